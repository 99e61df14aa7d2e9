//! Exact arithmetic on sums of `f64`, for the few predicates that floating point cannot decide.
//!
//! An expansion is a sum of `f64` that do not overlap, smallest first, so that its last component has the sign of the
//! whole. Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, Discrete &
//! Computational Geometry 18, 1997, doi 10.1007/PL00009321. Plain and allocating: this code runs for one predicate in
//! thousands.

use crate::geometry::predicates::Sign;

/// An exact sum of `f64`; the empty one is zero.
#[derive(Clone, Debug, Default)]
pub(super) struct Expansion(Vec<f64>);

impl Expansion {
    /// Adds the exact product of `a` and `b`.
    pub(super) fn add_product(&mut self, a: f64, b: f64) {
        let (high, low) = two_product(a, b);
        self.grow(low);
        self.grow(high);
    }

    /// The exact sum.
    pub(super) fn plus(&self, other: &Expansion) -> Expansion {
        let mut sum = self.clone();
        other.0.iter().for_each(|&x| sum.grow(x));
        sum
    }

    /// The exact difference.
    pub(super) fn minus(&self, other: &Expansion) -> Expansion {
        let mut sum = self.clone();
        other.0.iter().for_each(|&x| sum.grow(-x));
        sum
    }

    /// The exact product.
    pub(super) fn times(&self, other: &Expansion) -> Expansion {
        let mut product = Expansion::default();
        for &a in &self.0 {
            for &b in &other.0 {
                product.add_product(a, b);
            }
        }
        product
    }

    /// The exact product with one `f64`.
    pub(super) fn scaled(&self, factor: f64) -> Expansion {
        let mut product = Expansion::default();
        self.0.iter().for_each(|&a| product.add_product(a, factor));
        product
    }

    /// The whole, rounded.
    pub(super) fn value(&self) -> f64 {
        self.0.iter().sum()
    }

    /// The sign of the whole.
    pub(super) fn sign(&self) -> Sign {
        match self.0.last() {
            Some(&x) if x > 0.0 => Sign::Positive,
            Some(&x) if x < 0.0 => Sign::Negative,
            _ => Sign::Zero,
        }
    }

    /// Adds one `f64`: GROW-EXPANSION with zeros left out (section 2.4).
    fn grow(&mut self, x: f64) {
        let mut carry = x;
        let mut kept = 0;
        for k in 0..self.0.len() {
            let (high, low) = two_sum(carry, self.0[k]);
            if low != 0.0 {
                self.0[kept] = low;
                kept += 1;
            }
            carry = high;
        }
        self.0.truncate(kept);
        if carry != 0.0 {
            self.0.push(carry);
        }
    }
}

/// `a + b` and its rounding error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

/// `a * b` and its rounding error, by Dekker's splitting.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    let error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, error)
}

/// `a` as a sum of two `f64` of 26 bits each.
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a; // 2^27 + 1
    let high = c - (c - a);
    (high, a - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(x: f64) -> Expansion {
        let mut e = Expansion::default();
        e.grow(x);
        e
    }

    #[test]
    fn what_f64_loses_is_kept() {
        let tiny = of(1e-30);
        let sum = of(1.0).plus(&tiny).minus(&of(1.0));
        assert_eq!(sum.sign(), Sign::Positive);
        assert_eq!(sum.minus(&tiny).sign(), Sign::Zero);
    }

    #[test]
    fn products_expand_exactly() {
        // (a + b)(a - b) - (a^2 - b^2) = 0 for values whose squares need 106 bits.
        let (a, b) = (0.1234567890123456, 0.9876543210987654e-9);
        let left = of(a).plus(&of(b)).times(&of(a).minus(&of(b)));
        let mut right = Expansion::default();
        right.add_product(a, a);
        right.add_product(-b, b);
        assert_eq!(left.minus(&right).sign(), Sign::Zero);
        assert_eq!(left.minus(&right).plus(&of(-1e-200)).sign(), Sign::Negative);
    }
}
