//! Errors of photometry files, fits and chains.

use std::path::PathBuf;

use thiserror::Error;

use super::measurements::DropExample;

/// Names of the formats of photometry, for messages.
pub(super) const FORMATS: &str = "pomenis, mmt, score, slingshot, csv";

/// Errors of photometry files, fits and chains. Invalid rows are no errors but are counted in
/// [`DropCounts`](super::measurements::DropCounts).
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FitError {
    /// An empty list of files.
    #[error("no file of photometry is given; allowed: one or more")]
    NoFiles,
    /// A file that cannot be opened, read or decompressed.
    #[error("cannot read {file}: {problem}")]
    Unreadable {
        /// Name of the file.
        file: String,
        /// Message of the system or of the decompression.
        problem: String,
    },
    /// A file without rows.
    #[error("{file} has no rows; allowed: measured magnitudes in one of the formats {FORMATS}")]
    EmptyFile {
        /// Name of the file.
        file: String,
    },
    /// A header that matches none of the known formats.
    #[error(
        "{file}: the format with the header '{header}' is unknown; allowed: {FORMATS}, or any table with a column map"
    )]
    UnknownFormat {
        /// Name of the file.
        file: String,
        /// First line that is not a comment, truncated.
        header: String,
    },
    /// An unknown name of a format.
    #[error("unknown format of photometry '{name}'; allowed: {FORMATS}")]
    UnknownFormatName {
        /// Given name.
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
    /// A column of times without a time scale; TAI read as UTC would be 37 s off.
    #[error("column map: the times of column '{column}' have no scale; allowed: time_scale = utc, tai or tt")]
    NoTimeScale {
        /// The column of times.
        column: String,
    },
    /// Several filters in one file without a selection.
    #[error(
        "{file} data row {row}: filter is '{other}' after rows of filter '{first}'; allowed: one filter, unless the filters are specified"
    )]
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
    #[error("{name} is {given}; allowed: {allowed}")]
    Setting {
        /// Name of the option.
        name: &'static str,
        /// Given value.
        given: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Missing element sets.
    #[error("{what} requires element sets; none are given")]
    NoHistory {
        /// Operation that requires them.
        what: &'static str,
    },
    /// An empty set of points.
    #[error(
        "no points to fit: {given} given, and at {unexplained} of them the model {form} has no lit visible surface"
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
    #[error("{points} points cannot constrain {free} parameters ({names}); allowed: at least {least} points")]
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
    #[error("unknown parameter {given:?} of the model {form}; allowed: {allowed}")]
    Parameter {
        /// Given name.
        given: String,
        /// Name of the form.
        form: String,
        /// Names of its parameters.
        allowed: String,
    },
    /// An invalid error or magnitude.
    #[error("point {index}: {quantity} is {given}; allowed: {allowed}")]
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
    #[error("{folds} folds of {groups} groups of points (tracks, nights); allowed: 2 to the number of groups")]
    Folds {
        /// Number of groups.
        groups: usize,
        /// Requested folds.
        folds: usize,
    },
    /// Folds without a point that can be predicted.
    #[error(
        "none of {folds} folds contains a test point: the sky pixels have too few points, or no model has a lit surface there"
    )]
    NoneUnseen {
        /// Requested folds.
        folds: usize,
    },
    /// An invalid number of sets for the jackknife.
    #[error(
        "number of sets is {sets} for {groups} groups of points (tracks, nights); allowed: more than the {free} free parameters, at most the number of groups"
    )]
    Sets {
        /// Requested sets.
        sets: usize,
        /// Number of groups.
        groups: usize,
        /// Number of free parameters.
        free: usize,
    },
    /// A file of chains that cannot be read or written, or belongs to another fit.
    #[error("chains {}: {problem}", path.display())]
    ChainFile {
        /// The file.
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
    /// Too few walkers or an odd number of them.
    #[error("{walkers} walkers for {parameters} parameters; allowed: an even number of at least {least}")]
    Walkers {
        /// Given number of walkers.
        walkers: usize,
        /// Number of parameters.
        parameters: usize,
        /// Least number of walkers.
        least: usize,
    },
    /// A starting position with probability zero.
    #[error("walker {walker} starts at a position with zero or invalid probability: {place:?}")]
    WalkerStart {
        /// Number of the walker.
        walker: usize,
        /// Starting position.
        place: Vec<f64>,
    },
    /// Starting positions in a plane, which the stretch move cannot leave.
    #[error("the starting positions of the walkers do not differ in parameter {parameter}")]
    FlatWalkers {
        /// Index of the constant parameter.
        parameter: usize,
    },
    /// A chain of unexpected length.
    #[error("the chain has {given} numbers, which do not match {walkers} walkers and {parameters} parameters")]
    ChainShape {
        /// Length of the chain.
        given: usize,
        /// Number of walkers.
        walkers: usize,
        /// Number of parameters.
        parameters: usize,
    },
    /// A folder without any of the known files.
    #[error("no photometry in {}; allowed: {looked_for}", folder.display())]
    NoPhotometry {
        /// The folder.
        folder: PathBuf,
        /// Paths of the known files in it.
        looked_for: String,
    },
    /// A file that cannot be read.
    #[error("photometry {}: {problem}", path.display())]
    CheckUnreadable {
        /// The file.
        path: PathBuf,
        /// Message of the system or of the table reader.
        problem: String,
    },
    /// An invalid row. Published sets are complete, so that every row is required.
    #[error("photometry {0}")]
    CheckRow(DropExample),
}
