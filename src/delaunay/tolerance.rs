//! How far points may move before a predicate of theirs can change.
//!
//! P. M. M. de Castro, J. Tournois, P. Alliez, O. Devillers, *Filtering relocations on a Delaunay triangulation*, Computer
//! Graphics Forum 28(5), 2009, doi 10.1111/j.1467-8659.2009.01523.x: the tolerance of a bi-cell is half the width of the
//! thinnest annulus that holds its five points; of four points on the hull, half the width of the thinnest slab.
//!
//! Departure: the paper takes the annulus about the axis of the common facet, with that facet on one sphere and the two
//! apexes on the other. It is the thinnest only if the segment between the apexes passes through the facet; elsewhere it is
//! too wide, and a bi-cell may fail before. Here a bound is taken that holds for every bi-cell, and that is the true width to first order.
//!
//! **Spheres.** Let x_i = Σ λ_j x_j express the apex q by the corners of the tet, with circumcentre o and radius R, and
//! P = |q - o|² - R² > 0. With coefficients c = (λ, -1), which sum to zero as do the c_i x_i, Σ c_i |x_i - z|² = -P for
//! every z. If the points, moved by at most e, lay on a sphere about z of radius r, each |x_i - z| would be within e of r, so
//! P <= C (2 r e + e²/2) with C = 1 + Σ |λ|. And r cannot be large: the moved corners lie on that sphere, so z - o solves the
//! moved equations of the circumcentre; with K the norm of the inverse of the tet's edges and t = 2√3 K e < 1 that gives
//! |z - o| <= R t / (1 - t). So while P > C (2 R e / (1 - t) + 5/2 e²), no sphere, and no plane either, passes through all five.
//!
//! **Planes.** Let g_i be the gradients of the barycentric coordinates of four points. If the points, moved by at most e,
//! lay on a plane of normal n, then n = -Σ (n.δ_i) g_i, so 1 <= 2 e max |Σ over a subset of the g_i|: the exact half width.
//!
//! **Rounding.** As for the spheres of `tets.rs`: where a tet is too flat for plain `f64` the tolerance is zero, elsewhere
//! errors are below 1e-8 of each part, and margins of 1e-6 are kept.

use glam::DVec3;

use super::tets::{MARGIN, Spoke, sphere};

/// Square of the largest ratio of the longest edge's cube to six volumes for which rounding is bounded.
const SHARPNESS2: f64 = 1e12;

/// Below this longest squared edge, products may underflow.
const TINY: f64 = 1e-60;

/// Relative error of barycentric coordinates, generously.
const SLACK: f64 = 4e-8;

/// Four points, with what tolerances need of them.
pub struct Quad {
    origin: DVec3,
    /// Gradients of the barycentric coordinates of the last three points.
    gradients: [DVec3; 3],
    /// Whether rounding is bounded.
    certain: bool,
    edges: [Spoke; 3],
}

impl Quad {
    /// Of four points in general position, or the tolerances are zero.
    pub fn new([o, a, b, c]: [DVec3; 4]) -> Quad {
        let edges = [a, b, c].map(|p| Spoke::new(o, p));
        let [u, v, w] = edges.map(|e| e.to);
        let cross = [v.cross(w), w.cross(u), u.cross(v)];
        let det = u.dot(cross[0]);
        let longest2 = edges.iter().fold(0.0, |m: f64, e| m.max(e.length2));
        let certain = det * det * SHARPNESS2 > longest2 * longest2 * longest2 && longest2 > TINY;
        let scale = 1.0 / det;
        Quad { origin: o, gradients: cross.map(|c| c * scale), certain, edges }
    }

    /// How far the four may move before they can lie on a plane.
    pub fn of_plane(&self) -> f64 {
        if !self.certain {
            return 0.0;
        }
        let [a, b, c] = self.gradients;
        let sums = [a, b, c, a + b, b + c, c + a, a + b + c];
        let largest2 = sums.iter().fold(0.0, |m: f64, g| m.max(g.length_squared()));
        0.5 * (1.0 - MARGIN) / largest2.sqrt()
    }

    /// The sphere of a positive tet.
    pub fn sphere(&self) -> Sphere<'_> {
        let [a, b, c] = self.edges;
        let (center, radius2) = sphere(self.origin, a, b, c);
        let inverse = self.gradients.iter().map(|g| g.length_squared()).sum::<f64>().sqrt();
        Sphere { quad: self, center, radius2, radius: radius2.sqrt(), inverse }
    }
}

/// The sphere of a tet, with what tolerances need of it.
pub struct Sphere<'a> {
    quad: &'a Quad,
    center: DVec3,
    radius2: f64,
    radius: f64,
    /// K.
    inverse: f64,
}

impl Sphere<'_> {
    #[cfg(test)]
    fn center_and_radius2(&self) -> (DVec3, f64) {
        (self.center, self.radius2)
    }

    /// How far the corners and `q`, which is outside, may move before they can lie on a sphere.
    pub fn of(&self, q: DVec3) -> f64 {
        let power = (q - self.center).length_squared() * (1.0 - MARGIN) - self.radius2 * (1.0 + MARGIN);
        // Also if the radius is not known, and so NaN.
        if !(self.quad.certain && power > 0.0) {
            return 0.0;
        }
        let to = q - self.quad.origin;
        let shares = self.quad.gradients.map(|g| g.dot(to));
        let rest = 1.0 - (shares[0] + shares[1] + shares[2]);
        let sum = 1.0 + shares.iter().fold(rest.abs(), |s, l| s + l.abs()) + SLACK * to.length() * self.inverse;
        let radius = self.radius;
        // t = steepness * e.
        let steepness = 2.0 * 3f64.sqrt() * self.inverse;
        let at_most = (power / (2.0 * radius * sum)).min(0.5 / steepness);
        let t = steepness * at_most;
        let bound = power / (sum * (2.0 * radius / (1.0 - t) + 2.5 * at_most));
        bound.min(at_most) * (1.0 - MARGIN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::predicates::{Sign, insphere, orient3d};
    use crate::rng::Rng;

    fn point(rng: &mut Rng) -> DVec3 {
        rng.in_cube()
    }

    /// Directions in which to move five points: random, and against the sphere.
    fn moves(rng: &mut Rng, points: &[DVec3], center: DVec3, share: f64, e: f64) -> Vec<DVec3> {
        points
            .iter()
            .map(|&p| {
                let out = (p - center).normalize() * if rng.unit() < 0.5 { 1.0 } else { -1.0 };
                let any = point(rng).normalize();
                p + out.lerp(any, share).normalize() * e
            })
            .collect()
    }

    #[test]
    fn within_the_tolerance_no_sign_changes_and_beyond_it_some_do() {
        let mut rng = Rng::new(1, 0);
        let (mut tried, mut near, mut tight) = (0, 0, 0);
        while tried < 2000 {
            let mut p: Vec<DVec3> = (0..5).map(|_| point(&mut rng)).collect();
            if orient3d(p[0], p[1], p[2], p[3]) != Sign::Positive {
                p.swap(0, 1);
            }
            let (center, radius2) = Quad::new([p[0], p[1], p[2], p[3]]).sphere().center_and_radius2();
            let is_near = rng.unit() < 0.5;
            if is_near {
                p[4] = center + (p[4] - center).normalize() * radius2.sqrt() * (1.0 + 0.01 * rng.unit());
            }
            let inside = |p: &[DVec3]| insphere(p[0], p[1], p[2], p[3], p[4]);
            if radius2.is_nan() || radius2 > 10.0 || inside(&p) != Sign::Negative {
                continue;
            }
            tried += 1;
            let quad = Quad::new([p[0], p[1], p[2], p[3]]);
            let sphere = quad.sphere();
            let (e, plane) = (sphere.of(p[4]), quad.of_plane());
            let mut changed = false;
            for k in 0..200 {
                let share = if k % 2 == 0 { 0.0 } else { rng.unit() };
                let moved = moves(&mut rng, &p, sphere.center, share, e);
                assert_eq!(inside(&moved), Sign::Negative);
                let moved = moves(&mut rng, &p, sphere.center, share, 1.5 * e);
                changed |= inside(&moved) != Sign::Negative;
                let moved = moves(&mut rng, &p[..4], sphere.center, 1.0, plane);
                assert_eq!(orient3d(moved[0], moved[1], moved[2], moved[3]), Sign::Positive);
            }
            near += usize::from(is_near);
            tight += usize::from(is_near && changed);
        }
        // Were the bound much below the truth, nothing would change at half as much again.
        assert!(10 * tight > 9 * near, "{tight} of {near} of {tried}");
    }

    #[test]
    fn ties_and_flat_tets_have_no_tolerance() {
        let cube = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        assert_eq!(Quad::new(cube).sphere().of(DVec3::ONE), 0.0);
        let flat = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)];
        assert_eq!(Quad::new(flat).of_plane(), 0.0);
        assert_eq!(Quad::new(flat).sphere().of(DVec3::ONE), 0.0);
    }

    #[test]
    fn the_slab_of_a_regular_tet_is_between_opposite_edges() {
        let tet = [DVec3::ONE, DVec3::new(-1.0, -1.0, 1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(1.0, -1.0, -1.0)];
        assert!((Quad::new(tet).of_plane() - 1.0).abs() < 1e-5);
    }
}
