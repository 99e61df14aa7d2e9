//! Runs the scripts of tests/python, in a virtual environment that is made on first use.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Runs a script of tests/python; what it printed. Fails with that unless it succeeds.
pub fn run(script: &str, arguments: &[&Path]) -> String {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    let python = PYTHON.get_or_init(environment);
    let mut command = Command::new(python);
    command.arg("-B").arg(scripts().join(script)).args(arguments);
    let output = command.output().expect("the interpreter of the virtual environment starts");
    assert!(
        output.status.success(),
        "{command:?}\n{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn scripts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python")
}

/// Makes the environment, unless the one that is there was made, to its end, of the same requirements.
fn environment() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("venv");
    let python = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let requirements = scripts().join("requirements.txt");
    let wanted = fs::read_to_string(&requirements).expect("tests/python/requirements.txt");
    let made_of = folder.join("made-of.txt");
    if fs::read_to_string(&made_of).is_ok_and(|made| made == wanted) {
        return python;
    }
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("an unfinished virtual environment can be removed");
    }
    let system = if cfg!(windows) { "python" } else { "python3" };
    step(
        Command::new(system).args(["-m", "venv"]).arg(&folder),
        "the tests read files back with VTK, which needs Python 3.11 or newer with its venv module \
         (Debian: apt-get install python3-venv)",
    );
    step(
        Command::new(&python)
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:", "-r"])
            .arg(&requirements),
        "the packages of tests/python/requirements.txt come from PyPI, which needs a network the first time",
    );
    fs::write(made_of, wanted).expect("the virtual environment is writable");
    python
}

fn step(command: &mut Command, needs: &str) {
    match command.output() {
        Ok(output) if output.status.success() => {}
        Ok(output) => panic!("{command:?} failed; {needs}\n{}", String::from_utf8_lossy(&output.stderr)),
        Err(error) => panic!("{command:?}: {error}; {needs}"),
    }
}
