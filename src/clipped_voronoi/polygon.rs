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
    /// The bisectors that cut the triangle's corners apart.
    pub(super) bisectors: Vec<Bisector>,
    /// The lines of the edges, in order; empty where the cell owns nothing.
    pub(super) lines: Vec<Line>,
    next: Vec<Line>,
    signs: Vec<Sign>,
}

impl Polygon {
    /// Clips the triangle of `view` by the bisectors with `neighbors` (Sutherland, Hodgman 1974, on exact signs).
    pub(super) fn clip(&mut self, view: &View, neighbors: &[u32], points: &[DVec3]) {
        self.bisectors.clear();
        self.lines.clear();
        self.lines.extend([Line::Edge(0), Line::Edge(1), Line::Edge(2)]);
        for &seed in neighbors {
            let at = points[seed as usize];
            if view.surely_closer(at) {
                continue;
            }
            let l = view.bisector(seed, at);
            let corners = [0, 1, 2].map(|c| view.side_of_corner(c, &l));
            if corners == [Sign::Positive; 3] {
                continue;
            }
            self.bisectors.push(l);
            self.cut(view, &l, corners);
            if self.lines.is_empty() {
                return;
            }
        }
    }

    /// Cuts off what lies beyond bisector `l`, the last of the list, whose sides of the corners are `corners`.
    fn cut(&mut self, view: &View, l: &Bisector, corners: [Sign; 3]) {
        let n = self.lines.len();
        self.signs.clear();
        for m in 0..n {
            let sign = self.side(view, self.lines[(m + n - 1) % n], self.lines[m], l, corners);
            self.signs.push(sign);
        }
        self.next.clear();
        let cut = Line::Bisector((self.bisectors.len() - 1) as u32);
        for m in 0..n {
            let (here, there) = (self.signs[m], self.signs[(m + 1) % n]);
            if here == Sign::Positive || there == Sign::Positive {
                self.next.push(self.lines[m]);
                if there != Sign::Positive {
                    self.next.push(cut);
                }
            }
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

    /// Positions of the vertices, relative to the cell's seed. `ids` are the surface's vertices at the corners: two
    /// triangles that share an edge, and cells that share a vertex, compute its position alike to the last bit.
    pub(super) fn positions(&self, view: &View, seed: u32, ids: [u32; 3], points: &[DVec3], out: &mut Vec<DVec3>) {
        out.clear();
        let n = self.lines.len();
        for m in 0..n {
            let p = match (self.lines[(m + n - 1) % n], self.lines[m]) {
                (Line::Edge(_), Line::Edge(c)) => view.corners[c as usize],
                (Line::Edge(e), Line::Bisector(j)) | (Line::Bisector(j), Line::Edge(e)) => {
                    let (u, v) = (e as usize, (e as usize + 1) % 3);
                    let (u, v) = if ids[u] < ids[v] { (u, v) } else { (v, u) };
                    let other = self.bisectors[j as usize].seed;
                    on_edge(view.corners[u], view.corners[v], in_order([seed, other], points))
                }
                (Line::Bisector(j), Line::Bisector(k)) => {
                    let others = [self.bisectors[j as usize].seed, self.bisectors[k as usize].seed];
                    let mut seeds = [seed, others[0], others[1]];
                    seeds.sort_unstable();
                    within(view.corners, seeds.map(|s| points[s as usize]))
                }
            };
            out.push(p - view.seed);
        }
    }
}

/// The two seeds' positions, lower index first.
fn in_order(seeds: [u32; 2], points: &[DVec3]) -> [DVec3; 2] {
    let [a, b] = seeds;
    if a < b { [points[a as usize], points[b as usize]] } else { [points[b as usize], points[a as usize]] }
}

/// Where the segment from `u` to `v` meets the bisector of two seeds, lower index first; `u` is the surface's vertex with the
/// lower index.
pub(super) fn on_edge(u: DVec3, v: DVec3, [i, j]: [DVec3; 2]) -> DVec3 {
    let view = View { corners: [u, v, v], seed: i };
    let t = view.place_on_edge(&view.bisector(0, j));
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
