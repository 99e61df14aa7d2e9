//! A picture of what is wrong with a surface, as poly data of VTK (`.vtp`, text): bad vertices, edges and triangles, each
//! with the number of its flaw and the face of the input that it is on.

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use super::atomic::AtomicFile;
use crate::error::Error;
use crate::surface::defects::{Flaw, Marks, Shape};

/// Writes the marks: cell data `defect`, a [`Flaw`], and `face`, counted from 0.
///
/// # Errors
/// [`Error::Write`].
pub fn write(path: &Path, marks: &Marks) -> Result<(), Error> {
    AtomicFile::write_with(path, |file| file.write_all(text(marks).as_bytes()))
}

/// The points of a shape, and the place of its kind in a file: vertices, lines, polygons.
fn corners(shape: &Shape) -> (usize, &[[f64; 3]]) {
    match shape {
        Shape::Point(p) => (0, std::slice::from_ref(p)),
        Shape::Edge(ends) => (1, ends),
        Shape::Triangle(corners) => (2, corners),
    }
}

fn text(marks: &Marks) -> String {
    let mut list: Vec<&(Flaw, Shape, u32)> = marks.list.iter().collect();
    list.sort_by_key(|mark| corners(&mark.1).0);
    let count = |kind: usize| list.iter().filter(|m| corners(&m.1).0 == kind).count();
    let points: Vec<[f64; 3]> = list.iter().flat_map(|m| corners(&m.1).1).copied().collect();
    let mut xml = String::from("<?xml version=\"1.0\"?>\n<!-- defect:");
    for (flaw, name) in NAMES {
        xml += &format!(" {} {name};", flaw as u8);
    }
    xml += &format!(
        " -->\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfPolys=\"{}\" NumberOfStrips=\"0\">\n",
        points.len(),
        count(0),
        count(1),
        count(2)
    );
    xml += "<CellData Scalars=\"defect\">\n";
    array(&mut xml, "UInt8", "defect", 1, list.iter().map(|m| (m.0 as u8).to_string()));
    array(&mut xml, "Int64", "face", 1, list.iter().map(|m| m.2.to_string()));
    xml += "</CellData>\n<Points>\n";
    array(&mut xml, "Float64", "Points", 3, points.as_flattened().iter().map(|x| format!("{x:?}")));
    xml += "</Points>\n";
    let mut first = 0;
    for (kind, section) in ["Verts", "Lines", "Polys"].into_iter().enumerate() {
        let (size, cells) = (kind + 1, count(kind));
        xml += &format!("<{section}>\n");
        array(&mut xml, "Int64", "connectivity", 1, (first..first + size * cells).map(|i| i.to_string()));
        array(&mut xml, "Int64", "offsets", 1, (1..=cells).map(|k| (k * size).to_string()));
        xml += &format!("</{section}>\n");
        first += size * cells;
    }
    xml + "</Piece>\n</PolyData>\n</VTKFile>\n"
}

/// What the numbers stand for.
const NAMES: [(Flaw, &str); 8] = [
    (Flaw::Open, "open edge"),
    (Flaw::NonManifoldEdge, "non-manifold edge"),
    (Flaw::NonManifoldVertex, "non-manifold vertex"),
    (Flaw::NonOrientable, "not orientable"),
    (Flaw::DuplicateFace, "duplicate face"),
    (Flaw::SelfCrossing, "crosses or touches another face"),
    (Flaw::Degenerate, "no area"),
    (Flaw::NoVolume, "no volume"),
];

fn array(xml: &mut String, kind: &str, name: &str, components: usize, values: impl Iterator<Item = String>) {
    *xml +=
        &format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">\n");
    for value in values {
        // Writing to a string does not fail.
        let _ = writeln!(xml, "{value}");
    }
    *xml += "</DataArray>\n";
}
