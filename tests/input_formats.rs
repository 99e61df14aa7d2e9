//! Every format that is read, against the same surface as OBJ; what hostile bytes do.

use std::path::Path;

use glam::DVec3;
use tetcvt::Surface;
use tetcvt::io::read::{Soup, parse, parse_initial, parse_lines};

use crate::shapes::Shape;
use crate::support::Rng;

pub mod files;

use files::Grouped;

/// A hollow cube, single precision: its six sides are patches 0 to 5, the cavity 6.
fn hollow_cube() -> Grouped {
    let shape = Shape::cube().with(&Shape::icosphere(1, 0.5).reversed()).placed(DVec3::new(0.1, -0.2, 0.3), 0.7);
    let patch = (0..shape.faces.len() as u32).map(|t| (t / 2).min(6)).collect();
    let mut grouped = Grouped { shape, patch };
    grouped.shape.points.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
    grouped
}

fn soup(name: &str, bytes: &[u8]) -> Soup {
    parse(bytes, Path::new(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn surface(name: &str, bytes: &[u8]) -> Surface {
    soup(name, bytes).check().unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Corners of the triangles by coordinates, each from its least corner on, with patch and source: whatever the numbering.
fn geometry(surface: &Surface) -> Vec<([[u64; 3]; 3], u32, u32)> {
    let mut all: Vec<_> = (0..surface.triangles().len() as u32)
        .map(|t| {
            let mut corners = surface.corners(t).map(|p| surface.frame().to_model(p).to_array().map(f64::to_bits));
            let least = (0..3).min_by_key(|&i| corners[i]).expect("three corners");
            corners.rotate_left(least);
            (corners, surface.patch()[t as usize], surface.source()[t as usize])
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn every_format_gives_the_surface_of_the_obj() {
    let grouped = hollow_cube();
    let files = files::all(&grouped);
    let wanted = geometry(&surface(files[0].0, &files[0].1));
    assert_eq!(wanted.iter().map(|t| t.1).max(), Some(6));
    for (name, bytes) in &files {
        let surface = surface(name, bytes);
        let mut got = geometry(&surface);
        let grouped = !(name.ends_with(".off") || *name == "binary.stl");
        let mut wanted = wanted.clone();
        assert_eq!(surface.has_patches(), grouped, "{name}");
        if !grouped {
            wanted.iter_mut().for_each(|t| t.1 = 0);
        }
        // The order of equal triangles by patch.
        got.sort_unstable();
        wanted.sort_unstable();
        assert!(got == wanted, "{name} differs");
    }
}

#[test]
fn formats_of_double_precision_lose_no_bit() {
    let shape = Shape::icosphere(2, 1.0 / 3.0).placed(DVec3::new(0.1, 0.7, 1e-9), 1.0);
    let count = shape.faces.len();
    let grouped = Grouped { shape, patch: vec![0; count] };
    let files = files::all(&grouped);
    let exact = |name: &str| !name.contains("gl") && name != "binary.stl";
    let mut seen = 0;
    for (name, bytes) in files.iter().filter(|(name, _)| exact(name)) {
        let soup = soup(name, bytes);
        for (t, triangle) in soup.triangles().iter().enumerate() {
            let wanted = grouped.shape.faces[soup.source()[t] as usize].clone();
            for (i, &v) in triangle.iter().enumerate() {
                assert_eq!(soup.points()[v as usize], grouped.shape.points[wanted[i] as usize], "{name}");
            }
        }
        assert_eq!(soup.triangles().len(), count, "{name}");
        seen += 1;
    }
    assert_eq!(seen, 16);
}

#[test]
fn content_decides_and_names_only_where_it_does_not() {
    let grouped = hollow_cube();
    for (name, bytes) in files::all(&grouped) {
        let triangles = soup(name, &bytes).triangles().len();
        for other in ["a.obj", "a.stl", "a.ply", "a.vtk", "a.glb", "a", "a.txt"] {
            assert_eq!(soup(other, &bytes).triangles().len(), triangles, "{name} as {other}");
        }
    }
    // Bytes behind the triangles of a binary STL: its length no longer tells.
    let (_, mut stl) = files::all(&grouped).swap_remove(2);
    stl[..5].copy_from_slice(b"other");
    stl.extend([0; 7]);
    assert_eq!(soup("a.stl", &stl).triangles().len(), grouped.shape.faces.len());
    let error = parse(&stl, Path::new("a.bin")).expect_err("nothing tells");
    assert!(error.contains("neither its content nor its name"), "{error}");
    assert!(parse(b"", Path::new("a.ply")).is_err() && parse(b"", Path::new("nothing")).is_err());
}

#[test]
fn polygons_are_read_and_cut_in_every_format_that_has_them() {
    let prism = crate::shapes::l_prism();
    let (points, faces) = (&prism.points, &prism.faces);
    let lines = |items: Vec<String>| items.join("\n");
    let text = lines(points.iter().map(|p| format!("{} {} {}", p.x, p.y, p.z)).collect());
    let list = |separator: &str| {
        let row = |f: &Vec<u32>| f.iter().map(|v| v.to_string()).collect::<Vec<_>>().join(separator);
        lines(faces.iter().map(|f| format!("{} {}", f.len(), row(f))).collect())
    };
    let size: usize = faces.iter().map(|f| f.len() + 1).sum();
    let files = [
        ("a.off", format!("OFF\n{} {} 0\n{text}\n{}\n", points.len(), faces.len(), list(" "))),
        (
            "a.ply",
            format!(
                "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement \
                 face {}\nproperty list uchar uint vertex_index\nend_header\n{text}\n{}\n",
                points.len(),
                faces.len(),
                list(" ")
            ),
        ),
        (
            "a.vtk",
            format!(
                "# vtk DataFile Version 2.0\nt\nASCII\nDATASET POLYDATA\nPOINTS {} float\n{text}\nPOLYGONS {} {size}\n{}\n",
                points.len(),
                faces.len(),
                list("\n")
            ),
        ),
    ];
    for (name, text) in files {
        let surface = surface(name, text.as_bytes());
        assert_eq!(surface.triangles().len(), 24, "{name}");
        assert!((surface.volume() / surface.frame().scale.powi(3) - 3.0).abs() < 1e-12, "{name}");
        assert!(surface.notes().is_empty(), "{name}: {:?}", surface.notes());
    }
}

#[test]
fn strips_of_vtk_and_ply_are_read() {
    // A tetrahedron as one strip of four triangles.
    let points = "0 0 0 1 0 0 0 1 0 0 0 1";
    let vtk = format!(
        "# vtk DataFile Version 4.2\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n{points}\nLINES 1 3\n2 0 1\n\
         TRIANGLE_STRIPS 1 7\n6 0 2 1 3 0 2\n"
    );
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n\
         property list int int vertex_indices\nend_header\n{points}\n8 -1 0 2 1 3 0 2 -1\n"
    );
    let grid = format!(
        "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n{points}\nCELLS 5 18\n3 0 2 1\n\
         3 0 1 3\n3 0 3 2\n3 1 2 3\n1 0\nCELL_TYPES 5\n5 5 5 7 1\n"
    );
    for (name, text) in [("a.vtk", vtk), ("a.ply", ply), ("a.vtk", grid)] {
        let surface = surface(name, text.as_bytes());
        assert_eq!(surface.triangles().len(), 4, "{name}");
        assert!((surface.volume() / surface.frame().scale.powi(3) - 1.0 / 6.0).abs() < 1e-15, "{name}");
    }
    let volume = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n\
                  CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n";
    let error = parse(volume.as_bytes(), Path::new("a.vtk")).expect_err("a volume");
    assert!(error.contains("type 10") && error.contains("extract the surface"), "{error}");
}

#[test]
fn patches_reach_the_mesh() {
    use tetcvt::params::Target;
    let params = tetcvt::Params { target: Target::Count(300), iterations: 0, ..Default::default() };
    let patches = |patch: Vec<u32>| {
        let grouped = Grouped { shape: Shape::cube(), patch };
        let mesh = tetcvt::tetrahedralize(
            &surface("a.ply", &files::all(&grouped)[3].1),
            &params,
            &mut tetcvt::progress::Silent,
        );
        let mesh = mesh.expect("a mesh");
        let mut seen: Vec<u32> = mesh.boundary.iter().map(|t| t.patch).collect();
        for t in &mesh.boundary {
            // The face of the file that a boundary triangle names is on its side of the cube.
            let wanted = grouped.patch[t.source_triangle as usize];
            assert!(t.patch == wanted || grouped.patch.iter().all(|&p| p == grouped.patch[0]));
        }
        seen.sort_unstable();
        seen.dedup();
        seen
    };
    // The numbers of the file where it tells patches apart; else the sides between creases.
    assert_eq!(patches((0..12).map(|t| [70, 3][t / 6]).collect()), [3, 70]);
    assert_eq!(patches(vec![9; 12]), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn numbers_that_no_format_of_the_output_holds_are_renumbered_with_a_note() {
    for (numbers, patches, noted) in [
        (["7", "2147483646"], [7, 2147483646], false),
        (["7", "2147483647"], [0, 1], true),
        (["-1", "3"], [0, 1], true),
        (["0.5", "0.25"], [1, 0], true),
    ] {
        let shape = Shape::tetrahedron();
        let mut text = String::from("ply\nformat ascii 1.0\nelement vertex 4\n");
        text += "property double x\nproperty double y\nproperty double z\nelement face 4\n";
        text += "property list uchar int vertex_indices\nproperty double patch\nend_header\n";
        shape.points.iter().for_each(|p| text += &format!("{} {} {}\n", p.x, p.y, p.z));
        for (f, face) in shape.faces.iter().enumerate() {
            text += &format!("3 {} {} {} {}\n", face[0], face[1], face[2], numbers[f / 2]);
        }
        let surface = surface("a.ply", text.as_bytes());
        assert_eq!([surface.patch()[0], surface.patch()[3]], patches, "{numbers:?}");
        let note = surface.notes().iter().any(|n| n.contains("patches were numbered in their order"));
        assert_eq!(note, noted, "{numbers:?}: {:?}", surface.notes());
    }
}

#[test]
fn errors_say_where() {
    let ply =
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    let cases: [(&str, String, &str); 12] = [
        ("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero".into(), "line 4: a vertex needs a number"),
        ("a.stl", "solid a\nvertex 0 0 0".into(), "line 2: \"vertex\" is out of place"),
        ("a.stl", "solid a\nouter loop\nvertex 0 0 0".into(), "the file ends within a facet"),
        ("a.ply", format!("{ply}0 0 0\n1 one 1\n"), "line 9: vertex 2 of 2 needs numbers, not \"one\""),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex many\n".into(), "line 3"),
        ("a.ply", format!("{ply}0 0 0\n1 1\n"), "the file ends within vertex 2 of 2"),
        ("a.off", "OFF\n1 1 0\n0 0 0\n3 0 1 2\n".into(), "line 4: a face refers to vertex 1"),
        ("a.off", "OFF\n1 1 0\n0 0\n".into(), "vertex 1 of 1"),
        ("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n0 x 0\n".into(), "line 6"),
        ("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n".into(), "line 4"),
        ("a.vtp", "<VTKFile type=\"PolyData\">\n<PolyData><Piece></PolyData\n".into(), "line 2"),
        ("a.gltf", "{\n\"asset\": {\"version\": \"2.0\"},\n]".into(), "line 3"),
    ];
    for (name, text, words) in cases {
        let error = parse(text.as_bytes(), Path::new(name)).expect_err(words);
        assert!(error.contains(words), "{name}: {error}, not {words}");
        assert!(!error.contains('\n'), "{error}");
    }
}

/// Headers that promise more than the file holds: an error at once, not after memory has run out.
#[test]
fn promises_that_no_file_can_keep_are_refused() {
    let many = "4000000000000000000";
    let mut stl = vec![b'x'; 84];
    stl[80..].fill(0xff);
    let vtk = format!("# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS {many} double\n");
    let counts = format!("# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOLYGONS {many} {many}\n3 0 1 2\n");
    let ply = |encoding: &str, element: &str| {
        format!("ply\nformat {encoding} 1.0\nelement {element}\nproperty list uint int vertex_indices\nend_header\n")
    };
    let empty = format!("ply\nformat binary_little_endian 1.0\nelement nothing {many}\nend_header\n");
    let list = [ply("binary_little_endian", "face 1").as_bytes(), &[0xff; 8]].concat();
    let header = [u64::MAX, 1, 1].map(u64::to_le_bytes).concat();
    let mut zlib =
        b"<VTKFile type=\"PolyData\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"><PolyData><Piece>\
                     <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/>\
                     </Points></Piece></PolyData><AppendedData encoding=\"raw\">_"
            .to_vec();
    zlib.extend(header);
    let gltf = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\"meshes\":\
         [{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}],\"accessors\":[{{\"componentType\":5126,\"count\":{many},\
         \"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[0,0,0]}}]}}"
    );
    let files: [(&str, Vec<u8>); 10] = [
        ("a.stl", stl),
        ("a.vtk", vtk.into()),
        ("a.vtk", counts.into()),
        ("a.ply", ply("ascii", &format!("vertex {many}")).into()),
        ("a.ply", ply("binary_big_endian", &format!("face {many}")).into()),
        ("a.ply", empty.into()),
        ("a.ply", list),
        ("a.off", format!("OFF\n{many} {many} 0\n").into()),
        ("a.vtp", zlib),
        ("a.gltf", gltf.into()),
    ];
    for (name, bytes) in files {
        assert!(parse(&bytes, Path::new(name)).is_err(), "{name}: {}", String::from_utf8_lossy(&bytes));
    }
}

/// Whatever happens to the bytes of a file, reading it ends in a soup or an error. `TETCVT_HOSTILE_CASES` asks for more
/// cases a file.
#[test]
fn no_bytes_make_a_reader_panic() {
    let cases: usize = std::env::var("TETCVT_HOSTILE_CASES").map_or(400, |n| n.parse().expect("a number of cases"));
    let shape = Shape::cube().with(&Shape::tetrahedron().placed(DVec3::X * 5.0, 1.0));
    let patch = (0..shape.faces.len() as u32).map(|t| t / 4).collect();
    let files = files::all(&Grouped { shape, patch });
    let mut rng = Rng(5);
    let (mut read, mut refused) = (0, 0);
    for (name, bytes) in &files {
        for _ in 0..cases {
            let mut bytes = bytes.clone();
            for _ in 0..1 + rng.below(3) {
                mutate(&mut bytes, &files, &mut rng);
            }
            // Two that read something else in such files.
            let _ = (parse_initial(&bytes, Path::new(name)), parse_lines(&bytes));
            match parse(&bytes, Path::new(name)) {
                Ok(soup) => {
                    let points = soup.points().len() as u32;
                    assert!(soup.triangles().as_flattened().iter().all(|&v| v < points), "{name}");
                    // The checks must bear it too.
                    let _ = soup.check();
                    read += 1;
                }
                Err(error) => {
                    assert!(!error.is_empty());
                    refused += 1;
                }
            }
        }
    }
    assert!(read > cases && refused > cases, "{read} {refused}");
}

/// Cuts, splices, flips, and puts numbers where others were.
fn mutate(bytes: &mut Vec<u8>, files: &[(&str, Vec<u8>)], rng: &mut Rng) {
    if bytes.is_empty() {
        return;
    }
    let at = rng.below(bytes.len());
    match rng.below(7) {
        0 => bytes.truncate(at),
        1 => drop(bytes.drain(at..(at + 1 + rng.below(40)).min(bytes.len()))),
        2 => bytes[at] ^= 1 << rng.below(8),
        3 => bytes[at] = rng.bits() as u8,
        4 => {
            let other = &files[rng.below(files.len())].1;
            let begin = rng.below(other.len());
            let piece = other[begin..(begin + 1 + rng.below(60)).min(other.len())].to_vec();
            bytes.splice(at..at, piece);
        }
        5 => {
            // A number of the text.
            let numbers: [&[u8]; 8] =
                [b"-1", b"0", b"4294967296", b"18446744073709551616", b"1e400", b"nan", b"0.5", b"99999999999"];
            let digits = bytes[at..].iter().position(u8::is_ascii_digit).map_or(at, |i| at + i);
            let end = bytes[digits..].iter().position(|b| !b.is_ascii_digit()).map_or(digits, |i| digits + i);
            bytes.splice(digits..end, numbers[rng.below(numbers.len())].iter().copied());
        }
        _ => {
            // A number between binary ones.
            let word = [0u32, 1, 0xffff_ffff, 0x7fff_ffff, 0x8000_0000, 0x0100_0000][rng.below(6)].to_le_bytes();
            let end = (at + 4).min(bytes.len());
            bytes[at..end].copy_from_slice(&word[..end - at]);
        }
    }
}
