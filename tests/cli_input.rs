//! The binary on surfaces of every kind: statuses, files of defects, `--repair`; files that other programs write.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use tetcvt::io;

use crate::python;

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models")
}

/// Runs the program in `folder`, on few seeds; returns the status and what it said.
fn run(folder: &Path, surface: &Path, more: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::cargo_bin("tetcvt").expect("the binary");
    let command = command.current_dir(folder).arg(surface).args(["--seeds", "300", "--iterations", "0"]).args(more);
    let output = command.output().expect("it runs");
    assert!(output.stdout.is_empty());
    (output.status.code(), String::from_utf8(output.stderr).expect("text"))
}

#[test]
fn every_bad_file_ends_with_its_status_and_shows_its_defects() {
    let table = fs::read_to_string(models().join("bad/README.md")).expect("the table");
    let folder = tempfile::tempdir().expect("a folder");
    let mut shown = vec![];
    for row in table.lines().filter(|l| l.contains(".obj |")) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [file, _, status, words] = cells[..] else { panic!("{row}") };
        // What is mended makes a mesh, which takes its time; the library's tests see to it.
        if status == "0" {
            continue;
        }
        let (got, text) = run(folder.path(), &models().join("bad").join(file), &["-q"]);
        assert_eq!(got.map(|s| s.to_string()).as_deref(), Some(status), "{file}: {text}");
        assert!(text.starts_with("error: ") && text.contains(words), "{file}: {text}");
        assert_eq!(text.lines().count(), 1, "{file}: {text}");
        let marks = folder.path().join(file.replace(".obj", ".defects.vtp"));
        if marks.exists() {
            assert_eq!(status, "1", "{file}");
            shown.push(file.replace(".obj", ""));
            fs::remove_file(marks).expect("it goes");
        }
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0, "{file}");
    }
    shown.sort();
    let wanted = [
        "crossing_spheres",
        "duplicate_face",
        "flat",
        "inner_wall",
        "klein_bottle",
        "non_manifold_edge",
        "non_manifold_vertex",
        "open",
        "standing_cube",
        "standing_tip",
        "touching_cubes",
        "touching_cubes_crossed",
    ];
    assert_eq!(shown, wanted);
}

#[test]
fn defects_are_where_paraview_finds_them() {
    let folder = tempfile::tempdir().expect("a folder");
    for (file, kind, defect, count) in [
        ("open", "lines", "1", "3"),
        ("non_manifold_edge", "lines", "2", "1"),
        ("non_manifold_vertex", "verts", "3", "1"),
        ("touching_cubes", "polys", "5", "2"),
        ("standing_tip", "polys", "6", "4"),
        ("flat", "polys", "8", "4"),
    ] {
        let (status, text) = run(folder.path(), &models().join(format!("bad/{file}.obj")), &[]);
        assert_eq!(status, Some(1), "{text}");
        assert!(text.contains(&format!("wrote      {file}.defects.vtp")), "{text}");
        let marks = folder.path().join(format!("{file}.defects.vtp"));
        python::run("check_defects.py", &[&marks, Path::new(kind), Path::new(defect), Path::new(count)]);
    }
}

#[test]
fn repair_says_what_it_did_and_meshes() {
    let folder = tempfile::tempdir().expect("a folder");
    for (file, words) in [
        ("open", "1 hole was filled"),
        ("duplicate_face", "1 face over the same vertices"),
        ("touching_cubes", "4 faces over the same vertices"),
        ("non_manifold_vertex", "2 vertices where parts touched"),
    ] {
        let (status, text) = run(folder.path(), &models().join(format!("bad/{file}.obj")), &["--repair"]);
        // Parts that hardly part may need more vertices than there are here.
        assert!(status == Some(0) || (file == "non_manifold_vertex" && status == Some(5)), "{file}: {text}");
        assert!(text.contains(words), "{file}: {text}");
    }
    // What cannot be mended is refused, with what was done before.
    let (status, text) = run(folder.path(), &models().join("bad/klein_bottle.obj"), &["--repair"]);
    assert_eq!(status, Some(1), "{text}");
}

#[test]
fn files_of_other_programs_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    python::run("write_surfaces.py", &[folder.path()]);
    let wanted = io::read_surface(&folder.path().join("trimesh.obj")).expect("an OBJ file");
    let volume = |s: &tetcvt::Surface| s.volume() / s.frame().scale.powi(3);
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder.path()).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    files.sort();
    let (mut read, mut grouped) = (0, 0);
    for path in files {
        let name = path.file_name().and_then(|n| n.to_str()).expect("a name").to_owned();
        if name.ends_with(".bin") {
            continue;
        }
        let surface = io::read_surface(&path);
        if name.starts_with("refused") {
            let error = surface.err().expect(&name).to_string();
            assert!(error.contains("vtkLZ4DataCompressor"), "{error}");
            continue;
        }
        let surface = surface.unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(surface.triangles().len(), wanted.triangles().len(), "{name}");
        assert_eq!(surface.points().len(), wanted.points().len(), "{name}");
        assert!((volume(&surface) / volume(&wanted) - 1.0).abs() < 1e-6, "{name}");
        let mut patches = surface.patch().to_vec();
        patches.sort_unstable();
        patches.dedup();
        // Strips do not keep the order of the faces; pyvista drops the numbers on them.
        let has_numbers = name.ends_with(".vtp") || name.ends_with(".vtu") || name.ends_with(".vtk");
        if has_numbers && !name.starts_with("strips") {
            assert_eq!(patches, [2, 7], "{name}");
            grouped += 1;
        } else if !has_numbers {
            assert_eq!(patches, [0], "{name}");
        }
        read += 1;
    }
    assert!(read >= 36 && grouped >= 19, "{read} {grouped}");
}
