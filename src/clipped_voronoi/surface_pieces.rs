//! The surface cut up by the Voronoi cells: pieces of triangles, cut segments, crossings of Voronoi edges.
//!
//! 1. Every vertex of the surface has an owner (`owners.rs`). A triangle whose three are one seed's is in its cell whole, cells
//!    being convex; nearly all others are shared by few cells in a way that is simple to prove (`borders.rs`) and to sum, where
//!    triangles are smaller than cells (`shares.rs`).
//! 2. A seed owns a piece of every other triangle at its vertices: what its bisectors leave of it, which the edges at its own
//!    vertices show nearly always (`outline.rs`), and clipping always (`polygon.rs`).
//! 3. Which further seeds own a piece of a triangle follows by spreading over the bisectors that cut it: Yan, Lévy, Liu, Sun,
//!    Wang, *Isotropic remeshing with fast and exact computation of restricted Voronoi diagram*, Computer Graphics Forum
//!    28(5), 2009, doi 10.1111/j.1467-8659.2009.01521.x. Those of the last time are tried first, all at once.
//!
//! Departure: where pieces are cut, cells, not triangles, are gone through, so that each sum has one writer and its order does
//! not depend on the number of threads; and a cell's bisectors meet the corners of all of its triangles at once, in vectors
//! (`planes.rs`), as most pieces are summed (`slices.rs`).

use glam::DVec3;
use rayon::prelude::*;

use super::bisector::View;
use super::cell::Cell;
use super::outline::{Cuts, Exits, Outline};
use super::owners::Owners;
use super::planes::Planes;
use super::polygon::{Line, Polygon};
use super::sheet::Sheet;
use super::slices::{Part, Slices};
use super::vertices::Vertices;
use super::weighted::Weights;
use super::{Crossing, SEEDS, shares};
use crate::bucket_sort::sorted_by_bucket;
use crate::delaunay::Adjacency;
use crate::geometry::predicates::Sign;

/// Pieces without a corner of their triangle that one thread cuts in a row.
const BLOCK: usize = 128;

/// A seed and a triangle of the sheet.
pub(super) type Pair = (u32, u32);

/// What cutting looks at.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) points: &'a [DVec3],
    pub(super) adjacency: &'a Adjacency,
    pub(super) sheet: &'a Sheet<'a>,
    pub(super) owners: &'a Owners,
    pub(super) arch: pulp::Arch,
    /// Where the solid has a density.
    pub(super) weights: Option<Weights<'a>>,
}

/// Cuts for one thread; its buffers are reused.
struct Cutter<'a> {
    scene: Scene<'a>,
    planes: Planes,
    exits: Exits,
    polygon: Polygon,
    slices: Slices,
    corners: Vec<DVec3>,
    /// Triangles to be cut for one seed, with the places of their corners among these.
    triangles: Vec<(u32, [u32; 3])>,
    vertices: Vertices,
    crossings: Vec<Crossing>,
    /// Seeds that own a piece of a triangle but none of its corners.
    beyond: Vec<Pair>,
}

/// Adds the surface to `cells`; returns the crossings of Voronoi edges, by facet.
///
/// `cornerless` are pairs of a seed and a triangle of which it owns a piece but no corner, and which are cut one by one: guesses,
/// then those that are so.
pub(super) fn add_pieces(cells: &mut [Cell], scene: Scene, cornerless: &mut Vec<Pair>) -> Vec<Crossing> {
    // 1. Triangles that few cells share in a simple way.
    let (mut crossings, left) = shares::add(cells, scene);
    // 2. Others.
    add_left(cells, scene, &left, cornerless, &mut crossings);
    // Most are in order already.
    crossings.par_sort_by_key(|c| (c.facet, c.triangle));
    crossings
}

/// Adds to `cells` and `crossings` what cutting the triangles `left` one by one finds.
pub(super) fn add_left(
    cells: &mut [Cell],
    scene: Scene,
    left: &[u32],
    cornerless: &mut Vec<Pair>,
    crossings: &mut Vec<Crossing>,
) {
    let mut is_left = vec![false; scene.sheet.triangles.len()];
    left.iter().for_each(|&t| is_left[t as usize] = true);
    let mut todo = std::mem::take(cornerless);
    todo.retain(|&(i, t)| {
        (i as usize) < scene.points.len() && is_left[t as usize] && !scene.corner_owners(t).contains(&i)
    });
    // 1. Seeds that own corners.
    add_own(cells, scene, left, &mut todo, crossings);
    // 2. Others.
    let mut pieces = add_cornerless(scene, todo, crossings);
    // Guesses, nearly all of them, are in order already.
    pieces.sort_by_key(|p| p.0);
    for ((i, _), piece) in &pieces {
        cells[*i as usize].add(piece);
    }
    cornerless.extend(pieces.into_iter().map(|p| p.0));
}

/// Adds to `cells` the pieces of `triangles` that belong to the owners of their corners; adds other owners of pieces to `beyond`.
fn add_own(cells: &mut [Cell], scene: Scene, triangles: &[u32], beyond: &mut Vec<Pair>, crossings: &mut Vec<Crossing>) {
    let mut own: Vec<Pair> = Vec::new();
    for &t in triangles {
        let [a, b, c] = scene.corner_owners(t);
        own.push((a, t));
        own.extend((b != a).then_some((b, t)));
        own.extend((c != a && c != b).then_some((c, t)));
    }
    let own = sorted_by_bucket(&own, cells.len(), |pair| pair.0);
    let by_seed: Vec<&[Pair]> = own.chunk_by(|a, b| a.0 == b.0).collect();
    let parts: Vec<_> = by_seed
        .par_chunks(SEEDS)
        .map_init(
            || Cutter::new(scene),
            |cutter, seeds| {
                let sums: Vec<(u32, Cell)> = seeds.iter().map(|pairs| (pairs[0].0, cutter.cut_own(pairs))).collect();
                (sums, cutter.take())
            },
        )
        .collect();
    for (sums, (mut more, mut others)) in parts {
        sums.into_iter().for_each(|(i, sum)| cells[i as usize].add(&sum));
        crossings.append(&mut more);
        beyond.append(&mut others);
    }
}

/// The pieces of seeds that own no corner of their triangle: those of `todo` that there are, and all that they lead to.
fn add_cornerless(scene: Scene, mut todo: Vec<Pair>, crossings: &mut Vec<Crossing>) -> Vec<(Pair, Cell)> {
    let mut pieces = Vec::new();
    let mut known: Vec<Pair> = Vec::new();
    loop {
        todo.sort_unstable_by_key(|&(i, t)| u64::from(i) << 32 | u64::from(t));
        todo.dedup();
        todo.retain(|pair| known.binary_search(pair).is_err());
        if todo.is_empty() {
            return pieces;
        }
        let parts: Vec<_> = todo
            .par_chunks(BLOCK)
            .map_init(
                || Cutter::new(scene),
                |cutter, pairs| {
                    let mut pieces = Vec::new();
                    for of_seed in pairs.chunk_by(|a, b| a.0 == b.0) {
                        cutter.cut_cornerless(of_seed, &mut pieces);
                    }
                    (pieces, cutter.take())
                },
            )
            .collect();
        known.append(&mut todo);
        known.sort();
        for (mut found, (mut more, mut beyond)) in parts {
            pieces.append(&mut found);
            crossings.append(&mut more);
            todo.append(&mut beyond);
        }
    }
}

impl Scene<'_> {
    /// The owners of the corners of triangle `t`.
    #[inline]
    pub(super) fn corner_owners(&self, t: u32) -> [u32; 3] {
        self.sheet.triangles[t as usize].map(|v| self.owners.of()[v as usize])
    }
}

impl<'a> Cutter<'a> {
    fn new(scene: Scene<'a>) -> Cutter<'a> {
        Cutter {
            scene,
            planes: Planes::default(),
            exits: Exits::default(),
            polygon: Polygon::default(),
            slices: Slices::default(),
            corners: Vec::new(),
            triangles: Vec::new(),
            vertices: Vertices::new(scene.sheet.points.len()),
            crossings: Vec::new(),
            beyond: Vec::new(),
        }
    }

    /// Hands out what was found.
    fn take(&mut self) -> (Vec<Crossing>, Vec<Pair>) {
        (std::mem::take(&mut self.crossings), std::mem::take(&mut self.beyond))
    }

    /// The pieces of the triangles of `pairs`, all of one seed, which owns corners of theirs; of interfaces, which do not end the
    /// solid, the area alone.
    fn cut_own(&mut self, pairs: &[Pair]) -> Cell {
        let mut cell = self.cut_own_of(pairs, false);
        if self.scene.sheet.surface.has_interfaces() {
            cell.add(&self.cut_own_of(pairs, true).of_surface());
        }
        cell
    }

    /// The same for triangles that are interfaces, or are none.
    fn cut_own_of(&mut self, pairs: &[Pair], interface: bool) -> Cell {
        let Scene { points, sheet, arch, .. } = self.scene;
        let i = pairs[0].0;
        self.clear();
        for &(_, t) in pairs.iter().filter(|p| sheet.is_interface(p.1) == interface) {
            self.add_triangle(t, points[i as usize]);
        }
        let (mut cell, from) = (Cell::default(), self.crossings.len());
        self.test(i);
        for n in 0..self.triangles.len() {
            self.cut(i, n, &mut cell);
        }
        self.slices.take(arch, &mut cell);
        self.crossings[from..].sort_unstable_by_key(|c| (c.facet, c.triangle));
        cell
    }

    /// Cuts the triangles of `pairs`, all of one seed, which owns no corner of theirs.
    fn cut_cornerless(&mut self, pairs: &[Pair], pieces: &mut Vec<(Pair, Cell)>) {
        let i = pairs[0].0;
        let sheet = self.scene.sheet;
        self.clear();
        pairs.iter().for_each(|p| self.add_triangle(p.1, self.scene.points[i as usize]));
        self.test(i);
        for (n, &pair) in pairs.iter().enumerate() {
            let mut piece = Cell::default();
            if self.cut(i, n, &mut piece) {
                self.slices.take(self.scene.arch, &mut piece);
                let interface = sheet.is_interface(pair.1);
                pieces.push((pair, if interface { piece.of_surface() } else { piece }));
            }
        }
    }

    /// No triangles.
    fn clear(&mut self) {
        self.triangles.clear();
        self.vertices.clear();
        self.exits.clear();
    }

    /// One more triangle to be cut.
    fn add_triangle(&mut self, t: u32, seed: DVec3) {
        let [a, b, c] = self.scene.sheet.triangles[t as usize];
        let Scene { sheet, owners, .. } = self.scene;
        let place = [a, b, c].map(|v| self.vertices.add(v, sheet.points[v as usize], owners.of()[v as usize], seed));
        self.triangles.push((t, place));
    }

    /// Finds the bisectors of seed `i` that may cut its triangles.
    fn test(&mut self, i: u32) {
        if !self.triangles.is_empty() {
            let Scene { points, adjacency, arch, .. } = self.scene;
            let at = self.vertices.at.iter().copied();
            self.planes.set(arch, points[i as usize], adjacency.of(i as usize), points, at);
        }
    }

    /// Cuts the `n`th triangle by the cell of seed `i` and adds the piece, its cut segments and its crossings; notes the
    /// seeds across its edges. Whether there is a piece.
    fn cut(&mut self, i: u32, n: usize, cell: &mut Cell) -> bool {
        self.add_outlined(i, n) || self.clip(i, n, cell)
    }

    /// The same for any piece.
    #[inline(never)]
    fn clip(&mut self, i: u32, n: usize, cell: &mut Cell) -> bool {
        let Scene { points, sheet, .. } = self.scene;
        let (t, places) = self.triangles[n];
        let places = places.map(|k| k as usize);
        let view = View { corners: places.map(|k| self.vertices.at[k]), seed: points[i as usize] };
        let face = sheet.face(t, places.map(|k| self.vertices.from_seed[k]));
        let owners = places.map(|k| self.vertices.owners[k]);
        self.planes.cutting(places, &mut self.polygon.bisectors);
        self.polygon.clip(&view);
        if self.polygon.lines.is_empty() {
            return false;
        }
        let mut corners = std::mem::take(&mut self.corners);
        self.polygon.positions(&view, face.corners, face.ids, &mut corners);
        match &self.scene.weights {
            None => cell.add_polygon(&corners, face.normal(), face.density),
            Some(weights) => cell.add_weighted_polygon(&corners, &face, weights.at_seed(i)),
        }
        let n = corners.len();
        for m in 0..n {
            let Line::Bisector(here) = self.polygon.lines[m] else { continue };
            let j = self.polygon.bisectors[here as usize].seed;
            // The cut segment closes the facet i|j, which sees the surface from the other side.
            let middle = (points[j as usize] - view.seed) * 0.5;
            let segment = [corners[if m + 1 < n { m + 1 } else { 0 }], corners[m]];
            match &self.scene.weights {
                None => cell.add_tet(middle, segment[0], segment[1]),
                Some(weights) => {
                    let [from, to] = segment.map(|p| face.solid_at(p));
                    let densities = [weights.at_seed(i), weights.between(i, j), from, to];
                    cell.add_weighted_tet([middle, segment[0], segment[1]], densities);
                }
            }
            if !owners.contains(&j) {
                self.beyond.push((j, t));
            }
            if let Line::Bisector(before) = self.polygon.lines[if m > 0 { m - 1 } else { n - 1 }] {
                let [j, k] = [before, here].map(|b| &self.polygon.bisectors[b as usize]);
                add_crossing(&mut self.crossings, sheet.of_surface(t), i, [j.seed, k.seed], || {
                    let turned = (j.seed < k.seed) == (view.turn(j, k) == Sign::Positive);
                    (turned, view.seed + corners[m])
                });
            }
        }
        self.corners = corners;
        true
    }

    /// Adds the piece of a triangle where all is seen from the corners that the seed owns; whether it is.
    fn add_outlined(&mut self, i: u32, n: usize) -> bool {
        let (t, places) = self.triangles[n];
        let places = places.map(|k| k as usize);
        let owners = places.map(|k| self.vertices.owners[k]);
        let Some(outline) = Outline::new(places, owners.map(|o| o == i)) else { return false };
        if self.scene.weights.is_some() {
            return false;
        }
        let Some(cuts) = outline.cuts(&self.planes, &mut self.exits) else { return false };
        let sheet = self.scene.sheet;
        let from_seed = &self.vertices.from_seed;
        let density = sheet.density_on(t, from_seed[places[0]]);
        let part = |[a, b, c]: [usize; 3], single| Part {
            corners: [&from_seed[a], &from_seed[b], &from_seed[c]],
            single,
            density,
        };
        let [alone, to_q, to_r] = outline.corners;
        let whole = part(outline.corners, outline.single);
        let seeds = match cuts {
            Cuts::Once(j, form) => {
                let (seed, to) = self.planes.neighbor(j);
                self.slices.add_once(whole, 1.0, form, to);
                [seed; 2]
            }
            Cuts::Twice(both, forms, meeting) => {
                let [(j, to_j), (k, to_k)] = both.map(|n| self.planes.neighbor(n));
                self.slices.add_twice(whole, forms, [to_j, to_k]);
                add_crossing(&mut self.crossings, sheet.of_surface(t), i, [j, k], || {
                    // The corners run the other way around where two are left.
                    let turned = (j < k) == (meeting.turns() == outline.single);
                    let at = meeting.within(outline.corners.map(|c| from_seed[c]));
                    (turned, self.scene.points[i as usize] + at)
                });
                [j, k]
            }
            Cuts::Apart(both, [at_q, at_r]) => {
                let [(j, to_j), (k, to_k)] = both.map(|n| self.planes.neighbor(n));
                // What the first leaves of the triangle, less what the second cuts off.
                self.slices.add_once(part([to_q, alone, to_r], false), 1.0, at_q.reordered([1, 0, 2]), to_j);
                self.slices.add_once(part([to_r, alone, to_q], true), -1.0, at_r.reordered([2, 0, 1]), to_k);
                [j, k]
            }
        };
        self.beyond.extend(seeds.into_iter().filter(|j| !owners.contains(j)).map(|j| (j, t)));
        true
    }
}

/// Records the crossing where the bisectors of seed `i` and two others, in any order, meet on a triangle, if `i` is the least of
/// the three, which all see it. `found` says whether (x_j - x_i) x (x_k - x_i), with j < k, points to the outer side, and where.
fn add_crossing(
    crossings: &mut Vec<Crossing>,
    triangle: u32,
    i: u32,
    [j, k]: [u32; 2],
    found: impl FnOnce() -> (bool, DVec3),
) {
    if i < j && i < k {
        let (leaves, point) = found();
        crossings.push(Crossing { facet: [i, j.min(k), j.max(k)], point, triangle, leaves });
    }
}
