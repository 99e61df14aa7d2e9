//! Triangle strips.

/// The triangles of a strip over the corners 0 to n - 1: every second one is turned.
pub fn triangles(n: usize) -> impl Iterator<Item = [usize; 3]> {
    (2..n).map(|k| if k % 2 == 0 { [k - 2, k - 1, k] } else { [k - 1, k - 2, k] })
}
