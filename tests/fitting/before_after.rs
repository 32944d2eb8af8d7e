//! Default models with the recipe of their fits and with that of earlier versions, on the same held-out points.
//!
//! *Before*: least squares (for V2 Mini soft L1) with a scatter of 0.5 mag and rows weighted by n^-1/2 for n rows of a
//! group; sigma contains 68.3 % of the rows about the model, and each kind has its own normal core and wing, fitted to
//! rows. *After*: soft L1 with a scatter of 0.3 mag and weights by the correlation within groups; the model is the
//! median, and the wings are those of the other kinds. Both are fitted without a tenth of the groups, which they
//! predict. All means are weighted by group, and their errors are those between groups.
//!
//! `cargo test --test fitting -- --ignored write_before_after` writes the tables `TABLES` in `docs/tables`, from which
//! `docs/magnitudes.py` draws the figure.
//!
//! Requires the data folder; skipped with a message without it.

use std::collections::BTreeMap;
use std::path::Path;

use streakcast::fit::{
    CompetingForm, FitPoint, FitSettings, HeldOutPoint, Loss, compare_forms, median_mag, weighted_quantile,
    weighted_sigma_68_mag,
};
use streakcast::photometry::{ErrorDistribution, NormalPart};

use super::error_distributions::{common_shape, mixture};
use super::survey::{
    FOLDS, GroupMean, Recipe, SURVEYS, Survey, Weighted, held_out_of_form, in_order_of_held_out, log_density, mean_of,
    median_and_sigma_mag,
};

/// Tables in `docs/tables`: means of each kind; medians by phase angle.
const TABLES: [&str; 2] = ["before-after", "before-after-phase"];
/// Scatter of a point before, mag.
const SCATTER_BEFORE_MAG: f64 = 0.5;
/// Bounds of the phase angle, degrees.
const PHASES_DEG: [f64; 8] = [20.0, 40.0, 55.0, 70.0, 85.0, 100.0, 130.0, 150.0];
/// Fewest groups for which statistics of an interval of the phase angle are given.
const LEAST_GROUPS: usize = 5;
/// Number of quantiles of the residuals of rows to which the core and the wing of a kind were fitted.
const QUANTILES: usize = 1000;
/// Smallest gain of the log score of V1.5, and of the mean of the kinds.
const LEAST_GAIN: f64 = 0.03;
/// Largest median of VisorSat from 100 to 130 deg, mag; before it was 0.35 mag.
const MOST_TREND_MAG: f64 = 0.15;

/// Held-out prediction: residual from the printed magnitude, its sigma, and the distribution of residuals in sigmas.
#[derive(Copy, Clone)]
struct Predicted {
    residual_mag: f64,
    sigma_mag: f64,
    shape: ErrorDistribution,
}

/// Predictions of one point, before and after.
struct Pair {
    phase_deg: f64,
    weight: f64,
    group: u32,
    of: [Predicted; 2],
}

struct Kind {
    name: String,
    pairs: Vec<Pair>,
}

/// Errors of the earlier recipe: each group is weighted by the square root of its number of points, without a change
/// of Σ 1/σ².
fn points_before(points: &[FitPoint]) -> Vec<FitPoint> {
    let mut counts = BTreeMap::<u32, f64>::new();
    points.iter().for_each(|point| *counts.entry(point.group).or_default() += 1.0);
    let share = |point: &FitPoint| counts[&point.group].powf(-0.5);
    let level = points.len() as f64 / points.iter().map(share).sum::<f64>();
    // 1/σ'² = 1/σ² n^-½ N / Σ n^-½
    let sigma_mag = |point: &FitPoint| SCATTER_BEFORE_MAG * (share(point) * level).powf(-0.5);
    points.iter().map(|point| FitPoint { sigma_mag: sigma_mag(point), weight: 1.0, ..*point }).collect()
}

/// Core and wing of residuals in sigmas, with equal weights of the rows.
fn core_and_wing(rows: &[f64]) -> ErrorDistribution {
    let mut pairs: Vec<(f64, f64)> = rows.iter().map(|x| (*x, 1.0)).collect();
    let quantiles: Vec<f64> =
        (0..QUANTILES).map(|i| weighted_quantile(&mut pairs, (i as f64 + 0.5) / QUANTILES as f64)).collect();
    let median = median_mag(&pairs);
    let part = |share, centre, width| NormalPart { share, centre, width };
    mixture(&quantiles, [part(0.8, median, 0.7), part(0.2, median - 1.0, 1.75), part(0.0, 0.0, 1.0)])
}

fn kind(data: &Path, survey: &Survey) -> Kind {
    let points = survey.points(data);
    let candidate = &survey.models[0];
    let recipe = survey.recipe(candidate).unwrap();
    let loss = if candidate.name == "v2mini-panels" { Loss::SoftL1 } else { Loss::Squares };
    let settings = FitSettings { loss, ..recipe.settings };
    let after = survey.held_out(candidate, &points);
    let before = held_out_of_form(candidate.name, recipe.form, &settings, &points_before(&points));
    let ordered = in_order_of_held_out(&points);
    assert_eq!([before.len(), after.len()], [ordered.len(); 2], "{}", candidate.name);
    let of_others = |all: &[HeldOutPoint], fold: usize| {
        all.iter().filter(|one| one.fold != fold).copied().collect::<Vec<HeldOutPoint>>()
    };
    let others = common_shape(data, Some(candidate.name));
    let before_of_fold: Vec<(f64, ErrorDistribution)> = (0..FOLDS)
        .map(|fold| {
            let rows: Vec<f64> = of_others(&before, fold).iter().map(HeldOutPoint::residual_mag).collect();
            let sigma_mag = weighted_sigma_68_mag(&rows.iter().map(|r| (*r, 1.0)).collect::<Vec<_>>());
            (sigma_mag, core_and_wing(&rows.iter().map(|r| r / sigma_mag).collect::<Vec<_>>()))
        })
        .collect();
    let after_of_fold: Vec<[f64; 2]> =
        (0..FOLDS).map(|fold| median_and_sigma_mag(of_others(&after, fold).iter())).collect();
    let pair = |((point, before), after): ((&FitPoint, &HeldOutPoint), &HeldOutPoint)| {
        assert_eq!([point.magnitude, after.observed_mag], [before.observed_mag; 2], "{}", candidate.name);
        let (sigma_before_mag, own) = before_of_fold[before.fold];
        let [median_mag, sigma_mag] = after_of_fold[after.fold];
        Pair {
            phase_deg: point.geometry.phase_angle_rad().to_degrees(),
            weight: after.weight,
            group: after.group,
            of: [
                Predicted { residual_mag: before.residual_mag(), sigma_mag: sigma_before_mag, shape: own },
                Predicted { residual_mag: after.residual_mag() - median_mag, sigma_mag, shape: others },
            ],
        }
    };
    Kind { name: survey.kind.to_string(), pairs: ordered.iter().zip(&before).zip(&after).map(pair).collect() }
}

impl Kind {
    fn mean(&self, value: impl Fn(&Pair) -> f64) -> GroupMean {
        GroupMean::of(self.pairs.iter().map(|one| Weighted { value: value(one), weight: one.weight, group: one.group }))
    }

    /// Share of the points in the central interval that should contain a share of them.
    fn within(&self, which: usize, share: f64) -> GroupMean {
        let low = 0.5 * (1.0 - share);
        self.mean(|one| f64::from(u8::from((low..1.0 - low).contains(&one.of[which].brighter()))))
    }

    fn gain(&self) -> GroupMean {
        self.mean(|one| one.of[1].log_score() - one.of[0].log_score())
    }

    fn median_mag(&self, which: usize, phases_deg: [f64; 2]) -> f64 {
        let inside = self.pairs.iter().filter(|one| (phases_deg[0]..phases_deg[1]).contains(&one.phase_deg));
        median_mag(&inside.map(|one| (one.of[which].residual_mag, one.weight)).collect::<Vec<_>>())
    }
}

impl Predicted {
    fn log_score(&self) -> f64 {
        log_density(&self.shape, self.residual_mag, self.sigma_mag)
    }

    /// Stated probability of a brighter magnitude than the observed one.
    fn brighter(&self) -> f64 {
        self.shape.cumulative(self.residual_mag / self.sigma_mag, 0.0)
    }
}

/// Mean of the kinds, whose errors are independent.
fn mean_of_kinds(kinds: &[Kind]) -> GroupMean {
    let gains: Vec<GroupMean> = kinds.iter().map(Kind::gain).collect();
    let n = gains.len() as f64;
    GroupMean {
        mean: gains.iter().map(|one| one.mean).sum::<f64>() / n,
        error: gains.iter().map(|one| one.error * one.error).sum::<f64>().sqrt() / n,
    }
}

/// Returns the contents of [`TABLES`].
fn tables(kinds: &[Kind]) -> [String; 2] {
    let mut means = "| kind | version | mean absolute residual, mag | median, mag | PIT | within 50 % | within 68 % | within 95 % | gain of the log score |\n|---|---|---|---|---|---|---|---|---|\n".to_owned();
    let mut phases =
        "| kind | phase angle | tracks, nights or passes | median before, mag | median after, mag | within one sigma after |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for kind in kinds {
        for (which, version) in ["before", "after"].into_iter().enumerate() {
            let absolute = kind.mean(|one| one.of[which].residual_mag.abs());
            let pit = kind.mean(|one| one.of[which].brighter());
            let [half, one_sigma, most] = [0.5, 0.6827, 0.95].map(|share| {
                let within = kind.within(which, share);
                format!("{:.0} +- {:.0} %", 100.0 * within.mean, 100.0 * within.error)
            });
            let gain = kind.gain();
            let gain = match which {
                0 => String::new(),
                _ => format!("{:+.3} +- {:.3} ", gain.mean, gain.error),
            };
            let name = if which == 0 { format!("{} ", kind.name) } else { String::new() };
            means += &format!(
                "| {name}| {version} | {:.3} +- {:.3} | {:+.2} | {:.3} +- {:.3} | {half} | {one_sigma} | {most} | {gain}|\n",
                absolute.mean,
                absolute.error,
                kind.median_mag(which, [0.0, 180.0]),
                pit.mean,
                pit.error,
            );
        }
        for bounds in PHASES_DEG.windows(2) {
            let bounds = [bounds[0], bounds[1]];
            let inside: Vec<&Pair> =
                kind.pairs.iter().filter(|one| (bounds[0]..bounds[1]).contains(&one.phase_deg)).collect();
            let groups = inside.iter().map(|one| one.group).collect::<std::collections::BTreeSet<_>>().len();
            if groups < LEAST_GROUPS {
                continue;
            }
            let within = GroupMean::of(inside.iter().map(|one| Weighted {
                value: f64::from(u8::from(one.of[1].residual_mag.abs() < one.of[1].sigma_mag)),
                weight: one.weight,
                group: one.group,
            }));
            phases += &format!(
                "| {} | {:.0} to {:.0} deg | {groups} | {:+.2} | {:+.2} | {:.0} +- {:.0} % |\n",
                kind.name,
                bounds[0],
                bounds[1],
                kind.median_mag(0, bounds),
                kind.median_mag(1, bounds),
                100.0 * within.mean,
                100.0 * within.error,
            );
        }
    }
    let gain = mean_of_kinds(kinds);
    means += &format!("| mean of the kinds | after | | | | | | | {:+.3} +- {:.3} |\n", gain.mean, gain.error);
    [means, phases]
}

fn kinds(data: &Path) -> Vec<Kind> {
    SURVEYS.iter().map(|survey| kind(data, survey)).collect()
}

#[test]
fn valid_the_recipe_improves_predictions() {
    let Some(data) = crate::common::data_dir() else { return };
    let kinds = kinds(&data);
    let tables = tables(&kinds);
    println!("{}", tables.join("\n"));
    assert!(kinds[0].gain().mean >= LEAST_GAIN && mean_of_kinds(&kinds).mean >= LEAST_GAIN, "{}", tables[0]);
    let visorsat = kinds.iter().find(|kind| kind.name == "starlink-visorsat").unwrap();
    let trend_mag = [0, 1].map(|which| visorsat.median_mag(which, [100.0, 130.0]));
    assert!(trend_mag[1].abs() < MOST_TREND_MAG && trend_mag[1].abs() < trend_mag[0].abs(), "{}", tables[1]);
    for kind in &kinds {
        let pit = kind.mean(|one| one.of[1].brighter());
        assert!(pit.is(0.5), "{}: {pit:?}", kind.name);
        for share in [0.5, 0.6827, 0.95] {
            let within = kind.within(1, share);
            println!("{}: {share} {within:.4?}", kind.name);
            assert!(within.is(share) || within.is_share(share), "{}: {within:?} for {share}", kind.name);
        }
    }
    for (name, table) in TABLES.into_iter().zip(&tables) {
        crate::common::assert_is_documented(&format!("{name}.md"), table);
    }
}

/// Sigma and mean absolute residual of V2 Mini for other numbers of folds: with few passes they depend on which of them
/// are left out together.
#[test]
#[ignore = "fits of a minute, for a sentence in docs/explanation/models.md"]
fn folds_of_v2_mini() {
    let data = crate::common::data_dir().expect("the data folder");
    let survey = &SURVEYS[1];
    let points = survey.points(&data);
    for folds in [5, 8, 10, 11, 13, 16, 20] {
        let Recipe { form, settings } = survey.recipe(&survey.models[0]).unwrap();
        let own = CompetingForm { name: "own".to_owned(), form, free: settings.free.clone() };
        let held_out = compare_forms(&[own], &points, None, &settings, folds).unwrap().remove(0).held_out_points;
        let [median_mag, sigma_mag] = median_and_sigma_mag(held_out.iter());
        let absolute_mag = mean_of(&held_out, |one| (one.residual_mag() - median_mag).abs());
        println!("{folds} folds: sigma {sigma_mag:.3} mag, mean absolute residual {absolute_mag:.3?}");
    }
}

#[test]
#[ignore = "writes into the docs"]
fn write_before_after() {
    let data = crate::common::data_dir().expect("the data folder");
    for (name, table) in TABLES.into_iter().zip(tables(&kinds(&data))) {
        println!("{table}");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/tables/{name}.md"));
        std::fs::write(path, table).unwrap();
    }
}
