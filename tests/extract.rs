//! Tests of extract.

use std::collections::HashMap;

use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use tetcvt::clipped_voronoi::ClippedVoronoi;
use tetcvt::delaunay::{Delaunay, Facet, INFINITE};
use tetcvt::extract::boundary::{Boundary, regions};
use tetcvt::extract::complex::Complex;
use tetcvt::extract::mend::{Shape, settle};
use tetcvt::extract::repair::{Judge, Repair};
use tetcvt::extract::topology::Topology;
use tetcvt::extract::{DefectKind, Sampling, defects, label, mend, mesh, proposals};
use tetcvt::geometry::frame::snap;
use tetcvt::geometry::tetrahedron::{FACETS, centroid, circumcenter, volume6};
use tetcvt::params::{Params, Target};
use tetcvt::seeds::{Anchor, SeedKind, sample};
use tetcvt::surface::features::Features;
use tetcvt::{Surface, TetMesh};

use crate::support::Rng;

/// A triangulation made by hand, with infinite tets over its hull.
struct Made {
    points: Vec<DVec3>,
    tets: Vec<[u32; 4]>,
    neighbors: Vec<[Facet; 4]>,
    finite: usize,
    seeds: usize,
}

impl Made {
    /// Glues positively oriented tets over `points` along their facets, and infinite ones onto the rest.
    fn glue(points: Vec<DVec3>, mut tets: Vec<[u32; 4]>) -> Made {
        let sorted = |mut f: [u32; 3]| {
            f.sort();
            f
        };
        let finite = tets.len();
        let mut owners: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
        for (t, tet) in tets.iter().enumerate() {
            let [a, b, c, d] = tet.map(|v| points[v as usize]);
            assert!(volume6(a, b, c, d) > 0.0);
            for f in FACETS {
                owners.entry(sorted(f.map(|k| tet[k]))).or_default().push(t);
            }
        }
        for t in 0..finite {
            for f in FACETS {
                let f = f.map(|k| tets[t][k]);
                if owners[&sorted(f)].len() == 1 {
                    tets.push([f[0], f[1], f[2], INFINITE]);
                }
            }
        }
        let mut by_facet: HashMap<[u32; 3], Vec<Facet>> = HashMap::new();
        for (t, tet) in tets.iter().enumerate() {
            for (i, f) in FACETS.into_iter().enumerate() {
                by_facet.entry(sorted(f.map(|k| tet[k]))).or_default().push(Facet::new(t as u32, i));
            }
        }
        let neighbors = (0..tets.len())
            .map(|t| {
                FACETS.map(|f| {
                    let pair = &by_facet[&sorted(f.map(|k| tets[t][k]))];
                    assert_eq!(pair.len(), 2);
                    pair[usize::from(pair[0].tet() == t as u32)]
                })
            })
            .collect();
        let seeds = points.len();
        Made { points, tets, neighbors, finite, seeds }
    }

    /// A grid of n^3 unit cubes, each cut into six tets around its diagonal (1, 1, 1).
    fn grid(n: u32) -> Made {
        let at = |x: u32, y: u32, z: u32| x + (n + 1) * (y + (n + 1) * z);
        let points = (0..(n + 1).pow(3))
            .map(|i| DVec3::new((i % (n + 1)) as f64, (i / (n + 1) % (n + 1)) as f64, (i / (n + 1) / (n + 1)) as f64))
            .collect();
        let mut tets = Vec::new();
        for cube in 0..n.pow(3) {
            let corner = [cube % n, cube / n % n, cube / n / n];
            for [i, j, even] in [[0, 1, 1], [1, 2, 1], [2, 0, 1], [1, 0, 0], [2, 1, 0], [0, 2, 0]] {
                let mut p = corner;
                let mut path = vec![at(p[0], p[1], p[2])];
                for axis in [i, j, 3 - i - j] {
                    p[axis] += 1;
                    path.push(at(p[0], p[1], p[2]));
                }
                let [a, b, c, d] = [path[0], path[1], path[2], path[3]];
                tets.push(if even == 1 { [a, b, c, d] } else { [a, c, b, d] });
            }
        }
        Made::glue(points, tets)
    }

    /// Labels the tets whose centroids satisfy `inside`; vertices of these become the seeds, the others auxiliary.
    fn label(mut self, inside: impl Fn(DVec3) -> bool) -> (Made, Vec<bool>) {
        let labels: Vec<bool> = (0..self.tets.len()).map(|t| t < self.finite && inside(self.centroid(t))).collect();
        let mut used = vec![false; self.points.len()];
        for (tet, _) in self.tets.iter().zip(&labels).filter(|(_, l)| **l) {
            tet.iter().for_each(|&v| used[v as usize] = true);
        }
        let mut order: Vec<usize> = (0..used.len()).collect();
        order.sort_by_key(|&v| !used[v]);
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(i, &v)| rank[v] = i as u32);
        self.points = order.iter().map(|&v| self.points[v]).collect();
        for v in self.tets.iter_mut().flatten().filter(|v| **v != INFINITE) {
            *v = rank[*v as usize];
        }
        self.seeds = used.iter().filter(|u| **u).count();
        (self, labels)
    }

    fn centroid(&self, t: usize) -> DVec3 {
        let [a, b, c, d] = self.tets[t].map(|v| self.points[v as usize]);
        centroid(a, b, c, d)
    }

    fn complex(&self) -> Complex<'_> {
        Complex::new(&self.points, &self.tets, &self.neighbors, self.seeds)
    }

    /// Settles `labels` where `depth` is that of a point.
    fn settle(&self, kinds: &[SeedKind], labels: Vec<bool>, depth: impl Fn(DVec3) -> f64 + Sync) -> (Vec<bool>, u64) {
        let complex = self.complex();
        let of_tet = |t: u32| depth(self.centroid(t as usize));
        let flat = |t: u32| {
            let [a, b, c, d] = complex.corners(t);
            volume6(a, b, c, d) < 1e-9
        };
        let mut repair = Repair::new(&complex, kinds, Judge { depth: &of_tet, flat: &flat, reach: 0.5 }, labels);
        let smallest = |t: u32| {
            let [a, b, c, d] = complex.corners(t);
            tetcvt::geometry::tetrahedron::min_dihedral(a, b, c, d)
        };
        settle(&complex, &mut repair, Shape { thin: &|t| smallest(t) < 5.0, slim: &|t| smallest(t) < 20.0 });
        let total = repair.hard() + repair.soft();
        (repair.into_labels(), total)
    }
}

/// Whether the boundary of the labels is closed and manifold, by counting from scratch.
fn is_manifold(complex: &Complex, labels: &[bool]) -> bool {
    let boundary = Boundary::of(complex, labels);
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    let mut links: HashMap<u32, Vec<(u32, u32)>> = HashMap::new();
    for &[a, b, c] in &boundary.triangles {
        for (x, y, z) in [(a, b, c), (b, c, a), (c, a, b)] {
            *edges.entry((x, y)).or_default() += 1;
            links.entry(x).or_default().push((y, z));
        }
    }
    let closed = edges.iter().all(|(&(x, y), &n)| n == 1 && edges.get(&(y, x)) == Some(&1));
    let disks = links.values().all(|link| {
        let next: HashMap<u32, u32> = link.iter().copied().collect();
        let mut at = link[0].0;
        let mut steps = 0;
        while steps < link.len() && next.contains_key(&at) {
            at = next[&at];
            steps += 1;
            if at == link[0].0 {
                break;
            }
        }
        next.len() == link.len() && steps == link.len()
    });
    closed && disks
}

fn all_used(made: &Made, labels: &[bool]) -> bool {
    let mut used = vec![false; made.points.len()];
    for (tet, _) in made.tets.iter().zip(labels).filter(|(_, l)| **l) {
        tet.iter().for_each(|&v| used[v as usize] = true);
    }
    used[..made.seeds].iter().all(|&u| u)
}

fn cube_of(p: DVec3) -> [i32; 3] {
    p.floor().as_ivec3().to_array()
}

/// Signed distance to the box from `min` to `max`, positive inside.
fn box_depth(p: DVec3, min: DVec3, max: DVec3) -> f64 {
    let q = (min - p).max(p - max);
    -(q.max(DVec3::ZERO).length() + q.max_element().min(0.0))
}

#[test]
fn a_ball_a_ring_and_a_cavity_have_their_topology_and_are_left_alone() {
    type Shape = (&'static str, fn([i32; 3]) -> bool, Vec<i64>, usize);
    let shapes: [Shape; 4] = [
        ("ball", |c| c.iter().all(|&x| (1..4).contains(&x)), vec![2], 1),
        ("ring", |c| c[2] == 2 && c[0].abs_diff(2).max(c[1].abs_diff(2)) == 1, vec![0], 1),
        ("cavity", |c| c.iter().all(|&x| (1..4).contains(&x)) && c != [2; 3], vec![2, 2], 1),
        ("two balls", |c| c[1] == 2 && c[2] == 2 && (c[0] == 1 || c[0] == 3), vec![2, 2], 2),
    ];
    for (name, shape, euler, bodies) in shapes {
        let (made, labels) = Made::grid(5).label(|p| shape(cube_of(p)));
        let complex = made.complex();
        let boundary = Boundary::of(&complex, &labels);
        assert_eq!(boundary.euler, euler, "{name}");
        assert_eq!(regions(&complex, &labels).1, bodies, "{name}");
        assert!(is_manifold(&complex, &labels), "{name}");
        let kinds = vec![SeedKind::Interior; made.seeds];
        let (settled, total) = made.settle(&kinds, labels.clone(), |p| if shape(cube_of(p)) { 0.3 } else { -0.3 });
        assert_eq!(total, 0, "{name}");
        assert_eq!(settled, labels, "{name}");
    }
}

#[test]
fn bodies_that_share_an_edge_or_a_vertex_are_found_and_mended() {
    type Shape = (&'static str, [[i32; 3]; 2], usize);
    let shapes: [Shape; 4] = [
        ("edge", [[1, 1, 1], [2, 2, 1]], 2),
        ("other edge", [[1, 2, 1], [2, 1, 1]], 2),
        ("vertex", [[1, 1, 1], [2, 2, 2]], 1),
        ("other vertex", [[1, 2, 1], [2, 1, 2]], 1),
    ];
    for (name, cubes, wrong) in shapes {
        let (made, labels) = Made::grid(4).label(|p| cubes.contains(&cube_of(p)));
        let complex = made.complex();
        let kinds = vec![SeedKind::Interior; made.seeds];
        let zero = |_: u32| 0.0;
        let never = |_: u32| false;
        let repair = Repair::new(&complex, &kinds, Judge { depth: &zero, flat: &never, reach: 0.5 }, labels.clone());
        assert_eq!(repair.wrong(true).len(), wrong, "{name}");
        assert!(!is_manifold(&complex, &labels), "{name}");
        let (settled, total) = made.settle(&kinds, labels, |_| 0.0);
        assert_eq!(total, 0, "{name}");
        assert!(is_manifold(&complex, &settled), "{name}");
        assert!(all_used(&made, &settled), "{name}");
    }
}

#[test]
fn only_attempts_that_change_the_topology_stay() {
    let in_column = |p: DVec3| cube_of(p)[..2] == [2, 2];
    let (made, filled) = Made::grid(5).label(|p| cube_of(p).iter().all(|x| (1..4).contains(x)));
    let complex = made.complex();
    let holed: Vec<bool> = (0..).zip(&filled).map(|(t, &f)| f && !in_column(made.centroid(t))).collect();
    let kinds = vec![SeedKind::Interior; made.seeds];
    // Geometry would leave the tunnel open.
    let depth = |t: u32| if in_column(made.centroid(t as usize)) { -0.1 } else { 0.4 };
    let never = |_: u32| false;
    let judge = Judge { depth: &depth, flat: &never, reach: 0.5 };
    let mut repair = Repair::new(&complex, &kinds, judge, holed.clone());
    let euler = |labels: &[bool]| Boundary::of(&complex, labels).euler.iter().sum::<i64>();
    repair.descend();
    assert_eq!((repair.hard(), euler(repair.inside()), repair.twice_euler()), (0, 0, 0));

    let column: Vec<u32> = (0..).zip(&filled).zip(&holed).filter(|((_, f), h)| f != h).map(|((t, _), _)| t).collect();
    let above = |t: &u32| made.centroid(*t as usize).z > 3.0;
    let shallow: Vec<u32> = column.iter().copied().filter(above).take(1).collect();
    let before = repair.inside().to_vec();
    assert!(!repair.attempt(&shallow));
    assert_eq!(repair.inside(), before);
    let gap: Vec<u32> = column.into_iter().filter(|&t| !before[t as usize]).collect();
    assert!(repair.attempt(&gap));
    assert_eq!((repair.hard(), euler(repair.inside()), repair.twice_euler()), (0, 2, 4));
}

#[test]
fn geometry_decides_which_way_an_edge_is_mended() {
    // Two cubes that share an edge, between them a wedge that is shallow inside or shallow outside.
    let cubes = [[1, 1, 1], [2, 2, 1]];
    for (between, components) in [(0.1f64, 1), (-0.1, 2)] {
        let (made, labels) = Made::grid(4).label(|p| cubes.contains(&cube_of(p)));
        let kinds = vec![SeedKind::Interior; made.seeds];
        // Where the bodies meet the cubes are shallow too, else no label may go against them.
        let axis = DVec3::new(2.0, 2.0, 0.0);
        let depth = |p: DVec3| {
            if !cubes.contains(&cube_of(p)) {
                between
            } else if (p - axis).truncate().length() < 0.6 {
                between.abs() * 0.5 * between.signum()
            } else {
                0.4
            }
        };
        let (settled, total) = made.settle(&kinds, labels, depth);
        assert_eq!(total, 0);
        assert_eq!(Boundary::of(&made.complex(), &settled).components(), components);
    }
}

#[test]
fn a_sliver_on_the_boundary_is_peeled() {
    // A unit cube of six tets under a flat tet that covers its top the other way round.
    let mut made = Made::grid(1);
    let up = |made: &Made, x: f64, y: f64| made.points.iter().position(|p| *p == DVec3::new(x, y, 1.0)).unwrap();
    let [a, b, c, d] = [up(&made, 0.0, 0.0), up(&made, 1.0, 0.0), up(&made, 1.0, 1.0), up(&made, 0.0, 1.0)];
    made.points[b].z += 1e-3;
    made.points[d].z += 1e-3;
    let mut tets = made.tets[..made.finite].to_vec();
    tets.push([a as u32, b as u32, c as u32, d as u32]);
    let made = Made::glue(made.points, tets);
    let (made, labels) = made.label(|_| true);
    let kinds = vec![SeedKind::Surface; made.seeds];
    let (settled, total) = made.settle(&kinds, labels.clone(), |_| 0.1);
    assert_eq!(total, 0);
    assert!(labels[6] && !settled[6]);
    assert_eq!(settled[..6], labels[..6]);
    assert!(is_manifold(&made.complex(), &settled));
}

#[test]
fn a_cap_over_a_seed_of_the_surface_is_peeled_and_one_over_a_seed_within_is_not() {
    for kind in [SeedKind::Surface, SeedKind::Interior] {
        // A tet with a point just below the middle of its facet z = 0.
        let points = vec![
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(1.0, 0.0, 0.0),
            DVec3::new(0.0, 1.0, 0.0),
            DVec3::new(0.3, 0.3, -1.0),
            DVec3::new(0.3, 0.3, -0.001),
        ];
        let tets = vec![[0, 1, 4, 3], [1, 2, 4, 3], [2, 0, 4, 3], [0, 2, 1, 4]]
            .into_iter()
            .map(|[a, b, c, d]: [u32; 4]| {
                let p = [a, b, c, d].map(|v: u32| points[v as usize]);
                if volume6(p[0], p[1], p[2], p[3]) > 0.0 { [a, b, c, d] } else { [b, a, c, d] }
            })
            .collect();
        let (made, labels) = Made::glue(points, tets).label(|_| true);
        let mut kinds = vec![SeedKind::Surface; 5];
        kinds[4] = kind;
        let (settled, total) = made.settle(&kinds, labels, |_| 0.1);
        assert_eq!(total, 0);
        assert_eq!(settled[3], kind == SeedKind::Interior);
    }
}

#[test]
fn unused_seeds_are_attached() {
    // All 27 vertices of a 2^3 grid are seeds; only one cube is labelled, so that 19 seeds are in no tet.
    let (made, _) = Made::grid(2).label(|_| true);
    let labels: Vec<bool> =
        (0..made.tets.len()).map(|t| t < made.finite && cube_of(made.centroid(t)) == [0; 3]).collect();
    assert!(!all_used(&made, &labels));
    let kinds = vec![SeedKind::Interior; made.seeds];
    let (settled, total) = made.settle(&kinds, labels, |_| 0.1);
    assert_eq!(total, 0);
    assert!(all_used(&made, &settled));
    assert!(is_manifold(&made.complex(), &settled));
    assert_eq!(Boundary::of(&made.complex(), &settled).euler, [2]);
}

proptest! {
    // The same cases each time: about one in some thousands, such as seed 5082551864428970134 with share 0.09771561444115273, keeps a
    // few contradictions, for which a mesh gets more seeds.
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn label_noise_near_the_boundary_is_repaired(seed in any::<u64>(), share in 0.0..0.4f64) {
        let (min, max) = (DVec3::splat(1.0), DVec3::splat(6.0));
        let (made, mut labels) = Made::grid(7).label(|p| box_depth(p, min, max) > 0.0);
        let mut rng = Rng(seed);
        for (t, label) in labels.iter_mut().enumerate().take(made.finite) {
            let usable = made.tets[t].iter().all(|&v| (v as usize) < made.seeds);
            if usable && box_depth(made.centroid(t), min, max).abs() < 1.0 && rng.unit() < share {
                *label ^= true;
            }
        }
        // No help from geometry: all depths are shallow.
        let kinds = vec![SeedKind::Interior; made.seeds];
        let (settled, total) = made.settle(&kinds, labels, |p| 0.01 * box_depth(p, min, max).signum());
        prop_assert_eq!(total, 0);
        prop_assert!(is_manifold(&made.complex(), &settled));
        prop_assert!(all_used(&made, &settled));
        prop_assert_eq!(Boundary::of(&made.complex(), &settled).euler, vec![2]);
    }
}

/// The boxes from `min` to `max`, in one surface; a negative flag turns a box into a cavity.
fn boxes(all: &[([f64; 3], [f64; 3])]) -> Surface {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for &(min, max) in all {
        let base = points.len() as u32;
        for i in 0..8 {
            let pick = |axis: usize| if i >> axis & 1 == 1 { max[axis] } else { min[axis] };
            points.push(DVec3::new(pick(0), pick(1), pick(2)));
        }
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            triangles.push([base + a, base + b, base + c]);
            triangles.push([base + a, base + c, base + d]);
        }
    }
    surface(&points, &triangles)
}

fn surface(points: &[DVec3], triangles: &[[u32; 3]]) -> Surface {
    let source: Vec<u32> = (0..triangles.len() as u32).collect();
    Surface::new(points, triangles, &source, &vec![0; triangles.len()]).unwrap()
}

fn torus() -> Surface {
    let (m, n) = (48, 24);
    let turn = |i: u32, n: u32| std::f64::consts::TAU * i as f64 / n as f64;
    let points: Vec<DVec3> = (0..m * n)
        .map(|i| {
            let (u, v) = (turn(i / n, m), turn(i % n, n));
            DVec3::new((1.0 + 0.4 * v.cos()) * u.cos(), (1.0 + 0.4 * v.cos()) * u.sin(), 0.4 * v.sin())
        })
        .collect();
    let at = |i: u32, j: u32| i % m * n + j % n;
    let triangles: Vec<[u32; 3]> = (0..m * n)
        .flat_map(|i| {
            let (i, j) = (i / n, i % n);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    surface(&points, &triangles)
}

/// First seeds of a surface, auxiliary points around, and their triangulation.
struct Sampled {
    surface: Surface,
    kinds: Vec<SeedKind>,
    spacing: f64,
    delaunay: Delaunay,
}

impl Sampled {
    fn new(surface: Surface, count: usize) -> Sampled {
        let params = Params { target: Target::Count(count), ..Params::default() };
        let features = Features::find(&surface, params.feature_angle);
        let seeds = sample(&surface, &features, &params).unwrap();
        assert_eq!(seeds.positions.len(), count);
        let mut points = seeds.positions;
        for i in 0..200 {
            let z = 1.0 - (i as f64 + 0.5) / 100.0;
            let (sin, cos) = (i as f64 * 2.399963).sin_cos();
            let r = (1.0 - z * z).sqrt();
            points.push(snap(DVec3::new(r * cos, r * sin, z) * 0.5) * 2.2);
        }
        let delaunay = Delaunay::build(&points).unwrap();
        let kinds = seeds.anchors.iter().map(|a| a.kind()).collect();
        Sampled { surface, kinds, spacing: seeds.spacing, delaunay }
    }

    fn sampling(&self) -> Sampling<'_> {
        Sampling::new(&self.delaunay, &self.kinds, &self.surface, self.spacing)
    }

    /// The circumcentres' sides, by the inside test.
    fn clipped(&self) -> ClippedVoronoi {
        let inside = self.delaunay.vertices().iter().map(|tet| {
            let center = || {
                let [a, b, c, d] = tet.map(|v| self.delaunay.points()[v as usize]);
                circumcenter(a, b, c, d)
            };
            tet[3] != INFINITE && Some(center()).is_some_and(|c| c.is_finite() && self.surface.tree().is_inside(c))
        });
        ClippedVoronoi {
            cells: Vec::new(),
            inside: inside.collect(),
            odd: None,
            crossings: Vec::new(),
            adjacency: self.delaunay.adjacency().into(),
        }
    }
}

fn models() -> Vec<(&'static str, Surface)> {
    vec![
        ("cube", boxes(&[([0.0; 3], [1.0; 3])])),
        ("torus", torus()),
        ("cavity", boxes(&[([0.0; 3], [1.0; 3]), ([0.3; 3], [0.7; 3])])),
        ("two bodies", boxes(&[([0.0; 3], [1.0; 3]), ([1.2, 0.0, 0.0], [2.0, 1.0, 1.0])])),
        ("plate", boxes(&[([0.0; 3], [1.0, 1.0, 0.02])])),
    ]
}

/// Labels, mends and takes the mesh out, with every check.
fn whole(name: &str, sampled: &Sampled) -> TetMesh {
    let sampling = sampled.sampling();
    let labels = mend(&sampling, label(&sampling, &sampled.clipped()));
    let fatal: Vec<_> = defects(&sampling, &labels, &[]).into_iter().filter(|d| d.kind.is_fatal()).collect();
    assert!(fatal.is_empty(), "{name}: {fatal:?}");
    let topology = Topology::of(&sampling, &labels, &Boundary::of(&sampling.complex, &labels));
    assert_eq!(topology.mismatch(), 0, "{name}");
    let mesh = mesh(&sampling, &labels, sampled.surface.patch());
    mesh.check().unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(mesh.points.len(), sampled.kinds.len(), "{name}");
    mesh
}

#[test]
fn sampled_models_become_meshes_with_their_topology() {
    for (name, surface) in models() {
        let shells = 0..surface.shell_count() as u32;
        let solids = shells.map(|s| surface.solid_of_shell(s)).max().unwrap() + 1;
        let volume = surface.frame().length_to_model(1.0).powi(3) * surface.volume();
        let triangles = surface.triangles().len() as u32;
        let sampled = Sampled::new(surface, 2000);
        let mesh = whole(name, &sampled);
        assert!((mesh.volume() / volume - 1.0).abs() < 0.03, "{name}: {} of {volume}", mesh.volume());
        let mut regions = mesh.regions.clone();
        regions.sort_unstable();
        regions.dedup();
        assert_eq!(regions, (0..solids).collect::<Vec<u32>>(), "{name}");
        assert!(mesh.boundary.iter().all(|f| f.source_triangle < triangles && f.region_outside == -1));
    }
}

#[test]
fn noise_on_real_labels_is_mended() {
    for (name, surface) in models().into_iter().take(3) {
        let sampled = Sampled::new(surface, 1500);
        let mut clipped = sampled.clipped();
        let sampling = sampled.sampling();
        // Every seventh tet with a vertex on the surface and a circumcentre within a spacing of it.
        let tets: Vec<[u32; 4]> = sampled.delaunay.vertices().to_vec();
        for (t, tet) in tets.iter().enumerate().filter(|(t, _)| t % 7 == 0) {
            let bound = |&v: &u32| sampled.kinds.get(v as usize).is_some_and(|&k| k != SeedKind::Interior);
            if sampling.complex.usable(t as u32)
                && tet.iter().any(bound)
                && sampling.depth(t as u32).abs() < 0.2 * sampled.spacing
            {
                clipped.inside[t] ^= true;
            }
        }
        let noisy = label(&sampling, &clipped);
        assert!(defects(&sampling, &noisy, &[]).iter().any(|d| d.kind.is_fatal()), "{name}");
        let mended = mend(&sampling, noisy);
        mesh(&sampling, &mended, sampled.surface.patch()).check().unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn lost_shells_made_up_handles_and_unused_seeds_are_named() {
    let sampled = Sampled::new(boxes(&[([0.0; 3], [1.0; 3]), ([1.2, 0.0, 0.0], [2.0, 1.0, 1.0])]), 1500);
    let sampling = sampled.sampling();
    let labels = mend(&sampling, label(&sampling, &sampled.clipped()));
    // Without the second body.
    let (region, _) = regions(&sampling.complex, &labels);
    let first: Vec<bool> = region.iter().map(|&r| r == 0).collect();
    let found = defects(&sampling, &first, &[]);
    assert!(found.iter().any(|d| d.kind == DefectKind::UnusedSeed));
    let missing: Vec<_> = found.iter().filter(|d| d.kind == DefectKind::MissingShell).collect();
    assert_eq!(missing.len(), 1);
    let proposed = proposals(&sampling, &[missing[0].clone()]);
    let shell = missing[0].shell.unwrap();
    assert!(proposed.len() >= 4);
    for p in &proposed {
        let Anchor::Surface { triangle } = p.anchor else { panic!("{p:?} is not on the surface") };
        assert_eq!(sampled.surface.shell()[triangle as usize], shell);
        assert!(sampled.surface.tree().closest(p.place).distance2 < 1e-20);
    }

    // A torus with its hole filled: every tet of seeds is inside.
    let sampled = Sampled::new(torus(), 1500);
    let sampling = sampled.sampling();
    let labels: Vec<bool> = (0..sampled.delaunay.vertices().len() as u32).map(|t| sampling.complex.usable(t)).collect();
    let kinds = vec![SeedKind::Interior; sampled.kinds.len()];
    let shallow = |_: u32| 0.0;
    let never = |_: u32| false;
    let judge = Judge { depth: &shallow, flat: &never, reach: 1.0 };
    let mut repair = Repair::new(&sampling.complex, &kinds, judge, labels);
    repair.descend();
    assert_eq!(repair.hard(), 0);
    let found = defects(&sampling, repair.inside(), &[]);
    assert!(found.iter().any(|d| d.kind == DefectKind::WrongGenus && d.shell == Some(0)));
}

#[test]
fn check_names_what_is_wrong_with_a_mesh() {
    let mesh = whole("cube", &Sampled::new(boxes(&[([0.0; 3], [1.0; 3])]), 500));
    type Damage = (&'static str, fn(&mut TetMesh));
    let damages: [Damage; 8] = [
        ("inverted", |m| m.tets[7].swap(0, 1)),
        ("is in no tet", |m| {
            m.points.push(DVec3::ZERO);
            m.kinds.push(SeedKind::Interior);
            m.seeds.push(u32::MAX);
        }),
        ("is no boundary triangle with its region", |m| {
            m.boundary.pop();
        }),
        ("is no boundary triangle with its region", |m| m.boundary[3].vertices.swap(0, 1)),
        ("is no boundary triangle with its region", |m| m.boundary[3].region_outside = 0),
        ("some boundary triangles are there twice", |m| m.boundary.push(m.boundary[0])),
        ("different regions", |m| {
            let inner =
                (0..m.tets.len()).find(|&t| m.tets[t].iter().all(|&v| m.kinds[v as usize] == SeedKind::Interior));
            m.regions[inner.expect("a tet inside")] += 1;
        }),
        ("does not exist", |m| m.tets[0][0] = 1_000_000),
    ];
    for (message, damage) in damages {
        let mut broken = mesh.clone();
        damage(&mut broken);
        let error = broken.check().expect_err(message);
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let sampled = Sampled::new(torus(), 1500);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mesh = pool.install(|| whole("torus", &sampled));
        (mesh.points, mesh.tets, mesh.boundary)
    };
    assert_eq!(run(1), run(3));
}
