//! Reads surfaces from VTK's legacy files, as text and binary, versions up to 5.1: polygons and strips of
//! `POLYDATA`, flat cells of `UNSTRUCTURED_GRID`.
//!
//! Ours because the kept crate (`vtkio`) panics on some files that VTK writes, and on many broken ones.

use glam::DVec3;

use super::Soup;
use super::vtk_pieces::{self, Cells, DataArray, Kinds, POLYGON, Piece, TRIANGLE_STRIP, VERTEX};
use super::words::{Words, quoted};

/// Parses the bytes of a legacy file.
pub(super) fn parse(bytes: &[u8]) -> Result<Soup, String> {
    vtk_pieces::assemble(vec![parse_piece(bytes)?])
}

/// Parses them without making faces of the cells.
pub(super) fn parse_piece(bytes: &[u8]) -> Result<Piece, String> {
    let mut file = File { words: Words::new(bytes), binary: false };
    let version = file.words.rest_of_line().to_ascii_lowercase();
    if !version.starts_with(b"# vtk datafile version") {
        return Err("its first line does not name a version of VTK".into());
    }
    // The title.
    file.words.rest_of_line();
    let encoding = file.words.expect("the header")?;
    file.binary = match encoding.to_ascii_uppercase().as_slice() {
        b"ASCII" => false,
        b"BINARY" => true,
        _ => return Err(format!("line {}: ASCII or BINARY is wanted, not {}", file.words.line(), quoted(encoding))),
    };
    let mut piece = Piece::default();
    let mut grid = Grid::default();
    let mut on_cells = None;
    while let Some(keyword) = file.words.next() {
        let line = file.words.line();
        let binary = file.binary;
        let at = |e: String| match binary {
            // Lines mean nothing between binary numbers.
            true => e,
            false if e.starts_with("line ") => e,
            false => format!("line {line}: {e}"),
        };
        match keyword.to_ascii_uppercase().as_slice() {
            b"DATASET" => {
                let kind = file.words.expect("the type of the data set")?.to_ascii_uppercase();
                if kind != b"POLYDATA" && kind != b"UNSTRUCTURED_GRID" {
                    return Err(format!("line {line}: a data set {} is no surface: POLYDATA is", quoted(&kind)));
                }
            }
            b"POINTS" => {
                let count = file.words.count("POINTS")?;
                let kind = file.kind()?;
                let flat = file.numbers(count.saturating_mul(3), kind, "POINTS").map_err(at)?;
                piece.points = flat.chunks_exact(3).map(DVec3::from_slice).collect();
            }
            b"VERTICES" | b"LINES" => {
                let cells = file.cells(&version, "VERTICES or LINES").map_err(at)?;
                // Their points do not matter; the cells count.
                let cells = Cells { corners: vec![], ends: vec![0; cells.ends.len()] };
                piece.cells.push((Kinds::All(VERTEX), cells));
            }
            b"POLYGONS" => {
                piece.cells.push((Kinds::All(POLYGON), file.cells(&version, "POLYGONS").map_err(at)?));
            }
            b"TRIANGLE_STRIPS" => {
                piece.cells.push((Kinds::All(TRIANGLE_STRIP), file.cells(&version, "TRIANGLE_STRIPS").map_err(at)?));
            }
            b"CELLS" => grid.cells = Some(file.cells(&version, "CELLS").map_err(at)?),
            b"CELL_TYPES" => {
                let count = file.words.count("CELL_TYPES")?;
                grid.kinds = Some(file.numbers(count, INT, "CELL_TYPES").map_err(at)?);
            }
            b"CELL_DATA" => on_cells = Some((true, file.words.count("CELL_DATA")?)),
            b"POINT_DATA" => on_cells = Some((false, file.words.count("POINT_DATA")?)),
            // Names of components and the like, up to an empty line.
            b"METADATA" => {
                file.words.rest_of_line();
                while file.words.remaining() > 0 && !file.words.rest_of_line().is_empty() {}
            }
            other => {
                let (cells, count) = on_cells.unwrap_or((false, 0));
                let arrays = file.attribute(other, count).map_err(at)?;
                if cells { &mut piece.arrays } else { &mut piece.point_arrays }.extend(arrays);
            }
        }
    }
    if let (Some(cells), Some(kinds)) = (grid.cells, grid.kinds) {
        piece.cells.push((Kinds::Each(kinds), cells));
    }
    Ok(piece)
}

/// Cells and types of an unstructured grid.
#[derive(Default)]
struct Grid {
    cells: Option<Cells>,
    kinds: Option<Vec<f64>>,
}

/// A type of numbers.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Signed or not, in so many bytes.
    Integer {
        bytes: usize,
        signed: bool,
    },
    Float,
    Double,
    Bit,
}

const INT: Kind = Kind::Integer { bytes: 4, signed: true };
const BYTE: Kind = Kind::Integer { bytes: 1, signed: false };

struct File<'a> {
    words: Words<'a>,
    binary: bool,
}

impl File<'_> {
    /// Reads the name of a type.
    fn kind(&mut self) -> Result<Kind, String> {
        let word = self.words.expect("a type of numbers")?;
        let integer = |bytes, signed| Kind::Integer { bytes, signed };
        Ok(match word.to_ascii_lowercase().as_slice() {
            b"bit" => Kind::Bit,
            b"unsigned_char" | b"vtktypeuint8" => BYTE,
            b"char" | b"signed_char" | b"vtktypeint8" => integer(1, true),
            b"unsigned_short" | b"vtktypeuint16" => integer(2, false),
            b"short" | b"vtktypeint16" => integer(2, true),
            b"unsigned_int" | b"vtktypeuint32" => integer(4, false),
            b"int" | b"vtkidtype" | b"vtktypeint32" => INT,
            b"unsigned_long" | b"unsigned_long_long" | b"vtktypeuint64" => integer(8, false),
            b"long" | b"long_long" | b"vtktypeint64" => integer(8, true),
            b"float" | b"vtktypefloat32" => Kind::Float,
            b"double" | b"vtktypefloat64" => Kind::Double,
            _ => return Err(format!("line {}: {} is no type of numbers", self.words.line(), quoted(word))),
        })
    }

    /// Reads `count` numbers behind the line that announces them.
    fn numbers(&mut self, count: usize, kind: Kind, what: &str) -> Result<Vec<f64>, String> {
        if !self.binary {
            if count > self.words.remaining() {
                return Err(format!("{what} promises {count} numbers, more than the file can hold"));
            }
            return (0..count).map(|_| self.words.real(what)).collect();
        }
        self.words.rest_of_line();
        let size = match kind {
            Kind::Bit => Some(count.div_ceil(8)),
            Kind::Integer { bytes, .. } => count.checked_mul(bytes),
            Kind::Float => count.checked_mul(4),
            Kind::Double => count.checked_mul(8),
        };
        let Some(bytes) = size.and_then(|size| self.words.skip(size)) else {
            return Err(format!("{what} promises {count} numbers, but the file ends within them"));
        };
        // Binary numbers are big-endian.
        Ok(match kind {
            Kind::Bit => (0..count).map(|i| f64::from(bytes[i / 8] >> (7 - i % 8) & 1)).collect(),
            Kind::Float => bytes.as_chunks().0.iter().map(|&b| f64::from(f32::from_be_bytes(b))).collect(),
            Kind::Double => bytes.as_chunks().0.iter().map(|&b| f64::from_be_bytes(b)).collect(),
            Kind::Integer { bytes: width, signed } => bytes
                .chunks_exact(width)
                .map(|b| {
                    let negative = signed && b[0] >= 0x80;
                    let start = if negative { -1i64 } else { 0 };
                    let value = b.iter().fold(start, |x, &byte| x << 8 | i64::from(byte));
                    if signed { value as f64 } else { value as u64 as f64 }
                })
                .collect(),
        })
    }

    /// Reads cells: before version 5 their number and that of all integers, then the integers; from then on the lengths
    /// of two arrays and these.
    fn cells(&mut self, version: &[u8], what: &str) -> Result<Cells, String> {
        let (first, second) = (self.words.count(what)?, self.words.count(what)?);
        // "... version 5.1": the first digit.
        let new = version.iter().find(|b| b.is_ascii_digit()).is_some_and(|&b| b >= b'5');
        if !new {
            let numbers = self.numbers(second, INT, what)?;
            return Cells::of_counts(&numbers, first, what);
        }
        let mut arrays = [vec![], vec![]];
        for (array, (name, count)) in arrays.iter_mut().zip([("OFFSETS", first), ("CONNECTIVITY", second)]) {
            let word = self.words.expect(what)?;
            if !word.eq_ignore_ascii_case(name.as_bytes()) {
                return Err(format!("line {}: {name} is wanted, not {}", self.words.line(), quoted(word)));
            }
            let kind = self.kind()?;
            *array = self.numbers(count, kind, what)?;
        }
        let [offsets, corners] = arrays;
        match offsets.split_first() {
            Some((&0.0, ends)) => Cells::of_offsets(corners, ends, what),
            Some(_) => Err(format!("{what}: the first offset is not 0")),
            None => Ok(Cells::default()),
        }
    }

    /// Reads an attribute of points or cells, of which there are `count`; returns what has one number for each.
    fn attribute(&mut self, keyword: &[u8], count: usize) -> Result<Vec<DataArray>, String> {
        let mut arrays = vec![];
        let mut keep = |name: &[u8], kind: Kind, values: Vec<f64>| {
            let name = String::from_utf8_lossy(name).into_owned();
            arrays.push(DataArray { name, is_integer: matches!(kind, Kind::Integer { .. }), values });
        };
        let fixed = match keyword {
            b"VECTORS" | b"NORMALS" => Some(3),
            b"TENSORS" => Some(9),
            b"TENSORS6" => Some(6),
            b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => Some(1),
            _ => None,
        };
        if let Some(components) = fixed {
            self.words.expect("an attribute")?;
            let kind = self.kind()?;
            self.numbers(count.saturating_mul(components), kind, "an attribute")?;
            return Ok(arrays);
        }
        match keyword {
            b"SCALARS" => {
                let name = self.words.expect("SCALARS")?;
                let kind = self.kind()?;
                let components = self.words.next_on_line().map_or(Some(1), super::words::count);
                let components = components.ok_or("SCALARS needs a whole number of components")?;
                // The line with the look-up table may be missing in old files.
                if self.words.peek().is_some_and(|w| w.eq_ignore_ascii_case(b"LOOKUP_TABLE")) {
                    self.words.next();
                    self.words.expect("LOOKUP_TABLE")?;
                }
                let values = self.numbers(count.saturating_mul(components), kind, "SCALARS")?;
                if components == 1 {
                    keep(name, kind, values);
                }
            }
            b"LOOKUP_TABLE" | b"COLOR_SCALARS" => {
                self.words.expect("an attribute")?;
                let number = self.words.count("an attribute")?;
                let all = if keyword == b"LOOKUP_TABLE" { 4 } else { count };
                self.numbers(number.saturating_mul(all), BYTE, "an attribute")?;
            }
            b"TEXTURE_COORDINATES" => {
                self.words.expect("TEXTURE_COORDINATES")?;
                let components = self.words.count("TEXTURE_COORDINATES")?;
                let kind = self.kind()?;
                self.numbers(count.saturating_mul(components), kind, "TEXTURE_COORDINATES")?;
            }
            b"FIELD" => {
                self.words.expect("FIELD")?;
                for _ in 0..self.words.count("FIELD")? {
                    let mut name = self.words.expect("FIELD")?;
                    if name == b"METADATA" {
                        self.words.rest_of_line();
                        while self.words.remaining() > 0 && !self.words.rest_of_line().is_empty() {}
                        name = self.words.expect("FIELD")?;
                    }
                    let (components, tuples) = (self.words.count("FIELD")?, self.words.count("FIELD")?);
                    if self.words.peek().is_some_and(|w| w.eq_ignore_ascii_case(b"string")) {
                        return Err("fields of strings are not read: leave them out of the file".into());
                    }
                    let kind = self.kind()?;
                    let values = self.numbers(components.saturating_mul(tuples), kind, "FIELD")?;
                    if components == 1 {
                        keep(name, kind, values);
                    }
                }
            }
            other => return Err(format!("{} is not understood", quoted(other))),
        }
        Ok(arrays)
    }
}
