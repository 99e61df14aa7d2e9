//! Clipped Voronoi cells as VTK's polyhedra, XML format.
//!
//! ```text
//! connectivity    the points of each cell, each once
//! faces           for each cell: number of faces, then of each face: number of corners, corners
//! ```

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::xml::{self, Appended, Block};
use super::{Array, signed};
use crate::clipped_voronoi::Polyhedra;
use crate::clipped_voronoi::polyhedra::SURFACE;
use crate::error::Error;
use crate::geometry::frame::Frame;
use crate::io::atomic::AtomicFile;

/// VTK's number of a polyhedron.
const VTK_POLYHEDRON: u8 = 42;

/// Writes the cells; the file is left to be committed. Cell data: `seed`, `volume` as `volumes` has it for each seed in the
/// frame, `neighbors`, the number of cells that share a face with it. Field data: `neighbor`, these cells' seeds, cell by
/// cell.
pub fn write_voronoi(path: &Path, cells: &Polyhedra, volumes: &[f64], frame: &Frame) -> Result<AtomicFile, Error> {
    AtomicFile::fill(path, |file| write(cells, volumes, frame, file))
}

/// The seeds whose cells share a face with cell `c`, ascending.
fn neighbors(cells: &Polyhedra, c: usize) -> Vec<u32> {
    let mut seeds: Vec<u32> = cells.faces(c).map(|(_, beyond)| beyond).filter(|&s| s != SURFACE).collect();
    seeds.sort_unstable();
    seeds.dedup();
    seeds
}

fn write(cells: &Polyhedra, volumes: &[f64], frame: &Frame, out: &mut impl Write) -> io::Result<()> {
    let points: Vec<DVec3> = cells.points.iter().map(|&p| frame.to_model(p)).collect();
    let around: Vec<Vec<u32>> = (0..cells.len()).map(|c| neighbors(cells, c)).collect();
    let side = 1.0 / frame.scale;
    let volume: Vec<f64> = cells.seeds.iter().map(|&s| volumes[s as usize] * side * side * side).collect();
    let cell_data = [
        Array::integers("seed", cells.seeds.iter().copied().map(signed)),
        Array::reals("volume", 1, &volume),
        Array::integers("neighbors", around.iter().map(|a| signed(a.len() as u32))),
    ];
    let field_data = [Array::integers("neighbor", around.iter().flatten().copied().map(signed))];

    let mut appended = Appended::default();
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n  <UnstructuredGrid>\n",
    );
    xml::section(&mut xml, "FieldData", &field_data, &mut appended);
    xml += &format!("    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", points.len(), cells.len());
    xml::section(&mut xml, "CellData", &cell_data, &mut appended);
    xml += "      <Points>\n";
    xml += &appended.declare("Points", 3, Block::Points(&points));
    xml += "      </Points>\n      <Cells>\n";
    let streams = Streams::of(cells);
    xml += &appended.declare("connectivity", 1, Block::Long(streams.connectivity));
    xml += &appended.declare("offsets", 1, Block::Long(streams.offsets));
    xml += &appended.declare("types", 1, Block::Repeated { value: VTK_POLYHEDRON, count: cells.len() });
    xml += &appended.declare("faces", 1, Block::Long(streams.faces));
    xml += &appended.declare("faceoffsets", 1, Block::Long(streams.face_offsets));
    xml += "      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n_";
    xml::finish(&xml, &appended, out)
}

/// The arrays that describe the cells.
#[derive(Default)]
struct Streams {
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    faces: Vec<i64>,
    face_offsets: Vec<i64>,
}

impl Streams {
    fn of(cells: &Polyhedra) -> Streams {
        let mut streams = Streams::default();
        for c in 0..cells.len() {
            let count = cells.first_face[c + 1] - cells.first_face[c];
            streams.faces.push(count.into());
            let mut own = Vec::new();
            for (corners, _) in cells.faces(c) {
                streams.faces.push(corners.len() as i64);
                streams.faces.extend(corners.iter().map(|&p| i64::from(p)));
                own.extend(corners.iter().map(|&p| i64::from(p)));
            }
            own.sort_unstable();
            own.dedup();
            streams.connectivity.extend(own);
            streams.offsets.push(streams.connectivity.len() as i64);
            streams.face_offsets.push(streams.faces.len() as i64);
        }
        streams
    }
}
