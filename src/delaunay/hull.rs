//! Whether tets that are all positive fill space once.
//!
//! Positive tets may still overlap: a bipyramid on a pentagon stays positive when the pentagon becomes a pentagram, which
//! winds twice about the axis; and no test of neighbouring tets need find out. But if every facet of the hull has one
//! and the same point o on its inner side, the hull is a covering of the directions at o; if a line through o that
//! meets no edge leaves through one facet on each side, it covers each direction once, and so is a surface without
//! self-crossings; and then the number of tets over any point, all of them positive, is the number of times that the hull
//! winds about it: one inside, none outside. Flips and moves that keep tets positive keep this.

use super::facet::INFINITE;
use super::flip::Mesh;
use crate::geometry::predicates::{Sign, orient3d};

/// Lines through o that are tried until one meets no edge.
const LINES: usize = 4;

impl Mesh {
    /// Whether the tets, which are all positive, fill space once. May say no for want of a line that meets no edge.
    pub fn fills_space_once(&self, infinite: &[u32]) -> bool {
        (0..LINES).find_map(|n| self.leaves_once(infinite, n)).unwrap_or(false)
    }

    /// Whether line `n` leaves the hull through one facet on each side; none if it meets an edge.
    fn leaves_once(&self, infinite: &[u32], n: usize) -> Option<bool> {
        // A point of the hull, far enough from any plane of few points.
        let count = self.points.len();
        let pick = |part: usize| self.points[(part + 2 * n) * (count - 1) / 16];
        let to = (pick(1) * 0.4375 + pick(5) * 0.3125) + pick(9) * 0.25;
        let to = to.map(super::range::flush);
        let o = self.inside;
        let mut passed = [0, 0];
        for &t in infinite {
            let [a, b, c, d] = self.vertices[t as usize];
            debug_assert_eq!(d, INFINITE);
            let side = |p: u32, q: u32| orient3d(o, to, self.at(p), self.at(q));
            let first = side(a, b);
            if first == Sign::Zero {
                return None;
            }
            let second = side(b, c);
            if second != first {
                if second == Sign::Zero {
                    return None;
                }
                continue;
            }
            match side(c, a) {
                Sign::Zero => return None,
                third if third == first => passed[usize::from(third == Sign::Positive)] += 1,
                _ => {}
            }
        }
        Some(passed == [1, 1])
    }
}
