//! All tets around a vertex judged at once, by vectors: the same figures as those of `measure.rs`, compiled for each width of
//! vectors; the operations, and so the results, are the same in each.
//!
//! The angle at an edge grows with the way of a far corner of one of its facets along that facet's outward normal, over the
//! corner's distance to the edge; and as no common shift of the four corners changes the angle, the gradients by the edge's ends
//! are minus those of the far corners, shared as the feet of these on the edge are.

use glam::DVec3;

use super::measure::{self, FLAT, INVERTED};
use crate::geometry::triples::{cross, dot, minus};

/// Tets that are worked on at once.
const LANES: usize = 8;

/// What a shape of 1 weighs against a radian. Shapes that are all alike are worth more to a solver than the last degree of the
/// mean angle: the mean radius ratio gains 0.005 to 0.009 by it, and the mean angle loses less than 0.2 degrees.
const SHAPE: f64 = 2.0;

/// The cube of a regular tet's root of summed squares of edges, over six times its volume: 12 times the root of 3.
const REGULAR: f64 = 20.784_609_690_826_528;

type Lanes = [f64; LANES];

/// Three corners of each of some tets.
type Block = [[Lanes; 3]; 3];

/// The corners of the tets around a vertex, but for the vertex.
#[derive(Debug)]
pub(super) struct Around {
    blocks: Vec<Block>,
    count: usize,
    arch: pulp::Arch,
    /// For each tet its six dihedral angles, with their gradients, as [`Around::angles`] found them.
    angles: Vec<Angles>,
    /// For each tet its quality, as [`Around::judge`] found it.
    qualities: Vec<f64>,
}

/// What there is to say of a vertex's place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judgement {
    /// The worst quality of its tets.
    pub worst: f64,
    /// The sum of their smallest dihedral angles and weighted shapes.
    pub sum: f64,
}

/// The six dihedral angles of each of some tets.
#[derive(Clone, Copy, Debug)]
struct Angles {
    value: [Lanes; 6],
    gradient: [[Lanes; 3]; 6],
}

const NO_ANGLES: Angles = Angles { value: [[0.0; LANES]; 6], gradient: [[[0.0; LANES]; 3]; 6] };

/// The sum of the smallest dihedral angles and weighted shapes, with its gradient.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Steepest {
    pub sum: f64,
    pub rise: DVec3,
    /// The square of the shortest edge at the vertex.
    pub shortest2: f64,
}

impl Default for Around {
    fn default() -> Around {
        Around { blocks: Vec::new(), count: 0, arch: pulp::Arch::new(), angles: Vec::new(), qualities: Vec::new() }
    }
}

impl Around {
    /// Takes other tets: with the vertex first, these corners make them positive.
    pub(super) fn set(&mut self, links: impl Iterator<Item = [DVec3; 3]>) {
        self.blocks.clear();
        self.count = 0;
        for link in links {
            let lane = self.count % LANES;
            if lane == 0 {
                self.blocks.push([[[0.0; LANES]; 3]; 3]);
            }
            if let Some(block) = self.blocks.last_mut() {
                for k in 0..3 {
                    (block[k][0][lane], block[k][1][lane], block[k][2][lane]) = (link[k].x, link[k].y, link[k].z);
                }
            }
            self.count += 1;
        }
        // Lanes without a tet of their own have the first one's.
        if let (Some(block), known @ 1..) = (self.blocks.last_mut(), self.count % LANES) {
            for axis in block.as_flattened_mut() {
                let first = axis[0];
                axis[known..].fill(first);
            }
        }
    }

    /// How good the tets are with the vertex at `p`; none if one is flat or inverted.
    pub(super) fn judge(&mut self, p: DVec3) -> Option<Judgement> {
        self.qualities.clear();
        let arch = self.arch;
        arch.dispatch(Judge { around: self, p })
    }

    /// The qualities that [`Around::judge`] found last, in the order of the tets.
    pub(super) fn qualities(&self) -> &[f64] {
        &self.qualities[..self.count]
    }

    /// The sum of smallest angles and weighted shapes with the vertex at `p`, and where it grows fastest.
    pub(super) fn steepest(&self, p: DVec3) -> Steepest {
        self.arch.dispatch(FindSteepest { around: self, p })
    }

    /// Calls `visit` with the dihedral angles below `least` or above `most`, and their gradients, the vertex being at `p`.
    pub(super) fn each_angle(&mut self, p: DVec3, [least, most]: [f64; 2], mut visit: impl FnMut(f64, DVec3)) {
        self.angles.resize(self.blocks.len(), NO_ANGLES);
        let arch = self.arch;
        arch.dispatch(FindAngles { around: self, p });
        for (i, Angles { value, gradient }) in self.angles.iter().enumerate() {
            let known = (self.count - i * LANES).min(LANES);
            for (value, [x, y, z]) in value.iter().zip(gradient) {
                for l in 0..known {
                    if value[l] < least || value[l] > most {
                        visit(value[l], DVec3::new(x[l], y[l], z[l]));
                    }
                }
            }
        }
    }
}

struct Judge<'a> {
    around: &'a mut Around,
    p: DVec3,
}

impl pulp::WithSimd for Judge<'_> {
    type Output = Option<Judgement>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Option<Judgement> {
        let Judge { around: Around { blocks, count, qualities, .. }, p } = self;
        let mut worst = f64::INFINITY;
        let mut sum = 0.0;
        for (i, block) in blocks.iter().enumerate() {
            let (quality, merit) = qualities_of(block, p);
            qualities.extend(quality);
            let known = (*count - i * LANES).min(LANES);
            worst = quality.iter().fold(worst, |least, &x| measure::least(x, least));
            sum += merit[..known].iter().sum::<f64>();
        }
        (worst > INVERTED).then_some(Judgement { worst, sum })
    }
}

/// Qualities of some tets, and their smallest dihedral angles with their weighted shapes.
#[inline(always)]
fn qualities_of(block: &Block, p: DVec3) -> (Lanes, Lanes) {
    let (mut quality, mut merit) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        let [u, v, w] = edges(block, p, l);
        // Outward normals, as in `measure::extremes`.
        let (nb, nc, nd) = (cross(w, v), cross(u, w), cross(v, u));
        let na = [-(nb[0] + nc[0] + nd[0]), -(nb[1] + nc[1] + nd[1]), -(nb[2] + nc[2] + nd[2])];
        let volume6 = -dot(nd, w);
        let longest2 = measure::most(measure::most(dot(u, u), dot(v, v)), dot(w, w));
        let positive = volume6 > 0.0;
        let solid = volume6 * volume6 > FLAT * FLAT * longest2 * longest2 * longest2;
        let ra = 1.0 / dot(na, na).sqrt();
        let rb = 1.0 / dot(nb, nb).sqrt();
        let rc = 1.0 / dot(nc, nc).sqrt();
        let rd = 1.0 / dot(nd, nd).sqrt();
        let (ab, ac, ad) = (dot(na, nb) * (ra * rb), dot(na, nc) * (ra * rc), dot(na, nd) * (ra * rd));
        let (bc, bd, cd) = (dot(nb, nc) * (rb * rc), dot(nb, nd) * (rb * rd), dot(nc, nd) * (rc * rd));
        let low =
            measure::least(measure::least(measure::least(ab, ac), measure::least(ad, bc)), measure::least(bd, cd));
        let high = measure::most(measure::most(measure::most(ab, ac), measure::most(ad, bc)), measure::most(bd, cd));
        let least = measure::acos(-low);
        let found = measure::combined([least, measure::acos(-high)]);
        quality[l] = if positive & solid { found } else { INVERTED };
        let (_, edges2) = gathered(u, v, w);
        merit[l] = least + volume6 * shape_by_volume(edges2);
    }
    (quality, merit)
}

/// The sum of a corner's three edges, and the sum of the squares of all six of the tet's.
#[inline(always)]
fn gathered(u: [f64; 3], v: [f64; 3], w: [f64; 3]) -> ([f64; 3], f64) {
    let sum = [u[0] + v[0] + w[0], u[1] + v[1] + w[1], u[2] + v[2] + w[2]];
    (sum, 4.0 * (dot(u, u) + dot(v, v) + dot(w, w)) - dot(sum, sum))
}

/// A tet's weighted shape over six times its volume, for the sum of its edges' squares.
///
/// The shape is the 3/2th power of the mean ratio (A. Liu, B. Joe, *Relationship between tetrahedron shape measures*, BIT
/// 34, 1994, doi 10.1007/BF01955874): volume over the cube of the edges' root mean square, 1 for a regular tet.
#[inline(always)]
fn shape_by_volume(edges2: f64) -> f64 {
    SHAPE * REGULAR / (edges2 * edges2.sqrt())
}

struct FindAngles<'a> {
    around: &'a mut Around,
    p: DVec3,
}

impl pulp::WithSimd for FindAngles<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let FindAngles { around: Around { blocks, angles, .. }, p } = self;
        for (block, Angles { value, gradient }) in blocks.iter().zip(angles) {
            for l in 0..LANES {
                let Slopes { cosine, slope, .. } = slopes(block, p, l);
                set(value, gradient, (0, l), cosine[0], slope[0]);
                set(value, gradient, (1, l), cosine[1], slope[1]);
                set(value, gradient, (2, l), cosine[2], slope[2]);
                set(value, gradient, (3, l), cosine[3], slope[3]);
                set(value, gradient, (4, l), cosine[4], slope[4]);
                set(value, gradient, (5, l), cosine[5], slope[5]);
            }
        }
    }
}

#[inline(always)]
fn set(value: &mut [Lanes; 6], gradient: &mut [[Lanes; 3]; 6], (k, l): (usize, usize), cosine: f64, slope: [f64; 3]) {
    value[k][l] = measure::acos(-cosine);
    gradient[k][0][l] = slope[0];
    gradient[k][1][l] = slope[1];
    gradient[k][2][l] = slope[2];
}

struct FindSteepest<'a> {
    around: &'a Around,
    p: DVec3,
}

impl pulp::WithSimd for FindSteepest<'_> {
    type Output = Steepest;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Steepest {
        let FindSteepest { around: Around { blocks, count, .. }, p } = self;
        let mut all = Steepest { shortest2: f64::INFINITY, ..Steepest::default() };
        for (i, block) in blocks.iter().enumerate() {
            let (mut merit, mut shortest) = ([0.0; LANES], [0.0; LANES]);
            let mut rise = [[0.0; LANES]; 3];
            for l in 0..LANES {
                let Slopes { cosine, slope, shortest2, shape, shape_slope } = slopes(block, p, l);
                // The smallest angle is that of the normals that are the most opposite.
                let far = lower(lower((cosine[0], slope[0]), (cosine[1], slope[1])), (cosine[2], slope[2]));
                let near = lower(lower((cosine[3], slope[3]), (cosine[4], slope[4])), (cosine[5], slope[5]));
                let (low, toward) = lower(far, near);
                merit[l] = measure::acos(-low) + shape;
                rise[0][l] = toward[0] + shape_slope[0];
                rise[1][l] = toward[1] + shape_slope[1];
                rise[2][l] = toward[2] + shape_slope[2];
                shortest[l] = shortest2;
            }
            let known = (*count - i * LANES).min(LANES);
            let sum = |lanes: &Lanes| lanes[..known].iter().sum::<f64>();
            all.sum += sum(&merit);
            all.rise += DVec3::new(sum(&rise[0]), sum(&rise[1]), sum(&rise[2]));
            all.shortest2 = shortest.iter().fold(all.shortest2, |least, &x| measure::least(least, x));
        }
        all
    }
}

/// The one of two angles with the lower figure.
#[inline(always)]
fn lower(a: (f64, [f64; 3]), b: (f64, [f64; 3])) -> (f64, [f64; 3]) {
    let first = a.0 < b.0;
    let value = if first { a.0 } else { b.0 };
    let x = if first { a.1[0] } else { b.1[0] };
    let y = if first { a.1[1] } else { b.1[1] };
    let z = if first { a.1[2] } else { b.1[2] };
    (value, [x, y, z])
}

/// The six dihedral angles of a tet with a corner that moves, and its shape.
struct Slopes {
    /// The cosines between the outward normals, minus those of the angles.
    cosine: [f64; 6],
    /// The gradients of the angles by that corner.
    slope: [[f64; 3]; 6],
    /// The square of the shortest edge there.
    shortest2: f64,
    /// The weighted shape, and its gradient.
    shape: f64,
    shape_slope: [f64; 3],
}

/// The dihedral angles and the shape of the tet in lane `l` with its first corner at `p`.
#[inline(always)]
fn slopes(block: &Block, p: DVec3, l: usize) -> Slopes {
    let [u, v, w] = edges(block, p, l);
    let (ab, bc, ca) = (minus(v, u), minus(w, v), minus(u, w));
    let (na, nb, nc) = (cross(w, v), cross(u, w), cross(v, u));
    let np = cross(ab, minus(w, u));
    let (ra2, rb2, rc2) = (1.0 / dot(na, na), 1.0 / dot(nb, nb), 1.0 / dot(nc, nc));
    let rp = (1.0 / dot(np, np)).sqrt();
    let (ra, rb, rc) = (ra2.sqrt(), rb2.sqrt(), rc2.sqrt());
    let (ga, gb, gc) = (times(na, ra2), times(nb, rb2), times(nc, rc2));
    let (u2, v2, w2) = (dot(u, u), dot(v, v), dot(w, w));
    let (uv, vw, wu) = (dot(u, v), dot(v, w), dot(w, u));
    let (sum, edges2) = gathered(u, v, w);
    let by_volume = shape_by_volume(edges2);
    let shape = dot(nc, w) * -by_volume;
    // The volume grows along the inward normal of the facet opposite.
    let by_edges = 3.0 * shape / edges2;
    let along = |k: usize| sum[k] * by_edges - np[k] * by_volume;
    Slopes {
        cosine: [
            dot(na, np) * (ra * rp),
            dot(nb, np) * (rb * rp),
            dot(nc, np) * (rc * rp),
            dot(nb, nc) * (rb * rc),
            dot(na, nc) * (ra * rc),
            dot(na, nb) * (ra * rb),
        ],
        slope: [
            times(ga, dot(bc, bc).sqrt()),
            times(gb, dot(ca, ca).sqrt()),
            times(gc, dot(ab, ab).sqrt()),
            shared(gc, gb, u2, [uv, wu]),
            shared(ga, gc, v2, [vw, uv]),
            shared(ga, gb, w2, [vw, wu]),
        ],
        shortest2: measure::least(measure::least(u2, v2), w2),
        shape,
        shape_slope: [along(0), along(1), along(2)],
    }
}

/// The gradient by an end of the edge, whose square is `length2`: those by the far corners are `g` and `h`, their feet along the
/// edge at `x` and `y`, times its length.
#[inline(always)]
fn shared(g: [f64; 3], h: [f64; 3], length2: f64, [x, y]: [f64; 2]) -> [f64; 3] {
    let inverse = -1.0 / length2.sqrt();
    let (x, y) = ((length2 - x) * inverse, (length2 - y) * inverse);
    [g[0] * x + h[0] * y, g[1] * x + h[1] * y, g[2] * x + h[2] * y]
}

/// The edges from `p` in lane `l`.
#[inline(always)]
fn edges(block: &Block, p: DVec3, l: usize) -> [[f64; 3]; 3] {
    let edge = |k: usize| [block[k][0][l] - p.x, block[k][1][l] - p.y, block[k][2][l] - p.z];
    [edge(0), edge(1), edge(2)]
}

#[inline(always)]
fn times(a: [f64; 3], by: f64) -> [f64; 3] {
    [a[0] * by, a[1] * by, a[2] * by]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tetrahedron;
    use crate::rng::Rng;

    const ALL: [f64; 2] = [f64::INFINITY; 2];

    /// The weighted shape by its definition.
    fn shape(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
        let edges = [a - p, b - p, c - p, b - a, c - b, a - c];
        let mean2 = edges.iter().map(|e| e.length_squared()).sum::<f64>() / 6.0;
        SHAPE * tetrahedron::volume6(p, a, b, c) / (0.5_f64.sqrt() * mean2.powf(1.5))
    }

    /// Its gradient, by differences.
    fn shape_slope(p: DVec3, link: [DVec3; 3]) -> DVec3 {
        const STEP: f64 = 1e-6;
        let along = |axis: DVec3| (shape(p + axis * STEP, link) - shape(p - axis * STEP, link)) / (2.0 * STEP);
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    }

    #[test]
    fn the_same_as_one_by_one() {
        let mut rng = Rng::new(5, 1);
        let p = DVec3::new(0.1, -0.05, 0.02);
        let mut around = Around::default();
        for count in 1..40 {
            let mut point = || rng.in_cube();
            let links: Vec<[DVec3; 3]> = std::iter::repeat_with(|| [point(), point(), point()])
                .filter(|&[a, b, c]| tetrahedron::volume6(p, a, b, c) > 0.01)
                .take(count)
                .collect();
            around.set(links.iter().copied());
            let found = around.judge(p).expect("positive tets");
            let extremes = links.iter().map(|&[a, b, c]| measure::extremes([p, a, b, c]).expect("a positive tet"));
            let sum: f64 =
                extremes.clone().map(|e| e[0]).sum::<f64>() + links.iter().map(|&link| shape(p, link)).sum::<f64>();
            let worst = extremes.clone().map(measure::combined).fold(9.0, f64::min);
            assert!((found.sum - sum).abs() < 1e-9 * sum && (found.worst - worst).abs() < 1e-9);
            assert_eq!(around.qualities().len(), count);
            for (quality, extremes) in around.qualities().iter().zip(extremes) {
                assert!((quality - measure::combined(extremes)).abs() < 1e-9);
            }
            let mut all = Vec::new();
            around.each_angle(p, ALL, |value, gradient| all.push((value, gradient)));
            let steepest = around.steepest(p);
            assert_eq!(all.len(), 6 * count);
            let rise: DVec3 = links
                .iter()
                .map(|&link| {
                    around.set(std::iter::once(link));
                    let mut least = (f64::INFINITY, DVec3::ZERO);
                    around.each_angle(p, ALL, |value, gradient| {
                        if value < least.0 {
                            least = (value, gradient);
                        }
                    });
                    least.1 + shape_slope(p, link)
                })
                .sum();
            assert!((steepest.sum - sum).abs() < 1e-9 * sum && steepest.rise.distance(rise) < 1e-8 * rise.length());
            let nearest = links.iter().flatten().map(|q| q.distance_squared(p)).fold(9.0, f64::min);
            assert_eq!(steepest.shortest2, nearest);
        }
        // A tet that is flat, and one that is inverted.
        for c in [DVec3::new(0.3, 0.3, 1e-12), -DVec3::Z] {
            around.set([[DVec3::X, DVec3::Y, DVec3::Z], [DVec3::X, DVec3::Y, c]].into_iter());
            assert!(around.judge(DVec3::ZERO).is_none());
        }
    }

    #[test]
    fn gradients_are_those_of_finite_differences() {
        const STEP: f64 = 1e-6;
        let mut rng = Rng::new(1, 7);
        let mut around = Around::default();
        for _ in 0..400 {
            let [p, a, b, c] = [0; 4].map(|_| rng.in_cube());
            if tetrahedron::volume6(p, a, b, c) < 0.05 {
                continue;
            }
            let sorted = |p: DVec3| {
                let mut all = tetrahedron::dihedral_angles(p, a, b, c).map(f64::to_radians);
                all.sort_by(f64::total_cmp);
                all
            };
            around.set(std::iter::once([a, b, c]));
            let mut found = Vec::new();
            around.each_angle(p, ALL, |value, gradient| found.push((value, gradient)));
            found.sort_by(|x, y| x.0.total_cmp(&y.0));
            let here = sorted(p);
            let distinct = here.windows(2).all(|w| w[1] - w[0] > 1e-3);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let (before, after) = (sorted(p - axis * STEP), sorted(p + axis * STEP));
                for i in 0..6 {
                    assert!((found[i].0 - here[i]).abs() < 1e-7);
                    let slope = (after[i] - before[i]) / (2.0 * STEP);
                    let error = (found[i].1.dot(axis) - slope).abs();
                    assert!(!distinct || error < 1e-4 * (1.0 + slope.abs()), "{i} {axis}: {error} of {slope}");
                }
            }
        }
    }
}
