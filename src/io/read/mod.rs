//! Reads surfaces: OBJ, STL, PLY, OFF, VTK, glTF. The content of a file decides its format, its name only where the
//! content does not.
//!
//! A reader takes the bytes of a file and gives triangles over points in f64, with the index of the face that each
//! comes from and the group that it is in; polygons are cut. Nothing is checked but that indices exist: that is the
//! surface's own affair. No reader panics, whatever the bytes, and none allocates more than the file can hold.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;

use crate::error::Error;
use crate::geometry::polygon;
use crate::surface::defects::{Defect, Marks};
use crate::surface::{Surface, Treatment, note_count};

mod gltf;

mod initial;

mod lines;

mod obj;

mod off;

mod ply;

mod sizes;

mod stl;

mod strip;

mod vtk_legacy;

mod vtk_pieces;

mod vtk_xml;

mod words;

pub use initial::{parse_initial, read_initial};
pub use lines::{parse_lines, read_lines};
pub use sizes::read_sizes;

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Obj,
    StlText,
    StlBinary,
    Ply,
    Off,
    VtkLegacy,
    VtkXml,
    Gltf,
}

/// Reads and checks the surface in a file.
///
/// # Errors
/// [`Error::Read`] where the file cannot be read or parsed, [`Error::Surface`] where it bounds no solid.
pub fn read(path: &Path) -> Result<Surface, Error> {
    Ok(load(path)?.check()?)
}

/// Reads a file, without checking what it holds.
///
/// # Errors
/// [`Error::Read`], with the line or the element.
pub fn load(path: &Path) -> Result<Soup, Error> {
    parse(&bytes_of(path)?, path).map_err(|reason| Error::Read { path: path.to_owned(), reason })
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, Error> {
    let fail = |reason: String| Error::Read { path: path.to_owned(), reason };
    if path.is_dir() {
        return Err(fail("it is a folder".into()));
    }
    std::fs::read(path).map_err(|e| fail(e.to_string()))
}

/// Reads the bytes of a file; `path` is asked for its extension where they do not tell their format, and for the folder
/// of the files that they name.
///
/// # Errors
/// The reason, with the line or the element.
pub fn parse(bytes: &[u8], path: &Path) -> Result<Soup, String> {
    match format(bytes, path) {
        Some(Format::Obj) => obj::parse(bytes),
        Some(Format::StlText) => stl::parse_text(bytes),
        Some(Format::StlBinary) => stl::parse_binary(bytes),
        Some(Format::Ply) => ply::parse(bytes),
        Some(Format::Off) => off::parse(bytes),
        Some(Format::VtkLegacy) => vtk_legacy::parse(bytes),
        Some(Format::VtkXml) => vtk_xml::parse(bytes),
        Some(Format::Gltf) => gltf::parse(bytes, path.parent().unwrap_or(Path::new(""))),
        None => Err("neither its content nor its name tells a format that is read: OBJ, STL, PLY, OFF, VTK (.vtk, \
                     .vtp, .vtu), glTF (.gltf, .glb)"
            .into()),
    }
}

/// The format of a file: by its first bytes, by its length for binary STL, by its first statement for OBJ, at last by
/// its extension.
fn format(bytes: &[u8], path: &Path) -> Option<Format> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let head = &text[..text.len().min(4096)];
    if bytes.starts_with(b"glTF") {
        return Some(Format::Gltf);
    }
    if bytes.starts_with(b"ply") && bytes.get(3).is_some_and(u8::is_ascii_whitespace) {
        return Some(Format::Ply);
    }
    if head.get(..9).is_some_and(|h| h.eq_ignore_ascii_case(b"# vtk Dat")) {
        return Some(Format::VtkLegacy);
    }
    if head.starts_with(b"<") && head.windows(7).any(|w| w == b"VTKFile") {
        return Some(Format::VtkXml);
    }
    if head.starts_with(b"{") {
        return Some(Format::Gltf);
    }
    if words::Words::without_comments(text, b'#').next().is_some_and(|w| off::keyword(w).is_some()) {
        return Some(Format::Off);
    }
    // Binary STL files may begin with "solid" too: their length tells.
    if stl::is_binary(bytes) {
        return Some(Format::StlBinary);
    }
    if stl::is_text(text) {
        return Some(Format::StlText);
    }
    if obj::is_likely(text) {
        return Some(Format::Obj);
    }
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "obj" => Some(Format::Obj),
        // Some writers leave bytes behind the triangles.
        "stl" | "stlb" => Some(Format::StlBinary),
        "ply" => Some(Format::Ply),
        "off" => Some(Format::Off),
        "vtk" => Some(Format::VtkLegacy),
        "vtp" | "vtu" => Some(Format::VtkXml),
        "gltf" | "glb" => Some(Format::Gltf),
        _ => None,
    }
}

/// What a file holds, before any check.
#[derive(Debug, Default)]
pub struct Soup {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    source: Vec<u32>,
    patch: Vec<u32>,
    notes: Vec<String>,
}

impl Soup {
    /// Checks it and makes it a surface.
    ///
    /// # Errors
    /// The [`Defect`] that keeps it from bounding a solid.
    pub fn check(self) -> Result<Surface, Defect> {
        self.check_as(Treatment::default(), &mut Marks::default())
    }

    /// The same with the choice of what is mended and of what nested shells are; the places of all that is wrong go to `marks`.
    ///
    /// # Errors
    /// The [`Defect`] that keeps it from bounding a solid.
    pub fn check_as(self, treatment: Treatment, marks: &mut Marks) -> Result<Surface, Defect> {
        let surface = Surface::build(&self.points, &self.triangles, [&self.source, &self.patch], treatment, marks)?;
        Ok(surface.with_notes(self.notes))
    }

    /// Points, in the order of the file.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Triangles, in the order of the file.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// For each triangle, the index of its face in the file.
    pub fn source(&self) -> &[u32] {
        &self.source
    }

    /// For each triangle, the group that it is in.
    pub fn patch(&self) -> &[u32] {
        &self.patch
    }
}

/// Collects the points and faces of a file.
#[derive(Default)]
struct Builder {
    soup: Soup,
    /// Faces so far.
    faces: u32,
    /// Faces with fewer than three corners, and polygons that fold.
    short: usize,
    folded: usize,
}

impl Builder {
    /// Adds a point; returns its index.
    fn point(&mut self, p: DVec3) -> Result<usize, String> {
        let index = self.soup.points.len();
        if index >= u32::MAX as usize {
            return Err(format!("it has more than {} vertices", u32::MAX));
        }
        self.soup.points.push(p);
        Ok(index)
    }

    /// Adds a face over points that are there, cut into triangles.
    fn face(&mut self, corners: &[usize], patch: u32) -> Result<(), String> {
        let known = self.soup.points.len();
        if let Some(v) = corners.iter().find(|&&v| v >= known) {
            return Err(format!("a face refers to vertex {v}, counted from 0, but there are only {known}"));
        }
        let face = self.faces;
        self.faces = face.checked_add(1).ok_or_else(|| format!("it has more than {} faces", u32::MAX))?;
        match *corners {
            [] | [_] | [_, _] => self.short += 1,
            [a, b, c] => self.push([a, b, c], face, patch),
            _ => {
                let positions: Vec<DVec3> = corners.iter().map(|&v| self.soup.points[v]).collect();
                let cut = polygon::cut(&positions);
                self.folded += usize::from(!cut.proper);
                cut.triangles.iter().for_each(|t| self.push(t.map(|i| corners[i]), face, patch));
            }
        }
        Ok(())
    }

    /// Adds a triangle with points of its own.
    fn triangle(&mut self, corners: [DVec3; 3], patch: u32) -> Result<(), String> {
        let first = self.soup.points.len();
        for p in corners {
            self.point(p)?;
        }
        self.face(&[first, first + 1, first + 2], patch)
    }

    fn push(&mut self, triangle: [usize; 3], face: u32, patch: u32) {
        // Indices of points fit 32 bits: `point` sees to it.
        self.soup.triangles.push(triangle.map(|v| v as u32));
        self.soup.source.push(face);
        self.soup.patch.push(patch);
    }

    /// Adds a face that counts as part of the face before: of a strip, for instance.
    fn more_of_face(&mut self, corners: [usize; 3], patch: u32) -> Result<(), String> {
        self.faces = self.faces.saturating_sub(1);
        self.face(&corners, patch)
    }

    /// Counts a thing of the file that is no face, so that the indices of faces go on being those of the file.
    fn no_face(&mut self) -> Result<(), String> {
        self.faces = self.faces.checked_add(1).ok_or_else(|| format!("it has more than {} faces", u32::MAX))?;
        Ok(())
    }

    /// What was collected. Groups that do not tell faces apart are none.
    fn finish(mut self, groups: bool) -> Soup {
        if !groups {
            self.soup.patch.fill(0);
        }
        let notes = &mut self.soup.notes;
        note_count(
            notes,
            self.short,
            "face with fewer than three corners was left out",
            "faces with fewer than three corners were left out",
        );
        note_count(
            notes,
            self.folded,
            "polygon could not be cut without folding (it crosses itself or has no area) and was fanned",
            "polygons could not be cut without folding (they cross themselves or have no area) and were fanned",
        );
        self.soup
    }
}

/// Names of the numbers on faces that tell patches, the first one that is there counts.
const PATCH_NAMES: [&str; 20] = [
    "patch",
    "patch_id",
    "patchid",
    "region",
    "region_id",
    "group",
    "group_id",
    "groupid",
    "label",
    "part",
    "part_id",
    "segment",
    "material",
    "material_id",
    "material_index",
    "surface_id",
    "face_id",
    "gmsh:physical",
    "medit:ref",
    "cellentityids",
];

/// How well the name of a number on faces tells that it is their patch: the less the better.
fn patch_rank(name: &str) -> Option<usize> {
    PATCH_NAMES.iter().position(|n| n.eq_ignore_ascii_case(name))
}

/// The largest number of a patch: formats that number from 1 have signed integers of 32 bits for it.
const MOST_PATCH: i32 = i32::MAX - 1;

/// Patches out of numbers on faces: the numbers themselves where they are whole and from 0 to [`MOST_PATCH`]; else they are
/// numbered in their order, with a note.
fn patches(values: &[f64], notes: &mut Vec<String>) -> Vec<u32> {
    let fits = |x: f64| x >= 0.0 && x <= f64::from(MOST_PATCH) && x == x.trunc();
    if values.iter().all(|&x| fits(x)) {
        return values.iter().map(|&x| x as u32).collect();
    }
    notes.push(format!(
        "the numbers on faces that tell patches are not all whole and from 0 to {MOST_PATCH}: patches were numbered in their order"
    ));
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.dedup_by(|a, b| a.total_cmp(b).is_eq());
    let number = |x: &f64| sorted.partition_point(|y| y.total_cmp(x).is_lt()) as u32;
    values.iter().map(number).collect()
}

/// Numbers names in the order of their appearance.
#[derive(Default)]
struct Names<K>(BTreeMap<K, u32>);

impl<K: Ord> Names<K> {
    fn number(&mut self, name: K) -> u32 {
        let next = self.0.len() as u32;
        *self.0.entry(name).or_insert(next)
    }
}
