//! Takes the mesh out of the triangulation.
//!
//! 1. [`label()`]: the restricted Delaunay tets are those whose circumcentres lie in the solid; the facets between them
//!    and the rest, the restricted Delaunay surface, are those whose dual Voronoi edges cross the surface an odd number
//!    of times. Edelsbrunner, Shah, *Triangulating topological spaces*, International Journal of Computational Geometry
//!    and Applications 7(4), 1997, doi 10.1142/S0218195997000223: where Voronoi cells, facets and edges each meet the
//!    surface in a ball, that surface is the input's up to a homeomorphism.
//! 2. [`mend()`]: where the sampling is nearly good enough, or a wall is thinner than the spacing, toggles labels near the
//!    surface until the boundary is a manifold with the input's topology and every seed is in use.
//! 3. [`defects()`], [`proposals()`]: what is left, and where further seeds on the surface would mend it, after Boissonnat,
//!    Oudot, *Provably good sampling and meshing of surfaces*, Graphical Models 67(5), 2005,
//!    doi 10.1016/j.gmod.2005.01.004: at the crossing of a Voronoi edge with the surface farthest from its seeds.
//! 4. [`mesh()`]: vertices, oriented tets, regions, boundary triangles.
//!
//! Where shells are interfaces between regions a label says not whether a tet is inside the solid but whether it is behind
//! the surface, within an odd number of shells. Labels so colour the regions that nested shells part, and the boundary between
//! the two colours is all shells, outer ones and interfaces alike: steps 1 to 3 know no difference. Only what is in front of
//! the surface and yet enclosed is part of the mesh too ([`Sampling::meshed`]).
//!
//! Cost: linear in the triangulation but for a sort of the boundary's edges; mending adds a term for each defect.

use std::borrow::Cow;

use glam::DVec3;
use rayon::prelude::*;

use crate::clipped_voronoi::ClippedVoronoi;
use crate::delaunay::Delaunay;
use crate::geometry::frame::Frame;
use crate::geometry::tetrahedron;
use crate::seeds::SeedKind;
use crate::sizing::Spacing;
use crate::surface::Surface;

pub mod boundary;

pub mod complex;

pub mod defects;

mod dense;

pub mod mend;

mod mesh;

pub mod proposals;

pub mod repair;

pub mod topology;

mod tunnels;

pub use defects::{Defect, DefectKind, defects};
pub use dense::dense_proposals;
pub use mend::mend;
pub use mesh::mesh;
pub use proposals::{Proposal, is_pit, proposals};

use complex::Complex;

/// The triangulation of the seeds, and the surface that they sample.
pub struct Sampling<'a> {
    /// The triangulation with the stars of its vertices.
    pub complex: Complex<'a>,
    /// For each seed what it is bound to; further vertices of the triangulation are auxiliary.
    pub kinds: &'a [SeedKind],
    /// The surface.
    pub surface: &'a Surface,
    /// The edge lengths that the seeds aim at, in the frame.
    pub spacing: Spacing,
}

impl<'a> Sampling<'a> {
    /// The first `kinds.len()` vertices of `delaunay` are the seeds.
    pub fn new(
        delaunay: &'a Delaunay,
        kinds: &'a [SeedKind],
        surface: &'a Surface,
        spacing: impl Into<Spacing>,
    ) -> Sampling<'a> {
        let mut complex = Complex::new(delaunay.points(), delaunay.vertices(), delaunay.neighbors(), kinds.len());
        let seeds = &delaunay.points()[..kinds.len()];
        let closest_shell = |p: DVec3| surface.shell()[surface.tree().closest(p).triangle as usize];
        if (0..surface.shell_count() as u32).any(|s| surface.solid_of_shell(s) != 0) {
            // The way from a point of a solid to the closest point of the surface lies in that solid.
            complex.solids = seeds.par_iter().map(|&p| surface.solid_of_shell(closest_shell(p))).collect();
        }
        if surface.has_interfaces() {
            let may_be_in_front = |(&p, &kind): (&DVec3, &SeedKind)| match kind {
                SeedKind::Interior => !surface.tree().is_inside(p),
                _ => surface.depth_of_shell(closest_shell(p)) > 0,
            };
            complex.in_front = seeds.par_iter().zip(kinds).map(may_be_in_front).collect();
        }
        Sampling { complex, kinds, surface, spacing: spacing.into() }
    }

    /// The tets of the mesh under the labels `inside`: these, and those in front of the surface that it encloses, where its
    /// shells are interfaces.
    pub fn meshed<'b>(&self, inside: &'b [bool]) -> Cow<'b, [bool]> {
        if !self.surface.has_interfaces() {
            return inside.into();
        }
        let enclosed = boundary::enclosed(&self.complex, inside);
        inside.iter().zip(enclosed).map(|(&behind, enclosed)| behind || enclosed).collect()
    }

    /// How deep within the solid a finite tet lies: the mean of the signed distances to the surface, negative outside,
    /// of its centroid and of the points midway between it and the corners.
    ///
    /// Unlike the circumcentre these points are in the tet: the sign tells inside from outside even where the sampling
    /// is coarser than the wall is thick.
    pub fn depth(&self, t: u32) -> f64 {
        let corners = self.complex.corners(t);
        let [a, b, c, d] = corners;
        let centroid = tetrahedron::centroid(a, b, c, d);
        let tree = self.surface.tree();
        let distance = |p: DVec3| tree.closest(p).distance2.sqrt();
        let signed = |inside: bool, distance: f64| if inside { distance } else { -distance };
        let (inside, clearance) = (tree.is_inside(centroid), distance(centroid));
        let midway = corners.map(|q| {
            let p = (centroid + q) * 0.5;
            // No surface comes between the centroid and points closer to it than the surface is.
            signed(if p.distance(centroid) < clearance { inside } else { tree.is_inside(p) }, distance(p))
        });
        (signed(inside, clearance) + midway.iter().sum::<f64>()) / 5.0
    }

    /// Whether tet `t` is too flat to keep: see [`is_flat`], or its volume is not positive as the mesh file will have it, in
    /// model coordinates.
    pub fn is_flat(&self, t: u32) -> bool {
        let (frame, corners) = (self.surface.frame(), self.complex.corners(t));
        is_flat(corners) || model_volume6(frame, corners.map(|p| frame.to_model(p))) <= 0.0
    }
}

/// Labels the restricted Delaunay tets: those with their circumcentres inside, or behind the surface where its shells are
/// interfaces, whose vertices are seeds of one solid.
pub fn label(sampling: &Sampling, clipped: &ClippedVoronoi) -> Vec<bool> {
    clipped.behind().iter().enumerate().map(|(t, &inside)| inside && sampling.complex.usable(t as u32)).collect()
}

/// Whether the volume of the tet with these corners vanishes against its size.
pub fn is_flat(corners: [DVec3; 4]) -> bool {
    const LEAST: f64 = 1e-9;
    let [a, b, c, d] = corners;
    let longest2 = tetrahedron::EDGES.iter().map(|&[i, j]| corners[i].distance_squared(corners[j])).fold(0.0, f64::max);
    tetrahedron::volume6(a, b, c, d) <= LEAST * longest2 * longest2.sqrt()
}

/// Six times the volume of a tet in the model's coordinates and arithmetic, over the cube of the frame's unit: a power of two,
/// which changes no digit but keeps the products of very small and very large models in range.
pub fn model_volume6(frame: &Frame, [a, b, c, d]: [DVec3; 4]) -> f64 {
    let [u, v, w] = [b, c, d].map(|p| (p - a) * frame.scale);
    u.cross(v).dot(w)
}
