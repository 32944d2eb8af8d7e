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

pub use alarms::{Alarm, AlarmKind, Alarms, alarm_table, find_alarms, pass_differences};
pub use error::LearnError;
pub use hierarchy::{KindFit, Prediction, fit_kind};
pub use lateness::{MeasuredDelay, learn_lateness, read_delays};
pub use learned::{Learned, kind_table, learn, satellite_table};
pub use leave_out::{LeaveOutRow, leave_out_table, leave_passes_out};
pub use pass::{Pass, PassPoint, group_passes};
#[cfg(feature = "fit")]
pub use residuals::{LeftOutPoints, passes_of};
