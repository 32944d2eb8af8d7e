//! Force of sunlight on panels and spheres, compared with closed forms and with the integral of the modelled light.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use serde_json::{Value, json};
use streakcast::constants::AU_KM;
use streakcast::frames::{Direction, Gcrs, Position};
use streakcast::geometry::ShadowModel;
use streakcast::photometry::panels::SunlightForce;
use streakcast::photometry::{BrightnessModel, ModelLibrary};

use crate::photometry_panels::file;

/// Tolerance of forces, relative to pressure times area: the quadrature (1e-3), and lobes of one degree instead of
/// mirrors.
const TOLERANCE: f64 = 2e-3;
/// Tolerance of components that vanish by symmetry, relative to the force: the obstruction of some single directions
/// depends on rounding.
const SYMMETRY: f64 = 1e-6;
/// Tolerance of results without quadrature.
const ROUNDING: f64 = 1e-12;

/// Area of the plate, m².
const PLATE_M2: f64 = 6.0;

/// Returns the direction to the Sun at an angle from the zenith, degrees.
fn sun(zenith_angle_deg: f64) -> Direction<streakcast::frames::Body> {
    Direction::from_lon_lat_rad(0.0, (90.0 - zenith_angle_deg).to_radians())
}

fn model(panels: Value) -> BrightnessModel {
    BrightnessModel::from_json(&file(panels, Value::Null), "test").unwrap()
}

/// Returns the force on a plate of 2 x 3 m whose front faces the zenith.
fn plate(front: Value, back: Value, through: Value, zenith_angle_deg: f64) -> SunlightForce {
    let model = model(json!({
        "parameters": [],
        "panels": [{
            "name": "plate", "anchor_m": [0, 0, 0], "u_m": [-1, 1], "v_m": [0, 3],
            "attitude": {"law": "fixed", "normal": [0, 0, 1], "v": [1, 0, 0]},
            "front": front, "back": back, "through": through
        }]
    }));
    model.sunlight_force(&sun(zenith_angle_deg)).unwrap()
}

fn assert_close(ours: &SunlightForce, expected_m2: Vector3<f64>, tolerance_m2: f64, name: &str) {
    let distance = (ours.per_pressure_m2 - expected_m2).norm();
    assert!(distance < tolerance_m2, "{name}: {:?} {expected_m2:?}, {distance}", ours.per_pressure_m2);
}

#[test]
fn valid_flat_plates_have_the_force_of_closed_forms() {
    let normal = Vector3::z();
    for angle in [0.0_f64, 30.0, 60.0, 75.0] {
        let to_sun = *sun(angle).vector();
        let mirror = normal * (2.0 * normal.dot(&to_sun)) - to_sun;
        let cos = angle.to_radians().cos();
        let section_m2 = PLATE_M2 * cos;
        let none = || json!([]);
        let black = json!([{"law": "lambert", "albedo": 0}]);
        // F = -P A cos φ s
        let force = plate(black.clone(), none(), none(), angle);
        assert_close(&force, -to_sun * section_m2, ROUNDING, "black");
        assert!((force.cross_section_m2 - section_m2).abs() < ROUNDING);
        // F = -P A cos φ (s + 2/3 ρ n)
        let diffuse = json!([{"law": "lambert", "albedo": 0.6}]);
        let force = plate(diffuse.clone(), none(), none(), angle);
        assert_close(&force, -(to_sun + normal * 0.4) * section_m2, TOLERANCE * PLATE_M2, "Lambertian");
        // Lossless facets of 0.6 deg are a mirror: F = -2 P A cos² φ n
        let facets = json!([{"law": "facets", "weight": 1, "slope": 0.01}]);
        let force = plate(facets, none(), none(), angle);
        assert_close(&force, -normal * (2.0 * PLATE_M2 * cos * cos), TOLERANCE * PLATE_M2, "mirror");
        // A narrow Phong lobe reflects c cos φ: F = -P A cos φ (s + c cos φ m)
        let phong = json!([{"law": "phong", "weight": 0.8, "exponent": 3000}]);
        let force = plate(phong, none(), none(), angle);
        assert_close(&force, -(to_sun + mirror * (0.8 * cos)) * section_m2, TOLERANCE * PLATE_M2, "Phong");
        // Transmitted light carries momentum away: F = -P A cos φ (s - 2/3 τ n) if it is diffuse, and
        // F = -P A cos φ (s - c cos φ s) if it passes straight through.
        let force = plate(black.clone(), none(), diffuse.clone(), angle);
        assert_close(&force, -(to_sun - normal * 0.4) * section_m2, TOLERANCE * PLATE_M2, "diffuse transmission");
        let straight = json!([{"law": "straight", "weight": 0.8, "exponent": 3000}]);
        let force = plate(black.clone(), none(), straight, angle);
        assert_close(&force, -to_sun * (section_m2 * (1.0 - 0.8 * cos)), TOLERANCE * PLATE_M2, "straight");
        // The back, lit from below.
        let force = plate(black, diffuse, none(), 180.0 - angle);
        let below = *sun(180.0 - angle).vector();
        assert_close(&force, -(below - normal * 0.4) * section_m2, TOLERANCE * PLATE_M2, "Lambertian back");
    }
}

#[test]
fn valid_spheres_have_the_force_of_closed_forms() {
    const ALBEDO: f64 = 0.45;
    let radius_m: f64 = 1.3;
    let disc_m2 = PI * radius_m * radius_m;
    let to_sun = *sun(40.0).vector();
    // F = -π r² P (1 + 4/9 ρ) s                     Lambertian sphere
    for (phase, factor) in [("lambert", 1.0 + 4.0 / 9.0 * ALBEDO), ("isotropic", 1.0)] {
        let sphere = json!({"name": "sphere", "area_m2": disc_m2, "albedo": ALBEDO, "phase": phase});
        // A model requires a panel: this one is seen edge-on by the Sun.
        let across = json!({
            "name": "edge", "anchor_m": [0, 0, 0], "u_m": [0, 1], "v_m": [0, 1],
            "attitude": {"law": "fixed", "normal": [0, 1, 0], "v": [1, 0, 0]},
            "front": [{"law": "lambert", "albedo": ALBEDO}]
        });
        let model = model(json!({"parameters": [], "panels": [across], "spheres": [sphere]}));
        let force = model.sunlight_force(&sun(40.0)).unwrap();
        assert_close(&force, -to_sun * (factor * disc_m2), ROUNDING, phase);
    }
    // A sphere of Lambertian plates, whose normals have the cosines μ: F = -2π r² P ∫ μ (1 + 2/3 ρ μ) dμ s. Two points
    // of a Gauss-Legendre rule on (0, 1) are exact for it.
    let diffuse = json!([{"law": "lambert", "albedo": ALBEDO}]);
    let sum: f64 = [-1.0, 1.0]
        .iter()
        .map(|sign| {
            let cos: f64 = 0.5 + sign * 0.5 / 3f64.sqrt();
            let angle_deg = cos.acos().to_degrees();
            let force = plate(diffuse.clone(), json!([]), json!([]), angle_deg);
            // Components across the direction of the Sun cancel on the sphere.
            -force.per_pressure_m2.dot(sun(angle_deg).vector()) / PLATE_M2 * TAU * radius_m * radius_m * 0.5
        })
        .sum();
    assert!((sum / disc_m2 - (1.0 + 4.0 / 9.0 * ALBEDO)).abs() < TOLERANCE, "{}", sum / disc_m2);
}

/// Returns ∫ B(o) o dω of the sunlight that a model reflects and transmits, m², on a grid of equal areas.
fn outgoing_m2(b_m2_sr: impl Fn(&Vector3<f64>) -> f64) -> Vector3<f64> {
    const RINGS: usize = 300;
    const AZIMUTHS: usize = 600;
    let mut sum = Vector3::zeros();
    for ring in 0..RINGS {
        let z = 2.0 * (ring as f64 + 0.5) / RINGS as f64 - 1.0;
        let across = (1.0 - z * z).sqrt();
        for azimuth in 0..AZIMUTHS {
            let psi = TAU * (azimuth as f64 + 0.5) / AZIMUTHS as f64;
            let to_observer = Vector3::new(across * psi.cos(), across * psi.sin(), z);
            sum += to_observer * b_m2_sr(&to_observer);
        }
    }
    sum * (2.0 * TAU / (RINGS * AZIMUTHS) as f64)
}

/// The force of every built-in model of panels is that of the light that its magnitudes are computed from.
#[test]
fn verif_the_force_is_the_momentum_of_the_modelled_light() {
    let library = ModelLibrary::embedded();
    let mut compared = 0;
    for name in library.names() {
        let model = library.get(name).unwrap();
        // The closed form of chassis and sail omits the obstruction of the back of the sail by a chassis below it.
        let latitudes: &[f64] = if model.assembly().is_some() { &[-20.0, -5.0, 40.0] } else { &[-20.0, -5.0] };
        for &latitude_deg in latitudes {
            let to_sun = Direction::from_lon_lat_rad(0.0, latitude_deg.to_radians());
            let Some(force) = model.sunlight_force(&to_sun) else { continue };
            let light_m2 = outgoing_m2(|to_observer| match (model.assembly(), model.satellite()) {
                (Some(assembly), _) => assembly.b_total_m2_sr(to_sun.vector(), to_observer),
                (None, Some(satellite)) => satellite.terms_of_directions(to_sun.vector(), to_observer).b_total_m2_sr(),
                (None, None) => f64::NAN,
            });
            let expected_m2 = -(to_sun.vector() * force.cross_section_m2 + light_m2);
            assert_close(&force, expected_m2, TOLERANCE * force.cross_section_m2, name);
            compared += 1;
        }
    }
    // Five models of the kind panels and one of two panels.
    assert_eq!(compared, 5 * 3 + 2);
}

/// Chassis and sail of equal width share a hinge: with the Sun below the chassis, their shadow is as high as the larger
/// of the two projected lengths.
#[test]
fn valid_the_cross_section_of_chassis_and_sail_counts_shaded_area_once() {
    let library = ModelLibrary::embedded();
    let [sail_m, base_m, width_m] = [8.1, 1.3, 2.8];
    for name in ["starlink-v1.5-facets", "starlink-v1.5"] {
        for latitude_deg in [-10.0_f64, -45.0, -85.0] {
            let to_sun = Direction::from_lon_lat_rad(0.0, latitude_deg.to_radians());
            let force = library.get(name).unwrap().sunlight_force(&to_sun).unwrap();
            let (sin, cos) = latitude_deg.to_radians().abs().sin_cos();
            let expected_m2 = width_m * (sail_m * cos).max(base_m * sin);
            assert!((force.cross_section_m2 - expected_m2).abs() < 1e-9, "{name}: {force:?} {expected_m2}");
        }
    }
}

#[test]
fn valid_accelerations_scale_with_light_distance_and_mass() {
    // 4.5398e-6 N/m²
    const PRESSURE_N_M2: f64 = 1361.0 / 299_792_458.0;
    let model = ModelLibrary::embedded().get("visorsat-panels").unwrap();
    let satellite = Position::<Gcrs>::new(-2000.0, 3000.0, 5900.0);
    let sun = Position::<Gcrs>::new(0.9 * AU_KM, 0.3 * AU_KM, -0.2 * AU_KM);
    let at = |lit_fraction, mass_kg| model.sunlight_acceleration(&satellite, &sun, lit_fraction, mass_kg);
    let full = *at(1.0, 250.0).unwrap().vector();
    let to_sun = sun - satellite;
    let to_sun_direction = to_sun.direction().unwrap();
    // The latitude of the Sun above the chassis is 90 deg minus its angle from the zenith.
    let latitude_rad = PI / 2.0 - satellite.direction().unwrap().separation_rad(&to_sun_direction);
    let force = model.sunlight_force(&Direction::from_lon_lat_rad(0.0, latitude_rad)).unwrap();
    let expected_m_s2 = force.per_pressure_m2 * PRESSURE_N_M2 / 250.0 / (to_sun.norm_km() / AU_KM).powi(2);
    assert!((full.norm() / expected_m_s2.norm() - 1.0).abs() < 1e-9, "{full:?} {expected_m_s2:?}");
    let [along, expected] = [
        full.dot(to_sun_direction.vector()),
        expected_m_s2.dot(Direction::<Gcrs>::from_lon_lat_rad(0.0, latitude_rad).vector()),
    ];
    assert!((along / expected - 1.0).abs() < 1e-9 && along < 0.0, "{along} {expected}");
    // The models are symmetric about the plane of zenith and Sun.
    let across = satellite.vector().cross(to_sun.vector()).normalize();
    assert!(full.dot(&across).abs() < SYMMETRY * full.norm());
    let half = at(0.5, 500.0).unwrap();
    assert!((half.vector() * 4.0 - full).norm() < 1e-12 * full.norm());
    assert_eq!(at(0.0, 250.0).unwrap().vector().norm(), 0.0);

    // In the penumbra the fraction is that of the shadow.
    let eclipsed = Position::<Gcrs>::new(-6900.0, 0.0, 0.0);
    let behind = Position::<Gcrs>::new(AU_KM, 0.0, 0.0);
    let lit_fraction = ShadowModel::default().illumination(&eclipsed, &behind).lit_fraction();
    let dark = model.sunlight_acceleration(&eclipsed, &behind, lit_fraction, 250.0).unwrap();
    assert!(dark.vector().norm() < 0.01 * full.norm());

    for (lit_fraction, mass_kg) in [(1.0, 0.0), (1.0, -1.0), (1.0, f64::NAN), (f64::NAN, 250.0), (1.5, 250.0)] {
        assert_eq!(at(lit_fraction, mass_kg), None, "{lit_fraction} {mass_kg}");
    }
    assert_eq!(model.sunlight_acceleration(&Position::new(0.0, 0.0, 0.0), &sun, 1.0, 250.0), None);
    for name in ["oneweb", "visorsat", "unknown"] {
        let model = ModelLibrary::embedded().get(name).unwrap();
        assert_eq!(model.sunlight_acceleration(&satellite, &sun, 1.0, 250.0), None, "{name}");
    }
}
