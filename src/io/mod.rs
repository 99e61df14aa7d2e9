//! Files: surfaces in, meshes out. Whole files or none.

pub mod atomic;

pub mod npy;

pub mod vtk;
