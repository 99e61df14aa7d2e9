//! Follows moving points with the triangulation, by testing all of it and mending the little that has changed.
//!
//! - Y. Zhou, F. Sun, W. Wang, J. Wang, C. Zhang, *Fast updating of Delaunay triangulation of moving points by bi-cell
//!   filtering*, Computer Graphics Forum 29(7), 2010, doi 10.1111/j.1467-8659.2010.01812.x: move all, test orientations
//!   and bi-cells, flip what fails.
//! - C. L. Lawson, *Properties of n-dimensional triangulations*, Computer Aided Geometric Design 3(4), 1986,
//!   doi 10.1016/0167-8396(86)90001-4: the flips.
//!
//! 1. Move all vertices, and test every tet and its facets at once (`detect.rs`); what is not certain is suspect.
//! 2. Of the suspect tets, find those that are not positive, exactly. Hold vertices of theirs back at their old places
//!    until all tets are positive (`repair.rs`). The hull tells whether the tets then fill space once (`hull.rs`).
//! 3. Flip facets, from the suspect ones on, until all are Delaunay (`repair.rs`, `flip.rs`). The predicates are those of the
//!    construction, perturbation included, so the result is the one triangulation that there is.
//! 4. Bring the vertices held back home, each as far as its tets stay positive, and flip; again until all are home.
//! 5. Close gaps in the numbering; now and then bring the tets into the order of their vertices.
//!
//! Where 1 or 2 find that too much has changed, or 4 or 3 come to no end, what was done is taken back and the triangulation
//! built anew: also the way to name what is wrong with points that have none.
//!
//! Departures: no filter decides what to test, as testing in vectors costs less than a filter of a number per bi-cell; tets
//! that are turned around are mended, not cause to build anew; the hull moves like all else.
//!
//! Cost: about 12 ns a tet with AVX-512, and 1 to 2 µs a flip.

use std::time::Instant;

use glam::DVec3;

use super::detect::{Corner, corners, suspects};
use super::facet::INFINITE;
use super::flip::Mesh;
use super::range::hold;
use super::repair::{GivenUp, Lists};
use super::{Delaunay, DelaunayError, Facet};
use crate::geometry::predicates::Sign;

/// If more than one in so many tets is reversed, building anew is faster.
const REVERSED: usize = 250;

/// So many reversed tets are mended in any case.
const FEW: usize = 16;

/// So many suspects are mended in any case.
const MANY: usize = 64;

/// If more than one in so many tets is suspect, building anew is faster.
const SUSPECTS: usize = 4;

/// Tets are brought into order when one in so many has been made anew.
const DISORDER: usize = 4;

/// Tets made anew by a flip, most often.
const TETS_OF_A_FLIP: usize = 3;

/// What a call of [`Delaunay::relocate`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Relocation {
    /// Tets tested by the filter: all of them.
    pub tets: usize,
    /// Finite tets that it could not clear.
    pub suspects: usize,
    /// Facets that went on to the exact predicate.
    pub bicells_failed: usize,
    /// Exact predicates evaluated.
    pub predicates: usize,
    /// Vertices that failed a filter of vertices.
    pub vertices_failed: usize,
    /// Flips.
    pub flips: usize,
    /// Tets turned inside out, or flat, by the motion.
    pub reversed: usize,
    /// Vertices that went to their places in a second step.
    pub held_back: usize,
    /// Whether flips came to no end, so that the triangulation was built anew.
    pub stalled: bool,
    /// Whether the triangulation was built anew.
    pub rebuilt: bool,
    /// Time taken by its parts.
    pub seconds: Breakdown,
}

/// Seconds that the parts of an update took, by the names of Zhou et al. 2010.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Breakdown {
    /// Finding what may have changed.
    pub filter: f64,
    /// Exact predicates on that, before any flip.
    pub predicate: f64,
    /// Flips, and the tests of what they touch.
    pub flips: f64,
    /// Mending what flips alone cannot: reversed tets, and vertices that leave their place in the triangulation.
    pub repair: f64,
    /// Making ready for the next motion: renewal of the filter, gaps and order of the tets.
    pub renewal: f64,
    /// Building anew.
    pub build: f64,
}

impl Breakdown {
    /// The parts by name.
    pub fn parts(&self) -> [(&'static str, f64); 6] {
        let Breakdown { filter, predicate, flips, repair, renewal, build } = *self;
        [
            ("filter", filter),
            ("predicate", predicate),
            ("flips", flips),
            ("repair", repair),
            ("renewal", renewal),
            ("build", build),
        ]
    }

    /// Adds the times of a further update.
    pub fn add(&mut self, other: &Breakdown) {
        self.filter += other.filter;
        self.predicate += other.predicate;
        self.flips += other.flips;
        self.repair += other.repair;
        self.renewal += other.renewal;
        self.build += other.build;
    }
}

/// What is kept from one motion to the next.
#[derive(Clone, Default)]
pub struct Motion {
    pub mesh: Mesh,
    corners: Vec<Corner>,
    pub lists: Lists,
    /// Whether `mesh` fits the triangulation.
    ready: bool,
    /// Tets made anew since they were last brought into order.
    disorder: usize,
}

impl Motion {
    /// Fills what flips and edits need beside the tets, if it is not there; `mesh` holds points and tets.
    pub fn make_ready(&mut self) {
        if !std::mem::replace(&mut self.ready, true) {
            self.mesh.derive();
            self.disorder = 0;
        }
    }
}

impl Delaunay {
    /// Moves the points; the triangulation is then that of [`Delaunay::build`], tet for tet, if in another order.
    ///
    /// Any motion will do; one that is small against the distances of points is fast. On an error nothing has changed.
    pub fn relocate(&mut self, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        let (points, scale) = self.held(new_positions)?;
        let mut report = Relocation::default();
        if scale == self.scale && self.follow(&points, &mut report).is_ok() {
            self.points = points;
            return Ok(report);
        }
        self.build_anew(points, scale, &mut report)?;
        Ok(report)
    }

    /// As [`Delaunay::relocate`], by building anew.
    pub(super) fn rebuild(&mut self, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        let (points, scale) = self.held(new_positions)?;
        let mut report = Relocation::default();
        self.build_anew(points, scale, &mut report)?;
        Ok(report)
    }

    /// New positions as they are held, and their scale.
    pub(super) fn held(&self, new_positions: &[DVec3]) -> Result<(Vec<DVec3>, f64), DelaunayError> {
        let (count, expected) = (new_positions.len(), self.points.len());
        if count != expected {
            return Err(DelaunayError::WrongCount { count, expected });
        }
        if let Some(index) = new_positions.iter().position(|p| !p.is_finite()) {
            return Err(DelaunayError::NotFinite { index, point: new_positions[index].to_array() });
        }
        Ok(hold(new_positions))
    }

    /// Replaces all by the triangulation of `points`, which are held at `scale`.
    pub(super) fn build_anew(
        &mut self,
        points: Vec<DVec3>,
        scale: f64,
        report: &mut Relocation,
    ) -> Result<(), DelaunayError> {
        let clock = Instant::now();
        let (vertices, neighbors) = Delaunay::construct(&points)?;
        report.seconds.build += clock.elapsed().as_secs_f64();
        self.motion.ready = false;
        (self.points, self.scale, self.vertices, self.neighbors) = (points, scale, vertices, neighbors);
        report.rebuilt = true;
        Ok(())
    }

    /// Repairs the tets for new points. If that is given up, they are as they were.
    fn follow(&mut self, points: &[DVec3], report: &mut Relocation) -> Result<(), GivenUp> {
        let mesh = &mut self.motion.mesh;
        std::mem::swap(&mut mesh.vertices, &mut self.vertices);
        std::mem::swap(&mut mesh.neighbors, &mut self.neighbors);
        mesh.points.clear();
        mesh.points.extend_from_slice(points);
        self.motion.make_ready();
        let Motion { mesh, corners: at, lists, disorder, .. } = &mut self.motion;
        corners(points, at);
        mesh.begin();
        let result = mesh.follow(at, &self.points, lists, report);
        let clock = Instant::now();
        match result {
            Ok(()) => {
                mesh.compact();
                *disorder += TETS_OF_A_FLIP * report.flips;
                if *disorder * DISORDER > mesh.vertices.len() {
                    mesh.sort();
                    *disorder = 0;
                }
            }
            Err(GivenUp) => mesh.undo(),
        }
        report.seconds.renewal = clock.elapsed().as_secs_f64();
        std::mem::swap(&mut mesh.vertices, &mut self.vertices);
        std::mem::swap(&mut mesh.neighbors, &mut self.neighbors);
        result
    }
}

impl Mesh {
    /// Makes Delaunay again what was so when the vertices were at `old`.
    fn follow(
        &mut self,
        at: &[Corner],
        old: &[DVec3],
        lists: &mut Lists,
        report: &mut Relocation,
    ) -> Result<(), GivenUp> {
        let mut clock = Instant::now();
        let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        // 1. Suspects.
        let count = self.vertices.len();
        let suspects = suspects(at, &self.vertices, &self.opposite);
        let is_infinite = |&t: &u32| self.vertices[t as usize][3] == INFINITE;
        let infinite: Vec<u32> = suspects.iter().copied().filter(is_infinite).collect();
        report.tets = count;
        report.suspects = suspects.len() - infinite.len();
        report.seconds.filter = lap();
        if report.suspects > MANY + count / SUSPECTS {
            return Err(GivenUp);
        }
        // 2. Reversed tets.
        let mean = self.points.iter().fold(DVec3::ZERO, |sum, &p| sum + p) / self.points.len() as f64;
        self.inside = mean.map(super::range::flush);
        let is_reversed = |&t: &u32| self.orientation(self.vertices[t as usize]) != Sign::Positive;
        let reversed: Vec<u32> = suspects.iter().copied().filter(is_reversed).collect();
        report.reversed = reversed.len();
        report.predicates += suspects.len();
        if reversed.len() > FEW + count / REVERSED {
            return Err(GivenUp);
        }
        lists.clear(count);
        suspects.iter().for_each(|&t| lists.push(t));
        report.bicells_failed = 4 * report.suspects + 3 * infinite.len();
        report.seconds.predicate = lap();
        self.hold_back(&reversed, old, lists, report)?;
        if !self.fills_space_once(&infinite) {
            return Err(GivenUp);
        }
        report.seconds.repair = lap();
        // 3. Flips.
        self.flip_all(lists, report)?;
        report.seconds.flips = lap();
        // 4. Home.
        self.bring_home(lists, report)?;
        report.seconds.repair += lap();
        if self.is_stuck(lists) { Err(GivenUp) } else { Ok(()) }
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
