//! Mathematics on points: predicates, triangles, tets, boxes. Knows no mesh.

pub mod bounding_box;

pub mod frame;

mod integers;

pub mod predicates;

pub mod tetrahedron;

pub mod triangle;
