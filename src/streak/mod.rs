//! Streaks in pixels: the light of a pass put into a frame, with its truth.

mod chip;
mod chords;
mod count_scale;
mod drawn;
mod mask;
mod mask_planes;
mod modulation;
mod optics;
mod panels;
mod path;
mod random_streaks;
mod render;
mod resolved;
mod runs;
mod satellites;
mod sky_track;
mod source;
mod spline;
mod strokes;
#[cfg(feature = "fits")]
mod synthetic;
#[cfg(feature = "fits")]
mod target_frame;
mod tracking;
mod truth;
#[cfg(feature = "fits")]
mod write;

pub use chip::{Chip, ChipPath};
pub use count_scale::{CountScale, CountScaleError};
pub use drawn::{DrawError, DrawnStreak, Shot, StreakPoint, draw_on_chip};
pub use mask::{MaskSpan, mask_spans, noise_of};
pub use mask_planes::{MaskError, MaskPlanes, MaskPreset};
pub use modulation::{Glint, LightCurve, Modulation, ModulationError, Tumbling};
pub use optics::{Optics, OpticsError, SeeingForm};
pub use path::{PathError, PathNode, StreakPath};
pub use random_streaks::{RandomStreakError, RandomStreaks, StreakNumber};
pub use render::{draw, draw_summed};
pub use resolved::ResolvedPanels;
pub use satellites::{SatelliteError, SatelliteLight, Satellites, satellites};
pub use sky_track::{SkyPoint, SkyTrack};
pub use source::{Source, SourceName, SourcePart};
#[cfg(feature = "fits")]
pub use synthetic::{StarField, SyntheticError, SyntheticFrame, SyntheticShot};
#[cfg(feature = "fits")]
pub use target_frame::{FrameSaid, TargetChip, TargetError, TargetFrame, circle_of, direction_on};
pub use tracking::Tracking;
pub use truth::{TruthRow, points_table, trail_table, truth_table};
#[cfg(feature = "fits")]
pub use write::{InjectError, InjectOptions, Injected, inject, truth_rows};
