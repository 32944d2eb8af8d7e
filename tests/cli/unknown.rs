//! Elements that are too old: positions are unknown, in every verb, and not clear.

use std::fs;

use serde_json::Value;
use streakcast::elements::{Constellation, ElementSet, NoradId, Origin, format_tle};
use tempfile::TempDir;

use crate::common::cli::{json, path, records, run};
use crate::common::injected::SKY;

const SITE: &[&str] = &["--mpc", "X05", "--fov", "3.5deg"];
const SCHEDULE: &str = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\n\
                        a,2026-08-14T23:29:05Z,30,198.9,7.7\nb,2026-08-14T23:35:05Z,30,198.9,7.7\n";

/// Writes satellites of a simulated constellation as real ones: every `each`-th with elements `old_days` old on the
/// night of the schedule, the others half a day old.
fn elements(folder: &TempDir, name: &str, old_days: f64, each: usize) -> String {
    let epoch = |days: f64| -> hifitime::Epoch {
        "2026-08-14T23:29:05 UTC".parse::<hifitime::Epoch>().unwrap() - hifitime::Unit::Day * days
    };
    let text = |(number, set): (usize, &ElementSet)| {
        let set = ElementSet {
            norad_id: NoradId(60_000 + number as u32),
            epoch: epoch(if number % each == 0 { old_days } else { 0.5 }),
            mean_motion_dot_rev_day2: 2e-5,
            origin: Origin::Published,
            ..set.clone()
        };
        let [line1, line2] = format_tle(&set).unwrap();
        format!("{name}{number}\n{line1}\n{line2}\n")
    };
    let sets = Constellation::by_name("starlink-gen1").unwrap().element_sets(epoch(0.5));
    let file = path(folder, &format!("{old_days}.{each}.tle"));
    fs::write(&file, (0..).zip(sets.iter().step_by(4)).map(text).collect::<String>()).unwrap();
    file
}

fn flags(folder: &TempDir, elements: &str, more: &[&str]) -> Value {
    let schedule = path(folder, "night.csv");
    fs::write(&schedule, SCHEDULE).unwrap();
    let field: &[&str] = if more.contains(&"--fov") { &["--mpc", "X05"] } else { SITE };
    json(&[&["flag", "--elements", elements, "--schedule", &schedule, "--quiet"], field, more])
}

/// Satellites of unknown position are not drawn, but counted.
#[test]
fn satellites_of_unknown_position_are_not_injected() {
    let folder = tempfile::tempdir().unwrap();
    let sky = path(&folder, "sky.toml");
    let text = SKY.replace("columns = 400", "columns = 1200").replace("rows = 300", "rows = 1200");
    let text = text.replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 90.0");
    fs::write(&sky, text.replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0")).unwrap();
    let inject = |days: f64| {
        let file = elements(&folder, "STARLINK-31", days, 1);
        let (output, truth) = (path(&folder, "o.fits"), path(&folder, "truth.csv"));
        let shot = ["--start", "2026-08-14T23:29:05Z", "--exposure", "120s", "--ra", "198.9", "--dec", "7.7"];
        let files = ["inject", "--synthetic", &sky, "-o", &output, "--truth", &truth, "--seeing", "270arcsec"];
        let (code, _, stderr) = run(&[&files, &shot, &["--elements", &file, "--mpc", "X05"]]);
        assert_eq!(code, 0, "{stderr}");
        (records(&fs::read_to_string(&truth).unwrap()).len() - 1, stderr)
    };
    let (drawn, stderr) = inject(0.5);
    assert!(drawn > 0 && !stderr.contains("of unknown position"), "{drawn}: {stderr}");
    let (drawn, stderr) = inject(60.0);
    assert!(
        drawn == 0 && stderr.contains("of unknown position left out, because the element sets are too old"),
        "{stderr}"
    );
}

#[test]
fn verdicts_with_old_elements_are_unknown() {
    let folder = tempfile::tempdir().unwrap();
    for days in [216.0, 20_000.0, -60.0] {
        let file = elements(&folder, "STARLINK-31", days, 1);
        let answer = flags(&folder, &file, &["--limit-mag", "7"]);
        let age = if days < 0.0 { "60 days newer than the exposure".to_owned() } else { format!("{days:.0} days old") };
        for flag in answer["flags"].as_array().unwrap() {
            assert_eq!(flag["verdict"], "unknown");
            assert_eq!(flag["reasons"][0], format!("elements {age}: positions unknown"), "{flag}");
            // Numbers are unknown, not zero.
            for column in ["n_streaks", "p_any", "p_crossing", "late_s", "delay_s", "next_clear_start_utc"] {
                assert!(flag[column].is_null(), "{column}: {flag}");
            }
            assert!((flag["elements_age_days"].as_f64().unwrap() - days).abs() < 0.3, "{flag}");
        }
        assert_eq!(answer["left_out"].as_array().unwrap().len(), 1102);
    }
    // The same satellites with fresh elements.
    let file = elements(&folder, "STARLINK-31", 0.5, 1);
    for flag in flags(&folder, &file, &[])["flags"].as_array().unwrap() {
        assert_ne!(flag["verdict"], "unknown");
        assert!((flag["elements_age_days"].as_f64().unwrap() - 0.5).abs() < 0.2, "{flag}");
        let late_s = flag["late_s"].as_f64().unwrap();
        assert!(late_s > 0.1 && late_s < 3.0, "{flag}");
    }
}

/// Satellites that hold their orbits have no calibrated lateness beyond 21 days.
#[test]
fn a_few_old_sets_do_not_make_a_night_unknown() {
    let folder = tempfile::tempdir().unwrap();
    for (each, is_unknown) in [(10, false), (3, false), (1, true)] {
        let file = elements(&folder, "STARLINK-31", 25.0, each);
        let answer = flags(&folder, &file, &[]);
        for flag in answer["flags"].as_array().unwrap() {
            assert_eq!(flag["verdict"] == "unknown", is_unknown, "{flag}");
        }
        // They are counted and named.
        let left_out = answer["left_out"].as_array().unwrap();
        assert_eq!(left_out.len(), 1102_usize.div_ceil(each));
        assert_eq!(left_out[0]["norad_id"], 60_000);
        assert_eq!(left_out[0]["reason"], "satellite 60000: position unknown, elements 25 days old");
        let schedule = path(&folder, "night.csv");
        let (_, _, stderr) = run(&[&["flag", "--elements", &file, "--schedule", &schedule], SITE]);
        let counted = "1,102 element sets are too old to predict positions (median: elements 25 days old)";
        assert!(stderr.contains(counted) && stderr.contains("left out at these times: 60000, "), "{stderr}");
    }
}

#[test]
fn passes_windows_and_calendars_with_old_elements_state_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = elements(&folder, "STARLINK-31", 216.0, 1);
    let targets = path(&folder, "targets.csv");
    fs::write(&targets, "name,ra_deg,dec_deg,exposure_s\nM 87,198.9,7.7,30\n").unwrap();
    let elements: &[&str] = &["--elements", &file];
    let exposure = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"];
    let calendar = path(&folder, "night.ics");
    let reason = "elements 216 days old: positions unknown";
    for verb in [
        &[&["passes"], &exposure[..], SITE].concat()[..],
        &["forecast", "--night", "2026-08-14", "--mpc", "X05"],
        &["forecast", "--night", "2026-08-14", "--mpc", "X05", "--output", &calendar],
    ] {
        let (code, stdout, stderr) = run(&[verb, elements]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        let error = stderr.lines().last().unwrap();
        assert!(error.starts_with("error: elements 21") && error.contains("days old: positions unknown"), "{stderr}");
    }
    assert!(!fs::exists(&calendar).unwrap());
    let range: &[&str] = &["--start", "2026-08-14T23:29:00Z", "--end", "2026-08-14T23:40:00Z", "--targets", &targets];
    let answer = json(&[&["windows", "--quiet"], range, SITE, elements]);
    let target = &answer["targets"][0];
    assert_eq!(
        (target["n_windows"].as_u64(), target["reason"].as_str()),
        (Some(0), Some(format!("unknown: {reason}").as_str()))
    );
    // A limit of a satellite of known position is exceeded, whatever the others do.
    let ephemeris = ["ephemeris", "--norad", "60001", "--times", "2026-08-14T23:29:05Z", "--mpc", "X05", "--quiet"];
    let row = &json(&[&ephemeris, elements])["ephemeris"][0];
    assert!(row["along_track_sigma_s"].is_null() && row["element_age_days"].as_f64().unwrap() > 215.0, "{row}");
    let (_, stdout, _) =
        run(&[&["doctor", "--mpc", "X05", "--now", "2026-08-14T23:29:05Z", "--format", "csv"], elements]);
    assert!(stdout.contains("positions unknown") && !stdout.contains("early or late"), "{stdout}");
}

/// A forecast over days and windows over a week, of which the last days are unknown, say so.
#[test]
fn the_unknown_days_of_a_longer_request_are_named() {
    let folder = tempfile::tempdir().unwrap();
    // Known until 21 days after the epoch.
    let file = elements(&folder, "STARLINK-31", 18.0, 1);
    let elements: &[&str] = &["--elements", &file, "--mpc", "X05"];
    let range: &[&str] = &["--start", "2026-08-14T22:00:00Z", "--end", "2026-08-19T22:00:00Z"];
    let (code, _, stderr) = run(&[&["forecast", "--norad", "60001"], range, elements]);
    assert_eq!(code, 0, "{stderr}");
    let warning = "days old: positions unknown in all or part of the time from 2026-08-1";
    assert!(stderr.contains(warning) && stderr.contains(" to 2026-08-19T22:00:00Z: passes in it"), "{stderr}");
    // The target is observable in the nights of the known days and of the unknown ones.
    let target: &[&str] = &["--ra", "230", "--dec=-30", "--exposure", "10min", "--fov", "0.1deg"];
    let (code, stdout, stderr) = run(&[&["windows", "--format", "json"], range, elements, target]);
    assert_eq!(code, 0, "{stderr}");
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    let found = &answer["targets"][0];
    assert!(found["n_windows"].as_u64().unwrap() > 0, "{found}");
    assert!(found["reason"].as_str().unwrap().starts_with("some starts are unknown: elements 2"), "{found}");
    assert!(stderr.contains(": some starts are unknown: elements 2"), "{stderr}");
}

/// Satellites in drag are early or late by minutes after 60 days: crossings have probabilities, but no start is known
/// to be clear.
#[test]
fn starts_with_late_satellites_are_unknown() {
    let folder = tempfile::tempdir().unwrap();
    let file = elements(&folder, "COSMOS-", 60.0, 1);
    let answer = flags(&folder, &file, &["--fov", "60deg"]);
    for flag in answer["flags"].as_array().unwrap() {
        assert_eq!(flag["verdict"], "streaked", "{flag}");
        assert!(flag["p_crossing"].as_f64().unwrap() > 0.5 && flag["late_s"].as_f64().unwrap() > 100.0, "{flag}");
        assert!(flag["delay_s"].is_null() && flag["reasons"].to_string().contains("no clear start is known"), "{flag}");
    }
}

/// A forecast of only satellites with old elements is an error, like that of an old catalogue: an empty list would mean
/// that they do not rise. If the passes of some are unknown, an empty calendar says so.
#[test]
fn an_empty_forecast_names_old_elements() {
    let folder = tempfile::tempdir().unwrap();
    let file = elements(&folder, "STARLINK-31", 60.0, 10);
    let night = ["forecast", "--night", "2026-08-14", "--mpc", "X05", "--elements", &file, "--norad"];
    for format in ["csv", "json", "ics"] {
        let (code, stdout, stderr) = run(&[&night, &["60010", "--format", format]]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        assert!(
            stderr.contains("error: the elements of 1 selected satellite are too old to predict passes"),
            "{stderr}"
        );
    }
    let (_, stdout, stderr) = run(&[&night, &["60010", "60001", "--max-mag=-5", "--format", "ics"]]);
    let calendar = stdout.replace("\r\n ", "");
    assert!(calendar.contains("SUMMARY:Unknown satellite passes over"), "{stdout} {stderr}");
    assert!(calendar.contains("the elements of 1 of 2 satellites are too old to predict passes"), "{stdout}");
}

/// An empty night of satellites whose times are uncertain by minutes may have passes; the calendar says so. The error
/// and the warning for old catalogues do not count satellites that are not selected.
#[test]
fn an_empty_forecast_of_late_satellites_is_uncertain() {
    let folder = tempfile::tempdir().unwrap();
    let file = elements(&folder, "COSMOS-", 60.0, 1);
    let night = ["forecast", "--night", "2026-08-14", "--mpc", "X05", "--elements", &file, "--norad", "60010"];
    let (_, stdout, stderr) = run(&[&night, &["--max-mag=-5", "--format", "ics"]]);
    let calendar = stdout.replace("\r\n ", "");
    assert!(calendar.contains("SUMMARY:Unknown satellite passes over"), "{stdout} {stderr}");
    let reason = "the times of 1 of 1 satellites is uncertain by up to 1";
    assert!(calendar.contains(reason) && calendar.contains("so that a pass may be visible"), "{calendar}");

    // All but the first satellite are too old.
    let all_old = elements(&folder, "STARLINK-31", 60.0, 1);
    let fresh = elements(&folder, "COSMOS-", 0.5, 1);
    let one = fs::read_to_string(&fresh).unwrap().lines().take(3).collect::<Vec<_>>().join("\n");
    let old: String = fs::read_to_string(&all_old).unwrap().lines().skip(3).map(|line| format!("{line}\n")).collect();
    let file = path(&folder, "both.tle");
    fs::write(&file, format!("{one}\n{old}")).unwrap();
    let (code, _, stderr) =
        run(&[&["forecast", "--night", "2026-08-14", "--mpc", "X05", "--elements", &file, "--norad", "60000"]]);
    assert_eq!(code, 0, "{stderr}");
    assert!(!stderr.contains("positions"), "{stderr}");
}

/// The night of a date is that of the site's civil date in `windows` as in `forecast`, beyond the date line too.
#[test]
fn nights_of_windows_and_forecast_are_the_same() {
    let starts = |verb: &str, more: &[&str]| {
        let site = ["--time-zone", "Pacific/Tongatapu", "--night", "2026-08-22", "--lat=-21.2", "--lon=-175.2"];
        let answer = json(&[&[verb, "--shells", "starlink-gen1"], &site, more]);
        answer["provenance"]["options"].to_string()
    };
    let windows = starts("windows", &["--target", "M7", "--fov", "0.5deg", "--exposure", "30s", "--limit-mag", "3"]);
    let forecast = starts("forecast", &["--norad", "900000001"]);
    // The Sun sets at 05:00 UTC on 22 August.
    assert!(windows.contains("2026-08-22T") && forecast.contains("2026-08-22T"), "{windows} {forecast}");
    assert!(!windows.contains("2026-08-24T"), "{windows}");
}

#[test]
fn simulated_constellations_do_not_age() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = path(&folder, "night.csv");
    let rows = SCHEDULE.replace("b,2026-08-14", "b,2029-08-14");
    fs::write(&schedule, rows).unwrap();
    let answer = json(&[&["flag", "--shells", "starlink-gen1", "--schedule", &schedule, "--quiet"], SITE]);
    for flag in answer["flags"].as_array().unwrap() {
        assert_ne!(flag["verdict"], "unknown", "{flag}");
    }
}

/// Without a satellite that can be propagated, no row is printed as clear before the error.
#[test]
fn nothing_is_printed_if_nothing_can_be_propagated() {
    let folder = TempDir::new().unwrap();
    let (file, schedule) = (path(&folder, "decayed.json"), path(&folder, "night.csv"));
    let text = r#"[{"NORAD_CAT_ID": 44714, "EPOCH": "2026-08-12T22:00:09", "MEAN_MOTION": 15.6, "ECCENTRICITY": 0.0005,
        "INCLINATION": 53.1, "RA_OF_ASC_NODE": 111.5, "ARG_OF_PERICENTER": 74.6, "MEAN_ANOMALY": 285.6, "BSTAR": 0.0009,
        "DECAY_DATE": "2026-08-13"}]"#;
    fs::write(&file, text).unwrap();
    fs::write(&schedule, SCHEDULE).unwrap();
    for format in ["csv", "json"] {
        let words = ["flag", "--schedule", &schedule, "--elements", &file, "--format", format];
        let (code, stdout, stderr) = run(&[&words, SITE]);
        assert_eq!((code, &*stdout), (2, ""), "{stderr}");
        assert!(stderr.contains("the only element set cannot be propagated to 2026-08-14"), "{stderr}");
    }
}

/// Times before and after the decay of the only satellite: rows before it, and a warning.
#[test]
fn rows_before_a_decay_are_printed() {
    let folder = TempDir::new().unwrap();
    let file = path(&folder, "decayed.json");
    let text = r#"[{"NORAD_CAT_ID": 44714, "EPOCH": "2026-08-19T22:00:09", "MEAN_MOTION": 15.6112273, "ECCENTRICITY": 0.0005,
        "INCLINATION": 53.1481, "RA_OF_ASC_NODE": 111.5096, "ARG_OF_PERICENTER": 74.5693, "MEAN_ANOMALY": 285.5893, "BSTAR": 0.00092924,
        "DECAY_DATE": "2026-08-22T06:00:00"}]"#;
    fs::write(&file, text).unwrap();
    let times = |times: &'static [&str]| [&["ephemeris", "--norad", "44714", "--times"][..], times].concat();
    let of = |words: &[&str]| run(&[words, &["--lat", "30", "--lon", "-110", "--elements", &file, "--format", "csv"]]);
    let (before, after) = ("2026-08-22T05:00:00Z", "2026-08-22T07:00:00Z");
    for both in [
        times(&["2026-08-22T05:00:00Z", "2026-08-22T07:00:00Z"]),
        times(&["2026-08-22T07:00:00Z", "2026-08-22T05:00:00Z"]),
    ] {
        let (code, stdout, stderr) = of(&both);
        assert_eq!((code, stdout.contains(&before[..19]), stdout.contains(&after[..19])), (0, true, false), "{stderr}");
        assert!(stderr.contains("cannot be propagated to a part of these times"), "{stderr}");
        assert!(stderr.contains("has decayed before 2026-08-22T06:00:00"), "{stderr}");
    }
    let (code, _, stderr) = of(&times(&["2026-08-22T07:00:00Z"]));
    assert!(code == 2 && stderr.contains("cannot be propagated to 2026-08-22T07:00:00"), "{stderr}");
    // Passes of the night of the decay.
    let night = [
        "forecast",
        "--start",
        "2026-08-22T00:00:00Z",
        "--end",
        "2026-08-22T12:00:00Z",
        "--max-mag",
        "20",
        "--min-p-brighter",
        "0",
    ];
    let (code, _, stderr) = of(&night);
    assert!(code == 0, "{stderr}");
}
