//! Errors of photometry files, fits and Markov chains.

use std::path::PathBuf;

use thiserror::Error;

use super::measurements::DropExample;
use crate::message::Quoted;

/// Names of the formats of photometry, for error messages.
pub(super) const FORMATS: &str = "pomenis, mmt, score, slingshot, csv";

/// Errors of photometry files, fits and Markov chains. Invalid rows are not errors; they are counted in
/// [`DropCounts`](super::measurements::DropCounts).
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FitError {
    /// The list of files is empty.
    #[error("no file of photometry is given; allowed: one or more")]
    NoFiles,
    /// A file cannot be opened, read or decompressed.
    #[error("cannot read {file}: {problem}")]
    Unreadable {
        /// Name of the file.
        file: String,
        /// Message of the operating system or of the decompressor.
        problem: String,
    },
    /// A file has no rows.
    #[error("{file} has no rows; allowed: measured magnitudes in one of the formats {FORMATS}")]
    EmptyFile {
        /// Name of the file.
        file: String,
    },
    /// The header of a file matches none of the known formats.
    #[error(
        "{file}: the format with the header '{header}' is unknown; allowed: {FORMATS}, or any table with a column map", header = Quoted::new(.header)
    )]
    UnknownFormat {
        /// Name of the file.
        file: String,
        /// First line that is not a comment; truncated if it is long.
        header: String,
    },
    /// The name of a format is unknown.
    #[error("unknown format of photometry '{name}'; allowed: {FORMATS}", name = Quoted::new(.name))]
    UnknownFormatName {
        /// Given name.
        name: String,
    },
    /// A required column is missing.
    #[error("{file}: no column '{column}'", column = Quoted::new(.column))]
    Column {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
    },
    /// The unit or the time scale of a column in the file is another one than that of the column map.
    #[error("{file}: column {} is in '{}'; allowed: {allowed}", Quoted::new(.column), Quoted::new(.stated))]
    StatedUnit {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
        /// Unit or time scale that the file states.
        stated: String,
        /// Accepted unit or time scale.
        allowed: String,
    },
    /// A column map is invalid or incomplete.
    #[error("column map: {problem}")]
    ColumnMap {
        /// Description of the problem and of what is allowed.
        problem: String,
    },
    /// A column of times has no time scale. TAI that is read as UTC would be wrong by 37 s.
    #[error("column map: the times of column '{column}' have no scale; allowed: time_scale = utc, tai or tt", column = Quoted::new(.column))]
    NoTimeScale {
        /// Name of the column of times.
        column: String,
    },
    /// A file contains several filters, and none was selected.
    #[error(
        "{file} data row {row}: filter is '{other}' after rows of filter '{first}'; allowed: one filter, unless the filters are specified", other = Quoted::new(.other), first = Quoted::new(.first)
    )]
    MixedFilters {
        /// Name of the file.
        file: String,
        /// Data row, from 1.
        row: u64,
        /// Filter of the first row.
        first: String,
        /// Filter of this data row, which differs from `first`.
        other: String,
    },
    /// An option is outside its range.
    #[error("{name} is {given}; allowed: {allowed}")]
    Setting {
        /// Name of the option.
        name: &'static str,
        /// Given value.
        given: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Element sets are required but not given.
    #[error("element sets for {what} are missing; allowed: element sets with their history")]
    NoHistory {
        /// Operation that requires element sets.
        what: &'static str,
    },
    /// There are no points to fit.
    #[error(
        "no points to fit: {given} given, and at {unexplained} of them the model {form} has no lit visible surface"
    )]
    NoPoints {
        /// Number of points given.
        given: usize,
        /// Number of points for which the form gives no magnitude.
        unexplained: usize,
        /// Name of the form.
        form: String,
    },
    /// There are more free parameters than points.
    #[error("{points} points cannot constrain {free} parameters ({names}); allowed: at least {least} points")]
    TooFew {
        /// Number of points for which the form gives a magnitude.
        points: usize,
        /// Number of free parameters.
        free: usize,
        /// Names of the free parameters.
        names: String,
        /// Smallest number of points.
        least: usize,
    },
    /// A parameter is unknown.
    #[error("unknown parameter {given:?} of the model {form}; allowed: {allowed}", given = Quoted::new(.given))]
    Parameter {
        /// Given name.
        given: String,
        /// Name of the form.
        form: String,
        /// Names of its parameters.
        allowed: String,
    },
    /// The magnitude of a point or its error is invalid.
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
    /// None of the descents of a fit reached a finite cost.
    #[error("no minimum with a finite cost from any of {starts} starts")]
    NoMinimum {
        /// Number of starts.
        starts: usize,
    },
    /// There are fewer groups than folds, or fewer than two folds.
    #[error("{folds} folds of {groups} groups of points (tracks, nights); allowed: 2 to the number of groups")]
    Folds {
        /// Number of groups.
        groups: usize,
        /// Requested folds.
        folds: usize,
    },
    /// No fold contains a point that can be predicted.
    #[error(
        "none of {folds} folds contains a test point: the sky pixels have too few points, or no model has a lit surface there"
    )]
    NoneUnseen {
        /// Requested folds.
        folds: usize,
    },
    /// The number of sets for the jackknife is invalid.
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
    /// A file of chains cannot be read or written, or belongs to another fit.
    #[error("chains {}: {problem}", path.display())]
    ChainFile {
        /// The file.
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
    /// There are too few walkers, or an odd number of them.
    #[error("{walkers} walkers for {parameters} parameters; allowed: an even number of at least {least}")]
    Walkers {
        /// Given number of walkers.
        walkers: usize,
        /// Number of parameters.
        parameters: usize,
        /// Smallest number of walkers.
        least: usize,
    },
    /// The starting position of a walker has probability zero.
    #[error("the starting position of walker {walker} is {position:?}; allowed: positions with a probability above 0")]
    WalkerStart {
        /// Number of the walker.
        walker: usize,
        /// Starting position.
        position: Vec<f64>,
    },
    /// The starting positions lie in a plane, which the stretch move cannot leave.
    #[error(
        "the starting positions of the walkers are equal in parameter {parameter}; allowed: positions that differ in each"
    )]
    FlatWalkers {
        /// Index of the constant parameter.
        parameter: usize,
    },
    /// The length of a chain does not match its numbers of walkers and parameters.
    #[error(
        "the chain has {given} numbers; allowed: as many as {walkers} walkers and {parameters} parameters give in whole steps"
    )]
    ChainShape {
        /// Number of values in the chain.
        given: usize,
        /// Number of walkers.
        walkers: usize,
        /// Number of parameters.
        parameters: usize,
    },
    /// A folder contains none of the known files.
    #[error("no photometry in {}; allowed: {looked_for}", folder.display())]
    NoPhotometry {
        /// The folder.
        folder: PathBuf,
        /// Paths of the known files in it.
        looked_for: String,
    },
    /// A file of published measurements cannot be read.
    #[error("photometry {}: {problem}", path.display())]
    CheckUnreadable {
        /// The file.
        path: PathBuf,
        /// Message of the operating system or of the table reader.
        problem: String,
    },
    /// A row of a published set is invalid. Published sets are complete, so that every row must be valid.
    #[error("photometry {0}")]
    #[doc(hidden)]
    CheckRow(DropExample),
}
