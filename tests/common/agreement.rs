//! Comparison with a reference: the largest difference must not exceed a limit.
//!
//! Each successful comparison appends one line to the file named by the environment variable `STREAKCAST_FIGURES`. From
//! these lines `docs/tables.sh` makes the table of docs/explanation/accuracy.md.

use std::io::Write;

/// Differences from a reference. When dropped, it checks that there is at least one difference and that none exceeds
/// the limit.
pub struct Agreement {
    what: &'static str,
    authority: &'static str,
    allowed: f64,
    unit: &'static str,
    worst: f64,
    compared: usize,
}

impl Agreement {
    /// Creates an empty comparison. `unit` may be empty, for ratios.
    pub fn new(what: &'static str, authority: &'static str, allowed: f64, unit: &'static str) -> Self {
        Self { what, authority, allowed, unit, worst: 0.0, compared: 0 }
    }

    /// Adds a difference in this unit. Its sign is ignored.
    pub fn see(&mut self, difference: f64) {
        let size = difference.abs();
        // NaN is treated as the largest difference.
        if size.is_nan() || size > self.worst {
            self.worst = size;
        }
        self.compared += 1;
    }

    /// Returns the largest difference.
    pub fn worst(&self) -> f64 {
        self.worst
    }

    fn write_down(&self) {
        let Some(path) = std::env::var_os("STREAKCAST_FIGURES") else { return };
        let Self { what, authority, allowed, unit, worst, compared } = self;
        let line = format!("{what}\t{authority}\t{compared}\t{worst:e}\t{allowed:e}\t{unit}\n");
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        // Each line is written in one call, so that lines of parallel tests are not mixed.
        file.and_then(|mut file| file.write_all(line.as_bytes())).expect("STREAKCAST_FIGURES names a file");
    }
}

impl Drop for Agreement {
    fn drop(&mut self) {
        let Self { what, authority, allowed, unit, worst, compared } = self;
        println!("{what} against {authority}: {compared} compared, worst {worst:.3e} {unit}, allowed {allowed:.1e}");
        if std::thread::panicking() {
            return;
        }
        assert!(*compared > 0, "{what}: nothing was compared with {authority}");
        assert!(worst <= allowed, "{what} against {authority}: {worst:e} {unit}, allowed {allowed:e}");
        self.write_down();
    }
}
