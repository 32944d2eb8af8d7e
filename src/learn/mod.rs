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

mod alarms;
mod error;
mod hierarchy;
mod lateness;
mod learned;
mod leave_out;
mod pass;
#[cfg(feature = "fit")]
mod residuals;

pub use alarms::{Alarm, AlarmKind, Alarms, find_alarms};
pub use error::LearnError;
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
