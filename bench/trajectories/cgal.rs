//! CGAL, in a process of its own that answers requests about a trajectory: `cgal.cpp`.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use super::Outcome;
use super::frames::Frames;

/// The process.
pub struct Cgal {
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Cgal {
    /// Starts the program that `trajectories.sh` compiles.
    pub fn start(program: &Path) -> Outcome<Cgal> {
        let mut process = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| format!("{}: {e}", program.display()))?;
        let requests = process.stdin.take().expect("piped");
        let answers = BufReader::new(process.stdout.take().expect("piped"));
        Ok(Cgal { process, requests, answers })
    }

    /// Further requests are about this trajectory.
    pub fn open(&mut self, frames: &Frames) -> Outcome<()> {
        let path = frames.path().canonicalize()?;
        self.ask(&format!("open {} {} {}", frames.offset, frames.seeds, path.display())).map(|_| ())
    }

    /// Builds frame `k`: seconds, and tets with the infinite ones.
    pub fn build(&mut self, k: usize) -> Outcome<(f64, usize)> {
        self.ask(&format!("build {k}"))
    }

    /// Moves every vertex from frame `k - 1` to frame `k`: seconds, and tets with the infinite ones.
    pub fn relocate(&mut self, k: usize) -> Outcome<(f64, usize)> {
        self.ask(&format!("move {k}"))
    }

    fn ask(&mut self, request: &str) -> Outcome<(f64, usize)> {
        writeln!(self.requests, "{request}")?;
        self.requests.flush()?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        let parsed = line
            .trim()
            .split_once(' ')
            .and_then(|(ns, tets)| Some((ns.parse::<u64>().ok()?, tets.parse::<usize>().ok()?)));
        let (ns, tets) = parsed.ok_or_else(|| format!("CGAL's answer to \"{request}\" is \"{}\"", line.trim()))?;
        Ok((ns as f64 * 1e-9, tets))
    }
}

impl Drop for Cgal {
    fn drop(&mut self) {
        // It idles between requests, so nothing is lost; without this a zombie stays until the program ends.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
