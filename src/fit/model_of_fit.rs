//! Model file made from a fit.

use crate::error::Error;
use crate::geometry::ViewingGeometry;
use crate::photometry::{GeometryRange, ModelFile, PANEL_OFFSET, Provenance};

use super::paper_tests::COEFFICIENTS;
use super::point::FitPoint;
use super::solve::Fit;
use super::statistics::{median_mag, weighted_sigma_68_mag};

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
/// covariance, the range of the points, and the sigma of single measurements.
///
/// `singles` are residuals of single measurements (mag, preferably of held-out points) and their weights. Residuals
/// that are not finite are left out. The model is the median of these measurements: its light is multiplied so that the
/// median of the residuals is 0. Sigma is the half width about the median that contains 68.3 % of the weight.
///
/// # Errors
/// A number is outside the limits of model files.
pub fn model_file(
    base: &ModelFile,
    fit: &Fit,
    points: &[FitPoint],
    rms_mag: f64,
    singles: &[(f64, f64)],
    description: &ModelDescription,
) -> Result<ModelFile, Error> {
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
    let singles: Vec<(f64, f64)> = singles.iter().copied().filter(|(residual, _)| residual.is_finite()).collect();
    let median_mag = median_mag(&singles);
    let about_median: Vec<(f64, f64)> =
        singles.iter().map(|(residual, weight)| (residual - median_mag, *weight)).collect();
    let sigma_mag = weighted_sigma_68_mag(&about_median);
    // A magnitude fainter by the median is light multiplied by 10^(-0.4 median).
    let factor = 10_f64.powf(-0.4 * median_mag);
    let before = fitted.clone();
    if let Some(c) = &mut fitted.coefficients {
        [&mut c.c1, &mut c.c2, &mut c.c3, &mut c.c4, &mut c.c5].into_iter().for_each(|c| *c *= factor);
    }
    if let Some(panels) = &mut fitted.panels {
        panels.scale_light(factor);
    }
    // The covariance is that of the scaled parameters.
    let scale = |(name, value): (&str, f64)| {
        let scaled =
            fitted.parameters().into_iter().find(|(other, _)| *other == name).map_or(value, |(_, value)| value);
        if value == 0.0 { 1.0 } else { scaled / value }
    };
    let scales: Vec<f64> = before.parameters().into_iter().map(scale).collect();
    let scale_of = |row: usize| scales.get(row).copied().unwrap_or(1.0);
    let scaled = |all: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let row = |(r, &i): (usize, &usize)| {
            order.iter().enumerate().map(|(c, &j)| all[i][j] * scale_of(r) * scale_of(c)).collect()
        };
        order.iter().enumerate().map(row).collect()
    };
    let file = ModelFile {
        name: description.name.clone(),
        aliases: Vec::new(),
        title: description.title.clone(),
        covariance: covariance.map(scaled),
        rms_mag: Some(rounded(rms_mag)),
        sigma_mag: rounded(sigma_mag),
        sigma_origin: description.sigma_origin.clone(),
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
