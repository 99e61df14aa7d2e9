//! Follows moving points by the filter of bi-cells as it was printed.
//!
//! Y. Zhou, F. Sun, W. Wang, J. Wang, C. Zhang, *Fast updating of Delaunay triangulation of moving points by bi-cell
//! filtering*, Computer Graphics Forum 29(7), 2010, doi 10.1111/j.1467-8659.2010.01812.x. This is what `Delaunay::relocate` is
//! to be compared with, not what it does.
//!
//! 1. Move all vertices, and test the orientation of every tet. If one is reversed, build anew; as long as more than a tenth
//!    are, without a filter for the next motion.
//! 2. Test every bi-cell: it is cleared while its matrix is within its tolerance ω of that at its reference positions
//!    (`bicell_matrix.rs`). Both are stored with the bi-cell.
//! 3. Those that fail go to the exact predicate. If they pass, their reference and ω are renewed; else they are queued.
//! 4. Flip what is queued and not Delaunay, and queue what the flips touch (`repair.rs`); what they make gets its ω.
//!
//! Departures: ties are broken symbolically, and have ω = 0. Facets that wait for a flip in vain, of which the paper says
//! nothing, are cause to build anew. Infinite tets are oriented too, as seen from inside, and the hull must cover each
//! direction once (`hull.rs`): else a motion that turns it over would not be found out.

use std::fmt;
use std::time::Instant;

use glam::DVec3;

use super::bicell_matrix::{Rows, distance, of_plane, of_sphere, tolerance};
use super::facet::{Facet, INFINITE};
use super::flip::Mesh;
use super::region::Marks;
use super::relocate::Relocation;
use super::repair::{GivenUp, Lists};
use super::{Delaunay, DelaunayError};
use crate::geometry::predicates::Sign;

/// If more than one in so many tets is reversed, no filter is made.
const TETS_PER_REVERSED: usize = 10;

/// No bi-cell.
const NONE: u32 = u32::MAX;

/// A bi-cell.
#[derive(Clone)]
struct Bicell {
    /// Its vertices: of a tet, and the apex beyond. If one tet is infinite, the infinite vertex comes last.
    vertices: [u32; 5],
    /// Its facet, from one side.
    facet: Facet,
    /// Reference positions, relative to the first vertex.
    reference: [DVec3; 4],
    /// ω; infinite for a bi-cell that is no more.
    omega: f64,
}

/// What the filter keeps from one motion to the next.
#[derive(Clone, Default)]
pub struct BicellFilter {
    bicells: Vec<Bicell>,
    /// Numbers that are free.
    free: Vec<u32>,
    /// The bi-cell of each facet of each tet.
    of: Vec<[u32; 4]>,
    failed: Vec<u32>,
    changed: Vec<u32>,
    marks: Marks,
}

impl BicellFilter {
    /// Moves the points of a triangulation, as [`Delaunay::relocate`].
    pub fn relocate(&mut self, delaunay: &mut Delaunay, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        let (mut points, scale) = delaunay.held(new_positions)?;
        let mut report = Relocation::default();
        if scale == delaunay.scale {
            delaunay.lend_to_mesh();
            let (mesh, lists) = (&mut delaunay.motion.mesh, &mut delaunay.motion.lists);
            std::mem::swap(&mut mesh.points, &mut points);
            mesh.begin();
            lists.clear(mesh.vertices.len());
            let result = self.follow(mesh, lists, &mut points, &mut report);
            if result.is_err() {
                mesh.undo();
                std::mem::swap(&mut mesh.points, &mut points);
            }
            delaunay.take_from_mesh();
            if result.is_ok() {
                return Ok(report);
            }
        }
        // Bi-cells may have been renewed at places where the points, in case of an error, are not.
        self.bicells.clear();
        delaunay.build_anew(points, scale, &mut report)?;
        if report.reversed * TETS_PER_REVERSED <= delaunay.vertices.len() {
            let clock = Instant::now();
            delaunay.lend_to_mesh();
            self.renew_all(&delaunay.motion.mesh);
            delaunay.take_from_mesh();
            report.seconds.renewal += clock.elapsed().as_secs_f64();
        }
        Ok(report)
    }

    /// Makes the triangulation Delaunay again, which it was when the vertices were at `old`.
    fn follow(
        &mut self,
        mesh: &mut Mesh,
        lists: &mut Lists,
        old: &mut Vec<DVec3>,
        report: &mut Relocation,
    ) -> Result<(), GivenUp> {
        let mut clock = Instant::now();
        // 1. Orientation.
        report.tets = mesh.vertices.len();
        report.predicates += report.tets;
        let filled = count_reversed(mesh, report);
        report.seconds.predicate = lap(&mut clock);
        if !filled {
            return Err(GivenUp);
        }
        if self.bicells.is_empty() {
            std::mem::swap(&mut mesh.points, old);
            self.renew_all(mesh);
            std::mem::swap(&mut mesh.points, old);
            report.seconds.renewal = lap(&mut clock);
        }
        // 2. The filter.
        self.failed.clear();
        for (n, bicell) in self.bicells.iter().enumerate() {
            let now = bicell.matrix(&bicell.relative(&mesh.points));
            let then = bicell.matrix(&bicell.reference);
            if distance(&now, &then) >= bicell.omega {
                self.failed.push(n as u32);
            }
        }
        report.bicells_failed = self.failed.len();
        report.seconds.filter = lap(&mut clock);
        // 3. The predicate.
        report.predicates += self.failed.len();
        let is_delaunay = |&n: &u32| {
            let facet = self.bicells[n as usize].facet;
            let violates = mesh.violates(facet.tet(), facet.slot());
            if violates {
                lists.push(facet.tet());
            }
            !violates
        };
        self.failed.retain(is_delaunay);
        report.seconds.predicate += lap(&mut clock);
        for &n in &self.failed {
            self.bicells[n as usize].renew(&mesh.points);
        }
        report.seconds.renewal += lap(&mut clock);
        // 4. Flips.
        mesh.flip_all(lists, report)?;
        report.seconds.flips = lap(&mut clock);
        if mesh.is_stuck(lists) {
            report.stalled = true;
            return Err(GivenUp);
        }
        self.replace(mesh, &lists.made);
        mesh.compact_with(|from, to| self.moved(from, to));
        self.of.truncate(mesh.vertices.len());
        report.seconds.renewal += lap(&mut clock);
        Ok(())
    }

    /// Makes the bi-cells of all facets anew.
    fn renew_all(&mut self, mesh: &Mesh) {
        self.bicells.clear();
        self.free.clear();
        self.of.clear();
        self.of.resize(mesh.vertices.len(), [NONE; 4]);
        for t in 0..mesh.vertices.len() as u32 {
            self.add_bicells(mesh, t);
        }
    }

    /// Makes bi-cells for the facets of a tet that have none.
    fn add_bicells(&mut self, mesh: &Mesh, t: u32) {
        for i in 0..4 {
            if self.of[t as usize][i] != NONE {
                continue;
            }
            let bicell = Bicell::new(mesh, Facet::new(t, i));
            let n = match self.free.pop() {
                Some(n) => {
                    self.bicells[n as usize] = bicell;
                    n
                }
                None => {
                    self.bicells.push(bicell);
                    (self.bicells.len() - 1) as u32
                }
            };
            let across = mesh.neighbors[t as usize][i];
            self.of[t as usize][i] = n;
            self.of[across.tet() as usize][across.slot()] = n;
        }
    }

    /// Replaces the bi-cells of tets that flips have made or done away with.
    fn replace(&mut self, mesh: &Mesh, made: &[u32]) {
        self.marks.begin(mesh.vertices.len());
        self.changed.clear();
        let marks = &mut self.marks;
        self.changed.extend(made.iter().chain(&mesh.free).filter(|&&t| marks.insert(t)));
        let changed = std::mem::take(&mut self.changed);
        for &t in &changed {
            let Some(own) = self.of.get_mut(t as usize) else { continue };
            for n in std::mem::replace(own, [NONE; 4]) {
                let omega = &mut self.bicells[n as usize].omega;
                if std::mem::replace(omega, f64::INFINITY).is_finite() {
                    self.free.push(n);
                }
            }
        }
        self.of.resize(mesh.vertices.len(), [NONE; 4]);
        for &t in changed.iter().filter(|&&t| !mesh.is_dead(t)) {
            self.add_bicells(mesh, t);
        }
        self.changed = changed;
    }

    /// Follows a tet to another number.
    fn moved(&mut self, from: u32, to: u32) {
        let own = self.of[from as usize];
        self.of[to as usize] = own;
        for (i, n) in own.into_iter().enumerate() {
            let facet = &mut self.bicells[n as usize].facet;
            if *facet == Facet::new(from, i) {
                *facet = Facet::new(to, i);
            }
        }
    }
}

impl Bicell {
    /// Where the vertices are now.
    fn new(mesh: &Mesh, facet: Facet) -> Bicell {
        let (t, i) = (facet.tet() as usize, facet.slot());
        let ([a, b, c, d], q) = (mesh.vertices[t], mesh.opposite[t][i]);
        let vertices = if d == INFINITE { [a, b, c, q, d] } else { [a, b, c, d, q] };
        let mut bicell = Bicell { vertices, facet, reference: [DVec3::ZERO; 4], omega: 0.0 };
        bicell.renew(&mesh.points);
        bicell
    }

    fn renew(&mut self, points: &[DVec3]) {
        self.reference = self.relative(points);
        self.omega = tolerance(&self.matrix(&self.reference));
    }

    /// All vertices but the first, relative to it.
    fn relative(&self, points: &[DVec3]) -> [DVec3; 4] {
        let [first, others @ ..] = self.vertices;
        let origin = points[first as usize];
        others.map(|v| points.get(v as usize).map_or(DVec3::ZERO, |&p| p - origin))
    }

    fn matrix(&self, relative: &[DVec3; 4]) -> Rows {
        if self.vertices[4] == INFINITE {
            of_plane([relative[0], relative[1], relative[2]])
        } else {
            of_sphere(relative)
        }
    }
}

/// Counts the finite tets that are reversed or flat. Whether there are none, and the infinite ones cover all directions once.
fn count_reversed(mesh: &mut Mesh, report: &mut Relocation) -> bool {
    let sum = mesh.points.iter().fold(DVec3::ZERO, |sum, &p| sum + p);
    mesh.inside = (sum / mesh.points.len() as f64).map(super::range::flush);
    let mut infinite = Vec::new();
    let mut covered = true;
    for (t, &tet) in mesh.vertices.iter().enumerate() {
        let positive = mesh.orientation(tet) == Sign::Positive;
        if tet[3] == INFINITE {
            infinite.push(t as u32);
            covered &= positive;
        } else {
            report.reversed += usize::from(!positive);
        }
    }
    report.reversed == 0 && covered && mesh.fills_space_once(&infinite)
}

impl fmt::Debug for BicellFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BicellFilter {{ {} bi-cells }}", self.bicells.len())
    }
}

/// Seconds since the last lap.
fn lap(clock: &mut Instant) -> f64 {
    std::mem::replace(clock, Instant::now()).elapsed().as_secs_f64()
}
