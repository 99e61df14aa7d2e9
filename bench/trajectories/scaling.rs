//! How the cost of an update and the memory grow with the count of seeds.

use std::fs;
use std::path::Path;

use peak_alloc::PeakAlloc;
use tetcvt::delaunay::{Delaunay, Method, Updater};

use super::Outcome;
use super::cgal::Cgal;
use super::clock::Clock;
use super::frames::Frames;
use super::rows::read_table;

/// Counts what is allocated. A relaxed counter at each allocation costs nothing that could be measured.
#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Constructions are timed so often.
const BUILDS: usize = 3;

/// Measurements at one count.
#[derive(Clone, Debug)]
pub struct Size {
    /// The count.
    pub seeds: usize,
    /// Seconds of an update.
    pub bicell: f64,
    /// The same without a filter.
    pub check: f64,
    /// Seconds to build.
    pub build: f64,
    /// The same by CGAL, where it is there.
    pub cgal: Option<f64>,
    /// Bytes of the triangulation with its points.
    pub built_bytes: usize,
    /// Bytes of it after all updates by `bicell`, with all that these keep.
    pub followed_bytes: usize,
}

/// Follows a trajectory by each method on its own, and builds its last frame.
pub fn measure(frames: &mut Frames, cgal: Option<&mut Cgal>, clock: Clock) -> Outcome<Size> {
    let mut positions = Vec::new();
    let last = frames.count - 1;
    frames.read(last, &mut positions)?;
    let mut builds = Vec::new();
    let mut built_bytes = 0;
    for _ in 0..BUILDS {
        let before = MEMORY.current_usage();
        let started = clock.seconds();
        let delaunay = Delaunay::build(&positions)?;
        builds.push(clock.seconds() - started);
        built_bytes = MEMORY.current_usage() - before;
        drop(delaunay);
    }
    let cgal = match cgal {
        Some(cgal) => {
            cgal.open(frames)?;
            let seconds: Outcome<Vec<f64>> = (0..BUILDS).map(|_| Ok(cgal.build(last)?.0)).collect();
            Some(median(seconds?))
        }
        None => None,
    };
    let (bicell, followed_bytes) = follow(frames, Method::Bicell, clock)?;
    let (check, _) = follow(frames, Method::Check, clock)?;
    Ok(Size { seeds: frames.seeds, bicell, check, build: median(builds), cgal, built_bytes, followed_bytes })
}

/// Median seconds of an update over the second half of the trajectory, and the bytes held at its end.
fn follow(frames: &mut Frames, method: Method, clock: Clock) -> Outcome<(f64, usize)> {
    let mut positions = Vec::new();
    frames.read(0, &mut positions)?;
    let before = MEMORY.current_usage();
    let mut updater = Updater::new(Delaunay::build(&positions)?, method);
    let mut seconds = Vec::with_capacity(frames.count);
    for k in 1..frames.count {
        frames.read(k, &mut positions)?;
        let started = clock.seconds();
        updater.relocate(&positions)?;
        seconds.push(clock.seconds() - started);
    }
    let bytes = MEMORY.current_usage() - before;
    Ok((median(seconds.split_off(seconds.len() / 2)), bytes))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The columns.
const HEADER: &str = "seeds,bicell_s,check_s,build_s,cgal_rebuild_s,built_bytes,followed_bytes";

/// Writes the sizes as CSV, after a line that says when and where they were measured.
pub fn write(sizes: &[Size], about: &str, file: &Path) -> Outcome<()> {
    let mut text = format!("# {about}\n{HEADER}\n");
    for s in sizes {
        let cgal = s.cgal.map_or(String::new(), |c| format!("{c:.6}"));
        let seconds = format!("{:.7},{:.7},{:.6},{cgal}", s.bicell, s.check, s.build);
        text.push_str(&format!("{},{seconds},{},{}\n", s.seeds, s.built_bytes, s.followed_bytes));
    }
    fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()).into())
}

/// Reads what [`write`] wrote.
pub fn read(file: &Path) -> Outcome<(String, Vec<Size>)> {
    read_table(file, HEADER, parse)
}

fn parse(line: &str) -> Option<Size> {
    let words: Vec<&str> = line.split(',').collect();
    let [seeds, bicell, check, build, cgal, built, followed] = words[..] else { return None };
    Some(Size {
        seeds: seeds.parse().ok()?,
        bicell: bicell.parse().ok()?,
        check: check.parse().ok()?,
        build: build.parse().ok()?,
        cgal: if cgal.is_empty() { None } else { Some(cgal.parse().ok()?) },
        built_bytes: built.parse().ok()?,
        followed_bytes: followed.parse().ok()?,
    })
}
