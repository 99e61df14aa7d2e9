//! The Voronoi edges inside the solid: which circumcentres are inside, and what the edges between them add.

use glam::DVec3;
use rayon::prelude::*;

use super::Crossing;
use super::cell::{Accumulator, Cell, merge};
use crate::delaunay::{Delaunay, INFINITE};
use crate::geometry::triangle;

/// Tets in a block of the work: fixed, so that sums do not depend on the number of threads.
const BLOCK: usize = 4096;

/// The vertices of facet f of a tet, in the order in which the tet's vertex f is on the side that
/// (q - p) x (r - p) points to.
pub(super) const FACET: [[usize; 3]; 4] = [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]];

/// The crossings, found by facet.
pub(super) struct Crossings<'a> {
    all: &'a [Crossing],
    /// For each seed, where the facets begin of which it is the least vertex.
    first: Vec<u32>,
}

impl<'a> Crossings<'a> {
    /// Crossings sorted by facet, over so many seeds.
    pub(super) fn new(all: &'a [Crossing], seeds: usize) -> Crossings<'a> {
        let mut first = vec![0; seeds + 1];
        for c in all {
            first[c.facet[0] as usize + 1] += 1;
        }
        for i in 0..seeds {
            first[i + 1] += first[i];
        }
        Crossings { all, first }
    }

    /// The crossings of the Voronoi edge dual to the facet (p, q, r), and whether (p, q, r) is an even permutation of
    /// the ascending order that their `leaves` speaks of.
    pub(super) fn of(&self, [p, q, r]: [u32; 3]) -> (&'a [Crossing], bool) {
        let mut facet = [p, q, r];
        let least = p.min(q).min(r) as usize;
        let own = &self.all[self.first[least] as usize..self.first[least + 1] as usize];
        if own.is_empty() {
            return (own, true);
        }
        facet.sort_unstable();
        let from = own.partition_point(|c| c.facet < facet);
        let count = own[from..].partition_point(|c| c.facet == facet);
        (&own[from..from + count], (p < q) as u8 + (q < r) as u8 + (r < p) as u8 == 2)
    }
}

/// For each tet, how many shells of the surface hold its circumcentre, outward ones counted 1 and inward ones -1: 1
/// inside the solid and 0 outside. No ray is cast: all is outside at infinity, and along every Voronoi edge the
/// crossings say what changes. `None` where two ways disagree, which takes a surface that is not closed.
pub(super) fn winding(delaunay: &Delaunay, crossings: &Crossings) -> Option<Vec<i32>> {
    const UNKNOWN: i32 = i32::MIN;
    let (vertices, neighbors) = (delaunay.vertices(), delaunay.neighbors());
    let mut winding = vec![UNKNOWN; vertices.len()];
    let mut stack: Vec<u32> = (0..vertices.len() as u32).filter(|&t| vertices[t as usize][3] == INFINITE).collect();
    stack.iter().for_each(|&t| winding[t as usize] = 0);
    while let Some(t) = stack.pop() {
        for f in 0..4 {
            let n = neighbors[t as usize][f].tet();
            let facet = FACET[f].map(|v| vertices[t as usize][v]);
            if facet.contains(&INFINITE) {
                continue;
            }
            // From the neighbour to t the dual edge runs along (q - p) x (r - p).
            let (found, even) = crossings.of(facet);
            let entered: i32 = found.iter().map(|c| if c.leaves == even { -1 } else { 1 }).sum();
            let expected = winding[t as usize] - entered;
            match &mut winding[n as usize] {
                w if *w == UNKNOWN => {
                    *w = expected;
                    stack.push(n);
                }
                w if *w == expected => {}
                _ => return None,
            }
        }
    }
    Some(winding)
}

/// Adds, for every Voronoi edge, what its part inside the solid adds to the cells around it.
pub(super) fn add_edges(
    cells: &mut [Cell],
    delaunay: &Delaunay,
    crossings: &Crossings,
    winding: &[i32],
    centers: &[DVec3],
) {
    let (points, vertices, neighbors) = (delaunay.points(), delaunay.vertices(), delaunay.neighbors());
    let starts: Vec<usize> = (0..vertices.len()).step_by(BLOCK).collect();
    let found: Vec<_> = starts
        .par_iter()
        .map_init(
            || Accumulator::new(points.len()),
            |sums, &start| {
                for t in start..(start + BLOCK).min(vertices.len()) {
                    for f in 0..4 {
                        let n = neighbors[t][f].tet() as usize;
                        let facet = FACET[f].map(|v| vertices[t][v]);
                        if t > n || facet.contains(&INFINITE) {
                            continue;
                        }
                        let (found, even) = crossings.of(facet);
                        let ends = [(winding[n], centers[n]), (winding[t], centers[t])];
                        add_edge(sums, points, facet, ends, found, even);
                    }
                }
                sums.take()
            },
        )
        .collect();
    found.iter().for_each(|block| merge(cells, block));
}

/// Adds the Voronoi edge dual to facet (p, q, r), which runs between two circumcentres, each with its winding, along
/// (q - p) x (r - p).
///
/// What an interval from a to b adds is the difference of what the ways from one base point to b and to a add, so that
/// several crossings need no order along the edge.
fn add_edge(
    sums: &mut Accumulator,
    points: &[DVec3],
    facet: [u32; 3],
    [(w_from, from), (w_to, to)]: [(i32, DVec3); 2],
    crossings: &[Crossing],
    even: bool,
) {
    if crossings.is_empty() {
        if w_to != 0 {
            add_interval(sums, points, facet, from, to, w_to as f64);
        }
        return;
    }
    let [p, q, r] = facet.map(|i| points[i as usize]);
    let base = triangle::circumcenter(p, q, r);
    if w_from != 0 {
        add_interval(sums, points, facet, base, from, -(w_from as f64));
    }
    for c in crossings {
        add_interval(sums, points, facet, base, c.point, if c.leaves == even { 1.0 } else { -1.0 });
    }
    if w_to != 0 {
        add_interval(sums, points, facet, base, to, w_to as f64);
    }
}

/// Adds to the three cells around the Voronoi edge of `facet`, for its interval from `a` to `b`, the tets between each
/// seed, its midpoints with the two others, a and b; `weight` is 1, or -1 to take them away.
fn add_interval(sums: &mut Accumulator, points: &[DVec3], facet: [u32; 3], a: DVec3, b: DVec3, weight: f64) {
    let (a, b) = if weight > 0.0 { (a, b) } else { (b, a) };
    for side in 0..3 {
        let (i, j) = (facet[side], facet[(side + 1) % 3]);
        let (x, y) = (points[i as usize], points[j as usize]);
        let half = (y - x) * 0.5;
        for _ in 0..weight.abs() as usize {
            sums.cell(i).add_tet(half, a - x, b - x);
            sums.cell(j).add_tet(-half, b - y, a - y);
        }
    }
}
