//! The real binary: options, exit statuses, what goes where, what an error says.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// The program, run in `folder`.
pub fn tetcvt(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tetcvt"));
    command.current_dir(folder);
    command
}

/// A folder with a cube in it, of quads.
pub fn folder_with_cube() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    fs::write(folder.path().join("cube.obj"), cube).unwrap();
    folder
}

/// Names in a folder, hidden ones too.
pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// What a run said and how it ended.
struct Run {
    status: Option<i32>,
    stdout: String,
    stderr: String,
}

fn run(folder: &Path, arguments: &[&str]) -> Run {
    let output = tetcvt(folder).args(arguments).output().unwrap();
    Run {
        status: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

const SMALL: [&str; 5] = ["cube.obj", "--seeds", "300", "--iterations", "3"];

fn small(folder: &Path, more: &[&str]) -> Run {
    run(folder, &[&SMALL, more].concat())
}

#[test]
fn wrong_usage_ends_with_status_2_and_says_why() {
    let folder = folder_with_cube();
    let cases: [(&[&str], &str); 25] = [
        (&[], "<SURFACE>"),
        (&["cube.obj", "other.obj"], "other.obj"),
        (&["cube.obj", "--seeds", "3"], "--seeds"),
        (&["cube.obj", "--seeds", "-7"], "--seeds"),
        (&["cube.obj", "--seeds", "many"], "whole number"),
        (&["cube.obj", "--seeds", "300", "--edge", "0.1"], "--edge"),
        (&["cube.obj", "--edge", "0"], "--edge"),
        (&["cube.obj", "--edge", "2 mm"], "--edge"),
        (&["cube.obj", "--edge", "-3%"], "--edge"),
        (&["cube.obj", "--edge", "inf"], "--edge"),
        (&["cube.obj", "--boundary", "soft"], "conform"),
        (&["cube.obj", "--feature-angle", "181"], "--feature-angle"),
        (&["cube.obj", "--start", "grid"], "bcc"),
        (&["cube.obj", "--optimizer", "newton"], "lbfgs, nesterov, lloyd"),
        (&["cube.obj", "--time-limit", "-1"], "--time-limit"),
        (&["cube.obj", "--iterations", "-1"], "--iterations"),
        (&["cube.obj", "--tolerance", "nan"], "--tolerance"),
        (&["cube.obj", "--update", "soon"], "bicell, paper, vertex, check, rebuild"),
        (&["cube.obj", "--threads", "0"], "--threads"),
        (&["cube.obj", "-q", "-v"], "--quiet"),
        (&["cube.obj", "-o", "mesh.stl"], ".vtu"),
        (&["cube.obj", "-o", "mesh"], ".vtu"),
        (&["cube.obj", "--surface", "surface.vtu"], ".vtp"),
        (&["cube.obj", "--trajectory", "t.csv"], ".npy"),
        (&["cube.obj", "--delaunay", "d.vtk"], ".vtu"),
    ];
    for (arguments, word) in cases {
        let run = run(folder.path(), arguments);
        assert_eq!(run.status, Some(2), "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: ") && run.stderr.contains(word), "{arguments:?}: {}", run.stderr);
        assert_eq!(run.stdout, "", "{arguments:?}");
    }
    assert_eq!(names(folder.path()), ["cube.obj"]);
}

#[test]
fn options_of_later_versions_are_not_accepted() {
    let folder = folder_with_cube();
    for option in ["--animate=f.obj", "--sizes=f.vtu"] {
        let run = run(folder.path(), &["cube.obj", option]);
        assert_eq!(run.status, Some(2), "{option}");
        assert!(run.stderr.contains("unexpected argument"), "{}", run.stderr);
    }
}

#[test]
fn no_output_may_be_the_input_or_another_output() {
    let folder = folder_with_cube();
    let before = fs::read(folder.path().join("cube.obj")).unwrap();
    fs::create_dir(folder.path().join("deep")).unwrap();
    fs::copy(folder.path().join("cube.obj"), folder.path().join("cube.vtu")).unwrap();
    let mut cases: Vec<Vec<&str>> = vec![
        vec!["cube.vtu"],
        vec!["cube.obj", "--json", "cube.obj"],
        vec!["cube.obj", "--json", "deep/../cube.obj"],
        vec!["cube.obj", "-o", "a.vtk", "--surface", "a.vtk"],
        vec!["cube.obj", "-o", "a.vtk", "--surface", "./deep/../a.vtk"],
        vec!["cube.obj", "-o", "a.vtu", "--delaunay", "a.vtu"],
        vec!["cube.obj", "--json", "t.npy", "--trajectory", "t.npy"],
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../cube.obj", folder.path().join("deep/link.vtk")).unwrap();
        fs::hard_link(folder.path().join("cube.obj"), folder.path().join("hard.vtk")).unwrap();
        std::os::unix::fs::symlink("new.vtk", folder.path().join("dangling.vtk")).unwrap();
        cases.push(vec!["cube.obj", "-o", "deep/link.vtk"]);
        cases.push(vec!["cube.obj", "-o", "hard.vtk"]);
        cases.push(vec!["deep/link.vtk", "--json", "cube.obj"]);
        cases.push(vec!["cube.obj", "-o", "new.vtk", "--surface", "dangling.vtk"]);
    }
    let names_before = names(folder.path());
    for arguments in cases {
        let run = run(folder.path(), &arguments);
        assert_eq!(run.status, Some(2), "{arguments:?}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{arguments:?}: {}", run.stderr);
    }
    assert_eq!(fs::read(folder.path().join("cube.obj")).unwrap(), before);
    assert_eq!(names(folder.path()), names_before);
}

#[test]
fn unwritable_outputs_end_with_status_4_before_anything_is_read() {
    let folder = folder_with_cube();
    fs::write(folder.path().join("file"), "").unwrap();
    fs::create_dir(folder.path().join("folder.vtu")).unwrap();
    for arguments in [
        ["-o", "missing/a.vtu"],
        ["-o", "file/a.vtu"],
        ["-o", "folder.vtu"],
        ["--surface", "missing/a.vtp"],
        ["--json", "missing/a.json"],
        ["--trajectory", "missing/t.npy"],
        ["--delaunay", "missing/d.vtu"],
    ] {
        // The surface does not exist either: were it read first, the status would be 3.
        let run = run(folder.path(), &["missing.obj", arguments[0], arguments[1]]);
        assert_eq!(run.status, Some(4), "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: cannot write "), "{}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    }
    assert_eq!(names(folder.path()), ["cube.obj", "file", "folder.vtu"]);
}

#[cfg(unix)]
#[test]
fn a_protected_folder_or_file_is_respected() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder_with_cube();
    let locked = folder.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::write(folder.path().join("locked.vtu"), "mine").unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
    fs::set_permissions(folder.path().join("locked.vtu"), fs::Permissions::from_mode(0o444)).unwrap();
    // Permissions stop everybody but root.
    if fs::write(locked.join("probe"), "").is_err() {
        for file in ["locked/a.vtu", "locked.vtu"] {
            assert_eq!(run(folder.path(), &["cube.obj", "-o", file]).status, Some(4), "{file}");
        }
        assert_eq!(fs::read(folder.path().join("locked.vtu")).unwrap(), b"mine");
    }
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn unreadable_surfaces_end_with_status_3() {
    let folder = folder_with_cube();
    fs::write(folder.path().join("noise.obj"), [0x80, 0xff, 0, 10, 7, 200].repeat(100)).unwrap();
    for input in ["missing.obj", "noise.obj", "."] {
        let run = run(folder.path(), &[input, "-o", "out.vtu", "--surface", "out.vtp"]);
        assert_eq!(run.status, Some(3), "{input}: {}", run.stderr);
        assert!(run.stderr.starts_with("error: cannot read ") && run.stderr.contains(input), "{}", run.stderr);
    }
    assert_eq!(names(folder.path()), ["cube.obj", "noise.obj"]);
}

#[test]
fn help_and_version_go_to_standard_output() {
    let folder = folder_with_cube();
    for flag in ["--help", "-h", "--version"] {
        let run = run(folder.path(), &[flag]);
        assert_eq!((run.status, run.stderr.as_str()), (Some(0), ""), "{flag}");
        assert!(run.stdout.contains("tetcvt"), "{flag}: {}", run.stdout);
    }
    let help = run(folder.path(), &["--help"]).stdout;
    for part in ["Exit status:", "130", "--seeds <N>", "[default: 20000]", "--trajectory", "Examples:"] {
        assert!(help.contains(part), "{part}");
    }
    assert!(help.lines().all(|line| line.chars().count() <= 120), "{help}");
}

#[test]
fn by_default_two_files_and_a_summary() {
    let folder = folder_with_cube();
    let run = small(folder.path(), &[]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    assert_eq!(run.stdout, "");
    for part in
        ["300 vertices", "volume", "Hausdorff", "degrees", "###", "stopped", "time", "cube.vtu", "cube.surface.vtp"]
    {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
    assert!(!run.stderr.contains("iteration    1"), "{}", run.stderr);
    assert_eq!(names(folder.path()), ["cube.obj", "cube.surface.vtp", "cube.vtu"]);
}

#[test]
fn quiet_and_verbose() {
    let folder = folder_with_cube();
    let quiet = small(folder.path(), &["-q"]);
    assert_eq!((quiet.status, quiet.stdout.as_str(), quiet.stderr.as_str()), (Some(0), "", ""));
    let verbose = small(folder.path(), &["-v", "--tolerance", "0"]);
    assert_eq!(verbose.status, Some(0));
    assert_eq!(verbose.stderr.lines().filter(|l| l.starts_with("iteration ")).count(), 3, "{}", verbose.stderr);
}

#[test]
fn the_report_has_every_key_and_nothing_else_is_on_standard_output() {
    let folder = folder_with_cube();
    let run = small(folder.path(), &["--json", "-", "--tolerance", "0"]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let keys: [(&str, &str); 7] = [
        ("", "tetcvt command input mesh time update memory iterations stopped improved notes"),
        ("/input", "file vertices triangles components genus volume area diagonal"),
        (
            "/mesh",
            "vertices tets surface_triangles interior_seeds surface_seeds curve_seeds corner_seeds volume volume_error \
             size_ratio hausdorff rms_distance min_dihedral max_dihedral p1_min_dihedral mean_min_dihedral \
             mean_radius_ratio regions worst_at dihedral_histogram",
        ),
        ("/time", "total read check seeds build update centroids extract improve measure write"),
        ("/update", "filter predicate flips repair renewal build"),
        ("/memory", "peak_bytes"),
        (
            "/iterations/0",
            "move energy max_move evaluations update_s centroids_s tets bicells vertices_failed bicells_failed \
             predicates flips reversed held_back rebuilt",
        ),
    ];
    for (place, names) in keys {
        let object = report.pointer(place).and_then(|v| v.as_object()).unwrap_or_else(|| panic!("{place}"));
        let mut found: Vec<&str> = object.keys().map(String::as_str).collect();
        let mut wanted: Vec<&str> = names.split_whitespace().collect();
        found.sort_unstable();
        wanted.sort_unstable();
        assert_eq!(found, wanted, "{place}");
    }
    assert_eq!(report["mesh"]["vertices"], 300);
    assert_eq!(report["mesh"]["corner_seeds"], 8);
    assert_eq!(report["iterations"].as_array().unwrap().len(), 3);
    assert_eq!(report["input"]["triangles"], 12);
    assert_eq!(report["input"]["volume"], 1.0);
    assert_eq!(report["command"][1], "cube.obj");
    let volume_error = report["mesh"]["volume_error"].as_f64().unwrap();
    assert!(volume_error.abs() < 1e-9, "{volume_error}");
    let total = report["time"]["total"].as_f64().unwrap();
    let stages = report["time"].as_object().unwrap().iter().filter(|(k, _)| *k != "total");
    let sum: f64 = stages.map(|(_, v)| v.as_f64().unwrap()).sum();
    assert!(sum <= total * 1.01, "{sum} of {total}");
}

#[test]
fn the_same_bytes_on_one_and_two_threads() {
    let folder = folder_with_cube();
    let files = ["cube.vtu", "cube.surface.vtp", "d.vtu", "t.npy"];
    let read = |threads: &str| {
        let run = small(folder.path(), &["--threads", threads, "--delaunay", "d.vtu", "--trajectory", "t.npy"]);
        assert_eq!(run.status, Some(0), "{}", run.stderr);
        files.map(|f| fs::read(folder.path().join(f)).unwrap())
    };
    assert!(read("1") == read("2"));
}

#[test]
fn an_old_file_is_replaced_and_its_link_stays() {
    let folder = folder_with_cube();
    fs::write(folder.path().join("real.vtu"), "old").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("real.vtu", folder.path().join("cube.vtu")).unwrap();
    #[cfg(not(unix))]
    fs::write(folder.path().join("cube.vtu"), "old").unwrap();
    assert_eq!(small(folder.path(), &["-q"]).status, Some(0));
    assert!(fs::read(folder.path().join("cube.vtu")).unwrap().starts_with(b"<?xml"));
    #[cfg(unix)]
    {
        assert!(fs::symlink_metadata(folder.path().join("cube.vtu")).unwrap().is_symlink());
        assert!(fs::read(folder.path().join("real.vtu")).unwrap().starts_with(b"<?xml"));
    }
}

/// A table in Markdown: its rows with `columns` columns, without the header.
fn table(file: &Path, columns: usize) -> Vec<Vec<String>> {
    let text = fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let rows = text.lines().filter(|l| l.starts_with('|')).map(|l| {
        l.trim_matches('|').split('|').map(|cell| cell.trim().trim_matches('`').to_owned()).collect::<Vec<_>>()
    });
    rows.filter(|row| row.len() == columns && row[0].contains('.')).collect()
}

/// Each file of models/bad, with the status and the word that its README promises: | file | what | status | word |.
#[test]
fn every_bad_model_is_refused_for_its_own_reason() {
    let folder = tempfile::tempdir().unwrap();
    let bad = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/bad");
    let rows = table(&bad.join("README.md"), 4);
    let mut listed: Vec<String> = rows.iter().map(|row| row[0].clone()).collect();
    listed.sort();
    let present: Vec<String> = names(&bad).into_iter().filter(|name| name != "README.md").collect();
    assert_eq!(listed, present, "models/bad/README.md lists what is there");
    for row in rows {
        let input = bad.join(&row[0]);
        let run = run(folder.path(), &[input.to_str().unwrap(), "--seeds", "500", "--iterations", "2"]);
        assert_eq!(run.status.map(|s| s.to_string()).as_ref(), Some(&row[2]), "{}: {}", row[0], run.stderr);
        assert!(run.stderr.to_lowercase().contains(&row[3].to_lowercase()), "{}: {}", row[0], run.stderr);
        if row[2] != "0" {
            assert!(run.stderr.lines().any(|l| l.starts_with("error: ")), "{}", run.stderr);
            // Nothing but the places of the defects.
            let left: Vec<String> =
                names(folder.path()).into_iter().filter(|name| !name.ends_with(".defects.vtp")).collect();
            assert!(left.is_empty(), "{}: {left:?}", row[0]);
        }
    }
}

/// Larger broken surfaces, where a collection of them lies beside the project: | file | triangles | what | expected |.
#[test]
fn the_bad_surfaces_beside_the_project() {
    let models: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    if !models.join("bad").is_dir() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for row in table(&models.join("README.md"), 4) {
        let (file, expected) = (&row[0], &row[3]);
        // Its vertices differ by less than 2^-52 of its size: as points of the frame they are equal, and it is closed.
        let expected = if file == "soup_featuretype.stl" { "meshed" } else { expected.as_str() };
        let input = models.join("bad").join(file);
        let run = run(folder.path(), &[input.to_str().unwrap(), "--seeds", "6000", "--iterations", "3"]);
        match expected.strip_prefix("refused: ") {
            Some(reason) => {
                assert_eq!(run.status, Some(1), "{file}: {}", run.stderr);
                let reason = reason.replace("self-crossing", "crosses or touches itself: ");
                let alternatives: Vec<&str> = reason.split(" or ").collect();
                let named = alternatives.iter().any(|reason| {
                    reason.split_whitespace().all(|word| run.stderr.contains(word.trim_end_matches(" faces")))
                });
                assert!(named, "{file}: {reason}: {}", run.stderr);
            }
            None => assert_eq!(run.status, Some(0), "{file}: {}", run.stderr),
        }
    }
}
