//! Questions about nights and streaks as people say them, and what they mean: one meaning for every face.
//!
//! `forecast` says which passes of which night, on `time_range`; `streak` says where and when a streak was measured, `streak_line` and, of a frame,
//! `streak_frame` where it lies. `horizon` refuses what nobody can have seen. The rooms [`forecast`](crate::forecast) and
//! [`identify`](crate::identify) answer.

mod error;
mod forecast;
mod horizon;
mod streak;
#[cfg(feature = "fits")]
mod streak_frame;
mod streak_line;
mod time_range;

pub use error::QuestionError;
pub use forecast::ForecastSaid;
pub use horizon::above_the_horizon;
pub use streak::{StreakAsked, StreakSaid};
pub use time_range::time_range;
