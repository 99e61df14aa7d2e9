//! Triangles that few cells share in one of four ways: nearly all where triangles are smaller than cells.
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
//! Where these places are, and that there is nothing else, `borders.rs` proves; `shared_sums.rs` adds them up. A triangle is
//! looked at once for all of its seeds, so that sums are gathered in blocks of triangles.

use rayon::prelude::*;

use super::Crossing;
use super::borders::{self, Borders, Meeting, Shared, Way, turned};
use super::cell::{Cell, NUMBERS, Sums, add_sums};
use super::crossings::{ascending, is_even};
use super::seen::{Look, Seen};
use super::shared_sums::{Apart, Batch, Item, One, Three, Tip, Two};
use super::surface_pieces::Scene;
use super::walls::Walls;

/// Triangles in a block of the work: fixed, so that sums do not depend on the number of threads.
const BLOCK: usize = 4096;

/// Adds to `cells` all triangles that are shared so; returns the crossings of Voronoi edges with these, and the triangles that
/// are left.
pub(super) fn add(cells: &mut [Cell], scene: Scene) -> (Vec<Crossing>, Vec<u32>) {
    let count = scene.sheet.triangles.len();
    let seen: Vec<Seen> = (0..count.div_ceil(BLOCK))
        .into_par_iter()
        .map_init(Look::default, |look, block| look.at(scene, block * BLOCK..count.min((block + 1) * BLOCK)))
        .collect();
    // Where the solid has a density, only what is whole in a cell is simple.
    let borders = scene.weights.is_none().then(|| Borders::find(scene, &Shared::new(&seen, scene.points.len())));
    let parts: Vec<_> =
        seen.par_iter().map_init(|| Sharing::new(scene, borders.as_ref()), |sharing, seen| sharing.add(seen)).collect();
    let mut crossings = borders.map_or_else(Vec::new, |borders| crossings(scene, &borders));
    let mut left = Vec::new();
    let mut sums = Vec::with_capacity(parts.len());
    for mut part in parts {
        sums.push(part.sums);
        crossings.append(&mut part.crossings);
        left.append(&mut part.left);
    }
    add_sums(cells, &sums, Cell::add_numbers);
    (crossings, left)
}

/// Where Voronoi edges meet triangles of three owners, sorted by facet.
fn crossings(scene: Scene, borders: &Borders) -> Vec<Crossing> {
    let net = &scene.sheet.net;
    let crossing = |meeting: &Meeting| {
        let Meeting { triangle: t, owners, first, weights } = *meeting;
        let straight = borders.are_straight(net.edges_of(t), scene.corner_owners(t));
        straight.then(|| crossing(scene, t, first, weights, owners))
    };
    borders.meetings().par_iter().filter_map(crossing).collect()
}

/// The crossing at a place of triangle `t`, with barycentric coordinates from corner `first` on, where the cells of three seeds,
/// of which the first owns that corner, are around it counter-clockwise.
fn crossing(scene: Scene, t: u32, first: usize, weights: [f64; 3], [i, j, k]: [u32; 3]) -> Crossing {
    let seed = scene.points[i as usize];
    let [a, b, c] = turned(scene.sheet.corners(t), first).map(|p| p - seed);
    let point = seed + a + (b - a) * weights[1] + (c - a) * weights[2];
    let facet = [i, j, k];
    Crossing { facet: ascending(facet), point, triangle: scene.sheet.of_surface(t), leaves: is_even(facet) }
}

/// The work of one thread.
struct Sharing<'a> {
    scene: Scene<'a>,
    borders: Option<&'a Borders>,
    sums: Sums<NUMBERS>,
    lists: Lists,
    batch: Box<Batch>,
    walls: Walls,
}

/// What it did in a block.
struct Part {
    sums: (Vec<u32>, Vec<[f64; NUMBERS]>),
    crossings: Vec<Crossing>,
    left: Vec<u32>,
}

/// How a triangle is shared, as far as that is seen at once.
#[derive(Clone, Copy)]
enum Kind {
    /// By two owners.
    Two,
    /// By three, and no edge leads elsewhere.
    Three,
    /// Any other.
    Other,
}

/// Triangles by the way in which they are shared.
#[derive(Default)]
struct Lists {
    by_kind: [Vec<u32>; 3],
    aparts: Vec<Item>,
    tips: Vec<Item>,
    /// Crossings in tips.
    crossings: Vec<Crossing>,
    /// What is not shared.
    left: Vec<u32>,
}

impl Lists {
    fn clear(&mut self) {
        let Lists { aparts, tips, crossings, left, .. } = self;
        [aparts, tips].into_iter().for_each(Vec::clear);
        crossings.clear();
        left.clear();
    }
}

impl<'a> Sharing<'a> {
    fn new(scene: Scene<'a>, borders: Option<&'a Borders>) -> Sharing<'a> {
        let (sums, lists) = (Sums::new(scene.points.len()), Lists::default());
        Sharing { scene, borders, sums, lists, batch: Box::default(), walls: Walls::default() }
    }

    /// Some triangles.
    fn add(&mut self, seen: &Seen) -> Part {
        self.lists.clear();
        self.add_wholes(&seen.whole);
        match self.borders {
            Some(borders) => self.add_shared(borders, &seen.shared),
            None => self.lists.left.extend(&seen.shared),
        }
        let Lists { crossings, left, .. } = &mut self.lists;
        Part { sums: self.sums.take(), crossings: std::mem::take(crossings), left: std::mem::take(left) }
    }

    /// Triangles that are whole in one cell.
    fn add_wholes(&mut self, triangles: &[u32]) {
        let Sharing { scene, batch, sums, .. } = self;
        let Some(weights) = scene.weights else {
            batch.add::<1, One>(*scene, triangles.iter().map(|&t| one(*scene, t)), sums);
            return;
        };
        for &t in triangles {
            let [i, _, _] = scene.corner_owners(t);
            let face = scene.sheet.face(t, scene.sheet.corners(t).map(|p| p - scene.points[i as usize]));
            let mut cell = Cell::default();
            cell.add_weighted_polygon(&face.corners, &face, weights.at_seed(i));
            let cell = if scene.sheet.is_interface(t) { cell.of_surface() } else { cell };
            sums.add(i, cell.numbers());
        }
    }

    /// Triangles that several owners share.
    fn add_shared(&mut self, borders: &Borders, triangles: &[u32]) {
        self.list(borders, triangles);
        let Sharing { scene, lists, batch, sums, .. } = self;
        batch.add::<2, Two>(*scene, lists.by_kind[Kind::Two as usize].iter().map(|&t| two(*scene, borders, t)), sums);
        self.add_threes(borders);
        let Sharing { scene, lists, batch, sums, .. } = self;
        batch.add::<3, Apart>(*scene, lists.aparts.iter().copied(), sums);
        batch.add::<3, Tip>(*scene, lists.tips.iter().copied(), sums);
    }

    /// Lists triangles, and those that are left.
    fn list(&mut self, borders: &Borders, triangles: &[u32]) {
        let Sharing { scene, lists, .. } = self;
        lists.by_kind.iter_mut().for_each(|list| list.resize(triangles.len() + 1, 0));
        let mut counts = [0; 3];
        for &t in triangles {
            let kind = kind(*scene, borders, t) as usize;
            lists.by_kind[kind][counts[kind]] = t;
            counts[kind] += 1;
        }
        lists.by_kind.iter_mut().zip(counts).for_each(|(list, count)| list.truncate(count));
        let others = std::mem::take(&mut self.lists.by_kind[Kind::Other as usize]);
        for &t in &others {
            if !self.list_other(borders, t) {
                self.lists.left.push(t);
            }
        }
        self.lists.by_kind[Kind::Other as usize] = others;
    }

    /// Adds the triangles of three owners whose cells meet in them.
    fn add_threes(&mut self, borders: &Borders) {
        let Sharing { scene, lists, batch, sums, .. } = self;
        let Lists { by_kind, left, .. } = lists;
        let item = |&t: &u32| {
            let Some(&Meeting { first, owners: seeds, weights, .. }) = borders.in_triangle(t) else {
                left.push(t);
                return None;
            };
            let places =
                borders.places(scene.sheet.triangles[t as usize], scene.sheet.net.edges_of(t), scene.corner_owners(t));
            let [q, s, r] = turned(places, first);
            Some(Item { first, seeds, places: [q, s, r, 0.0], weights, ..Item::of(t) })
        };
        batch.add::<3, Three>(*scene, by_kind[Kind::Three as usize].iter().filter_map(item), sums);
    }

    /// Lists a triangle that is none of the other kinds; whether it is shared.
    fn list_other(&mut self, borders: &Borders, t: u32) -> bool {
        let (corners, edges) = (self.scene.sheet.triangles[t as usize], self.scene.sheet.net.edges_of(t));
        let owners = self.scene.corner_owners(t);
        let Some(ways) = borders.ways(corners, edges, owners) else { return false };
        let [i, j, k] = owners;
        if i != j && j != k && k != i {
            return self.list_apart(t, owners, ways);
        }
        let first = alone(owners);
        self.list_tip(t, first, turned(owners, first), turned(ways, first))
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

/// The kind of a triangle.
#[inline(always)]
fn kind(scene: Scene, borders: &Borders, t: u32) -> Kind {
    let owners = scene.corner_owners(t);
    let [i, j, k] = owners;
    let two = (i == j) | (j == k) | (k == i);
    let straight = borders.are_straight(scene.sheet.net.edges_of(t), owners);
    [[Kind::Other, Kind::Other], [Kind::Three, Kind::Two]][usize::from(straight)][usize::from(two)]
}

/// Of three corners that have two owners the one that stands alone.
#[inline(always)]
fn alone([i, j, k]: [u32; 3]) -> usize {
    if j == k {
        0
    } else if k == i {
        1
    } else {
        2
    }
}

/// A triangle that is whole in one cell.
#[inline(always)]
fn one(scene: Scene, t: u32) -> Item {
    Item { seeds: [scene.corner_owners(t)[0]; 3], ..Item::of(t) }
}

/// A triangle that two cells share.
#[inline(always)]
fn two(scene: Scene, borders: &Borders, t: u32) -> Item {
    let owners = scene.corner_owners(t);
    let first = alone(owners);
    let places = borders.places(scene.sheet.triangles[t as usize], scene.sheet.net.edges_of(t), owners);
    let ([q, _, r], [i, j, _]) = (turned(places, first), turned(owners, first));
    Item { first, seeds: [i, j, j], places: [q, 0.0, r, 0.0], ..Item::of(t) }
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

    /// A torus with so many sides around its axis, and half as many around its tube.
    fn torus(sides: u32) -> Surface {
        let around = |k: u32, n: u32| (std::f64::consts::TAU * f64::from(k) / f64::from(n)).sin_cos();
        let (long, short) = (sides, sides / 2);
        let place = |k: u32| {
            let ((sin, cos), (rise, out)) = (around(k / short, long), around(k % short, short));
            DVec3::new((1.0 + 0.4 * out) * cos, (1.0 + 0.4 * out) * sin, 0.4 * rise)
        };
        let points: Vec<DVec3> = (0..long * short).map(place).collect();
        let number = |i: u32, j: u32| i % long * short + j % short;
        let quad = |k: u32| {
            let (i, j) = (k / short, k % short);
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let triangles: Vec<[u32; 3]> = (0..long * short).flat_map(quad).collect();
        let each: Vec<u32> = (0..triangles.len() as u32).collect();
        Surface::new(&points, &triangles, &each, &each).expect("a closed surface")
    }

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
        for (sides, count) in [(60, 30), (60, 500), (60, 4_000), (20, 200), (150, 100)] {
            let surface = torus(sides);
            with_scene(&surface, count, |scene| {
                let (mut at_once, mut one_by_one) = (vec![Cell::default(); count], vec![Cell::default(); count]);
                let (mut crossings, left) = add(&mut at_once, scene);
                add_left(&mut at_once, scene, &left, &mut Vec::new(), &mut crossings);
                let all: Vec<u32> = (0..scene.sheet.triangles.len() as u32).collect();
                let mut expected = Vec::new();
                add_left(&mut one_by_one, scene, &all, &mut Vec::new(), &mut expected);
                for (i, (a, b)) in at_once.iter().zip(&one_by_one).enumerate() {
                    for (a, b) in a.numbers().into_iter().zip(b.numbers()) {
                        assert!((a - b).abs() < 1e-13, "{sides} sides, {count} seeds, cell {i}: {a} {b}");
                    }
                }
                crossings.sort_by_key(|c| (c.facet, c.triangle));
                expected.sort_by_key(|c| (c.facet, c.triangle));
                assert_eq!(crossings.len(), expected.len(), "{sides} sides, {count} seeds");
                for (a, b) in crossings.iter().zip(&expected) {
                    assert_eq!((a.facet, a.triangle, a.leaves), (b.facet, b.triangle, b.leaves));
                    assert!(a.point.distance(b.point) < 1e-10, "{sides} sides, {count} seeds: {a:?} {b:?}");
                }
            });
        }
    }

    #[test]
    fn triangles_are_shared_in_every_way_and_nearly_all_of_small_ones() {
        let surface = torus(60);
        with_scene(&surface, 100, |scene| {
            let count = scene.sheet.triangles.len();
            let seen = [Look::default().at(scene, 0..count)];
            let borders = Borders::find(scene, &Shared::new(&seen, scene.points.len()));
            let mut sharing = Sharing::new(scene, Some(&borders));
            sharing.list(&borders, &seen[0].shared);
            sharing.add_threes(&borders);
            let Lists { by_kind: [twos, threes, _], aparts, tips, crossings, left } = &sharing.lists;
            let (forward, backward): (Vec<&Item>, Vec<&Item>) = tips.iter().partition(|t| t.forward);
            let counts = [twos.len(), threes.len(), aparts.len(), forward.len(), backward.len()];
            assert!(counts.iter().all(|&n| n >= 5), "{counts:?}");
            assert_eq!(crossings.len(), tips.len());
            assert!(left.len() < count / 50, "{} of {count} are left", left.len());
        });
    }
}
