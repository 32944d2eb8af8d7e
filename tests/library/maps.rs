//! Magnitude maps compared with an independent computation, and with statements of Lu (2024), section 5.

use crate::common::agreement::Agreement;
use crate::common::maps::{options, v15};
use streakcast::geometry::{ShadowModel, Site};
use streakcast::maps::{BodyView, Earth, Grid, SkyView};
use streakcast::photometry::{BrightnessModel, Coefficients, Earthshine, ModelLibrary, PhotometryOptions};

/// Tolerance of ranges, km: rounding of the roots of a quadratic. An error of one km would be 10⁻³ mag.
const RANGE_KM: f64 = 1e-6;

/// Tolerance of magnitudes: the arccos formulas of the paper lose half of the digits near the nadir.
const MAGNITUDE: f64 = 1e-6;

/// Tolerance of lit fractions, which are computed from 4000 rays to the disk of the Sun.
const LIT_FRACTION: f64 = 0.005;

#[test]
fn valid_sky_against_numpy_rays_and_the_papers_formulas() {
    let mut file = v15().file().unwrap().clone();
    file.coefficients =
        Some(Coefficients { c1: 0.05, c2: 0.0279, c3: 0.0053, c4: 0.1097, c5: 0.0844, n_sail: 5.0, n_base: 22.0 });
    let model = BrightnessModel::from_file(file, "test").unwrap();
    let text = std::fs::read_to_string(crate::common::golden_dir().join("map_goldens.csv")).unwrap();
    let (mut rows, mut magnitudes, mut dark) = (0, 0, 0);
    let mut ranges = Agreement::new("Ranges of sky maps", "numpy", RANGE_KM, "km");
    let mut shadows = Agreement::new("Sunlit fractions of sky maps", "4,000 rays to the Sun's disk", LIT_FRACTION, "");
    let mut light = Agreement::new("Magnitudes of sky maps", "numpy", MAGNITUDE, "mag");
    for line in text.lines().skip(3) {
        let cells: Vec<Option<f64>> = line.split(',').map(|cell| cell.parse().ok()).collect();
        let n = |index: usize| cells[index].unwrap();
        let earth = match cells[0] {
            Some(latitude) => Earth::Ellipsoid(Site::new_deg("site", latitude, n(1), n(2)).unwrap()),
            None => Earth::Sphere,
        };
        let (sun_azimuth, sun_altitude) = (n(4).to_radians(), n(5).to_radians());
        let sunlight = PhotometryOptions { earthshine: Earthshine::Off, ..options() };
        let view = SkyView::new(&model, earth, n(3), sun_azimuth, sun_altitude, sunlight)
            .unwrap()
            .with_shadow(ShadowModel::Geometric);
        let point = view.at(n(6).to_radians(), n(7).to_radians());
        ranges.add(point.range_km - n(8));
        let lit = point.lit_fraction;
        shadows.add(lit - n(9));
        match (point.magnitude, cells[10]) {
            // In the penumbra, the magnitude is limited by the accuracy of the lit fraction.
            (Some(computed), Some(golden)) if lit == 1.0 => {
                light.add(computed.0 - golden);
                magnitudes += 1;
            }
            (Some(computed), Some(golden)) => {
                let tolerance = 1.1 * LIT_FRACTION / lit + 0.01;
                assert!((computed.0 - golden).abs() < tolerance, "row {rows}: {computed}, {line}");
            }
            (None, None) => dark += 1,
            (computed, golden) => panic!("row {rows}: {computed:?} against {golden:?}, {line}"),
        }
        rows += 1;
    }
    assert_eq!(rows, 300);
    assert!(magnitudes > 150 && dark > 100, "{magnitudes} {dark}");
}

/// Values computed by rows and by single directions agree, in sunlight only and with earthshine, for a sphere and an
/// ellipsoid, with and without extinction.
#[test]
fn verif_cells_steps_and_single_directions_agree() {
    // Tolerance: rows compute each azimuth from the previous one, and angles with other formulas.
    const MAGNITUDE: f64 = 1e-9;
    const RANGE_KM: f64 = 1e-9;
    let model = v15();
    let earths = [Earth::Sphere, Earth::Ellipsoid(Site::from_mpc("X05").unwrap())];
    let ways = [Earthshine::Off, Earthshine::Computed].into_iter().flat_map(|way| [None, Some(0.2)].map(|k| (way, k)));
    for (earth, (earthshine, k)) in earths.iter().flat_map(|earth| ways.clone().map(move |way| (earth, way))) {
        let options = PhotometryOptions { earthshine, extinction_mag_per_airmass: k, ..options() };
        let view = SkyView::new(&model, earth.clone(), 550.0, 4.4, -0.28, options).unwrap();
        let way = format!("{earth:?} {earthshine:?} {k:?}");
        for grid in [Grid::regular(5.0).unwrap(), Grid::healpix(16).unwrap()] {
            let map = view.map(grid).unwrap();
            assert_eq!(map.points.len(), grid.half_len());
            let mut compared = 0;
            for (index, point) in map.points.iter().enumerate() {
                let alone = view.at(point.azimuth_rad, point.altitude_rad);
                assert!((point.range_km - alone.range_km).abs() < RANGE_KM, "{way}: {point:?} {alone:?}");
                assert!((point.lit_fraction - alone.lit_fraction).abs() < 1e-9, "{way}: {point:?} {alone:?}");
                match (point.magnitude, alone.magnitude) {
                    (Some(row), Some(alone)) => {
                        assert!((row.0 - alone.0).abs() < MAGNITUDE, "{way}: {row} {alone}");
                        compared += 1;
                    }
                    (row, alone) => assert_eq!(row, alone, "{way}: {point:?}"),
                }
                assert!(point.altitude_rad >= 0.0);
                assert_eq!(grid.northern_cell(index), grid.nside().map(|_| index as u64));
            }
            assert!(compared > map.points.len() / 3, "{way}: {compared}");
        }
    }
}

/// Magnitudes of maps equal those of single predictions, for models of every kind.
#[test]
fn verif_maps_agree_with_single_predictions() {
    use streakcast::constants::AU_KM;
    use streakcast::frames::{Direction, Gcrs, Horizontal, Position};
    use streakcast::geometry::{ViewingGeometry, illumination};
    /// Tolerance of lit fractions: the positions of the satellites differ by some nanometres.
    const LIT_FRACTION: f64 = 1e-9;
    let library = ModelLibrary::embedded();
    let site = Site::from_mpc("X05").unwrap();
    let in_g = PhotometryOptions::in_band("g".parse().unwrap(), "AB".parse().unwrap());
    let (sun_azimuth, sun_altitude) = (4.0, -0.3);
    let horizontal = |azimuth: f64, altitude: f64| {
        let direction = Direction::<Horizontal>::from_lon_lat_rad(azimuth, altitude);
        *(site.horizon().inverse() * direction).vector()
    };
    let observer = *site.itrs().vector();
    let sun = Position::<Gcrs>::from_vector(horizontal(sun_azimuth, sun_altitude) * AU_KM);
    let ways = [Earthshine::Off, Earthshine::Computed];
    for (name, earthshine) in library.names().flat_map(|name| ways.map(|way| (name, way))) {
        let options = PhotometryOptions { earthshine, ..in_g };
        let model = library.get(name).unwrap();
        let earth = Earth::Ellipsoid(site.clone());
        let view = SkyView::new(&model, earth, 1200.0, sun_azimuth, sun_altitude, options).unwrap();
        let (mut lit, mut penumbra) = (0, 0);
        for point in view.map(Grid::regular(2.0).unwrap()).unwrap().points {
            let satellite = observer + horizontal(point.azimuth_rad, point.altitude_rad) * point.range_km;
            let satellite = Position::from_vector(satellite);
            let mut geometry = ViewingGeometry::new(&satellite, &Position::from_vector(observer), &sun).unwrap();
            geometry.sun_distance_au = 1.0;
            let fraction = illumination(&satellite, &sun).lit_fraction();
            assert!((point.lit_fraction - fraction).abs() < LIT_FRACTION, "{name}: {point:?} {fraction}");
            let long = model.brightness(&geometry, fraction, &options);
            match (point.magnitude, long) {
                // In the plane of a panel, rounding of a cosine is amplified for magnitudes of 20 and fainter.
                (Some(short), Some(long)) if long.magnitude.0 < 20.0 => {
                    // In the penumbra, the difference of the fractions f adds d(2.5 log f) = 1.0857 df / f.
                    let tolerance = 1e-9 + if fraction < 1.0 { 1.1 * LIT_FRACTION / fraction } else { 0.0 };
                    assert!((short.0 - long.magnitude.0).abs() < tolerance, "{name}: {short} {}", long.magnitude);
                    lit += 1;
                    penumbra += usize::from(fraction < 1.0);
                }
                (None, None) => {}
                (short, long) => {
                    let faint = |magnitude: Option<f64>| magnitude.is_none_or(|magnitude| magnitude > 19.9);
                    let is_border = (point.lit_fraction > 0.0) != (fraction > 0.0);
                    let (short, long) = (short.map(|one| one.0), long.map(|one| one.magnitude.0));
                    assert!(is_border || faint(short) && faint(long), "{name}: {short:?} {long:?}");
                }
            }
        }
        assert!(lit > 2500 && penumbra > 5, "{name}: {lit} {penumbra}");
    }
}

/// Earthshine on the chassis decreases as the Sun sinks below the plane of the chassis, and is zero if no ground that
/// the satellite sees is lit.
#[test]
fn verif_earthshine_brightens_a_map() {
    let model = v15();
    let gain = |sun_deg: f64| {
        let at = |earthshine| {
            let options = PhotometryOptions { earthshine, ..options() };
            let view = BodyView::new(&model, sun_deg.to_radians(), 550.0, options).unwrap();
            view.at(std::f64::consts::PI, -1.0).unwrap().0
        };
        at(Earthshine::Off) - at(Earthshine::Computed)
    };
    assert!(gain(-2.0) > gain(-8.0) && gain(-8.0) > gain(-14.0) && gain(-14.0) >= 0.0);
    assert!(gain(-2.0) > 0.02, "{}", gain(-2.0));
    assert!(gain(-30.0).abs() < 1e-9, "{}", gain(-30.0));
}

#[test]
fn verif_straight_up_and_at_the_horizon() {
    let model = v15();
    let view = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, -0.2, options()).unwrap();
    let zenith = view.at(1.0, std::f64::consts::FRAC_PI_2);
    assert!((zenith.range_km - 550.0).abs() < 1e-9);
    // √(r² - R²)
    let horizon = (6928.137_f64.powi(2) - 6378.137_f64.powi(2)).sqrt();
    assert!((view.at(2.0, 0.0).range_km - horizon).abs() < 1e-9);
    // Seen from a mountain at a pole, satellites at 550 km are higher: the ellipsoid is 21.4 km below the sphere there.
    let pole = Earth::Ellipsoid(Site::new_deg("pole", 90.0, 0.0, 0.0).unwrap());
    let view = SkyView::new(&model, pole, 550.0, 0.0, -0.2, options()).unwrap();
    let up = view.at(0.0, std::f64::consts::FRAC_PI_2).range_km;
    assert!((up - (550.0 + 6_378.137 - 6_356.752_314_2)).abs() < 1e-6, "{up}");
}

/// Far from the edge of the shadow, the fast computation agrees with the full one.
#[test]
fn verif_the_shadow_shortcut_is_exact() {
    use streakcast::constants::AU_KM;
    use streakcast::frames::{Gcrs, Position};
    let model = v15();
    let mut seen = [0; 3];
    let shadows = [ShadowModel::Geometric, ShadowModel::Atmosphere];
    for (shadow, height_km) in shadows
        .into_iter()
        .flat_map(|shadow| [200.0, 550.0, 2000.0, 36_000.0, 100_000.0].map(|height_km| (shadow, height_km)))
    {
        for sun_deg in [-5.0, -15.0, -25.0, -40.0, -70.0] {
            let view = SkyView::new(&model, Earth::Sphere, height_km, 0.0, f64::to_radians(sun_deg), options())
                .unwrap()
                .with_shadow(shadow);
            for step in 0..=1800 {
                // Along the meridian of the Sun, from the horizon below it through the zenith to the opposite horizon.
                let turn = f64::from(step) * 0.1_f64.to_radians();
                let computed = view.at(0.0, turn).lit_fraction;
                let radius_km = 6378.137 + height_km;
                let (sin, cos) = turn.sin_cos();
                let range_km =
                    (6378.137_f64.powi(2) * (sin * sin - 1.0) + radius_km * radius_km).sqrt() - 6378.137 * sin;
                let satellite = Position::<Gcrs>::new(range_km * cos, 6378.137 + range_km * sin, 0.0);
                let sun = f64::to_radians(sun_deg);
                let full = shadow.illumination(&satellite, &Position::new(AU_KM * sun.cos(), AU_KM * sun.sin(), 0.0));
                assert!(
                    (computed - full.lit_fraction()).abs() < 1e-3,
                    "{height_km} {sun_deg} {step}: {computed} {full:?}"
                );
                seen[if computed == 1.0 {
                    0
                } else if computed == 0.0 {
                    2
                } else {
                    1
                }] += 1;
            }
        }
    }
    assert!(seen.iter().all(|&count| count > 100), "{seen:?}");
}

/// Body maps computed by rows and by single directions agree, in sunlight only and with earthshine.
#[test]
fn verif_body_maps_agree_with_single_directions() {
    const MAGNITUDE: f64 = 1e-9;
    let library = ModelLibrary::embedded();
    for (name, earthshine) in
        library.names().flat_map(|name| [Earthshine::Off, Earthshine::Computed].map(|way| (name, way)))
    {
        let model = library.get(name).unwrap();
        let options =
            PhotometryOptions { earthshine, ..PhotometryOptions::in_band("g".parse().unwrap(), "AB".parse().unwrap()) };
        let view = BodyView::new(&model, -0.2, 550.0, options).unwrap();
        let mut seen = 0;
        for point in view.map(Grid::regular(5.0).unwrap()).unwrap().points {
            let alone = view.at(point.observer_longitude_rad, point.observer_latitude_rad);
            match (point.standard_magnitude, alone) {
                // In the plane of a panel, the result is dominated by rounding.
                (Some(row), Some(alone)) if alone.0 < 20.0 => {
                    assert!((row.0 - alone.0).abs() < MAGNITUDE, "{name}: {row:?} {alone:?}");
                    seen += 1;
                }
                (row, alone) => {
                    let dark = |magnitude: Option<f64>| magnitude.is_none_or(|magnitude| magnitude > 19.9);
                    assert!(dark(row.map(|one| one.0)) && dark(alone.map(|one| one.0)), "{name}: {row:?} {alone:?}");
                }
            }
        }
        assert!(seen > 1000, "{name}: {seen}");
    }
}

#[test]
fn verif_extinction_and_band_change_a_map_as_they_should() {
    let model = v15();
    let at = |options: PhotometryOptions, altitude_deg: f64| {
        let view = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, -0.2, options).unwrap();
        view.at(2.0, f64::to_radians(altitude_deg)).magnitude.map(|magnitude| magnitude.0)
    };
    let air = PhotometryOptions { extinction_mag_per_airmass: Some(0.2), ..options() };
    let dimmed = |altitude: f64| at(air, altitude).unwrap() - at(options(), altitude).unwrap();
    assert!((dimmed(90.0) - 0.2).abs() < 1e-4, "{}", dimmed(90.0));
    // The airmass at 30° differs from 2 by less than 0.005.
    assert!((dimmed(30.0) - 0.4).abs() < 2e-3, "{}", dimmed(30.0));
    let red = PhotometryOptions::in_band("R".parse().unwrap(), "Vega".parse().unwrap());
    assert!(at(red, 50.0).unwrap() < at(options(), 50.0).unwrap());
}

#[test]
fn verif_invalid_requests() {
    let model = v15();
    let sky = |height_km, sun_azimuth: f64, sun_altitude: f64| {
        SkyView::new(&model, Earth::Sphere, height_km, sun_azimuth, sun_altitude, options()).map(drop)
    };
    assert!(sky(550.0, 0.0, -0.2).is_ok());
    for (height_km, azimuth, altitude, part) in [
        (0.0, 0.0, -0.2, "height is 0 km; allowed: above 0"),
        (-5.0, 0.0, -0.2, "height is -5 km"),
        (f64::NAN, 0.0, -0.2, "height is NaN km"),
        (550.0, 0.0, 1.6, "Sun's altitude is 91.6"),
        (550.0, 7.0, -0.2, "Sun's azimuth is 401"),
        (550.0, f64::NAN, -0.2, "Sun's azimuth is NaN"),
    ] {
        let text = sky(height_km, azimuth, altitude).unwrap_err().to_string();
        assert!(text.contains(part), "{text}");
    }
    let high = Site::new_deg("balloon", 0.0, 0.0, 40_000.0).unwrap();
    let below = SkyView::new(&model, Earth::Ellipsoid(high), 30.0, 0.0, 0.0, options()).unwrap_err().to_string();
    assert!(below.contains("below site balloon; allowed: above 40.0 km"), "{below}");
    assert!(
        BodyView::new(&model, -2.0, 550.0, options()).unwrap_err().to_string().contains("Sun's latitude is -114.5")
    );
    assert!(BodyView::new(&model, -0.2, f64::INFINITY, options()).is_err());
}

/// A mean model has no earthshine, and its map does not state it.
#[test]
fn verif_only_maps_of_panels_state_earthshine() {
    let library = ModelLibrary::embedded();
    let mut stated = 0;
    for name in library.names() {
        let model = library.get(name).unwrap();
        let body = BodyView::new(&model, -0.2, 550.0, options()).unwrap().facts();
        let sky = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, -0.2, options()).unwrap().facts();
        for facts in [body, sky] {
            let is_stated = facts.iter().any(|fact| fact.name == "earthshine");
            assert_eq!(is_stated, model.is_of_panels(), "{name}");
            stated += usize::from(is_stated);
        }
    }
    assert!(stated > 0 && stated < 2 * library.names().count());
}
