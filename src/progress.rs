//! What a caller hears of a run, and how it stops one.

use glam::DVec3;
use serde::Serialize;

use crate::delaunay::Delaunay;
use crate::geometry::frame::Frame;
use crate::surface::Surface;

/// The stages of a run, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Placing the first seeds.
    Seeds,
    /// Moving them, at most so many iterations.
    Relax {
        /// The bound on the iterations.
        iterations: usize,
    },
    /// Taking the mesh out of the triangulation.
    Extract,
    /// Taking slivers out of it.
    Improve,
}

/// Whether a run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Go on.
    Continue,
    /// Finish with the best state so far.
    Stop,
}

/// How seeds moved in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Move {
    /// Each to the centroid of its piece.
    #[default]
    Lloyd,
    /// The same with momentum.
    Nesterov,
    /// Down the energy by what is known of its curvature.
    Lbfgs,
    /// Towards an optimal Delaunay triangulation: away from slivers, at some cost of energy.
    Odt,
    /// Some of them to where the mesh needs them.
    Insertion,
}

/// One iteration, as `--json` reports it.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Step {
    /// How the seeds moved.
    #[serde(rename = "move")]
    pub kind: Move,
    /// CVT energy of the seeds that the iteration began with, in the model's units to the fifth power.
    pub energy: f64,
    /// Longest way that a seed went, in model units.
    pub max_move: f64,
    /// How often triangulation, cells and energy were computed: twice where a first motion was taken back.
    pub evaluations: usize,
    /// Seconds for the triangulation.
    pub update_s: f64,
    /// Seconds for the clipped cells.
    pub centroids_s: f64,
    /// Finite tets of the triangulation that the iteration ended with.
    pub tets: usize,
    /// Pairs of tets that share a facet, infinite ones included.
    pub bicells: usize,
    /// Vertices that failed a filter.
    pub vertices_failed: usize,
    /// Bi-cells that went on to the exact predicate.
    pub bicells_failed: usize,
    /// Exact predicates evaluated.
    pub predicates: usize,
    /// Flips made.
    pub flips: usize,
    /// Tets found reversed.
    pub reversed: usize,
    /// Vertices held back for a while.
    pub held_back: usize,
    /// Whether the whole triangulation was built anew.
    pub rebuilt: bool,
}

/// What a caller hears of a run. Every method has a default that ignores what it is told.
pub trait Observer: Send {
    /// A stage begins.
    fn stage(&mut self, _stage: Stage) {}

    /// Something that a user should know: a repair, a fall-back, a doubt.
    fn note(&mut self, _text: &str) {}

    /// The seeds at the start (`step` is `None`) and after each iteration; seed i is always `positions[i]`, in the
    /// frame that leads back to the model.
    fn seeds(&mut self, _step: Option<&Step>, _positions: &[DVec3], _frame: &Frame) -> Flow {
        Flow::Continue
    }

    /// A pass of the improvement is about to begin, with so many tets below its floor.
    fn improving(&mut self, _below: usize) -> Flow {
        Flow::Continue
    }

    /// The whole Delaunay triangulation at the end, before extraction, in the frame of the surface that it fills.
    fn triangulation(&mut self, _delaunay: &Delaunay, _surface: &Surface) {}
}

/// Hears nothing.
pub struct Silent;

impl Observer for Silent {}
