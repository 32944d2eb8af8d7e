//! `fetch starlink-ephemerides`: the newest public ephemerides of chosen satellites. A whole set has 22 GB; candidates of
//! a schedule are some hundred files of 2 MB.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::output::{counted, format_utc, write_atomically};

use super::arguments::StarlinkEphemeridesArguments;
use super::common::{folder_of, now_of, options};
use super::request::{RequestOptions, Response, Validators, send};
use super::sources::Source;
use super::verify::{first_words, verify};
use crate::cache::FetchRecord;
use crate::failure::Outcome;
use crate::notices::Notices;

/// Columns with NORAD catalogue numbers in the tables of `flag` and `passes`.
const COLUMNS: [&str; 2] = ["norad_ids", "norad_id"];

/// Downloads the manifest, unless it is recent, and the files of the satellites that are not in the cache.
///
/// # Errors
/// No satellite or too many; no manifest; a refused or invalid file, after which no more requests are sent. Files that
/// were downloaded before stay in the cache, and a repetition continues with the others.
pub fn run(typed: &StarlinkEphemeridesArguments, manifest: &Source) -> anyhow::Result<Outcome> {
    let common = &typed.common;
    let notices = Notices::new(common.quiet);
    let (options, now, folder) = (options(common)?, now_of(common)?, folder_of(common)?);
    let wanted = satellites(typed)?;
    notices.info(&format!("source of {}: {}", manifest.name, manifest.policy));

    // Only one process at a time sends requests.
    let lock_path = folder.join(format!("{}.lock", manifest.file));
    let lock = File::create(&lock_path).map_err(|error| anyhow!("cache {}: {error}", lock_path.display()))?;
    lock.lock().map_err(|error| anyhow!("cache {}: {error}", lock_path.display()))?;

    let newest = newest_files(&manifest_text(manifest, &options, now, &folder)?);
    let found: Vec<&str> = wanted.iter().filter_map(|norad_id| Some(newest.get(norad_id)?.name.as_str())).collect();
    let new: Vec<&str> = found.iter().copied().filter(|name| !folder.join(name).is_file()).collect();
    for (number, name) in new.iter().enumerate() {
        download(name, manifest, &options, now, &folder).map_err(|error| {
            anyhow!("{error}; {number} of {} files were downloaded and are in the cache", new.len())
        })?;
    }
    notices.info(&format!(
        "{} of {} with ephemerides; {} downloaded, {} in the cache before",
        found.len(),
        counted(wanted.len(), "satellite", "satellites"),
        new.len(),
        found.len() - new.len()
    ));
    if found.is_empty() {
        return Err(anyhow!(
            "{}: none of the satellites has an ephemeris; allowed: numbers of Starlinks",
            manifest.name
        ));
    }
    let mut out = std::io::stdout().lock();
    for name in found {
        writeln!(out, "{}", folder.join(name).display())?;
    }
    Ok(Outcome::Done)
}

/// File of an ephemeris in the manifest.
struct Listed {
    name: String,
    /// Time of the file, which increases from one to the next.
    number: u64,
}

/// Returns the newest file of each satellite: `MEME_48430_STARLINK-2729_0291124_Operational_1359285900_UNCLASSIFIED.txt`.
fn newest_files(manifest: &str) -> BTreeMap<u32, Listed> {
    let mut newest: BTreeMap<u32, Listed> = BTreeMap::new();
    for name in manifest.split_whitespace() {
        let is_plain = name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-.".contains(&byte));
        let fields: Vec<&str> = name.split('_').collect();
        let (Some(&"MEME"), Some(Ok(norad_id)), true) =
            (fields.first(), fields.get(1).map(|field| field.parse()), is_plain)
        else {
            continue;
        };
        let number = fields.get(5).and_then(|field| field.parse().ok()).unwrap_or(0);
        if newest.get(&norad_id).is_none_or(|other| number >= other.number) {
            newest.insert(norad_id, Listed { name: name.to_owned(), number });
        }
    }
    newest
}

/// Returns the manifest of the cache if it is recent, otherwise of the server.
fn manifest_text(source: &Source, options: &RequestOptions, now: Epoch, folder: &Path) -> anyhow::Result<String> {
    let file = folder.join(&source.file);
    let mut record = FetchRecord::read(&file).unwrap_or_default();
    if record.wait_left_s(now, source.wait_s).is_some()
        && let Ok(text) = fs::read_to_string(&file)
    {
        return Ok(text);
    }
    let bytes = answer(source, options)?;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    if newest_files(&text).is_empty() {
        return Err(anyhow!("{}: the manifest has no ephemerides; {}", source.name, first_words(&bytes)));
    }
    write_atomically(&file, |out| out.write_all(&bytes))
        .map_err(|error| anyhow!("cannot write {}: {error}", file.display()))?;
    record = FetchRecord {
        source: source.name.to_owned(),
        url: source.url.clone(),
        policy: source.policy.to_owned(),
        fetched_utc: Some(format_utc(now, 0)),
        bytes: Some(bytes.len() as u64),
        ..FetchRecord::default()
    };
    record.stamp(now, source.wait_s, "200 OK");
    record.write(&file)?;
    Ok(text)
}

/// Downloads a file beside the manifest, and stores it if it is a valid ephemeris.
fn download(name: &str, manifest: &Source, options: &RequestOptions, now: Epoch, folder: &Path) -> anyhow::Result<()> {
    let base = manifest.url.rsplit_once('/').map_or("", |(base, _)| base);
    let source = Source { file: name.to_owned(), url: format!("{base}/{name}"), login: None, ..*manifest };
    let bytes = answer(&source, options)?;
    let read = verify(name, &bytes, None, true)?;
    let file = folder.join(name);
    write_atomically(&file, |out| out.write_all(&bytes))
        .map_err(|error| anyhow!("cannot write {}: {error}", file.display()))?;
    let mut record = FetchRecord {
        source: source.name.to_owned(),
        url: source.url.clone(),
        policy: source.policy.to_owned(),
        fetched_utc: Some(format_utc(now, 0)),
        sha256: Some(read.sha256),
        bytes: Some(bytes.len() as u64),
        format: Some(read.format.to_string()),
        records: Some(read.records),
        rejected: Some(read.rejected),
        first_epoch_utc: Some(format_utc(read.first_epoch, 3)),
        last_epoch_utc: Some(format_utc(read.last_epoch, 3)),
        ..FetchRecord::default()
    };
    record.stamp(now, source.wait_s, "200 OK");
    record.write(&file)
}

fn answer(source: &Source, options: &RequestOptions) -> anyhow::Result<Vec<u8>> {
    match send(source, options, &Validators::default(), None) {
        Response::Data { bytes, .. } => Ok(bytes),
        Response::NotModified => Err(anyhow!("{}: 304 without a condition", source.url)),
        Response::Refused(message) | Response::Unreached(message) => Err(anyhow!("{}: {message}", source.url)),
    }
}

/// Returns the numbers of the satellites given as numbers and in tables.
fn satellites(typed: &StarlinkEphemeridesArguments) -> anyhow::Result<BTreeSet<u32>> {
    let mut wanted: BTreeSet<u32> = typed.norad.iter().copied().collect();
    for path in &typed.candidates {
        let fail = |error: csv::Error| anyhow!("candidates {}: {error}", path.display());
        let mut table = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).map_err(fail)?;
        let columns = table.headers().map_err(fail)?.clone();
        let column =
            COLUMNS.iter().find_map(|name| columns.iter().position(|column| column == *name)).ok_or_else(|| {
                anyhow!(
                    "candidates {}: the column norad_ids is missing; allowed: a CSV table of flag or passes",
                    path.display()
                )
            })?;
        for row in table.records() {
            let row = row.map_err(fail)?;
            let numbers = row.get(column).unwrap_or_default().split(|c: char| !c.is_ascii_digit());
            wanted.extend(numbers.filter_map(|number| number.parse::<u32>().ok()));
        }
    }
    if wanted.is_empty() || wanted.len() > typed.max_satellites {
        return Err(anyhow!(
            "the number of satellites is {}; allowed: 1 to {} (--max-satellites)",
            wanted.len(),
            typed.max_satellites
        ));
    }
    Ok(wanted)
}
