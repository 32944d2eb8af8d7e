//! Learning from measurements: offsets of satellites and kinds from their brightness models, and errors along the
//! track.
//!
//! - `pass`: measured magnitudes as residuals from the models, by satellite and pass
//! - `residuals`: passes of photometry (feature `fit`)
//! - `hierarchy`: offsets of one kind and of its satellites: a hierarchical normal distribution with wings
//! - `lateness`: factor of the error along the track, from the tables of `streakcast measure`
//! - `leave_out`: each pass predicted from the others
//! - `learned`: the learned file of all kinds
//! - `alarms`: improbable light, trends and periods
//!
//! The learned file and its application are in [`passes`](crate::passes). docs/explanation/learning.md has the
//! equations.
//!
//! ```
//! use std::collections::BTreeMap;
//!
//! use streakcast::Watch;
//! use streakcast::elements::{Generation, NoradId};
//! use streakcast::frames::{parse_instant, seconds_after};
//! use streakcast::learn::{PassPoint, group_passes, learn};
//! use streakcast::passes::ModelChoice;
//!
//! // Three satellites that are 0.3 mag fainter than their model, each in eight nights.
//! let start = parse_instant("2026-08-01T23:30:00Z", None)?;
//! let point = |satellite: u32, night: u32| {
//!     let epoch = seconds_after(start, 86_400.0 * f64::from(night));
//!     let residual_mag = 0.3 + 0.1 * f64::from((satellite + night) % 3);
//!     (NoradId(90_000 + satellite), Generation::OneWeb, PassPoint { epoch, residual_mag, sigma_mag: Some(0.05) })
//! };
//! let passes = group_passes((0..8).flat_map(|night| (1..=3).map(move |satellite| point(satellite, night))));
//! let learned = learn(&passes, &BTreeMap::new(), &ModelChoice::default(), Default::default(), &Watch::default())?;
//! println!("{}", learned.file.to_json());
//! # Ok::<(), streakcast::Error>(())
//! ```

mod alarms;
mod hierarchy;
mod lateness;
mod learned;
mod leave_out;
mod pass;
#[cfg(feature = "fit")]
mod residuals;

pub use alarms::{Alarm, AlarmKind, Alarms, find_alarms};
pub use lateness::MeasuredDelay;
pub use learned::{Learned, learn};
pub use pass::{Pass, PassPoint, group_passes};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    alarms::{alarm_table, pass_differences},
    hierarchy::fit_kind,
    lateness::read_delays,
    learned::kind_table,
    leave_out::{LeaveOutRow, leave_out_table, leave_passes_out},
};
#[cfg(feature = "fit")]
#[doc(hidden)]
pub use residuals::passes_of;
