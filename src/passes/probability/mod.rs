//! Probability of a crossing, given the uncertainty of the prediction along and across the track.
//!
//! `delays` integrates the distribution of the delay over the chords of one track. `odds` averages over the shifts
//! across the track for an observer at a site; `in_flight` does the same for an observer in orbit.

mod delays;
mod in_flight;
mod odds;

pub(super) use delays::Delays;
pub(super) use in_flight::crossing_probability_in_flight;
pub(super) use odds::{REACH_SIGMAS, crossing_odds};
