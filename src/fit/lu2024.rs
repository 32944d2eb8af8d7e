//! Numbers that Lu (2024, Universe 10, 215; arXiv 2403.05831) prints, and the same numbers computed from photometry.
//!
//! The paper prints no coefficients. [`Lu2024Truth`] is a satellite with the printed sizes and, in each layer of the
//! Sun's latitude, the panel offset of table 2; its coefficients are those of a model file, with an assumed gloss of
//! the solar array. Photometry that is simulated with it shows what the method of the paper recovers.

use super::jackknife::jackknife;
use super::measurements::{Measurement, Measurements, ReduceOptions, Reduction, reduce};
use super::paper_tests::{COEFFICIENTS, LayerOffset, PairedModels, PaperTests, paper_tests};
use super::point::points_of_pixels;
use super::posterior::Posterior;
use super::solve::{Fit, FitSettings, Problem};
use super::statistics::rms;
use super::two_panel_form::TwoPanelForm;
use super::{CovarianceKind, RawWeights, points_of_measurements, predict};
use crate::error::{Error, ErrorKind};
use crate::geometry::ViewingGeometry;
use crate::message::Quoted;
use crate::output::{Column, Kind, Table};
use crate::photometry::{BrightnessModel, Coefficients, Earthshine, ModelFile, PANEL_OFFSET, StandardMagnitude};

/// Layer of the Sun's latitude in table 2 of the paper.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PublishedLayer {
    /// Lower limit of the Sun's latitude, degrees; the layer is 1° wide.
    pub from_deg: i32,
    /// Printed panel offset, degrees.
    pub panel_offset_deg: f64,
    /// Printed root mean square of the residuals, mag.
    pub rms_mag: f64,
}

const fn layer(from_deg: i32, panel_offset_deg: f64, rms_mag: f64) -> PublishedLayer {
    PublishedLayer { from_deg, panel_offset_deg, rms_mag }
}

/// Table 2 of the paper.
pub const PUBLISHED_LAYERS: [PublishedLayer; 10] = [
    layer(-12, -2.8100, 0.2275),
    layer(-13, -2.6224, 0.2142),
    layer(-14, -2.4771, 0.2245),
    layer(-15, -3.1621, 0.1912),
    layer(-16, -2.9903, 0.1962),
    layer(-17, -2.3624, 0.1886),
    layer(-18, -3.1250, 0.2160),
    layer(-19, -3.0606, 0.2290),
    layer(-20, -2.3758, 0.2230),
    layer(-21, -2.7825, 0.2263),
];

/// Assumed gloss of the solar array of the simulated satellite: weight and exponent of the lobe.
const ASSUMED_SAIL_GLOSS: (f64, f64) = (0.02, 4.0);
/// Number of sets of tracks of the jackknife.
const SETS: usize = 24;
/// Largest number of single measurements whose residuals are computed.
const SINGLES: usize = 20_000;
/// Layer of figure 2, degrees.
const SLICE_DEG: i32 = -19;

/// Satellite whose brightness is simulated: two panels with the offsets of table 2.
#[derive(Clone, Debug)]
pub struct Lu2024Truth {
    /// Coefficients.
    pub coefficients: Coefficients,
    layers: Vec<(i32, BrightnessModel)>,
    /// Model outside the layers of table 2, with the mean of their offsets.
    outside: BrightnessModel,
}

impl Lu2024Truth {
    /// Creates a satellite with sizes and coefficients of a two-panel model file.
    ///
    /// # Errors
    /// The file has no two panels.
    pub fn new(base: &ModelFile) -> Result<Self, Error> {
        let mut file = base.clone();
        file.covariance = None;
        if let Some(c) = &mut file.coefficients {
            (c.c1, c.n_sail) = ASSUMED_SAIL_GLOSS;
        }
        let model = |panel_offset_deg: f64| {
            let mut file = file.clone();
            if let Some(shape) = &mut file.shape {
                shape.panel_offset_deg = panel_offset_deg;
            }
            BrightnessModel::from_file(file, "simulated satellite")
        };
        let layers = PUBLISHED_LAYERS.iter().map(|layer| Ok((layer.from_deg, model(layer.panel_offset_deg)?)));
        let layers = layers.collect::<Result<_, Error>>()?;
        let mean_deg = PUBLISHED_LAYERS.iter().map(|layer| layer.panel_offset_deg).sum::<f64>() / 10.0;
        let coefficients = file.coefficients.ok_or_else(|| {
            Error::new(ErrorKind::Invalid, format!("unknown model '{}'", Quoted::new(&base.name)))
                .allowing("models of two panels")
        })?;
        Ok(Self { coefficients, layers, outside: model(mean_deg)? })
    }

    /// Returns the magnitude at 1000 km with earthshine; `None` if no lit surface is visible.
    pub fn magnitude(&self, geometry: &ViewingGeometry) -> Option<StandardMagnitude> {
        let from_deg = geometry.sun_latitude_rad.to_degrees().floor() as i32;
        let found = self.layers.iter().find(|(layer, _)| *layer == from_deg);
        found.map_or(&self.outside, |(_, model)| model).standard_magnitude_with(geometry, Earthshine::Computed)
    }

    /// Returns the coefficients in the order of [`COEFFICIENTS`].
    pub fn values(&self) -> [f64; 7] {
        let c = &self.coefficients;
        [c.c1, c.c2, c.c3, c.c4, c.c5, c.n_sail, c.n_base]
    }
}

/// Results of the computations of sections 3 and 4 of the paper.
#[derive(Clone, Debug)]
pub struct Lu2024 {
    /// Number of selected measurements.
    pub measurements: usize,
    /// Number of tracks (or nights, files) of the photometry.
    pub tracks: usize,
    /// Pixels with their thresholds.
    pub pixels: Reduction,
    /// Pixels of figure 2, with both sides of the plane through the Sun; `None` without measurements in this layer.
    pub slice: Option<Reduction>,
    /// Panel offsets of the layers of table 2 that have enough pixels.
    pub layers: Vec<LayerOffset>,
    /// Tests of sections 4.1 to 4.3.
    pub tests: PaperTests,
    /// Final model: seven coefficients, panel offset 0, with earthshine.
    pub fit: Fit,
    /// Fit in which the panel offset is free as well.
    pub free_offset: Fit,
    /// Residuals of at most 20,000 single measurements from the final model, mag.
    pub single_mag: Vec<f64>,
}

/// Computes the numbers of sections 3 and 4 from measurements. `each` is called after each of [`LU2024_PARTS`] parts.
///
/// # Errors
/// The errors of [`reduce`], [`Problem::new`] and [`Problem::solve`], for example too few pixels.
pub fn lu2024(
    form: &TwoPanelForm,
    measurements: &Measurements,
    options: ReduceOptions,
    each: &dyn Fn(),
) -> Result<Lu2024, Error> {
    let pixels = reduce(&measurements.points, options)?;
    let inside = within(measurements, SLICE_DEG);
    let slice = (!inside.points.is_empty())
        .then(|| reduce(&inside.points, ReduceOptions { fold: false, ..options }))
        .transpose()?;
    let points = points_of_pixels(&pixels);
    each();
    let tests = paper_tests(form, &points, &FitSettings::default(), 1.0)?;
    each();
    let mut with_offset = COEFFICIENTS.to_vec();
    with_offset.push(PANEL_OFFSET);
    let mut layers = Vec::new();
    for published in &PUBLISHED_LAYERS {
        let span = [f64::from(published.from_deg), f64::from(published.from_deg + 1)];
        let fitted = tests.offsets.iter().find(|offset| offset.sun_latitude_deg == span);
        if let Some(fitted) = fitted {
            let inside = within(measurements, published.from_deg);
            let fit = fitted_with_errors(form, &inside, options, &FitSettings::free(&with_offset))?;
            let index = fit.parameters.iter().position(|parameter| parameter.name == PANEL_OFFSET).unwrap_or_default();
            layers.push(LayerOffset { sigma_deg: fit.uncertainty.sigma(index), ..fitted.clone() });
        }
        each();
    }
    let free_offset = fitted_with_errors(form, measurements, options, &FitSettings::free(&with_offset))?;
    each();
    let fit = fitted_with_errors(form, measurements, options, &FitSettings::free(&COEFFICIENTS))?;
    each();
    // Every k-th measurement suffices for the distribution of residuals.
    let every = measurements.points.len().div_ceil(SINGLES);
    let thinned = Measurements {
        points: measurements.points.iter().step_by(every).copied().collect(),
        groups: measurements.groups.clone(),
        ..Measurements::default()
    };
    let singles = points_of_measurements(&thinned, &RawWeights { group_correlation: 0.0, ..RawWeights::default() });
    let predicted = predict(form, &singles, &fit.values());
    let residuals = singles.iter().zip(predicted).map(|(point, predicted)| point.magnitude - predicted);
    let single_mag = residuals.filter(|residual| residual.is_finite()).collect();
    let (tracks, measurements) = (measurements.groups.len(), measurements.points.len());
    Ok(Lu2024 { measurements, tracks, pixels, slice, layers, tests, fit, free_offset, single_mag })
}

/// Number of parts of [`lu2024`].
pub const LU2024_PARTS: usize = 4 + PUBLISHED_LAYERS.len();

/// Returns the measurements of a layer 1° wide.
fn within(measurements: &Measurements, from_deg: i32) -> Measurements {
    let is_inside = |point: &&Measurement| point.geometry.sun_latitude_rad.to_degrees().floor() as i32 == from_deg;
    let points = measurements.points.iter().filter(is_inside).copied().collect();
    Measurements { points, groups: measurements.groups.clone(), ..Measurements::default() }
}

/// Fits pixels. The errors are those of the jackknife over tracks; if there are too few tracks or pixels for it, the
/// pixels are assumed to be independent.
fn fitted_with_errors(
    form: &TwoPanelForm,
    measurements: &Measurements,
    options: ReduceOptions,
    settings: &FitSettings,
) -> Result<Fit, Error> {
    let points = points_of_pixels(&reduce(&measurements.points, options)?);
    let fit = Problem::new(form, &points, settings)?.solve()?;
    match jackknife(form, measurements, options, &fit, settings, SETS) {
        Ok(covariance) => Ok(fit.with_covariance(covariance, CovarianceKind::Jackknife)),
        Err(error) if error.kind() == ErrorKind::TooFewData => Ok(fit),
        Err(error) => Err(error),
    }
}

/// Origin of the photometry, which determines why numbers differ from those of the paper.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Lu2024Data {
    /// Simulated with [`Lu2024Truth`].
    Simulated,
    /// Files of measured magnitudes.
    Measured,
}

/// Number printed in the paper, and the number computed here.
#[derive(Clone, Debug, PartialEq)]
pub struct Lu2024Row {
    /// Table, figure or section of the paper.
    pub section: &'static str,
    /// Description of the quantity.
    pub quantity: String,
    /// Unit; empty for counts, criteria and probabilities.
    pub unit: &'static str,
    /// Printed number; `None` if the paper prints none.
    pub paper: Option<f64>,
    /// Computed number; `None` if it cannot be computed from the given data.
    pub ours: Option<f64>,
    /// One sigma of the computed number.
    pub ours_sigma: Option<f64>,
    /// Reason for the difference, or for which there is no computed number.
    pub reason: String,
}

const COLUMNS: [Column; 7] = [
    Column::new("section", Kind::Text, "Table, figure or section of Lu (2024)."),
    Column::new("quantity", Kind::Text, "Description of the quantity."),
    Column::new("unit", Kind::Text, "Unit; empty for counts, criteria and probabilities."),
    Column::real("paper", "", 4, "Printed number; empty if the paper prints none."),
    Column::real("ours", "", 5, "Computed number; empty if the data for it are not given."),
    Column::real("ours_sigma", "", 6, "One sigma of the computed number."),
    Column::new("reason", Kind::Text, "Reason for the difference, or for which there is no computed number."),
];

/// Returns a table with one row per number.
pub fn lu2024_table(rows: &[Lu2024Row]) -> Table {
    let row = |number: &Lu2024Row| {
        vec![
            number.section.into(),
            number.quantity.as_str().into(),
            number.unit.into(),
            number.paper.into(),
            number.ours.into(),
            number.ours_sigma.into(),
            number.reason.as_str().into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: rows.iter().map(row).collect() }
}

const FEWER: &str = "fewer measurements than the four million of the paper";
const ERRORS: &str =
    "scatter, attitudes and misidentified tracks of the simulation are assumed; the paper states only their order";
const OTHER_SATELLITES: &str = "other photometry than that of the paper";

/// Returns the rows of section 3, table 2, sections 4.1 to 4.4 and the posterior.
pub fn lu2024_rows(found: &Lu2024, posterior: Option<&Posterior>, data: Lu2024Data) -> Vec<Lu2024Row> {
    let is_simulated = data == Lu2024Data::Simulated;
    let noise = if is_simulated { ERRORS } else { OTHER_SATELLITES };
    let mut rows = Vec::new();
    let mut add = |section, quantity: String, unit, paper: Option<f64>, ours: Option<f64>, sigma, reason: &str| {
        rows.push(Lu2024Row { section, quantity, unit, paper, ours, ours_sigma: sigma, reason: reason.to_owned() });
    };
    let of = |count: usize| Some(count as f64);
    let kept = found.pixels.kept().count();
    add("section 3", "measurements".into(), "", Some(4e6), of(found.measurements), None, FEWER);
    add("section 3", "pixels before thresholds".into(), "", Some(2e4), of(found.pixels.pixels.len()), None, FEWER);
    let implied = "the paper prints no number: 4651 follows from both pairs of its RMS and AIC; other measurements";
    add("section 4.2", "pixels fitted".into(), "", Some(4651.0), of(kept), None, implied);
    for published in &PUBLISHED_LAYERS {
        let from = f64::from(published.from_deg);
        let layer = found.layers.iter().find(|layer| layer.sun_latitude_deg[0] == from);
        let name = |what: &str| format!("{what}, Sun at {} to {} deg", published.from_deg + 1, published.from_deg);
        let reason = match (layer, is_simulated) {
            (None, _) => "fewer than 100 pixels in this layer",
            (_, true) => {
                "the printed offset is that of the simulated satellite: the difference is the error of the method"
            }
            (_, false) => OTHER_SATELLITES,
        };
        let (ours, sigma) = (layer.map(|layer| layer.panel_offset_deg), layer.and_then(|layer| layer.sigma_deg));
        add("table 2", name("panel offset"), "deg", Some(published.panel_offset_deg), ours, sigma, reason);
        let reason = if layer.is_some() { noise } else { reason };
        let ours = layer.map(|layer| layer.rms_mag);
        add("table 2", name("RMS"), "mag", Some(published.rms_mag), ours, None, reason);
    }
    let mut pair = |section, pair: &PairedModels, paper: [[Option<f64>; 2]; 2], p: f64, reasons: [&str; 3]| {
        for (k, name) in pair.names.iter().enumerate() {
            add(section, format!("RMS {name}"), "mag", paper[k][0], Some(pair.rms_mag[k]), None, reasons[0]);
            add(section, format!("AIC {name}"), "", paper[k][1], Some(pair.aic[k]), None, reasons[1]);
        }
        let ours = pair.test.map(|test| test.p);
        add(section, "p of the paired t-test".into(), "", Some(p), ours, None, reasons[2]);
    };
    let aic = "AIC is proportional to the number of pixels; see the difference of the two models";
    let gloss = "the test compares mean residuals; the gloss of the simulated solar array is assumed";
    let printed = [[Some(0.2408), Some(-13232.0)], [Some(0.2423), Some(-13176.0)]];
    pair("section 4.2", &found.tests.sail_glossy, printed, 0.0, [noise, aic, gloss]);
    let shine = "the test compares mean residuals, which light through the solar array absorbs";
    let none = "the paper prints no AIC of this pair";
    pair(
        "section 4.3",
        &found.tests.earthshine,
        [[Some(0.2408), None], [Some(0.2410), None]],
        0.25,
        [noise, none, shine],
    );
    let [with, without] = found.tests.sail_glossy.aic;
    add("section 4.2", "AIC without gloss less AIC with it".into(), "", Some(56.0), Some(without - with), None, gloss);
    let [with, without] = found.tests.earthshine.aic;
    add("section 4.3", "AIC without earthshine less AIC with it".into(), "", None, Some(without - with), None, none);
    add(
        "figure 5",
        "RMS of the final model".into(),
        "mag",
        Some(0.25),
        Some(rms(&found.fit.residuals_mag)),
        None,
        noise,
    );
    let coefficients = "the paper prints no coefficients";
    for (index, name) in COEFFICIENTS.iter().enumerate() {
        let (value, sigma) = (found.fit.value(name), found.fit.uncertainty.sigma(index));
        add("section 4.4", (*name).to_owned(), "", None, value, sigma, coefficients);
    }
    for marginal in posterior.iter().flat_map(|posterior| &posterior.marginals) {
        let [low, median, high] = marginal.quantiles;
        let name = format!("{}, median and half the interval 0.16 to 0.84", marginal.name);
        let reason = "the paper prints no numbers of its posterior";
        add("posterior", name, "", None, Some(median), Some(0.5 * (high - low)), reason);
    }
    rows
}

const RECOVERED: [Column; 6] = [
    Column::new("parameter", Kind::Text, "Name of the parameter."),
    Column::real("simulated", "", 5, "Value of the simulated satellite."),
    Column::real("free_offset", "", 5, "Fit with free panel offset."),
    Column::real("free_offset_sigma", "", 5, "One sigma."),
    Column::real("final", "", 5, "Final model with the panel offset 0."),
    Column::real("final_sigma", "", 5, "One sigma."),
];

/// Returns a table of the parameters of the simulated satellite and of both fits.
pub fn recovered_table(found: &Lu2024, truth: Option<&Lu2024Truth>) -> Table {
    let mean_deg = PUBLISHED_LAYERS.iter().map(|layer| layer.panel_offset_deg).sum::<f64>() / 10.0;
    let rows = found.fit.parameters.iter().enumerate().map(|(index, parameter)| {
        let simulated = truth.map(|truth| truth.values().get(index).copied().unwrap_or(mean_deg));
        vec![
            parameter.name.as_str().into(),
            simulated.into(),
            found.free_offset.parameters[index].value.into(),
            found.free_offset.uncertainty.sigma(index).into(),
            parameter.value.into(),
            found.fit.uncertainty.sigma(index).into(),
        ]
    });
    Table { columns: RECOVERED.to_vec(), rows: rows.collect() }
}
