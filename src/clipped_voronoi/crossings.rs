//! Where Voronoi edges cross the surface, found by their dual facets.

use super::Crossing;

/// A place of the table where there is nothing.
const EMPTY: u32 = u32::MAX;

/// The vertices of facet f of a tet, in the order in which the tet's vertex f is on the side that
/// (q - p) x (r - p) points to.
pub(super) const FACET: [[usize; 3]; 4] = [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]];

/// The crossings, found by facet.
pub(super) struct Crossings<'a> {
    all: &'a [Crossing],
    /// Where the crossings of a facet begin, at the place that its vertices hash to or at the next that was free.
    table: Vec<u32>,
    /// Whether a seed is a vertex of any facet that has crossings.
    touched: Vec<bool>,
}

impl<'a> Crossings<'a> {
    /// Crossings sorted by facet, over so many seeds.
    pub(super) fn new(all: &'a [Crossing], seeds: usize) -> Crossings<'a> {
        let mut table = vec![EMPTY; (4 * all.len()).next_power_of_two()];
        let mut touched = vec![false; seeds];
        let mut last = None;
        for (n, crossing) in all.iter().enumerate() {
            let facet = crossing.facet;
            if last == Some(facet) {
                continue;
            }
            last = Some(facet);
            facet.iter().for_each(|&v| touched[v as usize] = true);
            let mut place = hash(facet) & (table.len() - 1);
            while table[place] != EMPTY {
                place = (place + 1) & (table.len() - 1);
            }
            table[place] = n as u32;
        }
        Crossings { all, table, touched }
    }

    /// The crossings of the Voronoi edge dual to the facet (p, q, r), and whether (p, q, r) is an even permutation of
    /// the ascending order that their `leaves` speaks of.
    pub(super) fn of(&self, facet: [u32; 3]) -> (&'a [Crossing], bool) {
        self.first_of(facet).map_or((&[], true), |first| self.from(first, facet))
    }

    /// Where those of a facet begin.
    #[inline]
    fn first_of(&self, [p, q, r]: [u32; 3]) -> Option<u32> {
        let (low, high) = (p.min(q), p.max(q));
        let facet = [low.min(r), low.max(r).min(high), high.max(r)];
        let mut place = hash(facet) & (self.table.len() - 1);
        loop {
            match self.table[place] {
                EMPTY => return None,
                first if self.all[first as usize].facet == facet => return Some(first),
                _ => place = (place + 1) & (self.table.len() - 1),
            }
        }
    }

    /// What [`Crossings::of`] says of a facet whose crossings begin at `first`.
    pub(super) fn from(&self, first: u32, [p, q, r]: [u32; 3]) -> (&'a [Crossing], bool) {
        let found = &self.all[first as usize..];
        let count = found.iter().position(|c| c.facet != found[0].facet).unwrap_or(found.len());
        (&found[..count], (p < q) as u8 + (q < r) as u8 + (r < p) as u8 == 2)
    }

    /// Whether the surface crosses any Voronoi edge of seed `v`; no for the infinite vertex.
    pub(super) fn touches(&self, v: u32) -> bool {
        self.touched.get(v as usize) == Some(&true)
    }

    /// For each facet of a tet whose dual edge crosses the surface, where its crossings begin.
    pub(super) fn of_tet(&self, tet: &[u32; 4]) -> [Option<u32>; 4] {
        let touched = tet.map(|v| self.touches(v));
        FACET.map(|corners| {
            let is_touched = corners.iter().all(|&v| touched[v]);
            is_touched.then(|| self.first_of(corners.map(|v| tet[v]))).flatten()
        })
    }

    /// What the winding changes by along (q - p) x (r - p), over all crossings of the edge dual to the facet (p, q, r).
    pub(super) fn entered(&self, facet: [u32; 3]) -> i32 {
        entered(self.of(facet))
    }
}

/// The same for what was [found](Crossings::of).
pub(super) fn entered((found, even): (&[Crossing], bool)) -> i32 {
    found.iter().map(|c| if c.leaves == even { -1 } else { 1 }).sum()
}

/// Spreads the vertices of a facet over the words.
fn hash([p, q, r]: [u32; 3]) -> usize {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    let mixed = (u64::from(p) ^ u64::from(q).rotate_left(21) ^ u64::from(r).rotate_left(42)).wrapping_mul(ODD);
    (mixed ^ mixed >> 32).wrapping_mul(ODD).wrapping_shr(32) as usize
}
