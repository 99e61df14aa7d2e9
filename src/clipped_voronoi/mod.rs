//! Voronoi cells clipped by the surface: their volumes, centroids and energies, exact up to rounding.
//!
//! For seed i with Voronoi cell V_i and solid Ω the moments of V_i ∩ Ω are sums over signed tets with their apex at the
//! seed (the divergence theorem); neither Ω nor any cell is ever built as a polyhedron. Three kinds of piece close a cell:
//!
//! 1. **Surface pieces**: each triangle of the surface, clipped by the cell, seen from the seed.
//! 2. **Cut segments**: each edge of such a piece on the bisector with j, with the midpoint m_ij and the seed.
//! 3. **Voronoi edges inside Ω**: each interval [a, b] of the dual of a Delaunay facet (i, j, k), with m_ij and the seed,
//!    for every ordered pair of the facet's vertices.
//!
//! All combinatorial decisions are exact, with ties broken as in the Delaunay kernel (see `bisector.rs`); what is
//! inside follows from them alone. Positions only enter the sums: as the pieces form closed chains whatever rounding does
//! to positions, volumes add up to the solid's and areas to its area within rounding, on any input.
//!
//! Yan, Wang, Lévy, Liu, *Efficient computation of clipped Voronoi diagram for mesh generation*, Computer-Aided Design
//! 45(4), 2013, doi 10.1016/j.cad.2011.09.004, compute the same cells from a tet mesh of Ω, which is not needed here.
//! Cost: linear in the facets of the triangulation and in the pieces of the surface.

use glam::DVec3;

use crate::delaunay::{Adjacency, Delaunay};
use crate::surface::Surface;

mod bisector;

mod cell;

mod circumcenters;

mod expansion;

mod polygon;

pub mod polyhedra;

mod surface_pieces;

mod voronoi_edges;

pub use cell::Cell;
pub use polyhedra::Polyhedra;

use voronoi_edges::Crossings;

/// Where a Voronoi edge, dual to a facet of the triangulation, crosses the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The facet's vertices, ascending.
    pub facet: [u32; 3],
    /// The point, in the frame.
    pub point: DVec3,
    /// The surface's triangle.
    pub triangle: u32,
    /// Whether the edge leaves the solid there on its way along (q - p) x (r - p), for the facet (p, q, r).
    pub leaves: bool,
}

/// The Voronoi tessellation clipped by the surface.
pub struct ClippedVoronoi {
    /// One per seed.
    pub cells: Vec<Cell>,
    /// For each tet of the triangulation, whether its circumcentre is inside the solid; false for infinite ones.
    pub inside: Vec<bool>,
    /// Crossings of Voronoi edges with the surface, by facet.
    pub crossings: Vec<Crossing>,
    /// Which seeds are Delaunay neighbours.
    pub adjacency: Adjacency,
}

impl ClippedVoronoi {
    /// The CVT energy: the integral over the solid of the squared distance to the nearest seed.
    pub fn energy(&self) -> f64 {
        self.cells.iter().map(|c| c.energy).sum()
    }
}

/// A density on the surface: weights of its points in the centroids of restricted cells.
pub enum Density {
    /// 1 everywhere.
    Uniform,
    /// At each vertex of the surface, linear between them.
    Vertices(Vec<f64>),
}

impl Density {
    /// At the corners of a triangle.
    fn at_corners(&self, ids: [u32; 3]) -> [f64; 3] {
        match self {
            Density::Uniform => [1.0; 3],
            Density::Vertices(at) => ids.map(|v| at[v as usize]),
        }
    }

    /// At three points of the triangle of `view`, given relative to its seed.
    fn within(&self, ids: [u32; 3], view: &bisector::View, points: [DVec3; 3]) -> [f64; 3] {
        let Density::Vertices(_) = self else { return [1.0; 3] };
        let at = self.at_corners(ids);
        let [a, b, c] = view.corners.map(|p| p - view.seed);
        let normal = (b - a).cross(c - a);
        let scale = 1.0 / normal.length_squared();
        points.map(|p| {
            let toward_b = (p - a).cross(c - a).dot(normal) * scale;
            let toward_c = (b - a).cross(p - a).dot(normal) * scale;
            let value = at[0] + (at[1] - at[0]) * toward_b + (at[2] - at[0]) * toward_c;
            value.clamp(at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]))
        })
    }
}

/// Clips the cells of one triangulation after another by one surface, and remembers what helps with the next.
pub struct Clipper<'a> {
    surface: &'a Surface,
    density: Density,
    owners: Vec<u32>,
}

impl<'a> Clipper<'a> {
    /// For cells clipped by `surface`.
    pub fn new(surface: &'a Surface) -> Clipper<'a> {
        let owners = vec![u32::MAX; surface.points().len()];
        Clipper { surface, density: Density::Uniform, owners }
    }

    /// From now on, weighs [`Cell::area_moment`] and [`Cell::area_mass`] by a density of the surface.
    pub fn set_density(&mut self, density: Density) {
        self.density = density;
    }

    /// The cells of `delaunay`, whose points are on the grid of the surface's frame.
    ///
    /// # Panics
    /// If the surface crosses nothing but is not closed: a [`Surface`] cannot be built so.
    pub fn clip(&mut self, delaunay: &Delaunay) -> ClippedVoronoi {
        let points = delaunay.points();
        let adjacency = delaunay.adjacency();
        surface_pieces::update_owners(&mut self.owners, points, self.surface, &adjacency);

        let mut cells = vec![Cell::default(); points.len()];
        let crossings =
            surface_pieces::add_pieces(&mut cells, points, self.surface, &self.density, &adjacency, &self.owners);

        let by_facet = Crossings::new(&crossings, points.len());
        let winding = voronoi_edges::winding(delaunay, &by_facet)
            .expect("a closed surface changes sides an even number of times: this is a bug in tetcvt");
        let centers = circumcenters::circumcenters(delaunay, &winding);
        voronoi_edges::add_edges(&mut cells, delaunay, &by_facet, &winding, &centers);

        let inside = winding.iter().map(|&w| w > 0).collect();
        ClippedVoronoi { cells, inside, crossings, adjacency }
    }
}
