//! From labels to a mesh in model units.

use rayon::prelude::*;

use super::Sampling;
use super::boundary::{Boundary, OUTSIDE, regions};
use crate::seeds::SeedKind;
use crate::tet_mesh::{BoundaryTriangle, StageTimes, TetMesh};

/// Stands for seeds that are no vertex.
const NONE: u32 = u32::MAX;

/// Takes the tets of the mesh out, those labelled `inside` and those enclosed between interfaces: vertices in the order of the
/// seeds, positively oriented tets ordered by their least vertex, regions numbered as those of the surface, boundary triangles
/// as seen from the side that is not `inside`.
///
/// `patch` is that of each triangle of the surface. The iterations' record is left empty. The labels should have no fatal
/// defect.
pub fn mesh(sampling: &Sampling, inside: &[bool], patch: &[u32]) -> TetMesh {
    let complex = &sampling.complex;
    let boundary = Boundary::of(complex, inside);
    let closest = closest_triangles(sampling, &boundary);
    let meshed = &sampling.meshed(inside);
    let part = Parts::of(sampling, inside, meshed);
    let region = part.regions(sampling, &boundary, &closest);

    let (vertex, seeds) = number_vertices(sampling, meshed);
    let frame = sampling.surface.frame();
    let points = seeds.iter().map(|&v| frame.to_model(complex.points[v as usize])).collect();
    let kinds: Vec<SeedKind> = seeds.iter().map(|&v| sampling.kinds[v as usize]).collect();

    // Neighbours in space are neighbours in the seeds' order: so they are in the file.
    let mut order: Vec<(u32, u32)> = (0..meshed.len() as u32)
        .filter(|&t| meshed[t as usize])
        .map(|t| (complex.tets[t as usize].into_iter().min().unwrap_or(NONE), t))
        .collect();
    order.sort_unstable();
    let tets = order.iter().map(|&(_, t)| complex.tets[t as usize].map(|v| vertex[v as usize])).collect();
    let region_of = |t: u32| region.get(part.of_tets[t as usize] as usize).copied();
    let own = |t: u32| region_of(t).expect("every tet of the mesh is in a part of it: this is a bug in tetcvt");
    let regions = order.iter().map(|&(_, t)| own(t)).collect();

    let surface = sampling.surface;
    let triangles = (0..boundary.triangles.len())
        .map(|f| BoundaryTriangle {
            vertices: boundary.triangles[f].map(|v| vertex[v as usize]),
            region_inside: own(boundary.tets[f]),
            region_outside: region_of(boundary.beyond[f]).map_or(-1, |r| r as i32),
            patch: patch[closest[f] as usize],
            source_triangle: surface.source()[closest[f] as usize],
        })
        .collect();
    TetMesh {
        points,
        kinds,
        seeds,
        tets,
        regions,
        boundary: triangles,
        steps: Vec::new(),
        size_ratio: None,
        stopped: String::new(),
        improved: String::new(),
        times: StageTimes::default(),
    }
}

/// For each seed its vertex in the mesh, and for each vertex its seed.
fn number_vertices(sampling: &Sampling, meshed: &[bool]) -> (Vec<u32>, Vec<u32>) {
    let mut vertex = vec![NONE; sampling.kinds.len()];
    for (tet, _) in sampling.complex.tets.iter().zip(meshed).filter(|&(_, &meshed)| meshed) {
        tet.iter().for_each(|&v| vertex[v as usize] = 0);
    }
    let seeds: Vec<u32> = (0..vertex.len() as u32).filter(|&v| vertex[v as usize] != NONE).collect();
    for (i, &v) in seeds.iter().enumerate() {
        vertex[v as usize] = i as u32;
    }
    (vertex, seeds)
}

/// For each boundary triangle the triangle of the surface closest to its centroid, of those that face the same way
/// where there are such nearby.
fn closest_triangles(sampling: &Sampling, boundary: &Boundary) -> Vec<u32> {
    let surface = sampling.surface;
    boundary
        .triangles
        .par_iter()
        .map(|vertices| surface.facing(vertices.map(|v| sampling.complex.points[v as usize])))
        .collect()
}

/// The connected parts of the mesh: tets of one label that share a facet share a part.
struct Parts {
    /// For each tet its part, or [`OUTSIDE`].
    of_tets: Vec<u32>,
    count: usize,
}

impl Parts {
    fn of(sampling: &Sampling, inside: &[bool], meshed: &[bool]) -> Parts {
        let (mut of_tets, mut count) = regions(&sampling.complex, inside);
        if sampling.surface.has_interfaces() {
            let in_front: Vec<bool> = inside.iter().zip(meshed).map(|(&inside, &meshed)| meshed && !inside).collect();
            let (more, further) = regions(&sampling.complex, &in_front);
            for (part, more) in of_tets.iter_mut().zip(more).filter(|(_, more)| *more != OUTSIDE) {
                *part = count as u32 + more;
            }
            count += further;
        }
        Parts { of_tets, count }
    }

    /// For each part the region of the surface that most of its boundary is closest to.
    fn regions(&self, sampling: &Sampling, boundary: &Boundary, closest: &[u32]) -> Vec<u32> {
        let surface = sampling.surface;
        let mut votes: Vec<(u32, i32)> = Vec::with_capacity(closest.len());
        for ((&t, &beyond), &c) in boundary.tets.iter().zip(&boundary.beyond).zip(closest) {
            let regions = surface.regions_of_shell(surface.shell()[c as usize]);
            let parts = [t, beyond].map(|t| self.of_tets[t as usize]);
            votes.extend(parts.into_iter().zip(regions).filter(|&(part, region)| part != OUTSIDE && region >= 0));
        }
        votes.sort_unstable();
        let mut region = vec![0; self.count];
        let mut most = vec![0; self.count];
        for same in votes.chunk_by(|a, b| a == b) {
            let part = same[0].0 as usize;
            if same.len() > most[part] {
                most[part] = same.len();
                region[part] = same[0].1 as u32;
            }
        }
        region
    }
}
