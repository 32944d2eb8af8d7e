//! Streaks in pixels: the light of satellite passes drawn into frames, with the true parameters of each streak.
//!
//! `light/` describes directions and brightness on the sky; `chip` converts them to a path in pixels; `psf/` is the
//! image of a point; `render/` draws a path; `drawn` holds drawn streaks with their true parameters; `truth/` makes
//! tables and masks from them; `frame/` reads and writes files; `injection/` adds streaks to frames; `masking/` masks the
//! streaks of real satellites.

mod background;
mod chip;
mod count_scale;
mod drawn;
mod error;
#[cfg(all(feature = "fits", unix))]
mod frame;
#[cfg(all(feature = "fits", unix))]
mod injection;
mod light;
#[cfg(all(feature = "fits", unix))]
mod masking;
mod optics;
mod psf;
mod render;
mod tracking;
mod truth;

#[cfg(all(feature = "fits", unix))]
pub(crate) use background::BRIGHTEST_E;
pub use background::{RandomStars, Star, background, flux_e};
pub use chip::{Chip, ChipPath, circle_of, direction_on};
pub use count_scale::CountScale;
pub use drawn::{DrawnStreak, Shot, StreakPoint, draw_on_chip};
pub use error::StreaksError;
#[cfg(all(feature = "fits", unix))]
pub use frame::{
    FrameOverrides, InjectOptions, Injected, StarField, SyntheticFrame, SyntheticShot, TargetChip, TargetFrame, inject,
};
#[cfg(all(feature = "fits", unix))]
pub use injection::{
    InjectedFrame, Injection, InjectionPlan, InjectionSky, Injections, Mark, RandomPlan, SyntheticPlan,
};
#[cfg(all(feature = "fits", unix))]
pub use light::{ChosenLight, ChosenStreak, ChosenStreaks, ChosenWidth};
pub use light::{
    Glint, LightCurve, Modulation, RandomStreaks, ResolvedPanels, SatelliteExposure, SatelliteLight, SkyPoint,
    SkyTrack, Source, SourceName, SourcePart, StreakNumber, Tumbling, satellites,
};
#[cfg(all(feature = "fits", unix))]
pub use masking::{
    Area, ChosenPlanes, FrameMask, LeftOutReason, LeftOutSatellite, MaskBit, MaskOptions, MaskedStreak, MeasuredStreak,
    PlaneChoice, StreakOrigin, UnusedReason, corridor_table, left_out_table, mask_frame, mask_history,
    read_measured_streaks, region_file, write_mask_file, write_mask_planes,
};
pub use optics::{Optics, SeeingForm};
pub use psf::{Blur, RadialProfile, Seeing, draw_point};
pub(crate) use psf::{PointLight, draw_points};
pub use render::{PathNode, StreakPath, draw};
pub use tracking::Tracking;
pub use truth::{
    MaskPlanes, MaskPreset, MaskSpan, NoiseMap, TruthRow, changed_spans, mask_spans, points_table, trail_table,
    truth_rows, truth_table,
};
