//! Exact predicates: the only file that calls `robust`, and the one sign convention.
//!
//! A tet (a, b, c, d) is **positive** when det[b - a, c - a, d - a] > 0. [`orient3d`] gives that sign; [`insphere`] is
//! positive when a point lies inside the sphere of a positive tet; [`insphere_perturbed`] breaks its ties.
//!
//! - J. R. Shewchuk, *Adaptive precision floating-point arithmetic and fast robust geometric predicates*, Discrete &
//!   Computational Geometry 18(3), 1997, doi 10.1007/PL00009321: the exact stage, from the crate `robust`.
//! - O. Devillers, M. Teillaud, *Perturbations and vertex removal in a 3D Delaunay triangulation*, Proc. 14th ACM-SIAM
//!   Symposium on Discrete Algorithms (SODA), 2003, pp. 313-319: the perturbation.
//!
//! In front of the exact stage stands a filter that adapts to the size of the tet: a bound that is fixed for the whole
//! model lets nothing pass once edges are short against it.
//!
//! **Range.** Every predicate is exact for coordinates that are multiples of 2^-200 and at most 2^60 in size: nothing
//! of degree five in their differences can then overflow or underflow. `Delaunay` holds its points so; the frame of
//! the mesher lies deep within.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D};

/// The sign of an exact quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sign {
    /// Below zero.
    Negative = -1,
    /// Zero.
    Zero = 0,
    /// Above zero.
    Positive = 1,
}

impl Sign {
    /// The sign of `x`, which is not NaN.
    #[inline]
    pub fn of(x: f64) -> Sign {
        if x > 0.0 {
            Sign::Positive
        } else if x < 0.0 {
            Sign::Negative
        } else {
            Sign::Zero
        }
    }
}

impl std::ops::Neg for Sign {
    type Output = Sign;

    #[inline]
    fn neg(self) -> Sign {
        match self {
            Sign::Negative => Sign::Positive,
            Sign::Zero => Sign::Zero,
            Sign::Positive => Sign::Negative,
        }
    }
}

/// Rounding of the plain 3x3 determinant of rounded differences, over the product of the largest difference along each
/// axis: six products, each with at most eight roundings of 2^-53 (48 * 2^-53 = 5.33e-15), and room for the bound itself.
const ORIENT3D_BOUND: f64 = 5.5e-15;

/// Below this the bound above may itself underflow.
const ORIENT3D_TINY: f64 = 1e-250;

/// Square of the rounding of the plain 4x4 determinant of rounded differences and lifts, over the fifth power of the
/// largest lift M: 24 products of at most M^(5/2), each with at most 17 roundings of 2^-53, come to 4.6e-14 M^(5/2);
/// this is the square of 1.2466e-13.
const INSPHERE_BOUND_SQUARED: f64 = 1.5542e-26;

/// Below this largest lift the fifth power underflows.
const INSPHERE_TINY: f64 = 1e-50;

/// `f64::max` without its rules for NaN, which cost a third of the filter.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The sign of det[b - a, c - a, d - a]: positive when d sees the triangle (a, b, c) clockwise, that is when d lies on
/// the side that the normal (b - a) x (c - a) points to.
#[inline]
pub fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Sign {
    let (u, v, w) = (b - a, c - a, d - a);
    let det = u.x * (v.y * w.z - v.z * w.y) + u.y * (v.z * w.x - v.x * w.z) + u.z * (v.x * w.y - v.y * w.x);
    let x = larger(larger(u.x.abs(), v.x.abs()), w.x.abs());
    let y = larger(larger(u.y.abs(), v.y.abs()), w.y.abs());
    let z = larger(larger(u.z.abs(), v.z.abs()), w.z.abs());
    let size = x * y * z;
    if det.abs() > ORIENT3D_BOUND * size && size > ORIENT3D_TINY {
        return if det > 0.0 { Sign::Positive } else { Sign::Negative };
    }
    orient3d_exact(a, b, c, d)
}

#[cold]
#[inline(never)]
fn orient3d_exact(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Sign {
    // Shewchuk's sign is the opposite of ours.
    -Sign::of(robust::orient3d(coord(a), coord(b), coord(c), coord(d)))
}

/// Positive when p lies inside the sphere through the positive tet (a, b, c, d), zero on it, negative outside.
#[inline]
pub fn insphere(a: DVec3, b: DVec3, c: DVec3, d: DVec3, p: DVec3) -> Sign {
    let (a1, b1, c1, d1) = (a - p, b - p, c - p, d - p);
    let (al, bl, cl, dl) = (a1.length_squared(), b1.length_squared(), c1.length_squared(), d1.length_squared());
    let ab = a1.x * b1.y - b1.x * a1.y;
    let bc = b1.x * c1.y - c1.x * b1.y;
    let cd = c1.x * d1.y - d1.x * c1.y;
    let da = d1.x * a1.y - a1.x * d1.y;
    let ac = a1.x * c1.y - c1.x * a1.y;
    let bd = b1.x * d1.y - d1.x * b1.y;
    let abc = a1.z * bc - b1.z * ac + c1.z * ab;
    let bcd = b1.z * cd - c1.z * bd + d1.z * bc;
    let cda = c1.z * da + d1.z * ac + a1.z * cd;
    let dab = d1.z * ab + a1.z * bd + b1.z * da;
    let det = (cl * dab - dl * abc) + (al * bcd - bl * cda);
    let m = larger(larger(al, bl), larger(cl, dl));
    let m2 = m * m;
    if m > INSPHERE_TINY && det * det > INSPHERE_BOUND_SQUARED * (m2 * m2 * m) {
        return if det > 0.0 { Sign::Positive } else { Sign::Negative };
    }
    insphere_exact(a, b, c, d, p)
}

#[cold]
#[inline(never)]
fn insphere_exact(a: DVec3, b: DVec3, c: DVec3, d: DVec3, p: DVec3) -> Sign {
    // Shewchuk's is positive inside when his orient3d is positive, ours negative.
    -Sign::of(robust::insphere(coord(a), coord(b), coord(c), coord(d), coord(p)))
}

/// As [`insphere`], with ties broken: never zero for five distinct points of which (a, b, c, d) make a positive tet.
///
/// Each point is lifted by a further infinitesimal amount, the larger its lexicographic position the (infinitely) larger
/// the amount. The sign of the perturbed determinant is then that of its first non-zero minor, from the largest
/// point down: if that is p, p is outside; else p takes its place in the tet, and the orientation of that tet decides.
/// Only the lift is perturbed, so flat tets stay flat, and are never chosen; and only the positions of the
/// points count, so that the Delaunay triangulation of a set of points is unique.
#[inline]
pub fn insphere_perturbed(a: DVec3, b: DVec3, c: DVec3, d: DVec3, p: DVec3) -> Sign {
    match insphere(a, b, c, d, p) {
        Sign::Zero => break_tie([a, b, c, d], p),
        sign => sign,
    }
}

/// The perturbed sign for a point p on the sphere of a tet.
#[cold]
pub fn break_tie(tet: [DVec3; 4], p: DVec3) -> Sign {
    let mut order = [0, 1, 2, 3];
    order.sort_unstable_by(|&i: &usize, &j: &usize| lexicographic(tet[j], tet[i]));
    for i in order {
        if lexicographic(p, tet[i]).is_gt() {
            return Sign::Negative;
        }
        let mut replaced = tet;
        replaced[i] = p;
        match orient3d(replaced[0], replaced[1], replaced[2], replaced[3]) {
            Sign::Zero => {}
            sign => return sign,
        }
    }
    Sign::Negative
}

/// The order of two points by x, then y, then z.
#[inline]
pub fn lexicographic(a: DVec3, b: DVec3) -> Ordering {
    a.x.total_cmp_numeric(b.x).then(a.y.total_cmp_numeric(b.y)).then(a.z.total_cmp_numeric(b.z))
}

/// Order of finite numbers, in which the two zeros are equal.
trait NumericOrder {
    fn total_cmp_numeric(self, other: Self) -> Ordering;
}

impl NumericOrder for f64 {
    #[inline]
    fn total_cmp_numeric(self, other: f64) -> Ordering {
        self.partial_cmp(&other).expect("coordinates are finite: this is a bug in tetcvt")
    }
}

/// The sign of the area of the plane triangle (a, b, c): positive when it is counter-clockwise.
#[inline]
pub fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> Sign {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    Sign::of(robust::orient2d(coord(a), coord(b), coord(c)))
}

/// The signs of the components of (b - a) x (c - a).
pub fn normal_signs(a: DVec3, b: DVec3, c: DVec3) -> [Sign; 3] {
    [
        orient2d(DVec2::new(a.y, a.z), DVec2::new(b.y, b.z), DVec2::new(c.y, c.z)),
        orient2d(DVec2::new(a.z, a.x), DVec2::new(b.z, b.x), DVec2::new(c.z, c.x)),
        orient2d(DVec2::new(a.x, a.y), DVec2::new(b.x, b.y), DVec2::new(c.x, c.y)),
    ]
}

/// Whether three points lie on one line.
pub fn collinear(a: DVec3, b: DVec3, c: DVec3) -> bool {
    normal_signs(a, b, c) == [Sign::Zero; 3]
}

#[inline]
fn coord(p: DVec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: DVec3 = DVec3::ZERO;
    const B: DVec3 = DVec3::X;
    const C: DVec3 = DVec3::Y;
    const D: DVec3 = DVec3::Z;

    #[test]
    fn signs_follow_the_convention_in_the_filter_and_in_the_exact_stage() {
        for orient in [orient3d, orient3d_exact] {
            assert_eq!(orient(A, B, C, D), Sign::Positive);
            assert_eq!(orient(B, A, C, D), Sign::Negative);
            assert_eq!(orient(A, B, C, DVec3::new(0.3, 0.3, 0.0)), Sign::Zero);
        }
        for inside in [insphere, insphere_exact] {
            assert_eq!(inside(A, B, C, D, DVec3::splat(0.5)), Sign::Positive);
            assert_eq!(inside(A, B, C, D, DVec3::splat(1.5)), Sign::Negative);
            assert_eq!(inside(A, B, C, D, DVec3::splat(1.0)), Sign::Zero);
        }
    }

    #[test]
    fn ties_go_to_the_lexicographically_largest() {
        // The farthest corner of the cube is the largest of the five: outside.
        assert_eq!(insphere_perturbed(A, B, C, D, DVec3::ONE), Sign::Negative);
        // Here B = (1, 0, 0) is the largest, and (0, 1, 1) in its place turns the tet around.
        assert_eq!(orient3d(A, DVec3::new(0.0, 1.0, 1.0), C, D), Sign::Zero);
        assert_ne!(insphere_perturbed(A, B, C, D, DVec3::new(0.0, 1.0, 1.0)), Sign::Zero);
    }

    #[test]
    fn collinear_only_on_a_line() {
        assert!(collinear(A, DVec3::new(1.0, 2.0, 3.0), DVec3::new(-2.0, -4.0, -6.0)));
        assert!(!collinear(A, B, DVec3::new(2.0, 0.0, 1e-30)));
    }
}
