//! The parts of `bench/trajectories` that its figures rest on.

use std::fs;

use glam::DVec3;
use tetcvt::delaunay::{Breakdown, Method, Relocation};
use tetcvt::io::npy::TrajectoryWriter;

#[path = "../bench/trajectories/frames.rs"]
mod frames;

#[path = "../bench/trajectories/rows.rs"]
mod rows;

#[allow(dead_code, reason = "the tables use the rest")]
#[path = "../bench/trajectories/summary.rs"]
mod summary;

type Outcome<T> = Result<T, Box<dyn std::error::Error + Send + Sync>>;

use frames::Frames;
use rows::{Mode, Row};
use summary::Summary;

#[test]
fn frames_come_back_as_they_were_written_in_any_order() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("t.npy");
    let at = |k: usize, i: usize| DVec3::new(k as f64, -(i as f64), 1.0 / (1 + k + i) as f64);
    let mut writer = TrajectoryWriter::create(&file).unwrap();
    for k in 0..4 {
        writer.push((0..5).map(|i| at(k, i))).unwrap();
    }
    writer.finish().unwrap();
    let mut frames = Frames::open(&file).unwrap();
    assert_eq!((frames.count, frames.seeds, frames.path()), (4, 5, file.as_path()));
    assert_eq!(frames.offset + 4 * 5 * 24, fs::metadata(&file).unwrap().len());
    let mut positions = vec![DVec3::ONE; 9];
    for k in [3, 0, 2] {
        frames.read(k, &mut positions).unwrap();
        assert_eq!(positions, (0..5).map(|i| at(k, i)).collect::<Vec<_>>());
    }
    assert!(frames.read(4, &mut positions).is_err());
}

#[test]
fn what_is_no_trajectory_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("t.npy");
    assert!(Frames::open(&file).is_err());
    for (shape, descr) in [("(2, 3, 4), }", "<f8"), ("(2, 3), }", "<f8"), ("(2, 3, 3), }", "<f4")] {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        fs::write(&file, bytes).unwrap();
        assert!(Frames::open(&file).is_err(), "{header}");
    }
    fs::write(&file, b"a short file").unwrap();
    assert!(Frames::open(&file).is_err());
}

fn row(iteration: usize, mode: Mode, seconds: f64, relocation: Relocation) -> Row {
    Row { iteration, mode, seconds, tets: 100, relocation }
}

#[test]
fn rows_survive_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rows.csv");
    let seconds = Breakdown { filter: 0.5, predicate: 0.25, flips: 0.125, repair: 2.0, renewal: 3.0, build: 4.0 };
    let relocation = Relocation {
        bicells_failed: 1,
        vertices_failed: 2,
        predicates: 3,
        flips: 4,
        reversed: 5,
        held_back: 6,
        rebuilt: true,
        seconds,
        ..Relocation::default()
    };
    let mut written: Vec<Row> = Mode::all().map(|m| row(7, m, 0.0625, Relocation::default())).collect();
    written[0].relocation = relocation;
    rows::write(&written, "when and where", &file).unwrap();
    let (about, read) = rows::read(&file).unwrap();
    assert_eq!(about, "when and where");
    assert_eq!(read.len(), written.len());
    for (a, b) in read.iter().zip(&written) {
        assert_eq!((a.iteration, a.mode, a.seconds, a.tets), (b.iteration, b.mode, b.seconds, b.tets));
        assert_eq!(a.relocation, b.relocation);
    }
    let whole = fs::read_to_string(&file).unwrap();
    fs::write(&file, &whole[..whole.len() - 20]).unwrap();
    assert!(rows::read(&file).is_err(), "half a line");
    fs::write(&file, whole.replacen("bicells", "cells", 1)).unwrap();
    assert!(rows::read(&file).is_err(), "another header");
}

#[test]
fn what_was_not_measured_lies_on_a_straight_line() {
    let followed = |bicells_failed, rebuilt| Relocation { bicells_failed, rebuilt, ..Relocation::default() };
    let bicell = Mode::Ours(Method::Bicell);
    let mut rows: Vec<Row> = (1..=24).map(|k| row(k, bicell, 0.5, followed(50, false))).collect();
    // Built anew before and after what counts as settled; the filter did not come to its end.
    rows[0] = row(1, bicell, 8.0, followed(0, true));
    rows[20] = row(21, bicell, 2.0, followed(0, true));
    for (k, seconds) in [(1, 4.0), (3, 6.0), (24, 6.0)] {
        rows.push(row(k, Mode::CgalRebuild, seconds, Relocation::default()));
    }
    let summary = Summary::new("name", 10, &rows).unwrap();
    assert_eq!((summary.iterations, summary.modes.len()), (24, 2));
    let cgal = summary.yardstick().unwrap();
    assert_eq!((cgal.mode, cgal.measured), (Mode::CgalRebuild, 3));
    assert_eq!(cgal.seconds[..4], [4.0, 5.0, 6.0, 6.0]);
    assert_eq!(cgal.total(), 4.0 + 5.0 + 22.0 * 6.0);
    assert_eq!((cgal.late(), cgal.failed_percent), (6.0, None));
    let ours = summary.mode(bicell).unwrap();
    assert_eq!((ours.rebuilt, ours.rebuilt_settled), (2, 1));
    assert_eq!(ours.failed_percent, Some(25.0), "50 of 200 bi-cells, where the filter decided");
    assert_eq!(ours.late(), 0.5);
    assert_eq!(ours.worst_against(cgal), (2.0, 1));
}
