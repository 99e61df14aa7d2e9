//! Sizes that vary: asked for, graded, met; weighted moments; what is refused.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use tetcvt::clipped_voronoi::Clipper;
use tetcvt::delaunay::Delaunay;
use tetcvt::params::{Boundary, Start, Target};
use tetcvt::progress::Silent;
use tetcvt::seeds::{self, Anchor};
use tetcvt::sizing::{SizeField, SizeMesh, Sizes, Sizing};
use tetcvt::surface::features::Features;
use tetcvt::tet_mesh::SizeRatio;
use tetcvt::{Error, Params, Surface, TetMesh, io, tetrahedralize};

use crate::shapes::Shape;
use crate::support::Rng;

fn by(text: &str) -> Sizes {
    Sizes { field: Some(SizeField::Expression(text.to_owned())), ..Sizes::default() }
}

fn sized(sizes: Sizes) -> Params {
    Params { target: Target::Sizes, sizes, ..Params::default() }
}

/// The unit cube.
fn cube() -> Surface {
    Shape::cuboid(DVec3::ZERO, DVec3::ONE).surface().expect("a cube")
}

fn sizing(surface: &Surface, sizes: &Sizes) -> Arc<Sizing> {
    let features = Features::find(surface, 40.0);
    Sizing::new(surface, &features, sizes, None).expect("sizes").expect("they vary")
}

fn mesh(surface: &Surface, params: &Params) -> TetMesh {
    let mesh = tetrahedralize(surface, params, &mut Silent).expect("a mesh");
    mesh.check().expect("a valid mesh");
    mesh
}

/// Lengths of all edges over what `asked` says at their middles: median, 5th and 95th percentile.
fn ratios(mesh: &TetMesh, asked: impl Fn(DVec3) -> f64) -> [f64; 3] {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for t in &mesh.tets {
        for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            edges.push([t[i].min(t[j]), t[i].max(t[j])]);
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let ratio = |e: &[u32; 2]| {
        let [p, q] = e.map(|v| mesh.points[v as usize]);
        p.distance(q) / asked((p + q) / 2.0)
    };
    let mut ratios: Vec<f64> = edges.iter().map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    [0.5, 0.05, 0.95].map(|share| ratios[((ratios.len() - 1) as f64 * share) as usize])
}

fn assert_met(mesh: &TetMesh, asked: impl Fn(DVec3) -> f64) {
    let [median, low, high] = ratios(mesh, asked);
    assert!((median - 1.0).abs() < 0.05, "{median}");
    assert!(low > 0.68 && high < 1.45, "{low} to {high}");
    let SizeRatio { median: said, p5, p95 } = mesh.size_ratio.expect("sizes vary");
    assert!((said - median).abs() < 0.02 && (p5 - low).abs() < 0.03 && (p95 - high).abs() < 0.03);
}

fn worst_angle(mesh: &TetMesh) -> f64 {
    tetcvt::quality::TetQuality::of(mesh).min_dihedral.iter().copied().fold(180.0, f64::min)
}

#[test]
fn a_cube_has_edges_from_one_to_five() {
    let asked = |p: DVec3| 0.04 + 0.16 * p.x;
    let mesh = mesh(&cube(), &sized(by("0.04 + 0.16*x")));
    assert_met(&mesh, asked);
    assert!((mesh.volume() - 1.0).abs() < 1e-9);
    assert!(worst_angle(&mesh) > 25.0, "{}", worst_angle(&mesh));
    // At either end, on the surface and inside alike.
    for x in [0.1, 0.5, 0.9] {
        let near = |t: &&[u32; 4]| t.iter().all(|&v| (mesh.points[v as usize].x - x).abs() < 0.12);
        let part = TetMesh { tets: mesh.tets.iter().filter(near).copied().collect(), ..mesh.clone() };
        let [median, ..] = ratios(&part, asked);
        assert!((median - 1.0).abs() < 0.1, "{median} at {x}");
    }
}

#[test]
fn a_sphere_is_refined_at_a_pole() {
    let surface = Shape::icosphere(4, 1.0).surface().expect("a sphere");
    let mesh = mesh(&surface, &sized(by("0.03 + 0.2*sqrt(x^2 + y^2 + (z - 1)^2)")));
    assert_met(&mesh, |p| 0.03 + 0.2 * p.distance(DVec3::Z));
    assert!(worst_angle(&mesh) > 25.0, "{}", worst_angle(&mesh));
}

#[test]
fn a_bunny_follows_its_curvature() {
    let surface = io::read_surface(Path::new("models/bunny.obj")).expect("a file of the project");
    let sizes = Sizes { curvature: Some(3.0), grade: Some(0.25), ..Sizes::default() };
    let mesh = mesh(&surface, &sized(sizes.clone()));
    let sizing = sizing(&surface, &sizes);
    let frame = *surface.frame();
    assert_met(&mesh, |p| frame.length_to_model(sizing.at((p - frame.shift) * frame.scale)));
}

#[test]
fn a_count_is_kept_and_sizes_become_relative() {
    let surface = cube();
    for boundary in [Boundary::Conform, Boundary::Free] {
        let params = Params { target: Target::Count(1200), boundary, ..sized(by("1 + 2*x")) };
        let mesh = mesh(&surface, &params);
        assert_eq!(mesh.points.len(), 1200);
        let median = mesh.size_ratio.expect("sizes vary").median;
        assert!((median - 1.0).abs() < 0.06, "{median}");
        let [scale, low, high] = ratios(&mesh, |p| 1.0 + 2.0 * p.x);
        assert!(low > 0.6 * scale && high < 1.7 * scale, "{low} {scale} {high}");
    }
}

#[test]
fn an_edge_is_the_largest_size() {
    let surface = cube();
    let capped = Params { target: Target::Edge(0.12), ..sized(by("0.05 + 0.2*x")) };
    let mesh = mesh(&surface, &capped);
    assert_met(&mesh, |p| (0.05 + 0.2 * p.x).min(0.12));
}

#[test]
fn every_start_meets_the_sizes() {
    let surface = cube();
    for start in [Start::Blue, Start::Random] {
        let params = Params { start, ..sized(by("0.08 + 0.12*z")) };
        let mesh = mesh(&surface, &params);
        let [median, ..] = ratios(&mesh, |p| 0.08 + 0.12 * p.z);
        assert!((median - 1.0).abs() < 0.05, "{start:?}: {median}");
    }
}

#[test]
fn the_mesh_does_not_depend_on_the_number_of_threads() {
    let surface = cube();
    let on = |threads| {
        let params = Params { threads, iterations: 12, ..sized(by("0.08 + 0.1*x + 0.05*y")) };
        let mesh = mesh(&surface, &params);
        let bits: Vec<u64> = mesh.points.iter().flat_map(|p| p.to_array().map(f64::to_bits)).collect();
        (bits, mesh.tets)
    };
    let one = on(1);
    assert!(one == on(2) && one == on(3));
}

#[test]
fn sizes_are_the_largest_below_those_asked_for_that_grow_slowly() {
    let surface = cube();
    // A fine ball in a coarse cube, with a steep step around it.
    let text = "0.02 + 0.2*min(1, max(0, 40*(sqrt((x - 0.3)^2 + (y - 0.4)^2 + (z - 0.5)^2) - 0.1)))";
    let center = DVec3::new(0.3, 0.4, 0.5);
    for grade in [0.1, 0.3] {
        let sizing = sizing(&surface, &Sizes { grade: Some(grade), ..by(text) });
        let frame = *surface.frame();
        let at = |p: DVec3| frame.length_to_model(sizing.at(frame.to_frame(p)));
        let mut rng = Rng(7);
        let (mut steepest, mut farthest, mut mean) = (0.0f64, 0.0f64, 0.0);
        for _ in 0..3000 {
            let p = rng.point() + 0.5;
            let expected = (0.02 + grade * (p.distance(center) - 0.1).max(0.0)).min(0.22);
            let off = (at(p) / expected - 1.0).abs();
            (farthest, mean) = (farthest.max(off), mean + off / 3000.0);
            let q = p.lerp(rng.point() + 0.5, 0.2);
            steepest = steepest.max((at(p) - at(q)).abs() / (p.distance(q) + 1e-3));
        }
        // The step is finer than leaves are, which are about as large as sizes: it is found to within one of them.
        assert!(mean < 0.05 && farthest < 0.5, "{grade}: {mean} {farthest}");
        // In a leaf each coordinate for itself grows no faster.
        assert!(steepest < 1.75 * grade, "{grade}: {steepest}");
    }
}

#[test]
fn sizes_are_continuous() {
    let surface = cube();
    let sizing = sizing(&surface, &by("0.02 + 0.2*abs(x - y + 0.3*z) + 0.1*z^2"));
    let mut rng = Rng(11);
    for _ in 0..200 {
        // Along a line, in steps far smaller than the leaves that it crosses.
        let frame = surface.frame();
        let [from, to] = [0, 1].map(|_| frame.to_frame(rng.point() + 0.5));
        let along = |i: u32| sizing.at(from.lerp(to, f64::from(i) / 4000.0));
        for i in 0..4000 {
            let step = from.distance(to) / 4000.0;
            assert!((along(i) - along(i + 1)).abs() < 0.6 * step + 1e-12, "{from} {to} {i}");
        }
    }
}

#[test]
fn numbers_on_a_mesh_are_sizes_too() {
    let corners: Vec<DVec3> =
        (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64)).collect();
    let tets = vec![[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];
    let sizes: Vec<f64> = corners.iter().map(|p| 0.07 + 0.1 * p.y).collect();
    let field = SizeMesh { points: corners, tets, sizes };
    let surface = cube();
    let from = |field| sizing(&surface, &Sizes { field: Some(field), ..Sizes::default() });
    let of_mesh = from(SizeField::Mesh(Arc::new(field.clone())));
    let of_text = from(SizeField::Expression("0.07 + 0.1*y".to_owned()));
    let mut rng = Rng(5);
    for _ in 0..300 {
        let p = surface.frame().to_frame(rng.point() + 0.5);
        assert!((of_mesh.at(p) / of_text.at(p) - 1.0).abs() < 0.02, "{p}");
    }
    // A mesh somewhere else.
    let elsewhere = SizeMesh { points: field.points.iter().map(|&p| p + 3.0).collect(), ..field };
    let params = sized(Sizes { field: Some(SizeField::Mesh(Arc::new(elsewhere))), ..Sizes::default() });
    match tetrahedralize(&surface, &params, &mut Silent) {
        Err(Error::Parameter { option: "size-field", reason }) => assert!(reason.contains("cover"), "{reason}"),
        other => panic!("{:?}", other.map(|m| m.points.len())),
    }
}

#[test]
fn weighted_moments_sum_to_those_of_the_solid() {
    let surface = cube();
    let sizing = sizing(&surface, &by("0.1 + 0.1*x"));
    let features = Features::find(&surface, 40.0);
    let params = Params { target: Target::Count(3000), ..Params::default() };
    let seeds = seeds::sample(&surface, &features, &params).expect("seeds");
    let delaunay = Delaunay::build(&seeds.positions).expect("distinct seeds");
    let even = Clipper::new(&surface).clip(&delaunay);
    // The surface's own triangles are as large as the cube: a finer one has the density on them as well.
    let mut clipper = Clipper::new(&surface);
    clipper.set_sizing(sizing.clone());
    let cells = clipper.clip(&delaunay).cells;
    for (cell, other) in cells.iter().zip(&even.cells) {
        assert!((cell.volume - other.volume).abs() < 1e-14 && (cell.area - other.area).abs() < 1e-13);
        if other.area > 0.0 {
            continue;
        }
        // The density where the mass is, to the second order of the cell.
        let density = cell.mass / cell.volume;
        assert!(cell.mass > 0.0 && cell.energy > 0.0 && density > 0.9 && density < 40.0);
    }
    // Inside, the mean of ρ = s^-5 over a cell is near its value at the centroid.
    for (i, (cell, other)) in cells.iter().zip(&even.cells).enumerate() {
        if other.area == 0.0 && seeds.anchors[i] == Anchor::Interior {
            let centroid = surface.frame().to_model(seeds.positions[i] + other.moment / other.volume);
            let relative: f64 = (0.1 + 0.1 * centroid.x) * surface.frame().scale / sizing.largest();
            let expected = relative.powi(-5) * other.volume;
            assert!((cell.mass / expected - 1.0).abs() < 0.05, "{centroid}: {} {expected}", cell.mass);
        }
    }
}

#[test]
fn sizes_that_no_run_could_honour_are_refused() {
    let surface = cube();
    let refused = |sizes: Sizes| match tetrahedralize(&surface, &sized(sizes), &mut Silent) {
        Err(Error::Parameter { option, reason }) => (option, reason),
        other => panic!("{:?}", other.map(|m| m.points.len())),
    };
    for text in ["0.1 - x", "0*x", "log(x - 0.5)", "1/0", "a + 1", "0.1 +", ""] {
        assert_eq!(refused(by(text)).0, "size-field", "{text}");
    }
    let (_, reason) = refused(by("0.5 - x"));
    assert!(reason.contains("not a positive number"), "{reason}");
    assert_eq!(refused(Sizes { curvature: Some(0.0), ..Sizes::default() }).0, "curvature");
    assert_eq!(refused(Sizes { curvature: Some(f64::NAN), ..Sizes::default() }).0, "curvature");
    assert_eq!(refused(Sizes { grade: Some(-1.0), ..by("0.1") }).0, "grade");
    assert_eq!(refused(Sizes::default()).0, "size-field");
    let alone = Params { sizes: Sizes { grade: Some(0.2), ..Sizes::default() }, ..Params::default() };
    assert!(matches!(alone.validate(), Err(Error::Parameter { option: "grade", .. })));
    // What is outside the solid does not matter.
    let sizing = sizing(&surface, &by("0.1 + 0.1*sqrt(x)"));
    assert!(sizing.at(surface.frame().to_frame(DVec3::splat(0.25))) > 0.0);
}

#[cfg(feature = "cli")]
mod program {
    use std::fs;

    use crate::cli::{folder_with_cube, tetcvt};

    /// A cube of six tets with a number on each corner.
    fn field(name: &str, sizes: [f64; 8]) -> String {
        let points: String = (0..8).map(|i| format!("{} {} {}\n", i & 1, i >> 1 & 1, i >> 2 & 1)).collect();
        let tets = ["0 1 3 7", "0 3 2 7", "0 2 6 7", "0 6 4 7", "0 4 5 7", "0 5 1 7"];
        let cells: String = tets.iter().map(|t| format!("4 {t}\n")).collect();
        let sizes: String = sizes.iter().map(|s| format!("{s}\n")).collect();
        format!(
            "# vtk DataFile Version 3.0\nsizes\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n{points}CELLS 6 30\n{cells}\
             CELL_TYPES 6\n10\n10\n10\n10\n10\n10\nPOINT_DATA 8\nSCALARS {name} double 1\nLOOKUP_TABLE default\n{sizes}"
        )
    }

    #[test]
    fn options_for_sizes_are_understood_or_refused() {
        let folder = folder_with_cube();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("good.vtk"), field("size", [0.1, 0.2, 0.1, 0.2, 0.1, 0.2, 0.1, 0.2])).unwrap();
        fs::write(at("unnamed.vtk"), field("h", [0.1; 8])).unwrap();
        fs::write(at("zero.vtk"), field("size", [0.0; 8])).unwrap();
        let run = |arguments: &[&str]| {
            let output =
                tetcvt(folder.path()).args(["cube.obj", "--iterations", "5"]).args(arguments).output().unwrap();
            (output.status.code(), String::from_utf8(output.stderr).unwrap())
        };
        for (arguments, status, says) in [
            (&["--size-field", "good.vtk"] as &[&str], 0, "sizes "),
            (&["--size-field", "0.1 + 0.1*x", "--edge", "15%", "--grade", "0.2"], 0, "sizes "),
            (&["--curvature", "--seeds", "400"], 0, "sizes "),
            (&["--size-field", "unnamed.vtk"], 3, "\"h\""),
            (&["--size-field", "zero.vtk"], 3, "not a positive number"),
            (&["--size-field", "missing.vtk"], 3, "missing.vtk"),
            (&["--size-field", "good.vtk", "-o", "good.vtk"], 2, "file of sizes"),
            (&["--size-field", "x - 0.5"], 2, "not a positive number"),
            (&["--size-field", "0.1 + w"], 2, "\"w\""),
            (&["--grade", "0.2"], 2, "--grade"),
            (&["--size-field", "0.1", "--grade", "0"], 2, "--grade"),
            (&["--curvature", "-1"], 2, "--curvature"),
        ] {
            let (found, text) = run(arguments);
            assert_eq!(found, Some(status), "{arguments:?}: {text}");
            assert!(text.contains(says), "{arguments:?}: {text}");
        }
    }
}
