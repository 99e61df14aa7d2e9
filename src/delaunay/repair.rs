//! Mends a triangulation whose vertices have moved: hold back, flip, bring home.
//!
//! All tets are positive at all times but while vertices are held back, infinite ones as seen from a point inside: so what
//! is there is a triangulation of all of space, and each flip and each step of a vertex leads to another. An infinite tet
//! is flipped like any other; no case of the hull is special.
//!
//! - **Flips.** For two tets (a, b, c, p) and (a, b, c, q) on a facet that is not Delaunay: if the segment pq passes
//!   through the facet, 2-3. If it passes by edge ab, 3-2 where these two tets and (a, b, p, q) are all around ab. If it
//!   meets edge ab, 4-4 where four tets are around ab, two on each side of the plane. Else the facet waits: flips next to
//!   it may make it flippable.
//! - **Held vertices** go to just before the first of their tets would be flat. That tet, if it is not Delaunay there, is
//!   flipped away; and if it is, as can happen on the hull, it is flipped all the same, and what is wrong with that is mended
//!   after the vertex has passed. One that does not get there so is taken out at last, and put in at its place.

use glam::DVec3;

use super::facet::INFINITE;
use super::flip::Mesh;
use super::region::Region;
use super::relocate::Relocation;
use crate::geometry::predicates::Sign;
use crate::geometry::tetrahedron::volume6;

/// How often held vertices are led on before they are taken out and put in.
const ROUNDS: usize = 10;

/// So many flips are made in any case.
const FLIPS: usize = 1000;

/// With more than one flip for so many tets, building anew is faster.
const TETS_PER_FLIP: usize = 4;

/// How often one of them is moved and a tet in its way flipped, before all is made Delaunay again.
const PASSES: usize = 6;

/// Share of the way to where the first tet would be flat that a vertex goes at once.
const NEARLY: f64 = 0.98;

/// The repair could not be finished; the triangulation is in between.
pub struct GivenUp;

/// Lists of a repair, used again by the next.
#[derive(Clone, Default)]
pub struct Lists {
    /// Tets whose facets are to be tested.
    queue: Vec<u32>,
    /// Whether a tet is in the queue.
    queued: Vec<bool>,
    /// Tets with a facet that is not Delaunay and could not be flipped.
    stuck: Vec<u32>,
    /// Vertices held back, and where each is to go.
    held: Vec<(u32, DVec3)>,
    /// Tets at a vertex.
    star: Vec<u32>,
    /// Tets made by a flip.
    ids: Vec<u32>,
    /// Tets made by all flips, dead ones and repetitions among them.
    pub made: Vec<u32>,
}

impl Lists {
    /// Makes ready for the next repair of `tets` tets.
    pub fn clear(&mut self, tets: usize) {
        self.forget();
        self.queued.resize(tets, false);
        self.begin();
    }

    /// Makes ready for the next repair, after one that came to its end.
    pub fn begin(&mut self) {
        if !self.queue.is_empty() {
            self.forget();
        }
        self.stuck.clear();
        self.held.clear();
        self.made.clear();
    }

    /// Makes ready for the next repair, after one that did not.
    pub fn forget(&mut self) {
        self.queue.clear();
        self.queued.clear();
    }

    /// Queues a tet.
    pub fn push(&mut self, t: u32) {
        if self.queued.len() <= t as usize {
            self.queued.resize(t as usize + 1, false);
        }
        if !std::mem::replace(&mut self.queued[t as usize], true) {
            self.queue.push(t);
        }
    }

    /// Queues the tets made by a flip, and remembers them.
    fn push_made(&mut self) {
        let ids = std::mem::take(&mut self.ids);
        ids.iter().for_each(|&t| self.push(t));
        self.made.extend_from_slice(&ids);
        self.ids = ids;
    }

    /// Tets with facets that could not be flipped, some of them dead or mended by now.
    pub fn stuck(&self) -> &[u32] {
        &self.stuck
    }

    /// Forgets facets that could not be flipped.
    pub fn forget_stuck(&mut self) {
        self.stuck.clear();
    }
}

impl Mesh {
    /// Puts vertices back to where they were, until all tets are positive: for each tet that is not, that one of its
    /// vertices that moved farthest, unless another has been put back already.
    pub fn hold_back(
        &mut self,
        reversed: &[u32],
        old: &[DVec3],
        lists: &mut Lists,
        report: &mut Relocation,
    ) -> Result<(), GivenUp> {
        let mut bad = reversed.to_vec();
        let mut next = Vec::new();
        while !bad.is_empty() {
            let first = lists.held.len();
            for &t in &bad {
                let tet = self.vertices[t as usize];
                let away = |v: u32| match self.points.get(v as usize) {
                    Some(p) if *p != old[v as usize] => p.distance_squared(old[v as usize]),
                    _ => -1.0,
                };
                if lists.held[first..].iter().any(|h| tet.contains(&h.0)) {
                    continue;
                }
                let Some(v) = tet.into_iter().max_by(|&v, &w| away(v).total_cmp(&away(w)).then(w.cmp(&v))) else {
                    return Err(GivenUp);
                };
                if away(v) < 0.0 {
                    // All its vertices are where they were, and still it is not positive: the hull has moved too far.
                    return Err(GivenUp);
                }
                lists.held.push((v, self.at(v)));
                self.points[v as usize] = old[v as usize];
            }
            next.clear();
            let mut star = std::mem::take(&mut lists.star);
            for n in first..lists.held.len() {
                self.star(lists.held[n].0, &mut star);
                next.extend(star.iter().filter(|&&t| self.orientation(self.vertices[t as usize]) != Sign::Positive));
                star.iter().for_each(|&t| lists.push(t));
                report.predicates += star.len();
            }
            lists.star = star;
            // Tets that were passed over because another was held are in the star of that one.
            next.sort_unstable();
            next.dedup();
            std::mem::swap(&mut bad, &mut next);
        }
        report.held_back += lists.held.len();
        Ok(())
    }

    /// Flips until all that is queued, and all that comes of it, is Delaunay. Facets that could not be flipped are left in
    /// `lists.stuck`.
    pub fn flip_all(&mut self, lists: &mut Lists, report: &mut Relocation) -> Result<(), GivenUp> {
        // Flips come to an end, each lowering the lifted surface; but that may be far off.
        let most = FLIPS + self.vertices.len() / TETS_PER_FLIP;
        loop {
            let before = report.flips;
            while let Some(t) = lists.queue.pop() {
                lists.queued[t as usize] = false;
                self.mend(t, lists, report);
                if report.flips > most {
                    return Err(GivenUp);
                }
            }
            if report.flips == before || lists.stuck.is_empty() {
                return Ok(());
            }
            // What could not be flipped may be flippable now.
            for t in std::mem::take(&mut lists.stuck) {
                lists.push(t);
            }
        }
    }

    /// Tests the facets of a tet and flips one that is not Delaunay.
    fn mend(&mut self, t: u32, lists: &mut Lists, report: &mut Relocation) {
        if self.is_dead(t) {
            return;
        }
        let mut stuck = false;
        for i in 0..4 {
            report.predicates += 1;
            if !self.violates(t, i) {
                continue;
            }
            if self.flip(t, i, &mut lists.ids) {
                report.flips += 1;
                lists.push_made();
                return;
            }
            stuck = true;
        }
        if stuck {
            lists.stuck.push(t);
        }
    }

    /// Replaces facet `i` of tet `t` by a flip, if there is one of which all tets are positive.
    fn flip(&mut self, t: u32, i: usize, ids: &mut Vec<u32>) -> bool {
        let tet = self.vertices[t as usize];
        let across = self.neighbors[t as usize][i];
        let n = across.tet();
        let (p, q) = (tet[i], self.opposite[t as usize][i]);
        // Edge m of the facet is that opposite slot others[m].
        let others = super::facet::OTHERS[i][0];
        let others = [others.0, others.1, others.2];
        let v = others.map(|s| tet[s]);
        // (p, v0, v1, v2) is positive; q in place of v[m].
        let fan = |m: usize| [p, v[(m + 1) % 3], v[(m + 2) % 3], q];
        let signs = [0, 1, 2].map(|m| self.orientation(fan(m)));
        let mut beyond = (0..3).filter(|&m| signs[m] != Sign::Positive);
        let Some(m) = beyond.next() else {
            self.replace(&[t, n], &[fan(0), fan(1), fan(2)], ids);
            return true;
        };
        if beyond.next().is_some() {
            return false;
        }
        // The edge (a, b), opposite c in the facet, is in the way.
        let [a, b, c] = [v[(m + 1) % 3], v[(m + 2) % 3], v[m]];
        let third = self.neighbors[t as usize][others[m]];
        let slot = self.vertices[n as usize].iter().position(|&w| w == c).expect("both sides share the facet");
        let fourth = self.neighbors[n as usize][slot];
        let kept = [fan((m + 1) % 3), fan((m + 2) % 3)];
        if third.tet() == fourth.tet() {
            // Three tets around the edge, which goes.
            self.replace(&[t, n, third.tet()], &kept, ids);
            return true;
        }
        let r = self.opposite[t as usize][others[m]];
        if signs[m] != Sign::Zero || r != self.opposite[n as usize][slot] {
            return false;
        }
        // Four tets around the edge, two and two in a plane: the edge turns in that plane.
        let (third, fourth) = (third.tet(), fourth.tet());
        if !self.neighbors[third as usize].iter().any(|f| f.tet() == fourth) {
            return false;
        }
        let turned = [[p, a, r, q], [p, r, b, q]];
        if turned.iter().any(|&t| self.orientation(t) != Sign::Positive) {
            return false;
        }
        self.replace(&[t, n, third, fourth], &[kept[0], kept[1], turned[0], turned[1]], ids);
        true
    }

    /// Brings the vertices held back to their places, as far as their tets stay positive at a time.
    pub fn bring_home(&mut self, lists: &mut Lists, report: &mut Relocation) -> Result<(), GivenUp> {
        for _ in 0..ROUNDS {
            let held = std::mem::take(&mut lists.held);
            if held.is_empty() {
                return Ok(());
            }
            for (v, goal) in held {
                self.bring_nearer(v, goal, lists, report);
                if self.at(v) != goal {
                    lists.held.push((v, goal));
                }
                self.flip_all(lists, report)?;
            }
        }
        self.put_home(lists, report)
    }

    /// Takes out the vertices that cannot be led to their places, and puts them in there: all else is Delaunay by then.
    fn put_home(&mut self, lists: &mut Lists, report: &mut Relocation) -> Result<(), GivenUp> {
        if lists.held.is_empty() {
            return Ok(());
        }
        self.unstick(lists, report)?;
        let mut region = Region::default();
        for (v, goal) in lists.held.drain(..) {
            self.remove_vertex(v, &mut region).map_err(|_| GivenUp)?;
            self.points[v as usize] = goal;
            self.insert_vertex(v, region.ids[0], &mut region).map_err(|_| GivenUp)?;
        }
        lists.forget_stuck();
        Ok(())
    }

    /// Moves a vertex towards its goal; where a tet would turn around, to just before that, and flips that tet away.
    ///
    /// Nearly flat tets are seldom Delaunay, and then flips remove them in any case; but a tet on the hull may stay
    /// Delaunay until it is flat, as may one whose corners are about to lie on a circle.
    fn bring_nearer(&mut self, v: u32, goal: DVec3, lists: &mut Lists, report: &mut Relocation) {
        let mut star = std::mem::take(&mut lists.star);
        for _ in 0..PASSES {
            self.star(v, &mut star);
            let (tested, end) = self.advance(v, goal, &star);
            report.predicates += tested;
            star.iter().for_each(|&t| lists.push(t));
            let Some(t) = end else { break };
            let opposite = self.opposite[t as usize];
            let hull_first =
                (0..4).filter(|&i| opposite[i] == INFINITE).chain((0..4).filter(|&i| opposite[i] != INFINITE));
            if !hull_first.into_iter().any(|i| self.flip(t, i, &mut lists.ids)) {
                break;
            }
            report.flips += 1;
            lists.push_made();
        }
        lists.star = star;
    }

    /// Moves a vertex towards its goal, as far as its star stays positive or nearly so far. Returns how many tets were
    /// tested, and the tet that would be the first to turn around.
    pub fn advance(&mut self, v: u32, goal: DVec3, star: &[u32]) -> (usize, Option<u32>) {
        let start = self.at(v);
        // Volumes are linear along the way: the first to vanish ends it.
        let volume = |mesh: &Mesh, t: u32| {
            let tet = mesh.vertices[t as usize];
            let [a, b, c, d] = tet.map(|w| if w == INFINITE { mesh.inside } else { mesh.at(w) });
            let volume = volume6(a, b, c, d);
            if tet[3] == INFINITE { -volume } else { volume }
        };
        let before: Vec<f64> = star.iter().map(|&t| volume(self, t)).collect();
        self.points[v as usize] = goal;
        let (mut end, mut blocking) = (f64::INFINITY, None);
        for (&t, before) in star.iter().zip(before) {
            let after = volume(self, t);
            let share = before / (before - after);
            if after <= 0.0 && share < end {
                (end, blocking) = (share, Some(t));
            }
        }
        let mut tested = 0;
        for share in [1.0, NEARLY * end, 0.5 * end, 0.125 * end, 0.015625 * end] {
            if !(share > 0.0 && share <= 1.0) {
                continue;
            }
            let way = (start + (goal - start) * share).map(super::range::flush);
            self.points[v as usize] = if share == 1.0 { goal } else { way };
            tested += star.len();
            if star.iter().all(|&t| self.orientation(self.vertices[t as usize]) == Sign::Positive) {
                return (tested, if share == 1.0 { None } else { blocking });
            }
        }
        self.points[v as usize] = start;
        (tested, blocking)
    }

    /// Whether some facet is left that is not Delaunay.
    pub fn is_stuck(&self, lists: &Lists) -> bool {
        lists.stuck.iter().any(|&t| !self.is_dead(t) && (0..4).any(|i| self.violates(t, i)))
    }
}
