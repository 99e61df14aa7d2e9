//! The trajectory of the seeds as a NumPy array, written while the run goes.
//!
//! Format: NumPy's `.npy` version 1.0: a magic string, the length of a header, a header that is a Python dictionary,
//! and the numbers. The header is as long for any shape, so that the count of frames can be put in at the end.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

use glam::DVec3;

use super::atomic::{AtomicFile, failure};
use crate::error::Error;

/// Bytes before the first number; a multiple of 64, as NumPy aligns it.
const HEADER: usize = 128;

/// Writes float64 of shape (frames, seeds, 3) in C order.
pub struct TrajectoryWriter {
    file: AtomicFile,
    seeds: usize,
    frames: usize,
    bytes: Vec<u8>,
}

impl TrajectoryWriter {
    /// Begins the file `path`, which takes its name only in [`finish`](Self::finish).
    pub fn create(path: &Path) -> Result<TrajectoryWriter, Error> {
        let mut writer = TrajectoryWriter { file: AtomicFile::create(path)?, seeds: 0, frames: 0, bytes: Vec::new() };
        // Its length is final, its shape is not.
        writer.file.write_all(&header(0, 0)).map_err(|e| writer.failure(e))?;
        Ok(writer)
    }

    /// Adds a frame, as long as every other.
    pub fn push(&mut self, positions: impl ExactSizeIterator<Item = DVec3>) -> Result<(), Error> {
        if self.frames == 0 {
            self.seeds = positions.len();
        } else if self.seeds != positions.len() {
            let reason = format!("a frame of {} seeds after one of {}", positions.len(), self.seeds);
            return Err(self.failure(io::Error::other(reason)));
        }
        self.bytes.clear();
        for p in positions {
            for x in p.to_array() {
                self.bytes.extend_from_slice(&x.to_le_bytes());
            }
        }
        self.file.write_all(&self.bytes).map_err(|e| self.failure(e))?;
        self.frames += 1;
        Ok(())
    }

    /// Completes the file.
    pub fn finish(mut self) -> Result<(), Error> {
        let header = header(self.frames, self.seeds);
        let patched = self.file.seek(SeekFrom::Start(0)).and_then(|_| self.file.write_all(&header));
        patched.map_err(|e| self.failure(e))?;
        self.file.commit()
    }

    fn failure(&self, error: io::Error) -> Error {
        failure(self.file.path(), &error)
    }
}

fn header(frames: usize, seeds: usize) -> [u8; HEADER] {
    let mut bytes = [b' '; HEADER];
    bytes[..8].copy_from_slice(b"\x93NUMPY\x01\x00");
    bytes[8..10].copy_from_slice(&((HEADER - 10) as u16).to_le_bytes());
    let shape = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({frames}, {seeds}, 3), }}");
    // 61 characters and two numbers of at most 20 digits.
    bytes[10..10 + shape.len()].copy_from_slice(shape.as_bytes());
    bytes[HEADER - 1] = b'\n';
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_has_room_for_any_shape() {
        assert_eq!(header(0, 0).len(), header(usize::MAX, usize::MAX).len());
    }

    #[test]
    fn frames_follow_the_header_and_the_shape_counts_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.npy");
        let mut writer = TrajectoryWriter::create(&path).unwrap();
        for k in 0..3 {
            writer.push((0..2).map(|i| DVec3::new(k as f64, i as f64, -0.5))).unwrap();
        }
        assert!(writer.push([DVec3::ZERO].into_iter()).is_err());
        assert!(!path.exists());
        writer.finish().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&bytes[10..HEADER]);
        assert_eq!(text.trim_end(), "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2, 3), }");
        let numbers: Vec<f64> =
            bytes[HEADER..].chunks_exact(8).map(|c| f64::from_le_bytes(c.try_into().unwrap())).collect();
        assert_eq!(numbers.len(), 18);
        assert_eq!(numbers[15..], [2.0, 1.0, -0.5]);
    }
}
