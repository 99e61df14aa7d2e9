//! Which vertices are Delaunay neighbours of which.

use rayon::prelude::*;

use super::Delaunay;

/// Tets in a block of a pass over all of them.
const BLOCK: usize = 8192;

/// Vertices in a block.
const ROWS: usize = 1024;

/// If more than one in so many vertices has lost or gained tets, all is built anew.
const DIRTY: usize = 2;

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
    /// The same as [`Delaunay::adjacency`], of the first `count` vertices among themselves.
    pub fn follow(&mut self, delaunay: &Delaunay, count: usize) -> &Adjacency {
        let new = delaunay.vertices();
        let dirty = (self.adjacency.offsets.len() == count + 1).then(|| self.dirty(new, count)).flatten();
        match dirty {
            Some(dirty) if dirty.list.is_empty() => {}
            Some(dirty) => self.adjacency = self.adjacency.with_rows(&dirty, new),
            None => self.adjacency = all_rows(new, count),
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
            if (v as usize) < self.rank.len() && self.rank[v as usize] == CLEAN {
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
        // 1. The tets with a dirty vertex.
        let touched: Vec<Vec<[u32; 4]>> = tets
            .par_chunks(BLOCK)
            .map(|tets| tets.iter().filter(|tet| dirty.ranks(tet) != [CLEAN; 4]).copied().collect())
            .collect();
        let touched = touched.concat();
        // 2. The neighbours of dirty vertices.
        let new = rows(&touched, dirty.rank.len(), &dirty.list, |v| dirty.rank[v as usize]);
        // 3. All rows, one after another.
        let mut all = Adjacency {
            offsets: Vec::with_capacity(self.offsets.len()),
            neighbors: Vec::with_capacity(self.neighbors.len() + new.neighbors.len()),
        };
        all.offsets.push(0);
        for (v, &rank) in dirty.rank.iter().enumerate() {
            let row = if rank == CLEAN { self.of(v) } else { new.of(rank as usize) };
            all.neighbors.extend_from_slice(row);
            all.offsets.push(all.neighbors.len() as u32);
        }
        all
    }
}

impl Delaunay {
    /// The edges of the triangulation between finite vertices, by vertex. Linear in the number of tets.
    pub fn adjacency(&self) -> Adjacency {
        all_rows(&self.vertices, self.points.len())
    }
}

/// The neighbours of the first `count` vertices among themselves.
fn all_rows(tets: &[[u32; 4]], count: usize) -> Adjacency {
    let all: Vec<u32> = (0..count as u32).collect();
    rows(tets, count, &all, |v| v)
}

/// The neighbours of the vertices `wanted` among the first `count`, to which they belong. `rank` is the place of a vertex in that list, or
/// [`CLEAN`] where it is not in it; `tets` are all that have any of them.
fn rows(tets: &[[u32; 4]], count: usize, wanted: &[u32], rank: impl Fn(u32) -> u32) -> Adjacency {
    // 1. The tets at each of them, by counting; all others go to one more place, which is cheaper than to tell them apart.
    let others = wanted.len() as u32;
    let rank = |v: u32| if v as usize >= count { others } else { rank(v).min(others) } as usize;
    let mut ends = vec![0u32; wanted.len() + 2];
    tets.iter().flatten().for_each(|&v| ends[rank(v) + 1] += 1);
    prefix_sums(&mut ends);
    // From where the tets of each begin to where they end.
    let mut tets_at = vec![0u32; 4 * tets.len()];
    for (t, tet) in tets.iter().enumerate() {
        for r in tet.map(rank) {
            tets_at[ends[r] as usize] = t as u32;
            ends[r] += 1;
        }
    }
    // 2. The neighbours of each, once each.
    let of_block = |seen: &mut Vec<u32>, block: usize| {
        let (mut row_ends, mut met, mut row) = (Vec::with_capacity(ROWS), Vec::with_capacity(20 * ROWS), Vec::new());
        for r in block * ROWS..((block + 1) * ROWS).min(wanted.len()) {
            let begin = if r == 0 { 0 } else { ends[r - 1] };
            let around = &tets_at[begin as usize..ends[r] as usize];
            row.resize((4 * around.len() + 1).max(row.len()), 0);
            let mark = r as u32;
            (seen[wanted[r] as usize], seen[count]) = (mark, mark);
            let mut found = 0;
            for &w in around.iter().flat_map(|&t| &tets[t as usize]) {
                // Whether a vertex is new is hard to predict: write it in any case.
                let place = (w as usize).min(count);
                row[found] = w;
                found += usize::from(seen[place] != mark);
                seen[place] = mark;
            }
            row[..found].sort_unstable();
            met.extend_from_slice(&row[..found]);
            row_ends.push(met.len() as u32);
        }
        (row_ends, met)
    };
    let blocks: Vec<(Vec<u32>, Vec<u32>)> =
        (0..wanted.len().div_ceil(ROWS)).into_par_iter().map_init(|| vec![CLEAN; count + 1], of_block).collect();
    // 3. One after another.
    let mut all = Adjacency { offsets: Vec::with_capacity(wanted.len() + 1), neighbors: Vec::new() };
    all.offsets.push(0);
    all.neighbors.reserve_exact(blocks.iter().map(|b| b.1.len()).sum());
    for (row_ends, met) in blocks {
        let before = all.neighbors.len() as u32;
        all.offsets.extend(row_ends.into_iter().map(|end| before + end));
        all.neighbors.extend_from_slice(&met);
    }
    all
}

/// Turns counts, each one place late, into starts.
fn prefix_sums(counts: &mut [u32]) {
    let mut sum = 0;
    for c in counts {
        sum += *c;
        *c = sum;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::frame::snap;
    use crate::rng::Rng;

    #[test]
    fn what_is_followed_is_what_is_found_anew() {
        let mut rng = Rng::new(8, 0);
        let mut points: Vec<DVec3> = (0..3000).map(|_| snap(rng.in_cube())).collect();
        let mut delaunay = Delaunay::build(&points).expect("distinct points");
        let mut follower = Follower::default();
        // All points, and all but the last ones, which then are nobody's neighbours.
        for count in [points.len(), points.len() - 400] {
            let mut in_part = 0;
            for round in 0..30 {
                // Now few points move, and now many.
                let (many, far) = ([3000, 30, 3][round % 3], if round < 15 { 1e-3 } else { 0.05 });
                for p in points.iter_mut().take(many) {
                    *p = snap(*p + rng.in_cube() * far);
                }
                delaunay.relocate(&points).expect("distinct points");
                let known = follower.adjacency.offsets.len() == count + 1;
                in_part += usize::from(known && follower.dirty(delaunay.vertices(), count).is_some());
                let expected = all_rows(delaunay.vertices(), count);
                assert_eq!(*follower.follow(&delaunay, count), expected, "{count} of them, round {round}");
                if count == points.len() {
                    assert_eq!(expected, delaunay.adjacency());
                }
            }
            assert!(in_part >= 10, "{in_part} rounds were followed in part");
        }
    }
}
