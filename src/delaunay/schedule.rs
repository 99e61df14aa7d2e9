//! Which tets are to be tested after a motion.
//!
//! To take the steps of its own eight vertices off the certificate of each tet would cost nearly as much as to test the
//! tets; to take off the longest step of all would waste them, for the longest is some fifty times the median. But a vertex
//! goes about as far in one motion as in the one before. So each vertex has a **bound** for its steps, and a tet that is
//! tested is due again when its certificate would have run out if all of its vertices had gone as far as their bounds each
//! time: a number of motions, to be compared with a counter.
//!
//! 1. A vertex that goes farther than its bound is **rash**: it gets a new bound, [`MARGIN`] times its step, and all tets that
//!    it is a corner or an apex of are due. A vertex that goes less far than its bound by that much gets a lower one. A bound
//!    never rises in another way, so it was not higher when any tet was last tested that is not due.
//! 2. Tets that are due are tested, and those that pass are due again as said. The others, and what flips have written since,
//!    are due after the next motion.

use super::facet::INFINITE;

/// A bound is so many times the step that it was made for. With less, more vertices are rash; with more, tets are due sooner.
const MARGIN: f32 = 2.5;

/// A bound is not less than this share of the mean step, in squares, so that what trembles is not rash.
const LEAST_SHARE: f64 = 1e-4;

/// No tet is due later than so many motions from now.
const HORIZON: u16 = 1000;

/// Motions that are counted before all starts anew.
const LAST: u16 = u16::MAX - 2 * HORIZON;

/// Room for rounding.
const LONG: f32 = 1.0 + 1e-6;

/// When each tet is to be tested.
#[derive(Clone, Default)]
pub struct Schedule {
    /// The motion after which a tet is due; zero for always.
    due: Vec<u16>,
    /// The number of this motion.
    now: u16,
    /// Square of each vertex's bound.
    bounds2: Vec<f32>,
    /// Square of the least bound.
    least2: f32,
}

impl Schedule {
    /// Begins, with all tets due now; the vertices went as far as the square roots of `steps2`.
    pub fn start(&mut self, tets: usize, steps2: &[f32]) {
        self.now = 1;
        self.due.clear();
        self.due.resize(tets, 0);
        self.find_least(steps2);
        self.bounds2.clear();
        self.bounds2.extend(steps2.iter().map(|&s| bound2(s, self.least2)));
    }

    /// Whether there are numbers left for motions.
    pub fn goes_on(&self) -> bool {
        self.now < LAST
    }

    /// Goes on to the next motion, and leaves in `rash` the vertices that went farther than their bounds.
    pub fn advance(&mut self, steps2: &[f32], rash: &mut Vec<u32>) {
        rash.clear();
        self.now += 1;
        let least2 = self.least2;
        for (block, (bounds2, steps2)) in self.bounds2.chunks_mut(BLOCK).zip(steps2.chunks(BLOCK)).enumerate() {
            let mut any = false;
            for (bound, &step) in bounds2.iter().zip(steps2) {
                any |= step > *bound;
            }
            if any {
                let first = (block * BLOCK) as u32;
                rash.extend(bounds2.iter().zip(steps2).zip(first..).filter(|((b, s), _)| s > b).map(|(_, v)| v));
            }
            for (bound, &step) in bounds2.iter_mut().zip(steps2) {
                let new = bound2(step, least2);
                *bound = if step > *bound || new < *bound { new } else { *bound };
            }
        }
        self.find_least(steps2);
    }

    fn find_least(&mut self, steps2: &[f32]) {
        // Sums in a fixed order, several at once.
        let mut sums = [0.0; BLOCK];
        for steps2 in steps2.chunks(BLOCK) {
            for (sum, &step) in sums.iter_mut().zip(steps2) {
                *sum += f64::from(step);
            }
        }
        self.least2 = (sums.iter().sum::<f64>() / steps2.len().max(1) as f64 * LEAST_SHARE) as f32;
    }

    /// A tet is due now.
    pub fn wake(&mut self, t: u32) {
        self.due[t as usize] = 0;
    }

    /// The tets that are due, ascending.
    pub fn find_due(&self, found: &mut Vec<u32>) {
        found.clear();
        let now = self.now;
        for (block, due) in self.due.chunks(BLOCK).enumerate() {
            let mut any = false;
            for &d in due {
                any |= d <= now;
            }
            if any {
                let first = (block * BLOCK) as u32;
                found.extend(due.iter().zip(first..).filter(|(d, _)| **d <= now).map(|(_, t)| t));
            }
        }
    }

    /// Plans the next test of a tet that has been tested after this motion, given its certificate, below zero for none.
    #[inline]
    pub fn plan(&mut self, t: u32, tet: &[u32; 4], across: &[u32; 4], certificate: f32) {
        self.due[t as usize] = if certificate < 0.0 {
            0
        } else {
            let mut most2 = f32::MIN_POSITIVE;
            for &v in tet.iter().chain(across) {
                // The infinite vertex does not move.
                let bound2 = self.bounds2.get(v as usize).copied().unwrap_or(0.0);
                most2 = if bound2 > most2 { bound2 } else { most2 };
            }
            // Motions that it is good for; the conversion rounds down, and to the limits of the type.
            let motions = (certificate / (most2.sqrt() * LONG * LONG)) as u16;
            self.now + 1 + motions.min(HORIZON)
        };
    }

    /// The number of tets is now this. New ones are due after the next motion.
    pub fn resize(&mut self, tets: usize) {
        self.due.resize(tets, 0);
    }
}

/// Vertices or tets that are looked at together.
const BLOCK: usize = 16;

/// The square of the bound for a step.
#[inline(always)]
fn bound2(step2: f32, least2: f32) -> f32 {
    let wanted = step2 * (MARGIN * MARGIN);
    if wanted > least2 { wanted } else { least2 }
}

/// Whether none of a tet's corners and apexes has moved.
pub fn stands_still(tet: &[u32; 4], across: &[u32; 4], steps2: &[f32]) -> bool {
    tet.iter().chain(across).filter(|&&v| v != INFINITE).all(|&v| steps2[v as usize] == 0.0)
}
