//! Satellites that cross a field while the shutter is open, that pass over a site, or that are above it at a time.
//!
//! [`Sky`] is the entry type: a catalogue with a viewpoint. `field_passes` computes crossings, their probability and
//! brightness, `visible_passes` the visible passes of a night (`above_horizon` their intervals), `snapshots` all
//! satellites at given times, `delayed_track` tracks of delayed satellites. They share `scene` (Sun, Earth, search
//! windows), `candidates` (the search), `track` (lines of sight), `crossing` (chords through a field), `probability`,
//! and `evaluator` (positions and brightness along a line of sight).

mod above_horizon;
mod altaz;
mod candidates;
mod crossing;
mod delayed_track;
mod error;
mod evaluator;
mod exposure;
mod field;
mod field_passes;
mod models;
mod probability;
mod scene;
mod sky;
mod snapshots;
mod track;
mod viewpoint;
mod visible_passes;

pub use altaz::AltAz;
pub use delayed_track::{DelayedTrack, ExposureInterval, Sighting};
pub use error::SkyError;
pub use exposure::Exposure;
pub use field::{Field, FieldOnSky};
pub use field_passes::{
    CountRequest, Counts, CrossingProbability, FieldCrossing, FieldCrossings, PassOptions, Passes, StreakCount,
};
pub use models::ModelChoice;
pub use sky::Sky;
pub use snapshots::{SatelliteSnapshot, SatelliteTrack, SnapshotOptions};
pub use track::{Chord, Pass, TrackPoint};
pub use viewpoint::{OrbitingObserver, Viewpoint};
pub use visible_passes::{NotShown, Visibility, VisiblePass, VisiblePasses, VisibleRequest, intervals_where};
