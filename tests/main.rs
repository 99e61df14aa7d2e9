//! Every test of the program from outside its modules; one file per subject.

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

// From triangulation to mesh.
mod extract;

// Each model end to end.
mod models;

// The binary: options, exit statuses, messages.
mod cli;

// The binary against signals, closed pipes, full disks.
#[cfg(unix)]
mod cli_unix;

// What a run says of its mesh.
mod report;

// Its files, read back by VTK.
mod output;

// Scripts around VTK, in a virtual environment of their own.
mod python;
