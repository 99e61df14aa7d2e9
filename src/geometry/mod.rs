//! Mathematics on points: predicates, triangles, tets, boxes, the Hilbert curve. Knows no mesh.

pub mod bounding_box;

pub mod frame;

pub mod hilbert;

mod integers;

pub mod places;

pub(crate) mod polygon;

pub mod predicates;

pub mod tetrahedron;

pub mod triangle;

pub(crate) mod triples;
