//! The relaxation: energy, kinds of seeds, determinism, stopping.

use glam::DVec3;
use tetcvt::delaunay::Delaunay;
use tetcvt::geometry::frame::Frame;
use tetcvt::geometry::tetrahedron::dihedral_angles;
use tetcvt::params::{Boundary, Optimizer, Start, Target};
use tetcvt::progress::{Flow, Move, Step};
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
    // What follows the relaxation moves vertices too.
    let improve = false;
    Params { target: Target::Count(seeds), iterations, tolerance: 0.0, check: true, improve, ..Params::default() }
}

fn run(surface: &Surface, params: &Params) -> (TetMesh, Recorder) {
    let mut recorder = Recorder::default();
    let mesh = tetrahedralize(surface, params, &mut recorder).expect("a valid mesh");
    (mesh, recorder)
}

/// The energies that the first iterations began with: those of the optimiser, before any seed is moved elsewhere and the steps
/// against slivers.
fn optimized(mesh: &TetMesh) -> Vec<f64> {
    let other = |s: &Step| matches!(s.kind, Move::Insertion | Move::Odt);
    mesh.steps.iter().take_while(|s| !other(s)).map(|s| s.energy).collect()
}

#[test]
fn the_energy_of_free_seeds_never_rises() {
    let surfaces = [(Shape::cube(), 300), (Shape::torus(48, 24, 1.0, 0.4), 800), (Shape::icosphere(3, 2.0), 300)];
    for (surface, seeds) in surfaces {
        let surface = shape(surface);
        for optimizer in [Optimizer::Lbfgs, Optimizer::Lloyd] {
            for start in [Start::Random, Start::Bcc] {
                let params = Params { boundary: Boundary::Free, optimizer, start, ..params(seeds, 30) };
                let energies = optimized(&run(&surface, &params).0);
                assert!(energies.len() >= 24);
                for (k, pair) in energies.windows(2).enumerate() {
                    assert!(pair[1] <= pair[0] * (1.0 + 1e-13), "{optimizer:?}, {k}: {} to {}", pair[0], pair[1]);
                }
                assert!(energies[23] < 0.999 * energies[0]);
            }
        }
    }
}

#[test]
fn memory_and_momentum_gain_iterations() {
    let surface = shape(Shape::torus(48, 24, 1.0, 0.4));
    for boundary in [Boundary::Free, Boundary::Conform] {
        let energies = [Optimizer::Lloyd, Optimizer::Nesterov, Optimizer::Lbfgs].map(|optimizer| {
            let params = Params { boundary, optimizer, start: Start::Random, ..params(1500, 45) };
            let (mesh, _) = run(&surface, &params);
            assert!(mesh.steps.iter().all(|s| (1..=2).contains(&s.evaluations)));
            optimized(&mesh)
        });
        let lloyd = energies[0][energies[0].len() - 1];
        for (k, fast) in energies[1..].iter().enumerate() {
            let reached = fast.iter().position(|&e| e <= lloyd).expect("the energy of Lloyd's iteration");
            assert!(3 * reached <= 2 * energies[0].len(), "{boundary:?}, {k}: {reached}");
        }
    }
}

#[test]
fn the_last_steps_leave_fewer_slivers() {
    let surface = shape(Shape::cube());
    let (mesh, record) = run(&surface, &Params { start: Start::Random, ..params(1500, 30) });
    let first = mesh.steps.iter().position(|s| s.kind == Move::Odt).expect("steps against slivers");
    let slivers = |positions: &[DVec3]| {
        let delaunay = Delaunay::build(positions).expect("distinct seeds");
        let corners = |tet: [u32; 4]| tet.map(|v| positions[v as usize]);
        let is_sliver = |[a, b, c, d]: [DVec3; 4]| dihedral_angles(a, b, c, d).into_iter().any(|x| x < 15.0);
        delaunay.tets().filter(|&t| is_sliver(corners(t))).count()
    };
    // positions[k] are those that step k begins with.
    let [before, after] = [&record.positions[first], &record.positions[mesh.steps.len()]].map(|p| slivers(p));
    assert!(3 * after < 2 * before, "{before} to {after}");
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
    for optimizer in [Optimizer::Nesterov, Optimizer::Lbfgs] {
        same_mesh_on_any_number_of_threads(&surface, optimizer);
    }
}

fn same_mesh_on_any_number_of_threads(surface: &Surface, optimizer: Optimizer) {
    let meshes = [1, 2, 3].map(|threads| run(surface, &Params { threads, optimizer, ..params(5000, 8) }).0);
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
fn the_time_limit_ends_the_run_with_a_valid_mesh() {
    let surface = shape(Shape::icosphere(3, 1.0));
    let params = Params { time_limit: Some(0.0), ..params(500, 1000) };
    let (mesh, _) = run(&surface, &params);
    mesh.check().expect("a valid mesh");
    assert_eq!(mesh.points.len(), 500);
    assert!(mesh.steps.len() < 10, "{} iterations", mesh.steps.len());
    assert!(mesh.stopped.contains("time"), "{}", mesh.stopped);
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

#[test]
fn seeds_that_settle_before_the_surface_is_followed_save_iterations() {
    let surface = shape(Shape::icosphere(4, 1.0));
    let made = |tolerance: f64| run(&surface, &Params { tolerance, improve: false, ..params(3000, 25) }).0;
    let (early, all) = (made(1e-3), made(0.0));
    let made = [early.steps.len(), all.steps.len()];
    // The last few, against slivers, end where one leaves no fewer.
    assert!(made[0] < made[1] && made[1] >= 22, "{made:?}");
    assert!(
        early.stopped.contains("settled early") && !all.stopped.contains("settled"),
        "{}, {}",
        early.stopped,
        all.stopped
    );
}
