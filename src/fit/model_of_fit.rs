//! A fit as a model file.

use crate::geometry::ViewingGeometry;
use crate::photometry::{Coefficients, GeometryRange, ModelFile, ModelFileError, Provenance};

use super::paper::COEFFICIENTS;
use super::point::FitPoint;
use super::solve::Fit;

/// Outside the geometry that was fitted, sigma grows by this in quadrature, mag: assumed, as for all models.
const OUTSIDE_MAG: f64 = 1.0;
/// Share of the points that the stated range of geometry leaves out at each end: single stray points are no coverage.
const STRAY_SHARE: f64 = 0.001;

/// What a model file says beside its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelWords {
    /// Name of the model.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Maker of the fit.
    pub source: String,
    /// The measurements.
    pub data: String,
    /// `2026-11`.
    pub date: String,
    /// True while a better fit is due: where the fit is not sound.
    pub provisional: bool,
    /// What a careful user should know.
    pub notes: Vec<String>,
    /// Where sigma comes from.
    pub sigma_origin: String,
}

/// The model that `base` becomes with the fitted coefficients, their covariance, the range of the points, and a sigma.
///
/// # Errors
/// [`ModelFileError`] where the fit's numbers are outside what a model file may hold, or `base` is not made of two panels.
pub fn two_panel_file(
    base: &ModelFile,
    fit: &Fit,
    points: &[FitPoint],
    rms_mag: f64,
    sigma_mag: f64,
    words: &ModelWords,
) -> Result<ModelFile, ModelFileError> {
    let value = |name: &str| fit.value(name).unwrap_or(f64::NAN);
    let index = |name: &str| fit.parameters.iter().position(|parameter| parameter.name == name);
    let order: Vec<usize> = COEFFICIENTS.iter().filter_map(|name| index(name)).collect();
    let covariance = fit.certainty.covariance.as_ref();
    let mut shape = base.shape;
    if let (Some(shape), Some(offset)) = (&mut shape, fit.value("panel_offset_deg")) {
        shape.panel_offset_deg = offset;
    }
    let fitted = ModelFile {
        shape,
        coefficients: Some(Coefficients {
            c1: value("c1"),
            c2: value("c2"),
            c3: value("c3"),
            c4: value("c4"),
            c5: value("c5"),
            n_sail: value("n_sail"),
            n_base: value("n_base"),
        }),
        covariance: covariance.map(|all| order.iter().map(|&i| order.iter().map(|&j| all[i][j]).collect()).collect()),
        ..base.clone()
    };
    named(fitted, fit, points, rms_mag, sigma_mag, words)
}

/// The same for a model that lists its panels.
///
/// # Errors
/// As [`two_panel_file`].
pub fn panels_file(
    base: &ModelFile,
    fit: &Fit,
    points: &[FitPoint],
    rms_mag: f64,
    sigma_mag: f64,
    words: &ModelWords,
) -> Result<ModelFile, ModelFileError> {
    let mut panels = base.panels.clone();
    for parameter in panels.iter_mut().flat_map(|panels| &mut panels.parameters) {
        parameter.value = fit.value(&parameter.name).unwrap_or(parameter.value);
    }
    let fitted = ModelFile { panels, covariance: fit.certainty.covariance.clone(), ..base.clone() };
    named(fitted, fit, points, rms_mag, sigma_mag, words)
}

/// Everything but the numbers of the law.
fn named(
    fitted: ModelFile,
    fit: &Fit,
    points: &[FitPoint],
    rms_mag: f64,
    sigma_mag: f64,
    words: &ModelWords,
) -> Result<ModelFile, ModelFileError> {
    let file = ModelFile {
        name: words.name.clone(),
        aliases: Vec::new(),
        title: words.title.clone(),
        rms_mag: Some(rounded(rms_mag)),
        sigma_mag: rounded(sigma_mag),
        sigma_outside_mag: rounded(sigma_mag.hypot(OUTSIDE_MAG)),
        sigma_origin: words.sigma_origin.clone(),
        geometry_range: Some(range_of(points)),
        provenance: Provenance {
            source: words.source.clone(),
            data: words.data.clone(),
            n_points: Some(fit.kept.len() as u64),
            date: words.date.clone(),
            provisional: words.provisional,
            notes: words.notes.clone(),
        },
        ..fitted
    };
    // What would be refused on reading is refused on writing.
    ModelFile::from_json(&file.to_json(), &words.name)
}

/// Least and greatest angles of the points, degrees outward.
pub fn range_of(points: &[FitPoint]) -> GeometryRange {
    let span = |angle: fn(&ViewingGeometry) -> f64| {
        let mut angles: Vec<f64> = points.iter().map(|point| angle(&point.geometry).to_degrees()).collect();
        angles.sort_by(f64::total_cmp);
        let stray = (angles.len() as f64 * STRAY_SHARE) as usize;
        let (first, last) = (angles.get(stray)?, angles.get(angles.len().checked_sub(1 + stray)?)?);
        Some([first.floor(), last.ceil()])
    };
    GeometryRange {
        sun_latitude_deg: span(|g| g.sun_latitude_rad),
        observer_latitude_deg: span(|g| g.observer_latitude_rad),
        phase_angle_deg: span(ViewingGeometry::phase_angle_rad),
    }
}

fn rounded(mag: f64) -> f64 {
    (mag * 1000.0).round() / 1000.0
}
