//! Names and marks of temporary files and folders, and the removal of those that ended processes left.
//!
//! A file or folder is removed only if it is certainly one of this program and not in use:
//!
//! - its name has the form of [`is_own_name`], which includes 32 random letters and digits;
//! - it is a regular file, or a folder with a file [`LOCK`] that contains [`MARKER`], or that is empty and alone in the
//!   folder (of a process that was killed before it wrote the marker); links are not followed;
//! - it belongs to the effective user of this process;
//! - no process holds its lock. A process keeps its temporary files locked, and the system drops the locks when it
//!   ends.
//!
//! Removal refers to the open folder, and the file must still be the one that was examined. A file of the same name
//! could be lost only if it took this name in the microseconds in between.

#[cfg(unix)]
pub(super) use unix::remove_abandoned;

/// Beginning of the names of temporary files and folders.
pub(super) const PREFIX: &str = ".streakcast-";
/// Number of random letters and digits in these names.
pub(super) const RANDOM_CHARACTERS: usize = 32;
/// End of these names.
pub(super) const SUFFIX: &str = ".part";
/// File in a temporary folder that is locked while the folder is in use.
pub(super) const LOCK: &str = "lock";
/// Content of this file, which is written after it was locked.
pub(super) const MARKER: &str =
    "This folder was created by streakcast for temporary files. streakcast removes it with all its files.\n";

/// Returns true if a file name has the form of the names of temporary files. Random texts of this length contain
/// lower-case and upper-case letters (all but one in ten million); other names are kept.
pub(super) fn is_own_name(name: &str) -> bool {
    let random = name.strip_prefix(PREFIX).and_then(|name| name.strip_suffix(SUFFIX)).unwrap_or_default();
    let has = |kind: fn(&u8) -> bool| random.as_bytes().iter().any(kind);
    random.len() == RANDOM_CHARACTERS
        && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
        && has(u8::is_ascii_lowercase)
        && has(u8::is_ascii_uppercase)
}

#[cfg(unix)]
mod unix {
    use std::ffi::{CStr, CString};
    use std::fs::File;
    use std::io;
    use std::os::fd::OwnedFd;
    use std::path::Path;

    use rustix::fs::{AtFlags, Dir, FileType, Mode, OFlags, Stat, fstat, open, openat, statat, unlinkat};

    use super::{LOCK, MARKER, is_own_name};
    use crate::input::read_at_most;

    /// Access to a folder. A named pipe is neither followed by a wait, nor a link by its target.
    const FOLDER: OFlags = OFlags::RDONLY.union(OFlags::DIRECTORY).union(FILE_FLAGS);
    const FILE: OFlags = OFlags::RDWR.union(FILE_FLAGS);
    const FILE_FLAGS: OFlags = OFlags::NONBLOCK.union(OFlags::NOFOLLOW).union(OFlags::CLOEXEC);

    /// Removes the temporary files and folders of ended processes from a folder. Whatever cannot be examined is kept.
    pub fn remove_abandoned(folder: &Path) {
        let Ok(folder) = open(folder, FOLDER.difference(OFlags::NOFOLLOW), Mode::empty()) else { return };
        for name in names(&folder).unwrap_or_default() {
            if name.to_str().is_ok_and(is_own_name) {
                let _ = remove_if_abandoned(&folder, &name);
            }
        }
    }

    fn remove_if_abandoned(folder: &OwnedFd, name: &CStr) -> io::Result<()> {
        match kind(&statat(folder, name, AtFlags::SYMLINK_NOFOLLOW)?) {
            FileType::RegularFile => {
                let (file, status) = open_own(folder, name, FILE, FileType::RegularFile)?;
                // Files on systems without locks are kept.
                file.try_lock()?;
                check_same(folder, name, &status)?;
                Ok(unlinkat(folder, name, AtFlags::empty())?)
            }
            FileType::Directory => {
                let (inner, status) = open_own(folder, name, FOLDER, FileType::Directory)?;
                let inner = OwnedFd::from(inner);
                // Succeeds only if the folder is empty.
                if unlinkat(folder, name, AtFlags::REMOVEDIR).is_ok() {
                    return Ok(());
                }
                let (marker, _) = open_own(&inner, LOCK, FILE, FileType::RegularFile)?;
                let text = read_at_most(&marker, MARKER.len() as u64)?;
                if text != MARKER.as_bytes() && (!text.is_empty() || names(&inner)?.len() > 1) {
                    return Err(io::ErrorKind::InvalidData.into());
                }
                marker.try_lock()?;
                // The marker is removed last, so that another run can remove what is left if this one is killed.
                remove_files(&inner, Some(LOCK))?;
                check_same(folder, name, &status)?;
                unlinkat(&inner, LOCK, AtFlags::empty())?;
                Ok(unlinkat(folder, name, AtFlags::REMOVEDIR)?)
            }
            _ => Ok(()),
        }
    }

    /// Opens a file of this user and returns its status. Neither follows a link nor waits for a pipe.
    fn open_own(
        folder: &OwnedFd,
        name: impl rustix::path::Arg,
        flags: OFlags,
        expected: FileType,
    ) -> io::Result<(File, Stat)> {
        let file = openat(folder, name, flags, Mode::empty())?;
        let status = fstat(&file)?;
        let is_own = status.st_uid == rustix::process::geteuid().as_raw() && kind(&status) == expected;
        if is_own { Ok((file.into(), status)) } else { Err(io::ErrorKind::PermissionDenied.into()) }
    }

    /// Checks that a name still belongs to the file with the given status.
    fn check_same(folder: &OwnedFd, name: &CStr, status: &Stat) -> io::Result<()> {
        let now = statat(folder, name, AtFlags::SYMLINK_NOFOLLOW)?;
        let is_same = (now.st_dev, now.st_ino) == (status.st_dev, status.st_ino);
        if is_same { Ok(()) } else { Err(io::ErrorKind::NotFound.into()) }
    }

    /// Removes the regular files of an open folder and of the folders in it, except for one name.
    fn remove_files(folder: &OwnedFd, kept: Option<&str>) -> io::Result<()> {
        for name in names(folder)?.iter().filter(|name| name.to_str().ok() != kept) {
            match kind(&statat(folder, name, AtFlags::SYMLINK_NOFOLLOW)?) {
                FileType::RegularFile => unlinkat(folder, name, AtFlags::empty())?,
                FileType::Directory => {
                    remove_files(&openat(folder, name, FOLDER, Mode::empty())?, None)?;
                    unlinkat(folder, name, AtFlags::REMOVEDIR)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the names in an open folder, without `.` and `..`.
    fn names(folder: &OwnedFd) -> io::Result<Vec<CString>> {
        let entries = Dir::read_from(folder)?.map(|entry| Ok(entry?.file_name().to_owned()));
        let names: io::Result<Vec<CString>> = entries.collect();
        Ok(names?.into_iter().filter(|name| ![c".", c".."].contains(&name.as_c_str())).collect())
    }

    fn kind(status: &Stat) -> FileType {
        FileType::from_raw_mode(status.st_mode)
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::collections::BTreeSet;
    use std::fs::{self, File};
    use std::os::unix::fs::symlink;
    use std::path::Path;

    use super::*;
    use crate::output::{AtomicFile, ScratchFolder};

    /// Names as tempfile makes them.
    const NAMES: [&str; 4] = [
        ".streakcast-0aAbcdefghijklmnopqrstuvwxyz2345.part",
        ".streakcast-1aAbcdefghijklmnopqrstuvwxyz2345.part",
        ".streakcast-2aAbcdefghijklmnopqrstuvwxyz2345.part",
        ".streakcast-3aAbcdefghijklmnopqrstuvwxyz2345.part",
    ];

    fn names(folder: &Path) -> BTreeSet<String> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    /// Creates a temporary folder as [`ScratchFolder`] does.
    fn make_folder(path: &Path, marker: &str) -> File {
        fs::create_dir(path).unwrap();
        fs::write(path.join(LOCK), marker).unwrap();
        File::options().read(true).write(true).open(path.join(LOCK)).unwrap()
    }

    /// Checks that nothing is removed from a folder.
    fn assert_kept(fill: impl Fn(&Path)) {
        let folder = tempfile::tempdir().unwrap();
        fill(folder.path());
        let before = names(folder.path());
        assert!(!before.is_empty());
        remove_abandoned(folder.path());
        assert_eq!(names(folder.path()), before);
    }

    #[test]
    fn names_of_temporary_files_are_recognised() {
        let folder = tempfile::tempdir().unwrap();
        let file = AtomicFile::new(&folder.path().join("out.csv")).unwrap();
        let scratch = ScratchFolder::new(folder.path()).unwrap();
        for path in [file.path(), scratch.path()] {
            let name = path.file_name().unwrap().to_str().unwrap();
            assert!(is_own_name(name), "{name}");
        }
        assert!(NAMES.into_iter().all(is_own_name));
        for name in [
            ".streakcast-policy.toml",
            ".streakcast-token",
            ".streakcast-policy.part",
            ".streakcast-.part",
            ".streakcast-policiesofthesurveyofthemoon2026.part",
            ".streakcast-0aAbcdefghijklmnopqrstuvwxyz234.part",
            ".streakcast-0aAbcdefghijklmnopqrstuvwxyz23456.part",
            ".streakcast-0aAbcdefghijklmnopqrstuvwxyz-345.part",
            ".streakcast-0aAbcdefghijklmnopqrstuvwxyz2345",
            "streakcast-0aAbcdefghijklmnopqrstuvwxyz2345.part",
            ".streakcast-5d41402abc4b2a76b9719d911017c592.part",
        ] {
            assert!(!is_own_name(name), "{name}");
        }
    }

    #[test]
    fn what_ended_processes_left_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let [file, scratch, ..] = NAMES.map(|name| folder.path().join(name));
        fs::write(&file, "unfinished").unwrap();
        drop(make_folder(&scratch, MARKER));
        fs::write(scratch.join("out.fits"), "unfinished").unwrap();
        // A frame that is copied inside a temporary folder has one of its own.
        drop(make_folder(&scratch.join(NAMES[0]), MARKER));
        fs::write(scratch.join(NAMES[0]).join("new.fits"), "unfinished").unwrap();
        // Processes that were killed before they wrote the marker.
        drop(make_folder(&folder.path().join(NAMES[2]), ""));
        fs::create_dir(folder.path().join(NAMES[3])).unwrap();
        remove_abandoned(folder.path());
        assert_eq!(names(folder.path()), BTreeSet::new());
    }

    #[test]
    fn what_running_processes_use_is_kept() {
        let locks = std::sync::Mutex::new(Vec::new());
        assert_kept(|folder| {
            let file = File::create(folder.join(NAMES[0])).unwrap();
            let scratch = make_folder(&folder.join(NAMES[1]), MARKER);
            // A folder that is just being made has no marker.
            let new = make_folder(&folder.join(NAMES[2]), "");
            for file in [file, scratch, new] {
                file.lock().unwrap();
                locks.lock().unwrap().push(file);
            }
        });
    }

    #[test]
    fn files_of_other_origin_are_kept() {
        assert_kept(|folder| {
            for name in [".streakcast-policy.toml", ".streakcast-token", ".streakcast-a.part"] {
                fs::write(folder.join(name), "mine").unwrap();
            }
            drop(make_folder(&folder.join(".streakcast-settings"), ""));
            drop(make_folder(&folder.join(".streakcast-copy"), MARKER));
            drop(make_folder(&folder.join(NAMES[0]), "lock of another program"));
            drop(make_folder(&folder.join(NAMES[1]), &MARKER.repeat(2)));
            drop(make_folder(&folder.join(NAMES[2]), ""));
            fs::write(folder.join(NAMES[2]).join("mine"), "mine").unwrap();
            fs::create_dir(folder.join(NAMES[3])).unwrap();
            fs::write(folder.join(NAMES[3]).join("mine"), "mine").unwrap();
        });
    }

    #[test]
    fn links_are_neither_removed_nor_followed() {
        let outside = tempfile::tempdir().unwrap();
        fs::write(outside.path().join("mine"), "mine").unwrap();
        drop(make_folder(&outside.path().join("folder"), MARKER));
        assert_kept(|folder| {
            symlink(outside.path().join("mine"), folder.join(NAMES[0])).unwrap();
            symlink(outside.path().join("folder"), folder.join(NAMES[1])).unwrap();
            fs::create_dir(folder.join(NAMES[2])).unwrap();
            symlink(outside.path().join("folder").join(LOCK), folder.join(NAMES[2]).join(LOCK)).unwrap();
        });
        assert_eq!(names(outside.path()).len(), 2);
        // A link inside an abandoned folder keeps this folder.
        let folder = tempfile::tempdir().unwrap();
        let scratch = folder.path().join(NAMES[0]);
        drop(make_folder(&scratch, MARKER));
        symlink(outside.path(), scratch.join("link")).unwrap();
        remove_abandoned(folder.path());
        assert_eq!(names(outside.path()).len(), 2);
        assert!(scratch.join("link").is_symlink());
    }
}
