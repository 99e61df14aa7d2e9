//! Gets on where no flip does: facets that are not Delaunay, none of which can be flipped.
//!
//! There are such knots of a few vertices, among seeds of flat faces most of all: each flip waits for the others. So a vertex
//! of the knot is taken out, if its neighbours by themselves have all the facets around the hole; if those of none do, one
//! is led aside, to the middle of its neighbours. What is left is flipped, and if all is Delaunay then, these vertices are
//! put in where they belong.

use std::cmp::Reverse;

use glam::DVec3;

use super::facet::INFINITE;
use super::flip::Mesh;
use super::range::flush;
use super::region::Region;
use super::relocate::Relocation;
use super::repair::{GivenUp, Lists};

/// So many vertices are taken out at most.
const MOST: usize = 32;

impl Mesh {
    /// Makes Delaunay what is stuck, if anything is.
    pub fn unstick(&mut self, lists: &mut Lists, report: &mut Relocation) -> Result<(), GivenUp> {
        let mut region = Region::default();
        // Where those belong that are out or aside.
        let mut homes: Vec<(u32, DVec3)> = Vec::new();
        let mut out = 0;
        while self.is_stuck(lists) {
            if homes.len() == MOST {
                return Err(GivenUp);
            }
            let knot = self.knot(lists);
            if let Some(&v) = knot.iter().find(|&&v| self.remove_vertex(v, &mut region).is_ok()) {
                let home = match homes[out..].iter().position(|home| home.0 == v) {
                    Some(i) => homes.remove(out + i),
                    None => (v, self.at(v)),
                };
                homes.insert(out, home);
                out += 1;
                region.ids.iter().for_each(|&t| lists.push(t));
            } else {
                let is_aside = |v: u32| homes.iter().any(|home| home.0 == v);
                let v = knot.into_iter().find(|&v| !is_aside(v)).ok_or(GivenUp)?;
                homes.push((v, self.at(v)));
                self.star_of(v, &mut region);
                let corners = region.old.iter().flat_map(|&t| self.vertices[t as usize]).filter(|&w| w != INFINITE);
                let (sum, count) = corners.fold((DVec3::ZERO, 0.0), |(sum, n), w| (sum + self.at(w), n + 1.0));
                report.predicates += self.advance(v, (sum / count).map(flush), &region.old).0;
                region.old.iter().for_each(|&t| lists.push(t));
            }
            self.flip_all(lists, report)?;
        }
        for &(v, _) in &homes[out..] {
            self.remove_vertex(v, &mut region).map_err(|_| GivenUp)?;
        }
        for (v, home) in homes {
            let near = self.any_tet().ok_or(GivenUp)?;
            self.points[v as usize] = home;
            self.insert_vertex(v, near, &mut region).map_err(|_| GivenUp)?;
        }
        Ok(())
    }

    /// Vertices of tets that are stuck, those of most of them first.
    fn knot(&self, lists: &Lists) -> Vec<u32> {
        let is_stuck = |&t: &u32| !self.is_dead(t) && (0..4).any(|i| self.violates(t, i));
        let tets = lists.stuck().iter().copied().filter(is_stuck);
        let mut vertices: Vec<u32> = tets.flat_map(|t| self.vertices[t as usize]).filter(|&v| v != INFINITE).collect();
        vertices.sort_unstable();
        let mut counted: Vec<(usize, u32)> = vertices.chunk_by(u32::eq).map(|same| (same.len(), same[0])).collect();
        counted.sort_unstable_by_key(|&(count, v)| (Reverse(count), v));
        counted.into_iter().map(|(_, v)| v).collect()
    }

    /// A tet that there is.
    pub fn any_tet(&self) -> Option<u32> {
        (0..self.vertices.len() as u32).find(|&t| !self.is_dead(t))
    }
}
