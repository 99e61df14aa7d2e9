//! How triangles fit together: which share an edge, and what keeps them from being a closed manifold.

use super::defects::{Defect, Flaw, Marks};
use super::soup::Soup;
use crate::disjoint_sets::DisjointSets;
use crate::geometry::predicates::{Sign, normal_signs, orient3d};

/// Edge `i` of triangle `t` runs from its corner `i` to corner `i + 1`; its number is `3 t + i`.
pub type EdgeId = u32;

/// The triangle of an edge.
pub fn triangle_of(edge: EdgeId) -> u32 {
    edge / 3
}

/// The ends of an edge, in its triangle's direction.
pub fn ends(triangles: &[[u32; 3]], edge: EdgeId) -> [u32; 2] {
    let triangle = triangles[edge as usize / 3];
    let i = edge as usize % 3;
    [triangle[i], triangle[(i + 1) % 3]]
}

/// All edges of the triangles, sorted so that those over the same two vertices are neighbours.
pub fn sorted(triangles: &[[u32; 3]]) -> Vec<([u32; 2], EdgeId)> {
    let mut edges: Vec<([u32; 2], EdgeId)> = (0..3 * triangles.len() as u32)
        .map(|e| {
            let [a, b] = ends(triangles, e);
            ([a.min(b), a.max(b)], e)
        })
        .collect();
    edges.sort_unstable();
    edges
}

/// For each edge, the other one over the same two vertices; `triangles` are edge-manifold and closed.
pub fn twins(triangles: &[[u32; 3]]) -> Vec<EdgeId> {
    // By their lesser vertex, counted, and then each vertex's by the other.
    let count = triangles.as_flattened().iter().max().map_or(0, |&v| v as usize + 1);
    let mut end = vec![0; count + 1];
    let edges = || {
        (0..3 * triangles.len() as u32).map(|e| {
            let [a, b] = ends(triangles, e);
            (a.min(b), a.max(b), e)
        })
    };
    edges().for_each(|(least, ..)| end[least as usize + 1] += 1);
    for v in 0..count {
        end[v + 1] += end[v];
    }
    let mut listed = vec![(0, 0, 0); 3 * triangles.len()];
    for edge in edges() {
        let place = &mut end[edge.0 as usize];
        listed[*place] = edge;
        *place += 1;
    }
    listed.chunk_by_mut(|x, y| x.0 == y.0).for_each(<[(u32, u32, EdgeId)]>::sort_unstable);
    let mut twin = vec![0; 3 * triangles.len()];
    for pair in listed.chunks_exact(2) {
        let [(a, b, e), (c, d, f)] = [pair[0], pair[1]];
        assert_eq!([a, b], [c, d], "the surface is closed and manifold: this is a bug in tetcvt");
        twin[e as usize] = f;
        twin[f as usize] = e;
    }
    twin
}

/// Refuses a soup that is not a closed manifold, in the order open, duplicate faces, coinciding faces, non-manifold
/// edges, non-manifold vertices; else returns the twin of each edge. All of them go to `marks`.
pub(super) fn check(soup: &Soup, marks: &mut Marks) -> Result<Vec<EdgeId>, Defect> {
    let edges = sorted(&soup.triangles);
    let mut open = (0, EdgeId::MAX);
    let mut crowded = vec![];
    for group in edges.chunk_by(|a, b| a.0 == b.0) {
        match group.len() {
            1 => {
                open = (open.0 + 1, open.1.min(group[0].1));
                soup.mark_edge(marks, Flaw::Open, group[0].1 / 3, group[0].1 as usize % 3);
            }
            2 => {}
            _ => {
                crowded.push(group);
                soup.mark_edge(marks, Flaw::NonManifoldEdge, group[0].1 / 3, group[0].1 as usize % 3);
            }
        }
    }
    let duplicates = duplicates(soup, marks);
    if open.0 > 0 {
        return Err(Defect::Open { count: open.0, place: soup.edge_place(open.1 / 3, open.1 as usize % 3) });
    }
    // Duplicates come first: they make edges non-manifold, and are the better name for it.
    duplicates?;
    // The first by its face in the input, not by the vertices' numbers.
    crowded.sort_unstable_by_key(|group| group[0].1);
    if let Some(first) = crowded.first() {
        let place = |group: &[([u32; 2], EdgeId)]| soup.edge_place(group[0].1 / 3, group[0].1 as usize % 3);
        let covered: Vec<_> = crowded.iter().filter(|group| faces_overlap(soup, group)).collect();
        return Err(match covered.first() {
            Some(group) => Defect::CoincidingFaces { count: covered.len(), place: place(group) },
            None => Defect::NonManifoldEdges { count: crowded.len(), place: place(first) },
        });
    }
    let twin = twins(&soup.triangles);
    vertices(soup, &twin, marks)?;
    Ok(twin)
}

/// Refuses triangles over the same three vertices.
fn duplicates(soup: &Soup, marks: &mut Marks) -> Result<(), Defect> {
    let mut keys: Vec<([u32; 3], u32)> = (0..soup.triangles.len() as u32)
        .map(|t| {
            let mut key = soup.triangles[t as usize];
            key.sort_unstable();
            (key, t)
        })
        .collect();
    keys.sort_unstable();
    let copies = || keys.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| w[1].1);
    copies().for_each(|t| soup.mark_triangle(marks, Flaw::DuplicateFace, t));
    match copies().min() {
        None => Ok(()),
        Some(t) => Err(Defect::DuplicateFaces { count: copies().count(), place: soup.corner_place(t, 0) }),
    }
}

/// Whether two of the triangles around an edge lie in one half-plane beside it.
fn faces_overlap(soup: &Soup, group: &[([u32; 2], EdgeId)]) -> bool {
    let [a, b] = group[0].0.map(|v| soup.points[v as usize]);
    // The corner that is not on the edge.
    let apex = |e: EdgeId| soup.points[soup.triangles[e as usize / 3][(e as usize % 3 + 2) % 3] as usize];
    group.iter().enumerate().any(|(k, &(_, e))| {
        group[..k].iter().any(|&(_, f)| {
            let (c, d) = (apex(e), apex(f));
            // Parallel normals agree in the sign of every component that is not zero.
            orient3d(a, b, c, d) == Sign::Zero && normal_signs(a, b, c) == normal_signs(a, b, d)
        })
    })
}

/// Refuses vertices whose triangles are not one fan.
fn vertices(soup: &Soup, twin: &[EdgeId], marks: &mut Marks) -> Result<(), Defect> {
    // Corners that follow each other around a vertex are joined across their common edge, whatever the orientations.
    let mut fans = DisjointSets::new(twin.len());
    for e in 0..twin.len() as u32 {
        let f = twin[e as usize];
        for v in ends(&soup.triangles, e) {
            fans.join(corner_at(&soup.triangles, e / 3, v), corner_at(&soup.triangles, f / 3, v));
        }
    }
    let mut fan = vec![u32::MAX; soup.points.len()];
    let mut bad = vec![];
    for corner in 0..twin.len() as u32 {
        let v = soup.triangles[corner as usize / 3][corner as usize % 3];
        let root = fans.find(corner);
        let known = &mut fan[v as usize];
        if *known == u32::MAX {
            *known = root;
        } else if *known != root {
            bad.push((v, corner));
        }
    }
    let Some(&(_, first)) = bad.first() else { return Ok(()) };
    bad.sort_unstable();
    bad.dedup_by_key(|b| b.0);
    for &(_, corner) in &bad {
        soup.mark_corner(marks, Flaw::NonManifoldVertex, corner / 3, corner as usize % 3);
    }
    Err(Defect::NonManifoldVertices { count: bad.len(), place: soup.corner_place(first / 3, first as usize % 3) })
}

/// The number `3 t + i` of the corner of `t` that is vertex `v`.
pub fn corner_at(triangles: &[[u32; 3]], t: u32, v: u32) -> u32 {
    let i = triangles[t as usize].iter().position(|&w| w == v);
    3 * t + i.expect("twins share their ends: this is a bug in tetcvt") as u32
}
