//! `fetch starlink-ephemerides`: downloads the newest public ephemerides of chosen satellites. The ephemerides of all
//! Starlink satellites have 22 GB; those of the candidates of a schedule are a few hundred files of 2 MB each.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::input::{self, TableRows};
use streakcast::output::{counted, format_utc, write_atomically};

use super::arguments::StarlinkEphemeridesArguments;
use super::common::{folder_of, lock, now_of, options};
use super::request::{RequestOptions, Response, Validators, send};
use super::sources::Source;
use super::verify::{first_words, retry_after_s, verify};
use crate::cache::FetchRecord;
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::cannot_print;

/// Description of a response that contains a file.
const OK: &str = "200 OK";
/// Columns with NORAD catalogue numbers in the tables of `flag` and `passes`.
const COLUMNS: [&str; 2] = ["norad_ids", "norad_id"];

/// Downloads the manifest (the list of files), unless the cached one is recent, and the files that are not in the
/// cache.
///
/// # Errors
/// No satellite or too many are given, or there is no manifest, or a file is refused or invalid. After a refused or
/// invalid file no more requests are sent within the waiting time of the source. Files that were already downloaded
/// stay in the cache, and a later run downloads the others.
pub fn run(typed: &StarlinkEphemeridesArguments, manifest: &Source) -> anyhow::Result<Outcome> {
    let common = &typed.common;
    let notices = Notices::new(common.quiet);
    let (options, now, folder) = (options(common)?, now_of(common)?, folder_of(common)?);
    let wanted = satellites(typed)?;
    notices.info(&format!("source of {}: {}", manifest.name, manifest.policy));

    let _lock = lock(&folder, manifest, options.timeout)?;
    let session = Session { manifest, options: &options, now, folder: &folder };
    let newest = newest_files(&session.manifest_text()?);
    let found: Vec<&str> = wanted.iter().filter_map(|norad_id| Some(newest.get(norad_id)?.name.as_str())).collect();
    let new: Vec<&str> = found.iter().copied().filter(|name| !folder.join(name).is_file()).collect();
    if !new.is_empty() {
        session.check_wait()?;
    }
    for (number, name) in new.iter().enumerate() {
        session.download(name).map_err(|error| {
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
        writeln!(out, "{}", folder.join(name).display()).map_err(|error| cannot_print("the paths of files", error))?;
    }
    Ok(Outcome::Done)
}

/// Ephemeris file listed in the manifest.
struct Listed {
    name: String,
    /// Number in the file name that increases with time.
    number: u64,
}

/// Returns the newest file of each satellite. Names have the form
/// `MEME_48430_STARLINK-2729_0291124_Operational_1359285900_UNCLASSIFIED.txt`.
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

/// Requests of one run; all have the same time stamp.
struct Session<'a> {
    manifest: &'a Source,
    options: &'a RequestOptions,
    now: Epoch,
    folder: &'a Path,
}

/// Failed request.
enum Failure {
    /// The server received the request, so the waiting time starts. The server may have stated a longer one.
    Refused { error: anyhow::Error, retry_after: Option<String> },
    /// No request was sent.
    Unreached(anyhow::Error),
}

impl Session<'_> {
    /// Returns the path of the cached manifest. Its sidecar records the last request to the source, for the manifest or
    /// for a file.
    fn manifest_file(&self) -> PathBuf {
        self.folder.join(&self.manifest.file)
    }

    /// Returns the cached manifest if it is recent, otherwise that of the server.
    fn manifest_text(&self) -> anyhow::Result<String> {
        let (source, file) = (self.manifest, self.manifest_file());
        let record = FetchRecord::read(&file).unwrap_or_default();
        if record.wait_left_s(self.now, source.wait_s).is_some() {
            match input::read_to_string(&file) {
                Ok(text) => return Ok(text),
                Err(_) => self.check_wait()?,
            }
        }
        let check = |bytes: &[u8]| match newest_files(&String::from_utf8_lossy(bytes)).is_empty() {
            true => Err(anyhow!("{}: the manifest has no ephemerides; {}", source.name, first_words(bytes))),
            false => Ok(FetchRecord::default()),
        };
        let bytes = self.fetch(source, &check)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Returns an error during the waiting time after a request that did not return a valid file.
    fn check_wait(&self) -> anyhow::Result<()> {
        let record = FetchRecord::read(&self.manifest_file()).unwrap_or_default();
        let answer = record.answer.as_deref().unwrap_or_default();
        match record.wait_left_s(self.now, self.manifest.wait_s) {
            Some(left_s) if answer != OK => Err(anyhow!(
                "the last request to {} was at {} ({answer}); the next one is allowed in {:.0} min",
                self.manifest.name,
                record.asked_utc.as_deref().unwrap_or_default(),
                (left_s / 60.0).ceil()
            )),
            _ => Ok(()),
        }
    }

    /// Downloads a file from the folder of the manifest, and stores it if it is a valid ephemeris.
    fn download(&self, name: &str) -> anyhow::Result<()> {
        let base = self.manifest.url.rsplit_once('/').map_or("", |(base, _)| base);
        let source = Source { file: name.to_owned(), url: format!("{base}/{name}"), login: None, ..*self.manifest };
        let check = |bytes: &[u8]| Ok(FetchRecord::default().with_contents(&verify(name, bytes, None, true)?));
        self.fetch(&source, &check).map(|_| ())
    }

    /// Sends one request. If `check` accepts the response, it is stored with the record that `check` returns. The
    /// sidecars of the file and of the manifest record the request before it is sent, and also a refusal, so that no
    /// further request is sent within the waiting time.
    fn fetch(&self, source: &Source, check: &dyn Fn(&[u8]) -> anyhow::Result<FetchRecord>) -> anyhow::Result<Vec<u8>> {
        let (file, of_all) = (self.folder.join(&source.file), self.manifest_file());
        let before = [&file, &of_all].map(|path| FetchRecord::read(path));
        // Other fields of existing records are kept.
        let stamp = |answer: &str, wait_s: f64| -> anyhow::Result<()> {
            for (path, before) in [&file, &of_all].into_iter().zip(&before) {
                let mut record = before.clone().unwrap_or_default();
                record.source = self.manifest.name.to_owned();
                record.policy = self.manifest.policy.to_owned();
                record.url = if *path == of_all { self.manifest.url.clone() } else { source.url.clone() };
                record.stamp(self.now, wait_s, answer);
                record.write(path)?;
            }
            Ok(())
        };
        stamp("no response yet", source.wait_s)?;
        let response = download(source, self.options);
        let stored = response.and_then(|bytes| {
            let record = check(&bytes).map_err(|error| Failure::Refused { error, retry_after: None })?;
            Ok((bytes, record))
        });
        let restore = || -> anyhow::Result<()> {
            for (path, before) in [&file, &of_all].into_iter().zip(&before) {
                match before {
                    Some(before) => before.write(path)?,
                    // If the manifest itself was requested, both paths are the same, and the sidecar may already be
                    // removed.
                    None if FetchRecord::sidecar_path(path).is_file() => FetchRecord::remove(path)?,
                    None => {}
                }
            }
            Ok(())
        };
        let (bytes, record) = match stored {
            Ok(stored) => stored,
            Err(Failure::Unreached(error)) => {
                restore()?;
                return Err(anyhow!("{error}; no request was sent; you may retry now"));
            }
            Err(Failure::Refused { error, retry_after }) => {
                let wait_s = source.wait_s.max(retry_after_s(retry_after.as_deref(), self.now).unwrap_or(0.0));
                stamp(&error.to_string(), wait_s)?;
                let wait_min = (wait_s / 60.0).ceil();
                return Err(anyhow!("{error}; next request allowed in {wait_min:.0} min"));
            }
        };
        restore()?;
        write_atomically(&file, |out| out.write_all(&bytes))
            .map_err(|error| anyhow!("cannot write {}: {error}", file.display()))?;
        let mut record = FetchRecord {
            source: source.name.to_owned(),
            url: source.url.clone(),
            policy: source.policy.to_owned(),
            fetched_utc: Some(format_utc(self.now, 0)),
            bytes: Some(bytes.len() as u64),
            ..record
        };
        record.stamp(self.now, source.wait_s, OK);
        record.write(&file)?;
        Ok(bytes)
    }
}

fn download(source: &Source, options: &RequestOptions) -> Result<Vec<u8>, Failure> {
    let url = &source.url;
    match send(source, options, &Validators::default(), None) {
        Response::Data { bytes, .. } => Ok(bytes),
        Response::NotModified => {
            Err(Failure::Refused { error: anyhow!("{url}: 304 without a condition"), retry_after: None })
        }
        Response::Refused { message, retry_after } => {
            Err(Failure::Refused { error: anyhow!("{url}: {message}"), retry_after })
        }
        Response::Unreached(message) => Err(Failure::Unreached(anyhow!("{url}: {message}"))),
    }
}

/// Returns the catalogue numbers given as flags and in tables.
fn satellites(typed: &StarlinkEphemeridesArguments) -> anyhow::Result<BTreeSet<u32>> {
    let mut wanted: BTreeSet<u32> = typed.norad.iter().copied().collect();
    for path in &typed.candidates {
        let failed = |error: std::io::Error| anyhow!("candidates {}: {error}", path.display());
        let table = TableRows::open(path).map_err(failed)?;
        let [ids, id] = COLUMNS;
        let column = table.column(ids, "a table of flag or passes");
        let column = column.or_else(|missing| table.find(id).ok_or(missing)).map_err(failed)?;
        for row in table {
            let row = row.map_err(failed)?;
            let numbers = row.text(column).split(|c: char| !c.is_ascii_digit());
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
