//! Forecasts compared with tables of Heavens-Above and STK, and with Skyfield for a real catalogue.

use std::collections::BTreeMap;
use std::path::Path;

use hifitime::{Epoch, Unit};
use streakcast::elements::{ElementSet, NoradId, ReadOptions, Satellites};
use streakcast::forecast::{Forecast, ForecastRequest, Selection, forecast};
use streakcast::frames::{EopTable, compass, seconds_after, seconds_between};
use streakcast::geometry::{Observer, ShadowModel, Site};
use streakcast::orbit::DragModel;
use streakcast::passes::{ModelChoice, Sky, TrackPoint};
use streakcast::photometry::ModelLibrary;

/// Tolerances for Heavens-Above, whose tables have whole seconds and degrees.
const HEAVENS_ABOVE_S: f64 = 1.5;
const HEAVENS_ABOVE_DEG: f64 = 0.6;
const HEAVENS_ABOVE_ROUNDING_S: f64 = 0.75;
/// Tolerance of azimuths, degrees: half of 22.5° (Heavens-Above gives one of sixteen compass points), plus one degree
/// for rounding.
const COMPASS_DEG: f64 = 12.25;

/// Required agreement with STK; `passes_reference.rs` tests it to a tenth of this.
const STK_S: f64 = 1.0;
const STK_DEG: f64 = 0.05;

/// Tolerances for Skyfield, which interpolates UT1 (a few centimetres); both programs find times by bisection (2 ms).
const SKYFIELD_S: f64 = 0.01;
/// Tolerance of culminations, seconds: the altitude changes slowly there, especially for slow satellites.
const SKYFIELD_TOP_S: f64 = 0.05;
const SKYFIELD_DEG: f64 = 0.001;
/// Tolerance of the edge of the penumbra, found with 720 rays to the limb of the Sun; differences are at most 4 ms.
const SKYFIELD_SHADOW_S: f64 = 0.02;

fn elements(path: &Path, id: u32) -> ElementSet {
    let text = std::fs::read_to_string(path).expect("the elements");
    let lines: Vec<&str> = text
        .lines()
        .map(|line| line.trim_start_matches("# "))
        .filter(|line| line.starts_with(['1', '2']) && line.len() == 69)
        .collect();
    let catalogue =
        Satellites::from_bytes("elements", lines.join("\n").as_bytes(), &ReadOptions::default()).expect("elements");
    catalogue.element_sets.into_iter().find(|set| set.norad_id == NoradId(id)).expect("the satellite")
}

fn sky(elements: Vec<ElementSet>, site: Site) -> Sky {
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    Sky::with_models(elements, Observer::new(site), EopTable::embedded().without_polar_motion(), &choice)
        .with_elements_of_any_age()
        .with_drag(DragModel::Published)
}

fn moment(date: &str, clock: &str) -> Epoch {
    format!("{}T{clock} UTC", date.replace('/', "-")).parse().expect("an epoch")
}

fn degrees(angle_rad: Option<f64>) -> f64 {
    angle_rad.expect("a site has a horizon").to_degrees()
}

#[test]
fn valid_forecast_against_heavens_above() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = data.join("reference").join("heavens_above");
    let sky = sky(
        vec![elements(&folder.join("heavens_above.tle"), 25544)],
        Site::new_deg("Zurich", 47.3744, 8.541, 0.0).expect("a site"),
    );
    let start = moment("2022-01-21", "12:00:00");
    let request =
        ForecastRequest { samples: 2001, ..ForecastRequest::new(start, seconds_after(start, 10.0 * 86_400.0)) };
    let computed = forecast(&sky, &request, &Selection::default()).expect("a forecast");
    let seen: Vec<_> = computed.found.passes.iter().filter_map(|pass| Some((pass, pass.visible.as_ref()?))).collect();
    let text = std::fs::read_to_string(folder.join("heavens_above_passes.csv")).expect("the passes");
    let (mut compared, mut worst_s, mut worst_deg) = (0, 0.0_f64, 0.0_f64);
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        // Local time is UTC + 1 h.
        let at = |cell: usize| moment(cells[8], cells[cell]) - 1.0 * Unit::Hour;
        let (pass, visible) = seen
            .iter()
            .find(|(_, visible)| seconds_between(at(10), visible.begin.epoch).abs() < 60.0)
            .unwrap_or_else(|| panic!("no pass for {line}"));
        for (cell, point) in [(10, &visible.begin), (13, &visible.highest), (16, &visible.end)] {
            let off_s = seconds_between(at(cell), point.epoch);
            assert!(off_s.abs() < HEAVENS_ABOVE_S, "{line}: column {cell} is {off_s} s off");
            // Times have whole seconds; near the zenith the altitude of the station changes by 1.2 deg in a second.
            let theirs_deg = cells[cell + 1].parse::<f64>().expect("degrees");
            let within = pass
                .samples
                .iter()
                .filter(|sample| seconds_between(sample.epoch, point.epoch).abs() < HEAVENS_ABOVE_ROUNDING_S);
            let off_deg = within
                .chain([point])
                .map(|point| (degrees(point.altitude_rad) - theirs_deg).abs())
                .fold(f64::INFINITY, f64::min);
            assert!(off_deg < HEAVENS_ABOVE_DEG, "{line}: column {cell} is {off_deg} deg off");
            // Near the zenith the azimuth changes by many degrees per second.
            if degrees(point.altitude_rad) < 80.0 {
                let azimuths = (0..360).filter(|azimuth| compass(f64::from(*azimuth).to_radians()) == cells[cell + 2]);
                let near = azimuths.clone().any(|azimuth| {
                    let off_deg = (degrees(point.azimuth_rad) - f64::from(azimuth) + 540.0).rem_euclid(360.0) - 180.0;
                    off_deg.abs() < COMPASS_DEG - 11.25
                });
                assert!(near, "{line}: column {cell} is at {:.1} deg", degrees(point.azimuth_rad));
            }
            (worst_s, worst_deg) = (worst_s.max(off_s.abs()), worst_deg.max(off_deg));
        }
        compared += 1;
    }
    println!("{compared} passes, {} computed: {worst_s:.2} s, {worst_deg:.2} deg at most", seen.len());
    assert_eq!(compared, 15);
    // Every visible pass found here satisfies the criteria of Heavens-Above.
    for row in computed.rows(&sky) {
        let Some(visible) = &row.pass.visible else { continue };
        assert!(degrees(visible.highest.altitude_rad) >= 9.99 && row.ends_by().is_some(), "{:?}", visible.begin.epoch);
    }
}

#[test]
fn valid_forecast_against_stk() {
    let Some(data) = crate::common::data_dir() else { return };
    let path = data.join("reference").join("heavens_above").join("stk_bugsat_passes.txt");
    let text = std::fs::read_to_string(&path).expect("the passes");
    let sky = sky(vec![elements(&path, 40014)], Site::new_deg("STK", -31.2884, -64.203_286_8, 492.96).expect("a site"));
    let start = moment("2014/10/23", "00:00:00");
    let request = ForecastRequest {
        min_altitude_rad: 0.0,
        include_dark: true,
        ..ForecastRequest::new(start, seconds_after(start, 2.3 * 86_400.0))
    };
    let computed = forecast(&sky, &request, &Selection::default()).expect("a forecast").found.passes;
    let lines: Vec<Vec<&str>> =
        text.lines().filter(|line| line.starts_with("2014/")).map(|line| line.split_whitespace().collect()).collect();
    assert_eq!((lines.len(), computed.len()), (10, 10));
    for (words, pass) in lines.iter().zip(&computed) {
        let point = |point: &Option<TrackPoint>| point.as_ref().expect("a rise and a set").epoch;
        for (word, epoch) in [(0, point(&pass.rise)), (2, pass.culmination.epoch), (4, point(&pass.set))] {
            let off_s = seconds_between(moment(words[word], words[word + 1]), epoch);
            assert!(off_s.abs() < STK_S, "{words:?}: {off_s} s off");
        }
        let off_deg = degrees(pass.culmination.altitude_rad) - words[7].parse::<f64>().expect("degrees");
        assert!(off_deg.abs() < STK_DEG, "{words:?}: {off_deg} deg off");
    }
}

/// One line of the golden file.
struct Event {
    name: String,
    seconds: f64,
    altitude_deg: f64,
    azimuth_deg: f64,
}

fn golden() -> BTreeMap<u32, Vec<Event>> {
    let mut events: BTreeMap<u32, Vec<Event>> = BTreeMap::new();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/forecast_golden.csv");
    let text = std::fs::read_to_string(path).expect("the golden events");
    for line in text.lines().filter(|line| line.starts_with(|mark: char| mark.is_ascii_digit())) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |cell: usize| cells[cell].parse::<f64>().expect("a number");
        events.entry(cells[0].parse().expect("a number")).or_default().push(Event {
            name: cells[1].to_owned(),
            seconds: number(2),
            altitude_deg: number(3),
            azimuth_deg: number(4),
        });
    }
    events
}

#[test]
fn valid_passes_and_shadow_against_skyfield() {
    let Some(data) = crate::common::data_dir() else { return };
    let path = data.join("tle").join("active").join("active_2026-04-25.txt");
    let catalogue = Satellites::read(&[path], &ReadOptions::default()).expect("the catalogue");
    let golden = golden();
    let selected: Vec<ElementSet> =
        catalogue.element_sets.into_iter().filter(|set| golden.contains_key(&set.norad_id.0)).collect();
    assert_eq!(selected.len(), golden.len());
    let site =
        Site::new_deg("golden", -(30.0 + 14.0 / 60.0 + 40.7 / 3600.0), -(70.0 + 44.0 / 60.0 + 57.9 / 3600.0), 2662.75);
    // Skyfield's shadow has no atmosphere.
    let sky = sky(selected, site.expect("a site")).with_shadow(ShadowModel::Geometric);
    let start = moment("2026-04-25", "22:00:00");
    let request = ForecastRequest {
        include_dark: true,
        max_sun_altitude_rad: None,
        ..ForecastRequest::new(start, seconds_after(start, 13.0 * 3600.0))
    };
    let Forecast { found, .. } = forecast(&sky, &request, &Selection::default()).expect("a forecast");
    assert!(found.left_out.is_empty(), "{:?}", found.left_out);
    let mut worst: BTreeMap<&str, (usize, f64, f64)> = BTreeMap::new();
    for (id, events) in &golden {
        let computed: Vec<_> = found.passes.iter().filter(|pass| pass.norad_id.0 == *id).collect();
        let whole = computed.iter().filter(|pass| pass.rise.is_some() && pass.set.is_some()).count();
        assert_eq!(whole, events.iter().filter(|event| event.name == "rise").count(), "passes of {id}");
        for event in events {
            let points =
                computed.iter().filter(|pass| pass.rise.is_some() && pass.set.is_some()).filter_map(|pass| match event
                    .name
                    .as_str()
                {
                    "rise" => pass.rise.as_ref(),
                    "set" => pass.set.as_ref(),
                    "culmination" => Some(&pass.culmination),
                    "fades" => pass.shadow_entry.as_ref(),
                    _ => pass.shadow_exit.as_ref(),
                });
            let off = |point: &TrackPoint| seconds_between(start, point.epoch) - event.seconds;
            let nearest = points.min_by(|a, b| off(a).abs().total_cmp(&off(b).abs()));
            let nearest = nearest.unwrap_or_else(|| panic!("{id}: no {} at {} s", event.name, event.seconds));
            let off_s = off(nearest).abs();
            let allowed_s = match event.name.as_str() {
                "culmination" => SKYFIELD_TOP_S,
                "rise" | "set" => SKYFIELD_S,
                _ => SKYFIELD_SHADOW_S,
            };
            assert!(off_s < allowed_s, "{id}: {} {off_s} s off", event.name);
            let off_deg = (degrees(nearest.altitude_rad) - event.altitude_deg).abs();
            assert!(off_deg < SKYFIELD_DEG, "{id}: {} {off_deg} deg off", event.name);
            if matches!(event.name.as_str(), "rise" | "set") {
                let off_deg = (degrees(nearest.azimuth_rad) - event.azimuth_deg + 540.0).rem_euclid(360.0) - 180.0;
                assert!(off_deg.abs() < 10.0 * SKYFIELD_DEG, "{id}: azimuth {off_deg} deg off");
            }
            let entry = worst
                .entry(if event.name == "rise" || event.name == "set" { "border" } else { &event.name })
                .or_default();
            *entry = (entry.0 + 1, entry.1.max(off_s), entry.2.max(off_deg));
        }
    }
    println!("events, worst s, worst deg: {worst:?}");
    let counts = (worst["border"].0, worst["culmination"].0, worst["fades"].0 + worst["back"].0);
    assert_eq!(counts, (510, 255, 67), "{worst:?}");
}
