//! A triangulation that follows moving points by the method of one's choice.

use glam::DVec3;

use super::{Delaunay, DelaunayError, Relocation};

/// How the triangulation follows the moving points. The result is the same, tet for tet; the time is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Method {
    /// All of the triangulation is tested and the little that has changed is mended, by flips.
    Bicell,
    /// As bicell, with the predicate on every bi-cell: no filter.
    Check,
    /// The triangulation is built anew each time.
    Rebuild,
}

impl Method {
    /// Every method.
    pub const ALL: [Method; 3] = [Method::Bicell, Method::Check, Method::Rebuild];

    /// Its name, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::Bicell => "bicell",
            Method::Check => "check",
            Method::Rebuild => "rebuild",
        }
    }
}

/// A triangulation of moving points, and what its method keeps from one motion to the next.
#[derive(Clone, Debug)]
pub struct Updater {
    delaunay: Delaunay,
    method: Method,
}

impl Updater {
    /// Follows the points of `delaunay` by `method`.
    pub fn new(delaunay: Delaunay, method: Method) -> Updater {
        Updater { delaunay, method }
    }

    /// Moves the points; the triangulation is then that of [`Delaunay::build`], tet for tet, if in another order.
    ///
    /// On an error nothing has changed.
    pub fn relocate(&mut self, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        match self.method {
            Method::Bicell => self.delaunay.relocate(new_positions),
            Method::Check => self.delaunay.relocate_unfiltered(new_positions),
            Method::Rebuild => self.delaunay.rebuild(new_positions),
        }
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The triangulation.
    pub fn delaunay(&self) -> &Delaunay {
        &self.delaunay
    }

    /// The triangulation, for keeps.
    pub fn into_delaunay(self) -> Delaunay {
        self.delaunay
    }
}
