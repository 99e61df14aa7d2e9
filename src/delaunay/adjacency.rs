//! Which vertices are Delaunay neighbours of which.

use rayon::prelude::*;

use super::{Delaunay, facet::INFINITE};

/// Tets in a block of a pass over all of them.
const BLOCK: usize = 8192;

/// If more than one in so many vertices has lost or gained tets, all is built anew.
const DIRTY: usize = 4;

/// For each vertex, its finite Delaunay neighbours, ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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

/// The adjacency of a triangulation that changes from one call to the next in a few places: only there it is built anew.
#[derive(Default)]
pub struct Follower {
    adjacency: Adjacency,
    /// The tets that it belongs to.
    vertices: Vec<[u32; 4]>,
}

impl Follower {
    /// The same as [`Delaunay::adjacency`].
    pub fn follow(&mut self, delaunay: &Delaunay) -> &Adjacency {
        let (new, count) = (delaunay.vertices(), delaunay.points().len());
        let dirty = (self.adjacency.offsets.len() == count + 1).then(|| self.dirty(new, count)).flatten();
        match dirty {
            Some(dirty) if dirty.list.is_empty() => {}
            Some(dirty) => self.adjacency = self.adjacency.with_rows(&dirty, new),
            None => self.adjacency = delaunay.adjacency(),
        }
        self.vertices.clear();
        self.vertices.extend_from_slice(new);
        &self.adjacency
    }

    /// The vertices of all tets that are not in both lists at the same place; none if there are many.
    fn dirty(&self, new: &[[u32; 4]], count: usize) -> Option<Dirty> {
        let common = self.vertices.len().min(new.len());
        let changed = |block: usize| {
            let places = block * BLOCK..common.min((block + 1) * BLOCK);
            let (old, new) = (&self.vertices[places.clone()], &new[places.clone()]);
            places.zip(old.iter().zip(new)).filter(|(_, (a, b))| a != b).map(|(t, _)| t).collect::<Vec<usize>>()
        };
        let changed: Vec<Vec<usize>> = (0..common.div_ceil(BLOCK)).into_par_iter().map(changed).collect();
        let mut dirty = Dirty { rank: vec![CLEAN; count], list: Vec::new() };
        for &t in changed.iter().flatten() {
            dirty.add(self.vertices[t]);
            dirty.add(new[t]);
        }
        self.vertices[common..].iter().chain(&new[common..]).for_each(|&tet| dirty.add(tet));
        (dirty.list.len() * DIRTY <= count).then_some(dirty)
    }
}

/// Rank of a vertex whose tets are the same as before.
const CLEAN: u32 = u32::MAX;

/// Vertices whose neighbours may have changed.
struct Dirty {
    /// For each vertex, its place in the list.
    rank: Vec<u32>,
    list: Vec<u32>,
}

impl Dirty {
    /// Adds the vertices of a tet.
    fn add(&mut self, tet: [u32; 4]) {
        for v in tet {
            if v != INFINITE && self.rank[v as usize] == CLEAN {
                self.rank[v as usize] = self.list.len() as u32;
                self.list.push(v);
            }
        }
    }

    /// The ranks of a tet's vertices.
    fn ranks(&self, tet: &[u32; 4]) -> [u32; 4] {
        tet.map(|v| self.rank.get(v as usize).copied().unwrap_or(CLEAN))
    }
}

impl Adjacency {
    /// A copy with the rows of `dirty` vertices made anew from all tets.
    fn with_rows(&self, dirty: &Dirty, tets: &[[u32; 4]]) -> Adjacency {
        // 1. The tets at each dirty vertex.
        let at_dirty: Vec<Vec<(u32, u32)>> = tets
            .par_chunks(BLOCK)
            .enumerate()
            .map(|(block, tets)| {
                let mut found = Vec::new();
                for (t, tet) in (block * BLOCK..).zip(tets) {
                    let ranks = dirty.ranks(tet);
                    if ranks != [CLEAN; 4] {
                        found.extend(ranks.into_iter().filter(|&r| r != CLEAN).map(|r| (r, t as u32)));
                    }
                }
                found
            })
            .collect();
        let mut rows = vec![Vec::new(); dirty.list.len()];
        for &(rank, t) in at_dirty.iter().flatten() {
            rows[rank as usize].extend(tets[t as usize].into_iter().filter(|&w| w != INFINITE));
        }
        // 2. Their neighbours, once each.
        rows.par_iter_mut().zip(&dirty.list).for_each(|(row, &v)| {
            row.sort_unstable();
            row.dedup();
            row.retain(|&w| w != v);
        });
        // 3. All rows, one after another.
        let mut all = Adjacency {
            offsets: Vec::with_capacity(self.offsets.len()),
            neighbors: Vec::with_capacity(self.neighbors.len() + 64),
        };
        all.offsets.push(0);
        for (v, &rank) in dirty.rank.iter().enumerate() {
            let row = if rank == CLEAN { self.of(v) } else { &rows[rank as usize] };
            all.neighbors.extend_from_slice(row);
            all.offsets.push(all.neighbors.len() as u32);
        }
        all
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
