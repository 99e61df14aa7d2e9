//! What the Voronoi edges inside the solid add to the cells around them.
//!
//! The dual edge of the facet (p, q, r), from a to b, adds to the cell of each ordered pair (i, j) of its vertices the tet
//! (x_i, m_ij, a, b), m_ij the middle of the two. With a as origin, D = b - a, X = x - a:
//!
//! | of (i, j) and (j, i) | |
//! |---|---|
//! | volume, the same for both | d = D . (X_i x X_j) / 12 |
//! | first moment of i | d (X_j - 5 X_i + 2 D) / 8 |
//! | second moment, the same for both | d (9 (X_i² + X_j²) - 6 X_i . X_j - 6 (X_i + X_j) . D + 4 D²) / 40 |
//!
//! The last uses that a and b are as far from x_i as from x_j. Edges that the surface does not cross, nearly all, are
//! done many at a time in vectors: see `tet_shares.rs`, and `weighted_edges.rs` where the solid has a density.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::Crossing;
use super::cell::{Cell, Sums, add_sums};
use super::circumcenters::circumcenter;
use super::crossed_tets::{Crossed, NOWHERE};
use super::crossings::{Crossings, FACET};
use super::tet_shares::Shares;
use crate::delaunay::Delaunay;
use crate::geometry::triples::{cross, dot, minus};

/// Tets in a block of the work: fixed, so that sums do not depend on the number of threads.
const BLOCK: usize = 8192;

/// What the edges are made of.
#[derive(Clone, Copy)]
pub(super) struct Edges<'a> {
    pub(super) delaunay: &'a Delaunay,
    pub(super) crossings: &'a Crossings<'a>,
    /// See [`CrossedTets`](super::crossed_tets::CrossedTets).
    pub(super) marks: &'a [u8],
    /// See [`CrossedTets`](super::crossed_tets::CrossedTets).
    pub(super) crossed: &'a [Crossed],
    pub(super) winding: &'a [i32],
    pub(super) arch: pulp::Arch,
}

/// What a density makes of an edge: N numbers for each of its three cells.
pub(super) trait Measure<const N: usize>: Sync {
    /// What one thread needs for edges that the surface does not cross.
    type Buffers: Default;

    /// What is known at the seeds of a facet.
    fn at_seeds(&self, facet: [u32; 3]) -> [f64; 3];

    /// At the circumcentre of a tet.
    fn at_center(&self, tet: usize) -> f64;

    /// At a crossing.
    fn at_crossing(&self, crossing: &Crossing) -> f64;

    /// What the interval from `a` to `b` of the Voronoi edge of a facet adds to the cells of its three vertices, all times
    /// `weight`, with what is known at the seeds and at the ends.
    fn interval(
        facet: [[f64; 3]; 3],
        ends: [[f64; 3]; 2],
        weight: f64,
        at_seeds: [f64; 3],
        at_ends: [f64; 2],
    ) -> [[f64; N]; 3];

    /// Adds the edges of some tets' facets that the surface does not cross.
    fn add_uncrossed(&self, edges: &Edges, tets: Range<usize>, buffers: &mut Self::Buffers, sums: &mut Sums<N>);

    /// Adds such numbers to a cell.
    fn add(cell: &mut Cell, numbers: [f64; N]);
}

/// The density 1: volume, first moment, second moment.
pub(super) struct Even;

/// How many they are.
pub(super) const MOMENTS: usize = 5;

impl Measure<MOMENTS> for Even {
    type Buffers = Shares;

    #[inline(always)]
    fn at_seeds(&self, _: [u32; 3]) -> [f64; 3] {
        [1.0; 3]
    }

    #[inline(always)]
    fn at_center(&self, _: usize) -> f64 {
        1.0
    }

    #[inline(always)]
    fn at_crossing(&self, _: &Crossing) -> f64 {
        1.0
    }

    #[inline(always)]
    fn interval(
        facet: [[f64; 3]; 3],
        ends: [[f64; 3]; 2],
        weight: f64,
        _: [f64; 3],
        _: [f64; 2],
    ) -> [[f64; MOMENTS]; 3] {
        interval(facet, ends[0], ends[1], weight)
    }

    fn add_uncrossed(&self, edges: &Edges, tets: Range<usize>, buffers: &mut Shares, sums: &mut Sums<MOMENTS>) {
        buffers.add(edges, tets, sums);
    }

    fn add(cell: &mut Cell, [volume, x, y, z, energy]: [f64; MOMENTS]) {
        cell.volume += volume;
        cell.moment += DVec3::new(x, y, z);
        cell.energy += energy;
    }
}

impl Edges<'_> {
    /// Adds, for every Voronoi edge, what its part inside the solid adds to the cells around it.
    pub(super) fn add<const N: usize, M: Measure<N>>(self, cells: &mut [Cell], measure: &M) {
        let seeds = self.delaunay.points().len();
        let count = self.winding.len();
        let found: Vec<_> = (0..count.div_ceil(BLOCK))
            .into_par_iter()
            .map_init(
                || (Sums::new(seeds), M::Buffers::default()),
                |(sums, buffers), block| {
                    let tets = block * BLOCK..((block + 1) * BLOCK).min(count);
                    let of = |t: usize| self.crossed.partition_point(|c| (c.tet as usize) < t);
                    let crossed = &self.crossed[of(tets.start)..of(tets.end)];
                    measure.add_uncrossed(&self, tets, buffers, sums);
                    crossed.iter().for_each(|tet| self.add_crossed(measure, tet, sums));
                    sums.take()
                },
            )
            .collect();
        add_sums(cells, &found, M::add);
    }

    /// The circumcentre of a tet whose winding is not 0.
    pub(super) fn center(&self, tet: usize) -> DVec3 {
        circumcenter(self.delaunay.vertices()[tet].map(|i| self.delaunay.points()[i as usize]))
    }

    /// Vertices of the facet `id`, and the tets at the beginning and at the end of its dual edge.
    #[inline(always)]
    pub(super) fn facet(&self, id: u32) -> ([u32; 3], usize, usize) {
        let (t, f) = ((id / 4) as usize, (id % 4) as usize);
        let tet = self.delaunay.vertices()[t];
        (FACET[f].map(|v| tet[v]), self.delaunay.neighbors()[t][f].tet() as usize, t)
    }

    /// Adds what belongs to a tet of its edges that cross the surface.
    ///
    /// What an interval from a to b adds is the difference of what the ways from one base point to b and to a add, so that
    /// several crossings need no order along the edge. The base is the first crossing. The way to each end is added at the tet
    /// there, the others at the tet with the lesser number.
    fn add_crossed<const N: usize, M: Measure<N>>(&self, measure: &M, crossed: &Crossed, sums: &mut Sums<N>) {
        let t = crossed.tet as usize;
        let winding = self.winding[t];
        let center = if winding != 0 { self.center(t) } else { DVec3::ZERO };
        for (f, first) in crossed.first.into_iter().enumerate().filter(|f| f.1 != NOWHERE) {
            let facet = FACET[f].map(|v| self.delaunay.vertices()[t][v]);
            let (crossings, even) = self.crossings.from(first, facet);
            let (base, at_base) = (crossings[0].point, measure.at_crossing(&crossings[0]));
            let at_seeds = measure.at_seeds(facet);
            let corners = facet.map(|i| self.delaunay.points()[i as usize].to_array());
            let mut add = |to: DVec3, at_to: f64, weight: i32| {
                let ends = [base.to_array(), to.to_array()];
                let parts = M::interval(corners, ends, f64::from(weight), at_seeds, [at_base, at_to]);
                facet.iter().zip(parts).for_each(|(&i, part)| sums.add(i, part));
            };
            if winding != 0 {
                add(center, measure.at_center(t), winding);
            }
            if crossings.len() > 1 && t < self.delaunay.neighbors()[t][f].tet() as usize {
                for c in &crossings[1..] {
                    add(c.point, measure.at_crossing(c), if c.leaves == even { 1 } else { -1 });
                }
            }
        }
    }
}

/// What the interval from `a` to `b` of the Voronoi edge of a facet adds to the cells of its three vertices: volume, first
/// moment, second moment, all times `weight`.
#[inline(always)]
pub(super) fn interval(facet: [[f64; 3]; 3], a: [f64; 3], b: [f64; 3], weight: f64) -> [[f64; MOMENTS]; 3] {
    let [p, q, r] = facet.map(|x| minus(x, a));
    let d = minus(b, a);
    let twelfth = weight / 12.0;
    let volumes = [dot(d, cross(p, q)) * twelfth, dot(d, cross(q, r)) * twelfth, dot(d, cross(r, p)) * twelfth];
    let squares =
        [9.0 * dot(p, p) - 6.0 * dot(p, d), 9.0 * dot(q, q) - 6.0 * dot(q, d), 9.0 * dot(r, r) - 6.0 * dot(r, d)];
    let last = 4.0 * dot(d, d);
    let second = |volume: f64, i: f64, j: f64, ij: f64| volume * (i + j - 6.0 * ij + last) / 40.0;
    let pq = second(volumes[0], squares[0], squares[1], dot(p, q));
    let qr = second(volumes[1], squares[1], squares[2], dot(q, r));
    let rp = second(volumes[2], squares[2], squares[0], dot(r, p));
    [
        of_vertex(p, d, q, volumes[0], r, volumes[2], pq + rp),
        of_vertex(q, d, r, volumes[1], p, volumes[0], qr + pq),
        of_vertex(r, d, p, volumes[2], q, volumes[1], rp + qr),
    ]
}

/// The share of vertex x, whose pairs with y and z have such volumes.
#[inline(always)]
fn of_vertex(
    x: [f64; 3],
    d: [f64; 3],
    y: [f64; 3],
    with_y: f64,
    z: [f64; 3],
    with_z: f64,
    second: f64,
) -> [f64; MOMENTS] {
    let volume = with_y + with_z;
    let moment = |k: usize| (with_y * y[k] + with_z * z[k] + volume * (2.0 * d[k] - 5.0 * x[k])) * 0.125;
    [volume, moment(0), moment(1), moment(2), second]
}
