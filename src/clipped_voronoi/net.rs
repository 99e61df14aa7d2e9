//! The edges of the sheet, and what is around each of its vertices.

use super::owners::count;
use crate::surface::edges;

/// How the triangles of a sheet hang together.
#[derive(Default)]
pub(super) struct Net {
    /// For each triangle the numbers of its edges, the first from its first corner to its second.
    edges: Vec<[u32; 3]>,
    /// How many edges there are.
    count: usize,
    /// For each vertex, where its corners begin.
    first: Vec<u32>,
    /// The corners by vertex.
    corners: Vec<Corner>,
}

/// A vertex in one of its triangles.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) triangle: u32,
    /// The edge to the next vertex.
    pub(super) edge: u32,
    /// The triangle's other vertices, in its order.
    pub(super) next: u32,
    pub(super) last: u32,
}

impl Net {
    /// Of triangles between so many vertices.
    pub(super) fn new(triangles: &[[u32; 3]], vertices: usize) -> Net {
        let mut net = Net { edges: vec![[0; 3]; triangles.len()], ..Net::default() };
        for group in edges::sorted(triangles).chunk_by(|a, b| a.0 == b.0) {
            for &(_, e) in group {
                net.edges[edges::triangle_of(e) as usize][e as usize % 3] = net.count as u32;
            }
            net.count += 1;
        }
        count(&mut net.first, vertices, triangles.iter().flatten().copied());
        let nothing = Corner { triangle: 0, edge: 0, next: 0, last: 0 };
        net.corners = vec![nothing; 3 * triangles.len()];
        for (t, ids) in triangles.iter().enumerate().rev() {
            for c in 0..3 {
                let first = &mut net.first[ids[c] as usize];
                *first -= 1;
                let (next, last) = (ids[(c + 1) % 3], ids[(c + 2) % 3]);
                net.corners[*first as usize] = Corner { triangle: t as u32, edge: net.edges[t][c], next, last };
            }
        }
        net
    }

    /// How many edges there are.
    pub(super) fn edges(&self) -> usize {
        self.count
    }

    /// The edges of triangle `t`, the first from its first corner to its second.
    #[inline]
    pub(super) fn edges_of(&self, t: u32) -> [u32; 3] {
        self.edges[t as usize]
    }

    /// The corners, by vertex.
    #[inline]
    pub(super) fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// Which of them are at vertex `v`.
    #[inline]
    pub(super) fn corners_at(&self, v: u32) -> std::ops::Range<usize> {
        self.first[v as usize] as usize..self.first[v as usize + 1] as usize
    }
}
