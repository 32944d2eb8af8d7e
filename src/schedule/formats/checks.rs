//! Columns of schedules and target lists that contradict those that are read, or change their meaning.

use std::path::Path;

use super::super::error::ScheduleError;
use super::columns::{Cell, display};
use super::raw_table::RawTable;
use crate::message::Quoted;
use crate::units::{DEGREES, SECONDS, Unit};

/// Quantity with its names in schedules and target lists.
pub(in crate::schedule) struct Quantity {
    names: &'static [&'static str],
    unit: &'static Unit,
    /// Differences up to this value, and up to this fraction, are those of rounding.
    rounding: f64,
    /// Factors between equal values: right ascensions without a unit may be in hours.
    factors: &'static [f64],
}

pub(in crate::schedule) static DURATIONS: Quantity = Quantity {
    names: &["duration_s", "exposure_s", "exptime", "exp_time", "t_exptime", "visitExposureTime"],
    unit: &SECONDS,
    rounding: 1e-2,
    factors: &[1.0],
};
pub(in crate::schedule) static RIGHT_ASCENSIONS: Quantity =
    Quantity { names: &["ra_deg", "ra", "fieldRA", "s_ra"], unit: &DEGREES, rounding: 1e-3, factors: &[1.0, 15.0] };
pub(in crate::schedule) static DECLINATIONS: Quantity =
    Quantity { names: &["dec_deg", "dec", "fieldDec", "s_dec"], unit: &DEGREES, rounding: 1e-3, factors: &[1.0] };

/// Columns that change the meaning of a row.
#[derive(Copy, Clone, Debug, PartialEq)]
enum Meaning {
    Equinox,
    /// Equinox, or the epoch of proper motions.
    Epoch,
    Frame,
    /// Number of exposures in a row.
    Count,
}

/// Names of such columns in lower case.
const MEANINGS: &[(&str, Meaning)] = &[
    ("equinox", Meaning::Equinox),
    ("epoch", Meaning::Epoch),
    ("frame", Meaning::Frame),
    ("coord_frame", Meaning::Frame),
    ("coordsys", Meaning::Frame),
    ("radesys", Meaning::Frame),
    ("radecsys", Meaning::Frame),
    ("nexp", Meaning::Count),
    ("n_exp", Meaning::Count),
    ("nexposures", Meaning::Count),
    ("numexposures", Meaning::Count),
    ("num_exposures", Meaning::Count),
    ("coadds", Meaning::Count),
];
/// Frames whose axes differ from ICRS by less than 0.1 arcsec, in lower case.
const ICRS: [&str; 7] = ["icrs", "gcrs", "fk5", "j2000", "fk5 j2000", "fk5/j2000", "eme2000"];

/// Another column of a quantity that is read.
#[derive(Clone, Debug, PartialEq)]
struct Other {
    indices: [usize; 2],
    names: [String; 2],
    scales: [f64; 2],
    rounding: f64,
    factors: &'static [f64],
}

/// Checks of the cells of a row.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct Checks {
    others: Vec<Other>,
    meanings: Vec<(usize, String, Meaning)>,
}

impl Checks {
    /// Finds the columns that are compared with those that are read, and those that change their meaning. `read` are the
    /// quantities that are read and their columns; `counted` is the column of a number of exposures that is used.
    ///
    /// # Errors
    /// The unit of a column is unknown or contradicts its name.
    pub fn find(
        path: &Path,
        table: &RawTable,
        read: &[(Option<usize>, &'static Quantity)],
        counted: Option<usize>,
    ) -> Result<Self, ScheduleError> {
        let mut others = Vec::new();
        for (index, quantity) in read {
            let Some(index) = *index else { continue };
            let scale = |at: usize| {
                let scale = quantity.unit.scale(&table.names[at], &table.units);
                scale.map_err(|source| ScheduleError::Unit { path: display(path), source })
            };
            for other in (0..table.names.len()).filter(|at| *at != index) {
                if quantity.names.contains(&&*table.names[other]) {
                    others.push(Other {
                        indices: [index, other],
                        names: [index, other].map(|at| table.names[at].clone()),
                        scales: [scale(index)?, scale(other)?],
                        rounding: quantity.rounding,
                        factors: quantity.factors,
                    });
                }
            }
        }
        let meaning = |index: usize| {
            let name = table.names[index].to_ascii_lowercase();
            let (_, meaning) = MEANINGS.iter().find(|(known, _)| *known == name)?;
            (Some(index) != counted).then(|| (index, table.names[index].clone(), *meaning))
        };
        Ok(Self { others, meanings: (0..table.names.len()).filter_map(meaning).collect() })
    }

    /// Checks a row.
    ///
    /// # Errors
    /// The columns of a quantity contradict each other, positions are not ICRS, or a row is of several exposures.
    pub fn reject<'a>(&self, cell: impl Fn(usize) -> &'a Cell) -> Result<(), String> {
        for Other { indices, names, scales, rounding, factors } in &self.others {
            let numbers = indices.map(|index| cell(index).number().ok());
            let [Some(one), Some(other)] = numbers else { continue };
            let is_same = |factor: &&f64| {
                let (one, other) = (one * scales[0], other * scales[1] * **factor);
                (one - other).abs() <= rounding.max(1e-4 * one.abs()) || (one - other).abs() == 360.0
            };
            if factors.iter().find(is_same).is_none() {
                let [first, second] = names;
                return Err(format!(
                    "{first} is {one} and {second} is {other}: they contradict each other; allowed: one of these columns, \
                     or equal values"
                ));
            }
        }
        for (index, name, meaning) in &self.meanings {
            let Some(text) = cell(*index).text() else { continue };
            let lower = text.trim().to_ascii_lowercase();
            let year = lower.trim_start_matches(['j', 'b']).parse::<f64>().ok();
            let (is_allowed, allowed) = match meaning {
                Meaning::Equinox => (year == Some(2000.0), "2000: positions are read as ICRS"),
                // A year after 1980 is the epoch of proper motions, and other numbers are dates.
                Meaning::Epoch => {
                    let is_date =
                        year.map_or(!["now", "jnow", "date", "apparent"].contains(&&*lower), |year| year > 1980.0);
                    (is_date && !lower.starts_with('b'), "2000: positions are read as ICRS")
                }
                Meaning::Frame => (ICRS.contains(&&*lower), "ICRS"),
                Meaning::Count => (
                    lower.parse::<f64>().is_ok_and(|count| count <= 1.0),
                    "1, with the time from the first opening to the last closing of the shutter as duration",
                ),
            };
            if !is_allowed {
                return Err(format!("{name} is {}; allowed: {allowed}", Quoted::new(&text)));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::columns::ScheduleFormat;
    use super::*;

    fn reason(row: &[(&str, &str)]) -> Option<String> {
        let names: Vec<String> = row.iter().map(|(name, _)| (*name).to_owned()).collect();
        let cells: Vec<Cell> = row.iter().map(|(_, text)| Cell::from_text(text)).collect();
        let table = RawTable::new(ScheduleFormat::Csv, names);
        let read = [(Some(0), &DURATIONS), (Some(1), &RIGHT_ASCENSIONS)];
        Checks::find(Path::new("t.csv"), &table, &read, None).unwrap().reject(|index| &cells[index]).err()
    }

    #[test]
    fn contradictions_and_other_meanings_are_rejected() {
        let with =
            |name: &'static str, text: &'static str| reason(&[("duration_s", "30"), ("ra_deg", "190"), (name, text)]);
        for (name, text) in [
            ("exposure_s", "30.001"),
            ("exptime_min", "300"),
            ("exposure_s", ""),
            ("ra", "190.0001"),
            ("ra", "12.666667"),
            ("s_ra", "-170"),
            ("ra", "12h40m"),
            ("equinox", "J2000.0"),
            ("epoch", "2016.0"),
            ("epoch", "2026-08-22T03:14:59"),
            ("FRAME", "FK5"),
            ("coadds", "1"),
            ("nexp", ""),
            ("airmass", "1.2"),
        ] {
            assert_eq!(with(name, text), None, "{name} {text}");
        }
        for (name, text, expected) in [
            ("exposure_s", "300", "duration_s is 30 and exposure_s is 300: they contradict each other"),
            ("visitExposureTime", "29", "duration_s is 30 and visitExposureTime is 29"),
            ("ra", "10", "ra_deg is 190 and ra is 10"),
            ("equinox", "1950", "equinox is 1950; allowed: 2000"),
            ("Equinox", "JNOW", "Equinox is JNOW; allowed: 2000"),
            ("epoch", "B1950", "epoch is B1950; allowed: 2000"),
            ("epoch", "JNOW", "epoch is JNOW; allowed: 2000"),
            ("frame", "galactic", "frame is galactic; allowed: ICRS"),
            ("coadds", "30", "coadds is 30; allowed: 1, with the time"),
            ("numExposures", "2", "numExposures is 2; allowed: 1"),
        ] {
            let reason = with(name, text).unwrap_or_default();
            assert!(reason.starts_with(expected), "{name} {text}: {reason}");
        }
    }
}
