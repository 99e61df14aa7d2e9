//! Steps towards an optimal Delaunay triangulation, which has fewer slivers than a centroidal Voronoi tessellation's.
//!
//! - L. Chen, *Mesh smoothing schemes based on optimal Delaunay triangulations*, 13th International Meshing Roundtable, 2004.
//! - P. Alliez, D. Cohen-Steiner, M. Yvinec, M. Desbrun, *Variational tetrahedral meshing*, ACM Transactions on Graphics
//!   24(3), 2005, doi 10.1145/1073204.1073238.
//!
//! 1. An interior seed goes to the mean of the circumcentres of its tets, weighted by their volumes. Weighted so, a flat
//!    tet with its centre far away counts for little, but pulls its vertices apart.
//! 2. Triangulate again.
//!
//! The CVT energy is blind to slivers; these steps cost it a thousandth or less. Departures: seeds of the boundary and
//! interior ones whose cells reach it stay, and no step is longer than a share of the shortest edge at the seed.

use glam::DVec3;
use rayon::prelude::*;

use crate::clipped_voronoi::ClippedVoronoi;
use crate::delaunay::Delaunay;
use crate::geometry::tetrahedron::{min_dihedral, volume};
use crate::seeds::{Anchor, Seeds};

/// A tet with a smaller dihedral angle than this, in degrees, is a sliver.
const SLIVER: f64 = 15.0;

/// The longest step over the shortest edge at the seed.
const LONGEST: f64 = 0.25;

/// How far each seed goes.
pub(super) fn motion(delaunay: &Delaunay, seeds: &Seeds, clipped: &ClippedVoronoi) -> Vec<DVec3> {
    let points = delaunay.points();
    let mut volumes = vec![0.0; points.len()];
    let mut moments = vec![DVec3::ZERO; points.len()];
    for tet in delaunay.tets() {
        let [a, b, c, d] = tet.map(|v| points[v as usize]);
        // Volume times the circumcentre, seen from a: no division, so that flat tets do no harm.
        let (u, v, w) = (b - a, c - a, d - a);
        let (size, scaled) = (
            volume(a, b, c, d),
            (v.cross(w) * u.length_squared() + w.cross(u) * v.length_squared() + u.cross(v) * w.length_squared())
                / 12.0,
        );
        for i in tet {
            volumes[i as usize] += size;
            moments[i as usize] += scaled + (a - points[i as usize]) * size;
        }
    }
    (0..seeds.positions.len())
        .into_par_iter()
        .map(|i| {
            if seeds.anchors[i] != Anchor::Interior || clipped.cells[i].area > 0.0 || volumes[i] <= 0.0 {
                return DVec3::ZERO;
            }
            let near = clipped.adjacency.of(i).iter().map(|&j| points[j as usize].distance_squared(points[i]));
            let longest = LONGEST * near.fold(f64::INFINITY, f64::min).sqrt();
            (moments[i] / volumes[i]).clamp_length_max(longest)
        })
        .collect()
}

/// Tets inside the solid that are slivers.
pub(super) fn slivers(delaunay: &Delaunay, clipped: &ClippedVoronoi) -> usize {
    let points = delaunay.points();
    let is_sliver = |tet: &[u32; 4]| {
        let [a, b, c, d] = tet.map(|v| points[v as usize]);
        min_dihedral(a, b, c, d) < SLIVER
    };
    let tets = delaunay.vertices().par_iter().zip(&clipped.inside);
    tets.filter(|(tet, inside)| **inside && is_sliver(tet)).count()
}
