//! Comments of header cards: what they state about the instant, the unit or the number of parts of a value.
//!
//! `words` splits a comment into words, `part` reads the part of the exposure to which an instant refers, `clock`
//! local times and time scales, `doubt` uncertainties, shifts and remarks about clocks, `unit` units of time,
//! `quantity` durations, and `seconds` names of units.

mod clock;
mod doubt;
mod part;
mod quantity;
mod seconds;
mod unit;
mod words;

pub use doubt::AGREED_S;
pub use part::AFTER_EXPOSURE;
pub use seconds::seconds_in;
pub use unit::begins_with_exposure;
pub use words::{Comment, FRAMES, Role};
