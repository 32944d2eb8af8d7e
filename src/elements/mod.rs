//! Element sets in all common formats, operator ephemerides, histories, simulated constellations, and satellite
//! generations.
//!
//! ```
//! use streakcast::elements::{Constellation, Keep, Satellites};
//! use streakcast::frames::parse_instant;
//!
//! let epoch = parse_instant("2026-08-14T00:00:00Z", None)?;
//! let oneweb = Constellation::by_name("oneweb")?;
//! let satellites = Satellites::from_element_sets(oneweb.element_sets(epoch), Keep::default());
//! assert_eq!(satellites.element_sets.len(), oneweb.satellites());
//! # Ok::<(), streakcast::Error>(())
//! ```

mod deployment;
mod element_set;
mod ephemeris;
mod epoch;
mod generation;
mod history;
mod omm;
mod omm_csv;
mod omm_json;
mod omm_kvn;
mod omm_xml;
mod on_station;
mod record;
mod satellites;
mod shell;
mod source;
mod tle;
mod tle_fields;
mod tle_file;

pub use element_set::{ElementSet, NoradId, Origin};
pub use ephemeris::Ephemeris;
pub(crate) use ephemeris::{EphemerisFrame, EphemerisObject, EphemerisState, PositionCovariance};
pub use generation::Generation;
pub(crate) use generation::STARLINK_TABLE_DATE;
pub use history::{Chosen, History};
pub use record::Rejected;
pub use satellites::{Keep, ReadOptions, Satellites};
pub use shell::{Constellation, Shell};
pub use tle_file::format_tle;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    deployment::{Deployment, DeploymentFile, DeploymentPeriod},
    ephemeris::CovarianceAxes,
    generation::{Certainty, GenerationTable},
    on_station::{OrbitPhase, StationRule, orbit_phases, semi_major_axis_km},
    record::ElementFormat,
    shell::{ConstellationSet, FIRST_SYNTHETIC_ID},
    source::SourceFile,
};
#[cfg(feature = "fit")]
pub(crate) use epoch::parse_iso;
pub(crate) use history::others_of;
pub(crate) use record::excerpt;
pub(crate) use source::sha256_hex;
