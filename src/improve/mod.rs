//! Takes the slivers out of a mesh.
//!
//! A centroidal Voronoi tessellation has near-regular tets and a few percent of slivers. Local operations that each raise the
//! worst of the tets they touch bring every dihedral angle over a floor, as in B. M. Klingner, J. R. Shewchuk, *Aggressive
//! tetrahedral mesh improvement*, Proceedings of the 16th International Meshing Roundtable, 2008,
//! doi 10.1007/978-3-540-75103-8_1:
//!
//! 1. Worst first ([`floor`]): the best edge removal ([`flips`]) or multi-face removal ([`faces`]) around the tet, or else
//!    a move of its corners ([`smooth`]).
//! 2. Polish: vertices move to where the sum of their tets' smallest angles is larger, the floor being a hard bound.
//! 3. Steps 1 and 2 again: the better average leaves fewer tets stuck.
//! 4. For the few that are ([`endgame`]): splits and contractions of edges, each with its surroundings improved anew, kept if the
//!    sum of cubed deficits falls; then the count of vertices is made right elsewhere.
//!
//! Departures: boundary edges are flipped and boundary vertices moved too, within a tight bound on the distance to the
//! surface ([`ground`]); creases stay, and which part of the surface a facet stands for. No operation of theirs that changes the
//! count is used before step 4.
//!
//! Cost: that of the slivers, plus a constant number of passes over all vertices.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::frame::snap;
use crate::geometry::triangle;
use crate::params::{Boundary, Params};
use crate::progress::{Flow, Observer};
use crate::seeds::{Anchor, SeedKind, Seeds};
use crate::surface::Surface;
use crate::surface::features::{Curve, Features};
use crate::tet_mesh::{BoundaryTriangle, TetMesh};

mod change;

mod complex;

mod endgame;

mod faces;

mod flips;

mod floor;

mod ground;

mod measure;

mod resize;

mod smooth;

mod stars;

use complex::{Complex, Facet, Freedom, NONE, Vertex};
use floor::Worklist;
use ground::Ground;

/// The quality that tets may fall to where a vertex is brought onto the surface (radians).
const LEAST_SETTLED: f64 = 0.02;

/// Rounds of the polish between attempts at the floor.
const POLISH_ROUNDS: usize = 2;

/// Raises the dihedral angles of `mesh`, made from `seeds`, to the floor of the parameters where that is possible.
///
/// The number of vertices stays, the boundary's topology, creases, and every invariant of the mesh.
pub fn improve(
    mesh: &mut TetMesh,
    seeds: &Seeds,
    (surface, features): (&Surface, &Features),
    params: &Params,
    observer: &mut dyn Observer,
) {
    let mut ground = Ground::new(surface, features);
    let mut complex = load(mesh, seeds, &ground);
    ground.measure(&complex.facets);
    let creases = crease_edges(&complex, &ground);
    complex.set_creases(creases.into_iter());
    if params.boundary == Boundary::Conform {
        settle(&mut complex, &ground, &mesh.kinds);
    }
    complex.set_floor(params.min_dihedral.to_radians() + 1e-5);
    let mut work = Worklist::default();
    let trace = std::env::var("TETCVT_TRACE").is_ok();
    let started = std::time::Instant::now();
    let say = |what: &str, complex: &Complex| {
        if trace {
            let left = endgame::left(complex);
            let alive: Vec<f64> = (0..complex.tets.len()).filter(|&t| complex.is_alive(t as u32)).map(|t| complex.quality[t]).collect();
            eprintln!("{:.3} {what}: {} left, worst {:.3}, mean {:.3}, vertices {}", started.elapsed().as_secs_f64(), left.len(),
                left.first().map_or(99.0, |&t| complex.quality[t as usize].to_degrees()),
                alive.iter().sum::<f64>().to_degrees() / alive.len() as f64, complex.vertex_count());
        }
    };
    say("start", &complex);
    work.fill(&complex);
    work.work(&mut complex, &ground);
    say("floor", &complex);
    for _ in 0..POLISH_ROUNDS {
        work.polish(&mut complex, &ground);
        say("polish", &complex);
    }
    release(&mut complex, &ground);
    work.fill(&complex);
    work.work(&mut complex, &ground);
    say("floor", &complex);
    endgame::run(&mut complex, &ground, &mut work, 2000);
    say("endgame", &complex);
    if trace && std::env::var("DIAG").is_ok() {
        for &t in endgame::left(&complex).iter().take(40) {
            let tet = complex.tets[t as usize];
            let nf = (0..4).filter(|&i| complex.facet(complex.facet_of(t, i)).is_some()).count();
            let faces: Vec<Vec<u32>> = tet.iter().map(|&v| { let mut f: Vec<u32> = complex.facets_of(v).iter().map(|&f| complex.facets[f as usize].face).collect(); f.sort(); f.dedup(); f }).collect();
            let fr: Vec<String> = tet.iter().map(|&v| match complex.freedom[v as usize] { Freedom::Inside => "I".into(), Freedom::Surface(t) => format!("S{}", ground.features.face[t as usize]), Freedom::Curve(c,_) => format!("C{c}"), Freedom::Fixed => "F".into() }).collect();
            let ext = measure::extremes(complex.corners(tet)).unwrap_or([0.0, 9.0]).map(f64::to_degrees);
            eprintln!("  {:.2} [{:.1} {:.1}] facets {nf} {fr:?} faces {faces:?}", complex.quality[t as usize].to_degrees(), ext[0], ext[1]);
        }
    }
    endgame::restore_count(&mut complex, &ground, &mut work, mesh.points.len());
    say("count", &complex);
    work.polish(&mut complex, &ground);
    say("polish", &complex);
    let _ = (Flow::Stop, observer);
    store(mesh, &complex, &ground);
}

/// The mesh in the frame, ready to be changed.
fn load(mesh: &TetMesh, seeds: &Seeds, ground: &Ground) -> Complex {
    let mut on_boundary = vec![false; mesh.points.len()];
    mesh.boundary.iter().flat_map(|f| f.vertices).for_each(|v| on_boundary[v as usize] = true);
    let mut region = vec![0; mesh.points.len()];
    for (tet, &r) in mesh.tets.iter().zip(&mesh.regions) {
        tet.iter().for_each(|&v| region[v as usize] = r);
    }
    let vertices: Vec<Vertex> = mesh
        .seeds
        .iter()
        .enumerate()
        .map(|(v, &seed)| {
            let freedom = match (seeds.anchors[seed as usize], on_boundary[v]) {
                (Anchor::Corner { .. }, _) | (Anchor::Interior, true) => Freedom::Fixed,
                (Anchor::Surface { triangle }, true) => Freedom::Surface(triangle),
                (Anchor::Curve { curve, at }, true) => Freedom::Curve(curve, at),
                (_, false) => Freedom::Inside,
            };
            Vertex { point: seeds.positions[seed as usize], freedom, region: region[v] }
        })
        .collect();
    let facets = mesh
        .boundary
        .par_iter()
        .map(|f| {
            let corners: [DVec3; 3] = f.vertices.map(|v| vertices[v as usize].point);
            let face = ground.features.face[ground.surface.facing(corners) as usize];
            Facet { vertices: f.vertices, face, stray: ground.stray(corners) }
        })
        .collect();
    Complex::new(vertices, mesh.tets.clone(), facets)
}

/// Brings vertices that the boundary has without their being bound to the surface onto it, where their tets stay positive.
fn settle(complex: &mut Complex, ground: &Ground, kinds: &[SeedKind]) {
    let loose: Vec<u32> = (0..complex.points.len() as u32)
        .filter(|&v| complex.freedom[v as usize] == Freedom::Fixed && kinds[v as usize] == SeedKind::Interior)
        .collect();
    for v in loose {
        let closest = ground.surface.tree().closest(complex.points[v as usize]);
        let face = ground.features.face[closest.triangle as usize];
        let facets: Vec<u32> = complex.facets_of(v).to_vec();
        let normal = ground.surface.normal2(closest.triangle);
        let fits = |&f: &u32| {
            let [a, b, c] = complex.corners(complex.facets[f as usize].vertices);
            complex.facets[f as usize].face == face && triangle::normal2(a, b, c).dot(normal) > 0.0
        };
        if !facets.iter().all(fits) {
            continue;
        }
        let mark = complex.mark();
        let worst = |complex: &Complex| {
            complex.star(v).iter().map(|&t| complex.quality[t as usize]).fold(f64::INFINITY, f64::min)
        };
        complex.move_vertex(v, snap(closest.point), Freedom::Surface(closest.triangle));
        if worst(complex) < LEAST_SETTLED {
            complex.rollback(mark);
            continue;
        }
        for f in facets {
            let stray = ground.stray(complex.corners(complex.facets[f as usize].vertices));
            complex.set_stray(f, stray);
        }
        complex.commit();
    }
}

/// Lets vertices of corners and creases slide on the surface where they keep a tet below the floor and no crease of the mesh
/// parts two patches there: what is finer than the spacing, as the noise of scans is, the mesh cannot follow anyway.
fn release(complex: &mut Complex, ground: &Ground) {
    for v in 0..complex.points.len() as u32 {
        let bound = matches!(complex.freedom[v as usize], Freedom::Fixed | Freedom::Curve(..));
        let low = |&t: &u32| complex.quality[t as usize] < complex.floor();
        if !bound || !complex.on_boundary(v) || !complex.star(v).iter().any(low) {
            continue;
        }
        let facets = complex.facets_of(v);
        let face = complex.facets[facets[0] as usize].face;
        if facets.iter().any(|&f| complex.facets[f as usize].face != face) || is_tip(complex, ground, v) {
            continue;
        }
        if let Some(triangle) = ground.triangle_at(complex.points[v as usize], face) {
            complex.freedom[v as usize] = Freedom::Surface(triangle);
        }
    }
    complex.retain_creases();
}

/// Whether a corner is the tip of a cone, where no crease ends.
fn is_tip(complex: &Complex, ground: &Ground, v: u32) -> bool {
    let here = complex.points[v as usize];
    let at = |&u: &u32| ground.surface.points()[u as usize] == here;
    let ends = |c: &Curve| at(&c.vertices[0]) || at(&c.vertices[c.vertices.len() - 1]);
    complex.freedom[v as usize] == Freedom::Fixed && !ground.features.curves.iter().any(ends)
}

/// Pairs of vertices next to each other on a crease.
fn crease_edges(complex: &Complex, ground: &Ground) -> Vec<[u32; 2]> {
    let Features { corners, curves, .. } = ground.features;
    let mut chains: Vec<Vec<(f64, u32)>> = vec![Vec::new(); curves.len()];
    let mut at_corner = vec![NONE; corners.len()];
    let mut position: Vec<(DVec3, usize)> =
        corners.iter().enumerate().map(|(i, &c)| (ground.surface.points()[c as usize], i)).collect();
    let order = |p: DVec3, q: DVec3| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z));
    position.sort_by(|a, b| order(a.0, b.0));
    for (v, freedom) in (0..).zip(&complex.freedom) {
        match *freedom {
            Freedom::Curve(curve, at) => chains[curve as usize].push((at, v)),
            Freedom::Fixed => {
                if let Ok(i) = position.binary_search_by(|c| order(c.0, complex.points[v as usize])) {
                    at_corner[position[i].1] = v;
                }
            }
            _ => {}
        }
    }
    let corner = |v: u32| corners.binary_search(&v).ok().map(|i| at_corner[i]).filter(|&v| v != NONE);
    let mut edges = Vec::new();
    for (curve, mut chain) in curves.iter().zip(chains) {
        let last = curve.vertices[curve.vertices.len() - 1];
        chain.extend(corner(curve.vertices[0]).map(|v| (0.0, v)));
        chain.extend(corner(last).map(|v| (curve.length(), v)));
        chain.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        edges.extend(chain.windows(2).map(|w| [w[0].1, w[1].1]));
        if let (true, [first, .., last]) = (curve.is_closed(), &chain[..]) {
            edges.push([first.1, last.1]);
        }
    }
    edges.retain(|[a, b]| a != b);
    edges
}

/// Brings the improved mesh back into model units; what has not changed stays as it was, to the last bit.
fn store(mesh: &mut TetMesh, complex: &Complex, ground: &Ground) {
    let surface = ground.surface;
    // Vertices beyond the count, made by splits, take the places of those contracted.
    let count = mesh.points.len() as u32;
    let mut place: Vec<u32> = (0..complex.points.len() as u32).collect();
    let mut vacant: Vec<u32> = complex.free_vertices.iter().copied().filter(|&v| v < count).collect();
    vacant.sort_unstable_by(|a, b| b.cmp(a));
    for v in count..complex.points.len() as u32 {
        if !complex.free_vertices.contains(&v) {
            place[v as usize] = vacant.pop().expect("the count is restored: this is a bug in tetcvt");
        }
    }
    for v in (0..complex.points.len()).filter(|&v| !complex.free_vertices.contains(&(v as u32))) {
        let to = place[v] as usize;
        mesh.points[to] = surface.frame().to_model(complex.points[v]);
        match complex.freedom[v] {
            Freedom::Inside => mesh.kinds[to] = SeedKind::Interior,
            Freedom::Surface(_) => mesh.kinds[to] = SeedKind::Surface,
            Freedom::Curve(..) => mesh.kinds[to] = SeedKind::Curve,
            Freedom::Fixed => {}
        }
    }
    let mut tets: Vec<([u32; 4], u32)> = complex
        .tets
        .iter()
        .filter(|t| t[0] != NONE)
        .map(|t| (t.map(|v| place[v as usize]), complex.region[t[0] as usize]))
        .collect();
    tets.sort_by_key(|(t, _)| t.iter().copied().min());
    mesh.tets = tets.iter().map(|t| t.0).collect();
    mesh.regions = tets.iter().map(|t| t.1).collect();
    let facets: Vec<[u32; 3]> = complex.facets.iter().map(|f| f.vertices).filter(|f| f[0] != NONE).collect();
    mesh.boundary = facets
        .par_iter()
        .map(|&vertices| {
            let closest = surface.facing(complex.corners(vertices)) as usize;
            BoundaryTriangle {
                vertices: vertices.map(|v| place[v as usize]),
                region_inside: complex.region[vertices[0] as usize],
                region_outside: -1,
                patch: surface.patch()[closest],
                source_triangle: surface.source()[closest],
            }
        })
        .collect();
}
