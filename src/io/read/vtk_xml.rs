//! Reads surfaces from VTK's XML files: polygons and strips of `PolyData` (`.vtp`), flat cells of `UnstructuredGrid`
//! (`.vtu`), with numbers as text, in base64 or raw behind the markup, compressed by zlib or not.
//!
//! The markup is read by `quick-xml`. The rest is ours because the kept crate (`vtkio`) cannot read appended data, which is
//! what ParaView writes, and panics on a piece without vertices.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use quick_xml::events::{BytesStart, Event};

use super::Soup;
use super::vtk_pieces::{self, Cells, DataArray, Kinds, POLYGON, Piece, TRIANGLE_STRIP, VERTEX};
use super::words::Words;

/// Parses the bytes of an XML file.
pub(super) fn parse(bytes: &[u8]) -> Result<Soup, String> {
    let (markup, appended) = split(bytes);
    let document = Document::of(markup)?;
    let pieces = document.pieces.iter().map(|piece| document.decode(piece, appended)).collect::<Result<_, _>>()?;
    vtk_pieces::assemble(pieces)
}

/// Parses the points alone, with the numbers on them.
pub(super) fn parse_points(bytes: &[u8]) -> Result<Vec<Piece>, String> {
    let (markup, appended) = split(bytes);
    let document = Document::of(markup)?;
    document.pieces.iter().map(|piece| document.decode_points(piece, appended)).collect()
}

/// Parses points and cells, with the numbers on both.
pub(super) fn parse_all(bytes: &[u8]) -> Result<Vec<Piece>, String> {
    let (markup, appended) = split(bytes);
    let document = Document::of(markup)?;
    let decode = |piece: &Vec<Array>| {
        let point_arrays = document.single_numbers(b"PointData", piece, appended)?;
        Ok(Piece { point_arrays, ..document.decode(piece, appended)? })
    };
    document.pieces.iter().map(decode).collect()
}

/// The markup, and what is appended to it: the bytes behind the underscore, which are no XML.
fn split(bytes: &[u8]) -> (&[u8], &[u8]) {
    const TAG: &[u8] = b"<AppendedData";
    let Some(tag) = bytes.windows(TAG.len()).position(|w| w == TAG) else { return (bytes, b"") };
    let rest = &bytes[tag..];
    let end = rest.iter().position(|&b| b == b'>').map_or(rest.len(), |i| i + 1);
    let begin = rest[end..].iter().position(|&b| b == b'_').map_or(rest.len(), |i| end + i + 1);
    (&bytes[..tag + end], &rest[begin..])
}

/// Where the numbers of an array are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Storage {
    Text,
    Base64,
    Appended,
}

/// An array of numbers, not yet decoded.
struct Array {
    section: Vec<u8>,
    name: String,
    kind: Type,
    components: usize,
    storage: Storage,
    /// Where in the appended data it begins, and ends at the latest.
    offset: usize,
    limit: usize,
    text: Vec<u8>,
    line: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Type {
    Integer {
        bytes: usize,
        signed: bool,
    },
    Float32,
    Float64,
    /// Text: no numbers.
    Other,
}

/// What the markup says.
#[derive(Default)]
struct Document {
    big_endian: bool,
    long_header: bool,
    compressed: bool,
    appended_base64: bool,
    pieces: Vec<Vec<Array>>,
    /// The section of the piece that the reader is in, and whether it is in one of its arrays.
    section: Vec<u8>,
    in_array: bool,
    /// How deep it is in elements of the array, whose text is no part of it.
    beneath: usize,
}

impl Document {
    /// What the markup of a file says.
    fn of(markup: &[u8]) -> Result<Document, String> {
        let mut reader = quick_xml::Reader::from_reader(markup);
        reader.config_mut().check_end_names = false;
        let mut document = Document::default();
        loop {
            let at = reader.buffer_position();
            let line = || 1 + markup[..(at as usize).min(markup.len())].iter().filter(|&&b| b == b'\n').count();
            let place = |e: String| format!("line {}: {e}", line());
            match reader.read_event() {
                Ok(Event::Start(tag)) => document.open(&tag, line).map_err(place)?,
                Ok(Event::Empty(tag)) => {
                    document.open(&tag, line).map_err(place)?;
                    document.close(tag.name().as_ref());
                }
                Ok(Event::End(tag)) => document.close(tag.name().as_ref()),
                Ok(Event::Text(text)) => document.text(&text),
                Ok(Event::Eof) => break,
                Ok(_) => {}
                Err(error) => return Err(place(format!("the markup is broken: {error}"))),
            }
        }
        document.ends_of_appended();
        Ok(document)
    }

    fn open(&mut self, tag: &BytesStart, line: impl Fn() -> usize) -> Result<(), String> {
        let attribute = |name: &str| -> Result<Option<String>, String> {
            let found = tag.try_get_attribute(name).map_err(|e| e.to_string())?;
            found.map(|a| a.unescape_value().map(|v| v.into_owned()).map_err(|e| e.to_string())).transpose()
        };
        if self.in_array {
            self.beneath += 1;
            return Ok(());
        }
        match tag.name().as_ref() {
            b"VTKFile" => {
                let kind = attribute("type")?.unwrap_or_default();
                if kind != "PolyData" && kind != "UnstructuredGrid" {
                    return Err(format!("a file of type {kind:?} is no surface: PolyData is"));
                }
                self.big_endian = attribute("byte_order")?.is_some_and(|o| o == "BigEndian");
                self.long_header = attribute("header_type")?.is_some_and(|t| t == "UInt64");
                self.compressed = match attribute("compressor")?.as_deref() {
                    None | Some("") => false,
                    Some("vtkZLibDataCompressor") => true,
                    Some(other) => {
                        return Err(format!("it is compressed by {other:?}: write it uncompressed or by zlib"));
                    }
                };
            }
            b"Piece" => self.pieces.push(vec![]),
            b"AppendedData" => self.appended_base64 = attribute("encoding")?.is_none_or(|e| e == "base64"),
            b"DataArray" | b"Array" => {
                let storage = match attribute("format")?.as_deref() {
                    Some("ascii") | None => Storage::Text,
                    Some("binary") => Storage::Base64,
                    Some("appended") => Storage::Appended,
                    Some(other) => return Err(format!("the format {other:?} of an array is not known")),
                };
                let number = |text: Option<String>, default: usize| match text {
                    None => Ok(default),
                    Some(text) => text.trim().parse().map_err(|_| format!("{text:?} is no whole number")),
                };
                let array = Array {
                    section: self.section.clone(),
                    name: attribute("Name")?.unwrap_or_default(),
                    kind: Type::named(&attribute("type")?.unwrap_or_default()),
                    components: number(attribute("NumberOfComponents")?, 1)?,
                    storage,
                    offset: number(attribute("offset")?, 0)?,
                    limit: usize::MAX,
                    text: vec![],
                    line: line(),
                };
                // Arrays outside of pieces, field data, do not matter.
                if let Some(piece) = self.pieces.last_mut() {
                    piece.push(array);
                    self.in_array = true;
                }
            }
            name @ (b"Points" | b"Cells" | b"Polys" | b"Strips" | b"Verts" | b"Lines" | b"CellData" | b"PointData"
            | b"FieldData") => self.section = name.to_vec(),
            _ => {}
        }
        Ok(())
    }

    fn close(&mut self, name: &[u8]) {
        match name {
            _ if self.beneath > 0 => self.beneath -= 1,
            b"DataArray" | b"Array" => self.in_array = false,
            name if name == self.section => self.section.clear(),
            _ => {}
        }
    }

    fn text(&mut self, text: &[u8]) {
        if let Some(array) =
            self.pieces.last_mut().and_then(|p| p.last_mut()).filter(|_| self.in_array && self.beneath == 0)
        {
            array.text.extend_from_slice(text);
        }
    }

    /// Arrays in base64 end where the next one begins: no more must be decoded.
    fn ends_of_appended(&mut self) {
        let all = || self.pieces.iter().flatten();
        let mut begins: Vec<usize> = all().filter(|a| a.storage == Storage::Appended).map(|a| a.offset).collect();
        begins.sort_unstable();
        for array in self.pieces.iter_mut().flatten() {
            let next = begins.partition_point(|&b| b <= array.offset);
            array.limit = begins.get(next).copied().unwrap_or(usize::MAX);
        }
    }

    fn points(&self, arrays: &[Array], appended: &[u8]) -> Result<Vec<DVec3>, String> {
        let Some(points) = arrays.iter().find(|a| a.section == b"Points") else { return Ok(vec![]) };
        if points.components != 3 {
            return Err(format!("its points have {} coordinates, not 3", points.components));
        }
        Ok(self.named_numbers(points, appended)?.chunks_exact(3).map(DVec3::from_slice).collect())
    }

    fn decode_points(&self, arrays: &[Array], appended: &[u8]) -> Result<Piece, String> {
        let mut piece = Piece { points: self.points(arrays, appended)?, ..Piece::default() };
        piece.point_arrays = self.single_numbers(b"PointData", arrays, appended)?;
        Ok(piece)
    }

    /// The arrays of a section that have one number for each item.
    fn single_numbers(&self, section: &[u8], arrays: &[Array], appended: &[u8]) -> Result<Vec<DataArray>, String> {
        let single = |a: &&Array| a.section == section && a.components == 1 && a.kind != Type::Other;
        let decode = |array: &Array| {
            let is_integer = matches!(array.kind, Type::Integer { .. });
            let values = self.named_numbers(array, appended)?;
            Ok(DataArray { name: array.name.clone(), is_integer, values })
        };
        arrays.iter().filter(single).map(decode).collect()
    }

    fn named_numbers(&self, array: &Array, appended: &[u8]) -> Result<Vec<f64>, String> {
        self.numbers(array, appended).map_err(|e| format!("array {:?} at line {}: {e}", array.name, array.line))
    }

    fn decode(&self, arrays: &[Array], appended: &[u8]) -> Result<Piece, String> {
        let of = |section: &[u8], name: &str| -> Result<Option<Vec<f64>>, String> {
            let found = arrays.iter().find(|a| a.section == section && a.name == name);
            found.map(|a| self.named_numbers(a, appended)).transpose()
        };
        let mut piece = Piece { points: self.points(arrays, appended)?, ..Piece::default() };
        // The order in which VTK counts cells.
        for (section, kind) in [("Verts", VERTEX), ("Lines", VERTEX), ("Polys", POLYGON), ("Strips", TRIANGLE_STRIP)] {
            if let Some(offsets) = of(section.as_bytes(), "offsets")? {
                let cells = match kind {
                    // Their points do not matter; the cells count.
                    VERTEX => Cells { corners: vec![], ends: vec![0; offsets.len()] },
                    _ => {
                        let corners = of(section.as_bytes(), "connectivity")?.unwrap_or_default();
                        Cells::of_offsets(corners, &offsets, section)?
                    }
                };
                piece.cells.push((Kinds::All(kind), cells));
            }
        }
        if let (Some(offsets), Some(types)) = (of(b"Cells", "offsets")?, of(b"Cells", "types")?) {
            let corners = of(b"Cells", "connectivity")?.unwrap_or_default();
            piece.cells.push((Kinds::Each(types), Cells::of_offsets(corners, &offsets, "Cells")?));
        }
        piece.arrays = self.single_numbers(b"CellData", arrays, appended)?;
        Ok(piece)
    }

    fn numbers(&self, array: &Array, appended: &[u8]) -> Result<Vec<f64>, String> {
        let width = match array.kind {
            Type::Integer { bytes, .. } => bytes,
            Type::Float32 => 4,
            Type::Float64 => 8,
            Type::Other => return Err("it holds no numbers".into()),
        };
        let bytes = match array.storage {
            Storage::Text => {
                let mut words = Words::new(&array.text);
                let mut values = vec![];
                while words.peek().is_some() {
                    // Its own lines, counted from that of the array.
                    values.push(words.real("the array").map_err(|e| e.replacen("line", "its line", 1))?);
                }
                return Ok(values);
            }
            Storage::Base64 => self.unpack(&base64(&array.text)?)?,
            Storage::Appended => {
                let end = array.limit.min(appended.len());
                let data = appended.get(array.offset..end).ok_or("it begins beyond the end of the file")?;
                if self.appended_base64 {
                    self.unpack(&base64(data)?)?
                } else {
                    self.unpack(&appended[array.offset..])?
                }
            }
        };
        Ok(bytes
            .chunks_exact(width)
            .map(|chunk| {
                let mut raw = [0; 8];
                for (k, &b) in chunk.iter().enumerate() {
                    raw[if self.big_endian { width - 1 - k } else { k }] = b;
                }
                match array.kind {
                    Type::Float32 => f64::from(f32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]])),
                    Type::Float64 => f64::from_le_bytes(raw),
                    Type::Integer { signed: true, .. } => {
                        // Moved to the top and back, which spreads the sign.
                        let unused = 64 - 8 * width as u32;
                        (i64::from_le_bytes(raw) << unused >> unused) as f64
                    }
                    _ => u64::from_le_bytes(raw) as f64,
                }
            })
            .collect())
    }

    /// The numbers' bytes behind their header: one length, or, where they are compressed, the number of blocks, their
    /// size, that of the last one, and the compressed size of each.
    fn unpack(&self, bytes: &[u8]) -> Result<Vec<u8>, String> {
        let width = if self.long_header { 8 } else { 4 };
        let field = |k: usize| -> Result<usize, String> {
            let begin = k.checked_mul(width).ok_or("its header is broken")?;
            let field = bytes.get(begin..).and_then(|rest| rest.get(..width)).ok_or("it ends within its header")?;
            let mut raw = [0; 8];
            for (i, &b) in field.iter().enumerate() {
                raw[if self.big_endian { width - 1 - i } else { i }] = b;
            }
            usize::try_from(u64::from_le_bytes(raw)).map_err(|_| "its header is broken".into())
        };
        if !self.compressed {
            // VTK writes nothing at all for some empty arrays.
            if bytes.is_empty() {
                return Ok(vec![]);
            }
            let length = field(0)?;
            let data = bytes[width..].get(..length);
            return data.map(<[u8]>::to_vec).ok_or(format!("its header promises {length} bytes, which are not there"));
        }
        let (blocks, size) = (if bytes.is_empty() { 0 } else { field(0)? }, field(1).unwrap_or(0));
        let mut at = blocks.checked_add(3).and_then(|n| n.checked_mul(width)).ok_or("its header is broken")?;
        let mut unpacked = vec![];
        for block in 0..blocks {
            let packed = field(3 + block)?;
            let end = at.checked_add(packed).ok_or("its header is broken")?;
            let data = bytes.get(at..end).ok_or_else(|| format!("it ends within its block {block}"))?;
            // No block is longer than the header says.
            let before = unpacked.len();
            let mut decoder = flate2::read::ZlibDecoder::new(data).take(size as u64);
            decoder.read_to_end(&mut unpacked).map_err(|e| format!("its block {block} is broken: {e}"))?;
            if unpacked.len() == before && packed > 0 && size > 0 {
                return Err(format!("its block {block} is empty"));
            }
            at = end;
        }
        Ok(unpacked)
    }
}

impl Type {
    fn named(name: &str) -> Type {
        let integer = |bytes, signed| Type::Integer { bytes, signed };
        match name {
            "Int8" => integer(1, true),
            "UInt8" => integer(1, false),
            "Int16" => integer(2, true),
            "UInt16" => integer(2, false),
            "Int32" => integer(4, true),
            "UInt32" => integer(4, false),
            "Int64" => integer(8, true),
            "UInt64" => integer(8, false),
            "Float32" => Type::Float32,
            "Float64" => Type::Float64,
            _ => Type::Other,
        }
    }
}

/// Decodes base64, in which header and numbers may each end in padding.
fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let clean: Vec<u8> = text.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
    // What follows the last array is the end of the section.
    let end = clean.iter().position(|&b| b == b'<').unwrap_or(clean.len());
    let mut bytes = vec![];
    let mut rest = &clean[..end];
    while !rest.is_empty() {
        let padding = rest.iter().position(|&b| b == b'=').unwrap_or(rest.len());
        let after = rest[padding..].iter().position(|&b| b != b'=').map_or(rest.len(), |i| padding + i);
        let part = STANDARD.decode(&rest[..after]).map_err(|e| format!("its base64 is broken: {e}"))?;
        bytes.extend(part);
        rest = &rest[after..];
    }
    Ok(bytes)
}
