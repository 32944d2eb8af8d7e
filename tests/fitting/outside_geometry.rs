//! Sigma outside the fitted geometry: models fitted without a region of the geometry predict the points of this region.
//!
//! `cargo test --test fitting -- --ignored write_outside_table` writes docs/tables/outside-geometry.md.
//!
//! Requires the data folder; skipped with a message without it.

use std::fmt::Write;
use std::path::Path;

use streakcast::fit::{FitPoint, Problem, median_mag, predict, range_of};
use streakcast::photometry::{BrightnessModel, Earthshine, ErrorDistribution, ModelLibrary, PhotometryOptions};

use super::survey::{GroupMean, SURVEYS, Weighted, log_density};

/// Shares of the points that are left out at either end of an angle.
const SHARES: [f64; 3] = [0.15, 0.3, 0.45];
/// Distances from the fitted geometry, degrees.
const DISTANCES_DEG: [[f64; 2]; 6] = [[0.0, 3.0], [3.0, 5.0], [5.0, 8.0], [8.0, 12.0], [12.0, 18.0], [18.0, 25.0]];
/// Rule with which the score is compared: 1 mag in quadrature outside.
const CONSTANT_MAG: f64 = 1.0;
const WITHIN: std::ops::RangeInclusive<f64> = 0.62..=0.75;
const LEAST_GAIN: f64 = 0.3;
/// Smallest and largest median of the residuals beyond the fitted phase angles of models with a forward lobe, mag.
const BEYOND_LOBES_MAG: [f64; 2] = [-0.9, 3.1];
/// Fewest fitted points.
const LEAST_POINTS: usize = 60;

/// Prediction outside the fitted geometry.
struct Outside {
    residual_mag: f64,
    sigma_mag: f64,
    /// Sigma inside the fitted geometry.
    inside_mag: f64,
    distance_deg: f64,
    weight: f64,
    group: u32,
}

type Angle = fn(&FitPoint) -> f64;

const ANGLES: [Angle; 3] = [
    |point| point.geometry.sun_latitude_rad,
    |point| point.geometry.observer_latitude_rad,
    |point| point.geometry.phase_angle_rad(),
];

/// Returns the predictions of models that were fitted without regions. Regions of the largest phase angles are omitted
/// for models with a forward lobe, for which another rule applies. The weights of a kind sum to 1.
fn predictions(data: &Path) -> Vec<Outside> {
    let mut all = Vec::new();
    for survey in &SURVEYS {
        let points = survey.points(data);
        let candidate = &survey.models[0];
        let recipe = survey.recipe(candidate).unwrap();
        let file = ModelLibrary::embedded().get(candidate.name).unwrap().file().unwrap().clone();
        let has_forward_lobe = file.to_json().contains("\"straight\"");
        let first = all.len();
        for angle in ANGLES {
            let mut sorted: Vec<f64> = points.iter().map(angle).collect();
            sorted.sort_by(f64::total_cmp);
            for share in SHARES {
                let cut = (share * sorted.len() as f64) as usize;
                for (low, bound) in [(true, sorted[cut]), (false, sorted[sorted.len() - 1 - cut])] {
                    let is_phase = std::ptr::fn_addr_eq(angle, ANGLES[2]);
                    if has_forward_lobe && is_phase && !low {
                        continue;
                    }
                    let is_left_out = |point: &&FitPoint| if low { angle(point) < bound } else { angle(point) > bound };
                    let (left_out, seen): (Vec<&FitPoint>, Vec<&FitPoint>) = points.iter().partition(is_left_out);
                    let [left_out, seen] = [left_out, seen].map(|side| side.into_iter().copied().collect::<Vec<_>>());
                    if seen.len() < LEAST_POINTS {
                        continue;
                    }
                    let fit = Problem::new(&*recipe.form, &seen, &recipe.settings).unwrap().solve().unwrap();
                    // The file of this fit, whose sigma follows the rule of the program.
                    let mut fitted = file.clone();
                    fitted.geometry_range = Some(range_of(&seen));
                    let model = BrightnessModel::from_file(fitted, "without a region").unwrap();
                    let magnitudes = predict(&*recipe.form, &left_out, &fit.values());
                    for (point, predicted) in left_out.iter().zip(magnitudes) {
                        let options = PhotometryOptions { earthshine: Earthshine::Off, ..PhotometryOptions::default() };
                        let Some(light) = model.brightness(&point.geometry, 1.0, &options) else { continue };
                        let inside_mag = model.sigma_mag();
                        let excess = ((light.scatter_mag / inside_mag).powi(2) - 1.0).max(0.0).sqrt();
                        if excess == 0.0 || !predicted.is_finite() {
                            continue;
                        }
                        all.push(Outside {
                            residual_mag: point.magnitude - predicted,
                            sigma_mag: light.scatter_mag,
                            inside_mag,
                            distance_deg: 10.0 * excess,
                            weight: point.weight,
                            group: point.group + 100_000 * survey.kind as u32,
                        });
                    }
                }
            }
        }
        let total: f64 = all[first..].iter().map(|one| one.weight).sum();
        all[first..].iter_mut().for_each(|one| one.weight /= total);
    }
    all
}

fn mean(all: &[&Outside], value: impl Fn(&Outside) -> f64) -> GroupMean {
    GroupMean::of(all.iter().map(|one| Weighted { value: value(one), weight: one.weight, group: one.group }))
}

/// Returns the shares within one sigma and the log scores, with the rule of the program and with 1 mag.
fn summary(all: &[&Outside]) -> [GroupMean; 4] {
    let constant = |one: &Outside| one.inside_mag.hypot(CONSTANT_MAG);
    let score = |one: &Outside, sigma: f64| log_density(&ErrorDistribution::SATELLITES, one.residual_mag, sigma);
    let within = |one: &Outside, sigma: f64| f64::from(u8::from(one.residual_mag.abs() < sigma));
    [
        mean(all, |one| within(one, one.sigma_mag)),
        mean(all, |one| within(one, constant(one))),
        mean(all, |one| score(one, one.sigma_mag)),
        mean(all, |one| score(one, constant(one))),
    ]
}

fn table(all: &[Outside]) -> String {
    let mut table = "| distance from the fitted geometry | predictions | within one sigma | within one sigma with 1 mag | log score | log score with 1 mag |\n|---|---|---|---|---|---|\n".to_owned();
    let mut row = |name: &str, of: &[&Outside]| {
        let [within, constant, score, constant_score] = summary(of);
        writeln!(
            table,
            "| {name} | {} | {:.0} +- {:.0} % | {:.0} % | {:.2} | {:.2} |",
            of.len(),
            100.0 * within.mean,
            100.0 * within.error,
            100.0 * constant.mean,
            score.mean,
            constant_score.mean
        )
        .unwrap();
    };
    for [from, to] in DISTANCES_DEG {
        let of: Vec<&Outside> = all.iter().filter(|one| from < one.distance_deg && one.distance_deg <= to).collect();
        row(&format!("{from} to {to} deg"), &of);
    }
    row("all", &all.iter().collect::<Vec<_>>());
    table
}

/// Models with a forward lobe that are fitted without the largest phase angles: kind, share of the points that are left
/// out, and median of the residuals of these points.
fn beyond_the_largest_phase(data: &Path) -> Vec<(&'static str, f64, f64)> {
    let mut found = Vec::new();
    for survey in &SURVEYS {
        let candidate = &survey.models[0];
        let json = ModelLibrary::embedded().get(candidate.name).unwrap().file().unwrap().to_json();
        if !json.contains("\"straight\"") {
            continue;
        }
        let (points, recipe) = (survey.points(data), survey.recipe(candidate).unwrap());
        let mut sorted: Vec<f64> = points.iter().map(ANGLES[2]).collect();
        sorted.sort_by(f64::total_cmp);
        for share in SHARES {
            let bound = sorted[sorted.len() - 1 - (share * sorted.len() as f64) as usize];
            let (left_out, seen): (Vec<FitPoint>, Vec<FitPoint>) =
                points.iter().copied().partition(|point| ANGLES[2](point) > bound);
            let fit = Problem::new(&*recipe.form, &seen, &recipe.settings).unwrap().solve().unwrap();
            let predicted = predict(&*recipe.form, &left_out, &fit.values());
            let residuals = left_out.iter().zip(predicted).filter(|(_, predicted)| predicted.is_finite());
            let residuals: Vec<(f64, f64)> =
                residuals.map(|(point, predicted)| (point.magnitude - predicted, point.weight)).collect();
            found.push((candidate.name, share, median_mag(&residuals)));
        }
    }
    found
}

/// The strength of a forward lobe does not follow from smaller phase angles.
#[test]
fn valid_errors_beyond_the_largest_phase_of_models_with_a_forward_lobe() {
    let Some(data) = crate::common::data_dir() else { return };
    let found = beyond_the_largest_phase(&data);
    println!("{found:.2?}");
    let medians = || found.iter().map(|(_, _, mag)| *mag);
    let extremes = [medians().fold(f64::INFINITY, f64::min), medians().fold(f64::NEG_INFINITY, f64::max)];
    for (extreme, documented) in extremes.iter().zip(BEYOND_LOBES_MAG) {
        assert!((extreme - documented).abs() < 0.1, "{found:?}");
    }
}

#[test]
fn valid_sigma_outside_the_fitted_geometry() {
    let Some(data) = crate::common::data_dir() else { return };
    let all = predictions(&data);
    let table = table(&all);
    println!("{table}");
    let [within, _, score, constant_score] = summary(&all.iter().collect::<Vec<_>>());
    assert!(WITHIN.contains(&within.mean) && score.mean - constant_score.mean >= LEAST_GAIN, "{table}");
    crate::common::assert_is_documented("outside-geometry.md", &table);
}

#[test]
#[ignore = "writes into the docs"]
fn write_outside_table() {
    let data = crate::common::data_dir().expect("the data folder");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/tables/outside-geometry.md");
    std::fs::write(path, table(&predictions(&data))).unwrap();
}
