//! From a motion to the places where seeds may go: each kind stays in its part of the solid.

use glam::DVec3;
use rayon::prelude::*;

use super::creases::{self, Chain, Guard};
use crate::clipped_voronoi::{Cell, ClippedVoronoi};
use crate::geometry::frame::snap;
use crate::params::Boundary;
use crate::seeds::{Anchor, Seeds};
use crate::surface::Surface;
use crate::surface::features::Features;

/// An interior seed that owns more than this share of a surface seed's mean area becomes a surface seed.
const ADOPTED_AREA: f64 = 0.12;

/// In the first iterations this share: many are on their way inside.
const ADOPTED_EARLY: f64 = 0.3;
const EARLY: usize = 10;

/// No seed moves further than this share of the spacing, or than so many steps of Lloyd where these are longer: no cell
/// is left behind.
const LONGEST: f64 = 0.5;
const LONGEST_OF_LLOYD: f64 = 2.0;

/// Seeds that one thread looks at in a row.
const BLOCK: usize = 512;

/// A place, and what a seed is bound to there.
pub(super) type Target = (DVec3, Anchor);

/// What confines seeds.
#[derive(Clone, Copy)]
pub(super) struct Confines<'a> {
    pub(super) surface: &'a Surface,
    pub(super) features: &'a Features,
    pub(super) boundary: Boundary,
    /// The least area with which an interior seed becomes a surface seed, over the square of the spacing.
    pub(super) adopted_area: f64,
}

/// See [`Confines::adopted_area`]: after so many iterations.
pub(super) fn adopted_area(iterations: usize) -> f64 {
    let share = if iterations < EARLY { ADOPTED_EARLY } else { ADOPTED_AREA };
    // Of the area of a hexagon.
    share * 0.866
}

impl Confines<'_> {
    /// The seeds of creases; none where all are free.
    pub(super) fn chains(&self, anchors: &[Anchor]) -> Vec<Chain> {
        match self.boundary {
            Boundary::Conform => creases::chains(self.features, anchors),
            Boundary::Free => Vec::new(),
        }
    }

    /// Where each seed goes by `motion`, given the step of Lloyd.
    pub(super) fn targets(
        &self,
        seeds: &Seeds,
        clipped: &ClippedVoronoi,
        chains: &[Chain],
        motion: &[DVec3],
        lloyd: &[DVec3],
    ) -> Vec<Target> {
        let mut targets = vec![(DVec3::ZERO, Anchor::Interior); seeds.positions.len()];
        targets.par_chunks_mut(BLOCK).enumerate().for_each(|(block, targets)| {
            let (mut along, mut on_surface) = (Vec::with_capacity(BLOCK), Vec::with_capacity(BLOCK));
            for (n, target) in targets.iter_mut().enumerate() {
                let i = block * BLOCK + n;
                let at = seeds.positions[i];
                let spacing = seeds.spacing_at(at);
                let longest = (LONGEST * spacing).max(LONGEST_OF_LLOYD * lloyd[i].length());
                let way = motion[i].clamp_length_max(longest);
                *target = match seeds.anchors[i] {
                    Anchor::Interior => self.interior(at, way, &clipped.cells[i], spacing),
                    fixed => (at, fixed),
                };
                if let (Anchor::Surface { triangle }, true) = (seeds.anchors[i], way != DVec3::ZERO) {
                    along.push((at + way, triangle));
                    on_surface.push(n);
                }
            }
            self.surface.tree().closest_near_each(&along, |n, closest| {
                targets[on_surface[n]] = (snap(closest.point), Anchor::Surface { triangle: closest.triangle });
            });
        });
        if self.boundary == Boundary::Conform {
            self.settle_creases(&mut targets, clipped, chains, motion);
        }
        targets
    }

    /// Moves the seeds of creases, and those of the surface out of their way.
    fn settle_creases(&self, targets: &mut [Target], clipped: &ClippedVoronoi, chains: &[Chain], motion: &[DVec3]) {
        for (i, at, anchor) in chains.iter().flat_map(|c| c.targets(self.features, self.surface, motion)) {
            targets[i as usize] = (snap(at), anchor);
        }
        let guard = Guard::new(chains, targets.len());
        let position = |p: u32| targets[p as usize].0;
        let pushed: Vec<Option<Target>> = targets
            .par_iter()
            .enumerate()
            .map(|(i, target)| match target.1 {
                Anchor::Surface { .. } => {
                    guard.push_out(target.0, clipped.adjacency.of(i), position).map(|p| self.onto_surface(p))
                }
                _ => None,
            })
            .collect();
        for (target, pushed) in targets.iter_mut().zip(pushed) {
            *target = pushed.unwrap_or(*target);
        }
    }

    /// Along its way; in a gap of the surface, to a place on it.
    fn interior(&self, at: DVec3, way: DVec3, cell: &Cell, spacing: f64) -> Target {
        if self.boundary == Boundary::Conform && cell.area > self.adopted_area * spacing * spacing {
            return self.onto_surface(at + cell.area_moment / cell.area_mass);
        }
        (snap(at + way), Anchor::Interior)
    }

    /// The closest point of the surface.
    fn onto_surface(&self, at: DVec3) -> Target {
        let closest = self.surface.tree().closest(at);
        (snap(closest.point), Anchor::Surface { triangle: closest.triangle })
    }
}
