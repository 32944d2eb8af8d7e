//! Moving lights on the sky: `sky_track` (positions and magnitudes), `modulation` (tumbling, glints, light curves),
//! `resolved` (chassis and solar array as separate lights), `satellites` (satellites of a sky) and `random_streaks`
//! (random lights) as `source`s.

mod modulation;
mod random_streaks;
mod resolved;
mod satellites;
mod sky_track;
mod source;

pub use modulation::{Glint, LightCurve, Modulation, Tumbling};
pub use random_streaks::{RandomStreaks, StreakNumber};
pub use resolved::ResolvedPanels;
pub use satellites::{SatelliteExposure, SatelliteLight, satellites};
pub use sky_track::{SkyPoint, SkyTrack};
pub use source::{Source, SourceName, SourcePart};
