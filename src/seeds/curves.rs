//! Seeds along creases: even in arc length, or in arc length over the spacing where that varies.

use glam::DVec3;

use super::Anchor;
use super::knots::Knot;
use super::networks::{LEAST_DETAIL, Network, Networks, ends};
use super::surface_sampling::BoundarySeed;
use crate::geometry::frame::snap;
use crate::surface::Surface;
use crate::surface::features::{Curve, Features};

/// Up to so many spacings long, a crease between two corners is one edge of the mesh.
const LONGEST_EDGE: f64 = 1.2;

/// What decides how many seeds a crease gets.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveNeed {
    /// Whether it is kept at all.
    pub(super) kept: bool,
    /// Whether it is to be in the mesh whole and close, however fine it is: designed, not noise.
    pub(super) whole: bool,
    /// Whether it is a closed loop without a corner.
    pub(super) closed: bool,
    /// Seeds without which its chain of edges would not be itself: 3 for a loop, 2 for a loop with one corner, 1
    /// where another crease joins the same two corners.
    pub(super) least: usize,
}

/// The needs of every curve of `features`, and the corners that are kept, where the spacing at a vertex is about `spacing`.
pub(super) fn needs(
    surface: &Surface,
    features: &Features,
    has_room: bool,
    spacing: impl Fn(u32) -> f64,
) -> (Vec<CurveNeed>, Vec<u32>) {
    let networks = Networks::of(surface, features, has_room, &spacing);
    let corners = networks.corners(surface, features, &spacing);
    let mut pairs: Vec<(u32, u32)> = features.curves.iter().map(ends).collect();
    pairs.sort_unstable();
    let need = |c: &Curve| {
        let pair = ends(c);
        let loops = pair.0 == pair.1;
        let closed = loops && features.corners.binary_search(&pair.0).is_err();
        let twins = pairs.partition_point(|&p| p <= pair) - pairs.partition_point(|&p| p < pair);
        let least = match (closed, loops) {
            (true, _) => 3,
            (false, true) => 2,
            _ => usize::from(twins > 1),
        };
        let Network { kept, whole, .. } = networks.at(pair.0);
        let whole = whole || c.is_given;
        let may_collapse = steps(c, &spacing) <= if whole { LEAST_DETAIL } else { 0.5 };
        let least = if kept && !may_collapse { least } else { 0 };
        CurveNeed { kept, whole: kept && whole, closed: closed && least > 0, least }
    };
    (features.curves.iter().map(need).collect(), corners)
}

/// Seeds of creases nearer than so many spacings to a corner or another crease's seed are one too many.
pub(super) fn crowded(whole: bool) -> f64 {
    if whole { 0.03 } else { 0.25 }
}

impl CurveNeed {
    /// Seeds wanted on a crease that is `steps` spacings long, not yet a whole number.
    pub(super) fn wanted(&self, steps: f64) -> f64 {
        if !self.kept {
            return 0.0;
        }
        if self.closed {
            return steps.max(3.0);
        }
        let least = if steps > LONGEST_EDGE { self.least.max(1) } else { self.least };
        (steps - 1.0).max(least as f64)
    }
}

/// How many spacings long `curve` is, for spacings at the surface's vertices.
pub(super) fn steps(curve: &Curve, spacing: impl Fn(u32) -> f64) -> f64 {
    segments(curve, &spacing).map(|(length, density)| length * density).sum()
}

/// Length and mean density (seeds per length) of each segment of `curve`.
fn segments(curve: &Curve, spacing: &impl Fn(u32) -> f64) -> impl Iterator<Item = (f64, f64)> {
    (1..curve.vertices.len()).map(move |i| {
        let density = 0.5 / spacing(curve.vertices[i - 1]) + 0.5 / spacing(curve.vertices[i]);
        (curve.arc[i] - curve.arc[i - 1], density)
    })
}

/// `count` places on `curve`, even in steps of the spacing, its ends left free if it joins corners.
pub(super) fn even(curve: &Curve, closed: bool, count: usize, spacing: impl Fn(u32) -> f64) -> Vec<Knot> {
    let total = steps(curve, &spacing);
    let (gaps, first) = if closed { (count, 0.5) } else { (count + 1, 1.0) };
    let mut knots = Vec::with_capacity(count);
    let mut passed = 0.0;
    for (i, (length, density)) in segments(curve, &spacing).enumerate() {
        let last = i + 2 == curve.vertices.len();
        while knots.len() < count {
            let want = total * (knots.len() as f64 + first) / gaps as f64;
            if want > passed + length * density && !last {
                break;
            }
            let at = curve.arc[i] + ((want - passed) / density).clamp(0.0, length);
            knots.push(Knot { at, fixed: false });
        }
        passed += length * density;
    }
    knots
}

/// The seeds of curve `index` at `knots`.
pub(super) fn place(
    surface: &Surface,
    curve: &Curve,
    index: u32,
    knots: &[Knot],
    spacing: impl Fn(u32) -> f64,
) -> Vec<BoundarySeed> {
    let place = |knot: &Knot| {
        let at = knot.at;
        let anchor = if knot.fixed { Anchor::Knot { curve: index, at } } else { Anchor::Curve { curve: index, at } };
        let near = curve.arc.partition_point(|&a| a <= at).min(curve.arc.len() - 1);
        let spacing = spacing(curve.vertices[near]);
        BoundarySeed { position: snap(curve.point_at(at, surface.points())), anchor, normal: DVec3::ZERO, spacing }
    };
    knots.iter().map(place).collect()
}
