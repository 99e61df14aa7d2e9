//! Time of whole iterations, late in a run: `cargo bench --bench iteration -- SURFACE [--seeds N] [--iterations K] [--last L]
//! [--threads T] [--cgal PROGRAM]`; `bench/iteration.sh` compiles the program and runs this with its path.
//!
//! Medians of the last L of K iterations: the clock, and on Linux with one thread the time that the thread was running, which
//! other work on the machine disturbs less. With CGAL's program, its triangulation of the same seeds is timed
//! too.

use std::path::{Path, PathBuf};
use std::time::Instant;

use tetcvt::params::{Params, Target};
use tetcvt::progress::Silent;
use tetcvt::relax::Relaxation;
use tetcvt::surface::features::Features;
use tetcvt::{io, seeds};

mod rival;

use rival::{Rival, cpu_seconds, write_points};

fn main() {
    let (mut surface, mut count, mut iterations, mut last, mut threads) = (None, 20_000, 60, 20, 1);
    let mut cgal: Option<PathBuf> = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--cgal" {
            cgal = arguments.next().map(PathBuf::from);
            continue;
        }
        let mut number = || arguments.next().and_then(|a| a.parse().ok()).expect("a number follows");
        match argument.as_str() {
            "--seeds" => count = number(),
            "--iterations" => iterations = number(),
            "--last" => last = number(),
            "--threads" => threads = number(),
            "--bench" => {}
            file => surface = Some(file.to_string()),
        }
    }
    let file = surface.unwrap_or_else(|| "models/torus.obj".to_string());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    // As the program does: work that starts outside a pool is handed over to it each time.
    pool.install(|| measure(&file, count, [iterations, last], threads, cgal.as_deref()));
}

fn measure(file: &str, count: usize, [iterations, last]: [usize; 2], threads: usize, cgal: Option<&Path>) {
    let surface = io::read_surface(file.as_ref()).expect("a surface");
    let params = Params { target: Target::Count(count), tolerance: 0.0, threads, ..Params::default() };
    let features = Features::find(&surface, params.feature_angle);
    let seeds = seeds::sample(&surface, &features, &params).expect("seeds");
    let mut relaxation = Relaxation::new(&surface, &features, &params, seeds, None).expect("a triangulation");
    let (mut times, mut late) = (Vec::new(), Vec::new());
    for k in 0..iterations {
        let (clock, running) = (Instant::now(), cpu_seconds());
        relaxation.run(1, &mut Silent).expect("an iteration");
        times.push((clock.elapsed().as_secs_f64() * 1e3, (cpu_seconds() - running) * 1e3));
        if cgal.is_some() && k + last >= iterations {
            late.push(relaxation.seeds().positions.clone());
        }
    }
    // Afterwards: each would find the caches full of what the other needs.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut rival = cgal.map(Rival::start);
    let mut build =
        |seeds: &Vec<_>| Some(rival.as_mut()?.ask("time", &write_points(seeds, folder.path()), "-").0 * 1e-6);
    let builds: Vec<f64> = late.iter().filter_map(&mut build).collect();
    let late = &times[iterations.saturating_sub(last)..];
    let (clock, running) = (median(late.iter().map(|t| t.0)), median(late.iter().map(|t| t.1)));
    let (steps, _) = relaxation.into_record();
    let late = &steps[iterations.saturating_sub(last)..];
    let update = median(late.iter().map(|s| s.update_s * 1e3));
    let centroids = median(late.iter().map(|s| s.centroids_s * 1e3));
    println!("{file}: {count} seeds, {threads} threads, {iterations} iterations, medians of the last {last}, ms");
    println!("iteration {clock:.2}, running {running:.2}; update {update:.2}, centroids {centroids:.2}");
    if !builds.is_empty() {
        let build = median(builds.into_iter());
        println!("CGAL's triangulation of the seeds {build:.2}; an iteration is {:.3} of that", clock / build);
    }
    println!("energy {:e}", steps[iterations - 1].energy);
}

fn median(times: impl Iterator<Item = f64>) -> f64 {
    let mut times: Vec<f64> = times.collect();
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}
