//! The output.

use glam::DVec3;

use crate::progress::Step;
use crate::seeds::SeedKind;

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
    /// Clipped cells and their moments.
    pub centroids: f64,
    /// Taking the mesh out.
    pub extract: f64,
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
    /// Why the iterations ended, for a human.
    pub stopped: String,
    /// Where the time went.
    pub times: StageTimes,
}

impl TetMesh {
    /// The vertices that the boundary uses, ascending.
    pub fn boundary_vertices(&self) -> Vec<u32> {
        let mut vertices: Vec<u32> = self.boundary.iter().flat_map(|t| t.vertices).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }
}
