//! Triangles that one bisector cuts, or two that meet within: most pieces of the surface, summed in vectors.
//!
//! ```text
//!         C                      B, cut off            A piece is the polygon (A, B, Q, R), of which B is A where
//!        / \                    / \                    one corner is left, or (A, B, Q, X, R) where two bisectors
//!   R --/---\-- Q          Q --/---\-- bisector        meet at X. The cut segment from Q to R closes the facet of
//!      /     \                /     \                 the two seeds; with X there are two, from Q to X and to R.
//!     A-------B              A---R---C, cut off
//! ```

use glam::DVec3;

use super::bisector::Bisector;
use super::cell::Cell;
use super::outline::Ends;
use super::sheet::Linear;
use crate::geometry::triples::{cross, dot, minus};

/// Pieces that are summed at once.
const LANES: usize = 8;

/// Numbers that describe a piece with one cut.
const ONCE: usize = 37;

/// Numbers that describe a piece with two: those, X, and where the second seed lies.
const TWICE: usize = ONCE + 6;

/// Numbers of a [`Cell`].
const SUMS: usize = 10;

/// Numbers of as many pieces.
type Block<const N: usize> = [[f64; LANES]; N];

/// No pieces: 0 in all numbers, but no division of 0 by 0.
const fn nothing<const N: usize>() -> Block<N> {
    let mut block = [[0.0; LANES]; N];
    (block[31], block[33]) = ([1.0; LANES], [1.0; LANES]);
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

/// A triangle of the surface, relative to the seed of the cell.
#[derive(Clone, Copy)]
pub(super) struct Face {
    pub(super) corners: [DVec3; 3],
    /// Vertices of the surface: the ends of an edge are taken in the order of these, the same for both triangles at it.
    pub(super) ids: [u32; 3],
    /// Its normal, twice the area long.
    pub(super) normal2: DVec3,
    pub(super) density: Linear,
    /// The density of the solid, where that is not even.
    pub(super) solid: Option<Linear>,
}

impl Face {
    /// Its unit normal; zero where it has none.
    pub(super) fn normal(&self) -> DVec3 {
        self.normal2.normalize_or_zero()
    }

    /// The density of the solid at a point of the triangle.
    pub(super) fn solid_at(&self, p: DVec3) -> f64 {
        self.solid.map_or(1.0, |solid| solid.at(p))
    }
}

impl Slices {
    /// Adds what is left of a triangle that one bisector cuts at these `ends`; its seed lies at `to`.
    #[inline]
    pub(super) fn add_once(&mut self, face: &Face, ends: &Ends, bisector: &Bisector, to: DVec3) {
        let (block, lane) = self.once.next();
        set_cut(block, lane, face, ends, [bisector; 2], to);
    }

    /// Adds what is left of a triangle that two bisectors cut, the first at the first of `ends`, the second at the other, and
    /// that meet at `meeting`; their seeds lie at `to`.
    #[inline]
    pub(super) fn add_twice(
        &mut self,
        face: &Face,
        ends: &Ends,
        bisectors: [&Bisector; 2],
        meeting: DVec3,
        to: [DVec3; 2],
    ) {
        let (block, lane) = self.twice.next();
        set_cut(block, lane, face, ends, bisectors, to[0]);
        for (n, x) in meeting.to_array().into_iter().chain(to[1].to_array()).enumerate() {
            block[ONCE + n][lane] = x;
        }
    }

    /// Adds all pieces to `cell`, and is empty again.
    pub(super) fn take(&mut self, arch: pulp::Arch, cell: &mut Cell) {
        self.once.take(arch, cell);
        self.twice.take(arch, cell);
    }
}

/// The first numbers of a piece (A, B, Q, R): Q on the first of `ends`, where the first bisector is 0, R on the other.
#[inline(always)]
fn set_cut<const N: usize>(
    block: &mut Block<N>,
    lane: usize,
    face: &Face,
    ends: &Ends,
    [j, k]: [&Bisector; 2],
    to: DVec3,
) {
    let in_order = |(u, v): (usize, usize)| if face.ids[u] < face.ids[v] { (u, v) } else { (v, u) };
    let (q, r, at) = (in_order(ends.cut[0]), in_order(ends.cut[1]), face.corners);
    let Linear { base, from, gradient, range } = face.density;
    let vectors =
        [at[ends.left[0]], at[ends.left[1]], at[q.0], at[q.1], at[r.0], at[r.1], to, face.normal2, from, gradient];
    for (n, v) in vectors.into_iter().enumerate() {
        (block[3 * n][lane], block[3 * n + 1][lane], block[3 * n + 2][lane]) = (v.x, v.y, v.z);
    }
    for (n, x) in [j.d[q.0], j.d[q.1], k.d[r.0], k.d[r.1], base, range[0], range[1]].into_iter().enumerate() {
        block[30 + n][lane] = x;
    }
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
    let (a, b) = (vector(0), vector(1));
    let between = |u: [f64; 3], v: [f64; 3], from: f64, to: f64| {
        let t = from / (from - to);
        [u[0] + (v[0] - u[0]) * t, u[1] + (v[1] - u[1]) * t, u[2] + (v[2] - u[2]) * t]
    };
    let q = between(vector(2), vector(3), number(30), number(31));
    let r = between(vector(4), vector(5), number(32), number(33));
    let (to, normal2, from, gradient) = (vector(6), vector(7), vector(8), vector(9));
    let length = dot(normal2, normal2).sqrt();
    let shrink = if length > 0.0 { 1.0 / length } else { 0.0 };
    let normal = normal2.map(|x| x * shrink);
    let density = |p: [f64; 3]| {
        let value = number(34) + dot(gradient, minus(p, from));
        let value = if value > number(35) { value } else { number(35) };
        if value < number(36) { value } else { number(36) }
    };
    // The piece, as two triangles or three, and the cut segments.
    let (at_a, at_q) = (density(a), density(q));
    let first = triangle([a, b, q], normal, [at_a, density(b), at_q]);
    let (rest, cut) = if N == TWICE {
        let x = [number(ONCE), number(ONCE + 1), number(ONCE + 2)];
        let at_x = density(x);
        let second = triangle([a, q, x], normal, [at_a, at_q, at_x]);
        let third = triangle([a, x, r], normal, [at_a, at_x, density(r)]);
        let cuts = (segment(to, q, x), segment([number(ONCE + 3), number(ONCE + 4), number(ONCE + 5)], x, r));
        (sum(second, third), sum(cuts.0, cuts.1))
    } else {
        (triangle([a, q, r], normal, [at_a, at_q, density(r)]), segment(to, q, r))
    };
    let [area, x, y, z, square, mx, my, mz, mass] = sum(first, rest);
    let height = dot(normal, a);
    let (third, flat) = (height / 6.0, height / 24.0);
    [
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
    ]
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
