//! Which vertices are Delaunay neighbours of which.

use std::sync::Arc;

use rayon::prelude::*;

use super::Delaunay;

/// Tets in a block of a pass over all of them.
const BLOCK: usize = 8192;

/// Vertices in a block.
const ROWS: usize = 1024;

/// If more than one in so many tets is new, all is built anew.
const MANY: usize = 2;

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
///
/// An edge of a tet that is gone belongs to one that is new, or to none: where tets are replaced, those beside them, which stay,
/// share facets with both. So the tets that come and go say all.
#[derive(Default)]
pub struct Follower {
    adjacency: Arc<Adjacency>,
    /// The tets that it belongs to.
    vertices: Vec<[u32; 4]>,
}

impl Follower {
    /// The same as [`Delaunay::adjacency`], of the first `count` vertices among themselves.
    pub fn follow(&mut self, delaunay: &Delaunay, count: usize) -> &Arc<Adjacency> {
        let new = delaunay.vertices();
        let places = places_that_differ(&self.vertices, new);
        if self.adjacency.offsets.len() == count + 1 && places.len() * MANY <= new.len() {
            let changes = self.changes(new, &places, count);
            if !changes.dirty.is_empty() {
                self.adjacency = Arc::new(self.adjacency.with(&changes));
            }
            self.vertices.resize(new.len(), [0; 4]);
            places.into_iter().filter(|&t| t < new.len()).for_each(|t| self.vertices[t] = new[t]);
        } else {
            self.adjacency = Arc::new(all_rows(new, count));
            self.vertices.clear();
            self.vertices.extend_from_slice(new);
        }
        &self.adjacency
    }

    /// What changed with the tets at some places.
    fn changes(&self, new: &[[u32; 4]], places: &[usize], count: usize) -> Changes {
        let at = |tets: &[[u32; 4]]| places.iter().filter_map(|&t| tets.get(t)).copied().collect();
        let (gone, come) = (at(&self.vertices), at(new));
        let mut changes = Changes { gone, come, rank: vec![CLEAN; count], dirty: Vec::new() };
        changes.rank_vertices();
        changes
    }
}

/// The places at which two lists of tets have not the same, those beyond the end of one among them.
fn places_that_differ(old: &[[u32; 4]], new: &[[u32; 4]]) -> Vec<usize> {
    let common = old.len().min(new.len());
    let blocks = old[..common].par_chunks(BLOCK).zip(new[..common].par_chunks(BLOCK)).enumerate();
    let mut places: Vec<Vec<usize>> = blocks
        .map(|(block, (old, new))| {
            let pairs = (block * BLOCK..).zip(old.iter().zip(new));
            pairs.filter(|(_, (a, b))| a != b).map(|(t, _)| t).collect()
        })
        .collect();
    places.push((common..old.len().max(new.len())).collect());
    places.concat()
}

/// Rank of a vertex whose tets are the same as before.
const CLEAN: u32 = u32::MAX;

/// What became of the tets.
struct Changes {
    /// Those that there were, and those that are in their stead.
    gone: Vec<[u32; 4]>,
    come: Vec<[u32; 4]>,
    /// For each vertex, its place among those whose neighbours may have changed.
    rank: Vec<u32>,
    dirty: Vec<u32>,
}

impl Changes {
    /// Finds these vertices.
    fn rank_vertices(&mut self) {
        let Changes { gone, come, rank, dirty } = self;
        for &v in gone.iter().chain(come.iter()).flatten() {
            if (v as usize) < rank.len() && rank[v as usize] == CLEAN {
                rank[v as usize] = dirty.len() as u32;
                dirty.push(v);
            }
        }
    }
}

impl Adjacency {
    /// A copy that follows some changes.
    fn with(&self, changes: &Changes) -> Adjacency {
        let Changes { gone, come, rank, dirty } = changes;
        // 1. At vertices where tets changed, the neighbours that are in none that is gone, and those in tets that have come.
        let of = |tets| rows(tets, rank.len(), dirty, |v| rank[v as usize]);
        let (gone, come) = rayon::join(|| of(gone), || of(come));
        // 2. All rows, one after another.
        let of_block = |(block, ranks): (usize, &[u32])| {
            let (mut row_ends, mut met) = (Vec::with_capacity(ROWS), Vec::with_capacity(20 * ROWS));
            for (v, &rank) in (block * ROWS..).zip(ranks) {
                match rank {
                    CLEAN => met.extend_from_slice(self.of(v)),
                    rank => append_changed(&mut met, self.of(v), gone.of(rank as usize), come.of(rank as usize)),
                }
                row_ends.push(met.len() as u32);
            }
            (row_ends, met)
        };
        joined(rank.par_chunks(ROWS).enumerate().map(of_block).collect())
    }
}

/// Appends those of `row` that are not `gone`, and those that have `come`, which are none of the others; all ascending.
fn append_changed(met: &mut Vec<u32>, row: &[u32], gone: &[u32], come: &[u32]) {
    let (mut gone, mut come) = (gone.iter().peekable(), come.iter().peekable());
    for &w in row {
        while let Some(&before) = come.next_if(|&&c| c < w) {
            met.push(before);
        }
        if gone.next_if_eq(&&w).is_none() {
            met.push(w);
        }
    }
    met.extend(come);
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
    joined(blocks)
}

/// The rows of blocks, each where its rows end, one after another.
fn joined(blocks: Vec<(Vec<u32>, Vec<u32>)>) -> Adjacency {
    let mut all = Adjacency {
        offsets: Vec::with_capacity(blocks.iter().map(|b| b.0.len()).sum::<usize>() + 1),
        neighbors: Vec::new(),
    };
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
                let places = places_that_differ(&follower.vertices, delaunay.vertices()).len();
                in_part += usize::from(known && places * MANY <= delaunay.vertices().len());
                let expected = all_rows(delaunay.vertices(), count);
                assert_eq!(**follower.follow(&delaunay, count), expected, "{count} of them, round {round}");
                if count == points.len() {
                    assert_eq!(expected, delaunay.adjacency());
                }
            }
            assert!(in_part >= 10, "{in_part} rounds were followed in part");
        }
    }
}
