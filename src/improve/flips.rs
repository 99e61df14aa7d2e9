//! Edge removal: the tets around an edge give way to the best that span its ring without it.
//!
//! J. R. Shewchuk, *Two Discrete Optimization Algorithms for the Topological Improvement of Tetrahedral Meshes*, 2002
//! (unpublished manuscript): the best triangulation of the ring by dynamic programming (G. T. Klincsek, *Minimal
//! triangulations of polygonal domains*, Annals of Discrete Mathematics 9, 1980, doi 10.1016/S0167-5060(08)70044-X). A ring of
//! three is a 3-2 flip, one of four a 4-4 flip.
//!
//! Departure: edges of the boundary too. Their rings are open; closing one makes the two facets of the edge those of the
//! other diagonal (with a ring of two tets a 2-2 flip, with one tet this tet is peeled off). The ring of an edge of an
//! interface is two such rings, one on either side.

use super::change::Change;
use super::complex::{Complex, NONE};
use super::ground::Ground;
use super::measure;
use crate::geometry::tetrahedron::{EDGES, FACETS};

/// The most tets around an edge that is removed: larger rings hardly ever gain anything.
const LARGEST_RING: usize = 7;

/// Vertices of such a ring where it is open, or where it comes back to the first.
const RING_VERTICES: usize = LARGEST_RING + 1;

/// The tets around an edge (a, b): tet i is (a, b, vertex i, vertex i + 1), positive.
pub(super) struct Ring {
    pub vertices: [u32; RING_VERTICES],
    /// Number of vertices.
    pub length: usize,
    pub tets: [u32; LARGEST_RING],
    /// Number of tets: one less than vertices where the edge is on the boundary.
    pub count: usize,
}

impl Ring {
    /// The ring of edge (a, b), unless it is too large.
    pub(super) fn around(complex: &Complex, a: u32, b: u32) -> Option<Ring> {
        // For each tet, the other edge (x, y) such that (a, b, x, y) is positive.
        let mut links = [(NONE, NONE, NONE); LARGEST_RING];
        let mut count = 0;
        for &t in complex.star(a) {
            let tet = complex.tets[t as usize];
            if !tet.contains(&b) {
                continue;
            }
            if count == LARGEST_RING {
                return None;
            }
            let at = tet.iter().position(|&v| v == a)?;
            let [p, q, r] = FACETS[at].map(|k| tet[k]);
            let (x, y) = if p == b {
                (q, r)
            } else if q == b {
                (r, p)
            } else {
                (p, q)
            };
            links[count] = (x, y, t);
            count += 1;
        }
        let links = &mut links[..count];
        // An open ring begins where no tet leads to.
        let first = (0..count).find(|&i| links.iter().all(|l| l.1 != links[i].0));
        let open = first.is_some();
        let mut at = links.get(first.unwrap_or(0))?.0;
        let mut ring = Ring { vertices: [NONE; RING_VERTICES], length: 0, tets: [NONE; LARGEST_RING], count };
        for i in 0..count {
            let &(_, y, t) = links.iter().find(|l| l.0 == at)?;
            ring.vertices[i] = at;
            ring.tets[i] = t;
            at = y;
        }
        ring.length = count;
        if open {
            ring.vertices[count] = at;
            ring.length += 1;
        }
        Some(ring)
    }

    pub(super) fn is_open(&self) -> bool {
        self.length > self.count
    }

    /// Turns a closed ring so that it begins with vertex `first`, and comes back to it. The place of `last`.
    fn begin_at(&mut self, first: u32, last: u32) -> Option<usize> {
        let start = self.vertices[..self.count].iter().position(|&v| v == first)?;
        self.vertices[..self.count].rotate_left(start);
        self.tets[..self.count].rotate_left(start);
        self.vertices[self.count] = first;
        self.vertices[..self.count].iter().position(|&v| v == last)
    }
}

/// The facets of an edge that go with it, and where they part its ring.
struct Sides {
    facets: [u32; 2],
    /// Their vertices off the edge.
    ends: [u32; 2],
    /// The place of the second of these in the ring, if the edge is one of an interface.
    place: Option<usize>,
}

/// The best triangulation of a ring found so far, for each of its stretches.
struct Table {
    worst: [[f64; RING_VERTICES]; RING_VERTICES],
    middle: [[u8; RING_VERTICES]; RING_VERTICES],
}

/// Works out the removal of edge (a, b), if all new tets would be better than `least`.
pub(super) fn remove_edge(
    complex: &Complex,
    ground: &Ground,
    [a, b]: [u32; 2],
    least: f64,
    change: &mut Change,
) -> bool {
    // Other parts may have tets around an edge of the seam.
    if complex.on_seam(a) && complex.on_seam(b) {
        return false;
    }
    let Some(mut ring) = Ring::around(complex, a, b) else { return false };
    if ring.length < 3 && !ring.is_open() {
        return false;
    }
    let mut sides = None;
    if ring.is_open() || complex.has_interfaces && complex.facets_at(a, b).next().is_some() {
        sides = match closable(complex, [a, b], &mut ring) {
            Some(sides) => Some(sides),
            None => return false,
        }
    }
    // The whole of a ring, or its two sides.
    let parted = sides.as_ref().and_then(|s| s.place);
    let stretches = match parted {
        Some(place) => [(0, place), (place, ring.count)],
        None => [(0, ring.length - 1), (0, 0)],
    };
    let mut table = Table::new();
    for stretch in stretches {
        if !triangulate(complex, [a, b], &ring, (stretch, least), &mut table) {
            return false;
        }
    }
    change.clear();
    let on_boundary = sides.is_some();
    if let Some(Sides { facets, ends: [first, last], .. }) = sides {
        let face = complex.facets[facets[0] as usize].face;
        for vertices in [[first, b, last], [first, last, a]] {
            let Some(facet) = ground.facet(complex, vertices, face, &facets) else { return false };
            change.new_facets.push(facet);
        }
        change.old_facets.extend(facets);
    }
    change.old_tets.extend(&ring.tets[..ring.count]);
    for stretch in stretches {
        collect(complex, [a, b], &ring, &table, stretch, change);
    }
    // A flip of the boundary takes in a little of what is outside, where another part of the solid may be.
    if on_boundary && change.new_tets.iter().any(|(tet, _)| crosses(complex, &ring, *tet)) {
        return false;
    }
    change.worst = change.new_tets.iter().map(|t| t.1).fold(f64::INFINITY, f64::min);
    true
}

/// The two facets of the edge of a ring that is open or that an interface parts, if the edge is no crease and its other
/// diagonal is free, which is not known on a seam.
fn closable(complex: &Complex, [a, b]: [u32; 2], ring: &mut Ring) -> Option<Sides> {
    let on_seam = ring.vertices[..ring.length].iter().any(|&v| complex.on_seam(v));
    if on_seam || complex.is_crease(a, b) {
        return None;
    }
    let mut place = None;
    let (first, last, fewest) = if ring.is_open() {
        (ring.vertices[0], ring.vertices[ring.length - 1], ring.count)
    } else {
        // The region behind both facets begins at the one that runs from b to a.
        let mut ends = [NONE; 2];
        for f in complex.facets_at(a, b) {
            let [x, y, z] = complex.facets[f as usize].vertices;
            let forward = [[x, y], [y, z], [z, x]].contains(&[a, b]);
            ends[usize::from(forward)] = x ^ y ^ z ^ a ^ b;
        }
        let at = ring.begin_at(ends[0], ends[1])?;
        place = Some(at);
        (ends[0], ends[1], at.min(ring.count - at))
    };
    let (f, g) = (complex.facet([a, b, first])?, complex.facet([a, b, last])?);
    if complex.facets[f as usize].face != complex.facets[g as usize].face {
        return None;
    }
    let taken = if fewest == 1 {
        // The tet is peeled off: what lies behind must not be the boundary already.
        let on_facet = |f: &u32| complex.facets[*f as usize].vertices.contains(&last);
        complex.facets_of(first).iter().any(on_facet)
    } else {
        complex.has_edge(first, last)
    };
    // Three facets at a vertex of the boundary are the least.
    let spare = |v: u32| complex.facets_of(v).len() > 3;
    (!taken && spare(a) && spare(b)).then_some(Sides { facets: [f, g], ends: [first, last], place })
}

impl Table {
    fn new() -> Table {
        Table { worst: [[f64::INFINITY; RING_VERTICES]; RING_VERTICES], middle: [[0; RING_VERTICES]; RING_VERTICES] }
    }
}

/// Finds the triangulation of a stretch of the ring whose worst tet is best; whether it is better than `least`.
fn triangulate(
    complex: &Complex,
    [a, b]: [u32; 2],
    ring: &Ring,
    ((from, to), least): ((usize, usize), f64),
    table: &mut Table,
) -> bool {
    for span in 2..=to - from {
        for i in from..=to - span {
            let k = i + span;
            let mut best = f64::NEG_INFINITY;
            for j in i + 1..k {
                let rest = table.worst[i][j].min(table.worst[j][k]);
                if rest <= least.max(best) {
                    continue;
                }
                let [x, y, z] = [i, j, k].map(|m| ring.vertices[m]);
                let lower = measure::quality(complex.corners([x, y, z, b]));
                if lower <= least.max(best) {
                    continue;
                }
                let worst = rest.min(lower).min(measure::quality(complex.corners([x, z, y, a])));
                if worst > best {
                    best = worst;
                    table.middle[i][k] = j as u8;
                }
            }
            table.worst[i][k] = best;
        }
    }
    table.worst[from][to] > least
}

/// Whether a new tet has an edge across the ring that is there already.
fn crosses(complex: &Complex, ring: &Ring, tet: [u32; 4]) -> bool {
    let place = |v: u32| ring.vertices[..ring.length].iter().position(|&w| w == v);
    let is_across = |v: u32, w: u32| {
        let (Some(i), Some(k)) = (place(v), place(w)) else { return false };
        let apart = i.abs_diff(k);
        apart > 1 && (apart + 1 < ring.length || ring.is_open())
    };
    EDGES.iter().map(|e| e.map(|i| tet[i])).any(|[v, w]| is_across(v, w) && complex.has_edge(v, w))
}

/// The tets of the best triangulation of a stretch of the ring.
fn collect(
    complex: &Complex,
    [a, b]: [u32; 2],
    ring: &Ring,
    table: &Table,
    (i, k): (usize, usize),
    change: &mut Change,
) {
    if k < i + 2 {
        return;
    }
    let j = table.middle[i][k] as usize;
    let [x, y, z] = [i, j, k].map(|m| ring.vertices[m]);
    for tet in [[x, y, z, b], [x, z, y, a]] {
        change.new_tets.push((tet, measure::quality(complex.corners(tet))));
    }
    collect(complex, [a, b], ring, table, (i, j), change);
    collect(complex, [a, b], ring, table, (j, k), change);
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::improve::complex::{Freedom, Vertex};

    #[test]
    fn an_edge_across_the_ring_that_is_there_already_stands_in_the_way() {
        let vertex = |p| Vertex { point: p, freedom: Freedom::Inside, region: 0 };
        let vertices = (0..8).map(|i| vertex(DVec3::new(f64::from(i), f64::from(i * i), f64::from(i % 3)))).collect();
        // Elsewhere there is an edge from 0 to 1, and one from 4 to 1 along the ring.
        let complex = Complex::new(vertices, vec![[0, 1, 2, 3], [1, 4, 6, 2]], Vec::new());
        let mut ring = Ring { vertices: [NONE; RING_VERTICES], length: 4, tets: [NONE; LARGEST_RING], count: 3 };
        ring.vertices[..4].copy_from_slice(&[0, 4, 1, 5]);
        assert!(crosses(&complex, &ring, [0, 4, 1, 7]));
        assert!(!crosses(&complex, &ring, [4, 1, 5, 7]));
        assert!(!crosses(&complex, &ring, [0, 4, 5, 7]));
        // In a closed ring the last vertex is next to the first.
        ring.vertices[..4].copy_from_slice(&[0, 4, 5, 1]);
        ring.count = 4;
        assert!(!crosses(&complex, &ring, [0, 5, 1, 7]));
    }
}
