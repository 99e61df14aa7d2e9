//! Moved triangulations against rebuilt ones.

use glam::DVec3;
use proptest::prelude::{ProptestConfig, prop_assert, proptest};
use tetcvt::delaunay::{Delaunay, DelaunayError, Facet, Relocation};

use crate::support::*;

/// All tets, the infinite ones too, as a set.
fn tets(delaunay: &Delaunay) -> Vec<[u32; 4]> {
    let mut tets: Vec<[u32; 4]> = delaunay.vertices().to_vec();
    tets.iter_mut().for_each(|t| t.sort_unstable());
    tets.sort_unstable();
    tets
}

/// Moves, and compares with a triangulation built of the same points: tets or errors alike. Returns none for an error.
fn follow(delaunay: &mut Delaunay, to: &[DVec3], what: &str) -> Option<Relocation> {
    let before = (delaunay.points().to_vec(), delaunay.vertices().to_vec(), delaunay.neighbors().to_vec());
    match (delaunay.relocate(to), Delaunay::build(to)) {
        (Ok(report), Ok(built)) => {
            delaunay.check().unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_eq!(delaunay.points(), built.points(), "{what}");
            assert_eq!(delaunay.scale(), built.scale(), "{what}");
            assert!(tets(delaunay) == tets(&built), "{what}: not the tets of a new triangulation");
            Some(report)
        }
        (Err(error), Err(expected)) => {
            // Two points that are not numbers are not equal.
            assert_eq!(format!("{error:?}"), format!("{expected:?}"), "{what}");
            let after = (delaunay.points().to_vec(), delaunay.vertices().to_vec(), delaunay.neighbors().to_vec());
            assert!(before == after, "{what}: changed in spite of {error}");
            None
        }
        (got, expected) => panic!("{what}: {got:?} in place of {expected:?}"),
    }
}

/// Point sets to start from.
fn starts(count: usize, seed: u64) -> Vec<(&'static str, Vec<DVec3>)> {
    let take = |mut points: Vec<DVec3>| {
        points.truncate(count);
        points
    };
    let side = (1..).find(|n| n * n * n >= count).expect("the cubes are unbounded");
    vec![
        ("uniform", uniform(count, seed)),
        ("grid", take(grid(side)).iter().map(|p| *p / side as f64).collect()),
        ("lattice", take(jittered_lattice(count, 0.0, seed))),
        ("jittered lattice", take(jittered_lattice(count, 0.1, seed))),
        ("layers", layers(count, 3, seed)),
        ("clusters", clusters(count, seed)),
        ("near duplicates", near_duplicates(count, seed)),
    ]
}

/// Motions of every kind, of points about a spacing `h` apart.
fn motions(points: &[DVec3], h: f64, seed: u64) -> Vec<(&'static str, Vec<DVec3>)> {
    let mut rng = Rng(seed);
    let mut each = |f: &mut dyn FnMut(&mut Rng, usize, DVec3) -> DVec3| -> Vec<DVec3> {
        points.iter().enumerate().map(|(i, &p)| f(&mut rng, i, p)).collect()
    };
    let mut mixed = points.to_vec();
    Rng(seed).shuffle(&mut mixed);
    let turn = glam::DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.3 + seed as f64);
    vec![
        ("stay", points.to_vec()),
        ("tremble", each(&mut |r, _, p| p + r.point() * 1e-12)),
        ("small", each(&mut |r, _, p| p + r.point() * (1e-3 * h))),
        ("medium", each(&mut |r, _, p| p + r.point() * (0.03 * h))),
        ("large", each(&mut |r, _, p| p + r.point() * (0.3 * h))),
        ("one leaps", each(&mut |r, i, p| if i == 1 { r.point() } else { p })),
        ("few leap", each(&mut |r, i, p| if i % 97 == 5 { r.point() } else { p })),
        ("few leave", each(&mut |r, i, p| if i % 97 == 5 { r.point() * 9.0 } else { p })),
        ("all leap", each(&mut |r, _, _| r.point())),
        ("change places", mixed),
        ("two change places", each(&mut |_, i, p| if i < 2 { points[1 - i] } else { p })),
        ("shift", each(&mut |_, _, p| p + DVec3::new(0.3, 1e3, -2.0))),
        ("turn", each(&mut |_, _, p| turn * p)),
        ("shear", each(&mut |_, _, p| DVec3::new(p.x + 0.4 * p.y, p.y, p.z - 0.7 * p.x))),
        ("mirror", each(&mut |_, _, p| DVec3::new(-p.x, p.y, p.z))),
        ("flatten", each(&mut |_, _, p| DVec3::new(p.x, p.y, p.z * 1e-9))),
        ("grow", each(&mut |_, _, p| p * 1e70)),
        ("shrink", each(&mut |_, _, p| p * 1e-100)),
        ("collapse", each(&mut |_, _, p| (p * 8.0).round() / 8.0)),
        ("near a grid", each(&mut |r, _, p| (p * 64.0).round() / 64.0 + r.point() * 1e-14)),
        ("onto planes", each(&mut |_, _, p| DVec3::new(p.x, p.y, (p.z * 16.0).round() / 16.0))),
        ("onto a sphere", each(&mut |_, _, p| p.normalize_or(DVec3::X))),
        ("onto a plane", each(&mut |_, _, p| DVec3::new(p.x, p.y, 0.5))),
        ("onto a line", each(&mut |_, i, _| DVec3::X * i as f64)),
        ("to a point", each(&mut |_, _, _| DVec3::X)),
        ("two meet", each(&mut |_, i, p| if i == 1 { points[0] } else { p })),
    ]
}

#[test]
fn every_motion_of_every_set() {
    for count in [4, 5, 6, 8, 12, 30, 100, 700] {
        for seed in 0..if count <= 30 { 4 } else { 1 } {
            for (kind, points) in starts(count, seed) {
                let Ok(start) = Delaunay::build(&points) else { continue };
                let h = (count as f64).cbrt().recip();
                for (motion, to) in motions(&points, h, seed) {
                    let what = format!("{count} {kind} {motion} {seed}");
                    let mut delaunay = start.clone();
                    follow(&mut delaunay, &to, &what);
                    // And back.
                    follow(&mut delaunay, &points, &format!("{what}, back"));
                }
            }
        }
    }
}

#[test]
fn a_pentagram_is_no_pentagon() {
    // All tets about the axis stay positive, the hull stays convex across each edge, but it winds twice.
    for turns in [1.0, 2.0] {
        for height in [0.05, 0.5, 0.9, 1.0, 1.1, 2.0] {
            let ring = |turns: f64| {
                let at = move |i: i32| {
                    let (y, x) = (turns * std::f64::consts::TAU * f64::from(i) / 5.0 + 0.1).sin_cos();
                    DVec3::new(x, y, 1e-3 * f64::from(i))
                };
                let axis = [DVec3::Z * height, DVec3::Z * -height];
                (0..5).map(at).chain(axis).collect::<Vec<DVec3>>()
            };
            let mut delaunay = Delaunay::build(&ring(turns)).expect("these points have tets");
            follow(&mut delaunay, &ring(3.0 - turns), &format!("{turns} {height}"));
        }
    }
}
