//! Which tets may have been spoilt by a motion: one fused test per tet, over all tets, many at a time.
//!
//! With x0 the tet's first corner as origin, u, v, w the others and q an apex across a facet, D = det[u, v, w] and
//! A = |u|²(v x w) + |v|²(w x u) + |w|²(u x v), the tet is positive if D > 0, and q is outside its sphere if
//! D |q|² - A.q > 0: orientation and sphere are computed once for four facets.
//!
//! **Error.** Let M be the largest of |u|², |v|², |w|². Counted as sums of products of the rounded differences, the roundings
//! (2^-53 each) are at most 15 in each product of D |q|² and 17 in each of A.q; and the sum of the absolute products of a
//! 3x3 determinant is at most 1.1548 times the product of the lengths of its rows. So the error of the test is at most
//! (17.4 M^(3/2) |q|² + 59 M² |q|) 2^-53. As 2 L |q| <= |q|² + L² for L = √M, that is at most
//! (46.9 M^(3/2) |q|² + 29.5 M^(5/2)) 2^-53: with D' = D - 50 M^(3/2) 2^-53 and K = 32 M^(5/2) 2^-53, rounding of these
//! themselves included, a facet with D' |q|² - A.q > K is certainly Delaunay, and a tet with D' > 0 certainly positive.
//!
//! Each facet is left to one of its two tets, the one whose own vertex opposite has the lesser number; a facet of the hull
//! to the infinite tet, which never passes, so that it goes on to the exact tests of the hull.

use glam::DVec3;
use rayon::prelude::*;

use super::facet::INFINITE;
use crate::geometry::triples::{cross, dot};

/// Tets that are tested at once.
pub const LANES: usize = 8;

/// Vectors of tets whose vertices are looked up in a row, so that vectors are read well after their numbers were written.
pub const BLOCKS: usize = 4;

/// Tets that one thread tests in a row.
const CHUNK: usize = 4096;

/// Below this squared length products may underflow.
pub const TINY: f64 = 1e-50;

/// Half the distance from 1 to the next number: the largest relative error of a rounding.
pub const U: f64 = f64::EPSILON / 2.0;

/// The tets, ascending, of which it is not certain that they are positive and their facets Delaunay: all
/// infinite ones, and few others.
pub fn suspects(points: &[DVec3], vertices: &[[u32; 4]], opposite: &[[u32; 4]]) -> Vec<u32> {
    let chunks = vertices.len().div_ceil(CHUNK);
    let chunk = |n: usize| {
        let range = n * CHUNK..vertices.len().min((n + 1) * CHUNK);
        let first = range.start as u32;
        pulp::Arch::new().dispatch(Scan {
            points,
            vertices: &vertices[range.clone()],
            opposite: &opposite[range],
            first,
        })
    };
    if rayon::current_num_threads() == 1 || chunks == 1 {
        return (0..chunks).flat_map(chunk).collect();
    }
    let parts: Vec<Vec<u32>> = (0..chunks).into_par_iter().map(chunk).collect();
    parts.concat()
}

/// Tests of tets in a row. It is compiled for each width of vectors, and the widest that the processor has is chosen as the
/// program runs; the operations are the same in each, and so are the answers.
struct Scan<'a> {
    points: &'a [DVec3],
    vertices: &'a [[u32; 4]],
    opposite: &'a [[u32; 4]],
    /// Number of the first tet.
    first: u32,
}

impl pulp::WithSimd for Scan<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Vec<u32> {
        let Scan { points, vertices, opposite, first } = self;
        let mut found = Vec::new();
        let (blocks, rest) = vertices.as_chunks::<LANES>();
        let (opposite_blocks, opposite_rest) = opposite.as_chunks::<LANES>();
        let mut number = first;
        let mut at = [[[DVec3::ZERO; LANES]; 8]; BLOCKS];
        for (vertices, opposite) in blocks.chunks(BLOCKS).zip(opposite_blocks.chunks(BLOCKS)) {
            for ((vertices, opposite), at) in vertices.iter().zip(opposite).zip(&mut at) {
                gather(points, vertices, opposite, at);
            }
            for ((vertices, opposite), at) in vertices.iter().zip(opposite).zip(&at) {
                let passed = test(at, vertices, opposite);
                if passed != [1.0; LANES] {
                    note(&passed, number, &mut found);
                }
                number += LANES as u32;
            }
        }
        if !rest.is_empty() {
            let mut last = ([[0; 4]; LANES], [[0; 4]; LANES]);
            last.0[..rest.len()].copy_from_slice(rest);
            last.1[..rest.len()].copy_from_slice(opposite_rest);
            gather(points, &last.0, &last.1, &mut at[0]);
            note(&test(&at[0], &last.0, &last.1)[..rest.len()], number, &mut found);
        }
        found
    }
}

/// Notes the tets that did not pass.
#[inline(never)]
fn note(passed: &[f64], first: u32, found: &mut Vec<u32>) {
    found.extend((first..).zip(passed).filter(|(_, passed)| **passed != 1.0).map(|(t, _)| t));
}

/// A number of each tet.
pub type Lanes = [f64; LANES];

/// The corners of tets, and then their apexes: the vertices across each facet.
pub type Gathered = [[DVec3; LANES]; 8];

/// Finds the corners and apexes of some tets. The infinite vertex, which is never asked for, is where the last one is.
#[inline(always)]
fn gather(points: &[DVec3], vertices: &[[u32; 4]; LANES], opposite: &[[u32; 4]; LANES], at: &mut Gathered) {
    let Some(last) = points.len().checked_sub(1) else { return };
    for l in 0..LANES {
        for k in 0..4 {
            at[k][l] = points[(vertices[l][k] as usize).min(last)];
            at[4 + k][l] = points[(opposite[l][k] as usize).min(last)];
        }
    }
}

/// Whether a facet is for the other one of its tets to test, given the vertices opposite it in this one and in that: true
/// too if the other one is infinite, as the infinite vertex is all ones.
#[inline(always)]
pub fn is_left_to_other(own: u32, apex: u32) -> bool {
    apex.wrapping_add(1) <= own
}

/// For each tet, 1 if it and its facets are certainly as they should be, else 0.
#[inline(always)]
fn test(at: &Gathered, vertices: &[[u32; 4]; LANES], opposite: &[[u32; 4]; LANES]) -> Lanes {
    // From here on all is done for all tets at once, by vectors.
    let [origin, others @ ..] = at;
    let mut passed = [0.0; LANES];
    for l in 0..LANES {
        let o = &origin[l];
        let (u, v, w) = (from(o, &others[0][l]), from(o, &others[1][l]), from(o, &others[2][l]));
        let (vw, wu, uv) = (cross(v, w), cross(w, u), cross(u, v));
        let (uu, vv, ww) = (dot(u, u), dot(v, v), dot(w, w));
        let d = dot(u, vw);
        let ax = vw[0] * uu + wu[0] * vv + uv[0] * ww;
        let ay = vw[1] * uu + wu[1] * vv + uv[1] * ww;
        let az = vw[2] * uu + wu[2] * vv + uv[2] * ww;
        let m = larger(larger(uu, vv), ww);
        let m3 = m * m.sqrt();
        let sure = d - 50.0 * U * m3;
        let k = 32.0 * U * m3 * m;
        let mut good = (sure > 0.0) & (m > TINY) & (vertices[l][3] != INFINITE);
        for (i, q) in others[3..].iter().enumerate() {
            let q = from(o, &q[l]);
            good &= (sure * dot(q, q) - dot([ax, ay, az], q) > k) | is_left_to_other(vertices[l][i], opposite[l][i]);
        }
        passed[l] = if good { 1.0 } else { 0.0 };
    }
    passed
}

/// `f64::max` without its rules for NaN.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// From one position to another.
#[inline(always)]
pub fn from(o: &DVec3, p: &DVec3) -> [f64; 3] {
    [p.x - o.x, p.y - o.y, p.z - o.z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delaunay::Delaunay;
    use crate::geometry::predicates::{Sign, insphere, orient3d};

    /// A grid, of which every cell is cospherical, each coordinate moved by up to `noise`.
    fn noisy_grid(noise: f64, offset: f64) -> Vec<DVec3> {
        let mut bits = 1u64;
        let mut random = || {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((bits >> 11) as f64 * 2f64.powi(-53) - 0.5) * noise
        };
        (0..729)
            .map(|i| DVec3::new((i % 9) as f64, (i / 9 % 9) as f64, (i / 81) as f64) * 0.1)
            .map(|p| p + DVec3::new(random(), random(), random()) + DVec3::splat(offset))
            .collect()
    }

    #[test]
    fn what_is_cleared_is_delaunay() {
        let mut cleared = 0;
        for offset in [0.0, 1e3] {
            for noise in [1e-1, 1e-6, 1e-10, 1e-12, 1e-13, 1e-14, 1e-15] {
                let delaunay = Delaunay::build(&noisy_grid(noise, offset)).expect("a grid has tets");
                // Other noise of the same size: many tets are turned around, many facets no longer Delaunay.
                let points: Vec<DVec3> = noisy_grid(2.0 * noise, offset).into_iter().rev().collect();
                let points: Vec<DVec3> = points.iter().map(|p| DVec3::splat(0.8 + 2.0 * offset) - *p).collect();
                let apex = |t: usize, i: usize| {
                    let f = delaunay.neighbors()[t][i];
                    delaunay.vertices()[f.tet() as usize][f.slot()]
                };
                let tets = delaunay.vertices();
                let opposite: Vec<[u32; 4]> = (0..tets.len()).map(|t| [0, 1, 2, 3].map(|i| apex(t, i))).collect();
                let suspects = suspects(&points, tets, &opposite);
                for (t, tet) in tets.iter().enumerate() {
                    if suspects.binary_search(&(t as u32)).is_ok() {
                        continue;
                    }
                    assert_ne!(tet[3], INFINITE, "infinite tets are always suspect");
                    cleared += 1;
                    let [a, b, c, d] = tet.map(|v| points[v as usize]);
                    assert_eq!(orient3d(a, b, c, d), Sign::Positive, "{noise} {offset}");
                    let own = |(i, q): &(usize, &u32)| !is_left_to_other(tet[*i], **q);
                    for (_, &q) in opposite[t].iter().enumerate().filter(own) {
                        assert_ne!(q, INFINITE);
                        assert_eq!(insphere(a, b, c, d, points[q as usize]), Sign::Negative, "{noise} {offset}");
                    }
                }
            }
        }
        assert!(cleared > 2000, "{cleared}");
    }
}
