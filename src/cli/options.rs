//! The command line, and what it asks for once it makes sense.

use std::num::{IntErrorKind, ParseIntError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{ArgAction, Parser};

use crate::error::Error;
use crate::io::atomic;
use crate::io::format::{Encoding, MeshFormat, SurfaceFormat};
use crate::io::{read_initial, read_lines, read_sizes};
use crate::params::{Boundary, Optimizer, Params, Start, Target, Update};
use crate::seeds::InitialPoints;
use crate::sizing::{SizeField, Sizes};
use crate::surface::imprint::Polyline;
use crate::surface::{Mending, Regions, Treatment};

/// Iterations from the points of a mesh: the mean of the smallest dihedral angles is then within 1.5 degrees of that from new seeds.
const ITERATIONS_FROM_MESH: usize = 8;

const AFTER_HELP: &str = "\
Formats, by extension:
  mesh     .vtu, .vtk (VTK), .msh (Gmsh 4.1), .mesh (Medit), .inp (Abaqus), .node or .ele (TetGen: both, and .face)
  surface  .vtp, .vtk (VTK), .obj, .stl, .ply

Exit status:
  0    done
  1    the surface cannot be meshed (open, non-manifold, self-crossing, ...)
  2    wrong usage
  3    cannot read or parse the surface
  4    cannot write
  5    no valid mesh at this count
  130  interrupted with nothing to keep

Ctrl-C, or SIGTERM, finishes with the seeds as they are; a second one stops at once.
Progress and messages go to standard error, standard output carries only what is asked for.

Examples:
  tetcvt bunny.obj --seeds 20000
      bunny.vtu, a mesh of exactly 20000 vertices, and bunny.surface.vtp, its boundary
  tetcvt part.obj --edge 2% -o out/part.vtu --surface out/part.vtp --json out/part.json
      edges of 2 % of the diagonal, files where you want them, and a report
  tetcvt part.obj -o part.msh --second-order --surface part.stl
      curved tets for Gmsh, with groups for regions and patches, and the boundary as STL
  tetcvt part.obj --size-field '0.5 + 0.1*x' --edge 2
      edges that grow with x, none over 2 long
  tetcvt frame2.obj --init frame1.vtu
      the mesh of frame 1 carried over to frame 2 of a motion, vertex by vertex";

/// Fills a closed triangle surface with tetrahedra, by a centroidal Voronoi tessellation.
#[derive(Debug, Parser)]
#[command(version, after_help = AFTER_HELP, max_term_width = 100)]
pub(super) struct Options {
    /// Closed triangle surface: OBJ, STL, PLY, OFF, VTK (.vtk, .vtp, .vtu), glTF (.gltf, .glb)
    #[arg(value_name = "SURFACE")]
    surface: PathBuf,

    /// Mend small holes and gaps, duplicate faces, hanging sheets, parts that touch
    #[arg(long, help_heading = "Surface")]
    repair: bool,

    /// What shells inside others are
    #[arg(long, help_heading = "Surface", default_value = "parity")]
    regions: Regions,

    /// Vertices of the mesh: exactly N [default: 20000]
    #[arg(long, value_name = "N", help_heading = "Size", value_parser = count, conflicts_with = "edge", allow_negative_numbers = true)]
    seeds: Option<usize>,

    /// Target edge length in model units, in place of --seeds; 2% = of the bounding-box diagonal
    #[arg(long, value_name = "L|L%", help_heading = "Size", value_parser = edge, allow_hyphen_values = true)]
    edge: Option<Target>,

    /// Edge lengths: an expression in x, y, z, or a mesh with point data `size`; with --seeds relative
    #[arg(long, value_name = "EXPR|FILE", help_heading = "Size", allow_hyphen_values = true)]
    size_field: Option<String>,

    /// Edges are the radius of curvature over K [K: 4], at most 5 % of the diagonal; with --seeds relative
    #[arg(
        long,
        value_name = "K",
        help_heading = "Size",
        num_args = 0..=1,
        default_missing_value = "4",
        allow_negative_numbers = true
    )]
    curvature: Option<f64>,

    /// Edge lengths grow by at most G per length [default: 0.3 with --size-field or --curvature]
    #[arg(long, value_name = "G", help_heading = "Size", allow_negative_numbers = true)]
    grade: Option<f64>,

    /// Where seeds may lie
    #[arg(long, help_heading = "Seeds", default_value = "conform")]
    boundary: Boundary,

    /// Creases sharper than this are kept, in degrees; 180 keeps none
    #[arg(long, value_name = "DEG", help_heading = "Seeds", default_value_t = 40.0, allow_negative_numbers = true)]
    feature_angle: f64,

    /// Lines on the surface to keep like creases: the `l` statements of an OBJ file
    #[arg(long, value_name = "FILE.obj", help_heading = "Seeds")]
    features: Option<PathBuf>,

    /// Where interior seeds begin
    #[arg(long, help_heading = "Seeds", default_value = "bcc")]
    start: Start,

    /// Start from the points of a mesh, .vtu or .vtk: point i becomes vertex i; for a surface that moved a little
    #[arg(long, value_name = "MESH", help_heading = "Seeds", conflicts_with_all = ["edge", "start"])]
    init: Option<PathBuf>,

    /// How seeds move
    #[arg(long, help_heading = "Iterations", default_value = "lbfgs")]
    optimizer: Optimizer,

    /// At most K iterations; 0 = only sample [default: 23; with --init 8]
    #[arg(long, value_name = "K", help_heading = "Iterations", value_parser = count, allow_negative_numbers = true)]
    iterations: Option<usize>,

    /// Stop when the energy falls by less than T of itself in an iteration; 0 = never
    #[arg(long, value_name = "T", help_heading = "Iterations", default_value = "2e-5", allow_negative_numbers = true)]
    tolerance: f64,

    /// How the triangulation follows the seeds
    #[arg(long, help_heading = "Iterations", default_value = "bicell")]
    update: Update,

    /// The floor that the improvement of dihedral angles aims at, in degrees
    #[arg(
        long,
        value_name = "DEG",
        help_heading = "Improvement",
        default_value_t = 35.0,
        allow_negative_numbers = true,
        conflicts_with = "no_improve"
    )]
    min_dihedral: f64,

    /// Leave the Delaunay tets as they are
    #[arg(long, help_heading = "Improvement")]
    no_improve: bool,

    /// Move the boundary's vertices off the surface by a little, so that the mesh has exactly its volume
    #[arg(long, help_heading = "Improvement", conflicts_with_all = ["no_improve", "second_order"])]
    preserve_volume: bool,

    /// Threads [default: all cores]; the result does not depend on it
    #[arg(long, value_name = "N", help_heading = "Run", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,

    /// Seed of every random choice
    #[arg(long, value_name = "N", help_heading = "Run", default_value_t = 1)]
    random_seed: u64,

    /// Finish with the best mesh so far after about S seconds
    #[arg(long, value_name = "S", help_heading = "Run", allow_negative_numbers = true)]
    time_limit: Option<f64>,

    /// Verify every invariant after every iteration (slow)
    #[arg(long, help_heading = "Run")]
    check: bool,

    /// Print nothing but errors
    #[arg(short, long, help_heading = "Run", conflicts_with = "verbose")]
    quiet: bool,

    /// Print a line for each iteration
    #[arg(short, long, help_heading = "Run", action = ArgAction::Count)]
    verbose: u8,

    /// The mesh, in a format below [default: <stem of SURFACE>.vtu in the current folder]
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    output: Option<PathBuf>,

    /// The restricted Delaunay surface [default: <stem of SURFACE>.surface.vtp in the current folder]
    #[arg(long = "surface", id = "surface_output", value_name = "FILE", help_heading = "Output")]
    surface_output: Option<PathBuf>,

    /// The clipped Voronoi cells of the seeds, as polyhedra: .vtu
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    voronoi: Option<PathBuf>,

    /// Tets with nodes in the middle of their edges, on the surface where the edge is: .vtu, .vtk, .msh, .inp
    #[arg(long, help_heading = "Output")]
    second_order: bool,

    /// Text instead of binary, in formats that have both: .msh, .stl, .ply
    #[arg(long, help_heading = "Output")]
    ascii: bool,

    /// Everything the run knows of itself; - = standard output
    #[arg(long, value_name = "FILE|-", help_heading = "Output")]
    json: Option<PathBuf>,

    /// Positions of all seeds after each iteration: .npy, float64, shape (iterations + 1, seeds, 3)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    trajectory: Option<PathBuf>,

    /// The whole Delaunay triangulation at the end: .vtu
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    delaunay: Option<PathBuf>,
}

/// A number of things.
fn count(text: &str) -> Result<usize, String> {
    text.parse().map_err(|error: ParseIntError| match error.kind() {
        IntErrorKind::PosOverflow => "that is more than any run could have".to_owned(),
        _ => "a whole number is wanted".to_owned(),
    })
}

/// `--edge`: a length, or a share of the diagonal.
fn edge(text: &str) -> Result<Target, String> {
    let (number, share) = match text.strip_suffix('%') {
        Some(number) => (number, true),
        None => (text, false),
    };
    match number.trim().parse::<f64>() {
        Ok(l) if share => Ok(Target::RelativeEdge(l / 100.0)),
        Ok(l) => Ok(Target::Edge(l)),
        Err(_) => Err("a length such as 0.05, or a share of the diagonal such as 2%, is wanted".to_owned()),
    }
}

/// How much is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Verbosity {
    /// Errors.
    Quiet,
    /// Progress, notes and the summary.
    Normal,
    /// A line for each iteration too.
    Verbose,
}

/// Where the report goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ReportTarget {
    /// To standard output.
    StandardOutput,
    /// To a file.
    File(PathBuf),
}

/// A command line that makes sense.
pub(super) struct Job {
    pub surface: PathBuf,
    init: Option<PathBuf>,
    size_file: Option<PathBuf>,
    pub initial: Option<InitialPoints>,
    features: Option<PathBuf>,
    pub lines: Vec<Polyline>,
    pub treatment: Treatment,
    pub defects_file: PathBuf,
    pub params: Params,
    pub verbosity: Verbosity,
    pub mesh_file: PathBuf,
    pub mesh_format: MeshFormat,
    pub second_order: bool,
    pub surface_file: PathBuf,
    pub surface_format: SurfaceFormat,
    pub encoding: Encoding,
    pub voronoi: Option<PathBuf>,
    pub report: Option<ReportTarget>,
    pub trajectory: Option<PathBuf>,
    pub delaunay: Option<PathBuf>,
}

impl Options {
    /// Refuses what no run could honour, before anything is computed.
    pub(super) fn into_job(self) -> Result<Job, Error> {
        let mut params = self.params();
        if let Some(path) = self.size_file() {
            // Before the rest is validated, which says nothing of files.
            params.sizes.field = Some(SizeField::Mesh(Arc::new(read_sizes(path)?)));
        }
        params.validate()?;
        let size_file = self.size_file().map(Path::to_owned);
        let stem = self.surface.file_stem().unwrap_or(self.surface.as_os_str()).to_owned();
        let default_name = |suffix: &str| {
            let mut name = stem.clone();
            name.push(suffix);
            PathBuf::from(name)
        };
        let defects_file = default_name(".defects.vtp");
        let mending = if self.repair { Mending::Repair } else { Mending::Exact };
        let treatment = Treatment { mending, regions: self.regions };
        let mesh_file = self.output.unwrap_or_else(|| default_name(".vtu"));
        let surface_file = self.surface_output.unwrap_or_else(|| default_name(".surface.vtp"));
        let mesh_format = MeshFormat::of(&mesh_file).ok_or_else(|| unknown("output", &mesh_file, MeshFormat::KNOWN))?;
        let surface_format =
            SurfaceFormat::of(&surface_file).ok_or_else(|| unknown("surface", &surface_file, SurfaceFormat::KNOWN))?;
        fits(&params, mesh_format, &mesh_file)?;
        if self.second_order && !mesh_format.has_second_order() {
            return refuse("second-order", format!("the format of {} has no such tets", mesh_file.display()));
        }
        if self.ascii && !mesh_format.has_text() && !surface_format.has_text() {
            return refuse("ascii", "no file of this run is binary or text at choice".to_owned());
        }
        has_extension("voronoi", self.voronoi.as_deref(), "vtu")?;
        has_extension("trajectory", self.trajectory.as_deref(), "npy")?;
        has_extension("delaunay", self.delaunay.as_deref(), "vtu")?;
        let report = self.json.map(|path| match path.to_str() {
            Some("-") => ReportTarget::StandardOutput,
            _ => ReportTarget::File(path),
        });
        let verbosity = match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (false, 0) => Verbosity::Normal,
            (false, _) => Verbosity::Verbose,
        };
        let (trajectory, delaunay) = (self.trajectory, self.delaunay);
        let surface = self.surface;
        let initial = self.init.as_deref().map(read_initial).transpose()?;
        if let Some(initial) = &initial {
            initial.validate()?;
            params.target = agreed(initial.points.len(), self.seeds)?;
            fits(&params, mesh_format, &mesh_file)?;
        }
        if self.features.is_some() && params.boundary == Boundary::Free {
            return refuse("features", "with --boundary free no seed lies on a line of the surface".to_owned());
        }
        let lines = self.features.as_deref().map(read_lines).transpose()?.unwrap_or_default();
        let job = Job {
            surface,
            init: self.init,
            size_file,
            initial,
            features: self.features,
            lines,
            treatment,
            defects_file,
            params,
            verbosity,
            mesh_file,
            mesh_format,
            surface_file,
            surface_format,
            second_order: self.second_order,
            encoding: if self.ascii { Encoding::Text } else { Encoding::Binary },
            voronoi: self.voronoi,
            report,
            trajectory,
            delaunay,
        };
        job.check_files()?;
        Ok(job)
    }

    /// The file that sizes come from, if it is no expression.
    fn size_file(&self) -> Option<&Path> {
        let path = Path::new(self.size_field.as_ref()?);
        let is_file =
            path.extension().is_some_and(|e| ["vtu", "vtk"].iter().any(|known| e.eq_ignore_ascii_case(known)));
        is_file.then_some(path)
    }

    fn params(&self) -> Params {
        let defaults = Params::default();
        let target = match (self.seeds, self.edge) {
            (Some(count), _) => Target::Count(count),
            (None, Some(edge)) => edge,
            (None, None) if self.size_field.is_some() || self.curvature.is_some() => Target::Sizes,
            (None, None) => defaults.target,
        };
        let sizes = Sizes {
            field: self.size_field.clone().map(SizeField::Expression),
            curvature: self.curvature,
            grade: self.grade,
        };
        Params {
            target,
            sizes,
            boundary: self.boundary,
            feature_angle: self.feature_angle,
            start: self.start,
            optimizer: self.optimizer,
            update: self.update,
            iterations: self.iterations.unwrap_or(match self.init {
                None => defaults.iterations,
                Some(_) => ITERATIONS_FROM_MESH,
            }),
            tolerance: self.tolerance,
            improve: !self.no_improve,
            min_dihedral: self.min_dihedral,
            preserve_volume: self.preserve_volume,
            threads: self.threads.map_or(0, usize::from),
            random_seed: self.random_seed,
            time_limit: self.time_limit,
            check: self.check,
        }
    }
}

impl Job {
    /// The files to be written, by option.
    fn outputs(&self) -> Vec<(&'static str, PathBuf)> {
        let mut outputs: Vec<_> = self.mesh_files().into_iter().map(|path| ("output", path)).collect();
        outputs.push(("surface", self.surface_file.clone()));
        if let Some(ReportTarget::File(path)) = &self.report {
            outputs.push(("json", path.clone()));
        }
        let others = [("trajectory", &self.trajectory), ("delaunay", &self.delaunay), ("voronoi", &self.voronoi)];
        outputs.extend(others.into_iter().filter_map(|(option, path)| Some((option, path.clone()?))));
        outputs
    }

    /// The files that make up the mesh.
    pub(super) fn mesh_files(&self) -> Vec<PathBuf> {
        self.mesh_format.files(&self.mesh_file)
    }

    /// No output may be the input, nor another output; each must be writable.
    fn check_files(&self) -> Result<(), Error> {
        let outputs = self.outputs();
        for (i, (option, path)) in outputs.iter().enumerate() {
            if atomic::same_file(path, &self.surface) {
                return refuse(option, format!("{} is the surface itself", path.display()));
            }
            if self.init.as_deref().is_some_and(|init| atomic::same_file(path, init)) {
                return refuse(option, format!("{} is the mesh to start from", path.display()));
            }
            if self.size_file.as_deref().is_some_and(|file| atomic::same_file(path, file)) {
                return refuse(option, format!("{} is the file of sizes", path.display()));
            }
            if self.features.as_deref().is_some_and(|features| atomic::same_file(path, features)) {
                return refuse(option, format!("{} holds the lines of --features", path.display()));
            }
            if let Some((other, _)) = outputs[..i].iter().find(|(_, earlier)| atomic::same_file(path, earlier)) {
                return refuse(option, format!("{} is also the file of --{other}", path.display()));
            }
        }
        outputs.iter().try_for_each(|(_, path)| atomic::check_writable(path))
    }
}

fn refuse<T>(option: &'static str, reason: String) -> Result<T, Error> {
    Err(Error::Parameter { option, reason })
}

/// Refuses a count whose mesh the format could not hold, before anything is computed.
fn fits(params: &Params, format: MeshFormat, path: &Path) -> Result<(), Error> {
    // VTK's legacy format counts the entries of its cells in 32 bits: 5 for a tet, of which there are under 7 to a vertex.
    const MOST_IN_LEGACY: usize = i32::MAX as usize / 35;
    match params.target {
        Target::Count(n) if format == MeshFormat::Vtk && n > MOST_IN_LEGACY => {
            let reason = format!("{} could not hold {n} vertices; a .vtu can", path.display());
            refuse("output", reason)
        }
        _ => Ok(()),
    }
}

/// The count of a mesh to start from, which `--seeds` may state but not change.
fn agreed(points: usize, asked: Option<usize>) -> Result<Target, Error> {
    match asked {
        Some(n) if n != points => {
            refuse("seeds", format!("the mesh of --init has {points} points, all of which become vertices, not {n}"))
        }
        _ => Ok(Target::Count(points)),
    }
}

fn unknown(option: &'static str, path: &Path, known: &str) -> Error {
    let reason = format!("the format of {} is not known by its name; it should end in {known}", path.display());
    Error::Parameter { option, reason }
}

fn has_extension(option: &'static str, path: Option<&Path>, wanted: &str) -> Result<(), Error> {
    match path {
        Some(path) if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted)) => {
            Err(unknown(option, path, &format!(".{wanted}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_definition_is_sound() {
        Options::command().debug_assert();
    }

    #[test]
    fn the_defaults_are_those_of_the_library() {
        let options = Options::try_parse_from(["tetcvt", "a.obj"]).unwrap();
        assert_eq!(options.params(), Params::default());
    }

    #[test]
    fn edges_are_lengths_or_shares() {
        assert_eq!(edge("0.05"), Ok(Target::Edge(0.05)));
        assert_eq!(edge("2%"), Ok(Target::RelativeEdge(0.02)));
        assert!(edge("2 mm").is_err() && edge("").is_err() && edge("%").is_err());
    }
}
