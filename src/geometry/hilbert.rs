//! The order of points along a Hilbert curve: neighbours along it are neighbours in space.
//!
//! C. H. Hamilton, A. Rau-Chaplin, *Compact Hilbert indices: space-filling curves for domains with unequal side lengths*,
//! Information Processing Letters 105(5), 2008, pp. 155-163, doi 10.1016/j.ipl.2007.08.034: the curve as a machine of 24
//! states (entry corner and direction of the cell).
//!
//! Each point gets its place along the curve through 2^30 cells of the bounding cube. Departure: where many points share a
//! cell, they are ordered along a curve of their own, and so on, so that clusters of any size keep their locality.

use glam::DVec3;

/// Levels of the curve in one sort: ten, as three bits of each make a key of 30 bits.
const LEVELS: u32 = 10;

/// Points that share a cell are ordered further when there are more than this.
const CROWD: usize = 16;

/// What a state of the curve does with an octant: its rank along the curve, and the state within it.
const STATES: [[(u8, u8); 8]; 24] = states();

/// The machine: state `3 * entry + direction`, where `entry` is the corner in which the curve enters the cell, a bit per
/// axis, and `direction` the axis along which it leaves.
const fn states() -> [[(u8, u8); 8]; 24] {
    let mut table = [[(0, 0); 8]; 24];
    let mut state = 0;
    while state < 24 {
        let (entry, direction) = (state as u32 / 3, state as u32 % 3);
        let mut octant = 0;
        while octant < 8 {
            let gray = rotate_right(octant as u32 ^ entry, direction + 1);
            // Inverse of the Gray code of three bits.
            let rank = gray ^ (gray >> 1) ^ (gray >> 2);
            let next_entry = entry ^ rotate_left(entry_corner(rank), direction + 1);
            let next_direction = (direction + inner_direction(rank) + 1) % 3;
            table[state][octant] = (rank as u8, (3 * next_entry + next_direction) as u8);
            octant += 1;
        }
        state += 1;
    }
    table
}

/// Corner in which the standard curve enters its sub-cell of this rank.
const fn entry_corner(rank: u32) -> u32 {
    if rank == 0 {
        return 0;
    }
    let even = (rank - 1) / 2 * 2;
    even ^ (even >> 1)
}

/// Axis along which the standard curve leaves its sub-cell of this rank.
const fn inner_direction(rank: u32) -> u32 {
    if rank == 0 {
        0
    } else if rank.is_multiple_of(2) {
        (rank - 1).trailing_ones() % 3
    } else {
        rank.trailing_ones() % 3
    }
}

const fn rotate_right(bits: u32, by: u32) -> u32 {
    let by = by % 3;
    ((bits >> by) | (bits << (3 - by))) & 7
}

const fn rotate_left(bits: u32, by: u32) -> u32 {
    rotate_right(bits, 3 - by % 3)
}

/// Place along the curve of the cell (x, y, z), each below 2^[`LEVELS`].
fn hilbert_key(x: u32, y: u32, z: u32) -> u32 {
    let mut state = 0usize;
    let mut key = 0;
    for level in (0..LEVELS).rev() {
        let octant = (x >> level & 1) | (y >> level & 1) << 1 | (z >> level & 1) << 2;
        let (rank, next) = STATES[state][octant as usize];
        key = key << 3 | u32::from(rank);
        state = usize::from(next);
    }
    key
}

/// Indices of the points along a Hilbert curve; points at the same place by index.
pub fn hilbert_order(points: &[DVec3]) -> Vec<u32> {
    let mut keyed: Vec<u64> = (0..points.len() as u64).collect();
    sort_along_curve(points, &mut keyed);
    keyed.into_iter().map(|k| k as u32).collect()
}

/// Orders `keyed`, whose low halves are indices of points, along a curve that fills their bounding cube.
fn sort_along_curve(points: &[DVec3], keyed: &mut [u64]) {
    let point = |k: u64| points[(k & 0xffff_ffff) as usize];
    let mut min = DVec3::INFINITY;
    let mut max = DVec3::NEG_INFINITY;
    for &k in keyed.iter() {
        min = min.min(point(k));
        max = max.max(point(k));
    }
    let side = (max - min).max_element();
    let scale = f64::from(1u32 << LEVELS) / side;
    if !(side > 0.0 && scale.is_finite()) {
        return;
    }
    let last = (1u32 << LEVELS) - 1;
    for k in keyed.iter_mut() {
        let cell = (point(*k) - min) * scale;
        // The conversion saturates, so rounding can lead no further than one past the end.
        let [x, y, z] = [cell.x as u32, cell.y as u32, cell.z as u32].map(|i| i.min(last));
        *k = u64::from(hilbert_key(x, y, z)) << 32 | (*k & 0xffff_ffff);
    }
    keyed.sort_unstable();
    let mut start = 0;
    while start < keyed.len() {
        let key = keyed[start] >> 32;
        let crowd = keyed[start..].iter().take_while(|&&k| k >> 32 == key).count();
        if crowd > CROWD && crowd < keyed.len() {
            sort_along_curve(points, &mut keyed[start..start + crowd]);
        }
        start += crowd;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::hash;

    #[test]
    fn successive_cells_of_the_curve_share_a_face() {
        let side = 1u32 << 5;
        let shift = LEVELS - 5;
        let mut cells: Vec<(u32, [u32; 3])> = (0..side.pow(3))
            .map(|i| [i % side, i / side % side, i / side / side])
            .map(|c| (hilbert_key(c[0] << shift, c[1] << shift, c[2] << shift) >> (3 * shift), c))
            .collect();
        cells.sort_unstable();
        for (i, pair) in cells.windows(2).enumerate() {
            assert_eq!(pair[0].0, i as u32, "every cell has a place of its own");
            let steps: u32 = (0..3).map(|k| pair[0].1[k].abs_diff(pair[1].1[k])).sum();
            assert_eq!(steps, 1, "{pair:?}");
        }
    }

    #[test]
    fn clusters_keep_their_locality() {
        let points: Vec<DVec3> = (0..4000)
            .map(|i| {
                let h = hash(i);
                let unit = |s: u32| f64::from((h >> s) as u32 & 0xfffff) / 1048576.0;
                DVec3::new(unit(0), unit(20), unit(40)) * if i % 2 == 0 { 1.0 } else { 1e-9 }
            })
            .collect();
        let order = hilbert_order(&points);
        let inner: Vec<DVec3> = order.iter().map(|&i| points[i as usize]).filter(|p| p.length() < 1e-8).collect();
        assert!(inner.len() >= 2000);
        let mean = inner.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>() / inner.len() as f64;
        assert!(mean < 2e-10, "{mean}");
    }
}
