//! `windows`: comparison with `passes` at random times, and file formats of schedulers.

use std::fs;

use crate::common::cli::{SKY, done, json, path, published_constellation, records, run};
use crate::common::random::Random;
use hifitime::Epoch;
use serde_json::Value;
use streakcast::config::Config;
use streakcast::frames::parse_instant;
use streakcast::frames::{EopTable, Orientation, seconds_after, seconds_between};
use streakcast::geometry::SunState;
use streakcast::passes::{Exposure, PassOptions};
use streakcast::schedule::{FlagRequest, Policy, WindowRequest, WindowTarget, clear_windows, lowest_altitude_rad};

const LIMIT_MAG: f64 = 6.5;
const MARGIN_S: f64 = 1.0;
/// Number of opening times that are checked for each target.
const TRIALS: usize = 400;

fn utc(text: &str) -> Epoch {
    parse_instant(text, None).unwrap()
}

/// The Sun does not set at latitude 78 in June.
#[test]
fn a_site_without_darkness_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let targets = path(&folder, "targets.csv");
    fs::write(&targets, "name,ra_deg,dec_deg,exposure_s\npole,0,89,30\n").unwrap();
    let place = ["--shells", "oneweb", "--lat", "78", "--lon", "15", "--fov", "1deg", "--night", "2024-06-21"];
    let (code, _, stderr) = run(&[&["windows", "--targets", &targets], &place]);
    assert_eq!(code, 0, "{stderr}");
    let why = "warning: it does not get dark at latitude 78.000, longitude 15.000 deg between 2024-06-21T";
    assert!(stderr.contains(why) && stderr.contains("target pole has no window"), "{stderr}");
}

/// A target by name or coordinates has the windows of a list with the same target, and local times on request.
#[test]
fn one_target_needs_no_list() {
    let folder = tempfile::tempdir().unwrap();
    let targets = path(&folder, "targets.csv");
    fs::write(&targets, "name,ra_deg,dec_deg,exposure_s\nM31,10.684793,41.269065,60\n").unwrap();
    let rest = ["--night", "2024-08-14", "--lat", "41.4", "--lon", "2.1", "--shells", "starlink-gen1", "--fov", "3deg"];
    let windows = |more: &[&str]| json(&[&["windows"], &rest, more])["windows"].as_array().unwrap().clone();
    let of_list = windows(&["--targets", &targets]);
    let of_name = windows(&["--target", "M31", "--exposure", "1min", "--time-zone", "Europe/Madrid"]);
    let of_angles = windows(&["--ra", "10.684793", "--dec", "41.269065", "--exposure", "60s"]);
    assert!(of_list.len() > 3 && of_name.len() == of_list.len() && of_angles.len() == of_list.len());
    let start = |row: &Value| utc(row["first_start_utc"].as_str().unwrap());
    for ((listed, named), angles) in of_list.iter().zip(&of_name).zip(&of_angles) {
        assert_eq!(listed["first_start_utc"], angles["first_start_utc"]);
        // The position of the name differs by some arcseconds.
        assert!(seconds_between(start(listed), start(named)).abs() < 0.1, "{listed} {named}");
        let local = named["first_start_local"].as_str().unwrap();
        let same = utc(&local.replacen(' ', "T", 1).replace(' ', ""));
        // Local times are rounded up to a second, so that they are inside the window.
        let later_s = seconds_between(start(named), same);
        assert!((0.0..=1.0).contains(&later_s) && local.ends_with("+02:00"), "{named}");
    }
    let (code, _, stderr) = run(&[&["windows", "--target", "M31"], &rest]);
    assert!(code == 2 && stderr.contains("missing exposure time; specify --exposure TIME"), "{stderr}");
}

/// Exposures at random times: inside the windows no satellite crosses; outside a satellite crosses, or the altitude of
/// target or Sun is not allowed.
#[test]
fn verif_windows_agree_with_passes() {
    let config = Config::from_toml("shells = 'starlink-gen1'\nmpc = 'X05'\nfov = '6deg'", "t.toml").unwrap();
    let (from, to) = (utc("2024-08-14T22:40:00Z"), utc("2024-08-15T01:00:00Z"));
    let prepared = config.prepare(from, to).unwrap();
    let (field, photometry) = (config.field_of_view().unwrap(), config.photometry().unwrap());
    let policy = Policy::from_toml(&format!("limit_mag = {LIMIT_MAG}\nmargin_s = {MARGIN_S}")).unwrap();
    let (min_altitude_deg, max_sun_altitude_deg) = (30.0_f64, -10.0_f64);
    let request = WindowRequest {
        conditions: FlagRequest {
            sky: &prepared.sky,
            field: &field,
            policy: &policy,
            telescope: None,
            photometry: &photometry,
        },
        min_altitude_rad: min_altitude_deg.to_radians(),
        max_sun_altitude_rad: Some(max_sun_altitude_deg.to_radians()),
    };
    let target = |ra_deg: f64, dec_deg: f64, duration_s: f64| WindowTarget {
        exposure: Exposure {
            id: format!("{ra_deg} {dec_deg}"),
            start: from,
            duration_s,
            pointing: streakcast::frames::Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians()),
            rotation_rad: 0.0,
        },
        band: None,
    };
    let targets =
        [target(217.5, -30.0, 15.0), target(255.0, -60.0, 60.0), target(200.0, -5.0, 5.0), target(0.0, 60.0, 30.0)];
    let report = clear_windows(&targets, from, to, &request).unwrap();
    assert!(report.by_target[3].windows.is_empty() && report.by_target[3].observable.is_empty());

    let observer = prepared.sky.viewpoint().site().unwrap().clone();
    let sun_deg = |epoch: Epoch| {
        let state = observer.state(&Orientation::at(epoch, &EopTable::embedded()));
        state.sine_of_altitude(&(SunState::at(epoch).sun - state.position)).asin().to_degrees()
    };
    let mut random = Random(20240814);
    let (mut inside, mut crossed, mut forbidden) = (0, 0, 0);
    for (target, found) in targets.iter().zip(&report.by_target) {
        let windows = &found.windows;
        assert!(windows.iter().all(|window| window.first <= window.last && window.first >= from && window.last <= to));
        assert!(windows.windows(2).all(|pair| pair[0].last < pair[1].first));
        // Random opening times, and the ends of the windows.
        let mut starts: Vec<Epoch> = (0..TRIALS)
            .map(|_| seconds_after(from, random.between(0.0, seconds_between(from, to) - target.exposure.duration_s)))
            .collect();
        starts.extend(windows.iter().take(40).flat_map(|window| [window.first, window.last]));
        // The margin is included at both ends.
        let exposures: Vec<Exposure> = starts
            .iter()
            .map(|start| Exposure {
                start: seconds_after(*start, -MARGIN_S),
                duration_s: target.exposure.duration_s + 2.0 * MARGIN_S,
                ..target.exposure.clone()
            })
            .collect();
        let answer = prepared.sky.field_passes(&exposures, &field, &PassOptions::default()).unwrap();
        for ((start, exposure), passes) in starts.iter().zip(&exposures).zip(&answer.by_exposure) {
            let bright = passes.iter().filter(|pass| pass.probability_brighter_than(LIMIT_MAG) >= 0.5).count();
            let is_inside = windows.iter().any(|window| (window.first..=window.last).contains(start));
            let shutter = Exposure { start: *start, ..target.exposure.clone() };
            let lowest_deg = lowest_altitude_rad(&shutter, prepared.sky.viewpoint(), &prepared.eop).to_degrees();
            let end = seconds_after(*start, target.exposure.duration_s);
            let highest_sun_deg = sun_deg(*start).max(sun_deg(end));
            if is_inside {
                inside += 1;
                assert_eq!(bright, 0, "{} {start}", exposure.id);
                assert!(lowest_deg >= min_altitude_deg - 1e-4, "{start}: {lowest_deg}");
                assert!(highest_sun_deg <= max_sun_altitude_deg + 1e-4, "{start}: {highest_sun_deg}");
            } else if lowest_deg >= min_altitude_deg + 1e-3 && highest_sun_deg <= max_sun_altitude_deg - 1e-3 {
                crossed += 1;
                if bright == 0 {
                    // A pass blocks from entry to exit, also while it is faint or in shadow, with a guard of 2 ms.
                    let begin = seconds_after(exposure.start, -0.003);
                    let end = seconds_after(exposure.start, exposure.duration_s + 0.003);
                    let touches =
                        found.blocking_passes.iter().any(|pass| pass.enter.epoch <= end && pass.exit.epoch >= begin);
                    assert!(touches, "{} {start}: outside of all windows, and nothing crosses", exposure.id);
                }
            } else {
                forbidden += 1;
            }
        }
    }
    assert!(
        inside > 300 && crossed > 60 && forbidden > 100,
        "{inside} inside, {crossed} crossed, {forbidden} forbidden"
    );
}

const CSV: &str = "name,ra,dec,exposure,unique_id\nA,14h30m,-30d00m,30,17\nlost,,,30,18\nnorth,10,80,30,19\n";
const RANGE: &[&str] = &["--start", "2024-08-14T23:20:00Z", "--end", "2024-08-14T23:50:00Z"];

#[test]
fn lists_in_every_syntax_give_the_same_windows() {
    let folder = tempfile::tempdir().unwrap();
    let list = |name: &str, text: &str| {
        let path = path(&folder, name);
        fs::write(&path, text).unwrap();
        path
    };
    let csv = list("t.csv", CSV);
    let windows = |path: &str| {
        json(&[&["windows", "--targets", path, "--fov", "6deg", "--limit-mag", "7"], RANGE, SKY])["windows"].clone()
    };
    let expected = windows(&csv);
    assert!(expected.as_array().unwrap().len() > 3, "{expected}");
    // The last exposure of 30 s ends with the range, as in Python.
    let last =
        expected.as_array().unwrap().iter().map(|one| utc(one["last_start_utc"].as_str().unwrap())).max().unwrap();
    assert!(seconds_between(utc("2024-08-14T23:49:30Z"), last) < 1e-3, "{last}");
    let ecsv = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: name, datatype: string}\n# - {name: ra_deg, unit: deg, datatype: float64}\n\
                # - {name: dec_deg, unit: deg, datatype: float64}\n# - {name: exposure_s, unit: s, datatype: float64}\n# - {name: unique_id, datatype: string}\n\
                name ra_deg dec_deg exposure_s unique_id\nA 217.5 -30 30 17\n";
    assert_eq!(windows(&list("t.ecsv", ecsv)), expected);
    let text = r#"{"targets": [{"name": "A", "ra_deg": 217.5, "dec_deg": -30, "exposure_s": 30, "unique_id": 17}]}"#;
    assert_eq!(windows(&list("t.json", text)), expected);

    let answer = json(&[&["windows", "--targets", &csv, "--fov", "6deg", "--limit-mag", "7"], RANGE, SKY]);
    let reasons: Vec<&str> =
        answer["targets"].as_array().unwrap().iter().map(|one| one["reason"].as_str().unwrap_or("")).collect();
    assert_eq!(
        reasons,
        [
            "",
            "right ascension is missing; allowed: degrees, or text such as 12h34m",
            "never above the lowest altitude in the dark"
        ]
    );
    // In every format, targets without a window are reported.
    let loud: Vec<&str> = SKY.iter().copied().filter(|word| *word != "--quiet").collect();
    for format in ["table", "csv", "json", "lco"] {
        let command = ["windows", "--targets", &csv, "--fov", "6deg", "--limit-mag", "7", "--format", format];
        let (code, _, stderr) = run(&[&command, RANGE, &loud]);
        assert_eq!(code, 0);
        for warning in [
            "t.csv, row 2, target lost is invalid: right ascension is missing; allowed: degrees",
            "warning: target north has no window: never above the lowest altitude in the dark\n",
        ] {
            assert!(stderr.contains(warning), "{format}: {stderr}");
        }
        assert_eq!(stderr.matches("has no window").count(), 1, "{format}: {stderr}");
        assert!(stderr.ends_with("\n2 targets and 1 invalid row: 6 windows\n"), "{format}: {stderr}");
    }
}

/// Invalid rows are not targets without a window, and a list of invalid rows has no result.
#[test]
fn invalid_rows_of_a_list_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let targets = path(&folder, "t.csv");
    let loud: Vec<&str> = SKY.iter().copied().filter(|word| *word != "--quiet").collect();
    let windows = |rows: &str| {
        fs::write(&targets, format!("name,ra,dec,exposure,count\n{rows}")).unwrap();
        run(&[&["windows", "--targets", &targets, "--fov", "6deg", "--limit-mag", "7"], RANGE, &loud])
    };
    let invalid = "B,abc,-30,30,1\nC,217.5,-30,30,20\nD,217.5,-30,-30,1\nE,217.5,-30,,1\n";
    let (code, _, stderr) = windows(&format!("A,217.5,-30,30,1\n{invalid}"));
    assert_eq!(code, 0, "{stderr}");
    for part in [
        "t.csv, row 2, target B is invalid: \"abc\" is not a right ascension",
        "t.csv, row 3, target C is invalid: count is 20; allowed: 1, with the time",
        "t.csv, row 4, target D is invalid: exposure is -30 s; allowed: above 0 to 86400",
        "warning: 1 more invalid targets in the list\n",
        "\n1 target and 4 invalid rows: ",
    ] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    assert!(!stderr.contains("has no window"), "{stderr}");
    let (code, stdout, stderr) = windows(invalid);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    assert!(stderr.contains("row 1, target B is invalid: ") && stderr.contains("(and all 3 other rows)"), "{stderr}");
}

/// An exposure that is longer than the range, or than the time in which the target is up in the dark, is the reason.
#[test]
fn too_long_exposures_are_named() {
    let loud: Vec<&str> = SKY.iter().copied().filter(|word| *word != "--quiet").collect();
    let reason = |exposure: &str, range: &[&str]| {
        let target = ["windows", "--ra", "217.5", "--dec", "-30", "--fov", "6deg", "--exposure", exposure];
        run(&[&target, range, &loud]).2
    };
    let of_range = reason("40min", RANGE);
    assert!(
        of_range.contains("the exposure of 2400 s is longer than the time of the range")
            && of_range.contains("dark: 1800 s"),
        "{of_range}"
    );
    let of_night = reason("10h", &["--night", "2024-08-14"]);
    assert!(of_night.contains("the exposure of 36000 s is longer than the "), "{of_night}");
    assert!(![of_range, of_night].iter().any(|text| text.contains("never above")));
}

#[test]
fn formats_of_schedulers() {
    let folder = tempfile::tempdir().unwrap();
    let targets = path(&folder, "t.csv");
    fs::write(&targets, CSV).unwrap();
    let shaped = |format: &str| {
        done(&[
            &["windows", "--targets", &targets, "--fov", "6deg", "--limit-mag", "7", "--format", format],
            RANGE,
            SKY,
        ])
    };
    let rows = records(&shaped("csv"));
    assert_eq!(
        rows[0].iter().collect::<Vec<_>>().join(","),
        "name,unique_id,first_start_utc,last_start_utc,length_s,ra_deg,dec_deg,exposure_s,elements_age_days,late_s"
    );
    let spans: Vec<(Epoch, Epoch)> = rows[1..].iter().map(|row| (utc(&row[2]), utc(&row[3]))).collect();
    let clear = |start: Epoch, end: Epoch| {
        spans.iter().any(|(first, last)| *first <= start && end <= seconds_after(*last, 30.0))
    };

    let lco: Value = serde_json::from_str(&shaped("lco")).unwrap();
    let windows = lco["requests"][0]["windows"].as_array().unwrap();
    assert!(!windows.is_empty());
    assert!(windows.iter().all(|one| clear(utc(one["start"].as_str().unwrap()), utc(one["end"].as_str().unwrap()))));
    let p2: Value = serde_json::from_str(&shaped("eso-p2")).unwrap();
    let p2_windows = p2[0]["absoluteTimeConstraints"].as_array().unwrap();
    assert!(p2_windows.iter().all(|one| one["from"].as_str().unwrap().len() == 16));
    let minute = |one: &Value| utc(&format!("{}:00Z", one.as_str().unwrap()));
    assert!(
        p2_windows
            .iter()
            .all(|one| spans.iter().any(|(first, last)| *first <= minute(&one["from"]) && minute(&one["to"]) <= *last))
    );
    let astroq = shaped("astroq");
    assert!(astroq.starts_with("unique_id,starname,start,stop\n17,A,2024-08-14T23:"), "{astroq}");
    let astroq = records(&astroq);
    assert_eq!(astroq.len() - 1, windows.len());
    assert!(astroq[1..].iter().all(|row| clear(utc(&format!("{}Z", &row[2])), utc(&format!("{}Z", &row[3])))));
    // A whole night, specified by its date, contains these windows.
    let night =
        json(&[&["windows", "--targets", &targets, "--fov", "6deg", "--limit-mag", "7", "--night", "2024-08-14"], SKY]);
    let firsts: Vec<Epoch> =
        night["windows"].as_array().unwrap().iter().map(|one| utc(one["first_start_utc"].as_str().unwrap())).collect();
    assert!(spans[1..].iter().all(|(first, _)| firsts.iter().any(|one| seconds_between(*first, *one).abs() < 5e-3)));
}

/// Satellites that pass before or after the range, and may be late or early, block starts like those of a longer range.
#[test]
fn satellites_beyond_the_ends_of_the_range_may_be_late() {
    let folder = tempfile::tempdir().unwrap();
    let policy = path(&folder, "p.toml");
    fs::write(&policy, "min_probability = 0.01").unwrap();
    let elements = published_constellation(&folder, "2024-08-04T00:00:00 UTC");
    let windows = |start: Epoch, end: Epoch| -> Vec<(Epoch, Epoch)> {
        let [start, end] = [start, end].map(|epoch| streakcast::output::format_utc(epoch, 3));
        let range = ["windows", "--ra", "217.5", "--dec=-30", "--exposure", "60s", "--start", &start, "--end", &end];
        let more = [&elements[0], &elements[1], "--mpc", "X05", "--fov", "0.5deg", "--policy", &policy, "--quiet"];
        let found = json(&[&range, &more]);
        let time = |row: &Value, name: &str| utc(row[name].as_str().unwrap());
        let rows = found["windows"].as_array().unwrap().iter();
        rows.map(|row| (time(row, "first_start_utc"), time(row, "last_start_utc"))).collect()
    };
    let (from, to) = (utc("2024-08-14T22:50:00Z"), utc("2024-08-15T00:50:00Z"));
    let long = windows(from, to);
    assert!(long.len() > 2, "{long:?}");
    let mut cut = 0;
    for pair in long.windows(2) {
        // The range ends 1 s after a window, and another one begins 1 s before the next window: the satellite in
        // between is predicted outside both.
        let ends = [seconds_after(pair[0].1, 60.0 + 1.0), seconds_after(pair[1].0, -1.0)];
        for (first, last) in windows(from, ends[0]).into_iter().chain(windows(ends[1], to)) {
            // Windows of parts of the range are inside those of the whole range.
            let is_inside = |whole: &(Epoch, Epoch)| {
                seconds_between(whole.0, first) > -0.2 && seconds_between(last, whole.1) > -0.2
            };
            assert!(long.iter().any(is_inside), "{first} {last} {long:?}");
            cut += 1;
        }
    }
    assert!(cut > 2, "{long:?}");
}

#[test]
fn invalid_arguments_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let targets = path(&folder, "t.csv");
    fs::write(&targets, CSV).unwrap();
    let [schedule, empty] = ["schedule.csv", "schedule"].map(|name| path(&folder, name));
    fs::write(&schedule, "name,dec_deg\na,1\n").unwrap();
    fs::write(&empty, "").unwrap();
    let [without_ra, without_rows] = [(&schedule, ": missing ra_deg"), (&empty, " is empty")]
        .map(|(file, end)| format!("error: target list {file}{end}"));
    let policy = path(&folder, "p.toml");
    fs::write(&policy, "max_cost_s = 1").unwrap();
    let base: &[&str] = &["windows", "--targets", &targets, "--fov", "6deg"];
    for (arguments, part) in [
        (&[base, SKY, &["--night", "tomorrow"]][..], "'tomorrow' for '--night <DATE>': not a night"),
        (
            &[base, SKY, &["--start", "2024-08-14T23:20:00Z", "--end", "2024-08-14T22:20:00Z"]],
            "the end not before the start",
        ),
        (&[base, SKY, RANGE, &["--format", "xlsx"]], "lco, eso-p2, astroq"),
        (&[base, SKY, RANGE, &["--min-altitude", "95"]], "min-altitude is 95 deg; allowed: -90 to 90"),
        (
            &[base, SKY, RANGE, &["--policy", &policy, "--telescope", "rubin"]],
            "the policy has max_cost_s, but windows are computed from the times of passes, without the cost of each start; allowed: limit_mag",
        ),
        (&[&["windows", "--targets", &schedule, "--fov", "6deg"], SKY, RANGE], &without_ra),
        (&[&["windows", "--targets", &empty, "--fov", "6deg"], SKY, RANGE], &without_rows),
        (&[&["windows", "--targets", "/nowhere.csv", "--fov", "6deg"], SKY, RANGE], "/nowhere.csv"),
    ] {
        let (code, stdout, stderr) = run(arguments);
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        assert!(stderr.contains(part), "'{part}' is not in: {stderr}");
    }
}
