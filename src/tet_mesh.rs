//! The output: a tetrahedral mesh, in the units of the model.

use glam::DVec3;

use crate::delaunay::Breakdown;
use crate::geometry::tetrahedron;
use crate::geometry::triangle;
use crate::progress::Step;
use crate::seeds::SeedKind;

mod check;

mod size_ratio;

pub use size_ratio::SizeRatio;

/// A facet of the mesh's boundary, or of an interface between two of its regions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryTriangle {
    /// Vertices of the mesh, counter-clockwise seen from outside; of an interface, from outside the region within.
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
    /// The region that each tet belongs to.
    pub regions: Vec<u32>,
    /// The boundary and the interfaces between regions: closed and manifold.
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

    /// Area of the boundary and of interfaces, in model units.
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

    /// Turns the triangles of interfaces so that the region within, which is deeper than the other, is behind them.
    pub(crate) fn turn_interfaces(&mut self, depth: impl Fn(u32) -> u32) {
        for facet in self.boundary.iter_mut().filter(|f| f.region_outside >= 0) {
            let outside = facet.region_outside as u32;
            if depth(facet.region_inside) < depth(outside) {
                facet.vertices.swap(1, 2);
                (facet.region_inside, facet.region_outside) = (outside, facet.region_inside as i32);
            }
        }
    }

    /// Verifies every invariant of the mesh; names the first violation.
    ///
    /// Volumes are positive as `f64` arithmetic has them, every vertex is used, no facet has more than two tets, the
    /// boundary is the facets that have one and those between two regions, each once, with the regions on their sides, and
    /// closed and manifold at every edge and vertex.
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
