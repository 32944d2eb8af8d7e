//! Errors of the command line for invalid input: one line, exit code 2, no partial output.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command as Process, Stdio};

use assert_cmd::Command;
use tempfile::TempDir;

const STREAKCAST: &str = env!("CARGO_BIN_EXE_streakcast");
const POINTING: &[&str] = &[
    "passes",
    "--start",
    "2024-08-14T03:30:00Z",
    "--exposure",
    "30s",
    "--ra",
    "280",
    "--dec",
    "-30",
    "--fov",
    "3.5deg",
];
const SITE: &[&str] = &["--mpc", "X05"];
const SHELLS: &[&str] = &["--shells", "oneweb"];
const HEADER: &str = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\n";

fn run(arguments: &[&[&str]]) -> (i32, String, String) {
    let output = Command::new(STREAKCAST).env("STREAKCAST_NO_HOME", "1").args(arguments.concat()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Checks that a run fails with exit code 2, one error line that contains every part, and no standard output.
#[track_caller]
fn fails(arguments: &[&[&str]], parts: &[&str]) {
    let (code, stdout, stderr) = run(arguments);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    let errors: Vec<&str> = stderr.lines().filter(|line| !line.starts_with("warning: ")).collect();
    assert_eq!(errors.len(), 1, "{stderr}");
    assert!(errors[0].starts_with("error: "), "{stderr}");
    for part in parts {
        assert!(errors[0].contains(part), "'{part}' is not in: {}", errors[0]);
    }
}

fn file(folder: &TempDir, name: &str, bytes: &[u8]) -> String {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path.display().to_string()
}

fn flag(schedule: &str) -> Vec<&str> {
    [&["flag", "--schedule", schedule, "--fov", "3.5deg"], SITE, SHELLS].concat()
}

/// CSV on a terminal, which `script` of util-linux provides, has no control characters; CSV in a file has them.
#[cfg(target_os = "linux")]
#[test]
fn control_characters_are_escaped_on_terminals() {
    let folder = TempDir::new().unwrap();
    let text = format!("{HEADER}\u{1b}[31mred,2026-08-14T23:30:00Z,30,217,-30\n");
    let schedule = file(&folder, "night.csv", text.as_bytes());
    let flags = [flag(&schedule), vec!["--format", "csv", "--quiet"]].concat();
    let (code, piped, stderr) = run(&[&flags]);
    assert!(code == 0 && piped.contains("\u{1b}[31mred"), "{stderr}{piped}");
    let command = format!("{STREAKCAST} {}", flags.join(" "));
    let Ok(shown) = Process::new("script").args(["--quiet", "--return", "--command", &command, "/dev/null"]).output()
    else {
        eprintln!("*** SKIPPED control_characters_are_escaped_on_terminals: no program `script` ***");
        return;
    };
    let shown = String::from_utf8(shown.stdout).unwrap();
    assert!(shown.contains("\\u{1b}[31mred") && !shown.contains('\u{1b}'), "{shown:?}");
}

#[test]
fn an_output_never_replaces_an_input_or_another_output() {
    let folder = TempDir::new().unwrap();
    let text = format!("{HEADER}a,2026-08-14T23:30:00Z,30,217,-30\n");
    let schedule = file(&folder, "night.csv", text.as_bytes());
    // Another name of the same file.
    let link = folder.path().join("link.csv").display().to_string();
    fs::hard_link(&schedule, &link).unwrap();
    let same = folder.path().join(".").join("night.csv").display().to_string();
    let config = file(&folder, "night.toml", b"elements = [\"night.csv\"]\n");
    let new = folder.path().join("new.csv").display().to_string();
    let flags = flag(&schedule);
    let input: &[&str] = &["is also an input", "allowed: another file"];
    fails(&[&flags, &["-o", &schedule]], input);
    fails(&[&flags, &["-o", &same]], input);
    let model = file(&folder, "m.json", b"{}");
    fails(&[&flags, &["--model", &format!("oneweb={model}"), "-o", &model]], input);
    fails(&[&["windows", "--targets", &schedule, "--night", "2026-08-14", "-o", &schedule], SITE, SHELLS], input);
    fails(&[&["forecast", "--night", "2026-08-14", "--config", &config, "-o", &schedule], SITE], input);
    fails(&[&["forecast", "--night", "2026-08-14", "--config", &config, "-o", &config], SITE], input);
    let forecast: &[&str] = &["forecast", "--night", "2026-08-14", "-o", &new, "--light-curves", &new];
    fails(&[forecast, SITE, SHELLS], &["new.csv is also another output", "allowed: another file"]);
    assert_eq!(fs::read_to_string(&schedule).unwrap(), text);
    assert!(!Path::new(&new).exists());
    // Files whose names follow from those of others.
    let derived = file(&folder, "new.streaks.csv", text.as_bytes());
    let mut annotate = flag(&derived);
    annotate[0] = "annotate";
    fails(
        &[&annotate, &["-o", &new]],
        &["new.streaks.csv, which is the schedule", "allowed: an output of another name"],
    );
    let data = file(&folder, "night-data.ecsv", text.as_bytes());
    let picture = folder.path().join("night.png").display().to_string();
    let plot = ["plot", "night", "--schedule", &data, "-o", &picture];
    fails(&[&plot, SITE, SHELLS, &["--fov", "3deg"]], &["night-data.ecsv is also an input"]);
    assert_eq!([&derived, &data].map(|path| fs::read_to_string(path).unwrap()), [text.clone(), text.clone()]);
    // A hard link is another file, which is replaced as a whole.
    assert_eq!(run(&[&flags, &["-o", &link]]).0, 0);
    assert_eq!(fs::read_to_string(&schedule).unwrap(), text);
}

/// Parquet is not supported: a schedule gives an error that names a converter, and no other format is written under
/// such a name.
#[test]
fn parquet_is_rejected_without_a_file() {
    let folder = TempDir::new().unwrap();
    let schedule = file(&folder, "s.csv", format!("{HEADER}a,2026-08-14T23:30:00Z,30,217,-30\n").as_bytes());
    for name in ["out.parquet", "OUT.PARQUET"] {
        let out = folder.path().join(name);
        fails(&[&flag(&schedule), &["-o", out.to_str().unwrap()]], &["is not a format; allowed: .csv, .ecsv"]);
        let mut annotate = flag(&schedule);
        annotate[0] = "annotate";
        fails(&[&annotate, &["-o", out.to_str().unwrap()]], &["has the extension of another format; allowed: .csv"]);
        assert!(!out.exists());
    }
    let schedule = file(&folder, "s.parquet", b"PAR1\x15\x04\x15\x10PAR1");
    fails(&[&flag(&schedule)], &["s.parquet: Parquet file; convert it to CSV first", "pandas.read_parquet"]);
}

/// An argument that is not UTF-8 is reported like any other unknown argument.
#[cfg(unix)]
#[test]
fn an_argument_that_is_not_utf8_gives_one_line() {
    use std::os::unix::ffi::OsStrExt;
    let word = std::ffi::OsStr::from_bytes(b"fore\xff");
    let output = Command::new(STREAKCAST).env("STREAKCAST_NO_HOME", "1").arg(word).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.starts_with("error: ") && stderr.contains("allowed: passes, flag"), "{stderr}");
}

/// Errors for unknown values list the allowed ones, and quote numbers as typed.
#[test]
fn errors_for_unknown_values_list_the_allowed_ones() {
    fails(&[&["plto"]], &["'plto'", "allowed: passes, flag, annotate"]);
    fails(&[&["passes", "--lon", "2.35N"]], &["invalid value '2.35N' for '--lon <DEG>': not a longitude"]);
    fails(&[&["passes", "--threads", "two"]], &["'two' for '--threads <N>': allowed: a whole number of 0 or more"]);
    fails(&[&["fit", "rnu"]], &["'rnu'", "reduce", "run"]);
    fails(&[&["plot", "plot"]], &["'plot'", "allowed: night, field"]);
    fails(&[&["plot", "nite"]], &["'nite'", "allowed: night, field, light-curve, sky-chart, sky-rate"]);
    fails(
        &[&["serve", "--schedule", "x", "--bind", "nonsense"]],
        &["'nonsense' for '--bind", "allowed: an IP address and a port of 0 to 65535, for example 127.0.0.1:8642"],
    );
    fails(&[&["map", "sky", "--model", "v1.5", "--sun-altitude-deg", "120"]], &["120 deg; allowed: -90 to 90 deg"]);
}

#[test]
fn options_without_effect_on_statistics() {
    let night: &[&str] = &["--night", "2024-08-14"];
    for option in [["--min-probability", "0.5"], ["--rotation", "10"]] {
        fails(&[&["statistics"], night, SHELLS, SITE, &option], &[option[0], "no effect on statistics"]);
    }
    let orbit: &[&str] = &["--observer-norad", "20580"];
    fails(&[&["forecast"], night, SHELLS, orbit], &["--observer-norad cannot be used", "horizon"]);
    for verb in ["statistics", "windows"] {
        fails(&[&[verb], night, SHELLS, orbit], &["--night is for a site; allowed for a telescope in orbit: --start"]);
    }
}

#[test]
fn missing_sites_and_satellites() {
    fails(&[POINTING, SHELLS, &["--site", "Rubin Observatry at Mars"]], &["unknown site", "similar names: "]);
    fails(&[POINTING, SHELLS, &["--site", "Moon"]], &["unknown site \"Moon\"", "streakcast sites", "--lat"]);
    fails(&[POINTING, SHELLS, &["--mpc", "ZZZ"]], &["unknown MPC observatory code \"ZZZ\""]);
    fails(&[POINTING, SHELLS], &["missing site; specify --site NAME, --mpc CODE"]);
    fails(&[POINTING, SHELLS, &["--lat", "95", "--lon", "0"]], &["95", "-90"]);
    fails(&[POINTING, SITE], &["missing satellites", "--elements FILE", "--shells NAME, for example starlink-gen1"]);
    fails(&[POINTING, SITE, &["--shells", "starlnk"]], &["starlnk", "starlink-gen1"]);
}

#[test]
fn invalid_element_files() {
    let folder = tempfile::tempdir().unwrap();
    let elements = |path: &str, parts: &[&str]| fails(&[POINTING, SITE, &["--elements", path]], parts);
    elements(&file(&folder, "empty.tle", b""), &["empty.tle", "is empty"]);
    // Folders are read: all files in them, but not subfolders.
    elements(&folder.path().display().to_string(), &["empty.tle is empty"]);
    let inner = folder.path().join("inner");
    std::fs::create_dir_all(inner.join("of_other_days")).unwrap();
    elements(&inner.display().to_string(), &["inner contains no files; allowed: files of element sets"]);
    elements("/nowhere/at/all.tle", &["/nowhere/at/all.tle"]);
    elements(&file(&folder, "noise.tle", b"this is not\nan element set\n"), &["noise.tle", "TLE"]);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(&b"1 25544U 98067A\n".repeat(400)).unwrap();
    let packed = packed.finish().unwrap();
    elements(&file(&folder, "cut.tle.gz", &packed[..packed.len() / 2]), &["cut.tle.gz", "invalid gzip"]);
}

#[test]
fn invalid_times_and_angles() {
    let with = |change: &[&str], parts: &[&str]| {
        let others = POINTING[1..].chunks(2).filter(|pair| pair[0] != change[0]).flatten();
        let arguments: Vec<&str> = POINTING[..1].iter().chain(others).chain(change).copied().collect();
        fails(&[&arguments, SITE, SHELLS], parts);
    };
    with(&["--start", "2024-08-14T03:30:00"], &["has no time scale", "37 s", "--time-scale"]);
    with(&["--start", "60536.1"], &["has no time scale", "37 s"]);
    with(&["--start", "1850-01-01T00:00:00Z"], &["1957", "2099"]);
    with(&["--start", "3000-01-01T00:00:00Z"], &["1957", "2099"]);
    with(&["--start", "2024-08-14T23:59:60Z"], &["only where a leap second was inserted"]);
    with(&["--start", "yesterday"], &["invalid time 'yesterday'", "ISO 8601"]);
    with(&["--exposure", "30"], &["exposure is 30, without a unit", "30s"]);
    with(&["--exposure", "-30s"], &["exposure is -30 s; allowed: above 0 s, at most 86400 s"]);
    with(&["--fov", "0deg"], &["fov is 0 deg; allowed: above 0 deg, at most 180 deg"]);
    with(&["--ra", "nan"], &["nan", "right ascension"]);
    with(&["--dec", "inf"], &["inf", "declination"]);
    with(&["--fov", "3.5"], &["fov is 3.5, without a unit", "3.5deg"]);
    with(&["--ra", "25h"], &["25h", "right ascension"]);
    with(&["--dec", "-91"], &["-91", "declination"]);
    with(&["--dec", "85"], &["below the horizon", "allowed: 0 deg or more"]);
    fails(
        &[&["passes", "--exposure", "30s", "--ra", "0", "--dec", "0", "--fov", "1deg"], SITE, SHELLS],
        &["missing start of the exposure; specify --start TIME"],
    );
    fails(
        &[&["passes", "--start", "2024-08-14T03:30:00Z", "--ra", "0", "--dec", "0", "--fov", "1deg"], SITE, SHELLS],
        &["missing exposure time; specify --exposure TIME"],
    );
}

#[test]
fn invalid_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = file(&folder, "s.csv", format!("{HEADER}1,2024-08-14T03:30:00Z,30,280,-30\n").as_bytes());
    for (name, allowed) in [
        ("rotation", "-360 to 360 deg"),
        ("limit-mag", "-30 to 40 mag"),
        ("min-probability", "above 0, at most 1"),
        ("lat", "-90 to 90 deg"),
        ("lon", "-180 to 360 deg"),
        ("height", "-11000 to 100000 m"),
    ] {
        for (typed, shown) in [("nan", "NaN"), ("inf", "inf"), ("1e300", "1e300")] {
            let typed = format!("--{name}={typed}");
            let parts = [&*format!("error: {name} is {shown}"), &*format!("; allowed: {allowed}")];
            fails(&[POINTING, SITE, SHELLS, &[&typed]], &parts);
            fails(&[&flag(&schedule), &[&typed]], &parts);
        }
    }
    fails(&[POINTING, SITE, SHELLS, &["--samples", "nan"]], &["nan", "--samples"]);
}

#[test]
fn invalid_schedules() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = |name: &str, bytes: &[u8], parts: &[&str]| fails(&[&flag(&file(&folder, name, bytes))], parts);
    schedule("empty.csv", b"", &["empty.csv is empty"]);
    schedule("blank.csv", b"\n \n", &["blank.csv is empty"]);
    schedule("header.csv", HEADER.as_bytes(), &["columns but no exposures"]);
    schedule(
        "short.csv",
        b"exposure_id,start_utc\n1,2024-08-14T03:30:00Z\n",
        &["missing duration_s, ra_deg, dec_deg", "found exposure_id, start_utc", "allowed: exposure_id"],
    );
    schedule("noise.bin", &[0xff, 0x00, 0x81, 0x7f], &["noise.bin"]);
    schedule("rows.json", b"{\"visits\": []}", &["without an array 'exposures'"]);
    schedule("cut.json", b"[{\"exposure_id\": ", &["cut.json: line 1"]);
    schedule("none.json", b"[]", &["none.json is empty"]);
    let twice = b"exposure_id,start_utc,duration_s,ra_deg,dec_deg,ra_deg\n1,2024-08-14T03:30:00Z,30,280,-30,10\n";
    schedule("twice.csv", twice, &["twice.csv: column ra_deg occurs twice; allowed: once"]);
    let open = b"exposure_id,start_utc,duration_s,ra_deg,dec_deg\na,\"2024-08-14T03:30:00Z,30,280,-30\nb,2024-08-14T03:31:00Z,30,280,-30\n";
    schedule("open.csv", open, &["open.csv, line 2: the cell that begins with a quotation mark has no other one"]);
    let single = b"# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n# - {name: exposure_id, datatype: string}\n# - {name: start_mjd_utc, datatype: float32}\n# - {name: duration_s, datatype: float32}\n# - {name: ra_deg, datatype: float32}\n# - {name: dec_deg, datatype: float32}\nexposure_id,start_mjd_utc,duration_s,ra_deg,dec_deg\na,60536.145,30,280,-30\n";
    schedule("single.ecsv", single, &["single.ecsv: column start_mjd_utc has single precision", "float64 in ECSV"]);
    let two = b"exposure_id,start_utc,duration_s,ra_rad,dec_deg,ra_arcmin\n1,2024-08-14T03:30:00Z,30,1,-30,99\n";
    schedule("two.csv", two, &["two.csv: columns ra_rad and ra_arcmin have the same quantity; allowed: one of them"]);
    schedule("page.html", b"<html></html>", &["XML or HTML", "allowed: opsim SQLite"]);
    schedule("cut.db", b"SQLite format 3\0 and then nothing", &["cut.db"]);
    fails(&[&flag(&folder.path().display().to_string())], &["is a directory"]);
    fails(&[&flag("/nowhere.csv")], &["/nowhere.csv"]);
    let mjd = b"exposure_id,start_mjd,duration_s,ra_deg,dec_deg\n1,60536.14,30,280,-30\n";
    schedule("mjd.csv", mjd, &["the time scale of column start_mjd is missing", "--time-scale utc, tai or tt", "37 s"]);
    let early = format!("{HEADER}1,1850-08-14T03:30:00Z,30,280,-30\n");
    // Rows that cannot be judged are part of the result and not an error.
    let (code, stdout, stderr) = run(&[&flag(&file(&folder, "early.csv", early.as_bytes())), &["--format", "json"]]);
    assert_eq!(code, 0, "{stderr}");
    let warned = ": 1 of 1 exposure cannot be judged; first row 1, exposure 1: ";
    for part in [warned, "outside the years of the ephemeris", "1957 to 2099"] {
        assert!(stderr.contains(part), "'{part}' is not in: {stderr}");
    }
    let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(answer["flags"][0]["verdict"], "invalid");
    assert!(answer["provenance"]["schedule"]["first_start_utc"].is_null());

    let low = format!("{HEADER}1,2024-08-14T03:30:00Z,30,280,85\n2,2024-08-14T03:31:00Z,30,280,85\n");
    let (code, _, stderr) = run(&[&flag(&file(&folder, "low.csv", low.as_bytes()))]);
    assert_eq!(code, 0, "{stderr}");
    let warned = ": 2 of 2 exposures cannot be judged; first row 1, exposure 1: ";
    assert!(stderr.contains(warned) && stderr.contains("horizon"), "{stderr}");
}

#[test]
fn unknown_arguments() {
    let folder = tempfile::tempdir().unwrap();
    fails(&[POINTING, SITE, SHELLS, &["--format", "xlsx"]], &["'xlsx'", "table, csv, ecsv, json, jsonl"]);
    fails(&[POINTING, SITE, SHELLS, &["--band", "q"]], &["unknown band \"q\""]);
    fails(&[POINTING, SITE, SHELLS, &["--telescope", "hubble"]], &["telescope is \"hubble\"", "rubin"]);
    fails(&[POINTING, SITE, SHELLS, &["--time-scale", "ut"]], &["time scale 'ut'", "utc, tai, tt"]);
    fails(&[POINTING, SITE, SHELLS, &["--threads", "0"]], &["threads is 0; allowed: 1 to 1024"]);
    fails(&[POINTING, SITE, SHELLS, &["--threads", "100000"]], &["threads is 100000; allowed: 1 to 1024"]);
    fails(
        &[POINTING, SITE, SHELLS, &["--min-probability", "1.5"]],
        &["min-probability is 1.5; allowed: above 0, at most 1"],
    );
    fails(&[POINTING, SITE, SHELLS, &["--field", "x.json"]], &["--fov and --field exclude each other"]);
    fails(&[POINTING, SITE, SHELLS, &["--samples", "100001"]], &["samples is 100001; allowed: 0 to 100000"]);
    fails(&[POINTING, SITE, SHELLS, &["--nonsense"]], &["--nonsense"]);
    fails(&[&["passses"]], &["passses", "passes"]);
    let config = file(&folder, "c.toml", b"limitmag = 7\n");
    fails(&[POINTING, SITE, SHELLS, &["--config", &config]], &["c.toml", "limitmag"]);
    let policy = file(&folder, "p.toml", b"limit = 7\n");
    let schedule = file(&folder, "s.csv", format!("{HEADER}1,2024-08-14T03:30:00Z,30,280,-30\n").as_bytes());
    fails(&[&flag(&schedule), &["--policy", &policy]], &["p.toml: line 1: unknown key 'limit'", "limit_mag"]);
    let (_, _, stderr) = run(&[&flag(&schedule), &["--policy", &policy]]);
    assert_eq!(stderr.matches("max_delay_s").count(), 1, "{stderr}");
    #[cfg(unix)]
    let frame = file(&folder, "s.toml", b"columns = 64\nrow = 64\n");
    #[cfg(unix)]
    fails(
        &[&[
            "inject",
            "--synthetic",
            &frame,
            "--random-streaks",
            "1",
            "--magnitude",
            "5",
            "--seeing",
            "1arcsec",
            "-o",
            "x.fits",
        ]],
        &["s.toml: line 2: unknown key 'row'; allowed: columns"],
    );
    let policy = file(&folder, "r.toml", b"margin_s = -1\n");
    fails(&[&flag(&schedule), &["--policy", &policy]], &["r.toml: margin_s is -1; allowed: 0 to 3600 s"]);
    for (verb, expected) in [
        ("passes", "probability of each crossing to be brighter"),
        ("flag", "the verdict avoid"),
        ("annotate", "the verdict avoid"),
    ] {
        let (_, help, _) = run(&[&[verb, "-h"]]);
        let (_, after) = help.split_once("--limit-mag").unwrap();
        let own = after.split(" --").next().unwrap_or_default();
        let own = own.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(own.contains(expected), "{verb}: {own}");
    }
    fails(&[&flag(&schedule), &["--fail-on", "clear"]], &["clear", "streaked", "avoid"]);
    fails(&[&["model", "show", "nonsense"]], &["unknown model 'nonsense'", "starlink-v1.5"]);
    fails(&[&["model", "pressure", "oneweb", "--mass-kg", "150"]], &["prior:oneweb has no panels", "allowed"]);
    fails(&[&["model", "pressure", "starlink-v1.5", "--mass-kg", "-1"]], &["mass is -1 kg", "0.01 to 1000000"]);
    let pressure = ["model", "pressure", "starlink-v1.5", "--mass-kg", "295", "--sun-latitude-deg"];
    fails(&[&pressure, &["0", "91"]], &["latitude of the Sun is 91 deg", "-90 to 90"]);
    fails(&[&["model", "check", &config]], &["c.toml"]);
    fails(&[&["model", "check", "--data", "no-such-folder"]], &["no photometry in no-such-folder", "pomenis"]);
}

#[test]
fn a_failure_leaves_no_new_file_and_keeps_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = file(&folder, "s.csv", b"exposure_id,start_utc\n1,nan\n");
    let new = folder.path().join("new.csv").display().to_string();
    fails(&[&flag(&schedule), &["-o", &new]], &["missing duration_s"]);
    assert!(!Path::new(&new).exists());
    let old = file(&folder, "old.csv", b"mine");
    fails(&[&flag(&schedule), &["-o", &old]], &["missing duration_s"]);
    assert_eq!(fs::read(&old).unwrap(), b"mine");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    fails(&[POINTING, SITE, SHELLS, &["-o", &folder.path().display().to_string()]], &["is a directory"]);
    fails(
        &[POINTING, SITE, SHELLS, &["-o", "/dev/null/at/all.csv"]],
        &["cannot write /dev/null/at/all.csv: folder /dev/null"],
    );
    // The output folder is checked before the schedule is read.
    fails(&[&flag("/nowhere.csv"), &["-o", "/dev/null/at/all.csv"]], &["cannot write /dev/null/at/all.csv"]);
    let (_, _, stderr) = run(&[POINTING, SITE, SHELLS, &["-o", "/dev/null/at/all.csv"]]);
    assert!(!stderr.contains(".part"), "{stderr}");
}

#[test]
fn invalid_rows_are_kept_with_a_reason_and_the_others_are_evaluated() {
    let folder = tempfile::tempdir().unwrap();
    let rows = [
        ("ok", "2024-08-14T03:30:00Z", "30", "280", "-30", ""),
        ("nan", "2024-08-14T03:30:00Z", "30", "NaN", "-30", "right ascension is NaN"),
        ("below", "2024-08-14T03:30:00Z", "30", "280", "80", "below the horizon"),
        ("dec", "2024-08-14T03:30:00Z", "30", "280", "-91", "declination is -91; allowed: -90 to 90"),
        ("ra", "2024-08-14T03:30:00Z", "30", "361", "-30", "right ascension is 361"),
        ("long", "2024-08-14T03:30:00Z", "1e9", "280", "-30", "duration is 1000000000"),
        ("negative", "2024-08-14T03:30:00Z", "-1", "280", "-30", "duration is -1"),
        (
            "text",
            "2024-08-14T03:30:00Z",
            "thirty",
            "280",
            "-30",
            "duration 'thirty' is not a number; allowed: a decimal number such as 30.5, above 0 to",
        ),
        ("gap", "", "30", "280", "-30", "start is missing"),
        ("early", "1850-01-01T00:00:00Z", "30", "280", "-30", "outside the years of the ephemeris"),
        ("", "2024-08-14T03:30:00Z", "30", "280", "-30", ""),
    ];
    let mut text = HEADER.to_owned();
    for (id, start, duration, ra, dec, _) in rows {
        text += &format!("{id},{start},{duration},{ra},{dec}\n");
    }
    text += "short,2024-08-14T03:30:00Z\n";
    let schedule = file(&folder, "s.csv", text.as_bytes());
    let (code, stdout, stderr) = run(&[&flag(&schedule), &["--format", "json"]]);
    assert_eq!(code, 0, "{stderr}");
    let warning = ": 10 of 12 exposures cannot be judged; first row 2, exposure nan: right ascension is NaN";
    assert!(stderr.contains(warning), "{stderr}");
    // The row without an identifier and the short one.
    assert!(stderr.contains("2 exposures have no exposure_id, or a wrong number of cells; the results name them by their rows, the first as row 11"), "{stderr}");
    let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let flags = answer["flags"].as_array().unwrap();
    assert_eq!(flags.len(), rows.len() + 1);
    for (flag, (id, .., reason)) in flags.iter().zip(rows) {
        let judged = reason.is_empty();
        assert_eq!(flag["verdict"] == "invalid", !judged, "{flag}");
        assert_eq!(flag["exposure_id"], if id.is_empty() { "row 11" } else { id });
        if !judged {
            assert!(flag["reasons"][0].as_str().unwrap().contains(reason), "{flag}");
            assert!(flag["p_any"].is_null() && flag["next_clear_start_utc"].is_null(), "{flag}");
        }
    }
    assert_eq!(flags[rows.len()]["verdict"], "invalid");
    assert!(flags[rows.len()]["reasons"][0].as_str().unwrap().contains("2 cells but the header has 5"));
}

#[test]
fn suspicious_schedules_give_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let header = "exposure_id,start_utc,duration_s,ra_deg,dec_deg,band\n";
    let rows = "a,2024-08-14T03:30:00Z,30,280,-30,g\na,2024-08-14T03:31:00Z,30,280,-30,q\nb,2024-08-14T03:32:00Z,30,280,-30,\n";
    let schedule = file(&folder, "s.csv", format!("{header}{rows}").as_bytes());
    let policy = file(&folder, "p.toml", b"limit_mag = {g = 7.0}\n");
    let (code, _, stderr) = run(&[&flag(&schedule), &["--policy", &policy]]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("warning: 1 exposure has the exposure_id of an earlier one"), "{stderr}");
    assert!(
        stderr.contains("warning: limit_mag of the policy has no value for band none, q and no default"),
        "{stderr}"
    );
    let (_, _, quiet) = run(&[&flag(&schedule), &["--policy", &policy, "--quiet"]]);
    assert_eq!(quiet, "");
    let as_text = file(&folder, "text.toml", b"limit_mag = 'g=7'\n");
    let of_text = run(&[&flag(&schedule), &["--policy", &as_text]]);
    assert_eq!(of_text.2.replace("text.toml", "p.toml"), stderr);
    let wrong = file(&folder, "wrong.toml", b"margin_s = 3\nlimit_mag = 'g=7,y'\n");
    fails(&[&flag(&schedule), &["--policy", &wrong]], &["wrong.toml", "line 2", "'g=7,y'", "g=7,y=5,default=6"]);
    let (_, _, stderr) = run(&[&flag(&schedule), &["--limit-mag", "G=5,default=7"]]);
    assert!(stderr.contains("limit_mag of band G has no effect: the exposures have the band g"), "{stderr}");
}

#[test]
fn a_closed_output_pipe_is_not_an_error() {
    let mut child = Process::new(STREAKCAST)
        .args(["sites", "--format", "csv"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The pipe is closed before anything is read, so the first write fails.
    drop(child.stdout.take());
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!((child.wait().unwrap().code(), stderr.as_str()), (Some(0), ""));
}

#[test]
fn elements_a_year_old_give_a_warning_and_a_large_sigma() {
    let Some(data) = crate::common::data_dir() else { return };
    let elements = data.join("tle/active/starlink_2023-10-16.txt").display().to_string();
    let year_later = [
        "passes",
        "--start",
        "2024-10-16T00:30:00Z",
        "--exposure",
        "60s",
        "--ra",
        "300",
        "--dec",
        "-30",
        "--fov",
        "40deg",
    ];
    let (code, stdout, stderr) =
        run(&[&year_later, SITE, &["--elements", &elements, "--format", "json", "--include-dark"]]);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    let warning = stderr.lines().find(|line| line.contains("more than 14 days")).unwrap_or_default();
    assert!(
        warning.starts_with("warning: ")
            && warning.contains("of 4,870 element sets")
            && warning.contains("(the farthest by "),
        "{stderr}"
    );
    // No pass is listed to the second whose time is not known to the minute.
    let error = stderr.lines().last().unwrap_or_default();
    assert!(error.starts_with("error: elements 36") && error.contains("unknown; specify elements"), "{stderr}");
}

#[test]
fn element_files_with_invalid_records_are_read_and_rejects_counted() {
    let Some(data) = crate::common::data_dir() else { return };
    for entry in fs::read_dir(data.join("tle/messy")).unwrap() {
        let path = entry.unwrap().path().display().to_string();
        let (code, _, stderr) = run(&[POINTING, SITE, &["--elements", &path]]);
        // The elements of some files are years from the exposure.
        let is_known = |line: &str| {
            line.starts_with("warning: ")
                || line == "no passes"
                || line.contains("unknown; specify elements of about the date")
        };
        assert!(code < 2 || stderr.contains("unknown; specify elements"), "{path}: {stderr}");
        assert!(stderr.lines().all(is_known), "{path}: {stderr}");
    }
}

#[test]
fn misspelt_columns_are_suggested_and_other_encodings_named() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = |name: &str, bytes: &[u8], parts: &[&str]| fails(&[&flag(&file(&folder, name, bytes))], parts);
    let misspelt = b"Exposure ID,start_utc,duraton_s,RA_deg,band\n1,2024-08-14T03:30:00Z,30,280,r\n";
    schedule(
        "m.csv",
        misspelt,
        &["exposure_id (rename Exposure ID?)", "duration_s (rename duraton_s?)", "ra_deg (rename RA_deg?), dec_deg;"],
    );
    // Byte 0xf3 is ó in Latin-1.
    let latin = [HEADER.as_bytes(), b"Pach\xf3n,2024-08-14T03:30:00Z,30,280,-30\n"].concat();
    schedule("l.csv", &latin, &["invalid UTF-8 in line 2", "Latin-1", "iconv -f LATIN1 -t UTF-8"]);
    let elements = file(&folder, "empty.xml", b"<ndm><omm id=\"a\"><body><segment/></body></omm></ndm>");
    fails(&[POINTING, SITE, &["--elements", &elements]], &["OMM XML", "this message contains no elements"]);
}

#[test]
fn an_unwritable_annotation_is_rejected_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    // The schedule does not exist either, but the error is that of the output folder.
    let below_a_file = file(&folder, "file", b"") + "/out.csv";
    fails(
        &[&["annotate", "--schedule", "/nowhere.csv", "-o", &below_a_file, "--fov", "1deg"], SITE, SHELLS],
        &["file/out.csv", "cannot"],
    );
    let (_, help, _) = run(&[&["annotate", "--help"]]);
    assert!(help.contains("Schedule: opsim SQLite, ConsDB or ObsPlan exports, CSV"), "{help}");
}

#[test]
fn a_time_scale_of_the_configuration_yields_to_the_column() {
    let folder = tempfile::tempdir().unwrap();
    let row = "1,60536.1,30,280,-30\n";
    let named =
        file(&folder, "n.csv", format!("exposure_id,start_mjd_utc,duration_s,ra_deg,dec_deg\n{row}").as_bytes());
    let bare = file(&folder, "b.csv", format!("exposure_id,start_mjd,duration_s,ra_deg,dec_deg\n{row}").as_bytes());
    let config = file(&folder, "c.toml", b"time_scale = 'tai'\n");
    let start = |schedule: &str, more: &[&str]| {
        let (code, stdout, stderr) = run(&[&flag(schedule), &["--format", "json"], more]);
        assert_eq!(code, 0, "{stderr}");
        let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
        answer["provenance"]["schedule"]["first_start_utc"].as_str().unwrap()[14..19].to_owned()
    };
    assert_eq!(start(&named, &["--config", &config]), "24:00");
    assert_eq!(start(&bare, &["--config", &config]), "23:23");
    assert_eq!(start(&bare, &["--config", &config, "--time-scale", "utc"]), "24:00");
    fails(&[&flag(&named), &["--time-scale", "tai"]], &["start_mjd_utc is in UTC", "--time-scale is TAI"]);
}

#[test]
fn invalid_rows_need_no_epoch() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = file(&folder, "s.csv", format!("{HEADER}1,2024-08-14T03:30:00Z,30,280,nan\n").as_bytes());
    let (code, stdout, stderr) = run(&[&flag(&schedule), &["--format", "json"]]);
    assert_eq!(code, 0, "{stderr}");
    let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(answer["flags"][0]["verdict"], "invalid");
    let provenance = answer["provenance"].as_object().unwrap();
    assert!(provenance["schedule"]["first_start_utc"].is_null());
    for nothing in ["earth_orientation", "shells", "satellites", "models"] {
        assert!(!provenance.contains_key(nothing), "{nothing}");
    }
}

#[test]
fn limits_of_the_cost_need_a_telescope() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = file(&folder, "s.csv", format!("{HEADER}1,2024-08-14T03:30:00Z,30,280,-30\n").as_bytes());
    let policy = file(&folder, "p.toml", b"max_cost_s = 1\n");
    fails(&[&flag(&schedule), &["--policy", &policy]], &["missing telescope for max_cost_s", "--telescope"]);
    fails(&[&flag(&schedule), &["--bright-share", "0.3"]], &["missing telescope for bright-share", "--telescope"]);
    fails(
        &[&flag(&schedule), &["--telescope", "rubin", "--bright-share=-1"]],
        &["bright-share is -1; allowed: 0 to 100"],
    );
    let policy = file(&folder, "q.toml", b"saturation_mag = 4\n");
    fails(&[&flag(&schedule), &["--policy", &policy]], &["unknown key 'saturation_mag'", "max_cost_s"]);
    fails(&[&flag(&schedule), &["--limit-mag", "g=7,g=6"]], &["band g has two limits in 'g=7,g=6'"]);
}

/// Very long exposures are rejected: without a limit, 11.4 million years took 172 GB, and 1e300 s is outside the
/// calendar.
#[test]
fn exposures_of_no_time_and_longer_than_a_day_are_refused() {
    let pointing = [&POINTING[..3], &POINTING[5..]].concat();
    for (exposure, given) in
        [("99999999999h", "359999999996400 s"), ("1e300s", "1e300 s"), ("24.01h", "86436 s"), ("0s", "0 s")]
    {
        let parts = [&format!("exposure is {given}")[..], "allowed: above 0 s, at most 86400 s"];
        fails(&[&pointing, &["--exposure", exposure], SITE, SHELLS], &parts);
    }
    let folder = TempDir::new().unwrap();
    for duration in ["86401", "1e300", "0"] {
        let row = format!("{HEADER}a,2024-08-14T03:30:00Z,{duration},280,-30\n");
        let (code, stdout, _) = run(&[&flag(&file(&folder, "long.csv", row.as_bytes())), &["--format", "csv"]]);
        assert_eq!(code, 0);
        assert!(stdout.contains("invalid") && stdout.contains("allowed: above 0 to 86400"), "{stdout}");
    }
}

/// Deeply nested YAML is rejected: it would overflow the stack of the YAML loader.
#[test]
fn deeply_nested_ecsv_headers_are_refused() {
    let folder = TempDir::new().unwrap();
    let rows = format!("{HEADER}a,2024-08-14T03:30:00Z,30,280,-30\n");
    for marker in ["- ", "? "] {
        let header = |depth| format!("# %ECSV 1.0\n# ---\n# delimiter: ','\n# meta:\n#  {}a\n", marker.repeat(depth));
        let deep = file(&folder, "deep.ecsv", (header(100_000) + &rows).as_bytes());
        fails(&[&flag(&deep)], &["deep.ecsv, line 5", "nested too deeply; allowed: 64 levels"]);
        let shallow = file(&folder, "shallow.ecsv", (header(50) + &rows).as_bytes());
        assert_eq!(run(&[&flag(&shallow)]).0, 0, "{marker}");
    }
}

/// Named pipes and devices are rejected: a pipe without a writer blocks the run, and an endless device fills the
/// memory.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused() {
    let folder = TempDir::new().unwrap();
    let pipe = folder.path().join("pipe").display().to_string();
    assert!(Process::new("mkfifo").arg(&pipe).status().unwrap().success());
    let strict: &[&str] = &["gate", "--strict", "--exposure", "30s", "--ra", "280", "--dec", "-30", "--fov", "3.5deg"];
    for (path, kind) in [(pipe.as_str(), "is a named pipe"), ("/dev/zero", "is a device")] {
        let parts = [path, kind, "allowed: a file"];
        fails(&[&flag(path)], &parts);
        fails(&[POINTING, SITE, &["--elements", path]], &parts);
        fails(&[strict, SITE, &["--elements", path]], &parts);
        fails(&[strict, SITE, SHELLS, &["--eop", path]], &parts);
        fails(&[strict, SITE, SHELLS, &["--config", path]], &parts);
        let clear: &[&str] = &["--ra", "217.5", "--dec=-30", "--limit-mag=-20", "--now", "2024-08-14T23:30:00Z"];
        let gate: &[&str] = &["gate", "--quiet", "--strict", "--exposure", "30s", "--fov", "3.5deg"];
        fails(&[gate, clear, SITE, SHELLS, &["--status-file", path]], &parts);
        let targets: &[&str] = &["gate", "--strict", "--exposure", "30s", "--target", "M31", "--fov", "3.5deg"];
        fails(&[targets, SITE, SHELLS, &["--targets", path]], &parts);
    }
    fails(&[strict, SITE, &["--elements", "/dev/fd/0"]], &["/dev/fd/0 is a stream", "allowed: a file"]);
}

/// The shell passes `<(command)` as the path of an open file descriptor.
#[cfg(unix)]
#[test]
fn a_schedule_can_come_from_a_stream() {
    let row = format!("{HEADER}a,2024-08-14T03:30:00Z,30,280,-30\n");
    for path in ["/dev/stdin", "/dev/fd/0"] {
        let output = Command::new(STREAKCAST)
            .env("STREAKCAST_NO_HOME", "1")
            .args(flag(path))
            .write_stdin(row.clone())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{path}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

/// The file is sparse: its 3 GB occupy no disk space.
#[test]
fn files_above_2_gb_are_refused() {
    let folder = TempDir::new().unwrap();
    let large = file(&folder, "large.txt", b"");
    fs::File::options().write(true).open(&large).unwrap().set_len(3_000_000_000).unwrap();
    let parts = ["large.txt", "more than 2000000000 bytes; allowed: at most 2000000000"];
    fails(&[POINTING, SITE, &["--elements", &large]], &parts);
    fails(&[&flag(&large)], &parts);
    fails(&[POINTING, SITE, SHELLS, &["--eop", &large]], &parts);
}

/// Control characters are escaped on terminals: they could clear the screen or rename the window.
#[test]
fn control_characters_of_files_are_escaped_for_people() {
    let folder = TempDir::new().unwrap();
    let row = format!("{HEADER}a\u{1b}[2J,2024-08-14T03:30:00Z,30\u{9b}\u{7},280,-30\n");
    let schedule = file(&folder, "controls.csv", row.as_bytes());
    let (code, stdout, stderr) = run(&[&flag(&schedule), &["--format", "table"]]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("a\\u{1b}[2J"), "{stdout}");
    assert!(stderr.contains("30\\u{9b}\\u{7}"), "{stderr}");
    assert!(!(stdout + &stderr).contains(|c: char| c.is_control() && c != '\n'));
    // In data formats, cells are not escaped.
    assert!(run(&[&flag(&schedule), &["--format", "csv"]]).1.contains("a\u{1b}[2J"));
    fails(&[POINTING, SITE, &["--shells", "x\u{1b}[2J"]], &["x\\u{1b}[2J"]);
}

/// An exposure whose name begins with `#` is read if the name is quoted, and written so that it can be read again.
/// Without quotation marks it is a comment, of which a warning tells.
#[test]
fn names_that_begin_like_comments() {
    let folder = TempDir::new().unwrap();
    let row = ",2024-08-14T23:30:00Z,30,217,-30\n";
    let text = format!("# ours, not a row\n{HEADER}\"#7\"{row}#8{row}# a remark\n9{row}");
    let schedule = file(&folder, "s.csv", text.as_bytes());
    let flags = folder.path().join("flags.csv").display().to_string();
    let (code, _, stderr) = run(&[&flag(&schedule), &["-o", &flags]]);
    assert_eq!(code, 0, "{stderr}");
    let warning =
        "warning: 1 comment has as many cells as a row: a first cell that begins with # must be in quotation marks";
    assert!(stderr.contains(warning), "{stderr}");
    let (code, stdout, stderr) = run(&[&flag(&flags), &["--format", "json"]]);
    assert!(code == 0 && !stderr.contains("as many cells"), "{stderr}");
    let again: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let ids: Vec<&str> =
        again["flags"].as_array().unwrap().iter().map(|flag| flag["exposure_id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["#7", "9"]);
}

/// Columns that contradict those that are read, or change their meaning, make rows invalid. Julian dates are rounded.
#[test]
fn contradictory_columns_and_other_equinoxes_make_rows_invalid() {
    let folder = TempDir::new().unwrap();
    let row = |id: &str, more: &str| format!("{id},2024-08-14T23:30:00Z,30,217,-30,{more}\n");
    let names = "exposure_id,start_utc,duration_s,ra_deg,dec_deg,exposure_s,start_mjd_tai,equinox,frame,nexp,end_utc\n";
    let rows = [
        ("good", "30,60536.9796,2000,ICRS,1,2024-08-14T23:30:31.4Z", ""),
        ("plain", ",,,,,", ""),
        ("long", "300,,,,,", "duration_s is 30 and exposure_s is 300: they contradict each other"),
        ("late", ",60537.00000,,,,", "start_utc is 2024-08-14T23:30:00Z and start_mjd_tai is 2024-08-14T23:59:23Z"),
        ("old", ",,B1950,,,", "equinox is B1950; allowed: 2000"),
        ("plane", ",,,galactic,,", "frame is galactic; allowed: ICRS"),
        ("many", ",,,,30,", "nexp is 30; allowed: 1"),
        ("turn", "390,,,,,", "duration_s is 30 and exposure_s is 390"),
        ("dark", ",,,17,,", ""),
        ("minute", ",60536.979942,,,,", ""),
        ("gaps", ",,,,,2024-08-14T23:30:39.2Z", ""),
    ];
    let text: String = rows.iter().map(|(id, more, _)| row(id, more)).collect();
    // A start without seconds is rounded to a minute.
    let text = text.replace("minute,2024-08-14T23:30:00Z", "minute,2024-08-14T23:30Z");
    let schedule = file(&folder, "s.csv", format!("{names}{text}").as_bytes());
    let (_, stdout, stderr) = run(&[&flag(&schedule), &["--format", "json"]]);
    let flags: serde_json::Value = serde_json::from_str(&stdout).unwrap_or_else(|_| panic!("{stderr}"));
    for (found, (id, _, expected)) in flags["flags"].as_array().unwrap().iter().zip(rows) {
        let reasons = found["reasons"][0].as_str().unwrap_or_default();
        assert_eq!((found["exposure_id"].as_str(), found["verdict"] == "invalid"), (Some(id), !expected.is_empty()));
        assert!(reasons.starts_with(expected), "{id}: {reasons}");
    }
    let ends = "1 exposure ends at another time than the file states, which may include readout or several snaps: \
                start_utc plus 30 s is 2024-08-14T23:30:30Z (used) and end_utc is 2024-08-14T23:30:39Z";
    assert!(stderr.contains(ends), "{stderr}");
}

/// A pointing that is above the horizon at opening and at closing may set in between; rotations have a range.
#[test]
fn a_pointing_that_sets_and_rises_again_is_below_the_horizon() {
    let folder = TempDir::new().unwrap();
    // For nearly a sidereal day.
    let text = format!(
        "{},rotation_deg\nday,2024-08-14T23:30:00Z,86000,217,-30,0\nshort,2024-08-14T23:30:00Z,30,217,-30,0\n\
         turned,2024-08-14T23:30:00Z,30,217,-30,1e300\n",
        HEADER.trim_end()
    );
    let schedule = file(&folder, "s.csv", text.as_bytes());
    let (code, stdout, stderr) = run(&[&flag(&schedule), &["--format", "json", "--quiet"]]);
    assert_eq!(code, 0, "{stderr}");
    let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let flags = &answer["flags"];
    assert_eq!([&flags[0]["verdict"], &flags[2]["verdict"]], ["invalid", "invalid"], "{flags}");
    assert_ne!(flags[1]["verdict"], "invalid", "{flags}");
    assert!(flags[0]["reasons"][0].as_str().unwrap().contains("below the horizon (altitude -"), "{flags}");
    assert!(flags[2]["reasons"][0].as_str().unwrap().contains("allowed: -360 to 360"), "{flags}");
}
