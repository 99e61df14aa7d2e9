//! Where Voronoi edges cross the surface, by their dual facets.

use super::Crossing;

/// The vertices of facet f of a tet, in the order in which the tet's vertex f is on the side that
/// (q - p) x (r - p) points to.
pub(super) const FACET: [[usize; 3]; 4] = [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]];

/// The crossings, by facet.
pub(super) struct Crossings<'a> {
    all: &'a [Crossing],
    /// The facets that have any, ascending.
    facets: Vec<CrossedFacet>,
    /// Whether a seed is a vertex of any of these.
    touched: Vec<bool>,
}

/// A facet whose dual edge crosses the surface.
#[derive(Clone, Copy)]
pub(super) struct CrossedFacet {
    /// Its vertices (p, q, r), ascending.
    pub(super) vertices: [u32; 3],
    /// Where its crossings begin.
    pub(super) first: u32,
    /// What the winding changes by along (q - p) x (r - p), over all of them.
    pub(super) entered: i32,
}

impl<'a> Crossings<'a> {
    /// Crossings sorted by facet, over so many seeds.
    pub(super) fn new(all: &'a [Crossing], seeds: usize) -> Crossings<'a> {
        let mut facets: Vec<CrossedFacet> = Vec::with_capacity(all.len());
        let mut touched = vec![false; seeds];
        for (first, &Crossing { facet, leaves, .. }) in (0..).zip(all) {
            let entered = if leaves { -1 } else { 1 };
            match facets.last_mut() {
                Some(last) if last.vertices == facet => last.entered += entered,
                _ => {
                    facet.iter().for_each(|&v| touched[v as usize] = true);
                    facets.push(CrossedFacet { vertices: facet, first, entered });
                }
            }
        }
        Crossings { all, facets, touched }
    }

    /// The facets that have any.
    pub(super) fn facets(&self) -> &[CrossedFacet] {
        &self.facets
    }

    /// The crossings of the Voronoi edge dual to the facet (p, q, r), which begin at `first`, and whether (p, q, r) is an even
    /// permutation of the ascending order that their `leaves` speaks of.
    pub(super) fn from(&self, first: u32, facet: [u32; 3]) -> (&'a [Crossing], bool) {
        let found = &self.all[first as usize..];
        let count = found.iter().position(|c| c.facet != found[0].facet).unwrap_or(found.len());
        (&found[..count], is_even(facet))
    }

    /// Whether the surface crosses any Voronoi edge of seed `v`; no for the infinite vertex.
    pub(super) fn touches(&self, v: u32) -> bool {
        self.touched.get(v as usize) == Some(&true)
    }
}

/// Finds facets among some by their vertices.
pub(super) struct Finder<'a> {
    facets: &'a [CrossedFacet],
    /// Which facet is at the place that its vertices hash to or at the next that was free.
    table: Vec<u32>,
}

/// A place of the table where there is nothing.
const EMPTY: u32 = u32::MAX;

impl<'a> Finder<'a> {
    /// Finds those of `facets` that `wanted` numbers.
    pub(super) fn new(facets: &'a [CrossedFacet], wanted: impl ExactSizeIterator<Item = u32>) -> Finder<'a> {
        let mut table = vec![EMPTY; (4 * wanted.len()).next_power_of_two()];
        for n in wanted {
            let mut place = hash(facets[n as usize].vertices) & (table.len() - 1);
            while table[place] != EMPTY {
                place = (place + 1) & (table.len() - 1);
            }
            table[place] = n;
        }
        Finder { facets, table }
    }

    /// The number of the facet with such vertices.
    #[inline]
    pub(super) fn find(&self, facet: [u32; 3]) -> Option<u32> {
        let vertices = ascending(facet);
        let mut place = hash(vertices) & (self.table.len() - 1);
        loop {
            match self.table[place] {
                EMPTY => return None,
                n if self.facets[n as usize].vertices == vertices => return Some(n),
                _ => place = (place + 1) & (self.table.len() - 1),
            }
        }
    }
}

/// The vertices of a facet in ascending order.
#[inline]
pub(super) fn ascending([p, q, r]: [u32; 3]) -> [u32; 3] {
    let (low, high) = (p.min(q), p.max(q));
    [low.min(r), low.max(r).min(high), high.max(r)]
}

/// Whether three vertices are an even permutation of themselves in ascending order.
#[inline]
pub(super) fn is_even([p, q, r]: [u32; 3]) -> bool {
    (p < q) as u8 + (q < r) as u8 + (r < p) as u8 == 2
}

/// Spreads the vertices of a facet over the words.
fn hash([p, q, r]: [u32; 3]) -> usize {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    let mixed = (u64::from(p) ^ u64::from(q).rotate_left(21) ^ u64::from(r).rotate_left(42)).wrapping_mul(ODD);
    (mixed ^ mixed >> 32).wrapping_mul(ODD).wrapping_shr(32) as usize
}
