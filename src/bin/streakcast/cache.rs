//! Cache of downloaded element sets. Next to each file there is a sidecar file (JSON) with its provenance and the time
//! from which the next request is allowed.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use serde::{Deserialize, Serialize};

/// Folder of this program in the cache folder of the system.
const CACHE_FOLDER: &str = "streakcast";
/// Suffix of the names of sidecar files.
const SIDECAR: &str = ".fetch.json";

/// Sidecar of a cached file: its provenance, and the last response of its source.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FetchRecord {
    pub source: String,
    pub url: String,
    pub policy: String,
    /// Time of the download; `None` before the first one.
    pub fetched_utc: Option<String>,
    /// SHA-256 of the file, in hexadecimal digits.
    pub sha256: Option<String>,
    pub bytes: Option<u64>,
    pub format: Option<String>,
    pub records: Option<usize>,
    pub rejected: Option<usize>,
    pub first_epoch_utc: Option<String>,
    pub last_epoch_utc: Option<String>,
    pub etag: Option<String>,
    pub last_modified: Option<String>,
    /// Time of the last request.
    pub asked_utc: Option<String>,
    /// Description of the response; `no response yet` until it arrives.
    pub answer: Option<String>,
    /// Time from which the next request is allowed.
    pub not_before_utc: Option<String>,
}

impl FetchRecord {
    pub fn sidecar_path(file: &Path) -> PathBuf {
        let mut name = file.file_name().unwrap_or_default().to_os_string();
        name.push(SIDECAR);
        file.with_file_name(name)
    }

    /// Reads the sidecar of a file; `None` if it is missing or unreadable, in which case the next download replaces it.
    pub fn read(file: &Path) -> Option<Self> {
        serde_json::from_slice(&streakcast::input::read(&Self::sidecar_path(file)).ok()?).ok()
    }
}

/// Returns the given folder, or else the cache folder of the system.
pub fn cache_folder(given: Option<&Path>) -> anyhow::Result<PathBuf> {
    match given {
        Some(folder) => Ok(folder.to_owned()),
        None => etcetera::base_strategy::choose_native_strategy()
            .map(|system| etcetera::BaseStrategy::cache_dir(&system).join(CACHE_FOLDER))
            .map_err(|_| anyhow!("missing cache folder, which this system does not have; specify --cache FOLDER")),
    }
}

/// Returns the sidecars in a folder with the paths of their files, sorted by path. If all requests failed, the file is
/// missing.
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
