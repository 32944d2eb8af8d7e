//! Fits of models made of panels and spheres: magnitudes, recovered parameters, and phase functions.

use streakcast::fit::{FitPoint, FitSettings, Form, PanelsForm, PhaseForm, Problem, SphereForm, predict, range_of};
use streakcast::geometry::ViewingGeometry;
use streakcast::photometry::{BrightnessModel, Earthshine};

/// Model file: chassis with a facet law, a translucent sail above it, and a sphere named clutter.
const SATELLITE: &str = r#"{
  "schema": 1, "name": "invented", "title": "An invented satellite", "kind": "panels", "band": "V", "mag_system": "Vega", "size_m": 4.0,
  "panels": {
    "parameters": [
      { "name": "sail_diffuse", "value": 0.03 }, { "name": "sail_straight", "value": 0.02 }, { "name": "n_straight", "value": 9.0 },
      { "name": "base_diffuse", "value": 0.1 }, { "name": "base_facets", "value": 0.05 }, { "name": "base_slope", "value": 0.15 },
      { "name": "clutter", "value": 0.004 }
    ],
    "panels": [
      { "name": "sail", "anchor_m": [0, 0, 0], "u_m": [-1.4, 1.4], "v_m": [0, 8.1], "attitude": { "law": "sun_azimuth", "offset_deg": 0 },
        "front": [{ "law": "lambert", "albedo": "sail_diffuse" }],
        "through": [{ "law": "straight", "weight": "sail_straight", "exponent": "n_straight" }] },
      { "name": "base", "anchor_m": [0, 0, 0], "u_m": [-1.4, 1.4], "v_m": [0, 1.3], "attitude": { "law": "nadir" },
        "front": [{ "law": "lambert", "albedo": "base_diffuse" }, { "law": "facets", "weight": "base_facets", "slope": "base_slope" }],
        "earthshine": true }
    ],
    "spheres": [{ "name": "clutter", "area_m2": 10, "albedo": "clutter", "phase": "isotropic" }],
    "blocking": [{ "panel": "sail", "by": "base" }]
  },
  "covariance": null, "rms_mag": null, "sigma_mag": 0.5, "sigma_origin": "assumed", "geometry_range": null,
  "provenance": { "source": "made up", "data": "none", "n_points": null, "date": "2026-11", "provisional": true, "notes": [] }
}"#;

fn model() -> BrightnessModel {
    BrightnessModel::from_json(SATELLITE, "invented").expect("a model")
}

fn form(earthshine: Earthshine) -> PanelsForm {
    let model = model();
    let (band, system) = model.band();
    let spec = model.file().and_then(|file| file.panels.clone()).expect("panels");
    PanelsForm { spec, earthshine, sun_magnitude: band.sun_magnitude(system) }
}

fn points() -> Vec<FitPoint> {
    let suns = [-20.0, -14.0, -7.0, -1.0];
    let directions = (0..13).flat_map(|i| (0..9).map(move |j| (15.0 * f64::from(i), -20.0 - 7.5 * f64::from(j))));
    let directions: Vec<(f64, f64)> = directions.collect();
    let at = |sun: f64, (longitude, latitude): (f64, f64)| {
        let [sun, longitude, latitude] = [sun, longitude, latitude].map(f64::to_radians);
        let geometry = ViewingGeometry::from_angles(sun, longitude, latitude, 1000.0, 550.0).expect("a geometry");
        FitPoint { geometry, magnitude: 6.0, sigma_mag: 0.1, weight: 1.0, group: (longitude * 100.0) as u32 }
    };
    suns.iter().flat_map(|&sun| directions.iter().map(move |&direction| at(sun, direction))).collect()
}

/// Error of the interpolation of earthshine between nodes of slope and exponent, mag.
const EARTH_MAG: f64 = 2e-3;

#[test]
fn verif_magnitudes_equal_those_of_the_model() {
    let (model, points) = (model(), points());
    for (earthshine, tolerance) in [(Earthshine::Off, 1e-9), (Earthshine::Computed, EARTH_MAG)] {
        let form = form(earthshine);
        let values: Vec<f64> = form.parameters().iter().map(|parameter| parameter.value).collect();
        let mut seen = 0;
        for (point, predicted) in points.iter().zip(predict(&form, &points, &values)) {
            if let Some(expected) = model.standard_magnitude_with(&point.geometry, earthshine) {
                assert!((predicted - expected.0).abs() < tolerance, "{point:?}: {predicted} {expected}");
                seen += 1;
            }
        }
        assert_eq!(seen, points.len());
    }
}

#[test]
fn verif_parameters_are_recovered() {
    for earthshine in [Earthshine::Off, Earthshine::Computed] {
        let form = form(earthshine);
        let truth: Vec<f64> = form.parameters().iter().map(|parameter| parameter.value).collect();
        let mut points = points();
        let magnitudes = predict(&form, &points, &truth);
        points.iter_mut().zip(magnitudes).for_each(|(point, magnitude)| point.magnitude = magnitude);
        // The fit starts from other values.
        let mut begun = form.clone();
        for (parameter, value) in begun.spec.parameters.iter_mut().zip([0.1, 0.1, 30.0, 0.3, 0.3, 0.05, 0.1]) {
            parameter.value = value;
        }
        let names: Vec<String> = begun.parameters().into_iter().map(|parameter| parameter.name).collect();
        let settings = FitSettings { free: names, ..FitSettings::default() };
        let fit = Problem::new(&begun, &points, &settings).expect("a problem").solve().expect("a fit");
        /// Relative tolerance of parameters fitted without noise; the derivatives are finite differences.
        const SHARE: f64 = 1e-3;
        for (parameter, truth) in fit.parameters.iter().zip(&truth) {
            assert!((parameter.value / truth - 1.0).abs() < SHARE, "{}: {} {truth}", parameter.name, parameter.value);
        }
    }
}

#[test]
fn verif_chassis_and_sail_are_found_among_panels() {
    let two = form(Earthshine::Off).as_two_panels().expect("two panels");
    let shape = two.shape;
    let sizes = [shape.sail_length_m, shape.sail_width_m, shape.base_length_m, shape.base_width_m];
    assert_eq!(sizes, [8.1, 2.8, 1.3, 2.8]);
    let mut bare = form(Earthshine::Off);
    bare.spec.panels.remove(0);
    assert!(bare.as_two_panels().is_none());
}

#[test]
fn verif_a_sphere_and_a_polynomial_in_phase() {
    let mut points = points();
    for point in &mut points {
        let phase = point.geometry.phase_angle_rad().to_degrees() / 90.0 - 1.0;
        point.magnitude = 6.5 + 0.8 * phase - 0.3 * phase * phase;
    }
    let settings = FitSettings::free(&["a0", "a1", "a2"]);
    let fit = Problem::new(&PhaseForm { degree: 2 }, &points, &settings).expect("a problem").solve().expect("a fit");
    for (value, expected) in fit.values().iter().zip([6.5, 0.8, -0.3]) {
        assert!((value - expected).abs() < 1e-9, "{value} {expected}");
    }
    let values = predict(&SphereForm, &points, &[5.0]);
    points.iter_mut().zip(values).for_each(|(point, value)| point.magnitude = value);
    let fit = Problem::new(&SphereForm, &points, &FitSettings::free(&["half_lit_mag"]))
        .expect("a problem")
        .solve()
        .expect("a fit");
    assert!((fit.values()[0] - 5.0).abs() < 1e-9);
    let range = range_of(&points);
    assert_eq!((range.sun_latitude_deg, range.observer_latitude_deg), (Some([-20.0, -1.0]), Some([-80.0, -20.0])));
}
