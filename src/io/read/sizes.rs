//! Reads meshes of tets with a size on each point: `.vtu` and `.vtk`.

use std::path::Path;

use super::vtk_pieces::Piece;
use super::{Format, bytes_of, format, vtk_legacy, vtk_xml};
use crate::error::Error;
use crate::sizing::SizeMesh;

/// The name of the numbers.
const NAME: &str = "size";

/// VTK's numbers of the types of flat cells end here; of tets, of curved ones too.
const LAST_FLAT: f64 = 9.0;
const TETS: [f64; 2] = [10.0, 24.0];

/// Reads the tets of a mesh and its point data `size`; flat cells are passed over.
///
/// # Errors
/// [`Error::Read`] where the file cannot be read or parsed, has no such data or other cells than tets, or where a size is not
/// positive.
pub fn read_sizes(path: &Path) -> Result<SizeMesh, Error> {
    let bytes = bytes_of(path)?;
    let mesh = parse(&bytes, path).and_then(|mesh| mesh.check().map(|()| mesh));
    mesh.map_err(|reason| Error::Read { path: path.to_owned(), reason })
}

fn parse(bytes: &[u8], path: &Path) -> Result<SizeMesh, String> {
    let pieces = match format(bytes, path) {
        Some(Format::VtkXml) => vtk_xml::parse_all(bytes)?,
        Some(Format::VtkLegacy) => vec![vtk_legacy::parse_piece(bytes)?],
        _ => return Err("sizes are read from .vtu and .vtk alone".into()),
    };
    let mut mesh = SizeMesh::default();
    for piece in &pieces {
        add(&mut mesh, piece)?;
    }
    Ok(mesh)
}

fn add(mesh: &mut SizeMesh, piece: &Piece) -> Result<(), String> {
    let points = piece.points.len();
    if points == 0 {
        return Ok(());
    }
    let Some(sizes) = piece.point_arrays.iter().find(|a| a.name == NAME) else {
        let names: Vec<String> = piece.point_arrays.iter().map(|a| format!("{:?}", a.name)).collect();
        let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        return Err(format!("it has no point data {NAME:?} with one number a point; those there are: {there}"));
    };
    if sizes.values.len() != points {
        return Err(format!("it has {points} points, but {} numbers {NAME:?} on them", sizes.values.len()));
    }
    let base = mesh.points.len();
    for (number, cell) in piece.each_cell().enumerate() {
        let (kind, corners) = cell?;
        if kind <= LAST_FLAT {
            continue;
        }
        if !TETS.contains(&kind) || corners.len() < 4 {
            return Err(format!("cell {number} is of VTK's type {kind}, no tet (10)"));
        }
        let mut tet = [0; 4];
        for (vertex, &corner) in tet.iter_mut().zip(corners) {
            if !(corner >= 0.0 && corner < points as f64) {
                return Err(format!("cell {number} refers to point {corner}, but there are {points}"));
            }
            *vertex = (base + corner as usize) as u32;
        }
        mesh.tets.push(tet);
    }
    mesh.points.extend_from_slice(&piece.points);
    mesh.sizes.extend_from_slice(&sizes.values);
    Ok(())
}
