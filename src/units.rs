//! Units of the columns of tables that the program reads. A unit is stated by the file (ECSV, VOTable), by the end of
//! the column's name (`ra_deg`), or by both. Values are converted to the unit that the program uses.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::error::Error;
use crate::message::Quoted;

/// Unit of a column in the program, and the units that are converted to it.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// Other spellings and units, each with its value in the first one, which is the unit in the program.
    accepted: &'static [(&'static str, f64)],
    /// The units as shown in messages.
    allowed: &'static str,
}

/// Degrees.
pub static DEGREES: Unit = Unit {
    accepted: &[
        ("deg", 1.0),
        ("degree", 1.0),
        ("degrees", 1.0),
        ("rad", 180.0 / PI),
        ("radian", 180.0 / PI),
        ("radians", 180.0 / PI),
        ("hourangle", 15.0),
        // Hour angles as astropy writes them to VOTable.
        ("15deg", 15.0),
        ("15 deg", 15.0),
        ("arcmin", 1.0 / 60.0),
        ("arcsec", 1.0 / 3600.0),
        ("mas", 1.0 / 3_600_000.0),
    ],
    allowed: "deg, rad, hourangle, arcmin, arcsec or mas",
};

/// Seconds.
pub static SECONDS: Unit = Unit {
    accepted: &[
        ("s", 1.0),
        ("sec", 1.0),
        ("second", 1.0),
        ("seconds", 1.0),
        ("ms", 1e-3),
        ("min", 60.0),
        ("minute", 60.0),
        ("minutes", 60.0),
        ("h", 3600.0),
        ("hr", 3600.0),
        ("hour", 3600.0),
        ("hours", 3600.0),
        ("d", 86400.0),
        ("day", 86400.0),
        ("days", 86400.0),
    ],
    allowed: "s, ms, min, h or d",
};

/// Days, of Julian dates.
pub static DAYS: Unit =
    Unit { accepted: &[("d", 1.0), ("day", 1.0), ("days", 1.0), ("mjd", 1.0), ("jd", 1.0)], allowed: "d" };

/// Magnitudes.
pub static MAGNITUDES: Unit =
    Unit { accepted: &[("mag", 1.0), ("mag(AB)", 1.0), ("mmag", 1e-3)], allowed: "mag, mag(AB) or mmag" };

/// Positions and lengths in a frame, pixels.
#[cfg(all(feature = "fits", unix))]
pub static PIXELS: Unit = Unit { accepted: &[("pix", 1.0), ("pixel", 1.0), ("pixels", 1.0)], allowed: "pix" };

/// Widths, arcseconds.
#[cfg(all(feature = "fits", unix))]
pub static ARCSECONDS: Unit = Unit {
    accepted: &[("arcsec", 1.0), ("mas", 1e-3), ("arcmin", 60.0), ("deg", 3600.0)],
    allowed: "arcsec, mas, arcmin or deg",
};

/// Distances, kilometres.
#[cfg(any(feature = "fit", all(feature = "fits", unix)))]
pub static KILOMETRES: Unit = Unit { accepted: &[("km", 1.0), ("m", 1e-3)], allowed: "km or m" };

/// Wavelengths, micrometres.
pub static MICROMETRES: Unit = Unit {
    accepted: &[
        ("um", 1.0),
        ("micron", 1.0),
        ("nm", 1e-3),
        ("Angstrom", 1e-4),
        ("angstrom", 1e-4),
        ("AA", 1e-4),
        ("m", 1e6),
    ],
    allowed: "um, nm, Angstrom or m",
};

/// Sizes, metres.
#[cfg(all(feature = "fits", unix))]
pub static METRES: Unit =
    Unit { accepted: &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("km", 1e3)], allowed: "m, cm, mm or km" };

/// Counts in the unit of a frame.
#[cfg(all(feature = "fits", unix))]
pub static COUNTS: Unit =
    Unit { accepted: &[("counts", 1.0), ("count", 1.0), ("adu", 1.0), ("ct", 1.0)], allowed: "adu or ct" };

impl Unit {
    /// Returns true if two numbers of one quantity, in the unit of the program, differ by no more than their rounding:
    /// 0.01, or a ten-thousandth. Right ascensions and rotations are equal after a whole turn, and right ascensions
    /// without a unit may be in hours; `column` is the name of one of the columns.
    pub fn is_same(&self, column: &str, first: f64, other: f64) -> bool {
        const ROUNDING: f64 = 0.01;
        const SHARE: f64 = 1e-4;
        let hours = self.value("hourangle").filter(|_| is_right_ascension(column)).map(|(_, degrees)| degrees);
        let turns = hours.is_some() || column.to_ascii_lowercase().contains("rot");
        let difference =
            |other: f64| if turns { (first - other + 180.0).rem_euclid(360.0) - 180.0 } else { first - other };
        let is_near = |other: f64| difference(other).abs() <= ROUNDING.max(SHARE * first.abs());
        is_near(other) || hours.is_some_and(|degrees| is_near(degrees * other))
    }

    fn value(&self, unit: &str) -> Option<(&'static str, f64)> {
        self.accepted.iter().find(|(accepted, _)| *accepted == unit).copied()
    }

    /// Returns the size of a unit in the unit of the program; `None` if it is not accepted.
    #[cfg(feature = "fit")]
    pub fn size(&self, unit: &str) -> Option<f64> {
        self.value(unit.trim()).map(|(_, size)| size)
    }

    /// Returns the value of the unit of a column, in the unit of the program. `units` are those that the file states,
    /// by column name. A column without any unit is in the unit of the program.
    ///
    /// # Errors
    /// The unit is not accepted, or differs from that in the name of the column.
    pub fn scale(&self, column: &str, units: &BTreeMap<String, String>) -> Result<f64, Error> {
        let named = column.rsplit_once('_').and_then(|(_, end)| self.value(end));
        let Some(unit) = units.get(column).map(|unit| unit.trim()).filter(|unit| !unit.is_empty()) else {
            return Ok(named.map_or(1.0, |(_, scale)| scale));
        };
        let error = |allowed| {
            let [column, unit] = [column, unit].map(Quoted::new);
            Error::format(format!("column {column} is in '{unit}'")).allowing(allowed)
        };
        match (self.value(unit), named) {
            (Some((_, scale)), Some((allowed, named))) if scale != named => Err(error(allowed)),
            (Some((_, scale)), _) => Ok(scale),
            (None, named) => Err(error(named.map_or(self.allowed, |(allowed, _)| allowed))),
        }
    }

    /// Returns the index of the column of a quantity: one of the names in `accepted`, in order of preference, or one of
    /// these that ends with another unit, as `ra_rad` for `ra_deg`.
    ///
    /// # Errors
    /// Several columns have this name, or the quantity in different units.
    pub fn find(&self, accepted: &[&str], names: &[String]) -> Result<Option<usize>, Error> {
        let positions =
            |name: &&str| -> Vec<usize> { (0..names.len()).filter(|&index| names[index] == **name).collect() };
        let own = accepted.iter().map(positions).find(|found| !found.is_empty());
        let found = own.unwrap_or_else(|| self.columns(accepted, names));
        match found[..] {
            [] => Ok(None),
            [index] => Ok(Some(index)),
            [first, other, ..] => {
                let [first, other] = [first, other].map(|index| Quoted::new(&names[index]));
                let sentence = format!("columns {first} and {other} have the same quantity");
                Err(Error::format(sentence).allowing("one of them"))
            }
        }
    }

    /// Returns the indices of all columns of a quantity: the names in `accepted`, and these with another unit at the
    /// end.
    pub fn columns(&self, accepted: &[&str], names: &[String]) -> Vec<usize> {
        let stem = |name: &str| Some(name.rsplit_once('_').filter(|(_, end)| self.value(end).is_some())?.0.to_owned());
        let stems: Vec<String> = accepted.iter().filter_map(|name| stem(name)).collect();
        let is_meant = |name: &str| accepted.contains(&name) || stem(name).is_some_and(|stem| stems.contains(&stem));
        (0..names.len()).filter(|&index| is_meant(&names[index])).collect()
    }
}

/// Returns true for the name of a column of right ascensions, such as `ra_deg`, `s_ra` or `fieldRA`.
pub fn is_right_ascension(column: &str) -> bool {
    // The ends of a streak have numbers: `ra1_deg`.
    let is_meant =
        |word: &str| ["ra", "fieldra"].contains(&word.trim_end_matches(|digit: char| digit.is_ascii_digit()));
    column.to_ascii_lowercase().split('_').any(is_meant)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_converted_and_contradictions_rejected() {
        let units: BTreeMap<String, String> = [
            ("ra", "hourangle"),
            ("h", "15deg"),
            ("ra_deg", "hourangle"),
            ("dec_deg", "degree"),
            ("dec", "m"),
            ("rotation", ""),
        ]
        .map(|(name, unit)| (name.to_owned(), unit.to_owned()))
        .into();
        assert_eq!(DEGREES.scale("ra", &units).unwrap(), 15.0);
        assert_eq!(DEGREES.scale("h", &units).unwrap(), 15.0);
        assert_eq!(DEGREES.scale("dec_deg", &units).unwrap(), 1.0);
        assert_eq!(DEGREES.scale("rotation", &units).unwrap(), 1.0);
        assert_eq!(SECONDS.scale("exposure_min", &units).unwrap(), 60.0);
        let message = |column| DEGREES.scale(column, &units).unwrap_err().to_string();
        assert_eq!(message("ra_deg"), "column ra_deg is in 'hourangle'; allowed: deg");
        assert_eq!(message("dec"), "column dec is in 'm'; allowed: deg, rad, hourangle, arcmin, arcsec or mas");
    }

    #[test]
    fn equal_values_differ_by_rounding() {
        for (unit, column, first, other, is_same) in [
            (&SECONDS, "duration_s", 30.0, 30.001, true),
            (&SECONDS, "duration_s", 30.0, 390.0, false),
            (&SECONDS, "duration_s", 30.0, 2.0, false),
            (&DEGREES, "s_ra", 198.1234, -161.87656, true),
            (&DEGREES, "s_ra", 359.9999, 0.0, true),
            (&DEGREES, "s_ra", 0.0, 359.9999, true),
            (&DEGREES, "s_ra", 190.0, 12.666667, true),
            (&DEGREES, "s_ra", 190.0, 10.0, false),
            (&DEGREES, "dec_deg", 30.0, 30.0001, true),
            (&DEGREES, "dec_deg", 30.0, 2.0, false),
            (&DEGREES, "dec_deg", -10.0, 350.0, false),
            (&DEGREES, "dec_rad", -30.0, -2.0, false),
            (&DEGREES, "ra1_deg", -170.0, 190.0, true),
            (&DEGREES, "rotSkyPos", -10.0, 350.0, true),
            (&DEGREES, "rotation_deg", 30.0, 2.0, false),
        ] {
            assert_eq!(unit.is_same(column, first, other), is_same, "{column} {first} {other}");
        }
    }

    #[test]
    fn names_may_end_with_another_unit() {
        let names = ["name", "ra_hourangle", "dec_m", "exposure_min"].map(str::to_owned);
        assert_eq!(DEGREES.find(&["ra_deg", "ra"], &names).unwrap(), Some(1));
        assert_eq!(DEGREES.find(&["dec_deg"], &names).unwrap(), None);
        assert_eq!(SECONDS.find(&["exposure_s"], &names).unwrap(), Some(3));
    }

    #[test]
    fn a_quantity_has_one_column() {
        let find = |names: &[&str]| {
            DEGREES.find(&["ra_deg", "ra"], &names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>())
        };
        assert_eq!(find(&["ra_rad", "ra_deg", "ra"]).unwrap(), Some(1));
        for names in [["ra_rad", "ra_arcmin"], ["ra_deg", "ra_deg"]] {
            let message = find(&names).unwrap_err().to_string();
            assert_eq!(
                message,
                format!("columns {} and {} have the same quantity; allowed: one of them", names[0], names[1])
            );
        }
    }
}
