//! `ephemeris`: columns and formats, times, and errors.

use std::fs;

use serde_json::Value;
use streakcast::elements::Satellites;
use streakcast::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};

use crate::common::cli::{SKY, done, json, path, records, run};

const HEADER: &str = "norad_id,name,utc,julian_date_utc,ra_deg,dec_deg,ra_cos_dec_rate_deg_s,dec_rate_deg_s,altitude_deg,azimuth_deg,altitude_rate_deg_s,azimuth_cos_altitude_rate_deg_s,range_km,range_rate_km_s,elongation_deg,phase_angle_deg,illumination,lit_fraction,magnitude,magnitude_sigma,mag_source,element_epoch_utc,element_age_days,along_track_sigma_s,cross_track_sigma_deg,position_source";
const PLACES: &[&str] = &["ephemeris", "--name", "S1 P24-1"];
const STEPS: &[&str] = &["--start", "2026-08-14T23:29:05Z", "--end", "2026-08-14T23:30:05Z", "--step", "30s"];

#[test]
fn verif_columns_rows_and_formats_agree() {
    let text = done(&[PLACES, SKY, STEPS]);
    assert!(text.starts_with("# "), "provenance first");
    let rows = records(&text);
    assert_eq!(rows[0].iter().collect::<Vec<_>>().join(","), HEADER);
    assert!(rows.len() > 10 && rows.len() % 3 == 1, "{} rows", rows.len());
    // Rows are grouped by satellite, in time order.
    assert_eq!((&rows[1][0], &rows[1][2]), (&rows[3][0], "2026-08-14T23:29:05.000000Z"));
    assert_eq!((&rows[3][2], &rows[1][3]), ("2026-08-14T23:30:05.000000Z", "2461267.47853009"));

    let answer = json(&[PLACES, SKY, STEPS]);
    let places = answer["ephemeris"].as_array().unwrap();
    assert_eq!(places.len(), rows.len() - 1);
    for (row, place) in rows[1..].iter().zip(places) {
        for (name, cell) in rows[0].iter().zip(row) {
            let value = &place[name];
            let same = value.as_str().map_or_else(|| cell.parse().ok() == value.as_f64(), |text| text == cell);
            assert!(same || cell.is_empty() && value.is_null(), "{name}: {cell} {value}");
        }
    }
    for (key, value) in [("drag", "station-keeping"), ("frame", "ICRS astrometric topocentric"), ("time_scale", "utc")]
    {
        assert_eq!(answer["provenance"][key], value, "{}", answer["provenance"]);
    }
    let options = &answer["provenance"]["options"];
    assert_eq!((&options["times"], &options["step"]), (&3.into(), &"30s".into()));
    assert_eq!(answer["left_out"], serde_json::json!([]));

    let lines = done(&[PLACES, SKY, STEPS, &["--format", "jsonl"]]);
    assert_eq!(lines.lines().count(), rows.len());
    for (format, part) in [("ecsv", "# %ECSV 1.0"), ("votable", "<VOTABLE"), ("table", "late s")] {
        assert!(done(&[PLACES, SKY, STEPS, &["--format", format]]).contains(part), "{format}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "places.csv");
    assert_eq!(done(&[PLACES, SKY, STEPS, &["-o", &file]]), "");
    assert_eq!(records(&fs::read_to_string(file).unwrap()), rows);
}

#[test]
fn verif_times_of_a_list_a_file_and_steps_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "times.txt");
    let times = ["2026-08-14T23:29:05Z", "2026-08-14T23:29:35Z", "2026-08-14T23:30:05Z"];
    fs::write(&file, format!("# UTC\n{}\n", times.join("\n"))).unwrap();
    let rows = |more: &[&str]| records(&done(&[PLACES, SKY, more]));
    let steps = rows(STEPS);
    assert_eq!(rows(&["--times-file", &file]), steps);
    assert_eq!(rows(&[&["--times"], &times[..]].concat()), steps);
}

/// The position at the time of entry equals that of `passes`.
#[test]
fn verif_the_position_at_an_entry_is_that_of_the_pass() {
    let exposure =
        ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7", "--fov", "3.5deg"];
    let passes = json(&[&["passes"], SKY, &exposure]);
    let pass = &passes["passes"].as_array().unwrap()[0];
    let norad = pass["norad_id"].to_string();
    let at = pass["enter_utc"].as_str().unwrap();
    let answer = json(&[&["ephemeris", "--norad", &norad, "--times", at], SKY]);
    let row = &answer["ephemeris"][0];
    for (column, of_entry) in [("ra_deg", "enter_ra_deg"), ("dec_deg", "enter_dec_deg")] {
        let [position, entry] = [&row[column], &pass[of_entry]].map(|value| value.as_f64().unwrap());
        // Times are rounded to a microsecond, half of which is 5e-7 deg at 1 deg/s; degrees of passes have six
        // decimals.
        assert!((position - entry).abs() < 2e-6, "{position} {entry}");
    }
}

#[test]
fn errors_name_what_is_allowed() {
    let at = ["--times", "2026-08-14T23:29:05Z"];
    let many = ["--start", "2026-08-14T00:00:00Z", "--end", "2026-08-15T00:00:00Z", "--step", "1s"];
    for (words, part) in [
        (&[PLACES, SKY, &["--start", "2026-08-14T23:29:05Z"]][..], "missing times; specify --times"),
        (&[PLACES, SKY, &["--times", "2026-08-14T23:29:05"]], "2026-08-14T23:29:05"),
        (&[PLACES, SKY, &at, &["--step", "1s"]], "--step"),
        (&[PLACES, SKY, &at, &["--fov", "1deg"]], "--fov has no effect on an ephemeris; allowed"),
        (&[PLACES, SKY, &at, &["--drag", "none"]], "station-keeping, published"),
        (&[&["ephemeris", "--name", "NO SUCH"], SKY, &at], "none of the 4408 satellites has a name with NO SUCH"),
        (&[&["ephemeris"], SKY, &at], "missing selection of satellites; specify --norad ID"),
        (&[&["ephemeris", "--name", "S1"], SKY, &many], "allowed: at most 1000000"),
    ] {
        let (code, stdout, stderr) = run(words);
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    // If no position is above the altitude limit, the result is empty and not an error.
    let (code, stdout, _) = run(&[PLACES, SKY, &at, &["--min-altitude", "89.9"]]);
    assert_eq!((code, records(&stdout).len()), (1, 1));
}

/// Directions of the default settings, which include polar motion, compared with rows of JPL Horizons for the Dominion
/// Astrophysical Observatory. Without polar motion they differ by 3.6".
#[test]
fn valid_directions_of_the_command_line_against_horizons() {
    /// From the printed digits: right ascension 0.01 s (0.15"), declination 0.1".
    const MEDIAN_ARCSEC: f64 = 0.3;
    const WORST_ARCSEC: f64 = 1.0;
    let Some(folder) = crate::common::data_dir() else { return };
    let folder = folder.join("photometry/boley2021_plaskett");
    let elements = folder.join("starlink.15JUL2021");
    let catalogue = Satellites::from_files([&elements]).unwrap().element_sets;
    let rows = std::fs::read_to_string(folder.join("dat")).unwrap();
    let mut separations_arcsec = Vec::new();
    for line in rows.lines().step_by(20) {
        // NAME.txt: 2021-Jul-16 09:12:42.000 [flags] RA(3) Dec(3) ...
        let (name, rest) = line.split_once(".txt:").unwrap();
        let Some(set) = catalogue.iter().find(|set| *set.name == *name) else { continue };
        let mut words = rest.split_whitespace();
        let time = format!("{}T{}Z", words.next().unwrap().replace("Jul", "07"), words.next().unwrap());
        let words: Vec<&str> = words.skip_while(|word| word.parse::<f64>().is_err()).collect();
        let expected = Direction::<Gcrs>::from_lon_lat_rad(
            parse_right_ascension_deg(&words[0..3].join(":")).unwrap().to_radians(),
            parse_declination_deg(&words[3..6].join(":")).unwrap().to_radians(),
        );
        let (norad, file) = (set.norad_id.to_string(), elements.display().to_string());
        let flags = ["--norad", &norad, "--times", &time, "--elements", &file, "--mpc", "658", "--drag", "published"];
        let answer = json(&[&["ephemeris", "--quiet"], &flags]);
        let number = |name: &str| answer["ephemeris"][0][name].as_f64().unwrap().to_radians();
        let found = Direction::from_lon_lat_rad(number("ra_deg"), number("dec_deg"));
        separations_arcsec.push(found.separation_rad(&expected).to_degrees() * 3600.0);
    }
    separations_arcsec.sort_by(f64::total_cmp);
    let (median, worst) = (separations_arcsec[separations_arcsec.len() / 2], separations_arcsec.last().unwrap());
    println!("{} rows: median {median:.3}\", worst {worst:.3}\"", separations_arcsec.len());
    assert!(separations_arcsec.len() >= 15 && median <= MEDIAN_ARCSEC && *worst <= WORST_ARCSEC, "{median} {worst}");
}

/// A second file, of a week before, improves the mean motions; the provenance has the numbers of satellites. The order
/// of the files does not matter, and a folder with both gives the same result.
#[test]
fn verif_older_element_sets_on_the_command_line() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = tempfile::tempdir().unwrap();
    let files = ["08", "15"].map(|day| {
        let name = format!("starlink_2026-06-{day}.tle.gz");
        let file = path(&folder, &name);
        fs::copy(data.join("tle/daily_2026-06").join(name), &file).unwrap();
        file
    });
    let words = ["ephemeris", "--norad", "59934", "--times", "2026-06-20T00:00:00Z", "--mpc", "X05", "--quiet"];
    let answer = |elements: &[&str]| json(&[&words, &["--elements"], elements]);
    let both = answer(&[&files[0], &files[1]]);
    for elements in [&[files[1].as_str(), &files[0]][..], &[folder.path().to_str().unwrap()]] {
        assert_eq!(answer(elements)["ephemeris"], both["ephemeris"]);
    }
    let count = |name: &str| both["provenance"]["mean_motion"][name].as_u64().unwrap();
    assert!(count("shell") > 8000 && count("arrived_at_shell") > 100, "{}", both["provenance"]);
    assert!(count("changed_between_epochs") < 1000 && count("four_epochs") == 0, "{}", both["provenance"]);
    let one = answer(&[&files[1]]);
    assert!(one["provenance"]["mean_motion"].is_null());
    let sigma_s = |answer: &Value| answer["ephemeris"][0]["along_track_sigma_s"].as_f64().unwrap();
    assert!(sigma_s(&both) < 0.6 * sigma_s(&one), "{} {}", sigma_s(&both), sigma_s(&one));
}
