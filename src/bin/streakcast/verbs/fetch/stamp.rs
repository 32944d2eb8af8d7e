//! The sidecar of a cached file as it is written: when its source was asked, what it said, and when it may be asked again.

use std::path::Path;

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::frames::parse_moment;
use streakcast::frames::{seconds_after, seconds_between};
use streakcast::output::{format_utc, write_atomically};

use crate::cache::FetchRecord;

impl FetchRecord {
    pub fn write(&self, file: &Path) -> anyhow::Result<()> {
        let path = Self::path_beside(file);
        let text = serde_json::to_string_pretty(self)? + "\n";
        write_atomically(&path, |out| out.write_all(text.as_bytes()))
            .map_err(|error| anyhow!("cannot write {}: {error}", path.display()))
    }

    /// Away with the sidecar of a file: its source was never asked.
    pub fn remove(file: &Path) -> anyhow::Result<()> {
        let path = Self::path_beside(file);
        std::fs::remove_file(&path).map_err(|error| anyhow!("cannot remove {}: {error}", path.display()))
    }

    /// Seconds until the source may be asked again; `None` where it may be now. A stamp from the future (a clock that was set back) does not bind for longer
    /// than the wait.
    pub fn wait_left_s(&self, now: Epoch, wait_s: f64) -> Option<f64> {
        let asked = parse_moment(self.asked_utc.as_deref()?, None).ok()?;
        let since_s = seconds_between(asked, now);
        (since_s > -wait_s && since_s < wait_s).then_some(wait_s - since_s)
    }

    /// The stamp of a question, written before it is asked: a crash does not ask again.
    pub fn stamp(&mut self, now: Epoch, wait_s: f64, answer: &str) {
        self.asked_utc = Some(format_utc(now, 0));
        self.answer = Some(answer.to_owned());
        self.not_before_utc = Some(format_utc(seconds_after(now, wait_s), 0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wait_ends_and_a_clock_that_was_set_back_does_not_bind_for_ever() {
        let now = |text: &str| parse_moment(text, None).unwrap();
        let mut record = FetchRecord::default();
        assert_eq!(record.wait_left_s(now("2024-08-14T00:00:00Z"), 3600.0), None);
        record.stamp(now("2024-08-14T00:00:00Z"), 3600.0, "200");
        assert_eq!(record.wait_left_s(now("2024-08-14T00:10:00Z"), 3600.0), Some(3000.0));
        assert_eq!(record.wait_left_s(now("2024-08-14T01:00:00Z"), 3600.0), None);
        assert_eq!(record.wait_left_s(now("2024-08-10T00:00:00Z"), 3600.0), None);
        assert_eq!(record.not_before_utc.as_deref(), Some("2024-08-14T01:00:00Z"));
    }
}
