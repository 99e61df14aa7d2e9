//! Seeds out of points that are there, those of an earlier mesh: point i becomes seed i, and so vertex i.
//!
//! The surface may have moved since. Each point keeps its part of the solid as far as it can:
//!
//! 1. Corners and places on creases are planned as for any run; each takes a point near it, of the same kind before others.
//!    On a crease the point goes to its own closest place, if that is about the planned one.
//! 2. Further points of the boundary go to the closest place of the surface. Where kinds are not known, those close to
//!    the surface count as such.
//! 3. The rest are inside; those that the surface left outside, or just under it, are brought below it, or onto it where
//!    there is no room.
//! 4. Points that came to lie on top of each other are moved apart.
//!
//! Cost: a closest point and an inside test for each point; step 1 sorts the points near corners and creases.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::counts::CELL;
use super::grid::CellGrid;
use super::surface_sampling::BoundarySeed;
use super::{Anchor, SeedKind, Seeds, line_seeds, planned, stream};
use crate::error::Error;
use crate::geometry::frame::snap;
use crate::params::{Boundary, MOST_SEEDS, Params, Target};
use crate::rng::Rng;
use crate::sizing::{Sizing, Spacing};
use crate::surface::Surface;
use crate::surface::box_tree::Closest;
use crate::surface::features::Features;

/// Corners and creases first ask points within so many spacings.
const REACH: f64 = 1.5;

/// A point on a crease goes to its own closest place if that is within so many spacings of the planned one.
const OWN_PLACE: f64 = 0.35;

/// Points of unknown kind that are closer to the surface than this share of the spacing are on it.
const CLOSE: f64 = 0.25;

/// Points inside are at least so many spacings deep; those that are not are brought to the second depth.
const SHALLOW: f64 = 0.15;
const DEPTH: f64 = 0.4;

/// Points closer to another than this share of the spacing are moved, so far at most.
const APART: f64 = 0.1;
const AWAY: f64 = 0.3;

/// How often that is tried.
const PARTING_ROUNDS: usize = 20;

/// Points that become the seeds, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InitialPoints {
    /// In the coordinates of the model.
    pub points: Vec<DVec3>,
    /// The part of the solid that each belonged to; empty where that is not known.
    pub kinds: Vec<SeedKind>,
}

impl InitialPoints {
    /// Refuses what no run could start from.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn validate(&self) -> Result<(), Error> {
        let n = self.points.len();
        if !(4..=MOST_SEEDS).contains(&n) {
            return refuse(format!("it has {n} points, not between 4 and {MOST_SEEDS}"));
        }
        if !self.kinds.is_empty() && self.kinds.len() != n {
            return refuse(format!("it has {n} points but {} kinds", self.kinds.len()));
        }
        match self.points.iter().position(|p| !p.is_finite()) {
            Some(i) => refuse(format!("point {i} is not finite")),
            None => Ok(()),
        }
    }
}

fn refuse<T>(reason: String) -> Result<T, Error> {
    Err(Error::Parameter { option: "init", reason })
}

/// Makes the points seeds of `surface`, in their order.
///
/// # Errors
/// [`Error::Parameter`] where the count is not the one of the parameters, or the points are no mesh of a surface near this
/// one; [`Error::TooFewSeeds`] as for any seeds.
pub fn from_points(
    surface: &Surface,
    features: &Features,
    initial: &InitialPoints,
    params: &Params,
    sizing: Option<Arc<Sizing>>,
) -> Result<Seeds, Error> {
    initial.validate()?;
    let n = initial.points.len();
    if params.target != Target::Count(n) {
        let reason = format!("the mesh to start from has {n} points, and all of them become vertices");
        return Err(Error::Parameter { option: "seeds", reason });
    }
    let positions = in_frame(surface, &initial.points);
    match params.boundary {
        Boundary::Conform => {
            let (demand, plan, _) = planned(surface, features, params, sizing.as_deref())?;
            let (sites, _) = line_seeds(surface, features, (&demand, &plan));
            let mut binding = Binding::new(surface, &plan.sizes, plan.spacing, positions, &initial.kinds)?;
            binding.take_sites(features, &sites);
            binding.settle(Boundary::Conform);
            binding.part(params)?;
            let relative_size = plan.sizes.iter().map(|s| s / plan.spacing).collect();
            let spacing = Spacing { largest: plan.spacing, field: sizing };
            Ok(binding.into_seeds(spacing, relative_size, demand.whole()))
        }
        Boundary::Free => {
            let volume = sizing.as_ref().map_or(surface.volume(), |s| s.inverse_cubes(surface));
            let largest = (volume / (CELL * n as f64)).cbrt();
            let spacing = Spacing { largest, field: sizing };
            let sizes: Vec<f64> = surface.points().iter().map(|&p| spacing.at(p)).collect();
            let kinds = vec![SeedKind::Interior; n];
            let mut binding = Binding::new(surface, &sizes, largest, positions, &kinds)?;
            binding.settle(Boundary::Free);
            binding.part(params)?;
            let relative_size = sizes.iter().map(|s| s / largest).collect();
            Ok(binding.into_seeds(spacing, relative_size, Vec::new()))
        }
    }
}

/// The points in the surface's frame; those far outside at its border.
fn in_frame(surface: &Surface, points: &[DVec3]) -> Vec<DVec3> {
    let frame = surface.frame();
    let half = DVec3::splat(0.5);
    points.iter().map(|&p| snap(((p - frame.shift) * frame.scale).clamp(-half, half))).collect()
}

/// Points on their way to being seeds.
struct Binding<'a> {
    surface: &'a Surface,
    /// Spacing at each vertex of the surface.
    sizes: &'a [f64],
    positions: Vec<DVec3>,
    /// Empty where not known.
    kinds: &'a [SeedKind],
    /// Closest points of the surface, where the points were given.
    closest: Vec<Closest>,
    inside: Vec<bool>,
    /// The spacing wanted around each.
    size: Vec<f64>,
    /// Where each is bound, once that is known.
    anchors: Vec<Option<Anchor>>,
}

impl<'a> Binding<'a> {
    fn new(
        surface: &'a Surface,
        sizes: &'a [f64],
        spacing: f64,
        positions: Vec<DVec3>,
        kinds: &'a [SeedKind],
    ) -> Result<Binding<'a>, Error> {
        let tree = surface.tree();
        let closest: Vec<Closest> = positions.par_iter().map(|&p| tree.closest(p)).collect();
        let inside: Vec<bool> = positions.par_iter().map(|&p| surface.is_inside(p)).collect();
        let far = |(c, inside): &(&Closest, &bool)| !**inside && c.distance2 > spacing * spacing;
        let strays = closest.iter().zip(&inside).filter(far).count();
        if 2 * strays > positions.len() {
            return refuse(format!(
                "{strays} of its {} points are outside the surface by more than the {:.3e} between vertices: it is no mesh of a \
                 surface near this one",
                positions.len(),
                surface.frame().length_to_model(spacing)
            ));
        }
        let anchors = vec![None; positions.len()];
        let mut binding = Binding { surface, sizes, positions, kinds, closest, inside, size: Vec::new(), anchors };
        binding.size = binding.closest.iter().map(|c| binding.size_at(c.triangle)).collect();
        Ok(binding)
    }

    /// The spacing wanted on a triangle.
    fn size_at(&self, triangle: u32) -> f64 {
        self.surface.triangles()[triangle as usize].iter().map(|&v| self.sizes[v as usize]).sum::<f64>() / 3.0
    }

    /// How well point `i` suits a place of a corner or crease: its distance, the longer the less its kind fits.
    fn cost(&self, site: &BoundarySeed, i: usize) -> f64 {
        let unlike = |k: &SeedKind| (*k as u8).abs_diff(site.anchor.kind() as u8);
        let unlike = self.kinds.get(i).map_or(0, unlike);
        site.position.distance(self.positions[i]) * (1.0 + 0.5 * f64::from(unlike))
    }

    /// Step 1.
    fn take_sites(&mut self, features: &Features, sites: &[BoundarySeed]) {
        let widest = sites.iter().map(|s| s.spacing).fold(0.0, f64::max);
        let grid = CellGrid::new(&self.positions, widest);
        let near = |(s, site): (usize, &BoundarySeed)| {
            let mut found: Vec<(f64, usize, usize)> = Vec::new();
            grid.near(site.position, REACH * site.spacing, |i| {
                found.push((self.cost(site, i as usize), s, i as usize))
            });
            found
        };
        let mut pairs: Vec<(f64, usize, usize)> = sites.iter().enumerate().flat_map(near).collect();
        pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut taken = vec![false; sites.len()];
        for (_, s, i) in pairs {
            if !taken[s] && self.anchors[i].is_none() {
                taken[s] = true;
                self.bind(features, &sites[s], i);
            }
        }
        // Where none is left nearby, whichever comes first.
        for s in (0..sites.len()).filter(|&s| !taken[s]) {
            let free = (0..self.positions.len()).filter(|&i| self.anchors[i].is_none());
            let best = free.min_by(|&i, &j| self.cost(&sites[s], i).total_cmp(&self.cost(&sites[s], j)));
            let i = best.expect("the plan has no more places than points: this is a bug in tetcvt");
            self.bind(features, &sites[s], i);
        }
    }

    /// Binds point `i` to a corner or crease.
    fn bind(&mut self, features: &Features, site: &BoundarySeed, i: usize) {
        let (mut position, mut anchor) = (site.position, site.anchor);
        if let Anchor::Curve { curve, at } = site.anchor {
            let line = &features.curves[curve as usize];
            let (own, _) = line.closest(self.positions[i], self.surface.points());
            if (own - at).abs() < OWN_PLACE * site.spacing {
                position = snap(line.point_at(own, self.surface.points()));
                anchor = Anchor::Curve { curve, at: own };
            }
        }
        (self.positions[i], self.anchors[i], self.size[i]) = (position, Some(anchor), site.spacing);
    }

    /// Steps 2 and 3.
    fn settle(&mut self, boundary: Boundary) {
        let settled: Vec<(DVec3, Anchor)> = (0..self.positions.len())
            .into_par_iter()
            .map(|i| match (self.anchors[i], self.kinds.get(i)) {
                (Some(anchor), _) => (self.positions[i], anchor),
                (None, Some(SeedKind::Interior)) => self.inside(i, boundary),
                (None, None) if self.closest[i].distance2.sqrt() >= CLOSE * self.size[i] => self.inside(i, boundary),
                (None, _) => on_surface(&self.closest[i]),
            })
            .collect();
        for (i, (position, anchor)) in settled.into_iter().enumerate() {
            (self.positions[i], self.anchors[i]) = (position, Some(anchor));
        }
    }

    /// Where point `i` goes inside, or on the surface where there is no room.
    fn inside(&self, i: usize, boundary: Boundary) -> (DVec3, Anchor) {
        let (p, closest, size) = (self.positions[i], &self.closest[i], self.size[i]);
        if self.inside[i] && closest.distance2.sqrt() >= SHALLOW * size {
            return (p, Anchor::Interior);
        }
        let outward = self.surface.normal2(closest.triangle).normalize_or_zero();
        // From an interface there are two ways in: the point stays on its side.
        let in_front = self.surface.is_interface(closest.triangle) && (p - closest.point).dot(outward) > 0.0;
        let below = snap(closest.point + outward * if in_front { DEPTH * size } else { -DEPTH * size });
        let tree = self.surface.tree();
        let has_room = self.surface.is_inside(below) && tree.closest(below).distance2.sqrt() >= SHALLOW * size;
        match boundary {
            _ if has_room => (below, Anchor::Interior),
            _ if self.inside[i] => (p, Anchor::Interior),
            Boundary::Conform => on_surface(closest),
            Boundary::Free => (snap(closest.point), Anchor::Interior),
        }
    }

    /// Step 4: of two that are too close the one that is bound less moves, of two alike the later.
    fn part(&mut self, params: &Params) -> Result<(), Error> {
        let mut rng = Rng::new(params.random_seed, stream::INITIAL);
        for _ in 0..PARTING_ROUNDS {
            let crowded = self.crowded(APART);
            if crowded.is_empty() {
                return Ok(());
            }
            for (i, _) in crowded {
                let there = snap(self.positions[i] + rng.in_cube() * AWAY * self.size[i]);
                match self.anchors[i] {
                    Some(Anchor::Surface { .. }) => {
                        let (position, anchor) = on_surface(&self.surface.tree().closest(there));
                        (self.positions[i], self.anchors[i]) = (position, Some(anchor));
                    }
                    _ if self.surface.is_inside(there) => self.positions[i] = there,
                    _ => {}
                }
            }
        }
        // Close together they may stay; in one place they may not.
        match self.crowded(0.0).first() {
            None => Ok(()),
            Some(&(i, j)) => {
                let [x, y, z] = self.surface.frame().to_model(self.positions[i]).to_array();
                refuse(format!("its points {j} and {i} fall on one place, ({x}, {y}, {z}), and cannot be parted there"))
            }
        }
    }

    /// Points that may move and are within so many spacings of one that has the older right, with that one.
    fn crowded(&self, share: f64) -> Vec<(usize, usize)> {
        let rank = |i: usize| match self.anchors[i] {
            Some(Anchor::Corner { .. } | Anchor::Knot { .. } | Anchor::Curve { .. }) => 0,
            Some(Anchor::Surface { .. }) => 1,
            _ => 2,
        };
        let widest = self.size.iter().copied().fold(0.0, f64::max);
        let grid = CellGrid::new(&self.positions, APART * widest);
        let movable = (0..self.positions.len()).into_par_iter().filter(|&i| share == 0.0 || rank(i) > 0);
        movable
            .filter_map(|i| {
                let reach = share * self.size[i];
                let mut other = None;
                grid.near(self.positions[i], reach, |j| {
                    let j = j as usize;
                    let near = self.positions[j].distance(self.positions[i]) <= reach;
                    if near && (rank(j), j) < (rank(i), i) {
                        other = Some(j);
                    }
                });
                other.map(|j| (i, j))
            })
            .collect()
    }

    fn into_seeds(self, spacing: Spacing, relative_size: Vec<f64>, whole: Vec<bool>) -> Seeds {
        let bound = |a: Option<Anchor>| a.expect("every point is settled: this is a bug in tetcvt");
        let anchors = self.anchors.into_iter().map(bound).collect();
        let Spacing { largest, field: sizing } = spacing;
        let positions = self.positions;
        Seeds { positions, anchors, spacing: largest, sizing, relative_size, keep_places: true, whole }
    }
}

fn on_surface(closest: &Closest) -> (DVec3, Anchor) {
    (snap(closest.point), Anchor::Surface { triangle: closest.triangle })
}
