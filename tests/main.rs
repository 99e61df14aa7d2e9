//! Every test of the program from outside its modules; one file per subject.

// Which module may use which.
mod architecture;

// Point sets and the exact oracle.
mod support;

// Exact predicates against exact rationals.
mod predicates;

// The triangulation against brute force.
mod delaunay;

// Moved triangulations against rebuilt ones.
mod relocation;

// Exact shapes, and the files of `models/` made of them.
mod shapes;

// Reading and checking surfaces.
mod surface;

// Inside tests, closest points, boxes and rays against brute force.
mod box_tree;

// Creases, corners, patches.
mod features;

// First seeds: counts, spread, kinds.
mod seeds;

// Moments of clipped cells against closed forms and Monte Carlo.
mod clipped_voronoi;

// Energy, determinism.
mod lloyd;

// Creases in the mesh.
mod creases;

// From triangulation to mesh.
mod extract;

// Slivers taken out.
mod improve;

// Each model end to end.
mod models;

// One small model for each mistake that was once made.
mod regression;

// The binary: options, exit statuses, messages.
#[cfg(feature = "cli")]
mod cli;

// The binary against signals, closed pipes, full disks.
#[cfg(all(unix, feature = "cli"))]
mod cli_unix;

// What a run says of its mesh.
mod report;

// Its files, read back by VTK.
#[cfg(feature = "cli")]
mod output;

// Scripts around VTK, in a virtual environment of their own.
#[cfg(feature = "cli")]
mod python;
