//! Reload of element files that change while the server runs.

use std::fs::metadata;
use std::path::PathBuf;
use std::sync::{Arc, PoisonError, RwLock};
use std::thread;
use std::time::{Duration, SystemTime};

use crate::notices::Notices;

/// Interval between two checks of the files.
const EVERY: Duration = Duration::from_secs(2);

/// Time of the last change and length of each file; `None` for a missing one.
type Marks = Vec<Option<(SystemTime, u64)>>;

/// Files, and the state that is loaded from them.
pub struct Reload {
    files: Vec<PathBuf>,
    /// Marks of the files from which the state was loaded.
    loaded: Marks,
    /// Marks at the last check.
    seen: Marks,
}

impl Reload {
    /// Records the state of the files. This must precede the first load, so that no change is missed.
    pub fn new(files: Vec<PathBuf>) -> Self {
        let loaded = marks(&files);
        Self { files, seen: loaded.clone(), loaded }
    }

    /// Returns true once after each change. A file that has changed since the last check may be incomplete, so that it
    /// is not yet used.
    fn is_due(&mut self) -> bool {
        let now = marks(&self.files);
        let is_settled = now == self.seen;
        self.seen = now;
        let is_due = is_settled && self.seen != self.loaded;
        if is_due {
            self.loaded.clone_from(&self.seen);
        }
        is_due
    }

    /// Loads the state again after each change, in a thread of its own. If that fails, or if the new state has less
    /// than half of the `satellites`, the previous state stays in use.
    pub fn start<T: Send + Sync + 'static>(
        mut self,
        current: Arc<RwLock<Arc<T>>>,
        load: impl Fn(&Notices) -> anyhow::Result<T> + Send + 'static,
        satellites: impl Fn(&T) -> usize + Send + 'static,
        notices: Notices,
    ) {
        if self.files.is_empty() {
            return;
        }
        thread::spawn(move || {
            loop {
                thread::sleep(EVERY);
                if !self.is_due() {
                    continue;
                }
                let before = satellites(&current.read().unwrap_or_else(PoisonError::into_inner));
                // A file that was cut off may be valid.
                let checked = load(&notices).and_then(|state| match satellites(&state) {
                    count if 2 * count < before => Err(anyhow::anyhow!(
                        "{count} satellites, less than half of the {before} before; if that is right, start serve again"
                    )),
                    _ => Ok(state),
                });
                match checked {
                    Ok(state) => {
                        *current.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(state);
                        notices.info("element files have changed and were loaded again");
                    }
                    Err(error) => notices.warn(&[format!(
                        "element files have changed, but cannot be used; the previous ones stay in use: {error}"
                    )]),
                }
            }
        });
    }
}

fn marks(files: &[PathBuf]) -> Marks {
    let mark = |path: &PathBuf| {
        let found = metadata(path).ok()?;
        Some((found.modified().ok()?, found.len()))
    };
    files.iter().map(mark).collect()
}

#[cfg(test)]
mod tests {
    use std::fs::{remove_file, write};

    use super::*;

    #[test]
    fn a_change_is_due_once_after_it_has_settled() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("elements.tle");
        write(&file, "1").unwrap();
        let mut reload = Reload::new(vec![file.clone()]);
        let mut due = || [(); 3].map(|()| reload.is_due());
        assert_eq!(due(), [false; 3]);
        write(&file, "12").unwrap();
        assert_eq!(due(), [false, true, false]);
        remove_file(&file).unwrap();
        assert_eq!(due(), [false, true, false]);
        write(&file, "123").unwrap();
        assert!(!reload.is_due(), "the file may be incomplete");
        write(&file, "1234").unwrap();
        assert_eq!([(); 3].map(|()| reload.is_due()), [false, true, false]);
    }
}
