//! A triangulation that follows moving points by the method of one's choice.

use glam::DVec3;

use super::bicell_filter::BicellFilter;
use super::vertex_filter::VertexFilter;
use super::{Delaunay, DelaunayError, Relocation};

/// How the triangulation follows the moving points. The result is the same, tet for tet; the time is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Method {
    /// All of the triangulation is tested and the little that has changed is mended, by flips.
    Bicell,
    /// Zhou et al. 2010, as printed: a tolerance for each bi-cell; built anew where a tet is reversed.
    Paper,
    /// De Castro et al. 2009: a tolerance for each vertex; those beyond it are moved or inserted anew.
    Vertex,
    /// As bicell, with the predicate on every bi-cell: no filter.
    Check,
    /// The triangulation is built anew each time.
    Rebuild,
}

impl Method {
    /// Every method.
    pub const ALL: [Method; 5] = [Method::Bicell, Method::Paper, Method::Vertex, Method::Check, Method::Rebuild];

    /// Its name, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::Bicell => "bicell",
            Method::Paper => "paper",
            Method::Vertex => "vertex",
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
    state: State,
}

/// What a method keeps from one motion to the next, beside what the triangulation does.
#[derive(Clone, Debug)]
enum State {
    None,
    Paper(BicellFilter),
    Vertex(VertexFilter),
}

impl Updater {
    /// Follows the points of `delaunay` by `method`.
    pub fn new(delaunay: Delaunay, method: Method) -> Updater {
        let state = match method {
            Method::Paper => State::Paper(BicellFilter::default()),
            Method::Vertex => State::Vertex(VertexFilter::default()),
            Method::Bicell | Method::Check | Method::Rebuild => State::None,
        };
        Updater { delaunay, method, state }
    }

    /// Moves the points; the triangulation is then that of [`Delaunay::build`], tet for tet, if in another order.
    ///
    /// On an error nothing has changed.
    pub fn relocate(&mut self, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        match &mut self.state {
            State::Paper(filter) => filter.relocate(&mut self.delaunay, new_positions),
            State::Vertex(filter) => filter.relocate(&mut self.delaunay, new_positions),
            State::None if self.method == Method::Rebuild => self.delaunay.rebuild(new_positions),
            State::None if self.method == Method::Check => self.delaunay.relocate_unfiltered(new_positions),
            State::None => self.delaunay.relocate(new_positions),
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
