//! Errors of a fit.

use std::path::PathBuf;

use thiserror::Error;

use super::inference::EnsembleError;
use super::measurements::MeasurementError;

/// Errors of a fit.
#[derive(Debug, Error)]
pub enum FitError {
    /// An empty set of points.
    #[error(
        "no points to fit: {given} given, and at {unexplained} of them the model {form} has no lit visible surface"
    )]
    Empty {
        /// Points given.
        given: usize,
        /// Points that the form does not explain.
        unexplained: usize,
        /// Name of the form.
        form: String,
    },
    /// More free parameters than points.
    #[error("{points} points cannot constrain {free} parameters ({names}): expected at least {least} points")]
    TooFew {
        /// Points that the form explains.
        points: usize,
        /// Number of free parameters.
        free: usize,
        /// Names of the free parameters.
        names: String,
        /// Least number of points.
        least: usize,
    },
    /// An unknown parameter.
    #[error("unknown parameter {given:?} of the model {form}: expected one of {allowed}")]
    Parameter {
        /// Given name.
        given: String,
        /// Name of the form.
        form: String,
        /// Names of its parameters.
        allowed: String,
    },
    /// An invalid error or magnitude.
    #[error("point {index}: {quantity} is {given}, allowed: {allowed}")]
    Point {
        /// Index of the point.
        index: usize,
        /// Name of the invalid quantity.
        quantity: &'static str,
        /// Given value.
        given: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// A fit whose descents all failed.
    #[error("no minimum with a finite cost from any of {starts} starts")]
    NoMinimum {
        /// Number of starts.
        starts: usize,
    },
    /// Fewer groups than folds.
    #[error("{groups} groups of points (tracks, nights) cannot be held out in {folds} folds")]
    Folds {
        /// Number of groups.
        groups: usize,
        /// Requested folds.
        folds: usize,
    },
    /// Folds without a point that can be predicted.
    #[error("no points in {folds} folds held out: their pixels contain too few points, or no form explains them")]
    NoneUnseen {
        /// Requested folds.
        folds: usize,
    },
    /// An invalid number of sets for the jackknife.
    #[error(
        "invalid number of sets {sets} for {groups} groups of points (tracks, nights); allowed: more than the {free} free parameters, at most the number of groups"
    )]
    Sets {
        /// Requested sets.
        sets: usize,
        /// Number of groups.
        groups: usize,
        /// Number of free parameters.
        free: usize,
    },
    /// Invalid options of a reduction.
    #[error(transparent)]
    Reduction(#[from] MeasurementError),
    /// An invalid ensemble of walkers.
    #[error(transparent)]
    Ensemble(#[from] EnsembleError),
    /// A file of chains that cannot be read or written, or belongs to another fit.
    #[error("chains {}: {problem}", path.display())]
    ChainFile {
        /// The file.
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
}
