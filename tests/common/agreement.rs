//! How well we agree with an authority: the largest difference that was seen, held against what is allowed.
//!
//! What holds is written down, one line a comparison, in the file that `STREAKCAST_FIGURES` names: `docs/tables.sh` makes the table of
//! docs/explanation/accuracy.md of these lines.

use std::io::Write;

/// Asserts when it goes: something was compared, and nothing was further off than allowed.
pub struct Agreement {
    what: &'static str,
    authority: &'static str,
    allowed: f64,
    unit: &'static str,
    worst: f64,
    compared: usize,
}

impl Agreement {
    /// `unit` may be empty, for ratios.
    pub fn new(what: &'static str, authority: &'static str, allowed: f64, unit: &'static str) -> Self {
        Self { what, authority, allowed, unit, worst: 0.0, compared: 0 }
    }

    /// A difference, in the unit; its sign does not matter.
    pub fn see(&mut self, difference: f64) {
        let size = difference.abs();
        // Not a number is the worst of all, and stays.
        if size.is_nan() || size > self.worst {
            self.worst = size;
        }
        self.compared += 1;
    }

    /// The largest difference seen so far.
    pub fn worst(&self) -> f64 {
        self.worst
    }

    fn write_down(&self) {
        let Some(path) = std::env::var_os("STREAKCAST_FIGURES") else { return };
        let Self { what, authority, allowed, unit, worst, compared } = self;
        let line = format!("{what}\t{authority}\t{compared}\t{worst:e}\t{allowed:e}\t{unit}\n");
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        // One write a line, so that lines of tests that run at once do not mix.
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
