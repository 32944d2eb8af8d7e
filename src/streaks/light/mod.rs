//! Lights that move over the sky: `sky_track` (where and how bright), `modulation` (tumbling, glints, light curves), `resolved` (chassis and solar array
//! apart), `satellites` (those of a sky) and `random_streaks` (those of a seed) as `source`s.

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
