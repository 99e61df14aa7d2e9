//! Measurements, one a line: an iteration followed in one way.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use tetcvt::delaunay::{Breakdown, Method, Relocation};

use super::Outcome;

/// A way to have the triangulation of the moved points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// One of ours.
    Ours(Method),
    /// CGAL's construction.
    CgalRebuild,
    /// CGAL's relocation of each vertex.
    CgalMove,
}

impl Mode {
    /// Ours, then CGAL's.
    pub fn all() -> impl Iterator<Item = Mode> {
        Method::ALL.into_iter().map(Mode::Ours).chain([Mode::CgalRebuild, Mode::CgalMove])
    }

    /// As on the command line of tetcvt; CGAL's with its name in front.
    pub fn name(self) -> &'static str {
        match self {
            Mode::Ours(method) => method.name(),
            Mode::CgalRebuild => "cgal-rebuild",
            Mode::CgalMove => "cgal-move",
        }
    }
}

/// One iteration in one mode.
#[derive(Clone, Debug)]
pub struct Row {
    /// From 1 on.
    pub iteration: usize,
    /// How it was followed.
    pub mode: Mode,
    /// Time of the whole update.
    pub seconds: f64,
    /// Tets afterwards, infinite ones included; there are twice as many bi-cells.
    pub tets: usize,
    /// What the update says of itself; of CGAL's nothing is known.
    pub relocation: Relocation,
}

/// The columns.
const HEADER: &str = "iteration,mode,seconds,bicells,bicells_failed,vertices_failed,predicates,flips,reversed,held_back,\
                      rebuilt,filter_s,predicate_s,flips_s,repair_s,renewal_s,build_s";

/// Writes the rows as CSV, after a line that says when and where they were measured.
pub fn write(rows: &[Row], about: &str, file: &Path) -> Outcome<()> {
    let mut text = format!("# {about}\n{HEADER}\n");
    for row in rows {
        let r = &row.relocation;
        let counts =
            [2 * row.tets, r.bicells_failed, r.vertices_failed, r.predicates, r.flips, r.reversed, r.held_back];
        write!(text, "{},{},{:.7}", row.iteration, row.mode.name(), row.seconds)?;
        for count in counts {
            write!(text, ",{count}")?;
        }
        write!(text, ",{}", u8::from(r.rebuilt))?;
        for (_, seconds) in r.seconds.parts() {
            write!(text, ",{seconds:.7}")?;
        }
        text.push('\n');
    }
    fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()).into())
}

/// Reads what [`write`] wrote.
pub fn read(file: &Path) -> Outcome<(String, Vec<Row>)> {
    read_table(file, HEADER, parse)
}

/// Reads the line about a table, and the lines below its header.
pub fn read_table<T>(file: &Path, header: &str, parse: impl Fn(&str) -> Option<T>) -> Outcome<(String, Vec<T>)> {
    let wrong = |what: &str| format!("{}: {what}", file.display());
    let text = fs::read_to_string(file).map_err(|e| wrong(&e.to_string()))?;
    let mut lines = text.lines();
    let about = lines.next().and_then(|l| l.strip_prefix("# ")).ok_or_else(|| wrong("its first line says nothing"))?;
    if lines.next() != Some(header) {
        return Err(wrong("not the columns of this version: measure anew").into());
    }
    let rows: Option<Vec<T>> = lines.map(parse).collect();
    Ok((about.to_owned(), rows.ok_or_else(|| wrong("a line does not fit its header"))?))
}

fn parse(line: &str) -> Option<Row> {
    let words: Vec<&str> = line.split(',').collect();
    if words.len() != HEADER.split(',').count() {
        return None;
    }
    let count = |i: usize| words[i].parse::<usize>().ok();
    let seconds = |i: usize| words[i].parse::<f64>().ok();
    Some(Row {
        iteration: count(0)?,
        mode: Mode::all().find(|m| m.name() == words[1])?,
        seconds: seconds(2)?,
        tets: count(3)? / 2,
        relocation: Relocation {
            bicells_failed: count(4)?,
            vertices_failed: count(5)?,
            predicates: count(6)?,
            flips: count(7)?,
            reversed: count(8)?,
            held_back: count(9)?,
            rebuilt: count(10)? == 1,
            seconds: Breakdown {
                filter: seconds(11)?,
                predicate: seconds(12)?,
                flips: seconds(13)?,
                repair: seconds(14)?,
                renewal: seconds(15)?,
                build: seconds(16)?,
            },
            ..Relocation::default()
        },
    })
}
