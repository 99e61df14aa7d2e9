//! Files: their structure, and what VTK, meshio, trimesh and NumPy read in them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;
use tetcvt::geometry::tetrahedron::{FACETS, volume6};
use tetcvt::io::format::{Encoding, MeshFormat, SurfaceFormat};
use tetcvt::io::{MeshData, write_mesh, write_surface};
use tetcvt::quality::TetQuality;
use tetcvt::seeds::SeedKind;
use tetcvt::tet_mesh::{BoundaryTriangle, StageTimes, TetMesh};

use crate::cli::tetcvt;
use crate::python;

/// Cells along the side of a body.
const N: usize = 3;

/// Two cubes apart, each a region, cut into tets (six a cell); vertices inside are pushed off the grid.
pub fn two_cubes() -> TetMesh {
    let mut mesh = TetMesh {
        points: Vec::new(),
        kinds: Vec::new(),
        seeds: Vec::new(),
        tets: Vec::new(),
        regions: Vec::new(),
        boundary: Vec::new(),
        steps: Vec::new(),
        size_ratio: None,
        stopped: String::new(),
        improved: String::new(),
        times: StageTimes::default(),
    };
    for body in 0..2 {
        add_cube(&mut mesh, DVec3::new(10.0 + 2.0 * f64::from(body), -3.0, 0.1), body);
    }
    mesh.seeds = (0..mesh.points.len() as u32).rev().collect();
    add_boundary(&mut mesh);
    mesh
}

fn add_cube(mesh: &mut TetMesh, corner: DVec3, region: u32) {
    let base = mesh.points.len();
    let index = |c: [usize; 3]| (base + (c[0] * (N + 1) + c[1]) * (N + 1) + c[2]) as u32;
    for i in 0..(N + 1).pow(3) {
        let c = [i / (N + 1) / (N + 1), i / (N + 1) % (N + 1), i % (N + 1)];
        let sides = c.iter().filter(|&&x| x == 0 || x == N).count();
        let push = if sides == 0 { DVec3::new(0.2, -0.13, 0.07) * (1.0 + (i % 5) as f64 / 5.0) } else { DVec3::ZERO };
        mesh.points.push(corner + (DVec3::from(c.map(|x| x as f64)) + push) / N as f64);
        mesh.kinds.push([SeedKind::Interior, SeedKind::Surface, SeedKind::Curve, SeedKind::Corner][sides]);
    }
    for i in 0..N * N * N {
        let cell = [i / N / N, i / N % N, i % N];
        for path in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let mut at = cell;
            let mut tet = [index(at); 4];
            for (corner, axis) in tet[1..].iter_mut().zip(path) {
                at[axis] += 1;
                *corner = index(at);
            }
            let [a, b, c, d] = tet.map(|v| mesh.points[v as usize]);
            if volume6(a, b, c, d) < 0.0 {
                tet.swap(2, 3);
            }
            mesh.tets.push(tet);
            mesh.regions.push(region);
        }
    }
}

fn add_boundary(mesh: &mut TetMesh) {
    let mut facets = BTreeMap::new();
    for (tet, &region) in mesh.tets.iter().zip(&mesh.regions) {
        for vertices in FACETS.map(|f| f.map(|i| tet[i])) {
            let mut sorted = vertices;
            sorted.sort_unstable();
            facets.entry(sorted).or_insert_with(Vec::new).push((vertices, region));
        }
    }
    for (i, facet) in (0..).zip(facets.values().filter(|f| f.len() == 1)) {
        let (vertices, region_inside) = facet[0];
        let triangle =
            BoundaryTriangle { vertices, region_inside, region_outside: -1, patch: i % 6, source_triangle: i };
        mesh.boundary.push(triangle);
    }
}

/// Writes a mesh and its surface, in the formats of the files' names.
pub fn write_both(mesh: &TetMesh, mesh_file: &Path, surface_file: &Path, encoding: Encoding) {
    let quality = TetQuality::of(mesh);
    let data = MeshData { mesh, quality: &quality, second_order: None, encoding };
    write_mesh(mesh_file, MeshFormat::of(mesh_file).unwrap(), &data).unwrap();
    write_surface(surface_file, SurfaceFormat::of(surface_file).unwrap(), mesh, encoding).unwrap();
}

#[test]
fn vtk_reads_both_formats_back() {
    let folder = tempfile::tempdir().unwrap();
    for names in [["mesh.vtu", "surface.vtp"], ["mesh.vtk", "surface.vtk"]] {
        let [mesh_file, surface_file] = names.map(|name| folder.path().join(name));
        write_both(&two_cubes(), &mesh_file, &surface_file, Encoding::Binary);
        python::run("check_mesh.py", &[&mesh_file, &surface_file]);
    }
}

#[test]
fn appended_arrays_follow_each_other_without_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh_file, surface_file] = ["mesh.vtu", "surface.vtp"].map(|name| folder.path().join(name));
    write_both(&two_cubes(), &mesh_file, &surface_file, Encoding::Binary);
    for file in [mesh_file, surface_file] {
        let bytes = fs::read(&file).unwrap();
        let behind = |text: &[u8]| bytes.windows(text.len()).position(|w| w == text).unwrap() + text.len();
        let begin = behind(b"<AppendedData encoding=\"raw\">\n_");
        let markup = std::str::from_utf8(&bytes[..begin]).unwrap();
        let offsets = markup.split("offset=\"").skip(1).map(|s| s.split('"').next().unwrap().parse::<usize>().unwrap());
        let mut end = 0;
        for offset in offsets {
            assert_eq!(offset, end, "{}", file.display());
            let length = &bytes[begin + offset..][..8];
            end = offset + 8 + u64::from_le_bytes(length.try_into().unwrap()) as usize;
        }
        assert!(end > 0);
        assert_eq!(&bytes[begin + end..], b"\n  </AppendedData>\n</VTKFile>\n");
    }
}

pub fn model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)
}

/// Meshes the small bunny; the mesh, its surface and the report are in `folder`.
fn mesh_bunny(folder: &Path, arguments: &[&str]) -> [PathBuf; 3] {
    let files = ["bunny.vtu", "bunny.surface.vtp", "bunny.json"].map(|name| folder.join(name));
    tetcvt(folder).arg(model("bunny.obj")).args(["--json", "bunny.json"]).args(arguments).assert().success();
    files
}

#[test]
fn the_files_of_the_bunny_are_what_they_should_be() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, surface, report] = mesh_bunny(folder.path(), &["--seeds", "4000", "--iterations", "10"]);
    python::run("check_mesh.py", &[&mesh, &surface, &report]);
    python::run("compare_tetgen.py", &[&model("bunny.obj"), &mesh, &report]);
}

#[test]
fn the_trajectory_ends_in_the_mesh_and_the_triangulation_is_delaunay() {
    let folder = tempfile::tempdir().unwrap();
    let [trajectory, delaunay] = ["t.npy", "d.vtu"].map(|name| folder.path().join(name));
    let arguments = [
        "--seeds",
        "1500",
        "--iterations",
        "4",
        "--tolerance",
        "0",
        "--trajectory",
        "t.npy",
        "--delaunay",
        "d.vtu",
        "--no-improve",
    ];
    let [mesh, _, report] = mesh_bunny(folder.path(), &arguments);
    // A valid mesh may take a few iterations more than were asked for.
    let report: serde_json::Value = serde_json::from_slice(&fs::read(report).unwrap()).unwrap();
    let frames = report["iterations"].as_array().unwrap().len() + 1;
    assert!(frames >= 5, "{frames}");
    python::run("check_trajectory.py", &[&trajectory, Path::new(&frames.to_string()), &mesh, &delaunay]);
}
