//! What goes to standard error beside the data: warnings, summaries, progress.

use std::io::{IsTerminal, Write, stderr};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// Work below this many exposures is over before a bar could be read.
const LONG_WORK: usize = 2000;

/// Standard error, unless the user wants none.
pub struct Notices {
    quiet: bool,
}

impl Notices {
    /// `quiet` keeps everything but errors away.
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// Prints warnings, one a line.
    pub fn warn<'a>(&self, warnings: impl IntoIterator<Item = &'a String>) {
        for warning in warnings {
            self.say(&format!("warning: {warning}"));
        }
    }

    /// Prints one line.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            // A closed standard error is no reason to stop.
            let _ = writeln!(stderr(), "{line}");
        }
    }

    /// A bar over `length` exposures: on long work, on a terminal, and unless quiet; else one that shows nothing.
    pub fn progress(&self, length: usize) -> ProgressBar {
        if length < LONG_WORK { ProgressBar::hidden() } else { self.bar(length, "exposures") }
    }

    /// A bar over the steps of walkers.
    #[cfg(feature = "fit")]
    pub fn steps(&self, length: usize) -> ProgressBar {
        self.bar(length, "steps")
    }

    fn bar(&self, length: usize, of: &str) -> ProgressBar {
        if self.quiet || !stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(length as u64);
        if let Ok(style) = ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}} {of}, {{eta}} to go")) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}
