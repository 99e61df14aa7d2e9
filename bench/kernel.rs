//! Time to triangulate, against CGAL's Delaunay triangulation, alternating in one run on the same points.
//!
//! `bench/kernel.sh` compiles `kernel_cgal.cpp` and runs this with its path; `bench/kernel.sh --compare` compares the
//! triangulations tet for tet instead.

use std::path::{Path, PathBuf};

use glam::DVec3;
use tetcvt::delaunay::Delaunay;

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../tests/support.rs"]
mod support;

mod rival;

use rival::{Rival, cpu_seconds, write_points};
use support::*;

fn main() {
    let mut cgal = None;
    let mut compare = false;
    let mut only = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--cgal" => cgal = arguments.next().map(PathBuf::from),
            "--compare" => compare = true,
            "--only" => only = arguments.next(),
            "--bench" => {}
            other => panic!("unknown option {other}"),
        }
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut rival = cgal.map(|program| Rival::start(&program));
    let wanted = |name: &str| only.as_ref().is_none_or(|o| name.contains(o.as_str()));
    if compare {
        let rival = rival.as_mut().expect("--compare needs --cgal PROGRAM");
        for (name, points) in sets_to_compare().into_iter().filter(|s| wanted(s.0)) {
            compare_tets(name, &points, rival, folder.path());
        }
        return;
    }
    println!("| points | tets | tetcvt ms | CGAL ms | tetcvt / CGAL | tetcvt µs a point |");
    println!("|---|---|---|---|---|---|");
    for (name, points) in sets_to_time().into_iter().filter(|s| wanted(s.0)) {
        time(name, &points, rival.as_mut(), folder.path());
    }
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}

fn time(name: &str, points: &[DVec3], rival: Option<&mut Rival>, folder: &Path) {
    let rounds = (600_000 / points.len()).clamp(3, 11);
    let file = write_points(points, folder);
    let mut ours = Vec::new();
    let mut theirs = Vec::new();
    let mut tets = 0;
    let mut rival = rival;
    for _ in 0..rounds {
        let start = cpu_seconds();
        let delaunay = Delaunay::build(points).expect("these points have tets");
        ours.push((cpu_seconds() - start) * 1e3);
        tets = delaunay.tets().count();
        drop(delaunay);
        if let Some(rival) = rival.as_deref_mut() {
            let (ns, count) = rival.ask("time", &file, "-");
            assert_eq!(count, tets, "{name}: CGAL has another number of tets");
            theirs.push(ns * 1e-6);
        }
    }
    let ours = median(&mut ours);
    let each = ours * 1e3 / points.len() as f64;
    if theirs.is_empty() {
        println!("| {name} | {tets} | {ours:.1} | | | {each:.2} |");
        return;
    }
    let theirs = median(&mut theirs);
    println!("| {name} | {tets} | {ours:.1} | {theirs:.1} | {:.2} | {each:.2} |", ours / theirs);
}

fn compare_tets(name: &str, points: &[DVec3], rival: &mut Rival, folder: &Path) {
    let file = write_points(points, folder);
    let out = folder.join("tets");
    let (_, count) = rival.ask("tets", &file, &out.display().to_string());
    let bytes = std::fs::read(&out).expect("CGAL wrote its tets");
    let words: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let theirs: Vec<[u32; 4]> = words.chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]]).collect();
    let delaunay = Delaunay::build(points).expect("these points have tets");
    let mut ours: Vec<[u32; 4]> = delaunay
        .tets()
        .map(|mut t| {
            t.sort_unstable();
            t
        })
        .collect();
    ours.sort_unstable();
    let common = ours.iter().filter(|t| theirs.binary_search(t).is_ok()).count();
    let verdict = if ours == theirs { "equal" } else { "DIFFERENT" };
    println!("{name}: {} points, {} tets, CGAL {count}, common {common}: {verdict}", points.len(), ours.len());
}

fn sets_to_time() -> Vec<(&'static str, Vec<DVec3>)> {
    vec![
        ("10k uniform in a cube", uniform(10_000, 1)),
        ("20k uniform in a cube", uniform(20_000, 2)),
        ("20k uniform in a ball", ball(20_000, 3)),
        ("20k lattice, 10 % jitter", jittered_lattice(20_000, 0.1, 4)),
        ("20k relaxed", relaxed(20_000, 5)),
        ("100k uniform in a cube", uniform(100_000, 6)),
        ("1M uniform in a cube", uniform(1_000_000, 7)),
        ("20k lattice, exact", jittered_lattice(20_000, 0.0, 8)),
    ]
}

fn sets_to_compare() -> Vec<(&'static str, Vec<DVec3>)> {
    vec![
        ("uniform", uniform(20_000, 1)),
        ("grid", grid(15)),
        ("grid of tenths", grid(12).iter().map(|p| *p * 0.1).collect()),
        ("cospherical", integer_sphere(12_101)),
        ("coplanar layers", layers(5_000, 5, 2)),
        ("lines", lines(2_000, 3)),
        ("clusters", clusters(5_000, 4)),
        ("near duplicates", near_duplicates(5_000, 5)),
        ("body-centred lattice", jittered_lattice(5_000, 0.0, 6)),
        ("nearly that lattice", jittered_lattice(5_000, 1e-12, 7)),
    ]
}

/// Uniform in a ball.
fn ball(count: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Rng(seed);
    std::iter::repeat_with(|| rng.point()).filter(|p| p.length() < 0.5).take(count).collect()
}

/// Random points after ten steps, each to the mean of the Delaunay neighbours: near to what Lloyd's algorithm gives.
fn relaxed(count: usize, seed: u64) -> Vec<DVec3> {
    let mut points = uniform(count, seed);
    for _ in 0..10 {
        let adjacency = Delaunay::build(&points).expect("these points have tets").adjacency();
        let inner = |p: &DVec3| p.abs().max_element() < 0.47;
        points = (0..count)
            .map(|i| {
                let near = adjacency.of(i);
                let mean = near.iter().map(|&j| points[j as usize]).sum::<DVec3>() / near.len() as f64;
                if inner(&points[i]) { mean } else { points[i] }
            })
            .collect();
    }
    points
}
