//! Slivers taken out: what must stay as it was, and what must get better.

use std::path::Path;

use tetcvt::params::Target;
use tetcvt::progress::{Flow, Observer, Silent};
use tetcvt::quality::TetQuality;
use tetcvt::report::MeshReport;
use tetcvt::seeds::SeedKind;
use tetcvt::{Params, Surface, TetMesh, io, tetrahedralize};

fn surface(name: &str) -> Surface {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("models/{name}.obj"));
    io::read_surface(&file).expect("a valid model")
}

fn params(count: usize) -> Params {
    Params { target: Target::Count(count), iterations: 15, ..Params::default() }
}

fn meshed(surface: &Surface, params: &Params) -> (TetMesh, MeshReport) {
    let mesh = tetrahedralize(surface, params, &mut Silent).expect("a mesh");
    mesh.check().expect("a valid mesh");
    let report = MeshReport::of(&mesh, &TetQuality::of(&mesh), surface);
    (mesh, report)
}

/// Components cannot be told by it, but handles and cavities change it.
fn euler_characteristic(mesh: &TetMesh) -> i64 {
    let (vertices, triangles) = mesh.boundary_mesh();
    vertices.len() as i64 - triangles.len() as i64 / 2
}

#[test]
fn models_reach_the_floor_and_keep_what_they_had() {
    for (name, count, floor) in [
        ("bunny", 4000, 33.0),
        ("torus", 2000, 35.0),
        ("cube", 1000, 35.0),
        ("hollow_cube", 2000, 35.0),
        ("thin_plate", 1500, 27.0),
    ] {
        let surface = surface(name);
        let (before, rough) = meshed(&surface, &Params { improve: false, ..params(count) });
        let (after, fine) = meshed(&surface, &params(count));
        assert_eq!(after.points.len(), count, "{name}");
        assert!(
            fine.min_dihedral >= floor,
            "{name}: {} from {}, {}",
            fine.min_dihedral,
            rough.min_dihedral,
            after.improved
        );
        assert!(fine.max_dihedral < rough.max_dihedral, "{name}: {}", fine.max_dihedral);
        assert!(fine.mean_min_dihedral > rough.mean_min_dihedral, "{name}: {}", fine.mean_min_dihedral);
        // The floor for the worst costs the rest a little where the surface is rough for the spacing.
        assert!(fine.mean_radius_ratio > rough.mean_radius_ratio - 0.01, "{name}: {}", fine.mean_radius_ratio);
        assert_eq!(euler_characteristic(&after), euler_characteristic(&before), "{name}");
        // Corners of the noise of a scan may be let off; those of exact shapes stay.
        let corners = [after.count(SeedKind::Corner), before.count(SeedKind::Corner)];
        assert!(corners[0] == corners[1] || (name == "bunny" && corners[0] < corners[1]), "{name}: {corners:?}");
        for (&p, &kind) in after.points.iter().zip(&after.kinds).filter(|(_, kind)| **kind != SeedKind::Interior) {
            let p = surface.frame().to_frame(p);
            let away = surface.tree().closest(p).distance2.sqrt();
            assert!(away < 1e-14, "{name}: a vertex of kind {kind:?} is {away} away from the surface");
        }
        // In the mean closer; one place of a scan that is coarsely followed may be farther.
        let [fine_rms, rough_rms] = [&fine, &rough].map(|m| m.rms_distance);
        assert!(fine_rms < 1.02 * rough_rms + 1e-9, "{name}: {fine_rms} from {rough_rms}");
        assert!(fine.hausdorff < 1.3 * rough.hausdorff + 1e-9, "{name}: {} from {}", fine.hausdorff, rough.hausdorff);
        assert!(fine.volume_error.abs() < rough.volume_error.abs() + 5e-4, "{name}: {}", fine.volume_error);
        if ["cube", "thin_plate"].contains(&name) {
            assert!(fine.volume_error.abs() < 1e-12, "{name}: {}", fine.volume_error);
        }
    }
}

#[test]
fn the_volume_is_preserved_where_asked_for() {
    for (name, count) in [("bunny", 2000), ("torus", 800), ("cube", 500)] {
        let surface = surface(name);
        let (on_surface, plain) = meshed(&surface, &params(count));
        let (mesh, report) = meshed(&surface, &Params { preserve_volume: true, ..params(count) });
        assert!(report.volume_error.abs() < 1e-4, "{name}: {} from {}", report.volume_error, plain.volume_error);
        let [was, is] = [plain.hausdorff, report.hausdorff];
        assert!(is <= was * 1.001, "{name}: Hausdorff distance {is} from {was}");
        assert!(report.min_dihedral >= plain.min_dihedral.min(35.0) - 1e-4, "{name}: {}", report.min_dihedral);
        assert_eq!(mesh.tets, on_surface.tets, "{name}");
        for v in 0..count {
            let stays = mesh.kinds[v] != SeedKind::Surface || name == "cube";
            assert!(!stays || mesh.points[v] == on_surface.points[v], "{name}: vertex {v}");
        }
    }
}

#[test]
fn bodies_stay_apart() {
    let surface = surface("two_bodies");
    let (before, _) = meshed(&surface, &Params { improve: false, ..params(1500) });
    let (after, report) = meshed(&surface, &params(1500));
    let volume = |mesh: &TetMesh, region: u32| -> f64 {
        let own = |&(t, _): &(usize, &u32)| mesh.regions[t] == region;
        mesh.regions
            .iter()
            .enumerate()
            .filter(own)
            .map(|(t, _)| {
                let [a, b, c, d] = mesh.corners(t);
                tetcvt::geometry::tetrahedron::volume(a, b, c, d)
            })
            .sum()
    };
    for region in 0..2 {
        let (was, is) = (volume(&before, region), volume(&after, region));
        assert!(was > 0.0 && (is / was - 1.0).abs() < 0.01, "region {region}: {is} from {was}");
    }
    assert!(report.min_dihedral > 25.0, "{}: {}", report.min_dihedral, after.improved);
}

#[test]
fn no_floor_lowers_the_smallest_angle() {
    let surface = surface("torus");
    let (_, rough) = meshed(&surface, &Params { improve: false, ..params(600) });
    for floor in [0.0, 20.0, 50.0] {
        let (mesh, fine) = meshed(&surface, &Params { min_dihedral: floor, ..params(600) });
        assert_eq!(mesh.points.len(), 600);
        assert!(fine.min_dihedral >= rough.min_dihedral.min(floor) - 1e-4, "{floor}: {}", fine.min_dihedral);
        // 50 degrees are out of reach: that must be said.
        let reached = mesh.improved.contains("at least");
        assert_eq!(reached, fine.min_dihedral >= floor, "{floor}: {}", mesh.improved);
    }
}

fn assert_same_on_one_and_three_threads(surface: &Surface, params: &Params) {
    let [one, three] = [1, 3].map(|threads| meshed(surface, &Params { threads, ..params.clone() }).0);
    assert_eq!(one.tets, three.tets);
    assert_eq!(one.points, three.points);
    assert_eq!(one.boundary, three.boundary);
}

#[test]
fn the_same_on_any_number_of_threads() {
    assert_same_on_one_and_three_threads(&surface("bunny"), &params(1500));
}

#[test]
fn the_same_on_any_number_of_threads_in_parts() {
    // Work is done in parts of some 4000 tets, 1000 of them below the floor; this one is nearly out of reach.
    let (surface, floor) = (surface("torus"), 46.0);
    let params = Params { min_dihedral: floor, ..params(3200) };
    let (rough, _) = meshed(&surface, &Params { improve: false, ..params.clone() });
    let below = TetQuality::of(&rough).min_dihedral.into_iter().filter(|&angle| angle < floor).count();
    assert!(rough.tets.len() > 2 * 4000 && below > 2 * 1000, "{below} of {} tets are one part", rough.tets.len());
    assert_same_on_one_and_three_threads(&surface, &params);
}

/// Stops before the improvement's pass of that number.
struct Until(usize);

impl Observer for Until {
    fn improving(&mut self, _below: usize) -> Flow {
        match self.0.checked_sub(1) {
            Some(left) => {
                self.0 = left;
                Flow::Continue
            }
            None => Flow::Stop,
        }
    }
}

#[test]
fn stopped_between_passes_the_mesh_is_valid() {
    let surface = surface("torus");
    let (before, rough) = meshed(&surface, &Params { improve: false, ..params(600) });
    for passes in 0..6 {
        let mesh = tetrahedralize(&surface, &params(600), &mut Until(passes)).expect("a mesh");
        mesh.check().expect("a valid mesh");
        assert_eq!(mesh.points.len(), 600);
        let fine = MeshReport::of(&mesh, &TetQuality::of(&mesh), &surface);
        assert!(fine.min_dihedral >= rough.min_dihedral, "{passes}: {}", fine.min_dihedral);
        assert_eq!(mesh.tets.len() == before.tets.len() && mesh.points == before.points, passes == 0, "{passes}");
    }
}
