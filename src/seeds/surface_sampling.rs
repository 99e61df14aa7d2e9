//! Seeds on the surface, off its creases: blue noise among the seeds that the creases already have.
//!
//! 1. Draw about five candidates for each seed, triangle by triangle, in a density of one over the square of the
//!    spacing; leave out those right beside a crease, where its own seeds stand for them.
//! 2. Take the most crowded out until as many are left as wanted (see `elimination`).

use glam::DVec3;

use super::Anchor;
use super::counts::{Demand, Plan};
use super::elimination::{Sample, eliminate};
use super::grid::{CellGrid, typical};
use crate::geometry::frame::snap;
use crate::geometry::hilbert::hilbert_order;
use crate::rng::Rng;
use crate::surface::Surface;
use crate::surface::features::Features;

/// Candidates for each seed.
const OVERSAMPLING: f64 = 5.0;
/// Candidates for each shell at least.
const PER_SHELL: f64 = 200.0;
/// Spacings that a candidate keeps away from a crease, tried in turn until enough candidates are left.
const CLEARANCES: [f64; 4] = [0.6, 0.45, 0.25, 0.0];

/// A seed on the boundary, with what its neighbours must know of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundarySeed {
    pub(super) position: DVec3,
    pub(super) anchor: Anchor,
    /// Outward normal; zero on creases and corners.
    pub(super) normal: DVec3,
    /// Spacing here.
    pub(super) spacing: f64,
}

/// Adds the surface seeds planned, and `more`, to `seeds`, which hold those of corners and creases.
pub(super) fn add_surface_seeds(
    surface: &Surface,
    features: &Features,
    (demand, plan): (&Demand, &Plan),
    more: usize,
    random_seed: u64,
    seeds: &mut Vec<BoundarySeed>,
) {
    let count = plan.surface + more;
    if count == 0 {
        return;
    }
    let fixed: Vec<Sample> = seeds
        .iter()
        .map(|s| Sample { position: s.position, normal: DVec3::ZERO, spacing: s.spacing, group: 0 })
        .collect();
    let mut rng = Rng::new(random_seed, super::stream::SURFACE);
    let mut wanted = OVERSAMPLING * count as f64;
    loop {
        let candidates = candidates(surface, plan, wanted, &mut rng);
        let chosen = CLEARANCES.iter().find_map(|&c| {
            let clear = clear_of_creases(surface, features, (demand, plan), c, &candidates);
            let enough = clear.len() >= 2 * count || (c == 0.0 && clear.len() > count);
            enough.then_some(clear)
        });
        let Some(chosen) = chosen else {
            wanted *= 2.0;
            continue;
        };
        let samples: Vec<Sample> = chosen.iter().map(|c| c.1).collect();
        for i in eliminate(&samples, &fixed, count, demand.shell_least()) {
            let (triangle, s) = chosen[i as usize];
            let anchor = Anchor::Surface { triangle };
            seeds.push(BoundarySeed { position: s.position, anchor, normal: s.normal, spacing: s.spacing });
        }
        return;
    }
}

/// 1. About `wanted` candidates or more, at even steps of cells' worth of area, uniform within each triangle.
fn candidates(surface: &Surface, plan: &Plan, wanted: f64, rng: &mut Rng) -> Vec<(u32, Sample)> {
    let cells_of = |t: u32| {
        let least = surface.triangles()[t as usize].iter().map(|&v| plan.sizes[v as usize]).fold(f64::MAX, f64::min);
        (0.5 * surface.normal2(t).length() / (0.866 * least * least), least)
    };
    let triangles = surface.triangles().len() as u32;
    let mut cells = vec![0.0; surface.shell_count()];
    (0..triangles).for_each(|t| cells[surface.shell()[t as usize] as usize] += cells_of(t).0);
    let oversampling = OVERSAMPLING.max(wanted / cells.iter().sum::<f64>());
    let rate: Vec<f64> = cells.iter().map(|c| oversampling.max(PER_SHELL / c)).collect();
    let mut passed = vec![0.5; cells.len()];
    let mut candidates = Vec::new();
    for t in 0..triangles {
        let shell = surface.shell()[t as usize];
        let (cells, least) = cells_of(t);
        let passed = &mut passed[shell as usize];
        *passed += cells * rate[shell as usize];
        if *passed < 1.0 {
            continue;
        }
        let [a, b, c] = surface.corners(t);
        let normal = surface.normal2(t).normalize_or_zero();
        let sizes = surface.triangles()[t as usize].map(|v| plan.sizes[v as usize]);
        while *passed >= 1.0 {
            *passed -= 1.0;
            let w = rng.barycentric();
            let keep = rng.unit();
            let spacing = sizes[0] * w[0] + sizes[1] * w[1] + sizes[2] * w[2];
            if keep * spacing * spacing <= least * least {
                let position = snap(a * w[0] + b * w[1] + c * w[2]);
                candidates.push((t, Sample { position, normal, spacing, group: shell }));
            }
        }
    }
    // Neighbours in space become neighbours in memory: elimination is bound by that.
    let positions: Vec<DVec3> = candidates.iter().map(|c| c.1.position).collect();
    hilbert_order(&positions).into_iter().map(|i| candidates[i as usize]).collect()
}

/// The candidates at least `clearance` spacings away from every crease.
fn clear_of_creases(
    surface: &Surface,
    features: &Features,
    (demand, plan): (&Demand, &Plan),
    clearance: f64,
    candidates: &[(u32, Sample)],
) -> Vec<(u32, Sample)> {
    let mut points = Vec::new();
    let mut steps = Vec::new();
    let kept = features.curves.iter().zip(demand.needs()).filter(|(_, n)| n.kept);
    for (c, _) in kept {
        for e in c.vertices.windows(2) {
            let [p, q] = [e[0], e[1]].map(|v| surface.points()[v as usize]);
            let step = 0.2 * plan.sizes[e[0] as usize].min(plan.sizes[e[1] as usize]);
            let parts = (p.distance(q) / step).ceil().max(1.0);
            steps.push(5.0 * step);
            points.extend((0..=parts as usize).map(|i| p.lerp(q, i as f64 / parts)));
        }
    }
    points.extend(demand.corners().iter().map(|&v| surface.points()[v as usize]));
    if points.is_empty() || clearance == 0.0 {
        return candidates.to_vec();
    }
    let cell = if demand.is_even() { plan.spacing } else { typical(&steps) };
    let grid = CellGrid::new(&points, 0.5 * cell);
    let clear = |s: &Sample| {
        let reach = clearance * s.spacing;
        let mut clear = true;
        grid.near(s.position, reach, |i| {
            clear &= points[i as usize].distance_squared(s.position) >= reach * reach;
        });
        clear
    };
    candidates.iter().filter(|(_, s)| clear(s)).copied().collect()
}
