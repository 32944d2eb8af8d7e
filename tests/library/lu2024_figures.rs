//! Statements of Lu (2024), section 5, on maps, compared with the bundled model of Starlink V1.5.

use crate::common::maps::{options, v15};
use streakcast::geometry::ShadowModel;
use streakcast::maps::{BodyView, DEFAULT_STEP_DEG, Earth, FigurePanel, Grid, PAPER_FIGURES, SkyMap, SkyView};
use streakcast::photometry::BrightnessModel;

/// Map with the shadow of the paper: the Earth without an atmosphere.
fn sky(model: &BrightnessModel, height_km: f64, sun_altitude_deg: f64) -> SkyMap {
    let view = SkyView::new(model, Earth::Sphere, height_km, 0.0, sun_altitude_deg.to_radians(), options()).unwrap();
    view.with_shadow(ShadowModel::Geometric).map(Grid::regular(DEFAULT_STEP_DEG).unwrap()).unwrap()
}

/// Returns the median magnitude of a body map over the directions for which `holds` (longitude and latitude in
/// degrees).
fn median(model: &BrightnessModel, sun_latitude_deg: f64, holds: impl Fn(f64, f64) -> bool) -> f64 {
    let view = BodyView::new(model, sun_latitude_deg.to_radians(), 550.0, options()).unwrap();
    let map = view.map(Grid::regular(DEFAULT_STEP_DEG).unwrap()).unwrap();
    let mut all: Vec<f64> = map
        .points
        .iter()
        .filter(|point| holds(point.observer_longitude_rad.to_degrees(), point.observer_latitude_rad.to_degrees()))
        .filter_map(|point| point.standard_magnitude.map(|magnitude| magnitude.0))
        .collect();
    assert!(all.len() > 20);
    all.sort_unstable_by(f64::total_cmp);
    all[all.len() / 2]
}

/// Returns the angle from the specular direction of the chassis, degrees: longitude 180°, latitude that of the Sun.
fn from_mirror(longitude_deg: f64, latitude_deg: f64, sun_latitude_deg: f64) -> f64 {
    let (sin, cos) = latitude_deg.to_radians().sin_cos();
    let (sin_sun, cos_sun) = sun_latitude_deg.to_radians().sin_cos();
    (sin * sin_sun - cos * cos_sun * longitude_deg.to_radians().cos()).clamp(-1.0, 1.0).acos().to_degrees()
}

/// Section 5.1: "the directions around the solar azimuth very bright", and the anti-solar ones "darker in comparison,
/// and only relatively brighter around the specular beam of the chassis".
#[test]
fn verif_figure_6_is_bright_towards_the_sun_and_dark_away_from_it() {
    let model = v15();
    let towards = |longitude: f64, _: f64| longitude.min(360.0 - longitude) <= 60.0;
    let mut spots = Vec::new();
    for sun in [-8.0, -14.0, -20.0] {
        let opposite = |longitude: f64, _: f64| (longitude - 180.0).abs() <= 60.0;
        let spot = median(&model, sun, |longitude, latitude| from_mirror(longitude, latitude, sun) < 15.0);
        let beside = median(&model, sun, |longitude, latitude| {
            opposite(longitude, latitude) && from_mirror(longitude, latitude, sun) > 40.0
        });
        let (bright, dark) = (median(&model, sun, towards), median(&model, sun, opposite));
        // The two sides differ by 1.1 to 1.5 mag; the specular beam is brighter by 1.4 to 2.2 mag.
        assert!(bright < dark - 0.5, "Sun at {sun}: {bright} towards, {dark} opposite");
        assert!(spot < beside - 0.5, "Sun at {sun}: {spot} in the spot, {beside} next to it");
        spots.push(spot);
    }
    // "With the solar altitude decreasing, the reflection contribution from the chassis gradually increases".
    assert!(spots.windows(2).all(|pair| pair[1] < pair[0]), "{spots:?}");
}

/// Section 5.1 continues "... and that of the sail is the opposite". Here the sail is observed from the ground directly
/// in front of it.
#[test]
fn verif_the_sail_fades_as_the_sun_sinks() {
    let model = v15();
    let satellite = model.satellite().unwrap();
    let sail = |sun_deg: f64| {
        let geometry = streakcast::geometry::ViewingGeometry::from_angles(
            sun_deg.to_radians(),
            0.0,
            -40_f64.to_radians(),
            1000.0,
            550.0,
        );
        let terms = satellite.terms(&geometry.unwrap());
        terms.sail_glossy_m2_sr + terms.sail_diffuse_m2_sr
    };
    assert!(sail(-8.0) > sail(-14.0) && sail(-14.0) > sail(-20.0));
}

/// Section 5.2: "During twilight, satellites in the anti-solar direction are significantly brighter". At the azimuth of
/// the Sun, satellites become brighter from twilight to night.
#[test]
fn verif_figure_7_twilight_is_bright_opposite_to_the_sun() {
    let model = v15();
    let mean = |sun_altitude_deg: f64, azimuth_deg: f64| {
        let map = sky(&model, 550.0, sun_altitude_deg);
        let magnitudes: Vec<f64> = map
            .points
            .iter()
            .filter(|point| {
                let apart = (point.azimuth_rad.to_degrees() - azimuth_deg + 540.0).rem_euclid(360.0) - 180.0;
                apart.abs() <= 45.0 && (30.0..=60.0).contains(&point.altitude_rad.to_degrees())
            })
            .filter_map(|point| point.magnitude.map(|magnitude| magnitude.0))
            .collect();
        assert!(!magnitudes.is_empty());
        magnitudes.iter().sum::<f64>() / magnitudes.len() as f64
    };
    assert!(mean(-8.0, 180.0) < mean(-8.0, 0.0) - 0.5, "{} {}", mean(-8.0, 180.0), mean(-8.0, 0.0));
    let below_the_sun = [-8.0, -16.0, -24.0].map(|sun| mean(sun, 0.0));
    assert!(below_the_sun.windows(2).all(|pair| pair[1] < pair[0]), "{below_the_sun:?}");
}

/// Captions of figures 7 to 9: 5 to 9 mag at 550 km, 4 to 8 at 340 km, 6 to 10 at 1200 km.
///
/// The captions give the ends of colour bars, and the coefficients of the paper are not printed. The test requires, for
/// each panel, that 85 % of the lit sky (by solid angle) more than 20° above the horizon are within them; the measured
/// fractions are 0.86 to 1.00. Over the whole sky, the central 90 % of all three panels are 4.9 to 9.2, 3.9 to 8.6 and
/// 6.6 to 9.9 mag: near the horizon they are fainter than the captions by up to 0.6 mag, about the RMS of the model.
#[test]
fn verif_magnitudes_of_figures_7_to_9_are_those_of_the_captions() {
    let model = v15();
    let mut figures = 0;
    for figure in &PAPER_FIGURES {
        let Some([brightest, faintest]) = figure.stated_range_mag else { continue };
        let mut all = Vec::new();
        for panel in figure.panels {
            let FigurePanel::Sky { sun_altitude_deg, height_km } = panel else { panic!("figure {}", figure.number) };
            let lit: Vec<(f64, f64, f64)> = sky(&model, height_km, sun_altitude_deg)
                .points
                .iter()
                .filter_map(|point| Some((point.magnitude?.0, point.altitude_rad.cos(), point.altitude_rad)))
                .collect();
            let area = |holds: &dyn Fn(f64) -> bool| {
                let high = lit.iter().filter(|(magnitude, _, altitude)| *altitude > 0.35 && holds(*magnitude));
                high.map(|(_, area, _)| area).sum::<f64>()
            };
            let share = area(&|magnitude| (brightest..=faintest).contains(&magnitude)) / area(&|_| true);
            assert!(share >= 0.85, "figure {}, Sun at {sun_altitude_deg}: {share}", figure.number);
            all.extend(lit);
        }
        all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = all.iter().map(|(_, area, _)| area).sum();
        let at = |share: f64| {
            let mut sum = 0.0;
            let found = all.iter().find(|(_, area, _)| {
                sum += area;
                sum >= share * total
            });
            found.unwrap().0
        };
        assert!(at(0.05) > brightest - 0.2, "figure {}: {}", figure.number, at(0.05));
        assert!(at(0.95) < faintest + 0.8, "figure {}: {}", figure.number, at(0.95));
        // The magnitudes are not all near one end of the range.
        assert!(at(0.95) - at(0.05) > 2.0, "figure {}", figure.number);
        figures += 1;
    }
    assert_eq!(figures, 3);
}

/// Returns the lowest altitude of the Sun at which a satellite at this altitude is lit, degrees.
fn last_lit_deg(model: &BrightnessModel, height_km: f64, altitude_deg: f64) -> f64 {
    let lit = |sun_deg: f64| {
        let view = SkyView::new(model, Earth::Sphere, height_km, 0.0, sun_deg.to_radians(), options())
            .unwrap()
            .with_shadow(ShadowModel::Geometric);
        // Satellites in the direction of the Sun are lit longest.
        view.at(0.0, altitude_deg.to_radians()).lit_fraction > 0.0
    };
    let (mut above, mut below) = (0.0, -89.0);
    assert!(lit(above) && !lit(below));
    while above - below > 1e-4 {
        let middle = 0.5 * (above + below);
        if lit(middle) { above = middle } else { below = middle }
    }
    above
}

/// Captions of figures 7 to 9: visible until the Sun is at about -30, -21 and -40°, without stating the altitude. For
/// 30°, geometry gives the sum of acos(R/r), the dip of the limb seen from the satellite, and the angle between
/// satellite and observer at the Earth's centre.
#[test]
fn verif_the_lowest_sun_of_the_captions() {
    let model = v15();
    // Height, altitude of the Sun in the paper, altitude of the Sun computed for 30°.
    for (height_km, paper_deg, ours_deg) in [(550.0, -30.0, -30.4), (340.0, -21.0, -23.3), (1200.0, -40.0, -46.2)] {
        let last = last_lit_deg(&model, height_km, 30.0);
        // acos(R/r) + 90° - 30° - asin(R cos 30° / r), plus the radius of the Sun.
        let ratio: f64 = 6378.137 / (6378.137 + height_km);
        let formula =
            -(ratio.acos().to_degrees() + 60.0 - (ratio * 30_f64.to_radians().cos()).asin().to_degrees() + 0.267);
        assert!((last - formula).abs() < 0.02, "{height_km} km: {last}, by the formula {formula}");
        assert!((last - ours_deg).abs() < 0.1, "{height_km} km: {last}");
        // The altitude in the paper is that for a satellite between 20° and 60°.
        let (low, high) = (last_lit_deg(&model, height_km, 20.0), last_lit_deg(&model, height_km, 60.0));
        assert!(low < paper_deg && paper_deg < high, "{height_km} km: {low} to {high}");
    }
}
