//! Writes an element set as the two lines of a TLE.

use thiserror::Error;

use super::element_set::{ElementSet, NoradId};
use super::epoch;
use super::tle_fields::{ALPHA5, BODY, checksum};

/// Why an element set cannot be written as a TLE.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TleFormatError {
    /// Alpha-5 ends at 339,999.
    #[error("catalogue number {0} does not fit a TLE: Alpha-5 ends at 339999")]
    IdTooLarge(NoradId),
    /// A number does not fit its columns.
    #[error("{field} {value} of object {norad_id} does not fit its columns of a TLE")]
    DoesNotFit {
        /// Whose.
        norad_id: NoradId,
        /// Name of the field.
        field: &'static str,
        /// The number.
        value: f64,
    },
}

/// Writes the two lines of an element set, each of 69 characters, rounded to what the columns hold.
///
/// The classification is `U`, the set number 999. Digits beyond the format are lost (eccentricity 1e-7, B* five digits,
/// epoch 1e-8 day): write OMM where they matter.
///
/// # Errors
/// * the catalogue number is above 339,999;
/// * a derivative, B*, or the epoch's year (1957-2056) does not fit its columns.
pub fn format_tle(set: &ElementSet) -> Result<[String; 2], TleFormatError> {
    let id = format_id(set.norad_id)?;
    let misfit = |field, value| TleFormatError::DoesNotFit { norad_id: set.norad_id, field, value };
    let (mut year, mut day, nanosecond) = epoch::to_day_of_year(set.epoch);
    let mut fraction = (nanosecond + 432_000) / 864_000;
    if fraction == 100_000_000 {
        (fraction, day) = (0, day + 1);
        // Keep the day inside its year: 366 is 1 January after a common year.
        (year, day, _) = epoch::to_day_of_year(epoch::from_day_of_year(year, day, 0));
    }
    if !(1957..=2056).contains(&year) {
        return Err(misfit("year of the epoch", f64::from(year)));
    }
    let dot = format!("{:.8}", set.mean_motion_dot_rev_day2.abs());
    let dot = dot.strip_prefix('0').unwrap_or(&dot);
    if dot.len() != 9 {
        return Err(misfit("first derivative of the mean motion", set.mean_motion_dot_rev_day2));
    }
    let sign = if set.mean_motion_dot_rev_day2.is_sign_negative() { '-' } else { ' ' };
    let ddot = format_exponential(set.mean_motion_ddot_rev_day3)
        .ok_or_else(|| misfit("second derivative of the mean motion", set.mean_motion_ddot_rev_day3))?;
    let bstar =
        format_exponential(set.bstar_per_earth_radius).ok_or_else(|| misfit("B*", set.bstar_per_earth_radius))?;
    let line1 = format!(
        "1 {id}U {:<8} {:02}{day:03}.{fraction:08} {sign}{dot} {ddot} {bstar} 0  999",
        format_designator(&set.international_designator),
        year % 100,
    );
    // Rounding up to 1 would overflow the seven digits.
    let eccentricity = (set.eccentricity * 1e7).round().min(9_999_999.0);
    let line2 = format!(
        "2 {id} {:8.4} {:8.4} {eccentricity:07} {:8.4} {:8.4} {:11.8}{:5}",
        set.inclination_deg,
        set.right_ascension_of_node_deg.rem_euclid(360.0),
        set.argument_of_perigee_deg.rem_euclid(360.0),
        set.mean_anomaly_deg.rem_euclid(360.0),
        set.mean_motion_rev_day,
        set.revolution_at_epoch % 100_000,
    );
    if line2.len() != BODY {
        return Err(misfit("mean motion", set.mean_motion_rev_day));
    }
    Ok([line1, line2].map(|line| {
        let checksum = checksum(line.as_bytes());
        format!("{line}{checksum}")
    }))
}

fn format_id(norad_id: NoradId) -> Result<String, TleFormatError> {
    let (tens, rest) = (norad_id.0 / 10_000, norad_id.0 % 10_000);
    if tens < 10 {
        return Ok(format!("{:05}", norad_id.0));
    }
    let letter = ALPHA5.get(tens as usize - 10).ok_or(TleFormatError::IdTooLarge(norad_id))?;
    Ok(format!("{}{rest:04}", char::from(*letter)))
}

/// `1998-067A` as `98067A`; blank where it has another form.
fn format_designator(designator: &str) -> String {
    match designator.as_bytes() {
        [_, _, y1, y2, b'-', rest @ ..] if (3..=6).contains(&rest.len()) && designator.is_ascii() => {
            format!("{}{}{}", char::from(*y1), char::from(*y2), String::from_utf8_lossy(rest))
        }
        _ => String::new(),
    }
}

/// ` 10370-3`, or `None` outside 1e-10 to 1e9.
fn format_exponential(value: f64) -> Option<String> {
    let sign = if value < 0.0 { '-' } else { ' ' };
    // Rust prints d.dddde-n; the point moves one place to the left.
    let text = format!("{:.4e}", value.abs());
    let (mantissa, exponent) = text.split_once('e')?;
    let digits = mantissa.replace('.', "");
    let exponent = exponent.parse::<i32>().ok()? + 1;
    if value == 0.0 || exponent < -9 {
        return Some(" 00000+0".into());
    }
    let exponent_sign = if exponent < 0 { '-' } else { '+' };
    (exponent <= 9).then(|| format!("{sign}{digits}{exponent_sign}{}", exponent.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::{Catalogue, ReadOptions};

    const TEXT: &str = "1 25544U 98067A   26189.73419088  .00005258  00000+0  10370-3 0  9999\n\
                        2 25544  51.6304 193.4497 0006669 272.1743  87.8481 15.48947664575097";

    #[test]
    fn verif_what_was_read_is_written() {
        let catalogue = Catalogue::from_bytes("iss", TEXT.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(format_tle(&catalogue.element_sets[0]).unwrap().join("\n"), TEXT);
    }

    #[test]
    fn verif_alpha5_ends_where_it_ends() {
        for (id, text) in [(5, "00005"), (99_999, "99999"), (100_000, "A0000"), (180_000, "J0000"), (339_999, "Z9999")]
        {
            assert_eq!(format_id(NoradId(id)).unwrap(), text);
        }
        assert_eq!(format_id(NoradId(340_000)), Err(TleFormatError::IdTooLarge(NoradId(340_000))));
    }

    #[test]
    fn verif_what_does_not_fit_is_an_error() {
        let catalogue = Catalogue::from_bytes("iss", TEXT.as_bytes(), &ReadOptions::default()).unwrap();
        let good = &catalogue.element_sets[0];
        let cases = [
            ElementSet { mean_motion_dot_rev_day2: 1.5, ..good.clone() },
            ElementSet { bstar_per_earth_radius: 1e10, ..good.clone() },
            ElementSet { mean_motion_rev_day: 123.0, ..good.clone() },
            ElementSet { epoch: hifitime::Epoch::from_gregorian_utc_at_noon(2057, 1, 1), ..good.clone() },
        ];
        for set in cases {
            assert!(matches!(format_tle(&set), Err(TleFormatError::DoesNotFit { .. })), "{set:?}");
        }
    }
}
