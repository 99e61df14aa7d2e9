//! The surface near a place, from triangle to triangle: faster than a search where a triangle close by is known.

use glam::DVec3;

use super::Surface;
use super::box_tree::Closest;
use super::edges::{EdgeId, triangle_of};
use crate::geometry::triangle;

/// Triangles on the way at most, and around a vertex.
const LONGEST_WAY: usize = 64;
const LARGEST_FAN: usize = 32;

/// The surface, with the triangles beside each.
#[derive(Clone, Copy)]
pub struct Walk<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// For each edge of the triangles, the other one over the same two vertices.
    pub twin: &'a [EdgeId],
}

impl<'a> Walk<'a> {
    /// On `surface`.
    pub fn new(surface: &'a Surface) -> Walk<'a> {
        Walk { surface, twin: surface.twins() }
    }

    /// The point that the surface is closest to `p` at, as far as one gets from triangle `start` by ever closer ones. There may be
    /// closer points behind a rise: the distance is an upper bound.
    pub fn closest_from(&self, start: u32, p: DVec3) -> Closest {
        self.closest_on_way((start, self.surface.corners(start)), p)
    }

    /// The same from a triangle whose corners are known.
    pub fn closest_on_way(&self, (start, corners): (u32, [DVec3; 3]), p: DVec3) -> Closest {
        let mut best = on(start, corners, p);
        for _ in 0..LONGEST_WAY {
            let Some(closer) = self.closer(best, p) else { break };
            best = closer;
        }
        best
    }

    fn on(&self, triangle: u32, p: DVec3) -> Closest {
        on(triangle, self.surface.corners(triangle), p)
    }

    /// A closer point on a triangle next to the one at hand.
    fn closer(&self, best: Closest, p: DVec3) -> Option<Closest> {
        let first = 3 * best.triangle;
        let corners = self.surface.corners(best.triangle);
        let normal = self.surface.normal2(best.triangle);
        let mut closer = best;
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if (b - a).cross(p - a).dot(normal) <= 0.0 {
                let beside = self.on(triangle_of(self.twin[first as usize + k]), p);
                if beside.distance2 < closer.distance2 {
                    closer = beside;
                }
            }
        }
        if closer.triangle == best.triangle
            && let Some(k) = (0..3).find(|&k| corners[k as usize] == best.point)
        {
            closer = self.closest_in_fan(first + k, best, p);
        }
        (closer.triangle != best.triangle).then_some(closer)
    }

    /// The closest point on the triangles around the vertex that edge `start` leaves.
    fn closest_in_fan(&self, start: EdgeId, mut best: Closest, p: DVec3) -> Closest {
        let mut edge = start;
        for _ in 0..LARGEST_FAN {
            // The twin comes to the vertex; the edge after it leaves it.
            let twin = self.twin[edge as usize];
            edge = twin - twin % 3 + (twin + 1) % 3;
            if edge == start {
                break;
            }
            let found = self.on(triangle_of(edge), p);
            if found.distance2 < best.distance2 {
                best = found;
            }
        }
        best
    }
}

/// The closest point of a triangle.
fn on(triangle: u32, corners: [DVec3; 3], p: DVec3) -> Closest {
    let point = triangle::closest_point(corners, p);
    Closest { point, triangle, distance2: point.distance_squared(p) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn on_a_convex_surface_the_way_leads_to_the_closest_point() {
        // A flat box: edges, corners and fans are all on the way.
        let at = |i: u32, k: u32| f64::from(i >> k & 1);
        let points: Vec<DVec3> = (0..8).map(|i| DVec3::new(at(i, 0), at(i, 1), 0.2 * at(i, 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let each: Vec<u32> = (0..12).collect();
        let surface = Surface::new(&points, &triangles, &each, &each).expect("a closed surface");
        let walk = Walk::new(&surface);
        let mut rng = Rng::new(2, 9);
        for _ in 0..500 {
            let p = rng.in_cube() * 3.0;
            if surface.is_inside(p) {
                continue;
            }
            let expected = surface.tree().closest(p);
            // On the far side the point opposite looks closest too.
            let faces = |&t: &u32| (p - surface.corners(t)[0]).dot(surface.normal2(t)) > 0.0;
            for start in (0..12).filter(faces) {
                let found = walk.closest_from(start, p);
                assert!((found.distance2 - expected.distance2).abs() < 1e-14, "{p} from {start}: {found:?}");
            }
        }
    }
}
