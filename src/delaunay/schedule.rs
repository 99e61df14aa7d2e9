//! Which tets are to be tested after a motion.
//!
//! To take the steps of its own eight vertices off the certificate of each tet would cost nearly as much as to test the
//! tets; to take off the longest step of all would waste them, for the longest is some fifty times the median. But a vertex
//! goes about as far in one motion as in the one before. So each vertex has a **bound** for its steps, and what it did not use of
//! it in earlier motions may be used later, up to [`SPARE`] of a bound. A tet that is tested is due again when its certificate
//! would have run out if all of its vertices had gone as far as they may: a number of motions, to be compared with a counter.
//!
//! 1. A vertex that goes farther than its bound and what it has to spare is **rash**: it gets a new bound, [`MARGIN`] times its
//!    step, and all tets that it is a corner or an apex of are due sooner. The bound of one that goes less far sinks, bit by
//!    bit. A bound never rises in another way, so what a vertex may do was not less when a tet was last planned.
//! 2. Tets that are due are tested, and those that pass are due again as said. The others, and what flips have written since,
//!    are due after the next motion.

use super::certificate::LEAST_BOUND;
use super::facet::INFINITE;

/// A bound is so many times the step that it was made for. With less, more vertices are rash; with more, tets are due sooner.
const MARGIN: f32 = 2.0;

/// So much of a bound may be saved. With more, what is tested after each motion in any case is more.
const SPARE: f32 = 0.25;

/// A bound sinks to no less than this share of itself in a motion.
const SINKING: f32 = 0.95;

/// A bound is not less than this share of the mean step, in squares, so that what trembles is not rash.
const LEAST_SHARE: f64 = 3e-3;

/// No tet is due later than so many motions from now.
const HORIZON: u16 = 1000;

/// Motions that are counted before all starts anew.
const LAST: u16 = u16::MAX - 2 * HORIZON;

/// Room for rounding.
const LONG: f32 = 1.0 + 1e-6;

/// Likewise.
const SHORT: f32 = 1.0 - 2e-6;

/// A vertex that went farther than it may.
#[derive(Clone, Copy)]
pub struct Rash {
    /// Its number.
    pub vertex: u32,
    /// How far it went, but for what it had saved.
    debt: f32,
    /// Its bound until now.
    bound: f32,
    /// Its bound from now on.
    new: f32,
}

/// When each tet is to be tested.
#[derive(Clone, Default)]
pub struct Schedule {
    /// The motion after which a tet is due; zero for always.
    due: Vec<u16>,
    /// The number of this motion.
    now: u16,
    /// Each vertex's bound.
    bounds: Vec<f32>,
    /// What it has saved.
    spare: Vec<f32>,
    /// The least bound.
    least: f32,
}

impl Schedule {
    /// Sets the bounds of vertices that went as far as the square roots of `steps2`.
    pub fn set_bounds(&mut self, steps2: &[f32]) {
        self.find_least(steps2);
        self.bounds.clear();
        self.bounds.extend(steps2.iter().map(|&s| bound(step(s), self.least)));
        self.spare.clear();
        self.spare.extend(self.bounds.iter().map(|b| b * SPARE));
    }

    /// Begins with these bounds, with all tets due now.
    pub fn start(&mut self, tets: usize) {
        self.now = 1;
        self.due.clear();
        self.due.resize(tets, 0);
    }

    /// Each vertex's bound.
    pub fn bounds(&self) -> &[f32] {
        &self.bounds
    }

    /// Whether there are numbers left for motions.
    pub fn goes_on(&self) -> bool {
        self.now < LAST
    }

    /// Goes on to the next motion, and leaves in `rash` the vertices that went farther than they may.
    pub fn advance(&mut self, steps2: &[f32], rash: &mut Vec<Rash>) {
        rash.clear();
        self.now += 1;
        let least = self.least;
        let bounds = self.bounds.chunks_mut(BLOCK).zip(self.spare.chunks_mut(BLOCK));
        for (block, ((bounds, spare), steps2)) in bounds.zip(steps2.chunks(BLOCK)).enumerate() {
            let mut any = false;
            for ((bound, spare), &step2) in bounds.iter().zip(&*spare).zip(steps2) {
                any |= step(step2) > bound + spare;
            }
            if any {
                let first = (block * BLOCK) as u32;
                for (((bound, spare), &step2), vertex) in bounds.iter().zip(&*spare).zip(steps2).zip(first..) {
                    let step = step(step2);
                    if step > bound + spare {
                        rash.push(Rash { vertex, debt: step - spare, bound: *bound, new: self::bound(step, least) });
                    }
                }
            }
            for ((old, spare), &step2) in bounds.iter_mut().zip(spare).zip(steps2) {
                let step = step(step2);
                let (new, left) = (bound(step, least), *old + *spare - step);
                let sunk = if new > *old * SINKING { new } else { *old * SINKING };
                let (lower, is_rash) = (if sunk < *old { sunk } else { *old }, left < 0.0);
                *old = if is_rash { new } else { lower };
                let most = *old * SPARE;
                let left = if is_rash { 0.0 } else { left };
                *spare = if left > most { most } else { left };
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
        let mean2 = sums.iter().sum::<f64>() / steps2.len().max(1) as f64;
        self.least = ((mean2 * LEAST_SHARE).sqrt() as f32).max(LEAST_BOUND);
    }

    /// Plans anew for a tet with a corner or apex that was rash. What was left to that one at its old bound has to do for
    /// what it took too much, and for the motions to come at its new bound.
    pub fn hasten(&mut self, t: u32, rash: &Rash) {
        let due = &mut self.due[t as usize];
        if *due > self.now {
            let left = rash.bound * (f32::from(*due - self.now) * SHORT) - rash.debt;
            // The conversion rounds down.
            *due = if left < 0.0 { 0 } else { (*due).min(self.now + 1 + (left / rash.new) as u16) };
        }
    }

    /// A tet is due now.
    pub fn wake(&mut self, t: u32) {
        self.due[t as usize] = 0;
    }

    /// The tets that are due, ascending.
    pub fn find_due(&self, found: &mut Vec<u32>) {
        // All are written, and those that are not due again: nothing depends on what cannot be foreseen.
        found.clear();
        found.resize(self.due.len() + 1, 0);
        let mut count = 0;
        for (t, &due) in (0..).zip(&self.due) {
            found[count] = t;
            count += usize::from(due <= self.now);
        }
        found.truncate(count);
    }

    /// Plans the next test of a tet that has been tested after this motion, given the motions that it is good for, below
    /// zero for none.
    #[inline]
    pub fn plan(&mut self, t: u32, certificate: f32) {
        self.due[t as usize] = if certificate < 0.0 { 0 } else { self.now + 1 + motions(certificate).min(HORIZON) };
    }

    /// The number of tets is now this. New ones are due after the next motion.
    pub fn resize(&mut self, tets: usize) {
        self.due.resize(tets, 0);
    }
}

/// Vertices or tets that are looked at together.
const BLOCK: usize = 16;

/// Motions before a tet with this certificate is tested again; the conversion rounds down, and to the limits of the type.
pub fn motions(certificate: f32) -> u16 {
    (certificate - SPARE) as u16
}

/// A step, not less, given its square.
#[inline(always)]
fn step(step2: f32) -> f32 {
    step2.sqrt() * LONG
}

/// The bound for a step.
#[inline(always)]
fn bound(step: f32, least: f32) -> f32 {
    let wanted = step * MARGIN;
    if wanted > least { wanted } else { least }
}

/// Whether none of a tet's corners and apexes has moved.
pub fn stands_still(tet: &[u32; 4], across: &[u32; 4], steps2: &[f32]) -> bool {
    tet.iter().chain(across).filter(|&&v| v != INFINITE).all(|&v| steps2[v as usize] == 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// What was promised to a tet when it was tested.
    struct Promise {
        vertices: [usize; 8],
        /// How far each may go until the tet is due, and has gone.
        reach: [f64; 8],
        gone: [f64; 8],
    }

    #[test]
    fn no_vertex_of_a_tet_that_is_not_due_goes_farther_than_its_certificate() {
        const VERTICES: usize = 40;
        const TETS: usize = 60;
        let mut rng = Rng::new(3, 0);
        let mut pick = || -> [usize; 8] { std::array::from_fn(|_| (rng.unit() * VERTICES as f64) as usize) };
        let tets: Vec<[usize; 8]> = (0..TETS).map(|_| pick()).collect();
        let mut rng = Rng::new(4, 0);
        // Mostly steady, now and then all at once much less or more, or not at all.
        let mut pace = [1.0f64; VERTICES];
        let mut steps = || -> Vec<f32> {
            let step = |p: &mut f64| {
                let luck = rng.unit();
                *p *= if luck < 0.02 {
                    8.0
                } else if luck < 0.06 {
                    0.5
                } else {
                    0.99
                };
                let length = if luck > 0.99 { 0.0 } else { *p * (0.5 + rng.unit()) };
                (length * length) as f32
            };
            pace.iter_mut().map(step).collect()
        };
        let mut schedule = Schedule::default();
        schedule.set_bounds(&steps());
        schedule.start(TETS);
        let mut promises: Vec<Option<Promise>> = (0..TETS).map(|_| None).collect();
        let (mut due, mut rash) = (Vec::new(), Vec::new());
        let (mut tested, mut hastened, mut spent) = (0, 0, 0.0f64);
        let mut luck = Rng::new(5, 0);
        for motion in 0..3000 {
            if motion > 0 {
                let steps2 = steps();
                for promise in promises.iter_mut().flatten() {
                    for (gone, &v) in promise.gone.iter_mut().zip(&promise.vertices) {
                        *gone += f64::from(steps2[v]).sqrt();
                    }
                }
                schedule.advance(&steps2, &mut rash);
                for rash in &rash {
                    for (t, _) in tets.iter().enumerate().filter(|(_, tet)| tet.contains(&(rash.vertex as usize))) {
                        schedule.hasten(t as u32, rash);
                        hastened += 1;
                    }
                }
            }
            schedule.find_due(&mut due);
            for (t, promise) in promises.iter_mut().enumerate() {
                if due.binary_search(&(t as u32)).is_err() {
                    let promise = promise.as_ref().expect("only what was tested is not due");
                    for (gone, reach) in promise.gone.iter().zip(promise.reach) {
                        assert!(*gone <= reach, "motion {motion}, tet {t}: {gone} of {reach}");
                        spent = spent.max(gone / reach);
                    }
                    continue;
                }
                tested += 1;
                let certificate = (luck.unit().powi(3) * 200.0) as f32;
                let vertices = tets[t];
                let reach = vertices.map(|v| f64::from(schedule.bounds()[v]) * f64::from(certificate));
                schedule.plan(t as u32, certificate);
                *promise = Some(Promise { vertices, reach, gone: [0.0; 8] });
            }
        }
        // They are used, and most of them are waited for.
        assert!(hastened > 1000 && spent > 0.9 && 2 * tested < 3000 * TETS, "{hastened} {spent} {tested}");
    }
}
