//! Where further seeds on the surface would mend what labels cannot.

use glam::DVec3;

use super::Sampling;
use super::defects::{Defect, DefectKind};
use crate::clipped_voronoi::Crossing;
use crate::geometry::triangle::{centroid, closest_point};
use crate::seeds::{Anchor, SeedKind};

/// A seed to insert on the surface or a crease.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// Where, on the surface, in the frame.
    pub place: DVec3,
    /// What it is bound to there.
    pub anchor: Anchor,
    /// How far apart seeds should be there: the distance to the nearest one now, at most the spacing.
    pub size: f64,
    /// The seed of the interior that had better move here than a new one be made.
    pub replaces: Option<u32>,
}

/// Proposals closer than this share of the spacing to a seed would only crowd it.
const CROWDED: f64 = 0.02;
/// Proposals keep this share of the larger of their sizes between each other.
const APART: f64 = 0.7;
/// An exposed seed deeper than this share of the spacing is at the bottom of a pit.
const PIT: f64 = 0.5;
/// Seeds within keep this share of the spacing to the surface.
const DEEP: f64 = 0.15;
/// Cosine of the angle to straight back below which a sheet faces another: 45 degrees.
const OPPOSITE: f64 = 0.7;
/// At most so many: the triangulation is to be made anew after them anyway.
pub const MOST: usize = 1000;
/// Seeds proposed for a shell that has none.
const PER_SHELL: usize = 6;

/// Proposes seeds for `defects`, the farthest from present seeds first, apart from those and from each other.
pub fn proposals(sampling: &Sampling, defects: &[Defect]) -> Vec<Proposal> {
    let mut all: Vec<Proposal> = Vec::new();
    for defect in defects {
        match defect.kind {
            DefectKind::MissingShell => all.extend(for_shell(sampling, defect)),
            DefectKind::FlatTet if is_deep(sampling, defect) => all.extend(within(sampling, defect)),
            // A seed more on the surface does nothing for a flat tet within.
            DefectKind::FlatTet if !on_surface(sampling, defect) => {}
            _ => all.extend(for_seeds(sampling, defect)),
        }
    }
    all.sort_by(|a, b| b.size.total_cmp(&a.size));
    let mut kept: Vec<Proposal> = Vec::new();
    for proposal in all {
        let free = |k: &Proposal| k.place.distance(proposal.place) >= APART * k.size.max(proposal.size);
        if kept.len() < MOST && kept.iter().all(free) {
            kept.push(proposal);
        }
    }
    kept
}

/// Whether there is room for a seed at a defect within the solid.
fn is_deep(sampling: &Sampling, defect: &Defect) -> bool {
    let tree = sampling.surface.tree();
    let clearance = tree.closest(defect.place).distance2.sqrt();
    clearance > DEEP * sampling.spacing.at(defect.place) && tree.is_inside(defect.place)
}

/// A seed amid the corners of a flat tet, which lie on a circle: no sphere through them is empty any more.
fn within(sampling: &Sampling, defect: &Defect) -> Option<Proposal> {
    let far = |&v: &u32| sampling.complex.points[v as usize].distance(defect.place);
    let size = defect.seeds.iter().map(far).fold(f64::INFINITY, f64::min);
    let wide = size > CROWDED * sampling.spacing.at(defect.place);
    wide.then_some(Proposal { place: defect.place, anchor: Anchor::Interior, size, replaces: None })
}

fn on_surface(sampling: &Sampling, defect: &Defect) -> bool {
    defect.seeds.iter().any(|&v| sampling.kinds[v as usize] != SeedKind::Interior)
}

/// A proposal at `place` on `triangle`; none where a seed is there already.
fn at(sampling: &Sampling, place: DVec3, triangle: u32, near: u32) -> Option<Proposal> {
    let nearest = sampling.complex.nearest(place, near);
    let spacing = sampling.spacing.at(place);
    let size = sampling.complex.points[nearest as usize].distance(place).min(spacing);
    (size > CROWDED * spacing).then_some(Proposal { place, anchor: Anchor::Surface { triangle }, size, replaces: None })
}

fn for_seeds(sampling: &Sampling, defect: &Defect) -> Option<Proposal> {
    let near = *defect.seeds.first()?;
    if is_pit(sampling, defect)
        && let Some(proposal) = at_rim(sampling, near)
    {
        return Some(proposal);
    }
    if defect.kind == DefectKind::ExposedSeed {
        // The seed itself goes to the surface: its own distance to the place does not count.
        let closest = sampling.surface.tree().closest(sampling.complex.points[near as usize]);
        let spacing = sampling.spacing.at(closest.point);
        let others = sampling.complex.star(near).iter().flat_map(|&t| sampling.complex.tets[t as usize]);
        let size = others
            .filter(|&w| w != near && (w as usize) < sampling.kinds.len())
            .map(|w| sampling.complex.points[w as usize].distance(closest.point))
            .fold(spacing, f64::min);
        return (size > CROWDED * spacing).then_some(Proposal {
            place: closest.point,
            anchor: Anchor::Surface { triangle: closest.triangle },
            size,
            replaces: Some(near),
        });
    }
    let at_mirror = defect.crossing.and_then(|c| mirrored(sampling, &c));
    let at_crossing = || defect.crossing.and_then(|c| at(sampling, c.point, c.triangle, near));
    let at_place = || {
        let closest = sampling.surface.tree().closest(defect.place);
        at(sampling, closest.point, closest.triangle, near)
    };
    // At a thin tip the seed is at that place itself.
    at_mirror.or_else(at_crossing).or_else(at_place).or_else(|| at_rim(sampling, near))
}

/// Where a sheet of the surface is closer to a seed of another sheet than to its own seeds: the place opposite that seed. From then
/// on either seed keeps the other off its sheet, however narrow the gap or the wall between the two is.
fn mirrored(sampling: &Sampling, crossing: &Crossing) -> Option<Proposal> {
    let sheet = Sheet::of(sampling, crossing.triangle);
    let bound = |v: u32| (v as usize) < sampling.kinds.len() && sampling.kinds[v as usize] != SeedKind::Interior;
    let is_foreign = |&v: &u32| bound(v) && sheet.is_opposite(sampling, v);
    let seed = crossing.facet.into_iter().find(is_foreign)?;
    let from = sampling.complex.points[seed as usize];
    let reach = DVec3::splat(from.distance(crossing.point));
    let mut closest = (crossing.point, crossing.triangle);
    sampling.surface.tree().near_box(from - reach, from + reach, |t| {
        let there = closest_point(sampling.surface.corners(t), from);
        if there.distance_squared(from) < closest.0.distance_squared(from) && sheet.has(sampling, t) {
            closest = (there, t);
        }
    });
    let (place, triangle) = closest;
    let spacing = sampling.spacing.at(place);
    let around = sampling.complex.star(seed).iter().flat_map(|&t| sampling.complex.tets[t as usize]);
    let size = around
        .filter(|&w| w != seed && bound(w) && !sheet.is_opposite(sampling, w))
        .map(|w| sampling.complex.points[w as usize].distance(place))
        .fold(spacing, f64::min);
    let anchor = Anchor::Surface { triangle };
    (size > CROWDED * spacing).then_some(Proposal { place, anchor, size, replaces: None })
}

/// The surface around one of its triangles.
struct Sheet {
    shell: u32,
    normal: DVec3,
}

impl Sheet {
    fn of(sampling: &Sampling, triangle: u32) -> Sheet {
        let normal = sampling.surface.normal2(triangle).normalize_or_zero();
        Sheet { shell: sampling.surface.shell()[triangle as usize], normal }
    }

    /// Whether a triangle near by is on this sheet.
    fn has(&self, sampling: &Sampling, triangle: u32) -> bool {
        let other = Sheet::of(sampling, triangle);
        other.shell == self.shell && other.normal.dot(self.normal) > 0.0
    }

    /// Whether seed `v`, on the surface near by, is on another shell, or faces this sheet from across a gap or a wall.
    fn is_opposite(&self, sampling: &Sampling, v: u32) -> bool {
        let at = sampling.surface.tree().closest(sampling.complex.points[v as usize]);
        let other = Sheet::of(sampling, at.triangle);
        let faces = sampling.kinds[v as usize] == SeedKind::Surface && other.normal.dot(self.normal) < -OPPOSITE;
        other.shell != self.shell || faces
    }
}

/// Whether a seed deep inside is on the boundary: two parts of the surface are so close to each other there that the tets
/// between them reach past either, and the solid misses more than a dent.
pub fn is_pit(sampling: &Sampling, defect: &Defect) -> bool {
    defect.kind == DefectKind::ExposedSeed
        && defect.seeds.iter().all(|&v| {
            let closest = sampling.surface.tree().closest(sampling.complex.points[v as usize]);
            closest.distance2 > (PIT * sampling.spacing.at(closest.point)).powi(2)
        })
}

/// On the surface between the seeds that bound the tets outside at seed `v`, where it is farthest from seeds.
fn at_rim(sampling: &Sampling, v: u32) -> Option<Proposal> {
    let complex = &sampling.complex;
    let bound = |w: &u32| (*w as usize) < complex.seeds && sampling.kinds[*w as usize] != SeedKind::Interior;
    let mut best: Option<Proposal> = None;
    for &t in complex.star(v).iter().filter(|&&t| !complex.usable(t)) {
        let rim: Vec<u32> = complex.tets[t as usize].into_iter().filter(bound).collect();
        let [a, b] = match *rim {
            [] | [_] => continue,
            _ => longest_pair(&rim, |i, j| complex.points[i as usize].distance_squared(complex.points[j as usize])),
        };
        let middle = (complex.points[a as usize] + complex.points[b as usize]) * 0.5;
        let closest = sampling.surface.tree().closest(middle);
        if let Some(proposal) = at(sampling, closest.point, closest.triangle, a)
            && best.is_none_or(|b| proposal.size > b.size)
        {
            best = Some(proposal);
        }
    }
    best
}

/// The pair with the greatest distance; the first of equals.
fn longest_pair(of: &[u32], distance: impl Fn(u32, u32) -> f64) -> [u32; 2] {
    let mut best = (f64::NEG_INFINITY, [of[0]; 2]);
    for (k, &i) in of.iter().enumerate() {
        for &j in &of[k + 1..] {
            if distance(i, j) > best.0 {
                best = (distance(i, j), [i, j]);
            }
        }
    }
    best.1
}

/// Seeds spread over a shell, each as far as can be from those before it.
fn for_shell(sampling: &Sampling, defect: &Defect) -> Vec<Proposal> {
    let surface = sampling.surface;
    let sites: Vec<(DVec3, u32)> = (0..surface.triangles().len() as u32)
        .filter(|&t| Some(surface.shell()[t as usize]) == defect.shell)
        .map(|t| {
            let [a, b, c] = surface.corners(t);
            (centroid(a, b, c), t)
        })
        .collect();
    let mut nearest = 0;
    let mut distance: Vec<f64> = sites
        .iter()
        .map(|&(p, _)| {
            nearest = sampling.complex.nearest(p, nearest);
            sampling.complex.points[nearest as usize].distance(p)
        })
        .collect();
    let mut chosen: Vec<Proposal> = Vec::new();
    for _ in 0..PER_SHELL {
        let Some((i, &size)) = distance.iter().enumerate().reduce(|a, b| if b.1 > a.1 { b } else { a }) else { break };
        if size <= 0.0 {
            break;
        }
        let (place, triangle) = sites[i];
        let anchor = Anchor::Surface { triangle };
        chosen.push(Proposal { place, anchor, size: size.min(sampling.spacing.at(place)), replaces: None });
        for (d, &(p, _)) in distance.iter_mut().zip(&sites) {
            *d = d.min(p.distance(place));
        }
    }
    // All are needed: none may be dropped for being close to another.
    let size = chosen.last().map_or(0.0, |p| p.size);
    chosen.iter_mut().for_each(|p| p.size = size);
    chosen
}
