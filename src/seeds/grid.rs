//! A grid of cubes over points: which points lie near another.
//!
//! Cells are hashed into about as many buckets as there are points, so that memory follows the points and not the
//! space that they span.

use glam::DVec3;

/// Points by the cube that holds them.
pub(super) struct CellGrid {
    cell: f64,
    mask: u64,
    /// Where each bucket begins in `entries`.
    starts: Vec<u32>,
    /// Cube and index of each point, by bucket; ascending index within one.
    entries: Vec<([i32; 3], u32)>,
}

impl CellGrid {
    /// A grid of cubes with edge `cell` over `points`.
    pub(super) fn new(points: &[DVec3], cell: f64) -> CellGrid {
        // Cubes are counted in i32; the frame is one unit wide.
        let cell = cell.max(1e-8);
        let buckets = points.len().next_power_of_two().max(64);
        let mask = buckets as u64 - 1;
        let mut starts = vec![0u32; buckets + 1];
        let cubes: Vec<[i32; 3]> = points.iter().map(|&p| cube_of(p, cell)).collect();
        for &c in &cubes {
            starts[bucket_of(c, mask) + 1] += 1;
        }
        for i in 0..buckets {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut entries = vec![([0; 3], 0); points.len()];
        for (i, &c) in cubes.iter().enumerate() {
            let slot = &mut next[bucket_of(c, mask)];
            entries[*slot as usize] = (c, i as u32);
            *slot += 1;
        }
        CellGrid { cell, mask, starts, entries }
    }

    /// Calls `visit` with the index of every point whose cube meets the cube of half-edge `radius` around `p`.
    pub(super) fn near(&self, p: DVec3, radius: f64, mut visit: impl FnMut(u32)) {
        let low = cube_of(p - radius, self.cell);
        let high = cube_of(p + radius, self.cell);
        let cubes: f64 = (0..3).map(|k| f64::from(high[k]) - f64::from(low[k]) + 1.0).product();
        if cubes > self.entries.len() as f64 {
            // More cubes than points, or no points at all: they are looked through one by one.
            let meets = |c: &[i32; 3]| (0..3).all(|k| (low[k]..=high[k]).contains(&c[k]));
            self.entries.iter().filter(|(c, _)| meets(c)).for_each(|&(_, i)| visit(i));
            return;
        }
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let cube = [x, y, z];
                    let bucket = bucket_of(cube, self.mask);
                    let range = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
                    for &(c, i) in &self.entries[range] {
                        if c == cube {
                            visit(i);
                        }
                    }
                }
            }
        }
    }
}

/// The median of some lengths, for cubes where lengths vary; 0 of none.
pub(super) fn typical(lengths: &[f64]) -> f64 {
    let mut lengths = lengths.to_vec();
    let middle = lengths.len() / 2;
    if lengths.is_empty() { 0.0 } else { *lengths.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

fn cube_of(p: DVec3, cell: f64) -> [i32; 3] {
    let c = (p / cell).floor();
    [c.x as i32, c.y as i32, c.z as i32]
}

/// Blocks of 4 x 4 x 4 cubes are hashed, so that the buckets of neighbouring cubes are mostly neighbours too.
fn bucket_of(c: [i32; 3], mask: u64) -> usize {
    let mut z = ((c[0] >> 2) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ ((c[1] >> 2) as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9)
        ^ ((c[2] >> 2) as u64).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 29;
    let within = (c[0] & 3) as u64 | ((c[1] & 3) << 2) as u64 | ((c[2] & 3) << 4) as u64;
    ((z.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32 << 6 | within) & mask) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn every_point_near_is_visited_once() {
        let mut rng = Rng::new(1, 1);
        let points: Vec<DVec3> = (0..500).map(|_| rng.in_cube() * 0.5).collect();
        let grid = CellGrid::new(&points, 0.07);
        for _ in 0..50 {
            let (p, radius) = (rng.in_cube() * 0.6, 0.2 * rng.unit());
            let mut seen = vec![0; points.len()];
            grid.near(p, radius, |i| seen[i as usize] += 1);
            for (q, &n) in points.iter().zip(&seen) {
                assert!(n <= 1);
                assert!(n == 1 || q.distance(p) > radius);
            }
        }
    }

    #[test]
    fn a_search_ends_however_small_the_cubes() {
        let mut found: Vec<u32> = Vec::new();
        CellGrid::new(&[], 0.0).near(DVec3::ZERO, 1.0, |i| found.push(i));
        assert!(found.is_empty());
        let points = [DVec3::splat(0.1), DVec3::splat(0.4), DVec3::splat(-0.1)];
        CellGrid::new(&points, 0.0).near(DVec3::ZERO, 0.2, |i| found.push(i));
        found.sort_unstable();
        assert_eq!(found, [0, 2]);
    }
}
