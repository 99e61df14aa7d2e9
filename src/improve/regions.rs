//! The regions of a mesh with interfaces, found anew: tets that share a facet which is no interface share a region, and the
//! shells that a region's facets stand for say which it is.

use super::complex::{Complex, NONE};
use super::ground::Ground;
use crate::disjoint_sets::DisjointSets;

/// The regions of tets, and those on the sides of facets.
pub(super) struct Regions {
    /// For each tet; meaningless for empty slots.
    pub of_tets: Vec<u32>,
    /// For each facet the region behind it and that in front, -1 where there is none; meaningless for empty slots.
    pub of_facets: Vec<[i32; 2]>,
}

/// Finds the regions.
pub(super) fn find(complex: &Complex, ground: &Ground) -> Regions {
    let mut sets = DisjointSets::new(complex.tets.len());
    for t in (0..complex.tets.len() as u32).filter(|&t| complex.is_alive(t)) {
        for i in 0..4 {
            if let Some(u) = complex.across(t, complex.facet_of(t, i)) {
                sets.join(t, u);
            }
        }
    }
    let (part, count) = sets.number();

    let sides: Vec<[Option<u32>; 2]> = complex.facets.iter().map(|f| sides(complex, f.vertices)).collect();
    let mut shell_of_face = vec![0; ground.features.face.iter().max().map_or(0, |&f| f as usize + 1)];
    for (&face, &shell) in ground.features.face.iter().zip(ground.surface.shell()) {
        shell_of_face[face as usize] = shell;
    }
    let mut votes: Vec<(u32, i32)> = Vec::new();
    for (facet, sides) in complex.facets.iter().zip(&sides) {
        let regions = ground.surface.regions_of_shell(shell_of_face[facet.face as usize]);
        votes.extend(sides.iter().zip(regions).filter_map(|(t, region)| Some((part[(*t)? as usize], region))));
    }
    votes.sort_unstable();
    let mut region = vec![0; count];
    let mut most = vec![0; count];
    for same in votes.chunk_by(|a, b| a == b).filter(|same| same[0].1 >= 0) {
        let part = same[0].0 as usize;
        if same.len() > most[part] {
            most[part] = same.len();
            region[part] = same[0].1;
        }
    }
    let of_tet = |t: u32| region[part[t as usize] as usize];
    Regions {
        of_tets: (0..complex.tets.len() as u32).map(|t| of_tet(t) as u32).collect(),
        of_facets: sides.iter().map(|sides| sides.map(|t| t.map_or(-1, of_tet))).collect(),
    }
}

/// The tets behind a facet and in front of it.
fn sides(complex: &Complex, [x, y, z]: [u32; 3]) -> [Option<u32>; 2] {
    let mut sides = [None; 2];
    if x == NONE {
        return sides;
    }
    for &t in complex.star(x) {
        let tet = &complex.tets[t as usize];
        if !(tet.contains(&y) && tet.contains(&z)) {
            continue;
        }
        let apex = complex.apex(t, [x, y, z]);
        let at = tet.iter().position(|&v| v == apex).expect("a tet has its apex: this is a bug in tetcvt");
        let mut seen = complex.facet_of(t, at);
        let start = seen.iter().position(|&v| v == x).expect("a facet has its vertices: this is a bug in tetcvt");
        seen.rotate_left(start);
        // Seen from the tet behind it a facet turns as it does itself.
        sides[usize::from(seen != [x, y, z])] = Some(t);
    }
    sides
}
