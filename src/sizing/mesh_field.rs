//! Sizes by numbers on the points of a mesh of tets.

use glam::DVec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;

use super::refused;
use crate::error::Error;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::tetrahedron::FACETS;
use crate::geometry::triangle;
use crate::surface::Surface;

/// The mesh must come this close to every vertex of the surface, over the diagonal.
const COVERED: f64 = 0.05;

/// A mesh of tets with a size on each point, in the units of the model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SizeMesh {
    /// Points.
    pub points: Vec<DVec3>,
    /// Tets, of any orientation.
    pub tets: Vec<[u32; 4]>,
    /// A size for each point.
    pub sizes: Vec<f64>,
}

impl SizeMesh {
    /// Refuses what is no field of sizes.
    ///
    /// # Errors
    /// What is wrong, for a user.
    pub fn check(&self) -> Result<(), String> {
        if self.tets.is_empty() {
            return Err("it has no tets".to_owned());
        }
        if self.sizes.len() != self.points.len() {
            return Err(format!("it has {} points, but {} sizes", self.points.len(), self.sizes.len()));
        }
        if let Some(t) = self.tets.iter().position(|t| t.iter().any(|&v| v as usize >= self.points.len())) {
            return Err(format!("tet {t} refers to a point that there is not"));
        }
        if let Some(i) = self.points.iter().position(|p| !p.is_finite()) {
            return Err(format!("point {i} is not finite"));
        }
        match self
            .tets
            .iter()
            .flatten()
            .find(|&&v| !(self.sizes[v as usize] > 0.0 && self.sizes[v as usize].is_finite()))
        {
            Some(&v) => Err(format!("the size of point {v} is {}, not a positive number", self.sizes[v as usize])),
            None => Ok(()),
        }
    }

    /// Prepares for finding tets around points of the frame of `surface`.
    pub(super) fn located(&self, surface: &Surface) -> Result<Located<'_>, Error> {
        self.check().map_err(|reason| refused("size-field", reason))?;
        let frame = surface.frame();
        let points: Vec<DVec3> = self.points.iter().map(|&p| (p - frame.shift) * frame.scale).collect();
        let located = Located::new(self, points);
        let reach = COVERED * surface.diagonal();
        let stray = |&&p: &&DVec3| located.nearest(p).1 > reach * reach;
        if let Some(&p) = surface.points().iter().find(stray) {
            let [x, y, z] = frame.to_model(p).to_array();
            let reason =
                format!("its mesh does not cover the surface: ({x}, {y}, {z}) is far from every tet that has a size");
            return Err(refused("size-field", reason));
        }
        Ok(located)
    }
}

/// Tets that can be found by places, all in the frame.
pub(super) struct Located<'a> {
    mesh: &'a SizeMesh,
    points: Vec<DVec3>,
    nodes: Vec<Node>,
    /// Tets in the order of the leaves.
    order: Vec<u32>,
    /// What lies far outside the frame is brought to its border: the boxes are in single precision.
    bounds: BoundingBox,
}

struct Node {
    bounds: BoundingBox,
    first: u32,
    count: u32,
}

impl<'a> Located<'a> {
    fn new(mesh: &'a SizeMesh, points: Vec<DVec3>) -> Located<'a> {
        let boxes: Vec<Aabb> = mesh
            .tets
            .iter()
            .map(|tet| {
                let b = BoundingBox::of(tet.map(|v| points[v as usize]).iter());
                Aabb::new(b.min.as_vec3a(), b.max.as_vec3a())
            })
            .collect();
        let mut seconds = std::time::Duration::ZERO;
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut seconds);
        // Padded by more than the rounding to single precision.
        let padded = |b: &Aabb| {
            let (min, max) = (b.min.as_dvec3(), b.max.as_dvec3());
            let pad = 1e-6 * (1.0 + min.abs().max_element().max(max.abs().max_element()));
            BoundingBox { min: min - pad, max: max + pad }
        };
        let node = |n: &obvhs::bvh2::node::Bvh2Node| Node {
            bounds: padded(n.aabb()),
            first: n.first_index,
            count: n.prim_count,
        };
        let nodes: Vec<Node> = tree.nodes.iter().map(node).collect();
        let bounds = nodes[0].bounds;
        Located { mesh, points, nodes, order: tree.primitive_indices, bounds }
    }

    /// The size at `p`, in the units of the model.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        let (place, _, t) = self.nearest(p);
        let tet = self.mesh.tets[t as usize];
        let [a, b, c, d] = tet.map(|v| self.points[v as usize]);
        let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
        let weights = [volume(place, b, c, d), volume(a, place, c, d), volume(a, b, place, d), volume(a, b, c, place)];
        let whole: f64 = weights.iter().sum();
        let sizes = tet.map(|v| self.mesh.sizes[v as usize]);
        let (least, most) = sizes.iter().fold((f64::INFINITY, 0.0f64), |(l, m), &s| (l.min(s), m.max(s)));
        let linear: f64 = weights.iter().zip(sizes).map(|(w, s)| w * s).sum::<f64>() / whole;
        // A flat tet has no weights: any of its sizes will do.
        if linear.is_finite() { linear.clamp(least, most) } else { least }
    }

    /// The closest point of the mesh, its squared distance, and its tet; the least of several.
    fn nearest(&self, p: DVec3) -> (DVec3, f64, u32) {
        let mut best = (p, f64::INFINITY, u32::MAX);
        let mut stack = vec![(distance2(&self.bounds, p), 0)];
        while let Some((distance, node)) = stack.pop() {
            if distance > best.1 {
                continue;
            }
            let node = &self.nodes[node as usize];
            if node.count == 0 {
                let children = [node.first, node.first + 1].map(|n| (distance2(&self.nodes[n as usize].bounds, p), n));
                let [near, far] = if children[0].0 <= children[1].0 { children } else { [children[1], children[0]] };
                stack.extend([far, near]);
                continue;
            }
            for k in node.first..node.first + node.count {
                let t = self.order[k as usize];
                let place = closest_in_tet(self.mesh.tets[t as usize].map(|v| self.points[v as usize]), p);
                let distance = place.distance_squared(p);
                if distance < best.1 || distance == best.1 && t < best.2 {
                    best = (place, distance, t);
                }
            }
        }
        best
    }
}

fn distance2(b: &BoundingBox, p: DVec3) -> f64 {
    (p.clamp(b.min, b.max) - p).length_squared()
}

/// The point of a tet of any orientation closest to `p`.
fn closest_in_tet(corners: [DVec3; 4], p: DVec3) -> DVec3 {
    let center = (corners[0] + corners[1] + corners[2] + corners[3]) * 0.25;
    let sides = FACETS.map(|f| {
        let [a, b, c] = f.map(|k| corners[k]);
        let normal = triangle::normal2(a, b, c);
        normal.dot(p - a) * normal.dot(center - a)
    });
    if sides.iter().all(|&s| s >= 0.0) && sides.iter().any(|&s| s > 0.0) {
        return p;
    }
    let places = FACETS.map(|f| triangle::closest_point(f.map(|k| corners[k]), p));
    places.into_iter().reduce(|a, b| if b.distance_squared(p) < a.distance_squared(p) { b } else { a }).unwrap_or(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_linear_within_and_those_of_the_nearest_point_outside() {
        let corners: Vec<DVec3> =
            (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64) - 0.5).collect();
        // Six tets around the diagonal, of either orientation.
        let tets = vec![[0, 7, 1, 3], [0, 7, 3, 2], [0, 7, 2, 6], [0, 7, 6, 4], [0, 7, 5, 4], [0, 7, 1, 5]];
        let linear = |p: DVec3| 2.0 + p.dot(DVec3::new(0.5, -0.25, 1.0));
        let sizes = corners.iter().map(|&p| linear(p)).collect();
        let mesh = SizeMesh { points: corners.clone(), tets, sizes };
        let located = Located::new(&mesh, corners);
        let mut rng = crate::rng::Rng::new(1, 1);
        for _ in 0..200 {
            let p = rng.in_cube();
            let nearest = p.clamp(DVec3::splat(-0.5), DVec3::splat(0.5));
            assert!((located.at(p) - linear(nearest)).abs() < 1e-12, "{p}");
        }
    }
}
