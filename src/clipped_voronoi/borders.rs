//! Where the borders of the cells cross the edges of the sheet and meet within its triangles, proven in vectors: nearly
//! everywhere, where triangles are smaller than cells.
//!
//! * An edge between vertices of two owners meets their bisector in one point. If it is in both cells, each of the edge's two
//!   parts is in one of them whole, cells being convex. Else it may pass through a third cell, if it leaves that of either end
//!   into the same.
//! * The bisectors of three seeds meet in one point of a triangle's plane. If it is in the triangle and in their cells, and
//!   nothing but these is on the edges, the cells of the three hold all of the triangle: each what is between that point and its
//!   part of the boundary.
//!
//! A point of the bisector of two seeds is in both cells if no other neighbour of the one is nearer: see `walls.rs`. Where the
//! margin is not met nothing is said, and `polygon.rs` decides exactly.

use rayon::prelude::*;

use super::SEEDS;
use super::groups::Groups;
use super::seen::{Edge, Seen, Triangle};
use super::surface_pieces::Scene;
use super::walls::{LANES, Lanes, Walls, get, in_triangle, on_edge, set};

/// Edges that one thread looks at in a row.
const BLOCK: usize = 256;

/// No meeting in a triangle, no passage of an edge.
const NONE: u32 = u32::MAX;

/// What was proven.
pub(super) struct Borders {
    /// For each edge, where the cells of its ends' owners part it: 0 at the vertex with the lesser number, 1 at the other; NaN
    /// where that is not proven.
    places: Vec<f64>,
    /// Edges through a third cell.
    passages: Vec<Passage>,
    /// For each edge, its place among these, if it is one.
    of_edges: Vec<u32>,
    /// For each triangle, its place among the meetings, if it has one.
    of_triangles: Vec<u32>,
    meetings: Vec<Meeting>,
}

/// An edge that passes through one cell on its way between those of its ends' owners.
#[derive(Clone, Copy)]
struct Passage {
    edge: u32,
    cell: u32,
    /// Where it comes in and goes out, from the vertex with the lesser number.
    places: [f64; 2],
}

/// How an edge leads from the cell of its first vertex's owner to that of the other's.
#[derive(Clone, Copy)]
pub(super) enum Way {
    /// It stays in the same cell.
    Within,
    /// Straight, at such a share of its length.
    Across(f64),
    /// Through a third cell, between two places.
    Through(u32, [f64; 2]),
}

/// Where the cells of the three corners of a triangle meet.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    pub(super) triangle: u32,
    /// The owners of its corners, from the least on, in the triangle's order; and which of its corners is that one's.
    pub(super) owners: [u32; 3],
    pub(super) first: usize,
    /// Barycentric coordinates, in the same order.
    pub(super) weights: [f64; 3],
}

impl Borders {
    /// All that is simple of what several seeds own.
    pub(super) fn find(scene: Scene, shared: &Shared) -> Borders {
        let net = &scene.sheet.net;
        let seeds = scene.points.len();
        let parts: Vec<Proofs> = (0..seeds.div_ceil(SEEDS))
            .into_par_iter()
            .map_init(Prover::default, |prover, block| {
                let mut proofs = Proofs::default();
                for i in block * SEEDS..((block + 1) * SEEDS).min(seeds) {
                    prover.prove(scene, i as u32, shared, &mut proofs);
                }
                proofs
            })
            .collect();
        let mut borders = Borders {
            places: vec![f64::NAN; net.edges()],
            passages: Vec::new(),
            of_edges: vec![NONE; net.edges()],
            of_triangles: vec![NONE; scene.sheet.triangles.len()],
            meetings: Vec::with_capacity(parts.iter().map(|p| p.meetings.len()).sum()),
        };
        let mut open = Vec::new();
        for Proofs { places, meetings, open: mut more } in parts {
            places.into_iter().for_each(|(edge, place)| borders.places[edge as usize] = place);
            for meeting in meetings {
                borders.of_triangles[meeting.triangle as usize] = borders.meetings.len() as u32;
                borders.meetings.push(meeting);
            }
            open.append(&mut more);
        }
        borders.passages = passages(scene, &open);
        for (n, passage) in (0..).zip(&borders.passages) {
            borders.of_edges[passage.edge as usize] = n;
        }
        borders
    }

    /// Whether it is proven of the edges of a triangle with such owners that all lead straight from one cell into another.
    #[inline(always)]
    pub(super) fn are_straight(&self, edges: [u32; 3], [i, j, k]: [u32; 3]) -> bool {
        let [a, b, c] = edges.map(|e| self.places[e as usize].is_nan());
        !((a & (i != j)) | (b & (j != k)) | (c & (k != i)))
    }

    /// Where they do, each on its way around; 0 or 1 where it stays within.
    #[inline(always)]
    pub(super) fn places(&self, corners: [u32; 3], edges: [u32; 3], owners: [u32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|c| {
            let next = if c < 2 { c + 1 } else { 0 };
            let place = if owners[c] == owners[next] { 0.0 } else { self.places[edges[c] as usize] };
            if corners[c] < corners[next] { place } else { 1.0 - place }
        })
    }

    /// How the edges of a triangle with such corners, edges and owners lead from one to the next, where that is proven.
    pub(super) fn ways(&self, corners: [u32; 3], edges: [u32; 3], owners: [u32; 3]) -> Option<[Way; 3]> {
        let mut ways = [Way::Within; 3];
        for c in 0..3 {
            let next = if c < 2 { c + 1 } else { 0 };
            if owners[c] == owners[next] {
                continue;
            }
            let (place, forward) = (self.places[edges[c] as usize], corners[c] < corners[next]);
            ways[c] = if place.is_nan() {
                let &Passage { cell, places: [a, b], .. } =
                    self.passages.get(self.of_edges[edges[c] as usize] as usize)?;
                Way::Through(cell, if forward { [a, b] } else { [1.0 - b, 1.0 - a] })
            } else {
                Way::Across(if forward { place } else { 1.0 - place })
            };
        }
        Some(ways)
    }

    /// Where the cells of the corners of triangle `t` meet.
    #[inline]
    pub(super) fn in_triangle(&self, t: u32) -> Option<&Meeting> {
        self.meetings.get(self.of_triangles[t as usize] as usize)
    }

    /// All meetings, by facet.
    pub(super) fn meetings(&self) -> &[Meeting] {
        &self.meetings
    }
}

/// An edge that does not lead straight from one cell to another: its number, and its vertices.
type Open = (u32, [u32; 2]);

/// Which of these edges pass through a third cell.
fn passages(scene: Scene, open: &[Open]) -> Vec<Passage> {
    let through = |walls: &mut [Walls; 2], &(edge, [u, v]): &Open| {
        let [i, j] = [u, v].map(|v| scene.owners.of()[v as usize]);
        let ends = |seed: u32| [u, v].map(|v| scene.sheet.points[v as usize] - scene.points[seed as usize]);
        walls[0].set(scene, i);
        let (cell, a) = walls[0].exit(scene.arch, ends(i))?;
        // Many edges in a row pass through the same.
        walls[1].set(scene, cell);
        let b = walls[1].border(scene.arch, ends(cell), (j, scene.points[j as usize] - scene.points[cell as usize]))?;
        let [a, b] = if u < v { [a, b] } else { [1.0 - b, 1.0 - a] };
        (a < b).then_some(Passage { edge, cell, places: [a, b] })
    };
    let found: Vec<Vec<Passage>> = open
        .par_chunks(BLOCK)
        .map_init(<[Walls; 2]>::default, |walls, open| open.iter().filter_map(|edge| through(walls, edge)).collect())
        .collect();
    found.concat()
}

/// Where the cell of the owner of corner `c` of triangle `t` meets those of two others in it, these three counter-clockwise.
pub(super) fn meeting(scene: Scene, walls: &mut Walls, t: u32, c: usize, others: [u32; 2]) -> Option<[f64; 3]> {
    let i = scene.corner_owners(t)[c];
    let seed = scene.points[i as usize];
    walls.set(scene, i);
    let corners = turned(scene.sheet.corners(t), c).map(|p| p - seed);
    walls.meeting(scene.arch, corners, others.map(|j| (j, scene.points[j as usize] - seed)))
}

/// The same three, from the one at `first` on.
#[inline]
pub(super) fn turned<T: Copy>(three: [T; 3], first: usize) -> [T; 3] {
    [0, 1, 2].map(|n| three[(first + n) % 3])
}

/// What one thread found in a row.
#[derive(Default)]
struct Proofs {
    places: Vec<(u32, f64)>,
    meetings: Vec<Meeting>,
    open: Vec<Open>,
}

/// Edges and triangles, by seed.
#[derive(Default)]
pub(super) struct Shared {
    edges: Groups<Edge>,
    triangles: Groups<Triangle>,
}

impl Shared {
    /// Of what is seen, over so many seeds.
    pub(super) fn new(seen: &[Seen], seeds: usize) -> Shared {
        let mut shared = Shared::default();
        shared.edges.set(seeds, seen.iter().map(|s| s.edges.iter().map(|e| (e.seed, *e))));
        shared.triangles.set(seeds, seen.iter().map(|s| s.triangles.iter().map(|t| (t.seed, *t))));
        shared
    }
}

/// Buffers of one thread, and the cell at hand.
#[derive(Default)]
struct Prover {
    walls: Walls,
    on_edges: Vec<OnEdges>,
    in_triangles: Vec<InTriangles>,
    /// Which of a triangle's corners is the seed's, and the owners of the next ones.
    triangles: Vec<(usize, [u32; 2])>,
}

/// As many edges: their ends and the other seeds, relative to the seed; and what was found.
#[derive(Default)]
struct OnEdges {
    from: [Lanes; 3],
    to: [Lanes; 3],
    other: [Lanes; 3],
    place: Lanes,
    at: [Lanes; 3],
    clear: [bool; LANES],
}

/// As many triangles: their corners, the own one first, and the other seeds, relative to the seed; and what was found.
#[derive(Default)]
struct InTriangles {
    corners: [[Lanes; 3]; 3],
    others: [[Lanes; 3]; 2],
    weights: [Lanes; 3],
    at: [Lanes; 3],
    clear: [bool; LANES],
}

impl Prover {
    /// What the cell of seed `i` proves: edges and triangles between it and seeds with greater numbers.
    fn prove(&mut self, scene: Scene, i: u32, shared: &Shared, proofs: &mut Proofs) {
        let (edges, triangles) = (shared.edges.of(i), shared.triangles.of(i));
        if edges.is_empty() {
            return;
        }
        self.list(scene, i, edges, triangles);
        self.walls.set(scene, i);
        let meetings = proofs.meetings.len();
        scene.arch.dispatch(Prove { prover: self, proofs, i, edges, triangles, owners: scene.owners.of() });
        proofs.meetings[meetings..].sort_unstable_by_key(|m| {
            let [_, j, k] = m.owners;
            (j.min(k), j.max(k), m.triangle)
        });
    }

    /// Lists the edges and triangles of the cell.
    fn list(&mut self, scene: Scene, i: u32, edges: &[Edge], triangles: &[Triangle]) {
        let Scene { points, sheet, owners, .. } = scene;
        let (of, seed) = (owners.of(), points[i as usize]);
        for (n, &Edge { vertices: [from, to], .. }) in edges.iter().enumerate() {
            let (block, l) = next(&mut self.on_edges, n);
            set(&mut block.from, l, sheet.points[from as usize] - seed);
            set(&mut block.to, l, sheet.points[to as usize] - seed);
            set(&mut block.other, l, points[of[to as usize] as usize] - seed);
        }
        self.triangles.clear();
        for (n, &Triangle { id, .. }) in triangles.iter().enumerate() {
            let of_corners = scene.corner_owners(id);
            let first = if of_corners[0] == i { 0 } else { 1 + usize::from(of_corners[2] == i) };
            let [_, j, k] = turned(of_corners, first);
            let (block, l) = next(&mut self.in_triangles, n);
            for (at, p) in block.corners.iter_mut().zip(turned(sheet.corners(id), first)) {
                set(at, l, p - seed);
            }
            for (at, j) in block.others.iter_mut().zip([j, k]) {
                set(at, l, points[j as usize] - seed);
            }
            self.triangles.push((first, [j, k]));
        }
    }
}

/// The block and the lane of item `n`.
#[inline]
fn next<T: Default>(blocks: &mut Vec<T>, n: usize) -> (&mut T, usize) {
    if n / LANES == blocks.len() {
        blocks.push(T::default());
    }
    (&mut blocks[n / LANES], n % LANES)
}

/// Compiled for each width of vectors; the operations, and so the answers, are the same in each.
struct Prove<'a> {
    prover: &'a mut Prover,
    proofs: &'a mut Proofs,
    i: u32,
    edges: &'a [Edge],
    triangles: &'a [Triangle],
    owners: &'a [u32],
}

impl pulp::WithSimd for Prove<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Prover { walls, on_edges, in_triangles, triangles } = self.prover;
        for (block, edges) in on_edges.iter_mut().zip(self.edges.chunks(LANES)) {
            block.find();
            for (l, &Edge { id, vertices, .. }) in edges.iter().enumerate() {
                if !block.clear[l] || !walls.hold(get(&block.at, l), [self.owners[vertices[1] as usize]; 2]) {
                    self.proofs.open.push((id, vertices));
                    continue;
                }
                let place = block.place[l];
                self.proofs.places.push((id, if vertices[0] < vertices[1] { place } else { 1.0 - place }));
            }
        }
        let listed = self.triangles.chunks(LANES).zip(triangles.chunks(LANES));
        for (block, (ids, triangles)) in in_triangles.iter_mut().zip(listed) {
            block.find();
            for (l, (&Triangle { id, .. }, &(first, others))) in ids.iter().zip(triangles).enumerate() {
                if block.clear[l] && walls.hold(get(&block.at, l), others) {
                    let (owners, weights) = ([self.i, others[0], others[1]], get(&block.weights, l));
                    self.proofs.meetings.push(Meeting { triangle: id, owners, first, weights });
                }
            }
        }
    }
}

impl OnEdges {
    /// Finds where the edges meet the bisectors with the other seeds.
    #[inline(always)]
    fn find(&mut self) {
        for l in 0..LANES {
            let found = on_edge(get(&self.from, l), get(&self.to, l), get(&self.other, l));
            self.place[l] = found.place;
            (0..3).for_each(|k| self.at[k][l] = found.at[k]);
            self.clear[l] = found.clear;
        }
    }
}

impl InTriangles {
    /// Finds where the bisectors with the two other seeds meet.
    #[inline(always)]
    fn find(&mut self) {
        for l in 0..LANES {
            let corners = [0, 1, 2].map(|c| get(&self.corners[c], l));
            let others = [0, 1].map(|n| get(&self.others[n], l));
            let found = in_triangle(corners, others);
            (0..3).for_each(|n| self.weights[n][l] = found.place[n]);
            (0..3).for_each(|n| self.at[n][l] = found.at[n]);
            self.clear[l] = found.clear;
        }
    }
}
