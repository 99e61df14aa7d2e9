//! The binary and the system: signals, pipes that close, disks that fill.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::cli::{folder_with_cube, names};

const PROGRAM: &str = env!("CARGO_BIN_EXE_tetcvt");

fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM);
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// Waits for `condition`, not for ever.
fn wait_until(what: &str, condition: impl Fn() -> bool) {
    let begin = Instant::now();
    while !condition() {
        assert!(begin.elapsed() < Duration::from_secs(60), "{what} does not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A run that goes on until it is stopped, and the lines of its standard error.
fn long_run(folder: &Path) -> (Child, impl Iterator<Item = String>) {
    let arguments =
        ["cube.obj", "--seeds", "20000", "--iterations", "100000", "--tolerance", "0", "-v", "--trajectory", "t.npy"];
    let mut child = program(folder, &arguments).stderr(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    (child, lines)
}

#[test]
fn one_interrupt_finishes_with_what_there_is() {
    let folder = folder_with_cube();
    let (mut child, mut lines) = long_run(folder.path());
    lines.find(|l| l.starts_with("iteration ")).expect("an iteration");
    interrupt(&child);
    let rest: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{rest:?}");
    assert!(rest.iter().any(|l| l.contains("20000 vertices")), "{rest:?}");
    assert_eq!(names(folder.path()), ["cube.obj", "cube.surface.vtp", "cube.vtu", "t.npy"]);
}

#[test]
fn a_second_interrupt_stops_at_once_and_leaves_nothing() {
    let folder = folder_with_cube();
    let (mut child, mut lines) = long_run(folder.path());
    lines.find(|l| l.starts_with("iteration ")).expect("an iteration");
    interrupt(&child);
    lines.find(|l| l.contains("Ctrl-C again")).expect("an answer to the first interrupt");
    interrupt(&child);
    drop(lines);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(folder.path()), ["cube.obj"]);
}

#[test]
fn an_interrupt_with_nothing_to_keep_ends_with_status_130() {
    let folder = tempfile::tempdir().unwrap();
    // Reading from a pipe without a writer takes for ever.
    let pipe = folder.path().join("pipe.obj");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut child =
        program(folder.path(), &["pipe.obj", "--trajectory", "t.npy"]).stderr(Stdio::piped()).spawn().unwrap();
    // The trajectory is begun once the program listens.
    wait_until("the trajectory", || names(folder.path()).len() == 2);
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!(stderr, "error: interrupted with nothing to keep\n");
    assert_eq!(names(folder.path()), ["pipe.obj"]);
}

#[test]
fn closed_pipes_are_no_failure() {
    let folder = folder_with_cube();
    let arguments = ["cube.obj", "--seeds", "300", "--iterations", "2", "-v", "--json", "-"];
    let mut child = program(folder.path(), &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(names(folder.path()), ["cube.obj", "cube.surface.vtp", "cube.vtu"]);
    for flag in ["--help", "--nonsense"] {
        let mut child = program(folder.path(), &[flag]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        drop(child.stderr.take());
        assert_eq!(child.wait().unwrap().code(), Some(if flag == "--help" { 0 } else { 2 }), "{flag}");
    }
}

#[test]
fn a_full_disk_keeps_the_old_files() {
    let folder = folder_with_cube();
    fs::write(folder.path().join("cube.vtu"), "old").unwrap();
    // Files may not grow over one block; the signal that would kill the program is ignored.
    let script =
        "trap '' XFSZ; ulimit -f 1; exec \"$0\" cube.obj --seeds 2000 --iterations 2 --trajectory t.npy --json r.json";
    let output = Command::new("sh").args(["-c", script, PROGRAM]).current_dir(folder.path()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert_eq!(stderr.lines().filter(|l| l.starts_with("error: cannot write ")).count(), 1, "{stderr}");
    assert_eq!(fs::read(folder.path().join("cube.vtu")).unwrap(), b"old");
    assert!(!names(folder.path()).iter().any(|name| name.ends_with(".part") || name.ends_with(".npy")));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_reported_and_the_mesh_is_safe() {
    let folder = folder_with_cube();
    let arguments = ["cube.obj", "--seeds", "300", "--iterations", "2", "--json"];
    let status = program(folder.path(), &arguments).arg("/dev/full").status().unwrap();
    assert_eq!(status.code(), Some(4));
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let status = program(folder.path(), &arguments).arg("-").stdout(full).status().unwrap();
    assert_eq!(status.code(), Some(4));
    assert_eq!(names(folder.path()), ["cube.obj", "cube.surface.vtp", "cube.vtu"]);
}
