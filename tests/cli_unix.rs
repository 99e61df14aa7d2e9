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
    send("-INT", child);
}

fn send(signal: &str, child: &Child) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
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
fn being_told_to_terminate_or_to_hang_up_is_an_interrupt() {
    for signal in ["-TERM", "-HUP"] {
        let folder = folder_with_cube();
        let (mut child, mut lines) = long_run(folder.path());
        lines.find(|l| l.starts_with("iteration ")).expect("an iteration");
        send(signal, &child);
        lines.find(|l| l.contains("Ctrl-C again")).expect("an answer to the first signal");
        send(signal, &child);
        drop(lines);
        assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}");
        assert_eq!(names(folder.path()), ["cube.obj"], "{signal}");
    }
}

#[test]
fn a_hang_up_that_is_ignored_stays_ignored() {
    let folder = folder_with_cube();
    let script = "trap '' HUP; exec \"$0\" cube.obj --seeds 3000 --iterations 30 --tolerance 0 -v";
    let mut child = Command::new("sh")
        .args(["-c", script, PROGRAM])
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    lines.find(|l| l.starts_with("iteration ")).expect("an iteration");
    send("-HUP", &child);
    // The last three are against slivers, and may be fewer.
    assert!(lines.any(|l| l.starts_with("iteration   27")), "all iterations");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// Whatever stage a signal meets, files are whole or not there, the old ones untouched unless all is done.
#[test]
fn a_signal_at_any_time_leaves_whole_files_or_none() {
    let arguments = [
        "cube.obj",
        "--seeds",
        "1500",
        "--iterations",
        "8",
        "-o",
        "m.node",
        "--surface",
        "s.ply",
        "--voronoi",
        "v.vtu",
        "--trajectory",
        "t.npy",
        "--json",
        "r.json",
    ];
    let begin = Instant::now();
    let folder = folder_with_cube();
    assert!(program(folder.path(), &arguments).status().unwrap().success());
    let whole = begin.elapsed();
    let complete = names(folder.path());
    assert_eq!(complete, ["cube.obj", "m.ele", "m.face", "m.node", "r.json", "s.ply", "t.npy", "v.vtu"]);
    for step in 0..24u32 {
        let folder = folder_with_cube();
        fs::write(folder.path().join("m.ele"), "old").unwrap();
        let mut child = program(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(whole * step / 20);
        // Every second time twice: at once, that is.
        let signal = if step % 4 < 2 { "-INT" } else { "-TERM" };
        for _ in 0..1 + step % 2 {
            // It may have ended by itself.
            let _ = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status();
        }
        let status = child.wait().unwrap();
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        let found = names(folder.path());
        assert!(!found.iter().any(|name| name.starts_with('.')), "{step}: {found:?}");
        let mesh_is_old = fs::read(folder.path().join("m.ele")).unwrap() == b"old";
        match status.code() {
            Some(0) => assert!(found == complete && !mesh_is_old, "{step}: {found:?} {stderr}"),
            Some(130) if !mesh_is_old => assert!(found.contains(&"m.node".to_owned()), "{step}: {found:?}"),
            // No code: the signal came before the program could listen.
            Some(130) | None => assert!(!found.contains(&"m.node".to_owned()), "{step}: {found:?}"),
            other => panic!("{step}: status {other:?}, {stderr}"),
        }
        assert!(stderr.lines().filter(|l| l.starts_with("error: ")).count() <= 1, "{step}: {stderr}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn more_memory_than_half_of_what_is_free_is_announced() {
    let folder = folder_with_cube();
    let arguments = ["cube.obj", "--seeds", "100000000"];
    let mut child = program(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let first = lines.next().unwrap();
    send("-KILL", &child);
    let _ = child.wait();
    assert!(first.starts_with("note: this will take about ") && first.contains(" are free"), "{first}");
}

#[test]
fn a_folder_that_cannot_be_written_is_found_before_any_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder_with_cube();
    let locked = folder.path().join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
    // Who may do everything can write there, too.
    if fs::write(locked.join("probe"), "").is_err() {
        let output = program(folder.path(), &["cube.obj", "-o", "locked/m.node"]).output().unwrap();
        assert_eq!(output.status.code(), Some(4));
    }
    // A file where a folder is wanted stops everyone.
    let arguments = ["cube.obj", "-o", "cube.obj/m.node"];
    let output = program(folder.path(), &arguments).stderr(Stdio::piped()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(stderr.starts_with("error: cannot write cube.obj/m.node: ") && stderr.lines().count() == 1, "{stderr}");
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
    let script = "trap '' XFSZ; ulimit -f 1; exec \"$0\" cube.obj --seeds 2000 --iterations 2 --trajectory t.npy --json r.json \
         --voronoi v.vtu --delaunay d.vtu";
    let output = Command::new("sh").args(["-c", script, PROGRAM]).current_dir(folder.path()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert_eq!(stderr.lines().filter(|l| l.starts_with("error: cannot write ")).count(), 1, "{stderr}");
    assert_eq!(fs::read(folder.path().join("cube.vtu")).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["cube.obj", "cube.vtu"], "{stderr}");
}

#[test]
fn a_full_disk_keeps_all_files_of_a_mesh() {
    let folder = folder_with_cube();
    let parts = ["m.ele", "m.face", "m.node"];
    parts.iter().for_each(|name| fs::write(folder.path().join(name), "old").unwrap());
    // The nodes have room, the tets have not.
    let script = "trap '' XFSZ; ulimit -f 240; exec \"$0\" cube.obj --seeds 1500 --iterations 1 -o m.node";
    let output = Command::new("sh").args(["-c", script, PROGRAM]).current_dir(folder.path()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert_eq!(stderr.lines().filter(|l| l.starts_with("error: cannot write m.ele")).count(), 1, "{stderr}");
    assert!(parts.iter().all(|name| fs::read(folder.path().join(name)).unwrap() == b"old"));
    assert_eq!(names(folder.path()), ["cube.obj", "cube.surface.vtp", "m.ele", "m.face", "m.node"]);
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
