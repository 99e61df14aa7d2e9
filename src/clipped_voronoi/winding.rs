//! Which circumcentres are inside.
//!
//! No ray is cast: all is outside at infinity, and along every Voronoi edge the crossings say what changes. The circumcentres
//! around a seed none of whose Voronoi edges crosses the surface are all on one side; which, is taken over from the last
//! time. That all ways agree is verified for every edge as the edges are added up (`voronoi_edges.rs`), and as they
//! connect all tets with infinity, no more is to be known.

use rayon::prelude::*;

use super::crossings::{Crossings, FACET};
use crate::delaunay::{Delaunay, INFINITE};

/// Tets that one thread looks at in a row.
const BLOCK: usize = 4096;

/// Not known.
const UNKNOWN: i32 = i32::MIN;

/// For each tet, how many shells of those that the crossings are of hold its circumcentre, outward ones counted 1 and inward
/// ones -1: 1 behind these shells and 0 in front.
#[derive(Default)]
pub(super) struct Winding {
    of_tets: Vec<i32>,
    /// For each seed that no crossing touches, the winding around it.
    of_seeds: Vec<i32>,
}

impl Winding {
    /// For each tet.
    pub(super) fn of_tets(&self) -> &[i32] {
        &self.of_tets
    }

    /// Forgets what is taken over.
    pub(super) fn forget(&mut self) {
        self.of_seeds.clear();
    }

    /// Follows the crossings to what they are now.
    pub(super) fn update(&mut self, delaunay: &Delaunay, crossings: &Crossings, marks: &[u8]) {
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
        let of_seeds = &self.of_seeds;
        self.of_tets.resize(vertices.len(), UNKNOWN);
        let unknown: Vec<Vec<u32>> = self
            .of_tets
            .par_chunks_mut(BLOCK)
            .zip(vertices.par_chunks(BLOCK))
            .enumerate()
            .map(|(block, (windings, tets))| {
                let mut unknown = Vec::new();
                for (t, (winding, tet)) in (block * BLOCK..).zip(windings.iter_mut().zip(tets)) {
                    // Windings are far above UNKNOWN, and all that are known here agree.
                    let known = |v: u32| of_seeds.get(v as usize).copied().unwrap_or(0);
                    *winding = tet.iter().fold(UNKNOWN, |max, &v| max.max(known(v)));
                    if tet[3] == INFINITE {
                        *winding = 0;
                    }
                    if *winding == UNKNOWN {
                        unknown.push(t as u32);
                    }
                }
                unknown
            })
            .collect();
        // 2. The others, across their facets.
        let unknown = unknown.concat();
        self.spread(delaunay, crossings, marks, &unknown);
        for &t in &unknown {
            for v in vertices[t as usize] {
                if !crossings.touches(v) {
                    self.of_seeds[v as usize] = self.of_tets[t as usize];
                }
            }
        }
    }

    /// Finds the windings of `unknown` tets from those next to them.
    fn spread(&mut self, delaunay: &Delaunay, crossings: &Crossings, marks: &[u8], unknown: &[u32]) {
        let (vertices, neighbors) = (delaunay.vertices(), delaunay.neighbors());
        let winding = &mut self.of_tets;
        // The winding of the tet across facet f of tet t, and of t from that.
        let entered = |t: u32, f: usize| {
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
            winding[start as usize] = beyond + entered(start, f);
            stack.push(start);
            while let Some(t) = stack.pop() {
                for (f, facet) in neighbors[t as usize].iter().enumerate() {
                    let n = facet.tet();
                    if winding[n as usize] == UNKNOWN {
                        winding[n as usize] = winding[t as usize] - entered(t, f);
                        stack.push(n);
                    }
                }
            }
        }
    }
}
