//! The default models have the best score of all bundled candidates on held-out tracks, nights or passes.
//!
//! Models fitted for this project are fitted again to nine tenths of the groups and predict the remaining tenth.
//! Published models were made from other measurements, so that all points are held out for them. The quadratic in the
//! phase angle, fitted to the same folds by the same recipe, shows whether the additional parameters of panels improve
//! the prediction.
//!
//! The log score is the mean logarithm of the probability density of the residuals, mag⁻¹. The density is that of
//! `ErrorDistribution::SATELLITES` with the median and the sigma of the other folds. All means are weighted by group.
//!
//! `cargo test --test fitting -- --ignored write_models` fits the models to all points of the surveys and writes the
//! model files; `fit run` gives the same parameters.
//!
//! Requires the data folder; skipped with a message without it.

use std::fmt::Write;
use std::path::Path;

use streakcast::fit::checks::compare;
use streakcast::fit::{FitPoint, FitSettings, HeldOutPoint, Loss, ModelDescription, PhaseForm, Problem, model_file};
use streakcast::passes::ModelChoice;
use streakcast::photometry::{ErrorDistribution, ModelLibrary};

use super::survey::{
    FOLDS, GroupMean, Recipe, SURVEYS, Survey, Weighted, held_out_of_form, log_density, mean_of, median_and_sigma_mag,
};
use crate::common::{assert_is_documented, assert_same};

/// Largest mean absolute residual of default models, mag.
const MOST_MAG: [(&str, f64); 2] = [("starlink-v1.5-facets", 0.33), ("visorsat-panels", 0.345)];
/// Smallest difference of the mean absolute residual from that of a robust quadratic in the phase angle, mag.
const LEAST_GAIN_MAG: (&str, f64) = ("visorsat-panels", 0.05);

struct Score {
    log: GroupMean,
    absolute_mag: GroupMean,
}

/// Scores held-out points with median and sigma of the other folds.
fn score(points: &[HeldOutPoint]) -> Score {
    let of_others: Vec<[f64; 2]> =
        (0..FOLDS).map(|fold| median_and_sigma_mag(points.iter().filter(|one| one.fold != fold))).collect();
    let value = |one: &HeldOutPoint| {
        let [median, sigma] = of_others[one.fold];
        (one.residual_mag() - median, sigma)
    };
    let log = |one: &HeldOutPoint| {
        let (residual, sigma) = value(one);
        log_density(&ErrorDistribution::SATELLITES, residual, sigma)
    };
    let absolute =
        points.iter().map(|one| Weighted { value: value(one).0.abs(), weight: one.weight, group: one.group });
    Score { log: mean_of(points, log), absolute_mag: GroupMean::of(absolute) }
}

/// Name of the quadratic in the phase angle.
const QUADRATIC: &str = "quadratic in phase";

/// Scores of all models of a survey, the default first and a quadratic in the phase angle last.
fn scores(survey: &Survey, points: &[FitPoint]) -> Vec<(&'static str, Score)> {
    let mut scores: Vec<(&str, Score)> =
        survey.models.iter().map(|one| (one.name, score(&survey.held_out(one, points)))).collect();
    let settings = FitSettings { loss: Loss::SoftL1, ..FitSettings::free(&["a0", "a1", "a2"]) };
    let quadratic = held_out_of_form("quadratic", Box::new(PhaseForm { degree: 2 }), &settings, points);
    scores.push((QUADRATIC, score(&quadratic)));
    scores
}

/// Returns the first note of a fitted model, as `model show` prints it.
fn note(survey: &Survey, name: &str, rms_mag: f64, scores: &[(&str, Score)]) -> String {
    let mag = |name: &str| scores.iter().find(|(other, _)| *other == name).unwrap().1.absolute_mag.mean;
    let others = scores.iter().filter(|(other, _)| *other != name).map(|(other, _)| match *other {
        QUADRATIC => format!("a quadratic in the phase angle {:.3} mag", mag(QUADRATIC)),
        other => format!("{other} {:.3} mag", mag(other)),
    });
    format!(
        "Weighted RMS of the fitted points {rms_mag:.3} mag. Mean absolute residual on held-out {} {:.3} mag; of other models \
         on the same points: {}.",
        survey.group_name(),
        mag(name),
        others.collect::<Vec<_>>().join(", ")
    )
}

#[test]
fn valid_default_models_have_the_best_score_on_unseen_points() {
    let Some(data) = crate::common::data_dir() else { return };
    let (library, defaults) = (ModelLibrary::embedded(), ModelChoice::default());
    let mut table =
        "| kind | points, groups | model | log score | mean absolute residual, mag |\n|---|---|---|---|---|\n"
            .to_owned();
    for survey in &SURVEYS {
        let points = survey.points(&data);
        let default = defaults.of_kind(survey.kind).and_then(|model| Some(model.file()?.name.clone())).unwrap();
        assert_eq!(survey.models[0].name, default);
        let scores = scores(survey, &points);
        for candidate in survey.models.iter().filter(|one| one.held.is_some()) {
            let model = library.get(candidate.name).unwrap();
            let file = model.file().unwrap();
            let expected = note(survey, candidate.name, file.rms_mag.unwrap(), &scores);
            assert_same(candidate.name, &file.provenance.notes[0], &expected);
        }
        let groups = points.iter().map(|point| point.group).collect::<std::collections::BTreeSet<_>>().len();
        for (index, (name, score)) in scores.iter().enumerate() {
            let of_survey =
                if index == 0 { format!("{} | {}, {groups}", survey.kind, points.len()) } else { "|".to_owned() };
            let name = if *name == default { format!("**{name}**") } else { (*name).to_owned() };
            let (log, mag) = (score.log, score.absolute_mag);
            writeln!(
                table,
                "| {of_survey} | {name} | {:.3} +- {:.3} | {:.3} +- {:.3} |",
                log.mean, log.error, mag.mean, mag.error
            )
            .unwrap();
        }
        println!("{table}");
        let own = &scores[0].1;
        for (name, other) in &scores[1..] {
            assert!(
                own.log.mean > other.log.mean && own.absolute_mag.mean < other.absolute_mag.mean,
                "{name}\n{table}"
            );
        }
        if let Some((_, most)) = MOST_MAG.iter().find(|(name, _)| *name == default) {
            assert!(own.absolute_mag.mean <= *most, "{table}");
        }
        if default == LEAST_GAIN_MAG.0 {
            let gain = scores.last().unwrap().1.absolute_mag.mean - own.absolute_mag.mean;
            assert!(gain >= LEAST_GAIN_MAG.1, "{table}");
        }
        // Every bundled model of these satellites is a candidate.
        let satellites = |name: &str| compare(&library.get(name).unwrap(), None)[0].satellites;
        let mut candidates: Vec<&str> = survey.models.iter().map(|one| one.name).collect();
        candidates.sort_unstable();
        let of_kind: Vec<&str> = library.names().filter(|name| satellites(name) == satellites(&default)).collect();
        assert_eq!(of_kind, candidates, "{}", survey.kind);
    }
    assert_is_documented("default-models.md", &table);
}

/// Fits the models again and writes parameters, covariance, range, RMS and sigma into their files.
#[test]
#[ignore = "writes into the source"]
fn write_models() {
    let data = crate::common::data_dir().expect("the data folder");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/photometry/models");
    let library = ModelLibrary::embedded();
    for survey in &SURVEYS {
        // Fits to all points; median and sigma from every n-th point, because rows of a track differ little.
        let (points, thinned) = (survey.weighed(&survey.measurements(&data)), survey.points(&data));
        for candidate in survey.models {
            let Some(Recipe { form, settings }) = survey.recipe(candidate) else { continue };
            let problem = Problem::new(&*form, &points, &settings).unwrap();
            let fit = problem.solve().unwrap();
            let base = library.get(candidate.name).unwrap().file().unwrap().clone();
            let held_out = survey.held_out(candidate, &thinned);
            let rms_mag = fit.statistics(&points).unwrap().rms_mag;
            let mut notes = base.provenance.notes.clone();
            notes[0] = note(survey, candidate.name, rms_mag, &scores(survey, &thinned));
            let singles: Vec<(f64, f64)> = held_out.iter().map(HeldOutPoint::weighted_residual).collect();
            let description = ModelDescription {
                name: base.name.clone(),
                title: base.title.clone(),
                source: base.provenance.source.clone(),
                data: base.provenance.data.clone(),
                date: base.provenance.date.clone(),
                provisional: base.provenance.provisional,
                notes,
                sigma_origin: format!(
                    "sigma contains 68.3 % of the residuals of single measurements of held-out {} ({FOLDS} folds) about \
                     their median, which is 0; other surveys may be offset by 0.1 to 0.2 mag",
                    survey.group_name()
                ),
            };
            let mut file = model_file(&base, &fit, problem.points(), rms_mag, &singles, &description).unwrap();
            file.aliases = base.aliases.clone();
            // Six digits are more than the points determine.
            let rounded = |x: f64| format!("{x:.5e}").parse::<f64>().unwrap();
            if let Some(panels) = &mut file.panels {
                panels.parameters.iter_mut().for_each(|one| one.value = rounded(one.value));
            }
            if let Some(c) = &mut file.coefficients {
                [&mut c.c1, &mut c.c2, &mut c.c3, &mut c.c4, &mut c.c5, &mut c.n_sail, &mut c.n_base]
                    .into_iter()
                    .for_each(|c| *c = rounded(*c));
            }
            println!("{}: rms {rms_mag:.3}, sigma {:.3}, {:?}", file.name, file.sigma_mag, file.parameters());
            std::fs::write(folder.join(format!("{}.json", file.name)), file.to_json() + "\n").unwrap();
        }
    }
}
