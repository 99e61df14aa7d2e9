//! Volume, area and genus.

use glam::DVec3;

use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::tetrahedron::volume6;
use crate::geometry::triangle;

/// A sum of f64 that keeps what rounding takes from it (A. Neumaier, "Rundungsfehleranalyse einiger Verfahren zur
/// Summation endlicher Summen", ZAMM 54, 1974, doi 10.1002/zamm.19740540106).
#[derive(Clone, Copy, Default)]
pub(super) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    /// Adds a term.
    pub fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        self.lost += if self.sum.abs() >= x.abs() { (self.sum - sum) + x } else { (x - sum) + self.sum };
        self.sum = sum;
    }

    /// The sum.
    pub fn value(self) -> f64 {
        self.sum + self.lost
    }
}

/// What a shell encloses.
pub(super) struct Volume {
    /// Signed, positive when its triangles face outward.
    pub signed: f64,
    /// Sum of the sizes of its terms.
    size: f64,
}

impl Volume {
    /// Whether rounding hides the sign: 16 times the rounding of the terms.
    pub fn is_nothing(&self) -> bool {
        self.signed.abs() <= 16.0 * f64::EPSILON * self.size
    }
}

/// The volume of each of the `count` shells, from the tets between its triangles and the centre of its box.
pub(super) fn shell_volumes(points: &[DVec3], triangles: &[[u32; 3]], shell: &[u32], count: usize) -> Vec<Volume> {
    let mut bounds = vec![BoundingBox::EMPTY; count];
    for (t, &s) in triangles.iter().zip(shell) {
        let b = &mut bounds[s as usize];
        *b = t.iter().fold(*b, |b, &v| b.with(points[v as usize]));
    }
    let mut sums = vec![(Sum::default(), Sum::default()); count];
    for (t, &s) in triangles.iter().zip(shell) {
        let [a, b, c] = t.map(|v| points[v as usize]);
        let v = volume6(bounds[s as usize].center(), a, b, c);
        sums[s as usize].0.add(v);
        sums[s as usize].1.add(v.abs());
    }
    sums.iter().map(|(v, size)| Volume { signed: v.value() / 6.0, size: size.value() / 6.0 }).collect()
}

/// Area of the triangles.
pub(super) fn area(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let mut sum = Sum::default();
    for t in triangles {
        let [a, b, c] = t.map(|v| points[v as usize]);
        sum.add(triangle::area(a, b, c));
    }
    sum.value()
}

/// Number of handles of all shells together, by Euler's formula; each edge has two triangles.
pub(super) fn genus(vertices: usize, triangles: usize, shells: usize) -> usize {
    // Sum over the shells of V - E + F = 2 - 2 g, with E = 3 F / 2.
    let doubled = 2 * shells + triangles / 2;
    assert!(doubled >= vertices, "shells are closed and manifold: this is a bug in tetcvt");
    (doubled - vertices) / 2
}
