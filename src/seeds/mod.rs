//! First seeds, in and on the surface: exactly as many as asked for, in one even spacing, or a finer one where walls are
//! thin.
//!
//! 1. Count: how many on creases, on the surface and inside (`counts`), thin walls included (`thickness`).
//! 2. Creases (`curves`), then the surface between them (`surface_sampling`), then the interior (`interior`).
//! 3. Number them along a Hilbert curve (`order`).
//!
//! Or else the points of an earlier mesh become the seeds (`initial`).

use std::sync::Arc;

use glam::DVec3;

use crate::error::Error;
use crate::geometry::bounding_box::BoundingBox;
use crate::params::{Boundary, MOST_SEEDS, Params, Target};
use crate::sizing::{MEAN_OVER_MEDIAN, Sizing, Spacing};
use crate::surface::Surface;
use crate::surface::features::Features;
use blocks::Blocks;
use counts::{Demand, Plan, Shortage, Size};
use grid::{CellGrid, typical};
use interior::Interior;
use surface_sampling::BoundarySeed;
use thickness::FLOOR;

pub use initial::InitialPoints;

mod blocks;

mod counts;

mod curves;

mod elimination;

mod grid;

pub mod initial;

mod interior;

mod knots;

mod networks;

mod order;

mod strips;

mod surface_sampling;

mod thickness;

/// Which part of the solid a seed belongs to; the value is the `kind` of the mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum SeedKind {
    /// Inside.
    Interior = 0,
    /// On the surface.
    Surface = 1,
    /// On a crease.
    Curve = 2,
    /// On a corner, never moving.
    Corner = 3,
}

/// Where a seed is bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// Nowhere.
    Interior,
    /// To the surface; the triangle that it lies on.
    Surface {
        /// Index of the triangle.
        triangle: u32,
    },
    /// To a crease.
    Curve {
        /// Index into [`Features::curves`].
        curve: u32,
        /// Arc length along the curve from its first vertex, in frame units.
        at: f64,
    },
    /// To a place on a crease where it bends.
    Knot {
        /// Index into [`Features::curves`].
        curve: u32,
        /// Arc length along the curve from its first vertex, in frame units.
        at: f64,
    },
    /// To a corner.
    Corner {
        /// The surface's vertex.
        vertex: u32,
    },
}

impl Anchor {
    /// The kind of a seed so bound.
    pub fn kind(&self) -> SeedKind {
        match self {
            Anchor::Interior => SeedKind::Interior,
            Anchor::Surface { .. } => SeedKind::Surface,
            Anchor::Curve { .. } | Anchor::Knot { .. } => SeedKind::Curve,
            Anchor::Corner { .. } => SeedKind::Corner,
        }
    }

    /// The crease that a seed so bound is on, but for corners.
    pub fn curve(&self) -> Option<u32> {
        match *self {
            Anchor::Curve { curve, .. } | Anchor::Knot { curve, .. } => Some(curve),
            _ => None,
        }
    }
}

/// Seeds in the frame, on its grid; no two alike. Those sampled are numbered along a Hilbert curve.
#[derive(Clone, Debug)]
pub struct Seeds {
    /// Positions.
    pub positions: Vec<DVec3>,
    /// Where each is bound.
    pub anchors: Vec<Anchor>,
    /// The edge length that one even spacing of this count gives, in frame units; where sizes vary, the largest.
    pub spacing: f64,
    /// Where sizes vary, what they are over the largest.
    pub sizing: Option<Arc<Sizing>>,
    /// For each vertex of the surface, the spacing wanted there over [`Seeds::spacing`]: 1, or less where a wall or a
    /// gap is thin.
    pub relative_size: Vec<f64>,
    /// Whether each seed is to stay where it is in the mesh, because somebody knows it by its number: no seed goes elsewhere
    /// unless a valid mesh needs it.
    pub keep_places: bool,
    /// For each crease, whether the mesh is to have it whole and close, however fine that is; not where it is noise.
    pub whole: Vec<bool>,
}

impl Seeds {
    /// The kind of each seed.
    pub fn kinds(&self) -> Vec<SeedKind> {
        self.anchors.iter().map(Anchor::kind).collect()
    }

    /// The spacing wanted over the solid.
    pub fn spacings(&self) -> Spacing {
        Spacing { largest: self.spacing, field: self.sizing.clone() }
    }

    /// The spacing wanted at a point.
    pub fn spacing_at(&self, p: DVec3) -> f64 {
        self.spacing * self.sizing.as_ref().map_or(1.0, |s| s.relative(p))
    }
}

/// Streams of random numbers, so that one stage's draws do not shift another's.
mod stream {
    pub(super) const THICKNESS: u64 = 1;
    pub(super) const SURFACE: u64 = 2;
    pub(super) const INTERIOR: u64 = 3;
    pub(super) const INITIAL: u64 = 4;
}

/// How much wider the spacing may get elsewhere for the sake of strips between creases.
const WIDER: f64 = 1.45;

/// Where it would get wider, limits are looser by these factors in turn.
const LOOSER: [f64; 5] = [1.0, 1.2, 1.45, 1.75, 2.1];

/// How often limits of thin walls are sought.
const THIN_ROUNDS: usize = 3;

/// How often the count that is said to do is measured again.
const HONEST_ROUNDS: usize = 16;

/// Places the first seeds: exactly as many as the parameters ask for.
///
/// # Errors
/// [`Error::TooFewSeeds`] where the count is too small for the surface's corners, creases, shells or thin walls;
/// [`Error::Parameter`] where edges are so short that they need more than [`MOST_SEEDS`].
pub fn sample(surface: &Surface, features: &Features, params: &Params) -> Result<Seeds, Error> {
    sample_sized(surface, features, params, sizing(surface, features, params)?)
}

/// The sizes that the parameters ask for.
///
/// # Errors
/// [`Error::Parameter`] as [`Sizing::new`] has it.
pub fn sizing(surface: &Surface, features: &Features, params: &Params) -> Result<Option<Arc<Sizing>>, Error> {
    let cap = match params.target {
        Target::Edge(l) => Some(l * surface.frame().scale),
        Target::RelativeEdge(share) => Some(share * surface.diagonal()),
        Target::Count(_) | Target::Sizes => None,
    };
    Sizing::new(surface, features, &params.sizes, cap)
}

/// The same as [`sample`] with sizes that are known already; they are nearly linear on each triangle of the surface.
///
/// # Errors
/// Those of [`sample`].
pub fn sample_sized(
    surface: &Surface,
    features: &Features,
    params: &Params,
    sizing: Option<Arc<Sizing>>,
) -> Result<Seeds, Error> {
    let mut seeds = match params.boundary {
        Boundary::Conform => conforming(surface, features, params, sizing)?,
        Boundary::Free => free(surface, params, sizing)?,
    };
    order::along_hilbert_curve(&mut seeds.positions, &mut seeds.anchors);
    Ok(seeds)
}

/// Seeds on corners, creases, the surface, and inside.
fn conforming(
    surface: &Surface,
    features: &Features,
    params: &Params,
    sizing: Option<Arc<Sizing>>,
) -> Result<Seeds, Error> {
    let (demand, mut plan, count) = planned(surface, features, params, sizing.as_deref())?;
    let edge = if sizing.is_some() { typical(&plan.sizes) } else { plan.spacing };
    let blocks = Blocks::new(surface, &BoundingBox::of(surface.points()), edge);
    let spacing = Spacing { largest: plan.spacing, field: sizing };
    // Where the walls are too thin for the interior seeds, these go on the surface.
    loop {
        let boundary = boundary_seeds(surface, features, (&demand, &plan), params.random_seed);
        let interior = Interior::new(surface, &blocks, &boundary, spacing.clone());
        let inside = interior.place(plan.interior, params.start, params.random_seed);
        if inside.len() < plan.interior {
            // A little less than had room: the boundary's seeds will not be the same.
            let room = inside.len() - inside.len() / 32;
            plan.surface += plan.interior - room;
            plan.interior = room;
            continue;
        }
        let anchors = boundary.iter().map(|s| s.anchor).chain(inside.iter().map(|_| Anchor::Interior)).collect();
        let positions: Vec<DVec3> = boundary.iter().map(|s| s.position).chain(inside).collect();
        debug_assert_eq!(positions.len(), count);
        let relative_size = plan.sizes.iter().map(|s| s / plan.spacing).collect();
        let Spacing { largest, field: sizing } = spacing;
        let (whole, keep_places) = (demand.whole(), false);
        return Ok(Seeds { positions, anchors, spacing: largest, sizing, relative_size, keep_places, whole });
    }
}

/// The plan for the run's target, thin walls seen to.
fn planned_for_walls<'a>(
    surface: &'a Surface,
    features: &'a Features,
    params: &Params,
    sizing: Option<&Sizing>,
) -> Result<(Demand<'a>, Plan, usize), Error> {
    let size = target(surface, params, sizing)?;
    let sized = (surface, features, sizing);
    let refuse = |count, shortage| too_few(surface, count, honest(sized, shortage, params.random_seed));
    let mut demand = Demand::measure(surface, features, sizing, size);
    let mut count = count_for(&demand, size)?;
    let mut plan = demand.plan(count).map_err(|s| refuse(count, s))?;
    // Limits are sought below the spacing at hand; seeds that thin walls take leave a larger one elsewhere, where more
    // may be thin.
    let mut sought = plan.spacing;
    for _ in 0..THIN_ROUNDS {
        let sizes = demand.plain_sizes(sought);
        demand.limit(&thickness::limits(surface, features, (&sizes, FLOOR), params.random_seed), sought);
        count = count_for(&demand, size)?;
        plan = match demand.plan(count) {
            Ok(plan) => plan,
            Err(shortage) => return Err(refuse(count, shortage)),
        };
        // Where seeds are scarce for the walls known already there is no use in looking for more.
        if plan.is_stretched || plan.spacing <= 1.1 * sought {
            break;
        }
        sought = plan.spacing;
    }
    Ok((demand, plan, count))
}

/// The surface with its triangles split where the spacing must follow creases that are close; none where it need not.
pub(crate) fn refined(surface: &Surface, features: &Features, params: &Params) -> Result<Option<Surface>, Error> {
    if params.boundary == Boundary::Free {
        return Ok(None);
    }
    let (demand, plan, _) = planned_for_walls(surface, features, params, None)?;
    Ok(if plan.is_stretched { None } else { strips::refined(surface, features, (demand.needs(), &plan)) })
}

/// The plan for the run's target, thin walls seen to, with seeds closer where creases are close, as far as that does not take too
/// many from elsewhere.
fn planned<'a>(
    surface: &'a Surface,
    features: &'a Features,
    params: &Params,
    sizing: Option<&Sizing>,
) -> Result<(Demand<'a>, Plan, usize), Error> {
    let (demand, plan, count) = planned_for_walls(surface, features, params, sizing)?;
    let sizes = demand.plain_sizes(plan.spacing);
    let limits = strips::limits(surface, features, (demand.needs(), &plan), &sizes);
    if plan.is_stretched || limits.iter().all(|l| l.is_infinite()) {
        return Ok((demand, plan, count));
    }
    for looser in LOOSER {
        let mut limits: Vec<f64> = limits.iter().map(|l| looser * l).collect();
        thickness::grade(surface, &mut limits, &sizes);
        let mut finer = demand.clone();
        finer.limit(&limits, plan.spacing);
        let count = count_for(&finer, target(surface, params, sizing)?)?;
        if let Ok(found) = finer.plan(count)
            && !found.is_stretched
            && found.spacing <= WIDER * plan.spacing
        {
            return Ok((finer, found, count));
        }
    }
    Ok((demand, plan, count))
}

fn target(surface: &Surface, params: &Params, sizing: Option<&Sizing>) -> Result<Size, Error> {
    Ok(match (params.target, sizing) {
        (Target::Count(n), _) => Size::Count(n),
        // Those of an edge are no longer than that.
        (_, Some(sizing)) => Size::Length(MEAN_OVER_MEDIAN * sizing.largest()),
        (Target::Edge(l), None) => Size::Length(l * surface.frame().scale),
        (Target::RelativeEdge(share), None) => Size::Length(share * surface.diagonal()),
        (Target::Sizes, None) => return Err(no_sizes()),
    })
}

/// A shortage was measured at a coarse spacing, at which fewer creases count and walls seem thicker: the count needed,
/// measured again at the spacing that it gives, until it would do.
fn honest(
    (surface, features, sizing): (&Surface, &Features, Option<&Sizing>),
    mut shortage: Shortage,
    random_seed: u64,
) -> Shortage {
    for _ in 0..HONEST_ROUNDS {
        let mut demand = Demand::measure(surface, features, sizing, Size::Count(shortage.needed));
        let outcome = demand.plan(shortage.needed).and_then(|_| {
            let sought = demand.plain_spacing(shortage.needed);
            let sizes = demand.plain_sizes(sought);
            demand.limit(&thickness::limits(surface, features, (&sizes, FLOOR), random_seed), sought);
            demand.plan(shortage.needed)
        });
        let Err(next) = outcome else { break };
        let needed = next.needed.max(shortage.needed + shortage.needed / 8);
        // The first shortage is the one to tell of; but what is thin is known better now.
        shortage = if shortage.thin {
            Shortage { needed, vertex: shortage.vertex, ..next }
        } else {
            Shortage { needed, ..shortage }
        };
    }
    shortage
}

/// How many seeds would do for the thin walls and narrow gaps of a surface for which `count` did not: for all of them, while a
/// run leaves those that are very thin for its count to what mends the restricted surface.
pub fn enough_for_walls(
    surface: &Surface,
    features: &Features,
    sizing: Option<&Sizing>,
    (count, random_seed): (usize, u64),
) -> usize {
    let mut demand = Demand::measure(surface, features, sizing, Size::Count(count));
    let sought = demand.plain_spacing(count);
    let sizes = demand.plain_sizes(sought);
    demand.limit(&thickness::limits(surface, features, (&sizes, 0.0), random_seed), sought);
    demand.enough_for_limits().min(MOST_SEEDS)
}

fn too_few(surface: &Surface, count: usize, shortage: Shortage) -> Error {
    Error::TooFewSeeds {
        count,
        needed: shortage.needed.max(count + 1),
        reason: shortage.reason,
        place: surface.frame().to_model(surface.points()[shortage.vertex as usize]).to_array(),
    }
}

/// What [`Params::validate`] refuses.
fn no_sizes() -> Error {
    let reason = "there are no sizes for the number of vertices to follow from".to_owned();
    Error::Parameter { option: "size-field", reason }
}

fn count_for(demand: &Demand, size: Size) -> Result<usize, Error> {
    match size {
        Size::Count(n) => Ok(n),
        Size::Length(h) => checked_count(demand.count_for(h), demand.is_even()),
    }
}

fn checked_count(count: f64, even: bool) -> Result<usize, Error> {
    if count <= MOST_SEEDS as f64 {
        return Ok(count as usize);
    }
    let reason = format!("edges so short need more than {MOST_SEEDS} vertices");
    Err(Error::Parameter { option: if even { "edge" } else { "size-field" }, reason })
}

/// Seeds on corners, creases and the surface.
fn boundary_seeds(
    surface: &Surface,
    features: &Features,
    (demand, plan): (&Demand, &Plan),
    random_seed: u64,
) -> Vec<BoundarySeed> {
    let (mut seeds, dropped) = line_seeds(surface, features, (demand, plan));
    surface_sampling::add_surface_seeds(surface, features, (demand, plan), dropped, random_seed, &mut seeds);
    seeds
}

/// Seeds on corners and creases, and how many of the plan's were one too many.
fn line_seeds(surface: &Surface, features: &Features, (demand, plan): (&Demand, &Plan)) -> (Vec<BoundarySeed>, usize) {
    let on_corner = |&v: &u32| BoundarySeed {
        position: surface.points()[v as usize],
        anchor: Anchor::Corner { vertex: v },
        normal: DVec3::ZERO,
        spacing: plan.sizes[v as usize],
    };
    let mut seeds: Vec<BoundarySeed> = demand.corners().iter().map(on_corner).collect();
    for (i, knots) in (0..).zip(&plan.curves) {
        let curve = &features.curves[i as usize];
        let spacing = |v: u32| plan.sizes[v as usize];
        seeds.extend(curves::place(surface, curve, i, knots, spacing));
    }
    let dropped = drop_crowded(demand, plan, &mut seeds);
    (seeds, dropped)
}

/// Takes out seeds of creases that crowd a corner or another crease's seed, and says how many. Creases keep the least
/// that they need.
fn drop_crowded(demand: &Demand, plan: &Plan, seeds: &mut Vec<BoundarySeed>) -> usize {
    let positions: Vec<DVec3> = seeds.iter().map(|s| s.position).collect();
    let spacings: Vec<f64> = seeds.iter().map(|s| s.spacing).collect();
    let cell = if demand.is_even() { plan.spacing } else { typical(&spacings) };
    let grid = CellGrid::new(&positions, 0.5 * cell);
    let mut left: Vec<usize> = plan.curves.iter().map(Vec::len).collect();
    let mut stays = vec![true; seeds.len()];
    for (i, s) in seeds.iter().enumerate() {
        let Some(curve) = s.anchor.curve() else { continue };
        let curve = curve as usize;
        let need = demand.needs()[curve];
        if left[curve] <= need.least {
            continue;
        }
        // Where a crease that is to be whole bends its own seeds are close.
        let is_own = |j: usize| need.whole && seeds[j].anchor.curve() == s.anchor.curve();
        let reach = curves::crowded(need.whole) * s.spacing;
        let mut crowded = false;
        grid.near(s.position, reach, |j| {
            let earlier = (j as usize) < i && stays[j as usize];
            crowded |= earlier && !is_own(j as usize) && positions[j as usize].distance(s.position) < reach;
        });
        if crowded {
            stays[i] = false;
            left[curve] -= 1;
        }
    }
    let before = seeds.len();
    let mut stay = stays.iter();
    seeds.retain(|_| *stay.next().expect("one flag for each seed: this is a bug in tetcvt"));
    before - seeds.len()
}

/// Seeds inside alone.
fn free(surface: &Surface, params: &Params, sizing: Option<Arc<Sizing>>) -> Result<Seeds, Error> {
    // With sizes over the largest to the power of -3.
    let volume = sizing.as_ref().map_or(surface.volume(), |s| s.inverse_cubes(surface));
    let count_at = |h: f64| checked_count((volume / (counts::CELL * h * h * h)).round().max(4.0), sizing.is_none());
    let count = match (params.target, &sizing) {
        (Target::Count(n), _) => n,
        (_, Some(sizing)) => count_at(MEAN_OVER_MEDIAN * sizing.largest())?,
        (Target::Edge(l), None) => count_at(l * surface.frame().scale)?,
        (Target::RelativeEdge(share), None) => count_at(share * surface.diagonal())?,
        (Target::Sizes, None) => return Err(no_sizes()),
    };
    let largest = (volume / (counts::CELL * count as f64)).cbrt();
    let spacing = Spacing { largest, field: sizing };
    let relative_size: Vec<f64> = surface.points().iter().map(|&p| spacing.relative(p)).collect();
    let blocks = Blocks::new(surface, &BoundingBox::of(surface.points()), largest * typical(&relative_size));
    let interior = Interior::new(surface, &blocks, &[], spacing.clone());
    let positions = interior.place(count, params.start, params.random_seed);
    if positions.len() < count {
        return Err(Error::TooFewSeeds {
            count,
            needed: 2 * count,
            reason: "the solid is too thin for seeds inside it alone".to_owned(),
            place: surface.frame().to_model(surface.points()[0]).to_array(),
        });
    }
    let anchors = vec![Anchor::Interior; count];
    let (sizing, whole, keep_places) = (spacing.field, Vec::new(), false);
    Ok(Seeds { positions, anchors, spacing: largest, sizing, relative_size, keep_places, whole })
}
