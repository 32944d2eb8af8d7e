//! `gate`: exit codes, standard input and status file; reading of a mount; errors that must not stop a night.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use crate::common::cli::{json, path, run};
use serde_json::Value;
use tempfile::TempDir;

/// At dusk over Rubin Observatory, a simulated Starlink satellite crosses a field of 8 deg about every minute.
const GATE: &[&str] = &["gate", "--shells", "starlink-gen1", "--mpc", "X05", "--fov", "8deg", "--exposure", "10s"];
const POINTING: &[&str] = &["--ra", "217.5", "--dec=-30"];
const LIMIT: &[&str] = &["--limit-mag", "7", "--max-wait", "10min"];
/// Time of the simulated runs.
const NOW: &str = "2024-08-14T23:30:00.000Z";
/// The same evening in the year of the invented satellite, whose elements are half a day old.
const ELEMENTS_NOW: &str = "2026-08-14T23:30:00.000Z";
/// Time limit that only stops a blocked run.
const LONG: &str = "600s";
/// Time limit of runs in which standard input or a server does not answer, which takes half of it.
const SHORT: &str = "10s";

#[track_caller]
fn gate(folder: &TempDir, more: &[&str]) -> (i32, String, Value) {
    let status = path(folder, "status.json");
    let (code, stdout, stderr) = run(&[GATE, more, &["--status-file", &status]]);
    assert_eq!(stdout, "", "unexpected output");
    let text = fs::read_to_string(status).unwrap_or_else(|_| "null".to_owned());
    (code, stderr, serde_json::from_str(&text).unwrap())
}

/// Runs the gate with the given standard input, as Ekos does.
fn ekos(folder: &TempDir, input: &[u8], close: bool, more: &[&str]) -> (i32, Value) {
    let status = path(folder, "status.json");
    let is_complete = close || serde_json::from_slice::<Value>(input).is_ok();
    let timeout = if is_complete { LONG } else { SHORT };
    let arguments = [GATE, &["--stdin", "ekos", "--status-file", &status, "--timeout", timeout], more].concat();
    let mut child = Command::new(env!("CARGO_BIN_EXE_streakcast"))
        .env("STREAKCAST_NO_HOME", "1")
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut pipe = child.stdin.take().unwrap();
    pipe.write_all(input).unwrap();
    pipe.flush().unwrap();
    let kept = (!close).then_some(pipe);
    let code = child.wait().unwrap().code().unwrap();
    drop(kept);
    (code, serde_json::from_str(&fs::read_to_string(status).unwrap()).unwrap())
}

fn utc_seconds(text: &str) -> f64 {
    let epoch = streakcast::frames::parse_instant(text, None).unwrap();
    epoch.to_unix_seconds()
}

/// With a telescope and no limit the start has the least sum of wait and cost, and `flag` computes the same cost.
#[test]
fn a_telescope_chooses_the_start_by_cost_and_flag_agrees() {
    let folder = tempfile::tempdir().unwrap();
    let cost_of = |start: &str, duration_s: f64, share: &str| {
        let schedule = path(&folder, "s.csv");
        let row = format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n1,{start},{duration_s},217.5,-30\n");
        fs::write(&schedule, row).unwrap();
        let flag = ["flag", "--schedule", &schedule, "--shells", "starlink-gen1", "--mpc", "X05", "--fov", "8deg"];
        let flags = json(&[&flag, &["--telescope", "rubin", "--bright-share", share]]);
        flags["flags"][0]["streak_cost_s"].as_f64().unwrap()
    };
    let cost_at = |start: &str, share: &str| cost_of(start, 10.0, share);
    // The upper limit for openings within the margin, 2 s: the share of the exposure that an exposure of 12 s loses.
    let limit_at = |start: &str, share: &str| cost_of(start, 12.0, share) * 10.0 / 12.0;
    let (mut waited, mut at_once, mut differing) = (0_u64, 0_u64, 0);
    for share in ["0.08", "3"] {
        for minute in [30, 45] {
            let now = format!("2024-08-14T23:{minute}:00.000Z");
            let by_cost: &[&str] =
                &["--telescope", "rubin", "--bright-share", share, "--max-wait", "1min", "--now", &now];
            let (code, stderr, status) = gate(&folder, &[POINTING, by_cost].concat());
            assert_eq!((code, status["verdict"].as_str()), (0, Some("start")), "{stderr}");
            assert_eq!(status["blocking"], "cost");
            let number = |key: &str| status[key].as_f64().unwrap();
            let (cost_s, wait_s, now_s) = (number("streak_cost_s"), number("waited_s"), number("scheduled_cost_s"));
            let start = status["start_utc"].as_str().unwrap();
            assert!(cost_s + wait_s <= now_s + 1e-3, "{stderr}");
            let utc = |text: &str| streakcast::frames::parse_instant(text, None).unwrap();
            let later = |start: &str, later_s: f64| {
                streakcast::output::format_utc(streakcast::frames::seconds_after(utc(start), later_s), 3)
            };
            assert_eq!(status["cost_until_utc"].as_str(), Some(later(start, 2.0).as_str()));
            assert!(
                (limit_at(&now, share) - now_s).abs() < 2e-3 && (limit_at(start, share) - cost_s).abs() < 0.05,
                "{stderr}"
            );
            for opening_s in [0.0, 0.3, 0.9, 1.5, 2.0] {
                assert!(cost_at(&later(&now, opening_s), share) <= now_s + 2e-3, "{now} + {opening_s} s");
            }
            // No other start is better by more than the interval between the starts that are compared.
            for tenth in 1..=9 {
                let later_s = 0.1 * f64::from(tenth) * now_s.min(60.0);
                let later = later(&now, later_s);
                differing += u32::from(limit_at(&later, share) > cost_at(&later, share) + 0.1);
                assert!(limit_at(&later, share) + later_s > cost_s + wait_s - now_s / 60.0 - 0.01, "{later}");
            }
            waited += u64::from(wait_s > 0.0);
            at_once += u64::from(wait_s == 0.0);
            let count = |name: &str| status["counters"][name].as_u64();
            assert_eq!([count("clear"), count("started"), count("waited")].map(Option::unwrap), [0, at_once, waited]);
        }
    }
    assert!(waited > 0 && differing > 0, "no wait is worth its time, or the margin has no effect");
    // With the largest cost of a policy the exposure starts when its cost is small enough, or is not clear.
    let policy = path(&folder, "policy.toml");
    let now = "2024-08-14T23:45:00.000Z";
    let free_s = limit_at(now, "0.08");
    assert!(free_s > 0.2, "{free_s} s");
    for (most_s, longest, verdict) in [(0.5 * free_s, "1min", "start"), (0.01 * free_s, "1s", "not_clear")] {
        fs::write(&policy, format!("max_cost_s = {most_s}")).unwrap();
        let more: &[&str] = &["--telescope", "rubin", "--policy", &policy, "--max-wait", longest, "--now", now];
        let (code, stderr, status) = gate(&folder, &[POINTING, more].concat());
        assert_eq!((code, status["verdict"].as_str()), (0, Some(verdict)), "{stderr}");
        assert_eq!(status["streak_cost_s"].as_f64().is_some_and(|cost_s| cost_s <= most_s), verdict == "start");
        // Only a start that is used is stated.
        for key in ["streak_cost_s", "start_utc", "waited_s"] {
            assert_eq!(status.get(key).is_some(), verdict == "start", "{status}");
        }
        assert!((status["scheduled_cost_s"].as_f64().unwrap() - free_s).abs() < 2e-3, "{status}");
        let costs = format!("no clear start within 1 s at which streaks cost at most {most_s} s; ");
        assert_eq!(stderr.contains(&costs), verdict == "not_clear", "{stderr}");
        // A start that exceeds neither a limit nor the cost. All satellites are fainter than this limit.
        fs::write(&policy, format!("max_cost_s = {most_s}\nlimit_mag = -5")).unwrap();
        let (_, stderr, status) = gate(&folder, &[POINTING, more].concat());
        assert_eq!(status["verdict"] == "clear", verdict == "start", "{stderr}");
        assert!(stderr.contains(&format!("streaks cost at most {most_s} s")), "{stderr}");
        assert_eq!(status.get("clear_until_utc").is_some(), verdict == "start", "{stderr}");
        if verdict == "start" {
            assert!(cost_at(status["clear_until_utc"].as_str().unwrap(), "0.08") <= most_s + 2e-3, "{stderr}");
            let start = status["start_utc"].as_str().unwrap();
            assert!(status["waited_s"].as_f64().unwrap() > 0.0 && cost_at(start, "0.08") <= most_s + 2e-3, "{stderr}");
        }
    }
    // A limit or `any` selects the satellites that block, as without a telescope.
    for more in [&["--limit-mag", "7"][..], &["--blocking", "any"]] {
        let (_, stderr, status) = gate(&folder, &[POINTING, &["--telescope", "rubin", "--now", NOW], more].concat());
        assert!(["clear", "not_clear"].contains(&status["verdict"].as_str().unwrap()), "{stderr}");
    }
    let below = ["--ra", "217.5", "--dec=80", "--telescope", "rubin", "--now", NOW];
    assert_eq!(gate(&folder, &below).2["fault"], "target");
}

/// A limit of surface brightness that all streaks exceed is that of all lit satellites; one that none exceeds is none.
#[test]
fn a_limit_of_surface_brightness_decides() {
    let folder = tempfile::tempdir().unwrap();
    let mut waits = 0;
    for minute in [30, 33, 36, 39] {
        let now = format!("2024-08-14T23:{minute}:00.000Z");
        let wait = |more: &[&str]| {
            let shared = ["--telescope", "rubin", "--max-wait", "10min", "--now", &now];
            let (code, stderr, status) = gate(&folder, &[POINTING, &shared, more].concat());
            assert_eq!((code, status["verdict"].as_str()), (0, Some("clear")), "{stderr}");
            (status["waited_s"].as_f64().unwrap(), status["limit_surface_brightness"].clone())
        };
        let (of_all_s, _) = wait(&["--blocking", "any"]);
        assert_eq!(wait(&["--limit-surface-brightness", "50"]), (of_all_s, 50.0.into()));
        assert_eq!(wait(&["--limit-surface-brightness", "5"]), (0.0, 5.0.into()));
        waits += usize::from(of_all_s > 0.0);
    }
    assert!(waits > 0);
    let (code, stderr, _) = gate(&folder, &[POINTING, &["--limit-surface-brightness", "22", "--now", NOW]].concat());
    assert!(code == 0 && stderr.contains("missing telescope for limit-surface-brightness"), "{code} {stderr}");
}

/// By daylight the line states the Sun; by night it does not.
#[test]
fn daylight_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    for (now, is_light) in [("2024-08-14T19:00:00.000Z", true), (NOW, false)] {
        let (code, stderr, status) = gate(&folder, &[&["--ra", "150", "--dec=-30"], LIMIT, &["--now", now]].concat());
        let sun_deg = status["sun_altitude_deg"].as_f64().unwrap();
        assert_eq!((code, sun_deg > -6.0), (0, is_light), "{stderr}");
        assert_eq!(stderr.contains(&format!("; it is not dark: the Sun is at {sun_deg:.1} deg")), is_light, "{stderr}");
        assert_eq!(status["message"].as_str().unwrap().contains("not dark"), is_light, "{status}");
    }
}

#[test]
fn waits_until_the_exposure_starts_clear_and_passes_agrees() {
    let folder = tempfile::tempdir().unwrap();
    let mut waited = 0;
    for minute in [30, 33, 36, 39] {
        let now = format!("2024-08-14T23:{minute}:00.000Z");
        let (code, stderr, status) = gate(&folder, &[POINTING, LIMIT, &["--now", &now]].concat());
        assert_eq!((code, status["verdict"].as_str()), (0, Some("clear")), "{stderr}");
        let start = status["start_utc"].as_str().unwrap();
        let wait_s = status["waited_s"].as_f64().unwrap();
        assert!((utc_seconds(start) - utc_seconds(&now) - wait_s).abs() < 2e-3, "{status}");
        waited += u32::from(wait_s > 0.0);
        let brighter = |start: &str, exposure: &str| {
            let passes =
                ["passes", "--shells", "starlink-gen1", "--mpc", "X05", "--fov", "8deg", "--limit-mag", "7", "--quiet"];
            let (code, stdout, _) =
                run(&[&passes, POINTING, &["--start", start, "--exposure", exposure, "--format", "json"]]);
            assert!(code < 2);
            let answer: Value = serde_json::from_str(&stdout).unwrap();
            let rows = answer["passes"].as_array().unwrap().clone();
            rows.iter().filter(|row| row["p_brighter"].as_f64().is_some_and(|brighter| brighter >= 0.5)).count()
        };
        assert_eq!(brighter(start, "10s"), 0, "{status}");
        // The shutter may open later by the margin.
        let late = streakcast::frames::parse_instant(start, None).unwrap() + 2.0 * hifitime::Unit::Second;
        assert_eq!(brighter(&streakcast::output::format_utc(late, 3), "10s"), 0, "{status}");
        if wait_s > 0.0 {
            // The blocking satellite is in the field now or within the margins.
            let early = streakcast::frames::parse_instant(&now, None).unwrap() - 2.0 * hifitime::Unit::Second;
            assert!(brighter(&streakcast::output::format_utc(early, 3), "14s") > 0, "{status}");
            assert!(status["n_dodged"].as_u64().unwrap() > 0);
        }
    }
    assert!(waited > 0, "all of them were clear: the test has seen no wait");
}

/// The gate waits as long as `flag` states: until no limit is exceeded, or with `--blocking any` until no lit satellite
/// crosses.
#[test]
fn waits_are_those_of_flag() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = path(&folder, "schedule.csv");
    let starts: Vec<String> = (40..60).map(|minute| format!("2024-08-14T23:{minute}:00.000Z")).collect();
    let rows: String = starts.iter().map(|start| format!("{start},{start},10,217.5,-30\n")).collect();
    fs::write(&schedule, format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{rows}")).unwrap();
    let flag = ["flag", "--shells", "starlink-gen1", "--mpc", "X05", "--fov", "8deg", "--limit-mag", "5.49", "--quiet"];
    let (code, stdout, stderr) = run(&[&flag, &["--schedule", &schedule, "--format", "json"]]);
    assert_eq!(code, 0, "{stderr}");
    let flags: Value = serde_json::from_str(&stdout).unwrap();
    let flags = flags["flags"].as_array().unwrap();
    // An exposure with different waits, and one that is avoided.
    let differ = |flag: &&Value| flag["acceptable_delay_s"] != flag["delay_s"];
    let is_avoided = |flag: &&Value| flag["verdict"] == "avoid" && flag["acceptable_delay_s"].is_number();
    let chosen = [flags.iter().find(differ).expect("different waits"), flags.iter().find(is_avoided).expect("avoided")];
    for flag in chosen {
        let now = flag["exposure_id"].as_str().unwrap();
        for (blocking, column) in [("avoid", "acceptable_delay_s"), ("any", "delay_s")] {
            let limit = ["--limit-mag", "5.49", "--max-wait", "10min", "--margin", "0s", "--blocking", blocking];
            let (_, stderr, status) = gate(&folder, &[POINTING, &limit, &["--now", now]].concat());
            assert_eq!(status["blocking"], blocking);
            match flag[column].as_f64() {
                // `flag` has an additional guard of 1 ms, and both are rounded to 1 ms.
                Some(delay_s) => {
                    assert!((status["waited_s"].as_f64().unwrap() - delay_s).abs() < 0.0031, "{stderr} {flag}")
                }
                None => assert_eq!(status["verdict"], "not_clear", "{flag}"),
            }
        }
    }
}

#[test]
fn exit_codes_and_counters_are_as_documented() {
    let folder = tempfile::tempdir().unwrap();
    // In a field of 60 deg there are always lit satellites.
    let never: &[&str] = &["--fov", "60deg", "--max-wait", "20s", "--now", NOW];
    let never: Vec<&str> =
        GATE[1..5].iter().chain(&["--exposure", "60s"]).chain(POINTING).chain(never).copied().collect();
    let status = path(&folder, "status.json");
    let run_never = |strict: &[&str]| run(&[&["gate"], &never, strict, &["--status-file", &status]]);
    let (code, _, stderr) = run_never(&[]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("warning: gate: no clear start within 20 s"), "{stderr}");
    assert!(stderr.contains("the exposure starts and will be streaked"), "{stderr}");
    let (code, _, stderr) = run_never(&["--strict"]);
    assert!(code == 1 && stderr.contains("no clear start") && !stderr.contains("the exposure starts"), "{stderr}");
    let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
    assert_eq!((record["verdict"].as_str(), record["exit_code"].as_i64()), (Some("not_clear"), Some(1)));
    assert_eq!((record["counters"]["runs"].as_i64(), record["counters"]["not_clear"].as_i64()), (Some(2), Some(2)));
    // No satellite is brighter than magnitude -20, so the field is clear at once.
    let (code, stderr, record) = gate(&folder, &[POINTING, &["--limit-mag=-20", "--now", NOW]].concat());
    assert_eq!(
        (code, record["verdict"].as_str(), record["waited_s"].as_f64()),
        (0, Some("clear"), Some(0.0)),
        "{stderr}"
    );
    assert_eq!(record["counters"]["clear"], 1);
    assert!(stderr.contains("satellites that exceed no limit may cross"), "{stderr}");
    // Limits of other bands do not apply: all satellites block.
    let (_, stderr, record) = gate(&folder, &[POINTING, &["--limit-mag", "g=-20", "--now", NOW]].concat());
    assert!(record["waited_s"].as_f64() > Some(0.0), "{stderr}");
    assert!(
        stderr.contains("limit_mag of the policy has no value for band none") && !stderr.contains("may cross"),
        "{stderr}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no half-written file stays");
    // An invalid or unwritable status file does not stop the gate.
    fs::write(&status, "{\"counters\": {\"runs\": 3").unwrap();
    let (code, _, record) = gate(&folder, &[POINTING, &["--limit-mag=-20", "--now", NOW]].concat());
    assert_eq!((code, record["counters"]["runs"].as_i64()), (0, Some(1)));
    let nowhere = &["--limit-mag=-20", "--now", NOW, "--status-file", "/dev/null/at/all.json"];
    assert_eq!(run(&[GATE, POINTING, nowhere]).0, 0);
    assert_eq!(run(&[GATE, POINTING, nowhere, &["--strict"]]).0, 2);
}

#[test]
fn usage_errors_have_exit_code_2_always() {
    for (arguments, part) in [
        (&[GATE][..], "missing pointing; specify --ra and --dec"),
        (&[GATE, &["--ra", "10"]], "--dec"),
        (&[&GATE[..7], POINTING], "missing exposure time"),
        (&[GATE, POINTING, &["--max-wait", "90"]], "max-wait is 90, without a unit"),
        (&[GATE, POINTING, &["--max-wait", "25h"]], "max-wait is 90000 s; allowed: 0 to 86400 s"),
        (&[GATE, POINTING, &["--now", "yesterday"]], "invalid time 'yesterday'"),
        (&[GATE, &["--ra", "25h", "--dec", "0"]], "25h"),
        (&[GATE, POINTING, &["--stdin", "nina"]], "nina"),
        (&[GATE, &["--indi", "localhost:99999"]], "allowed: HOST or HOST:PORT with a port from 1 to 65535"),
        (&[&["gate", "--mpc", "X05", "--fov", "1deg", "--exposure", "1s"], POINTING], "missing satellites"),
        (&[&["gate", "--shells", "oneweb", "--fov", "1deg", "--exposure", "1s"], POINTING], "missing site"),
        (&[&["gate", "--shells", "oneweb", "--mpc", "ZZZ", "--fov", "1deg", "--exposure", "1s"], POINTING], "ZZZ"),
    ] {
        let (code, stdout, stderr) = run(arguments);
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        assert!(stderr.starts_with("error: ") && stderr.contains(part), "'{part}' is not in: {stderr}");
    }
}

#[test]
fn faults_of_elements_open_the_gate_and_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let elements = path(&folder, "elements.tle");
    let base: &[&str] =
        &["gate", "--elements", &elements, "--mpc", "X05", "--fov", "3deg", "--exposure", "10s", "--limit-mag", "7"];
    let status = path(&folder, "status.json");
    let check = |kind: &str, part: &str, count: i64, now: &str| {
        for (strict, expected) in [(&[][..], 0), (&["--strict"][..], 2)] {
            let (code, _, stderr) = run(&[base, POINTING, &["--now", now, "--status-file", &status], strict]);
            assert_eq!(code, expected, "{kind}: {stderr}");
            let lines = stderr.lines().filter(|line| line.contains(part)).count();
            assert_eq!(lines, 1, "'{part}' is not one line of: {stderr}");
        }
        let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
        assert_eq!((record["verdict"].as_str(), record["fault"].as_str()), (Some("fault"), Some(kind)));
        assert_eq!(record["counters"]["faults"][kind], 2 * count, "{record}");
    };
    let all =
        crate::common::elements::pair(25544, "227.50000000") + &crate::common::elements::pair(25545, "227.50000000");
    let many: String = (0..40).map(|number| crate::common::elements::pair(40000 + number, "227.50000000")).collect();
    check("elements", "elements.tle", 1, ELEMENTS_NOW);
    // The file is truncated within a record, as during a slow copy.
    fs::write(&elements, &all[..100]).unwrap();
    check("elements", "elements.tle", 2, ELEMENTS_NOW);
    fs::write(&elements, "").unwrap();
    check("elements", "is empty", 3, ELEMENTS_NOW);
    // The file is complete. The field is clear because there are few satellites.
    fs::write(&elements, &many).unwrap();
    let (code, _, stderr) = run(&[base, POINTING, &["--now", ELEMENTS_NOW, "--status-file", &status]]);
    assert_eq!(code, 0, "{stderr}");
    let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
    assert_eq!((record["satellites"].as_i64(), record["verdict"].as_str()), (Some(40), Some("clear")), "{record}");
    // The file has a quarter of its previous records and is truncated between records. It has fewer than half of the
    // previous satellites, and is rejected until it has not changed for minutes.
    let is_believed = |text: &str, minutes: i64, part: &str| {
        fs::write(&elements, text).unwrap();
        let apart = Duration::from_secs(60 * minutes.unsigned_abs());
        let now = SystemTime::now();
        let changed = if minutes < 0 { now + apart } else { now - apart };
        fs::File::options().append(true).open(&elements).unwrap().set_modified(changed).unwrap();
        let (code, _, stderr) = run(&[base, POINTING, &["--now", ELEMENTS_NOW, "--status-file", &status]]);
        assert_eq!(code, 0, "{stderr}");
        assert!(stderr.contains(part), "'{part}' is not in: {stderr}");
        let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
        record["verdict"] != "fault"
    };
    let quarter: String = many.split_inclusive('\n').take(20).collect();
    let fewer = "elements may be incomplete: 10 satellites, 0 records rejected, 40 in the last run";
    // A modification time in the future (from the clock of another machine) is ignored.
    for minutes in [-60, 0, 1, 9] {
        assert!(!is_believed(&quarter, minutes, fewer));
    }
    // A file truncated within a record is always rejected if fewer than 90 % of its records are valid.
    let torn: String = many.split_inclusive('\n').take(60).collect::<String>() + &many[..100];
    let broken = "elements may be incomplete: 30 satellites, 1 records rejected, 40 in the last run";
    assert!(!is_believed(&torn, 60, broken));
    let last: String = many.split_inclusive('\n').take(79).collect();
    assert!(is_believed(&last, 1, "ends with a broken record"));
    assert!(is_believed(&many, 0, "clear now"));
    assert!(is_believed(&quarter, 11, "clear now"));
    // Element sets that are weeks old are too inaccurate for waiting times.
    fs::write(&elements, &many).unwrap();
    check("stale_elements", "elements 762 days old: positions unknown", 1, "2028-09-15T23:30:00Z");
    let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
    assert_eq!((record["positions_known"].as_bool(), record["late_s"].as_f64()), (Some(false), None), "{record}");
    assert!(!record["message"].as_str().unwrap().contains("the exposure starts"), "{record}");
    // After a month the satellites are early or late by 93 s: useless for 10 s, sufficient for two hours.
    let late = "2026-09-14T23:30:00Z";
    check("stale_elements", "of the crossings of an exposure of 10 s with a margin of 2 s are predicted", 2, late);
    let long: &[&str] = &["--exposure", "2h", "--max-wait", "1s", "--now", late, "--status-file", &status];
    let pole = &["--ra", "0", "--dec=-80"];
    let (code, _, stderr) = run(&[&base[..7], &["--limit-mag=-20"], pole, long]);
    let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
    assert_eq!((code, record["verdict"].as_str()), (0, Some("clear")), "{stderr}");
    assert_eq!(record["positions_known"], true, "{record}");
    assert!(record["late_s"].as_f64().unwrap() > 60.0 && record["elements_age_days"].as_f64().unwrap() > 25.0);
}

/// The element file of the period of the night is that of the request: it is read again and compared with the last run.
#[test]
fn faults_of_the_element_files_of_periods_are_those_of_elements() {
    let folder = tempfile::tempdir().unwrap();
    let [growth, now, later, status] =
        ["growth.toml", "now.tle", "later.tle", "status.json"].map(|name| path(&folder, name));
    fs::write(
        &growth,
        "[[period]]\nfrom = 2026-08-01\nelements = 'now.tle'\n[[period]]\nfrom = 2031-01-01\nelements = 'later.tle'\n",
    )
    .unwrap();
    let base = ["gate", "--shells", &growth, "--mpc", "X05", "--fov", "3deg", "--exposure", "10s", "--limit-mag", "7"];
    let run = || {
        let (_, _, stderr) = run(&[&base, POINTING, &["--now", ELEMENTS_NOW, "--status-file", &status]]);
        let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
        (record["fault"].as_str().map(str::to_owned), stderr)
    };
    let sets = |count: u32| -> String {
        (0..count).map(|number| crate::common::elements::pair(40000 + number, "227.50000000")).collect()
    };
    // The file of another period must exist, but is not read.
    for (present, missing) in [(&later, "now.tle"), (&now, "later.tle")] {
        fs::write(present, sets(40)).unwrap();
        let (fault, stderr) = run();
        assert!(fault.as_deref() == Some("elements") && stderr.contains(missing), "{stderr}");
        fs::remove_file(present).unwrap();
    }
    fs::write(&later, "not an element set\n").unwrap();
    for (count, expected) in
        [(40, None), (10, Some("elements may be incomplete: 10 satellites, 0 records rejected, 40"))]
    {
        fs::write(&now, sets(count)).unwrap();
        let (fault, stderr) = run();
        assert_eq!(fault.as_deref(), expected.map(|_| "elements"), "{stderr}");
        assert!(stderr.contains(expected.unwrap_or("clear")), "{stderr}");
    }
}

/// Files that are missing or invalid are faults: N.I.N.A. ends a sequence at any exit code except 0.
#[test]
fn missing_and_invalid_files_open_the_gate() {
    let folder = tempfile::tempdir().unwrap();
    let corrupt = path(&folder, "corrupt");
    fs::write(&corrupt, "\u{0}[[[ not a file = { of any kind").unwrap();
    let subfolder = path(&folder, "folder");
    for name in ["toml", "json", "csv"] {
        fs::copy(&corrupt, format!("{corrupt}.{name}")).unwrap();
        fs::create_dir(format!("{subfolder}.{name}")).unwrap();
    }
    let status = path(&folder, "status.json");
    let base: &[&str] = &["gate", "--shells", "starlink-gen1", "--mpc", "X05", "--exposure", "10s", "--now", NOW];
    let fov: &[&str] = &["--fov", "8deg"];
    for file in ["/nowhere/file", &corrupt, &subfolder] {
        let named = |extension: &str| format!("{file}.{extension}");
        let (toml, json) = (named("toml"), named("json"));
        for (more, kind) in [
            (&[fov, &["--policy", &toml]][..], "setup"),
            (&[fov, &["--config", &toml]], "setup"),
            (&[&["--field", &json]], "setup"),
            (&[&["--telescope", &toml]], "setup"),
            (&[fov, &["--model", &json]], "setup"),
            (&[fov, &["--eop", &toml]], "setup"),
            (&[fov, &["--qs-mag", &toml]], "setup"),
        ] {
            let (code, _, stderr) = run(&[base, POINTING, &more.concat(), &["--status-file", &status]]);
            assert_eq!(code, 0, "{more:?}: {stderr}");
            let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
            assert_eq!(
                (record["fault"].as_str(), record["exit_code"].as_i64()),
                (Some(kind), Some(0)),
                "{more:?}: {stderr}"
            );
            assert_eq!(run(&[base, POINTING, &more.concat(), &["--strict"]]).0, 2, "{more:?}");
        }
    }
    // Keys and numbers of a policy depend on the file too.
    let policy = path(&folder, "policy.toml");
    for text in ["saturation_mag = 4", "margin_s = -5", "max_cost_s = 1", "limit_mag = 'bright'"] {
        fs::write(&policy, text).unwrap();
        let (code, _, stderr) = run(&[base, POINTING, fov, &["--policy", &policy]]);
        assert_eq!(code, 0, "{text}: {stderr}");
    }
}

/// Errors in the keys of a verb, and files that are too large to parse in time, are faults of the configuration file.
#[test]
fn errors_in_tables_of_the_configuration_open_the_gate() {
    let folder = tempfile::tempdir().unwrap();
    let (config, status) = (path(&folder, "c.toml"), path(&folder, "status.json"));
    let base: &[&str] = &["gate", "--shells", "starlink-gen1", "--mpc", "X05", "--exposure", "10s", "--now", NOW];
    let rest: &[&str] = &["--fov", "8deg", "--config", &config, "--status-file", &status];
    let zeros = "\0".repeat(1_000_001);
    for (text, part) in [
        ("[gate]\nnope = 1", "unknown key 'nope'"),
        ("[forecast]\nnope = 1", "unknown key 'nope'"),
        ("fov = '-1deg'", "fov is -1"),
        ("[gate]\nmax_wait = 5", "[gate]: max-wait is 5, without a unit"),
        ("[gate]\ntimeout = '0s'", "[gate]: timeout is 0 s; allowed: 0.1 to 600 s"),
        ("[gate]\nindi = 'mount:99999'", "allowed: HOST or HOST:PORT"),
        ("max_delay = 10", "max-delay is 10, without a unit"),
        ("max_delay = '1s'\nmax-delay = '2s'", "max_delay is given twice"),
        (&zeros, "1000001 bytes; allowed: at most 1000000"),
    ] {
        fs::write(&config, text).unwrap();
        let (code, _, stderr) = run(&[base, POINTING, rest]);
        assert_eq!(code, 0, "{part}: {stderr}");
        let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
        assert_eq!(
            (record["fault"].as_str(), record["exit_code"].as_i64()),
            (Some("setup"), Some(0)),
            "{part}: {record}"
        );
        assert!(stderr.contains(part) && stderr.contains("the exposure starts"), "{part}: {stderr}");
        let (code, _, stderr) = run(&[base, POINTING, rest, &["--strict"]]);
        assert!(code == 2 && !stderr.contains("the exposure starts"), "{part}: {stderr}");
        fs::remove_file(&status).unwrap();
    }
    // A wrong flag is not a fault of a file.
    for text in ["", "[gate]\nmax_wait = 5"] {
        fs::write(&config, text).unwrap();
        assert_eq!(run(&[base, POINTING, rest, &["--nope"]]).0, 2);
        assert_eq!(run(&[base, POINTING, rest, &["--timeout", "0s"]]).0, 2);
    }
}

/// Counters of a status file do not overflow.
#[test]
fn the_largest_counters_remain() {
    let folder = tempfile::tempdir().unwrap();
    let status = path(&folder, "status.json");
    let most = u64::MAX;
    fs::write(&status, format!("{{\"counters\": {{\"runs\": {most}, \"faults\": {{\"setup\": {most}}}}}}}")).unwrap();
    let base: &[&str] = &["gate", "--shells", "oneweb", "--mpc", "X05", "--exposure", "10s", "--fov", "1deg"];
    let (code, _, stderr) =
        run(&[base, POINTING, &["--now", NOW, "--policy", "/nowhere/p.toml", "--status-file", &status]]);
    assert!(code == 0 && !stderr.contains("panicked"), "{stderr}");
    let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
    assert_eq!(
        (record["counters"]["runs"].as_u64(), record["counters"]["faults"]["setup"].as_u64()),
        (Some(most), Some(most))
    );
}

/// Only a status file is replaced. Other files of the user remain, and the result is that without a status file.
#[test]
fn other_files_are_not_replaced_by_a_status() {
    let folder = tempfile::tempdir().unwrap();
    let other = path(&folder, "other");
    let base: &[&str] = &["gate", "--shells", "oneweb", "--mpc", "X05", "--exposure", "10s", "--fov", "1deg"];
    let base = [base, POINTING, &["--now", NOW, "--limit-mag=-20", "--status-file", &other]].concat();
    for text in
        ["limit_mag = 7\n", "{\"type\": \"FeatureCollection\"}", "[1, 2]", "\u{0}", "{\"counters\": {\"a\": 1}}"]
    {
        fs::write(&other, text).unwrap();
        for (strict, expected) in [(&[][..], 0), (&["--strict"][..], 2)] {
            let (code, _, stderr) = run(&[&base, strict]);
            assert!(
                code == expected && stderr.contains("is not a status file; allowed: a new file"),
                "{text}: {stderr}"
            );
            assert_eq!(fs::read_to_string(&other).unwrap(), text);
        }
    }
    for text in ["", " \n"] {
        fs::write(&other, text).unwrap();
        assert_eq!(run(&[&base]).0, 0);
        assert!(fs::read_to_string(&other).unwrap().contains("\"verdict\": \"clear\""));
    }
}

/// Counters that cannot be read start again, with a warning; `since_utc` is then the begin of this run.
#[test]
fn a_damaged_status_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let status = path(&folder, "status.json");
    let base: &[&str] = &["gate", "--shells", "oneweb", "--mpc", "X05", "--exposure", "10s", "--fov", "1deg"];
    let base = [base, POINTING, &["--now", NOW, "--limit-mag=-20", "--status-file", &status]].concat();
    let counters = || -> Value {
        let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
        record["counters"].clone()
    };
    for damaged in ["{\"counters\": {\"runs\": 5, \"cl", "{\"counters\": {\"runs\": -5}}"] {
        fs::write(&status, damaged).unwrap();
        let (code, _, stderr) = run(&[&base]);
        assert!(code == 0 && stderr.contains("status.json was damaged: its counters start again"), "{stderr}");
        let first = counters();
        let (code, _, stderr) = run(&[&base]);
        assert!(code == 0 && !stderr.contains("damaged"), "{stderr}");
        assert_eq!((&first["runs"], &counters()["runs"]), (&Value::from(1), &Value::from(2)));
        assert!(first["since_utc"].is_string() && first["since_utc"] == counters()["since_utc"], "{first}");
    }
    // Also if the file is written during a wait, before the final status.
    let mut waited = 0;
    for minute in [30, 33, 36, 39] {
        fs::write(&status, "{\"counters\": {\"runs\": -5}}").unwrap();
        let now = format!("2024-08-14T23:{minute}:00.000Z");
        let (code, _, stderr) = run(&[GATE, POINTING, LIMIT, &["--now", &now, "--status-file", &status]]);
        assert_eq!((code, stderr.matches("was damaged").count()), (0, 1), "{stderr}");
        waited += usize::from(stderr.contains("clear after"));
    }
    assert!(waited > 0, "all of them were clear at once");
}

/// Runs at the same time with one status file are all counted.
#[test]
fn runs_at_the_same_time_are_all_counted() {
    const RUNS: usize = 6;
    let folder = tempfile::tempdir().unwrap();
    let status = path(&folder, "status.json");
    let base: &[&str] = &["gate", "--shells", "oneweb", "--mpc", "X05", "--exposure", "10s", "--fov", "1deg"];
    let base = [base, POINTING, &["--now", NOW, "--policy", "/nowhere/p.toml", "--status-file", &status]].concat();
    thread::scope(|scope| {
        for _ in 0..RUNS {
            scope.spawn(|| assert_eq!(run(&[&base]).0, 0));
        }
    });
    let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
    assert_eq!(record["counters"]["runs"].as_u64(), Some(RUNS as u64), "{record}");
}

/// A computation of a day of crossings takes longer than 0.1 s. The thread is left behind, as in a call that blocks.
#[test]
fn the_gate_answers_at_its_deadline() {
    let folder = tempfile::tempdir().unwrap();
    let status = path(&folder, "status.json");
    let base: &[&str] = &["gate", "--shells", "starlink-gen1", "--mpc", "X05", "--fov", "60deg", "--exposure", "24h"];
    let limits: &[&str] = &["--max-wait", "24h", "--timeout", "0.1s", "--now", NOW, "--status-file", &status];
    // A target that never sets is searched for the whole time.
    let pointing: &[&str] = &["--ra", "217.5", "--dec", "-80"];
    for (strict, expected) in [(&[][..], 0), (&["--strict"], 2)] {
        let (code, _, stderr) = run(&[base, pointing, limits, strict]);
        assert_eq!(code, expected, "{stderr}");
        let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
        assert_eq!(record["fault"], "timeout", "{record}");
        assert!(stderr.contains("no result within 0.1 s (--timeout), after the start of: "), "{stderr}");
        assert_eq!(stderr.contains("the exposure starts"), strict.is_empty(), "{stderr}");
    }
    let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
    assert_eq!(record["counters"]["faults"]["timeout"], 2, "{record}");
}

#[test]
fn elements_being_replaced_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let elements = path(&folder, "elements.tle");
    let whole: String = (0..40).map(|number| crate::common::elements::pair(40000 + number, "227.50000000")).collect();
    let base: &[&str] =
        &["gate", "--elements", &elements, "--mpc", "X05", "--fov", "3deg", "--exposure", "10s", "--limit-mag", "7"];
    // The gate retries for 0.9 s. On a loaded machine the file may be completed later; the test is then repeated.
    let end = Instant::now() + Duration::from_secs(120);
    loop {
        fs::write(&elements, &whole[..60]).unwrap();
        let (late, target) = (whole.clone(), elements.clone());
        let writer = thread::spawn(move || {
            thread::sleep(Duration::from_millis(150));
            fs::write(target, late).unwrap();
        });
        let (code, _, stderr) = run(&[base, POINTING, &["--now", ELEMENTS_NOW, "--strict"]]);
        writer.join().unwrap();
        if code == 0 {
            break;
        }
        assert!(Instant::now() < end, "{stderr}");
    }
}

const TARGETS: &str =
    "[targets.'M 31']\nra = '00h42m44s'\ndec = '+41d16m09s'\n[targets.field_1]\nra = 217.5\ndec = -30\n";

#[test]
fn ekos_jobs_are_read_and_darks_pass() {
    let folder = tempfile::tempdir().unwrap();
    let targets = path(&folder, "targets.toml");
    fs::write(&targets, TARGETS).unwrap();
    let more: &[&str] = &["--targets", &targets, "--limit-mag=L=-20,default=-21", "--now", NOW];
    let job = |kind: &str, target: &str| {
        format!(
            "{{\"script_type\":\"PRE_CAPTURE\",\"job\":{{\"filter\":\"L\",\"exposure\":120.0,\"type\":\"{kind}\",\"binning_x\":1,\"binning_y\":1,\"target_name\":\"{target}\"}}}}"
        )
    };
    // Ekos replaces blanks in names by underscores; the exposure time of the job is used. The pipe stays open, as with
    // some hosts.
    let (code, status) = ekos(&folder, job("Light", "Field 1").as_bytes(), false, more);
    assert_eq!((code, status["verdict"].as_str()), (0, Some("clear")), "{status}");
    assert_eq!((status["exposure_s"].as_f64(), status["ra_deg"].as_f64()), (Some(120.0), Some(217.5)));
    assert_eq!((status["band"].as_str(), status["limit_mag"].as_f64()), (Some("L"), Some(-20.0)));
    for kind in ["Dark", "Flat", "Bias"] {
        let (code, status) = ekos(&folder, job(kind, "anything").as_bytes(), true, more);
        assert_eq!((code, status["verdict"].as_str()), (0, Some("skipped")), "{status}");
    }
    // Unknown target, target below the horizon, invalid JSON, truncated JSON, and no input: the exit code is 0, and a
    // counter of the status file increases.
    for (input, close, kind) in [
        (job("Light", "NGC 1"), true, "target"),
        (job("Light", "M 31"), true, "target"),
        (job("Light", ""), true, "target"),
        ("not json\n".to_owned(), true, "host"),
        ("{\"script_type\":\"PRE_CAPTURE\",\"job\":{".to_owned(), false, "host"),
        ("{\"script_type\":\"POST_CAPTURE\",\"job\":{}}".to_owned(), true, "host"),
        ("{\"job\":{\"exposure\":-5,\"target_name\":\"Field 1\"}}".to_owned(), true, "host"),
    ] {
        let (code, status) = ekos(&folder, input.as_bytes(), close, more);
        assert_eq!((code, status["fault"].as_str()), (0, Some(kind)), "{input}: {status}");
        let strict: Vec<&str> = more.iter().chain(&["--strict"]).copied().collect();
        assert_eq!(ekos(&folder, input.as_bytes(), close, &strict).0, 2, "{input}");
    }
    // Older versions of KStars send no data; the command line arguments are used.
    let typed: Vec<&str> = ["--limit-mag=-20", "--now", NOW].iter().chain(POINTING).copied().collect();
    for (input, close) in [("", true), ("", false), ("\n", false)] {
        let (code, status) = ekos(&folder, input.as_bytes(), close, &typed);
        assert_eq!((code, status["verdict"].as_str()), (0, Some("clear")), "{status}");
        assert_eq!(status["exposure_s"].as_f64(), Some(10.0), "{status}");
    }
}

/// Called as by N.I.N.A.: a program with arguments. Any exit code except 0 stops the sequence, and the result is read
/// from the status file.
#[test]
fn nina_reads_the_status_file_and_fails_only_with_strict() {
    let folder = tempfile::tempdir().unwrap();
    let targets = path(&folder, "targets.toml");
    fs::write(&targets, TARGETS).unwrap();
    let named = |target: &str, more: &[&str]| {
        let named = ["--targets", &targets, "--target", target, "--limit-mag=-20", "--now", NOW];
        gate(&folder, &[&named, more].concat())
    };
    let (code, stderr, status) = named("FIELD-1", &[]);
    assert_eq!((code, status["verdict"].as_str()), (0, Some("clear")), "{stderr}");
    for key in ["verdict", "message", "exit_code", "began_utc", "ended_utc", "start_utc", "clear_until_utc", "counters"]
    {
        assert!(!status[key].is_null(), "{key} in {status}");
    }
    let (code, stderr, status) = named("nowhere", &[]);
    assert_eq!((code, status["fault"].as_str()), (0, Some("target")));
    assert!(stderr.contains("unknown target 'nowhere'; allowed: M 31, field_1"), "{stderr}");
    assert_eq!(named("nowhere", &["--strict"]).0, 2);
}

/// INDI server that sends messages to its first client, and then keeps the connection open or closes it.
fn fake_indi(messages: impl FnOnce() -> Vec<String> + Send + 'static, close: bool) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut received = [0; 256];
        let read = stream.read(&mut received).unwrap_or(0);
        assert!(received[..read].starts_with(b"<getProperties version="));
        for message in messages() {
            if stream.write_all(message.as_bytes()).is_err() {
                return;
            }
            // So that the parts are usually received by separate reads.
            thread::sleep(Duration::from_millis(20));
        }
        if !close {
            // Until the client closes the connection.
            let _ = stream.read(&mut received);
        }
    });
    address
}

fn numbers(device: &str, name: &str, state: &str, stamp: &str, numbers: &[(&str, &str)]) -> String {
    let items: String = numbers
        .iter()
        .map(|(name, value)| {
            format!("<defNumber name='{name}' format='%g' min='0' max='24' step='0'>\n{value}\n</defNumber>\n")
        })
        .collect();
    format!(
        "<defNumberVector device=\"{device}\" name=\"{name}\" label=\"x\" state=\"{state}\" perm=\"rw\" timestamp=\"{stamp}\">\n{items}</defNumberVector>\n"
    )
}

fn eod(state: &str, stamp: &str) -> String {
    // Apparent position of date for ICRS 217.5, -30 on 2024-08-14, by astropy 8.0.2 (TETE).
    numbers("Mount", "EQUATORIAL_EOD_COORD", state, stamp, &[("RA", "14:31:26.619"), ("DEC", "-30.110918")])
}

fn place(latitude: &str, longitude: &str) -> String {
    numbers(
        "Mount",
        "GEOGRAPHIC_COORD",
        "Ok",
        "2024-08-14T23:30:00",
        &[("LAT", latitude), ("LONG", longitude), ("ELEV", "2663")],
    )
}

const STAMP: &str = "2024-08-14T23:30:00";
const CCD: &str = "<defTextVector device='CCD' name='DRIVER_INFO' state='Idle'><defText name='A'>a &amp; b</defText></defTextVector>\n";

/// Runs the gate with an INDI server. The time limit has an effect only if the server sends nothing and keeps the
/// connection open.
#[track_caller]
fn run_with_indi(folder: &TempDir, messages: Vec<String>, close: bool, more: &[&str]) -> (i32, String, Value) {
    let timeout = if messages.is_empty() && !close { SHORT } else { LONG };
    let address = fake_indi(|| messages, close);
    gate(folder, &[&["--indi", &address, "--timeout", timeout, "--limit-mag=-20"], more].concat())
}

#[test]
fn pointing_and_site_are_read_from_a_mount() {
    let folder = tempfile::tempdir().unwrap();
    let now = &["--now", NOW];
    // Sent in one message, because the gate waits less than a second for the site after the pointing.
    let good = || vec![CCD.to_owned() + &eod("Ok", STAMP) + &place("-30:14:40", "289.2506")];
    let (code, stderr, status) = run_with_indi(&folder, good(), false, now);
    assert_eq!(
        (code, status["verdict"].as_str(), status["mount"].as_str()),
        (0, Some("clear"), Some("Mount")),
        "{stderr}"
    );
    // Coordinates of date, which differ by a third of a degree, are converted to ICRS with an error below 0.1 arcsec.
    let (ra, dec) = (status["ra_deg"].as_f64().unwrap(), status["dec_deg"].as_f64().unwrap());
    assert!((ra - 217.5).abs() < 3e-5 && (dec + 30.0).abs() < 3e-5, "{ra} {dec}");
    // A message that is sent in parts, and a mount that stops moving during the connection.
    let cut = eod("Busy", STAMP) + &place("-30.2446", "289.2506");
    let moved = eod("Ok", STAMP)
        .replace("def", "set")
        .replace("setNumber name", "oneNumber name")
        .replace("</setNumber>", "</oneNumber>");
    let pieces = cut.as_bytes().chunks(50).map(|piece| String::from_utf8(piece.to_vec()).unwrap()).chain([moved]);
    let (code, stderr, status) = run_with_indi(&folder, pieces.collect(), false, now);
    assert_eq!((code, status["verdict"].as_str()), (0, Some("clear")), "{stderr}");
    // J2000 coordinates are used unchanged.
    let j2000 = numbers("Mount", "EQUATORIAL_COORD", "Idle", STAMP, &[("RA", "14.5"), ("DEC", "-30")]);
    let (_, stderr, status) = run_with_indi(&folder, vec![j2000], false, now);
    assert_eq!((status["ra_deg"].as_f64(), status["dec_deg"].as_f64()), (Some(217.5), Some(-30.0)), "{stderr}");
    // If no site is configured, the site of the mount is used.
    let status_file = path(&folder, "own.json");
    let address = fake_indi(good, false);
    let own =
        ["gate", "--shells", "starlink-gen1", "--fov", "8deg", "--exposure", "10s", "--limit-mag=-20", "--now", NOW];
    let (code, _, stderr) = run(&[&own, &["--indi", &address, "--status-file", &status_file, "--strict"]]);
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn faulty_servers_do_not_stop_the_gate() {
    let folder = tempfile::tempdir().unwrap();
    let second = eod("Ok", STAMP).replace("\"Mount\"", "\"Other\"");
    let wrong = numbers("Mount", "EQUATORIAL_EOD_COORD", "Ok", STAMP, &[("RA", "14.5"), ("DEC", "-300")]);
    for (pieces, close, part) in [
        (vec![], false, "no mount (I/O error: no response in time)"),
        (vec![], true, "connection closed by the server"),
        (vec![CCD.to_owned()], true, "no mount"),
        (vec![eod("Ok", STAMP)[..120].to_owned()], true, "no mount"),
        (vec!["\u{1}<<<&&>>\"garbage\u{7f}".to_owned(); 3], true, "no mount"),
        (vec![eod("Busy", STAMP)], true, "Mount is Busy; allowed: a mount at rest"),
        (vec![eod("Busy", STAMP) + &second], false, "several mounts (Mount, Other)"),
        (vec![eod("Ok", STAMP) + &place("-30.2446", "289.2506") + &second], false, "several mounts (Mount, Other)"),
        (vec![wrong], false, "invalid pointing of Mount: 14.5 h, -300 deg"),
    ] {
        let (code, stderr, status) = run_with_indi(&folder, pieces, close, &["--now", NOW]);
        assert_eq!((code, status["fault"].as_str()), (0, Some("indi")), "{stderr}");
        assert!(stderr.contains(part), "'{part}' is not in: {stderr}");
    }
    // Names of devices are shortened, and so is their list.
    let many: String = (0..3000).map(|number| CCD.replace("CCD", &format!("{number}{}", "x".repeat(900)))).collect();
    let numbered = many.replace("defTextVector", "defNumberVector").replace("defText", "defNumber");
    let (code, stderr, status) = run_with_indi(&folder, vec![numbered], true, &["--now", NOW]);
    assert_eq!((code, status["fault"].as_str()), (0, Some("indi")), "{stderr}");
    assert!(stderr.len() < 1000 && stderr.contains("and 2992 more"), "{} bytes: {stderr}", stderr.len());
    let closed_port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let (code, stderr, status) = gate(&folder, &["--indi", &closed_port, "--now", NOW]);
    assert_eq!((code, status["fault"].as_str()), (0, Some("indi")), "{stderr}");
    assert_eq!(gate(&folder, &["--indi", &closed_port, "--now", NOW, "--strict"]).0, 2);
}

#[test]
fn a_different_site_and_a_wrong_clock_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    // A difference of 0.02 deg is 2.2 km; 0.005 deg is 0.5 km.
    let (code, stderr, status) =
        run_with_indi(&folder, vec![eod("Ok", STAMP) + &place("-30.2646", "289.2506")], false, &["--now", NOW]);
    assert_eq!((code, status["fault"].as_str()), (0, Some("site")), "{stderr}");
    assert!(stderr.contains("the site of the mount Mount is 2.2 km from"), "{stderr}");
    let (_, stderr, status) =
        run_with_indi(&folder, vec![eod("Ok", STAMP) + &place("-30.2496", "289.2506")], false, &["--now", NOW]);
    assert_eq!(status["verdict"], "clear", "{stderr}");

    // Server clocks compared with the system clock: correct, and 37 s wrong. The time stamp is computed when the server
    // sends.
    let stamp = |offset_s: f64| {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap().as_secs_f64();
        streakcast::output::format_utc(hifitime::Epoch::from_unix_seconds(now + offset_s), 0).replace('Z', "")
    };
    let place = place("-30.2446", "289.2506");
    let ask_at = |offset_s: f64| {
        let place = place.clone();
        let address = fake_indi(move || vec![eod("Ok", &stamp(offset_s)) + &place], false);
        gate(&folder, &["--indi", &address, "--timeout", LONG, "--limit-mag=-20"])
    };
    let (_, stderr, status) = ask_at(0.0);
    assert_ne!(status["fault"], "clock", "{stderr}");
    let (code, stderr, status) = ask_at(37.0);
    assert_eq!((code, status["fault"].as_str()), (0, Some("clock")), "{stderr}");
    assert!(stderr.contains("the clock of the INDI server differs by +3"), "{stderr}");
}

#[test]
fn the_gate_waits_in_real_time() {
    // A field near the pole does not set. The test only checks that real time passes, not how much.
    let folder = tempfile::tempdir().unwrap();
    let status = path(&folder, "status.json");
    let began = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap().as_secs_f64();
    let arguments = [
        "gate",
        "--shells",
        "starlink-gen1",
        "--lat=-89",
        "--lon",
        "0",
        "--fov",
        "3deg",
        "--exposure",
        "1s",
        "--ra",
        "0",
        "--dec=-80",
    ];
    let (code, _, stderr) = run(&[&arguments, &["--limit-mag", "9", "--max-wait", "30s", "--status-file", &status]]);
    assert_eq!(code, 0, "{stderr}");
    let record: Value = serde_json::from_str(&fs::read_to_string(&status).unwrap()).unwrap();
    let ended = utc_seconds(record["ended_utc"].as_str().unwrap());
    assert!(ended >= began, "{record}");
    if let Some(start) = record["start_utc"].as_str() {
        assert!(ended >= utc_seconds(start) - 1e-3, "{record}");
    }
}

#[test]
fn the_gate_uses_the_same_satellites_as_passes() {
    let folder = tempfile::tempdir().unwrap();
    let (_, _, status) = gate(&folder, &[POINTING, LIMIT, &["--now", NOW]].concat());
    let dodged = status["dodged"].as_array().unwrap();
    assert!(!dodged.is_empty(), "{status}");
    let first = &dodged[0];
    let passes = ["passes", "--shells", "starlink-gen1", "--mpc", "X05", "--fov", "8deg", "--quiet", "--start", NOW];
    let answer = json(&[&passes, POINTING, &["--exposure", "10min"]]);
    let rows = answer["passes"].as_array().unwrap();
    assert!(rows.iter().any(|row| row["norad_id"] == first["norad_id"]), "{first}");
}
