//! Errors of a fit.

use std::path::PathBuf;

use thiserror::Error;

use super::inference::EnsembleError;
use super::measurements::MeasurementError;

/// Errors of a fit.
#[derive(Debug, Error)]
pub enum FitError {
    /// No point is left.
    #[error(
        "no point is left to fit: {given} given; at {unexplained} of them the model {form} has no lit visible surface"
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
    #[error("{points} points cannot constrain {free} parameters ({names}): at least {least} points are needed")]
    TooFew {
        /// Points that the form explains.
        points: usize,
        /// Number of free parameters.
        free: usize,
        /// Their names.
        names: String,
        /// Least number of points.
        least: usize,
    },
    /// An unknown parameter.
    #[error("unknown parameter {given:?} of the model {form}; known are {allowed}")]
    Parameter {
        /// As it was given.
        given: String,
        /// Name of the form.
        form: String,
        /// Names of its parameters.
        allowed: String,
    },
    /// An invalid error or magnitude.
    #[error("point {index}: {quantity} is {given}, allowed is {allowed}")]
    Point {
        /// Index of the point.
        index: usize,
        /// Name of the invalid quantity.
        quantity: &'static str,
        /// As it was given.
        given: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// No descent ended at a finite cost.
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
    /// No point of any fold can be predicted.
    #[error(
        "no point is left in {folds} folds held out: their pixels contain too few points, or no form explains them"
    )]
    NoneUnseen {
        /// Requested folds.
        folds: usize,
    },
    /// Invalid number of sets for the jackknife.
    #[error(
        "{sets} sets of {groups} groups of points (tracks, nights); allowed: more sets than the {free} free parameters, at most as many as groups"
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
    /// Invalid ensemble of walkers.
    #[error(transparent)]
    Ensemble(#[from] EnsembleError),
    /// A file of chains cannot be read or written, or belongs to another fit.
    #[error("chains {}: {problem}", path.display())]
    ChainFile {
        /// The file.
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
}
