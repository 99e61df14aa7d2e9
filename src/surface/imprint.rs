//! Lines of the user's on a surface: its triangles are cut along them, so that they are chains of its edges.
//!
//! 1. Each vertex of a line goes to the closest point of the surface: to a vertex or an edge that is very close, which is cut
//!    there, or into a triangle, which becomes three.
//! 2. From one such point to the next the line follows the plane through both that stands upright on the surface, the mean of
//!    the normals at both being up: around the present vertex, the edge that the plane cuts next is cut in two, and the
//!    cut is the next vertex, unless a vertex of the surface is very close.
//! 3. What the line went along is marked; lines that cross share the vertex where they do.
//!
//! The surface stays where it was but for the rounding of new vertices to the grid. Every part of a triangle keeps what is known
//! of it: its source, its patch, its shell.

use glam::DVec3;

use super::Surface;
use super::box_tree::BoxTree;
use super::edges;
use crate::geometry::frame::snap;
use crate::geometry::triangle;

/// Lines may be so far from the surface, over its diagonal.
pub const TOLERANCE: f64 = 0.01;

/// A vertex of a line closer than this share of the diagonal to a vertex or an edge of the surface is on it; also than the
/// second share of the triangle's shortest edge.
const CLOSE: f64 = 1e-6;
const CLOSE_ON_TRIANGLE: f64 = 0.02;

/// A line to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// Its vertices, in the model's coordinates; closed where the first is also the last.
    pub points: Vec<DVec3>,
    /// Its number for messages, such as that of its line in a file.
    pub line: usize,
}

/// Why a line cannot be kept.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LineError {
    /// It is not on the surface.
    #[error(
        "line {line}: the point ({}, {}, {}) is {distance:.3e} away from the surface, more than {most:.3e}, 1 % of its diagonal",
        place[0], place[1], place[2]
    )]
    OffSurface {
        /// Its number.
        line: usize,
        /// The vertex.
        place: [f64; 3],
        /// Its distance from the surface, and what would be allowed.
        distance: f64,
        /// What would be allowed.
        most: f64,
    },
    /// The way along the surface from one of its vertices to the next is another one.
    #[error(
        "line {line}: the way on the surface from ({}, {}, {}) to ({}, {}, {}) is not along the line: between them it leaves the \
         surface by more than {most:.3e}, 1 % of its diagonal",
        from[0], from[1], from[2], to[0], to[1], to[2]
    )]
    Leaves {
        /// Its number.
        line: usize,
        /// The vertex before.
        from: [f64; 3],
        /// The vertex behind.
        to: [f64; 3],
        /// What would be allowed.
        most: f64,
    },
    /// It has a coordinate that is no number.
    #[error("line {line}: vertex {vertex} of it is not finite")]
    NotFinite {
        /// Its number.
        line: usize,
        /// The vertex, counted from 1.
        vertex: usize,
    },
    /// It has no length.
    #[error("line {line}: it has no two different points")]
    NoLength {
        /// Its number.
        line: usize,
    },
    /// Triangles along it cannot be cut.
    #[error("line {line}: it passes triangles that are too flat to be cut near ({}, {}, {})", place[0], place[1], place[2])]
    TooFlat {
        /// Its number.
        line: usize,
        /// Where.
        place: [f64; 3],
    },
}

impl Surface {
    /// The same surface with `lines` kept like creases, whatever the angle: as chains of its edges, for which its triangles
    /// are cut. Their vertices go to the closest points of the surface.
    ///
    /// # Errors
    /// [`LineError`] where a line is not on the surface, within [`TOLERANCE`].
    pub fn with_features(self, lines: &[Polyline]) -> Result<Surface, LineError> {
        let mut imprint = Imprint::new(self);
        for line in lines {
            imprint.draw(line)?;
        }
        Ok(imprint.finish())
    }
}

/// No triangle, vertex or edge.
const NONE: u32 = u32::MAX;

/// A surface that is being cut. Edge `i` of a triangle runs from its corner `i` to the next.
struct Imprint {
    surface: Surface,
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// The triangle across each edge.
    neighbors: Vec<[u32; 3]>,
    /// The edges on lines.
    marked: Vec<[bool; 3]>,
    /// For each vertex, one of its triangles.
    at: Vec<u32>,
    /// For each triangle, the one of the surface that it is a part of; and for each of the surface, its parts.
    whole: Vec<u32>,
    parts: Vec<Vec<u32>>,
}

/// Where a path goes on from a vertex.
enum Next {
    Vertex(u32),
    Cut { triangle: u32, edge: usize, place: DVec3 },
}

impl Imprint {
    fn new(surface: Surface) -> Imprint {
        let triangles = surface.triangles.clone();
        let twin = surface.twins();
        let count = triangles.len();
        let mut at = vec![NONE; surface.points.len()];
        for (t, v) in (0..).zip(&triangles) {
            v.iter().for_each(|&v| at[v as usize] = t);
        }
        let marked = (0..3 * count as u32).map(|e| surface.is_on_line(edges::ends(&triangles, e)));
        let marked: Vec<bool> = marked.collect();
        Imprint {
            points: surface.points.clone(),
            neighbors: (0..count).map(|t| [0, 1, 2].map(|i| twin[3 * t + i] / 3)).collect(),
            marked: marked.chunks_exact(3).map(|m| [m[0], m[1], m[2]]).collect(),
            at,
            whole: (0..count as u32).collect(),
            parts: (0..count as u32).map(|t| vec![t]).collect(),
            triangles,
            surface,
        }
    }

    /// Steps 1 to 3 for one line.
    fn draw(&mut self, line: &Polyline) -> Result<(), LineError> {
        if let Some(v) = line.points.iter().position(|p| !p.is_finite()) {
            return Err(LineError::NotFinite { line: line.line, vertex: v + 1 });
        }
        let mut vertices: Vec<u32> = Vec::with_capacity(line.points.len());
        for &p in &line.points {
            let v = self.vertex_at(p, line.line)?;
            if vertices.last() != Some(&v) {
                vertices.push(v);
            }
        }
        if vertices.len() < 2 {
            return Err(LineError::NoLength { line: line.line });
        }
        vertices.windows(2).try_for_each(|ends| self.connect([ends[0], ends[1]], line.line))
    }

    /// 1. The vertex for a point of a line.
    fn vertex_at(&mut self, model: DVec3, line: usize) -> Result<u32, LineError> {
        // Not brought to the grid: it may be far outside the frame.
        let frame = *self.surface.frame();
        let p = (model - frame.shift) * frame.scale;
        let most = TOLERANCE * self.surface.diagonal();
        let closest = self.surface.tree().closest(p);
        let distance = closest.distance2.sqrt();
        if distance > most {
            let [distance, most] = [distance, most].map(|d| frame.length_to_model(d));
            return Err(LineError::OffSurface { line, place: model.to_array(), distance, most });
        }
        let p = snap(closest.point);
        let away = |&t: &u32| triangle::closest_point(self.corners(t), p).distance_squared(p);
        let parts = &self.parts[closest.triangle as usize];
        let t = parts.iter().copied().min_by(|s, t| away(s).total_cmp(&away(t)));
        let t = t.expect("a triangle keeps a part: this is a bug in tetcvt");
        let close = self.close(t);
        let corners = self.corners(t);
        if let Some(i) = (0..3).find(|&i| corners[i].distance(p) <= close) {
            return Ok(self.triangles[t as usize][i]);
        }
        let on_edge = |i: usize| triangle::closest_on_segment(corners[i], corners[(i + 1) % 3], p);
        if let Some(i) = (0..3).find(|&i| on_edge(i).distance(p) <= close) {
            return self.checked(line, |cut| cut.split_edge(t, i, snap(on_edge(i))));
        }
        self.checked(line, |cut| cut.split_triangle(t, p))
    }

    /// How close to its vertices and edges a point of triangle `t` is on them.
    fn close(&self, t: u32) -> f64 {
        let [a, b, c] = self.corners(t);
        let shortest = a.distance(b).min(b.distance(c)).min(c.distance(a));
        (CLOSE * self.surface.diagonal()).min(CLOSE_ON_TRIANGLE * shortest)
    }

    /// 2. Marks a chain of edges from one vertex to another.
    fn connect(&mut self, [from, to]: [u32; 2], line: usize) -> Result<(), LineError> {
        let [a, b] = [from, to].map(|v| self.points[v as usize]);
        let up = self.normal(from) + self.normal(to);
        let across = (b - a).cross(up).normalize_or_zero();
        let most = TOLERANCE * self.surface.diagonal();
        let leaves = |frame: &crate::geometry::frame::Frame| {
            let [from, to] = [a, b].map(|p| frame.to_model(p).to_array());
            LineError::Leaves { line, from, to, most: frame.length_to_model(most) }
        };
        let (mut before, mut here) = (NONE, from);
        // A path that meets every triangle a few times goes round in circles.
        for _ in 0..3 * self.triangles.len() + 8 {
            if self.mark(here, to) {
                return Ok(());
            }
            let next = match self.next(before, here, (a, b, across)) {
                Some(Next::Vertex(v)) => v,
                Some(Next::Cut { triangle, edge, place }) => {
                    self.checked(line, |cut| cut.split_edge(triangle, edge, place))?
                }
                None => return Err(leaves(self.surface.frame())),
            };
            let place = self.points[next as usize];
            if triangle::closest_on_segment(a, b, place).distance(place) > most {
                return Err(leaves(self.surface.frame()));
            }
            self.mark(here, next);
            (before, here) = (here, next);
        }
        Err(leaves(self.surface.frame()))
    }

    /// Where the plane through `a` across `across` goes on from vertex `here`, towards `b` and not back.
    fn next(&self, before: u32, here: u32, (a, b, across): (DVec3, DVec3, DVec3)) -> Option<Next> {
        let center = self.points[here as usize];
        let side = |v: u32| (self.points[v as usize] - a).dot(across);
        let mut best: Option<(f64, Next)> = None;
        let mut consider = |place: DVec3, next: Next| {
            let ahead = (place - center).normalize_or_zero().dot((b - center).normalize_or_zero());
            if best.as_ref().is_none_or(|b| ahead > b.0) {
                best = Some((ahead, next));
            }
        };
        for (t, k) in self.fan(here) {
            let edge = (k + 1) % 3;
            let [x, y] = [1, 2].map(|i| self.triangles[t as usize][(k + i) % 3]);
            let close = self.close(t);
            let (sx, sy) = (side(x), side(y));
            // Every vertex of the fan is the first of one of its edges.
            if sx.abs() <= close {
                if x != before {
                    consider(self.points[x as usize], Next::Vertex(x));
                }
            } else if sy.abs() > close && (sx < 0.0) != (sy < 0.0) {
                let [p, q] = [x, y].map(|v| self.points[v as usize]);
                let place = snap(p.lerp(q, sx / (sx - sy)));
                match [(x, p), (y, q)].into_iter().find(|(_, end)| end.distance(place) <= close) {
                    Some((v, end)) if v != before => consider(end, Next::Vertex(v)),
                    Some(_) => {}
                    None => consider(place, Next::Cut { triangle: t, edge, place }),
                }
            }
        }
        best.map(|b| b.1)
    }

    /// The unit normal at a vertex.
    fn normal(&self, v: u32) -> DVec3 {
        let sum: DVec3 = self.fan(v).map(|(t, _)| self.normal2(t)).sum();
        sum.normalize_or_zero()
    }

    /// The triangles around a vertex, each with its corner there.
    fn fan(&self, v: u32) -> impl Iterator<Item = (u32, usize)> {
        let first = self.at[v as usize];
        let corner = move |t: u32| {
            let i = self.triangles[t as usize].iter().position(|&w| w == v);
            i.expect("the fan of a vertex: this is a bug in tetcvt")
        };
        std::iter::successors(Some((first, corner(first))), move |&(t, k)| {
            let next = self.neighbors[t as usize][k];
            (next != first).then(|| (next, corner(next)))
        })
    }

    /// 3. Marks the edge between two vertices, if there is one.
    fn mark(&mut self, a: u32, b: u32) -> bool {
        let Some((t, k)) = self.fan(a).find(|&(t, k)| self.triangles[t as usize][(k + 1) % 3] == b) else {
            return false;
        };
        let u = self.neighbors[t as usize][k];
        let back = self.triangles[u as usize].iter().position(|&w| w == b);
        self.marked[t as usize][k] = true;
        self.marked[u as usize][back.expect("twins share their ends: this is a bug in tetcvt")] = true;
        true
    }

    /// A cut, refused where a part would have no area or be turned over.
    fn checked(&mut self, line: usize, cut: impl FnOnce(&mut Imprint) -> u32) -> Result<u32, LineError> {
        let v = cut(self);
        let turned = |(t, _): (u32, usize)| self.normal2(t).dot(self.surface.normal2(self.whole[t as usize])) <= 0.0;
        if self.fan(v).any(turned) {
            let place = self.surface.frame().to_model(self.points[v as usize]).to_array();
            return Err(LineError::TooFlat { line, place });
        }
        Ok(v)
    }

    /// Cuts edge `i` of triangle `t`, and the triangle across, at `place`; returns the new vertex.
    ///
    /// ```text
    ///       c                c
    ///      / \              /|\
    ///     / t \            / | \
    ///    a --- b    ->    a--m--b
    ///     \ u /            \ | /
    ///      \ /              \|/
    ///       d                d
    /// ```
    fn split_edge(&mut self, t: u32, i: usize, place: DVec3) -> u32 {
        let u = self.neighbors[t as usize][i];
        let [a, b, c] = [0, 1, 2].map(|k| self.triangles[t as usize][(i + k) % 3]);
        let j = self.triangles[u as usize].iter().position(|&w| w == b);
        let j = j.expect("twins share their ends: this is a bug in tetcvt");
        let d = self.triangles[u as usize][(j + 2) % 3];
        let turned = |of: [u32; 3], by: usize| [0, 1, 2].map(|k| of[(by + k) % 3]);
        let (nt, nu) = (turned(self.neighbors[t as usize], i), turned(self.neighbors[u as usize], j));
        let flags = |of: [bool; 3], by: usize| [0, 1, 2].map(|k| of[(by + k) % 3]);
        let (mt, mu) = (flags(self.marked[t as usize], i), flags(self.marked[u as usize], j));
        let m = self.push_vertex(place, t);
        let t2 = self.push_part(t);
        let u2 = self.push_part(u);
        // amc and mbc, bmd and mad.
        self.set(t, [a, m, c], [u2, t2, nt[2]], [mt[0], false, mt[2]]);
        self.set(t2, [m, b, c], [u, nt[1], t], [mt[0], mt[1], false]);
        self.set(u, [b, m, d], [t2, u2, nu[2]], [mu[0], false, mu[2]]);
        self.set(u2, [m, a, d], [t, nu[1], u], [mu[0], mu[1], false]);
        self.relink(nt[1], t, t2, [b, c]);
        self.relink(nu[1], u, u2, [a, d]);
        for (v, t) in [(a, t), (b, t2), (c, t), (d, u)] {
            self.at[v as usize] = t;
        }
        m
    }

    /// Cuts triangle `t` in three at `place`; returns the new vertex.
    fn split_triangle(&mut self, t: u32, place: DVec3) -> u32 {
        let [a, b, c] = self.triangles[t as usize];
        let (n, marked) = (self.neighbors[t as usize], self.marked[t as usize]);
        let m = self.push_vertex(place, t);
        let t2 = self.push_part(t);
        let t3 = self.push_part(t);
        self.set(t, [a, b, m], [n[0], t2, t3], [marked[0], false, false]);
        self.set(t2, [b, c, m], [n[1], t3, t], [marked[1], false, false]);
        self.set(t3, [c, a, m], [n[2], t, t2], [marked[2], false, false]);
        self.relink(n[1], t, t2, [b, c]);
        self.relink(n[2], t, t3, [c, a]);
        for (v, t) in [(a, t), (b, t), (c, t2)] {
            self.at[v as usize] = t;
        }
        m
    }

    fn push_vertex(&mut self, place: DVec3, t: u32) -> u32 {
        self.points.push(place);
        self.at.push(t);
        self.points.len() as u32 - 1
    }

    /// A further part of what triangle `t` is a part of, still to be set.
    fn push_part(&mut self, t: u32) -> u32 {
        let (new, whole) = (self.triangles.len() as u32, self.whole[t as usize]);
        self.triangles.push([NONE; 3]);
        self.neighbors.push([NONE; 3]);
        self.marked.push([false; 3]);
        self.whole.push(whole);
        self.parts[whole as usize].push(new);
        new
    }

    fn set(&mut self, t: u32, triangle: [u32; 3], neighbors: [u32; 3], marked: [bool; 3]) {
        self.triangles[t as usize] = triangle;
        self.neighbors[t as usize] = neighbors;
        self.marked[t as usize] = marked;
    }

    /// Tells the triangle across the edge of these ends that `new` has it, and no longer `old`.
    fn relink(&mut self, across: u32, old: u32, new: u32, ends: [u32; 2]) {
        let corners = self.triangles[across as usize];
        let on_edge = |i: &usize| ends.contains(&corners[*i]) && ends.contains(&corners[(i + 1) % 3]);
        let i = (0..3).find(on_edge).expect("twins share their ends: this is a bug in tetcvt");
        debug_assert_eq!(self.neighbors[across as usize][i], old);
        self.neighbors[across as usize][i] = new;
    }

    fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.points[v as usize])
    }

    fn normal2(&self, t: u32) -> DVec3 {
        let [a, b, c] = self.corners(t);
        triangle::normal2(a, b, c)
    }

    fn finish(self) -> Surface {
        let Imprint { surface, points, triangles, marked, whole, .. } = self;
        let of_whole = |values: &[u32]| whole.iter().map(|&t| values[t as usize]).collect();
        let mut lines: Vec<[u32; 2]> = (0..3 * triangles.len() as u32)
            .filter(|&e| marked[e as usize / 3][e as usize % 3])
            .map(|e| edges::ends(&triangles, e))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        lines.sort_unstable();
        lines.dedup();
        Surface {
            source: of_whole(&surface.source),
            patch: of_whole(&surface.patch),
            shell: of_whole(&surface.shell),
            tree: BoxTree::build(&points, &triangles),
            twins: edges::twins(&triangles),
            points,
            triangles,
            lines,
            ..surface
        }
    }
}
