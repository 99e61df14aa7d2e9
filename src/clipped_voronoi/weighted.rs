//! Moments with a density of the solid, for edges whose lengths are to vary.
//!
//! The density is known at the seeds, at the Voronoi vertices and on the surface, and is linear within each of the signed
//! tets that a cell is summed from. Tets with a common side have the same values on it, so that this is one continuous
//! function, exact to the second order of their size, and energy and moments are integrals of the same one. In the middle of
//! two seeds it is that of the mean of their sizes.
//!
//! With corners p_k of a tet of volume V relative to the seed, the seed itself the first, densities r_k, and
//! S = sum p_k, R = sum r_k, T = sum r_k p_k:
//!
//! | mass | R V / 4 |
//! |---|---|
//! | first moment | (R S + T) V / 20 |
//! | second moment | (R (S² + sum p_k²) + 2 (S . T + sum r_k p_k²)) V / 120 |

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::Crossing;
use super::cell::{Cell, Sums};
use super::sheet::Sheet;
use super::voronoi_edges::{Edges, Measure};
use super::weighted_edges::WholeEdges;
use crate::geometry::triples::{cross, dot, minus};
use crate::sizing::Sizing;

/// Numbers that a Voronoi edge adds to a cell: volume, mass, first moment, second moment.
pub(super) const MOMENTS: usize = 6;

/// The density where edges are `relative` times as long as the longest.
#[inline(always)]
pub(super) fn density(relative: f64) -> f64 {
    let square = relative * relative;
    1.0 / (square * square * relative)
}

/// Relative sizes, and densities, at the seeds.
pub(super) struct AtSeeds {
    pub(super) sizes: Vec<f64>,
    pub(super) densities: Vec<f64>,
}

/// What is known at the seeds `points`.
pub(super) fn sizes(sizing: &Sizing, points: &[DVec3]) -> AtSeeds {
    let sizes: Vec<f64> = points.par_iter().map(|&p| sizing.relative(p)).collect();
    let densities = sizes.iter().map(|&s| density(s)).collect();
    AtSeeds { sizes, densities }
}

/// Densities at the circumcentres of tets whose winding is not 0; others are never asked for.
pub(super) fn at_centers(sizing: &Sizing, centers: &[DVec3], winding: &[i32]) -> Vec<f64> {
    let at = |(&c, &w): (&DVec3, &i32)| if w == 0 { 0.0 } else { density(sizing.relative(c)) };
    centers.par_iter().zip(winding).map(at).collect()
}

/// The same at hand.
#[derive(Clone, Copy)]
pub(super) struct Weights<'a> {
    pub(super) sizes: &'a [f64],
    pub(super) densities: &'a [f64],
}

impl Weights<'_> {
    /// The density at seed `i`.
    pub(super) fn at_seed(&self, i: u32) -> f64 {
        self.densities[i as usize]
    }

    /// In the middle of two seeds.
    pub(super) fn between(&self, i: u32, j: u32) -> f64 {
        density(0.5 * (self.sizes[i as usize] + self.sizes[j as usize]))
    }
}

/// Mass, first and second moment of a tet with its first corner at the origin.
#[inline(always)]
pub(super) fn tet(volume: f64, corners: [[f64; 3]; 3], densities: [f64; 4]) -> [f64; 5] {
    let [a, b, c] = corners;
    let [at_origin, at_a, at_b, at_c] = densities;
    let whole = at_origin + at_a + at_b + at_c;
    let sum = [a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]];
    let weighted = |k: usize| at_a * a[k] + at_b * b[k] + at_c * c[k];
    let weighted = [weighted(0), weighted(1), weighted(2)];
    let squares = [dot(a, a), dot(b, b), dot(c, c)];
    let all = dot(sum, sum) + (squares[0] + squares[1] + squares[2]);
    let heavy = dot(sum, weighted) + (at_a * squares[0] + at_b * squares[1] + at_c * squares[2]);
    let share = volume / 20.0;
    [
        whole * volume * 0.25,
        (whole * sum[0] + weighted[0]) * share,
        (whole * sum[1] + weighted[1]) * share,
        (whole * sum[2] + weighted[2]) * share,
        (whole * all + 2.0 * heavy) * volume / 120.0,
    ]
}

/// The density for Voronoi edges.
pub(super) struct Weighted<'a> {
    pub(super) weights: Weights<'a>,
    /// Circumcentres, and densities there, of the tets whose winding is not 0.
    pub(super) centers: &'a [DVec3],
    pub(super) at_centers: &'a [f64],
    pub(super) sheet: &'a Sheet<'a>,
}

impl Measure<MOMENTS> for Weighted<'_> {
    type Buffers = WholeEdges;

    #[inline(always)]
    fn at_seeds(&self, facet: [u32; 3]) -> [f64; 3] {
        facet.map(|i| self.weights.sizes[i as usize])
    }

    #[inline(always)]
    fn at_center(&self, tet: usize) -> f64 {
        self.at_centers[tet]
    }

    #[inline(always)]
    fn at_crossing(&self, crossing: &Crossing) -> f64 {
        self.sheet.solid_at(crossing.triangle, crossing.point)
    }

    #[inline(always)]
    fn interval(
        facet: [[f64; 3]; 3],
        ends: [[f64; 3]; 2],
        weight: f64,
        at_seeds: [f64; 3],
        at_ends: [f64; 2],
    ) -> [[f64; MOMENTS]; 3] {
        let mut found = [[0.0; MOMENTS]; 3];
        let own = [density(at_seeds[0]), density(at_seeds[1]), density(at_seeds[2])];
        let d = minus(ends[1], ends[0]);
        let from = [minus(facet[0], ends[0]), minus(facet[1], ends[0]), minus(facet[2], ends[0])];
        for k in 0..3 {
            let (i, j) = (k, (k + 1) % 3);
            let volume = dot(d, cross(from[i], from[j])) * (weight / 12.0);
            let middle = density(0.5 * (at_seeds[i] + at_seeds[j]));
            for (x, y) in [(i, j), (j, i)] {
                let half = [0, 1, 2].map(|n| 0.5 * (facet[y][n] - facet[x][n]));
                let corners = [half, minus(ends[0], facet[x]), minus(ends[1], facet[x])];
                let [mass, mx, my, mz, energy] = tet(volume, corners, [own[x], middle, at_ends[0], at_ends[1]]);
                let sums = [volume, mass, mx, my, mz, energy];
                for n in 0..MOMENTS {
                    found[x][n] += sums[n];
                }
            }
        }
        found
    }

    fn add_uncrossed(&self, edges: &Edges, tets: Range<usize>, buffers: &mut WholeEdges, sums: &mut Sums<MOMENTS>) {
        buffers.add(edges, self, tets, sums);
    }

    fn add(cell: &mut Cell, [volume, mass, x, y, z, energy]: [f64; MOMENTS]) {
        cell.volume += volume;
        cell.mass += mass;
        cell.moment += DVec3::new(x, y, z);
        cell.energy += energy;
    }
}
