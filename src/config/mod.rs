//! Configuration: one document for satellites, site, models, camera and policy, filled from flags, files and plugins.
//!
//! [`Config`] has the options common to all requests; [`ForecastConfig`], [`EphemerisConfig`], [`IdentifyConfig`] and
//! `InjectionConfig` have those of one kind of request. Each is checked once and converted to an [`ObservationPlan`], a
//! [`PreparedSky`], a [`ForecastRequest`](crate::forecast::ForecastRequest), an
//! [`EphemerisRequest`](crate::forecast::EphemerisRequest), an [`IdentifyPlan`], or an `InjectionPlan` of
//! [`streaks`](crate::streaks). With the feature `cli`, the command line flags are derived from the same structures.

mod coordinates;
mod described;
mod document;
mod doubtful_site;
mod ephemeris;
mod error;
mod forecast;
mod health;
mod identify;
#[cfg(all(feature = "fits", unix))]
mod identify_frame;
mod identify_plan;
#[cfg(all(feature = "fits", unix))]
mod identify_streaks;
#[cfg(all(feature = "fits", unix))]
mod identify_table;
#[cfg(all(feature = "fits", unix))]
mod injection;
#[cfg(all(feature = "fits", unix))]
mod injection_plan;
mod inputs;
#[cfg(all(feature = "fits", unix))]
mod mask;
#[cfg(all(feature = "fits", unix))]
mod measure;
#[cfg(all(feature = "fits", unix))]
mod measure_frame;
#[cfg(all(feature = "fits", unix))]
mod measured_tables;
mod observation;
mod paths;
mod prepared;
mod questions;
mod reading;
mod required;
mod response_file;
mod site;
mod values;
mod warnings;

pub use coordinates::{parse_coordinates, parse_height_m, parse_latitude_deg, parse_longitude_deg};
#[cfg(feature = "cli")]
pub use document::norad_id;
pub use document::{Config, ExposureConfig, HomeConfig, LightConfig, RulesConfig, RunConfig, SiteConfig};
pub use doubtful_site::doubtful_site;
pub use ephemeris::EphemerisConfig;
pub use forecast::{ForecastConfig, SelectionConfig, TimeRangeConfig, parse_night, time_range};
pub use health::{
    AgeBin, ElementState, EphemerisState, Finding, Health, MomentSource, Severity, Unmatched, finding_table,
};
pub use identify::IdentifyConfig;
pub use identify_plan::{IdentifiedStreak, IdentifyPlan, IdentifySettings};
#[cfg(all(feature = "fits", unix))]
pub use identify_streaks::{IdentifiedStreaks, SkyOver, StreakTables, identify_streaks};
#[cfg(all(feature = "fits", unix))]
pub use injection::InjectionConfig;
#[cfg(all(feature = "fits", unix))]
pub use injection_plan::{SkyOf, inject_frames};
pub use inputs::LoadedInputs;
#[cfg(all(feature = "fits", unix))]
pub use mask::{MaskConfig, MaskedFrame, Masks};
#[cfg(all(feature = "fits", unix))]
pub use measure::{MeasureConfig, Measurements};
pub use observation::{MOST_SAMPLES, ObservationPlan};
pub use prepared::{PreparedSky, state_scales};
pub use questions::Question;
pub use required::{
    EXPOSURE, FIELD, FRAMES, INJECTED_STREAKS, Mark, POINTING, RequiredInput, SATELLITES, SEEING, SELECTION, SITE,
    START, STREAK, TIMES,
};
pub use values::{
    FieldChoice, ModelAssignment, ModelSource, ModelsTable, NameOrFile, NameOrTable, Numbers, PolicyChoice, Quantity,
    SiteChoice, SiteTable, TelescopeChoice, parse_angle_deg, parse_duration_s, parse_exposure_s, parse_size_deg,
    parse_time_scale,
};
pub use warnings::OLD_ELEMENTS_DAYS;
