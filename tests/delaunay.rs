//! The triangulation against brute force.

use glam::DVec3;
use tetcvt::delaunay::{Delaunay, DelaunayError};

use crate::support::*;

/// Every kind of point set in this file, small.
fn kinds() -> Vec<(&'static str, Vec<DVec3>)> {
    vec![
        ("uniform", uniform(60, 1)),
        ("grid", grid(4)),
        ("cospherical", integer_sphere(41)),
        ("sphere and centre", integer_sphere(26).into_iter().chain([DVec3::ZERO]).collect()),
        ("layers", layers(60, 3, 2)),
        ("lines", lines(60, 3)),
        ("clusters", clusters(60, 4)),
        ("near duplicates", near_duplicates(60, 5)),
        ("lattice", jittered_lattice(54, 0.0, 6)),
        ("jittered lattice", jittered_lattice(54, 1e-15, 6)),
        ("far", uniform(60, 7).iter().map(|p| *p + DVec3::splat(1e6)).collect()),
        ("tiny", grid(3).iter().map(|p| *p * 1e-200).collect()),
        ("huge", uniform(40, 8).iter().map(|p| *p * 1e200).collect()),
        ("denormal", grid(3).iter().map(|p| *p * 5e-324).collect()),
        ("largest", uniform(40, 9).iter().map(|p| *p * f64::MAX).collect()),
        ("mixed", uniform(60, 10).iter().map(|p| DVec3::new(p.x, p.y * 1e-30, p.z * 1e-50)).collect()),
    ]
}

/// The finite tets as a set.
fn tets(delaunay: &Delaunay) -> Vec<[u32; 4]> {
    let mut tets: Vec<[u32; 4]> = delaunay
        .tets()
        .map(|mut t| {
            t.sort_unstable();
            t
        })
        .collect();
    tets.sort_unstable();
    tets
}

fn build(points: &[DVec3]) -> Delaunay {
    Delaunay::build(points).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn spheres_are_empty_by_brute_force() {
    use tetcvt::geometry::predicates::Sign;
    for (kind, points) in kinds() {
        let delaunay = build(&points);
        delaunay.check().unwrap_or_else(|e| panic!("{kind}: {e}"));
        let exact: Vec<ExactPoint> = delaunay.points().iter().map(|&p| exact(p)).collect();
        for tet in delaunay.tets() {
            let corners = tet.map(|v| &exact[v as usize]);
            assert_eq!(exact_orient3d(corners), Sign::Positive, "{kind}: {tet:?}");
            for (v, p) in exact.iter().enumerate() {
                assert!(exact_insphere(corners, p) != Sign::Positive, "{kind}: {v} in {tet:?}");
            }
        }
    }
}

#[test]
fn the_order_of_the_points_does_not_matter() {
    let mut rng = Rng(11);
    for (kind, points) in kinds() {
        let expected = tets(&build(&points));
        for _ in 0..6 {
            let mut order: Vec<usize> = (0..points.len()).collect();
            rng.shuffle(&mut order);
            let shuffled: Vec<DVec3> = order.iter().map(|&i| points[i]).collect();
            let delaunay = build(&shuffled);
            let mut renamed: Vec<[u32; 4]> = tets(&delaunay)
                .into_iter()
                .map(|t| {
                    let mut t = t.map(|v| order[v as usize] as u32);
                    t.sort_unstable();
                    t
                })
                .collect();
            renamed.sort_unstable();
            assert!(renamed == expected, "{kind}");
        }
    }
}

#[test]
fn larger_sets_pass_the_check() {
    for (kind, points) in [
        ("uniform", uniform(5000, 20)),
        ("grid", grid(12)),
        ("cospherical", integer_sphere(12_101)),
        ("layers", layers(3000, 5, 21)),
        ("lines", lines(1000, 22)),
        ("clusters", clusters(3000, 23)),
        ("near duplicates", near_duplicates(3000, 24)),
        ("lattice", jittered_lattice(3000, 0.0, 25)),
        ("nearly a lattice", jittered_lattice(3000, 1e-7, 25)),
        ("jittered lattice", jittered_lattice(3000, 0.1, 25)),
    ] {
        let delaunay = build(&points);
        delaunay.check().unwrap_or_else(|e| panic!("{kind}: {e}"));
        assert_eq!(delaunay.points(), points);
    }
}

#[test]
fn points_without_a_tet_are_refused() {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    for count in 0..4 {
        let points = &uniform(3, 30)[..count];
        assert_eq!(Delaunay::build(points).unwrap_err(), DelaunayError::TooFew { count });
    }
    let line: Vec<DVec3> = (0..10).map(|i| p(1.0, 2.0, 3.0) * f64::from(i)).collect();
    assert_eq!(Delaunay::build(&line).unwrap_err(), DelaunayError::Line { count: 10 });
    // Coordinates on a grid of 2^-52: the sum is exact, the plane is one.
    let tilted = |q: DVec3| p(q.x, q.y, q.x + q.y);
    let plane: Vec<DVec3> = uniform(20, 31).into_iter().map(|q| tilted(tetcvt::geometry::frame::snap(q))).collect();
    assert_eq!(Delaunay::build(&plane).unwrap_err(), DelaunayError::Flat { count: 20 });
    let mut points = uniform(100, 32);
    points[40] = points[70];
    points[71] = points[70];
    points[30] = points[90];
    let error = Delaunay::build(&points).unwrap_err();
    let point = points[30].to_array();
    assert_eq!(error, DelaunayError::Duplicates { count: 3, first: 30, second: 90, point });
    points[5].y = f64::NAN;
    match Delaunay::build(&points).unwrap_err() {
        DelaunayError::NotFinite { index: 5, .. } => {}
        other => panic!("{other}"),
    }
}
