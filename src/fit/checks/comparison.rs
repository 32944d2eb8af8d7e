//! Comparison of one model with one reference: differences and a verdict.

use crate::output::{Column, Kind, Table};
use crate::photometry::BrightnessModel;

use super::super::statistics::{ResidualStatistics, share_within};
use super::photometry::{Photometry, ReferenceMeasurement, in_v};
use super::population::shell_geometries;
use super::published::{PublishedCurve, PublishedMean, Subject};

/// Largest mean difference from measurements with which a model is accepted, mag. Unfiltered AB magnitudes and V (Vega)
/// differ by 0.02 to 0.2 mag for solar colours, and surveys of the same type of satellite differ by as much.
pub const OFFSET_TOLERANCE_MAG: f64 = 0.3;

/// Largest core with which a model is accepted, in units of the sigma in its file. The core is 1.4826 times the median
/// absolute deviation. The stated sigma contains 68.3 % of single magnitudes, as does the core of a normal
/// distribution. A core of 0.7 mag for a stated sigma of 0.6 mag is accepted, twice the stated sigma is not.
const CORE_TOLERANCE_SIGMA: f64 = 1.15;

/// Largest RMS with which a model is accepted, in units of the sigma in its file. Flares and misidentified satellites
/// form wings, which raise the RMS above the sigma that contains 68.3 %. Above twice that sigma the wings dominate.
const RMS_TOLERANCE_SIGMA: f64 = 2.0;

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
    /// Number of geometries or measurements compared.
    pub n: usize,
    /// Mean of the model over these geometries or measurements, mag.
    pub model_mean_mag: Option<f64>,
    /// Standard deviation of the model over these geometries or measurements, mag.
    pub model_sd_mag: Option<f64>,
    /// Mean of the reference, mag: as published, or over the same geometries or measurements.
    pub reference_mean_mag: Option<f64>,
    /// Standard deviation of the reference, mag.
    pub reference_sd_mag: Option<f64>,
    /// Mean of reference minus model, mag.
    pub difference_mag: Option<f64>,
    /// Root mean square of reference minus model, mag; `None` if the reference is a published mean.
    pub rms_mag: Option<f64>,
    /// 1.4826 times the median absolute deviation of reference minus model, mag; `None` if the reference is a published
    /// mean.
    pub core_mag: Option<f64>,
    /// Uncertainty (one sigma) of a single prediction as stated in the model's file, mag.
    pub sigma_mag: f64,
    /// Fraction of the differences that are within that sigma. If the reference is a published mean: fraction of the
    /// model's magnitudes that are within the published standard deviation of it.
    pub within_one_sigma: Option<f64>,
    /// Result of the comparison.
    pub verdict: Verdict,
}

/// Compares a model with every published reference for its satellites, and with measurements if given.
///
/// The model's name or an alias selects the references. The model agrees
///
/// * with a published mean if the two means differ by no more than the standard deviation of the survey, because the
///   geometries of the survey differ from those of the population;
/// * with a published curve if neither the mean nor the RMS of the differences exceeds that standard deviation, because
///   the survey scatters as much about its own curve, and a model that depends on more angles than the phase angle
///   differs from it;
/// * with measurements if the mean difference is no more than [`OFFSET_TOLERANCE_MAG`], the core no more than 1.15
///   times and the RMS no more than 2 times the sigma in the model's file. Measurements in grazing sunlight are
///   compared separately with the same tolerances.
///
/// The result has at least one row.
pub fn compare(model: &BrightnessModel, photometry: Option<&Photometry>) -> Vec<Comparison> {
    let name = model.file().map(|file| file.name.clone()).unwrap_or_default();
    let sigma_mag = model.file().map_or(f64::NAN, |file| file.sigma_mag);
    let subject = model.file().and_then(Subject::of);
    let blank = Comparison {
        model: name,
        satellites: subject.map(|subject| subject.name),
        kind: ReferenceKind::None,
        reference: "",
        n: 0,
        model_mean_mag: None,
        model_sd_mag: None,
        reference_mean_mag: None,
        reference_sd_mag: None,
        difference_mag: None,
        rms_mag: None,
        core_mag: None,
        sigma_mag,
        within_one_sigma: None,
        verdict: Verdict::NoData,
    };
    let Some(subject) = subject else { return vec![blank] };
    let mut rows = Vec::new();
    if let Some((height_km, inclination_deg)) = subject.shell {
        let modelled: Vec<Modelled> = shell_geometries(height_km, inclination_deg)
            .iter()
            .filter_map(|(geometry, weight)| {
                let magnitude = in_v(model, geometry)?.0;
                Some(Modelled { magnitude, weight: *weight, phase_rad: geometry.phase_angle_rad() })
            })
            .collect();
        rows.extend(subject.means.iter().map(|published| with_mean(&blank, published, &modelled)));
        rows.extend(subject.curve.iter().map(|curve| with_curve(&blank, curve, subject.survey_sd_mag(), &modelled)));
    }
    if let Some(set) = subject.photometry {
        let tolerances = Tolerances {
            mean_mag: OFFSET_TOLERANCE_MAG,
            core_mag: CORE_TOLERANCE_SIGMA * sigma_mag,
            rms_mag: RMS_TOLERANCE_SIGMA * sigma_mag,
        };
        let pairs = |measured: &[ReferenceMeasurement]| {
            measured.iter().filter_map(|one| Some((one.magnitude.0, one.of_model(model)?.0, 1.0))).collect::<Vec<_>>()
        };
        let sunlit = photometry.and_then(|photometry| photometry.get(set)).unwrap_or_default();
        let grazing = pairs(photometry.map_or(&[], |photometry| photometry.grazing(set)));
        let row = Comparison { kind: ReferenceKind::Photometry, reference: set.source(), ..blank };
        let grazing = (!grazing.is_empty()).then(|| {
            with_pairs(Comparison { kind: ReferenceKind::GrazingPhotometry, ..row.clone() }, &tolerances, grazing)
        });
        rows.push(with_pairs(row, &tolerances, pairs(sunlit)));
        rows.extend(grazing);
    }
    rows
}

/// Magnitude of the model in one geometry of the population, with its weight.
struct Modelled {
    magnitude: f64,
    weight: f64,
    phase_rad: f64,
}

/// Largest differences for which model and reference agree, mag.
struct Tolerances {
    mean_mag: f64,
    core_mag: f64,
    rms_mag: f64,
}

fn with_mean(blank: &Comparison, published: &PublishedMean, modelled: &[Modelled]) -> Comparison {
    let row = Comparison { kind: ReferenceKind::Mean, reference: published.source, ..blank.clone() };
    let Some(model) = ResidualStatistics::weighted(modelled.iter().map(|one| (one.magnitude, one.weight))) else {
        return row;
    };
    let differences = || modelled.iter().map(|one| (published.mean_mag - one.magnitude, one.weight));
    let difference = published.mean_mag - model.mean_mag;
    Comparison {
        n: model.n,
        model_mean_mag: Some(model.mean_mag),
        model_sd_mag: Some(model.sd_mag),
        reference_mean_mag: Some(published.mean_mag),
        reference_sd_mag: published.sd_mag,
        difference_mag: Some(difference),
        within_one_sigma: published.sd_mag.and_then(|sd| share_within(differences(), sd)),
        verdict: if difference.abs() <= published.survey_sd_mag() { Verdict::Ok } else { Verdict::Off },
        ..row
    }
}

fn with_curve(blank: &Comparison, curve: &PublishedCurve, sd_mag: f64, modelled: &[Modelled]) -> Comparison {
    let tolerances = Tolerances { mean_mag: sd_mag, core_mag: sd_mag, rms_mag: sd_mag };
    let pairs = modelled.iter().filter_map(|one| Some((curve.at(one.phase_rad)?, one.magnitude, one.weight)));
    let row = Comparison { kind: ReferenceKind::PhaseCurve, reference: curve.source, ..blank.clone() };
    with_pairs(row, &tolerances, pairs.collect())
}

/// Completes a row from triples of a reference magnitude, a model magnitude and a weight.
fn with_pairs(row: Comparison, tolerances: &Tolerances, pairs: Vec<(f64, f64, f64)>) -> Comparison {
    let differences = || pairs.iter().map(|&(reference, model, weight)| (reference - model, weight));
    let reference = ResidualStatistics::weighted(pairs.iter().map(|&(reference, _, weight)| (reference, weight)));
    let model = ResidualStatistics::weighted(pairs.iter().map(|&(_, model, weight)| (model, weight)));
    let (Some(reference), Some(model), Some(difference)) =
        (reference, model, ResidualStatistics::weighted(differences()))
    else {
        return row;
    };
    let is_good = difference.mean_mag.abs() <= tolerances.mean_mag
        && difference.core_mag <= tolerances.core_mag
        && difference.rms_mag <= tolerances.rms_mag;
    Comparison {
        n: difference.n,
        model_mean_mag: Some(model.mean_mag),
        model_sd_mag: Some(model.sd_mag),
        reference_mean_mag: Some(reference.mean_mag),
        reference_sd_mag: Some(reference.sd_mag),
        difference_mag: Some(difference.mean_mag),
        rms_mag: Some(difference.rms_mag),
        core_mag: Some(difference.core_mag),
        within_one_sigma: share_within(differences(), row.sigma_mag),
        verdict: if is_good { Verdict::Ok } else { Verdict::Off },
        ..row
    }
}

const COLUMNS: [Column; 15] = [
    Column::new("model", Kind::Text, "Name of the model."),
    Column::new("satellites", Kind::Text, "Satellites that the model describes; empty if its name is unknown."),
    Column::new(
        "kind",
        Kind::Text,
        "Kind of reference: mean, phase curve, photometry, grazing (photometry in grazing sunlight), none.",
    ),
    Column::new("reference", Kind::Text, "Publication of the reference."),
    Column::new("n", Kind::Integer, "Number of geometries or measurements compared."),
    Column::real("model_mean_mag", "mag", 3, "Mean of the model over them, at 1000 km."),
    Column::real("model_sd_mag", "mag", 3, "Standard deviation of the model over them."),
    Column::real("reference_mean_mag", "mag", 3, "Mean of the reference, at 1000 km."),
    Column::real("reference_sd_mag", "mag", 3, "Standard deviation of the reference; empty if none was published."),
    Column::real("difference_mag", "mag", 3, "Mean of reference minus model."),
    Column::real("rms_mag", "mag", 3, "Root mean square of reference minus model; empty against a mean."),
    Column::real("core_mag", "mag", 3, "1.4826 times the median absolute deviation of reference minus model."),
    Column::real("sigma_mag", "mag", 3, "One sigma of a single prediction, from the model's file."),
    Column::real(
        "within_one_sigma",
        "",
        3,
        "Fraction within that sigma; against a mean, fraction of the model within its published standard deviation.",
    ),
    Column::new("verdict", Kind::Text, "ok, off, or no data."),
];

/// Returns a table with one row per comparison.
pub fn comparison_table(comparisons: &[Comparison]) -> Table {
    let row = |one: &Comparison| {
        let is_compared = one.model_mean_mag.is_some();
        vec![
            one.model.as_str().into(),
            one.satellites.into(),
            one.kind.name().into(),
            one.reference.into(),
            is_compared.then_some(one.n).into(),
            one.model_mean_mag.into(),
            one.model_sd_mag.into(),
            one.reference_mean_mag.into(),
            one.reference_sd_mag.into(),
            one.difference_mag.into(),
            one.rms_mag.into(),
            one.core_mag.into(),
            one.sigma_mag.into(),
            one.within_one_sigma.into(),
            one.verdict.name().into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: comparisons.iter().map(row).collect() }
}
