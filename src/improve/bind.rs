//! From a mesh to one that can be changed: how each of its vertices may move, which edges are creases, and what may be let off.

use glam::DVec3;
use rayon::prelude::*;

use super::complex::{Complex, Facet, Freedom, NONE, Vertex};
use super::ground::Ground;
use crate::geometry::frame::snap;
use crate::geometry::triangle;
use crate::seeds::{Anchor, SeedKind, Seeds};
use crate::surface::features::{Curve, Features};
use crate::tet_mesh::TetMesh;

/// The quality that tets may fall to where a vertex is brought onto the surface (radians).
const LEAST_SETTLED: f64 = 0.02;

/// The mesh in the frame, ready to be changed.
pub(super) fn load(mesh: &TetMesh, seeds: &Seeds, ground: &Ground) -> Complex {
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
                (Anchor::Knot { curve, at }, true) => Freedom::Knot(curve, at),
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
            let stray = ground.stray(corners);
            let facing = ground.facing(corners, stray.triangle);
            Facet { vertices: f.vertices, face: ground.face[facing as usize], stray }
        })
        .collect();
    let mut complex = Complex::new(vertices, mesh.tets.clone(), facets);
    complex.has_interfaces = ground.surface.has_interfaces();
    complex
}

/// Brings vertices that the boundary has without their being bound to the surface onto it, where their tets stay positive.
pub(super) fn settle(complex: &mut Complex, ground: &Ground, kinds: &[SeedKind]) {
    let loose: Vec<u32> = (0..complex.points.len() as u32)
        .filter(|&v| complex.freedom[v as usize] == Freedom::Fixed && kinds[v as usize] == SeedKind::Interior)
        .collect();
    for v in loose {
        let closest = ground.surface.tree().closest(complex.points[v as usize]);
        let face = ground.face[closest.triangle as usize];
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
/// parts two patches there, and the knots of those that do along them: what is finer than the spacing, as the noise of scans is, the
/// mesh cannot follow anyway.
pub(super) fn release(complex: &mut Complex, ground: &Ground) {
    for v in 0..complex.points.len() as u32 {
        let bound = complex.freedom[v as usize].is_bound();
        let low = |&t: &u32| complex.quality[t as usize] < complex.floor();
        if !bound || !complex.on_boundary(v) || !complex.star(v).iter().any(low) {
            continue;
        }
        let facets = complex.facets_of(v);
        let face = complex.facets[facets[0] as usize].face;
        if stays(complex, ground, v) {
            continue;
        }
        if facets.iter().any(|&f| complex.facets[f as usize].face != face) {
            if let Freedom::Knot(curve, at) = complex.freedom[v as usize] {
                complex.freedom[v as usize] = Freedom::Curve(curve, at);
                complex.touch(v);
            }
            continue;
        }
        let triangle = ground.triangle_at(complex.points[v as usize], face);
        let triangle = triangle.unwrap_or_else(|| ground.surface.tree().closest(complex.points[v as usize]).triangle);
        complex.freedom[v as usize] = Freedom::Surface(triangle);
        complex.touch(v);
    }
    complex.retain_creases();
}

/// Whether a vertex is on a crease that is to stay whole, or is the tip of a cone, where no crease ends.
fn stays(complex: &Complex, ground: &Ground, v: u32) -> bool {
    let is_whole = |curve: usize| ground.whole.get(curve) == Some(&true);
    match complex.freedom[v as usize] {
        Freedom::Curve(curve, _) | Freedom::Knot(curve, _) => is_whole(curve as usize),
        Freedom::Fixed => {
            let here = complex.points[v as usize];
            let at = |&u: &u32| ground.surface.points()[u as usize] == here;
            let ends = |c: &Curve| at(&c.vertices[0]) || at(&c.vertices[c.vertices.len() - 1]);
            let mut ending = (0..).zip(&ground.features.curves).filter(|(_, c)| ends(c)).map(|(i, _)| i).peekable();
            ending.peek().is_none() || ending.any(is_whole)
        }
        _ => false,
    }
}

/// Pairs of vertices next to each other on a crease.
pub(super) fn crease_edges(complex: &Complex, ground: &Ground) -> Vec<[u32; 2]> {
    let Features { corners, curves, .. } = ground.features;
    let mut chains: Vec<Vec<(f64, u32)>> = vec![Vec::new(); curves.len()];
    let mut at_corner = vec![NONE; corners.len()];
    let mut position: Vec<(DVec3, usize)> =
        corners.iter().enumerate().map(|(i, &c)| (ground.surface.points()[c as usize], i)).collect();
    let order = |p: DVec3, q: DVec3| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z));
    position.sort_by(|a, b| order(a.0, b.0));
    for (v, freedom) in (0..).zip(&complex.freedom) {
        match *freedom {
            Freedom::Curve(curve, at) | Freedom::Knot(curve, at) => chains[curve as usize].push((at, v)),
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
