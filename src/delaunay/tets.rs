//! The tets while points are being inserted: one cache line each, with a certified sphere.
//!
//! Nearly all tests of a point against a sphere are far from close. So each new tet stores its circumcentre and squared
//! radius in plain `f64`, and a test reads that one line: outside the sphere by more than [`MARGIN`] or inside by
//! more is certain, what lies between goes to the exact predicate. Tets for which plain `f64` cannot promise that
//! much, and infinite tets, have no sphere (a NaN), and every test of theirs is exact.
//!
//! **Why the margin holds.** Let q be the origin of the tet, a, b, c the other corners relative to it, M the largest of
//! their squared lengths, D = det[a, b, c], A = |a|²(b x c) + |b|²(c x a) + |c|²(a x b), and u = 2^-53. Differences of
//! coordinates have relative error u. Counting roundings, and with the inequality of Cauchy for the sums of absolute
//! products, the error of D is at most 12 u M^(3/2), and that of the vector A at most 63 u M². The circumcentre
//! relative to q is C = A / 2D, of length r, and M <= 4 r². If k = M^(3/2) / |D| < 10^6, D has a relative error below
//! 1/2, and so the error of C is at most u r (150 k + 2) < 1.7e-8 r. Adding q rounds by at most u (|q| + r), less than
//! 1.3e-8 r if r > 10^-8 |q + C|. Together: centre and radius are each known to 3e-8 r, and their squares differ by
//! less than 1.3e-7 r² from the truth wherever a point is close to the sphere; the margin is 10^-6.

use glam::DVec3;

use super::facet::Facet;

/// A point, and where a cavity has numbered it.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub struct Site {
    /// Its position; NaN for the infinite vertex, which makes every sphere through it unknown.
    pub position: DVec3,
    /// The insertion that last numbered this point.
    pub stamp: u32,
    /// Its number in the cavity of that insertion.
    pub label: u32,
}

/// A tet under construction.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Tet {
    /// Its vertices, positively oriented; the infinite vertex only in the last slot.
    pub vertices: [u32; 4],
    /// Each of its facets as seen from the other side.
    pub mirrors: [Facet; 4],
    /// Circumcentre, near enough.
    pub center: DVec3,
    /// Squared radius of the circumsphere; NaN if not known; [`DEAD`] for a tet that is no more.
    pub radius2: f64,
}

/// Squared radius of a tet that is no longer part of the triangulation.
pub const DEAD: f64 = -1.0;

/// Relative distance of a squared length from the squared radius beyond which the comparison is certain.
pub const MARGIN: f64 = 1e-6;

/// What plain `f64` knows about a point and a tet.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Certainly inside the sphere.
    Inside,
    /// Certainly outside.
    Outside,
    /// Too close, or no sphere.
    Unknown,
}

impl Tet {
    /// Compares `p` with the circumsphere of a tet that is not [`DEAD`].
    #[inline(always)]
    pub fn side(&self, p: DVec3) -> Side {
        let d2 = (p - self.center).length_squared();
        if d2 > self.radius2 * (1.0 + MARGIN) {
            Side::Outside
        } else if d2 < self.radius2 * (1.0 - MARGIN) {
            Side::Inside
        } else {
            Side::Unknown
        }
    }

    /// Whether this tet is no longer part of the triangulation.
    #[inline(always)]
    pub fn is_dead(&self) -> bool {
        self.radius2 < 0.0
    }
}

/// A vertex of a cavity, relative to the point that is being inserted.
#[derive(Clone, Copy)]
pub struct Spoke {
    /// From the new point to the vertex.
    pub to: DVec3,
    /// Squared length of that.
    pub length2: f64,
}

impl Spoke {
    /// From `q` to `p`.
    #[inline(always)]
    pub fn new(q: DVec3, p: DVec3) -> Spoke {
        let to = p - q;
        Spoke { to, length2: to.length_squared() }
    }
}

/// Circumcentre and squared radius of the tet (q, a, b, c), the latter NaN unless both are certain to within the margin.
#[inline(always)]
pub fn sphere(q: DVec3, a: Spoke, b: Spoke, c: Spoke) -> (DVec3, f64) {
    /// Square of the largest ratio k that the margin is good for.
    const SHARPNESS2: f64 = 1e12;
    /// Square of the least radius over distance from the origin.
    const SMALLNESS2: f64 = 1e-16;
    /// Below this largest squared edge, products may underflow.
    const TINY: f64 = 1e-60;

    let bc = b.to.cross(c.to);
    let ca = c.to.cross(a.to);
    let ab = a.to.cross(b.to);
    let det = a.to.dot(bc);
    let scale = 0.5 / det;
    let offset = (bc * a.length2 + ca * b.length2 + ab * c.length2) * scale;
    let radius2 = offset.length_squared();
    let center = q + offset;
    let m = if a.length2 > b.length2 { a.length2 } else { b.length2 };
    let m = if m > c.length2 { m } else { c.length2 };
    let certain = det * det * SHARPNESS2 > m * m * m && radius2 > SMALLNESS2 * center.length_squared() && m > TINY;
    (center, if certain { radius2 } else { f64::NAN })
}
