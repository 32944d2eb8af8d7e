//! Identification of the satellite of a measured streak.
//!
//! `streak` defines the measured streak, and `region` fits it to regions drawn around it. `search` finds the satellites
//! of a [`Sky`](crate::passes::Sky) whose orbits pass near the streak, `compare` compares one satellite with the
//! streak, and `likelihood` computes probabilities.
//!
//! ```
//! use streakcast::frames::{Direction, parse_instant};
//! use streakcast::identify::{IdentifyOptions, MeasuredStreak, Timing, identify_streak};
//! use streakcast::{Satellites, Site, Sky};
//!
//! let start = parse_instant("2026-08-14T23:29:05Z", None)?;
//! let satellites = Satellites::synthetic("starlink-gen1", start)?;
//! let sky = Sky::new(satellites, Site::from_mpc("X05")?);
//! let ends = [(198.2_f64, 7.1_f64), (199.4, 8.0)]
//!     .map(|(ra_deg, dec_deg)| Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians()));
//! // Errors of 5 arcsec and 0.5 s; the ends are within the exposure of 30 s.
//! let error_rad = (5.0_f64 / 3600.0).to_radians();
//! let streak = MeasuredStreak::from_ends(ends, (start, 30.0), Timing::Within, error_rad, 0.5)?;
//! let found = identify_streak(&sky, &streak, &IdentifyOptions::default())?;
//! println!("{} candidates; none is it with probability {:.2}", found.candidates.len(), found.unknown_probability);
//! # Ok::<(), streakcast::Error>(())
//! ```

mod compare;
mod error;
mod likelihood;
mod region;
mod search;
mod streak;
mod table;

#[cfg(all(feature = "fits", unix))]
pub(crate) use region::line_in_plane;

pub use likelihood::{Candidate, Offset};
pub use search::{Identified, IdentifyOptions, identify_streak};
pub use streak::{MeasuredStreak, Timing};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    region::fit_line,
    table::{CandidateRow, candidate_table, streak_table},
};
