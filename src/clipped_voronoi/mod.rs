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

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::delaunay::{Adjacency, Delaunay, Follower};
use crate::sizing::Sizing;
use crate::surface::Surface;

mod bisector;

mod borders;

mod cell;

mod circumcenters;

mod crossed_tets;

mod crossings;

mod expansion;

mod groups;

mod net;

mod outline;

mod owners;

mod planes;

mod polygon;

pub mod polyhedra;

mod seen;

mod shared_sums;

mod shares;

mod sheet;

mod slices;

mod surface_pieces;

mod tet_shares;

mod vertices;

mod voronoi_edges;

mod walls;

mod weighted;

mod weighted_edges;

mod winding;

pub use cell::Cell;
pub use polyhedra::Polyhedra;

use crossed_tets::CrossedTets;
use crossings::Crossings;
use owners::Owners;
use sheet::Sheet;
use surface_pieces::{Pair, Scene};
use voronoi_edges::{Edges, Even};
use weighted::{Weighted, Weights, density};
use winding::Winding;

/// Seeds in a block of the work, most of which have nothing to do with the surface.
const SEEDS: usize = 256;

/// Where a Voronoi edge, dual to a facet of the triangulation, crosses the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The facet's vertices, ascending.
    pub facet: [u32; 3],
    /// The point, in the frame.
    pub point: DVec3,
    /// The surface's triangle.
    pub triangle: u32,
    /// Whether the edge goes from behind that triangle to its front there on its way along (q - p) x (r - p), for the facet
    /// (p, q, r): leaves the solid, where the triangle is no interface.
    pub leaves: bool,
}

/// The Voronoi tessellation clipped by the surface.
pub struct ClippedVoronoi {
    /// One per seed.
    pub cells: Vec<Cell>,
    /// For each tet of the triangulation, whether its circumcentre is inside the solid; false for infinite ones.
    pub inside: Vec<bool>,
    /// For each tet, whether its circumcentre is behind the surface, within an odd number of shells; `None` where that is
    /// the same as inside.
    pub odd: Option<Vec<bool>>,
    /// Crossings of Voronoi edges with the surface, by facet.
    pub crossings: Vec<Crossing>,
    /// Which seeds are Delaunay neighbours.
    pub adjacency: Arc<Adjacency>,
}

impl ClippedVoronoi {
    /// The CVT energy: the integral over the solid of the squared distance to the nearest seed.
    pub fn energy(&self) -> f64 {
        self.cells.iter().map(|c| c.energy).sum()
    }

    /// For each tet, whether its circumcentre is behind the surface: within an odd number of shells.
    pub fn behind(&self) -> &[bool] {
        self.odd.as_deref().unwrap_or(&self.inside)
    }
}

/// A density on the surface: weights of its points in the centroids of restricted cells.
pub enum Density {
    /// 1 everywhere.
    Uniform,
    /// At each vertex of the surface, linear between them.
    Vertices(Vec<f64>),
}

/// Clips the cells of one triangulation after another by one surface, and remembers what helps with the next.
pub struct Clipper<'a> {
    sheet: Sheet<'a>,
    adjacency: Follower,
    owners: Owners,
    cornerless: Vec<Pair>,
    winding: Winding,
    arch: pulp::Arch,
    /// Relative sizes, where the solid has a density.
    sizing: Option<Arc<Sizing>>,
}

impl<'a> Clipper<'a> {
    /// For cells clipped by `surface`.
    pub fn new(surface: &'a Surface) -> Clipper<'a> {
        let (sheet, arch) = (Sheet::new(surface), pulp::Arch::new());
        let (adjacency, owners) = (Follower::default(), Owners::default());
        Clipper { sheet, adjacency, owners, cornerless: Vec::new(), winding: Winding::default(), arch, sizing: None }
    }

    /// From now on, weighs [`Cell::area_moment`] and [`Cell::area_mass`] by a density of the surface.
    pub fn set_density(&mut self, density: Density) {
        self.sheet.set_density(density);
    }

    /// From now on weighs the solid, and with it [`Cell::mass`], [`Cell::moment`] and [`Cell::energy`], by one over the fifth
    /// power of the relative sizes: cells as large as these then have all the same energy, which is what a centroidal Voronoi
    /// tessellation tends to (Gersho, *Asymptotically optimal block quantization*, IEEE Transactions on Information Theory
    /// 25(4), 1979, doi 10.1109/TIT.1979.1056067).
    pub fn set_sizing(&mut self, sizing: Arc<Sizing>) {
        self.sheet.set_solid(self.sheet.surface.points().iter().map(|&p| density(sizing.relative(p))).collect());
        self.sizing = Some(sizing);
    }

    /// The cells of `delaunay`, whose points are on the grid of the surface's frame.
    ///
    /// # Panics
    /// If the surface crosses nothing but is not closed: a [`Surface`] cannot be built so.
    pub fn clip(&mut self, delaunay: &Delaunay) -> ClippedVoronoi {
        self.clip_first(delaunay, delaunay.points().len())
    }

    /// The cells of the first `seeds` points of `delaunay`. All further ones must be so far away that no point of the solid is
    /// nearer to them than to a seed: their own cells are empty, and left out, as they are of the adjacency.
    ///
    /// # Panics
    /// As [`Clipper::clip`].
    pub fn clip_first(&mut self, delaunay: &Delaunay, seeds: usize) -> ClippedVoronoi {
        let (points, arch) = (&delaunay.points()[..seeds], self.arch);
        let adjacency = self.adjacency.follow(delaunay, seeds);
        self.owners.update(&self.sheet.points, points, adjacency, arch);

        let weights = self.sizing.as_ref().map(|s| weighted::sizes(s, points));
        let weights = weights.as_ref().map(|w| Weights { sizes: &w.sizes, densities: &w.densities });
        let mut cells = vec![Cell::default(); seeds];
        let scene = Scene { points, adjacency, sheet: &self.sheet, owners: &self.owners, arch, weights };
        let crossings = surface_pieces::add_pieces(&mut cells, scene, &mut self.cornerless);

        // What bounds the solid; interfaces only part its regions.
        let outer = outer_crossings(self.sheet.surface, &crossings);
        let by_facet = Crossings::new(&outer, delaunay.points().len());
        self.winding.update(delaunay, &by_facet);
        let Winding { of_tets: winding, crossed, .. } = &self.winding;
        let CrossedTets { marks, tets: crossed, .. } = crossed;
        let edges = Edges { delaunay, crossings: &by_facet, marks, crossed, winding, arch };
        match (&self.sizing, weights) {
            (Some(sizing), Some(weights)) => {
                let centers = &circumcenters::circumcenters(delaunay, winding);
                let at_centers = &weighted::at_centers(sizing, centers, winding);
                edges.add(&mut cells, &Weighted { weights, centers, at_centers, sheet: &self.sheet });
            }
            _ => edges.add(&mut cells, &Even),
        }

        if weights.is_none() {
            cells.par_iter_mut().for_each(|c| c.mass = c.volume);
        }
        let inside = self.winding.of_tets.par_iter().map(|&w| w > 0).collect();
        let odd = self.sheet.surface.has_interfaces().then(|| behind(delaunay, &crossings));
        ClippedVoronoi { cells, inside, odd, crossings, adjacency: adjacency.clone() }
    }
}

/// The crossings with shells that are no interfaces.
fn outer_crossings<'a>(surface: &Surface, crossings: &'a [Crossing]) -> Cow<'a, [Crossing]> {
    if !surface.has_interfaces() {
        return crossings.into();
    }
    crossings.iter().filter(|c| !surface.is_interface(c.triangle)).copied().collect()
}

/// For each tet, whether its circumcentre is within an odd number of shells.
fn behind(delaunay: &Delaunay, crossings: &[Crossing]) -> Vec<bool> {
    let by_facet = Crossings::new(crossings, delaunay.points().len());
    let mut winding = Winding::default();
    winding.update(delaunay, &by_facet);
    winding.of_tets.iter().map(|&w| w > 0).collect()
}
