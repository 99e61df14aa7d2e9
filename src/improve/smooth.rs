//! Moves vertices so that the worst tet around each gets better.
//!
//! L. A. Freitag, C. Ollivier-Gooch, *Tetrahedral mesh improvement using swapping and smoothing*, International Journal
//! for Numerical Methods in Engineering 40(21), 1997, doi 10.1002/(SICI)1097-0207(19971115)40:21<3979::AID-NME251>3.0.CO;2-9:
//!
//! 1. The angles around the vertex that are nearly the worst are active.
//! 2. The shortest vector in the convex hull of their gradients leads to where all of them rise, if there is such a way.
//! 3. The step goes where an angle that is not active yet would become the worst; it is halved until the worst tet gains.
//!
//! Departures: gradients are projected to the part of the solid that the vertex is bound to, and steps brought back to
//! it; the hull's shortest vector is approached by Gilbert's algorithm (E. G. Gilbert, *An iterative procedure for computing
//! the minimum of a quadratic form on a convex set*, SIAM Journal on Control 4(1), 1966, doi 10.1137/0304007).

use std::f64::consts::PI;

use glam::DVec3;

use super::complex::{Complex, Freedom};
use super::ground::{Ground, Tangent};
use super::measure::{self, LARGE_WEIGHT};
use crate::geometry::tetrahedron::FACETS;

/// Rounds of smoothing of one vertex at a time.
const ROUNDS: usize = 4;

/// Angles within so much of the worst are active: first many, then, where these allow no step, few (radians).
const ACTIVE: [f64; 2] = [0.05, 0.008];

/// Angles so far above the worst are not looked at.
const HORIZON: f64 = 0.5;

/// No step is longer than this share of the shortest edge.
const LONGEST_STEP: f64 = 0.4;

/// Trial steps before a direction is given up, each half the one before.
const TRIALS: usize = 4;

/// The least gain of the worst quality that counts (radians), and as a share of what it lacks to the floor: a tet far
/// below it is not worth a crawl.
const LEAST_GAIN: f64 = 2e-4;
const LEAST_SHARE: f64 = 0.03;

/// The least gain of the quality `worst` that counts.
pub(super) fn least_gain(worst: f64, floor: f64) -> f64 {
    LEAST_GAIN.max(LEAST_SHARE * (floor - worst))
}

/// Steps towards the shortest vector of the hull.
const HULL_STEPS: usize = 24;

/// What is known of the tets around a vertex; its buffers are used again.
#[derive(Debug, Default)]
pub(super) struct Smoother {
    /// For each tet of the star, the facet opposite the vertex: with the vertex first, a positive tet.
    links: Vec<[DVec3; 3]>,
    pieces: Vec<Piece>,
    active: Vec<DVec3>,
    strays: Vec<(u32, f64)>,
}

/// An angle as it counts for the quality.
#[derive(Clone, Copy, Debug)]
struct Piece {
    value: f64,
    gradient: DVec3,
}

impl Smoother {
    /// Takes the star of `v`; returns the worst quality in it.
    fn gather(&mut self, complex: &Complex, v: u32) -> f64 {
        self.links.clear();
        let mut worst = f64::INFINITY;
        for &t in complex.star(v) {
            let tet = complex.tets[t as usize];
            let at = tet.iter().position(|&u| u == v).expect("a star's tets have its vertex: this is a bug in tetcvt");
            self.links.push(FACETS[at].map(|k| complex.points[tet[k] as usize]));
            worst = complex.quality[t as usize].min(worst);
        }
        worst
    }

    /// Moves `v` so that its worst tet gets better; whether it did.
    pub(super) fn raise_worst(&mut self, complex: &mut Complex, ground: &Ground, v: u32) -> bool {
        let mut moved = false;
        for _ in 0..ROUNDS {
            let worst = self.gather(complex, v);
            let Some(tangent) = ground.tangent(complex, v) else { return moved };
            if worst >= complex.floor() || !self.step(complex, ground, (v, worst), tangent) {
                return moved;
            }
            moved = true;
        }
        moved
    }

    /// One step of step 1 to 3.
    fn step(&mut self, complex: &mut Complex, ground: &Ground, (v, worst): (u32, f64), tangent: Tangent) -> bool {
        let from = complex.points[v as usize];
        let gain = least_gain(worst, complex.floor());
        let shortest2 = self.find_pieces(from, worst, tangent);
        for window in ACTIVE {
            self.active.clear();
            self.active.extend(self.pieces.iter().filter(|p| p.value <= worst + window).map(|p| p.gradient));
            let rise = shortest_in_hull(&self.active);
            let Some(direction) = rise.try_normalize() else { continue };
            // 3.
            let mut step = LONGEST_STEP * shortest2.sqrt();
            let rate = rise.length();
            for piece in &self.pieces {
                let slope = piece.gradient.dot(direction);
                if piece.value > worst + window && slope < rate {
                    step = step.min((piece.value - worst) / (rate - slope));
                }
            }
            for _ in 0..TRIALS {
                if rate * step < gain {
                    break;
                }
                if let Some((to, freedom)) = ground.place(complex, v, direction * step)
                    && self.worst_at(to, worst + gain).is_some()
                    && self.settle(complex, ground, v, to, freedom)
                {
                    return true;
                }
                step *= 0.5;
            }
        }
        false
    }

    /// The angles around the vertex that are not far above the worst, and the square of the shortest edge.
    fn find_pieces(&mut self, from: DVec3, worst: f64, tangent: Tangent) -> f64 {
        self.pieces.clear();
        let most = worst + HORIZON;
        let mut shortest2 = f64::INFINITY;
        for &link in &self.links {
            for angle in measure::angles(from, link) {
                if angle.value < most {
                    self.pieces.push(Piece { value: angle.value, gradient: tangent.project(angle.gradient) });
                }
                let large = LARGE_WEIGHT * (PI - angle.value);
                if large < most {
                    let gradient = tangent.project(angle.gradient) * -LARGE_WEIGHT;
                    self.pieces.push(Piece { value: large, gradient });
                }
            }
            shortest2 = link.iter().map(|q| q.distance_squared(from)).fold(shortest2, f64::min);
        }
        shortest2
    }

    /// The worst quality with the vertex at `p`, if it is more than `least`.
    fn worst_at(&self, p: DVec3, least: f64) -> Option<f64> {
        let mut worst = f64::INFINITY;
        for &[a, b, c] in &self.links {
            worst = measure::quality([p, a, b, c]).min(worst);
            if worst <= least {
                return None;
            }
        }
        Some(worst)
    }

    /// Moves the vertex, unless a facet around it would stray from the surface.
    fn settle(&mut self, complex: &mut Complex, ground: &Ground, v: u32, to: DVec3, freedom: Freedom) -> bool {
        self.strays.clear();
        if complex.on_boundary(v) {
            let before = complex.facets_of(v).iter().map(|&f| complex.facets[f as usize].stray).fold(0.0, f64::max);
            for &f in complex.facets_of(v) {
                let corners = complex.facets[f as usize].vertices;
                let corners = corners.map(|u| if u == v { to } else { complex.points[u as usize] });
                let stray = ground.stray(corners);
                if !ground.allows(corners, stray, before) {
                    return false;
                }
                self.strays.push((f, stray));
            }
        }
        complex.move_vertex(v, to, freedom);
        for &(f, stray) in &self.strays {
            complex.set_stray(f, stray);
        }
        true
    }

    /// Moves `v` so that the sum of its tets' smallest angles grows while none falls below the floor, or below the worst
    /// that there was; whether it did.
    pub(super) fn raise_sum(&mut self, complex: &mut Complex, ground: &Ground, v: u32) -> bool {
        let worst = self.gather(complex, v);
        let Some(tangent) = ground.tangent(complex, v) else { return false };
        let from = complex.points[v as usize];
        let mut sum = 0.0;
        let mut rise = DVec3::ZERO;
        let mut shortest2 = f64::INFINITY;
        for &link in &self.links {
            let angles = measure::angles(from, link);
            let least = angles.iter().fold(&angles[0], |a, b| if b.value < a.value { b } else { a });
            sum += least.value;
            rise += least.gradient;
            shortest2 = link.iter().map(|q| q.distance_squared(from)).fold(shortest2, f64::min);
        }
        let rise = tangent.project(rise);
        let Some(direction) = rise.try_normalize() else { return false };
        let mut step = POLISH_STEP * shortest2.sqrt();
        let bound = complex.floor().min(worst);
        for _ in 0..TRIALS {
            if let Some((to, freedom)) = ground.place(complex, v, direction * step)
                && self.sum_at(to, bound).is_some_and(|s| s > sum + POLISH_GAIN)
                && self.settle(complex, ground, v, to, freedom)
            {
                return true;
            }
            step *= 0.5;
        }
        false
    }

    /// The sum of the smallest angles with the vertex at `p`, if no quality is below `bound`.
    fn sum_at(&self, p: DVec3, bound: f64) -> Option<f64> {
        let mut sum = 0.0;
        for &[a, b, c] in &self.links {
            let extremes = measure::extremes([p, a, b, c])?;
            if measure::combined(extremes) < bound {
                return None;
            }
            sum += extremes[0];
        }
        Some(sum)
    }
}

/// First step of the polish, as a share of the shortest edge, and the least gain of a sum (radians).
const POLISH_STEP: f64 = 0.08;
const POLISH_GAIN: f64 = 1e-3;

/// About the shortest vector in the convex hull of `vectors`; zero where the hull holds the origin.
fn shortest_in_hull(vectors: &[DVec3]) -> DVec3 {
    let Some(&first) = vectors.first() else { return DVec3::ZERO };
    let mut best = first;
    for _ in 0..HULL_STEPS {
        let length2 = best.length_squared();
        let lowest = vectors.iter().fold((f64::INFINITY, best), |low, &g| {
            let along = g.dot(best);
            if along < low.0 { (along, g) } else { low }
        });
        if lowest.0 >= 0.98 * length2 {
            return best;
        }
        // The point of the segment to that vector that is closest to the origin.
        let to = lowest.1 - best;
        let share = (-best.dot(to) / to.length_squared()).clamp(0.0, 1.0);
        best += to * share;
    }
    // Not settled: a way up only if every vector agrees with it.
    if vectors.iter().all(|g| g.dot(best) > 0.0) { best } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_s_shortest_vector() {
        let close = |v: &[DVec3], expected: DVec3| {
            let found = shortest_in_hull(v);
            assert!(found.distance(expected) < 0.02, "{found} is not {expected}");
        };
        close(&[DVec3::X], DVec3::X);
        close(&[DVec3::X, DVec3::Y], DVec3::new(0.5, 0.5, 0.0));
        close(&[DVec3::X, DVec3::Y, DVec3::Z], DVec3::splat(1.0 / 3.0));
        close(&[DVec3::X, DVec3::X * 5.0 + DVec3::Y, DVec3::X * 9.0 - DVec3::Z], DVec3::X);
        assert_eq!(shortest_in_hull(&[DVec3::X, -DVec3::X]), DVec3::ZERO);
        assert_eq!(shortest_in_hull(&[]), DVec3::ZERO);
    }
}
