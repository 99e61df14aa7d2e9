//! Records how seeds move in Lloyd's iteration, frame by frame, in the coordinates that the kernel sees.

use std::path::Path;

use glam::DVec3;
use tetcvt::geometry::frame::{Frame, snap};
use tetcvt::geometry::hilbert::hilbert_order;
use tetcvt::io;
use tetcvt::io::npy::TrajectoryWriter;
use tetcvt::params::{Boundary, Optimizer, Params, Target};
use tetcvt::progress::{Flow, Observer, Step};
use tetcvt::relax::Relaxation;
use tetcvt::seeds::{self, Anchor, Seeds};
use tetcvt::surface::Surface;
use tetcvt::surface::features::Features;

use super::Outcome;
use super::experiments::Start;
use super::support::Rng;

/// A crowded start is chosen from so many times as many uniform points.
const CHOICE: usize = 16;

/// The density of a crowded start falls by e in this share of the frame's unit.
const DECAY: f64 = 0.125;

/// A run to record.
pub struct Run<'a> {
    /// The surface's file.
    pub model: &'a Path,
    /// Count of seeds.
    pub seeds: usize,
    /// Iterations.
    pub iterations: usize,
    /// Where interior seeds begin.
    pub first: tetcvt::params::Start,
    /// How they are chosen.
    pub start: Start,
}

/// Runs Lloyd's iteration and writes all of its positions to `file`. Returns the share of the update in the time of the
/// iterations.
pub fn record(run: &Run, file: &Path) -> Outcome<f64> {
    let surface = io::read_surface(run.model)?;
    let params = Params {
        target: Target::Count(run.seeds),
        boundary: if run.start == Start::Surface { Boundary::Conform } else { Boundary::Free },
        feature_angle: 180.0,
        start: run.first,
        optimizer: Optimizer::Lloyd,
        iterations: run.iterations,
        tolerance: 0.0,
        ..Params::default()
    };
    let features = Features::find(&surface, params.feature_angle);
    let seeds = match run.start {
        Start::Uniform => seeds::sample(&surface, &features, &params)?,
        Start::Crowded => crowded(&surface, &features, &params, run.seeds)?,
        Start::Surface => on_surface(&surface, run.seeds),
    };
    let mut recorder = Recorder { writer: TrajectoryWriter::create(file)?, failure: None, update: 0.0, all: 0.0 };
    recorder.seeds(None, &seeds.positions, surface.frame());
    Relaxation::new(&surface, &features, &params, seeds, None)?.run(run.iterations, &mut recorder)?;
    if let Some(failure) = recorder.failure {
        return Err(failure.into());
    }
    recorder.writer.finish()?;
    Ok(recorder.update / recorder.all)
}

/// Hears of every iteration, and writes it.
struct Recorder {
    writer: TrajectoryWriter,
    failure: Option<tetcvt::Error>,
    /// Seconds of the updates.
    update: f64,
    /// Seconds of the iterations.
    all: f64,
}

impl Observer for Recorder {
    fn seeds(&mut self, step: Option<&Step>, positions: &[DVec3], _: &Frame) -> Flow {
        if let Some(step) = step {
            self.update += step.update_s;
            self.all += step.update_s + step.centroids_s;
        }
        match self.writer.push(positions.iter().copied()) {
            Ok(()) => Flow::Continue,
            Err(e) => {
                self.failure = Some(e);
                Flow::Stop
            }
        }
    }
}

/// Weighted sampling without replacement, from uniform points: the weight falls away from the surface's highest vertex.
///
/// P. S. Efraimidis, P. G. Spirakis, *Weighted random sampling with a reservoir*, Information Processing Letters 97(5),
/// 2006, doi 10.1016/j.ipl.2005.11.003: those with the greatest u^(1/w), u uniform in (0, 1].
fn crowded(surface: &Surface, features: &Features, params: &Params, count: usize) -> Outcome<Seeds> {
    let many = Params { target: Target::Count(CHOICE * count), ..params.clone() };
    let mut seeds = seeds::sample(surface, features, &many)?;
    let highest = surface.points().iter().copied().max_by(|a, b| a.y.total_cmp(&b.y)).expect("a surface has vertices");
    let mut rng = Rng(params.random_seed);
    let key = |p: &DVec3| (1.0 - rng.unit()).ln() * (p.distance(highest) / DECAY).exp();
    let mut keys: Vec<(f64, usize)> = seeds.positions.iter().map(key).zip(0..).collect();
    keys.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut chosen: Vec<usize> = keys[..count].iter().map(|k| k.1).collect();
    chosen.sort_unstable();
    seeds.positions = chosen.iter().map(|&i| seeds.positions[i]).collect();
    seeds.anchors.truncate(count);
    seeds.spacing *= (CHOICE as f64).cbrt();
    Ok(seeds)
}

/// Uniform on the surface, numbered along a Hilbert curve.
fn on_surface(surface: &Surface, count: usize) -> Seeds {
    let mut rng = Rng(1);
    let mut areas = vec![0.0];
    for t in 0..surface.triangles().len() as u32 {
        areas.push(areas[t as usize] + surface.normal2(t).length());
    }
    let total = areas[areas.len() - 1];
    let mut drawn = Vec::with_capacity(count);
    while drawn.len() < count {
        let at = rng.unit() * total;
        let t = areas.partition_point(|&a| a <= at) as u32 - 1;
        let [a, b, c] = surface.corners(t);
        let (mut u, mut v) = (rng.unit(), rng.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        drawn.push((snap(a + (b - a) * u + (c - a) * v), t));
    }
    let positions: Vec<DVec3> = drawn.iter().map(|d| d.0).collect();
    let order = hilbert_order(&positions);
    // An even spacing: each seed owns a hexagon.
    let spacing = (surface.area() / count as f64 / 0.75f64.sqrt()).sqrt();
    Seeds {
        keep_places: false,
        positions: order.iter().map(|&i| drawn[i as usize].0).collect(),
        anchors: order.iter().map(|&i| Anchor::Surface { triangle: drawn[i as usize].1 }).collect(),
        spacing,
        sizing: None,
        relative_size: vec![1.0; surface.points().len()],
        whole: Vec::new(),
    }
}
