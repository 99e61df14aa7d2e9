//! Moved triangulations against rebuilt ones.

use glam::DVec3;
use proptest::prelude::{ProptestConfig, proptest};
use tetcvt::delaunay::{Delaunay, DelaunayError, Facet, Relocation};

use crate::support::*;

/// Moves, and compares with a triangulation built of the same points.
fn follow(delaunay: &mut Delaunay, to: &[DVec3], what: &str) -> Option<Relocation> {
    follow_by(delaunay, |d| d, |d| d.relocate(to), to, what)
}

/// Moves what has a triangulation, and compares that with one built of the same points: tets or errors alike. Returns none
/// for an error.
pub fn follow_by<T>(
    moving: &mut T,
    delaunay: impl Fn(&T) -> &Delaunay,
    relocate: impl FnOnce(&mut T) -> Result<Relocation, DelaunayError>,
    to: &[DVec3],
    what: &str,
) -> Option<Relocation> {
    let parts = |d: &Delaunay| (d.points().to_vec(), d.vertices().to_vec(), d.neighbors().to_vec());
    let before = parts(delaunay(moving));
    let moved = relocate(moving);
    let delaunay = delaunay(moving);
    match (moved, Delaunay::build(to)) {
        (Ok(report), Ok(built)) => {
            delaunay.check().unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_eq!(delaunay.points(), built.points(), "{what}");
            assert_eq!(delaunay.scale(), built.scale(), "{what}");
            assert!(sorted_tets(delaunay) == sorted_tets(&built), "{what}: not the tets of a new triangulation");
            Some(report)
        }
        (Err(error), Err(expected)) => {
            // Two points that are not numbers are not equal.
            assert_eq!(format!("{error:?}"), format!("{expected:?}"), "{what}");
            assert!(before == parts(delaunay), "{what}: changed in spite of {error}");
            None
        }
        (got, expected) => panic!("{what}: {got:?} in place of {expected:?}"),
    }
}

/// Point sets to start from.
pub fn starts(count: usize, seed: u64) -> Vec<(&'static str, Vec<DVec3>)> {
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
pub fn motions(points: &[DVec3], h: f64, seed: u64) -> Vec<(&'static str, Vec<DVec3>)> {
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
        (
            "few leap, all tremble",
            each(&mut |r, i, p| if i % 97 == 5 { r.point() } else { p + r.point() * (1e-3 * h) }),
        ),
        ("few leap to a grid", each(&mut |r, i, p| if i % 61 == 5 { (r.point() * 8.0).round() / 8.0 } else { p })),
        ("few leap to a sphere", each(&mut |r, i, p| if i % 61 == 7 { r.point().normalize_or(DVec3::Y) } else { p })),
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

/// Each vertex goes `damping` of the way to the mean of its neighbours; those of the hull stay.
pub fn smoothed(delaunay: &Delaunay, damping: f64) -> Vec<DVec3> {
    let points = delaunay.points();
    let adjacency = delaunay.adjacency();
    let mut to: Vec<DVec3> = (0..points.len())
        .map(|v| {
            let neighbors = adjacency.of(v);
            let mean = neighbors.iter().map(|&w| points[w as usize]).sum::<DVec3>() / neighbors.len() as f64;
            points[v].lerp(mean, damping)
        })
        .collect();
    for tet in delaunay.vertices().iter().filter(|t| t[3] == tetcvt::delaunay::INFINITE) {
        tet[..3].iter().for_each(|&v| to[v as usize] = points[v as usize]);
    }
    to
}

#[test]
fn a_relaxation_is_followed_without_building_anew() {
    for (kind, points) in [("random", uniform(2000, 50)), ("jittered lattice", jittered_lattice(2000, 0.1, 51))] {
        let mut delaunay = Delaunay::build(&points).expect("these points have tets");
        for iteration in 0..200 {
            let to = smoothed(&delaunay, 0.5);
            let what = format!("{kind}, iteration {iteration}");
            let report = follow(&mut delaunay, &to, &what).expect("these points have tets");
            assert!(!report.rebuilt || iteration < 3, "{what}: {report:?}");
        }
    }
}

#[test]
fn small_motions_are_mended_hull_and_all() {
    let ball = |count| uniform(count, 60).into_iter().map(|p| p.normalize_or(DVec3::X) * p.length().cbrt());
    for (kind, points) in [
        ("uniform", uniform(5000, 61)),
        ("lattice", jittered_lattice(5000, 0.05, 62)),
        ("sphere", uniform(1000, 63).into_iter().map(|p| p.normalize_or(DVec3::X)).collect()),
        ("ball", ball(3000).collect()),
    ] {
        let mut delaunay = Delaunay::build(&points).expect("these points have tets");
        let h = (points.len() as f64).cbrt().recip();
        let mut mended = 0;
        for step in 0..12 {
            let mut rng = Rng(step);
            let size = h * [1e-6, 1e-3, 5e-3][step as usize % 3];
            let to: Vec<DVec3> = delaunay.points().iter().map(|&p| p + rng.point() * size).collect();
            let what = format!("{kind}, step {step}");
            let report = follow(&mut delaunay, &to, &what).expect("these points have tets");
            // On a sphere all is nearly tied, and most facets change at once.
            assert!(!report.rebuilt || kind == "sphere", "{what}: {report:?}");
            mended += report.flips + report.held_back;
        }
        assert!(mended > 0, "{kind}: there was nothing to do");
    }
}

#[test]
fn a_few_may_leap_anywhere() {
    let mut delaunay = Delaunay::build(&uniform(3000, 70)).expect("these points have tets");
    for step in 0..10 {
        let mut rng = Rng(100 + step);
        let mut to = delaunay.points().to_vec();
        for _ in 0..3 {
            let v = rng.below(to.len());
            to[v] = rng.point() * if step % 2 == 0 { 1.0 } else { 3.0 };
        }
        follow(&mut delaunay, &to, &format!("step {step}")).expect("these points have tets");
    }
}

/// A part of the points leaps, to places of every kind, while the rest stays or moves a little; with far points around and
/// without, and none of it is built anew.
#[test]
fn those_that_leap_are_put_elsewhere() {
    let far = [-4.0, 5.0].map(|x| [-4.0, 5.0].map(|y| [-4.0, 5.0].map(|z| DVec3::new(x, y, z))));
    for (kind, rest) in [
        ("uniform", uniform(4000, 71)),
        ("jittered lattice", jittered_lattice(4000, 0.1, 72)),
        ("exact lattice", jittered_lattice(4000, 0.0, 73)),
        ("layers", layers(4000, 9, 74)),
    ] {
        for around in [far.as_flattened().as_flattened(), &[]] {
            let points = [&rest[..], around].concat();
            let h = (points.len() as f64).cbrt().recip();
            let start = Delaunay::build(&points).expect("these points have tets");
            let mut leapt = 0;
            for step in 0..24u64 {
                let mut rng = Rng(75 + step);
                let tremble = h * [0.0, 1e-9, 1e-5, 1e-3][step as usize % 4];
                let every = [1000, 150, 40][step as usize % 3];
                let goal = |rng: &mut Rng| match step % 6 {
                    0 | 1 => rng.point(),
                    2 => (rng.point() * 32.0).round() / 32.0 + DVec3::X / 64.0,
                    3 => DVec3::splat(0.5) + (rng.point() - 0.5).normalize_or(DVec3::X) * 0.25,
                    4 => rng.point() * 1.5,
                    _ => DVec3::new(rng.point().x, rng.point().y, 0.5),
                };
                let mut to = points.clone();
                for p in &mut to[..rest.len()] {
                    *p = if rng.below(every) == 0 { goal(&mut rng) } else { *p + rng.point() * tremble };
                }
                let what = format!("{kind}, {} around, step {step}", around.len());
                let mut delaunay = start.clone();
                for (to, way) in [(&to, "there"), (&points, "back")] {
                    let Some(report) = follow(&mut delaunay, to, &format!("{what}, {way}")) else { break };
                    // Layers and exact lattices lie on planes, and to tremble spoils most of their tets; outside, points are
                    // so far from each other that to come back is not far.
                    let any = kind == "layers" || kind == "exact lattice" || (step % 6 == 4 && way == "back");
                    assert!(!report.rebuilt || any, "{what}, {way}: {report:?}");
                    leapt += report.held_back;
                }
            }
            assert!(leapt > 200 || kind == "layers", "{kind}: {leapt} leapt");
        }
    }
}

#[test]
fn errors_leave_everything_as_it_was() {
    let points = uniform(300, 80);
    let mut delaunay = Delaunay::build(&points).expect("these points have tets");
    let before = (delaunay.vertices().to_vec(), delaunay.neighbors().to_vec());
    let jitter: Vec<DVec3> = points.iter().map(|p| *p * 1.000001).collect();
    let change = |f: &dyn Fn(&mut Vec<DVec3>)| {
        let mut to = jitter.clone();
        f(&mut to);
        to
    };
    let cases: [(Vec<DVec3>, DelaunayError); 7] = [
        (points[..299].to_vec(), DelaunayError::WrongCount { count: 299, expected: 300 }),
        (
            change(&|p| p[7].y = f64::INFINITY),
            DelaunayError::NotFinite { index: 7, point: [jitter[7].x, f64::INFINITY, jitter[7].z] },
        ),
        (
            change(&|p| p[9] = p[200]),
            DelaunayError::Duplicates { count: 1, first: 9, second: 200, point: jitter[200].to_array() },
        ),
        (
            // Two that leap to one place, amid others that do.
            change(&|p| {
                [20, 60, 77, 150].into_iter().zip([1, 4, 2, 4]).for_each(|(v, k)| p[v] = jitter[k] * 0.5 + 0.25)
            }),
            DelaunayError::Duplicates { count: 1, first: 60, second: 150, point: (jitter[4] * 0.5 + 0.25).to_array() },
        ),
        (change(&|p| p.iter_mut().for_each(|p| p.z = 0.25)), DelaunayError::Flat { count: 300 }),
        (
            change(&|p| p.iter_mut().enumerate().for_each(|(i, p)| *p = DVec3::X * i as f64)),
            DelaunayError::Line { count: 300 },
        ),
        (
            change(&|p| p.fill(DVec3::Y)),
            DelaunayError::Duplicates { count: 299, first: 0, second: 1, point: [0.0, 1.0, 0.0] },
        ),
    ];
    for (to, expected) in cases {
        assert_eq!(delaunay.relocate(&to).expect_err("no triangulation"), expected);
        assert_eq!(delaunay.points(), points, "{expected}");
        let after = (delaunay.vertices().to_vec(), delaunay.neighbors().to_vec());
        assert!(before == after, "{expected}: tets changed");
        assert_eq!(delaunay.check(), Ok(()), "{expected}");
        // And what comes after is followed as ever.
        let mut next = delaunay.clone();
        follow(&mut next, &jitter, "after an error").expect("these points have tets");
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    type State = (Vec<[u32; 4]>, Vec<[Facet; 4]>, Relocation);
    let run = |threads| -> Vec<State> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut delaunay = Delaunay::build(&uniform(6000, 90)).expect("these points have tets");
            (0..12)
                .map(|_| {
                    let to = smoothed(&delaunay, 0.4);
                    let mut report = delaunay.relocate(&to).expect("these points have tets");
                    report.seconds = Default::default();
                    (delaunay.vertices().to_vec(), delaunay.neighbors().to_vec(), report)
                })
                .collect()
        })
    };
    let (one, three) = (run(1), run(3));
    assert!(one == three);
    assert!(one.iter().any(|step| step.2.flips > 0 && !step.2.rebuilt));
}

/// Checks the tets, and now and then that they are those of a new triangulation.
fn follow_long(delaunay: &mut Delaunay, to: &[DVec3], step: usize, what: &str) -> Relocation {
    if step.is_multiple_of(16) {
        return follow(delaunay, to, what).expect("these points have tets");
    }
    let report = delaunay.relocate(to).expect("these points have tets");
    if step.is_multiple_of(3) {
        delaunay.check().unwrap_or_else(|e| panic!("{what}: {e}"));
    }
    report
}

/// Many small steps, so that certificates last; with pauses, bursts, leaps of a few, and stretches on a grid.
#[test]
fn certificates_last_for_as_long_as_they_say() {
    for (kind, mut points) in [
        ("uniform", uniform(1000, 200)),
        ("lattice", jittered_lattice(1000, 1e-3, 201)),
        ("exact lattice", jittered_lattice(1000, 0.0, 202)),
        ("layers", layers(1000, 5, 203)),
    ] {
        let h = (points.len() as f64).cbrt().recip();
        let mut delaunay = Delaunay::build(&points).expect("these points have tets");
        let mut rng = Rng(204);
        // Steps are not all random: what drifts reaches the limits that what trembles never does.
        let drift: Vec<DVec3> = points.iter().map(|_| rng.point()).collect();
        let (mut spared, mut flips) = (0, 0);
        for step in 0..400 {
            let size = h * [1e-4, 3e-4, 1e-3, 1e-5][step / 25 % 4];
            let what = format!("{kind}, step {step}");
            for (i, p) in points.iter_mut().enumerate() {
                match step % 50 {
                    40 => *p = (*p * 4096.0).round() / 4096.0,
                    41 => {}
                    42 if i % 311 == step / 50 => *p = rng.point(),
                    43 if i / 40 == step / 50 => *p += rng.point() * (0.2 * h),
                    44 if i % 2 == 0 => {}
                    _ => *p += drift[i] * size + rng.point() * (0.3 * size),
                }
            }
            let report = follow_long(&mut delaunay, &points, step, &what);
            spared += usize::from(report.tets * 4 < report.all_tets);
            flips += report.flips;
        }
        assert!(flips > 0, "{kind}: nothing changed");
        assert!(spared > 100 || kind != "uniform", "{kind}: certificates were of use in {spared} steps");
    }
}

#[test]
fn with_and_without_certificates_alike() {
    let mut certified = Delaunay::build(&uniform(4000, 210)).expect("these points have tets");
    let mut unfiltered = certified.clone();
    let mut spared = 0;
    for step in 0..150 {
        let to = smoothed(&certified, if step < 60 { 0.5 } else { 0.001 });
        let report = certified.relocate(&to).expect("these points have tets");
        let all = unfiltered.relocate_unfiltered(&to).expect("these points have tets");
        assert!(sorted_tets(&certified) == sorted_tets(&unfiltered), "step {step}");
        assert!(all.tets == all.all_tets || all.rebuilt, "step {step}: {all:?}");
        spared += usize::from(report.tets < report.all_tets / 4);
    }
    assert!(spared > 50, "{spared}");
}

/// As long as a long run: 20,000 points, 2,000 smoothing steps, compared with a new triangulation after each.
#[test]
#[ignore = "takes minutes"]
fn a_long_relaxation() {
    let mut delaunay = Delaunay::build(&uniform(20_000, 220)).expect("these points have tets");
    for step in 0..2000 {
        let to = smoothed(&delaunay, 0.5);
        let report = delaunay.relocate(&to).expect("these points have tets");
        assert!(
            sorted_tets(&delaunay) == sorted_tets(&Delaunay::build(&to).expect("these points have tets")),
            "step {step}"
        );
        assert!(!report.rebuilt || step < 20, "step {step}: {report:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, ..ProptestConfig::default() })]

    #[test]
    fn any_chain_of_motions(seed in 0u64..u64::MAX, count in 4usize..150, movers in 1usize..8, digits in 0i32..60) {
        let mut rng = Rng(seed);
        let mut points: Vec<DVec3> = (0..count).map(|_| rng.point()).collect();
        let Ok(mut delaunay) = Delaunay::build(&points) else { return Ok(()) };
        for step in 0..6 {
            let size = 10f64.powi(-(rng.below(7) as i32));
            // Few digits make ties, coplanar points and duplicates.
            let unit = 2f64.powi(-digits.min(if step % 2 == 0 { 60 } else { 4 }));
            for p in &mut points {
                if rng.below(8) < movers {
                    *p += rng.point() * size;
                    *p = (*p / unit).round() * unit;
                }
            }
            if follow(&mut delaunay, &points, &format!("{seed} {count} {movers} {digits}, step {step}")).is_none() {
                points = delaunay.points().to_vec();
            }
        }
    }
}
