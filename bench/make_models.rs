//! Writes the files of `models/` and `models/bad/`: `cargo run --example make_models [index.js]`, in the folder of the
//! package. With the `index.js` of the npm package `bunny` 1.0.1, it writes `models/bunny.obj` as well.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs, io};

// One module makes the shapes of the tests and these files.
#[allow(dead_code)]
#[path = "../tests/shapes.rs"]
mod shapes;

fn main() -> io::Result<()> {
    let folder = Path::new("models");
    fs::create_dir_all(folder.join("bad"))?;
    for (name, text) in shapes::models() {
        fs::write(folder.join(name), text)?;
    }
    for (name, bytes) in shapes::bad_models() {
        fs::write(folder.join("bad").join(name), bytes)?;
    }
    if let Some(package) = env::args_os().nth(1) {
        fs::write(folder.join("bunny.obj"), bunny(&fs::read_to_string(package)?)?)?;
    }
    Ok(())
}

/// The package's positions and cells as an OBJ file, every number to the last digit.
fn bunny(script: &str) -> io::Result<String> {
    let mut text =
        String::from("# The Stanford bunny, as in the npm package bunny 1.0.1 (public domain): positions and cells\n");
    for (export, keyword) in [("positions", "v"), ("cells", "f")] {
        let (_, list) = script.split_once(&format!("exports.{export}=")).ok_or(io::ErrorKind::InvalidData)?;
        let list = list.split(['\n', ';']).next().unwrap_or(list);
        for row in serde_json::from_str::<Vec<[f64; 3]>>(list)? {
            // Cells count from 0, the faces of a file from 1.
            let [x, y, z] = if keyword == "f" { row.map(|v| v + 1.0) } else { row };
            writeln!(text, "{keyword} {x} {y} {z}").map_err(io::Error::other)?;
        }
    }
    Ok(text)
}
