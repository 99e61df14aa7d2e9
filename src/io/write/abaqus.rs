//! An input file of Abaqus, which CalculiX reads too: nodes, elements C3D4 or C3D10 in a set `REGION_r` for each region,
//! and a surface `PATCH_p` for each patch, made of faces of elements.

use std::io::{self, Write};

use super::facets;
use super::{Decimals, MeshData, distinct};

/// The face of an element that lies opposite each of its corners: S1 is 1-2-3, S2 1-4-2, S3 2-4-3, S4 3-4-1.
const FACE: [usize; 4] = [3, 4, 2, 1];

/// Entries of a line in a list.
const IN_A_LINE: usize = 16;

pub(super) fn write(data: &MeshData, out: &mut impl Write) -> io::Result<()> {
    let mesh = data.mesh;
    writeln!(out, "*HEADING\ntetcvt {}\n*NODE", env!("CARGO_PKG_VERSION"))?;
    for (i, p) in data.nodes().enumerate() {
        writeln!(out, "{}, {}", i + 1, Decimals(p, ", "))?;
    }
    let kind = if data.second_order.is_some() { "C3D10" } else { "C3D4" };
    let mut nodes = Vec::new();
    for region in distinct(mesh.regions.iter().copied()) {
        writeln!(out, "*ELEMENT, TYPE={kind}, ELSET=REGION_{region}")?;
        for t in (0..mesh.tets.len()).filter(|&t| mesh.regions[t] == region) {
            data.tet_nodes(t, &mut nodes);
            write!(out, "{}", t + 1)?;
            nodes.iter().try_for_each(|v| write!(out, ", {}", v + 1))?;
            out.write_all(b"\n")?;
        }
    }
    write_patches(data, out)
}

fn write_patches(data: &MeshData, out: &mut impl Write) -> io::Result<()> {
    let behind = facets::behind(data.mesh);
    let mut faces: Vec<(u32, usize, u32)> = data
        .mesh
        .boundary
        .iter()
        .zip(&behind)
        .map(|(b, &(tet, corner))| (b.patch, FACE[corner as usize], tet))
        .collect();
    faces.sort_unstable();
    for patch in faces.chunk_by(|a, b| a.0 == b.0) {
        let name = patch[0].0;
        for side in patch.chunk_by(|a, b| a.1 == b.1) {
            writeln!(out, "*ELSET, ELSET=PATCH_{name}_S{}", side[0].1)?;
            for entries in side.chunks(IN_A_LINE) {
                let numbers: Vec<String> = entries.iter().map(|e| (e.2 + 1).to_string()).collect();
                writeln!(out, "{}", numbers.join(", "))?;
            }
        }
        writeln!(out, "*SURFACE, NAME=PATCH_{name}, TYPE=ELEMENT")?;
        for side in patch.chunk_by(|a, b| a.1 == b.1) {
            writeln!(out, "PATCH_{name}_S{face}, S{face}", face = side[0].1)?;
        }
    }
    Ok(())
}
