//! Takes one vertex out of a finished triangulation, and fills the hole.
//!
//! O. Devillers, M. Teillaud, *Perturbations and vertex removal in a 3D Delaunay triangulation*, Proc. 14th ACM-SIAM
//! Symposium on Discrete Algorithms (SODA), 2003, pp. 313-319.
//!
//! 1. The hole is the star of the vertex, infinite tets included; its link are the facets around the hole.
//! 2. Triangulate the vertices of the link on their own. Each facet of the link, and each tet that belongs into the hole,
//!    has an empty sphere among all points that are left, and so among these few: they are all there.
//! 3. From the facets of the link, spread over the tets on the side of the hole, as far as the next facets of the link.
//! 4. Put these tets into the hole.
//!
//! The perturbation depends on positions alone, so ties among the few points are broken as among all. On the hull the link
//! may lie in a plane: what is left of the hole is then infinite, and each finite facet of the link carries an infinite tet.
//!
//! Cost: what it takes to triangulate the link's vertices, about 16; nothing depends on the number of points.

use super::facet::{INFINITE, OTHERS};
use super::flip::Mesh;
use super::insert::Construction;
use super::region::Region;

/// Why a vertex could not be taken out: nothing has changed.
#[derive(Debug)]
pub enum Kept {
    /// All other points lie on a plane.
    AllFlat,
    /// The triangulation is not Delaunay here, and the link's vertices on their own do not have its facets.
    Torn,
}

/// A facet as three numbers, turned so that the least comes first: which side is meant is told by the order.
type Turn = [u32; 3];

impl Mesh {
    /// Makes vertex `v` no part of the triangulation any more. The tets that fill its hole are then `region.ids`.
    pub fn remove_vertex(&mut self, v: u32, region: &mut Region) -> Result<(), Kept> {
        // 1. The star, and its link.
        self.star_of(v, region);
        let mut link = Vec::with_capacity(region.old.len());
        let mut around = Vec::with_capacity(3 * region.old.len());
        for &t in &region.old {
            let tet = self.vertices[t as usize];
            let slot = slot_of(tet, v);
            link.push(facet(tet, slot));
            around.extend(tet.into_iter().filter(|&w| w != v && w != INFINITE));
        }
        around.sort_unstable();
        around.dedup();
        // 2. Its vertices on their own.
        region.new.clear();
        match Construction::of(around.iter().map(|&w| self.at(w))) {
            Ok(few) => fill(&few, &around, link, &mut region.new)?,
            Err(_) => self.close_flat(v, region)?,
        }
        // 4. Into the hole.
        self.replace_region(region);
        Ok(())
    }

    /// Marks and lists the tets at `v`.
    pub fn star_of(&self, v: u32, region: &mut Region) {
        self.spread(self.incident[v as usize], region, |t, slot, _| self.vertices[t as usize][slot] != v);
    }

    /// Fills the hole of a vertex whose link lies in a plane, with infinite tets.
    fn close_flat(&self, v: u32, region: &mut Region) -> Result<(), Kept> {
        for &t in &region.old {
            let mut tet = self.vertices[t as usize];
            if tet[3] == INFINITE {
                continue;
            }
            let slot = slot_of(tet, v);
            if self.opposite[t as usize][slot] == INFINITE {
                return Err(Kept::AllFlat);
            }
            tet[slot] = INFINITE;
            region.new.push(tet);
        }
        Ok(())
    }
}

/// 3. The tets among the few points that are on the side of the hole, with the numbers that their vertices have here.
fn fill(few: &Construction, around: &[u32], mut link: Vec<Turn>, new: &mut Vec<[u32; 4]>) -> Result<(), Kept> {
    let here = |w: u32| around.get(w as usize).copied().unwrap_or(INFINITE);
    link.sort_unstable();
    let mut inside = vec![false; few.tets.len()];
    let mut stack = Vec::with_capacity(link.len());
    // Facets of the link, seen from the hole.
    let mut closed = vec![[false; 4]; few.tets.len()];
    let mut found = 0;
    for (t, tet) in few.tets.iter().enumerate().filter(|(_, tet)| !tet.is_dead()) {
        let vertices = tet.vertices.map(here);
        for (i, closed) in closed[t].iter_mut().enumerate() {
            if link.binary_search(&facet(vertices, i)).is_ok() {
                *closed = true;
                found += 1;
                if !std::mem::replace(&mut inside[t], true) {
                    stack.push(t);
                }
            }
        }
    }
    if found != link.len() {
        return Err(Kept::Torn);
    }
    while let Some(t) = stack.pop() {
        new.push(few.tets[t].vertices.map(here));
        for (mirror, closed) in few.tets[t].mirrors.iter().zip(closed[t]) {
            let next = mirror.tet() as usize;
            if !closed && !std::mem::replace(&mut inside[next], true) {
                stack.push(next);
            }
        }
    }
    Ok(())
}

/// Facet `i` of a tet as seen from its vertex `i`.
fn facet(tet: [u32; 4], i: usize) -> Turn {
    let (j, k, l) = OTHERS[i][0];
    let [a, b, c] = [tet[j], tet[k], tet[l]];
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Where vertex `v` is in a tet.
pub fn slot_of(tet: [u32; 4], v: u32) -> usize {
    tet.iter().position(|&w| w == v).expect("the tet is in the star of the vertex: this is a bug in tetcvt")
}
