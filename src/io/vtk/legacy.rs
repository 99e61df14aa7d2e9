//! VTK's legacy format, binary, by `vtkio`.
//!
//! Big-endian always: a little-endian legacy file makes VTK's reader crash. Data go in one `FIELD` for points and one
//! for cells: of several `SCALARS` a reader takes only the first.

use std::io::{self, Write};

use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataSet, FieldArray, IOBuffer, PolyDataPiece,
    UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};

use super::{Array, Grid, Shape, Values};

pub(super) fn write(grid: &Grid, out: &mut impl Write) -> io::Result<()> {
    let points: IOBuffer = IOBuffer::F64(grid.points.iter().flat_map(|p| p.to_array()).collect());
    let numbers = vertex_numbers(grid)?;
    let data = Attributes { point: field(&grid.point_data), cell: field(&grid.cell_data) };
    let data_set = match grid.shape {
        Shape::Tet | Shape::QuadraticTet => {
            let kind = if grid.shape == Shape::Tet { CellType::Tetra } else { CellType::QuadraticTetra };
            let cells = Cells { cell_verts: numbers, types: vec![kind; grid.cells()] };
            DataSet::inline(UnstructuredGridPiece { points, cells, data })
        }
        Shape::Triangle => {
            DataSet::inline(PolyDataPiece { points, polys: Some(numbers), data, ..PolyDataPiece::default() })
        }
    };
    let vtk = Vtk {
        version: Version::new_legacy(3, 0),
        title: "tetcvt".to_owned(),
        byte_order: ByteOrder::BigEndian,
        data: data_set,
        file_path: None,
    };
    let mut out = Remembering { out, error: None };
    let written = vtk.write_legacy(&mut out);
    match (out.error, written) {
        (Some(error), _) => Err(error),
        (None, Err(error)) => Err(io::Error::other(error.to_string())),
        (None, Ok(())) => Ok(()),
    }
}

fn vertex_numbers(grid: &Grid) -> io::Result<VertexNumbers> {
    let corners = grid.shape.corners();
    // The format counts corners and cells together in 32 bits.
    let entries = grid.corners.len() + grid.cells();
    if i32::try_from(entries).is_err() {
        return Err(io::Error::other("the mesh is too large for the legacy format; write .vtu or .vtp"));
    }
    let mut vertices = Vec::with_capacity(entries);
    for cell in grid.corners.chunks_exact(corners) {
        vertices.push(corners as u32);
        vertices.extend_from_slice(cell);
    }
    Ok(VertexNumbers::Legacy { num_cells: grid.cells() as u32, vertices })
}

fn field(arrays: &[Array]) -> Vec<Attribute> {
    let copy = |array: &Array| FieldArray {
        name: array.name.to_owned(),
        elem: array.components as u32,
        data: match &array.values {
            Values::UInt8(v) => IOBuffer::U8(v.clone()),
            Values::Int32(v) => IOBuffer::I32(v.clone()),
            Values::Float64(v) => IOBuffer::F64(v.clone()),
        },
    };
    vec![Attribute::Field { name: "FieldData".to_owned(), data_array: arrays.iter().map(copy).collect() }]
}

/// Keeps the error of the operating system, which `vtkio` replaces by the place in the file where it happened.
struct Remembering<'a, W> {
    out: &'a mut W,
    error: Option<io::Error>,
}

impl<W: Write> Remembering<'_, W> {
    fn remember<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|error| {
            let kind = error.kind();
            if kind != io::ErrorKind::Interrupted && self.error.is_none() {
                self.error = Some(error);
            }
            kind.into()
        })
    }
}

impl<W: Write> Write for Remembering<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = self.out.write(bytes);
        self.remember(result)
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = self.out.flush();
        self.remember(result)
    }
}
