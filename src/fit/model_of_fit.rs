//! Model file made from a fit.

use crate::geometry::ViewingGeometry;
use crate::photometry::{GeometryRange, ModelFile, PANEL_OFFSET, PhotometryError, Provenance};

use super::error_distribution::error_distribution;
use super::paper_tests::COEFFICIENTS;
use super::point::FitPoint;
use super::solve::Fit;
use super::statistics::sigma_68_mag;

/// Uncertainty that is added in quadrature to sigma outside the fitted geometry, mag. It is assumed, and the same for
/// all models.
const OUTSIDE_MAG: f64 = 1.0;
/// Fraction of the points that is ignored at each end of the range of geometry, because a few stray points do not cover
/// a range.
const STRAY_SHARE: f64 = 0.001;

/// Texts that describe a model in its file.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelDescription {
    /// Name of the model.
    pub name: String,
    /// Title of the model.
    pub title: String,
    /// Author or program that made the fit.
    pub source: String,
    /// Description of the measurements.
    pub data: String,
    /// Month of the fit, for example `2026-11`.
    pub date: String,
    /// True if the fit has faults, so that the model is provisional.
    pub provisional: bool,
    /// Notes for users.
    pub notes: Vec<String>,
    /// Description of how sigma was determined.
    pub sigma_origin: String,
}

/// Returns a model file with the shape of `base` (chassis and sail, or a list of panels), the fitted parameters, their
/// covariance, the range of the points, and sigma and distribution of the residuals of single measurements
/// (`singles_mag`, preferably of held-out points).
///
/// # Errors
/// [`PhotometryError`] if a number is outside the limits of model files.
pub fn model_file(
    base: &ModelFile,
    fit: &Fit,
    points: &[FitPoint],
    rms_mag: f64,
    singles_mag: &[f64],
    description: &ModelDescription,
) -> Result<ModelFile, PhotometryError> {
    let index = |name: &str| fit.parameters.iter().position(|parameter| parameter.name == name);
    let mut order: Vec<usize> = base
        .parameters()
        .iter()
        .filter(|(name, _)| *name != PANEL_OFFSET)
        .filter_map(|(name, _)| index(name))
        .collect();
    // The covariance of a model of chassis and solar array includes the panel offset only if it was fitted.
    order.extend(index(PANEL_OFFSET).filter(|index| base.shape.is_some() && fit.free.contains(index)));
    let covariance = fit.uncertainty.covariance.as_ref();
    let value = |name: &str, otherwise: f64| fit.value(name).unwrap_or(otherwise);
    let mut fitted = base.clone();
    if let Some(shape) = &mut fitted.shape {
        shape.panel_offset_deg = value(PANEL_OFFSET, shape.panel_offset_deg);
    }
    if let Some(c) = &mut fitted.coefficients {
        let all = [&mut c.c1, &mut c.c2, &mut c.c3, &mut c.c4, &mut c.c5, &mut c.n_sail, &mut c.n_base];
        COEFFICIENTS.iter().zip(all).for_each(|(name, c)| *c = value(name, *c));
    }
    for parameter in fitted.panels.iter_mut().flat_map(|panels| &mut panels.parameters) {
        parameter.value = value(&parameter.name, parameter.value);
    }
    let sigma_mag = sigma_68_mag(singles_mag);
    let in_sigmas: Vec<(f64, f64)> = singles_mag.iter().map(|residual_mag| (residual_mag / sigma_mag, 1.0)).collect();
    let file = ModelFile {
        name: description.name.clone(),
        aliases: Vec::new(),
        title: description.title.clone(),
        covariance: covariance.map(|all| order.iter().map(|&i| order.iter().map(|&j| all[i][j]).collect()).collect()),
        rms_mag: Some(rounded(rms_mag)),
        sigma_mag: rounded(sigma_mag),
        sigma_outside_mag: rounded(sigma_mag.hypot(OUTSIDE_MAG)),
        sigma_origin: description.sigma_origin.clone(),
        error_distribution: error_distribution(&in_sigmas),
        geometry_range: Some(range_of(points)),
        provenance: Provenance {
            source: description.source.clone(),
            data: description.data.clone(),
            n_points: Some(fit.kept.len() as u64),
            date: description.date.clone(),
            provisional: description.provisional,
            notes: description.notes.clone(),
        },
        ..fitted
    };
    // The file is read back, so that it passes the same checks as any model file.
    ModelFile::from_json(&file.to_json(), &description.name)
}

/// Returns the ranges of the angles of the points, rounded outward to whole degrees.
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
