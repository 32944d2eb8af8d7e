//! Numbers of rows that were not used, by reason, with the first example of each reason.

use std::fmt;

use crate::output::{Column, Kind, Table};

/// Reason why a row was not used.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum DropReason {
    /// A value cannot be parsed, or the row is truncated.
    Unparsable,
    /// The filter is not among the selected ones.
    WrongFilter,
    /// The magnitude is empty, not a number, or a placeholder (outside -30 to 40, for example 99).
    NoMagnitude,
    /// All values equal those of an earlier row.
    Duplicate,
    /// The survey flags the satellite as in the penumbra.
    PenumbraFlag,
    /// The line from the Sun to the satellite passes too near the ground (100 km rule).
    Shaded,
    /// The satellite is below the lowest altitude at the site, so that a different object must have been observed.
    BelowHorizon,
    /// There is no element set of the satellite, or the satellite is not identified.
    NoElements,
    /// No element set is near enough in time.
    StaleElements,
    /// SGP4 cannot compute a position from the element set.
    NoPosition,
    /// The satellite is raising, decaying, parked, or in an unknown phase.
    OffStation,
    /// Time, distance, angles and site determine no viewing geometry, or one too close to the nadir.
    NoGeometry,
    /// Range or phase angle of the given satellite differ from those of the record.
    WrongAssociation,
}

impl DropReason {
    /// All reasons, in the order in which tables list them.
    pub const ALL: [Self; 13] = [
        Self::Unparsable,
        Self::WrongFilter,
        Self::NoMagnitude,
        Self::Duplicate,
        Self::PenumbraFlag,
        Self::Shaded,
        Self::BelowHorizon,
        Self::NoElements,
        Self::StaleElements,
        Self::NoPosition,
        Self::OffStation,
        Self::NoGeometry,
        Self::WrongAssociation,
    ];

    /// Returns the name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unparsable => "unparsable",
            Self::WrongFilter => "wrong_filter",
            Self::NoMagnitude => "no_magnitude",
            Self::Duplicate => "duplicate",
            Self::PenumbraFlag => "penumbra_flag",
            Self::Shaded => "shaded",
            Self::BelowHorizon => "below_horizon",
            Self::NoElements => "no_elements",
            Self::StaleElements => "stale_elements",
            Self::NoPosition => "no_position",
            Self::OffStation => "off_station",
            Self::NoGeometry => "no_geometry",
            Self::WrongAssociation => "wrong_association",
        }
    }
}

/// Example of a dropped row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DropExample {
    /// Name of the file; empty for rows that are not from a file.
    pub file: String,
    /// Data row of the file, from 1, without header and comments.
    pub row: u64,
    /// Description of the given and the expected content; empty if the reason alone suffices.
    pub problem: String,
}

impl fmt::Display for DropExample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let separator = if self.file.is_empty() { "" } else { " " };
        write!(f, "{}{separator}data row {}", self.file, self.row)?;
        if self.problem.is_empty() { Ok(()) } else { write!(f, ": {}", self.problem) }
    }
}

/// Numbers of dropped rows by reason, with the first example of each reason.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DropCounts {
    counts: [u64; DropReason::ALL.len()],
    examples: [Option<DropExample>; DropReason::ALL.len()],
}

const COLUMNS: [Column; 5] = [
    Column::new("reason", Kind::Text, "Reason why rows were not used."),
    Column::new("count", Kind::Integer, "Number of rows."),
    Column::new("file", Kind::Text, "File of the first row."),
    Column::new("row", Kind::Integer, "Data row of the first row, from 1."),
    Column::new("problem", Kind::Text, "Given and expected content."),
];

impl DropCounts {
    /// Returns the number of rows that were dropped for a reason.
    pub fn count(&self, reason: DropReason) -> u64 {
        self.counts[reason as usize]
    }

    /// Returns the first row that was dropped for a reason.
    pub fn example(&self, reason: DropReason) -> Option<&DropExample> {
        self.examples[reason as usize].as_ref()
    }

    /// Returns the number of all dropped rows.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Returns the reasons that occurred, with their numbers of rows and first examples.
    pub fn iter(&self) -> impl Iterator<Item = (DropReason, u64, Option<&DropExample>)> {
        DropReason::ALL
            .into_iter()
            .map(|reason| (reason, self.count(reason), self.example(reason)))
            .filter(|of| of.1 > 0)
    }

    /// Returns a table with one row per reason that occurred.
    pub fn table(&self) -> Table {
        let row = |(reason, count, example): (DropReason, u64, Option<&DropExample>)| {
            vec![
                reason.name().into(),
                (count as i64).into(),
                example.map(|example| example.file.as_str()).into(),
                example.map(|example| example.row as i64).into(),
                example.map(|example| example.problem.as_str()).into(),
            ]
        };
        Table { columns: COLUMNS.to_vec(), rows: self.iter().map(row).collect() }
    }

    /// Counts one row. The example is created only for the first row of its reason.
    pub(super) fn add(&mut self, reason: DropReason, example: impl FnOnce() -> DropExample) {
        self.counts[reason as usize] += 1;
        self.examples[reason as usize].get_or_insert_with(example);
    }

    /// Adds the numbers of rows that follow in the same source.
    pub(super) fn append(&mut self, later: Self) {
        for (mine, more) in self.counts.iter_mut().zip(later.counts) {
            *mine += more;
        }
        for (mine, more) in self.examples.iter_mut().zip(later.examples) {
            if mine.is_none() {
                *mine = more;
            }
        }
    }

    /// Converts row numbers within a block to those of the file.
    pub(super) fn shift_rows(&mut self, file: &str, rows: u64) {
        for example in self.examples.iter_mut().flatten() {
            example.row += rows;
            example.file = file.to_owned();
        }
    }
}
