//! Vertices that go far while the others go little: they leap.
//!
//! To lead one of them through all that lies on its way takes many flips. In place of that it is taken out where it was
//! (`remove_vertex.rs`), before the others move, and put in where it goes (`insert_vertex.rs`) once these have been followed: at
//! a cost that does not depend on how far that is.
//!
//! 1. Candidates are the vertices that go much farther than most. Of these, such leap as leave their neighbours behind.
//! 2. Where that is too many, building anew is faster, which other tests find out.

use glam::DVec3;

use super::facet::INFINITE;
use super::flip::Mesh;
use super::region::Region;
use super::repair::GivenUp;
use crate::geometry::hilbert::hilbert_order;

/// A candidate goes so many times as far as the median, in squares.
const MUCH_FARTHER2: f32 = 64.0;

/// Who leaps goes so many times as far as to the nearest neighbour, in squares.
const BEYOND2: f64 = 2.0;

/// Who goes less than this, as measured by the neighbours in one tet, which may be far, does not leap, in squares.
const MAYBE2: f64 = 1e-2;

/// The median is that of so many vertices.
const SAMPLE: usize = 255;

/// With more than one in so many vertices that leap, building anew is faster.
const VERTICES_PER_LEAP: usize = 32;

/// But so many leap in any case.
const FEW: usize = 8;

/// The vertices that leap in a motion.
#[derive(Clone, Default)]
pub struct Leaps {
    /// Ascending.
    vertices: Vec<u32>,
    region: Region,
    sample: Vec<f32>,
    /// Tets made by taking out and putting in.
    made: usize,
}

impl Mesh {
    /// A tet that there is.
    fn any_tet(&self) -> Option<u32> {
        (0..self.vertices.len() as u32).find(|&t| !self.is_dead(t))
    }
}

impl Leaps {
    /// 1. Finds the candidates, given the squared length of the step of each vertex.
    pub fn find(&mut self, steps2: &[f32]) {
        self.made = 0;
        self.vertices.clear();
        self.sample.clear();
        self.sample.extend(steps2.iter().step_by(steps2.len() / SAMPLE + 1));
        if self.sample.is_empty() {
            return;
        }
        let middle = self.sample.len() / 2;
        let limit = *self.sample.select_nth_unstable_by(middle, f32::total_cmp).1 * MUCH_FARTHER2;
        self.vertices.extend((0..).zip(steps2).filter(|(_, step2)| **step2 > limit).map(|(v, _)| v));
    }

    /// Keeps the candidates that leap: those that go well beyond a neighbour. None if that is too many.
    pub fn keep_far(&mut self, mesh: &Mesh, old: &[DVec3], steps2: &[f32]) {
        let nearest2 = |v: u32, tets: &[u32]| {
            let corners = tets.iter().flat_map(|&t| mesh.vertices[t as usize]);
            let others = corners.filter(|&w| w != INFINITE && w != v).map(|w| old[w as usize]);
            others.map(|p| p.distance_squared(old[v as usize])).fold(f64::INFINITY, f64::min)
        };
        let mut star = Vec::new();
        self.vertices.retain(|&v| {
            let step2 = f64::from(steps2[v as usize]);
            // Most are far from it, and one of their tets tells.
            if step2 < MAYBE2 * nearest2(v, &[mesh.incident[v as usize]]) {
                return false;
            }
            mesh.star(v, &mut star);
            step2 > BEYOND2 * nearest2(v, &star)
        });
        if self.vertices.len() > FEW + old.len() / VERTICES_PER_LEAP {
            self.vertices.clear();
        }
    }

    /// The longest step of the vertices that do not leap; those that do have none from here on.
    pub fn others_longest(&self, steps2: &mut [f32]) -> f64 {
        /// Room for rounding.
        const LONG: f64 = 1.0 + 1e-6;
        self.vertices.iter().for_each(|&v| steps2[v as usize] = 0.0);
        f64::from(steps2.iter().copied().fold(0.0, f32::max)).sqrt() * LONG
    }

    /// Takes the vertices that leap out of the triangulation of `old`. The others are then at `new`, as before.
    pub fn take_out(&mut self, mesh: &mut Mesh, old: &[DVec3], new: &[DVec3]) -> Result<(), GivenUp> {
        if self.vertices.is_empty() {
            return Ok(());
        }
        mesh.points.copy_from_slice(old);
        for &v in &self.vertices {
            mesh.remove_vertex(v, &mut self.region).map_err(|_| GivenUp)?;
            if self.region.old.iter().chain(&self.region.ids).any(|&t| mesh.vertices[t as usize][3] == INFINITE) {
                // The hull may have come nearer.
                mesh.room = 0.0;
            }
            self.made += self.region.ids.len();
        }
        mesh.points.copy_from_slice(new);
        Ok(())
    }

    /// Puts them in where they are now.
    pub fn put_in(&mut self, mesh: &mut Mesh) -> Result<(), GivenUp> {
        let goals: Vec<DVec3> = self.vertices.iter().map(|&v| mesh.at(v)).collect();
        let mut near = mesh.any_tet().ok_or(GivenUp)?;
        for i in hilbert_order(&goals) {
            // Where another vertex is already there is no triangulation.
            mesh.insert_vertex(self.vertices[i as usize], near, &mut self.region).map_err(|_| GivenUp)?;
            near = self.region.ids[0];
            self.made += self.region.ids.len();
        }
        Ok(())
    }

    /// Whether a vertex leaps.
    pub fn contains(&self, v: u32) -> bool {
        self.vertices.binary_search(&v).is_ok()
    }

    /// Whether none leaps.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// How many leap.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Tets made by it.
    pub fn made(&self) -> usize {
        self.made
    }
}
