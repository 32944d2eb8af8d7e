//! Time to compute a magnitude: with sunlight only, with earthshine, for two panels given as a list of panels, and for
//! a map of all directions below the satellite.

use divan::{Bencher, black_box};
use nalgebra::Vector3;
use streakcast::geometry::ViewingGeometry;
use streakcast::photometry::earthshine::LitEarth;
use streakcast::photometry::{BrightnessModel, Earthshine, ModelLibrary, PhotometryOptions};

/// Number of directions in one iteration.
const DIRECTIONS: usize = 1000;
/// Latitudes of the Sun, degrees: low twilight, terminator below the satellite, and daylight on half of the visible
/// ground.
const SUNS_DEG: [f64; 3] = [-8.0, 0.0, 8.0];

fn main() {
    divan::main();
}

fn model() -> std::sync::Arc<BrightnessModel> {
    ModelLibrary::embedded().get("starlink-v1.5").expect("shipped")
}

/// Returns directions in the lower hemisphere of a satellite at 550 km, with the Sun near one latitude.
fn geometries(n: usize, sun_deg: f64) -> Vec<ViewingGeometry> {
    (0..n)
        .map(|i| {
            // Directions on a golden spiral, each for the same solid angle.
            let up = -(i as f64 + 0.5) / n as f64;
            let longitude = 2.399_963 * i as f64;
            let range_km = 550.0 / up.abs().max(0.2);
            ViewingGeometry::from_angles(
                (sun_deg + 1e-4 * i as f64).to_radians(),
                longitude,
                up.asin(),
                range_km,
                550.0,
            )
            .expect("within its ranges")
        })
        .collect()
}

/// Sunlight only; target: 0.2 µs per direction.
#[divan::bench]
fn brightness_1000_sun_only(bencher: Bencher) {
    let (model, geometries) = (model(), geometries(DIRECTIONS, -8.0));
    let options = PhotometryOptions { earthshine: Earthshine::Off, ..PhotometryOptions::default() };
    bencher.bench(|| total(&model, &geometries, &options));
}

/// With earthshine for a different Sun each time; target: 5 µs per direction.
#[divan::bench(args = SUNS_DEG)]
fn brightness_1000_with_earthshine(bencher: Bencher, sun_deg: f64) {
    let (model, geometries) = (model(), geometries(DIRECTIONS, sun_deg));
    bencher.bench(|| total(&model, &geometries, &PhotometryOptions::default()));
}

/// Models of the kinds of satellites with photometry.
const MODELS: [&str; 5] = ["starlink-v1.5-facets", "v2mini-panels", "visorsat-panels", "oneweb-panels", "iridium-next"];

/// Default models, with sunlight only.
#[divan::bench(args = MODELS)]
fn brightness_1000_of_defaults_sun_only(bencher: Bencher, name: &str) {
    let (model, geometries) = (ModelLibrary::embedded().get(name).expect("shipped"), geometries(DIRECTIONS, -12.0));
    let options = PhotometryOptions { earthshine: Earthshine::Off, ..PhotometryOptions::default() };
    bencher.bench(|| total(&model, &geometries, &options));
}

/// Default models, with earthshine and the other options of the program.
#[divan::bench(args = MODELS)]
fn brightness_1000_of_defaults(bencher: Bencher, name: &str) {
    let (model, geometries) = (ModelLibrary::embedded().get(name).expect("shipped"), geometries(DIRECTIONS, -12.0));
    bencher.bench(|| total(&model, &geometries, &PhotometryOptions::default()));
}

fn total(model: &BrightnessModel, geometries: &[ViewingGeometry], options: &PhotometryOptions) -> f64 {
    let magnitude = |geometry| Some(model.brightness(black_box(geometry), 1.0, options)?.magnitude.0);
    geometries.iter().filter_map(magnitude).sum()
}

/// Earthshine only, computed for a different Sun each time.
#[divan::bench(args = SUNS_DEG)]
fn shine_1000_computed(bencher: Bencher, sun_deg: f64) {
    let directions = directions(DIRECTIONS, sun_deg);
    bencher.bench(|| {
        let shine = |(sun, to_observer): &(f64, Vector3<f64>)| {
            Some(LitEarth::new(*sun, 550.0)?.shine(&-Vector3::z(), to_observer, 22.0).lobe)
        };
        black_box(&directions).iter().filter_map(shine).sum::<f64>()
    });
}

fn directions(n: usize, sun_deg: f64) -> Vec<(f64, Vector3<f64>)> {
    geometries(n, sun_deg)
        .iter()
        .map(|geometry| (geometry.sun_latitude_rad, *geometry.to_observer().vector()))
        .collect()
}

/// Number of directions of nside 64 below the chassis.
const MAP: usize = 24_448;

/// Map of the lower hemisphere of the body frame in sunlight, one direction after the other.
#[divan::bench(sample_count = 20)]
fn map_24448_sun_only(bencher: Bencher) {
    let (model, geometries) = (model(), geometries_of_map(-8.0));
    bencher.bench(|| {
        let magnitude = |geometry| Some(model.standard_magnitude(black_box(geometry))?.0);
        geometries.iter().filter_map(magnitude).sum::<f64>()
    });
}

/// Satellite of the paper as a list of panels in sunlight; compares the general code with the two-panel equations.
#[divan::bench(sample_count = 20)]
fn map_24448_sun_only_as_list_of_panels(bencher: Bencher) {
    let file = ModelLibrary::embedded().get("visorsat-panels").expect("shipped").file().expect("from a file").clone();
    let mut panels = file.panels.expect("a list of panels");
    panels.panels.truncate(2);
    let geometries = geometries_of_map(-8.0);
    let assembly = panels.assemble(&[]);
    bencher.bench(|| {
        let light = |geometry: &ViewingGeometry| {
            assembly.b_total_m2_sr(geometry.to_sun().vector(), geometry.to_observer().vector())
        };
        black_box(&geometries).iter().map(light).sum::<f64>()
    });
}

fn geometries_of_map(sun_deg: f64) -> Vec<ViewingGeometry> {
    let mut geometries = geometries(MAP, sun_deg);
    geometries.iter_mut().for_each(|geometry| geometry.sun_latitude_rad = sun_deg.to_radians());
    geometries
}
