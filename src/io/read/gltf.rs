//! Reads surfaces from glTF 2.0 files, `.gltf` and `.glb`: the triangles of all meshes in the scene, where its nodes
//! put them. Each primitive of each mesh in the scene is a patch; lines and points are passed over.
//!
//! The document is read and validated by the crate `gltf`. The container of `.glb` and the accessors are read here,
//! every index and length checked: the crate takes many for granted, and counts on positions being in single precision.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};
use glam::{DMat4, DVec3, DVec4};
use gltf::accessor::{DataType, Dimensions};
use gltf::json::validation::Checked;
use gltf::mesh::{Mode, Semantic};

use super::{Builder, Soup, strip};

/// Deepest scene: far beyond any real one, and not deep enough to run out of stack.
const DEEPEST: usize = 500;

/// Most triangles out of a mesh that stands in the scene many times over: 2^26.
const MOST_INSTANCED: usize = 1 << 26;

/// Parses the bytes of a glTF file; `folder` is where the files that it names are.
pub(super) fn parse(bytes: &[u8], folder: &Path) -> Result<Soup, String> {
    let (json, blob) = if bytes.starts_with(b"glTF") { container(bytes)? } else { (bytes, None) };
    let document = gltf::Gltf::from_slice_without_validation(json).map_err(|e| e.to_string())?.document;
    // Before the validation, which only says that something is not supported.
    for extension in document.extensions_required() {
        let way_out = match extension {
            "KHR_draco_mesh_compression" => "its meshes are compressed by Draco",
            "EXT_meshopt_compression" | "KHR_meshopt_compression" => "its buffers are compressed by meshopt",
            "KHR_mesh_quantization" => "its positions are quantized",
            // These say nothing of positions.
            name if ["KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_"]
                .iter()
                .any(|p| name.starts_with(p)) =>
            {
                continue;
            }
            _ => "it needs an extension that is not read",
        };
        return Err(format!("{way_out} ({extension}): export it without"));
    }
    let mut json = document.into_json();
    // What is left of them means nothing to the geometry, but validation would refuse it.
    json.extensions_required.clear();
    // Nor do attributes other than positions, the application's own among them, whose names the validation knows not.
    for primitive in json.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        primitive.attributes.retain(|name, _| *name == Checked::Valid(Semantic::Positions));
    }
    // The validation itself takes these indices for granted.
    let attributes = json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values());
    if let Some(index) = attributes.map(|a| a.value()).find(|&i| i >= json.accessors.len()) {
        return Err(format!("a primitive refers to accessor {index}, but there are {}", json.accessors.len()));
    }
    let document = gltf::Document::from_json(json).map_err(|e| format!("it is not valid: {e}"))?;
    let buffers = document.buffers().map(|b| buffer(&b, blob, folder)).collect::<Result<Vec<_>, _>>()?;
    let held = buffers.iter().map(Vec::len).sum::<usize>() + bytes.len();
    let mut reader = Reader { buffers, held, builder: Builder::default(), primitives: 0, seen: vec![] };
    reader.seen = vec![false; document.nodes().len()];
    match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => scene.nodes().try_for_each(|node| reader.node(&node, DMat4::IDENTITY, 0))?,
        None => return Err("it has no scene".into()),
    }
    let groups = reader.primitives > 1;
    Ok(reader.builder.finish(groups))
}

/// The document and the binary chunk of a `.glb`.
fn container(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let number = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    match number(4) {
        Some(2) => {}
        Some(version) => return Err(format!("it is of version {version} of glTF: 2 is read")),
        None => return Err("the file ends within its header".into()),
    }
    let (mut json, mut blob) = (None, None);
    let mut at = 12;
    while let (Some(length), Some(kind)) = (number(at), number(at + 4)) {
        let begin = at + 8;
        let end = begin.checked_add(length).filter(|&end| end <= bytes.len());
        let Some(end) = end else { return Err(format!("the file ends within the chunk at byte {at}")) };
        match kind {
            // "JSON" and "BIN\0".
            0x4e4f_534a => json = json.or(Some(&bytes[begin..end])),
            0x004e_4942 => blob = blob.or(Some(&bytes[begin..end])),
            _ => {}
        }
        // Chunks begin at multiples of four bytes.
        at = end.next_multiple_of(4);
    }
    let json = json.ok_or("it has no chunk of JSON")?;
    // The crate would take it for a file of its own, and its length for granted.
    if json.starts_with(b"glTF") {
        return Err("its chunk of JSON holds another .glb".into());
    }
    Ok((json, blob))
}

/// The bytes of a buffer: the binary chunk, a URI that holds them, or a file beside this one.
fn buffer(buffer: &gltf::Buffer, blob: Option<&[u8]>, folder: &Path) -> Result<Vec<u8>, String> {
    let place = |e: String| format!("buffer {}: {e}", buffer.index());
    match buffer.source() {
        gltf::buffer::Source::Bin => match blob {
            Some(blob) => Ok(blob.to_vec()),
            None => Err(place("there is no binary chunk".into())),
        },
        gltf::buffer::Source::Uri(uri) => match uri.strip_prefix("data:") {
            Some(data) => {
                let (kind, text) = data.split_once(',').ok_or_else(|| place("its data URI has no comma".into()))?;
                if !kind.ends_with(";base64") {
                    return Err(place("its data URI is not base64".into()));
                }
                let decoded = if text.ends_with('=') { STANDARD.decode(text) } else { STANDARD_NO_PAD.decode(text) };
                decoded.map_err(|e| place(e.to_string()))
            }
            None if uri.contains("://") => Err(place(format!("{uri:?} is not a file beside this one"))),
            None => {
                let name = unescaped(uri);
                std::fs::read(folder.join(&name)).map_err(|e| place(format!("{name:?}: {e}")))
            }
        },
    }
}

/// A URI's path without its %-escapes.
fn unescaped(uri: &str) -> String {
    let mut bytes = vec![];
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let escaped = (first == b'%').then(|| after.get(..2)).flatten();
        let value = escaped.and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        bytes.push(value.unwrap_or(first));
        rest = if value.is_some() { &after[2..] } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

struct Reader {
    buffers: Vec<Vec<u8>>,
    /// Bytes of the file and its buffers: no accessor has more elements.
    held: usize,
    builder: Builder,
    primitives: u32,
    /// For each node, whether the scene had it.
    seen: Vec<bool>,
}

impl Reader {
    fn node(&mut self, node: &gltf::Node, parent: DMat4, depth: usize) -> Result<(), String> {
        let index = node.index();
        if depth > DEEPEST || std::mem::replace(&mut self.seen[index], true) {
            return Err(format!("node {index} has several parents, or is too deep: scenes are trees"));
        }
        let place = parent * transform(node);
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                let name = || format!("primitive {} of mesh {}", primitive.index(), mesh.index());
                if primitive.extension_value("KHR_draco_mesh_compression").is_some() {
                    return Err(
                        "its meshes are compressed by Draco (KHR_draco_mesh_compression): export it without".into()
                    );
                }
                self.primitive(&primitive, place).map_err(|e| format!("{}: {e}", name()))?;
            }
        }
        node.children().try_for_each(|child| self.node(&child, place, depth + 1))
    }

    fn primitive(&mut self, primitive: &gltf::Primitive, place: DMat4) -> Result<(), String> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let positions = primitive.get(&gltf::Semantic::Positions).ok_or("it has no positions")?;
        let positions = self.positions(&positions)?;
        let indices: Vec<usize> = match primitive.indices() {
            Some(accessor) => self.indices(&accessor)?,
            None => (0..positions.len()).collect(),
        };
        let n = indices.len();
        if let Some(&v) = indices.iter().find(|&&v| v >= positions.len()) {
            return Err(format!("an index is {v}, but there are {} positions", positions.len()));
        }
        let triangles: Box<dyn Iterator<Item = [usize; 3]>> = match mode {
            Mode::Triangles => Box::new((0..n / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2])),
            Mode::TriangleStrip => Box::new(strip::triangles(n)),
            _ => Box::new((2..n).map(|k| [0, k - 1, k])),
        };
        let so_far = self.builder.soup.triangles.len().max(self.builder.soup.points.len());
        if so_far + n.max(positions.len()) > MOST_INSTANCED.max(self.held) {
            return Err("its meshes stand in the scene so often that they make too many triangles".into());
        }
        let base = self.builder.soup.points.len();
        for p in positions {
            self.builder.point(placed(place, p))?;
        }
        // A mirror turns what it shows.
        let mirrored = place.determinant() < 0.0;
        for t in triangles {
            let [a, b, c] = t.map(|k| base + indices[k]);
            self.builder.face(&if mirrored { [a, c, b] } else { [a, b, c] }, self.primitives)?;
        }
        self.primitives += 1;
        Ok(())
    }

    fn positions(&self, accessor: &gltf::Accessor) -> Result<Vec<DVec3>, String> {
        if accessor.data_type() != DataType::F32 || accessor.dimensions() != Dimensions::Vec3 {
            return Err("its positions are not of three 32-bit floating-point numbers".into());
        }
        let bytes = self.elements(accessor)?;
        let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let point = |b: &[u8]| DVec3::new(number(&b[..4]), number(&b[4..8]), number(&b[8..12]));
        Ok(bytes.chunks_exact(12).map(point).collect())
    }

    fn indices(&self, accessor: &gltf::Accessor) -> Result<Vec<usize>, String> {
        if accessor.dimensions() != Dimensions::Scalar {
            return Err("its indices are not single numbers".into());
        }
        let width = unsigned(accessor.data_type())?;
        Ok(self.elements(accessor)?.chunks_exact(width).map(little_endian).collect())
    }

    /// The elements of an accessor one after the other, sparse ones put in.
    fn elements(&self, accessor: &gltf::Accessor) -> Result<Vec<u8>, String> {
        let (size, count) = (accessor.size(), accessor.count());
        if count > self.held {
            return Err(format!(
                "accessor {} promises {count} elements, more than the file can hold",
                accessor.index()
            ));
        }
        let mut elements = match accessor.view() {
            Some(view) => self.range(&view, accessor.offset(), size, count, view.stride().unwrap_or(size))?,
            None => vec![0; size * count],
        };
        if let Some(sparse) = accessor.sparse() {
            let index_type = match sparse.indices().index_type() {
                gltf::accessor::sparse::IndexType::U8 => 1,
                gltf::accessor::sparse::IndexType::U16 => 2,
                gltf::accessor::sparse::IndexType::U32 => 4,
            };
            let (indices, values) = (sparse.indices(), sparse.values());
            let at = self.range(&indices.view(), indices.offset(), index_type, sparse.count(), index_type)?;
            let new = self.range(&values.view(), values.offset(), size, sparse.count(), size)?;
            for (at, new) in at.chunks_exact(index_type).map(little_endian).zip(new.chunks_exact(size)) {
                let old = elements.chunks_exact_mut(size).nth(at);
                old.ok_or_else(|| format!("a sparse index is {at}, but there are {count} elements"))?
                    .copy_from_slice(new);
            }
        }
        Ok(elements)
    }

    /// `count` pieces of `size` bytes, every `stride` bytes.
    fn range(
        &self,
        view: &gltf::buffer::View,
        offset: usize,
        size: usize,
        count: usize,
        stride: usize,
    ) -> Result<Vec<u8>, String> {
        let beyond = || format!("buffer view {} reaches beyond its buffer", view.index());
        let buffer = &self.buffers[view.buffer().index()];
        let bytes = buffer.get(view.offset()..).and_then(|b| b.get(..view.length())).ok_or_else(beyond)?;
        let bytes = bytes.get(offset..).ok_or_else(beyond)?;
        if stride < size {
            return Err(format!("buffer view {} has a stride of {stride} for elements of {size} bytes", view.index()));
        }
        let mut elements = Vec::with_capacity(bytes.len().min(size.saturating_mul(count)));
        for k in 0..count {
            let begin = k.checked_mul(stride).ok_or_else(beyond)?;
            elements.extend_from_slice(bytes.get(begin..).and_then(|b| b.get(..size)).ok_or_else(beyond)?);
        }
        Ok(elements)
    }
}

fn unsigned(kind: DataType) -> Result<usize, String> {
    match kind {
        DataType::U8 => Ok(1),
        DataType::U16 => Ok(2),
        DataType::U32 => Ok(4),
        _ => Err("its indices are not unsigned whole numbers".into()),
    }
}

fn little_endian(bytes: &[u8]) -> usize {
    bytes.iter().rev().fold(0, |x, &b| x << 8 | usize::from(b))
}

/// The transform of a node, in f64.
fn transform(node: &gltf::Node) -> DMat4 {
    match node.transform() {
        gltf::scene::Transform::Matrix { matrix } => {
            DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
        }
        gltf::scene::Transform::Decomposed { translation, rotation, scale } => {
            let [t, s] = [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
            let [x, y, z, w] = rotation.map(f64::from);
            let length = DVec4::new(x, y, z, w).length();
            // Of unit length but for its rounding to single precision.
            let turn = match length > 0.0 {
                true => glam::DQuat::from_xyzw(x / length, y / length, z / length, w / length),
                false => glam::DQuat::IDENTITY,
            };
            DMat4::from_scale_rotation_translation(s, turn, t)
        }
    }
}

/// A point where a transform puts it; unchanged to the last bit where it is the identity.
fn placed(place: DMat4, p: DVec3) -> DVec3 {
    if place == DMat4::IDENTITY { p } else { place.transform_point3(p) }
}
