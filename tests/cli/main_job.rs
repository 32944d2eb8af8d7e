//! The main task of the command line: passes and verdicts in every format, from elements and a schedule.

use std::fs;

use crate::common::cli::{FLAG, SKY, done, json, path, records, run};
use serde_json::Value;
use streakcast::frames::{Direction, Horizontal, Position};
use streakcast::geometry::{Site, ellipsoidal_height_km};

const PASSES: &[&str] = &[
    "passes",
    "--start",
    "2024-08-14T23:30:00.000Z",
    "--exposure",
    "120s",
    "--ra",
    "14h30m",
    "--dec=-30",
    "--fov",
    "20deg",
];

/// Returns forty exposures of an evening as CSV.
fn evening() -> String {
    let mut text = "exposure_id,start_utc,duration_s,ra_deg,dec_deg,rotation_deg,band\n".to_owned();
    for number in 0..40 {
        let (minute, second) = (number * 45 / 60 + 5, number * 45 % 60);
        let (ra, dec) = (200.0 + 1.5 * f64::from(number), -50.0 + f64::from(number));
        text += &format!("v{number},2024-08-14T23:{minute:02}:{second:02}.000Z,30,{ra},{dec},12.5,r\n");
    }
    text
}

#[test]
fn passes_agree_in_every_format() {
    let answer = json(&[PASSES, SKY]);
    let passes = answer["passes"].as_array().unwrap();
    assert!(passes.len() > 3, "{} passes", passes.len());
    assert_eq!(answer["exposures"][0]["start_utc"], "2024-08-14T23:30:00.000000Z");
    assert_eq!(answer["exposures"][0]["ra_deg"], 217.5);
    assert_eq!(answer["provenance"]["shells"][0]["synthetic"], true);
    assert!(answer["left_out"].as_array().unwrap().is_empty());

    let csv = done(&[PASSES, SKY, &["--format", "csv"]]);
    let rows = records(&csv);
    let names: Vec<&str> = rows[0].iter().collect();
    let law = "exposure_id, norad_id, name, international_designator, enter_utc, mid_utc, exit_utc, enter_ra_deg, enter_dec_deg, mid_ra_deg, \
               mid_dec_deg, exit_ra_deg, exit_dec_deg, min_separation_deg, streak_length_deg, position_angle_deg, angular_rate_deg_s, \
               altitude_deg, azimuth_deg, range_km, height_km, phase_angle_deg, illumination, lit_fraction, magnitude, magnitude_sigma, \
               magnitude_peak, band, mag_system, mag_source, effective_magnitude, surface_brightness_mag_arcsec2, width_arcsec, \
               element_age_days, along_track_sigma_s, cross_track_sigma_deg, probability, position_source, magnitude_peak_sigma, \
               streak_cost_s, p_bright, in_fitted_range";
    assert_eq!(names.join(", "), law);
    assert!(csv.lines().next().unwrap().starts_with("# software: \"streakcast\""));
    // ECSV has True for true.
    let ecsv =
        done(&[PASSES, SKY, &["--format", "ecsv"]]).replace(",True\n", ",true\n").replace(",False\n", ",false\n");
    assert_eq!(records(&ecsv), rows);
    let lines = done(&[PASSES, SKY, &["--format", "jsonl"]]);
    let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(&lines[1..], passes.as_slice());
    assert_eq!(rows.len() - 1, passes.len());
    for (row, pass) in rows[1..].iter().zip(passes) {
        for (name, cell) in names.iter().zip(row) {
            match &pass[*name] {
                Value::Null => assert_eq!(cell, "", "{name}"),
                Value::String(text) => assert_eq!(cell, text, "{name}"),
                Value::Bool(value) => assert_eq!(cell, value.to_string(), "{name}"),
                number => assert_eq!(cell.parse::<f64>().unwrap(), number.as_f64().unwrap(), "{name}"),
            }
        }
    }
}

/// Share of a streak: the mask of two widths, and 8 % of a bright streak across the whole field.
#[test]
fn costs_follow_from_the_columns() {
    let mut uncertain = 0;
    let sky = ["--shells", "oneweb", "--mpc", "X05", "--quiet", "--telescope", "rubin"];
    for pass in json(&[PASSES, &sky])["passes"].as_array().unwrap() {
        let number = |name: &str| pass[name].as_f64().unwrap_or_else(|| panic!("{name} in {pass}"));
        let [p, p_bright, length_deg, width_arcsec] =
            ["probability", "p_bright", "streak_length_deg", "width_arcsec"].map(number);
        let masked = length_deg * 2.0 * width_arcsec / 3600.0 / 314.16;
        let expected_s = 120.0 * p * (masked + p_bright * 0.08 * length_deg / 20.0);
        let cost_s = number("streak_cost_s");
        assert!((cost_s - expected_s).abs() < 0.002 + 0.01 * cost_s, "{pass}: {expected_s} s");
        uncertain += usize::from(p_bright > 0.02 && p_bright < 0.98);
    }
    assert!(uncertain > 0, "every streak is certainly bright or faint");
}

#[test]
fn rows_are_self_consistent() {
    let site = Site::from_mpc("X05").unwrap();
    for pass in json(&[PASSES, SKY, &["--samples", "5", "--telescope", "rubin"]])["passes"].as_array().unwrap() {
        let number = |name: &str| pass[name].as_f64().unwrap_or_else(|| panic!("{name} in {pass}"));
        let text = |name: &str| pass[name].as_str().unwrap().to_owned();
        // ISO times of equal length are ordered like their text.
        assert!(text("enter_utc") <= text("mid_utc") && text("mid_utc") <= text("exit_utc"), "{pass}");
        assert!(text("enter_utc").as_str() >= "2024-08-14T23:30:00.000000Z");
        assert!(text("exit_utc").as_str() <= "2024-08-14T23:32:00.000000Z");
        assert!(number("min_separation_deg") <= 10.0 && number("streak_length_deg") <= 20.1, "{pass}");
        assert!((0.0..=1.0).contains(&number("probability")) && number("probability") > 0.01);
        assert!(number("range_km") > 500.0, "{pass}");
        // The height from site, altitude, azimuth and range; a satellite moves by 0.03 km while its light travels.
        let [azimuth_rad, altitude_rad] = ["azimuth_deg", "altitude_deg"].map(|name| number(name).to_radians());
        let seen = Direction::<Horizontal>::from_lon_lat_rad(azimuth_rad, altitude_rad);
        let line_km = (site.horizon().inverse() * seen).vector() * number("range_km");
        let height_km = ellipsoidal_height_km(&Position::from_vector(site.itrs().vector() + line_km));
        assert!((number("height_km") - height_km).abs() < 0.05, "{height_km} {pass}");
        assert!(number("magnitude_peak") <= number("magnitude") && number("magnitude_sigma") > 0.0, "{pass}");
        assert!(number("effective_magnitude") > number("magnitude") + 5.0 && number("width_arcsec") > 0.7, "{pass}");
        let samples = pass["samples"].as_array().unwrap();
        assert_eq!(samples.len(), 5);
        assert_eq!(samples[0]["utc"], pass["enter_utc"]);
        assert_eq!(samples[4]["ra_deg"], pass["exit_ra_deg"]);
        let chords = pass["chords"].as_array().unwrap();
        assert_eq!((&chords[0]["enter_utc"], chords.len()), (&pass["enter_utc"], 1));
    }
}

#[test]
fn equivalent_arguments() {
    let expected = json(&[PASSES, SKY])["passes"].clone();
    let respelled: &[&[&str]] = &[
        &[
            "--start",
            "2024-08-14T23:30:37",
            "--time-scale",
            "tai",
            "--ra",
            "217.5",
            "--dec",
            "-30d00m",
            "--exposure",
            "2min",
            "--fov",
            "1200arcmin",
        ],
        &[
            "--start",
            "2024-08-14 23:30Z",
            "--ra",
            "14:30:00",
            "--dec",
            "-30",
            "--exposure",
            "120.0s",
            "--fov",
            "20 deg",
        ],
    ];
    for words in respelled {
        assert_eq!(json(&[&["passes"], words, SKY])["passes"], expected, "{words:?}");
    }
    let site = ["--shells", "starlink-gen1", "--lat", "-30.244639", "--lon=-70.749417", "--height", "2663", "-q"];
    let by_name = ["--shells", "starlink-gen1", "--site", "rubin observatory", "-q"];
    assert_eq!(json(&[PASSES, &site])["passes"].as_array().unwrap().len(), expected.as_array().unwrap().len());
    assert_eq!(json(&[PASSES, &by_name])["passes"], expected);
    let one_thread = json(&[PASSES, SKY, &["--threads", "1"]]);
    assert_eq!(one_thread["passes"], expected);
}

#[test]
fn nothing_found_is_exit_code_one() {
    let narrow = [
        "passes",
        "--start",
        "2024-08-14T23:30:00Z",
        "--exposure",
        "1ms",
        "--ra",
        "217.5",
        "--dec",
        "-30",
        "--fov",
        "1arcsec",
    ];
    let (code, stdout, stderr) = run(&[&narrow, &["--shells", "qianfan", "--mpc", "X05", "--format", "json"]]);
    assert_eq!(code, 1, "{stderr}");
    assert!(serde_json::from_str::<Value>(&stdout).unwrap()["passes"].as_array().unwrap().is_empty());
    assert!(stderr.contains("simulated constellation") && stderr.contains("no passes"), "{stderr}");
}

#[test]
fn schedules_in_four_formats_give_the_same_flags() {
    let folder = tempfile::tempdir().unwrap();
    let csv = evening();
    fs::write(path(&folder, "s.csv"), &csv).unwrap();
    let rows = records(&csv);
    let objects: Vec<String> = rows[1..]
        .iter()
        .map(|row| format!(r#"{{"exposure_id": "{}", "start_utc": "{}", "duration_s": {}, "ra_deg": {}, "dec_deg": {}, "rotation_deg": {}, "band": "{}"}}"#, &row[0], &row[1], &row[2], &row[3], &row[4], &row[5], &row[6]))
        .collect();
    fs::write(path(&folder, "s.json"), format!("{{\"exposures\": [{}]}}", objects.join(","))).unwrap();
    let body: String = rows.iter().map(|row| row.iter().collect::<Vec<_>>().join(" ") + "\n").collect();
    let ecsv = format!("# %ECSV 1.0\n# ---\n# datatype:\n# - {{name: ra_deg, unit: deg, datatype: float64}}\n{body}");
    fs::write(path(&folder, "s.ecsv"), ecsv).unwrap();

    let expected = done(&[&["flag", "--schedule", &path(&folder, "s.csv")], FLAG, SKY]);
    let verdicts: Vec<String> = records(&expected)[1..].iter().map(|row| row[1].to_owned()).collect();
    assert_eq!(verdicts.len(), 40);
    assert!(
        verdicts.iter().any(|verdict| verdict == "clear") && verdicts.iter().any(|verdict| verdict != "clear"),
        "{verdicts:?}"
    );
    for name in ["s.json", "s.ecsv"] {
        let found = done(&[&["flag", "--schedule", &path(&folder, name)], FLAG, SKY]);
        assert_eq!(records(&found), records(&expected), "{name}");
    }
}

#[test]
fn a_next_clear_start_is_the_earliest_clear_one() {
    /// Field of ten degrees, so that some exposures must be delayed.
    const WIDE: &[&str] = &["--fov", "10deg"];
    let folder = tempfile::tempdir().unwrap();
    fs::write(path(&folder, "s.csv"), evening()).unwrap();
    let flags = json(&[&["flag", "--schedule", &path(&folder, "s.csv")], WIDE, SKY])["flags"].clone();
    let mut later = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\n".to_owned();
    let mut earlier = later.clone();
    let mut waiting = 0;
    for (flag, row) in flags.as_array().unwrap().iter().zip(&records(&evening())[1..]) {
        let delay_s = flag["delay_s"].as_f64();
        assert_eq!(flag["verdict"] == "clear", delay_s == Some(0.0), "{flag}");
        let Some(start) = flag["next_clear_start_utc"].as_str() else { continue };
        later += &format!("{},{start},{},{},{}\n", &row[0], &row[2], &row[3], &row[4]);
        if delay_s.is_some_and(|delay_s| delay_s > 0.01) {
            waiting += 1;
            // Ten milliseconds before the clear start, the blocking satellite is still in the field.
            let seconds: f64 = start[17..23].parse().unwrap();
            let hundredth =
                if seconds >= 0.01 { format!("{}{:06.3}Z", &start[..17], seconds - 0.01) } else { continue };
            earlier += &format!("{},{hundredth},{},{},{}\n", &row[0], &row[2], &row[3], &row[4]);
        }
    }
    assert!(waiting > 3, "{waiting} exposures wait");
    fs::write(path(&folder, "later.csv"), later).unwrap();
    fs::write(path(&folder, "earlier.csv"), earlier).unwrap();
    for flag in json(&[&["flag", "--schedule", &path(&folder, "later.csv")], WIDE, SKY])["flags"].as_array().unwrap() {
        assert_eq!(flag["verdict"], "clear", "{flag}");
    }
    for flag in json(&[&["flag", "--schedule", &path(&folder, "earlier.csv")], WIDE, SKY])["flags"].as_array().unwrap()
    {
        assert_ne!(flag["verdict"], "clear", "{flag}");
    }
}

#[test]
fn flags_agree_with_the_passes_of_their_exposures() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(path(&folder, "s.csv"), evening()).unwrap();
    let flags =
        json(&[&["flag", "--schedule", &path(&folder, "s.csv"), "--telescope", "rubin"], FLAG, SKY])["flags"].clone();
    for (flag, row) in flags.as_array().unwrap().iter().zip(&records(&evening())[1..]) {
        let one = [
            "passes",
            "--start",
            &row[1],
            "--exposure",
            "30s",
            "--ra",
            &row[3],
            "--dec",
            &row[4],
            "--fov",
            "3.5deg",
            "--telescope",
            "rubin",
            "--limit-mag",
            "6.5",
            "--format",
            "json",
        ];
        let (_, stdout, _) = run(&[&one, SKY]);
        let answer: Value = serde_json::from_str(&stdout).unwrap();
        let passes = answer["passes"].as_array().unwrap();
        assert_eq!(flag["n_streaks"], passes.len(), "{flag}");
        let ids: Vec<&Value> = passes.iter().map(|pass| &pass["norad_id"]).collect();
        assert_eq!(flag["norad_ids"].as_array().unwrap().iter().collect::<Vec<_>>(), ids);
        let peaks = || passes.iter().filter_map(|pass| pass["magnitude_peak"].as_f64());
        let brightest = peaks().fold(f64::INFINITY, f64::min);
        assert_eq!(flag["brightest_mag"].as_f64().unwrap_or(f64::INFINITY), brightest, "{flag}");
        let number = |pass: &Value, name: &str| pass[name].as_f64().unwrap();
        let odds = |pass: &Value| number(pass, "probability") * number(pass, "p_brighter");
        let avoid = passes.iter().any(|pass| odds(pass) >= 0.5);
        let expected = if avoid {
            "avoid"
        } else if passes.is_empty() {
            "clear"
        } else {
            "streaked"
        };
        assert_eq!(flag["verdict"], expected, "{flag}");
        let length: f64 = passes.iter().map(|pass| pass["streak_length_deg"].as_f64().unwrap()).sum();
        assert!((flag["streak_length_deg"].as_f64().unwrap() - length).abs() < 1e-3);
        assert_eq!(flag["expected_lost_pixel_fraction"].as_f64().unwrap() > 0.0, !passes.is_empty(), "{flag}");
        // Simulated satellites have no errors of position: the cost is the sum over the passes.
        let cost_s: f64 = passes.iter().map(|pass| number(pass, "streak_cost_s")).sum();
        assert!(
            (flag["streak_cost_s"].as_f64().unwrap() - cost_s.min(30.0)).abs() < 0.002 + 0.01 * cost_s,
            "{flag} {cost_s}"
        );
    }
}

/// Without a band of the exposure, `bright_mag` is that of the band of the magnitudes, in all tables.
#[test]
fn costs_of_flags_and_passes_have_one_bright_mag() {
    let folder = tempfile::tempdir().unwrap();
    let without_band: String =
        evening().lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned() + "\n").collect();
    fs::write(path(&folder, "s.csv"), &without_band).unwrap();
    let cost_of = |bright_mag: &str, band: &str| {
        let telescope = format!(
            "name = \"t\"\ntitle = \"T\"\nouter_radius_m = 4.2\ninner_radius_m = 2.5\nseeing_arcsec = 0.7\npixel_scale_arcsec = 0.2\n\
             field = {{ circle_deg = 3.5 }}\nbright_share = 0.08\nsource = \"test\"\nbright_mag = {bright_mag}\n"
        );
        fs::write(path(&folder, "t.toml"), telescope).unwrap();
        let telescope = path(&folder, "t.toml");
        let options = ["--telescope", &telescope, "--band", band];
        let of_flags = json(&[&["flag", "--schedule", &path(&folder, "s.csv"), "--fov", "3.5deg"], SKY, &options]);
        let rows = records(&without_band);
        let streaked = of_flags["flags"].as_array().unwrap().iter().zip(&rows[1..]);
        let (flag, row) = streaked
            .max_by(|a, b| a.0["streak_cost_s"].as_f64().unwrap().total_cmp(&b.0["streak_cost_s"].as_f64().unwrap()))
            .unwrap();
        let one =
            ["passes", "--start", &row[1], "--exposure", "30s", "--ra", &row[3], "--dec", &row[4], "--fov", "3.5deg"];
        let answer = json(&[&one, SKY, &options]);
        let passes = answer["passes"].as_array().unwrap();
        let cost_s: f64 = passes.iter().map(|pass| pass["streak_cost_s"].as_f64().unwrap()).sum();
        let of_flag = flag["streak_cost_s"].as_f64().unwrap();
        assert!((of_flag - cost_s).abs() < 0.002 + 0.01 * cost_s, "{bright_mag} {band}: {of_flag} {cost_s}");
        of_flag
    };
    let [faint, bright, other] = [
        ("{ V = 9.0, r = 1.0, default = 1.0 }", "V"),
        ("{ V = 1.0, default = 9.0 }", "V"),
        ("{ V = 9.0, default = 1.0 }", "r"),
    ]
    .map(|(bright_mag, band)| cost_of(bright_mag, band));
    assert!(faint > 3.0 * bright && faint > 3.0 * other, "{faint} {bright} {other}");
}

#[test]
fn policies_and_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(path(&folder, "s.csv"), evening()).unwrap();
    let schedule = path(&folder, "s.csv");
    let flag =
        |more: &[&str]| run(&[&["flag", "--schedule", &schedule, "--fov", "3.5deg", "--format", "jsonl"], more, SKY]);
    let count = |stdout: &str, verdict: &str| stdout.matches(&format!("\"verdict\": \"{verdict}\"")).count();
    // Without a limit no exposure is `avoid`. If all satellites are brighter than the limit, every exposure that a lit
    // satellite crosses is `avoid`.
    let (code, free, _) = flag(&["--fail-on", "avoid"]);
    assert_eq!((code, count(&free, "avoid")), (0, 0));
    let (code, strict, _) = flag(&["--limit-mag", "30", "--fail-on", "avoid"]);
    assert_eq!((code, count(&strict, "streaked")), (1, 0));
    assert_eq!(count(&strict, "avoid"), count(&free, "streaked"));
    assert_eq!(flag(&["--fail-on", "streaked"]).0, 1);

    fs::write(path(&folder, "p.toml"), "[limit_mag]\nr = 30\n").unwrap();
    let policy = path(&folder, "p.toml");
    assert_eq!(count(&flag(&["--policy", &policy]).1, "avoid"), count(&strict, "avoid"));
    fs::write(&policy, "[limit_mag]\ng = 30\n").unwrap();
    assert_eq!(count(&flag(&["--policy", &policy]).1, "avoid"), 0);
    // With a margin the number of streaked exposures is the same or larger, and each has a reason.
    fs::write(&policy, "margin_s = 20\n").unwrap();
    let (_, wide, _) = flag(&["--policy", &policy]);
    assert!(count(&wide, "clear") < count(&free, "clear") && wide.contains("within 20 s of the exposure"));
    fs::write(&policy, "max_cost_s = 1e-6\n").unwrap();
    let (_, lost, _) = flag(&["--policy", &policy, "--telescope", "rubin"]);
    assert_eq!(count(&lost, "avoid"), count(&free, "streaked"));
    // Without a delay, exposures that are not clear have no next clear start.
    let (_, hurried, _) = flag(&["--max-delay", "0s"]);
    assert_eq!(hurried.matches("\"next_clear_start_utc\": null").count(), count(&hurried, "streaked"));
}

/// Local noon at the site is 16:43 UTC. A schedule with times in a wrong zone has exposures at daylight.
#[test]
fn exposures_by_daylight_give_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let rows = "a,2024-08-14T23:30:00Z,30,217.5,-30\nb,2024-08-14T17:00:00Z,30,150,-30\n";
    fs::write(path(&folder, "day.csv"), format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{rows}")).unwrap();
    let warnings = |name: &str| run(&[&["flag", "--schedule", &path(&folder, name), "--fov", "1deg"], &SKY[..4]]).2;
    let stderr = warnings("day.csv");
    assert!(stderr.contains("warning: 1 exposure begins while the Sun is above the horizon"), "{stderr}");
    fs::write(path(&folder, "night.csv"), evening()).unwrap();
    let stderr = warnings("night.csv");
    assert!(!stderr.contains("the Sun is above the horizon"), "{stderr}");
}

#[test]
fn bare_dates_use_the_given_scale() {
    let folder = tempfile::tempdir().unwrap();
    let row = |start: &str| format!("1,{start},30,217.5,-30\n");
    let header = |start: &str| format!("exposure_id,{start},duration_s,ra_deg,dec_deg\n");
    fs::write(path(&folder, "mjd.csv"), header("start_mjd") + &row("60536.979166666664")).unwrap();
    fs::write(path(&folder, "tai.csv"), header("start_mjd_tai") + &row("60536.979166666664")).unwrap();
    fs::write(path(&folder, "utc.csv"), header("start_utc") + &row("2024-08-14T23:30:00.000")).unwrap();
    let first = |name: &str, more: &[&str]| {
        let answer = json(&[&["flag", "--schedule", &path(&folder, name), "--fov", "0.1deg"], more, SKY]);
        let provenance = &answer["provenance"];
        (
            provenance["schedule"]["first_start_utc"].as_str().unwrap().to_owned(),
            provenance["time_scale"].as_str().unwrap().to_owned(),
        )
    };
    let at = |time: &str, scale: &str| (format!("2024-08-14T23:{time}Z"), scale.to_owned());
    assert_eq!(first("mjd.csv", &["--time-scale", "utc"]), at("30:00.000", "utc"));
    assert_eq!(first("mjd.csv", &["--time-scale", "TAI"]), at("29:23.000", "tai"));
    assert_eq!(first("mjd.csv", &["--time-scale", "tt"]), at("28:50.816", "tt"));
    assert_eq!(first("tai.csv", &[]), at("29:23.000", "tai"));
    assert_eq!(first("utc.csv", &["--time-scale", "utc"]), at("30:00.000", "utc"));
    // Different scales in the flag and the column name are an error. A Z in a cell takes precedence.
    let named = ["flag", "--schedule", &path(&folder, "utc.csv"), "--fov", "0.1deg", "--time-scale", "tai"];
    let (code, _, stderr) = run(&[&named, SKY]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("column start_utc is in UTC, but --time-scale is TAI; allowed: "), "{stderr}");
    fs::write(path(&folder, "utc.csv"), header("start_utc") + &row("2024-08-14T23:30:00.000Z")).unwrap();
    assert_eq!(first("utc.csv", &["--time-scale", "tai"]), at("30:00.000", "utc"));
}

#[test]
fn a_configuration_replaces_flags_and_flags_take_precedence() {
    let folder = tempfile::tempdir().unwrap();
    let config = path(&folder, "streakcast.toml");
    fs::write(&config, "shells = ['starlink-gen1']\nquiet = true\nexposure = '120s'\nstart = '2024-01-01T00:00:00Z'\n[site]\nmpc = 'X05'\n[field]\ncircle_deg = 20.0\n").unwrap();
    let words = ["passes", "--start", "2024-08-14T23:30:00Z", "--ra", "217.5", "--dec", "-30", "--config", &config];
    assert_eq!(json(&[&words])["passes"], json(&[PASSES, SKY])["passes"]);
    let wider = json(&[&words, &["--fov", "60deg"]]);
    assert!(wider["passes"].as_array().unwrap().len() > json(&[&words])["passes"].as_array().unwrap().len());
}

#[test]
fn csv_schedules_are_annotated_and_keep_all_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let text = evening();
    fs::write(path(&folder, "s.csv"), &text).unwrap();
    let (input, output) = (path(&folder, "s.csv"), path(&folder, "out.csv"));
    let annotate = |more: &[&str]| run(&[&["annotate", "--schedule", &input, "-o", &output], more, FLAG, SKY]);
    assert_eq!(annotate(&[]).0, 0);
    let annotated = fs::read_to_string(&output).unwrap();
    for (line, original) in annotated.lines().zip(text.lines()) {
        assert!(line.starts_with(original), "{line}");
    }
    let flags = records(&done(&[&["flag", "--schedule", &input], FLAG, SKY]));
    for (row, flag) in records(&annotated).iter().zip(&flags) {
        // The rows of `flag` have start, length, pointing and band before the cost; the annotated schedule has them
        // already.
        let flag: Vec<&str> = flag.iter().take(16).chain(flag.iter().skip(21)).skip(1).collect();
        assert_eq!(row.iter().skip(7).collect::<Vec<_>>(), flag);
    }
    let streaks = records(&fs::read_to_string(path(&folder, "out.streaks.csv")).unwrap());
    let count: usize = flags[1..].iter().map(|flag| flag[2].parse::<usize>().unwrap()).sum();
    assert_eq!(streaks.len() - 1, count);
    // An earlier annotation is replaced only with `--replace`.
    let again = |more: &[&str]| run(&[&["annotate", "--schedule", &output, "-o", &output], more, FLAG, SKY]);
    assert_eq!(again(&[]).0, 2);
    assert_eq!(again(&["--replace"]).0, 0);
    assert_eq!(fs::read_to_string(&output).unwrap(), annotated);
}

#[test]
fn a_schedule_and_one_of_its_exposures_see_the_same_synthetic_satellites() {
    let folder = tempfile::tempdir().unwrap();
    let last = "b,2024-08-14T23:30:00.000Z,120,217.5,-30,,r\n";
    let rows = format!("a,2024-08-14T09:00:00Z,30,250,-40,,r\n{last}");
    fs::write(
        path(&folder, "s.csv"),
        format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg,rotation_deg,band\n{rows}"),
    )
    .unwrap();
    let schedule = path(&folder, "s.csv");
    let (code, _, stderr) =
        run(&[&["annotate", "--schedule", &schedule, "--fov", "20deg", "-o", &path(&folder, "o.csv")], SKY]);
    assert_eq!(code, 0, "{stderr}");
    let of = |text: &str| -> Vec<(String, String, String)> {
        let rows = records(text);
        let place = |name: &str| rows[0].iter().position(|cell| cell == name).unwrap();
        let (id, norad, enter, exit) = (place("exposure_id"), place("norad_id"), place("enter_utc"), place("exit_utc"));
        let rows = rows[1..].iter().filter(|row| &row[id] != "a");
        rows.map(|row| (row[norad].to_owned(), row[enter].to_owned(), row[exit].to_owned())).collect()
    };
    let passes = of(&done(&[PASSES, SKY, &["--format", "csv"]]));
    assert!(passes.len() > 3);
    assert_eq!(of(&fs::read_to_string(path(&folder, "o.streaks.csv")).unwrap()), passes);
}

#[test]
fn limits_by_band_have_the_syntax_of_a_policy() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(path(&folder, "s.csv"), evening().replace(",r\n", ",g\n")).unwrap();
    let flags = |limit: &str| {
        let answer =
            json(&[&["flag", "--schedule", &path(&folder, "s.csv"), "--fov", "8deg", "--limit-mag", limit], SKY]);
        answer["flags"].as_array().unwrap().iter().map(|flag| flag["verdict"].to_string()).collect::<Vec<_>>()
    };
    assert_eq!(flags("g=6.8,default=-9"), flags("6.8"));
    assert_ne!(flags("g=6.8,default=-9"), flags("y=6.8,default=-9"));
}

#[test]
fn lists_of_models_sites_and_shells() {
    let model: Value = serde_json::from_str(&done(&[&["model", "show", "starlink-v1.5", "--format", "json"]])).unwrap();
    for key in ["c1", "c2", "c3", "c4", "c5", "n_sail", "n_base"] {
        assert!(model["coefficients"][key].is_number(), "{key}");
    }
    assert_eq!(model["covariance"].as_array().map(Vec::len), Some(7));
    assert!(model["rms_mag"].is_number() && model["provenance"].is_object());
    let names = records(&done(&[&["model", "list", "--format", "csv"]]));
    assert!(names.iter().any(|row| &row[0] == "starlink-v1.5"));
    // Every model is compared with published values; without the folder of measurements, it is not compared with data.
    let checks = records(&done(&[&["model", "check", "--format", "csv"]]));
    let verdict = checks[0].len() - 1;
    assert!(names[1..].iter().all(|name| checks.iter().any(|row| row[0] == name[0])));
    let other = |row: &&csv::StringRecord| &row[verdict] != if &row[2] == "photometry" { "no data" } else { "ok" };
    // The panels of V2 Mini differ from one of two published means. The prior of high orbits needs a catalogue.
    let others: Vec<_> = checks[1..].iter().filter(other).map(|row| [&row[0], &row[2], &row[verdict]]).collect();
    assert_eq!(others, [["high-orbit", "none", "no data"], ["v2mini-panels", "mean", "off"]]);
    let sites = records(&done(&[&["sites", "x05", "--format", "csv"]]));
    assert_eq!((sites.len(), &sites[1][0]), (2, "X05"));
    let (code, _, stderr) = run(&[&["sites", "nosuch", "--format", "csv"]]);
    assert_eq!((code, stderr.trim()), (1, "no site has 'nosuch' in its name or code"));
    let shells = records(&done(&[&["shells", "--format", "csv"]]));
    assert!(shells.iter().any(|row| &row[0] == "starlink-gen2" && &row[1] == "29988"));
    assert!(shells.iter().any(|row| &row[0] == "planned-2026" && &row[1] == "1822393"));
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("own.toml").display().to_string();
    let text = "[[constellation]]\nname = 'own'\nshell = [{ altitude_km = [600, 8000], inclination_deg = 55, planes = 3, \
                satellites_per_plane = 5 }]\n";
    std::fs::write(&path, text).unwrap();
    let own = records(&done(&[&["shells", &path, "--format", "csv"]]));
    assert_eq!((own.len(), &own[1][0], &own[1][1], &own[1][2], &own[1][4]), (2, "own", "30", "2", "8000.0"));
    let (code, _, stderr) = run(&[&["shells", "nowhere.toml", "--format", "csv"]]);
    assert!(code == 2 && stderr.contains("nowhere.toml"), "{stderr}");
}

#[test]
fn starlink_1102_is_found_in_a_decam_exposure() {
    let Some(data) = crate::common::data_dir() else { return };
    let elements = data.join("tle/supgp/starlink_supgp_2020-02-23.tle").display().to_string();
    // Values of DATE-OBS, EXPTIME, RA and DEC in the header of exposure 941420.
    let words = [
        "passes",
        "--elements",
        &elements,
        "--mpc",
        "W84",
        "--start",
        "2020-03-06T00:04:15.410235Z",
        "--exposure",
        "120.0s",
        "--ra",
        "05:36:49.000",
        "--dec",
        "-21:12:15.998",
        "--telescope",
        "decam",
    ];
    let answer = json(&[&words, &["-q"]]);
    let pass = answer["passes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|pass| pass["norad_id"] == 44920)
        .expect("Starlink-1102 crosses");
    assert_eq!(pass["name"], "STARLINK-1102");
    assert!(pass["min_separation_deg"].as_f64().unwrap() < 0.3, "{pass}");
    assert!(pass["mid_utc"].as_str().unwrap().starts_with("2020-03-06T00:05:4"), "{pass}");
}

#[test]
fn flags_end_with_the_exposures_of_the_schedule() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = path(&folder, "s.csv");
    // The second row is below the horizon, the third has no position.
    let rows = "a,2024-08-14T23:30:00Z,30,217.5,-30,r\nb,2024-08-14T23:31:00Z,30,217.5,80,r\nc,2024-08-14T23:32:00Z,30,,-30,\n";
    fs::write(&schedule, format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg,band\n{rows}")).unwrap();
    let flag = ["flag", "--schedule", &schedule];
    let written = records(&done(&[&flag, FLAG, SKY, &["--telescope", "rubin", "--format", "csv"]]));
    let last = |row: &csv::StringRecord| row.iter().skip(16).take(5).collect::<Vec<_>>().join(",");
    assert_eq!((&written[0][13], &written[0][15], &written[0][21]), ("acceptable_delay_s", "late_s", "streak_cost_s"));
    // The cost of an exposure that cannot be judged is unknown, not 0.
    let cost_s: Vec<&str> = written.iter().skip(1).map(|row| &row[21]).collect();
    assert!(cost_s[0].parse::<f64>().is_ok_and(|cost_s| cost_s >= 0.0) && cost_s[1..] == ["", ""], "{cost_s:?}");
    let expected = [
        "start_utc,duration_s,ra_deg,dec_deg,band",
        "2024-08-14T23:30:00.000000Z,30.000,217.5000000,-30.0000000,r",
        "2024-08-14T23:31:00.000000Z,30.000,217.5000000,80.0000000,r",
        ",,,,",
    ];
    assert_eq!(written.iter().map(last).collect::<Vec<_>>(), expected);
    let screen = done(&[&flag, FLAG, SKY, &["--format", "table"]]);
    assert!(
        screen.lines().next().unwrap().ends_with("start (UTC)           exposure s  RA deg   Dec deg  band"),
        "{screen}"
    );

    // With one valid row --fail-on has a result, without any it is an error.
    assert!([0, 1].contains(&run(&[&flag, FLAG, SKY, &["--fail-on", "avoid"]]).0));
    for kept in [&rows.lines().skip(1).collect::<Vec<_>>()[..], &rows.lines().skip(2).collect::<Vec<_>>()[..]] {
        let text = format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg,band\n{}\n", kept.join("\n"));
        fs::write(&schedule, text).unwrap();
        assert_eq!(run(&[&flag, FLAG, SKY]).0, 0);
        let (code, stdout, stderr) = run(&[&flag, FLAG, SKY, &["--fail-on", "streaked"]]);
        assert_eq!((code, stderr.lines().count()), (2, 1), "{stderr}");
        assert!(stdout.contains("invalid") && stderr.contains("none of"), "{stderr}");
    }
}
