//! Telescopes in orbit and models of the Earth's shadow on the command line.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::cli::run;

/// Element set of the telescope, an invented satellite. The catalogue contains 6,372 simulated satellites.
const OBSERVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/data/elements/sample.2le");
const SHELLS: &[&str] = &["--shells", "oneweb", "--quiet"];
const EXPOSURE: &[&str] =
    &["--start", "2026-03-21T06:00:00Z", "--exposure", "660s", "--fov", "10deg", "--include-dark"];

/// Returns the first of eight pointings around the sky that is not blocked by the Earth and is crossed by a satellite.
fn crossed() -> (String, String, Value) {
    for ra in (0..360).step_by(45) {
        let (ra, dec) = (ra.to_string(), "20".to_owned());
        let pointing = ["--ra", &ra, "--dec", &dec, "--observer-elements", OBSERVER, "--format", "json"];
        let (code, stdout, stderr) = run(&[&["passes"], SHELLS, EXPOSURE, &pointing]);
        match code {
            0 => return (ra, dec, serde_json::from_str(&stdout).unwrap()),
            1 => {}
            _ => assert!(stderr.contains("below the Earth's limb of "), "{stderr}"),
        }
    }
    panic!("no crossing in eight fields of 10 deg")
}

#[test]
fn passes_and_flags_from_an_orbit() {
    let (ra, dec, answer) = crossed();
    let observer = &answer["provenance"]["observer"];
    assert_eq!((&observer["norad_id"], &observer["limb_height_km"]), (&90001.into(), &0.0.into()));
    assert!(answer["provenance"].get("site").is_none() && answer["provenance"]["shadow"] == "atmosphere");
    let passes = answer["passes"].as_array().unwrap();
    for pass in passes {
        assert!(pass["altitude_deg"].is_null() && pass["azimuth_deg"].is_null());
        assert!(pass["range_km"].as_f64().unwrap() > 0.0 && pass["norad_id"] != 90001);
    }
    // A schedule of the same field and of pointings all over the sky: those that the Earth blocks are invalid.
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("s.csv").display().to_string();
    let mut rows = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\n".to_owned();
    rows += &format!("a,2026-03-21T06:00:00Z,660,{ra},{dec}\n");
    for turn in 0..12 {
        for tilt in [-60, 0, 60] {
            rows += &format!("x{turn}{tilt},2026-03-21T06:00:00Z,10,{},{tilt}\n", 30 * turn);
        }
    }
    fs::write(&path, rows).unwrap();
    let flags = ["flag", "--schedule", &path, "--fov", "10deg", "--observer-elements", OBSERVER, "--format", "json"];
    // A later start is searched only with --max-delay.
    let judged = |more: &[&str]| {
        let (code, stdout, stderr) = run(&[&flags, SHELLS, more]);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).unwrap()["flags"].as_array().unwrap().clone()
    };
    let is_searched =
        |flag: &Value| flag["delay_s"].is_number() || flag["reasons"].to_string().contains("start within");
    let streaked =
        |flags: &[Value]| flags.iter().filter(|flag| flag["verdict"] == "streaked").cloned().collect::<Vec<_>>();
    let delayed = streaked(&judged(&["--max-delay", "2min"]));
    assert!(!delayed.is_empty() && delayed.iter().all(is_searched), "{delayed:?}");
    let flags = judged(&[]);
    assert!(streaked(&flags).len() == delayed.len() && !streaked(&flags).iter().any(is_searched), "{flags:?}");
    let lit = passes.iter().filter(|pass| pass["illumination"] != "umbra").count();
    assert!(flags[0]["n_streaks"].as_u64().unwrap() as usize >= lit.min(1), "{}", flags[0]);
    let hidden = flags.iter().filter(|flag| flag["verdict"] == "invalid").collect::<Vec<_>>();
    // The Earth covers 33 % of the sky at 550 km.
    assert!((6..20).contains(&hidden.len()), "{}", hidden.len());
    assert!(hidden[0]["reasons"].to_string().contains("meets the Earth ("), "{}", hidden[0]);
}

/// Trails by class of orbit, numbers of trails and position angles; the same seed gives the same numbers.
#[test]
fn statistics_and_windows_from_an_orbit() {
    let span = ["--start", "2026-03-21T06:00:00Z", "--end", "2026-03-21T12:00:00Z"];
    let orbit = ["--observer-elements", OBSERVER, "--min-limb-angle", "20"];
    let statistics = |more: &[&str]| {
        let shared = ["statistics", "--exposure", "100s", "--pointings", "60", "--format", "json"];
        let (code, stdout, stderr) = run(&[&shared, SHELLS, &span, &orbit, more]);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).unwrap()
    };
    let found = statistics(&["--fov", "5x3deg", "--include-dark", "--limit-mag", "20"]);
    let row = |name: &str| {
        let rows = found["statistics"].as_array().unwrap();
        rows.iter().find(|row| row["orbits"] == name).unwrap().clone()
    };
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"));
    let (all, low) = (row("all"), row("LEO"));
    assert!(number(&all, "trails_per_exposure") > 0.0 && number(&all, "trails_sigma") > 0.0, "{all}");
    assert!(number(&all, "trails_with_dark") > number(&all, "trails_per_exposure"), "{all}");
    assert!(number(&all, "trails_brighter_than_limit") <= number(&all, "trails_per_exposure"), "{all}");
    assert_eq!((&all["satellites"], &low["satellites"]), (&6372.into(), &6372.into()));
    assert_eq!(all["trails_per_exposure"], low["trails_per_exposure"]);
    assert_eq!(number(&row("GEO"), "trails_per_exposure"), 0.0);
    let sum = |section: &str, key: &str| {
        let rows = found[section].as_array().unwrap();
        rows.iter().map(|row| number(row, key)).sum::<f64>()
    };
    assert_eq!((sum("histogram", "exposures"), sum("histogram", "exposures_with_dark")), (60.0, 60.0));
    let trails: f64 =
        found["histogram"].as_array().unwrap().iter().map(|row| number(row, "trails") * number(row, "exposures")).sum();
    assert!(
        (trails - 60.0 * number(&all, "trails_per_exposure")).abs() < 0.01
            && trails == sum("position_angles", "trails")
    );
    assert_eq!(
        statistics(&["--fov", "5x3deg", "--include-dark", "--limit-mag", "20"])["statistics"],
        found["statistics"]
    );
    let other = statistics(&["--fov", "5x3deg", "--include-dark", "--limit-mag", "20", "--seed", "2"]);
    assert_ne!(other["statistics"], found["statistics"]);
    for (words, expected) in [
        (
            &["statistics", "--fov", "3deg", "--exposure", "60s", "--pointings", "60"][..],
            "missing span of the exposures",
        ),
        (
            &["statistics", "--fov", "3deg", "--moments", "3"],
            "--moments is for a site; allowed for a telescope in orbit",
        ),
        (&["statistics", "--fov", "3deg", "--min-altitude", "3"], "--min-altitude is for a site; allowed"),
        (
            &["windows", "--fov", "3deg", "--target", "M31", "--exposure", "1min", "--min-altitude", "3"],
            "--min-limb-angle DEG",
        ),
        (
            &["windows", "--fov", "3deg", "--target", "M31", "--exposure", "1min", "--max-sun-altitude-deg", "3"],
            "--min-sun-angle DEG",
        ),
        (&["windows", "--fov", "3deg", "--target", "M31", "--exposure", "1min"], "missing time range; specify --start"),
        (&["forecast"], "for satellites in its field use passes, flag or windows, for numbers statistics"),
    ] {
        let (code, _, stderr) = run(&[words, SHELLS, &orbit[..2]]);
        assert!(code == 2 && stderr.contains(expected), "{words:?}: {stderr}");
    }
    let (code, _, stderr) = run(&[&["statistics", "--mpc", "X05", "--night", "2026-03-21", "--seed", "3"], SHELLS]);
    assert!(code == 2 && stderr.contains("--seed is for a telescope in orbit (--observer-elements)"), "{stderr}");
    let target = ["windows", "--target", "M31", "--exposure", "1min", "--fov", "1deg", "--format", "json"];
    let (code, stdout, stderr) = run(&[&target, SHELLS, &span, &orbit]);
    let windows: Value = serde_json::from_str(&stdout).unwrap_or_else(|_| panic!("{stderr}"));
    // Four revolutions of 96 min: M31 is in the orbit's plane or near its poles.
    assert!(code == 0 && windows["windows"].as_array().unwrap().len() > 2, "{windows}");
}

/// Satellites in shadow count in the verdicts of a telescope in orbit on request.
#[test]
fn dark_crossings_count_on_request() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("s.csv").display().to_string();
    let rows: String = (0..60)
        .map(|row| format!("{row},2026-03-21T06:{:02}:00Z,60,{},{}\n", row, 6 * row, (row % 7) * 20 - 60))
        .collect();
    fs::write(&path, format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{rows}")).unwrap();
    let flags = |more: &[&str]| {
        let words = ["flag", "--schedule", &path, "--fov", "8deg", "--observer-elements", OBSERVER, "--format", "json"];
        let (code, stdout, stderr) = run(&[&words, SHELLS, more]);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).unwrap()["flags"].as_array().unwrap().clone()
    };
    let (lit, all) = (flags(&["--limit-mag", "20"]), flags(&["--limit-mag", "20", "--include-dark"]));
    let mut added = 0;
    for (lit, all) in lit.iter().zip(&all).filter(|(lit, _)| lit["verdict"] != "invalid") {
        let count = |flag: &Value| flag["n_streaks"].as_u64().unwrap();
        let p = |flag: &Value, key: &str| flag[key].as_f64().unwrap();
        assert!(count(all) >= count(lit) && p(all, "p_crossing") >= p(lit, "p_crossing") - 1e-9, "{lit} {all}");
        // Satellites in shadow are not brighter than the limit.
        assert!((p(all, "p_any") - p(lit, "p_any")).abs() < 1e-6, "{lit} {all}");
        if count(all) > count(lit) {
            added += 1;
            assert!(all["verdict"] != "clear" && p(all, "p_crossing") > 0.3, "{all}");
            assert!(all["verdict"] == "avoid" || !all["reasons"].to_string().contains(" lit "), "{all}");
        }
    }
    assert!(added > 0, "{all:?}");
    let (code, _, stderr) =
        run(&[&["flag", "--schedule", &path, "--fov", "8deg", "--mpc", "X05", "--include-dark"], SHELLS]);
    assert!(code == 2 && stderr.contains("--include-dark is for a telescope in orbit"), "{stderr}");
}

/// With satellites in shadow, the cost at the next acceptable start is below the largest one, too, and the cost of an
/// exposure is the sum over its streaks.
#[test]
fn costs_with_satellites_in_shadow_follow_one_rule() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let header = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\n";
    let row = |row: i32, start: &str| format!("{row},{start},30,{},{}\n", 6 * row, (row % 7) * 20 - 60);
    let rows: String = (10..30).map(|number| row(number, &format!("2026-03-21T06:{number:02}:00Z"))).collect();
    fs::write(path("s.csv"), format!("{header}{rows}")).unwrap();
    fs::write(path("p.toml"), "limit_mag = 1\nmax_cost_s = 0.004\nmax_delay_s = 120\n").unwrap();
    fs::write(path("dark.toml"), "include_dark = true\n").unwrap();
    let [policy, dark] = [path("p.toml"), path("dark.toml")];
    let shared = ["--fov", "4deg", "--telescope", "small", "--policy", &policy, "--observer-elements", OBSERVER];
    let flags = |schedule: &str| {
        let words = ["flag", "--schedule", schedule, "--include-dark", "--format", "json"];
        let (code, stdout, stderr) = run(&[&words, &shared, SHELLS]);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).unwrap()["flags"].as_array().unwrap().clone()
    };
    let all = flags(&path("s.csv"));
    let delayed = all.iter().filter(|flag| flag["acceptable_delay_s"].as_f64().is_some_and(|delay_s| delay_s > 0.0));
    let later: String = delayed
        .map(|flag| {
            let number = flag["exposure_id"].as_str().unwrap().parse().unwrap();
            row(number, flag["next_acceptable_start_utc"].as_str().unwrap())
        })
        .collect();
    assert!(later.lines().count() > 1, "{all:?}");
    fs::write(path("later.csv"), format!("{header}{later}")).unwrap();
    for flag in flags(&path("later.csv")) {
        assert!(flag["streak_cost_s"].as_f64().unwrap() <= 0.004 && flag["verdict"] != "avoid", "{flag}");
    }
    let output = path("annotated.csv");
    let annotate = ["annotate", "--schedule", &path("s.csv"), "-o", &output, "--config", &dark];
    let (code, _, stderr) = run(&[&annotate, &shared, SHELLS]);
    assert_eq!(code, 0, "{stderr}");
    let streaks = crate::common::cli::records(&fs::read_to_string(path("annotated.streaks.csv")).unwrap());
    let at = |name: &str| streaks[0].iter().position(|column| column == name).unwrap();
    let [id, cost, lit] = ["exposure_id", "streak_cost_s", "illumination"].map(at);
    let mut in_shadow = 0;
    for flag in all.iter().filter(|flag| flag["verdict"] != "invalid") {
        let own: Vec<_> = streaks[1..].iter().filter(|streak| flag["exposure_id"] == streak[id]).collect();
        let sum_s: f64 = own.iter().map(|streak| streak[cost].parse::<f64>().unwrap()).sum();
        let cost_s = flag["streak_cost_s"].as_f64().unwrap();
        // Rounded to a millisecond each; the exposure also has the near misses with probabilities of 1 % to 50 %.
        let tolerance_s = 0.001 * (own.len() + 1) as f64 + 0.1 * cost_s;
        assert!((sum_s - cost_s).abs() < tolerance_s, "{sum_s} s in {own:?}, {flag}");
        in_shadow += usize::from(!own.is_empty() && own.iter().all(|streak| &streak[lit] == "umbra") && cost_s > 0.003);
        let has_streaks = !own.is_empty();
        assert_eq!(flag["streak_length_deg"].as_f64().unwrap() > 0.0, has_streaks, "{flag}");
    }
    assert!(in_shadow > 1, "{streaks:?}");
}

/// The span of an ephemeris is searched to its ends, also with margins, and segments and ends are no errors of random
/// exposures.
#[test]
fn windows_and_statistics_end_with_the_ephemeris() {
    const EPHEMERIS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/data/ephemerides/invented.oem");
    let folder = TempDir::new().unwrap();
    let policy = folder.path().join("p.toml").display().to_string();
    fs::write(&policy, "margin_s = 45\n").unwrap();
    let span = ["--start", "2024-08-14T00:00:00Z", "--end", "2024-08-14T01:30:00Z", "--observer-elements", EPHEMERIS];
    let mut last_starts = Vec::new();
    for more in [&[][..], &["--policy", &policy]] {
        for ra in ["0", "90", "180", "270"] {
            let target = ["windows", "--ra", ra, "--dec", "10", "--exposure", "500s", "--fov", "1deg"];
            let (code, stdout, stderr) = run(&[&target, SHELLS, &span, more, &["--format", "json"]]);
            assert_eq!(code, 0, "{stderr}");
            let answer: Value = serde_json::from_str(&stdout).unwrap();
            let windows = answer["windows"].as_array().unwrap();
            last_starts.extend(windows.iter().map(|one| one["last_start_utc"].as_str().unwrap().to_owned()));
        }
    }
    let target = ["windows", "--ra", "0", "--dec", "10", "--exposure", "500s", "--fov", "1deg"];
    let (_, _, stderr) = run(&[&target, &["--shells", "oneweb", "--min-sun-angle", "180"], &span]);
    assert!(stderr.contains("never above the Earth's limb and within the limits of the telescope"), "{stderr}");
    // The shutter closes by 01:30:00.
    assert_eq!(last_starts.iter().max().map(|last| &last[..19]), Some("2024-08-14T01:21:40"), "{last_starts:?}");
    let statistics = ["statistics", "--fov", "1deg", "--exposure", "500s", "--pointings", "40", "--format", "json"];
    let (code, _, stderr) = run(&[&statistics, SHELLS, &span]);
    assert_eq!(code, 0, "{stderr}");
}

/// Segments of the telescope's ephemeris that overlap and differ are named, as those of satellites are.
#[test]
fn contradictory_segments_of_the_telescope_are_named() {
    const EPHEMERIS: &str = include_str!("../data/ephemerides/invented.oem");
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("two.oem").display().to_string();
    // The second segment is 100 km away.
    let shifted = |line: &str| match line.split_once(' ') {
        Some((time, cells)) if time.starts_with("2024-") => {
            let (x, others) = cells.split_once(' ').unwrap();
            format!("{time} {:.9} {others}\n", x.parse::<f64>().unwrap() + 100.0)
        }
        _ => format!("{line}\n"),
    };
    let second: String = EPHEMERIS[EPHEMERIS.find("META_START").unwrap()..].lines().map(shifted).collect();
    for (text, expected) in [(EPHEMERIS.to_owned(), false), (format!("{EPHEMERIS}\n{second}"), true)] {
        fs::write(&path, text).unwrap();
        let exposure = ["passes", "--start", "2024-08-14T01:10:00Z", "--exposure", "60s", "--fov", "5deg", "--ra", "0"];
        let satellites = ["--dec", "10", "--shells", "oneweb", "--observer-elements", &path];
        let (_, _, stderr) = run(&[&exposure, &satellites]);
        let warning = "segments of one ephemeris message overlap and differ by more than 1 km";
        assert_eq!(stderr.contains(warning), expected, "{stderr}");
    }
}

/// Limits that allow three in 10,000 pointings are no error, whatever the seed (with seeds 1, 2, 3, 4 and 7 they were).
#[test]
fn narrow_limits_are_no_error_by_chance() {
    for seed in ["1", "4", "7"] {
        let limits =
            ["--max-zenith-angle", "2", "--seed", seed, "--pointings", "2", "--exposure", "1s", "--fov", "1deg"];
        let span = ["--start", "2026-03-21T06:00:00Z", "--end", "2026-03-21T12:00:00Z"];
        let (code, _, stderr) = run(&[&["statistics"], SHELLS, &span, &limits, &["--observer-elements", OBSERVER]]);
        assert_eq!(code, 0, "{stderr}");
    }
}

/// The limits of a configuration file for a telescope in orbit do not apply to a site on the command line.
#[test]
fn limits_of_a_file_are_those_of_its_telescope() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("orbit.toml").display().to_string();
    fs::write(&file, format!("observer-elements = '{OBSERVER}'\nmin-sun-angle = 179\nfov = '5deg'\n")).unwrap();
    // The Sun is near RA 0, Dec 0; at least one of two opposite pointings is not behind the Earth.
    let is_seen = |ra: &&str| {
        let words = ["passes", "--ra", ra, "--dec", "0", "--fov", "5deg", "--observer-elements", OBSERVER];
        !run(&[&words, SHELLS, &["--start", "2026-03-21T06:00:00Z", "--exposure", "10s"]]).2.contains("limb")
    };
    let ra = ["90", "270"].into_iter().find(is_seen).unwrap();
    let pointing = ["passes", "--ra", ra, "--dec", "0", "--config", &file];
    let times = ["--start", "2026-03-21T06:00:00Z", "--exposure", "10s"];
    let (code, _, stderr) = run(&[&pointing, SHELLS, &times]);
    assert!(code == 2 && stderr.contains("deg from the Sun; allowed: 179 deg or more"), "{stderr}");
    let (code, _, stderr) = run(&[&pointing, SHELLS, &times, &["--min-sun-angle", "30"]]);
    assert!(code != 2, "{stderr}");
    let (code, _, stderr) = run(&[&pointing, SHELLS, &times, &["--lat", "60", "--lon", "10"]]);
    assert!(code != 2 || stderr.contains("below the horizon"), "{stderr}");
}

#[test]
fn the_observer_is_specified_once() {
    let folder = TempDir::new().unwrap();
    let two = folder.path().join("two.tle").display().to_string();
    let other = "1 25544U 98067A   26080.73419088  .00005258  00000+0  10370-3 0  9991\n\
                 2 25544  51.6304 193.4497 0006669 272.1743  87.8481 15.48947664575097\n";
    fs::write(&two, fs::read_to_string(OBSERVER).unwrap() + other).unwrap();
    let pointing = ["--ra", "10", "--dec", "20"];
    for (more, expected) in [
        (&["--observer-elements", OBSERVER, "--mpc", "X05"][..], "exclude each other; specify one of them"),
        (&["--observer-norad", "90001", "--lat", "3", "--lon", "4"], "exclude each other; specify one of them"),
        (
            &["--observer-norad", "90001"],
            "missing elements or ephemeris of the telescope in orbit; specify --observer-elements FILE",
        ),
        (&["--observer-elements", OBSERVER, "--observer-norad", "5"], "--observer-norad 5 is not among the 1 objects"),
        (
            &["--observer-elements", &two, "--accept-bad-checksums"],
            "contain 2 objects; specify one with --observer-norad",
        ),
        (&["--observer-elements", "nowhere.tle"], "nowhere.tle"),
        (&["--observer-elements", OBSERVER, "--limb-height-km=-3"], "limb-height-km is -3 km; allowed: 0 to 1000 km"),
        (&["--observer-elements", OBSERVER, "--limb-height-km", "900"], "km, below the limb height of 900 km; allowed"),
        (
            &["--observer-elements", OBSERVER, "--min-sun-angle", "200"],
            "min-sun-angle is 200 deg; allowed: 0 to 180 deg",
        ),
        (&["--observer-elements", OBSERVER, "--max-zenith-angle=-1"], "max-zenith-angle is -1 deg; allowed: 0 to 180"),
        (&["--mpc", "X05", "--max-zenith-angle", "3"], "allowed for a site: --min-altitude of windows and statistics"),
        (&["--mpc", "X05", "--min-sun-angle", "3"], "allowed for a site: --max-sun-altitude-deg of windows"),
        (&["--mpc", "X05", "--min-limb-angle", "3"], "allowed for a site: --min-altitude of windows and statistics"),
        (&["--mpc", "X05", "--limb-height-km", "3"], "specify --observer-elements FILE or --observer-norad ID"),
        (&["--mpc", "X05", "--shadow", "round"], "invalid shadow 'round'; allowed: geometric, atmosphere"),
    ] {
        let (code, _, stderr) = run(&[&["passes"], SHELLS, EXPOSURE, &pointing, more]);
        assert_eq!(code, 2, "{more:?}");
        assert!(stderr.contains(expected) && stderr.trim_end().lines().count() == 1, "{more:?}: {stderr}");
    }
    // The telescope is selected by its number from several element sets, and from the catalogue of satellites.
    for more in [
        &["--observer-elements", &two, "--accept-bad-checksums", "--observer-norad", "90001"][..],
        &["--elements", OBSERVER, "--observer-norad", "90001"],
    ] {
        let (code, _, stderr) = run(&[&["passes"], SHELLS, EXPOSURE, &pointing, more]);
        assert!(code != 2 || stderr.contains("below the Earth's limb"), "{more:?}: {stderr}");
    }
}

/// An ephemeris of the telescope is used in place of its element set; exposures outside it are invalid.
#[test]
fn an_ephemeris_of_the_telescope_is_used() {
    const EPHEMERIS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/data/ephemerides/invented.oem");
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    // The ephemeris is of 2024-08-14, 00:00 to 01:30 UTC.
    let rows: String = (0..36)
        .map(|turn| format!("in{turn},2024-08-14T01:00:00Z,60,{},0\n", 10 * turn))
        .chain(["out,2024-08-14T09:00:00Z,60,10,20\n".to_owned()])
        .collect();
    fs::write(path("s.csv"), format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{rows}")).unwrap();
    fs::create_dir(path("both")).unwrap();
    fs::copy(EPHEMERIS, path("both/a.oem")).unwrap();
    fs::copy(OBSERVER, path("both/b.tle")).unwrap();
    let schedule = path("s.csv");
    let both = path("both");
    for observer in [&["--observer-elements", EPHEMERIS][..], &["--observer-elements", &both]] {
        let flag = ["flag", "--schedule", &schedule, "--fov", "5deg", "--format", "json"];
        let (code, stdout, stderr) = run(&[&flag, SHELLS, observer]);
        assert_eq!(code, 0, "{stderr}");
        let answer: Value = serde_json::from_str(&stdout).unwrap();
        let stated = &answer["provenance"]["observer"];
        assert!(
            stated["elements_epoch_utc"].is_null() && stated["ephemerides"][0]["first_utc"].is_string(),
            "{stated}"
        );
        let flags = answer["flags"].as_array().unwrap();
        let verdict = |flag: &Value| flag["verdict"].as_str().unwrap().to_owned();
        assert!(flags[..36].iter().any(|flag| verdict(flag) != "invalid"), "{flags:?}");
        assert_eq!(verdict(&flags[36]), "invalid");
        assert!(flags[36]["reasons"].to_string().contains("no ephemeris of "), "{}", flags[36]);
    }
    let exposure = ["passes", "--start", "2024-08-14T09:00:00Z", "--exposure", "60s", "--fov", "5deg", "--ra", "10"];
    let (code, _, stderr) = run(&[&exposure, &["--dec", "20", "--observer-elements", EPHEMERIS], SHELLS]);
    assert!(code == 2 && stderr.contains("no ephemeris covers the time from"), "{code} {stderr}");
}

/// Wide field over a site at dusk with satellites that enter the shadow: with the atmosphere none is brighter, and more
/// of them are dimmed.
#[test]
fn the_shadow_with_atmosphere_dims_and_is_named() {
    let lit = |shadow: &str| -> Vec<(u64, f64)> {
        let question = [
            "passes",
            "--mpc",
            "X05",
            "--ra",
            "12h",
            "--dec=-10",
            "--fov",
            "140deg",
            "--start",
            "2026-03-21T01:00:00Z",
        ];
        let rest = ["--exposure", "60s", "--include-dark", "--format", "json", "--shadow", shadow];
        let (code, stdout, stderr) = run(&[&question, &rest, SHELLS]);
        assert_eq!(code, 0, "{stderr}");
        let answer: Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!(answer["provenance"]["shadow"], shadow);
        let passes = answer["passes"].as_array().unwrap();
        passes.iter().map(|pass| (pass["norad_id"].as_u64().unwrap(), pass["lit_fraction"].as_f64().unwrap())).collect()
    };
    let (solid, air) = (lit("geometric"), lit("atmosphere"));
    assert_eq!(solid.len(), air.len());
    let fading = |all: &[(u64, f64)]| all.iter().filter(|(_, lit)| *lit > 0.0 && *lit < 1.0).count();
    assert!(fading(&air) > fading(&solid) && fading(&air) > 2, "{} {}", fading(&solid), fading(&air));
    for (solid, air) in solid.iter().zip(&air) {
        assert_eq!(solid.0, air.0);
        // Compared with the solid Earth, the atmosphere only adds refracted light in the umbra.
        assert!(air.1 <= solid.1 || solid.1 < 0.12, "{solid:?} {air:?}");
    }
}

/// Elements of the telescope that are so old that its position is unknown by more than the field give the verdict
/// `unknown` with the reason, no windows, and an error of `passes`.
#[test]
fn old_elements_of_the_telescope_are_no_clear_exposures() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("s.csv").display().to_string();
    // The epoch of the elements is 2026-03-20T12:34:57.
    let days = ["2026-03-20T13", "2026-03-21T06", "2026-03-30T12", "2026-10-01T06", "2028-01-01T06", "2025-12-01T06"];
    let rows: String = days
        .iter()
        .flat_map(|day| (0..12).map(move |turn| format!("{day},{day}:00:00Z,30,{},0\n", 30 * turn)))
        .collect();
    fs::write(&path, format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{rows}")).unwrap();
    let verdicts = |fov: &str| {
        let words = ["flag", "--schedule", &path, "--fov", fov, "--observer-elements", OBSERVER, "--format", "json"];
        let (code, stdout, stderr) = run(&[&words, SHELLS]);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).unwrap()["flags"].as_array().unwrap().clone()
    };
    // After 10 days the position is known within 25 km (68 %), 0.7 deg at 2,000 km.
    for (fov, known) in [("10deg", &days[..3]), ("0.5deg", &days[..2]), ("0.01deg", &[])] {
        let flags = verdicts(fov);
        let judged: Vec<&Value> = flags.iter().filter(|flag| flag["verdict"] != "invalid").collect();
        for day in days {
            let of_day = judged.iter().filter(|flag| flag["exposure_id"] == day);
            assert!(of_day.count() > 4, "{day}");
        }
        for flag in judged {
            let is_known = known.iter().any(|day| flag["exposure_id"] == *day);
            assert_eq!(flag["verdict"] != "unknown", is_known, "{fov}: {flag}");
            let reasons = flag["reasons"].to_string();
            assert_eq!(reasons.contains(" of the telescope 90001: its position is "), !is_known, "{fov}: {flag}");
            assert!(is_known || flag["p_any"].is_null() && flag["elements_age_days"].is_number(), "{flag}");
        }
    }
    let flags = verdicts("10deg");
    let late = flags.iter().find(|flag| flag["exposure_id"] == days[3] && flag["verdict"] == "unknown").unwrap();
    assert!((late["elements_age_days"].as_f64().unwrap() - 194.7).abs() < 0.1, "{late}");
    // A pointing that the Earth does not hide.
    let ra = late["ra_deg"].to_string();
    let pointing = ["--ra", &ra, "--dec", "0", "--fov", "10deg", "--observer-elements", OBSERVER];
    let exposure = ["passes", "--start", "2026-10-01T06:00:00Z", "--exposure", "30s"];
    let (code, _, stderr) = run(&[&exposure, SHELLS, &pointing]);
    assert!(code == 2 && stderr.contains("elements 195 days old of the telescope 90001: its position"), "{stderr}");
    let span = ["--start", "2026-10-01T06:00:00Z", "--end", "2026-10-01T08:00:00Z", "--exposure", "30s"];
    let (_, stdout, stderr) = run(&[&["windows", "--format", "json", "--shells", "oneweb"], &pointing, &span]);
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    assert!(answer["windows"].as_array().unwrap().is_empty() && stderr.contains("of the telescope 90001"), "{stderr}");
}

/// The verbs of frames and streaks state that the position of the telescope is unknown, by the rule of `flag`: after
/// two days a field of 0.1 deg is too small.
#[test]
fn frames_of_a_telescope_of_unknown_position_have_a_warning() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (synthetic, frame, output) = (path("small.toml"), path("visit.fits"), path("output.fits"));
    let table = path("streaks.csv");
    fs::write(
        &synthetic,
        "columns = 512\nrows = 512\npixel_scale_arcsec = 0.5\nsky_mag_arcsec2 = 21\nzero_point_1s_mag = 25\n",
    )
    .unwrap();
    fs::write(&table, "x1_pix,y1_pix,x2_pix,y2_pix\n10,20,500,480\n").unwrap();
    let orbit = ["--shells", "oneweb", "--observer-elements", OBSERVER];
    for (start, is_known) in [("2026-03-20T13:00:00Z", true), ("2026-03-22T13:00:00Z", false)] {
        let exposure = ["--start", start, "--exposure", "30s"];
        let new = ["--synthetic", &synthetic, "--ra", "270", "--dec", "0", "--seeing", "1arcsec"];
        run(&[
            &["inject", "-o", &frame, "--random-streaks", "1", "--magnitude", "9", "--pixels-only"],
            &new,
            &exposure,
        ]);
        for words in [
            &["inject", "--image", &frame, "-o", &output, "--seeing", "1arcsec"][..],
            &["mask", &frame, "-o", &output, "--width", "9arcsec"],
            &["measure", &frame],
            &["measure", &frame, "--streaks", &table],
            &["identify", "--end", "270,0", "--end", "270.06,0.06", exposure[0], exposure[1], exposure[2], exposure[3]],
            &["identify", "--streaks", &table, "--image", &frame],
        ] {
            let (code, _, stderr) = run(&[words, &orbit]);
            let stated = stderr.matches("old of the telescope 90001: its position is known within").count();
            assert!(code < 2 && stated == usize::from(!is_known), "{words:?}: {stderr}");
        }
        // Without a length of the streak, only elements older than the calibration are too old.
        let (_, _, stderr) = run(&[
            &[
                "identify",
                "--ra",
                "270",
                "--dec",
                "0",
                "--position-angle",
                "9",
                exposure[0],
                start,
                "--exposure",
                "30s",
            ],
            &orbit,
        ]);
        assert!(!stderr.contains("of the telescope"), "{stderr}");
    }
}

/// The reason of a gap in the ephemeris of the telescope is stated: states too far apart, or a wrong one.
#[test]
fn gaps_of_the_telescope_have_reasons() {
    const EPHEMERIS: &str = include_str!("../data/ephemerides/invented.oem");
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let rows: String = (0..12).map(|turn| format!("{turn},2024-08-14T00:50:00Z,60,{},0\n", 30 * turn)).collect();
    fs::write(path("s.csv"), format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{rows}")).unwrap();
    let judged_with = |ephemeris: &str| {
        let schedule = path("s.csv");
        let flag = ["flag", "--schedule", &schedule, "--fov", "5deg", "--format", "json", "--shells", "oneweb"];
        let (code, stdout, stderr) = run(&[&flag, &["--observer-elements", ephemeris]]);
        assert_eq!(code, 0, "{stderr}");
        (serde_json::from_str::<Value>(&stdout).unwrap()["flags"].to_string(), stderr)
    };
    let judged = |text: String| {
        fs::write(path("a.oem"), text).unwrap();
        judged_with(&path("a.oem"))
    };
    let is_state = |line: &str| line.starts_with("2024-");
    // Every sixth state.
    let mut count = 0;
    let coarse = EPHEMERIS.lines().filter(|line| {
        count += usize::from(is_state(line));
        !is_state(line) || count % 6 == 1
    });
    let coarse: String = coarse.map(|line| format!("{line}\n")).collect();
    let (flags, stderr) = judged(coarse.clone());
    let reason = "s apart; allowed: ";
    assert!(flags.contains(reason) && flags.contains(", a twentieth of a revolution"), "{flags}");
    assert!(stderr.contains("with gaps: exposures in gaps and outside are invalid (first gap from "), "{stderr}");
    // Another ephemeris without the gaps covers them.
    fs::create_dir(path("both")).unwrap();
    fs::write(path("both/coarse.oem"), &coarse).unwrap();
    fs::write(path("both/whole.oem"), EPHEMERIS).unwrap();
    let (flags, stderr) = judged_with(&path("both"));
    assert!(!flags.contains("gap from") && !stderr.contains("gap"), "{flags} {stderr}");
    // One state is 5 km off. Times of the file are TAI.
    let shifted = |line: &str| match line.split_once(' ') {
        Some((time, cells)) if time.starts_with("2024-08-14T00:50:37") => {
            let (x, others) = cells.split_once(' ').unwrap();
            format!("{time} {:.9} {others}\n", x.parse::<f64>().unwrap() + 5.0)
        }
        _ => format!("{line}\n"),
    };
    let (flags, stderr) = judged(EPHEMERIS.lines().map(shifted).collect());
    let reason = "the state of 2024-08-14T00:50:00 UTC is 5.0 km off the curve through its neighbours; allowed: 0.1 km";
    assert!(flags.contains(reason) && stderr.contains(reason), "{flags} {stderr}");
    let (flags, stderr) = judged(EPHEMERIS.to_owned());
    assert!(!flags.contains("gap from") && !stderr.contains("gap"), "{flags} {stderr}");
}
