//! Surfaces that cross or touch themselves; what is mended on request; the shared bad surfaces.

use std::path::Path;

use glam::{DQuat, DVec3};
use tetcvt::surface::defects::{Defect, Flaw, Marks, Shape as MarkShape};
use tetcvt::surface::{Mending, Regions, Treatment};
use tetcvt::{Surface, io};

use crate::shapes::{self, Shape};
use crate::support::Rng;

fn build(shape: &Shape, mending: Mending, marks: &mut Marks) -> Result<Surface, Defect> {
    let triangles = shape.triangles();
    let source: Vec<u32> = (0..triangles.len() as u32).collect();
    let treatment = Treatment { mending, regions: Regions::Parity };
    Surface::build(&shape.points, &triangles, [&source, &vec![0; triangles.len()]], treatment, marks)
}

fn repaired(shape: &Shape) -> Result<Surface, Defect> {
    build(shape, Mending::Repair, &mut Marks::default())
}

fn is_crossing(shape: &Shape) -> bool {
    match shape.surface() {
        Ok(_) => false,
        Err(Defect::SelfCrossing { .. }) => true,
        Err(other) => panic!("{other}"),
    }
}

fn cube(x: f64, y: f64, z: f64) -> Shape {
    Shape::cube().placed(DVec3::new(x, y, z), 1.0)
}

#[test]
fn whatever_meets_is_refused_and_what_only_nearly_meets_is_not() {
    let small = |x: f64, y: f64, z: f64| Shape::cube().placed(DVec3::new(x, y, z), 0.25);
    let tip = |z: f64| {
        // A tetrahedron that stands on its tip.
        let mut tip = Shape::tetrahedron();
        tip.points = vec![
            DVec3::new(0.1, 0.2, z),
            DVec3::new(1.0, 0.0, 3.0),
            DVec3::new(-1.0, 0.7, 3.0),
            DVec3::new(0.0, -1.0, 3.0),
        ];
        tip
    };
    let gap = 2f64.powi(-40);
    for (what, with, meets) in [
        ("overlapping cubes", cube(1.0, 0.5, 0.25), true),
        ("a cube on a side", small(0.1, 0.2, 1.25), true),
        ("a cube over a side", small(0.1, 0.2, 1.25 + gap), false),
        ("a cube flush inside a side", small(0.1, 0.2, 0.75), true),
        ("a cube in a cube", small(0.1, 0.2, 0.3), false),
        ("sides that overlap in part", cube(2.0, 0.5, 0.3), true),
        ("edges that cross", cube(1.0 + gap, 0.0, 2.0), true),
        ("edges on each other in part", cube(2.0, 0.5, 2.0), true),
        ("edges that nearly are", cube(2.0 + gap, 0.5, 2.0), false),
        ("a tip in a side", tip(1.0), true),
        ("a tip through a side", tip(1.0 - gap), true),
        ("a tip over a side", tip(1.0 + gap), false),
        ("spheres through each other", Shape::icosphere(2, 1.3), true),
    ] {
        let shape = Shape::cube().with(&with);
        assert_eq!(is_crossing(&shape), meets, "{what}");
        assert_eq!(is_crossing(&with.with(&Shape::cube())), meets, "{what}, in the other order");
    }
}

#[test]
fn parts_of_one_shell_that_meet_are_refused() {
    // A sphere whose pole is pushed inward: short of, onto and through the other side.
    let pushed = |to: f64| {
        let mut sphere = Shape::icosphere(2, 1.0);
        let pole = (0..sphere.points.len())
            .max_by(|&a, &b| sphere.points[a].z.total_cmp(&sphere.points[b].z))
            .expect("points");
        sphere.points[pole].z = to;
        sphere
    };
    assert!(!is_crossing(&pushed(0.5)) && !is_crossing(&pushed(-0.5)) && is_crossing(&pushed(-1.5)));
    // A face folded onto its neighbour: one vertex of a flat side moved in its plane beyond an edge.
    let mut cube = shapes::cube_with_needle();
    cube.points[8] += DVec3::new(0.5, -0.5, 0.0);
    assert!(is_crossing(&cube));
    cube.points[8] = DVec3::new(-0.5, 0.5, 1.0);
    assert!(!is_crossing(&cube));
}

#[test]
fn crossings_are_found_wherever_the_surface_stands() {
    let crossing = Shape::torus(24, 12, 1.0, 0.4).with(&Shape::torus(24, 12, 1.0, 0.4).placed(DVec3::X * 1.05, 1.0));
    let linked = {
        // Two links of a chain, nearly touching.
        let turn = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        let mut other = Shape::torus(24, 12, 1.0, 0.3).placed(DVec3::X, 1.0);
        other.points.iter_mut().for_each(|p| *p = turn * *p);
        Shape::torus(24, 12, 1.0, 0.3).with(&other)
    };
    let mut rng = Rng(3);
    for _ in 0..30 {
        let turn = DQuat::from_axis_angle((rng.point() - 0.5).normalize(), 7.0 * rng.unit());
        let (shift, scale) = ((rng.point() - 0.5) * 1e3, 10f64.powf(6.0 * rng.unit() - 3.0));
        let place = |shape: &Shape| {
            let mut shape = shape.clone();
            shape.points.iter_mut().for_each(|p| *p = turn * *p * scale + shift * scale);
            shape
        };
        assert!(is_crossing(&place(&crossing)));
        assert!(!is_crossing(&place(&linked)));
    }
}

#[test]
fn a_crossing_is_counted_and_placed() {
    // A thin needle through the top of a cube: its three sides meet the two triangles there, or one.
    let needle =
        Shape::tetrahedron().points.iter().map(|&p| DVec3::new(0.5 + p.x * 0.1, p.y * 0.1, 0.9 + p.z)).collect();
    let shape = Shape::cube().with(&Shape { points: needle, ..Shape::tetrahedron() });
    let mut marks = Marks::default();
    let Err(Defect::SelfCrossing { count, place, other, coplanar }) = build(&shape, Mending::Exact, &mut marks) else {
        panic!("the needle passes the top")
    };
    assert_eq!(count, marks.list.len());
    assert!(marks.list.iter().all(|m| m.0 == Flaw::SelfCrossing && matches!(m.1, MarkShape::Triangle(_))));
    // One triangle of the top, and the three tall sides of the needle.
    assert_eq!(marks.list.iter().map(|m| m.2).filter(|&f| f < 12).count(), 1);
    assert_eq!(count, 4);
    assert!(place.face < 12 && other >= 12 && !coplanar);
    let [x, y, z] = place.point;
    assert!((0.5..=0.6).contains(&x) && (0.0..=0.1).contains(&y) && (z - 1.0).abs() < 1e-12, "{:?}", place.point);
}

#[test]
fn holes_that_are_small_and_flat_are_filled() {
    let whole = Shape::icosphere(3, 1.0);
    let volume = |s: &Surface| s.volume() / s.frame().scale.powi(3);
    for (lost, fills) in [(1, true), (6, true), (20, true), (800, false)] {
        let mut open = whole.clone();
        // The faces nearest to a point of the sphere.
        let center = |f: &[u32]| f.iter().map(|&v| open.points[v as usize]).sum::<DVec3>() / 3.0;
        let mut order: Vec<usize> = (0..open.faces.len()).collect();
        order.sort_by(|&a, &b| {
            let distance = |f: usize| center(&open.faces[f]).distance(DVec3::new(0.6, 0.0, 0.8));
            distance(a).total_cmp(&distance(b))
        });
        let gone = &order[..lost];
        open.faces = (0..order.len()).filter(|f| !gone.contains(f)).map(|f| open.faces[f].clone()).collect();
        assert!(matches!(open.surface(), Err(Defect::Open { .. })));
        match repaired(&open) {
            Ok(surface) => {
                assert!(fills, "{lost}");
                assert!(surface.notes().iter().any(|n| n.contains("1 hole was filled")), "{:?}", surface.notes());
                assert!((volume(&surface) / volume(&whole.surface().expect("whole")) - 1.0).abs() < 0.01, "{lost}");
                assert_eq!((surface.genus(), surface.shell_count()), (0, 1));
            }
            Err(defect) => assert!(!fills && matches!(defect, Defect::Open { .. }), "{lost}: {defect}"),
        }
    }
    // A loose disk is no body with a hole.
    let mut disk = Shape::icosphere(3, 1.0);
    disk.faces.retain(|f| f.iter().all(|&v| disk.points[v as usize].z > 0.95));
    assert!(matches!(repaired(&whole.with(&disk.placed(DVec3::X * 5.0, 1.0))), Err(Defect::Open { .. })));
}

#[test]
fn edges_that_nearly_meet_are_welded() {
    // Each triangle has vertices of its own, a little off.
    let mut rng = Rng(9);
    let shape = Shape::icosphere(2, 1.0);
    for (noise, closes) in [(1e-9, true), (2e-6, true), (1e-3, false)] {
        let points: Vec<DVec3> =
            shape.faces.iter().flatten().map(|&v| shape.points[v as usize] + (rng.point() - 0.5) * noise).collect();
        let soup =
            Shape { faces: (0..points.len() as u32 / 3).map(|t| vec![3 * t, 3 * t + 1, 3 * t + 2]).collect(), points };
        assert!(matches!(soup.surface(), Err(Defect::Open { .. })));
        match repaired(&soup) {
            Ok(surface) => assert!(closes && surface.points().len() == shape.points.len()),
            Err(defect) => assert!(!closes, "{noise}: {defect}"),
        }
    }
}

#[test]
fn what_touches_moves_apart() {
    let corner = Shape::tetrahedron().with(&Shape::tetrahedron().placed(DVec3::ZERO, -1.0).reversed());
    for (shape, moved) in [(corner, 2), (cube(0.0, 0.0, 0.0).with(&cube(2.0, 2.0, 0.0)), 4)] {
        assert!(matches!(shape.surface(), Err(Defect::NonManifoldVertices { .. } | Defect::NonManifoldEdges { .. })));
        let surface = repaired(&shape).expect("two bodies");
        assert_eq!(surface.shell_count(), 2);
        assert!(surface.notes().iter().any(|n| n.starts_with(&format!("{moved} vertices"))), "{:?}", surface.notes());
    }
}

#[test]
fn walls_sheets_and_copies_go() {
    // Two cubes with a common side become one body.
    let joined = repaired(&cube(0.0, 0.0, 0.0).with(&cube(2.0, 0.0, 0.0))).expect("one body");
    assert_eq!((joined.shell_count(), joined.triangles().len()), (1, 20));
    assert!((joined.volume() / joined.frame().scale.powi(3) - 16.0).abs() < 1e-12);
    // One triangle twice.
    let mut twice = Shape::cube();
    twice.faces.push(vec![4, 5, 7]);
    assert_eq!(repaired(&twice).expect("a cube").triangles().len(), 12);
    // A fin on an edge.
    let mut fin = Shape::cube();
    fin.points.push(DVec3::new(2.0, 0.0, 2.0));
    fin.faces.push(vec![5, 7, 8]);
    assert!(fin.surface().is_err());
    let surface = repaired(&fin).expect("a cube");
    assert_eq!(surface.triangles().len(), 12);
    assert!(surface.notes().iter().any(|n| n.contains("sheet")), "{:?}", surface.notes());
}

#[test]
fn repair_leaves_sound_surfaces_alone_and_never_lets_a_bad_one_pass() {
    for (name, text) in shapes::models() {
        let soup = io::read::parse(text.as_bytes(), Path::new(name)).expect(name);
        let surface = soup
            .check_as(Treatment { mending: Mending::Repair, ..Treatment::default() }, &mut Marks::default())
            .expect(name);
        assert!(surface.notes().is_empty(), "{name}: {:?}", surface.notes());
    }
    let mut rng = Rng(23);
    let mut mended = 0;
    for i in 0..300 {
        let mut shape =
            [Shape::icosphere(1, 1.0), Shape::torus(8, 5, 1.0, 0.4), cube(0.0, 0.0, 0.0).with(&cube(2.0, 0.0, 0.0))]
                [i % 3]
                .clone();
        for _ in 0..1 + rng.below(3) {
            let victim = rng.below(shape.faces.len());
            match rng.below(4) {
                0 => drop(shape.faces.swap_remove(victim)),
                1 => shape.faces.push(shape.faces[victim].clone()),
                2 => {
                    let vertex = rng.below(shape.points.len()) as u32;
                    shape.faces[victim][rng.below(3)] = vertex;
                }
                _ => {
                    let copy = shape.points[shape.faces[victim][0] as usize] + (rng.point() - 0.5) * 1e-6;
                    shape.faces[victim][0] = shape.points.len() as u32;
                    shape.points.push(copy);
                }
            }
        }
        let Ok(surface) = repaired(&shape) else { continue };
        mended += 1;
        let mut edges: Vec<[u32; 2]> =
            surface.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        assert!(edges.windows(2).all(|w| w[0] != w[1]), "{i}");
        assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()), "{i}");
    }
    assert!(mended > 100, "{mended}");
}

/// The table of the shared bad surfaces: status, and words of the refusal.
const SHARED: [(&str, u8, &str); 23] = [
    ("degen_capsule.obj", 0, ""),
    ("degen_rust_logo.obj", 0, ""),
    ("dup_bunny_trimesh.ply", 1, "open"),
    ("flip_blobby_shuffled.off", 0, ""),
    ("flip_multibody.stl", 0, ""),
    ("fold_double_torus_cad.off", 0, ""),
    ("huge_coords_box.obj", 0, ""),
    ("inside_out_npm_bunny.obj", 0, ""),
    ("nested_same_orientation.obj", 0, ""),
    ("nm_joined_tetrahedra.obj", 1, "non-manifold edge"),
    ("nm_shared_edge_cubes.stl", 1, "non-manifold edge"),
    ("nmv_cow.off", 1, "non-manifold vertex"),
    ("nmv_hourglass.obj", 1, "non-manifold vertex"),
    ("open_beetle.off", 1, "open"),
    ("open_bunny_stanford_scan.obj", 1, "open"),
    ("open_moebius.obj", 1, "open"),
    ("si_block.off", 1, "crosses or touches itself: 43 triangles"),
    ("si_dragon25k.off", 1, "crosses or touches itself: 24 triangles"),
    ("si_two_spheres.obj", 1, "crosses or touches itself"),
    // Its vertices differ by less than 2^-52 of its size: as points of the frame they are equal, and it is closed.
    ("soup_featuretype.stl", 0, ""),
    ("soup_random.stl", 1, "open"),
    ("soup_suzanne.obj", 1, "open"),
    ("touch_two_cubes_shared_face_dup.obj", 1, "duplicate faces"),
];

#[test]
fn the_bad_surfaces_shared_between_projects_where_they_exist() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models/bad");
    for (name, status, words) in SHARED {
        let path = folder.join(name);
        if !path.exists() {
            continue;
        }
        let (got, text) = match io::read_surface(&path) {
            Ok(_) => (0, String::new()),
            Err(error) => (error.exit_status(), error.to_string()),
        };
        assert_eq!(got, status, "{name}: {text}");
        assert!(text.contains(words), "{name}: {text}");
    }
}
