//! Columns of schedules and target lists that contradict those that are read, or change their meaning.

use std::borrow::Cow;
use std::path::Path;

use super::super::error;
use super::columns::{Cell, Quantity, ScheduleRow};
use super::raw_table::RawTable;
use crate::error::Error;
use crate::frames::{parse_declination_deg, parse_right_ascension_deg};
use crate::message::Quoted;
use crate::units::{DEGREES, Unit, is_right_ascension};

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

/// Names of such columns in lower case without underscores.
const MEANINGS: &[(&str, Meaning)] = &[
    ("equinox", Meaning::Equinox),
    ("epoch", Meaning::Epoch),
    ("frame", Meaning::Frame),
    ("coordframe", Meaning::Frame),
    ("coordsys", Meaning::Frame),
    ("radesys", Meaning::Frame),
    ("radecsys", Meaning::Frame),
];
/// Names of numbers of exposures in a row, in the same form.
const COUNTS: &[&str] = &[
    "nexp",
    "nexps",
    "numexp",
    "numexps",
    "expcount",
    "nexposures",
    "numexposures",
    "numberofexposures",
    "exposures",
    "exposurecount",
    "nsub",
    "numsubs",
    "nsubexp",
    "nsubexposures",
    "subexposures",
    "nsubs",
    "subs",
    "nsubframes",
    "subframes",
    "snaps",
    "nsnap",
    "nsnaps",
    "numsnaps",
    "frames",
    "nframes",
    "numframes",
    "framecount",
    "nimages",
    "numimages",
    "imagecount",
    "coadds",
    "ncoadds",
    "repeat",
    "repeats",
    "nrepeats",
    "reps",
    "nreps",
    "ndit",
    "nint",
    "nints",
    "numints",
    "nvisits",
    "numvisits",
    "visitcount",
    "loops",
    "nloops",
    "numloops",
    "stack",
    "nstack",
    "count",
];
/// Those that are also names of columns of text, such as kinds of frames.
const ALSO_TEXTS: &[&str] = &["exposures", "frames", "loops", "repeat", "repeats", "snaps", "stack", "subs"];
/// Those that are also names of running numbers of rows.
const ALSO_ROW_NUMBERS: &[&str] = &["count", "exposures", "frames"];
/// Number of rows by which a column of running numbers is recognised.
const COMPARED_ROWS: usize = 20;
/// Frames with other axes than ICRS, in lower case without blanks and punctuation. The axes of FK5 at J2000 differ by
/// less than 0.1 arcsec. Other texts may be the numbers, names or types of frames.
const OTHER_FRAMES: &[&str] = &[
    "fk4",
    "fk4noe",
    "fk4noeterms",
    "fk4b1950",
    "b1950",
    "1950",
    "galactic",
    "supergalactic",
    "altaz",
    "azel",
    "azalt",
    "horizontal",
    "hadec",
    "cirs",
    "tete",
    "teme",
    "itrs",
    "itrf",
    "gappt",
    "apparent",
    "jnow",
    "fk5jnow",
];

/// Another column of a quantity that is read.
#[derive(Clone, Debug, PartialEq)]
struct Other {
    indices: [usize; 2],
    names: [String; 2],
    scales: [f64; 2],
    unit: &'static Unit,
}

impl Other {
    /// Returns the value of a cell of the first or second column in the unit of the program, also of an angle as text
    /// such as `12h40m`; `None` if it has none.
    fn value(&self, which: usize, cell: &Cell) -> Option<f64> {
        let number = cell.number().ok().map(|number| number * self.scales[which]);
        number.or_else(|| {
            let text = cell.text().filter(|_| *self.unit == DEGREES)?;
            let parse =
                if is_right_ascension(&self.names[0]) { parse_right_ascension_deg } else { parse_declination_deg };
            parse(&text).ok()
        })
    }
}

/// Checks of the cells of a row.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct Checks {
    others: Vec<Other>,
    meanings: Vec<(usize, String, Meaning)>,
}

impl Checks {
    /// Finds the columns that are compared with those that are read, and those that change their meaning. `read` are
    /// the quantities that are read and their columns; `counted` is the column of a number of exposures that is used.
    ///
    /// # Errors
    /// The unit of a column that is read is unknown or contradicts its name, or the file states another frame. Others
    /// with such a unit are not compared.
    pub fn find(
        path: &Path,
        table: &RawTable,
        read: &[(Option<usize>, &'static Quantity)],
        counted: Option<usize>,
    ) -> Result<Self, Error> {
        let mut others = Vec::new();
        for (index, Quantity { names, unit }) in read {
            let Some(index) = *index else { continue };
            if let Some(what) = table.rejected.get(&table.names[index]) {
                let what = format!("column {} {what}", table.names[index]);
                return Err(error::format(path, what));
            }
            let scale = table.scale(path, index, unit)?;
            for other in unit.columns(names, &table.names).into_iter().filter(|at| *at != index) {
                if let Ok(other_scale) = unit.scale(&table.names[other], &table.units) {
                    others.push(Other {
                        indices: [index, other],
                        names: [index, other].map(|at| table.names[at].clone()),
                        scales: [scale, other_scale],
                        unit,
                    });
                }
            }
        }
        let meaning = |index: usize| {
            let lower = table.names[index].to_ascii_lowercase();
            let name = lower.replace('_', "");
            let of_row = MEANINGS.iter().find(|(known, _)| *known == name).map(|(_, meaning)| *meaning);
            // The unit of `exposure_s` is not the plural of `exposures`.
            let meaning =
                of_row.or_else(|| (COUNTS.contains(&&*name) && !lower.ends_with("_s")).then_some(Meaning::Count))?;
            let is_number = ALSO_ROW_NUMBERS.contains(&&*name) && is_row_number(table, index);
            (Some(index) != counted && !is_number).then(|| (index, table.names[index].clone(), meaning))
        };
        Ok(Self { others, meanings: (0..table.names.len()).filter_map(meaning).collect() })
    }

    /// Checks a row.
    ///
    /// # Errors
    /// The columns of a quantity contradict each other, positions are not ICRS, or a row is of several exposures.
    pub fn reject<'a>(&self, cell: impl Fn(usize) -> &'a Cell) -> Result<(), String> {
        for other in &self.others {
            let [index, second_index] = other.indices;
            let [Some(first), Some(second)] = [0, 1].map(|which| other.value(which, cell(other.indices[which]))) else {
                continue;
            };
            if !other.unit.is_same(&other.names[0], first, second) {
                let [first_name, second_name] = &other.names;
                let [first_text, second_text] =
                    [index, second_index].map(|index| Quoted::new(cell(index).text().unwrap_or_default()).to_string());
                return Err(format!(
                    "{first_name} is {first_text} and {second_name} is {second_text}: they contradict each other; allowed: one \
                     of these columns, or equal values"
                ));
            }
        }
        for (index, name, meaning) in &self.meanings {
            let Some(text) = cell(*index).text() else { continue };
            let lower = text.trim().to_ascii_lowercase();
            let year = lower.trim_start_matches(['j', 'b']).parse::<f64>().ok();
            let (is_allowed, allowed) = match meaning {
                Meaning::Equinox => (year == Some(2000.0), "2000: positions are read as ICRS"),
                // A year after 1980 is the epoch of proper motions; other numbers are dates or those of visits.
                Meaning::Epoch => {
                    let is_other = year.map_or(["now", "jnow", "date", "apparent"].contains(&&*lower), |year| {
                        [1855.0, 1875.0, 1900.0, 1950.0].contains(&year) || lower.starts_with('b')
                    });
                    (!is_other, "2000: positions are read as ICRS")
                }
                Meaning::Frame => (!is_other_frame(&lower), "ICRS"),
                Meaning::Count => (
                    lower
                        .parse::<f64>()
                        .map_or(ALSO_TEXTS.contains(&&*name.to_ascii_lowercase()), |count| count <= 1.0),
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

/// Returns true if a column has the running numbers of the rows, by the first of them.
fn is_row_number(table: &RawTable, index: usize) -> bool {
    let value = |row: Cow<'_, ScheduleRow>| row.as_ref().as_ref().ok()?.get(index)?.number().ok();
    let values: Option<Vec<f64>> = table.rows.iter().take(COMPARED_ROWS).map(value).collect();
    values.is_some_and(|values| values.len() > 2 && values.windows(2).all(|pair| pair[1] - pair[0] == 1.0))
}

/// Returns true for the name of a frame with other axes than ICRS.
fn is_other_frame(name: &str) -> bool {
    let letters: String = name.to_ascii_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
    OTHER_FRAMES.contains(&&*letters) || letters.ends_with("ecliptic")
}

#[cfg(test)]
mod tests {
    use super::super::columns::{DURATIONS, RIGHT_ASCENSIONS, ScheduleFormat};
    use super::*;

    fn reason(row: &[(&str, &str)]) -> Option<String> {
        let names: Vec<String> = row.iter().map(|(name, _)| (*name).to_owned()).collect();
        let cells: Vec<Cell> = row.iter().map(|(_, text)| Cell::from_text(text)).collect();
        let table = RawTable::new(ScheduleFormat::Csv, names);
        let read = [(Some(0), &DURATIONS), (Some(1), &RIGHT_ASCENSIONS)];
        Checks::find(Path::new("t.csv"), &table, &read, None).unwrap().reject(|index| &cells[index]).err()
    }

    #[test]
    fn a_compared_column_has_any_unit() {
        let names = ["duration_s", "ra_deg", "ra"].map(str::to_owned);
        let mut table = RawTable::new(ScheduleFormat::Ecsv, names.to_vec());
        table.units.insert("ra".to_owned(), "h:m:s".to_owned());
        let read = [(Some(0), &DURATIONS), (Some(1), &RIGHT_ASCENSIONS)];
        assert_eq!(Checks::find(Path::new("t.ecsv"), &table, &read, None).unwrap().others, []);
    }

    #[test]
    fn a_column_of_running_numbers_counts_no_exposures() {
        for (name, values, is_counted) in [
            ("count", ["1", "2", "3"], false),
            ("frames", ["0", "1", "2"], false),
            ("count", ["1", "1", "2"], true),
            ("count", ["1", "", "2"], true),
            ("ndit", ["1", "2", "3"], true),
        ] {
            let mut table = RawTable::new(ScheduleFormat::Csv, ["duration_s", name].map(str::to_owned).to_vec());
            let row = |value: &&str| Ok(vec![Cell::from_text("30"), Cell::from_text(value)]);
            table.rows = values.iter().map(row).collect::<Vec<_>>().into();
            let checks = Checks::find(Path::new("t.csv"), &table, &[(Some(0), &DURATIONS)], None).unwrap();
            assert_eq!(!checks.meanings.is_empty(), is_counted, "{name} {values:?}");
        }
    }

    #[test]
    fn contradictions_and_other_meanings_are_rejected() {
        let with =
            |name: &'static str, text: &'static str| reason(&[("duration_s", "30"), ("ra_deg", "190"), (name, text)]);
        for (name, text) in [
            ("exposure_s", "30.001"),
            ("exposure_min", "0.5"),
            ("ra_rad", "3.316126"),
            ("exposure_s", ""),
            ("ra", "190.0001"),
            ("ra", "12.666667"),
            ("s_ra", "-170"),
            ("ra", "12h40m"),
            ("equinox", "J2000.0"),
            ("epoch", "2016.0"),
            ("epoch", "2026-08-22T03:14:59"),
            ("epoch", "1"),
            ("epoch", "1870"),
            ("epoch", "blue"),
            ("FRAME", "FK5"),
            ("frame", "17"),
            ("frame", "Light"),
            ("frame", "ICRF"),
            ("ra", "-170.00004"),
            ("s_ra", "550"),
            ("exposure", "2026042500012"),
            ("coadds", "1"),
            ("nexp", ""),
            ("exposure_count", "1"),
            ("repeats", "0"),
            ("count", "1"),
            ("frames", "Light"),
            ("stack", "deep"),
            ("reps", "1.0"),
            ("airmass", "1.2"),
        ] {
            assert_eq!(with(name, text), None, "{name} {text}");
        }
        for (name, text, expected) in [
            ("exposure_s", "300", "duration_s is 30 and exposure_s is 300: they contradict each other"),
            ("visitExposureTime", "29", "duration_s is 30 and visitExposureTime is 29"),
            ("exposure_s", "390", "duration_s is 30 and exposure_s is 390"),
            ("epoch", "1950", "epoch is 1950; allowed: 2000"),
            ("frame", "FK4-NO-E", "frame is FK4-NO-E; allowed: ICRS"),
            ("coordsys", "BarycentricMeanEcliptic", "coordsys is BarycentricMeanEcliptic; allowed: ICRS"),
            ("ra", "10", "ra_deg is 190 and ra is 10"),
            ("equinox", "1950", "equinox is 1950; allowed: 2000"),
            ("Equinox", "JNOW", "Equinox is JNOW; allowed: 2000"),
            ("epoch", "B1950", "epoch is B1950; allowed: 2000"),
            ("epoch", "JNOW", "epoch is JNOW; allowed: 2000"),
            ("frame", "galactic", "frame is galactic; allowed: ICRS"),
            ("coadds", "30", "coadds is 30; allowed: 1, with the time"),
            ("duration_min", "5", "duration_s is 30 and duration_min is 5"),
            ("exposure_ms", "30", "duration_s is 30 and exposure_ms is 30"),
            ("ra_rad", "1", "ra_deg is 190 and ra_rad is 1"),
            ("ra_hourangle", "14", "ra_deg is 190 and ra_hourangle is 14"),
            ("ra", "18h50m", "ra_deg is 190 and ra is 18h50m"),
            ("numExposures", "2", "numExposures is 2; allowed: 1"),
            ("exposure_count", "2", "exposure_count is 2; allowed: 1"),
            ("NDIT", "10", "NDIT is 10; allowed: 1"),
            ("num_images", "3", "num_images is 3; allowed: 1"),
            ("nsnap", "2", "nsnap is 2; allowed: 1"),
            ("Exp_Count", "4", "Exp_Count is 4; allowed: 1"),
            ("n_visits", "5", "n_visits is 5; allowed: 1"),
            ("nloops", "5", "nloops is 5; allowed: 1"),
            ("stack", "10", "stack is 10; allowed: 1"),
            ("exposures", "5", "exposures is 5; allowed: 1"),
            ("subs", "2.0", "subs is 2.0; allowed: 1"),
            ("count", "20", "count is 20; allowed: 1"),
            ("exposures", "20", "exposures is 20; allowed: 1"),
            ("number_of_exposures", "3", "number_of_exposures is 3; allowed: 1"),
        ] {
            let reason = with(name, text).unwrap_or_default();
            assert!(reason.starts_with(expected), "{name} {text}: {reason}");
        }
    }
}
