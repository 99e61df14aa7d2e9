//! CGAL's triangulation of the same points, to be timed beside our own work.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

use glam::DVec3;

/// Seconds that this thread has spent computing: on a machine that others use as well, the clock tells less. Where the
/// system does not say, the clock all the same.
pub fn cpu_seconds() -> f64 {
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = stat.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// CGAL, in a process of its own that answers requests.
pub struct Rival {
    _process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Rival {
    /// Starts `program`, compiled from `kernel_cgal.cpp`.
    pub fn start(program: &Path) -> Rival {
        let mut process =
            Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("the CGAL program runs");
        let requests = process.stdin.take().expect("piped");
        let answers = BufReader::new(process.stdout.take().expect("piped"));
        Rival { _process: process, requests, answers }
    }

    /// Nanoseconds and number of tets.
    pub fn ask(&mut self, verb: &str, file: &Path, argument: &str) -> (f64, usize) {
        writeln!(self.requests, "{verb} {} {argument}", file.display()).expect("CGAL listens");
        self.requests.flush().expect("CGAL listens");
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("CGAL answers");
        let mut words = line.split_whitespace();
        let mut number = || words.next().and_then(|w| w.parse::<f64>().ok()).expect("CGAL answers two numbers");
        (number(), number() as usize)
    }
}

/// Writes points to a file in `folder` as CGAL's program reads them.
pub fn write_points(points: &[DVec3], folder: &Path) -> PathBuf {
    let path = folder.join("points");
    let bytes: Vec<u8> = points.iter().flat_map(|p| p.to_array()).flat_map(f64::to_le_bytes).collect();
    std::fs::write(&path, bytes).expect("the temporary folder is writable");
    path
}
