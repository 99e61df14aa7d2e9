//! Seeds along creases: even in arc length, or in arc length over the spacing where that varies.

use glam::DVec3;

use super::Anchor;
use crate::geometry::frame::snap;
use crate::surface::Surface;
use crate::surface::features::{Curve, Features};

/// Up to so many spacings long, a crease between two corners is one edge of the mesh.
const LONGEST_EDGE: f64 = 1.2;

/// What decides how many seeds a crease gets.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveNeed {
    /// Whether it is a closed loop without a corner.
    pub(super) closed: bool,
    /// Seeds without which its chain of edges would not be itself: 3 for a loop, 2 for a loop with one corner, 1
    /// where another crease joins the same two corners.
    pub(super) least: usize,
}

/// The needs of every curve of `features`.
pub(super) fn needs(features: &Features) -> Vec<CurveNeed> {
    let ends = |c: &Curve| {
        let (a, b) = (c.vertices[0], c.vertices[c.vertices.len() - 1]);
        (a.min(b), a.max(b))
    };
    let mut corners = features.corners.clone();
    corners.sort_unstable();
    let mut pairs: Vec<(u32, u32)> = features.curves.iter().map(ends).collect();
    pairs.sort_unstable();
    let need = |c: &Curve| {
        let pair = ends(c);
        let loops = pair.0 == pair.1;
        let closed = loops && corners.binary_search(&pair.0).is_err();
        let twins = pairs.partition_point(|&p| p <= pair) - pairs.partition_point(|&p| p < pair);
        let least = match (closed, loops) {
            (true, _) => 3,
            (false, true) => 2,
            _ => usize::from(twins > 1),
        };
        CurveNeed { closed, least }
    };
    features.curves.iter().map(need).collect()
}

impl CurveNeed {
    /// Seeds wanted on a crease that is `steps` spacings long, not yet a whole number.
    pub(super) fn wanted(&self, steps: f64) -> f64 {
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

/// Puts `count` seeds on curve `index`, its ends left free if it joins corners.
pub(super) fn place(
    surface: &Surface,
    features: &Features,
    (index, closed): (u32, bool),
    count: usize,
    spacing: impl Fn(u32) -> f64,
) -> Vec<(DVec3, Anchor)> {
    let curve = &features.curves[index as usize];
    let total = steps(curve, &spacing);
    let (gaps, first) = if closed { (count, 0.5) } else { (count + 1, 1.0) };
    let mut seeds = Vec::with_capacity(count);
    let mut passed = 0.0;
    for (i, (length, density)) in segments(curve, &spacing).enumerate() {
        let last = i + 2 == curve.vertices.len();
        while seeds.len() < count {
            let want = total * (seeds.len() as f64 + first) / gaps as f64;
            if want > passed + length * density && !last {
                break;
            }
            let at = curve.arc[i] + ((want - passed) / density).clamp(0.0, length);
            seeds.push((point_at(surface, curve, at), Anchor::Curve { curve: index, at }));
        }
        passed += length * density;
    }
    seeds
}

/// The point of `curve` at arc length `at`, on the frame's grid.
pub fn point_at(surface: &Surface, curve: &Curve, at: f64) -> DVec3 {
    let i = curve.arc.partition_point(|&a| a <= at).clamp(1, curve.arc.len() - 1);
    let (a, b) = (curve.vertices[i - 1] as usize, curve.vertices[i] as usize);
    let t = (at - curve.arc[i - 1]) / (curve.arc[i] - curve.arc[i - 1]);
    snap(surface.points()[a].lerp(surface.points()[b], t.clamp(0.0, 1.0)))
}
