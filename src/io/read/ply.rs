//! Reads surfaces from PLY files (G. Turk, "The PLY Polygon File Format", Stanford, 1994), as text and binary of either
//! byte order: vertices, faces of any number of corners, strips. Numbers of text are read in f64 whatever type the
//! header gives them; what else a file has on its elements is passed over.
//!
//! Ours because the kept crate (`ply-rs-bw`) rounds text to the header's single precision, and loops for hours over an
//! element that has no properties and a large count.

use glam::DVec3;

use super::words::{Words, quoted};
use super::{Builder, Soup, patch_rank, patches, strip};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The types of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn named(name: &[u8]) -> Option<Type> {
        Some(match name {
            b"char" | b"int8" => Type::I8,
            b"uchar" | b"uint8" => Type::U8,
            b"short" | b"int16" => Type::I16,
            b"ushort" | b"uint16" => Type::U16,
            b"int" | b"int32" => Type::I32,
            b"uint" | b"uint32" => Type::U32,
            b"float" | b"float32" => Type::F32,
            b"double" | b"float64" => Type::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Type::I8 | Type::U8 => 1,
            Type::I16 | Type::U16 => 2,
            Type::I32 | Type::U32 | Type::F32 => 4,
            Type::F64 => 8,
        }
    }
}

struct Property {
    name: String,
    /// The type of a list's count.
    list: Option<Type>,
    kind: Type,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

impl Element {
    /// The position of the first of some properties that is there.
    fn find(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.properties.iter().position(|p| p.name == *name))
    }

    /// Bytes that one of them takes at least.
    fn least(&self, encoding: Encoding) -> usize {
        match encoding {
            // A digit and a blank; the last may lack the blank.
            Encoding::Text => 2 * self.properties.len(),
            _ => self.properties.iter().map(|p| p.list.unwrap_or(p.kind).bytes()).sum(),
        }
    }
}

/// Parses the bytes of a PLY file.
pub(super) fn parse(bytes: &[u8]) -> Result<Soup, String> {
    let (encoding, elements, body, line) = header(bytes)?;
    let mut values = Values { words: Words::new(&bytes[body..]).counting_from(line), encoding };
    let mut vertices = None;
    let (mut faces, mut strips) = (Lists::default(), Lists::default());
    for element in &elements {
        let least = element.least(encoding);
        if least == 0 {
            continue;
        }
        if element.count > values.words.remaining() / least + 1 {
            return Err(format!(
                "its header promises {} of element {}, but {} bytes cannot hold them",
                element.count,
                element.name,
                values.words.remaining()
            ));
        }
        match element.name.as_str() {
            "vertex" if vertices.is_none() => vertices = Some(read_vertices(&mut values, element)?),
            "face" => read_lists(&mut values, element, &mut faces)?,
            "tristrips" => read_lists(&mut values, element, &mut strips)?,
            _ => {
                for k in 0..element.count {
                    values.element(element, k, |_, _| Ok(()))?;
                }
            }
        }
    }
    let mut builder = Builder::default();
    for p in vertices.ok_or("it has no vertices with x, y and z")? {
        builder.point(p)?;
    }
    let has_groups = !faces.patch.is_empty();
    let patch = patches(&faces.patch, &mut builder.soup.notes);
    for (k, corners) in faces.iter().enumerate() {
        let corners: Vec<usize> = corners.iter().map(|&v| index(v)).collect();
        let patch = patch.get(k).copied().unwrap_or(0);
        builder.face(&corners, patch).map_err(|e| format!("face {}: {e}", k + 1))?;
    }
    for (k, corners) in strips.iter().enumerate() {
        // An index of -1 begins a strip anew.
        for run in corners.split(|&v| v < 0.0) {
            for t in strip::triangles(run.len()) {
                builder.face(&t.map(|i| index(run[i])), 0).map_err(|e| format!("strip {}: {e}", k + 1))?;
            }
        }
    }
    Ok(builder.finish(has_groups))
}

/// An index of a file; what cannot be one becomes an index that no file has.
fn index(v: f64) -> usize {
    if v >= 0.0 && v == v.trunc() { v as usize } else { usize::MAX }
}

/// Encoding, elements, where the numbers begin, and the line of that.
fn header(bytes: &[u8]) -> Result<(Encoding, Vec<Element>, usize, usize), String> {
    let mut encoding = None;
    let mut elements: Vec<Element> = vec![];
    let (mut at, mut line) = (0, 0);
    while at < bytes.len() {
        let rest = &bytes[at..];
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        // Lines end in \n, \r\n or, on old machines, \r.
        at += end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
        at = at.min(bytes.len());
        line += 1;
        let words: Vec<&[u8]> = rest[..end].split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
        let name = |w: &[u8]| String::from_utf8_lossy(w).into_owned();
        let wrong =
            || format!("line {line}: the header has a statement that is not understood: {}", quoted(&rest[..end]));
        match *words.as_slice() {
            [b"end_header"] => {
                let encoding = encoding.ok_or("its header has no line with the format")?;
                return Ok((encoding, elements, at, line + 1));
            }
            [] | [b"ply"] | [b"comment" | b"obj_info", ..] => {}
            [b"format", b"ascii", ..] => encoding = Some(Encoding::Text),
            [b"format", b"binary_little_endian", ..] => encoding = Some(Encoding::LittleEndian),
            [b"format", b"binary_big_endian", ..] => encoding = Some(Encoding::BigEndian),
            [b"element", element, count] => {
                let count = super::words::count(count).ok_or_else(wrong)?;
                elements.push(Element { name: name(element), count, properties: vec![] });
            }
            [b"property", b"list", count, kind, property] => {
                let (list, kind) = (Type::named(count).ok_or_else(wrong)?, Type::named(kind).ok_or_else(wrong)?);
                let properties = &mut elements.last_mut().ok_or_else(wrong)?.properties;
                properties.push(Property { name: name(property), list: Some(list), kind });
            }
            [b"property", kind, property] => {
                let kind = Type::named(kind).ok_or_else(wrong)?;
                let properties = &mut elements.last_mut().ok_or_else(wrong)?.properties;
                properties.push(Property { name: name(property), list: None, kind });
            }
            _ => return Err(wrong()),
        }
    }
    Err("the file ends within its header".into())
}

fn read_vertices(values: &mut Values, element: &Element) -> Result<Vec<DVec3>, String> {
    let axes = ["x", "y", "z"].map(|axis| element.find(&[axis]).filter(|&p| element.properties[p].list.is_none()));
    let [Some(x), Some(y), Some(z)] = axes else { return Err("its vertices have no x, y and z".into()) };
    let mut points = Vec::with_capacity(element.count);
    for k in 0..element.count {
        let mut p = DVec3::ZERO;
        values.element(element, k, |property, value| {
            for (axis, at) in [x, y, z].into_iter().enumerate() {
                if at == property {
                    p[axis] = value;
                }
            }
            Ok(())
        })?;
        points.push(p);
    }
    Ok(points)
}

/// Lists of indices, one after the other.
#[derive(Default)]
struct Lists {
    indices: Vec<f64>,
    /// Where each ends.
    ends: Vec<usize>,
    /// The number that tells the patch of each, if there is one.
    patch: Vec<f64>,
}

impl Lists {
    fn iter(&self) -> impl Iterator<Item = &[f64]> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        begins.zip(&self.ends).map(|(begin, &end)| &self.indices[begin..end])
    }
}

fn read_lists(values: &mut Values, element: &Element, lists: &mut Lists) -> Result<(), String> {
    let corners = element.find(&["vertex_indices", "vertex_index"]).filter(|&p| element.properties[p].list.is_some());
    let Some(corners) = corners else {
        return Err(format!("its element {} has no list vertex_indices", element.name));
    };
    let scalars = (0..element.properties.len()).filter(|&p| element.properties[p].list.is_none());
    let patch = scalars.filter_map(|p| Some((patch_rank(&element.properties[p].name)?, p))).min().map(|best| best.1);
    for k in 0..element.count {
        values.element(element, k, |property, value| {
            if property == corners {
                lists.indices.push(value);
            } else if Some(property) == patch {
                lists.patch.push(value);
            }
            Ok(())
        })?;
        lists.ends.push(lists.indices.len());
    }
    Ok(())
}

/// The numbers behind the header.
struct Values<'a> {
    words: Words<'a>,
    encoding: Encoding,
}

impl Values<'_> {
    /// Reads element `k` of its kind; gives `visit` each number, with the position of its property.
    fn element(
        &mut self,
        element: &Element,
        k: usize,
        mut visit: impl FnMut(usize, f64) -> Result<(), String>,
    ) -> Result<(), String> {
        for (p, property) in element.properties.iter().enumerate() {
            let what = || format!("{} {} of {}", element.name, k + 1, element.count);
            let count = match property.list {
                None => 1,
                Some(kind) => {
                    let count = self.value(kind, what)?;
                    if !(count >= 0.0 && count == count.trunc() && count <= self.words.remaining() as f64) {
                        return Err(format!("{}: a list of {count} numbers cannot be", what()));
                    }
                    count as usize
                }
            };
            for _ in 0..count {
                let value = self.value(property.kind, what)?;
                visit(p, value)?;
            }
        }
        Ok(())
    }

    fn value(&mut self, kind: Type, what: impl Fn() -> String) -> Result<f64, String> {
        if self.encoding == Encoding::Text {
            let Some(word) = self.words.next() else { return Err(format!("the file ends within {}", what())) };
            return super::words::real(word)
                .ok_or_else(|| format!("line {}: {} needs numbers, not {}", self.words.line(), what(), quoted(word)));
        }
        let bytes = self.words.skip(kind.bytes()).ok_or_else(|| format!("the file ends within {}", what()))?;
        let mut raw = [0; 8];
        // Little-endian, from the first byte on.
        for (k, &b) in bytes.iter().enumerate() {
            raw[if self.encoding == Encoding::LittleEndian { k } else { bytes.len() - 1 - k }] = b;
        }
        let [a, b, c, d, ..] = raw;
        Ok(match kind {
            Type::I8 => f64::from(a as i8),
            Type::U8 => f64::from(a),
            Type::I16 => f64::from(i16::from_le_bytes([a, b])),
            Type::U16 => f64::from(u16::from_le_bytes([a, b])),
            Type::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Type::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Type::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Type::F64 => f64::from_le_bytes(raw),
        })
    }
}
