//! From labels to a mesh in model units.

use rayon::prelude::*;

use super::Sampling;
use super::boundary::{Boundary, regions};
use crate::seeds::SeedKind;
use crate::tet_mesh::{BoundaryTriangle, StageTimes, TetMesh};

/// Stands for seeds that are no vertex.
const NONE: u32 = u32::MAX;

/// Takes the tets labelled `inside` out: vertices in the order of the seeds, positively oriented tets ordered by their
/// least vertex, regions numbered as the solids of the surface, outward boundary triangles.
///
/// `patch` is that of each triangle of the surface. The iterations' record is left empty. The labels should have no fatal
/// defect.
pub fn mesh(sampling: &Sampling, inside: &[bool], patch: &[u32]) -> TetMesh {
    let complex = &sampling.complex;
    let boundary = Boundary::of(complex, inside);
    let closest = closest_triangles(sampling, &boundary);
    let (region, count) = regions(complex, inside);
    let solid = solids(sampling, &boundary, &closest, &region, count);

    let (vertex, seeds) = number_vertices(sampling, inside);
    let frame = sampling.surface.frame();
    let points = seeds.iter().map(|&v| frame.to_model(complex.points[v as usize])).collect();
    let kinds: Vec<SeedKind> = seeds.iter().map(|&v| sampling.kinds[v as usize]).collect();

    // Neighbours in space are neighbours in the seeds' order: so they are in the file.
    let mut order: Vec<(u32, u32)> = (0..inside.len() as u32)
        .filter(|&t| inside[t as usize])
        .map(|t| (complex.tets[t as usize].into_iter().min().unwrap_or(NONE), t))
        .collect();
    order.sort_unstable();
    let tets = order.iter().map(|&(_, t)| complex.tets[t as usize].map(|v| vertex[v as usize])).collect();
    let regions = order.iter().map(|&(_, t)| solid[region[t as usize] as usize]).collect();

    let surface = sampling.surface;
    let triangles = (0..boundary.triangles.len())
        .map(|f| BoundaryTriangle {
            vertices: boundary.triangles[f].map(|v| vertex[v as usize]),
            region_inside: solid[region[boundary.tets[f] as usize] as usize],
            region_outside: -1,
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
fn number_vertices(sampling: &Sampling, inside: &[bool]) -> (Vec<u32>, Vec<u32>) {
    let mut vertex = vec![NONE; sampling.kinds.len()];
    for (tet, _) in sampling.complex.tets.iter().zip(inside).filter(|&(_, &inside)| inside) {
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

/// For each region of the labelling the solid of the surface that most of its boundary is closest to.
fn solids(sampling: &Sampling, boundary: &Boundary, closest: &[u32], region: &[u32], count: usize) -> Vec<u32> {
    let surface = sampling.surface;
    let mut votes: Vec<(u32, u32)> = boundary
        .tets
        .iter()
        .zip(closest)
        .map(|(&t, &c)| (region[t as usize], surface.solid_of_shell()[surface.shell()[c as usize] as usize]))
        .collect();
    votes.sort_unstable();
    let mut solid = vec![0; count];
    let mut most = vec![0; count];
    for same in votes.chunk_by(|a, b| a == b) {
        let r = same[0].0 as usize;
        if same.len() > most[r] {
            most[r] = same.len();
            solid[r] = same[0].1;
        }
    }
    solid
}
