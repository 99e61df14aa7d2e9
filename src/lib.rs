//! Tetrahedral meshes with an exact vertex count, from centroidal Voronoi tessellations of closed surfaces.
//!
//! ```text
//! surface ──> seeds ──> Delaunay ──> clipped Voronoi cells ──> extract ──> TetMesh
//!                          ^                   │
//!                          └─────── relax <────┘   all seeds down the CVT energy, until it rests
//! ```
//!
//! The input is a closed triangle surface ([`Surface`]), the output a mesh of the solid that it bounds ([`TetMesh`]): every
//! tet positively oriented, the boundary a closed manifold with the surface's topology, the number of vertices exactly
//! the one asked for. What cannot be meshed is refused with an [`Error`] that says what, where, and what would do.
//!
//! ```
//! use tetcvt::params::Target;
//! use tetcvt::progress::Silent;
//! use tetcvt::{Params, io, tetrahedralize};
//!
//! let surface = io::read_surface("models/cube.obj".as_ref())?;
//! let params = Params { target: Target::Count(200), iterations: 10, ..Params::default() };
//! let mesh = tetrahedralize(&surface, &params, &mut Silent)?;
//! assert_eq!(mesh.points.len(), 200);
//! // The cube has edges of length 2; its creases are kept, and so its volume.
//! assert!((mesh.volume() - 8.0).abs() < 1e-9);
//! # Ok::<(), tetcvt::Error>(())
//! ```
//!
//! An [`Observer`] in the place of [`progress::Silent`] hears of every iteration and can end the run. The kernel stands on
//! its own: [`delaunay::Delaunay::build`] takes any finite points.
//!
//! # Units
//!
//! Within the library lengths are those of a normalised [frame](geometry::frame), in which the model is about 1 in size;
//! what says so is *in the frame*. [`TetMesh`], [`report`] and [`progress::Step`] are in the units of the model.
//!
//! # The same bytes
//!
//! The same surface and parameters give the same mesh, bit for bit, on any number of threads.
//!
//! # Modules
//!
//! They stand in the order of the flow; each uses only those before it (`tests/architecture.rs` makes sure).

// Tools: random numbers, disjoint sets, sorting, mathematics on points.
mod rng;

mod disjoint_sets;

mod bucket_sort;

pub mod geometry;

// The input.
pub mod surface;

// The kernel.
pub mod delaunay;

// What a caller chooses and hears.
pub mod error;

pub mod sizing;

pub mod params;

pub mod progress;

// From the surface to seeds, and to their cells.
pub mod seeds;

pub mod clipped_voronoi;

// The output.
pub mod tet_mesh;

pub mod improve;

// The loop.
pub mod relax;

// From cells to the output, with more seeds where it needs them.
pub mod extract;

mod fidelity;

mod refine;

// All of it, on one screen.
pub mod mesher;

// What can be said of the output.
pub mod quality;

pub mod report;

// The output with curved edges.
pub mod second_order;

// Files.
pub mod io;

// The program.
#[cfg(feature = "cli")]
pub mod cli;

pub use error::Error;
pub use mesher::{tetrahedralize, tetrahedralize_from};
pub use params::Params;
pub use progress::Observer;
pub use surface::Surface;
pub use tet_mesh::TetMesh;
