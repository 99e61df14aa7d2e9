//! The invariants of a mesh, verified from its arrays alone: nothing is shared with the code that made it.

use super::TetMesh;
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::tetrahedron::FACETS;

/// Verifies every invariant; names the first violation.
pub(super) fn check(mesh: &TetMesh) -> Result<(), String> {
    arrays(mesh)?;
    tets(mesh)?;
    vertices_used(mesh)?;
    let facets = facets_of(mesh);
    at_most_two_tets(&facets)?;
    boundary_facets(mesh, &facets)?;
    boundary_edges(mesh)?;
    boundary_vertices(mesh)
}

fn arrays(mesh: &TetMesh) -> Result<(), String> {
    let vertices = mesh.points.len();
    for (name, length, expected) in [
        ("kinds", mesh.kinds.len(), vertices),
        ("seeds", mesh.seeds.len(), vertices),
        ("regions", mesh.regions.len(), mesh.tets.len()),
    ] {
        if length != expected {
            return Err(format!("{length} {name} where there should be {expected}"));
        }
    }
    if let Some(v) = mesh.points.iter().position(|p| !p.is_finite()) {
        return Err(format!("vertex {v} is not finite"));
    }
    if mesh.seeds.windows(2).any(|w| w[0] >= w[1]) {
        return Err("vertices are not in the order of their seeds".into());
    }
    let in_range = |&v: &u32| (v as usize) < vertices;
    if let Some(t) = mesh.tets.iter().position(|t| !t.iter().all(in_range)) {
        return Err(format!("tet {t} has a vertex that does not exist"));
    }
    if let Some(f) = mesh.boundary.iter().position(|f| !f.vertices.iter().all(in_range)) {
        return Err(format!("boundary triangle {f} has a vertex that does not exist"));
    }
    Ok(())
}

fn tets(mesh: &TetMesh) -> Result<(), String> {
    // A power of two changes no digit, but keeps the products of very small and very large meshes in range.
    let largest = BoundingBox::of(&mesh.points).extent().max_element();
    let scale = 2f64.powi(-largest.log2().ceil().clamp(-1000.0, 1000.0) as i32);
    for t in 0..mesh.tets.len() {
        let [a, b, c, d] = mesh.corners(t);
        let [u, v, w] = [b, c, d].map(|p| (p - a) * scale);
        let volume6 = u.cross(v).dot(w);
        if volume6.is_nan() || volume6 <= 0.0 {
            return Err(format!("tet {t} {:?} at {a} is flat or inverted", mesh.tets[t]));
        }
    }
    Ok(())
}

fn vertices_used(mesh: &TetMesh) -> Result<(), String> {
    let mut used = vec![false; mesh.points.len()];
    mesh.tets.iter().flatten().for_each(|&v| used[v as usize] = true);
    match used.iter().position(|u| !u) {
        Some(v) => Err(format!("vertex {v} is in no tet")),
        None => Ok(()),
    }
}

/// A facet of a tet: its vertices in ascending order, the tet and the number of the facet there.
type TetFacet = ([u32; 3], u32, u8);

/// No facet has more than two tets.
fn at_most_two_tets(facets: &[TetFacet]) -> Result<(), String> {
    match facets.chunk_by(|a, b| a.0 == b.0).find(|same| same.len() > 2) {
        Some(same) => Err(format!("facet {:?} has {} tets", same[0].0, same.len())),
        None => Ok(()),
    }
}

/// The facets of all tets in the order of their vertices.
fn facets_of(mesh: &TetMesh) -> Vec<TetFacet> {
    // By their first vertex, counted, and then each vertex's by themselves.
    let mut end = vec![0; mesh.points.len() + 1];
    for tet in &mesh.tets {
        let [least, second, ..] = ascending(*tet);
        end[least.0 as usize + 1] += 3;
        end[second.0 as usize + 1] += 1;
    }
    for v in 0..mesh.points.len() {
        end[v + 1] += end[v];
    }
    let mut facets = vec![([0; 3], 0, 0); 4 * mesh.tets.len()];
    for (t, tet) in (0..).zip(&mesh.tets) {
        let [a, b, c, d] = ascending(*tet);
        let mut add = |key: [u32; 3], number: u8| {
            let place = &mut end[key[0] as usize];
            facets[*place] = (key, t, number);
            *place += 1;
        };
        add([b.0, c.0, d.0], a.1);
        add([a.0, c.0, d.0], b.1);
        add([a.0, b.0, d.0], c.1);
        add([a.0, b.0, c.0], d.1);
    }
    facets.chunk_by_mut(|x, y| x.0[0] == y.0[0]).for_each(<[TetFacet]>::sort_unstable);
    facets
}

/// The vertices of a tet in ascending order, each with its place: the number of the facet opposite it.
fn ascending([a, b, c, d]: [u32; 4]) -> [(u32, u8); 4] {
    let order = |x: (u32, u8), y: (u32, u8)| if x.0 < y.0 { (x, y) } else { (y, x) };
    let (a, b) = order((a, 0), (b, 1));
    let (c, d) = order((c, 2), (d, 3));
    let (a, c) = order(a, c);
    let (b, d) = order(b, d);
    let (b, c) = order(b, c);
    [a, b, c, d]
}

/// A triangle turned so that its least vertex is first; its orientation stays.
fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// The boundary is the facets that have one tet, as seen from outside, and those between two regions, as seen from one of
/// them, each once and with its regions.
fn boundary_facets(mesh: &TetMesh, facets: &[TetFacet]) -> Result<(), String> {
    let region = |t: u32| mesh.regions[t as usize];
    let seen = |&(_, t, i): &TetFacet| turned(FACETS[i as usize].map(|k| mesh.tets[t as usize][k]));
    let mut found: Vec<([u32; 3], u32, i64)> =
        mesh.boundary.iter().map(|f| (turned(f.vertices), f.region_inside, i64::from(f.region_outside))).collect();
    found.sort_unstable();
    let mut left = found.len();
    for same in facets.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, t, _), (_, u, _)] = same
            && region(*t) == region(*u)
        {
            continue;
        }
        let outside = |other: usize| same.get(other).map_or(-1, |f| i64::from(region(f.1)));
        let is_found = |(k, facet): &(usize, &TetFacet)| {
            found.binary_search(&(seen(facet), region(facet.1), outside(1 - k))).is_ok()
        };
        let times = same.iter().enumerate().filter(is_found).count();
        left = left.wrapping_sub(times);
        let (key, t, _) = same[0];
        match *same {
            [_] if times == 1 => {}
            [_] => return Err(format!("facet {key:?} of tet {t} is no boundary triangle with its region")),
            [..] if times == 1 => {}
            [_, other, ..] => {
                let u = other.1;
                return Err(format!(
                    "tets {t} and {u} of different regions share facet {key:?}, no interface of theirs"
                ));
            }
            [] => {}
        }
    }
    match left {
        0 => Ok(()),
        _ => Err("some boundary triangles are there twice, or no facets between their regions".into()),
    }
}

/// Every edge of the boundary has two triangles, which run along it in opposite directions.
fn boundary_edges(mesh: &TetMesh) -> Result<(), String> {
    let mut edges: Vec<(u32, u32, bool)> = mesh
        .boundary
        .iter()
        .flat_map(|f| {
            let [a, b, c] = f.vertices;
            [(a, b), (b, c), (c, a)].map(|(x, y)| (x.min(y), x.max(y), x < y))
        })
        .collect();
    edges.sort_unstable();
    for same in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        if same.len() != 2 || same[0].2 == same[1].2 {
            return Err(format!("boundary edge ({}, {}) has {} triangles", same[0].0, same[0].1, same.len()));
        }
    }
    Ok(())
}

/// The triangles around every vertex of the boundary are a single fan.
fn boundary_vertices(mesh: &TetMesh) -> Result<(), String> {
    // Around vertex v, triangle (v, x, y) leads from x to y: a single fan is a single cycle.
    let mut spokes: Vec<(u32, u32, u32)> = mesh
        .boundary
        .iter()
        .flat_map(|f| {
            let [a, b, c] = f.vertices;
            [(a, b, c), (b, c, a), (c, a, b)]
        })
        .collect();
    spokes.sort_unstable();
    for fan in spokes.chunk_by(|x, y| x.0 == y.0) {
        let start = fan[0].1;
        let mut at = start;
        let mut steps = 0;
        loop {
            // Edges have two triangles each, so that exactly one leads on from each spoke.
            let i =
                fan.binary_search_by_key(&at, |s| s.1).map_err(|_| format!("vertex {} has an open fan", fan[0].0))?;
            at = fan[i].2;
            steps += 1;
            if at == start || steps > fan.len() {
                break;
            }
        }
        if steps != fan.len() {
            return Err(format!("boundary vertex {} has more than one fan of triangles", fan[0].0));
        }
    }
    Ok(())
}
