//! The surface, prepared for being cut up many times.

use glam::DVec3;

use super::Density;
use super::net::Net;
use crate::geometry::hilbert::hilbert_order;
use crate::geometry::triangle::normal2;
use crate::surface::Surface;

/// What does not change from one set of seeds to the next.
///
/// Triangles and vertices have numbers of their own here, near where they are near in space: along a Hilbert curve, as seeds
/// are.
pub(super) struct Sheet<'a> {
    pub(super) surface: &'a Surface,
    /// For each triangle, which one of the surface it is.
    order: Vec<u32>,
    /// The corners of each.
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each vertex, which one of the surface it is.
    vertices: Vec<u32>,
    /// Where each is.
    pub(super) points: Vec<DVec3>,
    /// How these hang together.
    pub(super) net: Net,
    /// The density of the surface.
    density: OnVertices,
    /// The density of the solid, on its surface; by the surface's own numbers.
    solid: OnVertices,
}

/// A triangle of the surface, relative to the seed of the cell.
#[derive(Clone, Copy)]
pub(super) struct Face {
    pub(super) corners: [DVec3; 3],
    /// Vertices of the surface: the ends of an edge are taken in the order of these, the same for both triangles at it.
    pub(super) ids: [u32; 3],
    /// Its normal, twice the area long.
    pub(super) normal2: DVec3,
    pub(super) density: Linear,
    /// The density of the solid, where that is not even.
    pub(super) solid: Option<Linear>,
}

impl Face {
    /// Its unit normal; zero where it has none.
    pub(super) fn normal(&self) -> DVec3 {
        self.normal2.normalize_or_zero()
    }

    /// The density of the solid at a point of the triangle.
    pub(super) fn solid_at(&self, p: DVec3) -> f64 {
        self.solid.map_or(1.0, |solid| solid.at(p))
    }
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
        let count = surface.triangles().len() as u32;
        let middles: Vec<DVec3> = (0..count).map(|t| surface.corners(t).iter().sum::<DVec3>() / 3.0).collect();
        let order = hilbert_order(&middles);
        // Vertices as triangles come to them.
        let (mut numbers, mut vertices) = (vec![u32::MAX; surface.points().len()], Vec::new());
        let mut number = |v: u32| {
            let number = &mut numbers[v as usize];
            if *number == u32::MAX {
                *number = vertices.len() as u32;
                vertices.push(v);
            }
            *number
        };
        let triangles: Vec<[u32; 3]> =
            order.iter().map(|&t| surface.triangles()[t as usize].map(&mut number)).collect();
        let points: Vec<DVec3> = vertices.iter().map(|&v| surface.points()[v as usize]).collect();
        let net = Net::new(&triangles);
        let (density, solid) = (OnVertices::default(), OnVertices::default());
        Sheet { surface, order, triangles, vertices, points, net, density, solid }
    }

    /// From now on weighs the surface by `density`.
    pub(super) fn set_density(&mut self, density: Density) {
        self.density = match density {
            Density::Uniform => OnVertices::default(),
            Density::Vertices(at) => {
                let at = self.vertices.iter().map(|&v| at[v as usize]).collect();
                OnVertices::new(&self.triangles, &self.points, at)
            }
        };
    }

    /// From now on weighs the solid by a density that has these values at the surface's vertices.
    pub(super) fn set_solid(&mut self, at: Vec<f64>) {
        self.solid = OnVertices::new(self.surface.triangles(), self.surface.points(), at);
    }

    /// Which triangle of the surface triangle `t` is.
    #[inline]
    pub(super) fn of_surface(&self, t: u32) -> u32 {
        self.order[t as usize]
    }

    /// Whether triangle `t` is an interface.
    #[inline]
    pub(super) fn is_interface(&self, t: u32) -> bool {
        self.surface.has_interfaces() && self.surface.is_interface(self.of_surface(t))
    }

    /// Where the corners of triangle `t` are.
    #[inline]
    pub(super) fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.points[v as usize])
    }

    /// The density of the surface on triangle `t`, for points relative to the same as its first corner `from`.
    #[inline]
    pub(super) fn density_on(&self, t: u32, from: DVec3) -> Linear {
        self.density.on(t, self.triangles[t as usize], from)
    }

    /// The density of the surface at the corners of triangle `t`.
    #[inline]
    pub(super) fn densities(&self, t: u32) -> [f64; 3] {
        self.density.at_vertices(self.triangles[t as usize])
    }

    /// Triangle `t` with its corners relative to a seed.
    #[inline]
    pub(super) fn face(&self, t: u32, corners: [DVec3; 3]) -> Face {
        let ids = self.triangles[t as usize];
        let density = self.density_on(t, corners[0]);
        let solid = (!self.solid.at.is_empty()).then(|| {
            let t = self.of_surface(t);
            self.solid.on(t, self.surface.triangles()[t as usize], corners[0])
        });
        Face { corners, ids, normal2: normal2(corners[0], corners[1], corners[2]), density, solid }
    }

    /// The density of the solid at a point of triangle `t` of the surface.
    pub(super) fn solid_at(&self, t: u32, p: DVec3) -> f64 {
        let ids = self.surface.triangles()[t as usize];
        self.solid.on(t, ids, self.surface.points()[ids[0] as usize]).at(p)
    }
}

impl OnVertices {
    fn new(triangles: &[[u32; 3]], points: &[DVec3], at: Vec<f64>) -> OnVertices {
        let gradient = |ids: &[u32; 3]| {
            let [a, b, c] = ids.map(|v| points[v as usize]);
            let [at_a, at_b, at_c] = ids.map(|v| at[v as usize]);
            let normal = normal2(a, b, c);
            let rise = (c - a).cross(normal) * (at_b - at_a) + normal.cross(b - a) * (at_c - at_a);
            rise / normal.length_squared()
        };
        let gradients = triangles.iter().map(gradient).collect();
        OnVertices { at, gradients }
    }

    /// At some vertices.
    #[inline]
    fn at_vertices(&self, ids: [u32; 3]) -> [f64; 3] {
        if self.at.is_empty() { [1.0; 3] } else { ids.map(|v| self.at[v as usize]) }
    }

    /// On triangle `t` with corners `ids`, for points relative to what its first corner `from` is relative to.
    #[inline]
    fn on(&self, t: u32, ids: [u32; 3], from: DVec3) -> Linear {
        let [a, b, c] = self.at_vertices(ids);
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
