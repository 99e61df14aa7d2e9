//! What a seed leaves of a triangle of which it owns one or two corners, where that is seen from the edges at these: nearly
//! always.
//!
//! A cell is convex. From an own corner to one that is another's the edge leaves it at the first of the bisectors that it
//! crosses. The points where the two such edges leave it, the own corners, and where the two bisectors meet, are the corners
//! of the piece, if no further bisector cuts off that meeting: then none cuts the piece at all.

use super::bisector::{Bisector, Meeting};
use crate::geometry::predicates::Sign;

/// The corners of a triangle that are left, and its edges that are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ends {
    /// The first corner of the piece and the second, or the first again where only one is left.
    pub(super) left: [usize; 2],
    /// The next edge on the way around the piece, each from the corner that is left to the one that is not, and the last.
    pub(super) cut: [(usize, usize); 2],
}

/// What cuts such a triangle, by place in the list of bisectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cuts {
    /// One bisector, at both ends.
    Once(usize),
    /// One at the first end, another at the second, and where they meet.
    Twice([usize; 2], Meeting),
}

impl Ends {
    /// For a triangle with some of its corners left, but not all.
    #[inline]
    pub(super) fn new(left: [bool; 3]) -> Option<Ends> {
        let single = match left.iter().filter(|&&l| l).count() {
            1 => true,
            2 => false,
            _ => return None,
        };
        // The corner that stands alone, on either side, and the two after it.
        let alone = left.iter().position(|&l| l == single)?;
        let (next, last) = ((alone + 1) % 3, (alone + 2) % 3);
        Some(if single {
            Ends { left: [alone; 2], cut: [(alone, next), (alone, last)] }
        } else {
            Ends { left: [next, last], cut: [(last, alone), (next, alone)] }
        })
    }

    /// Which of `bisectors`, that may cut the triangle of `view`, do; `None` where that is not certain, or more than these.
    #[inline]
    pub(super) fn cuts(&self, bisectors: &[Bisector]) -> Option<Cuts> {
        let [q, r] = [first(bisectors, self.cut[0])?, first(bisectors, self.cut[1])?];
        if q == r {
            return Some(Cuts::Once(q));
        }
        let (j, k) = (&bisectors[q], &bisectors[r]);
        if !self.meet(j, k)? {
            return None;
        }
        let meeting = j.meeting(k)?;
        let beyond = |(n, l): (usize, &Bisector)| n == q || n == r || meeting.is_left_by(l);
        bisectors.iter().enumerate().all(beyond).then_some(Cuts::Twice([q, r], meeting))
    }

    /// Whether bisectors `j` and `k`, where the piece ends first on its two edges, meet within the triangle.
    fn meet(&self, j: &Bisector, k: &Bisector) -> Option<bool> {
        if self.left[0] != self.left[1] {
            // Each leaves the triangle by the other edge, beyond the other.
            return Some(true);
        }
        let (next, last) = (self.cut[0].1, self.cut[1].1);
        Some(match (j.side(last)?, k.side(next)?) {
            (Sign::Positive, Sign::Positive) => {
                // Where the opposite edge meets the first, going away from the corner that it cuts off.
                j.order_on_edge(k, next, last)? == Sign::Positive
            }
            _ => true,
        })
    }
}

/// The first of `bisectors` that the edge meets on its way `from` a corner that is left to one that is not.
#[inline]
fn first(bisectors: &[Bisector], (from, to): (usize, usize)) -> Option<usize> {
    let mut first: Option<usize> = None;
    for (n, l) in bisectors.iter().enumerate() {
        if l.side(to)? == Sign::Positive {
            continue;
        }
        if l.is_vague_on(from, to) {
            return None;
        }
        first = match first {
            Some(m) if bisectors[m].order_on_edge(l, from, to)? == Sign::Positive => Some(m),
            _ => Some(n),
        };
    }
    first
}
