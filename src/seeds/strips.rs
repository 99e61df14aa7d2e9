//! How close seeds must be where creases force some of them together. On a strip, such as a chamfer or a step, that is narrower
//! than the spacing, edges much longer than the strip is wide make tets with small angles, and no move of the strip's seeds helps,
//! as all are bound to the creases. The same goes for a crease that bends so tightly that its own seeds are close.
//!
//! 1. Sample the creases that the mesh is to have whole.
//! 2. From each sample measure how far the nearest other crease is, or the same one farther on. Creases that meet near by at a
//!    wide angle are a corner, and no strip.
//! 3. On either side of a strip of width w the spacing may be [`STRIP`] w.
//! 4. Around the seeds of a crease that are g apart it may be [`BEND`] g.

use std::ops::RangeInclusive;

use glam::DVec3;
use rayon::prelude::*;

use super::counts::Plan;
use super::curves::CurveNeed;
use super::grid::{CellGrid, typical};
use super::networks::ends;
use super::thickness::GRADE;
use crate::surface::Surface;
use crate::surface::features::{Curve, Features};

/// Spacing over the width of a strip.
const STRIP: f64 = 2.0;

/// Spacing over the distance of seeds along a crease.
const BEND: f64 = 2.0;

/// No limit is below this share of the spacing: strips narrower than half of it are too fine for the count.
const NARROWEST: f64 = 0.2;

/// Samples along a crease for each spacing.
const DENSITY: f64 = 2.0;

/// Creases that meet nearer than so many times their distance are a corner.
const CORNER: f64 = 4.0;

/// A crease is beside itself where the way along it is so many times as long as the way across.
const AROUND: f64 = 4.0;

/// The surface is refined until its edges are no longer than so many times the size there, and where that is looked at along
/// an edge at most.
const SPLIT: f64 = 1.5;
const MOST_STEPS: f64 = 256.0;

/// A piece of a crease between two of the surface's vertices.
struct Segment {
    curve: u32,
    vertices: [u32; 2],
    /// Where its first vertex is along the crease.
    first: usize,
    at: f64,
}

/// A place on a crease.
struct Sample {
    segment: u32,
    place: DVec3,
    spacing: f64,
}

/// Where creases force seeds together.
struct Narrow {
    place: DVec3,
    /// The largest spacing there.
    limit: f64,
    /// The crease's vertices around it.
    curve: u32,
    vertices: RangeInclusive<usize>,
}

/// The largest spacing that creases allow at each vertex of the surface, where `sizes` are wanted; infinite where all is wide.
pub(super) fn limits(
    surface: &Surface,
    features: &Features,
    (needs, plan): (&[CurveNeed], &Plan),
    sizes: &[f64],
) -> Vec<f64> {
    let mut limits = vec![f64::INFINITY; surface.points().len()];
    for narrow in places(surface, features, (needs, plan), sizes) {
        for &v in &features.curves[narrow.curve as usize].vertices[narrow.vertices] {
            let away = surface.points()[v as usize].distance(narrow.place);
            limits[v as usize] = limits[v as usize].min(narrow.limit + GRADE * (away - narrow.limit).max(0.0));
        }
    }
    limits
}

/// The surface with its edges split where sizes that grow from what creases force together would not be linear along them; none
/// where they force nothing. The spacing is `plan`'s everywhere.
pub(super) fn refined(surface: &Surface, features: &Features, (needs, plan): (&[CurveNeed], &Plan)) -> Option<Surface> {
    let sizes = vec![plan.spacing; surface.points().len()];
    let narrow = places(surface, features, (needs, plan), &sizes);
    if narrow.is_empty() {
        return None;
    }
    let centers: Vec<DVec3> = narrow.iter().map(|n| n.place).collect();
    let grid = CellGrid::new(&centers, plan.spacing);
    let size = |p: DVec3| {
        let mut size = plan.spacing;
        grid.near(p, (1.0 - NARROWEST) / GRADE * plan.spacing, |i| {
            let Narrow { place, limit, .. } = narrow[i as usize];
            size = size.min(limit + GRADE * p.distance(place));
        });
        size
    };
    let is_long = |p: DVec3, q: DVec3| {
        let length = p.distance(q);
        if length < SPLIT * NARROWEST * plan.spacing {
            return false;
        }
        let steps = (length / plan.spacing).ceil().min(MOST_STEPS);
        (0..=steps as usize).any(|i| {
            let here = size(p.lerp(q, i as f64 / steps));
            here < plan.spacing && length > SPLIT * here
        })
    };
    Some(surface.refined(is_long))
}

/// 2. to 4.
fn places(surface: &Surface, features: &Features, (needs, plan): (&[CurveNeed], &Plan), sizes: &[f64]) -> Vec<Narrow> {
    let points = surface.points();
    let (segments, samples) = sample(surface, features, needs, sizes);
    let grid_places: Vec<DVec3> = samples.iter().map(|s| s.place).collect();
    let spacings: Vec<f64> = samples.iter().map(|s| s.spacing).collect();
    let grid = CellGrid::new(&grid_places, typical(&spacings));
    let width = |s: &Sample| {
        let own = &segments[s.segment as usize];
        let widest = s.spacing / STRIP;
        let mut least = f64::INFINITY;
        grid.near(s.place, widest + s.spacing / DENSITY, |i| {
            let other = &segments[samples[i as usize].segment as usize];
            let [a, b] = other.vertices.map(|v| points[v as usize]);
            let share = ((s.place - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let distance = a.lerp(b, share).distance(s.place);
            if distance < widest.min(least) {
                let at =
                    [own.at + s.place.distance(points[own.vertices[0] as usize]), other.at + share * a.distance(b)];
                if are_beside(features, [own.curve, other.curve], at, distance) {
                    least = distance;
                }
            }
        });
        least
    };
    let widths: Vec<f64> = samples.par_iter().map(width).collect();
    let across = samples.iter().zip(widths).filter_map(|(s, width)| {
        let Segment { curve, first, .. } = segments[s.segment as usize];
        let counts = width.is_finite() && STRIP * width >= NARROWEST * s.spacing;
        counts.then_some(Narrow { place: s.place, limit: STRIP * width, curve, vertices: first..=first + 1 })
    });
    let mut found: Vec<Narrow> = across.collect();
    // 4.
    for (i, ((curve, knots), _)) in
        (0..).zip(features.curves.iter().zip(&plan.curves).zip(needs)).filter(|(_, (_, n))| n.whole)
    {
        let inner = knots.iter().map(|k| k.at);
        let places: Vec<f64> = std::iter::once(0.0).chain(inner).chain([curve.length()]).collect();
        for gap in places.windows(2) {
            let limit = BEND * (gap[1] - gap[0]);
            let first = curve.arc.partition_point(|&a| a <= gap[0]).saturating_sub(1);
            let last = curve.arc.partition_point(|&a| a < gap[1]).min(curve.arc.len() - 1);
            let spacing = sizes[curve.vertices[first] as usize];
            if limit > NARROWEST * spacing && limit < spacing {
                let place = curve.point_at(0.5 * (gap[0] + gap[1]), points);
                found.push(Narrow { place, limit, curve: i, vertices: first..=last });
            }
        }
    }
    found
}

/// 1.
fn sample(surface: &Surface, features: &Features, needs: &[CurveNeed], sizes: &[f64]) -> (Vec<Segment>, Vec<Sample>) {
    let (mut segments, mut samples) = (Vec::new(), Vec::new());
    for (i, (curve, _)) in (0..).zip(features.curves.iter().zip(needs)).filter(|(_, (_, n))| n.whole) {
        for (first, (ends, &at)) in curve.vertices.windows(2).zip(&curve.arc).enumerate() {
            let spacing = 0.5 * (sizes[ends[0] as usize] + sizes[ends[1] as usize]);
            let [a, b] = [ends[0], ends[1]].map(|v| surface.points()[v as usize]);
            let parts = (DENSITY * a.distance(b) / spacing).ceil().max(1.0);
            for k in 0..parts as usize {
                let place = a.lerp(b, (k as f64 + 0.5) / parts);
                samples.push(Sample { segment: segments.len() as u32, place, spacing });
            }
            segments.push(Segment { curve: i, vertices: [ends[0], ends[1]], first, at });
        }
    }
    (segments, samples)
}

/// 2. Whether places of two creases, at these arc lengths and so far apart, are on either side of a strip.
fn are_beside(features: &Features, curves: [u32; 2], at: [f64; 2], distance: f64) -> bool {
    let [one, other] = curves.map(|c| &features.curves[c as usize]);
    if curves[0] == curves[1] {
        let along = (at[0] - at[1]).abs();
        let (a, b) = ends(one);
        let along = if a == b { along.min(one.length() - along) } else { along };
        return along > AROUND * distance;
    }
    // What ends there is not beside: a short crease may part it from the one that goes on.
    let (a, b) = ends(other);
    if a != b && !(1e-9..=1.0 - 1e-9).contains(&(at[1] / other.length())) {
        return false;
    }
    // From a corner that both end at.
    let from = |c: &Curve, end: usize, at: f64| if end == 0 { at } else { c.length() - at };
    let last = |c: &Curve, end: usize| if end == 0 { c.vertices[0] } else { c.vertices[c.vertices.len() - 1] };
    [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter().all(|[i, j]| {
        last(one, i) != last(other, j) || from(one, i, at[0]).min(from(other, j, at[1])) > CORNER * distance
    })
}

#[cfg(test)]
mod tests {
    use super::super::counts::{Demand, Size};
    use super::*;

    /// A prism over a convex polygon, of height 1, and its creases.
    fn prism(polygon: &[[f64; 2]]) -> (Surface, Features) {
        let n = polygon.len() as u32;
        let level = |z: f64| polygon.iter().map(move |&[x, y]| DVec3::new(x, y, z));
        let points: Vec<DVec3> = level(0.0).chain(level(1.0)).collect();
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for i in 0..n {
            let j = (i + 1) % n;
            triangles.extend([[i, j, n + j], [i, n + j, n + i]]);
        }
        triangles.extend((1..n - 1).flat_map(|i| [[0, i + 1, i], [n, n + i, n + i + 1]]));
        let each: Vec<u32> = (0..triangles.len() as u32).collect();
        let surface = Surface::new(&points, &triangles, &each, &each).expect("a closed surface");
        let features = Features::find(&surface, 40.0);
        (surface, features)
    }

    /// The limits at the vertices for so many seeds, over the spacing, and the spacing.
    fn limits_of(polygon: &[[f64; 2]], count: usize) -> (Vec<f64>, f64) {
        let (surface, features) = prism(polygon);
        let demand = Demand::measure(&surface, &features, None, Size::Count(count));
        let plan = demand.plan(count).expect("a plan");
        let sizes = demand.plain_sizes(plan.spacing);
        (limits(&surface, &features, (demand.needs(), &plan), &sizes), plan.spacing)
    }

    #[test]
    fn corners_are_no_strips() {
        let (limits, _) = limits_of(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 2000);
        assert!(limits.iter().all(|l| l.is_infinite()), "{limits:?}");
    }

    #[test]
    fn a_chamfer_is_a_strip_as_wide_as_it_is() {
        // The frame scales the prism so that its largest extent is one or less: widths are compared over the spacing.
        let cut = 0.03;
        let polygon = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0 - cut], [1.0 - cut, 1.0], [0.0, 1.0]];
        let (surface, _) = prism(&polygon);
        let scale = surface.frame().scale;
        let (limits, spacing) = limits_of(&polygon, 2000);
        let width = cut * 2f64.sqrt() * scale;
        assert!(STRIP * width < spacing, "{width} {spacing}");
        for (v, limit) in limits.iter().enumerate() {
            match v % 5 {
                2 | 3 => assert!((limit / (STRIP * width) - 1.0).abs() < 0.01, "{v}: {limit}"),
                _ => assert!(limit.is_infinite(), "{v}: {limit}"),
            }
        }
        // Too narrow for so few seeds.
        let finer = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.996], [0.996, 1.0], [0.0, 1.0]];
        let (limits, spacing) = limits_of(&finer, 2000);
        assert!(limits.iter().all(|l| l.is_infinite()), "{limits:?} {spacing}");
    }

    #[test]
    fn the_surface_is_refined_where_strips_are() {
        let polygon = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.97], [0.97, 1.0], [0.0, 1.0]];
        let (surface, features) = prism(&polygon);
        let demand = Demand::measure(&surface, &features, None, Size::Count(2000));
        let plan = demand.plan(2000).expect("a plan");
        let refined = refined(&surface, &features, (demand.needs(), &plan)).expect("strips");
        assert!((refined.area() - surface.area()).abs() < 1e-9 * surface.area());
        // Along the chamfer no edge is much longer than it is wide, and far from it edges stay long.
        let longest = |near: bool| {
            let chamfer = DVec3::new(0.985, 0.985, 0.5);
            let corners = |t: &[u32; 3]| t.map(|v| surface.frame().to_model(refined.points()[v as usize]));
            let all = refined.triangles().iter().map(corners).filter(|c| {
                let away = c.map(|p| (p.x - chamfer.x).hypot(p.y - chamfer.y));
                if near { away.iter().all(|d| *d < 0.03) } else { away.iter().all(|d| *d > 0.6) }
            });
            all.flat_map(|[a, b, c]| [a.distance(b), b.distance(c), c.distance(a)]).fold(0.0, f64::max)
        };
        assert!(longest(true) < 0.15 && longest(false) > 0.3, "{} {}", longest(true), longest(false));
    }
}
