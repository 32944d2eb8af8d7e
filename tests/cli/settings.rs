//! Settings from flags and from a configuration file: the layer on top that has any of the settings of a question
//! answers it alone, in all verbs.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::cli::{done, json, path, run};

const SATELLITES: &[&str] = &["--shells", "oneweb", "--quiet"];
const SITE: &[&str] = &["--mpc", "X05"];
const EXPOSURE: &[&str] =
    &["passes", "--start", "2024-08-14T03:30:00Z", "--exposure", "30s", "--ra", "280", "--dec=-30"];
const NIGHT: &[&str] = &["--night", "2024-08-14"];

/// Writes `obs.toml` and returns the flag that reads it.
fn config(folder: &TempDir, text: &str) -> [String; 2] {
    fs::write(folder.path().join("obs.toml"), text).unwrap();
    ["--config".to_owned(), path(folder, "obs.toml")]
}

fn run_with(verb: &[&[&str]], config: &[String; 2]) -> (i32, String, String) {
    run(&[&verb.concat(), &[config[0].as_str(), &config[1]]])
}

#[track_caller]
fn json_with(verb: &[&[&str]], config: &[String; 2]) -> Value {
    json(&[&verb.concat(), &[config[0].as_str(), &config[1]]])
}

/// Checks that a run fails with exit code 2 and one error line that contains every part.
#[track_caller]
fn fails(verb: &[&[&str]], config: &[String; 2], parts: &[&str]) {
    let (code, stdout, stderr) = run_with(verb, config);
    assert_eq!((code, stdout.as_str(), stderr.lines().count()), (2, "", 1), "{stderr}");
    for part in parts {
        assert!(stderr.contains(part), "'{part}' is not in: {stderr}");
    }
}

/// Returns the path of a schedule with one exposure.
fn schedule(folder: &TempDir) -> String {
    let text = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\na,2024-08-14T03:30:00Z,30,280,-30\n";
    fs::write(folder.path().join("night.csv"), text).unwrap();
    path(folder, "night.csv")
}

/// A policy file on the command line replaces all limits of the configuration file; a single limit on the command line
/// replaces only this one.
#[test]
fn a_policy_flag_replaces_the_limits_of_the_file() {
    let folder = TempDir::new().unwrap();
    let schedule = schedule(&folder);
    let policy = path(&folder, "p.toml");
    fs::write(&policy, "limit_mag = 3\n").unwrap();
    let flag = ["flag", "--schedule", &schedule, "--fov", "3deg"];
    let stated = |more: &[&str], text: &str| {
        json_with(&[&flag, SATELLITES, SITE, more], &config(&folder, text))["provenance"]["options"]["policy"].clone()
    };
    let keys = "limit_mag = 9\nmin_probability = 0.1\nblocking = 'any'\nmax_delay = '2min'\n";
    let replaced = stated(&["--policy", &policy], keys);
    assert_eq!((&replaced["limit_mag"], &replaced["min_probability"]), (&3.0.into(), &Value::Null), "{replaced}");
    assert_eq!((&replaced["blocking"], &replaced["max_delay_s"]), (&"avoid".into(), &Value::Null), "{replaced}");
    let one = stated(&["--limit-mag", "6"], "[policy]\nlimit_mag = 3\nmargin_s = 4\nmin_probability = 0.2\n");
    assert_eq!((&one["limit_mag"], &one["margin_s"]), (&6.0.into(), &4.0.into()), "{one}");
    assert_eq!(one["min_probability"], 0.2, "{one}");
    let both = stated(&["--policy", &policy, "--min-probability", "0.3"], keys);
    assert_eq!((&both["limit_mag"], &both["min_probability"]), (&3.0.into(), &0.3.into()), "{both}");
}

#[test]
fn a_site_flag_replaces_the_telescope_in_orbit_of_the_file() {
    let folder = TempDir::new().unwrap();
    let orbit = config(&folder, "observer_norad = 20580\nlimb_height_km = 50\nfov = '3deg'\n");
    let (code, _, stderr) = run_with(&[EXPOSURE, SATELLITES, SITE], &orbit);
    assert!(code < 2, "{stderr}");
    // In one layer, the height of the limb has no effect on a site.
    let both = config(&folder, "mpc = 'X05'\nlimb_height_km = 50\nfov = '3deg'\n");
    fails(&[EXPOSURE, SATELLITES], &both, &["obs.toml", "limb"]);
}

#[test]
fn a_telescope_flag_replaces_the_field_of_the_file() {
    let folder = TempDir::new().unwrap();
    let options = |more: &[&str], text: &str| {
        let (_, stdout, _) =
            run_with(&[EXPOSURE, SATELLITES, SITE, &["--format", "json"], more], &config(&folder, text));
        let document: Value = serde_json::from_str(&stdout).unwrap();
        let options = &document["provenance"]["options"];
        (options["field"].clone(), options["telescope"].clone())
    };
    for text in ["fov = '1deg'\n", "[field]\ncircle_deg = 1.0\n", "fov = '1deg'\ntelescope = 'vst'\n"] {
        let (field, telescope) = options(&["--telescope", "rubin"], text);
        assert_eq!((field, telescope), ("of the telescope".into(), "rubin".into()), "{text}");
    }
    // A field on the command line keeps the telescope of the file.
    let (field, telescope) = options(&["--fov", "2deg"], "telescope = 'rubin'\nfov = '1deg'\n");
    assert_eq!((&field["circle"], telescope), (&"2deg".into(), "rubin".into()));
}

#[test]
fn forecast_reads_include_dark_of_the_file() {
    let folder = TempDir::new().unwrap();
    let forecast: &[&str] = &["forecast", "--start", "2024-08-14T03:30:00Z", "--end", "2024-08-14T03:40:00Z"];
    let count = |text: &str| {
        json_with(&[forecast, SATELLITES, SITE], &config(&folder, text))["passes"].as_array().unwrap().len()
    };
    let flag = json(&[forecast, SATELLITES, SITE, &["--include-dark"]])["passes"].as_array().unwrap().len();
    assert_eq!([count("include_dark = true\n"), count("[forecast]\ninclude_dark = true\n")], [flag, flag]);
    assert!(count("") < flag, "{flag}");
}

#[test]
fn statistics_reads_exposure_limit_and_field_of_the_file() {
    let folder = TempDir::new().unwrap();
    let statistics: &[&str] =
        &["statistics", "--night", "2024-06-21", "--sun-altitude-deg=-18", "--moments", "1", "--min-altitude", "30"];
    let rows = |more: &[&str], text: &str| {
        json_with(&[statistics, SATELLITES, SITE, more], &config(&folder, text))["statistics"].clone()
    };
    let flags = rows(&["--exposure", "300s", "--limit-mag", "6"], "");
    assert!(flags[0]["trails_brighter_than_limit"].as_f64().is_some(), "{flags}");
    assert_eq!(rows(&[], "exposure = '300s'\nlimit_mag = 6\n"), flags);
    assert_eq!(rows(&["--exposure", "300s"], "exposure = '10s'\nlimit_mag = 6\n"), flags);
    let trails = |text: &str| rows(&[], text)[0]["trails_per_exposure"].as_f64().unwrap();
    // A circle on the tangent plane is larger than one on the sky by 1e-4.
    assert!((trails("[field]\ncircle_deg = 2.0\n") / trails("fov = '2deg'\n") - 1.0).abs() < 1e-3);
    let policy = "[policy]\nlimit_mag = 6\n";
    assert_eq!(rows(&["--exposure", "300s"], policy)[0]["brighter_than_limit"], flags[0]["brighter_than_limit"]);
    // The field of Rubin Observatory has an area of 9.62 deg2, as a circle of 3.5 deg.
    assert!((trails("telescope = 'rubin'\n") / trails("fov = '3.5deg'\n") - 1.0).abs() < 0.1);
}

#[test]
fn windows_reads_the_exposure_time_of_the_file() {
    let folder = TempDir::new().unwrap();
    let targets = path(&folder, "targets.csv");
    fs::write(&targets, "name,ra_deg,dec_deg\na,282,-30\n").unwrap();
    let windows: &[&str] = &["windows", "--targets", &targets, "--fov", "1deg"];
    let found = json_with(&[windows, SATELLITES, SITE, NIGHT], &config(&folder, "exposure = '2min'\n"));
    assert_eq!(found["windows"][0]["exposure_s"], 120.0);
}

/// A table of the configuration file has the keys of one verb. It lies above the keys at the top of the file.
#[test]
fn every_flag_is_a_key_in_the_table_of_its_verb() {
    let folder = TempDir::new().unwrap();
    let text = "fov = '1deg'\nshells = ['oneweb']\nmpc = 'X05'\nquiet = true\n\
                [passes]\nfov = '2deg'\nlimit_mag = 5\n\
                [forecast]\nnight = '2024-08-14'\nmax_mag = 6\nmin_culmination = 80\nname = ['ONEWEB']\n\
                [windows]\nmin_altitude = 30\n\
                [plot.night]\ntime_zone = 'America/Santiago'\n";
    let file = config(&folder, text);
    let passes = run_with(&[EXPOSURE, &["--format", "json"]], &file).1;
    assert_eq!(serde_json::from_str::<Value>(&passes).unwrap()["provenance"]["options"]["field"]["circle"], "2deg");
    let forecast = json_with(&[&["forecast"]], &file);
    assert_eq!(forecast["provenance"]["options"]["max_mag"], 6.0);
    assert_eq!(forecast["provenance"]["options"]["night"], "2024-08-14");
    // Flags replace the keys of the table, together with those that they exclude.
    let range: &[&str] = &["forecast", "--start", "2024-08-14T03:30:00Z", "--end", "2024-08-14T03:40:00Z"];
    assert_eq!(json_with(&[range, &["--max-mag", "5"]], &file)["provenance"]["options"]["max_mag"], 5.0);
    let site =
        json_with(&[range, &["--lat", "48", "--lon", "16"]], &config(&folder, &format!("{text}[serve]\nlat = 1\n")));
    assert_eq!(site["provenance"]["site"]["latitude_deg"], 48.0);
}

/// Paths in the table of a verb are relative to the folder of the file, as those at its top.
#[test]
fn paths_in_a_table_of_a_verb() {
    let folder = TempDir::new().unwrap();
    schedule(&folder);
    fs::write(folder.path().join("p.toml"), "limit_mag = 3\n").unwrap();
    let text = "fov = '1deg'\nlimit_mag = 5\n[flag]\nschedule = 'night.csv'\npolicy = 'p.toml'\nshard = '1/1'\n";
    let flags = json_with(&[&["flag"], SATELLITES, SITE], &config(&folder, text));
    assert_eq!(
        (&flags["provenance"]["options"]["policy"]["limit_mag"], &flags["provenance"]["schedule"]["shard"]),
        (&3.0.into(), &"1/1".into())
    );
    // A limit by band is a table in the file and a list on the command line.
    let text = text.replace("shard = '1/1'", "limit_mag = { g = 7, default = 6.5 }");
    let flags = json_with(&[&["flag"], SATELLITES, SITE], &config(&folder, &text));
    assert_eq!(flags["provenance"]["options"]["policy"]["limit_mag"], serde_json::json!({"g": 7.0, "default": 6.5}));
}

#[test]
fn errors_in_keys_name_the_file_and_the_table() {
    let folder = TempDir::new().unwrap();
    let verb: &[&[&str]] = &[EXPOSURE, SATELLITES, SITE, &["--fov", "1deg"]];
    for (text, parts) in [
        ("limb_heigt_km = 3\n", ["limb_heigt_km", "limb_height_km"]),
        ("max_mag = 5\n", ["max_mag", "[forecast]"]),
        ("[flag]\nmax_mag = 5\n", ["max_mag", "[forecast]"]),
        ("[passes]\nlimit_mg = 5\n", ["limit_mg", "limit_mag"]),
        ("[pases]\nlimit_mag = 5\n", ["pases", "passes"]),
        ("[passes]\nlimit_mag = 'x'\n", ["limit-mag", "[passes]"]),
        ("[passes]\nsamples = -1\n", ["samples", "[passes]"]),
        ("[passes]\ninclude_dark = 3\n", ["include_dark is 3", "[passes]"]),
        ("[passes]\nconfig = 'other.toml'\n", ["config", "[passes]"]),
        ("fov = '1deg'\n[field]\ncircle_deg = 1.0\n", ["--fov and --field", "exclude each other"]),
        ("lat = 93\nlon = 1\n", ["lat is 93 deg", "-90 to 90 deg"]),
    ] {
        fails(verb, &config(&folder, text), &[&["obs.toml"], &parts[..]].concat());
    }
}

/// An error in any value of a configuration file names the file, whether a number, a name or a table is wrong.
#[test]
fn errors_in_values_name_the_file() {
    let folder = TempDir::new().unwrap();
    for (text, error) in [
        ("fov = '999deg'", "fov is 999 deg"),
        ("field = { circle_deg = 900 }", "diameter is 900 deg"),
        ("telescope = 'large'", "telescope is \"large\""),
        ("fov = '1deg'\nmpc = 'ZZZ'", "unknown MPC observatory code \"ZZZ\""),
        ("fov = '1deg'\nsite = 'nowhere at all'", "unknown site"),
        ("fov = '1deg'\nshells = 'onewab'", "unknown shells \"onewab\""),
        ("fov = '1deg'\nmodel = 'nonsense'", "unknown model 'nonsense'"),
        ("fov = '1deg'\nthreads = 0", "threads is 0; allowed: 1 to 1024"),
        ("fov = '1deg'\nformat = 'docx'", "unknown format 'docx'"),
    ] {
        fails(&[EXPOSURE], &config(&folder, text), &["configuration", "obs.toml", error]);
    }
}

/// A stream is read once, for the keys at its top.
#[cfg(unix)]
#[test]
fn tables_of_verbs_in_a_stream_are_an_error() {
    let arguments = [EXPOSURE, SATELLITES, SITE, &["--fov", "1deg", "--config", "/dev/stdin"]].concat();
    let code = |text: &str| {
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_streakcast"));
        command.env("STREAKCAST_NO_HOME", "1");
        let output = command.args(&arguments).write_stdin(text.to_owned()).output().unwrap();
        (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    assert!(code("band = 'g'\n").0 < 2);
    let (failed, stderr) = code("[passes]\nsamples = 3\n");
    assert!(failed == 2 && stderr.contains("[passes] is in a stream"), "{stderr}");
}

/// An invalid flag that replaces a key is an error of the command line.
#[test]
fn errors_in_flags_do_not_name_the_file() {
    let folder = TempDir::new().unwrap();
    let verb: &[&[&str]] = &[EXPOSURE, SATELLITES, SITE, &["--fov", "1deg", "--samples", "x"]];
    let (code, _, stderr) = run_with(verb, &config(&folder, "[passes]\nsamples = 3\n"));
    assert!(code == 2 && stderr.contains("'x' for '--samples") && !stderr.contains("obs.toml"), "{stderr}");
}

/// The same threshold applies to near misses and to the verdict `avoid`.
#[test]
fn the_help_of_min_probability_states_its_effect_on_verdicts() {
    let help = done(&[&["flag", "--help"]]);
    let line = help.lines().find(|line| line.contains("--min-probability")).unwrap();
    assert!(line.contains("avoid") && line.contains("0.5"), "{line}");
}

/// The units of a table of targets are those of its columns.
#[test]
fn targets_have_the_units_of_their_columns() {
    let folder = TempDir::new().unwrap();
    let flags: &[&str] = &["windows", "--fov", "1deg", "--min-altitude", "5"];
    let targets = |text: &str| {
        let file = path(&folder, "targets.ecsv");
        fs::write(&file, text).unwrap();
        let found = json(&[flags, SATELLITES, SITE, NIGHT, &["--targets", &file]])["windows"].clone();
        assert!(!found.as_array().unwrap().is_empty());
        found
    };
    let table = |ra: &str, exposure: &str, row: &str| {
        format!(
            "# %ECSV 1.0\n# ---\n# datatype:\n# - {{name: name, datatype: string}}\n\
             # - {{name: ra, unit: {ra}, datatype: float64}}\n# - {{name: dec, unit: deg, datatype: float64}}\n\
             # - {{name: exposure, unit: {exposure}, datatype: float64}}\nname ra dec exposure\n{row}\n"
        )
    };
    let expected = targets(&table("deg", "s", "a 282.0 -30 300"));
    assert_eq!(expected, targets(&table("hourangle", "min", "a 18.8 -30 5")));
    // The unit at the end of a name counts as well.
    assert_eq!(expected, targets("name,ra_hourangle,dec_arcmin,exposure_min\na,18.8,-1800,5\n"));
}

/// The height of the limb of a telescope in orbit has no effect if a flag gives a site, and a limit may be written as
/// on the command line.
#[test]
fn a_file_of_a_telescope_in_orbit_serves_a_site_and_limits_may_be_text() {
    let folder = TempDir::new().unwrap();
    let verb = [EXPOSURE, SATELLITES, &["--fov", "3deg"]];
    for site in [SITE, &["--site", "Paranal"]] {
        // No satellite crosses the field: exit status 1.
        let (code, _, stderr) = run_with(&[&verb.concat(), site], &config(&folder, "limb_height_km = 100\n"));
        assert_eq!(code, 1, "{stderr}");
    }
    fails(&[&verb.concat()], &config(&folder, "limb_height_km = 100\n"), &["missing"]);
    // The line is that of the key that the error names.
    let both = "mpc = 'X05'\nlimb_height_km = 100\n";
    fails(&[&verb.concat()], &config(&folder, both), &["line 2: ", "telescope in orbit for"]);
    let both = "mpc = 'X05'\nmin_sun_angle = 50\n";
    fails(&[&verb.concat()], &config(&folder, both), &["line 2: ", "min-sun-angle is a limit of a telescope in orbit"]);
    let schedule = schedule(&folder);
    let flag = ["flag", "--schedule", &schedule, "--fov", "3deg"];
    let limits = |text: &str| {
        json_with(&[&flag, SATELLITES, SITE], &config(&folder, text))["provenance"]["options"]["policy"].clone()
    };
    assert_eq!(limits("limit_mag = 'g=7,default=6'\n"), limits("[limit_mag]\ng = 7\ndefault = 6\n"));
    assert_eq!(limits("limit_mag = '7'\n"), limits("limit_mag = 7\n"));
    fails(&[&flag, SATELLITES, SITE], &config(&folder, "limit_mag = 'g=x'\n"), &["line 1: limit_mag"]);
}

/// Every verb has a table, and the provenance names all files with settings.
#[test]
fn mask_has_a_table_and_files_of_settings_are_in_the_provenance() {
    let folder = TempDir::new().unwrap();
    let policy = path(&folder, "p.toml");
    fs::write(&policy, "limit_mag = 3\n").unwrap();
    let schedule = schedule(&folder);
    let verb = [&["flag", "--schedule", &schedule, "--fov", "3deg"], SATELLITES, SITE].concat();
    let found = json_with(&[&verb], &config(&folder, "policy = 'p.toml'\n[mask]\ncoverage = 0.9\n"));
    let files = found["provenance"]["settings_files"].as_array().unwrap();
    let names: Vec<&str> = files.iter().filter_map(|file| file["file"].as_str()).collect();
    assert!(names.len() == 2 && names[0].ends_with("obs.toml") && names[1].ends_with("p.toml"), "{names:?}");
    assert_eq!(files[1]["sha256"].as_str().unwrap().len(), 64);
    assert_eq!(json(&[&verb])["provenance"].get("settings_files"), None);
}

/// A key that is false in a file, or true, is undone by the layers above: the table of a verb, and the flag.
#[test]
fn switches_are_undone_by_the_layers_above() {
    let folder = TempDir::new().unwrap();
    let stated = |text: &str, more: &[&str]| {
        let verb: &[&[&str]] = &[EXPOSURE, SATELLITES, SITE, &["--fov", "1deg", "--format", "json"], more];
        let (code, stdout, stderr) = run_with(verb, &config(&folder, text));
        assert!(code < 2, "{stderr}");
        let stated = &serde_json::from_str::<Value>(&stdout).unwrap()["provenance"];
        (stated["earthshine"].as_str().unwrap().to_owned(), stated["options"]["include_dark"].as_bool().unwrap())
    };
    let of = |earthshine: &str, include_dark: bool| (earthshine.to_owned(), include_dark);
    let file = "earthshine = false\ninclude_dark = true\n";
    assert_eq!(stated(file, &[]), of("off", true));
    assert_eq!(stated(file, &["--no-earthshine=false", "--include-dark=false"]), of("computed", false));
    let table = format!("{file}[passes]\nearthshine = true\ninclude_dark = false\n");
    assert_eq!(stated(&table, &[]), of("computed", false));
    assert_eq!(stated(&table, &["--no-earthshine", "--include-dark"]), of("off", true));
    assert_eq!(stated("[passes]\nno_earthshine = true\n", &[]), of("off", false));
}

/// A value in a table of a verb that only the verb checks has its file and line as well.
#[test]
fn errors_in_values_of_tables_have_file_and_line() {
    let folder = TempDir::new().unwrap();
    let windows: &[&str] = &["windows", "--target", "M31", "--night", "2024-08-14", "--fov", "1deg"];
    let forecast: &[&str] = &["forecast", "--start", "2024-08-14T00:00:00Z", "--end", "2024-08-14T00:01:00Z"];
    for (verb, text, error) in [
        (windows, "[windows]\nexposure = '30'", "[windows], line 2: exposure is 30, without a unit"),
        (windows, "exposure = '30s'\n[windows]\nmin_altitude = 95", "[windows], line 3: min-altitude is 95 deg"),
        (
            forecast,
            "[forecast]\nmax_mag = 'x'",
            "[forecast], line 2: invalid value 'x' for '--max-mag <MAG>': allowed: a number",
        ),
        (forecast, "[forecast]\ngeneration = 'x'", "[forecast], line 2: unknown generation 'x'"),
    ] {
        fails(&[verb, SATELLITES, SITE], &config(&folder, text), &["configuration", "obs.toml, ", error]);
    }
    // An error in a file that a key names has the place in that file only.
    let (code, _, stderr) = {
        let schedule = path(&folder, "night.csv");
        fs::write(&schedule, "exposure_id,ra_deg\n1,2\n").unwrap();
        let text = format!("[serve]\nfov = '1deg'\nbind = '127.0.0.1:0'\nschedule = {schedule:?}\n");
        run_with(&[&["serve"], SATELLITES, SITE], &config(&folder, &text))
    };
    assert!(code == 2 && stderr.starts_with("error: schedule ") && !stderr.contains("obs.toml"), "{stderr}");
    // The same value on the command line has no place in a file.
    let flag: &[&str] = &["--exposure", "30"];
    let (code, _, stderr) =
        run_with(&[windows, SATELLITES, SITE, flag], &config(&folder, "[windows]\nexposure = '30'"));
    assert!(code == 2 && stderr.starts_with("error: exposure is 30"), "{stderr}");
}

/// Errors of the parser of TOML state what is allowed, without the words of a programming language.
#[test]
fn errors_of_the_parser_state_what_is_allowed() {
    let folder = TempDir::new().unwrap();
    for (text, error) in [
        ("rotation = 'x'", "line 1: rotation: invalid value \"x\"; allowed: a number"),
        ("samples = -1", "line 1: samples: invalid value '-1'; allowed: a whole number"),
        ("quiet = 'yes'", "line 1: quiet: invalid value \"yes\"; allowed: true, false"),
        ("band = 5", "line 1: band: invalid value '5'; allowed: a text in quotes"),
        ("[site]\nlatitude = 3", "site: unknown key 'latitude'; allowed: name, mpc, latitude_deg"),
        ("band = 'g'\nband = 'r'", "line 2: duplicate key 'band'; allowed: once"),
    ] {
        fails(&[EXPOSURE, SATELLITES], &config(&folder, text), &["configuration", "obs.toml", error]);
    }
    let (code, _, stderr) = run(&[EXPOSURE, SATELLITES, SITE, &["--threads", "99999999999999999999"]]);
    assert!(code == 2 && stderr.contains("'--threads <N>': allowed: a smaller number"), "{stderr}");
    let (code, _, stderr) = run(&[&["flag", "--fail-on", "x"]]);
    assert!(code == 2 && stderr.contains("allowed: streaked, avoid"), "{stderr}");
}

/// Paths in tables are relative to the folder of their file, for every kind of setting that may be a file.
#[test]
fn all_paths_are_relative_to_their_file() {
    let folder = TempDir::new().unwrap();
    let verb: &[&[&str]] = &[EXPOSURE, SATELLITES, SITE];
    for setting in [
        "band = 'no-such.csv'",
        "telescope = 'no-such.toml'",
        "shells = 'no-such.toml'",
        "model = 'oneweb=no-such.json'",
    ] {
        for text in [format!("fov = '1deg'\n{setting}\n"), format!("fov = '1deg'\n[passes]\n{setting}\n")] {
            let verb: &[&[&str]] = if setting.starts_with("shells") { &[EXPOSURE, SITE] } else { verb };
            fails(verb, &config(&folder, &text), &[&folder.path().join("no-such").display().to_string()]);
        }
    }
    let file = "[field]\nfile = 'no-such.json'\n";
    fails(verb, &config(&folder, file), &[&path(&folder, "no-such.json")]);
}

/// A list of targets is read as a schedule, but its errors do not call it one.
#[test]
fn errors_of_targets_do_not_call_them_a_schedule() {
    let folder = TempDir::new().unwrap();
    let targets = path(&folder, "targets.csv");
    let windows: &[&str] = &["windows", "--fov", "1deg", "--exposure", "30s", "--targets", &targets];
    for (text, error) in
        [("name,dec_deg\na,3\n", "missing ra_deg"), ("", "is empty"), ("name,ra_deg,dec_deg\n", "no exposures")]
    {
        fs::write(&targets, text).unwrap();
        let (code, _, stderr) = run(&[windows, SATELLITES, SITE, NIGHT]);
        assert!(code == 2 && stderr.starts_with("error: target list ") && stderr.contains(error), "{stderr}");
    }
}
