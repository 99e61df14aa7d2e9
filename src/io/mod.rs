//! Files: surfaces in, meshes out. Whole files or none.

pub mod atomic;

pub mod defects;

pub mod format;

pub mod npy;

pub mod read;

pub mod vtk;

mod write;

pub use read::{load as load_surface, read as read_surface, read_initial, read_lines, read_sizes};
pub use write::{MeshData, write_mesh, write_surface};
