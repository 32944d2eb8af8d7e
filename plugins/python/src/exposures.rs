//! Conversion of arrays to exposures. Errors contain the name of the argument, the index and the accepted range.

use hifitime::{Duration, Epoch, TimeScale};
use numpy::ndarray::ArrayView1;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use streakcast::config::parse_time_scale;
use streakcast::frames::is_covered;
use streakcast::frames::parse_moment;
use streakcast::frames::{Direction, epoch_from_mjd};
use streakcast::output::format_utc;
use streakcast::passes::Exposure;
use streakcast::schedule::ScheduledExposure;

/// Julian date of hifitime's zero point, 1900-01-01T00:00:00 TAI.
const ZERO_JD: f64 = 2_415_020.5;
/// Nanoseconds in a day.
const DAY_NS: f64 = 86_400e9;
/// Longest accepted exposure, seconds.
const LONGEST_S: f64 = 86_400.0;

/// A column of numbers.
pub type Column<'py> = PyReadonlyArray1<'py, f64>;
/// Two-part Julian dates, TAI.
pub type TwoParts<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Returns the epoch of a two-part Julian date, TAI. Any division into two parts is accepted.
pub fn epoch_of(jd1: f64, jd2: f64) -> Epoch {
    let days = jd1 - ZERO_JD;
    let whole = days.floor();
    let fraction_ns = ((days - whole + jd2) * DAY_NS).round();
    Epoch::from_tai_duration(Duration::from_total_nanoseconds(whole as i128 * DAY_NS as i128 + fraction_ns as i128))
}

/// Returns the two-part Julian date, TAI, of an epoch; the first part is a midnight.
pub fn two_parts(epoch: Epoch) -> (f64, f64) {
    let nanoseconds = epoch.to_tai_duration().total_nanoseconds();
    let day = nanoseconds.div_euclid(DAY_NS as i128);
    (ZERO_JD + day as f64, nanoseconds.rem_euclid(DAY_NS as i128) as f64 / DAY_NS)
}

fn parts<'py>(py: Python<'py>, epochs: impl Iterator<Item = Epoch>) -> TwoParts<'py> {
    let (first, second): (Vec<f64>, Vec<f64>) = epochs.map(two_parts).unzip();
    (first.into_pyarray(py), second.into_pyarray(py))
}

/// Converts ISO 8601 texts to two-part Julian dates, TAI.
#[pyfunction]
#[pyo3(signature = (texts, scale=None))]
pub fn times_from_text<'py>(py: Python<'py>, texts: Vec<String>, scale: Option<&str>) -> PyResult<TwoParts<'py>> {
    let scale = scale.map(parse_time_scale).transpose().map_err(crate::failure::request)?;
    let epochs = texts.iter().enumerate().map(|(index, text)| {
        let bad = |error| PyValueError::new_err(format!("time[{index}]: {error}"));
        parse_moment(text, scale).map_err(|error| bad(crate::failure::as_arguments(&error.to_string())))
    });
    Ok(parts(py, epochs.collect::<PyResult<Vec<Epoch>>>()?.into_iter()))
}

/// Converts Modified Julian Dates in a time scale to two-part Julian dates, TAI.
#[pyfunction]
pub fn times_from_mjd<'py>(py: Python<'py>, mjd: Column<'py>, scale: &str) -> PyResult<TwoParts<'py>> {
    let scale = parse_time_scale(scale).map_err(crate::failure::request)?;
    let epochs = mjd
        .as_array()
        .iter()
        .enumerate()
        .map(|(index, mjd)| {
            epoch_from_mjd(*mjd, scale).map_err(|error| PyValueError::new_err(format!("mjd[{index}]: {error}")))
        })
        .collect::<PyResult<Vec<Epoch>>>()?;
    Ok(parts(py, epochs.into_iter()))
}

/// Columns of exposures, of equal length.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Columns<'py> {
    /// Right ascension, degrees.
    ra_deg: Column<'py>,
    /// Declination, degrees.
    dec_deg: Column<'py>,
    /// Shutter opening, TAI, first part.
    jd1: Column<'py>,
    /// Shutter opening, TAI, second part.
    jd2: Column<'py>,
    /// Duration, seconds.
    exposure_s: Column<'py>,
    /// Position angle of the field's y axis, degrees.
    rotation_deg: Column<'py>,
    /// Time with open shutter, seconds, of visits that last longer.
    #[pyo3(default)]
    open_s: Option<Column<'py>>,
}

/// Number of rows that are converted between two checks for signals.
const CONVERTED: usize = 10_000;

impl Columns<'_> {
    /// Returns the exposures. Their ids are their indices. Only time spans (`is_span`) may have the length 0.
    pub fn to_exposures(&self, py: Python<'_>, is_span: bool) -> PyResult<Vec<Exposure>> {
        self.each(py, |columns, index| {
            let name = |what: &str| format!("{what}[{index}]");
            columns.exposure(index, is_span, &name).map_err(PyValueError::new_err)
        })
    }

    /// Returns the exposures as rows of a schedule. `bands` has one entry for all or one for each. A number out of its
    /// range is an error, or the reason of an invalid row if `keep_invalid`.
    pub fn to_rows(&self, py: Python<'_>, bands: &[String], keep_invalid: bool) -> PyResult<Vec<ScheduledExposure>> {
        let band = bands_of(bands, self.ra_deg.as_array().len())?;
        let open_s = self.open_s.as_ref().map(|column| column.as_array());
        self.each(py, |columns, index| {
            let name = |what: &str| if keep_invalid { what.to_owned() } else { format!("{what}[{index}]") };
            let exposure = columns.exposure(index, false, &name);
            if let (Err(error), false) = (&exposure, keep_invalid) {
                return Err(PyValueError::new_err(error.clone()));
            }
            let is_shorter = |open_s: &f64| exposure.as_ref().is_ok_and(|exposure| *open_s < exposure.duration_s);
            let open_s = open_s.map(|column| column[index]).filter(is_shorter);
            Ok(ScheduledExposure { id: index.to_string(), row: index, band: band(index), open_s, exposure })
        })
    }

    fn each<T>(&self, py: Python<'_>, of: impl Fn(&Views<'_>, usize) -> PyResult<T>) -> PyResult<Vec<T>> {
        let columns = [&self.ra_deg, &self.dec_deg, &self.jd1, &self.jd2, &self.exposure_s, &self.rotation_deg];
        let views = Views(columns.map(|column| column.as_array()));
        let count = views.0[0].len();
        let open_s = self.open_s.as_ref().map(|column| column.as_array());
        if views.0.iter().chain(&open_s).any(|view| view.len() != count) {
            return Err(PyValueError::new_err("columns differ in length"));
        }
        (0..count)
            .map(|index| {
                if index % CONVERTED == 0 {
                    py.check_signals()?;
                }
                of(&views, index)
            })
            .collect()
    }
}

/// Columns of exposures in the order of [`Columns`].
struct Views<'a>([ArrayView1<'a, f64>; 6]);

impl Views<'_> {
    /// Returns one exposure; an error names a column by `name`.
    fn exposure(&self, index: usize, is_span: bool, name: &dyn Fn(&str) -> String) -> Result<Exposure, String> {
        let [ra_deg, dec_deg, jd1, jd2, duration_s, rotation_deg] = std::array::from_fn(|column| self.0[column][index]);
        let in_range = |what: &str, value: f64, least: f64, most: f64, unit: &str| {
            let error = || format!("{} is {value} {unit}; allowed: {least} to {most} {unit}", name(what));
            (least..=most).contains(&value).then_some(value).ok_or_else(error)
        };
        let ra_deg = in_range("ra", ra_deg, -180.0, 360.0, "deg")?;
        let dec_deg = in_range("dec", dec_deg, -90.0, 90.0, "deg")?;
        // False for NaN.
        let is_allowed = duration_s > 0.0 && duration_s <= LONGEST_S;
        if !(is_span || is_allowed) {
            return Err(format!("{} is {duration_s} s; allowed: above 0 s, at most {LONGEST_S} s", name("exposure")));
        }
        Ok(Exposure {
            id: index.to_string(),
            start: start(jd1, jd2).map_err(|allowed| format!("{} {allowed}", name("time")))?,
            duration_s: in_range("exposure", duration_s, 0.0, LONGEST_S, "s")?,
            pointing: Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians()),
            rotation_rad: in_range("rotation", rotation_deg, -360.0, 360.0, "deg")?.to_radians(),
        })
    }
}

/// Returns the epoch of a two-part Julian date, TAI, within the supported years.
pub fn start_of(index: usize, jd1: f64, jd2: f64) -> PyResult<Epoch> {
    start(jd1, jd2).map_err(|error| PyValueError::new_err(format!("time[{index}] {error}")))
}

fn start(jd1: f64, jd2: f64) -> Result<Epoch, String> {
    let jd = jd1 + jd2;
    // The range is checked first, because the number of nanoseconds would overflow for distant times.
    let epoch =
        (jd.is_finite() && (0.0..5e6).contains(&jd)).then(|| epoch_of(jd1, jd2)).filter(|epoch| is_covered(*epoch));
    epoch.ok_or_else(|| format!("is JD {jd}; allowed: the years 1957 to 2099"))
}

/// Returns a number if it is in its range, otherwise an error with name and index.
pub fn within(what: &str, index: usize, value: f64, least: f64, most: f64, unit: &str) -> PyResult<f64> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(PyValueError::new_err(format!("{what}[{index}] is {value} {unit}; allowed: {least} to {most} {unit}")))
}

/// Converts exposures to rows of a schedule. `bands` has one entry for all or one for each.
pub fn rows(exposures: Vec<Exposure>, bands: &[String]) -> PyResult<Vec<ScheduledExposure>> {
    let band = bands_of(bands, exposures.len())?;
    let row = |(row, exposure): (usize, Exposure)| ScheduledExposure {
        id: exposure.id.clone(),
        row,
        band: band(row),
        open_s: None,
        exposure: Ok(exposure),
    };
    Ok(exposures.into_iter().enumerate().map(row).collect())
}

/// Returns a function from the index of an exposure to its band.
fn bands_of(bands: &[String], exposures: usize) -> PyResult<impl Fn(usize) -> Option<String>> {
    if bands.len() > 1 && bands.len() != exposures {
        let given = bands.len();
        return Err(PyValueError::new_err(format!(
            "{given} bands for {exposures} exposures; allowed: one, or one for each"
        )));
    }
    Ok(|row: usize| bands.get(row).or(bands.first()).cloned())
}

/// Returns index and reason of each exposure that has a number out of its range.
#[pyfunction]
pub fn out_of_range(py: Python<'_>, exposures: Columns<'_>) -> PyResult<Vec<(usize, String)>> {
    let rows = exposures.to_rows(py, &[], true)?;
    Ok(rows.into_iter().filter_map(|row| Some((row.row, row.exposure.err()?))).collect())
}

/// Returns the lower-case name of a time scale.
pub fn scale_name(scale: TimeScale) -> String {
    scale.to_string().to_ascii_lowercase()
}

/// Returns a time as ISO 8601 text (UTC), to the nanosecond.
#[pyfunction]
pub fn utc_text(jd1: f64, jd2: f64) -> PyResult<String> {
    Ok(format_utc(start_of(0, jd1, jd2)?, 9))
}
