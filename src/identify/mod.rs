//! Identification of the satellite of a measured streak.
//!
//! `streak` defines the measured streak, and `region` reads it from a DS9 region file. `search` finds the satellites of
//! a [`Sky`](crate::passes::Sky) whose orbits pass near the streak, `compare` compares one satellite with the streak,
//! and `likelihood` computes probabilities.

mod compare;
mod error;
mod likelihood;
mod region;
mod search;
mod streak;
mod table;

pub use error::IdentifyError;
pub use likelihood::{Candidate, Offset};
pub use search::{Identified, IdentifyOptions, identify_streak};
pub use streak::{MeasuredStreak, Timing};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    region::{fit_line, parse_regions},
    table::{CandidateRow, candidate_table, streak_table},
};
