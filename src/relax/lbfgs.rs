//! Motions by the limited-memory BFGS method.
//!
//! - J. Nocedal, *Updating quasi-Newton matrices with limited storage*, Mathematics of Computation 35(151), 1980,
//!   doi 10.1090/S0025-5718-1980-0572855-7: the two-loop recursion.
//! - Y. Liu, W. Wang, B. Lévy, F. Sun, D.-M. Yan, L. Lu, C. Yang, *On centroidal Voronoi tessellation: energy smoothness and
//!   fast computation*, ACM Transactions on Graphics 28(4), 2009, doi 10.1145/1559755.1559758: for this energy.
//!
//! 1. q = g. From the newest pair (s, y) of motion and change of gradient to the oldest: α = ρ s.q, q -= α y.
//! 2. r = γ D^-1 q, with the diagonal D of the Hessian with fixed cells and γ = s.y / y.D^-1 y of the newest pair.
//! 3. From the oldest pair to the newest: r += (α - ρ y.r) s. The motion is -τ r.
//!
//! Without pairs this is -D^-1 g, the step of Lloyd. Departures:
//!
//! - H0 is γ D^-1, not a multiple of the identity, so that seeds of all kinds and sizes of cell are scaled right from the
//!   start.
//! - No search along r, which would cost cells to be clipped again. Instead τ follows where past searches would have ended:
//!   the slopes at both ends of a motion s tell it, by the secant, as -g.s / y.s motions. On the whole motions of τ = 1 are a
//!   fifth too short: with it, a random start needs a fifth fewer evaluations.
//!
//! Cost: 2 m dot products and sums for a memory of m pairs, each with the one before in one pass.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use glam::DVec3;
use rayon::prelude::*;

use super::objective::Slope;
use super::vectors::{add_scaled, add_scaled_and_dot, dot};
use crate::progress::Move;

/// m.
const MEMORY: usize = 7;

/// A pair must be convex by at least this share: s.y against |s|_D |y|_(D^-1).
const CONVEX: f64 = 1e-6;

/// How much of τ is the newest motion's.
const NEWEST: f64 = 0.2;

/// What a motion may say of τ.
const LENGTHS: RangeInclusive<f64> = 0.7..=1.5;

struct Pair {
    motion: Vec<DVec3>,
    change: Vec<DVec3>,
    /// s.y.
    curvature: f64,
}

/// The memory.
pub(super) struct Lbfgs {
    /// Oldest first.
    pairs: VecDeque<Pair>,
    /// τ.
    length: f64,
}

impl Default for Lbfgs {
    fn default() -> Lbfgs {
        Lbfgs { pairs: VecDeque::new(), length: 1.0 }
    }
}

impl Lbfgs {
    /// The next motion, which is Lloyd's while nothing is remembered.
    pub(super) fn motion(&self, slope: &Slope, lloyd: &[DVec3]) -> (Vec<DVec3>, Move) {
        // 1.
        let mut q = slope.gradient.clone();
        let used: Vec<&Pair> = self.pairs.iter().rev().filter(|p| p.curvature > 0.0).collect();
        let Some(newest) = used.first() else { return (lloyd.to_vec(), Move::Lloyd) };
        let mut alphas = Vec::with_capacity(MEMORY);
        let mut along = dot(&newest.motion, &q);
        for (n, pair) in used.iter().enumerate() {
            let alpha = along / pair.curvature;
            match used.get(n + 1) {
                Some(older) => along = add_scaled_and_dot(&mut q, -alpha, &pair.change, &older.motion),
                None => add_scaled(&mut q, -alpha, &pair.change),
            }
            alphas.push(alpha);
        }
        // 2.
        let gamma = newest.curvature / dot(&newest.change, &slope.relaxed(&newest.change));
        let mut r = slope.relaxed(&q);
        r.iter_mut().for_each(|r| *r *= gamma);
        // 3.
        let mut along = used.last().map_or(0.0, |oldest| dot(&oldest.change, &r));
        for (n, pair) in used.iter().enumerate().rev() {
            let factor = alphas[n] - along / pair.curvature;
            match n.checked_sub(1) {
                Some(newer) => along = add_scaled_and_dot(&mut r, factor, &pair.motion, &used[newer].change),
                None => add_scaled(&mut r, factor, &pair.motion),
            }
        }
        r.iter_mut().for_each(|r| *r *= -self.length);
        (r, Move::Lbfgs)
    }

    /// Remembers a motion and the change of the gradient that it made, if the energy is convex along it.
    pub(super) fn remember(&mut self, motion: Vec<DVec3>, change: Vec<DVec3>, slope: &Slope) {
        let curvature = dot(&motion, &change);
        let stiff: Vec<DVec3> = motion.par_iter().zip(&slope.stiffness).map(|(s, &d)| *s * d).collect();
        let sizes = (dot(&motion, &stiff) * dot(&change, &slope.relaxed(&change))).sqrt();
        if curvature > CONVEX * sizes {
            if !self.pairs.is_empty() {
                let best = self.length * (1.0 - dot(&motion, &slope.gradient) / curvature);
                self.length += NEWEST * (best.clamp(*LENGTHS.start(), *LENGTHS.end()) - self.length);
            }
            if self.pairs.len() == MEMORY {
                self.pairs.pop_front();
            }
            self.pairs.push_back(Pair { motion, change, curvature });
        }
    }

    /// Forgets all that a seed did.
    pub(super) fn forget_seed(&mut self, i: usize) {
        for pair in &mut self.pairs {
            pair.curvature -= pair.motion[i].dot(pair.change[i]);
            pair.motion[i] = DVec3::ZERO;
            pair.change[i] = DVec3::ZERO;
        }
    }

    /// Forgets everything.
    pub(super) fn forget(&mut self) {
        *self = Lbfgs::default();
    }
}
