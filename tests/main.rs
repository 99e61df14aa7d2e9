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

// The same by every method.
mod updaters;

// Points added and taken out, one by one.
mod editing;

// Exact shapes, and the files of `models/` made of them.
mod shapes;

// Reading and checking surfaces.
mod surface;

// Every format that is read.
mod input_formats;

// Scenes of glTF.
mod gltf;

// Self-crossings, and what is mended on request.
mod defects;

// Inside tests, closest points, boxes and rays against brute force.
mod box_tree;

// Creases, corners, patches.
mod features;

// First seeds: counts, spread, kinds.
mod seeds;

// Moments of clipped cells against closed forms and Monte Carlo.
mod clipped_voronoi;

// The same moments in exact integers.
mod moments;

// Energy, kinds of seeds, determinism, stopping.
mod relax;

// Sizes that vary.
mod sizes;

// Creases in the mesh.
mod creases;

// Lines of the user's on the surface, and in the mesh.
mod lines;

// Meshes from the points of earlier ones.
mod init;

// From triangulation to mesh.
mod extract;

// Nested shells as interfaces between regions.
mod regions;

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

// The binary on surfaces of every kind, and on files of other programs.
#[cfg(feature = "cli")]
mod cli_input;

// What a run says of its mesh.
mod report;

// Its files, read back by VTK.
#[cfg(feature = "cli")]
mod output;

// The other formats, curved tets and Voronoi cells, each read back by the programs that they are for.
#[cfg(feature = "cli")]
mod output_formats;

// One mesh at any scale and offset.
mod scale;

// Beside other meshers.
#[cfg(feature = "cli")]
mod peers;

// Scripts around VTK, in a virtual environment of their own.
#[cfg(feature = "cli")]
mod python;

mod trajectories;
