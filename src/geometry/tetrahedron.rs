//! Tets: volume, circumcentre, dihedral angles, quality.

use glam::DVec3;

/// Six times the signed volume: det[b - a, c - a, d - a].
pub fn volume6(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    (b - a).cross(c - a).dot(d - a)
}
