//! Earthshine: the quadrature compared with finer ones, with HEALPix, and with closed forms.

use crate::common::agreement::Agreement;
use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;
use streakcast::constants::EARTH_EQUATORIAL_RADIUS_KM;
use streakcast::geometry::ViewingGeometry;
use streakcast::math::healpix::{cell_count, ring_centre_rad};
use streakcast::photometry::brdf::{Brdf, Incidence, Lambert, Phong};
use streakcast::photometry::earthshine::{EARTH_ALBEDO, LitEarth, PanelEarthshine};
use streakcast::photometry::{BrightnessModel, Earthshine, ModelLibrary, PhotometryOptions};

/// Specified accuracy of the quadrature for a chassis lit only by the Earth, mag.
const EARTHSHINE_MAG: f64 = 1e-3;
/// Returns an exponent for which the quadrature has at least 2.5 times the nodes in each direction.
fn finer(exponent: f64) -> f64 {
    if exponent > 60.0 { 1000.0 } else { 400.0 }
}

fn down() -> Vector3<f64> {
    -Vector3::z()
}

/// Returns the unit vector at an angle from the nadir and a longitude from that of the Sun, degrees.
fn below(nadir_deg: f64, longitude_deg: f64) -> Vector3<f64> {
    let (sin, cos) = nadir_deg.to_radians().sin_cos();
    let (sin_lon, cos_lon) = longitude_deg.to_radians().sin_cos();
    Vector3::new(sin * cos_lon, sin * sin_lon, -cos)
}

/// Returns the light on the chassis; zero if no visible ground is lit.
fn shine(sun_rad: f64, height_km: f64, to_observer: &Vector3<f64>, exponent: f64) -> PanelEarthshine {
    LitEarth::new(sun_rad, height_km).map(|earth| earth.shine(&down(), to_observer, exponent)).unwrap_or_default()
}

/// Returns the same light as a sum over sources.
fn shine_of(sources: &[(Vector3<f64>, f64)], to_observer: &Vector3<f64>, exponent: f64) -> PanelEarthshine {
    let mirror = Vector3::new(-to_observer.x, -to_observer.y, to_observer.z);
    let mut sum = PanelEarthshine::default();
    for (direction, irradiance) in sources {
        let lit = irradiance * -direction.z;
        sum.irradiance += lit;
        sum.lobe += lit * direction.dot(&mirror).max(0.0).powf(exponent);
    }
    sum
}

/// Returns directions and irradiances of the lit and visible equal-area pixels of the Earth, as in the paper. Pixels
/// are flat and evaluated at their centres, so that one at the terminator or the limb counts completely or not at all.
/// The pole of the pixel grid is at the nadir.
fn healpix_earth(sun_rad: f64, height_km: f64, nside: u32) -> Vec<(Vector3<f64>, f64)> {
    let radius_km = EARTH_EQUATORIAL_RADIUS_KM;
    let satellite_km = Vector3::new(0.0, 0.0, radius_km + height_km);
    let sun = Vector3::new(sun_rad.cos(), 0.0, sun_rad.sin());
    let area_km2 = 4.0 * PI * radius_km * radius_km / cell_count(nside) as f64;
    let limb_rad = FRAC_PI_2 - dip_deg(height_km).to_radians();
    (0..cell_count(nside))
        .map_while(|cell| ring_centre_rad(nside, cell))
        // Rings are ordered from the pole downwards.
        .take_while(|&(_, latitude)| latitude > limb_rad)
        .filter_map(|(longitude, latitude)| {
            let (up, along) = latitude.sin_cos();
            let ground = Vector3::new(along * longitude.cos(), along * longitude.sin(), up);
            let to_ground_km = ground * radius_km - satellite_km;
            let distance_km = to_ground_km.norm();
            let direction = to_ground_km / distance_km;
            let (cos_sun, cos_view) = (ground.dot(&sun), -ground.dot(&direction));
            // dE = (albedo/π) cos(Sun) cos(view) A_pix / d²                  Lu (2024), section 2.4
            let irradiance = EARTH_ALBEDO / PI * cos_sun * cos_view * area_km2 / (distance_km * distance_km);
            (cos_sun > 0.0 && cos_view > 0.0).then_some((direction, irradiance))
        })
        .collect()
}

/// Returns the light of a chassis with c4 and c5 of the bundled Starlink V1.5, without area and cos φ_r.
fn chassis(shine: &PanelEarthshine, exponent: f64) -> f64 {
    0.0915 / PI * shine.irradiance + 0.1889 * (exponent + 2.0) / (2.0 * PI) * shine.lobe
}

fn magnitudes_apart(a: f64, b: f64) -> f64 {
    (2.5 * (a / b).log10()).abs()
}

fn dip_deg(height_km: f64) -> f64 {
    (EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + height_km)).acos().to_degrees()
}

/// Returns latitudes of the Sun from almost no lit ground to completely lit visible ground, degrees.
fn suns(height_km: f64) -> Vec<f64> {
    let dip = dip_deg(height_km);
    let mut suns = vec![-0.97 * dip, -0.8 * dip, 0.95 * dip, 60.0];
    suns.extend([-20.0, -14.0, -8.0, -2.0, -0.3, 0.0, 0.02, 1.0, 5.0, 10.0].into_iter().filter(|sun| sun + dip > 0.5));
    suns
}

#[test]
fn verif_rule_against_a_far_finer_one() {
    for exponent in [1.0, 1.5, 2.0, 5.0, 22.0, 60.0, 200.0] {
        let mut worst = 0.0_f64;
        for height_km in [200.0, 340.0, 550.0, 1200.0, 35_786.0] {
            for sun in suns(height_km).into_iter().map(f64::to_radians) {
                let earth = LitEarth::new(sun, height_km).unwrap();
                let fine = earth.sources(finer(exponent));
                for (nadir, longitude) in
                    [(0.0, 0.0), (20.0, 0.0), (45.0, 110.0), (58.0, 180.0), (64.0, 40.0), (64.0, 170.0), (75.0, 150.0)]
                {
                    let to_observer = below(nadir, longitude);
                    let computed = earth.shine(&down(), &to_observer, exponent);
                    let exact = shine_of(&fine, &to_observer, exponent);
                    let apart = magnitudes_apart(chassis(&computed, exponent), chassis(&exact, exponent));
                    worst = worst.max(apart);
                    // For the Lambertian part alone, the error is far smaller.
                    assert!((computed.irradiance / exact.irradiance - 1.0).abs() < 1e-4);
                }
            }
        }
        let nodes =
            suns(550.0).into_iter().map(|sun| LitEarth::new(sun.to_radians(), 550.0).unwrap().sources(exponent).len());
        println!("n {exponent:5}: {worst:.1e} mag, {} nodes at 550 km", nodes.max().unwrap());
        assert!(worst < EARTHSHINE_MAG, "n {exponent}: {worst} mag");
    }
}

/// Prints the table of convergence in the documentation of the module.
#[test]
fn valid_rule_against_healpix() {
    let (exponent, height_km) = (22.0, 550.0);
    let mut errors = [[0.0_f64; 2]; 5];
    let mut cells = [0; 5];
    for sun_deg in [-12.0_f64, -5.0, -1.0, 3.0, 10.0, 40.0] {
        let sun = sun_deg.to_radians();
        let earths = [32, 64, 128, 256, 512].map(|nside| healpix_earth(sun, height_km, nside));
        for (cells, earth) in cells.iter_mut().zip(&earths) {
            *cells = (*cells).max(earth.len());
        }
        for (nadir, longitude) in [(0.0, 0.0), (30.0, 180.0), (55.0, 160.0), (60.0, 60.0)] {
            let to_observer = below(nadir, longitude);
            let computed = shine(sun, height_km, &to_observer, exponent);
            for (error, earth) in errors.iter_mut().zip(&earths) {
                let sum = shine_of(earth, &to_observer, exponent);
                error[0] = error[0].max((sum.irradiance / computed.irradiance - 1.0).abs());
                error[1] = error[1].max(magnitudes_apart(chassis(&sum, exponent), chassis(&computed, exponent)));
            }
        }
    }
    for (i, error) in errors.iter().enumerate() {
        println!("nside {:3}, {:6} cells: diffuse {:.1e}, total {:.1e} mag", 32 << i, cells[i], error[0], error[1]);
    }
    // Pixels at the terminator and the limb count completely or not at all, which causes this error at nside 512.
    assert!(errors[4][0] < 5e-4, "{errors:?}");
    Agreement::new("Earthshine of a chassis", "sum over HEALPix cells, nside 512", EARTHSHINE_MAG, "mag")
        .add(errors[4][1]);
    assert!(errors[0][1] > 3.0 * errors[4][1], "the coarse Earth is coarser");
}

#[test]
fn verif_a_uniformly_lit_earth_gives_its_solid_angle() {
    for height_km in [200.0, 550.0, 2000.0, 35_786.0] {
        let ratio = EARTH_EQUATORIAL_RADIUS_KM / (EARTH_EQUATORIAL_RADIUS_KM + height_km);
        // With the Sun in the zenith all visible ground is lit. Divided by the cosine, the illumination is uniform.
        let plate: f64 = LitEarth::new(FRAC_PI_2, height_km)
            .unwrap()
            .sources(60.0)
            .into_iter()
            .map(|(direction, irradiance)| {
                let (cos, sin) = (-direction.z, direction.x.hypot(direction.y));
                let gamma = (sin / ratio).min(1.0).asin() - sin.atan2(cos);
                irradiance * cos / gamma.cos()
            })
            .sum();
        assert!((plate / (EARTH_ALBEDO * ratio * ratio) - 1.0).abs() < 1e-6, "{height_km} km: {plate}");
    }
}

#[test]
fn valid_diffuse_light_against_the_worked_ratios() {
    // Relative tolerance: the reference ratios of earthshine to direct light on the chassis at 550 km were computed on
    // a mesh and rounded.
    const MESH_AND_ROUNDING: f64 = 0.03;
    for (sun_deg, expected) in [(-2.0_f64, 0.118), (-8.0, 0.0044), (-14.0, 2.8e-4), (-20.0, 3e-6)] {
        let sun = sun_deg.to_radians();
        let shine = shine(sun, 550.0, &down(), 22.0);
        let ratio = shine.irradiance / -sun.sin();
        println!("{sun_deg}: {ratio:.3e}");
        assert!((ratio / expected - 1.0).abs() < MESH_AND_ROUNDING, "{sun_deg} deg: {ratio}");
    }
}

#[test]
fn verif_no_light_below_the_dip_of_the_horizon() {
    let dip = dip_deg(550.0);
    assert!((dip - 22.98).abs() < 0.01);
    let lit = |sun_deg: f64| shine(sun_deg.to_radians(), 550.0, &below(60.0, 180.0), 22.0);
    assert!(LitEarth::new((-dip - 1e-6).to_radians(), 550.0).is_none());
    let last = lit(-dip + 0.1);
    assert!(last.irradiance > 0.0 && last.irradiance < 1e-9 && last.lobe > 0.0, "{last:?}");
    assert!(healpix_earth(-0.5, 550.0, 64).is_empty());
    for nonsense in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
        assert_eq!(LitEarth::new(0.3, nonsense), None);
    }
    assert_eq!(LitEarth::new(f64::NAN, 550.0), None);
}

#[test]
fn verif_panels_of_any_orientation_against_laws_source_by_source() {
    let earth = LitEarth::new(0.05, 550.0).unwrap();
    let (diffuse, glossy) = (Lambert { albedo: 1.0 }, Phong { weight: 1.0, exponent: 22.0 });
    for normal in [down(), Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.6, -0.48, -0.64)] {
        let to_observer = below(50.0, 20.0);
        let fast = earth.shine(&normal, &to_observer, 22.0);
        let sum = |law: &dyn Fn(&Incidence) -> f64| -> f64 {
            let of_source = |(to_source, irradiance): (Vector3<f64>, f64)| {
                let incidence = Incidence::new(&normal, &to_source, &to_observer);
                irradiance * law(&incidence) * incidence.cos_in.max(0.0)
            };
            earth.sources(22.0).into_iter().map(of_source).sum()
        };
        let by_diffuse = sum(&|incidence| diffuse.value_per_sr(incidence));
        let by_glossy = sum(&|incidence| glossy.value_per_sr(incidence));
        for (fast, plain) in [(fast.irradiance / PI, by_diffuse), (fast.lobe * 24.0 / (2.0 * PI), by_glossy)] {
            // Compared with the series of the power law.
            assert!((fast / plain - 1.0).abs() < 1e-9, "{fast} {plain}");
        }
    }
    // A panel that faces up receives no light from the ground.
    assert_eq!(earth.shine(&Vector3::z(), &Vector3::x(), 22.0).irradiance, 0.0);
}

#[test]
fn verif_the_switch() {
    let library = ModelLibrary::embedded();
    let model = library.get("starlink-v1.5").unwrap();
    let on = PhotometryOptions::default();
    let off = PhotometryOptions { earthshine: Earthshine::Off, ..on };
    let satellite = model.satellite().unwrap();
    for (sun_deg, longitude_deg, observer_deg) in
        [(-2.5_f64, 160.0_f64, -40.0_f64), (-8.0, 30.0, -60.0), (-4.0, 170.0, -70.0)]
    {
        let geometry = ViewingGeometry::from_angles(
            sun_deg.to_radians(),
            longitude_deg.to_radians(),
            observer_deg.to_radians(),
            900.0,
            550.0,
        )
        .unwrap();
        let terms = satellite.terms_with(&geometry, Earthshine::Computed);
        assert!(terms.earth_diffuse_m2_sr > 0.0 && terms.earth_glossy_m2_sr > 0.0);
        assert_eq!(satellite.terms_with(&geometry, Earthshine::Off), satellite.terms(&geometry));
        assert_eq!(terms.sunlight_m2_sr(), satellite.terms(&geometry).b_total_m2_sr());
        // Without earthshine the magnitude is that of sunlight.
        let plain = -2.5 * (terms.sunlight_m2_sr() / 1e12).log10() - 26.76 + 5.0 * 0.9_f64.log10();
        let without = model.brightness(&geometry, 1.0, &off).unwrap().magnitude.0;
        assert!((without - plain).abs() < 1e-9);
        // With earthshine it is brighter by the ratio of the two terms.
        let with = model.brightness(&geometry, 1.0, &on).unwrap().magnitude.0;
        let gain = 2.5 * (terms.b_total_m2_sr() / terms.sunlight_m2_sr()).log10();
        assert!((without - with - gain).abs() < 1e-9 && gain > 0.0);
        let standard = model.standard_magnitude_with(&geometry, Earthshine::Computed).unwrap();
        assert!((standard.at_range(900.0).0 - with).abs() < 1e-9);
        // In the penumbra, sunlight is dimmed and earthshine is not.
        let dimmed = model.brightness(&geometry, 0.25, &on).unwrap().magnitude.0;
        let expected =
            -2.5 * ((0.25 * terms.sunlight_m2_sr() + terms.earthshine_m2_sr()) / terms.b_total_m2_sr()).log10();
        assert!((dimmed - with - expected).abs() < 1e-9);
    }
}

/// The chassis of the paper as a list of panels receives the same earthshine as in the two-panel form; with earthshine
/// on the array too, there is more light.
#[test]
fn verif_panels_receive_earthshine_if_enabled() {
    let two = ModelLibrary::embedded().get("starlink-v1.5").unwrap();
    let c = two.file().unwrap().coefficients.unwrap();
    let model = |sail: bool| {
        let text = serde_json::json!({
            "schema": 1, "name": "own", "title": "Own", "kind": "panels", "band": "V", "mag_system": "Vega", "size_m": 4.0,
            "panels": {"parameters": [], "panels": [
                {"name": "sail", "anchor_m": [0, 0, 0], "u_m": [-1.4, 1.4], "v_m": [0, 8.1],
                 "attitude": {"law": "sun_azimuth", "offset_deg": 0}, "front": [{"law": "lambert", "albedo": c.c2}],
                 "through": [{"law": "lambert", "albedo": c.c3}], "earthshine": sail},
                {"name": "chassis", "anchor_m": [0, 0, 0], "u_m": [-1.4, 1.4], "v_m": [0, 1.3], "attitude": {"law": "nadir"},
                 "front": [{"law": "phong", "weight": c.c4, "exponent": c.n_base}, {"law": "lambert", "albedo": c.c5}],
                 "earthshine": true}],
                "blocking": [{"panel": "sail", "by": "chassis"}]},
            "covariance": null, "rms_mag": null, "sigma_mag": 0.3, "sigma_origin": "assumed",
            "geometry_range": null,
            "provenance": {"source": "a test", "data": "none", "n_points": null, "date": "2026", "provisional": true, "notes": []}
        });
        BrightnessModel::from_json(&text.to_string(), "own").unwrap()
    };
    let mut more = 0;
    for (sun_deg, longitude_deg, latitude_deg) in
        [(-8.0, 170.0, -50.0), (-2.0, 120.0, -30.0), (3.0, 30.0, -60.0), (1.0, 10.0, -20.0), (-15.0, 180.0, -80.0)]
    {
        let [sun, longitude, latitude] = [sun_deg, longitude_deg, latitude_deg].map(f64::to_radians);
        let geometry = ViewingGeometry::from_angles(sun, longitude, latitude, 900.0, 550.0).unwrap();
        let magnitude =
            |model: &BrightnessModel| model.standard_magnitude_with(&geometry, Earthshine::Computed).unwrap().0;
        let (closed, panels, wide) = (magnitude(&two), magnitude(&model(false)), magnitude(&model(true)));
        // Two quadratures of the same Earth, each with an error of 4e-4 mag for a chassis without other light.
        assert!((closed - panels).abs() < 1e-3, "{closed} {panels} at {sun_deg}");
        assert!(wide <= panels);
        more += usize::from(wide < panels - 1e-3);
    }
    assert!(more >= 2, "{more}");
}
