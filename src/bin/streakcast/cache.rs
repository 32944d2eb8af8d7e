//! The cache of fetched elements: what is kept beside a file of it, where that came from, and when its source may be asked again.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use serde::{Deserialize, Serialize};

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
