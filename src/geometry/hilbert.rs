//! Position along a Hilbert curve.
//!
//! J. Skilling, *Programming the Hilbert curve*, AIP Conference Proceedings 707, 2004, doi 10.1063/1.1751381: undo the
//! excess work of the Gray code bit by bit, then interleave.

use glam::DVec3;

use super::bounding_box::BoundingBox;

/// Bits of each coordinate that count.
const BITS: u32 = 21;

/// Where `p` lies along the Hilbert curve through the cube around `bounds`; points outside count as on its border.
pub fn key(p: DVec3, bounds: &BoundingBox) -> u64 {
    let side = bounds.extent().max_element();
    let last = ((1u64 << BITS) - 1) as f64;
    let unit = if side > 0.0 { (p - bounds.min) / side } else { DVec3::ZERO };
    let cell = (unit * (last + 1.0)).clamp(DVec3::ZERO, DVec3::splat(last));
    interleave(to_transposed([cell.x as u32, cell.y as u32, cell.z as u32]))
}

/// Coordinates to the transposed Hilbert index: bit b of its word i is bit 3 b + 2 - i of the index.
fn to_transposed(mut x: [u32; 3]) -> [u32; 3] {
    let top = 1u32 << (BITS - 1);
    let mut q = top;
    while q > 1 {
        let low = q - 1;
        for i in 0..3 {
            if x[i] & q != 0 {
                x[0] ^= low;
            } else {
                let swap = (x[0] ^ x[i]) & low;
                x[0] ^= swap;
                x[i] ^= swap;
            }
        }
        q >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut flip = 0;
    q = top;
    while q > 1 {
        if x[2] & q != 0 {
            flip ^= q - 1;
        }
        q >>= 1;
    }
    x.map(|w| w ^ flip)
}

fn interleave(x: [u32; 3]) -> u64 {
    (0..BITS).fold(0, |key, b| {
        let bit = |w: u32| u64::from(w >> b & 1);
        key | (bit(x[0]) << 2 | bit(x[1]) << 1 | bit(x[2])) << (3 * b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_every_cell_of_a_grid_in_steps_of_one() {
        // The cells of an 8^3 grid, by their first corner, are 21 - 3 levels coarser: their order is the curve's own.
        let n = 8;
        let bounds = BoundingBox { min: DVec3::ZERO, max: DVec3::splat(n as f64) };
        let mut cells: Vec<[i32; 3]> = Vec::new();
        for x in 0..n {
            for y in 0..n {
                cells.extend((0..n).map(|z| [x, y, z]));
            }
        }
        let centre = |c: &[i32; 3]| DVec3::new(f64::from(c[0]), f64::from(c[1]), f64::from(c[2])) + 0.5;
        cells.sort_by_key(|c| key(centre(c), &bounds));
        for pair in cells.windows(2) {
            let step: i32 = (0..3).map(|i| (pair[0][i] - pair[1][i]).abs()).sum();
            assert_eq!(step, 1, "{pair:?}");
        }
    }
}
