//! Point sets that break geometry code, and an exact oracle to judge it by.

use glam::DVec3;
use num_bigint::BigInt;
use num_traits::Zero;
use tetcvt::delaunay::Delaunay;
use tetcvt::geometry::predicates::Sign;

/// All tets, the infinite ones too, as a set.
pub fn sorted_tets(delaunay: &Delaunay) -> Vec<[u32; 4]> {
    let mut tets: Vec<[u32; 4]> = delaunay.vertices().to_vec();
    tets.iter_mut().for_each(|t| t.sort_unstable());
    tets.sort_unstable();
    tets
}

/// SplitMix64.
#[derive(Clone)]
pub struct Rng(pub u64);

impl Rng {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1), a multiple of 2^-53.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2f64.powi(-53)
    }

    /// Uniform in 0..n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Uniform in [-1/2, 1/2)^3.
    pub fn point(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) - DVec3::splat(0.5)
    }

    /// A random order of the items.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// Uniform in a cube.
pub fn uniform(count: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Rng(seed);
    (0..count).map(|_| rng.point()).collect()
}

/// All points of an n x n x n grid.
pub fn grid(n: usize) -> Vec<DVec3> {
    let at = |i: usize| DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
    (0..n * n * n).map(at).collect()
}

/// All integer points at distance `sqrt(norm2)` from the origin.
pub fn integer_sphere(norm2: i64) -> Vec<DVec3> {
    let r = norm2.isqrt();
    let mut points = Vec::new();
    for x in -r..=r {
        for y in -r..=r {
            for z in -r..=r {
                if x * x + y * y + z * z == norm2 {
                    points.push(DVec3::new(x as f64, y as f64, z as f64));
                }
            }
        }
    }
    points
}

/// Layers of random points on parallel planes.
pub fn layers(count: usize, planes: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Rng(seed);
    (0..count).map(|i| DVec3::new(rng.unit(), rng.unit(), (i % planes) as f64 * 0.25)).collect()
}

/// Points on lines parallel to the axes, with a few off them.
pub fn lines(count: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Rng(seed);
    (0..count)
        .map(|i| {
            let mut p = [0.25, -0.25, 0.125];
            p[i % 3] = i as f64 / count as f64;
            if i % 10 == 9 { rng.point() } else { DVec3::from_array(p) }
        })
        .collect()
}

/// Clusters at ever smaller scales about a few centres.
pub fn clusters(count: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Rng(seed);
    let centers: Vec<DVec3> = (0..5).map(|_| rng.point()).collect();
    (0..count).map(|i| centers[i % 5] + rng.point() * 10f64.powi(-((i / 5 % 12) as i32))).collect()
}

/// Triples of points one unit in the last place apart.
pub fn near_duplicates(count: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Rng(seed);
    let mut points = Vec::new();
    while points.len() < count {
        let p = rng.point();
        points.push(p);
        points.push(DVec3::new(p.x.next_up(), p.y, p.z));
        points.push(DVec3::new(p.x, p.y.next_down(), p.z.next_up()));
    }
    points.truncate(count);
    points
}

/// A body-centred cubic lattice of at least `count` points in the unit cube, jittered by `jitter` of its spacing.
pub fn jittered_lattice(count: usize, jitter: f64, seed: u64) -> Vec<DVec3> {
    let mut rng = Rng(seed);
    let n = (1..).find(|n| 2 * n * n * n >= count).expect("the cubes are unbounded");
    grid(n)
        .into_iter()
        .flat_map(|p| [p, p + DVec3::splat(0.5)])
        .map(|p| (p + rng.point() * jitter) / n as f64)
        .collect()
}

/// A finite `f64` as an integer times 2^-1074.
fn integer(x: f64) -> BigInt {
    let bits = x.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, shift) = if exponent == 0 { (fraction, 0) } else { (fraction | 1 << 52, exponent - 1) };
    let value = BigInt::from(mantissa) << shift;
    if x.is_sign_negative() { -value } else { value }
}

/// Coordinates as integers over a common power of two.
pub type ExactPoint = [BigInt; 3];

/// The point, exactly.
pub fn exact(p: DVec3) -> ExactPoint {
    p.to_array().map(integer)
}

fn minus(a: &ExactPoint, b: &ExactPoint) -> ExactPoint {
    std::array::from_fn(|i| &a[i] - &b[i])
}

fn det3(u: &ExactPoint, v: &ExactPoint, w: &ExactPoint) -> BigInt {
    &u[0] * (&v[1] * &w[2] - &v[2] * &w[1])
        + &u[1] * (&v[2] * &w[0] - &v[0] * &w[2])
        + &u[2] * (&v[0] * &w[1] - &v[1] * &w[0])
}

fn sign(x: &BigInt) -> Sign {
    match x.sign() {
        num_bigint::Sign::Minus => Sign::Negative,
        num_bigint::Sign::NoSign => Sign::Zero,
        num_bigint::Sign::Plus => Sign::Positive,
    }
}

/// Six times the volume of the tet, over the cube of the common denominator.
pub fn exact_volume6(t: [&ExactPoint; 4]) -> BigInt {
    det3(&minus(t[1], t[0]), &minus(t[2], t[0]), &minus(t[3], t[0]))
}

/// The sign of det[b - a, c - a, d - a].
pub fn exact_orient3d(t: [&ExactPoint; 4]) -> Sign {
    sign(&exact_volume6(t))
}

/// Positive when `p` is inside the sphere of the positive tet `t`: the 4x4 determinant of differences and lifts.
pub fn exact_insphere(t: [&ExactPoint; 4], p: &ExactPoint) -> Sign {
    let rows = t.map(|v| minus(v, p));
    let lifts: Vec<BigInt> = rows.iter().map(|r| r.iter().map(|x| x * x).sum()).collect();
    let mut sum = BigInt::zero();
    for (i, lift) in lifts.iter().enumerate() {
        let rest: Vec<&ExactPoint> = (0..4).filter(|&j| j != i).map(|j| &rows[j]).collect();
        let term = lift * det3(rest[0], rest[1], rest[2]);
        // Expansion along the last column; with p as origin, a positive tet around it has a positive sum.
        if i % 2 == 0 { sum -= term } else { sum += term }
    }
    -sign(&sum)
}
