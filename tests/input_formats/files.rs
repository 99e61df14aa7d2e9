//! Writes shapes in every format that is read, in the ways that other programs do.

use std::fmt::Write;
use std::io::Write as _;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::shapes::Shape;

/// A shape with a patch for each face.
#[derive(Clone)]
pub struct Grouped {
    pub shape: Shape,
    pub patch: Vec<u32>,
}

impl Grouped {
    /// Each patch's faces, in order.
    fn groups(&self) -> Vec<Vec<&Vec<u32>>> {
        let count = self.patch.iter().max().map_or(0, |&p| p as usize + 1);
        let mut groups = vec![vec![]; count];
        self.shape.faces.iter().zip(&self.patch).for_each(|(f, &p)| groups[p as usize].push(f));
        groups
    }
}

fn join<T: std::fmt::Display>(items: impl IntoIterator<Item = T>) -> String {
    items.into_iter().map(|x| x.to_string()).collect::<Vec<_>>().join(" ")
}

/// Every format and way of writing it, by name: `name.extension`, and bytes. Faces must be triangles.
pub fn all(g: &Grouped) -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("text.obj", obj(g)),
        ("text.stl", stl_text(g)),
        ("binary.stl", stl_binary(g)),
        ("text.ply", ply(g, "ascii")),
        ("little.ply", ply(g, "binary_little_endian")),
        ("big.ply", ply(g, "binary_big_endian")),
        ("text.off", off(g, "OFF")),
        ("colours.off", off(g, "COFF")),
        ("normals.off", off(g, "NOFF")),
        ("text3.vtk", vtk_text(g)),
        ("binary3.vtk", vtk_binary(g)),
        ("binary5.vtk", vtk_binary_5(g)),
        ("text.vtp", vtp(g, Xml::Text)),
        ("base64.vtp", vtp(g, Xml::Base64)),
        ("zlib.vtp", vtp(g, Xml::Zlib)),
        ("raw.vtp", vtp(g, Xml::Raw)),
        ("appended.vtp", vtp(g, Xml::AppendedBase64)),
        ("embedded.gltf", gltf(g)),
        ("binary.glb", glb(g)),
    ]
}

fn obj(g: &Grouped) -> Vec<u8> {
    let mut text = String::from("# a comment\n");
    g.shape.points.iter().for_each(|p| writeln!(text, "v {} {} {}", p.x, p.y, p.z).expect("a string"));
    for (k, group) in g.groups().iter().enumerate() {
        writeln!(text, "g part{k}").expect("a string");
        group.iter().for_each(|f| writeln!(text, "f {}", join(f.iter().map(|v| v + 1))).expect("a string"));
    }
    text.into_bytes()
}

fn stl_text(g: &Grouped) -> Vec<u8> {
    let mut text = String::new();
    for (k, group) in g.groups().iter().enumerate() {
        writeln!(text, "solid part {k}").expect("a string");
        for f in group {
            text += "  facet normal 0 0 1\n    outer loop\n";
            for &v in f.iter() {
                let p = g.shape.points[v as usize];
                writeln!(text, "      vertex {:e} {:e} {:e}", p.x, p.y, p.z).expect("a string");
            }
            text += "    endloop\n  endfacet\n";
        }
        writeln!(text, "endsolid part {k}").expect("a string");
    }
    text.into_bytes()
}

fn stl_binary(g: &Grouped) -> Vec<u8> {
    // It begins as text does.
    let mut bytes = b"solid".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((g.shape.faces.len() as u32).to_le_bytes());
    for f in g.groups().iter().flatten() {
        bytes.extend([0; 12]);
        for &v in f.iter() {
            let p = g.shape.points[v as usize].to_array();
            p.iter().for_each(|&x| bytes.extend((x as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply(g: &Grouped, format: &str) -> Vec<u8> {
    let (points, faces) = (&g.shape.points, &g.shape.faces);
    let header = format!(
        "ply\nformat {format} 1.0\ncomment made for a test\nelement vertex {}\nproperty double x\nproperty uchar red\n\
         property double y\nproperty double z\nelement face {}\nproperty int patch\nproperty list uchar int vertex_indices\n\
         property list short float quality\nelement edge 1\nproperty int vertex1\nend_header\n",
        points.len(),
        faces.len()
    );
    let mut bytes = header.into_bytes();
    if format == "ascii" {
        for p in points {
            writeln!(bytes, "{} 7 {} {}", p.x, p.y, p.z).expect("a vector");
        }
        for (f, patch) in faces.iter().zip(&g.patch) {
            writeln!(bytes, "{patch} {} {} 2 0.5 1", f.len(), join(f)).expect("a vector");
        }
        writeln!(bytes, "3").expect("a vector");
        return bytes;
    }
    let big = format.contains("big");
    let put = |little: &[u8], bytes: &mut Vec<u8>| {
        let mut number = little.to_vec();
        if big {
            number.reverse();
        }
        bytes.extend(number);
    };
    for p in points {
        put(&p.x.to_le_bytes(), &mut bytes);
        bytes.push(7);
        put(&p.y.to_le_bytes(), &mut bytes);
        put(&p.z.to_le_bytes(), &mut bytes);
    }
    for (f, patch) in faces.iter().zip(&g.patch) {
        put(&(*patch as i32).to_le_bytes(), &mut bytes);
        bytes.push(f.len() as u8);
        f.iter().for_each(|&v| put(&(v as i32).to_le_bytes(), &mut bytes));
        put(&1i16.to_le_bytes(), &mut bytes);
        put(&0.5f32.to_le_bytes(), &mut bytes);
    }
    put(&3i32.to_le_bytes(), &mut bytes);
    bytes
}

fn off(g: &Grouped, keyword: &str) -> Vec<u8> {
    let (points, faces) = (&g.shape.points, &g.shape.faces);
    let mut text = format!("{keyword} # a comment\n{} {} 0\n\n", points.len(), faces.len());
    let more = match keyword {
        "COFF" => " 0.5 0.5 0.5 1",
        "NOFF" => " 0 0 1",
        _ => "",
    };
    points.iter().for_each(|p| writeln!(text, "{} {} {}{more}", p.x, p.y, p.z).expect("a string"));
    faces.iter().for_each(|f| writeln!(text, "{} {} 255 0 0", f.len(), join(f)).expect("a string"));
    text.into_bytes()
}

fn vtk_text(g: &Grouped) -> Vec<u8> {
    let (points, faces) = (&g.shape.points, &g.shape.faces);
    let mut text =
        format!("# vtk DataFile Version 3.0\na title\nASCII\nDATASET POLYDATA\nPOINTS {} double\n", points.len());
    points.iter().for_each(|p| writeln!(text, "{} {} {}", p.x, p.y, p.z).expect("a string"));
    let size: usize = faces.iter().map(|f| f.len() + 1).sum();
    writeln!(text, "POLYGONS {} {size}", faces.len()).expect("a string");
    faces.iter().for_each(|f| writeln!(text, "{} {}", f.len(), join(f)).expect("a string"));
    writeln!(text, "\nCELL_DATA {}\nSCALARS area float\nLOOKUP_TABLE default", faces.len()).expect("a string");
    writeln!(text, "{}", join(faces.iter().map(|_| 0.25))).expect("a string");
    writeln!(text, "FIELD FieldData 1\npatch 1 {} int\n{}", faces.len(), join(&g.patch)).expect("a string");
    writeln!(text, "POINT_DATA {}\nNORMALS n float\n{}", points.len(), join(vec![1; 3 * points.len()]))
        .expect("a string");
    text.into_bytes()
}

fn vtk_binary(g: &Grouped) -> Vec<u8> {
    let (points, faces) = (&g.shape.points, &g.shape.faces);
    let mut bytes = b"# vtk DataFile Version 3.0\na title\nBINARY\nDATASET POLYDATA\n".to_vec();
    writeln!(bytes, "POINTS {} double", points.len()).expect("a vector");
    points.iter().for_each(|p| p.to_array().iter().for_each(|x| bytes.extend(x.to_be_bytes())));
    let size: usize = faces.iter().map(|f| f.len() + 1).sum();
    writeln!(bytes, "\nPOLYGONS {} {size}", faces.len()).expect("a vector");
    for f in faces {
        bytes.extend((f.len() as i32).to_be_bytes());
        f.iter().for_each(|&v| bytes.extend((v as i32).to_be_bytes()));
    }
    writeln!(bytes, "\nCELL_DATA {}\nSCALARS area float 1\nLOOKUP_TABLE default", faces.len()).expect("a vector");
    faces.iter().for_each(|_| bytes.extend(0.25f32.to_be_bytes()));
    writeln!(bytes, "\nSCALARS patch short 1\nLOOKUP_TABLE default").expect("a vector");
    g.patch.iter().for_each(|&p| bytes.extend((p as i16).to_be_bytes()));
    bytes.push(b'\n');
    bytes
}

fn vtk_binary_5(g: &Grouped) -> Vec<u8> {
    let (points, faces) = (&g.shape.points, &g.shape.faces);
    let mut bytes = b"# vtk DataFile Version 5.1\nvtk output\nBINARY\nDATASET POLYDATA\n".to_vec();
    writeln!(bytes, "POINTS {} double", points.len()).expect("a vector");
    points.iter().for_each(|p| p.to_array().iter().for_each(|x| bytes.extend(x.to_be_bytes())));
    writeln!(bytes, "\nMETADATA\nINFORMATION 0\n\nPOLYGONS {} {}", faces.len() + 1, 3 * faces.len()).expect("a vector");
    writeln!(bytes, "OFFSETS vtktypeint64").expect("a vector");
    (0..=faces.len() as i64).for_each(|k| bytes.extend((3 * k).to_be_bytes()));
    writeln!(bytes, "\nCONNECTIVITY vtktypeint64").expect("a vector");
    faces.iter().flatten().for_each(|&v| bytes.extend(i64::from(v).to_be_bytes()));
    writeln!(bytes, "\nCELL_DATA {}\nFIELD FieldData 1\nlabel 1 {0} vtktypeint64", faces.len()).expect("a vector");
    g.patch.iter().for_each(|&p| bytes.extend(i64::from(p).to_be_bytes()));
    writeln!(bytes, "\nMETADATA\nINFORMATION 0\n").expect("a vector");
    bytes
}

/// The ways to store an array.
#[derive(Clone, Copy, PartialEq)]
enum Xml {
    Text,
    Base64,
    Zlib,
    Raw,
    AppendedBase64,
}

/// The bytes of an array as the file has them.
fn packed(way: Xml, numbers: &[u8]) -> Vec<u8> {
    if way != Xml::Zlib {
        let mut bytes = (numbers.len() as u64).to_le_bytes().to_vec();
        bytes.extend(numbers);
        return if way == Xml::Raw { bytes } else { STANDARD.encode(bytes).into_bytes() };
    }
    // Blocks of 100 bytes; the header is encoded on its own.
    let blocks: Vec<Vec<u8>> = numbers
        .chunks(100)
        .map(|block| {
            let mut encoder = flate2::write::ZlibEncoder::new(vec![], flate2::Compression::default());
            encoder.write_all(block).expect("a vector");
            encoder.finish().expect("a vector")
        })
        .collect();
    let mut header = vec![blocks.len() as u64, 100, (numbers.len() % 100) as u64];
    header.extend(blocks.iter().map(|b| b.len() as u64));
    let header: Vec<u8> = header.iter().flat_map(|n| n.to_le_bytes()).collect();
    (STANDARD.encode(header) + &STANDARD.encode(blocks.concat())).into_bytes()
}

fn vtp(g: &Grouped, way: Xml) -> Vec<u8> {
    let (points, faces) = (&g.shape.points, &g.shape.faces);
    let mut appended = vec![];
    let mut array = |kind: &str, name: &str, components: usize, numbers: Vec<u8>, text: String| {
        let head = format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
        match way {
            Xml::Text => format!("{head} format=\"ascii\">\n{text}\n</DataArray>\n"),
            Xml::Base64 | Xml::Zlib => {
                let text = String::from_utf8(packed(way, &numbers)).expect("base64");
                format!("{head} format=\"binary\">\n  {text}\n</DataArray>\n")
            }
            Xml::Raw | Xml::AppendedBase64 => {
                let offset = appended.len();
                appended.extend(packed(way, &numbers));
                format!("{head} format=\"appended\" offset=\"{offset}\"/>\n")
            }
        }
    };
    let coordinates: Vec<f64> = points.iter().flat_map(|p| p.to_array()).collect();
    let reals = coordinates.iter().flat_map(|x| x.to_le_bytes()).collect();
    let integers = |values: &[i32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let corners: Vec<i32> = faces.iter().flatten().map(|&v| v as i32).collect();
    let ends: Vec<i32> = (1..=faces.len() as i32).map(|k| 3 * k).collect();
    let patch: Vec<i32> = g.patch.iter().map(|&p| p as i32).collect();
    let compressor = if way == Xml::Zlib { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
    let mut xml = format!(
        "<?xml version=\"1.0\"?>\n<!-- a comment -->\n<VTKFile type=\"PolyData\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\"{compressor}>\n<PolyData>\n<Piece NumberOfPoints=\"{}\" \
         NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
        points.len(),
        faces.len()
    );
    xml += "<CellData>\n";
    xml += &array("Int32", "a &amp; b", 3, integers(&corners), join(&corners));
    xml += &array("Int32", "patch", 1, integers(&patch), join(&patch));
    xml += "</CellData>\n<Points>\n";
    xml += &array("Float64", "Points", 3, reals, join(&coordinates));
    xml += "</Points>\n<Verts>\n";
    xml += &array("Int32", "connectivity", 1, vec![], String::new());
    xml += &array("Int32", "offsets", 1, vec![], String::new());
    xml += "</Verts>\n<Polys>\n";
    xml += &array("Int32", "connectivity", 1, integers(&corners), join(&corners));
    xml += &array("Int32", "offsets", 1, integers(&ends), join(&ends));
    xml += "</Polys>\n</Piece>\n</PolyData>\n";
    let mut bytes = xml.into_bytes();
    if way == Xml::Raw || way == Xml::AppendedBase64 {
        let encoding = if way == Xml::Raw { "raw" } else { "base64" };
        write!(bytes, "<AppendedData encoding=\"{encoding}\">\n  _").expect("a vector");
        bytes.extend(appended);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}

/// The document, with one primitive for each patch, and its buffer: positions, then indices.
fn document(g: &Grouped, uri: Option<&str>) -> (String, Vec<u8>) {
    let mut buffer: Vec<u8> =
        g.shape.points.iter().flat_map(|p| p.to_array()).flat_map(|x| (x as f32).to_le_bytes()).collect();
    let positions = buffer.len();
    let (low, high) =
        g.shape.points.iter().fold((glam::DVec3::MAX, glam::DVec3::MIN), |(l, h), &p| (l.min(p), h.max(p)));
    let mut accessors = vec![format!(
        "{{\"bufferView\":0,\"componentType\":5126,\"count\":{},\"type\":\"VEC3\",\"min\":{:?},\"max\":{:?}}}",
        g.shape.points.len(),
        low.to_array(),
        high.to_array()
    )];
    let mut primitives = vec![];
    for group in g.groups() {
        accessors.push(format!(
            "{{\"bufferView\":1,\"byteOffset\":{},\"componentType\":5125,\"count\":{},\"type\":\"SCALAR\"}}",
            buffer.len() - positions,
            3 * group.len()
        ));
        primitives.push(format!("{{\"attributes\":{{\"POSITION\":0}},\"indices\":{}}}", accessors.len() - 1));
        group.iter().copied().flatten().for_each(|v| buffer.extend(v.to_le_bytes()));
    }
    let length = buffer.len();
    let uri = match uri {
        Some(uri) => format!(",\"uri\":\"{uri}\""),
        None => String::new(),
    };
    let json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\
         \"meshes\":[{{\"primitives\":[{}]}}],\"accessors\":[{}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":{positions}}},\
         {{\"buffer\":0,\"byteOffset\":{positions},\"byteLength\":{}}}],\"buffers\":[{{\"byteLength\":{length}{uri}}}]}}",
        primitives.join(","),
        accessors.join(","),
        length - positions
    );
    (json, buffer)
}

fn gltf(g: &Grouped) -> Vec<u8> {
    let (_, buffer) = document(g, None);
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(buffer));
    document(g, Some(&uri)).0.into_bytes()
}

/// The document and the buffer that it names, as two files.
pub fn gltf_beside(g: &Grouped, name: &str) -> (Vec<u8>, Vec<u8>) {
    let (json, buffer) = document(g, Some(name));
    (json.into_bytes(), buffer)
}

fn glb(g: &Grouped) -> Vec<u8> {
    let (json, buffer) = document(g, None);
    container(json, buffer)
}

/// A `.glb` of a document and its buffer.
pub fn container(mut json: String, mut buffer: Vec<u8>) -> Vec<u8> {
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((28 + json.len() as u32 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json.as_bytes()), (b"BIN\0", &buffer)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}
