//! Tets of the second order: a node in the middle of each edge, on the surface where the edge is on the boundary.
//!
//! 1. Each edge of the mesh gets a node in its middle.
//! 2. Where the edge belongs to the boundary, the node moves to the point of the surface closest to that middle; where it
//!    follows a crease, to the middle of the crease's stretch between its ends.
//! 3. A tet must not fold. The determinant of the Jacobian of its quadratic map is a polynomial of degree 3 in the
//!    barycentric coordinates, and lies between the least and the greatest of its 20 Bernstein coefficients (A. Johnen,
//!    J.-F. Remacle, C. Geuzaine, *Geometrical validity of curvilinear finite elements*, Journal of Computational Physics
//!    233, 2013, doi 10.1016/j.jcp.2012.08.051). While the least of them is below `LEAST` of the straight tet's, the
//!    moves of its nodes are halved; after `HALVINGS` the nodes are back on their edges, and the tet is straight.
//!
//! Departure: coefficients are not subdivided where they do not decide. A tet whose determinant is positive though a
//! coefficient is not is straightened a little more than it needs; what is kept is valid without doubt. The bound, far
//! above rounding, keeps determinants away from 0, too. Cost: linear in the tets but for a sort of the edges.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::tetrahedron::EDGES;
use crate::seeds::SeedKind;
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::tet_mesh::TetMesh;

/// The least Bernstein coefficient of a curved tet's Jacobian determinant, over the straight tet's determinant.
const LEAST: f64 = 0.1;

/// So often the moves of a tet's nodes are halved before they are taken back.
const HALVINGS: u8 = 6;

/// The edges of a tet in the order in which files list their middles; in triangles 01, 12, 20.
const ORDER: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Distance from a crease, over the length of an edge, up to which a vertex is on it.
const ON_CREASE: f64 = 1e-6;

/// Nodes in the middle of the edges of a mesh, in model units.
#[derive(Clone, Debug)]
pub struct SecondOrder {
    /// The nodes, by edge: ascending by the edge's lower, then by its higher vertex.
    pub points: Vec<DVec3>,
    /// What each lies on.
    pub kinds: Vec<SeedKind>,
    /// For each tet its nodes, on the edges 01, 12, 02, 03, 13 and 23.
    pub tets: Vec<[u32; 6]>,
    /// For each boundary triangle its nodes, on the edges 01, 12 and 20.
    pub triangles: Vec<[u32; 3]>,
    /// How many nodes on the boundary are not as far out as the surface, because a tet would fold.
    pub held_back: usize,
}

impl SecondOrder {
    /// The nodes for `mesh`, a mesh of the solid that `surface` bounds.
    pub fn of(mesh: &TetMesh, surface: &Surface, features: &Features) -> SecondOrder {
        // 1.
        let edges = edges(&mesh.tets);
        let find = |a: u32, b: u32| {
            let place = edges.binary_search(&[a.min(b), a.max(b)]);
            place.expect("every edge of a tet is listed: this is a bug in tetcvt") as u32
        };
        let tets: Vec<[u32; 6]> = mesh.tets.par_iter().map(|t| ORDER.map(|[i, j]| find(t[i], t[j]))).collect();
        let triangles: Vec<[u32; 3]> =
            mesh.boundary.iter().map(|t| [0, 1, 2].map(|i| find(t.vertices[i], t.vertices[(i + 1) % 3]))).collect();
        let corner = |v: u32| mesh.points[v as usize];
        let middles: Vec<DVec3> = edges.iter().map(|e| corner(e[0]) * 0.5 + corner(e[1]) * 0.5).collect();
        // 2.
        let mut kinds = vec![SeedKind::Interior; edges.len()];
        triangles.iter().flatten().for_each(|&e| kinds[e as usize] = SeedKind::Surface);
        let mut creases = crease_targets(mesh, surface, features);
        creases.retain(|(edge, _)| {
            let place = edges.binary_search(edge);
            place.is_ok_and(|e| kinds[e] == SeedKind::Surface)
        });
        creases.iter().for_each(|(edge, _)| kinds[find(edge[0], edge[1]) as usize] = SeedKind::Curve);
        let frame = surface.frame();
        let moves: Vec<DVec3> = (0..edges.len())
            .into_par_iter()
            .map(|e| match kinds[e] {
                SeedKind::Interior => DVec3::ZERO,
                SeedKind::Curve => {
                    let place = creases.binary_search_by_key(&edges[e], |c| c.0);
                    let place = place.expect("every node of a crease has its place: this is a bug in tetcvt");
                    frame.to_model(creases[place].1) - middles[e]
                }
                _ => frame.to_model(surface.tree().closest(frame.to_frame(middles[e])).point) - middles[e],
            })
            .collect();
        // 3.
        let mut nodes = Nodes { mesh, tets: &tets, middles: &middles, moves: &moves, halvings: vec![0; edges.len()] };
        nodes.unfold(frame.scale);
        let points = (0..edges.len()).map(|e| nodes.at(e)).collect();
        let held_back = nodes.halvings.iter().zip(&moves).filter(|&(&h, &m)| h > 0 && m != DVec3::ZERO).count();
        SecondOrder { points, kinds, tets, triangles, held_back }
    }
}

/// The edges of the tets, each once, ascending.
fn edges(tets: &[[u32; 4]]) -> Vec<[u32; 2]> {
    let ends = |t: &[u32; 4]| EDGES.map(|[i, j]| [t[i].min(t[j]), t[i].max(t[j])]);
    let mut edges: Vec<[u32; 2]> = tets.iter().flat_map(ends).collect();
    edges.par_sort_unstable();
    edges.dedup();
    edges
}

/// Pairs of vertices next to each other on a crease, ascending, with the middle of the stretch between them, in the frame.
fn crease_targets(mesh: &TetMesh, surface: &Surface, features: &Features) -> Vec<([u32; 2], DVec3)> {
    let frame = surface.frame();
    let on_some: Vec<(u32, DVec3)> = (0..mesh.points.len() as u32)
        .filter(|&v| matches!(mesh.kinds[v as usize], SeedKind::Curve | SeedKind::Corner))
        .map(|v| (v, frame.to_frame(mesh.points[v as usize])))
        .collect();
    let of_curve = |curve: &crate::surface::features::Curve| {
        let tolerance = ON_CREASE * curve.length();
        let mut along: Vec<(f64, u32)> = on_some
            .iter()
            .filter_map(|&(v, p)| {
                let (at, distance2) = curve.closest(p, surface.points());
                (distance2 <= tolerance * tolerance).then_some((at, v))
            })
            .collect();
        along.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut found = Vec::new();
        let mut stretch = |a: (f64, u32), b: (f64, u32)| {
            found.push(([a.1.min(b.1), a.1.max(b.1)], curve.point_at((a.0 + b.0) / 2.0, surface.points())));
        };
        along.windows(2).for_each(|pair| stretch(pair[0], pair[1]));
        if let (true, [first, .., last]) = (curve.is_closed(), along.as_slice()) {
            stretch(*last, (first.0 + curve.length(), first.1));
        }
        found
    };
    let mut targets: Vec<([u32; 2], DVec3)> = features.curves.par_iter().flat_map_iter(of_curve).collect();
    // Where two creases join the same vertices the first has the edge.
    targets.sort_by_key(|t| t.0);
    targets.dedup_by_key(|t| t.0);
    targets
}

/// The nodes on their way from the middles of the edges.
struct Nodes<'a> {
    mesh: &'a TetMesh,
    tets: &'a [[u32; 6]],
    middles: &'a [DVec3],
    moves: &'a [DVec3],
    halvings: Vec<u8>,
}

impl Nodes<'_> {
    /// Where the node of edge `e` is.
    fn at(&self, e: usize) -> DVec3 {
        match self.halvings[e] {
            0 => self.middles[e] + self.moves[e],
            HALVINGS.. => self.middles[e],
            n => self.middles[e] + self.moves[e] * 0.5f64.powi(n.into()),
        }
    }

    /// Halves moves until no tet folds. Lengths are multiplied by `scale`: they become about 1.
    fn unfold(&mut self, scale: f64) {
        let curved = |t: &usize| self.tets[*t].iter().any(|&e| self.moves[e as usize] != DVec3::ZERO);
        let mut suspects: Vec<usize> = (0..self.tets.len()).filter(curved).collect();
        loop {
            let folded: Vec<usize> = suspects.par_iter().copied().filter(|&t| self.folds(t, scale)).collect();
            let before = self.halvings.clone();
            for e in folded.iter().flat_map(|&t| self.tets[t]) {
                let e = e as usize;
                if self.moves[e] != DVec3::ZERO {
                    self.halvings[e] = (before[e] + 1).min(HALVINGS);
                }
            }
            if self.halvings == before {
                return;
            }
            // Only tets that share a halved edge can have changed.
            let changed = |t: &usize| self.tets[*t].iter().any(|&e| self.halvings[e as usize] > 0);
            suspects = (0..self.tets.len()).filter(changed).collect();
        }
    }

    /// Whether the Jacobian determinant of tet `t` comes near 0.
    fn folds(&self, t: usize, scale: f64) -> bool {
        let corners = self.mesh.corners(t);
        let relative = |p: DVec3| (p - corners[0]) * scale;
        let nodes = self.tets[t].map(|e| relative(self.at(e as usize)));
        let corners = corners.map(relative);
        let straight = (corners[1]).cross(corners[2]).dot(corners[3]);
        jacobian_coefficients(corners, nodes).into_iter().any(|c| c < LEAST * straight)
    }
}

/// The Bernstein coefficients of the Jacobian determinant of a tet of the second order.
///
/// With nodes in Bernstein form, q_ii the corners and q_ij = 2 m_ij - (p_i + p_j) / 2, the derivative along l_k - l_0 is
/// 2 sum_i l_i (q_ik - q_i0): linear, so that the determinant of three of them is a sum over the corners a, b, c at which
/// the three are taken, of weight l_a l_b l_c.
fn jacobian_coefficients(p: [DVec3; 4], middles: [DVec3; 6]) -> [f64; 20] {
    let mut q = [[DVec3::ZERO; 4]; 4];
    for (i, &corner) in p.iter().enumerate() {
        q[i][i] = corner;
    }
    for ([i, j], m) in ORDER.into_iter().zip(middles) {
        q[i][j] = m * 2.0 - (p[i] + p[j]) * 0.5;
        q[j][i] = q[i][j];
    }
    // derivative[k][i]: along edge 0 to k + 1, its coefficient at corner i.
    let derivative = [1, 2, 3].map(|k| [0, 1, 2, 3].map(|i: usize| (q[i][k] - q[i][0]) * 2.0));
    let mut sums = [[[0.0; 4]; 4]; 4];
    for a in 0..4 {
        for b in 0..4 {
            let across = derivative[0][a].cross(derivative[1][b]);
            for (c, slope) in derivative[2].iter().enumerate() {
                let mut index = [a, b, c];
                index.sort_unstable();
                let [i, j, k] = index;
                sums[i][j][k] += across.dot(*slope);
            }
        }
    }
    let mut coefficients = [0.0; 20];
    let indices = (0..4).flat_map(|i| (i..4).flat_map(move |j| (j..4).map(move |k| (i, j, k))));
    for (coefficient, (i, j, k)) in coefficients.iter_mut().zip(indices) {
        // So many products share the index: 3! over the factorials of how often each corner occurs.
        let count = match (i == j, j == k) {
            (true, true) => 1.0,
            (false, false) => 6.0,
            _ => 3.0,
        };
        *coefficient = sums[i][j][k] / count;
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];

    fn middles() -> [DVec3; 6] {
        ORDER.map(|[i, j]| (CORNERS[i] + CORNERS[j]) * 0.5)
    }

    /// The determinant at a point, from differences of the quadratic map.
    fn determinant(middles: [DVec3; 6], [x, y, z]: [f64; 3]) -> f64 {
        let map = |x: f64, y: f64, z: f64| {
            let l = [1.0 - x - y - z, x, y, z];
            let corners: DVec3 = (0..4).map(|i| CORNERS[i] * (l[i] * (2.0 * l[i] - 1.0))).sum();
            corners + ORDER.iter().zip(middles).map(|(&[i, j], m)| m * (4.0 * l[i] * l[j])).sum::<DVec3>()
        };
        // Central differences are exact for quadratic maps.
        let h = 0.25;
        let along = |d: DVec3| {
            (map(x + h * d.x, y + h * d.y, z + h * d.z) - map(x - h * d.x, y - h * d.y, z - h * d.z)) / (2.0 * h)
        };
        along(DVec3::X).cross(along(DVec3::Y)).dot(along(DVec3::Z))
    }

    #[test]
    fn straight_tets_have_one_determinant() {
        for c in jacobian_coefficients(CORNERS, middles()) {
            assert!((c - 1.0).abs() < 1e-14, "{c}");
        }
    }

    #[test]
    fn the_coefficients_are_those_of_the_determinant() {
        let mut bent = middles();
        bent[0] += DVec3::new(0.05, -0.2, 0.1);
        bent[4] += DVec3::new(-0.1, 0.07, 0.11);
        bent[5] += DVec3::new(0.02, 0.01, -0.3);
        let coefficients = jacobian_coefficients(CORNERS, bent);
        for point in [[0.0; 3], [1.0, 0.0, 0.0], [0.25; 3], [0.1, 0.6, 0.2], [0.0, 0.3, 0.3]] {
            let l = [1.0 - point.iter().sum::<f64>(), point[0], point[1], point[2]];
            let indices = (0..4).flat_map(|i| (i..4).flat_map(move |j| (j..4).map(move |k| [i, j, k])));
            let value: f64 = indices
                .zip(coefficients)
                .map(|(index, c)| {
                    let factorial = |n: usize| (1..=n).product::<usize>() as f64;
                    let often = [0, 1, 2, 3].map(|v| index.iter().filter(|&&i| i == v).count());
                    let count = 6.0 / often.map(factorial).iter().product::<f64>();
                    c * count * index.iter().map(|&i| l[i]).product::<f64>()
                })
                .sum();
            assert!((value - determinant(bent, point)).abs() < 1e-13, "{point:?}: {value}");
        }
    }
}
