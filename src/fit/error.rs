//! Errors of photometry files, fits and Markov chains.

use crate::error::{Error, ErrorKind};

/// Names of the formats of photometry, for error messages.
pub(super) const FORMATS: &str = "pomenis, mmt, score, slingshot, csv";

/// Element sets are required but not given.
pub(super) fn no_history(what: &str) -> Error {
    Error::new(ErrorKind::Missing, format!("element sets for {what} are missing"))
        .allowing("element sets with their history")
}

/// There are more free parameters than points for which the form gives a magnitude.
pub(super) fn too_few(points: usize, free: usize, names: &str, least: usize) -> Error {
    Error::new(ErrorKind::TooFewData, format!("{points} points cannot constrain {free} parameters ({names})"))
        .allowing(format!("at least {least} points"))
}

/// The form gives no magnitude for any of the points.
pub(super) fn no_points(points: usize, form: &str) -> Error {
    Error::new(
        ErrorKind::TooFewData,
        format!(
            "no points to fit: {points} given, and at {points} of them the model {form} has no lit visible surface"
        ),
    )
}

/// None of the descents of a fit reached a finite cost.
pub(super) fn no_minimum(starts: usize) -> Error {
    Error::new(ErrorKind::Invalid, format!("no minimum with a finite cost from any of {starts} starts"))
}

/// A file has no rows.
pub(super) fn empty_file(file: &str) -> Error {
    Error::about_file("", file, "has no rows").allowing(format!("measured magnitudes in one of the formats {FORMATS}"))
}
