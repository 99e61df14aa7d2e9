//! Where the boundary may run through a wall, or across a gap, that the surface does not, or fall apart.
//!
//! A tunnel through a wall is lined with triangles that stand across the surface, and so is a bridge between two sheets
//! seen from within. No seed is in between, or it would be in no tet, or misplaced: what fills the tunnel, or makes up the
//! bridge, are tets of one label between the vertices of that lining.

use glam::DVec3;
use rayon::prelude::*;

use super::Sampling;
use super::boundary::Boundary;
use super::complex::Complex;
use crate::disjoint_sets::DisjointSets;
use crate::geometry::triangle::{centroid, normal2};
use crate::seeds::SeedKind;

/// Cosines of the angle to the surface beyond which triangles count as standing across it: 75, 60 and 45 degrees. The steepest
/// come first, but a short or slanting tunnel has hardly any.
const ACROSS: [f64; 3] = [0.26, 0.5, 0.71];

/// Tets that a search for the way to another region may visit.
const SEARCH: usize = 256;

/// Sets of tets of equal label, each between the vertices of triangles that stand across the surface and share vertices.
pub(super) fn fillings(sampling: &Sampling, inside: &[bool]) -> Vec<Vec<u32>> {
    let boundary = Boundary::of(&sampling.complex, inside);
    let cosines = cosines(sampling, &boundary);
    let mut all = Vec::new();
    for across in ACROSS {
        let lining: Vec<[u32; 3]> =
            boundary.triangles.iter().zip(&cosines).filter(|(_, c)| **c < across).map(|(t, _)| *t).collect();
        for vertices in clusters(&lining) {
            all.extend(between(&sampling.complex, inside, &vertices));
        }
    }
    all
}

/// For each triangle of the boundary the cosine of its angle to the surface: at its seeds, or else where it is closest to its
/// middle.
fn cosines(sampling: &Sampling, boundary: &Boundary) -> Vec<f64> {
    let normal_at = |p: DVec3| {
        let triangle = sampling.surface.tree().closest(p).triangle;
        sampling.surface.normal2(triangle).normalize_or_zero()
    };
    let is_smooth = |v: &u32| sampling.kinds[*v as usize] == SeedKind::Surface;
    let points = sampling.complex.points;
    (boundary.triangles.par_iter())
        .map(|triangle| {
            let [a, b, c] = triangle.map(|v| points[v as usize]);
            let normal = normal2(a, b, c).normalize_or_zero();
            let at_seeds = triangle.iter().filter(|v| is_smooth(v)).map(|&v| normal.dot(normal_at(points[v as usize])));
            at_seeds.reduce(f64::min).unwrap_or_else(|| normal.dot(normal_at(centroid(a, b, c))))
        })
        .collect()
}

/// The vertices of triangles that share vertices, cluster by cluster, each ascending.
fn clusters(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let number = |v: u32| vertices.binary_search(&v).expect("a vertex of these: this is a bug in tetcvt") as u32;
    let mut sets = DisjointSets::new(vertices.len());
    for &[a, b, c] in triangles {
        sets.join(number(a), number(b));
        sets.join(number(a), number(c));
    }
    sets.group(&vertices)
}

/// The tets outside, and those inside, with all their corners among `vertices`; where they fall apart into pieces that share no
/// facet, each of these too.
fn between(complex: &Complex, inside: &[bool], vertices: &[u32]) -> Vec<Vec<u32>> {
    let is_between =
        |t: &u32| complex.usable(*t) && complex.tets[*t as usize].iter().all(|v| vertices.binary_search(v).is_ok());
    let mut tets: Vec<u32> = vertices.iter().flat_map(|&v| complex.star(v)).copied().filter(is_between).collect();
    tets.sort_unstable();
    tets.dedup();
    let (within, beyond): (Vec<u32>, Vec<u32>) = tets.into_iter().partition(|&t| inside[t as usize]);
    let mut all = Vec::new();
    for of_label in [beyond, within] {
        let pieces = pieces(complex, &of_label);
        if pieces.len() > 1 {
            all.push(of_label);
        }
        all.extend(pieces);
    }
    all
}

/// The pieces of `tets`, ascending, that hang together through facets.
fn pieces(complex: &Complex, tets: &[u32]) -> Vec<Vec<u32>> {
    let mut sets = DisjointSets::new(tets.len());
    for (i, &t) in (0..).zip(tets) {
        for n in complex.around(t) {
            if let Ok(j) = tets.binary_search(&n) {
                sets.join(i, j as u32);
            }
        }
    }
    sets.group(tets)
}

/// The shortest way from a region of tets of equal label, ascending, through usable tets to another region of that label.
pub(super) fn link(complex: &Complex, inside: &[bool], region: &[u32]) -> Option<Vec<u32>> {
    let label = inside[*region.first()? as usize];
    // Tets reached, each with the position of the one it was reached from.
    let mut reached: Vec<(u32, Option<usize>)> = Vec::new();
    let reach = |reached: &mut Vec<(u32, Option<usize>)>, t: u32, from: Option<usize>| {
        let is_new = inside[t as usize] != label && complex.usable(t) && !reached.iter().any(|r| r.0 == t);
        if is_new && reached.len() < SEARCH {
            reached.push((t, from));
        }
    };
    region.iter().flat_map(|&t| complex.around(t)).for_each(|n| reach(&mut reached, n, None));
    let is_other = |n: &u32| inside[*n as usize] == label && region.binary_search(n).is_err();
    let mut next = 0;
    while next < reached.len() {
        let around = complex.around(reached[next].0);
        if around.iter().any(is_other) {
            let way = std::iter::successors(Some(next), |&at| reached[at].1);
            return Some(way.map(|at| reached[at].0).collect());
        }
        around.into_iter().for_each(|n| reach(&mut reached, n, Some(next)));
        next += 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delaunay::{Delaunay, INFINITE};
    use crate::surface::Surface;

    /// A plate of three by three cells, with a seed at each of their corners.
    fn plate() -> (Surface, Delaunay, Vec<SeedKind>) {
        let size = DVec3::new(3.0, 3.0, 0.5);
        let corner = |i: u32| size * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let each: Vec<u32> = (0..12).collect();
        let points: Vec<DVec3> = (0..8).map(corner).collect();
        let surface = Surface::new(&points, &triangles, &each, &each).expect("a closed surface");
        let nodes: Vec<[u32; 3]> = (0..32).map(|i| [i % 4, i / 4 % 4, i / 16]).collect();
        let place =
            |[x, y, z]: [u32; 3]| surface.frame().to_frame(DVec3::new(f64::from(x), f64::from(y), 0.5 * f64::from(z)));
        let seeds: Vec<DVec3> = nodes.iter().map(|&n| place(n)).collect();
        let is_inner = |x: u32| x == 1 || x == 2;
        let kind = |[x, y, _]: [u32; 3]| if is_inner(x) && is_inner(y) { SeedKind::Surface } else { SeedKind::Curve };
        let kinds = nodes.into_iter().map(kind).collect();
        (surface, Delaunay::build(&seeds).expect("seeds have tets"), kinds)
    }

    #[test]
    fn what_a_wall_lacks_is_found_between_the_sides_of_the_tunnel() {
        let (surface, delaunay, kinds) = plate();
        let sampling = Sampling::new(&delaunay, &kinds, &surface, 0.3);
        let is_finite = |t: &[u32; 4]| t[3] != INFINITE;
        let whole: Vec<bool> = delaunay.vertices().iter().map(is_finite).collect();
        assert!(fillings(&sampling, &whole).is_empty());

        let is_middle = |t: &[u32; 4]| t.iter().all(|&v| v != INFINITE && kinds[v as usize] == SeedKind::Surface);
        let middle: Vec<u32> = (0..).zip(delaunay.vertices()).filter(|(_, t)| is_middle(t)).map(|(i, _)| i).collect();
        let holed: Vec<bool> = (0..).zip(&whole).map(|(t, &w)| w && !middle.contains(&t)).collect();
        assert!(middle.len() >= 5);
        assert!(fillings(&sampling, &holed).contains(&middle));
    }

    #[test]
    fn a_region_is_linked_by_the_tets_between_it_and_the_next() {
        let (surface, delaunay, kinds) = plate();
        let sampling = Sampling::new(&delaunay, &kinds, &surface, 0.3);
        let middle_of = |t: &[u32; 4]| t.iter().map(|&v| delaunay.points()[v as usize].x).sum::<f64>();
        let third = delaunay.points()[3].x / 3.0;
        let is_finite = |t: &[u32; 4]| t[3] != INFINITE;
        let labels: Vec<bool> =
            delaunay.vertices().iter().map(|t| is_finite(t) && middle_of(t).abs() > 4.0 * third).collect();
        let left: Vec<u32> = (0..)
            .zip(delaunay.vertices())
            .filter(|(i, t)| labels[*i as usize] && middle_of(t) < 0.0)
            .map(|e| e.0)
            .collect();
        let way = link(&sampling.complex, &labels, &left).expect("a way through the middle");
        let touches = |t: u32, left: bool| {
            let is_there =
                |n: &u32| labels[*n as usize] && (middle_of(&delaunay.vertices()[*n as usize]) < 0.0) == left;
            sampling.complex.around(t).iter().any(is_there)
        };
        assert!(way.iter().all(|&t| !labels[t as usize]));
        assert!(touches(way[0], false) && touches(way[way.len() - 1], true));
    }

    #[test]
    fn triangles_cluster_where_they_share_a_vertex() {
        let found = clusters(&[[1, 5, 9], [2, 3, 4], [9, 7, 8]]);
        assert_eq!(found, [vec![1, 5, 7, 8, 9], vec![2, 3, 4]]);
    }
}
