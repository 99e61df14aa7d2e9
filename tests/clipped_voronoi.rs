//! Tests of clipped_voronoi.
