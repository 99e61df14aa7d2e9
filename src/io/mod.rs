//! Files: surfaces in, meshes out. Whole files or none.

pub mod atomic;

pub mod format;

pub mod npy;

pub mod obj;

pub mod vtk;

mod write;

use crate::geometry::polygon;

pub use obj::{load as load_surface, read as read_surface};
pub use write::{MeshData, write_mesh, write_surface};
