//! Satellites that cross a field while the shutter is open, that pass over a site, or that are above a site at a given
//! time.
//!
//! [`Sky`] is the main type: a catalogue of satellites with an observer. `field_passes` computes crossings of a field
//! with their probability and brightness, `visible_passes` the visible passes of a night (from the intervals of
//! `above_horizon`), `snapshots` all satellites at given times, `ephemeris` selected satellites at given times, and
//! `delayed_track` tracks of delayed satellites. They share `scene` (Sun, Earth, search windows), `candidates` (the
//! search), `track` (lines of sight), `crossing` (parts of a track inside a field), `probability`, and `evaluator`
//! (position and brightness along a line of sight). `models` assigns brightness models to satellites, with the
//! corrections of `learned`; `corrections` corrects the magnitudes of a pass by those of `measured`. `pointing_checks`
//! computes the angles of a pointing that limit a telescope in orbit, and `own_satellite` finds the telescope itself
//! among the satellites.
//!
//! ```
//! use streakcast::frames::parse_instant;
//! use streakcast::passes::PassOptions;
//! use streakcast::{Exposure, Field, Satellites, Site, Sky};
//!
//! let satellites = Satellites::synthetic("starlink-gen1", parse_instant("2026-08-14T00:00:00Z", None)?)?;
//! let sky = Sky::new(satellites, Site::from_mpc("X05")?);
//! let exposures = [Exposure::new("2026-08-14T23:36:25Z", 30.0, "14h53m36s", "-08d54m")?];
//! let found = sky.field_passes(&exposures, &Field::circle_deg(3.5)?, &PassOptions::default())?;
//! for pass in &found.by_exposure[0] {
//!     println!("{} from {} to {}", pass.norad_id, pass.enter.epoch, pass.exit.epoch);
//! }
//! # assert!(!found.by_exposure[0].is_empty());
//! # Ok::<(), streakcast::Error>(())
//! ```

mod above_horizon;
mod altaz;
mod candidates;
mod corrections;
mod crossing;
mod delayed_track;
mod ephemeris;
mod error;
mod evaluator;
mod exposure;
mod field;
mod field_passes;
mod intervals;
mod known_positions;
mod learned;
mod measured;
mod models;
mod own_satellite;
mod pointing_checks;
mod predictability;
mod probability;
mod scene;
mod sky;
mod snapshots;
mod track;
mod viewpoint;
mod visible_passes;

pub(crate) use delayed_track::{DelayedTrack, Sighting};
pub use ephemeris::EphemerisPoint;
pub(crate) use error::{no_ephemeris, no_observer};
pub use exposure::Exposure;
pub use field::Field;
pub use field_passes::{CrossingProbability, FieldCrossing, FieldCrossings, PassOptions, Passes};
pub(crate) use intervals::intervals_where;
pub use learned::LearnedFile;
pub(crate) use learned::{LearnedMagnitude, LearnedSatellite};
pub(crate) use measured::{LONGEST_PASS_GAP_S, read_measured};
pub use models::ModelChoice;
pub(crate) use predictability::Predictability;
pub use sky::Sky;
pub use snapshots::{SatelliteSnapshot, SatelliteTrack, SnapshotOptions, SnapshotPositions};
pub use track::{Chord, Pass, TrackPoint};
pub use viewpoint::{OrbitingObserver, Viewpoint};
pub use visible_passes::{BrightnessLimit, NotShown, Visibility, VisiblePass, VisiblePasses, VisibleRequest};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    altaz::AltAz,
    delayed_track::ExposureInterval,
    field_passes::{CountRequest, Counts, StreakCount},
    learned::{LearnedKind, LearnedLateness},
};
pub(crate) use learned::LEARNED_ERRORS;
