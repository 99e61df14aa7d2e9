//! A mesh that can be changed: tets and boundary facets in slots, with the stars of all vertices, and a log by which every
//! change since the last [`Complex::commit`] can be taken back.

use glam::DVec3;

use super::measure;
use super::stars::Stars;
use crate::geometry::tetrahedron::FACETS;

/// Stands for what does not exist.
pub(super) const NONE: u32 = u32::MAX;

/// How a vertex may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Freedom {
    /// Anywhere within the solid.
    Inside,
    /// On the surface; the triangle that it lies on.
    Surface(u32),
    /// Not at all, on the surface, of which it holds a tip; the triangle that it lies on.
    Held(u32),
    /// Along a crease: its number, and the arc length there.
    Curve(u32, f64),
    /// Not at all; its place on a crease, as above.
    Knot(u32, f64),
    /// Not at all.
    Fixed,
}

impl Freedom {
    /// Whether the vertex is bound to a crease or a corner, or does not move at all.
    pub(super) fn is_bound(self) -> bool {
        !matches!(self, Freedom::Inside | Freedom::Surface(_))
    }
}

/// A vertex as it is given.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub point: DVec3,
    pub freedom: Freedom,
    /// The solid that it belongs to.
    pub region: u32,
}

/// A facet of the boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facet {
    /// Its vertices, counter-clockwise seen from outside; [`NONE`] first in an empty slot.
    pub vertices: [u32; 3],
    /// The smooth part of the surface that it stands for.
    pub face: u32,
    /// How far it strays from the surface, in the frame.
    pub stray: f64,
}

/// Enough to take a change back.
#[derive(Clone, Copy, Debug)]
enum Undo {
    /// The slot, and whether it was an empty one.
    AddedTet(u32, bool),
    RemovedTet(u32, [u32; 4], f64),
    AddedFacet(u32, bool),
    RemovedFacet(u32, Facet),
    Moved(u32, DVec3, Freedom),
    Judged(u32, f64),
    Strayed(u32, f64),
    AddedVertex,
    ReusedVertex(u32, DVec3, Freedom, u32),
    FreedVertex,
    AddedCrease([u32; 2]),
    RemovedCrease([u32; 2]),
}

/// A mesh of tets and its boundary, in the frame.
#[derive(Clone, Debug)]
pub(super) struct Complex {
    pub points: Vec<DVec3>,
    pub freedom: Vec<Freedom>,
    /// The solid that each vertex belongs to.
    pub region: Vec<u32>,
    /// Positive tets; [`NONE`] first in an empty slot.
    pub tets: Vec<[u32; 4]>,
    /// Quality of each tet.
    pub quality: Vec<f64>,
    pub facets: Vec<Facet>,
    /// Whether some facets are interfaces: they have tets on both of their sides.
    pub has_interfaces: bool,
    /// Edges on creases, both ways, ascending: they stay.
    creases: Vec<[u32; 2]>,
    tet_stars: Stars,
    facet_stars: Stars,
    free_tets: Vec<u32>,
    free_facets: Vec<u32>,
    /// Vertices in no tet.
    pub free_vertices: Vec<u32>,
    log: Vec<Undo>,
    /// When something last changed for good around each vertex, by the number of the commit.
    stamps: Vec<u32>,
    commits: u32,
    /// The quality that every tet should have.
    floor: f64,
    /// Sum of the cubes of what tets lack to the floor.
    deficit: f64,
}

/// A place in the log, to go back to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    entries: usize,
    deficit: f64,
}

impl Complex {
    /// Of these vertices, tets and boundary facets.
    pub(super) fn new(vertices: Vec<Vertex>, tets: Vec<[u32; 4]>, facets: Vec<Facet>) -> Complex {
        let points: Vec<DVec3> = vertices.iter().map(|v| v.point).collect();
        let quality = tets.iter().map(|t| measure::quality(t.map(|v| points[v as usize]))).collect();
        let triangles: Vec<[u32; 3]> = facets.iter().map(|f| f.vertices).collect();
        Complex {
            tet_stars: Stars::new(points.len(), &tets),
            facet_stars: Stars::new(points.len(), &triangles),
            freedom: vertices.iter().map(|v| v.freedom).collect(),
            region: vertices.iter().map(|v| v.region).collect(),
            points,
            tets,
            quality,
            facets,
            has_interfaces: false,
            creases: Vec::new(),
            free_tets: Vec::new(),
            free_facets: Vec::new(),
            free_vertices: Vec::new(),
            log: Vec::new(),
            stamps: Vec::new(),
            commits: 0,
            floor: 0.0,
            deficit: 0.0,
        }
    }

    /// Makes those of `edges` that are edges of the boundary creases, which stay.
    pub(super) fn set_creases(&mut self, edges: impl Iterator<Item = [u32; 2]>) {
        let on_boundary =
            |&[a, b]: &[u32; 2]| self.facets_of(a).iter().any(|&f| self.facets[f as usize].vertices.contains(&b));
        let mut creases: Vec<[u32; 2]> = edges.filter(on_boundary).flat_map(|[a, b]| [[a, b], [b, a]]).collect();
        creases.sort_unstable();
        creases.dedup();
        self.creases = creases;
    }

    /// Forgets the creases that do not end at vertices bound to them on both sides any more.
    pub(super) fn retain_creases(&mut self) {
        let freedom = &self.freedom;
        let bound = |v: u32| freedom[v as usize].is_bound();
        self.creases.retain(|&[a, b]| bound(a) && bound(b));
    }

    /// Whether the edge between two vertices is a crease.
    pub(super) fn is_crease(&self, a: u32, b: u32) -> bool {
        self.creases.binary_search(&[a, b]).is_ok()
    }

    /// The vertices next to `v` along creases.
    pub(super) fn along_creases(&self, v: u32) -> impl Iterator<Item = u32> {
        let from = self.creases.partition_point(|e| e[0] < v);
        self.creases[from..].iter().take_while(move |e| e[0] == v).map(|e| e[1])
    }

    /// Makes an edge a crease.
    pub(super) fn add_crease(&mut self, [a, b]: [u32; 2]) {
        self.put_crease([a, b]);
        self.log.push(Undo::AddedCrease([a, b]));
    }

    /// Makes a crease an edge like others.
    pub(super) fn remove_crease(&mut self, [a, b]: [u32; 2]) {
        self.drop_crease([a, b]);
        self.log.push(Undo::RemovedCrease([a, b]));
    }

    fn put_crease(&mut self, [a, b]: [u32; 2]) {
        for edge in [[a, b], [b, a]] {
            if let Err(at) = self.creases.binary_search(&edge) {
                self.creases.insert(at, edge);
            }
        }
    }

    fn drop_crease(&mut self, [a, b]: [u32; 2]) {
        for edge in [[a, b], [b, a]] {
            if let Ok(at) = self.creases.binary_search(&edge) {
                self.creases.remove(at);
            }
        }
    }

    /// Sets the quality that every tet should have.
    pub(super) fn set_floor(&mut self, floor: f64) {
        self.floor = floor;
        self.deficit =
            (0..self.tets.len()).filter(|&t| self.is_alive(t as u32)).map(|t| self.deficit_of(self.quality[t])).sum();
    }

    /// The quality that every tet should have.
    pub(super) fn floor(&self) -> f64 {
        self.floor
    }

    /// Sum of the cubes of what tets lack to the floor, but for rounding.
    pub(super) fn deficit(&self) -> f64 {
        self.deficit
    }

    fn deficit_of(&self, quality: f64) -> f64 {
        let lack = (self.floor - quality).max(0.0);
        lack * lack * lack
    }

    /// Number of vertices in use.
    pub(super) fn vertex_count(&self) -> usize {
        self.points.len() - self.free_vertices.len()
    }

    /// The tets around vertex `v`.
    pub(super) fn star(&self, v: u32) -> &[u32] {
        self.tet_stars.of(v)
    }

    /// The boundary facets around vertex `v`.
    pub(super) fn facets_of(&self, v: u32) -> &[u32] {
        self.facet_stars.of(v)
    }

    pub(super) fn is_alive(&self, t: u32) -> bool {
        self.tets[t as usize][0] != NONE
    }

    pub(super) fn on_boundary(&self, v: u32) -> bool {
        !self.facet_stars.of(v).is_empty()
    }

    pub(super) fn corners<const K: usize>(&self, vertices: [u32; K]) -> [DVec3; K] {
        vertices.map(|v| self.points[v as usize])
    }

    /// The tet, other than `t`, that has the facet of these vertices; none across an interface.
    pub(super) fn across(&self, t: u32, [a, b, c]: [u32; 3]) -> Option<u32> {
        if self.has_interfaces && self.facet([a, b, c]).is_some() {
            return None;
        }
        self.star(a).iter().copied().find(|&u| {
            let tet = &self.tets[u as usize];
            u != t && tet.contains(&b) && tet.contains(&c)
        })
    }

    /// The boundary facet of these vertices.
    pub(super) fn facet(&self, [a, b, c]: [u32; 3]) -> Option<u32> {
        self.facets_of(a).iter().copied().find(|&f| {
            let facet = &self.facets[f as usize].vertices;
            facet.contains(&b) && facet.contains(&c)
        })
    }

    /// The boundary facets at the edge between two vertices: two or none.
    pub(super) fn facets_at(&self, a: u32, b: u32) -> impl Iterator<Item = u32> {
        self.facets_of(a).iter().copied().filter(move |&f| self.facets[f as usize].vertices.contains(&b))
    }

    /// The same, as a list.
    pub(super) fn edge_facets(&self, [a, b]: [u32; 2]) -> Vec<u32> {
        self.facets_at(a, b).collect()
    }

    /// Whether some tet has both vertices.
    pub(super) fn has_edge(&self, a: u32, b: u32) -> bool {
        self.star(a).iter().any(|&t| self.tets[t as usize].contains(&b))
    }

    /// The vertex of tet `t` that is not of the facet.
    pub(super) fn apex(&self, t: u32, facet: [u32; 3]) -> u32 {
        let tet = self.tets[t as usize];
        tet.into_iter().find(|v| !facet.contains(v)).expect("a tet has four vertices: this is a bug in tetcvt")
    }

    /// The facet of tet `t` opposite its corner `i`, counter-clockwise seen from outside.
    pub(super) fn facet_of(&self, t: u32, i: usize) -> [u32; 3] {
        FACETS[i].map(|k| self.tets[t as usize][k])
    }

    /// Adds a tet of known quality.
    pub(super) fn add_tet(&mut self, tet: [u32; 4], quality: f64) -> u32 {
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
        tet.into_iter().for_each(|v| self.tet_stars.add(v, t));
        self.log.push(Undo::AddedTet(t, free.is_some()));
        t
    }

    pub(super) fn remove_tet(&mut self, t: u32) {
        let tet = self.tets[t as usize];
        let quality = self.quality[t as usize];
        self.deficit -= self.deficit_of(quality);
        self.log.push(Undo::RemovedTet(t, tet, quality));
        self.drop_tet(t);
    }

    fn drop_tet(&mut self, t: u32) {
        let tet = std::mem::replace(&mut self.tets[t as usize], [NONE; 4]);
        tet.into_iter().for_each(|v| self.tet_stars.remove(v, t));
        self.free_tets.push(t);
    }

    pub(super) fn add_facet(&mut self, facet: Facet) {
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

    pub(super) fn remove_facet(&mut self, f: u32) {
        self.log.push(Undo::RemovedFacet(f, self.facets[f as usize]));
        self.drop_facet(f);
    }

    fn drop_facet(&mut self, f: u32) {
        let vertices = std::mem::replace(&mut self.facets[f as usize].vertices, [NONE; 3]);
        vertices.into_iter().for_each(|v| self.facet_stars.remove(v, f));
        self.free_facets.push(f);
    }

    /// Moves a vertex and judges its tets anew.
    pub(super) fn move_vertex(&mut self, v: u32, to: DVec3, freedom: Freedom) {
        self.log.push(Undo::Moved(v, self.points[v as usize], self.freedom[v as usize]));
        self.points[v as usize] = to;
        self.freedom[v as usize] = freedom;
        for k in 0..self.tet_stars.of(v).len() {
            let t = self.tet_stars.of(v)[k];
            let quality = measure::quality(self.tets[t as usize].map(|v| self.points[v as usize]));
            let before = std::mem::replace(&mut self.quality[t as usize], quality);
            self.deficit += self.deficit_of(quality) - self.deficit_of(before);
            self.log.push(Undo::Judged(t, before));
        }
    }

    /// Notes how far facet `f` strays from the surface now.
    pub(super) fn set_stray(&mut self, f: u32, stray: f64) {
        self.log.push(Undo::Strayed(f, self.facets[f as usize].stray));
        self.facets[f as usize].stray = stray;
    }

    pub(super) fn add_vertex(&mut self, vertex: Vertex) -> u32 {
        let Vertex { point, freedom, region } = vertex;
        if let Some(v) = self.free_vertices.pop() {
            let i = v as usize;
            self.log.push(Undo::ReusedVertex(v, self.points[i], self.freedom[i], self.region[i]));
            (self.points[i], self.freedom[i], self.region[i]) = (point, freedom, region);
            return v;
        }
        self.points.push(point);
        self.freedom.push(freedom);
        self.region.push(region);
        self.tet_stars.push();
        self.facet_stars.push();
        self.log.push(Undo::AddedVertex);
        self.points.len() as u32 - 1
    }

    /// Gives up a vertex that is in no tet any more.
    pub(super) fn free_vertex(&mut self, v: u32) {
        debug_assert!(self.star(v).is_empty() && self.facets_of(v).is_empty());
        self.free_vertices.push(v);
        self.log.push(Undo::FreedVertex);
    }

    /// This place in the log, to go back to.
    pub(super) fn mark(&self) -> Mark {
        Mark { entries: self.log.len(), deficit: self.deficit }
    }

    /// Keeps every change for good.
    pub(super) fn commit(&mut self) {
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
    pub(super) fn commits(&self) -> u32 {
        self.commits
    }

    /// Lets everything around `v` count as changed.
    pub(super) fn touch(&mut self, v: u32) {
        self.commits += 1;
        self.stamps.resize(self.points.len(), 0);
        self.stamps[v as usize] = self.commits;
    }

    /// Whether something changed after commit `since` at vertex `v` or one beside it.
    pub(super) fn changed_beside(&self, v: u32, since: u32) -> bool {
        let mut beside = self.star(v).iter().flat_map(|&t| self.tets[t as usize]);
        beside.any(|u| self.stamps.get(u as usize).is_some_and(|&s| s > since))
    }

    /// The last commit that changed something at a vertex of a tet beside tet `t`.
    pub(super) fn last_change(&self, t: u32) -> u32 {
        let beside = self.tets[t as usize].into_iter().flat_map(|v| self.star(v)).flat_map(|&u| self.tets[u as usize]);
        beside.map(|v| self.stamps.get(v as usize).copied().unwrap_or(0)).max().unwrap_or(0)
    }

    /// Takes back what was changed since `mark`.
    pub(super) fn rollback(&mut self, mark: Mark) {
        while self.log.len() > mark.entries
            && let Some(undo) = self.log.pop()
        {
            self.undo(undo);
        }
        self.deficit = mark.deficit;
    }

    /// The tets that were added or changed since `mark` and are still there, some of them repeatedly.
    pub(super) fn changed_since(&self, mark: Mark) -> impl Iterator<Item = u32> {
        let slots = self.log[mark.entries..].iter().filter_map(|undo| match *undo {
            Undo::AddedTet(t, _) | Undo::Judged(t, _) => Some(t),
            _ => None,
        });
        slots.filter(|&t| self.is_alive(t))
    }

    /// The facets that were added or changed since `mark` and are still there, some of them repeatedly.
    pub(super) fn facets_since(&self, mark: Mark) -> impl Iterator<Item = u32> {
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
            Undo::Judged(t, quality) => self.quality[t as usize] = quality,
            Undo::Strayed(f, stray) => self.facets[f as usize].stray = stray,
            Undo::AddedVertex => {
                self.points.pop();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::improve::change::Change;
    use crate::improve::faces::remove_faces;
    use crate::improve::flips::remove_edge;
    use crate::improve::ground::Ground;
    use crate::improve::measure::INVERTED;
    use crate::improve::resize::{contract, split};
    use crate::rng::Rng;
    use crate::surface::Surface;
    use crate::surface::features::Features;

    /// The box of edge length 2, its sides cut into two triangles each.
    fn cube() -> Surface {
        let at = |i: u32, k: u32| if i >> k & 1 == 1 { 1.0 } else { -1.0 };
        let points: Vec<DVec3> = (0..8).map(|i| DVec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let each: Vec<u32> = (0..12).collect();
        Surface::new(&points, &triangles, &each, &each).expect("a closed surface")
    }

    /// Six tets around a diagonal in each of n^3 small cubes (H. W. Kuhn, 1960), the vertices inside shaken.
    fn grid(surface: &Surface, features: &Features, n: u32) -> Complex {
        let side = n + 1;
        let mut rng = Rng::new(1, 2);
        let id = |x: u32, y: u32, z: u32| (z * side + y) * side + x;
        let mut vertices = Vec::new();
        for i in 0..side * side * side {
            let place = [i % side, i / side % side, i / side / side];
            let [x, y, z] = place.map(|c| 2.0 * f64::from(c) / f64::from(n) - 1.0);
            let walls = place.iter().filter(|&&c| c == 0 || c == n).count();
            let p = surface.frame().to_frame(DVec3::new(x, y, z));
            let freedom = match walls {
                0 => Freedom::Inside,
                1 => Freedom::Surface(surface.tree().closest(p).triangle),
                _ => Freedom::Fixed,
            };
            let shake = if walls == 0 { rng.in_cube() * (0.02 / f64::from(n)) } else { DVec3::ZERO };
            vertices.push(Vertex { point: p + shake, freedom, region: 0 });
        }
        let mut tets = Vec::new();
        for i in 0..n * n * n {
            let low = [i % n, i / n % n, i / n / n];
            for [a, b, c] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
                let mut at = low;
                let mut tet = [id(at[0], at[1], at[2]); 4];
                for (k, axis) in (1..).zip([a, b, c]) {
                    at[axis] += 1;
                    tet[k] = id(at[0], at[1], at[2]);
                }
                if measure::quality(tet.map(|v| vertices[v as usize].point)) == INVERTED {
                    tet.swap(2, 3);
                }
                tets.push(tet);
            }
        }
        let mut complex = Complex::new(vertices, tets.clone(), Vec::new());
        let ground = Ground::new(surface, features, &features.face);
        for t in 0..tets.len() as u32 {
            for i in 0..4 {
                let facet = complex.facet_of(t, i);
                if complex.across(t, facet).is_none() {
                    let face = features.face[surface.facing(complex.corners(facet)) as usize];
                    let stray = ground.stray(complex.corners(facet));
                    complex.add_facet(Facet { vertices: facet, face, stray });
                }
            }
        }
        complex.commit();
        complex.set_floor(0.6);
        complex
    }

    /// All that a rollback must bring back, to the last bit; the order within a star may change.
    fn state(complex: &Complex) -> impl PartialEq + use<> {
        let bits: Vec<[u64; 3]> = complex.points.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
        let stars: Vec<[Vec<u32>; 2]> = (0..complex.points.len() as u32)
            .map(|v| {
                [complex.star(v), complex.facets_of(v)].map(|list| {
                    let mut list = list.to_vec();
                    list.sort_unstable();
                    list
                })
            })
            .collect();
        let alive: Vec<u64> = (0..complex.tets.len())
            .filter(|&t| complex.is_alive(t as u32))
            .map(|t| complex.quality[t].to_bits())
            .collect();
        let free = (complex.free_tets.clone(), complex.free_facets.clone(), complex.free_vertices.clone());
        let facets: Vec<Option<Facet>> = complex.facets.iter().map(|f| (f.vertices[0] != NONE).then_some(*f)).collect();
        let rest = (complex.tets.clone(), facets, complex.freedom.clone(), complex.region.clone());
        (bits, stars, alive, free, rest, complex.deficit.to_bits())
    }

    /// One random operation; whether it was possible.
    fn change_something(complex: &mut Complex, ground: &Ground, rng: &mut Rng) -> bool {
        let mut change = Change::default();
        let t = (rng.bits() % complex.tets.len() as u64) as u32;
        if !complex.is_alive(t) {
            return false;
        }
        let tet = complex.tets[t as usize];
        let [i, j] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]][(rng.bits() % 6) as usize];
        match rng.bits() % 5 {
            0 => remove_edge(complex, ground, [tet[i], tet[j]], 0.0, &mut change)
                .then(|| change.apply(complex))
                .is_some(),
            1 => remove_faces(complex, t, i, 0.0, &mut change).then(|| change.apply(complex)).is_some(),
            2 => split(complex, ground, [tet[i], tet[j]], &mut change).is_some(),
            3 => contract(complex, ground, [tet[i], tet[j]], 0.0, &mut change),
            _ => match ground.place(complex, tet[i], rng.in_cube() * 1e-3) {
                Some((to, freedom)) => {
                    complex.move_vertex(tet[i], to, freedom);
                    true
                }
                None => false,
            },
        }
    }

    fn volume(complex: &Complex) -> f64 {
        let tets = complex.tets.iter().filter(|t| t[0] != NONE);
        tets.map(|&t| {
            let [a, b, c, d] = complex.corners(t);
            crate::geometry::tetrahedron::volume(a, b, c, d)
        })
        .sum()
    }

    #[test]
    fn a_rollback_brings_everything_back_to_the_last_bit() {
        let surface = cube();
        let features = Features::find(&surface, 40.0);
        let ground = Ground::new(&surface, &features, &features.face);
        let mut complex = grid(&surface, &features, 4);
        let whole = volume(&complex);
        let mut rng = Rng::new(3, 4);
        let mut made = 0;
        for round in 0..60 {
            let (mark, before) = (complex.mark(), state(&complex));
            for _ in 0..30 {
                made += usize::from(change_something(&mut complex, &ground, &mut rng));
            }
            // The sides are flat, and their vertices stay on them.
            assert!((volume(&complex) / whole - 1.0).abs() < 1e-12, "round {round}");
            if round % 3 == 0 {
                complex.commit();
            } else {
                complex.rollback(mark);
                assert!(state(&complex) == before, "round {round}");
            }
        }
        assert!(made > 300, "only {made} operations were possible");
    }
}
