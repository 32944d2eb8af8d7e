//! Charts for notebooks and files: plain columns to pictures.

use std::path::Path;

use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use streakcast::frames::mjd_utc;
use streakcast::plot::{
    FieldChart, FieldStreak, LightCurve, LocalClock, NightTimeline, PictureFormat, SkyRate, SunAltitude, field_chart,
    light_curve, night_timeline, sky_rate, sun_altitude,
};
use streakcast::table::write_atomically;

use crate::failure;
use crate::questions::{Column, epoch_of};

/// A picture that can be shown and written.
#[pyclass(frozen)]
pub struct Picture(streakcast::plot::Picture);

#[pymethods]
impl Picture {
    /// A PNG.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = failure::without_lock(py, || self.0.to_png().map_err(failure::asked))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// An SVG with its font.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        failure::without_lock(py, || self.0.to_svg().map_err(failure::asked))
    }

    /// Writes a file, whole or not at all; PNG or SVG by the end of its name.
    fn save(&self, py: Python<'_>, path: &str) -> PyResult<()> {
        let path = Path::new(path);
        let format = PictureFormat::of(path).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let bytes = failure::without_lock(py, || self.0.to_bytes(format).map_err(failure::asked))?;
        write_atomically(path, |out| out.write_all(&bytes))
            .map_err(|error| PyOSError::new_err(format!("cannot write {}: {error}", path.display())))
    }

    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (usize, usize) {
        self.0.size()
    }
}

fn drawn(picture: Result<streakcast::plot::Picture, streakcast::plot::PlotError>) -> PyResult<Picture> {
    picture.map(Picture).map_err(failure::asked)
}

fn clock<'a>(ahead_of_utc_h: Option<f64>, name: &'a str) -> Option<LocalClock<'a>> {
    ahead_of_utc_h.map(|ahead_of_utc_h| LocalClock { ahead_of_utc_h, name })
}

/// Two-part Julian dates, TAI, as MJD (UTC).
#[pyfunction]
pub fn utc_mjd<'py>(jd1: Column<'py>, jd2: Column<'py>) -> Vec<f64> {
    jd1.as_array().iter().zip(jd2.as_array()).map(|(one, two)| mjd_utc(epoch_of(*one, *two))).collect()
}

/// The timeline of a night.
#[pyfunction]
#[pyo3(signature = (start_mjd, duration_s, n_streaks, brightest_mag, title, caption, limit_mag=None, sun=vec![], local_h=None, local_name=""))]
#[allow(clippy::too_many_arguments)]
pub fn plot_night(
    start_mjd: Vec<f64>,
    duration_s: Vec<f64>,
    n_streaks: Vec<f64>,
    brightest_mag: Vec<f64>,
    title: &str,
    caption: &str,
    limit_mag: Option<f64>,
    sun: Vec<(f64, f64)>,
    local_h: Option<f64>,
    local_name: &str,
) -> PyResult<Picture> {
    drawn(night_timeline(&NightTimeline {
        title,
        caption,
        start_mjd: &start_mjd,
        duration_s: &duration_s,
        n_streaks: &n_streaks,
        brightest_mag: &brightest_mag,
        limit_mag,
        sun: &sun,
        local: clock(local_h, local_name),
    }))
}

/// Name, track, entry, exit, magnitude, sigma.
type Streak = (String, Vec<[f64; 2]>, String, String, f64, f64);

/// A field with its streaks.
#[pyfunction]
pub fn plot_field(
    ra_deg: f64,
    dec_deg: f64,
    outlines: Vec<Vec<[f64; 2]>>,
    streaks: Vec<Streak>,
    title: &str,
    caption: &str,
) -> PyResult<Picture> {
    let streak = |(name, track_deg, enter, exit, magnitude, sigma_mag)| FieldStreak {
        name,
        track_deg,
        enter,
        exit,
        magnitude,
        sigma_mag,
    };
    let streaks: Vec<FieldStreak> = streaks.into_iter().map(streak).collect();
    drawn(field_chart(&FieldChart { title, caption, ra_deg, dec_deg, outlines: &outlines, streaks: &streaks }))
}

/// Magnitude along a track.
#[pyfunction]
#[pyo3(signature = (time_mjd, magnitude, sigma_mag, in_field, title, caption, shutter=None, limit_mag=None, local_h=None, local_name=""))]
#[allow(clippy::too_many_arguments)]
pub fn plot_light_curve(
    time_mjd: Vec<f64>,
    magnitude: Vec<f64>,
    sigma_mag: Vec<f64>,
    in_field: Vec<[f64; 2]>,
    title: &str,
    caption: &str,
    shutter: Option<[f64; 2]>,
    limit_mag: Option<f64>,
    local_h: Option<f64>,
    local_name: &str,
) -> PyResult<Picture> {
    drawn(light_curve(&LightCurve {
        title,
        caption,
        time_mjd: &time_mjd,
        magnitude: &magnitude,
        sigma_mag: &sigma_mag,
        in_field: &in_field,
        shutter,
        limit_mag,
        local: clock(local_h, local_name),
    }))
}

/// Expected streaks over the sky.
#[pyfunction]
pub fn plot_sky_rate(
    nside: u32,
    cells: Vec<u64>,
    rate: Vec<f64>,
    sun_azimuth_deg: f64,
    title: &str,
    subtitle: &str,
    caption: &str,
) -> PyResult<Picture> {
    drawn(sky_rate(&SkyRate { title, subtitle, caption, nside, cells: &cells, rate: &rate, sun_azimuth_deg }))
}

/// Trails an exposure against the Sun's altitude.
#[pyfunction]
#[pyo3(signature = (sun_altitude_deg, n_trails, bin_deg, title, caption, n_bright=None, limit_mag=None))]
pub fn plot_sun_altitude(
    sun_altitude_deg: Vec<f64>,
    n_trails: Vec<f64>,
    bin_deg: f64,
    title: &str,
    caption: &str,
    n_bright: Option<Vec<f64>>,
    limit_mag: Option<f64>,
) -> PyResult<Picture> {
    let n_bright = n_bright.as_deref().zip(limit_mag);
    drawn(sun_altitude(&SunAltitude {
        title,
        caption,
        sun_altitude_deg: &sun_altitude_deg,
        n_trails: &n_trails,
        n_bright,
        bin_deg,
    }))
}
