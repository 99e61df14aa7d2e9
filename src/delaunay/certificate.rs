//! How far vertices may move before a tet must be tested again.
//!
//! A tet's certificate is a distance m: while none of its corners and apexes has moved farther than m from where it was
//! tested, the tet stays positive and the facets that it answers for stay Delaunay. With the names of `detect.rs`, F = D P
//! where P is the power of the apex q for the circumsphere, of centre c and radius R; and q = Σ βj xj with Σ βj = 1.
//!
//! - Seen from c, the five points are rows (y, |y|² - R², 1) of F: all of the third column are zero but P. After the motion they
//!   are at most r = 2Rm + m² in size, and P has lost at most 2 |q - c| m + m². Expand F by that column: with D, and the
//!   determinants D βj of the tets with q in place of xj, having changed by at most d and dj,
//!   F' >= F - (2 |q - c| m + m²) D - P d - r (S + Σ dj), S = D Σ|βj|.
//! - A determinant changes by at most m times the sum of the lengths of its four normals, and terms of higher order: for D
//!   that is d <= N m + 12.5 l m², N = 2 √(sum of squares of the normals), l the longest of the edges at x0, if m <= l/16. With
//!   k = |q - x0|, Σ dj <= (12 l² + 18 lk) m + ..., and all terms of second and higher order of r (S + Σ dj) come to at
//!   most (S + 2R (16 l² + 21 lk)) m².
//! - As 2 |q - c| D = √(|2DR|² + 4DF) <= 2DR + 2F/l (2R >= l), 21 lk <= 16 l² + 7 k² and D <= S, all in all
//!   F' >= F - G m - K m² with G = 2R (D + S) + 2F/l + N P and K = 2S + 2R (32 l² + 7 k²) + 12.5 l P.
//!   That is positive for m = F / (G + √(K F)); likewise D' for m = D / (N + √(12.5 l D)).
//!
//! Rounding: F and D enter as what is sure of them, the rest with room for its errors, and a millionth is taken off
//! the result. The first order is
//! sharp, what follows it is bounded term by term.
//!
//! A hull facet's certificate is that of two kinds of orientation: of the facet and a point inside, and of the facet and each
//! neighbour's vertex.
//!
//! The annulus of P. M. M. de Castro, J. Tournois, P. Alliez, O. Devillers, *Filtering relocations on a Delaunay
//! triangulation*, Computer Graphics Forum 28(5), 2009, doi 10.1111/j.1467-8659.2009.01523.x, gives such distances too, for
//! bi-cells; the tolerance of Zhou et al. 2010 is one on matrices. This one has to be
//! cheap, as it is computed with every test.

use glam::DVec3;
use rayon::prelude::*;

use super::detect::{LANES, Lanes, TINY, U, from, gather, is_left_to_other, larger};
use super::facet::INFINITE;
use super::flip::Mesh;
use crate::geometry::triples::{cross, dot};

/// Tets that one thread tests in a row.
const CHUNK: usize = 2048;

/// A tet without a certificate: it is tested after each motion.
pub const NONE: f32 = -1.0;

/// Certificates below this are none, so that nothing underflows.
const LEAST: f64 = 1e-30;

/// Room for rounding.
const SHORT: f64 = 1.0 - 1e-6;

/// Tests tets; their certificates are left in `found`, [`NONE`] for what could not be cleared.
pub fn certify(mesh: &Mesh, tets: &[u32], found: &mut Vec<f32>) {
    found.clear();
    found.resize(tets.len(), NONE);
    let chunk = |(tets, found): (&[u32], &mut [f32])| {
        pulp::Arch::new().dispatch(Batch { mesh, tets, found });
        for (&t, found) in tets.iter().zip(found) {
            if mesh.vertices[t as usize][3] == INFINITE {
                *found = rounded(hull_certificate(mesh, t));
            }
        }
    };
    if rayon::current_num_threads() == 1 || tets.len() <= CHUNK {
        chunk((tets, found));
    } else {
        tets.par_chunks(CHUNK).zip(found.par_chunks_mut(CHUNK)).for_each(chunk);
    }
}

/// A certificate as it is stored.
#[inline(always)]
fn rounded(m: f64) -> f32 {
    if m > LEAST { (m * SHORT) as f32 } else { NONE }
}

/// Tets to be tested; compiled for each width of vectors, like the test of all.
struct Batch<'a> {
    mesh: &'a Mesh,
    tets: &'a [u32],
    found: &'a mut [f32],
}

impl pulp::WithSimd for Batch<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Batch { mesh, tets, found } = self;
        for (tets, found) in tets.chunks(LANES).zip(found.chunks_mut(LANES)) {
            let (mut vertices, mut opposite) = ([[INFINITE; 4]; LANES], [[INFINITE; 4]; LANES]);
            for ((&t, v), q) in tets.iter().zip(&mut vertices).zip(&mut opposite) {
                (*v, *q) = (mesh.vertices[t as usize], mesh.opposite[t as usize]);
            }
            let certificates = test(&mesh.points, &vertices, &opposite);
            for (found, m) in found.iter_mut().zip(certificates) {
                *found = rounded(m);
            }
        }
    }
}

/// The certificates of tets, zero or less for none.
#[inline(always)]
fn test(points: &[DVec3], vertices: &[[u32; 4]; LANES], opposite: &[[u32; 4]; LANES]) -> Lanes {
    let at = gather(points, vertices, opposite);
    let [origin, others @ ..] = &at;
    let mut least = [0.0; LANES];
    for l in 0..LANES {
        let o = &origin[l];
        let (u, v, w) = (from(o, &others[0][l]), from(o, &others[1][l]), from(o, &others[2][l]));
        let (vw, wu, uv) = (cross(v, w), cross(w, u), cross(u, v));
        let (uu, vv, ww) = (dot(u, u), dot(v, v), dot(w, w));
        let d = dot(u, vw);
        let a = sum(sum(scaled(vw, uu), scaled(wu, vv)), scaled(uv, ww));
        let m = larger(larger(uu, vv), ww);
        let length = m.sqrt();
        let m3 = m * length;
        let sure = d - 50.0 * U * m3;
        let k = 32.0 * U * m3 * m;
        // The orientation's.
        let base = sum(sum(vw, wu), uv);
        let normals = 2.0 * (dot(vw, vw) + dot(wu, wu) + dot(uv, uv) + dot(base, base)).sqrt() + 100.0 * U * m;
        // The least of the quotients, without dividing for each.
        let (mut above, mut below) = (sure, normals + (12.5 * length * sure).sqrt());
        // The facets'.
        let size = dot(a, a).sqrt() + 100.0 * U * m * m;
        let inverse = 1.0 / sure;
        let diameter = size * inverse;
        let with_f = 2.0 / length + normals * inverse;
        let flattening = 12.5 * length * inverse;
        let mut good = (sure > 0.0) & (m > TINY) & (vertices[l][3] != INFINITE);
        for (i, q) in others[3..].iter().enumerate() {
            let q = from(o, &q[l]);
            let qq = dot(q, q);
            let (b1, b2, b3) = (dot(q, vw), dot(q, wu), dot(q, uv));
            let f = sure * qq - dot(a, q) - k;
            let most = f + 3.0 * k + 105.0 * U * m3 * qq;
            let tets = (d - b1 - b2 - b3).abs() + b1.abs() + b2.abs() + b3.abs() + 100.0 * U * length * (m + qq);
            let slope = size + diameter * tets + with_f * most;
            let rest = 2.0 * tets + diameter * (32.0 * m + 7.0 * qq) + flattening * most;
            let bound = slope + (rest * most).sqrt();
            let left = is_left_to_other(vertices[l][i], opposite[l][i]);
            good &= (f > 0.0) | left;
            let lower = (f * below < above * bound) & !left;
            above = if lower { f } else { above };
            below = if lower { bound } else { below };
        }
        let certificate = above / below;
        let limit = length * (1.0 / 16.0);
        let certificate = if certificate < limit { certificate } else { limit };
        least[l] = if good { certificate } else { 0.0 };
    }
    least
}

#[inline(always)]
fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn scaled(a: [f64; 3], by: f64) -> [f64; 3] {
    [a[0] * by, a[1] * by, a[2] * by]
}

/// The certificate of an infinite tet: that its facet turns its inner side to the point inside, and to the vertices across
/// those of its edges that it answers for.
fn hull_certificate(mesh: &Mesh, t: u32) -> f64 {
    let [a, b, c, _] = mesh.vertices[t as usize];
    let facet = [a, b, c].map(|v| mesh.at(v).to_array());
    let mut least = orientation_certificate(facet, mesh.inside.to_array());
    for i in 0..3 {
        let (own, apex) = (mesh.vertices[t as usize][i], mesh.opposite[t as usize][i]);
        if !is_left_to_other(own, apex) {
            least = least.min(orientation_certificate(facet, mesh.at(apex).to_array()));
        }
    }
    least
}

/// How far four points may move while (a, b, c, d) stays negative; zero or less if it is not certain that it is.
fn orientation_certificate([a, b, c]: [[f64; 3]; 3], d: [f64; 3]) -> f64 {
    let edge = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (u, v, w) = (edge(c), edge(b), edge(d));
    let (vw, wu, uv) = (cross(v, w), cross(w, u), cross(u, v));
    let m = larger(larger(dot(u, u), dot(v, v)), dot(w, w));
    let length = m.sqrt();
    let sure = dot(w, uv) - 50.0 * U * m * length;
    if sure <= 0.0 || m <= TINY {
        return 0.0;
    }
    let base = sum(sum(vw, wu), uv);
    let normals = [vw, wu, uv, base].iter().map(|n| dot(*n, *n).sqrt()).sum::<f64>() + 100.0 * U * m;
    (sure / (normals + (12.5 * length * sure).sqrt())).min(length / 16.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delaunay::Delaunay;
    use crate::geometry::predicates::{Sign, insphere, orient3d};
    use crate::rng::Rng;

    fn mesh_of(points: &[DVec3]) -> Mesh {
        let delaunay = Delaunay::build(points).expect("these points have tets");
        let mut mesh = Mesh::default();
        mesh.points = points.to_vec();
        mesh.vertices = delaunay.vertices().to_vec();
        mesh.neighbors = delaunay.neighbors().to_vec();
        mesh.inside = points.iter().sum::<DVec3>() / points.len() as f64;
        mesh.derive();
        mesh
    }

    fn point_sets() -> Vec<Vec<DVec3>> {
        let mut rng = Rng::new(5, 0);
        let mut point = || DVec3::new(rng.unit(), rng.unit(), rng.unit());
        let uniform: Vec<DVec3> = (0..300).map(|_| point()).collect();
        let grid = |n: i32| DVec3::new((n % 7) as f64, (n / 7 % 7) as f64, (n / 49) as f64) * 0.125;
        let sets = [1e-1, 1e-3, 1e-6, 1e-10, 1e-13].map(|noise| (0..343).map(|n| grid(n) + point() * noise).collect());
        [vec![uniform], sets.into()].concat()
    }

    /// Whether tet `t` is positive, and the facets that it answers for are Delaunay.
    fn holds(mesh: &Mesh, t: u32, points: [DVec3; 8]) -> bool {
        let [a, b, c, d, apexes @ ..] = points;
        let (tet, across) = (mesh.vertices[t as usize], mesh.opposite[t as usize]);
        let own = |i: &usize| !is_left_to_other(tet[*i], across[*i]);
        if tet[3] == INFINITE {
            let facet = |q: DVec3| orient3d(a, b, c, q) == Sign::Negative;
            return facet(mesh.inside) && (0..3).filter(own).all(|i| facet(apexes[i]));
        }
        orient3d(a, b, c, d) == Sign::Positive
            && (0..4).filter(own).all(|i| insphere(a, b, c, d, apexes[i]) == Sign::Negative)
    }

    #[test]
    fn nothing_changes_within_a_certificate() {
        let mut rng = Rng::new(9, 0);
        let (mut certified, mut near) = (0, 0);
        for points in point_sets() {
            let mesh = mesh_of(&points);
            let all: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
            let mut certificates = Vec::new();
            certify(&mesh, &all, &mut certificates);
            for (&t, &m) in all.iter().zip(&certificates).filter(|(_, m)| **m > 0.0) {
                certified += 1;
                let (tet, across) = (mesh.vertices[t as usize], mesh.opposite[t as usize]);
                let at: [DVec3; 8] = std::array::from_fn(|i| {
                    let v = if i < 4 { tet[i] } else { across[i - 4] };
                    if v == INFINITE { DVec3::ZERO } else { mesh.at(v) }
                });
                assert!(holds(&mesh, t, at));
                let moved =
                    |by: f64, ways: &[DVec3; 8]| -> [DVec3; 8] { std::array::from_fn(|i| at[i] + ways[i] * by) };
                let mut failed = false;
                for round in 0..24 {
                    // Random ways, and such as shrink or grow the tet against its apexes.
                    let mut ways: [DVec3; 8] = std::array::from_fn(|_| {
                        DVec3::new(rng.unit() - 0.5, rng.unit() - 0.5, rng.unit() - 0.5).normalize_or(DVec3::X)
                    });
                    if round % 2 == 0 && tet[3] != INFINITE {
                        let [a, b, c, d] = [at[0], at[1], at[2], at[3]];
                        let center = crate::geometry::tetrahedron::circumcenter(a, b, c, d);
                        let sign = if round % 4 == 0 { 1.0 } else { -1.0 };
                        for (i, (way, at)) in ways.iter_mut().zip(at).enumerate() {
                            let away = (at - center).normalize_or(DVec3::X) * if i < 4 { sign } else { -1.0 };
                            *way = (away + *way * (0.05 * f64::from(round))).normalize_or(DVec3::X);
                        }
                    }
                    let m = f64::from(m) * (1.0 - 1e-9);
                    assert!(holds(&mesh, t, moved(m, &ways)), "tet {t}, certificate {m}, round {round}");
                    failed |= !holds(&mesh, t, moved(30.0 * m, &ways));
                }
                near += usize::from(failed);
            }
        }
        // They are not idle: most tets do change at a few times the distance.
        assert!(certified > 5000 && 2 * near > certified, "{near} of {certified}");
    }

    #[test]
    fn every_width_of_vectors_gives_the_same_certificates() {
        for points in point_sets() {
            let mesh = mesh_of(&points);
            let all: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
            let mut expected = Vec::new();
            certify(&mesh, &all, &mut expected);
            let mut plain = vec![NONE; all.len()];
            pulp::WithSimd::with_simd(Batch { mesh: &mesh, tets: &all, found: &mut plain }, pulp::Scalar::new());
            for ((&t, expected), plain) in all.iter().zip(expected).zip(plain) {
                assert!(mesh.vertices[t as usize][3] == INFINITE || expected == plain, "tet {t}: {expected} {plain}");
            }
        }
    }
}
