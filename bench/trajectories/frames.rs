//! Reads a recorded trajectory, frame by frame: what `tetcvt::io::npy` writes.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::Outcome;

/// Start of a file of NumPy's version 1.0.
const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// A trajectory in a file.
pub struct Frames {
    path: PathBuf,
    file: File,
    /// Where the numbers begin.
    pub offset: u64,
    /// Frames: the start and one after each iteration.
    pub count: usize,
    /// Seeds in each.
    pub seeds: usize,
    bytes: Vec<u8>,
}

impl Frames {
    /// Opens float64 of shape (frames, seeds, 3) in C order.
    pub fn open(path: &Path) -> Outcome<Frames> {
        let wrong = |what: &str| format!("{}: {what}", path.display());
        let mut file = File::open(path).map_err(|e| wrong(&e.to_string()))?;
        let mut start = [0; 10];
        file.read_exact(&mut start)?;
        if &start[..8] != MAGIC {
            return Err(wrong("no .npy file of version 1.0").into());
        }
        let mut header = vec![0; usize::from(u16::from_le_bytes([start[8], start[9]]))];
        file.read_exact(&mut header)?;
        let header = String::from_utf8_lossy(&header);
        if !header.contains("'descr': '<f8'") || !header.contains("'fortran_order': False") {
            return Err(wrong("not float64 in C order").into());
        }
        let shape = header.split("'shape': (").nth(1).and_then(|rest| rest.split(')').next()).unwrap_or_default();
        let shape: Vec<usize> = shape.split(',').filter_map(|word| word.trim().parse().ok()).collect();
        let [count, seeds, 3] = shape[..] else {
            return Err(wrong("not of shape (frames, seeds, 3)").into());
        };
        let offset = (start.len() + header.len()) as u64;
        Ok(Frames { path: path.to_owned(), file, offset, count, seeds, bytes: Vec::new() })
    }

    /// Positions of all seeds in frame `k`.
    pub fn read(&mut self, k: usize, positions: &mut Vec<DVec3>) -> Outcome<()> {
        self.bytes.resize(24 * self.seeds, 0);
        self.file.seek(SeekFrom::Start(self.offset + (k * self.bytes.len()) as u64))?;
        self.file.read_exact(&mut self.bytes).map_err(|e| format!("{}: frame {k}: {e}", self.path.display()))?;
        let number = |at: &[u8]| f64::from_le_bytes(at.try_into().expect("eight bytes"));
        positions.clear();
        positions.extend(
            self.bytes.chunks_exact(24).map(|p| DVec3::new(number(&p[..8]), number(&p[8..16]), number(&p[16..]))),
        );
        Ok(())
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}
