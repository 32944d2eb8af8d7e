//! The default models have the best score of all bundled candidates on held-out tracks, nights or degrees of the Sun's
//! altitude.
//!
//! Models fitted for this project are fitted again to four fifths of the groups and predict the remaining fifth.
//! Published models were made from other measurements, so that all points are held-out for them. The quadratic in the
//! phase angle, fitted to the same folds, shows whether the additional parameters of panels improve the prediction.
//!
//! The log score is the mean logarithm of the probability density of the residuals, mag⁻¹. The density is a sum of two
//! normal distributions of mean zero, a core and wings, fitted to the residuals of the other folds.
//!
//! Of large surveys every n-th point is used.
//!
//! Requires the data folder; skipped with a message without it.

use std::fmt::Write;
use std::path::Path;

use streakcast::elements::Generation;
use streakcast::fit::checks::compare;
use streakcast::fit::measurements::{
    Format, Measurements, PhotometryOptions, Placement, RecordReader, Selection, measure,
};
use streakcast::fit::{
    FitPoint, FitSettings, Form, Loss, PanelsForm, PhaseForm, Problem, RawWeights, TwoPanelForm,
    points_of_measurements, predict, rms,
};
use streakcast::passes::ModelChoice;
use streakcast::photometry::{BrightnessModel, Earthshine, ModelKind, ModelLibrary};

use crate::common::{assert_is_documented, thin};

const FOLDS: usize = 5;

/// Residuals of the points for which a candidate predicts a magnitude, each with its fold.
type Residuals = Vec<(f64, usize)>;

/// Survey of satellites of one generation.
struct Survey {
    kind: Generation,
    path: &'static str,
    format: Format,
    height_km: Option<f64>,
    /// Bundled models of this generation.
    candidates: &'static [Candidate],
}

/// Bundled model with the settings of the fit that produced it (docs/explanation/models.md).
struct Candidate {
    model: &'static str,
    held: &'static [(&'static str, f64)],
    loss: Loss,
}

const fn candidate(model: &'static str, held: &'static [(&'static str, f64)], loss: Loss) -> Candidate {
    Candidate { model, held, loss }
}

const SURVEYS: [Survey; 5] = [
    Survey {
        kind: Generation::StarlinkV15,
        path: "photometry/pomenis/pomenis_observations.csv",
        format: Format::Pomenis,
        height_km: None,
        candidates: &[
            candidate("starlink-v1.5-facets", &[], Loss::Squares),
            candidate("starlink-v1.5", &[("c1", 0.0), ("n_sail", 5.0)], Loss::Squares),
            candidate("starlink-v1.5-phase", &[], Loss::Squares),
        ],
    },
    Survey {
        kind: Generation::StarlinkV2Mini,
        path: "photometry/slingshot_v2/Observations_in_field.csv",
        format: Format::Slingshot,
        height_km: None,
        candidates: &[
            candidate("v2mini-panels", &[("n_straight", 18.0)], Loss::SoftL1),
            candidate("v2mini", &[], Loss::Squares),
        ],
    },
    Survey {
        kind: Generation::StarlinkVisorSat,
        path: "derived/mmt9_starlink_visorsat.csv.gz",
        format: Format::Mmt,
        height_km: Some(540.0),
        candidates: &[
            candidate("visorsat-panels", &[("n_sail", 1.0)], Loss::Squares),
            candidate("visorsat", &[], Loss::Squares),
        ],
    },
    Survey {
        kind: Generation::OneWeb,
        path: "derived/mmt9_oneweb.csv.gz",
        format: Format::Mmt,
        height_km: Some(1200.0),
        candidates: &[
            candidate("oneweb-panels", &[("sail_diffuse", 0.0), ("n_straight", 1.6)], Loss::Squares),
            candidate("oneweb", &[], Loss::Squares),
        ],
    },
    Survey {
        kind: Generation::IridiumNext,
        path: "derived/mmt9_iridium2.csv.gz",
        format: Format::Mmt,
        height_km: Some(780.0),
        candidates: &[candidate("iridium-next", &[], Loss::Squares)],
    },
];

#[test]
fn valid_default_models_have_the_best_score_on_unseen_points() {
    let Some(data) = crate::common::data_dir() else { return };
    let (library, defaults) = (ModelLibrary::embedded(), ModelChoice::default());
    let mut table = "| kind | points | model | log score | RMS, mag |\n|---|---|---|---|---|\n".to_owned();
    for survey in &SURVEYS {
        let points = survey.points(&data);
        let folds = folds(&points);
        let default = defaults.of_kind(survey.kind).and_then(|model| Some(model.file()?.name.clone())).unwrap();
        let of_candidate = |candidate: &Candidate| {
            (
                candidate.model,
                score(&unseen_of_model(&library.get(candidate.model).unwrap(), candidate, &points, &folds)),
            )
        };
        let mut scores: Vec<(&str, [f64; 2])> = survey.candidates.iter().map(of_candidate).collect();
        let quadratic = FitSettings::free(&["a0", "a1", "a2"]);
        let quadratic = score(&unseen_of_form(&PhaseForm { degree: 2 }, &quadratic, &points, &folds));
        scores.push(("quadratic in phase", quadratic));
        let best_log = scores.iter().max_by(|a, b| a.1[0].total_cmp(&b.1[0])).unwrap();
        let best_rms = scores.iter().min_by(|a, b| a.1[1].total_cmp(&b.1[1])).unwrap();
        assert_eq!((best_log.0, best_rms.0), (default.as_str(), default.as_str()), "{}: {scores:?}", survey.kind);
        for (index, (name, [log_score, rms_mag])) in scores.iter().enumerate() {
            let of_survey = if index == 0 { format!("{} | {}", survey.kind, points.len()) } else { "|".to_owned() };
            let name = if *name == default { format!("**{name}**") } else { (*name).to_owned() };
            writeln!(table, "| {of_survey} | {name} | {log_score:.3} | {rms_mag:.3} |").unwrap();
        }
        // Every bundled model of these satellites is a candidate.
        let satellites = |name: &str| compare(&library.get(name).unwrap(), None)[0].satellites.unwrap();
        let mut candidates: Vec<&str> = survey.candidates.iter().map(|one| one.model).collect();
        candidates.sort_unstable();
        let of_kind: Vec<&str> = library.names().filter(|name| satellites(name) == satellites(&default)).collect();
        assert_eq!(of_kind, candidates, "{}", survey.kind);
    }
    assert_is_documented("default-models.md", &table);
}

impl Survey {
    fn points(&self, data: &Path) -> Vec<FitPoint> {
        let options = PhotometryOptions { format: Some(self.format), ..PhotometryOptions::default() };
        let mut reader = RecordReader::open(&[data.join(self.path)], &options).unwrap();
        let mut measured: Measurements =
            measure(&mut reader, &Placement::recorded(self.height_km), &Selection::default()).unwrap();
        thin(&mut measured);
        points_of_measurements(&measured, &RawWeights::default())
    }
}

/// Returns the fold of each point; all points of a group have the same fold.
fn folds(points: &[FitPoint]) -> Vec<usize> {
    let mut groups: Vec<u32> = points.iter().map(|point| point.group).collect();
    groups.sort_unstable();
    groups.dedup();
    assert!(groups.len() >= 3 * FOLDS, "{} groups", groups.len());
    points.iter().map(|point| groups.partition_point(|&other| other < point.group) % FOLDS).collect()
}

fn unseen_of_model(model: &BrightnessModel, candidate: &Candidate, points: &[FitPoint], folds: &[usize]) -> Residuals {
    let file = model.file().unwrap();
    let (band, system) = model.band();
    let (earthshine, sun_magnitude) = (Earthshine::Computed, band.sun_magnitude(system));
    let form: Box<dyn Form> = match (file.kind, &file.panels, file.shape.zip(file.coefficients)) {
        (ModelKind::Panels, Some(spec), _) => Box::new(PanelsForm { spec: spec.clone(), earthshine, sun_magnitude }),
        (ModelKind::TwoPanel, _, Some((shape, coefficients))) => {
            Box::new(TwoPanelForm { shape, coefficients, earthshine, blocking: true, sun_magnitude })
        }
        _ => {
            let residual = |point: &FitPoint| point.magnitude - model.standard_magnitude(&point.geometry).unwrap().0;
            return points.iter().map(residual).zip(folds.iter().copied()).collect();
        }
    };
    let held: Vec<(String, f64)> = candidate.held.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let parameters = form.parameters().into_iter().map(|parameter| parameter.name);
    // The angle between chassis and sail is not fitted.
    let is_free = |name: &String| name != "panel_offset_deg" && held.iter().all(|(other, _)| other != name);
    let free = parameters.filter(is_free).collect();
    unseen_of_form(&*form, &FitSettings { free, held, loss: candidate.loss, ..FitSettings::default() }, points, folds)
}

/// Returns the residuals of each fold from the fit to the others, for points for which the form gives a magnitude.
fn unseen_of_form(form: &dyn Form, settings: &FitSettings, points: &[FitPoint], folds: &[usize]) -> Residuals {
    let mut unseen = Vec::new();
    for fold in 0..FOLDS {
        let side = |held: bool| -> Vec<FitPoint> {
            points.iter().zip(folds).filter(|(_, of)| (**of == fold) == held).map(|(point, _)| *point).collect()
        };
        let (fitted, predicted) = (side(false), side(true));
        let fit = Problem::new(form, &fitted, settings).unwrap().solve().unwrap();
        let magnitudes = predict(form, &predicted, &fit.values());
        unseen.extend(predicted.iter().zip(magnitudes).map(|(point, magnitude)| (point.magnitude - magnitude, fold)));
    }
    assert!(unseen.iter().all(|(residual, _)| residual.is_finite()), "a point that {} does not explain", form.name());
    unseen
}

/// Returns log score, mag⁻¹, and RMS, mag.
fn score(unseen: &Residuals) -> [f64; 2] {
    let all: Vec<f64> = unseen.iter().map(|(residual, _)| *residual).collect();
    let mut sum = 0.0;
    for fold in 0..FOLDS {
        let side = |same: bool| -> Vec<f64> {
            unseen.iter().filter(|(_, of)| (*of == fold) == same).map(|(residual, _)| *residual).collect()
        };
        let distribution = CoreAndWings::fitted(&side(false));
        sum += side(true).iter().map(|residual| distribution.density_per_mag(*residual).ln()).sum::<f64>();
    }
    [sum / all.len() as f64, rms(&all)]
}

/// Sum of two normal distributions of mean zero.
#[derive(Copy, Clone)]
struct CoreAndWings {
    sigma_mag: [f64; 2],
    share: [f64; 2],
}

impl CoreAndWings {
    /// Fits the distribution by maximum likelihood (expectation maximisation).
    fn fitted(residuals_mag: &[f64]) -> Self {
        let whole = rms(residuals_mag);
        let mut now = Self { sigma_mag: [0.6 * whole, 1.8 * whole], share: [0.8, 0.2] };
        for _ in 0..200 {
            let mut sums = [[0.0_f64; 2]; 2];
            for residual in residuals_mag {
                let all = now.density_per_mag(*residual);
                for (part, sums) in sums.iter_mut().enumerate() {
                    let weight = now.part_per_mag(part, *residual) / all;
                    sums[0] += weight;
                    sums[1] += weight * residual * residual;
                }
            }
            now.share = sums.map(|[weight, _]| weight / residuals_mag.len() as f64);
            // The sigmas are at least the measurement errors of the surveys.
            now.sigma_mag = sums.map(|[weight, square]| (square / weight).sqrt().max(0.05));
        }
        now
    }

    fn part_per_mag(&self, part: usize, residual_mag: f64) -> f64 {
        let sigma = self.sigma_mag[part];
        // s e^(-r²/2σ²) / (σ √2π)
        self.share[part] * (-0.5 * (residual_mag / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt())
    }

    fn density_per_mag(&self, residual_mag: f64) -> f64 {
        self.part_per_mag(0, residual_mag) + self.part_per_mag(1, residual_mag)
    }
}
