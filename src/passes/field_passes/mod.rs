//! Satellites that cross a field during exposures: passes with their light, crossings alone, probabilities, and counts.
//!
//! `query` holds the options and results and runs a query over exposures; `exposed_field` is one exposure with its candidates; `pass`,
//! `crossings` and `probabilities` evaluate one candidate each; `streak_counts` counts passes.

mod crossings;
mod exposed_field;
mod pass;
mod probabilities;
mod query;
mod streak_counts;

pub use crossings::{FieldCrossing, FieldCrossings};
pub use probabilities::CrossingProbability;
pub use query::{PassOptions, Passes};
pub use streak_counts::{CountRequest, Counts, StreakCount};
