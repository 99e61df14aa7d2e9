//! The directions in which seeds may move.
//!
//! A motion, or a gradient, has an entry for each seed in the coordinates of its kind: an interior seed's is a vector, a
//! surface seed's a tangent vector, a curve seed's has the way along the crease in x, a corner's and a knot's are 0.
//!
//! Tangent planes are those of normals interpolated over each smooth patch: normals of the triangles would jump at every
//! edge of the input, and the gradient with them.

use glam::DVec3;

use crate::seeds::Anchor;
use crate::surface::Surface;
use crate::surface::features::Features;

/// Tangents of a surface and of its creases.
pub(super) struct Tangents<'a> {
    surface: &'a Surface,
    features: &'a Features,
    /// Unit normals at the three corners of each triangle.
    normals: Vec<[DVec3; 3]>,
}

impl<'a> Tangents<'a> {
    /// Normals at corners: the mean over the triangles of the same patch at the vertex, weighted by their areas.
    pub(super) fn new(surface: &'a Surface, features: &'a Features) -> Tangents<'a> {
        let triangles = surface.triangles();
        let mut corners: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
        for (t, v) in (0..).zip(triangles) {
            corners.extend((0..3).map(|k| (v[k], features.face[t as usize], 3 * t + k as u32)));
        }
        corners.sort_unstable();
        let mut normals = vec![[DVec3::ZERO; 3]; triangles.len()];
        for same in corners.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let sum: DVec3 = same.iter().map(|c| surface.normal2(c.2 / 3)).sum();
            for &(_, _, corner) in same {
                let own = surface.normal2(corner / 3).normalize_or_zero();
                normals[corner as usize / 3][corner as usize % 3] = sum.normalize_or(own);
            }
        }
        Tangents { surface, features, normals }
    }

    /// The normal at a point of triangle `t`.
    fn normal(&self, at: DVec3, t: u32) -> DVec3 {
        let [a, b, c] = self.surface.triangles()[t as usize].map(|v| self.surface.points()[v as usize]);
        let normal = self.surface.normal2(t);
        let share = |p: DVec3, q: DVec3| (p - at).cross(q - at).dot(normal).max(0.0);
        let [na, nb, nc] = self.normals[t as usize];
        (na * share(b, c) + nb * share(c, a) + nc * share(a, b)).normalize_or(normal.normalize_or_zero())
    }

    /// The normal at a seed on the surface; 0 for any other.
    pub(super) fn normal_of(&self, at: DVec3, anchor: Anchor) -> DVec3 {
        match anchor {
            Anchor::Surface { triangle } => self.normal(at, triangle),
            _ => DVec3::ZERO,
        }
    }

    /// A force on a seed with this [normal](Tangents::normal_of), in the coordinates of its kind.
    pub(super) fn force(&self, anchor: Anchor, normal: DVec3, force: DVec3) -> DVec3 {
        match anchor {
            Anchor::Curve { curve, at } => {
                DVec3::X * self.features.curves[curve as usize].tangent_at(at, self.surface.points()).dot(force)
            }
            other => motion(other, normal, force),
        }
    }

    /// The point of a crease at an arc length.
    pub(super) fn on_crease(&self, curve: u32, at: f64) -> DVec3 {
        self.features.curves[curve as usize].point_at(at, self.surface.points())
    }

    /// The motion that led from one place to another, with this normal there; none between places of different kinds.
    pub(super) fn between(&self, from: (DVec3, Anchor), to: (DVec3, Anchor), normal: DVec3) -> Option<DVec3> {
        match (from.1, to.1) {
            (Anchor::Interior, Anchor::Interior) | (Anchor::Surface { .. }, Anchor::Surface { .. }) => {
                Some(motion(to.1, normal, to.0 - from.0))
            }
            (Anchor::Curve { curve: a, at: before }, Anchor::Curve { curve: b, at: after }) if a == b => {
                let curve = &self.features.curves[a as usize];
                let (way, length) = (after - before, curve.length());
                // Around a loop, the short way.
                Some(DVec3::X * if curve.is_closed() { way - length * (way / length).round() } else { way })
            }
            (Anchor::Corner { .. }, Anchor::Corner { .. }) | (Anchor::Knot { .. }, Anchor::Knot { .. }) => {
                Some(DVec3::ZERO)
            }
            _ => None,
        }
    }
}

/// The part of an entry of a motion that a seed with this [normal](Tangents::normal_of) can follow.
pub(super) fn motion(anchor: Anchor, normal: DVec3, motion: DVec3) -> DVec3 {
    match anchor {
        Anchor::Interior => motion,
        Anchor::Surface { .. } => motion - normal * normal.dot(motion),
        Anchor::Curve { .. } => DVec3::X * motion.x,
        Anchor::Corner { .. } | Anchor::Knot { .. } => DVec3::ZERO,
    }
}
