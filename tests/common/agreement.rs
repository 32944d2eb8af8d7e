//! Comparison with a reference: the largest difference must not exceed a bound.
//!
//! Each successful comparison appends one line to the file named by the environment variable `STREAKCAST_FIGURES`. From
//! these lines `docs/tables.sh` makes the tables of docs/explanation/accuracy.md.

use std::io::Write;
use std::panic::Location;
use std::path::Path;

/// Differences from a reference. When dropped, it checks that there is at least one difference and that none exceeds
/// the bound.
pub struct Agreement {
    /// Name of the test's file without extension; it determines the subject of the row in the tables.
    subject: String,
    quantity: &'static str,
    authority: &'static str,
    allowed: f64,
    unit: &'static str,
    worst: f64,
    compared: usize,
}

impl Agreement {
    /// Creates an empty comparison of a quantity with an authority. `allowed` is the bound in this unit. `unit` may be
    /// empty, for ratios.
    #[track_caller]
    pub fn new(quantity: &'static str, authority: &'static str, allowed: f64, unit: &'static str) -> Self {
        let file = Path::new(Location::caller().file()).file_stem().unwrap_or_default();
        let subject = file.to_string_lossy().into_owned();
        Self { subject, quantity, authority, allowed, unit, worst: 0.0, compared: 0 }
    }

    /// Adds a difference in this unit. Its sign is ignored.
    pub fn add(&mut self, difference: f64) {
        let size = difference.abs();
        // NaN is treated as the largest difference.
        if size.is_nan() || size > self.worst {
            self.worst = size;
        }
        self.compared += 1;
    }

    /// Appends a line to the file of `STREAKCAST_FIGURES`.
    fn record(&self) {
        let Some(path) = std::env::var_os("STREAKCAST_FIGURES") else { return };
        let Self { subject, quantity, authority, allowed, unit, worst, compared } = self;
        let line = format!("{subject}\t{quantity}\t{authority}\t{compared}\t{worst:e}\t{allowed:e}\t{unit}\n");
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        // Each line is written in one call, so that lines of parallel tests are not mixed.
        file.and_then(|mut file| file.write_all(line.as_bytes())).expect("STREAKCAST_FIGURES names a file");
    }
}

impl Drop for Agreement {
    fn drop(&mut self) {
        let Self { quantity, authority, allowed, unit, worst, compared, .. } = self;
        println!("{quantity}, {authority}: {compared} compared, largest {worst:.3e} {unit}, bound {allowed:.1e}");
        if std::thread::panicking() {
            return;
        }
        assert!(*compared > 0, "{quantity}: nothing was compared with {authority}");
        assert!(worst <= allowed, "{quantity}, {authority}: {worst:e} {unit}, bound {allowed:e}");
        self.record();
    }
}
