//! Moves seeds to a centroidal Voronoi tessellation of the solid, of its surface and of its creases at once.
//!
//! Each iteration:
//!
//! 1. A motion from the slope of the energy (`objective.rs`): by L-BFGS (`lbfgs.rs`), by Lloyd's step with momentum
//!    (`nesterov.rs`), or by Lloyd's step -D^-1 g alone, which takes each seed to the centroid of its piece (Du, Faber,
//!    Gunzburger, *Centroidal Voronoi Tessellations: Applications and Algorithms*, SIAM Review 41(4), 1999,
//!    doi 10.1137/S0036144599352836).
//! 2. Each seed moves within its own part of the solid (`targets.rs`, `creases.rs`).
//! 3. The triangulation follows, cells are clipped by the surface, and the slope is known again.
//! 4. If a motion of L-BFGS did not lower the energy enough, it is taken back, its memory is cleared, and Lloyd's step
//!    taken in its place: this never raises the energy of free seeds.
//!
//! Departure: an interior seed whose cell reaches the surface fills a gap between surface seeds, and becomes one.

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use crate::clipped_voronoi::{ClippedVoronoi, Clipper, Density};
use crate::delaunay::{Delaunay, DelaunayError, Relocation, Updater};
use crate::error::Error;
use crate::geometry::frame::snap;
use crate::params::{Boundary, Optimizer, Params};
use crate::progress::{Flow, Move, Observer, Step};
use crate::seeds::{Anchor, Seeds};
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::tet_mesh::StageTimes;

mod creases;

mod far;

mod lbfgs;

mod nesterov;

mod objective;

mod odt;

mod tangents;

mod targets;

mod vectors;

use creases::Chain;
use lbfgs::Lbfgs;
use nesterov::Nesterov;
use objective::{Objective, Slope};
use tangents::Tangents;
use targets::{Confines, Target};

/// No part of the surface is asked to be sampled finer than this share of the spacing.
const LEAST_SIZE: f64 = 0.05;

/// Stretches of creases below twice this share of the spacing are not split: of those to be whole, and of noise.
const LEAST_STRETCH: f64 = 0.05;
const LEAST_STRETCH_OF_NOISE: f64 = 0.3;

/// A motion of L-BFGS stands if the energy falls by this share of what the slope promises.
const ENOUGH: f64 = 1e-4;

/// Seeds on their way to a centroidal Voronoi tessellation.
pub struct Relaxation<'a> {
    params: &'a Params,
    confines: Confines<'a>,
    tangents: Tangents<'a>,
    objective: Objective,
    method: Method,
    seeds: Seeds,
    updater: Updater,
    clipper: Clipper<'a>,
    state: State,
    deadline: Option<Instant>,
    steps: Vec<Step>,
    times: StageTimes,
}

/// What follows from the places of the seeds.
struct State {
    clipped: ClippedVoronoi,
    chains: Vec<Chain>,
    slope: Slope,
}

/// Where the seeds were before a motion.
struct Before {
    positions: Vec<DVec3>,
    anchors: Vec<Anchor>,
    state: State,
}

/// How motions are found.
enum Method {
    Lloyd,
    Nesterov(Nesterov),
    Lbfgs(Lbfgs),
}

/// Why an iteration was the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// As many as were asked for.
    Iterations,
    /// The energy fell by less than the tolerance.
    Tolerance,
    /// The time is up.
    Time,
    /// The caller said so.
    Caller,
}

impl Stopped {
    /// Whether the run is to end with what there is.
    pub fn is_interruption(self) -> bool {
        matches!(self, Stopped::Time | Stopped::Caller)
    }
}

impl<'a> Relaxation<'a> {
    /// Triangulates the first seeds and clips their cells. At the deadline the run ends with what there is.
    pub fn new(
        surface: &'a Surface,
        features: &'a Features,
        params: &'a Params,
        seeds: Seeds,
        deadline: Option<Instant>,
    ) -> Result<Relaxation<'a>, Error> {
        let mut times = StageTimes::default();
        let started = Instant::now();
        let delaunay = Delaunay::build(&[seeds.positions.as_slice(), &far::points()].concat())?;
        times.build = started.elapsed().as_secs_f64();

        let started = Instant::now();
        let confines = Confines { surface, features, boundary: params.boundary, adopted_area: f64::INFINITY };
        let tangents = Tangents::new(surface, features);
        let mut objective = match params.boundary {
            Boundary::Conform => Objective::conforming(seeds.spacings()),
            Boundary::Free => Objective::free(),
        };
        let mut clipper = Clipper::new(surface);
        if let Some(sizing) = &seeds.sizing {
            clipper.set_sizing(sizing.clone());
        }
        set_density(surface, &mut clipper, &mut objective, &seeds.relative_size);
        let clipped = clipper.clip_first(&delaunay, seeds.positions.len());
        let chains = confines.chains(&seeds.anchors);
        let slope = objective.slope(&seeds, &clipped, &tangents, &chains);
        let state = State { clipped, chains, slope };
        times.centroids = started.elapsed().as_secs_f64();
        let method = Method::new(params.optimizer);
        let steps = Vec::new();
        Ok(Relaxation {
            params,
            confines,
            tangents,
            objective,
            method,
            seeds,
            updater: Updater::new(delaunay, params.update),
            clipper,
            state,
            deadline,
            steps,
            times,
        })
    }

    /// At most so many iterations, until the energy settles, the time is up or the caller stops.
    pub fn run(&mut self, iterations: usize, observer: &mut dyn Observer) -> Result<Stopped, Error> {
        self.run_within(iterations, self.params.tolerance, observer)
    }

    /// The same until an iteration changes the energy by less than the share `tolerance` of itself.
    pub fn run_within(
        &mut self,
        iterations: usize,
        tolerance: f64,
        observer: &mut dyn Observer,
    ) -> Result<Stopped, Error> {
        for _ in 0..iterations {
            if self.deadline.is_some_and(|d| Instant::now() >= d) {
                return Ok(Stopped::Time);
            }
            let before = self.state.slope.energy;
            if self.iterate(observer)? == Flow::Stop {
                return Ok(Stopped::Caller);
            }
            let fall = before - self.state.slope.energy;
            // While surface seeds settle the energy may rise; that is no rest.
            if fall.abs() < tolerance * before {
                return Ok(Stopped::Tolerance);
            }
        }
        Ok(Stopped::Iterations)
    }

    /// One iteration of the chosen method.
    fn iterate(&mut self, observer: &mut dyn Observer) -> Result<Flow, Error> {
        let mut lloyd = self.state.slope.relaxed(&self.state.slope.gradient);
        lloyd.par_iter_mut().for_each(|v| *v = -*v);
        let (mut motion, kind) = self.method.motion(&self.state.slope, &lloyd);
        let (anchors, normals) = (&self.seeds.anchors, &self.state.slope.normals);
        motion.par_iter_mut().enumerate().for_each(|(i, m)| *m = tangents::motion(anchors[i], normals[i], *m));

        let mut step = Step { kind, energy: self.volume_energy(), ..Step::default() };
        let mut before = self.go(self.targets(&motion, &lloyd), &mut step)?;
        let mut made = self.made(&before);
        if kind == Move::Lbfgs && !self.has_descended(&before, &made) {
            self.method.forget();
            self.restore(before);
            step = Step { kind: Move::Lloyd, evaluations: step.evaluations, ..step };
            before = self.go(self.targets(&lloyd, &lloyd), &mut step)?;
            made = self.made(&before);
        }
        self.learn(before, made);
        self.report(step, observer)
    }

    /// Where `motion` takes the seeds.
    fn targets(&self, motion: &[DVec3], lloyd: &[DVec3]) -> Vec<Target> {
        let confines = Confines { adopted_area: targets::adopted_area(self.steps.len()), ..self.confines };
        confines.targets(&self.seeds, &self.state.clipped, &self.state.chains, motion, lloyd)
    }

    /// The motion that was made, confined as seeds are; `None` for a seed that came to belong elsewhere.
    fn made(&self, before: &Before) -> Vec<Option<DVec3>> {
        let from = |i| (before.positions[i], before.anchors[i]);
        let to = |i| (self.seeds.positions[i], self.seeds.anchors[i]);
        let normals = &self.state.slope.normals;
        (0..before.positions.len()).into_par_iter().map(|i| self.tangents.between(from(i), to(i), normals[i])).collect()
    }

    /// Whether the energy fell by enough (Armijo's condition). Where a seed came to belong elsewhere, another energy is
    /// minimised from now on, and the two cannot be compared.
    fn has_descended(&self, before: &Before, made: &[Option<DVec3>]) -> bool {
        let Some(made) = made.iter().copied().collect::<Option<Vec<DVec3>>>() else { return true };
        let promised = vectors::dot(&before.state.slope.gradient, &made).min(0.0);
        self.state.slope.energy <= before.state.slope.energy + ENOUGH * promised
    }

    /// Lets the method learn from a motion that was made.
    fn learn(&mut self, before: Before, made: Vec<Option<DVec3>>) {
        for i in (0..made.len()).filter(|&i| made[i].is_none()) {
            self.method.forget_seed(i);
        }
        let Method::Lbfgs(memory) = &mut self.method else { return };
        let (old, new) = (&before.state.slope.gradient, &self.state.slope.gradient);
        let change = |(i, m): (usize, &Option<DVec3>)| if m.is_some() { new[i] - old[i] } else { DVec3::ZERO };
        let change = made.par_iter().enumerate().map(change).collect();
        let made = made.into_par_iter().map(Option::unwrap_or_default).collect();
        memory.remember(made, change, &self.state.slope);
    }

    /// Moves seeds elsewhere, which takes no part in the optimisation.
    pub fn insert(&mut self, targets: Vec<Target>, observer: &mut dyn Observer) -> Result<Flow, Error> {
        self.method.forget();
        let mut step = Step { kind: Move::Insertion, energy: self.volume_energy(), ..Step::default() };
        self.go(targets, &mut step)?;
        self.report(step, observer)
    }

    /// At most so many steps towards an optimal Delaunay triangulation; one that does not leave fewer slivers is taken back
    /// and the last.
    pub fn reduce_slivers(&mut self, steps: usize, observer: &mut dyn Observer) -> Result<Stopped, Error> {
        let mut fewest = odt::slivers(self.delaunay(), &self.state.clipped);
        for _ in 0..steps {
            if self.deadline.is_some_and(|d| Instant::now() >= d) {
                return Ok(Stopped::Time);
            }
            let motion = odt::motion(self.delaunay(), &self.seeds, &self.state.clipped);
            let here: Vec<Target> =
                self.seeds.positions.iter().copied().zip(self.seeds.anchors.iter().copied()).collect();
            let moved = |(target, way): (&Target, DVec3)| (snap(target.0 + way), target.1);
            let targets = here.iter().zip(motion).map(moved).collect();
            let mut step = Step { kind: Move::Odt, energy: self.volume_energy(), ..Step::default() };
            self.go(targets, &mut step)?;
            let left = odt::slivers(self.delaunay(), &self.state.clipped);
            if left >= fewest {
                self.go(here, &mut step)?;
                break;
            }
            fewest = left;
            if self.report(step, observer)? == Flow::Stop {
                return Ok(Stopped::Caller);
            }
        }
        Ok(Stopped::Iterations)
    }

    /// Moves every seed to its new place; the triangulation, the cells and the slope follow. Says where all came from.
    fn go(&mut self, targets: Vec<Target>, step: &mut Step) -> Result<Before, Error> {
        let started = Instant::now();
        let (positions, anchors, relocation) = self.relocate(targets)?;
        let update_s = started.elapsed().as_secs_f64();

        let started = Instant::now();
        let clipped = self.clipper.clip_first(self.updater.delaunay(), positions.len());
        let chains = self.confines.chains(&self.seeds.anchors);
        let slope = self.objective.slope(&self.seeds, &clipped, &self.tangents, &chains);
        let state = std::mem::replace(&mut self.state, State { clipped, chains, slope });
        let centroids_s = started.elapsed().as_secs_f64();
        self.times.update += update_s;
        self.times.update_parts.add(&relocation.seconds);
        self.times.centroids += centroids_s;

        let moves2 = positions.par_iter().zip(&self.seeds.positions).map(|(a, b)| a.distance_squared(*b));
        *step = Step {
            kind: step.kind,
            energy: step.energy,
            max_move: self.confines.surface.frame().length_to_model(moves2.reduce(|| 0.0, f64::max).sqrt()),
            evaluations: step.evaluations + 1,
            update_s: step.update_s + update_s,
            centroids_s: step.centroids_s + centroids_s,
            tets: self.delaunay().tets().count(),
            bicells: 2 * self.delaunay().vertices().len(),
            vertices_failed: step.vertices_failed + relocation.vertices_failed,
            bicells_failed: step.bicells_failed + relocation.bicells_failed,
            predicates: step.predicates + relocation.predicates,
            flips: step.flips + relocation.flips,
            reversed: step.reversed + relocation.reversed,
            held_back: step.held_back + relocation.held_back,
            rebuilt: step.rebuilt || relocation.rebuilt,
        };
        Ok(Before { positions, anchors, state })
    }

    /// The seeds and all that follows from them as they were; the triangulation stays where it is until the next motion.
    fn restore(&mut self, before: Before) {
        Before { positions: self.seeds.positions, anchors: self.seeds.anchors, state: self.state } = before;
    }

    /// Keeps a step and tells the observer.
    fn report(&mut self, step: Step, observer: &mut dyn Observer) -> Result<Flow, Error> {
        if self.params.check {
            self.check()?;
        }
        self.steps.push(step);
        Ok(observer.seeds(Some(&step), &self.seeds.positions, self.confines.surface.frame()))
    }

    /// Follows the moved seeds with the triangulation; a seed that would fall on another keeps its place. Returns where
    /// the seeds were.
    fn relocate(&mut self, mut targets: Vec<Target>) -> Result<(Vec<DVec3>, Vec<Anchor>, Relocation), Error> {
        loop {
            let mut positions: Vec<DVec3> = targets.iter().map(|t| t.0).chain(far::points()).collect();
            match self.updater.relocate(&positions) {
                Ok(relocation) => {
                    positions.truncate(targets.len());
                    let anchors = targets.into_iter().map(|t| t.1).collect();
                    let old_positions = std::mem::replace(&mut self.seeds.positions, positions);
                    let old_anchors = std::mem::replace(&mut self.seeds.anchors, anchors);
                    return Ok((old_positions, old_anchors, relocation));
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

    /// The CVT energy of the cells, in the model's units.
    fn volume_energy(&self) -> f64 {
        self.state.clipped.energy() / self.confines.surface.frame().scale.powi(5)
    }

    /// Every invariant that must hold between iterations.
    fn check(&self) -> Result<(), Error> {
        self.delaunay().check().map_err(Error::Broken)?;
        let volume: f64 = self.state.clipped.cells.iter().map(|c| c.volume).sum();
        let area: f64 = self.state.clipped.cells.iter().map(|c| c.area).sum();
        for (what, sum, whole) in
            [("volumes", volume, self.confines.surface.volume()), ("areas", area, self.confines.surface.area())]
        {
            if (sum - whole).abs() > 1e-12 * whole {
                return Err(Error::Broken(format!("the cells' {what} sum to {sum}, not to {whole}")));
            }
        }
        Ok(())
    }

    /// Asks for a finer spacing around some places from now on: so much at each, and half of the distance more around it.
    pub fn refine_density(&mut self, places: &[(DVec3, f64)]) {
        let spacing = self.seeds.spacing;
        let sizing = self.seeds.sizing.clone();
        for &(place, finest) in places {
            // Where sizes grow with the distance themselves, a little further.
            let far = if sizing.is_some() { 4.0 } else { 2.0 };
            let reach = DVec3::splat(far * (self.seeds.spacing_at(place) - finest).max(0.0));
            let relative = &mut self.seeds.relative_size;
            self.confines.surface.tree().near_box(place - reach, place + reach, |t| {
                for v in self.confines.surface.triangles()[t as usize] {
                    let p = self.confines.surface.points()[v as usize];
                    let least = LEAST_SIZE * sizing.as_ref().map_or(1.0, |s| s.relative(p));
                    let size = (finest + 0.5 * p.distance(place)) / spacing;
                    let wanted = &mut relative[v as usize];
                    *wanted = if size < *wanted { size.max(least) } else { *wanted };
                }
            });
        }
        let sizes = &self.seeds.relative_size;
        set_density(self.confines.surface, &mut self.clipper, &mut self.objective, sizes);
    }

    /// Places for seeds in the middle of the stretches of creases that are no edges of the mesh, as `is_edge` has it: each
    /// with its anchor and the distance to the seeds before and after.
    pub(crate) fn crease_splits(&self, is_edge: impl Fn(u32, u32) -> bool) -> Vec<(DVec3, Anchor, f64)> {
        let least = |place: DVec3, anchor: &Anchor| {
            let whole = anchor.curve().is_some_and(|c| self.seeds.whole.get(c as usize) == Some(&true));
            self.seeds.spacing_at(place) * if whole { LEAST_STRETCH } else { LEAST_STRETCH_OF_NOISE }
        };
        let Confines { features, surface, .. } = self.confines;
        let splits = self.state.chains.iter().flat_map(|c| c.splits(features, surface, &is_edge));
        splits
            .map(|(place, anchor, ends)| {
                let size =
                    ends.map(|e| self.seeds.positions[e as usize].distance(place)).into_iter().fold(0.0, f64::max);
                (place, anchor, size)
            })
            .filter(|(place, anchor, size)| *size > least(*place, anchor))
            .collect()
    }

    /// The seeds as they are now.
    pub fn seeds(&self) -> &Seeds {
        &self.seeds
    }

    /// Their triangulation, with a few auxiliary points after the seeds.
    pub fn delaunay(&self) -> &Delaunay {
        self.updater.delaunay()
    }

    /// Their cells.
    pub fn clipped(&self) -> &ClippedVoronoi {
        &self.state.clipped
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

/// Sets the density of the surface that spaces seeds on it like `sizes`: 1/s^4 (Du, Wang, *Grid generation and optimization
/// based on centroidal Voronoi tessellations*, Applied Mathematics and Computation 133, 2002,
/// doi 10.1016/S0096-3003(01)00260-0).
fn set_density(surface: &Surface, clipper: &mut Clipper, objective: &mut Objective, sizes: &[f64]) {
    if sizes.iter().all(|&s| s == 1.0) {
        objective.set_density(surface, |_| 1.0);
        clipper.set_density(Density::Uniform);
    } else {
        let density: Vec<f64> = sizes.iter().map(|s| s.powi(-4)).collect();
        objective.set_density(surface, |v| density[v as usize]);
        clipper.set_density(Density::Vertices(density));
    }
}

impl Method {
    fn new(optimizer: Optimizer) -> Method {
        match optimizer {
            Optimizer::Lloyd => Method::Lloyd,
            Optimizer::Nesterov => Method::Nesterov(Nesterov::default()),
            Optimizer::Lbfgs => Method::Lbfgs(Lbfgs::default()),
        }
    }

    /// The next motion, given the step of Lloyd, and what it is.
    fn motion(&mut self, slope: &Slope, lloyd: &[DVec3]) -> (Vec<DVec3>, Move) {
        match self {
            Method::Lloyd => (lloyd.to_vec(), Move::Lloyd),
            Method::Nesterov(momentum) => (momentum.motion(slope, lloyd), Move::Nesterov),
            Method::Lbfgs(memory) => memory.motion(slope, lloyd),
        }
    }

    fn forget_seed(&mut self, i: usize) {
        match self {
            Method::Lloyd => {}
            Method::Nesterov(momentum) => momentum.forget_seed(i),
            Method::Lbfgs(memory) => memory.forget_seed(i),
        }
    }

    fn forget(&mut self) {
        match self {
            Method::Lloyd => {}
            Method::Nesterov(momentum) => momentum.forget(),
            Method::Lbfgs(memory) => memory.forget(),
        }
    }
}
