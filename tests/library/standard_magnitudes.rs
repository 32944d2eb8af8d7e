//! Magnitudes from standard magnitudes compared with Heavens-Above, and built-in bright objects.

use hifitime::{Epoch, Unit};
use streakcast::elements::{ElementSet, NoradId, ReadOptions, Satellites};
use streakcast::forecast::{ForecastRequest, Selection, forecast};
use streakcast::frames::{EopTable, seconds_after};
use streakcast::geometry::{Observer, ShadowModel, Site, ViewingGeometry};
use streakcast::orbit::DragModel;
use streakcast::passes::{ModelChoice, Sky};
use streakcast::photometry::{
    BrightObjects, DiffuseSphere, MagnitudeSource, StandardMagnitude, StandardMagnitudes, StandardObject,
};

/// Tolerance for the rounding of magnitudes and times by Heavens-Above, mag. Near the zenith, a pass brightens by 0.03
/// mag in a second.
const PRINTED_MAG: f64 = 0.1;

fn elements(data: &std::path::Path, id: u32) -> ElementSet {
    let text = std::fs::read_to_string(data.join("reference/heavens_above/heavens_above.tle")).unwrap();
    let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("1 ") || line.starts_with("2 ")).collect();
    let sets = Satellites::from_bytes("heavens_above", lines.join("\n").as_bytes(), &ReadOptions::default()).unwrap();
    sets.element_sets.into_iter().find(|set| set.norad_id == NoradId(id)).unwrap()
}

fn sky(set: ElementSet, site: Site, choice: &ModelChoice) -> Sky {
    let eop = EopTable::embedded().without_polar_motion();
    Sky::with_models(vec![set], Observer::new(site), eop, choice).with_drag(DragModel::Published)
}

/// Returns the rows of one pass: time, range (km), magnitude.
fn events(text: &str, date: &str) -> Vec<(String, f64, f64)> {
    let pass = text.split("Date:").find(|pass| pass.trim_start().starts_with(date)).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('\t').collect();
        let number = |cell: usize| cells.get(cell)?.replace(',', "").parse::<f64>().ok();
        Some(((*cells.get(1)?).to_owned(), number(4)?, number(5)?))
    };
    pass.lines().filter_map(row).collect()
}

/// HST over San Antonio and Envisat over Cape Town. Sites, intrinsic magnitudes and the rows of Heavens-Above are those
/// in the tests of passpredict (MIT licence).
#[test]
fn valid_phase_rule_of_standard_magnitudes_against_heavens_above() {
    let Some(data) = crate::common::data_dir() else { return };
    let text = std::fs::read_to_string(data.join("reference/heavens_above/heavens_above_events.txt")).unwrap();
    let passes = [
        (20_580, "31 January 2022", "2022-01-31", -6.0, Site::new_deg("San Antonio", 29.4246, -98.4951, 0.0)),
        (27_386, "06 February 2022", "2022-02-06", 2.0, Site::new_deg("Cape Town", -33.929, 18.4174, 0.0)),
    ];
    let (mut phases_deg, mut differences) = (Vec::new(), Vec::new());
    for (id, date, day, offset_h, site) in passes {
        let sky = sky(elements(&data, id), site.unwrap(), &ModelChoice::default());
        let object = BrightObjects::embedded().get(id, "").unwrap();
        for (clock, distance_km, printed) in events(&text, date) {
            let local: Epoch = format!("{day}T{clock} UTC").parse().unwrap();
            let (points, _) = sky.ephemeris(&[0], &[local - offset_h * Unit::Hour], None).unwrap();
            let point = &points[0].point;
            // The rows have whole kilometres and seconds.
            assert!((point.range_km - distance_km).abs() < 8.0, "{clock}: {} {distance_km}", point.range_km);
            let phase_rad = point.geometry.phase_angle_rad();
            let half_lit = object.half_lit;
            // Illuminated fraction of a sphere as in QuickSat: (1 + cos φ)/2.
            let fraction = half_lit.0 - 2.5 * (1.0 + phase_rad.cos()).log10();
            let rules = [
                StandardObject { half_lit }.standard_magnitude(phase_rad).unwrap().0,
                fraction,
                DiffuseSphere { half_lit }.standard_magnitude(phase_rad).unwrap().0,
            ];
            let difference = rules.map(|rule| StandardMagnitude(rule).at_range(point.range_km).0 - printed);
            println!("{id} {clock} phase {:.1} deg: linear, fraction, sphere {difference:.2?}", phase_rad.to_degrees());
            phases_deg.push(phase_rad.to_degrees());
            differences.push(difference);
        }
    }
    assert_eq!(differences.len(), 10);
    let (least, greatest) =
        phases_deg.iter().fold((180.0_f64, 0.0_f64), |(a, b), phase| (a.min(*phase), b.max(*phase)));
    println!("phases {least:.0} to {greatest:.0} deg");
    assert!(least < 30.0 && greatest > 150.0, "{least} {greatest}");
    let worst = |rule: usize| differences.iter().map(|one| one[rule].abs()).fold(0.0, f64::max);
    println!("largest differences {:.2} {:.2} {:.2}", worst(0), worst(1), worst(2));
    assert!(worst(0) < PRINTED_MAG && worst(1) > 10.0 * PRINTED_MAG && worst(2) > 20.0 * PRINTED_MAG);
}

/// Brightest times of 15 passes of the ISS, without and with a table of standard magnitudes.
#[test]
fn valid_iss_with_and_without_a_file_against_heavens_above() {
    let Some(data) = crate::common::data_dir() else { return };
    let bytes = std::fs::read(data.join("metadata/qs.mag")).unwrap();
    let table = StandardMagnitudes::from_qs_mag(&String::from_utf8_lossy(&bytes)).unwrap();
    for choice in [ModelChoice::default(), ModelChoice::default().with_standard_magnitudes(table)] {
        iss_against_heavens_above(&data, &choice);
    }
}

fn iss_against_heavens_above(data: &std::path::Path, choice: &ModelChoice) {
    // Heavens-Above ends passes at the geometric shadow.
    let sky = sky(elements(data, 25_544), Site::new_deg("Zurich", 47.3744, 8.541, 0.0).unwrap(), choice)
        .with_shadow(ShadowModel::Geometric);
    let start: Epoch = "2022-01-21T12:00:00 UTC".parse().unwrap();
    let request = ForecastRequest {
        samples: 201,
        max_magnitude: Some(3.0),
        ..ForecastRequest::new(start, seconds_after(start, 10.0 * 86_400.0))
    };
    let found = forecast(&sky, &request, &Selection::default()).unwrap();
    let text = std::fs::read_to_string(data.join("reference/heavens_above/heavens_above_passes.csv")).unwrap();
    let mut compared = 0;
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let begin: Epoch = format!("{}T{} UTC", cells[8], cells[10]).parse().unwrap();
        let begin = begin - 1.0 * Unit::Hour;
        let pass = found.found.passes.iter().filter_map(|pass| Some((pass, pass.visible.as_ref()?)));
        let near = |epoch: Epoch| (epoch - begin).abs() < 60.0 * Unit::Second;
        let (pass, _) = pass.into_iter().find(|(_, visible)| near(visible.begin.epoch)).unwrap();
        let magnitudes = pass.samples.iter().filter_map(|sample| Some(sample.brightness.as_ref()?.magnitude.0));
        let (computed, printed) = (magnitudes.fold(f64::INFINITY, f64::min), cells[9].parse::<f64>().unwrap());
        println!("{line}: {computed:.2}");
        assert!((computed - printed).abs() < 0.2, "{line}: {computed}");
        compared += 1;
    }
    assert_eq!(compared, 15);
}

/// Standard magnitudes of HST and Envisat in the list, if the built-in ones were not used: the difference from those of
/// Heavens-Above.
#[test]
fn valid_conversion_of_the_list_against_heavens_above() {
    let Some(data) = crate::common::data_dir() else { return };
    let bytes = std::fs::read(data.join("metadata/qs.mag")).unwrap();
    let listed = StandardMagnitudes::from_qs_mag(&String::from_utf8_lossy(&bytes)).unwrap();
    for id in [20_580, 27_386] {
        let of_heavens_above = BrightObjects::embedded().get(id, "").unwrap().half_lit.0;
        assert!((listed.get(id).unwrap().0 - of_heavens_above).abs() < PRINTED_MAG, "{id}");
    }
}

/// Magnitudes of classes are the means of the listed magnitudes.
#[test]
fn valid_class_means_of_rocket_bodies() {
    let Some(data) = crate::common::data_dir() else { return };
    let bytes = std::fs::read(data.join("metadata/qs.mag")).unwrap();
    let listed = StandardMagnitudes::from_qs_mag(&String::from_utf8_lossy(&bytes)).unwrap();
    let path = data.join("tle/fullcat/TLE3_2023-04-07.txt");
    let catalogue = Satellites::read(&[path], &ReadOptions::default()).unwrap();
    let table = BrightObjects::embedded();
    for class in table.iter().filter(|object| object.norad_id.is_none() && !object.name.ends_with('*')) {
        let of_class = catalogue
            .element_sets
            .iter()
            .filter(|set| table.get(set.norad_id.0, &set.name).is_some_and(|object| object.name == class.name));
        let magnitudes: Vec<f64> = of_class.filter_map(|set| Some(listed.get(set.norad_id.0)?.0)).collect();
        let mean = magnitudes.iter().sum::<f64>() / magnitudes.len() as f64;
        assert!(magnitudes.len() >= 5 && (mean - class.half_lit.0).abs() < 0.02, "{class:?}: {mean}");
    }
}

/// The magnitude of families of cubesats is the mean of the smallest objects in the list.
#[test]
fn valid_mean_of_small_objects() {
    let Some(data) = crate::common::data_dir() else { return };
    let bytes = std::fs::read(data.join("metadata/qs.mag")).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let listed = StandardMagnitudes::from_qs_mag(&text).unwrap();
    // Columns 39-50: three sizes, m; 0 if unknown.
    let size = |line: &str, column: usize| line.get(column..column + 4)?.trim().parse::<f64>().ok();
    let largest = |line: &str| Some(size(line, 38)?.max(size(line, 42)?).max(size(line, 46)?));
    let is_small = |line: &&str| largest(line).is_some_and(|size_m| size_m > 0.0 && size_m <= 0.4);
    let magnitude = |line: &str| Some(listed.get(line.get(..5)?.trim().parse().ok()?)?.0);
    let magnitudes: Vec<f64> = text.lines().filter(is_small).filter_map(magnitude).collect();
    let mean = magnitudes.iter().sum::<f64>() / magnitudes.len() as f64;
    let of_flock = BrightObjects::embedded().get(0, "FLOCK 4P-12").unwrap();
    assert!(magnitudes.len() == 11 && (mean - of_flock.half_lit.0).abs() < 0.005, "{magnitudes:?}");
    // Standard deviation of the objects, and 1 mag for single magnitudes.
    let variance = magnitudes.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / 10.0;
    assert!((variance.sqrt().hypot(1.0) - of_flock.sigma_mag).abs() < 0.01, "{variance}");
}

/// Priors of unknown satellites in high orbits, which have the median of the listed objects of their class of orbit.
#[test]
fn valid_prior_of_high_orbits_against_the_list() {
    let Some(data) = crate::common::data_dir() else { return };
    let bytes = std::fs::read(data.join("metadata/qs.mag")).unwrap();
    let listed = StandardMagnitudes::from_qs_mag(&String::from_utf8_lossy(&bytes)).unwrap();
    let path = data.join("tle/fullcat/TLE3_2023-04-07.txt");
    let catalogue = Satellites::read(&[path], &ReadOptions::default()).unwrap();
    let choice = ModelChoice::default();
    let half_lit = ViewingGeometry {
        sun_latitude_rad: 0.0,
        observer_latitude_rad: -std::f64::consts::FRAC_PI_2,
        observer_longitude_rad: 0.0,
        range_km: 1000.0,
        height_km: 36_000.0,
        sun_distance_au: 1.0,
    };
    let is_high = |set: &ElementSet| set.mean_motion_rev_day < 11.25;
    let is_synchronous = |set: &ElementSet| (0.9..1.1).contains(&set.mean_motion_rev_day) && set.eccentricity < 0.3;
    let is_eccentric = |set: &ElementSet| is_high(set) && set.eccentricity > 0.3;
    for name in ["geosynchronous", "eccentric"] {
        let is_of_class = |set: &ElementSet| if name == "eccentric" { is_eccentric(set) } else { is_synchronous(set) };
        let of_class = catalogue.element_sets.iter().filter(|set| is_of_class(set) && choice.is_unknown(set));
        let residuals: Vec<f64> = of_class
            .filter_map(|set| {
                let prior = choice.model_of(set).standard_magnitude(&half_lit)?;
                Some(listed.get(set.norad_id.0)?.0 - prior.0)
            })
            .collect();
        let count = residuals.len() as f64;
        let mean = residuals.iter().sum::<f64>() / count;
        let sigma = (residuals.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / count).sqrt();
        println!("{name}: {count} objects, mean {mean:.2}, standard deviation {sigma:.2} mag");
        assert!(count > 100.0 && mean.abs() < 0.2 && (sigma - 1.2).abs() < 0.2, "{name}: {count} {mean} {sigma}");
    }
}

#[test]
fn verif_built_in_objects_have_their_models() {
    let named = |id: u32, name: &str| {
        let text = "1 25544U 98067A   22021.68747065 -.00000457  00000-0  00000+0 0  9996\n\
                    2 25544  51.6270 342.0904 0006847  44.2808  14.3181 15.49598315322461\n";
        let mut set =
            Satellites::from_bytes("iss", text.as_bytes(), &ReadOptions::default()).unwrap().element_sets[0].clone();
        set.norad_id = NoradId(id);
        set.name = name.into();
        set
    };
    let choice = ModelChoice::default();
    let source = |id: u32, name: &str| choice.model_of(&named(id, name)).source().to_string();
    assert_eq!(source(25_544, "ISS (ZARYA)"), "stdmag");
    assert_eq!(source(19_120, "SL-16 R/B"), "prior:sl-16-rocket-body");
    assert_eq!(source(19_120, "CZ-99 R/B"), "prior:rocket-body");
    assert_eq!(source(12, "VANGUARD 2"), "prior");
    // A table of the user takes precedence over classes and priors, but not over single built-in objects.
    let text = "25544   98 67A    ISS            -2.0              348\n\
                19120   88 39B    C* 1943 Rk      1.9 10.4 3.9 0.0  11\n";
    let choice = ModelChoice::default().with_standard_magnitudes(StandardMagnitudes::from_qs_mag(text).unwrap());
    let geometry = ViewingGeometry::from_angles(0.0, 0.0, -std::f64::consts::FRAC_PI_2, 1000.0, 420.0).unwrap();
    for (id, name, expected) in [(25_544, "ISS", -1.8), (19_120, "SL-16 R/B", 1.9 + 0.7526)] {
        let own = choice.model_of(&named(id, name));
        assert!((own.standard_magnitude(&geometry).unwrap().0 - expected).abs() < 1e-4, "{name}");
        assert_eq!(*own.source(), MagnitudeSource::StandardMagnitude);
    }
}
