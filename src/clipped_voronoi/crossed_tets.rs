//! Which tets have facets whose dual edges cross the surface.
//!
//! Late in a run nearly all of these facets are where they were the last time: there they are looked for first. Others are found
//! by their vertices.

use rayon::prelude::*;

use super::crossings::{CrossedFacet, Crossings, FACET, Finder, ascending, is_even};
use crate::delaunay::{Delaunay, Facet};

/// Tets that one thread looks at in a row.
const BLOCK: usize = 1024;

/// Where no crossings begin.
pub(super) const NOWHERE: u32 = u32::MAX;

/// The tets that have such facets.
#[derive(Default)]
pub(super) struct CrossedTets {
    /// For each tet, a bit for each of its facets that is one.
    pub(super) marks: Vec<u8>,
    /// Those that have any, in their order.
    pub(super) tets: Vec<Crossed>,
    /// For each tet that has any, its place among these.
    rank: Vec<u32>,
    /// Where facets were, ascending.
    known: Vec<([u32; 3], Facet)>,
}

/// A tet that has such facets.
#[derive(Clone, Copy)]
pub(super) struct Crossed {
    pub(super) tet: u32,
    /// For each of its facets, where the crossings begin; [`NOWHERE`] if there are none.
    pub(super) first: [u32; 4],
    /// For each, what the winding changes by from the tet across it to this one.
    entered: [i32; 4],
}

impl CrossedTets {
    /// Follows the crossings. The tets `candidates` are all that may have such a facet, and perhaps others.
    pub(super) fn follow(&mut self, delaunay: &Delaunay, crossings: &Crossings, candidates: &[u32]) {
        let facets = crossings.facets();
        let mut places = self.recall(delaunay, facets);
        find_others(delaunay, facets, candidates, &mut places);
        self.known.clear();
        self.known.extend(facets.iter().zip(&places).filter_map(|(facet, place)| Some((facet.vertices, (*place)?))));
        self.list(delaunay, facets, &places);
    }

    /// What the winding changes by from the tet across each facet of tet `t` to `t`.
    #[inline]
    pub(super) fn entered(&self, t: u32) -> [i32; 4] {
        if self.marks[t as usize] == 0 { [0; 4] } else { self.tets[self.rank[t as usize] as usize].entered }
    }

    /// The facets that are where they were the last time.
    fn recall(&self, delaunay: &Delaunay, facets: &[CrossedFacet]) -> Vec<Option<Facet>> {
        let is_at = |vertices: [u32; 3], place: Facet| {
            let tet = delaunay.vertices().get(place.tet() as usize);
            tet.is_some_and(|tet| ascending(FACET[place.slot()].map(|v| tet[v])) == vertices)
        };
        let mut known = self.known.iter().peekable();
        let recall = |facet: &CrossedFacet| {
            while known.next_if(|k| k.0 < facet.vertices).is_some() {}
            let &(vertices, place) = known.next_if(|k| k.0 == facet.vertices)?;
            is_at(vertices, place).then_some(place)
        };
        facets.iter().map(recall).collect()
    }

    /// Lists the tets on both sides of all facets.
    fn list(&mut self, delaunay: &Delaunay, facets: &[CrossedFacet], places: &[Option<Facet>]) {
        let neighbors = delaunay.neighbors();
        self.marks.clear();
        self.marks.resize(neighbors.len(), 0);
        let mut mark = |place: Facet| {
            let sides = [place, neighbors[place.tet() as usize][place.slot()]];
            sides.iter().for_each(|side| self.marks[side.tet() as usize] |= 1 << side.slot());
            sides
        };
        let sides: Vec<Option<[Facet; 2]>> = places.iter().map(|place| place.map(&mut mark)).collect();
        self.rank.resize(neighbors.len(), 0);
        self.tets.clear();
        for (tet, _) in (0..).zip(&self.marks).filter(|(_, marks)| **marks != 0) {
            self.rank[tet as usize] = self.tets.len() as u32;
            self.tets.push(Crossed { tet, first: [NOWHERE; 4], entered: [0; 4] });
        }
        for (facet, sides) in facets.iter().zip(sides) {
            let Some([place, other]) = sides else { continue };
            let tet = delaunay.vertices()[place.tet() as usize];
            let is_even = is_even(FACET[place.slot()].map(|v| tet[v]));
            let entered = if is_even { facet.entered } else { -facet.entered };
            for (side, entered) in [(place, entered), (other, -entered)] {
                let crossed = &mut self.tets[self.rank[side.tet() as usize] as usize];
                (crossed.first[side.slot()], crossed.entered[side.slot()]) = (facet.first, entered);
            }
        }
    }
}

/// Finds the places of the facets that have none yet among those of some tets.
fn find_others(delaunay: &Delaunay, facets: &[CrossedFacet], tets: &[u32], places: &mut [Option<Facet>]) {
    let wanted: Vec<u32> = (0..).zip(&*places).filter(|(_, place)| place.is_none()).map(|(n, _)| n).collect();
    if wanted.is_empty() {
        return;
    }
    let finder = Finder::new(facets, wanted.iter().copied());
    let mut touched = vec![false; delaunay.points().len()];
    wanted.iter().flat_map(|&n| facets[n as usize].vertices).for_each(|v| touched[v as usize] = true);
    let of_tet = |&t: &u32| {
        let tet = delaunay.vertices()[t as usize];
        let touched = tet.map(|v| touched.get(v as usize) == Some(&true));
        let finder = &finder;
        let facets = if touched.iter().map(|&t| u8::from(t)).sum::<u8>() < 3 { 0..0 } else { 0..4 };
        facets.filter(move |&f| FACET[f].iter().all(|&v| touched[v])).filter_map(move |f| {
            let n = finder.find(FACET[f].map(|v| tet[v]))?;
            Some((n, Facet::new(t, f)))
        })
    };
    let found: Vec<Vec<(u32, Facet)>> =
        tets.par_chunks(BLOCK).map(|tets| tets.iter().flat_map(of_tet).collect()).collect();
    found.into_iter().flatten().for_each(|(n, place)| places[n as usize] = Some(place));
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::clipped_voronoi::Crossing;
    use crate::geometry::frame::snap;
    use crate::rng::Rng;

    /// Crossings, one or two each, of the facets that `chosen` says of the triangulation, sorted.
    fn crossings(delaunay: &Delaunay, mut chosen: impl FnMut([u32; 3]) -> bool) -> Vec<Crossing> {
        let mut facets: Vec<[u32; 3]> =
            delaunay.tets().flat_map(|tet| FACET.map(|f| ascending(f.map(|v| tet[v])))).collect();
        facets.sort_unstable();
        facets.dedup();
        facets.retain(|&facet| chosen(facet));
        let crossing = |(facet, leaves)| Crossing { facet, point: DVec3::ZERO, triangle: 0, leaves };
        let of_facet = |facet: [u32; 3]| {
            let leaves = facet[0].is_multiple_of(2);
            let more = facet[2].is_multiple_of(5).then_some((facet, leaves));
            [(facet, leaves)].into_iter().chain(more)
        };
        facets.into_iter().flat_map(of_facet).map(crossing).collect()
    }

    #[test]
    fn what_is_followed_is_what_is_found_anew_and_both_sides_of_a_facet_agree() {
        let mut rng = Rng::new(21, 0);
        let mut points: Vec<DVec3> = (0..600).map(|_| snap(rng.in_cube())).collect();
        let mut delaunay = Delaunay::build(&points).expect("distinct points");
        let (mut followed, mut kept, mut all_facets) = (CrossedTets::default(), 0, 0);
        for round in 0..20 {
            let far = if round % 4 == 3 { 0.1 } else { 1e-3 };
            points.iter_mut().take(60).for_each(|p| *p = snap(*p + rng.in_cube() * far));
            delaunay.relocate(&points).expect("distinct points");
            // Mostly the same facets as the last time.
            let all = crossings(&delaunay, |[a, b, c]| (a + b + c) % 7 < 3 || rng.unit() < 0.02);
            let crossings = Crossings::new(&all, points.len());
            let candidates: Vec<u32> = (0..delaunay.vertices().len() as u32).collect();
            kept += followed.recall(&delaunay, crossings.facets()).iter().flatten().count();
            all_facets += crossings.facets().len();
            followed.follow(&delaunay, &crossings, &candidates);
            let mut anew = CrossedTets::default();
            anew.follow(&delaunay, &crossings, &candidates);
            assert_eq!(followed.marks, anew.marks);
            let mut sides = 0;
            for (a, b) in followed.tets.iter().zip(&anew.tets) {
                assert_eq!((a.tet, a.first, a.entered), (b.tet, b.first, b.entered));
                let tet = delaunay.vertices()[a.tet as usize];
                for f in (0..4).filter(|&f| a.first[f] != NOWHERE) {
                    sides += 1;
                    let (found, even) = crossings.from(a.first[f], FACET[f].map(|v| tet[v]));
                    assert_eq!(found[0].facet, ascending(FACET[f].map(|v| tet[v])));
                    let entered: i32 = found.iter().map(|c| if c.leaves == even { -1 } else { 1 }).sum();
                    assert_eq!(a.entered[f], entered);
                    let other = delaunay.neighbors()[a.tet as usize][f];
                    assert_eq!(followed.entered(other.tet())[other.slot()], -entered);
                }
            }
            assert_eq!(sides, 2 * crossings.facets().len(), "each facet is one of two tets");
        }
        assert!(kept > all_facets / 3, "{kept} of {all_facets} were where they had been");
    }
}
