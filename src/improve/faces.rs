//! Multi-face removal: facets sandwiched between two vertices give way to tets around the edge between these.
//!
//! J. R. Shewchuk, *Two Discrete Optimization Algorithms for the Topological Improvement of Tetrahedral Meshes*, 2002
//! (unpublished manuscript). One facet is a 2-3 flip. Departure: facets are sought only so many steps away from the first.

use super::change::Change;
use super::complex::Complex;
use super::measure;

/// How many edges lie at most between the first facet and another one removed with it.
const STEPS: usize = 3;

/// Works out the removal of the facet of tet `t` opposite its corner `i`, and of others sandwiched between the same two
/// vertices, if all new tets would be better than `least` and than the worst that goes.
pub(super) fn remove_faces(complex: &Complex, t: u32, i: usize, least: f64, change: &mut Change) -> bool {
    let facet = complex.facet_of(t, i);
    let Some(u) = complex.across(t, facet) else { return false };
    let (a, b) = (complex.tets[t as usize][i], complex.apex(u, facet));
    // Other parts may have an edge between vertices of the seam.
    if complex.on_seam(a) && complex.on_seam(b) {
        return false;
    }
    let least = least.max(complex.quality[t as usize].min(complex.quality[u as usize]));
    change.clear();
    change.old_tets.extend([t, u]);
    let sandwich = Sandwich { complex, apices: [a, b], least };
    let [x, y, z] = facet;
    for edge in [[x, y], [y, z], [z, x]] {
        let worst = sandwich.extend([t, u], edge, STEPS, change);
        if worst <= least {
            return false;
        }
        change.worst = change.worst.min(worst);
    }
    !complex.has_edge(a, b)
}

struct Sandwich<'a> {
    complex: &'a Complex,
    apices: [u32; 2],
    least: f64,
}

impl Sandwich<'_> {
    /// The best that can be had across an edge of the facet between two tets: the tet of that edge and the two vertices,
    /// or those of the edges beyond if the facet there goes too. Adds them to the change; returns the worst.
    fn extend(&self, [t, u]: [u32; 2], [x, y]: [u32; 2], steps: usize, change: &mut Change) -> f64 {
        let [a, b] = self.apices;
        let tet = [a, x, y, b];
        let stop = measure::quality(self.complex.corners(tet));
        if stop > self.least || steps == 0 {
            // Good enough: to take more away is seldom better.
            change.new_tets.push((tet, stop));
            return stop;
        }
        let (old, new) = (change.old_tets.len(), change.new_tets.len());
        if let (Some(t2), Some(u2)) = (self.complex.across(t, [a, x, y]), self.complex.across(u, [b, x, y])) {
            let z = self.complex.apex(t2, [a, x, y]);
            let seen = change.old_tets.contains(&t2) || change.old_tets.contains(&u2);
            if !seen && t2 != u2 && z == self.complex.apex(u2, [b, x, y]) {
                change.old_tets.extend([t2, u2]);
                let first = self.extend([t2, u2], [x, z], steps - 1, change);
                if first > self.least {
                    let second = self.extend([t2, u2], [z, y], steps - 1, change);
                    if first.min(second) > self.least {
                        return first.min(second);
                    }
                }
                change.old_tets.truncate(old);
                change.new_tets.truncate(new);
            }
        }
        change.new_tets.push((tet, stop));
        stop
    }
}
