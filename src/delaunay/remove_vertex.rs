//! Takes one vertex out of a finished triangulation, and fills the hole.
//!
//! O. Devillers, M. Teillaud, *Perturbations and vertex removal in a 3D Delaunay triangulation*, Proc. 14th ACM-SIAM
//! Symposium on Discrete Algorithms (SODA), 2003, pp. 313-319.
//!
//! 1. The hole is the star of the vertex, infinite tets included; its link are the facets around the hole.
//! 2. Triangulate the vertices of the link on their own.
//! 3. From the facets of the link, spread over the tets on the side of the hole, as far as the next facets of the link
//!    (`hole.rs`).
//! 4. Put these tets into the hole.
//!
//! On the hull the link may lie in a plane: what is left of the hole is then infinite, and each finite facet of the link carries an infinite tet.
//!
//! Cost: what it takes to triangulate the link's vertices, about 16; nothing depends on the number of points.

use super::facet::INFINITE;
use super::flip::Mesh;
use super::hole::{Hole, facet};
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

impl Mesh {
    /// Makes vertex `v` no part of the triangulation any more. The tets that fill its hole are then `region.ids`.
    pub fn remove_vertex(&mut self, v: u32, region: &mut Region) -> Result<(), Kept> {
        // 1. The star, and its link.
        self.star_of(v, region);
        let mut hole = Hole::default();
        for &t in &region.old {
            let tet = self.vertices[t as usize];
            hole.walls.push(facet(tet, slot_of(tet, v)));
            hole.vertices.extend(tet.into_iter().filter(|&w| w != v && w != INFINITE));
        }
        hole.walls.sort_unstable();
        hole.vertices.sort_unstable();
        hole.vertices.dedup();
        // 2. Its vertices on their own, and 3.
        match Construction::of(hole.vertices.iter().map(|&w| self.at(w))) {
            Ok(few) if hole.fill(&few, &mut region.new) => {}
            Ok(_) => return Err(Kept::Torn),
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
        region.new.clear();
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

/// Where vertex `v` is in a tet.
pub fn slot_of(tet: [u32; 4], v: u32) -> usize {
    tet.iter().position(|&w| w == v).expect("the tet is in the star of the vertex: this is a bug in tetcvt")
}
