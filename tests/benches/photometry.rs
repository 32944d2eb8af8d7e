//! What a magnitude costs: by sunlight, with earthshine computed and from the table, and a map of all directions below.

use divan::{Bencher, black_box};
use nalgebra::Vector3;
use streakcast::geometry::ViewingGeometry;
use streakcast::photometry::earthshine::{Albedo, EarthshineNodes, EarthshineTable, PAPER_ALBEDO, Shine};
use streakcast::photometry::{BrightnessModel, Earthshine, ModelLibrary, PhotometryOptions};

/// Directions asked for by one iteration.
const DIRECTIONS: usize = 1000;
/// Suns of low twilight, of the terminator below the satellite, and of a day that lights half of the cap, degrees.
const SUNS_DEG: [f64; 3] = [-8.0, 0.0, 8.0];

fn main() {
    divan::main();
}

fn model() -> std::sync::Arc<BrightnessModel> {
    ModelLibrary::embedded().get("starlink-v1.5").expect("shipped")
}

/// Spread over the half sphere below and around one Sun, at 550 km.
fn geometries(n: usize, sun_deg: f64) -> Vec<ViewingGeometry> {
    (0..n)
        .map(|i| {
            // Equal areas along a golden spiral.
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

/// By sunlight alone: 0.2 µs at most.
#[divan::bench]
fn brightness_1000_sun_only(bencher: Bencher) {
    let (model, geometries) = (model(), geometries(DIRECTIONS, -8.0));
    let options = PhotometryOptions { earthshine: Earthshine::Off, ..PhotometryOptions::default() };
    bencher.bench(|| total(&model, &geometries, &options));
}

/// With earthshine for another Sun each time: 5 µs each at most.
#[divan::bench(args = SUNS_DEG)]
fn brightness_1000_with_earthshine(bencher: Bencher, sun_deg: f64) {
    let (model, geometries) = (model(), geometries(DIRECTIONS, sun_deg));
    bencher.bench(|| total(&model, &geometries, &PhotometryOptions::default()));
}

fn total(model: &BrightnessModel, geometries: &[ViewingGeometry], options: &PhotometryOptions) -> f64 {
    let magnitude = |geometry| Some(model.brightness(black_box(geometry), 1.0, options)?.magnitude.0);
    geometries.iter().filter_map(magnitude).sum()
}

/// Earthshine alone, computed for another Sun each time.
#[divan::bench(args = SUNS_DEG)]
fn shine_1000_computed(bencher: Bencher, sun_deg: f64) {
    let directions = directions(DIRECTIONS, sun_deg);
    bencher.bench(|| {
        let shine = |(sun, to_observer): &(f64, Vector3<f64>)| {
            Shine::on_panel(*sun, 550.0, PAPER_ALBEDO, &-Vector3::z(), to_observer, 22.0).lobe
        };
        black_box(&directions).iter().map(shine).sum::<f64>()
    });
}

/// Earthshine alone for one Sun, its nodes made once.
#[divan::bench(args = SUNS_DEG)]
fn shine_1000_from_nodes(bencher: Bencher, sun_deg: f64) {
    let directions = directions(DIRECTIONS, sun_deg);
    let nodes = EarthshineNodes::new(sun_deg.to_radians(), 550.0, &Albedo::Uniform(PAPER_ALBEDO), 22.0);
    bencher.bench(|| {
        black_box(&directions)
            .iter()
            .map(|(_, to_observer)| nodes.shine(&-Vector3::z(), to_observer, 22.0).lobe)
            .sum::<f64>()
    });
}

/// Earthshine alone from a table of many heights: 1 µs each at most.
#[divan::bench]
fn shine_1000_from_table(bencher: Bencher) {
    let directions = directions(DIRECTIONS, -8.0);
    let table = EarthshineTable::new(22.0, [300.0, 1300.0], [-0.7, 1.57]).expect("within its ranges");
    bencher.bench(|| {
        let shine = |(sun, to_observer): &(f64, Vector3<f64>)| table.shine(*sun, 550.0, to_observer).unwrap().lobe;
        black_box(&directions).iter().map(shine).sum::<f64>()
    });
}

/// The table itself, for one height and for many.
#[divan::bench(args = [550.0, 300.0], sample_count = 3, sample_size = 1)]
fn table_built(bencher: Bencher, least_km: f64) {
    let greatest_km = if least_km < 550.0 { 1300.0 } else { least_km };
    bencher.bench(|| EarthshineTable::new(22.0, [least_km, greatest_km], [-0.7, 1.57]));
}

fn directions(n: usize, sun_deg: f64) -> Vec<(f64, Vector3<f64>)> {
    geometries(n, sun_deg)
        .iter()
        .map(|geometry| (geometry.sun_latitude_rad, *geometry.to_observer().vector()))
        .collect()
}

/// Directions of nside 64 below the chassis.
const MAP: usize = 24_448;

/// A map of the body's lower half by sunlight, one direction after the other.
#[divan::bench(sample_count = 20)]
fn map_24448_sun_only(bencher: Bencher) {
    let (model, geometries) = (model(), geometries_of_map(-8.0));
    bencher.bench(|| {
        let magnitude = |geometry| Some(model.standard_magnitude(black_box(geometry))?.0);
        geometries.iter().filter_map(magnitude).sum::<f64>()
    });
}

/// The same with earthshine, its nodes made once for all directions.
#[divan::bench(args = SUNS_DEG, sample_count = 20)]
fn map_24448_with_earthshine(bencher: Bencher, sun_deg: f64) {
    let (model, geometries) = (model(), geometries_of_map(sun_deg));
    let satellite = *model.satellite().expect("made of panels");
    bencher.bench(|| {
        let exponent = satellite.base_exponent();
        let nodes = EarthshineNodes::new(sun_deg.to_radians(), 550.0, &Albedo::Uniform(PAPER_ALBEDO), exponent);
        let total = |geometry: &ViewingGeometry| {
            let to_observer = *geometry.to_observer().vector();
            let shine = nodes.shine(&-Vector3::z(), &to_observer, exponent);
            let earth = satellite.earth_terms_of(&shine, &to_observer);
            satellite.terms(geometry).b_total_m2_sr() + earth.glossy_m2_sr + earth.diffuse_m2_sr
        };
        black_box(&geometries).iter().map(|geometry| -2.5 * total(geometry).log10()).sum::<f64>()
    });
}

fn geometries_of_map(sun_deg: f64) -> Vec<ViewingGeometry> {
    let mut geometries = geometries(MAP, sun_deg);
    geometries.iter_mut().for_each(|geometry| geometry.sun_latitude_rad = sun_deg.to_radians());
    geometries
}
