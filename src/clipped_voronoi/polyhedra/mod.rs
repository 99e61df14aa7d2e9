//! The clipped Voronoi cells as polyhedra, for files and pictures: the iterations need their moments only.
//!
//! 1. **Pieces** of the surface's triangles, each in one cell: a face of it. Their corners are known by what meets there
//!    (a vertex of the surface, an edge and a bisector, a triangle and two bisectors), and so are circumcentres: a corner
//!    that several faces share is one point, however each of them came to it.
//! 2. **Segments** around the part of each Voronoi facet inside the solid: the cut segments that end pieces, and the
//!    intervals of Voronoi edges inside, which pair the places where the edge enters with those where it leaves. Exact
//!    signs decide what there is, so that segments form closed loops.
//! 3. Points closer than rounding are one: what many seeds on one sphere share is one corner.
//! 4. **Loops** become faces: as they are where they are convex, cut into triangles where not; holes are joined to the
//!    loop around them first. A facet is made once and used by the cells on both of its sides, turned over: cells
//!    conform, and each is closed.
//!
//! The pieces of a cell that the solid cuts in several are one polyhedron with all their faces. Interfaces between regions cut
//! nothing.
//! Cost: that of clipping, and a sort of the segments.

use glam::DVec3;
use rayon::prelude::*;

use super::ClippedVoronoi;
use super::circumcenters::circumcenters;
use super::polygon::{on_edge, within};
use crate::delaunay::Delaunay;
use crate::disjoint_sets::DisjointSets;
use crate::surface::Surface;

mod loops;

mod pieces;

mod segments;

/// Stands for the surface where a face's other side is asked for.
pub const SURFACE: u32 = u32::MAX;

/// Points so close in the frame are one: a few roundings.
const SAME: f64 = 64.0 * f64::EPSILON;

/// Clipped Voronoi cells.
#[derive(Clone, Debug)]
pub struct Polyhedra {
    /// Corners of all cells, in the frame; each is used.
    pub points: Vec<DVec3>,
    /// The seeds whose cells follow, ascending: those that own a part of the solid.
    pub seeds: Vec<u32>,
    /// The faces of cell c are `first_face[c]..first_face[c + 1]`.
    pub first_face: Vec<u32>,
    /// The corners of face f are `corners[first_corner[f]..first_corner[f + 1]]`.
    pub first_corner: Vec<usize>,
    /// Counter-clockwise seen from outside the cell. Faces are flat, and convex but for rounding.
    pub corners: Vec<u32>,
    /// The seed on the other side of each face, or [`SURFACE`].
    pub beyond: Vec<u32>,
}

/// What meets at a corner; its order is that of the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    /// The circumcentre of a tet of the triangulation.
    Center(u32),
    /// A vertex of the surface.
    Vertex(u32),
    /// An edge of the surface, by its vertices, and the bisector of two seeds; both ascending.
    OnEdge([u32; 2], [u32; 2]),
    /// A triangle of the surface and the Voronoi edge of three seeds, ascending.
    Within(u32, [u32; 3]),
}

/// A directed edge of the facet between two seeds, ascending; the facet lies to its left seen from the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Segment<P> {
    facet: [u32; 2],
    from: P,
    to: P,
}

/// A face of the cell of `seed`.
struct Face<P> {
    seed: u32,
    beyond: u32,
    corners: Vec<P>,
}

impl Polyhedra {
    /// The cells of the first `seeds` vertices of `delaunay` clipped by `surface`, as [`Clipper::clip_first`](super::Clipper::clip_first)
    /// has measured them.
    pub fn of(delaunay: &Delaunay, surface: &Surface, clipped: &ClippedVoronoi, seeds: usize) -> Polyhedra {
        // 1. and 2.
        let (pieces, mut segments) = pieces::collect(&delaunay.points()[..seeds], surface, &clipped.adjacency);
        segments.extend(segments::of_edges(delaunay, surface, clipped));
        let mut keys: Vec<Key> = segments.iter().flat_map(|s| [s.from, s.to]).collect();
        keys.extend(pieces.iter().flat_map(|p| &p.corners));
        keys.par_sort_unstable();
        keys.dedup();
        let points = positions(&keys, delaunay, surface, clipped);
        let number =
            |key: &Key| keys.binary_search(key).expect("every corner is listed: this is a bug in tetcvt") as u32;
        let segments: Vec<Segment<u32>> =
            segments.par_iter().map(|s| Segment { facet: s.facet, from: number(&s.from), to: number(&s.to) }).collect();
        let pieces: Vec<Face<u32>> = pieces
            .par_iter()
            .map(|p| Face { seed: p.seed, beyond: p.beyond, corners: p.corners.iter().map(number).collect() })
            .collect();
        // 3.
        let same = merge(&points, &segments, &pieces);
        let faces = pieces.into_iter().filter_map(|piece| {
            let mut corners: Vec<u32> = piece.corners.iter().map(|&p| same[p as usize]).collect();
            corners.dedup();
            if corners.len() > 1 && corners.first() == corners.last() {
                corners.pop();
            }
            (corners.len() >= 3).then_some(Face { corners, ..piece })
        });
        // 4.
        let mut faces: Vec<Face<u32>> = faces.collect();
        faces.extend(loops::facets(&points, delaunay.points(), segments, &same));
        faces.retain(|face| (face.seed as usize) < seeds);
        // Stable: pieces of the surface first, then facets by the other seed.
        faces.sort_by_key(|face| face.seed);
        assemble(&points, &faces)
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.seeds.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.seeds.is_empty()
    }

    /// The faces of cell `c`: corners, and the seed on the other side.
    pub fn faces(&self, c: usize) -> impl Iterator<Item = (&[u32], u32)> {
        (self.first_face[c] as usize..self.first_face[c + 1] as usize)
            .map(|f| (&self.corners[self.first_corner[f]..self.first_corner[f + 1]], self.beyond[f]))
    }
}

/// Where each corner is: computed from its key alone.
fn positions(keys: &[Key], delaunay: &Delaunay, surface: &Surface, clipped: &ClippedVoronoi) -> Vec<DVec3> {
    let seeds = delaunay.points();
    let used: Vec<i32> = clipped.inside.iter().map(|&inside| i32::from(inside)).collect();
    let centers = circumcenters(delaunay, &used);
    keys.par_iter()
        .map(|key| match *key {
            Key::Center(t) => centers[t as usize],
            Key::Vertex(v) => surface.points()[v as usize],
            Key::OnEdge([u, v], pair) => {
                let [u, v] = [u, v].map(|v| surface.points()[v as usize]);
                on_edge(u, v, pair.map(|s| seeds[s as usize]))
            }
            Key::Within(t, triple) => within(surface.corners(t), triple.map(|s| seeds[s as usize])),
        })
        .collect()
}

/// For each point the least of those that are one with it, by way of edges without a length.
fn merge(points: &[DVec3], segments: &[Segment<u32>], pieces: &[Face<u32>]) -> Vec<u32> {
    let mut sets = DisjointSets::new(points.len());
    let mut join = |a: u32, b: u32| {
        if points[a as usize].distance_squared(points[b as usize]) <= SAME * SAME {
            sets.join(a, b);
        }
    };
    segments.iter().for_each(|s| join(s.from, s.to));
    for corners in pieces.iter().map(|p| &p.corners) {
        (0..corners.len()).for_each(|m| join(corners[m], corners[(m + 1) % corners.len()]));
    }
    (0..points.len() as u32).map(|i| sets.find(i)).collect()
}

/// Puts faces, sorted by their cells, and the points in use one after another.
fn assemble(points: &[DVec3], faces: &[Face<u32>]) -> Polyhedra {
    let mut number = vec![u32::MAX; points.len()];
    faces.iter().flat_map(|f| &f.corners).for_each(|&p| number[p as usize] = 0);
    let used: Vec<usize> = (0..points.len()).filter(|&p| number[p] == 0).collect();
    (0..).zip(&used).for_each(|(i, &p)| number[p] = i);
    let mut cells = Polyhedra {
        points: used.iter().map(|&p| points[p]).collect(),
        seeds: Vec::new(),
        first_face: vec![0],
        first_corner: vec![0],
        corners: Vec::new(),
        beyond: Vec::new(),
    };
    for cell in faces.chunk_by(|a, b| a.seed == b.seed) {
        cells.seeds.push(cell[0].seed);
        for face in cell {
            cells.corners.extend(face.corners.iter().map(|&p| number[p as usize]));
            cells.first_corner.push(cells.corners.len());
            cells.beyond.push(face.beyond);
        }
        cells.first_face.push(cells.beyond.len() as u32);
    }
    cells
}
