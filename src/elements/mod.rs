//! Which satellites: element sets from every syntax in use, their history, synthetic shells, and which kind each is.

#[allow(clippy::module_inception)]
mod catalogue;
mod chunks;
mod element_set;
mod epoch;
mod generation;
mod history;
mod mean_motion;
mod omm;
mod omm_csv;
mod omm_json;
mod omm_kvn;
mod omm_xml;
mod on_station;
mod record;
mod shell;
mod source;
mod tle;
mod tle_fields;
mod tle_file;
mod tle_write;

pub use catalogue::{Catalogue, Keep, ReadOptions};
pub use element_set::{ElementSet, NoradId, Origin};
#[cfg(feature = "fit")]
pub(crate) use epoch::parse_iso;
pub use generation::{Certainty, Generation, GenerationTable};
pub use history::History;
pub use mean_motion::semi_major_axis_km;
pub use on_station::{OrbitPhase, StationRule, orbit_phases};
pub use record::{RecordError, Rejected};
pub use shell::{Constellation, FIRST_SYNTHETIC_ID, Shell, ShellError};
pub use source::{CatalogueError, ElementFormat, SourceFile};
pub use tle_write::{TleFormatError, format_tle};
