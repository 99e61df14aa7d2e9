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

use super::around::{Around, Judgement, Steepest};
use super::complex::{Complex, Facet, Freedom, Stray};
use super::ground::{Ground, Tangent};
use super::measure::LARGE_WEIGHT;
use crate::geometry::tetrahedron::FACETS;

/// First step of the polish, as a share of the shortest edge, and the least gain of a sum (radians).
const POLISH_STEP: f64 = 0.08;
const POLISH_GAIN: f64 = 1e-3;

/// Rounds of smoothing of one vertex at a time.
const ROUNDS: usize = 4;

/// Angles within so much of the worst are active: first many, then, where these allow no step, few (radians).
const ACTIVE: [f64; 2] = [0.05, 0.008];

/// Angles so far above the worst are not looked at: these seldom bound a step.
const HORIZON: f64 = 0.3;

/// No step is longer than this share of the shortest edge.
const LONGEST_STEP: f64 = 0.4;

/// Trial steps before a direction is given up, each half the one before.
const TRIALS: usize = 4;

/// The least gain of the worst quality that counts (radians).
const LEAST_GAIN: f64 = 2e-4;

/// The least gain of the quality `worst` that counts: in haste a larger share of what it lacks to the floor.
pub(super) fn least_gain(worst: f64, floor: f64, haste: f64) -> f64 {
    LEAST_GAIN.max(haste * (floor - worst))
}

/// Steps towards the shortest vector of the hull.
const HULL_STEPS: usize = 24;

/// What is known of the tets around a vertex; its buffers are used again.
#[derive(Debug, Default)]
pub(super) struct Smoother {
    around: Around,
    /// Those of these tets that are not far above the worst.
    low: Around,
    pieces: Vec<Piece>,
    active: Vec<DVec3>,
    strays: Vec<(u32, Stray)>,
    /// For each vertex, when it last could not be moved.
    stuck: Vec<Stuck>,
}

/// An angle as it counts for the quality.
#[derive(Clone, Copy, Debug)]
struct Piece {
    value: f64,
    gradient: DVec3,
}

/// A vertex that could not be moved so that its worst tet gets better.
#[derive(Clone, Copy, Debug, Default)]
struct Stuck {
    /// The number of changes of the mesh at that time, and one more.
    since: u32,
    /// The bounds on the boundary at that time.
    reach: [f64; 2],
}

impl Smoother {
    /// Lets every vertex be tried again.
    pub(super) fn forget(&mut self) {
        self.stuck.clear();
    }

    /// Takes the star of `v`.
    fn gather(&mut self, complex: &Complex, v: u32) {
        self.around.set(complex.star(v).iter().map(|&t| link(complex, t, v)));
    }

    /// Moves `v` so that its worst tet gets better, by as much as counts in such haste; whether it did.
    pub(super) fn raise_worst(&mut self, complex: &mut Complex, ground: &Ground, v: u32, haste: f64) -> bool {
        if complex.on_seam(v) || self.is_stuck(complex, ground, v) {
            return false;
        }
        for round in 0..ROUNDS {
            let worst = worst_of(complex, v);
            if worst >= complex.floor() {
                return round > 0;
            }
            let Some(tangent) = ground.tangent(complex, v) else { return false };
            let gain = least_gain(worst, complex.floor(), haste);
            if !self.step(complex, ground, (v, worst, gain), tangent) {
                self.stuck[v as usize] = Stuck { since: complex.changes() + 1, reach: ground.reach() };
                return round > 0;
            }
        }
        true
    }

    /// Whether nothing changed around `v` since it could not be moved.
    fn is_stuck(&mut self, complex: &Complex, ground: &Ground, v: u32) -> bool {
        self.stuck.resize(complex.points.len().max(self.stuck.len()), Stuck::default());
        let Stuck { since, reach } = self.stuck[v as usize];
        since > 0 && !complex.changed_around(v, since - 1) && ground.is_within(reach)
    }

    /// One step of step 1 to 3.
    fn step(
        &mut self,
        complex: &mut Complex,
        ground: &Ground,
        (v, worst, gain): (u32, f64, f64),
        tangent: Tangent,
    ) -> bool {
        self.find_pieces(complex, (v, worst), tangent);
        let longest = LONGEST_STEP * shortest_edge2(complex, v).sqrt();
        let mut is_gathered = false;
        for window in ACTIVE {
            self.active.clear();
            self.active.extend(self.pieces.iter().filter(|p| p.value <= worst + window).map(|p| p.gradient));
            let rise = shortest_in_hull(&self.active);
            let Some(direction) = rise.try_normalize() else { continue };
            // 3.
            let mut step = longest;
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
                if !std::mem::replace(&mut is_gathered, true) {
                    self.gather(complex, v);
                }
                if let Some((to, freedom)) = ground.place(complex, v, direction * step)
                    && self.around.judge(to).is_some_and(|j| j.worst > worst + gain)
                    && self.settle(complex, ground, v, to, freedom)
                {
                    return true;
                }
                step *= 0.5;
            }
        }
        false
    }

    /// The angles around vertex `v` that are not far above the worst: tets of a higher quality have none of them.
    fn find_pieces(&mut self, complex: &Complex, (v, worst): (u32, f64), tangent: Tangent) {
        let Smoother { low, pieces, .. } = self;
        pieces.clear();
        let most = worst + HORIZON;
        let is_low = |t: &&u32| complex.quality[**t as usize] < most;
        low.set(complex.star(v).iter().filter(is_low).map(|&t| link(complex, t, v)));
        low.each_angle(complex.points[v as usize], [most, PI - most / LARGE_WEIGHT], |value, gradient| {
            let gradient = tangent.project(gradient);
            if value < most {
                pieces.push(Piece { value, gradient });
            } else {
                pieces.push(Piece { value: LARGE_WEIGHT * (PI - value), gradient: gradient * -LARGE_WEIGHT });
            }
        });
    }

    /// Moves the vertex to where its tets were just judged, unless a facet around it would stray from the surface.
    fn settle(&mut self, complex: &mut Complex, ground: &Ground, v: u32, to: DVec3, freedom: Freedom) -> bool {
        if !self.keeps_to(complex, ground, v, to) {
            return false;
        }
        complex.move_judged(v, to, freedom, self.around.qualities());
        self.strays.iter().for_each(|&(f, stray)| complex.set_stray(f, stray));
        true
    }

    /// Whether no facet around the vertex would stray from the surface; notes how far they do.
    fn keeps_to(&mut self, complex: &Complex, ground: &Ground, v: u32, to: DVec3) -> bool {
        self.strays.clear();
        let facets = complex.facets_of(v);
        let before = facets.iter().map(|&f| complex.facets[f as usize].stray.distance).fold(0.0, f64::max);
        facets.iter().all(|&f| {
            let Facet { vertices, stray, .. } = complex.facets[f as usize];
            let corners = vertices.map(|u| if u == v { to } else { complex.points[u as usize] });
            let stray = ground.stray_near(corners, stray.triangle);
            self.strays.push((f, stray));
            ground.allows(corners, stray, before)
        })
    }

    /// A move of `v` so that the sum of its tets' smallest angles and shapes grows while none falls below the floor, or below the worst
    /// that there was.
    pub(super) fn rise(&mut self, complex: &Complex, ground: &Ground, v: u32) -> Option<Move> {
        let tangent = ground.tangent(complex, v)?;
        self.gather(complex, v);
        let Steepest { sum, rise, shortest2 } = self.around.steepest(complex.points[v as usize]);
        let rise = tangent.project(rise);
        let direction = rise.try_normalize()?;
        let rate = rise.length();
        let mut step = POLISH_STEP * shortest2.sqrt();
        let bound = complex.floor().min(worst_of(complex, v));
        for _ in 0..TRIALS {
            // The sum bends down along the way: it grows by less than this.
            if rate * step <= POLISH_GAIN {
                return None;
            }
            let mut next = 0.5 * step;
            if let Some((to, freedom)) = ground.place(complex, v, direction * step)
                && let Some(Judgement { worst, sum: found }) = self.around.judge(to)
            {
                if found <= sum + POLISH_GAIN {
                    // To the top of the parabola through what is known of the sum along the way.
                    let top = 0.5 * rate * step * step / (rate * step + sum - found);
                    if 0.5 * rate * top <= POLISH_GAIN {
                        return None;
                    }
                    next = top.clamp(0.125 * step, 0.75 * step);
                } else if worst >= bound && self.keeps_to(complex, ground, v, to) {
                    let qualities = self.around.qualities().to_vec();
                    return Some(Move { vertex: v, to, freedom, qualities, strays: self.strays.clone() });
                }
            }
            step = next;
        }
        None
    }
}

/// A move of a vertex, with what becomes of its tets and of the facets around it.
#[derive(Clone, Debug)]
pub(super) struct Move {
    vertex: u32,
    to: DVec3,
    freedom: Freedom,
    qualities: Vec<f64>,
    strays: Vec<(u32, Stray)>,
}

impl Move {
    /// Makes the move: nothing around the vertex has changed since it was found.
    pub(super) fn apply(&self, complex: &mut Complex) {
        complex.move_judged(self.vertex, self.to, self.freedom, &self.qualities);
        self.strays.iter().for_each(|&(f, stray)| complex.set_stray(f, stray));
    }
}

/// The corners of tet `t` but for its vertex `v`: with that first they make it positive.
fn link(complex: &Complex, t: u32, v: u32) -> [DVec3; 3] {
    let tet = complex.tets[t as usize];
    let at = tet.iter().position(|&u| u == v).expect("a star's tets have its vertex: this is a bug in tetcvt");
    FACETS[at].map(|k| complex.points[tet[k] as usize])
}

/// The square of the shortest edge at a vertex.
fn shortest_edge2(complex: &Complex, v: u32) -> f64 {
    let from = complex.points[v as usize];
    let others = complex.star(v).iter().flat_map(|&t| complex.tets[t as usize]).filter(|&u| u != v);
    others.map(|u| complex.points[u as usize].distance_squared(from)).fold(f64::INFINITY, f64::min)
}

/// The worst quality of the tets around a vertex.
fn worst_of(complex: &Complex, v: u32) -> f64 {
    complex.star(v).iter().map(|&t| complex.quality[t as usize]).fold(f64::INFINITY, f64::min)
}

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
    use super::super::complex::tests::{on_grid, shake};
    use super::*;

    #[test]
    fn gains_that_count_are_a_share_of_the_lack() {
        assert_eq!(least_gain(0.2, 0.6, 0.0), LEAST_GAIN);
        assert!((least_gain(0.2, 0.6, 0.3) - 0.12).abs() < 1e-15);
        assert_eq!(least_gain(0.6 - 1e-9, 0.6, 0.3), LEAST_GAIN);
    }

    #[test]
    fn in_haste_a_vertex_moves_for_a_large_gain_alone() {
        on_grid(|mut complex, ground| {
            shake(&mut complex, 0.05);
            complex.set_floor(0.9);
            let [patient, hasty] = [0.0, 0.1].map(|haste| {
                let mut moved = 0;
                for v in 0..complex.points.len() as u32 {
                    let (mark, before) = (complex.mark(), worst_of(&complex, v));
                    if Smoother::default().raise_worst(&mut complex, ground, v, haste) {
                        moved += 1;
                        let least = before + haste * (complex.floor() - before);
                        assert!(worst_of(&complex, v) > least, "vertex {v} from {before} in haste {haste}");
                    }
                    complex.rollback(mark);
                }
                moved
            });
            assert!(0 < hasty && hasty < patient, "{hasty} of {patient} moved in haste");
        });
    }

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
