//! Streaks in pixels: the light of a pass put into a frame, with its truth.

mod count_scale;
mod mask_planes;
mod modulation;
mod random_streaks;
mod resolved;
mod sky_track;
mod tracking;

pub use count_scale::{CountScale, CountScaleError};
pub use mask_planes::{MaskError, MaskPlanes, MaskPreset};
pub use modulation::{Glint, LightCurve, Modulation, ModulationError, Tumbling};
pub use random_streaks::{RandomStreakError, RandomStreaks, StreakNumber};
pub use resolved::ResolvedPanels;
pub use sky_track::{SkyPoint, SkyTrack};
pub use tracking::Tracking;
