//! A mesh that can be changed: tets and boundary facets in slots, with the stars of all vertices, and a log by which every
//! change since the last [`Complex::commit`] can be taken back.

use glam::DVec3;

use super::measure;
use super::stars::Stars;
use crate::geometry::tetrahedron::FACETS;

mod edit;

mod part;

#[cfg(test)]
pub(super) mod tests;

use edit::Undo;

pub(super) use edit::Mark;
pub(super) use part::Part;

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
    /// How far it strays from the surface, in the frame, and a triangle there.
    pub stray: Stray,
}

/// How far a facet's centroid is from the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stray {
    /// The distance, in the frame; an upper bound where the surface folds.
    pub distance: f64,
    /// The triangle of the surface at that distance.
    pub triangle: u32,
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
    /// Of a part of a mesh, the vertices that other parts have tets of too; otherwise empty.
    seam: Vec<bool>,
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
    /// When a tet around each vertex last changed, be it for a trial, by the number of the change.
    touched: Vec<u32>,
    changes: u32,
    /// The quality that every tet should have.
    floor: f64,
    /// Sum of the cubes of what tets lack to the floor.
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
            seam: Vec::new(),
            creases: Vec::new(),
            free_tets: Vec::new(),
            free_facets: Vec::new(),
            free_vertices: Vec::new(),
            log: Vec::new(),
            stamps: Vec::new(),
            commits: 0,
            touched: vec![0; vertices.len()],
            changes: 0,
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

    /// The cube of what a tet of this quality lacks to the floor.
    pub(super) fn deficit_of(&self, quality: f64) -> f64 {
        let lack = (self.floor - quality).max(0.0);
        lack * lack * lack
    }

    /// Vertex `v` as it is given.
    fn vertex(&self, v: u32) -> Vertex {
        let v = v as usize;
        Vertex { point: self.points[v], freedom: self.freedom[v], region: self.region[v] }
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

    /// The tets below the floor.
    pub(super) fn low(&self) -> impl Iterator<Item = u32> {
        (0..self.tets.len() as u32).filter(|&t| self.is_alive(t) && self.quality[t as usize] < self.floor)
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
}
