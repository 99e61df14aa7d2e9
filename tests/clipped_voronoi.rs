//! Moments of clipped cells against closed forms, Monte Carlo and the identities that must always hold.

use glam::{DMat3, DVec3};
use tetcvt::Surface;
use tetcvt::clipped_voronoi::{ClippedVoronoi, Clipper};
use tetcvt::delaunay::Delaunay;
use tetcvt::geometry::frame::snap;
use tetcvt::geometry::tetrahedron;

use crate::shapes::Shape;
use crate::support::Rng;

fn surface(shape: Shape) -> Surface {
    shape.surface().expect("a valid shape")
}

/// The box [0, 1]^3.
fn unit_cube() -> Surface {
    surface(Shape::cuboid(DVec3::ZERO, DVec3::ONE))
}

/// Seeds given in model coordinates, in the frame of the surface.
fn seeds(surface: &Surface, points: impl IntoIterator<Item = DVec3>) -> Vec<DVec3> {
    points.into_iter().map(|p| surface.frame().to_frame(p)).collect()
}

fn clip(surface: &Surface, seeds: &[DVec3]) -> (Delaunay, ClippedVoronoi) {
    let delaunay = Delaunay::build(seeds).expect("seeds in general position");
    delaunay.check().expect("a Delaunay triangulation");
    let clipped = Clipper::new(surface).clip(&delaunay);
    assert_identities(surface, &clipped);
    (delaunay, clipped)
}

fn assert_identities(surface: &Surface, clipped: &ClippedVoronoi) {
    let volume: f64 = clipped.cells.iter().map(|c| c.volume).sum();
    let area: f64 = clipped.cells.iter().map(|c| c.area).sum();
    assert!((volume / surface.volume() - 1.0).abs() < 1e-12, "volumes sum to {volume}, not {}", surface.volume());
    assert!((area / surface.area() - 1.0).abs() < 1e-12, "areas sum to {area}, not {}", surface.area());
    for (i, cell) in clipped.cells.iter().enumerate() {
        assert!(cell.volume > -1e-14 && cell.energy > -1e-14, "cell {i}: {cell:?}");
    }
}

fn grid(n: usize, at: impl Fn(usize) -> f64) -> Vec<DVec3> {
    let mut points = Vec::new();
    for x in 0..n {
        for y in 0..n {
            points.extend((0..n).map(|z| DVec3::new(at(x), at(y), at(z))));
        }
    }
    points
}

#[test]
fn a_grid_of_cell_centres_cuts_a_cube_into_equal_cubes() {
    // Every Voronoi vertex is the meeting of eight cells, every edge of four: all ties.
    let surface = unit_cube();
    for n in [2, 3, 5, 8] {
        let h = 1.0 / n as f64;
        let (_, clipped) = clip(&surface, &seeds(&surface, grid(n, |i| (i as f64 + 0.5) * h)));
        let h = h * surface.frame().scale;
        for cell in &clipped.cells {
            assert!((cell.volume / h.powi(3) - 1.0).abs() < 1e-12, "{n}: {cell:?}");
            assert!(cell.moment.length() < 1e-12 * h.powi(4), "{n}: {cell:?}");
            assert!((cell.energy / (h.powi(5) / 4.0) - 1.0).abs() < 1e-12, "{n}: {cell:?}");
            let faces = (cell.area / h.powi(2)).round();
            assert!((cell.area / h.powi(2) - faces).abs() < 1e-11 && faces <= 3.0, "{n}: {cell:?}");
        }
    }
}

#[test]
fn seeds_on_the_faces_own_halves_quarters_and_eighths() {
    let surface = unit_cube();
    let n = 5;
    let h = 1.0 / (n - 1) as f64;
    let points = grid(n, |i| i as f64 * h);
    let (_, clipped) = clip(&surface, &seeds(&surface, points.iter().copied()));
    let h = h * surface.frame().scale;
    for (p, cell) in points.iter().zip(&clipped.cells) {
        let on_faces = p.to_array().iter().filter(|&&x| x == 0.0 || x == 1.0).count() as i32;
        let volume = h.powi(3) / 2f64.powi(on_faces);
        assert!((cell.volume / volume - 1.0).abs() < 1e-11, "{p}: {cell:?}");
        let area = on_faces as f64 * h * h / 2f64.powi(on_faces - 1);
        assert!((cell.area - area).abs() < 1e-12 * h * h, "{p}: {cell:?}");
    }
}

#[test]
fn bisectors_that_coincide_with_the_faces_give_all_to_one_side() {
    // The outermost layers of seeds are mirror images in the faces of the cube.
    let surface = unit_cube();
    let n = 4;
    let h = 1.0 / n as f64;
    let points = grid(n + 2, |i| (i as f64 - 0.5) * h);
    // The seeds outside the cube are outside the unit frame's half, but on its grid.
    let (_, clipped) = clip(&surface, &seeds(&surface, points.iter().copied()));
    let h = h * surface.frame().scale;
    for (p, cell) in points.iter().zip(&clipped.cells) {
        let inside = p.min_element() > 0.0 && p.max_element() < 1.0;
        let volume = if inside { h.powi(3) } else { 0.0 };
        assert!((cell.volume - volume).abs() < 1e-12 * h.powi(3), "{p}: {cell:?}");
    }
}

#[test]
fn a_tilted_cube_and_a_lattice_that_is_aligned_with_it() {
    // The same coincidences as above, every one of them blurred by rounding.
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let mut shape = Shape::cuboid(DVec3::ZERO, DVec3::ONE);
    shape.points.iter_mut().for_each(|p| *p = turn * *p);
    let surface = surface(shape);
    let n = 6;
    let h = 1.0 / n as f64;
    for offset in [0.0, -0.5, 0.5] {
        let points = grid(n + 1, |i| (i as f64 + offset) * h);
        let (_, clipped) = clip(&surface, &seeds(&surface, points.iter().map(|&p| turn * p)));
        let cell = h.powi(3) * surface.frame().scale.powi(3);
        for (p, c) in points.iter().zip(&clipped.cells) {
            let width = |x: f64| ((x + h / 2.0).min(1.0) - (x - h / 2.0).max(0.0)).max(0.0) / h;
            let exact = cell * p.to_array().map(width).iter().product::<f64>();
            assert!((c.volume - exact).abs() < 1e-9 * cell, "{offset} {p}: {} instead of {exact}", c.volume);
        }
    }
}

#[test]
fn random_seeds_in_every_shape_share_out_volume_and_area() {
    let plate = Shape::cuboid(DVec3::ZERO, DVec3::new(1.0, 0.8, 0.01));
    let hollow = Shape::cuboid(DVec3::ZERO, DVec3::ONE)
        .with(&Shape::icosphere(2, 0.3).placed(DVec3::splat(0.5), 1.0).reversed());
    let shapes = [
        ("cube", Shape::cuboid(DVec3::ZERO, DVec3::ONE)),
        ("torus", Shape::torus(48, 24, 1.0, 0.4)),
        ("plate", plate),
        ("icosphere", Shape::icosphere(4, 1.0)),
        ("hollow cube", hollow),
    ];
    for (name, shape) in shapes {
        let surface = surface(shape);
        for (count, seed) in [(4, 1), (5, 2), (10, 3), (100, 4), (1000, 5), (5000, 6)] {
            let mut rng = Rng(seed);
            let points = (0..count).map(|_| snap(rng.point() * 0.9));
            let (delaunay, clipped) = clip(&surface, &points.collect::<Vec<_>>());
            // What the crossings say of every circumcentre is what a ray says, but for those within rounding.
            for (t, v) in delaunay.vertices().iter().enumerate().filter(|(_, v)| v[3] != u32::MAX) {
                let [a, b, c, d] = v.map(|i| delaunay.points()[i as usize]);
                let center = tetrahedron::circumcenter(a, b, c, d);
                if center.abs().max_element() > 0.6 {
                    assert!(!clipped.inside[t], "{name} {count}: {center} is far outside");
                } else if surface.tree().closest(center).distance2 > 1e-16 {
                    assert_eq!(clipped.inside[t], surface.tree().is_inside(center), "{name} {count}: {center}");
                }
            }
        }
    }
}

#[test]
fn cells_agree_with_monte_carlo() {
    let surface = surface(Shape::torus(48, 24, 1.0, 0.4));
    let mut rng = Rng(7);
    let points: Vec<DVec3> = (0..40).map(|_| snap(rng.point())).collect();
    let (_, clipped) = clip(&surface, &points);
    let samples = 400_000;
    let mut hits = vec![(0.0, DVec3::ZERO, 0.0); points.len()];
    for _ in 0..samples {
        let x = rng.point();
        if surface.tree().is_inside(x) {
            let nearest = (0..points.len()).min_by(|&a, &b| x.distance(points[a]).total_cmp(&x.distance(points[b])));
            let i = nearest.expect("forty seeds");
            let r = x - points[i];
            hits[i].0 += 1.0;
            hits[i].1 += r;
            hits[i].2 += r.length_squared();
        }
    }
    for (cell, (count, moment, energy)) in clipped.cells.iter().zip(hits) {
        let n = samples as f64;
        let bound = 5.0 * (cell.volume.max(1e-5) / n).sqrt();
        assert!((cell.volume - count / n).abs() < bound, "{cell:?} {}", count / n);
        assert!((cell.moment - moment / n).length() < bound, "{cell:?} {}", moment / n);
        assert!((cell.energy - energy / n).abs() < bound, "{cell:?} {}", energy / n);
    }
}

#[test]
fn the_same_bytes_on_one_thread_and_on_three() {
    let surface = surface(Shape::torus(96, 48, 1.0, 0.4));
    let mut rng = Rng(8);
    let points: Vec<DVec3> = (0..6000).map(|_| snap(rng.point())).collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
        pool.install(|| clip(&surface, &points).1)
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one.cells, three.cells);
    assert_eq!(one.inside, three.inside);
    assert_eq!(one.crossings, three.crossings);
}

#[test]
fn what_a_clipper_remembers_changes_nothing() {
    // Triangles much larger than cells, and much smaller; steps from none to far beyond the spacing; a seed more.
    for (surface, count) in [(unit_cube(), 3000), (surface(Shape::torus(96, 48, 1.0, 0.4)), 400)] {
        let mut rng = Rng(9);
        let mut points: Vec<DVec3> = (0..count).map(|_| snap(rng.point())).collect();
        let mut delaunay = Delaunay::build(&points).expect("seeds in general position");
        let mut clipper = Clipper::new(&surface);
        for step in [0.0, 1e-5, 1e-3, 1e-3, 0.0, 0.3] {
            points.iter_mut().for_each(|p| *p = snap(*p + rng.point() * step));
            delaunay.relocate(&points).expect("seeds in general position");
            assert_same(&clipper.clip(&delaunay), &Clipper::new(&surface).clip(&delaunay));
        }
        points.push(snap(rng.point()));
        let delaunay = Delaunay::build(&points).expect("seeds in general position");
        let clipped = clipper.clip(&delaunay);
        assert_same(&clipped, &Clipper::new(&surface).clip(&delaunay));
        assert_eq!(*clipped.adjacency, delaunay.adjacency());
        assert_identities(&surface, &clipped);
    }
}

fn assert_same(a: &ClippedVoronoi, b: &ClippedVoronoi) {
    assert_eq!(a.cells, b.cells);
    assert_eq!(a.inside, b.inside);
    assert_eq!(a.crossings, b.crossings);
    assert_eq!(a.adjacency, b.adjacency);
}
