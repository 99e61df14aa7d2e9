//! The exact Delaunay triangulation of a set of points.
//!
//! All of space is covered: beyond every facet of the convex hull lies an **infinite tet**, whose fourth vertex is the
//! infinite one ([`INFINITE`]). Cospherical points are told apart by a symbolic perturbation that depends on their
//! positions alone (`geometry::predicates`), so a set of points has exactly one triangulation, without flat tets,
//! whatever the order of the points and however it was come by.

mod adjacency;

mod bicell_filter;

mod bicell_matrix;

mod cavity;

mod certificate;

mod check;

mod detect;

mod edit;

mod error;

mod facet;

mod flip;

mod hole;

mod hull;

mod insert;

mod insert_vertex;

mod leaps;

mod locate;

mod motion;

mod order;

mod range;

mod region;

mod relocate;

mod remove_vertex;

mod repair;

mod rows;
mod schedule;

mod stuck;

mod tets;

mod tolerance;

mod updater;

mod vertex_filter;

use std::fmt;

use glam::DVec3;

pub use adjacency::{Adjacency, Follower};
pub use error::DelaunayError;
pub use facet::{Facet, INFINITE};
pub use relocate::{Breakdown, Relocation};
pub use updater::{Method, Updater};

/// The Delaunay triangulation of a set of points, the infinite vertex included.
#[derive(Clone)]
pub struct Delaunay {
    points: Vec<DVec3>,
    scale: f64,
    vertices: Vec<[u32; 4]>,
    neighbors: Vec<[Facet; 4]>,
    motion: motion::Motion,
    edits: edit::Edits,
}

impl Delaunay {
    /// Builds the triangulation; vertex i is `points[i]`.
    ///
    /// Any finite points will do. They are held bit for bit, except that parts of coordinates below 2^-200 are rounded
    /// off, and that points whose largest coordinate is beyond 2^60 or below 2^-60 are held times a power of two,
    /// [`Delaunay::scale`]. Points that coincide as held are duplicates.
    pub fn build(points: &[DVec3]) -> Result<Delaunay, DelaunayError> {
        let count = points.len();
        if let Some(index) = points.iter().position(|p| !p.is_finite()) {
            return Err(DelaunayError::NotFinite { index, point: points[index].to_array() });
        }
        if count < 4 {
            return Err(DelaunayError::TooFew { count });
        }
        if count >= Facet::MAX_TETS {
            return Err(DelaunayError::TooMany { count });
        }
        let (points, scale) = range::hold(points);
        let (vertices, neighbors) = Delaunay::construct(&points)?;
        let (motion, edits) = Default::default();
        Ok(Delaunay { points, scale, vertices, neighbors, motion, edits })
    }

    /// The points as held: as given, times [`Delaunay::scale`], to a multiple of 2^-200.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The power of two by which the points are held: 1 unless their largest coordinate is beyond 2^60 or below 2^-60.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// For each tet, its vertices, positively oriented: det[b - a, c - a, d - a] > 0. An infinite tet has
    /// [`INFINITE`] in its last slot and the facet of the hull, turned so that a positive apex would be outside.
    pub fn vertices(&self) -> &[[u32; 4]] {
        &self.vertices
    }

    /// For each tet and each of its facets (facet i lies opposite vertex i), that facet as seen from the other side: the
    /// neighbour, and which of its facets it is.
    pub fn neighbors(&self) -> &[[Facet; 4]] {
        &self.neighbors
    }

    /// The tet across facet `i` of tet `t`.
    #[inline]
    pub fn neighbor(&self, t: u32, i: usize) -> u32 {
        self.neighbors[t as usize][i].tet()
    }

    /// The tet across facet `i` of tet `t`, and the slot of its vertex opposite that facet.
    #[inline]
    pub fn opposite(&self, t: u32, i: usize) -> (u32, usize) {
        let facet = self.neighbors[t as usize][i];
        (facet.tet(), facet.slot())
    }

    /// The finite tets.
    pub fn tets(&self) -> impl Iterator<Item = [u32; 4]> + '_ {
        self.vertices.iter().copied().filter(|v| v[3] != INFINITE)
    }
}

impl fmt::Debug for Delaunay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Delaunay {{ {} points, {} tets }}", self.points.len(), self.vertices.len())
    }
}
