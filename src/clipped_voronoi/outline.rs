//! What a seed leaves of a triangle of which it owns one or two corners, where that is seen from the edges at these: nearly
//! always.
//!
//! ```text
//!         0                   0, cut off       One corner of the triangle, 0, stands alone. With it alone the piece is
//!        / \                  / \              (0, Q, R), with the other two it is (R', Q', Q, R); Q is on the edge
//!   Q --/---\-- R        R --/---\-- Q        from 0 to Q', R on that to R'. Where the two are on different
//!      /     \              /     \           bisectors, these meet in between, or leave some of the edge from Q' to R'.
//!     Q'------R'           R'------Q'
//! ```
//!
//! A cell is convex. From an own corner to one that is another's the edge leaves it at the first of the bisectors that it
//! crosses. The points where the two such edges leave it, the own corners, and where the two bisectors meet, are the corners
//! of the piece, if no further bisector cuts off that meeting: then none cuts the piece at all.

use super::bisector::{Form, Meeting};
use super::planes::{Planes, Seen};
use crate::geometry::predicates::Sign;

/// A triangle of which some corners are left, but not all: numbers of its corners from the one that stands alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Outline {
    /// The corner alone on its side, and those to which the edges with Q and R lead from it.
    pub(super) corners: [usize; 3],
    /// Whether it is the one that is left.
    pub(super) single: bool,
}

/// What cuts such a triangle: neighbours of the seed, by their places in the list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cuts {
    /// One bisector, at both ends.
    Once(usize, Form),
    /// One at Q, another at R, and where they meet.
    Twice([usize; 2], [Form; 2], Meeting),
    /// One at Q, another at R, which leave part of the edge between the other two corners.
    Apart([usize; 2], [Form; 2]),
}

/// Where edges leave the cell: two triangles of a seed share each of them.
pub(super) struct Exits {
    /// The number of the seed among those that were gone through.
    round: u32,
    /// By a hash of the edge: the round, the places of its ends, and the first bisector on the way if that is certain.
    table: Vec<(u32, [usize; 2], Option<usize>)>,
}

/// Edges that are remembered.
const EXITS: usize = 128;

impl Default for Exits {
    fn default() -> Exits {
        Exits { round: 0, table: vec![(0, [0; 2], None); EXITS] }
    }
}

impl Exits {
    /// Forgets all edges: the next are those of another seed.
    pub(super) fn clear(&mut self) {
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            *self = Exits { round: 1, ..Exits::default() };
        }
    }

    /// What leaves the cell by this edge first, as found before or now.
    #[inline]
    fn of(&mut self, edge: [usize; 2], find: impl FnOnce() -> Option<usize>) -> Option<usize> {
        let known = &mut self.table[(edge[0] * 11 + edge[1]) % EXITS];
        if (known.0, known.1) != (self.round, edge) {
            *known = (self.round, edge, find());
        }
        known.2
    }
}

impl Outline {
    /// For a triangle with such corners, counter-clockwise, and those of them left.
    #[inline]
    pub(super) fn new(corners: [usize; 3], left: [bool; 3]) -> Option<Outline> {
        let [a, b, c] = corners;
        Some(match left {
            [true, false, false] => Outline { corners: [a, b, c], single: true },
            [false, true, false] => Outline { corners: [b, c, a], single: true },
            [false, false, true] => Outline { corners: [c, a, b], single: true },
            [false, true, true] => Outline { corners: [a, c, b], single: false },
            [true, false, true] => Outline { corners: [b, a, c], single: false },
            [true, true, false] => Outline { corners: [c, b, a], single: false },
            _ => return None,
        })
    }

    /// What cuts the triangle; `None` where that is not certain, or more than these.
    #[inline]
    pub(super) fn cuts(&self, planes: &Planes, exits: &mut Exits) -> Option<Cuts> {
        let seen = planes.on_triangle(self.corners)?;
        let q = self.exit(&seen, 1, exits)?;
        let r = self.exit(&seen, 2, exits)?;
        let (j, k) = (seen.form(q), seen.form(r));
        if q == r {
            return Some(Cuts::Once(q, j));
        }
        let others = || seen.doubtful().filter(|&l| l != q && l != r).map(|l| seen.form(l));
        if self.meet(&j, &k)? {
            let meeting = j.meeting(&k)?;
            return others().all(|l| meeting.is_left_by(&l)).then_some(Cuts::Twice([q, r], [j, k], meeting));
        }
        let clear = !j.is_vague_on(1, 2) && !k.is_vague_on(2, 1);
        let left = |l: Form| {
            j.order_on_edge(&l, 1, 2) == Some(Sign::Negative) && k.order_on_edge(&l, 2, 1) == Some(Sign::Negative)
        };
        (clear && others().all(left)).then_some(Cuts::Apart([q, r], [j, k]))
    }

    /// The first bisector that the edge between corners 0 and `end` meets on its way from the one that is left.
    #[inline]
    fn exit(&self, seen: &Seen, end: usize, exits: &mut Exits) -> Option<usize> {
        let (from, to) = if self.single { (0, end) } else { (end, 0) };
        exits.of([self.corners[from], self.corners[to]], || first(seen, from, to))
    }

    /// Whether bisectors `j` and `k`, on which Q and R are, meet within the triangle.
    #[inline]
    fn meet(&self, j: &Form, k: &Form) -> Option<bool> {
        if !self.single {
            // Each leaves the triangle by the other's edge, beyond the other.
            return Some(true);
        }
        Some(match (j.side(2)?, k.side(1)?) {
            // Where the opposite edge meets the first, going away from the corner that it cuts off.
            (Sign::Positive, Sign::Positive) => j.order_on_edge(k, 1, 2)? == Sign::Positive,
            _ => true,
        })
    }
}

/// The first bisector that the edge between two corners of a triangle meets, where that is certain.
#[inline]
fn first(seen: &Seen, from: usize, to: usize) -> Option<usize> {
    let mut first: Option<(usize, Form)> = None;
    for l in seen.doubtful_at(to) {
        let form = seen.form(l);
        if form.side(to)? == Sign::Positive {
            continue;
        }
        if form.is_vague_on(from, to) {
            return None;
        }
        first = match first {
            Some((_, other)) if other.order_on_edge(&form, from, to)? == Sign::Positive => first,
            _ => Some((l, form)),
        };
    }
    first.map(|(l, _)| l)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::frame::snap;
    use crate::rng::Rng;

    #[test]
    fn pieces_are_those_that_points_of_the_triangle_say() {
        let mut rng = Rng::new(5, 0);
        let (mut seen, mut exits) = ([0; 3], Exits::default());
        for _ in 0..20_000 {
            let mut point = |size: f64| snap(DVec3::from_array([0; 3].map(|_| (rng.unit() - 0.5) * size)));
            let corners = [0; 3].map(|_| point(0.5));
            let (seed, others) = (point(0.4), [0; 5].map(|_| point(0.4)));
            let nearest = |p: DVec3| {
                let nearer = |k: &usize| p.distance_squared(others[*k]) < p.distance_squared(seed);
                (0..others.len())
                    .filter(nearer)
                    .min_by(|&a, &b| p.distance_squared(others[a]).total_cmp(&p.distance_squared(others[b])))
            };
            let Some(outline) = Outline::new([0, 1, 2], corners.map(|p| nearest(p).is_none())) else { continue };
            let mut planes = Planes::default();
            planes.set(pulp::Arch::new(), seed, &[0, 1, 2, 3, 4], &others, corners.into_iter());
            exits.clear();
            let Some(cuts) = outline.cuts(&planes, &mut exits) else { continue };
            let (kind, by) = match cuts {
                Cuts::Once(j, _) => (0, vec![j]),
                Cuts::Twice(both, ..) => (1, both.to_vec()),
                Cuts::Apart(both, _) => (2, both.to_vec()),
            };
            seen[kind] += 1;
            // A point is left where the bisectors found say so, whatever the others say.
            for _ in 0..20 {
                let [a, b] = [rng.unit(), rng.unit()];
                let [a, b] = if a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] };
                let p = corners[0] + (corners[1] - corners[0]) * a + (corners[2] - corners[0]) * b;
                let left = by.iter().all(|&j| p.distance_squared(others[j]) > p.distance_squared(seed));
                assert_eq!(left, nearest(p).is_none(), "{cuts:?}");
            }
        }
        assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
    }
}
