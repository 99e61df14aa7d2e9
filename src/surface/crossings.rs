//! Finds where a surface crosses, touches or lies on itself.
//!
//! Two triangles of a sound surface meet in nothing, in a common vertex or along a common edge. Steps: 1. for each
//! triangle, in parallel, those whose boxes meet its own, from the box tree; 2. by the number of vertices that the two
//! share, the least that must be asked; every answer is exact.
//!
//! What two triangles have in common beyond shared vertices contains a point of an edge of one of them (T. Moeller, "A
//! Fast Triangle-Triangle Intersection Test", Journal of Graphics Tools 2(2), 1997, doi
//! 10.1080/10867651.1997.10487472; O. Devillers, P. Guigue, "Faster Triangle-Triangle Intersection Tests", INRIA RR-4488,
//! 2002, has it by orientations alone, as here). So all of it comes down to whether an edge meets a triangle, in space or,
//! where the two lie in one plane, in that plane.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::box_tree::BoxTree;
use super::defects::{Defect, Flaw, Marks, Place};
use super::soup::Soup;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::predicates::{Sign, normal_signs, orient2d, orient3d};

/// Refuses a closed, manifold surface that crosses, touches or lies on itself.
pub(super) fn check(soup: &Soup, tree: &BoxTree, marks: &mut Marks) -> Result<(), Defect> {
    let around = |t: u32| BoundingBox::of(&soup.corners(t as usize));
    let meets_any = |t: u32, of: &(dyn Fn(u32) -> bool + Sync)| {
        let bounds = around(t);
        tree.any_near_box(bounds.min, bounds.max, |u| of(u) && meet(soup, t, u))
    };
    let all = || (0..soup.triangles.len() as u32).into_par_iter().with_min_len(256);
    // Each pair once tells whether there is any; only then is every triangle asked.
    if !all().any(|t| meets_any(t, &|u| u > t)) {
        return Ok(());
    }
    let meeting: Vec<u32> = all().filter(|&t| meets_any(t, &|u| u != t)).collect();
    let first = *meeting.first().expect("what one pair found is found again: this is a bug in tetcvt");
    meeting.iter().for_each(|&t| soup.mark_triangle(marks, Flaw::SelfCrossing, t));
    let bounds = around(first);
    let mut other = u32::MAX;
    tree.near_box(bounds.min, bounds.max, |u| {
        if u != first && u < other && meet(soup, first, u) {
            other = u;
        }
    });
    let (a, b) = (soup.corners(first as usize), soup.corners(other as usize));
    let coplanar = b.iter().all(|&p| orient3d(a[0], a[1], a[2], p) == Sign::Zero);
    Err(Defect::SelfCrossing {
        count: meeting.len(),
        place: Place { point: somewhere(soup, first, other).to_array(), face: soup.source[first as usize] },
        other: soup.source[other as usize],
        coplanar,
    })
}

/// Whether two triangles meet beyond the vertices and edges that they share.
fn meet(soup: &Soup, t: u32, u: u32) -> bool {
    let (a, b) = (soup.triangles[t as usize], soup.triangles[u as usize]);
    let shared = a.iter().filter(|v| b.contains(v)).count();
    let at = |v: u32| soup.points[v as usize];
    // Turned so that what is shared comes first, in the order of `a`; the orientation of `b` does not matter.
    let first = |triangle: [u32; 3], of: [u32; 3], wanted: bool| {
        let i = (0..3).find(|&i| of.contains(&triangle[i]) == wanted).unwrap_or(0);
        [triangle[i], triangle[(i + 1) % 3], triangle[(i + 2) % 3]]
    };
    match shared {
        0 => disjoint_meet(a.map(at), b.map(at)),
        1 => {
            let [v, p, q] = first(a, b, true).map(at);
            let [_, r, s] = first(b, a, true).map(at);
            touching_meet(v, [p, q], [r, s])
        }
        2 => {
            let [c, p, q] = first(a, b, false).map(at);
            let d = at(first(b, a, false)[0]);
            // Beside a common edge they meet where they are folded onto each other.
            orient3d(p, q, c, d) == Sign::Zero && normal_signs(p, q, c) == normal_signs(p, q, d)
        }
        // One face twice.
        _ => true,
    }
}

/// Whether two triangles without a common vertex meet.
fn disjoint_meet(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    let above = b.map(|p| orient3d(a[0], a[1], a[2], p));
    if above[0] == above[1] && above[1] == above[2] && above[0] != Sign::Zero {
        return false;
    }
    let below = a.map(|p| orient3d(b[0], b[1], b[2], p));
    if below[0] == below[1] && below[1] == below[2] && below[0] != Sign::Zero {
        return false;
    }
    (0..3).any(|i| {
        let j = (i + 1) % 3;
        edge_meets(a, [b[i], b[j]], [above[i], above[j]]) || edge_meets(b, [a[i], a[j]], [below[i], below[j]])
    })
}

/// Whether triangles (v, p, q) and (v, r, s) meet beyond v: then the edge opposite v of one meets the other.
fn touching_meet(v: DVec3, [p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> bool {
    let above = [r, s].map(|x| orient3d(v, p, q, x));
    if above[0] == above[1] && above[0] != Sign::Zero {
        return false;
    }
    let below = [p, q].map(|x| orient3d(v, r, s, x));
    if below[0] == below[1] && below[0] != Sign::Zero {
        return false;
    }
    edge_meets([v, p, q], [r, s], above) || edge_meets([v, r, s], [p, q], below)
}

/// Whether an edge meets a triangle; `sides` are those of its ends, beside the triangle's plane.
fn edge_meets(triangle: [DVec3; 3], [p, q]: [DVec3; 2], sides: [Sign; 2]) -> bool {
    let [a, b, c] = triangle;
    match sides {
        [Sign::Zero, Sign::Zero] => edge_meets_in_plane(triangle, p, q),
        [Sign::Zero, _] => edge_meets_in_plane(triangle, p, p),
        [_, Sign::Zero] => edge_meets_in_plane(triangle, q, q),
        [s, t] if s == t => false,
        _ => {
            // The line passes the three edges on the same side, or through one of them.
            let turns = [orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a)];
            !(turns.contains(&Sign::Positive) && turns.contains(&Sign::Negative))
        }
    }
}

/// Whether an edge, or a point (p = q), in the plane of a triangle meets it.
fn edge_meets_in_plane([a, b, c]: [DVec3; 3], p: DVec3, q: DVec3) -> bool {
    // A coordinate plane in which the triangle keeps an area.
    let flat: fn(DVec3) -> DVec2 = match normal_signs(a, b, c) {
        [Sign::Zero, Sign::Zero, _] => |p| DVec2::new(p.x, p.y),
        [Sign::Zero, ..] => |p| DVec2::new(p.z, p.x),
        _ => |p| DVec2::new(p.y, p.z),
    };
    let [a, b, c, p, q] = [a, b, c, p, q].map(flat);
    let turn = orient2d(a, b, c);
    let holds = |p| [(a, b), (b, c), (c, a)].iter().all(|&(u, v)| orient2d(u, v, p) != -turn);
    holds(p) || holds(q) || [(a, b), (b, c), (c, a)].iter().any(|&(u, v)| segments_meet(u, v, p, q))
}

/// Whether two segments of the plane meet.
fn segments_meet(a: DVec2, b: DVec2, p: DVec2, q: DVec2) -> bool {
    let (s, t) = (orient2d(a, b, p), orient2d(a, b, q));
    let (u, v) = (orient2d(p, q, a), orient2d(p, q, b));
    if s == Sign::Zero && t == Sign::Zero {
        // On one line: their ranges overlap.
        return a.min(b).cmple(p.max(q)).all() && p.min(q).cmple(a.max(b)).all();
    }
    s != t && u != v
}

/// A point where two triangles meet, rounded, in model coordinates: the mean of where edges pass through planes, or of
/// the two middles.
fn somewhere(soup: &Soup, t: u32, u: u32) -> DVec3 {
    // Halved: the sum of coordinates near the end of the range would overflow.
    let model = |t: u32| soup.triangles[t as usize].map(|v| soup.model[v as usize] * 0.5);
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    let shares = |v: &u32| soup.triangles[t as usize].contains(v) && soup.triangles[u as usize].contains(v);
    for (t, u) in [(t, u), (u, t)] {
        let corners = soup.corners(t as usize);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let (other, ends) = (soup.corners(u as usize), model(u));
        for i in 0..3 {
            let j = (i + 1) % 3;
            let edge = [soup.triangles[u as usize][i], soup.triangles[u as usize][j]];
            let sides = [other[i], other[j]].map(|p| orient3d(corners[0], corners[1], corners[2], p));
            if edge.iter().any(shares) || sides[0] == sides[1] || !edge_meets(corners, [other[i], other[j]], sides) {
                continue;
            }
            let (from, to) = ((other[i] - corners[0]).dot(normal), (other[j] - corners[0]).dot(normal));
            let share = from / (from - to);
            if share.is_finite() {
                sum += ends[i].lerp(ends[j], share.clamp(0.0, 1.0)) * 0.25;
                count += 0.25;
            }
        }
    }
    if count > 0.0 {
        return sum / count * 2.0;
    }
    let middle = |t: u32| model(t).iter().map(|&p| p / 3.0).sum::<DVec3>();
    middle(t) + middle(u)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_in_the_plane() {
        let p = DVec2::new;
        let meet = |a: [f64; 4], b: [f64; 4]| segments_meet(p(a[0], a[1]), p(a[2], a[3]), p(b[0], b[1]), p(b[2], b[3]));
        assert!(meet([0.0, 0.0, 2.0, 2.0], [0.0, 2.0, 2.0, 0.0]));
        assert!(meet([0.0, 0.0, 2.0, 0.0], [1.0, 0.0, 1.0, 5.0]));
        assert!(meet([1.0, 0.0, 1.0, 5.0], [0.0, 0.0, 2.0, 0.0]));
        assert!(meet([0.0, 0.0, 2.0, 0.0], [2.0, 0.0, 3.0, 0.0]));
        assert!(meet([0.0, 0.0, 2.0, 0.0], [2.0, 0.0, 3.0, 7.0]));
        assert!(!meet([0.0, 0.0, 2.0, 0.0], [2.1, 0.0, 3.0, 0.0]));
        assert!(!meet([0.0, 0.0, 2.0, 0.0], [3.0, -1.0, 3.0, 1.0]));
        assert!(!meet([0.0, 0.0, 2.0, 0.0], [1.0, 0.1, 1.0, 1.0]));
    }

    #[test]
    fn triangles_in_space() {
        let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let moved = |x: f64, y: f64, z: f64| a.map(|p| p + DVec3::new(x, y, z));
        assert!(disjoint_meet(a, moved(0.25, 0.25, 0.0)), "in one plane");
        assert!(disjoint_meet(moved(0.25, 0.25, 0.0).map(|p| p * 0.25), a), "one holds the other");
        assert!(disjoint_meet(a, moved(1.0, 0.0, 0.0)), "in a vertex");
        assert!(!disjoint_meet(a, moved(1.0 + 1e-15, 0.0, 0.0)));
        assert!(!disjoint_meet(a, moved(0.0, 0.0, 1e-30)));
        let upright = [DVec3::new(0.2, 0.2, -1.0), DVec3::new(0.2, 0.2, 1.0), DVec3::new(5.0, 5.0, 0.5)];
        assert!(disjoint_meet(a, upright) && disjoint_meet(upright, a));
        let beside = upright.map(|p| p + DVec3::new(0.31, 0.31, 0.0));
        assert!(!disjoint_meet(a, beside) && !disjoint_meet(beside, a));
        let on_it = [DVec3::new(0.2, 0.2, 0.0), DVec3::new(0.2, 0.2, 1.0), DVec3::new(5.0, 5.0, 0.5)];
        assert!(disjoint_meet(a, on_it) && disjoint_meet(on_it, a));
    }
}
