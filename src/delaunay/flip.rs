//! Local changes of the tets: flips, written so that they can be taken back.
//!
//! 1. Label the vertices of the tets that go; a facet is then a set of labels, three bits.
//! 2. Note what lies beyond each facet around them.
//! 3. Write the new tets in their place, and glue: facets of the rim to what was noted, inner ones to each other.

use glam::DVec3;

use super::facet::{Facet, INFINITE};
use crate::geometry::predicates::{Sign, insphere_perturbed, orient3d};

/// First vertex of a tet that is no longer part of the triangulation.
pub const DEAD: u32 = INFINITE;

/// Most vertices of the tets of a flip.
const LABELS: usize = 6;

/// An array of tets that is full gets room for one more in so many.
const GROWTH: usize = 32;

/// But for not fewer than this.
const LEAST_GROWTH: usize = 64;

/// Between motions, there is room in the journal for one tet in so many.
const LONG_JOURNAL: usize = 32;

/// A tet as it was before it was written to: its number, and its vertices, neighbours and vertices across.
type Entry = (u32, [u32; 4], [Facet; 4], [u32; 4]);

/// The tets while they are repaired, with what that needs.
#[derive(Clone, Default)]
pub struct Mesh {
    /// As `Delaunay::vertices`; the first is [`DEAD`] for a dead tet.
    pub vertices: Vec<[u32; 4]>,
    /// As `Delaunay::neighbors`.
    pub neighbors: Vec<[Facet; 4]>,
    /// For each facet of each tet, the vertex across.
    pub opposite: Vec<[u32; 4]>,
    /// A tet at each vertex.
    pub incident: Vec<u32>,
    /// Where the vertices are now.
    pub points: Vec<DVec3>,
    /// A point inside the hull: an infinite tet is the part of space that its facet hides from there.
    pub inside: DVec3,
    /// No point of the hull is nearer to `inside` than this, which is zero where it is not known.
    pub room: f64,
    /// Dead tets.
    pub free: Vec<u32>,
    /// What was overwritten, to be read backwards.
    journal: Vec<Entry>,
    /// Tets before the first flip.
    before: usize,
}

impl Mesh {
    /// Fills the arrays that follow from vertices and neighbours.
    pub fn derive(&mut self) {
        self.incident.clear();
        self.incident.resize(self.points.len(), 0);
        for (t, tet) in self.vertices.iter().enumerate() {
            for &v in tet.iter().filter(|&&v| v != INFINITE) {
                self.incident[v as usize] = t as u32;
            }
        }
        let across = |f: &Facet| self.vertices[f.tet() as usize][f.slot()];
        self.opposite.clear();
        self.opposite.extend(self.neighbors.iter().map(|n| [0, 1, 2, 3].map(|i| across(&n[i]))));
    }

    /// From here on, changes can be taken back.
    pub fn begin(&mut self) {
        self.journal.clear();
        // What a rough motion needed is not kept for all the quiet ones.
        self.journal.shrink_to(self.vertices.len() / LONG_JOURNAL);
        self.free.clear();
        self.before = self.vertices.len();
    }

    /// The tets written to since [`Mesh::begin`] that there still are, some more than once.
    pub fn written(&self) -> impl Iterator<Item = u32> + '_ {
        let count = self.vertices.len();
        let old = self.journal.iter().map(|entry| entry.0).filter(move |&t| (t as usize) < count);
        old.chain((self.before..count.max(self.before)).map(|t| t as u32))
    }

    /// Takes back all changes to tets since [`Mesh::begin`].
    pub fn undo(&mut self) {
        while let Some((t, vertices, neighbors, opposite)) = self.journal.pop() {
            self.vertices[t as usize] = vertices;
            self.neighbors[t as usize] = neighbors;
            self.opposite[t as usize] = opposite;
            for v in vertices.into_iter().filter(|&v| v != INFINITE) {
                self.incident[v as usize] = t;
            }
        }
        self.vertices.truncate(self.before);
        self.neighbors.truncate(self.before);
        self.opposite.truncate(self.before);
        self.free.clear();
    }

    /// Whether a tet is no longer part of the triangulation.
    #[inline]
    pub fn is_dead(&self, t: u32) -> bool {
        self.vertices[t as usize][0] == DEAD
    }

    /// Position of a finite vertex.
    #[inline]
    pub fn at(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    /// The orientation of a tet with these vertices, one of which may be the infinite one.
    pub fn orientation(&self, tet: [u32; 4]) -> Sign {
        match tet.iter().position(|&v| v == INFINITE) {
            None => {
                let [a, b, c, d] = tet.map(|v| self.at(v));
                orient3d(a, b, c, d)
            }
            Some(slot) => {
                // The hidden part of space is on the other side of the facet.
                let [a, b, c, d] = std::array::from_fn(|i| if i == slot { self.inside } else { self.at(tet[i]) });
                -orient3d(a, b, c, d)
            }
        }
    }

    /// Whether facet `i` of tet `t` is not Delaunay.
    pub fn violates(&self, t: u32, i: usize) -> bool {
        let (tet, q) = (self.vertices[t as usize], self.opposite[t as usize][i]);
        if q == INFINITE {
            return false;
        }
        if tet[3] == INFINITE && i == 3 {
            return false;
        }
        self.conflicts(t, self.at(q))
    }

    /// Whether a point, which is no vertex of tet `t`, is in conflict with it.
    pub fn conflicts(&self, t: u32, p: DVec3) -> bool {
        let tet = self.vertices[t as usize];
        if tet[3] != INFINITE {
            return self.in_sphere(tet, p);
        }
        match orient3d(self.at(tet[0]), self.at(tet[1]), self.at(tet[2]), p) {
            Sign::Positive => true,
            Sign::Negative => false,
            // In the plane of the hull facet, the sphere of the tet behind it cuts out the facet's circle.
            Sign::Zero => self.in_sphere(self.vertices[self.neighbors[t as usize][3].tet() as usize], p),
        }
    }

    fn in_sphere(&self, tet: [u32; 4], p: DVec3) -> bool {
        let [a, b, c, d] = tet.map(|v| self.at(v));
        insphere_perturbed(a, b, c, d, p) == Sign::Positive
    }

    /// Replaces tets by others that fill the same space. The numbers of the new ones are left in `ids`.
    pub fn replace(&mut self, old: &[u32], new: &[[u32; 4]], ids: &mut Vec<u32>) {
        // 1. Labels.
        let mut labels = [DEAD; LABELS];
        let mut count = 0;
        for &t in old {
            for v in self.vertices[t as usize] {
                if !labels[..count].contains(&v) {
                    labels[count] = v;
                    count += 1;
                }
            }
        }
        let bit = |v: u32| 1usize << labels[..count].iter().position(|&w| w == v).expect("old and new vertices agree");
        let bits = |tet: &[u32; 4]| tet.map(bit);
        // 2. What lies beyond.
        let mut beyond = [(Facet::BLANK, 0, false); 1 << LABELS];
        for &t in old {
            let bits = bits(&self.vertices[t as usize]);
            let all: usize = bits.iter().sum();
            for i in 0..4 {
                let facet = self.neighbors[t as usize][i];
                if !old.contains(&facet.tet()) {
                    beyond[all - bits[i]] = (facet, self.opposite[t as usize][i], true);
                }
            }
        }
        // 3. New tets.
        self.number(old, new.len(), ids);
        for (tet, &id) in new.iter().zip(ids.iter()) {
            let tet = infinite_last(*tet);
            self.vertices[id as usize] = tet;
            for v in tet.into_iter().filter(|&v| v != INFINITE) {
                self.incident[v as usize] = id;
            }
            let bits = bits(&tet);
            let all: usize = bits.iter().sum();
            for i in 0..4 {
                let here = Facet::new(id, i);
                let (facet, apex, known) = beyond[all - bits[i]];
                if known {
                    self.glue(here, tet[i], facet, apex);
                } else {
                    beyond[all - bits[i]] = (here, tet[i], true);
                }
            }
        }
    }

    /// Makes two facets one.
    pub fn glue(&mut self, here: Facet, apex_here: u32, there: Facet, apex_there: u32) {
        let (t, u) = (here.tet() as usize, there.tet() as usize);
        self.note(there.tet());
        self.neighbors[t][here.slot()] = there;
        self.opposite[t][here.slot()] = apex_there;
        self.neighbors[u][there.slot()] = here;
        self.opposite[u][there.slot()] = apex_here;
    }

    /// Numbers new tets: those of the old first, then other dead ones, then new numbers.
    pub fn number(&mut self, old: &[u32], count: usize, ids: &mut Vec<u32>) {
        ids.clear();
        for &t in old {
            self.note(t);
        }
        ids.extend_from_slice(&old[..count.min(old.len())]);
        for &t in &old[ids.len()..] {
            self.vertices[t as usize][0] = DEAD;
            self.free.push(t);
        }
        while ids.len() < count {
            let id = self.free.pop();
            ids.push(id.unwrap_or_else(|| self.add_tet()));
        }
    }

    /// A further tet, dead as yet.
    fn add_tet(&mut self) -> u32 {
        push(&mut self.vertices, [DEAD; 4]);
        push(&mut self.neighbors, [Facet::BLANK; 4]);
        push(&mut self.opposite, [DEAD; 4]);
        (self.vertices.len() - 1) as u32
    }

    /// Notes a tet as it is.
    fn note(&mut self, t: u32) {
        if (t as usize) < self.before {
            let i = t as usize;
            self.journal.push((t, self.vertices[i], self.neighbors[i], self.opposite[i]));
        }
    }

    /// The tets at a vertex.
    pub fn star(&self, v: u32, star: &mut Vec<u32>) {
        star.clear();
        star.push(self.incident[v as usize]);
        let mut done = 0;
        while done < star.len() {
            let t = star[done] as usize;
            done += 1;
            for i in 0..4 {
                let next = self.neighbors[t][i].tet();
                if self.vertices[t][i] != v && !star.contains(&next) {
                    star.push(next);
                }
            }
        }
    }

    /// Moves tets from the end into the places of dead ones.
    pub fn compact(&mut self) {
        self.compact_with(|_, _| {});
    }

    /// As [`Mesh::compact`], telling of each move from where to where.
    pub fn compact_with(&mut self, mut moved: impl FnMut(u32, u32)) {
        self.free.sort_unstable();
        let alive = self.vertices.len() - self.free.len();
        let mut holes = 0;
        for t in (alive..self.vertices.len()).rev() {
            if self.is_dead(t as u32) {
                continue;
            }
            let hole = self.free[holes] as usize;
            holes += 1;
            moved(t as u32, hole as u32);
            self.vertices[hole] = self.vertices[t];
            self.neighbors[hole] = self.neighbors[t];
            self.opposite[hole] = self.opposite[t];
            for i in 0..4 {
                let there = self.neighbors[hole][i];
                self.neighbors[there.tet() as usize][there.slot()] = Facet::new(hole as u32, i);
                let v = self.vertices[hole][i];
                if v != INFINITE {
                    self.incident[v as usize] = hole as u32;
                }
            }
        }
        self.vertices.truncate(alive);
        self.neighbors.truncate(alive);
        self.opposite.truncate(alive);
        self.free.clear();
    }
}

/// Adds an item. The number of tets hardly changes, so the array gets room for a few more, not for twice as many.
fn push<T>(items: &mut Vec<T>, item: T) {
    if items.len() == items.capacity() {
        items.reserve_exact((items.len() / GROWTH).max(LEAST_GROWTH));
    }
    items.push(item);
}

/// An even permutation that brings the infinite vertex, if there is one, to the last slot.
pub fn infinite_last(tet: [u32; 4]) -> [u32; 4] {
    let [a, b, c, d] = tet;
    match tet.iter().position(|&v| v == INFINITE) {
        Some(0) => [b, d, c, a],
        Some(1) => [a, c, d, b],
        Some(2) => [d, b, a, c],
        _ => tet,
    }
}
