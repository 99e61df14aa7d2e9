//! How good a tet is.
//!
//! The quality of a tet is min(s, 0.7 (180 - l)) of its smallest and largest dihedral angles s and l, in radians: at 35
//! degrees no angle is below 35 or above 130. Angles come from cosines by a polynomial (M. Abramowitz, I. A. Stegun,
//! *Handbook of Mathematical Functions*, 1964, 4.4.46: error below 2e-8), the same on every platform.

use std::f64::consts::PI;

use glam::DVec3;

/// What a degree at the largest angle counts for against one at the smallest.
pub(super) const LARGE_WEIGHT: f64 = 0.7;

/// The quality of a tet that is flat or inverted.
pub(super) const INVERTED: f64 = -1.0;

/// A tet with less than this share of the cube of its longest edge as its volume, times six, is flat.
pub(super) const FLAT: f64 = 1e-9;

/// The arc cosine.
#[inline(always)]
pub(super) fn acos(x: f64) -> f64 {
    let positive = acos_positive(least(x.abs(), 1.0));
    if x < 0.0 { PI - positive } else { positive }
}

#[inline(always)]
fn acos_positive(x: f64) -> f64 {
    let low = 1.570_796_305_0 + x * (-0.214_598_801_6 + x * (0.088_978_987_4 - 0.050_174_304_6 * x));
    let high = 0.030_891_881_0 + x * (-0.017_088_125_6 + x * (0.006_670_090_1 - 0.001_262_491_1 * x));
    let x2 = x * x;
    (1.0 - x).sqrt() * (low + x2 * x2 * high)
}

/// `f64::min` without its rules for NaN.
#[inline(always)]
pub(super) fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// `f64::max` without its rules for NaN.
#[inline(always)]
pub(super) fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Smallest and largest dihedral angle of tet (a, b, c, d); `None` where it is flat or inverted.
#[inline]
pub(super) fn extremes([a, b, c, d]: [DVec3; 4]) -> Option<[f64; 2]> {
    let (u, v, w) = (b - a, c - a, d - a);
    // Outward normals, twice the facets' area long; they sum to zero.
    let (nb, nc, nd) = (w.cross(v), u.cross(w), v.cross(u));
    let volume6 = -nd.dot(w);
    let longest2 = most(most(u.length_squared(), v.length_squared()), w.length_squared());
    if volume6.is_nan() || volume6 <= FLAT * longest2 * longest2.sqrt() {
        return None;
    }
    let na = -(nb + nc + nd);
    let ra = na.length_squared().sqrt().recip();
    let rb = nb.length_squared().sqrt().recip();
    let rc = nc.length_squared().sqrt().recip();
    let rd = nd.length_squared().sqrt().recip();
    // The normals are outward: these are the cosines of the angles outside.
    let (ab, ac, ad) = (na.dot(nb) * (ra * rb), na.dot(nc) * (ra * rc), na.dot(nd) * (ra * rd));
    let (bc, bd, cd) = (nb.dot(nc) * (rb * rc), nb.dot(nd) * (rb * rd), nc.dot(nd) * (rc * rd));
    let low = least(least(least(ab, ac), least(ad, bc)), least(bd, cd));
    let high = most(most(most(ab, ac), most(ad, bc)), most(bd, cd));
    Some([acos(-low), acos(-high)])
}

/// The quality of tet (a, b, c, d); [`INVERTED`] where it is flat or inverted.
#[inline]
pub(super) fn quality(corners: [DVec3; 4]) -> f64 {
    extremes(corners).map_or(INVERTED, combined)
}

/// The quality of a tet with these smallest and largest dihedral angles.
#[inline(always)]
pub(super) fn combined([smallest, largest]: [f64; 2]) -> f64 {
    least(smallest, LARGE_WEIGHT * (PI - largest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tetrahedron;
    use crate::rng::Rng;

    fn tets() -> impl Iterator<Item = [DVec3; 4]> {
        let mut rng = Rng::new(1, 7);
        std::iter::repeat_with(move || [rng.in_cube(), rng.in_cube(), rng.in_cube(), rng.in_cube()])
            .filter(|&[a, b, c, d]| tetrahedron::volume6(a, b, c, d) > 0.05)
            .take(200)
    }

    #[test]
    fn the_polynomial_is_the_arc_cosine() {
        for i in -1000..=1000 {
            let x = f64::from(i) / 1000.0;
            assert!((acos(x) - x.acos()).abs() < 3e-8, "{x}");
        }
        assert_eq!(acos(1.0 + 1e-16), 0.0);
    }

    #[test]
    fn extremes_are_those_of_the_six_angles() {
        for [a, b, c, d] in tets() {
            let angles = tetrahedron::dihedral_angles(a, b, c, d).map(f64::to_radians);
            let [smallest, largest] = extremes([a, b, c, d]).expect("a positive tet");
            assert!((smallest - angles.into_iter().fold(9.0, f64::min)).abs() < 1e-7);
            assert!((largest - angles.into_iter().fold(0.0, f64::max)).abs() < 1e-7);
            assert_eq!(quality([b, a, c, d]), INVERTED);
        }
        assert_eq!(quality([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 1e-12)]), INVERTED);
    }
}
