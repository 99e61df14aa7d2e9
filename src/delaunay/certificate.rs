//! How many motions a tet is good for before it must be tested again, if each vertex goes no farther than its bound in any.
//!
//! A tet's certificate is a number n of motions: while each of its corners and apexes is within n times its bound from where
//! it was tested, the tet stays positive and the facets that it answers for stay Delaunay. With the names of `detect.rs`,
//! F = D P where P is the power of the apex q for the circumsphere, of centre c and radius R; and q = Σ βj xj with Σ βj = 1. A
//! vertex v goes mv = n bv in all, bv its bound, and none of them farther than m = n b.
//!
//! - Seen from c, the five points are rows (y, |y|² - R², 1) of F: all of the third column are zero but P. After the motion
//!   they are at most rj = 2R mj + m² in size, and P has lost at most 2 |q - c| mq. Expand F by that column: with D, and the
//!   determinants D βj of the tets with q in place of xj, having changed by at most d and dj,
//!   F' >= F - 2 |q - c| mq D - P d - Σ rj (D |βj| + dj).
//! - A determinant changes by at most Σ Nj mj, Nj the lengths of its four normals, and terms of higher order: for D
//!   that is d <= N m + 12.5 l m², N = 2 √(sum of squares of the normals), l the longest of the edges at x0, if m <= l/16.
//! - With q in place of xj there are six new facets, each of them twice, of areas below half of sa sb, where sa = |xa - q|. With
//!   T = Σ sa² these come to Σ sa sb <= 1.5 T, so Σ dj <= (N + 3T) m + 24 √T m² + 32 m³, and as m <= l/16 and l <= 2R,
//!   Σ rj dj <= 2R (1.07 N + 4T + 0.95 l²) m².
//! - As 2 |q - c| D = √(|2DR|² + 4DF) <= 2DR + 2F/l, with S = D Σ|βj|, all in all
//!   F' >= F - G n - K n² with G = 2R D (bq + Σ |βj| bj) + 2F bq/l + N' P, N' = 2 √(Σ (Nj bj)²), and
//!   K = (S + 2R (1.07 N + 4T + 0.95 l²) + 12.5 l P) b².
//!   That is positive for n = F / (G + √(K F)); likewise D' for n = D / (N' + b √(12.5 l D)).
//!
//! Rounding: F and D enter as what is sure of them, the rest with room for its errors, and a millionth is taken off
//! the result. The first order is sharp, each vertex with its own weight and bound; what follows it is bounded term by term.
//!
//! A hull facet's certificate is that of two kinds of orientation: of the facet and a point inside, and of the facet and each
//! neighbour's vertex.
//!
//! The annulus of P. M. M. de Castro, J. Tournois, P. Alliez, O. Devillers, *Filtering relocations on a Delaunay
//! triangulation*, Computer Graphics Forum 28(5), 2009, doi 10.1111/j.1467-8659.2009.01523.x, gives distances for
//! bi-cells; the tolerance of Zhou et al. 2010 is one on matrices. This one has to be
//! cheap, as it is computed with every test.

use std::array::from_fn;

use super::detect::{Gathered, LANES, Lanes, TINY, U, from, is_left_to_other, larger};
use super::flip::Mesh;
use crate::geometry::triples::{cross, dot, minus};

/// A tet without a certificate: it is tested after each motion.
pub const NONE: f32 = -1.0;

/// The least bound, so that nothing underflows.
pub const LEAST_BOUND: f32 = 1e-30;

/// Room for rounding.
const SHORT: f64 = 1.0 - 1e-6;

/// A certificate as it is stored.
#[inline(always)]
pub fn rounded(n: f64) -> f32 {
    if n > 0.0 { (n * SHORT) as f32 } else { NONE }
}

/// Tets in a row of vectors: where their corners are, then the apexes, and their bounds.
#[derive(Clone, Copy, Default)]
pub struct Block {
    pub at: Gathered,
    pub reach: [[f32; LANES]; 8],
}

/// The motions that tets are good for, zero or less for none.
#[inline(always)]
pub fn test<const FACETS: usize>(block: &Block) -> Lanes {
    let Block { at, reach } = block;
    let reach: [Lanes; 8] = reach.map(|bounds| bounds.map(f64::from));
    let [origin, others @ ..] = at;
    // Numbers of each tet, which its facets share.
    let [mut det, mut sure, mut square, mut long, mut most, mut good] = [[0.0; LANES]; 6];
    let [mut size, mut diameter, mut flattening, mut with_p, mut with_q] = [[0.0; LANES]; 5];
    let (mut normals, mut center, mut edges) = ([[[0.0; LANES]; 3]; 3], [[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    let mut sides = [0.0; LANES];
    // The least of the quotients, without dividing for each.
    let [mut above, mut below] = [[0.0; LANES]; 2];
    for l in 0..LANES {
        let o = &origin[l];
        let (u, v, w) = (from(o, &others[0][l]), from(o, &others[1][l]), from(o, &others[2][l]));
        let (vw, wu, uv) = (cross(v, w), cross(w, u), cross(u, v));
        let (uu, vv, ww) = (dot(u, u), dot(v, v), dot(w, w));
        let d = dot(u, vw);
        let a = sum(sum(scaled(vw, uu), scaled(wu, vv)), scaled(uv, ww));
        let m = larger(larger(uu, vv), ww);
        let length = m.sqrt();
        let base = sum(sum(vw, wu), uv);
        let squares = [dot(base, base), dot(vw, vw), dot(wu, wu), dot(uv, uv)];
        let mut b = larger(larger(reach[0][l], reach[1][l]), larger(reach[2][l], reach[3][l]));
        // The orientation's.
        let rounding = 100.0 * U * m;
        let weighted: [f64; 4] = from_fn(|k| squares[k] * reach[k][l] * reach[k][l]);
        let weighted = 2.0 * ((weighted[0] + weighted[1]) + (weighted[2] + weighted[3])).sqrt() + rounding * b;
        let certain = d - 50.0 * U * m * length;
        above[l] = certain;
        below[l] = weighted + (12.5 * length * certain).sqrt() * b;
        // For the facets.
        for i in 0..FACETS {
            b = larger(b, reach[4 + i][l]);
        }
        let all = (squares[0] + squares[1]) + (squares[2] + squares[3]);
        for c in 0..3 {
            normals[0][c][l] = vw[c];
            normals[1][c][l] = wu[c];
            normals[2][c][l] = uv[c];
            center[c][l] = a[c];
            edges[c][l] = u[c] + v[c] + w[c];
        }
        det[l] = d;
        sure[l] = certain;
        let inverse = 1.0 / certain;
        size[l] = dot(a, a).sqrt() + 100.0 * U * m * m;
        diameter[l] = size[l] * inverse;
        flattening[l] = 12.5 * length * inverse;
        let facets = 2.0 * all.sqrt() + rounding;
        sides[l] = 1.07 * facets + 4.0 * (uu + vv + ww) + 0.95 * m;
        with_p[l] = weighted * inverse;
        with_q[l] = 2.0 / length;
        square[l] = m;
        long[l] = length;
        most[l] = b;
        good[l] = if (certain > 0.0) & (m > TINY) { 1.0 } else { 0.0 };
    }
    for i in 0..FACETS {
        for l in 0..LANES {
            let (d, sure, m, length, b) = (det[l], sure[l], square[l], long[l], most[l]);
            let normal = |k: usize| [normals[k][0][l], normals[k][1][l], normals[k][2][l]];
            let q = from(&origin[l], &others[3 + i][l]);
            let qq = dot(q, q);
            let (b1, b2, b3) = (dot(q, normal(0)), dot(q, normal(1)), dot(q, normal(2)));
            let b0 = d - b1 - b2 - b3;
            let m3 = m * length;
            let k = 32.0 * U * m3 * m;
            let f = sure * qq - dot([center[0][l], center[1][l], center[2][l]], q) - k;
            let at_most = f + 3.0 * k + 105.0 * U * m3 * qq;
            let rounding = 100.0 * U * length * (m + qq);
            let (b0, b1, b2, b3) = (b0.abs(), b1.abs(), b2.abs(), b3.abs());
            let tets = b0 + b1 + b2 + b3 + rounding;
            let moved = (b0 * reach[0][l] + b1 * reach[1][l]) + (b2 * reach[2][l] + b3 * reach[3][l]) + rounding * b;
            let own = reach[4 + i][l];
            let slope = size[l] * own + diameter[l] * moved + (with_q[l] * own + with_p[l]) * at_most;
            let along = dot(q, [edges[0][l], edges[1][l], edges[2][l]]);
            let rest = tets + diameter[l] * (sides[l] + 16.0 * qq - 8.0 * along) + flattening[l] * at_most;
            let bound = slope + (rest * at_most).sqrt() * b;
            good[l] = if f > 0.0 { good[l] } else { 0.0 };
            let lower = f * below[l] < above[l] * bound;
            above[l] = if lower { f } else { above[l] };
            below[l] = if lower { bound } else { below[l] };
        }
    }
    let mut motions = [0.0; LANES];
    for l in 0..LANES {
        let (certificate, limit) = (above[l] / below[l], long[l] * (1.0 / 16.0) / most[l]);
        let certificate = if certificate < limit { certificate } else { limit };
        motions[l] = if good[l] == 1.0 { certificate } else { 0.0 };
    }
    motions
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
pub fn hull_certificate(mesh: &Mesh, bounds: &[f32], t: u32) -> f64 {
    let [a, b, c, _] = mesh.vertices[t as usize];
    let facet = [a, b, c].map(|v| mesh.at(v).to_array());
    let reach = |v: u32| f64::from(bounds[v as usize]);
    let most = reach(a).max(reach(b)).max(reach(c));
    let mut least = orientation_certificate(facet, mesh.inside.to_array()) / most;
    for i in 0..3 {
        let (own, apex) = (mesh.vertices[t as usize][i], mesh.opposite[t as usize][i]);
        if !is_left_to_other(own, apex) {
            let certificate = orientation_certificate(facet, mesh.at(apex).to_array());
            least = least.min(certificate / most.max(reach(apex)));
        }
    }
    least
}

/// How far four points may move while (a, b, c, d) stays negative; zero or less if it is not certain that it is.
fn orientation_certificate([a, b, c]: [[f64; 3]; 3], d: [f64; 3]) -> f64 {
    let (u, v, w) = (minus(c, a), minus(b, a), minus(d, a));
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
pub mod tests {
    use glam::DVec3;

    use super::*;
    use crate::delaunay::Delaunay;
    use crate::delaunay::facet::INFINITE;
    use crate::delaunay::rows::certify;
    use crate::geometry::predicates::{Sign, insphere, orient3d};
    use crate::rng::Rng;

    pub fn mesh_of(points: &[DVec3]) -> Mesh {
        let delaunay = Delaunay::build(points).expect("these points have tets");
        let mut mesh = Mesh::default();
        mesh.points = points.to_vec();
        mesh.vertices = delaunay.vertices().to_vec();
        mesh.neighbors = delaunay.neighbors().to_vec();
        mesh.inside = points.iter().sum::<DVec3>() / points.len() as f64;
        mesh.derive();
        mesh
    }

    pub fn point_sets() -> Vec<Vec<DVec3>> {
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
            // From nearly none to a thousandth.
            let bounds: Vec<f32> = points.iter().map(|_| (rng.unit().powi(3) * 1e-3) as f32 + 1e-12).collect();
            let mut certificates = Vec::new();
            certify(&mesh, &all, &bounds, &mut certificates);
            for (&t, &n) in all.iter().zip(&certificates).filter(|(_, n)| **n > 0.0) {
                certified += 1;
                let (tet, across) = (mesh.vertices[t as usize], mesh.opposite[t as usize]);
                let vertices: [u32; 8] = from_fn(|i| if i < 4 { tet[i] } else { across[i - 4] });
                let at = vertices.map(|v| if v == INFINITE { DVec3::ZERO } else { mesh.at(v) });
                let reach = vertices.map(|v| if v == INFINITE { 0.0 } else { f64::from(bounds[v as usize]) });
                assert!(holds(&mesh, t, at));
                let moved = |by: f64, ways: &[DVec3; 8]| from_fn(|i| at[i] + ways[i] * (by * reach[i]));
                let mut failed = false;
                for round in 0..24 {
                    // Random ways, and such as shrink or grow the tet against its apexes.
                    let mut ways: [DVec3; 8] = from_fn(|_| {
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
                    let n = f64::from(n) * (1.0 - 1e-9);
                    assert!(holds(&mesh, t, moved(n, &ways)), "tet {t}, certificate {n}, round {round}");
                    failed |= !holds(&mesh, t, moved(30.0 * n, &ways));
                }
                near += usize::from(failed);
            }
        }
        // They are not idle: most tets do change at a few times the distance.
        assert!(certified > 5000 && 2 * near > certified, "{near} of {certified}");
    }
}
