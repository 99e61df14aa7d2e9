//! In what order points are inserted: rounds of random samples, each along a Hilbert curve.
//!
//! N. Amenta, S. Choi, G. Rote, *Incremental constructions con BRIO*, Proc. 19th ACM Symposium on Computational Geometry
//! (SoCG), 2003, pp. 211-219, doi 10.1145/777792.777824.
//!
//! 1. The points are numbered along a Hilbert curve (`geometry::hilbert`).
//! 2. Each point is drawn into a round: a quarter of the points come before the last round, a quarter of these before
//!    the last but one, and so on. Within a round, points follow the curve.
//!
//! Departures: a quarter in place of a half; the draw is a hash of the point's place, so the order is deterministic.

use crate::rng::hash;

/// The order in which to insert `count` points that are numbered along the curve.
pub fn insertion_rounds(count: usize) -> Vec<u32> {
    // Rounds end where about this many points are left: so few need no further sampling.
    const FIRST_ROUND: usize = 64;
    let rounds = (count / FIRST_ROUND).max(1).ilog2() / 2 + 1;
    let round_of = |i: u32| (rounds - 1).saturating_sub(hash(i.into()).trailing_zeros() / 2) as usize;
    let mut starts = vec![0usize; rounds as usize + 1];
    for i in 0..count as u32 {
        starts[round_of(i) + 1] += 1;
    }
    for r in 1..starts.len() {
        starts[r] += starts[r - 1];
    }
    let mut order = vec![0; count];
    for i in 0..count as u32 {
        let place = &mut starts[round_of(i)];
        order[*place] = i;
        *place += 1;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_hold_every_point_once_and_grow_fourfold() {
        for count in [0, 1, 5, 1000, 100_000] {
            let order = insertion_rounds(count);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert!(sorted.iter().copied().eq(0..count as u32));
        }
        let order = insertion_rounds(100_000);
        let descents: Vec<usize> = (1..order.len()).filter(|&i| order[i] < order[i - 1]).collect();
        assert!(descents.len() >= 4, "{descents:?}");
        let last = *descents.last().expect("checked above");
        assert!((20_000..30_000).contains(&last), "{last}");
    }
}
