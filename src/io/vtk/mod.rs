//! Meshes, surfaces and triangulations as files of VTK.
//!
//! The XML formats (`.vtu`, `.vtp`) are written by hand, in `xml`: raw appended data, which `vtkio` cannot write, is ten
//! times faster and a third smaller than its inline base64, and it is what ParaView writes itself. The legacy format
//! (`.vtk`) goes through `vtkio`, in `legacy`. Both get the same arrays, so that their fields never differ.

use std::borrow::Cow;
use std::io;
use std::path::Path;

use glam::DVec3;

use crate::delaunay::Delaunay;
use crate::error::Error;
use crate::geometry::frame::Frame;
use crate::quality::TetQuality;
use crate::second_order::SecondOrder;
use crate::seeds::SeedKind;
use crate::tet_mesh::TetMesh;

use super::atomic::AtomicFile;

mod legacy;

mod polyhedra;

mod xml;

pub use polyhedra::write_voronoi;

/// The formats of VTK.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// XML with raw appended data: `.vtu` for tets, `.vtp` for surfaces.
    Xml,
    /// The legacy format, binary: `.vtk`.
    Legacy,
}

/// Cells of one kind over points, with data on them.
struct Grid<'a> {
    shape: Shape,
    points: &'a [DVec3],
    /// Points of the cells, one cell after the other.
    corners: &'a [u32],
    field_data: Vec<Array>,
    point_data: Vec<Array>,
    cell_data: Vec<Array>,
}

impl Grid<'_> {
    fn cells(&self) -> usize {
        self.corners.len() / self.shape.corners()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    Tet,
    /// With a node in the middle of each edge.
    QuadraticTet,
    Triangle,
}

impl Shape {
    fn corners(self) -> usize {
        match self {
            Shape::Tet => 4,
            Shape::QuadraticTet => 10,
            Shape::Triangle => 3,
        }
    }
}

/// A named array of tuples. Names have no blanks: the legacy format loses them.
struct Array {
    name: &'static str,
    components: usize,
    values: Values,
}

enum Values {
    UInt8(Vec<u8>),
    Int32(Vec<i32>),
    Float64(Vec<f64>),
}

impl Array {
    fn bytes(name: &'static str, values: impl Iterator<Item = u8>) -> Array {
        Array { name, components: 1, values: Values::UInt8(values.collect()) }
    }

    fn integers(name: &'static str, values: impl Iterator<Item = i32>) -> Array {
        Array { name, components: 1, values: Values::Int32(values.collect()) }
    }

    fn reals(name: &'static str, components: usize, values: &[f64]) -> Array {
        Array { name, components, values: Values::Float64(values.to_vec()) }
    }

    fn tuples(&self) -> usize {
        let len = match &self.values {
            Values::UInt8(v) => v.len(),
            Values::Int32(v) => v.len(),
            Values::Float64(v) => v.len(),
        };
        len / self.components
    }
}

/// An index as VTK's signed integer. A mesh has under 10^8 vertices and 8 times as many tets; numbers of patches and the like
/// are checked before.
fn signed(index: u32) -> i32 {
    i32::try_from(index).expect("an index is below 2^31: this is a bug in tetcvt")
}

/// Writes a mesh: point data `kind` and `seed`; cell data `region`, `volume`, `min_dihedral`, `radius_ratio`, which are
/// measures of the corners. Nodes in the middle of edges have the kind of the part of the solid that their edge lies
/// on, and -1 for a seed.
pub(super) fn write_mesh(
    out: &mut AtomicFile,
    format: Format,
    mesh: &TetMesh,
    quality: &TetQuality,
    second_order: Option<&SecondOrder>,
) -> io::Result<()> {
    let mut points = Cow::Borrowed(mesh.points.as_slice());
    let mut corners = Cow::Borrowed(mesh.tets.as_flattened());
    let mut kinds: Vec<SeedKind> = mesh.kinds.clone();
    let mut seeds: Vec<i32> = mesh.seeds.iter().copied().map(signed).collect();
    if let Some(second) = second_order {
        let first = mesh.points.len() as u32;
        points.to_mut().extend(&second.points);
        let both = mesh.tets.iter().zip(&second.tets);
        corners = both.flat_map(|(tet, middle)| tet.iter().copied().chain(middle.map(|m| first + m))).collect();
        kinds.extend(&second.kinds);
        seeds.resize(points.len(), -1);
    }
    let grid = Grid {
        shape: if second_order.is_some() { Shape::QuadraticTet } else { Shape::Tet },
        points: &points,
        corners: &corners,
        field_data: Vec::new(),
        point_data: vec![
            Array::bytes("kind", kinds.iter().map(|&k| k as u8)),
            Array::integers("seed", seeds.into_iter()),
        ],
        cell_data: vec![
            Array::integers("region", mesh.regions.iter().copied().map(signed)),
            Array::reals("volume", 1, &quality.volume),
            Array::reals("min_dihedral", 1, &quality.min_dihedral),
            Array::reals("radius_ratio", 1, &quality.radius_ratio),
        ],
    };
    write(out, format, &grid)
}

/// Writes the boundary of a mesh: the points that it uses, with point data `vertex`, their index in the mesh; cell
/// data `region_inside`, `region_outside`, `patch`, `source_triangle`.
pub(super) fn write_surface(out: &mut AtomicFile, format: Format, mesh: &TetMesh) -> io::Result<()> {
    let (vertices, triangles) = mesh.boundary_mesh();
    let points: Vec<DVec3> = vertices.iter().map(|&v| mesh.points[v as usize]).collect();
    let grid = Grid {
        shape: Shape::Triangle,
        points: &points,
        corners: triangles.as_flattened(),
        field_data: Vec::new(),
        point_data: vec![Array::integers("vertex", vertices.iter().copied().map(signed))],
        cell_data: vec![
            Array::integers("region_inside", mesh.boundary.iter().map(|t| signed(t.region_inside))),
            Array::integers("region_outside", mesh.boundary.iter().map(|t| t.region_outside)),
            Array::integers("patch", mesh.boundary.iter().map(|t| signed(t.patch))),
            Array::integers("source_triangle", mesh.boundary.iter().map(|t| signed(t.source_triangle))),
        ],
    };
    write(out, format, &grid)
}

/// Writes the finite tets of a triangulation and all its points, to the last bit, in the XML format; the file is left
/// to be committed. Field data `scale` and `shift` lead from its points to the model's: model = point / scale + shift.
/// Point data `seed`: -1 from vertex `seeds` on.
pub fn write_delaunay(path: &Path, delaunay: &Delaunay, frame: &Frame, seeds: usize) -> Result<AtomicFile, Error> {
    let corners: Vec<[u32; 4]> = delaunay.tets().collect();
    let points = delaunay.points();
    let seed = |v: usize| if v < seeds { signed(v as u32) } else { -1 };
    let grid = Grid {
        shape: Shape::Tet,
        points,
        corners: corners.as_flattened(),
        field_data: vec![Array::reals("scale", 1, &[frame.scale]), Array::reals("shift", 3, &frame.shift.to_array())],
        point_data: vec![Array::integers("seed", (0..points.len()).map(seed))],
        cell_data: Vec::new(),
    };
    AtomicFile::fill(path, |file| xml::write(&grid, file))
}

fn write(out: &mut AtomicFile, format: Format, grid: &Grid) -> io::Result<()> {
    match format {
        Format::Xml => xml::write(grid, out),
        Format::Legacy => legacy::write(grid, out),
    }
}
