//! What can go wrong that a user can mend, with the exit status that it ends the program with.

use std::path::PathBuf;

use crate::delaunay::DelaunayError;
use crate::surface::defects::{Defect, coordinates};
use crate::surface::imprint::LineError;

/// Why a run ended without a mesh: cause, place, and the way out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option's value that no run can honour.
    #[error("--{option}: {reason}")]
    Parameter {
        /// The option, without its dashes.
        option: &'static str,
        /// What is wrong with the value.
        reason: String,
    },
    /// A file that cannot be read or parsed.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        reason: String,
    },
    /// A file that cannot be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        reason: String,
    },
    /// A surface that does not bound a solid.
    #[error("the surface cannot be meshed: {0}")]
    Surface(#[from] Defect),
    /// A line of the user's that is not on the surface.
    #[error("--features: {0}")]
    Line(#[from] LineError),
    /// Points that have no Delaunay triangulation.
    #[error(transparent)]
    Delaunay(#[from] DelaunayError),
    /// The surface needs more seeds than the run has.
    #[error(
        "{count} vertices are too few for a valid mesh: {reason} near {}; about {needed} would do (--seeds {needed})",
        coordinates(*place)
    )]
    TooFewSeeds {
        /// Vertices asked for.
        count: usize,
        /// A count that should be enough.
        needed: usize,
        /// What cannot be represented.
        reason: String,
        /// Where, in model coordinates.
        place: [f64; 3],
    },
    /// An invariant that `--check` found broken, or a mesh that is not valid: a bug.
    #[error("{0}: this is a bug in tetcvt")]
    Broken(String),
    /// Stopped by the user before there was anything to keep.
    #[error("interrupted with nothing to keep")]
    Interrupted,
}

impl Error {
    /// The exit status that the command line promises for this error.
    pub fn exit_status(&self) -> u8 {
        match self {
            Error::Surface(_) | Error::Delaunay(_) => 1,
            Error::Parameter { .. } | Error::Line(_) => 2,
            Error::Read { .. } => 3,
            Error::Write { .. } => 4,
            Error::TooFewSeeds { .. } | Error::Broken(_) => 5,
            Error::Interrupted => 130,
        }
    }
}
