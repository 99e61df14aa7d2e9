//! Changes of a mesh, each with what it takes to take it back.

use glam::DVec3;

use super::{Complex, Facet, Freedom, NONE, Stray, Vertex};
use crate::improve::measure;

/// Enough to take a change back.
#[derive(Clone, Copy, Debug)]
pub(super) enum Undo {
    /// The slot, and whether it was an empty one.
    AddedTet(u32, bool),
    RemovedTet(u32, [u32; 4], f64),
    AddedFacet(u32, bool),
    RemovedFacet(u32, Facet),
    Moved(u32, DVec3, Freedom),
    Judged(u32, f64),
    Strayed(u32, Stray),
    AddedVertex,
    ReusedVertex(u32, DVec3, Freedom, u32),
    FreedVertex,
    AddedCrease([u32; 2]),
    RemovedCrease([u32; 2]),
}

/// A place in the log, to go back to.
#[derive(Clone, Copy, Debug)]
pub(in crate::improve) struct Mark {
    entries: usize,
    deficit: f64,
}

impl Complex {
    /// Adds a tet of known quality.
    pub(in crate::improve) fn add_tet(&mut self, tet: [u32; 4], quality: f64) -> u32 {
        let free = self.free_tets.pop();
        let t = free.unwrap_or(self.tets.len() as u32);
        if free.is_some() {
            self.tets[t as usize] = tet;
            self.quality[t as usize] = quality;
        } else {
            self.tets.push(tet);
            self.quality.push(quality);
        }
        self.deficit += self.deficit_of(quality);
        self.touch_all(tet);
        tet.into_iter().for_each(|v| self.tet_stars.add(v, t));
        self.log.push(Undo::AddedTet(t, free.is_some()));
        t
    }

    pub(in crate::improve) fn remove_tet(&mut self, t: u32) {
        let tet = self.tets[t as usize];
        let quality = self.quality[t as usize];
        self.deficit -= self.deficit_of(quality);
        self.log.push(Undo::RemovedTet(t, tet, quality));
        self.drop_tet(t);
    }

    fn drop_tet(&mut self, t: u32) {
        let tet = std::mem::replace(&mut self.tets[t as usize], [NONE; 4]);
        self.touch_all(tet);
        tet.into_iter().for_each(|v| self.tet_stars.remove(v, t));
        self.free_tets.push(t);
    }

    pub(in crate::improve) fn add_facet(&mut self, facet: Facet) {
        let free = self.free_facets.pop();
        let f = free.unwrap_or(self.facets.len() as u32);
        if free.is_some() {
            self.facets[f as usize] = facet;
        } else {
            self.facets.push(facet);
        }
        facet.vertices.into_iter().for_each(|v| self.facet_stars.add(v, f));
        self.log.push(Undo::AddedFacet(f, free.is_some()));
    }

    pub(in crate::improve) fn remove_facet(&mut self, f: u32) {
        self.log.push(Undo::RemovedFacet(f, self.facets[f as usize]));
        self.drop_facet(f);
    }

    fn drop_facet(&mut self, f: u32) {
        let vertices = std::mem::replace(&mut self.facets[f as usize].vertices, [NONE; 3]);
        vertices.into_iter().for_each(|v| self.facet_stars.remove(v, f));
        self.free_facets.push(f);
    }

    /// Moves a vertex and judges its tets anew.
    pub(in crate::improve) fn move_vertex(&mut self, v: u32, to: DVec3, freedom: Freedom) {
        self.place_vertex(v, to, freedom);
        for k in 0..self.tet_stars.of(v).len() {
            let t = self.tet_stars.of(v)[k];
            self.judge(t, measure::quality(self.corners(self.tets[t as usize])));
        }
    }

    /// The same where the qualities of its tets are known, in the order of [`Complex::star`].
    pub(in crate::improve) fn move_judged(&mut self, v: u32, to: DVec3, freedom: Freedom, qualities: &[f64]) {
        self.place_vertex(v, to, freedom);
        debug_assert_eq!(qualities.len(), self.star(v).len());
        for (k, &quality) in qualities.iter().enumerate() {
            self.judge(self.tet_stars.of(v)[k], quality);
        }
    }

    fn place_vertex(&mut self, v: u32, to: DVec3, freedom: Freedom) {
        self.log.push(Undo::Moved(v, self.points[v as usize], self.freedom[v as usize]));
        self.points[v as usize] = to;
        self.freedom[v as usize] = freedom;
    }

    fn judge(&mut self, t: u32, quality: f64) {
        let before = std::mem::replace(&mut self.quality[t as usize], quality);
        self.deficit += self.deficit_of(quality) - self.deficit_of(before);
        self.log.push(Undo::Judged(t, before));
        self.touch_all(self.tets[t as usize]);
    }

    /// Notes a change of a tet of these vertices.
    fn touch_all(&mut self, tet: [u32; 4]) {
        self.changes += 1;
        tet.into_iter().for_each(|v| self.touched[v as usize] = self.changes);
    }

    /// The number of changes so far, those for trials and those taken back included.
    pub(in crate::improve) fn changes(&self) -> u32 {
        self.changes
    }

    /// Whether a tet around `v` changed after so many changes.
    pub(in crate::improve) fn changed_around(&self, v: u32, since: u32) -> bool {
        self.touched[v as usize] > since
    }

    /// Notes how far facet `f` strays from the surface now.
    pub(in crate::improve) fn set_stray(&mut self, f: u32, stray: Stray) {
        self.log.push(Undo::Strayed(f, self.facets[f as usize].stray));
        self.facets[f as usize].stray = stray;
    }

    pub(in crate::improve) fn add_vertex(&mut self, vertex: Vertex) -> u32 {
        let Vertex { point, freedom, region } = vertex;
        if let Some(v) = self.free_vertices.pop() {
            let i = v as usize;
            self.log.push(Undo::ReusedVertex(v, self.points[i], self.freedom[i], self.region[i]));
            (self.points[i], self.freedom[i], self.region[i]) = (point, freedom, region);
            return v;
        }
        self.points.push(point);
        self.changes += 1;
        self.touched.push(self.changes);
        self.freedom.push(freedom);
        self.region.push(region);
        self.tet_stars.push();
        self.facet_stars.push();
        self.log.push(Undo::AddedVertex);
        self.points.len() as u32 - 1
    }

    /// Gives up a vertex that is in no tet any more.
    pub(in crate::improve) fn free_vertex(&mut self, v: u32) {
        debug_assert!(self.star(v).is_empty() && self.facets_of(v).is_empty());
        self.free_vertices.push(v);
        self.log.push(Undo::FreedVertex);
    }

    /// This place in the log, to go back to.
    pub(in crate::improve) fn mark(&self) -> Mark {
        Mark { entries: self.log.len(), deficit: self.deficit }
    }

    /// Keeps every change for good.
    pub(in crate::improve) fn commit(&mut self) {
        self.commits += 1;
        self.stamps.resize(self.points.len(), 0);
        for k in 0..self.log.len() {
            match self.log[k] {
                Undo::AddedTet(t, _) if self.is_alive(t) => {
                    self.tets[t as usize].into_iter().for_each(|v| self.stamps[v as usize] = self.commits);
                }
                Undo::Moved(v, ..) => self.stamps[v as usize] = self.commits,
                _ => {}
            }
        }
        self.log.clear();
    }

    /// The number of commits so far.
    pub(in crate::improve) fn commits(&self) -> u32 {
        self.commits
    }

    /// Lets everything around `v` count as changed.
    pub(in crate::improve) fn touch(&mut self, v: u32) {
        self.commits += 1;
        self.stamps.resize(self.points.len(), 0);
        self.stamps[v as usize] = self.commits;
        self.changes += 1;
        self.touched[v as usize] = self.changes;
    }

    /// Whether something changed after commit `since` at vertex `v`.
    pub(in crate::improve) fn changed_at(&self, v: u32, since: u32) -> bool {
        self.stamps.get(v as usize).is_some_and(|&s| s > since)
    }

    /// Whether something changed after commit `since` at vertex `v` or one beside it.
    pub(in crate::improve) fn changed_beside(&self, v: u32, since: u32) -> bool {
        let mut beside = self.star(v).iter().flat_map(|&t| self.tets[t as usize]);
        beside.any(|u| self.changed_at(u, since))
    }

    /// Takes back what was changed since `mark`.
    pub(in crate::improve) fn rollback(&mut self, mark: Mark) {
        while self.log.len() > mark.entries
            && let Some(undo) = self.log.pop()
        {
            self.undo(undo);
        }
        self.deficit = mark.deficit;
    }

    /// The tets that were added or changed since `mark` and are still there, some of them repeatedly.
    pub(in crate::improve) fn changed_since(&self, mark: Mark) -> impl Iterator<Item = u32> {
        let slots = self.log[mark.entries..].iter().filter_map(|undo| match *undo {
            Undo::AddedTet(t, _) | Undo::Judged(t, _) => Some(t),
            _ => None,
        });
        slots.filter(|&t| self.is_alive(t))
    }

    /// The facets that were added or changed since `mark` and are still there, some of them repeatedly.
    pub(in crate::improve) fn facets_since(&self, mark: Mark) -> impl Iterator<Item = u32> {
        let slots = self.log[mark.entries..].iter().filter_map(|undo| match *undo {
            Undo::AddedFacet(f, _) | Undo::Strayed(f, _) => Some(f),
            _ => None,
        });
        slots.filter(|&f| self.facets[f as usize].vertices[0] != NONE)
    }

    fn undo(&mut self, undo: Undo) {
        const FREED_LAST: &str = "changes are taken back in the order opposite to theirs: this is a bug in tetcvt";
        match undo {
            Undo::AddedTet(t, reused) => {
                self.drop_tet(t);
                if !reused {
                    self.free_tets.pop();
                    self.tets.pop();
                    self.quality.pop();
                }
            }
            Undo::RemovedTet(t, tet, quality) => {
                self.free_tets.pop().expect(FREED_LAST);
                self.tets[t as usize] = tet;
                self.quality[t as usize] = quality;
                self.touch_all(tet);
                tet.into_iter().for_each(|v| self.tet_stars.add(v, t));
            }
            Undo::AddedFacet(f, reused) => {
                self.drop_facet(f);
                if !reused {
                    self.free_facets.pop();
                    self.facets.pop();
                }
            }
            Undo::RemovedFacet(f, facet) => {
                self.free_facets.pop().expect(FREED_LAST);
                self.facets[f as usize] = facet;
                facet.vertices.into_iter().for_each(|v| self.facet_stars.add(v, f));
            }
            Undo::Moved(v, point, freedom) => {
                self.points[v as usize] = point;
                self.freedom[v as usize] = freedom;
            }
            Undo::Judged(t, quality) => {
                self.quality[t as usize] = quality;
                self.touch_all(self.tets[t as usize]);
            }
            Undo::Strayed(f, stray) => self.facets[f as usize].stray = stray,
            Undo::AddedVertex => {
                self.points.pop();
                self.touched.pop();
                self.freedom.pop();
                self.region.pop();
                self.tet_stars.pop();
                self.facet_stars.pop();
            }
            Undo::ReusedVertex(v, point, freedom, region) => {
                let i = v as usize;
                (self.points[i], self.freedom[i], self.region[i]) = (point, freedom, region);
                self.free_vertices.push(v);
            }
            Undo::FreedVertex => {
                self.free_vertices.pop().expect(FREED_LAST);
            }
            Undo::AddedCrease(edge) => self.drop_crease(edge),
            Undo::RemovedCrease(edge) => self.put_crease(edge),
        }
    }
}
