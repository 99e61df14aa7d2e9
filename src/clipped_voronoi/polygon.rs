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

/// What is left of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clipped {
    Nothing,
    Whole,
    /// What is on one side of the bisector at this place of [`Polygon::bisectors`], with its sides of the corners. The
    /// lines are not set.
    Once(usize, [Sign; 3]),
    /// A polygon with the lines that are set.
    Often,
}

/// A triangle clipped by the cell of a seed: a convex polygon, known by the lines of its edges alone.
///
/// Vertex m lies where line m - 1 meets line m; edge m leads from vertex m to vertex m + 1, counter-clockwise as the
/// triangle is. Buffers are reused from one triangle to the next.
#[derive(Default)]
pub(super) struct Polygon {
    /// The bisectors that cut the triangle's corners apart.
    pub(super) bisectors: Vec<Bisector>,
    /// The lines of the edges, in order.
    pub(super) lines: Vec<Line>,
    next: Vec<Line>,
}

impl Polygon {
    /// Clips the triangle of `view` by the bisectors with other seeds (Sutherland, Hodgman 1974, on exact signs).
    pub(super) fn clip(&mut self, view: &View, bisectors: impl Iterator<Item = Bisector>) -> Clipped {
        self.bisectors.clear();
        self.lines.clear();
        let mut first = [Sign::Positive; 3];
        for l in bisectors {
            let corners = [0, 1, 2].map(|c| view.side_of_corner(c, &l));
            if corners == [Sign::Positive; 3] {
                continue;
            }
            if corners == [Sign::Negative; 3] {
                return Clipped::Nothing;
            }
            self.bisectors.push(l);
            // Often there is one only, and nothing to be said but on which side the corners are.
            match self.bisectors.len() {
                1 => first = corners,
                2 => {
                    self.set_whole();
                    self.cut(view, 0, first);
                    self.cut(view, 1, corners);
                }
                n => self.cut(view, n - 1, corners),
            }
            if self.bisectors.len() > 1 && self.lines.is_empty() {
                return Clipped::Nothing;
            }
        }
        match self.bisectors.len() {
            0 => Clipped::Whole,
            1 => Clipped::Once(0, first),
            _ => self.summary(view),
        }
    }

    /// Sets the lines of a triangle that is [whole](Clipped::Whole).
    pub(super) fn set_whole(&mut self) {
        self.lines.clear();
        self.lines.extend([Line::Edge(0), Line::Edge(1), Line::Edge(2)]);
    }

    /// Sets the lines of a triangle that is clipped [once](Clipped::Once).
    pub(super) fn set_once(&mut self, bisector: Bisector, signs: [Sign; 3]) {
        self.bisectors.clear();
        self.bisectors.push(bisector);
        self.lines.clear();
        for c in 0..3 {
            let (here, there) = (signs[c] == Sign::Positive, signs[(c + 1) % 3] == Sign::Positive);
            if here || there {
                self.lines.push(Line::Edge(c as u8));
            }
            if here && !there {
                self.lines.push(Line::Bisector(0));
            }
        }
    }

    /// How many bisectors are left among the lines.
    fn summary(&self, view: &View) -> Clipped {
        let mut cuts = self.lines.iter().filter_map(|line| match *line {
            Line::Bisector(j) => Some(j as usize),
            Line::Edge(_) => None,
        });
        match (cuts.next(), cuts.next()) {
            (None, _) => Clipped::Whole,
            (Some(j), None) => Clipped::Once(j, [0, 1, 2].map(|c| view.side_of_corner(c, &self.bisectors[j]))),
            _ => Clipped::Often,
        }
    }

    /// Cuts off what lies beyond bisector `number` of the list, whose sides of the corners are `corners`.
    fn cut(&mut self, view: &View, number: usize, corners: [Sign; 3]) {
        let l = &self.bisectors[number];
        self.next.clear();
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
                    let [_, b, c] = view.place_within(j, k);
                    corners[0] + (corners[1] - corners[0]) * b + (corners[2] - corners[0]) * c
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
    let [_, b, c] = view.place_within(&view.bisector(0, j), &view.bisector(0, k));
    corners[0] + (corners[1] - corners[0]) * b + (corners[2] - corners[0]) * c
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
