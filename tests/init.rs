//! Meshes from the points of earlier ones: identity, kinds, what is refused; and a motion, frame by frame.

#[cfg(feature = "cli")]
use std::fs;
use std::path::Path;

use glam::{DQuat, DVec3};
use tetcvt::params::{Boundary, Target};
use tetcvt::progress::Silent;
use tetcvt::seeds::{InitialPoints, SeedKind};
use tetcvt::{Error, Params, Surface, TetMesh, io, tetrahedralize, tetrahedralize_from};

fn params(count: usize, iterations: usize) -> Params {
    Params { target: Target::Count(count), iterations, ..Params::default() }
}

fn points_of(mesh: &TetMesh) -> InitialPoints {
    InitialPoints { points: mesh.points.clone(), kinds: mesh.kinds.clone() }
}

/// The faces of a model with its points moved.
fn moved(model: &str, way: impl Fn(DVec3) -> DVec3) -> Surface {
    let soup = io::load_surface(Path::new(model)).expect("a file of the project");
    let points: Vec<DVec3> = soup.points().iter().map(|&p| way(p)).collect();
    Surface::new(&points, soup.triangles(), soup.source(), soup.patch()).expect("a motion that keeps it whole")
}

/// The bunny, twisted about its upright axis by so many degrees from foot to ear.
fn twisted_bunny(degrees: f64) -> Surface {
    let soup = io::load_surface(Path::new("models/bunny.obj")).expect("a file of the project");
    let (min, max) =
        soup.points().iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let center = (min + max) / 2.0;
    moved("models/bunny.obj", |p| {
        let angle = degrees.to_radians() * (p.y - min.y) / (max.y - min.y);
        center + DQuat::from_rotation_y(angle) * (p - center)
    })
}

fn distances(a: &TetMesh, b: &TetMesh) -> Vec<f64> {
    let mut distances: Vec<f64> = a.points.iter().zip(&b.points).map(|(p, q)| p.distance(*q)).collect();
    distances.sort_by(f64::total_cmp);
    distances
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn mean_edge(mesh: &TetMesh) -> f64 {
    let edges = mesh.tets.iter().flat_map(|t| [[t[0], t[1]], [t[2], t[3]], [t[0], t[3]]]);
    mean(&edges.map(|e| mesh.points[e[0] as usize].distance(mesh.points[e[1] as usize])).collect::<Vec<_>>())
}

/// Everything that a mesh from earlier points promises.
fn check(mesh: &TetMesh, surface: &Surface, count: usize) {
    mesh.check().expect("a valid mesh");
    assert_eq!(mesh.points.len(), count);
    assert!(mesh.seeds.iter().copied().eq(0..count as u32), "vertex i is seed i");
    let mut on_boundary = vec![false; count];
    mesh.boundary.iter().flat_map(|t| t.vertices).for_each(|v| on_boundary[v as usize] = true);
    let frame = surface.frame();
    for (v, &kind) in mesh.kinds.iter().enumerate() {
        let distance = surface.tree().closest(frame.to_frame(mesh.points[v])).distance2.sqrt();
        if kind != SeedKind::Interior {
            assert!(on_boundary[v] && distance < 1e-12, "vertex {v}, {kind:?}, is {distance} off the surface");
        }
    }
}

/// So many frames of a twist of 60 degrees, each from the one before.
fn follow_twist(count: usize, frames: usize, shown: usize) {
    let start = params(count, 20);
    let mut before = tetrahedralize(&twisted_bunny(0.0), &start, &mut Silent).expect("a mesh");
    let mut remeshed = before.clone();
    for frame in 1..=shown {
        let surface = twisted_bunny(60.0 * frame as f64 / frames as f64);
        let mesh = tetrahedralize_from(&surface, &points_of(&before), &params(count, 8), &mut Silent).expect("a mesh");
        check(&mesh, &surface, count);
        // Most stay by far closer than the next vertex, and none goes to the other end.
        let (ways, edge) = (distances(&before, &mesh), mean_edge(&mesh));
        assert!(ways[count / 2] < 0.25 * edge, "frame {frame}: {} of {edge}", ways[count / 2]);
        assert!(ways[count * 99 / 100] < 1.5 * edge, "frame {frame}: {} of {edge}", ways[count * 99 / 100]);
        if frame <= 2 {
            let again = tetrahedralize(&surface, &start, &mut Silent).expect("a mesh");
            assert!(mean(&ways) < 0.25 * mean(&distances(&remeshed, &again)), "frame {frame}");
            let volume = |m: &TetMesh| (m.volume() - surface_volume(&surface)).abs() / surface_volume(&surface);
            assert!(volume(&mesh) < volume(&again) + 0.01, "frame {frame}: {} {}", volume(&mesh), volume(&again));
            remeshed = again;
        }
        before = mesh;
    }
}

fn surface_volume(surface: &Surface) -> f64 {
    surface.volume() / surface.frame().scale.powi(3)
}

#[test]
fn a_twisted_bunny_is_followed_vertex_by_vertex() {
    follow_twist(1500, 20, 4);
}

#[test]
#[ignore = "20 frames take a while"]
fn a_twisted_bunny_is_followed_over_20_frames() {
    follow_twist(1500, 20, 20);
}

#[test]
fn corners_and_creases_of_a_sheared_cube_keep_their_vertices() {
    let cube = moved("models/cube.obj", |p| p);
    let before = tetrahedralize(&cube, &params(400, 15), &mut Silent).expect("a mesh");
    let shear = |p: DVec3| DVec3::new(p.x + 0.1 * p.z, p.y, 1.05 * p.z);
    let sheared = moved("models/cube.obj", shear);
    let mesh = tetrahedralize_from(&sheared, &points_of(&before), &params(400, 8), &mut Silent).expect("a mesh");
    check(&mesh, &sheared, 400);
    assert_eq!(mesh.count(SeedKind::Corner), 8);
    for v in (0..400).filter(|&v| before.kinds[v] == SeedKind::Corner) {
        assert_eq!(mesh.kinds[v], SeedKind::Corner);
        assert!(mesh.points[v].distance(shear(before.points[v])) < 1e-12);
    }
    // Creases whole: so is the volume.
    assert!((mesh.volume() / (8.0 * 1.05) - 1.0).abs() < 1e-9, "{}", mesh.volume());
}

#[test]
fn kinds_are_found_where_they_are_not_given() {
    let cube = moved("models/cube.obj", |p| p);
    let before = tetrahedralize(&cube, &params(300, 10), &mut Silent).expect("a mesh");
    let bare = InitialPoints { points: before.points.clone(), kinds: Vec::new() };
    let mesh = tetrahedralize_from(&cube, &bare, &params(300, 0), &mut Silent).expect("a mesh");
    check(&mesh, &cube, 300);
    let same = mesh.kinds.iter().zip(&before.kinds).filter(|(a, b)| a == b).count();
    assert!(same >= 285, "{same} of 300 kinds alike");
    assert_eq!(mesh.count(SeedKind::Corner), 8);
}

#[test]
fn points_outside_and_in_one_place_become_a_mesh_too() {
    let sphere = moved("models/icosphere.obj", |p| p);
    let before = tetrahedralize(&sphere, &params(300, 10), &mut Silent).expect("a mesh");
    let mut initial = points_of(&before);
    let inside: Vec<usize> = (0..300).filter(|&v| before.kinds[v] == SeedKind::Interior).collect();
    initial.points[inside[0]] = DVec3::new(5.0, 0.0, 0.0);
    for &v in &inside[1..4] {
        initial.points[v] = initial.points[inside[1]];
    }
    for boundary in [Boundary::Conform, Boundary::Free] {
        let params = Params { boundary, ..params(300, 8) };
        let mesh = tetrahedralize_from(&sphere, &initial, &params, &mut Silent).expect("a mesh");
        mesh.check().expect("a valid mesh");
        assert_eq!(mesh.points.len(), 300);
    }
}

#[test]
fn the_result_does_not_depend_on_the_threads() {
    let before = tetrahedralize(&twisted_bunny(0.0), &params(600, 5), &mut Silent).expect("a mesh");
    let surface = twisted_bunny(5.0);
    let run = |threads| {
        let params = Params { threads, ..params(600, 5) };
        tetrahedralize_from(&surface, &points_of(&before), &params, &mut Silent).expect("a mesh")
    };
    let (one, four) = (run(1), run(4));
    assert_eq!(one.points, four.points);
    assert_eq!(one.tets, four.tets);
}

#[test]
fn what_is_no_start_is_refused() {
    let cube = moved("models/cube.obj", |p| p);
    let option =
        |initial: &InitialPoints, count| match tetrahedralize_from(&cube, initial, &params(count, 1), &mut Silent) {
            Err(Error::Parameter { option, .. }) => option,
            other => panic!("{other:?}"),
        };
    let at = |p: DVec3| InitialPoints { points: vec![p; 20], kinds: Vec::new() };
    assert_eq!(option(&at(DVec3::ZERO), 21), "seeds");
    assert_eq!(option(&at(DVec3::splat(100.0)), 20), "init");
    assert_eq!(option(&at(DVec3::splat(f64::NAN)), 20), "init");
    assert_eq!(option(&InitialPoints { kinds: vec![SeedKind::Corner], ..at(DVec3::ZERO) }, 20), "init");
    assert_eq!(option(&InitialPoints { points: vec![DVec3::ZERO; 3], kinds: Vec::new() }, 20), "init");
}

#[cfg(feature = "cli")]
mod program {
    use super::*;
    use crate::cli::{folder_with_cube, tetcvt};

    fn status(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
        let output = tetcvt(folder).args(arguments).output().expect("the program runs");
        (output.status.code(), String::from_utf8(output.stderr).expect("text"))
    }

    #[test]
    fn both_formats_of_vtk_lead_to_the_same_mesh() {
        let folder = folder_with_cube();
        let folder = folder.path();
        for mesh in ["a.vtu", "a.vtk"] {
            assert_eq!(status(folder, &["cube.obj", "--seeds", "200", "--iterations", "4", "-o", mesh]).0, Some(0));
        }
        let from = |mesh: &str, out: &str| {
            let (status, message) = status(folder, &["cube.obj", "--init", mesh, "--seeds", "200", "-o", out]);
            assert_eq!(status, Some(0), "{message}");
            fs::read(folder.join(out)).expect("a mesh")
        };
        let first = from("a.vtu", "b.vtu");
        assert_eq!(first, from("a.vtk", "c.vtu"));
        let before = io::read_initial(&folder.join("a.vtu")).expect("points");
        let after = io::read_initial(&folder.join("b.vtu")).expect("points");
        assert_eq!((before.points.len(), after.points.len()), (200, 200));
        let close = before.points.iter().zip(&after.points).filter(|(p, q)| p.distance(**q) < 0.1).count();
        assert!(close > 190, "{close}");
    }

    #[test]
    fn what_cannot_be_a_start_ends_with_its_status() {
        let folder = folder_with_cube();
        let folder = folder.path();
        let made = ["cube.obj", "--seeds", "100", "--iterations", "2", "-o", "a.vtu"];
        assert_eq!(status(folder, &made).0, Some(0));
        assert_eq!(status(folder, &["cube.obj", "--init", "a.vtu", "--second-order", "-o", "q.vtu"]).0, Some(0));
        fs::write(folder.join("text.vtu"), "nothing").expect("a file");
        let cases: [(&[&str], i32, &str); 8] = [
            (&["--init", "a.vtu", "--seeds", "101"], 2, "100 points"),
            (&["--init", "a.vtu", "--edge", "0.1"], 2, "--edge"),
            (&["--init", "a.vtu", "--start", "blue"], 2, "--start"),
            (&["--init", "a.vtu", "-o", "a.vtu"], 2, "a.vtu is the mesh to start from"),
            (&["--init", "none.vtu"], 3, "none.vtu"),
            (&["--init", "text.vtu"], 3, "text.vtu"),
            (&["--init", "cube.obj"], 3, ".vtu and .vtk"),
            (&["--init", "q.vtu"], 3, "seed is -1"),
        ];
        for (arguments, wanted, word) in cases {
            let (status, message) = status(folder, &[&["cube.obj"], arguments].concat());
            assert_eq!(status, Some(wanted), "{arguments:?}: {message}");
            assert!(message.contains(word), "{arguments:?}: {message}");
        }
    }
}
