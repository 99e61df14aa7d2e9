//! Each model end to end: exact count, valid mesh, the input's topology, volume and distance.

use std::path::{Path, PathBuf};

use tetcvt::io::read_surface;
use tetcvt::params::{Boundary, Target};
use tetcvt::progress::Silent;
use tetcvt::quality::TetQuality;
use tetcvt::report::MeshReport;
use tetcvt::{Error, Params, Surface, TetMesh, tetrahedralize};

fn models(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.map(|e| e.expect("a readable folder").path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "obj"));
    files.sort();
    files
}

/// Number of components of the boundary and Euler characteristic of all of it, by a count of its own.
fn topology(triangles: impl Iterator<Item = [u32; 3]> + Clone) -> (usize, i64) {
    let mut parent: Vec<u32> = (0..=triangles.clone().flatten().max().unwrap_or(0)).collect();
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    let mut edges = Vec::new();
    let mut vertices = Vec::new();
    let mut count = 0;
    for [a, b, c] in triangles {
        count += 1;
        for (u, v) in [(a, b), (b, c), (c, a)] {
            edges.push((u.min(v), u.max(v)));
            let (u, v) = (root(&mut parent, u), root(&mut parent, v));
            parent[u as usize] = v;
        }
        vertices.extend([a, b, c]);
    }
    edges.sort_unstable();
    edges.dedup();
    vertices.sort_unstable();
    vertices.dedup();
    let components = vertices.iter().filter(|&&v| parent[v as usize] == v).count();
    (components, vertices.len() as i64 - edges.len() as i64 + count)
}

fn meshed(surface: &Surface, params: &Params, name: &str) -> (TetMesh, MeshReport) {
    let mesh = tetrahedralize(surface, params, &mut Silent).unwrap_or_else(|e| panic!("{name}: {e}"));
    mesh.check().unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(!mesh.improved.starts_with("left as it was"), "{name}: {}", mesh.improved);
    let inner = topology(mesh.boundary.iter().map(|t| t.vertices));
    let outer = topology(surface.triangles().iter().copied());
    if params.boundary == Boundary::Conform {
        assert_eq!(inner, outer, "{name}: components and Euler characteristic");
    }
    let report = MeshReport::of(&mesh, &TetQuality::of(&mesh), surface);
    (mesh, report)
}

#[test]
fn every_model_at_two_counts() {
    let files = models("models");
    assert!(files.len() >= 7, "the models of this project are missing: {files:?}");
    for file in files {
        let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let surface = read_surface(&file).expect("a valid model");
        for (seeds, volume, distance) in [(1500, 0.04, 0.05), (6000, 0.015, 0.025)] {
            let params = Params { target: Target::Count(seeds), iterations: 20, ..Params::default() };
            let (mesh, report) = meshed(&surface, &params, &name);
            assert_eq!(mesh.points.len(), seeds, "{name}");
            assert!(report.volume_error.abs() < volume, "{name} {seeds}: volume {}", report.volume_error);
            assert!(report.hausdorff < distance, "{name} {seeds}: Hausdorff {}", report.hausdorff);
        }
    }
}

/// Seeds of a crease in one plane, the corners of a tet within the solid: no seed near by takes it from them.
#[test]
fn tets_without_volume_within_the_solid_are_flipped_away() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/cut_part.obj");
    let surface = read_surface(&file).expect("a valid model");
    let params = |improve| Params { target: Target::Count(3000), improve, ..Params::default() };
    match tetrahedralize(&surface, &params(false), &mut Silent) {
        Err(Error::TooFewSeeds { reason, .. }) => assert_eq!(reason, "a tet has no volume"),
        other => panic!("it has such a tet, by which this test is one: {:?}", other.map(|mesh| mesh.points.len())),
    }
    let (mesh, report) = meshed(&surface, &params(true), "cut_part");
    assert_eq!(mesh.points.len(), 3000);
    assert!(report.min_dihedral > 15.0, "the smallest angle is {}", report.min_dihedral);
}

#[test]
fn free_seeds_fill_the_solid_from_inside() {
    for name in ["cube", "torus", "hollow_cube"] {
        let surface = read_surface(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("models/{name}.obj")));
        let surface = surface.expect("a valid model");
        let params =
            Params { target: Target::Count(3000), boundary: Boundary::Free, iterations: 20, ..Params::default() };
        let (mesh, report) = meshed(&surface, &params, name);
        assert_eq!(mesh.points.len(), 3000);
        assert!(mesh.points.iter().all(|&p| surface.tree().is_inside(surface.frame().to_frame(p))), "{name}");
        assert!((-0.35..0.0).contains(&report.volume_error), "{name}: {}", report.volume_error);
    }
}

#[test]
fn any_scale_and_offset_gives_the_same_mesh() {
    let base = crate::shapes::Shape::icosphere(3, 1.0);
    let params = Params { target: Target::Count(300), iterations: 5, ..Params::default() };
    let mesh = |shape: &crate::shapes::Shape| {
        tetrahedralize(&shape.surface().expect("a valid shape"), &params, &mut Silent).expect("a mesh")
    };
    let reference = mesh(&base);
    for exponent in [-900, -40, 40, 900] {
        let scale = 2f64.powi(exponent);
        let shape = crate::shapes::Shape::icosphere(3, 1.0).placed(glam::DVec3::ZERO, scale);
        let scaled = mesh(&shape);
        assert_eq!(scaled.tets, reference.tets, "2^{exponent}");
        assert!(scaled.points.iter().zip(&reference.points).all(|(a, b)| *a == *b * scale), "2^{exponent}");
    }
    let far = mesh(&base.placed(glam::DVec3::splat(1e7), 1.0));
    assert_eq!(far.points.len(), 300);
}

#[test]
fn the_models_shared_between_projects_where_they_exist() {
    for file in models("../shared/models") {
        let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let surface = read_surface(&file).expect("a valid model");
        let params = Params { target: Target::Count(20_000), iterations: 3, ..Params::default() };
        let (mesh, report) = meshed(&surface, &params, &name);
        assert_eq!(mesh.points.len(), 20_000, "{name}");
        assert!(report.volume_error.abs() < 0.01, "{name}: volume {}", report.volume_error);
        assert!(report.hausdorff < 0.02, "{name}: Hausdorff {}", report.hausdorff);
    }
}
