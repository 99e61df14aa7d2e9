//! Which circumcentres are inside.
//!
//! No ray is cast: all is outside at infinity, and along every Voronoi edge the crossings say what changes. The circumcentres
//! around a seed none of whose Voronoi edges crosses the surface are all on one side; which, is taken over from the last
//! time. That all ways agree is verified, and as they connect all tets with infinity, no more is to be known: where seeds are
//! taken for known, all of a tet's must agree, and elsewhere both ends of every Voronoi edge.

use rayon::prelude::*;

use super::crossings::{Crossings, FACET, entered};
use crate::delaunay::Delaunay;

/// Tets that one thread looks at in a row.
const BLOCK: usize = 4096;

/// So many times tets are looked at one by one, in their order, before one leads to the next.
const LOOKS: usize = 3;

/// Not known.
const UNKNOWN: i32 = i32::MIN;

/// For each tet, how many shells of those that the crossings are of hold its circumcentre, outward ones counted 1 and inward
/// ones -1: 1 behind these shells and 0 in front.
#[derive(Default)]
pub(super) struct Winding {
    pub(super) of_tets: Vec<i32>,
    /// For each tet, a bit for each of its facets whose dual edge crosses these shells.
    pub(super) marks: Vec<u8>,
    /// The tets that have such facets, in their order.
    pub(super) crossed: Vec<Crossed>,
    /// For each seed that no crossing touches, the winding around it.
    of_seeds: Vec<i32>,
}

/// A tet with facets whose dual edges cross the shells.
#[derive(Clone, Copy)]
pub(super) struct Crossed {
    pub(super) tet: u32,
    /// For each facet that does, where its crossings begin.
    pub(super) first: [Option<u32>; 4],
}

/// A tet of which fewer than two corners are known.
struct Open {
    tet: u32,
    /// What the winding changes by from the tet across each facet to this one.
    entered: [i32; 4],
}

/// Ways to the same circumcentre disagree.
struct NotClosed;

impl Winding {
    /// Follows the crossings to what they are now.
    ///
    /// # Panics
    /// If they are not those of closed shells.
    pub(super) fn update(&mut self, delaunay: &Delaunay, crossings: &Crossings) {
        let agreed = self.follow(delaunay, crossings).is_ok() || {
            // A cell with no crossing went from one side of the surface to the other.
            self.of_seeds.clear();
            self.follow(delaunay, crossings).is_ok()
        };
        assert!(agreed, "a closed surface changes sides an even number of times: this is a bug in tetcvt");
    }

    fn follow(&mut self, delaunay: &Delaunay, crossings: &Crossings) -> Result<(), NotClosed> {
        let (vertices, seeds) = (delaunay.vertices(), delaunay.points().len());
        if self.of_seeds.len() != seeds {
            self.of_seeds.clear();
            self.of_seeds.resize(seeds, UNKNOWN);
        }
        for (v, known) in (0..).zip(&mut self.of_seeds) {
            if crossings.touches(v) {
                *known = UNKNOWN;
            }
        }
        // 1. Tets with an infinite vertex, or with one that is known.
        let open = self.begin(delaunay, crossings)?;
        // 2. The others, across their facets: most have a tet beside them that is known.
        let mut unknown: Vec<&Open> = open.iter().filter(|o| self.of_tets[o.tet as usize] == UNKNOWN).collect();
        let found = unknown.iter().map(|o| o.tet).collect::<Vec<u32>>();
        for _ in 0..LOOKS {
            unknown.retain(|o| !self.look_beside(delaunay, o));
        }
        self.spread(delaunay, crossings, &unknown.iter().map(|o| o.tet).collect::<Vec<u32>>());
        for t in found {
            for v in vertices[t as usize] {
                if !crossings.touches(v) {
                    self.of_seeds[v as usize] = self.of_tets[t as usize];
                }
            }
        }
        // 3. Facets without a corner that was known.
        let agrees = |&Open { tet, entered }: &Open| {
            let beyond = delaunay.neighbors()[tet as usize].map(|n| self.of_tets[n.tet() as usize]);
            (0..4).all(|f| beyond[f] + entered[f] == self.of_tets[tet as usize])
        };
        if open.par_iter().with_min_len(BLOCK).all(agrees) { Ok(()) } else { Err(NotClosed) }
    }

    /// Finds the windings of tets with a corner that is known, and the marks; those with at most one such.
    fn begin(&mut self, delaunay: &Delaunay, crossings: &Crossings) -> Result<Vec<Open>, NotClosed> {
        let vertices = delaunay.vertices();
        let of_seeds = &self.of_seeds;
        self.of_tets.resize(vertices.len(), UNKNOWN);
        self.marks.clear();
        self.marks.resize(vertices.len(), 0);
        let blocks = self.of_tets.par_chunks_mut(BLOCK).zip(self.marks.par_chunks_mut(BLOCK));
        let parts: Vec<(Vec<Open>, Vec<Crossed>)> = blocks
            .zip(vertices.par_chunks(BLOCK))
            .enumerate()
            .map(|(block, ((windings, marks), tets))| {
                let (mut open, mut crossed) = (Vec::new(), Vec::new());
                let mut agreed = true;
                for (k, tet) in tets.iter().enumerate() {
                    // All is outside around the infinite vertex.
                    let known = tet.map(|v| of_seeds.get(v as usize).copied().unwrap_or(0));
                    // Windings are far above UNKNOWN.
                    let winding = known.into_iter().fold(UNKNOWN, i32::max);
                    windings[k] = winding;
                    agreed &= known.iter().fold(true, |all, &w| all & ((w == winding) | (w == UNKNOWN)));
                    if known.iter().map(|&w| u32::from(w == UNKNOWN)).sum::<u32>() >= 3 {
                        let (id, first) = ((block * BLOCK + k) as u32, crossings.of_tet(tet));
                        let entered = [0, 1, 2, 3].map(|f| {
                            first[f].map_or(0, |first| entered(crossings.from(first, FACET[f].map(|v| tet[v]))))
                        });
                        open.push(Open { tet: id, entered });
                        if first != [None; 4] {
                            marks[k] = (0..4).fold(0, |marks, f| marks | u8::from(first[f].is_some()) << f);
                            crossed.push(Crossed { tet: id, first });
                        }
                    }
                }
                if agreed { Ok((open, crossed)) } else { Err(NotClosed) }
            })
            .collect::<Result<_, NotClosed>>()?;
        let (open, crossed): (Vec<Vec<Open>>, Vec<Vec<Crossed>>) = parts.into_iter().unzip();
        self.crossed = crossed.concat();
        Ok(open.into_iter().flatten().collect())
    }

    /// Finds the winding of a tet from one beside it, if that of any is known; whether it is.
    fn look_beside(&mut self, delaunay: &Delaunay, open: &Open) -> bool {
        let beyond = delaunay.neighbors()[open.tet as usize].map(|n| self.of_tets[n.tet() as usize]);
        let Some(f) = (0..4).find(|&f| beyond[f] != UNKNOWN) else { return false };
        self.of_tets[open.tet as usize] = beyond[f] + open.entered[f];
        true
    }

    /// Finds the windings of `unknown` tets from those next to them.
    fn spread(&mut self, delaunay: &Delaunay, crossings: &Crossings, unknown: &[u32]) {
        let (vertices, neighbors) = (delaunay.vertices(), delaunay.neighbors());
        let (winding, marks) = (&mut self.of_tets, &self.marks);
        // The winding of the tet across facet f of tet t, and of t from that.
        let entered_by = |t: u32, f: usize| {
            let crossed = marks[t as usize] >> f & 1 == 1;
            if crossed { crossings.entered(FACET[f].map(|v| vertices[t as usize][v])) } else { 0 }
        };
        let mut stack: Vec<u32> = Vec::new();
        for &start in unknown {
            if winding[start as usize] != UNKNOWN {
                continue;
            }
            let mut sources = (0..4).map(|f| (f, winding[neighbors[start as usize][f].tet() as usize]));
            let Some((f, beyond)) = sources.find(|s| s.1 != UNKNOWN) else { continue };
            // From the neighbour to t the dual edge runs along (q - p) x (r - p).
            winding[start as usize] = beyond + entered_by(start, f);
            stack.push(start);
            while let Some(t) = stack.pop() {
                for (f, facet) in neighbors[t as usize].iter().enumerate() {
                    let n = facet.tet();
                    if winding[n as usize] == UNKNOWN {
                        winding[n as usize] = winding[t as usize] - entered_by(t, f);
                        stack.push(n);
                    }
                }
            }
        }
    }
}
