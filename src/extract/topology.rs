//! Which shell of the surface each component of the boundary stands for, and whether it has its topology.

use glam::DVec3;

use super::Sampling;
use super::boundary::{Boundary, regions, shell_euler};
use crate::geometry::triangle::centroid;
use crate::seeds::SeedKind;

/// Points of a component that are asked for the closest shell.
const VOTERS: usize = 48;

/// A component of the boundary beside the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Match {
    /// The shell that it is closest to, in most of its points.
    pub shell: u32,
    /// A point of it that is closest to another shell, with that shell.
    pub other: Option<(u32, DVec3)>,
    /// Its Euler characteristic.
    pub euler: i64,
    /// A vertex of it.
    pub vertex: u32,
}

/// The topology of a labelling beside the surface's.
pub struct Topology {
    /// The components of the boundary.
    pub components: Vec<Match>,
    /// The Euler characteristic of each shell.
    pub shells: Vec<i64>,
    /// Number of connected regions of the labelling.
    pub regions: usize,
    /// Number of solids that the surface bounds, by parity.
    pub solids: usize,
}

impl Topology {
    /// Compares the labels `inside`, with their boundary, to the surface.
    pub fn of(sampling: &Sampling, inside: &[bool], boundary: &Boundary) -> Topology {
        let mut members = vec![Vec::new(); boundary.components()];
        for (triangle, &c) in boundary.triangles.iter().zip(&boundary.component) {
            members[c as usize].push(*triangle);
        }
        let components = members.iter().zip(&boundary.euler).map(|(m, &euler)| vote(sampling, m, euler)).collect();
        let shells = 0..sampling.surface.shell_count() as u32;
        let solids = shells.map(|s| sampling.surface.solid_of_shell(s)).max().map_or(0, |s| s as usize + 1);
        Topology {
            components,
            shells: shell_euler(sampling.surface),
            regions: regions(&sampling.complex, inside).1,
            solids,
        }
    }

    /// The components that stand for `shell`.
    pub fn of_shell(&self, shell: u32) -> impl Iterator<Item = &Match> {
        self.components.iter().filter(move |c| c.shell == shell)
    }

    /// How far the topology is from the surface's; 0 = the same.
    pub fn mismatch(&self) -> u64 {
        let shells: u64 = (0..self.shells.len() as u32)
            .map(|s| {
                let count = self.of_shell(s).count() as u64;
                let euler: i64 = self.of_shell(s).map(|c| c.euler).sum();
                // What has come off another is a sphere of its own: it hides no handle of that.
                let of_one = euler - 2 * (count as i64 - 1);
                2 * count.abs_diff(1) + of_one.abs_diff(self.shells[s as usize])
            })
            .sum();
        let bridges = self.components.iter().filter(|c| c.other.is_some()).count() as u64;
        shells + bridges + self.regions.abs_diff(self.solids) as u64
    }
}

/// Lets points of a component say which shell is closest.
fn vote(sampling: &Sampling, triangles: &[[u32; 3]], euler: i64) -> Match {
    let surface = sampling.surface;
    let step = triangles.len().div_ceil(VOTERS).max(1);
    let votes: Vec<(u32, DVec3)> = triangles
        .iter()
        .step_by(step)
        .map(|triangle| {
            // A vertex on the surface lies on its shell; anything else may be closer to another one.
            let bound = triangle.iter().find(|&&v| sampling.kinds[v as usize] != SeedKind::Interior);
            let p = match bound {
                Some(&v) => sampling.complex.points[v as usize],
                None => {
                    let [a, b, c] = triangle.map(|v| sampling.complex.points[v as usize]);
                    centroid(a, b, c)
                }
            };
            (surface.shell()[surface.tree().closest(p).triangle as usize], p)
        })
        .collect();
    let mut sorted: Vec<u32> = votes.iter().map(|&(s, _)| s).collect();
    sorted.sort_unstable();
    let shell = sorted
        .chunk_by(|a, b| a == b)
        .max_by_key(|same| (same.len(), std::cmp::Reverse(same[0])))
        .map_or(0, |same| same[0]);
    let other = votes.into_iter().find(|&(s, _)| s != shell);
    Match { shell, other, euler, vertex: triangles[0][0] }
}
