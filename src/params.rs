//! What the user chooses; read-only from [`Params::validate`] on.

pub use crate::delaunay::Method as Update;
use crate::error::Error;
use crate::sizing::Sizes;

/// The largest count of vertices: the kernel packs a tet's index and a facet into 32 bits, and there are under 8 tets to a
/// vertex.
pub const MOST_SEEDS: usize = 100_000_000;

/// The largest number of threads: a machine with more would gain nothing from them, and starting them takes long.
const MOST_THREADS: usize = 1024;

/// The largest number of iterations: more than any run will see, and far from overflow.
const MOST_ITERATIONS: usize = 1_000_000_000;

/// The highest floor for dihedral angles, in degrees: regular tets, which do not fill space, have 70.5.
pub const HIGHEST_FLOOR: f64 = 60.0;

/// How many vertices the mesh gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Exactly so many vertices.
    Count(usize),
    /// As many as edges of this length need, in model units.
    Edge(f64),
    /// As many as edges of this share of the surface's bounding-box diagonal need (0.02 = 2 %).
    RelativeEdge(f64),
    /// As many as [`Params::sizes`] need.
    Sizes,
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

/// How seeds move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Optimizer {
    /// By the energy's slope and what is remembered of its curvature: L-BFGS (Liu et al. 2009).
    Lbfgs,
    /// Half again the step of Lloyd with momentum, without a line search (Nesterov 1983).
    Nesterov,
    /// Each seed to the centroid of its cell (Du, Faber, Gunzburger 1999).
    Lloyd,
}

/// The parameters of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// How many vertices: a count of 4 to [`MOST_SEEDS`], or a positive length of edges.
    pub target: Target,
    /// What the length of edges is to depend on. With a count these are relative, with a length of edges that is the
    /// largest.
    pub sizes: Sizes,
    /// Where seeds may lie.
    pub boundary: Boundary,
    /// Edges whose faces' normals differ by more than this, in degrees, are creases: over 0, and 180 keeps none.
    pub feature_angle: f64,
    /// Where interior seeds begin.
    pub start: Start,
    /// How seeds move.
    pub optimizer: Optimizer,
    /// How the triangulation follows them.
    pub update: Update,
    /// At most so many iterations; 0 = only sample. The last sixth, at most four, is against slivers. A few more may follow
    /// where a valid mesh needs further seeds, and fewer are made where seeds settle early.
    pub iterations: usize,
    /// Stop when the energy falls by less than this share of itself in an iteration; 0 = never. Before the surface is followed
    /// 30 times that ends the first part.
    pub tolerance: f64,
    /// Whether slivers are taken out at the end.
    pub improve: bool,
    /// The dihedral angle that the improvement aims at, in degrees: 0 to [`HIGHEST_FLOOR`].
    pub min_dihedral: f64,
    /// Whether vertices of the boundary leave the surface by a little, so that the mesh has its volume.
    pub preserve_volume: bool,
    /// Number of threads; 0 = all cores. The result does not depend on it.
    pub threads: usize,
    /// Seed of every random choice.
    pub random_seed: u64,
    /// Finish with the best mesh so far after about so many seconds.
    pub time_limit: Option<f64>,
    /// Verify every invariant after every iteration (slow).
    pub check: bool,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            target: Target::Count(20_000),
            sizes: Sizes::default(),
            boundary: Boundary::Conform,
            feature_angle: 40.0,
            start: Start::Bcc,
            optimizer: Optimizer::Lbfgs,
            update: Update::Bicell,
            iterations: 23,
            tolerance: 2e-5,
            improve: true,
            min_dihedral: 35.0,
            preserve_volume: false,
            threads: 0,
            random_seed: 1,
            time_limit: None,
            check: false,
        }
    }
}

impl Params {
    /// Refuses values that no run could honour, by the name that their option has on the command line.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn validate(&self) -> Result<(), Error> {
        let refuse = |option: &'static str, reason: String| Err(Error::Parameter { option, reason });
        match self.target {
            Target::Count(n) if !(4..=MOST_SEEDS).contains(&n) => {
                return refuse("seeds", format!("{n} is not between 4 and {MOST_SEEDS}"));
            }
            Target::Edge(l) | Target::RelativeEdge(l) if !(l.is_finite() && l > 0.0) => {
                return refuse("edge", format!("{l} is not a positive length"));
            }
            Target::Sizes if !self.sizes.vary() => {
                return refuse("size-field", "there are no sizes for the number of vertices to follow from".to_owned());
            }
            _ => {}
        }
        self.sizes.validate()?;
        if !(self.feature_angle > 0.0 && self.feature_angle <= 180.0) {
            return refuse("feature-angle", format!("{} is not over 0 and at most 180 degrees", self.feature_angle));
        }
        if !(self.tolerance >= 0.0 && self.tolerance.is_finite()) {
            return refuse("tolerance", format!("{} is not a finite number of at least 0", self.tolerance));
        }
        if let Some(limit) = self.time_limit
            && !(limit >= 0.0 && limit.is_finite())
        {
            return refuse("time-limit", format!("{limit} is not a finite number of at least 0 seconds"));
        }
        if !(0.0..=HIGHEST_FLOOR).contains(&self.min_dihedral) {
            return refuse(
                "min-dihedral",
                format!("{} is not between 0 and {HIGHEST_FLOOR} degrees", self.min_dihedral),
            );
        }
        if self.preserve_volume && (!self.improve || self.boundary == Boundary::Free) {
            let reason = "takes the improvement, and seeds on the surface to begin with".to_string();
            return refuse("preserve-volume", reason);
        }
        if self.threads > MOST_THREADS {
            return refuse("threads", format!("{} is more than {MOST_THREADS}", self.threads));
        }
        if self.iterations > MOST_ITERATIONS {
            return refuse("iterations", format!("{} is more than {MOST_ITERATIONS}", self.iterations));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The option that is refused once `change` has been made to the defaults.
    fn refused(change: impl FnOnce(&mut Params)) -> Option<&'static str> {
        let mut params = Params::default();
        change(&mut params);
        match params.validate() {
            Ok(()) => None,
            Err(Error::Parameter { option, .. }) => Some(option),
            Err(other) => panic!("{other}"),
        }
    }

    #[test]
    fn what_no_run_could_honour_is_refused_by_its_option() {
        assert_eq!(refused(|_| ()), None);
        for n in [0, 3, MOST_SEEDS + 1, usize::MAX] {
            assert_eq!(refused(|p| p.target = Target::Count(n)), Some("seeds"));
        }
        for l in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(refused(|p| p.target = Target::Edge(l)), Some("edge"));
            assert_eq!(refused(|p| p.target = Target::RelativeEdge(l)), Some("edge"));
        }
        for angle in [0.0, -1.0, 180.1, f64::NAN] {
            assert_eq!(refused(|p| p.feature_angle = angle), Some("feature-angle"));
        }
        for tolerance in [-1e-9, f64::NAN, f64::INFINITY] {
            assert_eq!(refused(|p| p.tolerance = tolerance), Some("tolerance"));
        }
        for limit in [-1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(refused(|p| p.time_limit = Some(limit)), Some("time-limit"));
        }
        for angle in [-1.0, 60.1, f64::NAN, f64::INFINITY] {
            assert_eq!(refused(|p| p.min_dihedral = angle), Some("min-dihedral"));
        }
        for (improve, boundary) in [(false, Boundary::Conform), (true, Boundary::Free)] {
            let change = |p: &mut Params| (p.preserve_volume, p.improve, p.boundary) = (true, improve, boundary);
            assert_eq!(refused(change), Some("preserve-volume"));
        }
        assert_eq!(refused(|p| p.threads = 65_535), Some("threads"));
        assert_eq!(refused(|p| p.iterations = usize::MAX), Some("iterations"));
    }

    #[test]
    fn the_ends_of_each_range_are_allowed() {
        for n in [4, MOST_SEEDS] {
            assert_eq!(refused(|p| p.target = Target::Count(n)), None);
        }
        assert_eq!(refused(|p| p.feature_angle = 180.0), None);
        for angle in [0.0, HIGHEST_FLOOR] {
            assert_eq!(refused(|p| p.min_dihedral = angle), None);
        }
        assert_eq!(refused(|p| p.preserve_volume = true), None);
        assert_eq!(refused(|p| p.tolerance = 0.0), None);
        assert_eq!(refused(|p| p.iterations = 0), None);
        assert_eq!(refused(|p| p.time_limit = Some(0.0)), None);
    }
}
