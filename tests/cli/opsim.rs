//! Rubin opsim databases on the command line: verdicts, annotation, unchanged cells.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::cli::{done, json, path, run};
use serde_json::Value;
use streakcast::schedule::{Schedule, ScheduleOptions};

fn dump(path: &Path) -> Vec<Vec<rusqlite::types::Value>> {
    let connection = rusqlite::Connection::open_with_flags(path, rusqlite::OpenFlags::SQLITE_OPEN_READ_ONLY).unwrap();
    let mut statement = connection.prepare("SELECT rowid, * FROM observations ORDER BY rowid").unwrap();
    let width = statement.column_count();
    let rows = statement.query_map([], |row| (0..width).map(|index| row.get(index)).collect::<Result<Vec<_>, _>>());
    rows.unwrap().collect::<Result<_, _>>().unwrap()
}

fn real() -> Option<(PathBuf, String)> {
    let data = crate::common::data_dir()?;
    let elements = data.join("tle/active/active_2024-08-14.txt").display().to_string();
    Some((data.join("schedules/opsim_prenight_2024-08-13_1.db"), elements))
}

/// Opsim databases have UTC in `observationStartMJD`.
#[test]
fn another_time_scale_of_opsim_gives_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "opsim.db");
    let database = rusqlite::Connection::open(&file).unwrap();
    database
        .execute_batch(
            "CREATE TABLE observations (observationId INTEGER, observationStartMJD REAL, visitExposureTime REAL, \
             fieldRA REAL, fieldDec REAL, rotSkyPos REAL); INSERT INTO observations VALUES (1, 61266.98, 30, 217, -30, 0);",
        )
        .unwrap();
    drop(database);
    let warnings = |scale: &str| {
        let sky = ["--shells", "oneweb", "--mpc", "X05", "--fov", "3.5deg"];
        let (code, _, stderr) = run(&[&["flag", "--schedule", &file, "--time-scale", scale], &sky]);
        assert_eq!(code, 0, "{stderr}");
        stderr
    };
    let warning = "warning: opsim databases have observationStartMJD in UTC, but it is read as TAI";
    assert!(warnings("tai").contains(warning), "{}", warnings("tai"));
    assert!(!warnings("utc").contains("opsim databases"), "{}", warnings("utc"));
}

#[test]
fn rubins_night_is_flagged() {
    let Some((schedule, elements)) = real() else { return };
    let schedule = schedule.display().to_string();
    let words = [
        "flag",
        "--elements",
        &elements,
        "--schedule",
        &schedule,
        "--time-scale",
        "utc",
        "--site",
        "Rubin Observatory",
        "--fov",
        "3.5deg",
        "--limit-mag",
        "7",
    ];
    let answer = json(&[&words, &["--quiet"]]);
    let flags = answer["flags"].as_array().unwrap();
    assert_eq!(flags.len(), 242);
    let count = |verdict: &str| flags.iter().filter(|flag| flag["verdict"] == verdict).count();
    // On a night in August with ten thousand satellites, most visits are clear, some are not, and all are above the
    // horizon.
    assert!(count("clear") > 150 && count("streaked") > 5 && count("avoid") > 5, "{} clear", count("clear"));
    assert_eq!(count("invalid"), 0);
    let (code, _, stderr) = run(&[&words[..5], &words[7..]]);
    assert_eq!(code, 2);
    assert!(stderr.contains("the time scale of column observationStartMJD is missing"), "{stderr}");
}

/// With a time error of 37 s, almost no visit of 30 s is crossed by the same satellite.
#[test]
fn tai_read_as_utc_finds_other_satellites() {
    let Some(data) = crate::common::data_dir() else { return };
    // A quarter of the visits of a survey.
    let folder = tempfile::tempdir().unwrap();
    let schedule = path(&folder, "survey.db");
    fs::copy(data.join("schedules/baseline_10klines_2.0.db"), &schedule).unwrap();
    let database = rusqlite::Connection::open(&schedule).unwrap();
    database.execute_batch("DELETE FROM observations WHERE rowid % 4 != 0").unwrap();
    drop(database);
    let elements = data.join("tle/active/starlink_2023-10-16.txt").display().to_string();
    let flags = |scale: &str| {
        let words = ["flag", "--elements", &elements, "--schedule", &schedule, "--time-scale", scale, "--mpc", "X05"];
        json(&[&words, &["--fov", "3.5deg", "--limit-mag", "7", "--quiet"]])["flags"].as_array().unwrap().clone()
    };
    let (right, wrong) = (flags("utc"), flags("tai"));
    assert_eq!(right.len(), 2_500);
    let pairs: Vec<(&Value, &Value)> = right.iter().zip(&wrong).filter(|(flag, _)| flag["n_streaks"] == 1).collect();
    let same = pairs.iter().filter(|(flag, wrong)| flag["norad_ids"] == wrong["norad_ids"]).count();
    assert!(pairs.len() > 30 && same * 10 < pairs.len(), "{same} of {}", pairs.len());
}

#[test]
fn a_next_clear_start_is_also_clear_of_improbable_crossings() {
    let Some((schedule, elements)) = real() else {
        eprintln!("SKIPPED: no data");
        return;
    };
    let flags_of = |schedule: &str| {
        let sky = ["--elements", &elements, "--mpc", "X05", "--time-scale", "utc", "--fov", "3.5deg", "--quiet"];
        json(&[&["flag", "--schedule", schedule, "--min-probability", "0.05"], &sky])["flags"].clone()
    };
    let copy = rusqlite::Connection::open(&schedule).unwrap();
    let mut statement =
        copy.prepare("SELECT visitExposureTime, fieldRA, fieldDec, rotSkyPos FROM observations").unwrap();
    let rows = statement.query_map([], |row| Ok([row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?]));
    let rows: Vec<[f64; 4]> = rows.unwrap().collect::<Result<_, _>>().unwrap();
    let mut later = "exposure_id,start_utc,duration_s,ra_deg,dec_deg,rotation_deg\n".to_owned();
    let mut waiting = 0;
    for (flag, [duration, ra, dec, rotation]) in
        flags_of(&schedule.display().to_string()).as_array().unwrap().iter().zip(rows)
    {
        let (Some(start), true) = (flag["next_clear_start_utc"].as_str(), flag["verdict"] != "clear") else {
            continue;
        };
        waiting += 1;
        later += &format!("{},{start},{duration},{ra},{dec},{rotation}\n", flag["exposure_id"]);
    }
    assert!(waiting > 10, "{waiting} wait");
    let folder = tempfile::tempdir().unwrap();
    fs::write(path(&folder, "later.csv"), later).unwrap();
    for flag in flags_of(&path(&folder, "later.csv")).as_array().unwrap() {
        assert_eq!(flag["verdict"], "clear", "{flag}");
    }
}

#[test]
fn rubins_night_is_annotated_and_keeps_all_cells() {
    let Some((schedule, elements)) = real() else { return };
    let folder = tempfile::tempdir().unwrap();
    let output = path(&folder, "annotated.db");
    let shown = schedule.display().to_string();
    done(&[&[
        "annotate",
        "--elements",
        &elements,
        "--schedule",
        &shown,
        "--time-scale",
        "utc",
        "--mpc",
        "X05",
        "--limit-mag",
        "7",
        "--telescope",
        "rubin",
        "-o",
        &output,
        "-q",
    ]]);
    assert_eq!(dump(&schedule), dump(Path::new(&output)));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let copy = rusqlite::Connection::open(&output).unwrap();
    let number = |query: &str| copy.query_row(query, [], |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!(number("SELECT count(*) FROM streak_flags JOIN observations ON exposure_id = observationId"), 242);
    assert_eq!(
        number("SELECT sum(n_streaks) FROM streak_flags"),
        number("SELECT count(*) FROM streaks JOIN observations ON exposure_id = observationId")
    );
    assert!(number("SELECT count(*) FROM streaks WHERE width_arcsec > 0.7 AND effective_magnitude > magnitude") > 20);
    assert!(number("SELECT count(*) FROM streak_provenance WHERE name = 'elements'") == 1);
}

/// The altitudes of a schedule show that it is of another site, also in other formats.
#[test]
fn altitudes_of_another_site_give_a_warning() {
    use hifitime::Epoch;
    use streakcast::geometry::{Observer, Site};
    use streakcast::{frames::EopTable, passes::Viewpoint, schedule::lowest_altitude_rad};
    let folder = tempfile::tempdir().unwrap();
    let [database, table, output] = ["a.db", "a.csv", "b.db"].map(|name| path(&folder, name));
    let rubin = Viewpoint::from(Observer::new(Site::from_mpc("X05").unwrap()));
    let rows: Vec<String> = (0..4)
        .map(|row| {
            let (mjd, ra_deg) = (61266.98 + 0.001 * f64::from(row), 217 + row);
            let exposure =
                streakcast::Exposure::new("2026-08-14T00:00:00Z", 30.0, &format!("{ra_deg}"), "-30").unwrap();
            let exposure = streakcast::Exposure { start: Epoch::from_mjd_utc(mjd), ..exposure };
            let altitude_deg = lowest_altitude_rad(&exposure, &rubin, &EopTable::embedded()).to_degrees();
            format!("{row}, {mjd}, 30.0, {ra_deg}, -30, 0, {:.2}", altitude_deg + 0.3)
        })
        .collect();
    let inserted: Vec<String> = rows.iter().map(|row| format!("({row})")).collect();
    rusqlite::Connection::open(&database)
        .unwrap()
        .execute_batch(&format!(
            "CREATE TABLE observations (observationId, observationStartMJD, visitExposureTime, fieldRA, fieldDec, \
             rotSkyPos, altitude); INSERT INTO observations VALUES {};",
            inserted.join(", ")
        ))
        .unwrap();
    let names = "exposure_id, start_mjd_utc, duration_s, ra_deg, dec_deg, rotation_deg, altitude_deg";
    fs::write(&table, format!("{names}\n{}\n", rows.join("\n")).replace(", ", ",")).unwrap();
    let sky = ["--shells", "oneweb", "--time-scale", "utc", "--fov", "3.5deg"];
    for (arguments, name) in
        [(&["annotate", "--schedule", &database, "-o", &output][..], "opsim"), (&["flag", "--schedule", &table], "CSV")]
    {
        for (site, is_other) in [("Rubin", false), ("Paranal", true), ("CTIO", false), ("Subaru", true)] {
            let (code, _, stderr) = run(&[arguments, &sky, &["--site", site]]);
            let warning = format!("the altitudes in the schedule differ from those at {site} by ");
            assert_eq!((code, stderr.contains(&warning)), (0, is_other), "{name} {site}: {stderr}");
            std::fs::remove_file(&output).ok();
        }
    }
}

/// The exposure time of a visit is the sum over its snaps, which are open for longer with the readout between them.
#[test]
fn visits_of_several_snaps_last_until_the_last_one() {
    let folder = tempfile::tempdir().unwrap();
    let durations = |name: &str, columns: &str, rows: &str| -> Vec<Result<f64, String>> {
        let file = folder.path().join(name);
        rusqlite::Connection::open(&file)
            .unwrap()
            .execute_batch(&format!(
                "CREATE TABLE observations (observationId, observationStartMJD, visitExposureTime, fieldRA, fieldDec, \
                 rotSkyPos{columns}); INSERT INTO observations VALUES {rows};"
            ))
            .unwrap();
        let options = ScheduleOptions { time_scale: Some(hifitime::TimeScale::UTC), ..ScheduleOptions::default() };
        let schedule = Schedule::read(&file, &options).unwrap();
        schedule.exposures.into_iter().map(|row| row.exposure.map(|exposure| exposure.duration_s)).collect()
    };
    let visit = "61266.98, 30.0, 217, -30, 0";
    let found = durations(
        "snaps.db",
        ", numExposures, visitTime",
        &format!("(1, {visit}, 2, 34.0), (2, {visit}, 1, 31.0), (3, {visit}, NULL, NULL), (4, {visit}, 2, 29.0)"),
    );
    assert_eq!(found[..3], [Ok(34.0), Ok(30.0), Ok(30.0)]);
    assert!(found[3].as_ref().unwrap_err().contains("visitTime is 29; allowed: 30 to"), "{found:?}");
    let found = durations("no_time.db", ", numExposures", &format!("(1, {visit}, 2), (2, {visit}, 1)"));
    assert!(found[0].as_ref().unwrap_err().contains("visitTime is missing"), "{found:?}");
    assert_eq!(found[1], Ok(30.0));
    assert_eq!(durations("nexp.db", ", nexp, visitTime", &format!("(1, {visit}, 2, 34.0)")), [Ok(34.0)]);
    // Without a number of snaps there may be several.
    let rows = format!("(1, {visit}, NULL, 34.0), (2, {visit}, 0, 34.0), (3, {visit}, NULL, 29.0)");
    assert_eq!(durations("unknown.db", ", numExposures, visitTime", &rows), [Ok(34.0), Ok(34.0), Ok(30.0)]);
    assert_eq!(durations("visit.db", ", visitTime", &format!("(1, {visit}, 34.0)")), [Ok(34.0)]);
    assert_eq!(durations("plain.db", "", &format!("(1, {visit})")), [Ok(30.0)]);
    // The cost is of the time with open shutter: a satellite brighter than the limit costs 30 s, and not 34 s.
    let schedule = folder.path().join("visit.db").display().to_string();
    let sky =
        ["--shells", "starlink-gen1", "--mpc", "X05", "--time-scale", "utc", "--fov", "20deg", "--telescope", "rubin"];
    let rules = ["--limit-mag", "40", "--bright-share", "1", "-q"];
    let answer = json(&[&["flag", "--schedule", &schedule], &sky, &rules]);
    assert_eq!(answer["flags"][0]["streak_cost_s"], 30.0);
    let output = folder.path().join("out.db").display().to_string();
    done(&[&["annotate", "--schedule", &schedule, "-o", &output], &sky, &rules]);
    let query = "SELECT max(streak_cost_s) FROM streaks";
    let most_s: f64 = rusqlite::Connection::open(&output).unwrap().query_row(query, [], |row| row.get(0)).unwrap();
    assert!((29.0..=30.0).contains(&most_s), "{most_s} s");
}
