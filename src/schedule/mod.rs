//! Verdicts on scheduled exposures, next clear starts, and clear windows of targets.
//!
//! A [`Schedule`] is read from Rubin opsim SQLite, CSV, ECSV, JSON or VOTable. [`flag_exposures`] judges its
//! exposures by the passes that cross them and a [`Policy`], and computes their next clear starts; `annotate` adds
//! the results to the file. [`clear_windows`] computes the opening times for which an exposure of a target is clear.
//! Rows that cannot be judged are kept, with the reason.
//!
//! ```
//! use streakcast::frames::parse_instant;
//! use streakcast::photometry::PhotometryOptions;
//! use streakcast::schedule::{FlagRequest, ScheduledExposure, flag_exposures};
//! use streakcast::{Exposure, Field, Policy, Satellites, Site, Sky};
//!
//! let satellites = Satellites::synthetic("starlink-gen1", parse_instant("2026-08-14T00:00:00Z", None)?)?;
//! let sky = Sky::new(satellites, Site::from_mpc("X05")?);
//! let exposure = Exposure::new("2026-08-14T23:36:25Z", 30.0, "14h53m36s", "-08d54m")?;
//! let row = ScheduledExposure { id: "1".to_owned(), row: 0, band: None, open_s: None, exposure: Ok(exposure) };
//! let (field, policy) = (Field::circle_deg(3.5)?, Policy::limit_mag(7.0));
//! let photometry = PhotometryOptions::default();
//! let request =
//!     FlagRequest { sky: &sky, field: &field, policy: &policy, telescope: None, photometry: &photometry };
//! let report = flag_exposures(&[&row], &request)?;
//! println!("{}", report.flags[0]);
//! # Ok::<(), streakcast::Error>(())
//! ```

mod annotate;
mod best_start;
mod blockers;
mod error;
mod flag_request;
mod formats;
mod horizon;
mod limits;
mod nights;
mod policy;
mod report;
mod scheduled;
mod shift;
mod starts;
mod stated_altitudes;
mod streak_costs;
mod tables;
mod targets;
mod totals;
mod verdict;
mod verdict_rules;
mod window_table;
mod windows;

pub use crate::images::MagnitudeLimit;
pub use best_start::{BestStart, best_start};
pub use flag_request::FlagRequest;
pub use nights::night_of;
pub use policy::{Blocking, Policy};
pub use report::{FlagReport, flag_exposures};
pub use scheduled::{Schedule, ScheduleOptions, ScheduledExposure};
pub use verdict::{Verdict, VerdictKind};
pub use windows::{ClearWindow, TargetWindows, WindowReport, WindowRequest, WindowTarget, clear_windows};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    annotate::{Annotation, annotate, check_extension, check_not_annotated},
    best_start::{COMPARED_STARTS, delayed_costs_s},
    formats::ScheduleFormat,
    horizon::lowest_altitude_rad,
    nights::{Shard, evening_mjd},
    report::judge_exposures,
    starts::reason_for_unknown_starts,
    streak_costs::BrightStreaks,
    tables::{PassCost, StreakColumns, StreakRow, exposure_table, flag_table, flag_table_with_exposures, streak_table},
    targets::{ListedTarget, TargetList, read_targets},
    totals::{AgeEffect, FlagTotals},
    window_table::{FoundWindows, SchedulerFormat, window_table, window_target_table},
    windows::{clear_windows_without_passes, next_window},
};
