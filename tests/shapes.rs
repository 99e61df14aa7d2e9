//! Exact shapes: closed polyhedra whose volume and genus are known, and the files of `models/` made of them.

use std::f64::consts::TAU;
use std::fmt::Write;

use glam::DVec3;

/// A polyhedron, its faces counter-clockwise seen from outside.
#[derive(Clone, Default)]
pub struct Shape {
    pub points: Vec<DVec3>,
    pub faces: Vec<Vec<u32>>,
}

impl Shape {
    /// The box from `min` to `max`, two triangles a side.
    pub fn cuboid(min: DVec3, max: DVec3) -> Shape {
        let at = |i: u32, k: u32, low: f64, high: f64| if i >> k & 1 == 1 { high } else { low };
        let corner = |i| DVec3::new(at(i, 0, min.x, max.x), at(i, 1, min.y, max.y), at(i, 2, min.z, max.z));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [vec![a, b, c], vec![a, c, d]]).collect();
        Shape { points: (0..8).map(corner).collect(), faces }
    }

    /// The box of edge length 2 about the origin.
    pub fn cube() -> Shape {
        Shape::cuboid(DVec3::NEG_ONE, DVec3::ONE)
    }

    /// The tetrahedron over a corner of a cube.
    pub fn tetrahedron() -> Shape {
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].iter().map(|f| f.to_vec()).collect();
        Shape { points: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], faces }
    }

    /// An icosahedron whose triangles are split into four `level` times, all vertices on the sphere.
    pub fn icosphere(level: u32, radius: f64) -> Shape {
        let g = (1.0 + 5f64.sqrt()) / 2.0;
        let ring = [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)];
        let mut points: Vec<DVec3> = ring.iter().map(|&(a, b)| DVec3::new(a, b, 0.0)).collect();
        points.extend(ring.iter().map(|&(a, b)| DVec3::new(0.0, a, b)));
        points.extend(ring.iter().map(|&(a, b)| DVec3::new(b, 0.0, a)));
        // The faces are the triples of vertices that are all two apart.
        let near = |i: usize, j: usize, p: &[DVec3]| (p[i].distance_squared(p[j]) - 4.0).abs() < 1e-9;
        let mut faces = vec![];
        for i in 0..12 {
            for j in i + 1..12 {
                for k in j + 1..12 {
                    if near(i, j, &points) && near(j, k, &points) && near(i, k, &points) {
                        let outward = points[i].cross(points[j]).dot(points[k]) > 0.0;
                        let [j, k] = if outward { [j, k] } else { [k, j] };
                        faces.push(vec![i as u32, j as u32, k as u32]);
                    }
                }
            }
        }
        for _ in 0..level {
            let mut middle = std::collections::BTreeMap::new();
            let mut split = vec![];
            for f in &faces {
                let m: Vec<u32> = (0..3)
                    .map(|i| {
                        let (a, b) = (f[i], f[(i + 1) % 3]);
                        *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                            points.push((points[a as usize] + points[b as usize]) * 0.5);
                            points.len() as u32 - 1
                        })
                    })
                    .collect();
                split.extend((0..3).map(|i| vec![f[i], m[i], m[(i + 2) % 3]]));
                split.push(m);
            }
            faces = split;
            points.iter_mut().for_each(|p| *p = p.normalize() * 2.0);
        }
        points.iter_mut().for_each(|p| *p = p.normalize() * radius);
        Shape { points, faces }
    }

    /// A torus of `m` prisms around the z axis, each over an `n`-gon of circumradius `small` about distance `large`.
    pub fn torus(m: u32, n: u32, large: f64, small: f64) -> Shape {
        let at = |i: u32, j: u32| {
            let (u, v) = (TAU * f64::from(i) / f64::from(m), TAU * f64::from(j) / f64::from(n));
            let r = large + small * v.cos();
            DVec3::new(r * u.cos(), r * u.sin(), small * v.sin())
        };
        let id = |i: u32, j: u32| (i % m) * n + j % n;
        let cells = || (0..m).flat_map(|i| (0..n).map(move |j| (i, j)));
        let faces = cells()
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                [vec![a, b, c], vec![a, c, d]]
            })
            .collect();
        Shape { points: cells().map(|(i, j)| at(i, j)).collect(), faces }
    }

    /// A closed surface with one side only: the figure-eight immersion of the Klein bottle.
    pub fn klein_bottle(m: u32, n: u32) -> Shape {
        let at = |i: u32, j: u32| {
            // Half a step off, so that no two vertices meet where the eight crosses itself.
            let (u, v) = (TAU * f64::from(i) / f64::from(m), TAU * (f64::from(j) + 0.5) / f64::from(n));
            let r = 2.0 + (u / 2.0).cos() * v.sin() - (u / 2.0).sin() * (2.0 * v).sin();
            let z = (u / 2.0).sin() * v.sin() + (u / 2.0).cos() * (2.0 * v).sin();
            DVec3::new(r * u.cos(), r * u.sin(), z)
        };
        let id = |i: u32, j: u32| if i < m { i * n + j % n } else { n - 1 - j % n };
        let cells = || (0..m).flat_map(|i| (0..n).map(move |j| (i, j)));
        let faces = cells().map(|(i, j)| vec![id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]).collect();
        Shape { points: cells().map(|(i, j)| at(i, j)).collect(), faces }
    }

    /// Both, as they are.
    pub fn with(mut self, other: &Shape) -> Shape {
        let base = self.points.len() as u32;
        self.points.extend(&other.points);
        self.faces.extend(other.faces.iter().map(|f| f.iter().map(|v| v + base).collect()));
        self
    }

    /// The same from inside.
    pub fn reversed(mut self) -> Shape {
        self.faces.iter_mut().for_each(|f| f.reverse());
        self
    }

    /// The mirror image with y and -y exchanged: a cube stays, but its diagonals change.
    pub fn mirrored(mut self) -> Shape {
        self.points.iter_mut().for_each(|p| p.y = -p.y);
        self.reversed()
    }

    /// The same elsewhere, larger.
    pub fn placed(mut self, shift: DVec3, scale: f64) -> Shape {
        self.points.iter_mut().for_each(|p| *p = *p * scale + shift);
        self
    }

    /// The triangles, as `Surface::new` wants them.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.faces.iter().map(|f| [f[0], f[1], f[2]]).collect()
    }

    /// The checked surface.
    pub fn surface(&self) -> Result<tetcvt::Surface, tetcvt::surface::defects::Defect> {
        let triangles = self.triangles();
        let source: Vec<u32> = (0..triangles.len() as u32).collect();
        tetcvt::Surface::new(&self.points, &triangles, &source, &vec![0; triangles.len()])
    }

    /// The shape as an OBJ file. Nine decimals, so that no platform's sine shows.
    pub fn obj(&self, caption: &str) -> String {
        let number = |x: f64| {
            let text = format!("{x:.9}");
            let text = text.trim_end_matches('0').trim_end_matches('.');
            if text == "-0" { "0".to_owned() } else { text.to_owned() }
        };
        self.obj_with(caption, number)
    }

    /// The same with numbers written by `number`.
    pub fn obj_with(&self, caption: &str, number: impl Fn(f64) -> String) -> String {
        let mut text = format!("# {caption}\n");
        for p in &self.points {
            writeln!(text, "v {} {} {}", number(p.x), number(p.y), number(p.z)).expect("a string takes all");
        }
        for f in &self.faces {
            let ids: Vec<String> = f.iter().map(|v| (v + 1).to_string()).collect();
            writeln!(text, "f {}", ids.join(" ")).expect("a string takes all");
        }
        text
    }
}

/// The good files of `models/` that are made here: name and text.
pub fn models() -> Vec<(&'static str, String)> {
    let shift = |x: f64| DVec3::new(x, 0.0, 0.0);
    let sphere = || Shape::icosphere(3, 1.0);
    vec![
        ("cube.obj", Shape::cube().obj("cube of edge length 2, 12 triangles")),
        ("icosphere.obj", Shape::icosphere(4, 1.0).obj("icosahedron split four times, on the unit sphere")),
        ("torus.obj", Shape::torus(64, 32, 1.0, 0.4).obj("torus of 64 prisms over 32-gons, radii 1 and 0.4")),
        (
            "hollow_cube.obj",
            Shape::cube()
                .with(&Shape::icosphere(3, 0.6).reversed())
                .obj("cube of edge length 2 with a spherical cavity of radius 0.6"),
        ),
        (
            "two_bodies.obj",
            sphere().with(&Shape::cube().placed(shift(3.0), 1.0)).obj("unit sphere and, apart from it, a cube"),
        ),
        (
            "thin_plate.obj",
            Shape::cuboid(DVec3::ZERO, DVec3::new(2.0, 1.0, 0.02)).obj("plate, 2 x 1 and a fiftieth of that thick"),
        ),
    ]
}

/// The prism over an L, its faces polygons: two concave hexagons and six quads, one with a corner along its edge.
pub fn l_prism() -> Shape {
    let outline = [(2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (0, 0), (1, 0)];
    let n = outline.len() as u32;
    let level = |z: f64| outline.iter().map(move |&(x, y)| DVec3::new(f64::from(x), f64::from(y), z));
    let mut faces = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    // The last corner lies along an edge: the wall over it is one face of six corners.
    faces.extend((0..n - 2).map(|i| vec![i, i + 1, i + 1 + n, i + n]));
    faces.push(vec![5, 6, 0, n, n + 6, n + 5]);
    Shape { points: level(0.0).chain(level(1.0)).collect(), faces }
}

/// A cube with a triangle without area: the diagonal of one side has a vertex in its middle on one side only.
pub fn cube_with_needle() -> Shape {
    let mut cube = Shape::cube();
    // Side z = 1 is (4, 5, 7) and (4, 7, 6).
    cube.points.push(DVec3::Z);
    let split = cube.faces.iter().position(|f| *f == [4, 7, 6]).expect("the cube has this face");
    cube.faces[split] = vec![8, 7, 6];
    cube.faces.push(vec![4, 8, 6]);
    cube.faces.push(vec![4, 7, 8]);
    cube
}

/// The files of `models/bad/`: name and content. What each must give is in the table of the README there.
pub fn bad_models() -> Vec<(&'static str, Vec<u8>)> {
    let mut files: Vec<(&'static str, Vec<u8>)> = vec![];
    let mut add = |name, text: String| files.push((name, text.into_bytes()));
    let cube = Shape::cube;
    let at = |x: f64, y: f64, z: f64| cube().placed(DVec3::new(x, y, z), 1.0);

    // Defects of the surface.
    let mut open = cube();
    open.faces.pop();
    add("open.obj", open.obj("a cube that lacks a triangle"));
    add("non_manifold_edge.obj", cube().with(&at(2.0, 2.0, 0.0)).obj("two cubes that share an edge"));
    let corner = Shape::tetrahedron().with(&Shape::tetrahedron().placed(DVec3::ZERO, -1.0).reversed());
    add("non_manifold_vertex.obj", corner.obj("two tetrahedra that share a vertex"));
    add("klein_bottle.obj", Shape::klein_bottle(16, 12).obj("a closed surface with one side only"));
    let mut twice = cube();
    twice.faces.push(vec![4, 5, 7]);
    add("duplicate_face.obj", twice.obj("a cube with one triangle twice"));
    add("touching_cubes.obj", cube().with(&at(2.0, 0.0, 0.0)).obj("two cubes that share a side"));
    add(
        "touching_cubes_crossed.obj",
        cube().with(&at(2.0, 0.0, 0.0).mirrored()).obj("the same, cut along other diagonals"),
    );
    let mut wall = Shape::cuboid(DVec3::NEG_ONE, DVec3::ONE);
    wall.points.push(DVec3::ZERO);
    // A fin from the edge 0-1 into the cube and, on the other side of itself, back.
    wall.faces.extend([vec![0, 1, 8], vec![2, 0, 8], vec![3, 2, 8], vec![1, 3, 8]]);
    add("inner_wall.obj", wall.obj("a cube with walls from one side's edges to its centre"));
    let flat = Shape {
        points: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y],
        faces: vec![vec![0, 1, 2], vec![0, 2, 3], vec![0, 3, 1], vec![1, 3, 2]],
    };
    add("flat.obj", flat.obj("a square, its two sides cut along different diagonals"));
    let mut line = cube();
    line.faces.iter_mut().for_each(|f| f[2] = f[1]);
    add("all_degenerate.obj", line.obj("nothing but triangles without area"));
    add("not_finite.obj", cube().obj("a vertex that is not a number").replacen("-1 -1 -1", "-1 nan -1", 1));
    add("overflow.obj", cube().obj("a number beyond the range of f64").replacen("-1 -1 -1", "-1 -1e999 -1", 1));
    let exponent = |x: f64| format!("{x:e}");
    add("too_large.obj", cube().placed(DVec3::ZERO, 1e308).obj_with("too large to compute with", exponent));
    add("too_small.obj", cube().placed(DVec3::ZERO, 1e-320).obj_with("denormal numbers", exponent));
    add("empty.obj", "# nothing here\n".into());
    add("points_only.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n".into());

    add(
        "crossing_spheres.obj",
        Shape::icosphere(1, 1.0)
            .with(&Shape::icosphere(1, 1.0).placed(DVec3::X * 0.7, 1.0))
            .obj("two spheres through each other"),
    );
    let on_it = cube().placed(DVec3::new(0.1, 0.2, 1.5), 0.5);
    add("standing_cube.obj", cube().with(&on_it).obj("a cube that stands on a larger one"));
    let tip = [(0.1, 0.2, 1.0), (1.0, 0.0, 3.0), (-1.0, 0.5, 3.0), (0.0, -1.0, 3.0)];
    let peak = Shape { points: tip.map(DVec3::from).to_vec(), ..Shape::tetrahedron() }.reversed();
    add("standing_tip.obj", cube().with(&peak).obj("a tetrahedron that touches a cube's side"));

    // Text that is no surface.
    add("garbage.obj", "The quick brown fox\njumps over the lazy dog.\n".into());
    add("bad_number.obj", cube().obj("a coordinate that is not a number").replacen("-1 -1 -1", "-1 one -1", 1));
    add("bad_face.obj", cube().obj("an index that is not a number").replacen("f 1 3 4", "f 1 three 4", 1));
    add("bad_index.obj", cube().obj("an index beyond the vertices").replacen("f 1 3 4", "f 1 3 99", 1));
    add("index_zero.obj", cube().obj("indices begin with 1").replacen("f 1 3 4", "f 0 3 4", 1));
    add("negative_index.obj", cube().obj("a relative index too far back").replacen("f 1 3 4", "f -9 3 4", 1));

    // What is mended.
    add("inside_out.obj", cube().reversed().obj("a cube seen from inside"));
    let mut shuffled = Shape::icosphere(1, 1.0);
    shuffled.faces.iter_mut().enumerate().filter(|(i, _)| i * 7 % 5 < 2).for_each(|(_, f)| f.reverse());
    add("shuffled.obj", shuffled.obj("a sphere with some faces turned"));
    add(
        "cavity_outward.obj",
        cube().with(&Shape::icosphere(1, 0.5)).obj("a cube and in it a sphere, both facing outward"),
    );
    add("zero_area.obj", cube_with_needle().obj("a cube with a triangle without area"));
    let mut equal = cube();
    equal.faces.extend([vec![0, 0, 1], vec![3, 3, 3]]);
    add("equal_corners.obj", equal.obj("a cube with two faces that have equal corners"));
    let soup = Shape {
        points: cube().faces.iter().flatten().map(|&v| cube().points[v as usize]).collect(),
        faces: (0..12).map(|t| vec![3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    };
    add(
        "duplicate_vertices.obj",
        soup.obj("a cube whose triangles have vertices of their own").replace("v 1 ", "v +1.0 "),
    );
    let mut unused = cube();
    unused.points.extend([DVec3::splat(1e3), DVec3::splat(-7.0)]);
    add("unused_vertices.obj", unused.obj("a cube and two vertices of no face"));
    add("polygons.obj", l_prism().obj("a prism over an L: concave polygons, a corner along an edge"));
    add("huge.obj", cube().placed(DVec3::ZERO, 1e38).obj_with("a cube of 1e38", exponent));
    add("tiny.obj", cube().placed(DVec3::ZERO, 1e-300).obj_with("a cube of 1e-300", exponent));
    add("far.obj", cube().placed(DVec3::new(1e7, -2e7, 1e7), 1.0).obj("a cube far from the origin"));
    add("statements.obj", STATEMENTS.replace('\n', "\r\n"));

    let mut binary = cube().obj("a zero byte").into_bytes();
    binary.extend([0, 1, 2, 0xff, 0]);
    files.push(("binary.obj", binary));
    files
}

/// A cube in all the ways of the format.
const STATEMENTS: &str = "\
# comments, continued lines, groups, relative indices, texture coordinates and normals, colours, lines and points
mtllib nowhere.mtl
o cube#1
v -1 -1 -1 1.0 # a weight
v 1.0e0 -1 -1 0.5 0.5 0.5
v -1 +1 -1
v 1 1 \\
  -1
v -1 -1 1
v 1 -1 1
v -1 1 1
v 1 1 1
vt 0 0
vn 0 0 1
g bottom
usemtl stone
f 1/1/1 3/1/1 4/1/1 2/1/1 # a quad
g walls
s off
f 1//1 2//1 6//1 5//1
f 3/1 7/1 8/1 4/1
f 1 5 \\
7 3
usemtl glass
f -7 -5 -1 -3
l 1 2 3
p 4
g top
f 5 6 8 7
";
