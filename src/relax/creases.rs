//! Seeds on creases, and the room that the surface leaves them.
//!
//! The stretch of a crease between two consecutive seeds is an edge of the restricted Delaunay surface if its smallest
//! ball holds no other seed (a Gabriel edge). Seeds on the surface are kept out of these balls, so that the mesh has its
//! creases whole.

use glam::DVec3;

use crate::seeds::Anchor;
use crate::surface::Surface;
use crate::surface::features::{Curve, Features};

/// Balls are so much larger than the smallest.
const MARGIN: f64 = 1.1;

/// No seed goes further towards the next one than this share of the way.
const NO_FURTHER: f64 = 0.45;

/// The seeds of one crease, in order along it.
pub(super) struct Chain {
    curve: u32,
    length: f64,
    closed: bool,
    seeds: Vec<Link>,
}

/// A seed of a crease, or the corner at its end; corners and knots stay.
#[derive(Clone, Copy)]
struct Link {
    /// Arc length.
    at: f64,
    seed: u32,
    is_fixed: bool,
}

/// A seed that moves along a crease, and the ways to the next ones.
pub(super) struct Gap {
    pub(super) seed: u32,
    /// Its arc length.
    pub(super) at: f64,
    pub(super) before: f64,
    pub(super) after: f64,
}

/// The seeds of every crease.
pub(super) fn chains(features: &Features, anchors: &[Anchor]) -> Vec<Chain> {
    let chain =
        |(curve, c): (u32, &Curve)| Chain { curve, length: c.length(), closed: c.is_closed(), seeds: Vec::new() };
    let mut chains: Vec<Chain> = (0..).zip(&features.curves).map(chain).collect();
    let mut corners: Vec<(u32, u32)> = Vec::new();
    for (seed, anchor) in (0..).zip(anchors) {
        match *anchor {
            Anchor::Curve { curve, at } => chains[curve as usize].seeds.push(Link { at, seed, is_fixed: false }),
            Anchor::Knot { curve, at } => chains[curve as usize].seeds.push(Link { at, seed, is_fixed: true }),
            Anchor::Corner { vertex } => corners.push((vertex, seed)),
            _ => {}
        }
    }
    corners.sort_unstable();
    let corner = |v: u32| corners.binary_search_by_key(&v, |c| c.0).ok().map(|k| corners[k].1);
    for (chain, curve) in chains.iter_mut().zip(&features.curves) {
        if !chain.closed {
            let ends = [(0.0, curve.vertices[0]), (chain.length, curve.vertices[curve.vertices.len() - 1])];
            let link = |(at, v)| corner(v).map(|seed| Link { at, seed, is_fixed: true });
            chain.seeds.extend(ends.into_iter().filter_map(link));
        }
        chain.seeds.sort_unstable_by(|a, b| a.at.total_cmp(&b.at).then(a.seed.cmp(&b.seed)));
    }
    chains
}

impl Chain {
    /// Arc lengths of the seeds before and after the k-th; the ends of an open crease count as seeds.
    fn around(&self, k: usize) -> [f64; 2] {
        let n = self.seeds.len();
        let before = match k {
            0 if self.closed => self.seeds[n - 1].at - self.length,
            0 => 0.0,
            _ => self.seeds[k - 1].at,
        };
        let after = match k + 1 {
            next if next < n => self.seeds[next].at,
            _ if self.closed => self.seeds[0].at + self.length,
            _ => self.length,
        };
        [before, after]
    }

    /// The seeds that move, with the ways to the next ones: the piece of each ends half-way.
    pub(super) fn gaps(&self) -> impl Iterator<Item = Gap> + '_ {
        (0..self.seeds.len()).filter(|&k| !self.seeds[k].is_fixed).map(|k| {
            let (Link { at, seed, .. }, [before, after]) = (self.seeds[k], self.around(k));
            Gap { seed, at, before: at - before, after: after - at }
        })
    }

    /// The crease.
    pub(super) fn curve(&self) -> u32 {
        self.curve
    }

    /// Every stretch that has a seed before it, as the arc lengths of its ends; those around a seam go on beyond the length.
    pub(super) fn ways(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        (0..self.seeds.len()).map(|k| [self.seeds[k].at, self.around(k)[1]])
    }

    /// The stretch before the first seed, which only an open crease has.
    pub(super) fn first_way(&self) -> Option<[f64; 2]> {
        (!self.closed).then(|| self.seeds.first().map(|s| [0.0, s.at])).flatten()
    }

    /// The integral of the squared distance along the crease to the nearest seed.
    pub(super) fn energy(&self) -> f64 {
        let n = self.seeds.len();
        let cube = |gap: f64| gap * gap * gap / 12.0;
        let after: f64 = (0..n).map(|k| cube(self.around(k)[1] - self.seeds[k].at)).sum();
        // On an open crease the stretch before the first is still missing.
        if self.closed || n == 0 { after } else { after + cube(self.seeds[0].at) }
    }

    /// Where each seed goes that moves by so much along the crease, never past the next.
    pub(super) fn targets<'a>(
        &'a self,
        features: &'a Features,
        surface: &'a Surface,
        motion: &'a [DVec3],
    ) -> impl Iterator<Item = (u32, DVec3, Anchor)> + 'a {
        let curve = &features.curves[self.curve as usize];
        self.seeds.iter().zip(0..).filter(|(link, _)| !link.is_fixed).map(move |(link, k)| {
            let [before, after] = self.around(k);
            let way = motion[link.seed as usize].x;
            let at = link.at + way.clamp(NO_FURTHER * (before - link.at), NO_FURTHER * (after - link.at));
            let at = if self.closed { at.rem_euclid(self.length) } else { at };
            (link.seed, curve.point_at(at, surface.points()), Anchor::Curve { curve: self.curve, at })
        })
    }

    /// Pairs of consecutive seeds, and the arc length where a seed between them goes: about midway; from a corner a power
    /// of two away, so that creases that meet there at an acute angle have seeds on common spheres around it and none comes
    /// into the balls of the other (Shewchuk, *Delaunay refinement algorithms for triangular mesh generation*,
    /// Computational Geometry 22, 2002, doi 10.1016/S0925-7721(01)00047-5: concentric shells).
    fn stretches(&self) -> impl Iterator<Item = ([u32; 2], f64)> + '_ {
        let n = self.seeds.len();
        let last = if self.closed && n > 2 { n } else { n.saturating_sub(1) };
        (0..last).map(move |k| {
            let (a, b) = (self.seeds[k], self.seeds[(k + 1) % n]);
            let length = if b.at < a.at { b.at + self.length } else { b.at } - a.at;
            let shell = (0.5 * length).log2().round().exp2();
            let way = match [k == 0, k + 2 == n].map(|end| end && !self.closed) {
                [true, _] => shell,
                [false, true] => length - shell,
                [false, false] => 0.5 * length,
            };
            let at = a.at + way;
            ([a.seed, b.seed], if at < self.length { at } else { at - self.length })
        })
    }

    /// New seeds in the middle of the stretches that are no edges of the mesh, each with the seeds before and after.
    pub(super) fn splits<'a>(
        &'a self,
        features: &'a Features,
        surface: &'a Surface,
        is_edge: impl Fn(u32, u32) -> bool + 'a,
    ) -> impl Iterator<Item = (DVec3, Anchor, [u32; 2])> + 'a {
        let curve = &features.curves[self.curve as usize];
        self.stretches()
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
    pub(super) fn new(chains: &[Chain], seeds: usize) -> Guard {
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for ([p, q], _) in chains.iter().flat_map(Chain::stretches) {
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
