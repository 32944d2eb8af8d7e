//! Files that are there whole or not at all: written beside their target and renamed. Only a power cut may leave less, of a file that is
//! [finished lazily](AtomicFile::finish_lazily).

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

/// A file in the making. Dropped without [`finish`](AtomicFile::finish), it leaves nothing behind.
#[derive(Debug)]
pub struct AtomicFile {
    temporary: NamedTempFile,
    target: PathBuf,
}

impl AtomicFile {
    /// Begins a file that will stand at `target`, in the same folder so that the rename is one step. Symbolic links are followed: what they lead to, there
    /// already or not yet, is replaced, and they stay.
    ///
    /// # Errors
    /// The folder is missing or cannot be written to, the target is a directory, a pipe or a device, or its links go round in a circle.
    pub fn new(target: &Path) -> io::Result<Self> {
        let target = behind_links(target)?;
        if target.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a directory"));
        }
        if is_special(&target) {
            let why = "is a pipe, a terminal or a device, which no file can take the place of; allowed: a file's name";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
        }
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = Builder::new();
        builder.prefix(".streakcast-").suffix(".part");
        // What the process would give any new file; a temporary one is for its owner only.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let temporary = builder.tempfile_in(folder).map_err(|error| of_folder(folder, &error))?;
        Ok(Self { temporary, target })
    }

    /// Whether a file can be begun there: better asked before long work than after it. Leaves nothing behind.
    ///
    /// # Errors
    /// As [`new`](AtomicFile::new).
    pub fn check(target: &Path) -> io::Result<()> {
        Self::new(target).map(drop)
    }

    /// The file as it is being made.
    pub fn file(&self) -> &File {
        self.temporary.as_file()
    }

    /// Asks for room for so many bytes before they are written: large files are written a third faster than where each write asks for more, and a full
    /// disk is told before anything is written. The file is so long then. Where a file system has no such thing, nothing happens.
    ///
    /// # Errors
    /// There is not so much room.
    pub fn reserve(&self, length: u64) -> io::Result<()> {
        reserve(self.file(), length)
    }

    /// Where it is being made.
    pub fn path(&self) -> &Path {
        self.temporary.path()
    }

    /// Takes a file of the same folder in place of what was written so far.
    ///
    /// # Errors
    /// The file cannot be renamed or opened.
    pub fn take(&mut self, made: &Path) -> io::Result<()> {
        std::fs::rename(made, self.path())?;
        *self.temporary.as_file_mut() = File::options().read(true).write(true).open(self.path())?;
        Ok(())
    }

    /// Whether another file stands where this one will.
    pub fn is_replacing(&self) -> bool {
        self.target.symlink_metadata().is_ok()
    }

    /// Puts the file in its place, over whatever stood there, when all of it is on the disk.
    ///
    /// # Errors
    /// Whatever the system reports; the old file then stands as it was.
    pub fn finish(self) -> io::Result<()> {
        self.temporary.as_file().sync_all()?;
        self.put()
    }

    /// The same, but waits for the disk only where another file is replaced, which a power cut must not take away before this one is there. A file that
    /// replaces nothing is as safe as one that was copied: for large ones that can be made again.
    ///
    /// # Errors
    /// As [`finish`](AtomicFile::finish).
    pub fn finish_lazily(self) -> io::Result<()> {
        if self.is_replacing() { self.finish() } else { self.put() }
    }

    fn put(self) -> io::Result<()> {
        let (file, path) = self.temporary.into_parts();
        close(file)?;
        path.persist(&self.target).map_err(|error| error.error)
    }
}

#[cfg(target_os = "linux")]
fn reserve(file: &File, length: u64) -> io::Result<()> {
    use nix::errno::Errno;
    use nix::fcntl::{FallocateFlags, fallocate};
    let Ok(length) = i64::try_from(length) else { return Ok(()) };
    match fallocate(file, FallocateFlags::empty(), 0, length) {
        Err(full @ (Errno::ENOSPC | Errno::EDQUOT)) => Err(full.into()),
        _ => Ok(()),
    }
}

/// Other systems grow files as they are written.
#[cfg(not(target_os = "linux"))]
fn reserve(_: &File, _: u64) -> io::Result<()> {
    Ok(())
}

/// Closes a file. Network file systems say only now that something could not be written; dropping a `File` would not tell.
#[cfg(unix)]
fn close(file: File) -> io::Result<()> {
    nix::unistd::close(file).map_err(io::Error::from)
}

/// Closes a file; what other systems say then is not to be had.
#[cfg(not(unix))]
fn close(file: File) -> io::Result<()> {
    drop(file);
    Ok(())
}

/// A folder for files that only pass through; removed with all in it when dropped.
#[derive(Debug)]
pub struct ScratchFolder(TempDir);

impl ScratchFolder {
    /// Makes one in `parent`.
    ///
    /// # Errors
    /// `parent` is missing or cannot be written to.
    pub fn new(parent: &Path) -> io::Result<Self> {
        Builder::new().prefix("streakcast-").tempdir_in(parent).map(Self).map_err(|error| of_folder(parent, &error))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

/// What the system said, about the folder: the name of the temporary file in it means nothing to anyone.
fn of_folder(folder: &Path, error: &io::Error) -> io::Error {
    let text = error.to_string();
    let cause = text.split_once(" at path ").map_or(text.as_str(), |(cause, _)| cause);
    io::Error::new(error.kind(), format!("folder {}: {cause}", folder.display()))
}

/// Whether [`write_atomically`] can write to `target`: better asked before long work than after it. Leaves nothing behind.
///
/// # Errors
/// The folder is missing or cannot be written to, or the target is a directory.
pub fn check_target(target: &Path) -> io::Result<()> {
    if is_special(target) { Ok(()) } else { AtomicFile::check(target) }
}

/// Links on the way to a file; a system follows 40 of them (`man 7 path_resolution`).
const MOST_LINKS: usize = 40;

/// Where the symbolic links at `target` lead to, whether something stands there or not; `target` itself where it is none.
fn behind_links(target: &Path) -> io::Result<PathBuf> {
    let mut target = target.to_owned();
    for _ in 0..=MOST_LINKS {
        if !target.is_symlink() {
            return Ok(target);
        }
        // A link that begins with a folder's name begins in its own folder; `join` takes an absolute one as it is.
        let link = std::fs::read_link(&target)?;
        target = target.parent().unwrap_or(Path::new("")).join(link);
    }
    Err(io::Error::other(format!("is a symbolic link that leads to no file within {MOST_LINKS} steps")))
}

/// A pipe, a terminal: what cannot be replaced by another file.
fn is_special(target: &Path) -> bool {
    target.metadata().is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Writes a file in one step. What is no ordinary file (a pipe, a terminal) is written to as it is.
///
/// # Errors
/// Whatever the writer or the system reports; nothing half-written stays.
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
    fn a_file_that_does_not_wait_for_the_disk_stands_as_well() {
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
        assert!(check_target(&round).unwrap_err().to_string().contains("leads to no file"));
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
