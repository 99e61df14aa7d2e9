//! Moments of Voronoi cells clipped by the surface.

use glam::DVec3;

use crate::delaunay::Delaunay;
use crate::surface::Surface;

/// What a seed owns of the solid and of its surface. Moments are relative to the seed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// Volume of the cell within the solid.
    pub volume: f64,
    /// Integral of x - seed over it.
    pub moment: DVec3,
    /// Integral of |x - seed|^2 over it: its share of the CVT energy.
    pub energy: f64,
    /// Area of the surface within the cell.
    pub area: f64,
    /// Integral of x - seed over that.
    pub area_moment: DVec3,
}

/// Where a Voronoi edge, dual to a facet of the triangulation, crosses the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The facet's vertices, ascending.
    pub facet: [u32; 3],
    /// The point.
    pub point: DVec3,
    /// The surface's triangle.
    pub triangle: u32,
}

/// The Voronoi tessellation clipped by the surface.
pub struct ClippedVoronoi {
    /// One per seed.
    pub cells: Vec<Cell>,
    /// For each tet of the triangulation, whether its circumcentre is inside the solid; false for infinite ones.
    pub inside: Vec<bool>,
    /// Crossings of Voronoi edges with the surface, by facet.
    pub crossings: Vec<Crossing>,
}

/// Clips the Voronoi cells of `delaunay` by `surface`.
pub fn clip(_delaunay: &Delaunay, _surface: &Surface) -> ClippedVoronoi {
    todo!()
}
