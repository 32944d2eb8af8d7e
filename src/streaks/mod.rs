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
pub use chip::{Chip, direction_on};
pub use count_scale::CountScale;
pub use drawn::{DrawnStreak, Shot, StreakPoint, draw_on_chip};
pub use error::StreaksError;
#[cfg(all(feature = "fits", unix))]
pub(crate) use frame::TargetChip;
#[cfg(all(feature = "fits", unix))]
pub(crate) use injection::{Injection, InjectionPlan, InjectionSky, RandomPlan, SyntheticPlan};
#[cfg(all(feature = "fits", unix))]
pub(crate) use light::ChosenStreaks;
pub use light::{
    Glint, LightCurve, Modulation, RandomStreaks, SkyTrack, Source, SourceName, SourcePart, StreakNumber, Tumbling,
};
#[cfg(all(feature = "fits", unix))]
pub(crate) use masking::{
    ChosenPlanes, LeftOutReason, MaskBit, MeasuredStreak, PlaneChoice, StreakOrigin, UnusedReason, corridor_table,
    left_out_table, mask_history, read_measured_streaks, region_file, write_mask_file, write_mask_planes,
};
pub use optics::{Optics, SeeingForm};
pub use psf::Seeing;
pub use render::{PathNode, StreakPath};
pub use tracking::Tracking;
pub use truth::{TruthRow, truth_rows};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    background::{RandomStars, Star, background, flux_e},
    chip::circle_of,
    light::{SatelliteLight, SkyPoint, satellites},
    psf::{Blur, RadialProfile, draw_point},
    render::draw,
    truth::{MaskPlanes, MaskPreset, NoiseMap, changed_spans, mask_spans, points_table, trail_table, truth_table},
};
#[cfg(all(feature = "fits", unix))]
#[doc(hidden)]
pub use self::{
    frame::{FrameOverrides, StarField, SyntheticFrame, SyntheticShot, TargetFrame},
    injection::{InjectedFrame, Injections},
    masking::{FrameMask, MaskOptions, MaskedStreak, mask_frame},
};
pub(crate) use psf::{PointLight, draw_points};
