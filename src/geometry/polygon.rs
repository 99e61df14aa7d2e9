//! Cuts polygons into triangles.
//!
//! A polygon whose triangles around its first corner all turn the same way becomes that fan; any other is cut by ears
//! (G. H. Meisters, "Polygons have ears", American Mathematical Monthly 82(6), 1975, doi 10.2307/2319703), the
//! best-shaped ear first so that collinear corners end in triangles with an area where there are any. The polygon is
//! seen along its normal (M. E. Newell's sum over the edges); signs in that plane are exact.

use glam::{DVec2, DVec3};

use super::predicates::{Sign, orient2d};

/// Triangles over the corners 0 to n - 1 of a polygon, and whether they are sure not to fold.
pub struct Cut {
    /// Triangles, turning as the polygon does.
    pub triangles: Vec<[usize; 3]>,
    /// False where no ear was left (the polygon crosses itself or has no area) and the rest was fanned.
    pub proper: bool,
}

/// Cuts a polygon of at least 3 corners.
pub fn cut(corners: &[DVec3]) -> Cut {
    let fan = |ids: &[usize]| ids[1..].windows(2).map(|w| [ids[0], w[0], w[1]]).collect::<Vec<_>>();
    let mut ids: Vec<usize> = (0..corners.len()).collect();
    if corners.len() == 3 {
        return Cut { triangles: fan(&ids), proper: true };
    }
    let plane = flatten(corners);
    if fan(&ids).iter().all(|&[a, b, c]| is_left(plane[a], plane[b], plane[c]) && shape(&plane, [a, b, c]) > 1e-12) {
        return Cut { triangles: fan(&ids), proper: true };
    }
    let mut triangles = vec![];
    while ids.len() > 3 {
        let Some(i) = best_ear(&plane, &ids) else {
            triangles.extend(fan(&ids));
            return Cut { triangles, proper: false };
        };
        triangles.push(neighbors(&ids, i));
        ids.remove(i);
    }
    let [a, b, c] = [ids[0], ids[1], ids[2]];
    triangles.push([a, b, c]);
    Cut { triangles, proper: is_left(plane[a], plane[b], plane[c]) }
}

/// The corners in the plane across the polygon's normal, about 1 in size; turning counter-clockwise.
fn flatten(corners: &[DVec3]) -> Vec<DVec2> {
    // Scaled first: coordinates may be near either end of the range of f64.
    let reach = corners.iter().map(|&p| (p * 0.5 - corners[0] * 0.5).abs().max_element()).fold(0.0, f64::max);
    let reach = if reach > 0.0 { reach } else { 1.0 };
    let points: Vec<DVec3> = corners.iter().map(|&p| (p * 0.5 - corners[0] * 0.5) / reach).collect();
    let mut normal = DVec3::ZERO;
    for (i, &p) in points.iter().enumerate() {
        normal += p.cross(points[(i + 1) % points.len()]);
    }
    // Dropping the normal's largest coordinate keeps the others exact; rotation would round them.
    let size = normal.abs();
    let (x, y, sign) = if size.x >= size.y && size.x >= size.z {
        (1, 2, normal.x)
    } else if size.y >= size.z {
        (2, 0, normal.y)
    } else {
        (0, 1, normal.z)
    };
    points.iter().map(|p| if sign < 0.0 { DVec2::new(p[y], p[x]) } else { DVec2::new(p[x], p[y]) }).collect()
}

/// Whether the corner b turns left.
fn is_left(a: DVec2, b: DVec2, c: DVec2) -> bool {
    orient2d(a, b, c) == Sign::Positive
}

/// Twice the area over the square of the longest edge.
fn shape(plane: &[DVec2], triangle: [usize; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| plane[v]);
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).perp_dot(c - a) / longest
}

fn neighbors(ids: &[usize], i: usize) -> [usize; 3] {
    let n = ids.len();
    [ids[(i + n - 1) % n], ids[i], ids[(i + 1) % n]]
}

/// The position in `ids` of the ear with the best shape: a corner that turns left, with no other in its triangle.
fn best_ear(plane: &[DVec2], ids: &[usize]) -> Option<usize> {
    let mut best: Option<(f64, usize)> = None;
    for i in 0..ids.len() {
        let ear = neighbors(ids, i);
        let [a, b, c] = ear.map(|v| plane[v]);
        if !is_left(a, b, c) {
            continue;
        }
        let shape = shape(plane, ear);
        // Corners in the same place as one of the ear's own do not stand in its way.
        let inside = |p: DVec2| {
            p != a && p != b && p != c && [(a, b), (b, c), (c, a)].iter().all(|&(u, v)| orient2d(u, v, p) >= Sign::Zero)
        };
        let better = best.is_none_or(|b| shape > b.0);
        if better && !ids.iter().any(|&v| inside(plane[v])) {
            best = Some((shape, i));
            // In a polygon of very many corners the first good ear must do, or cutting would take cubic time.
            if ids.len() > 256 && shape > 1e-6 {
                break;
            }
        }
    }
    best.map(|b| b.1)
}
