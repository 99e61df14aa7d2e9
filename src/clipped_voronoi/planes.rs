//! The bisectors of a seed at the corners of many triangles, in vectors, and which of them can cut which triangle.
//!
//! Nearly all neighbours are farther from all of a triangle by a wide margin, and are done with here; the few that are left go
//! on to the exact signs of `bisector.rs`.

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

/// The bisectors of one seed on some triangles.
#[derive(Default)]
pub(super) struct Planes {
    seed: DVec3,
    neighbors: Vec<u32>,
    blocks: Vec<Block>,
    /// For each triangle and block, the values of d at the three corners.
    values: Vec<[Lanes; 3]>,
    /// For each triangle, a bit for each neighbour that is not certain to be farther than the seed.
    doubts: Vec<u64>,
}

/// Eight neighbours; positions that are missing are infinitely far.
struct Block {
    at: [Lanes; 3],
    /// From each to the seed, and how far that is.
    apart: [Lanes; 3],
    distance: Lanes,
}

impl Planes {
    /// Makes these the bisectors of `seed` and `neighbors`, on `triangles`.
    pub(super) fn set(
        &mut self,
        arch: pulp::Arch,
        seed: DVec3,
        neighbors: &[u32],
        points: &[DVec3],
        triangles: impl Iterator<Item = [DVec3; 3]>,
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
        arch.dispatch(Test { planes: self, triangles });
    }

    /// Sets `out` to the bisectors that may cut triangle `n`, whose corners, relative to the seed, are `corners`.
    #[inline]
    pub(super) fn cutting(&self, n: usize, corners: [DVec3; 3], out: &mut Vec<Bisector>) {
        out.clear();
        let farthest = farthest(corners);
        out.extend(self.doubtful(n).map(|k| self.bisector(n, k, farthest)));
    }

    /// The bisector with neighbour `k` of the list on triangle `n`, whose farthest corner is so far from the seed.
    #[inline]
    fn bisector(&self, n: usize, k: usize, farthest: f64) -> Bisector {
        let (block, l) = (&self.blocks[k / LANES], k % LANES);
        let distance = block.distance[l];
        Bisector {
            seed: self.neighbors[k],
            at: DVec3::new(block.at[0][l], block.at[1][l], block.at[2][l]),
            d: self.values[n * self.blocks.len() + k / LANES].map(|lanes| lanes[l]),
            // By Cauchy's inequality; the margin is for the roundings of this bound itself.
            size: 1.000_001 * distance * (2.0 * farthest + distance),
        }
    }

    /// The neighbours, by their place in the list, of which it is not certain that they are farther from triangle `n` than
    /// the seed.
    pub(super) fn doubtful(&self, n: usize) -> impl Iterator<Item = usize> + '_ {
        let words = (self.blocks.len() * LANES).div_ceil(BITS);
        self.doubts[n * words..(n + 1) * words].iter().enumerate().flat_map(|(word, &bits)| {
            let mut rest = bits;
            std::iter::from_fn(move || {
                if rest == 0 {
                    return None;
                }
                let bit = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                // A byte for each lane, a bit of it for each block.
                Some(word * BITS + (bit % 8) * LANES + bit / 8)
            })
        })
    }
}

/// The distance of the farthest of three points from the origin.
fn farthest(corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|y| y.length_squared());
    a.max(b).max(c).sqrt()
}

/// Compiled for each width of vectors; the operations, and so the answers, are the same in each.
struct Test<'a, I> {
    planes: &'a mut Planes,
    triangles: I,
}

impl<I: Iterator<Item = [DVec3; 3]>> pulp::WithSimd for Test<'_, I> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Planes { seed, blocks, values, doubts, .. } = self.planes;
        for corners in self.triangles {
            let from_seed = corners.map(|c| c - *seed);
            for eight in blocks.chunks(BITS / LANES) {
                let mut found = [0u64; LANES];
                for (bit, Block { at, apart, .. }) in eight.iter().enumerate() {
                    let mut d = [[0.0; LANES]; 3];
                    for l in 0..LANES {
                        // The same bits, but for the sign, as the other seed's.
                        let value = |c: usize| {
                            let x = apart[0][l] * (from_seed[c].x + (corners[c].x - at[0][l]));
                            let y = apart[1][l] * (from_seed[c].y + (corners[c].y - at[1][l]));
                            let z = apart[2][l] * (from_seed[c].z + (corners[c].z - at[2][l]));
                            x + y + z
                        };
                        (d[0][l], d[1][l], d[2][l]) = (value(0), value(1), value(2));
                        let least = if d[0][l] < d[1][l] { d[0][l] } else { d[1][l] };
                        let least = if least < d[2][l] { least } else { d[2][l] };
                        found[l] |= if least > SURE { 0 } else { 1 << bit };
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
            let triangles: Vec<[DVec3; 3]> = (0..20).map(|_| [0; 3].map(|_| point(0.5))).collect();
            let (mut planes, mut bisectors) = (Planes::default(), Vec::new());
            planes.set(pulp::Arch::new(), seed, &neighbors, &points, triangles.iter().copied());
            for (n, triangle) in triangles.iter().enumerate() {
                let mut found: Vec<usize> = planes.doubtful(n).collect();
                found.sort_unstable();
                let nearer = |k: &usize| triangle.iter().any(|p| p.distance(points[*k]) < p.distance(seed));
                let expected: Vec<usize> = (0..count).filter(nearer).collect();
                assert_eq!(found, expected);
                planes.cutting(n, triangle.map(|c| c - seed), &mut bisectors);
                assert_eq!(bisectors.len(), found.len());
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
