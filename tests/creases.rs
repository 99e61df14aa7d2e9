//! Creases of the input, in the mesh: whole chains of its edges, close to the input's.

use std::path::Path;

use glam::DVec3;
use tetcvt::params::Target;
use tetcvt::progress::{Observer, Silent};
use tetcvt::seeds::SeedKind;
use tetcvt::surface::features::{Curve, Features};
use tetcvt::{Params, Surface, TetMesh, io, tetrahedralize};

use crate::shapes::Shape;

/// How a mesh keeps the creases of its surface.
struct Chains {
    /// Chords between consecutive vertices of a crease.
    chords: usize,
    /// Middles of those that are no edge of the boundary.
    missing: Vec<DVec3>,
    /// The creases' length, and that of those that have no vertex between their ends nor both ends, in the frame.
    length: f64,
    left_out: f64,
    /// The farthest that a crease strays from its chords, over the mean edge of the boundary.
    stray: f64,
}

fn chains(surface: &Surface, mesh: &TetMesh) -> Chains {
    let features = Features::find(surface, 40.0);
    let frame = surface.frame();
    let points: Vec<DVec3> = mesh.points.iter().map(|&p| frame.to_frame(p)).collect();
    let mut edges: Vec<[u32; 2]> = mesh
        .boundary
        .iter()
        .flat_map(|t| (0..3).map(|i| [t.vertices[i], t.vertices[(i + 1) % 3]]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let length = |e: &[u32; 2]| points[e[0] as usize].distance(points[e[1] as usize]);
    let spacing = edges.iter().map(length).sum::<f64>() / edges.len() as f64;
    let bound: Vec<u32> = (0..points.len() as u32)
        .filter(|&v| matches!(mesh.kinds[v as usize], SeedKind::Curve | SeedKind::Corner))
        .collect();
    let mut found = Chains { chords: 0, missing: Vec::new(), length: 0.0, left_out: 0.0, stray: 0.0 };
    for curve in &features.curves {
        found.length += curve.length();
        let chain = chain(curve, surface, &bound, &points);
        if chain.len() < 2 {
            found.left_out += curve.length();
            continue;
        }
        let closing = curve.is_closed().then_some([chain[chain.len() - 1], chain[0]]);
        for [(s, a), (t, b)] in chain.windows(2).map(|w| [w[0], w[1]]).chain(closing) {
            if a == b {
                continue;
            }
            found.chords += 1;
            let [p, q] = [a, b].map(|v| points[v as usize]);
            if edges.binary_search(&[a.min(b), a.max(b)]).is_err() {
                found.missing.push((p + q) / 2.0);
            }
            let end = if t < s { t + curve.length() } else { t };
            for k in 1..16 {
                let on_curve = curve.point_at(s + (end - s) * f64::from(k) / 16.0, surface.points());
                let share = ((on_curve - p).dot(q - p) / p.distance_squared(q)).clamp(0.0, 1.0);
                found.stray = found.stray.max(on_curve.distance(p.lerp(q, share)) / spacing);
            }
        }
    }
    found
}

/// The vertices on a curve, in order, with their arc lengths.
fn chain(curve: &Curve, surface: &Surface, bound: &[u32], points: &[DVec3]) -> Vec<(f64, u32)> {
    let mut chain: Vec<(f64, u32)> = bound
        .iter()
        .filter_map(|&v| {
            let (at, distance2) = curve.closest(points[v as usize], surface.points());
            (distance2 < 1e-24).then_some((at, v))
        })
        .collect();
    chain.sort_by(|a, b| a.0.total_cmp(&b.0));
    chain
}

/// The mesh of `surface` with so many vertices, and how it keeps the creases.
fn kept(surface: &Surface, count: usize, improve: bool) -> Chains {
    let params = Params { target: Target::Count(count), iterations: 20, improve, ..Params::default() };
    let mesh = tetrahedralize(surface, &params, &mut Silent).expect("a mesh");
    chains(surface, &mesh)
}

/// A prism over a regular polygon, with a smaller one as a hole through it.
fn washer(sides: u32) -> Shape {
    let ring = |radius: f64, z: f64| {
        (0..sides).map(move |i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
            DVec3::new(radius * cos, radius * sin, z)
        })
    };
    let points = ring(1.0, 0.0).chain(ring(1.0, 0.6)).chain(ring(0.4, 0.0)).chain(ring(0.4, 0.6)).collect();
    let at = |r: u32, i: u32| r * sides + i % sides;
    let band = |low: u32, high: u32, i: u32| vec![at(low, i), at(low, i + 1), at(high, i + 1), at(high, i)];
    // The outer side, the inner one, the top, the bottom.
    let faces = (0..sides).flat_map(|i| [band(0, 1, i), band(3, 2, i), band(1, 3, i), band(2, 0, i)]);
    let quads: Vec<Vec<u32>> = faces.collect();
    let faces = quads.iter().flat_map(|q| [vec![q[0], q[1], q[2]], vec![q[0], q[2], q[3]]]).collect();
    Shape { points, faces }
}

/// A prism over a star with so many tips, thinner the more there are.
fn star(tips: u32) -> Shape {
    let ring = |z: f64| {
        (0..2 * tips).map(move |i| {
            let (sin, cos) = (std::f64::consts::PI * f64::from(i) / f64::from(tips)).sin_cos();
            let radius = if i % 2 == 0 { 1.0 } else { 0.3 };
            DVec3::new(radius * cos, radius * sin, z)
        })
    };
    let n = 2 * tips;
    let points = ring(0.0).chain(ring(0.7)).chain([DVec3::ZERO, DVec3::Z * 0.7]).collect();
    let sides = (0..n).flat_map(|i| {
        let j = (i + 1) % n;
        [vec![i, j, j + n], vec![i, j + n, i + n], vec![j, i, 2 * n], vec![i + n, j + n, 2 * n + 1]]
    });
    Shape { points, faces: sides.collect() }
}

#[test]
fn creases_that_meet_at_acute_angles_are_whole() {
    for (tips, count) in [(5, 500), (9, 1000)] {
        let chains = kept(&star(tips).surface().expect("a sound surface"), count, true);
        assert!(chains.missing.is_empty(), "{tips} tips: missing at {:?}", chains.missing);
        assert!(chains.stray < 1e-9 && chains.left_out == 0.0, "{tips} tips: {}", chains.stray);
    }
}

/// Hears how many seeds went to follow the surface.
#[derive(Default)]
struct Notes(Vec<String>);

impl Observer for Notes {
    fn note(&mut self, text: &str) {
        self.0.push(text.to_string());
    }
}

#[test]
fn tips_that_have_their_seeds_get_no_more() {
    // A cube with a tall pyramid on each side: before the mesh is mended tips may be in no tet.
    let cube = (0..8).map(|i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 0.125 } else { -0.125 }));
    let tips = (0..6).map(|i| std::array::from_fn(|k| if k == i % 3 { if i < 3 { 0.5 } else { -0.5 } } else { 0.0 }));
    let points: Vec<DVec3> = cube.chain(tips).map(DVec3::from_array).collect();
    let sides = [[1, 3, 7, 5], [2, 6, 7, 3], [4, 5, 7, 6], [0, 4, 6, 2], [0, 1, 5, 4], [0, 2, 3, 1]];
    let faces = (8..).zip(sides).flat_map(|(tip, s)| (0..4).map(move |k| vec![s[k], s[(k + 1) % 4], tip]));
    let surface = Shape { points, faces: faces.collect() }.surface().expect("a sound surface");
    let mut notes = Notes::default();
    let params = Params { target: Target::Count(20_000), iterations: 20, improve: false, ..Params::default() };
    let mesh = tetrahedralize(&surface, &params, &mut notes).expect("a mesh");
    let moved: Vec<&String> = notes.0.iter().filter(|n| n.contains("flat facets")).collect();
    assert!(moved.is_empty(), "{moved:?}");
    assert!(chains(&surface, &mesh).missing.is_empty());
}

#[test]
fn polygonal_and_round_creases_are_whole_and_close() {
    for (sides, count) in [(6, 400), (16, 900), (64, 900), (200, 900)] {
        let surface = washer(sides).surface().expect("a sound surface");
        let chains = kept(&surface, count, true);
        assert!(chains.missing.is_empty(), "{sides} sides: missing at {:?}", chains.missing);
        assert_eq!(chains.left_out, 0.0);
        // Every bend of more than a few degrees has its vertex; chords are so short that others stray little.
        assert!(chains.stray < 0.01, "{sides} sides: {}", chains.stray);
    }
}

#[test]
fn creases_of_mechanical_parts_are_whole() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    for (name, count) in [("joint", 2000), ("fandisk", 3000), ("thingi_72214", 3000), ("casting", 3000)] {
        let file = folder.join(name).with_extension("obj");
        if !file.exists() {
            continue;
        }
        let surface = io::read_surface(&file).expect("a sound surface");
        // With the improvement, and on the smallest without it too.
        for improve in [true, false].into_iter().take(if name == "joint" { 2 } else { 1 }) {
            let chains = kept(&surface, count, improve);
            assert!(chains.missing.is_empty(), "{name}: missing at {:?}", chains.missing);
            assert!(chains.stray < 0.012, "{name}, {improve}: {}", chains.stray);
            assert!(chains.left_out < 1e-3 * chains.length, "{name}: {}", chains.left_out);
        }
    }
}
