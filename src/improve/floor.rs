//! Brings every tet to the floor: worst first, by whatever single operation makes the worst of the tets involved better.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::change::Change;
use super::complex::{Complex, Mark, Part};
use super::faces::remove_faces;
use super::flips::remove_edge;
use super::ground::Ground;
use super::hopeless::Hopeless;
use super::parts;
use super::smooth::{Smoother, least_gain};
use crate::geometry::tetrahedron::EDGES;

/// Tets treated in one go over all that are below the floor, for each of them and beside: the rest is crawl.
const TREATED_EACH: usize = 12;
const TREATED_LEAST: usize = 2000;

/// So many tets below the floor are worth a part of the mesh of their own.
const LOW_EACH: usize = 1000;

/// Whether the aim is reached is asked each time that so many tets were treated: those still on the list have their turn later.
const JUDGED_EVERY: usize = 4;

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

impl Aim {
    /// Whether what changed since `mark` has come to it.
    fn is_reached(self, complex: &Complex, mark: Mark) -> bool {
        complex.deficit() <= self.deficit
            && complex.changed_since(mark).all(|t| complex.quality[t as usize] > self.least)
    }
}

/// The tets below the floor, worst first, and the buffers of the operations.
#[derive(Default)]
pub(super) struct Worklist {
    heap: BinaryHeap<Reverse<(u64, u32)>>,
    /// The key that each tet is on the list with, by slot; 0 where it is not.
    listed: Vec<u64>,
    best: Change,
    trial: Change,
    smoother: Smoother,
    near: Vec<u32>,
    /// Whether no vertex may be made or taken out, be it that the count comes out right.
    pub(super) keeps_vertices: bool,
    /// The share of what a tet lacks to the floor that an operation must gain: a crawl costs more than it brings, and while others can
    /// still be helped by larger strides it keeps these from it.
    pub(super) haste: f64,
    /// Whether the boundary is to follow the surface.
    pub(super) follows: bool,
    hopeless: Hopeless,
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

    /// Works off all tets below the floor, but for those that nothing helped before and at whose vertices nothing changed since.
    /// Not beyond `last` tets treated in all.
    pub(super) fn run(&mut self, complex: &mut Complex, ground: &Ground, last: usize) {
        let low: Vec<u32> = complex.low().filter(|&t| !self.hopeless.has(complex, t)).collect();
        let until = last.min(self.most).min(self.treated + TREATED_LEAST + TREATED_EACH * low.len());
        self.run_parts(complex, ground, (&low, until));
        self.clear();
        complex.low().for_each(|t| self.push(complex, t));
        while let Some(t) = self.next(complex) {
            if self.treated >= until {
                break;
            }
            if self.hopeless.has(complex, t) {
                continue;
            }
            if self.treat(complex, ground, t) {
                complex.commit();
            } else {
                self.hopeless.add(complex, t);
            }
        }
    }

    /// The same in parts of the mesh, where that is worth the while.
    fn run_parts(&mut self, complex: &mut Complex, ground: &Ground, (low, until): (&[u32], usize)) {
        let left = until.saturating_sub(self.treated);
        let work = |part: &mut Part, whole: &Complex, share: f64| {
            let mut work = self.of_part((share * left as f64) as usize);
            let known = (0..).zip(&part.tets).filter(|(_, t)| self.hopeless.has(whole, **t));
            known.for_each(|(t, _)| work.hopeless.add(&part.complex, t));
            work.run(&mut part.complex, ground, usize::MAX);
            (work.treated, part.complex.low().filter(|&t| work.hopeless.has(&part.complex, t)).collect())
        };
        let Some(done) = parts::work(complex, (low, LOW_EACH), work) else { return };
        self.treated += done.of_parts.into_iter().sum::<usize>();
        done.hopeless.into_iter().for_each(|t| self.hopeless.add(complex, t));
    }

    /// A list for a part of the mesh, the same in kind.
    pub(super) fn of_part(&self, most: usize) -> Worklist {
        let &Worklist { keeps_vertices, haste, follows, .. } = self;
        Worklist { keeps_vertices, haste, follows, ..Worklist::new(most) }
    }

    /// Notes work that was done by lists of parts.
    pub(super) fn add_treated(&mut self, treated: usize) {
        self.treated += treated;
    }

    /// Lets every tet be tried again: what stands in their way has changed.
    pub(super) fn forget(&mut self) {
        self.hopeless.clear();
        self.smoother.forget();
    }

    fn push(&mut self, complex: &Complex, t: u32) {
        let quality = complex.quality[t as usize];
        if quality >= complex.floor() {
            return;
        }
        let key = key(quality);
        self.listed.resize(complex.tets.len().max(self.listed.len()), 0);
        if std::mem::replace(&mut self.listed[t as usize], key) != key {
            self.heap.push(Reverse((key, t)));
        }
    }

    /// Empties the list.
    fn clear(&mut self) {
        self.heap.drain().for_each(|Reverse((_, t))| self.listed[t as usize] = 0);
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

    /// Makes what changed since `mark` the list, and works off as much of it as the aim takes, without a commit. Whether that was reached;
    /// the first tet that is too bad and cannot be helped ends the work, and so do those that leave too large a deficit.
    pub(super) fn work_since(&mut self, complex: &mut Complex, ground: &Ground, mark: Mark, aim: Aim) -> bool {
        self.clear();
        self.near.clear();
        for t in complex.changed_since(mark) {
            self.near.extend(complex.tets[t as usize]);
        }
        self.push_around(complex);
        for treated in 0..aim.treated {
            if (treated + 1).is_multiple_of(JUDGED_EVERY) && aim.is_reached(complex, mark) {
                return true;
            }
            let Some(t) = self.next(complex) else { break };
            if !self.treat(complex, ground, t)
                && (complex.quality[t as usize] <= aim.least || self.certain_deficit(complex) > aim.deficit)
            {
                return false;
            }
        }
        aim.is_reached(complex, mark)
    }

    /// The deficit that is left if every tet on the list comes to the floor.
    fn certain_deficit(&self, complex: &Complex) -> f64 {
        let listed = self.heap.iter().filter(|Reverse((key, t))| self.is_listed(complex, *key, *t));
        complex.deficit() - listed.map(|Reverse((_, t))| complex.deficit_of(complex.quality[*t as usize])).sum::<f64>()
    }

    /// The worst tet of the list.
    fn next(&mut self, complex: &Complex) -> Option<u32> {
        loop {
            let Reverse((key, t)) = self.heap.pop()?;
            if self.is_listed(complex, key, t) {
                self.listed[t as usize] = 0;
                return Some(t);
            }
        }
    }

    /// Whether an entry of the heap still says what is.
    fn is_listed(&self, complex: &Complex, listed: u64, t: u32) -> bool {
        self.listed[t as usize] == listed && complex.is_alive(t) && key(complex.quality[t as usize]) == listed
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
        least += least_gain(least, complex.floor(), self.haste);
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
            if self.smoother.raise_worst(complex, ground, v, self.haste) {
                moved = true;
                for &t in complex.star(v) {
                    self.near.extend(complex.tets[t as usize]);
                }
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::super::complex::tests::{on_grid, shake};
    use super::*;

    #[test]
    fn in_haste_flips_are_made_for_a_large_gain_alone() {
        on_grid(|mut complex, ground| {
            shake(&mut complex, 0.05);
            complex.set_floor(1.2);
            let [patient, hasty] = [0.0, 0.3].map(|haste| {
                let mut work = Worklist { haste, ..Worklist::default() };
                let mut made = 0;
                for t in 0..complex.tets.len() as u32 {
                    let (mark, before) = (complex.mark(), complex.quality[t as usize]);
                    if work.flip(&mut complex, ground, t) {
                        made += 1;
                        let least = before + haste * (complex.floor() - before);
                        assert!(complex.changed_since(mark).all(|t| complex.quality[t as usize] > least), "tet {t}");
                    }
                    complex.rollback(mark);
                }
                made
            });
            assert!(0 < hasty && hasty < patient, "{hasty} of {patient} flips were made in haste");
        });
    }
}
