//! The relaxation: energy, kinds of seeds, determinism, stopping.

use glam::DVec3;
use tetcvt::geometry::frame::Frame;
use tetcvt::params::{Boundary, Target};
use tetcvt::progress::{Flow, Step};
use tetcvt::seeds::SeedKind;
use tetcvt::{Observer, Params, Surface, TetMesh, tetrahedralize};

use crate::shapes::Shape;

/// Remembers the positions after each iteration, in model coordinates, and may stop the run.
#[derive(Default)]
struct Recorder {
    positions: Vec<Vec<DVec3>>,
    energies: Vec<f64>,
    stop_after: Option<usize>,
}

impl Observer for Recorder {
    fn seeds(&mut self, step: Option<&Step>, positions: &[DVec3], frame: &Frame) -> Flow {
        self.positions.push(positions.iter().map(|&p| frame.to_model(p)).collect());
        self.energies.extend(step.map(|s| s.energy));
        if self.stop_after.is_some_and(|k| self.energies.len() >= k) { Flow::Stop } else { Flow::Continue }
    }
}

fn shape(shape: Shape) -> Surface {
    shape.surface().expect("a valid shape")
}

fn params(seeds: usize, iterations: usize) -> Params {
    Params { target: Target::Count(seeds), iterations, tolerance: 0.0, check: true, ..Params::default() }
}

fn run(surface: &Surface, params: &Params) -> (TetMesh, Recorder) {
    let mut recorder = Recorder::default();
    let mesh = tetrahedralize(surface, params, &mut recorder).expect("a valid mesh");
    (mesh, recorder)
}

#[test]
fn the_energy_of_free_seeds_never_rises() {
    for (surface, seeds) in
        [(Shape::cube(), 300), (Shape::torus(48, 24, 1.0, 0.4), 800), (Shape::icosphere(3, 2.0), 300)]
    {
        let surface = shape(surface);
        let params = Params { boundary: Boundary::Free, ..params(seeds, 40) };
        let (_, record) = run(&surface, &params);
        assert!(record.energies.len() >= 40);
        // Seeds added for a valid mesh come after the forty.
        for (k, pair) in record.energies[..40].windows(2).enumerate() {
            assert!(pair[1] <= pair[0] * (1.0 + 1e-13), "iteration {k}: {} to {}", pair[0], pair[1]);
        }
        assert!(record.energies[39] < 0.999 * record.energies[0]);
    }
}

#[test]
fn every_kind_of_seed_stays_where_it_belongs() {
    let surface = shape(Shape::cube());
    let (mesh, record) = run(&surface, &params(1000, 30));
    assert_eq!(mesh.points.len(), 1000);
    assert_eq!(mesh.count(SeedKind::Corner), 8);
    let on_planes = |p: DVec3| p.to_array().iter().filter(|&&x| x.abs() == 1.0).count();
    for (p, kind) in mesh.points.iter().zip(&mesh.kinds) {
        let least = match kind {
            SeedKind::Interior => 0,
            SeedKind::Surface => 1,
            SeedKind::Curve => 2,
            SeedKind::Corner => 3,
        };
        // Faces are flat to the last bit, and so are the mesh's.
        assert_eq!(on_planes(*p), least, "{kind:?} at {p}");
    }
    // Corners never moved, and the mesh has the seeds' last places.
    let last = record.positions.last().expect("positions at the start");
    for (v, &seed) in mesh.seeds.iter().enumerate() {
        assert_eq!(mesh.points[v], last[seed as usize]);
        if mesh.kinds[v] == SeedKind::Corner {
            assert!(record.positions.iter().all(|p| p[seed as usize] == mesh.points[v]));
        }
    }
    assert!((mesh.volume() - 8.0).abs() < 1e-12);
}

#[test]
fn the_same_mesh_on_any_number_of_threads() {
    let surface = shape(Shape::torus(60, 30, 1.0, 0.35));
    let meshes = [1, 2, 3].map(|threads| run(&surface, &Params { threads, ..params(3000, 8) }).0);
    for other in &meshes[1..] {
        assert_eq!(meshes[0].points, other.points);
        assert_eq!(meshes[0].tets, other.tets);
        assert_eq!(meshes[0].boundary, other.boundary);
        assert_eq!(meshes[0].kinds, other.kinds);
    }
    let energy = |m: &TetMesh| m.steps.iter().map(|s| s.energy.to_bits()).collect::<Vec<_>>();
    assert_eq!(energy(&meshes[0]), energy(&meshes[2]));
}

#[test]
fn the_random_seed_matters() {
    let surface = shape(Shape::icosphere(3, 1.0));
    let [a, b] = [1, 2].map(|random_seed| run(&surface, &Params { random_seed, ..params(400, 3) }).0);
    assert_ne!(a.points, b.points);
}

#[test]
fn a_caller_that_stops_gets_the_mesh_so_far() {
    let surface = shape(Shape::icosphere(3, 1.0));
    let mut recorder = Recorder { stop_after: Some(2), ..Recorder::default() };
    let mesh = tetrahedralize(&surface, &params(500, 50), &mut recorder).expect("a valid mesh");
    mesh.check().expect("a valid mesh");
    assert_eq!(mesh.points.len(), 500);
    assert!(mesh.steps.len() < 10, "{} iterations", mesh.steps.len());
}

#[test]
fn the_tolerance_ends_the_run() {
    let surface = shape(Shape::cube());
    let params = Params { tolerance: 1e-3, ..params(400, 200) };
    let (mesh, _) = run(&surface, &params);
    assert!(mesh.steps.len() < 100, "{} iterations", mesh.steps.len());
    assert!(mesh.stopped.contains("energy"), "{}", mesh.stopped);
}

#[test]
fn relaxed_seeds_are_evenly_spaced() {
    // Edges within the surface, from it to the interior, and within the interior; on a curved surface seeds would also go
    // where flat facets cut off most.
    let surface = shape(Shape::cube());
    let (mesh, _) = run(&surface, &params(4000, 40));
    let mut sums = [(0.0, 0usize); 3];
    for tet in &mesh.tets {
        for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            let (a, b) = (tet[i] as usize, tet[j] as usize);
            let on_surface = [a, b].iter().filter(|&&v| mesh.kinds[v] != SeedKind::Interior).count();
            sums[on_surface].0 += mesh.points[a].distance(mesh.points[b]);
            sums[on_surface].1 += 1;
        }
    }
    let means = sums.map(|(sum, count)| sum / count as f64);
    for mean in means {
        assert!((mean / means[0] - 1.0).abs() < 0.15, "{means:?}");
    }
}
