//! What is seen of the triangles of the sheet before any is cut: from the owners of their corners alone.

use std::ops::Range;

use super::surface_pieces::Scene;

/// What is seen of a block of triangles from the owners of their corners alone.
pub(super) struct Seen {
    /// Triangles that are whole in a cell, and others.
    pub(super) whole: Vec<u32>,
    pub(super) shared: Vec<u32>,
    /// Edges between two owners, each in one of the two directions in which triangles have it.
    pub(super) edges: Vec<Edge>,
    /// Triangles of three owners.
    pub(super) triangles: Vec<Triangle>,
}

/// An edge between vertices of two seeds, that of the lesser first.
#[derive(Clone, Copy, Default)]
pub(super) struct Edge {
    pub(super) seed: u32,
    pub(super) id: u32,
    pub(super) vertices: [u32; 2],
}

/// A triangle with the corners of three seeds, and the least of these.
#[derive(Clone, Copy, Default)]
pub(super) struct Triangle {
    pub(super) seed: u32,
    pub(super) id: u32,
}

/// Lists that are longer than what is in them: what a triangle is is hard to predict, and written in any case.
#[derive(Default)]
pub(super) struct Look {
    whole: Vec<u32>,
    shared: Vec<u32>,
    edges: Vec<Edge>,
    triangles: Vec<Triangle>,
}

impl Look {
    /// Looks at some triangles.
    pub(super) fn at(&mut self, scene: Scene, range: Range<usize>) -> Seen {
        let Look { whole, shared, edges, triangles } = self;
        let most = range.len() + 1;
        whole.resize(most, 0);
        shared.resize(most, 0);
        edges.resize(3 * most, Edge::default());
        triangles.resize(most, Triangle::default());
        let [mut wholes, mut others, mut borders, mut threes] = [0; 4];
        for t in range.start as u32..range.end as u32 {
            let ([u, v, w], ids) = (scene.sheet.triangles[t as usize], scene.sheet.net.edges_of(t));
            let [i, j, k] = scene.corner_owners(t);
            for (id, [a, b], [from, to]) in
                [(ids[0], [i, j], [u, v]), (ids[1], [j, k], [v, w]), (ids[2], [k, i], [w, u])]
            {
                edges[borders] = Edge { seed: a.min(b), id, vertices: if a < b { [from, to] } else { [to, from] } };
                borders += usize::from((a != b) & (from < to));
            }
            (whole[wholes], shared[others]) = (t, t);
            let is_whole = (i == j) & (j == k);
            (wholes, others) = (wholes + usize::from(is_whole), others + usize::from(!is_whole));
            triangles[threes] = Triangle { seed: i.min(j).min(k), id: t };
            threes += usize::from((i != j) & (j != k) & (k != i));
        }
        Seen {
            whole: whole[..wholes].to_vec(),
            shared: shared[..others].to_vec(),
            edges: edges[..borders].to_vec(),
            triangles: triangles[..threes].to_vec(),
        }
    }
}
