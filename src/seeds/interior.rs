//! Seeds inside the solid, clear of those on its boundary.
//!
//! - `bcc`: a randomly rotated body-centred cubic lattice, the lattice of the least CVT energy known in space (Barnes,
//!   Sloane, *The Optimal Lattice Quantizer in Three Dimensions*, SIAM Journal on Algebraic and Discrete Methods 4(1),
//!   1983, doi 10.1137/0604005). Its constant is fitted until it has as many points in the solid, clear of the
//!   boundary's seeds, as are wanted or slightly more; the surplus nearest the boundary is left out; then a jitter of a
//!   tenth of the spacing, without which relaxation would not leave the lattice where it does not fit.
//! - `blue`: sample elimination among uniform candidates (see `elimination`).
//! - `random`: uniform points, no two closer than a quarter of the spacing.
//!
//! Where sizes vary, points are drawn in that density, and distances and clearances are measured in the spacing at hand; the
//! lattice is kept where sizes are even, and blue noise fills the rest.
//!
//! Where walls are thin there may be no room for as many: fewer are returned, and the caller puts the rest on the
//! surface.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::blocks::Blocks;
use super::counts::CELL;
use super::elimination::{Sample, eliminate};
use super::grid::{CellGrid, typical};
use super::surface_sampling::BoundarySeed;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::frame::snap;
use crate::geometry::hilbert::hilbert_order;
use crate::params::Start;
use crate::rng::Rng;
use crate::sizing::Spacing;
use crate::surface::Surface;

/// Spacings between an interior seed and the nearest seed of the boundary, at least.
const CLEARANCE: f64 = 0.5;
/// Spacings of depth under the tangent plane of the nearest seed of the surface, at least.
const DEPTH: f64 = 0.2;
/// Displacement by jitter in each direction, over the spacing of the lattice.
const JITTER: f64 = 0.1;
/// The interior counts as full once the lattice's spacing has come down to this share of the one planned; what is left
/// over has room on the surface.
const DENSEST: f64 = 0.85;
/// The same where no seed may go to the surface.
const DENSEST_FREE: f64 = 0.4;
/// Candidates of blue noise for each seed.
const OVERSAMPLING: usize = 5;
/// Least distance between white noise's points, in spacings.
const WHITE_DISTANCE: f64 = 0.25;
/// Sizes above this share of the largest count as even, and where they are more than such a share of the seeds they get a
/// lattice.
const EVEN: f64 = 0.97;
const LATTICE: f64 = 0.3;
/// Points tried for each one wanted before the interior counts as full.
const TRIALS: usize = 400;

/// Where interior seeds may go.
pub(super) struct Interior<'a> {
    surface: &'a Surface,
    boundary: &'a [BoundarySeed],
    grid: CellGrid,
    blocks: &'a Blocks,
    spacing: Spacing,
    bounds: BoundingBox,
}

impl<'a> Interior<'a> {
    /// The interior of `surface`, clear of `boundary`.
    pub(super) fn new(
        surface: &'a Surface,
        blocks: &'a Blocks,
        boundary: &'a [BoundarySeed],
        spacing: Spacing,
    ) -> Interior<'a> {
        let positions: Vec<DVec3> = boundary.iter().map(|s| s.position).collect();
        let spacings: Vec<f64> = boundary.iter().map(|s| s.spacing).collect();
        let cell = if spacing.field.is_some() { typical(&spacings) } else { spacing.largest };
        let bounds = BoundingBox::of(surface.points());
        Interior { surface, boundary, grid: CellGrid::new(&positions, 2.0 * cell), blocks, spacing, bounds }
    }

    /// At most `count` seeds; fewer where there is no room.
    pub(super) fn place(&self, count: usize, start: Start, random_seed: u64) -> Vec<DVec3> {
        if count == 0 {
            return Vec::new();
        }
        let mut rng = Rng::new(random_seed, super::stream::INTERIOR);
        match start {
            Start::Bcc if self.spacing.field.is_some() => self.partly_lattice(count, &mut rng),
            Start::Bcc => self.lattice(count, &|_| true, &mut rng),
            Start::Blue => self.blue_noise(count, &mut rng),
            Start::Random => self.white_noise(count, &mut rng),
        }
    }

    /// How far `p` is from the boundary's seeds, in spacings and at most 1; none if it is outside or too close.
    fn clearance(&self, p: DVec3) -> Option<f64> {
        let mut nearest = (1.0, None);
        let reach = match &self.spacing.field {
            None => self.spacing.largest,
            Some(_) => 1.5 * self.spacing.at(p),
        };
        self.grid.near(p, reach, |i| {
            let s = &self.boundary[i as usize];
            let d2 = p.distance_squared(s.position) / (s.spacing * s.spacing);
            if d2 < nearest.0 {
                nearest = (d2, Some(i));
            }
        });
        if let (d2, Some(i)) = nearest {
            let s = &self.boundary[i as usize];
            let close = d2 < CLEARANCE * CLEARANCE;
            let shallow = s.normal != DVec3::ZERO && (s.position - p).dot(s.normal) < DEPTH * s.spacing;
            if close || shallow {
                return None;
            }
        }
        self.blocks.is_inside(self.surface, p).then_some(nearest.0.sqrt())
    }

    /// The points with their clearances, those that have none left out.
    fn clear(&self, points: &[DVec3]) -> Vec<(f64, DVec3)> {
        let found: Vec<Option<f64>> = points.par_iter().map(|&p| self.clearance(p)).collect();
        points.iter().zip(found).filter_map(|(&p, c)| Some((c?, p))).collect()
    }

    /// Points of a lattice, at most `count` of those that `wanted` lets through.
    fn lattice(&self, count: usize, wanted: &(impl Fn(DVec3) -> bool + Sync), rng: &mut Rng) -> Vec<DVec3> {
        let rotation = rng.rotation();
        let offset = rng.in_cube();
        let planned = CELL.cbrt() * self.spacing.largest;
        let densest = planned * if self.boundary.is_empty() { DENSEST_FREE } else { DENSEST };
        let points_at = |edge: f64| {
            let mut points = bcc_points(&self.bounds, rotation, offset, edge);
            points.iter_mut().enumerate().for_each(|(i, p)| *p = self.jittered(*p, edge, i, rng));
            points.retain(|&p| wanted(p));
            self.clear(&points)
        };
        // Counts follow the cube of the lattice's spacing, but for the boundary: a few steps of that rule, then the
        // finest lattice too coarse and the coarsest fine enough close in on each other.
        let (mut coarse, mut fine) = (f64::INFINITY, 0.0f64);
        let mut best: Option<Vec<(f64, DVec3)>> = None;
        let mut edge = planned;
        for _ in 0..24 {
            let points = points_at(edge);
            let n = points.len();
            let enough = n >= count;
            if enough {
                fine = fine.max(edge);
            } else {
                coarse = coarse.min(edge);
            }
            let better =
                best.as_ref().is_none_or(|b| if b.len() < count { n > b.len() } else { enough && n < b.len() });
            if better {
                best = Some(points);
            }
            if enough && n as f64 <= 1.01 * count as f64 + 1.0 || !enough && edge <= densest {
                break;
            }
            let guess = edge * ((n as f64 + 0.5) / (1.004 * count as f64 + 0.5)).cbrt().clamp(0.8, 1.25);
            edge = match (fine > 0.0, coarse.is_finite()) {
                (true, true) if guess <= fine * 1.0005 || guess >= coarse * 0.9995 => 0.5 * (fine + coarse),
                _ => guess,
            }
            .max(densest);
            if fine > 0.0 && coarse < fine * 1.0005 {
                break;
            }
        }
        let points = best.unwrap_or_default();
        // Nearest the boundary last; where none is nearer, at random, so that no side of the lattice is cut off.
        let mut points: Vec<(f64, u64, DVec3)> = points.into_iter().map(|(c, p)| (c, rng.bits(), p)).collect();
        points.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        points.truncate(count);
        points.into_iter().map(|(_, _, p)| p).collect()
    }

    /// `p`, moved by the jitter of the lattice's point `i`.
    fn jittered(&self, p: DVec3, edge: f64, i: usize, rng: &Rng) -> DVec3 {
        let mut rng = Rng::new(rng.clone().bits(), i as u64);
        let p = p + JITTER * edge * rng.in_cube();
        snap(p.clamp(self.bounds.min, self.bounds.max))
    }

    /// Uniform points in the solid, clear of the boundary: `count`, or as many as are found.
    fn uniform(&self, count: usize, rng: &mut Rng) -> Vec<DVec3> {
        let mut points = Vec::with_capacity(count);
        let mut trials = TRIALS * (count + 64);
        while points.len() < count && trials > 0 {
            let batch = (2 * (count - points.len()) + 64).min(trials);
            trials -= batch;
            let extent = self.bounds.extent();
            let tried: Vec<DVec3> = match &self.spacing.field {
                None => (0..batch).map(|_| snap(self.bounds.min + extent * (0.5 * rng.in_cube() + 0.5))).collect(),
                Some(field) => field.draw(batch, rng),
            };
            points.extend(self.clear(&tried).into_iter().map(|(_, p)| p));
        }
        points.truncate(count);
        points
    }

    fn blue_noise(&self, count: usize, rng: &mut Rng) -> Vec<DVec3> {
        let points = self.uniform(OVERSAMPLING * count, rng);
        self.thinned(points, &[], count)
    }

    /// At most `count` of `points`, apart from each other, from the boundary and from those `placed`.
    fn thinned(&self, points: Vec<DVec3>, placed: &[DVec3], count: usize) -> Vec<DVec3> {
        // Neighbours in space become neighbours in memory: elimination is bound by that.
        let points: Vec<DVec3> = hilbert_order(&points).into_iter().map(|i| points[i as usize]).collect();
        // Packed as densely as can be, points of cells of volume v are 1.1225 v^(1/3) apart.
        let spacing = |p| 1.1225 * CELL.cbrt() * self.spacing.at(p);
        let sample = |position| Sample { position, normal: DVec3::ZERO, spacing: spacing(position), group: 0 };
        let samples: Vec<Sample> = points.iter().map(|&p| sample(p)).collect();
        let bound = self.boundary.iter().map(|s| Sample { spacing: s.spacing, ..sample(s.position) });
        let fixed: Vec<Sample> = bound.chain(placed.iter().map(|&p| sample(p))).collect();
        eliminate(&samples, &fixed, count.min(points.len()), &[0]).into_iter().map(|i| points[i as usize]).collect()
    }

    /// A lattice where sizes are the largest, if that is much of the solid; blue noise elsewhere.
    fn partly_lattice(&self, count: usize, rng: &mut Rng) -> Vec<DVec3> {
        let even = |p: DVec3| self.spacing.relative(p) >= EVEN;
        let points = self.uniform(OVERSAMPLING * count, rng);
        let (flat, graded): (Vec<DVec3>, Vec<DVec3>) = points.iter().partition(|&&p| even(p));
        if (flat.len() as f64) < LATTICE * points.len() as f64 {
            return self.thinned(points, &[], count);
        }
        let share = flat.len() as f64 / points.len() as f64;
        let mut placed = self.lattice((share * count as f64).round() as usize, &even, rng);
        let others = self.thinned(graded, &placed, count - placed.len());
        placed.extend(others);
        placed
    }

    fn white_noise(&self, count: usize, rng: &mut Rng) -> Vec<DVec3> {
        let mut points: Vec<DVec3> = Vec::with_capacity(count);
        let distance = |p| WHITE_DISTANCE * self.spacing.at(p);
        // Each round thins old and new points together: a point stays if no earlier one that stays is too close.
        for _ in 0..20 {
            let missing = count - points.len();
            if missing == 0 {
                break;
            }
            let kept = points.len();
            points.extend(self.uniform(missing + missing / 8 + 1, rng));
            let distances: Vec<f64> = points.iter().map(|&p| distance(p)).collect();
            let grid = CellGrid::new(&points, typical(&distances));
            let mut stays = vec![true; points.len()];
            for i in kept..points.len() {
                let (mut free, distance) = (true, distances[i]);
                grid.near(points[i], distance, |j| {
                    let j = j as usize;
                    free &= j >= i || !stays[j] || points[i].distance_squared(points[j]) >= distance * distance;
                });
                stays[i] = free;
            }
            let mut stay = stays.iter();
            points.retain(|_| *stay.next().expect("one flag for each point: this is a bug in tetcvt"));
            points.truncate(count);
        }
        points
    }
}

/// The points within `bounds` of the body-centred cubic lattice with cells of volume `edge`^3, turned by `rotation` and
/// shifted by `offset` cells.
fn bcc_points(bounds: &BoundingBox, rotation: DMat3, offset: DVec3, edge: f64) -> Vec<DVec3> {
    // A cube of the lattice holds two points.
    let cube = edge * 2f64.cbrt();
    let center = bounds.center();
    let half = 0.5 * bounds.extent();
    let axes = [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(|a| a * cube);
    let reach = (bounds.diagonal() * 0.5 / cube).ceil() as i64 + 2;
    let mut points = Vec::new();
    for body in [0.0, 0.5] {
        let shift = offset + body;
        for i in -reach..=reach {
            for j in -reach..=reach {
                let start =
                    center + axes[0] * (i as f64 + shift.x) + axes[1] * (j as f64 + shift.y) + axes[2] * shift.z;
                let Some((first, last)) = clip_line(start - center, axes[2], half) else { continue };
                for k in first.ceil() as i64..=last.floor() as i64 {
                    points.push(start + axes[2] * k as f64);
                }
            }
        }
    }
    points
}

/// The parameters between which `start + t * direction` lies within `half` of the origin in each coordinate.
fn clip_line(start: DVec3, direction: DVec3, half: DVec3) -> Option<(f64, f64)> {
    let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
    for i in 0..3 {
        if direction[i] == 0.0 {
            if start[i].abs() > half[i] {
                return None;
            }
            continue;
        }
        let a = (-half[i] - start[i]) / direction[i];
        let b = (half[i] - start[i]) / direction[i];
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    (first <= last).then_some((first, last))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lattice_has_its_density_and_its_neighbours() {
        let bounds = BoundingBox { min: DVec3::new(-0.5, -0.4, 0.0), max: DVec3::new(0.5, 0.4, 0.3) };
        let edge: f64 = 0.04;
        let points = bcc_points(&bounds, Rng::new(5, 0).rotation(), DVec3::splat(0.3), edge);
        let wanted = 0.8 * 0.3 / edge.powi(3);
        assert!((points.len() as f64 / wanted - 1.0).abs() < 0.02, "{} of {wanted}", points.len());
        // Every point well inside has its 8 nearest neighbours at sqrt(3)/2 cubes: 1.0911 edges.
        let inner = |p: &DVec3| (*p - bounds.center()).abs().cmplt(0.5 * bounds.extent() - 0.06).all();
        for p in points.iter().filter(|p| inner(p)) {
            let near = points.iter().filter(|q| (q.distance(*p) / edge - 1.0911).abs() < 1e-3).count();
            assert_eq!(near, 8);
        }
    }
}
