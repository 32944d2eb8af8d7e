//! Photometry of a satellite whose coefficients are known, as MMT-9 would have made it, through the whole pipeline of Lu (2024), sections 3
//! and 4: do the coefficients come back, and do the paper's three tests say what is true?
//!
//! The long form (two million points) is `cargo test --release --test fit_closed_circle -- --include-ignored --nocapture`; the short one has
//! fewer points and larger pixels.

use streakcast::catalogue::{Constellation, ElementSet, History};
use streakcast::fit::{
    COEFFICIENTS, Fit, FitSettings, PaperTests, Problem, RawWeights, TwoPanelForm, paper_tests, points_of_measurements,
    points_of_pixels, predict, rms,
};
use streakcast::measured::{
    Measurements, Placement, ReduceOptions, Reduction, Selection, SimulationOptions, measure, reduce, simulate,
};
use streakcast::photometry::{BrightnessModel, Coefficients, Earthshine, ModelFile, ModelLibrary};

/// What is true: the paper's form with a glossy sail.
const TRUTH: Coefficients =
    Coefficients { c1: 0.12, c2: 0.02, c3: 0.006, c4: 0.25, c5: 0.09, n_sail: 4.0, n_base: 16.0 };

fn file() -> ModelFile {
    let library = ModelLibrary::embedded();
    let mut file = library.get("starlink-v1.5").and_then(|model| model.file().cloned()).expect("a shipped model");
    (file.coefficients, file.covariance) = (Some(TRUTH), None);
    file
}

fn form(earthshine: Earthshine) -> TwoPanelForm {
    let file = file();
    let begun = Coefficients { c1: 0.0, c2: 0.0, c3: 0.0, c4: 0.0, c5: 0.0, n_sail: 1.0, n_base: 1.0 };
    let model = BrightnessModel::from_file(file.clone(), "truth").expect("a model");
    let (band, system) = model.band();
    TwoPanelForm {
        shape: file.shape.expect("a shape"),
        coefficients: begun,
        earthshine,
        blocking: true,
        sun_magnitude: band.sun_magnitude(system),
    }
}

/// The first shell of Starlink on some nights spread over a year.
fn observed(nights: u32, per_night: usize, track_scatter_mag: f64, earthshine: Earthshine) -> Measurements {
    let model = BrightnessModel::from_file(file(), "truth").expect("a model");
    let first: hifitime::Epoch = "2023-01-10T20:00:00 UTC".parse().expect("a moment");
    let constellation = Constellation::by_name("starlink-gen1").expect("a constellation");
    let sets: Vec<ElementSet> = constellation.element_sets(first + hifitime::Unit::Day * 180.0);
    let at_550 = |set: &ElementSet| (set.inclination_deg - 53.0).abs() < 0.5;
    let history = History::new(sets.into_iter().filter(at_550).collect());
    let options = SimulationOptions {
        tracks_per_night: per_night,
        night_step_days: 360 / nights.max(1),
        track_scatter_mag,
        point_scatter_mag: if track_scatter_mag > 0.2 { 0.05 } else { 0.2 },
        earthshine,
        ..SimulationOptions::mmt9(first, nights).expect("a site")
    };
    let simulation = simulate(&model, &history, &options).expect("photometry");
    let placement = Placement { max_element_age_days: 400.0, ..Placement::elements(&history) };
    measure(&mut simulation.records.source(), &placement, &Selection::default()).expect("measurements")
}

struct Circle {
    measurements: Measurements,
    pixels: Reduction,
    fit: Fit,
    tests: PaperTests,
}

fn circle(
    nights: u32,
    per_night: usize,
    track_scatter_mag: f64,
    reduction: ReduceOptions,
    truth: Earthshine,
) -> Circle {
    let measurements = observed(nights, per_night, track_scatter_mag, truth);
    let pixels = reduce(&measurements.points, reduction).expect("pixels");
    let points = points_of_pixels(&pixels);
    let form = form(truth);
    let problem = Problem::new(&form, &points, &FitSettings::free(&COEFFICIENTS)).expect("a problem");
    let fit = problem.solve().expect("a fit");
    let tests =
        paper_tests(&form, &points, &FitSettings::default(), reduction.layer_width_rad.to_degrees()).expect("tests");
    println!(
        "{} points in {} tracks, {} dropped; {} of {} pixels kept; RMS {:.4} mag",
        measurements.points.len(),
        measurements.groups.len(),
        measurements.dropped.total(),
        points.len(),
        pixels.pixels.len(),
        rms(&fit.residuals_mag)
    );
    Circle { measurements, pixels, fit, tests }
}

/// Coefficients within `sigmas` of the truth, or within `share` of it where pixels are too coarse to be that exact.
fn comes_back(circle: &Circle, sigmas: f64, share: f64) {
    let truth = [TRUTH.c1, TRUTH.c2, TRUTH.c3, TRUTH.c4, TRUTH.c5, TRUTH.n_sail, TRUTH.n_base];
    for (i, truth) in truth.iter().enumerate() {
        let (parameter, sigma) = (&circle.fit.parameters[i], circle.fit.certainty.sigma(i).expect("a sigma"));
        println!("  {:<7} {:.5} ± {sigma:.5}, true {truth}", parameter.name, parameter.value);
        let allowed = (sigmas * sigma).max(share * truth);
        assert!(
            (parameter.value - truth).abs() < allowed,
            "{} {} ± {sigma}, true {truth}",
            parameter.name,
            parameter.value
        );
    }
}

fn tests_say_what_is_true(circle: &Circle, truth: Earthshine) {
    let tests = &circle.tests;
    for layer in &tests.offsets {
        println!(
            "  {:?} n {} POA {:+.3} ± {:.3?} RMS {:.4}",
            layer.sun_latitude_deg, layer.n, layer.panel_offset_deg, layer.sigma_deg, layer.rms_mag
        );
    }
    println!("  {:?}\n  {:?}", tests.sail_glossy, tests.earthshine);
    // The sail stands upright: offsets lie about 0, whatever the layer.
    let mean = tests.offsets.iter().map(|layer| layer.panel_offset_deg).sum::<f64>() / tests.offsets.len() as f64;
    /// Between layers of some hundred pixels each.
    const OFFSET_DEG: f64 = 0.5;
    assert!(tests.offsets.len() > 3 && mean.abs() < OFFSET_DEG, "{mean}");
    // The glossy lobe is there, and Akaike's criterion keeps it.
    let gloss = &tests.sail_glossy;
    assert!(gloss.aic[0] < gloss.aic[1] - 10.0 && gloss.rms_mag[0] < gloss.rms_mag[1], "{gloss:?}");
    // Earthshine cannot be told from the light through the sail's back: RMSE and mean residuals are alike either way (the paper: p = 0.25).
    let earth = &tests.earthshine;
    assert!((earth.rms_mag[0] - earth.rms_mag[1]).abs() < 0.005, "{earth:?}");
    assert!(earth.test.is_some_and(|test| test.p > 0.01), "{earth:?} (truth {truth:?})");
}

#[test]
fn verif_known_coefficients_come_back_through_the_pipeline() {
    let reduction = ReduceOptions {
        nside: 16,
        least_count: 40,
        most_iqr_mag: 0.8,
        layer_width_rad: 2_f64.to_radians(),
        ..ReduceOptions::default()
    };
    let circle = circle(12, 150, 0.1, reduction, Earthshine::Off);
    comes_back(&circle, 4.0, 0.25);
    tests_say_what_is_true(&circle, Earthshine::Off);
}

/// From one track to the next, so that modes of pixels, made of a few tracks each, scatter about the model as the paper's do (0.24 mag).
const SATELLITES_DIFFER_MAG: f64 = 0.23;

#[test]
#[ignore = "two million points: some minutes without optimisation"]
fn verif_two_million_points_of_the_papers_pipeline() {
    for truth in [Earthshine::Off, Earthshine::Computed] {
        println!("truth: earthshine {truth:?}");
        let circle = circle(48, 270, SATELLITES_DIFFER_MAG, ReduceOptions::default(), truth);
        assert!(circle.measurements.points.len() > 1_800_000, "{}", circle.measurements.points.len());
        let kept = circle.pixels.kept().count();
        assert!(kept > 1_000, "{kept} pixels");
        let found = rms(&circle.fit.residuals_mag);
        assert!((0.05..0.3).contains(&found), "{found}");
        comes_back(&circle, 2.0, 0.0);
        tests_say_what_is_true(&circle, truth);
        // Single measurements scatter as they were made to.
        let points = points_of_measurements(&circle.measurements, &RawWeights::default());
        let predicted = predict(&form(truth), &points, &circle.fit.values());
        let residuals: Vec<f64> =
            points.iter().zip(predicted).map(|(p, m)| p.magnitude - m).filter(|r| r.is_finite()).collect();
        println!("  single measurements: RMS {:.3} mag", rms(&residuals));
    }
}
