//! Passes above the horizon and shadow entries compared with STK and Heavens-Above.

use crate::common::agreement::Agreement;
use std::path::Path;

use hifitime::{Epoch, Unit};
use streakcast::elements::{ElementSet, NoradId, ReadOptions, Satellites};
use streakcast::frames::{EopTable, OrientationTable, seconds_after, seconds_between};
use streakcast::geometry::{Illumination, Observer, ShadowModel, Site, SunTable};
use streakcast::orbit::Propagator;
use streakcast::passes::{ModelChoice, Sky, VisiblePass, VisibleRequest};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};

/// Tolerance for STK, seconds. It prints milliseconds and uses its own UT1; a difference of a few milliseconds in UT1
/// changes the times by about 1 ms.
const STK_S: f64 = 0.1;
const STK_ALTITUDE_DEG: f64 = 0.006;

/// Tolerance of rise and set, seconds: Heavens-Above gives whole seconds and degrees.
const HEAVENS_ABOVE_BORDER_S: f64 = 2.0;
/// Tolerance of culminations, seconds: the altitude changes slowly there, less so near the zenith.
const HEAVENS_ABOVE_TOP_S: f64 = 3.0;
const HEAVENS_ABOVE_ALTITUDE_DEG: f64 = 0.6;
/// The shadow entry of Heavens-Above is the first dimming computed here (half of the disk of the Sun is hidden 4.4 s
/// later, all of it 8.7 s later). The tolerance is for rounding and another shadow model.
const HEAVENS_ABOVE_SHADOW_S: f64 = 1.0;

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

fn passes(elements: ElementSet, site: Site, start: Epoch, days: f64, min_altitude_deg: f64) -> Vec<VisiblePass> {
    let choice = ModelChoice::new(&ModelLibrary::embedded()).expect("shipped models");
    let sky = Sky::with_models(vec![elements], Observer::new(site), EopTable::embedded(), &choice);
    let request = VisibleRequest {
        start,
        end: seconds_after(start, days * 86_400.0),
        dark: Vec::new(),
        min_altitude_rad: min_altitude_deg.to_radians(),
        min_culmination_rad: min_altitude_deg.to_radians(),
        limit: None,
        include_dark: true,
        samples: 0,
        photometry: PhotometryOptions::default(),
    };
    let found = sky.visible_passes(&request, &|_| true).expect("passes");
    assert!(found.left_out.is_empty(), "{:?}", found.left_out);
    found.passes
}

/// Parses a time such as `2014/10/23 01:27:33.224`.
fn moment(date: &str, clock: &str) -> Epoch {
    format!("{}T{clock} UTC", date.replace('/', "-")).parse().expect("an epoch")
}

#[test]
fn valid_passes_against_stk() {
    let Some(data) = crate::common::data_dir() else { return };
    let path = data.join("reference").join("heavens_above").join("stk_bugsat_passes.txt");
    let text = std::fs::read_to_string(&path).expect("the passes");
    let site = Site::new_deg("STK", -31.2884, -64.203_286_8, 492.96).expect("a site");
    let computed = passes(elements(&path, 40014), site, moment("2014/10/23", "00:00:00"), 2.3, 0.0);
    let mut compared = 0;
    let mut border = Agreement::new("Rise and set, 10 passes", "STK", STK_S, "s");
    let mut summit = Agreement::new("Time of culmination, 10 passes", "STK", STK_S, "s");
    let mut height = Agreement::new("Altitude at culmination, 10 passes", "STK", STK_ALTITUDE_DEG, "deg");
    for line in text.lines().filter(|line| line.starts_with("2014/")) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (rise, top, set) = (moment(words[0], words[1]), moment(words[2], words[3]), moment(words[4], words[5]));
        let altitude_deg: f64 = words[7].parse().expect("degrees");
        let pass = computed.iter().find(|pass| seconds_between(top, pass.culmination.epoch).abs() < 60.0).expect(line);
        let (our_rise, our_set) = (pass.rise.as_ref().expect("a rise"), pass.set.as_ref().expect("a set"));
        border.add(seconds_between(rise, our_rise.epoch));
        border.add(seconds_between(set, our_set.epoch));
        summit.add(seconds_between(top, pass.culmination.epoch));
        height.add(pass.culmination.altitude_rad.expect("an altitude").to_degrees() - altitude_deg);
        compared += 1;
    }
    assert_eq!(compared, 10);
    // STK lists all passes above the horizon in its time range.
    assert_eq!(
        computed.len(),
        compared,
        "{:?}",
        computed.iter().map(|pass| pass.culmination.epoch).collect::<Vec<_>>()
    );
}

#[test]
fn valid_passes_and_shadow_against_heavens_above() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = data.join("reference").join("heavens_above");
    let set = elements(&folder.join("heavens_above.tle"), 25544);
    let site = Site::new_deg("Zurich", 47.3744, 8.541, 0.0).expect("a site");
    let start = moment("2022-01-21", "00:00:00");
    let computed = passes(set.clone(), site, start, 10.0, 10.0);
    let eop = EopTable::embedded();
    let end = seconds_after(start, 10.0 * 86_400.0);
    let (orientation, sun) = (OrientationTable::new(start, end, &eop), SunTable::new(start, end));
    let propagator = Propagator::new(&set).expect("an orbit");
    let lit = |epoch: Epoch| {
        let seconds = seconds_between(start, epoch);
        let state = propagator.state(epoch, &orientation.at_s(seconds).teme_to_gcrs).expect("a state");
        // Heavens-Above gives the first dimming without atmosphere.
        ShadowModel::Geometric.illumination(&state.position, &sun.at_s(seconds).sun)
    };

    let (mut compared, mut shadows) = (0, Vec::new());
    let heavens_above = "Heavens-Above (printed to 1 s and 1 deg)";
    let mut border = Agreement::new("Rise over 10 deg", heavens_above, HEAVENS_ABOVE_BORDER_S, "s");
    let mut summit = Agreement::new("Time of culmination", heavens_above, HEAVENS_ABOVE_TOP_S, "s");
    let mut height = Agreement::new("Altitude at culmination", heavens_above, HEAVENS_ABOVE_ALTITUDE_DEG, "deg");
    let text = std::fs::read_to_string(folder.join("heavens_above_passes.csv")).expect("the passes");
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        // Local time is UTC + 1 h.
        let at = |cell: usize| moment(cells[8], cells[cell]) - 1.0 * Unit::Hour;
        let degrees = |cell: usize| cells[cell].parse::<f64>().expect("degrees");
        let pass = computed
            .iter()
            .find(|pass| pass.rise.as_ref().is_some_and(|rise| seconds_between(at(10), rise.epoch).abs() < 60.0));
        let pass = pass.unwrap_or_else(|| panic!("no pass for {line}"));
        let rise = pass.rise.as_ref().expect("found by it");
        border.add(seconds_between(at(10), rise.epoch));
        assert_eq!(degrees(11), 10.0);

        let (top_s, top_deg) = (
            seconds_between(at(13), pass.culmination.epoch),
            pass.culmination.altitude_rad.expect("an altitude").to_degrees(),
        );
        let ends_in_shadow = degrees(17) > 10.0;
        // If the satellite enters the shadow before culmination, Heavens-Above gives the entry as highest point.
        if at(13) < at(16) {
            summit.add(top_s);
            height.add(top_deg - degrees(14));
        }
        assert!(ends_in_shadow, "{line}");
        // In steps of 0.01 s, starting a minute before the time of Heavens-Above.
        let before = seconds_after(at(16), -60.0);
        assert_eq!(lit(before), Illumination::Sunlit, "{line}");
        let step = (0..12_000).find(|step| lit(seconds_after(before, f64::from(*step) * 0.01)) != Illumination::Sunlit);
        shadows.push(f64::from(step.expect("a shadow")) * 0.01 - 60.0);
        compared += 1;
    }
    println!("{compared} passes; shadow entries, computed less expected: {shadows:.2?} s");
    assert_eq!(compared, 15);
    for off_s in shadows {
        assert!(off_s.abs() < HEAVENS_ABOVE_SHADOW_S, "{off_s}");
    }
}
