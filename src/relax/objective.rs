//! The energy that seeds minimise, its gradient, and the diagonal of its Hessian as long as cells do not change.
//!
//! Each kind of seed belongs to a part of the solid of its own dimension, and the energy is the sum of three CVT energies,
//!
//! ```text
//! E = ∫ over Ω of |x - x(i)|^2  +  λ ∫ over its surface of ρ |x - x(i)|^2  +  μ ∫ along its creases of |s - s(i)|^2,
//! ```
//!
//! with the nearest seed in each. Where sizes s, over the largest, are to vary, the three have the densities s^-5, ρ = s^-4 and
//! s^-3 (density^(-1/(d + 2)) is the size in d dimensions, see `Clipper::set_sizing`): a seed then weighs the same in each
//! of the three, and the same as any other.
//!
//! λ is a multiple of the spacing h, μ of h^2, so that the three weigh the same per seed at
//! any count. By Reynolds' theorem the gradient is that of fixed cells (Liu, Wang, Lévy, Sun, Yan, Lu, Yang, *On
//! centroidal Voronoi tessellation: energy smoothness and fast computation*, ACM Transactions on Graphics 28(4), 2009,
//! doi 10.1145/1559755.1559758), 2 m (x(i) - c) in each term with the mass m and the centroid c of the seed's piece,
//! brought into the coordinates of the seed's kind (`tangents.rs`). Its zeros are centroidal in all dimensions at once.
//!
//! Departure: an interior seed does not feel the second term. Where its cell reaches the surface it has to give way to
//! the surface's own seeds or become one of them, and its pull there would make it stay.
//!
//! With [`Boundary::Free`](crate::params::Boundary) the first term is all.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::creases::Chain;
use super::tangents::Tangents;
use super::vectors;
use crate::clipped_voronoi::{Cell, ClippedVoronoi};
use crate::seeds::{Anchor, Seeds};
use crate::sizing::{Sizing, Spacing};
use crate::surface::Surface;

/// λ over the spacing.
const SURFACE_WEIGHT: f64 = 0.5;

/// μ over the square of the spacing.
const CREASE_WEIGHT: f64 = 0.25;

/// The energy at the seeds' places, and its slope there.
pub(super) struct Slope {
    /// E.
    pub(super) energy: f64,
    /// Its gradient, in the coordinates of each seed's kind.
    pub(super) gradient: Vec<DVec3>,
    /// D: twice the mass that each seed minimises the second moment of.
    pub(super) stiffness: Vec<f64>,
    /// The normals at the seeds, see [`Tangents::normals`].
    pub(super) normals: Vec<DVec3>,
}

impl Slope {
    /// D^-1 `v`; nothing for a seed without mass.
    pub(super) fn relaxed(&self, v: &[DVec3]) -> Vec<DVec3> {
        let entry = |(&v, &d): (&DVec3, &f64)| if d > 0.0 { v / d } else { DVec3::ZERO };
        v.par_iter().zip(&self.stiffness).map(entry).collect()
    }
}

/// What is constant of the energy.
pub(super) struct Objective {
    surface_weight: f64,
    crease_weight: f64,
    /// Where sizes vary.
    sizing: Option<Arc<Sizing>>,
    /// ∫ over the surface of ρ |x|^2.
    surface_moment: f64,
}

impl Objective {
    /// For seeds on the boundary, so far apart.
    pub(super) fn conforming(spacing: Spacing) -> Objective {
        let Spacing { largest: h, field: sizing } = spacing;
        let (surface_weight, crease_weight) = (SURFACE_WEIGHT * h, CREASE_WEIGHT * h * h);
        Objective { surface_weight, crease_weight, sizing, surface_moment: 0.0 }
    }

    /// For free seeds.
    pub(super) fn free() -> Objective {
        Objective { surface_weight: 0.0, crease_weight: 0.0, sizing: None, surface_moment: 0.0 }
    }

    /// Takes note of the density ρ, 1 or its values at the surface's vertices.
    pub(super) fn set_density(&mut self, surface: &Surface, at: impl Fn(u32) -> f64 + Sync) {
        self.surface_moment = vectors::sum(surface.triangles().len(), |t| {
            let ids = surface.triangles()[t];
            let area = 0.5 * surface.normal2(t as u32).length();
            second_moment(ids.map(|v| surface.points()[v as usize]), ids.map(&at), area)
        });
    }

    /// The slope at `seeds`, whose cells and creases are given.
    pub(super) fn slope(
        &self,
        seeds: &Seeds,
        clipped: &ClippedVoronoi,
        tangents: &Tangents,
        chains: &[Chain],
    ) -> Slope {
        let cells = &clipped.cells;
        let normals = tangents.normals(&seeds.positions, &seeds.anchors);
        let (mut gradient, mut stiffness): (Vec<DVec3>, Vec<f64>) = (0..cells.len())
            .into_par_iter()
            .map(|i| {
                let Cell { mass, moment, area_moment, area_mass, .. } = cells[i];
                let weight = if seeds.anchors[i] == Anchor::Interior { 0.0 } else { self.surface_weight };
                let force = -2.0 * (moment + weight * area_moment);
                let mass = mass + weight * area_mass;
                let anchor = seeds.anchors[i];
                (tangents.force(anchor, normals[i], force), 2.0 * mass)
            })
            .unzip();
        let mut energy = vectors::sum(cells.len(), |i| cells[i].energy);
        if self.surface_weight > 0.0 {
            // ∫ |x - s|^2 = ∫ |x|^2 - 2 s.∫ (x - s) - |s|^2 ∫ 1, with the first summed over all cells once and for all.
            let known = vectors::sum(cells.len(), |i| {
                let s = seeds.positions[i];
                2.0 * s.dot(cells[i].area_moment) + s.length_squared() * cells[i].area_mass
            });
            energy += self.surface_weight * (self.surface_moment - known);
        }
        for chain in chains {
            if let Some(sizing) = &self.sizing {
                energy += self.crease_weight * self.add_crease(chain, tangents, sizing, &mut gradient, &mut stiffness);
                continue;
            }
            energy += self.crease_weight * chain.energy();
            for gap in chain.gaps() {
                let i = gap.seed as usize;
                gradient[i].x += self.crease_weight * (gap.before * gap.before - gap.after * gap.after) / 4.0;
                stiffness[i] += self.crease_weight * (gap.before + gap.after);
            }
        }
        Slope { energy, gradient, stiffness, normals }
    }
}

impl Objective {
    /// Adds a crease whose density is linear between seeds and the middles of the ways between them; its energy.
    ///
    /// From a seed with density a over the half way L to where it is b: mass L (a + b) / 2, first moment L² (a + 2 b) / 6,
    /// second moment L³ (a + 3 b) / 12.
    fn add_crease(
        &self,
        chain: &Chain,
        tangents: &Tangents,
        sizing: &Sizing,
        gradient: &mut [DVec3],
        stiffness: &mut [f64],
    ) -> f64 {
        let density = |at: f64| sizing.relative(tangents.on_crease(chain.curve(), at)).powi(-3);
        let second = |way: f64, from: f64, to: f64| way * way * way * (density(from) + 3.0 * density(to)) / 12.0;
        for gap in chain.gaps() {
            let i = gap.seed as usize;
            let here = density(gap.at);
            for (way, side) in [(0.5 * gap.before, -1.0), (0.5 * gap.after, 1.0)] {
                let there = density(gap.at + side * way);
                gradient[i].x -= side * self.crease_weight * way * way * (here + 2.0 * there) / 3.0;
                stiffness[i] += self.crease_weight * way * (here + there);
            }
        }
        let between = chain.ways().map(|[from, to]| {
            let (half, middle) = (0.5 * (to - from), 0.5 * (from + to));
            second(half, from, middle) + second(half, to, middle)
        });
        let before = chain.first_way().map_or(0.0, |[from, to]| {
            let (half, middle) = (0.5 * (to - from), 0.5 * (from + to));
            second(half, from, middle) + second(half, to, middle)
        });
        between.sum::<f64>() + before
    }
}

/// ∫ ρ |x|^2 over a triangle, ρ linear between its corners: of degree 3, and exact.
fn second_moment(corners: [DVec3; 3], density: [f64; 3], area: f64) -> f64 {
    let [a, b, c] = corners;
    let squares = corners.map(|p| p.length_squared());
    let sum = a + b + c;
    let mass: f64 = density.iter().sum();
    let weighted = a * density[0] + b * density[1] + c * density[2];
    let weighted_squares = (0..3).map(|k| density[k] * squares[k]).sum::<f64>();
    let squares: f64 = squares.iter().sum();
    area / 60.0 * (mass * (sum.length_squared() + squares) + 2.0 * (sum.dot(weighted) + weighted_squares))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clipped_voronoi::{Clipper, Density};
    use crate::delaunay::Delaunay;
    use crate::params::{Params, Target};
    use crate::relax::{creases, tangents};
    use crate::seeds;
    use crate::sizing::{SizeField, Sizes};
    use crate::surface::features::Features;

    fn cube() -> Surface {
        let points: Vec<DVec3> =
            (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Surface::new(&points, &triangles, &(0..12).collect::<Vec<u32>>(), &[0; 12]).expect("a cube")
    }

    #[test]
    fn the_gradient_is_that_of_the_energy_for_every_kind_of_seed() {
        compare(&cube(), None, 1e-4);
    }

    /// The density of the solid is linear in pieces that move with the seeds, which the gradient leaves out.
    #[test]
    fn the_gradient_is_nearly_that_of_the_energy_where_sizes_vary() {
        let surface = cube();
        let features = Features::find(&surface, 40.0);
        let field = Some(SizeField::Expression("0.1 + 0.1*x".to_owned()));
        let sizes = Sizes { field, ..Sizes::default() };
        let sizing = Sizing::new(&surface, &features, &sizes, None).expect("sizes").expect("they vary");
        compare(&sizing.refined(&surface), Some(sizing), 0.03);
    }

    /// Differences of the energy against the gradient, over the largest gradient, for seeds of every kind.
    fn compare(surface: &Surface, sizing: Option<Arc<Sizing>>, tolerance: f64) {
        let features = Features::find(surface, 40.0);
        let params = Params { target: Target::Count(400), ..Params::default() };
        let seeds = seeds::sample_sized(surface, &features, &params, sizing.clone()).expect("seeds");
        let tangents = Tangents::new(surface, &features);
        let mut objective = Objective::conforming(seeds.spacings());
        let density: Vec<f64> = seeds.relative_size.iter().map(|s| s.powi(-4)).collect();
        objective.set_density(surface, |v| density[v as usize]);
        let slope = |seeds: &Seeds| {
            let mut clipper = Clipper::new(surface);
            if let Some(sizing) = &sizing {
                clipper.set_sizing(sizing.clone());
                clipper.set_density(Density::Vertices(density.clone()));
            }
            let clipped = clipper.clip(&Delaunay::build(&seeds.positions).expect("distinct seeds"));
            let chains = creases::chains(&features, &seeds.anchors);
            (objective.slope(seeds, &clipped, &tangents, &chains), clipped)
        };
        let (here, clipped) = slope(&seeds);
        let scale = here.gradient.iter().map(|g| g.length()).fold(0.0, f64::max);
        let mut tested = [0; 3];
        for i in (0..seeds.positions.len()).step_by(7) {
            let step = 1e-5;
            let kind = seeds.anchors[i].kind() as usize;
            // Where an interior seed reaches the surface the gradient leaves a part of the energy out.
            if kind == 3 || kind == 0 && clipped.cells[i].area > 0.0 {
                continue;
            }
            let moved = |way: f64| {
                let mut moved = seeds.clone();
                let direction = tangents::motion(seeds.anchors[i], here.normals[i], DVec3::new(1.0, 0.7, -0.4));
                if let Anchor::Curve { curve, at } = seeds.anchors[i] {
                    let at = at + way * direction.x;
                    moved.positions[i] = features.curves[curve as usize].point_at(at, surface.points());
                    moved.anchors[i] = Anchor::Curve { curve, at };
                } else {
                    moved.positions[i] += way * direction;
                }
                moved.positions[i] = crate::geometry::frame::snap(moved.positions[i]);
                (slope(&moved).0.energy, direction)
            };
            let ((up, direction), (down, _)) = (moved(step), moved(-step));
            let measured = (up - down) / (2.0 * step);
            let claimed = here.gradient[i].dot(direction);
            assert!(
                (measured - claimed).abs() < tolerance * scale,
                "kind {kind}: {measured} against {claimed}, {scale}"
            );
            tested[kind] += 1;
        }
        assert!(tested.iter().all(|&n| n > 0), "{tested:?}");
    }
}
