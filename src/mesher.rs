//! The whole algorithm on one screen.

use crate::error::Error;
use crate::params::Params;
use crate::progress::Observer;
use crate::surface::Surface;
use crate::tet_mesh::TetMesh;

/// Meshes the solid that `surface` bounds.
pub fn tetrahedralize(_surface: &Surface, _params: &Params, _observer: &mut dyn Observer) -> Result<TetMesh, Error> {
    todo!()
}
