//! Formats other than VTK's, tets of the second order and Voronoi cells, read back by the programs that they are for.

use std::fs;
use std::path::{Path, PathBuf};

use tetcvt::io::format::{Encoding, MeshFormat};
use tetcvt::io::{MeshData, write_mesh};
use tetcvt::quality::TetQuality;
use tetcvt::second_order::SecondOrder;
use tetcvt::surface::features::Features;
use tetcvt::{Error, io};

use crate::cli::{folder_with_cube, names, tetcvt};
use crate::output::{model, two_cubes, write_both};
use crate::python;
use crate::shapes::Shape;

#[test]
fn every_format_holds_the_same_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut files = vec![at("mesh.vtu"), at("surface.vtp")];
    write_both(&two_cubes(), &files[0], &files[1], Encoding::Binary);
    for (mesh_file, surface_file, encoding) in [
        ("a.msh", "a.stl", Encoding::Binary),
        ("b.msh", "b.stl", Encoding::Text),
        ("a.mesh", "a.ply", Encoding::Binary),
        ("a.inp", "b.ply", Encoding::Text),
        ("a.node", "a.obj", Encoding::Binary),
    ] {
        write_both(&two_cubes(), &at(mesh_file), &at(surface_file), encoding);
        files.extend([at(mesh_file), at(surface_file)]);
    }
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    python::run("check_formats.py", &files);
}

#[test]
fn numbers_in_text_read_back_to_the_last_bit() {
    let mut mesh = two_cubes();
    let [tiny, third, huge] = [5e-324, 1.0 / 3.0, 1.7976931348623157e308];
    mesh.points[0] = glam::DVec3::new(-tiny, third, huge);
    let folder = tempfile::tempdir().unwrap();
    let [file, surface] = ["a.mesh", "a.vtp"].map(|name| folder.path().join(name));
    write_both(&mesh, &file, &surface, Encoding::Binary);
    let text = fs::read_to_string(&file).unwrap();
    let line = text.lines().skip_while(|line| *line != "Vertices").nth(2).unwrap();
    let numbers: Vec<f64> = line.split(' ').take(3).map(|word| word.parse().unwrap()).collect();
    assert_eq!(numbers, [-tiny, third, huge]);
    assert!(line.len() < 80, "{line}");
}

#[test]
fn stl_refuses_what_single_precision_would_tear() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.stl");
    for (scale, offset, reason) in [(1e39, 0.0, "too large"), (1.0, 1e9, "fall together")] {
        let mut mesh = two_cubes();
        mesh.points.iter_mut().for_each(|p| *p = *p * scale + offset);
        let write = |encoding| io::write_surface(&file, io::format::SurfaceFormat::Stl, &mesh, encoding);
        assert!(matches!(write(Encoding::Binary), Err(Error::Write { reason: r, .. }) if r.contains(reason)));
        assert!(!file.exists());
        write(Encoding::Text).unwrap();
        fs::remove_file(&file).unwrap();
    }
}

/// Numbers that a library's user may give but no format can hold are an error, not a panic; the largest that fit are written.
#[test]
fn numbers_beyond_signed_integers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |mesh: &tetcvt::TetMesh, name: &str| {
        let path = folder.path().join(name);
        match (MeshFormat::of(&path), io::format::SurfaceFormat::of(&path)) {
            (Some(format), _) => {
                let quality = TetQuality::of(mesh);
                let data = MeshData { mesh, quality: &quality, second_order: None, encoding: Encoding::Binary };
                write_mesh(&path, format, &data)
            }
            (None, format) => io::write_surface(&path, format.unwrap(), mesh, Encoding::Binary),
        }
    };
    let largest = i32::MAX as u32 - 1;
    type Damage = (&'static str, fn(&mut tetcvt::TetMesh, u32));
    let damages: [Damage; 3] = [
        ("patch", |m, id| m.boundary[5].patch = id),
        ("region", |m, id| m.regions[5] = id),
        ("source triangle", |m, id| m.boundary[5].source_triangle = id),
    ];
    for (what, damage) in damages {
        for name in ["a.vtu", "a.vtk", "a.msh", "a.mesh", "a.inp", "a.node", "a.vtp", "a.obj", "a.ply"] {
            let mut mesh = two_cubes();
            damage(&mut mesh, largest);
            write(&mesh, name).unwrap_or_else(|e| panic!("{name} {what}: {e}"));
            damage(&mut mesh, largest + 1);
            let Err(Error::Write { reason, .. }) = write(&mesh, name) else { panic!("{name} {what} is written") };
            assert!(reason.starts_with(&format!("{what} 2147483647 is over")), "{reason}");
        }
    }
}

/// Runs the program on `model` in `folder`.
fn mesh(folder: &Path, model: &Path, arguments: &[&str]) {
    tetcvt(folder).arg(model).args(arguments).arg("--quiet").assert().success();
}

/// A sphere of radius 1, its vertices on it: an icosahedron cut `levels` times.
fn sphere(levels: u32) -> String {
    Shape::icosphere(levels, 1.0).obj_with("sphere", |x| format!("{x:?}"))
}

#[test]
fn tets_of_the_second_order_follow_the_surface_and_do_not_fold() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("sphere.obj");
    fs::write(&model, sphere(5)).unwrap();
    let files: Vec<PathBuf> = ["a.vtu", "a.vtk", "a.msh", "a.inp"].map(|name| folder.path().join(name)).to_vec();
    for file in &files {
        let name = file.file_name().unwrap().to_str().unwrap();
        mesh(folder.path(), &model, &["--seeds", "200", "--iterations", "5", "--second-order", "-o", name]);
    }
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    python::run("check_second_order.py", &files);
}

#[test]
fn nodes_on_creases_stay_on_them_and_on_flat_faces_in_them() {
    let surface = io::read_surface(&model("cube.obj")).unwrap();
    let params =
        tetcvt::Params { target: tetcvt::params::Target::Count(300), iterations: 3, ..tetcvt::Params::default() };
    let mesh = tetcvt::tetrahedralize(&surface, &params, &mut tetcvt::progress::Silent).unwrap();
    let nodes = SecondOrder::of(&mesh, &surface, &Features::find(&surface, 40.0));
    assert_eq!(nodes.held_back, 0);
    let sides = |p: &glam::DVec3| p.to_array().iter().filter(|x| (x.abs() - 1.0).abs() < 1e-12).count();
    for (p, kind) in nodes.points.iter().zip(&nodes.kinds) {
        assert_eq!(sides(p), *kind as usize, "{p}");
    }
    // 12 edges of the cube: between n nodes there are n + 1 stretches.
    let curves = mesh.count(tetcvt::seeds::SeedKind::Curve);
    assert_eq!(nodes.kinds.iter().filter(|&&k| k == tetcvt::seeds::SeedKind::Curve).count(), curves + 12);
    let quality = TetQuality::of(&mesh);
    let data = MeshData { mesh: &mesh, quality: &quality, second_order: Some(&nodes), encoding: Encoding::Binary };
    let folder = tempfile::tempdir().unwrap();
    let refused = write_mesh(&folder.path().join("a.mesh"), MeshFormat::Medit, &data);
    assert!(matches!(refused, Err(Error::Write { .. })));
}

#[test]
fn finite_elements_converge_at_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("sphere.obj"), sphere(6)).unwrap();
    let few = ["--iterations", "10", "--seeds"];
    let mut files = Vec::new();
    for n in ["150", "400", "1000"] {
        let name = format!("cube{n}.vtu");
        mesh(folder.path(), &model("cube.obj"), &[&few[..], &[n, "-o", &name]].concat());
        files.push(at(&name));
    }
    let run = |problem: [&str; 3], files: &[PathBuf]| {
        let arguments = problem.map(Path::new).into_iter().chain(files.iter().map(PathBuf::as_path));
        python::run("check_poisson.py", &arguments.collect::<Vec<_>>());
    };
    run(["cube", "2", "3"], &files);
    files.clear();
    for n in ["80", "200", "500"] {
        let name = format!("ball{n}.msh");
        mesh(folder.path(), &at("sphere.obj"), &[&few[..], &[n, "--second-order", "-o", &name]].concat());
        files.push(at(&name));
    }
    run(["ball", "-", "3.3"], &files);
}

#[test]
fn voronoi_cells_close_conform_and_have_their_volumes() {
    for (name, seeds, volume) in
        [("bunny.obj", "400", None), ("hollow_cube.obj", "500", None), ("cube.obj", "60", Some("8"))]
    {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let arguments = [
            "--no-improve",
            "--iterations",
            "3",
            "--voronoi",
            "c.vtu",
            "-o",
            "m.vtu",
            "--json",
            "r.json",
            "--seeds",
            seeds,
        ];
        mesh(folder.path(), &model(name), &arguments);
        let report: serde_json::Value = serde_json::from_slice(&fs::read(at("r.json")).unwrap()).unwrap();
        let volume = volume.map_or_else(|| report["input"]["volume"].to_string(), str::to_owned);
        python::run("check_voronoi.py", &[&at("c.vtu"), &at("m.vtu"), Path::new(&volume)]);
    }
}

#[test]
fn what_is_asked_for_in_vain_is_refused_before_any_work() {
    let folder = folder_with_cube();
    for (arguments, named) in [
        (&["-o", "a.xyz"][..], ".node or .ele"),
        (&["--surface", "a.vtu"], ".stl or .ply"),
        (&["--voronoi", "a.vtk"], "--voronoi"),
        (&["--second-order", "-o", "a.mesh"], "--second-order"),
        (&["--ascii"], "--ascii"),
        (&["-o", "a.vtk", "--seeds", "90000000"], "--output"),
        (&["-o", "a.ele", "--json", "a.face"], "--json"),
        (&["-o", "cube.node", "--trajectory", "cube.obj"], "--trajectory"),
    ] {
        let output = tetcvt(folder.path()).arg("cube.obj").args(arguments).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.starts_with("error: ") && stderr.contains(named), "{arguments:?}: {stderr}");
        assert_eq!(names(folder.path()), ["cube.obj"], "{arguments:?}");
    }
}

#[test]
fn the_surface_of_a_mesh_can_be_meshed_again() {
    let folder = folder_with_cube();
    mesh(
        folder.path(),
        Path::new("cube.obj"),
        &["--seeds", "200", "--iterations", "2", "-o", "a.ele", "--surface", "b.obj"],
    );
    assert_eq!(names(folder.path()), ["a.ele", "a.face", "a.node", "b.obj", "cube.obj"]);
    mesh(folder.path(), Path::new("b.obj"), &["--seeds", "200", "--iterations", "2"]);
    assert!(folder.path().join("b.vtu").exists());
}
