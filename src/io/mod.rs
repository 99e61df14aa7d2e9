//! Files: surfaces in, meshes out. Whole files or none.

pub mod atomic;

pub mod npy;

pub mod vtk;
/// TEMPORARY
pub fn read_surface(_path: &std::path::Path) -> Result<crate::Surface, crate::Error> {
    todo!()
}
