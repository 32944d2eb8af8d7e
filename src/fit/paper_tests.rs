//! Three tests that Lu (2024, section 4) makes before the final model: does the panel offset depend on the Sun's
//! latitude, is the glossy lobe of the solar array needed, and is earthshine needed?

use crate::error::Error;
use crate::photometry::{Earthshine, PANEL_OFFSET};

use super::objective::Loss;
use super::point::FitPoint;
use super::solve::{Fit, FitSettings, Problem};
use super::statistics::{PairedTest, aic_under, paired_t_test, rms};
use super::two_panel_form::TwoPanelForm;

/// Names of the seven coefficients of the form of Lu (2024).
pub const COEFFICIENTS: [&str; 7] = ["c1", "c2", "c3", "c4", "c5", "n_sail", "n_base"];
/// Smallest number of points in a layer.
const LEAST_IN_LAYER: usize = 100;

/// Panel offset that was fitted to one layer of the Sun's latitude (one row of table 2).
#[derive(Clone, Debug, PartialEq)]
pub struct LayerOffset {
    /// Limits of the Sun's latitude, degrees.
    pub sun_latitude_deg: [f64; 2],
    /// Number of points in the layer.
    pub n: usize,
    /// Panel offset, degrees.
    pub panel_offset_deg: f64,
    /// Uncertainty (one sigma) of the panel offset, degrees; `None` if it is not determined.
    pub sigma_deg: Option<f64>,
    /// Root mean square of the residuals, mag.
    pub rms_mag: f64,
}

/// Comparison of two models on the same points.
#[derive(Clone, Debug, PartialEq)]
pub struct PairedModels {
    /// Names of both models.
    pub names: [&'static str; 2],
    /// Number of points.
    pub n: usize,
    /// Number of fitted parameters of each model.
    pub parameters: [usize; 2],
    /// Root mean square of the residuals of each model, mag.
    pub rms_mag: [f64; 2],
    /// Akaike's criterion of each model: n ln(RMS²) + 2k for squares, Σ ρ + 2k for a robust loss.
    pub aic: [f64; 2],
    /// Paired t-test of the mean residuals; `None` if it cannot be computed.
    pub test: Option<PairedTest>,
}

/// Results of the three tests.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperTests {
    /// Panel offsets of the layers (table 2).
    pub offsets: Vec<LayerOffset>,
    /// Layers with too few points: their limits, degrees, and numbers of points.
    pub left_out: Vec<([f64; 2], usize)>,
    /// Models with and without the glossy lobe of the solar array (section 4.2).
    pub sail_glossy: PairedModels,
    /// Models with and without earthshine (section 4.3).
    pub earthshine: PairedModels,
}

/// Makes the fits of all three tests. `layer_deg` is the width of the layers of table 2.
///
/// # Errors
/// The errors of [`Problem::new`] and [`Problem::solve`] for all points together. A layer that cannot be fitted is
/// omitted.
pub fn paper_tests(
    form: &TwoPanelForm,
    points: &[FitPoint],
    settings: &FitSettings,
    layer_deg: f64,
) -> Result<PaperTests, Error> {
    // Parameters that are held in the settings remain held unless a test varies or sets them.
    let free = |names: &[&str], set: &[&str]| {
        let is_held = |name: &str| settings.held.iter().any(|(held, _)| held == name);
        let varies = |name: &&str| **name == *PANEL_OFFSET || !is_held(name);
        let free = names.iter().filter(|name| varies(name)).map(|&name| name.to_owned()).collect::<Vec<String>>();
        let stays = |(name, _): &&(String, f64)| !free.contains(name) && !set.contains(&name.as_str());
        let held = settings.held.iter().filter(stays).cloned().collect();
        FitSettings { free, held, ..settings.clone() }
    };
    let solve =
        |form: &TwoPanelForm, names: &[&str], set: &[&str]| Problem::new(form, points, &free(names, set))?.solve();
    let mut layers = std::collections::BTreeMap::<i64, Vec<FitPoint>>::new();
    for point in points {
        let layer = (point.geometry.sun_latitude_rad.to_degrees() / layer_deg).floor() as i64;
        layers.entry(layer).or_default().push(*point);
    }
    let (mut offsets, mut left_out) = (Vec::new(), Vec::new());
    let mut with_offset = COEFFICIENTS.to_vec();
    with_offset.push(PANEL_OFFSET);
    for (layer, points) in layers.iter().rev() {
        let span = [*layer as f64 * layer_deg, (*layer + 1) as f64 * layer_deg];
        let fit =
            (points.len() >= LEAST_IN_LAYER).then(|| Problem::new(form, points, &free(&with_offset, &[]))?.solve());
        let Some(Ok(fit)) = fit else {
            left_out.push((span, points.len()));
            continue;
        };
        let index = fit.parameters.iter().position(|parameter| parameter.name == PANEL_OFFSET).unwrap_or_default();
        offsets.push(LayerOffset {
            sun_latitude_deg: span,
            n: fit.residuals_mag.len(),
            panel_offset_deg: fit.parameters[index].value,
            sigma_deg: fit.uncertainty.sigma(index),
            rms_mag: rms(&fit.residuals_mag),
        });
    }
    let whole = solve(form, &COEFFICIENTS, &[])?;
    let mut without_gloss = form.clone();
    without_gloss.coefficients.c1 = 0.0;
    let without_gloss = solve(&without_gloss, &["c2", "c3", "c4", "c5", "n_base"], &["c1"])?;
    let other = match form.earthshine {
        Earthshine::Computed => Earthshine::Off,
        Earthshine::Off => Earthshine::Computed,
    };
    let other = solve(&TwoPanelForm { earthshine: other, ..form.clone() }, &COEFFICIENTS, &[])?;
    let (lit, unlit) = if form.earthshine == Earthshine::Computed { (&whole, &other) } else { (&other, &whole) };
    Ok(PaperTests {
        offsets,
        left_out,
        sail_glossy: paired(["with the sail's glossy lobe", "without"], &whole, &without_gloss, points, settings.loss),
        earthshine: paired(["with earthshine", "without"], lit, unlit, points, settings.loss),
    })
}

/// Compares two fits on the points for which both give a magnitude.
fn paired(names: [&'static str; 2], first: &Fit, other: &Fit, points: &[FitPoint], loss: Loss) -> PairedModels {
    let of = |fit: &Fit| {
        fit.kept.iter().copied().zip(fit.residuals_mag.iter().copied()).collect::<std::collections::BTreeMap<_, _>>()
    };
    let (a, b) = (of(first), of(other));
    let both: Vec<(usize, f64, f64)> = a.iter().filter_map(|(i, a)| Some((*i, *a, *b.get(i)?))).collect();
    let shared: Vec<FitPoint> = both.iter().map(|(i, ..)| points[*i]).collect();
    let (a, b): (Vec<f64>, Vec<f64>) = both.iter().map(|(_, a, b)| (*a, *b)).unzip();
    let parameters = [first.free.len(), other.free.len()];
    let aic = |residuals: &[f64], k| aic_under(loss, residuals, &shared, k);
    PairedModels {
        names,
        n: a.len(),
        parameters,
        rms_mag: [rms(&a), rms(&b)],
        aic: [aic(&a, parameters[0]), aic(&b, parameters[1])],
        test: paired_t_test(&a, &b),
    }
}
