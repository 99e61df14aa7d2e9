//! Reads surfaces from STL files, as text with any number of solids, or binary.
//!
//! Text is ours because no kept crate reads more than its first solid, or numbers in f64; the binary format is 50 bytes
//! a triangle. Vertices come one by one: equal ones (bit for bit, but for the sign of 0) are welded where the surface is
//! checked. The solids are the patches.

use glam::DVec3;

use super::words::{Words, quoted};
use super::{Builder, Soup};

/// Bytes before the first triangle: 80 of comment, 4 of count.
const HEADER: usize = 84;

/// Bytes of a triangle: normal, three corners, 2 of attributes.
const TRIANGLE: usize = 50;

/// The number of triangles that the header of a binary file promises.
fn promised(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?) as usize)
}

/// Whether the length is just that of a binary file with the triangles that its header promises.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    promised(bytes).is_some_and(|n| bytes.len() == HEADER + TRIANGLE * n)
}

/// Whether it begins as text does.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    Words::new(bytes).next().is_some_and(|w| w.eq_ignore_ascii_case(b"solid"))
}

/// Parses the bytes of a binary file.
pub(super) fn parse_binary(bytes: &[u8]) -> Result<Soup, String> {
    let Some(count) = promised(bytes) else {
        return Err(format!("it is too short for an STL file: {} bytes", bytes.len()));
    };
    let triangles = bytes[HEADER..].as_chunks::<TRIANGLE>().0;
    if triangles.len() < count {
        return Err(format!(
            "its header promises {count} triangles, but the file ends within triangle {}",
            triangles.len() + 1
        ));
    }
    let mut builder = Builder::default();
    for triangle in &triangles[..count] {
        let number = |k: usize| {
            let at = 12 + 4 * k;
            f64::from(f32::from_le_bytes([triangle[at], triangle[at + 1], triangle[at + 2], triangle[at + 3]]))
        };
        let corner = |k: usize| DVec3::new(number(3 * k), number(3 * k + 1), number(3 * k + 2));
        builder.triangle([corner(0), corner(1), corner(2)], 0)?;
    }
    Ok(builder.finish(false))
}

/// Parses text: `solid`, then `facet ... outer loop`, `vertex x y z` three times or more, `endloop endfacet`, then
/// `endsolid`.
pub(super) fn parse_text(bytes: &[u8]) -> Result<Soup, String> {
    let mut words = Words::new(bytes);
    let mut builder = Builder::default();
    let mut solids = 0u32;
    let mut corners: Option<Vec<usize>> = None;
    let is = |word: &[u8], keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
    while let Some(word) = words.next() {
        let line = words.line();
        let misplaced = || format!("line {line}: {} is out of place", quoted(word));
        if is(word, "vertex") {
            let point = words.point("a vertex")?;
            let v = builder.point(point)?;
            corners.as_mut().ok_or_else(misplaced)?.push(v);
        } else if is(word, "outer") {
            // "outer loop"
            words.next();
            if corners.replace(vec![]).is_some() {
                return Err(misplaced());
            }
        } else if is(word, "endloop") {
            let corners = corners.take().ok_or_else(misplaced)?;
            builder.face(&corners, solids.saturating_sub(1)).map_err(|e| format!("line {line}: {e}"))?;
        } else if is(word, "solid") {
            if corners.is_some() {
                return Err(misplaced());
            }
            words.rest_of_line();
            solids += 1;
        } else if is(word, "endsolid") {
            words.rest_of_line();
        } else if is(word, "facet") {
            // Its normal, a word and three numbers, follows from the corners.
            if words.peek().is_some_and(|w| is(w, "normal")) {
                (0..4).for_each(|_| _ = words.next());
            }
        } else if !is(word, "endfacet") {
            return Err(format!("line {line}: {} is no statement of an STL file", quoted(word)));
        }
    }
    match corners {
        None => Ok(builder.finish(solids > 1)),
        Some(_) => Err(format!("line {}: the file ends within a facet", words.line())),
    }
}
