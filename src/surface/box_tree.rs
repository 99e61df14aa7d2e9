//! A box tree over triangles: inside test, closest point, triangles near a box.

use glam::DVec3;

/// The point of the surface closest to a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The point.
    pub point: DVec3,
    /// The triangle that it lies on.
    pub triangle: u32,
    /// Its squared distance to the query.
    pub distance2: f64,
}

/// A box tree over the triangles of a closed surface.
pub struct BoxTree {}

impl BoxTree {
    /// Builds the tree; every index of `triangles` is below the number of `points`.
    pub fn build(_points: &[DVec3], _triangles: &[[u32; 3]]) -> BoxTree {
        todo!()
    }

    /// Whether `p` is inside, by the parity of exact crossings of a ray.
    pub fn is_inside(&self, _p: DVec3) -> bool {
        todo!()
    }

    /// The closest point of the surface; the lowest triangle index where several are equally close.
    pub fn closest(&self, _p: DVec3) -> Closest {
        todo!()
    }

    /// Calls `visit` with every triangle whose box meets the box from `min` to `max`, in no particular order.
    pub fn near_box(&self, _min: DVec3, _max: DVec3, _visit: impl FnMut(u32)) {
        todo!()
    }

    /// The nearest triangle that the ray from `origin` along `direction` crosses, and how far along it in multiples
    /// of `direction`; none within `limit`.
    pub fn ray(&self, _origin: DVec3, _direction: DVec3, _limit: f64) -> Option<(f64, u32)> {
        todo!()
    }
}
