//! Fits of the two-panel form: magnitudes, derivatives, minima and posterior, compared with SciPy and emcee.

use crate::common::agreement::Agreement;
use std::fs;

use streakcast::fit::inference::{Chain, LogProbability, NormalEquations, autocorrelation_times};
use streakcast::fit::{
    FitPoint, FitSettings, Form, Loss, ModelDescription, PosteriorSettings, Problem, TwoPanelForm, draw, model_file,
    posterior, predict,
};
use streakcast::geometry::ViewingGeometry;
use streakcast::photometry::{
    Coefficients, Earthshine, ModelLibrary, SatelliteModel, SatelliteShape, StandardMagnitude,
};

const SEVEN: [&str; 7] = ["c1", "c2", "c3", "c4", "c5", "n_sail", "n_base"];
const SUN: f64 = -26.76;

fn form(earthshine: Earthshine) -> TwoPanelForm {
    TwoPanelForm {
        shape: SatelliteShape {
            sail_length_m: 8.1,
            sail_width_m: 2.8,
            base_length_m: 1.3,
            base_width_m: 2.8,
            panel_offset_deg: 0.0,
        },
        coefficients: Coefficients { c1: 0.02, c2: 0.004, c3: 0.006, c4: 0.35, c5: 0.09, n_sail: 6.0, n_base: 18.0 },
        earthshine,
        blocking: true,
        sun_magnitude: SUN,
    }
}

/// Points of the golden file, and the numbers in its header.
struct Golden {
    points: Vec<FitPoint>,
    head: Vec<(String, Vec<f64>)>,
}

impl Golden {
    fn read() -> Self {
        let text =
            fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/fit_golden.csv")).expect("golden file");
        let numbers = |text: &str| {
            text.trim_matches(['[', ']']).split(", ").filter_map(|number| number.parse().ok()).collect::<Vec<f64>>()
        };
        let head = text.lines().filter_map(|line| line.strip_prefix("# ")?.split_once(' '));
        let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1).map(|line| {
            let n: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
            point(n[0], n[1], n[2], n[3], n[4])
        });
        Self { points: rows.collect(), head: head.map(|(key, value)| (key.to_owned(), numbers(value))).collect() }
    }

    fn numbers(&self, key: &str) -> &[f64] {
        &self.head.iter().find(|(name, _)| name == key).unwrap_or_else(|| panic!("no {key}")).1
    }
}

fn point(sun_deg: f64, longitude_deg: f64, latitude_deg: f64, magnitude: f64, sigma_mag: f64) -> FitPoint {
    let [sun, longitude, latitude] = [sun_deg, longitude_deg, latitude_deg].map(f64::to_radians);
    let geometry = ViewingGeometry::from_angles(sun, longitude, latitude, 1000.0, 550.0).expect("a geometry");
    FitPoint { geometry, magnitude, sigma_mag, weight: 1.0, group: 0 }
}

fn many(suns_deg: &[f64]) -> Vec<FitPoint> {
    let directions = (0..24).flat_map(|i| (0..8).map(move |j| (15.0 * f64::from(i) + 2.0, -10.0 - 9.7 * f64::from(j))));
    let directions: Vec<(f64, f64)> = directions.collect();
    suns_deg.iter().flat_map(|&sun| directions.iter().map(move |&(lon, lat)| point(sun, lon, lat, 6.0, 0.2))).collect()
}

/// Tolerance of earthshine, mag. The quadrature has errors of 3e-4 mag at exponents of 1 and 2, where its nodes change
/// with the exponent; interpolation adds 2e-5 mag.
const EARTH: f64 = 4e-4;

#[test]
fn verif_magnitudes_equal_those_of_the_model() {
    for (earthshine, tolerance) in [(Earthshine::Off, 1e-9), (Earthshine::Computed, EARTH)] {
        let points = many(&[-21.0, -12.0, -3.0, 4.0]);
        for n_base in [2.0, 18.0, 75.0] {
            let mut form = form(earthshine);
            form.coefficients.n_base = n_base;
            form.shape.panel_offset_deg = 3.0;
            let values: Vec<f64> = form.parameters().iter().map(|parameter| parameter.value).collect();
            let model = SatelliteModel::new(&form.shape, &form.coefficients).expect("a satellite");
            let mut seen = 0;
            for (point, predicted) in points.iter().zip(predict(&form, &points, &values)) {
                let b_total = model.terms_with(&point.geometry, earthshine).b_total_m2_sr();
                // Points whose only light is earthshine on the night side of the chassis are omitted from fits.
                if let Some(expected) =
                    StandardMagnitude::from_reflection(b_total, SUN).filter(|_| predicted.is_finite())
                {
                    assert!((predicted - expected.0).abs() < tolerance, "{n_base} {point:?}: {predicted} {expected:?}");
                    seen += 1;
                }
            }
            assert!(seen > points.len() / 3, "{seen} of {}", points.len());
        }
    }
}

#[test]
fn verif_slopes_are_derivatives() {
    for earthshine in [Earthshine::Off, Earthshine::Computed] {
        let form = form(earthshine);
        let mut names = SEVEN.to_vec();
        names.push("panel_offset_deg");
        let points = many(&[-18.0, -10.0, -1.0]);
        let problem = Problem::new(&form, &points, &FitSettings::free(&names)).expect("a problem");
        let objective = problem.objective();
        let x = [0.03, 0.006, 0.004, 0.2, 0.12, 4.0, 25.0, 1.5];
        let (cost, slope, _) = objective.equations(&x);
        assert!((cost - objective.cost(&x)).abs() < 1e-9 * cost);
        for (i, x_i) in x.iter().enumerate() {
            let h = 1e-5 * x_i;
            let moved = |by: f64| {
                let mut moved = x;
                moved[i] += by;
                objective.cost(&moved)
            };
            let expected = (moved(h) - moved(-h)) / (2.0 * h);
            /// Relative error of central differences over a step of 1e-5.
            const DIFFERENCES: f64 = 2e-5;
            let scale = expected.abs().max(1e-3 * cost / x_i);
            assert!((slope[i] - expected).abs() < DIFFERENCES * scale, "{} {} {expected}", names[i], slope[i]);
        }
    }
}

#[test]
fn valid_least_squares_against_scipy() {
    let golden = Golden::read();
    for (loss, key) in [(Loss::Squares, "scipy_linear_cost"), (Loss::SoftL1, "scipy_soft_l1_cost")] {
        let settings = FitSettings { loss, ..FitSettings::free(&SEVEN) };
        let problem = Problem::new(&form(Earthshine::Off), &golden.points, &settings).expect("a problem");
        let fit = problem.solve().expect("a fit");
        let scipy = golden.numbers(key)[0];
        /// Relative tolerance of the cost. Both programs stop when it decreases by less than 1e-12.
        const COST: f64 = 1e-8;
        Agreement::new("Smallest cost of least squares, plain and robust", "SciPy 1.17", COST, "of the cost")
            .add(fit.cost / scipy - 1.0);
        if loss == Loss::Squares {
            let truth = golden.numbers("truth");
            for ((i, parameter), (scipy, truth)) in
                fit.parameters.iter().enumerate().zip(golden.numbers("scipy_linear_x").iter().zip(truth))
            {
                let sigma = fit.uncertainty.sigma(i).expect("a sigma");
                assert!(
                    (parameter.value - scipy).abs() < 1e-3 * sigma,
                    "{}: {} {scipy}",
                    parameter.name,
                    parameter.value
                );
                // Seven errors of one draw; the tolerance is 4 sigma.
                assert!(
                    (parameter.value - truth).abs() < 4.0 * sigma,
                    "{}: {} ± {sigma}, {truth}",
                    parameter.name,
                    parameter.value
                );
            }
        }
    }
}

#[test]
fn verif_the_best_of_all_starts_is_kept() {
    let golden = Golden::read();
    let problem = Problem::new(&form(Earthshine::Off), &golden.points, &FitSettings::free(&SEVEN)).expect("a problem");
    let fit = problem.solve().expect("a fit");
    assert!(fit.costs.len() > 3, "{:?}", fit.costs);
    // A descent from a poor start ends in the same or another minimum, but not in a lower one.
    let poor = problem.descend(&[0.5, 0.5, 0.5, 0.5, 0.5, 150.0, 1.0]);
    assert!(poor.cost >= fit.cost * (1.0 - 1e-9), "{} {}", poor.cost, fit.cost);
}

#[test]
fn valid_posterior_against_emcee() {
    let golden = Golden::read();
    let problem = Problem::new(&form(Earthshine::Off), &golden.points, &FitSettings::free(&SEVEN)).expect("a problem");
    let fit = problem.solve().expect("a fit");
    let objective = problem.objective();
    let settings = PosteriorSettings { steps: 6_000, burn_in: 500, walkers: 32, seed: 3 };
    let chain = draw(&objective, &fit, &settings, None, |_| Ok(())).expect("a chain");
    let found = posterior(&chain, &fit, settings.burn_in);
    let (mean, covariance) = (golden.numbers("emcee_mean"), golden.numbers("emcee_covariance"));
    assert!((0.2..0.7).contains(&found.acceptance), "{}", found.acceptance);
    for (i, marginal) in found.marginals.iter().enumerate() {
        let sigma = covariance[8 * i].sqrt();
        // Number of independent draws of this chain. The chain of emcee has five times as many.
        let draws = (found.steps * settings.walkers) as f64 / marginal.autocorrelation.steps;
        // The errors of means are σ/√draws, those of variances √(2/draws). The tolerance is 4.5 sigma for 7 + 28
        // numbers.
        let (of_mean, of_variance) = (4.5 * sigma * (1.2 / draws).sqrt(), 4.5 * (2.4 / draws).sqrt());
        assert!((marginal.mean - mean[i]).abs() < of_mean, "{}: {} {}", marginal.name, marginal.mean, mean[i]);
        for j in 0..=i {
            let scale = sigma * covariance[8 * j].sqrt();
            let apart = (found.covariance[i][j] - covariance[7 * i + j]) / scale;
            assert!(
                apart.abs() < of_variance,
                "{} {j}: {} {}",
                marginal.name,
                found.covariance[i][j],
                covariance[7 * i + j]
            );
        }
        assert!(marginal.quantiles[0] < marginal.quantiles[1] && marginal.quantiles[1] < marginal.quantiles[2]);
    }
    let emcee_tau = golden.numbers("emcee_tau");
    for (marginal, emcee) in found.marginals.iter().zip(emcee_tau) {
        // Correlation times of equivalent chains differ by some ten percent.
        assert!((marginal.autocorrelation.steps / emcee).ln().abs() < 0.4, "{marginal:?} {emcee}");
    }
}

#[test]
fn valid_autocorrelation_times_against_emcee() {
    let golden = Golden::read();
    let (steps, walkers) = (20_000, 4);
    let (mut state, mut x) = (12_345_u64, [0.0; 4]);
    let mut places = Vec::with_capacity(steps * walkers);
    for _ in 0..steps {
        for x in &mut x {
            state = (1_103_515_245 * state + 12_345) % (1 << 31);
            *x = 0.9 * *x + state as f64 / (1_u64 << 31) as f64 - 0.5;
            places.push(*x);
        }
    }
    let chain = Chain::from_parts(walkers, 1, places, vec![0.0; steps * walkers], vec![0; walkers]).expect("a chain");
    let tau = autocorrelation_times(&chain, 0)[0];
    /// Tolerance of correlation times; emcee computes the same sums by Fourier transforms.
    const ROUNDING: f64 = 1e-9;
    let mut times = Agreement::new("Autocorrelation time", "emcee 3.1.6", ROUNDING, "of the time");
    times.add(tau.steps / golden.numbers("emcee_recurrence_tau")[0] - 1.0);
    assert!(tau.is_trusted && !autocorrelation_times(&chain, steps - 200)[0].is_trusted);
}

/// The same seed gives the same draws on one thread and on many, in one run and in a resumed run.
#[test]
fn verif_a_chain_is_the_same_at_any_number_of_threads_and_when_resumed() {
    let golden = Golden::read();
    let problem =
        Problem::new(&form(Earthshine::Computed), &golden.points, &FitSettings::free(&SEVEN)).expect("a problem");
    let fit = problem.solve().expect("a fit");
    let objective = problem.objective();
    let settings = PosteriorSettings { steps: 30, burn_in: 5, walkers: 16, seed: 11 };
    let run = |threads: usize, steps: usize, resumed: Option<Chain>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            draw(&objective, &fit, &PosteriorSettings { steps, ..settings }, resumed, |_| Ok(())).expect("a chain")
        })
    };
    let whole = run(1, 30, None);
    assert_eq!(whole, run(3, 30, None));
    assert_eq!(whole, run(2, 30, Some(run(1, 13, None))));
    let other = draw(&objective, &fit, &PosteriorSettings { seed: 12, ..settings }, None, |_| Ok(())).expect("a chain");
    assert_ne!(whole, other);
    // The probability outside the bounds is zero.
    let mut outside = whole.at(29, 0).to_vec();
    outside[0] = 1.5;
    assert_eq!(objective.of_many(&[outside]), [f64::NEG_INFINITY]);
}

/// A fitted panel offset is part of the covariance in the model file, and contributes to the sigma of magnitudes.
#[test]
fn verif_a_fitted_panel_offset_is_in_the_covariance() {
    let mut form = form(Earthshine::Off);
    form.shape.panel_offset_deg = 3.0;
    let values: Vec<f64> = form.parameters().iter().map(|parameter| parameter.value).collect();
    let mut points = many(&[-21.0, -12.0, -3.0]);
    let predicted = predict(&form, &points, &values);
    for (i, (point, magnitude)) in points.iter_mut().zip(predicted).enumerate() {
        point.magnitude = if magnitude.is_finite() { magnitude + 0.05 * (i as f64 * 0.7).sin() } else { 6.0 };
    }
    let library = ModelLibrary::embedded();
    let base = library.get("starlink-v1.5").and_then(|model| model.file().cloned()).expect("a model");
    let words = ModelDescription {
        name: "mine".into(),
        title: "A fit".into(),
        source: "a test".into(),
        data: "made up".into(),
        date: "2026-11".into(),
        provisional: false,
        notes: Vec::new(),
        sigma_origin: "made up".into(),
    };
    let fitted = |names: &[&str]| {
        let problem = Problem::new(&form, &points, &FitSettings::free(names)).expect("a problem");
        let fit = problem.solve().expect("a fit");
        let file =
            model_file(&base, &fit, problem.points(), 0.05, &[(-0.3, 1.0), (0.3, 1.0)], &words).expect("a model file");
        (fit, file)
    };
    let (_, without) = fitted(&SEVEN);
    assert_eq!(without.covariance.as_ref().map(Vec::len), Some(7));
    let mut names = SEVEN.to_vec();
    names.push("panel_offset_deg");
    let (fit, file) = fitted(&names);
    let covariance = file.covariance.clone().expect("a covariance");
    let variance = fit.uncertainty.sigma(7).expect("a sigma").powi(2);
    assert!(covariance.len() == 8 && (covariance[7][7] / variance - 1.0).abs() < 1e-12, "{covariance:?}");
    assert_eq!(file.parameters()[7], ("panel_offset_deg", file.shape.expect("a shape").panel_offset_deg));
    assert!((file.parameters()[7].1 - 3.0).abs() < 0.5, "{:?}", file.parameters());
}
