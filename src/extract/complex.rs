//! A triangulation seen from its vertices: which tets are around each, and how labels divide them.

use glam::DVec3;

use crate::delaunay::{Facet, INFINITE};
use crate::disjoint_sets::DisjointSets;
use crate::geometry::tetrahedron::FACETS;

/// A triangulation of all of space, the infinite vertex included, with the star of each vertex.
///
/// The arrays are those of [`crate::delaunay::Delaunay`].
pub struct Complex<'a> {
    /// Vertices: the seeds, then auxiliary points that no mesh may use.
    pub points: &'a [DVec3],
    /// For each tet its vertices; an infinite tet has [`INFINITE`] in its last slot.
    pub tets: &'a [[u32; 4]],
    /// For each tet its facets as seen from the tets across them; facet i lies opposite vertex i.
    pub neighbors: &'a [[Facet; 4]],
    /// Number of seeds.
    pub seeds: usize,
    /// For each seed the solid that it belongs to; empty where there is only one.
    pub solids: Vec<u32>,
    /// For each seed whether it is in use even if no tet inside has it, being in a region in front of the surface or on an
    /// interface with one; empty where the mesh has no such regions.
    pub in_front: Vec<bool>,
    // The tets around vertex v are star[first[v]..first[v + 1]].
    first: Vec<u32>,
    star: Vec<u32>,
}

/// In how many pieces, connected through facets, the tets around a vertex are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fans {
    /// Pieces inside.
    pub inside: u32,
    /// Pieces outside.
    pub outside: u32,
}

impl Fans {
    /// Whether the vertex is in use and the boundary is a single disk at it, or away from it.
    ///
    /// The link of a vertex is a sphere. Where both its inside and its outside are connected, a single closed curve
    /// divides it (Jordan), so that no boundary edge at the vertex has more than two triangles either.
    pub fn is_manifold(&self) -> bool {
        self.inside <= 1 && self.outside <= 1
    }

    /// Whether the vertex is on the boundary.
    pub fn on_boundary(&self) -> bool {
        self.inside > 0 && self.outside > 0
    }
}

/// Buffers of [`Complex::fans`], reused between calls.
#[derive(Default)]
pub struct FanBuffers {
    // Position of a tet in the star at hand; read only after it has been written for that star.
    slot: Vec<u32>,
    sets: DisjointSets,
}

impl<'a> Complex<'a> {
    /// Collects the stars of a triangulation whose first `seeds` vertices are seeds.
    pub fn new(points: &'a [DVec3], tets: &'a [[u32; 4]], neighbors: &'a [[Facet; 4]], seeds: usize) -> Complex<'a> {
        let mut first = vec![0u32; points.len() + 2];
        for &v in tets.iter().flatten().filter(|&&v| v != INFINITE) {
            first[v as usize + 2] += 1;
        }
        for v in 2..first.len() {
            first[v] += first[v - 1];
        }
        // first[v + 1] runs from the start of v's star to its end while the star is filled.
        let mut star = vec![0; first[points.len() + 1] as usize];
        for (t, tet) in tets.iter().enumerate() {
            for &v in tet.iter().filter(|&&v| v != INFINITE) {
                let end = &mut first[v as usize + 1];
                star[*end as usize] = t as u32;
                *end += 1;
            }
        }
        first.pop();
        Complex { points, tets, neighbors, seeds, solids: Vec::new(), in_front: Vec::new(), first, star }
    }

    /// The tets around vertex `v`, infinite ones included, ascending.
    pub fn star(&self, v: u32) -> &[u32] {
        &self.star[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }

    /// Whether a mesh may use tet `t`: all its vertices are seeds, and of one solid.
    pub fn usable(&self, t: u32) -> bool {
        let tet = self.tets[t as usize];
        let solid = |v: u32| self.solids.get(v as usize);
        tet.iter().all(|&v| (v as usize) < self.seeds && solid(v) == solid(tet[0]))
    }

    /// Whether a seed at which the labels leave these pieces is in no tet of the mesh.
    pub fn is_unused(&self, v: u32, fans: Fans) -> bool {
        fans.inside == 0 && !self.in_front.get(v as usize).is_some_and(|&in_front| in_front)
    }

    /// The tets across the facets of tet `t`.
    pub fn around(&self, t: u32) -> [u32; 4] {
        self.neighbors[t as usize].map(Facet::tet)
    }

    /// The corners of the finite tet `t`.
    pub fn corners(&self, t: u32) -> [DVec3; 4] {
        self.tets[t as usize].map(|v| self.points[v as usize])
    }

    /// Vertices of facet `i` of tet `t`, counter-clockwise seen from outside the tet.
    pub fn facet(&self, t: u32, i: usize) -> [u32; 3] {
        FACETS[i].map(|k| self.tets[t as usize][k])
    }

    /// The vertex, auxiliary ones included, that is nearest to `p`, sought from vertex `start`.
    ///
    /// A vertex of a Delaunay triangulation that is not the nearest has a neighbour that is nearer.
    pub fn nearest(&self, p: DVec3, start: u32) -> u32 {
        let mut best = (p.distance_squared(self.points[start as usize]), start);
        loop {
            let before = best.1;
            for &w in self.star(before).iter().flat_map(|&t| &self.tets[t as usize]).filter(|&&w| w != INFINITE) {
                let d = p.distance_squared(self.points[w as usize]);
                if d < best.0 {
                    best = (d, w);
                }
            }
            if best.1 == before {
                return before;
            }
        }
    }

    /// Number of facets of tet `t` across which the label differs.
    pub fn exposed(&self, inside: &[bool], t: u32) -> usize {
        self.around(t).iter().filter(|&&n| inside[n as usize] != inside[t as usize]).count()
    }

    /// Buffers for [`Complex::fans`].
    pub fn fan_buffers(&self) -> FanBuffers {
        FanBuffers { slot: vec![0; self.tets.len()], sets: DisjointSets::default() }
    }

    /// Counts the pieces that the labels cut the star of `v` into.
    pub fn fans(&self, inside: &[bool], v: u32, buffers: &mut FanBuffers) -> Fans {
        // Most vertices have one label all around; stars are connected.
        let star = self.star(v);
        if star.iter().all(|&t| inside[t as usize] == inside[star[0] as usize]) {
            let any = star.first().is_some_and(|&t| inside[t as usize]);
            return Fans { inside: u32::from(any), outside: u32::from(!any) };
        }
        let pieces = self.pieces(star, v, inside, buffers);
        let mut fans = Fans { inside: 0, outside: 0 };
        for (i, &t) in star.iter().enumerate() {
            if pieces.find(i as u32) == i as u32 {
                *if inside[t as usize] { &mut fans.inside } else { &mut fans.outside } += 1;
            }
        }
        fans
    }

    /// The pieces of equal label of `tets`, all around vertex `v`, as sets of positions in that list; tets are joined
    /// across those of their facets that contain `v`.
    pub(super) fn pieces<'b>(
        &self,
        tets: &[u32],
        v: u32,
        inside: &[bool],
        buffers: &'b mut FanBuffers,
    ) -> &'b mut DisjointSets {
        for (i, &t) in tets.iter().enumerate() {
            buffers.slot[t as usize] = i as u32;
        }
        buffers.sets.reset(tets.len());
        for (i, &t) in tets.iter().enumerate() {
            for k in 0..4 {
                let n = self.neighbors[t as usize][k].tet();
                // Each pair once. The slot of a tet that is not in the list points elsewhere.
                if n >= t || self.tets[t as usize][k] == v || inside[n as usize] != inside[t as usize] {
                    continue;
                }
                let j = buffers.slot[n as usize];
                if tets.get(j as usize) == Some(&n) {
                    buffers.sets.join(i as u32, j);
                }
            }
        }
        &mut buffers.sets
    }
}
