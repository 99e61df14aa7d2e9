//! Which bisectors of a seed can cut a triangle: all of its neighbours against many triangles at once, in vectors.
//!
//! With the seed as origin, the neighbour at e is farther from y than the seed where |e|² - 2 e.y > 0. Nearly all neighbours
//! are farther from all of a triangle by a wide margin, and are done with here; the few that are left go on to the exact signs
//! of `bisector.rs`.

use glam::DVec3;

/// Neighbours that are tested at once.
const LANES: usize = 8;

/// Neighbours whose answers share a word.
const BITS: usize = 64;

/// Above this a value has its sign: differences of points on the frame's grid are exact and below 2 in size, so the two sums
/// are below 12 and 24, each with 3 rounding units of that, and their difference adds 36.
const SURE: f64 = 160.0 * f64::EPSILON / 2.0;

/// The bisectors of one seed.
#[derive(Default)]
pub(super) struct Planes {
    /// For eight neighbours: x, y and z of twice the way to each, and its squared length.
    blocks: Vec<[[f64; LANES]; 4]>,
}

/// The neighbours, by their place in the list, of which it is not certain that they are farther than the seed.
pub(super) struct Doubtful<'a> {
    words: &'a [u64],
    word: usize,
    rest: u64,
}

impl Planes {
    /// Makes these the bisectors of `seed` and `neighbors`.
    pub(super) fn set(&mut self, seed: DVec3, neighbors: &[u32], points: &[DVec3]) {
        self.blocks.clear();
        for eight in neighbors.chunks(LANES) {
            // Lanes without a neighbour have one that is infinitely far.
            let mut block = [0.0, 0.0, 0.0, f64::INFINITY].map(|x| [x; LANES]);
            for (l, &k) in eight.iter().enumerate() {
                let e = points[k as usize] - seed;
                block[0][l] = 2.0 * e.x;
                block[1][l] = 2.0 * e.y;
                block[2][l] = 2.0 * e.z;
                block[3][l] = e.length_squared();
            }
            self.blocks.push(block);
        }
    }

    /// Words that hold the answers for one triangle.
    fn words(&self) -> usize {
        (self.blocks.len() * LANES).div_ceil(BITS)
    }

    /// Tests triangles, given relative to the seed; appends the answers to `words`.
    pub(super) fn test(&self, arch: pulp::Arch, triangles: &[[DVec3; 3]], words: &mut Vec<u64>) {
        arch.dispatch(Test { blocks: &self.blocks, triangles, words });
    }

    /// The doubtful neighbours for triangle `n` of those tested.
    pub(super) fn doubtful<'a>(&self, words: &'a [u64], n: usize) -> Doubtful<'a> {
        let count = self.words();
        let words = &words[n * count..(n + 1) * count];
        Doubtful { words, word: 0, rest: words.first().copied().unwrap_or(0) }
    }
}

impl Iterator for Doubtful<'_> {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        while self.rest == 0 {
            self.word += 1;
            self.rest = *self.words.get(self.word)?;
        }
        let bit = self.rest.trailing_zeros() as usize;
        self.rest &= self.rest - 1;
        // A byte for each lane, a bit of it for each block.
        Some(self.word * BITS + (bit % 8) * LANES + bit / 8)
    }
}

/// Compiled for each width of vectors; the operations, and so the answers, are the same in each.
struct Test<'a> {
    blocks: &'a [[[f64; LANES]; 4]],
    triangles: &'a [[DVec3; 3]],
    words: &'a mut Vec<u64>,
}

impl pulp::WithSimd for Test<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for [a, b, c] in self.triangles {
            for eight in self.blocks.chunks(BITS / LANES) {
                let mut doubts = [0u64; LANES];
                for (bit, [x, y, z, length2]) in eight.iter().enumerate() {
                    for l in 0..LANES {
                        let value = |p: &DVec3| length2[l] - (x[l] * p.x + y[l] * p.y + z[l] * p.z);
                        let (at_a, at_b, at_c) = (value(a), value(b), value(c));
                        let least = if at_a < at_b { at_a } else { at_b };
                        let least = if least < at_c { least } else { at_c };
                        doubts[l] |= if least > SURE { 0 } else { 1 << bit };
                    }
                }
                let mut word = 0;
                for (l, doubt) in doubts.iter().enumerate() {
                    word |= doubt << (8 * l);
                }
                self.words.push(word);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn the_doubtful_are_those_that_are_nearer_to_a_corner() {
        let mut rng = Rng::new(3, 0);
        let mut point = |size: f64| DVec3::from_array([0; 3].map(|_| (rng.unit() - 0.5) * size));
        for count in [1, 7, 8, 9, 63, 64, 65, 200] {
            let seed = point(0.1);
            let points: Vec<DVec3> = (0..count).map(|_| point(0.5)).collect();
            let neighbors: Vec<u32> = (0..count as u32).collect();
            let triangles: Vec<[DVec3; 3]> = (0..20).map(|_| [0; 3].map(|_| point(0.5))).collect();
            let mut planes = Planes::default();
            planes.set(seed, &neighbors, &points);
            let mut words = Vec::new();
            let relative: Vec<_> = triangles.iter().map(|t| t.map(|p| p - seed)).collect();
            planes.test(pulp::Arch::new(), &relative, &mut words);
            for (n, triangle) in triangles.iter().enumerate() {
                let mut found: Vec<usize> = planes.doubtful(&words, n).collect();
                found.sort_unstable();
                let nearer = |k: &usize| triangle.iter().any(|p| p.distance(points[*k]) < p.distance(seed));
                let expected: Vec<usize> = (0..count).filter(nearer).collect();
                assert_eq!(found, expected);
            }
        }
    }
}
