//! What the cells that share triangles have of them, in vectors; for the ways to share one see `shares.rs`.
//!
//! A piece is made of triangles, whose shares of the area of the whole follow from the places on its edges. A cut segment between
//! two cells, from one such place to the next, closes the facet between them.

use super::cell::{NUMBERS, Sums};
use super::surface_pieces::Scene;
use super::walls::{LANES, Lanes};
use crate::geometry::triples::{cross, dot, minus};

/// Blocks of as many that are gathered in a row.
const BLOCKS: usize = 4;

/// How many of the numbers of a [`Cell`](super::cell::Cell), the first, are of the solid.
const OF_SOLID: usize = 6;

/// Numbers that describe a triangle.
const DESCRIPTION: usize = 26;

/// Where in these, after the corners, the other seeds begin, the places on the edges, the barycentric coordinates of X, the
/// densities at the corners, and whether these are counter-clockwise, 1 or -1.
const OTHERS: usize = 9;

const PLACES: usize = 15;

const WEIGHTS: usize = 19;

const DENSITIES: usize = 22;

const TURN: usize = 25;

/// A triangle that is shared.
#[derive(Clone, Copy)]
pub(super) struct Item {
    pub(super) triangle: u32,
    /// Its corner 0 of the picture, and whether 1 is the next one, or that before.
    pub(super) first: usize,
    pub(super) forward: bool,
    /// In the picture's order; of two the last twice.
    pub(super) seeds: [u32; 3],
    /// Q from 0, S from 1, R from 2; apart: Q, S, T from 1, R; tip: P, Q, R: shares of their edges.
    pub(super) places: [f64; 4],
    /// Barycentric coordinates of X.
    pub(super) weights: [f64; 3],
}

impl Item {
    /// Of which nothing is said but the triangle.
    pub(super) fn of(triangle: u32) -> Item {
        Item { triangle, first: 0, forward: true, seeds: [0; 3], places: [0.0; 4], weights: [0.0; 3] }
    }
}

/// Triangles that are summed in a row.
#[derive(Default)]
pub(super) struct Batch {
    blocks: [Block; BLOCKS],
}

#[derive(Default)]
struct Block {
    seeds: [[u32; 3]; LANES],
    /// Whether it is an interface, which does not end the solid.
    interface: [bool; LANES],
    /// Positions are relative to the first seed.
    numbers: [Lanes; DESCRIPTION],
    /// What each seed has of it.
    moments: [Moments; 3],
}

type Moments = [Lanes; NUMBERS];

/// How triangles are shared between so many seeds.
pub(super) trait Shared<const SEEDS: usize> {
    /// What each has of a triangle that such numbers describe.
    fn moments(number: impl Fn(usize) -> f64) -> [[f64; NUMBERS]; SEEDS];
}

/// Whole in one cell.
pub(super) struct One;

pub(super) struct Two;

pub(super) struct Three;

pub(super) struct Apart;

pub(super) struct Tip;

impl Batch {
    /// Adds `items` to `sums`.
    pub(super) fn add<const SEEDS: usize, S: Shared<SEEDS>>(
        &mut self,
        scene: Scene,
        mut items: impl Iterator<Item = Item>,
        sums: &mut Sums<NUMBERS>,
    ) {
        // Vectors are read long after their numbers were written one by one: else each would wait for all of these.
        loop {
            let mut count = 0;
            for item in items.by_ref().take(BLOCKS * LANES) {
                self.blocks[count / LANES].set::<SEEDS>(count % LANES, &item, scene);
                count += 1;
            }
            if count == 0 {
                return;
            }
            scene.arch.dispatch(Find::<SEEDS, S> { blocks: &mut self.blocks, kind: std::marker::PhantomData });
            (0..count).for_each(|n| self.blocks[n / LANES].add::<SEEDS>(n % LANES, sums));
        }
    }
}

impl Block {
    /// Puts a triangle that so many seeds share into lane `l`.
    #[inline]
    fn set<const SEEDS: usize>(&mut self, l: usize, item: &Item, scene: Scene) {
        let Scene { points, sheet, .. } = scene;
        let Item { triangle, first, forward, seeds, places, weights } = *item;
        let seed = points[seeds[0] as usize];
        let numbers = &mut self.numbers;
        let mut put = |n: usize, p: glam::DVec3| {
            (numbers[n][l], numbers[n + 1][l], numbers[n + 2][l]) = (p.x, p.y, p.z);
        };
        let (ids, densities) = (sheet.triangles[triangle as usize], sheet.densities(triangle));
        let order = [first, (first + if forward { 1 } else { 2 }) % 3, (first + if forward { 2 } else { 1 }) % 3];
        for n in 0..3 {
            put(3 * n, sheet.points[ids[order[n]] as usize] - seed);
        }
        for n in 0..SEEDS - 1 {
            put(OTHERS + 3 * n, points[seeds[n + 1] as usize] - seed);
        }
        if SEEDS > 1 {
            (0..4).for_each(|n| numbers[PLACES + n][l] = places[n]);
        }
        if SEEDS > 2 {
            (0..3).for_each(|n| numbers[WEIGHTS + n][l] = weights[n]);
        }
        (0..3).for_each(|n| numbers[DENSITIES + n][l] = densities[order[n]]);
        numbers[TURN][l] = if forward { 1.0 } else { -1.0 };
        (self.seeds[l], self.interface[l]) = (seeds, sheet.is_interface(triangle));
    }

    /// Adds what was found for lane `l` to the sums.
    #[inline]
    fn add<const SEEDS: usize>(&self, l: usize, sums: &mut Sums<NUMBERS>) {
        for n in 0..SEEDS {
            let mut moments = std::array::from_fn(|m| self.moments[n][m][l]);
            if self.interface[l] {
                moments[..OF_SOLID].fill(0.0);
            }
            sums.add(self.seeds[l][n], moments);
        }
    }
}

/// Compiled for each width of vectors; the operations, and so the sums, are the same in each.
struct Find<'a, const SEEDS: usize, S> {
    blocks: &'a mut [Block],
    kind: std::marker::PhantomData<S>,
}

impl<const SEEDS: usize, S: Shared<SEEDS>> pulp::WithSimd for Find<'_, SEEDS, S> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: pulp::Simd>(self, _: V) {
        for Block { numbers, moments, .. } in self.blocks {
            for l in 0..LANES {
                let found = S::moments(|n| numbers[n][l]);
                for n in 0..SEEDS {
                    for m in 0..NUMBERS {
                        moments[n][m][l] = found[n][m];
                    }
                }
            }
        }
    }
}

/// A point of the triangle, and the density there.
#[derive(Clone, Copy)]
struct Place {
    at: [f64; 3],
    density: f64,
}

impl Place {
    /// The same as seen from another seed.
    #[inline(always)]
    fn from(self, seed: [f64; 3]) -> Place {
        Place { at: minus(self.at, seed), ..self }
    }

    /// A place between two.
    #[inline(always)]
    fn to(self, end: Place, share: f64) -> Place {
        let at = [0, 1, 2].map(|n| self.at[n] + (end.at[n] - self.at[n]) * share);
        Place { at, density: self.density + (end.density - self.density) * share }
    }
}

/// The plane of a triangle: its unit normal times its area, that area, and whether its corners are counter-clockwise, 1 or -1.
#[derive(Clone, Copy)]
struct Plane {
    area_vector: [f64; 3],
    area: f64,
    turn: f64,
}

/// The corners of a triangle, and its plane.
#[inline(always)]
fn corners(number: &impl Fn(usize) -> f64) -> ([Place; 3], Plane) {
    let corners = [0, 1, 2].map(|c| Place { at: vector(number, 3 * c), density: number(DENSITIES + c) });
    let [a, b, c] = corners.map(|p| p.at);
    let turn = number(TURN);
    let area_vector = cross(minus(b, a), minus(c, a)).map(|x| 0.5 * turn * x);
    (corners, Plane { area_vector, area: dot(area_vector, area_vector).sqrt(), turn })
}

#[inline(always)]
fn vector(number: &impl Fn(usize) -> f64, n: usize) -> [f64; 3] {
    [number(n), number(n + 1), number(n + 2)]
}

/// The two other seeds, seen from the first.
#[inline(always)]
fn others(number: &impl Fn(usize) -> f64) -> [[f64; 3]; 2] {
    [vector(number, OTHERS), vector(number, OTHERS + 3)]
}

/// The place where three cells meet, and its barycentric coordinates.
#[inline(always)]
fn meeting(number: &impl Fn(usize) -> f64, [a, b, c]: [Place; 3]) -> (Place, [f64; 3]) {
    let weights = vector(number, WEIGHTS);
    let [_, v, w] = weights;
    let at = [0, 1, 2].map(|n| a.at[n] + (b.at[n] - a.at[n]) * v + (c.at[n] - a.at[n]) * w);
    (Place { at, density: a.density + (b.density - a.density) * v + (c.density - a.density) * w }, weights)
}

#[inline(always)]
fn plus(a: [f64; NUMBERS], b: [f64; NUMBERS]) -> [f64; NUMBERS] {
    std::array::from_fn(|n| a[n] + b[n])
}

#[inline(always)]
fn less(a: [f64; NUMBERS], b: [f64; NUMBERS]) -> [f64; NUMBERS] {
    std::array::from_fn(|n| a[n] - b[n])
}

impl Shared<1> for One {
    #[inline(always)]
    fn moments(number: impl Fn(usize) -> f64) -> [[f64; NUMBERS]; 1] {
        let (corners, plane) = corners(&number);
        [plane.piece(corners, 1.0)]
    }
}

impl Shared<2> for Two {
    #[inline(always)]
    fn moments(number: impl Fn(usize) -> f64) -> [[f64; NUMBERS]; 2] {
        let ([a, b, c], plane) = corners(&number);
        let ([at_q, at_r], other) = ([number(PLACES), number(PLACES + 2)], vector(&number, OTHERS));
        let (q, r, share) = (a.to(b, at_q), c.to(a, at_r), at_q * (1.0 - at_r));
        let first = plane.with_cut(plane.piece([a, q, r], share), other, [q, r]);
        let [a, b, c, q, r] = [a, b, c, q, r].map(|p| p.from(other));
        let rest = less(plane.piece([a, b, c], 1.0), plane.piece([a, q, r], share));
        [first, plane.with_cut(rest, other.map(|x| -x), [r, q])]
    }
}

impl Shared<3> for Three {
    #[inline(always)]
    fn moments(number: impl Fn(usize) -> f64) -> [[f64; NUMBERS]; 3] {
        let ([a, b, c], plane) = corners(&number);
        let (x, [wa, wb, wc]) = meeting(&number, [a, b, c]);
        let [at_q, at_s, at_r] = [0, 1, 2].map(|n| number(PLACES + n));
        let (q, s, r) = (a.to(b, at_q), b.to(c, at_s), c.to(a, at_r));
        let (first, [second, third]) = ([0.0; 3], others(&number));
        [
            plane.around([a, q, x, r], [at_q * wc, (1.0 - at_r) * wb], [first, second, third]),
            plane.around([b, s, x, q], [at_s * wa, (1.0 - at_q) * wc], [second, third, first]),
            plane.around([c, r, x, s], [at_r * wb, (1.0 - at_s) * wa], [third, first, second]),
        ]
    }
}

impl Shared<3> for Apart {
    #[inline(always)]
    fn moments(number: impl Fn(usize) -> f64) -> [[f64; NUMBERS]; 3] {
        let ([a, b, c], plane) = corners(&number);
        let [at_q, at_s, at_t, at_r] = [0, 1, 2, 3].map(|n| number(PLACES + n));
        let [q, s, t, r] = [a.to(b, at_q), b.to(c, at_s), b.to(c, at_t), c.to(a, at_r)];
        let [second, third] = others(&number);
        let shares = [(1.0 - at_q) * at_s, at_r * (1.0 - at_t)];
        let rest = less(plane.piece([a, b, c], 1.0), plane.piece([b, s, q], shares[0]));
        let rest = less(rest, plane.piece([c, r, t], shares[1]));
        let rest = plane.with_cut(plane.with_cut(rest, second, [q, s]), third, [t, r]);
        let off = |seed: [f64; 3], corners: [Place; 3], share: f64| {
            let corners = corners.map(|p| p.from(seed));
            plane.with_cut(plane.piece(corners, share), seed.map(|x| -x), [corners[1], corners[2]])
        };
        [rest, off(second, [b, s, q], shares[0]), off(third, [c, r, t], shares[1])]
    }
}

impl Shared<3> for Tip {
    #[inline(always)]
    fn moments(number: impl Fn(usize) -> f64) -> [[f64; NUMBERS]; 3] {
        let ([a, b, c], plane) = corners(&number);
        let (x, weights) = meeting(&number, [a, b, c]);
        let [at_p, at_q, at_r] = [0, 1, 2].map(|n| number(PLACES + n));
        let [p, q, r] = [a.to(b, at_p), a.to(b, at_q), c.to(a, at_r)];
        let [tip, last] = others(&number);
        let shares = [at_p * weights[2], (1.0 - at_r) * weights[1], (at_q - at_p) * weights[2]];
        let first = plus(plane.piece([a, p, x], shares[0]), plane.piece([a, x, r], shares[1]));
        let first = plane.with_cut(plane.with_cut(first, tip, [p, x]), last, [x, r]);
        let second = {
            let [p, q, x] = [p, q, x].map(|p| p.from(tip));
            let piece = plane.with_cut(plane.piece([p, q, x], shares[2]), minus(last, tip), [q, x]);
            plane.with_cut(piece, tip.map(|x| -x), [x, p])
        };
        let [a, b, c, p, q, x, r] = [a, b, c, p, q, x, r].map(|p| p.from(last));
        let rest = less(plane.piece([a, b, c], 1.0), plane.piece([a, p, x], shares[0]));
        let rest = less(less(rest, plane.piece([a, x, r], shares[1])), plane.piece([p, q, x], shares[2]));
        let rest = plane.with_cut(rest, last.map(|x| -x), [r, x]);
        [first, second, plane.with_cut(rest, minus(tip, last), [x, q])]
    }
}

impl Plane {
    /// What a triangle within this one, of such a share of its area, adds to the cell of the seed at 0: see
    /// [`Cell::add_polygon`](super::cell::Cell::add_polygon).
    #[inline(always)]
    fn piece(self, [a, b, c]: [Place; 3], share: f64) -> [f64; NUMBERS] {
        let sum = [0, 1, 2].map(|n| a.at[n] + b.at[n] + c.at[n]);
        let mass = a.density + b.density + c.density;
        // Three times the volume of the cone.
        let cone = dot(self.area_vector, sum) * share / 3.0;
        let squares = dot(a.at, a.at) + dot(b.at, b.at) + dot(c.at, c.at) + dot(sum, sum);
        let area = self.area * share;
        let moment = |n: usize| {
            area / 12.0 * (sum[n] * mass + (a.at[n] * a.density + b.at[n] * b.density + c.at[n] * c.density))
        };
        let flat = cone / 12.0;
        [
            cone / 3.0,
            0.0,
            sum[0] * flat,
            sum[1] * flat,
            sum[2] * flat,
            cone * squares / 60.0,
            area,
            moment(0),
            moment(1),
            moment(2),
            area * mass / 3.0,
        ]
    }

    /// What is around a corner of three: from it to the place on the next edge, to X, and to the place on the edge before; with
    /// the shares of the two triangles that these make. Seeds are that of the corner, the next, and the one before.
    #[inline(always)]
    fn around(self, corners: [Place; 4], shares: [f64; 2], [seed, next, last]: [[f64; 3]; 3]) -> [f64; NUMBERS] {
        let [corner, out, x, back] = corners.map(|p| p.from(seed));
        let piece = plus(self.piece([corner, out, x], shares[0]), self.piece([corner, x, back], shares[1]));
        self.with_cut(self.with_cut(piece, minus(next, seed), [out, x]), minus(last, seed), [x, back])
    }

    /// A piece with its cut segment from `q` to `r`, on the bisector of the seed at 0 and the one at `other`: see
    /// [`Cell::add_tet`](super::cell::Cell::add_tet).
    #[inline(always)]
    fn with_cut(self, mut piece: [f64; NUMBERS], other: [f64; 3], [q, r]: [Place; 2]) -> [f64; NUMBERS] {
        let (middle, q, r) = (other.map(|x| 0.5 * x), q.at, r.at);
        let volume = self.turn * dot(middle, cross(r, q)) / 6.0;
        let sum = [0, 1, 2].map(|n| middle[n] + r[n] + q[n]);
        let squares = dot(middle, middle) + dot(r, r) + dot(q, q) + dot(sum, sum);
        piece[0] += volume;
        (0..3).for_each(|n| piece[2 + n] += sum[n] * volume * 0.25);
        piece[5] += squares * volume / 20.0;
        piece
    }
}
