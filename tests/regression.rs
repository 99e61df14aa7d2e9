//! One small model for each mistake that was once made.

use glam::dvec3;
use tetcvt::params::Target;
use tetcvt::progress::Silent;
use tetcvt::quality::TetQuality;
use tetcvt::report::MeshReport;
use tetcvt::{Error, Params, Surface, TetMesh, tetrahedralize};

use crate::shapes::Shape;

fn params(count: usize) -> Params {
    Params { target: Target::Count(count), iterations: 25, ..Params::default() }
}

fn meshed(shape: &Shape, count: usize) -> (Surface, TetMesh) {
    let surface = shape.surface().expect("a closed surface");
    let mesh = tetrahedralize(&surface, &params(count), &mut Silent).expect("a mesh");
    assert_eq!(mesh.points.len(), count);
    mesh.check().expect("a valid mesh");
    (surface, mesh)
}

/// The boundary ran across the creases of the narrow sides, where it was a manifold all the same.
#[test]
fn boundary_follows_creases_of_a_plate() {
    let (surface, mesh) = meshed(&Shape::cuboid(dvec3(0.0, 0.0, 0.0), dvec3(1.0, 0.7, 0.1)), 300);
    let report = MeshReport::of(&mesh, &TetQuality::of(&mesh), &surface);
    assert!(report.volume_error.abs() < 1e-12, "volume {}", report.volume_error);
    assert!(report.hausdorff < 1e-9, "distance {}", report.hausdorff);
}

/// Flat sides that meet at an acute angle were thin walls, of which no count was enough.
#[test]
fn acute_wedge_is_meshed() {
    let mut points = Vec::new();
    for z in [0.0, 0.5] {
        points.extend([dvec3(0.0, 0.0, z), dvec3(1.0, 0.0, z), dvec3(1.0, 0.05, z)]);
    }
    let triangles = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
    let shape = Shape { points, faces: triangles.iter().map(|t| t.to_vec()).collect() };
    let (surface, mesh) = meshed(&shape, 300);
    assert!(MeshReport::of(&mesh, &TetQuality::of(&mesh), &surface).volume_error.abs() < 1e-3);
}

/// The count that the refusal named left out the corners that a finer spacing resolves.
#[test]
fn refusal_of_a_rough_surface_names_a_count_that_will_do() {
    let mut shape = Shape::icosphere(4, 1.0);
    let mut rng = crate::support::Rng(7);
    for p in &mut shape.points {
        *p *= 1.0 + 0.1 * (rng.unit() - 0.5);
    }
    let surface = shape.surface().expect("a closed surface");
    match tetrahedralize(&surface, &params(300), &mut Silent) {
        Err(Error::TooFewSeeds { needed, .. }) => {
            let mesh = tetrahedralize(&surface, &params(needed), &mut Silent).expect("a mesh at the count named");
            assert_eq!(mesh.points.len(), needed);
        }
        other => panic!("300 vertices should be too few, not {:?}", other.map(|m| m.points.len())),
    }
}

/// Tets between two spheres that nearly touch reached deep into either, and left pits.
#[test]
fn spheres_that_nearly_touch_keep_their_shape() {
    let shape = Shape::icosphere(3, 1.0).with(&Shape::icosphere(3, 1.0).placed(dvec3(2.01, 0.0, 0.0), 1.0));
    let (surface, mesh) = meshed(&shape, 300);
    let report = MeshReport::of(&mesh, &TetQuality::of(&mesh), &surface);
    assert!(report.hausdorff < 0.04, "distance {}", report.hausdorff);
}
