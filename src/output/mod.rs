//! Tables as they leave the house: columns with unit and meaning, written once, in every text format.
//!
//! The room knows nothing of satellites. A table of any room is a list of [`Column`]s and rows of [`Value`]s; the same
//! rows go to CSV, ECSV, JSON, JSON lines, VOTable and (feature `parquet`) Parquet with the same digits.

mod atomic;
mod column;
mod count;
mod csv;
mod ecsv;
mod instant;
mod json;
#[cfg(feature = "parquet")]
mod parquet;
mod provenance;
mod value;
mod votable;

pub use self::csv::write_csv;
#[cfg(feature = "parquet")]
pub use self::parquet::write_parquet;
#[cfg(feature = "parquet")]
pub(crate) use self::parquet::{parquet_columns, parquet_fields};
pub use atomic::{AtomicFile, ScratchFolder, check_target, write_atomically};
pub use column::{Column, Kind};
pub use count::counted;
pub use ecsv::{ecsv_column, write_ecsv};
pub use instant::format_utc;
pub use json::{Section, json_members, json_rows, write_json, write_json_lines};
pub use provenance::Provenance;
pub use value::{Table, Value};
pub use votable::{votable_cells, votable_fields, votable_table, write_votable};
