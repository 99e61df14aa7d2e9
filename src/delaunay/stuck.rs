//! Gets on where no flip does: facets that are not Delaunay, none of which can be flipped.
//!
//! There are such knots of a few vertices, among seeds of flat faces most of all: each flip waits for the others. So what is
//! around such a facet is made anew:
//!
//! 1. The region is the facet's two tets, at first.
//! 2. Triangulate its vertices on their own (`hole.rs`). Facets around the region that these few do not have are not
//!    Delaunay: the region takes in the tets beyond them, and this is done again. Where all that is not Delaunay is inside,
//!    all facets around it are had.
//! 3. Put what is between them in place of the region, if all of it is positive, infinite tets as seen from the point
//!    inside: while the hull is not yet one, it need not be. Flip on from there.
//!
//! The new tets are the lowest on the lifted surface, and the old ones were not: so this comes to an end, as flips do.

use super::facet::INFINITE;
use super::flip::Mesh;
use super::hole::{Hole, Turn, facet};
use super::insert::Construction;
use super::region::Region;
use super::relocate::Relocation;
use super::repair::{GivenUp, Lists};
use crate::geometry::predicates::Sign;

/// With a region of more than one in so many tets, building anew is faster.
const TETS_OF_ALL: usize = 16;

/// Regions of so many tets are made anew in any case.
const FEW: usize = 2000;

impl Mesh {
    /// Makes Delaunay what is stuck, if anything is.
    pub fn unstick(&mut self, lists: &mut Lists, report: &mut Relocation) -> Result<(), GivenUp> {
        let mut region = Region::default();
        while let Some((t, i)) = self.first_stuck(lists) {
            self.renew_around(t, i, &mut region)?;
            region.ids.iter().for_each(|&t| lists.push(t));
            self.flip_all(lists, report)?;
        }
        Ok(())
    }

    /// A facet that could not be flipped.
    fn first_stuck(&self, lists: &Lists) -> Option<(u32, usize)> {
        let alive = lists.stuck().iter().copied().filter(|&t| !self.is_dead(t));
        alive.flat_map(|t| (0..4).map(move |i| (t, i))).find(|&(t, i)| self.violates(t, i))
    }

    /// Makes anew the tets around facet `i` of tet `t`, as far as it takes. The new ones are then `region.ids`.
    fn renew_around(&mut self, t: u32, i: usize, region: &mut Region) -> Result<(), GivenUp> {
        let other = self.neighbors[t as usize][i].tet();
        self.spread(t, region, |_, _, next| next == other);
        let mut hole = Hole::default();
        // Each facet around the region, and the tet beyond it.
        let mut around: Vec<(Turn, u32)> = Vec::new();
        loop {
            if region.old.len() > FEW + self.vertices.len() / TETS_OF_ALL {
                return Err(GivenUp);
            }
            around.clear();
            hole.vertices.clear();
            for &t in &region.old {
                let tet = self.vertices[t as usize];
                hole.vertices.extend(tet.into_iter().filter(|&v| v != INFINITE));
                let beyond = (0..4).map(|i| (facet(tet, i), self.neighbors[t as usize][i].tet()));
                around.extend(beyond.filter(|&(_, next)| !region.marks.contains(next)));
            }
            if around.is_empty() {
                // That is all there is.
                return Err(GivenUp);
            }
            around.sort_unstable();
            hole.walls.clear();
            hole.walls.extend(around.iter().map(|(wall, _)| *wall));
            hole.vertices.sort_unstable();
            hole.vertices.dedup();
            hole.found.clear();
            if let Ok(few) = Construction::of(hole.vertices.iter().map(|&v| self.at(v)))
                && hole.fill(&few, &mut region.new)
                && region.new.iter().all(|&tet| self.orientation(tet) == Sign::Positive)
            {
                self.replace_region(region);
                return Ok(());
            }
            // All of them where it is not known which.
            let all = !hole.found.contains(&false);
            for (n, &(_, next)) in around.iter().enumerate() {
                if (all || !hole.found[n]) && region.marks.insert(next) {
                    region.old.push(next);
                }
            }
        }
    }
}
