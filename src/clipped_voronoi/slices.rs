//! Triangles of which one bisector cuts off corners, or two that meet within or leave an edge between them: most pieces of the
//! surface, summed in vectors.
//!
//! With the corners of `outline.rs` a piece is the polygon (0, 0, Q, R) or (R', Q', Q, R); where two bisectors meet, at X,
//! (0, 0, Q, X, R) or (R', Q', Q, X, R). The cut segment from Q to R closes the facet of the two seeds; with X there are two,
//! from Q to X and from X to R. Where two bisectors do not meet, the piece is what one leaves less what the other cuts off.

use glam::DVec3;

use super::bisector::Form;
use super::cell::Cell;
use super::sheet::Linear;
use crate::geometry::triples::{cross, dot, minus};

/// Pieces that are summed at once.
const LANES: usize = 8;

/// Numbers that describe a piece with one cut.
const ONCE: usize = 27;

/// Numbers that describe a piece with two: those, d of each at the other's end, and where the second seed lies.
const TWICE: usize = ONCE + 5;

/// Where in these the values of d begin.
const D: usize = 12;

/// Numbers of a [`Cell`].
const SUMS: usize = 10;

/// Numbers of as many pieces.
type Block<const N: usize> = [[f64; LANES]; N];

/// No pieces: 0 in all numbers, but no division of 0 by 0.
const fn nothing<const N: usize>() -> Block<N> {
    let mut block = [[0.0; LANES]; N];
    // d at the ends of the edges; the sum of the minors is then 1 too.
    (block[D + 1], block[D + 3]) = ([1.0; LANES], [1.0; LANES]);
    if N == TWICE {
        block[ONCE] = [1.0; LANES];
    }
    block
}

/// Pieces of one cell.
#[derive(Default)]
pub(super) struct Slices {
    once: Pieces<ONCE>,
    twice: Pieces<TWICE>,
}

/// Pieces of as many numbers.
#[derive(Default)]
struct Pieces<const N: usize> {
    /// Those of the pieces first; what is behind them is left from other cells.
    blocks: Vec<Block<N>>,
    count: usize,
}

/// A triangle, with corners in the order of `outline.rs`, relative to the seed.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    pub(super) corners: [&'a DVec3; 3],
    /// Whether the first corner is the one that is left.
    pub(super) single: bool,
    pub(super) density: Linear,
}

impl Slices {
    /// Adds what is left of a triangle that one bisector cuts, whose seed lies at `to`, times `weight`.
    #[inline(always)]
    pub(super) fn add_once(&mut self, part: Part, weight: f64, Form { d, .. }: Form, to: DVec3) {
        let (block, lane) = self.once.next();
        set_cut(block, lane, part, weight, [d[0], d[1], d[0], d[2]], to);
    }

    /// Adds what is left of a triangle that two bisectors cut, the first at Q, the second at R, and that meet within; their seeds
    /// lie at `to`.
    #[inline(always)]
    pub(super) fn add_twice(&mut self, part: Part, [j, k]: [Form; 2], to: [DVec3; 2]) {
        let (block, lane) = self.twice.next();
        set_cut(block, lane, part, 1.0, [j.d[0], j.d[1], k.d[0], k.d[2]], to[0]);
        (block[ONCE][lane], block[ONCE + 1][lane]) = (j.d[2], k.d[1]);
        (block[ONCE + 2][lane], block[ONCE + 3][lane], block[ONCE + 4][lane]) = (to[1].x, to[1].y, to[1].z);
    }

    /// Adds all pieces to `cell`, and is empty again.
    pub(super) fn take(&mut self, arch: pulp::Arch, cell: &mut Cell) {
        self.once.take(arch, cell);
        self.twice.take(arch, cell);
    }
}

/// The first numbers of a piece.
#[inline(always)]
fn set_cut<const N: usize>(block: &mut Block<N>, lane: usize, part: Part, weight: f64, d: [f64; 4], to: DVec3) {
    let [a, b, c] = part.corners;
    let Linear { base, from, gradient, range } = part.density;
    for (n, v) in [a, b, c, &to].into_iter().enumerate() {
        (block[3 * n][lane], block[3 * n + 1][lane], block[3 * n + 2][lane]) = (v.x, v.y, v.z);
    }
    for (n, x) in d.into_iter().enumerate() {
        block[D + n][lane] = x;
    }
    (block[16][lane], block[17][lane]) = (f64::from(part.single), weight);
    for (n, v) in [from, gradient].into_iter().enumerate() {
        (block[18 + 3 * n][lane], block[19 + 3 * n][lane], block[20 + 3 * n][lane]) = (v.x, v.y, v.z);
    }
    (block[24][lane], block[25][lane], block[26][lane]) = (base, range[0], range[1]);
}

impl<const N: usize> Pieces<N> {
    /// Where one more goes.
    #[inline(always)]
    fn next(&mut self) -> (&mut Block<N>, usize) {
        let (at, lane) = (self.count / LANES, self.count % LANES);
        if at == self.blocks.len() {
            self.blocks.push(nothing());
        }
        self.count += 1;
        (&mut self.blocks[at], lane)
    }

    fn take(&mut self, arch: pulp::Arch, cell: &mut Cell) {
        if self.count == 0 {
            return;
        }
        let (used, rest) = (self.count.div_ceil(LANES), self.count % LANES);
        if rest > 0 {
            let last = self.blocks[used - 1].iter_mut().zip(const { &nothing::<N>() });
            last.for_each(|(numbers, nothing)| numbers[rest..].fill(nothing[0]));
        }
        let sums = arch.dispatch(AddAll { blocks: &self.blocks[..used] });
        let [volume, mx, my, mz, energy, area, ax, ay, az, mass] = sums.map(|lanes| lanes.iter().sum::<f64>());
        cell.volume += volume;
        cell.moment += DVec3::new(mx, my, mz);
        cell.energy += energy;
        cell.area += area;
        cell.area_moment += DVec3::new(ax, ay, az);
        cell.area_mass += mass;
        self.count = 0;
    }
}

/// Compiled for each width of vectors; the operations, and so the sums, are the same in each.
struct AddAll<'a, const N: usize> {
    blocks: &'a [Block<N>],
}

impl<const N: usize> pulp::WithSimd for AddAll<'_, N> {
    type Output = [[f64; LANES]; SUMS];

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> [[f64; LANES]; SUMS] {
        let mut sums = [[0.0; LANES]; SUMS];
        for block in self.blocks {
            for l in 0..LANES {
                let part = moments::<N>(|n| block[n][l]);
                for n in 0..SUMS {
                    sums[n][l] += part[n];
                }
            }
        }
        sums
    }
}

/// What one piece adds to the numbers of a cell, in their order; for the formulas see [`Cell::add_polygon`] and
/// [`Cell::add_tet`].
#[inline(always)]
fn moments<const N: usize>(number: impl Fn(usize) -> f64) -> [f64; SUMS] {
    let vector = |n: usize| [number(3 * n), number(3 * n + 1), number(3 * n + 2)];
    let (alone, to_q, to_r, to) = (vector(0), vector(1), vector(2), vector(3));
    let between = |end: [f64; 3], from: f64, to: f64| {
        let t = from / (from - to);
        [0, 1, 2].map(|n| alone[n] + (end[n] - alone[n]) * t)
    };
    let q = between(to_q, number(D), number(D + 1));
    let r = between(to_r, number(D + 2), number(D + 3));
    let single = number(16) > 0.5;
    let either = |one: f64, two: f64| if single { one } else { two };
    let [a, b] = [to_r, to_q].map(|end| [0, 1, 2].map(|n| either(alone[n], end[n])));
    let normal2 = cross(minus(to_q, alone), minus(to_r, alone));
    let length = dot(normal2, normal2).sqrt();
    let shrink = if length > 0.0 { 1.0 / length } else { 0.0 };
    let shrink = either(shrink, -shrink);
    let normal = normal2.map(|x| x * shrink);
    let (from, gradient) = (vector(6), vector(7));
    let density = |p: [f64; 3]| {
        let value = number(24) + dot(gradient, minus(p, from));
        let value = if value > number(25) { value } else { number(25) };
        if value < number(26) { value } else { number(26) }
    };
    // The piece, as two triangles or three, and the cut segments.
    let (at_a, at_q) = (density(a), density(q));
    let first = triangle([a, b, q], normal, [at_a, density(b), at_q]);
    let (rest, cut) = if N == TWICE {
        let minors = cross([number(D), number(D + 1), number(ONCE)], [number(D + 2), number(ONCE + 1), number(D + 3)]);
        let whole = minors[0] + minors[1] + minors[2];
        let (b, c) = (minors[1] / whole, minors[2] / whole);
        let x = [0, 1, 2].map(|n| alone[n] + (to_q[n] - alone[n]) * b + (to_r[n] - alone[n]) * c);
        let at_x = density(x);
        let second = triangle([a, q, x], normal, [at_a, at_q, at_x]);
        let third = triangle([a, x, r], normal, [at_a, at_x, density(r)]);
        let cuts = (segment(to, q, x), segment([number(ONCE + 2), number(ONCE + 3), number(ONCE + 4)], x, r));
        (sum(second, third), sum(cuts.0, cuts.1))
    } else {
        (triangle([a, q, r], normal, [at_a, at_q, density(r)]), segment(to, q, r))
    };
    let [area, x, y, z, square, mx, my, mz, mass] = sum(first, rest);
    let height = dot(normal, a);
    let (third, flat) = (height / 6.0, height / 24.0);
    let sums = [
        area * third + cut[0],
        x * flat + cut[1],
        y * flat + cut[2],
        z * flat + cut[3],
        square * height / 120.0 + cut[4],
        area * 0.5,
        mx / 24.0,
        my / 24.0,
        mz / 24.0,
        mass / 6.0,
    ];
    sums.map(|x| x * number(17))
}

#[inline(always)]
fn sum<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|n| a[n] + b[n])
}

/// For the cut segment from `q` to `r`, seen from the middle of the two seeds, of which the other lies at `to`: volume, first
/// and second moment.
#[inline(always)]
fn segment(to: [f64; 3], q: [f64; 3], r: [f64; 3]) -> [f64; 5] {
    let middle = [0.5 * to[0], 0.5 * to[1], 0.5 * to[2]];
    let d = dot(middle, cross(r, q)) / 6.0;
    let all = [middle[0] + r[0] + q[0], middle[1] + r[1] + q[1], middle[2] + r[2] + q[2]];
    let squares = dot(middle, middle) + dot(r, r) + dot(q, q) + dot(all, all);
    let quarter = d * 0.25;
    [d, all[0] * quarter, all[1] * quarter, all[2] * quarter, squares * d / 20.0]
}

/// For a triangle: twice the area, 6 and 24 times half of the first and second moments as [`Cell::add_polygon`] sums them, and
/// the moment and mass with a density.
#[inline(always)]
fn triangle([a, b, c]: [[f64; 3]; 3], normal: [f64; 3], density: [f64; 3]) -> [f64; SUMS - 1] {
    let part = dot(cross(minus(b, a), minus(c, a)), normal);
    let sum = [a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]];
    let squares = dot(a, a) + dot(b, b) + dot(c, c) + dot(sum, sum);
    let mass = density[0] + density[1] + density[2];
    let moment = |k: usize| part * (sum[k] * mass + (a[k] * density[0] + b[k] * density[1] + c[k] * density[2]));
    [part, part * sum[0], part * sum[1], part * sum[2], part * squares, moment(0), moment(1), moment(2), part * mass]
}
