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

mod bright;
mod delays;
mod detection;
mod faint;
mod fluxes;
mod forms;
mod widths;

// Required bounds, set before the first run.

/// Largest bias of the flux.
const FLUX_BIAS: f64 = 0.02;
/// Share of fluxes within one sigma, for the sample of docs/explanation/measuring.md and for its parts.
const WITHIN_ONE_SIGMA: RangeInclusive<f64> = 0.63..=0.73;
/// Probability of a false detection in a corridor (an option of the measurement).
const FALSE_ALARM: f64 = 0.01;
/// Smallest share of streaks found at a signal to noise of 10, and of 30.
const FOUND_AT_10: f64 = 0.95;
const FOUND_AT_30: f64 = 0.99;
/// Largest share of streaks with exactly the given seeing that have the flag `width`.
const WRONG_WIDTHS: f64 = 0.03;

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

/// Values of the grid of streaks.
const BRIGHTNESS: [f64; 4] = [10.0, 30.0, 100.0, 400.0];
const ANGLES_DEG: [f64; 4] = [3.0, 30.0, 52.0, 88.0];
const SEEING_PIX: [f64; 3] = [2.2, 4.0, 7.0];
const STARS: [f64; 3] = [0.0, 100.0, 1000.0];

fn options() -> MeasureOptions {
    MeasureOptions { false_alarm: FALSE_ALARM, is_form_known: true, ..MeasureOptions::default() }
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

/// Prints a line of the table of docs/explanation/measuring.md: bias of the flux, its standard error and the share
/// within one sigma as fractions, and the number of detected streaks of all.
fn print_row(name: &str, fractions: [f64; 3], found: usize, all: usize) {
    let [bias, error, share] = fractions.map(|fraction| 100.0 * fraction);
    println!("| {name} | {bias:+.1} ± {error:.1} % | {share:.1} % | {found} of {all} |");
}

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
