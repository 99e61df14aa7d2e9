//! Lloyd's iteration with momentum.
//!
//! - Y. Nesterov, *A method for solving the convex programming problem with convergence rate O(1/k^2)*, Soviet Mathematics
//!   Doklady 27(2), 1983.
//! - B. O'Donoghue, E. Candès, *Adaptive restart for accelerated gradient schemes*, Foundations of Computational Mathematics
//!   15(3), 2015, doi 10.1007/s10208-013-9150-3.
//!
//! 1. From y, where the gradient is known, x' = y - 1.5 D^-1 g: half again the step of Lloyd.
//! 2. The way from the last x to x' is the velocity; if it points uphill or the energy has risen, momentum starts anew.
//! 3. y' = x' + β velocity, with β = (t - 1) / t', t' = (1 + sqrt(1 + 4 t^2)) / 2.
//!
//! Departure: the seeds are the points y; as the momentum fades they and the x are the same. There is no line search: each
//! iteration takes one evaluation, and one vector of memory.

use glam::DVec3;

use super::objective::Slope;
use super::vectors::{add_scaled, dot};

/// Steps over Lloyd's.
const OVERRELAXED: f64 = 1.5;

/// The momentum.
pub(super) struct Nesterov {
    /// y - x: the part of the last motion that was momentum.
    momentum: Vec<DVec3>,
    t: f64,
    /// The last energy.
    energy: f64,
}

impl Default for Nesterov {
    fn default() -> Nesterov {
        Nesterov { momentum: Vec::new(), t: 1.0, energy: f64::INFINITY }
    }
}

impl Nesterov {
    /// The next motion.
    pub(super) fn motion(&mut self, slope: &Slope, lloyd: &[DVec3]) -> Vec<DVec3> {
        // 1.
        let mut step: Vec<DVec3> = lloyd.iter().map(|s| OVERRELAXED * *s).collect();
        // 2.
        self.momentum.resize(step.len(), DVec3::ZERO);
        let mut velocity = step.clone();
        add_scaled(&mut velocity, 1.0, &self.momentum);
        let risen = slope.energy > std::mem::replace(&mut self.energy, slope.energy);
        if risen || dot(&slope.gradient, &velocity) > 0.0 {
            self.forget();
            velocity = step.clone();
        }
        // 3.
        let next = 0.5 * (1.0 + (1.0 + 4.0 * self.t * self.t).sqrt());
        let beta = (self.t - 1.0) / next;
        self.t = next;
        velocity.iter_mut().for_each(|v| *v *= beta);
        add_scaled(&mut step, 1.0, &velocity);
        self.momentum = velocity;
        step
    }

    /// Forgets what a seed did.
    pub(super) fn forget_seed(&mut self, i: usize) {
        if let Some(m) = self.momentum.get_mut(i) {
            *m = DVec3::ZERO;
        }
    }

    /// Starts anew.
    pub(super) fn forget(&mut self) {
        self.momentum.fill(DVec3::ZERO);
        self.t = 1.0;
        self.energy = f64::INFINITY;
    }
}
