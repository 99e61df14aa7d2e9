//! Writers of meshes and of their boundary, one file a format; VTK's are in `vtk`.
//!
//! Text formats get the shortest decimals that read back to the same `f64`. Formats that number their groups from 1
//! have region r and patch p as the groups r + 1 and p + 1, named `region_r` and `patch_p` where groups have names.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::atomic::{AtomicFile, commit_all};
use super::format::{Encoding, MeshFormat, SurfaceFormat};
use super::vtk;
use crate::error::Error;
use crate::quality::TetQuality;
use crate::second_order::SecondOrder;
use crate::tet_mesh::{BoundaryTriangle, TetMesh};

mod abaqus;

mod facets;

mod gmsh;

mod medit;

mod obj;

mod ply;

mod stl;

mod tetgen;

/// What goes into a mesh file.
#[derive(Clone, Copy)]
pub struct MeshData<'a> {
    /// The mesh.
    pub mesh: &'a TetMesh,
    /// Measures of its tets.
    pub quality: &'a TetQuality,
    /// Nodes in the middle of its edges, for tets of the second order.
    pub second_order: Option<&'a SecondOrder>,
    /// For formats that are binary or text.
    pub encoding: Encoding,
}

impl MeshData<'_> {
    /// Vertices, then the nodes in the middle of edges.
    fn nodes(&self) -> impl Iterator<Item = DVec3> {
        let middle = self.second_order.map_or(&[][..], |s| &s.points);
        self.mesh.points.iter().chain(middle).copied()
    }

    /// How many nodes there are.
    fn node_count(&self) -> usize {
        self.mesh.points.len() + self.second_order.map_or(0, |s| s.points.len())
    }

    /// The number of the first node in the middle of an edge.
    fn first_middle(&self) -> u32 {
        self.mesh.points.len() as u32
    }

    /// The nodes of tet `t`: its corners, then the middles of its edges 01, 12, 02, 03, 13 and 23.
    fn tet_nodes(&self, t: usize, out: &mut Vec<u32>) {
        out.clear();
        out.extend(self.mesh.tets[t]);
        if let Some(second) = self.second_order {
            out.extend(second.tets[t].map(|m| self.first_middle() + m));
        }
    }

    /// The nodes of boundary triangle `f`: its corners, then the middles of its edges 01, 12 and 20.
    fn triangle_nodes(&self, f: usize, out: &mut Vec<u32>) {
        out.clear();
        out.extend(self.mesh.boundary[f].vertices);
        if let Some(second) = self.second_order {
            out.extend(second.triangles[f].map(|m| self.first_middle() + m));
        }
    }
}

/// Writes a mesh in the format of `path`'s extension, whole or not at all.
///
/// # Errors
/// [`Error::Write`]; also where the format cannot hold the mesh.
pub fn write_mesh(path: &Path, format: MeshFormat, data: &MeshData) -> Result<(), Error> {
    if data.second_order.is_some() && !format.has_second_order() {
        let reason = "the format has no tets of the second order".to_owned();
        return Err(Error::Write { path: path.to_owned(), reason });
    }
    check_ids(path, data.mesh)?;
    let one = |write: fn(&MeshData, &mut AtomicFile) -> io::Result<()>| {
        AtomicFile::fill(path, |file| write(data, file)).map(|file| vec![file])
    };
    let files = match format {
        MeshFormat::Vtu => {
            one(|data, out| vtk::write_mesh(out, vtk::Format::Xml, data.mesh, data.quality, data.second_order))
        }
        MeshFormat::Vtk => {
            one(|data, out| vtk::write_mesh(out, vtk::Format::Legacy, data.mesh, data.quality, data.second_order))
        }
        MeshFormat::Gmsh => one(gmsh::write),
        MeshFormat::Medit => one(medit::write),
        MeshFormat::Abaqus => one(abaqus::write),
        MeshFormat::TetGen => {
            let parts: [fn(&MeshData, &mut AtomicFile) -> io::Result<()>; 3] =
                [tetgen::write_nodes, tetgen::write_elements, tetgen::write_faces];
            let names = format.files(path);
            names.iter().zip(parts).map(|(name, write)| AtomicFile::fill(name, |file| write(data, file))).collect()
        }
    }?;
    commit_all(files)
}

/// The boundary of a mesh as a surface of its own.
struct SurfaceData<'a> {
    /// For each point the vertex of the mesh.
    vertices: Vec<u32>,
    points: Vec<DVec3>,
    /// Outward triangles over the points.
    triangles: Vec<[u32; 3]>,
    /// The same triangles in the mesh.
    boundary: &'a [BoundaryTriangle],
    encoding: Encoding,
}

/// Writes the boundary of a mesh in the format of `path`'s extension, whole or not at all.
///
/// # Errors
/// [`Error::Write`]; also where the format cannot hold the surface.
pub fn write_surface(path: &Path, format: SurfaceFormat, mesh: &TetMesh, encoding: Encoding) -> Result<(), Error> {
    check_ids(path, mesh)?;
    let (vertices, triangles) = mesh.boundary_mesh();
    let points = vertices.iter().map(|&v| mesh.points[v as usize]).collect();
    let data = SurfaceData { vertices, points, triangles, boundary: &mesh.boundary, encoding };
    AtomicFile::write_with(path, |file| match format {
        SurfaceFormat::Vtp => vtk::write_surface(file, vtk::Format::Xml, mesh),
        SurfaceFormat::Vtk => vtk::write_surface(file, vtk::Format::Legacy, mesh),
        SurfaceFormat::Obj => obj::write(&data, file),
        SurfaceFormat::Stl => stl::write(&data, file),
        SurfaceFormat::Ply => ply::write(&data, file),
    })
}

/// Refuses numbers of patches, regions and faces that do not fit the signed integers of 32 bits that most formats have for
/// them, with 1 added in some.
fn check_ids(path: &Path, mesh: &TetMesh) -> Result<(), Error> {
    const MOST: u32 = i32::MAX as u32 - 1;
    let of_boundary = mesh.boundary.iter().flat_map(|b| [("patch", b.patch), ("source triangle", b.source_triangle)]);
    let mut all = of_boundary.chain(mesh.regions.iter().map(|&r| ("region", r)));
    match all.find(|&(_, id)| id > MOST) {
        Some((what, id)) => Err(Error::Write {
            path: path.to_owned(),
            reason: format!("{what} {id} is over {MOST}, the largest number"),
        }),
        None => Ok(()),
    }
}

/// Writes numbers with blanks between them and ends the line.
fn line<T: std::fmt::Display>(out: &mut impl Write, numbers: impl IntoIterator<Item = T>) -> io::Result<()> {
    let mut first = true;
    for number in numbers {
        if !std::mem::replace(&mut first, false) {
            out.write_all(b" ")?;
        }
        write!(out, "{number}")?;
    }
    out.write_all(b"\n")
}

/// A point as three decimals, each the shortest that reads back to the same number.
struct Decimals(DVec3, &'static str);

impl std::fmt::Display for Decimals {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Decimals(p, between) = self;
        write!(f, "{:?}{between}{:?}{between}{:?}", p.x, p.y, p.z)
    }
}

/// The values that occur, ascending.
fn distinct(values: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut values: Vec<u32> = values.collect();
    values.sort_unstable();
    values.dedup();
    values
}
