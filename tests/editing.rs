//! Triangulations with points added and taken out, against built ones.

use glam::DVec3;
use proptest::prelude::{ProptestConfig, proptest};
use tetcvt::delaunay::{Delaunay, DelaunayError};

use crate::support::*;

/// Compares with a triangulation built of the same points.
fn equals_built(delaunay: &Delaunay, points: &[DVec3], what: &str) {
    let built = Delaunay::build(points).unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_eq!(delaunay.points(), built.points(), "{what}");
    assert_eq!(delaunay.scale(), built.scale(), "{what}");
    delaunay.check().unwrap_or_else(|e| panic!("{what}: {e}"));
    assert!(sorted_tets(delaunay) == sorted_tets(&built), "{what}: not the tets of a new triangulation");
}

/// Inserts or removes; an error must be that of building, and leave everything as it was. Whether it went well.
fn edit(delaunay: &mut Delaunay, points: &mut Vec<DVec3>, change: Change, what: &str) -> bool {
    let mut changed = points.clone();
    let before = (delaunay.vertices().to_vec(), delaunay.neighbors().to_vec());
    let done = match change {
        Change::Insert(p) => {
            changed.push(p);
            delaunay.insert(p).map(|index| assert_eq!(index as usize, points.len(), "{what}"))
        }
        Change::InsertNear(p, v) => {
            changed.push(p);
            delaunay.insert_near(p, v).map(|index| assert_eq!(index as usize, points.len(), "{what}"))
        }
        Change::Remove(v) => {
            changed.swap_remove(v as usize);
            delaunay.remove(v)
        }
    };
    match done {
        Ok(()) => {
            equals_built(delaunay, &changed, what);
            *points = changed;
            true
        }
        Err(error) => {
            let expected = Delaunay::build(&changed).expect_err(what);
            assert_eq!(error, expected, "{what}");
            let after = (delaunay.vertices().to_vec(), delaunay.neighbors().to_vec());
            assert!(before == after && delaunay.points() == points, "{what}: changed in spite of {error}");
            false
        }
    }
}

enum Change {
    Insert(DVec3),
    InsertNear(DVec3, u32),
    Remove(u32),
}

/// Sets whose ties and hulls are as bad as can be.
fn sets() -> Vec<(&'static str, Vec<DVec3>)> {
    vec![
        ("uniform", uniform(90, 1)),
        ("grid", grid(4)),
        ("flat slab", grid(5).into_iter().filter(|p| p.z < 2.0).collect()),
        ("lattice", jittered_lattice(70, 0.0, 2)),
        ("sphere", integer_sphere(26)),
        ("layers", layers(60, 3, 3)),
        ("lines", lines(50, 4)),
        ("clusters", clusters(60, 5)),
        ("near duplicates", near_duplicates(45, 6)),
        ("cone on a grid", grid(6).into_iter().filter(|p| p.z == 0.0).chain([DVec3::new(2.5, 2.0, 3.0)]).collect()),
        ("huge", uniform(40, 7).into_iter().map(|p| p * 1e90).collect()),
        ("tiny", uniform(40, 8).into_iter().map(|p| p * 1e-90).collect()),
    ]
}

#[test]
fn points_come_one_by_one_and_go_again() {
    for (kind, all) in sets() {
        let mut all = all;
        Rng(9).shuffle(&mut all);
        // The first that have a tet.
        let first = (4..).find(|&n| Delaunay::build(&all[..n]).is_ok()).expect("these points have tets");
        let mut points = all[..first].to_vec();
        let mut delaunay = Delaunay::build(&points).expect("these points have tets");
        for &p in &all[first..] {
            let what = format!("{kind}, insert {}", points.len());
            assert!(edit(&mut delaunay, &mut points, Change::Insert(p), &what));
        }
        let mut rng = Rng(10);
        let mut refused = 0;
        while points.len() > 4 && refused < 20 {
            let v = rng.below(points.len()) as u32;
            let what = format!("{kind}, remove {v} of {}", points.len());
            if !edit(&mut delaunay, &mut points, Change::Remove(v), &what) {
                refused += 1;
            }
        }
        assert!(points.len() <= 40, "{kind}: {} points are left", points.len());
    }
}

#[test]
fn each_point_goes_and_comes_back() {
    for (kind, mut points) in sets() {
        let mut delaunay = Delaunay::build(&points).expect("these points have tets");
        for step in 0..points.len() {
            let p = points[step];
            let what = format!("{kind}, {step}");
            if edit(&mut delaunay, &mut points, Change::Remove(step as u32), &what) {
                assert!(edit(&mut delaunay, &mut points, Change::InsertNear(p, step as u32 / 2), &what));
            }
        }
    }
}

#[test]
fn scales_change_with_the_largest_point() {
    let mut points = uniform(30, 11);
    let mut delaunay = Delaunay::build(&points).expect("these points have tets");
    for far in [1e17, 1e19, 1e30] {
        assert!(edit(&mut delaunay, &mut points, Change::Insert(DVec3::new(far, 1.0, 2.0)), "far"));
    }
    assert_ne!(delaunay.scale(), 1.0);
    for left in (30..33).rev() {
        let v = points.iter().position(|p| p.x > 1e16).expect("one is left") as u32;
        assert!(edit(&mut delaunay, &mut points, Change::Remove(v), "near"));
        assert_eq!(points.len(), left);
    }
    assert_eq!(delaunay.scale(), 1.0);
    let mut small: Vec<DVec3> = uniform(30, 12).into_iter().map(|p| p * 1e-25).collect();
    small.push(DVec3::X);
    let mut delaunay = Delaunay::build(&small).expect("these points have tets");
    assert_eq!(delaunay.scale(), 1.0);
    assert!(edit(&mut delaunay, &mut small, Change::Remove(30), "small"));
    assert_ne!(delaunay.scale(), 1.0);
}

#[test]
fn edits_that_make_no_sense_are_refused() {
    let points = uniform(4, 13);
    let mut delaunay = Delaunay::build(&points).expect("these points have tets");
    assert_eq!(delaunay.remove(0), Err(DelaunayError::TooFew { count: 3 }));
    assert_eq!(delaunay.remove(4), Err(DelaunayError::NoSuchPoint { index: 4, count: 4 }));
    assert_eq!(delaunay.insert_near(DVec3::X, u32::MAX), Err(DelaunayError::NoSuchPoint { index: u32::MAX, count: 4 }));
    let nowhere = DVec3::new(0.0, f64::NEG_INFINITY, 0.0);
    let error = DelaunayError::NotFinite { index: 4, point: nowhere.to_array() };
    assert_eq!(delaunay.insert(nowhere), Err(error));
    let point = points[2].to_array();
    assert_eq!(delaunay.insert(points[2]), Err(DelaunayError::Duplicates { count: 1, first: 2, second: 4, point }));
    equals_built(&delaunay, &points, "after errors");
    // A pyramid without its top is flat.
    let mut points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::Z];
    let mut delaunay = Delaunay::build(&points).expect("these points have tets");
    assert!(!edit(&mut delaunay, &mut points, Change::Remove(4), "top"));
    assert!(edit(&mut delaunay, &mut points, Change::Remove(1), "base"));
}

#[test]
fn edits_and_motions_take_turns() {
    let mut rng = Rng(14);
    let mut points = uniform(400, 15);
    let mut delaunay = Delaunay::build(&points).expect("these points have tets");
    for step in 0..60 {
        let what = format!("step {step}");
        match step % 3 {
            0 => {
                for p in &mut points {
                    *p += rng.point() * 1e-3;
                }
                delaunay.relocate(&points).expect("these points have tets");
                equals_built(&delaunay, &points, &what);
            }
            1 => assert!(edit(&mut delaunay, &mut points, Change::Insert(rng.point() * 1.5), &what)),
            _ => {
                let v = rng.below(points.len()) as u32;
                assert!(edit(&mut delaunay, &mut points, Change::Remove(v), &what));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn any_chain_of_edits(seed in 0u64..u64::MAX, count in 4usize..40, digits in 1i32..8) {
        let mut rng = Rng(seed);
        // Few digits make ties, coplanar points and duplicates.
        let unit = 2f64.powi(-digits);
        let point = |rng: &mut Rng| (rng.point() / unit).round() * unit;
        let mut points: Vec<DVec3> = (0..count).map(|_| point(&mut rng)).collect();
        let Ok(mut delaunay) = Delaunay::build(&points) else { return Ok(()) };
        for step in 0..24 {
            let change = if rng.below(2) == 0 {
                Change::Insert(point(&mut rng))
            } else {
                Change::Remove(rng.below(points.len()) as u32)
            };
            edit(&mut delaunay, &mut points, change, &format!("{seed} {count} {digits}, step {step}"));
        }
    }
}
