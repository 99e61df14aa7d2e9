//! What keeps labels from being a mesh, and where.

use glam::DVec3;
use rayon::prelude::*;

use super::Sampling;
use super::boundary::Boundary;
use super::topology::Topology;
use crate::clipped_voronoi::Crossing;
use crate::geometry::{tetrahedron, triangle};
use crate::seeds::SeedKind;
use crate::surface::edges;

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DefectKind {
    /// An edge with more than two boundary triangles.
    NonManifoldEdge,
    /// A vertex with more than one fan of boundary triangles.
    NonManifoldVertex,
    /// A seed in no tet.
    UnusedSeed,
    /// A tet without volume.
    FlatTet,
    /// A shell of the surface that no component of the boundary stands for.
    MissingShell,
    /// More than one component of the boundary for one shell, or a component too many.
    ExtraComponent,
    /// A component of the boundary that stands for two shells at once.
    BridgedShells,
    /// The wrong number of handles.
    WrongGenus,
    /// A seed on the surface that is not on the boundary. The mesh is valid all the same.
    BuriedSeed,
    /// A seed of the interior that is on the boundary. The mesh is valid all the same, with a dent.
    ExposedSeed,
}

impl DefectKind {
    /// Whether a mesh with such a defect must not be written.
    pub fn is_fatal(self) -> bool {
        !matches!(self, DefectKind::BuriedSeed | DefectKind::ExposedSeed)
    }

    /// What cannot be represented, for a message.
    pub fn describe(self) -> &'static str {
        match self {
            DefectKind::NonManifoldEdge => "the boundary meets itself along an edge",
            DefectKind::NonManifoldVertex => "the boundary meets itself at a vertex",
            DefectKind::UnusedSeed => "a seed is in no tet",
            DefectKind::FlatTet => "a tet has no volume",
            DefectKind::MissingShell => "a shell of the surface is lost",
            DefectKind::ExtraComponent => "a shell of the surface falls apart",
            DefectKind::BridgedShells => "two shells of the surface grow together",
            DefectKind::WrongGenus => "a handle or a hole is lost or made up",
            DefectKind::BuriedSeed => "a seed on the surface is not on the boundary",
            DefectKind::ExposedSeed => "a seed of the interior is on the boundary",
        }
    }
}

/// Facets that meet a shell in several arcs point to its lost handles while they hold at most this share of its crossings.
const TELLING: f64 = 0.1;

/// Cosine of the angle to the surface beyond which a triangle of the boundary stands across it: 75 degrees.
const STEEP: f64 = 0.26;

/// A defect of a labelling.
#[derive(Clone, Debug, PartialEq)]
pub struct Defect {
    /// What is wrong.
    pub kind: DefectKind,
    /// Where, in the frame.
    pub place: DVec3,
    /// The seeds involved, ascending.
    pub seeds: Vec<u32>,
    /// Of the crossings of Voronoi edges with the surface at these seeds, the one farthest from its seeds.
    pub crossing: Option<Crossing>,
    /// The shell of the surface, where the defect is one of topology.
    pub shell: Option<u32>,
}

/// Finds every defect of the labels `inside`, by kind and seed. Topology is looked at only where the boundary is a
/// manifold, without which components and handles mean nothing.
pub fn defects(sampling: &Sampling, inside: &[bool], crossings: &[Crossing]) -> Vec<Defect> {
    let boundary = Boundary::of(&sampling.complex, inside);
    let meshed = &sampling.meshed(inside);
    let mut found = vertex_defects(sampling, inside, meshed, &boundary);
    let manifold = !found.iter().any(|d| d.kind < DefectKind::UnusedSeed);
    found.extend(flat_tets(sampling, meshed));
    if manifold {
        found.extend(topology_defects(sampling, inside, &boundary, crossings));
    }
    found.sort_by(|a, b| (a.kind, &a.seeds).cmp(&(b.kind, &b.seeds)));
    attach_crossings(sampling, &mut found, crossings);
    found
}

fn defect(sampling: &Sampling, kind: DefectKind, seeds: Vec<u32>) -> Defect {
    let sum: DVec3 = seeds.iter().map(|&v| sampling.complex.points[v as usize]).sum();
    Defect { kind, place: sum / seeds.len() as f64, seeds, crossing: None, shell: None }
}

/// Edges and vertices where the boundary is no manifold, and seeds that are not where they belong.
fn vertex_defects(sampling: &Sampling, inside: &[bool], meshed: &[bool], boundary: &Boundary) -> Vec<Defect> {
    let edges = edges::sorted(&boundary.triangles);
    let mut found = Vec::new();
    let mut at_edge = vec![false; sampling.kinds.len()];
    for same in edges.chunk_by(|x, y| x.0 == y.0).filter(|same| same.len() > 2) {
        let [a, b] = same[0].0;
        at_edge[a as usize] = true;
        at_edge[b as usize] = true;
        found.push(defect(sampling, DefectKind::NonManifoldEdge, vec![a, b]));
    }
    let conforming = sampling.kinds.iter().any(|&k| k != SeedKind::Interior);
    let mut buffers = sampling.complex.fan_buffers();
    for (v, &kind) in sampling.kinds.iter().enumerate() {
        let fans = sampling.complex.fans(inside, v as u32, &mut buffers);
        let kind = if fans.inside == 0 && !sampling.complex.star(v as u32).iter().any(|&t| meshed[t as usize]) {
            DefectKind::UnusedSeed
        } else if !fans.is_manifold() && !at_edge[v] {
            DefectKind::NonManifoldVertex
        } else if !conforming || fans.on_boundary() == (kind != SeedKind::Interior) {
            continue;
        } else if kind == SeedKind::Interior {
            DefectKind::ExposedSeed
        } else {
            DefectKind::BuriedSeed
        };
        found.push(defect(sampling, kind, vec![v as u32]));
    }
    found
}

fn flat_tets(sampling: &Sampling, meshed: &[bool]) -> Vec<Defect> {
    (0..meshed.len() as u32)
        .into_par_iter()
        .filter(|&t| meshed[t as usize] && sampling.is_flat(t))
        .map(|t| {
            let mut seeds = sampling.complex.tets[t as usize].to_vec();
            seeds.sort_unstable();
            let [a, b, c, d] = sampling.complex.corners(t);
            Defect { place: tetrahedron::centroid(a, b, c, d), ..defect(sampling, DefectKind::FlatTet, seeds) }
        })
        .collect()
}

/// Components and handles that are not the surface's.
fn topology_defects(sampling: &Sampling, inside: &[bool], boundary: &Boundary, crossings: &[Crossing]) -> Vec<Defect> {
    let topology = Topology::of(sampling, inside, boundary);
    let mut found = Vec::new();
    if topology.mismatch() == 0 {
        return found;
    }
    let surface = sampling.surface;
    for (shell, &euler) in topology.shells.iter().enumerate() {
        let shell = shell as u32;
        let mut report = |kind, seeds, place| {
            found.push(Defect { kind, place, seeds, crossing: None, shell: Some(shell) });
        };
        let components: Vec<_> = topology.of_shell(shell).collect();
        if components.is_empty() {
            let triangle = surface
                .shell()
                .iter()
                .position(|&s| s == shell)
                .expect("a shell has triangles: this is a bug in tetcvt");
            let [a, b, c] = surface.corners(triangle as u32);
            report(DefectKind::MissingShell, Vec::new(), triangle::centroid(a, b, c));
        }
        for component in &components {
            let point = sampling.complex.points[component.vertex as usize];
            if components.len() > 1 {
                report(DefectKind::ExtraComponent, vec![component.vertex], point);
            }
            if let Some((_, place)) = component.other {
                report(DefectKind::BridgedShells, vec![component.vertex], place);
            }
        }
        if components.len() == 1 && components[0].euler != euler {
            // Triangles that stand across the surface wall a tunnel or a bridge that it does not have.
            let most = 10 * (components[0].euler - euler).unsigned_abs() as usize;
            let across = crosswise_triangles(sampling, boundary, components[0].vertex, most);
            for (place, seeds) in &across {
                report(DefectKind::WrongGenus, seeds.clone(), *place);
            }
            // Where Voronoi facets meet the shell in more than one arc its handles hide.
            let suspects = multiple_crossings(sampling, crossings, shell);
            for &suspect in &suspects {
                let seeds = suspect.facet.to_vec();
                let place = suspect.point;
                found.push(Defect {
                    kind: DefectKind::WrongGenus,
                    place,
                    seeds,
                    crossing: Some(suspect),
                    shell: Some(shell),
                });
            }
            if suspects.is_empty() && across.is_empty() {
                let (place, seeds) = worst_triangle(sampling, boundary, components[0].vertex);
                found.push(Defect { kind: DefectKind::WrongGenus, place, seeds, crossing: None, shell: Some(shell) });
            }
        }
    }
    if found.is_empty() {
        // Every shell is there, once, with its handles: the solids behind them have grown together or fallen apart.
        let vertex = topology.components.first().map_or(0, |c| c.vertex);
        found.push(defect(sampling, DefectKind::BridgedShells, vec![vertex]));
    }
    found
}

/// The crossings of `shell` where a Voronoi facet, which has two crossings to an arc, meets it in more than one arc, against
/// the conditions of Edelsbrunner and Shah; none where that is so nearly everywhere.
fn multiple_crossings(sampling: &Sampling, crossings: &[Crossing], shell: u32) -> Vec<Crossing> {
    let shells = sampling.surface.shell();
    let seeds = sampling.kinds.len();
    let own: Vec<Crossing> = crossings
        .iter()
        .filter(|c| shells[c.triangle as usize] == shell && c.facet.iter().all(|&v| (v as usize) < seeds))
        .copied()
        .collect();
    let mut pairs: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * own.len());
    for (i, crossing) in (0..).zip(&own) {
        let [a, b, c] = crossing.facet;
        pairs.extend([([a, b], i), ([b, c], i), ([a, c], i)]);
    }
    pairs.sort_unstable();
    let mut suspect = vec![false; own.len()];
    for arcs in pairs.chunk_by(|a, b| a.0 == b.0).filter(|arcs| arcs.len() > 2) {
        arcs.iter().for_each(|&(_, i)| suspect[i as usize] = true);
    }
    // Where walls are thinner than the spacing nearly every facet meets both of their sides, which tells nothing.
    if suspect.iter().filter(|&&s| s).count() as f64 > TELLING * own.len() as f64 {
        return Vec::new();
    }
    own.into_iter().zip(suspect).filter(|(_, s)| *s).map(|(c, _)| c).collect()
}

/// The triangles of the component of the boundary that `vertex` is on that stand across the surface, at most so many, the
/// steepest first.
fn crosswise_triangles(sampling: &Sampling, boundary: &Boundary, vertex: u32, most: usize) -> Vec<(DVec3, Vec<u32>)> {
    let component = component_at(boundary, vertex);
    let surface = sampling.surface;
    let mut found: Vec<(f64, usize)> = (0..boundary.triangles.len())
        .into_par_iter()
        .filter(|&f| boundary.component[f] == component)
        .filter_map(|f| {
            let [a, b, c] = boundary.triangles[f].map(|v| sampling.complex.points[v as usize]);
            let closest = surface.tree().closest(triangle::centroid(a, b, c)).triangle;
            let cosine =
                triangle::normal2(a, b, c).normalize_or_zero().dot(surface.normal2(closest).normalize_or_zero());
            (cosine < STEEP).then_some((cosine, f))
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.truncate(most);
    found
        .into_iter()
        .map(|(_, f)| {
            let mut seeds = boundary.triangles[f].to_vec();
            seeds.sort_unstable();
            (middle(sampling, boundary.triangles[f]), seeds)
        })
        .collect()
}

/// The component of the boundary that `vertex` is on.
fn component_at(boundary: &Boundary, vertex: u32) -> u32 {
    let at = boundary.triangles.iter().position(|t| t.contains(&vertex));
    boundary.component[at.expect("a component has triangles: this is a bug in tetcvt")]
}

/// The middle of a triangle of the boundary.
fn middle(sampling: &Sampling, vertices: [u32; 3]) -> DVec3 {
    let [a, b, c] = vertices.map(|v| sampling.complex.points[v as usize]);
    triangle::centroid(a, b, c)
}

/// The triangle farthest from the surface in the component of the boundary that `vertex` is on.
fn worst_triangle(sampling: &Sampling, boundary: &Boundary, vertex: u32) -> (DVec3, Vec<u32>) {
    let component = component_at(boundary, vertex);
    let (_, index) = (0..boundary.triangles.len())
        .into_par_iter()
        .filter(|&f| boundary.component[f] == component)
        .map(|f| (sampling.surface.tree().closest(middle(sampling, boundary.triangles[f])).distance2, f))
        .reduce(|| (-1.0, usize::MAX), |a, b| if b.0 > a.0 || (b.0 == a.0 && b.1 < a.1) { b } else { a });
    let mut seeds = boundary.triangles[index].to_vec();
    seeds.sort_unstable();
    (middle(sampling, boundary.triangles[index]), seeds)
}

/// Gives each defect without one the crossing at its seeds that is farthest from them.
fn attach_crossings(sampling: &Sampling, defects: &mut [Defect], crossings: &[Crossing]) {
    if defects.is_empty() {
        return;
    }
    // Per seed the farthest crossing; ties go to the first.
    let mut farthest: Vec<Option<(f64, u32)>> = vec![None; sampling.kinds.len()];
    for (i, crossing) in crossings.iter().enumerate() {
        let radius2 = sampling.complex.points[crossing.facet[0] as usize].distance_squared(crossing.point);
        for &v in &crossing.facet {
            if let Some(slot) = farthest.get_mut(v as usize)
                && slot.is_none_or(|(r, _)| radius2 > r)
            {
                *slot = Some((radius2, i as u32));
            }
        }
    }
    for defect in defects.iter_mut().filter(|d| d.crossing.is_none()) {
        let best =
            defect.seeds.iter().filter_map(|&v| farthest[v as usize]).reduce(|a, b| if b.0 > a.0 { b } else { a });
        defect.crossing = best.map(|(_, i)| crossings[i as usize]);
    }
}
