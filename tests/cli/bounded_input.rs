//! Bounds of inputs and messages: pipes and devices are rejected by every reader, messages are short and name their
//! file, and repeated warnings are counted.

use std::fs;
use std::process::{Command, Stdio};

use crate::common::cli::{FLAG, SKY, path, run};
use tempfile::TempDir;

/// Largest number of characters of a line on standard error.
const LONGEST_MESSAGE: usize = 1000;
const POINTING: &[&str] =
    &["passes", "--start", "2024-08-14T23:30:00Z", "--exposure", "10s", "--ra", "217", "--dec=-30", "--mpc", "X05"];

/// Returns the only line on standard error of a run that fails.
#[track_caller]
fn error(arguments: &[&[&str]]) -> String {
    let (code, stdout, stderr) = run(arguments);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    let errors: Vec<&str> = stderr.lines().filter(|line| !line.starts_with("warning: ")).collect();
    assert!(errors.len() == 1 && errors[0].starts_with("error: "), "{stderr}");
    assert!(errors[0].chars().count() <= LONGEST_MESSAGE, "{} characters", errors[0].chars().count());
    errors[0].to_owned()
}

fn file(folder: &TempDir, name: &str, text: &str) -> String {
    let path = path(folder, name);
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn small_tables_are_regular_files() {
    let folder = TempDir::new().unwrap();
    let pipe = path(&folder, "pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let [output, tables] = ["out", "tables"].map(|name| path(&folder, name));
    let photometry = file(&folder, "mmt.csv", "");
    let elements = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/data/elements/sample.3le");
    let synthetic =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/synthetic.toml")).unwrap();
    let plain = file(&folder, "plain.toml", &synthetic);
    let random: &[&str] =
        &["--random-streaks", "1", "--magnitude", "4,7", "--exposure", "30s", "--seeing", "1.5arcsec", "--seed", "1"];
    for (input, kind) in [(pipe.as_str(), "is a named pipe"), ("/dev/zero", "is a device")] {
        let stars = file(&folder, "stars.toml", &format!("star_list = '{input}'\n{synthetic}"));
        let fit = ["--elements", elements, "--model", "starlink-v1.5", "--raw-points", "-o", &output];
        let commands: [&[&[&str]]; 4] = [
            &[&["inject", "--synthetic", &plain, "-o", &output, "--light-curve", input], random],
            &[&["inject", "--synthetic", &stars, "-o", &output], random],
            &[&["reproduce", "lu2024", "-o", &tables, "--satcat", input]],
            &[&["fit", "run", "--photometry", &photometry, "--identified", input], &fit],
        ];
        for command in commands {
            let error = error(command);
            assert!(error.contains(input) && error.contains(kind), "{error}");
            assert!([&output, &tables].iter().all(|path| !fs::exists(path).unwrap()), "{error}");
        }
    }
}

#[test]
fn long_values_are_shortened() {
    let folder = TempDir::new().unwrap();
    let long = "x".repeat(60_000);
    error(&[&[&long]]);
    error(&[&["passes", &format!("--{long}")]]);
    error(&[POINTING, SKY, &["--fov", &long]]);
    error(&[POINTING, SKY, &["--fov", "1deg", "--limit-mag", &long]]);
    error(&[POINTING, SKY, &["--fov", "1deg", "--elements", &long]]);
    let policy = file(&folder, "policy.toml", &format!("{long} = 1\n"));
    let schedule = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/night.csv");
    error(&[&["flag", "--schedule", schedule, "--policy", &policy, "--fov", "1deg"], SKY]);

    // Cells of 10 MB, in the reasons of invalid rows.
    let long = "x".repeat(10_000_000);
    for row in [format!("a,{long},30,217,-30"), format!("a,2024-08-14T23:30:00Z,{long},217,-30")] {
        let schedule = file(&folder, "night.csv", &format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{row}\n"));
        let sky: Vec<&str> = SKY.iter().copied().filter(|word| *word != "--quiet").collect();
        let (code, stdout, stderr) = run(&[&["flag", "--schedule", &schedule], FLAG, &sky]);
        assert_eq!(code, 0, "{stderr}");
        for line in stdout.lines().chain(stderr.lines()) {
            assert!(line.chars().count() <= 5000, "a line of {} characters", line.chars().count());
        }
        assert!(stdout.contains("xxx..."), "{stdout}");
    }
}

#[test]
fn errors_name_their_file() {
    let folder = TempDir::new().unwrap();
    let bad = file(&folder, "bad.toml", "nothing = 1\n");
    for arguments in [
        vec!["--shells", "oneweb", "--field", &bad],
        vec!["--shells", &bad, "--fov", "1deg"],
        vec!["--shells", "oneweb", "--fov", "1deg", "--eop", &bad],
        vec!["--shells", "oneweb", "--fov", "1deg", "--qs-mag", &bad],
        vec!["--shells", "oneweb", "--fov", "1deg", "--config", &bad],
        vec!["--shells", "oneweb", "--fov", "1deg", "--learned", &bad],
        vec!["--shells", "oneweb", "--telescope", &bad],
        vec!["--elements", &bad, "--fov", "1deg"],
    ] {
        let error = error(&[POINTING, &arguments]);
        assert!(error.contains(&bad), "{arguments:?}: {error}");
    }
    let schedule = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/night.csv");
    assert!(error(&[&["flag", "--schedule", schedule, "--policy", &bad, "--fov", "1deg"], SKY]).contains(&bad));
}

#[test]
fn warnings_of_one_kind_are_counted() {
    let folder = TempDir::new().unwrap();
    let rows: String = (0..2000).map(|number| format!("t{number},,,60\n")).collect();
    let rows = format!("{rows}valid,200,-30,60\n");
    let targets = file(&folder, "targets.csv", &format!("name,ra_deg,dec_deg,exposure_s\n{rows}"));
    let (code, _, stderr) = run(&[
        &["windows", "--targets", &targets, "--night", "2024-08-14"],
        FLAG,
        &SKY.iter().copied().filter(|word| *word != "--quiet").collect::<Vec<_>>(),
    ]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.lines().count() < 15, "{stderr}");
    assert!(stderr.contains("row 3, target t2 is invalid") && stderr.contains("1997 more invalid targets in the list"));
    // Names of many bands in one warning.
    let rows: String = (0..2000).map(|number| format!("{number},2024-08-14T23:30:00Z,1,217,-30,b{number}\n")).collect();
    let schedule = file(&folder, "night.csv", &format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg,band\n{rows}"));
    let policy = file(&folder, "policy.toml", "[limit_mag]\ng = 7\n");
    let sky: Vec<&str> = SKY.iter().copied().filter(|word| *word != "--quiet").collect();
    let (code, _, stderr) = run(&[&["flag", "--schedule", &schedule, "--fov", "1deg", "--policy", &policy], &sky]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("and 1988 more") && stderr.lines().all(|line| line.len() <= LONGEST_MESSAGE), "{stderr}");
}

#[test]
fn keys_of_json_schedules_occur_once() {
    let folder = TempDir::new().unwrap();
    let row =
        r#"{"exposure_id": "a", "start_utc": "2024-08-14T23:30:00Z", "duration_s": 1, "ra_deg": 217, "dec_deg": -30}"#;
    let twice = row.replace("\"ra_deg\": 217", "\"ra_deg\": 217, \"ra_deg\": 37");
    for (text, line) in [
        (format!("[{row},\n {twice}]"), "line 2"),
        (format!("{{\"exposures\": [\n\n{twice}]}}"), "line 3"),
        (format!("{{\"exposures\": [{row}],\n\"exposures\": []}}"), "line 2"),
    ] {
        let schedule = file(&folder, "night.json", &text);
        let error = error(&[&["flag", "--schedule", &schedule], FLAG, SKY]);
        assert!(error.contains("night.json") && error.contains(line) && error.contains("occurs twice"), "{error}");
        assert!(error.contains("'ra_deg'") || error.contains("'exposures'"), "{error}");
    }
    let schedule = file(&folder, "night.json", &format!("[{row}]"));
    assert_eq!(run(&[&["flag", "--schedule", &schedule], FLAG, SKY]).0, 0);
    // Each key is a column with a cell in every row.
    let rows: Vec<String> = (0..2000).map(|number| format!("{{\"k{number}\": 1}}")).collect();
    let schedule = file(&folder, "night.json", &format!("[{}]", rows.join(",")));
    assert!(error(&[&["flag", "--schedule", &schedule], FLAG, SKY]).contains("more than 1000 keys"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_that_says_what_is_missing() {
    for (arguments, what) in
        [(vec!["sites"], "the table"), (vec!["--help"], "the help"), (vec!["passes", "--help"], "the help")]
    {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_streakcast"))
            .env("STREAKCAST_NO_HOME", "1")
            .args(&arguments)
            .stdout(Stdio::from(full))
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        let expected = format!("error: cannot write {what}");
        assert!(stderr.starts_with(&expected) && stderr.contains("to standard output: No space left"), "{stderr}");
    }
}
