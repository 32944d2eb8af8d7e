//! Steps of a download: check and record the time of the request, send it, verify the response, replace the cached
//! file.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::frames::parse_moment;
use streakcast::output::{format_utc, write_atomically};

use super::arguments::{FetchArguments, FetchSource};
use super::common::{folder_of, lock, now_of, options};
use super::days::{folder_of_days, keep};
use super::ephemerides;
use super::request::{Credentials, Response, Validators, send};
use super::sources::Source;
use super::verify::{retry_after_s, verify};
use crate::cache::FetchRecord;
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::cannot_print;

pub fn run(typed: &FetchArguments) -> anyhow::Result<Outcome> {
    let common = typed.source.common();
    let notices = Notices::new(common.quiet);
    let source = typed.source.source()?;
    if let FetchSource::StarlinkEphemerides(typed) = &typed.source {
        return ephemerides::run(typed, &source);
    }
    let began = Instant::now();
    let mut options = options(common)?;
    let (now, folder) = (now_of(common)?, folder_of(common)?);
    let file = folder.join(&source.file);
    notices.info(&format!("usage policy of {}: {}", source.name, source.policy));

    let _lock = lock(&folder, &source, options.timeout)?;
    options.timeout = options.timeout.saturating_sub(began.elapsed());
    let before = FetchRecord::read(&file);
    let mut record = before.clone().unwrap_or_default();
    let is_cached = is_intact(&file, &record);
    if let Some(left_s) = record.wait_left_s(now, source.wait_s) {
        check_cached(&file, &record, &source, is_cached, left_s, &notices)?;
        return print_path(&file, &record, typed.source.with_older(), now);
    }
    let credentials = match &typed.source {
        FetchSource::SpaceTrack(typed) => Some(Credentials::from_arguments(typed, &notices)?),
        _ => None,
    };
    let validators = if is_cached {
        Validators { etag: record.etag.clone(), last_modified: record.last_modified.clone() }
    } else {
        // The file was changed or deleted, so the stored HTTP validators do not apply.
        if file.exists() {
            notices
                .warn(&[format!("{} was changed after its download; a complete download replaces it", file.display())]);
        }
        record = FetchRecord { asked_utc: record.asked_utc, ..FetchRecord::default() };
        Validators::default()
    };
    record.source = source.name.to_owned();
    record.url = source.url.clone();
    record.policy = source.policy.to_owned();
    record.stamp(now, source.wait_s, "no response yet");
    record.write(&file)?;

    let (refused, retry_after) = match send(&source, &options, &validators, credentials.as_ref()) {
        Response::NotModified => {
            record.stamp(now, source.wait_s, "304 Not Modified");
            record.write(&file)?;
            notices.info(&format!("{} has no newer data", source.name));
            return print_path(&file, &record, typed.source.with_older(), now);
        }
        Response::Data { bytes, validators } => {
            match verify(&source.file, &bytes, record.records, typed.source.accepts_fewer()) {
                Ok(read) => {
                    write_atomically(&file, |out| out.write_all(&bytes))
                        .map_err(|error| anyhow!("cannot write {}: {error}", file.display()))?;
                    record = FetchRecord {
                        fetched_utc: Some(format_utc(now, 0)),
                        bytes: Some(bytes.len() as u64),
                        etag: validators.etag,
                        last_modified: validators.last_modified,
                        ..record.with_contents(&read)
                    };
                    record.stamp(now, source.wait_s, "200 OK");
                    record.write(&file)?;
                    notices.info(&format!(
                        "{} element sets of {} to {}",
                        read.records,
                        format_utc(read.first_epoch, 0),
                        format_utc(read.last_epoch, 0)
                    ));
                    return print_path(&file, &record, typed.source.with_older(), now);
                }
                Err(error) => (error.to_string(), None),
            }
        }
        Response::Refused { message, retry_after } => (message, retry_after),
        Response::Unreached(message) => {
            // No request was sent: the sidecar is restored, and no waiting time starts.
            match before {
                Some(before) => before.write(&file)?,
                None => FetchRecord::remove(&file)?,
            }
            let kept = if is_cached { format!("; {} is unchanged", file.display()) } else { String::new() };
            return Err(anyhow!("{}: {message}{kept}; no request was sent; you may retry now", source.name));
        }
    };
    let wait_s = source.wait_s.max(retry_after_s(retry_after.as_deref(), now).unwrap_or(0.0));
    record.stamp(now, wait_s, &refused);
    record.write(&file)?;
    let kept = if is_cached { format!("; {} is unchanged", file.display()) } else { String::new() };
    let not_before = record.not_before_utc.unwrap_or_default();
    Err(anyhow!("{}: {refused}{kept}; next request allowed from {not_before}", source.name))
}

/// Returns true if the file has the SHA-256 stored in its sidecar.
fn is_intact(file: &Path, record: &FetchRecord) -> bool {
    let Ok(bytes) = streakcast::input::read(file) else { return false };
    verify("", &bytes, None, true).is_ok_and(|source| Some(source.sha256) == record.sha256)
}

/// Checks that the cached file can be used if no new request is allowed yet.
fn check_cached(
    file: &Path,
    record: &FetchRecord,
    source: &Source,
    is_cached: bool,
    left_s: f64,
    notices: &Notices,
) -> anyhow::Result<()> {
    let time = record.asked_utc.as_deref().unwrap_or_default();
    let answer = record.answer.as_deref().unwrap_or_default();
    let rest = format!(
        "the last request to {} was at {time} ({answer}); the next one is allowed in {:.0} min",
        source.name,
        (left_s / 60.0).ceil()
    );
    if !is_cached && file.exists() {
        return Err(anyhow!("{rest}; {} was changed after its download and is not used", file.display()));
    }
    if !is_cached {
        return Err(anyhow!("{rest}; no file is cached"));
    }
    let is_good = answer.starts_with("200") && answer.ends_with("OK") || answer.starts_with("304");
    let fetched = record.fetched_utc.as_deref().unwrap_or_default();
    if is_good {
        notices.info(&format!("{rest}; using the cached file of {fetched}"));
    } else {
        notices.warn(&[format!("{rest}; using the cached file of {fetched}")]);
    }
    Ok(())
}

/// Prints only the path on standard output, for use as `--elements "$(streakcast fetch ...)"`: that of the cached file,
/// or of the folder with those of earlier days. The cached file is added to the folder if it is not in it yet.
fn print_path(file: &Path, record: &FetchRecord, with_older: Option<bool>, now: Epoch) -> anyhow::Result<Outcome> {
    if with_older.is_some() {
        let fetched = record.fetched_utc.as_deref().and_then(|text| parse_moment(text, None).ok()).unwrap_or(now);
        let bytes =
            streakcast::input::read(file).map_err(|error| anyhow!("cannot read {}: {error}", file.display()))?;
        keep(file, &bytes, fetched)?;
    }
    let path = if with_older == Some(true) { folder_of_days(file) } else { file.to_owned() };
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", path.display()).map_err(|error| cannot_print("the path of the file", error))?;
    Ok(Outcome::Done)
}
