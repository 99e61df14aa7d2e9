//! Inserts one vertex into a finished triangulation: walk, carve, fill.
//!
//! Bowyer 1981 and Watson 1981, as in `insert.rs`, on the arrays of the finished triangulation.
//!
//! 1. Walk from a tet nearby to the tet that holds the point, or to an infinite one whose facet it is beyond (Devillers,
//!    Pion, Teillaud 2002, as in `locate.rs`): in conflict either way.
//! 2. Carve: spread from there over all tets in conflict.
//! 3. Fill: the new vertex in the place of the one that each facet around the zone had on the zone's side.
//!
//! Cost: the walk, and what the conflict zone takes; nothing depends on the number of points.

use super::facet::INFINITE;
use super::flip::Mesh;
use super::region::Region;
use crate::geometry::predicates::{Sign, orient3d};

impl Mesh {
    /// Makes vertex `v`, whose position is set, part of the triangulation; the walk begins at tet `from`. Its new tets are
    /// then `region.ids`. If another vertex is there already, nothing changes and that one is returned.
    pub fn insert_vertex(&mut self, v: u32, from: u32, region: &mut Region) -> Result<(), u32> {
        let start = self.walk(v, from)?;
        let p = self.at(v);
        self.spread(start, region, |_, _, next| self.conflicts(next, p));
        region.new.clear();
        for &t in &region.old {
            for i in 0..4 {
                if !region.marks.contains(self.neighbors[t as usize][i].tet()) {
                    let mut tet = self.vertices[t as usize];
                    tet[i] = v;
                    region.new.push(tet);
                }
            }
        }
        self.replace_region(region);
        Ok(())
    }

    /// A tet in conflict with the position of `v`; or the vertex that is there.
    fn walk(&self, v: u32, from: u32) -> Result<u32, u32> {
        let p = self.at(v);
        let mut t =
            if self.vertices[from as usize][3] == INFINITE { self.neighbors[from as usize][3].tet() } else { from };
        let mut entered = 4;
        'walk: loop {
            let tet = self.vertices[t as usize];
            if tet[3] == INFINITE {
                return Ok(t);
            }
            let corners = tet.map(|w| self.at(w));
            for i in 0..4 {
                if i == entered {
                    continue;
                }
                let mut beyond = corners;
                beyond[i] = p;
                if orient3d(beyond[0], beyond[1], beyond[2], beyond[3]) == Sign::Negative {
                    let across = self.neighbors[t as usize][i];
                    (t, entered) = (across.tet(), across.slot());
                    continue 'walk;
                }
            }
            // The tet holds the point, and so does its sphere, unless the point is a corner.
            return match corners.iter().position(|&c| c == p) {
                Some(i) => Err(tet[i]),
                None => Ok(t),
            };
        }
    }
}
