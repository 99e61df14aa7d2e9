//! Which circumcentres are inside.
//!
//! No ray is cast: all is outside at infinity, and along every Voronoi edge the crossings say what changes. The circumcentres
//! around a seed none of whose Voronoi edges crosses the surface are all on one side; which, is taken over from the last
//! time. That all ways agree is verified, and as they connect all tets with infinity, no more is to be known: where seeds are
//! taken for known, all of a tet's must agree, and elsewhere both ends of every Voronoi edge.

use rayon::prelude::*;

use super::crossed_tets::CrossedTets;
use super::crossings::Crossings;
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
    /// The tets with facets whose dual edges cross these shells.
    pub(super) crossed: CrossedTets,
    /// For each seed that no crossing touches, the winding around it.
    of_seeds: Vec<i32>,
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
        let open = self.begin(vertices)?;
        self.crossed.follow(delaunay, crossings, &open);
        // 2. The others, across their facets: most have a tet beside them that is known.
        let mut unknown: Vec<u32> = open.iter().copied().filter(|&t| self.of_tets[t as usize] == UNKNOWN).collect();
        let found = unknown.clone();
        for _ in 0..LOOKS {
            unknown.retain(|&t| !self.look_beside(delaunay, t));
        }
        self.spread(delaunay, &unknown);
        for t in found {
            for v in vertices[t as usize] {
                if !crossings.touches(v) {
                    self.of_seeds[v as usize] = self.of_tets[t as usize];
                }
            }
        }
        // 3. Facets without a corner that was known.
        let agrees = |&t: &u32| {
            let beyond = delaunay.neighbors()[t as usize].map(|n| self.of_tets[n.tet() as usize]);
            let entered = self.crossed.entered(t);
            (0..4).all(|f| beyond[f] + entered[f] == self.of_tets[t as usize])
        };
        if open.par_iter().with_min_len(BLOCK).all(agrees) { Ok(()) } else { Err(NotClosed) }
    }

    /// Finds the windings of tets with a corner that is known; those with at most one such, in their order.
    fn begin(&mut self, vertices: &[[u32; 4]]) -> Result<Vec<u32>, NotClosed> {
        let of_seeds = &self.of_seeds;
        self.of_tets.resize(vertices.len(), UNKNOWN);
        let blocks = self.of_tets.par_chunks_mut(BLOCK).zip(vertices.par_chunks(BLOCK));
        let of_block = |(block, (windings, tets)): (usize, (&mut [i32], &[[u32; 4]]))| {
            // What a tet is is hard to predict, and written in any case.
            let mut open = vec![0; tets.len() + 1];
            let (mut agreed, mut count) = (true, 0);
            for (k, tet) in tets.iter().enumerate() {
                // All is outside around the infinite vertex.
                let known = tet.map(|v| of_seeds.get(v as usize).copied().unwrap_or(0));
                // Windings are far above UNKNOWN.
                let winding = known.into_iter().fold(UNKNOWN, i32::max);
                windings[k] = winding;
                agreed &= known.iter().fold(true, |all, &w| all & ((w == winding) | (w == UNKNOWN)));
                open[count] = (block * BLOCK + k) as u32;
                count += usize::from(known.iter().map(|&w| u32::from(w == UNKNOWN)).sum::<u32>() >= 3);
            }
            open.truncate(count);
            if agreed { Ok(open) } else { Err(NotClosed) }
        };
        let open: Vec<Vec<u32>> = blocks.enumerate().map(of_block).collect::<Result<_, NotClosed>>()?;
        Ok(open.concat())
    }

    /// Finds the winding of a tet from one beside it, if that of any is known; whether it is.
    fn look_beside(&mut self, delaunay: &Delaunay, t: u32) -> bool {
        let beyond = delaunay.neighbors()[t as usize].map(|n| self.of_tets[n.tet() as usize]);
        let Some(f) = (0..4).find(|&f| beyond[f] != UNKNOWN) else { return false };
        self.of_tets[t as usize] = beyond[f] + self.crossed.entered(t)[f];
        true
    }

    /// Finds the windings of `unknown` tets from those next to them.
    fn spread(&mut self, delaunay: &Delaunay, unknown: &[u32]) {
        let neighbors = delaunay.neighbors();
        let (winding, crossed) = (&mut self.of_tets, &self.crossed);
        let mut stack: Vec<u32> = Vec::new();
        for &start in unknown {
            if winding[start as usize] != UNKNOWN {
                continue;
            }
            let mut sources = (0..4).map(|f| (f, winding[neighbors[start as usize][f].tet() as usize]));
            let Some((f, beyond)) = sources.find(|s| s.1 != UNKNOWN) else { continue };
            winding[start as usize] = beyond + crossed.entered(start)[f];
            stack.push(start);
            while let Some(t) = stack.pop() {
                let entered = crossed.entered(t);
                for (facet, entered) in neighbors[t as usize].iter().zip(entered) {
                    let n = facet.tet();
                    if winding[n as usize] == UNKNOWN {
                        winding[n as usize] = winding[t as usize] - entered;
                        stack.push(n);
                    }
                }
            }
        }
    }
}
