//! The bisectors of a seed at many points of the surface, in vectors, and which of them can cut which triangle.
//!
//! Nearly all neighbours are farther from all corners of a triangle by a wide margin, and are done with here; the few that are
//! left go on to the exact signs of `bisector.rs`.

use glam::DVec3;

use super::bisector::{Bisector, Form};

/// Neighbours that are tested at once.
const LANES: usize = 8;

/// Neighbours whose answers share a word.
const BITS: usize = 64;

/// Above this a value of d has its sign: points of the frame are below 1 in size, so that the three products of differences
/// with sums of two are below 8 each, and all roundings together below 100 units.
const SURE: f64 = 160.0 * f64::EPSILON / 2.0;

/// A number of each neighbour.
type Lanes = [f64; LANES];

/// The bisectors of one seed at some points.
#[derive(Default)]
pub(super) struct Planes {
    seed: DVec3,
    neighbors: Vec<u32>,
    blocks: Vec<Block>,
    /// How far each neighbour is from the seed.
    distances: Vec<f64>,
    /// For each point, the values of d for each neighbour, and as many more as fill blocks.
    values: Vec<f64>,
    /// For each point, a bit for each neighbour that is not certain to be farther than the seed.
    doubts: Vec<u64>,
    /// How far each point is from the seed.
    reaches: Vec<f64>,
}

/// Eight neighbours; positions that are missing are infinitely far.
struct Block {
    at: [Lanes; 3],
    /// From each to the seed.
    apart: [Lanes; 3],
}

/// The bisectors of the seed on the triangle of three of the points, where few enough that their doubts share a word.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    planes: &'a Planes,
    /// Where the values of the points begin.
    rows: [usize; 3],
    doubts: [u64; 3],
    farthest: f64,
}

impl Planes {
    /// Makes these the bisectors of `seed` and `neighbors`, at points of the surface.
    pub(super) fn set(
        &mut self,
        arch: pulp::Arch,
        seed: DVec3,
        neighbors: &[u32],
        points: &[DVec3],
        at: impl Iterator<Item = DVec3>,
    ) {
        self.seed = seed;
        self.neighbors.clear();
        self.neighbors.extend_from_slice(neighbors);
        self.blocks.clear();
        self.distances.clear();
        for eight in neighbors.chunks(LANES) {
            let mut at = [[f64::INFINITY; LANES]; 3];
            for (l, &k) in eight.iter().enumerate() {
                let p = points[k as usize];
                (at[0][l], at[1][l], at[2][l]) = (p.x, p.y, p.z);
            }
            let (mut apart, mut distance) = ([[0.0; LANES]; 3], [0.0; LANES]);
            for l in 0..LANES {
                (0..3).for_each(|axis| apart[axis][l] = seed[axis] - at[axis][l]);
                let [x, y, z] = [apart[0][l], apart[1][l], apart[2][l]];
                distance[l] = (x * x + y * y + z * z).sqrt();
            }
            self.blocks.push(Block { at, apart });
            self.distances.extend_from_slice(&distance);
        }
        self.values.clear();
        self.doubts.clear();
        self.reaches.clear();
        arch.dispatch(Test { planes: self, at });
    }

    /// What is seen on the triangle of three of the points; `None` for a seed with very many neighbours.
    #[inline]
    pub(super) fn on_triangle(&self, corners: [usize; 3]) -> Option<Seen<'_>> {
        let row = self.blocks.len() * LANES;
        (row <= BITS).then(|| Seen {
            planes: self,
            rows: corners.map(|n| n * row),
            doubts: corners.map(|n| self.doubts[n]),
            farthest: self.farthest(corners),
        })
    }

    /// Sets `out` to the bisectors that may cut the triangle of three of the points.
    pub(super) fn cutting(&self, corners: [usize; 3], out: &mut Vec<Bisector>) {
        out.clear();
        let (words, row) = (self.words(), self.blocks.len() * LANES);
        let (rows, farthest) = (corners.map(|n| n * row), self.farthest(corners));
        for word in 0..words {
            let [a, b, c] = corners.map(|n| self.doubts[n * words + word]);
            for k in places(a | b | c) {
                let k = word * BITS + k;
                let at = &self.blocks[k / LANES].at;
                out.push(Bisector {
                    seed: self.neighbors[k],
                    at: DVec3::new(at[0][k % LANES], at[1][k % LANES], at[2][k % LANES]),
                    form: self.form(k, rows, farthest),
                });
            }
        }
    }

    /// The seed at place `k` of the list, and where it lies from this one.
    #[inline]
    pub(super) fn neighbor(&self, k: usize) -> (u32, DVec3) {
        let (apart, l) = (&self.blocks[k / LANES].apart, k % LANES);
        (self.neighbors[k], -DVec3::new(apart[0][l], apart[1][l], apart[2][l]))
    }

    /// Whether it is not certain that the seed is the nearest to point `n`.
    pub(super) fn is_doubtful(&self, n: usize) -> bool {
        let words = self.words();
        self.doubts[n * words..(n + 1) * words].iter().any(|&bits| bits != 0)
    }

    fn words(&self) -> usize {
        (self.blocks.len() * LANES).div_ceil(BITS)
    }

    #[inline]
    fn farthest(&self, corners: [usize; 3]) -> f64 {
        let [a, b, c] = corners.map(|n| self.reaches[n]);
        a.max(b).max(c)
    }

    /// The bisector with neighbour `k` at the points with these rows of values, none of them farther from the seed than `farthest`.
    #[inline]
    fn form(&self, k: usize, rows: [usize; 3], farthest: f64) -> Form {
        // By Cauchy's inequality; the margin is for the roundings of this bound itself.
        let distance = self.distances[k];
        let size = 1.000_001 * distance * (2.0 * farthest + distance);
        Form { d: rows.map(|row| self.values[row + k]), size }
    }
}

/// The neighbours whose bits are set, by their place among as many as share a word.
#[inline]
fn places(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        if bits == 0 {
            return None;
        }
        let bit = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        // A byte for each lane, a bit of it for each block.
        Some(bit % 8 * LANES + bit / 8)
    })
}

impl Seen<'_> {
    /// The neighbours that may be nearer to corner `c`, by their places in the list.
    #[inline]
    pub(super) fn doubtful_at(&self, c: usize) -> impl Iterator<Item = usize> {
        places(self.doubts[c])
    }

    /// Those that may be nearer to any.
    #[inline]
    pub(super) fn doubtful(&self) -> impl Iterator<Item = usize> {
        places(self.doubts[0] | self.doubts[1] | self.doubts[2])
    }

    /// The bisector with neighbour `k`.
    #[inline]
    pub(super) fn form(&self, k: usize) -> Form {
        self.planes.form(k, self.rows, self.farthest)
    }
}

/// Compiled for each width of vectors; the operations, and so the answers, are the same in each.
struct Test<'a, I> {
    planes: &'a mut Planes,
    at: I,
}

impl<I: Iterator<Item = DVec3>> pulp::WithSimd for Test<'_, I> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Planes { seed, blocks, values, doubts, reaches, .. } = self.planes;
        for p in self.at {
            let from_seed = p - *seed;
            reaches.push(from_seed.length());
            for eight in blocks.chunks(BITS / LANES) {
                let mut found = [0u64; LANES];
                for (bit, Block { at, apart, .. }) in eight.iter().enumerate() {
                    let mut d = [0.0; LANES];
                    for l in 0..LANES {
                        // The same bits, but for the sign, as the other seed's.
                        let x = apart[0][l] * (from_seed.x + (p.x - at[0][l]));
                        let y = apart[1][l] * (from_seed.y + (p.y - at[1][l]));
                        let z = apart[2][l] * (from_seed.z + (p.z - at[2][l]));
                        d[l] = x + y + z;
                        found[l] |= if d[l] > SURE { 0 } else { 1 << bit };
                    }
                    values.extend_from_slice(&d);
                }
                let mut word = 0;
                for (l, doubt) in found.iter().enumerate() {
                    word |= doubt << (8 * l);
                }
                doubts.push(word);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::frame::snap;
    use crate::rng::Rng;

    #[test]
    fn the_doubtful_are_those_that_are_nearer_to_a_corner() {
        let mut rng = Rng::new(3, 0);
        let mut point = |size: f64| snap(DVec3::from_array([0; 3].map(|_| (rng.unit() - 0.5) * size)));
        for count in [1, 7, 8, 9, 63, 64, 65, 200] {
            let seed = point(0.1);
            let points: Vec<DVec3> = (0..count).map(|_| point(0.5)).collect();
            let neighbors: Vec<u32> = (0..count as u32).collect();
            let corners: Vec<DVec3> = (0..60).map(|_| point(0.5)).collect();
            let (mut planes, mut bisectors) = (Planes::default(), Vec::new());
            planes.set(pulp::Arch::new(), seed, &neighbors, &points, corners.iter().copied());
            for n in (0..60).step_by(3) {
                let triangle = [n, n + 1, n + 2].map(|n| corners[n]);
                planes.cutting([n, n + 1, n + 2], &mut bisectors);
                let mut found: Vec<usize> = bisectors.iter().map(|b| b.seed as usize).collect();
                found.sort_unstable();
                let nearer = |p: &DVec3, k: usize| p.distance(points[k]) < p.distance(seed);
                let expected: Vec<usize> = (0..count).filter(|&k| triangle.iter().any(|p| nearer(p, k))).collect();
                assert_eq!(found, expected);
                assert_eq!(planes.is_doubtful(n), (0..count).any(|k| nearer(&corners[n], k)));
                for bisector in &bisectors {
                    let at = points[bisector.seed as usize];
                    for (d, c) in bisector.form.d.into_iter().zip(triangle) {
                        assert!((d - c.distance_squared(at) + c.distance_squared(seed)).abs() < 1e-15);
                        assert!(d.abs() <= bisector.form.size);
                    }
                }
            }
        }
    }
}
