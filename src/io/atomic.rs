//! Files that appear whole or not at all.
//!
//! An [`AtomicFile`] is written under another name in the same folder and takes its own name only when it is complete;
//! until then, and on any error, whatever had that name before is untouched. Symbolic links are followed, as a plain
//! create would; permissions are those that a plain create would give. Devices and pipes cannot be replaced and are
//! written straight.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};

use crate::error::Error;

/// Files being written, for [`discard_unfinished`]: a process that is told to end at once runs no destructors.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes every file not yet complete. None can be begun or completed while the guard lives: hold it until the
/// process ends.
pub fn discard_unfinished() -> impl Sized {
    let files = unfinished();
    for path in files.iter() {
        // Nothing more can be done about a file that cannot be removed.
        let _ = fs::remove_file(path);
    }
    files
}

/// A file on its way.
pub struct AtomicFile {
    path: PathBuf,
    sink: Sink,
}

enum Sink {
    Replace { temporary: Temporary, target: PathBuf },
    Straight(BufWriter<File>),
}

impl AtomicFile {
    /// Begins the file `path`.
    pub fn create(path: &Path) -> Result<AtomicFile, Error> {
        let sink = Sink::open(path).map_err(|e| failure(path, &e))?;
        Ok(AtomicFile { path: path.to_owned(), sink })
    }

    /// Begins the file `path` and writes all of it by `write`.
    pub fn fill(path: &Path, write: impl FnOnce(&mut AtomicFile) -> io::Result<()>) -> Result<AtomicFile, Error> {
        let mut file = AtomicFile::create(path)?;
        write(&mut file).map_err(|e| failure(path, &e))?;
        Ok(file)
    }

    /// Writes the file `path` by `write`, whole or not at all.
    pub fn write_with(path: &Path, write: impl FnOnce(&mut AtomicFile) -> io::Result<()>) -> Result<(), Error> {
        AtomicFile::fill(path, write)?.commit()
    }

    /// The name that the file will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the complete file its name.
    pub fn commit(self) -> Result<(), Error> {
        commit_all(vec![self])
    }

    /// Writes what is left in the buffer; on the disk before it takes the name: a full disk may show only here.
    fn complete(&mut self) -> Result<(), Error> {
        let done = match &mut self.sink {
            Sink::Straight(writer) => writer.flush(),
            Sink::Replace { temporary, .. } => temporary.complete(),
        };
        done.map_err(|e| failure(&self.path, &e))
    }
}

/// Gives complete files their names, all of them or none: where one cannot have its name, those before it get back what
/// they had.
pub fn commit_all(mut files: Vec<AtomicFile>) -> Result<(), Error> {
    files.iter_mut().try_for_each(AtomicFile::complete)?;
    // Held to the end: nobody is to end the process between two names.
    let mut unfinished = unfinished();
    let mut replaced: Vec<Replaced> = Vec::new();
    let last = files.len().saturating_sub(1);
    for (i, file) in files.into_iter().enumerate() {
        let Sink::Replace { temporary, target } = file.sink else { continue };
        let old = if i < last { Replaced::remember(&target) } else { Ok(Replaced::nothing(&target)) };
        // Dropped only after the guard, which its removal waits for.
        let mut abandoned = None;
        let renamed = match old {
            Ok(old) => temporary.persist(&target, &mut unfinished).map(|()| old),
            Err(error) => {
                abandoned = Some(temporary);
                Err(error)
            }
        };
        match renamed {
            Ok(old) => replaced.push(old),
            Err(error) => {
                replaced.into_iter().for_each(Replaced::restore);
                drop(unfinished);
                drop(abandoned);
                return Err(failure(&file.path, &error));
            }
        }
    }
    Ok(())
}

/// What had a name before a file took it.
struct Replaced {
    target: PathBuf,
    old: Option<TempPath>,
}

impl Replaced {
    fn nothing(target: &Path) -> Replaced {
        Replaced { target: target.to_owned(), old: None }
    }

    /// Keeps what `target` leads to under another name too.
    fn remember(target: &Path) -> io::Result<Replaced> {
        if existing(target)?.is_none() {
            return Ok(Replaced::nothing(target));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".tetcvt-").suffix(".old");
        // Not every file system has links.
        let link = |name: &Path| fs::hard_link(target, name).or_else(|_| fs::copy(target, name).map(drop));
        let old = builder.make_in(folder(target), link)?.into_temp_path();
        Ok(Replaced { target: target.to_owned(), old: Some(old) })
    }

    /// Gives the name back; nothing more can be done where that fails.
    fn restore(self) {
        let _ = match self.old {
            Some(old) => old.persist(&self.target).map_err(|e| e.error),
            None => fs::remove_file(&self.target),
        };
    }
}

impl Sink {
    fn open(path: &Path) -> io::Result<Sink> {
        let existing = existing(path)?;
        if existing.as_ref().is_some_and(|m| !m.is_file()) {
            return Ok(Sink::Straight(BufWriter::new(OpenOptions::new().write(true).open(path)?)));
        }
        let target = followed(path)?;
        let temporary = Temporary::beside(&target)?;
        if let (Some(metadata), Some(writer)) = (existing, &temporary.writer) {
            // A file system without permissions refuses this, and then has none to keep.
            let _ = writer.get_ref().as_file().set_permissions(metadata.permissions());
        }
        Ok(Sink::Replace { temporary, target })
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            Sink::Replace { temporary, .. } => temporary.writer().write(bytes),
            Sink::Straight(writer) => writer.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Replace { temporary, .. } => temporary.writer().flush(),
            Sink::Straight(writer) => writer.flush(),
        }
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        match &mut self.sink {
            Sink::Replace { temporary, .. } => temporary.writer().seek(position),
            Sink::Straight(writer) => writer.seek(position),
        }
    }
}

/// A file under a temporary name, known to [`UNFINISHED`]; removed when dropped.
struct Temporary {
    /// `None` only once it is persisted or dropped.
    writer: Option<BufWriter<NamedTempFile>>,
}

impl Temporary {
    fn beside(target: &Path) -> io::Result<Temporary> {
        let mut files = unfinished();
        let mut builder = tempfile::Builder::new();
        builder.prefix(".tetcvt-").suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Less the user's mask, as a plain create.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder(target))?;
        files.insert(file.path().to_owned());
        Ok(Temporary { writer: Some(BufWriter::with_capacity(1 << 16, file)) })
    }

    fn writer(&mut self) -> &mut BufWriter<NamedTempFile> {
        self.writer.as_mut().expect("a temporary file is open until it is persisted: this is a bug in tetcvt")
    }

    /// Puts all that was written on the disk.
    fn complete(&mut self) -> io::Result<()> {
        self.writer().flush()?;
        self.writer().get_ref().as_file().sync_all()
    }

    /// Gives the complete file its name.
    fn persist(mut self, target: &Path, unfinished: &mut BTreeSet<PathBuf>) -> io::Result<()> {
        let writer = self.writer.take().expect("a temporary file is persisted once: this is a bug in tetcvt");
        let (file, _) = writer.into_parts();
        unfinished.remove(file.path());
        // On failure the file comes back and is removed.
        file.persist(target).map_err(|e| e.error)?;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(writer) = self.writer.take() {
            let mut files = unfinished();
            // Unflushed bytes of a file that is given up need no writing.
            let (file, _) = writer.into_parts();
            files.remove(file.path());
        }
    }
}

/// What the operating system said, without the temporary name that `tempfile` adds: it means nothing to the user.
fn reason(error: &io::Error) -> String {
    let said = error.get_ref().and_then(|inner| inner.source());
    said.map_or_else(|| error.to_string(), |source| source.to_string())
}

pub(super) fn failure(path: &Path, error: &io::Error) -> Error {
    Error::Write { path: path.to_owned(), reason: reason(error) }
}

/// The metadata of what `path` leads to, if anything.
fn existing(path: &Path) -> io::Result<Option<fs::Metadata>> {
    match fs::metadata(path) {
        Ok(metadata) => Ok(Some(metadata)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e),
    }
}

/// The folder of a file's path.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// The file that a plain create of `path` would write: symbolic links followed, dangling ones too.
fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    // As many links as Linux follows.
    for _ in 0..40 {
        match fs::symlink_metadata(&path) {
            Ok(metadata) if metadata.is_symlink() => path = folder(&path).join(fs::read_link(&path)?),
            _ => {
                let name = path.file_name().ok_or_else(|| io::Error::other("it is not the name of a file"))?;
                return Ok(fs::canonicalize(folder(&path))?.join(name));
            }
        }
    }
    Err(io::Error::other("too many levels of symbolic links"))
}

/// Makes sure that `path` can be written, without leaving a trace, so that a long run does not fail at its end.
pub fn check_writable(path: &Path) -> Result<(), Error> {
    let check = || -> io::Result<()> {
        match existing(path)? {
            Some(metadata) if metadata.is_dir() => return Err(io::Error::other("it is a folder")),
            // A device or a pipe: opening it may block or be heard at the other end.
            Some(metadata) if !metadata.is_file() => return Ok(()),
            // A file that its owner has protected is not to be replaced.
            Some(_) => drop(OpenOptions::new().write(true).open(path)?),
            None => {}
        }
        Temporary::beside(&followed(path)?).map(drop)
    };
    check().map_err(|e| failure(path, &e))
}

/// Whether two paths lead to the same file, through links of either kind; a file need not exist yet.
pub fn same_file(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| followed(path).unwrap_or_else(|_| path.to_owned());
    if real(a) == real(b) {
        return true;
    }
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt;
        return a.is_file() && (a.dev(), a.ino()) == (b.dev(), b.ino());
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_only_when_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        fs::write(&path, "old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        file.flush().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        file.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        fs::write(&path, "old").unwrap();
        let result = AtomicFile::write_with(&path, |file| {
            file.write_all(&[0; 1 << 20])?;
            Err(io::Error::other("it broke"))
        });
        assert!(matches!(result, Err(Error::Write { reason, .. }) if reason == "it broke"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn several_files_take_their_names_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), "old").unwrap();
        let new = |name: &str| AtomicFile::fill(&at(name), |file| file.write_all(b"new")).unwrap();
        let files = vec![new("a"), new("b"), new("c"), new("d")];
        // A folder has taken the third name in the meantime.
        fs::create_dir(at("c")).unwrap();
        let failed = commit_all(files);
        assert!(matches!(failed, Err(Error::Write { path, .. }) if path == at("c")));
        assert_eq!(names(folder.path()), ["a", "c"]);
        assert_eq!(fs::read(at("a")).unwrap(), b"old");
        fs::remove_dir(at("c")).unwrap();
        commit_all(vec![new("a"), new("b"), new("c")]).unwrap();
        assert_eq!(names(folder.path()), ["a", "b", "c"]);
        assert!(["a", "b", "c"].iter().all(|name| fs::read(at(name)).unwrap() == b"new"));
    }

    #[test]
    fn a_missing_folder_and_a_file_for_a_folder_are_refused_beforehand() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "").unwrap();
        for path in ["missing/a.vtu", "file/a.vtu", ""] {
            let path = folder.path().join(path);
            assert!(matches!(check_writable(&path), Err(Error::Write { .. })), "{}", path.display());
        }
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_stay_links() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("deep")).unwrap();
        symlink("deep/target", at("link")).unwrap();
        symlink("link", at("link2")).unwrap();
        assert!(same_file(&at("link2"), &at("deep/target")));
        for text in ["first", "second"] {
            check_writable(&at("link2")).unwrap();
            AtomicFile::write_with(&at("link2"), |f| f.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read(at("deep/target")).unwrap(), text.as_bytes());
        }
        assert!(fs::symlink_metadata(at("link2")).unwrap().is_symlink());
        fs::hard_link(at("deep/target"), at("hard")).unwrap();
        assert!(same_file(&at("hard"), &at("link")));
        assert!(!same_file(&at("hard"), &at("other")));
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_a_plain_create() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().permissions().mode() & 0o7777;
        fs::write(folder.path().join("plain"), "").unwrap();
        AtomicFile::write_with(&folder.path().join("ours"), |_| Ok(())).unwrap();
        assert_eq!(mode("ours"), mode("plain"));
        fs::set_permissions(folder.path().join("ours"), fs::Permissions::from_mode(0o640)).unwrap();
        AtomicFile::write_with(&folder.path().join("ours"), |_| Ok(())).unwrap();
        assert_eq!(mode("ours"), 0o640);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_device_is_written_and_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        AtomicFile::write_with(Path::new("/dev/null"), |f| f.write_all(b"gone")).unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        let full = AtomicFile::write_with(Path::new("/dev/full"), |f| f.write_all(b"no room"));
        assert!(matches!(full, Err(Error::Write { .. })));
    }
}
