//! Distance between the boundary of a mesh and the surface that it stands for.
//!
//! P. Cignoni, C. Rocchini, R. Scopigno, *Metro: Measuring Error on Simplified Surfaces*, Computer Graphics Forum 17(2),
//! 1998, doi 10.1111/1467-8659.00236: sample one surface, take the distance of each sample to the other, both ways.
//!
//! 1. Samples: every vertex, and one point in each of [`SAMPLES`] parts of equal area, in the order of the triangles.
//! 2. The distances of such points of fewer parts, one for [`STRIDE`] of these, to the other surface, by its box tree: their root
//!    mean square, both sides weighing the same, and a first lower bound of the largest.
//! 3. Hausdorff: the largest of all. Most of the others are soon seen to be closer than that bound.
//!
//! Where we depart: strata of equal area over the whole surface instead of a sampling rate per triangle, so that the
//! cost does not depend on the mesh. The Hausdorff distance is a lower bound, as in every sampling method. Numbers
//! behind samples follow from their index alone, so the result is the same on any number of threads.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::triangle;
use crate::rng::Rng;
use crate::surface::Surface;
use crate::surface::box_tree::{BoxTree, Closest};
use crate::tet_mesh::TetMesh;

/// Samples on each side, beside the vertices.
pub const SAMPLES: usize = 100_000;

/// The mean is over one point for so many of the samples.
const STRIDE: usize = 5;

/// Samples that one task takes; sums run within and then over tasks, in order.
const CHUNK: usize = 1024;

/// Distances between two surfaces, in frame units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Largest distance of a sample of either side to the other side.
    pub hausdorff: f64,
    /// Root of the mean of squared distances.
    pub rms: f64,
}

impl Distance {
    /// Between the boundary of `mesh` and `surface`.
    pub fn between(mesh: &TetMesh, surface: &Surface) -> Distance {
        let (vertices, triangles) = mesh.boundary_mesh();
        let points: Vec<DVec3> = vertices.iter().map(|&v| surface.frame().to_frame(mesh.points[v as usize])).collect();
        let tree = BoxTree::build(&points, &triangles);
        let there = Target { tree: surface.tree(), points: surface.points(), triangles: surface.triangles() };
        let there = OneSided::measure(&points, &triangles, &there);
        let back = Target { tree: &tree, points: &points, triangles: &triangles };
        let back = OneSided::measure(surface.points(), surface.triangles(), &back);
        Distance { hausdorff: there.max2.max(back.max2).sqrt(), rms: ((there.mean2 + back.mean2) / 2.0).sqrt() }
    }
}

/// Squared distances from one surface to another.
#[derive(Clone, Copy, Default)]
struct OneSided {
    max2: f64,
    mean2: f64,
}

impl OneSided {
    fn measure(points: &[DVec3], triangles: &[[u32; 3]], to: &Target) -> OneSided {
        const STRATA: usize = SAMPLES / STRIDE;
        let strata = Strata::new(points, triangles);
        let few = OneSided::over(STRATA, to, |chunk| strata.samples(chunk, STRATA));
        let samples = farthest(SAMPLES, to, few.max2, |chunk| strata.samples(chunk, SAMPLES));
        let vertices = farthest(points.len(), to, few.max2, |chunk| points[chunk].iter().copied());
        OneSided { max2: samples.max(vertices), mean2: few.mean2 }
    }

    /// The distances of `count` points, a chunk of which `of` gives at a time.
    fn over<I: Iterator<Item = DVec3>>(count: usize, to: &Target, of: impl Fn(Range<usize>) -> I + Sync) -> OneSided {
        let chunk = |range: Range<usize>| {
            // What was closest to the last point is close to this one.
            let mut last = None;
            of(range).fold((0.0f64, 0.0), |(max, sum), p| {
                let closest = to.closest(p, last);
                last = Some(closest.triangle);
                (max.max(closest.distance2), sum + closest.distance2)
            })
        };
        let chunks: Vec<(f64, f64)> = chunks(count).map(chunk).collect();
        let (max2, sum) = chunks.into_iter().fold((0.0f64, 0.0), |(max, sum), (m, s)| (max.max(m), sum + s));
        OneSided { max2, mean2: sum / count.max(1) as f64 }
    }
}

/// The largest squared distance of `count` points, a chunk of which `of` gives at a time, or `known` if that is larger.
fn farthest<I: Iterator<Item = DVec3>>(
    count: usize,
    to: &Target,
    known: f64,
    of: impl Fn(Range<usize>) -> I + Sync,
) -> f64 {
    let chunk = |range: Range<usize>| {
        let (mut last, mut most) = (None, known);
        for p in of(range) {
            let close = to.close_enough(p, last, most);
            last = Some(close.triangle);
            most = most.max(close.distance2);
        }
        most
    };
    chunks(count).map(chunk).reduce(|| known, f64::max)
}

/// Parts of the numbers below `count`.
fn chunks(count: usize) -> impl IndexedParallelIterator<Item = Range<usize>> {
    (0..count.div_ceil(CHUNK)).into_par_iter().map(move |i| i * CHUNK..((i + 1) * CHUNK).min(count))
}

/// The surface that distances are to.
struct Target<'a> {
    tree: &'a BoxTree,
    points: &'a [DVec3],
    triangles: &'a [[u32; 3]],
}

impl Target<'_> {
    /// The closest point; `guess` is a triangle that may be near it.
    fn closest(&self, p: DVec3, guess: Option<u32>) -> Closest {
        guess.map_or_else(|| self.tree.closest(p), |t| self.tree.closest_near(p, t, self.corners(t)))
    }

    /// A point whose squared distance is no more than `enough`, or the closest.
    fn close_enough(&self, p: DVec3, guess: Option<u32>, enough: f64) -> Closest {
        guess.map_or_else(|| self.tree.closest(p), |t| self.tree.close_enough(p, t, self.corners(t), enough))
    }

    fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.points[v as usize])
    }
}

/// Parts of equal area of a surface.
struct Strata<'a> {
    points: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    /// Area of the triangles up to and including each.
    area: Vec<f64>,
}

impl<'a> Strata<'a> {
    fn new(points: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Strata<'a> {
        let mut sum = 0.0;
        let area = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| points[v as usize]);
                sum += triangle::area(a, b, c);
                sum
            })
            .collect();
        Strata { points, triangles, area }
    }

    /// A point in each of some of `n` parts.
    fn samples(&self, parts: Range<usize>, n: usize) -> impl Iterator<Item = DVec3> {
        let total = self.area.last().copied().unwrap_or(0.0);
        let start = parts.start as f64 / n as f64 * total;
        let mut t = self.area.partition_point(|&area| area < start);
        parts.map(move |k| {
            let mut rng = Rng::new(0, k as u64);
            let at = (k as f64 + rng.unit()) / n as f64 * total;
            while t + 1 < self.area.len() && self.area[t] < at {
                t += 1;
            }
            let [a, b, c] = self.triangles[t.min(self.area.len() - 1)].map(|v| self.points[v as usize]);
            let [_, u, v] = rng.barycentric();
            a + (b - a) * u + (c - a) * v
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_lie_on_the_triangles_in_proportion_to_their_area() {
        // Two triangles of areas 1/2 and 3/2 in different planes.
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 3.0, 1.0)];
        let triangles = [[0, 1, 2], [3, 4, 5]];
        let strata = Strata::new(&points, &triangles);
        let n = 4000;
        let samples: Vec<DVec3> = strata.samples(0..n, n).collect();
        assert_eq!(samples.iter().filter(|p| p.z == 0.0).count(), n / 4);
        assert!(
            samples
                .iter()
                .all(|p| p.x >= 0.0 && p.y >= 0.0 && p.x + p.y / if p.z == 0.0 { 1.0 } else { 3.0 } <= 1.0 + 1e-15)
        );
        let mean: DVec3 = samples[..n / 4].iter().sum::<DVec3>() / (n / 4) as f64;
        assert!((mean - DVec3::new(1.0, 1.0, 0.0) / 3.0).length() < 0.02, "{mean}");
    }

    #[test]
    fn the_farthest_is_the_one_of_all_distances() {
        let mut rng = Rng::new(3, 0);
        let points: Vec<DVec3> = (0..60).map(|_| rng.in_cube()).collect();
        let triangles: Vec<[u32; 3]> = (0..20).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let tree = BoxTree::build(&points, &triangles);
        let to = Target { tree: &tree, points: &points, triangles: &triangles };
        let random = |chunk: Range<usize>| chunk.map(|k| Rng::new(1, k as u64).in_cube());
        let all = OneSided::over(5000, &to, random).max2;
        for known in [0.0, 0.5 * all, 0.999 * all, all] {
            assert_eq!(farthest(5000, &to, known, random), all, "{known}");
        }
        assert_eq!(farthest(5000, &to, 2.0 * all, random), 2.0 * all);
    }

    #[test]
    fn sums_do_not_depend_on_threads() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let triangles = [[0, 1, 2]];
        let tree = BoxTree::build(&points, &triangles);
        let to = Target { tree: &tree, points: &points, triangles: &triangles };
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let random = |chunk: Range<usize>| chunk.map(|k| Rng::new(0, k as u64).in_cube());
            let d = pool.install(|| OneSided::over(10_000, &to, random));
            (d.max2.to_bits(), d.mean2.to_bits())
        };
        assert_eq!(run(1), run(3));
    }
}
