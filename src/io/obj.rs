//! Reads surfaces from Wavefront OBJ files.
//!
//! The numbers and faces are parsed by `tobj`. A filter in front of it hands over the statements that make a surface
//! and nothing else: comments, continued lines, texture coordinates, normals, lines and points are gone, faces name
//! positions only. Groups stay behind as well, so that the faces come as one model in the order of the file; which
//! group (`o`, `g`, `usemtl`) a face is in becomes its patch.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use glam::DVec3;

use super::polygon;
use crate::error::Error;
use crate::surface::defects::Defect;
use crate::surface::{Surface, note_count};

/// Reads and checks the surface in an OBJ file.
///
/// # Errors
/// [`Error::Read`] where the file cannot be read or parsed, [`Error::Surface`] where it bounds no solid.
pub fn read(path: &Path) -> Result<Surface, Error> {
    Ok(load(path)?.check()?)
}

/// Reads an OBJ file, without checking what it holds.
///
/// # Errors
/// [`Error::Read`], with the line.
pub fn load(path: &Path) -> Result<Soup, Error> {
    let fail = |reason: String| Error::Read { path: path.to_owned(), reason };
    let file = File::open(path).map_err(|e| fail(e.to_string()))?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err(fail("it is a folder".into()));
    }
    parse(BufReader::with_capacity(1 << 16, file)).map_err(fail)
}

/// What an OBJ file holds, before any check.
pub struct Soup {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    source: Vec<u32>,
    patch: Vec<u32>,
    notes: Vec<String>,
}

impl Soup {
    /// Checks it and makes it a surface.
    pub fn check(self) -> Result<Surface, Defect> {
        let surface = Surface::new(&self.points, &self.triangles, &self.source, &self.patch)?;
        Ok(surface.with_notes(self.notes))
    }
}

/// Parses the text of an OBJ file.
fn parse(text: impl Read) -> Result<Soup, String> {
    let log = RefCell::new(Log::default());
    let mut statements =
        Statements { text: BufReader::new(text), line: vec![], at: 0, groups: Groups::default(), log: &log };
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
    Ok(assemble(&models, &log))
}

/// Makes triangles of the faces.
fn assemble(models: &[tobj::Model], log: &Log) -> Soup {
    let mut soup = Soup { points: vec![], triangles: vec![], source: vec![], patch: vec![], notes: vec![] };
    let (mut short, mut folded) = (0, 0);
    let mut face = 0;
    for model in models {
        let mesh = &model.mesh;
        let base = soup.points.len() as u32;
        soup.points.extend(mesh.positions.chunks_exact(3).map(DVec3::from_slice));
        // tobj leaves the arities out where all faces are triangles.
        let triangles = vec![3; if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 }];
        let mut begin = 0;
        for &arity in mesh.face_arities.iter().chain(&triangles) {
            let ids = &mesh.indices[begin..begin + arity as usize];
            begin += arity as usize;
            if ids.len() < 3 {
                short += 1;
            } else {
                let corners: Vec<DVec3> = ids.iter().map(|&v| soup.points[(base + v) as usize]).collect();
                let cut = polygon::cut(&corners);
                folded += usize::from(!cut.proper);
                for triangle in cut.triangles {
                    soup.triangles.push(triangle.map(|i| base + ids[i]));
                    soup.source.push(face);
                    soup.patch.push(log.patch[face as usize]);
                }
            }
            face += 1;
        }
    }
    let notes = &mut soup.notes;
    let unused = log.vertices - soup.points.len();
    note_count(notes, unused, "vertex that no face uses was dropped", "vertices that no face uses were dropped");
    note_count(
        notes,
        short,
        "face with fewer than three corners was left out",
        "faces with fewer than three corners were left out",
    );
    note_count(
        notes,
        folded,
        "polygon could not be cut without folding (it crosses itself or has no area) and was fanned",
        "polygons could not be cut without folding (they cross themselves or have no area) and were fanned",
    );
    soup
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
    known: std::collections::BTreeMap<[Vec<u8>; 3], u32>,
}

/// The statements of an OBJ file that make a surface, as text again; one statement at a time.
struct Statements<'a, R> {
    text: BufReader<R>,
    /// The statement that is being read, and how far.
    line: Vec<u8>,
    at: usize,
    groups: Groups,
    log: &'a RefCell<Log>,
}

impl<R: Read> Statements<'_, R> {
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
                    let next = groups.known.len() as u32;
                    log.patch.push(*groups.known.entry(groups.current.clone()).or_insert(next));
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

impl<R: Read> Read for Statements<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let available = self.fill_buf()?;
        let count = available.len().min(buffer.len());
        buffer[..count].copy_from_slice(&available[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl<R: Read> BufRead for Statements<'_, R> {
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
