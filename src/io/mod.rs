//! Files: surfaces in, meshes out. Whole files or none.

pub mod obj;

mod polygon;

pub use obj::read as read_surface;
