//! One motion: what may have changed, how that is found, and in what order it is mended.
//!
//! Whether certificates decide what is tested, all is tested, or all is built anew, is chosen by counts of tets that were
//! tested, of all or of a sample: by nothing that differs from run to run.

use std::time::Instant;

use glam::DVec3;

use super::certificate::NONE;
use super::detect::{LANES, suspects};
use super::facet::{Facet, INFINITE};
use super::flip::Mesh;
use super::hull::Guard;
use super::leaps::Leaps;
use super::relocate::Relocation;
use super::repair::{GivenUp, Lists};
use super::rows::certify;
use super::schedule::{Rash, Schedule, motions, stands_still};
use crate::geometry::predicates::Sign;

/// If more than one in so many tets is reversed, building anew is faster.
const REVERSED: usize = 64;

/// So many reversed tets are mended in any case.
const FEW: usize = 16;

/// So many suspects are mended in any case.
const MANY: usize = 64;

/// If more than one in so many tets is suspect, building anew is faster.
const SUSPECTS: usize = 8;

/// Tets are brought into order when one in so many has been made anew.
const DISORDER: usize = 4;

/// Tets made anew by a flip, most often.
const TETS_OF_A_FLIP: usize = 3;

/// A sample has one tet in so many.
const SAMPLE: usize = 128;

/// But not fewer than this.
const LEAST_SAMPLE: usize = 512;

/// As [`SUSPECTS`], of a sample.
const SUSPECTS_SHARE: f64 = 1.0 / SUSPECTS as f64;

/// A sample is believed where it is so many standard deviations off.
const DEVIATIONS: f64 = 4.0;

/// Certificates are taken if a smaller share of tets than this would be tested after each motion. What is due is scattered,
/// and takes two to four times as long to test as tets in a row; less where all tets stay in the cache of a core.
const WORTH_WHILE: f64 = 0.21;
const WORTH_WHILE_CACHED: f64 = 0.34;

/// So many tets stay there.
const CACHED: usize = 1 << 16;

/// So many motions go by before it is asked again, if it was just not worth while: to ask costs a tenth of a test of all.
const PATIENCE: f64 = 4.0;

/// If certificates of so many times more tets than are worth while have run out, all tets are tested, without.
const RUN_OUT: f64 = 1.4;

/// Tets that a thread certifies before they are planned.
const AT_ONCE: usize = 512;

/// What is tested after a motion.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// All tets.
    Nothing,
    /// Tets whose certificates have run out, where that is fewer by enough.
    Certificates,
}

/// What is kept from one motion to the next.
#[derive(Clone, Default)]
pub struct Motion {
    /// The triangulation; between motions without its tets, and with the positions before the last one.
    pub mesh: Mesh,
    /// Squared length of the step of each vertex, not less.
    steps2: Vec<f32>,
    schedule: Schedule,
    /// Whether `schedule` fits the triangulation.
    certified: bool,
    pub lists: Lists,
    leaps: Leaps,
    rash: Vec<Rash>,
    star: Vec<u32>,
    tested: Vec<u32>,
    certificates: Vec<f32>,
    /// Whether `mesh` fits the triangulation.
    pub ready: bool,
    /// Tets made anew since they were last brought into order.
    disorder: usize,
    /// Motions before it is asked again whether certificates are worth while.
    wait: u32,
}

impl Motion {
    /// Makes Delaunay again what was so when the vertices were at `old`, now that they are at `new`.
    pub fn follow(
        &mut self,
        old: &[DVec3],
        new: &[DVec3],
        filter: Filter,
        report: &mut Relocation,
    ) -> Result<(), GivenUp> {
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let mut longest = self.take(old, new);
        report.all_tets = self.mesh.vertices.len();
        self.leaps.find(&self.steps2);
        if !self.ready {
            if self.is_too_rough(0.0) {
                report.seconds.filter = lap();
                return Err(GivenUp);
            }
            self.make_ready();
            self.wait = 0;
        }
        self.leaps.keep_far(&self.mesh, old, &self.steps2);
        if !self.leaps.is_empty() {
            // Nothing is taken out before it is known to be worth while; a sample that errs is no reason to build anew.
            if self.is_too_rough(DEVIATIONS) {
                report.seconds.filter = lap();
                return Err(GivenUp);
            }
            longest = self.leaps.others_longest(&mut self.steps2);
        }
        report.seconds.filter = lap();
        self.mesh.begin();
        let mut result = self.leaps.take_out(&mut self.mesh, old, new);
        report.seconds.repair = lap();
        if result.is_ok() {
            result = self.find(old, longest, filter, report).and_then(|(suspects, guard)| {
                report.seconds.filter += lap();
                self.mesh.mend_all(&suspects, guard, old, &mut self.lists, report)
            });
        }
        lap();
        if result.is_ok() {
            result = self.leaps.put_in(&mut self.mesh);
            report.held_back += self.leaps.len();
            report.seconds.repair += lap();
        }
        match result {
            Ok(()) => self.finish(report),
            Err(GivenUp) => {
                self.mesh.undo();
                self.lists.forget();
                self.certified = false;
            }
        }
        report.seconds.renewal = lap();
        result
    }

    /// Fills what flips and edits need beside the tets, if it is not there; `mesh` holds points and tets. What is done to
    /// them then, certificates do not know of.
    pub fn make_ready(&mut self) {
        (self.certified, self.mesh.room) = (false, 0.0);
        if !std::mem::replace(&mut self.ready, true) {
            self.mesh.derive();
            self.disorder = 0;
        }
    }

    /// Takes the new positions. Returns the longest step.
    fn take(&mut self, old: &[DVec3], new: &[DVec3]) -> f64 {
        /// Room for rounding.
        const LONG: f64 = 1.0 + 1e-6;
        self.mesh.points.resize(new.len(), DVec3::ZERO);
        self.steps2.resize(new.len(), 0.0);
        let to = self.mesh.points.iter_mut().zip(&mut self.steps2);
        let mut longest2 = 0.0;
        for ((&new, &old), (point, step2)) in new.iter().zip(old).zip(to) {
            let squared = (new - old).length_squared() * LONG;
            longest2 = if squared > longest2 { squared } else { longest2 };
            // Too small for single precision is not yet zero.
            let least = if squared > 0.0 { f32::MIN_POSITIVE } else { 0.0 };
            let single = squared as f32;
            *step2 = if single > least { single } else { least };
            *point = new;
        }
        longest2.sqrt() * LONG
    }

    /// Finds the tets that may no longer be as they should, and whether the hull is sure to be a hull.
    fn find(
        &mut self,
        old: &[DVec3],
        longest: f64,
        filter: Filter,
        report: &mut Relocation,
    ) -> Result<(Vec<u32>, Guard), GivenUp> {
        let count = self.mesh.vertices.len();
        let worth_while = if count < CACHED { WORTH_WHILE_CACHED } else { WORTH_WHILE };
        let guard = self.mesh.guard(old, longest);
        if guard != Guard::Kept {
            // Certificates of the hull are for a point inside that is no longer the one.
            self.certified = false;
        }
        self.certified &= filter == Filter::Certificates && self.schedule.goes_on();
        if self.certified {
            self.find_due();
            if self.tested.len() as f64 <= RUN_OUT * worth_while * count as f64 {
                return Ok((self.test_due(report), guard));
            }
            self.certified = false;
        }
        let certify = filter == Filter::Certificates && guard != Guard::Lost && self.wait == 0;
        self.wait = self.wait.saturating_sub(1);
        if certify && count >= LEAST_SAMPLE {
            let tested = self.sample();
            if tested < worth_while {
                return Ok((self.test_all(report), guard));
            }
            // The more there would be to do, the later it is asked again.
            self.wait = (PATIENCE * tested / worth_while) as u32;
        }
        report.tets = count;
        let mut suspects = suspects(&self.mesh.points, &self.mesh.vertices, &self.mesh.opposite);
        if !self.leaps.is_empty() {
            suspects.retain(|&t| !self.mesh.is_dead(t));
        }
        Ok((suspects, guard))
    }

    /// Leaves the tets that are due in `tested`.
    fn find_due(&mut self) {
        self.schedule.advance(&self.steps2, &mut self.rash);
        // What vertices that leap have left behind.
        self.schedule.resize(self.mesh.vertices.len());
        self.mesh.written().for_each(|t| self.schedule.wake(t));
        for rash in &self.rash {
            self.mesh.star(rash.vertex, &mut self.star);
            for &t in &self.star {
                self.schedule.hasten(t, rash);
                let slot = self.mesh.vertices[t as usize].iter().position(|&w| w == rash.vertex);
                let slot = slot.expect("a tet of the star has its vertex: this is a bug in tetcvt");
                self.schedule.hasten(self.mesh.neighbors[t as usize][slot].tet(), rash);
            }
        }
        self.schedule.find_due(&mut self.tested);
    }

    /// Tests the tets that are due. Returns those that could not be cleared.
    fn test_due(&mut self, report: &mut Relocation) -> Vec<u32> {
        let Motion { mesh, steps2, schedule, tested, certificates, .. } = self;
        if !self.leaps.is_empty() {
            tested.retain(|&t| !mesh.is_dead(t));
        }
        report.tets = tested.len();
        let mut suspects = Vec::new();
        for tested in tested.chunks(AT_ONCE * rayon::current_num_threads()) {
            certify(mesh, tested, schedule.bounds(), certificates);
            for (&t, &certificate) in tested.iter().zip(&*certificates) {
                schedule.plan(t, certificate);
                let (tet, across) = (&mesh.vertices[t as usize], &mesh.opposite[t as usize]);
                if certificate == NONE && !stands_still(tet, across, steps2) {
                    suspects.push(t);
                }
            }
        }
        suspects
    }

    /// Tests all tets, and notes how far they may move. Returns those that could not be cleared.
    fn test_all(&mut self, report: &mut Relocation) -> Vec<u32> {
        let count = self.mesh.vertices.len();
        self.tested.clear();
        self.tested.extend(0..count as u32);
        self.schedule.start(count);
        self.certified = true;
        self.test_due(report)
    }

    /// Whether a few tets show that so much has changed that building anew is faster: to be found out before anything else
    /// is done if what is kept from one motion to the next is not there yet.
    ///
    /// Tets of vertices that leap are not asked, unless that is most of them. It must be so by as many standard `deviations`.
    fn is_too_rough(&mut self, deviations: f64) -> bool {
        self.choose_sample();
        let Mesh { vertices, neighbors, points, .. } = &self.mesh;
        let corners = |&t: &u32| vertices[t as usize];
        let apexes = |&t: &u32| neighbors[t as usize].map(|f| vertices[f.tet() as usize][f.slot()]);
        let leaps = |t: &u32| corners(t).iter().chain(&apexes(t)).any(|&v| self.leaps.contains(v));
        let resting: Vec<u32> = self.tested.iter().copied().filter(|t| !leaps(t)).collect();
        let sample = if 2 * resting.len() < self.tested.len() { &self.tested } else { &resting };
        let tets: Vec<[u32; 4]> = sample.iter().map(corners).collect();
        let opposite: Vec<[u32; 4]> = sample.iter().map(apexes).collect();
        let (most, count) = (SUSPECTS_SHARE + MANY as f64 / vertices.len() as f64, tets.len() as f64);
        suspects(points, &tets, &opposite).len() as f64 > most * count + deviations * (most * count).sqrt()
    }

    /// The share of tets that certificates would leave to be tested after each motion, judged by a few tets.
    fn sample(&mut self) -> f64 {
        self.choose_sample();
        self.schedule.set_bounds(&self.steps2);
        certify(&self.mesh, &self.tested, self.schedule.bounds(), &mut self.certificates);
        let share: f64 = self.certificates.iter().map(|&c| 1.0 / (1.0 + f64::from(motions(c)))).sum();
        share / self.tested.len().max(1) as f64
    }

    /// Leaves a few finite tets, from everywhere, in `tested`.
    fn choose_sample(&mut self) {
        let count = self.mesh.vertices.len();
        let stride = (count / LEAST_SAMPLE).clamp(1, SAMPLE) * LANES;
        let group = |start: usize| start as u32..count.min(start + LANES) as u32;
        self.tested.clear();
        self.tested.extend((0..count).step_by(stride).flat_map(group));
        self.tested.retain(|&t| self.mesh.vertices[t as usize][3] != INFINITE && !self.mesh.is_dead(t));
    }

    /// Makes ready for the next motion.
    fn finish(&mut self, report: &Relocation) {
        self.mesh.compact();
        if self.certified {
            self.schedule.resize(self.mesh.vertices.len());
            self.mesh.written().for_each(|t| self.schedule.wake(t));
        }
        self.disorder += TETS_OF_A_FLIP * report.flips + self.leaps.made();
        if self.disorder * DISORDER > self.mesh.vertices.len() {
            self.mesh.sort();
            (self.disorder, self.certified) = (0, false);
        }
    }
}

impl Mesh {
    /// Makes Delaunay again what may not be so at suspect tets.
    fn mend_all(
        &mut self,
        suspects: &[u32],
        guard: Guard,
        old: &[DVec3],
        lists: &mut Lists,
        report: &mut Relocation,
    ) -> Result<(), GivenUp> {
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let count = self.vertices.len();
        let is_infinite = |&t: &u32| self.vertices[t as usize][3] == INFINITE;
        let infinite: Vec<u32> = suspects.iter().copied().filter(is_infinite).collect();
        report.suspects = suspects.len() - infinite.len();
        if report.suspects > MANY + count / SUSPECTS {
            return Err(GivenUp);
        }
        // 2. Reversed tets.
        let is_reversed = |&t: &u32| self.orientation(self.vertices[t as usize]) != Sign::Positive;
        let reversed: Vec<u32> = suspects.iter().copied().filter(is_reversed).collect();
        report.reversed = reversed.len();
        report.predicates += suspects.len();
        if reversed.len() > FEW + count / REVERSED {
            return Err(GivenUp);
        }
        lists.begin();
        suspects.iter().for_each(|&t| lists.push(t));
        report.bicells_failed = 4 * report.suspects + 3 * infinite.len();
        report.seconds.predicate = lap();
        self.hold_back(&reversed, old, lists, report)?;
        if guard == Guard::Lost && !self.fills_space_once(&infinite) {
            return Err(GivenUp);
        }
        report.seconds.repair += lap();
        // 3. Flips.
        self.flip_all(lists, report)?;
        report.seconds.flips = lap();
        // 4. Home.
        self.bring_home(lists, report)?;
        let result = self.unstick(lists, report);
        report.seconds.repair += lap();
        result
    }

    /// Brings the tets into the order of their least vertices.
    fn sort(&mut self) {
        let least = |t: &[u32; 4]| t.iter().fold(u32::MAX, |m, &v| m.min(v)) as usize;
        let mut starts = vec![0u32; self.points.len() + 1];
        for tet in &self.vertices {
            starts[least(tet) + 1] += 1;
        }
        for v in 1..starts.len() {
            starts[v] += starts[v - 1];
        }
        let mut places = Vec::with_capacity(self.vertices.len());
        for tet in &self.vertices {
            let start = &mut starts[least(tet)];
            places.push(*start);
            *start += 1;
        }
        let mut vertices = vec![[0; 4]; places.len()];
        let mut neighbors = vec![[Facet::BLANK; 4]; places.len()];
        for (t, &place) in places.iter().enumerate() {
            vertices[place as usize] = self.vertices[t];
            neighbors[place as usize] = self.neighbors[t].map(|f| Facet::new(places[f.tet() as usize], f.slot()));
        }
        (self.vertices, self.neighbors) = (vertices, neighbors);
        self.derive();
    }
}
