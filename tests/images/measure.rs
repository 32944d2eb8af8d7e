//! Forced photometry of drawn streaks with known brightness, among random stars.

use std::ops::{Range, RangeInclusive};

use crate::common::is_all;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use streakcast::images::{LightArea, PixelPosition, Plane};
use streakcast::measure::{
    Background, Flag, MeasureOptions, PredictedStreak, StreakImage, StreakMeasurement, measure_streak, streak_cut,
};
use streakcast::streaks::{Optics, PathNode, RadialProfile, RandomStars, SeeingForm, StreakPath, background, draw};

mod delays;
mod faint;
mod forms;

// Required bounds, set before the first run.

/// Largest bias of the flux.
const FLUX_BIAS: f64 = 0.02;
/// Share of fluxes within one sigma, for the sample of docs/explanation/measuring.md and for its parts.
const WITHIN_ONE_SIGMA: RangeInclusive<f64> = 0.63..=0.73;
/// Probability of a false detection in a corridor (an option of the measurement), and the largest accepted share of
/// false detections: 2.4 sigmas above this probability in 600 corridors, 1.4 sigmas in 200.
const FALSE_ALARM: f64 = 0.01;
const FALSE_ALARMS: f64 = 0.02;
/// Smallest share of streaks found at a signal to noise of 10, and of 30.
const FOUND_AT_10: f64 = 0.95;
const FOUND_AT_30: f64 = 0.99;
/// Number of streaks in the whole sample at a signal to noise of 10.
const ALL_AT_10: usize = 480;

/// Returns the bounds of the share of fluxes within one sigma in a smaller sample: those above, widened by two standard
/// errors.
fn within_one_sigma_of(count: usize) -> RangeInclusive<f64> {
    let (least, most) = (*WITHIN_ONE_SIGMA.start(), *WITHIN_ONE_SIGMA.end());
    let share = 0.5 * (least + most);
    let margin = 2.0 * (share * (1.0 - share) / count as f64).sqrt();
    least - margin..=most + margin
}

const ROWS: usize = 320;
const COLUMNS: usize = 400;
const EXPOSURE_S: f64 = 30.0;
/// Electrons of the sky in a pixel, and read noise.
const SKY_E: f64 = 400.0;
const READ_E: f64 = 5.0;
/// Error of the predicted track: pixels across and seconds along.
const CROSS_PIX: f64 = 8.0;
const SPEED_PIX_S: f64 = 100.0;

#[derive(Copy, Clone, Debug)]
struct Case {
    /// Signal to noise of the streak without stars; 0 for no streak.
    signal_to_noise: f64,
    angle_deg: f64,
    /// FWHM, pixels.
    seeing_pix: f64,
    form: SeeingForm,
    stars_per_megapixel: f64,
    /// True if the shutter closes while the satellite is in the image.
    has_end: bool,
    seed: u64,
}

struct Outcome {
    case: Case,
    truth: f64,
    measured: StreakMeasurement,
    late_s: f64,
    offset_pix: f64,
}

fn optics(case: &Case) -> Optics {
    Optics { form: case.form, seeing_arcsec: case.seeing_pix, outer_radius_m: 0.0, inner_radius_m: 0.0 }
}

/// Draws a frame with one streak, and measures it at a predicted track that is wrong by random errors.
fn measured(case: Case, options: &MeasureOptions, assumed: Optics) -> Outcome {
    drawn(case, options, assumed).0
}

/// Same as `measured`, but also returns the frame.
fn drawn(case: Case, options: &MeasureOptions, assumed: Optics) -> (Outcome, Plane) {
    let Scene { plane, predicted, truth, late_s, offset_pix } = scene(case);
    let measured = measure(&plane, &LightArea::whole(ROWS, COLUMNS), &predicted, &assumed, options);
    let measured = measured.unwrap_or_else(|| panic!("no track: {case:?}"));
    (Outcome { case, truth, measured, late_s, offset_pix }, plane)
}

/// Frame with one streak, and its prediction.
struct Scene {
    plane: Plane,
    predicted: PredictedStreak,
    truth: f64,
    late_s: f64,
    offset_pix: f64,
}

/// Draws a frame with one streak, whose predicted track is wrong by random errors.
fn scene(case: Case) -> Scene {
    let mut random = ChaCha8Rng::seed_from_u64(case.seed);
    let mut normal =
        |sigma: f64| -> f64 { sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut random) };
    let profile = optics(&case).profile(600.0, 0.0, 1.0, 1.0).unwrap();
    let (sin, cos) = case.angle_deg.to_radians().sin_cos();
    let middle = PixelPosition { x: 0.5 * COLUMNS as f64 + normal(20.0), y: 0.5 * ROWS as f64 + normal(20.0) };
    // The middle is passed in the middle of the exposure, or shortly before its end.
    let middle_s = if case.has_end { EXPOSURE_S - 0.4 } else { 0.5 * EXPOSURE_S };
    let late_sigma_s = 0.1;
    let (late_s, offset_pix) = (normal(late_sigma_s).clamp(-0.25, 0.25), normal(CROSS_PIX).clamp(-20.0, 20.0));
    let at = |time_s: f64, across: f64| {
        let along = SPEED_PIX_S * (time_s - middle_s);
        PixelPosition { x: middle.x + cos * along - sin * across, y: middle.y + sin * along + cos * across }
    };
    // Length of the streak in the image.
    let inside = |time_s: f64| LightArea::whole(ROWS, COLUMNS).contains(at(time_s - late_s, offset_pix));
    let length_pix = (0..30_000).filter(|step| inside(f64::from(*step) * 1e-3)).count() as f64 * 1e-3 * SPEED_PIX_S;
    // Σ m² = L / (v² 2 √π s) for a Gaussian of standard deviation s.
    let spread = case.seeing_pix / 2.3548;
    let pixel_sigma = (SKY_E + READ_E * READ_E).sqrt();
    let squares = length_pix / (SPEED_PIX_S * SPEED_PIX_S * 2.0 * std::f64::consts::PI.sqrt() * spread);
    let truth = case.signal_to_noise * pixel_sigma / squares.sqrt();

    let stars = RandomStars {
        per_megapixel: case.stars_per_megapixel,
        slope: 0.3,
        brightest_mag: 13.0,
        faintest_mag: 20.0,
        zero_point_mag: 26.5,
    };
    let stars = stars.draw(ROWS, COLUMNS, 20.0, case.seed + 1).unwrap();
    let mut plane = background(ROWS, COLUMNS, SKY_E, &stars, &profile).unwrap();
    if truth > 0.0 {
        let nodes = [0.0, EXPOSURE_S].map(|time_s| PathNode::new(time_s, at(time_s - late_s, offset_pix), truth));
        draw(&StreakPath::new(nodes.to_vec()).unwrap(), &profile, ROWS, COLUMNS).add_to(&mut plane);
    }
    for value in plane.values_mut() {
        let mean = f64::from(*value);
        *value = (mean + normal((mean + READ_E * READ_E).sqrt())) as f32;
    }
    let nodes = [-2.0, EXPOSURE_S + 2.0].map(|time_s| PathNode::new(time_s, at(time_s, 0.0), 1.0));
    let predicted = PredictedStreak {
        path: StreakPath::new(nodes.to_vec()).unwrap(),
        drift_pix_s: [0.0; 2],
        lateness_sigma_s: late_sigma_s,
        largest_delay_s: 5.0,
        ends_s: None,
        cross_sigma_pix: CROSS_PIX,
        range_km: 600.0,
        radius_m: 0.0,
        radius_sigma_m: 0.0,
    };
    Scene { plane, predicted, truth, late_s, offset_pix }
}

fn measure(
    plane: &Plane,
    light_area: &LightArea,
    predicted: &PredictedStreak,
    optics: &Optics,
    options: &MeasureOptions,
) -> Option<StreakMeasurement> {
    let sky = Background::new(plane, light_area);
    measure_streak(&image_of(plane, &sky, light_area), predicted, optics, options).unwrap()
}

fn image_of<'a>(plane: &'a Plane, background: &'a Background, light_area: &'a LightArea) -> StreakImage<'a> {
    StreakImage {
        plane,
        background,
        light_area,
        exposure_s: EXPOSURE_S,
        electrons_per_unit: Some(1.0),
        saturation: None,
        pixel_scale_arcsec: 1.0,
        pixel_aspect: 1.0,
    }
}

/// Draws streaks on a sky with this mean and scatter.
fn on_noisy_sky(
    streaks: &[StreakPath],
    profile: &RadialProfile,
    [rows, columns]: [usize; 2],
    [mean, scatter]: [f64; 2],
    seed: u64,
) -> Plane {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut plane = Plane::zeros(rows, columns);
    for path in streaks {
        draw(path, profile, rows, columns).add_to(&mut plane);
    }
    for value in plane.values_mut() {
        let noise: f64 = StandardNormal.sample(&mut random);
        *value += (mean + scatter * noise) as f32;
    }
    plane
}

/// Returns the prediction of a point source at 600 km without errors.
fn point_source(path: StreakPath) -> PredictedStreak {
    PredictedStreak {
        path,
        drift_pix_s: [0.0; 2],
        lateness_sigma_s: 0.0,
        largest_delay_s: 0.0,
        ends_s: None,
        cross_sigma_pix: 0.0,
        range_km: 600.0,
        radius_m: 0.0,
        radius_sigma_m: 0.0,
    }
}

fn options() -> MeasureOptions {
    MeasureOptions { false_alarm: FALSE_ALARM, is_form_known: true, ..MeasureOptions::default() }
}

const BRIGHTNESS: [f64; 4] = [10.0, 30.0, 100.0, 400.0];
const ANGLES_DEG: [f64; 4] = [3.0, 30.0, 52.0, 88.0];
const SEEING_PIX: [f64; 3] = [2.2, 4.0, 7.0];
const STARS: [f64; 3] = [0.0, 100.0, 1000.0];

/// All combinations of brightness, angle, seeing and crowding, or every n-th of them. Repeats differ in form and end.
fn grid(repeats: Range<u64>, step: usize) -> Vec<Outcome> {
    let mut cases = Vec::new();
    for signal_to_noise in BRIGHTNESS {
        for angle_deg in ANGLES_DEG {
            for (number, seeing_pix) in SEEING_PIX.into_iter().enumerate() {
                for stars_per_megapixel in STARS {
                    for repeat in repeats.clone() {
                        let form =
                            if repeat % 2 == 0 { SeeingForm::Gaussian } else { SeeingForm::Moffat { beta: 3.5 } };
                        let seed = 1000 * cases.len() as u64 + number as u64;
                        let has_end = repeat % 4 >= 2;
                        cases.push(Case {
                            signal_to_noise,
                            angle_deg,
                            seeing_pix,
                            form,
                            stars_per_megapixel,
                            has_end,
                            seed,
                        });
                    }
                }
            }
        }
    }
    cases.into_par_iter().step_by(step).map(|case| measured(case, &options(), optics(&case))).collect()
}

/// Mean relative error of the flux, its standard error, and share within one sigma, of the detected streaks.
fn bias_and_share<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> (f64, f64, f64, usize) {
    let found: Vec<&Outcome> = outcomes.filter(|outcome| outcome.measured.is_detected).collect();
    let errors: Vec<f64> = found.iter().map(|one| one.measured.rate.value / one.truth - 1.0).collect();
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let scatter = (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count).sqrt();
    let within =
        found.iter().filter(|one| (one.measured.rate.value - one.truth).abs() <= one.measured.rate.sigma).count();
    (mean, scatter / count.sqrt(), within as f64 / count, found.len())
}

/// Name of a sample, and its streaks.
type Sample<'a> = (String, Vec<&'a Outcome>);

/// The whole sample and parts of it.
fn parts(outcomes: &[Outcome]) -> Vec<Sample<'_>> {
    let part = |name: &str, is_in: &dyn Fn(&Case) -> bool| {
        (name.to_owned(), outcomes.iter().filter(|one| is_in(&one.case)).collect::<Vec<_>>())
    };
    let mut parts = vec![
        part("all", &|_| true),
        part("Gaussian profile", &|case| case.form == SeeingForm::Gaussian),
        part("Moffat profile", &|case| case.form != SeeingForm::Gaussian),
        part("with an end in the frame", &|case| case.has_end),
    ];
    type Key = fn(&Case) -> f64;
    let keys: [(&str, &[f64], Key); 4] = [
        ("signal to noise", &BRIGHTNESS, |case| case.signal_to_noise),
        ("angle to the rows, deg:", &ANGLES_DEG, |case| case.angle_deg),
        ("seeing, pixels:", &SEEING_PIX, |case| case.seeing_pix),
        ("stars per megapixel:", &STARS, |case| case.stars_per_megapixel),
    ];
    for (name, values, key) in keys {
        parts.extend(values.iter().map(|value| part(&format!("{name} {value}"), &|case| key(case) == *value)));
    }
    parts
}

/// Checks the bounds of samples, and prints the lines of the table of docs/explanation/measuring.md.
fn check_fluxes(samples: &[Sample], within_one_sigma: &RangeInclusive<f64>) {
    let mut failures = Vec::new();
    for (name, outcomes) in samples {
        let (bias, error, share, found) = bias_and_share(outcomes.iter().copied());
        print_row(name, [bias, error, share], found, outcomes.len());
        if bias.abs() >= FLUX_BIAS || !within_one_sigma.contains(&share) {
            failures.push(name);
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}

/// Prints a line of the table of docs/explanation/measuring.md: bias of the flux, its standard error and the share
/// within one sigma as fractions, and the number of detected streaks of all.
fn print_row(name: &str, fractions: [f64; 3], found: usize, all: usize) {
    let [bias, error, share] = fractions.map(|fraction| 100.0 * fraction);
    println!("| {name} | {bias:+.1} ± {error:.1} % | {share:.1} % | {found} of {all} |");
}

/// Checks the share of streaks found, except among 1,000 stars per megapixel, where the search is not complete at these
/// ratios of signal to noise (docs/explanation/measuring.md).
fn check_completeness(outcomes: &[Outcome]) {
    for (signal_to_noise, least) in [(10.0, FOUND_AT_10), (30.0, FOUND_AT_30)] {
        let is_selected = |case: &Case| case.signal_to_noise == signal_to_noise && case.stars_per_megapixel < 1000.0;
        let of: Vec<&Outcome> = outcomes.iter().filter(|one| is_selected(&one.case)).collect();
        let found = of.iter().filter(|one| one.measured.is_detected).count() as f64 / of.len() as f64;
        assert!(found >= least, "found {found} at {signal_to_noise}");
    }
}

/// `fluxes_of_many` has more streaks.
#[test]
fn verif_flux_is_unbiased_and_errors_are_honest() {
    // Moffat profiles without an end in the frame, and Gaussian ones with an end: 288 streaks, or every third of them.
    let outcomes = grid(1..3, if is_all() { 1 } else { 3 });
    check_fluxes(&[("all".to_owned(), outcomes.iter().collect())], &within_one_sigma_of(outcomes.len()));
}

/// Prints the table of docs/explanation/measuring.md, which docs/tables.sh collects.
#[test]
#[ignore = "some 2,600 streaks"]
fn fluxes_of_many() {
    println!("| streaks | bias of the flux | within one sigma | found |\n|---|---|---|---|");
    let outcomes = grid(0..10, 1);
    check_fluxes(&parts(&outcomes), &WITHIN_ONE_SIGMA);
    check_completeness(&outcomes);
    check_a_low_signal_to_noise(ALL_AT_10);
    check_a_fitted_width();
    check_false_detections(600);
}

/// Signal to noise, seeing and density of stars of the cells in which the share within one sigma is tested.
const COVERAGE_SIGNALS: [f64; 4] = [8.0, 20.0, 60.0, 300.0];
const COVERAGE_SEEING_PIX: [f64; 5] = [0.8, 1.2, 2.0, 3.5, 6.0];
/// Number of streaks in a cell.
const COVERAGE_COUNT: u64 = 100;

/// Measures the streaks of a cell, at all angles, half of them with a Moffat profile and half with an end in the frame.
fn cell(signal_to_noise: f64, seeing_pix: f64, stars_per_megapixel: f64, count: u64) -> Vec<Outcome> {
    let case = |number: u64| Case {
        signal_to_noise,
        angle_deg: (number * 37 % 180) as f64 + 0.5,
        seeing_pix,
        form: if number.is_multiple_of(2) { SeeingForm::Gaussian } else { SeeingForm::Moffat { beta: 3.5 } },
        stars_per_megapixel,
        has_end: number % 4 >= 2,
        seed: 7_000_000 + 1000 * number + (10.0 * seeing_pix) as u64,
    };
    (0..count).into_par_iter().map(|number| measured(case(number), &options(), optics(&case(number)))).collect()
}

/// Prints the share of fluxes within one sigma, with its binomial error, and the share with the flag `width`, by
/// density of stars, seeing and signal to noise. The share of each row must be that of one sigma.
#[test]
#[ignore = "some 6,000 streaks"]
fn coverage_of_many() {
    let names = COVERAGE_SIGNALS.map(|signal| format!("signal to noise {signal}"));
    println!("| stars per megapixel | seeing, pixels | {} | all | `width` |", names.join(" | "));
    println!("|---|---|{}---|---|", "---|".repeat(names.len()));
    let mut failures = Vec::new();
    for stars_per_megapixel in STARS.into_iter().rev() {
        for seeing_pix in COVERAGE_SEEING_PIX {
            let cells = COVERAGE_SIGNALS.map(|signal| cell(signal, seeing_pix, stars_per_megapixel, COVERAGE_COUNT));
            let text = |outcomes: &[&Outcome]| {
                let (.., share, found) = bias_and_share(outcomes.iter().copied());
                let error = (share * (1.0 - share) / found as f64).sqrt();
                (share, found, format!("{:.0} ± {:.0} % of {found}", 100.0 * share, 100.0 * error))
            };
            let shown: Vec<String> = cells.iter().map(|cell| text(&cell.iter().collect::<Vec<_>>()).2).collect();
            let all: Vec<&Outcome> = cells.iter().flatten().filter(|one| one.measured.is_detected).collect();
            let (share, found, row) = text(&all);
            let flagged = all.iter().filter(|one| one.measured.flags.contains(&Flag::Width)).count();
            let flagged = 100.0 * flagged as f64 / found as f64;
            println!("| {stars_per_megapixel} | {seeing_pix} | {} | {row} | {flagged:.1} % |", shown.join(" | "));
            if !within_one_sigma_of(found).contains(&share) || flagged > 100.0 * WRONG_WIDTHS {
                failures.push((stars_per_megapixel, seeing_pix));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}

/// Largest share of streaks with exactly the given seeing that have the flag `width`.
const WRONG_WIDTHS: f64 = 0.03;

/// The width of faint and narrow streaks has a large error, so that it differs from the right one by chance.
#[test]
fn verif_streaks_with_the_given_seeing_have_no_flag_of_the_width() {
    let outcomes = cell(20.0, 0.8, 0.0, 40);
    let flagged = outcomes.iter().filter(|one| one.measured.flags.contains(&Flag::Width)).count();
    assert!(flagged as f64 <= WRONG_WIDTHS * outcomes.len() as f64, "{flagged}");
    // A wrong seeing is flagged.
    let case = Case { seed: 5, ..outcomes[0].case };
    let case = Case { signal_to_noise: 100.0, seeing_pix: 3.0, angle_deg: 20.0, has_end: false, ..case };
    let assumed = Optics { seeing_arcsec: 2.0, ..optics(&case) };
    assert!(measured(case, &options(), assumed).measured.flags.contains(&Flag::Width));
}

/// Where the profile of a streak has other wings than the assumed one, the error of the flux contains the difference.
#[test]
fn verif_a_wrong_form_of_the_profile_is_part_of_the_error() {
    let moffat = SeeingForm::Moffat { beta: 3.5 };
    for (form, assumed) in [(moffat, SeeingForm::Gaussian), (SeeingForm::Gaussian, moffat)] {
        for seeing_pix in [2.2, 4.0] {
            for seed in 0..4 {
                let case = Case {
                    signal_to_noise: 300.0,
                    angle_deg: 20.0 + 40.0 * seed as f64,
                    seeing_pix,
                    form,
                    stars_per_megapixel: 0.0,
                    has_end: false,
                    seed: 4000 + seed,
                };
                let outcome = measured(case, &options(), Optics { form: assumed, ..optics(&case) });
                let (rate, stated) = (outcome.measured.rate, outcome.measured.form_sigma);
                let error = (rate.value / outcome.truth - 1.0).abs();
                println!("{form:?} {seeing_pix}: off by {error:.3}, stated {:.3}", rate.sigma / outcome.truth);
                assert!(error > 0.02 && error * outcome.truth <= 2.0 * rate.sigma, "{error} {rate:?}");
                assert!(stated > 0.5 * error * outcome.truth, "{stated} {error}");
                // With the right form the error is that of the noise.
                let right = measured(case, &options(), optics(&case)).measured;
                assert!(right.form_sigma < 0.3 * stated, "{} {stated}", right.form_sigma);
            }
        }
    }
}

/// At a low signal to noise the fitted position follows the noise, for which the flux is corrected. Nearly all of these
/// streaks are found, so that the selection by detection does not bias the mean.
fn check_a_low_signal_to_noise(count: usize) {
    /// Smallest difference of the uncorrected flux from the truth, in standard errors: the correction is needed.
    const UNCORRECTED_ERRORS: f64 = 2.0;
    let cases: Vec<Case> = [0.0, 100.0].into_iter().flat_map(|stars| cases_at(10.0, stars, count / 2)).collect();
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let (bias, error, share, found) = bias_and_share(outcomes.iter());
    let uncorrected = |one: &Outcome| one.measured.signal_to_noise * one.measured.rate.sigma / one.truth - 1.0;
    let detected = outcomes.iter().filter(|one| one.measured.is_detected);
    let before = detected.map(uncorrected).sum::<f64>() / found as f64;
    print_row("signal to noise 10, 0 and 100 stars", [bias, error, share], found, count);
    println!("| the same without the correction for the fitted position | {:+.1} % | | |", 100.0 * before);
    assert!(bias.abs() < FLUX_BIAS, "{bias}");
    // In a smaller sample the standard error is too large to see the correction.
    assert!(count < ALL_AT_10 || before > UNCORRECTED_ERRORS * error, "{before}, {error}");
    assert!(found as f64 >= FOUND_AT_10 * count as f64, "{found}");
}

#[test]
fn verif_flux_at_a_low_signal_to_noise_is_unbiased() {
    check_a_low_signal_to_noise(if is_all() { ALL_AT_10 } else { 192 });
}

/// Corridors without a streak, a third of them among 1,000 stars per megapixel.
fn check_false_detections(count: usize) {
    let cases: Vec<Case> = (0..count)
        .map(|number: usize| Case {
            signal_to_noise: 0.0,
            angle_deg: ANGLES_DEG[number % 4],
            seeing_pix: SEEING_PIX[(number / 4) % 3],
            form: SeeingForm::Gaussian,
            stars_per_megapixel: STARS[(number / 12) % 3],
            has_end: false,
            seed: 7_000_000 + 10 * number as u64,
        })
        .collect();
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let found = outcomes.iter().filter(|one| one.measured.is_detected).count();
    println!("| no streak | | | {found} of {count} |");
    assert!(found as f64 <= FALSE_ALARMS * count as f64, "{found}");
    // Upper limits are above the rate, which is 0.
    assert!(outcomes.iter().all(|one| one.measured.rate_limit > 0.0));
}

#[test]
fn verif_false_detections_are_rare() {
    check_false_detections(if is_all() { 200 } else { 100 });
}

/// Offset and delay agree with the truth within their errors.
#[test]
fn verif_offsets_and_delays_are_measured() {
    /// Smallest share within three sigmas plus a hundredth of a pixel.
    const WITHIN_THREE_SIGMAS: f64 = 0.97;
    let cases = (0..120).map(|number: usize| Case {
        signal_to_noise: 60.0,
        angle_deg: ANGLES_DEG[number % 4],
        seeing_pix: 4.0,
        form: SeeingForm::Gaussian,
        stars_per_megapixel: 0.0,
        has_end: true,
        seed: 9_000_000 + 10 * number as u64,
    });
    let cases: Vec<Case> = cases.collect();
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let of = |difference: fn(&Outcome) -> Option<(f64, f64, f64)>| {
        let all: Vec<(f64, f64, f64)> = outcomes.iter().filter_map(difference).collect();
        let within = all.iter().filter(|(error, sigma, margin)| error.abs() <= 3.0 * sigma + margin).count();
        (all.len(), within as f64 / all.len() as f64)
    };
    let (delays, delays_within) = of(|one| {
        let late = one.measured.late_s?;
        Some((late.value - one.late_s, late.sigma, 0.01 / SPEED_PIX_S))
    });
    let (offsets, offsets_within) = of(|one| {
        // Positive offsets of the library have larger y, or larger x for steep tracks.
        let sense = if one.case.angle_deg > 45.0 { -1.0 } else { 1.0 };
        let (offset, truth) = (one.measured.offset_pix, sense * one.offset_pix);
        // The offset is measured at the middle of the corridor, where a tilt does not change it.
        Some((offset.value - truth, offset.sigma, 0.01 + 20.0 * one.measured.tilt_rad.abs()))
    });
    println!("{delays} delays, {delays_within} within; {offsets} offsets, {offsets_within} within");
    assert!(delays >= 100 && offsets == 120);
    assert!(delays_within >= WITHIN_THREE_SIGMAS && offsets_within >= WITHIN_THREE_SIGMAS);
}

#[test]
fn verif_a_fitted_width_replaces_a_wrong_seeing() {
    check_a_fitted_width();
}

/// With a given seeing that is wrong by 20 %, the fit of the width restores the flux.
fn check_a_fitted_width() {
    let cases: Vec<Case> = (0..60)
        .map(|number: usize| Case {
            signal_to_noise: 150.0,
            angle_deg: ANGLES_DEG[number % 4],
            seeing_pix: 4.0,
            form: SeeingForm::Gaussian,
            stars_per_megapixel: 0.0,
            has_end: false,
            seed: 8_000_000 + 10 * number as u64,
        })
        .collect();
    let fitted = MeasureOptions { fit_width: true, ..options() };
    let outcomes: Vec<Outcome> = cases
        .into_par_iter()
        .map(|case| measured(case, &fitted, Optics { seeing_arcsec: 1.2 * case.seeing_pix, ..optics(&case) }))
        .collect();
    let (bias, error, share, found) = bias_and_share(outcomes.iter());
    print_row("given seeing 20 % too large, width fitted", [bias, error, share], found, outcomes.len());
    assert!(found == 60 && bias.abs() < FLUX_BIAS, "{bias}");
    assert!(outcomes.iter().all(|one| (one.measured.seeing_arcsec.unwrap() / 4.0 - 1.0).abs() < 0.05));
}

/// Streaks that are four times wider than the assumed seeing, as those of defocused satellites, are measured whole:
/// their wings are not masked as stars.
#[test]
fn verif_streaks_much_wider_than_the_seeing_are_measured() {
    const COUNT: usize = 40;
    /// Smallest number of streaks that are found, and largest error of each width.
    const FOUND: usize = 39;
    const WIDTH: f64 = 0.1;
    let cases: Vec<Case> = (0..COUNT)
        .map(|number: usize| Case {
            signal_to_noise: 150.0,
            angle_deg: ANGLES_DEG[number % 4],
            seeing_pix: 16.0,
            form: SeeingForm::Gaussian,
            stars_per_megapixel: if number < COUNT / 2 { 0.0 } else { 100.0 },
            has_end: false,
            seed: 8_500_000 + 10 * number as u64,
        })
        .collect();
    let fitted = MeasureOptions { fit_width: true, ..options() };
    let outcomes: Vec<Outcome> = cases
        .into_par_iter()
        .map(|case| measured(case, &fitted, Optics { seeing_arcsec: 4.0, ..optics(&case) }))
        .collect();
    let (bias, _, _, found) = bias_and_share(outcomes.iter());
    println!("four times wider: bias {:.2} %, found {found} of {COUNT}", 100.0 * bias);
    assert!(found >= FOUND && bias.abs() < FLUX_BIAS, "{found}, {bias}");
    let found = outcomes.iter().filter(|one| one.measured.is_detected);
    for (case, seeing) in found.map(|one| (one.case, one.measured.seeing_arcsec)) {
        assert!((seeing.unwrap() / case.seeing_pix - 1.0).abs() < WIDTH, "{case:?}: {seeing:?}");
    }
}

/// Bright streaks that the mask of the frame covers are neither found nor excluded, and dark streaks are not found in
/// the contrast beside them.
#[test]
fn verif_hidden_and_dark_streaks_have_no_limit() {
    let light_area = LightArea::whole(ROWS, COLUMNS);
    for (number, angle_deg) in ANGLES_DEG.into_iter().enumerate() {
        for signal_to_noise in [30.0, 400.0, 4000.0] {
            let case = Case {
                signal_to_noise,
                angle_deg,
                seeing_pix: 3.0,
                form: SeeingForm::Gaussian,
                stars_per_megapixel: 100.0,
                has_end: number % 2 == 1,
                seed: 9_000_000 + 10 * number as u64,
            };
            let Scene { plane, predicted, .. } = scene(case);
            let (found, _) = drawn(case, &options(), optics(&case));
            let clear = found.measured;
            assert!(clear.is_detected && !clear.flags.contains(&Flag::Masked) && !clear.flags.contains(&Flag::Dark));
            // The mask reaches to the given distance from the track.
            for half_width_pix in [1.5, 3.0, 4.0, 8.0] {
                let mut masked = plane.clone();
                let [from, to] = clear.ends_in_frame();
                let length_pix = from.distance(to);
                for (index, value) in masked.values_mut().iter_mut().enumerate() {
                    let (x, y) = ((index % COLUMNS) as f64, (index / COLUMNS) as f64);
                    let across = ((x - from.x) * (to.y - from.y) - (y - from.y) * (to.x - from.x)) / length_pix;
                    if across.abs() < half_width_pix {
                        *value = f32::NAN;
                    }
                }
                let one = measure(&masked, &light_area, &predicted, &optics(&case), &options()).unwrap();
                let message = format!("{case:?}, {half_width_pix}: {:?}", one.flags);
                assert!(one.flags.contains(&Flag::Masked) && !one.flags.contains(&Flag::Dark), "{message}");
                assert!(!one.is_detected, "{message}");
            }
            // The frame with negative light.
            let mut dark = plane.clone();
            dark.values_mut().iter_mut().for_each(|value| *value = 2.0 * SKY_E as f32 - *value);
            let one = measure(&dark, &light_area, &predicted, &optics(&case), &options()).unwrap();
            assert!(!one.is_detected && one.flags.contains(&Flag::Dark), "{case:?}: {:?}", one.flags);
        }
    }
}

/// A bright streak a few pixels from the edge of the frame is found with its flux.
#[test]
fn verif_streaks_beside_the_edge_are_found() {
    /// Largest relative error of the flux.
    const ERROR: f64 = 0.05;
    let profile = Optics { form: SeeingForm::Gaussian, seeing_arcsec: 3.0, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let drawn_with = profile.profile(600.0, 0.0, 1.0, 1.0).unwrap();
    for (number, edge_pix) in [2.0, 4.0, 7.0, COLUMNS as f64 - 4.0].into_iter().enumerate() {
        let light_area = LightArea::whole(ROWS, COLUMNS);
        let path = |rate: f64| {
            let ends = [(0.0, 60.0), (EXPOSURE_S, 260.0)];
            let nodes = ends.map(|(time_s, y)| PathNode::new(time_s, PixelPosition { x: edge_pix, y }, rate));
            StreakPath::new(nodes.to_vec()).unwrap()
        };
        let plane = on_noisy_sky(&[path(6000.0)], &drawn_with, [ROWS, COLUMNS], [1000.0, 10.0], number as u64);
        let predicted = PredictedStreak {
            largest_delay_s: 5.0,
            ends_s: Some([0.0, EXPOSURE_S]),
            cross_sigma_pix: 2.0,
            ..point_source(path(1.0))
        };
        // Also with a border of two masked columns, as of an amplifier, outside of the light of the streak.
        let mut with_border = plane.clone();
        with_border.values_mut().chunks_exact_mut(COLUMNS).for_each(|row| row[..2].fill(f32::NAN));
        for plane in [Some(plane), (number == 2).then_some(with_border)].into_iter().flatten() {
            let one = measure(&plane, &light_area, &predicted, &profile, &options()).unwrap();
            assert!(one.is_detected, "{edge_pix}: {} of {}", one.significance, one.threshold);
            assert!((one.rate.value / 6000.0 - 1.0).abs() < ERROR, "{edge_pix}: {:?}", one.rate);
        }
    }
}

/// Streaks narrower than a pixel are measured whole: the fit does not stay beside the streak.
#[test]
fn verif_streaks_narrower_than_a_pixel_are_measured_whole() {
    /// Largest mean square of the errors in sigmas, and largest error.
    const SQUARES: f64 = 1.3;
    const SIGMAS: f64 = 4.5;
    let case = |number: usize| Case {
        signal_to_noise: [12.0, 18.0][number % 2],
        angle_deg: (37 * number % 180) as f64,
        seeing_pix: 0.8,
        form: SeeingForm::Gaussian,
        stars_per_megapixel: 0.0,
        has_end: false,
        seed: 9_500_000 + 10 * number as u64,
    };
    let cases: Vec<Case> = (0..200).map(case).collect();
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let found = outcomes.iter().filter(|one| one.measured.is_detected);
    let errors: Vec<f64> = found.map(|one| (one.measured.rate.value - one.truth) / one.measured.rate.sigma).collect();
    let squares = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    let most = errors.iter().fold(0.0f64, |most, error| most.max(error.abs()));
    println!("narrow streaks: {} found, mean square {squares:.2}, largest {most:.1}", errors.len());
    assert!(errors.len() > 190 && squares < SQUARES && most < SIGMAS, "{}: {squares}, {most}", errors.len());
}

/// The profile of the pixels along a track is that of the fitted streak, for all directions of motion.
#[test]
fn verif_profiles_across_the_track_are_those_of_the_fit() {
    /// Largest difference: the sum of this number of sigmas and this share of the peak.
    const SIGMAS: f64 = 5.0;
    const OF_PEAK: f64 = 0.03;
    for angle_deg in [0.0, 3.0, 52.0, 88.0, 160.0, 250.0] {
        let case = Case {
            signal_to_noise: 400.0,
            angle_deg,
            seeing_pix: 4.0,
            form: SeeingForm::Gaussian,
            stars_per_megapixel: 0.0,
            has_end: false,
            seed: 30 + angle_deg as u64,
        };
        let (outcome, plane) = drawn(case, &options(), optics(&case));
        let light_area = LightArea::whole(ROWS, COLUMNS);
        let sky = Background::new(&plane, &light_area);
        let profile = optics(&case).profile(600.0, 0.0, 1.0, 1.0).unwrap();
        let cut = streak_cut(&image_of(&plane, &sky, &light_area), &outcome.measured, &profile);
        let rows = cut.across_pix.len();
        assert_eq!((cut.profile.len(), cut.values.len()), (rows, rows * cut.columns));
        let peak = cut.model.iter().copied().fold(0.0, f64::max);
        for row in 0..rows {
            let difference = cut.profile[row] - cut.model[row];
            let most = SIGMAS * cut.profile_sigma[row] + OF_PEAK * peak;
            assert!(difference.abs() <= most, "{angle_deg}: row {row}: {} and {}", cut.profile[row], cut.model[row]);
        }
        assert!(cut.profile[rows / 2] > 0.9 * peak);
    }
}

/// Returns streaks among stars with one signal to noise, which differ in angle, seeing, form and errors of the
/// prediction.
fn cases_at(signal_to_noise: f64, stars_per_megapixel: f64, count: usize) -> Vec<Case> {
    let case = |number: usize| Case {
        signal_to_noise,
        angle_deg: ANGLES_DEG[number % 4],
        seeing_pix: SEEING_PIX[(number / 4) % 3],
        form: if (number / 12).is_multiple_of(2) { SeeingForm::Gaussian } else { SeeingForm::Moffat { beta: 3.5 } },
        stars_per_megapixel,
        has_end: (number / 24) % 2 == 1,
        seed: 20_000_000 + 1000 * (10.0 * signal_to_noise) as u64 + 10 * number as u64 + stars_per_megapixel as u64,
    };
    (0..count).map(case).collect()
}

/// Shares of streaks that are found at their place, and of detections at another place.
fn completeness(cases: Vec<Case>) -> (f64, f64) {
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let is_at_its_place = |one: &&Outcome| {
        let sense = if one.case.angle_deg > 45.0 { -1.0 } else { 1.0 };
        let away_pix = one.measured.offset_pix.value - sense * one.offset_pix;
        one.case.signal_to_noise > 0.0 && away_pix.abs() <= 1.5 * one.case.seeing_pix
    };
    let count = outcomes.len() as f64;
    let found: Vec<&Outcome> = outcomes.iter().filter(|one| one.measured.is_detected).collect();
    let right = found.iter().copied().filter(is_at_its_place).count();
    (right as f64 / count, (found.len() - right) as f64 / count)
}

/// Completeness rises from a few to all streaks with the signal to noise, and detections elsewhere are rare.
///
/// Bounds were set before the first run. `completeness_of_many` has more streaks.
#[test]
fn verif_completeness_rises_with_the_signal_to_noise() {
    const COUNT: usize = 48;
    /// Signal to noise, and smallest and largest share that is found.
    const FOUND: [(f64, [f64; 2]); 4] =
        [(3.0, [0.0, 0.2]), (6.0, [0.3, 1.0]), (12.0, [0.95, 1.0]), (25.0, [0.98, 1.0])];
    const ELSEWHERE: f64 = 0.03;
    for stars_per_megapixel in if is_all() { &[100.0, 0.0][..] } else { &[100.0] } {
        let stars_per_megapixel = *stars_per_megapixel;
        let mut wrong = 0.0;
        for (signal_to_noise, [least, most]) in FOUND {
            let (found, elsewhere) = completeness(cases_at(signal_to_noise, stars_per_megapixel, COUNT));
            println!(
                "{stars_per_megapixel} stars, signal to noise {signal_to_noise}: {found:.3}, elsewhere {elsewhere:.3}"
            );
            assert!((least..=most).contains(&found), "{stars_per_megapixel}, {signal_to_noise}: {found}");
            wrong += elsewhere / FOUND.len() as f64;
        }
        assert!(wrong <= ELSEWHERE, "{stars_per_megapixel}: {wrong}");
    }
}

/// Prints the table from which docs/completeness.py draws curves: the lines that begin with `|`.
///
/// `cargo test --release --test images completeness_of_many -- --ignored --nocapture | grep '^|'
/// > docs/tables/completeness.md`
#[test]
#[ignore = "some 10,000 streaks"]
fn completeness_of_many() {
    const COUNT: usize = 288;
    let numbers = |of: &dyn Fn(f64) -> String| STARS.map(of).join(" | ");
    println!("| signal to noise | {} |", numbers(&|stars| format!("found, elsewhere: {stars} stars")));
    println!("|---|{}", "---|".repeat(STARS.len()));
    for signal_to_noise in [0.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 50.0] {
        let cell = |stars: f64| {
            let (found, elsewhere) = completeness(cases_at(signal_to_noise, stars, COUNT));
            format!("{:.1} %, {:.1} %", 100.0 * found, 100.0 * elsewhere)
        };
        println!("| {signal_to_noise} | {} |", numbers(&cell));
    }
}

/// The error of an assumed size is half of the difference of the fluxes with the sizes one sigma away. If the width is
/// fitted, it depends only on the shape of the light.
#[test]
fn verif_the_error_of_an_assumed_size_is_part_of_that_of_the_flux() {
    let optics = Optics { form: SeeingForm::Gaussian, seeing_arcsec: 2.5, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    // 10 m at 600 km are 3.4 pixels.
    let profile = optics.profile(600.0, 5.0, 1.0, 1.0).unwrap();
    let at =
        |time_s: f64| PixelPosition { x: 200.0 + SPEED_PIX_S * (time_s - 15.0), y: 150.0 + 20.0 * (time_s - 15.0) };
    let path = |[from_s, to_s]: [f64; 2], rate: f64| {
        StreakPath::new([from_s, to_s].map(|time_s| PathNode::new(time_s, at(time_s), rate)).to_vec()).unwrap()
    };
    const RATE: f64 = 2e5;
    let mut plane = Plane::from_values(ROWS, COLUMNS, vec![SKY_E as f32; ROWS * COLUMNS]).unwrap();
    draw(&path([0.0, EXPOSURE_S], RATE), &profile, ROWS, COLUMNS).add_to(&mut plane);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for value in plane.values_mut() {
        *value += 20.0 * <StandardNormal as Distribution<f32>>::sample(&StandardNormal, &mut random);
    }
    let light_area = LightArea::whole(ROWS, COLUMNS);
    let found = |radius_m: f64, radius_sigma_m: f64, fit_width: bool| {
        let predicted = PredictedStreak {
            path: path([-2.0, EXPOSURE_S + 2.0], 1.0),
            drift_pix_s: [0.0; 2],
            lateness_sigma_s: 0.1,
            largest_delay_s: 5.0,
            ends_s: None,
            cross_sigma_pix: CROSS_PIX,
            range_km: 600.0,
            radius_m,
            radius_sigma_m,
        };
        measure(&plane, &light_area, &predicted, &optics, &MeasureOptions { fit_width, ..options() }).unwrap()
    };
    let (exact, small, large) = (found(5.0, 0.0, false), found(2.5, 0.0, false), found(7.5, 0.0, false));
    let assumed = found(5.0, 2.5, false);
    assert_eq!(exact.size_sigma, 0.0);
    assert_eq!(assumed.rate.value, exact.rate.value);
    let half = 0.5 * (large.rate.value - small.rate.value);
    assert!(half > 0.05 * RATE && (assumed.size_sigma / half - 1.0).abs() < 0.1, "{} {half}", assumed.size_sigma);
    assert!((assumed.rate.sigma / exact.rate.sigma.hypot(assumed.size_sigma) - 1.0).abs() < 1e-9);
    // The signal to noise, which decides about the detection, does not contain it.
    assert_eq!(assumed.signal_to_noise, exact.signal_to_noise);
    let fitted = found(5.0, 2.5, true);
    assert!(fitted.size_sigma < 0.3 * assumed.size_sigma, "{} {}", fitted.size_sigma, assumed.size_sigma);
}

/// The star mask has no pixels of a streak: bright streaks, whose errors of position and profile are many times the
/// noise, have their flux, also beside another bright streak.
#[test]
fn verif_bright_streaks_are_measured_whole() {
    /// Largest relative error of a flux.
    const FLUX: f64 = 0.03;
    let mut cases = Vec::new();
    for signal_to_noise in [1e3, 1e4, 1e5, 1e6] {
        for (number, seeing_pix) in [1.05, 2.2, 4.0, 7.0].into_iter().enumerate() {
            for (angle, angle_deg) in ANGLES_DEG.into_iter().enumerate() {
                let form =
                    if (number + angle) % 2 == 0 { SeeingForm::Gaussian } else { SeeingForm::Moffat { beta: 3.5 } };
                let seed = 8_700_000 + 10 * cases.len() as u64;
                cases.push(Case {
                    signal_to_noise,
                    angle_deg,
                    seeing_pix,
                    form,
                    stars_per_megapixel: 0.0,
                    has_end: angle == 1,
                    seed,
                });
            }
        }
    }
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let failed = |one: &&Outcome| {
        let measured = &one.measured;
        !measured.is_detected
            || (measured.rate.value / one.truth - 1.0).abs() > FLUX
            || measured.flags.contains(&Flag::Masked)
    };
    for one in outcomes.iter().filter(failed) {
        println!("{:?}: {} {:?}", one.case, one.measured.rate.value / one.truth, one.measured.flags);
    }
    assert_eq!(outcomes.iter().filter(failed).count(), 0, "of {}", outcomes.len());
}

/// A bright streak in a corner of the frame has its flux also if another one of the same brightness ends 77 pixels from
/// it at the edge of the frame.
#[test]
fn verif_a_bright_streak_beside_another_has_its_flux() {
    /// Largest relative error of a flux, and light per second of each streak.
    const FLUX: f64 = 0.03;
    const RATE: f64 = 800_000.0;
    const SIDE: usize = 400;
    let optics = Optics {
        form: SeeingForm::Moffat { beta: 3.5 },
        seeing_arcsec: 1.05,
        outer_radius_m: 0.0,
        inner_radius_m: 0.0,
    };
    let profile = optics.profile(600.0, 0.0, 1.0, 1.0).unwrap();
    let line = |from: [f64; 3], to: [f64; 3], rate: f64| {
        let nodes = [from, to].map(|[time_s, x, y]| PathNode::new(time_s, PixelPosition { x, y }, rate));
        StreakPath::new(nodes.to_vec()).unwrap()
    };
    let other = line([13.0, 229.0, -8.0], [22.2, 164.0, 408.0], RATE);
    let extended = |rate: f64| line([13.0, 226.7, -73.4], [20.0, -57.2, 203.2], rate);
    for seed in 0..4 {
        for has_other in [false, true] {
            let drawn: Vec<StreakPath> =
                [Some(extended(RATE)), has_other.then(|| other.clone())].into_iter().flatten().collect();
            let plane = on_noisy_sky(&drawn, &profile, [SIDE; 2], [100.0, 10.0], seed);
            let predicted = PredictedStreak {
                lateness_sigma_s: 0.6,
                largest_delay_s: 5.0,
                cross_sigma_pix: 0.5,
                ..point_source(extended(1.0))
            };
            let light_area = LightArea::whole(SIDE, SIDE);
            let measured = measure(&plane, &light_area, &predicted, &optics, &options()).unwrap();
            let ratio = measured.rate.value / RATE;
            println!("seed {seed}, other {has_other}: {ratio} {:?} {:?}", measured.flags, measured.offset_pix);
            assert!((ratio - 1.0).abs() <= FLUX, "seed {seed}, other {has_other}: {ratio}");
        }
    }
}

/// Two given streaks beside each other, of which one is five times brighter, have their own fluxes and a flag.
#[test]
fn given_streaks_beside_each_other_do_not_take_the_same_light() {
    /// Largest relative error of the flux, and light of the streaks per second.
    const FLUX: f64 = 0.1;
    const RATES: [f64; 2] = [10_000.0, 50_000.0];
    const SIDE: usize = 400;
    const LENGTH: f64 = 300.0;
    let optics = Optics { form: SeeingForm::Gaussian, seeing_arcsec: 4.0, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let profile = optics.profile(600.0, 0.0, 1.0, 1.0).unwrap();
    let line = |y: f64, beyond: f64, rate: f64| {
        let node = |time_s: f64| {
            PathNode::new(time_s, PixelPosition { x: 50.0 + LENGTH * time_s / 10.0, y: y + 2.0 * time_s }, rate)
        };
        StreakPath::new([-beyond, 10.0 + beyond].map(node).to_vec()).unwrap()
    };
    for (apart, cross_sigma_pix) in [(16.0, 0.5), (16.0, 3.0), (24.0, 3.0), (60.0, 3.0)] {
        let places = [150.0, 150.0 + apart];
        let drawn: Vec<StreakPath> = places.iter().zip(RATES).map(|(y, rate)| line(*y, 0.0, rate)).collect();
        let plane = on_noisy_sky(&drawn, &profile, [SIDE; 2], [800.0, 20.0], 3);
        for (y, rate) in places.iter().zip(RATES) {
            let predicted =
                PredictedStreak { ends_s: Some([0.0, 10.0]), cross_sigma_pix, ..point_source(line(*y, 0.5, 1.0)) };
            let options = MeasureOptions { neighbour_pix: Some(apart), ..options() };
            let light_area = LightArea::whole(SIDE, SIDE);
            let measured = measure(&plane, &light_area, &predicted, &optics, &options).unwrap();
            let ratio = measured.rate.value / rate;
            println!("{apart} {cross_sigma_pix}: {ratio} {:?} {:?}", measured.flags, measured.offset_pix);
            assert!(measured.offset_pix.value.abs() < 1.0, "{apart}: {:?}", measured.offset_pix);
            assert!((ratio - 1.0).abs() <= FLUX, "{apart}: {ratio}");
            assert_eq!(measured.flags.contains(&Flag::Blended), apart <= 24.0, "{apart}");
        }
    }
}

/// Given ends are fitted where the light of a bright streak ends, and stay near the given position if bad pixels hide
/// it.
#[test]
fn verif_given_ends_of_bright_streaks_are_where_their_light_ends() {
    /// Largest error of an end, and of one that bad pixels hide, pixels. The error of the given ends is 3 pixels.
    const END_PIX: f64 = 0.3;
    const HIDDEN_PIX: f64 = 2.0;
    const RATE: f64 = 84_000.0;
    let (rows, columns) = (160, 600);
    let optics = Optics { form: SeeingForm::Gaussian, seeing_arcsec: 2.4, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let profile = optics.profile(600.0, 0.0, 1.0, 1.0).unwrap();
    for seed in 0..40 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let (y, rise) = (60.0 + 3.0 * normal(), 40.0 + 10.0 * normal());
        let at = |time_s: f64| PixelPosition { x: 59.0 + 16.0 * time_s, y: y + rise * time_s / EXPOSURE_S };
        let line = |[from_s, to_s]: [f64; 2], rate: f64| {
            StreakPath::new([from_s, to_s].map(|time_s| PathNode::new(time_s, at(time_s), rate)).to_vec()).unwrap()
        };
        let mut plane = Plane::zeros(rows, columns);
        draw(&line([0.0, EXPOSURE_S], RATE), &profile, rows, columns).add_to(&mut plane);
        let is_hidden = seed % 4 == 0;
        if is_hidden {
            // Bad pixels around the end.
            let end = at(EXPOSURE_S);
            for row in 0..rows {
                for column in 0..columns {
                    if end.distance(PixelPosition { x: column as f64, y: row as f64 }) < 8.0 {
                        plane.row_mut(row)[column] = f32::NAN;
                    }
                }
            }
        }
        for value in plane.values_mut() {
            let mean = f64::from(*value) + 150.0;
            *value = (mean + normal() * mean.sqrt()) as f32;
        }
        let predicted = PredictedStreak {
            ends_s: Some([0.0, EXPOSURE_S]),
            cross_sigma_pix: 3.0,
            ..point_source(line([-0.8, EXPOSURE_S + 0.8], 1.0))
        };
        let measured = measure(&plane, &LightArea::whole(rows, columns), &predicted, &optics, &options()).unwrap();
        let [first, last] = measured.ends_in_frame();
        let errors_pix = [first.distance(at(0.0)), last.distance(at(EXPOSURE_S))];
        let ratio = measured.rate.value / RATE - 1.0;
        println!("seed {seed}: ends {errors_pix:.2?}, flux {ratio:.5} +- {:.5}", measured.rate.sigma / RATE);
        assert!(errors_pix[0] < END_PIX && errors_pix[1] < if is_hidden { HIDDEN_PIX } else { END_PIX }, "seed {seed}");
        assert!(is_hidden || ratio.abs() < 5.0 * measured.rate.sigma / RATE, "seed {seed}: {ratio}");
    }
}

#[test]
fn a_constant_frame_has_no_limit() {
    for level in [0.0, 1.0, 1000.7] {
        let mut plane = Plane::zeros(200, 300);
        plane.values_mut().fill(level);
        let node = |time_s: f64| PathNode::new(time_s, PixelPosition { x: 30.0 * time_s, y: 100.0 + time_s }, 1.0);
        let predicted = PredictedStreak {
            path: StreakPath::new([-2.0, 12.0].map(node).to_vec()).unwrap(),
            drift_pix_s: [0.0; 2],
            lateness_sigma_s: 0.1,
            largest_delay_s: 1.0,
            ends_s: None,
            cross_sigma_pix: 1.0,
            range_km: 600.0,
            radius_m: 0.0,
            radius_sigma_m: 0.0,
        };
        let optics =
            Optics { form: SeeingForm::Gaussian, seeing_arcsec: 2.0, outer_radius_m: 0.0, inner_radius_m: 0.0 };
        let measured = measure(&plane, &LightArea::whole(200, 300), &predicted, &optics, &options()).unwrap();
        assert!(!measured.is_detected && measured.rate_limit.is_nan() && measured.rate.sigma.is_nan(), "{measured:?}");
    }
}
