//! Errors of schedules.

use std::path::Path;

use crate::error::Error;
#[cfg(feature = "sqlite")]
use crate::error::ErrorKind;

/// Accepted columns of a schedule, for error messages.
pub(super) const ALLOWED_COLUMNS: &str = "exposure_id, start_utc (or start_mjd, start_jd with --time-scale, or \
     start_mjd_utc, start_mjd_tai, start_mjd_tt and the like), duration_s, ra_deg, dec_deg and, if known, rotation_deg, band; \
     the names used by Rubin's opsim and ConsDB and by ObsLocTAP are also accepted";

/// The file is empty.
pub(super) fn empty(path: &Path) -> Error {
    Error::about_file("schedule", path, "is empty")
        .allowing("opsim SQLite, CSV, ECSV, JSON or VOTable with at least one exposure")
}

/// The file has columns but no rows.
pub(super) fn no_rows(path: &Path) -> Error {
    Error::about_file("schedule", path, "has columns but no exposures").allowing("at least one row")
}

/// The file has more rows than the largest number.
pub(super) fn too_many_rows(path: &Path, most: usize) -> Error {
    Error::about_file("schedule", path, format!("has more than {most} rows"))
        .allowing(format!("at most {most}; split it"))
}

/// The format is not supported.
pub(super) fn format(path: &Path, what: impl Into<String>) -> Error {
    Error::format(what).in_file("schedule", path).allowing("opsim SQLite, CSV, ECSV, JSON or VOTable (TABLEDATA)")
}

/// The file has an earlier annotation.
pub(super) fn already_there(path: &Path, what: &str) -> Error {
    Error::about_file("schedule", path, format!("already has {what}")).allowing("--replace, which replaces them")
}

/// The number of rows of the file changed between reading and writing.
pub(super) fn changed(path: &Path, rows: usize, flags: usize) -> Error {
    Error::about_file("schedule", path, format!("has {rows} rows"))
        .allowing(format!("the {flags} rows that were judged (the file changed in between)"))
}

/// SQLite cannot read the file.
#[cfg(feature = "sqlite")]
pub(super) fn sqlite(path: &Path, source: rusqlite::Error) -> Error {
    Error::caused(ErrorKind::File, source).in_file("schedule", path).allowing("a complete SQLite database")
}
