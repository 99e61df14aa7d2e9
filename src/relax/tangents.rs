//! The directions in which seeds may move.
//!
//! A motion, or a gradient, has an entry for each seed in the coordinates of its kind: an interior seed's is a vector, a
//! surface seed's a tangent vector, a curve seed's has the way along the crease in x, a corner's and a knot's are 0.
//!
//! Tangent planes are those of normals interpolated over each smooth patch: normals of the triangles would jump at every
//! edge of the input, and the gradient with them.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::triangle::normal2;
use crate::seeds::Anchor;
use crate::surface::Surface;
use crate::surface::features::Features;

/// Seeds that one thread looks at in a row, and of those on the surface so many at once.
const BLOCK: usize = 512;

const AT_ONCE: usize = 16;

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

    /// The normals at seeds on the surface; 0 for any other.
    pub(super) fn normals(&self, positions: &[DVec3], anchors: &[Anchor]) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; positions.len()];
        let blocks = normals.par_chunks_mut(BLOCK).zip(positions.par_chunks(BLOCK).zip(anchors.par_chunks(BLOCK)));
        blocks.for_each(|(normals, (positions, anchors))| {
            let on_surface: Vec<(usize, u32)> = (anchors.iter().enumerate())
                .filter_map(
                    |(n, anchor)| if let Anchor::Surface { triangle } = *anchor { Some((n, triangle)) } else { None },
                )
                .collect();
            // Memory is waited for many at a time.
            let mut known = [([DVec3::ZERO; 3], [DVec3::ZERO; 3]); AT_ONCE];
            for seeds in on_surface.chunks(AT_ONCE) {
                for (known, &(_, t)) in known.iter_mut().zip(seeds) {
                    *known = (self.surface.corners(t), self.normals[t as usize]);
                }
                for (&(corners, at_corners), &(n, _)) in known.iter().zip(seeds) {
                    normals[n] = interpolated(positions[n], corners, at_corners);
                }
            }
        });
        normals
    }

    /// A force on a seed with this [normal](Tangents::normals), in the coordinates of its kind.
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

/// The normal at a point of a triangle, from those at its corners.
fn interpolated(at: DVec3, [a, b, c]: [DVec3; 3], [at_a, at_b, at_c]: [DVec3; 3]) -> DVec3 {
    let normal = normal2(a, b, c);
    let share = |p: DVec3, q: DVec3| (p - at).cross(q - at).dot(normal).max(0.0);
    let sum = at_a * share(b, c) + at_b * share(c, a) + at_c * share(a, b);
    sum.normalize_or(normal.normalize_or_zero())
}

/// The part of an entry of a motion that a seed with this [normal](Tangents::normals) can follow.
pub(super) fn motion(anchor: Anchor, normal: DVec3, motion: DVec3) -> DVec3 {
    match anchor {
        Anchor::Interior => motion,
        Anchor::Surface { .. } => motion - normal * normal.dot(motion),
        Anchor::Curve { .. } => DVec3::X * motion.x,
        Anchor::Corner { .. } | Anchor::Knot { .. } => DVec3::ZERO,
    }
}
