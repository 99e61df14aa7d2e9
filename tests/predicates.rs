//! Exact predicates against exact integers of any size.

use glam::DVec3;
use proptest::prelude::*;
use tetcvt::geometry::predicates::{Sign, collinear, insphere, insphere_perturbed, orient3d};

use crate::support::{Rng, exact, exact_insphere, exact_orient3d};

/// All orders of five things, with whether each is even.
fn permutations() -> Vec<([usize; 5], bool)> {
    let mut all = Vec::new();
    for code in 0..3125 {
        let p: [usize; 5] = std::array::from_fn(|i| code / 5usize.pow(i as u32) % 5);
        if (0..5).all(|x| p.contains(&x)) {
            let inversions = (0..5).flat_map(|i| (i + 1..5).map(move |j| (i, j))).filter(|&(i, j)| p[i] > p[j]).count();
            all.push((p, inversions % 2 == 0));
        }
    }
    all
}

/// Five points of one of many regimes, degenerate more often than not.
fn five(rng: &mut Rng) -> [DVec3; 5] {
    let regime = rng.below(12);
    let step = |rng: &mut Rng, n: usize| DVec3::from_array(std::array::from_fn(|_| rng.below(n) as f64));
    let mut points: [DVec3; 5] = std::array::from_fn(|_| rng.point());
    match regime {
        0 => {}
        1 => points = points.map(|_| step(rng, 3)),
        2 => points = points.map(|_| step(rng, 3) * 0.1),
        3 => points = points.map(|p| p + DVec3::splat(1e6)),
        4 => points[4] = (points[0] + points[1] + points[2]) / 3.0,
        5 => points[3] = points[0] * 0.5 + points[1] * 0.5,
        // Nearly on one sphere, then a few units in the last place off.
        6 | 7 => {
            points = points.map(|p| p.normalize() * 0.5);
            if regime == 7 {
                points[4].x = points[4].x.next_up();
            }
        }
        8 => points = points.map(|_| step(rng, 2) * 1e17 + step(rng, 2)),
        9 => points = points.map(|p| p * 2f64.powi(-140)).map(on_the_finest_grid),
        10 => points = points.map(|p| on_the_finest_grid(p * 10f64.powi(-(rng.below(44) as i32)))),
        _ => points = points.map(|p| DVec3::new(p.x, 0.25, (p.z * 4.0).round())),
    }
    points
}

/// Multiples of 2^-200, the finest grid on which predicates promise to be exact.
fn on_the_finest_grid(p: DVec3) -> DVec3 {
    (p * 2f64.powi(200)).round() * 2f64.powi(-200)
}

#[test]
fn signs_are_exact_and_change_with_every_permutation() {
    let mut rng = Rng(1);
    let permutations = permutations();
    assert_eq!(permutations.len(), 120);
    let (mut flat, mut cospherical) = (0, 0);
    for round in 0..6000 {
        let p = five(&mut rng);
        let e = p.map(exact);
        let orient = exact_orient3d([&e[0], &e[1], &e[2], &e[3]]);
        // The determinant itself, whether or not the tet is positive.
        let sphere = exact_insphere([&e[0], &e[1], &e[2], &e[3]], &e[4]);
        flat += usize::from(orient == Sign::Zero);
        cospherical += usize::from(sphere == Sign::Zero && orient != Sign::Zero);
        let every = if round % 20 == 0 { 1 } else { 17 };
        for (q, even) in permutations.iter().step_by(every) {
            let [a, b, c, d, f] = q.map(|i| p[i]);
            let expected = if *even { sphere } else { -sphere };
            assert_eq!(insphere(a, b, c, d, f), expected, "{a} {b} {c} {d} {f}");
            if q[4] == 4 {
                let expected = if *even { orient } else { -orient };
                assert_eq!(orient3d(a, b, c, d), expected, "{a} {b} {c} {d}");
            }
        }
    }
    assert!(flat > 500 && cospherical > 100, "the sets must be degenerate: {flat} flat, {cospherical} cospherical");
}

#[test]
fn the_perturbation_decides_every_tie_and_only_ties() {
    let mut rng = Rng(2);
    let mut ties = 0;
    for _ in 0..60_000 {
        let mut p = five(&mut rng);
        match orient3d(p[0], p[1], p[2], p[3]) {
            Sign::Zero => continue,
            Sign::Negative => p.swap(0, 1),
            Sign::Positive => {}
        }
        if p[..4].contains(&p[4]) {
            continue;
        }
        let [a, b, c, d, q] = p;
        let perturbed = insphere_perturbed(a, b, c, d, q);
        assert_ne!(perturbed, Sign::Zero);
        match insphere(a, b, c, d, q) {
            Sign::Zero => ties += 1,
            sign => assert_eq!(perturbed, sign),
        }
        // The same whatever even order the tet comes in.
        assert_eq!(insphere_perturbed(b, c, a, d, q), perturbed);
        assert_eq!(insphere_perturbed(b, a, d, c, q), perturbed);
        // Two tets on a facet agree on whether it is Delaunay: q is inside (a, b, c, d) exactly if d is inside the tet
        // across the facet (a, b, c), where q is on its far side.
        if orient3d(a, b, c, q) == Sign::Negative {
            assert_eq!(insphere_perturbed(b, a, c, q, d), perturbed, "{p:?}");
        }
    }
    assert!(ties > 1000, "{ties}");
}

proptest! {
    #[test]
    fn any_grid_points_get_the_exact_sign(coordinates in prop::array::uniform15(-40i32..40), unit in -190i32..50) {
        let at = |i: usize| DVec3::from_array(std::array::from_fn(|k| f64::from(coordinates[3 * i + k]) * 2f64.powi(unit)));
        let p: [DVec3; 5] = std::array::from_fn(at);
        let e = p.map(exact);
        prop_assert_eq!(orient3d(p[0], p[1], p[2], p[3]), exact_orient3d([&e[0], &e[1], &e[2], &e[3]]));
        prop_assert_eq!(insphere(p[0], p[1], p[2], p[3], p[4]), exact_insphere([&e[0], &e[1], &e[2], &e[3]], &e[4]));
    }

    #[test]
    fn points_of_all_magnitudes_get_the_exact_sign(
        mantissas in prop::array::uniform15(-1.0f64..1.0),
        exponents in prop::array::uniform15(-147i32..60),
    ) {
        let at = |i: usize| DVec3::from_array(std::array::from_fn(|k| mantissas[3 * i + k] * 2f64.powi(exponents[3 * i + k])));
        let p: [DVec3; 5] = std::array::from_fn(|i| on_the_finest_grid(at(i)));
        let e = p.map(exact);
        prop_assert_eq!(orient3d(p[0], p[1], p[2], p[3]), exact_orient3d([&e[0], &e[1], &e[2], &e[3]]));
        prop_assert_eq!(insphere(p[0], p[1], p[2], p[3], p[4]), exact_insphere([&e[0], &e[1], &e[2], &e[3]], &e[4]));
    }
}

#[test]
fn collinear_is_exact() {
    let mut rng = Rng(3);
    for _ in 0..1000 {
        // Short coordinates: the sum is exact.
        let point = |rng: &mut Rng| DVec3::from_array(std::array::from_fn(|_| rng.below(1 << 20) as f64));
        let (a, u) = (point(&mut rng), point(&mut rng));
        let b = a + u * 3.0;
        let c = a - u * 5.0;
        assert!(collinear(a, b, c));
        assert!(!collinear(a, b, DVec3::new(c.x, c.y, c.z.next_up())) || u == DVec3::ZERO);
    }
}
