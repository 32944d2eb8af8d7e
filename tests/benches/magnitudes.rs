//! Time per direction to compute many magnitudes with the two-panel model on one core. Time of predictions with
//! earthshine and sigma, for the default models and the models that they replaced, and for both models of the Earth's
//! shadow. Time to compute the force of sunlight.
//!
//! ```text
//! cargo bench --bench magnitudes            medians for whole columns and for single directions
//! ```

use std::time::Instant;

use streakcast::constants::AU_KM;
use streakcast::frames::{Direction, Gcrs, Position};
use streakcast::geometry::{ShadowModel, ViewingGeometry};
use streakcast::photometry::{BodyAngles, BrightnessModel, ModelLibrary, PhotometryOptions};

const DIRECTIONS: usize = 20_000;
/// Number of directions of a prediction with earthshine.
const FEW: usize = 1000;
const ROUNDS: usize = 51;

fn main() {
    let mut state = 1_u64;
    let mut between = |least: f64, greatest: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        least + (greatest - least) * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let columns: [Vec<f64>; 3] = [(-0.4, -0.05), (0.0, std::f64::consts::TAU), (-1.5, -0.3)]
        .map(|(least, greatest)| (0..DIRECTIONS).map(|_| between(least, greatest)).collect());
    let shipped = ModelLibrary::embedded().get("starlink-v1.5").expect("shipped");
    let mut glossy = shipped.file().expect("from a file").clone();
    glossy.coefficients.as_mut().expect("two panels").c1 = 0.05;
    let glossy = BrightnessModel::from_file(glossy, "glossy").expect("sound");
    for (name, model) in [("starlink-v1.5 (no sail lobe)", &*shipped), ("both lobes", &glossy)] {
        let [sun_latitude_rad, observer_longitude_rad, observer_latitude_rad] = &columns;
        let angles = BodyAngles { sun_latitude_rad, observer_longitude_rad, observer_latitude_rad };
        let mut out = vec![0.0; DIRECTIONS];
        let at_once = median(|| model.standard_magnitudes(&angles, &mut out));
        let one_by_one = median(|| {
            for row in 0..DIRECTIONS {
                let geometry =
                    ViewingGeometry::from_angles(columns[0][row], columns[1][row], columns[2][row], 1000.0, 550.0);
                out[row] = geometry.and_then(|g| model.standard_magnitude(&g)).map_or(f64::NAN, |m| m.0);
            }
        });
        println!("{name}: {at_once:.1} ns a direction at once, {one_by_one:.1} ns one by one");
    }
    for (sun, pair) in [
        (-0.2, ["starlink-v1.5", "starlink-v1.5-facets"]),
        (0.0, ["starlink-v1.5", "starlink-v1.5-facets"]),
        (-0.2, ["v2mini", "v2mini-panels"]),
        (-0.2, ["visorsat", "visorsat-panels"]),
        (-0.2, ["oneweb", "oneweb-panels"]),
        (-0.2, ["unknown", "iridium-next"]),
    ] {
        let [before, after] = pair.map(|name| prediction_ns(name, sun, &columns[1], &columns[2]));
        let ratio = after / before;
        println!("Sun at {sun:.1} rad, {}: {before:.0} ns, {}: {after:.0} ns, ratio {ratio:.2}", pair[0], pair[1]);
    }
    for (range, [least, greatest]) in [("evening", [-0.4, -0.05]), ("grazing", [-0.41, -0.37])] {
        let latitudes: Vec<f64> = (0..FEW).map(|_| between(least, greatest)).collect();
        for name in ["starlink-v1.5", "starlink-v1.5-facets", "unknown"] {
            let [solid, air] = [ShadowModel::Geometric, ShadowModel::default()]
                .map(|shadow| shaded_ns(name, shadow, &latitudes, &columns[1], &columns[2]));
            let ratio = air / solid;
            println!("{range}, {name}: {solid:.0} ns with the solid Earth, {air:.0} ns with air, ratio {ratio:.2}");
        }
    }
    for name in ["starlink-v1.5", "v2mini-panels"] {
        let model = ModelLibrary::embedded().get(name).expect("shipped");
        let to_sun = Direction::from_lon_lat_rad(0.0, -0.2);
        let start = Instant::now();
        let force = model.sunlight_force(&to_sun).expect("panels");
        let elapsed_ms = start.elapsed().as_secs_f64() * 1e3;
        println!("force of sunlight, {name}: {elapsed_ms:.0} ms ({:.1} m2)", force.cross_section_m2);
    }
}

/// Returns the time of a prediction with the Earth's shadow, earthshine and sigma, ns per direction.
fn shaded_ns(
    name: &str,
    shadow: ShadowModel,
    sun_latitudes_rad: &[f64],
    longitudes_rad: &[f64],
    latitudes_rad: &[f64],
) -> f64 {
    const HEIGHT_KM: f64 = 550.0;
    let model = ModelLibrary::embedded().get(name).expect("shipped");
    let options = PhotometryOptions::default();
    let sun = Position::<Gcrs>::new(AU_KM, 0.0, 0.0);
    let cases: Vec<(Position<Gcrs>, ViewingGeometry)> = sun_latitudes_rad
        .iter()
        .zip(longitudes_rad)
        .zip(latitudes_rad)
        .filter_map(|((sun_rad, longitude), latitude)| {
            let (up, across) = sun_rad.sin_cos();
            let radius_km = 6378.137 + HEIGHT_KM;
            let geometry = ViewingGeometry::from_angles(*sun_rad, *longitude, *latitude, 1000.0, HEIGHT_KM)?;
            Some((Position::new(radius_km * up, radius_km * across, 0.0), geometry))
        })
        .collect();
    let mut sum = 0.0;
    let all = median(|| {
        let brightness = |(satellite, geometry): &(Position<Gcrs>, ViewingGeometry)| {
            model.brightness(geometry, shadow.illumination(satellite, &sun).lit_fraction(), &options)
        };
        sum += cases.iter().filter_map(brightness).map(|it| it.sigma_mag).sum::<f64>();
    });
    assert!(sum > 0.0);
    all * DIRECTIONS as f64 / cases.len() as f64
}

/// Returns the time of a prediction with earthshine and sigma, ns per direction. `sun_rad` is the latitude of the Sun.
fn prediction_ns(name: &str, sun_rad: f64, longitudes_rad: &[f64], latitudes_rad: &[f64]) -> f64 {
    let model = ModelLibrary::embedded().get(name).expect("shipped");
    let options = PhotometryOptions::default();
    let directions = longitudes_rad.iter().zip(latitudes_rad).take(FEW);
    let geometries: Vec<ViewingGeometry> = directions
        .filter_map(|(longitude, latitude)| ViewingGeometry::from_angles(sun_rad, *longitude, *latitude, 1000.0, 550.0))
        .collect();
    let mut sum = 0.0;
    let all = median(|| {
        sum += geometries
            .iter()
            .filter_map(|geometry| model.brightness(geometry, 1.0, &options))
            .map(|it| it.sigma_mag)
            .sum::<f64>();
    });
    assert!(sum > 0.0);
    all * DIRECTIONS as f64 / geometries.len() as f64
}

/// Returns the median time per direction, ns.
fn median(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e9 / DIRECTIONS as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[ROUNDS / 2]
}
