//! Moved triangulations against rebuilt ones, by every method.

use std::path::Path;

use glam::DVec3;
use proptest::prelude::{ProptestConfig, proptest};
use tetcvt::delaunay::{Delaunay, DelaunayError, Method, Relocation, Updater};
use tetcvt::geometry::frame::Frame;
use tetcvt::io::read_surface;
use tetcvt::params::Target;
use tetcvt::progress::{Flow, Step};
use tetcvt::{Observer, Params, tetrahedralize};

use crate::relocation::{follow_by, motions, smoothed, starts};
use crate::shapes::Shape;
use crate::support::*;

/// Updaters of the same points, by each method.
fn all(points: &[DVec3]) -> Vec<Updater> {
    let start = Delaunay::build(points).expect("these points have tets");
    Method::ALL.map(|method| Updater::new(start.clone(), method)).into()
}

/// Moves, and compares with a triangulation built of the same points.
fn follow(updater: &mut Updater, to: &[DVec3], what: &str) -> Option<Relocation> {
    let what = format!("{}, {what}", updater.method().name());
    follow_by(updater, Updater::delaunay, |u| u.relocate(to), to, &what)
}

#[test]
fn every_motion_of_every_set_by_every_method() {
    for count in [4, 7, 40] {
        for seed in 0..if count <= 8 { 2 } else { 1 } {
            for (kind, points) in starts(count, seed) {
                if Delaunay::build(&points).is_err() {
                    continue;
                }
                let h = (count as f64).cbrt().recip();
                for updater in all(&points) {
                    let mut updater = updater;
                    // One after the other, and back between: filters remember.
                    for (motion, to) in motions(&points, h, seed) {
                        let what = format!("{count} {kind} {motion} {seed}");
                        follow(&mut updater, &to, &what);
                        follow(&mut updater, &points, &format!("{what}, back"));
                    }
                }
            }
        }
    }
}

#[test]
fn a_relaxation_by_every_method() {
    for (kind, points) in [("random", uniform(500, 50)), ("jittered lattice", jittered_lattice(500, 0.1, 51))] {
        for mut updater in all(&points) {
            let method = updater.method();
            let mut failed = 0;
            for iteration in 0..40 {
                let to = smoothed(updater.delaunay(), 0.5);
                let what = format!("{kind}, iteration {iteration}");
                let report = follow(&mut updater, &to, &what).expect("these points have tets");
                failed += if method == Method::Vertex { report.vertices_failed } else { report.bicells_failed };
                let parts: f64 = report.seconds.parts().iter().map(|(_, s)| s).sum();
                assert!(parts > 0.0, "{method:?}: no time is accounted for");
                match method {
                    Method::Rebuild => assert!(report.rebuilt),
                    // These mend what is reversed.
                    Method::Bicell | Method::Check => assert!(!report.rebuilt || iteration < 3, "{what}: {report:?}"),
                    _ => {}
                }
            }
            assert!(failed > 0 || method == Method::Rebuild, "{kind} {method:?}: nothing ever failed");
        }
    }
}

#[test]
fn long_rests_and_sudden_moves() {
    // Filters that remember are tried most by many steps that are each below what they forgive.
    let points = jittered_lattice(400, 0.2, 3);
    let h = (points.len() as f64).cbrt().recip();
    for mut updater in all(&points) {
        let mut to = updater.delaunay().points().to_vec();
        let mut rng = Rng(4);
        let mut speeds: Vec<DVec3> = to.iter().map(|_| rng.point() * (1e-3 * h)).collect();
        for step in 0..60 {
            for (p, v) in to.iter_mut().zip(&mut speeds) {
                *p += *v;
                if rng.below(20) == 0 {
                    *v = rng.point() * (h * 10f64.powi(-(rng.below(6) as i32) - 1));
                }
            }
            if step % 20 == 13 {
                let v = rng.below(to.len());
                to[v] = rng.point();
            }
            if step % 10 == 7 {
                continue;
            }
            follow(&mut updater, &to, &format!("step {step}")).expect("these points have tets");
        }
    }
}

/// Remembers the positions after each iteration, in the frame, and the energies.
#[derive(Default)]
struct Recorder {
    positions: Vec<Vec<DVec3>>,
    energies: Vec<f64>,
}

impl Observer for Recorder {
    fn seeds(&mut self, step: Option<&Step>, positions: &[DVec3], _: &Frame) -> Flow {
        self.positions.push(positions.to_vec());
        self.energies.extend(step.map(|s| s.energy));
        Flow::Continue
    }
}

#[test]
fn runs_of_the_mesher_by_every_method() {
    let kitten = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/models/kitten.obj"));
    let mut surfaces = vec![
        ("bunny", read_surface(Path::new("models/bunny.obj")).expect("a sound model")),
        ("torus", Shape::torus(40, 20, 1.0, 0.4).surface().expect("a valid shape")),
    ];
    if kitten.exists() {
        surfaces.push(("kitten", read_surface(kitten).expect("a sound model")));
    }
    for (name, surface) in &surfaces {
        let mut first: Option<Recorder> = None;
        for update in Method::ALL {
            let mut record = Recorder::default();
            let params = Params {
                target: Target::Count(600),
                iterations: 12,
                tolerance: 0.0,
                update,
                check: true,
                ..Params::default()
            };
            let mesh = tetrahedralize(surface, &params, &mut record).expect("a valid mesh");
            assert_eq!(mesh.points.len(), 600);
            // All follow the same path, up to rounding: sums over cells run in the order of the tets.
            let first = first.get_or_insert(Recorder { energies: record.energies.clone(), ..Recorder::default() });
            for (energy, expected) in record.energies.iter().zip(&first.energies) {
                assert!((energy - expected).abs() < 1e-9 * expected, "{name} {update:?}: {energy} {expected}");
            }
            assert_eq!(record.energies.len(), first.energies.len(), "{name} {update:?}");
            first.positions = record.positions;
        }
        // And along one path each holds the same tets.
        let path = first.expect("there are methods").positions;
        for mut updater in all(&path[0]) {
            for (k, to) in path[1..].iter().enumerate() {
                if to.len() == path[0].len() {
                    follow(&mut updater, to, &format!("{name}, iteration {k}")).expect("these points have tets");
                }
            }
        }
    }
}

#[test]
fn motions_of_ties() {
    // Lattice to lattice: every point ends where another was, or on the sphere and in the plane of many.
    let lattice = grid(6);
    let shifted = |by: DVec3| lattice.iter().map(|p| *p + by).collect::<Vec<_>>();
    let mut turned: Vec<DVec3> = lattice.iter().map(|p| DVec3::new(p.y, 5.0 - p.x, p.z)).collect();
    for mut updater in all(&lattice) {
        follow(&mut updater, &shifted(DVec3::X), "shift by a cell").expect("a grid has tets");
        follow(&mut updater, &shifted(DVec3::new(0.5, 0.25, 0.125)), "shift by parts").expect("a grid has tets");
        follow(&mut updater, &turned, "turn").expect("a grid has tets");
        follow(&mut updater, &lattice, "back").expect("a grid has tets");
        // One layer slides over the next, cell by cell.
        for k in 1..5 {
            let slide = |p: &DVec3| if p.z > 2.0 { *p + DVec3::X * (0.5 * f64::from(k)) } else { *p };
            let to: Vec<DVec3> = lattice.iter().map(slide).collect();
            follow(&mut updater, &to, &format!("slide {k}")).expect("a grid has tets");
        }
        // A single point wanders along a row of free places, then off them.
        for k in 0..12 {
            turned[0].z = 5.25 + 0.25 * f64::from(k % 7);
            follow(&mut updater, &turned, &format!("wander {k}")).expect("a grid has tets");
        }
    }
}

#[test]
fn errors_leave_every_method_as_it_was() {
    let points = uniform(200, 80);
    for mut updater in all(&points) {
        let near: Vec<DVec3> = points.iter().map(|p| *p * 1.000001).collect();
        let change = |f: &dyn Fn(&mut Vec<DVec3>)| {
            let mut to = near.clone();
            f(&mut to);
            to
        };
        follow(&mut updater, &near, "near").expect("these points have tets");
        for (what, to) in [
            ("not finite", change(&|p| p[7].y = f64::NAN)),
            ("two meet", change(&|p| p[9] = p[150])),
            ("one visits", change(&|p| p[9] = points[150])),
            ("flat", change(&|p| p.iter_mut().for_each(|p| p.z = 0.25))),
            ("a point", change(&|p| p.fill(DVec3::Y))),
        ] {
            follow(&mut updater, &to, what);
            follow(&mut updater, &near, &format!("after {what}")).expect("these points have tets");
        }
        assert_eq!(updater.relocate(&near[1..]), Err(DelaunayError::WrongCount { count: 199, expected: 200 }));
        follow(&mut updater, &points, "at last").expect("these points have tets");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 30, ..ProptestConfig::default() })]

    #[test]
    fn any_chain_of_motions_by_every_method(
        seed in 0u64..u64::MAX, count in 4usize..120, movers in 1usize..8, digits in 0i32..60,
    ) {
        let mut rng = Rng(seed);
        let start: Vec<DVec3> = (0..count).map(|_| rng.point()).collect();
        if Delaunay::build(&start).is_err() {
            return Ok(());
        }
        for mut updater in all(&start) {
            let mut rng = Rng(seed + 1);
            let mut points = start.clone();
            for step in 0..8 {
                let size = 10f64.powi(-(rng.below(7) as i32));
                // Few digits make ties, coplanar points and duplicates.
                let unit = 2f64.powi(-digits.min(if step % 2 == 0 { 60 } else { 4 }));
                for p in &mut points {
                    if rng.below(8) < movers {
                        *p += rng.point() * size;
                        *p = (*p / unit).round() * unit;
                    }
                }
                let what = format!("{seed} {count} {movers} {digits}, step {step}");
                if follow(&mut updater, &points, &what).is_none() {
                    points = updater.delaunay().points().to_vec();
                }
            }
        }
    }
}
