//! The command line: options, progress, messages. The only module that prints.

use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::time::Instant;

use clap::Parser;
use indicatif::ProgressBar;

use crate::error::Error;
use crate::io::atomic::AtomicFile;
use crate::io::npy::TrajectoryWriter;
use crate::io::{self as files, MeshData, defects, load_surface};
use crate::mesher::{tetrahedralize, tetrahedralize_from};
use crate::progress::Observer;
use crate::quality::TetQuality;
use crate::report::{InputReport, MemoryReport, MeshReport, Report, TimeReport};
use crate::second_order::SecondOrder;
use crate::surface::Surface;
use crate::surface::defects::Marks;
use crate::surface::features::Features;
use crate::tet_mesh::TetMesh;

mod interrupt;
mod memory;
mod options;
mod progress;
mod summary;

use interrupt::Interrupt;
use options::{Job, Options, ReportTarget, Verbosity};
use progress::{Watched, Watcher};
use summary::{Summary, breakdown};

/// Runs the program; returns its exit status.
pub fn run() -> u8 {
    let started = Instant::now();
    let options = match Options::try_parse() {
        Ok(options) => options,
        Err(message) => {
            // `--help` into a pipe that is closed early is no failure.
            let _ = message.print();
            return if message.use_stderr() { 2 } else { 0 };
        }
    };
    // Before the first file is tried.
    let bar = ProgressBar::hidden();
    let interrupt = Interrupt::listen(&bar);
    match options.into_job().and_then(|job| execute(&job, Watcher::new(&job, bar, interrupt)?, started)) {
        Ok(()) => 0,
        Err(error) => {
            say(&format!("error: {error}"));
            error.exit_status()
        }
    }
}

/// A line on standard error. Nobody may be listening there: a closed pipe is no reason to end a run.
fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Reads, meshes, writes, reports.
fn execute(job: &Job, mut watcher: Watcher, started: Instant) -> Result<(), Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(job.params.threads).build_global();
    pool.map_err(|e| Error::Parameter { option: "threads", reason: e.to_string() })?;
    watcher.spin("reading the surface");
    let reading = Instant::now();
    let soup = load_surface(&job.surface)?;
    let read = reading.elapsed().as_secs_f64();
    let checking = Instant::now();
    let mut marks = Marks::default();
    let surface = soup.check_as(job.treatment, &mut marks).inspect_err(|_| {
        marks.notes.iter().for_each(|note| watcher.note(note));
        watcher.clear();
        show_defects(job, &marks);
    })?;
    for note in surface.notes() {
        watcher.note(note);
    }
    let input = InputReport::of(&surface, job.surface.to_string_lossy().into_owned());
    let surface = if job.lines.is_empty() { surface } else { surface.with_features(&job.lines)? };
    let check = checking.elapsed().as_secs_f64();

    if let Some(warning) =
        memory::free().and_then(|free| memory::warning(memory::estimate(&job.params, &surface), free))
    {
        watcher.note(&warning);
    }

    let result = match &job.initial {
        None => tetrahedralize(&surface, &job.params, &mut watcher),
        Some(initial) => tetrahedralize_from(&surface, initial, &job.params, &mut watcher),
    };
    watcher.clear();
    let mesh = result?;
    let second_order = job.second_order.then(|| second_order(job, &mesh, &surface, &mut watcher));
    let watched = watcher.finish();

    let measuring = Instant::now();
    let quality = TetQuality::of(&mesh);
    let mut report = Report {
        tetcvt: env!("CARGO_PKG_VERSION"),
        command: std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect(),
        input,
        mesh: MeshReport::of(&mesh, &quality, &surface),
        time: TimeReport { read, check, ..TimeReport::of(&mesh.times) },
        update: mesh.times.update_parts,
        memory: MemoryReport::default(),
        stopped: mesh.stopped.clone(),
        improved: mesh.improved.clone(),
        notes: watched.notes.clone(),
        iterations: mesh.steps.clone(),
    };
    report.time.measure = measuring.elapsed().as_secs_f64();

    let writing = Instant::now();
    let before = watched.writing;
    let data = MeshData { mesh: &mesh, quality: &quality, second_order: second_order.as_ref(), encoding: job.encoding };
    let written = write_files(job, &data, watched);
    report.time.write = (before + writing.elapsed()).as_secs_f64();
    report.time.total = started.elapsed().as_secs_f64();
    report.memory = MemoryReport::now();
    if job.verbosity > Verbosity::Quiet {
        say(&Summary(&report).to_string());
    }
    if job.verbosity >= Verbosity::Verbose {
        say(&breakdown(&report.update));
    }
    written.and(write_report(job, &report))
}

/// The nodes in the middle of edges.
fn second_order(job: &Job, mesh: &TetMesh, surface: &Surface, watcher: &mut Watcher) -> SecondOrder {
    let nodes = SecondOrder::of(mesh, surface, &Features::find(surface, job.params.feature_angle));
    if nodes.held_back > 0 {
        watcher.note(&format!(
            "{} of the nodes on boundary edges are short of the surface: a tet would fold",
            nodes.held_back
        ));
    }
    nodes
}

/// Writes the file with the places of defects, if there are any to show. The refusal is what matters: that it cannot be
/// written as well is only said.
fn show_defects(job: &Job, marks: &Marks) {
    if marks.list.is_empty() {
        return;
    }
    match defects::write(&job.defects_file, marks) {
        Ok(()) if job.verbosity > Verbosity::Quiet => say(&format!("wrote      {}", job.defects_file.display())),
        Ok(()) => {}
        Err(error) => say(&format!("note: {error}")),
    }
}

/// Writes every file that can be written, then tells of the first that could not.
fn write_files(job: &Job, data: &MeshData, watched: Watched) -> Result<(), Error> {
    let wrote = |path: &Path| {
        if job.verbosity > Verbosity::Quiet {
            say(&format!("wrote      {}", path.display()));
        }
    };
    let mut results = vec![
        files::write_mesh(&job.mesh_file, job.mesh_format, data)
            .map(|()| job.mesh_files().iter().for_each(|path| wrote(path))),
        files::write_surface(&job.surface_file, job.surface_format, data.mesh, job.encoding)
            .map(|()| wrote(&job.surface_file)),
    ];
    results.extend(watched.failure.map(Err));
    results.extend(watched.trajectory.map(TrajectoryWriter::finish));
    results.extend([watched.delaunay, watched.voronoi].into_iter().flatten().map(AtomicFile::commit));
    results.into_iter().collect()
}

fn write_report(job: &Job, report: &Report) -> Result<(), Error> {
    match &job.report {
        Some(ReportTarget::StandardOutput) => print_json(report),
        Some(ReportTarget::File(path)) => AtomicFile::write_with(path, |file| write_json(file, report)),
        None => Ok(()),
    }
}

fn write_json(out: &mut impl Write, report: &Report) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, report)?;
    writeln!(out)
}

/// The report on standard output; a reader that has gone away has seen enough.
fn print_json(report: &Report) -> Result<(), Error> {
    let mut bytes = Vec::new();
    let mut out = io::stdout().lock();
    let written = write_json(&mut bytes, report).and_then(|()| out.write_all(&bytes)).and_then(|()| out.flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::Write { path: Path::new("standard output").to_owned(), reason: error.to_string() })
        }
        _ => Ok(()),
    }
}
