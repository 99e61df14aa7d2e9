//! The surface cut up by the Voronoi cells: pieces of triangles, cut segments, crossings of Voronoi edges.

use glam::DVec3;
use rayon::prelude::*;

use super::bisector::View;
use super::cell::{Accumulator, Cell, merge};
use super::polygon::{Line, Polygon, owner};
use super::{Crossing, Density};
use crate::delaunay::Adjacency;
use crate::geometry::predicates::Sign;
use crate::geometry::triangle::normal2;
use crate::surface::Surface;

/// Triangles in a block of the work: fixed, so that sums do not depend on the number of threads.
const BLOCK: usize = 1024;

/// Owns what one block of triangles needs and finds.
struct Block<'a> {
    points: &'a [DVec3],
    surface: &'a Surface,
    density: &'a Density,
    adjacency: &'a Adjacency,
    polygon: Polygon,
    corners: Vec<DVec3>,
    /// Seeds found to own a piece of the triangle, in the order found.
    owners: Vec<u32>,
    /// The last triangle for which each seed was found.
    seen: Vec<u32>,
    sums: Accumulator,
    crossings: Vec<Crossing>,
}

/// Nearest seed of every vertex of the surface; `owners` holds guesses, such as those of the last iteration.
pub(super) fn update_owners(owners: &mut [u32], points: &[DVec3], surface: &Surface, adjacency: &Adjacency) {
    owners.par_chunks_mut(BLOCK).zip(surface.points().par_chunks(BLOCK)).for_each(|(owners, at)| {
        let mut last = 0;
        for (mine, &p) in owners.iter_mut().zip(at) {
            let guess = if (*mine as usize) < points.len() { *mine } else { last };
            *mine = owner(p, guess, adjacency, points);
            last = *mine;
        }
    });
}

/// Adds every triangle's share to `cells`; returns the crossings of Voronoi edges, by facet.
///
/// `owners` are the nearest seeds of the surface's vertices. Which other seeds own a piece of a triangle follows by
/// spreading over the bisectors that cut it: Yan, Lévy, Liu, Sun, Wang, *Isotropic remeshing with fast and exact
/// computation of restricted Voronoi diagram*, Computer Graphics Forum 28(5), 2009, doi 10.1111/j.1467-8659.2009.01521.x.
pub(super) fn add_pieces(
    cells: &mut [Cell],
    points: &[DVec3],
    surface: &Surface,
    density: &Density,
    adjacency: &Adjacency,
    owners: &[u32],
) -> Vec<Crossing> {
    let starts: Vec<usize> = (0..surface.triangles().len()).step_by(BLOCK).collect();
    let new_block = || Block {
        points,
        surface,
        density,
        adjacency,
        polygon: Polygon::default(),
        corners: Vec::new(),
        owners: Vec::new(),
        seen: vec![u32::MAX; points.len()],
        sums: Accumulator::new(points.len()),
        crossings: Vec::new(),
    };
    let found: Vec<_> = starts
        .par_iter()
        .map_init(new_block, |block, &start| {
            for t in start..(start + BLOCK).min(surface.triangles().len()) {
                block.add_triangle(t as u32, owners);
            }
            (block.sums.take(), std::mem::take(&mut block.crossings))
        })
        .collect();
    let mut crossings = Vec::new();
    for (sums, mut more) in found {
        merge(cells, &sums);
        crossings.append(&mut more);
    }
    crossings.sort_unstable_by_key(|c| (c.facet, c.triangle));
    crossings
}

impl Block<'_> {
    /// Adds one triangle of the surface to the cells that own a part of it.
    fn add_triangle(&mut self, t: u32, owners: &[u32]) {
        let ids = self.surface.triangles()[t as usize];
        let [a, b, c] = ids.map(|v| owners[v as usize]);
        let corners = self.surface.corners(t);
        let normal = normal2(corners[0], corners[1], corners[2]).normalize_or_zero();
        if a == b && b == c {
            // Cells are convex: the whole triangle is in the cell that holds its corners.
            let seed = self.points[a as usize];
            let relative = corners.map(|p| p - seed);
            let cell = self.sums.cell(a);
            cell.add_tet(relative[0], relative[1], relative[2]);
            cell.add_triangle(relative, normal, self.density.at_corners(ids));
            return;
        }
        self.owners.clear();
        self.found(a, t);
        let mut next = 0;
        while let Some(&i) = self.owners.get(next) {
            next += 1;
            let view = View { corners, seed: self.points[i as usize] };
            self.polygon.clip(&view, self.adjacency.of(i as usize), self.points);
            self.add_piece(t, i, &view, normal);
        }
    }

    /// Remembers seed `i` as an owner of a piece of triangle `t`.
    fn found(&mut self, i: u32, t: u32) {
        if self.seen[i as usize] != t {
            self.seen[i as usize] = t;
            self.owners.push(i);
        }
    }

    /// Adds the clipped polygon: the piece, its cut segments and its crossings; spreads to the seeds across its edges.
    fn add_piece(&mut self, t: u32, i: u32, view: &View, normal: DVec3) {
        let ids = self.surface.triangles()[t as usize];
        let mut corners = std::mem::take(&mut self.corners);
        self.polygon.positions(view, i, ids, self.points, &mut corners);
        let n = corners.len();
        let cell = self.sums.cell(i);
        for m in 2..n {
            let fan = [corners[0], corners[m - 1], corners[m]];
            cell.add_tet(fan[0], fan[1], fan[2]);
            cell.add_triangle(fan, normal, self.density.within(ids, view, fan));
        }
        for m in 0..n {
            let Line::Bisector(here) = self.polygon.lines[m] else { continue };
            let j = self.polygon.bisectors[here as usize].seed;
            // The cut segment closes the facet i|j, which sees the surface from the other side.
            let middle = (self.points[j as usize] - view.seed) * 0.5;
            self.sums.cell(i).add_tet(middle, corners[(m + 1) % n], corners[m]);
            self.found(j, t);
            if let Line::Bisector(before) = self.polygon.lines[(m + n - 1) % n] {
                self.add_crossing(t, i, view, [before as usize, here as usize], corners[m]);
            }
        }
        self.corners = corners;
    }

    /// Records the crossing where two bisectors meet on triangle `t`; its three cells all see it, the least records it.
    fn add_crossing(&mut self, t: u32, i: u32, view: &View, bisectors: [usize; 2], at: DVec3) {
        let [j, k] = bisectors.map(|b| &self.polygon.bisectors[b]);
        let (lower, upper) = if j.seed < k.seed { (j, k) } else { (k, j) };
        if i < lower.seed {
            self.crossings.push(Crossing {
                facet: [i, lower.seed, upper.seed],
                point: view.seed + at,
                triangle: t,
                leaves: view.turn(lower, upper) == Sign::Positive,
            });
        }
    }
}
