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
//! The infinite vertex stands far out on an axis. A finite tet's facet on the hull then always passes, and
//! an infinite tet never does, so that it goes on to the exact tests of the hull.

use glam::DVec3;
use rayon::prelude::*;

/// Tets that are tested at once.
const LANES: usize = 8;

/// Tets that one thread tests in a row.
const CHUNK: usize = 4096;

/// Where the infinite vertex stands: a power of two whose square dwarfs any product of coordinates.
const FAR: f64 = f64::from_bits((1023 + 300) << 52);

/// Below this squared length products may underflow.
const TINY: f64 = 1e-50;

/// A position, aligned so that it is never split between cache lines.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
pub struct Corner([f64; 3]);

/// Copies positions to where [`suspects`] wants them: the infinite vertex comes last.
pub fn corners(points: &[DVec3], corners: &mut Vec<Corner>) {
    corners.clear();
    corners.extend(points.iter().map(|p| Corner(p.to_array())));
    corners.push(Corner([FAR, 0.0, 0.0]));
}

/// The tets, ascending, of which it is not certain that they are positive and their facets Delaunay: all
/// infinite ones, and few others.
pub fn suspects(corners: &[Corner], vertices: &[[u32; 4]], opposite: &[[u32; 4]]) -> Vec<u32> {
    let chunk = |(n, (vertices, opposite)): (usize, (&[[u32; 4]], &[[u32; 4]]))| {
        let mut found = Vec::new();
        scan(corners, vertices, opposite, (n * CHUNK) as u32, &mut found);
        found
    };
    if rayon::current_num_threads() == 1 || vertices.len() <= CHUNK {
        return vertices.chunks(CHUNK).zip(opposite.chunks(CHUNK)).enumerate().flat_map(chunk).collect();
    }
    let parts: Vec<Vec<u32>> =
        vertices.par_chunks(CHUNK).zip(opposite.par_chunks(CHUNK)).enumerate().map(chunk).collect();
    parts.concat()
}

/// Tests tets in a row, the first of which has the number `first`.
fn scan(corners: &[Corner], vertices: &[[u32; 4]], opposite: &[[u32; 4]], first: u32, found: &mut Vec<u32>) {
    let (blocks, rest) = vertices.as_chunks::<LANES>();
    let (opposite_blocks, opposite_rest) = opposite.as_chunks::<LANES>();
    let mut number = first;
    let mut note = |passed: &[bool; LANES], number: u32, count: usize| {
        if *passed != [true; LANES] {
            found.extend((0..count).filter(|&l| !passed[l]).map(|l| number + l as u32));
        }
    };
    for (vertices, opposite) in blocks.iter().zip(opposite_blocks) {
        note(&test(corners, vertices, opposite), number, LANES);
        number += LANES as u32;
    }
    if !rest.is_empty() {
        let mut last = ([[0; 4]; LANES], [[0; 4]; LANES]);
        last.0[..rest.len()].copy_from_slice(rest);
        last.1[..rest.len()].copy_from_slice(opposite_rest);
        note(&test(corners, &last.0, &last.1), number, rest.len());
    }
}

/// One coordinate of one corner of each tet.
type Lanes = [f64; LANES];

/// Whether each tet and its facets are certainly as they should be.
#[inline(always)]
fn test(corners: &[Corner], vertices: &[[u32; 4]; LANES], opposite: &[[u32; 4]; LANES]) -> [bool; LANES] {
    const U: f64 = f64::EPSILON / 2.0;
    let last = corners.len() - 1;
    let mut at = [[[0.0; LANES]; 3]; 8];
    for l in 0..LANES {
        for k in 0..4 {
            let Corner(p) = corners[(vertices[l][k] as usize).min(last)];
            let Corner(q) = corners[(opposite[l][k] as usize).min(last)];
            for axis in 0..3 {
                at[k][axis][l] = p[axis];
                at[4 + k][axis][l] = q[axis];
            }
        }
    }
    let [origin, others @ ..]: &[[Lanes; 3]; 8] = &at;
    let mut passed = [false; LANES];
    for l in 0..LANES {
        let from = |p: &[Lanes; 3]| DVec3::new(p[0][l] - origin[0][l], p[1][l] - origin[1][l], p[2][l] - origin[2][l]);
        let (u, v, w) = (from(&others[0]), from(&others[1]), from(&others[2]));
        let (vw, wu, uv) = (v.cross(w), w.cross(u), u.cross(v));
        let (uu, vv, ww) = (u.length_squared(), v.length_squared(), w.length_squared());
        let d = u.dot(vw);
        let a = vw * uu + wu * vv + uv * ww;
        let m = if uu > vv { uu } else { vv };
        let m = if m > ww { m } else { ww };
        let m3 = m * m.sqrt();
        let sure = d - 50.0 * U * m3;
        let k = 32.0 * U * m3 * m;
        let mut good = (sure > 0.0) & (m > TINY);
        for q in &others[3..] {
            let q = from(q);
            good &= sure * q.length_squared() - a.dot(q) > k;
        }
        passed[l] = good;
    }
    passed
}
