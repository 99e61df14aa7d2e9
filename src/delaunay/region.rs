//! Replaces a region of tets by others, of any number: what [`Mesh::replace`] is for flips.
//!
//! 1. Note the facets around the region, each with what lies beyond.
//! 2. Write the new tets, and note their facets.
//! 3. Sort all facets by their vertices: each is there twice, and the two are glued.

use super::facet::Facet;
use super::flip::{Mesh, infinite_last};

/// A set of tets that is emptied at no cost.
#[derive(Clone, Default)]
pub struct Marks {
    round: u32,
    last_round: Vec<u32>,
}

impl Marks {
    /// Empties the set, and makes room for numbers below `count`.
    pub fn begin(&mut self, count: usize) {
        if self.last_round.len() < count {
            self.last_round.resize(count + count / 2, 0);
        }
        if self.round == u32::MAX {
            self.last_round.fill(0);
            self.round = 0;
        }
        self.round += 1;
    }

    /// Puts a number into the set; whether it is new there.
    pub fn insert(&mut self, n: u32) -> bool {
        std::mem::replace(&mut self.last_round[n as usize], self.round) != self.round
    }

    /// Whether a number is in the set.
    pub fn contains(&self, n: u32) -> bool {
        self.last_round[n as usize] == self.round
    }
}

/// A facet by its vertices, ascending, from one side: the vertex opposite it there.
#[derive(Clone, Copy)]
struct Side {
    vertices: [u32; 3],
    facet: Facet,
    apex: u32,
    /// Whether that side is beyond the region.
    beyond: bool,
}

/// A region, what takes its place, and what that needs: used again by the next.
#[derive(Clone, Default)]
pub struct Region {
    /// The tets that go, all of them marked.
    pub old: Vec<u32>,
    /// Their numbers as a set.
    pub marks: Marks,
    /// The tets that come.
    pub new: Vec<[u32; 4]>,
    /// Their numbers, once they are there.
    pub ids: Vec<u32>,
    sides: Vec<Side>,
}

impl Mesh {
    /// Marks and lists the tets that are come by from `start`, one after another, across facets that `is_open`: given a tet,
    /// the facet's slot, and the tet beyond, which is not yet in the region.
    pub fn spread(&self, start: u32, region: &mut Region, is_open: impl Fn(u32, usize, u32) -> bool) {
        let Region { old, marks, .. } = region;
        marks.begin(self.vertices.len());
        old.clear();
        old.push(start);
        marks.insert(start);
        let mut done = 0;
        while done < old.len() {
            let t = old[done];
            done += 1;
            for i in 0..4 {
                let next = self.neighbors[t as usize][i].tet();
                if !marks.contains(next) && is_open(t, i, next) {
                    marks.insert(next);
                    old.push(next);
                }
            }
        }
    }

    /// Replaces the tets `region.old`, which are the marked ones, by `region.new`, which fill the same space.
    pub fn replace_region(&mut self, region: &mut Region) {
        let Region { old, marks, new, ids, sides } = region;
        // 1. What lies beyond.
        sides.clear();
        for &t in old.iter() {
            let tet = self.vertices[t as usize];
            for i in 0..4 {
                let facet = self.neighbors[t as usize][i];
                if !marks.contains(facet.tet()) {
                    sides.push(Side {
                        vertices: without(tet, i),
                        facet,
                        apex: self.opposite[t as usize][i],
                        beyond: true,
                    });
                }
            }
        }
        // 2. New tets.
        self.number(old, new.len(), ids);
        for (tet, &id) in new.iter().zip(ids.iter()) {
            let tet = infinite_last(*tet);
            self.vertices[id as usize] = tet;
            for i in 0..4 {
                if let Some(tet_at) = self.incident.get_mut(tet[i] as usize) {
                    *tet_at = id;
                }
                sides.push(Side { vertices: without(tet, i), facet: Facet::new(id, i), apex: tet[i], beyond: false });
            }
        }
        // 3. Glue.
        sides.sort_unstable_by_key(|s| (s.vertices, s.facet));
        for pair in sides.chunks(2) {
            let &[mut here, mut there] = pair else { unreachable!("a facet has two sides: this is a bug in tetcvt") };
            debug_assert_eq!(here.vertices, there.vertices);
            if here.beyond {
                std::mem::swap(&mut here, &mut there);
            }
            self.glue(here.facet, here.apex, there.facet, there.apex);
        }
    }
}

/// The vertices of a tet but the one in slot `i`, ascending.
fn without(tet: [u32; 4], i: usize) -> [u32; 3] {
    let (j, k, l) = super::facet::OTHERS[i][0];
    let [a, b, c] = [tet[j], tet[k], tet[l]];
    let (a, b) = (a.min(b), a.max(b));
    let (b, c) = (b.min(c), b.max(c));
    [a.min(b), a.max(b), c]
}
