//! Surveys of satellites with brightness models, held-out residuals by group (night, track, pass), and their
//! statistics.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Mutex;

use streakcast::elements::Generation;
use streakcast::fit::checks::DataSet;
use streakcast::fit::measurements::{Measurements, PhotometryOptions, Placement, RecordReader, Selection, measure};
use streakcast::fit::{
    CompetingForm, FitPoint, FitSettings, Form, HeldOutPoint, Loss, PanelsForm, RawWeights, TwoPanelForm,
    compare_forms, median_mag, points_of_measurements, weigh_groups, weighted_sigma_68_mag,
};
use streakcast::photometry::{Band, BrightnessModel, Earthshine, ErrorDistribution, MagSystem, ModelLibrary};

/// Number of folds, by night, track or pass.
pub const FOLDS: usize = 10;

/// Survey of satellites of one generation. The first of its models is the default.
pub struct Survey {
    pub kind: Generation,
    pub set: DataSet,
    /// Height of circular orbits for measurements without height, km.
    pub height_km: Option<f64>,
    pub models: &'static [Candidate],
}

/// Bundled model, and the parameters that are held in its fit to the survey (docs/explanation/models.md). `None` for a
/// published model, which is not fitted again.
pub struct Candidate {
    pub name: &'static str,
    pub held: Option<&'static [(&'static str, f64)]>,
}

const fn fitted(name: &'static str, held: &'static [(&'static str, f64)]) -> Candidate {
    Candidate { name, held: Some(held) }
}

const fn published(name: &'static str) -> Candidate {
    Candidate { name, held: None }
}

pub const SURVEYS: [Survey; 5] = [
    Survey {
        kind: Generation::StarlinkV15,
        set: DataSet::Pomenis,
        height_km: None,
        models: &[
            fitted("starlink-v1.5-facets", &[]),
            fitted("starlink-v1.5", &[("c1", 0.0), ("n_sail", 5.0)]),
            published("starlink-v1.5-phase"),
        ],
    },
    Survey {
        kind: Generation::StarlinkV2Mini,
        set: DataSet::SlingshotV2,
        height_km: None,
        models: &[fitted("v2mini-panels", &[("n_straight", 18.0)]), published("v2mini")],
    },
    Survey {
        kind: Generation::StarlinkVisorSat,
        set: DataSet::Mmt9VisorSat,
        height_km: Some(540.0),
        models: &[fitted("visorsat-panels", &[("n_sail", 1.0)]), published("visorsat")],
    },
    Survey {
        kind: Generation::OneWeb,
        set: DataSet::Mmt9OneWeb,
        height_km: Some(1200.0),
        models: &[fitted("oneweb-panels", &[("sail_diffuse", 0.0), ("n_straight", 1.6)]), published("oneweb")],
    },
    Survey {
        kind: Generation::IridiumNext,
        set: DataSet::Mmt9IridiumNext,
        height_km: Some(780.0),
        models: &[fitted("iridium-next", &[])],
    },
];

/// Form, free and held parameters of the fit of a model.
pub struct Recipe {
    pub form: Box<dyn Form>,
    pub settings: FitSettings,
}

impl Recipe {
    pub fn of(model: &BrightnessModel, held: &[(&str, f64)]) -> Self {
        let file = model.file().unwrap();
        let (band, system) = model.band();
        let (sun_magnitude, earthshine) = (band.sun_magnitude(system), Earthshine::Computed);
        let form: Box<dyn Form> = match (file.shape.zip(file.coefficients), &file.panels) {
            (Some((shape, coefficients)), _) => {
                Box::new(TwoPanelForm { shape, coefficients, earthshine, blocking: true, sun_magnitude })
            }
            (_, Some(spec)) => Box::new(PanelsForm { spec: spec.clone(), earthshine, sun_magnitude }),
            _ => panic!("{} has no parameters", file.name),
        };
        // The angle between chassis and solar array is not fitted.
        let is_free = |name: &String| name != "panel_offset_deg" && held.iter().all(|(held, _)| held != name);
        let free = form.parameters().into_iter().map(|one| one.name).filter(is_free).collect();
        let held = held.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        Self { form, settings: FitSettings { free, held, loss: Loss::SoftL1, ..FitSettings::default() } }
    }
}

impl Survey {
    pub fn recipe(&self, candidate: &Candidate) -> Option<Recipe> {
        let model = ModelLibrary::embedded().get(candidate.name).unwrap();
        Some(Recipe::of(&model, candidate.held?))
    }

    /// Returns the points with the weights of their groups. Of large surveys every n-th point is used.
    pub fn points(&self, data: &Path) -> Vec<FitPoint> {
        static KNOWN: Mutex<BTreeMap<&str, Vec<FitPoint>>> = Mutex::new(BTreeMap::new());
        let mut known = KNOWN.lock().unwrap();
        let read = || {
            let mut measured = self.measurements(data);
            thin(&mut measured);
            self.weighed(&measured)
        };
        known.entry(self.models[0].name).or_insert_with(read).clone()
    }

    /// Returns the name of the groups.
    pub fn group_name(&self) -> &'static str {
        match self.set {
            DataSet::Pomenis => "nights",
            DataSet::SlingshotV2 => "passes",
            _ => "tracks",
        }
    }

    pub fn measurements(&self, data: &Path) -> Measurements {
        let mut reader = RecordReader::open(&[data.join(self.set.path())], &PhotometryOptions::default()).unwrap();
        measure(&mut reader, &Placement::recorded(self.height_km), &Selection::default()).unwrap()
    }

    /// Returns the points with the weights of their groups, by the residuals of the default model.
    pub fn weighed(&self, measured: &Measurements) -> Vec<FitPoint> {
        let mut points = points_of_measurements(measured, &RawWeights::default());
        let default = self.recipe(&self.models[0]).unwrap();
        let correlation = weigh_groups(&*default.form, &mut points, &default.settings).unwrap();
        println!("{}: correlation within groups {correlation:.2}", self.kind);
        points
    }

    /// Returns held-out points of a model; several tests use them. Fitted models are fitted again without the fold that
    /// they predict.
    pub fn held_out(&self, candidate: &Candidate, points: &[FitPoint]) -> Vec<HeldOutPoint> {
        static KNOWN: Mutex<BTreeMap<&str, Vec<HeldOutPoint>>> = Mutex::new(BTreeMap::new());
        let mut known = KNOWN.lock().unwrap();
        known.entry(candidate.name).or_insert_with(|| self.predicted(candidate, points)).clone()
    }

    fn predicted(&self, candidate: &Candidate, points: &[FitPoint]) -> Vec<HeldOutPoint> {
        match self.recipe(candidate) {
            Some(Recipe { form, settings }) => held_out_of_form(candidate.name, form, &settings, points),
            None => {
                let model = ModelLibrary::embedded().get(candidate.name).unwrap();
                let colour_mag = model.colour_to_mag(Band::V, MagSystem::Vega);
                let folds = folds(points);
                let point = |(one, fold): (&FitPoint, usize)| HeldOutPoint {
                    observed_mag: one.magnitude,
                    predicted_mag: model.standard_magnitude_with(&one.geometry, Earthshine::Computed).unwrap().0
                        + colour_mag,
                    fold,
                    weight: one.weight,
                    group: one.group,
                };
                points.iter().zip(folds).map(point).collect()
            }
        }
    }
}

pub fn held_out_of_form(
    name: &str,
    form: Box<dyn Form>,
    settings: &FitSettings,
    points: &[FitPoint],
) -> Vec<HeldOutPoint> {
    let own = CompetingForm { name: name.to_owned(), form, free: settings.free.clone() };
    compare_forms(&[own], points, None, settings, FOLDS).unwrap().remove(0).held_out_points
}

/// Returns the fold of each point; all points of a group have the same fold.
fn folds(points: &[FitPoint]) -> Vec<usize> {
    let mut groups: Vec<u32> = points.iter().map(|point| point.group).collect();
    groups.sort_unstable();
    groups.dedup();
    points.iter().map(|point| groups.partition_point(|&other| other < point.group) % FOLDS).collect()
}

/// Returns the points in the order in which `compare_forms` returns held-out points: by fold. All of them must be
/// explained by the forms that are compared.
pub fn in_order_of_held_out(points: &[FitPoint]) -> Vec<FitPoint> {
    let folds = folds(points);
    let of_fold = |fold: usize| points.iter().zip(&folds).filter(move |(_, of)| **of == fold).map(|(point, _)| *point);
    (0..FOLDS).flat_map(of_fold).collect()
}

/// Value of one held-out point, with its weight and group.
#[derive(Copy, Clone)]
pub struct Weighted {
    pub value: f64,
    pub weight: f64,
    pub group: u32,
}

/// Weighted mean with its error, whose groups are independent of one another.
#[derive(Copy, Clone, Debug)]
pub struct GroupMean {
    pub mean: f64,
    pub error: f64,
}

impl GroupMean {
    pub fn of(values: impl IntoIterator<Item = Weighted>) -> Self {
        let values: Vec<Weighted> = values.into_iter().collect();
        let total: f64 = values.iter().map(|one| one.weight).sum();
        let mean = values.iter().map(|one| one.weight * one.value).sum::<f64>() / total;
        let mut sums = BTreeMap::<u32, f64>::new();
        for one in &values {
            *sums.entry(one.group).or_default() += one.weight * (one.value - mean);
        }
        let groups = sums.len() as f64;
        // e² = G/(G - 1) Σ_g (Σ_i w_i (v_i - mean))² / (Σ w)²
        let error = (groups / (groups - 1.0) * sums.values().map(|sum| sum * sum).sum::<f64>()).sqrt() / total;
        Self { mean, error }
    }

    /// Returns true if the mean of values 0 and 1 is within two errors of a share. The error of a mean near 0 or 1 is
    /// underestimated; it is scaled to that of the share, as in the interval of Wilson (1927, JASA 22, 209).
    pub fn is_share(&self, share: f64) -> bool {
        let error = self.error * (share * (1.0 - share) / (self.mean * (1.0 - self.mean))).sqrt();
        (self.mean - share).abs() <= 2.0 * error
    }

    /// Returns true if the mean is within two errors of a value.
    pub fn is(&self, expected: f64) -> bool {
        (self.mean - expected).abs() <= 2.0 * self.error
    }
}

/// Returns the mean of a quantity of the held-out points.
pub fn mean_of(points: &[HeldOutPoint], value: impl Fn(&HeldOutPoint) -> f64) -> GroupMean {
    GroupMean::of(points.iter().map(|one| Weighted { value: value(one), weight: one.weight, group: one.group }))
}

/// Returns the median of the residuals, and the half width about it that contains 68.3 %, mag.
pub fn median_and_sigma_mag<'a>(points: impl Iterator<Item = &'a HeldOutPoint>) -> [f64; 2] {
    let residuals: Vec<(f64, f64)> = points.map(HeldOutPoint::weighted_residual).collect();
    let median = median_mag(&residuals);
    let about: Vec<(f64, f64)> = residuals.iter().map(|(residual, weight)| (residual - median, *weight)).collect();
    [median, weighted_sigma_68_mag(&about)]
}

/// Returns the probability density at `x` sigmas, times sigma.
pub fn density(shape: &ErrorDistribution, x: f64) -> f64 {
    let part = |(share, centre, width): (f64, f64, f64)| {
        share * (-0.5 * ((x - centre) / width).powi(2)).exp() / (width * TAU.sqrt())
    };
    shape.parts.iter().map(|one| part((one.share, one.centre, one.width))).sum()
}

/// Returns the logarithm of the probability density of a residual, mag⁻¹.
pub fn log_density(shape: &ErrorDistribution, residual_mag: f64, sigma_mag: f64) -> f64 {
    (density(shape, residual_mag / sigma_mag) / sigma_mag).ln()
}

/// Keeps every n-th measurement of a survey, so that at most 12,000 remain. Tracks are sampled at 10 Hz, so successive
/// measurements differ little.
fn thin(measured: &mut Measurements) {
    const MOST: usize = 12_000;
    let step = measured.points.len().div_ceil(MOST);
    measured.points = std::mem::take(&mut measured.points).into_iter().step_by(step).collect();
}
