//! Element sets in all common formats, operator ephemerides, histories, simulated constellations, and satellite
//! generations.

mod element_set;
mod ephemeris;
mod epoch;
mod error;
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

pub use element_set::{ElementSet, NoradId, Origin, share_of_stale};
pub use ephemeris::{CovarianceAxes, Ephemeris, EphemerisFrame, EphemerisObject, EphemerisState, PositionCovariance};
pub(crate) use epoch::parse_iso;
pub use error::ElementsError;
pub use generation::{Certainty, Generation, GenerationTable, STARLINK_TABLE_DATE};
pub(crate) use history::others_of;
pub use history::{Chosen, History};
pub use on_station::{OrbitPhase, StationRule, orbit_phases, semi_major_axis_km};
pub(crate) use record::excerpt;
pub use record::{ElementFormat, RejectReason, Rejected};
pub use satellites::{Keep, ReadOptions, Satellites};
pub use shell::{Constellation, ConstellationSet, FIRST_SYNTHETIC_ID, Shell};
pub use source::SourceFile;
pub use tle_file::format_tle;
