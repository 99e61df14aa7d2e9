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

/// Tets treated in one go over all that are below the floor, for each of them and beside: the rest is crawl.
const TREATED_EACH: usize = 12;
const TREATED_LEAST: usize = 2000;

/// What the tets around a change must come to for it to be kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    /// So many tets are treated at most.
    pub treated: usize,
    /// Every tet that changed is better than this.
    pub least: f64,
    /// The deficit of the whole mesh, at most.
    pub deficit: f64,
}

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
    /// Whether the boundary is to follow the surface.
    pub(super) follows: bool,
    /// The commit at which nothing helped a tet, by slot.
    hopeless: Vec<u32>,
    /// Tets treated so far, and how many end [`Worklist::run`].
    treated: usize,
    most: usize,
}

/// Orders qualities like numbers.
fn key(quality: f64) -> u64 {
    let bits = quality.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

impl Worklist {
    /// A list that [`Worklist::run`] works off until so many tets were treated in all.
    pub(super) fn new(most: usize) -> Worklist {
        Worklist { most, ..Worklist::default() }
    }

    /// How many tets were treated so far: a measure of the work done that is the same everywhere.
    pub(super) fn treated(&self) -> usize {
        self.treated
    }

    /// Works off all tets below the floor, but for those that nothing helped before and around which nothing changed since.
    /// Not beyond `last` tets treated in all.
    pub(super) fn run(&mut self, complex: &mut Complex, ground: &Ground, last: usize) {
        self.heap.clear();
        for t in 0..complex.tets.len() as u32 {
            if complex.is_alive(t) {
                self.push(complex, t);
            }
        }
        let until = last.min(self.most).min(self.treated + TREATED_LEAST + TREATED_EACH * self.heap.len());
        while let Some(t) = self.next(complex) {
            if self.treated >= until {
                break;
            }
            self.hopeless.resize(complex.tets.len(), 0);
            let tried = self.hopeless[t as usize];
            if tried > 0 && complex.last_change(t) < tried {
                continue;
            }
            if self.treat(complex, ground, t) {
                complex.commit();
            } else {
                self.hopeless[t as usize] = complex.commits() + 1;
            }
        }
    }

    /// Lets every tet be tried again: what stands in their way has changed.
    pub(super) fn forget(&mut self) {
        self.hopeless.clear();
        self.smoother.forget();
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

    /// Makes what changed since `mark` the list, and works off some of it, without a commit. Whether the aim was reached; the first
    /// tet that is too bad and cannot be helped ends the work, and so do those that leave too large a deficit.
    pub(super) fn work_since(&mut self, complex: &mut Complex, ground: &Ground, mark: Mark, aim: Aim) -> bool {
        self.heap.clear();
        self.near.clear();
        for t in complex.changed_since(mark) {
            self.near.extend(complex.tets[t as usize]);
        }
        self.push_around(complex);
        for _ in 0..aim.treated {
            let Some(t) = self.next(complex) else { break };
            if !self.treat(complex, ground, t)
                && (complex.quality[t as usize] <= aim.least || self.certain_deficit(complex) > aim.deficit)
            {
                return false;
            }
        }
        complex.deficit() <= aim.deficit && complex.changed_since(mark).all(|t| complex.quality[t as usize] > aim.least)
    }

    /// The deficit that is left if every tet on the list comes to the floor.
    fn certain_deficit(&self, complex: &Complex) -> f64 {
        let is_valid = |&t: &u32, quality: u64| complex.is_alive(t) && key(complex.quality[t as usize]) == quality;
        let listed = self.heap.iter().filter(|Reverse((quality, t))| is_valid(t, *quality));
        complex.deficit() - listed.map(|Reverse((_, t))| complex.deficit_of(complex.quality[*t as usize])).sum::<f64>()
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
        self.treated += 1;
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
}
