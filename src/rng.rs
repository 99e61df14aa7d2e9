//! The one source of random choices: a promise to users that a random seed gives the same mesh in every version that
//! does not say otherwise.
//!
//! SplitMix64: Steele, Lea, Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014,
//! doi 10.1145/2660193.2660195. Streams of one random seed are told apart by a number that is mixed into the state.
//! Nothing here calls a transcendental function, whose last bit depends on the platform.

use glam::{DMat3, DQuat, DVec3};

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Rng {
    state: u64,
}

impl Rng {
    /// Stream `stream` of `seed`.
    pub fn new(seed: u64, stream: u64) -> Rng {
        Rng { state: mix(seed ^ mix(stream.wrapping_mul(GAMMA).wrapping_add(GAMMA))) }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GAMMA);
        mix(self.state)
    }

    /// A number in [0, 1), a multiple of 2^-53.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A number in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// A point of the cube [-1, 1)^3.
    pub fn in_cube(&mut self) -> DVec3 {
        let x = self.signed();
        let y = self.signed();
        DVec3::new(x, y, self.signed())
    }

    /// A rotation, uniform among all: a unit quaternion by rejection from the cube.
    pub fn rotation(&mut self) -> DMat3 {
        loop {
            let v = self.in_cube();
            let q = DQuat::from_xyzw(v.x, v.y, v.z, self.signed());
            let length2 = q.length_squared();
            if length2 > 0.01 && length2 <= 1.0 {
                return DMat3::from_quat(q.normalize());
            }
        }
    }

    /// Barycentric coordinates of a uniform point of a triangle.
    pub fn barycentric(&mut self) -> [f64; 3] {
        let (mut u, mut v) = (self.unit(), self.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        [(1.0 - u) - v, u, v]
    }
}

/// 64 bits that follow from `index` alone: the generator's output of that index, from state 0.
pub fn hash(index: u64) -> u64 {
    mix(index.wrapping_add(1).wrapping_mul(GAMMA))
}

const GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mixer_is_that_of_splitmix64() {
        // First outputs of the published generator for state 0.
        let mut rng = Rng { state: 0 };
        assert_eq!(rng.bits(), 0xe220_a839_7b1d_cdaf);
        assert_eq!(rng.bits(), 0x6e78_9e6a_a1b9_65f4);
        assert_eq!([hash(0), hash(1)], [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4]);
    }

    #[test]
    fn streams_and_seeds_differ() {
        let first = |seed, stream| Rng::new(seed, stream).bits();
        assert_ne!(first(1, 0), first(1, 1));
        assert_ne!(first(1, 0), first(2, 0));
        assert_eq!(first(7, 3), first(7, 3));
    }

    #[test]
    fn rotations_are_rotations() {
        let mut rng = Rng::new(1, 1);
        let mut mean = DVec3::ZERO;
        for _ in 0..2000 {
            let r = rng.rotation();
            assert!((r.determinant() - 1.0).abs() < 1e-12);
            mean += r * DVec3::X / 2000.0;
        }
        assert!(mean.length() < 0.06, "{mean}");
    }
}
