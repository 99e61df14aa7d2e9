//! The 3D experiments of Y. Zhou, F. Sun, W. Wang, J. Wang, C. Zhang, *Fast updating of Delaunay triangulation of moving
//! points by bi-cell filtering*, Computer Graphics Forum 29(7), 2010, doi 10.1111/j.1467-8659.2010.01812.x.
//!
//! 1. Record a trajectory: all positions of all seeds under Lloyd's iteration (`record.rs`).
//! 2. Follow that trajectory in every mode, and by CGAL, alternating (`replay.rs`).
//! 3. Sum up (`summary.rs`), and write tables (`tables.rs`) and plots (`plots.rs`).
//!
//! `bench/trajectories.sh` compiles the CGAL part and runs this; `bench/README.md` says what there is to choose.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../../tests/support.rs"]
mod support;

mod cgal;

mod clock;

mod experiments;

mod frames;

mod options;

mod plots;

mod record;

mod replay;

mod rows;

mod scaling;

mod summary;

mod tables;

use cgal::Cgal;
use clock::Clock;
use experiments::{Experiment, Extent, Start, choose, find_model};
use frames::Frames;
use options::Options;
use record::Run;
use rows::Row;
use summary::Summary;

/// What a part of the benchmark gives, or why it could not.
type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

fn main() -> ExitCode {
    match Options::parse(std::env::args().skip(1)).and_then(|options| run(&options)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("trajectories: {e}");
            ExitCode::FAILURE
        }
    }
}

/// The project's folder.
fn project() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn run(options: &Options) -> Outcome<()> {
    let folder = project().join("target/trajectories").join(options.extent.name());
    fs::create_dir_all(&folder)?;
    let chosen = choose(options.extent.experiments(), &options.names)?;
    let mut failed = Vec::new();
    if !options.report {
        let mut cgal = options.cgal.as_deref().map(Cgal::start).transpose()?;
        if cgal.is_none() {
            eprintln!("without CGAL: its columns stay empty, and speed is compared with our own rebuild");
        }
        // One that fails does not cost the hours of the others.
        for experiment in chosen.iter().filter(|_| options.experiments()) {
            if let Err(e) = run_experiment(experiment, options, cgal.as_mut(), &folder) {
                eprintln!("{}: {e}", experiment.name);
                failed.push(experiment.name);
            }
        }
        if options.scaling()
            && let Err(e) = run_scaling(options, cgal.as_mut(), &folder)
        {
            eprintln!("scaling: {e}");
            failed.push("scaling");
        }
    }
    report(options, &folder)?;
    if failed.is_empty() { Ok(()) } else { Err(format!("failed: {}", failed.join(", ")).into()) }
}

/// When and where, for the head of the tables.
fn about(options: &Options) -> String {
    let threads = match options.threads {
        1 => "one thread".to_owned(),
        n => format!("{n} threads"),
    };
    let clock = Clock::for_threads(options.threads).name();
    let of = options.about.as_ref().map_or(String::new(), |about| format!("{about}; "));
    format!("The {} run. {of}{threads}, {clock}.", options.extent.name())
}

/// Records and replays one experiment; its rows go to a file of its own.
fn run_experiment(experiment: &Experiment, options: &Options, cgal: Option<&mut Cgal>, folder: &Path) -> Outcome<()> {
    let name = experiment.name;
    let Some(model) = find_model(experiment.model, &options.models) else {
        eprintln!("{name}: skipped: {}.obj is not in models/ or {}", experiment.model, options.models.display());
        return Ok(());
    };
    let run = Run {
        model: &model,
        seeds: experiment.seeds,
        iterations: options.iterations.unwrap_or(experiment.iterations),
        first: tetcvt::params::Start::Random,
        start: experiment.start,
    };
    let mut frames = recorded(&run, name, options, folder)?;
    let started = Instant::now();
    let clock = Clock::for_threads(options.threads);
    let sampling = options.extent.sampling();
    let rows = on_threads(options.threads, || replay::replay(&mut frames, &options.methods, cgal, sampling, clock))??;
    eprintln!("{name}: followed in {:.1} s", started.elapsed().as_secs_f64());
    rows::write(&rows, &about(options), &folder.join(format!("{name}.csv")))?;
    discard(frames, options)
}

/// Records and follows ever larger sets.
fn run_scaling(options: &Options, mut cgal: Option<&mut Cgal>, folder: &Path) -> Outcome<()> {
    let (counts, iterations) = options.extent.scaling();
    let model = find_model("bunny", &options.models).ok_or("models/bunny.obj is missing")?;
    let mut sizes = Vec::new();
    for &seeds in counts {
        let name = format!("scaling-{seeds}");
        let iterations = options.iterations.unwrap_or(iterations);
        let run = Run { model: &model, seeds, iterations, first: tetcvt::params::Start::Bcc, start: Start::Uniform };
        let mut frames = recorded(&run, &name, options, folder)?;
        let clock = Clock::for_threads(options.threads);
        let cgal = cgal.as_deref_mut();
        sizes.push(on_threads(options.threads, || scaling::measure(&mut frames, cgal, clock))??);
        discard(frames, options)?;
    }
    scaling::write(&sizes, &about(options), &folder.join("scaling.csv"))
}

/// The trajectory of a run, recorded unless one of the same shape is there from before (`--keep`).
fn recorded(run: &Run, name: &str, options: &Options, folder: &Path) -> Outcome<Frames> {
    let file = folder.join(format!("{name}.npy"));
    if options.keep && file.is_file() {
        let frames = Frames::open(&file)?;
        if (frames.count, frames.seeds) == (run.iterations + 1, run.seeds) {
            eprintln!("{name}: recorded before");
            return Ok(frames);
        }
    }
    let started = Instant::now();
    let update = 100.0 * record::record(run, &file)?;
    let seconds = started.elapsed().as_secs_f64();
    eprintln!("{name}: recorded in {seconds:.1} s; the update is {update:.1} % of an iteration");
    Frames::open(&file)
}

fn discard(frames: Frames, options: &Options) -> Outcome<()> {
    let file = frames.path().to_owned();
    drop(frames);
    if options.keep { Ok(()) } else { Ok(fs::remove_file(file)?) }
}

/// Runs `work` on a thread of a pool of so many.
fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Outcome<T> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(work))
}

/// Tables and plots of everything in the folder, of this run or earlier ones; they are published if that was asked for.
fn report(options: &Options, folder: &Path) -> Outcome<()> {
    let plots = folder.join("plots");
    fs::create_dir_all(&plots)?;
    let (mut summaries, mut origins) = (Vec::new(), Vec::new());
    for experiment in options.extent.experiments() {
        let file = folder.join(format!("{}.csv", experiment.name));
        if file.is_file() {
            let (about, rows): (String, Vec<Row>) = rows::read(&file)?;
            origins.push((about, experiment.name));
            if let Some(summary) = Summary::new(experiment.name, experiment.seeds, &rows) {
                plots::draw(&summary, &rows, &plots.join(format!("{}.svg", experiment.name)))?;
                summaries.push(summary);
            }
        }
    }
    let scaling = folder.join("scaling.csv");
    let mut sizes = Vec::new();
    if scaling.is_file() {
        let (about, rows) = scaling::read(&scaling)?;
        origins.push((about, "scaling"));
        sizes = rows;
    }
    if origins.is_empty() {
        return Err(format!("nothing was measured yet in {}", folder.display()).into());
    }
    let text = tables::markdown(&summaries, &sizes, &origins)?;
    tables::csv(&summaries, &folder.join("summary.csv"))?;
    fs::write(folder.join("tables.md"), &text)?;
    println!("{text}");
    if options.publish {
        publish(&summaries, &text, folder)?;
    }
    eprintln!("CSV, tables and plots are in {}", folder.display());
    Ok(())
}

/// Brings the tables into the README, and the plots and what they show beside it.
fn publish(summaries: &[Summary], text: &str, folder: &Path) -> Outcome<()> {
    let bench = project().join("bench");
    let (plots, results) = (bench.join("plots"), bench.join("results"));
    fs::create_dir_all(&plots)?;
    fs::create_dir_all(&results)?;
    // Of the run that was published before, nothing stays.
    for experiment in [Extent::Short, Extent::Full].into_iter().flat_map(Extent::experiments) {
        let file = plots.join(format!("{}.svg", experiment.name));
        if file.is_file() {
            fs::remove_file(file)?;
        }
    }
    let mut links = Vec::new();
    for summary in summaries {
        let file = format!("{}.svg", summary.name);
        fs::copy(folder.join("plots").join(&file), plots.join(&file))?;
        links.push(format!("plots/{file}"));
    }
    fs::copy(folder.join("summary.csv"), results.join("trajectories.csv"))?;
    let scaling = folder.join("scaling.csv");
    if scaling.is_file() {
        fs::copy(scaling, results.join("scaling.csv"))?;
    }
    tables::publish(&bench.join("README.md"), text, &links)
}
