//! Moments of one cell, and their sums in an order that does not depend on the number of threads.

use glam::DVec3;
use rayon::prelude::*;

use super::sheet::{Face, Linear};
use super::weighted;
use crate::geometry::triangle::normal2;

/// Numbers of a [`Cell`].
pub(super) const NUMBERS: usize = 11;

/// What a seed owns of the solid and of its surface. Moments are relative to the seed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// Volume of the cell within the solid.
    pub volume: f64,
    /// Integral over it of the density of the solid: its volume where that is 1.
    pub mass: f64,
    /// Integral of x - seed over it, weighted by the density.
    pub moment: DVec3,
    /// Integral of |x - seed|^2 over it, weighted by the density: its share of the CVT energy.
    pub energy: f64,
    /// Area of the surface within the cell.
    pub area: f64,
    /// Integral of x - seed over that, weighted by the density of the surface.
    pub area_moment: DVec3,
    /// Integral of the density of the surface over it.
    pub area_mass: f64,
}

impl Cell {
    /// Adds the signed tet (seed, a, b, c); corners are relative to the seed.
    ///
    /// With d = det(a, b, c) / 6: volume d, first moment d (a + b + c) / 4, second moment
    /// d (|a|^2 + |b|^2 + |c|^2 + |a + b + c|^2) / 20.
    pub(super) fn add_tet(&mut self, a: DVec3, b: DVec3, c: DVec3) {
        let d = a.dot(b.cross(c)) / 6.0;
        let sum = a + b + c;
        self.volume += d;
        self.moment += sum * (d / 4.0);
        self.energy += d / 20.0 * (a.length_squared() + b.length_squared() + c.length_squared() + sum.length_squared());
    }

    /// The same with densities at the seed and at the corners, linear between them (see `weighted.rs`).
    pub(super) fn add_weighted_tet(&mut self, corners: [DVec3; 3], densities: [f64; 4]) {
        let [a, b, c] = corners;
        self.add_weighted(a.dot(b.cross(c)) / 6.0, corners, densities);
    }

    fn add_weighted(&mut self, volume: f64, corners: [DVec3; 3], densities: [f64; 4]) {
        let [mass, x, y, z, energy] = weighted::tet(volume, corners.map(|p| p.to_array()), densities);
        self.volume += volume;
        self.mass += mass;
        self.moment += DVec3::new(x, y, z);
        self.energy += energy;
    }

    /// Adds a convex piece of the surface, with corners relative to the seed, and the cone over it.
    ///
    /// Its area counts along the unit normal `normal` of the surface, so that the pieces of a triangle add up to it
    /// whatever rounding did to their corners. With A, M and E the integrals of 1, x and |x|² over the piece and h the height
    /// of its plane over the seed, those over the cone are h A / 3, h M / 4 and h E / 5. A density, linear on the piece, is of
    /// degree 1 in the mass and of degree 2 in the moment, both exact.
    pub(super) fn add_polygon(&mut self, corners: &[DVec3], normal: DVec3, density: Linear) {
        let (area, first, second) = self.add_area(corners, normal, density);
        let height = normal.dot(corners[0]);
        self.volume += height * area / 6.0;
        self.moment += first * (height / 24.0);
        self.energy += height * second / 120.0;
    }

    /// The same, where the solid has the density `at_seed` at the seed and `solid` on the piece.
    pub(super) fn add_weighted_polygon(&mut self, corners: &[DVec3], face: &Face, at_seed: f64) {
        let (a, normal) = (corners[0], face.normal());
        self.add_area(corners, normal, face.density);
        let height = normal.dot(a);
        for pair in corners[1..].windows(2) {
            let fan = [a, pair[0], pair[1]];
            let [at_a, at_b, at_c] = fan.map(|p| face.solid_at(p));
            let part = normal2(a, pair[0], pair[1]).dot(normal);
            self.add_weighted(height * part / 6.0, fan, [at_seed, at_a, at_b, at_c]);
        }
    }

    /// Adds the area of a piece; twice the area, and the sums of the first and second moments that cones need.
    fn add_area(&mut self, corners: &[DVec3], normal: DVec3, density: Linear) -> (f64, DVec3, f64) {
        let (mut area, mut first, mut second) = (0.0, DVec3::ZERO, 0.0);
        let a = corners[0];
        for pair in corners[1..].windows(2) {
            let [b, c] = [pair[0], pair[1]];
            let part = normal2(a, b, c).dot(normal);
            let sum = a + b + c;
            let squares = a.length_squared() + b.length_squared() + c.length_squared() + sum.length_squared();
            area += part;
            first += sum * part;
            second += squares * part;
            if density.constant().is_none() {
                let at = [a, b, c].map(|p| density.at(p));
                let mass: f64 = at.iter().sum();
                let weighted = a * at[0] + b * at[1] + c * at[2];
                self.area_mass += part * mass / 6.0;
                self.area_moment += (sum * mass + weighted) * (part / 24.0);
            }
        }
        self.area += area / 2.0;
        if let Some(density) = density.constant() {
            self.area_mass += density * area / 2.0;
            self.area_moment += first * (density / 6.0);
        }
        (area, first, second)
    }

    /// What there is of the surface alone.
    pub(super) fn of_surface(self) -> Cell {
        Cell { volume: 0.0, moment: DVec3::ZERO, energy: 0.0, ..self }
    }

    /// Its numbers, in their order.
    pub(super) fn numbers(&self) -> [f64; NUMBERS] {
        let (m, a) = (self.moment, self.area_moment);
        [self.volume, self.mass, m.x, m.y, m.z, self.energy, self.area, a.x, a.y, a.z, self.area_mass]
    }

    /// Adds as many.
    pub(super) fn add_numbers(&mut self, numbers: [f64; NUMBERS]) {
        let [volume, mass, x, y, z, energy, area, area_x, area_y, area_z, area_mass] = numbers;
        let (moment, area_moment) = (DVec3::new(x, y, z), DVec3::new(area_x, area_y, area_z));
        self.add(&Cell { volume, mass, moment, energy, area, area_moment, area_mass });
    }

    /// Adds what another part of the work found for the same cell.
    pub(super) fn add(&mut self, other: &Cell) {
        self.volume += other.volume;
        self.mass += other.mass;
        self.moment += other.moment;
        self.energy += other.energy;
        self.area += other.area;
        self.area_moment += other.area_moment;
        self.area_mass += other.area_mass;
    }
}

/// Sums for the cells that one block of the work touches: blocks are cut without regard to the number of threads and
/// added up in their order, so that every sum is the same to the last bit on any number of them.
pub(super) struct Sums<const N: usize> {
    place: Vec<u32>,
    seeds: Vec<u32>,
    found: Vec<[f64; N]>,
}

impl<const N: usize> Sums<N> {
    /// Empty ones for so many seeds.
    pub(super) fn new(seeds: usize) -> Sums<N> {
        Sums { place: vec![u32::MAX; seeds], seeds: Vec::new(), found: Vec::new() }
    }

    /// Adds to the sums of seed `i`.
    #[inline(always)]
    pub(super) fn add(&mut self, i: u32, part: [f64; N]) {
        let place = self.place[i as usize] as usize;
        if let Some(sums) = self.found.get_mut(place) {
            for n in 0..N {
                sums[n] += part[n];
            }
            return;
        }
        self.place[i as usize] = self.found.len() as u32;
        self.seeds.push(i);
        self.found.push(part);
    }

    /// Hands out the sums and is empty again.
    pub(super) fn take(&mut self) -> (Vec<u32>, Vec<[f64; N]>) {
        for &i in &self.seeds {
            self.place[i as usize] = u32::MAX;
        }
        (std::mem::take(&mut self.seeds), std::mem::take(&mut self.found))
    }
}

/// Adds the sums of blocks, in their order, to the cells.
pub(super) fn add_sums<const N: usize>(
    cells: &mut [Cell],
    blocks: &[(Vec<u32>, Vec<[f64; N]>)],
    add: impl Fn(&mut Cell, [f64; N]) + Sync,
) {
    // Each thread looks at all of them, and adds those of its own seeds.
    let size = cells.len().div_ceil(rayon::current_num_threads()).max(1);
    cells.par_chunks_mut(size).enumerate().for_each(|(part, cells)| {
        let first = part * size;
        for (&i, &sums) in blocks.iter().flat_map(|(seeds, sums)| seeds.iter().zip(sums)) {
            if let Some(cell) = cells.get_mut((i as usize).wrapping_sub(first)) {
                add(cell, sums);
            }
        }
    });
}
