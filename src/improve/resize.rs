//! Splits and contracts edges, splits facets.

use glam::DVec3;

use super::change::Change;
use super::complex::{Complex, Facet, Freedom, Vertex};
use super::flips::Ring;
use super::ground::Ground;
use super::measure;
use crate::geometry::frame::snap;
use crate::geometry::tetrahedron::FACETS;
use crate::geometry::triangle;

/// Splits edge (a, b) in the middle, of a crease on its curve; the new vertex, unless a tet would be flat or a facet stray.
pub(super) fn split(complex: &mut Complex, ground: &Ground, edge: [u32; 2], change: &mut Change) -> Option<u32> {
    let [a, b] = edge;
    if !complex.is_crease(a, b) {
        let place = middle(complex, ground, edge, &complex.edge_facets(edge))?;
        return split_at(complex, ground, edge, place, change);
    }
    let (curve, at) = ground.middle_of_crease(complex, edge)?;
    let place = ground.features.curves[curve as usize].point_at(at, ground.surface.points());
    let m = split_at(complex, ground, edge, (snap(place), Freedom::Curve(curve, at)), change)?;
    complex.remove_crease(edge);
    complex.add_crease([a, m]);
    complex.add_crease([m, b]);
    Some(m)
}

/// The same with the new vertex at a place of the caller's, for edges that are no creases.
pub(super) fn split_at(
    complex: &mut Complex,
    ground: &Ground,
    [a, b]: [u32; 2],
    (at, freedom): (DVec3, Freedom),
    change: &mut Change,
) -> Option<u32> {
    if complex.on_seam(a) && complex.on_seam(b) {
        return None;
    }
    let facets = complex.edge_facets([a, b]);
    let mark = complex.mark();
    let m = complex.add_vertex(Vertex { point: at, freedom, region: complex.region[a as usize] });
    change.clear();
    for &t in complex.star(a).iter().filter(|&&t| complex.tets[t as usize].contains(&b)) {
        change.old_tets.push(t);
        for end in [a, b] {
            let tet = complex.tets[t as usize].map(|v| if v == end { m } else { v });
            change.new_tets.push((tet, measure::quality(complex.corners(tet))));
        }
    }
    let mut fits = change.new_tets.iter().all(|t| t.1 > 0.0);
    for &f in &facets {
        let Facet { vertices, face, .. } = complex.facets[f as usize];
        for end in [a, b] {
            match ground.facet(complex, vertices.map(|v| if v == end { m } else { v }), face, &[f]) {
                Some(facet) => change.new_facets.push(facet),
                None => fits = false,
            }
        }
    }
    change.old_facets = facets;
    if !fits {
        complex.rollback(mark);
        return None;
    }
    change.apply(complex);
    Some(m)
}

/// Splits a facet of tet `t` at its centroid, unless it is of the boundary or a tet would be flat; whether that went. Where all edges
/// of a tet are on the boundary, this is the way to a vertex inside.
pub(super) fn split_facet(complex: &mut Complex, (t, facet): (u32, [u32; 3]), change: &mut Change) -> bool {
    let Some(u) = complex.across(t, facet) else { return false };
    let [a, b, c] = complex.corners(facet);
    let (point, region) = (snap(triangle::centroid(a, b, c)), complex.region[facet[0] as usize]);
    let mark = complex.mark();
    let m = complex.add_vertex(Vertex { point, freedom: Freedom::Inside, region });
    change.clear();
    change.old_tets.extend([t, u]);
    for tet in [t, u].map(|t| complex.tets[t as usize]) {
        for corner in facet {
            let tet = tet.map(|v| if v == corner { m } else { v });
            change.new_tets.push((tet, measure::quality(complex.corners(tet))));
        }
    }
    if change.new_tets.iter().any(|t| t.1 <= 0.0) {
        complex.rollback(mark);
        return false;
    }
    change.apply(complex);
    true
}

/// Where the vertex in the middle of an edge goes, and how it may move from there.
fn middle(complex: &Complex, ground: &Ground, [a, b]: [u32; 2], facets: &[u32]) -> Option<(DVec3, Freedom)> {
    let half = (complex.points[a as usize] + complex.points[b as usize]) * 0.5;
    let &[f, g] = facets else { return Some((snap(half), Freedom::Inside)) };
    if complex.facets[f as usize].face != complex.facets[g as usize].face {
        return None;
    }
    let closest = ground.surface.tree().closest(half);
    let same = ground.face[closest.triangle as usize] == complex.facets[f as usize].face;
    same.then_some((snap(closest.point), Freedom::Surface(closest.triangle)))
}

/// Contracts edge (a, b) to `b`, if every tet that changes is better than `least`.
///
/// The tets around `a` then are those between `b` and the facets that `a` saw. If all are positive they fill the same
/// space; for a vertex of the boundary the link condition makes sure of that (H. Edelsbrunner, *Geometry and Topology for
/// Mesh Generation*, 2001, section 4.2).
pub(super) fn contract(
    complex: &mut Complex,
    ground: &Ground,
    [a, b]: [u32; 2],
    least: f64,
    change: &mut Change,
) -> bool {
    // The link of a vertex of the seam is not known.
    if complex.on_seam(a) || complex.on_seam(b) && complex.on_boundary(a) {
        return false;
    }
    change.clear();
    for &t in complex.star(a) {
        let tet = complex.tets[t as usize];
        change.old_tets.push(t);
        if !tet.contains(&b) {
            let at = tet.iter().position(|&v| v == a).expect("a star's tets have its vertex: this is a bug in tetcvt");
            let [x, y, z] = FACETS[at].map(|k| tet[k]);
            let tet = [b, x, y, z];
            let quality = measure::quality(complex.corners(tet));
            if quality <= least.max(0.0) {
                return false;
            }
            change.new_tets.push((tet, quality));
        }
    }
    let mut creases = None;
    if complex.on_boundary(a) {
        if complex.freedom[a as usize].is_bound() {
            let Some(next) = crease_follows(complex, ground, [a, b]) else { return false };
            creases = Some(next);
        }
        if !boundary_follows(complex, ground, [a, b], change) {
            return false;
        }
    }
    if let Some(next) = creases {
        complex.remove_crease([a, b]);
        complex.remove_crease([a, next]);
        complex.add_crease([b, next]);
    }
    change.apply(complex);
    complex.free_vertex(a);
    true
}

/// The vertex next to `a` on its crease, on the side away from `b`, if the crease can do without `a`.
fn crease_follows(complex: &Complex, ground: &Ground, [a, b]: [u32; 2]) -> Option<u32> {
    let (Freedom::Curve(number, _) | Freedom::Knot(number, _)) = complex.freedom[a as usize] else { return None };
    let mut beside = complex.along_creases(a);
    let [Some(x), Some(y), None] = [beside.next(), beside.next(), beside.next()] else { return None };
    let next = if x == b { y } else { x };
    if x != b && y != b {
        return None;
    }
    (!complex.has_edge(b, next) && ground.may_skip(complex, number, a, [b, next])).then_some(next)
}

/// The facets of a contraction of a vertex of the surface; whether there is nothing against them.
fn boundary_follows(complex: &Complex, ground: &Ground, [a, b]: [u32; 2], change: &mut Change) -> bool {
    let Some(ring) = Ring::around(complex, a, b) else { return false };
    if !ring.is_open() {
        return false;
    }
    // The link condition: the vertices next to both ends are those of the ring, on the boundary too.
    let common = |of_a: Vec<u32>, of_b: Vec<u32>| of_a.iter().filter(|v| of_b.binary_search(v).is_ok()).count();
    let near = |v: u32| sorted(complex.star(v).iter().flat_map(|&t| complex.tets[t as usize]), [a, b]);
    let beside =
        |v: u32| sorted(complex.facets_of(v).iter().flat_map(|&f| complex.facets[f as usize].vertices), [a, b]);
    if common(near(a), near(b)) != ring.length || common(beside(a), beside(b)) != 2 {
        return false;
    }
    let spare = |v: u32| complex.facets_of(v).len() > 3;
    if !spare(ring.vertices[0]) || !spare(ring.vertices[ring.length - 1]) {
        return false;
    }
    change.old_facets.extend(complex.facets_of(a));
    // Those that vanish come last: of two vertices that all but coincide they face any way.
    let vanishes = |f: u32| complex.facets[f as usize].vertices.contains(&b);
    change.old_facets.sort_by_key(|&f| vanishes(f));
    let left = change.old_facets.partition_point(|&f| !vanishes(f));
    let on_crease = complex.freedom[a as usize].is_bound();
    let face = complex.facets[change.old_facets[0] as usize].face;
    if !on_crease && change.old_facets.iter().any(|&f| complex.facets[f as usize].face != face) {
        return false;
    }
    for k in 0..left {
        let Facet { vertices, face, .. } = complex.facets[change.old_facets[k] as usize];
        let moved = vertices.map(|v| if v == a { b } else { v });
        // Facets on both sides of a crease face different ways.
        let before = if on_crease { &change.old_facets[k..=k] } else { &change.old_facets[..left] };
        match ground.facet(complex, moved, face, before) {
            Some(facet) => change.new_facets.push(facet),
            None => return false,
        }
    }
    true
}

fn sorted(vertices: impl Iterator<Item = u32>, but: [u32; 2]) -> Vec<u32> {
    let mut all: Vec<u32> = vertices.filter(|v| !but.contains(v)).collect();
    all.sort_unstable();
    all.dedup();
    all
}
