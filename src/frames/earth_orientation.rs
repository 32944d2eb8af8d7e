//! Earth orientation parameters: UT1 - UTC and polar motion, measured and predicted by the IERS.
//!
//! Without a table, UT1 is taken equal to UTC and the pole is held at its origin. UT1 - UTC reaches 0.9 s, and 0.1 s of
//! UT1 turns the Earth by 46 m at the equator; the pole moves by up to 0.6" (18 m). Both errors displace the observer,
//! not the satellite: 46 m are 17" at a range of 550 km.

use std::f64::consts::PI;
use std::fmt;
use std::sync::{Arc, OnceLock};

use hifitime::Epoch;

use super::time::{epoch_from_utc_day, seconds_between, tai_minus_utc_s};
use crate::constants::DAY_S;
use crate::error::Error;
use crate::message::Quoted;

const ARCSEC_RAD: f64 = PI / 648_000.0;
/// Embedded table, made from finals2000A as described in its header.
const EMBEDDED: &str = include_str!("data/earth_orientation.txt");

/// UT1 - UTC and the coordinates of the pole at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct EarthOrientationParameters {
    /// UT1 - UTC, seconds.
    pub ut1_minus_utc_s: f64,
    /// Pole coordinate x, towards longitude 0, radians.
    pub xp_rad: f64,
    /// Pole coordinate y, towards longitude 90° west, radians.
    pub yp_rad: f64,
}

impl EarthOrientationParameters {
    /// Parameters for UT1 = UTC and the pole at its origin.
    pub const ZERO: Self = Self { ut1_minus_utc_s: 0.0, xp_rad: 0.0, yp_rad: 0.0 };
}

/// Origin and accuracy of the values that [`EopTable::at`] returns.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum EopStatus {
    /// Measured: UT1 to 0.1 ms (5 cm at the equator) from a file, to 0.5 ms (0.2 m) from the embedded table.
    Measured,
    /// Predicted: the error of UT1 is a few ms (a metre at the equator) after a month, some 30 ms (14 m) after a year.
    Predicted,
    /// Time after the last row of the table: UT1 = UTC and no polar motion are used.
    Expired {
        /// Last row of the table.
        last: Epoch,
    },
    /// Time before the first row of the table: UT1 = UTC and no polar motion are used.
    TooEarly {
        /// First row of the table.
        first: Epoch,
    },
    /// No table: UT1 = UTC and no polar motion are used.
    NoTable,
}

impl EopStatus {
    /// Returns true where the table covers the time.
    pub fn is_covered(&self) -> bool {
        matches!(self, Self::Measured | Self::Predicted)
    }
}

impl fmt::Display for EopStatus {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let without = "UT1 = UTC and no polar motion (0.1 s of UT1 is 46 m at the equator, the pole up to 18 m)";
        match self {
            Self::Measured => formatter.write_str("measured"),
            Self::Predicted => formatter.write_str("predicted"),
            Self::Expired { last } => write!(formatter, "table expired on {}: {without}", day(*last)),
            Self::TooEarly { first } => write!(formatter, "table begins on {}: {without}", day(*first)),
            Self::NoTable => write!(formatter, "no table: {without}"),
        }
    }
}

#[derive(Copy, Clone, Debug, PartialEq)]
struct EopRow {
    /// TAI seconds after the first row; TAI and UT1 - TAI have no jumps at leap seconds.
    tai_s: f64,
    ut1_minus_tai_s: f64,
    xp_rad: f64,
    yp_rad: f64,
}

/// Table of UT1 - UTC and polar motion, interpolated linearly between its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct EopTable {
    name: &'static str,
    first: Option<Epoch>,
    /// Time after which the rows are predictions, TAI seconds after the first row.
    predicted_from_s: f64,
    /// Shared by all clones: each request for a night clones the table.
    rows: Arc<[EopRow]>,
    /// True where the table's polar motion is used; false where the pole is held at its origin.
    polar_motion: bool,
}

impl EopTable {
    /// Returns the bundled table, from 2000 to October 2027. It has a row of the IERS series every three days;
    /// interpolated values agree with the daily ones within 0.5 ms in UT1 (0.2 m at the equator) and 1.1 mas in the
    /// pole (3 cm).
    pub fn embedded() -> Self {
        static TABLE: OnceLock<EopTable> = OnceLock::new();
        TABLE.get_or_init(|| parse_embedded(EMBEDDED)).clone()
    }

    /// Returns an empty table: UT1 = UTC and no polar motion at all times.
    pub fn none() -> Self {
        Self { name: "none", first: None, predicted_from_s: 0.0, rows: Arc::default(), polar_motion: true }
    }

    /// Reads the text of an IERS finals2000A file (`.all`, `.data` or `.daily`) and uses its Bulletin A columns.
    ///
    /// Rows without UT1 - UTC or pole (the days beyond the predictions) are skipped.
    ///
    /// # Errors
    /// A number is invalid, dates do not increase, or no row has both UT1 - UTC and the pole.
    pub fn from_finals2000a(text: &str) -> Result<Self, Error> {
        let mut first: Option<Epoch> = None;
        let mut predicted_from_s = f64::INFINITY;
        let mut previous_mjd = f64::NEG_INFINITY;
        let mut rows = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let line_number = index + 1;
            // Bytes of a line, counted from 1, from the ReadMe of the IERS: 8-15 MJD, 19-27 x, 38-46 y, 58 flag, 59-68
            // UT1 - UTC.
            let field = |from: usize, to: usize| line.get(from - 1..to).unwrap_or("").trim();
            if field(59, 68).is_empty() || field(19, 27).is_empty() || field(38, 46).is_empty() {
                continue;
            }
            let number = |column: &'static str, from: usize, to: usize| -> Result<f64, Error> {
                let bad = || {
                    let given = Quoted::new(field(from, to));
                    Error::invalid(column, format_args!("{given:?}"), "a number")
                        .at(format_args!("finals2000A line {line_number}"))
                };
                field(from, to).parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(bad)
            };
            let mjd = number("MJD", 8, 15)?;
            if mjd <= previous_mjd {
                return Err(Error::format(format!("MJD is {mjd}"))
                    .allowing(format!("later than {previous_mjd}, the MJD of the previous row"))
                    .at(format_args!("finals2000A line {line_number}")));
            }
            previous_mjd = mjd;
            let epoch = super::time::epoch_from_mjd(mjd, hifitime::TimeScale::UTC)?;
            let tai_s = seconds_between(*first.get_or_insert(epoch), epoch);
            if field(58, 58) == "P" {
                predicted_from_s = predicted_from_s.min(tai_s);
            }
            rows.push(EopRow {
                tai_s,
                ut1_minus_tai_s: number("UT1_UTC_A", 59, 68)? - tai_minus_utc_s(epoch),
                xp_rad: number("PM_x_A", 19, 27)? * ARCSEC_RAD,
                yp_rad: number("PM_y_A", 38, 46)? * ARCSEC_RAD,
            });
        }
        if rows.is_empty() {
            return Err(Error::format(format!("none of {} lines contains UT1-UTC", text.lines().count()))
                .allowing("a finals2000A file of the IERS"));
        }
        Ok(Self { name: "finals2000A", first, predicted_from_s, rows: rows.into(), polar_motion: true })
    }

    /// Returns the same table with the pole held at its origin, for comparison with programs that use UT1 only. This
    /// moves observers by up to 18 m.
    pub fn without_polar_motion(mut self) -> Self {
        self.rows = self.rows.iter().map(|row| EopRow { xp_rad: 0.0, yp_rad: 0.0, ..*row }).collect();
        self.polar_motion = false;
        self
    }

    /// Returns the parameters at a time. Outside the table they are [`EarthOrientationParameters::ZERO`];
    /// [`EopTable::status`] returns whether a time is covered.
    ///
    /// UT1 - TAI is interpolated and the leap seconds are added afterwards, so that no jump is spread over a day.
    #[doc(hidden)]
    pub fn at(&self, epoch: Epoch) -> EarthOrientationParameters {
        let Some(seconds) = self.covered_s(epoch) else { return EarthOrientationParameters::ZERO };
        let after = self.rows.partition_point(|row| row.tai_s <= seconds).clamp(1, self.rows.len().max(2) - 1);
        let left = &self.rows[after - 1];
        let Some(right) = self.rows.get(after) else {
            return EarthOrientationParameters {
                ut1_minus_utc_s: left.ut1_minus_tai_s + tai_minus_utc_s(epoch),
                xp_rad: left.xp_rad,
                yp_rad: left.yp_rad,
            };
        };
        let part = (seconds - left.tai_s) / (right.tai_s - left.tai_s);
        let between = |a: f64, b: f64| a + (b - a) * part;
        EarthOrientationParameters {
            ut1_minus_utc_s: between(left.ut1_minus_tai_s, right.ut1_minus_tai_s) + tai_minus_utc_s(epoch),
            xp_rad: between(left.xp_rad, right.xp_rad),
            yp_rad: between(left.yp_rad, right.yp_rad),
        }
    }

    /// Returns whether the values at a time are measured, predicted, or outside the table.
    #[doc(hidden)]
    pub fn status(&self, epoch: Epoch) -> EopStatus {
        let (Some(first), Some(last)) = (self.first(), self.last()) else { return EopStatus::NoTable };
        match self.covered_s(epoch) {
            Some(seconds) if seconds >= self.predicted_from_s => EopStatus::Predicted,
            Some(_) => EopStatus::Measured,
            None if seconds_between(first, epoch) < 0.0 => EopStatus::TooEarly { first },
            None => EopStatus::Expired { last },
        }
    }

    /// Returns the time of the first row; `None` for an empty table.
    pub fn first(&self) -> Option<Epoch> {
        self.first
    }

    /// Returns the time of the last row; `None` for an empty table.
    pub fn last(&self) -> Option<Epoch> {
        Some(super::time::seconds_after(self.first?, self.rows.last()?.tai_s))
    }

    /// Returns a description in one line for a log: the table's source, the interval that it covers, and the error
    /// outside.
    pub fn describe(&self) -> String {
        let (Some(first), Some(last)) = (self.first(), self.last()) else {
            return "no Earth orientation table: UT1 = UTC, with an error of up to 0.9 s (0.1 s is 46 m at the equator)"
                .to_owned();
        };
        let measured = super::time::seconds_after(first, self.predicted_from_s.min(seconds_between(first, last)));
        let pole = if self.polar_motion { "" } else { "without polar motion (18 m at most), " };
        format!(
            "Earth orientation ({}): {pole}{} to {}, predicted after {}; outside UT1 = UTC (0.1 s of UT1 is 46 m at the equator)",
            self.name,
            day(first),
            day(last),
            day(measured)
        )
    }

    fn covered_s(&self, epoch: Epoch) -> Option<f64> {
        let seconds = seconds_between(self.first?, epoch);
        (seconds >= 0.0 && seconds <= self.rows.last()?.tai_s).then_some(seconds)
    }
}

/// Formats the UTC date, as in `2027-10-29`.
fn day(epoch: Epoch) -> String {
    let (year, month, day, ..) = epoch.to_gregorian_utc();
    format!("{year:04}-{month:02}-{day:02}")
}

/// Parses the format of the embedded table: a header of `key value` lines, then `UT1-TAI x y` in 0.1 ms and 0.1 mas.
///
/// The table is part of the library and covered by its tests, so invalid lines are skipped.
fn parse_embedded(text: &str) -> EopTable {
    let (mut first_mjd, mut step_days, mut predicted_from_mjd, mut last_mjd) = (0, 1, i64::MAX, 0);
    let mut rows = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["first_mjd", value] => first_mjd = value.parse().unwrap_or(first_mjd),
            ["step_days", value] => step_days = value.parse().unwrap_or(step_days),
            ["predicted_from_mjd", value] => predicted_from_mjd = value.parse().unwrap_or(predicted_from_mjd),
            ["last_mjd", value] => last_mjd = value.parse().unwrap_or(last_mjd),
            [ut1, x, y] => {
                let (Ok(ut1), Ok(x), Ok(y)) = (ut1.parse::<f64>(), x.parse::<f64>(), y.parse::<f64>()) else {
                    continue;
                };
                // The last row is for the last day of the predictions, which may be less than one step after the row
                // before it.
                let mjd = last_mjd.min(first_mjd + step_days * rows.len() as i64);
                let first = epoch_from_utc_day(first_mjd);
                rows.push(EopRow {
                    tai_s: seconds_between(first, epoch_from_utc_day(mjd)),
                    ut1_minus_tai_s: ut1 * 1e-4,
                    xp_rad: x * 1e-4 * ARCSEC_RAD,
                    yp_rad: y * 1e-4 * ARCSEC_RAD,
                });
            }
            _ => {}
        }
    }
    let first = epoch_from_utc_day(first_mjd);
    EopTable {
        name: "embedded",
        first: Some(first),
        predicted_from_s: (predicted_from_mjd - first_mjd) as f64 * DAY_S,
        rows: rows.into(),
        polar_motion: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::mjd_utc;

    fn utc(text: &str) -> Epoch {
        text.parse().expect("an epoch")
    }

    /// Three days of finals2000A around the leap second of 2016 (columns as in the IERS ReadMe), a prediction and a
    /// blank row.
    const SAMPLE: &str = "\
161231 57753.00 I  0.072600 0.000091  0.264600 0.000091  I-0.4080000 0.0000100  0.0000 0.0000
17 1 1 57754.00 I  0.070600 0.000091  0.265600 0.000091  I 0.5908000 0.0000100  0.0000 0.0000
17 1 2 57755.00 P  0.068600 0.000091  0.266600 0.000091  P 0.5896000 0.0000100  0.0000 0.0000
17 1 3 57756.00                                                                              \n";

    #[test]
    fn leap_second_is_not_smeared() {
        let table = EopTable::from_finals2000a(SAMPLE).expect("a table");
        // UT1 - TAI: -36.4080, -36.4092, -36.4104: half way between the first two rows -36.4086.
        let noon = table.at(utc("2016-12-31T12:00:00 UTC"));
        assert!((noon.ut1_minus_utc_s + 0.4086).abs() < 1e-7, "{noon:?}");
        assert!((noon.xp_rad / ARCSEC_RAD - 0.0716).abs() < 1e-7);
        let after = table.at(utc("2017-01-01T00:00:00 UTC"));
        assert!((after.ut1_minus_utc_s - 0.5908).abs() < 1e-12);
        let last = table.at(utc("2017-01-02T00:00:00 UTC"));
        assert!((last.ut1_minus_utc_s - 0.5896).abs() < 1e-12);
    }

    #[test]
    fn status_shows_where_the_table_ends() {
        let table = EopTable::from_finals2000a(SAMPLE).expect("a table");
        assert_eq!(table.status(utc("2016-12-31T12:00:00 UTC")), EopStatus::Measured);
        assert_eq!(table.status(utc("2017-01-02T00:00:00 UTC")), EopStatus::Predicted);
        let (first, last) = (utc("2016-12-31T00:00:00 UTC"), utc("2017-01-02T00:00:00 UTC"));
        assert_eq!(table.status(utc("2017-01-02T00:00:01 UTC")), EopStatus::Expired { last });
        assert_eq!(table.status(utc("2016-12-30T23:59:59 UTC")), EopStatus::TooEarly { first });
        let expired = table.status(utc("2017-01-02T00:00:01 UTC")).to_string();
        assert!(expired.starts_with("table expired on 2017-01-02: UT1 = UTC"), "{expired}");
        assert_eq!(table.at(utc("2017-01-02T00:00:01 UTC")), EarthOrientationParameters::ZERO);
        assert_eq!(EopTable::none().status(first), EopStatus::NoTable);
        assert_eq!(EopTable::none().at(first), EarthOrientationParameters::ZERO);
    }

    #[test]
    fn a_table_of_one_row_is_valid_at_its_time() {
        let table = EopTable::from_finals2000a(SAMPLE.lines().next().unwrap_or("")).expect("a table");
        let only = table.at(utc("2016-12-31T00:00:00 UTC"));
        assert!((only.ut1_minus_utc_s + 0.408).abs() < 1e-12);
    }

    #[test]
    fn broken_files_are_named() {
        let bad = SAMPLE.replace("0.5908000", "0.59x8000");
        let error = EopTable::from_finals2000a(&bad).expect_err("a broken number");
        assert_eq!(error.to_string(), "finals2000A line 2: UT1_UTC_A is \"0.59x8000\"; allowed: a number");
        let twice = format!("{SAMPLE}{SAMPLE}");
        assert!(EopTable::from_finals2000a(&twice).unwrap_err().to_string().starts_with("finals2000A line 5: MJD is "));
        for text in ["", "<html>not found</html>\n", "é".repeat(200).as_str()] {
            let error = EopTable::from_finals2000a(text).unwrap_err().to_string();
            assert!(error.contains(" lines contains UT1-UTC"), "{error}");
        }
    }

    #[test]
    fn embedded_table_is_whole() {
        let table = EopTable::embedded();
        assert_eq!(table.first(), Some(utc("2000-01-01T00:00:00 UTC")));
        let last = table.last().expect("a last row");
        assert_eq!(mjd_utc(last), 61_707.0);
        assert_eq!(table.rows.len(), 3389);
        assert!(table.rows.windows(2).all(|pair| pair[0].tai_s < pair[1].tai_s));
        // Bulletin A of 2017-01-01: +0.5913 s (after the leap second), pole 0.0764", 0.2636".
        let values = table.at(utc("2017-01-01T00:00:00 UTC"));
        assert!((values.ut1_minus_utc_s - 0.5913).abs() < 1e-3, "{values:?}");
        assert_eq!(table.status(utc("2024-08-14T00:00:00 UTC")), EopStatus::Measured);
        assert_eq!(table.status(utc("2027-01-01T00:00:00 UTC")), EopStatus::Predicted);
        assert_eq!(table.status(utc("2028-01-01T00:00:00 UTC")), EopStatus::Expired { last });
        assert!(table.describe().contains("2027-10-29"), "{}", table.describe());
    }
}
