//! The CVT energy against evaluations and seconds, for every start and every optimiser, as CSV.
//!
//! `cargo bench --bench energy -- SURFACE [--seeds N] [--iterations K] [--boundary free|conform] > energy.csv`. One thread; an
//! evaluation is one update of the triangulation with one clipping of all cells. A row tells what an iteration began with.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};
use tetcvt::params::{Boundary, Optimizer, Start, Target};
use tetcvt::progress::{Move, Silent};
use tetcvt::{Params, io, tetrahedralize};

#[derive(Parser)]
struct Options {
    surface: PathBuf,
    #[arg(long, default_value_t = 5000)]
    seeds: usize,
    #[arg(long, default_value_t = 100)]
    iterations: usize,
    #[arg(long, default_value = "free")]
    boundary: Boundary,
    /// Given by cargo.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let Options { surface, seeds, iterations, boundary, .. } = Options::parse();
    let surface = io::read_surface(&surface).expect("a surface");
    println!("boundary,start,optimizer,evaluations,seconds,energy,move");
    for &start in Start::value_variants() {
        for &optimizer in Optimizer::value_variants() {
            let params = Params {
                target: Target::Count(seeds),
                boundary,
                start,
                optimizer,
                iterations,
                tolerance: 0.0,
                threads: 1,
                ..Params::default()
            };
            let mesh = tetrahedralize(&surface, &params, &mut Silent).expect("a mesh");
            let (mut evaluations, mut seconds) = (0, 0.0);
            for step in mesh.steps.iter().take_while(|s| s.kind != Move::Odt) {
                let names = [name(&boundary), name(&start), name(&optimizer)].join(",");
                println!("{names},{evaluations},{seconds:.4},{:.12e},{:?}", step.energy, step.kind);
                evaluations += step.evaluations;
                seconds += step.update_s + step.centroids_s;
            }
        }
    }
}

/// As on the command line.
fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned())
}
