//! Wavefront OBJ: a group `patch_p` for each patch.

use std::io::{self, Write};

use super::{Decimals, SurfaceData};

pub(super) fn write(data: &SurfaceData, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "# tetcvt {}", env!("CARGO_PKG_VERSION"))?;
    for &p in &data.points {
        writeln!(out, "v {}", Decimals(p, " "))?;
    }
    let mut order: Vec<usize> = (0..data.triangles.len()).collect();
    order.sort_by_key(|&f| data.boundary[f].patch);
    for group in order.chunk_by(|&f, &g| data.boundary[f].patch == data.boundary[g].patch) {
        writeln!(out, "g patch_{}", data.boundary[group[0]].patch)?;
        for [a, b, c] in group.iter().map(|&f| data.triangles[f].map(|v| v + 1)) {
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    Ok(())
}
