//! The box tree against brute force, with exact arithmetic where signs decide.

use glam::DVec3;
use num_bigint::BigInt;
use num_traits::Zero;
use tetcvt::geometry::predicates::Sign;
use tetcvt::geometry::triangle;
use tetcvt::surface::box_tree::BoxTree;

use crate::shapes::Shape;
use crate::support::{Rng, exact, exact_orient3d};

/// Points in general and in special position: vertices, middles of edges and faces, points straight below them, the
/// grid around, and far ones.
fn queries(points: &[DVec3], triangles: &[[u32; 3]], size: f64) -> Vec<DVec3> {
    let mut rng = Rng(7);
    let mut queries: Vec<DVec3> = (0..200).map(|_| rng.point() * 2.4 * size).collect();
    for t in triangles.iter().step_by(triangles.len() / 60 + 1) {
        let [a, b, c] = t.map(|v| points[v as usize]);
        for p in [a, (a + b) * 0.5, (a + b + c) / 3.0, (a + a + b) / 3.0] {
            let down = DVec3::Z * 0.375 * size;
            queries.extend([p, p - down, p + down, p * 0.5, p * 1.5]);
        }
    }
    queries.extend([DVec3::ZERO, DVec3::X * size, DVec3::splat(-1e5 * size), DVec3::new(0.0, 0.0, -1e5) * size]);
    queries
}

/// The inside test by definition: the parity of the triangles above the query moved by (e, e^2, e^3), in exact
/// arithmetic with e a true, tiny number.
fn inside_exactly(points: &[DVec3], triangles: &[[u32; 3]], p: DVec3) -> bool {
    // Every coordinate times 2^shift and then times 2^600; e = 2^-200 in the first unit is tiny against any sign.
    let scaled = |p: DVec3| exact(p).map(|x| x << 900u32);
    let mut q = scaled(p);
    for (i, x) in q.iter_mut().enumerate() {
        *x += BigInt::from(1) << (600u32 - 300 * i as u32);
    }
    let above = |t: &&[u32; 3]| {
        let [a, b, c] = t.map(|v| scaled(points[v as usize]));
        let flat = |u: &[BigInt; 3], v: &[BigInt; 3]| {
            let area = (&u[0] - &q[0]) * (&v[1] - &q[1]) - (&u[1] - &q[1]) * (&v[0] - &q[0]);
            area.cmp(&BigInt::zero())
        };
        // Zero only along a vertical edge: no ray crosses that triangle.
        let turns = [flat(&a, &b), flat(&b, &c), flat(&c, &a)];
        if turns[0] != turns[1] || turns[1] != turns[2] {
            return false;
        }
        let side = exact_orient3d([&a, &b, &c, &q]);
        assert!(side != Sign::Zero, "perturbed");
        (side == Sign::Negative) == turns[0].is_gt()
    };
    triangles.iter().filter(above).count() % 2 == 1
}

#[test]
fn inside_tests_are_exact_in_general_and_special_position() {
    let grid_cube = Shape::cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
    let hollow = Shape::cube().with(&Shape::icosphere(1, 0.5).reversed()).placed(DVec3::ZERO, 0.25);
    let needle = Shape::icosphere(1, 0.5).placed(DVec3::ZERO, 1.0);
    let needle = Shape { points: needle.points.iter().map(|p| *p * DVec3::new(1.0, 1e-6, 1.0)).collect(), ..needle };
    for (name, shape) in
        [("cube", grid_cube), ("hollow", hollow), ("torus", Shape::torus(12, 8, 0.35, 0.14)), ("needle", needle)]
    {
        let triangles = shape.triangles();
        let tree = BoxTree::build(&shape.points, &triangles);
        let mut inside = 0;
        for p in queries(&shape.points, &triangles, 0.5) {
            // The oracle has one denominator for all: the grid of 2^-200.
            let p = (p + 0.0).clamp(DVec3::splat(-1e6), DVec3::splat(1e6));
            let answer = tree.is_inside(p);
            assert_eq!(answer, inside_exactly(&shape.points, &triangles, p), "{name}: {p}");
            inside += usize::from(answer);
        }
        assert!(inside > 20, "{name}: {inside}");
    }
}

#[test]
fn inside_tests_are_right_at_any_offset_and_scale() {
    let sphere = Shape::icosphere(3, 1.0);
    let mut rng = Rng(3);
    let directions: Vec<DVec3> = (0..500).map(|_| rng.point().normalize()).collect();
    for (offset, scale) in [(0.0, 1.0), (1e3, 1.0), (1e7, 1.0), (0.0, 1e-12), (0.0, 1e12), (1.0, 1e-6)] {
        let there = sphere.clone().placed(DVec3::splat(offset), scale);
        let tree = BoxTree::build(&there.points, &there.triangles());
        for d in &directions {
            // The polyhedron lies between the spheres of radius 0.99 and 1.
            let at = |r: f64| DVec3::splat(offset) + *d * (r * scale);
            assert!(tree.is_inside(at(0.985)) && !tree.is_inside(at(1.001)), "{offset} {scale} {d}");
        }
    }
}

#[test]
fn two_solids_that_share_a_face_share_no_point() {
    let [left, right] = [-1.0, 0.0].map(|x| {
        let shape = Shape::cuboid(DVec3::new(x, 0.0, 0.0), DVec3::new(x + 1.0, 1.0, 1.0));
        BoxTree::build(&shape.points, &shape.triangles())
    });
    for i in 0..=8 {
        for j in 0..=8 {
            let p = DVec3::new(0.0, f64::from(i) / 8.0, f64::from(j) / 8.0);
            let [l, r] = [&left, &right].map(|t| t.is_inside(p));
            assert!(!(l && r), "{p}");
            assert!(l || r || i == 8 || j == 8, "{p}");
        }
    }
}

#[test]
fn closest_points_are_those_of_brute_force() {
    for (name, shape) in [
        ("cube", Shape::cube()),
        ("sphere", Shape::icosphere(3, 1.0)),
        ("torus", Shape::torus(24, 12, 0.7, 0.3)),
        ("far", Shape::icosphere(2, 1.0).placed(DVec3::splat(1e6), 1.0)),
        ("tiny", Shape::icosphere(2, 1e-9)),
    ] {
        let triangles = shape.triangles();
        let tree = BoxTree::build(&shape.points, &triangles);
        let center = if name == "far" { DVec3::splat(1e6) } else { DVec3::ZERO };
        let size = if name == "tiny" { 1e-9 } else { 1.0 };
        let local: Vec<DVec3> = shape.points.iter().map(|p| *p - center).collect();
        for q in queries(&local, &triangles, size) {
            let p = center + q;
            let brute = triangles.iter().enumerate().map(|(t, v)| {
                let point = triangle::closest_point(v.map(|v| shape.points[v as usize]), p);
                (point.distance_squared(p), t as u32)
            });
            let (distance2, t) = brute.min_by(|a, b| a.partial_cmp(b).expect("finite")).expect("triangles");
            let found = tree.closest(p);
            assert_eq!((found.distance2, found.triangle), (distance2, t), "{name}: {p}");
            assert_eq!(found.point.distance_squared(p), distance2);
            // A guess changes nothing, however good or bad.
            for guess in [0, triangles.len() as u32 / 2, t] {
                let corners = triangles[guess as usize].map(|v| shape.points[v as usize]);
                assert_eq!(tree.closest_near(p, guess, corners), found, "{name}: {p} from {guess}");
            }
        }
    }
}

#[test]
fn the_closest_point_of_a_triangle_is_no_farther_than_any_sample() {
    let mut rng = Rng(11);
    for i in 0..2000 {
        let flat = DVec3::new(1.0, if i % 3 == 0 { 1e-9 } else { 1.0 }, 1.0);
        let [a, b, c] = [0; 3].map(|_| rng.point() * flat);
        let p = rng.point() * 2.0;
        let best = triangle::closest_point([a, b, c], p).distance(p);
        for _ in 0..50 {
            let (u, v) = (rng.unit(), rng.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let sample = a + (b - a) * u + (c - a) * v;
            assert!(best <= sample.distance(p) + 1e-8, "{a} {b} {c} {p}: {best}");
        }
    }
}

#[test]
fn boxes_and_rays_find_what_brute_force_finds() {
    let shape = Shape::torus(24, 12, 0.7, 0.3);
    let triangles = shape.triangles();
    let corners: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|v| shape.points[v as usize])).collect();
    let tree = BoxTree::build(&shape.points, &triangles);
    let mut rng = Rng(5);
    let mut hits = 0;
    for _ in 0..500 {
        let (p, q) = (rng.point() * 2.0, rng.point() * 2.0);
        let (min, max) = (p.min(q), p.max(q));
        let mut found = vec![];
        tree.near_box(min, max, |t| found.push(t));
        found.sort_unstable();
        let meets = |c: &[DVec3; 3]| {
            let (low, high) = (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2]));
            low.cmple(max).all() && min.cmple(high).all()
        };
        let brute: Vec<u32> = (0..corners.len() as u32).filter(|&t| meets(&corners[t as usize])).collect();
        assert_eq!(found, brute);

        // A ray leaves the torus at the surface: the middle between two crossings is alternately in and out.
        let mut at = 0.0;
        let mut inside = tree.is_inside(p);
        while let Some((t, _)) = tree.ray(p + (q - p) * at, q - p, 1.0 - at) {
            let next = at + t;
            let middle = p + (q - p) * (0.5 * (at + next));
            assert_eq!(tree.is_inside(middle), inside, "{p} {q}");
            inside = !inside;
            at = next + 1e-9;
            hits += 1;
        }
        assert_eq!(tree.is_inside(q), inside, "{p} {q}");
    }
    assert!(hits > 100);
    // Along an axis, through vertices and edges, and in the plane of a face.
    let cube = Shape::cube();
    let tree = BoxTree::build(&cube.points, &cube.triangles());
    for y in [-1.0, -0.5, 0.0, 1.0] {
        let hit = tree.ray(DVec3::new(-3.0, y, 0.0), DVec3::X, 10.0).expect("a side");
        assert_eq!(hit.0, 2.0);
    }
    assert_eq!(tree.ray(DVec3::new(-3.0, 1.5, 0.0), DVec3::X, 10.0), None);
    assert_eq!(tree.ray(DVec3::new(-3.0, 0.0, 0.0), DVec3::X, 1.5), None);
}

#[test]
fn trees_of_no_of_one_and_of_equal_triangles_work() {
    let points = Shape::tetrahedron().points;
    let empty = BoxTree::build(&points, &[]);
    assert!(!empty.is_inside(DVec3::ZERO));
    assert_eq!(empty.ray(DVec3::ZERO, DVec3::X, 1.0), None);
    let one = BoxTree::build(&points, &[[1, 2, 3]]);
    assert_eq!(one.closest(DVec3::ZERO).triangle, 0);
    let many = BoxTree::build(&points, &vec![[1, 2, 3]; 3000]);
    assert_eq!(many.closest(DVec3::ONE).triangle, 0);
    let mut count = 0;
    many.near_box(DVec3::ZERO, DVec3::ONE, |_| count += 1);
    assert_eq!(count, 3000);
}
