//! Seeds all over the surface around places that single seeds did not mend.
//!
//! A sheet that no point of is farther from its own seeds than from those of another sheet is there in the restricted Delaunay
//! surface, whatever lies behind it. Seeds put where one thing is wrong, one at a time, may chase the fault around a thin rim or a
//! narrow gap; put everywhere around at a distance that shrinks from round to round they come to an end.

use std::collections::BTreeSet;

use glam::DVec3;

use super::Sampling;
use super::proposals::{MOST, Proposal};
use crate::geometry::places::Places;
use crate::seeds::{Anchor, SeedKind};

/// Samples of a triangle are so far apart, over the distance between seeds.
const STEP: f64 = 0.35;

/// Samples along an edge at most.
const FINEST: usize = 64;

/// The side of a shell that a place is on; on creases and corners, which are on several, without a normal.
#[derive(Clone, Copy, Debug)]
struct Side {
    shell: u32,
    normal: Option<DVec3>,
}

impl Side {
    fn of(sampling: &Sampling, triangle: u32) -> Side {
        let normal = Some(sampling.surface.normal2(triangle).normalize_or_zero());
        Side { shell: sampling.surface.shell()[triangle as usize], normal }
    }

    fn of_seed(sampling: &Sampling, place: DVec3, kind: SeedKind) -> Side {
        let side = Side::of(sampling, sampling.surface.tree().closest(place).triangle);
        if kind == SeedKind::Surface { side } else { Side { normal: None, ..side } }
    }

    /// Whether places near each other on these sides are on one sheet.
    fn continues(&self, other: &Side) -> bool {
        let along = self.normal.zip(other.normal).is_none_or(|(one, other)| one.dot(other) > 0.0);
        self.shell == other.shell && along
    }
}

/// Proposes seeds so that up to `reach` around `places` no point of a sheet is farther than `gap` from a seed of that sheet; both
/// over the spacing.
pub fn dense_proposals(sampling: &Sampling, places: &[DVec3], (gap, reach): (f64, f64)) -> Vec<Proposal> {
    let surface = sampling.surface;
    let largest = sampling.spacing.largest;
    let mut faults: Places = Places::new(largest);
    let mut around = BTreeSet::new();
    for &place in places {
        faults.insert(place);
        let far = reach * sampling.spacing.at(place);
        surface.tree().near_box(place - far, place + far, |t| {
            around.insert(t);
        });
    }
    let is_near = |p: DVec3, reach: f64| faults.any_within(p, reach * sampling.spacing.at(p));
    let mut taken = Places::new(gap * largest);
    for (&p, &kind) in sampling.complex.points.iter().zip(sampling.kinds) {
        if kind != SeedKind::Interior && is_near(p, reach + gap) {
            taken.insert_with(p, Side::of_seed(sampling, p, kind));
        }
    }
    let mut found = Vec::new();
    for triangle in around {
        let side = Side::of(sampling, triangle);
        for place in samples(surface.corners(triangle), STEP * gap * largest) {
            let apart = gap * sampling.spacing.at(place);
            if is_near(place, reach) && !taken.any_within_that(place, apart, |s| s.continues(&side)) {
                taken.insert_with(place, side);
                let anchor = Anchor::Surface { triangle };
                found.push(Proposal { place, anchor, size: apart, replaces: None });
                if found.len() == MOST {
                    return found;
                }
            }
        }
    }
    found
}

/// Points of a triangle in rows, the corners left out, about `step` apart.
fn samples([a, b, c]: [DVec3; 3], step: f64) -> impl Iterator<Item = DVec3> {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let rows = ((longest / step).ceil() as usize).clamp(1, FINEST);
    let share = move |i: usize| (i as f64 + 1.0 / 3.0) / rows as f64;
    (0..rows).flat_map(move |i| (0..rows - i).map(move |j| a + (b - a) * share(i) + (c - a) * share(j)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_lie_in_the_triangle_and_are_no_farther_apart_than_asked() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for step in [2.0, 0.3, 0.05] {
            let all: Vec<DVec3> = samples(corners, step).collect();
            assert!(all.iter().all(|p| p.x > 0.0 && p.y > 0.0 && p.x + p.y < 1.0));
            for q in samples(corners, 0.02) {
                assert!(all.iter().any(|p| p.distance(q) <= step), "{q} for {step}");
            }
        }
    }
}
