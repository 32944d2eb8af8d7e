//! Effects of old element sets: no drag for satellites that hold their orbits, and warnings about along-track errors
//! and changed verdicts.

use std::fs;

use serde_json::Value;
use streakcast::elements::{Constellation, ElementSet, NoradId, Origin, format_tle};

use crate::common::cli::{json, path, run};

const EPOCH: &str = "2026-08-07T00:00:00 UTC";
const FIELD: &[&str] = &["--mpc", "X05", "--fov", "3.5deg", "--limit-mag", "7"];

/// Writes the satellites of a simulated constellation as real ones with this name and an epoch a week before
/// examples/night.csv.
fn catalogue(folder: &tempfile::TempDir, shells: &str, name: &str, half_derivative_rev_day2: f64) -> String {
    catalogue_of(folder, shells, name, half_derivative_rev_day2, EPOCH)
}

fn catalogue_of(
    folder: &tempfile::TempDir,
    shells: &str,
    name: &str,
    half_derivative_rev_day2: f64,
    epoch: &str,
) -> String {
    let sets = Constellation::by_name(shells).unwrap().element_sets(epoch.parse().unwrap());
    let text = |(number, set): (u32, &ElementSet)| {
        let set = ElementSet {
            norad_id: NoradId(60_000 + number),
            mean_motion_dot_rev_day2: half_derivative_rev_day2,
            // Approximate B* of a circular orbit at 550 km for this ṅ/2.
            bstar_per_earth_radius: 5.0 * half_derivative_rev_day2,
            origin: Origin::Published,
            ..set.clone()
        };
        let [line1, line2] = format_tle(&set).unwrap();
        format!("{name}{number}\n{line1}\n{line2}\n")
    };
    let file = path(folder, &format!("{}.tle", &epoch[..10]));
    fs::write(&file, (1..).zip(&sets).map(text).collect::<String>()).unwrap();
    file
}

/// V2 Mini satellites, identified by name, with a published drag whose effect D t² = P ṅ/2 t² is 50 s after 7 days.
#[test]
fn verif_published_drag_changes_positions_and_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let file = catalogue(&folder, "starlink-gen1", "STARLINK-31", 1.8e-4);
    let words =
        ["ephemeris", "--norad", "60001", "--times", "2026-08-14T00:00:00Z", "--elements", &file, "--mpc", "X05"];
    let answer = |drag: &[&str]| json(&[&words, drag, &["--quiet"]]);
    let (default, station_keeping) = (answer(&[]), answer(&["--drag", "station-keeping"]));
    let published = answer(&["--drag", "published"]);
    assert_eq!(default, station_keeping);
    let stated = [&station_keeping, &published].map(|answer| answer["provenance"]["drag"].as_str().unwrap_or_default());
    assert_eq!(stated, ["station-keeping", "published"]);
    let number = |answer: &Value, name: &str| answer["ephemeris"][0][name].as_f64().unwrap();
    let [ra, dec] = ["ra_deg", "dec_deg"].map(|name| number(&published, name) - number(&station_keeping, name));
    let moved_deg = (ra * number(&station_keeping, "dec_deg").to_radians().cos()).hypot(dec);
    assert!(moved_deg > 0.5, "{moved_deg}");
    // Without drag the stated along-track error is smaller.
    let late_s = |answer: &Value| number(answer, "along_track_sigma_s");
    assert!(late_s(&station_keeping) < 0.5 * late_s(&published), "{} {}", late_s(&station_keeping), late_s(&published));
}

/// Each night of a schedule uses the element sets closest to it, as if it was judged alone.
#[test]
fn verif_element_sets_are_chosen_for_each_night() {
    let folder = tempfile::tempdir().unwrap();
    let of = |epoch| catalogue_of(&folder, "starlink-gen1", "STARLINK-31", 1e-6, epoch);
    let files = ["2026-08-07T00:00:00 UTC", "2026-08-19T00:00:00 UTC"].map(of);
    let rows = [("a", "2026-08-08T01:00:00Z"), ("b", "2026-08-09T01:00:00Z"), ("c", "2026-08-20T01:00:00Z")];
    let judged = |rows: &[(&str, &str)]| {
        let row = |(id, start): &(&str, &str)| format!("{id},{start},300,270,-30\n");
        let schedule = path(&folder, "schedule.csv");
        let head = "exposure_id,start_utc,exposure_s,ra_deg,dec_deg\n".to_owned();
        fs::write(&schedule, head + &rows.iter().map(row).collect::<String>()).unwrap();
        let words =
            ["flag", "--elements", &files[0], &files[1], "--schedule", &schedule, "--mpc", "X05", "--fov", "10deg"];
        json(&[&words, &["--quiet"]])
    };
    let all = judged(&rows);
    assert_eq!(all["provenance"]["element_sets"], "closest to the middle of each night");
    for (index, row) in rows.iter().enumerate() {
        let alone = judged(&[*row]);
        assert_eq!(all["flags"][index], alone["flags"][0], "{row:?}");
        let age_days = all["flags"][index]["elements_age_days"].as_f64().unwrap();
        assert!((1.0..2.3).contains(&age_days), "{row:?} {age_days}");
    }
}

fn share(text: &str) -> f64 {
    let (before, _) = text.split_once(" % of the visits would change verdict").unwrap_or_else(|| panic!("{text}"));
    before.rsplit(' ').next().unwrap().parse().unwrap()
}

/// Returns the printed percentage of verdicts that change: the mean of p_crossing of clear visits, and of 1 -
/// p_crossing of the others.
fn changed(stdout: &str) -> f64 {
    let answer: Value = serde_json::from_str(stdout).unwrap();
    let flags = answer["flags"].as_array().unwrap();
    let change = |flag: &Value| {
        let p = flag["p_crossing"].as_f64().unwrap();
        if flag["verdict"] == "clear" { p } else { 1.0 - p }
    };
    100.0 * flags.iter().map(change).sum::<f64>() / flags.len() as f64
}

const SMALL_FIELD: &[&str] = &["--mpc", "X05", "--fov", "2deg", "--format", "json"];

/// Writes a schedule of selected visits of the first minutes of the night.
fn visits(folder: &tempfile::TempDir, name: &str, wanted: impl Fn(&str) -> bool) -> String {
    let mut text = "exposure_id,start_utc,duration_s,ra_deg,dec_deg,band\n".to_owned();
    for number in 0..80 {
        let (id, second) = (format!("v{number}"), 29 * 60 + 5 + 10 * number);
        let (ra_deg, dec_deg) = (190 + 7 * number % 50, 11 * number % 40 - 30);
        if wanted(&id) {
            text += &format!("{id},2026-08-14T23:{:02}:{:02}Z,30,{ra_deg},{dec_deg},z\n", second / 60, second % 60);
        }
    }
    let file = path(folder, name);
    fs::write(&file, text).unwrap();
    file
}

/// With --min-probability, near misses make visits `streaked` without a nominal crossing. These visits change to clear
/// with the probability that no satellite crosses. Clear visits also contribute to the percentage.
#[test]
fn verif_shares_of_near_misses_follow_the_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let file = catalogue(&folder, "starlink-gen1", "ONEWEB-", 2e-5);
    let flag = |schedule: &str, more: &[&str]| {
        let (code, stdout, stderr) = run(&[&["flag", "--schedule", schedule, "--elements", &file], SMALL_FIELD, more]);
        assert_eq!(code, 0, "{stderr}");
        let expected = changed(&stdout);
        assert!((share(&stderr) - expected).abs() < 0.06, "{expected}: {stderr}");
        let answer: Value = serde_json::from_str(&stdout).unwrap();
        (answer["flags"].as_array().unwrap().clone(), stderr)
    };
    let all = visits(&folder, "all.csv", |_| true);
    let (flags, _) = flag(&all, &["--min-probability", "0.05"]);
    let is_near = |flag: &&Value| flag["verdict"] == "streaked" && flag["n_streaks"] == 0;
    assert!(flags.iter().filter(is_near).count() > 2, "{flags:?}");
    assert!(flags.iter().any(|flag| flag["n_streaks"] != 0), "{flags:?}");

    let (flags, stderr) = flag(&all, &[]);
    assert!(stderr.contains("median of the satellites that cross)"), "{stderr}");
    let is_clear = |flag: &&Value| flag["verdict"] == "clear" && flag["p_any"].as_f64().is_some_and(|p| p > 0.01);
    let clear: Vec<&str> = flags.iter().filter(is_clear).filter_map(|flag| flag["exposure_id"].as_str()).collect();
    assert!(clear.len() > 2, "{flags:?}");
    let (flags, stderr) = flag(&visits(&folder, "clear.csv", |id| clear.contains(&id)), &[]);
    assert!(flags.len() == clear.len() && flags.iter().all(|flag| flag["verdict"] == "clear"), "{flags:?}");
    assert!(stderr.contains("elements 8.0 days old: ") && stderr.contains("that may cross)"), "{stderr}");
}

#[test]
fn verif_old_elements_warn_with_their_effect_on_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let file = catalogue(&folder, "starlink-gen1", "ONEWEB-", 2e-5);
    let night = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/night.csv");
    let flag = ["flag", "--schedule", night, "--elements", &file, "--format", "json"];
    let (code, stdout, stderr) = run(&[&flag, FIELD]);
    assert_eq!(code, 0, "{stderr}");
    let warning =
        stderr.lines().find(|line| line.contains("would change verdict")).unwrap_or_else(|| panic!("{stderr}"));
    assert!(
        warning.starts_with("warning: elements 8.0 days old: ") && warning.contains(" s late (68 %, "),
        "{warning}"
    );
    let expected = changed(&stdout);
    assert!((share(warning) - expected).abs() < 0.06, "{expected}: {warning}");
    assert!(expected > 1.0, "{expected}");

    let doctor = ["doctor", "--now", "2026-08-14T23:00:00Z", "--elements", &file, "--schedule", night, "--cache"];
    let cache = path(&folder, "cache");
    let answer = json(&[&doctor, &[&cache], FIELD, &["--quiet"]]);
    let finding = |subject: &str| {
        let all = answer["findings"].as_array().unwrap();
        all.iter().find(|one| one["subject"] == subject).unwrap_or_else(|| panic!("{answer}")).clone()
    };
    assert_eq!(finding("schedule")["severity"], "warning");
    assert!((share(finding("schedule")["finding"].as_str().unwrap()) - expected).abs() < 0.06);
    let elements = finding("elements");
    let text = elements["finding"].as_str().unwrap();
    assert!(text.contains("median age 8.0 days; early or late by ") && text.contains(" s (68 %, median)"), "{text}");
    // A schedule that cannot be read is a finding.
    let (code, stdout, _) =
        run(&[&["doctor", "--schedule", "no-such.csv", "--cache", &cache, "--format", "json"], FIELD]);
    assert!(code == 2 && stdout.contains("no-such.csv"), "{stdout}");
}

/// The elements of simulated satellites are always current.
#[test]
fn verif_new_elements_do_not_warn() {
    let night = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/night.csv");
    let (_, _, stderr) = run(&[&["flag", "--schedule", night, "--shells", "starlink-gen1"], FIELD]);
    assert!(!stderr.contains("would change verdict"), "{stderr}");
}

/// Sets of two real Starlinks under the numbers of others, and twice for one epoch.
#[test]
fn sets_of_other_objects_and_of_one_epoch_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let newer = "STARLINK-34196\n1 65324U 25189B   26166.12147178  .00018327  00000+0  60100-3 0  9997\n\
                 2 65324  53.1595 113.5030 0001459  64.7383 295.3769 15.31694726 45984\n";
    let older = "STARLINK-34196\n1 65324U 25189AD  26159.13933807  .00023527  00000+0  76732-3 0  9998\n\
                 2 65324  53.1588 146.0019 0001299 101.0509 259.0638 15.31707454 44918\n";
    let first = "STARLINK-32802\n1 62738U 25014D   26166.13020166  .00025209  00000+0  92190-3 0  9999\n\
                 2 62738  42.9990 323.7495 0002233 274.8313  85.2284 15.27598852 78165\n";
    let last = "STARLINK-32802\n1 62738U 25014D   26166.13020166  .00021520  00000+0  78874-3 0  9994\n\
                2 62738  43.0022   4.7372 0002416 265.7686  94.2889 15.27599978 77056\n";
    let file = path(&folder, "sets.tle");
    for (text, expected) in [
        (
            [newer, older, first].concat(),
            Some(
                "1 element set of another epoch ignored, because the COSPAR designator is that of another object than in the \
                  set that is used: 65324 STARLINK-34196 (2025-189AD, not 2025-189B)",
            ),
        ),
        (
            [first, last].concat(),
            Some(
                "1 element set ignored, because another set of the same satellite and epoch with different elements is read \
                  after it: 62738 STARLINK-32802 (used: inclination 43.0022 deg, not 42.999 deg)",
            ),
        ),
        ([last, newer, first].concat(), Some("(used: inclination 42.999 deg, not 43.0022 deg)")),
        ([newer, first, first].concat(), None),
    ] {
        fs::write(&file, text).unwrap();
        let schedule = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\n1,2026-06-16T03:00:00Z,30,217,-30\n";
        let night = path(&folder, "night.csv");
        fs::write(&night, schedule).unwrap();
        for words in [
            &["ephemeris", "--norad", "62738", "--times", "2026-06-16T03:00:00Z"][..],
            &["flag", "--schedule", &night, "--fov", "3.5deg"],
        ] {
            let (code, _, stderr) = run(&[words, &["--elements", &file, "--mpc", "X05"]]);
            assert_eq!(code, 0, "{stderr}");
            assert_eq!(stderr.contains("ignored"), expected.is_some(), "{stderr}");
            assert!(stderr.contains(expected.unwrap_or_default()), "{stderr}");
        }
    }
}
