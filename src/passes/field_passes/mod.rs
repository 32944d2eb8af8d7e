//! Satellites that cross a field during exposures: passes with their brightness, crossings only, probabilities, and
//! counts.
//!
//! `query` runs a query over exposures with the `options`; `exposed_field` is one exposure with its candidates; `pass`,
//! `crossings` and `probabilities` evaluate one candidate each; `streak_counts` counts passes.

mod crossings;
mod exposed_field;
mod options;
mod pass;
mod probabilities;
mod query;
mod streak_counts;

pub use crossings::{FieldCrossing, FieldCrossings};
pub use options::PassOptions;
pub use probabilities::CrossingProbability;
pub use query::Passes;
pub use streak_counts::{CountRequest, Counts, StreakCount};
