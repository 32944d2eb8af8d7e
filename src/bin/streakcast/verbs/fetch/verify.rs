//! Checks of downloaded element sets, and sidecar records with time and status of the last request.

use std::path::Path;

use anyhow::anyhow;
use hifitime::Epoch;
use hifitime::efmt::consts::RFC2822;
use streakcast::elements::{Keep, ReadOptions, Satellites, SourceFile};
use streakcast::frames::{parse_moment, seconds_after, seconds_between};
use streakcast::output::{counted, format_utc, write_atomically};

use crate::cache::FetchRecord;

/// Largest accepted fraction of invalid records.
const MAX_REJECTED: f64 = 0.01;
/// Smallest accepted number of records, as a fraction of those in the previous file.
const LEAST_SHARE: f64 = 0.5;

/// Parses the bytes as element sets and checks them.
///
/// # Errors
/// The bytes are an error page or other text, are truncated within a record, have too many invalid records, or have
/// less than half of the records of the previous file.
pub fn verify(name: &str, bytes: &[u8], before: Option<usize>, accept_fewer: bool) -> anyhow::Result<SourceFile> {
    let options = ReadOptions { keep: Keep::All, ..ReadOptions::default() };
    let catalogue = Satellites::from_bytes(name, bytes, &options)
        .map_err(|error| anyhow!("the response has no element sets ({}); {error}", first_words(bytes)))?;
    let source = catalogue.sources.into_iter().next().ok_or_else(|| anyhow!("the response is empty"))?;
    let all = source.records + source.rejected;
    // The last record of a truncated file is invalid.
    let last_line = bytes.split(|byte| *byte == b'\n').count();
    let is_truncated = catalogue.rejected.last().is_some_and(|rejected| rejected.line + 3 >= last_line);
    if source.rejected as f64 > MAX_REJECTED * all as f64 || is_truncated {
        let first = catalogue.rejected.first().map(ToString::to_string).unwrap_or_default();
        return Err(anyhow!(
            "the response is damaged: {} of {} invalid, the first: {first}",
            source.rejected,
            counted(all, "record is", "records are")
        ));
    }
    if let Some(before) = before
        && !accept_fewer
        && (source.records as f64) < LEAST_SHARE * before as f64
    {
        return Err(anyhow!(
            "the response has {} instead of {before}: more than half are missing (--accept-fewer accepts it)",
            counted(source.records, "record", "records")
        ));
    }
    Ok(source)
}

/// Returns the start of a response on one line, for an error message.
pub fn first_words(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(400)]);
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut line: String = words.join(" ").chars().filter(|character| !character.is_control()).take(120).collect();
    if line.is_empty() {
        line = "nothing".to_owned();
    }
    format!("it begins: {line}")
}

/// Longest waiting time that a source can set, seconds.
const LONGEST_RETRY_S: f64 = 30.0 * 86_400.0;

/// Returns the waiting time of the header Retry-After, seconds from `now`, at most 30 days: a number of seconds, or a
/// date such as `Wed, 14 Aug 2024 13:00:00 GMT`. `None` for other text and for a time in the past.
pub fn retry_after_s(header: Option<&str>, now: Epoch) -> Option<f64> {
    let text = header?.trim();
    let wait_s = if text.bytes().all(|byte| byte.is_ascii_digit()) {
        text.parse::<f64>().ok()?
    } else {
        let date = Epoch::from_str_with_format(text.strip_suffix(" GMT")?, RFC2822).ok()?;
        seconds_between(now, date)
    };
    (wait_s > 0.0).then_some(wait_s.min(LONGEST_RETRY_S))
}

impl FetchRecord {
    /// Returns the record with the SHA-256, format, records and epochs of a file.
    pub fn with_contents(self, read: &SourceFile) -> Self {
        Self {
            sha256: Some(read.sha256.clone()),
            format: Some(read.format.to_string()),
            records: Some(read.records),
            rejected: Some(read.rejected),
            first_epoch_utc: Some(format_utc(read.first_epoch, 3)),
            last_epoch_utc: Some(format_utc(read.last_epoch, 3)),
            ..self
        }
    }

    pub fn write(&self, file: &Path) -> anyhow::Result<()> {
        let path = Self::sidecar_path(file);
        let text = serde_json::to_string_pretty(self)? + "\n";
        write_atomically(&path, |out| out.write_all(text.as_bytes()))
            .map_err(|error| anyhow!("cannot write {}: {error}", path.display()))
    }

    /// Removes the sidecar of a file.
    pub fn remove(file: &Path) -> anyhow::Result<()> {
        let path = Self::sidecar_path(file);
        std::fs::remove_file(&path).map_err(|error| anyhow!("cannot remove {}: {error}", path.display()))
    }

    /// Returns the seconds until the next request is allowed; `None` if it is allowed now. The waiting time is at least
    /// `wait_s`, and longer if the source stated so. A last request that is this time or more in the future (the clock
    /// was set back since) is ignored.
    pub fn wait_left_s(&self, now: Epoch, wait_s: f64) -> Option<f64> {
        let requested = parse_moment(self.asked_utc.as_deref()?, None).ok()?;
        let not_before = self.not_before_utc.as_deref().and_then(|text| parse_moment(text, None).ok());
        let wait_s = not_before.map_or(wait_s, |until| seconds_between(requested, until).max(wait_s));
        let since_s = seconds_between(requested, now);
        (since_s > -wait_s && since_s < wait_s).then_some(wait_s - since_s)
    }

    /// Sets time and response of a request, and the time from which the next one is allowed. The sidecar is written
    /// before a request is sent, so that no second request is sent after a crash.
    pub fn stamp(&mut self, now: Epoch, wait_s: f64, answer: &str) {
        self.asked_utc = Some(format_utc(now, 0));
        self.answer = Some(answer.to_owned());
        self.not_before_utc = Some(format_utc(seconds_after(now, wait_s), 0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAIR: &str = "ISS (ZARYA)\n\
        1 25544U 98067A   26189.73419088  .00005258  00000+0  10370-3 0  9999\n\
        2 25544  51.6304 193.4497 0006669 272.1743  87.8481 15.48947664575097\n";

    #[test]
    fn only_whole_element_sets_pass() {
        assert_eq!(verify("a", PAIR.as_bytes(), None, false).unwrap().records, 1);
        let error = |bytes: &[u8], before| verify("a", bytes, before, false).unwrap_err().to_string();
        assert!(error(b"<!DOCTYPE html><html>Forbidden</html>", None).contains("it begins: <!DOCTYPE html>"));
        assert!(error(b"No GP data found", None).contains("it begins: No GP data found"));
        assert!(error(b"", None).contains("nothing"));
        let cut = PAIR.repeat(200) + &PAIR[..60];
        assert!(error(cut.as_bytes(), None).contains("damaged"), "{}", error(cut.as_bytes(), None));
        assert!(error(PAIR.as_bytes(), Some(3)).contains("--accept-fewer"));
        assert!(verify("a", PAIR.as_bytes(), Some(3), true).is_ok());
    }

    #[test]
    fn both_forms_of_retry_after_are_read() {
        let now = parse_moment("2024-08-14T12:00:00Z", None).unwrap();
        for (header, expected) in [
            ("7200", Some(7200.0)),
            (" 90 ", Some(90.0)),
            ("Wed, 14 Aug 2024 13:00:00 GMT", Some(3600.0)),
            ("Sun, 18 Aug 2024 12:00:00 GMT", Some(4.0 * 86_400.0)),
            ("99999999999999999999", Some(LONGEST_RETRY_S)),
            ("Sat, 14 Aug 2224 13:00:00 GMT", Some(LONGEST_RETRY_S)),
            ("Wed, 14 Aug 2024 11:00:00 GMT", None),
            ("0", None),
            ("", None),
            ("-5", None),
            ("1e9", None),
            ("soon", None),
            ("Wed, 14 Aug 2024 13:00:00", None),
            ("Tue, 14 Aug 2024 13:00:00 GMT", None),
            ("Wed, 99 Aug 2024 13:00:00 GMT", None),
        ] {
            assert_eq!(retry_after_s(Some(header), now), expected, "{header}");
        }
        assert_eq!(retry_after_s(None, now), None);
    }

    #[test]
    fn the_wait_ends_also_after_a_clock_was_set_back() {
        let now = |text: &str| parse_moment(text, None).unwrap();
        let mut record = FetchRecord::default();
        assert_eq!(record.wait_left_s(now("2024-08-14T00:00:00Z"), 3600.0), None);
        record.stamp(now("2024-08-14T00:00:00Z"), 3600.0, "200");
        assert_eq!(record.wait_left_s(now("2024-08-14T00:10:00Z"), 3600.0), Some(3000.0));
        assert_eq!(record.wait_left_s(now("2024-08-14T01:00:00Z"), 3600.0), None);
        assert_eq!(record.wait_left_s(now("2024-08-10T00:00:00Z"), 3600.0), None);
        assert_eq!(record.not_before_utc.as_deref(), Some("2024-08-14T01:00:00Z"));
        // The source stated a longer waiting time.
        record.stamp(now("2024-08-14T00:00:00Z"), 7200.0, "503");
        assert_eq!(record.wait_left_s(now("2024-08-14T01:30:00Z"), 3600.0), Some(1800.0));
        assert_eq!(record.wait_left_s(now("2024-08-14T02:00:00Z"), 3600.0), None);
    }
}
