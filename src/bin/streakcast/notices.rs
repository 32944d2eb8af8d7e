//! Messages on standard error: warnings, summaries, progress.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{IsTerminal, Write, stderr};
use std::path::Path;
use std::time::Duration;

use hifitime::Epoch;
use indicatif::{ProgressBar, ProgressStyle};
use streakcast::config::{Config, PreparedSky};
use streakcast::message::{bounded, first_of, printable};
use streakcast::orbit::LeftOut;
use streakcast::output::counted;

/// Smallest number of exposures for which a progress bar is shown.
const LONG_WORK: usize = 2000;

/// Warnings of several nights. Of those that differ only in numbers, the first and the last one are printed.
#[derive(Default)]
pub struct WarningsOfNights {
    texts: BTreeSet<String>,
    /// Last warning of each kind; `None` if there is only the first one.
    last: BTreeMap<String, Option<String>>,
}

impl WarningsOfNights {
    /// Adds a warning, and returns true if it is the first of its kind, which the caller prints.
    pub fn is_first(&mut self, warning: &str) -> bool {
        let kind: Vec<&str> = warning.split(' ').map(|word| if is_number(word) { "#" } else { word }).collect();
        let kind = kind.join(" ");
        let is_first = !self.last.contains_key(&kind);
        if self.texts.insert(warning.to_owned()) {
            self.last.insert(kind, Some(warning.to_owned()).filter(|_| !is_first));
        }
        is_first
    }

    /// Prints the last warning of each kind, and the number of those between the first and the last ones.
    pub fn print_last(self, notices: &Notices) {
        let kinds = self.last.len();
        let last: Vec<String> = self.last.into_values().flatten().collect();
        notices.warn(&last);
        let omitted = self.texts.len() - kinds - last.len();
        if omitted > 0 {
            let omitted = counted(omitted, "warning", "warnings");
            notices.warn(&[format!("not printed: {omitted} that differ from these in numbers")]);
        }
    }
}

/// Returns true for a number, a date or a time, with signs of punctuation around it.
fn is_number(word: &str) -> bool {
    let inner = word.trim_matches(|c: char| !c.is_ascii_alphanumeric());
    inner.starts_with(|c: char| c.is_ascii_digit())
        && inner.chars().all(|c| c.is_ascii_digit() || matches!(c, '.' | ',' | ':' | '-' | '+' | 'T' | 'Z'))
}

/// Writer of messages to standard error.
#[derive(Copy, Clone)]
pub struct Notices {
    quiet: bool,
    verbose: bool,
}

impl Notices {
    /// Returns a writer; `quiet` suppresses everything except errors.
    pub fn new(quiet: bool) -> Self {
        Self { quiet, verbose: false }
    }

    /// Sets whether the warning about satellites whose position cannot be computed lists all of them.
    pub fn with_details(self, verbose: bool) -> Self {
        Self { verbose, ..self }
    }

    /// Returns a writer with the options of a configuration.
    pub fn from_config(config: &Config) -> Self {
        Self::new(config.run.quiet.unwrap_or(false)).with_details(config.run.verbose.unwrap_or(false))
    }

    /// Prints that a file was written.
    pub fn wrote(&self, path: &Path) {
        self.info(&format!("wrote {}", path.display()));
    }

    /// Prints warnings, one on each line.
    pub fn warn<'a>(&self, warnings: impl IntoIterator<Item = &'a String>) {
        for warning in warnings {
            self.info(&format!("warning: {warning}"));
        }
    }

    /// Prints the first three warnings of one kind, and the number of the others. `what` describes them in plural, for
    /// example "targets without a window".
    pub fn warn_first(&self, warnings: impl IntoIterator<Item = String>, what: &str) {
        self.warn(&first_of(warnings, what));
    }

    /// Prints a warning if the position of satellites cannot be computed; with `verbose` it lists all of them.
    ///
    /// # Errors
    /// No satellite has a position.
    pub fn warn_left_out(&self, prepared: &PreparedSky, left_out: &[LeftOut], moment: Epoch) -> anyhow::Result<()> {
        self.list_left_out(prepared.left_out_warning(left_out, moment)?, left_out);
        Ok(())
    }

    /// Prints such warnings of one sky, or of several periods of constellations that grow.
    pub fn list_left_out(&self, warnings: impl IntoIterator<Item = String>, left_out: &[LeftOut]) {
        let end = if self.verbose { ":" } else { "; --verbose lists them" };
        let warnings = warnings.into_iter().map(|warning| format!("{warning}{end}"));
        self.warn_first(warnings, "periods of the shells with satellites without a position");
        if self.verbose {
            left_out.iter().for_each(|satellite| self.info(&format!("  {}", satellite.reason)));
        }
    }

    /// Prints one line.
    pub fn info(&self, line: &str) {
        if !self.quiet {
            // A closed standard error is ignored.
            let _ = writeln!(stderr(), "{}", bounded(&printable(line)));
        }
    }

    /// Returns a progress bar over `length` exposures; hidden for short work, without a terminal, or if quiet.
    pub fn progress(&self, length: usize) -> ProgressBar {
        if length < LONG_WORK { ProgressBar::hidden() } else { self.bar(length, "exposures") }
    }

    /// Returns a progress bar over the steps of a sampling run.
    pub fn steps(&self, length: usize) -> ProgressBar {
        self.bar(length, "steps")
    }

    /// Returns a progress bar over other parts of a computation, for example nights; hidden without a terminal.
    pub fn tasks(&self, length: usize, unit: &str) -> ProgressBar {
        self.bar(length, unit)
    }

    fn bar(&self, length: usize, unit: &str) -> ProgressBar {
        if self.quiet || !stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(length as u64);
        if let Ok(style) = ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{eta}} left")) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_of_warnings_differ_in_more_than_numbers() {
        let mut warnings = WarningsOfNights::default();
        assert!(warnings.is_first("gp1.tle ends with a broken record (line 12)"));
        assert!(!warnings.is_first("gp1.tle ends with a broken record (line 13)"));
        assert!(warnings.is_first("gp2.tle ends with a broken record (line 12)"));
        assert!(warnings.is_first("3 sets are 12.5 days from 2026-03-20T03:00:00Z"));
        assert!(!warnings.is_first("1,400 sets are 9 days from 2026-03-21T03:00:00Z"));
    }
}
