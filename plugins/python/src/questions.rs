//! Arrays to exposures. What is not finite or out of range is told with its name, its place and what is allowed.

use hifitime::{Duration, Epoch, TimeScale};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use streakcast::config::parse_time_scale;
use streakcast::frames::is_covered;
use streakcast::frames::parse_moment;
use streakcast::frames::{Direction, epoch_from_mjd};
use streakcast::passes::Exposure;
use streakcast::schedule::ScheduledExposure;

/// Julian date of hifitime's zero, 1900-01-01T00:00:00 TAI.
const ZERO_JD: f64 = 2_415_020.5;
/// Nanoseconds in a day.
const DAY_NS: f64 = 86_400e9;
/// The longest exposure that is asked about, seconds.
const LONGEST_S: f64 = 86_400.0;

/// A column of numbers.
pub type Column<'py> = PyReadonlyArray1<'py, f64>;
/// Two-part Julian dates, TAI.
pub type TwoParts<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// The epoch of a two-part Julian date, TAI; the parts may be cut anywhere.
pub fn epoch_of(jd1: f64, jd2: f64) -> Epoch {
    let days = jd1 - ZERO_JD;
    let whole = days.floor();
    let fraction_ns = ((days - whole + jd2) * DAY_NS).round();
    Epoch::from_tai_duration(Duration::from_total_nanoseconds(whole as i128 * DAY_NS as i128 + fraction_ns as i128))
}

/// The two-part Julian date, TAI, of an epoch: midnights and halves in the first part.
pub fn two_parts(epoch: Epoch) -> (f64, f64) {
    let nanoseconds = epoch.to_tai_duration().total_nanoseconds();
    let day = nanoseconds.div_euclid(DAY_NS as i128);
    (ZERO_JD + day as f64, nanoseconds.rem_euclid(DAY_NS as i128) as f64 / DAY_NS)
}

fn parts<'py>(py: Python<'py>, epochs: impl Iterator<Item = Epoch>) -> TwoParts<'py> {
    let (first, second): (Vec<f64>, Vec<f64>) = epochs.map(two_parts).unzip();
    (first.into_pyarray(py), second.into_pyarray(py))
}

/// ISO 8601 texts to two-part Julian dates, TAI.
#[pyfunction]
#[pyo3(signature = (texts, scale=None))]
pub fn times_from_text<'py>(py: Python<'py>, texts: Vec<String>, scale: Option<&str>) -> PyResult<TwoParts<'py>> {
    let scale = scale.map(parse_time_scale).transpose().map_err(crate::failure::asked)?;
    let epochs = texts.iter().enumerate().map(|(index, text)| {
        let bad = |error| PyValueError::new_err(format!("time[{index}]: {error}"));
        parse_moment(text, scale).map_err(|error| bad(crate::failure::as_arguments(&error.to_string())))
    });
    Ok(parts(py, epochs.collect::<PyResult<Vec<Epoch>>>()?.into_iter()))
}

/// Modified Julian dates of a scale to two-part Julian dates, TAI.
#[pyfunction]
pub fn times_from_mjd<'py>(py: Python<'py>, mjd: Column<'py>, scale: &str) -> PyResult<TwoParts<'py>> {
    let scale = parse_time_scale(scale).map_err(crate::failure::asked)?;
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

/// Columns of one length that make exposures.
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
    /// Length, seconds.
    exposure_s: Column<'py>,
    /// Position angle of the field's y axis, degrees.
    rotation_deg: Column<'py>,
}

impl Columns<'_> {
    /// The exposures, called by their places.
    pub fn exposures(&self) -> PyResult<Vec<Exposure>> {
        let columns = [&self.ra_deg, &self.dec_deg, &self.jd1, &self.jd2, &self.exposure_s, &self.rotation_deg];
        let [ra, dec, jd1, jd2, exposure, rotation] = columns.map(|column| column.as_array());
        if columns.iter().any(|column| column.as_array().len() != ra.len()) {
            return Err(PyValueError::new_err("columns of different lengths"));
        }
        (0..ra.len())
            .map(|index| {
                let ra_deg = within("ra", index, ra[index], -180.0, 360.0, "deg")?;
                let dec_deg = within("dec", index, dec[index], -90.0, 90.0, "deg")?;
                Ok(Exposure {
                    id: index.to_string(),
                    start: start_of(index, jd1[index], jd2[index])?,
                    duration_s: within("exposure", index, exposure[index], 0.0, LONGEST_S, "s")?,
                    pointing: Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians()),
                    rotation_rad: within("rotation", index, rotation[index], -360.0, 360.0, "deg")?.to_radians(),
                })
            })
            .collect()
    }
}

/// The moment of a two-part Julian date, TAI, within the years that are known.
pub fn start_of(index: usize, jd1: f64, jd2: f64) -> PyResult<Epoch> {
    let jd = jd1 + jd2;
    // Far outside, the count of nanoseconds itself would not fit.
    let epoch =
        (jd.is_finite() && (0.0..5e6).contains(&jd)).then(|| epoch_of(jd1, jd2)).filter(|epoch| is_covered(*epoch));
    epoch.ok_or_else(|| PyValueError::new_err(format!("time[{index}] is JD {jd}; allowed: the years 1957 to 2099")))
}

/// A number within its range, or an error that names it.
pub fn within(what: &str, index: usize, value: f64, least: f64, most: f64, unit: &str) -> PyResult<f64> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(PyValueError::new_err(format!("{what}[{index}] is {value} {unit}; allowed: {least} to {most} {unit}")))
}

/// Exposures as rows of a schedule; `bands` is one for all or one for each.
pub fn rows(exposures: Vec<Exposure>, bands: &[String]) -> PyResult<Vec<ScheduledExposure>> {
    if bands.len() > 1 && bands.len() != exposures.len() {
        let (given, wanted) = (bands.len(), exposures.len());
        return Err(PyValueError::new_err(format!(
            "{given} bands for {wanted} exposures; allowed: one, or one for each"
        )));
    }
    let band = |row: usize| bands.get(row).or(bands.first()).cloned();
    Ok(exposures
        .into_iter()
        .enumerate()
        .map(|(row, exposure)| ScheduledExposure {
            id: exposure.id.clone(),
            row,
            band: band(row),
            exposure: Ok(exposure),
        })
        .collect())
}

/// A scale by its name, for who asks.
pub fn scale_name(scale: TimeScale) -> String {
    scale.to_string().to_ascii_lowercase()
}
