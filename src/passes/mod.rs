//! Which satellites cross a field while the shutter is open, and what the telescope sees of them.

mod almanac;
mod chance;
mod count;
mod crossing;
mod expose;
mod exposure;
mod field;
mod horizon;
mod look;
mod models;
mod probability;
mod scene;
mod sightline;
mod sky;
mod track;
mod viewpoint;
mod windows;

pub use chance::Chance;
pub use count::{CountRequest, Counts, StreakCount};
pub use exposure::Exposure;
pub use field::{Field, FieldError, FieldOnSky};
pub use horizon::HorizonPass;
pub use models::{ModelChoice, UnknownModel};
pub use sky::{PassOptions, Passes, Sky, SkyError};
pub use track::{Chord, FieldPass, TrackPoint};
pub use viewpoint::{OrbitingObserver, Viewpoint};
