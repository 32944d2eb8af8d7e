//! Errors of photometry files, fits and chains.

use std::path::PathBuf;

use thiserror::Error;

use super::measurements::DropExample;

/// Names of the formats of photometry, for messages.
pub(super) const FORMATS: &str = "pomenis, mmt, score, slingshot, csv";

/// Errors of photometry files, fits and chains. Invalid rows are no errors but are counted in [`DropCounts`](super::measurements::DropCounts).
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FitError {
    /// No file was given.
    #[error("no file of photometry given")]
    NoFiles,
    /// A file cannot be opened, read or decompressed.
    #[error("cannot read {file}: {problem}")]
    Unreadable {
        /// Name of the file.
        file: String,
        /// Message of the system or of the decompression.
        problem: String,
    },
    /// A file without rows.
    #[error("{file} has no rows; expected measured magnitudes in one of the formats {FORMATS}")]
    EmptyFile {
        /// Name of the file.
        file: String,
    },
    /// The header matches none of the known formats.
    #[error("{file}: the header '{header}' belongs to no known format; name one of {FORMATS}, or give a column map")]
    UnknownFormat {
        /// Name of the file.
        file: String,
        /// The first line that is no comment, truncated.
        header: String,
    },
    /// An unknown name of a format.
    #[error("unknown format of photometry '{name}'; known are {FORMATS}")]
    UnknownFormatName {
        /// The given name.
        name: String,
    },
    /// A missing column.
    #[error("{file}: no column '{column}'")]
    Column {
        /// Name of the file.
        file: String,
        /// The column.
        column: String,
    },
    /// An invalid or incomplete column map.
    #[error("column map: {problem}")]
    ColumnMap {
        /// The problem and what is allowed.
        problem: String,
    },
    /// A column of times without a time scale; TAI taken for UTC would be 37 s off.
    #[error("column map: the times of column '{column}' have no scale; specify time_scale = utc, tai or tt")]
    NoTimeScale {
        /// The column of times.
        column: String,
    },
    /// Two filters in one file without a choice.
    #[error("{file} data row {row}: filter '{other}' after rows of filter '{first}'; name the filters that are wanted")]
    MixedFilters {
        /// Name of the file.
        file: String,
        /// Data row, from 1.
        row: u64,
        /// The filter of the first row.
        first: String,
        /// The other one.
        other: String,
    },
    /// An option outside its range.
    #[error("{name} {given} is not allowed: {allowed}")]
    Setting {
        /// Name of the option.
        name: &'static str,
        /// The given value.
        given: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Missing element sets.
    #[error("{what} needs element sets, and none were given")]
    NoHistory {
        /// What needs them.
        what: &'static str,
    },
    /// No point is left.
    #[error(
        "no point is left to fit: {given} given; at {unexplained} of them the model {form} has no lit visible surface"
    )]
    NoPoints {
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
    /// A file of chains cannot be read or written, or belongs to another fit.
    #[error("chains {}: {problem}", path.display())]
    ChainFile {
        /// The file.
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
    /// Too few walkers or an odd number of them.
    #[error("{walkers} walkers for {parameters} parameters: an even number of at least {least} is needed")]
    Walkers {
        /// Given number of walkers.
        walkers: usize,
        /// Number of parameters.
        parameters: usize,
        /// Least number of walkers.
        least: usize,
    },
    /// A starting place with probability zero.
    #[error("walker {walker} starts at a place of zero or invalid probability: {place:?}")]
    WalkerStart {
        /// Number of the walker.
        walker: usize,
        /// Its starting place.
        place: Vec<f64>,
    },
    /// All walkers start in a plane, which the stretch move cannot leave.
    #[error("the walkers' starting places do not differ in parameter {parameter}")]
    FlatWalkers {
        /// Index of the constant parameter.
        parameter: usize,
    },
    /// A chain whose length does not match the numbers of walkers and parameters.
    #[error("the chain has {given} numbers, not those of {walkers} walkers and {parameters} parameters at each step")]
    ChainShape {
        /// Length of the chain.
        given: usize,
        /// Number of walkers.
        walkers: usize,
        /// Number of parameters.
        parameters: usize,
    },
    /// The folder contains none of the known files.
    #[error("no photometry in {}: looked for {looked_for}", folder.display())]
    NoPhotometry {
        /// The folder.
        folder: PathBuf,
        /// Paths of the known files in it.
        looked_for: String,
    },
    /// A file cannot be read.
    #[error("photometry {}: {problem}", path.display())]
    CheckUnreadable {
        /// The file.
        path: PathBuf,
        /// Message of the system or of the table's reader.
        problem: String,
    },
    /// A row is invalid. Published sets are complete, so that every row is required.
    #[error("photometry {0}")]
    CheckRow(DropExample),
}
