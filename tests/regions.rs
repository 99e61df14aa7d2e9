//! Nested shells as interfaces between regions: volumes, topology, cells, files.

#[cfg(feature = "cli")]
use std::path::{Path, PathBuf};

use glam::DVec3;
use tetcvt::clipped_voronoi::Clipper;
use tetcvt::delaunay::{Delaunay, INFINITE};
use tetcvt::geometry::tetrahedron::{circumcenter, volume};
use tetcvt::params::{Boundary, Target};
use tetcvt::progress::Silent;
use tetcvt::seeds::SeedKind;
use tetcvt::surface::defects::Marks;
use tetcvt::surface::{Regions, Treatment};
use tetcvt::{Params, Surface, TetMesh, tetrahedralize};

use crate::shapes::Shape;
use crate::support::Rng;

/// The surface of a shape whose shells are all kept.
pub fn nested(shape: &Shape) -> Surface {
    let triangles = shape.triangles();
    let source: Vec<u32> = (0..triangles.len() as u32).collect();
    let patch = vec![0; triangles.len()];
    let treatment = Treatment { regions: Regions::Nested, ..Treatment::default() };
    Surface::build(&shape.points, &triangles, [&source, &patch], treatment, &mut Marks::default())
        .expect("a sound shape")
}

fn cuboid(half: f64) -> Shape {
    Shape::cuboid(DVec3::splat(-half), DVec3::splat(half))
}

fn sphere(level: u32, radius: f64, x: f64) -> Shape {
    Shape::icosphere(level, radius).placed(DVec3::X * x, 1.0)
}

/// Models, with the shell right around each shell.
fn models() -> Vec<(&'static str, Shape, Vec<i32>)> {
    vec![
        ("concentric spheres", sphere(3, 1.0, 0.0).with(&sphere(2, 0.5, 0.0)), vec![-1, 0]),
        // Which way an interface faces is all the same.
        ("nested boxes", cuboid(1.0).with(&cuboid(0.7).reversed()).with(&cuboid(0.3)), vec![-1, 0, 1]),
        ("two spheres in a box", sphere(2, 0.4, -0.45).with(&sphere(2, 0.35, 0.45)).with(&cuboid(1.0)), vec![2, 2, -1]),
        (
            "two bodies",
            sphere(2, 0.5, 2.5).with(&cuboid(1.0)).with(&sphere(3, 1.0, 2.5)).with(&cuboid(0.4)),
            vec![2, -1, -1, 1],
        ),
    ]
}

fn params(count: usize) -> Params {
    Params { target: Target::Count(count), iterations: 12, check: true, ..Params::default() }
}

fn mesh(name: &str, surface: &Surface, params: &Params) -> TetMesh {
    let mesh = tetrahedralize(surface, params, &mut Silent).unwrap_or_else(|e| panic!("{name}: {e}"));
    mesh.check().unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(Target::Count(mesh.points.len()), params.target, "{name}");
    mesh
}

/// Volumes of the regions, from the tets.
fn volumes(mesh: &TetMesh, count: usize) -> Vec<f64> {
    let mut volumes = vec![0.0; count];
    for (t, &r) in mesh.regions.iter().enumerate() {
        let [a, b, c, d] = mesh.corners(t);
        volumes[r as usize] += volume(a, b, c, d);
    }
    volumes
}

/// Volumes of the regions of a surface, in the model's units.
fn wanted(surface: &Surface, around: &[i32]) -> Vec<f64> {
    let unit = surface.frame().length_to_model(1.0).powi(3);
    let enclosed = |s: usize| surface.volume_of_shell(s as u32) * unit;
    let within = |s: usize| (0..around.len()).filter(move |&i| around[i] == s as i32);
    (0..around.len()).map(|s| enclosed(s) - within(s).map(enclosed).sum::<f64>()).collect()
}

/// Every region is connected, and its facets, turned to face outward, enclose the volume of its tets.
fn assert_regions_are_closed(name: &str, mesh: &TetMesh, volumes: &[f64]) {
    for (r, volume) in volumes.iter().enumerate() {
        let side = |f: &&tetcvt::tet_mesh::BoundaryTriangle| f.region_inside as usize == r;
        let other = |f: &&tetcvt::tet_mesh::BoundaryTriangle| f.region_outside == r as i32;
        let flux = |f: &tetcvt::tet_mesh::BoundaryTriangle| {
            let [a, b, c] = f.vertices.map(|v| mesh.points[v as usize]);
            a.dot(b.cross(c)) / 6.0
        };
        let enclosed = mesh.boundary.iter().filter(side).map(flux).sum::<f64>()
            - mesh.boundary.iter().filter(other).map(flux).sum::<f64>();
        assert!((enclosed - volume).abs() < 1e-10, "{name}: facets of region {r} enclose {enclosed}, not {volume}");
    }
}

/// V - E + F of the facets between two regions: every edge has two of them.
fn euler(mesh: &TetMesh, inside: u32, outside: i32) -> i64 {
    let own = || mesh.boundary.iter().filter(|f| (f.region_inside, f.region_outside) == (inside, outside));
    let mut vertices: Vec<u32> = own().flat_map(|f| f.vertices).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.len() as i64 - own().count() as i64 / 2
}

#[test]
fn every_shell_is_an_interface_between_two_regions() {
    for (name, shape, around) in models() {
        let surface = nested(&shape);
        let count = around.len();
        for (shell, &right_around) in around.iter().enumerate() {
            let mut regions = surface.regions_of_shell(shell as u32);
            regions.sort_unstable();
            let mut expected = [right_around, shell as i32];
            expected.sort_unstable();
            assert_eq!(regions, expected, "{name}");
        }
        let mesh = mesh(name, &surface, &params(1800));
        let volumes = volumes(&mesh, count);
        for (r, (volume, wanted)) in volumes.iter().zip(wanted(&surface, &around)).enumerate() {
            assert!((volume / wanted - 1.0).abs() < 0.1, "{name}: region {r} has {volume}, not {wanted}");
        }
        let whole = surface.volume() * surface.frame().length_to_model(1.0).powi(3);
        assert!((mesh.volume() / whole - 1.0).abs() < 0.03, "{name}: {} of {whole}", mesh.volume());
        assert_regions_are_closed(name, &mesh, &volumes);
        // Each shell once, between the region within and the one around it; all are spheres.
        for (shell, &right_around) in around.iter().enumerate() {
            assert_eq!(euler(&mesh, shell as u32, right_around), 2, "{name}: shell {shell}");
        }
        let sides = |f: &tetcvt::tet_mesh::BoundaryTriangle| around[f.region_inside as usize] == f.region_outside;
        assert!(mesh.boundary.iter().all(sides), "{name}");
        // Vertices of interfaces stay on the surface.
        for v in mesh.boundary.iter().flat_map(|f| f.vertices).map(|v| v as usize) {
            if mesh.kinds[v] != SeedKind::Interior {
                let p = surface.frame().to_frame(mesh.points[v]);
                let distance = surface.tree().closest(p).distance2.sqrt();
                assert!(distance < 1e-12, "{name}: vertex {v} is off the surface by {distance}");
            }
        }
    }
}

#[test]
fn flat_interfaces_lose_no_volume() {
    // Not along the axes, where planes are exact.
    let mut shape = cuboid(1.0).with(&cuboid(0.7)).with(&cuboid(0.3));
    let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    shape.points.iter_mut().for_each(|p| *p = turn * *p);
    let surface = nested(&shape);
    let mesh = mesh("turned boxes", &surface, &params(1500));
    for (volume, wanted) in volumes(&mesh, 3).into_iter().zip([8.0 - 2.744, 2.744 - 0.216, 0.216]) {
        assert!((volume - wanted).abs() < 1e-9, "{volume}, not {wanted}");
    }
}

#[test]
fn by_default_shells_go_by_parity() {
    let shape = cuboid(1.0).with(&cuboid(0.7)).with(&cuboid(0.3));
    let surface = shape.surface().expect("three shells");
    assert!(!surface.has_interfaces());
    let mesh = mesh("parity", &surface, &params(1500));
    let [outer, inner] = volumes(&mesh, 2)[..] else { panic!("two solids") };
    assert!((outer - (8.0 - 2.744)).abs() < 1e-9 && (inner - 0.216).abs() < 1e-9, "{outer} {inner}");
    assert!(mesh.boundary.iter().all(|f| f.region_outside == -1));
}

#[test]
fn free_seeds_and_no_improvement_keep_regions_too() {
    let (name, shape, around) = models().swap_remove(0);
    let surface = nested(&shape);
    for (boundary, improve) in [(Boundary::Free, true), (Boundary::Free, false), (Boundary::Conform, false)] {
        let mesh = mesh(name, &surface, &Params { boundary, improve, ..params(1500) });
        let volumes = volumes(&mesh, around.len());
        assert_regions_are_closed(name, &mesh, &volumes);
        for (volume, wanted) in volumes.into_iter().zip(wanted(&surface, &around)) {
            assert!((volume / wanted - 1.0).abs() < 0.25, "{boundary:?}: {volume}, not {wanted}");
        }
    }
}

/// Interfaces have seeds, but cut no cell: volumes, centroids and energies are those that the outer shells give alone.
#[test]
fn cells_reach_across_interfaces() {
    let (inner, outer) = (sphere(2, 0.5, 0.1), sphere(3, 1.0, 0.0));
    let surface = nested(&inner.clone().with(&outer));
    let alone = outer.surface().expect("a sphere");
    assert!((surface.volume() / alone.volume() - 1.0).abs() < 1e-14);
    let mut rng = Rng(3);
    let mut seeds: Vec<DVec3> = (0..600).map(|_| rng.point() * 1.2 - 0.6).collect();
    seeds.extend(inner.points.iter().map(|p| surface.frame().to_frame(*p)));
    let seeds: Vec<DVec3> = seeds.into_iter().map(tetcvt::geometry::frame::snap).collect();
    let delaunay = Delaunay::build(&seeds).expect("distinct seeds");
    let (whole, plain) = (Clipper::new(&surface).clip(&delaunay), Clipper::new(&alone).clip(&delaunay));
    for (a, b) in whole.cells.iter().zip(&plain.cells) {
        assert!((a.volume - b.volume).abs() < 1e-15 && (a.energy - b.energy).abs() < 1e-15, "{a:?} {b:?}");
        assert!(a.moment.distance(b.moment) < 1e-15, "{a:?} {b:?}");
    }
    let area: f64 = whole.cells.iter().map(|c| c.area).sum();
    assert!((area / surface.area() - 1.0).abs() < 1e-12 && area > alone.area() * 1.2, "{area}");
    assert_eq!(whole.inside, plain.inside);
    // What is behind the surface is between the two shells.
    let mut known = 0;
    for (t, tet) in delaunay.vertices().iter().enumerate().filter(|(_, tet)| tet[3] != INFINITE) {
        let [a, b, c, d] = tet.map(|v| seeds[v as usize]);
        let center = circumcenter(a, b, c, d);
        if center.is_finite() && surface.tree().closest(center).distance2 > 1e-18 {
            assert_eq!(whole.inside[t], surface.is_inside(center), "{center}");
            assert_eq!(whole.behind()[t], surface.tree().is_inside(center), "{center}");
            known += 1;
        }
    }
    assert!(known > 2000, "{known}");
    assert!(plain.odd.is_none() && plain.behind() == plain.inside);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let (name, shape, _) = models().swap_remove(2);
    let surface = nested(&shape);
    let [one, three] = [1, 3].map(|threads| mesh(name, &surface, &Params { threads, ..params(700) }));
    assert!(one.points == three.points && one.tets == three.tets && one.boundary == three.boundary);
    assert_eq!(one.regions, three.regions);
}

/// Every format, read back by the programs that it is for: volumes of regions, and interfaces once, between two of them.
#[cfg(feature = "cli")]
#[test]
fn files_have_regions_and_interfaces() {
    use crate::cli::tetcvt;
    use crate::output::write_both;
    use crate::python;
    use tetcvt::io::format::Encoding;

    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let shape = cuboid(1.0).with(&cuboid(0.5));
    std::fs::write(at("boxes.obj"), shape.obj("two nested boxes")).expect("a writable folder");
    let arguments = ["boxes.obj", "--regions", "nested", "--seeds", "900", "--iterations", "5", "--quiet"];
    let more = ["--voronoi", "cells.vtu", "--json", "run.json"];
    tetcvt(folder.path()).args(arguments).args(more).assert().success();
    let paths: Vec<PathBuf> =
        ["boxes.vtu", "boxes.surface.vtp", "cells.vtu", "run.json"].iter().map(|name| at(name)).collect();
    python::run("check_regions.py", &paths.iter().map(PathBuf::as_path).collect::<Vec<&Path>>());

    let mesh = mesh("boxes", &nested(&shape), &params(900));
    let mut files = vec![at("mesh.vtu"), at("surface.vtp")];
    write_both(&mesh, &files[0], &files[1], Encoding::Binary);
    for (mesh_file, surface_file, encoding) in [
        ("a.msh", "a.stl", Encoding::Binary),
        ("b.msh", "a.ply", Encoding::Text),
        ("a.mesh", "b.ply", Encoding::Binary),
        ("a.inp", "a.obj", Encoding::Text),
        ("a.node", "b.stl", Encoding::Text),
    ] {
        write_both(&mesh, &at(mesh_file), &at(surface_file), encoding);
        files.extend([at(mesh_file), at(surface_file)]);
    }
    python::run("check_formats.py", &files.iter().map(PathBuf::as_path).collect::<Vec<&Path>>());
}
