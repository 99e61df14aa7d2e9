//! Reads the lines of Wavefront OBJ files: `l` statements over the positions of `v` statements; faces do not matter.

use std::path::Path;

use glam::DVec3;

use super::bytes_of;
use crate::error::Error;
use crate::surface::imprint::Polyline;

/// Reads the lines of an OBJ file, in its order; each is numbered by the line of the file that it stands on.
///
/// # Errors
/// [`Error::Read`] where the file cannot be read or parsed, or has no lines.
pub fn read_lines(path: &Path) -> Result<Vec<Polyline>, Error> {
    parse_lines(&bytes_of(path)?).map_err(|reason| Error::Read { path: path.to_owned(), reason })
}

/// The lines in the text of an OBJ file.
///
/// # Errors
/// The reason, with the line.
pub fn parse_lines(text: &[u8]) -> Result<Vec<Polyline>, String> {
    let text = std::str::from_utf8(text).map_err(|_| "it is not a text file".to_owned())?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut points: Vec<DVec3> = Vec::new();
    // Indices may be of vertices further down.
    let mut chains: Vec<(usize, Vec<i64>, usize)> = Vec::new();
    let mut numbered = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    while let Some((number, line)) = numbered.next() {
        let mut statement = without_comment(line).to_owned();
        while let Some(begun) = statement.strip_suffix('\\') {
            let more = numbered.next().map_or("", |(_, line)| without_comment(line));
            statement = format!("{begun} {more}");
        }
        let mut words = statement.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let coordinates: Option<Vec<f64>> = words.take(3).map(|w| w.parse().ok()).collect();
                match coordinates.as_deref() {
                    Some(&[x, y, z]) => points.push(DVec3::new(x, y, z)),
                    _ => return Err(format!("line {number}: a vertex needs three numbers")),
                }
            }
            Some("l") => {
                let index = |w: &str| w.split('/').next().and_then(|w| w.parse().ok());
                let indices: Option<Vec<i64>> = words.map(index).collect();
                match indices {
                    Some(indices) if indices.len() >= 2 => chains.push((number, indices, points.len())),
                    Some(_) => return Err(format!("line {number}: a line needs two vertices")),
                    None => return Err(format!("line {number}: a line needs whole numbers as indices")),
                }
            }
            _ => {}
        }
    }
    if chains.is_empty() {
        return Err("it has no lines: no statement begins with 'l'".into());
    }
    chains.into_iter().map(|(line, indices, before)| resolve(&points, line, &indices, before)).collect()
}

fn without_comment(line: &str) -> &str {
    line.split('#').next().unwrap_or(line).trim_end()
}

/// The line over these indices: from 1 on, or back from the last of the vertices `before` it.
fn resolve(points: &[DVec3], line: usize, indices: &[i64], before: usize) -> Result<Polyline, String> {
    let point = |&index: &i64| {
        let at = if index < 0 { before as i64 + index } else { index - 1 };
        let found = usize::try_from(at).ok().and_then(|at| points.get(at));
        found.copied().ok_or_else(|| format!("line {line}: there is no vertex {index} among {}", points.len()))
    };
    Ok(Polyline { points: indices.iter().map(point).collect::<Result<_, _>>()?, line })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_whatever_stands_between_them() {
        let text = b"o a\nv 0 0 0 # origin\nl 1 2/7 \\\n 3\nv 1 0 0 1.0\nv 1 1 0\nf 1 2 3\nl -1 -3\n";
        let lines = parse_lines(text).expect("two lines");
        assert_eq!(lines.len(), 2);
        assert_eq!((lines[0].line, lines[1].line), (3, 8));
        assert_eq!(lines[0].points, [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0)]);
        assert_eq!(lines[1].points, [DVec3::new(1.0, 1.0, 0.0), DVec3::ZERO]);
    }

    #[test]
    fn what_is_no_line_is_refused_with_its_place() {
        let refused = |text: &str, what: &str| {
            let reason = parse_lines(text.as_bytes()).expect_err("no lines");
            assert!(reason.contains(what), "{reason}");
        };
        refused("v 0 0 0\nf 1 1 1\n", "no lines");
        refused("v 0 0 0\nv 1 0 0\nl 1\n", "line 3: a line needs two");
        refused("v 0 0 0\nl 1 2\n", "line 2: there is no vertex 2 among 1");
        refused("v 0 0 0\nl 1 0\n", "no vertex 0");
        refused("v 0 0\n", "line 1: a vertex needs three");
        refused("l 1 a\n", "line 1: a line needs whole");
    }
}
