//! Which trajectories: those of the 3D experiments of Zhou et al. 2010.

use std::path::{Path, PathBuf};

use super::Outcome;

/// Where seeds begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Uniformly random in the solid.
    Uniform,
    /// Random, some hundred times as dense at one end of the solid as at the other.
    Crowded,
    /// Uniformly random on the surface, where they stay.
    Surface,
}

/// A run of Lloyd's iteration.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// By which it is chosen, and its files are named.
    pub name: &'static str,
    /// The surface.
    pub model: &'static str,
    /// Count of seeds.
    pub seeds: usize,
    /// Iterations.
    pub iterations: usize,
    /// Where they begin.
    pub start: Start,
}

/// The extent of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Every part, in about a minute.
    Short,
    /// The paper's counts, for hours.
    Full,
}

/// How often what depends on no history is measured: in every so many iterations, and more often while they change most.
#[derive(Clone, Copy, Debug)]
pub struct Sampling {
    /// Rebuilding, ours and CGAL's; and in every iteration up to [`Sampling::ALL_UNTIL`].
    pub rebuild: usize,
    /// CGAL's relocation, from the frame before, which takes longest of all; and in iterations that are powers of two.
    pub relocation: usize,
}

impl Sampling {
    /// Every rebuild is measured up to this iteration.
    pub const ALL_UNTIL: usize = 20;

    /// Whether rebuilding is measured in iteration `k`.
    pub fn rebuilds(&self, k: usize) -> bool {
        k <= Sampling::ALL_UNTIL || k.is_multiple_of(self.rebuild)
    }

    /// Whether CGAL's relocation is measured in iteration `k`.
    pub fn relocates(&self, k: usize) -> bool {
        k.is_power_of_two() || k.is_multiple_of(self.relocation)
    }
}

impl Extent {
    /// Also the name of its folder.
    pub fn name(self) -> &'static str {
        match self {
            Extent::Short => "short",
            Extent::Full => "full",
        }
    }

    /// Its experiments.
    pub fn experiments(self) -> Vec<Experiment> {
        let new = |name, model, seeds, iterations, start| Experiment { name, model, seeds, iterations, start };
        match self {
            Extent::Short => vec![
                new("bunny-5k", "bunny", 5_000, 60, Start::Uniform),
                new("bunny-2k-crowded", "bunny", 2_000, 60, Start::Crowded),
                new("torus-3k-surface", "torus", 3_000, 40, Start::Surface),
            ],
            Extent::Full => vec![
                new("bunny-10k", "bunny", 10_000, 2_000, Start::Uniform),
                new("bunny-15k", "bunny", 15_000, 2_000, Start::Uniform),
                new("bunny-20k", "bunny", 20_000, 2_000, Start::Uniform),
                new("bunny-25k", "bunny", 25_000, 2_000, Start::Uniform),
                new("bunny-30k", "bunny", 30_000, 2_000, Start::Uniform),
                new("bunny-5k-crowded", "bunny", 5_000, 2_000, Start::Crowded),
                new("kitten-15k-surface", "kitten", 15_000, 3_000, Start::Surface),
                new("triceratops-25k", "triceratops", 25_000, 2_000, Start::Uniform),
                new("genus3-13k", "genus3", 13_000, 2_000, Start::Uniform),
            ],
        }
    }

    /// How often the stateless is measured.
    pub fn sampling(self) -> Sampling {
        match self {
            Extent::Short => Sampling { rebuild: 1, relocation: 10 },
            Extent::Full => Sampling { rebuild: 10, relocation: 100 },
        }
    }

    /// Counts and iterations of the scaling table.
    pub fn scaling(self) -> (&'static [usize], usize) {
        match self {
            Extent::Short => (&[2_000, 8_000, 32_000], 10),
            Extent::Full => (&[10_000, 30_000, 100_000, 300_000, 1_000_000], 40),
        }
    }
}

/// The file of a model: in `models/` of the project, else in `folder`.
pub fn find_model(name: &str, folder: &Path) -> Option<PathBuf> {
    let file = format!("{name}.obj");
    [super::project().join("models"), folder.to_owned()].into_iter().map(|f| f.join(&file)).find(|p| p.is_file())
}

/// Those of `all` that `names` name, in their order; all where none is named.
pub fn choose(all: Vec<Experiment>, names: &[String]) -> Outcome<Vec<Experiment>> {
    if let Some(unknown) = names.iter().find(|n| all.iter().all(|e| e.name != n.as_str())) {
        let known: Vec<&str> = all.iter().map(|e| e.name).collect();
        return Err(format!("no experiment {unknown}; there are {}", known.join(", ")).into());
    }
    Ok(all.into_iter().filter(|e| names.is_empty() || names.iter().any(|n| n == e.name)).collect())
}
