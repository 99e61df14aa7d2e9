//! Files: surfaces in, meshes out. Whole files or none.

pub mod atomic;

pub mod defects;

pub mod npy;

pub mod read;

pub mod vtk;

pub use read::{load as load_surface, read as read_surface};
