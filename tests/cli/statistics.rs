//! The verbs `statistics` and `reproduce` of counts of satellites.

use crate::common::cli::{done, json, records, run};

const STATISTICS: &[&str] = &["statistics", "--shells", "starlink-gen1", "--mpc", "X05", "--quiet"];

#[test]
fn verif_statistics_by_season_and_latitude() {
    let more: &[&str] = &[
        "--moments",
        "2",
        "--night",
        "2024-06-21",
        "2024-12-21",
        "--latitudes",
        "-60,0",
        "--sun-altitude-deg",
        "-12,-30",
    ];
    let answer = json(&[STATISTICS, more]);
    let rows = answer["statistics"].as_array().unwrap();
    // At 60° south, the Sun stays above -12° in December, and above -30° throughout summer.
    assert!(rows.len() > 16 && rows.len() < 32, "{}", rows.len());
    let row = |latitude: f64, month: &str, sun: f64| {
        rows.iter().find(|row| {
            row["latitude_deg"].as_f64() == Some(latitude)
                && row["utc"].as_str().unwrap().contains(month)
                && row["sun_altitude_deg"].as_f64() == Some(sun)
        })
    };
    assert!(row(-60.0, "-12-", -12.0).is_none() && row(0.0, "-12-", -12.0).is_some());
    let text = done(&[STATISTICS, more, &["--format", "csv"]]);
    assert_eq!(records(&text).len() - 1, rows.len());
}

#[test]
fn bad_input_is_one_line() {
    let statistics: [(&[&str], &str); 6] = [
        (&[], "--night"),
        (&["--night", "x"], "'x' for '--night <DATE>...': not a night"),
        (&["--night", "2024-06-21", "--moments", "0"], "1 to 10000"),
        (&["--night", "2024-06-21", "--min-altitude", "95"], "0 to 89 deg"),
        (&["--night", "2024-06-21", "--latitudes", "95"], "-90 to 90 deg"),
        (&["--night", "2024-06-21", "--fov", "3"], "without a unit"),
    ];
    let reproduce: [(&[&str], &str); 8] = [
        (&["hu2022"], "--schedule"),
        (&["hu2022", "--schedule", "nowhere.db"], "nowhere.db"),
        (&["lu2024b", "--schedule", "a.db"], "--schedule has no effect on reproduce lu2024b"),
        (&["bassa2022", "--time-scale", "utc"], "--time-scale has no effect on reproduce bassa2022"),
        (&["borlaff2026"], "missing satellites; specify --elements FILE"),
        (&["borlaff2026", "--elements", "nowhere.tle"], "nowhere.tle"),
        (&["borlaff2026", "--elements", "a.tle", "--nights", "3"], "--nights has no effect on reproduce borlaff2026"),
        (&["smith1999"], "hu2022, lu2024, lu2024b, borlaff2026, bassa2022"),
    ];
    let cases = statistics.iter().map(|case| (STATISTICS, case));
    for (verb, (arguments, part)) in cases.chain(reproduce.iter().map(|case| (&["reproduce"][..], case))) {
        let (code, stdout, stderr) = run(&[verb, arguments]);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(stdout.is_empty() && stderr.lines().count() == 1 && stderr.contains(part), "{arguments:?}: {stderr}");
    }
}

#[test]
fn valid_visits_of_the_baseline_against_hu_2022() {
    let Some(data) = crate::common::data_dir() else { return };
    let schedule = data.join("schedules").join("baseline_10klines_2.0.db").display().to_string();
    let answer = json(&[&["reproduce", "hu2022", "--schedule", &schedule, "--time-scale", "utc", "-q"]]);
    let rows = answer["reproduced"].as_array().unwrap();
    assert_eq!(rows.len(), 6);
    for row in rows {
        println!("{}: {} published, {} computed", row["quantity"], row["published"], row["ours"]);
        // A year is compared with thirteen nights in its October (docs/explanation/counts.md). For the same nights,
        // the difference from the visits of the paper is below 20 %.
        let is_year = row["quantity"].as_str().unwrap().contains("of a year");
        let allowed = if is_year { 25.0 } else { 20.0 };
        assert!(row["difference_percent"].as_f64().unwrap().abs() < allowed, "{row}");
        assert!(row["reason"].as_str().unwrap().contains(if is_year { "season" } else { "other visits" }), "{row}");
    }
}

/// The result for another schedule states that the schedule differs.
#[test]
fn a_schedule_of_other_nights_gives_a_note() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = folder.path().join("other.csv").display().to_string();
    std::fs::write(&schedule, "exposure_id,start_utc,duration_s,ra_deg,dec_deg\na,2025-06-01T00:00:00Z,30,200,-30\n")
        .unwrap();
    let (code, stdout, stderr) = run(&[&["reproduce", "hu2022", "--schedule", &schedule, "--format", "json"]]);
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stderr.contains("1 visit from 2025-06-01T00:00:00Z")
            && stderr.contains("is not that of the first 10,000 of the paper")
    );
    let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(answer["reproduced"].as_array().unwrap().len(), 3);
}

/// Warnings of all nights are printed, the first and the last of those that differ only in numbers, and the number of
/// the others.
#[test]
fn every_night_has_its_warnings() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/data/elements/sample.2le");
    let base: &[&str] = &["statistics", "--elements", file, "--mpc", "X05", "--moments", "1", "--sun-altitude-deg=-18"];
    let of_nights = |nights: &[&str]| run(&[base, &["--night"], nights]).2;
    let days = |stderr: &str| stderr.matches("more than 14 days from the exposures").count();
    assert_eq!(of_nights(&["2026-03-20"]), "");
    // A limit for another band than that of the magnitudes, V, gives no counts.
    let stderr = run(&[base, &["--night", "2026-03-20", "--limit-mag", "g=7"]]).2;
    assert_eq!(stderr, "warning: limit_mag of the policy has no value for band V and no default\n");
    // Elements that are recent in the first night are old in the others.
    let stderr = of_nights(&["2026-03-20", "2026-04-20"]);
    assert_eq!((days(&stderr), stderr.lines().count()), (1, 1), "{stderr}");
    let stderr = of_nights(&["2026-03-20", "2026-04-20", "2026-04-21", "2026-04-22", "2026-04-23"]);
    assert_eq!((days(&stderr), stderr.lines().count()), (2, 3), "{stderr}");
    assert!(stderr.contains("not printed: 2 warnings that differ from these in numbers"), "{stderr}");
}
