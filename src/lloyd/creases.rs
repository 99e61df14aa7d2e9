//! Seeds on creases, and the room that the surface leaves them.
//!
//! The stretch of a crease between two consecutive seeds is an edge of the restricted Delaunay surface if its smallest
//! ball holds no other seed (a Gabriel edge). Seeds on the surface are kept out of these balls, so that the mesh has its
//! creases whole.

use glam::DVec3;

use crate::seeds::Anchor;
use crate::surface::Surface;
use crate::surface::features::Features;

/// Balls are so much larger than the smallest.
const MARGIN: f64 = 1.1;

/// The seeds of one crease, in order along it.
pub(super) struct Chain {
    curve: u32,
    /// Arc length and seed; the corners at the ends are among them where they have seeds.
    seeds: Vec<(f64, u32)>,
}

/// The seeds of every crease.
pub(super) fn chains(features: &Features, anchors: &[Anchor]) -> Vec<Chain> {
    let mut chains: Vec<Chain> =
        (0..features.curves.len() as u32).map(|curve| Chain { curve, seeds: Vec::new() }).collect();
    let mut corners: Vec<(u32, u32)> = Vec::new();
    for (i, anchor) in (0..).zip(anchors) {
        match *anchor {
            Anchor::Curve { curve, at } | Anchor::Knot { curve, at } => chains[curve as usize].seeds.push((at, i)),
            Anchor::Corner { vertex } => corners.push((vertex, i)),
            _ => {}
        }
    }
    corners.sort_unstable();
    let corner = |v: u32| corners.binary_search_by_key(&v, |c| c.0).ok().map(|k| corners[k].1);
    for (chain, curve) in chains.iter_mut().zip(&features.curves) {
        if !curve.is_closed() {
            let ends = [(0.0, curve.vertices[0]), (curve.length(), curve.vertices[curve.vertices.len() - 1])];
            chain.seeds.extend(ends.into_iter().filter_map(|(at, v)| corner(v).map(|i| (at, i))));
        }
        chain.seeds.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
    chains
}

impl Chain {
    /// Where each seed of the crease goes, with its arc length: to the middle of its piece, which ends half-way to the
    /// next seeds. Corners and knots stay.
    pub(super) fn targets<'a>(
        &'a self,
        features: &'a Features,
        surface: &'a Surface,
        anchors: &'a [Anchor],
    ) -> impl Iterator<Item = (u32, DVec3, Anchor)> + 'a {
        let curve = &features.curves[self.curve as usize];
        let (n, length, closed) = (self.seeds.len(), curve.length(), curve.is_closed());
        let movable = move |k: &usize| matches!(anchors[self.seeds[*k].1 as usize], Anchor::Curve { .. });
        (0..n).filter(movable).map(move |k| {
            let (here, seed) = self.seeds[k];
            let before = match k {
                0 if closed => self.seeds[n - 1].0 - length,
                0 => 0.0,
                _ => self.seeds[k - 1].0,
            };
            let after = match k + 1 {
                next if next < n => self.seeds[next].0,
                _ if closed => self.seeds[0].0 + length,
                _ => length,
            };
            let middle = (before + 2.0 * here + after) / 4.0;
            let at = if closed { middle.rem_euclid(length) } else { middle };
            (seed, curve.point_at(at, surface.points()), Anchor::Curve { curve: self.curve, at })
        })
    }

    /// Pairs of consecutive seeds, and the arc length midway between them.
    fn stretches<'a>(&'a self, features: &'a Features) -> impl Iterator<Item = ([u32; 2], f64)> + 'a {
        let n = self.seeds.len();
        let curve = &features.curves[self.curve as usize];
        let last = if curve.is_closed() && n > 2 { n } else { n.saturating_sub(1) };
        (0..last).map(move |k| {
            let ((from, a), (to, b)) = (self.seeds[k], self.seeds[(k + 1) % n]);
            let round = if to < from { curve.length() } else { 0.0 };
            let middle = (from + to + round) / 2.0;
            ([a, b], if middle < curve.length() { middle } else { middle - curve.length() })
        })
    }

    /// New seeds in the middle of the stretches that are no edges of the mesh, each with its arc length and the distance
    /// that it leaves to the next.
    pub(super) fn splits<'a>(
        &'a self,
        features: &'a Features,
        surface: &'a Surface,
        is_edge: impl Fn(u32, u32) -> bool + 'a,
    ) -> impl Iterator<Item = (DVec3, Anchor, [u32; 2])> + 'a {
        let curve = &features.curves[self.curve as usize];
        self.stretches(features)
            .filter(move |([a, b], _)| a != b && !is_edge(*a, *b))
            .map(move |(ends, at)| (curve.point_at(at, surface.points()), Anchor::Knot { curve: self.curve, at }, ends))
    }
}

/// The balls of all stretches of creases, by seed.
pub(super) struct Guard {
    first: Vec<u32>,
    /// For each seed on a crease, the seeds next to it.
    next: Vec<u32>,
}

impl Guard {
    /// For so many seeds.
    pub(super) fn new(chains: &[Chain], features: &Features, seeds: usize) -> Guard {
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for ([p, q], _) in chains.iter().flat_map(|c| c.stretches(features)) {
            pairs.extend([[p, q], [q, p]]);
        }
        pairs.sort_unstable();
        let first = (0..=seeds as u32).map(|i| pairs.partition_point(|p| p[0] < i) as u32).collect();
        Guard { first, next: pairs.iter().map(|p| p[1]).collect() }
    }

    /// The seeds next to seed `i` on its creases.
    fn next(&self, i: u32) -> &[u32] {
        &self.next[self.first[i as usize] as usize..self.first[i as usize + 1] as usize]
    }

    /// `target` moved out of the balls of stretches that begin at any of `neighbors`, straight away from the crease;
    /// `None` where it is clear of them.
    pub(super) fn push_out(&self, target: DVec3, neighbors: &[u32], position: impl Fn(u32) -> DVec3) -> Option<DVec3> {
        let mut moved = None;
        for &p in neighbors {
            for &q in self.next(p) {
                let here = moved.unwrap_or(target);
                let (a, b) = (position(p), position(q));
                let (middle, along) = ((a + b) * 0.5, b - a);
                let radius2 = MARGIN * MARGIN * along.length_squared() / 4.0;
                let offset = here - middle;
                if offset.length_squared() >= radius2 {
                    continue;
                }
                let along = along.normalize_or_zero();
                let shift = along * offset.dot(along);
                let away = (offset - shift).try_normalize();
                // A target on the crease itself has no way out: its seed stays for this time.
                if let Some(away) = away {
                    moved = Some(middle + shift + away * (radius2 - shift.length_squared()).sqrt());
                }
            }
        }
        moved
    }
}
