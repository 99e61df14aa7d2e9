//! From the segments around the parts of a Voronoi facet to its faces.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Face, Segment};
use crate::geometry::polygon;

/// Turns to the right by less than this, as a sine, are rounding.
const STRAIGHT: f64 = 1e-9;

/// The faces of all facets, each for the cells on both of its sides. `same` says which point stands for each.
pub(super) fn facets(
    points: &[DVec3],
    seeds: &[DVec3],
    mut segments: Vec<Segment<u32>>,
    same: &[u32],
) -> Vec<Face<u32>> {
    segments.iter_mut().for_each(|s| (s.from, s.to) = (same[s.from as usize], same[s.to as usize]));
    segments.retain(|s| s.from != s.to);
    segments.par_sort_unstable();
    let facets: Vec<&[Segment<u32>]> = segments.chunk_by(|a, b| a.facet == b.facet).collect();
    facets
        .par_iter()
        .flat_map_iter(|around| {
            let [i, j] = around[0].facet;
            let normal = seeds[j as usize] - seeds[i as usize];
            let plane = Plane { points, normal };
            faces(&plane, loops(around)).into_iter().flat_map(move |corners| {
                let turned = corners.iter().rev().copied().collect();
                [Face { seed: i, beyond: j, corners }, Face { seed: j, beyond: i, corners: turned }]
            })
        })
        .collect()
}

/// Chains sorted segments into loops. Segments that cancel are left out.
fn loops(around: &[Segment<u32>]) -> Vec<Vec<u32>> {
    let mut used: Vec<bool> = vec![false; around.len()];
    let all_from = |p: u32| {
        let first = around.partition_point(|s| s.from < p);
        first..first + around[first..].partition_point(|s| s.from == p)
    };
    // There and back again: what merging of points has left of a stretch without a width.
    for k in 0..around.len() {
        let back = all_from(around[k].to).find(|&m| !used[m] && around[m].to == around[k].from);
        if let (false, Some(back)) = (used[k], back) {
            (used[k], used[back]) = (true, true);
        }
    }
    let mut found = Vec::new();
    for start in 0..around.len() {
        if used[start] {
            continue;
        }
        let mut corners = Vec::new();
        let mut next = Some(start);
        while let Some(k) = next {
            used[k] = true;
            corners.push(around[k].from);
            next = if around[k].to == around[start].from { None } else { all_from(around[k].to).find(|&m| !used[m]) };
        }
        if corners.len() >= 3 {
            found.push(corners);
        }
    }
    found
}

/// The plane of a facet, seen against its normal.
struct Plane<'a> {
    points: &'a [DVec3],
    normal: DVec3,
}

impl Plane<'_> {
    /// Two coordinates in the plane: turns are as the normal has them.
    fn flat(&self, p: u32) -> DVec2 {
        let (at, n) = (self.points[p as usize], self.normal);
        let size = n.abs();
        let (x, y, sign) = if size.x >= size.y && size.x >= size.z {
            (at.y, at.z, n.x)
        } else if size.y >= size.z {
            (at.z, at.x, n.y)
        } else {
            (at.x, at.y, n.z)
        };
        if sign < 0.0 { DVec2::new(y, x) } else { DVec2::new(x, y) }
    }

    /// Twice the signed area of a loop.
    fn area2(&self, corners: &[u32]) -> f64 {
        let origin = self.flat(corners[0]);
        let way = |p: u32| self.flat(p) - origin;
        corners.windows(2).map(|e| way(e[0]).perp_dot(way(e[1]))).sum()
    }

    fn is_convex(&self, corners: &[u32]) -> bool {
        let n = corners.len();
        (0..n).all(|m| {
            let [a, b, c] = [0, 1, 2].map(|k| self.flat(corners[(m + k) % n]));
            let (u, v) = (b - a, c - b);
            u.perp_dot(v) >= -STRAIGHT * u.length() * v.length()
        })
    }
}

/// The faces that loops bound: outer ones turn to the left, holes to the right.
fn faces(plane: &Plane, loops: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    let (mut outer, mut holes): (Vec<_>, Vec<_>) = loops.into_iter().partition(|l| plane.area2(l) >= 0.0);
    if outer.is_empty() {
        // Parts without an area, which rounding has turned over.
        std::mem::swap(&mut outer, &mut holes);
    }
    // From the right, so that what a hole is joined to is to its right.
    let rightmost =
        |l: &[u32]| (0..l.len()).max_by(|&a, &b| plane.flat(l[a]).x.total_cmp(&plane.flat(l[b]).x)).unwrap_or(0);
    holes.sort_by(|a, b| plane.flat(b[rightmost(b)]).x.total_cmp(&plane.flat(a[rightmost(a)]).x));
    for hole in holes {
        let from = rightmost(&hole);
        let at = plane.flat(hole[from]);
        let around = (0..outer.len()).filter(|&o| is_inside(plane, &outer[o], at));
        let smallest = around.min_by(|&a, &b| plane.area2(&outer[a]).total_cmp(&plane.area2(&outer[b])));
        let around = &mut outer[smallest.unwrap_or(0)];
        let to = bridge(plane, around, &hole, from);
        let joined = hole[from..].iter().chain(&hole[..=from]).copied();
        let tail = around[to..].to_vec();
        around.truncate(to + 1);
        around.extend(joined);
        around.extend(tail);
    }
    outer.into_iter().flat_map(|corners| convex_parts(plane, corners)).collect()
}

/// Whether a loop goes round a point, by the crossings of a ray.
fn is_inside(plane: &Plane, corners: &[u32], at: DVec2) -> bool {
    let n = corners.len();
    let crosses = |&m: &usize| {
        let (a, b) = (plane.flat(corners[m]), plane.flat(corners[(m + 1) % n]));
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (b.x - a.x) * ((at.y - a.y) / (b.y - a.y))
    };
    (0..n).filter(crosses).count() % 2 == 1
}

/// The closest corner of `around` that corner `from` of `hole` sees; simply the closest where it sees none.
fn bridge(plane: &Plane, around: &[u32], hole: &[u32], from: usize) -> usize {
    let at = plane.flat(hole[from]);
    let mut order: Vec<usize> = (0..around.len()).collect();
    let distance = |k: usize| plane.flat(around[k]).distance_squared(at);
    order.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let blocks = |to: DVec2, corners: &[u32]| {
        let n = corners.len();
        (0..n).any(|m| {
            let (a, b) = (plane.flat(corners[m]), plane.flat(corners[(m + 1) % n]));
            let side = |u: DVec2, v: DVec2, p: DVec2| (v - u).perp_dot(p - u);
            let apart = |x: f64, y: f64| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
            apart(side(at, to, a), side(at, to, b)) && apart(side(a, b, at), side(a, b, to))
        })
    };
    let seen = order.iter().copied().find(|&k| {
        let to = plane.flat(around[k]);
        !blocks(to, around) && !blocks(to, hole)
    });
    seen.or(order.first().copied()).unwrap_or(0)
}

/// The loop itself where it is convex, else triangles.
fn convex_parts(plane: &Plane, corners: Vec<u32>) -> Vec<Vec<u32>> {
    if corners.len() == 3 || plane.is_convex(&corners) {
        return vec![corners];
    }
    let at: Vec<DVec3> = corners.iter().map(|&p| plane.points[p as usize]).collect();
    let cut = polygon::cut(&at);
    cut.triangles.iter().map(|t| t.map(|k| corners[k]).to_vec()).collect()
}
