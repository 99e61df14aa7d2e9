//! Determinants of points whose coordinates are integers of one unit, exactly, in fixed width.
//!
//! Points of a common grid (those of the mesher's frame are multiples of 2^-52) become integers below 2^61 by a power of
//! two. Differences are then below 2^62, minors of two rows below 2^125, and the determinants below fit 192 and
//! 320 bits. All of it is arithmetic modulo a power of two, in two's complement, without branches: an order of magnitude
//! faster than floating-point expansions, which remain for points that share no such grid.

use glam::DVec3;

/// The points as integers of a common unit, below 2^61 in size, if they share one.
#[inline]
pub fn on_grid<const N: usize>(points: [DVec3; N]) -> Option<[[i64; 3]; N]> {
    let reach = points.iter().fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
    // reach < 2^(exponent - 1022), so the power of two that takes it below 2^61 has the exponent 1083 - exponent.
    let exponent = reach.to_bits() >> 52;
    if !(200..2000).contains(&exponent) {
        return None;
    }
    let scale = f64::from_bits((1023 + 1083 - exponent) << 52);
    let mut whole = true;
    let grid = points.map(|p| {
        p.to_array().map(|x| {
            let x = x * scale;
            let i = x as i64;
            whole &= i as f64 == x;
            i
        })
    });
    whole.then_some(grid)
}

/// An integer modulo 2^(64 N), least word first, in two's complement.
#[derive(Clone, Copy)]
struct Wide<const N: usize>([u64; N]);

impl<const N: usize> Wide<N> {
    fn new(x: i128) -> Wide<N> {
        Wide(std::array::from_fn(|i| if i < 2 { (x >> (64 * i)) as u64 } else { (x >> 127) as u64 }))
    }

    /// The same integer in more words.
    fn widen<const M: usize>(self) -> Wide<M> {
        let sign = (self.0[N - 1] as i64 >> 63) as u64;
        Wide(std::array::from_fn(|i| if i < N { self.0[i] } else { sign }))
    }

    fn times(self, other: Wide<N>) -> Wide<N> {
        let mut product = [0u64; N];
        for i in 0..N {
            let mut carry = 0u128;
            for j in 0..N - i {
                let t = u128::from(self.0[i]) * u128::from(other.0[j]) + u128::from(product[i + j]) + carry;
                product[i + j] = t as u64;
                carry = t >> 64;
            }
        }
        Wide(product)
    }

    fn plus(self, other: Wide<N>) -> Wide<N> {
        let mut carry = false;
        Wide(std::array::from_fn(|i| {
            let (sum, first) = self.0[i].overflowing_add(other.0[i]);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            carry = first | second;
            sum
        }))
    }

    fn negated(self) -> Wide<N> {
        Wide(self.0.map(|w| !w)).plus(Wide::new(1))
    }

    /// -1, 0 or 1.
    fn signum(self) -> i32 {
        if (self.0[N - 1] as i64) < 0 { -1 } else { i32::from(self.0.iter().any(|&w| w != 0)) }
    }
}

type Row = [i64; 3];

fn minus(a: Row, b: Row) -> Row {
    std::array::from_fn(|i| a[i] - b[i])
}

/// The minor of the first two columns.
fn minor(a: Row, b: Row) -> i128 {
    i128::from(a[0]) * i128::from(b[1]) - i128::from(b[0]) * i128::from(a[1])
}

/// u * a + v * b + w * c.
fn combine(a: i128, b: i128, c: i128, u: i64, v: i64, w: i64) -> Wide<3> {
    let term = |m: i128, x: i64| Wide::<3>::new(m).times(Wide::new(i128::from(x)));
    term(a, u).plus(term(b, v)).plus(term(c, w))
}

/// The sign of det[b - a, c - a, d - a].
pub fn orient3d([a, b, c, d]: [Row; 4]) -> i32 {
    let (u, v, w) = (minus(b, a), minus(c, a), minus(d, a));
    combine(minor(v, w), minor(w, u), minor(u, v), u[2], v[2], w[2]).signum()
}

/// The sign of the determinant of rows (difference to p, its squared length): positive when p is inside the sphere of
/// the positive tet (a, b, c, d).
pub fn insphere([a, b, c, d, p]: [Row; 5]) -> i32 {
    let (a, b, c, d) = (minus(a, p), minus(b, p), minus(c, p), minus(d, p));
    let (ab, bc, cd, da) = (minor(a, b), minor(b, c), minor(c, d), minor(d, a));
    let (ac, bd) = (minor(a, c), minor(b, d));
    let abc = combine(bc, -ac, ab, a[2], b[2], c[2]);
    let bcd = combine(cd, -bd, bc, b[2], c[2], d[2]);
    let cda = combine(da, ac, cd, c[2], d[2], a[2]);
    let dab = combine(ab, bd, da, d[2], a[2], b[2]);
    let lifted = |row: Row, minor: Wide<3>| {
        let lift = row.iter().map(|&x| i128::from(x) * i128::from(x)).sum();
        Wide::<5>::new(lift).times(minor.widen())
    };
    let plus = lifted(c, dab).plus(lifted(a, bcd));
    let minus = lifted(d, abc).plus(lifted(b, cda));
    plus.plus(minus.negated()).signum()
}
