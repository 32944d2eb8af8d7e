//! Lock of a folder, for files that are read and then replaced.

use std::fs::File;
use std::path::Path;
use std::time::Duration;

/// Locks a folder until the result is dropped, and waits up to `longest` for other processes. `None` if the folder
/// cannot be locked, as on Windows, or another process keeps it locked.
#[cfg(unix)]
pub fn lock_folder(path: &Path, longest: Duration) -> Option<File> {
    use rustix::fs::{Mode, OFlags, open};
    use std::fs::TryLockError;

    const PAUSE: Duration = Duration::from_millis(5);
    let folder = File::from(open(path, OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty()).ok()?);
    for _ in 0..=longest.as_millis() / PAUSE.as_millis() {
        match folder.try_lock() {
            Ok(()) => return Some(folder),
            Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
            Err(TryLockError::Error(_)) => return None,
        }
    }
    None
}

/// Locks no folder on systems other than Unix.
#[cfg(not(unix))]
pub fn lock_folder(_: &Path, _: Duration) -> Option<File> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_locked_by_one_holder_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let first = lock_folder(folder.path(), Duration::ZERO);
        assert!(first.is_some());
        assert!(lock_folder(folder.path(), Duration::ZERO).is_none());
        drop(first);
        assert!(lock_folder(folder.path(), Duration::ZERO).is_some());
        assert!(lock_folder(&folder.path().join("missing"), Duration::ZERO).is_none());
    }
}
