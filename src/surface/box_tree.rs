//! A box tree over triangles: inside test, closest point, triangles near a box or a ray.
//!
//! The tree is built by `obvhs` (parallel locally-ordered clustering: D. Meister, J. Bittner, "Parallel
//! Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", IEEE TVCG 24(3), 2018,
//! doi 10.1109/TVCG.2017.2669983) in single precision. Departures: boxes are recentred and scaled to [-1, 1] in f64
//! before they are rounded and padded by 2^-20, more than 8 times the rounding of a box and a query together, so that
//! a box never loses what it holds at any offset or scale; triangles decide in f64 on the coordinates as given, inside
//! tests exactly. The traversals are our own, over nodes of four (`box_tree/nodes.rs`). Queries allocate nothing.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;

use super::ray;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::triangle;

mod nodes;

use nodes::{Child, Entry, Node, Reach};

/// More than the rounding of a box and of a query to single precision, in the tree's own units.
const PAD: f32 = 1.0 / (1 << 20) as f32;

/// How the binary tree is built: with one triangle in each leaf.
const BUILD: BvhBuildParams = BvhBuildParams {
    max_prims_per_leaf: 1,
    post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
    ..BvhBuildParams::fast_build()
};

/// No distance is enough.
const NEVER: f64 = -1.0;

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
    /// The root is the first.
    nodes: Vec<Node>,
    /// Corners of the triangles, in the order of the nodes.
    corners: Vec<[DVec3; 3]>,
    /// For each of them, its index in the list that the tree was built from.
    index: Vec<u32>,
    /// Centre of the tree's own frame.
    center: DVec3,
    /// Its units per unit of the coordinates given.
    scale: f64,
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
        let (nodes, index) = nodes::collapse(&build_bvh2(&boxes, BUILD, &mut seconds));
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
                false
            },
        );
    }

    /// The closest point of the surface; the lowest triangle index where several are equally close.
    ///
    /// # Panics
    /// If the tree has no triangles, or `p` is not finite.
    pub fn closest(&self, p: DVec3) -> Closest {
        self.closest_below(p, Closest { point: p, triangle: u32::MAX, distance2: f64::INFINITY }, NEVER)
    }

    /// The same as [`BoxTree::closest`], faster if `guess` is a triangle close to `p`, with these corners.
    ///
    /// # Panics
    /// If the tree has no triangles, or `p` is not finite.
    pub fn closest_near(&self, p: DVec3, guess: u32, corners: [DVec3; 3]) -> Closest {
        self.closest_below(p, guessed(p, guess, corners), NEVER)
    }

    /// A point whose squared distance is no more than `enough`, faster still than the closest; that one where there is none.
    ///
    /// # Panics
    /// As [`BoxTree::closest_near`].
    pub fn close_enough(&self, p: DVec3, guess: u32, corners: [DVec3; 3], enough: f64) -> Closest {
        let guessed = guessed(p, guess, corners);
        if guessed.distance2 <= enough { guessed } else { self.closest_below(p, guessed, enough) }
    }

    /// The closest point, if it is not `best`, one that is known; or any whose squared distance is `enough`.
    fn closest_below(&self, p: DVec3, mut best: Closest, enough: f64) -> Closest {
        let q = self.local(p);
        // What rounding to single precision can take off a distance, squared; queries may be far away.
        let slack = 1e-12 * (1.0 + f64::from(q[0].abs().max(q[1].abs()).max(q[2].abs()))).powi(2);
        let scale2 = self.scale * self.scale;
        // Equal distances must pass: the lowest index is still to be found.
        let reach = |distance2: f64| Reach::new((distance2 * scale2 * (1.0 + 1e-5) + slack) as f32);
        let mut limit = reach(best.distance2);
        let mut stack = Stack::new();
        stack.extend(self.nodes.first().map(|_| Entry::new(0.0, Child::ROOT)));
        while let Some(entry) = stack.pop() {
            if !limit.holds(entry) {
                continue;
            }
            match entry.child().place() {
                Ok(k) => {
                    let point = triangle::closest_point(self.corners[k], p);
                    let distance2 = point.distance_squared(p);
                    let triangle = self.index[k];
                    if distance2 < best.distance2 || (distance2 == best.distance2 && triangle < best.triangle) {
                        best = Closest { point, triangle, distance2 };
                        if distance2 <= enough {
                            break;
                        }
                        limit = reach(distance2);
                    }
                }
                Err(node) => {
                    // The nearest goes on top.
                    let (entries, count) = self.nodes[node].nearer(q, limit);
                    entries[..count].iter().rev().for_each(|&e| stack.push(e));
                }
            }
        }
        assert!(best.triangle != u32::MAX, "closest point to {p} among {} triangles", self.corners.len());
        best
    }

    /// Calls `visit` with every triangle whose box meets the box from `min` to `max`, in no particular order.
    pub fn near_box(&self, min: DVec3, max: DVec3, mut visit: impl FnMut(u32)) {
        self.any_near_box(min, max, |t| {
            visit(t);
            false
        });
    }

    /// Whether `is_hit` says so of any triangle whose box meets the box from `min` to `max`; asked in no particular
    /// order, and no longer than until it does.
    pub fn any_near_box(&self, min: DVec3, max: DVec3, mut is_hit: impl FnMut(u32) -> bool) -> bool {
        let (low, high) = (self.local(min), self.local(max));
        self.descend(
            |node| node.meets(low, high),
            |k| {
                let b = BoundingBox::of(&self.corners[k]);
                b.min.cmple(max).all() && min.cmple(b.max).all() && is_hit(self.index[k])
            },
        )
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
        stack.push((0.0, Child::ROOT.bits()));
        while let Some((entry, child)) = stack.pop() {
            if entry > reach {
                continue;
            }
            match Child::of_bits(child).place() {
                Err(node) => {
                    // The nearest goes on top.
                    let mut entered = [(0.0, 0); 4];
                    let mut count = 0;
                    let node = &self.nodes[node];
                    for (entry, child) in node.children(node.entries(from, inverse, reach)) {
                        if let Some(entry) = entry {
                            entered[count] = (entry, child.bits());
                            count += 1;
                        }
                    }
                    entered[..count].sort_unstable_by(|a: &(f64, u32), b| b.0.total_cmp(&a.0));
                    entered[..count].iter().for_each(|&e| stack.push(e));
                }
                Ok(k) => {
                    let Some(t) = ray::crossing(self.corners[k], origin, direction) else { continue };
                    let hit = (t, self.index[k]);
                    if t >= 0.0 && t <= limit && best.is_none_or(|b| hit < b) {
                        best = Some(hit);
                        // A box is entered at most a rounding after what it holds is crossed.
                        reach = t + 1e-9 * t.abs();
                    }
                }
            }
        }
        best
    }

    /// Calls `leaf` with the position of every triangle that passes `enter` with all above it, until it says so of one;
    /// whether it did.
    fn descend(&self, enter: impl Fn(&Node) -> [bool; 4], mut leaf: impl FnMut(usize) -> bool) -> bool {
        let mut stack = Stack::new();
        stack.extend(self.nodes.first().map(|_| 0usize));
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node];
            for (entered, child) in node.children(enter(node)) {
                if entered {
                    match child.place() {
                        Ok(k) if leaf(k) => return true,
                        Ok(_) => {}
                        Err(node) => stack.push(node),
                    }
                }
            }
        }
        false
    }

    /// A point in the tree's own units.
    fn local(&self, p: DVec3) -> [f32; 3] {
        local(p, self.center, self.scale)
    }
}

/// The closest point of one triangle.
fn guessed(p: DVec3, triangle: u32, corners: [DVec3; 3]) -> Closest {
    let point = triangle::closest_point(corners, p);
    Closest { point, triangle, distance2: point.distance_squared(p) }
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
