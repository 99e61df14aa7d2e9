//! Triangles: area, normal, closest point.

use glam::DVec3;

/// Twice the area times the unit normal of triangle (a, b, c).
pub fn normal2(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    (b - a).cross(c - a)
}
