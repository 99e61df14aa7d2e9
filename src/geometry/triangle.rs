//! Triangles: area, normal, closest point.

use glam::DVec3;

/// Twice the area times the unit normal of triangle (a, b, c).
pub fn normal2(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    (b - a).cross(c - a)
}

/// Area of triangle (a, b, c).
pub fn area(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    0.5 * normal2(a, b, c).length()
}

/// The point of triangle (a, b, c) closest to p; right for triangles without area too.
///
/// The region of p among those of the corners, edges and the face is found by barycentric coordinates (C. Ericson,
/// "Real-Time Collision Detection", 2005, section 5.1.5). Beyond it: the point on an edge does not depend on which of
/// its two triangles asks, and triangles too thin for that arithmetic are decided by their edges.
pub fn closest_point([a, b, c]: [DVec3; 3], p: DVec3) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    // Twice the squared area of the triangle, and the share of it that rounding can hide.
    let normal = ab.cross(ac);
    let longest = ab.length_squared().max(ac.length_squared()).max((c - b).length_squared());
    if normal.length_squared() < 1e-20 * longest * longest {
        return closest_on_edges([a, b, c], p);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return closest_on_segment(a, b, p);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return closest_on_segment(a, c, p);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return closest_on_segment(b, c, p);
    }
    let sum = va + vb + vc;
    if sum > 0.0 { a + ab * (vb / sum) + ac * (vc / sum) } else { closest_on_edges([a, b, c], p) }
}

/// The point of segment ab closest to p; the same bits for ba.
pub fn closest_on_segment(a: DVec3, b: DVec3, p: DVec3) -> DVec3 {
    let swap = (b.x, b.y, b.z) < (a.x, a.y, a.z);
    let (a, b) = if swap { (b, a) } else { (a, b) };
    let along = b - a;
    let length2 = along.length_squared();
    if length2 == 0.0 {
        return a;
    }
    let t = along.dot(p - a) / length2;
    match t {
        t if t <= 0.0 => a,
        t if t >= 1.0 => b,
        t => a + along * t,
    }
}

/// The closest of the points on the three edges.
fn closest_on_edges([a, b, c]: [DVec3; 3], p: DVec3) -> DVec3 {
    let mut best = closest_on_segment(a, b, p);
    for q in [closest_on_segment(b, c, p), closest_on_segment(c, a, p)] {
        if q.distance_squared(p) < best.distance_squared(p) {
            best = q;
        }
    }
    best
}

/// Circumcentre: the centre of the smallest sphere through (a, b, c). Not finite where the three lie on a line.
pub fn circumcenter(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let (u, v) = (b - a, c - a);
    let n = u.cross(v);
    a + (u.length_squared() * v.cross(n) + v.length_squared() * n.cross(u)) / (2.0 * n.length_squared())
}

/// The mean of the corners.
pub fn centroid(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    a + ((b - a) + (c - a)) / 3.0
}

/// A triangle's vertices, turned so that the least comes first: which side is meant is told by their order.
pub fn from_least([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
