//! Plots for notebooks and files, drawn from columns.

use std::path::Path;

use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use streakcast::frames::{Direction, Gcrs, mjd_utc};
use streakcast::output::write_atomically;
use streakcast::passes::Field;
use streakcast::plot::{
    FieldChart, FieldStreak, LightCurve, LocalClock, NightTimeline, PictureFormat, SkyChart, SkyRate, SkyTrack,
    SunAltitude, field_chart, light_curve, night_timeline, sky_chart, sky_rate, sun_altitude,
};

use crate::exposures::{Column, epoch_of};
use crate::failure;

/// Number of points of the outline of a circle.
const CIRCLE_POINTS: usize = 180;

/// Rendered plot.
#[pyclass(frozen)]
pub struct Picture(streakcast::plot::Picture);

#[pymethods]
impl Picture {
    /// Returns a PNG.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = failure::without_lock(py, |_| self.0.to_png().map_err(failure::request))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Returns an SVG with embedded font.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        failure::without_lock(py, |_| self.0.to_svg().map_err(failure::request))
    }

    /// Writes a file atomically, as PNG or SVG by the file name extension.
    fn save(&self, py: Python<'_>, path: &str) -> PyResult<()> {
        let path = Path::new(path);
        let format = PictureFormat::from_extension(path).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let bytes = failure::without_lock(py, |_| self.0.to_bytes(format).map_err(failure::request))?;
        write_atomically(path, |out| out.write_all(&bytes))
            .map_err(|error| PyOSError::new_err(format!("cannot write {}: {error}", path.display())))
    }

    /// Returns width and height in pixels.
    #[getter]
    fn size(&self) -> (usize, usize) {
        self.0.size()
    }
}

/// Converts two-part Julian dates, TAI, to MJD (UTC).
#[pyfunction]
pub fn utc_mjd<'py>(jd1: Column<'py>, jd2: Column<'py>) -> Vec<f64> {
    jd1.as_array().iter().zip(jd2.as_array()).map(|(jd1, jd2)| mjd_utc(epoch_of(*jd1, *jd2))).collect()
}

/// Labels and lines common to all plots.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Labels {
    title: String,
    limit_mag: Option<f64>,
    /// Local time of the upper axis: hours ahead of UTC, and name.
    local: Option<(f64, String)>,
}

impl Labels {
    fn clock(&self) -> Option<LocalClock> {
        self.local
            .as_ref()
            .map(|(ahead_of_utc_h, name)| LocalClock { ahead_of_utc_h: *ahead_of_utc_h, name: name.clone() })
    }
}

/// Columns of the plot of a night.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Night {
    start_mjd: Vec<f64>,
    duration_s: Vec<f64>,
    n_streaks: Vec<f64>,
    brightest_mag: Vec<f64>,
}

/// Columns of the plot of a field: centre, diameter of a circular field, and streaks with name, track, entry and exit
/// (MJD, UTC), magnitude and sigma.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct FieldOf {
    ra_deg: f64,
    dec_deg: f64,
    fov_deg: Option<f64>,
    streaks: Vec<(String, Vec<[f64; 2]>, f64, f64, f64, f64)>,
}

impl FieldOf {
    /// Returns the outlines of the field, degrees.
    fn outlines(&self) -> PyResult<Vec<Vec<[f64; 2]>>> {
        let Some(fov_deg) = self.fov_deg else { return Ok(Vec::new()) };
        let field = Field::circle(fov_deg.to_radians()).map_err(failure::request)?;
        let centre = Direction::from_lon_lat_rad(self.ra_deg.to_radians(), self.dec_deg.to_radians());
        let degrees = |point: Direction<Gcrs>| [point.longitude_rad().to_degrees(), point.latitude_rad().to_degrees()];
        let outlines = field.on_sky(&centre, 0.0).outlines(CIRCLE_POINTS);
        Ok(outlines.into_iter().map(|outline| outline.into_iter().map(degrees).collect()).collect())
    }
}

/// Columns of a light curve.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Curve {
    time_mjd: Vec<f64>,
    magnitude: Vec<f64>,
    sigma_mag: Vec<f64>,
    in_fitted_range: Vec<bool>,
    in_field: Vec<[f64; 2]>,
}

/// Passes over a site.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Sky {
    tracks: Vec<Track>,
}

/// Columns of one pass.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Track {
    name: String,
    time_mjd: Vec<f64>,
    azimuth_deg: Vec<f64>,
    altitude_deg: Vec<f64>,
    magnitude: Vec<f64>,
    sigma_mag: Vec<f64>,
    time_sigma_s: f64,
}

/// Columns of a HEALPix map of streak rates.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Rates {
    nside: u32,
    cells: Vec<u64>,
    rate: Vec<f64>,
    sun_azimuth_deg: f64,
    subtitle: String,
}

/// Columns of numbers of trails by altitude of the Sun.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Trails {
    sun_altitude_deg: Vec<f64>,
    n_trails: Vec<f64>,
    bin_deg: f64,
    n_bright: Option<Vec<f64>>,
}

/// Draws a plot by name from labels and columns (dictionaries).
#[pyfunction]
pub fn draw(chart: &str, labels: Labels, columns: Bound<'_, PyAny>) -> PyResult<Picture> {
    let (title, caption, limit_mag) = (labels.title.as_str(), "", labels.limit_mag);
    let picture = match chart {
        "night" => {
            let Night { start_mjd, duration_s, n_streaks, brightest_mag } = columns.extract()?;
            night_timeline(&NightTimeline {
                title,
                caption,
                start_mjd: &start_mjd,
                duration_s: &duration_s,
                n_streaks: &n_streaks,
                brightest_mag: &brightest_mag,
                limit_mag,
                sun: &[],
                local: labels.clock(),
            })
        }
        "field" => {
            let field: FieldOf = columns.extract()?;
            let outlines = field.outlines()?;
            let FieldOf { ra_deg, dec_deg, streaks, .. } = field;
            let streak = |(name, track_deg, enter_mjd, exit_mjd, magnitude, sigma_mag)| FieldStreak {
                name,
                track_deg,
                enter_mjd,
                exit_mjd,
                magnitude,
                sigma_mag,
            };
            let streaks: Vec<FieldStreak> = streaks.into_iter().map(streak).collect();
            field_chart(&FieldChart { title, caption, ra_deg, dec_deg, outlines: &outlines, streaks: &streaks })
        }
        "light_curve" => {
            let Curve { time_mjd, magnitude, sigma_mag, in_fitted_range, in_field } = columns.extract()?;
            light_curve(&LightCurve {
                title,
                caption,
                time_mjd: &time_mjd,
                magnitude: &magnitude,
                sigma_mag: &sigma_mag,
                in_fitted_range: &in_fitted_range,
                in_field: &in_field,
                shutter: None,
                limit_mag,
                local: labels.clock(),
            })
        }
        "sky_chart" => {
            let Sky { tracks } = columns.extract()?;
            let track = |Track { name, time_mjd, azimuth_deg, altitude_deg, magnitude, sigma_mag, time_sigma_s }| {
                SkyTrack { name, time_mjd, azimuth_deg, altitude_deg, magnitude, sigma_mag, time_sigma_s }
            };
            let tracks: Vec<SkyTrack> = tracks.into_iter().map(track).collect();
            sky_chart(&SkyChart { title, caption, tracks: &tracks, local: None, site: None })
        }
        "sky_rate" => {
            let Rates { nside, cells, rate, sun_azimuth_deg, subtitle } = columns.extract()?;
            sky_rate(&SkyRate {
                title,
                subtitle: &subtitle,
                caption,
                nside,
                cells: &cells,
                rate: &rate,
                sun_azimuth_deg,
            })
        }
        "sun_altitude" => {
            let Trails { sun_altitude_deg, n_trails, bin_deg, n_bright } = columns.extract()?;
            sun_altitude(&SunAltitude {
                title,
                caption,
                sun_altitude_deg: &sun_altitude_deg,
                n_trails: &n_trails,
                n_bright: n_bright.as_deref().zip(limit_mag),
                bin_deg,
            })
        }
        other => return Err(PyValueError::new_err(format!("unknown chart '{other}'"))),
    };
    picture.map(Picture).map_err(failure::request)
}
