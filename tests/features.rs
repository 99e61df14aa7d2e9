//! Creases, corners and patches.

use glam::DVec3;
use tetcvt::surface::features::Features;

use crate::shapes::Shape;

fn features(shape: &Shape, angle: f64) -> Features {
    Features::find(&shape.surface().expect("a shape"), angle)
}

fn patches(features: &Features) -> u32 {
    features.face.iter().max().expect("triangles") + 1
}

#[test]
fn a_cube_has_eight_corners_twelve_edges_six_sides() {
    let f = features(&Shape::cube(), 40.0);
    assert_eq!((f.corners.len(), f.curves.len(), patches(&f)), (8, 12, 6));
    let none = features(&Shape::cube(), 180.0);
    assert_eq!((none.corners.len(), none.curves.len(), patches(&none)), (0, 0, 1));
    // Creases of 90 degrees are no sharper than 90.
    let exact = features(&Shape::cube(), 90.5);
    assert_eq!((exact.curves.len(), patches(&exact)), (0, 1));
}

#[test]
fn creases_are_chained_through_the_vertices_along_them() {
    // Twelve edges; the middle vertex on one of the L's edges is no corner.
    let surface =
        tetcvt::io::read_surface(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/bad/polygons.obj"))
            .expect("the prism");
    let f = Features::find(&surface, 40.0);
    assert_eq!((f.corners.len(), f.curves.len(), patches(&f)), (12, 18, 8));
    let long: Vec<_> = f.curves.iter().filter(|c| c.vertices.len() == 3).collect();
    assert_eq!(long.len(), 2);
    let scale = surface.frame().scale;
    for curve in &long {
        assert!((curve.length() / scale - 2.0).abs() < 1e-15);
        let quarter = curve.point_at(0.25 * curve.length(), surface.points());
        let (at, distance2) = curve.closest(quarter, surface.points());
        assert!(distance2 < 1e-30 && (at - 0.25 * curve.length()).abs() < 1e-15);
        let off = quarter + DVec3::Z * 0.1;
        assert!((curve.closest(off, surface.points()).0 - at).abs() < 1e-12);
    }
}

#[test]
fn the_rims_of_a_cylinder_are_loops() {
    let n = 24;
    let ring = |z: f64| {
        (0..n).map(move |i| {
            let u = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            DVec3::new(u.cos(), u.sin(), z)
        })
    };
    let mut shape = Shape { points: ring(0.0).chain(ring(1.0)).collect(), faces: vec![] };
    shape.points.extend([DVec3::ZERO, DVec3::Z]);
    for i in 0..n {
        let j = (i + 1) % n;
        shape.faces.extend([
            vec![i, j, j + n],
            vec![i, j + n, i + n],
            vec![j, i, 2 * n],
            vec![i + n, j + n, 2 * n + 1],
        ]);
    }
    let surface = shape.surface().expect("a cylinder");
    let f = Features::find(&surface, 40.0);
    assert_eq!((f.corners.len(), f.curves.len(), patches(&f)), (0, 2, 3));
    for curve in &f.curves {
        assert!(curve.is_closed() && curve.vertices.len() == n as usize + 1);
        let length = curve.length();
        let p = curve.point_at(length + 0.01, surface.points());
        assert!(p.distance(curve.point_at(0.01, surface.points())) < 1e-15);
        assert!((curve.closest(p, surface.points()).0 - 0.01).abs() < 1e-15);
    }

    // A tall cone: its tip is a corner though no crease ends there.
    shape.points[2 * n as usize + 1] = DVec3::Z * 4.0;
    shape.points[n as usize..2 * n as usize].iter_mut().for_each(|p| *p = DVec3::new(p.x * 0.5, p.y * 0.5, 2.0));
    let cone = shape.surface().expect("a cone");
    let f = Features::find(&cone, 40.0);
    assert_eq!((f.corners.len(), f.curves.len(), patches(&f)), (1, 1, 2));
    assert_eq!(cone.frame().to_model(cone.points()[f.corners[0] as usize]), DVec3::Z * 4.0);
}

#[test]
fn every_crease_lies_in_one_curve_and_parts_patches() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/bunny.obj");
    let surface = tetcvt::io::read_surface(&path).expect("the bunny");
    let f = Features::find(&surface, 30.0);
    let mut edges: Vec<[u32; 2]> =
        f.curves.iter().flat_map(|c| c.vertices.windows(2).map(|w| [w[0].min(w[1]), w[0].max(w[1])])).collect();
    let count = edges.len();
    edges.sort_unstable();
    edges.dedup();
    assert_eq!(edges.len(), count, "a crease is in two curves");
    // Counted anew, edge by edge.
    let mut sides = std::collections::BTreeMap::<[u32; 2], Vec<u32>>::new();
    for (t, v) in surface.triangles().iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (v[i], v[(i + 1) % 3]);
            sides.entry([a.min(b), a.max(b)]).or_default().push(t as u32);
        }
    }
    for (edge, ts) in sides {
        let [n, m] = [ts[0], ts[1]].map(|t| {
            let [a, b, c] = surface.corners(t);
            (b - a).cross(c - a)
        });
        let sharp = n.angle_between(m).to_degrees() > 30.0;
        assert_eq!(edges.binary_search(&edge).is_ok(), sharp, "{edge:?}");
        assert!(sharp || f.face[ts[0] as usize] == f.face[ts[1] as usize]);
    }
    for curve in f.curves.iter().filter(|c| !c.is_closed()) {
        for end in [curve.vertices[0], curve.vertices[curve.vertices.len() - 1]] {
            assert!(f.corners.binary_search(&end).is_ok());
        }
    }
}
