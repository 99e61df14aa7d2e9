//! Where the boundary and the surface are far apart: the middles of the boundary's edges and facets far from the surface, and the
//! surface's vertices far from the boundary.
//!
//! Nearly all are close, and seen to be so from a triangle or facet known to be near; only the others are measured by a search.

use glam::DVec3;
use rayon::prelude::*;

use super::complex::{Complex, Facet, NONE};
use super::ground::Ground;
use crate::geometry::triangle;
use crate::surface::box_tree::BoxTree;

/// A place where boundary and surface are apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub distance: f64,
    /// An edge of the boundary there.
    pub edge: [u32; 2],
    /// The point of the surface there that is far from the boundary, with its triangle.
    pub tip: Option<(DVec3, u32)>,
}

/// The places where the distance is more than `close`, the farthest first; only those beside which something changed after
/// commit `since`, if that is not 0.
pub(super) fn find(complex: &Complex, ground: &Ground, (close, since): (f64, u32)) -> Vec<Place> {
    let mut places = on_boundary(complex, ground, (close, since));
    places.extend(on_surface(complex, ground, (close, since)));
    places.sort_by(|x, y| y.distance.total_cmp(&x.distance).then(x.edge.cmp(&y.edge)));
    places
}

/// The edges of the boundary that stray, or whose facets do.
fn on_boundary(complex: &Complex, ground: &Ground, (close, since): (f64, u32)) -> Vec<Place> {
    complex
        .facets
        .par_iter()
        .filter(|f| f.vertices[0] != NONE && (since == 0 || f.vertices.iter().any(|&v| complex.changed_at(v, since))))
        .flat_map_iter(|f| {
            let inner = (f.stray.distance > close).then(|| (f.stray.distance, longest_edge(complex, f)));
            let edges = edges_of(f.vertices).into_iter().filter(|e| e[0] < e[1]);
            let along =
                edges.filter_map(|e| Some((edge_stray_over(complex, ground, (e, f.stray.triangle), close)?, e)));
            inner.into_iter().chain(along)
        })
        .map(|(distance, [a, b])| Place { distance, edge: [a.min(b), a.max(b)], tip: None })
        .collect()
}

/// The vertices of the surface far from the boundary.
fn on_surface(complex: &Complex, ground: &Ground, (close, since): (f64, u32)) -> Vec<Place> {
    let near = facets_near(complex, ground);
    let is_far = |v: usize| {
        let Some(facet) = complex.facets.get(near[v] as usize) else { return true };
        let p = ground.surface.points()[v];
        triangle::closest_point(complex.corners(facet.vertices), p).distance_squared(p) > close * close
    };
    let far: Vec<usize> = (0..near.len()).into_par_iter().filter(|&v| is_far(v)).collect();
    if far.is_empty() {
        return Vec::new();
    }
    let facets: Vec<&Facet> = complex.facets.iter().filter(|f| f.vertices[0] != NONE).collect();
    let triangles: Vec<[u32; 3]> = facets.iter().map(|f| f.vertices).collect();
    let tree = BoxTree::build(&complex.points, &triangles);
    let measure = |v: usize| {
        let p = ground.surface.points()[v];
        let is_close = |f: u32| {
            triangle::closest_point(complex.corners(triangles[f as usize]), p).distance_squared(p) <= close * close
        };
        if tree.any_near_box(p - close, p + close, is_close) {
            return None;
        }
        let closest = tree.closest(p);
        let facet = facets[closest.triangle as usize];
        if since > 0 && !facet.vertices.iter().any(|&v| complex.changed_beside(v, since)) {
            return None;
        }
        let [a, b] = nearest_edge(complex, facet, closest.point);
        let tip = ground.triangle_at(p, facet.face).map(|t| (p, t));
        Some(Place { distance: closest.distance2.sqrt(), edge: [a.min(b), a.max(b)], tip })
    };
    far.into_par_iter().filter_map(measure).collect()
}

/// For each vertex of the surface a facet of the boundary near it; [`NONE`] where none is known.
fn facets_near(complex: &Complex, ground: &Ground) -> Vec<u32> {
    let triangles = ground.surface.triangles();
    let mut near = vec![NONE; ground.surface.points().len()];
    for (f, facet) in (0..).zip(&complex.facets).filter(|(_, f)| f.vertices[0] != NONE) {
        triangles[facet.stray.triangle as usize].iter().for_each(|&v| near[v as usize] = f);
    }
    // What a vertex knows its neighbours learn: forth and back through the list nearly all do.
    let mut learn = |triangle: &[u32; 3]| {
        let known = triangle.iter().map(|&v| near[v as usize]).find(|&f| f != NONE);
        if let Some(f) = known {
            for &v in triangle {
                near[v as usize] = if near[v as usize] == NONE { f } else { near[v as usize] };
            }
        }
    };
    triangles.iter().for_each(&mut learn);
    triangles.iter().rev().for_each(&mut learn);
    near
}

/// The edges of a facet.
pub(super) fn edges_of([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn longest_edge(complex: &Complex, facet: &Facet) -> [u32; 2] {
    let length2 = |e: [u32; 2]| complex.points[e[0] as usize].distance_squared(complex.points[e[1] as usize]);
    let longest = |d: [u32; 2], e: [u32; 2]| if length2(e) > length2(d) { e } else { d };
    let [d, e, f] = edges_of(facet.vertices);
    longest(longest(d, e), f)
}

/// The edge of a facet next to a point of it.
fn nearest_edge(complex: &Complex, facet: &Facet, p: DVec3) -> [u32; 2] {
    let away = |e: [u32; 2]| {
        let [a, b] = complex.corners(e);
        triangle::closest_on_segment(a, b, p).distance_squared(p)
    };
    let nearest = |d: [u32; 2], e: [u32; 2]| if away(e) < away(d) { e } else { d };
    let [d, e, f] = edges_of(facet.vertices);
    nearest(nearest(d, e), f)
}

/// How far the middle of an edge is from the surface.
pub(super) fn edge_stray(complex: &Complex, ground: &Ground, [a, b]: [u32; 2]) -> f64 {
    let middle = (complex.points[a as usize] + complex.points[b as usize]) * 0.5;
    ground.surface.tree().closest(middle).distance2.sqrt()
}

/// The same if that is more than `close`; a triangle of the surface nearby is known.
fn edge_stray_over(complex: &Complex, ground: &Ground, (edge, near): ([u32; 2], u32), close: f64) -> Option<f64> {
    let [a, b] = complex.corners(edge);
    if ground.walk.closest_from(near, (a + b) * 0.5).distance2 <= close * close {
        return None;
    }
    Some(edge_stray(complex, ground, edge)).filter(|&away| away > close)
}
