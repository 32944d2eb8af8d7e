//! Which satellites: element sets from every syntax in use, their history, synthetic shells, and which kind each is.

#[allow(clippy::module_inception)]
mod catalogue;
mod element_set;
mod epoch;
mod history;
mod omm;
mod omm_csv;
mod omm_json;
mod omm_kvn;
mod omm_xml;
mod record;
mod source;
mod tle;
mod tle_file;

pub use catalogue::{Catalogue, Keep, ReadOptions};
pub use element_set::{ElementSet, NoradId, Origin};
pub use history::History;
pub use record::{RecordError, Rejected};
pub use source::{CatalogueError, ElementFormat, SourceFile};
pub use tle::{TleFormatError, format_tle};
