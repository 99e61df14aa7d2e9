//! Where the seeds of a crease go: its edges in the mesh are the chords between them.
//!
//! A chord cuts off what bends between its ends, and a crease of few, long segments loses its own vertices. Of all ways to
//! pick seeds among candidates along the crease, the one with the least sum over its chords of
//!
//! - the square of ln(length / spacing), which makes them even, and
//! - the square of what the crease strays from the chord beyond a share of the spacing, over that,
//!
//! is found by dynamic programming along the crease. Candidates are the crease's own vertices and even steps between them.
//! Seeds at and beside bends are fixed; those on a straight run may still move.
//!
//! Cost: O(candidates x candidates to a spacing squared), about 10^4 steps to a spacing of crease.

use glam::DVec3;

use crate::geometry::triangle::closest_on_segment;
use crate::surface::features::Curve;

/// Seeds may move where the crease between their neighbours strays less than this, over the spacing, from a straight line.
const STRAIGHT: f64 = 1e-3;
/// Steps between candidates on straight segments, over the spacing.
const STEP: f64 = 0.2;
/// Cosine of 6 degrees.
const TURN: f64 = 0.9945;
/// Longest chord over the spacing.
const LONGEST: f64 = 1.6;

/// How close chords are to follow a crease.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closeness {
    /// The crease may stray so far from its chords, over the spacing.
    stray: f64,
    /// What straying that far again weighs against a chord e times too long or too short.
    weight: f64,
    /// Vertices closer to the candidate before than this, over the spacing, are none, unless the crease turns by more than
    /// [`TURN`] there.
    finest: f64,
}

impl Closeness {
    /// For creases that are to be whole, and for those that are noise.
    pub(super) fn of(whole: bool) -> Closeness {
        if whole {
            Closeness { stray: 0.0055, weight: 8.0, finest: 0.02 }
        } else {
            Closeness { stray: 0.008, weight: 3.0, finest: 0.05 }
        }
    }
}

/// A place for a seed on a crease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    /// Arc length from the curve's first vertex.
    pub(super) at: f64,
    /// Whether the crease bends here, so that the seed must stay.
    pub(super) fixed: bool,
}

struct Candidate {
    at: f64,
    point: DVec3,
    /// What chords are to be long.
    spacing: f64,
    /// What straying is measured by: the spacing that would be here if no seeds had to be closer.
    plain: f64,
}

/// The places between the ends of `curve`, and on a loop without a corner that of its first vertex too; `spacings` has for each of
/// the surface's vertices the spacing there, and what it would be if no seeds had to be closer.
pub(super) fn knots(
    curve: &Curve,
    closed: bool,
    closeness: Closeness,
    points: &[DVec3],
    spacings: impl Fn(u32) -> [f64; 2],
) -> Vec<Knot> {
    let candidates = candidates(curve, closeness, points, spacings);
    let chain = best_chain(&candidates, closeness);
    let inner = chain.windows(3).map(|k| {
        let here = &candidates[k[1]];
        Knot { at: here.at, fixed: stray(&candidates[k[0]..=k[2]]) > STRAIGHT * here.spacing }
    });
    // The seam of a loop is as good a place as any other, and stays so that the rest keeps its places to it.
    let seam = closed.then_some(Knot { at: 0.0, fixed: true });
    seam.into_iter().chain(inner).collect()
}

/// The ends of the curve, its vertices, and even steps on its long segments.
fn candidates(
    curve: &Curve,
    closeness: Closeness,
    points: &[DVec3],
    spacings: impl Fn(u32) -> [f64; 2],
) -> Vec<Candidate> {
    let last = curve.vertices.len() - 1;
    let place = |i: usize| points[curve.vertices[i] as usize];
    let candidate = |at, point, [spacing, plain]: [f64; 2]| Candidate { at, point, spacing, plain };
    let mut found = vec![candidate(0.0, place(0), spacings(curve.vertices[0]))];
    for i in 1..=last {
        let (from, to) = (place(i - 1), place(i));
        let [s, t] = [i - 1, i].map(|k| spacings(curve.vertices[k]));
        let (start, length) = (curve.arc[i - 1], curve.arc[i] - curve.arc[i - 1]);
        let steps = (length / (STEP * s[0].min(t[0]))).ceil().max(1.0) as usize;
        for k in 1..steps {
            let share = k as f64 / steps as f64;
            let between = |k: usize| s[k] + share * (t[k] - s[k]);
            found.push(candidate(start + share * length, from.lerp(to, share), [between(0), between(1)]));
        }
        let straight = i < last && (to - from).dot(place(i + 1) - to) > TURN * length * place(i + 1).distance(to);
        let near = curve.arc[i] - found[found.len() - 1].at < closeness.finest * t[0];
        if i == last || !(straight && near) {
            found.push(candidate(curve.arc[i], to, t));
        }
    }
    found
}

/// The candidates from the first to the last whose chords cost least.
fn best_chain(candidates: &[Candidate], closeness: Closeness) -> Vec<usize> {
    let mut best = vec![(f64::INFINITY, 0); candidates.len()];
    best[0].0 = 0.0;
    for j in 1..candidates.len() {
        for i in (0..j).rev() {
            let span = candidates[j].at - candidates[i].at;
            if i + 1 < j && span > LONGEST * candidates[i].spacing.max(candidates[j].spacing) {
                break;
            }
            let cost = best[i].0 + cost(&candidates[i..=j], closeness);
            if cost < best[j].0 {
                best[j] = (cost, i);
            }
        }
    }
    let mut chain = vec![candidates.len() - 1];
    while let Some(&j) = chain.last().filter(|&&j| j > 0) {
        chain.push(best[j].1);
    }
    chain.reverse();
    chain
}

/// How far these candidates are from the chord between the first and the last.
fn stray(piece: &[Candidate]) -> f64 {
    let (from, to) = (piece[0].point, piece[piece.len() - 1].point);
    piece[1..piece.len() - 1]
        .iter()
        .map(|c| closest_on_segment(from, to, c.point).distance(c.point))
        .fold(0.0, f64::max)
}

/// What a chord from the first to the last of these candidates costs.
fn cost(piece: &[Candidate], closeness: Closeness) -> f64 {
    let (from, to) = (&piece[0], &piece[piece.len() - 1]);
    let spacing = 0.5 * (from.spacing + to.spacing);
    let plain = 0.5 * (from.plain + to.plain);
    let beyond = (stray(piece) / (closeness.stray * plain) - 1.0).max(0.0);
    let length = ((to.at - from.at) / spacing).ln();
    length * length + closeness.weight * beyond * beyond
}
