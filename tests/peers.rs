//! Meshes beside those of TetGen and fTetWild.

use std::path::{Path, PathBuf};

use crate::output::model;
use crate::python;

/// The program under test.
const TETCVT: &str = env!("CARGO_BIN_EXE_tetcvt");

#[test]
fn beside_tetgen_and_ftetwild_tets_are_better_and_solve_better() {
    let table = Path::new(env!("CARGO_TARGET_TMPDIR")).join("peers.csv");
    let mut models: Vec<PathBuf> =
        ["cube.obj", "torus.obj", "hollow_cube.obj", "bunny.obj"].into_iter().map(model).collect();
    let fandisk = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models/fandisk.obj");
    models.extend(fandisk.exists().then_some(fandisk));
    let mut arguments: Vec<&Path> = vec![Path::new(TETCVT), &table];
    arguments.extend(models.iter().map(PathBuf::as_path));
    print!("{}", python::run("compare_peers.py", &arguments));
}
