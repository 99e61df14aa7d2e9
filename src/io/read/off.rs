//! Reads surfaces from OFF files, the format of Geomview: `OFF`, also with colours (`COFF`), normals (`NOFF`) and
//! texture coordinates (`STOFF`) at the vertices, as text.
//!
//! ```text
//! OFF
//! vertices faces edges
//! x y z                  for each vertex; normals, colours and texture coordinates follow on the line
//! n v0 v1 ... [colour]   for each face; the colour is the rest of the line
//! ```
//!
//! No crate reads it with places for its errors.

use super::words::{Words, count, quoted};
use super::{Builder, Soup};

/// Parses the text of an OFF file. The keyword may be missing, as the format allows.
pub(super) fn parse(bytes: &[u8]) -> Result<Soup, String> {
    let mut words = Words::without_comments(bytes, b'#');
    if let Some(keyword) = words.peek().filter(|w| keyword(w).is_some()) {
        words.next();
        if keyword.contains(&b'4') || keyword.contains(&b'n') {
            return Err("its vertices are not three-dimensional (4OFF, nOFF): export it as OFF".into());
        }
    }
    if words.peek().is_some_and(|w| w.eq_ignore_ascii_case(b"BINARY")) {
        return Err("it is a binary OFF file: export it as text".into());
    }
    let vertices = words.count("the number of vertices")?;
    let faces = words.count("the number of faces")?;
    // Edges are not used, and some writers leave their number out.
    words.rest_of_line();
    // A vertex takes 6 bytes at least, a face 2.
    if vertices > words.remaining() / 5 + 1 || faces > words.remaining() {
        return Err(format!("it cannot hold the {vertices} vertices and {faces} faces that its header promises"));
    }

    let mut builder = Builder::default();
    for v in 0..vertices {
        let point = words.point("a vertex").map_err(|e| format!("{e} (vertex {} of {vertices})", v + 1))?;
        builder.point(point)?;
        words.rest_of_line();
    }
    let mut corners = vec![];
    for _ in 0..faces {
        let arity = words.count("a face")?;
        let line = words.line();
        corners.clear();
        for _ in 0..arity {
            let Some(word) = words.next_on_line() else {
                return Err(format!("line {line}: a face of {arity} corners has only {}", corners.len()));
            };
            let Some(v) = count(word) else {
                return Err(format!("line {line}: a face needs whole numbers as indices, not {}", quoted(word)));
            };
            corners.push(v);
        }
        builder.face(&corners, 0).map_err(|e| format!("line {line}: {e}"))?;
        words.rest_of_line();
    }
    Ok(builder.finish(false))
}

/// What a word says of the format, if it is its keyword: the letters before `OFF`.
pub(super) fn keyword(word: &[u8]) -> Option<&[u8]> {
    let prefix = word.strip_suffix(b"OFF")?;
    [b"".as_slice(), b"C", b"N", b"CN", b"ST", b"STC", b"STN", b"STCN", b"4", b"n", b"C4", b"4n"]
        .contains(&prefix)
        .then_some(prefix)
}
