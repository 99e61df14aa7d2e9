//! The CVT energy against evaluations and seconds, for every start and every optimiser, and how soon each reaches what
//! Lloyd's iteration reaches in the end from a random start.
//!
//! `cargo bench --bench energy -- SURFACE [--seeds N] [--iterations K] [--reference K] [--boundary free|conform] [--publish]`. One
//! thread; an evaluation is one update of the triangulation with one clipping of all cells. CSV and plot go to
//! `target/energy`, with `--publish` to `bench/results` and `bench/plots` too; the table is printed.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::{Parser, ValueEnum};
use plotters::coord::Shift;
use plotters::prelude::*;
use tetcvt::params::{Boundary, Optimizer, Start, Target};
use tetcvt::progress::{Move, Silent};
use tetcvt::surface::Surface;
use tetcvt::{Params, io, tetrahedralize};

#[derive(Parser)]
struct Options {
    surface: PathBuf,
    #[arg(long, default_value_t = 5000)]
    seeds: usize,
    #[arg(long, default_value_t = 250)]
    iterations: usize,
    /// Iterations of Lloyd from a random start, whose last energy all are held to.
    #[arg(long, default_value_t = 2000)]
    reference: usize,
    #[arg(long, default_value = "free")]
    boundary: Boundary,
    #[arg(long)]
    publish: bool,
    /// Given by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

type Outcome<T> = Result<T, Box<dyn Error>>;

/// The energies of a run, each with the evaluations and the seconds before it.
struct Run {
    start: Start,
    optimizer: Optimizer,
    points: Vec<(usize, f64, f64)>,
}

fn main() -> Outcome<()> {
    let options = Options::parse();
    let surface = io::read_surface(&options.surface)?;
    let reference = run(&surface, &options, Start::Random, Optimizer::Lloyd, options.reference)?;
    let goal = reference.points.last().map_or(0.0, |p| p.2);
    let mut runs = Vec::new();
    for &start in Start::value_variants() {
        for &optimizer in Optimizer::value_variants() {
            runs.push(run(&surface, &options, start, optimizer, options.iterations)?);
        }
    }
    let model = options.surface.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = format!("energy-{model}-{}-{}", options.seeds, word(&options.boundary));
    let title = format!("{model}, {} seeds, {}", options.seeds, word(&options.boundary));
    for (folder, suffix) in folders(options.publish) {
        fs::create_dir_all(&folder)?;
        let file = folder.join(format!("{name}.{suffix}"));
        if suffix == "csv" { fs::write(file, csv(&runs))? } else { draw(&title, &runs, goal, &file)? }
    }
    println!("{title}: energy {goal:.6e} after {} iterations of Lloyd from a random start\n", options.reference);
    print!("{}", table(&runs, goal));
    Ok(())
}

/// Where files of which kind go.
fn folders(publish: bool) -> Vec<(PathBuf, &'static str)> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![(project.join("target/energy"), "csv"), (project.join("target/energy"), "svg")];
    if publish {
        folders.extend([(project.join("bench/results"), "csv"), (project.join("bench/plots"), "svg")]);
    }
    folders
}

fn run(surface: &Surface, options: &Options, start: Start, optimizer: Optimizer, iterations: usize) -> Outcome<Run> {
    let params = Params {
        target: Target::Count(options.seeds),
        boundary: options.boundary,
        start,
        optimizer,
        iterations,
        tolerance: 0.0,
        threads: 1,
        improve: false,
        ..Params::default()
    };
    let mesh = tetrahedralize(surface, &params, &mut Silent)?;
    let (mut evaluations, mut seconds) = (0, 0.0);
    let mut points = Vec::new();
    // The steps against slivers raise the energy, and are not what is compared.
    for step in mesh.steps.iter().take_while(|s| s.kind != Move::Odt) {
        points.push((evaluations, seconds, step.energy));
        evaluations += step.evaluations;
        seconds += step.update_s + step.centroids_s;
    }
    Ok(Run { start, optimizer, points })
}

/// As on the command line.
fn word(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned())
}

fn csv(runs: &[Run]) -> String {
    let mut text = "start,optimizer,evaluations,seconds,energy\n".to_owned();
    for run in runs {
        let names = format!("{},{}", word(&run.start), word(&run.optimizer));
        for (evaluations, seconds, energy) in &run.points {
            writeln!(text, "{names},{evaluations},{seconds:.4},{energy:.12e}")
                .expect("text can be written to a string");
        }
    }
    text
}

/// Evaluations until each run has the energy `goal`.
fn table(runs: &[Run], goal: f64) -> String {
    let mut text =
        "| start | optimizer | evaluations to it | seconds | lowest / it |\n|---|---|---|---|---|\n".to_owned();
    for run in runs {
        let reached = run.points.iter().find(|p| p.2 <= goal);
        let (evaluations, seconds) = reached.map_or(("-".to_owned(), "-".to_owned()), |(evaluations, seconds, _)| {
            (evaluations.to_string(), format!("{seconds:.1}"))
        });
        let lowest = lowest(std::slice::from_ref(run)) / goal;
        let names = format!("{} | {}", word(&run.start), word(&run.optimizer));
        writeln!(text, "| {names} | {evaluations} | {seconds} | {lowest:.5} |")
            .expect("text can be written to a string");
    }
    text
}

fn lowest(runs: &[Run]) -> f64 {
    runs.iter().flat_map(|r| &r.points).map(|p| p.2).fold(f64::INFINITY, f64::min)
}

/// What the energy is above the lowest of all, over evaluations and over seconds.
fn draw(title: &str, runs: &[Run], goal: f64, file: &Path) -> Outcome<()> {
    let root = SVGBackend::new(file, (1300, 560)).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.titled(&format!("{title}: energy above the lowest reached, relative"), ("sans-serif", 22))?;
    let panels = root.split_evenly((1, 2));
    panel(&panels[0], "evaluations", runs, goal, |p| p.0 as f64)?;
    panel(&panels[1], "seconds", runs, goal, |p| p.1)?;
    root.present()?;
    Ok(())
}

fn panel(
    area: &DrawingArea<SVGBackend, Shift>,
    axis: &str,
    runs: &[Run],
    goal: f64,
    x: impl Fn(&(usize, f64, f64)) -> f64,
) -> Outcome<()> {
    /// Nothing is shown below this.
    const LEAST: f64 = 1e-5;
    let lowest = lowest(runs) * (1.0 - LEAST);
    let points = || runs.iter().flat_map(|r| &r.points);
    let positive = |r: Range<f64>| if r.start < r.end { r } else { 1e-3..1.0 };
    let first = points().map(&x).filter(|&x| x > 0.0).fold(f64::INFINITY, f64::min);
    let last = points().map(&x).fold(0.0, f64::max);
    let highest = points().map(|p| p.2 / lowest - 1.0).fold(0.0, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .set_label_area_size(LabelAreaPosition::Left, 70)
        .set_label_area_size(LabelAreaPosition::Bottom, 40)
        .build_cartesian_2d(positive(first..last).log_scale(), positive(LEAST..2.0 * highest).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(axis)
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.15))
        .label_style(("sans-serif", 14))
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .draw()?;
    for run in runs {
        let (color, width) = style(run);
        let line = run.points.iter().map(|p| (x(p), p.2 / lowest - 1.0)).filter(|p| p.0 > 0.0);
        chart
            .draw_series(LineSeries::new(line, color.stroke_width(width)))?
            .label(format!("{} {}", word(&run.start), word(&run.optimizer)))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(width)));
    }
    let level = goal / lowest - 1.0;
    chart
        .draw_series(LineSeries::new([(first, level), (last, level)], BLACK.mix(0.5)))?
        .label("Lloyd, in the end")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK.mix(0.5)));
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 14))
        .draw()?;
    Ok(())
}

/// The colour tells the optimiser, the width the start.
fn style(run: &Run) -> (RGBColor, u32) {
    let color = match run.optimizer {
        Optimizer::Lbfgs => RGBColor(0, 90, 181),
        Optimizer::Nesterov => RGBColor(26, 133, 80),
        Optimizer::Lloyd => RGBColor(220, 110, 0),
    };
    let width = match run.start {
        Start::Bcc => 3,
        Start::Blue => 2,
        Start::Random => 1,
    };
    (color, width)
}
