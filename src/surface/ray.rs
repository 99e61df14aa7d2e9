//! Exact tests of points and vertical rays against triangles.
//!
//! The query of an inside test is taken to be moved by (e, e^2, e^3) for an infinitesimal e > 0 (H. Edelsbrunner,
//! E. P. Muecke, "Simulation of Simplicity", ACM Transactions on Graphics 9(1), 1990, doi 10.1145/77635.77639; here
//! the query alone is perturbed). It is then never on a triangle, and the ray through it never meets an edge or a
//! vertex, so that there is no special case left to count wrong.

use glam::DVec3;

use crate::geometry::predicates::{Sign, normal_signs, orient2d, orient3d};

/// The query of an inside test, made safe for the predicates.
///
/// They are exact while no coordinate difference is below about 1e-100; what is below 1e-60 becomes 0, which is far
/// below the grid of the frame.
pub fn flushed(p: DVec3) -> DVec3 {
    let flush = |x: f64| if x.abs() < 1e-60 { 0.0 } else { x };
    DVec3::new(flush(p.x), flush(p.y), flush(p.z))
}

/// Whether the ray from p, perturbed, in direction +z crosses the triangle; exact.
pub fn crosses_upward([a, b, c]: [DVec3; 3], p: DVec3) -> bool {
    // The plain box test first: most triangles of a leaf end here.
    if a.z < p.z && b.z < p.z && c.z < p.z {
        return false;
    }
    let turn = side(a, b, p);
    // A triangle that is vertical never has three equal sides: its perturbed areas sum to zero.
    if side(b, c, p) != turn || side(c, a, p) != turn {
        return false;
    }
    let above = match orient3d(a, b, c, p) {
        Sign::Zero => perturbed_height([a, b, c]),
        s => s,
    };
    // p is below the plane where it is on the negative side of a triangle that is counter-clockwise from above.
    above != turn
}

/// On which side of the projected line from a to b the perturbed query lies; zero only if a and b project to a point.
fn side(a: DVec3, b: DVec3, p: DVec3) -> Sign {
    match orient2d(a.truncate(), b.truncate(), p.truncate()) {
        // The derivative of the area by the query's x is a.y - b.y, by its y it is b.x - a.x.
        Sign::Zero if a.y != b.y => Sign::of(a.y - b.y),
        Sign::Zero => Sign::of(b.x - a.x),
        s => s,
    }
}

/// On which side of its plane a query on a triangle comes to lie when it is perturbed.
fn perturbed_height([a, b, c]: [DVec3; 3]) -> Sign {
    let normal = normal_signs(a, b, c);
    normal.into_iter().find(|&s| s != Sign::Zero).unwrap_or(Sign::Zero)
}

/// Where the line `origin + t direction` crosses a triangle, edges and corners included; `None` for parallel ones.
///
/// Neighbours compute the same products for their common edge with opposite signs, so that no line slips between them.
pub fn crossing([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let [p, q, r] = [a - origin, b - origin, c - origin];
    let u = direction.dot(q.cross(r));
    let v = direction.dot(r.cross(p));
    let w = direction.dot(p.cross(q));
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let normal = (b - a).cross(c - a);
    let speed = normal.dot(direction);
    let t = normal.dot(p) / speed;
    // A line within the plane divides by zero.
    t.is_finite().then_some(t)
}
