//! The home file: `streakcast setup` writes it, and the verbs of an observer read it below `--config`.

use std::fs;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

const STREAKCAST: &str = env!("CARGO_BIN_EXE_streakcast");
const FILE: &str = ".config/streakcast/streakcast.toml";
/// Home file of an observer with a camera.
const OBSERVER: &str = "lat = 48.2\nlon = 16.4\ntime_zone = 'Europe/Vienna'\nshells = ['kuiper']\nfov = '2deg'\n\
                        limit_mag = 7\n[windows]\nexposure = '60s'\n[gate]\nexposure = '60s'\n";

/// Returns the program for a user with this home folder.
fn program(home: &TempDir) -> Command {
    let mut command = Command::new(STREAKCAST);
    command.env("HOME", home.path()).current_dir(home.path()).write_stdin("");
    for variable in ["XDG_CONFIG_HOME", "XDG_CACHE_HOME", "STREAKCAST_NO_HOME"] {
        command.env_remove(variable);
    }
    command
}

fn run(home: &TempDir, arguments: &[&str]) -> (i32, String, String) {
    let output = program(home).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[track_caller]
fn json(home: &TempDir, arguments: &[&str]) -> Value {
    let (code, stdout, stderr) = run(home, &[arguments, &["--format", "json"]].concat());
    assert!(code < 2, "{stderr}");
    serde_json::from_str(&stdout).unwrap()
}

/// Returns a home folder with this home file.
fn home(text: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::create_dir_all(folder.path().join(FILE).parent().unwrap()).unwrap();
    fs::write(folder.path().join(FILE), text).unwrap();
    folder
}

const PASSES: &[&str] =
    &["passes", "--start", "2024-08-14T01:30:00Z", "--exposure", "30s", "--ra", "318", "--dec", "0"];

#[test]
fn setup_writes_the_home_file_once() {
    let folder = TempDir::new().unwrap();
    let (code, _, stderr) = run(&folder, &["setup"]);
    assert!(code == 2 && stderr.contains("--place") && stderr.contains("not a terminal"), "{stderr}");
    assert!(!folder.path().join(FILE).exists());
    let answers = ["setup", "--place", "Wien", "--camera", "1.5x1.0deg", "--limit-mag", "6.5", "--exposure", "2min"];
    let (code, _, stderr) = run(&folder, &answers);
    assert_eq!(code, 0, "{stderr}");
    for part in ["wrote ", "streakcast fetch celestrak", "streakcast forecast", "windows --target M31", "gate --target"]
    {
        assert!(stderr.contains(part), "'{part}' is not in: {stderr}");
    }
    let text = fs::read_to_string(folder.path().join(FILE)).unwrap();
    let keys: toml::Table = text.parse().unwrap();
    assert_eq!((&keys["lat"], &keys["lon"]), (&48.21.into(), &16.37.into()), "{text}");
    assert_eq!((&keys["time_zone"], &keys["fov"]), (&"Europe/Vienna".into(), &"1.5x1.0deg".into()), "{text}");
    let elements = keys["elements"][0].as_str().unwrap();
    assert!(elements.ends_with("streakcast/celestrak-active.csv") && elements.starts_with('/'), "{text}");
    assert_eq!((&keys["limit_mag"], &keys["gate"]["exposure"]), (&6.5.into(), &"2min".into()), "{text}");
    let (code, _, stderr) = run(&folder, &["setup", "--place", "X05"]);
    assert!(code == 2 && stderr.contains("exists; allowed: --force"), "{stderr}");
    assert_eq!(fs::read_to_string(folder.path().join(FILE)).unwrap(), text);
    let (code, _, stderr) = run(&folder, &["setup", "--place", "X05", "--force"]);
    assert!(code == 0 && !stderr.contains("gate"), "{stderr}");
    let keys: toml::Table = fs::read_to_string(folder.path().join(FILE)).unwrap().parse().unwrap();
    assert_eq!((&keys["mpc"], &keys["time_zone"]), (&"X05".into(), &"America/Santiago".into()));
    assert!(!keys.contains_key("fov") && !keys.contains_key("limit_mag"), "{keys}");
}

#[test]
fn invalid_answers_name_their_flag() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("notes.txt"), "clouds\n").unwrap();
    for (answers, parts) in [
        (&["--place", "Viena del Norte"][..], ["--place", "unknown place 'Viena del Norte'"]),
        (&["--place", "93.0,16.0"], ["--place", "lat is 93 deg; allowed: -90 to 90 deg"]),
        (&["--place", "47,37"], ["--place", "latitude 47 and longitude 37, or 47.37 with a decimal comma"]),
        (&["--place", "X05", "--time-zone", "Mars/Utopia"], ["--time-zone", "'Mars/Utopia' is not a time zone"]),
        (&["--place", "X05", "--elements", "no.tle"], ["--elements", "no.tle: No such file"]),
        (&["--place", "X05", "--elements", "notes.txt"], ["--elements", "contains no element sets"]),
        (&["--place", "X05", "--camera", "1.5"], ["--camera", "without a unit"]),
        (&["--place", "X05", "--camera", "large"], ["--camera", "allowed: atlas"]),
        (&["--place", "X05", "--limit-mag", "99"], ["--limit-mag", "-30 to 40 mag"]),
        (&["--place", "X05", "--exposure", "30"], ["exposure is 30", "30s"]),
        (&["--place", "X05", "--max-mag", "99"], ["max-mag is 99", "-30 to 40"]),
    ] {
        let (code, _, stderr) = run(&folder, &[&["setup"], answers].concat());
        assert_eq!((code, stderr.lines().count()), (2, 1), "{stderr}");
        for part in parts {
            assert!(stderr.contains(part), "'{part}' is not in: {stderr}");
        }
    }
    assert!(!folder.path().join(FILE).exists());
}

/// A pipe or a link to a missing file in its place is an error at once, also for `setup`.
#[cfg(unix)]
#[test]
fn other_things_in_its_place_are_errors() {
    let observer = home("");
    let file = observer.path().join(FILE);
    fs::remove_file(&file).unwrap();
    std::os::unix::fs::symlink("/nowhere/streakcast.toml", &file).unwrap();
    let (code, _, stderr) = run(&observer, &["forecast", "--night", "2024-08-14"]);
    assert!(code == 2 && stderr.contains("streakcast.toml: No such file"), "{stderr}");
    fs::remove_file(&file).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&file).status().unwrap().success());
    let setup = ["setup", "--place", "X05", "--time-zone", "America/Santiago", "--force"];
    for arguments in [&setup[..], &["forecast", "--night", "2024-08-14"]] {
        let (code, _, stderr) = run(&observer, arguments);
        assert!(code == 2 && stderr.contains("is a named pipe; allowed: a file"), "{stderr}");
    }
}

/// With a home file, the evening's verbs need no flags besides the target.
#[test]
fn verbs_need_nothing_else() {
    let observer = home(&OBSERVER.replace("[windows]", "[forecast]\nmax_mag = 6\nmin_culmination = 80\n[windows]"));
    let forecast = json(&observer, &["forecast"]);
    assert_eq!(forecast["provenance"]["site"]["latitude_deg"], 48.2);
    assert_eq!(forecast["provenance"]["options"]["max_mag"], 6.0);
    let file = observer.path().join(FILE).display().to_string();
    assert_eq!(forecast["provenance"]["home_file"], file);
    let windows = json(&observer, &["windows", "--target", "M31", "--night", "2024-08-14"]);
    assert!(!windows["windows"].as_array().unwrap().is_empty());
    assert_eq!(windows["provenance"]["options"]["field"]["circle"], "2deg");
    for window in windows["windows"].as_array().unwrap() {
        assert!(window["exposure_s"] == 60.0 && window["first_start_local"].is_string(), "{window}");
    }
    let (code, _, stderr) = run(&observer, &["gate", "--target", "M31", "--now", "2024-08-14T01:30:00Z", "--strict"]);
    assert!(code < 2, "{stderr}");
    let (code, stdout, _) = run(&observer, &["doctor"]);
    assert_eq!(code, 0, "{stdout}");
    let line = stdout.lines().find(|line| line.contains("settings")).unwrap_or_else(|| panic!("{stdout}"));
    for part in [file.as_str(), "lat, lon", "time_zone", "[forecast]", "[gate]"] {
        assert!(line.contains(part), "'{part}' is not in: {line}");
    }
}

/// The time zone of the home file is not that of another site: the night of Hawaii is that of its own evening.
#[test]
fn the_time_zone_belongs_to_the_site() {
    let observer = home(OBSERVER);
    let forecast = ["forecast", "--mpc", "568", "--night", "2024-08-14", "--max-mag", "6"];
    let with_home = json(&observer, &forecast);
    let without = json(&observer, &[&forecast[..], &["--no-home", "--shells", "kuiper"]].concat());
    assert!(!with_home["passes"].as_array().unwrap().is_empty());
    assert_eq!(with_home["passes"], without["passes"]);
}

/// The keys of a stream lie above the tables of the home file, and `doctor` reads the stream once.
#[test]
fn a_configuration_from_a_stream_lies_above_the_home_file() {
    let observer = home(OBSERVER);
    let piped = |arguments: &[&str]| {
        let output = program(&observer)
            .args(arguments)
            .args(["--config", "/dev/stdin", "--format", "json"])
            .write_stdin("exposure = '30s'\nmpc = 'X05'\n")
            .output()
            .unwrap();
        assert!(output.status.code().unwrap() < 2, "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let windows: Value = serde_json::from_str(&piped(&["windows", "--target", "M8", "--night", "2024-08-14"])).unwrap();
    assert_eq!(windows["windows"][0]["exposure_s"], 30.0);
    assert!(piped(&["doctor", "--now", "2024-08-14T01:30:00Z"]).contains("Rubin Observatory"));
}

/// The path of the home file is not a flag of users.
#[test]
fn the_home_file_is_not_a_flag() {
    let observer = home(OBSERVER);
    let (code, _, stderr) = run(&observer, &[PASSES, &["--home", "other.toml"]].concat());
    assert!(code == 2 && stderr.contains("unexpected argument '--home'"), "{stderr}");
}

/// Layers, topmost first: flags, the verb's table and the top of `--config`, the same of the home file.
#[test]
fn the_home_file_lies_below_the_configuration() {
    let home = home(
        "shells = ['kuiper']\nmpc = 'X05'\ntelescope = 'vst'\nmin_probability = 0.1\n[passes]\nfov = '2deg'\nmin_probability = 0.2\n",
    );
    let config = |text: &str| {
        fs::write(home.path().join("obs.toml"), text).unwrap();
        json(&home, &[PASSES, &["--config", "obs.toml"]].concat())["provenance"].clone()
    };
    let stated = |provenance: &Value| {
        let options = &provenance["options"];
        (options["field"].clone(), options["min_probability"].clone())
    };
    let circle = |text: &str| serde_json::json!({ "circle": text });
    // The table of the verb lies above the top of the same file, and below the other file.
    assert_eq!(stated(&config("")), (circle("2deg"), 0.2.into()));
    assert_eq!(stated(&config("fov = '3deg'\n")), (circle("3deg"), 0.2.into()));
    assert_eq!(stated(&config("[passes]\nfov = '4deg'\nmin_probability = 0.4\n")), (circle("4deg"), 0.4.into()));
    assert_eq!(stated(&config("telescope = 'rubin'\n")), ("of the telescope".into(), 0.2.into()));
    // A key of a question replaces all keys of the home file that answer it.
    let site = config("lat = 48.2\nlon = 16.4\n")["site"].clone();
    assert_eq!((&site["latitude_deg"], &site["mpc_code"]), (&48.2.into(), &Value::Null));
    let flags = json(&home, &[PASSES, &["--fov", "1deg", "--min-probability", "0.5"]].concat())["provenance"].clone();
    assert_eq!(stated(&flags), (circle("1deg"), 0.5.into()));
    let doctor = |flags: &[&str]| run(&home, &[&["doctor", "--config", "obs.toml"], flags].concat()).1;
    assert!(doctor(&["--site", "Paranal"]).contains("obs.toml; replaced: lat, lon"), "{}", doctor(&[]));
}

#[test]
fn the_home_file_can_be_switched_off() {
    let home = home(OBSERVER);
    let (code, _, stderr) = run(&home, &[PASSES, &["--no-home"]].concat());
    assert!(code == 2 && stderr.contains("missing: satellites"), "{stderr}");
    let output = program(&home).args(PASSES).env("STREAKCAST_NO_HOME", "1").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(run(&home, PASSES).0 < 2);
    let flags = ["--no-home", "--shells", "kuiper", "--mpc", "X05", "--fov", "1deg"];
    assert_eq!(json(&home, &[PASSES, &flags].concat())["provenance"]["home_file"], Value::Null);
}

/// An error names file, line, key and value. It is a fault of the gate, which does not stop an exposure.
#[test]
fn errors_name_the_home_file_and_do_not_stop_the_gate() {
    for (text, parts) in [
        ("mpc = 'X05'\nlat = 93\nlon = 1\n", &["line 2: ", "lat is 93 deg; allowed: -90 to 90 deg"][..]),
        ("limit_mg = 7\n", &["line 1: ", "unknown key 'limit_mg'; did you mean limit_mag?"]),
        ("fov = '1deg'\n\nlimit_mag = 'x'\n", &["line 3: ", "limit_mag"]),
        ("fov = '1deg'\ntime_zone = 'Mars'\n", &["line 2", "time_zone is \"Mars\"", "Europe/Madrid"]),
        ("[gate]\nexposure = '30'\n", &["[gate]", "exposure is 30, without a unit"]),
        ("fov = \n", &["line 1: "]),
    ] {
        let home = home(text);
        let gate =
            ["gate", "--target", "M31", "--exposure", "30s", "--shells", "kuiper", "--mpc", "X05", "--fov", "1deg"];
        // A flag replaces the key of the table.
        let gate = if text.starts_with("[gate]") { [&gate[..3], &gate[5..]].concat() } else { gate.to_vec() };
        let (code, _, stderr) = run(&home, &gate);
        assert!(code == 0 && stderr.contains("satellites were not checked"), "{stderr}");
        let (code, _, strict) = run(&home, &[&gate[..], &["--strict"]].concat());
        assert_eq!(code, 2, "{strict}");
        let mut errors = vec![stderr, strict];
        if !text.starts_with("[gate]") {
            let (code, _, stderr) = run(&home, PASSES);
            assert_eq!((code, stderr.lines().count()), (2, 1), "{stderr}");
            errors.push(stderr);
        }
        for part in [&[FILE], parts].concat() {
            for error in &errors {
                assert!(error.contains(part), "'{part}' is not in: {error}");
            }
        }
    }
}

/// Relative paths are relative to the folder of the home file.
#[test]
fn paths_are_relative_to_the_home_file() {
    let home =
        home("shells = ['kuiper']\nmpc = 'X05'\nfov = '1deg'\npolicy = 'p.toml'\n[flag]\nschedule = 'night.csv'\n");
    let folder = home.path().join(FILE).parent().unwrap().to_owned();
    fs::write(folder.join("p.toml"), "limit_mag = 3\n").unwrap();
    let schedule = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\na,2024-08-14T03:30:00Z,30,280,-30\n";
    fs::write(folder.join("night.csv"), schedule).unwrap();
    assert_eq!(json(&home, &["flag"])["provenance"]["options"]["policy"]["limit_mag"], 3.0);
}

/// The site of the home file is that of a frame whose header has none, which is stated.
#[test]
fn frames_without_a_site_are_those_of_the_home_file() {
    let home = home(OBSERVER);
    let synthetic = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/synthetic.toml");
    let streak = ["--random-streaks", "1", "--magnitude", "4", "--exposure", "30s", "--seeing", "1.5arcsec"];
    let (code, _, stderr) = run(&home, &[&["inject", "--synthetic", synthetic, "-o", "f.fits"], &streak[..]].concat());
    assert_eq!(code, 0, "{stderr}");
    let identify = ["identify", "--image", "f.fits", "--from-pix", "12,94", "--to-pix", "203,110"];
    let (_, _, stderr) = run(&home, &identify);
    assert!(stderr.contains("warning: the header of f.fits has no site; that of the home file is used"), "{stderr}");
    let (code, _, stderr) = run(&home, &[&identify[..], &["--no-home", "--shells", "kuiper"]].concat());
    assert!(code == 2 && stderr.contains("missing site; specify --site NAME"), "{stderr}");
}
