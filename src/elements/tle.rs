//! Parser of one two-line element set: two lines with fields in fixed columns.
//!
//! Columns are those of the NORAD two-line format (Hoots & Roehrich, Spacetrack Report 3; Kelso, CelesTrak "FAQs:
//! Two-Line Element Set Format"). The following unambiguous variants are also accepted:
//!
//! * catalogue numbers with blanks for zeros, and Alpha-5 (`A0000` = 100,000 ... `Z9999` = 339,999; no I, no O);
//! * plus signs, and angles with zeros for leading blanks;
//! * a missing checksum (68 characters);
//! * blank fields for the two derivatives, the revolution number and the set number, taken as 0 (SGP4 uses none of
//!   them);
//! * text after column 69, separated by a blank (SGP4 verification files have times there).
//!
//! A line that is truncated or shifted by a column is rejected, since a number from the wrong columns may look valid.
//!
//! A number is read as an integer divided by a power of ten. Both are exact in binary64, so that the correctly rounded
//! quotient has the same bits as the same decimal in any other format.

use std::sync::Arc;

use hifitime::Epoch;

use super::element_set::{ElementSet, NoradId, Origin};
use super::epoch;
use super::record::{checked, excerpt};
use super::tle_fields::{BODY, decimal, designator_of, exponential, parse_five_characters, verify_checksum};
use crate::error::Error;
use crate::message::Quoted;

/// Treatment of wrong checksums.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Checksums {
    /// The record is rejected.
    Require,
    /// The record is accepted and counted.
    Ignore,
}

/// Element set, and true if a wrong checksum was accepted.
pub(super) type Read = (ElementSet, bool);

/// Parses one element set from two lines without trailing blanks and line breaks.
///
/// # Errors
/// Number of the invalid line (1 or 2), and the reason: see [`Error`].
pub(super) fn parse_lines(name: &[u8], line1: &[u8], line2: &[u8], checksums: Checksums) -> Result<Read, (u8, Error)> {
    let first = parse_line1(line1).map_err(|error| (1, error))?;
    let second = parse_line2(line2).map_err(|error| (2, error))?;
    if first.norad_id != second.norad_id {
        return Err((
            2,
            Error::format(format!("line 1 is of object {}, line 2 of object {}", first.norad_id, second.norad_id)),
        ));
    }
    let mut overlooked = false;
    for (line, text) in [(1, line1), (2, line2)] {
        if let Err(error) = verify_checksum(line, text) {
            match checksums {
                Checksums::Require => return Err((line, error)),
                Checksums::Ignore => overlooked = true,
            }
        }
    }
    let set = ElementSet {
        norad_id: NoradId(first.norad_id),
        name: name_of(name),
        international_designator: first.designator,
        epoch: first.epoch,
        mean_motion_rev_day: second.mean_motion,
        eccentricity: second.eccentricity,
        inclination_deg: second.inclination,
        right_ascension_of_node_deg: second.node,
        argument_of_perigee_deg: second.perigee,
        mean_anomaly_deg: second.anomaly,
        bstar_per_earth_radius: first.bstar,
        mean_motion_dot_rev_day2: first.dot,
        mean_motion_ddot_rev_day3: first.ddot,
        revolution_at_epoch: second.revolution,
        decayed: None,
        origin: Origin::Published,
    };
    // Of the range errors, only that of catalogue number 0 concerns line 1.
    checked(set).map(|set| (set, overlooked)).map_err(|error| (if first.norad_id == 0 { 1 } else { 2 }, error))
}

/// Returns the name on a name line, without leading "0 " and surrounding blanks.
pub(super) fn name_of(line: &[u8]) -> Arc<str> {
    let line = line.trim_ascii();
    let line = if line == b"0" { &[] } else { line.strip_prefix(b"0 ").unwrap_or(line).trim_ascii() };
    if line.is_empty() { Arc::default() } else { Arc::from(String::from_utf8_lossy(line).as_ref()) }
}

/// Fields of line 1.
struct Line1 {
    norad_id: u32,
    designator: Arc<str>,
    epoch: Epoch,
    dot: f64,
    ddot: f64,
    bstar: f64,
}

/// Fields of line 2.
struct Line2 {
    norad_id: u32,
    inclination: f64,
    node: f64,
    eccentricity: f64,
    perigee: f64,
    anomaly: f64,
    mean_motion: f64,
    revolution: u32,
}

fn parse_line1(text: &[u8]) -> Result<Line1, Error> {
    let line = Line { number: 1, text };
    line.check_shape(&[2, 9, 18, 33, 44, 53, 62, 64])?;
    let norad_id = line.norad_id()?;
    let epoch = line.epoch()?;
    let dot = line.decimal_or_zero("first derivative of the mean motion", 34, 43)?;
    let ddot = line.exponential("second derivative of the mean motion", 45, 52, true)?;
    let bstar = line.exponential("B*", 54, 61, false)?;
    // Ephemeris type 4 is SGP4-XP: it has the same columns, but in SGP4 its elements give errors of kilometres.
    if text[62] == b'4' {
        return Err(Error::format(format!(
            "unsupported ephemeris type {:?}: allowed 0 (SGP4); 4 means SGP4-XP elements, which require another propagator",
            Quoted::new("4")
        )));
    }
    Ok(Line1 { norad_id, designator: designator_of(line.columns(10, 17)), epoch, dot, ddot, bstar })
}

fn parse_line2(text: &[u8]) -> Result<Line2, Error> {
    let line = Line { number: 2, text };
    line.check_shape(&[2, 8, 17, 26, 34, 43, 52])?;
    Ok(Line2 {
        norad_id: line.norad_id()?,
        inclination: line.decimal("inclination", 9, 16)?,
        node: line.decimal("right ascension of the node", 18, 25)?,
        eccentricity: line.eccentricity()?,
        perigee: line.decimal("argument of perigee", 35, 42)?,
        anomaly: line.decimal("mean anomaly", 44, 51)?,
        mean_motion: line.decimal("mean motion", 53, 63)?,
        revolution: line.revolution()?,
    })
}

/// One of the two lines, with its number for error messages.
struct Line<'a> {
    number: u8,
    text: &'a [u8],
}

impl<'a> Line<'a> {
    /// Returns the text in columns `first` to `last`, counted from 1. `check_shape` must have accepted the line.
    fn columns(&self, first: u8, last: u8) -> &'a [u8] {
        &self.text[usize::from(first) - 1..usize::from(last)]
    }

    /// Checks the length of the line, and that the columns between fields are blank.
    fn check_shape(&self, blanks: &[u8]) -> Result<(), Error> {
        let length = self.text.len();
        let ends_well = length == BODY || length == BODY + 1 || self.text.get(BODY + 1) == Some(&b' ');
        if !ends_well || length < BODY {
            return Err(Error::format(format!(
                "line {} has {length} characters, expected 69, or 68 without a checksum",
                self.number
            )));
        }
        for &column in blanks {
            let found = self.text[usize::from(column) - 1];
            if found != b' ' {
                return Err(Error::format(format!(
                    "line {}: {:?} in column {column}, expected a blank: the columns are shifted",
                    self.number,
                    char::from(found)
                )));
            }
        }
        Ok(())
    }

    fn not_a_number(&self, field: &'static str, first: u8, last: u8) -> Error {
        let text = excerpt(self.columns(first, last));
        Error::format(format!(
            "line {}: {field} {:?} is not a number in columns {first}-{last}",
            self.number,
            Quoted::new(text)
        ))
    }

    fn norad_id(&self) -> Result<u32, Error> {
        let field = self.columns(3, 7).trim_ascii();
        parse_five_characters(field)
            .ok_or_else(|| Error::format(format!("line {}: invalid catalogue number {:?} in columns 3-7: expected 1-99999, or Alpha-5 with A-Z without I and O", self.number, Quoted::new(excerpt(self.columns(3, 7))))))
    }

    /// Parses a decimal number.
    fn decimal(&self, field: &'static str, first: u8, last: u8) -> Result<f64, Error> {
        decimal(self.columns(first, last)).ok_or_else(|| self.not_a_number(field, first, last))
    }

    fn decimal_or_zero(&self, field: &'static str, first: u8, last: u8) -> Result<f64, Error> {
        if self.columns(first, last).trim_ascii().is_empty() { Ok(0.0) } else { self.decimal(field, first, last) }
    }

    /// Parses `SNNNNNSE`: a fraction with an implied leading decimal point, and a power of ten.
    fn exponential(&self, field: &'static str, first: u8, last: u8, blank_is_zero: bool) -> Result<f64, Error> {
        let text = self.columns(first, last);
        if blank_is_zero && text.trim_ascii().is_empty() {
            return Ok(0.0);
        }
        exponential(text).ok_or_else(|| self.not_a_number(field, first, last))
    }

    /// Parses the eccentricity: seven digits with an implied leading decimal point.
    fn eccentricity(&self) -> Result<f64, Error> {
        let field = self.columns(27, 33);
        // Only leading blanks are read as zeros.
        let value = epoch::digits(field.trim_ascii_start());
        value.map(|value| f64::from(value) / 1e7).ok_or_else(|| self.not_a_number("eccentricity", 27, 33))
    }

    fn revolution(&self) -> Result<u32, Error> {
        let field = self.columns(64, 68).trim_ascii();
        if field.is_empty() {
            return Ok(0);
        }
        epoch::digits(field).ok_or_else(|| self.not_a_number("revolution number", 64, 68))
    }

    /// Parses two digits of the year (57-99 are 1957-1999), the day of the year and its fraction.
    fn epoch(&self) -> Result<Epoch, Error> {
        let bad = || {
            Error::format(format!(
                "invalid epoch {:?}: expected YYDDD.DDDDDDDD in columns 19-32 of line 1, with the day from 1 to 365, in leap years 366",
                Quoted::new(excerpt(self.columns(19, 32)))
            ))
        };
        let year = epoch::digits(self.columns(19, 20).trim_ascii()).ok_or_else(bad)? as i32;
        let year = if year < 57 { 2000 + year } else { 1900 + year };
        let field = self.columns(21, 32).trim_ascii();
        let point = field.iter().position(|&byte| byte == b'.').unwrap_or(field.len());
        let day = epoch::digits(&field[..point]).ok_or_else(bad)?;
        if day == 0 {
            return Err(Error::format(format!(
                "invalid epoch {:?}: expected {}",
                Quoted::new(excerpt(self.columns(19, 32))),
                "YYDDD.DDDDDDDD in columns 19-32 of line 1, with the day from 1 to 365, in leap years 366; day 0 is \
                          31 December of the year before for some programs and an error for others"
            )));
        }
        let mut nanosecond = 0;
        if let Some(fraction) = field.get(point + 1..).filter(|fraction| !fraction.is_empty()) {
            // The field has space for at most ten digits of the fraction. 1e-10 day is 8,640 ns, so the quotient is a
            // whole number of nanoseconds.
            let scale = 10_i64.pow(fraction.len() as u32);
            let whole = fraction
                .iter()
                .try_fold(0_i64, |value, byte| byte.is_ascii_digit().then(|| value * 10 + i64::from(byte - b'0')));
            let product = i128::from(whole.ok_or_else(bad)?) * i128::from(epoch::DAY_NS);
            nanosecond = ((product + i128::from(scale / 2)) / i128::from(scale)) as i64;
        }
        if day > 365 + u32::from(epoch::is_leap(year)) {
            return Err(bad());
        }
        Ok(epoch::from_day_of_year(year, i64::from(day), nanosecond))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE1: &str = "1 25544U 98067A   26189.73419088  .00005258  00000+0  10370-3 0  9999";
    const LINE2: &str = "2 25544  51.6304 193.4497 0006669 272.1743  87.8481 15.48947664575097";

    fn read(line1: &str, line2: &str) -> Result<ElementSet, Error> {
        parse_lines(b"0 ISS (ZARYA)  ", line1.as_bytes(), line2.as_bytes(), Checksums::Require)
            .map(|read| read.0)
            .map_err(|(_, error)| error)
    }

    #[test]
    fn verif_a_line_pair_gives_the_decimals_it_prints() {
        let set = read(LINE1, LINE2).unwrap();
        assert_eq!(set.norad_id, NoradId(25544));
        assert_eq!(&*set.name, "ISS (ZARYA)");
        assert_eq!(&*set.international_designator, "1998-067A");
        assert_eq!(set.epoch, epoch::parse_iso("2026-07-08T17:37:14.092032").unwrap());
        assert_eq!(set.mean_motion_rev_day, 15.48947664);
        assert_eq!(set.eccentricity, 0.0006669);
        assert_eq!(set.inclination_deg, 51.6304);
        assert_eq!(set.right_ascension_of_node_deg, 193.4497);
        assert_eq!(set.argument_of_perigee_deg, 272.1743);
        assert_eq!(set.mean_anomaly_deg, 87.8481);
        assert_eq!(set.bstar_per_earth_radius, 0.10370e-3);
        assert_eq!(set.mean_motion_dot_rev_day2, 0.00005258);
        assert_eq!(set.mean_motion_ddot_rev_day3, 0.0);
        assert_eq!(set.revolution_at_epoch, 57509);
    }

    #[test]
    fn verif_two_digit_years() {
        for (year, expected) in [("57", "1957"), ("99", "1999"), ("00", "2000"), ("56", "2056")] {
            let line1 = format!("{}{year}{}", &LINE1[..18], &LINE1[20..68]);
            let set = read(&line1, LINE2).unwrap();
            assert_eq!(epoch::to_day_of_year(set.epoch).0.to_string(), expected);
        }
    }

    #[test]
    fn verif_errors_contain_reason_and_position() {
        let put = |line: &str, column: usize, text: &str| {
            format!("{}{text}{}", &line[..column - 1], &line[column - 1 + text.len()..68])
        };
        let cases = [
            (LINE1.into(), put(LINE2, 9, "     abc"), r#"line 2: inclination "abc" is not a number in columns 9-16"#),
            (LINE1.into(), put(LINE2, 9, "181.0000"), "inclination 181 is out of range: allowed 0 to 180 deg"),
            (
                LINE1.into(),
                put(LINE2, 53, " 0.00000000"),
                "mean motion 0 is out of range: allowed above 0 revolutions a day",
            ),
            (
                put(LINE1, 3, "I5544"),
                LINE2.into(),
                r#"line 1: invalid catalogue number "I5544" in columns 3-7: expected 1-99999, or Alpha-5 with A-Z without I and O"#,
            ),
            (
                put(LINE1, 19, "26000"),
                LINE2.into(),
                r#"invalid epoch "26000.73419088": expected YYDDD.DDDDDDDD in columns 19-32 of line 1, with the day from 1 to 365, in leap years 366; day 0 is 31 December of the year before for some programs and an error for others"#,
            ),
            (
                put(LINE1, 19, "26366"),
                LINE2.into(),
                r#"invalid epoch "26366.73419088": expected YYDDD.DDDDDDDD in columns 19-32 of line 1, with the day from 1 to 365, in leap years 366"#,
            ),
            (format!("{}4", &LINE1[..68]), LINE2.into(), "line 1: checksum '4' does not match the sum of the line, 9"),
            (
                LINE1.replacen("98067A  ", "98067A ", 1),
                LINE2.into(),
                "line 1: '2' in column 18, expected a blank: the columns are shifted",
            ),
            (
                put(LINE1, 63, "4"),
                LINE2.into(),
                r#"unsupported ephemeris type "4": allowed 0 (SGP4); 4 means SGP4-XP elements, which require another propagator"#,
            ),
        ];
        for (line1, line2, expected) in cases {
            assert_eq!(read(&line1, &line2).unwrap_err().to_string(), expected);
        }
    }

    #[test]
    fn verif_a_missing_checksum_is_not_a_bad_one() {
        assert!(read(&LINE1[..68], &LINE2[..68]).is_ok());
        let line1 = "1     5U 58002B   00179.78495062 +.00000023 +00000-0 +28098-4 0 0475";
        let line2 = "2     5 034.2682 348.7242 1859667 331.7664 019.3264 10.8241915741366     0.00      4320.0";
        let set = read(line1, line2).unwrap();
        assert_eq!((set.norad_id, set.revolution_at_epoch), (NoradId(5), 41366));
        assert_eq!(set.bstar_per_earth_radius, 0.28098e-4);
    }
}
