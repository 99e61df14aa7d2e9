//! Sizes at the corners of an octree's leaves, trilinear within each and continuous.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::frame::snap;
use crate::rng::Rng;
use crate::surface::Surface;

/// Levels at most; coordinates of corners run from 0 to 2^DEPTH over the frame.
pub(super) const DEPTH: u32 = 14;

/// The number of units along the frame.
pub(super) const UNITS: u32 = 1 << DEPTH;

/// What tells leaves from inner nodes.
const LEAF: u32 = 1 << 31;

/// Samples along a leaf through which the surface passes, or in which sizes vary; in others.
const FINE: usize = 3;
const COARSE: usize = 2;

/// Where a cell lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Outside,
    Inside,
    /// The surface may pass through it.
    Mixed,
}

/// A cube of the octree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Its least corner, in units.
    pub(super) origin: [u32; 3],
    pub(super) level: u32,
    /// The first of its eight children, 0 for a leaf; child k is on the upper side in x, y, z as bits 0, 1, 2 of k say.
    pub(super) first: u32,
    pub(super) side: Side,
}

impl Cell {
    /// Its edge, in units.
    pub(super) fn edge(&self) -> u32 {
        UNITS >> self.level
    }

    /// Its corner k, in units.
    pub(super) fn corner(&self, k: usize) -> [u32; 3] {
        std::array::from_fn(|axis| self.origin[axis] + if k >> axis & 1 == 1 { self.edge() } else { 0 })
    }

    /// Its least corner and its edge, in the frame.
    pub(super) fn cube(&self) -> (DVec3, f64) {
        (place(self.origin), f64::from(self.edge()) / f64::from(UNITS))
    }
}

/// The point at these units.
pub(super) fn place(at: [u32; 3]) -> DVec3 {
    DVec3::from_array(at.map(f64::from)) / f64::from(UNITS) - 0.5
}

/// The leaf among `cells` that holds the unit cube at these units.
pub(super) fn leaf_at(cells: &[Cell], at: [u32; 3]) -> usize {
    let mut cell = 0;
    while cells[cell].first != 0 {
        let shift = DEPTH - 1 - cells[cell].level;
        let child = (0..3).fold(0, |k, axis| k | (at[axis] >> shift & 1) << axis);
        cell = (cells[cell].first + child) as usize;
    }
    cell
}

/// The units of a point; of the nearest within the frame if it is outside.
pub(super) fn units(p: DVec3) -> [u32; 3] {
    let q = (p + 0.5) * f64::from(UNITS);
    q.to_array().map(|x| (x.max(0.0) as u32).min(UNITS - 1))
}

/// The octree, ready to be asked.
#[derive(Debug)]
pub(super) struct Octree {
    /// For each cell its first child, or [`LEAF`] and its place among the leaves.
    nodes: Vec<u32>,
    leaves: Vec<Leaf>,
}

#[derive(Clone, Copy, Debug)]
struct Leaf {
    /// At its corners.
    sizes: [f64; 8],
    origin: DVec3,
    edge: f64,
    side: Side,
}

impl Octree {
    /// Of `cells`, with the sizes at the corners that each leaf has.
    pub(super) fn new(cells: &[Cell], sizes_of: impl Fn(&Cell) -> [f64; 8]) -> Octree {
        let mut leaves = Vec::new();
        let node = |cell: &Cell| {
            if cell.first != 0 {
                return cell.first;
            }
            let (origin, edge) = cell.cube();
            leaves.push(Leaf { sizes: sizes_of(cell), origin, edge, side: cell.side });
            LEAF | (leaves.len() - 1) as u32
        };
        let nodes = cells.iter().map(node).collect();
        Octree { nodes, leaves }
    }

    /// The size at a point; at the nearest of the frame, where it is outside.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        let at = units(p);
        let (mut node, mut shift) = (self.nodes[0], DEPTH);
        while node & LEAF == 0 {
            shift -= 1;
            let child = (at[0] >> shift & 1) | (at[1] >> shift & 1) << 1 | (at[2] >> shift & 1) << 2;
            node = self.nodes[(node + child) as usize];
        }
        let leaf = &self.leaves[(node & !LEAF) as usize];
        trilinear(&leaf.sizes, ((p - leaf.origin) / leaf.edge).clamp(DVec3::ZERO, DVec3::ONE))
    }

    /// The least and the largest size at corners of leaves in the solid.
    pub(super) fn range(&self) -> [f64; 2] {
        let within = self.leaves.iter().filter(|l| l.side != Side::Outside).flat_map(|l| l.sizes);
        within.fold([f64::INFINITY, 0.0], |[least, largest], s| [least.min(s), largest.max(s)])
    }

    /// The integral over the solid of a function of the size. Leaves on the surface count for the share of their samples that
    /// are inside, all by one factor so that they sum to the volume that is left for them.
    pub(super) fn integral(&self, surface: &Surface, of: impl Fn(f64) -> f64 + Sync) -> f64 {
        let parts: Vec<[f64; 3]> = self
            .leaves
            .par_iter()
            .map(|leaf| {
                let (least, largest) =
                    leaf.sizes.iter().fold((f64::INFINITY, 0.0f64), |(l, m), &s| (l.min(s), m.max(s)));
                let steps = if leaf.side == Side::Mixed || largest > 1.2 * least { FINE } else { COARSE };
                let mut sum = [0.0; 3];
                if leaf.side == Side::Outside {
                    return sum;
                }
                let volume = (leaf.edge / steps as f64).powi(3);
                for i in 0..steps * steps * steps {
                    let t = DVec3::new((i % steps) as f64, (i / steps % steps) as f64, (i / steps / steps) as f64);
                    let t = (t + 0.5) / steps as f64;
                    let value = of(trilinear(&leaf.sizes, t)) * volume;
                    match leaf.side {
                        Side::Inside => sum[0] += value,
                        _ if surface.is_inside(leaf.origin + t * leaf.edge) => {
                            sum[1] += value;
                            sum[2] += volume;
                        }
                        _ => {}
                    }
                }
                sum
            })
            .collect();
        let [inside, mixed, mixed_volume] = parts.iter().fold([0.0; 3], |s, p| [s[0] + p[0], s[1] + p[1], s[2] + p[2]]);
        let whole = self.leaves.iter().filter(|l| l.side == Side::Inside).map(|l| l.edge.powi(3)).sum::<f64>();
        if mixed_volume > 0.0 {
            return inside + mixed * (surface.volume() - whole).max(0.0) / mixed_volume;
        }
        // A solid so thin that no sample hits it: what its leaves have in the mean.
        let (mut value, mut volume) = (0.0, 0.0);
        for leaf in self.leaves.iter().filter(|l| l.side == Side::Mixed) {
            value += of(trilinear(&leaf.sizes, DVec3::splat(0.5))) * leaf.edge.powi(3);
            volume += leaf.edge.powi(3);
        }
        inside + if volume > 0.0 { (surface.volume() - whole).max(0.0) * value / volume } else { 0.0 }
    }
}

impl Octree {
    /// So many random points of the leaves that are not outside, in the density of the inverse cube of sizes: a leaf by what
    /// it would have if all of it were as fine as its finest corner, and a point of it by what it has of that.
    pub(super) fn draw(&self, count: usize, rng: &mut Rng) -> Vec<DVec3> {
        let inverse_cube = |size: f64| 1.0 / (size * size * size);
        let within: Vec<&Leaf> = self.leaves.iter().filter(|l| l.side != Side::Outside).collect();
        let mut sums = Vec::with_capacity(within.len());
        let mut sum = 0.0;
        for leaf in &within {
            sum += leaf.edge.powi(3) * inverse_cube(leaf.sizes.into_iter().fold(f64::INFINITY, f64::min));
            sums.push(sum);
        }
        let mut points = Vec::with_capacity(count);
        while points.len() < count {
            let at = rng.unit() * sum;
            let leaf = within[sums.partition_point(|&s| s <= at).min(within.len() - 1)];
            let t = 0.5 * rng.in_cube() + 0.5;
            let least = leaf.sizes.into_iter().fold(f64::INFINITY, f64::min);
            if rng.unit() * inverse_cube(least) <= inverse_cube(trilinear(&leaf.sizes, t)) {
                points.push(snap(leaf.origin + t * leaf.edge));
            }
        }
        points
    }
}

/// The value in a cube with these values at its corners, `t` of the way along its edges.
pub(super) fn trilinear(at: &[f64; 8], t: DVec3) -> f64 {
    let along_x = |k: usize| at[k] + t.x * (at[k + 1] - at[k]);
    let along_y = |k: usize| along_x(k) + t.y * (along_x(k + 2) - along_x(k));
    along_y(0) + t.z * (along_y(4) - along_y(0))
}
