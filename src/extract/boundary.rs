//! The facets between inside and outside, their components, and the regions behind them.

use super::complex::Complex;
use crate::disjoint_sets::DisjointSets;
use crate::surface::{Surface, edges};

/// The facets between tets inside and tets outside.
pub struct Boundary {
    /// For each the tet inside, ascending.
    pub tets: Vec<u32>,
    /// For each the tet outside.
    pub beyond: Vec<u32>,
    /// For each its vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// For each its component: triangles that share an edge share a component.
    pub component: Vec<u32>,
    /// For each component its Euler characteristic; means something where the boundary is manifold.
    pub euler: Vec<i64>,
}

impl Boundary {
    /// Collects the boundary of the tets labelled `inside`.
    pub fn of(complex: &Complex, inside: &[bool]) -> Boundary {
        let mut tets = Vec::new();
        let mut beyond = Vec::new();
        let mut triangles = Vec::new();
        for t in (0..inside.len()).filter(|&t| inside[t]) {
            for i in 0..4 {
                let across = complex.neighbors[t][i].tet();
                if !inside[across as usize] {
                    tets.push(t as u32);
                    beyond.push(across);
                    triangles.push(complex.facet(t as u32, i));
                }
            }
        }
        let (component, count) = components(&triangles);
        let euler = euler_characteristics(complex.points.len(), &triangles, &component, count);
        Boundary { tets, beyond, triangles, component, euler }
    }

    /// Number of components.
    pub fn components(&self) -> usize {
        self.euler.len()
    }
}

/// The component of each triangle, and how many there are.
pub(crate) fn components(triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(triangles.len());
    for pair in edges::sorted(triangles).windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        sets.join(edges::triangle_of(pair[0].1), edges::triangle_of(pair[1].1));
    }
    sets.number()
}

/// V - E + F of each component of a closed manifold surface.
fn euler_characteristics(points: usize, triangles: &[[u32; 3]], component: &[u32], count: usize) -> Vec<i64> {
    // Each vertex belongs to one component, and each component has 3F/2 edges.
    let mut seen = vec![false; points];
    let mut twice = vec![0i64; count];
    for (triangle, &c) in triangles.iter().zip(component) {
        twice[c as usize] -= 1;
        for &v in triangle {
            if !std::mem::replace(&mut seen[v as usize], true) {
                twice[c as usize] += 2;
            }
        }
    }
    // The number of triangles is even where every edge has two.
    twice.into_iter().map(|x| x.div_euclid(2)).collect()
}

/// The Euler characteristic of each shell of the surface.
pub fn shell_euler(surface: &Surface) -> Vec<i64> {
    let shells = surface.shell_count();
    euler_characteristics(surface.points().len(), surface.triangles(), surface.shell(), shells)
}

/// The tets outside that the tets inside shut off from infinity.
pub fn enclosed(complex: &Complex, inside: &[bool]) -> Vec<bool> {
    let mut enclosed: Vec<bool> = inside.iter().map(|i| !i).collect();
    let is_infinite = |t: &usize| complex.tets[*t].iter().any(|&v| v as usize >= complex.seeds);
    let mut stack: Vec<u32> = (0..inside.len()).filter(is_infinite).map(|t| t as u32).collect();
    stack.iter().for_each(|&t| enclosed[t as usize] = false);
    while let Some(t) = stack.pop() {
        for n in complex.around(t) {
            if std::mem::replace(&mut enclosed[n as usize], false) {
                stack.push(n);
            }
        }
    }
    enclosed
}

/// Stands for "outside" in [`regions`].
pub const OUTSIDE: u32 = u32::MAX;

/// For each tet inside the number of its region: tets that share a facet share a region; and how many there are.
pub fn regions(complex: &Complex, inside: &[bool]) -> (Vec<u32>, usize) {
    let mut region = vec![OUTSIDE; inside.len()];
    let mut stack = Vec::new();
    let mut count = 0;
    for start in 0..inside.len() {
        if !inside[start] || region[start] != OUTSIDE {
            continue;
        }
        region[start] = count;
        stack.push(start as u32);
        while let Some(t) = stack.pop() {
            for n in complex.around(t) {
                if inside[n as usize] && region[n as usize] == OUTSIDE {
                    region[n as usize] = count;
                    stack.push(n);
                }
            }
        }
        count += 1;
    }
    (region, count as usize)
}
