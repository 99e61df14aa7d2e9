//! Tests of delaunay.
