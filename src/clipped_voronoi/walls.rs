//! The cell of one seed as the half-spaces of its neighbours, for tests of single points with a wide margin.

use glam::DVec3;

use super::bisector::VAGUE;
use super::surface_pieces::Scene;
use crate::geometry::triples::{cross, dot, greater, minus};

/// Neighbours, or points, that are dealt with at once.
pub(super) const LANES: usize = 8;

/// A number of each.
pub(super) type Lanes = [f64; LANES];

/// A point must be nearer to a seed by more than this share of the squares of its own distance and of the other seed's: it is
/// known to a tenth of that.
const MARGIN: f64 = 1e-8;

/// Edges longer than so many times the distance of two seeds take digits from it too.
const LONG: f64 = 10.0;

/// The neighbours of a seed, eight by eight.
#[derive(Default)]
pub(super) struct Walls {
    seed: Option<u32>,
    blocks: Vec<Block>,
}

/// Positions are relative to the seed: a point is nearer to the seed where its product with `at` is below `limit`.
struct Block {
    ids: [u32; LANES],
    at: [Lanes; 3],
    limit: Lanes,
}

impl Walls {
    /// Makes these the walls of the cell of seed `i`; all calls must be of one scene.
    pub(super) fn set(&mut self, scene: Scene, i: u32) {
        if self.seed.replace(i) == Some(i) {
            return;
        }
        let seed = scene.points[i as usize];
        self.blocks.clear();
        for eight in scene.adjacency.of(i as usize).chunks(LANES) {
            let mut block = Block { ids: [u32::MAX; LANES], at: [[0.0; LANES]; 3], limit: [f64::INFINITY; LANES] };
            for (l, &k) in eight.iter().enumerate() {
                let at = scene.points[k as usize] - seed;
                block.ids[l] = k;
                set(&mut block.at, l, at);
                block.limit[l] = (0.5 - MARGIN) * at.length_squared();
            }
            self.blocks.push(block);
        }
    }

    /// Whether a point on the bisectors with `others` is certainly in the cell, and so in theirs.
    #[inline(always)]
    pub(super) fn hold(&self, [x, y, z]: [f64; 3], others: [u32; 2]) -> bool {
        let margin = MARGIN * (x * x + y * y + z * z);
        let mut beyond = [0u64; LANES];
        for Block { ids, at, limit } in &self.blocks {
            for l in 0..LANES {
                let near = x * at[0][l] + y * at[1][l] + z * at[2][l] + margin < limit[l];
                beyond[l] |= u64::from(!near & (ids[l] != others[0]) & (ids[l] != others[1]));
            }
        }
        beyond.iter().fold(0, |all, one| all | one) == 0
    }

    /// Where the way from a point of the cell to one of another leaves it, as a share of the way, and into which cell; `None`
    /// where that is not certain.
    pub(super) fn exit(&self, arch: pulp::Arch, [from, to]: [DVec3; 2]) -> Option<(u32, f64)> {
        arch.dispatch(Exit { walls: self, from: from.to_array(), to: to.to_array() })
    }

    /// Where an edge that comes through the cell leaves it for that of the other seed, as a share of the edge; `None` where it does
    /// not, or that is not certain.
    pub(super) fn border(&self, arch: pulp::Arch, [from, to]: [DVec3; 2], (other, at): (u32, DVec3)) -> Option<f64> {
        arch.dispatch(Border { walls: self, from: from.to_array(), to: to.to_array(), other, at: at.to_array() })
    }

    /// Where the cell meets those of two others in a triangle, around that point counter-clockwise, as barycentric coordinates;
    /// `None` where it does not, or that is not certain.
    pub(super) fn meeting(&self, arch: pulp::Arch, corners: [DVec3; 3], others: [(u32, DVec3); 2]) -> Option<[f64; 3]> {
        let (ids, at) = (others.map(|o| o.0), others.map(|o| o.1.to_array()));
        arch.dispatch(Meet { walls: self, corners: corners.map(|p| p.to_array()), ids, at })
    }
}

/// Compiled for each width of vectors; the operations, and so the answers, are the same in each.
struct Exit<'a> {
    walls: &'a Walls,
    from: [f64; 3],
    to: [f64; 3],
}

impl pulp::WithSimd for Exit<'_> {
    type Output = Option<(u32, f64)>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Option<(u32, f64)> {
        let Exit { walls, from, to } = self;
        let (mut least, mut which) = ([f64::INFINITY; LANES], [0u64; LANES]);
        for (n, Block { at, .. }) in (0..).zip(&walls.blocks) {
            for l in 0..LANES {
                let other = get(at, l);
                let (at_from, at_to) = (value(from, other).0, value(to, other).0);
                let fall = at_from - at_to;
                let place = if fall > 0.0 { at_from / fall } else { f64::INFINITY };
                let sooner = place < least[l];
                least[l] = if sooner { place } else { least[l] };
                which[l] = if sooner { n } else { which[l] };
            }
        }
        let l = (1..LANES).fold(0, |best, l| if least[l] < least[best] { l } else { best });
        let block = walls.blocks.get(which[l] as usize)?;
        let found = on_edge(from, to, get(&block.at, l));
        (found.clear && walls.hold(found.at, [block.ids[l]; 2])).then_some((block.ids[l], found.place))
    }
}

/// The same for a border.
struct Border<'a> {
    walls: &'a Walls,
    from: [f64; 3],
    to: [f64; 3],
    other: u32,
    at: [f64; 3],
}

impl pulp::WithSimd for Border<'_> {
    type Output = Option<f64>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Option<f64> {
        let found = on_edge(self.from, self.to, self.at);
        (found.clear && self.walls.hold(found.at, [self.other; 2])).then_some(found.place)
    }
}

/// The same for a meeting.
struct Meet<'a> {
    walls: &'a Walls,
    corners: [[f64; 3]; 3],
    ids: [u32; 2],
    at: [[f64; 3]; 2],
}

impl pulp::WithSimd for Meet<'_> {
    type Output = Option<[f64; 3]>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Option<[f64; 3]> {
        let found = in_triangle(self.corners, self.at);
        (found.clear && self.walls.hold(found.at, self.ids)).then_some(found.place)
    }
}

/// A place on a bisector, or on two: what it is on its edge or triangle, the point, and whether it has digits enough to be tested.
pub(super) struct Found<T> {
    pub(super) place: T,
    pub(super) at: [f64; 3],
    pub(super) clear: bool,
}

/// Where an edge from a point of the cell of the seed at 0 to one of another's meets the bisector with the seed at `other`.
#[inline(always)]
pub(super) fn on_edge(from: [f64; 3], to: [f64; 3], other: [f64; 3]) -> Found<f64> {
    let ((at_from, size_from), (at_to, size_to)) = (value(from, other), value(to, other));
    let (along, fall) = (minus(to, from), at_from - at_to);
    let place = at_from / fall;
    // It is known to be on the edge: what rounding puts beyond an end is brought back.
    let place = if place > 0.0 { place } else { 0.0 };
    let place = if place < 1.0 { place } else { 1.0 };
    let at = [0, 1, 2].map(|k| from[k] + along[k] * place);
    Found { place, at, clear: (fall > VAGUE * greater(size_from, size_to)) & is_short(along, other) }
}

/// Where the bisectors with two others meet in a triangle, as barycentric coordinates, where the cells of the seed at 0, the first
/// and the second are around that point counter-clockwise.
#[inline(always)]
pub(super) fn in_triangle(corners: [[f64; 3]; 3], others: [[f64; 3]; 2]) -> Found<[f64; 3]> {
    let at_corners = others.map(|other| corners.map(|p| value(p, other)));
    let [j, k] = at_corners.map(|values| values.map(|v| v.0));
    let [size_j, size_k] = at_corners.map(|values| greater(greater(values[0].1, values[1].1), values[2].1));
    let minors = cross(j, k);
    let sum = minors[0] + minors[1] + minors[2];
    let weights = minors.map(|m| m / sum);
    let [a, b, c] = corners;
    let (to_b, to_c) = (minus(b, a), minus(c, a));
    let at = [0, 1, 2].map(|n| a[n] + to_b[n] * weights[1] + to_c[n] * weights[2]);
    let inside = (weights[0] >= 0.0) & (weights[1] >= 0.0) & (weights[2] >= 0.0);
    let short = is_short(to_b, others[0]) & is_short(to_c, others[0]);
    Found { place: weights, at, clear: (sum > VAGUE * size_j * size_k) & inside & short }
}

/// The value of d, positive where the seed at 0 is nearer to `p` than the one at `other`, and a bound on the size of its terms.
#[inline(always)]
fn value(p: [f64; 3], other: [f64; 3]) -> (f64, f64) {
    let twice = [0, 1, 2].map(|k| p[k] + (p[k] - other[k]));
    let terms = [0, 1, 2].map(|k| -other[k] * twice[k]);
    (terms[0] + terms[1] + terms[2], terms[0].abs() + terms[1].abs() + terms[2].abs())
}

/// Whether an edge is not long for the distance of two seeds.
#[inline(always)]
fn is_short(edge: [f64; 3], other: [f64; 3]) -> bool {
    dot(edge, edge) <= LONG * LONG * dot(other, other)
}

/// Puts a vector into lane `l`.
#[inline]
pub(super) fn set(at: &mut [Lanes; 3], l: usize, p: DVec3) {
    (at[0][l], at[1][l], at[2][l]) = (p.x, p.y, p.z);
}

/// The vector in lane `l`.
#[inline(always)]
pub(super) fn get(at: &[Lanes; 3], l: usize) -> [f64; 3] {
    [at[0][l], at[1][l], at[2][l]]
}
