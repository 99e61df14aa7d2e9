//! Creases and corners of a surface, by dihedral angle.
//!
//! Steps: 1. an edge is a crease when the normals of its two triangles differ by more than the angle, or when it is on a line of
//! the user's; 2. a vertex of
//! the crease graph is a corner unless exactly two creases meet there and go on within the angle; vertices without a
//! crease are corners when they are the tip of a cone; 3. creases are chained between corners, the rest are loops;
//! 4. triangles are flooded into patches across the edges that are not creases.

use glam::DVec3;

use super::Surface;
use super::edges;
use crate::disjoint_sets::DisjointSets;
use crate::geometry::triangle::closest_on_segment;

/// The tip of a cone is a corner when its triangles' angles sum to less than this share of a full turn: that of a cone
/// with a half-angle of 45 degrees at the tip. A vertex of a smooth, sampled surface lies far above it.
const TIP: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A crease: a chain of the surface's edges between two corners, or a closed loop.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The surface's vertices along it; a closed one repeats its first vertex at the end.
    pub vertices: Vec<u32>,
    /// Arc length from the first vertex to each, in frame units.
    pub arc: Vec<f64>,
    /// Whether some of it is a line of the user's.
    pub is_given: bool,
}

impl Curve {
    fn new(vertices: Vec<u32>, surface: &Surface) -> Curve {
        let points = surface.points();
        let mut arc = vec![0.0];
        for edge in vertices.windows(2) {
            let length = points[edge[0] as usize].distance(points[edge[1] as usize]);
            arc.push(arc[arc.len() - 1] + length);
        }
        let is_given = vertices.windows(2).any(|e| surface.is_on_line([e[0], e[1]]));
        Curve { vertices, arc, is_given }
    }

    /// Length, in frame units.
    pub fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// Whether it ends where it began.
    pub fn is_closed(&self) -> bool {
        self.vertices[0] == self.vertices[self.vertices.len() - 1]
    }

    /// The point at arc length `at`; beyond the ends, a closed curve goes round and an open one stops.
    pub fn point_at(&self, at: f64, points: &[DVec3]) -> DVec3 {
        let (i, at) = self.edge_at(at);
        let [a, b] = [self.vertices[i], self.vertices[i + 1]].map(|v| points[v as usize]);
        a.lerp(b, (at - self.arc[i]) / (self.arc[i + 1] - self.arc[i]))
    }

    /// The unit vector along the curve at arc length `at`.
    pub fn tangent_at(&self, at: f64, points: &[DVec3]) -> DVec3 {
        let (i, _) = self.edge_at(at);
        let [a, b] = [self.vertices[i], self.vertices[i + 1]].map(|v| points[v as usize]);
        (b - a).normalize_or_zero()
    }

    /// The edge at arc length `at`, and the arc length brought into the curve's range.
    fn edge_at(&self, at: f64) -> (usize, f64) {
        let length = self.length();
        let at = if self.is_closed() { at.rem_euclid(length) } else { at }.clamp(0.0, length);
        // The edge that holds `at` begins at the last vertex not beyond it.
        (self.arc.partition_point(|&s| s <= at).clamp(1, self.arc.len() - 1) - 1, at)
    }

    /// The arc length of the point of the curve closest to `p`, and its squared distance; the least arc length where
    /// several are equally close.
    pub fn closest(&self, p: DVec3, points: &[DVec3]) -> (f64, f64) {
        let mut best = (0.0, f64::INFINITY);
        for (i, edge) in self.vertices.windows(2).enumerate() {
            let [a, b] = [edge[0], edge[1]].map(|v| points[v as usize]);
            let q = closest_on_segment(a, b, p);
            let distance2 = q.distance_squared(p);
            if distance2 < best.1 {
                best = ((self.arc[i] + a.distance(q)).min(self.arc[i + 1]), distance2);
            }
        }
        best
    }
}

/// The corners, creases and smooth patches of a surface.
#[derive(Clone, Debug)]
pub struct Features {
    /// Vertices where creases meet, end or turn sharply, and tips of cones.
    pub corners: Vec<u32>,
    /// Creases.
    pub curves: Vec<Curve>,
    /// For each triangle, the smooth patch that it belongs to: patches are bounded by creases.
    pub face: Vec<u32>,
}

impl Features {
    /// The features of `surface`: edges whose faces' normals differ by more than `angle` degrees.
    ///
    /// At 180 degrees there are none but the user's lines: no corners, no curves, one patch per shell.
    pub fn find(surface: &Surface, angle: f64) -> Features {
        let twin = surface.twins();
        // 1.
        let crease = creases(surface, twin, angle);
        let graph = Graph::new(surface, twin, &crease);
        // 2.
        let is_corner = corners(surface, &graph, angle);
        // 3.
        let curves = chain(&graph, &is_corner);
        let curves = curves.into_iter().map(|vertices| Curve::new(vertices, surface)).collect();
        let corners = (0..is_corner.len() as u32).filter(|&v| is_corner[v as usize]).collect();
        // 4.
        Features { corners, curves, face: patches(twin, &crease) }
    }
}

/// For each edge of each triangle, whether it is a crease.
fn creases(surface: &Surface, twin: &[u32], angle: f64) -> Vec<bool> {
    let normals: Vec<DVec3> =
        (0..surface.triangles().len() as u32).map(|t| surface.normal2(t).normalize_or_zero()).collect();
    (0..twin.len())
        .map(|e| {
            let (n, m) = (normals[e / 3], normals[twin[e] as usize / 3]);
            // acos loses half its digits near 0 and 180 degrees; this does not.
            let is_sharp = angle < 180.0 && 2.0 * (n - m).length().atan2((n + m).length()) > angle.to_radians();
            is_sharp || surface.is_on_line(edges::ends(surface.triangles(), e as u32))
        })
        .collect()
}

/// The graph of the creases.
struct Graph {
    /// For each vertex, the first of its neighbours in `neighbour`.
    start: Vec<u32>,
    neighbor: Vec<u32>,
}

impl Graph {
    fn new(surface: &Surface, twin: &[u32], crease: &[bool]) -> Graph {
        let mut links: Vec<[u32; 2]> = vec![];
        for e in (0..twin.len() as u32).filter(|&e| crease[e as usize] && e < twin[e as usize]) {
            let [a, b] = edges::ends(surface.triangles(), e);
            links.extend([[a, b], [b, a]]);
        }
        links.sort_unstable();
        let mut start = vec![0; surface.points().len() + 1];
        links.iter().for_each(|l| start[l[0] as usize + 1] += 1);
        for v in 1..start.len() {
            start[v] += start[v - 1];
        }
        Graph { start, neighbor: links.iter().map(|l| l[1]).collect() }
    }

    fn around(&self, v: u32) -> &[u32] {
        &self.neighbor[self.start[v as usize] as usize..self.start[v as usize + 1] as usize]
    }
}

/// For each vertex, whether it is a corner.
fn corners(surface: &Surface, graph: &Graph, angle: f64) -> Vec<bool> {
    let points = surface.points();
    let mut turn = vec![0.0; points.len()];
    for t in 0..surface.triangles().len() as u32 {
        let corners = surface.corners(t);
        for (i, &v) in surface.triangles()[t as usize].iter().enumerate() {
            let [p, q, r] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
            turn[v as usize] += (q - p).angle_between(r - p);
        }
    }
    (0..points.len() as u32)
        .map(|v| match *graph.around(v) {
            [] => angle < 180.0 && turn[v as usize] < TIP * std::f64::consts::TAU,
            [u, w] => {
                let p = points[v as usize];
                (p - points[u as usize]).angle_between(points[w as usize] - p) > angle.to_radians()
            }
            _ => true,
        })
        .collect()
}

/// Chains the creases: first those between corners, in the order of their first vertex, then the loops.
fn chain(graph: &Graph, is_corner: &[bool]) -> Vec<Vec<u32>> {
    let mut used = vec![false; graph.neighbor.len()];
    let slot = |from: u32, to: u32| {
        let i = graph.around(from).binary_search(&to).expect("the graph is symmetric: this is a bug in tetcvt");
        graph.start[from as usize] as usize + i
    };
    let mut follow = |start: u32, mut next: u32| {
        let mut vertices = vec![start];
        let mut at = start;
        if used[slot(at, next)] {
            return None;
        }
        loop {
            used[slot(at, next)] = true;
            used[slot(next, at)] = true;
            vertices.push(next);
            if is_corner[next as usize] || next == start {
                return Some(vertices);
            }
            // Not a corner: exactly two creases meet here.
            let around = graph.around(next);
            let onward = if around[0] == at { around[1] } else { around[0] };
            (at, next) = (next, onward);
        }
    };
    let vertices = 0..is_corner.len() as u32;
    let mut curves = vec![];
    for corners in [true, false] {
        for v in vertices.clone().filter(|&v| is_corner[v as usize] == corners) {
            curves.extend(graph.around(v).iter().filter_map(|&next| follow(v, next)));
        }
    }
    curves
}

/// For each triangle, its patch; numbered by the first triangle of each.
fn patches(twin: &[u32], crease: &[bool]) -> Vec<u32> {
    let mut patches = DisjointSets::new(twin.len() / 3);
    for e in (0..twin.len()).filter(|&e| !crease[e]) {
        patches.join(e as u32 / 3, twin[e] / 3);
    }
    patches.number().0
}
