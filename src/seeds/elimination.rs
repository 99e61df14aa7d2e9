//! Blue noise by weighted sample elimination.
//!
//! C. Yuksel, *Sample Elimination for Generating Poisson Disk Sample Sets*, Computer Graphics Forum 34(2), 2015,
//! doi 10.1111/cgf.12538.
//!
//! 1. Weigh each sample by its neighbours: the sum of (1 - d / r)^8 over all at a distance d below r.
//! 2. Take the heaviest sample out and lower the weights of its neighbours.
//! 3. Repeat until as many are left as wanted.
//!
//! Departures: r is the spacing wanted where the two samples are, so that the density may vary; fixed samples repel but
//! are never taken out; samples whose normals point apart lie on two sides of a wall and repel only when they are close
//! to each other; a group (one shell of the surface) keeps a least number of samples.
//!
//! Cost: O(m log m) for m samples.

use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::grid::{CellGrid, typical};

/// A sample, or a fixed neighbour of samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) position: DVec3,
    /// Unit normal of its sheet; zero where there is none.
    pub(super) normal: DVec3,
    /// The spacing wanted here.
    pub(super) spacing: f64,
    /// The group that it belongs to.
    pub(super) group: u32,
}

/// Spacings differ by much where the longest is so many times the usual one.
const DIFFERENT: f64 = 1.5;

/// Distances across a wall count so many times.
const ACROSS_WALL: f64 = 2.5;

/// An entry of the queue: heaviest first, then lowest index; out of date once the sample's weight has changed.
#[derive(PartialEq)]
struct Entry {
    weight: f64,
    sample: u32,
}

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Entry) -> Ordering {
        self.weight.total_cmp(&other.weight).then(other.sample.cmp(&self.sample))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Entry) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Chooses `keep` of `samples`, given neighbours that stay, and returns their indices in ascending order. Group g
/// keeps `least[g]` of its samples as long as it has so many.
pub(super) fn eliminate(samples: &[Sample], fixed: &[Sample], keep: usize, least: &[usize]) -> Vec<u32> {
    let spacings: Vec<f64> = samples.iter().chain(fixed).map(|s| s.spacing).collect();
    let longest = spacings.iter().copied().fold(0.0, f64::max);
    let usual = typical(&spacings);
    // Where spacings differ by much, each looks as far as neighbours with a spacing up to twice its own want to be.
    let (cell, differ) = if longest > DIFFERENT * usual { (usual, true) } else { (longest, false) };
    let reach = |s: &Sample| if differ { (1.5 * s.spacing).min(longest) } else { longest };
    let positions: Vec<DVec3> = samples.iter().map(|s| s.position).collect();
    // 2 r_max of the paper is the spacing; distances below r_min = 0.65 (1 - (kept share)^1.5) r_max count as r_min.
    let share = keep as f64 / samples.len().max(1) as f64;
    let clamp = 0.325 * (1.0 - share * share.sqrt());
    let grid = CellGrid::new(&positions, cell);

    // 1. Weigh.
    let mut weights = vec![0.0; samples.len()];
    for (i, s) in samples.iter().enumerate() {
        grid.near(s.position, reach(s), |j| {
            if j as usize > i {
                let w = weight(s, &samples[j as usize], clamp);
                weights[i] += w;
                weights[j as usize] += w;
            }
        });
    }
    for f in fixed {
        grid.near(f.position, reach(f), |j| weights[j as usize] += weight(f, &samples[j as usize], clamp));
    }

    // 2. Take out. Weights only fall, so that an entry out of date is always too heavy: it goes back with the weight
    // of the day.
    let mut left = vec![0usize; least.len()];
    samples.iter().for_each(|s| left[s.group as usize] += 1);
    let mut alive = vec![true; samples.len()];
    let mut heap: BinaryHeap<Entry> =
        weights.iter().enumerate().map(|(i, &weight)| Entry { weight, sample: i as u32 }).collect();
    let mut surplus = samples.len().saturating_sub(keep);
    while surplus > 0 {
        let Some(entry) = heap.pop() else { break };
        let i = entry.sample as usize;
        if weights[i] < entry.weight {
            heap.push(Entry { weight: weights[i], sample: entry.sample });
            continue;
        }
        let s = &samples[i];
        if left[s.group as usize] <= least[s.group as usize] {
            continue;
        }
        left[s.group as usize] -= 1;
        alive[i] = false;
        surplus -= 1;
        grid.near(s.position, reach(s), |j| {
            if alive[j as usize] {
                weights[j as usize] -= weight(s, &samples[j as usize], clamp);
            }
        });
    }
    (0..samples.len() as u32).filter(|&i| alive[i as usize]).collect()
}

fn weight(a: &Sample, b: &Sample, clamp: f64) -> f64 {
    let reach = 0.5 * (a.spacing + b.spacing);
    let distance2 = a.position.distance_squared(b.position);
    if distance2 >= reach * reach {
        return 0.0;
    }
    let mut d = distance2.sqrt() / reach;
    if a.normal.dot(b.normal) < 0.0 {
        d *= ACROSS_WALL;
    }
    let w = 1.0 - d.max(clamp);
    if w <= 0.0 {
        return 0.0;
    }
    let w2 = w * w;
    let w4 = w2 * w2;
    w4 * w4
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    fn square(n: usize, spacing: f64) -> Vec<Sample> {
        let mut rng = Rng::new(3, 0);
        let at = |p: DVec3| Sample { position: p, normal: DVec3::Z, spacing, group: 0 };
        (0..n).map(|_| at(DVec3::new(rng.unit(), rng.unit(), 0.0))).collect()
    }

    #[test]
    fn what_is_left_is_spread() {
        let spacing = (1.0f64 / (0.866 * 400.0)).sqrt();
        let samples = square(2000, spacing);
        let kept = eliminate(&samples, &[], 400, &[0]);
        assert_eq!(kept.len(), 400);
        let nearest = |i: &u32| {
            let p = samples[*i as usize].position;
            kept.iter().filter(|j| *j != i).map(|&j| samples[j as usize].position.distance(p)).fold(1.0, f64::min)
        };
        let least = kept.iter().map(nearest).fold(1.0, f64::min);
        // White noise of 400 points has its closest pair near 0.002; the paper reports 0.7 to 0.8 of the bound.
        assert!(least > 0.6 * spacing, "{least} of {spacing}");
    }

    #[test]
    fn fixed_samples_repel_and_groups_keep_their_least() {
        let spacing = 0.2;
        let mut samples = square(300, spacing);
        samples.iter_mut().take(10).for_each(|s| s.group = 1);
        let middle = Sample { position: DVec3::new(0.5, 0.5, 0.0), normal: DVec3::ZERO, spacing, group: 0 };
        let kept = eliminate(&samples, &[middle], 25, &[0, 9]);
        assert_eq!(kept.len(), 25);
        assert!(kept.iter().filter(|&&i| samples[i as usize].group == 1).count() >= 9);
        let free = kept.iter().filter(|&&i| samples[i as usize].group == 0);
        assert!(free.clone().all(|&i| samples[i as usize].position.distance(middle.position) > 0.5 * spacing));
    }
}
