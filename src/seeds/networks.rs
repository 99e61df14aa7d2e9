//! Networks of creases: which are of the solid's design, and which are noise.
//!
//! The dihedral angle alone does not tell a part's edge from the wrinkle of a scan. Wrinkles are short and end loose; edges
//! of a design run into each other or close up, or are few among many that do. The mesh has the latter whole, however fine
//! they are; of the former it follows what the spacing resolves.

use super::curves::{crowded, steps};
use super::grid::{CellGrid, typical};
use crate::disjoint_sets::DisjointSets;
use crate::surface::Surface;
use crate::surface::features::{Curve, Features};

/// Networks shorter than so many spacings in all are below the resolution of the mesh: on a scanned surface they are noise,
/// and their corners, fixed and far closer than the spacing, would spoil the mesh around them.
const RESOLVED: f64 = 2.0;

/// Networks with a loose end are noise up to so many spacings.
const LOOSE: f64 = 8.0;

/// Among much noise a network is of the design if it has no loose end and is so many spacings long: wrinkles may close up too.
const CLEAR: f64 = 16.0;

/// Where no more than this share of all creases is noise or below the resolution, and no more than that share ends loose, the
/// creases are designed, and all are kept whole. On organic shapes, whose folds run out, half of the creases end loose.
const DETAILS: f64 = 0.15;
const LOOSE_ENDS: f64 = 0.3;

/// But networks shorter than so many spacings.
pub(super) const LEAST_DETAIL: f64 = 0.25;

/// What is known of a network.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Network {
    /// In spacings.
    length: f64,
    /// Whether a crease of it ends where no other begins.
    is_loose: bool,
    is_given: bool,
    /// Whether it is kept at all.
    pub(super) kept: bool,
    /// Whether it is of the design.
    pub(super) whole: bool,
}

/// All networks: creases joined at their ends.
pub(super) struct Networks {
    /// For each vertex of the surface the vertex that its network is named after, and by that the network.
    root: Vec<u32>,
    all: Vec<Network>,
    /// For each vertex, the creases that end there; a loop without a corner ends twice at its first.
    ends_at: Vec<u32>,
}

/// The first and the last vertex of a crease, the lesser first.
pub(super) fn ends(c: &Curve) -> (u32, u32) {
    let (a, b) = (c.vertices[0], c.vertices[c.vertices.len() - 1]);
    (a.min(b), a.max(b))
}

impl Networks {
    /// The networks of `features`, where the spacing at a vertex is about `spacing`.
    pub(super) fn of(surface: &Surface, features: &Features, has_room: bool, spacing: impl Fn(u32) -> f64) -> Networks {
        let vertices = surface.points().len();
        let mut joined = DisjointSets::new(vertices);
        let mut ends_at = vec![0u32; vertices];
        for c in &features.curves {
            let (a, b) = ends(c);
            joined.join(a, b);
            ends_at[a as usize] += 1;
            ends_at[b as usize] += 1;
        }
        let root: Vec<u32> = (0..vertices as u32).map(|v| joined.find(v)).collect();
        let mut all = vec![Network::default(); vertices];
        let ends_loose = |c: &Curve| {
            let (a, b) = ends(c);
            ends_at[a as usize] == 1 || ends_at[b as usize] == 1
        };
        for c in &features.curves {
            let network = &mut all[root[c.vertices[0] as usize] as usize];
            network.length += steps(c, &spacing);
            network.is_loose |= ends_loose(c);
            network.is_given |= c.is_given;
        }
        let is_noise = |n: &Network| n.length < if n.is_loose { LOOSE } else { RESOLVED };
        // What the user asked for is kept in any case, and says nothing of the rest.
        let noise: f64 = all.iter().filter(|n| !n.is_given && is_noise(n)).map(|n| n.length).sum();
        let own = || features.curves.iter().filter(|c| !c.is_given);
        let length: f64 = own().map(|c| steps(c, &spacing)).sum();
        let loose: f64 = own().filter(|c| ends_loose(c)).map(|c| steps(c, &spacing)).sum();
        let designed = has_room && noise <= DETAILS * length && loose <= LOOSE_ENDS * length;
        let least = if designed { LEAST_DETAIL } else { RESOLVED };
        for n in &mut all {
            n.kept = n.is_given || n.length >= least;
            let is_clear = designed || (!n.is_loose && n.length >= CLEAR);
            n.whole = n.kept && (has_room || n.is_given) && is_clear;
        }
        Networks { root, all, ends_at }
    }

    /// The network at a vertex.
    pub(super) fn at(&self, v: u32) -> Network {
        self.all[self.root[v as usize] as usize]
    }

    /// The corners that are kept: those of networks that are, and tips of cones; but for those that crowd another, of which the
    /// one where three creases or more meet comes first, then tips and the lower index.
    pub(super) fn corners(&self, surface: &Surface, features: &Features, spacing: impl Fn(u32) -> f64) -> Vec<u32> {
        let ends_at = |v: u32| self.ends_at[v as usize];
        let rank = |v: u32| match ends_at(v) {
            3.. => 0,
            0 => 1,
            _ => 2,
        };
        let mut corners: Vec<u32> =
            features.corners.iter().copied().filter(|&v| ends_at(v) == 0 || self.at(v).kept).collect();
        corners.sort_by_key(|&v| (rank(v), v));
        let positions: Vec<_> = corners.iter().map(|&v| surface.points()[v as usize]).collect();
        let reach: Vec<f64> = corners.iter().map(|&v| crowded(self.at(v).whole) * spacing(v)).collect();
        let grid = CellGrid::new(&positions, 2.0 * typical(&reach));
        let mut stays = vec![true; corners.len()];
        for i in 0..corners.len() {
            let mut crowded = false;
            grid.near(positions[i], reach[i], |j| {
                let j = j as usize;
                crowded |= j < i && stays[j] && positions[i].distance(positions[j]) < reach[i];
            });
            stays[i] = !crowded;
        }
        let mut kept: Vec<u32> = corners.iter().zip(&stays).filter(|(_, s)| **s).map(|(&v, _)| v).collect();
        kept.sort_unstable();
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A crease over these vertices, of such a length in spacings of 1.
    fn crease(vertices: Vec<u32>, length: f64) -> Curve {
        let last = (vertices.len() - 1) as f64;
        let arc = (0..vertices.len()).map(|i| length * i as f64 / last).collect();
        Curve { vertices, arc, is_given: false }
    }

    /// For each crease, whether it is kept, and whole.
    fn networks(curves: Vec<Curve>) -> Vec<(bool, bool)> {
        // A fan over a regular polygon, from both sides: all that matters of it is that it has vertices enough.
        let count = 40;
        let rim = (0..count).map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(count)).sin_cos();
            DVec3::new(cos, sin, 0.0)
        });
        let points: Vec<DVec3> = rim.chain([DVec3::Z, -DVec3::Z]).collect();
        let next = |i: u32| (i + 1) % count;
        let triangles: Vec<[u32; 3]> =
            (0..count).flat_map(|i| [[i, next(i), count], [next(i), i, count + 1]]).collect();
        let each: Vec<u32> = (0..triangles.len() as u32).collect();
        let surface = Surface::new(&points, &triangles, &each, &each).expect("a closed surface");
        let features = Features { corners: Vec::new(), curves, face: Vec::new() };
        let networks = Networks::of(&surface, &features, true, |_| 1.0);
        let of = |c: &Curve| (networks.at(c.vertices[0]).kept, networks.at(c.vertices[0]).whole);
        features.curves.iter().map(of).collect()
    }

    #[test]
    fn creases_that_end_loose_tell_an_organic_shape() {
        let rings = || vec![crease(vec![0, 1, 2, 0], 10.0), crease(vec![3, 4, 5, 3], 20.0)];
        let all = |extra: Vec<Curve>| networks(rings().into_iter().chain(extra).collect());
        // Rings alone are of the design, and so is a seam that runs out, as long as it is little of all.
        assert_eq!(all(vec![]), [(true, true); 2]);
        assert_eq!(all(vec![crease(vec![6, 7], 9.0)]), [(true, true); 3]);
        // Among many long folds only the long ring is.
        let folds = vec![crease(vec![6, 7], 9.0), crease(vec![8, 9], 9.0)];
        assert_eq!(all(folds), [(true, false), (true, true), (true, false), (true, false)]);
        // Short ones are noise, and tell the same.
        let wrinkles: Vec<Curve> = (0..5).map(|i| crease(vec![10 + 2 * i, 11 + 2 * i], 1.5)).collect();
        assert_eq!(all(wrinkles), [[(true, false), (true, true)].as_slice(), &[(false, false); 5]].concat());
    }
}
