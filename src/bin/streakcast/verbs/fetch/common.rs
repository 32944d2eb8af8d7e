//! Common parts of all sources of `fetch`: time of the request, cache folder, limits.

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::config::parse_duration_s;
use streakcast::frames::parse_moment;

use super::arguments::CommonFetchArguments;
use super::request::RequestOptions;
use crate::cache::cache_folder;

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
