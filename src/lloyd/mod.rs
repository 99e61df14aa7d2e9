//! Moves seeds to a centroidal Voronoi tessellation of the solid.
//!
//! Lloyd's iteration (Du, Faber, Gunzburger, *Centroidal Voronoi Tessellations: Applications and Algorithms*, SIAM Review
//! 41(4), 1999, doi 10.1137/S0036144599352836), for each kind of seed within its own part of the solid:
//!
//! 1. Clip the Voronoi cells by the surface.
//! 2. An interior seed's target is the centroid of its cell; a surface seed's that of its piece of the surface, brought
//!    back onto the surface; a curve seed's the middle of its piece of the crease; corners stay.
//! 3. Move, and triangulate again.
//!
//! Departure: an interior seed whose cell reaches the surface fills a gap between surface seeds, and becomes one.
//! With [`Boundary::Free`](crate::params::Boundary) every seed is an interior one, and the CVT energy never rises.

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use crate::clipped_voronoi::{Cell, ClippedVoronoi, Clipper, Density};
use crate::delaunay::{Delaunay, DelaunayError, Relocation};
use crate::error::Error;
use crate::geometry::frame::snap;
use crate::params::{Boundary, Params, Update};
use crate::progress::{Flow, Observer, Step};
use crate::seeds::{Anchor, Seeds};
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::tet_mesh::StageTimes;

mod creases;

use creases::Guard;

/// An interior seed that owns more than this share of a surface seed's mean area becomes a surface seed.
const ADOPTED_AREA: f64 = 0.1;

/// No part of the surface is asked to be sampled finer than this share of the spacing.
const LEAST_SIZE: f64 = 0.05;

/// Stretches of creases below twice this share of the spacing are not split.
const LEAST_STRETCH: f64 = 0.1;

/// Seeds on their way to a centroidal Voronoi tessellation.
pub struct Relaxation<'a> {
    surface: &'a Surface,
    features: &'a Features,
    params: &'a Params,
    seeds: Seeds,
    delaunay: Delaunay,
    clipper: Clipper<'a>,
    clipped: ClippedVoronoi,
    steps: Vec<Step>,
    times: StageTimes,
}

/// Why an iteration was the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// As many as were asked for.
    Iterations,
    /// The energy fell by less than the tolerance.
    Tolerance,
    /// The caller said so.
    Caller,
}

impl<'a> Relaxation<'a> {
    /// Triangulates the first seeds and clips their cells.
    pub fn new(
        surface: &'a Surface,
        features: &'a Features,
        params: &'a Params,
        seeds: Seeds,
    ) -> Result<Relaxation<'a>, Error> {
        let mut times = StageTimes::default();
        let started = Instant::now();
        let delaunay = Delaunay::build(&seeds.positions)?;
        times.build = started.elapsed().as_secs_f64();
        let mut clipper = Clipper::new(surface);
        clipper.set_density(density(&seeds.relative_size));
        let started = Instant::now();
        let clipped = clipper.clip(&delaunay);
        times.centroids = started.elapsed().as_secs_f64();
        Ok(Relaxation { surface, features, params, seeds, delaunay, clipper, clipped, steps: Vec::new(), times })
    }

    /// At most so many iterations, until the energy settles or the caller stops.
    pub fn run(&mut self, iterations: usize, observer: &mut dyn Observer) -> Result<Stopped, Error> {
        for _ in 0..iterations {
            let before = self.clipped.energy();
            let targets = self.targets();
            if self.move_to(targets, observer)? == Flow::Stop {
                return Ok(Stopped::Caller);
            }
            let fall = before - self.clipped.energy();
            // While surface seeds settle the energy may rise; that is no rest.
            if fall.abs() < self.params.tolerance * before {
                return Ok(Stopped::Tolerance);
            }
        }
        Ok(Stopped::Iterations)
    }

    /// Moves every seed to its new place, follows with the triangulation and the cells, and tells the observer.
    pub fn move_to(&mut self, targets: Vec<(DVec3, Anchor)>, observer: &mut dyn Observer) -> Result<Flow, Error> {
        let energy = self.clipped.energy();
        let started = Instant::now();
        let (max_move, relocation) = self.relocate(targets)?;
        let update_s = started.elapsed().as_secs_f64();

        let started = Instant::now();
        self.clipped = self.clipper.clip(&self.delaunay);
        let centroids_s = started.elapsed().as_secs_f64();
        self.times.update += update_s;
        self.times.centroids += centroids_s;
        if self.params.check {
            self.check()?;
        }

        let frame = self.surface.frame();
        let step = Step {
            energy: energy / frame.scale.powi(5),
            max_move: frame.length_to_model(max_move),
            update_s,
            centroids_s,
            tets: self.delaunay.tets().count(),
            bicells: 2 * self.delaunay.vertices().len(),
            bicells_failed: relocation.bicells_failed,
            predicates: relocation.predicates,
            flips: relocation.flips,
            reversed: relocation.reversed,
            held_back: relocation.held_back,
            rebuilt: relocation.rebuilt,
            ..Step::default()
        };
        self.steps.push(step);
        Ok(observer.seeds(Some(&step), &self.seeds.positions, frame))
    }

    /// Follows the moved seeds with the triangulation; a seed that would fall on another keeps its place. Returns the
    /// longest way that a seed went.
    fn relocate(&mut self, mut targets: Vec<(DVec3, Anchor)>) -> Result<(f64, Relocation), Error> {
        loop {
            let positions: Vec<DVec3> = targets.iter().map(|t| t.0).collect();
            let updated = match self.params.update {
                Update::Bicell => self.delaunay.relocate(&positions),
                Update::Rebuild => Delaunay::build(&positions).map(|built| {
                    self.delaunay = built;
                    Relocation { rebuilt: true, ..Relocation::default() }
                }),
            };
            match updated {
                Ok(relocation) => {
                    let moves = positions.iter().zip(&self.seeds.positions).map(|(a, b)| a.distance(*b));
                    let longest = moves.fold(0.0, f64::max);
                    self.seeds.positions = positions;
                    self.seeds.anchors = targets.into_iter().map(|t| t.1).collect();
                    return Ok((longest, relocation));
                }
                Err(DelaunayError::Duplicates { first, second, .. }) => {
                    for i in [first, second] {
                        targets[i] = (self.seeds.positions[i], self.seeds.anchors[i]);
                    }
                }
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Where each seed goes, and what it is bound to there.
    fn targets(&self) -> Vec<(DVec3, Anchor)> {
        let mut targets: Vec<(DVec3, Anchor)> = (0..self.seeds.positions.len())
            .into_par_iter()
            .map(|i| {
                let (at, cell) = (self.seeds.positions[i], &self.clipped.cells[i]);
                match self.seeds.anchors[i] {
                    Anchor::Interior => self.interior_target(at, cell),
                    Anchor::Surface { triangle } => self.surface_target(at, triangle, cell),
                    fixed => (at, fixed),
                }
            })
            .collect();
        if self.params.boundary == Boundary::Conform {
            self.settle_creases(&mut targets);
        }
        targets
    }

    /// Moves the seeds of creases, and those of the surface out of their way.
    fn settle_creases(&self, targets: &mut [(DVec3, Anchor)]) {
        let anchors = &self.seeds.anchors;
        let chains = creases::chains(self.features, anchors);
        for (i, at, anchor) in chains.iter().flat_map(|c| c.targets(self.features, self.surface, anchors)) {
            targets[i as usize] = (snap(at), anchor);
        }
        let guard = Guard::new(&chains, self.features, anchors.len());
        let position = |p: u32| targets[p as usize].0;
        let pushed: Vec<Option<(DVec3, Anchor)>> = targets
            .par_iter()
            .enumerate()
            .map(|(i, target)| match target.1 {
                Anchor::Surface { .. } => {
                    guard.push_out(target.0, self.clipped.adjacency.of(i), position).map(|p| self.onto_surface(p))
                }
                _ => None,
            })
            .collect();
        for (target, pushed) in targets.iter_mut().zip(pushed) {
            *target = pushed.unwrap_or(*target);
        }
    }

    /// The centroid of the clipped cell; in a gap of the surface, a place on it.
    fn interior_target(&self, at: DVec3, cell: &Cell) -> (DVec3, Anchor) {
        if self.params.boundary == Boundary::Conform && cell.area > ADOPTED_AREA * self.surface_seed_area() {
            return self.onto_surface(at + cell.area_moment / cell.area_mass);
        }
        if cell.volume > 0.0 {
            (snap(at + cell.moment / cell.volume), Anchor::Interior)
        } else {
            (at, Anchor::Interior)
        }
    }

    /// The centroid of the piece of the surface, brought back onto it.
    fn surface_target(&self, at: DVec3, triangle: u32, cell: &Cell) -> (DVec3, Anchor) {
        if cell.area_mass > 0.0 {
            self.onto_surface(at + cell.area_moment / cell.area_mass)
        } else {
            (at, Anchor::Surface { triangle })
        }
    }

    /// The closest point of the surface.
    fn onto_surface(&self, at: DVec3) -> (DVec3, Anchor) {
        let closest = self.surface.tree().closest(at);
        (snap(closest.point), Anchor::Surface { triangle: closest.triangle })
    }

    /// Area of a hexagon at the even spacing.
    fn surface_seed_area(&self) -> f64 {
        0.866 * self.seeds.spacing * self.seeds.spacing
    }

    /// Every invariant that must hold between iterations.
    fn check(&self) -> Result<(), Error> {
        self.delaunay.check().map_err(Error::Broken)?;
        let volume: f64 = self.clipped.cells.iter().map(|c| c.volume).sum();
        let area: f64 = self.clipped.cells.iter().map(|c| c.area).sum();
        for (what, sum, whole) in [("volumes", volume, self.surface.volume()), ("areas", area, self.surface.area())] {
            if (sum - whole).abs() > 1e-12 * whole {
                return Err(Error::Broken(format!("the cells' {what} sum to {sum}, not to {whole}")));
            }
        }
        Ok(())
    }

    /// Asks for a finer spacing around some places from now on: so much at each, and half of the distance more around it.
    pub fn refine_density(&mut self, places: &[(DVec3, f64)]) {
        let spacing = self.seeds.spacing;
        for &(place, finest) in places {
            let reach = DVec3::splat(2.0 * (spacing - finest).max(0.0));
            let relative = &mut self.seeds.relative_size;
            self.surface.tree().near_box(place - reach, place + reach, |t| {
                for v in self.surface.triangles()[t as usize] {
                    let away = self.surface.points()[v as usize].distance(place);
                    let size = (finest + 0.5 * away) / spacing;
                    let wanted = &mut relative[v as usize];
                    *wanted = if size < *wanted { size.max(LEAST_SIZE) } else { *wanted };
                }
            });
        }
        self.clipper.set_density(density(&self.seeds.relative_size));
    }

    /// Places for seeds in the middle of the stretches of creases that are no edges of the mesh, as `is_edge` has it: each
    /// with its anchor and the distance to the seeds before and after.
    pub(crate) fn crease_splits(&self, is_edge: impl Fn(u32, u32) -> bool) -> Vec<(DVec3, Anchor, f64)> {
        let least = LEAST_STRETCH * self.seeds.spacing;
        let chains = creases::chains(self.features, &self.seeds.anchors);
        let splits = chains.iter().flat_map(|c| c.splits(self.features, self.surface, &is_edge));
        splits
            .map(|(place, anchor, ends)| {
                let size =
                    ends.map(|e| self.seeds.positions[e as usize].distance(place)).into_iter().fold(0.0, f64::max);
                (place, anchor, size)
            })
            .filter(|&(_, _, size)| size > least)
            .collect()
    }

    /// The seeds as they are now.
    pub fn seeds(&self) -> &Seeds {
        &self.seeds
    }

    /// Their triangulation.
    pub fn delaunay(&self) -> &Delaunay {
        &self.delaunay
    }

    /// Their cells.
    pub fn clipped(&self) -> &ClippedVoronoi {
        &self.clipped
    }

    /// Iterations made so far.
    pub fn iterations(&self) -> usize {
        self.steps.len()
    }

    /// Seconds spent on moving so far: the triangulation's and the cells'.
    pub fn moving_time(&self) -> f64 {
        self.times.update + self.times.centroids
    }

    /// What each iteration did so far, and where the time went.
    pub fn into_record(self) -> (Vec<Step>, StageTimes) {
        (self.steps, self.times)
    }
}

/// The density of the surface that spaces seeds on it like `sizes`: 1/s^4 (Du, Wang, *Grid generation and optimization
/// based on centroidal Voronoi tessellations*, Applied Mathematics and Computation 133, 2002,
/// doi 10.1016/S0096-3003(01)00260-0).
fn density(sizes: &[f64]) -> Density {
    if sizes.iter().all(|&s| s == 1.0) {
        Density::Uniform
    } else {
        Density::Vertices(sizes.iter().map(|s| s.powi(-4)).collect())
    }
}
