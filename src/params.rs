//! What the user chooses. Read-only after [`Params::validate`].

use crate::error::Error;

/// How many vertices the mesh gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Exactly so many vertices.
    Count(usize),
    /// As many as edges of this length need, in model units.
    Edge(f64),
    /// As many as edges of this share of the surface's bounding-box diagonal need (0.02 = 2 %).
    RelativeEdge(f64),
}

/// Where seeds may lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Boundary {
    /// Seeds on corners, creases and the surface stay there, so that the mesh follows the surface.
    Conform,
    /// Every seed moves to the centroid of its clipped cell.
    Free,
}

/// Where interior seeds begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Start {
    /// A randomly rotated, slightly jittered body-centred cubic lattice.
    Bcc,
    /// Blue noise.
    Blue,
    /// White noise.
    Random,
}

/// How the triangulation follows the moving seeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Update {
    /// The triangulation is built anew in every iteration.
    Rebuild,
}

/// How seeds move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Optimizer {
    /// Each seed to the centroid of its cell (Du, Faber, Gunzburger 1999).
    Lloyd,
}

/// The parameters of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// How many vertices.
    pub target: Target,
    /// Where seeds may lie.
    pub boundary: Boundary,
    /// Edges whose faces' normals differ by more than this, in degrees, are creases; 180 keeps none.
    pub feature_angle: f64,
    /// Where interior seeds begin.
    pub start: Start,
    /// How seeds move.
    pub optimizer: Optimizer,
    /// How the triangulation follows them.
    pub update: Update,
    /// At most so many iterations; 0 = only sample.
    pub iterations: usize,
    /// Stop when the energy falls by less than this share of itself in an iteration; 0 = never.
    pub tolerance: f64,
    /// Number of threads; 0 = all cores. The result does not depend on it.
    pub threads: usize,
    /// Seed of every random choice.
    pub random_seed: u64,
    /// Verify every invariant after every iteration (slow).
    pub check: bool,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            target: Target::Count(20_000),
            boundary: Boundary::Conform,
            feature_angle: 40.0,
            start: Start::Bcc,
            optimizer: Optimizer::Lloyd,
            update: Update::Rebuild,
            iterations: 100,
            tolerance: 1e-6,
            threads: 0,
            random_seed: 1,
            check: false,
        }
    }
}

impl Params {
    /// Refuses values that no run could honour.
    pub fn validate(&self) -> Result<(), Error> {
        let refuse = |option: &'static str, reason: String| Err(Error::Parameter { option, reason });
        match self.target {
            // The kernel packs a tet's index and a facet into 32 bits; a mesh has under 8 tets a vertex.
            Target::Count(n) if !(4..=100_000_000).contains(&n) => {
                return refuse("seeds", format!("{n} is not between 4 and 100000000"));
            }
            Target::Edge(l) | Target::RelativeEdge(l) if !(l.is_finite() && l > 0.0) => {
                return refuse("edge", format!("{l} is not a positive length"));
            }
            _ => {}
        }
        if !(self.feature_angle > 0.0 && self.feature_angle <= 180.0) {
            return refuse("feature-angle", format!("{} is not over 0 and at most 180 degrees", self.feature_angle));
        }
        if !(self.tolerance >= 0.0 && self.tolerance.is_finite()) {
            return refuse("tolerance", format!("{} is not a finite number of at least 0", self.tolerance));
        }
        Ok(())
    }
}
