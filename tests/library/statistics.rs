//! Statistics of a site: expected trails compared with computed crossings, counts compared with the density of shells.

use std::f64::consts::{PI, TAU};

use crate::common::random::Random;
use hifitime::Epoch;
use streakcast::elements::Constellation;
use streakcast::forecast::{StatisticsRequest, bassa2022, sky_counts};
use streakcast::frames::parse_instant;
use streakcast::frames::{Direction, EopTable, Horizontal};
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{Exposure, Field, ModelChoice, PassOptions, Sky};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::schedule::night_of;

/// Relative tolerance: three sigma of counting about 800 trails, and 5 % for pointings near the lowest altitude.
const TRAILS: f64 = 0.16;
/// Relative tolerance: the formula is a mean over time for a spherical Earth. The counts at 144 times include about
/// 3,000 satellites above 30°.
const DENSITY: f64 = 0.05;

fn sky(constellation: &Constellation, site: Site, epoch: Epoch) -> Sky {
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    Sky::with_models(constellation.element_sets(epoch), Observer::new(site), EopTable::embedded(), &choice)
}

fn request(site: &Site, date: &str) -> StatisticsRequest {
    let (start, end) = night_of(parse_instant(&format!("{date}T12:00:00Z"), None).unwrap(), site.longitude_rad);
    StatisticsRequest {
        start,
        end,
        sun_altitudes_rad: [-12.0_f64, -24.0].map(f64::to_radians).to_vec(),
        min_altitudes_rad: [20.0_f64, 30.0].map(f64::to_radians).to_vec(),
        field_rad: 3.5_f64.to_radians(),
        field_sr: None,
        exposure_s: 30.0,
        moments: 1,
        spread_s: 0.0,
        limit_mag: None,
        photometry: PhotometryOptions::default(),
    }
}

/// The expectation of Bassa et al. agrees with crossings of fields with random pointings above 30°.
#[test]
fn verif_expected_trails_agree_with_crossings() {
    let site = Site::from_mpc("X05").unwrap();
    let request = request(&site, "2024-12-21");
    let sky = sky(&Constellation::by_name("starlink-gen1").unwrap(), site, request.start);
    let (counts, missed, left_out) = sky_counts(&sky, &request).unwrap();
    assert!(missed.is_empty() && left_out.is_empty());
    // Evening and morning, two altitudes of the Sun, two lowest altitudes.
    assert_eq!(counts.len(), 8);
    let count = counts.iter().find(|count| count.evening && count.min_altitude_rad > 0.5).unwrap();
    assert!(count.lit > 8.0 && count.lit <= count.above, "{count:?}");

    let mut random = Random(2022);
    let observer = sky.viewpoint().site().unwrap();
    let here = observer.state(&sky.orientation_over(count.epoch, count.epoch).at_s(0.0));
    let exposures: Vec<Exposure> = (0..8000)
        .map(|number| {
            let altitude_rad = random.between(0.5, 1.0).asin();
            let horizontal = Direction::<Horizontal>::from_lon_lat_rad(random.between(0.0, TAU), altitude_rad);
            Exposure {
                id: number.to_string(),
                start: count.epoch,
                duration_s: request.exposure_s,
                pointing: here.horizon.inverse() * horizontal,
                rotation_rad: 0.0,
            }
        })
        .collect();
    let field = Field::circle(request.field_rad).unwrap();
    let passes = sky.field_passes(&exposures, &field, &PassOptions::default()).unwrap();
    let crossed: usize = passes.by_exposure.iter().map(Vec::len).sum();
    let mean = crossed as f64 / exposures.len() as f64;
    println!("{crossed} trails: {mean:.4} an exposure, {:.4} expected", count.trails);
    assert!(crossed > 300, "{crossed}");
    assert!((mean / count.trails - 1.0).abs() < TRAILS, "{mean} {}", count.trails);
}

#[test]
fn verif_counts_fall_with_the_sun_and_grow_with_the_limits() {
    let site = Site::from_mpc("X05").unwrap();
    let request =
        StatisticsRequest { moments: 5, spread_s: 600.0, limit_mag: Some(7.0), ..request(&site, "2024-06-21") };
    let sky = sky(&Constellation::by_name("starlink-gen1").unwrap(), site, request.start);
    let (counts, ..) = sky_counts(&sky, &request).unwrap();
    for count in &counts {
        // The fifth of the magnitudes 3, 4, ... 8.
        let (brighter, trails) = (count.brighter_than_limit.unwrap(), count.trails_brighter_than_limit.unwrap());
        assert!((brighter - count.brighter_than[4]).abs() < 1e-12);
        assert!(trails <= count.trails);
        // Trails grow with the angular rate, and bright satellites are the near, fast ones: their share of the trails
        // is at least their share of the lit satellites, and at most three times as large.
        let share = trails * count.lit / (count.trails * brighter);
        assert!(brighter == 0.0 || (1.0..3.0).contains(&share), "{share} {count:?}");
        assert!(count.brighter_than.windows(2).all(|pair| pair[0] <= pair[1]) && count.brighter_than[5] <= count.lit);
        let higher =
            counts.iter().find(|other| other.epoch == count.epoch && other.min_altitude_rad > count.min_altitude_rad);
        assert!(higher.is_none_or(|higher| higher.lit <= count.lit && higher.above < count.above));
    }
    // On a winter night with the Sun at -24°, most satellites at 550 km are in the shadow.
    let lit = |sun_deg: f64| -> f64 {
        counts
            .iter()
            .filter(|count| (count.sun_altitude_rad.to_degrees() - sun_deg).abs() < 0.1)
            .map(|count| count.lit)
            .sum()
    };
    assert!(lit(-12.0) > 2.0 * lit(-24.0), "{} {}", lit(-12.0), lit(-24.0));
    let refused = StatisticsRequest { limit_mag: Some(f64::NAN), ..request.clone() };
    assert!(sky_counts(&sky, &refused).unwrap_err().to_string().contains("limit-mag is NaN mag"));
    let refused = StatisticsRequest { field_sr: Some(f64::NAN), ..request.clone() };
    assert!(sky_counts(&sky, &refused).unwrap_err().to_string().starts_with("field is NaN deg2; allowed: "));
    let refused = StatisticsRequest { field_rad: 0.0, ..request.clone() };
    assert!(sky_counts(&sky, &refused).unwrap_err().to_string().contains("above 0 deg"));
}

/// The number of satellites over Paranal agrees with the density of Bassa et al. (2022), section 2.
#[test]
fn valid_satellites_above_against_the_density_of_shells() {
    let start = parse_instant("2025-03-20T00:00:00Z", None).unwrap();
    for name in ["starlink-gen1", "oneweb", "kuiper"] {
        let constellation = Constellation::by_name(name).unwrap();
        let sky = sky(&constellation, Site::by_name("Paranal").unwrap(), start);
        for altitude_deg in [0.0_f64, 30.0] {
            let row = bassa2022(&constellation, &sky, start, altitude_deg.to_radians(), "").unwrap();
            let off = row.difference_percent().unwrap() / 100.0;
            println!("{name} above {altitude_deg}: {:.1} expected, {:.1} counted", row.by_method.unwrap(), row.ours);
            assert!(off.abs() < DENSITY, "{name} above {altitude_deg}: {row:?}");
        }
    }
}

#[test]
fn mean_widths_of_fields() {
    let width_deg = |json: &str| Field::from_json(&format!("{{\"shapes\": [{json}]}}")).unwrap().mean_width_deg();
    // The mean width of a convex shape is its perimeter divided by π.
    assert!((Field::circle_deg(1.0).unwrap().mean_width_deg() - 1.0).abs() < 1e-4);
    assert!((Field::rectangle_deg(2.0, 1.0).unwrap().mean_width_deg() - 6.0 / PI).abs() < 1e-4);
    // Shapes that cover each other count once; two distant ones count twice in most directions.
    let one = r#"{"circle_deg": 1.0}"#;
    assert!((width_deg(&format!("{one}, {one}")) - 1.0).abs() < 1e-4);
    let apart = width_deg(&format!(r#"{one}, {{"circle_deg": 1.0, "center_deg": [5.0, 0.0]}}"#));
    assert!((1.9..2.0).contains(&apart), "{apart}");
}
