//! The bisectors of a seed at many points of the surface, in vectors, and which of them can cut which triangle.
//!
//! Nearly all neighbours are farther from all corners of a triangle by a wide margin, and are done with here; the few that are
//! left go on to the exact signs of `bisector.rs`.

use glam::DVec3;

use super::bisector::Bisector;

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
    /// For each point and block, the values of d.
    values: Vec<Lanes>,
    /// For each point, a bit for each neighbour that is not certain to be farther than the seed.
    doubts: Vec<u64>,
    /// Bounds on the distance of each point from the seed.
    distances: Vec<f64>,
}

/// Eight neighbours; positions that are missing are infinitely far.
struct Block {
    at: [Lanes; 3],
    /// From each to the seed, and how far that is.
    apart: [Lanes; 3],
    distance: Lanes,
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
            self.blocks.push(Block { at, apart, distance });
        }
        self.values.clear();
        self.doubts.clear();
        self.distances.clear();
        arch.dispatch(Test { planes: self, at });
    }

    /// Sets `out` to the bisectors that may cut the triangle of three of the points.
    #[inline]
    pub(super) fn cutting(&self, corners: [usize; 3], out: &mut Vec<Bisector>) {
        out.clear();
        let [a, b, c] = corners.map(|n| self.distances[n]);
        let farthest = a.max(b).max(c);
        let words = self.words();
        for word in 0..words {
            let [a, b, c] = corners.map(|n| self.doubts[n * words + word]);
            let mut rest = a | b | c;
            while rest != 0 {
                let bit = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                // A byte for each lane, a bit of it for each block.
                out.push(self.bisector(corners, word * BITS / LANES + bit % 8, bit / 8, farthest));
            }
        }
    }

    /// Whether it is not certain that the seed is the nearest to point `n`.
    pub(super) fn is_doubtful(&self, n: usize) -> bool {
        let words = self.words();
        self.doubts[n * words..(n + 1) * words].iter().any(|&bits| bits != 0)
    }

    fn words(&self) -> usize {
        (self.blocks.len() * LANES).div_ceil(BITS)
    }

    /// The bisector with the neighbour in such a lane of a block on the triangle of three points, the farthest of which is no
    /// farther from the seed than that.
    #[inline]
    fn bisector(&self, corners: [usize; 3], number: usize, lane: usize, farthest: f64) -> Bisector {
        let (block, blocks) = (&self.blocks[number], self.blocks.len());
        let distance = block.distance[lane];
        Bisector {
            seed: self.neighbors[number * LANES + lane],
            at: DVec3::new(block.at[0][lane], block.at[1][lane], block.at[2][lane]),
            d: corners.map(|n| self.values[n * blocks + number][lane]),
            // By Cauchy's inequality; the margin is for the roundings of this bound itself.
            size: 1.000_001 * distance * (2.0 * farthest + distance),
        }
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
        let Planes { seed, blocks, values, doubts, distances, .. } = self.planes;
        for p in self.at {
            let from_seed = p - *seed;
            distances.push(from_seed.length());
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
                    values.push(d);
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
                    for (d, c) in bisector.d.into_iter().zip(triangle) {
                        assert!((d - c.distance_squared(at) + c.distance_squared(seed)).abs() < 1e-15);
                        assert!(d.abs() <= bisector.size);
                    }
                }
            }
        }
    }
}
