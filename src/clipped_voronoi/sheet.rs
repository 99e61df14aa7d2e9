//! The surface, prepared for being cut up many times.

use glam::DVec3;

use super::Density;
use super::slices::Face;
use crate::geometry::triangle::normal2;
use crate::surface::Surface;

/// What does not change from one set of seeds to the next.
pub(super) struct Sheet<'a> {
    pub(super) surface: &'a Surface,
    /// Unit normals of the triangles.
    normals: Vec<DVec3>,
    density: Density,
    /// For each triangle the gradient of its density within its plane; none where the density is even.
    gradients: Vec<DVec3>,
}

impl<'a> Sheet<'a> {
    /// For `surface`, with an even density.
    pub(super) fn new(surface: &'a Surface) -> Sheet<'a> {
        let unit = |t: usize| surface.normal2(t as u32).normalize_or_zero();
        let normals = (0..surface.triangles().len()).map(unit).collect();
        Sheet { surface, normals, density: Density::Uniform, gradients: Vec::new() }
    }

    /// From now on weighs the surface by `density`.
    pub(super) fn set_density(&mut self, density: Density) {
        self.gradients.clear();
        if let Density::Vertices(at) = &density {
            self.gradients.extend(self.surface.triangles().iter().map(|ids| {
                let [a, b, c] = ids.map(|v| self.surface.points()[v as usize]);
                let [at_a, at_b, at_c] = ids.map(|v| at[v as usize]);
                let normal = normal2(a, b, c);
                let rise = (c - a).cross(normal) * (at_b - at_a) + normal.cross(b - a) * (at_c - at_a);
                rise / normal.length_squared()
            }));
        }
        self.density = density;
    }

    /// Triangle `t`, whose corners are `at`, relative to `origin`.
    pub(super) fn face(&self, t: u32, at: [DVec3; 3], origin: DVec3) -> Face {
        let (corners, ids) = (at.map(|p| p - origin), self.surface.triangles()[t as usize]);
        Face { corners, ids, normal: self.normals[t as usize], density: self.density(t, ids, corners[0]) }
    }

    /// The density on triangle `t`, for points relative to what its first corner `from` is relative to.
    fn density(&self, t: u32, ids: [u32; 3], from: DVec3) -> Linear {
        let Density::Vertices(at) = &self.density else { return Linear::EVEN };
        let [a, b, c] = ids.map(|v| at[v as usize]);
        Linear { base: a, from, gradient: self.gradients[t as usize], range: [a.min(b).min(c), a.max(b).max(c)] }
    }
}

/// A function on a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear {
    pub(super) base: f64,
    pub(super) from: DVec3,
    pub(super) gradient: DVec3,
    pub(super) range: [f64; 2],
}

impl Linear {
    /// 1 everywhere.
    const EVEN: Linear = Linear { base: 1.0, from: DVec3::ZERO, gradient: DVec3::ZERO, range: [1.0; 2] };

    /// Whether it has the same value everywhere.
    pub(super) fn constant(&self) -> Option<f64> {
        (self.range[0] == self.range[1]).then_some(self.base)
    }

    /// Its value at a point; what rounding adds is taken off again, in thin triangles too.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        (self.base + self.gradient.dot(p - self.from)).clamp(self.range[0], self.range[1])
    }
}
