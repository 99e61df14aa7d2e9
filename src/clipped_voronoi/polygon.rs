//! One triangle of the surface clipped by one Voronoi cell.

use glam::DVec3;

use super::bisector::{Bisector, View, closer};
use crate::delaunay::Adjacency;
use crate::geometry::predicates::Sign;

/// The line that an edge of a clipped polygon lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// Edge of the triangle from corner c to corner c + 1.
    Edge(u8),
    /// A bisector, by its place in [`Polygon::bisectors`].
    Bisector(u32),
}

/// A triangle clipped by the cell of a seed: a convex polygon, known by the lines of its edges alone.
///
/// Vertex m lies where line m - 1 meets line m; edge m leads from vertex m to vertex m + 1, counter-clockwise as the
/// triangle is. Buffers are reused from one triangle to the next.
#[derive(Default)]
pub(super) struct Polygon {
    /// The bisectors that may cut the triangle.
    pub(super) bisectors: Vec<Bisector>,
    /// The lines of the edges, in order; none where nothing is left.
    pub(super) lines: Vec<Line>,
    next: Vec<Line>,
}

impl Polygon {
    /// Sets the lines of what the bisectors leave of the triangle of `view` (Sutherland, Hodgman 1974, on exact signs).
    pub(super) fn clip(&mut self, view: &View) {
        self.lines.clear();
        self.lines.extend([Line::Edge(0), Line::Edge(1), Line::Edge(2)]);
        for l in 0..self.bisectors.len() {
            match [0, 1, 2].map(|c| view.side_of_corner(c, &self.bisectors[l])) {
                [Sign::Positive, Sign::Positive, Sign::Positive] => {}
                corners => self.cut(view, l, corners),
            }
            if self.lines.is_empty() {
                return;
            }
        }
    }

    /// Cuts off what lies beyond bisector `number` of the list, whose sides of the corners are `corners`.
    fn cut(&mut self, view: &View, number: usize, corners: [Sign; 3]) {
        let l = &self.bisectors[number];
        self.next.clear();
        if corners == [Sign::Negative; 3] {
            self.lines.clear();
        }
        let Some(&last) = self.lines.last() else { return };
        let first = self.side(view, last, self.lines[0], l, corners);
        let mut here = first;
        for (m, &line) in self.lines.iter().enumerate() {
            let there = self.lines.get(m + 1).map_or(first, |&next| self.side(view, line, next, l, corners));
            if here == Sign::Positive || there == Sign::Positive {
                self.next.push(line);
                if there != Sign::Positive {
                    self.next.push(Line::Bisector(number as u32));
                }
            }
            here = there;
        }
        std::mem::swap(&mut self.lines, &mut self.next);
    }

    /// Side of the vertex between lines `a` and `b` against bisector `l`.
    fn side(&self, view: &View, a: Line, b: Line, l: &Bisector, corners: [Sign; 3]) -> Sign {
        match (a, b) {
            // Edge c begins at corner c.
            (Line::Edge(_), Line::Edge(c)) => corners[c as usize],
            (Line::Edge(e), Line::Bisector(j)) | (Line::Bisector(j), Line::Edge(e)) => {
                let (u, v) = (e as usize, (e as usize + 1) % 3);
                view.side_on_edge(u, v, &self.bisectors[j as usize], l)
            }
            (Line::Bisector(j), Line::Bisector(k)) => {
                view.side_within(&self.bisectors[j as usize], &self.bisectors[k as usize], l)
            }
        }
    }

    /// Positions of the vertices, relative to the cell's seed as the triangle's `corners` are. `ids` are the surface's vertices
    /// at these: two triangles that share an edge go along it the same way.
    pub(super) fn positions(&self, view: &View, corners: [DVec3; 3], ids: [u32; 3], out: &mut Vec<DVec3>) {
        out.clear();
        let mut before = self.lines[self.lines.len() - 1];
        for &line in &self.lines {
            out.push(match (before, line) {
                (Line::Edge(_), Line::Edge(c)) => corners[c as usize],
                (Line::Edge(e), Line::Bisector(j)) | (Line::Bisector(j), Line::Edge(e)) => {
                    let (u, v) = (e as usize, (e as usize + 1) % 3);
                    let (u, v) = if ids[u] < ids[v] { (u, v) } else { (v, u) };
                    let t = view.place_on_edge(u, v, &self.bisectors[j as usize]);
                    corners[u] + (corners[v] - corners[u]) * t
                }
                (Line::Bisector(j), Line::Bisector(k)) => {
                    let (j, k) = (&self.bisectors[j as usize], &self.bisectors[k as usize]);
                    view.place_within(j, k, corners)
                }
            });
            before = line;
        }
    }
}

/// Where the segment from `u` to `v` meets the bisector of two seeds, lower index first; `u` is the surface's vertex with the
/// lower index.
pub(super) fn on_edge(u: DVec3, v: DVec3, [i, j]: [DVec3; 2]) -> DVec3 {
    let view = View { corners: [u, v, v], seed: i };
    let t = view.place_on_edge(0, 1, &view.bisector(0, j));
    u + (v - u) * t
}

/// Where the bisectors of three seeds, ascending, meet on the triangle with these corners.
pub(super) fn within(corners: [DVec3; 3], [i, j, k]: [DVec3; 3]) -> DVec3 {
    let view = View { corners, seed: i };
    view.place_within(&view.bisector(0, j), &view.bisector(0, k), corners)
}

/// The seed that owns point `at`, by descent over Delaunay neighbours from `start`: Voronoi cells are convex, so a seed
/// that no neighbour beats is the nearest. Ties as everywhere.
pub(super) fn owner(at: DVec3, start: u32, adjacency: &Adjacency, points: &[DVec3]) -> u32 {
    let mut best = start;
    while let Some(&next) =
        adjacency.of(best as usize).iter().find(|&&j| closer(at, points[j as usize], points[best as usize]))
    {
        best = next;
    }
    best
}
