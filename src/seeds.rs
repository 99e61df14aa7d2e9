//! First seeds, in and on the surface.

use glam::DVec3;

use crate::error::Error;
use crate::params::Params;
use crate::surface::Surface;
use crate::surface::features::Features;

/// Which part of the solid a seed belongs to; the value is the `kind` of the mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum SeedKind {
    /// Inside.
    Interior = 0,
    /// On the surface.
    Surface = 1,
    /// On a crease.
    Curve = 2,
    /// On a corner, never moving.
    Corner = 3,
}

/// Where a seed is bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// Nowhere.
    Interior,
    /// To the surface; the triangle that it lies on.
    Surface {
        /// Index of the triangle.
        triangle: u32,
    },
    /// To a crease.
    Curve {
        /// Index into [`Features::curves`].
        curve: u32,
        /// Arc length along the curve from its first vertex, in frame units.
        at: f64,
    },
    /// To a corner.
    Corner {
        /// The surface's vertex.
        vertex: u32,
    },
}

impl Anchor {
    /// The kind of a seed so bound.
    pub fn kind(&self) -> SeedKind {
        match self {
            Anchor::Interior => SeedKind::Interior,
            Anchor::Surface { .. } => SeedKind::Surface,
            Anchor::Curve { .. } => SeedKind::Curve,
            Anchor::Corner { .. } => SeedKind::Corner,
        }
    }
}

/// Seeds along a Hilbert curve, in the frame, on its grid; no two alike.
#[derive(Clone, Debug)]
pub struct Seeds {
    /// Positions.
    pub positions: Vec<DVec3>,
    /// Where each is bound.
    pub anchors: Vec<Anchor>,
    /// The edge length that one even spacing of this count gives, in frame units.
    pub spacing: f64,
}

/// Places the first seeds.
pub fn sample(_surface: &Surface, _features: &Features, _params: &Params) -> Result<Seeds, Error> {
    todo!()
}
