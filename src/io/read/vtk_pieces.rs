//! What both formats of VTK hold: points, cells over them, numbers on the cells.

use glam::DVec3;

use super::{Builder, Soup, patch_rank, patches, strip};

/// VTK's numbers of the types of cells that are faces, and of those that are passed over.
pub const VERTEX: u8 = 1;
pub const TRIANGLE_STRIP: u8 = 6;
pub const POLYGON: u8 = 7;
const EMPTY: u8 = 0;
const POLY_LINE: u8 = 4;
const TRIANGLE: u8 = 5;
const PIXEL: u8 = 8;
const QUAD: u8 = 9;

/// Cells of one kind or several.
#[derive(Default)]
pub struct Cells {
    /// Points of all cells, one after the other.
    pub corners: Vec<f64>,
    /// Where each cell's points end.
    pub ends: Vec<usize>,
}

impl Cells {
    /// Cells out of the two arrays of the newer files; `what` names them.
    pub fn of_offsets(corners: Vec<f64>, offsets: &[f64], what: &str) -> Result<Cells, String> {
        let mut ends = Vec::with_capacity(offsets.len());
        let mut last = 0;
        for (k, &offset) in offsets.iter().enumerate() {
            let end = offset as usize;
            if offset != end as f64 || end < last || end > corners.len() {
                return Err(format!("{what}: offset {offset} of cell {k} cannot be"));
            }
            ends.push(end);
            last = end;
        }
        Ok(Cells { corners, ends })
    }

    /// Cells out of the one array of older files: each its number of points, then these.
    pub fn of_counts(numbers: &[f64], count: usize, what: &str) -> Result<Cells, String> {
        let mut cells = Cells::default();
        let mut at = 0;
        for k in 0..count {
            let points = numbers.get(at).map_or(usize::MAX, |&n| if n >= 0.0 { n as usize } else { usize::MAX });
            let Some(ids) = at.checked_add(1).and_then(|begin| numbers.get(begin..begin.checked_add(points)?)) else {
                return Err(format!("{what}: the list ends within cell {k}"));
            };
            cells.corners.extend_from_slice(ids);
            cells.ends.push(cells.corners.len());
            at += 1 + points;
        }
        Ok(cells)
    }
}

/// Numbers on cells or points: one for each.
pub struct DataArray {
    pub name: String,
    pub is_integer: bool,
    pub values: Vec<f64>,
}

/// A data set, or a piece of one.
#[derive(Default)]
pub struct Piece {
    pub points: Vec<DVec3>,
    pub cells: Vec<(Kinds, Cells)>,
    /// Numbers on all of the cells, in the order of `cells`.
    pub arrays: Vec<DataArray>,
    /// Numbers on all of the points.
    pub point_arrays: Vec<DataArray>,
}

impl Piece {
    /// All cells, in the order of the file: the type of each and its points, as the file has them. An error in place of a
    /// cell whose type is missing.
    pub fn each_cell(&self) -> impl Iterator<Item = Result<(f64, &[f64]), String>> {
        self.cells.iter().flat_map(|(kinds, cells)| {
            let mut begin = 0;
            cells.ends.iter().enumerate().map(move |(k, &end)| {
                let kind = match kinds {
                    Kinds::All(kind) => f64::from(*kind),
                    Kinds::Each(kinds) => kinds.get(k).copied().ok_or("it has more cells than types of cells")?,
                };
                Ok((kind, &cells.corners[std::mem::replace(&mut begin, end)..end]))
            })
        })
    }
}

/// The types of a list of cells.
pub enum Kinds {
    All(u8),
    Each(Vec<f64>),
}

/// Makes triangles of the faces; every cell counts, so that indices are those that ParaView shows.
pub fn assemble(pieces: Vec<Piece>) -> Result<Soup, String> {
    let mut builder = Builder::default();
    let mut values = vec![];
    let mut grouped = !pieces.is_empty();
    for piece in &pieces {
        let cells: usize = piece.cells.iter().map(|(_, c)| c.ends.len()).sum();
        match patch_array(&piece.arrays, cells) {
            Some(array) => values.extend_from_slice(&array.values),
            None => grouped = false,
        }
    }
    let patch = if grouped { patches(&values, &mut builder.soup.notes) } else { vec![] };
    for piece in &pieces {
        let (base, points) = (builder.soup.points.len(), piece.points.len());
        for &p in &piece.points {
            builder.point(p)?;
        }
        for cell in piece.each_cell() {
            let (kind, of_piece) = cell?;
            let corner = |&v: &f64| if v >= 0.0 && v < points as f64 { base + v as usize } else { usize::MAX };
            let corners: Vec<usize> = of_piece.iter().map(corner).collect();
            let number = builder.faces as usize;
            let patch = patch.get(number).copied().unwrap_or(0);
            add(&mut builder, kind, &corners, patch).map_err(|e| {
                match corners.iter().position(|&v| v == usize::MAX) {
                    Some(i) => format!("cell {number} refers to point {}, but there are {points}", of_piece[i]),
                    None => format!("cell {number}: {e}"),
                }
            })?;
        }
    }
    Ok(builder.finish(grouped))
}

/// Adds a cell as a face.
fn add(builder: &mut Builder, kind: f64, corners: &[usize], patch: u32) -> Result<(), String> {
    let kind = if (0.0..=255.0).contains(&kind) { kind as u8 } else { u8::MAX };
    match kind {
        EMPTY..=POLY_LINE => builder.no_face(),
        TRIANGLE | POLYGON | QUAD => builder.face(corners, patch),
        PIXEL => match *corners {
            // A quad whose points come row by row.
            [a, b, c, d] => builder.face(&[a, b, d, c], patch),
            _ => Err(format!("a pixel has 4 points, not {}", corners.len())),
        },
        TRIANGLE_STRIP => {
            builder.no_face()?;
            strip::triangles(corners.len()).try_for_each(|t| builder.more_of_face(t.map(|i| corners[i]), patch))
        }
        other => Err(format!("it is of VTK's type {other}, no flat face: extract the surface and triangulate it")),
    }
}

/// The numbers that tell patches: those with a name that says so, or else the only whole ones, unless they are a number
/// for each face.
fn patch_array(arrays: &[DataArray], cells: usize) -> Option<&DataArray> {
    let fitting = || arrays.iter().filter(|a| a.values.len() == cells);
    let named = fitting().filter_map(|a| Some((patch_rank(&a.name)?, a))).min_by_key(|(rank, _)| *rank);
    if let Some((_, array)) = named {
        return Some(array);
    }
    let mut whole = fitting().filter(|a| a.is_integer);
    let (only, others) = (whole.next()?, whole.next());
    let mut distinct = only.values.clone();
    distinct.sort_unstable_by(f64::total_cmp);
    distinct.dedup();
    (others.is_none() && 2 * distinct.len() <= cells).then_some(only)
}
