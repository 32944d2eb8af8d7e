//! A brightness model out of photometry: a night is simulated, read back, reduced, fitted, and drawn from.
//!
//! `cargo run --release --example fit_photometry`

use streakcast::elements::{Constellation, History};
use streakcast::fit::measurements::{Placement, Selection, SimulationOptions, measure, simulate};
use streakcast::fit::{
    COEFFICIENTS, FitSettings, PosteriorSettings, Problem, RawWeights, TwoPanelForm, draw, faults,
    points_of_measurements, posterior, rms,
};
use streakcast::photometry::{Earthshine, ModelLibrary};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 1. Photometry: here simulated, so that the truth is known; RecordReader reads files instead.
    let library = ModelLibrary::embedded();
    let truth = library.get("starlink-v1.5").ok_or("no such model")?;
    let shell = "[[constellation]]\nname = 'shell'\nshell = [{ altitude_km = 550, inclination_deg = 53, planes = 18, \
                 satellites_per_plane = 15, phasing = 5 }]";
    let first = "2023-05-20T12:00:00 UTC".parse()?;
    let history = History::new(Constellation::from_toml(shell)?.remove(0).element_sets(first));
    let photometry = simulate(
        &truth,
        &history,
        &SimulationOptions { tracks_per_night: 60, cadence_s: 2.0, ..SimulationOptions::mmt9(first, 5)? },
    )?;

    // 2. Its geometry, by the nearest element set, and the paper's selection.
    let measured = measure(&mut photometry.records.source(), &Placement::elements(&history), &Selection::default())?;
    println!("{} measurements, {} rows left out", measured.points.len(), measured.dropped.total());

    // 3. The paper's form, all seven coefficients free.
    let file = truth.file().ok_or("a model without a file")?;
    let (band, system) = truth.band();
    let form = TwoPanelForm {
        shape: file.shape.ok_or("no shape")?,
        coefficients: file.coefficients.ok_or("no coefficients")?,
        earthshine: Earthshine::Off,
        blocking: true,
        sun_magnitude: band.sun_magnitude(system),
    };
    let points = points_of_measurements(&measured, &RawWeights::default());
    let problem = Problem::new(&form, &points, &FitSettings::free(&COEFFICIENTS))?;
    let fit = problem.solve()?;
    println!("RMS {:.3} mag", rms(&fit.residuals_mag));
    for (i, parameter) in fit.parameters.iter().enumerate() {
        match fit.certainty.sigma(i) {
            Some(sigma) => println!("  {:<17} {:.5} +- {sigma:.5}", parameter.name, parameter.value),
            None => println!("  {:<17} {:.5}", parameter.name, parameter.value),
        }
    }
    faults(&problem, &fit).iter().for_each(|fault| println!("  not sound: {fault}"));

    // 4. A short walk through the posterior.
    let settings = PosteriorSettings { steps: 300, burn_in: 100, ..PosteriorSettings::default() };
    let chain = draw(&problem.objective(), &fit, &settings, None, |_| Ok(()))?;
    for marginal in posterior(&chain, &fit, settings.burn_in).marginals {
        let [low, median, high] = marginal.quantiles;
        println!("  {:<17} {median:.5} +{:.5} -{:.5}", marginal.name, high - median, median - low);
    }
    Ok(())
}
