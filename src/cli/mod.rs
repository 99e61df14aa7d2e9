//! The command line: options, progress, messages. The only module that prints.

use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::time::Instant;

use clap::Parser;

use crate::error::Error;
use crate::io::atomic::AtomicFile;
use crate::io::npy::TrajectoryWriter;
use crate::io::{load_surface, vtk};
use crate::mesher::tetrahedralize;
use crate::progress::Observer;
use crate::quality::TetQuality;
use crate::report::{InputReport, MemoryReport, MeshReport, Report, TimeReport};
use crate::tet_mesh::TetMesh;

mod interrupt;
mod options;
mod progress;
mod summary;

use options::{Job, Options, ReportTarget, Verbosity};
use progress::{Watched, Watcher};
use summary::Summary;

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
    match options.into_job().and_then(|job| execute(&job, started)) {
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
fn execute(job: &Job, started: Instant) -> Result<(), Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(job.params.threads).build_global();
    pool.map_err(|e| Error::Parameter { option: "threads", reason: e.to_string() })?;
    let mut watcher = Watcher::new(job)?;
    watcher.spin("reading the surface");
    let reading = Instant::now();
    let soup = load_surface(&job.surface)?;
    let read = reading.elapsed().as_secs_f64();
    let checking = Instant::now();
    let surface = soup.check()?;
    let check = checking.elapsed().as_secs_f64();
    for note in surface.notes() {
        watcher.note(note);
    }

    let result = tetrahedralize(&surface, &job.params, &mut watcher);
    watcher.clear();
    let watched = watcher.finish();
    let mesh = result?;

    let measuring = Instant::now();
    let quality = TetQuality::of(&mesh);
    let mut report = Report {
        tetcvt: env!("CARGO_PKG_VERSION"),
        command: std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect(),
        input: InputReport::of(&surface, job.surface.to_string_lossy().into_owned()),
        mesh: MeshReport::of(&mesh, &quality, &surface),
        time: TimeReport { read, check, ..TimeReport::of(&mesh.times) },
        memory: MemoryReport::default(),
        stopped: mesh.stopped.clone(),
        improved: mesh.improved.clone(),
        notes: watched.notes.clone(),
        iterations: mesh.steps.clone(),
    };
    report.time.measure = measuring.elapsed().as_secs_f64();

    let writing = Instant::now();
    let before = watched.writing;
    let written = write_files(job, &mesh, &quality, watched);
    report.time.write = (before + writing.elapsed()).as_secs_f64();
    report.time.total = started.elapsed().as_secs_f64();
    report.memory = MemoryReport::now();
    if job.verbosity > Verbosity::Quiet {
        say(&Summary(&report).to_string());
    }
    written.and(write_report(job, &report))
}

/// Writes every file that can be written, then tells of the first that could not.
fn write_files(job: &Job, mesh: &TetMesh, quality: &TetQuality, watched: Watched) -> Result<(), Error> {
    let wrote = |path: &Path| {
        if job.verbosity > Verbosity::Quiet {
            say(&format!("wrote      {}", path.display()));
        }
    };
    let mut results = vec![
        vtk::write_mesh(&job.mesh_file, job.mesh_format, mesh, quality).map(|()| wrote(&job.mesh_file)),
        vtk::write_surface(&job.surface_file, job.surface_format, mesh).map(|()| wrote(&job.surface_file)),
    ];
    results.extend(watched.failure.map(Err));
    results.extend(watched.trajectory.map(TrajectoryWriter::finish));
    results.extend(watched.delaunay.map(AtomicFile::commit));
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
