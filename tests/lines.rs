//! Lines of the user's on a surface: imprinted without moving it, and edges of the mesh in the end.

#[cfg(feature = "cli")]
use std::fs;
use std::path::Path;

use glam::DVec3;
use tetcvt::params::Target;
use tetcvt::progress::Silent;
use tetcvt::seeds::SeedKind;
use tetcvt::surface::features::Features;
use tetcvt::surface::imprint::{LineError, Polyline};
use tetcvt::{Params, Surface, TetMesh, tetrahedralize};

#[cfg(feature = "cli")]
use crate::cli::{folder_with_cube, tetcvt};
use crate::shapes::Shape;

fn line(points: &[DVec3]) -> Polyline {
    Polyline { points: points.to_vec(), line: 7 }
}

/// A great circle of the unit sphere, tilted, of so many vertices.
fn great_circle(vertices: u32) -> Polyline {
    let (u, v) = (DVec3::new(1.0, 0.3, -0.2).normalize(), DVec3::new(0.1, 1.0, 0.5));
    let v = (v - u * u.dot(v)).normalize();
    let at = |i: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i % vertices) / f64::from(vertices)).sin_cos();
        u * cos + v * sin
    };
    line(&(0..=vertices).map(at).collect::<Vec<_>>())
}

fn meshed(surface: &Surface, count: usize) -> TetMesh {
    let params = Params { target: Target::Count(count), iterations: 20, ..Params::default() };
    tetrahedralize(surface, &params, &mut Silent).expect("a mesh")
}

/// The chain of boundary edges over the vertices of kinds 2 and 3 that lie on `curve`: its vertices, in order.
///
/// Every edge between consecutive ones must be an edge of the boundary.
fn chain(surface: &Surface, mesh: &TetMesh, curve: &tetcvt::surface::features::Curve) -> Vec<u32> {
    let frame = surface.frame();
    let mut on_curve: Vec<(f64, u32)> = (0..mesh.points.len() as u32)
        .filter(|&v| matches!(mesh.kinds[v as usize], SeedKind::Curve | SeedKind::Corner))
        .filter_map(|v| {
            let (at, distance2) = curve.closest(frame.to_frame(mesh.points[v as usize]), surface.points());
            (distance2 < 1e-24).then_some((at, v))
        })
        .collect();
    on_curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut chain: Vec<u32> = on_curve.into_iter().map(|(_, v)| v).collect();
    if curve.is_closed() {
        chain.push(chain[0]);
    }
    for edge in chain.windows(2) {
        let has = |v: u32, f: &[u32; 3]| f.contains(&v);
        let found = mesh.boundary.iter().filter(|f| has(edge[0], &f.vertices) && has(edge[1], &f.vertices)).count();
        assert_eq!(found, 2, "the line is no edge of the mesh at {}", mesh.points[edge[0] as usize]);
    }
    chain
}

#[test]
fn a_great_circle_is_a_chain_of_edges() {
    let plain = Shape::icosphere(3, 1.0).surface().expect("a sphere");
    let (volume, area, triangles) = (plain.volume(), plain.area(), plain.triangles().len());
    let circle = great_circle(48);
    let surface = plain.with_features(std::slice::from_ref(&circle)).expect("a line on the sphere");
    // Cut, but the same.
    assert!(surface.triangles().len() > triangles + 48);
    assert!((surface.volume() / volume - 1.0).abs() < 1e-15 && (surface.area() / area - 1.0).abs() < 1e-15);
    let sum: f64 = (0..surface.triangles().len() as u32).map(|t| surface.normal2(t).length() / 2.0).sum();
    assert!((sum / area - 1.0).abs() < 1e-12);
    assert!(surface.source().iter().all(|&s| (s as usize) < triangles));

    let features = Features::find(&surface, 40.0);
    assert!(features.corners.is_empty() && features.curves.len() == 1 && features.curves[0].is_closed());
    assert!((features.curves[0].length() / surface.frame().scale / std::f64::consts::TAU - 1.0).abs() < 0.01);
    let mesh = meshed(&surface, 1500);
    let chain = chain(&surface, &mesh, &features.curves[0]);
    assert!(chain.len() > 30, "{}", chain.len());
    // All of them in the plane of the circle, but for what going straight to the sphere's facets leads astray.
    let normal = circle.points[0].cross(circle.points[5]).normalize();
    assert!(chain.iter().all(|&v| mesh.points[v as usize].dot(normal).abs() < 1e-3));
    // The two hemispheres are patches.
    let patches: std::collections::BTreeSet<u32> = mesh.boundary.iter().map(|f| f.patch).collect();
    assert_eq!(patches.len(), 2);
    for f in &mesh.boundary {
        let center: DVec3 = f.vertices.iter().map(|&v| mesh.points[v as usize]).sum();
        let first = mesh.boundary[0].vertices.iter().map(|&v| mesh.points[v as usize]).sum::<DVec3>();
        assert_eq!(f.patch == mesh.boundary[0].patch, (center.dot(normal) > 0.0) == (first.dot(normal) > 0.0));
    }
}

#[test]
fn a_line_across_a_side_of_the_cube_ends_at_corners() {
    // Neither end on a corner or edge of the cube, two triangles and a point above the side on the way.
    let ends = [DVec3::new(-0.7, -0.2, 1.0), DVec3::new(0.8, 0.5, 1.0)];
    let middle = DVec3::new(0.1, 0.3, 1.005);
    let surface = Shape::cube().surface().expect("a cube");
    let surface = surface.with_features(&[line(&[ends[0], middle, ends[1]])]).expect("a line");
    let features = Features::find(&surface, 40.0);
    assert_eq!((features.corners.len(), features.curves.len()), (10, 13));
    assert_eq!(features.face.iter().max(), Some(&5), "a line that ends on a side does not part it");
    let mesh = meshed(&surface, 800);
    let curve = features.curves.iter().find(|c| c.is_given).expect("the line");
    let chain = chain(&surface, &mesh, curve);
    let place = |v: u32| mesh.points[v as usize];
    let first = if place(chain[0]).distance(ends[0]) < 1e-12 { 0 } else { 1 };
    for (v, end) in [(chain[0], ends[first]), (chain[chain.len() - 1], ends[1 - first])] {
        assert!(place(v).distance(end) < 1e-12);
        assert_eq!(mesh.kinds[v as usize], SeedKind::Corner);
    }
    let inner = &chain[1..chain.len() - 1];
    assert!(inner.iter().all(|&v| mesh.kinds[v as usize] == SeedKind::Curve && place(v).z == 1.0));
    // The middle one is where the line bends.
    assert!(inner.iter().any(|&v| place(v).distance(DVec3::new(0.1, 0.3, 1.0)) < 1e-12));
}

#[test]
fn lines_cross_each_other_and_creases() {
    let over_the_edge = line(&[DVec3::new(-0.5, 0.1, 1.0), DVec3::new(1.0, 0.1, 0.4), DVec3::new(1.0, -0.6, -0.3)]);
    let crossing = line(&[DVec3::new(0.2, -0.8, 1.0), DVec3::new(0.3, 0.9, 1.0)]);
    let diagonal = line(&[DVec3::new(-1.0, -1.0, 1.0), DVec3::new(1.0, 1.0, 1.0)]);
    let surface = Shape::cube().surface().expect("a cube");
    // The way over the edge bends far off the straight line: that is another line than the one asked for.
    let refused = surface.with_features(std::slice::from_ref(&over_the_edge));
    assert!(matches!(refused, Err(LineError::Leaves { line: 7, .. })));
    let surface = Shape::cube().surface().expect("a cube");
    let along = line(&[
        DVec3::new(-0.5, 0.1, 1.0),
        DVec3::new(1.0, 0.1, 1.0),
        DVec3::new(1.0, 0.1, 0.4),
        DVec3::new(1.0, -0.6, -0.3),
    ]);
    let surface = surface.with_features(&[along, crossing, diagonal]).expect("lines");
    let features = Features::find(&surface, 40.0);
    // Eight of the cube, five ends (the diagonal's are two of the eight), two on an edge or sharply bent, and three crossings.
    let given = features.curves.iter().filter(|c| c.is_given).count();
    let frame = surface.frame();
    let corners: Vec<DVec3> = features.corners.iter().map(|&v| frame.to_model(surface.points()[v as usize])).collect();
    let has = |p: DVec3| corners.iter().any(|c| c.distance(p) < 1e-9);
    assert!(has(DVec3::new(0.1, 0.1, 1.0)), "the diagonal meets the first line there: {corners:?}");
    assert!(has(DVec3::new(1.0, 0.1, 1.0)), "a line over an edge makes a corner");
    assert!(given >= 9, "{given}");
    let mesh = meshed(&surface, 1500);
    for curve in features.curves.iter().filter(|c| c.is_given) {
        chain(&surface, &mesh, curve);
    }
}

#[test]
fn a_loop_around_the_bunny_is_kept() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/bunny.obj");
    let surface = tetcvt::io::read_surface(&path).expect("the bunny");
    // Out from a point inside, in a plane.
    let (low, high) = surface.points().iter().fold((DVec3::MAX, DVec3::MIN), |(l, h), &p| (l.min(p), h.max(p)));
    let center = low.lerp(high, 0.35);
    assert!(surface.tree().is_inside(center));
    let outward = |i: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i % 90) / 90.0).sin_cos();
        let direction = DVec3::new(cos, 0.0, sin);
        let (t, _) = surface.tree().ray(center, direction, 2.0).expect("the surface is closed");
        surface.frame().to_model(center + t * direction)
    };
    let ring = line(&(0..=90).map(outward).collect::<Vec<_>>());
    let surface = surface.with_features(&[ring]).expect("a line on the bunny");
    let features = Features::find(&surface, 180.0);
    assert_eq!((features.corners.len(), features.curves.len()), (0, 1));
    assert_eq!(features.face.iter().max(), Some(&1));
    let params = Params { target: Target::Count(2500), iterations: 15, feature_angle: 180.0, ..Params::default() };
    let mesh = tetrahedralize(&surface, &params, &mut Silent).expect("a mesh");
    assert!(chain(&surface, &mesh, &features.curves[0]).len() > 30);
}

#[test]
fn what_is_not_on_the_surface_is_refused_with_its_place() {
    let cube = || Shape::cube().surface().expect("a cube");
    let off = cube().with_features(&[line(&[DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.5, 0.25, 1.25)])]);
    let error = off.err().expect("a point off the surface");
    assert!(
        matches!(error, LineError::OffSurface { line: 7, place: [0.5, 0.25, 1.25], distance: 0.25, .. }),
        "{error}"
    );
    assert!(matches!(cube().with_features(&[line(&[DVec3::Z; 2])]), Err(LineError::NoLength { line: 7 })));
    let nan = line(&[DVec3::Z, DVec3::NAN]);
    assert!(matches!(cube().with_features(&[nan]), Err(LineError::NotFinite { vertex: 2, .. })));
    // Straight through the solid.
    let through = line(&[DVec3::new(0.1, 0.2, 1.0), DVec3::new(0.1, 0.3, -1.0)]);
    assert!(matches!(cube().with_features(&[through]), Err(LineError::Leaves { .. })));
}

#[cfg(feature = "cli")]
#[test]
fn the_program_keeps_lines_and_refuses_those_off_the_surface() {
    let folder = folder_with_cube();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a writable folder");
    write("lines.obj", "v 0.1 0.1 1\nv 0.8 0.7 1\n# a line on the top\nl 1 2\n");
    write("off.obj", "v 0.1 0.1 1\n\nv 0.8 0.7 1.5\nl 1 2\n");
    write("faces.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let run = |arguments: &[&str]| {
        let base = ["cube.obj", "--seeds", "300", "--iterations", "3", "--features"];
        tetcvt(folder.path()).args(base).args(arguments).output().expect("the program runs")
    };
    let kept = run(&["lines.obj", "--json", "-"]);
    assert!(kept.status.success(), "{}", String::from_utf8_lossy(&kept.stderr));
    let report: serde_json::Value = serde_json::from_slice(&kept.stdout).expect("JSON");
    assert_eq!(report["mesh"]["corner_seeds"], 10);
    assert_eq!(report["input"]["triangles"], 12);
    for (arguments, status, says) in [
        (&["off.obj"][..], 2, "--features: line 4: the point (0.8, 0.7, 1.5)"),
        (&["faces.obj"], 3, "no lines"),
        (&["missing.obj"], 3, "missing.obj"),
        (&["lines.obj", "--boundary", "free"], 2, "--features"),
        (&["lines.obj", "-o", "lines.obj"], 2, "--output"),
    ] {
        let refused = run(arguments);
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(status), "{said}");
        assert!(said.contains(says), "{said}");
    }
}
