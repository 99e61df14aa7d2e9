//! The surface, prepared for being cut up many times.

use glam::DVec3;

use super::Density;
use super::slices::Face;
use crate::geometry::hilbert::hilbert_order;
use crate::geometry::triangle::normal2;
use crate::surface::Surface;

/// What does not change from one set of seeds to the next.
pub(super) struct Sheet<'a> {
    pub(super) surface: &'a Surface,
    /// All that is asked of each triangle, near in memory where it is near in space: along a Hilbert curve, as seeds are.
    panels: Vec<Panel>,
    /// For each triangle, where.
    place: Vec<u32>,
    /// The density of the surface.
    density: OnVertices,
    /// The density of the solid, on its surface.
    solid: OnVertices,
}

/// A triangle.
#[derive(Clone, Copy)]
pub(super) struct Panel {
    pub(super) corners: [DVec3; 3],
    /// Its unit normal.
    normal: DVec3,
    /// The density of the surface at the corners.
    density: [f64; 3],
    /// Vertices of the surface.
    pub(super) ids: [u32; 3],
}

/// A function on the surface, linear on each triangle.
#[derive(Default)]
struct OnVertices {
    /// At each vertex; empty where it is 1 everywhere.
    at: Vec<f64>,
    /// For each triangle its gradient within the plane.
    gradients: Vec<DVec3>,
}

impl<'a> Sheet<'a> {
    /// For `surface`, with an even density.
    pub(super) fn new(surface: &'a Surface) -> Sheet<'a> {
        let panel = |&t: &u32| Panel {
            corners: surface.corners(t),
            normal: surface.normal2(t).normalize_or_zero(),
            density: [1.0; 3],
            ids: surface.triangles()[t as usize],
        };
        let count = surface.triangles().len();
        let middles: Vec<DVec3> = (0..count as u32).map(|t| surface.corners(t).iter().sum::<DVec3>() / 3.0).collect();
        let order = hilbert_order(&middles);
        let mut place = vec![0; count];
        (0..).zip(&order).for_each(|(k, &t)| place[t as usize] = k);
        let panels = order.iter().map(panel).collect();
        Sheet { surface, panels, place, density: OnVertices::default(), solid: OnVertices::default() }
    }

    /// From now on weighs the surface by `density`.
    pub(super) fn set_density(&mut self, density: Density) {
        self.density = match density {
            Density::Uniform => OnVertices::default(),
            Density::Vertices(at) => OnVertices::new(self.surface, at),
        };
        for panel in &mut self.panels {
            panel.density = self.density.at_vertices(panel.ids);
        }
    }

    /// From now on weighs the solid by a density that has these values at the surface's vertices.
    pub(super) fn set_solid(&mut self, at: Vec<f64>) {
        self.solid = OnVertices::new(self.surface, at);
    }

    /// Triangle `t`.
    #[inline]
    pub(super) fn panel(&self, t: u32) -> &Panel {
        &self.panels[self.place[t as usize] as usize]
    }

    /// Triangle `t` relative to `origin`.
    #[inline]
    pub(super) fn face(&self, t: u32, panel: &Panel, origin: DVec3) -> Face {
        let corners = panel.corners.map(|p| p - origin);
        let density = self.density.on(t, panel.density, corners[0]);
        let solid =
            (!self.solid.at.is_empty()).then(|| self.solid.on(t, self.solid.at_vertices(panel.ids), corners[0]));
        Face { corners, ids: panel.ids, normal: panel.normal, density, solid }
    }

    /// The density of the solid at a point of triangle `t`.
    pub(super) fn solid_at(&self, t: u32, p: DVec3) -> f64 {
        let ids = self.surface.triangles()[t as usize];
        self.solid.on(t, self.solid.at_vertices(ids), self.surface.points()[ids[0] as usize]).at(p)
    }
}

impl OnVertices {
    fn new(surface: &Surface, at: Vec<f64>) -> OnVertices {
        let gradient = |ids: &[u32; 3]| {
            let [a, b, c] = ids.map(|v| surface.points()[v as usize]);
            let [at_a, at_b, at_c] = ids.map(|v| at[v as usize]);
            let normal = normal2(a, b, c);
            let rise = (c - a).cross(normal) * (at_b - at_a) + normal.cross(b - a) * (at_c - at_a);
            rise / normal.length_squared()
        };
        let gradients = surface.triangles().iter().map(gradient).collect();
        OnVertices { at, gradients }
    }

    /// At some vertices.
    #[inline]
    fn at_vertices(&self, ids: [u32; 3]) -> [f64; 3] {
        if self.at.is_empty() { [1.0; 3] } else { ids.map(|v| self.at[v as usize]) }
    }

    /// On triangle `t`, at whose corners it has such values, for points relative to what its first corner `from` is
    /// relative to.
    #[inline]
    fn on(&self, t: u32, [a, b, c]: [f64; 3], from: DVec3) -> Linear {
        if a == b && b == c {
            return Linear { base: a, from: DVec3::ZERO, gradient: DVec3::ZERO, range: [a; 2] };
        }
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
    /// Whether it has the same value everywhere.
    pub(super) fn constant(&self) -> Option<f64> {
        (self.range[0] == self.range[1]).then_some(self.base)
    }

    /// Its value at a point; what rounding adds is taken off again, in thin triangles too.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        (self.base + self.gradient.dot(p - self.from)).clamp(self.range[0], self.range[1])
    }
}
