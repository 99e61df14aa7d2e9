//! Scenes of glTF: transforms, modes, sparse accessors, buffers; what is refused.

use std::path::Path;

use glam::DVec3;
use tetcvt::io::read::{Soup, parse};

use crate::input_formats::files::{Grouped, container, gltf_beside};
use crate::shapes::Shape;

/// A document with these nodes, of which the first is the scene, over one mesh of one primitive.
fn scene(nodes: &str, primitive: &str, accessors: &str, views: &str, buffer: &[u8], more: &str) -> Vec<u8> {
    let json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{nodes}],\"meshes\":\
         [{{\"primitives\":[{primitive}]}}],\"accessors\":[{accessors}],\"bufferViews\":[{views}],\"buffers\":\
         [{{\"byteLength\":{}}}]{more}}}",
        buffer.len()
    );
    container(json, buffer.to_vec())
}

const TETRAHEDRON: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
const POSITIONS: &str = r#"{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}"#;

/// Positions, then indices of one byte.
fn bytes(indices: &[u8]) -> (Vec<u8>, String, String) {
    let mut buffer: Vec<u8> = TETRAHEDRON.iter().flat_map(|x| x.to_le_bytes()).collect();
    buffer.extend(indices);
    let views = format!(
        "{{\"buffer\":0,\"byteLength\":48}},{{\"buffer\":0,\"byteOffset\":48,\"byteLength\":{}}}",
        indices.len()
    );
    let accessors = format!(
        "{POSITIONS},{{\"bufferView\":1,\"componentType\":5121,\"count\":{},\"type\":\"SCALAR\"}}",
        indices.len()
    );
    (buffer, accessors, views)
}

const INDEXED: &str = r#"{"attributes":{"POSITION":0},"indices":1"#;
const FACES: [u8; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];

fn tetrahedron(nodes: &str) -> Result<Soup, String> {
    let (buffer, accessors, views) = bytes(&FACES);
    parse(&scene(nodes, &format!("{INDEXED}}}"), &accessors, &views, &buffer, ""), Path::new("a.glb"))
}

fn signed_volume(soup: &Soup) -> f64 {
    let corner = |v: u32| soup.points()[v as usize];
    soup.triangles().iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
}

#[test]
fn nodes_put_meshes_where_they_belong() {
    let plain = tetrahedron(r#"{"mesh":0}"#).expect("a tetrahedron");
    assert_eq!(plain.points()[3], DVec3::Z);
    assert!((signed_volume(&plain) - 1.0 / 6.0).abs() < 1e-15);

    let moved = tetrahedron(r#"{"children":[1],"translation":[1,2,3]},{"mesh":0,"scale":[2,2,2]}"#).expect("moved");
    assert_eq!(moved.points()[1], DVec3::new(3.0, 2.0, 3.0));
    assert!((signed_volume(&moved) - 8.0 / 6.0).abs() < 1e-13);

    // A quarter turn about z takes x to y.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turned = tetrahedron(&format!("{{\"mesh\":0,\"rotation\":[0,0,{half},{half}]}}")).expect("turned");
    assert!(turned.points()[1].distance(DVec3::Y) < 1e-15);

    // Columns come one after the other; a mirror turns the faces with it.
    let mirrored = tetrahedron(r#"{"mesh":0,"matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 5,0,0,1]}"#).expect("mirrored");
    assert_eq!(mirrored.points()[1], DVec3::new(4.0, 0.0, 0.0));
    assert!((signed_volume(&mirrored) - 1.0 / 6.0).abs() < 1e-14);

    let twice = tetrahedron(r#"{"children":[1,2]},{"mesh":0},{"mesh":0,"translation":[9,0,0]}"#).expect("two");
    assert_eq!(twice.patch(), [0, 0, 0, 0, 1, 1, 1, 1]);
    assert_eq!(twice.source(), [0, 1, 2, 3, 4, 5, 6, 7]);
}

#[test]
fn strips_fans_and_lines() {
    let with = |mode: u32, indices: &[u8]| {
        let (buffer, accessors, views) = bytes(indices);
        let primitive = format!("{INDEXED},\"mode\":{mode}}}");
        parse(&scene(r#"{"mesh":0}"#, &primitive, &accessors, &views, &buffer, ""), Path::new("a.glb"))
    };
    let strip = with(5, &[0, 2, 1, 3, 0, 2]).expect("a strip");
    assert!((signed_volume(&strip) - 1.0 / 6.0).abs() < 1e-15 && strip.triangles().len() == 4);
    let fan = with(6, &[0, 2, 1, 3, 2]).expect("a fan");
    assert_eq!(fan.triangles(), [[0, 2, 1], [0, 1, 3], [0, 3, 2]]);
    let lines = with(1, &[0, 1, 1, 2]).expect("lines are passed over");
    assert!(lines.triangles().is_empty());
    let error = with(4, &[0, 1, 4]).expect_err("vertex 4 of 4");
    assert!(error.contains("primitive 0 of mesh 0") && error.contains("an index is 4"), "{error}");
}

#[test]
fn attributes_of_the_application_are_passed_over() {
    let (buffer, accessors, views) = bytes(&FACES);
    // Names of one's own begin with a line in the standard; there are files where they do not.
    for name in ["_TEMPERATURE", "_s", "temperature", "COLOR_x", "NORMAL"] {
        let primitive = format!("{INDEXED}}}").replacen("\"POSITION\":", &format!("\"{name}\":0,\"POSITION\":"), 1);
        assert!(primitive.contains(name), "{primitive}");
        let file = scene(r#"{"mesh":0}"#, &primitive, &accessors, &views, &buffer, "");
        let soup = parse(&file, Path::new("a.glb")).expect(name);
        assert!((signed_volume(&soup) - 1.0 / 6.0).abs() < 1e-15, "{name}");
    }
}

#[test]
fn sparse_accessors_replace_elements() {
    // The last vertex moves to (0, 0, 2); with and without elements to begin with.
    let (mut buffer, accessors, views) = bytes(&FACES);
    buffer.extend([3, 0, 0, 0]);
    [0.0f32, 0.0, 2.0].iter().for_each(|x| buffer.extend(x.to_le_bytes()));
    let views = format!(
        "{views},{{\"buffer\":0,\"byteOffset\":60,\"byteLength\":4}},{{\"buffer\":0,\"byteOffset\":64,\"byteLength\":12}}"
    );
    let sparse = r#","sparse":{"count":1,"indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":3}}}"#;
    let from_view = accessors.replacen("\"max\":[1,1,1]}", &format!("\"max\":[1,1,2]{sparse}"), 1);
    let from_zero = from_view.replacen("\"bufferView\":0,", "", 1);
    let read = |accessors: &str| {
        let file = scene(r#"{"mesh":0}"#, &format!("{INDEXED}}}"), accessors, &views, &buffer, "");
        parse(&file, Path::new("a.glb"))
    };
    let soup = read(&from_view).expect("sparse");
    assert_eq!(soup.points(), [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z * 2.0]);
    let soup = read(&from_zero).expect("sparse over nothing");
    assert_eq!(soup.points(), [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, DVec3::Z * 2.0]);
}

#[test]
fn buffers_lie_beside_the_file() {
    let shape = Shape::cube();
    let patch = vec![0; shape.faces.len()];
    let (document, buffer) = gltf_beside(&Grouped { shape, patch }, "a%20cube.bin");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cube.gltf");
    std::fs::write(&path, document).expect("a file");
    let error = tetcvt::io::load_surface(&path).expect_err("no buffer yet");
    assert_eq!(error.exit_status(), 3);
    assert!(error.to_string().contains("a cube.bin"), "{error}");
    std::fs::write(folder.path().join("a cube.bin"), buffer).expect("a file");
    let surface = tetcvt::io::read_surface(&path).expect("a cube");
    assert_eq!(surface.triangles().len(), 12);
}

#[test]
fn what_cannot_be_read_is_named() {
    let (buffer, accessors, views) = bytes(&FACES);
    let with = |primitive: &str, accessors: &str, more: &str| {
        let file = scene(r#"{"mesh":0}"#, primitive, accessors, &views, &buffer, more);
        parse(&file, Path::new("a.glb")).expect_err("a refusal")
    };
    let plain = format!("{INDEXED}}}");
    for (extension, words) in [
        ("KHR_draco_mesh_compression", "Draco"),
        ("EXT_meshopt_compression", "meshopt"),
        ("KHR_mesh_quantization", "quantized"),
        ("ACME_unheard_of", "ACME_unheard_of"),
    ] {
        let more = format!(",\"extensionsUsed\":[\"{extension}\"],\"extensionsRequired\":[\"{extension}\"]");
        let error = with(&plain, &accessors, &more);
        assert!(error.contains(words) && error.contains(extension), "{error}");
    }
    let draco = format!(
        "{INDEXED},\"extensions\":{{\"KHR_draco_mesh_compression\":{{\"bufferView\":0,\"attributes\":{{}}}}}}}}"
    );
    assert!(with(&draco, &accessors, "").contains("Draco"));
    let short = accessors.replacen("5126", "5123", 1);
    assert!(with(&plain, &short, "").contains("floating-point"));
    let beyond = accessors.replacen("\"count\":4", "\"count\":40", 1);
    assert!(with(&plain, &beyond, "").contains("beyond its buffer"));

    let error = tetrahedron(r#"{"children":[1]},{"mesh":0,"children":[0]}"#).expect_err("a circle");
    assert!(error.contains("scenes are trees"), "{error}");
    // Within which the length of the header is less than the header's own.
    let nested = String::from_utf8(b"glTF\x02\0\0\0\x09\0\0\0".to_vec()).expect("seven bits");
    let error = parse(&container(nested, Vec::new()), Path::new("a.glb")).expect_err("a container within");
    assert!(error.contains("another .glb"), "{error}");
    let error = parse(b"glTF\x01\0\0\0\x0c\0\0\0", Path::new("a.glb")).expect_err("version 1");
    assert!(error.contains("version 1"), "{error}");
}
