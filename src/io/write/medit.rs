//! Medit's `.mesh`, text: P. J. Frey, *MEDIT: an interactive mesh visualization software*, INRIA technical report 247, 2001.
//! References of triangles are patches, of tets regions, of vertices what they lie on (`kind`); all of them plus 1 but
//! the last.

use std::io::{self, Write};

use super::{Decimals, MeshData, line};
use crate::seeds::SeedKind;

pub(super) fn write(data: &MeshData, out: &mut impl Write) -> io::Result<()> {
    let mesh = data.mesh;
    write!(out, "MeshVersionFormatted 2\n\nDimension 3\n\nVertices\n{}\n", mesh.points.len())?;
    for (&p, &kind) in mesh.points.iter().zip(&mesh.kinds) {
        writeln!(out, "{} {}", Decimals(p, " "), kind as u8)?;
    }
    let corners: Vec<usize> = (0..mesh.kinds.len()).filter(|&v| mesh.kinds[v] == SeedKind::Corner).collect();
    if !corners.is_empty() {
        write!(out, "\nCorners\n{}\n", corners.len())?;
        corners.iter().try_for_each(|v| writeln!(out, "{}", v + 1))?;
    }
    write!(out, "\nTriangles\n{}\n", mesh.boundary.len())?;
    for triangle in &mesh.boundary {
        line(out, triangle.vertices.into_iter().chain([triangle.patch]).map(|v| v + 1))?;
    }
    write!(out, "\nTetrahedra\n{}\n", mesh.tets.len())?;
    for (tet, &region) in mesh.tets.iter().zip(&mesh.regions) {
        line(out, tet.iter().chain([&region]).map(|v| v + 1))?;
    }
    out.write_all(b"\nEnd\n")
}
