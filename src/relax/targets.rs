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
use crate::surface::walk::Walk;

/// An interior seed that owns more than this share of a surface seed's mean area becomes a surface seed.
const ADOPTED_AREA: f64 = 0.12;

/// In the first iterations this share: many are on their way inside.
const ADOPTED_EARLY: f64 = 0.3;
const EARLY: usize = 10;

/// No seed moves further than this share of the spacing, or than so many steps of Lloyd where these are longer: no cell
/// is left behind.
const LONGEST: f64 = 0.5;
const LONGEST_OF_LLOYD: f64 = 2.0;

/// The end of a way along the surface is looked for from triangle to triangle, if it ends no further from the surface than this
/// share of its length.
const BENT: f64 = 0.2;

/// Seeds that one thread looks at in a row, and of those on the surface so many at once.
const BLOCK: usize = 512;

const AT_ONCE: usize = 16;

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
            let mut on_surface = Vec::with_capacity(BLOCK);
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
                    on_surface.push((n, triangle, way));
                }
            }
            // Memory is waited for many at a time.
            let mut corners = [[DVec3::ZERO; 3]; AT_ONCE];
            for seeds in on_surface.chunks(AT_ONCE) {
                corners.iter_mut().zip(seeds).for_each(|(corners, s)| *corners = self.surface.corners(s.1));
                for (&corners, &(n, triangle, way)) in corners.iter().zip(seeds) {
                    targets[n] = self.along_surface(targets[n].0, way, (triangle, corners));
                }
            }
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

    /// On the surface, from a place on a triangle with such corners by a way in the plane there. The point that is closest to its
    /// end from triangle to triangle; where that is not near, the closest of all.
    fn along_surface(&self, at: DVec3, way: DVec3, (triangle, corners): (u32, [DVec3; 3])) -> Target {
        let to = at + way;
        let mut found = Walk::new(self.surface).closest_on_way((triangle, corners), to);
        if found.distance2 > BENT * BENT * way.length_squared() {
            found = self.surface.tree().closest_near(to, found.triangle, self.surface.corners(found.triangle));
        }
        (snap(found.point), Anchor::Surface { triangle: found.triangle })
    }

    /// The closest point of the surface.
    fn onto_surface(&self, at: DVec3) -> Target {
        let closest = self.surface.tree().closest(at);
        (snap(closest.point), Anchor::Surface { triangle: closest.triangle })
    }
}
