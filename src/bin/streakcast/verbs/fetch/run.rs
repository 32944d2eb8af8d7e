//! The order of things: look at the stamp, set it, ask, look at what came, put it in its place.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::time::{Duration, SystemTime};

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::config::parse_duration_s;
use streakcast::frames::parse_moment;
use streakcast::output::{format_utc, write_atomically};

use super::arguments::{CommonFetchArguments, FetchArguments, FetchSource};
use super::ask::Credentials;
use super::ask::{Answer, Known, Manner, ask};
use super::sources::Wanted;
use super::verify::verify;
use crate::cache::{FetchRecord, cache_folder};
use crate::failure::Outcome;
use crate::notices::Notices;

pub fn run(typed: &FetchArguments) -> anyhow::Result<Outcome> {
    let common = typed.source.common();
    let notices = Notices::new(common.quiet);
    let wanted = typed.source.wanted()?;
    let manner = manner(common)?;
    let now = match &common.now {
        Some(now) => parse_moment(now, None)?,
        None => Epoch::from_unix_seconds(
            SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_secs_f64(),
        ),
    };
    let folder = cache_folder(common.cache.as_deref())?;
    fs::create_dir_all(&folder).map_err(|error| match folder.is_dir() || !folder.exists() {
        true => anyhow!("cache {}: {error}; allowed: a folder that can be written to, or made", folder.display()),
        false => anyhow!("cache {}: this is a file; allowed: a folder, or the name of one to make", folder.display()),
    })?;
    let file = folder.join(&wanted.file);
    notices.say(&format!("{} asks its users to keep to {}", wanted.source, wanted.policy));

    // Two at a time would ask twice.
    let lock_path = folder.join(format!("{}.lock", wanted.file));
    let lock = File::create(&lock_path).map_err(|error| anyhow!("cache {}: {error}", lock_path.display()))?;
    lock.lock().map_err(|error| anyhow!("cache {}: {error}", lock_path.display()))?;

    let before = FetchRecord::read(&file);
    let mut record = before.clone().unwrap_or_default();
    let is_there = is_intact(&file, &record);
    if let Some(left_s) = record.wait_left_s(now, wanted.wait_s) {
        return keep_waiting(&file, &record, &wanted, is_there, left_s, &notices);
    }
    let credentials = match &typed.source {
        FetchSource::SpaceTrack(typed) => Some(Credentials::of(typed, &notices)?),
        _ => None,
    };
    let known = if is_there {
        Known { etag: record.etag.clone(), last_modified: record.last_modified.clone() }
    } else {
        // A file that is not what came then says nothing of what there is now.
        record = FetchRecord { asked_utc: record.asked_utc, ..FetchRecord::default() };
        Known::default()
    };
    record.source = wanted.source.to_owned();
    record.url = wanted.url.clone();
    record.policy = wanted.policy.to_owned();
    record.stamp(now, wanted.wait_s, "asking");
    record.write(&file)?;

    let refused = match ask(&wanted, &manner, &known, credentials.as_ref()) {
        Answer::NotModified => {
            record.stamp(now, wanted.wait_s, "304 Not Modified");
            record.write(&file)?;
            notices.say(&format!("{} has nothing newer", wanted.source));
            return told(&file);
        }
        Answer::Came { bytes, known } => match verify(&wanted.file, &bytes, record.records, common.accept_fewer) {
            Ok(source) => {
                write_atomically(&file, |out| out.write_all(&bytes))
                    .map_err(|error| anyhow!("cannot write {}: {error}", file.display()))?;
                record = FetchRecord {
                    fetched_utc: Some(format_utc(now, 0)),
                    sha256: Some(source.sha256.clone()),
                    bytes: Some(bytes.len() as u64),
                    format: Some(source.format.to_string()),
                    records: Some(source.records),
                    rejected: Some(source.rejected),
                    first_epoch_utc: Some(format_utc(source.first_epoch, 3)),
                    last_epoch_utc: Some(format_utc(source.last_epoch, 3)),
                    etag: known.etag,
                    last_modified: known.last_modified,
                    ..record
                };
                record.stamp(now, wanted.wait_s, "200 OK");
                record.write(&file)?;
                notices.say(&format!(
                    "{} element sets of {} to {}",
                    source.records,
                    format_utc(source.first_epoch, 0),
                    format_utc(source.last_epoch, 0)
                ));
                return told(&file);
            }
            Err(error) => error.to_string(),
        },
        Answer::Refused(words) => words,
        Answer::Unreached(words) => {
            // Nobody was asked: what stood beside the file before holds on, and no wait begins.
            match before {
                Some(before) => before.write(&file)?,
                None => FetchRecord::remove(&file)?,
            }
            let kept = if is_there { format!("; {} stays as it was", file.display()) } else { String::new() };
            return Err(anyhow!("{}: {words}{kept}; it was not asked, and may be at once", wanted.source));
        }
    };
    record.stamp(now, wanted.wait_s, &refused);
    record.write(&file)?;
    let kept = if is_there { format!("; {} stays as it was", file.display()) } else { String::new() };
    let not_before = record.not_before_utc.unwrap_or_default();
    Err(anyhow!("{}: {refused}{kept}; not asked again before {not_before}", wanted.source))
}

fn manner(common: &CommonFetchArguments) -> anyhow::Result<Manner> {
    let timeout_s = parse_duration_s("timeout", &common.timeout)?;
    if !(0.1..=3_600.0).contains(&timeout_s) {
        return Err(anyhow!("timeout {timeout_s} s: allowed 0.1 to 3600 s"));
    }
    Ok(Manner {
        timeout: Duration::from_secs_f64(timeout_s),
        max_bytes: common.max_bytes,
        plain: common.base_url.is_some(),
    })
}

/// True where the file is the one that the sidecar tells of.
fn is_intact(file: &Path, record: &FetchRecord) -> bool {
    let Ok(bytes) = fs::read(file) else { return false };
    verify("", &bytes, None, true).is_ok_and(|source| Some(source.sha256) == record.sha256)
}

/// Within the wait: the cached file serves, whatever the source said last.
fn keep_waiting(
    file: &Path,
    record: &FetchRecord,
    wanted: &Wanted,
    is_there: bool,
    left_s: f64,
    notices: &Notices,
) -> anyhow::Result<Outcome> {
    let asked = record.asked_utc.as_deref().unwrap_or_default();
    let answer = record.answer.as_deref().unwrap_or_default();
    let rest = format!(
        "{} was asked for this at {asked} ({answer}) and is not asked again for {:.0} min",
        wanted.source,
        (left_s / 60.0).ceil()
    );
    if !is_there {
        return Err(anyhow!("{rest}; there is no cached file"));
    }
    let is_good = answer.starts_with("200") && answer.ends_with("OK") || answer.starts_with("304");
    let fetched = record.fetched_utc.as_deref().unwrap_or_default();
    if is_good {
        notices.say(&format!("{rest}; the cached file is of {fetched}"));
    } else {
        notices.warn(&[format!("{rest}; the cached file is of {fetched}")]);
    }
    told(file)
}

/// The path alone goes to standard output: `--elements "$(streakcast fetch ...)"`.
fn told(file: &Path) -> anyhow::Result<Outcome> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", file.display())?;
    Ok(Outcome::Done)
}
