//! Files that are written completely or not at all. The data go to a temporary file in the folder of the target, which
//! is renamed at the end.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

/// Unfinished output file. If it is dropped without [`finish`](AtomicFile::finish), the temporary file is deleted.
#[derive(Debug)]
pub struct AtomicFile {
    temporary: NamedTempFile,
    target: PathBuf,
}

impl AtomicFile {
    /// Creates the temporary file in the folder of `target`. If `target` is a symbolic link, the file it points to is
    /// replaced, and the link is kept.
    ///
    /// # Errors
    /// The folder is missing or not writable; the target is a directory, a pipe or a device; or symbolic links form a
    /// circle.
    pub fn new(target: &Path) -> io::Result<Self> {
        let target = behind_links(target)?;
        if target.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a directory; allowed: the name of a file"));
        }
        if is_special(&target) {
            let reason = "is a pipe, a terminal or a device, which cannot be replaced; allowed: the name of a file";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
        }
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = Builder::new();
        builder.prefix(".streakcast-").suffix(".part");
        // A new file gets the usual permissions; by default temporary files are readable only by their owner.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let temporary = builder.tempfile_in(folder).map_err(|error| folder_error(folder, &error))?;
        Ok(Self { temporary, target })
    }

    /// Checks that a file can be created at `target`, for use before a long computation.
    ///
    /// # Errors
    /// Same as [`new`](AtomicFile::new).
    pub fn check(target: &Path) -> io::Result<()> {
        Self::new(target).map(drop)
    }

    /// Returns the temporary file, open for writing.
    pub fn file(&self) -> &File {
        self.temporary.as_file()
    }

    /// Returns the path of the temporary file.
    pub fn path(&self) -> &Path {
        self.temporary.path()
    }

    /// Replaces the temporary file by the file `made`, which is in the same folder.
    ///
    /// # Errors
    /// The file cannot be renamed or opened.
    pub fn take(&mut self, made: &Path) -> io::Result<()> {
        std::fs::rename(made, self.path())?;
        *self.temporary.as_file_mut() = File::options().read(true).write(true).open(self.path())?;
        Ok(())
    }

    /// Returns true if a file exists at the target.
    pub fn is_replacing(&self) -> bool {
        self.target.symlink_metadata().is_ok()
    }

    /// Syncs the file to disk and renames it to its target, replacing any file there.
    ///
    /// # Errors
    /// Any error of the operating system; a file that existed at the target is then unchanged.
    pub fn finish(self) -> io::Result<()> {
        self.temporary.as_file().sync_all()?;
        self.rename()
    }

    /// Renames the file as [`finish`](AtomicFile::finish) does, but syncs it to disk only if it replaces another file.
    /// Meant for large files that can be regenerated: after a power failure a new file may be incomplete.
    ///
    /// # Errors
    /// Same as [`finish`](AtomicFile::finish).
    pub fn finish_lazily(self) -> io::Result<()> {
        if self.is_replacing() { self.finish() } else { self.rename() }
    }

    fn rename(self) -> io::Result<()> {
        self.temporary.persist(&self.target).map(drop).map_err(|error| error.error)
    }
}

/// A temporary folder, removed with all its files when dropped.
#[derive(Debug)]
pub struct ScratchFolder(TempDir);

impl ScratchFolder {
    /// Creates the folder in `parent`.
    ///
    /// # Errors
    /// `parent` is missing or not writable.
    pub fn new(parent: &Path) -> io::Result<Self> {
        Builder::new().prefix("streakcast-").tempdir_in(parent).map(Self).map_err(|error| folder_error(parent, &error))
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

/// Returns the error with the name of the folder in place of the name of the temporary file, which the user does not
/// know.
fn folder_error(folder: &Path, error: &io::Error) -> io::Error {
    let text = error.to_string();
    let cause = text.split_once(" at path ").map_or(text.as_str(), |(cause, _)| cause);
    io::Error::new(error.kind(), format!("folder {}: {cause}", folder.display()))
}

/// Checks that [`write_atomically`] can write to `target`, for use before a long computation.
///
/// # Errors
/// The folder is missing or not writable, or the target is a directory.
pub fn check_target(target: &Path) -> io::Result<()> {
    if is_special(target) { Ok(()) } else { AtomicFile::check(target) }
}

/// Largest number of symbolic links that are followed, the same as on Linux (`man 7 path_resolution`).
const MOST_LINKS: usize = 40;

/// Follows the symbolic links at `target`, even if the last link points to a missing file.
fn behind_links(target: &Path) -> io::Result<PathBuf> {
    let mut target = target.to_owned();
    for _ in 0..=MOST_LINKS {
        if !target.is_symlink() {
            return Ok(target);
        }
        // A relative link is relative to the folder of the link; `join` leaves an absolute path unchanged.
        let link = std::fs::read_link(&target)?;
        target = target.parent().unwrap_or(Path::new("")).join(link);
    }
    Err(io::Error::other(format!(
        "is a symbolic link without a target within {MOST_LINKS} links; allowed: a link to a file"
    )))
}

/// Returns true for a pipe, a terminal or another device; renaming a file to its path would replace the device.
fn is_special(target: &Path) -> bool {
    target.metadata().is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Writes a file completely or not at all. Pipes, terminals and other devices are written to directly.
///
/// # Errors
/// Any error of `write` or of the operating system; no incomplete file remains.
pub fn write_atomically(target: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    if is_special(target) {
        let mut out = BufWriter::new(File::options().write(true).open(target)?);
        write(&mut out)?;
        return out.flush();
    }
    let file = AtomicFile::new(target)?;
    let mut out = BufWriter::new(file.file());
    write(&mut out)?;
    out.flush()?;
    drop(out);
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_fails_leaves_the_old_one_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        write_atomically(&path, |out| out.write_all(b"one")).unwrap();
        let failed = write_atomically(&path, |out| {
            out.write_all(b"two")?;
            Err(io::Error::other("no"))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_without_a_disk_sync_is_complete_as_well() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.fits");
        for (text, is_replacing) in [("one", false), ("two", true)] {
            let file = AtomicFile::new(&path).unwrap();
            file.file().write_all(text.as_bytes()).unwrap();
            assert_eq!(file.is_replacing(), is_replacing);
            file.finish_lazily().unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_directory_is_no_target() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write_atomically(folder.path(), |_| Ok(())).is_err());
        assert!(check_target(folder.path()).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_stay() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("below");
        std::fs::create_dir(&below).unwrap();
        std::fs::write(below.join("old.csv"), "old").unwrap();
        let [old, new, round] = ["old", "new", "round"].map(|name| folder.path().join(name));
        symlink("below/old.csv", &old).unwrap();
        symlink(below.join("new.csv"), below.join("link")).unwrap();
        symlink("below/link", &new).unwrap();
        symlink("round", &round).unwrap();
        for (link, file) in [(&old, "old.csv"), (&new, "new.csv")] {
            write_atomically(link, |out| out.write_all(b"written")).unwrap();
            assert!(link.is_symlink(), "{file}");
            assert_eq!(std::fs::read(below.join(file)).unwrap(), b"written");
        }
        assert!(!below.join("new.csv").is_symlink() && below.join("link").is_symlink());
        assert!(check_target(&round).unwrap_err().to_string().contains("without a target"));
        assert_eq!(std::fs::read_dir(&below).unwrap().count(), 3);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_and_never_replaced() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        symlink("/dev/null", &link).unwrap();
        for target in [Path::new("/dev/null"), &link] {
            check_target(target).unwrap();
            write_atomically(target, |out| out.write_all(b"words")).unwrap();
            assert!(AtomicFile::new(target).unwrap_err().to_string().contains("device"));
        }
        assert!(link.is_symlink() && link.metadata().unwrap().file_type().is_char_device());
    }

    #[test]
    fn a_folder_that_is_missing_is_named_and_not_the_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing");
        let error = check_target(&missing.join("out.csv")).unwrap_err();
        let text = error.to_string();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(text.starts_with(&format!("folder {}: No such file", missing.display())), "{text}");
        assert!(!text.contains(".part"), "{text}");
        check_target(&folder.path().join("out.csv")).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
