//! Follows moving points with the triangulation, by testing all of it and mending the little that has changed.
//!
//! - Y. Zhou, F. Sun, W. Wang, J. Wang, C. Zhang, *Fast updating of Delaunay triangulation of moving points by bi-cell
//!   filtering*, Computer Graphics Forum 29(7), 2010, doi 10.1111/j.1467-8659.2010.01812.x: move all, test orientations
//!   and bi-cells, flip what fails.
//! - C. L. Lawson, *Properties of n-dimensional triangulations*, Computer Aided Geometric Design 3(4), 1986,
//!   doi 10.1016/0167-8396(86)90001-4: the flips.
//!
//! 0. A few vertices that go far while the others go little are taken out first, and put in at the end (`leaps.rs`).
//! 1. Move all vertices. Of tets that were tested before it is known how many motions they are good for if their vertices go no
//!    farther than is expected of each (`certificate.rs`, `schedule.rs`); or while much moves, all are due. Test
//!    those, and their facets at once; what is not certain is suspect (`detect.rs`, `motion.rs`).
//! 2. Of the suspect tets, find those that are not positive, exactly. Hold vertices of theirs back at their old places
//!    until all tets are positive (`repair.rs`). The hull tells whether the tets then fill space once (`hull.rs`).
//! 3. Flip facets, from the suspect ones on, until all are Delaunay (`repair.rs`, `flip.rs`). The predicates are those of the
//!    construction, perturbation included, so the result is the one triangulation that there is.
//! 4. Bring the vertices held back home, each as far as its tets stay positive, and flip; again until all are home, or put there.
//! 5. Close gaps in the numbering; now and then bring the tets into the order of their vertices.
//!
//! Where 1 or 2 find that too much has changed, or 4 or 3 come to no end, what was done is taken back and the triangulation
//! built anew: also the way to name what is wrong with points that have none.
//!
//! Departures: a certificate belongs to a tet, not to a bi-cell, and is a number of motions; most are not even looked at. Tets
//! that are turned around are mended, not cause to build anew; the hull moves like all else.
//!
//! Cost: about 12 ns a tet with AVX-512 where all are tested, two to three times that for one with a certificate, of which few
//! are tested; and 1 to 2 µs a flip. Kept for it, beside positions (twice) and tets: a vertex across each facet, a tet at
//! each vertex, and 6 bytes a tet and 12 a vertex for certificates.

use std::time::Instant;

use glam::DVec3;

use super::motion::Filter;
use super::range::{are_held_as_they_are, hold};
use super::repair::GivenUp;
use super::{Delaunay, DelaunayError};

/// What a call of [`Delaunay::relocate`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Relocation {
    /// Tets that there were, infinite ones included.
    pub all_tets: usize,
    /// Of these, those that were tested in floating point.
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

impl Delaunay {
    /// Moves the points; the triangulation is then that of [`Delaunay::build`], tet for tet, if in another order.
    ///
    /// Any motion will do; one that is small against the distances of points is fast. On an error nothing has changed.
    pub fn relocate(&mut self, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        self.relocate_with(Filter::Certificates, new_positions)
    }

    /// As [`Delaunay::relocate`], but with no certificates kept: every tet is tested after every motion.
    pub fn relocate_unfiltered(&mut self, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        self.relocate_with(Filter::Nothing, new_positions)
    }

    fn relocate_with(&mut self, filter: Filter, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        let mut report = Relocation::default();
        let held;
        let as_they_are =
            self.scale == 1.0 && new_positions.len() == self.points.len() && are_held_as_they_are(new_positions);
        let (points, scale) = if as_they_are {
            (new_positions, 1.0)
        } else {
            held = self.held(new_positions)?;
            (&held.0[..], held.1)
        };
        if scale == self.scale && self.follow(points, filter, &mut report).is_ok() {
            std::mem::swap(&mut self.points, &mut self.motion.mesh.points);
            return Ok(report);
        }
        self.build_anew(points.to_vec(), scale, &mut report)?;
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

    /// Repairs the tets for new points, which are then in `motion.mesh.points`. If that is given up, all is as it was.
    fn follow(&mut self, points: &[DVec3], filter: Filter, report: &mut Relocation) -> Result<(), GivenUp> {
        std::mem::swap(&mut self.motion.mesh.vertices, &mut self.vertices);
        std::mem::swap(&mut self.motion.mesh.neighbors, &mut self.neighbors);
        let result = self.motion.follow(&self.points, points, filter, report);
        std::mem::swap(&mut self.motion.mesh.vertices, &mut self.vertices);
        std::mem::swap(&mut self.motion.mesh.neighbors, &mut self.neighbors);
        result
    }
}
