//! Circumcentres, accurate for flat tets too.

use glam::DVec3;
use rayon::prelude::*;

use super::expansion::Expansion;
use crate::delaunay::Delaunay;
use crate::geometry::tetrahedron;

/// Below this share of the product of three edge lengths a determinant is computed exactly: the error of the circumcentre
/// in floating point is the rounding unit over that share.
const FLAT: f64 = 1e-4;

/// Circumcentres of the tets whose winding is not 0; others are never asked for.
pub(super) fn circumcenters(delaunay: &Delaunay, winding: &[i32]) -> Vec<DVec3> {
    let points = delaunay.points();
    let center = |(v, &w): (&[u32; 4], &i32)| {
        if w == 0 {
            return DVec3::ZERO;
        }
        circumcenter(v.map(|i| points[i as usize]))
    };
    delaunay.vertices().par_iter().zip(winding).map(center).collect()
}

/// The circumcentre of a tet that is not flat, however nearly so, its corners on the grid of the frame.
pub(super) fn circumcenter([a, b, c, d]: [DVec3; 4]) -> DVec3 {
    let (u, v, w) = (b - a, c - a, d - a);
    let det = u.cross(v).dot(w);
    let size2 = u.length_squared() * v.length_squared() * w.length_squared();
    if det * det > FLAT * FLAT * size2 { tetrahedron::circumcenter(a, b, c, d) } else { a + exact(u, v, w) }
}

/// The circumcentre of the tet (0, u, v, w): |u|^2 (v x w) + |v|^2 (w x u) + |w|^2 (u x v) over 2 det(u, v, w).
fn exact(u: DVec3, v: DVec3, w: DVec3) -> DVec3 {
    let square = |p: DVec3| {
        let mut sum = Expansion::default();
        (0..3).for_each(|axis| sum.add_product(p[axis], p[axis]));
        sum
    };
    let cross = |p: DVec3, q: DVec3| {
        [(1, 2), (2, 0), (0, 1)].map(|(y, z)| {
            let mut minor = Expansion::default();
            minor.add_product(p[y], q[z]);
            minor.add_product(-p[z], q[y]);
            minor
        })
    };
    let normals = [cross(v, w), cross(w, u), cross(u, v)];
    let squares = [square(u), square(v), square(w)];
    let numerator = [0, 1, 2].map(|axis| {
        let terms = [0, 1, 2].map(|k| normals[k][axis].times(&squares[k]));
        terms[0].plus(&terms[1]).plus(&terms[2]).value()
    });
    let det = [0, 1, 2].map(|axis| normals[2][axis].scaled(w[axis]));
    DVec3::from_array(numerator) / (2.0 * det[0].plus(&det[1]).plus(&det[2]).value())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::frame::snap;

    #[test]
    fn flat_tets_have_their_centre_as_far_from_every_corner() {
        // Four corners of a square, one of them lifted by a few units in the last place of the frame's grid.
        let turn = glam::DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        for lift in [1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 0.1] {
            let square = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, lift / 1e-2)];
            let corners = square.map(|p| snap(turn * p * 1e-2));
            let center = circumcenter(corners);
            let radii = corners.map(|p| p.distance(center));
            for r in radii {
                assert!((r - radii[0]).abs() < 1e-12 * radii[0], "{lift}: {radii:?}");
            }
        }
    }
}
