//! Output files: tables in every text format, files written completely or not at all, and provenance.
//!
//! A table is a list of [`Column`]s with unit and description, and rows of [`Value`]s. The same rows are written to
//! CSV, ECSV, JSON, JSON lines and VOTable with the same digits.

mod abandoned;
mod atomic;
mod delimited;
mod folder_lock;
mod json;
mod provenance;
mod table;
mod text;
mod votable;

pub use atomic::{AtomicFile, ScratchFolder, check_target, remove_unfinished, write_atomically};
pub(crate) use delimited::{csv_cell, ecsv_column};
pub use delimited::{write_csv, write_csv_rows, write_ecsv};
pub use folder_lock::lock_folder;
pub use json::{Section, write_json, write_json_lines};
pub use provenance::Provenance;
pub use table::{Column, Kind, Table, TableField, Value, json_members, json_rows};
pub use text::{counted, format_utc};
pub use votable::write_votable;
pub(crate) use votable::{votable_cells, votable_fields, votable_table};
