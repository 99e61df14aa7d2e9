//! The surface that the boundary must keep to: where its vertices may go, and how far its facets may stray.

use glam::DVec3;

use super::complex::{Complex, Facet, Freedom, NONE, Stray};
use crate::geometry::frame::snap;
use crate::geometry::triangle;
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::surface::walk::Walk;

/// Facets may stray from the surface by this share of its diagonal; farther, only where they did before.
const STRAY: f64 = 3e-4;

/// For the few tets that this leaves below the floor: as far as all but this share of the facets do at the start, or by a
/// share of the facet's size.
const STRAYING: f64 = 0.03;

/// A vertex of the surface that moves by a step may be brought back to the surface by at most this share of it.
const LIFT: f64 = 0.5;

/// What holds the gradient of a vertex to its part of the solid.
#[derive(Clone, Copy, Debug)]
pub(super) enum Tangent {
    /// Every direction.
    All,
    /// Those across this unit normal.
    Plane(DVec3),
    /// Those along this unit vector.
    Line(DVec3),
}

impl Tangent {
    /// The part of `gradient` along which the vertex may move.
    pub(super) fn project(&self, gradient: DVec3) -> DVec3 {
        match *self {
            Tangent::All => gradient,
            Tangent::Plane(n) => gradient - n * gradient.dot(n),
            Tangent::Line(t) => t * gradient.dot(t),
        }
    }
}

/// The surface and its features.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub surface: &'a Surface,
    pub walk: Walk<'a>,
    pub features: &'a Features,
    /// The smooth part that each of the surface's triangles counts to.
    pub face: &'a [u32],
    /// For each crease, whether it is to stay whole.
    pub whole: &'a [bool],
    limit: f64,
    /// Facets may also stray by this share of their size.
    share: f64,
}

impl<'a> Ground<'a> {
    pub(super) fn new(walk: Walk<'a>, features: &'a Features, face: &'a [u32]) -> Ground<'a> {
        let surface = walk.surface;
        Ground { surface, walk, features, face, whole: &[], limit: STRAY * surface.diagonal(), share: 0.0 }
    }

    /// The same, with the creases that are to stay whole.
    pub(super) fn keeping(self, whole: &'a [bool]) -> Ground<'a> {
        Ground { whole, ..self }
    }

    /// A triangle of a smooth part of the surface that holds `p`.
    pub(super) fn triangle_at(&self, p: DVec3, face: u32) -> Option<u32> {
        let reach = DVec3::splat(1e-12);
        let mut found: Option<u32> = None;
        self.surface.tree().near_box(p - reach, p + reach, |t| {
            if self.face[t as usize] == face && found.is_none_or(|f| t < f) {
                found = Some(t);
            }
        });
        found.filter(|&t| triangle::closest_point(self.surface.corners(t), p).distance(p) <= reach.x)
    }

    /// The same, with a bound that leaves more room: as far as most of `facets` stray, or `share` of a facet's size.
    pub(super) fn loosened(&self, facets: &[Facet], share: f64) -> Ground<'a> {
        let mut strays: Vec<f64> = facets.iter().filter(|f| f.vertices[0] != NONE).map(|f| f.stray.distance).collect();
        strays.sort_unstable_by(f64::total_cmp);
        let usual = strays.get((strays.len() as f64 * (1.0 - STRAYING)) as usize);
        Ground { limit: self.limit.max(usual.copied().unwrap_or(0.0)), share, ..*self }
    }

    /// The same, where facets may stray by `limit`.
    pub(super) fn within(&self, limit: f64) -> Ground<'a> {
        Ground { limit: self.limit.max(limit), ..*self }
    }

    /// How far a facet strays: the distance of its centroid to the surface.
    pub(super) fn stray(&self, [a, b, c]: [DVec3; 3]) -> Stray {
        let closest = self.surface.tree().closest(triangle::centroid(a, b, c));
        Stray { distance: closest.distance2.sqrt(), triangle: closest.triangle }
    }

    /// The same where a triangle nearby is known.
    pub(super) fn stray_near(&self, [a, b, c]: [DVec3; 3], triangle: u32) -> Stray {
        let closest = self.walk.closest_from(triangle, triangle::centroid(a, b, c));
        Stray { distance: closest.distance2.sqrt(), triangle: closest.triangle }
    }

    /// The triangle of the surface that a facet stands for, as [`Surface::facing`] finds it; one nearby is known.
    pub(super) fn facing(&self, [a, b, c]: [DVec3; 3], near: u32) -> u32 {
        let center = triangle::centroid(a, b, c);
        let closest = self.surface.tree().closest_near(center, near, self.surface.corners(near)).triangle;
        let faces = self.surface.normal2(closest).dot(triangle::normal2(a, b, c)) > 0.0;
        if faces { closest } else { self.surface.facing([a, b, c]) }
    }

    /// Whether facets may stray no farther than where the bounds were `reach`.
    pub(super) fn is_within(&self, reach: [f64; 2]) -> bool {
        self.limit <= reach[0] && self.share <= reach[1]
    }

    /// The bounds on how far facets may stray.
    pub(super) fn reach(&self) -> [f64; 2] {
        [self.limit, self.share]
    }

    /// Whether a facet may stray so far in the place of facets that strayed by at most `before`.
    pub(super) fn allows(&self, [a, b, c]: [DVec3; 3], stray: Stray, before: f64) -> bool {
        let stray = stray.distance;
        stray <= self.limit.max(before) || stray <= self.share / 3.0 * (a.distance(b) + b.distance(c) + c.distance(a))
    }

    /// Whether a crease may run straight from `a` to `b`, vertices on curve `number`, past `v` between them: it may cut off as much as a
    /// facet that long.
    pub(super) fn may_skip(&self, complex: &Complex, number: u32, v: u32, [a, b]: [u32; 2]) -> bool {
        let (Freedom::Curve(_, at) | Freedom::Knot(_, at)) = complex.freedom[v as usize] else { return false };
        let Some(from) = self.arc_of(complex, number, a, at) else { return false };
        let Some(to) = self.arc_of(complex, number, b, at) else { return false };
        let curve = &self.features.curves[number as usize];
        let past = (from < at) == (at < to);
        let length = complex.points[a as usize].distance(complex.points[b as usize]);
        let is_whole = self.whole.get(number as usize) == Some(&true);
        let most = if is_whole { 0.25 * self.limit } else { self.limit.max(self.share * length) };
        let is_direct = !curve.is_closed() || (to - from).abs() < 0.5 * curve.length();
        past && is_direct && self.bulge(number, from, to) <= most
    }

    /// The curve of a crease of the mesh, and the arc length midway between its ends; `None` where both are corners, and across
    /// the seam of a loop.
    pub(super) fn middle_of_crease(&self, complex: &Complex, [a, b]: [u32; 2]) -> Option<(u32, f64)> {
        let on_curve = |v: u32| match complex.freedom[v as usize] {
            Freedom::Curve(number, at) | Freedom::Knot(number, at) => Some((number, at)),
            _ => None,
        };
        let (number, at) = on_curve(a).or_else(|| on_curve(b))?;
        let (from, to) = (self.arc_of(complex, number, a, at)?, self.arc_of(complex, number, b, at)?);
        let curve = &self.features.curves[number as usize];
        let is_direct = !curve.is_closed() || (to - from).abs() < 0.5 * curve.length();
        is_direct.then_some((number, 0.5 * (from + to)))
    }

    /// The directions that a vertex may move in; none for those that may not.
    pub(super) fn tangent(&self, complex: &Complex, v: u32) -> Option<Tangent> {
        match complex.freedom[v as usize] {
            Freedom::Inside => Some(Tangent::All),
            Freedom::Surface(t) => self.surface.normal2(t).try_normalize().map(Tangent::Plane),
            Freedom::Curve(curve, at) => {
                let points = self.surface.points();
                let curve = &self.features.curves[curve as usize];
                let reach = 1e-3 * curve.length();
                let along = curve.point_at(at + reach, points) - curve.point_at(at - reach, points);
                along.try_normalize().map(Tangent::Line)
            }
            Freedom::Held(_) | Freedom::Knot(..) | Freedom::Fixed => None,
        }
    }

    /// The place, within its part of the solid, that a vertex gets to by a step; `None` where the step leads out of it.
    pub(super) fn place(&self, complex: &Complex, v: u32, step: DVec3) -> Option<(DVec3, Freedom)> {
        let from = complex.points[v as usize];
        match complex.freedom[v as usize] {
            Freedom::Inside => Some((snap(from + step), Freedom::Inside)),
            Freedom::Surface(t) => self.on_surface(t, from + step, step.length()),
            Freedom::Curve(curve, at) => self.on_curve(complex, v, (curve, at), step),
            Freedom::Held(_) | Freedom::Knot(..) | Freedom::Fixed => None,
        }
    }

    fn on_surface(&self, near: u32, trial: DVec3, step: f64) -> Option<(DVec3, Freedom)> {
        let corners = self.surface.corners(near);
        // Within the triangle at hand no other needs to be looked for.
        if is_above(corners, trial) {
            let p = triangle::closest_point(corners, trial);
            return (p.distance(trial) <= LIFT * step).then_some((snap(p), Freedom::Surface(near)));
        }
        let closest = self.walk.closest_from(near, trial);
        let same = self.face[closest.triangle as usize] == self.face[near as usize]
            && self.surface.normal2(closest.triangle).dot(self.surface.normal2(near)) > 0.0;
        (same && closest.distance2 <= LIFT * LIFT * step * step)
            .then_some((snap(closest.point), Freedom::Surface(closest.triangle)))
    }

    fn on_curve(&self, complex: &Complex, v: u32, (number, at): (u32, f64), step: DVec3) -> Option<(DVec3, Freedom)> {
        let curve = &self.features.curves[number as usize];
        let Some(Tangent::Line(along)) = self.tangent(complex, v) else { return None };
        let length = curve.length();
        let mut to = at + step.dot(along);
        if curve.is_closed() {
            to = to.rem_euclid(length);
        } else if !(to > 0.0 && to < length) {
            return None;
        }
        let p = snap(curve.point_at(to, self.surface.points()));
        for w in complex.along_creases(v) {
            let Some(end) = self.arc_of(complex, number, w, to) else { continue };
            let (before, after) = (self.bulge(number, at, end), self.bulge(number, to, end));
            let is_whole = self.whole.get(number as usize) == Some(&true);
            let length = p.distance(complex.points[w as usize]);
            let most = if is_whole { 0.1 * self.limit } else { self.limit.max(self.share * length) };
            if after > before.max(most) {
                return None;
            }
        }
        Some((p, Freedom::Curve(number, to)))
    }

    /// The arc length of vertex `w` on a curve, if it is on it; for the end of a curve the one nearer `to`.
    fn arc_of(&self, complex: &Complex, number: u32, w: u32, to: f64) -> Option<f64> {
        match complex.freedom[w as usize] {
            Freedom::Curve(curve, at) | Freedom::Knot(curve, at) => (curve == number).then_some(at),
            Freedom::Fixed => {
                let curve = &self.features.curves[number as usize];
                let ends = [(0.0, curve.vertices[0]), (curve.length(), curve.vertices[curve.vertices.len() - 1])];
                let here = complex.points[w as usize];
                let at_end = |&(_, u): &(f64, u32)| self.surface.points()[u as usize] == here;
                let found = ends.into_iter().filter(at_end).map(|(at, _)| at);
                found.min_by(|a, b| (a - to).abs().total_cmp(&(b - to).abs()))
            }
            _ => None,
        }
    }

    /// How far a curve gets from its chord between two arc lengths.
    fn bulge(&self, number: u32, from: f64, to: f64) -> f64 {
        let curve = &self.features.curves[number as usize];
        let (low, high) = (from.min(to), from.max(to));
        if curve.is_closed() && high - low > 0.5 * curve.length() {
            // The way round goes through the seam: too rare to follow.
            return 0.0;
        }
        let points = self.surface.points();
        let [a, b] = [low, high].map(|at| curve.point_at(at, points));
        let range = curve.arc.partition_point(|&s| s <= low)..curve.arc.partition_point(|&s| s < high);
        let between = curve.vertices.get(range).unwrap_or(&[]);
        between
            .iter()
            .map(|&u| points[u as usize])
            .map(|p| triangle::closest_on_segment(a, b, p).distance(p))
            .fold(0.0, f64::max)
    }

    /// A new facet, unless it strays too far or turns away from what it replaces.
    pub(super) fn facet(&self, complex: &Complex, vertices: [u32; 3], face: u32, old: &[u32]) -> Option<Facet> {
        let corners = complex.corners(vertices);
        let [a, b, c] = corners;
        let normal = triangle::normal2(a, b, c);
        let before = old.iter().map(|&f| complex.facets[f as usize].stray.distance).fold(0.0, f64::max);
        let turned = old.iter().any(|&f| {
            let [a, b, c] = complex.corners(complex.facets[f as usize].vertices);
            let other = triangle::normal2(a, b, c);
            normal.dot(other) <= 0.5 * normal.length() * other.length()
        });
        if turned {
            return None;
        }
        let stray = match old {
            [f, ..] => self.stray_near(corners, complex.facets[*f as usize].stray.triangle),
            [] => self.stray(corners),
        };
        self.allows(corners, stray, before).then_some(Facet { vertices, face, stray })
    }
}

/// Whether `p` lies over or under the inside of a triangle.
fn is_above([a, b, c]: [DVec3; 3], p: DVec3) -> bool {
    let n = triangle::normal2(a, b, c);
    (b - a).cross(p - a).dot(n) > 0.0 && (c - b).cross(p - b).dot(n) > 0.0 && (a - c).cross(p - c).dot(n) > 0.0
}
