//! The polygon file format, binary (little-endian) or text: positions in double precision, `vertex` of each point, and
//! what the other surface files say of each triangle.

use std::io::{self, Write};

use super::{Decimals, SurfaceData};
use crate::io::format::Encoding;

pub(super) fn write(data: &SurfaceData, out: &mut impl Write) -> io::Result<()> {
    let binary = data.encoding == Encoding::Binary;
    let form = if binary { "binary_little_endian" } else { "ascii" };
    write!(out, "ply\nformat {form} 1.0\ncomment tetcvt {}\n", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "element vertex {}", data.points.len())?;
    write!(out, "property double x\nproperty double y\nproperty double z\nproperty int vertex\n")?;
    write!(out, "element face {}\nproperty list uchar int vertex_indices\n", data.triangles.len())?;
    write!(out, "property int region_inside\nproperty int region_outside\n")?;
    write!(out, "property int patch\nproperty int source_triangle\nend_header\n")?;
    for (&p, &vertex) in data.points.iter().zip(&data.vertices) {
        if binary {
            p.to_array().iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
            out.write_all(&vertex.to_le_bytes())?;
        } else {
            writeln!(out, "{} {vertex}", Decimals(p, " "))?;
        }
    }
    for (&[a, b, c], t) in data.triangles.iter().zip(data.boundary) {
        if binary {
            let (inside, outside) = (t.region_inside, t.region_outside as u32);
            out.write_all(&[3])?;
            let numbers = [a, b, c, inside, outside, t.patch, t.source_triangle];
            numbers.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
        } else {
            let (inside, outside, patch, source) = (t.region_inside, t.region_outside, t.patch, t.source_triangle);
            writeln!(out, "3 {a} {b} {c} {inside} {outside} {patch} {source}")?;
        }
    }
    Ok(())
}
