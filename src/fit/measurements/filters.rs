//! Numbers of rows by filter, and their comparison with the band of a model.

use std::fmt;

use crate::photometry::Band;

/// Numbers of rows by filter.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FilterCounts {
    /// Counts in the order of the first rows; `None` for rows without a filter.
    counts: Vec<(Option<String>, u64)>,
}

/// Photometry that may not be in the band of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BandMismatch {
    band: Band,
    seen: FilterCounts,
}

impl FilterCounts {
    /// Each filter with its number of rows.
    pub fn iter(&self) -> impl Iterator<Item = (Option<&str>, u64)> {
        self.counts.iter().map(|(filter, count)| (filter.as_deref(), *count))
    }

    /// Mismatch if any row has another filter than `band` or none. Case matters (`R` is Cousins', `r` LSST's), and a
    /// survey's own filter (`Clear`) is not a band.
    pub fn mismatch(&self, band: Band) -> Option<BandMismatch> {
        let is_other = |filter: Option<&str>| filter.and_then(|name| name.parse::<Band>().ok()) != Some(band);
        self.iter().any(|(filter, _)| is_other(filter)).then(|| BandMismatch { band, seen: self.clone() })
    }

    /// Adds rows of a filter.
    pub(super) fn add(&mut self, filter: Option<&str>, rows: u64) {
        match self.counts.iter_mut().find(|(known, _)| known.as_deref() == filter) {
            Some((_, count)) => *count += rows,
            None => self.counts.push((filter.map(str::to_owned), rows)),
        }
    }

    /// Adds the counts of later rows.
    pub(super) fn append(&mut self, later: &Self) {
        later.iter().for_each(|(filter, rows)| self.add(filter, rows));
    }
}

impl fmt::Display for BandMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let filters = self.seen.iter().map(|(filter, rows)| match filter {
            Some(name) => format!("{name} ({rows} rows)"),
            None => format!("an unnamed filter ({rows} rows)"),
        });
        let filters = filters.collect::<Vec<_>>().join(", ");
        let mixed = if self.seen.counts.len() > 1 { "mixed filters: " } else { "" };
        write!(f, "{mixed}photometry through {filters} is taken as {}, the model's band", self.band)?;
        write!(f, "; differences of colour or zero point enter the fit")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_only_the_models_band_matches() {
        let counts = |rows: &[(Option<&str>, u64)]| {
            let mut counts = FilterCounts::default();
            rows.iter().for_each(|(filter, rows)| counts.add(*filter, *rows));
            counts.mismatch(Band::V).map(|mismatch| mismatch.to_string())
        };
        assert_eq!(counts(&[(Some("V"), 3), (Some("V"), 4)]), None);
        assert_eq!(counts(&[]), None);
        for (rows, parts) in [
            (vec![(Some("Clear"), 3), (Some("Clear"), 4)], ["photometry through Clear (7 rows)", "taken as V"]),
            (vec![(None, 5)], ["an unnamed filter (5 rows)", "taken as V"]),
            (vec![(Some("V"), 5), (Some("B"), 1)], ["mixed filters", "V (5 rows), B (1 rows)"]),
            (vec![(Some("v"), 5)], ["v (5 rows)", "taken as V"]),
        ] {
            let message = counts(&rows).unwrap_or_default();
            assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        }
    }
}
