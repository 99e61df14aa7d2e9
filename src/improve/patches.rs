//! Smooth parts of the surface that are too small for facets of their own.
//!
//! The noise of a scan, or a chamfer finer than the spacing, cuts parts off the surface that are smaller than a few facets.
//! Facets there cannot keep to one part; so each of these counts as one with the neighbour that it has the longest border
//! with, the smallest first. Creases between them stay where they keep no tet below the floor.

use std::collections::BTreeMap;

use crate::disjoint_sets::DisjointSets;
use crate::geometry::triangle;
use crate::surface::edges;
use crate::surface::features::Features;
use crate::surface::walk::Walk;

/// A part is small if it has less than so many facets' area.
const SMALL: f64 = 4.0;

/// The part of each triangle of the surface, once small ones are joined to their neighbours; `facets` is the number of
/// facets of the boundary.
pub(super) fn joined(Walk { surface, twin }: Walk, features: &Features, facets: usize) -> Vec<u32> {
    let small = SMALL * surface.area() / facets.max(1) as f64;
    let count = features.face.iter().max().map_or(0, |&f| f as usize + 1);
    let mut area = vec![0.0; count];
    let mut border: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for (t, &face) in (0..).zip(&features.face) {
        let corners = surface.corners(t);
        area[face as usize] += triangle::area(corners[0], corners[1], corners[2]);
        for k in 0..3 {
            let other = features.face[edges::triangle_of(twin[3 * t as usize + k]) as usize];
            if other != face {
                let [a, b] = edges::ends(surface.triangles(), 3 * t + k as u32);
                let length = surface.points()[a as usize].distance(surface.points()[b as usize]);
                *border.entry([face, other]).or_default() += length;
            }
        }
    }
    let mut order: Vec<u32> = (0..count as u32).filter(|&f| area[f as usize] < small).collect();
    order.sort_by(|&f, &g| area[f as usize].total_cmp(&area[g as usize]).then(f.cmp(&g)));
    let mut sets = DisjointSets::new(count);
    for face in order {
        let root = sets.find(face);
        if area[root as usize] >= small {
            continue;
        }
        let mut shared: BTreeMap<u32, f64> = BTreeMap::new();
        for (&[f, other], &length) in &border {
            let neighbor = sets.find(other);
            if sets.find(f) == root && neighbor != root {
                *shared.entry(neighbor).or_default() += length;
            }
        }
        let longest = shared.into_iter().fold((root, 0.0), |most, s| if s.1 > most.1 { s } else { most }).0;
        let whole = area[root as usize] + area[longest as usize];
        sets.join(root, longest);
        let joined = sets.find(root);
        area[joined as usize] = if longest == root { area[root as usize] } else { whole };
    }
    features.face.iter().map(|&f| sets.find(f)).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::surface::Surface;

    #[test]
    fn a_part_joins_the_neighbor_along_its_longest_border() {
        // A box 1 x 1 x 0.1: its two large sides are the only ones that are not small beside 400 facets.
        let at = |i: u32, k: u32| f64::from(i >> k & 1);
        let points: Vec<DVec3> = (0..8).map(|i| DVec3::new(at(i, 0), at(i, 1), 0.1 * at(i, 2))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let each: Vec<u32> = (0..12).collect();
        let surface = Surface::new(&points, &triangles, &each, &each).expect("a closed surface");
        let features = Features::find(&surface, 40.0);
        let parts = |facets: usize| {
            let mut parts = joined(Walk::new(&surface), &features, facets);
            let own = [parts[0], parts[2]];
            parts.sort_unstable();
            parts.dedup();
            (parts.len(), own[0] == own[1])
        };
        // Areas 1, 1 and 0.1 four times; a part is small below 4 x 2.4 / facets.
        assert_eq!(parts(400), (6, false));
        assert_eq!(parts(60), (2, false));
        assert_eq!(parts(1).0, 1);
    }
}
