//! From the improved mesh back to model units, and what there is to say of it.

use rayon::prelude::*;

use super::complex::{Complex, Facet, Freedom, NONE};
use super::ground::Ground;
use super::{endgame, measure, regions, volume};
use crate::geometry::tetrahedron::{self, EDGES};
use crate::seeds::SeedKind;
use crate::tet_mesh::{BoundaryTriangle, TetMesh};

/// The improved mesh in model units; `patch` has the patch of each of the surface's triangles.
pub(super) fn store(before: &TetMesh, complex: &Complex, ground: &Ground, patch: &[u32]) -> TetMesh {
    let mut mesh = before.clone();
    let surface = ground.surface;
    // Vertices beyond the count, made by splits, take the places of those contracted.
    let count = mesh.points.len() as u32;
    let mut place: Vec<u32> = (0..complex.points.len() as u32).collect();
    let mut vacant: Vec<u32> = complex.free_vertices.iter().copied().filter(|&v| v < count).collect();
    vacant.sort_unstable_by(|a, b| b.cmp(a));
    let in_use = |&v: &u32| !complex.star(v).is_empty();
    for v in (count..complex.points.len() as u32).filter(in_use) {
        place[v as usize] = vacant.pop().expect("the count is restored: this is a bug in tetcvt");
    }
    for v in (0..complex.points.len() as u32).filter(in_use) {
        let v = v as usize;
        let to = place[v] as usize;
        mesh.points[to] = surface.frame().to_model(complex.points[v]);
        match complex.freedom[v] {
            Freedom::Inside => mesh.kinds[to] = SeedKind::Interior,
            Freedom::Surface(_) | Freedom::Held(_) => mesh.kinds[to] = SeedKind::Surface,
            Freedom::Curve(..) | Freedom::Knot(..) => mesh.kinds[to] = SeedKind::Curve,
            Freedom::Fixed => {}
        }
    }
    // Of vertices on an interface no region could be said.
    let regions = complex.has_interfaces.then(|| regions::find(complex, ground));
    let of_tet = |t: usize| match &regions {
        Some(regions) => regions.of_tets[t],
        None => complex.region[complex.tets[t][0] as usize],
    };
    let of_facet = |f: usize| match &regions {
        Some(regions) => regions.of_facets[f],
        None => [complex.region[complex.facets[f].vertices[0] as usize] as i32, -1],
    };
    let tets: Vec<([u32; 4], u32)> = (0..complex.tets.len())
        .filter(|&t| complex.is_alive(t as u32))
        .map(|t| (complex.tets[t].map(|v| place[v as usize]), of_tet(t)))
        .collect();
    let mut order: Vec<(u32, u32)> = (0..).zip(&tets).map(|(t, (tet, _))| (least(*tet), t)).collect();
    order.sort_unstable();
    mesh.tets = order.iter().map(|&(_, t)| tets[t as usize].0).collect();
    mesh.regions = order.iter().map(|&(_, t)| tets[t as usize].1).collect();
    let facets: Vec<usize> = (0..complex.facets.len()).filter(|&f| complex.facets[f].vertices[0] != NONE).collect();
    mesh.boundary = facets
        .par_iter()
        .map(|&f| {
            let Facet { vertices, stray, .. } = complex.facets[f];
            let [inside, outside] = of_facet(f);
            let closest = ground.facing(complex.corners(vertices), stray.triangle) as usize;
            BoundaryTriangle {
                vertices: vertices.map(|v| place[v as usize]),
                region_inside: inside as u32,
                region_outside: outside,
                patch: patch[closest],
                source_triangle: surface.source()[closest],
            }
        })
        .collect();
    mesh
}

fn least([a, b, c, d]: [u32; 4]) -> u32 {
    a.min(b).min(c).min(d)
}

/// What is shown of an angle, in degrees.
const SHOWN: f64 = 0.005;

/// What became of the floor, for a human: reached, or how many tets are below it, where the worst is and why.
pub(super) fn describe(complex: &Complex, ground: &Ground, floor: f64) -> String {
    let below = |&t: &u32| {
        let extremes = measure::extremes(complex.corners(complex.tets[t as usize]));
        extremes.is_none_or(|e| e[0].to_degrees() < floor - SHOWN)
    };
    let left: Vec<u32> = endgame::left(complex).into_iter().filter(below).collect();
    let angle = |t: u32| {
        let [a, b, c, d] = complex.corners(complex.tets[t as usize]);
        tetrahedron::min_dihedral(a, b, c, d)
    };
    let Some(worst) = left.iter().copied().min_by(|&t, &u| angle(t).total_cmp(&angle(u))) else {
        return format!("every dihedral angle is at least {floor} degrees");
    };
    let [a, b, c, d] = complex.corners(complex.tets[worst as usize]);
    let place = ground.surface.frame().to_model(tetrahedron::centroid(a, b, c, d));
    format!(
        "{} of {} tets below {floor} degrees; the worst, with {:.2}, at ({:.6}, {:.6}, {:.6}): {}",
        left.len(),
        complex.tets.iter().filter(|t| t[0] != NONE).count(),
        angle(worst),
        place.x,
        place.y,
        place.z,
        reason(complex, worst)
    )
}

/// What became of the volume, for a human.
pub(super) fn describe_volume(outcome: &volume::Outcome, ground: &Ground) -> String {
    format!(
        "vertices of the boundary left the surface by up to {:.3} % of the diagonal, for a volume within {:.0e}",
        100.0 * outcome.farthest / ground.surface.diagonal(),
        outcome.error.abs().max(1e-6)
    )
}

/// What stands in the way of a tet.
fn reason(complex: &Complex, t: u32) -> &'static str {
    let tet = complex.tets[t as usize];
    let [a, b, c, d] = complex.corners(tet);
    let angles = tetrahedron::dihedral_angles(a, b, c, d);
    let sharpest = (0..6).min_by(|&e, &f| angles[e].total_cmp(&angles[f])).unwrap_or(0);
    let [i, j] = EDGES[sharpest];
    let facets = complex.facets_of(tet[i]).iter().filter(|&&f| {
        let vertices = &complex.facets[f as usize].vertices;
        vertices.contains(&tet[j]) && vertices.iter().all(|v| tet.contains(v))
    });
    if facets.count() == 2 {
        "the surface itself is as sharp there"
    } else if tet.iter().all(|&v| complex.freedom[v as usize].is_bound()) {
        "its vertices are bound to corners and creases closer than the spacing"
    } else if tet.iter().all(|&v| complex.on_boundary(v)) {
        "its corners are all on the surface, where a wall or a tip is thinner than the spacing"
    } else {
        "no local change raises it"
    }
}
