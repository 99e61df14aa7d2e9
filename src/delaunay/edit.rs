//! Adds points to a triangulation, and takes points out of it.
//!
//! Between edits the triangulation is at rest, its tets numbered without gaps. An edit borrows the arrays for the time that it
//! takes, and fills the few gaps that it leaves: nothing is copied, so the cost does not depend on the number of points. Only
//! what flips and edits need beside (`Mesh::derive`) is filled in by the first of them.

use glam::DVec3;

use super::facet::{Facet, INFINITE};
use super::range::{flush, holds_scale, may_join};
use super::region::Region;
use super::remove_vertex::{Kept, slot_of};
use super::{Delaunay, DelaunayError};

/// What edits keep from one to the next.
#[derive(Clone, Default)]
pub struct Edits {
    region: Region,
    /// A tet near the last edit.
    near: u32,
}

impl Delaunay {
    /// Adds a point; returns its index, which is one more than the last. The triangulation is then that of
    /// [`Delaunay::build`] of all points, tet for tet, if in another order.
    ///
    /// The search for its place begins at the last edit: fast if points come one near another. On an error nothing has
    /// changed.
    pub fn insert(&mut self, point: DVec3) -> Result<u32, DelaunayError> {
        let near = (self.edits.near as usize).min(self.vertices.len() - 1);
        self.insert_from(point, near as u32)
    }

    /// As [`Delaunay::insert`]; the search begins at a vertex, which should be near.
    pub fn insert_near(&mut self, point: DVec3, vertex: u32) -> Result<u32, DelaunayError> {
        self.check_vertex(vertex)?;
        self.lend_to_mesh();
        let near = self.motion.mesh.incident[vertex as usize];
        self.take_from_mesh();
        self.insert_from(point, near)
    }

    /// Takes a point out; the last one gets its index, as with [`Vec::swap_remove`]. The triangulation is then that of
    /// [`Delaunay::build`] of the points left, tet for tet, if in another order.
    ///
    /// On an error, among them that the points left lie on a plane, nothing has changed.
    pub fn remove(&mut self, vertex: u32) -> Result<(), DelaunayError> {
        self.check_vertex(vertex)?;
        let v = vertex as usize;
        let count = self.points.len() - 1;
        if count < 4 {
            return Err(DelaunayError::TooFew { count });
        }
        let others = || self.points.iter().enumerate().filter(|&(w, _)| w != v).map(|(_, &p)| p);
        if self.scale != 1.0 || !others().any(holds_scale) {
            // How points are held depends on the largest of them.
            let mut points = self.given();
            points.swap_remove(v);
            return self.replace_all(&points);
        }
        self.lend_to_mesh();
        let (mesh, edits) = (&mut self.motion.mesh, &mut self.edits);
        mesh.begin();
        let removed = mesh.remove_vertex(vertex, &mut edits.region);
        if removed.is_ok() {
            edits.near = edits.region.ids[0];
            mesh.rename_last(vertex, &mut edits.region);
            mesh.compact();
        }
        self.take_from_mesh();
        match removed {
            Ok(()) => Ok(()),
            Err(Kept::AllFlat) => Err(DelaunayError::Flat { count }),
            Err(Kept::Torn) => unreachable!("the link is among its own Delaunay facets: this is a bug in tetcvt"),
        }
    }

    fn insert_from(&mut self, point: DVec3, near: u32) -> Result<u32, DelaunayError> {
        let index = self.points.len();
        if !point.is_finite() {
            return Err(DelaunayError::NotFinite { index, point: point.to_array() });
        }
        if index + 1 >= Facet::MAX_TETS {
            return Err(DelaunayError::TooMany { count: index + 1 });
        }
        if self.scale != 1.0 || !may_join(point) {
            let mut points = self.given();
            points.push(point);
            return self.replace_all(&points).map(|()| index as u32);
        }
        self.lend_to_mesh();
        let (mesh, edits) = (&mut self.motion.mesh, &mut self.edits);
        mesh.begin();
        mesh.points.push(point.map(flush));
        mesh.incident.push(near);
        let inserted = mesh.insert_vertex(index as u32, near, &mut edits.region);
        match inserted {
            Ok(()) => {
                edits.near = edits.region.ids[0];
                mesh.compact();
            }
            Err(_) => {
                mesh.points.pop();
                mesh.incident.pop();
            }
        }
        self.take_from_mesh();
        match inserted {
            Ok(()) => Ok(index as u32),
            Err(at) => Err(DelaunayError::Duplicates {
                count: 1,
                first: at as usize,
                second: index,
                point: self.points[at as usize].to_array(),
            }),
        }
    }

    fn check_vertex(&self, vertex: u32) -> Result<(), DelaunayError> {
        let count = self.points.len();
        if (vertex as usize) < count { Ok(()) } else { Err(DelaunayError::NoSuchPoint { index: vertex, count }) }
    }

    /// The points before they were scaled.
    fn given(&self) -> Vec<DVec3> {
        self.points.iter().map(|&p| p / self.scale).collect()
    }

    fn replace_all(&mut self, points: &[DVec3]) -> Result<(), DelaunayError> {
        *self = Delaunay::build(points)?;
        Ok(())
    }

    /// Hands points and tets to the mesh, with all that it needs of them.
    pub(super) fn lend_to_mesh(&mut self) {
        let motion = &mut self.motion;
        std::mem::swap(&mut motion.mesh.points, &mut self.points);
        std::mem::swap(&mut motion.mesh.vertices, &mut self.vertices);
        std::mem::swap(&mut motion.mesh.neighbors, &mut self.neighbors);
        motion.make_ready();
    }

    /// Takes them back.
    pub(super) fn take_from_mesh(&mut self) {
        let motion = &mut self.motion;
        std::mem::swap(&mut motion.mesh.points, &mut self.points);
        std::mem::swap(&mut motion.mesh.vertices, &mut self.vertices);
        std::mem::swap(&mut motion.mesh.neighbors, &mut self.neighbors);
    }
}

impl super::flip::Mesh {
    /// Gives the last vertex the number of one that is no longer part of the triangulation.
    fn rename_last(&mut self, gap: u32, region: &mut Region) {
        let last = (self.points.len() - 1) as u32;
        if gap != last {
            self.star_of(last, region);
            for &t in &region.old {
                let slot = slot_of(self.vertices[t as usize], last);
                let across = self.neighbors[t as usize][slot];
                self.vertices[t as usize][slot] = gap;
                self.opposite[across.tet() as usize][across.slot()] = gap;
            }
            self.incident[gap as usize] = self.incident[last as usize];
        }
        self.points.swap_remove(gap as usize);
        self.incident.pop();
        debug_assert!(self.vertices.iter().flatten().all(|&v| v == INFINITE || v < last));
    }
}
