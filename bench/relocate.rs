//! Time to follow moving points, against building anew, alternating in one run on the same points.
//!
//! `cargo bench --bench relocate [-- --points N --iterations K]`. Points move as in Lloyd's
//! iteration, nearly: to the mean of the tets around them by volume; those of the hull stay.

use std::time::Instant;

use glam::DVec3;
use tetcvt::delaunay::{Delaunay, Relocation};

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../tests/support.rs"]
mod support;

use support::*;

fn main() {
    let (mut points, mut iterations) = (20_000, 100);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|a| a.parse().ok()).expect("a number follows");
        match argument.as_str() {
            "--points" => points = number(),
            "--iterations" => iterations = number(),
            "--bench" => {}
            other => panic!("unknown option {other}"),
        }
    }
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    let mut lattice = jittered_lattice(points, 0.1, 2);
    lattice.truncate(points);
    run("lattice, 10 % jitter", lattice, iterations);
    run("random", uniform(points, 1), iterations);
}

/// For each vertex the centroid of its star; on the hull, its place.
fn targets(delaunay: &Delaunay) -> Vec<DVec3> {
    let points = delaunay.points();
    let mut sums = vec![(DVec3::ZERO, 0.0); points.len()];
    let mut fixed = vec![false; points.len()];
    for tet in delaunay.vertices() {
        if tet[3] == u32::MAX {
            tet[..3].iter().for_each(|&v| fixed[v as usize] = true);
            continue;
        }
        let [a, b, c, d] = tet.map(|v| points[v as usize]);
        let volume = tetcvt::geometry::tetrahedron::volume(a, b, c, d);
        let center = (a + b + c + d) * 0.25;
        for v in tet {
            let s = &mut sums[*v as usize];
            s.0 += center * volume;
            s.1 += volume;
        }
    }
    (0..points.len()).map(|i| if fixed[i] { points[i] } else { sums[i].0 / sums[i].1 }).collect()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}

/// One iteration.
struct Entry {
    moved_ms: f64,
    built_ms: f64,
    /// Median step over the spacing.
    step: f64,
    report: Relocation,
}

fn run(name: &str, points: Vec<DVec3>, iterations: usize) {
    let mut delaunay = Delaunay::build(&points).expect("these points have tets");
    let mut log: Vec<Entry> = Vec::new();
    let h = (points.len() as f64).cbrt().recip();
    for _ in 0..iterations {
        let to = targets(&delaunay);
        let mut steps: Vec<f64> = to.iter().zip(delaunay.points()).map(|(a, b)| a.distance(*b) / h).collect();
        steps.sort_unstable_by(f64::total_cmp);
        let clock = Instant::now();
        let report = delaunay.relocate(&to).expect("these points have tets");
        let moved_ms = clock.elapsed().as_secs_f64() * 1e3;
        let clock = Instant::now();
        let built = Delaunay::build(&to).expect("these points have tets");
        let built_ms = clock.elapsed().as_secs_f64() * 1e3;
        log.push(Entry { moved_ms, built_ms, step: steps[steps.len() / 2], report });
        assert_eq!(delaunay.tets().count(), built.tets().count());
    }
    println!("{name}: {} points", points.len());
    println!(
        "| iterations | step / h | relocate ms | build ms | ratio | filter | predicate | flips | repair | renewal | suspects | reversed | held | flips | rebuilt |"
    );
    for range in [0..1, 1..2, 2..5, 5..20, 20..100, 100..500, 500..2000, 0..2000] {
        let Some(part) = log.get(range.start..range.end.min(log.len())).filter(|p| !p.is_empty()) else { continue };
        let of = |f: &dyn Fn(&Entry) -> f64| median(part.iter().map(f).collect());
        let mean = |f: &dyn Fn(&Relocation) -> f64| part.iter().map(|l| f(&l.report)).sum::<f64>() / part.len() as f64;
        let (moved, built) = (of(&|l| l.moved_ms), of(&|l| l.built_ms));
        let phase = |f: &dyn Fn(&Relocation) -> f64| of(&|l| f(&l.report) * 1e3);
        println!(
            "| {range:?} | {:.4} | {moved:.2} | {built:.1} | {:.1} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.0} | {:.1} | {:.1} | {:.0} | {} |",
            of(&|l| l.step),
            built / moved,
            phase(&|r| r.seconds.filter),
            phase(&|r| r.seconds.predicate),
            phase(&|r| r.seconds.flips),
            phase(&|r| r.seconds.repair),
            phase(&|r| r.seconds.renewal),
            mean(&|r| r.suspects as f64),
            mean(&|r| r.reversed as f64),
            mean(&|r| r.held_back as f64),
            mean(&|r| r.flips as f64),
            part.iter().filter(|l| l.report.rebuilt).count()
        );
    }
}
