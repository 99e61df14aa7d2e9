//! Sizes by the curvature of the surface.
//!
//! S. Rusinkiewicz, *Estimating curvatures and their derivatives on triangle meshes*, 3D Data Processing, Visualization and
//! Transmission (3DPVT), 2004, doi 10.1109/TDPVT.2004.1335277.
//!
//! 1. Normals at the corners of triangles: means over the triangles of the same smooth patch, weighted by area, so that a
//!    crease is no curvature.
//! 2. In each triangle, the symmetric tensor that best says how the normal changes along its three edges.
//! 3. Means of the tensors around each vertex, twice: what single triangles of a scan have is noise.
//! 4. The larger of the two principal curvatures, and one over so many times that as the size.
//!
//! Departure: tensors are 3 x 3 matrices of space, so that they can be added without turning frames.
//!
//! Cost: linear in the triangles, and in the sizes that fit on them.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::surface::Surface;
use crate::surface::features::Features;

/// Rounds of step 3.
const ROUNDS: usize = 2;

/// Points on the surface with the sizes that `edges` of them to a radius of curvature give, none below the first of `range`;
/// places that would have more than the second are left out.
pub(super) fn sizes(surface: &Surface, features: &Features, edges: f64, range: [f64; 2]) -> Vec<(DVec3, f64)> {
    let corners = Corners::new(surface, features);
    let mut tensors: Vec<DMat3> =
        (0..surface.triangles().len()).into_par_iter().map(|t| tensor(surface, t, &corners.normals[t])).collect();
    // Of a class of corners: vertices, apart where a crease parts them.
    let mut curvature = Vec::new();
    for _ in 0..ROUNDS {
        let at_class = corners.means(surface, &tensors);
        tensors = corners.of.iter().map(|c| c.iter().map(|&c| at_class[c as usize]).sum::<DMat3>() / 3.0).collect();
        curvature = at_class.iter().map(largest).collect();
    }
    let size = |class: u32| (1.0 / (edges * curvature[class as usize])).clamp(range[0], range[1]);
    (0..surface.triangles().len())
        .into_par_iter()
        .flat_map_iter(|t| spread(surface.corners(t as u32), corners.of[t].map(size), range[1]))
        .collect()
}

/// Points of a triangle as far apart as the sizes there, which are linear between the corners.
fn spread(corners: [DVec3; 3], sizes: [f64; 3], most: f64) -> Vec<(DVec3, f64)> {
    let [a, b, c] = corners;
    let least = sizes.into_iter().fold(f64::INFINITY, f64::min);
    if least >= most {
        return Vec::new();
    }
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let steps = (longest / least).ceil().clamp(1.0, 1000.0) as usize;
    let mut found = Vec::with_capacity((steps + 1) * (steps + 2) / 2);
    for i in 0..=steps {
        for j in 0..=steps - i {
            let (u, v) = (i as f64 / steps as f64, j as f64 / steps as f64);
            let w = [1.0 - u - v, u, v];
            let size = w[0] * sizes[0] + w[1] * sizes[1] + w[2] * sizes[2];
            if size < most {
                found.push((a * w[0] + b * w[1] + c * w[2], size));
            }
        }
    }
    found
}

/// The corners of triangles, in classes of those at the same vertex and of the same patch.
struct Corners {
    /// Class of each corner of each triangle.
    of: Vec<[u32; 3]>,
    classes: usize,
    /// Unit normals at the corners of each triangle.
    normals: Vec<[DVec3; 3]>,
}

impl Corners {
    fn new(surface: &Surface, features: &Features) -> Corners {
        let triangles = surface.triangles();
        let mut corners: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
        for (t, v) in (0..).zip(triangles) {
            corners.extend((0..3).map(|k| (v[k], features.face[t as usize], 3 * t + k as u32)));
        }
        corners.sort_unstable();
        let mut of = vec![[0; 3]; triangles.len()];
        let mut normals = vec![[DVec3::ZERO; 3]; triangles.len()];
        let mut classes = 0;
        for same in corners.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let sum: DVec3 = same.iter().map(|c| surface.normal2(c.2 / 3)).sum();
            for &(_, _, corner) in same {
                let (t, k) = (corner as usize / 3, corner as usize % 3);
                of[t][k] = classes as u32;
                normals[t][k] = sum.normalize_or_zero();
            }
            classes += 1;
        }
        Corners { of, classes, normals }
    }

    /// Means of the triangles' tensors, weighted by their areas, for each class.
    fn means(&self, surface: &Surface, tensors: &[DMat3]) -> Vec<DMat3> {
        let mut sums = vec![(DMat3::ZERO, 0.0); self.classes];
        for (t, corners) in self.of.iter().enumerate() {
            let area = surface.normal2(t as u32).length();
            for &c in corners {
                let (sum, areas) = &mut sums[c as usize];
                *sum += tensors[t] * area;
                *areas += area;
            }
        }
        sums.into_iter().map(|(sum, areas)| if areas > 0.0 { sum * (1.0 / areas) } else { sum }).collect()
    }
}

/// Step 2: the second fundamental form of triangle `t` by least squares, as a matrix of space.
fn tensor(surface: &Surface, t: usize, normals: &[DVec3; 3]) -> DMat3 {
    let p = surface.corners(t as u32);
    let Some(normal) = surface.normal2(t as u32).try_normalize() else { return DMat3::ZERO };
    let Some(u) = (p[1] - p[0]).try_normalize() else { return DMat3::ZERO };
    let v = normal.cross(u);
    // Of the form (e, f; f, g): e x + f y = dn.u and f x + g y = dn.v along each edge (x, y).
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for i in 0..3 {
        let (from, to) = (i, (i + 1) % 3);
        let (edge, change) = (p[to] - p[from], normals[to] - normals[from]);
        let (x, y) = (edge.dot(u), edge.dot(v));
        matrix += DMat3::from_cols(
            DVec3::new(x * x, x * y, 0.0),
            DVec3::new(x * y, x * x + y * y, x * y),
            DVec3::new(0.0, x * y, y * y),
        );
        let (du, dv) = (change.dot(u), change.dot(v));
        right += DVec3::new(x * du, y * du + x * dv, y * dv);
    }
    let Some(inverse) = matrix.try_inverse() else { return DMat3::ZERO };
    let DVec3 { x: e, y: f, z: g } = inverse * right;
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    outer(u, u) * e + (outer(u, v) + outer(v, u)) * f + outer(v, v) * g
}

/// Step 4: the larger principal curvature, of a tensor that is flat along the normal but for rounding and for what means
/// of turned ones have there.
fn largest(tensor: &DMat3) -> f64 {
    let columns = [tensor.x_axis, tensor.y_axis, tensor.z_axis];
    let trace = tensor.x_axis.x + tensor.y_axis.y + tensor.z_axis.z;
    let squares: f64 = columns.iter().map(|c| c.length_squared()).sum();
    0.5 * (trace.abs() + (2.0 * squares - trace * trace).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A torus of radii 1 and 0.25, or a cylinder of radius 0.5 where `flat`.
    fn turned(profile: impl Fn(f64) -> (f64, f64), around: usize, along: usize) -> Surface {
        let mut points = Vec::new();
        for i in 0..around {
            for j in 0..along {
                let (sin, cos) = (i as f64 / around as f64 * std::f64::consts::TAU).sin_cos();
                let (r, z) = profile(j as f64 / along as f64 * std::f64::consts::TAU);
                points.push(DVec3::new(r * cos, r * sin, z));
            }
        }
        let at = |i: usize, j: usize| ((i % around) * along + j % along) as u32;
        let mut triangles = Vec::new();
        for i in 0..around {
            for j in 0..along {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let n = triangles.len();
        Surface::new(&points, &triangles, &(0..n as u32).collect::<Vec<_>>(), &vec![0; n]).expect("a surface")
    }

    #[test]
    fn a_torus_has_the_curvature_of_its_tube() {
        let surface = turned(|a| (1.0 + 0.25 * a.cos(), 0.25 * a.sin()), 96, 32);
        let features = Features::find(&surface, 40.0);
        let found = sizes(&surface, &features, 4.0, [1e-9, 1.0]);
        assert!(found.len() > 2000);
        // Everywhere the tube's curvature is the larger: 4, and so the size 1/16.
        let expected = surface.frame().scale / 16.0;
        for (p, size) in found {
            assert!((size / expected - 1.0).abs() < 0.05, "{p}: {size} for {expected}");
        }
    }
}
