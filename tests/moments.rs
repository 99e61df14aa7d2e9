//! Moments of clipped cells against a reference that shares nothing with them: convex pieces clipped in exact integers.
//!
//! The cell of seed i within the solid is a sum of signed cones from x_i over the triangles of the surface, each cut off by
//! all bisectors of the seed: no Delaunay triangulation, no neighbours, no inside test. A cone's outer boundary is what is left
//! of its triangle, and for each bisector the polygon in which its plane meets the cone below the triangle. Corners of
//! these polygons are exact, in homogeneous integers; they are rounded once, relative to x_i, for the closed forms.

use glam::DVec3;
use num_bigint::{BigInt, Sign};
use tetcvt::Surface;
use tetcvt::clipped_voronoi::Clipper;
use tetcvt::delaunay::Delaunay;
use tetcvt::geometry::frame::snap;

use crate::shapes::Shape;
use crate::support::Rng;

/// The frame's grid is 2^-52.
const UNITS: f64 = (1u64 << 52) as f64;

/// x, y, z and the common denominator, which is positive.
type Point = [BigInt; 4];

/// Where a.x + b.y + c.z + d.w is negative is beyond.
type Plane = [BigInt; 4];

fn point(p: DVec3) -> Point {
    let [x, y, z] = p.to_array().map(|x| BigInt::from((x * UNITS) as i64));
    [x, y, z, BigInt::from(1)]
}

fn value(plane: &Plane, p: &Point) -> BigInt {
    (0..4).map(|k| &plane[k] * &p[k]).sum()
}

/// The plane through three points with denominator 1; the side of `inner` is within.
fn plane_through([a, b, c]: [&Point; 3], inner: &Point) -> Plane {
    let (u, v): (Vec<BigInt>, Vec<BigInt>) = (0..3).map(|k| (&b[k] - &a[k], &c[k] - &a[k])).unzip();
    let n: [BigInt; 3] = std::array::from_fn(|k| {
        let (y, z) = ((k + 1) % 3, (k + 2) % 3);
        &u[y] * &v[z] - &u[z] * &v[y]
    });
    let offset: BigInt = (0..3).map(|k| &n[k] * &a[k]).sum();
    let [x, y, z] = n;
    let plane = [x, y, z, -offset];
    if value(&plane, inner).sign() == Sign::Minus { plane.map(|x| -x) } else { plane }
}

/// What is closer to `i` than to `j` is within.
fn bisector(i: &Point, j: &Point) -> Plane {
    let square = |p: &Point| (0..3).map(|k| &p[k] * &p[k]).sum::<BigInt>();
    let [x, y, z]: [BigInt; 3] = std::array::from_fn(|k| BigInt::from(2) * (&i[k] - &j[k]));
    [x, y, z, square(j) - square(i)]
}

fn clip(polygon: &[Point], plane: &Plane) -> Vec<Point> {
    let values: Vec<BigInt> = polygon.iter().map(|p| value(plane, p)).collect();
    if values.iter().all(|v| v.sign() != Sign::Minus) {
        return polygon.to_vec();
    }
    let mut kept = Vec::new();
    for (m, p) in polygon.iter().enumerate() {
        let next = (m + 1) % polygon.len();
        let (here, there) = (&values[m], &values[next]);
        if here.sign() != Sign::Minus {
            kept.push(p.clone());
        }
        if here * there < BigInt::ZERO {
            let (h, t) = (here.magnitude(), there.magnitude());
            let mix = |k: usize| &p[k] * BigInt::from(t.clone()) + &polygon[next][k] * BigInt::from(h.clone());
            kept.push(std::array::from_fn(mix));
        }
    }
    kept
}

/// The quotient of two integers of any size.
fn quotient(a: &BigInt, b: &BigInt) -> f64 {
    let leading = |x: &BigInt| {
        let shift = x.bits().saturating_sub(62);
        (i64::try_from(x >> shift).expect("62 bits") as f64, shift as i32)
    };
    let ((a, a_shift), (b, b_shift)) = (leading(a), leading(b));
    a / b * 2f64.powi(a_shift - b_shift)
}

/// The point relative to `origin`, rounded once.
fn relative(p: &Point, origin: &Point) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|k| quotient(&(&p[k] - &origin[k] * &p[3]), &p[3]) / UNITS))
}

/// Volume, first and second moment of a cell, area and first moment of its surface, relative to the seed; and the sum of the
/// sizes of all parts of the volume.
#[derive(Clone, Copy, Debug, Default)]
struct Reference {
    volume: f64,
    moment: DVec3,
    energy: f64,
    area: f64,
    area_moment: DVec3,
    turned_over: f64,
}

impl Reference {
    /// Adds the cone from the seed over a convex polygon, all of which counts with `sign`.
    fn add_cone(&mut self, corners: &[DVec3], sign: f64) {
        for m in 2..corners.len() {
            let (a, b, c) = (corners[0], corners[m - 1], corners[m]);
            let volume = sign * a.dot(b.cross(c)).abs() / 6.0;
            let s = a + b + c;
            self.volume += volume;
            self.turned_over += volume.abs();
            self.moment += s * (volume / 4.0);
            let squares = a.length_squared() + b.length_squared() + c.length_squared() + s.length_squared();
            self.energy += volume / 20.0 * squares;
        }
    }

    fn add_surface(&mut self, corners: &[DVec3]) {
        for m in 2..corners.len() {
            let (a, b, c) = (corners[0], corners[m - 1], corners[m]);
            let area = (b - a).cross(c - a).length() / 2.0;
            self.area += area;
            self.area_moment += (a + b + c) * (area / 3.0);
        }
    }

    fn of(surface: &Surface, seeds: &[DVec3], i: usize) -> Reference {
        let all: Vec<Point> = seeds.iter().map(|&p| point(p)).collect();
        let seed = &all[i];
        let bisectors: Vec<Plane> = (0..all.len()).filter(|&j| j != i).map(|j| bisector(seed, &all[j])).collect();
        let mut sums = Reference::default();
        for t in 0..surface.triangles().len() as u32 {
            let corners = surface.corners(t).map(point);
            let [a, b, c] = &corners;
            let piece = bisectors.iter().fold(corners.to_vec(), |polygon, plane| clip(&polygon, plane));
            let rounded: Vec<DVec3> = piece.iter().map(|p| relative(p, seed)).collect();
            sums.add_surface(&rounded);
            let outward = tetcvt::geometry::predicates::orient3d(
                seeds[i],
                surface.corners(t)[0],
                surface.corners(t)[1],
                surface.corners(t)[2],
            );
            let sign = match outward {
                tetcvt::geometry::predicates::Sign::Positive => 1.0,
                tetcvt::geometry::predicates::Sign::Negative => -1.0,
                // The triangle is seen from the side: no cone.
                tetcvt::geometry::predicates::Sign::Zero => continue,
            };
            sums.add_cone(&rounded, sign);
            let sides = [
                plane_through([seed, a, b], c),
                plane_through([seed, b, c], a),
                plane_through([seed, c, a], b),
                plane_through([a, b, c], seed),
            ];
            for (n, plane) in bisectors.iter().enumerate() {
                if corners.iter().all(|p| value(plane, p).sign() != Sign::Minus) {
                    continue;
                }
                let mut polygon = large(plane);
                for other in sides.iter().chain(bisectors.iter().enumerate().filter(|o| o.0 != n).map(|o| o.1)) {
                    if polygon.is_empty() {
                        break;
                    }
                    polygon = clip(&polygon, other);
                }
                let rounded: Vec<DVec3> = polygon.iter().map(|p| relative(p, seed)).collect();
                sums.add_cone(&rounded, sign);
            }
        }
        sums
    }
}

/// A quadrangle in a plane, larger than anything in the frame.
fn large(plane: &Plane) -> Vec<Point> {
    // The axis along which the plane is steepest is solved for; the others go from corner to corner.
    let steepest = (0..3).max_by_key(|&k| plane[k].magnitude().clone()).expect("three axes");
    let (y, z) = ((steepest + 1) % 3, (steepest + 2) % 3);
    let far = BigInt::from(1i64 << 56);
    [(1, 1), (-1, 1), (-1, -1), (1, -1)]
        .map(|(u, v)| {
            let (u, v): (BigInt, BigInt) = (&far * u, &far * v);
            let w = BigInt::from(plane[steepest].magnitude().clone());
            let along: BigInt = -(&plane[y] * &u + &plane[z] * &v + &plane[3]);
            let mut p = [BigInt::ZERO, BigInt::ZERO, BigInt::ZERO, w.clone()];
            p[steepest] = if plane[steepest].sign() == Sign::Minus { -along } else { along };
            p[y] = u * &w;
            p[z] = v * w;
            p
        })
        .to_vec()
}

/// Compares the cells of some of the seeds, `every` so manyth.
fn assert_agree(name: &str, surface: &Surface, count: usize, every: usize) {
    let mut rng = Rng(count as u64);
    let mut seeds: Vec<DVec3> = Vec::new();
    while seeds.len() < count {
        // Some on the surface, as most meshes have them.
        let p = snap(rng.point());
        if surface.tree().is_inside(p) {
            let on_surface = snap(surface.tree().closest(p).point);
            seeds.push(if seeds.len().is_multiple_of(3) { on_surface } else { p });
        }
    }
    let delaunay = Delaunay::build(&seeds).expect("seeds in general position");
    let clipped = Clipper::new(surface).clip(&delaunay);
    for i in (0..count).step_by(every) {
        let (cell, exact) = (&clipped.cells[i], Reference::of(surface, &seeds, i));
        // Cancellation in the reference costs it digits; it must have enough left.
        assert!(exact.turned_over < 1e4 * exact.volume, "{name}: {exact:?}");
        let size = (exact.energy / exact.volume).sqrt();
        let relative = |a: f64, b: f64, unit: f64| (a - b).abs() / unit;
        let errors = [
            relative(cell.volume, exact.volume, exact.volume),
            (cell.moment - exact.moment).length() / (exact.volume * size),
            relative(cell.energy, exact.energy, exact.energy),
            relative(cell.area, exact.area, exact.area.max(size * size)),
            (cell.area_moment - exact.area_moment).length() / (exact.area.max(size * size) * size),
        ];
        assert!(errors.iter().all(|&e| e < 1e-10), "{name}, cell {i}: {errors:?} {cell:?} {exact:?}");
    }
}

#[test]
fn cells_of_a_cube_and_of_a_torus() {
    assert_agree("cube", &Shape::cube().surface().expect("a cube"), 30, 1);
    assert_agree("torus", &Shape::torus(12, 8, 1.0, 0.4).surface().expect("a torus"), 30, 3);
}

#[test]
fn cells_of_models_with_creases_and_holes_where_they_exist() {
    let file = std::path::Path::new("../shared/models/joint.obj");
    if file.exists() {
        assert_agree("joint", &tetcvt::io::read_surface(file).expect("a surface"), 40, 8);
    }
}
