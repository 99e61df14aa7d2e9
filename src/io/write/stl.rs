//! Stereolithography, binary or text. The binary form has single precision and no more: a surface that it would
//! tear or flatten is refused.

use std::io::{self, Write};

use glam::{DVec3, Vec3};

use super::{Decimals, SurfaceData};
use crate::geometry::triangle::normal2;
use crate::io::format::Encoding;

pub(super) fn write(data: &SurfaceData, out: &mut impl Write) -> io::Result<()> {
    match data.encoding {
        Encoding::Text => write_text(data, out),
        Encoding::Binary => write_binary(data, out),
    }
}

/// The outward unit normal of a triangle; its size may be near either end of the range of `f64`.
fn unit_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let longest = (b - a).abs().max((c - a).abs()).max_element();
    normal2(DVec3::ZERO, (b - a) / longest, (c - a) / longest).normalize_or_zero()
}

fn write_text(data: &SurfaceData, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "solid tetcvt")?;
    for triangle in &data.triangles {
        let corners = triangle.map(|v| data.points[v as usize]);
        writeln!(out, "facet normal {}\n outer loop", Decimals(unit_normal(corners), " "))?;
        corners.iter().try_for_each(|&p| writeln!(out, "  vertex {}", Decimals(p, " ")))?;
        writeln!(out, " endloop\nendfacet")?;
    }
    writeln!(out, "endsolid tetcvt")
}

fn write_binary(data: &SurfaceData, out: &mut impl Write) -> io::Result<()> {
    let count =
        u32::try_from(data.triangles.len()).map_err(|_| io::Error::other("more triangles than STL can count"))?;
    let points: Vec<Vec3> = data.points.iter().map(|p| p.as_vec3()).collect();
    check(&points)?;
    let mut header = [b' '; 80];
    header[..6].copy_from_slice(b"tetcvt");
    out.write_all(&header)?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in &data.triangles {
        let normal = unit_normal(triangle.map(|v| data.points[v as usize])).as_vec3();
        let corners = triangle.map(|v| points[v as usize]);
        let mut record = [0; 50];
        let numbers = [normal].into_iter().chain(corners).flat_map(|p| p.to_array());
        record.chunks_exact_mut(4).zip(numbers).for_each(|(bytes, x)| bytes.copy_from_slice(&x.to_le_bytes()));
        out.write_all(&record)?;
    }
    Ok(())
}

/// Refuses points that are not finite, or no longer apart, in single precision.
fn check(points: &[Vec3]) -> io::Result<()> {
    let way_out = "write text (--ascii) or another format";
    if points.iter().any(|p| !p.is_finite()) {
        return Err(io::Error::other(format!("the model is too large for STL's single precision; {way_out}")));
    }
    // -0 equals 0.
    let mut bits: Vec<[u32; 3]> = points.iter().map(|p| (*p + Vec3::ZERO).to_array().map(f32::to_bits)).collect();
    bits.sort_unstable();
    if bits.windows(2).any(|pair| pair[0] == pair[1]) {
        return Err(io::Error::other(format!("points fall together in STL's single precision; {way_out}")));
    }
    Ok(())
}
