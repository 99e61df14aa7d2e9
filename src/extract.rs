//! Takes the mesh out of the triangulation.
