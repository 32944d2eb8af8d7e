//! Which satellite a measured streak is of.
//!
//! `streak` is what was measured, `region` reads it from a file of DS9, `line` fits it to outlines. `search` asks a [`Sky`](crate::passes::Sky): `near`
//! finds whose orbits lead past the streak, `compare` holds one satellite against it, `likelihood` weighs them. `table` is what leaves the house.

mod compare;
mod error;
mod likelihood;
mod line;
mod near;
mod region;
mod search;
mod streak;
mod table;

pub use compare::{Candidate, Offset};
pub use error::IdentifyError;
pub use likelihood::chi_square_survival;
pub use line::{FittedLine, fit_line};
pub use region::parse_regions;
pub use search::{Identified, IdentifyOptions, identify_streak};
pub use streak::{MeasuredStreak, Timing};
pub use table::{CandidateRow, candidate_table, streak_table};
