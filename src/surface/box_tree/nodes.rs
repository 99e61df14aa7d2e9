//! Nodes of four boxes side by side, which one pass of a vector unit tests at once.
//!
//! A binary tree becomes one of four children by opening, in each node, the largest boxes first (H. Dammertz, J. Hanika,
//! A. Keller, "Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays", Computer Graphics Forum
//! 27(4), 2008, doi 10.1111/j.1467-8659.2008.01261.x). Departure: a leaf is one triangle, whose own box is what a query
//! tests before the triangle.

use glam::{BVec4A, DVec3, Vec4};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;

/// Boxes in a node.
const WIDTH: usize = 4;

/// What a box holds: a node, or a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

impl Child {
    /// The node that all others are below.
    pub(super) const ROOT: Child = Child(0);

    /// Nothing.
    const NONE: Child = Child(u32::MAX);

    /// Set for triangles.
    const TRIANGLE: u32 = 1 << 31;

    /// The place of a triangle, or else that of a node.
    pub(super) fn place(self) -> Result<usize, usize> {
        let place = (self.0 & !Child::TRIANGLE) as usize;
        if self.0 & Child::TRIANGLE != 0 { Ok(place) } else { Err(place) }
    }

    /// Its bits.
    pub(super) fn bits(self) -> u32 {
        self.0
    }

    /// The child with these bits.
    pub(super) fn of_bits(bits: u32) -> Child {
        Child(bits)
    }
}

/// Up to four boxes; missing ones are empty, and come last.
#[derive(Clone, Copy)]
pub(super) struct Node {
    min: [Vec4; 3],
    max: [Vec4; 3],
    child: [Child; WIDTH],
}

impl Node {
    const EMPTY: Node = Node { min: [Vec4::INFINITY; 3], max: [Vec4::NEG_INFINITY; 3], child: [Child::NONE; WIDTH] };

    /// What there is, each with what a test says of its box.
    pub(super) fn children<T: Copy>(&self, tests: [T; WIDTH]) -> impl Iterator<Item = (T, Child)> {
        tests.into_iter().zip(self.child).take_while(|c| c.1 != Child::NONE)
    }

    /// What there is within some distance of a point, or less, in the order of distance.
    #[inline(always)]
    pub(super) fn nearer(&self, p: [f32; 3], limit: Reach) -> ([Entry; WIDTH], usize) {
        let mut sum = Vec4::ZERO;
        for (axis, &x) in p.iter().enumerate() {
            let p = Vec4::splat(x);
            let gap = (self.min[axis] - p).max(p - self.max[axis]).max(Vec4::ZERO);
            sum += gap * gap;
        }
        let distances2 = sum.to_array();
        let [a, b, c, d] = std::array::from_fn(|k| Entry::new(distances2[k], self.child[k]));
        let ((a, b), (c, d)) = (a.in_order(b), c.in_order(d));
        let ((a, c), (b, d)) = (a.in_order(c), b.in_order(d));
        let (b, c) = b.in_order(c);
        let entries = [a, b, c, d];
        (entries, entries.iter().map(|e| usize::from(limit.holds(*e))).sum())
    }

    /// Whether the ray in direction +z meets the boxes.
    pub(super) fn below_or_in(&self, p: [f32; 3]) -> [bool; WIDTH] {
        let [x, y, z] = p.map(Vec4::splat);
        let within = |axis: usize, p: Vec4| self.min[axis].cmple(p) & p.cmple(self.max[axis]);
        bools(z.cmple(self.max[2]) & within(0, x) & within(1, y))
    }

    /// Whether a box meets the boxes.
    pub(super) fn meets(&self, min: [f32; 3], max: [f32; 3]) -> [bool; WIDTH] {
        let along =
            |axis: usize| self.min[axis].cmple(Vec4::splat(max[axis])) & Vec4::splat(min[axis]).cmple(self.max[axis]);
        bools(along(0) & along(1) & along(2))
    }

    /// Where a ray enters the boxes, if it does at some t in [0, limit]; all in the tree's units.
    pub(super) fn entries(&self, origin: DVec3, inverse: DVec3, limit: f64) -> [Option<f64>; WIDTH] {
        std::array::from_fn(|k| {
            let (mut near, mut far) = (0.0, limit);
            for axis in 0..3 {
                let (min, max) = (f64::from(self.min[axis][k]), f64::from(self.max[axis][k]));
                if inverse[axis].is_infinite() {
                    // The ray does not move along this axis.
                    if origin[axis] < min || origin[axis] > max {
                        return None;
                    }
                    continue;
                }
                let (t, u) = ((min - origin[axis]) * inverse[axis], (max - origin[axis]) * inverse[axis]);
                near = t.min(u).max(near);
                far = t.max(u).min(far);
            }
            (near <= far).then_some(near)
        })
    }

    /// Puts a box in place `k`.
    fn set(&mut self, k: usize, of: &Bvh2Node, child: Child) {
        let (min, max) = (of.aabb().min.to_array(), of.aabb().max.to_array());
        for axis in 0..3 {
            (self.min[axis][k], self.max[axis][k]) = (min[axis], max[axis]);
        }
        self.child[k] = child;
    }
}

fn bools(mask: BVec4A) -> [bool; WIDTH] {
    std::array::from_fn(|k| mask.bitmask() >> k & 1 == 1)
}

/// A box to be opened, and its squared distance, which orders these: the bits of floating-point numbers from 0 on are ordered
/// as the numbers are.
#[derive(Clone, Copy, Default)]
pub(super) struct Entry(u64);

impl Entry {
    #[inline(always)]
    pub(super) fn new(distance2: f32, child: Child) -> Entry {
        Entry(u64::from(distance2.to_bits()) << 32 | u64::from(child.0))
    }

    #[inline(always)]
    pub(super) fn child(self) -> Child {
        Child(self.0 as u32)
    }

    /// The nearer one first.
    #[inline(always)]
    fn in_order(self, other: Entry) -> (Entry, Entry) {
        (Entry(self.0.min(other.0)), Entry(self.0.max(other.0)))
    }
}

/// A squared distance up to which boxes are opened.
#[derive(Clone, Copy)]
pub(super) struct Reach(u64);

impl Reach {
    /// What is so far, or less; infinity holds everything but [`Child::NONE`].
    #[inline(always)]
    pub(super) fn new(distance2: f32) -> Reach {
        Reach(Entry::new(distance2, Child::NONE).0 - 1)
    }

    #[inline(always)]
    pub(super) fn holds(self, entry: Entry) -> bool {
        entry.0 <= self.0
    }
}

/// The nodes of four that a binary tree with one triangle in each leaf becomes, the root first, and the triangles in the order
/// in which their places count them.
///
/// # Panics
/// If there are no triangles, or several in a leaf.
pub(super) fn collapse(tree: &Bvh2) -> (Vec<Node>, Vec<u32>) {
    let mut nodes = Vec::with_capacity(tree.nodes.len() / 4 + 1);
    let mut triangles = Vec::with_capacity(tree.primitive_indices.len());
    // Nodes of the binary tree to be made nodes, and where their places are to be noted.
    let mut open: Vec<(u32, Option<(usize, usize)>)> = vec![(0, None)];
    while let Some((from, parent)) = open.pop() {
        let place = nodes.len();
        if let Some((above, k)) = parent {
            let above: &mut Node = &mut nodes[above];
            above.child[k] = Child(place as u32);
        }
        let (boxes, count) = largest(tree, from);
        let mut node = Node::EMPTY;
        for (k, &n) in boxes[..count].iter().enumerate() {
            let of = &tree.nodes[n as usize];
            if of.prim_count == 0 {
                node.set(k, of, Child(0));
            } else {
                assert!(of.prim_count == 1, "a leaf holds one triangle: this is a bug in tetcvt");
                node.set(k, of, Child(Child::TRIANGLE | triangles.len() as u32));
                triangles.push(tree.primitive_indices[of.first_index as usize]);
            }
        }
        nodes.push(node);
        // The first child comes next, so that what is near in space is near in memory.
        let inner = (0..count).rev().filter(|&k| tree.nodes[boxes[k] as usize].prim_count == 0);
        open.extend(inner.map(|k| (boxes[k], Some((place, k)))));
    }
    (nodes, triangles)
}

/// Up to four nodes of a binary tree that together hold what `from` holds: of these the largest is opened until there are
/// four.
fn largest(tree: &Bvh2, from: u32) -> ([u32; WIDTH], usize) {
    let (mut boxes, mut count) = ([from; WIDTH], 1);
    while count < WIDTH {
        let inner = (0..count).filter(|&k| tree.nodes[boxes[k] as usize].prim_count == 0);
        let area = |k: usize| tree.nodes[boxes[k] as usize].aabb().half_area();
        let Some(k) = inner.max_by(|&a, &b| area(a).total_cmp(&area(b))) else { break };
        let first = tree.nodes[boxes[k] as usize].first_index;
        (boxes[k], boxes[count]) = (first, first + 1);
        count += 1;
    }
    (boxes, count)
}
