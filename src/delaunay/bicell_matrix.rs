//! The matrix of a bi-cell, and how far it may change before its determinant can.
//!
//! Zhou et al. 2010 (`bicell_filter.rs`): while ‖ΔM‖ < ω = 1/‖M⁻¹‖, M + ΔM = M (1 + M⁻¹ ΔM) is regular, so the sign of its
//! determinant has not changed. The norm is the ∞-norm: the largest sum of absolute values in a row.
//!
//! Two tets: rows (x, y, z, x² + y² + z², 1), translated so that the first point is the origin; its row and the column of
//! ones drop out. A tet and an infinite tet, or two infinite ones: rows (x, y, z, 1) of their four points, translated likewise.
//!
//! **Rounding.** M⁻¹ is the adjugate over the determinant. Either is a sum of products with at most 12 roundings in each, so
//! that the same sums of absolute values, times 2^-49, bound the errors. The entries of M have relative errors of
//! at most 5 * 2^-53, before and after, which come to less than 2^-48 ‖M‖ in all: that is taken off ω.

use glam::DVec3;

/// The rows.
pub type Rows = [[f64; 4]; 4];

/// 2^-49.
const ROUNDING: f64 = f64::EPSILON * 8.0;

/// Below this determinant products may underflow.
const TINY: f64 = 1e-200;

/// Of two tets, from four of their five points relative to the first.
pub fn of_sphere(points: &[DVec3; 4]) -> Rows {
    points.map(|p| [p.x, p.y, p.z, p.length_squared()])
}

/// Of tets of which one at least is infinite, from three of their four points relative to the first.
pub fn of_plane([a, b, c]: [DVec3; 3]) -> Rows {
    let row = |p: DVec3| [p.x, p.y, p.z, 1.0];
    [row(DVec3::ZERO), row(a), row(b), row(c)]
}

/// The norm of the difference.
pub fn distance(a: &Rows, b: &Rows) -> f64 {
    let entry = |r: usize, c: usize| (a[r][c] - b[r][c]).abs();
    largest([0, 1, 2, 3].map(|r| (entry(r, 0) + entry(r, 1)) + (entry(r, 2) + entry(r, 3))))
}

/// ω, rounded down; zero if the determinant may be.
pub fn tolerance(m: &Rows) -> f64 {
    let (adjugate, det) = adjugate(m, |x, y| x - y);
    let (adjugate_size, det_size) = self::adjugate(&m.map(|row| row.map(f64::abs)), |x, y| x + y);
    let least = det.abs() - ROUNDING * det_size;
    if least <= TINY {
        return 0.0;
    }
    let entry = |r: usize, c: usize| adjugate[r][c].abs() + ROUNDING * adjugate_size[r][c];
    let sizes = [0, 1, 2, 3].map(|r| (entry(r, 0) + entry(r, 1)) + (entry(r, 2) + entry(r, 3)));
    let inverse = largest(sizes) / least;
    let omega = 1.0 / inverse - 2.0 * ROUNDING * distance(m, &[[0.0; 4]; 4]);
    (omega * (1.0 - 1e-12)).max(0.0)
}

/// Without the rules of `f64::max` for NaN, which cost time.
fn largest([a, b, c, d]: [f64; 4]) -> f64 {
    let larger = |x: f64, y: f64| if x > y { x } else { y };
    larger(larger(a, b), larger(c, d))
}

/// The adjugate, up to signs, and the determinant. With a sum in place of each difference, and absolute values, the sums of the
/// absolute values of all products.
#[inline(always)]
fn adjugate(m: &Rows, minus: impl Fn(f64, f64) -> f64) -> (Rows, f64) {
    // Minors of the upper and of the lower two rows, by pair of columns.
    let minor = |r: usize, i: usize, j: usize| minus(m[r][i] * m[r + 1][j], m[r + 1][i] * m[r][j]);
    let minors =
        |r: usize| [minor(r, 0, 1), minor(r, 0, 2), minor(r, 0, 3), minor(r, 1, 2), minor(r, 1, 3), minor(r, 2, 3)];
    let (upper, lower) = (minors(0), minors(2));
    let det = minus(upper[0] * lower[5], upper[1] * lower[4])
        + upper[2] * lower[3]
        + minus(upper[3] * lower[2], upper[4] * lower[1])
        + upper[5] * lower[0];
    // Row c of the adjugate lacks column c: each of the three left in turn is that of the entry, the minor those of the others.
    // Its column r lacks row r: the entry is from the row beside r, the minor from the other half.
    let row = |[i, j, k]: [usize; 3], [p, q, r]: [usize; 3]| {
        let entry = |n: usize, half: &[f64; 6]| minus(m[n][i] * half[p], m[n][j] * half[q]) + m[n][k] * half[r];
        [entry(1, &lower), entry(0, &lower), entry(3, &upper), entry(2, &upper)]
    };
    let adjugate =
        [row([1, 2, 3], [5, 4, 3]), row([0, 2, 3], [5, 2, 1]), row([0, 1, 3], [4, 2, 0]), row([0, 1, 2], [3, 1, 0])];
    (adjugate, det)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn adjugate_times_matrix_is_the_determinant() {
        let mut rng = Rng::new(3, 0);
        for _ in 0..100 {
            let m: Rows = std::array::from_fn(|_| std::array::from_fn(|_| rng.signed()));
            let (adjugate, det) = adjugate(&m, |x, y| x - y);
            for (i, row) in adjugate.iter().enumerate() {
                let signed = |k: usize| if (i + k).is_multiple_of(2) { row[k] } else { -row[k] };
                let product: [f64; 4] = std::array::from_fn(|j| (0..4).map(|k| signed(k) * m[k][j]).sum());
                for (j, sum) in product.into_iter().enumerate() {
                    let expected = if i == j { det } else { 0.0 };
                    assert!((sum - expected).abs() < 1e-13, "{i} {j}: {sum} {expected}");
                }
            }
        }
    }

    #[test]
    fn within_omega_the_sign_stays_and_just_beyond_it_may_change() {
        let mut rng = Rng::new(4, 0);
        let det = |m: &Rows| adjugate(m, |x, y| x - y).1;
        for _ in 0..300 {
            let m = of_sphere(&std::array::from_fn(|_| rng.in_cube()));
            let omega = tolerance(&m);
            assert!(omega > 0.0);
            let sign = det(&m).signum();
            for _ in 0..100 {
                let mut moved = m;
                for row in &mut moved {
                    // Each row changes by nearly all that is allowed.
                    let change: [f64; 4] = std::array::from_fn(|_| rng.signed());
                    let size: f64 = change.iter().map(|x| x.abs()).sum();
                    (0..4).for_each(|c| row[c] += change[c] / size * omega * 0.999);
                }
                assert!(distance(&moved, &m) < omega);
                assert_eq!(det(&moved).signum(), sign);
            }
            // 1/‖M⁻¹‖ is the distance to the nearest singular matrix: it is reached by a change of rank one.
            let (adjugate, det_m) = adjugate(&m, |x, y| x - y);
            let size = |r: usize| adjugate[r].iter().map(|x| x.abs()).sum::<f64>();
            let worst = (0..4).max_by(|&a, &b| size(a).total_cmp(&size(b))).expect("four rows");
            let mut moved = m;
            for (k, row) in moved.iter_mut().enumerate() {
                let sign = if (worst + k).is_multiple_of(2) { 1.0 } else { -1.0 };
                row[worst] -= 1.001 * omega * (sign * adjugate[worst][k] / det_m).signum();
            }
            assert_ne!(det(&moved).signum(), sign);
        }
    }

    #[test]
    fn ties_have_no_tolerance() {
        let cube = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
        assert_eq!(tolerance(&of_sphere(&cube)), 0.0);
        assert_eq!(tolerance(&of_plane([DVec3::X, DVec3::Y, DVec3::new(0.3, 0.7, 0.0)])), 0.0);
        assert!(tolerance(&of_plane([DVec3::X, DVec3::Y, DVec3::Z])) > 0.1);
    }
}
