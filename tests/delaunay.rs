//! The triangulation against brute force.

use glam::DVec3;
use num_bigint::BigInt;
use proptest::prelude::{ProptestConfig, prop, prop_assert, proptest};
use tetcvt::delaunay::{Delaunay, DelaunayError, Facet, INFINITE};
use tetcvt::geometry::predicates::Sign;

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

#[test]
fn tets_fill_the_hull() {
    for (kind, points) in kinds() {
        let delaunay = build(&points);
        let exact: Vec<ExactPoint> = delaunay.points().iter().map(|&p| exact(p)).collect();
        let at = |v: u32| &exact[v as usize];
        let inside: BigInt = delaunay.tets().map(|t| exact_volume6(t.map(at))).sum();
        // Facets of the hull, seen from any one point, here the first; they are turned outward.
        let hull: BigInt = delaunay
            .vertices()
            .iter()
            .filter(|t| t[3] == INFINITE)
            .map(|t| -exact_volume6([at(t[0]), at(t[1]), at(t[2]), at(0)]))
            .sum();
        assert!(inside == hull && inside > BigInt::ZERO, "{kind}: {inside} {hull}");
        // And the hull is that of all points: none lies beyond a facet.
        for t in delaunay.vertices().iter().filter(|t| t[3] == INFINITE) {
            let beyond = |p| exact_orient3d([at(t[0]), at(t[1]), at(t[2]), p]) == Sign::Positive;
            assert!(!exact.iter().any(beyond), "{kind}: {t:?}");
        }
    }
}

#[test]
fn a_cavity_may_have_any_number_of_vertices() {
    // Shells of a few hundred points and their common centre, whose cavity holds the inner shell; the order of
    // insertion is not ours to choose, so try many sets.
    for seed in 0..20 {
        let mut rng = Rng(seed);
        let mut points: Vec<DVec3> = (0..300).map(|_| rng.point().normalize()).collect();
        points.push(rng.point() * 1e-3);
        let delaunay = build(&points);
        delaunay.check().unwrap_or_else(|e| panic!("{e}"));
        assert!(delaunay.adjacency().of(300).len() > 64, "the centre sees the shell");
    }
}

#[test]
fn neighbours_are_mutual_and_ascend() {
    for (kind, points) in kinds() {
        let delaunay = build(&points);
        let mut edges: Vec<(u32, u32)> = delaunay
            .tets()
            .flat_map(|t| (0..4).flat_map(move |i| (0..4).filter(move |&j| j != i).map(move |j| (t[i], t[j]))))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let adjacency = delaunay.adjacency();
        let listed = (0..points.len()).flat_map(|v| adjacency.of(v).iter().map(move |&w| (v as u32, w)));
        assert!(listed.eq(edges), "{kind}");
        for t in 0..delaunay.vertices().len() as u32 {
            for i in 0..4 {
                let (u, j) = delaunay.opposite(t, i);
                assert_eq!(delaunay.neighbors()[u as usize][j], Facet::new(t, i));
                assert_eq!(delaunay.neighbor(t, i), u);
            }
        }
    }
}

#[test]
fn points_out_of_range_are_held_scaled() {
    for (factor, scaled) in [(1.0, false), (1e-15, false), (1e15, false), (1e-200, true), (1e200, true)] {
        let points: Vec<DVec3> = uniform(30, 41).iter().map(|p| *p * factor).collect();
        let delaunay = build(&points);
        assert_eq!(delaunay.scale() != 1.0, scaled, "{factor}");
        for (held, given) in delaunay.points().iter().zip(&points) {
            assert_eq!(*held / delaunay.scale(), *given);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn any_subset_of_a_small_grid(cells in prop::collection::btree_set(0usize..125, 4..60), seed in 0u64..1000) {
        let all = grid(5);
        let mut points: Vec<DVec3> = cells.iter().map(|&c| all[c] * 0.1).collect();
        match Delaunay::build(&points) {
            Ok(delaunay) => {
                prop_assert!(delaunay.check().is_ok(), "{:?}", delaunay.check());
                let count = delaunay.tets().count();
                Rng(seed).shuffle(&mut points);
                prop_assert!(build(&points).tets().count() == count);
            }
            Err(DelaunayError::Flat { .. } | DelaunayError::Line { .. }) => {}
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}
