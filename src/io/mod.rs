//! Files: surfaces in, meshes out. Whole files or none.

pub mod atomic;

pub mod npy;

pub mod obj;

mod polygon;

pub mod vtk;

pub use obj::{load as load_surface, read as read_surface};
