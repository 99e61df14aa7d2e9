//! Reading and checking surfaces, and their measures; the box tree and the features are in files of their own.

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use tetcvt::surface::defects::Defect;
use tetcvt::{Error, Surface, io};

use crate::shapes::{self, Shape};
use crate::support::Rng;

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models")
}

fn read(name: &str) -> Result<Surface, Error> {
    io::read_surface(&models().join(name))
}

/// Volume in the model's units.
fn volume(surface: &Surface) -> f64 {
    surface.volume() / surface.frame().scale.powi(3)
}

fn assert_close(value: f64, expected: f64, relative: f64, what: &str) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{what}: {value} is not {expected}");
}

#[test]
fn the_files_are_what_the_shapes_make() {
    for (name, text) in shapes::models() {
        let file = std::fs::read_to_string(models().join(name)).expect(name);
        assert!(file == text && text.len() < 500_000, "{name}: cargo run --example make_models");
    }
    for (name, bytes) in shapes::bad_models() {
        let file = std::fs::read(models().join("bad").join(name)).expect(name);
        assert!(file == bytes, "{name}: cargo run --example make_models");
    }
}

#[test]
fn every_bad_file_gives_what_its_table_says() {
    let table = std::fs::read_to_string(models().join("bad/README.md")).expect("the table");
    let mut seen = vec![];
    for row in table.lines().filter(|l| l.contains(".obj |")) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [file, _, status, words] = cells[..] else { panic!("{row}") };
        let (got, text) = match read(&format!("bad/{file}")) {
            Ok(surface) => (0, surface.notes().join("; ")),
            Err(error) => (error.exit_status(), error.to_string()),
        };
        assert_eq!(got.to_string(), status, "{file}: {text}");
        assert!(text.contains(words), "{file}: {text}");
        seen.push(file.to_owned());
    }
    let mut made: Vec<String> = shapes::bad_models().iter().map(|f| f.0.to_owned()).collect();
    seen.sort_unstable();
    made.sort_unstable();
    assert_eq!(seen, made);
}

#[test]
fn mended_files_are_the_shapes_they_were_meant_to_be() {
    for (file, triangles, expected) in [
        ("inside_out", 12, 8.0),
        ("zero_area", 14, 8.0),
        ("equal_corners", 12, 8.0),
        ("duplicate_vertices", 12, 8.0),
        ("unused_vertices", 12, 8.0),
        ("statements", 12, 8.0),
        ("far", 12, 8.0),
        ("polygons", 24, 3.0),
        ("huge", 12, 8e114),
    ] {
        let surface = read(&format!("bad/{file}.obj")).expect(file);
        assert_eq!(surface.triangles().len(), triangles, "{file}");
        assert_close(volume(&surface), expected, 1e-14, file);
        assert_eq!((surface.genus(), surface.shell_count()), (0, 1), "{file}");
    }
    // 8e-900 is below the range of f64: compared in the frame.
    let tiny = read("bad/tiny.obj").expect("tiny");
    let edge = 2e-300 * tiny.frame().scale;
    assert_close(tiny.volume(), edge.powi(3), 1e-14, "tiny");
    let cavity = read("bad/cavity_outward.obj").expect("cavity");
    let ball = Shape::icosphere(1, 0.5).surface().expect("a sphere");
    assert_close(volume(&cavity), 8.0 - volume(&ball), 1e-8, "cavity");
}

#[test]
fn good_files_have_no_notes_and_the_measures_of_their_table() {
    let table = std::fs::read_to_string(models().join("README.md")).expect("the table");
    let mut rows = 0;
    for row in table.lines().filter(|l| l.contains(".obj |")) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let surface = read(cells[0]).expect(cells[0]);
        let figures = [surface.triangles().len(), surface.genus(), surface.shell_count()].map(|n| n.to_string());
        assert_eq!(figures[..], cells[1..4], "{}", cells[0]);
        assert!(surface.notes().is_empty(), "{}: {:?}", cells[0], surface.notes());
        rows += 1;
    }
    // Beside these the bunny and cut_part.
    assert_eq!(rows, shapes::models().len() + 2);
}

#[test]
fn volumes_and_areas_are_those_of_closed_forms() {
    use std::f64::consts::TAU;
    let (m, n) = (64.0, 32.0);
    let torus = Shape::torus(64, 32, 1.0, 0.4).surface().expect("torus");
    // A prism's cross-section, an n-gon, sweeps a regular m-gon at every distance from the axis.
    let polygon = n / 2.0 * 0.16 * (TAU / n).sin();
    assert_close(volume(&torus), m * (TAU / m).sin() * polygon, 1e-13, "torus");
    assert_eq!(torus.genus(), 1);

    let ico = Shape::icosphere(0, 1.0).surface().expect("icosahedron");
    let edge = 1.0 / (TAU / 5.0).sin();
    assert_close(volume(&ico), 5.0 / 12.0 * (3.0 + 5f64.sqrt()) * edge.powi(3), 1e-15, "icosahedron");
    let area = ico.area() / ico.frame().scale.powi(2);
    assert_close(area, 5.0 * 3f64.sqrt() * edge.powi(2), 1e-15, "icosahedron's area");

    let plate = read("thin_plate.obj").expect("plate");
    assert_close(volume(&plate), 0.04, 1e-13, "plate");
    assert_close(plate.diagonal() / plate.frame().scale, (4.0f64 + 1.0 + 0.0004).sqrt(), 1e-14, "plate's diagonal");
}

#[test]
fn shells_nest_to_any_depth() {
    let at = |level: u32, radius: f64, x: f64| Shape::icosphere(level, radius).placed(DVec3::X * x, 1.0);
    // Depth 0 to 3, a second island in the first cavity, a body apart, in no helpful order; all face outward.
    let shape = at(1, 0.25, 0.0)
        .with(&at(2, 2.0, 0.0))
        .with(&at(1, 0.5, 0.0).reversed())
        .with(&at(2, 1.0, 10.0))
        .with(&at(2, 1.5, 0.0))
        .with(&at(1, 0.2, 1.0));
    let surface = shape.surface().expect("nested spheres");
    // The innermost ball of 0.25 lies in 0.5, which is solid in the cavity 1.5 of the ball 2.0: it is a cavity.
    assert_eq!([0, 1, 2, 3, 4, 5].map(|s| surface.solid_of_shell(s)), [0, 1, 0, 2, 1, 3]);
    let ball = |level, radius| volume(&Shape::icosphere(level, radius).surface().expect("a sphere"));
    let expected = ball(2, 2.0) - ball(2, 1.5) + ball(1, 0.5) - ball(1, 0.25) + ball(1, 0.2) + ball(2, 1.0);
    assert_close(volume(&surface), expected, 1e-13, "nested spheres");
    assert!(surface.notes().iter().any(|n| n.contains("cavities")), "{:?}", surface.notes());
    assert!(surface.notes().iter().any(|n| n.contains("inside out")), "{:?}", surface.notes());
}

#[test]
fn a_moved_and_scaled_surface_is_the_same() {
    let shape = Shape::icosphere(2, 1.0);
    let here = shape.surface().expect("sphere");
    for (shift, scale) in [(0.0, 1e300), (0.0, 1e38), (0.0, 1e-300), (0.0, 1e-12), (1e7, 1.0), (-1e7, 1.0)] {
        let there = shape.clone().placed(DVec3::splat(shift), scale).surface().expect("sphere");
        assert_eq!(there.triangles(), here.triangles());
        assert!(there.notes().is_empty(), "{shift} {scale}: {:?}", there.notes());
        // Far from the origin the coordinates themselves have fewer digits.
        let ratio = there.volume() / here.volume() / (there.diagonal() / here.diagonal()).powi(3);
        assert_close(ratio, 1.0, if shift == 0.0 { 1e-14 } else { 1e-7 }, "shape");
    }
}

#[test]
fn needles_in_rows_and_fans_are_removed() {
    // A cube with k vertices along a diagonal of one side: one half of the side uses them, the other has the diagonal
    // whole, and a chain of triangles without area closes the gap.
    for k in [1, 2, 3, 10, 63] {
        let mut cube = Shape::cube();
        let split = cube.faces.iter().position(|f| *f == [4, 7, 6]).expect("the cube has this face");
        cube.faces.swap_remove(split);
        let first = cube.points.len() as u32;
        let chain: Vec<u32> = std::iter::once(4).chain(first..first + k).chain([7]).collect();
        for i in 1..=k {
            let at = 2.0 * f64::from(i) / 64.0 - 1.0;
            cube.points.push(DVec3::new(at, at, 1.0));
        }
        cube.faces.extend(chain.windows(2).map(|w| vec![w[0], w[1], 6]));
        // Zero-area triangles from corner 4 along the diagonal.
        cube.faces.extend(chain[1..].windows(2).map(|w| vec![4, w[1], w[0]]));
        // Turned, they are only flat up to rounding.
        for angle in [0.0, 0.3, 1.0] {
            let mut cube = cube.clone();
            let turn = DQuat::from_axis_angle(DVec3::new(2.0, 3.0, 6.0) / 7.0, angle);
            cube.points.iter_mut().for_each(|p| *p = turn * *p);
            let surface = cube.surface().unwrap_or_else(|e| panic!("{k} {angle}: {e}"));
            assert_close(volume(&surface), 8.0, 4e-15, "cube");
            assert_close(surface.area() / surface.frame().scale.powi(2), 24.0, 4e-15, "area");
            assert_eq!(surface.points().len(), 8 + k as usize);
            for t in 0..surface.triangles().len() as u32 {
                let [a, b, c] = surface.corners(t);
                assert!((b - a).cross(c - a).length() > 1e-6, "{k} {angle}: triangle {t}");
            }
        }
    }
}

#[test]
fn thin_triangles_with_an_area_stay() {
    let mut cube = shapes::cube_with_needle();
    // Off the diagonal by 1e-9: a dent, not a degenerate triangle.
    cube.points[8].x -= 1e-9;
    let surface = cube.surface().expect("a cube");
    assert_eq!(surface.triangles().len(), 14);
    assert!(surface.notes().is_empty(), "{:?}", surface.notes());
}

#[test]
fn defects_say_how_often_and_where() {
    let mut open = Shape::cube().placed(DVec3::splat(10.0), 1.0);
    open.faces.remove(2);
    let Err(Defect::Open { count, place }) = open.surface() else { panic!("an open cube") };
    assert_eq!(count, 3);
    assert_eq!(place.point[2], 10.0 + f64::from(place.point[2] > 10.0) - f64::from(place.point[2] < 10.0));
    assert!(place.face < 11);

    let triangles = Shape::cube().triangles();
    let points = Shape::cube().points;
    let bad = Surface::new(&points[..7], &triangles, &[5; 12], &[0; 12]);
    assert!(matches!(bad, Err(Defect::BadIndex { face: 5, index: 7, count: 7 })));
}

#[test]
fn sources_and_patches_follow_the_file() {
    let surface = read("bad/statements.obj").expect("statements");
    // Six quads in order, the line between them not counted; object, group and material change four times.
    assert_eq!(surface.source(), [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]);
    assert_eq!(surface.patch(), [0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 3, 3]);
}

#[test]
fn polygons_of_many_corners_are_cut_without_folds() {
    // A prism over a gear with a tooth every third corner.
    for n in [9u32, 60, 900] {
        let corner = |i: u32| {
            let u = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            let r = if i.is_multiple_of(3) { 1.0 } else { 0.8 };
            (r * u.cos(), r * u.sin())
        };
        let outline: Vec<(f64, f64)> = (0..n).map(corner).collect();
        let level = |z: f64| outline.iter().map(move |&(x, y)| DVec3::new(x, y, z));
        let mut faces = vec![(0..n).rev().collect(), (n..2 * n).collect()];
        faces.extend((0..n).map(|i| vec![i, (i + 1) % n, (i + 1) % n + n, i + n]));
        let gear = Shape { points: level(0.0).chain(level(1.0)).collect(), faces };
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("gear.obj");
        std::fs::write(&path, gear.obj_with("gear", |x| x.to_string())).expect("a file");
        let surface = io::read_surface(&path).expect("a gear");
        assert!(surface.notes().is_empty(), "{:?}", surface.notes());
        let cross = |i: usize| {
            let ((a, b), (c, d)) = (outline[i], outline[(i + 1) % outline.len()]);
            a * d - b * c
        };
        let area = 0.5 * (0..outline.len()).map(cross).sum::<f64>();
        assert_close(volume(&surface), area, 1e-13, "gear");
        // Folds would add area to the flat sides.
        let flat: f64 = (0..surface.triangles().len() as u32)
            .map(|t| surface.corners(t))
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).z.abs() / surface.frame().scale.powi(2))
            .sum();
        assert_close(flat, 2.0 * area, 1e-12, "flat sides");
    }
}

#[test]
fn what_cannot_be_opened_is_an_error_of_reading() {
    for path in [models().join("there_is_none.obj"), models()] {
        let error = io::read_surface(&path).err().expect("an error");
        assert_eq!(error.exit_status(), 3, "{error}");
        assert!(error.to_string().contains(&path.display().to_string()), "{error}");
    }
}

#[test]
fn nothing_that_crosses_itself_panics() {
    let overlapping = Shape::icosphere(2, 1.0).with(&Shape::icosphere(2, 1.0).placed(DVec3::X * 0.7, 1.0));
    let through = Shape::torus(12, 8, 1.0, 0.4).with(&Shape::icosphere(1, 0.8).reversed());
    let star = Shape {
        points: Shape::icosphere(1, 1.0).points.iter().map(|&p| p * p.x).collect(),
        ..Shape::icosphere(1, 1.0)
    };
    for shape in [overlapping, through, star] {
        // Whether it is refused is for the search for self-crossings to say; here it must end.
        if let Ok(surface) = shape.surface() {
            assert!(surface.volume().is_finite());
        }
    }
}

#[test]
fn whatever_the_triangles_a_surface_is_sound_or_refused() {
    let mut rng = Rng(17);
    let (mut sound, mut mended) = (0, 0);
    for i in 0..1500 {
        let mut shape = match i % 3 {
            0 => Shape::icosphere(1 + i % 2, 1.0),
            1 => Shape::torus(8, 5, 1.0, 0.4),
            _ => Shape::cube().with(&shapes::cube_with_needle().placed(DVec3::splat(0.1), 0.5)),
        };
        // Rounded to a coarse grid: welded vertices, triangles without area, sides on each other.
        let grid = 2.0 + rng.below(40) as f64;
        shape.points.iter_mut().for_each(|p| *p = (*p * grid).round());
        if i % 5 == 0 {
            let victim = rng.below(shape.faces.len());
            let vertex = rng.below(shape.points.len()) as u32;
            shape.faces[victim][rng.below(3)] = vertex;
        }
        for f in shape.faces.iter_mut() {
            if i % 7 == 0 && rng.below(4) == 0 {
                f.reverse();
            }
        }
        let Ok(surface) = shape.surface() else { continue };
        sound += 1;
        mended += usize::from(surface.notes().iter().any(|n| n.contains("no area")));
        // Closed and oriented: every edge is there once in each direction.
        let mut edges: Vec<[u32; 2]> =
            surface.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        assert!(edges.windows(2).all(|w| w[0] != w[1]), "{i}");
        assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()), "{i}");
        for t in 0..surface.triangles().len() as u32 {
            let [a, b, c] = surface.corners(t);
            assert!((b - a).cross(c - a) != DVec3::ZERO, "{i}: triangle {t}");
        }
        assert!(surface.volume().is_finite() && surface.area() > 0.0);
    }
    assert!(sound > 300 && mended > 20, "{sound} {mended}");
}
