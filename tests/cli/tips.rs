//! Errors that name what is probably meant, values in completions, and flags that many verbs share.

use crate::common::cli::{SKY, done, json, path, run};
use std::fs;

const EXPOSURE: &[&str] = &["passes", "--exposure", "30s", "--ra", "280", "--dec", "-30"];

#[test]
fn errors_name_what_is_probably_meant() {
    let folder = tempfile::tempdir().unwrap();
    let elements = path(&folder, "elements");
    fs::write(&elements, "").unwrap();
    let at = &["--start", "2024-08-14T03:30:00Z"][..];
    for (arguments, part) in [
        (&[&["forecast", "--nite", "2024-08-14"], SKY].concat(), "; tip: similar: --night"),
        (&[&["forecast", "--max-magnitude", "5"], SKY].concat(), "; tip: similar: --max-mag"),
        (
            &vec!["forecast", "--mpc", "X05", "active.tle"],
            "; tip: a file of element sets is given by --elements active.tle",
        ),
        (&vec!["passes", "--mpc", "X05", &elements], "; tip: a file of element sets is given by --elements"),
        (
            &[EXPOSURE, SKY, &["--start", "2024-08-14T03:30:00", "--fov", "3deg"]].concat(),
            "or in an offset of local time (+02:00)",
        ),
        (&[EXPOSURE, SKY, at, &["--fov", "23.5x15.6mm"]].concat(), "for example 23.5x15.6mm@400mm"),
        (&[EXPOSURE, SKY, at, &["--fov", "24mm"]].concat(), "for example 23.5x15.6mm@400mm"),
        (&vec!["forecast", "--shells", "oneweb"], "; streakcast setup writes them once into a home file"),
        (
            &vec!["windows", "--mpc", "X05", "--fov", "1deg", "--target", "M31", "--exposure", "30s"],
            "; streakcast setup",
        ),
        (&[&["forecast", "--date", "2024-08-14"], SKY].concat(), "; tip: similar: --night"),
        (&[&["forecast", "--night", "today"], SKY].concat(), "allowed: tonight, or the local date of the evening"),
        (&[&["forecast", "--night", "8/14/2024"], SKY].concat(), "allowed: tonight, or the local date of the evening"),
        (&vec!["forecast", "--shells", "oneweb", "--lat", "47,37", "--lon", "8.5"], "with a decimal point: 47.37"),
        (&vec!["forecast", "--shells", "oneweb", "--lat", "-33.9S", "--lon", "8.5"], "with a point, south negative"),
        (&vec!["forecast", "--shells", "oneweb", "--site", "Zurich"], "streakcast setup --place TOWN"),
        (&vec!["forecast", "--elements", "https://example.org/a.csv", "--mpc", "X05"], "streakcast fetch downloads"),
        (&[&["forecast", "--night", "2024-08-14", "--name", "25544"], SKY].concat(), "--norad 25544 selects"),
        (
            &[&["windows", "--ra", "280", "--dec", "-30", "--exposure", "30s", "--fov", "1deg", "-o", "w.ics"], SKY]
                .concat(),
            "only streakcast forecast writes",
        ),
        (&[EXPOSURE, SKY, &["--start", "2024-08-14T03:30", "--fov", "3deg"]].concat(), "(+02:00)"),
        (
            &[
                &[
                    "forecast",
                    "--start",
                    "2024-08-14T03:30",
                    "--end",
                    "2024-08-14T04:30Z",
                    "--time-zone",
                    "Europe/Zurich",
                ],
                SKY,
            ]
            .concat(),
            "allowed: 2024-08-14T03:30+02:00 for local time in the given time zone",
        ),
        (
            &[
                &["forecast", "--start", "2024-08-14", "--end", "2024-08-15T00:00Z", "--time-zone", "Europe/Zurich"],
                SKY,
            ]
            .concat(),
            "allowed: 2024-08-14T00:00+02:00 for local time in the given time zone",
        ),
    ] {
        let (code, _, stderr) = run(&[arguments]);
        assert!(code == 2 && stderr.contains(part) && stderr.lines().count() == 1, "{arguments:?}: {stderr}");
    }
    // Nothing is similar to this flag.
    let (_, _, stderr) = run(&[&["forecast", "--xyzzy", "5"], SKY]);
    assert!(!stderr.contains("tip:"), "{stderr}");
}

#[test]
fn negative_numbers_are_values_of_all_flags() {
    let sky = ["map", "sky", "--model", "visorsat", "--sun-altitude-deg", "-15", "--step-deg", "-5"];
    let (_, _, stderr) = run(&[&sky]);
    assert!(stderr.contains("step is -5 deg"), "{stderr}");
    let (_, _, stderr) = run(&[&["forecast", "--night", "2024-08-14", "--samples", "-1"], SKY]);
    assert!(stderr.contains("'-1'") && stderr.contains("samples"), "{stderr}");
}

/// Forms of coordinates, dates and lists of times other than those of the help, with the same result.
#[test]
fn unambiguous_forms_are_accepted() {
    let site_of = |site: &[&str]| {
        let night = ["forecast", "--shells", "oneweb", "--sun-altitude-deg", "-89", "--night", "20240814"];
        json(&[&night, site])["provenance"]["site"].clone()
    };
    let expected = site_of(&["--lat", "-33.9", "--lon", "18.5", "--height", "430"]);
    for site in [
        ["--lat", "33.9S", "--lon", "18°30'E", "--height", "430m"],
        ["--lat", "\u{2212}33:54", "--lon", "18d30m", "--height", "0.43 km"],
    ] {
        assert_eq!(site_of(&site), expected, "{site:?}");
    }
    let dates = ["2024-8-14", "14.08.2024", "2024/08/14"];
    for night in dates {
        let options =
            json(&[&["forecast", "--sun-altitude-deg", "-89", "--night", night], SKY])["provenance"]["options"].clone();
        assert_eq!(options["night"].as_str(), Some("2024-08-14"), "{night}");
    }
    let times = "2024-08-14T00:00:00Z,2024-08-14T00:01:00Z";
    let rows = json(&[&["ephemeris", "--generation", "starlink-v1.5", "--times", times], SKY])["provenance"]["options"]
        .clone();
    assert_eq!(rows["times"].as_i64(), Some(2));
    let folder = tempfile::tempdir().unwrap();
    let calendar = path(&folder, "passes.ical");
    done(&[&["forecast", "--night", "2024-08-14", "--sun-altitude-deg", "-89", "-o", &calendar], SKY]);
    assert!(fs::read_to_string(&calendar).unwrap().starts_with("BEGIN:VCALENDAR"));
    let file = path(&folder, "home.toml");
    fs::write(&file, "lat = \"33°54'S\"\nlon = '18.5E'\nheight = '430m'\n").unwrap();
    assert_eq!(site_of(&["--config", &file]), expected);
    fs::write(&file, "lat = 47,37\nlon = 8.5\n").unwrap();
    let (code, _, stderr) = run(&[&["forecast", "--shells", "oneweb", "--config", &file]]);
    assert!(code == 2 && stderr.contains("a decimal point in place of the comma (47.37)"), "{stderr}");
}

#[test]
fn completions_have_values() {
    for shell in ["bash", "zsh", "fish"] {
        let script = done(&[&["completions", shell]]);
        for value in ["votable", "starlink-gen1", "starlink-v2mini", "geometric", "radec"] {
            assert!(script.contains(value), "{shell}: {value}");
        }
    }
}

#[test]
fn quiet_verbs_write_no_notes() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "list.csv");
    for verb in [&["sites", "paranal"][..], &["shells", "oneweb"], &["model", "list"], &["model", "show", "visorsat"]] {
        let (code, _, stderr) = run(&[verb, &["-o", &file, "--quiet"]]);
        assert!(code == 0 && stderr.is_empty(), "{verb:?}: {stderr}");
        assert!(run(&[verb, &["-o", &file]]).2.contains("wrote "), "{verb:?}");
    }
}

#[test]
fn a_height_without_coordinates_is_that_of_the_site_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "site.toml");
    fs::write(&file, "lat = 48.2\nlon = 16.37\nheight = 170\nshells = ['oneweb']\n").unwrap();
    let range = ["forecast", "--start", "2024-08-14T21:00:00Z", "--end", "2024-08-14T21:10:00Z", "--config", &file];
    let stated = |more: &[&str]| json(&[&range, more])["provenance"]["site"].clone();
    let (low, high) = (stated(&[]), stated(&["--height", "2500"]));
    assert_eq!((low["height_m"].as_f64(), high["height_m"].as_f64()), (Some(170.0), Some(2500.0)), "{low} {high}");
    assert_eq!(low["latitude_deg"], high["latitude_deg"]);
    fs::write(&file, "mpc = 'X05'\nshells = ['oneweb']\n").unwrap();
    let (code, _, stderr) = run(&[&range, &["--height", "2500"]]);
    assert!(code == 2 && stderr.contains("exclude each other"), "{stderr}");
}

/// Values of tables are checked also for verbs that are not called.
#[test]
fn the_check_of_a_setup_covers_the_tables_of_all_verbs() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "observer.toml");
    let tables = "mpc = 'X05'\nshells = ['oneweb']\n[forecast]\nmax_mag = 6\n[plot.field]\nlimit_mag = 7\n";
    let doctor = ["doctor", "--now", "2026-11-25T00:00:00Z", "--config", &file];
    fs::write(&file, tables).unwrap();
    assert_eq!(run(&[&doctor]).0, 0);
    for (wrong, parts) in [
        ("[forecast]\nmax_mag = 'bright'\n", [", [forecast], line 4: ", "'bright'"]),
        ("[plot.field]\nnorth = 1\nlimit_mag = 7\n", [", [plot.field], line 4: ", "unknown key 'north'"]),
        ("[plot.field]\nlimit_mag = [1, 'x']\n", [", [plot.field], line 4: ", "--limit-mag"]),
    ] {
        fs::write(&file, format!("mpc = 'X05'\nshells = ['oneweb']\n{wrong}")).unwrap();
        let (code, stdout, stderr) = run(&[&doctor]);
        let text = stdout + &stderr;
        assert!(code == 2 && parts.iter().all(|part| text.contains(part)), "{wrong}: {text}");
    }
}

/// The limit of `plot field` omits streaks from the picture, not from its data.
#[test]
fn a_field_is_drawn_up_to_a_limit() {
    let folder = tempfile::tempdir().unwrap();
    let (all, bright) = (path(&folder, "all.svg"), path(&folder, "bright.svg"));
    let field =
        [&["plot", "field"], &EXPOSURE[1..], SKY, &["--start", "2024-08-14T00:00:00Z", "--fov", "40deg"]].concat();
    let changed = |word| match word {
        "280" => "210",
        "30s" => "120s",
        word => word,
    };
    let field: Vec<&str> = field.into_iter().map(changed).collect();
    let drawn = |file: &str, more: &[&str]| {
        let (code, _, stderr) = run(&[&field, &["-o", file], more]);
        assert_eq!(code, 0, "{stderr}");
        fs::read_to_string(file).unwrap()
    };
    let (all, bright) = (drawn(&all, &[]), drawn(&bright, &["--limit-mag", "6"]));
    assert!(!all.contains("not drawn") && bright.contains("fainter than mag 6 not drawn"));
    assert!(bright.len() < all.len());
    let data = |name: &str| {
        fs::read_to_string(path(&folder, name)).unwrap().lines().filter(|line| !line.starts_with('#')).count()
    };
    assert_eq!(data("all-data.ecsv"), data("bright-data.ecsv"));
}
