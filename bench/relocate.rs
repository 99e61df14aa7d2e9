//! Time to follow moving points, with certificates and without, against building anew: alternating in one run on the
//! same points.
//!
//! `cargo bench --bench relocate [-- --points N --iterations K]`: points move as in Lloyd's
//! iteration, nearly: to the mean of the tets around them by volume; those of the hull stay.
//!
//! `cargo bench --bench relocate -- --trajectory FILE.npy [--from I] [--iterations K] [--compare]`: points move as written by
//! `tetcvt --trajectory`, from row I on; `--compare` demands that the tets be those of a new triangulation each time.
//! `--build N` builds anew every Nth time only. `--threads N`: one if not given.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::time::Instant;

use glam::DVec3;
use tetcvt::delaunay::{Delaunay, Relocation};

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../tests/support.rs"]
mod support;

use support::*;

/// What is asked for.
struct Options {
    points: usize,
    iterations: usize,
    trajectory: Option<String>,
    from: usize,
    build: usize,
    compare: bool,
}

fn main() {
    let mut options = Options { points: 20_000, iterations: 100, trajectory: None, from: 0, build: 1, compare: false };
    let mut threads = 1;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut text = || arguments.next().expect("a value follows");
        let number = |text: String| text.parse().expect("a number follows");
        match argument.as_str() {
            "--points" => options.points = number(text()),
            "--iterations" => options.iterations = number(text()),
            "--trajectory" => options.trajectory = Some(text()),
            "--from" => options.from = number(text()),
            "--build" => options.build = number(text()).max(1),
            "--threads" => threads = number(text()),
            "--compare" => options.compare = true,
            "--bench" => {}
            other => panic!("unknown option {other}"),
        }
    }
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("the first pool");
    if let Some(file) = &options.trajectory {
        let mut rows = Trajectory::open(file, options.from);
        run(file, rows.next().expect("a first row"), &mut |_| rows.next(), &options);
        return;
    }
    let mut lattice = jittered_lattice(options.points, 0.1, 2);
    lattice.truncate(options.points);
    run("lattice, 10 % jitter", lattice, &mut |d| Some(targets(d)), &options);
    run("random", uniform(options.points, 1), &mut |d| Some(targets(d)), &options);
}

/// Rows of a file that `tetcvt --trajectory` wrote.
struct Trajectory {
    file: BufReader<File>,
    points: usize,
}

impl Trajectory {
    fn open(path: &str, from: usize) -> Trajectory {
        let mut file = BufReader::new(File::open(path).expect("the trajectory"));
        let mut start = [0; 10];
        file.read_exact(&mut start).expect("a header");
        let length = u16::from_le_bytes([start[8], start[9]]);
        let mut header = vec![0; length.into()];
        file.read_exact(&mut header).expect("a header");
        let header = String::from_utf8(header).expect("a header of letters");
        let shape = header.split_once("'shape': (").expect("a shape").1;
        let points: usize = shape.split(", ").nth(1).and_then(|n| n.parse().ok()).expect("rows, points, 3");
        file.seek(SeekFrom::Current((from * points * 24) as i64)).expect("so many rows");
        Trajectory { file, points }
    }

    fn next(&mut self) -> Option<Vec<DVec3>> {
        let mut bytes = vec![0; self.points * 24];
        self.file.read_exact(&mut bytes).ok()?;
        let numbers: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        Some(numbers.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(*p)).collect())
    }
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

fn median(times: impl Iterator<Item = f64>) -> f64 {
    let mut times: Vec<f64> = times.collect();
    times.sort_unstable_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// One iteration.
struct Entry {
    moved_ms: f64,
    checked_ms: f64,
    built_ms: Option<f64>,
    /// Median step over the spacing.
    step: f64,
    report: Relocation,
}

/// Seconds that this thread has spent computing: on a machine that others use as well, the clock tells less.
#[cfg(unix)]
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Where the system does not say, the clock.
#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

/// What a function returns, and its milliseconds: of the one thread, or of the clock if there are several.
fn timed<T>(f: impl FnOnce() -> T) -> (T, f64) {
    let (clock, start) = (Instant::now(), cpu_seconds());
    let result = f();
    let seconds = if rayon::current_num_threads() == 1 { cpu_seconds() - start } else { clock.elapsed().as_secs_f64() };
    (result, seconds * 1e3)
}

fn run(name: &str, points: Vec<DVec3>, next: &mut dyn FnMut(&Delaunay) -> Option<Vec<DVec3>>, options: &Options) {
    let mut delaunay = Delaunay::build(&points).expect("these points have tets");
    let mut unfiltered = delaunay.clone();
    let mut log: Vec<Entry> = Vec::new();
    let volume: f64 = delaunay.tets().map(|t| support_volume(&delaunay, t)).sum();
    let h = (volume / points.len() as f64).cbrt();
    for n in 0..options.iterations {
        let Some(to) = next(&delaunay) else { break };
        let step = median(to.iter().zip(delaunay.points()).map(|(a, b)| a.distance(*b) / h));
        let (report, moved_ms) = timed(|| delaunay.relocate(&to).expect("these points have tets"));
        let (_, checked_ms) = timed(|| unfiltered.relocate_unfiltered(&to).expect("these points have tets"));
        let mut built_ms = None;
        if n % options.build == 0 {
            let (built, ms) = timed(|| Delaunay::build(&to).expect("these points have tets"));
            built_ms = Some(ms);
            if options.compare {
                let built = sorted_tets(&built);
                assert!(sorted_tets(&delaunay) == built, "iteration {n}: other tets than those of a new triangulation");
                assert!(
                    sorted_tets(&unfiltered) == built,
                    "iteration {n}: other tets than those of a new triangulation"
                );
            }
        }
        log.push(Entry { moved_ms, checked_ms, built_ms, step, report });
    }
    print(name, points.len(), options.from, &log);
}

fn support_volume(delaunay: &Delaunay, tet: [u32; 4]) -> f64 {
    let [a, b, c, d] = tet.map(|v| delaunay.points()[v as usize]);
    tetcvt::geometry::tetrahedron::volume(a, b, c, d)
}

fn print(name: &str, points: usize, from: usize, log: &[Entry]) {
    println!("{name}: {points} points");
    println!(
        "| iterations | step / h | relocate ms | mean | unfiltered ms | build ms | unfiltered / relocate | build / relocate | filter | predicate | flips | repair | renewal | tested % | suspects | reversed | held | flips | rebuilt | worst / build |"
    );
    for range in [0..1, 1..2, 2..5, 5..20, 20..100, 100..500, 500..1000, 1000..1500, 1500..2000, 0..2000] {
        let part: Vec<&Entry> =
            log.iter().zip(from..).filter(|(_, k)| range.contains(k)).map(|(entry, _)| entry).collect();
        if part.is_empty() {
            continue;
        }
        let of = |f: &dyn Fn(&Entry) -> f64| median(part.iter().map(|l| f(l)));
        let mean = |f: &dyn Fn(&Entry) -> f64| part.iter().map(|l| f(l)).sum::<f64>() / part.len() as f64;
        let (moved, checked) = (of(&|l| l.moved_ms), of(&|l| l.checked_ms));
        let built = median(part.iter().filter_map(|l| l.built_ms));
        let phase = |f: &dyn Fn(&Relocation) -> f64| of(&|l| f(&l.report) * 1e6);
        println!(
            "| {range:?} | {:.6} | {moved:.3} | {:.3} | {checked:.3} | {built:.1} | {:.2} | {:.1} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} | {:.2} | {:.0} | {:.1} | {:.1} | {:.0} | {} | {:.2} |",
            of(&|l| l.step),
            mean(&|l| l.moved_ms),
            checked / moved,
            built / moved,
            phase(&|r| r.seconds.filter),
            phase(&|r| r.seconds.predicate),
            phase(&|r| r.seconds.flips),
            phase(&|r| r.seconds.repair),
            phase(&|r| r.seconds.renewal),
            mean(&|l| l.report.tets as f64 * 100.0 / l.report.all_tets as f64),
            mean(&|l| l.report.suspects as f64),
            mean(&|l| l.report.reversed as f64),
            mean(&|l| l.report.held_back as f64),
            mean(&|l| l.report.flips as f64),
            part.iter().filter(|l| l.report.rebuilt).count(),
            part.iter().filter_map(|l| Some(l.moved_ms / l.built_ms?)).fold(0.0, f64::max)
        );
    }
}
