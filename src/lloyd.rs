//! Moves seeds to a centroidal Voronoi tessellation.
