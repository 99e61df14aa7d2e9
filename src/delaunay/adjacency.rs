//! Which vertices are Delaunay neighbours of which.

use super::{Delaunay, facet::INFINITE};

/// For each vertex, its finite Delaunay neighbours, ascending.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adjacency {
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
}

impl Adjacency {
    /// Neighbours of a vertex, ascending.
    #[inline]
    pub fn of(&self, vertex: usize) -> &[u32] {
        &self.neighbors[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }

    /// Neighbours of vertex v are `neighbors()[offsets()[v]..offsets()[v + 1]]`.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// The neighbours of all vertices, one after another.
    pub fn neighbors(&self) -> &[u32] {
        &self.neighbors
    }
}

impl Delaunay {
    /// The edges of the triangulation between finite vertices, by vertex. Linear in the number of tets.
    pub fn adjacency(&self) -> Adjacency {
        let count = self.points.len();
        // 1. The tets at each vertex, by counting.
        let finite = |v: &u32| *v != INFINITE;
        let mut starts = vec![0u32; count + 1];
        for &v in self.vertices.iter().flatten().filter(|v| finite(v)) {
            starts[v as usize + 1] += 1;
        }
        prefix_sums(&mut starts);
        let mut fill = starts.clone();
        let mut tets_at = vec![0u32; starts[count] as usize];
        for (t, tet) in self.vertices.iter().enumerate() {
            for &v in tet.iter().filter(|v| finite(v)) {
                tets_at[fill[v as usize] as usize] = t as u32;
                fill[v as usize] += 1;
            }
        }
        // 2. The neighbours of each, once each, in the order met.
        let mut seen = vec![u32::MAX; count];
        let mut offsets = Vec::with_capacity(count + 1);
        let mut met = Vec::with_capacity(16 * count);
        offsets.push(0);
        for v in 0..count {
            seen[v] = v as u32;
            for &t in &tets_at[starts[v] as usize..starts[v + 1] as usize] {
                for &w in self.vertices[t as usize].iter().filter(|w| finite(w)) {
                    if seen[w as usize] != v as u32 {
                        seen[w as usize] = v as u32;
                        met.push(w);
                    }
                }
            }
            offsets.push(met.len() as u32);
        }
        // 3. Read by ascending vertex and handed to its neighbours, each list comes out ascending.
        let mut fill = offsets.clone();
        let mut neighbors = vec![0; met.len()];
        for v in 0..count {
            for &w in &met[offsets[v] as usize..offsets[v + 1] as usize] {
                neighbors[fill[w as usize] as usize] = v as u32;
                fill[w as usize] += 1;
            }
        }
        Adjacency { offsets, neighbors }
    }
}

/// Turns counts, each one place late, into starts.
fn prefix_sums(counts: &mut [u32]) {
    let mut sum = 0;
    for c in counts {
        sum += *c;
        *c = sum;
    }
}
