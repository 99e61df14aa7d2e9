//! Brings every tet to the floor: worst first, by whatever single operation makes the worst of the tets involved better.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::change::Change;
use super::complex::{Complex, Mark};
use super::faces::remove_faces;
use super::flips::remove_edge;
use super::ground::Ground;
use super::smooth::{Smoother, least_gain};
use crate::geometry::tetrahedron::EDGES;

/// The tets below the floor, worst first, and the buffers of the operations.
#[derive(Default)]
pub(super) struct Worklist {
    heap: BinaryHeap<Reverse<(u64, u32)>>,
    best: Change,
    trial: Change,
    smoother: Smoother,
    near: Vec<u32>,
    /// Whether no vertex may be made or taken out, be it that the count comes out right.
    pub(super) keeps_vertices: bool,
    /// Tets that may yet be treated.
    left: usize,
}

/// Orders qualities like numbers.
fn key(quality: f64) -> u64 {
    let bits = quality.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

impl Worklist {
    /// A list that treats so many tets at most, in all.
    pub(super) fn new(most: usize) -> Worklist {
        Worklist { left: most, ..Worklist::default() }
    }

    /// Works off all tets below the floor.
    pub(super) fn run(&mut self, complex: &mut Complex, ground: &Ground) {
        self.fill(complex);
        while let Some(t) = self.next(complex) {
            if self.treat(complex, ground, t) {
                complex.commit();
            }
        }
    }

    /// All tets below the floor.
    fn fill(&mut self, complex: &Complex) {
        self.heap.clear();
        for t in 0..complex.tets.len() as u32 {
            if complex.is_alive(t) {
                self.push(complex, t);
            }
        }
    }

    fn push(&mut self, complex: &Complex, t: u32) {
        let quality = complex.quality[t as usize];
        if quality < complex.floor() {
            self.heap.push(Reverse((key(quality), t)));
        }
    }

    /// Puts those on the list, of the tets around these vertices, that are below the floor.
    fn push_around(&mut self, complex: &Complex) {
        self.near.sort_unstable();
        self.near.dedup();
        for k in 0..self.near.len() {
            for &t in complex.star(self.near[k]) {
                self.push(complex, t);
            }
        }
    }

    /// Makes what changed since `mark` the list, and works off `most` of it, without a commit. Whether every tet there is better
    /// than `least` then; the first that is not and cannot be helped ends the work.
    pub(super) fn work_since(
        &mut self,
        complex: &mut Complex,
        ground: &Ground,
        mark: Mark,
        (most, least): (usize, f64),
    ) -> bool {
        self.heap.clear();
        self.near.clear();
        for t in complex.changed_since(mark) {
            self.near.extend(complex.tets[t as usize]);
        }
        self.push_around(complex);
        for _ in 0..most {
            let Some(t) = self.next(complex) else { break };
            if !self.treat(complex, ground, t) && complex.quality[t as usize] <= least {
                return false;
            }
        }
        complex.changed_since(mark).all(|t| complex.quality[t as usize] > least)
    }

    /// The worst tet of the list.
    fn next(&mut self, complex: &Complex) -> Option<u32> {
        loop {
            let Reverse((quality, t)) = self.heap.pop()?;
            // The same tet may be there several times.
            while self.heap.peek() == Some(&Reverse((quality, t))) {
                self.heap.pop();
            }
            if complex.is_alive(t) && key(complex.quality[t as usize]) == quality {
                return Some(t);
            }
        }
    }

    /// Improves the neighbourhood of one tet; whether that went.
    fn treat(&mut self, complex: &mut Complex, ground: &Ground, t: u32) -> bool {
        self.near.clear();
        if self.left == 0 {
            return false;
        }
        self.left -= 1;
        if self.flip(complex, ground, t) || self.smooth(complex, ground, t) {
            self.push_around(complex);
            return true;
        }
        false
    }

    /// The best of the flips that take tet `t` away.
    fn flip(&mut self, complex: &mut Complex, ground: &Ground, t: u32) -> bool {
        let tet = complex.tets[t as usize];
        let mut least = complex.quality[t as usize];
        least += least_gain(least, complex.floor());
        let mut found = false;
        let mut keep = |list: &mut (&mut Change, &mut Change), least: &mut f64| {
            *least = list.1.worst;
            std::mem::swap(list.0, list.1);
            found = true;
        };
        let mut changes = (&mut self.best, &mut self.trial);
        for [i, j] in EDGES {
            if remove_edge(complex, ground, [tet[i], tet[j]], least, changes.1) {
                keep(&mut changes, &mut least);
            }
        }
        for i in 0..4 {
            if remove_faces(complex, t, i, least, changes.1) {
                keep(&mut changes, &mut least);
            }
        }
        if found {
            self.near.extend(self.best.old_tets.iter().flat_map(|&t| complex.tets[t as usize]));
            self.best.apply(complex);
        }
        found
    }

    /// Moves the corners of tet `t`, each where it can.
    fn smooth(&mut self, complex: &mut Complex, ground: &Ground, t: u32) -> bool {
        let mut moved = false;
        for v in complex.tets[t as usize] {
            if self.smoother.raise_worst(complex, ground, v) {
                moved = true;
                for &t in complex.star(v) {
                    self.near.extend(complex.tets[t as usize]);
                }
            }
        }
        moved
    }

    /// One round of the polish: every vertex where the sum of its tets' smallest angles is larger. How many moved.
    pub(super) fn polish(&mut self, complex: &mut Complex, ground: &Ground) -> usize {
        let mut moved = 0;
        for v in 0..complex.points.len() as u32 {
            if !complex.star(v).is_empty() && self.smoother.raise_sum(complex, ground, v) {
                moved += 1;
                complex.commit();
            }
        }
        moved
    }
}
