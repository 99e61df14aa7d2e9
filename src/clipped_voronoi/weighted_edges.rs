//! What the Voronoi edges that the surface does not cross add to the cells where the solid has a density, edge by edge, many at
//! a time in vectors.

use std::ops::Range;

use super::cell::Sums;
use super::voronoi_edges::{Edges, Measure};
use super::weighted::{MOMENTS, Weighted};

/// Edges that are added at once.
const LANES: usize = 8;

/// Blocks of as many that are gathered in a row.
const BLOCKS: usize = 4;

/// What is at hand of the edges of one thread.
#[derive(Default)]
pub(super) struct WholeEdges {
    /// Facets with both ends inside: four times the tet, plus the facet.
    facets: Vec<u32>,
    blocks: [Block; BLOCKS],
}

impl WholeEdges {
    /// Adds the edges of the facets of some tets, each at one of its two.
    pub(super) fn add(&mut self, edges: &Edges, measure: &Weighted, tets: Range<usize>, sums: &mut Sums<MOMENTS>) {
        self.list(edges, tets);
        // Vectors are read long after their numbers were written one by one: else each would wait for all of these.
        for ids in self.facets.chunks(BLOCKS * LANES) {
            ids.iter().enumerate().for_each(|(n, &id)| self.blocks[n / LANES].set(n % LANES, id, edges, measure));
            edges.arch.dispatch(Find { blocks: &mut self.blocks });
            (0..ids.len()).for_each(|n| self.blocks[n / LANES].add(n % LANES, sums));
        }
    }

    /// Lists them.
    fn list(&mut self, edges: &Edges, tets: Range<usize>) {
        let neighbors = edges.delaunay.neighbors();
        self.facets.clear();
        for t in tets.filter(|&t| edges.winding[t] != 0) {
            let own = |f: &usize| edges.marks[t] >> f & 1 == 0 && t < neighbors[t][*f].tet() as usize;
            self.facets.extend((0..4).filter(own).map(|f| (4 * t + f) as u32));
        }
    }
}

/// As many edges, number by number.
#[derive(Default)]
struct Block {
    facets: [[u32; 3]; LANES],
    /// The facet's three vertices and the two ends.
    at: [[[f64; LANES]; 3]; 5],
    /// What is known of the density there.
    known: [[f64; LANES]; 5],
    weights: [f64; LANES],
    /// What they add to the cells of the three.
    parts: [[[f64; LANES]; MOMENTS]; 3],
}

impl Block {
    /// Puts edge `id` into lane `l`.
    #[inline]
    fn set(&mut self, l: usize, id: u32, edges: &Edges, measure: &Weighted) {
        let (points, centers) = (edges.delaunay.points(), measure.centers);
        let (facet, from, to) = edges.facet(id);
        let [p, q, r] = facet.map(|i| points[i as usize]);
        for (k, x) in [p, q, r, centers[from], centers[to]].into_iter().enumerate() {
            (self.at[k][0][l], self.at[k][1][l], self.at[k][2][l]) = (x.x, x.y, x.z);
        }
        self.weights[l] = f64::from(edges.winding[to]);
        let [p, q, r] = measure.at_seeds(facet);
        let all = [p, q, r, measure.at_center(from), measure.at_center(to)];
        all.into_iter().enumerate().for_each(|(k, x)| self.known[k][l] = x);
        self.facets[l] = facet;
    }

    /// Adds what was found for lane `l` to the sums.
    #[inline]
    fn add(&self, l: usize, sums: &mut Sums<MOMENTS>) {
        for (part, &i) in self.parts.iter().zip(&self.facets[l]) {
            sums.add(i, std::array::from_fn(|m| part[m][l]));
        }
    }
}

/// Compiled for each width of vectors; the operations, and so the sums, are the same in each.
struct Find<'a> {
    blocks: &'a mut [Block],
}

impl pulp::WithSimd for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for Block { at, known, weights, parts, .. } in self.blocks {
            for l in 0..LANES {
                let [p, q, r, a, b] = [0, 1, 2, 3, 4].map(|k| [at[k][0][l], at[k][1][l], at[k][2][l]]);
                let [at_p, at_q, at_r, at_a, at_b] = [0, 1, 2, 3, 4].map(|k| known[k][l]);
                let found = Weighted::interval([p, q, r], [a, b], weights[l], [at_p, at_q, at_r], [at_a, at_b]);
                for k in 0..3 {
                    for m in 0..MOMENTS {
                        parts[k][m][l] = found[k][m];
                    }
                }
            }
        }
    }
}
