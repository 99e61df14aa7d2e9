//! Reads the points of a mesh to start from: `.vtu` and `.vtk`, this program's or another's.

use std::path::Path;

use super::vtk_pieces::{DataArray, Piece};
use super::{Format, bytes_of, format, vtk_legacy, vtk_xml};
use crate::error::Error;
use crate::seeds::{InitialPoints, SeedKind};

/// Reads all points of a mesh, with their point data `kind` where the file has it.
///
/// # Errors
/// [`Error::Read`] where the file cannot be read or parsed, or its points are not all vertices, as in the files of curved tets.
pub fn read_initial(path: &Path) -> Result<InitialPoints, Error> {
    let bytes = bytes_of(path)?;
    parse_initial(&bytes, path).map_err(|reason| Error::Read { path: path.to_owned(), reason })
}

/// The same out of the bytes of a file; `path` is asked for its extension where they do not tell their format.
///
/// # Errors
/// The reason.
pub fn parse_initial(bytes: &[u8], path: &Path) -> Result<InitialPoints, String> {
    let pieces = match format(bytes, path) {
        Some(Format::VtkXml) => vtk_xml::parse_points(bytes)?,
        Some(Format::VtkLegacy) => vec![vtk_legacy::parse_piece(bytes)?],
        _ => return Err("a mesh to start from is read from .vtu and .vtk alone".into()),
    };
    let mut initial = InitialPoints::default();
    let mut known = !pieces.is_empty();
    for Piece { points, point_arrays, .. } in &pieces {
        let array = |name: &str| -> Result<Option<&DataArray>, String> {
            let Some(found) = point_arrays.iter().find(|a| a.name == name) else { return Ok(None) };
            match found.values.len() {
                n if n == points.len() => Ok(Some(found)),
                n => Err(format!("it has {} points, but {n} numbers {name:?} on them", points.len())),
            }
        };
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(format!("point {} is not finite", initial.points.len() + i));
        }
        let added = array("seed")?.map_or(0, |seeds| seeds.values.iter().filter(|&&s| s < 0.0).count());
        if added > 0 {
            return Err(format!(
                "{added} of its points are no vertices (their seed is -1): a mesh of straight tets is wanted"
            ));
        }
        // Our meshes have both; `--delaunay` files have seeds alone.
        if array("seed")?.is_some() && array("kind")?.is_none() {
            return Err(
                "it is the triangulation of a run (--delaunay), not a mesh: its points are in another frame".into()
            );
        }
        initial.points.extend(points);
        match array("kind")? {
            Some(kinds) => initial.kinds.extend(kinds.values.iter().map(|&k| kind(k)).collect::<Result<Vec<_>, _>>()?),
            None => known = false,
        }
    }
    if initial.points.is_empty() {
        return Err("it has no points".into());
    }
    if !known {
        initial.kinds.clear();
    }
    Ok(initial)
}

/// The kind of a number of the mesh file.
fn kind(number: f64) -> Result<SeedKind, String> {
    let kinds = [SeedKind::Interior, SeedKind::Surface, SeedKind::Curve, SeedKind::Corner];
    let found = kinds.into_iter().find(|&k| f64::from(k as u8) == number);
    found.ok_or_else(|| format!("{number} is no kind of a point: 0 to 3 are"))
}
