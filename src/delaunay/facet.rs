//! A facet of a tet, in one word.

use std::fmt;

/// Stands for the infinite vertex in the tets of the hull.
pub const INFINITE: u32 = u32::MAX;

/// Facet `slot` of tet `tet`: the one opposite the tet's vertex `slot`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct Facet(u32);

impl Facet {
    /// Tets are numbered below this, so that tet and slot fit one word.
    pub const MAX_TETS: usize = 1 << 30;

    /// Facet `slot` (below 4) of tet `tet` (below [`Facet::MAX_TETS`]).
    #[inline]
    pub fn new(tet: u32, slot: usize) -> Facet {
        debug_assert!(slot < 4 && (tet as usize) < Facet::MAX_TETS);
        Facet(tet << 2 | slot as u32)
    }

    /// The tet.
    #[inline]
    pub fn tet(self) -> u32 {
        self.0 >> 2
    }

    /// The slot of the vertex opposite the facet.
    #[inline]
    pub fn slot(self) -> usize {
        (self.0 & 3) as usize
    }
}

impl fmt::Debug for Facet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.tet(), self.slot())
    }
}

/// For each slot i, the three others as (j, k, l), where (i, j, k, l) is an even permutation of (0, 1, 2, 3).
///
/// ```text
///          i            Seen from i, the facet opposite i of a positive tet is walked through j, k, l so that
///         /|\           (i, j, k, l) is again a positive tet. A tet across the facet {i, k, l} walks the
///        / | \          edge k, l the other way: (i, j', l, k).
///       j--+--l
///        \ | /
///          k
/// ```
pub const OTHERS: [[(usize, usize, usize); 3]; 4] = [
    [(1, 2, 3), (2, 3, 1), (3, 1, 2)],
    [(0, 3, 2), (3, 2, 0), (2, 0, 3)],
    [(0, 1, 3), (1, 3, 0), (3, 0, 1)],
    [(0, 2, 1), (2, 1, 0), (1, 0, 2)],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_keeps_tet_and_slot() {
        for tet in [0, 1, 12345, (1 << 30) - 1] {
            for slot in 0..4 {
                let facet = Facet::new(tet, slot);
                assert_eq!((facet.tet(), facet.slot()), (tet, slot));
            }
        }
    }

    #[test]
    fn the_others_are_even_permutations() {
        for i in 0..4 {
            for (j, k, l) in OTHERS[i] {
                let p = [i, j, k, l];
                let inversions = (0..4).flat_map(|a| (a + 1..4).map(move |b| (a, b))).filter(|&(a, b)| p[a] > p[b]);
                assert_eq!(inversions.count() % 2, 0, "{p:?}");
                let mut sorted = p;
                sorted.sort_unstable();
                assert_eq!(sorted, [0, 1, 2, 3]);
            }
        }
    }
}
