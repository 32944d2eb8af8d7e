//! Distribution of single magnitudes about the bundled models on held-out points: values in the model files, and
//! reliability of the probability of being brighter than a limit.
//!
//! `cargo test --test fitting -- --ignored write_error_distributions` fits the distributions of all models again,
//! writes them into the files of `src/photometry/models` and (the default) into `src/photometry/error_distribution.rs`,
//! and writes the tables `TABLES` in `docs/tables`. `docs/brightness.py` draws the figure.
//!
//! Requires the data folder; skipped with a message without it.

use std::path::Path;

use streakcast::fit::checks::{DataSet, Photometry};
use streakcast::fit::measurements::{Measurements, PhotometryOptions, Placement, RecordReader, Selection, measure};
use streakcast::fit::{
    CompetingForm, FitSettings, Form, HeldOutPoint, Loss, PanelsForm, RawWeights, TwoPanelForm, compare_forms,
    error_distribution, points_of_measurements,
};
use streakcast::math::quantile::quantile;
use streakcast::photometry::{
    Band, BrightnessModel, Earthshine, ErrorDistribution, MagSystem, ModelKind, ModelLibrary, PANEL_OFFSET,
};

/// Tables in `docs/tables`: probabilities by tenth; distribution of each model; largest difference of probabilities of
/// each model.
const TABLES: [&str; 3] = ["brightness", "brightness-distributions", "brightness-models"];
/// Number of folds, by track, night or degree of the Sun's altitude.
const FOLDS: usize = 5;
/// Magnitude limits at 1000 km for which probabilities are compared, in quarters of a magnitude: 3 to 10 mag.
const LIMITS: std::ops::RangeInclusive<i32> = 12..=40;
/// Number of evenly spaced quantiles of the residuals that represent a model in the distribution of all models
/// together.
const QUANTILES: usize = 1000;
/// Largest difference between stated probability and observed fraction in any tenth, for all models together.
const POOLED_TOLERANCE: f64 = 0.05;
/// Largest difference between a parameter in a model file and its fit here, in sigmas or as a fraction.
const FILE_TOLERANCE: f64 = 0.03;

/// Loss function and fixed parameters of the fits of docs/explanation/models.md.
type FitOf = (Loss, &'static [(&'static str, f64)]);

/// Models with measurements; height of circular orbits for measurements without height, km; and the settings of a fit
/// to the same measurements: such a model is fitted again without the fold that it predicts.
const MODELS: [(&str, DataSet, Option<f64>, Option<FitOf>); 12] = [
    ("starlink-v1.5", DataSet::Pomenis, None, Some((Loss::Squares, &[("c1", 0.0), ("n_sail", 5.0)]))),
    ("starlink-v1.5-facets", DataSet::Pomenis, None, Some((Loss::Squares, &[]))),
    ("starlink-v1.5-phase", DataSet::Pomenis, None, None),
    ("v2mini-panels", DataSet::SlingshotV2, None, Some((Loss::SoftL1, &[("n_straight", 18.0)]))),
    ("v2mini", DataSet::SlingshotV2, None, None),
    ("visorsat-panels", DataSet::Mmt9VisorSat, Some(540.0), Some((Loss::Squares, &[("n_sail", 1.0)]))),
    ("visorsat", DataSet::Mmt9VisorSat, Some(540.0), None),
    (
        "oneweb-panels",
        DataSet::Mmt9OneWeb,
        Some(1200.0),
        Some((Loss::Squares, &[("sail_diffuse", 0.0), ("n_straight", 1.6)])),
    ),
    ("oneweb", DataSet::Mmt9OneWeb, Some(1200.0), None),
    ("iridium-next", DataSet::Mmt9IridiumNext, Some(780.0), Some((Loss::Squares, &[]))),
    ("unknown", DataSet::AmateursPayloads, None, None),
    ("rocket-body", DataSet::AmateursRocketBodies, None, None),
];

/// Held-out points of one model.
struct HeldOut {
    model: &'static str,
    is_prior: bool,
    sigma_mag: f64,
    points: Vec<HeldOutPoint>,
}

impl HeldOut {
    /// Returns residuals, in sigmas, of selected folds; the weights are such that all models have the same total
    /// weight.
    fn residuals(&self, is_selected: impl Fn(usize) -> bool) -> Vec<(f64, f64)> {
        let selected: Vec<_> = self.points.iter().filter(|point| is_selected(point.fold)).collect();
        let weight = 1.0 / selected.len() as f64;
        selected.iter().map(|point| (point.residual_mag() / self.sigma_mag, weight)).collect()
    }

    /// Returns evenly spaced quantiles of the residuals in sigmas, each with weight 1.
    fn quantiles(&self) -> Vec<(f64, f64)> {
        let mut sorted: Vec<f64> = self.residuals(|_| true).into_iter().map(|(residual, _)| residual).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |i: usize| quantile(&sorted, (i as f64 + 0.5) / QUANTILES as f64);
        (0..QUANTILES).map(|i| (at(i), 1.0)).collect()
    }

    fn distribution(&self) -> ErrorDistribution {
        error_distribution(&self.residuals(|_| true)).expect("many residuals")
    }
}

/// Returns the distribution of all models except priors, optionally without one of them.
fn pooled(all: &[HeldOut], without: Option<&str>) -> ErrorDistribution {
    let counted = all.iter().filter(|one| !one.is_prior && Some(one.model) != without);
    let residuals: Vec<_> = counted.flat_map(HeldOut::quantiles).collect();
    error_distribution(&residuals).expect("many residuals")
}

fn measurements(data: &Path, set: DataSet, height_km: Option<f64>) -> Measurements {
    let mut reader = RecordReader::open(&[data.join(set.path())], &PhotometryOptions::default()).unwrap();
    let mut measured = measure(&mut reader, &Placement::recorded(height_km), &Selection::default()).unwrap();
    crate::common::thin(&mut measured);
    measured
}

fn fitted(model: &BrightnessModel, (loss, held): FitOf, measurements: &Measurements) -> Vec<HeldOutPoint> {
    let file = model.file().unwrap();
    let (band, system) = model.band();
    let (sun_magnitude, earthshine) = (band.sun_magnitude(system), Earthshine::Computed);
    let form: Box<dyn Form> = match (file.shape, file.coefficients, &file.panels) {
        (Some(shape), Some(coefficients), _) => {
            Box::new(TwoPanelForm { shape, coefficients, earthshine, blocking: true, sun_magnitude })
        }
        (_, _, Some(spec)) => Box::new(PanelsForm { spec: spec.clone(), earthshine, sun_magnitude }),
        _ => panic!("{} has no parameters", file.name),
    };
    let is_free = |name: &String| name != PANEL_OFFSET && held.iter().all(|(held, _)| held != name);
    let free: Vec<String> = form.parameters().into_iter().map(|one| one.name).filter(is_free).collect();
    let held = held.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let settings = FitSettings { free: free.clone(), held, loss, ..FitSettings::default() };
    let points = points_of_measurements(measurements, &RawWeights::default());
    let own = CompetingForm { name: file.name.clone(), form, free };
    compare_forms(&[own], &points, None, &settings, FOLDS).unwrap().remove(0).held_out_points
}

fn published(model: &BrightnessModel, measurements: &Measurements) -> Vec<HeldOutPoint> {
    let colour_mag = model.colour_to_mag(Band::V, MagSystem::Vega);
    let point = |one: &streakcast::fit::measurements::Measurement| {
        let predicted_mag = model.standard_magnitude_with(&one.geometry, Earthshine::Computed)?.0 + colour_mag;
        Some(HeldOutPoint { observed_mag: one.magnitude.0, predicted_mag, fold: one.group as usize % FOLDS })
    };
    measurements.points.iter().filter_map(point).collect()
}

fn held_out(data: &Path) -> Vec<HeldOut> {
    let library = ModelLibrary::embedded();
    let photometry = Photometry::read(data).unwrap();
    let of = |(name, set, height_km, fit): (&'static str, DataSet, Option<f64>, Option<FitOf>)| {
        let model = library.get(name).unwrap();
        let file = model.file().unwrap();
        let points = match (set, fit) {
            (DataSet::AmateursPayloads | DataSet::AmateursRocketBodies, _) => {
                // The standard magnitudes are those of different objects.
                let predicted_mag = file.mean_mag.unwrap();
                let listed = photometry.get(set).unwrap().iter().enumerate();
                let point = |(row, one): (usize, &streakcast::fit::checks::ReferenceMeasurement)| HeldOutPoint {
                    observed_mag: one.magnitude.0,
                    predicted_mag,
                    fold: row % FOLDS,
                };
                listed.map(point).collect()
            }
            (_, Some(fit)) => fitted(&model, fit, &measurements(data, set, height_km)),
            (_, None) => published(&model, &measurements(data, set, height_km)),
        };
        HeldOut { model: name, is_prior: file.kind == ModelKind::Prior, sigma_mag: file.sigma_mag, points }
    };
    MODELS.into_iter().map(of).collect()
}

/// Weights, and weighted sums of stated probabilities and of observed fractions, for each tenth of the stated
/// probability.
#[derive(Clone, Copy, Default)]
struct Reliability([[f64; 3]; 10]);

impl Reliability {
    fn add(&mut self, stated: f64, is_brighter: bool, weight: f64) {
        let tenth = &mut self.0[((10.0 * stated) as usize).min(9)];
        for (sum, value) in tenth.iter_mut().zip([1.0, stated, f64::from(u8::from(is_brighter))]) {
            *sum += weight * value;
        }
    }

    fn of(one: &HeldOut, distribution_of_fold: &dyn Fn(usize) -> ErrorDistribution) -> Self {
        let mut seen = Self::default();
        let weight = 1.0 / one.points.len() as f64;
        let of_folds: Vec<ErrorDistribution> = (0..FOLDS).map(distribution_of_fold).collect();
        for point in &one.points {
            for limit_mag in LIMITS.map(|quarter| 0.25 * f64::from(quarter)) {
                let x = (limit_mag - point.predicted_mag) / one.sigma_mag;
                seen.add(of_folds[point.fold].cumulative(x, 0.0), point.observed_mag < limit_mag, weight);
            }
        }
        seen
    }

    fn sum<'a>(all: impl Iterator<Item = &'a Self>) -> Self {
        let mut total = Self::default();
        for one in all {
            for (sum, more) in total.0.iter_mut().flatten().zip(one.0.iter().flatten()) {
                *sum += more;
            }
        }
        total
    }

    /// Returns the mean stated probability and the observed fraction in each tenth.
    fn shares(&self) -> [[f64; 2]; 10] {
        self.0.map(|[weight, stated, observed]| [stated / weight, observed / weight])
    }

    /// Returns the largest difference in any tenth.
    fn worst(&self) -> f64 {
        self.shares().iter().map(|[stated, observed]| (stated - observed).abs()).fold(0.0, f64::max)
    }

    /// Returns the mean difference over all points.
    fn mean(&self) -> f64 {
        let weights: f64 = self.0.iter().map(|tenth| tenth[0]).sum();
        self.0.iter().map(|[_, stated, observed]| (stated - observed).abs()).sum::<f64>() / weights
    }
}

/// Reliability of one model with its own distribution from the other folds, with that of the other models, and with a
/// normal distribution.
struct Row<'a> {
    of: &'a HeldOut,
    own: Reliability,
    others: Reliability,
    normal: Reliability,
}

fn row<'a>(one: &'a HeldOut, all: &[HeldOut]) -> Row<'a> {
    let others = pooled(all, Some(one.model));
    let own = |fold| error_distribution(&one.residuals(|other| other != fold)).expect("many residuals");
    Row {
        of: one,
        own: Reliability::of(one, &own),
        others: Reliability::of(one, &|_| others),
        normal: Reliability::of(one, &|_| ErrorDistribution::NORMAL),
    }
}

fn rows(all: &[HeldOut]) -> Vec<Row<'_>> {
    all.iter().map(|one| row(one, all)).collect()
}

fn pooled_reliability(rows: &[Row<'_>], of: for<'a> fn(&'a Row<'_>) -> &'a Reliability) -> Reliability {
    Reliability::sum(rows.iter().map(of))
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// Returns the contents of [`TABLES`].
fn tables(rows: &[Row<'_>]) -> [String; 3] {
    let columns: [for<'a> fn(&'a Row<'_>) -> &'a Reliability; 3] =
        [|row| &row.own, |row| &row.others, |row| &row.normal];
    let of = columns.map(|column| pooled_reliability(rows, column).shares());
    let mut tenths = "| stated probability | core and wing: stated, observed | of the other models: stated, observed | normal: stated, observed |\n|---|---|---|---|\n".to_owned();
    for tenth in 0..10 {
        let cells = of.map(|shares| shares[tenth].map(percent).join(", "));
        tenths += &format!(
            "| {:.1} to {:.1} | {} |\n",
            0.1 * f64::from(tenth as u8),
            0.1 * f64::from(tenth as u8 + 1),
            cells.join(" | ")
        );
    }
    let mut distributions =
        "| model | sigma, mag | core: shift, width | wing: share, shift, width |\n|---|---|---|---|\n".to_owned();
    let mut models =
        "| model | points | core and wing | of the other models | normal |\n|---|---|---|---|---|\n".to_owned();
    for Row { of, own, others, normal } in rows {
        let d = of.distribution();
        distributions += &format!(
            "| {} | {:.3} | {:.2}, {:.2} | {:.0} %, {:.2}, {:.2} |\n",
            of.model,
            of.sigma_mag,
            d.core_shift,
            d.core_sigma,
            100.0 * d.wing_share,
            d.wing_shift,
            d.wing_sigma,
        );
        models += &format!(
            "| {} | {} | {} | {} | {} |\n",
            of.model,
            of.points.len(),
            percent(own.worst()),
            percent(others.worst()),
            percent(normal.worst()),
        );
    }
    [tenths, distributions, models]
}

fn print(rows: &[Row<'_>]) {
    println!("{}", tables(rows).join("\n"));
    for (name, of) in [
        ("own", (|row| &row.own) as for<'a> fn(&'a Row<'_>) -> &'a Reliability),
        ("others", |row| &row.others),
        ("normal", |row| &row.normal),
    ] {
        let pooled = pooled_reliability(rows, of);
        println!("{name}: worst tenth {}, mean {}", percent(pooled.worst()), percent(pooled.mean()));
    }
}

fn parameters(of: &ErrorDistribution) -> [(&'static str, f64); 5] {
    [
        ("core_shift", of.core_shift),
        ("core_sigma", of.core_sigma),
        ("wing_share", of.wing_share),
        ("wing_shift", of.wing_shift),
        ("wing_sigma", of.wing_sigma),
    ]
}

#[test]
fn valid_stated_probabilities_to_be_brighter_hold_on_unseen_points() {
    let Some(data) = crate::common::data_dir() else { return };
    let all = held_out(&data);
    let rows = rows(&all);
    print(&rows);
    for (name, table) in TABLES.into_iter().zip(tables(&rows)) {
        crate::common::assert_is_documented(&format!("{name}.md"), &table);
    }
    let [own, others, normal] = [
        pooled_reliability(&rows, |row| &row.own),
        pooled_reliability(&rows, |row| &row.others),
        pooled_reliability(&rows, |row| &row.normal),
    ];
    assert!(own.worst() < POOLED_TOLERANCE, "{}", own.worst());
    // Models without photometry use the distribution of the other models.
    assert!(others.mean() < normal.mean() && own.mean() < others.mean());
    // The values in the files are those of this fit.
    let library = ModelLibrary::embedded();
    let is_same = |name: &str, file: &ErrorDistribution, fitted: &ErrorDistribution| {
        for ((key, file), (_, fitted)) in parameters(file).into_iter().zip(parameters(fitted)) {
            assert!(
                (file - fitted).abs() < FILE_TOLERANCE,
                "{name}: {key} {file}, fitted {fitted}; cargo test --test fitting -- --ignored write_error_distributions"
            );
        }
        // The sigma of a fitted model contains 68 %, as for a normal distribution; a published sigma is the standard
        // deviation of core and wings together.
        let inside = file.cumulative(1.0, 0.0) - file.cumulative(-1.0, 0.0);
        assert!((0.6..0.87).contains(&inside), "{name}: {inside}");
    };
    for one in &all {
        is_same(one.model, library.get(one.model).unwrap().error_distribution(), &one.distribution());
    }
    is_same("default", &ErrorDistribution::default(), &pooled(&all, None));
    let has_own = |name: &str| all.iter().any(|one| one.model == name);
    for name in library.names().filter(|name| !has_own(name)) {
        assert_eq!(*library.get(name).unwrap().error_distribution(), ErrorDistribution::default(), "{name}");
    }
}

/// Replaces the lines of a text that start with `beginning`, or inserts `line` after those that start with `after`.
fn with_line(text: &str, beginning: &str, after: Option<&str>, line: &str) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    let at = lines.iter().position(|old| old.starts_with(beginning)).or_else(|| {
        let after = lines.iter().position(|old| after.is_some_and(|after| old.starts_with(after)))?;
        lines.insert(after + 1, "");
        Some(after + 1)
    });
    lines[at.expect("a line to replace, or one before it")] = line;
    lines.join("\n") + "\n"
}

#[test]
#[ignore = "writes into the source"]
fn write_error_distributions() {
    let data = crate::common::data_dir().expect("the data folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let all = held_out(&data);
    let edit = |path: &Path, beginning: &str, after: Option<&str>, line: &str| {
        let text = std::fs::read_to_string(path).unwrap();
        std::fs::write(path, with_line(&text, beginning, after, line)).unwrap();
    };
    for one in &all {
        let values = parameters(&one.distribution()).map(|(key, value)| format!("\"{key}\": {value:?}")).join(", ");
        let line = format!("  \"error_distribution\": {{ {values} }},");
        let path = root.join(format!("src/photometry/models/{}.json", one.model));
        edit(&path, "  \"error_distribution\"", Some("  \"sigma_origin\""), &line);
    }
    let values = parameters(&pooled(&all, None)).map(|(key, value)| format!("{key}: {value:?}")).join(", ");
    let path = root.join("src/photometry/error_distribution.rs");
    edit(&path, "        Self { core_shift: ", None, &format!("        Self {{ {values} }}"));
    let rows = rows(&all);
    print(&rows);
    for (name, table) in TABLES.into_iter().zip(tables(&rows)) {
        std::fs::write(root.join(format!("docs/tables/{name}.md")), table).unwrap();
    }
}
