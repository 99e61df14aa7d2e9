//! Exact tests of points and vertical rays against triangles.
//!
//! The query of an inside test is taken to be moved by (e, e^2, e^3) for an infinitesimal e > 0 (H. Edelsbrunner,
//! E. P. Muecke, "Simulation of Simplicity", ACM Transactions on Graphics 9(1), 1990, doi 10.1145/77635.77639; here
//! the query alone is perturbed). It is then never on a triangle, and the ray through it never meets an edge or a
//! vertex, so that there is no special case left to count wrong.

use glam::DVec3;
use robust::{Coord, Coord3D};

use crate::geometry::predicates::Sign;

/// Sign of the area of the plane triangle (a, b, c), positive when counter-clockwise; exact.
pub fn orient2d(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Sign {
    let coord = |[x, y]: [f64; 2]| Coord { x, y };
    sign(robust::orient2d(coord(a), coord(b), coord(c)))
}

/// Sign of det[b - a, c - a, d - a]: positive where d sees (a, b, c) counter-clockwise from above; exact.
fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Sign {
    let coord = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    // Shewchuk's sign is the opposite.
    sign(-robust::orient3d(coord(a), coord(b), coord(c), coord(d)))
}

fn sign(x: f64) -> Sign {
    match x {
        x if x > 0.0 => Sign::Positive,
        x if x < 0.0 => Sign::Negative,
        _ => Sign::Zero,
    }
}

/// Whether four points lie in one plane; exact.
pub fn coplanar(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> bool {
    orient3d(a, b, c, d) == Sign::Zero
}

/// Whether three points lie on one line; exact.
pub fn collinear(a: DVec3, b: DVec3, c: DVec3) -> bool {
    normal_signs(a, b, c) == [Sign::Zero; 3]
}

/// Whether c and d, coplanar with a and b and neither on their line, lie on the same side of it; exact.
pub fn same_side(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> bool {
    // Parallel normals agree in the sign of every component that is not zero.
    normal_signs(a, b, c) == normal_signs(a, b, d)
}

/// Signs of the components of (b - a) x (c - a); exact.
fn normal_signs(a: DVec3, b: DVec3, c: DVec3) -> [Sign; 3] {
    let drop = |i: usize| {
        let project = |p: DVec3| [p[(i + 1) % 3], p[(i + 2) % 3]];
        orient2d(project(a), project(b), project(c))
    };
    [drop(0), drop(1), drop(2)]
}

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
    match orient2d([a.x, a.y], [b.x, b.y], [p.x, p.y]) {
        // The derivative of the area by the query's x is a.y - b.y, by its y it is b.x - a.x.
        Sign::Zero if a.y != b.y => sign(a.y - b.y),
        Sign::Zero => sign(b.x - a.x),
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
