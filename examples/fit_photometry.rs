//! Fit of a brightness model to photometry: reduces and fits points, and draws samples of the posterior.
//!
//! `cargo run --release --example fit_photometry`

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use streakcast::fit::measurements::{Measurement, Measurements};
use streakcast::fit::{
    COEFFICIENTS, FitSettings, PosteriorSettings, Problem, RawWeights, TwoPanelForm, draw, faults,
    points_of_measurements, posterior, rms,
};
use streakcast::geometry::ViewingGeometry;
use streakcast::photometry::{BrightnessModel, Earthshine, ModelLibrary, StandardMagnitude};

/// Number of tracks, points per track, and one sigma of a point, mag.
const TRACKS: u32 = 120;
const POINTS: u32 = 50;
const NOISE_MAG: f64 = 0.2;

/// Returns simulated measurements of satellites at 550 km with a known model. Photometry
/// in files is fitted by `streakcast fit run`.
fn measurements(truth: &BrightnessModel) -> Measurements {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut measured = Measurements::default();
    for group in 0..TRACKS {
        measured.groups.push(format!("track {group}"));
        let mut between = |least: f64, greatest: f64| least + (greatest - least) * random.random::<f64>();
        let (sun, longitude, latitude) = (between(-0.35, 0.0), between(0.0, 2.6), between(-1.3, -0.6));
        for point in 0..POINTS {
            let longitude = longitude + 0.5 * f64::from(point) / f64::from(POINTS);
            let Some(geometry) = ViewingGeometry::from_angles(sun, longitude, latitude, 900.0, 550.0) else { continue };
            let Some(magnitude) = truth.standard_magnitude(&geometry) else { continue };
            let noise_mag = NOISE_MAG * random.sample::<f64, _>(StandardNormal);
            measured.points.push(Measurement {
                magnitude: StandardMagnitude(magnitude.0 + noise_mag),
                sigma_mag: Some(NOISE_MAG),
                geometry,
                group,
                norad_id: None,
                epoch: None,
                // In full sunlight, far from the Earth's limb.
                grazing_height_km: None,
                lit_fraction: 1.0,
            });
        }
    }
    measured
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 1. Measurements at 1000 km in the satellite's frame.
    let library = ModelLibrary::embedded();
    let truth = library.get("starlink-v1.5").ok_or("unknown model")?;
    let measured = measurements(&truth);
    println!("{} measurements", measured.points.len());

    // 2. The form of Lu (2024) with all seven coefficients free.
    let form = TwoPanelForm::from_model(&truth, Earthshine::Off).ok_or("a model without two panels")?;
    let points = points_of_measurements(&measured, &RawWeights::default());
    let problem = Problem::new(&form, &points, &FitSettings::free(&COEFFICIENTS))?;
    let fit = problem.solve()?;
    println!("RMS {:.3} mag", rms(&fit.residuals_mag));
    for (i, parameter) in fit.parameters.iter().enumerate() {
        match fit.uncertainty.sigma(i) {
            Some(sigma) => println!("  {:<17} {:.5} +- {sigma:.5}", parameter.name, parameter.value),
            None => println!("  {:<17} {:.5}", parameter.name, parameter.value),
        }
    }
    faults(&problem, &fit).iter().for_each(|fault| println!("  fault: {fault}"));

    // 3. A short chain of draws from the posterior.
    let settings = PosteriorSettings { steps: 300, burn_in: 100, ..PosteriorSettings::default() };
    let chain = draw(&problem.objective(), &fit, &settings, None, |_| Ok(()))?;
    for marginal in posterior(&chain, &fit, settings.burn_in).marginals {
        let [low, median, high] = marginal.quantiles;
        println!("  {:<17} {median:.5} +{:.5} -{:.5}", marginal.name, high - median, median - low);
    }
    Ok(())
}
