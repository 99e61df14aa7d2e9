//! The edges of the sheet.

use crate::surface::edges;

/// How the triangles of a sheet hang together.
#[derive(Default)]
pub(super) struct Net {
    /// For each triangle the numbers of its edges, the first from its first corner to its second.
    edges: Vec<[u32; 3]>,
    /// How many edges there are.
    count: usize,
}

impl Net {
    /// Of these triangles.
    pub(super) fn new(triangles: &[[u32; 3]]) -> Net {
        let mut net = Net { edges: vec![[0; 3]; triangles.len()], ..Net::default() };
        for group in edges::sorted(triangles).chunk_by(|a, b| a.0 == b.0) {
            for &(_, e) in group {
                net.edges[edges::triangle_of(e) as usize][e as usize % 3] = net.count as u32;
            }
            net.count += 1;
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
}
