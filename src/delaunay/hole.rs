//! The tets that belong into a hole: those of the triangulation of its vertices alone, on the inner side of its walls.
//!
//! A wall is a facet around the hole. One that is a facet of the whole Delaunay triangulation has an empty sphere among all
//! points, and so among these few: if all are, the few have them all, and what is between them has empty spheres too. The
//! perturbation depends on positions alone, so ties among the few points are broken as among all.

use super::facet::{INFINITE, OTHERS};
use super::insert::Construction;
use crate::geometry::triangle::from_least;

/// A facet as three numbers, turned so that the least comes first: which side is meant is told by the order.
pub type Turn = [u32; 3];

/// A hole.
#[derive(Clone, Default)]
pub struct Hole {
    /// Its walls as seen from inside, ascending.
    pub walls: Vec<Turn>,
    /// The vertices of the walls and between them, ascending; not the infinite one.
    pub vertices: Vec<u32>,
    /// For each wall, whether the few points have it.
    pub found: Vec<bool>,
}

impl Hole {
    /// Leaves the tets that fill the hole in `new`, given the triangulation of its vertices. If that does not have all the
    /// walls, as `found` tells, or they do not part an inner side from an outer one, it says no.
    pub fn fill(&mut self, few: &Construction, new: &mut Vec<[u32; 4]>) -> bool {
        let Hole { walls, vertices, found } = self;
        let here = |w: u32| vertices.get(w as usize).copied().unwrap_or(INFINITE);
        let mut inside = vec![false; few.tets.len()];
        let mut stack = Vec::with_capacity(walls.len());
        // Walls, seen from the hole.
        let mut closed = vec![[false; 4]; few.tets.len()];
        found.clear();
        found.resize(walls.len(), false);
        for (t, tet) in few.tets.iter().enumerate().filter(|(_, tet)| !tet.is_dead()) {
            let vertices = tet.vertices.map(here);
            for (i, closed) in closed[t].iter_mut().enumerate() {
                if let Ok(wall) = walls.binary_search(&facet(vertices, i)) {
                    (*closed, found[wall]) = (true, true);
                    if !std::mem::replace(&mut inside[t], true) {
                        stack.push(t);
                    }
                }
            }
        }
        if found.contains(&false) {
            return false;
        }
        new.clear();
        while let Some(t) = stack.pop() {
            new.push(few.tets[t].vertices.map(here));
            for (mirror, closed) in few.tets[t].mirrors.iter().zip(closed[t]) {
                let next = mirror.tet() as usize;
                if !closed && !std::mem::replace(&mut inside[next], true) {
                    stack.push(next);
                }
            }
        }
        let beyond = |(tet, closed): (&super::tets::Tet, &[bool; 4])| {
            tet.mirrors.iter().zip(closed).any(|(mirror, closed)| *closed && inside[mirror.tet() as usize])
        };
        !few.tets.iter().zip(&closed).any(beyond)
    }
}

/// Facet `i` of a tet as seen from its vertex `i`.
pub fn facet(tet: [u32; 4], i: usize) -> Turn {
    let (j, k, l) = OTHERS[i][0];
    from_least([tet[j], tet[k], tet[l]])
}
