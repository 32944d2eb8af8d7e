//! Satellites that cross a field during exposures: passes with brightness, crossings with times only, probabilities,
//! and numbers of streaks.
//!
//! `query` runs a query with the `options` over all exposures. `exposed_field` is the field during one exposure, with
//! its candidates. `pass`, `crossings` and `probabilities` each evaluate one candidate. `streak_counts` counts passes.

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
