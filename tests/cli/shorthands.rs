//! Shorthands on the command line: target names, rectangular fields, schedules on standard input, `now` and `tonight`.

use std::fs;

use assert_cmd::Command;

use crate::common::cli::{SKY, done, json, run};
use serde_json::Value;

const EXPOSURE: &[&str] = &["passes", "--start", "2024-08-14T23:30:00Z", "--exposure", "120s"];

#[test]
fn targets_by_name() {
    let by_name = json(&[EXPOSURE, SKY, &["--fov", "80deg", "--target", "M 13"]]);
    // 16h41m41.6s +36d27m41s in the table of deep-sky objects, in degrees with four decimals.
    let by_angles = json(&[EXPOSURE, SKY, &["--fov", "80deg", "--ra", "250.4233", "--dec", "36.4603"]]);
    assert!(by_name["passes"].as_array().unwrap().len() > 3);
    let names = |answer: &Value| -> Vec<Value> {
        answer["passes"].as_array().unwrap().iter().map(|pass| pass["norad_id"].clone()).collect()
    };
    assert_eq!(names(&by_name), names(&by_angles));
    let (code, _, stderr) = run(&[EXPOSURE, SKY, &["--fov", "80deg", "--target", "M 131"]]);
    assert!(code == 2 && stderr.contains("unknown target 'M 131'; allowed: Messier, Caldwell"), "{stderr}");
    let (code, _, stderr) = run(&[EXPOSURE, SKY, &["--fov", "80deg", "--target", "Sombrero"]]);
    assert!(code == 2 && stderr.contains("unknown target 'Sombrero'; similar names: Sombrero Galaxy"), "{stderr}");
    let (code, _, stderr) = run(&[EXPOSURE, SKY, &["--fov", "80deg", "--target", "M 13", "--ra", "3"]]);
    assert!(code == 2 && stderr.contains("--target"), "{stderr}");
}

#[test]
fn fields_by_width_and_height() {
    let pointing: &[&str] = &["--ra", "217.5", "--dec=-30"];
    let count = |size: &str| json(&[EXPOSURE, SKY, pointing, &["--fov", size]])["passes"].as_array().unwrap().len();
    let (wide, narrow) = (count("60x60deg"), count("60x1deg"));
    assert!(wide > narrow && wide > 3, "{wide} {narrow}");
    // The square contains its inscribed circle, and is contained in its circumscribed circle.
    assert!(count("60deg") <= wide && wide <= count("84.9deg"));
}

#[test]
fn a_schedule_from_standard_input() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = folder.path().join("night.csv");
    fs::write(&schedule, "exposure_id,start_utc,duration_s,ra_deg,dec_deg\na,2024-08-14T23:30:00Z,120,217.5,-30\n")
        .unwrap();
    let flags: &[&str] = &["flag", "--fov", "80deg", "--format", "csv"];
    let from_file = done(&[flags, SKY, &["--schedule", schedule.to_str().unwrap()]]);
    let answer = Command::new(env!("CARGO_BIN_EXE_streakcast"))
        .env("STREAKCAST_NO_HOME", "1")
        .args([flags, SKY, &["--schedule", "-"]].concat())
        .write_stdin(fs::read(&schedule).unwrap())
        .output()
        .unwrap();
    // Comment lines contain the name of the file.
    let rows = |text: &str| text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(rows(&from_file), rows(&String::from_utf8(answer.stdout).unwrap()));
    assert_eq!(rows(&from_file).len(), 2);
}

#[test]
fn now_and_tonight() {
    // Simulated satellites are used, because the element sets of the sample are too old today.
    let sky = ["--shells", "oneweb", "--lat", "47", "--lon", "10", "-q"];
    let now: &[&str] = &["passes", "--start", "now", "--exposure", "30s", "--target", "M81", "--fov", "90deg"];
    // M81 never sets at this latitude. Exit code 1 means that no satellite crosses, which depends on the time of day.
    let (code, _, stderr) = run(&[now, &sky]);
    assert!(code <= 1, "{code}: {stderr}");
    let (code, _, stderr) = run(&[&["ephemeris", "--times", "now", "--name", "S1"], &sky]);
    assert!(code <= 1, "{code}: {stderr}");
    let answer = json(&[&["forecast", "--night", "tonight"], &sky]);
    let options = answer["provenance"].to_string();
    assert!(!options.contains("tonight") && options.contains("\"night\":\"20"), "{options}");
}
