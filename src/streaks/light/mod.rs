//! Moving lights on the sky. A `source` has one or two tracks (`sky_track`) of directions and magnitudes. `satellites`
//! creates the sources of an exposure from a sky, and `random_streaks` draws random tracks. `modulation` changes the
//! brightness by tumbling, glints and light curves. `resolved` divides a satellite into chassis and solar array.
//! `given_streaks` holds streaks whose place a table gives; `chosen_streaks` adds the light that the user chooses.

#[cfg(all(feature = "fits", unix))]
mod chosen_streaks;
#[cfg(all(feature = "fits", unix))]
mod given_streaks;
mod modulation;
mod random_streaks;
mod resolved;
mod satellites;
mod sky_track;
mod source;

#[cfg(all(feature = "fits", unix))]
pub use chosen_streaks::{ChosenLight, ChosenStreak, ChosenStreaks};
#[cfg(all(feature = "fits", unix))]
pub use given_streaks::{GivenColumns, GivenStreak, GivenWidth};
pub use modulation::{Glint, LightCurve, Modulation, Tumbling};
pub use random_streaks::{RandomStreaks, StreakNumber};
pub use satellites::{SatelliteLight, satellites};
pub use sky_track::{SkyPoint, SkyTrack};
pub use source::{Source, SourceName, SourcePart};
