//! The surface cut up by the cells, with names for all corners: faces, and the segments that end them.

use glam::DVec3;
use rayon::prelude::*;

use super::{Face, Key, SURFACE, Segment};
use crate::clipped_voronoi::bisector::View;
use crate::clipped_voronoi::owners::Owners;
use crate::clipped_voronoi::polygon::{Line, Polygon};
use crate::delaunay::Adjacency;
use crate::surface::Surface;

/// Triangles in a block of the work.
const BLOCK: usize = 1024;

/// What a block of triangles needs and finds.
struct Block<'a> {
    points: &'a [DVec3],
    surface: &'a Surface,
    adjacency: &'a Adjacency,
    polygon: Polygon,
    faces: Vec<Face<Key>>,
    segments: Vec<Segment<Key>>,
}

/// The pieces of all triangles, by triangle, and the segments where two cells meet on them.
pub(super) fn collect(
    points: &[DVec3],
    surface: &Surface,
    adjacency: &Adjacency,
) -> (Vec<Face<Key>>, Vec<Segment<Key>>) {
    let mut owners = Owners::default();
    owners.update(surface.points(), points, adjacency, pulp::Arch::new());
    let owners = owners.of();
    let count = surface.triangles().len() as u32;
    let starts: Vec<u32> = (0..count).step_by(BLOCK).collect();
    let found: Vec<_> = starts
        .par_iter()
        .map(|&start| {
            let (polygon, faces, segments) = (Polygon::default(), Vec::new(), Vec::new());
            let mut block = Block { points, surface, adjacency, polygon, faces, segments };
            let ends = (start..(start + BLOCK as u32).min(count)).filter(|&t| !surface.is_interface(t));
            ends.for_each(|t| block.add_triangle(t, owners));
            (block.faces, block.segments)
        })
        .collect();
    let (mut faces, mut segments) = (Vec::new(), Vec::new());
    for (more_faces, more_segments) in found {
        faces.extend(more_faces);
        segments.extend(more_segments);
    }
    (faces, segments)
}

impl Block<'_> {
    /// Cuts up one triangle, from the owner of a corner on across the bisectors that cut it.
    fn add_triangle(&mut self, t: u32, owners: &[u32]) {
        let ids = self.surface.triangles()[t as usize];
        let [a, b, c] = ids.map(|v| owners[v as usize]);
        if a == b && b == c {
            self.faces.push(Face { seed: a, beyond: SURFACE, corners: ids.map(Key::Vertex).to_vec() });
            return;
        }
        let mut found = vec![a];
        let mut next = 0;
        while let Some(&i) = found.get(next) {
            next += 1;
            let view = View { corners: self.surface.corners(t), seed: self.points[i as usize] };
            let bisectors = self.adjacency.of(i as usize).iter().map(|&j| view.bisector(j, self.points[j as usize]));
            self.polygon.bisectors.clear();
            self.polygon.bisectors.extend(bisectors);
            self.polygon.clip(&view);
            self.add_piece(t, i);
            for line in &self.polygon.lines {
                if let Line::Bisector(b) = *line {
                    let j = self.polygon.bisectors[b as usize].seed;
                    if !found.contains(&j) {
                        found.push(j);
                    }
                }
            }
        }
    }

    /// Adds the clipped polygon of triangle `t` in the cell of seed `i`.
    fn add_piece(&mut self, t: u32, i: u32) {
        let ids = self.surface.triangles()[t as usize];
        let (lines, n) = (&self.polygon.lines, self.polygon.lines.len());
        if n == 0 {
            return;
        }
        let across = |line: Line| match line {
            Line::Bisector(b) => Some(self.polygon.bisectors[b as usize].seed),
            Line::Edge(_) => None,
        };
        let corner = |m: usize| match (lines[(m + n - 1) % n], lines[m]) {
            (Line::Edge(_), Line::Edge(c)) => Key::Vertex(ids[c as usize]),
            (Line::Edge(e), b @ Line::Bisector(_)) | (b @ Line::Bisector(_), Line::Edge(e)) => {
                let j = across(b).unwrap_or(i);
                let ends = [ids[e as usize], ids[(e as usize + 1) % 3]];
                Key::OnEdge([ends[0].min(ends[1]), ends[0].max(ends[1])], [i.min(j), i.max(j)])
            }
            (a, b) => {
                let mut seeds = [i, across(a).unwrap_or(i), across(b).unwrap_or(i)];
                seeds.sort_unstable();
                Key::Within(t, seeds)
            }
        };
        let corners: Vec<Key> = (0..n).map(corner).collect();
        for m in 0..n {
            // The cell on the other side has the same segment.
            if let Some(j) = across(lines[m]).filter(|&j| i < j) {
                self.segments.push(Segment { facet: [i, j], from: corners[(m + 1) % n], to: corners[m] });
            }
        }
        self.faces.push(Face { seed: i, beyond: SURFACE, corners });
    }
}
