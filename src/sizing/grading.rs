//! The largest field of sizes that is nowhere above what is asked for and grows by no more than so much per length:
//!
//! ```text
//! size(p) = min over q of (asked(q) + grade |p - q|)
//! ```
//!
//! J. A. Sethian, *A fast marching level set method for monotonically advancing fronts*, PNAS 93(4), 1996,
//! doi 10.1073/pnas.93.4.1591, solves such a problem from the least value up; P.-O. Persson, *Mesh size functions for implicit
//! geometries and PDE-based gradient limiting*, Engineering with Computers 22, 2006, doi 10.1007/s00366-006-0014-1, for
//! meshes.
//!
//! 1. An octree over the frame, finer in the solid, and as fine as the sizes of the places on the surface that ask for one.
//! 2. What is asked for at its corners; then, from the least value up, each corner passes on to its neighbours the place
//!    that its value comes from, so that distances are straight lines and not ways along edges.
//! 3. Leaves where this is not yet linear to 2 % are split, and step 2 is done again; leaves as small as half their sizes
//!    stay.
//! 4. A corner in the middle of a larger leaf's side gets what that one has there: the field is continuous.
//!
//! Departure: values are passed from corner to corner with their place of origin, exact up to the few places that are cut
//! off by others; no quadratic equation is solved.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::DVec3;
use rayon::prelude::*;

use super::Asked;
use super::octree::{Cell, DEPTH, Octree, Side, UNITS, leaf_at, place, trilinear, units};
use crate::error::Error;
use crate::geometry::bounding_box::BoundingBox;
use crate::surface::Surface;

/// Leaves along the solid's longest side at least.
const COARSEST: f64 = 32.0;

/// How far a leaf's values may be from what the middle of it has, and the middles of its sides.
const EXACT: f64 = 0.02;

/// Leaves at most: splitting ends there.
const MOST_LEAVES: usize = 8_000_000;

/// The octree on its way.
pub(super) struct Grading<'a> {
    surface: &'a Surface,
    asked: &'a Asked<'a>,
    /// Places on the surface, and the sizes that they ask for.
    fine: &'a [(DVec3, f64)],
    grade: f64,
    cells: Vec<Cell>,
    corners: Vec<Corner>,
    index: HashMap<[u32; 3], u32>,
}

/// A corner of leaves.
#[derive(Clone, Copy)]
struct Corner {
    at: [u32; 3],
    /// What is asked for here.
    asked: f64,
    value: f64,
    /// The place that the value comes from, and what is asked for there.
    from: DVec3,
    source: f64,
}

impl<'a> Grading<'a> {
    pub(super) fn new(surface: &'a Surface, asked: &'a Asked<'a>, fine: &'a [(DVec3, f64)], grade: f64) -> Grading<'a> {
        let root = Cell { origin: [0; 3], level: 0, first: 0, side: Side::Mixed };
        Grading { surface, asked, fine, grade, cells: vec![root], corners: Vec::new(), index: HashMap::new() }
    }

    /// Steps 1 to 4.
    pub(super) fn octree(mut self) -> Result<Octree, Error> {
        self.split_evenly();
        self.split_at_places();
        loop {
            self.ask()?;
            self.grade();
            let coarse = self.coarse()?;
            if coarse.is_empty() || self.cells.len() + 8 * coarse.len() > MOST_LEAVES {
                break;
            }
            coarse.into_iter().for_each(|c| self.split(c));
        }
        self.join();
        let value = |at: [u32; 3]| self.corners[self.index[&at] as usize].value;
        Ok(Octree::new(&self.cells, |cell| std::array::from_fn(|k| value(cell.corner(k)))))
    }

    fn split_evenly(&mut self) {
        let extent = BoundingBox::of(self.surface.points()).extent().max_element();
        let mut c = 0;
        while c < self.cells.len() {
            let cell = self.cells[c];
            if cell.side != Side::Outside && cell.cube().1 > extent / COARSEST && cell.level < DEPTH {
                self.split(c);
            }
            c += 1;
        }
    }

    /// Splits the leaves around the places of the surface until they are as small as the sizes there.
    fn split_at_places(&mut self) {
        for &(p, size) in self.fine {
            loop {
                let c = leaf_at(&self.cells, units(p));
                if self.cells[c].cube().1 <= size || self.cells[c].level == DEPTH || self.cells.len() > MOST_LEAVES {
                    break;
                }
                self.split(c);
            }
        }
    }

    fn split(&mut self, c: usize) {
        let parent = self.cells[c];
        let first = self.cells.len() as u32;
        for k in 0..8 {
            let half = parent.edge() / 2;
            let origin = std::array::from_fn(|axis| parent.origin[axis] + if k >> axis & 1 == 1 { half } else { 0 });
            let mut cell = Cell { origin, level: parent.level + 1, first: 0, side: parent.side };
            if parent.side == Side::Mixed {
                cell.side = self.side_of(&cell);
            }
            self.cells.push(cell);
        }
        self.cells[c].first = first;
    }

    fn side_of(&self, cell: &Cell) -> Side {
        let (low, edge) = cell.cube();
        let mut mixed = false;
        self.surface.tree().near_box(low, low + edge, |_| mixed = true);
        match mixed {
            true => Side::Mixed,
            false if self.surface.is_inside(low + 0.5 * edge) => Side::Inside,
            false => Side::Outside,
        }
    }

    fn leaves(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.cells.len()).filter(|&c| self.cells[c].first == 0)
    }

    /// Finds the corners that are new, and what is asked for at each.
    fn ask(&mut self) -> Result<(), Error> {
        let known = self.corners.len();
        for c in 0..self.cells.len() {
            if self.cells[c].first != 0 {
                continue;
            }
            for k in 0..8 {
                let at = self.cells[c].corner(k);
                let next = self.corners.len() as u32;
                if *self.index.entry(at).or_insert(next) == next {
                    let from = place(at);
                    self.corners.push(Corner { at, asked: f64::INFINITY, value: 0.0, from, source: 0.0 });
                }
            }
        }
        let asked: Vec<Result<f64, Error>> =
            self.corners[known..].par_iter().map(|corner| self.asked.at(place(corner.at))).collect();
        for (corner, asked) in self.corners[known..].iter_mut().zip(asked) {
            corner.asked = asked?;
        }
        Ok(())
    }

    /// Step 2.
    fn grade(&mut self) {
        for corner in &mut self.corners {
            (corner.value, corner.source, corner.from) = (corner.asked, corner.asked, place(corner.at));
        }
        let leaves: Vec<[u32; 8]> =
            self.leaves().map(|c| std::array::from_fn(|k| self.index[&self.cells[c].corner(k)])).collect();
        for &(p, size) in self.fine {
            let cell = self.cells[leaf_at(&self.cells, units(p))];
            for k in 0..8 {
                let corner = self.index[&cell.corner(k)];
                self.offer(corner, p, size);
            }
        }
        let (starts, around) = incidence(&leaves, self.corners.len());
        // Values are positive: their bits sort as they do.
        let mut heap: BinaryHeap<Reverse<(u64, u32)>> =
            (0..).zip(&self.corners).map(|(i, c)| Reverse((c.value.to_bits(), i))).collect();
        while let Some(Reverse((bits, i))) = heap.pop() {
            let Corner { value, from, source, .. } = self.corners[i as usize];
            if value.to_bits() != bits || value == f64::INFINITY {
                continue;
            }
            for &leaf in &around[starts[i as usize] as usize..starts[i as usize + 1] as usize] {
                for j in leaves[leaf as usize] {
                    if self.offer(j, from, source) {
                        heap.push(Reverse((self.corners[j as usize].value.to_bits(), j)));
                    }
                }
            }
        }
    }

    /// Lowers the value of a corner to what a place allows; whether it does.
    fn offer(&mut self, corner: u32, from: DVec3, source: f64) -> bool {
        let corner = &mut self.corners[corner as usize];
        let value = source + self.grade * place(corner.at).distance(from);
        if value < corner.value {
            (corner.value, corner.from, corner.source) = (value, from, source);
            return true;
        }
        false
    }

    /// Step 3: the leaves in the solid that are too coarse.
    fn coarse(&self) -> Result<Vec<usize>, Error> {
        let leaves: Vec<usize> = self.leaves().filter(|&c| self.cells[c].side != Side::Outside).collect();
        let coarse: Vec<Result<bool, Error>> = leaves.par_iter().map(|&c| self.is_coarse(&self.cells[c])).collect();
        let mut found = Vec::new();
        for (c, coarse) in leaves.into_iter().zip(coarse) {
            if coarse? {
                found.push(c);
            }
        }
        Ok(found)
    }

    fn is_coarse(&self, cell: &Cell) -> Result<bool, Error> {
        let corners: [Corner; 8] = std::array::from_fn(|k| self.corners[self.index[&cell.corner(k)] as usize]);
        let values = corners.map(|c| c.value);
        let (low, edge) = cell.cube();
        if cell.level == DEPTH || edge <= values.iter().copied().fold(f64::INFINITY, f64::min) {
            return Ok(false);
        }
        let middle = DVec3::splat(0.5);
        let sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|d| [middle - 0.5 * d, middle + 0.5 * d]);
        for t in std::iter::once(middle).chain(sides) {
            let p = low + t * edge;
            let allowed = corners.iter().map(|c| c.source + self.grade * p.distance(c.from));
            let value = allowed.fold(self.asked.at(p)?, f64::min);
            let linear = trilinear(&values, t);
            if (linear - value).abs() > EXACT * value {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Step 4.
    fn join(&mut self) {
        // The coarsest leaf at each corner that it is no corner of.
        let mut hanging: Vec<(u32, u32, usize)> = Vec::new();
        for (i, corner) in (0..).zip(&self.corners) {
            let octants = (0..8).filter_map(|k: u32| {
                let mut at = corner.at;
                for (axis, x) in at.iter_mut().enumerate() {
                    if k >> axis & 1 == 1 {
                        *x = x.checked_sub(1)?;
                    }
                }
                at.iter().all(|&x| x < UNITS).then(|| leaf_at(&self.cells, at))
            });
            let coarsest = octants.min_by_key(|&c| (self.cells[c].level, c));
            if let Some(c) = coarsest.filter(|&c| !(0..8).any(|k| self.cells[c].corner(k) == corner.at)) {
                hanging.push((self.cells[c].level, i, c));
            }
        }
        hanging.sort_unstable();
        for (_, i, c) in hanging {
            let cell = self.cells[c];
            let values = std::array::from_fn(|k| self.corners[self.index[&cell.corner(k)] as usize].value);
            let (low, edge) = cell.cube();
            let corner = &mut self.corners[i as usize];
            corner.value = trilinear(&values, (place(corner.at) - low) / edge);
        }
    }
}

/// For each corner, where its leaves begin in the list that follows.
fn incidence(leaves: &[[u32; 8]], corners: usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; corners + 1];
    leaves.iter().flatten().for_each(|&c| starts[c as usize + 1] += 1);
    for i in 0..corners {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut around = vec![0; 8 * leaves.len()];
    for (leaf, corners) in (0..).zip(leaves) {
        for &c in corners {
            around[next[c as usize] as usize] = leaf;
            next[c as usize] += 1;
        }
    }
    (starts, around)
}
