//! Which tet is in conflict with a point: a walk.
//!
//! O. Devillers, S. Pion, M. Teillaud, *Walking in a triangulation*, International Journal of Foundations of Computer
//! Science 13(2), 2002, doi 10.1142/S0129054102001047: the visibility walk. In a Delaunay triangulation it ends even
//! without any random choice, since each step leads to a tet of smaller power with respect to the point.
//!
//! Departures: it ends as soon as the point is inside the sphere of a tet, most often a step or two early; and an
//! infinite tet is only entered across its hull facet, by a point that is strictly beyond: in conflict.

use glam::DVec3;

use super::insert::Construction;
use super::tets::Side;
use crate::geometry::predicates::{Sign, break_tie, insphere, orient3d};

impl Construction {
    /// A tet in conflict with `p`; none if a vertex is at `p` already.
    pub(super) fn locate(&self, p: DVec3) -> Option<u32> {
        let mut tet = self.last;
        let mut entered = 4;
        'walk: loop {
            let here = &self.tets[tet as usize];
            if here.vertices[3] == self.infinite() {
                return Some(tet);
            }
            match here.side(p) {
                Side::Inside => return Some(tet),
                Side::Outside => {}
                Side::Unknown => match self.conflict(tet, p) {
                    Conflict::Yes => return Some(tet),
                    Conflict::No => {}
                    Conflict::Duplicate => return None,
                },
            }
            let corners = self.corners(here.vertices);
            for i in 0..4 {
                if i == entered {
                    continue;
                }
                let mut beyond = corners;
                beyond[i] = p;
                if orient3d(beyond[0], beyond[1], beyond[2], beyond[3]) == Sign::Negative {
                    tet = here.mirrors[i].tet();
                    entered = here.mirrors[i].slot();
                    continue 'walk;
                }
            }
            // The tet holds p, so its sphere does, unless p is one of its corners, which was found out above.
            unreachable!("a tet that holds a point is in conflict with it: this is a bug in tetcvt");
        }
    }

    /// Whether `p` is in conflict with a tet, exactly, ties broken.
    #[cold]
    #[inline(never)]
    pub(super) fn conflict(&self, tet: u32, p: DVec3) -> Conflict {
        let here = &self.tets[tet as usize];
        let [a, b, c, d] = self.corners(here.vertices);
        if here.vertices[3] != self.infinite() {
            return match insphere(a, b, c, d, p) {
                Sign::Positive => Conflict::Yes,
                Sign::Negative => Conflict::No,
                Sign::Zero if [a, b, c, d].contains(&p) => Conflict::Duplicate,
                Sign::Zero if break_tie([a, b, c, d], p) == Sign::Positive => Conflict::Yes,
                Sign::Zero => Conflict::No,
            };
        }
        match orient3d(a, b, c, p) {
            Sign::Positive => Conflict::Yes,
            Sign::Negative => Conflict::No,
            // In the plane of the hull facet, the sphere of the finite tet behind it cuts out the circle of the facet,
            // and its apex, off the plane, never decides a tie.
            Sign::Zero => self.conflict(here.mirrors[3].tet(), p),
        }
    }
}

/// The exact answer.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Conflict {
    /// The point is inside.
    Yes,
    /// The point is outside.
    No,
    /// The point is a corner of the tet.
    Duplicate,
}
