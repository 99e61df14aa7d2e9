//! Bisectors of a seed seen on one triangle of the surface, and the exact signs that clip it.
//!
//! On triangle (u, v, w) the bisector of seeds i and j is the linear form d_ij(x) = |x - x_j|^2 - |x - x_i|^2, positive
//! where i is closer; its values at the three corners say everything about it. A vertex of a clipped polygon lies on two
//! lines, and on which side of a third bisector it is, is the sign of a small determinant of such values:
//!
//! | vertex | lines | sign of d_il there |
//! |---|---|---|
//! | corner u | two edges | d_il(u) |
//! | on edge u v | edge and i\|j | (d_ij(u) d_il(v) - d_ij(v) d_il(u)) (d_ij(u) - d_ij(v)) |
//! | within | i\|j and i\|k | det(d_ij, d_ik, d_il) det(d_ij, d_ik, 1) |
//!
//! Each is computed in floating point with a bound on its error, and exactly where that does not decide. Zeros are
//! resolved as in the Delaunay kernel: the squared distance to seed a is raised by an infinitesimal, larger for points
//! that come later in lexicographic order and of another order of magnitude for each. The clipped cells are then cells of
//! one and the same perturbed diagram, dual to the kernel's triangulation, on every triangle of the surface: no case is
//! degenerate, and what neighbouring triangles and neighbouring cells say of a common point always agrees.

use std::cmp::Ordering;

use glam::DVec3;

use super::expansion::Expansion;
use crate::geometry::predicates::{Sign, lexicographic};
use crate::geometry::triples::{cross, dot};

/// Half the distance from 1 to the next `f64`.
const UNIT: f64 = f64::EPSILON / 2.0;

/// Above this share of the sizes of three bisectors the determinant of their values has its sign: six products of three values
/// with 4 units of error each, two roundings each and the sums, below 6 * 18.
const WITHIN: f64 = 120.0 * UNIT;

/// Differences below this share of their terms leave too few digits for a position, which is then computed exactly.
pub(super) const VAGUE: f64 = 1e-4;

/// d_ij on the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Form {
    /// Its values at the three corners.
    pub(super) d: [f64; 3],
    /// Bound on the size of these and of the terms that they are sums of.
    pub(super) size: f64,
}

/// The bisector of the cell's seed and another, on one triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bisector {
    /// The other seed.
    pub(super) seed: u32,
    /// Its position.
    pub(super) at: DVec3,
    pub(super) form: Form,
}

/// A triangle of the surface as the cell of one seed sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// Corners of the triangle, on the frame's grid.
    pub(super) corners: [DVec3; 3],
    /// The cell's seed, on the frame's grid.
    pub(super) seed: DVec3,
}

impl Form {
    /// Side of corner `c`: positive where the cell's seed is closer; `None` where rounding leaves that open.
    #[inline]
    pub(super) fn side(&self, c: usize) -> Option<Sign> {
        // One rounding in `twice`, one in each product, two in the sum: 4 units of each term.
        (self.d[c].abs() > 5.0 * UNIT * self.size).then(|| Sign::of(self.d[c]))
    }

    /// Whether it runs nearly along an edge that it meets, so that where needs exact arithmetic.
    #[inline]
    pub(super) fn is_vague_on(&self, u: usize, v: usize) -> bool {
        (self.d[u] - self.d[v]).abs() < VAGUE * self.size
    }

    /// The sign of d_ij(u) d_il(v) - d_ij(v) d_il(u), with this as j; `None` where rounding leaves that open.
    #[inline]
    pub(super) fn order_on_edge(&self, l: &Form, u: usize, v: usize) -> Option<Sign> {
        let det = self.d[u] * l.d[v] - self.d[v] * l.d[u];
        // Two products of values with 4 units of error each, one rounding each and one of the difference: below 2 * 10.
        (det.abs() > 24.0 * UNIT * self.size * l.size).then(|| Sign::of(det))
    }

    /// The same with the corners in another order.
    #[inline]
    pub(super) fn reordered(&self, corners: [usize; 3]) -> Form {
        Form { d: corners.map(|c| self.d[c]), size: self.size }
    }

    /// Where it meets another; `None` where there are too few digits.
    #[inline]
    pub(super) fn meeting(&self, k: &Form) -> Option<Meeting> {
        let minors = cross(self.d, k.d);
        let meeting = Meeting { minors, sum: minors.iter().sum(), size: self.size * k.size };
        (meeting.sum.abs() >= VAGUE * meeting.size).then_some(meeting)
    }
}

/// Where two bisectors, j and k, meet in the plane of the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    /// Barycentric coordinates, times their sum.
    minors: [f64; 3],
    /// That sum: det(d_ij, d_ik, 1).
    sum: f64,
    /// Bound on the size of products of the two.
    size: f64,
}

impl Meeting {
    /// Whether det(d_ij, d_ik, 1) is positive: see [`View::turn`], of which it is certain, as there are digits enough.
    #[inline]
    pub(super) fn turns(&self) -> bool {
        self.sum > 0.0
    }

    /// Whether it is certain that the cell's seed is closer there than that of a third bisector.
    #[inline]
    pub(super) fn is_left_by(&self, l: &Form) -> bool {
        let det = dot(self.minors, l.d);
        det.abs() > WITHIN * self.size * l.size && (det > 0.0) == (self.sum > 0.0)
    }

    /// The point, within a triangle with these corners: what rounding puts outside is brought back.
    #[inline]
    pub(super) fn within(&self, corners: [DVec3; 3]) -> DVec3 {
        within(self.minors, corners)
    }
}

/// The point with such barycentric coordinates, up to a factor, in a triangle that it is known to be in: what rounding puts
/// outside is brought back.
#[inline]
fn within(weights: [f64; 3], corners: [DVec3; 3]) -> DVec3 {
    let sum: f64 = weights.iter().sum();
    let inside = weights.map(|w| (w / sum).max(0.0));
    let total: f64 = inside.iter().sum();
    let [_, b, c] = if total.is_finite() { inside.map(|w| w / total) } else { [1.0 / 3.0; 3] };
    corners[0] + (corners[1] - corners[0]) * b + (corners[2] - corners[0]) * c
}

impl View {
    /// The bisector with another seed at `at`.
    pub(super) fn bisector(&self, seed: u32, at: DVec3) -> Bisector {
        let apart = self.seed - at;
        let (mut d, mut size) = ([0.0; 3], 0.0);
        for (value, corner) in d.iter_mut().zip(self.corners) {
            let twice = (corner - self.seed) + (corner - at);
            *value = apart.dot(twice);
            let bound = apart.abs().dot(twice.abs());
            size = if bound > size { bound } else { size };
        }
        Bisector { seed, at, form: Form { d, size } }
    }

    /// Side of corner `c`: positive where the cell's seed is closer.
    #[inline]
    pub(super) fn side_of_corner(&self, c: usize, l: &Bisector) -> Sign {
        if let Some(sign) = l.form.side(c) {
            return sign;
        }
        match self.exact(l, c).sign() {
            Sign::Zero if later(l.at, self.seed) => Sign::Positive,
            Sign::Zero => Sign::Negative,
            sign => sign,
        }
    }

    /// Side of the point where the edge from corner `u` to corner `v` meets bisector `j`, against bisector `l`.
    pub(super) fn side_on_edge(&self, u: usize, v: usize, j: &Bisector, l: &Bisector) -> Sign {
        // The edge meets bisector j, so that d_ij has different signs at its ends and the difference that of the first.
        let along = self.side_of_corner(u, j);
        if let Some(sign) = j.form.order_on_edge(&l.form, u, v) {
            return times(sign, along);
        }
        let [ju, jv, lu, lv] = [self.exact(j, u), self.exact(j, v), self.exact(l, u), self.exact(l, v)];
        let exact = ju.times(&lv).minus(&jv.times(&lu)).sign();
        if exact != Sign::Zero {
            return times(exact, along);
        }
        let (of_j, of_l) = (lv.minus(&lu), ju.minus(&jv));
        let terms = [(j.at, of_j.sign()), (l.at, of_l.sign()), (self.seed, -of_j.plus(&of_l).sign())];
        times(first_of_latest(terms), along)
    }

    /// Side of the point where bisectors `j` and `k` meet within the triangle, against bisector `l`.
    pub(super) fn side_within(&self, j: &Bisector, k: &Bisector, l: &Bisector) -> Sign {
        let det = dot(cross(j.form.d, k.form.d), l.form.d);
        let sign = if det.abs() > WITHIN * j.form.size * k.form.size * l.form.size {
            Sign::of(det)
        } else {
            self.exact_side_within(j, k, l)
        };
        times(sign, self.turn(j, k))
    }

    /// The sign of det(d_ij, d_ik, 1): whether n = (x_j - x_i) x (x_k - x_i) points to the outer side of the triangle.
    pub(super) fn turn(&self, j: &Bisector, k: &Bisector) -> Sign {
        let det = dot(cross(j.form.d, k.form.d), [1.0; 3]);
        if det.abs() > 72.0 * UNIT * j.form.size * k.form.size {
            return Sign::of(det);
        }
        self.exact_minor(j, k).sign()
    }

    /// Where on the edge from corner `u` to corner `v` bisector `j` meets it: 0 at its beginning, 1 at its end. The two seeds of
    /// the bisector and the two triangles at the edge find the same, within rounding.
    pub(super) fn place_on_edge(&self, u: usize, v: usize, j: &Bisector) -> f64 {
        let (mut from, mut fall) = (j.form.d[u], j.form.d[u] - j.form.d[v]);
        if j.form.is_vague_on(u, v) {
            let exact = self.exact(j, u);
            (from, fall) = (exact.value(), exact.minus(&self.exact(j, v)).value());
        }
        // It is known to be on the edge: what rounding puts beyond an end is brought back.
        if fall == 0.0 { 0.0 } else { (from / fall).clamp(0.0, 1.0) }
    }

    /// The point of the triangle where bisectors `j` and `k` meet, in the frame of `corners`, which are the triangle's. The three
    /// seeds find the same, within rounding.
    pub(super) fn place_within(&self, j: &Bisector, k: &Bisector, corners: [DVec3; 3]) -> DVec3 {
        j.form.meeting(&k.form).map_or_else(
            || {
                let [dj, dk] = [j, k].map(|b| [0, 1, 2].map(|c| self.exact(b, c)));
                let minor = |(a, b): (usize, usize)| dj[a].times(&dk[b]).minus(&dj[b].times(&dk[a])).value();
                within([(1, 2), (2, 0), (0, 1)].map(minor), corners)
            },
            |meeting| meeting.within(corners),
        )
    }

    /// The sign of the perturbed det(d_ij, d_ik, d_il).
    fn exact_side_within(&self, j: &Bisector, k: &Bisector, l: &Bisector) -> Sign {
        let [dj, dk, dl] = [j, k, l].map(|b| [0, 1, 2].map(|c| self.exact(b, c)));
        let minor = |c: usize| {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            dj[a].times(&dk[b]).minus(&dj[b].times(&dk[a]))
        };
        let det = minor(0).times(&dl[0]).plus(&minor(1).times(&dl[1])).plus(&minor(2).times(&dl[2]));
        if det.sign() != Sign::Zero {
            return det.sign();
        }
        // A seed's infinitesimal enters with the determinant in which 1 stands in the place of its form.
        let of_l = self.exact_minor(j, k);
        let of_j = self.exact_minor(k, l);
        let of_k = self.exact_minor(l, j);
        let of_seed = of_j.plus(&of_k).plus(&of_l);
        first_of_latest([(j.at, of_j.sign()), (k.at, of_k.sign()), (l.at, of_l.sign()), (self.seed, -of_seed.sign())])
    }

    /// det(d_ij, d_ik, 1).
    fn exact_minor(&self, j: &Bisector, k: &Bisector) -> Expansion {
        let [ju, jv, jw] = [0, 1, 2].map(|c| self.exact(j, c));
        let [ku, kv, kw] = [0, 1, 2].map(|c| self.exact(k, c));
        let [jv, jw, kv, kw] = [jv.minus(&ju), jw.minus(&ju), kv.minus(&ku), kw.minus(&ku)];
        jv.times(&kw).minus(&jw.times(&kv))
    }

    /// d_ij at corner `c`; differences of coordinates are exact on the frame's grid.
    fn exact(&self, j: &Bisector, c: usize) -> Expansion {
        let mut d = Expansion::default();
        for axis in 0..3 {
            let (to_j, to_seed) = (self.corners[c][axis] - j.at[axis], self.corners[c][axis] - self.seed[axis]);
            d.add_product(to_j, to_j);
            d.add_product(-to_seed, to_seed);
        }
        d
    }
}

/// Whether `a` is closer to `at` than `b` is.
pub(super) fn closer(at: DVec3, a: DVec3, b: DVec3) -> bool {
    let (apart, twice) = (a - b, (at - a) + (at - b));
    let d = apart.dot(twice);
    if d.abs() > 5.0 * UNIT * apart.abs().dot(twice.abs()) {
        return d > 0.0;
    }
    let view = View { corners: [at; 3], seed: a };
    view.side_of_corner(0, &view.bisector(u32::MAX, b)) == Sign::Positive
}

/// Whether `a` comes after `b` in lexicographic order: x, then y, then z.
fn later(a: DVec3, b: DVec3) -> bool {
    lexicographic(a, b) == Ordering::Greater
}

/// The sign that belongs to the latest point whose sign is not zero.
fn first_of_latest<const N: usize>(mut terms: [(DVec3, Sign); N]) -> Sign {
    terms.sort_unstable_by(|a, b| lexicographic(b.0, a.0));
    let found = terms.iter().find(|term| term.1 != Sign::Zero);
    found.expect("the last line crosses the others: this is a bug in tetcvt").1
}

fn times(a: Sign, b: Sign) -> Sign {
    match b {
        Sign::Positive => a,
        Sign::Negative => -a,
        Sign::Zero => Sign::Zero,
    }
}
