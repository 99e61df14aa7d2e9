//! TetGen's `.node`, `.ele` and `.face`: H. Si, *TetGen, a Delaunay-based quality tetrahedral mesh generator*, ACM
//! Transactions on Mathematical Software 41(2), 2015, doi 10.1145/2629697. Counted from 0, as the other files' points.
//! The marker of a point is 1 on the boundary; the attribute of a tet is its region + 1, the marker of a face its
//! patch + 1: 0 means "none" there.

use std::io::{self, Write};

use super::{Decimals, MeshData, line};
use crate::seeds::SeedKind;

pub(super) fn write_nodes(data: &MeshData, out: &mut impl Write) -> io::Result<()> {
    let mesh = data.mesh;
    writeln!(out, "{} 3 0 1", mesh.points.len())?;
    for (i, (&p, &kind)) in mesh.points.iter().zip(&mesh.kinds).enumerate() {
        writeln!(out, "{i} {} {}", Decimals(p, " "), u8::from(kind != SeedKind::Interior))?;
    }
    Ok(())
}

pub(super) fn write_elements(data: &MeshData, out: &mut impl Write) -> io::Result<()> {
    let mesh = data.mesh;
    writeln!(out, "{} 4 1", mesh.tets.len())?;
    for (t, (tet, region)) in (0..).zip(mesh.tets.iter().zip(&mesh.regions)) {
        line(out, [t].iter().chain(tet).chain([&(region + 1)]))?;
    }
    Ok(())
}

pub(super) fn write_faces(data: &MeshData, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{} 1", data.mesh.boundary.len())?;
    for (f, triangle) in (0..).zip(&data.mesh.boundary) {
        line(out, [f].iter().chain(&triangle.vertices).chain([&(triangle.patch + 1)]))?;
    }
    Ok(())
}
