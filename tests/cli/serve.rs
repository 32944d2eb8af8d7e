//! `serve`: results and warnings equal those of the command line.

use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::sync::OnceLock;

use crate::common::cli::{json as command, run};
use crate::common::server::{RULES, SHARED, Server, parse, serve, shared};
use serde_json::{Value, json};

/// First exposure of the example schedule, with its pointing.
const FIRST: &str = "start_utc=2026-08-14T23:29:05Z&duration_s=30&ra_deg=198.9&dec_deg=7.7";

/// Returns the result of `flag` without the columns start, length, pointing and band, which the API has in `exposures`.
fn flags_of_the_command_line() -> &'static Value {
    static FLAGS: OnceLock<Value> = OnceLock::new();
    FLAGS.get_or_init(|| {
        let mut response = command(&[&["flag"], SHARED, RULES, &["--telescope", "rubin"]]);
        for flag in response["flags"].as_array_mut().unwrap() {
            let flag = flag.as_object_mut().unwrap();
            for name in ["start_utc", "duration_s", "ra_deg", "dec_deg", "band"] {
                flag.remove(name).unwrap();
            }
        }
        response
    })
}

#[test]
fn the_night_equals_flag() {
    let server = shared();
    let night = server.json("/api/v1/night");
    let flags = flags_of_the_command_line();
    assert_eq!(night["flags"], flags["flags"]);
    assert_eq!(night["flags"].as_array().unwrap().len(), 21);
    assert_eq!(night["nights"], json!([{"night": "2026-08-14", "exposures": 21}]));
    assert_eq!(night["exposures"][0]["start_utc"], "2026-08-14T23:29:05.000000Z");
    for statement in ["version", "shells", "site", "models", "earth_orientation", "band"] {
        assert_eq!(night["provenance"][statement], flags["provenance"][statement], "{statement}");
    }
    // The Sun is above the horizon at both ends of the night, and below it in between.
    let sun: Vec<f64> =
        night["sun"].as_array().unwrap().iter().map(|one| one["sun_altitude_deg"].as_f64().unwrap()).collect();
    assert!(sun[0] > 30.0 && sun[sun.len() - 1] > 30.0 && sun.iter().copied().fold(90.0, f64::min) < -40.0, "{sun:?}");
    // A night can be chosen by its date or by a time in it, and need not be in the schedule.
    assert_eq!(server.json("/api/v1/night?time_utc=2026-08-15T09:00:00Z")["flags"], night["flags"]);
    let next = server.json("/api/v1/night?night=2026-08-15");
    assert_eq!((&next["night"], &next["nights"]), (&json!("2026-08-15"), &night["nights"]));
    assert_eq!((&next["exposures"], &next["flags"]), (&json!([]), &json!([])));
    let problem = server.get("/api/v1/night?night=2026-08-15&time_utc=2026-08-15T09:00:00Z");
    assert_eq!((problem.status, problem.json()["parameter"].as_str()), (400, Some("night")));
}

#[test]
fn verdicts_of_a_night_with_another_limit_equal_flag() {
    let server = shared();
    let mut verdicts = BTreeSet::new();
    for limit in ["5", "7", "9"] {
        let night = server.json(&format!("/api/v1/night?limit_mag={limit}"));
        let schedule = ["--schedule", "examples/night.csv", "--limit-mag", limit];
        let flags = command(&[&["flag"], SHARED, &schedule, &["--telescope", "rubin"]]);
        let (flags, of_night) = (flags["flags"].as_array().unwrap(), night["flags"].as_array().unwrap());
        assert_eq!(night["limit_mag"], json!(limit.parse::<f64>().unwrap()));
        assert_eq!(flags.len(), of_night.len());
        for (flag, one) in flags.iter().zip(of_night) {
            for (name, value) in one.as_object().unwrap() {
                assert_eq!(value, &flag[name], "limit {limit}: {name} of {flag}");
            }
        }
        verdicts.insert(flags.iter().map(|flag| flag["verdict"].to_string()).collect::<String>());
    }
    assert_eq!(verdicts.len(), 3, "the limits give the same verdicts: {verdicts:?}");
}

#[test]
fn an_exposure_is_avoided_if_one_of_its_crossings_exceeds_the_limit() {
    let server = shared();
    let mut counts = [0; 2];
    for row in server.json("/api/v1/night")["exposures"].as_array().unwrap() {
        let [start, ra, dec, band] = ["start_utc", "ra_deg", "dec_deg", "band"].map(|name| &row[name]);
        let (start, band) = (start.as_str().unwrap(), band.as_str().unwrap());
        for limit in ["5", "6.6", "7"] {
            let answer = server.json(&format!(
                "/api/v1/exposure?start_utc={start}&duration_s=30&ra_deg={ra}&dec_deg={dec}&band={band}&limit_mag={limit}&around_s=0"
            ));
            let exceeding = answer["around"].as_array().unwrap().iter().any(|one| one["exceeds_limit"] == true);
            assert_eq!(answer["flags"][0]["verdict"] == "avoid", exceeding, "{start}, limit {limit}");
            counts[usize::from(exceeding)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 5), "{counts:?}");
}

#[test]
fn many_exposures_in_one_request_have_the_verdicts_of_single_ones() {
    let server = shared();
    let night = server.json("/api/v1/night");
    let rows = night["exposures"].as_array().unwrap();
    let cells = |row: &serde_json::Value| {
        let text = |name: &str| row[name].to_string().replace('"', "");
        ["start_utc", "duration_s", "ra_deg", "dec_deg", "rotation_deg", "band"].map(text)
    };
    let list: Vec<String> = rows.iter().map(|row| cells(row).join(",")).collect();
    let answer = server.json(&format!("/api/v1/exposures?limit_mag=6.6&exposures={}", list.join(";")));
    assert_eq!(answer["flags"].as_array().unwrap().len(), rows.len());
    assert_eq!(answer["exposures"].as_array().unwrap().len(), rows.len());
    let mut verdicts = BTreeSet::new();
    for (row, flag) in rows.iter().zip(answer["flags"].as_array().unwrap()) {
        let [start, duration_s, ra, dec, rotation, band] = cells(row);
        let single = server.json(&format!(
            "/api/v1/exposure?start_utc={start}&duration_s={duration_s}&ra_deg={ra}&dec_deg={dec}&rotation_deg={rotation}\
             &band={band}&limit_mag=6.6"
        ));
        for (name, value) in flag.as_object().unwrap().iter().filter(|(name, _)| *name != "exposure_id") {
            assert_eq!(value, &single["flags"][0][name], "{start}: {name}");
        }
        verdicts.insert(flag["verdict"].to_string());
    }
    assert!(verdicts.len() > 1, "{verdicts:?}");
    let one = "2026-08-14T23:29:05Z,30,198.9,7.7";
    for (list, words) in [
        (one.replace("30,", "0,"), "exposure 1: invalid duration_s '0'; allowed: 0.001 to 3600 s"),
        (one.replace("30,", "x,"), "exposure 1: invalid duration_s 'x'; allowed: 0.001 to 3600 s"),
        (
            format!("{one};{}", one.replace("30,", "4000,")),
            "exposure 2: invalid duration_s '4000'; allowed: 0.001 to 3600 s",
        ),
        (one.replace("198.9", "NaN"), "exposure 1: invalid ra_deg 'NaN'; allowed: 0 to 360 deg"),
        (one.replace("7.7", "97.7"), "exposure 1: invalid dec_deg '97.7'; allowed: -90 to 90 deg"),
        (one.replace('Z', ""), "exposure 1: invalid start_utc '2026-08-14T23:29:05'; allowed: UTC like"),
        (format!("{one},400"), "exposure 1: invalid rotation_deg '400'; allowed: -360 to 360 deg"),
        (
            format!("{one},0,r,5"),
            "exposure 1: invalid values '2026-08-14T23:29:05Z,30,198.9,7.7,0,r,5'; allowed: START",
        ),
        (format!("{one};{one},0,xx"), "exposure 2: invalid band 'xx'; allowed: "),
        (";".to_owned(), "1 to 250 exposures"),
        ([one; 251].join(";"), "251 exposures"),
    ] {
        let problem = server.get(&format!("/api/v1/exposures?exposures={list}"));
        assert_eq!((problem.status, problem.json()["parameter"].as_str()), (400, Some("exposures")), "{list}");
        assert!(problem.json()["detail"].as_str().unwrap().contains(words), "{}", problem.json());
    }
}

#[test]
fn a_target_by_name_or_as_text_equals_its_coordinates() {
    let server = shared();
    let at = "start_utc=2026-08-14T23:35:20Z&duration_s=30";
    let by_text = |target: &str| server.json(&format!("/api/v1/exposure?{at}&target={target}"));
    let by_name = by_text("M104");
    let [ra, dec] = ["ra_deg", "dec_deg"].map(|name| by_name["exposures"][0][name].to_string());
    assert_eq!(by_text("ngc%204594"), by_name);
    for (text, ra, dec) in [
        (format!("{ra}%20{dec}"), ra.as_str(), dec.as_str()),
        ("12h39m59.4s%20-11d37m23s".to_owned(), "189.9975", "-11.6230556"),
    ] {
        let by_degrees = server.json(&format!("/api/v1/exposure?{at}&ra_deg={ra}&dec_deg={dec}"));
        assert_eq!(by_text(&text)["exposures"], by_degrees["exposures"], "{text}");
        assert_eq!(by_text(&text)["flags"], by_degrees["flags"], "{text}");
    }
    for (query, parameter, words) in [
        ("target=M111", "target", "invalid target 'M111'; allowed: a Messier or Caldwell object"),
        ("target=M31&ra_deg=1", "target", "allowed: one of them"),
        ("ra_deg=1", "dec_deg", "ra_deg and dec_deg, or target"),
        ("", "ra_deg", "ra_deg and dec_deg, or target"),
    ] {
        let problem = server.get(&format!("/api/v1/exposure?{at}&{query}"));
        assert_eq!((problem.status, problem.json()["parameter"].as_str()), (400, Some(parameter)), "{query}");
        assert!(problem.json()["detail"].as_str().unwrap().contains(words), "{}", problem.json());
    }
}

/// The passes are those of `forecast`; the night is also found by a time in it, or by day before it.
#[test]
fn the_passes_of_a_night_equal_forecast() {
    let server = shared();
    let target = "/api/v1/forecast?max_mag=5&samples=5";
    let response = server.json(&format!("{target}&night=2026-08-14"));
    let satellites = ["--shells", "starlink-gen1", "--mpc", "X05", "--quiet"];
    let night = ["--night", "2026-08-14", "--max-mag", "5", "--samples", "5"];
    let forecast = command(&[&["forecast"], &satellites, &night]);
    for section in ["night", "passes", "left_out"] {
        let expected = if section == "night" { &forecast[section][0] } else { &forecast[section] };
        assert_eq!(&response[section], expected, "{section}");
    }
    let passes = response["passes"].as_array().unwrap();
    assert!(passes.len() > 3, "only {} passes", passes.len());
    let events: Vec<&str> = response["calendar"].as_str().unwrap().split("BEGIN:VEVENT").skip(1).collect();
    assert_eq!(events.len(), passes.len());
    for (event, pass) in events.iter().zip(passes) {
        assert!(event.contains(&format!("UID:{}-", pass["norad_id"])), "{event}");
    }
    for time in ["2026-08-14T20:00:00Z", "2026-08-15T04:00:00Z"] {
        assert_eq!(server.json(&format!("{target}&time_utc={time}"))["passes"], response["passes"], "{time}");
    }
    // In the morning, the next night follows.
    let next = server.json("/api/v1/forecast?max_mag=-5&time_utc=2026-08-15T13:00:00Z");
    assert_eq!((&next["date"], &next["passes"], &next["calendar"]), (&json!("2026-08-15"), &json!([]), &Value::Null));
    assert!(next["night"]["why_empty"].as_str().unwrap().contains("brighter than mag -5"), "{}", next["night"]);
    for (query, parameter) in [
        ("max_mag=5", "night"),
        ("night=2026-08-14", "max_mag"),
        ("max_mag=5&night=2026-08-14&time_utc=2026-08-14T20:00:00Z", "night"),
    ] {
        let problem = server.get(&format!("/api/v1/forecast?{query}"));
        assert_eq!((problem.status, problem.json()["parameter"].as_str()), (400, Some(parameter)), "{query}");
    }
}

/// Nights are named by the civil date of their evening, also beyond the date line, and a change of the clocks is
/// stated.
#[test]
fn nights_and_offsets_are_those_of_the_time_zone() {
    let site = |lat: &str, lon: &str, zone: &str| {
        let satellites = ["--shells", "starlink-gen1", "--fov", "1deg", "--quiet"];
        Server::start(&[&satellites[..], &["--lat", lat, "--lon", lon, "--time-zone", zone]].concat())
    };
    let tonga = site("-21.2", "-175.2", "Pacific/Tongatapu");
    let night = tonga.json("/api/v1/forecast?max_mag=-9&night=2026-08-22");
    assert_eq!(
        (&night["date"], &night["night"]["start_utc"]),
        (&json!("2026-08-22"), &json!("2026-08-21T23:40:48.000000Z"))
    );
    let same = tonga.json("/api/v1/forecast?max_mag=-9&time_utc=2026-08-22T09:00:00Z");
    assert_eq!((&same["date"], &same["night"]), (&night["date"], &night["night"]));
    // `night` names it in the same way, so that times typed into the page are those of this evening.
    for question in ["night=2026-08-22", "time_utc=2026-08-22T09:00:00Z"] {
        let of_page = tonga.json(&format!("/api/v1/night?{question}"));
        assert_eq!(
            (&of_page["night"], &of_page["from_utc"], &of_page["utc_offset_h"]),
            (&json!("2026-08-22"), &json!("2026-08-21T23:40:48Z"), &json!(13.0)),
            "{question}"
        );
    }
    let zurich = site("47.37", "8.54", "Europe/Zurich");
    for path in ["night?", "forecast?max_mag=-9&"] {
        let night = zurich.json(&format!("/api/v1/{path}night=2026-10-24"));
        let offsets: Vec<(&str, f64)> = night["utc_offsets"]
            .as_array()
            .unwrap()
            .iter()
            .map(|one| (one["from_utc"].as_str().unwrap(), one["utc_offset_h"].as_f64().unwrap()))
            .collect();
        assert_eq!((offsets.len(), offsets[0].1, offsets[1]), (2, 2.0, ("2026-10-25T01:00:00Z", 1.0)), "{path}");
    }
    let next = zurich.json("/api/v1/night?night=2026-10-25");
    assert_eq!(next["utc_offsets"].as_array().unwrap().len(), 1);
    // More points than are allowed are an error.
    let many = zurich.get("/api/v1/forecast?max_mag=30&night=2026-10-24&samples=500");
    assert!(many.status == 400 && many.json()["detail"].as_str().unwrap().contains("allowed: up to 200000 points"));
}

#[test]
fn a_server_without_a_schedule_judges_any_exposure() {
    let server = Server::start(&[SHARED, &["--limit-mag", "7"]].concat());
    let night = server.json("/api/v1/night");
    for name in ["nights", "exposures", "flags"] {
        assert_eq!(night[name], json!([]), "{name}");
    }
    // The night contains the start of the server; 47 Tucanae is always above the horizon of Rubin Observatory.
    let start = night["from_utc"].as_str().unwrap();
    assert_eq!(server.json(&format!("/api/v1/night?time_utc={start}"))["night"], night["night"]);
    assert!(night["provenance"]["schedule"].is_null());
    let answer = server.json(&format!("/api/v1/exposure?start_utc={start}&duration_s=30&target=NGC104"));
    assert_ne!(answer["flags"][0]["verdict"], "invalid", "{answer}");
    assert_eq!(server.json("/health")["exposures"], 0);
}

#[test]
fn every_exposure_equals_flag_and_passes() {
    let server = shared();
    let flags = flags_of_the_command_line();
    let night = server.json("/api/v1/night");
    let mut crossings = 0;
    for (row, flag) in night["exposures"].as_array().unwrap().iter().zip(flags["flags"].as_array().unwrap()) {
        let text = |name: &str| row[name].as_str().unwrap().to_owned();
        let (ra, dec, duration) =
            (row["ra_deg"].to_string(), row["dec_deg"].to_string(), row["duration_s"].to_string());
        let target = format!(
            "/api/v1/exposure?start_utc={}&duration_s={duration}&ra_deg={ra}&dec_deg={dec}&band={}&samples=5",
            text("start_utc"),
            text("band")
        );
        let response = server.json(&target);
        let mut expected = flag.clone();
        expected["exposure_id"] = json!("1");
        assert_eq!(response["flags"][0], expected, "{target}");
        // Simulated satellites are generated for 0h UTC of the date of the first exposure of the schedule.
        if !text("start_utc").starts_with("2026-08-14") {
            continue;
        }
        let (start, exposure) = (text("start_utc"), format!("{duration}s"));
        let one = ["--start", &start, "--exposure", &exposure, "--ra", &ra, &format!("--dec={dec}"), "--samples", "5"];
        let (code, stdout, stderr) =
            run(&[&["passes"], SHARED, &["--telescope", "rubin", "--limit-mag", "7", "--format", "json"], &one]);
        assert!(code < 2, "{stderr}");
        let passes: Value = serde_json::from_str(&stdout).unwrap();
        for section in ["exposures", "passes", "left_out"] {
            assert_eq!(response[section], passes[section], "{target}: {section}");
        }
        crossings += passes["passes"].as_array().unwrap().len();
    }
    assert!(crossings > 4, "only {crossings} crossings compared");
}

#[test]
fn other_starts_and_limits_equal_a_schedule_with_them() {
    let server = shared();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shifted.csv");
    let starts = ["23:29:10", "23:29:15.5", "23:29:24", "23:31:00"];
    let lines: String = starts.iter().map(|start| format!("a,2026-08-14T{start}Z,45,198.9,7.7\n")).collect();
    std::fs::write(&path, format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{lines}")).unwrap();
    let shown = path.display().to_string();
    let flags = command(&[&["flag"], SHARED, &["--telescope", "rubin", "--schedule", &shown, "--limit-mag", "6.62"]]);
    let mut verdicts = BTreeSet::new();
    for (start, flag) in starts.iter().zip(flags["flags"].as_array().unwrap()) {
        let target = format!(
            "/api/v1/exposure?start_utc=2026-08-14T{start}Z&duration_s=45&ra_deg=198.9&dec_deg=7.7&limit_mag=6.62"
        );
        let response = server.json(&target);
        for key in ["verdict", "n_streaks", "brightest_mag", "next_clear_start_utc", "delay_s", "reasons"] {
            assert_eq!(response["flags"][0][key], flag[key], "{target}: {key}");
        }
        verdicts.insert(flag["verdict"].as_str().unwrap().to_owned());
    }
    assert!(verdicts.len() > 1, "{verdicts:?}");
    // An exposure at the next clear start is clear.
    let first = server.json(&format!("/api/v1/exposure?{FIRST}"));
    let next = first["flags"][0]["next_clear_start_utc"].as_str().unwrap();
    let then = server.json(&format!("/api/v1/exposure?{}", FIRST.replace("2026-08-14T23:29:05Z", next)));
    assert_eq!(then["flags"][0]["verdict"], "clear");
}

#[test]
fn crossings_before_and_after_equal_those_of_a_longer_exposure() {
    let server = shared();
    let response = server.json(&format!("/api/v1/exposure?{FIRST}&around_s=120"));
    let passes = command(&[
        &["passes"],
        SHARED,
        &["--start", "2026-08-14T23:27:05Z", "--exposure", "270s", "--ra", "198.9", "--dec", "7.7"],
    ]);
    let (around, passes) = (response["around"].as_array().unwrap(), passes["passes"].as_array().unwrap());
    assert_eq!(around.len(), passes.len());
    assert!(
        around.len() > response["passes"].as_array().unwrap().len(),
        "the time around it is as empty as the exposure"
    );
    for (one, pass) in around.iter().zip(passes) {
        let enter_s = pass["chords"][0]["enter_s"].as_f64().unwrap() - 120.0;
        assert!((one["enter_s"].as_f64().unwrap() - enter_s).abs() < 2e-3, "{one} {pass}");
        assert_eq!((&one["norad_id"], &one["magnitude_peak"]), (&pass["norad_id"], &pass["magnitude_peak"]));
    }
}

/// Returns an element set that is two years old on the night of the schedule.
fn old(norad_id: u32, bstar_per_earth_radius: f64) -> String {
    let now =
        crate::common::elements::read(crate::common::elements::pair(norad_id, "226.52426840").as_bytes()).unwrap();
    let mut set = now.element_sets[0].clone();
    set.epoch -= hifitime::Unit::Day * 730;
    set.bstar_per_earth_radius = bstar_per_earth_radius;
    streakcast::elements::format_tle(&set).unwrap().map(|line| line + "\n").concat()
}

/// Starts a server with old elements: one valid set, one for which SGP4 fails soon, and one invalid record.
fn stale() -> (tempfile::TempDir, Server) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.tle").display().to_string();
    let broken = old(90003, 0.0).replacen("1 90003", "1 90x03", 1);
    std::fs::write(&path, old(90001, 0.0) + &old(90002, 0.05) + &broken).unwrap();
    let arguments = ["--elements", &path, "--mpc", "X05", "--fov", "3.5deg", "--quiet", "--utc-offset=-04:30"];
    let server = Server::start(&[&arguments, RULES].concat());
    (folder, server)
}

/// Returns a warning without its hint about command line flags.
fn without_hint(warning: &str) -> &str {
    warning.strip_suffix("; --verbose lists them").unwrap_or(warning)
}

#[test]
fn warnings_of_the_command_line_are_in_the_responses() {
    let (folder, server) = stale();
    let path = folder.path().join("old.tle").display().to_string();
    let (_, _, stderr) = run(&[&["flag", "--elements", &path, "--mpc", "X05", "--fov", "3.5deg"], RULES]);
    // The number of exposures that cannot be judged is not a warning of the responses, which have a verdict for each.
    let warned: Vec<Value> = stderr
        .lines()
        .filter_map(|line| line.strip_prefix("warning: "))
        .filter(|line| !line.contains("cannot be judged"))
        .map(without_hint)
        .map(Value::from)
        .collect();
    let night = server.json("/api/v1/night");
    assert_eq!(night["warnings"], json!(warned));
    assert_eq!((&night["left_out_count"], &night["utc_offset_h"]), (&json!(2), &json!(-4.5)));
    for flag in night["flags"].as_array().unwrap() {
        assert_eq!(
            (&flag["verdict"], &flag["p_any"], &flag["late_s"]),
            (&json!("unknown"), &json!(null), &json!(null))
        );
        let reason = flag["reasons"][0].as_str().unwrap();
        assert!(reason.starts_with("elements 73") && reason.ends_with(" days old: positions unknown"), "{reason}");
    }
    assert!(warned.iter().any(|one| one.as_str().unwrap().contains("element sets are more than 14 days")), "{stderr}");
    for (start, words) in [
        ("2026-08-14T23:29:05Z", "(the farthest by 730."),
        ("2030-08-14T00:10:00Z", "(the farthest by 2190."),
        ("1990-08-14T00:10:00Z", "element sets are more than 14 days"),
    ] {
        let response = server.json(&format!("/api/v1/exposure?{}", FIRST.replace("2026-08-14T23:29:05Z", start)));
        let warnings = response["warnings"].as_array().unwrap();
        let has = |words: &str| warnings.iter().any(|one| one.as_str().unwrap().contains(words));
        assert!(has(words) && has("rejected"), "{start}: {warnings:?}");
        let left_out = response["left_out"].as_array().unwrap().len();
        assert_eq!(
            (response["left_out_count"].as_u64(), has("too old to predict positions")),
            (Some(left_out as u64), left_out > 0),
            "{start}"
        );
    }
    // Responses without a verdict are errors: without satellites they would be taken as clear.
    for target in at_the_first_exposure() {
        let refused = server.get(&target);
        let detail = refused.json()["detail"].as_str().unwrap().to_owned();
        assert!(refused.status == 400 && detail.contains("days old: positions unknown"), "{target}: {detail}");
    }
    // Simulated satellites are generated for the day of the schedule; a request for another day has a warning.
    let response = shared().json(&format!("/api/v1/exposure?{}", FIRST.replace("2026", "2036")));
    assert!(
        response["warnings"].to_string().contains("the shells were generated for 2026-08-14"),
        "{}",
        response["warnings"]
    );
    let response = shared().json(&format!("/api/v1/exposure?{FIRST}"));
    assert_eq!(response["warnings"], shared().json("/api/v1/night")["warnings"]);
    assert_eq!(response["warnings"].as_array().unwrap().len(), 1);
    for target in at_the_first_exposure() {
        let same = shared().json(&target);
        assert_eq!((&same["warnings"], &same["left_out_count"]), (&response["warnings"], &json!(0)), "{target}");
    }
    let later = shared().json("/fov/satellites-above-horizon/?site=rubin&julian_date=2465000.5");
    assert!(
        later["warnings"].to_string().contains("the shells were generated for 2026-08-14"),
        "{}",
        later["warnings"]
    );
}

/// Returns other requests about satellites at the time of the first exposure.
fn at_the_first_exposure() -> [String; 4] {
    let field = "duration=30&ra=198.9&dec=7.7&fov_radius=1.75";
    let passes = format!("/fov/satellite-passes/?site=rubin&start_time_jd=2461267.4785300926&{field}");
    [
        "/api/v1/dome?start_utc=2026-08-14T23:29:05Z&duration_s=30".to_owned(),
        passes.clone(),
        format!("{passes}&group_by=satellite"),
        "/fov/satellites-above-horizon/?site=rubin&julian_date=2461267.4785300926".to_owned(),
    ]
}

#[test]
fn a_sky_that_cannot_be_computed_is_not_empty() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.tle").display().to_string();
    // Too old on the night of the schedule; the satellite has decayed years later.
    std::fs::write(&path, old(90001, 0.001)).unwrap();
    let server = Server::start(&[&["--elements", &path, "--mpc", "X05", "--fov", "3.5deg", "--quiet"], RULES].concat());
    let later = |target: &str| target.replace("2026-08-14", "2090-08-14").replace("2461267.", "2484643.");
    for exposure in [format!("/api/v1/exposure?{FIRST}"), later(&format!("/api/v1/exposure?{FIRST}"))] {
        let flag = &server.json(&exposure)["flags"][0];
        assert_eq!((&flag["verdict"], &flag["p_any"]), (&json!("unknown"), &json!(null)), "{flag}");
    }
    for target in at_the_first_exposure() {
        for target in [later(&target), target] {
            let refused = server.get(&target);
            assert_eq!(refused.status, 400);
            let words = refused.json()["detail"].as_str().unwrap().to_owned();
            assert!(words.contains("positions unknown"), "{words}");
        }
    }
}

#[test]
fn a_field_below_the_horizon_is_reported() {
    let server = shared();
    let response = server.json("/api/v1/exposure?start_utc=2026-08-14T23:29:05Z&duration_s=30&ra_deg=18.9&dec_deg=80");
    assert_eq!(response["flags"][0]["verdict"], "invalid");
    assert!(response["flags"][0]["reasons"][0].as_str().unwrap().contains("horizon"));
    assert_eq!((&response["passes"], &response["around"]), (&json!([]), &json!([])));
    assert!(response["pointing"][0]["altitude_deg"].as_f64().unwrap() < 0.0);
}

#[test]
fn the_dome_contains_the_crossings_of_the_field() {
    let server = shared();
    let dome = server.json("/api/v1/dome?start_utc=2026-08-14T23:29:05Z&duration_s=30&height_km=550");
    let exposure = server.json(&format!("/api/v1/exposure?{FIRST}"));
    let up = dome["satellites"].as_array().unwrap();
    assert!(up.len() > 50, "{} satellites up at dusk", up.len());
    for pass in exposure["passes"].as_array().unwrap() {
        let found = up.iter().find(|one| one["norad_id"] == pass["norad_id"]).expect("on the dome");
        // The middle of the pass is between the ends of the track.
        let altitudes: Vec<f64> =
            found["track_deg"].as_array().unwrap().iter().map(|place| place[1].as_f64().unwrap()).collect();
        let (low, high) =
            altitudes.iter().fold((90.0_f64, -90.0_f64), |(low, high), one| (low.min(*one), high.max(*one)));
        let altitude = pass["altitude_deg"].as_f64().unwrap();
        assert!((low - 2.0..=high + 2.0).contains(&altitude), "{altitude} {altitudes:?}");
    }
    // The map equals that of `map sky` for the same position of the Sun.
    let sun = (dome["sun"]["altitude_deg"].to_string(), dome["sun"]["azimuth_deg"].to_string());
    let map = command(&[
        &["map", "sky", "--model", "starlink-v1.5", "--height-km", "550", "--mpc", "X05", "--step-deg", "5", "--quiet"],
        &["--sun-altitude-deg", &sun.0, "--sun-azimuth-deg", &sun.1],
    ]);
    let table = map["directions"].as_array().unwrap();
    let served: Vec<&Value> =
        dome["map"]["magnitudes"].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap()).collect();
    assert_eq!(table.len(), served.len());
    for (printed, served) in table.iter().zip(served) {
        match (printed["magnitude"].as_f64(), served.as_f64()) {
            // Map, response and position of the Sun in the request are rounded.
            (Some(printed), Some(served)) => assert!((printed - served).abs() < 0.02, "{printed} {served}"),
            (printed, served) => assert_eq!(printed.is_some(), served.is_some(), "{printed:?} {served:?}"),
        }
    }
    let edge = dome["shadow_edge_deg"].as_array().unwrap();
    assert!(
        edge.iter().any(|place| place[1].as_f64().unwrap() > 0.0),
        "the Sun is low: the shadow has come up in the east"
    );
    assert_eq!(server.get("/api/v1/dome?start_utc=2026-08-14T23:29:05Z&duration_s=30&model=none").status, 400);
}

/// Keys of the example bodies in SatChecker's documentation (docs/source/fov.rst, 2026), used by clients.
const POSITION: &[&str] = &["altitude", "angle", "azimuth", "date_time", "dec", "julian_date", "ra", "tle_epoch"];
const ABOVE: &[&str] = &["altitude", "azimuth", "dec", "julian_date", "name", "norad_id", "ra", "range", "tle_epoch"];

#[test]
fn satchecker_shapes_carry_magnitudes() {
    let server = shared();
    // The time is 2026-08-14T23:29:05Z, and the site is that with MPC code X05.
    let site = server.json("/api/v1/night")["site"].clone();
    let place =
        format!("latitude={}&longitude={}&elevation={}", site["latitude_deg"], site["longitude_deg"], site["height_m"]);
    let query =
        format!("{place}&start_time_jd=2461267.4785300926&duration=30&ra=198.9&dec=7.7&fov_radius=1.75&async=false");
    let exposure = server.json(&format!("/api/v1/exposure?{FIRST}"));
    let grouped = server.json(&format!("/fov/satellite-passes/?{query}&illuminated_only=True&group_by=satellite"));
    let satellites = grouped["data"]["satellites"].as_object().unwrap();
    let passes = exposure["passes"].as_array().unwrap();
    assert_eq!(satellites.len(), passes.len());
    for pass in passes {
        let key = format!("{} ({})", pass["name"].as_str().unwrap(), pass["norad_id"]);
        let satellite = &satellites[&key];
        let positions = satellite["positions"].as_array().unwrap();
        for position in positions {
            assert!(POSITION.iter().all(|key| !position[key].is_null()), "{position}");
            let magnitude = position["apparent_magnitude"].as_f64().unwrap();
            assert!(magnitude >= pass["magnitude_peak"].as_f64().unwrap() - 1e-3, "{position} {pass}");
            assert!(position["angle"].as_f64().unwrap() <= 1.75 + 1e-4 && position["illuminated"] == true);
        }
        // There is at least one point per second from entry to exit.
        let jd: Vec<f64> = positions.iter().map(|one| one["julian_date"].as_f64().unwrap()).collect();
        assert!(jd.windows(2).all(|pair| (0.0..=1.05 / 86_400.0).contains(&(pair[1] - pair[0]))), "{jd:?}");
        let streak = &satellite["streaks"][0];
        assert_eq!(streak["enter_utc"].as_str().unwrap()[..22], pass["enter_utc"].as_str().unwrap()[..22]);
        assert_eq!(streak["magnitude_peak"], pass["magnitude_peak"]);
    }
    assert_eq!(grouped["data"]["total_satellites"], json!(passes.len()));
    // A field below the horizon has no satellites because none is visible, which a warning states.
    let warnings = |query: &str| server.json(&format!("/fov/satellite-passes/?{query}"))["warnings"].to_string();
    let below = query.replace("dec=7.7", "dec=88");
    assert!(warnings(&below).contains("the field is below the horizon"), "{}", warnings(&below));
    assert!(!warnings(&query).contains("horizon"), "{}", warnings(&query));
    let by_time =
        server.json(&format!("/fov/satellite-passes?{query}&illuminated_only=true&include_orbital_data=true"));
    let listed = by_time["data"].as_array().unwrap();
    assert_eq!(by_time["count"], grouped["data"]["total_position_results"]);
    let times: Vec<f64> = listed.iter().map(|one| one["julian_date"].as_f64().unwrap()).collect();
    assert!(
        times.is_sorted() && listed.iter().all(|one| one["norad_id"].is_number() && one["orbital_data"].is_object())
    );

    let above =
        server.json(&format!("/fov/satellites-above-horizon/?{place}&julian_date=2461267.4785300926&min_altitude=20"));
    let up = above["data"].as_array().unwrap();
    assert_eq!(above["count"], json!(up.len()));
    assert!(up.len() > 20 && up.iter().all(|one| ABOVE.iter().all(|key| !one[key].is_null())));
    assert!(up.iter().all(|one| one["altitude"].as_f64().unwrap() >= 20.0));
    assert!(up.iter().any(|one| one["apparent_magnitude"].is_number()));
    // For a named site, and for a site on the opposite side of the Earth.
    let named = server.json("/fov/satellites-above-horizon/?site=rubin&julian_date=2461267.4785300926&min_altitude=20");
    assert_eq!(named["count"], above["count"]);
    let elsewhere =
        "/fov/satellites-above-horizon/?latitude=40&longitude=120&elevation=0&julian_date=2461267.4785300926";
    let elsewhere = server.json(&format!("{elsewhere}&constellation=starlink&max_range=1500&illuminated_only=true"));
    let names = |response: &Value| -> BTreeSet<String> {
        response["data"].as_array().unwrap().iter().map(|one| one["norad_id"].to_string()).collect()
    };
    assert!(names(&elsewhere).is_disjoint(&names(&above)));
    assert!(elsewhere["data"].as_array().unwrap().iter().all(|one| one["range_km"].as_f64().unwrap() <= 1500.0));
    for (query, parameter) in [
        ("start_time_jd=2461267.4&duration=30&ra=1&dec=1&fov_radius=1", "site"),
        ("site=rubin&latitude=3&start_time_jd=2461267.4&duration=30&ra=1&dec=1&fov_radius=1", "site"),
        ("site=rubin&duration=30&ra=1&dec=1&fov_radius=1", "start_time_jd"),
        (
            "site=rubin&start_time_jd=2461267.4&mid_obs_time_jd=2461267.4&duration=30&ra=1&dec=1&fov_radius=1",
            "start_time_jd",
        ),
        ("site=rubin&start_time_jd=2461267.4&duration=30&ra=1&dec=1&fov_radius=1&async=true", "async"),
        ("site=rubin&start_time_jd=2461267.4&duration=30&ra=1&dec=91&fov_radius=1", "dec"),
    ] {
        let problem = server.get(&format!("/fov/satellite-passes/?{query}"));
        assert_eq!((problem.status, problem.json()["parameter"].as_str()), (400, Some(parameter)), "{query}");
    }
    let words = |target: &str| server.get(target).json()["detail"].as_str().unwrap().to_owned();
    let both = "site=rubin&start_time_jd=2461267.4&mid_obs_time_jd=2461267.4&duration=30&ra=1&dec=1&fov_radius=1";
    let both = words(&format!("/fov/satellite-passes/?{both}"));
    assert_eq!(both, "start_time_jd and mid_obs_time_jd are both given; allowed: one of them");
    let twice = words("/api/v1/night?night=2026-08-14&night=2026-08-14");
    assert_eq!(twice, "night is given more than once; allowed: once");
    let crowd = "site=rubin&start_time_jd=2461267.4785&duration=3600&ra=254&dec=-30&fov_radius=45";
    assert_eq!(server.get(&format!("/fov/satellite-passes/?{crowd}")).status, 400);
}

#[test]
fn openapi_describes_all_paths() {
    let server = shared();
    let document = server.json("/openapi.json");
    assert_eq!(document["openapi"], "3.1.0");
    for (path, operations) in document["paths"].as_object().unwrap() {
        assert_eq!(operations.as_object().unwrap().keys().collect::<Vec<_>>(), ["get"]);
        // Every path exists and accepts its documented parameters.
        let missing: Vec<&Value> = operations["get"]["parameters"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|parameter| parameter["required"] == true)
            .collect();
        let response = server.get(path);
        assert_eq!(response.status, if missing.is_empty() && !path.starts_with("/fov") { 200 } else { 400 }, "{path}");
        assert!(operations["get"]["responses"][response.status.to_string()].is_object(), "{path}");
        assert_eq!(server.send("POST", path, &[]).status, 405, "{path}");
    }
    let health = server.json("/health");
    assert_eq!(
        (&health["status"], &health["satellites"], &health["exposures"]),
        (&json!("ok"), &json!(4408), &json!(21))
    );
}

#[test]
fn a_stop_completes_open_requests() {
    for signal in ["-TERM", "-INT"] {
        let server = serve(&[]);
        // Half of a request is sent before the signal. The server completes the request, and then ends. An earlier
        // request fills the cache, because a stopped server waits at most 10 s.
        let target = format!("/api/v1/exposure?{FIRST}");
        server.json(&target);
        let mut stream = server.connect();
        let head = format!("GET {target} HTTP/1.1\r\nHost: localhost\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        assert_eq!(server.get("/health").status, 200);
        server.signal(signal);
        stream.write_all(b"\r\n").unwrap();
        let mut response = Vec::new();
        stream.read_to_end(&mut response).unwrap();
        let response = parse(&response);
        assert_eq!(response.status, 200, "{}", String::from_utf8_lossy(&response.body));
        assert_eq!(response.json()["flags"][0]["verdict"], "avoid");
        assert_eq!(server.stop("-0"), 0);
    }
}

/// A request is in progress when its client leaves: the server continues, and other requests have responses.
#[test]
fn clients_that_leave_do_not_occupy_the_server() {
    let server = serve(&[]);
    for limit in 0..20 {
        let mut stream = server.connect();
        let head = format!("GET /api/v1/night?limit_mag=5.{limit} HTTP/1.1\r\nHost: localhost\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
    }
    assert_eq!(server.get("/health").status, 200);
    server.json(&format!("/api/v1/exposure?{FIRST}"));
    assert_eq!(server.stop("-TERM"), 0);
}

/// Changed element files are loaded again; invalid ones are not used.
#[test]
fn changed_elements_are_used_without_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("elements.tle");
    let pair = |norad_id| crate::common::elements::pair(norad_id, "226.52426840");
    std::fs::write(&path, pair(90001)).unwrap();
    let arguments = ["--elements", path.to_str().unwrap(), "--mpc", "X05", "--fov", "3.5deg", "--quiet"];
    let server = Server::start(&[&arguments, RULES].concat());
    let satellites = || server.json("/health")["satellites"].as_u64().unwrap();
    let above = "/fov/satellites-above-horizon/?site=X05&julian_date=2461267.4";
    assert_eq!((satellites(), server.get(above).status), (1, 200));
    let becomes = |number: u64| {
        // The files are checked every two seconds. The bound is for a machine that does not progress at all.
        for _ in 0..1200 {
            if satellites() == number {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        panic!("still {} satellites, not {number}", satellites());
    };
    std::fs::write(&path, pair(90001) + &pair(90002)).unwrap();
    becomes(2);
    // A file that is cut off after a whole record has less than half of the satellites.
    std::fs::write(&path, pair(90001) + &pair(90002) + &pair(90003)).unwrap();
    becomes(3);
    std::fs::write(&path, pair(90001)).unwrap();
    std::thread::sleep(std::time::Duration::from_secs(5));
    assert_eq!(satellites(), 3);
    std::fs::write(&path, pair(90001) + &pair(90002)).unwrap();
    becomes(2);
    std::fs::write(&path, "no element sets\n").unwrap();
    // Long enough for two checks, in most cases; a failure of the reload must not be missed for ever.
    std::thread::sleep(std::time::Duration::from_secs(5));
    assert_eq!((satellites(), server.get(above).status), (2, 200));
    std::fs::write(&path, pair(90001) + &pair(90002) + &pair(90003)).unwrap();
    becomes(3);
}
