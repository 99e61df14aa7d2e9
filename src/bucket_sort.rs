//! A sort for many items that share few of their first keys.

/// Sorts `items`, whose order is first of all that of `bucket`, a number below `count`: by counting, and then the few in
/// each bucket by comparing. Linear where no bucket holds many.
pub fn sorted_by_bucket<T: Copy + Ord>(items: &[T], count: usize, bucket: impl Fn(&T) -> u32) -> Vec<T> {
    let mut ends = vec![0usize; count + 1];
    items.iter().for_each(|item| ends[bucket(item) as usize + 1] += 1);
    for b in 1..ends.len() {
        ends[b] += ends[b - 1];
    }
    // Each from where a bucket begins to where it ends, which is where the next one begins.
    let mut sorted = items.to_vec();
    for item in items {
        let end = &mut ends[bucket(item) as usize];
        sorted[*end] = *item;
        *end += 1;
    }
    let mut from = 0;
    for end in ends {
        if end - from > 1 {
            sorted[from..end].sort_unstable();
        }
        from = end;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn it_sorts_like_a_sort_that_compares() {
        let mut rng = Rng::new(5, 0);
        for count in [0, 1, 2, 17, 5000] {
            let items: Vec<(u32, u32)> =
                (0..3 * count).map(|_| ((rng.unit() * count as f64) as u32, (rng.unit() * 10.0) as u32)).collect();
            let mut expected = items.clone();
            expected.sort_unstable();
            assert_eq!(sorted_by_bucket(&items, count, |item| item.0), expected);
        }
    }
}
