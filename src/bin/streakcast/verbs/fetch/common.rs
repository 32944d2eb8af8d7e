//! Common parts of all sources of `fetch`: time of the request, cache folder, limits.

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::config::parse_duration_s;
use streakcast::frames::parse_moment;
use streakcast::input;

use super::arguments::CommonFetchArguments;
use super::request::RequestOptions;
use super::sources::Source;
use crate::cache::{FetchRecord, cache_folder};

/// Interval between two attempts to lock a cached file.
const LOCK_EVERY: Duration = Duration::from_millis(50);

/// Returns the time of the request.
pub(super) fn now_of(common: &CommonFetchArguments) -> anyhow::Result<Epoch> {
    Ok(match &common.now {
        Some(now) => parse_moment(now, None)?,
        None => crate::clock::now(),
    })
}

/// Returns the cache folder, and creates it if it is missing.
pub(super) fn folder_of(common: &CommonFetchArguments) -> anyhow::Result<PathBuf> {
    let folder = cache_folder(common.cache.as_deref())?;
    fs::create_dir_all(&folder).map_err(|error| match folder.is_dir() || !folder.exists() {
        true => anyhow!("cache {}: {error}; allowed: a writable folder", folder.display()),
        false => anyhow!("cache {} is a file; allowed: a folder, or the name of a new one", folder.display()),
    })?;
    Ok(folder)
}

/// Returns the limits of a request.
pub(super) fn options(common: &CommonFetchArguments) -> anyhow::Result<RequestOptions> {
    let timeout_s = parse_duration_s("timeout", &common.timeout)?;
    if !(0.1..=3_600.0).contains(&timeout_s) {
        return Err(anyhow!("timeout is {timeout_s} s; allowed: 0.1 to 3600 s"));
    }
    Ok(RequestOptions {
        timeout: Duration::from_secs_f64(timeout_s),
        max_bytes: common.max_bytes,
        plain: common.base_url.is_some(),
    })
}

/// Locks a cached file, so that several processes do not send simultaneous requests. The lock ends when the returned
/// file is closed.
///
/// # Errors
/// Another process holds the lock for longer than `timeout`, or the cached file, its sidecar or the lock is a named
/// pipe, a device or a directory.
pub(super) fn lock(folder: &Path, source: &Source, timeout: Duration) -> anyhow::Result<File> {
    let (began, file) = (Instant::now(), folder.join(&source.file));
    let path = folder.join(format!("{}.lock", source.file));
    let failed = |path: &Path, error| anyhow!("cache {}: {error}", path.display());
    for path in [&file, &FetchRecord::sidecar_path(&file)] {
        match input::check_regular(path) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(failed(path, error)),
            _ => {}
        }
    }
    // Neither call waits if the name is that of a named pipe.
    match File::create_new(&path) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(failed(&path, error)),
        _ => {}
    }
    let lock = input::open(&path).map_err(|error| failed(&path, error))?;
    loop {
        match lock.try_lock() {
            Ok(()) => return Ok(lock),
            Err(TryLockError::Error(error)) => return Err(failed(&path, error)),
            Err(TryLockError::WouldBlock) if began.elapsed() < timeout => sleep(LOCK_EVERY),
            Err(TryLockError::WouldBlock) => {
                let seconds = timeout.as_secs_f64();
                let path = path.display();
                return Err(anyhow!(
                    "cache {path}: locked by another process for {seconds} s (--timeout); no request was sent"
                ));
            }
        }
    }
}
