//! The exact Delaunay triangulation of a set of points.

use glam::DVec3;

/// Why points have no Delaunay triangulation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DelaunayError {
    /// Points on one plane, or fewer than four.
    #[error("all {count} points lie on one plane: there is no tet")]
    Flat {
        /// Number of points.
        count: usize,
    },
}

/// Stands for the infinite vertex in the tets of the hull.
pub const INFINITE: u32 = u32::MAX;

/// The Delaunay triangulation of a set of points, the infinite vertex included.
pub struct Delaunay {
    points: Vec<DVec3>,
    vertices: Vec<[u32; 4]>,
    neighbors: Vec<[u32; 4]>,
}

impl Delaunay {
    /// Builds the triangulation; vertex i is `points[i]`.
    pub fn build(_points: &[DVec3]) -> Result<Delaunay, DelaunayError> {
        todo!()
    }

    /// The points, as given.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// For each tet, its vertices, positively oriented: det[b - a, c - a, d - a] > 0. An infinite tet has
    /// [`INFINITE`] in its last slot and the facet of the hull, seen from where a positive apex would be outside.
    pub fn vertices(&self) -> &[[u32; 4]] {
        &self.vertices
    }

    /// For each tet, the tets across its four facets; facet i lies opposite vertex i.
    pub fn neighbors(&self) -> &[[u32; 4]] {
        &self.neighbors
    }

    /// The finite tets.
    pub fn tets(&self) -> impl Iterator<Item = [u32; 4]> + '_ {
        self.vertices.iter().copied().filter(|v| v[3] != INFINITE)
    }

    /// Verifies combinatorics, orientation and empty spheres; names the first violation.
    pub fn check(&self) -> Result<(), String> {
        todo!()
    }
}
