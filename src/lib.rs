//! Tetrahedral meshes with an exact vertex count, from centroidal Voronoi tessellations of closed surfaces.
//!
//! ```text
//! surface --> seeds --> [ centroids of clipped cells --> move --> Delaunay triangulation ]*  --> extract --> TetMesh
//! ```

pub mod error;

pub mod params;

pub mod progress;

pub mod geometry;

pub mod rng;

mod disjoint_sets;

pub mod surface;

pub mod seeds;

pub mod delaunay;

pub mod clipped_voronoi;

pub mod lloyd;

pub mod tet_mesh;

pub mod quality;

pub mod extract;

pub mod fidelity;

pub mod refine;

pub mod mesher;

pub mod report;

pub mod io;

#[cfg(feature = "cli")]
pub mod cli;

pub use error::Error;
pub use mesher::tetrahedralize;
pub use params::Params;
pub use progress::Observer;
pub use surface::Surface;
pub use tet_mesh::TetMesh;
