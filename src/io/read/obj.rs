//! Reads surfaces from Wavefront OBJ files.
//!
//! The numbers and faces are parsed by `tobj`. A filter in front of it hands over the statements that make a surface
//! and nothing else: comments, continued lines, texture coordinates, normals, lines and points are gone, faces name
//! positions only. Groups stay behind as well, so that the faces come as one model in the order of the file; which
//! group (`o`, `g`, `usemtl`) a face is in becomes its patch.

use std::cell::RefCell;
use std::io::{self, BufRead, Read};

use glam::DVec3;

use super::words::Words;
use super::{Builder, Names, Soup};
use crate::surface::note_count;

/// Parses the text of an OBJ file.
pub(super) fn parse(text: &[u8]) -> Result<Soup, String> {
    let log = RefCell::new(Log::default());
    let mut statements = Statements { text, line: vec![], at: 0, groups: Groups::default(), log: &log };
    let options = tobj::LoadOptions { triangulate: false, single_index: true, ..Default::default() };
    let loaded = tobj::load_obj_buf(&mut statements, &options, |_| Err(tobj::LoadError::OpenFileFailed));
    let log = log.into_inner();
    let models = match loaded {
        Ok((models, _)) => models,
        Err(error) => return Err(log.explain(error)),
    };
    if let Some(reason) = log.failure {
        return Err(reason);
    }
    if log.lines > 0 && log.statements == 0 && log.other > 0 {
        return Err("it is not an OBJ file: no line begins with an OBJ statement".into());
    }
    assemble(&models, &log)
}

/// Makes triangles of the faces.
fn assemble(models: &[tobj::Model], log: &Log) -> Result<Soup, String> {
    let mut builder = Builder::default();
    let mut face = 0;
    for model in models {
        let mesh = &model.mesh;
        let mut base = None;
        for position in mesh.positions.chunks_exact(3) {
            let first = builder.point(DVec3::from_slice(position))?;
            base.get_or_insert(first);
        }
        // tobj leaves the arities out where all faces are triangles.
        let triangles = vec![3; if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 }];
        let mut begin = 0;
        for &arity in mesh.face_arities.iter().chain(&triangles) {
            let ids = &mesh.indices[begin..begin + arity as usize];
            begin += arity as usize;
            let corners: Vec<usize> = ids.iter().map(|&v| base.unwrap_or(0) + v as usize).collect();
            builder.face(&corners, log.patch[face])?;
            face += 1;
        }
    }
    let unused = log.vertices - builder.soup.points.len();
    let notes = &mut builder.soup.notes;
    note_count(notes, unused, "vertex that no face uses was dropped", "vertices that no face uses were dropped");
    Ok(builder.finish(true))
}

/// Whether the text's first statement is one of an OBJ file.
pub(super) fn is_likely(text: &[u8]) -> bool {
    let first = Words::without_comments(text, b'#').next();
    first.is_some_and(|w| is_statement(w) && ![b"deg".as_slice(), b"lod", b"usemap", b"p", b"l"].contains(&w))
}

/// What the filter saw.
#[derive(Default)]
struct Log {
    /// Lines read so far: the number of the one that `tobj` has just been given.
    lines: usize,
    /// Lines that begin with an OBJ statement, and with something else.
    statements: usize,
    other: usize,
    vertices: usize,
    /// For each face, its patch.
    patch: Vec<u32>,
    /// The first index that can never be right, and the greatest one: (index, line, vertices before it).
    impossible: Option<(i64, usize, usize)>,
    greatest: (i64, usize),
    /// Why the filter gave up.
    failure: Option<String>,
}

impl Log {
    /// The cause of a parse error, with its line.
    fn explain(self, error: tobj::LoadError) -> String {
        use tobj::LoadError::*;
        if let Some(failure) = self.failure {
            return failure;
        }
        let line = self.lines;
        match error {
            FaceVertexOutOfBounds => match self.impossible {
                Some((0, line, _)) => format!("line {line}: a face refers to vertex 0, but the first is 1"),
                Some((index, line, before)) => {
                    format!("line {line}: a face refers to vertex {index}, but only {before} come before it")
                }
                None => {
                    let (index, line) = self.greatest;
                    format!("line {line}: a face refers to vertex {index}, but there are only {}", self.vertices)
                }
            },
            PositionParseError => format!("line {line}: a vertex needs three numbers"),
            FaceParseError => format!("line {line}: a face needs whole numbers that fit the machine as indices"),
            ReadError => format!("line {line} is not text"),
            other => format!("line {line}: {other}"),
        }
    }

    /// Remembers an index that a face uses.
    fn index(&mut self, text: &[u8]) {
        let Some(index) = std::str::from_utf8(text).ok().and_then(|t| t.parse::<i64>().ok()) else { return };
        if index == 0 || index < -(self.vertices as i64) {
            self.impossible.get_or_insert((index, self.lines, self.vertices));
        }
        if index > self.greatest.0 {
            self.greatest = (index, self.lines);
        }
    }
}

/// The groups that the next face is in.
#[derive(Default)]
struct Groups {
    /// Object, group and material.
    current: [Vec<u8>; 3],
    /// Those seen with a face, numbered in that order.
    known: Names<[Vec<u8>; 3]>,
}

/// The statements of an OBJ file that make a surface, as text again; one statement at a time.
struct Statements<'a> {
    text: &'a [u8],
    /// The statement that is being read, and how far.
    line: Vec<u8>,
    at: usize,
    groups: Groups,
    log: &'a RefCell<Log>,
}

impl Statements<'_> {
    /// Reads the next line with what continues it; `None` at the end.
    fn logical_line(&mut self, log: &mut Log) -> io::Result<Option<Vec<u8>>> {
        let mut line = vec![];
        loop {
            let begin = line.len();
            if self.text.read_until(b'\n', &mut line)? == 0 {
                return Ok((!line.is_empty()).then_some(line));
            }
            log.lines += 1;
            if line[begin..].contains(&0) {
                let reason = format!("line {} holds a zero byte: it is not a text file", log.lines);
                log.failure = Some(reason.clone());
                return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
            }
            line.truncate(line.trim_ascii_end().len());
            // A comment is not continued.
            let continued = line.ends_with(b"\\") && !line.trim_ascii_start().starts_with(b"#");
            if !continued {
                if line.is_empty() {
                    line.push(b' ');
                }
                return Ok(Some(line));
            }
            line.pop();
            line.push(b' ');
        }
    }

    /// Puts the next statement that matters into `line`; leaves it empty at the end.
    fn advance(&mut self) -> io::Result<()> {
        let log = self.log;
        let mut log = log.borrow_mut();
        self.line.clear();
        self.at = 0;
        while self.line.is_empty() {
            let raw = match self.logical_line(&mut log) {
                Ok(Some(raw)) => raw,
                Ok(None) => return Ok(()),
                Err(error) => {
                    let line = log.lines + 1;
                    log.failure.get_or_insert_with(|| format!("line {line}: {error}"));
                    return Err(error);
                }
            };
            let first = log.statements + log.other == 0;
            let raw = if first { raw.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&raw) } else { &raw };
            let mut words = raw.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).peekable();
            let Some(&keyword) = words.peek() else { continue };
            match keyword {
                b"v" => {
                    log.vertices += 1;
                    // Weights and colours after the position mean nothing to a polygon.
                    words.take_while(|w| !w.starts_with(b"#")).take(4).for_each(|w| push_word(&mut self.line, w));
                }
                b"f" => {
                    push_word(&mut self.line, keyword);
                    for word in words.skip(1).take_while(|w| !w.starts_with(b"#")) {
                        let index = word.split(|&b| b == b'/' || b == b'#').next().unwrap_or(word);
                        log.index(index);
                        push_word(&mut self.line, index);
                    }
                    let groups = &mut self.groups;
                    log.patch.push(groups.known.number(groups.current.clone()));
                }
                b"o" | b"g" | b"usemtl" => {
                    let slot = [b"o".as_slice(), b"g", b"usemtl"].iter().position(|&k| k == keyword).unwrap_or(0);
                    self.groups.current[slot] = words.skip(1).collect::<Vec<_>>().join(&b' ');
                }
                _ => {}
            }
            if is_statement(keyword) {
                log.statements += 1;
            } else if !keyword.starts_with(b"#") {
                log.other += 1;
            }
        }
        self.line.push(b'\n');
        Ok(())
    }
}

fn push_word(line: &mut Vec<u8>, word: &[u8]) {
    if !line.is_empty() {
        line.push(b' ');
    }
    line.extend_from_slice(word);
}

/// Whether a line that begins so is one of an OBJ file.
fn is_statement(keyword: &[u8]) -> bool {
    const KNOWN: [&[u8]; 15] = [
        b"v", b"vt", b"vn", b"vp", b"f", b"l", b"p", b"o", b"g", b"s", b"usemtl", b"mtllib", b"usemap", b"deg", b"lod",
    ];
    KNOWN.contains(&keyword)
}

impl Read for Statements<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let available = self.fill_buf()?;
        let count = available.len().min(buffer.len());
        buffer[..count].copy_from_slice(&available[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Statements<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at == self.line.len() {
            self.advance()?;
        }
        Ok(&self.line[self.at..])
    }

    fn consume(&mut self, count: usize) {
        self.at += count;
    }
}
