//! Comparison of one model with one reference: differences and a verdict.

use std::collections::BTreeMap;

use crate::math::quantile::median;
use crate::output::{Column, Kind, Table};
use crate::photometry::BrightnessModel;

use super::super::point::group_weights;
use super::super::statistics::{ResidualStatistics, share_within, weighted_sigma_68_mag};
use super::photometry::{Photometry, ReferenceMeasurement, in_v};
use super::population::shell_geometries;
use super::published::{PublishedCurve, PublishedMean, Subject};

/// Error of a mean difference between a correct model and a reference, mag, apart from the statistical error of
/// measurements. Unfiltered AB magnitudes and V (Vega) differ by 0.02 to 0.2 mag for solar colours, and surveys of the
/// same type of satellite differ by as much. The geometries of a survey are not those of the population.
pub const SURVEY_ERROR_MAG: f64 = 0.2;

/// Largest mean difference between model and reference with which a model is accepted, in units of the error of this
/// difference.
const DIFFERENCE_TOLERANCE: f64 = 2.0;

/// Correlation of the differences of one track, night or pass, from which the weights of the measurements follow. It is
/// 0.2 to 0.6 in the surveys.
const GROUP_CORRELATION: f64 = 0.5;

/// Smallest and largest accepted ratio of the half width that contains 68.3 % of the differences from measurements to
/// the predicted sigma. A sigma that is too small misleads more than one that is too large.
pub const SIGMA_RATIOS: [f64; 2] = [1.0 / 1.5, 1.25];

/// Largest RMS with which a model is accepted, in units of the predicted sigma. Flares and misidentified satellites
/// form wings, which raise the RMS above the sigma that contains 68.3 %. Above twice that sigma the wings dominate.
const RMS_TOLERANCE_SIGMA: f64 = 2.0;

/// Difference between the median of single magnitudes, which a model predicts, and their mean, which is published, in
/// units of sigma: flares make the mean brighter. The files of published means and phase functions are fainter by as
/// much.
pub const MEDIAN_LESS_MEAN_SIGMAS: f64 = 0.2;

/// Kind of a reference.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum ReferenceKind {
    /// A published mean, compared with the model's mean over [`POPULATION`](super::POPULATION).
    Mean,
    /// A published phase function, compared over the same geometries within the phase function's range of validity.
    PhaseCurve,
    /// Measured magnitudes in full sunlight, each in its own geometry.
    Photometry,
    /// Measured magnitudes in sunlight that grazes the Earth lower than 100 km, each in its own geometry and dimmed by
    /// the atmosphere.
    GrazingPhotometry,
    /// There is no reference for these satellites.
    None,
}

impl ReferenceKind {
    fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::PhaseCurve => "phase curve",
            Self::Photometry => "photometry",
            Self::GrazingPhotometry => "grazing",
            Self::None => "none",
        }
    }
}

/// Relation between the reference and the data from which a model was made.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Sample {
    /// The provenance of the model names the survey or the publication: agreement is not a test of predictions.
    InSample,
    /// The provenance of the model does not name it.
    HeldOut,
}

impl Sample {
    fn new(is_in_sample: bool) -> Self {
        if is_in_sample { Self::InSample } else { Self::HeldOut }
    }

    fn name(self) -> &'static str {
        match self {
            Self::InSample => "in-sample",
            Self::HeldOut => "held-out",
        }
    }
}

/// Result of a comparison.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The model agrees with the reference within the tolerances of [`compare`].
    Ok,
    /// The model differs from the reference by more than the tolerances.
    Off,
    /// There are no data to compare with.
    NoData,
}

impl Verdict {
    fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Off => "off",
            Self::NoData => "no data",
        }
    }
}

/// Comparison of one model with one reference. Magnitudes are V (Vega) at a range of 1000 km, whatever the band of the
/// model; differences are reference minus model.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Name of the model.
    pub model: String,
    /// Satellites that the model describes; `None` if its name is unknown.
    pub satellites: Option<&'static str>,
    /// Kind of the reference.
    pub kind: ReferenceKind,
    /// Publication of the reference; empty if there is no reference.
    pub reference: &'static str,
    /// Relation of the reference to the data of the model; `None` if there is no reference.
    pub sample: Option<Sample>,
    /// Number of geometries or measurements compared.
    pub n: usize,
    /// Mean of the model over these geometries or measurements, mag. For published means and phase functions it is that
    /// of single magnitudes, which is `MEDIAN_LESS_MEAN_SIGMAS` brighter than the mean of the predicted medians.
    pub model_mean_mag: Option<f64>,
    /// Standard deviation of the model over these geometries or measurements, mag.
    pub model_sd_mag: Option<f64>,
    /// Mean of the reference, mag: as published, or over the same geometries or measurements.
    pub reference_mean_mag: Option<f64>,
    /// Standard deviation of the reference, mag.
    pub reference_sd_mag: Option<f64>,
    /// Mean of reference minus model, mag.
    pub difference_mag: Option<f64>,
    /// Error of this difference for a correct model, mag: [`SURVEY_ERROR_MAG`] and, in quadrature, the statistical
    /// error of the mean of measurements, whose groups (tracks, nights) are independent.
    pub difference_error_mag: Option<f64>,
    /// Root mean square of reference minus model, mag; `None` if the reference is a published mean.
    pub rms_mag: Option<f64>,
    /// 1.4826 times the median absolute deviation of reference minus model, mag; `None` if the reference is a published
    /// mean.
    pub core_mag: Option<f64>,
    /// Uncertainty (one sigma) of a single prediction, mag: the median of the sigmas that the program predicts for the
    /// geometries of the measurements; for other references that in the model's file.
    pub sigma_mag: f64,
    /// Fraction of the differences that are within the sigma of their prediction. If the reference is a published mean:
    /// fraction of the model's magnitudes that are within the published standard deviation of that mean.
    pub within_one_sigma: Option<f64>,
    /// Half width that contains 68.3 % of the differences from measurements, each in units of the sigma of its
    /// prediction; `None` for other references.
    pub sigma_ratio: Option<f64>,
    /// Result of the comparison.
    pub verdict: Verdict,
}

/// Compares a model with every published reference for its satellites, and with measurements if given.
///
/// The model's name or an alias selects the references. The model agrees with
///
/// * a published mean if the difference is at most twice its error;
/// * a published curve if, in addition, the RMS of the differences does not exceed the standard deviation of the
///   survey, because the survey scatters by as much about its own curve, and a model that depends on more angles than
///   the phase angle cannot follow the curve exactly;
/// * measurements if the difference is at most twice its error, the ratio of sigmas is within `SIGMA_RATIOS`, and the
///   RMS is at most twice sigma. Measurements in grazing sunlight are compared separately with
///   the same tolerances. Each measurement is compared with the sigma that the program predicts for its geometry, and
///   weighted by the number of measurements of its group.
///
/// The result has at least one row.
pub fn compare(model: &BrightnessModel, photometry: Option<&Photometry>) -> Vec<Comparison> {
    let name = model.file().map(|file| file.name.clone()).unwrap_or_default();
    let sigma_mag = model.file().map_or(f64::NAN, |file| file.sigma_mag);
    let subject = model.file().and_then(Subject::from_model_file);
    let blank = Comparison {
        model: name,
        satellites: subject.map(|subject| subject.name),
        kind: ReferenceKind::None,
        reference: "",
        sample: None,
        n: 0,
        model_mean_mag: None,
        model_sd_mag: None,
        reference_mean_mag: None,
        reference_sd_mag: None,
        difference_mag: None,
        difference_error_mag: None,
        rms_mag: None,
        core_mag: None,
        sigma_mag,
        within_one_sigma: None,
        sigma_ratio: None,
        verdict: Verdict::NoData,
    };
    let Some(subject) = subject else { return vec![blank] };
    let provenance = model.file().map(|file| format!("{} {}", file.provenance.source, file.provenance.data));
    let names = |text: &str| provenance.as_ref().is_some_and(|provenance| is_named(text, provenance));
    let mut rows = Vec::new();
    if let Some((height_km, inclination_deg)) = subject.shell {
        let modelled: Vec<Modelled> = shell_geometries(height_km, inclination_deg)
            .iter()
            .filter_map(|(geometry, weight)| {
                let magnitude = in_v(model, geometry)?.0 - MEDIAN_LESS_MEAN_SIGMAS * sigma_mag;
                Some(Modelled { magnitude, weight: *weight, phase_rad: geometry.phase_angle_rad() })
            })
            .collect();
        let row = |kind, reference: &'static str| Comparison {
            kind,
            reference,
            sample: Some(Sample::new(published_names(reference).any(names))),
            ..blank.clone()
        };
        let mean =
            |published: &PublishedMean| with_mean(row(ReferenceKind::Mean, published.source), published, &modelled);
        rows.extend(subject.means.iter().map(mean));
        let sd_mag = subject.survey_sd_mag();
        let curve = |published: &PublishedCurve| {
            with_curve(row(ReferenceKind::PhaseCurve, published.source), published, sd_mag, &modelled)
        };
        rows.extend(subject.curve.iter().map(curve));
    }
    if let Some(set) = subject.photometry {
        let row = |kind| Comparison {
            kind,
            reference: set.source(),
            sample: Some(Sample::new(names(set.survey()))),
            ..blank.clone()
        };
        let sunlit = photometry.and_then(|photometry| photometry.get(set)).unwrap_or_default();
        rows.push(with_measurements(row(ReferenceKind::Photometry), model, sunlit));
        let grazing = photometry.map_or(&[][..], |photometry| photometry.grazing(set));
        let grazing = with_measurements(row(ReferenceKind::GrazingPhotometry), model, grazing);
        rows.extend((grazing.verdict != Verdict::NoData).then_some(grazing));
    }
    rows
}

/// Returns true if a provenance contains the name of a survey or a publication; case is ignored.
fn is_named(name: &str, provenance: &str) -> bool {
    provenance.to_lowercase().contains(&name.to_lowercase())
}

/// Returns the arXiv numbers in a reference, by which a provenance can name it; for a reference without such a number
/// its text without the note in parentheses.
fn published_names(reference: &'static str) -> impl Iterator<Item = &'static str> {
    let is_number = |word: &&str| word.len() == 10 && word.chars().all(|c| c.is_ascii_digit() || c == '.');
    let numbers = reference.split([' ', ',']).filter(is_number);
    let text = reference.split(" (").next().filter(|_| !reference.contains("arXiv"));
    numbers.chain(text)
}

/// Magnitude of the model in one geometry of the population, with its weight.
struct Modelled {
    magnitude: f64,
    weight: f64,
    phase_rad: f64,
}

/// Returns true if a mean difference is at most [`DIFFERENCE_TOLERANCE`] times its error.
fn is_close(row: &Comparison) -> bool {
    row.difference_mag
        .zip(row.difference_error_mag)
        .is_some_and(|(difference, error)| difference.abs() <= DIFFERENCE_TOLERANCE * error)
}

fn verdict(agrees: bool) -> Verdict {
    if agrees { Verdict::Ok } else { Verdict::Off }
}

fn with_mean(row: Comparison, published: &PublishedMean, modelled: &[Modelled]) -> Comparison {
    let Some(model) = ResidualStatistics::weighted(modelled.iter().map(|point| (point.magnitude, point.weight))) else {
        return row;
    };
    let differences = || modelled.iter().map(|point| (published.mean_mag - point.magnitude, point.weight));
    let row = Comparison {
        n: model.n,
        model_mean_mag: Some(model.mean_mag),
        model_sd_mag: Some(model.sd_mag),
        reference_mean_mag: Some(published.mean_mag),
        reference_sd_mag: published.sd_mag,
        difference_mag: Some(published.mean_mag - model.mean_mag),
        difference_error_mag: Some(SURVEY_ERROR_MAG),
        within_one_sigma: published.sd_mag.and_then(|sd| share_within(differences(), sd)),
        ..row
    };
    Comparison { verdict: verdict(is_close(&row)), ..row }
}

fn with_curve(row: Comparison, curve: &PublishedCurve, sd_mag: f64, modelled: &[Modelled]) -> Comparison {
    let pairs: Vec<Pair> = modelled
        .iter()
        .filter_map(|point| {
            let reference_mag = curve.at(point.phase_rad)?;
            Some(Pair { reference_mag, model_mag: point.magnitude, weight: point.weight })
        })
        .collect();
    let Some((row, _)) = with_pairs(&row, &pairs) else { return row };
    let is_narrow = row.rms_mag.is_some_and(|rms| rms <= sd_mag);
    Comparison { verdict: verdict(is_close(&row) && is_narrow), ..row }
}

fn with_measurements(row: Comparison, model: &BrightnessModel, measured: &[ReferenceMeasurement]) -> Comparison {
    let compared = measured.iter().filter_map(|measurement| {
        let (model_mag, sigma_mag) = (measurement.of_model(model)?.0, measurement.sigma_of_model_mag(model)?);
        Some((Pair { reference_mag: measurement.magnitude.0, model_mag, weight: 1.0 }, sigma_mag, measurement.group))
    });
    let mut pairs = Vec::new();
    let (mut sigmas_mag, mut groups): (Vec<f64>, Vec<u32>) = (Vec::new(), Vec::new());
    for (pair, sigma_mag, group) in compared {
        pairs.push(pair);
        sigmas_mag.push(sigma_mag);
        groups.push(group);
    }
    let weights = group_weights(&groups, GROUP_CORRELATION);
    pairs.iter_mut().zip(&weights).for_each(|(pair, weight)| pair.weight = *weight);
    let Some((row, statistics)) = with_pairs(&row, &pairs) else { return row };
    let sampling_mag = error_of_mean(&pairs, &groups, &statistics);
    let in_sigmas: Vec<(f64, f64)> =
        pairs.iter().zip(&sigmas_mag).map(|(pair, sigma)| (pair.difference_mag() / sigma, pair.weight)).collect();
    let sigma_ratio = weighted_sigma_68_mag(&in_sigmas);
    let rms_sigmas = ResidualStatistics::weighted(in_sigmas.iter().copied()).map_or(f64::NAN, |all| all.rms_mag);
    let row = Comparison {
        difference_error_mag: Some(SURVEY_ERROR_MAG.hypot(sampling_mag)),
        sigma_mag: median(sigmas_mag),
        within_one_sigma: share_within(in_sigmas, 1.0),
        sigma_ratio: Some(sigma_ratio),
        ..row
    };
    let [least, greatest] = SIGMA_RATIOS;
    let has_few_wings = rms_sigmas <= RMS_TOLERANCE_SIGMA;
    let agrees = is_close(&row) && (least..=greatest).contains(&sigma_ratio) && has_few_wings;
    Comparison { verdict: verdict(agrees), ..row }
}

/// Returns the statistical error of the weighted mean of differences, mag, whose groups are independent of one another;
/// for a single group, the spread of the differences.
fn error_of_mean(pairs: &[Pair], groups: &[u32], statistics: &ResidualStatistics) -> f64 {
    let mut sums = BTreeMap::new();
    for (pair, group) in pairs.iter().zip(groups) {
        *sums.entry(group).or_insert(0.0) += pair.weight * (pair.difference_mag() - statistics.mean_mag);
    }
    let count = sums.len() as f64;
    if sums.len() < 2 {
        return statistics.sd_mag;
    }
    let total: f64 = pairs.iter().map(|pair| pair.weight).sum();
    // e² = G/(G - 1) Σ_g (Σ_i w_i (d_i - mean))² / (Σ w)²            Liang and Zeger (1986), Biometrika 73, 13
    (count / (count - 1.0) * sums.values().map(|sum| sum * sum).sum::<f64>()).sqrt() / total
}

/// Magnitudes of a reference and of the model in one geometry, with its weight.
struct Pair {
    reference_mag: f64,
    model_mag: f64,
    weight: f64,
}

impl Pair {
    fn difference_mag(&self) -> f64 {
        self.reference_mag - self.model_mag
    }
}

/// Returns the row with the statistics of pairs of magnitudes, and those of their differences; `None` without pairs.
fn with_pairs(row: &Comparison, pairs: &[Pair]) -> Option<(Comparison, ResidualStatistics)> {
    let of =
        |value: fn(&Pair) -> f64| ResidualStatistics::weighted(pairs.iter().map(|pair| (value(pair), pair.weight)));
    let (reference, model) = (of(|pair| pair.reference_mag)?, of(|pair| pair.model_mag)?);
    let difference = of(Pair::difference_mag)?;
    let differences = pairs.iter().map(|pair| (pair.difference_mag(), pair.weight));
    let row = Comparison {
        n: difference.n,
        model_mean_mag: Some(model.mean_mag),
        model_sd_mag: Some(model.sd_mag),
        reference_mean_mag: Some(reference.mean_mag),
        reference_sd_mag: Some(reference.sd_mag),
        difference_mag: Some(difference.mean_mag),
        difference_error_mag: Some(SURVEY_ERROR_MAG),
        rms_mag: Some(difference.rms_mag),
        core_mag: Some(difference.core_mag),
        within_one_sigma: share_within(differences, row.sigma_mag),
        ..row.clone()
    };
    Some((row, difference))
}

const COLUMNS: [Column; 19] = [
    Column::new("model", Kind::Text, "Name of the model."),
    Column::new("satellites", Kind::Text, "Satellites that the model describes; empty if its name is unknown."),
    Column::new(
        "kind",
        Kind::Text,
        "Kind of reference: mean, phase curve, photometry, grazing (photometry in grazing sunlight), none.",
    ),
    Column::new("reference", Kind::Text, "Publication of the reference."),
    Column::new(
        "sample",
        Kind::Text,
        "in-sample if the provenance of the model names this survey or publication, otherwise held-out.",
    ),
    Column::new("n", Kind::Integer, "Number of geometries or measurements compared."),
    Column::real("model_mean_mag", "mag", 3, "Mean of the model over them, at 1000 km."),
    Column::real("model_sd_mag", "mag", 3, "Standard deviation of the model over them."),
    Column::real("reference_mean_mag", "mag", 3, "Mean of the reference, at 1000 km."),
    Column::real("reference_sd_mag", "mag", 3, "Standard deviation of the reference; empty if none was published."),
    Column::real("difference_mag", "mag", 3, "Mean of reference minus model."),
    Column::real("difference_error_mag", "mag", 3, "Error of the difference: between surveys, and of the mean."),
    Column::real("difference_errors", "", 2, "Difference divided by its error; ok from -2 to 2."),
    Column::real("rms_mag", "mag", 3, "Root mean square of reference minus model; empty against a mean."),
    Column::real("core_mag", "mag", 3, "1.4826 times the median absolute deviation of reference minus model."),
    Column::real("sigma_mag", "mag", 3, "One sigma of a single prediction (median over the measurements)."),
    Column::real(
        "within_one_sigma",
        "",
        3,
        "Fraction within that sigma; against a mean, fraction of the model within its published standard deviation.",
    ),
    Column::real(
        "sigma_ratio",
        "",
        3,
        "Half width with 68.3 % of the differences from measurements, in their sigmas; ok from 0.67 to 1.25.",
    ),
    Column::new("verdict", Kind::Text, "ok, off, or no data."),
];

/// Returns a table with one row per comparison.
pub fn comparison_table(comparisons: &[Comparison]) -> Table {
    let row = |comparison: &Comparison| {
        let is_compared = comparison.model_mean_mag.is_some();
        vec![
            comparison.model.as_str().into(),
            comparison.satellites.into(),
            comparison.kind.name().into(),
            comparison.reference.into(),
            comparison.sample.map(Sample::name).into(),
            is_compared.then_some(comparison.n).into(),
            comparison.model_mean_mag.into(),
            comparison.model_sd_mag.into(),
            comparison.reference_mean_mag.into(),
            comparison.reference_sd_mag.into(),
            comparison.difference_mag.into(),
            comparison.difference_error_mag.into(),
            comparison
                .difference_mag
                .zip(comparison.difference_error_mag)
                .map(|(difference, error)| difference / error)
                .into(),
            comparison.rms_mag.into(),
            comparison.core_mag.into(),
            comparison.sigma_mag.into(),
            comparison.within_one_sigma.into(),
            comparison.sigma_ratio.into(),
            comparison.verdict.name().into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: comparisons.iter().map(row).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_error_of_the_mean_counts_groups() {
        // Four groups of equal differences are four measurements: sd 1.29, error 1.29/√4.
        let values = [1.0, 2.0, 3.0, 4.0];
        let pair = |difference: f64| Pair { reference_mag: difference, model_mag: 0.0, weight: 0.5 };
        let pairs: Vec<Pair> = values.iter().flat_map(|value| [*value; 5]).map(pair).collect();
        let groups: Vec<u32> = (0..4).flat_map(|group| [group; 5]).collect();
        let statistics = ResidualStatistics::weighted(pairs.iter().map(|pair| (pair.difference_mag(), 0.5))).unwrap();
        let expected = (5.0_f64 / 3.0).sqrt() / 2.0;
        assert!((error_of_mean(&pairs, &groups, &statistics) - expected).abs() < 1e-12);
        assert_eq!(error_of_mean(&pairs, &[7; 20], &statistics), statistics.sd_mag);
    }

    #[test]
    fn verif_references_are_found_in_a_provenance() {
        let in_sample = |reference, provenance| published_names(reference).any(|name| is_named(name, provenance));
        let source = "Mallama, arXiv 2210.17268, 2507.00107";
        assert!(in_sample(source, "Mallama (arXiv 2210.17268)") && in_sample(source, "see 2507.00107"));
        assert!(!in_sample(source, "Mallama (arXiv 2006.08422)"));
        let benchmark = "Mallama, benchmark of constellations (raising)";
        assert!(in_sample(benchmark, "mallama, benchmark of constellations") && !in_sample(benchmark, "Mallama"));
    }
}
