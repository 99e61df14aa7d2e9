//! VTK's XML formats, with the numbers in one raw block behind the markup.
//!
//! ```text
//! <VTKFile ...> <DataArray ... format="appended" offset="0"/> ... <AppendedData encoding="raw"> _ n bytes n bytes ...
//! ```
//!
//! Each array is its length in bytes, a 64-bit integer, then its numbers; `offset` counts from behind the underscore.
//! Everything is little-endian.

use std::io::{self, Write};

use glam::DVec3;

use super::{Array, Grid, Shape, Values};

/// VTK's numbers of cell types.
const VTK_TETRA: u8 = 10;
const VTK_QUADRATIC_TETRA: u8 = 24;

pub(super) fn write(grid: &Grid, out: &mut impl Write) -> io::Result<()> {
    let mut appended = Appended::default();
    let markup = markup(grid, &mut appended);
    finish(&markup, &appended, out)
}

/// Writes the markup, which ends where the arrays begin, the arrays, and the end.
pub(super) fn finish(markup: &str, appended: &Appended, out: &mut impl Write) -> io::Result<()> {
    out.write_all(markup.as_bytes())?;
    for block in &appended.blocks {
        block.write(out)?;
    }
    out.write_all(b"\n  </AppendedData>\n</VTKFile>\n")
}

fn markup<'a>(grid: &'a Grid, appended: &mut Appended<'a>) -> String {
    let mut xml = String::new();
    let (dataset, sizes) = match grid.shape {
        Shape::Tet | Shape::QuadraticTet => ("UnstructuredGrid", format!("NumberOfCells=\"{}\"", grid.cells())),
        Shape::Triangle => (
            "PolyData",
            format!("NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"{}\"", grid.cells()),
        ),
    };
    xml += "<?xml version=\"1.0\"?>\n";
    xml += &format!(
        "<VTKFile type=\"{dataset}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <{dataset}>\n"
    );
    section(&mut xml, "FieldData", &grid.field_data, appended);
    xml += &format!("    <Piece NumberOfPoints=\"{}\" {sizes}>\n", grid.points.len());
    section(&mut xml, "PointData", &grid.point_data, appended);
    section(&mut xml, "CellData", &grid.cell_data, appended);
    xml += "      <Points>\n";
    xml += &appended.declare("Points", 3, Block::Points(grid.points));
    xml += "      </Points>\n";
    cells(&mut xml, grid, appended);
    xml += &format!("    </Piece>\n  </{dataset}>\n  <AppendedData encoding=\"raw\">\n_");
    xml
}

pub(super) fn section<'a>(xml: &mut String, name: &str, arrays: &'a [Array], appended: &mut Appended<'a>) {
    if arrays.is_empty() {
        return;
    }
    *xml += &format!("      <{name}>\n");
    for array in arrays {
        let declaration = appended.declare(array.name, array.components, Block::Values(&array.values));
        // Field data has no piece to take its number of tuples from.
        let tuples = format!("<DataArray NumberOfTuples=\"{}\"", array.tuples());
        *xml += &if name == "FieldData" { declaration.replacen("<DataArray", &tuples, 1) } else { declaration };
    }
    *xml += &format!("      </{name}>\n");
}

fn cells<'a>(xml: &mut String, grid: &'a Grid, appended: &mut Appended<'a>) {
    let name = match grid.shape {
        Shape::Tet | Shape::QuadraticTet => "Cells",
        Shape::Triangle => "Polys",
    };
    // VTK wants both arrays of one type; 32 bits halve the file.
    let wide = i32::try_from(grid.corners.len()).is_err();
    let (count, corners) = (grid.cells(), grid.shape.corners());
    *xml += &format!("      <{name}>\n");
    *xml += &appended.declare("connectivity", 1, Block::Indices { indices: grid.corners, wide });
    *xml += &appended.declare("offsets", 1, Block::Offsets { count, corners, wide });
    let value = match grid.shape {
        Shape::Tet => Some(VTK_TETRA),
        Shape::QuadraticTet => Some(VTK_QUADRATIC_TETRA),
        Shape::Triangle => None,
    };
    if let Some(value) = value {
        *xml += &appended.declare("types", 1, Block::Repeated { value, count });
    }
    *xml += &format!("      </{name}>\n");
}

/// The arrays behind the markup, in the order of their declaration.
#[derive(Default)]
pub(super) struct Appended<'a> {
    blocks: Vec<Block<'a>>,
    offset: usize,
}

impl<'a> Appended<'a> {
    /// Takes in an array; returns the element that stands for it.
    pub(super) fn declare(&mut self, name: &str, components: usize, block: Block<'a>) -> String {
        let offset = self.offset;
        self.offset += size_of::<u64>() + block.len();
        let declaration = format!(
            "        <DataArray type=\"{}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>\n",
            block.vtk_type()
        );
        self.blocks.push(block);
        declaration
    }
}

/// An array, as it lies in memory or as it follows from a few numbers.
pub(super) enum Block<'a> {
    Points(&'a [DVec3]),
    Values(&'a Values),
    Long(Vec<i64>),
    Indices { indices: &'a [u32], wide: bool },
    Offsets { count: usize, corners: usize, wide: bool },
    Repeated { value: u8, count: usize },
}

impl Block<'_> {
    fn vtk_type(&self) -> &'static str {
        match self {
            Block::Points(_) | Block::Values(Values::Float64(_)) => "Float64",
            Block::Values(Values::UInt8(_)) | Block::Repeated { .. } => "UInt8",
            Block::Long(_) | Block::Indices { wide: true, .. } | Block::Offsets { wide: true, .. } => "Int64",
            Block::Values(Values::Int32(_)) | Block::Indices { .. } | Block::Offsets { .. } => "Int32",
        }
    }

    /// Length in bytes.
    fn len(&self) -> usize {
        let width = |wide| if wide { size_of::<i64>() } else { size_of::<i32>() };
        match self {
            Block::Points(points) => size_of_val(*points),
            Block::Values(Values::UInt8(v)) => v.len(),
            Block::Values(Values::Int32(v)) => size_of_val(v.as_slice()),
            Block::Values(Values::Float64(v)) => size_of_val(v.as_slice()),
            Block::Long(v) => size_of_val(v.as_slice()),
            Block::Indices { indices, wide } => indices.len() * width(*wide),
            Block::Offsets { count, wide, .. } => count * width(*wide),
            Block::Repeated { count, .. } => *count,
        }
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&(self.len() as u64).to_le_bytes())?;
        match self {
            Block::Long(v) => all(out, v.iter().map(|x| x.to_le_bytes())),
            Block::Points(points) => all(out, points.iter().flat_map(|p| p.to_array()).map(f64::to_le_bytes)),
            Block::Values(Values::UInt8(v)) => out.write_all(v),
            Block::Values(Values::Int32(v)) => all(out, v.iter().map(|x| x.to_le_bytes())),
            Block::Values(Values::Float64(v)) => all(out, v.iter().map(|x| x.to_le_bytes())),
            Block::Indices { indices, wide: true } => all(out, indices.iter().map(|&i| i64::from(i).to_le_bytes())),
            // Indices are below the number of corners, which fits.
            Block::Indices { indices, wide: false } => all(out, indices.iter().map(|i| i.to_le_bytes())),
            Block::Offsets { count, corners, wide: true } => {
                all(out, (1..=*count).map(|k| ((k * corners) as i64).to_le_bytes()))
            }
            Block::Offsets { count, corners, wide: false } => {
                all(out, (1..=*count).map(|k| ((k * corners) as i32).to_le_bytes()))
            }
            Block::Repeated { value, count } => all(out, std::iter::repeat_n([*value], *count)),
        }
    }
}

/// Writes numbers through a buffer of a few pages: a call for each would take most of the time.
fn all<const N: usize>(out: &mut impl Write, numbers: impl Iterator<Item = [u8; N]>) -> io::Result<()> {
    const FULL: usize = 1 << 16;
    let mut buffer = Vec::with_capacity(FULL + N);
    for number in numbers {
        buffer.extend_from_slice(&number);
        if buffer.len() >= FULL {
            out.write_all(&buffer)?;
            buffer.clear();
        }
    }
    out.write_all(&buffer)
}
