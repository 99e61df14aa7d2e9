//! What a run says of its mesh, against shapes whose numbers are known.

use glam::DVec3;
use tetcvt::Surface;
use tetcvt::quality::TetQuality;
use tetcvt::report::{Distance, InputReport, MeshReport};
use tetcvt::seeds::SeedKind;
use tetcvt::tet_mesh::{BoundaryTriangle, StageTimes, TetMesh};

/// The sides of a cube whose corner i is at (i & 1, i >> 1 & 1, i >> 2), outward.
const SIDES: [[u32; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];

/// Corners of a cube around `centre`.
fn corners(center: DVec3, side: f64) -> Vec<DVec3> {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) - 0.5;
    (0..8).map(|i| center + corner(i) * side).collect()
}

fn surface(center: DVec3, side: f64) -> Surface {
    let source: Vec<u32> = (0..12).collect();
    Surface::new(&corners(center, side), &SIDES, &source, &[0; 12]).unwrap()
}

/// Six tets around the diagonal from corner 0 to corner 7.
fn mesh(center: DVec3, side: f64) -> TetMesh {
    let boundary = (0..).zip(SIDES).map(|(source_triangle, vertices)| BoundaryTriangle {
        vertices,
        region_inside: 0,
        region_outside: -1,
        patch: 0,
        source_triangle,
    });
    TetMesh {
        points: corners(center, side),
        kinds: vec![SeedKind::Corner; 8],
        seeds: (0..8).collect(),
        tets: vec![[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]],
        regions: vec![0; 6],
        boundary: boundary.collect(),
        steps: Vec::new(),
        size_ratio: None,
        stopped: String::new(),
        improved: String::new(),
        times: StageTimes::default(),
    }
}

fn report(mesh: &TetMesh, surface: &Surface) -> MeshReport {
    MeshReport::of(mesh, &TetQuality::of(mesh), surface)
}

#[test]
fn a_mesh_that_fills_its_surface_has_no_error_at_any_scale() {
    for scale in [1e-30, 1.0, 1e30] {
        let center = DVec3::new(3.0, -7.0, 1.0) * scale;
        let report = report(&mesh(center, scale), &surface(center, scale));
        assert!(report.volume_error.abs() < 1e-14, "{scale}: {}", report.volume_error);
        assert!(report.hausdorff < 1e-14 && report.rms_distance < 1e-14, "{scale}: {}", report.hausdorff);
        assert!((report.volume / scale.powi(3) - 1.0).abs() < 1e-14, "{scale}: {}", report.volume);
        assert!((report.min_dihedral - 45.0).abs() < 1e-9 && (report.max_dihedral - 90.0).abs() < 1e-9);
        assert_eq!((report.corner_seeds, report.interior_seeds, report.tets), (8, 0, 6));
        let [region] = report.regions[..] else { panic!("{:?}", report.regions) };
        assert_eq!((region.region, region.tets, region.volume), (0, 6, report.volume));
        assert_eq!(report.dihedral_histogram.iter().sum::<u64>(), 36);
    }
}

#[test]
fn a_smaller_cube_in_a_larger_one() {
    let center = DVec3::new(3.0, -7.0, 1.0);
    let (surface, mesh) = (surface(center, 1.1), mesh(center, 1.0));
    let report = report(&mesh, &surface);
    let diagonal = 1.1 * 3f64.sqrt();
    assert!((report.volume_error - (1.0 / 1.331 - 1.0)).abs() < 1e-14, "{}", report.volume_error);
    // From corner to corner; sides are 0.05 apart.
    assert!((report.hausdorff - 0.05 * 3f64.sqrt() / diagonal).abs() < 1e-14, "{}", report.hausdorff);
    // From within, 0.05 everywhere. From without, u and v being how far a point of a side is beyond the inner cube,
    // the mean of 0.05^2 + u^2 + v^2, where the mean of u^2 is 2 (0.05^3 / 3) / 1.1.
    let out = 0.05f64.powi(2) + 2.0 * (2.0 * 0.05f64.powi(3) / 3.0) / 1.1;
    let rms = ((0.05f64.powi(2) + out) / 2.0).sqrt() / diagonal;
    assert!((report.rms_distance / rms - 1.0).abs() < 1e-3, "{} {rms}", report.rms_distance);
}

#[test]
fn the_mesh_outside_counts_as_much_as_the_surface_outside() {
    let center = DVec3::ZERO;
    let distance = Distance::between(&mesh(center, 1.1), &surface(center, 1.0));
    let other = Distance::between(&mesh(center, 1.0), &surface(center, 1.1));
    let scales = [surface(center, 1.0), surface(center, 1.1)].map(|s| s.frame().scale);
    let relative = (distance.hausdorff / scales[0]) / (other.hausdorff / scales[1]);
    assert!((relative - 1.0).abs() < 1e-12, "{relative}");
}

#[test]
fn the_surface_is_described_in_units_of_the_model() {
    let report = InputReport::of(&surface(DVec3::splat(100.0), 5.0), "cube.obj".into());
    assert_eq!((report.vertices, report.triangles, report.components, report.genus), (8, 12, 1, 0));
    assert!((report.volume - 125.0).abs() < 1e-9 && (report.area - 150.0).abs() < 1e-9);
    assert!((report.diagonal - 75f64.sqrt()).abs() < 1e-9);
}
