//! Fills small holes that are nearly flat.
//!
//! Of all triangulations of a loop of open edges, the one whose sharpest fold is the least sharp, those to the faces beside
//! the hole included, and of such the one of least area (P. Liepa, "Filling holes in meshes", Eurographics
//! Symposium on Geometry Processing, 2003, pp. 200-206), by dynamic programming in cubic time. Departures: no edge of it may be
//! one of the surface already, and the vertices of the loop are the only ones.

use glam::DVec3;

use super::super::edges::{self, EdgeId};
use super::super::soup::{Soup, note_count};
use crate::disjoint_sets::DisjointSets;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::triangle;

/// A hole is small where what closes it has at most this share of the area of the part that it is in.
const SMALL: f64 = 0.1;

/// A loop of more edges would take long, and is none that a scanner or a lost face leaves.
const MOST_EDGES: usize = 400;

/// A hole is nearly flat when no vertex of it is farther from its plane than this share of its own diagonal.
const FLAT: f64 = 0.2;

/// Fills the holes of `soup`.
pub(super) fn fill(soup: &mut Soup, notes: &mut Vec<String>) {
    let sorted = edges::sorted(&soup.triangles);
    let taken: Vec<[u32; 2]> = sorted.iter().map(|e| e.0).collect();
    let part_area = areas_of_parts(soup, &sorted);
    let (mut filled, mut added) = (0, 0);
    for hole in loops(soup, &sorted) {
        let corners: Vec<DVec3> = hole.vertices.iter().map(|&v| soup.points[v as usize]).collect();
        if corners.len() > MOST_EDGES || !is_nearly_flat(&corners) {
            continue;
        }
        let is_taken = |i: usize, j: usize| {
            let (a, b) = (hole.vertices[i], hole.vertices[j]);
            taken.binary_search(&[a.min(b), a.max(b)]).is_ok()
        };
        let beside: Vec<DVec3> = hole.apexes.iter().map(|&v| soup.points[v as usize]).collect();
        let Some((triangles, area)) = flattest(&corners, &beside, is_taken) else { continue };
        if area > SMALL * part_area[hole.beside as usize] {
            continue;
        }
        // New faces count as part of the one beside them.
        let (source, patch) = (soup.source[hole.beside as usize], soup.patch[hole.beside as usize]);
        added += triangles.len();
        filled += 1;
        triangles.iter().for_each(|t| soup.push(t.map(|i| hole.vertices[i]), source, patch));
    }
    note_count(
        notes,
        filled,
        &format!("hole was filled, with {added} triangles (--repair)"),
        &format!("holes were filled, with {added} triangles (--repair)"),
    );
}

/// A loop of open edges.
struct Hole {
    /// Against the direction of the triangles beside it, where these agree.
    vertices: Vec<u32>,
    /// The third corner of the triangle at the edge from each vertex to the next.
    apexes: Vec<u32>,
    /// A triangle beside it.
    beside: u32,
}

/// Loops of open edges in which every vertex has just two of them.
fn loops(soup: &Soup, sorted: &[([u32; 2], EdgeId)]) -> Vec<Hole> {
    let mut links: Vec<(u32, u32, u32)> = vec![];
    for group in sorted.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() == 1) {
        let e = group[0].1;
        let [a, b] = edges::ends(&soup.triangles, e);
        links.extend([(b, a, e), (a, b, e)]);
    }
    links.sort_unstable();
    let around = |v: u32| {
        let begin = links.partition_point(|l| l.0 < v);
        &links[begin..begin + links[begin..].partition_point(|l| l.0 == v)]
    };
    let mut done = vec![false; soup.points.len()];
    let mut holes = vec![];
    for &(start, ..) in &links {
        if done[start as usize] || around(start).len() != 2 {
            continue;
        }
        // The first step goes against the triangle, if one of the two does.
        let against = |l: &&(u32, u32, u32)| edges::ends(&soup.triangles, l.2) == [l.1, l.0];
        let Some(first) = around(start).iter().find(against).or(around(start).first()) else { continue };
        let apex = |e: EdgeId| soup.triangles[e as usize / 3][(e as usize % 3 + 2) % 3];
        let (mut vertices, mut apexes, mut at, mut edge) = (vec![start], vec![apex(first.2)], first.1, first.2);
        while at != start && around(at).len() == 2 && !done[at as usize] {
            vertices.push(at);
            done[at as usize] = true;
            let Some(next) = around(at).iter().find(|l| l.2 != edge) else { break };
            (at, edge) = (next.1, next.2);
            apexes.push(apex(edge));
        }
        done[start as usize] = true;
        if at == start && vertices.len() > 2 {
            holes.push(Hole { vertices, apexes, beside: first.2 / 3 });
        }
    }
    holes
}

fn is_nearly_flat(corners: &[DVec3]) -> bool {
    let size = BoundingBox::of(corners).diagonal();
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let mut normal = DVec3::ZERO;
    for (i, &p) in corners.iter().enumerate() {
        normal += (p - middle).cross(corners[(i + 1) % corners.len()] - middle);
    }
    // A crack has no normal, and nothing to be flat about.
    let normal = normal.normalize_or_zero();
    corners.iter().all(|&p| (p - middle).dot(normal).abs() <= FLAT * size)
}

/// For each triangle the area of what hangs together with it along edges of two faces.
fn areas_of_parts(soup: &Soup, sorted: &[([u32; 2], EdgeId)]) -> Vec<f64> {
    let mut parts = DisjointSets::new(soup.triangles.len());
    for group in sorted.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() == 2) {
        parts.join(group[0].1 / 3, group[1].1 / 3);
    }
    let (part, count) = parts.number();
    let mut area = vec![0.0; count];
    for (t, &p) in part.iter().enumerate() {
        let [a, b, c] = soup.corners(t);
        area[p as usize] += triangle::area(a, b, c);
    }
    part.iter().map(|&p| area[p as usize]).collect()
}

/// How a part of a polygon is best cut.
#[derive(Clone, Copy)]
struct Best {
    /// Sharpest fold, as 1 - the cosine of the angle between normals.
    fold: f64,
    area: f64,
    /// The corner that makes a triangle with the ends of the part, and that triangle's unit normal.
    apex: usize,
    normal: DVec3,
}

/// The triangulation of a closed polygon whose sharpest fold is least, and its area; `beside[i]` is the third corner of the
/// face beyond the edge from corner i to the next. None where every one needs an edge that is taken.
fn flattest(
    corners: &[DVec3],
    beside: &[DVec3],
    is_taken: impl Fn(usize, usize) -> bool,
) -> Option<(Vec<[usize; 3]>, f64)> {
    let n = corners.len();
    let normal = |a: DVec3, b: DVec3, c: DVec3| triangle::normal2(a, b, c).normalize_or_zero();
    // A side of the polygon has the face beyond it in the place of a triangle.
    let side = |i: usize| {
        let j = (i + 1) % n;
        Best { fold: 0.0, area: 0.0, apex: usize::MAX, normal: normal(corners[j], corners[i], beside[i]) }
    };
    let none = Best { fold: f64::INFINITY, area: f64::INFINITY, apex: usize::MAX, normal: DVec3::ZERO };
    let mut best = vec![none; n * n];
    (0..n - 1).for_each(|i| best[i * n + i + 1] = side(i));
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            let is_last = span == n - 1;
            if !is_last && is_taken(i, j) {
                continue;
            }
            let mut least = none;
            for k in i + 1..j {
                let parts = [best[i * n + k], best[k * n + j]];
                let mut fold = parts[0].fold.max(parts[1].fold);
                if fold > least.fold || !fold.is_finite() {
                    continue;
                }
                let own = normal(corners[i], corners[k], corners[j]);
                let last = is_last.then(|| side(j));
                for neighbor in parts.iter().chain(&last) {
                    fold = fold.max(1.0 - own.dot(neighbor.normal));
                }
                let area = parts[0].area + parts[1].area + triangle::area(corners[i], corners[k], corners[j]);
                if fold < least.fold || (fold == least.fold && area < least.area) {
                    least = Best { fold, area, apex: k, normal: own };
                }
            }
            best[i * n + j] = least;
        }
    }
    let whole = best[n - 1];
    if !whole.fold.is_finite() {
        return None;
    }
    let mut triangles = vec![];
    let mut parts = vec![(0, n - 1)];
    while let Some((i, j)) = parts.pop() {
        if j - i > 1 {
            let k = best[i * n + j].apex;
            triangles.push([i, k, j]);
            parts.extend([(i, k), (k, j)]);
        }
    }
    Some((triangles, whole.area))
}
