//! Through which filters rows were seen, and whether that is the band of the model that they are fitted with.

use std::fmt;

use crate::photometry::Band;

/// Rows read, by the filter that they name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FilterCounts {
    /// In the order of their first rows; the name is `None` of rows that name no filter.
    counts: Vec<(Option<String>, u64)>,
}

/// Photometry that is not, or not for sure, in the band of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BandDoubt {
    band: Band,
    seen: FilterCounts,
}

impl FilterCounts {
    /// Each filter with its number of rows.
    pub fn iter(&self) -> impl Iterator<Item = (Option<&str>, u64)> {
        self.counts.iter().map(|(filter, count)| (filter.as_deref(), *count))
    }

    /// What there is to say where any row is of another filter than `band`, or of none that is named. Upper and lower case differ (`R` is
    /// Cousins', `r` LSST's), and a survey's own filter (`Clear`) is no band.
    pub fn doubt(&self, band: Band) -> Option<BandDoubt> {
        let is_other = |filter: Option<&str>| filter.and_then(|name| name.parse::<Band>().ok()) != Some(band);
        self.iter().any(|(filter, _)| is_other(filter)).then(|| BandDoubt { band, seen: self.clone() })
    }

    /// So many more rows.
    pub(super) fn add(&mut self, filter: Option<&str>, rows: u64) {
        match self.counts.iter_mut().find(|(known, _)| known.as_deref() == filter) {
            Some((_, count)) => *count += rows,
            None => self.counts.push((filter.map(str::to_owned), rows)),
        }
    }

    /// Those of later rows.
    pub(super) fn append(&mut self, later: &Self) {
        later.iter().for_each(|(filter, rows)| self.add(filter, rows));
    }
}

impl fmt::Display for BandDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = self.seen.iter().map(|(filter, rows)| match filter {
            Some(name) => format!("{name} ({rows} rows)"),
            None => format!("a filter that nothing names ({rows} rows)"),
        });
        let words = words.collect::<Vec<_>>().join(", ");
        let mixed = if self.seen.counts.len() > 1 { "mixed filters: " } else { "" };
        write!(f, "{mixed}photometry through {words} is taken as {}, the model's band", self.band)?;
        write!(f, "; a difference of colour or zero point goes into the fit")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_only_the_models_band_is_beyond_doubt() {
        let counts = |rows: &[(Option<&str>, u64)]| {
            let mut counts = FilterCounts::default();
            rows.iter().for_each(|(filter, rows)| counts.add(*filter, *rows));
            counts.doubt(Band::V).map(|doubt| doubt.to_string())
        };
        assert_eq!(counts(&[(Some("V"), 3), (Some("V"), 4)]), None);
        assert_eq!(counts(&[]), None);
        for (rows, parts) in [
            (vec![(Some("Clear"), 3), (Some("Clear"), 4)], ["photometry through Clear (7 rows)", "taken as V"]),
            (vec![(None, 5)], ["a filter that nothing names (5 rows)", "taken as V"]),
            (vec![(Some("V"), 5), (Some("B"), 1)], ["mixed filters", "V (5 rows), B (1 rows)"]),
            (vec![(Some("v"), 5)], ["v (5 rows)", "taken as V"]),
        ] {
            let said = counts(&rows).unwrap_or_default();
            assert!(parts.iter().all(|part| said.contains(part)), "{said}");
        }
    }
}
