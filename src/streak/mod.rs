//! Streaks in pixels: the light of a pass put into a frame, with its truth.

mod chip;
mod chords;
mod count_scale;
mod drawn;
mod mask_planes;
mod modulation;
mod optics;
mod panels;
mod path;
mod random_streaks;
mod render;
mod resolved;
mod runs;
mod sky_track;
mod source;
mod spline;
mod strokes;
mod tracking;
mod truth;

pub use chip::{Chip, ChipPath};
pub use count_scale::{CountScale, CountScaleError};
pub use drawn::{DrawError, DrawnStreak, Shot, StreakPoint, draw_on_chip};
pub use mask_planes::{MaskError, MaskPlanes, MaskPreset};
pub use modulation::{Glint, LightCurve, Modulation, ModulationError, Tumbling};
pub use optics::{Optics, OpticsError, SeeingForm};
pub use path::{PathError, PathNode, StreakPath};
pub use random_streaks::{RandomStreakError, RandomStreaks, StreakNumber};
pub use render::{draw, draw_summed};
pub use resolved::ResolvedPanels;
pub use sky_track::{SkyPoint, SkyTrack};
pub use source::{Source, SourceName, SourcePart};
pub use tracking::Tracking;
pub use truth::{TruthRow, points_table, trail_table, truth_table};
