//! Rows that were not used: how many for which reason, and the first example of each.

use std::fmt;

use crate::output::{Column, Kind, Table};

/// Why a row was not used.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum DropReason {
    /// A cell that cannot be what its column says, or a row cut short.
    Unparsable,
    /// Through a filter that is not wanted.
    WrongFilter,
    /// The magnitude is empty, no number, or a stand-in for "none" (beyond -30 to 40, or 99 and the like).
    NoMagnitude,
    /// The same as an earlier row, cell for cell.
    Duplicate,
    /// Flagged by the survey as in the penumbra.
    PenumbraFlag,
    /// The line from the Sun to the satellite passes too near to the ground (100 km rule).
    Shaded,
    /// Below the altitude allowed at the site: the satellite is another one.
    BelowHorizon,
    /// No element set of this satellite, or no satellite named.
    NoElements,
    /// No element set near enough in time.
    StaleElements,
    /// The element set gives no position.
    NoPosition,
    /// Raising, decaying, parked, or not known to be on station.
    OffStation,
    /// Time, distance, angles or site do not make a geometry, or one too near to straight below.
    NoGeometry,
    /// Range or phase of the named satellite are not those of the record.
    WrongAssociation,
}

impl DropReason {
    /// All of them, in the order in which rows are tried.
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

    /// As tables write it.
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

/// One dropped row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DropExample {
    /// Name of the file; empty where rows came from none.
    pub file: String,
    /// Data row of the file, from 1: header and comments are not counted.
    pub row: u64,
    /// What stood there, and what was expected; empty where the reason says it all.
    pub problem: String,
}

impl fmt::Display for DropExample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let separator = if self.file.is_empty() { "" } else { " " };
        write!(f, "{}{separator}data row {}", self.file, self.row)?;
        if self.problem.is_empty() { Ok(()) } else { write!(f, ": {}", self.problem) }
    }
}

/// How many rows were dropped for which reason, and the first of each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DropCounts {
    counts: [u64; DropReason::ALL.len()],
    examples: [Option<DropExample>; DropReason::ALL.len()],
}

const COLUMNS: [Column; 5] = [
    Column::new("reason", Kind::Text, "Why rows were not used."),
    Column::new("count", Kind::Integer, "How many."),
    Column::new("file", Kind::Text, "File of the first one."),
    Column::new("row", Kind::Integer, "Data row of the first one, from 1."),
    Column::new("problem", Kind::Text, "What stood there."),
];

impl DropCounts {
    /// Rows dropped for a reason.
    pub fn count(&self, reason: DropReason) -> u64 {
        self.counts[reason as usize]
    }

    /// The first of them.
    pub fn example(&self, reason: DropReason) -> Option<&DropExample> {
        self.examples[reason as usize].as_ref()
    }

    /// All rows dropped.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Reasons that occurred, with their counts and first examples.
    pub fn iter(&self) -> impl Iterator<Item = (DropReason, u64, Option<&DropExample>)> {
        DropReason::ALL
            .into_iter()
            .map(|reason| (reason, self.count(reason), self.example(reason)))
            .filter(|of| of.1 > 0)
    }

    /// One row a reason that occurred.
    pub fn table(&self) -> Table {
        let row = |(reason, count, example): (DropReason, u64, Option<&DropExample>)| {
            vec![
                reason.name().into(),
                (count as i64).into(),
                example.map(|one| one.file.as_str()).into(),
                example.map(|one| one.row as i64).into(),
                example.map(|one| one.problem.as_str()).into(),
            ]
        };
        Table { columns: COLUMNS.to_vec(), rows: self.iter().map(row).collect() }
    }

    /// One more; the example is made only where it is the first.
    pub(super) fn add(&mut self, reason: DropReason, example: impl FnOnce() -> DropExample) {
        self.counts[reason as usize] += 1;
        self.examples[reason as usize].get_or_insert_with(example);
    }

    /// Those of later rows.
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

    /// For counts of a part of a file whose rows were counted from its own beginning.
    pub(super) fn shift_rows(&mut self, file: &str, rows: u64) {
        for example in self.examples.iter_mut().flatten() {
            example.row += rows;
            example.file = file.to_owned();
        }
    }
}
