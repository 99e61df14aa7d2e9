//! Whether tets that are all positive fill space once.
//!
//! Positive tets may still overlap: a bipyramid on a pentagon stays positive when the pentagon becomes a pentagram, which
//! winds twice about the axis; and no test of neighbouring tets need find out. But if every facet of the hull has one
//! and the same point o on its inner side, the hull is a covering of the directions at o; if a line through o that
//! meets no edge leaves through one facet on each side, it covers each direction once, and so is a surface without
//! self-crossings; and then the number of tets over any point, all of them positive, is the number of times that the hull
//! winds about it: one inside, none outside. Flips and moves that keep tets positive keep this.
//!
//! So does any motion of which no facet of the hull meets o on the straight way, as the number of times that the hull winds
//! about o is then as before. If the hull was at least r from o, no vertex goes as far as r, and so no facet
//! meets o; and the new hull is farther than r less the longest step. As long as that is positive nothing need be counted.

use glam::DVec3;

use super::facet::INFINITE;
use super::flip::{DEAD, Mesh};
use crate::geometry::predicates::{Sign, orient3d};

/// Lines through o that are tried until one meets no edge.
const LINES: usize = 4;

/// What is known of the hull after a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// If all tets are positive they fill space once.
    Kept,
    /// So too, but with a new point inside.
    Renewed,
    /// Nothing, and there is a new point that may be inside.
    Lost,
}

impl Mesh {
    /// Follows the point inside through a motion from `old`, of which no step was longer than `longest`.
    pub fn guard(&mut self, old: &[DVec3], longest: f64) -> Guard {
        /// Room for rounding.
        const SHORT: f64 = 1.0 - 1e-9;
        if self.room > longest {
            self.room = (self.room - longest) * SHORT;
            return Guard::Kept;
        }
        self.inside = middle(old);
        let facets = self.vertices.iter().filter(|t| t[3] == INFINITE && t[0] != DEAD);
        let depths = facets.map(|&[a, b, c, _]| depth(self.inside, [a, b, c].map(|v| old[v as usize])));
        let room = depths.fold(f64::INFINITY, f64::min);
        // Half of it must be left, lest it be renewed time and again.
        if room > 2.0 * longest {
            self.room = (room - longest) * SHORT;
            return Guard::Renewed;
        }
        self.room = 0.0;
        self.inside = middle(&self.points);
        Guard::Lost
    }

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

/// A point amid points.
fn middle(points: &[DVec3]) -> DVec3 {
    let mean = points.iter().fold(DVec3::ZERO, |sum, &p| sum + p) / points.len() as f64;
    mean.map(super::range::flush)
}

/// How far below a facet of the hull a point is, or less.
fn depth(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    /// Rounding of the quotient, over the largest squared length: the determinant's is below 50 roundings of its cube's root.
    const BOUND: f64 = 1e-13;
    let (u, v, w) = (b - a, c - a, p - a);
    let normal = u.cross(v);
    let size = u.length_squared().max(v.length_squared()).max(w.length_squared());
    let determinant = -w.dot(normal) - BOUND * size * size.sqrt();
    let depth = determinant / (normal.length() + BOUND * size);
    // Not a number where the facet has shrunk to nothing.
    if depth > 0.0 { depth * (1.0 - 1e-9) } else { 0.0 }
}
