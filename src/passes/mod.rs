//! Which satellites cross a field while the shutter is open, and what the telescope sees of them.

mod almanac;
mod chance;
mod circle_path;
mod crossing;
mod expose;
mod exposure;
mod field;
mod glance;
mod horizon;
mod look;
mod models;
mod overhead;
mod places;
mod probability;
mod scene;
mod sightline;
mod sky;
mod stretch;
mod track;
mod two_body;
mod viewpoint;
mod visible;
mod windows;

pub use chance::Chance;
pub use exposure::Exposure;
pub use field::{Field, FieldError, FieldOnSky};
pub use glance::Glance;
pub use horizon::HorizonPass;
pub use models::{ModelChoice, UnknownModel};
pub use overhead::{Horizontally, Overhead};
pub use sky::{PassOptions, Passes, Sky, SkyError};
pub use stretch::{LateTrack, Sighting, Stretch};
pub use track::{Chord, FieldPass, TrackPoint};
pub use viewpoint::{OrbitingObserver, Viewpoint};
pub use visible::{NotShown, Visibility, VisiblePass, VisiblePasses, VisibleRequest, stretches_where};
