//! The same surface with some edges split in the middle, so that numbers on its vertices can follow what varies along them.
//!
//! M.-C. Rivara, *Algorithms for refining triangular grids suitable for adaptive and multigrid techniques*, International Journal for
//! Numerical Methods in Engineering 20(4), 1984, doi 10.1002/nme.1620200412.
//!
//! 1. Edges that are too long are split, and with any edge of a triangle its longest: without that, splitting a short edge
//!    would make a new long one, and so on without end.
//! 2. The parts of a triangle, by how many of its edges are split:
//!
//! ```text
//!      one edge               two                three
//!         /|\                 /\                  /\
//!        / | \               /  \                /  \
//!       /  |  \             /----\              /----\
//!      /   |   \           / \    \            / \  / \
//!     -----------         -----------         -----------
//! ```

use glam::DVec3;
use rayon::prelude::*;

use super::box_tree::BoxTree;
use super::{Surface, edges};
use crate::geometry::frame::snap;

/// No split.
const NONE: u32 = u32::MAX;

/// Triangles at most: their edges are numbered in 32 bits, and no run needs so many.
const MOST: usize = 1 << 26;

/// Triangles on their way, each with the one of the surface that it is a part of.
struct Split {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    origin: Vec<u32>,
    /// The edges on lines, each with its lower end first, ascending.
    lines: Vec<[u32; 2]>,
}

impl Surface {
    /// This surface with its edges split until `too_long` says of none that it is; the shape stays as it is but for the
    /// rounding of new vertices to the grid of the frame.
    pub(crate) fn refined(&self, too_long: impl Fn(DVec3, DVec3) -> bool + Sync) -> Surface {
        let mut split = Split {
            points: self.points.clone(),
            triangles: self.triangles.clone(),
            origin: (0..self.triangles.len() as u32).collect(),
            lines: self.lines.clone(),
        };
        while split.triangles.len() < MOST && split.halve(&too_long) {}
        let Split { points, triangles, origin, lines } = split;
        let of = |numbers: &[u32]| origin.iter().map(|&t| numbers[t as usize]).collect();
        Surface {
            tree: BoxTree::build(&points, &triangles),
            twins: edges::twins(&triangles),
            source: of(&self.source),
            patch: of(&self.patch),
            shell: of(&self.shell),
            lines,
            shells: self.shells.clone(),
            has_interfaces: self.has_interfaces,
            frame: self.frame,
            notes: self.notes.clone(),
            volume: self.volume,
            area: self.area,
            diagonal: self.diagonal,
            points,
            triangles,
        }
    }
}

impl Split {
    /// Splits each edge that is too long once; whether there were any.
    fn halve(&mut self, too_long: &(impl Fn(DVec3, DVec3) -> bool + Sync)) -> bool {
        let sorted = edges::sorted(&self.triangles);
        let pairs: Vec<_> = sorted.chunks_exact(2).collect();
        // 1.
        let long: Vec<bool> = pairs
            .par_iter()
            .map(|pair| {
                let [p, q] = pair[0].0.map(|v| self.points[v as usize]);
                too_long(p, q)
            })
            .collect();
        let marks = self.with_longest(&pairs, long);
        let mut at_edge = vec![NONE; 3 * self.triangles.len()];
        let (mut any, mut halves) = (false, Vec::new());
        for (pair, _) in pairs.iter().zip(marks).filter(|(_, marked)| *marked) {
            let [p, q] = pair[0].0.map(|v| self.points[v as usize]);
            let middle = snap((p + q) * 0.5);
            if middle != p && middle != q {
                any = true;
                let (end, between) = (pair[0].0, self.points.len() as u32);
                if let Ok(at) = self.lines.binary_search(&end) {
                    halves.push((at, end, between));
                }
                pair.iter().for_each(|e| at_edge[e.1 as usize] = between);
                self.points.push(middle);
            }
        }
        // 2.
        for (at, [lower, upper], between) in halves {
            self.lines[at] = [lower, between];
            self.lines.push([upper, between]);
        }
        self.lines.sort_unstable();
        if any {
            let old = std::mem::take(&mut self.triangles);
            let origins = std::mem::take(&mut self.origin);
            for (t, (corners, origin)) in old.into_iter().zip(origins).enumerate() {
                let middles = [at_edge[3 * t], at_edge[3 * t + 1], at_edge[3 * t + 2]];
                self.push_parts(corners, middles);
                self.origin.resize(self.triangles.len(), origin);
            }
        }
        any
    }

    /// The marks of edges, and of the longest edge of each triangle that has any.
    fn with_longest(&self, pairs: &[&[([u32; 2], u32)]], mut marks: Vec<bool>) -> Vec<bool> {
        let mut pair_of = vec![0u32; 3 * self.triangles.len()];
        for (k, pair) in (0..).zip(pairs) {
            pair.iter().for_each(|e| pair_of[e.1 as usize] = k);
        }
        let length2 = |k: u32| {
            let [p, q] = pairs[k as usize][0].0.map(|v| self.points[v as usize]);
            p.distance_squared(q)
        };
        let longest: Vec<u32> = pair_of
            .chunks_exact(3)
            .map(|e| e.iter().copied().reduce(|a, b| if (length2(b), b) > (length2(a), a) { b } else { a }))
            .map(|e| e.expect("a triangle has edges: this is a bug in tetcvt"))
            .collect();
        let mut todo: Vec<u32> = (0..).zip(&marks).filter(|(_, m)| **m).map(|(k, _)| k).collect();
        while let Some(k) = todo.pop() {
            for e in pairs[k as usize] {
                let longest = longest[e.1 as usize / 3];
                if !std::mem::replace(&mut marks[longest as usize], true) {
                    todo.push(longest);
                }
            }
        }
        marks
    }

    /// The parts of a triangle whose edge i, from corner i to the next, has a vertex in its middle or [`NONE`].
    fn push_parts(&mut self, corners: [u32; 3], middles: [u32; 3]) {
        match middles.iter().filter(|&&m| m != NONE).count() {
            0 => self.triangles.push(corners),
            1 => {
                let i = (0..3).find(|&i| middles[i] != NONE).expect("one is split: this is a bug in tetcvt");
                let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
                self.triangles.extend([[a, middles[i], c], [middles[i], b, c]]);
            }
            2 => {
                // The edge from b to c stays.
                let i = (0..3).find(|&i| middles[i] == NONE).expect("one is not: this is a bug in tetcvt");
                let [b, c, a] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
                let [ca, ab] = [1, 2].map(|k| middles[(i + k) % 3]);
                self.triangles.push([a, ab, ca]);
                let length2 = |u: u32, v: u32| self.points[u as usize].distance_squared(self.points[v as usize]);
                if length2(ab, c) <= length2(b, ca) {
                    self.triangles.extend([[ab, b, c], [ab, c, ca]]);
                } else {
                    self.triangles.extend([[ab, b, ca], [b, c, ca]]);
                }
            }
            _ => {
                let [a, b, c] = corners;
                let [ab, bc, ca] = middles;
                self.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
        }
    }
}
