//! How fine the surface must be sampled where a wall or a gap is thin.
//!
//! Two sheets of surface stay apart in the restricted Delaunay surface when no point of one is closer to a seed of the
//! other than to its own nearest seed: the covering radius, about 0.65 of the spacing in a relaxed sampling, must stay
//! below the distance t between the sheets. (The bound is that of Amenta and Bern, *Surface Reconstruction by Voronoi
//! Filtering*, Discrete & Computational Geometry 22, 1999, doi 10.1007/PL00009475, with the medial axis taken between
//! opposite sheets alone: creases are kept by their own seeds, and curvature costs accuracy, not topology.)
//!
//! 1. Sample the surface, a few samples to each seed that it will get.
//! 2. From each sample shoot a ray inwards and one outwards. A hit on a sheet nearly parallel to the sample's own, seen
//!    from the side that faces it, is the other side of a wall or of a gap, unless a crease that joins the two sheets is
//!    near, or they are flat up to it: that is a wedge, which no spacing resolves.
//! 3. A wall may have a spacing of 1.3 t. Where rays across the middle of it end soon as well it is a wire, which needs
//!    enough seeds around it: 0.9 t.
//! 4. Bring the limits to the vertices and let them grow along edges by at most [`GRADE`] per length.

use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::grid::{CellGrid, typical};
use crate::rng::Rng;
use crate::surface::Surface;
use crate::surface::features::Features;

/// Spacing over thickness of a wall.
const WALL: f64 = 1.3;
/// Spacing over thickness of a wire.
const WIRE: f64 = 0.9;
/// A wall is a wire where it is less than so many times as wide as thick.
const WIRE_WIDTH: f64 = 2.5;
/// Cosine of the largest angle between sheets that count as two sides of a wall: 25 degrees.
const PARALLEL: f64 = 0.906;
/// A wedge is as thick as the angle between its sides says, up to this factor.
const WEDGE: f64 = 1.25;
/// Growth of the spacing per length along the surface.
pub(super) const GRADE: f64 = 0.35;
/// No limit is below this share of the spacing that the count gives: what is thinner is left to the repair of the
/// restricted surface, or to a larger count.
pub(super) const FLOOR: f64 = 0.15;
/// Samples per square of the spacing.
const DENSITY: f64 = 4.0;
/// Samples per shell at least.
const PER_SHELL: f64 = 64.0;

/// The largest spacing that each vertex of the surface allows, where `sizes` are wanted; infinite where nothing is thin. Nowhere
/// less than the share `floor` of the size.
pub(super) fn limits(
    surface: &Surface,
    features: &Features,
    (sizes, floor): (&[f64], f64),
    random_seed: u64,
) -> Vec<f64> {
    let samples = samples(surface, sizes, random_seed);
    let creases = Creases::new(surface, features, sizes);
    let found: Vec<Option<f64>> = samples
        .par_iter()
        .map(|s| {
            let spacing = s.spacing;
            let thickness = |side| opposite(surface, features, &creases, s, side);
            let least = [-1.0, 1.0].into_iter().filter_map(thickness).fold(f64::INFINITY, f64::min);
            (least < spacing).then(|| least.max(floor * spacing))
        })
        .collect();
    let mut limits = vec![f64::INFINITY; surface.points().len()];
    for (s, limit) in samples.iter().zip(found) {
        let Some(limit) = limit else { continue };
        let vertices = surface.triangles()[s.triangle as usize];
        let distances = vertices.map(|v| surface.points()[v as usize].distance(s.position));
        // The sample stands for the place up to the next one. Where the triangle is so large that growth towards its
        // vertices would hide the thin place from an interpolation, all of it is as fine as that.
        let mut grown = distances.map(|d| limit + GRADE * (d - s.gap).max(0.0));
        if (0..3).map(|i| s.weights[i] * grown[i]).sum::<f64>() > 1.2 * limit {
            grown = [limit; 3];
        }
        for (v, there) in vertices.into_iter().zip(grown) {
            limits[v as usize] = limits[v as usize].min(there);
        }
    }
    grade(surface, &mut limits, sizes);
    limits
}

struct Probe {
    position: DVec3,
    normal: DVec3,
    triangle: u32,
    /// Its barycentric coordinates in the triangle.
    weights: [f64; 3],
    /// How far the next sample may be.
    gap: f64,
    /// The spacing wanted here.
    spacing: f64,
}

/// The mean of three; of equal ones, exactly that.
fn mean([a, b, c]: [f64; 3]) -> f64 {
    a + ((b - a) + (c - a)) / 3.0
}

/// 1. Samples at even steps of area, shell by shell.
fn samples(surface: &Surface, sizes: &[f64], random_seed: u64) -> Vec<Probe> {
    let shells = surface.shell_count();
    let mut areas = vec![0.0; shells];
    for t in 0..surface.triangles().len() {
        areas[surface.shell()[t] as usize] += 0.5 * surface.normal2(t as u32).length();
    }
    let mut passed = vec![0.5; shells];
    let mut rng = Rng::new(random_seed, super::stream::THICKNESS);
    let mut samples = Vec::new();
    for t in 0..surface.triangles().len() as u32 {
        let shell = surface.shell()[t as usize] as usize;
        let normal2 = surface.normal2(t);
        let spacing = mean(surface.triangles()[t as usize].map(|v| sizes[v as usize]));
        let step = (spacing * spacing / DENSITY).min(areas[shell] / PER_SHELL);
        passed[shell] += 0.5 * normal2.length() / step;
        while passed[shell] >= 1.0 {
            passed[shell] -= 1.0;
            let [a, b, c] = surface.corners(t);
            let w = rng.barycentric();
            let position = a * w[0] + b * w[1] + c * w[2];
            let (gap, normal) = (1.5 * step.sqrt(), normal2.normalize_or_zero());
            samples.push(Probe { position, normal, triangle: t, weights: w, gap, spacing });
        }
    }
    samples
}

/// 2. and 3. The spacing that the sheet opposite a sample allows; `side` is -1 through the solid, 1 through the void.
fn opposite(surface: &Surface, features: &Features, creases: &Creases, sample: &Probe, side: f64) -> Option<f64> {
    let direction = side * sample.normal;
    // Past the sample's own triangle, which rounding may put on either side of it.
    let start = 1e-12;
    let (t, hit) = surface.tree().ray(sample.position + start * direction, direction, 1.2 * sample.spacing)?;
    if hit == sample.triangle {
        return None;
    }
    let across = surface.normal2(hit).normalize_or_zero();
    if sample.normal.dot(across) > -PARALLEL {
        return None;
    }
    let patches = [features.face[sample.triangle as usize], features.face[hit as usize]];
    if creases.join(patches, sample, t) || creases.is_wedge(patches, sample, across, t) {
        return None;
    }
    let middle = sample.position + 0.5 * t * direction;
    let limit = WIRE_WIDTH * t;
    let width = |d: DVec3| match (surface.tree().ray(middle, d, limit), surface.tree().ray(middle, -d, limit)) {
        (Some(a), Some(b)) => a.0 + b.0,
        _ => f64::INFINITY,
    };
    let u = sample.normal.any_orthonormal_vector();
    let width = width(u).min(width(sample.normal.cross(u)));
    Some(t * if width < limit { WIRE } else { WALL })
}

/// Creases as points, each with the two patches that it joins.
struct Creases {
    points: Vec<DVec3>,
    patches: Vec<[u32; 2]>,
    grid: CellGrid,
    /// The points again, ordered by patches.
    by_pair: Vec<([u32; 2], u32)>,
}

impl Creases {
    fn new(surface: &Surface, features: &Features, sizes: &[f64]) -> Creases {
        let mut edges: Vec<([u32; 2], u32)> = Vec::new();
        for c in &features.curves {
            edges.extend(c.vertices.windows(2).map(|e| ([e[0].min(e[1]), e[0].max(e[1])], u32::MAX)));
        }
        edges.sort_unstable();
        let mut joined = vec![[u32::MAX; 2]; edges.len()];
        for (t, v) in surface.triangles().iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (v[i], v[(i + 1) % 3]);
                if let Ok(e) = edges.binary_search(&([a.min(b), a.max(b)], u32::MAX)) {
                    let side = usize::from(joined[e][0] != u32::MAX);
                    joined[e][side] = features.face[t];
                }
            }
        }
        let (mut points, mut patches, mut spacings) = (Vec::new(), Vec::new(), Vec::new());
        for (&([a, b], _), joined) in edges.iter().zip(&joined) {
            let spacing = 0.5 * (sizes[a as usize] + sizes[b as usize]);
            let (a, b) = (surface.points()[a as usize], surface.points()[b as usize]);
            let parts = (2.0 * a.distance(b) / spacing).ceil().max(1.0);
            for i in 0..parts as usize {
                spacings.push(spacing);
                points.push(a.lerp(b, (i as f64 + 0.5) / parts));
                patches.push([joined[0].min(joined[1]), joined[0].max(joined[1])]);
            }
        }
        let grid = CellGrid::new(&points, 2.0 * typical(&spacings));
        let mut by_pair: Vec<([u32; 2], u32)> = patches.iter().copied().zip(0..).collect();
        by_pair.sort_unstable();
        Creases { points, patches, grid, by_pair }
    }

    /// Whether the sample and the sheet opposite with normal `across`, `thickness` away, are flat sides of a wedge: they
    /// meet in a crease, at the angle that they have here. Flat sides need no more seeds than their creases, however
    /// acute the wedge.
    fn is_wedge(&self, patches: [u32; 2], sample: &Probe, across: DVec3, thickness: f64) -> bool {
        let pair = [patches[0].min(patches[1]), patches[0].max(patches[1])];
        let first = self.by_pair.partition_point(|&(p, _)| p < pair);
        let own = self.by_pair[first..].iter().take_while(|e| e.0 == pair);
        let distance2 =
            own.map(|&(_, i)| self.points[i as usize].distance_squared(sample.position)).fold(f64::INFINITY, f64::min);
        let (sine, cosine) = (sample.normal.cross(across).length(), -sample.normal.dot(across));
        distance2.is_finite() && fits(thickness, distance2.sqrt(), sine, cosine)
    }

    /// Whether a crease that joins these two patches is near a sample, where they are `thickness` apart.
    fn join(&self, patches: [u32; 2], sample: &Probe, thickness: f64) -> bool {
        let pair = [patches[0].min(patches[1]), patches[0].max(patches[1])];
        let (p, reach) = (sample.position, (3.0 * thickness).max(sample.spacing));
        let mut found = false;
        self.grid.near(p, reach, |i| {
            let i = i as usize;
            found |= self.patches[i] == pair && self.points[i].distance(p) < reach;
        });
        found
    }
}

/// Whether a wedge of this angle (its sine and cosine) is about `thickness` thick so far from its crease.
fn fits(thickness: f64, distance: f64, sine: f64, cosine: f64) -> bool {
    let expected = distance * sine / cosine;
    (expected / WEDGE..=expected * WEDGE).contains(&thickness)
}

/// 4. Lets limits grow along edges by at most [`GRADE`] per length (Dijkstra from the least up to twice the sizes wanted).
pub(super) fn grade(surface: &Surface, limits: &mut [f64], sizes: &[f64]) {
    let most = |v: u32| 2.0 * sizes[v as usize];
    if (0..).zip(limits.iter()).all(|(v, l)| *l > most(v)) {
        return;
    }
    let mut starts = vec![0u32; limits.len() + 1];
    for v in surface.triangles().iter().flatten() {
        starts[*v as usize + 1] += 1;
    }
    for i in 0..limits.len() {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut neighbors = vec![0u32; 3 * surface.triangles().len()];
    for v in surface.triangles() {
        for i in 0..3 {
            let slot = &mut next[v[i] as usize];
            neighbors[*slot as usize] = v[(i + 1) % 3];
            *slot += 1;
        }
    }
    // Limits are positive: their bits sort as they do.
    let mut heap: BinaryHeap<Reverse<(u64, u32)>> = (0..limits.len() as u32)
        .filter(|&v| limits[v as usize] < most(v))
        .map(|v| Reverse((limits[v as usize].to_bits(), v)))
        .collect();
    let points = surface.points();
    while let Some(Reverse((bits, v))) = heap.pop() {
        let limit = f64::from_bits(bits);
        if limit > limits[v as usize] {
            continue;
        }
        for &u in &neighbors[starts[v as usize] as usize..starts[v as usize + 1] as usize] {
            let there = limit + GRADE * points[v as usize].distance(points[u as usize]);
            if there < limits[u as usize] && there < most(u) {
                limits[u as usize] = there;
                heap.push(Reverse((there.to_bits(), u)));
            }
        }
    }
}
