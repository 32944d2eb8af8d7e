//! Streaks in pixels: the light of satellite passes drawn into frames, with the true parameters of each streak.
//!
//! `light/` describes directions and brightness on the sky; `chip` converts them to a path in pixels; `psf/` is the
//! image of a point; `render/` draws a path; `drawn` holds drawn streaks with their true parameters; `truth/` makes
//! tables and masks from them; `frame/` reads and writes files; `injection/` adds streaks to frames; `masking/` masks
//! the streaks of real satellites.
//!
//! ```
//! use streakcast::frames::Direction;
//! use streakcast::images::{LightArea, Plane, Wcs};
//! use streakcast::streaks::{
//!     Chip, CountScale, Optics, RandomStreaks, SeeingForm, Shot, Source, SourceName, SourcePart, StreakNumber,
//!     Tracking, direction_on, draw_on_chip,
//! };
//!
//! let (seed, exposure_s, centre) = (11, 30.0, Direction::from_lon_lat_rad(1.0, -0.4));
//! let chip = Chip {
//!     hdu: 0,
//!     name: "one".to_owned(),
//!     rows: 200,
//!     columns: 200,
//!     light_area: LightArea::whole(200, 200),
//!     wcs: Wcs::tangent(centre, 2.0, 0.0, 200, 200)?,
//!     is_on_sky: true,
//!     scale: CountScale::of_frame(25.0, exposure_s)?,
//! };
//! let random =
//!     RandomStreaks { number: StreakNumber::Exactly(1), magnitude: [5.0, 8.0], rate_rad_s: [0.005, 0.01] };
//! let radius_rad = 0.002;
//! let tracks = random.tracks(seed, exposure_s, radius_rad, |at, _| direction_on([&chip].into_iter(), at));
//! let source = Source {
//!     name: SourceName::Random(1),
//!     mag_source: "random".to_owned(),
//!     element_age_days: None,
//!     hdu: None,
//!     image_fwhm_arcsec: None,
//!     parts: vec![SourcePart { label: "whole", track: tracks[0].clone(), radius_m: 1.0 }],
//! };
//! let optics =
//!     Optics { form: SeeingForm::Gaussian, seeing_arcsec: 1.2, outer_radius_m: 0.5, inner_radius_m: 0.2 };
//! let shot = Shot {
//!     opened: "2026-08-14T23:30:00 UTC".parse().expect("a time"),
//!     exposure_s,
//!     centre,
//!     tracking: &Tracking::Sidereal,
//!     optics: &optics,
//!     truth_points: 2,
//! };
//! let mut plane = Plane::zeros(chip.rows, chip.columns);
//! for streak in draw_on_chip(&source, &chip, &shot)? {
//!     streak.patch.add_to(&mut plane);
//! }
//! assert!(plane.values().iter().any(|&counts| counts > 0.0));
//! # Ok::<(), streakcast::Error>(())
//! ```

mod background;
mod chip;
mod count_scale;
mod drawn;
#[cfg(all(feature = "fits", unix))]
mod frame;
#[cfg(all(feature = "fits", unix))]
mod injection;
mod light;
#[cfg(all(feature = "fits", unix))]
mod masking;
mod optics;
mod psf;
#[cfg(all(feature = "fits", unix))]
mod regions;
mod render;
mod tracking;
mod truth;

#[cfg(all(feature = "fits", unix))]
pub(crate) use background::BRIGHTEST_E;
pub use chip::{Chip, direction_on};
pub use count_scale::CountScale;
pub use drawn::{DrawnStreak, Shot, StreakPoint, draw_on_chip};
#[cfg(all(feature = "fits", unix))]
pub(crate) use frame::TargetChip;
#[cfg(all(feature = "fits", unix))]
pub(crate) use injection::{Injection, InjectionPlan, InjectionSky, RandomPlan, SyntheticPlan, partly_written};
#[cfg(all(feature = "fits", unix))]
pub(crate) use light::{ChosenStreaks, GivenColumns, GivenStreak, GivenWidth};
pub use light::{
    Glint, LightCurve, Modulation, RandomStreaks, SkyTrack, Source, SourceName, SourcePart, StreakNumber, Tumbling,
};
#[cfg(all(feature = "fits", unix))]
pub(crate) use masking::{
    ChosenPlanes, LeftOutReason, MaskBit, MeasuredStreak, PlaneChoice, StreakOrigin, UnusedReason, corridor_table,
    is_same_file_name, left_out_table, mask_history, missing_zero_point, read_measured_streaks, region_file,
    write_mask_file, write_mask_planes,
};
pub use optics::{Optics, SeeingForm};
pub use psf::Seeing;
pub use render::{PathNode, StreakPath};
pub use tracking::Tracking;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    background::{RandomStars, Star, background, flux_e},
    chip::circle_of,
    light::{SatelliteLight, SkyPoint, satellites},
    psf::{Blur, RadialProfile, draw_point},
    render::draw,
    truth::{
        MaskPlanes, MaskPreset, NoiseMap, TruthRow, changed_spans, mask_spans, points_table, trail_table, truth_rows,
        truth_table,
    },
};
#[cfg(all(feature = "fits", unix))]
#[doc(hidden)]
pub use self::{
    frame::{FrameOverrides, StarField, SyntheticFrame, SyntheticShot, TargetFrame},
    injection::{InjectedFrame, Injections, LabelFile, LabelFormat},
    masking::{FrameMask, MaskOptions, MaskedStreak, mask_frame},
};
pub(crate) use psf::{PointLight, draw_points};
