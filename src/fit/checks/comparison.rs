//! One model against one reference: the differences and a verdict.

use crate::photometry::BrightnessModel;

use super::photometry::{Photometry, in_v};
use super::population::Population;
use super::published::{PublishedCurve, PublishedMean, Subject};
use super::residuals::{Residuals, share_within};

/// Mean difference from measurements up to which a model is called good, mag: unfiltered AB magnitudes and V (Vega) differ by 0.02 to
/// 0.2 mag for colours like the Sun's, and single surveys of one satellite type by as much again.
pub const OFFSET_TOLERANCE_MAG: f64 = 0.3;

/// Core about measurements up to which a model is called good, in units of the sigma that its file states: sigma
/// holds 68.3 % of single magnitudes, and so does the core where they are normal. A file that states 0.6 where 0.7 is found misleads
/// nobody; one that states half of what is found does.
pub const CORE_TOLERANCE_SIGMA: f64 = 1.15;

/// RMS up to which it is called good, in the same units: flares and wrongly identified satellites make wings, and the RMS larger than
/// the sigma that holds 68.3 %, but beyond twice that sigma most of what is seen is wings.
pub const RMS_TOLERANCE_SIGMA: f64 = 2.0;

/// What a model is compared with.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum ReferenceKind {
    /// A published mean, against the model's mean over [`POPULATION`](super::POPULATION).
    Mean,
    /// A published phase function, over the same geometries within the phases for which it is believed.
    PhaseCurve,
    /// Measured magnitudes, each in its own geometry.
    Photometry,
    /// Nothing is known of these satellites.
    None,
}

impl ReferenceKind {
    /// As tables write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::PhaseCurve => "phase curve",
            Self::Photometry => "photometry",
            Self::None => "none",
        }
    }
}

/// Whether the two agree.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Within the tolerances of [`compare`].
    Ok,
    /// Beyond them.
    Off,
    /// Nothing to compare with.
    NoData,
}

impl Verdict {
    /// As tables write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Off => "off",
            Self::NoData => "no data",
        }
    }
}

/// One model and one reference. Magnitudes are V (Vega) at 1000 km, whatever band the model was made in; differences are reference minus model.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Name of the model.
    pub model: String,
    /// Whose brightness it is; `None` where the model's name tells nothing.
    pub satellites: Option<&'static str>,
    /// What kind of reference.
    pub kind: ReferenceKind,
    /// Where the reference was published; empty for none.
    pub reference: &'static str,
    /// Geometries or measurements compared.
    pub n: usize,
    /// Mean of the model over them, mag.
    pub model_mean_mag: Option<f64>,
    /// Its standard deviation over them, mag.
    pub model_sd_mag: Option<f64>,
    /// Mean of the reference: as published, or over the same geometries or measurements, mag.
    pub reference_mean_mag: Option<f64>,
    /// Its standard deviation, mag.
    pub reference_sd_mag: Option<f64>,
    /// Mean of reference minus model, mag.
    pub difference_mag: Option<f64>,
    /// Root mean square of reference minus model, mag; `None` against a mean.
    pub rms_mag: Option<f64>,
    /// 1.4826 times the median absolute deviation of reference minus model, mag; `None` against a mean.
    pub core_mag: Option<f64>,
    /// Sigma that the model states for a single prediction, mag.
    pub sigma_mag: f64,
    /// Share of reference minus model within that sigma; against a mean, share of the model's magnitudes within the published standard
    /// deviation of the published mean.
    pub within_one_sigma: Option<f64>,
    /// Whether the two agree.
    pub verdict: Verdict,
}

/// Holds a model against all that is known of its satellites, and against measurements where there are any.
///
/// The name of the model, or an alias, says whose it is ([`Subject`]). Against a published mean it is good where the two means differ by no
/// more than the standard deviation of that survey ([`PublishedMean::survey_sd_mag`]): its geometries are not those of the population.
/// Against a published curve, where both the mean and the RMS of what lies between are no more than that: about its own curve the survey
/// scatters as much, and a model that knows more than the phase lies off it too. Against measurements, where the mean differs by no more than
/// [`OFFSET_TOLERANCE_MAG`], the core is no more than [`CORE_TOLERANCE_SIGMA`] and the RMS no more than [`RMS_TOLERANCE_SIGMA`] of the sigma
/// that the model states. At least one row comes back.
pub fn compare(model: &BrightnessModel, photometry: Option<&Photometry>) -> Vec<Comparison> {
    let name = model.file().map(|file| file.name.clone()).unwrap_or_default();
    let sigma_mag = model.file().map_or(f64::NAN, |file| file.sigma_mag);
    let subject = model.file().and_then(Subject::of);
    let against = Against { blank: blank(name, subject.map(|subject| subject.name), sigma_mag) };
    let Some(subject) = subject else { return vec![against.blank] };
    let mut rows = Vec::new();
    if let Some((height_km, inclination_deg)) = subject.shell {
        // Magnitude, weight and phase wherever the model says anything.
        let population = Population::of_shell(height_km, inclination_deg);
        let said: Vec<Said> = population
            .viewed
            .iter()
            .filter_map(|viewed| {
                let magnitude = in_v(model, &viewed.geometry)?.0;
                Some(Said { magnitude, weight: viewed.weight, phase_rad: viewed.geometry.phase_angle_rad() })
            })
            .collect();
        rows.extend(subject.means.iter().map(|published| against.mean(published, &said)));
        rows.extend(subject.curve.iter().map(|curve| against.curve(curve, subject.survey_sd_mag(), &said)));
    }
    if let Some(set) = subject.photometry {
        let measured = photometry.and_then(|photometry| photometry.get(set)).unwrap_or_default();
        let pairs = measured.iter().filter_map(|one| Some((one.magnitude.0, one.of_model(model)?.0, 1.0))).collect();
        let allowed = Allowed {
            mean_mag: OFFSET_TOLERANCE_MAG,
            core_mag: CORE_TOLERANCE_SIGMA * sigma_mag,
            rms_mag: RMS_TOLERANCE_SIGMA * sigma_mag,
        };
        rows.push(against.pairs(ReferenceKind::Photometry, set.source(), allowed, pairs));
    }
    rows
}

fn blank(model: String, satellites: Option<&'static str>, sigma_mag: f64) -> Comparison {
    Comparison {
        model,
        satellites,
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
    }
}

/// What a model says in one geometry of the population.
struct Said {
    magnitude: f64,
    weight: f64,
    phase_rad: f64,
}

/// The most that differences may be where the two agree, mag.
struct Allowed {
    mean_mag: f64,
    core_mag: f64,
    rms_mag: f64,
}

/// Makes rows for one model.
struct Against {
    blank: Comparison,
}

impl Against {
    fn mean(&self, published: &PublishedMean, said: &[Said]) -> Comparison {
        let row = Comparison { kind: ReferenceKind::Mean, reference: published.source, ..self.blank.clone() };
        let Some(model) = Residuals::weighted(said.iter().map(|one| (one.magnitude, one.weight))) else { return row };
        let apart: Vec<_> = said.iter().map(|one| (published.mean_mag - one.magnitude, one.weight)).collect();
        let difference = published.mean_mag - model.mean_mag;
        Comparison {
            n: model.n,
            model_mean_mag: Some(model.mean_mag),
            model_sd_mag: Some(model.scatter_mag),
            reference_mean_mag: Some(published.mean_mag),
            reference_sd_mag: published.sd_mag,
            difference_mag: Some(difference),
            within_one_sigma: published.sd_mag.and_then(|sd| share_within(&apart, sd)),
            verdict: if difference.abs() <= published.survey_sd_mag() { Verdict::Ok } else { Verdict::Off },
            ..row
        }
    }

    fn curve(&self, curve: &PublishedCurve, sd_mag: f64, said: &[Said]) -> Comparison {
        let allowed = Allowed { mean_mag: sd_mag, core_mag: sd_mag, rms_mag: sd_mag };
        let pairs = said.iter().filter_map(|one| Some((curve.at(one.phase_rad)?, one.magnitude, one.weight)));
        self.pairs(ReferenceKind::PhaseCurve, curve.source, allowed, pairs.collect())
    }

    /// From triples of reference, model and weight.
    fn pairs(
        &self,
        kind: ReferenceKind,
        source: &'static str,
        allowed: Allowed,
        pairs: Vec<(f64, f64, f64)>,
    ) -> Comparison {
        let row = Comparison { kind, reference: source, ..self.blank.clone() };
        let apart: Vec<_> = pairs.iter().map(|&(reference, model, weight)| (reference - model, weight)).collect();
        let reference = Residuals::weighted(pairs.iter().map(|&(reference, _, weight)| (reference, weight)));
        let model = Residuals::weighted(pairs.iter().map(|&(_, model, weight)| (model, weight)));
        let (Some(reference), Some(model), Some(difference)) =
            (reference, model, Residuals::weighted(apart.iter().copied()))
        else {
            return row;
        };
        let sigma = row.sigma_mag;
        let is_good = difference.mean_mag.abs() <= allowed.mean_mag
            && difference.core_mag <= allowed.core_mag
            && difference.rms_mag <= allowed.rms_mag;
        Comparison {
            n: difference.n,
            model_mean_mag: Some(model.mean_mag),
            model_sd_mag: Some(model.scatter_mag),
            reference_mean_mag: Some(reference.mean_mag),
            reference_sd_mag: Some(reference.scatter_mag),
            difference_mag: Some(difference.mean_mag),
            rms_mag: Some(difference.rms_mag),
            core_mag: Some(difference.core_mag),
            within_one_sigma: share_within(&apart, sigma),
            verdict: if is_good { Verdict::Ok } else { Verdict::Off },
            ..row
        }
    }
}
