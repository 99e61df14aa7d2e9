//! Triangles that few cells share in one of four ways, summed in vectors: nearly all where triangles are smaller than cells.
//!
//! ```text
//!        0                 0                 0                 0           Two:   (0, Q, R) and the rest.
//!       / \               / \               / \               / \          Three: each what is around its corner; the
//!  Q --/---\-- R     Q --/_ _\-- R     Q --/   \-- R     P --/_  \              cells meet at X.
//!     /     \           /  X  \           /     \       Q --/_ X--\-- R   Apart: the owner of 0 keeps the others'
//!    1-------2         1---|---2         1-------2         1-------2             apart: (1, S, Q), (2, R, T), the rest.
//!                          S                S   T                         Tip:   a third cell has (P, Q, X); (0, P, X, R)
//! ```                                                                            and the rest.
//!
//! Where these places are, and that there is nothing else, `borders.rs` proves. A triangle is looked at once for all of its
//! seeds, so that sums are gathered in blocks of triangles. A cut segment between two cells closes the facet between them.

use rayon::prelude::*;

use super::Crossing;
use super::borders::{self, Borders, Meeting, Way, turned};
use super::cell::{Cell, NUMBERS, Sums};
use super::surface_pieces::Scene;
use super::walls::{LANES, Lanes, Walls};
use crate::geometry::triples::{cross, dot, minus};

/// Triangles in a block of the work: fixed, so that sums do not depend on the number of threads.
const BLOCK: usize = 4096;

/// Blocks of as many that are gathered in a row.
const BLOCKS: usize = 4;

/// How many of the numbers of a [`Cell`], the first, are of the solid.
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

/// Adds to `cells` all triangles that are shared so; returns the crossings of Voronoi edges with these, and the triangles that
/// are left.
pub(super) fn add(cells: &mut [Cell], scene: Scene) -> (Vec<Crossing>, Vec<u32>) {
    let borders = Borders::find(scene);
    let count = scene.sheet.triangles.len();
    let parts: Vec<_> = (0..count.div_ceil(BLOCK))
        .into_par_iter()
        .map_init(
            || Sharing::new(scene, &borders),
            |sharing, block| sharing.add(block * BLOCK..count.min((block + 1) * BLOCK)),
        )
        .collect();
    let (mut crossings, mut left) = (crossings(scene, &borders), Vec::new());
    for mut part in parts {
        part.sums.into_iter().for_each(|(i, numbers)| cells[i as usize].add_numbers(numbers));
        crossings.append(&mut part.crossings);
        left.append(&mut part.left);
    }
    (crossings, left)
}

/// Where Voronoi edges meet triangles of three owners, sorted by facet.
fn crossings(scene: Scene, borders: &Borders) -> Vec<Crossing> {
    let net = &scene.sheet.net;
    let crossing = |meeting: &Meeting| {
        let Meeting { triangle: t, owners, first, weights } = *meeting;
        let corners = scene.sheet.triangles[t as usize];
        borders.straight(corners, net.edges_of(t), scene.corner_owners(t))?;
        Some(crossing(scene, t, first, weights, owners))
    };
    borders.meetings().par_iter().filter_map(crossing).collect()
}

/// The crossing at a place of triangle `t`, with barycentric coordinates from corner `first` on, where the cells of three seeds,
/// of which the first owns that corner, are around it counter-clockwise.
fn crossing(scene: Scene, t: u32, first: usize, weights: [f64; 3], [i, j, k]: [u32; 3]) -> Crossing {
    let seed = scene.points[i as usize];
    let [a, b, c] = turned(scene.sheet.corners(t), first).map(|p| p - seed);
    let point = seed + a + (b - a) * weights[1] + (c - a) * weights[2];
    let mut facet = [i, j, k];
    facet.sort_unstable();
    let leaves = usize::from(i < j) + usize::from(j < k) + usize::from(k < i) == 2;
    Crossing { facet, point, triangle: scene.sheet.of_surface(t), leaves }
}

/// The work of one thread.
struct Sharing<'a> {
    scene: Scene<'a>,
    borders: &'a Borders,
    sums: Sums<NUMBERS>,
    lists: Lists,
    batch: Box<Batch>,
    walls: Walls,
}

/// What it did in a block.
struct Part {
    sums: Vec<(u32, [f64; NUMBERS])>,
    crossings: Vec<Crossing>,
    left: Vec<u32>,
}

/// Triangles by the way in which they are shared.
#[derive(Default)]
struct Lists {
    twos: Vec<Item>,
    threes: Vec<Item>,
    aparts: Vec<Item>,
    tips: Vec<Item>,
    /// Crossings in tips.
    crossings: Vec<Crossing>,
}

impl Lists {
    fn clear(&mut self) {
        let Lists { twos, threes, aparts, tips, crossings } = self;
        [twos, threes, aparts, tips].into_iter().for_each(Vec::clear);
        crossings.clear();
    }
}

/// A triangle that is shared.
#[derive(Clone, Copy)]
struct Item {
    triangle: u32,
    /// Its corner 0 of the picture, and whether 1 is the next one, or that before.
    first: usize,
    forward: bool,
    /// In the picture's order; of two the last twice.
    seeds: [u32; 3],
    /// Q from 0, S from 1, R from 2; apart: Q, S, T from 1, R; tip: P, Q, R: shares of their edges.
    places: [f64; 4],
    /// Barycentric coordinates of X.
    weights: [f64; 3],
}

impl<'a> Sharing<'a> {
    fn new(scene: Scene<'a>, borders: &'a Borders) -> Sharing<'a> {
        let (sums, lists) = (Sums::new(scene.points.len()), Lists::default());
        Sharing { scene, borders, sums, lists, batch: Box::default(), walls: Walls::default() }
    }

    /// Some triangles.
    fn add(&mut self, triangles: std::ops::Range<usize>) -> Part {
        self.lists.clear();
        let left = (triangles.start as u32..triangles.end as u32).filter(|&t| !self.take(t)).collect();
        let lists = &mut self.lists;
        self.batch.add::<2, Two>(self.scene, &lists.twos, &mut self.sums);
        self.batch.add::<3, Three>(self.scene, &lists.threes, &mut self.sums);
        self.batch.add::<3, Apart>(self.scene, &lists.aparts, &mut self.sums);
        self.batch.add::<3, Tip>(self.scene, &lists.tips, &mut self.sums);
        Part { sums: self.sums.take(), crossings: std::mem::take(&mut lists.crossings), left }
    }

    /// Adds or lists triangle `t`; whether it is shared.
    #[inline]
    fn take(&mut self, t: u32) -> bool {
        let owners = self.scene.corner_owners(t);
        let [i, j, k] = owners;
        if i == j && j == k {
            self.add_whole(t, i);
            return true;
        }
        if self.scene.weights.is_some() {
            return false;
        }
        // The corner that stands alone, if one does.
        let alone = if j == k {
            Some(0)
        } else if k == i {
            Some(1)
        } else {
            (i == j).then_some(2)
        };
        let (corners, edges) = (self.scene.sheet.triangles[t as usize], self.scene.sheet.net.edges_of(t));
        match (self.borders.straight(corners, edges, owners), alone) {
            (Some(places), Some(first)) => {
                let ([q, _, r], [i, j, _]) = (turned(places, first), turned(owners, first));
                self.lists.twos.push(Item { first, seeds: [i, j, j], places: [q, 0.0, r, 0.0], ..Item::of(t) });
                true
            }
            (Some(places), None) => {
                let Some(&Meeting { first, owners: seeds, weights, .. }) = self.borders.in_triangle(t) else {
                    return false;
                };
                let [q, s, r] = turned(places, first);
                self.lists.threes.push(Item { first, seeds, places: [q, s, r, 0.0], weights, ..Item::of(t) });
                true
            }
            (None, alone) => {
                let Some(ways) = self.borders.ways(corners, edges, owners) else { return false };
                match alone {
                    Some(first) => self.list_tip(t, first, turned(owners, first), turned(ways, first)),
                    None => self.list_apart(t, owners, ways),
                }
            }
        }
    }

    fn add_whole(&mut self, t: u32, i: u32) {
        let mut cell = Cell::default();
        self.scene.add_whole(i, t, &mut cell);
        let cell = if self.scene.sheet.is_interface(t) { cell.of_surface() } else { cell };
        self.sums.add(i, cell.numbers());
    }

    /// Lists a triangle whose corners have two owners and that has the tip of a third cell, if the three meet in it.
    fn list_tip(&mut self, triangle: u32, first: usize, [i, j, _]: [u32; 3], ways: [Way; 3]) -> bool {
        let (l, forward, places) = match ways {
            [Way::Through(l, [p, q]), _, Way::Across(r)] => (l, true, [p, q, r, 0.0]),
            [Way::Across(r), _, Way::Through(l, [q, p])] => (l, false, [1.0 - p, 1.0 - q, 1.0 - r, 0.0]),
            _ => return false,
        };
        let [j, k] = if forward { [l, j] } else { [j, l] };
        let Some(weights) = borders::meeting(self.scene, &mut self.walls, triangle, first, [j, k]) else {
            return false;
        };
        self.lists.crossings.push(crossing(self.scene, triangle, first, weights, [i, j, k]));
        let (seeds, weights) =
            if forward { ([i, j, k], weights) } else { ([i, k, j], [weights[0], weights[2], weights[1]]) };
        self.lists.tips.push(Item { first, forward, seeds, places, weights, ..Item::of(triangle) });
        true
    }

    /// Lists a triangle whose corners have three owners, if one of their cells keeps the others apart.
    fn list_apart(&mut self, triangle: u32, owners: [u32; 3], ways: [Way; 3]) -> bool {
        for first in 0..3 {
            let seeds = turned(owners, first);
            match turned(ways, first) {
                [Way::Across(q), Way::Through(l, [s, t]), Way::Across(r)] if l == seeds[0] => {
                    self.lists.aparts.push(Item { first, seeds, places: [q, s, t, r], ..Item::of(triangle) });
                    return true;
                }
                _ => {}
            }
        }
        false
    }
}

impl Item {
    /// Of which nothing is said but the triangle.
    fn of(triangle: u32) -> Item {
        Item { triangle, first: 0, forward: true, seeds: [0; 3], places: [0.0; 4], weights: [0.0; 3] }
    }
}

/// Triangles that are summed in a row.
#[derive(Default)]
struct Batch {
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
trait Shared<const SEEDS: usize> {
    /// What each has of a triangle that such numbers describe.
    fn moments(number: impl Fn(usize) -> f64) -> [[f64; NUMBERS]; SEEDS];
}

struct Two;

struct Three;

struct Apart;

struct Tip;

impl Batch {
    /// Adds `items` to `sums`.
    fn add<const SEEDS: usize, S: Shared<SEEDS>>(&mut self, scene: Scene, items: &[Item], sums: &mut Sums<NUMBERS>) {
        // Vectors are read long after their numbers were written one by one: else each would wait for all of these.
        for items in items.chunks(BLOCKS * LANES) {
            items.iter().enumerate().for_each(|(n, item)| self.blocks[n / LANES].set(n % LANES, item, scene));
            scene.arch.dispatch(Find::<SEEDS, S> { blocks: &mut self.blocks, kind: std::marker::PhantomData });
            (0..items.len()).for_each(|n| self.blocks[n / LANES].add::<SEEDS>(n % LANES, sums));
        }
    }
}

impl Block {
    /// Puts a triangle into lane `l`.
    #[inline]
    fn set(&mut self, l: usize, item: &Item, scene: Scene) {
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
        for n in 0..2 {
            put(OTHERS + 3 * n, points[seeds[n + 1] as usize] - seed);
        }
        for n in 0..4 {
            numbers[PLACES + n][l] = places[n];
        }
        for n in 0..3 {
            numbers[WEIGHTS + n][l] = weights[n];
            numbers[DENSITIES + n][l] = densities[order[n]];
        }
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
        let (corners, plane) = corners(&number);
        let (x, weights) = meeting(&number, corners);
        let places = [0, 1, 2].map(|n| number(PLACES + n));
        let on_edges = [0, 1, 2].map(|n| corners[n].to(corners[(n + 1) % 3], places[n]));
        let [second, third] = others(&number);
        let seeds = [[0.0; 3], second, third];
        [0, 1, 2].map(|n| {
            let (next, last) = ((n + 1) % 3, (n + 2) % 3);
            let [corner, out, x, back] = [corners[n], on_edges[n], x, on_edges[last]].map(|p| p.from(seeds[n]));
            let piece = plus(
                plane.piece([corner, out, x], places[n] * weights[last]),
                plane.piece([corner, x, back], (1.0 - places[last]) * weights[next]),
            );
            let piece = plane.with_cut(piece, minus(seeds[next], seeds[n]), [out, x]);
            plane.with_cut(piece, minus(seeds[last], seeds[n]), [x, back])
        })
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
    /// [`Cell::add_polygon`].
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

    /// A piece with its cut segment from `q` to `r`, on the bisector of the seed at 0 and the one at `other`: see
    /// [`Cell::add_tet`].
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

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::clipped_voronoi::Density;
    use crate::clipped_voronoi::owners::Owners;
    use crate::clipped_voronoi::sheet::Sheet;
    use crate::clipped_voronoi::surface_pieces::add_left;
    use crate::delaunay::Delaunay;
    use crate::geometry::frame::snap;
    use crate::rng::Rng;
    use crate::surface::Surface;

    /// Hands a scene with so many random seeds, and a density of the surface, to `look`.
    fn with_scene(surface: &Surface, count: usize, look: impl FnOnce(Scene)) {
        let mut rng = Rng::new(7, count as u64);
        let bounds = surface.points().iter().fold([DVec3::MAX, DVec3::MIN], |[a, b], &p| [a.min(p), b.max(p)]);
        let mut point =
            || DVec3::from_array([0, 1, 2].map(|k| rng.unit() * (bounds[1][k] - bounds[0][k]) + bounds[0][k]));
        let points: Vec<DVec3> = (0..count).map(|_| snap(point())).collect();
        let adjacency = Delaunay::build(&points).expect("points in general position").adjacency();
        let (mut sheet, mut owners, arch) = (Sheet::new(surface), Owners::default(), pulp::Arch::new());
        sheet.set_density(Density::Vertices(surface.points().iter().map(|p| 1.0 + p.x * p.x).collect()));
        owners.update(&sheet.points, &points, &adjacency, arch);
        let (adjacency, sheet, owners) = (&adjacency, &sheet, &owners);
        look(Scene { points: &points, adjacency, sheet, owners, arch, weights: None });
    }

    #[test]
    fn what_is_summed_at_once_is_what_cutting_one_by_one_finds() {
        for (file, count) in [("torus", 30), ("torus", 500), ("torus", 4_000), ("icosphere", 100), ("two_bodies", 300)]
        {
            let surface = crate::io::read_surface(format!("models/{file}.obj").as_ref()).expect("a surface");
            with_scene(&surface, count, |scene| {
                let (mut at_once, mut one_by_one) = (vec![Cell::default(); count], vec![Cell::default(); count]);
                let (mut crossings, left) = add(&mut at_once, scene);
                add_left(&mut at_once, scene, &left, &mut Vec::new(), &mut crossings);
                let all: Vec<u32> = (0..scene.sheet.triangles.len() as u32).collect();
                let mut expected = Vec::new();
                add_left(&mut one_by_one, scene, &all, &mut Vec::new(), &mut expected);
                for (i, (a, b)) in at_once.iter().zip(&one_by_one).enumerate() {
                    for (a, b) in a.numbers().into_iter().zip(b.numbers()) {
                        assert!((a - b).abs() < 1e-13, "{file}, {count} seeds, cell {i}: {a} {b}");
                    }
                }
                crossings.sort_by_key(|c| (c.facet, c.triangle));
                expected.sort_by_key(|c| (c.facet, c.triangle));
                assert_eq!(crossings.len(), expected.len(), "{file}, {count} seeds");
                for (a, b) in crossings.iter().zip(&expected) {
                    assert_eq!((a.facet, a.triangle, a.leaves), (b.facet, b.triangle, b.leaves));
                    assert!(a.point.distance(b.point) < 1e-10, "{file}, {count} seeds: {a:?} {b:?}");
                }
            });
        }
    }

    #[test]
    fn triangles_are_shared_in_every_way_and_nearly_all_of_small_ones() {
        let surface = crate::io::read_surface("models/torus.obj".as_ref()).expect("a surface");
        with_scene(&surface, 100, |scene| {
            let borders = Borders::find(scene);
            let mut sharing = Sharing::new(scene, &borders);
            let count = scene.sheet.triangles.len() as u32;
            let left = (0..count).filter(|&t| !sharing.take(t)).count();
            let Lists { twos, threes, aparts, tips, crossings } = &sharing.lists;
            let (forward, backward): (Vec<&Item>, Vec<&Item>) = tips.iter().partition(|t| t.forward);
            let counts = [twos.len(), threes.len(), aparts.len(), forward.len(), backward.len()];
            assert!(counts.iter().all(|&n| n >= 5), "{counts:?}");
            assert_eq!(crossings.len(), tips.len());
            assert!(left < count as usize / 50, "{left} of {count} are left");
        });
    }
}
