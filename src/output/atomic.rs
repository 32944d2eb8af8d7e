//! Files that are written completely or not at all. The data go to a temporary file in the folder of the target, which
//! is renamed at the end.
//!
//! A program that ends at a signal removes its temporary files with [`remove_unfinished`]. Those of a process that was
//! killed are removed by the next process that writes into the folder: a process keeps its temporary files locked, and
//! the system drops the locks when it ends.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{Builder, NamedTempFile, TempDir};

/// Beginning of the names of temporary files and folders.
const PREFIX: &str = ".streakcast-";
/// File in a temporary folder that is locked while the folder is in use.
const LOCK: &str = "lock";

/// Temporary files of this process.
struct Unfinished {
    /// Temporary files and folders.
    paths: BTreeSet<PathBuf>,
    /// Folders in which the files of ended processes were removed.
    cleaned: BTreeSet<PathBuf>,
}

static UNFINISHED: Mutex<Unfinished> = Mutex::new(Unfinished { paths: BTreeSet::new(), cleaned: BTreeSet::new() });

fn unfinished() -> MutexGuard<'static, Unfinished> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files and folders of this process, for a program that ends at a signal; finished outputs are
/// kept.
///
/// Afterwards no output can be begun or finished in this process: threads that try it wait for the end of the process.
pub fn remove_unfinished() {
    let unfinished = unfinished();
    unfinished.paths.iter().for_each(|path| remove(path));
    std::mem::forget(unfinished);
}

/// Number of attempts to remove a folder, in which another thread may create files meanwhile.
const ATTEMPTS: usize = 100;

fn remove(path: &Path) {
    // The file may be gone already.
    if path.is_dir() {
        let _ = (0..ATTEMPTS).find(|_| std::fs::remove_dir_all(path).is_ok() || !path.exists());
    } else {
        let _ = std::fs::remove_file(path);
    }
}

/// Removes the temporary files of ended processes from a folder, once in each process. On Windows they are kept,
/// because there [`lock`] does not mark those in use.
fn remove_abandoned(folder: &Path) {
    if !unfinished().cleaned.insert(folder.to_owned()) || cfg!(not(unix)) {
        return;
    }
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(PREFIX)) {
        let (path, Ok(kind)) = (entry.path(), entry.file_type()) else { continue };
        let locked = if kind.is_dir() { path.join(LOCK) } else { path.clone() };
        // Files on systems without locks are kept.
        if let Some(file) = File::options().write(true).open(locked).ok().filter(|_| kind.is_dir() || kind.is_file())
            && file.try_lock().is_ok()
        {
            remove(&path);
        }
    }
}

/// Locks a file until it is closed. Waits for a process that tests whether the file is in use, and returns false if
/// that process has removed it.
#[cfg(unix)]
fn lock(file: &File, path: &Path) -> bool {
    // The error of a file system without locks is ignored.
    let _ = file.lock();
    path.exists()
}

/// On Windows a lock would also exclude other handles of this process.
#[cfg(not(unix))]
fn lock(_: &File, _: &Path) -> bool {
    true
}

/// Entry in the list of temporary files. It is removed from the list when this value is dropped.
#[derive(Debug)]
struct Listed(PathBuf);

impl Listed {
    /// Creates a temporary file or folder and its entry under one lock, so that every temporary file has an entry.
    fn create<T>(create: impl FnOnce() -> io::Result<T>, path: impl Fn(&T) -> &Path) -> io::Result<(T, Self)> {
        let mut unfinished = unfinished();
        let created = create()?;
        let path = path(&created).to_owned();
        unfinished.paths.insert(path.clone());
        Ok((created, Self(path)))
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().paths.remove(&self.0);
    }
}

/// Unfinished output file. If it is dropped without [`finish`](AtomicFile::finish), the temporary file is deleted.
#[derive(Debug)]
pub struct AtomicFile {
    temporary: NamedTempFile,
    target: PathBuf,
    /// Dropped after the temporary file.
    _listed: Listed,
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
        remove_abandoned(folder);
        let mut builder = Builder::new();
        builder.prefix(PREFIX).suffix(".part");
        // A new file gets the usual permissions; by default temporary files are readable only by their owner.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        loop {
            let (temporary, listed) = Listed::create(|| builder.tempfile_in(folder), NamedTempFile::path)
                .map_err(|error| folder_error(folder, &error))?;
            if lock(temporary.as_file(), temporary.path()) {
                return Ok(Self { temporary, target, _listed: listed });
            }
        }
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
        let file = File::options().read(true).write(true).open(made)?;
        lock(&file, made);
        std::fs::rename(made, self.path())?;
        *self.temporary.as_file_mut() = file;
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
pub struct ScratchFolder {
    folder: TempDir,
    /// Dropped after the folder.
    _listed: Listed,
    /// The file [`LOCK`], locked.
    _lock: File,
}

impl ScratchFolder {
    /// Creates the folder in `parent`.
    ///
    /// # Errors
    /// `parent` is missing or not writable.
    pub fn new(parent: &Path) -> io::Result<Self> {
        remove_abandoned(parent);
        loop {
            let (folder, listed) = Listed::create(|| Builder::new().prefix(PREFIX).tempdir_in(parent), TempDir::path)
                .map_err(|error| folder_error(parent, &error))?;
            let file = folder.path().join(LOCK);
            let locked = File::create(&file).map_err(|error| folder_error(parent, &error))?;
            if lock(&locked, &file) {
                return Ok(Self { folder, _listed: listed, _lock: locked });
            }
        }
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
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

    #[cfg(unix)]
    #[test]
    fn files_of_ended_processes_are_removed_and_those_in_use_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let made = |name: &str| {
            let path = folder.path().join(name);
            path.parent().map(std::fs::create_dir_all).unwrap().unwrap();
            File::create(&path).unwrap()
        };
        for name in [".streakcast-a.part", ".streakcast-b/lock", ".streakcast-b/out.fits", "streakcast-c.part"] {
            drop(made(name));
        }
        let in_use = [made(".streakcast-d.part"), made(".streakcast-e/lock")];
        in_use.iter().for_each(|file| file.lock().unwrap());
        // A folder without its lock is just being made.
        std::fs::create_dir(folder.path().join(".streakcast-f")).unwrap();
        let (file, scratch) =
            (AtomicFile::new(&folder.path().join("out.csv")).unwrap(), ScratchFolder::new(folder.path()).unwrap());
        // Other processes see the locks of this one.
        for path in [file.path().to_owned(), scratch.path().join(LOCK)] {
            assert!(File::options().write(true).open(path).unwrap().try_lock().is_err());
        }
        drop((file, scratch));
        let mut left: Vec<String> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        assert_eq!(left, [".streakcast-d.part", ".streakcast-e", ".streakcast-f", "streakcast-c.part"]);
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
