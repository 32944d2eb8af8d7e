//! Why a fit cannot be made.

use std::path::PathBuf;

use thiserror::Error;

use super::measurements::MeasuredError;

use super::inference::EnsembleError;

/// Why a fit cannot be made.
#[derive(Debug, Error)]
pub enum FitError {
    /// Nothing is left to be explained.
    #[error("no point is left to fit: {given} given, {unexplained} of them where the model {form} sees nothing lit")]
    Empty {
        /// Points given.
        given: usize,
        /// Points that the form says nothing of.
        unexplained: usize,
        /// Name of the form.
        form: String,
    },
    /// More unknowns than points.
    #[error("{points} points cannot fix {free} parameters ({names}): at least {least} points are needed")]
    TooFew {
        /// Points that can be fitted.
        points: usize,
        /// Free parameters.
        free: usize,
        /// Their names.
        names: String,
        /// Least number of points.
        least: usize,
    },
    /// A parameter that the form does not have.
    #[error("{given:?} is no parameter of the model {form}; they are {allowed}")]
    Parameter {
        /// As it was given.
        given: String,
        /// Name of the form.
        form: String,
        /// Names that it has.
        allowed: String,
    },
    /// An error or a magnitude that is none.
    #[error("point {index}: {quantity} is {given}, allowed is {allowed}")]
    Point {
        /// Its place in the list, from 0.
        index: usize,
        /// What is wrong.
        quantity: &'static str,
        /// As it was given.
        given: f64,
        /// What may stand there.
        allowed: &'static str,
    },
    /// No starting place led anywhere.
    #[error("none of {starts} starting places led to a minimum with a finite cost")]
    NoMinimum {
        /// How many were tried.
        starts: usize,
    },
    /// Fewer groups than folds.
    #[error("{groups} groups of points (tracks, nights) cannot be held out in {folds} folds")]
    Folds {
        /// Groups there are.
        groups: usize,
        /// Folds asked for.
        folds: usize,
    },
    /// No point of any fold can be judged.
    #[error(
        "no point is left of those held out in {folds} folds: the pixels of so few tracks hold too few points, or no form says anything of them"
    )]
    NoneUnseen {
        /// Folds asked for.
        folds: usize,
    },
    /// Sets of groups for the jackknife.
    #[error(
        "{groups} groups of points (tracks, nights) in {sets} sets: allowed are more sets than the {free} free parameters, and no more than groups"
    )]
    Sets {
        /// Sets asked for.
        sets: usize,
        /// Groups there are.
        groups: usize,
        /// Free parameters.
        free: usize,
    },
    /// Measurements that cannot be reduced again.
    #[error(transparent)]
    Reduction(#[from] MeasuredError),
    /// The ensemble of walkers.
    #[error(transparent)]
    Ensemble(#[from] EnsembleError),
    /// A file of chains that cannot be read or written, or is not of this fit.
    #[error("chains {}: {problem}", path.display())]
    ChainFile {
        /// Where.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
}
