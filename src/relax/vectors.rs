//! Vectors with one entry for each seed. Sums run over fixed blocks, so that they are the same to the last bit on any
//! number of threads.

use glam::DVec3;
use rayon::prelude::*;

/// Entries in a block.
const BLOCK: usize = 4096;

/// Entries whose sums do not wait for each other.
const AT_ONCE: usize = 4;

/// The dot product.
pub(super) fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    let blocks = a.par_chunks(BLOCK).zip(b.par_chunks(BLOCK));
    let sums: Vec<f64> = blocks.map(|(a, b)| dot_of_block(a, b)).collect();
    sums.iter().sum()
}

fn dot_of_block(a: &[DVec3], b: &[DVec3]) -> f64 {
    let (rows, rest) = a.as_chunks::<AT_ONCE>();
    let (others, other_rest) = b.as_chunks::<AT_ONCE>();
    let mut sums = [DVec3::ZERO; AT_ONCE];
    for (a, b) in rows.iter().zip(others) {
        (0..AT_ONCE).for_each(|k| sums[k] += a[k] * b[k]);
    }
    let sum = sums.into_iter().sum::<DVec3>().element_sum();
    sum + rest.iter().zip(other_rest).map(|(a, b)| a.dot(*b)).sum::<f64>()
}

/// The sum of `of(i)` over 0..count.
pub(super) fn sum(count: usize, of: impl Fn(usize) -> f64 + Sync) -> f64 {
    let blocks = count.div_ceil(BLOCK);
    let sums: Vec<f64> =
        (0..blocks).into_par_iter().map(|b| (b * BLOCK..((b + 1) * BLOCK).min(count)).map(&of).sum()).collect();
    sums.iter().sum()
}

/// a += t b.
pub(super) fn add_scaled(a: &mut [DVec3], t: f64, b: &[DVec3]) {
    let blocks = a.par_chunks_mut(BLOCK).zip(b.par_chunks(BLOCK));
    blocks.for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| *a += t * *b));
}

/// The same; then the dot product of a and c.
pub(super) fn add_scaled_and_dot(a: &mut [DVec3], t: f64, b: &[DVec3], c: &[DVec3]) -> f64 {
    let blocks = a.par_chunks_mut(BLOCK).zip(b.par_chunks(BLOCK).zip(c.par_chunks(BLOCK)));
    let sums: Vec<f64> = blocks
        .map(|(a, (b, c))| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += t * *b);
            dot_of_block(a, c)
        })
        .collect();
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn sums_do_not_depend_on_the_number_of_threads() {
        let mut rng = Rng::new(1, 0);
        let [a, b] = [0, 1].map(|_| (0..3 * BLOCK + 17).map(|_| rng.in_cube()).collect::<Vec<DVec3>>());
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| (dot(&a, &b).to_bits(), sum(a.len(), |i| a[i].x).to_bits()))
        };
        assert_eq!(on(1), on(3));
        let plain: f64 = a.iter().zip(&b).map(|(a, b)| a.dot(*b)).sum();
        assert!((dot(&a, &b) - plain).abs() < 1e-10 * a.len() as f64);
        let mut sum = a.clone();
        let found = add_scaled_and_dot(&mut sum, 0.3, &b, &a);
        assert!(sum.iter().zip(a.iter().zip(&b)).all(|(s, (a, b))| *s == *a + 0.3 * *b));
        assert_eq!(found, dot(&sum, &a));
    }
}
