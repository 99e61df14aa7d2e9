//! The output: a tetrahedral mesh, in the units of the model.

use glam::DVec3;

use crate::delaunay::Breakdown;
use crate::geometry::tetrahedron::{self, FACETS};
use crate::geometry::triangle;
use crate::progress::Step;
use crate::seeds::SeedKind;

mod check;

mod size_ratio;

pub use size_ratio::SizeRatio;

/// A facet of the mesh's boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryTriangle {
    /// Vertices of the mesh, counter-clockwise seen from outside.
    pub vertices: [u32; 3],
    /// The region behind it.
    pub region_inside: u32,
    /// The region in front of it; -1 where there is none.
    pub region_outside: i32,
    /// Patch of the surface's triangle closest to it.
    pub patch: u32,
    /// Index, in the input file, of that triangle.
    pub source_triangle: u32,
}

/// Seconds spent in the stages of the library.
#[derive(Clone, Copy, Debug, Default)]
pub struct StageTimes {
    /// Placing seeds (features included).
    pub seeds: f64,
    /// The first triangulation.
    pub build: f64,
    /// Keeping it while the seeds move.
    pub update: f64,
    /// The parts of that.
    pub update_parts: Breakdown,
    /// Clipped cells and their moments.
    pub centroids: f64,
    /// Taking the mesh out.
    pub extract: f64,
    /// Taking slivers out of it.
    pub improve: f64,
}

/// A tetrahedral mesh of a solid, in model units.
#[derive(Clone, Debug)]
pub struct TetMesh {
    /// Vertices, all in use.
    pub points: Vec<DVec3>,
    /// The part of the solid that each vertex belongs to.
    pub kinds: Vec<SeedKind>,
    /// The seed that each vertex was: a row of the trajectory.
    pub seeds: Vec<u32>,
    /// Positively oriented tets: det[b - a, c - a, d - a] > 0, in `f64` arithmetic too.
    pub tets: Vec<[u32; 4]>,
    /// The solid that each tet belongs to.
    pub regions: Vec<u32>,
    /// The boundary: closed and manifold.
    pub boundary: Vec<BoundaryTriangle>,
    /// What each iteration did.
    pub steps: Vec<Step>,
    /// The lengths of its edges over the sizes asked for, where these vary.
    pub size_ratio: Option<SizeRatio>,
    /// Why the iterations ended, for a human.
    pub stopped: String,
    /// What became of the floor for dihedral angles, for a human; empty where none was aimed at.
    pub improved: String,
    /// Where the time went.
    pub times: StageTimes,
}

impl TetMesh {
    /// The corners of tet `t`.
    pub fn corners(&self, t: usize) -> [DVec3; 4] {
        self.tets[t].map(|v| self.points[v as usize])
    }

    /// Volume, in model units.
    pub fn volume(&self) -> f64 {
        (0..self.tets.len())
            .map(|t| {
                let [a, b, c, d] = self.corners(t);
                tetrahedron::volume(a, b, c, d)
            })
            .sum()
    }

    /// Area of the boundary, in model units.
    pub fn area(&self) -> f64 {
        self.boundary
            .iter()
            .map(|facet| {
                let [a, b, c] = facet.vertices.map(|v| self.points[v as usize]);
                triangle::area(a, b, c)
            })
            .sum()
    }

    /// Number of vertices of a kind.
    pub fn count(&self, kind: SeedKind) -> usize {
        self.kinds.iter().filter(|&&k| k == kind).count()
    }

    /// The facets that belong to one tet only, each as its tet and its vertices, counter-clockwise seen from outside;
    /// ordered by tet. Found anew from the tets.
    pub fn single_facets(&self) -> Vec<(u32, [u32; 3])> {
        let mut facets: Vec<([u32; 3], u32, u8)> = Vec::with_capacity(4 * self.tets.len());
        for (t, tet) in self.tets.iter().enumerate() {
            for (i, facet) in FACETS.iter().enumerate() {
                let mut key = facet.map(|k| tet[k]);
                key.sort_unstable();
                facets.push((key, t as u32, i as u8));
            }
        }
        facets.sort_unstable();
        let mut single: Vec<(u32, [u32; 3])> = facets
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|same| same.len() == 1)
            .map(|same| (same[0].1, FACETS[same[0].2 as usize].map(|k| self.tets[same[0].1 as usize][k])))
            .collect();
        single.sort_unstable();
        single
    }

    /// Verifies every invariant of the mesh; names the first violation.
    ///
    /// Volumes are positive as `f64` arithmetic has them, every vertex is used, no facet has more than two tets, the
    /// boundary is the facets that have one, outward, closed and manifold at every edge and vertex, and regions change
    /// nowhere but there.
    pub fn check(&self) -> Result<(), String> {
        check::check(self)
    }

    /// The boundary as a mesh of its own: the vertices that it uses, ascending, and its triangles over these.
    pub fn boundary_mesh(&self) -> (Vec<u32>, Vec<[u32; 3]>) {
        let mut vertices: Vec<u32> = self.boundary.iter().flat_map(|t| t.vertices).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut compact = vec![0; self.points.len()];
        for (i, &v) in (0..).zip(&vertices) {
            compact[v as usize] = i;
        }
        let triangles = self.boundary.iter().map(|t| t.vertices.map(|v| compact[v as usize])).collect();
        (vertices, triangles)
    }
}
