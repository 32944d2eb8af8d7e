//! Files that are written completely or not at all. The data go to a temporary file in the folder of the target, which
//! is renamed at the end. A missing folder is created when its first file is begun.
//!
//! A program that ends at a signal removes its temporary files with [`remove_unfinished`]. Those of a process that was
//! killed are removed by the next process that writes into the folder (`abandoned`).

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{Builder, NamedTempFile, TempDir};

use super::abandoned::{LOCK, MARKER, PREFIX, RANDOM_CHARACTERS, SUFFIX};

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

/// Number of attempts to remove a folder, in which another thread may create files meanwhile, and to create a file that
/// no other process locks.
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
    let _is_first = unfinished().cleaned.insert(folder.to_owned());
    #[cfg(unix)]
    if _is_first {
        super::abandoned::remove_abandoned(folder);
    }
}

/// Returns a builder of temporary files and folders with the names that [`super::abandoned`] recognises.
fn builder() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(PREFIX).rand_bytes(RANDOM_CHARACTERS).suffix(SUFFIX);
    builder
}

/// Locks a new file until it is closed. Returns false if another process holds the lock, or has removed the file while
/// it tested whether the file is in use. It does not wait, because any process that can read the file can lock it.
#[cfg(unix)]
fn lock(file: &File, path: &Path) -> bool {
    // The error of a file system without locks is ignored.
    !matches!(file.try_lock(), Err(std::fs::TryLockError::WouldBlock)) && path.exists()
}

/// On Windows a lock would also exclude other handles of this process.
#[cfg(not(unix))]
fn lock(_: &File, _: &Path) -> bool {
    true
}

/// Gives a finished file the permissions of the file that it replaces and, where the system allows it, its owner and
/// group.
#[cfg(unix)]
fn keep_access(new: &File, old: &std::fs::Metadata) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let (made, mut mode) = (new.metadata()?, old.mode() & 0o777);
    if made.uid() != old.uid() {
        let _ = fchown(new, Some(old.uid()), None);
    }
    if made.gid() != old.gid() && fchown(new, None, Some(old.gid())).is_err() {
        // Members of another group get no more than both the old group and all others had.
        mode &= !0o070 | (mode & 0o007) << 3;
    }
    // A file system without permissions (FAT) rejects this. The file was created with the same ones.
    let _ = new.set_permissions(std::fs::Permissions::from_mode(mode));
    Ok(())
}

#[cfg(not(unix))]
fn keep_access(_: &File, _: &std::fs::Metadata) -> io::Result<()> {
    Ok(())
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
    /// Creates the temporary file in the folder of `target`, and this folder if it is missing. If `target` is a
    /// symbolic link, the file it points to is replaced, and the link is kept. The new file gets the permissions of the
    /// file that it replaces and, where the system allows it, owner and group; otherwise the permissions that the umask
    /// leaves. Other hard links to the replaced file keep its old content.
    ///
    /// # Errors
    /// The folder cannot be created or is not writable; the target is a directory, a pipe or a device; or symbolic
    /// links form a circle.
    pub fn new(target: &Path) -> io::Result<Self> {
        let target = replaceable(target)?;
        let folder = folder_of(&target).to_owned();
        create_folder(&folder)?;
        Self::begin(target, &folder)
    }

    /// Creates the temporary file in `folder`.
    fn begin(target: PathBuf, folder: &Path) -> io::Result<Self> {
        remove_abandoned(folder);
        let mut builder = builder();
        // By default temporary files are readable only by their owner. A new file gets the usual permissions, and one
        // that replaces another is never more open than that.
        #[cfg(unix)]
        builder.permissions({
            use std::os::unix::fs::PermissionsExt;
            let mode = target.metadata().map_or(0o666, |old| old.permissions().mode() & 0o666 | 0o600);
            PermissionsExt::from_mode(mode)
        });
        for _ in 0..ATTEMPTS {
            let (temporary, listed) = Listed::create(|| builder.tempfile_in(folder), NamedTempFile::path)
                .map_err(|error| folder_error(folder, &error))?;
            if lock(temporary.as_file(), temporary.path()) {
                return Ok(Self { temporary, target, _listed: listed });
            }
        }
        Err(folder_error(folder, &busy()))
    }

    /// Checks that a file can be created at `target`, for use before a long computation. Nothing is created: in place
    /// of a missing folder the one in which it would be created is checked.
    ///
    /// # Errors
    /// Same as [`new`](AtomicFile::new).
    pub fn check(target: &Path) -> io::Result<()> {
        let target = replaceable(target)?;
        let folder = folder_of(&target).to_owned();
        check_links(&folder)?;
        let existing = folder.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new("."));
        Self::begin(target, existing).map(drop)
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
        // Some file systems have no permissions.
        let _ = file.set_permissions(self.file().metadata()?.permissions());
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
        if let Ok(old) = self.target.metadata() {
            keep_access(self.file(), &old)?;
        }
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
    /// Creates the folder beside an output, whose folder is created if it is missing.
    ///
    /// # Errors
    /// The folder of the output cannot be created or is not writable.
    #[cfg(all(feature = "fits", unix))]
    pub fn beside(output: &Path) -> io::Result<Self> {
        let parent = folder_of(output);
        create_folder(parent)?;
        Self::new(parent)
    }

    /// Creates the folder in `parent`.
    ///
    /// # Errors
    /// `parent` is missing or not writable.
    pub fn new(parent: &Path) -> io::Result<Self> {
        remove_abandoned(parent);
        let failed = |error| folder_error(parent, &error);
        for _ in 0..ATTEMPTS {
            let (folder, listed) = Listed::create(|| builder().tempdir_in(parent), TempDir::path).map_err(failed)?;
            // The marker is written after the file was locked: without it the folder counts as empty.
            let path = folder.path().join(LOCK);
            match File::create_new(&path) {
                Ok(mut file) if lock(&file, &path) => {
                    file.write_all(MARKER.as_bytes()).map_err(failed)?;
                    return Ok(Self { folder, _listed: listed, _lock: file });
                }
                // Another process has just removed the empty folder.
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed(error)),
                _ => {}
            }
        }
        Err(failed(busy()))
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

fn busy() -> io::Error {
    io::Error::other("another process locks or removes each new temporary file")
}

/// Returns the folder of a file.
fn folder_of(target: &Path) -> &Path {
    target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Creates the folder of an output if it is missing.
fn create_folder(folder: &Path) -> io::Result<()> {
    check_links(folder)?;
    std::fs::create_dir_all(folder).map_err(|error| folder_error(folder, &error))
}

/// Checks that no part of the path of a folder is a symbolic link to a missing folder, which cannot be created.
fn check_links(folder: &Path) -> io::Result<()> {
    match folder.ancestors().find(|part| part.is_symlink() && !part.exists()) {
        Some(link) => {
            let reason =
                "is a symbolic link to a missing folder; allowed: an existing folder, or the name of a new one";
            Err(io::Error::new(io::ErrorKind::NotFound, format!("folder {} {reason}", link.display())))
        }
        None => Ok(()),
    }
}

/// Returns true for a path that can only be that of a folder: it ends in `/`, `.` or `..`.
fn is_path_of_folder(path: &Path) -> bool {
    let last = path.as_os_str().to_string_lossy();
    let last = last.rsplit(std::path::is_separator).next().unwrap_or_default();
    matches!(last, "" | "." | "..")
}

/// Returns the file behind the symbolic links of `target`.
///
/// # Errors
/// It is a directory, a pipe or a device, or the links form a circle.
fn replaceable(target: &Path) -> io::Result<PathBuf> {
    if is_path_of_folder(target) && !target.exists() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "is the name of a folder; allowed: the name of a file",
        ));
    }
    let target = behind_links(target)?;
    if target.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a directory; allowed: the name of a file"));
    }
    if is_special(&target) {
        let reason = "is a pipe, a terminal or a device, which cannot be replaced; allowed: the name of a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    Ok(target)
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
/// The folder cannot be created or is not writable, or the target is a directory.
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
    fn mode(path: &Path) -> u32 {
        use std::os::unix::fs::PermissionsExt;
        path.metadata().unwrap().permissions().mode() & 0o7777
    }

    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_permissions_and_a_new_one_has_those_of_the_umask() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        let usual = folder.path().join("usual");
        File::create(&usual).unwrap();
        let write = |path: &Path| {
            let file = AtomicFile::new(path).unwrap();
            let unfinished = mode(file.path());
            file.finish().unwrap();
            unfinished
        };
        write(&path);
        assert_eq!(mode(&path), mode(&usual));
        for kept in [0o600, 0o640, 0o666, 0o400, 0o755] {
            std::fs::set_permissions(&path, PermissionsExt::from_mode(kept)).unwrap();
            let unfinished = write(&path);
            assert_eq!(
                unfinished & !(kept | 0o600),
                0,
                "{unfinished:o} during the replacement of a file with {kept:o}"
            );
            assert_eq!(mode(&path), kept);
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_another_program_made_in_the_folder_of_fits_keeps_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (path, made) = (folder.path().join("out.fits"), folder.path().join("made"));
        for name in [&path, &made] {
            std::fs::write(name, "old").unwrap();
        }
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).unwrap();
        let mut file = AtomicFile::new(&path).unwrap();
        file.take(&made).unwrap();
        assert_eq!(mode(file.path()), 0o600);
        file.finish().unwrap();
        assert_eq!(mode(&path), 0o600);
    }

    #[test]
    fn other_hard_links_keep_the_old_content() {
        let folder = tempfile::tempdir().unwrap();
        let [path, link] = ["out.csv", "link.csv"].map(|name| folder.path().join(name));
        std::fs::write(&path, "old").unwrap();
        std::fs::hard_link(&path, &link).unwrap();
        write_atomically(&path, |out| out.write_all(b"new")).unwrap();
        assert_eq!([&path, &link].map(|path| std::fs::read_to_string(path).unwrap()), ["new", "old"]);
    }

    #[cfg(unix)]
    #[test]
    fn other_processes_see_the_locks_of_temporary_files() {
        let folder = tempfile::tempdir().unwrap();
        let file = AtomicFile::new(&folder.path().join("out.csv")).unwrap();
        let scratch = ScratchFolder::new(folder.path()).unwrap();
        for path in [file.path().to_owned(), scratch.path().join(LOCK)] {
            assert!(File::options().write(true).open(path).unwrap().try_lock().is_err());
        }
        // The files of this process are not abandoned.
        super::super::abandoned::remove_abandoned(folder.path());
        assert!(file.path().exists() && scratch.path().join(LOCK).exists());
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
    fn missing_folders_are_created_when_a_file_is_written_and_not_by_a_check() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("new/below/out.csv");
        check_target(&target).unwrap();
        check_target(&folder.path().join("out.csv")).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        write_atomically(&target, |out| out.write_all(b"words")).unwrap();
        assert_eq!(std::fs::read(&target).unwrap(), b"words");
        // A relative path without a folder.
        check_target(Path::new("streakcast-new-folder/out.csv")).unwrap();
        assert!(!Path::new("streakcast-new-folder").exists());
    }

    #[test]
    fn a_folder_that_cannot_be_created_is_named_and_not_the_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        for target in [file.join("out.csv"), file.join("new/out.csv")] {
            let errors = [check_target(&target).unwrap_err(), AtomicFile::new(&target).unwrap_err()];
            for text in errors.map(|error| error.to_string()) {
                assert!(text.starts_with(&format!("folder {}", file.display())), "{text}");
                assert!(!text.contains(".part"), "{text}");
            }
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn paths_of_folders_are_not_files() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["new1/", "new1/.", "new1/..", "new1/below/", ""] {
            let target = if name.is_empty() { PathBuf::new() } else { folder.path().join(name) };
            for error in [check_target(&target).unwrap_err(), AtomicFile::new(&target).unwrap_err()] {
                assert_eq!(error.to_string(), "is the name of a folder; allowed: the name of a file", "{name}");
            }
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn links_to_missing_folders_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(folder.path().join("missing"), &link).unwrap();
        for target in [link.join("out.csv"), link.join("new/out.csv")] {
            for error in [check_target(&target).unwrap_err(), AtomicFile::new(&target).unwrap_err()] {
                let text = error.to_string();
                assert!(text.starts_with(&format!("folder {} is a symbolic link", link.display())), "{text}");
                assert!(text.contains("; allowed: "), "{text}");
            }
        }
        assert!(!folder.path().join("missing").exists());
    }
}
