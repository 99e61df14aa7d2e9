//! Raises the average above the floor: every vertex goes to where the sum of its tets' smallest angles and shapes is
//! larger.
//!
//! Vertices of one colour are in no common tet, so that they can be moved at the same time: the moves of a colour are found in
//! parallel and made in the order of the vertices. The colours are those of the greedy algorithm, so that the result
//! is the same on any number of threads.

use rayon::prelude::*;

use super::complex::Complex;
use super::ground::Ground;
use super::smooth::{Move, Smoother};

/// Vertices of one colour whose moves are found by one thread at a time.
const TOGETHER: usize = 64;

/// One round: every vertex beside which something changed after commit `since`.
pub(super) fn run(complex: &mut Complex, ground: &Ground, since: u32) {
    for vertices in colors(complex, since) {
        let found: Vec<Vec<Move>> = vertices
            .par_chunks(TOGETHER)
            .map_init(Smoother::default, |smoother, some| {
                some.iter().filter_map(|&v| smoother.rise(complex, ground, v)).collect()
            })
            .collect();
        found.iter().flatten().for_each(|m| m.apply(complex));
        complex.commit();
    }
}

/// The vertices that are to move, by colours.
fn colors(complex: &Complex, since: u32) -> Vec<Vec<u32>> {
    const UNCOLORED: u8 = u8::MAX;
    let mut color = vec![UNCOLORED; complex.points.len()];
    let mut colors: Vec<Vec<u32>> = Vec::new();
    for v in 0..complex.points.len() as u32 {
        if complex.star(v).is_empty() || (since > 0 && !complex.changed_beside(v, since)) {
            continue;
        }
        let mut taken = 0_u128;
        for &t in complex.star(v) {
            for u in complex.tets[t as usize] {
                // None is beyond what is counted.
                taken |= 1_u128.checked_shl(u32::from(color[u as usize])).unwrap_or(0);
            }
        }
        let free = taken.trailing_ones() as usize;
        // A vertex beside so many colours can do without a polish.
        if free >= 128 {
            continue;
        }
        color[v as usize] = free as u8;
        colors.resize(colors.len().max(free + 1), Vec::new());
        colors[free].push(v);
    }
    colors
}
