//! The unit of length and the origin do not matter: a model at any scale and offset has the same mesh.

use glam::DVec3;
use tetcvt::clipped_voronoi::{Clipper, Polyhedra};
use tetcvt::delaunay::Delaunay;
use tetcvt::params::Target;
use tetcvt::progress::{Observer, Silent};
use tetcvt::second_order::SecondOrder;
use tetcvt::surface::features::Features;
use tetcvt::{Params, Surface, TetMesh, tetrahedralize};

use crate::shapes::Shape;

/// The mesh of a model that is placed somewhere.
fn mesh(shape: &Shape, shift: DVec3, scale: f64) -> TetMesh {
    mesh_of(shape, shift, scale, true)
}

/// The same, with slivers left in it or not.
fn mesh_of(shape: &Shape, shift: DVec3, scale: f64, improve: bool) -> TetMesh {
    let placed = Shape { points: shape.points.clone(), faces: shape.faces.clone() }.placed(shift, scale);
    let surface = placed.surface().unwrap_or_else(|defect| panic!("{scale} {shift}: {defect}"));
    let (target, check) = (Target::Count(400), true);
    let params = Params { target, iterations: 4, tolerance: 0.0, improve, check, ..Params::default() };
    let mesh = tetrahedralize(&surface, &params, &mut Silent).unwrap_or_else(|e| panic!("{scale} {shift}: {e}"));
    mesh.check().unwrap_or_else(|violation| panic!("{scale} {shift}: {violation}"));
    mesh
}

/// A sphere, and a tetrahedron without symmetries, which has creases and corners.
fn shapes() -> [Shape; 2] {
    let mut creased = Shape::tetrahedron();
    creased.points[1] = DVec3::new(1.0, 0.1, 0.05);
    creased.points[2] = DVec3::new(0.2, 0.9, -0.1);
    creased.points[3] = DVec3::new(0.15, 0.3, 0.8);
    [Shape::icosphere(3, 1.0), creased]
}

/// Whether a mesh is another one brought elsewhere, for all that rounding may have decided otherwise.
fn assert_alike(one: &TetMesh, other: &TetMesh, scale: f64, case: &str) {
    assert_eq!(one.points.len(), other.points.len(), "{case}");
    let [volume, others] = [one.volume(), other.volume() / scale / scale / scale];
    assert!((volume / others - 1.0).abs() < 1e-3, "{case}: volumes {volume}, {others}");
    let [tets, others] = [one, other].map(|mesh| mesh.tets.len() as f64);
    assert!((tets / others - 1.0).abs() < 0.06, "{case}: {tets} and {others} tets");
}

/// The tets as sets of vertices, sorted: equal for meshes whose tets are listed or turned in another way.
fn tets(mesh: &TetMesh) -> Vec<[u32; 4]> {
    let mut tets = mesh.tets.clone();
    tets.iter_mut().for_each(|t| t.sort_unstable());
    tets.sort_unstable();
    tets
}

/// Largest distance between vertices of `a` and of `b`, brought back.
fn difference(a: &TetMesh, b: &TetMesh, shift: DVec3, scale: f64) -> f64 {
    let apart = |(p, q): (&DVec3, &DVec3)| p.distance((*q - shift) / scale);
    a.points.iter().zip(&b.points).map(apart).fold(0.0, f64::max)
}

#[test]
fn powers_of_two_change_no_digit() {
    for shape in shapes() {
        let one = mesh(&shape, DVec3::ZERO, 1.0);
        for exponent in [-1000, -40, 40, 900] {
            let scale = 2f64.powi(exponent);
            let other = mesh(&shape, DVec3::ZERO, scale);
            assert!(one.points.iter().zip(&other.points).all(|(p, q)| *p * scale == *q), "2^{exponent}");
            assert!(one.tets == other.tets && one.boundary == other.boundary, "2^{exponent}");
        }
    }
}

#[test]
fn any_scale_gives_the_same_mesh() {
    let [smooth, creased] = shapes();
    // The improvement takes the worst tet first: which one that is, rounding may decide.
    let (one, one_creased) = (mesh_of(&smooth, DVec3::ZERO, 1.0, false), mesh(&creased, DVec3::ZERO, 1.0));
    for scale in [1e-12, 3e-7, 0.7, 1e5, 1e12] {
        let other = mesh_of(&smooth, DVec3::ZERO, scale, false);
        assert_eq!(tets(&one), tets(&other), "{scale}");
        let apart = difference(&one, &other, DVec3::ZERO, scale);
        assert!(apart < 1e-13, "{scale}: {apart}");
        // On creases rounding decides which of two stretches as long is split first.
        assert_alike(&one_creased, &mesh(&creased, DVec3::ZERO, scale), scale, &scale.to_string());
    }
}

#[test]
fn any_offset_gives_the_same_mesh_as_far_as_its_digits_go() {
    for shape in shapes() {
        let one = mesh(&shape, DVec3::ZERO, 1.0);
        for (scale, offset) in [(1.0, 1e3), (1e-12, -1e7), (1e12, 1e7), (0.3, 1e7)] {
            let shift = DVec3::new(1.0, -0.7, 0.3) * offset * scale;
            assert_alike(&one, &mesh(&shape, shift, scale), scale, &format!("{scale} {offset}"));
        }
    }
}

/// A sphere with a box in it, kept as an interface.
fn nested() -> Shape {
    Shape::icosphere(3, 1.0).with(&Shape::cuboid(DVec3::splat(-0.4), DVec3::splat(0.4)))
}

/// Regions, tets of the second order and clipped cells: the exact same under powers of two, alike elsewhere.
#[test]
fn regions_curved_tets_and_cells_come_with_the_mesh() {
    let run = |shift: DVec3, scale: f64| {
        let surface = crate::regions::nested(&nested().placed(shift, scale));
        let params =
            Params { target: Target::Count(600), iterations: 4, tolerance: 0.0, check: true, ..Params::default() };
        let mut watch = Cells::default();
        let mesh = tetrahedralize(&surface, &params, &mut watch).unwrap_or_else(|e| panic!("{scale} {shift}: {e}"));
        mesh.check().unwrap_or_else(|violation| panic!("{scale} {shift}: {violation}"));
        let curved = SecondOrder::of(&mesh, &surface, &Features::find(&surface, params.feature_angle));
        assert!((watch.volume - 1.0).abs() < 1e-11, "{scale} {shift}: the cells have {} of the volume", watch.volume);
        (mesh, curved)
    };
    let (one, one_curved) = run(DVec3::ZERO, 1.0);
    for scale in [2f64.powi(-600), 2f64.powi(500)] {
        let (other, curved) = run(DVec3::ZERO, scale);
        assert!(one.points.iter().zip(&other.points).all(|(p, q)| *p * scale == *q), "{scale}");
        assert!(one.regions == other.regions && one.boundary == other.boundary, "{scale}");
        assert!(one_curved.points.iter().zip(&curved.points).all(|(p, q)| *p * scale == *q), "{scale}");
    }
    for (scale, offset) in [(1e-12, 0.0), (1e12, 0.0), (1.0, 1e7), (1e-12, -1e7), (1e12, 1e7)] {
        let (other, curved) = run(DVec3::new(1.0, -0.7, 0.3) * offset * scale, scale);
        assert_alike(&one, &other, scale, &format!("{scale} {offset}"));
        for region in 0..2 {
            let count = |mesh: &TetMesh| mesh.regions.iter().filter(|&&r| r == region).count() as f64;
            let ratio = count(&one) / count(&other);
            assert!((ratio - 1.0).abs() < 0.1, "{scale} {offset}: region {region} differs by {ratio}");
        }
        let held_back = [&one_curved, &curved].map(|c| c.held_back);
        assert!(held_back[0].abs_diff(held_back[1]) <= 12, "{scale} {offset}: {held_back:?}");
    }
}

/// The share of the solid's volume that the clipped cells have at the end.
#[derive(Default)]
struct Cells {
    volume: f64,
}

impl Observer for Cells {
    fn triangulation(&mut self, delaunay: &Delaunay, surface: &Surface) {
        let cells = Clipper::new(surface).clip(delaunay);
        let polyhedra = Polyhedra::of(delaunay, surface, &cells, delaunay.points().len());
        let mut volume = 0.0;
        for c in 0..polyhedra.len() {
            for (corners, _) in polyhedra.faces(c) {
                let at = |i: usize| polyhedra.points[corners[i] as usize];
                volume += (1..corners.len() - 1).map(|i| at(0).dot(at(i).cross(at(i + 1))) / 6.0).sum::<f64>();
            }
        }
        self.volume = volume / surface.volume();
    }
}
