//! Creases and corners of a surface, by dihedral angle.

use super::Surface;

/// A crease: a chain of the surface's edges between two corners, or a closed loop.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The surface's vertices along it; a closed one repeats its first vertex at the end.
    pub vertices: Vec<u32>,
    /// Arc length from the first vertex to each, in frame units.
    pub arc: Vec<f64>,
}

/// The corners, creases and smooth patches of a surface.
#[derive(Clone, Debug)]
pub struct Features {
    /// Vertices where creases meet, end or turn sharply, and tips of cones.
    pub corners: Vec<u32>,
    /// Creases.
    pub curves: Vec<Curve>,
    /// For each triangle, the smooth patch that it belongs to: patches are bounded by creases.
    pub face: Vec<u32>,
}

impl Features {
    /// The features of `surface`: edges whose faces' normals differ by more than `angle` degrees.
    pub fn find(_surface: &Surface, _angle: f64) -> Features {
        todo!()
    }
}
