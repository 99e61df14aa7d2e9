//! What is run, and how.

use std::path::PathBuf;

use tetcvt::delaunay::Method;

use super::Outcome;
use super::experiments::Extent;

const USAGE: &str = "bench/trajectories.sh [--short|--full] [EXPERIMENT...]
  --short           every part, in about a minute (default)
  --full            the counts and iterations of the paper, for hours
  EXPERIMENT        only these, and no scaling
  --scaling         only the scaling table, unless experiments are named
  --modes A,B       only these methods of ours
  --iterations K    so many in place of each experiment's own
  --threads N       1 unless said otherwise
  --models FOLDER   where models that the project has not are: ../shared/models
  --keep            keep the recorded trajectories, and use those of the same shape that are there
  --report          run nothing: tables and plots of what was run before
  --publish         put tables and plots into bench/README.md and bench/plots
  --cgal PROGRAM    the compiled cgal.cpp, --about TEXT for the head of the tables: trajectories.sh gives both";

/// The choices.
pub struct Options {
    /// Short or full.
    pub extent: Extent,
    /// Experiments by name; all where none is named.
    pub names: Vec<String>,
    /// Whether the scaling table is asked for by name.
    scaling: bool,
    /// Methods to follow by.
    pub methods: Vec<Method>,
    /// Iterations in place of each experiment's own.
    pub iterations: Option<usize>,
    /// Threads for following.
    pub threads: usize,
    /// A further folder of models.
    pub models: PathBuf,
    /// Whether trajectories are kept and used again.
    pub keep: bool,
    /// Whether only tables and plots are made.
    pub report: bool,
    /// Whether these go into the project.
    pub publish: bool,
    /// The CGAL program.
    pub cgal: Option<PathBuf>,
    /// When and where, in words.
    pub about: Option<String>,
}

impl Options {
    /// From the command line.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Outcome<Options> {
        let mut options = Options {
            extent: Extent::Short,
            names: Vec::new(),
            scaling: false,
            methods: Method::ALL.to_vec(),
            iterations: None,
            threads: 1,
            models: super::project().join("../shared/models"),
            keep: false,
            report: false,
            publish: false,
            cgal: None,
            about: None,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| format!("a value must follow {argument}\n{USAGE}"));
            match argument.as_str() {
                "--short" => options.extent = Extent::Short,
                "--full" => options.extent = Extent::Full,
                "--scaling" => options.scaling = true,
                "--modes" => options.methods = methods(&value()?)?,
                "--iterations" => options.iterations = Some(positive(&argument, &value()?)?),
                "--threads" => options.threads = positive(&argument, &value()?)?,
                "--models" => options.models = value()?.into(),
                "--keep" => options.keep = true,
                "--report" => options.report = true,
                "--publish" => options.publish = true,
                "--cgal" => options.cgal = Some(value()?.into()),
                "--about" => options.about = Some(value()?),
                // Cargo says so.
                "--bench" => {}
                other if other.starts_with('-') => return Err(format!("unknown option {other}\n{USAGE}").into()),
                name => options.names.push(name.to_owned()),
            }
        }
        Ok(options)
    }

    /// Whether experiments are run.
    pub fn experiments(&self) -> bool {
        !self.scaling || !self.names.is_empty()
    }

    /// Whether the scaling table is made.
    pub fn scaling(&self) -> bool {
        self.scaling || self.names.is_empty()
    }
}

fn positive(option: &str, text: &str) -> Outcome<usize> {
    let number = text.parse().ok().filter(|&n| n > 0);
    number.ok_or_else(|| format!("{option}: {text} is not a positive number").into())
}

fn methods(text: &str) -> Outcome<Vec<Method>> {
    let method = |name: &str| {
        let found = Method::ALL.into_iter().find(|m| m.name() == name);
        found.ok_or_else(|| {
            let known = Method::ALL.map(Method::name).join(", ");
            format!("--modes: no method {name}; there are {known}").into()
        })
    };
    text.split(',').map(method).collect()
}
