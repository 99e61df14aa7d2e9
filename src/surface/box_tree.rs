//! A box tree over triangles: inside test, closest point, triangles near a box or a ray.
//!
//! The tree is built by `obvhs` (parallel locally-ordered clustering: D. Meister, J. Bittner, "Parallel
//! Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", IEEE TVCG 24(3), 2018,
//! doi 10.1109/TVCG.2017.2669983) in single precision. Departures: boxes are recentred and scaled to [-1, 1] in f64
//! before they are rounded and padded by 2^-20, more than 8 times the rounding of a box and a query together, so that
//! a box never loses what it holds at any offset or scale; leaves decide in f64 on the coordinates as given, inside
//! tests exactly. The traversals are our own. Queries allocate nothing.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;

use super::ray;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::triangle;

/// More than the rounding of a box and of a query to single precision, in the tree's own units.
const PAD: f32 = 1.0 / (1 << 20) as f32;

/// The point of the surface closest to a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The point.
    pub point: DVec3,
    /// The triangle that it lies on.
    pub triangle: u32,
    /// Its squared distance to the query.
    pub distance2: f64,
}

/// A box tree over the triangles of a closed surface.
pub struct BoxTree {
    /// The root is the first; the two children of a node follow each other.
    nodes: Vec<Node>,
    /// Corners of the triangles, in the order of the leaves.
    corners: Vec<[DVec3; 3]>,
    /// For each of them, its index in the list that the tree was built from.
    index: Vec<u32>,
    /// Centre of the tree's own frame.
    center: DVec3,
    /// Its units per unit of the coordinates given.
    scale: f64,
}

/// A node of the tree, 32 bytes.
#[derive(Clone, Copy)]
struct Node {
    min: [f32; 3],
    /// First child of an inner node, first triangle of a leaf.
    first: u32,
    max: [f32; 3],
    /// Number of triangles of a leaf; 0 for inner nodes.
    count: u32,
}

impl Node {
    /// Squared distance of a point to the box, in the tree's units.
    fn distance2(&self, p: [f32; 3]) -> f32 {
        let gap = |i: usize| (self.min[i] - p[i]).max(p[i] - self.max[i]).max(0.0);
        let (x, y, z) = (gap(0), gap(1), gap(2));
        x * x + y * y + z * z
    }

    /// Whether the ray in direction +z meets the box.
    fn below_or_in(&self, p: [f32; 3]) -> bool {
        p[2] <= self.max[2] && self.min[0] <= p[0] && p[0] <= self.max[0] && self.min[1] <= p[1] && p[1] <= self.max[1]
    }

    fn meets(&self, min: [f32; 3], max: [f32; 3]) -> bool {
        (0..3).all(|i| self.min[i] <= max[i] && min[i] <= self.max[i])
    }

    /// Where the ray enters the box, if it does at some t in [0, limit]; all in the tree's units.
    fn entry(&self, origin: DVec3, inverse: DVec3, limit: f64) -> Option<f64> {
        let (mut near, mut far) = (0.0, limit);
        for i in 0..3 {
            let (min, max) = (f64::from(self.min[i]), f64::from(self.max[i]));
            if inverse[i].is_infinite() {
                // The ray does not move along this axis.
                if origin[i] < min || origin[i] > max {
                    return None;
                }
                continue;
            }
            let (t, u) = ((min - origin[i]) * inverse[i], (max - origin[i]) * inverse[i]);
            near = t.min(u).max(near);
            far = t.max(u).min(far);
        }
        (near <= far).then_some(near)
    }
}

impl BoxTree {
    /// Builds the tree; every index of `triangles` is below the number of `points`.
    pub fn build(points: &[DVec3], triangles: &[[u32; 3]]) -> BoxTree {
        let corners: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|v| points[v as usize])).collect();
        let bounds = BoundingBox::of(corners.as_flattened());
        if corners.is_empty() {
            return BoxTree { nodes: vec![], corners, index: vec![], center: DVec3::ZERO, scale: 1.0 };
        }
        let half = (bounds.extent() * 0.5).max_element();
        let scale = if half > 0.0 { 1.0 / half } else { 1.0 };
        let center = bounds.center();
        let boxes: Vec<Aabb> = corners
            .iter()
            .map(|corners| {
                let b = BoundingBox::of(corners);
                let single = |p: DVec3| Vec3A::from(local(p, center, scale));
                Aabb::new(single(b.min) - Vec3A::splat(PAD), single(b.max) + Vec3A::splat(PAD))
            })
            .collect();
        let mut seconds = std::time::Duration::ZERO;
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut seconds);
        let nodes = tree
            .nodes
            .iter()
            .map(|n| Node {
                min: n.aabb().min.to_array(),
                first: n.first_index,
                max: n.aabb().max.to_array(),
                count: n.prim_count,
            })
            .collect();
        let index = tree.primitive_indices;
        let corners = index.iter().map(|&t| corners[t as usize]).collect();
        BoxTree { nodes, corners, index, center, scale }
    }

    /// Whether `p` is inside, by the parity of exact crossings of a ray.
    ///
    /// A point exactly on the surface counts as the point moved by (e, e^2, e^3) for an infinitesimal e > 0 does: of
    /// two solids that share a face, exactly one holds it. A point that is not finite is outside.
    pub fn is_inside(&self, p: DVec3) -> bool {
        let mut inside = false;
        self.crossed_upward(p, |_| inside = !inside);
        inside
    }

    /// Calls `visit` with every triangle that the ray from `p` (perturbed as in [`BoxTree::is_inside`]) in direction
    /// +z crosses, in no particular order.
    pub fn crossed_upward(&self, p: DVec3, mut visit: impl FnMut(u32)) {
        let q = self.local(p);
        let p = ray::flushed(p);
        self.descend(
            |node| node.below_or_in(q),
            |k| {
                if ray::crosses_upward(self.corners[k], p) {
                    visit(self.index[k]);
                }
            },
        );
    }

    /// The closest point of the surface; the lowest triangle index where several are equally close.
    ///
    /// # Panics
    /// If the tree has no triangles, or `p` is not finite.
    pub fn closest(&self, p: DVec3) -> Closest {
        self.closest_below(p, Closest { point: p, triangle: u32::MAX, distance2: f64::INFINITY })
    }

    /// The same as [`BoxTree::closest`], faster if `guess` is a triangle close to `p`, with these corners.
    ///
    /// # Panics
    /// If the tree has no triangles, or `p` is not finite.
    pub fn closest_near(&self, p: DVec3, guess: u32, corners: [DVec3; 3]) -> Closest {
        let point = triangle::closest_point(corners, p);
        self.closest_below(p, Closest { point, triangle: guess, distance2: point.distance_squared(p) })
    }

    /// The closest point, if it is not `best`, one that is known.
    fn closest_below(&self, p: DVec3, mut best: Closest) -> Closest {
        let q = self.local(p);
        // What rounding to single precision can take off a distance, squared; queries may be far away.
        let slack = 1e-12 * (1.0 + f64::from(q[0].abs().max(q[1].abs()).max(q[2].abs()))).powi(2);
        let scale2 = self.scale * self.scale;
        let mut stack = Stack::new();
        stack.push((0.0, 0));
        while let Some((distance2, node)) = stack.pop() {
            // Equal distances must pass: the lowest index is still to be found.
            if f64::from(distance2) > best.distance2 * scale2 * (1.0 + 1e-5) + slack {
                continue;
            }
            let node = &self.nodes[node as usize];
            if node.count == 0 {
                let [left, right] = [node.first, node.first + 1].map(|n| (self.nodes[n as usize].distance2(q), n));
                let (near, far) = if left.0 <= right.0 { (left, right) } else { (right, left) };
                stack.push(far);
                stack.push(near);
                continue;
            }
            for k in node.first as usize..(node.first + node.count) as usize {
                let point = triangle::closest_point(self.corners[k], p);
                let distance2 = point.distance_squared(p);
                let triangle = self.index[k];
                if distance2 < best.distance2 || (distance2 == best.distance2 && triangle < best.triangle) {
                    best = Closest { point, triangle, distance2 };
                }
            }
        }
        assert!(best.triangle != u32::MAX, "closest point to {p} among {} triangles", self.corners.len());
        best
    }

    /// Calls `visit` with every triangle whose box meets the box from `min` to `max`, in no particular order.
    pub fn near_box(&self, min: DVec3, max: DVec3, mut visit: impl FnMut(u32)) {
        let (low, high) = (self.local(min), self.local(max));
        self.descend(
            |node| node.meets(low, high),
            |k| {
                let b = BoundingBox::of(&self.corners[k]);
                if b.min.cmple(max).all() && min.cmple(b.max).all() {
                    visit(self.index[k]);
                }
            },
        );
    }

    /// Whether `is_hit` says so of any triangle whose box meets the box from `min` to `max`; asked in no particular
    /// order, and no longer than until it does.
    pub fn any_near_box(&self, min: DVec3, max: DVec3, mut is_hit: impl FnMut(u32) -> bool) -> bool {
        let (low, high) = (self.local(min), self.local(max));
        let mut stack = Stack::new();
        stack.extend(self.nodes.first().filter(|root| root.meets(low, high)).map(|_| 0u32));
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            for k in node.first as usize..(node.first + node.count) as usize {
                let b = BoundingBox::of(&self.corners[k]);
                if b.min.cmple(max).all() && min.cmple(b.max).all() && is_hit(self.index[k]) {
                    return true;
                }
            }
            if node.count == 0 {
                let children = [node.first, node.first + 1].into_iter();
                children.filter(|&n| self.nodes[n as usize].meets(low, high)).for_each(|n| stack.push(n));
            }
        }
        false
    }

    /// The nearest triangle that the ray from `origin` along `direction` crosses, and how far along it in multiples
    /// of `direction`; none within `limit`. The lowest index where several are crossed at once.
    pub fn ray(&self, origin: DVec3, direction: DVec3, limit: f64) -> Option<(f64, u32)> {
        if self.nodes.is_empty() {
            return None;
        }
        let from = (origin - self.center) * self.scale;
        let inverse = (direction * self.scale).recip();
        let mut best: Option<(f64, u32)> = None;
        let mut reach = limit;
        let mut stack = Stack::new();
        stack.extend(self.nodes[0].entry(from, inverse, reach).map(|t| (t, 0)));
        while let Some((entry, node)) = stack.pop() {
            if entry > reach {
                continue;
            }
            let node = &self.nodes[node as usize];
            if node.count == 0 {
                let child = |n: u32| self.nodes[n as usize].entry(from, inverse, reach).map(|t| (t, n));
                let (left, right) = (child(node.first), child(node.first + 1));
                // The nearer one goes on top.
                let swap = matches!((left, right), (Some(l), Some(r)) if l.0 <= r.0);
                let (first, second) = if swap { (right, left) } else { (left, right) };
                stack.extend(first);
                stack.extend(second);
                continue;
            }
            for k in node.first as usize..(node.first + node.count) as usize {
                let Some(t) = ray::crossing(self.corners[k], origin, direction) else { continue };
                let hit = (t, self.index[k]);
                if t >= 0.0 && t <= limit && best.is_none_or(|b| hit < b) {
                    best = Some(hit);
                    // A box is entered at most a rounding after what it holds is crossed.
                    reach = t + 1e-9 * t.abs();
                }
            }
        }
        best
    }

    /// Calls `leaf` with the position of every triangle in a leaf all of whose ancestors pass `enter`.
    fn descend(&self, mut enter: impl FnMut(&Node) -> bool, mut leaf: impl FnMut(usize)) {
        let mut stack = Stack::new();
        if self.nodes.first().is_some_and(&mut enter) {
            stack.push(0u32);
        }
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            if node.count > 0 {
                (node.first as usize..(node.first + node.count) as usize).for_each(&mut leaf);
                continue;
            }
            for child in [node.first, node.first + 1] {
                if enter(&self.nodes[child as usize]) {
                    stack.push(child);
                }
            }
        }
    }

    /// A point in the tree's own units.
    fn local(&self, p: DVec3) -> [f32; 3] {
        local(p, self.center, self.scale)
    }
}

fn local(p: DVec3, center: DVec3, scale: f64) -> [f32; 3] {
    let q = (p - center) * scale;
    [q.x as f32, q.y as f32, q.z as f32]
}

/// A stack that allocates only for trees deeper than any of a real model.
struct Stack<T> {
    near: [T; 64],
    used: usize,
    beyond: Vec<T>,
}

impl<T: Copy + Default> Stack<T> {
    fn new() -> Stack<T> {
        Stack { near: [T::default(); 64], used: 0, beyond: Vec::new() }
    }

    fn push(&mut self, item: T) {
        if self.used < self.near.len() {
            self.near[self.used] = item;
            self.used += 1;
        } else {
            self.beyond.push(item);
        }
    }

    fn extend(&mut self, item: Option<T>) {
        if let Some(item) = item {
            self.push(item);
        }
    }

    fn pop(&mut self) -> Option<T> {
        if let Some(item) = self.beyond.pop() {
            return Some(item);
        }
        self.used = self.used.checked_sub(1)?;
        Some(self.near[self.used])
    }
}
