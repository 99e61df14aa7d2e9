//! The observer of a run: progress bar, lines of `-v`, and the files written while it goes.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use glam::DVec3;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::interrupt::Interrupt;
use super::options::{Job, Verbosity};
use super::say;
use crate::clipped_voronoi::{Clipper, Polyhedra};
use crate::delaunay::Delaunay;
use crate::error::Error;
use crate::geometry::frame::Frame;
use crate::io::atomic::AtomicFile;
use crate::io::npy::TrajectoryWriter;
use crate::io::vtk;
use crate::progress::{Flow, Observer, Stage, Step};
use crate::surface::Surface;

/// What the program shows and writes while the library works.
pub(super) struct Watcher {
    bar: ProgressBar,
    verbosity: Verbosity,
    interrupt: Interrupt,
    trajectory: Option<TrajectoryWriter>,
    delaunay_path: Option<PathBuf>,
    delaunay: Option<AtomicFile>,
    voronoi_path: Option<PathBuf>,
    voronoi: Option<AtomicFile>,
    seeds: usize,
    iteration: usize,
    energy: Option<f64>,
    notes: Vec<String>,
    failure: Option<Error>,
    writing: Duration,
}

/// What is left of a watcher when the library is done.
pub(super) struct Watched {
    /// Files complete but for their names.
    pub trajectory: Option<TrajectoryWriter>,
    pub delaunay: Option<AtomicFile>,
    pub voronoi: Option<AtomicFile>,
    /// What the library said.
    pub notes: Vec<String>,
    /// The first file that could not be written.
    pub failure: Option<Error>,
    /// Time spent on files.
    pub writing: Duration,
}

impl Watcher {
    /// Shows progress on `bar`, and asks `interrupt` whether to go on.
    pub(super) fn new(job: &Job, bar: ProgressBar, interrupt: Interrupt) -> Result<Watcher, Error> {
        let shown = job.verbosity > Verbosity::Quiet && std::io::stderr().is_terminal();
        let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        bar.set_draw_target(target);
        Ok(Watcher {
            interrupt,
            bar,
            verbosity: job.verbosity,
            trajectory: job.trajectory.as_deref().map(TrajectoryWriter::create).transpose()?,
            delaunay_path: job.delaunay.clone(),
            delaunay: None,
            voronoi_path: job.voronoi.clone(),
            voronoi: None,
            seeds: 0,
            iteration: 0,
            energy: None,
            notes: Vec::new(),
            failure: None,
            writing: Duration::ZERO,
        })
    }

    /// A stage of unknown length begins.
    pub(super) fn spin(&self, what: &'static str) {
        self.bar.set_style(style("{spinner} {msg} {elapsed}"));
        self.bar.set_message(what);
        self.bar.enable_steady_tick(Duration::from_millis(100));
    }

    pub(super) fn finish(self) -> Watched {
        let Watcher { trajectory, delaunay, voronoi, notes, failure, writing, .. } = self;
        Watched { trajectory, delaunay, voronoi, notes, failure, writing }
    }

    /// Ends the bar, so that a summary can follow.
    pub(super) fn clear(&self) {
        self.bar.finish_and_clear();
    }

    /// Tells the user something, above the bar.
    fn tell(&self, least: Verbosity, text: &str) {
        if self.verbosity >= least {
            self.bar.suspend(|| say(text));
        }
    }

    /// Writes by `write` what a run can go on without: the failure is told at the end, when the mesh is safe.
    fn attempt<T>(&mut self, write: impl FnOnce(&mut Watcher) -> Result<T, Error>) -> Option<T> {
        let started = Instant::now();
        let result = write(self);
        self.writing += started.elapsed();
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.failure.get_or_insert(error);
                None
            }
        }
    }

    fn show_step(&mut self, step: &Step) {
        self.iteration += 1;
        let fall = match self.energy.replace(step.energy) {
            Some(before) if before > 0.0 => format!(" ({:+.2e})", step.energy / before - 1.0),
            _ => String::new(),
        };
        self.bar.set_message(format!("energy {:.6e}{fall}", step.energy));
        self.bar.set_position(self.iteration as u64);
        let line = format!(
            "iteration {:4}: energy {:.9e}{fall}, longest move {:.3e}, {} tets, update {:.3} s, centroids {:.3} s",
            self.iteration, step.energy, step.max_move, step.tets, step.update_s, step.centroids_s
        );
        self.tell(Verbosity::Verbose, &line);
    }
}

impl Observer for Watcher {
    fn stage(&mut self, stage: Stage) {
        match stage {
            Stage::Seeds => self.spin("placing seeds"),
            Stage::Relax { iterations } => {
                self.bar.disable_steady_tick();
                self.bar.set_style(style("{bar:30} {pos}/{len} {msg} {eta}"));
                self.bar.set_message("");
                self.bar.set_length(iterations as u64);
                self.bar.set_position(0);
            }
            Stage::Extract => self.spin("extracting the mesh"),
            Stage::Improve => self.spin("improving the mesh"),
        }
    }

    fn note(&mut self, text: &str) {
        self.tell(Verbosity::Normal, &format!("note: {text}"));
        self.notes.push(text.to_owned());
    }

    fn seeds(&mut self, step: Option<&Step>, positions: &[DVec3], frame: &Frame) -> Flow {
        self.interrupt.keep();
        self.seeds = positions.len();
        if let Some(mut trajectory) = self.trajectory.take() {
            self.trajectory = self.attempt(|_| {
                trajectory.push(positions.iter().map(|&p| frame.to_model(p)))?;
                Ok(trajectory)
            });
        }
        if let Some(step) = step {
            self.show_step(step);
        }
        if self.interrupt.came() { Flow::Stop } else { Flow::Continue }
    }

    fn improving(&mut self, below: usize) -> Flow {
        self.tell(Verbosity::Verbose, &format!("improvement: {below} tets below the floor"));
        if self.interrupt.came() { Flow::Stop } else { Flow::Continue }
    }

    fn triangulation(&mut self, delaunay: &Delaunay, surface: &Surface) {
        let frame = surface.frame();
        if let Some(path) = self.delaunay_path.take() {
            self.delaunay = self.attempt(|watcher| vtk::write_delaunay(&path, delaunay, frame, watcher.seeds));
        }
        if let Some(path) = self.voronoi_path.take() {
            self.voronoi = self.attempt(|watcher| {
                let clipped = Clipper::new(surface).clip_first(delaunay, watcher.seeds);
                let cells = Polyhedra::of(delaunay, surface, &clipped, watcher.seeds);
                let volumes: Vec<f64> = clipped.cells.iter().map(|c| c.volume).collect();
                vtk::write_voronoi(&path, &cells, &volumes, frame)
            });
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("templates of the progress bar are constant: this is a bug in tetcvt")
}
