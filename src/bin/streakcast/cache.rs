//! The cache of fetched elements: what is kept beside a file of it, where that came from, and when its source may be asked again.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use hifitime::Epoch;
use serde::{Deserialize, Serialize};
use streakcast::frames::seconds_between;
use streakcast::setup::parse_moment;
use streakcast::table::{format_utc, write_atomically};

/// In the system's folder for caches.
const CACHE_FOLDER: &str = "streakcast";
/// The end of a sidecar's name.
const SIDECAR: &str = ".fetch.json";

/// The sidecar of a cached file (JSON): its provenance, and what its source last said.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FetchRecord {
    pub source: String,
    pub url: String,
    pub policy: String,
    /// When the file came; empty where none has yet.
    pub fetched_utc: Option<String>,
    /// Of the bytes in the file, as sha256sum prints it.
    pub sha256: Option<String>,
    pub bytes: Option<u64>,
    pub format: Option<String>,
    pub records: Option<usize>,
    pub rejected: Option<usize>,
    pub first_epoch_utc: Option<String>,
    pub last_epoch_utc: Option<String>,
    pub etag: Option<String>,
    pub last_modified: Option<String>,
    /// When the source was last asked, whatever it said.
    pub asked_utc: Option<String>,
    /// What it said, in words; `asking` while an answer is awaited.
    pub answer: Option<String>,
    /// It is not asked again before.
    pub not_before_utc: Option<String>,
}

impl FetchRecord {
    pub fn path_beside(file: &Path) -> PathBuf {
        let mut name = file.file_name().unwrap_or_default().to_os_string();
        name.push(SIDECAR);
        file.with_file_name(name)
    }

    /// The sidecar of a file; `None` where there is none, or one that cannot be read (which is then written anew).
    pub fn read(file: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(Self::path_beside(file)).ok()?).ok()
    }

    pub fn write(&self, file: &Path) -> anyhow::Result<()> {
        let path = Self::path_beside(file);
        let text = serde_json::to_string_pretty(self)? + "\n";
        write_atomically(&path, |out| out.write_all(text.as_bytes()))
            .map_err(|error| anyhow!("cannot write {}: {error}", path.display()))
    }

    /// Seconds until the source may be asked again; `None` where it may be now. A stamp from the future (a clock that was set back) does not bind for longer
    /// than the wait.
    pub fn wait_left_s(&self, now: Epoch, wait_s: f64) -> Option<f64> {
        let asked = parse_moment(self.asked_utc.as_deref()?, None).ok()?;
        let since_s = seconds_between(asked, now);
        (since_s > -wait_s && since_s < wait_s).then_some(wait_s - since_s)
    }

    /// The stamp of a question, written before it is asked: a crash does not ask again.
    pub fn stamp(&mut self, now: Epoch, wait_s: f64, answer: &str) {
        self.asked_utc = Some(format_utc(now, 0));
        self.answer = Some(answer.to_owned());
        self.not_before_utc = Some(format_utc(streakcast::frames::seconds_after(now, wait_s), 0));
    }
}

/// The folder said, else that of the system.
pub fn cache_folder(said: Option<&Path>) -> anyhow::Result<PathBuf> {
    match said {
        Some(folder) => Ok(folder.to_owned()),
        None => etcetera::base_strategy::choose_native_strategy()
            .map(|system| etcetera::BaseStrategy::cache_dir(&system).join(CACHE_FOLDER))
            .map_err(|_| anyhow!("this system has no folder for caches; say --cache FOLDER")),
    }
}

/// Every file in a cache that has a sidecar, or whose sidecar says why there is none, by name.
pub fn records_in(folder: &Path) -> Vec<(PathBuf, FetchRecord)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<(PathBuf, FetchRecord)> = entries
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let file = folder.join(name.strip_suffix(SIDECAR)?);
            let record = FetchRecord::read(&file)?;
            Some((file, record))
        })
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wait_ends_and_a_clock_that_was_set_back_does_not_bind_for_ever() {
        let now = |text: &str| parse_moment(text, None).unwrap();
        let mut record = FetchRecord::default();
        assert_eq!(record.wait_left_s(now("2024-08-14T00:00:00Z"), 3600.0), None);
        record.stamp(now("2024-08-14T00:00:00Z"), 3600.0, "200");
        assert_eq!(record.wait_left_s(now("2024-08-14T00:10:00Z"), 3600.0), Some(3000.0));
        assert_eq!(record.wait_left_s(now("2024-08-14T01:00:00Z"), 3600.0), None);
        assert_eq!(record.wait_left_s(now("2024-08-10T00:00:00Z"), 3600.0), None);
        assert_eq!(record.not_before_utc.as_deref(), Some("2024-08-14T01:00:00Z"));
    }
}
