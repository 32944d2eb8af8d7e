//! Verdicts on scheduled exposures, next clear starts, and clear windows of targets.
//!
//! A [`Schedule`] is read from Rubin opsim SQLite, CSV, ECSV, JSON or VOTable. [`flag_exposures`] judges its
//! exposures by the passes that cross them and a [`Policy`], and computes their next clear starts; [`annotate`] adds
//! the results to the file. [`clear_windows`] computes the opening times for which an exposure of a target is clear.
//! Rows that cannot be judged are kept, with the reason.

mod annotate;
mod best_start;
mod error;
mod flag_request;
mod formats;
mod horizon;
mod nights;
mod policy;
mod report;
mod scheduled;
mod shift;
mod starts;
mod streak_costs;
mod tables;
mod targets;
mod totals;
mod verdict;
mod verdict_rules;
mod window_table;
mod windows;

pub use crate::images::MagnitudeLimit;
pub use annotate::{Annotation, annotate, check_extension};
pub use best_start::{BestStart, best_start};
pub use error::ScheduleError;
pub use flag_request::FlagRequest;
pub use formats::ScheduleFormat;
pub use horizon::lowest_altitude_rad;
pub use nights::{Shard, ShardError, evening_mjd, night_of};
pub use policy::{Blocking, Policy};
pub use report::{FlagReport, flag_exposures, judge_exposures};
pub use scheduled::{Schedule, ScheduleOptions, ScheduledExposure};
pub use starts::reason_for_unknown_starts;
pub use streak_costs::BrightStreaks;
pub use tables::{StreakColumns, StreakRow, exposure_table, flag_table, flag_table_with_exposures, streak_table};
pub use targets::{ListedTarget, read_targets};
pub use totals::{AgeEffect, FlagTotals};
pub use verdict::{Verdict, VerdictKind};
pub use window_table::{FoundWindows, SchedulerFormat, window_table, window_target_table};
pub use windows::{
    ClearWindow, TargetWindows, WindowReport, WindowRequest, WindowTarget, clear_windows, clear_windows_without_passes,
    next_window,
};
