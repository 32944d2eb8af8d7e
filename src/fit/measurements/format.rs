//! Formats of photometry files, and the filters in them.

use std::fmt;

use super::super::error::FORMATS;
use super::column_map::{ColumnMap, Field};
use crate::error::{Error, ErrorKind};
use crate::geometry::Site;
use crate::message::Quoted;
use crate::photometry::Band;

/// Layout of a table of photometry.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// MMT-9 (Karpov et al. 2016, Beskin et al. 2017), as raw text (comments first, columns separated by blanks) or
    /// CSV. Times are UTC; only rows with the filter `Clear` are used unless other filters are selected.
    Mmt,
    /// Pomenis (Fankhauser, Tyson and Askari 2023): Starlink V1.5 seen from Mount Lemmon, with height, altitude and
    /// azimuth.
    Pomenis,
    /// Upload format of SCORE, the repository of the IAU CPS, with site, satellite and filter in each row.
    Score,
    /// Slingshot (Kandula et al. 2025): altitudes of Sun and satellite and the azimuth difference, without times.
    Slingshot,
    /// Any other delimited table, read with a [`ColumnMap`].
    Csv,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::Pomenis, Self::Mmt, Self::Score, Self::Slingshot, Self::Csv];

    /// Returns the name on the command line.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Mmt => "mmt",
            Self::Pomenis => "pomenis",
            Self::Score => "score",
            Self::Slingshot => "slingshot",
            Self::Csv => "csv",
        }
    }

    /// Returns the format with this name; upper and lower case are equivalent.
    ///
    /// # Errors
    /// An unknown name.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|format| format.name().eq_ignore_ascii_case(name.trim()));
        found.ok_or_else(|| {
            Error::new(ErrorKind::Invalid, format!("unknown format of photometry '{}'", Quoted::new(name)))
                .allowing(FORMATS)
        })
    }

    /// Returns the format that has these columns; never [`Csv`](Self::Csv).
    pub(super) fn sniff(header: &[String]) -> Option<Self> {
        let marks: [(Self, [&str; 2]); 4] = [
            (Self::Mmt, ["StdMag", "Distance"]),
            (Self::Pomenis, ["ab_magnitude", "satellite_height"]),
            (Self::Score, ["apparent_magnitude", "observation_time_utc"]),
            (Self::Slingshot, ["measured_ab", "az diff"]),
        ];
        let has = |name: &str| header.iter().any(|column| column == name);
        marks.into_iter().find(|(_, [first, other])| has(first) && has(other)).map(|(format, _)| format)
    }

    /// Returns the columns of the format; none for [`Csv`](Self::Csv).
    pub(super) fn columns(self) -> ColumnMap {
        use Field::*;
        match self {
            Self::Mmt => ColumnMap {
                optional: vec![TimeOfDay, Filter, Penumbra, Track, Norad],
                ..ColumnMap::fixed(&[
                    (Time, "Date"),
                    (TimeOfDay, "Time"),
                    (Magnitude, "Mag"),
                    (Filter, "Filter"),
                    (Penumbra, "Penumbra"),
                    (Distance, "Distance"),
                    (Phase, "Phase"),
                    (Track, "Track"),
                    (Norad, "NORAD"),
                ])
            },
            Self::Pomenis => ColumnMap::fixed(&[
                (Time, "observation_time"),
                (Height, "satellite_height"),
                (Altitude, "satellite_altitude"),
                (Azimuth, "satellite_azimuth"),
                (Magnitude, "ab_magnitude"),
            ]),
            Self::Score => ColumnMap {
                optional: vec![Sigma, RightAscension, Declination, Distance],
                ..ColumnMap::fixed(&[
                    (Time, "observation_time_utc"),
                    (Magnitude, "apparent_magnitude"),
                    (Sigma, "apparent_magnitude_uncertainty"),
                    (Filter, "observing_filter"),
                    (Norad, "norad_cat_id"),
                    (Latitude, "observer_latitude_deg"),
                    (Longitude, "observer_longitude_deg"),
                    (SiteHeight, "observer_altitude_m"),
                    (RightAscension, "satellite_right_ascension_deg"),
                    (Declination, "satellite_declination_deg"),
                    (Distance, "range_to_satellite_km"),
                ])
            },
            Self::Slingshot => ColumnMap {
                height_km: 1e-3,
                ..ColumnMap::fixed(&[
                    (SunAltitude, "sun altitude"),
                    (Altitude, "sat altitude"),
                    (Height, "sat height"),
                    (Magnitude, "measured_ab"),
                    (AzimuthFromSun, "az diff"),
                ])
            },
            Self::Csv => ColumnMap::default(),
        }
    }

    /// Returns the site of a format whose data all come from one site.
    pub(super) fn site(self) -> Result<Option<Site>, Error> {
        match self {
            // 43°38'59.5" N, 41°25'53.3" E, 2030 m.
            Self::Mmt => Site::by_name("MMT-9").map(Some),
            // From the head of the table: 32.4434° N, 110.7881° W, Mount Lemmon.
            Self::Pomenis => Site::new_deg("Pomenis", 32.4434, -110.7881, 2790.0).map(Some),
            _ => Ok(None),
        }
    }

    /// Returns the filter that is used if none is selected.
    pub(super) fn usual_filter(self) -> Option<&'static str> {
        // Lu (2024), section 3: only magnitudes through the clear filter are used.
        (self == Self::Mmt).then_some("Clear")
    }
}

/// Numbers of rows for each filter.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FilterCounts {
    /// Numbers in the order in which the filters first occur; `None` stands for rows without a filter.
    counts: Vec<(Option<String>, u64)>,
}

/// Warning that photometry may not be in the band of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BandMismatch {
    band: Band,
    seen: FilterCounts,
}

impl FilterCounts {
    /// Returns each filter with its number of rows.
    pub fn iter(&self) -> impl Iterator<Item = (Option<&str>, u64)> {
        self.counts.iter().map(|(filter, count)| (filter.as_deref(), *count))
    }

    /// Returns a mismatch if any row has a filter other than `band`, or no filter. Case matters (`R` is Cousins', `r`
    /// is LSST's), and a survey's own filter (`Clear`) is not a band.
    pub fn mismatch(&self, band: Band) -> Option<BandMismatch> {
        let is_other = |filter: Option<&str>| filter.and_then(|name| name.parse::<Band>().ok()) != Some(band);
        self.iter().any(|(filter, _)| is_other(filter)).then(|| BandMismatch { band, seen: self.clone() })
    }

    /// Adds rows with a filter.
    pub(super) fn add(&mut self, filter: Option<&str>, rows: u64) {
        match self.counts.iter_mut().find(|(known, _)| known.as_deref() == filter) {
            Some((_, count)) => *count += rows,
            None => self.counts.push((filter.map(str::to_owned), rows)),
        }
    }

    /// Adds the numbers of rows that follow in the same source.
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
