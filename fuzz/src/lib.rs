//! What all fuzz targets do with a file: read it, and bear what was read.

use std::path::Path;

use tetcvt::io::read::{parse, parse_initial, parse_lines};

/// Reads `head` and then `bytes` as the surface file `name`; what is read must have no index out of range, and the checks
/// must end.
pub fn surface(name: &str, head: &[u8], bytes: &[u8]) {
    let Ok(soup) = parse(&[head, bytes].concat(), Path::new(name)) else { return };
    let points = soup.points().len() as u32;
    assert!(soup.triangles().as_flattened().iter().all(|&v| v < points));
    assert!(soup.source().len() == soup.triangles().len() && soup.patch().len() == soup.triangles().len());
    let _ = soup.check();
}

/// Reads `bytes` as a mesh to start from; all points are finite, and all or none have kinds.
pub fn initial(bytes: &[u8]) {
    let Ok(initial) = parse_initial(bytes, Path::new("mesh.vtu")) else { return };
    assert!(initial.points.iter().all(|p| p.is_finite()));
    assert!(initial.kinds.is_empty() || initial.kinds.len() == initial.points.len());
}

/// Reads `bytes` as the lines of an OBJ file.
pub fn lines(bytes: &[u8]) {
    if let Ok(lines) = parse_lines(bytes) {
        assert!(!lines.is_empty());
    }
}
