//! Which seed owns each vertex of the surface.

use glam::DVec3;
use rayon::prelude::*;

use super::SEEDS;
use super::groups::Groups;
use super::planes::Planes;
use super::polygon::owner;
use crate::delaunay::Adjacency;

/// Vertices in a block of the first search.
const BLOCK: usize = 1024;

/// The nearest seed of every vertex, and the vertices by seed.
#[derive(Default)]
pub(super) struct Owners {
    of: Vec<u32>,
    /// Vertices by owner, ascending for each.
    vertices: Groups<u32>,
}

impl Owners {
    /// The seed nearest to each vertex.
    pub(super) fn of(&self) -> &[u32] {
        &self.of
    }

    /// Follows the seeds, `points`, to where they are now, for vertices `at` their places; owners of the last time are the first
    /// guess.
    pub(super) fn update(&mut self, at: &[DVec3], points: &[DVec3], adjacency: &Adjacency, arch: pulp::Arch) {
        if self.of.len() == at.len() && self.vertices.count() == Some(points.len()) {
            let changes = self.verify(at, points, adjacency, arch);
            if changes.is_empty() {
                return;
            }
            changes.into_iter().for_each(|(v, i)| self.of[v as usize] = i);
        } else {
            self.search(at, points, adjacency);
        }
        self.vertices.set(points.len(), std::iter::once(self.of.iter().enumerate().map(|(v, &i)| (i, v as u32))));
    }

    /// The vertices that have another owner than before.
    fn verify(&self, at: &[DVec3], points: &[DVec3], adjacency: &Adjacency, arch: pulp::Arch) -> Vec<(u32, u32)> {
        let parts: Vec<Vec<(u32, u32)>> = (0..points.len().div_ceil(SEEDS))
            .into_par_iter()
            .map_init(Planes::default, |planes, block| {
                let mut changes = Vec::new();
                for i in block * SEEDS..((block + 1) * SEEDS).min(points.len()) {
                    let own = self.vertices.of(i as u32);
                    if own.is_empty() {
                        continue;
                    }
                    planes.set(arch, points[i], adjacency.of(i), points, own.iter().map(|&v| at[v as usize]));
                    for (_, &v) in own.iter().enumerate().filter(|&(n, _)| planes.is_doubtful(n)) {
                        let now = owner(at[v as usize], i as u32, adjacency, points);
                        if now != i as u32 {
                            changes.push((v, now));
                        }
                    }
                }
                changes
            })
            .collect();
        parts.concat()
    }

    /// Finds all owners, with little to start from.
    fn search(&mut self, at: &[DVec3], points: &[DVec3], adjacency: &Adjacency) {
        self.of.resize(at.len(), u32::MAX);
        self.of.par_chunks_mut(BLOCK).zip(at.par_chunks(BLOCK)).for_each(|(owners, at)| {
            let mut last = 0;
            for (mine, &p) in owners.iter_mut().zip(at) {
                let guess = if (*mine as usize) < points.len() { *mine } else { last };
                *mine = owner(p, guess, adjacency, points);
                last = *mine;
            }
        });
    }
}
