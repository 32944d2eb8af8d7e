//! Schedules in, verdicts out: which exposures are streaked, by how much, and when the field is clear next.
//!
//! A [`Schedule`] is read from Rubin opsim SQLite, CSV, ECSV or JSON; [`flag`] judges one exposure by the passes that
//! cross it and a [`Policy`], [`flag_exposures`] all of them; [`next_clear_start`] is the arithmetic of waiting; [`annotate`]
//! writes the answer beside every original cell. [`clear_windows`] turns the question round: from when to when a target may be exposed. A row that cannot be judged stays in its place with its reason.

mod annotate;
mod camera;
mod error;
mod exposure_flag;
mod exposure_table;
mod flag_table;
mod formats;
mod heavens;
mod horizon;
mod judge;
mod policy;
mod report;
mod rows;
mod scheduled;
mod shard;
mod shift;
mod streak_table;
mod targets;
mod waiting;
mod window_table;
mod windows;

pub use annotate::{AnnotateError, Annotation, annotate};
pub use error::ScheduleError;
pub use exposure_flag::{ExposureFlag, Verdict};
pub use exposure_table::exposure_table;
pub use flag_table::flag_table;
pub use formats::ScheduleFormat;
pub use horizon::lowest_altitudes_rad;
pub use judge::{CameraLimits, Expected, LimitKind, Rules, flag};
pub(crate) use policy::one_line as toml_error_on_one_line;
pub use policy::{MagnitudeLimit, OfTelescope, Policy, PolicyError};
pub use report::{FlagReport, FlagRequest, flag_exposures, judge_exposures};
pub use scheduled::{Schedule, ScheduleOptions, ScheduledExposure};
pub use shard::{Shard, ShardError};
pub use shift::{Interval, clear_starts, next_clear_start};
pub use streak_table::{StreakRow, streak_table};
pub use targets::{ListedTarget, read_targets};
pub use waiting::{share_of_stale, wait_for};
pub use window_table::{FoundWindows, WindowShape, window_table, window_target_table};
pub use windows::{
    Blocking, ClearWindow, TargetWindows, WindowReport, WindowRequest, WindowTarget, clear_windows,
    clear_windows_alone, evening_mjd, night_of,
};
