//! Follows moving points with the triangulation.

use glam::DVec3;

use super::detect::{Corner, corners, suspects};
use super::facet::INFINITE;
use super::flip::Mesh;
use super::range::hold;
use super::repair::{GivenUp, Lists};
use super::{Delaunay, DelaunayError, Facet};
use crate::geometry::predicates::Sign;

/// If more than one in so many tets is reversed, building anew is faster.
const REVERSED: usize = 400;

/// So many reversed tets are mended in any case.
const FEW: usize = 16;

/// If more than one in so many tets is suspect, building anew is faster.
const SUSPECTS: usize = 4;

/// Tets are brought into order when one in so many has been made anew.
const DISORDER: usize = 4;

/// What a call of [`Delaunay::relocate`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Relocation {
    /// Tets tested by the filter: all of them.
    pub tets: usize,
    /// Finite tets that it could not clear.
    pub suspects: usize,
    /// Facets that went on to the exact predicate.
    pub bicells_failed: usize,
    /// Exact predicates evaluated.
    pub predicates: usize,
    /// Flips.
    pub flips: usize,
    /// Tets turned inside out, or flat, by the motion.
    pub reversed: usize,
    /// Vertices that went to their places in a second step.
    pub held_back: usize,
    /// Whether the triangulation was built anew.
    pub rebuilt: bool,
    /// Nanoseconds spent in the filter, and in all.
    pub nanoseconds: [u64; 4],
}

/// What is kept from one motion to the next.
#[derive(Clone, Default)]
pub struct Motion {
    mesh: Mesh,
    corners: Vec<Corner>,
    lists: Lists,
    /// Whether `mesh` fits the triangulation.
    ready: bool,
    /// Tets made anew since they were last brought into order.
    disorder: usize,
}

impl Delaunay {
    /// Moves the points; the triangulation is then that of [`Delaunay::build`], tet for tet, if in another order.
    ///
    /// Any motion will do; one that is small against the distances of points is fast. On an error nothing has changed.
    pub fn relocate(&mut self, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        let (count, expected) = (new_positions.len(), self.points.len());
        if count != expected {
            return Err(DelaunayError::WrongCount { count, expected });
        }
        if let Some(index) = new_positions.iter().position(|p| !p.is_finite()) {
            return Err(DelaunayError::NotFinite { index, point: new_positions[index].to_array() });
        }
        let (points, scale) = hold(new_positions);
        let mut report = Relocation::default();
        if scale == self.scale && self.follow(&points, &mut report).is_ok() {
            self.points = points;
            return Ok(report);
        }
        let (vertices, neighbors) = Delaunay::construct(&points)?;
        self.motion.ready = false;
        (self.points, self.scale, self.vertices, self.neighbors) = (points, scale, vertices, neighbors);
        report.rebuilt = true;
        Ok(report)
    }

    /// Repairs the tets for new points. If that is given up, they are as they were.
    fn follow(&mut self, points: &[DVec3], report: &mut Relocation) -> Result<(), GivenUp> {
        let Motion { mesh, corners: at, lists, ready, disorder } = &mut self.motion;
        std::mem::swap(&mut mesh.vertices, &mut self.vertices);
        std::mem::swap(&mut mesh.neighbors, &mut self.neighbors);
        mesh.points.clear();
        mesh.points.extend_from_slice(points);
        if !std::mem::replace(ready, true) {
            mesh.derive();
            *disorder = 0;
        }
        corners(points, at);
        mesh.begin();
        let result = mesh.follow(at, &self.points, lists, report);
        if result.is_err() {
            mesh.undo();
        } else {
            mesh.compact();
            *disorder += 3 * report.flips;
            if *disorder * DISORDER > mesh.vertices.len() {
                mesh.sort();
                *disorder = 0;
            }
        }
        std::mem::swap(&mut mesh.vertices, &mut self.vertices);
        std::mem::swap(&mut mesh.neighbors, &mut self.neighbors);
        result
    }
}

impl Mesh {
    fn follow(
        &mut self,
        at: &[Corner],
        old: &[DVec3],
        lists: &mut Lists,
        report: &mut Relocation,
    ) -> Result<(), GivenUp> {
        let clock = std::time::Instant::now();
        let count = self.vertices.len();
        let suspects = suspects(at, &self.vertices, &self.opposite);
        report.nanoseconds[0] = clock.elapsed().as_nanos() as u64;
        let infinite: Vec<u32> =
            suspects.iter().copied().filter(|&t| self.vertices[t as usize][3] == INFINITE).collect();
        report.tets = count;
        report.suspects = suspects.len() - infinite.len();
        if report.suspects > 4 * FEW + count / SUSPECTS {
            return Err(GivenUp);
        }
        let mean = self.points.iter().fold(DVec3::ZERO, |sum, &p| sum + p) / self.points.len() as f64;
        self.inside = mean.map(super::range::flush);
        let reversed: Vec<u32> = suspects
            .iter()
            .copied()
            .filter(|&t| self.orientation(self.vertices[t as usize]) != Sign::Positive)
            .collect();
        report.reversed = reversed.len();
        report.predicates += suspects.len();
        if reversed.len() > FEW + count / REVERSED {
            return Err(GivenUp);
        }
        lists.clear(count);
        suspects.iter().for_each(|&t| lists.push(t));
        report.bicells_failed = 4 * report.suspects + 3 * infinite.len();
        self.hold_back(&reversed, old, lists, report)?;
        report.nanoseconds[1] = clock.elapsed().as_nanos() as u64;
        if !self.fills_space_once(&infinite) {
            return Err(GivenUp);
        }
        self.flip_all(lists, report);
        report.nanoseconds[2] = clock.elapsed().as_nanos() as u64;
        self.bring_home(lists, report)?;
        report.nanoseconds[3] = clock.elapsed().as_nanos() as u64;
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
