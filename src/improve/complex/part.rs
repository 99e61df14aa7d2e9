//! A part of a mesh that is worked on by itself while others work on the rest, and then put back.
//!
//! The vertices that it shares with the rest are its seam. They do not move, edges and facets between them stay, and nothing is
//! done that one would have to know all around them for.

use super::{Complex, Facet, NONE, Vertex};

/// A part, with the numbers that its vertices, tets and facets have in the whole.
#[derive(Debug)]
pub(in crate::improve) struct Part {
    pub complex: Complex,
    vertices: Vec<u32>,
    pub tets: Vec<u32>,
    facets: Vec<u32>,
    /// The creases that there were.
    creases: Vec<[u32; 2]>,
}

impl Part {
    /// The slot in the whole of a tet that is still what it was, unless a tet beside it reaches the seam.
    pub(in crate::improve) fn tet_within(&self, whole: &Complex, t: u32) -> Option<u32> {
        let &of_whole = self.tets.get(t as usize)?;
        let tet = self.complex.tets[t as usize];
        let mut beside = tet.iter().flat_map(|&v| self.complex.star(v)).flat_map(|&u| self.complex.tets[u as usize]);
        let is_same = named(&self.vertices, tet) == whole.tets[of_whole as usize];
        (is_same && !beside.any(|v| self.complex.on_seam(v))).then_some(of_whole)
    }
}

/// The numbers of some vertices of a part in the whole; [`NONE`] stays.
fn named<const K: usize>(vertices: &[u32], of_part: [u32; K]) -> [u32; K] {
    of_part.map(|v| vertices.get(v as usize).copied().unwrap_or(NONE))
}

impl Complex {
    /// Whether this is a part of a mesh.
    pub(in crate::improve) fn is_part(&self) -> bool {
        !self.seam.is_empty()
    }

    /// Whether vertex `v` of a part belongs to others too.
    pub(in crate::improve) fn on_seam(&self, v: u32) -> bool {
        self.seam.get(v as usize).is_some_and(|&s| s)
    }

    /// The part that is made of these tets; `seam` has the vertices of the whole that tets of other parts have too.
    pub(in crate::improve) fn part(&self, tets: Vec<u32>, seam: &[bool]) -> Part {
        let mut number = vec![NONE; self.points.len()];
        tets.iter().for_each(|&t| self.tets[t as usize].into_iter().for_each(|v| number[v as usize] = 0));
        let vertices: Vec<u32> = (0..self.points.len() as u32).filter(|&v| number[v as usize] == 0).collect();
        (0..).zip(&vertices).for_each(|(i, &v)| number[v as usize] = i);
        let within = |vertices: &[u32]| vertices.iter().all(|&v| number[v as usize] != NONE);
        let mut facets: Vec<u32> = vertices.iter().flat_map(|&v| self.facets_of(v)).copied().collect();
        facets.sort_unstable();
        facets.dedup();
        facets.retain(|&f| within(&self.facets[f as usize].vertices));

        let given = vertices.iter().map(|&v| self.vertex(v)).collect();
        let corners = tets.iter().map(|&t| named(&number, self.tets[t as usize])).collect();
        let bounds = facets.iter().map(|&f| self.facets[f as usize]);
        let bounds = bounds.map(|f| Facet { vertices: named(&number, f.vertices), ..f }).collect();
        let mut complex = Complex::new(given, corners, bounds);
        complex.seam = vertices.iter().map(|&v| seam[v as usize]).collect();
        complex.has_interfaces = self.has_interfaces;
        complex.creases = self.creases.iter().filter(|&edge| within(edge)).map(|&edge| named(&number, edge)).collect();
        complex.set_floor(self.floor);
        Part { creases: complex.creases.clone(), complex, vertices, tets, facets }
    }

    /// Makes the changes that were made in a part, for good.
    pub(in crate::improve) fn put_back(&mut self, part: &Part) {
        let vertices = self.put_new_vertices(part);
        let tets: Vec<[u32; 4]> = part.complex.tets.iter().map(|&t| named(&vertices, t)).collect();
        let facets: Vec<[u32; 3]> = part.complex.facets.iter().map(|f| named(&vertices, f.vertices)).collect();
        let new_tets = differing(tets.len(), &part.tets, |i, t| self.tets[t as usize] == tets[i]);
        let new_facets = differing(facets.len(), &part.facets, |i, f| self.facets[f as usize].vertices == facets[i]);

        new_tets.iter().filter_map(|&i| part.tets.get(i)).for_each(|&t| self.remove_tet(t));
        new_facets.iter().filter_map(|&i| part.facets.get(i)).for_each(|&f| self.remove_facet(f));
        self.put_moves(part);
        for &i in new_tets.iter().filter(|&&i| tets[i][0] != NONE) {
            self.add_tet(tets[i], part.complex.quality[i]);
        }
        for &i in new_facets.iter().filter(|&&i| facets[i][0] != NONE) {
            self.add_facet(Facet { vertices: facets[i], ..part.complex.facets[i] });
        }
        for &v in &part.vertices {
            if self.star(v).is_empty() {
                self.free_vertex(v);
            }
        }
        self.put_creases(part, &vertices);
        self.commit();
    }

    /// Adds the vertices that were made in a part; the numbers of all of the part's vertices in the whole.
    fn put_new_vertices(&mut self, part: &Part) -> Vec<u32> {
        let mut vertices = part.vertices.clone();
        for v in vertices.len() as u32..part.complex.points.len() as u32 {
            let is_used = !part.complex.star(v).is_empty();
            vertices.push(if is_used { self.add_vertex(part.complex.vertex(v)) } else { NONE });
        }
        vertices
    }

    /// Moves what moved in a part: vertices, and facets relative to the surface.
    fn put_moves(&mut self, part: &Part) {
        for (i, &v) in (0..).zip(&part.vertices) {
            let Vertex { point, freedom, region } = part.complex.vertex(i);
            // Its place in the list may have been given up and taken anew.
            self.region[v as usize] = region;
            if (point, freedom) != (self.points[v as usize], self.freedom[v as usize]) {
                self.move_vertex(v, point, freedom);
            }
        }
        for (facet, &f) in part.complex.facets.iter().zip(&part.facets) {
            let is_there = self.facets[f as usize].vertices[0] != NONE;
            if is_there && self.facets[f as usize].stray != facet.stray {
                self.set_stray(f, facet.stray);
            }
        }
    }

    fn put_creases(&mut self, part: &Part, vertices: &[u32]) {
        let (before, after) = (&part.creases, &part.complex.creases);
        let only_in = |here: &[[u32; 2]], there: &[[u32; 2]]| -> Vec<[u32; 2]> {
            let is_new = |e: &&[u32; 2]| e[0] < e[1] && there.binary_search(e).is_err();
            here.iter().filter(is_new).map(|&e| named(vertices, e)).collect()
        };
        only_in(before, after).into_iter().for_each(|edge| self.remove_crease(edge));
        only_in(after, before).into_iter().for_each(|edge| self.add_crease(edge));
    }
}

/// The slots of a part, of so many, whose item is not the `same` as that of the slot of the whole, or new.
fn differing(count: usize, of_whole: &[u32], same: impl Fn(usize, u32) -> bool) -> Vec<usize> {
    (0..count).filter(|&i| !of_whole.get(i).is_some_and(|&slot| same(i, slot))).collect()
}
