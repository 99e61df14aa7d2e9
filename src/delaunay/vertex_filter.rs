//! Follows moving points by a filter of vertices: those that stay near where they were need not be looked at.
//!
//! P. M. M. de Castro, J. Tournois, P. Alliez, O. Devillers, *Filtering relocations on a Delaunay triangulation*, Computer
//! Graphics Forum 28(5), 2009, doi 10.1111/j.1467-8659.2009.01523.x.
//!
//! The triangulation is that of reference positions. Each vertex has a tolerance, the least of those of its bi-cells
//! (`tolerance.rs`): while all are within their tolerances from their references, moving all from there to where they are
//! changes no predicate on the way, and the triangulation of the references is that of the points.
//!
//! 1. Queue every vertex that is out of its tolerance.
//! 2. Take one from the queue, and relocate it: its reference is where it is now. If its star stays positive there, move it in
//!    place and flip what is no longer Delaunay; else remove it, and insert it again nearby.
//! 3. The bi-cells that are new or whose vertex moved give tolerances anew: its own is their least, and others may fall.
//!    What is then out of its tolerance joins the queue. Until the queue is empty.
//!
//! Where too many fail for that to be worth it, all is built anew, as the paper does in the first iterations (if most fail,
//! without a filter for the next few motions); and where points meet references of others on the way. A tie has no tolerance: who is part of one and moves is relocated.
//!
//! Departures: the tolerance of a bi-cell; a vertex of the hull is never moved in place; a vertex that is relocated does
//! not raise the tolerances of others, which costs them a look later on.

use std::fmt;
use std::time::Instant;

use glam::DVec3;

use super::facet::INFINITE;
use super::flip::Mesh;
use super::region::{Marks, Region};
use super::relocate::Relocation;
use super::repair::{GivenUp, Lists};
use super::tolerance::Quad;
use super::{Delaunay, DelaunayError};
use crate::geometry::predicates::Sign;

/// With more than one vertex in so many to be relocated, building anew is faster.
const VERTICES_PER_RELOCATION: usize = 5;

/// So many vertices are relocated in any case.
const FEW: usize = 64;

/// As long as more than one vertex in so many fails, the filter is tried less and less often.
const VERTICES_PER_FAILURE: usize = 2;

/// The most motions in a row without a filter.
const LONGEST_PAUSE: u32 = 8;

/// What the filter keeps from one motion to the next.
#[derive(Clone, Default)]
pub struct VertexFilter {
    /// Positions of the vertices of which the tets are the triangulation.
    references: Vec<DVec3>,
    /// How far from there each may be.
    tolerances: Vec<f64>,
    queue: Vec<u32>,
    queued: Vec<bool>,
    /// Vertices that were relocated, and their references before.
    relocated: Vec<(u32, DVec3)>,
    region: Region,
    /// Tets with bi-cells that are new.
    fresh: Vec<u32>,
    marks: Marks,
    /// Motions that are to go without a filter, and how many at a time.
    pause: u32,
    pauses: u32,
}

impl VertexFilter {
    /// Moves the points of a triangulation, as [`Delaunay::relocate`].
    pub fn relocate(&mut self, delaunay: &mut Delaunay, new_positions: &[DVec3]) -> Result<Relocation, DelaunayError> {
        let (points, scale) = delaunay.held(new_positions)?;
        let mut report = Relocation::default();
        let mut clock = Instant::now();
        if self.pause > 0 {
            delaunay.build_anew(points, scale, &mut report)?;
            self.pause -= 1;
            self.references.clear();
            return Ok(report);
        }
        if self.references.is_empty() {
            self.renew_all(delaunay);
            report.seconds.renewal = lap(&mut clock);
        }
        if scale == delaunay.scale {
            self.start(&points);
            report.vertices_failed = self.queue.len();
            report.seconds.filter = lap(&mut clock);
            if self.queue.len() <= self.most() && self.follow(delaunay, &points, &mut report).is_ok() {
                delaunay.points = points;
                return Ok(report);
            }
        }
        delaunay.build_anew(points, scale, &mut report)?;
        if report.vertices_failed * VERTICES_PER_FAILURE > self.references.len() {
            self.pauses = (2 * self.pauses).clamp(1, LONGEST_PAUSE);
            self.pause = self.pauses;
            self.references.clear();
        } else {
            self.pauses = 0;
            let mut clock = Instant::now();
            self.renew_all(delaunay);
            report.seconds.renewal += lap(&mut clock);
        }
        Ok(report)
    }

    /// How many vertices are relocated at most.
    fn most(&self) -> usize {
        FEW + self.references.len() / VERTICES_PER_RELOCATION
    }

    /// 1. Queues the vertices out of their tolerance.
    fn start(&mut self, points: &[DVec3]) {
        self.queue.clear();
        self.queued.clear();
        self.queued.resize(points.len(), false);
        for v in 0..points.len() {
            if self.is_out(v as u32, points) {
                self.queued[v] = true;
                self.queue.push(v as u32);
            }
        }
    }

    /// Whether a vertex is out of its tolerance.
    fn is_out(&self, v: u32, points: &[DVec3]) -> bool {
        let (reference, tolerance) = (self.references[v as usize], self.tolerances[v as usize]);
        let p = points[v as usize];
        // Not to move at all is within a tolerance of zero.
        p.distance_squared(reference) >= tolerance * tolerance && p != reference
    }

    /// Relocates what is queued, and what that makes fail. If that is given up, all is as it was.
    fn follow(&mut self, delaunay: &mut Delaunay, points: &[DVec3], report: &mut Relocation) -> Result<(), GivenUp> {
        self.relocated.clear();
        delaunay.lend_to_mesh();
        let mesh = &mut delaunay.motion.mesh;
        let lists = &mut delaunay.motion.lists;
        std::mem::swap(&mut mesh.points, &mut self.references);
        mesh.begin();
        lists.clear(mesh.vertices.len());
        let mut done = 0;
        let mut result = Ok(());
        while done < self.queue.len() && result.is_ok() {
            let v = self.queue[done];
            done += 1;
            result = if done > self.most() { Err(GivenUp) } else { self.relocate_one(v, mesh, lists, points, report) };
        }
        report.vertices_failed = self.queue.len();
        let clock = Instant::now();
        if result.is_ok() {
            mesh.compact();
        } else {
            mesh.undo();
            while let Some((v, reference)) = self.relocated.pop() {
                mesh.points[v as usize] = reference;
                self.tolerances[v as usize] = 0.0;
            }
        }
        report.seconds.renewal += clock.elapsed().as_secs_f64();
        std::mem::swap(&mut mesh.points, &mut self.references);
        delaunay.take_from_mesh();
        result
    }

    /// 2. and 3. for one vertex. While a motion is followed, the references are the points of the mesh.
    fn relocate_one(
        &mut self,
        v: u32,
        mesh: &mut Mesh,
        lists: &mut Lists,
        points: &[DVec3],
        report: &mut Relocation,
    ) -> Result<(), GivenUp> {
        let mut clock = Instant::now();
        self.relocated.push((v, mesh.at(v)));
        let goal = points[v as usize];
        mesh.star_of(v, &mut self.region);
        self.fresh.clear();
        let stays = self.moves_in_place(v, goal, mesh);
        report.predicates += self.region.old.len();
        report.seconds.predicate += lap(&mut clock);
        if stays {
            self.region.old.iter().for_each(|&t| lists.push(t));
            report.bicells_failed += self.region.old.len() * 5 / 2;
            lists.made.clear();
            let before = report.flips;
            mesh.inside = goal;
            mesh.flip_all(lists, report)?;
            if mesh.is_stuck(lists) {
                return Err(GivenUp);
            }
            lists.forget_stuck();
            self.fresh.append(&mut lists.made);
            if report.flips == before {
                self.fresh.extend_from_slice(&self.region.old);
            } else {
                mesh.star_of(v, &mut self.region);
                self.fresh.extend_from_slice(&self.region.old);
            }
            report.seconds.flips += lap(&mut clock);
        } else {
            mesh.remove_vertex(v, &mut self.region).map_err(|_| GivenUp)?;
            self.fresh.extend_from_slice(&self.region.ids);
            mesh.points[v as usize] = goal;
            mesh.insert_vertex(v, self.fresh[0], &mut self.region).map_err(|_| GivenUp)?;
            self.fresh.extend_from_slice(&self.region.ids);
            report.held_back += 1;
            report.seconds.repair += lap(&mut clock);
        }
        self.renew(v, mesh, points);
        report.seconds.renewal += lap(&mut clock);
        Ok(())
    }

    /// Moves a vertex that is not on the hull, with its star as it is, if all of it stays positive.
    fn moves_in_place(&self, v: u32, goal: DVec3, mesh: &mut Mesh) -> bool {
        let star = &self.region.old;
        if star.iter().any(|&t| mesh.vertices[t as usize][3] == INFINITE) {
            return false;
        }
        let start = std::mem::replace(&mut mesh.points[v as usize], goal);
        let stays = star.iter().all(|&t| mesh.orientation(mesh.vertices[t as usize]) == Sign::Positive);
        if !stays {
            mesh.points[v as usize] = start;
        }
        stays
    }

    /// 3. Tolerances of the bi-cells of `fresh`; the vertices of these may fail, and are queued.
    fn renew(&mut self, v: u32, mesh: &Mesh, points: &[DVec3]) {
        self.tolerances[v as usize] = f64::INFINITY;
        self.marks.begin(mesh.vertices.len());
        let mut fresh = std::mem::take(&mut self.fresh);
        fresh.retain(|&t| !mesh.is_dead(t) && self.marks.insert(t));
        for &t in &fresh {
            let twice = |i: usize| {
                let n = mesh.neighbors[t as usize][i].tet();
                n < t && self.marks.contains(n)
            };
            let once = [0, 1, 2, 3].map(|i| !twice(i));
            let (tolerances, queue, queued) = (&mut self.tolerances, &mut self.queue, &mut self.queued);
            each_tolerance(mesh, t, once, &mut |w, tolerance| {
                let own = &mut tolerances[w as usize];
                if tolerance < *own {
                    *own = tolerance;
                    let (p, reference) = (points[w as usize], mesh.at(w));
                    let out = p.distance_squared(reference) >= tolerance * tolerance && p != reference;
                    if out && !std::mem::replace(&mut queued[w as usize], true) {
                        queue.push(w);
                    }
                }
            });
        }
        self.fresh = fresh;
    }

    /// The tolerances of all vertices where they are.
    fn renew_all(&mut self, delaunay: &mut Delaunay) {
        self.references.clone_from(&delaunay.points);
        self.tolerances.clear();
        self.tolerances.resize(self.references.len(), f64::INFINITY);
        delaunay.lend_to_mesh();
        let mesh = &delaunay.motion.mesh;
        for t in 0..mesh.vertices.len() as u32 {
            let once = mesh.neighbors[t as usize].map(|f| t < f.tet());
            each_tolerance(mesh, t, once, &mut |w, tolerance| {
                let own = &mut self.tolerances[w as usize];
                *own = if tolerance < *own { tolerance } else { *own };
            });
        }
        delaunay.take_from_mesh();
    }
}

/// Tells each vertex of the bi-cells of tet `t`, of the facets that are `wanted`, their tolerance.
fn each_tolerance(mesh: &Mesh, t: u32, wanted: [bool; 4], tell: &mut impl FnMut(u32, f64)) {
    let tet = mesh.vertices[t as usize];
    let apexes = mesh.opposite[t as usize];
    let is_infinite = tet[3] == INFINITE;
    if is_infinite {
        for i in (0..4).filter(|&i| wanted[i]) {
            // Across facet 3 lies the finite tet, along the hull another infinite one.
            let four = [tet[0], tet[1], tet[2], apexes[i]];
            let tolerance = Quad::new(four.map(|w| mesh.at(w))).of_plane();
            four.into_iter().for_each(|w| tell(w, tolerance));
        }
        return;
    }
    let quad = Quad::new(tet.map(|w| mesh.at(w)));
    let sphere = quad.sphere();
    for i in (0..4).filter(|&i| wanted[i]) {
        let q = apexes[i];
        if q == INFINITE {
            let tolerance = quad.of_plane();
            tet.into_iter().for_each(|w| tell(w, tolerance));
        } else {
            let tolerance = sphere.of(mesh.at(q));
            tet.into_iter().chain([q]).for_each(|w| tell(w, tolerance));
        }
    }
}

impl fmt::Debug for VertexFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VertexFilter {{ {} vertices }}", self.references.len())
    }
}

/// Seconds since the last lap.
fn lap(clock: &mut Instant) -> f64 {
    std::mem::replace(clock, Instant::now()).elapsed().as_secs_f64()
}
