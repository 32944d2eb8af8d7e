//! Reads one file: decompression, detection of the format, valid and rejected records.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::read::MultiGzDecoder;
use hifitime::Epoch;
use sha2::{Digest, Sha256};

use super::element_set::ElementSet;
use super::ephemeris::{self, Ephemeris};
use super::record::{ElementFormat, Parsed, Rejected, excerpt};
use super::tle::Checksums;
use super::{omm_csv, omm_json, omm_kvn, omm_xml, tle_file};
use crate::error::Error;
use crate::input;

/// File of element sets or ephemerides, for the provenance of results.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SourceFile {
    /// Name of the file as given.
    pub name: Arc<str>,
    /// SHA-256 of the bytes on disk in lower-case hexadecimal, as printed by `sha256sum`.
    pub sha256: String,
    /// Format of the file.
    pub format: ElementFormat,
    /// True if the file was compressed with gzip.
    pub gzipped: bool,
    /// Number of valid records, including duplicates; in an ephemeris, number of states.
    pub records: usize,
    /// Number of rejected records.
    pub rejected: usize,
    /// True if the last record was rejected: the file may be truncated or incompletely written.
    pub cut_short: bool,
    /// Number of records accepted with a wrong checksum.
    pub bad_checksums_accepted: usize,
    /// Earliest epoch of an element set or state.
    pub first_epoch: Epoch,
    /// Latest epoch of an element set or state.
    pub last_epoch: Epoch,
}

/// Content of one file, with its provenance.
#[derive(Clone)]
pub(super) struct FileReading {
    pub source: SourceFile,
    pub sets: Vec<ElementSet>,
    pub ephemerides: Vec<Arc<Ephemeris>>,
    pub rejected: Vec<Rejected>,
}

/// Returns the paths with folders replaced by the files in them, sorted by name. Subfolders, hidden files and the
/// records and locks of `streakcast fetch` are not read.
pub(super) fn files_of<P: AsRef<Path>>(paths: &[P]) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    for path in paths.iter().map(AsRef::as_ref) {
        if !path.is_dir() {
            files.push(path.to_owned());
            continue;
        }
        let unreadable = |source| Error::cannot("read", path, source);
        let mut found = Vec::new();
        for entry in path.read_dir().map_err(unreadable)? {
            let file = entry.map_err(unreadable)?.path();
            let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if !file.is_dir() && !name.starts_with('.') && !OF_FETCH.iter().any(|end| name.ends_with(end)) {
                found.push(file);
            }
        }
        if found.is_empty() {
            return Err(Error::about_file("the folder", path, "contains no files")
                .allowing("files of element sets, or folders that contain only these"));
        }
        found.sort();
        files.extend(found);
    }
    Ok(files)
}

/// Accepted formats, for error messages.
const ALLOWED: &str =
    "TLE, 2LE, 3LE, OMM (JSON, CSV, XML, KVN), or ephemerides as OEM (KVN, XML) or Modified ITC, plain or gzipped";

/// Reads a file from disk.
pub(super) fn read_file(path: &Path, checksums: Checksums) -> Result<FileReading, Error> {
    let bytes = input::read(path).map_err(|source| Error::cannot("read", path, source))?;
    read_bytes(&path.display().to_string(), &bytes, checksums)
}

/// Reads the content of a file.
pub(super) fn read_bytes(name: &str, bytes: &[u8], checksums: Checksums) -> Result<FileReading, Error> {
    // Hashing and parsing take similar times; they run in parallel.
    let (sha256, content) = rayon::join(|| hex(&Sha256::digest(bytes)), || read_content(name, bytes, checksums));
    let Content { format, gzipped, sets, mut ephemerides, rejected, cut_short, bad_checksums_accepted } = content?;
    let name: Arc<str> = Arc::from(name);
    let rejected: Vec<Rejected> =
        rejected.into_iter().map(|(line, reason)| Rejected { file: name.clone(), line, reason }).collect();
    // All epochs are UTC. Comparing durations avoids conversions with leap seconds.
    let of_states = || ephemerides.iter().flat_map(|ephemeris| ephemeris.states.iter().map(|state| state.epoch));
    let epochs = || sets.iter().map(|set| set.epoch).chain(of_states());
    let duration = |epoch: &Epoch| epoch.duration;
    let (Some(first_epoch), Some(last_epoch)) = (epochs().min_by_key(duration), epochs().max_by_key(duration)) else {
        // Without this error, every exposure would be reported as clear.
        let found = rejected.first().map_or(": it has no records".to_owned(), |first| {
            format!(": {} rejected, the first at line {}: {}", rejected.len(), first.line, first.reason)
        });
        return Err(Error::about_file("", &*name, format!("({format}) contains no valid element set{found}")));
    };
    let source = SourceFile {
        name: name.clone(),
        sha256,
        format,
        gzipped,
        records: epochs().count(),
        rejected: rejected.len(),
        cut_short,
        bad_checksums_accepted,
        first_epoch,
        last_epoch,
    };
    for ephemeris in &mut ephemerides {
        ephemeris.file = name.clone();
    }
    let ephemerides = ephemerides.into_iter().map(Arc::new).collect();
    Ok(FileReading { source, sets, ephemerides, rejected })
}

/// Records of a file, with rejected records by line.
struct Content {
    format: ElementFormat,
    gzipped: bool,
    sets: Vec<ElementSet>,
    ephemerides: Vec<Ephemeris>,
    rejected: Vec<(usize, Error)>,
    cut_short: bool,
    bad_checksums_accepted: usize,
}

fn read_content(name: &str, bytes: &[u8], checksums: Checksums) -> Result<Content, Error> {
    let gzipped = bytes.starts_with(&[0x1f, 0x8b]);
    let unpacked = unpack(name, bytes, input::LARGEST_INPUT)?;
    let decoded = decode(&unpacked);
    let text = String::from_utf8_lossy(&decoded);
    if text.bytes().all(|byte| byte.is_ascii_whitespace() || byte == 0) {
        return Err(Error::about_file("", name, "is empty").allowing(ALLOWED));
    }
    let format = sniff(&decoded, &text)
        .map_err(|what| Error::about_file("", name, format!("contains no element sets ({what})")).allowing(ALLOWED))?;
    let with_name = |problem: ephemeris::Problem| {
        let ephemeris::Problem { line, what, given, allowed } = problem;
        Error::invalid(what, given, allowed).located(format_args!("{name}:{line}"), name, Some(line))
    };
    // A Modified ITC file is not part of another one, because its name has the number of the satellite.
    if format == ElementFormat::ModifiedItc {
        let ephemerides = ephemeris::parse_modified_itc(name, &text).map_err(with_name)?;
        let (sets, rejected) = (Vec::new(), Vec::new());
        return Ok(Content {
            format,
            gzipped,
            sets,
            ephemerides,
            rejected,
            cut_short: false,
            bad_checksums_accepted: 0,
        });
    }
    let first = if format == ElementFormat::OemXml { ElementFormat::OmmXml } else { format };
    let starts = starts_of_parts(&text, first);
    let ends = starts.iter().skip(1).map(|(start, _)| *start).chain([text.len()]);
    let mut ephemerides = Vec::new();
    let mut parts = Vec::with_capacity(starts.len());
    for ((start, format), end) in starts.iter().zip(ends) {
        let part = &text[*start..end];
        // A CCSDS navigation data message (NDM) may contain both OMM and OEM messages.
        let found = match format {
            ElementFormat::OemKvn if ephemeris::looks_like_oem_kvn(part) => Some(ephemeris::parse_oem_kvn(part)),
            ElementFormat::OmmXml if ephemeris::looks_like_oem_xml(part) => Some(ephemeris::parse_oem_xml(part)),
            _ => None,
        };
        let has_ephemerides = found.is_some();
        if let Some(found) = found {
            let lines_before = text[..*start].matches('\n').count();
            let of_file = |problem: ephemeris::Problem| {
                with_name(ephemeris::Problem { line: lines_before + problem.line, ..problem })
            };
            ephemerides.extend(found.map_err(of_file)?);
        }
        let parsed = match format {
            ElementFormat::OmmJson => omm_json::parse(part, checksums),
            ElementFormat::OmmCsv => omm_csv::parse(part, checksums),
            ElementFormat::OmmXml => omm_xml::parse(part, checksums),
            ElementFormat::OmmKvn => omm_kvn::parse(part),
            ElementFormat::OemKvn if has_ephemerides => Parsed::default(),
            _ => tle_file::parse(part, checksums),
        };
        parts.push((*start, parsed));
    }
    let mut parsed = Parsed::joined(parts);
    parsed.rejected.sort_by_key(|(offset, _)| *offset);
    let cut_short = parsed.is_cut_short();
    let Parsed { sets, rejected, bad_checksums_accepted, .. } = parsed;
    let rejected = line_numbers(text.as_bytes(), rejected);
    Ok(Content { format, gzipped, sets, ephemerides, rejected, cut_short, bad_checksums_accepted })
}

/// Returns the offset and the format of each part of a text of several concatenated files. `first` is the format of the
/// first line with content.
fn starts_of_parts(text: &str, first: ElementFormat) -> Vec<(usize, ElementFormat)> {
    let mut starts = vec![(0, first)];
    // Millions of lines of TLEs are searched only for other forms.
    const OTHERS: [&str; 5] = ["MEAN_MOTION", "TLE_LINE1", ephemeris::OEM_KVN_OPENING, "<oem", ":oem"];
    if first == ElementFormat::Tle && !OTHERS.iter().any(|keyword| text.contains(keyword)) {
        return starts;
    }
    let (mut at, mut before, mut is_open) = (0, None, false);
    let mut current = first;
    for line in text.split_inclusive(['\n', '\r']) {
        let offset = at;
        at += line.len();
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let found = format_started_by(line).unwrap_or(current);
        // Tables with other titles have their own columns.
        let has_titles = found == ElementFormat::OmmCsv && before.is_some() && omm_csv::looks_like(line);
        // Comments may be before the keyword that opens the first message.
        let opens = ephemeris::opens_oem_kvn(line);
        let is_next_message = found == ElementFormat::OemKvn && opens && is_open;
        is_open = opens || is_open && found == current;
        if found != current || has_titles || is_next_message {
            // The name of a satellite is in the line before.
            let name = before.filter(|(_, line): &(usize, &str)| !line.contains(['<', '>', '{', '}', '=', ',', '"']));
            let name = name.filter(|(_, line)| found == ElementFormat::Tle && *line != "]");
            let name = name.filter(|(_, line)| current != ElementFormat::OemKvn || !ephemeris::closes_oem_kvn(line));
            starts.push((name.map_or(offset, |(name_at, _)| name_at), found));
            current = found;
        }
        before = Some((offset, line));
    }
    starts
}

/// Returns the format of which a line is the first; `None` for the following lines of JSON and other lines.
fn format_started_by(line: &str) -> Option<ElementFormat> {
    match line.as_bytes() {
        [b'<', ..] if line.starts_with("<?xml") || line.starts_with("<ndm") || omm_xml::looks_like(line) => {
            Some(ElementFormat::OmmXml)
        }
        [b'<', ..] if ephemeris::looks_like_oem_xml(line) => Some(ElementFormat::OmmXml),
        [b'{' | b'[', rest @ ..] => {
            matches!(rest.trim_ascii_start(), [] | [b'{' | b'[' | b'"', ..]).then_some(ElementFormat::OmmJson)
        }
        [b'1', b' ', ..] if !line.contains([',', ';', '\t']) => {
            tle_file::looks_like(line).then_some(ElementFormat::Tle)
        }
        _ if ephemeris::opens_oem_kvn(line) => Some(ElementFormat::OemKvn),
        _ if omm_kvn::opens(line) => Some(ElementFormat::OmmKvn),
        _ if line.contains("MEAN_MOTION") && omm_csv::looks_like(line) => Some(ElementFormat::OmmCsv),
        _ => None,
    }
}

/// Converts increasing byte offsets to line numbers, which start at 1.
fn line_numbers<T>(text: &[u8], rejected: Vec<(usize, T)>) -> Vec<(usize, T)> {
    // Files of the classic Mac OS have a carriage return at the end of lines.
    let line_end = if text.contains(&b'\n') { b'\n' } else { b'\r' };
    let (mut at, mut line) = (0, 1);
    rejected
        .into_iter()
        .map(|(offset, reason)| {
            let offset = offset.clamp(at, text.len());
            line += text[at..offset].iter().filter(|&&byte| byte == line_end).count();
            at = offset;
            (line, reason)
        })
        .collect()
}

/// Ends of the names of the records and locks that `streakcast fetch` writes next to its files.
const OF_FETCH: [&str; 2] = [".fetch.json", ".lock"];

/// Largest size of decompressed text relative to the compressed one. Catalogues expand by a factor of 3 (TLE) to 20
/// (XML).
const LARGEST_EXPANSION: u64 = 100;
/// Decompressed size that is accepted for any expansion, bytes.
const SMALL: u64 = 1_000_000;

/// Decompresses gzip, up to `limit` bytes and [`LARGEST_EXPANSION`].
fn unpack<'a>(name: &str, bytes: &'a [u8], limit: u64) -> Result<Cow<'a, [u8]>, Error> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(Cow::Borrowed(bytes));
    }
    let limit = limit.min(SMALL.max(LARGEST_EXPANSION * bytes.len() as u64));
    input::read_at_most(MultiGzDecoder::new(bytes), limit).map(Cow::Owned).map_err(|source| match source.kind() {
        io::ErrorKind::FileTooLarge => Error::cannot("read", name, source),
        _ => Error::about_file(
            "",
            name,
            format!("is an invalid gzip file ({source}): it may be truncated; download it again"),
        ),
    })
}

/// Removes a byte order mark, and converts UTF-16 (as written by Windows shells) to UTF-8.
fn decode(bytes: &[u8]) -> Cow<'_, [u8]> {
    let utf16 = |bytes: &[u8], from: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| from([pair[0], pair[1]])).collect();
        Cow::Owned(String::from_utf16_lossy(&units).into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(rest),
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ => Cow::Borrowed(bytes),
    }
}

/// Detects the format of a text. The error describes what the text appears to be.
fn sniff(bytes: &[u8], text: &str) -> Result<ElementFormat, Cow<'static, str>> {
    let packed: &[(&[u8], &str)] = &[
        (b"PK\x03\x04", "it is a zip archive; unpack it"),
        (b"\xfd7zXZ", "it is packed with xz; unpack it"),
        (b"\x28\xb5\x2f\xfd", "it is packed with zstd; unpack it"),
        (b"BZh", "it is packed with bzip2; unpack it"),
        (b"SQLite format 3", "it is an SQLite database"),
    ];
    if let Some((_, what)) = packed.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Err(Cow::Borrowed(what));
    }
    let body = text.trim_start();
    match body.as_bytes().first() {
        Some(b'{') => return Ok(ElementFormat::OmmJson),
        // TOML and INI tables also start with a bracket.
        Some(b'[') if matches!(body[1..].trim_start().as_bytes().first(), None | Some(b'{' | b'[' | b']' | b'"')) => {
            return Ok(ElementFormat::OmmJson);
        }
        Some(b'<') if omm_xml::looks_like(body) => return Ok(ElementFormat::OmmXml),
        Some(b'<') if ephemeris::looks_like_oem_xml(body) => return Ok(ElementFormat::OemXml),
        Some(b'<') => return Err("it is a web page or another kind of XML".into()),
        _ => {}
    }
    // CSV is tested before TLE, because a CSV file may contain the two lines of a TLE in columns.
    if ephemeris::looks_like_modified_itc(body) {
        Ok(ElementFormat::ModifiedItc)
    } else if ephemeris::looks_like_oem_kvn(body) {
        Ok(ElementFormat::OemKvn)
    } else if omm_kvn::looks_like(body) {
        Ok(ElementFormat::OmmKvn)
    } else if omm_csv::looks_like(body) {
        Ok(ElementFormat::OmmCsv)
    } else if tle_file::looks_like(body) {
        Ok(ElementFormat::Tle)
    } else {
        let first = body.lines().next().unwrap_or_default();
        Err(format!("it begins {:?}", excerpt(first.as_bytes())).into())
    }
}

/// Returns the SHA-256 of bytes in lower-case hexadecimal.
pub fn sha256_hex(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Formats bytes as lower-case hexadecimal.
fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder};

    use super::*;

    /// Decompression bombs: gzip files of 1 kB that expand to 1 MB, and of 3 kB that expand to 3 MB.
    #[test]
    fn verif_decompression_is_bounded() {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&vec![b' '; 1_000_000]).unwrap();
        let bomb = encoder.finish().unwrap();
        assert!(bomb.len() < 2000);
        assert_eq!(unpack("bomb.gz", &bomb, 1_000_000).unwrap().len(), 1_000_000);
        let error = unpack("bomb.gz", &bomb, 999_999).unwrap_err().to_string();
        assert_eq!(error, "cannot read bomb.gz: more than 999999 bytes; allowed: at most 999999");
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&vec![b' '; 3_000_000]).unwrap();
        let error = unpack("bomb.gz", &encoder.finish().unwrap(), u64::MAX).unwrap_err().to_string();
        assert_eq!(error, "cannot read bomb.gz: more than 1000000 bytes; allowed: at most 1000000");
    }
}
