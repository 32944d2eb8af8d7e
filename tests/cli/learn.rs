//! `learn` and `--learned`: magnitudes of satellites and kinds move by the learned offsets; errors for invalid input.

use std::fs;

use serde_json::Value;
use streakcast::elements::NoradId;
use streakcast::learn::MeasuredDelay;
use streakcast::measure::PredictOptions;
use tempfile::TempDir;

use crate::common::cli::{FIRST_NORAD, done, json, path, published_constellation, run};

/// Offset of the measured magnitudes from the model, mag.
const OFFSET_MAG: f64 = 0.8;
/// Number of measured satellites.
const MEASURED: usize = 12;
/// Smallest number of them that is used; the sunlight of others passes below 100 km.
const LEAST_USED: u64 = 8;
/// Epoch of the element sets.
const EPOCH: &str = "2026-08-14T00:00:00 UTC";
const SITE: [&str; 3] = ["--mpc", "X05", "--quiet"];
const TIMES: [&str; 7] =
    ["--start", "2026-08-14T23:29:05Z", "--end", "2026-08-14T23:29:15Z", "--step", "1s", "--generation"];

/// Returns rows of `ephemeris` with magnitudes at altitudes above 20 deg.
fn places(elements: &[String; 2], flags: &[&str]) -> (Vec<Value>, Value) {
    let elements = elements.each_ref().map(String::as_str);
    let mut answer = json(&[&["ephemeris"], &TIMES, &["starlink-v1.5"], &elements, &SITE, flags]);
    let rows = answer["ephemeris"].as_array().unwrap().iter();
    let is_used = |row: &&Value| row["magnitude"].is_number() && row["altitude_deg"].as_f64().unwrap() > 20.0;
    (rows.filter(is_used).cloned().collect(), answer["provenance"].take())
}

/// Writes measurements of the first satellites, fainter than predicted by [`OFFSET_MAG`]; returns the file.
fn photometry(folder: &TempDir, places: &[Value]) -> String {
    let mut ids: Vec<u64> = places.iter().map(|row| row["norad_id"].as_u64().unwrap()).collect();
    ids.dedup();
    assert!(ids.len() > 2 * MEASURED, "{} satellites", ids.len());
    let mut text = "norad_cat_id,observation_time_utc,apparent_magnitude,apparent_magnitude_uncertainty,\
                    observer_latitude_deg,observer_longitude_deg,observer_altitude_m,observing_filter\n"
        .to_owned();
    for row in places.iter().filter(|row| ids[..MEASURED].contains(&row["norad_id"].as_u64().unwrap())) {
        text += &format!(
            "{},{},{:.3},0.05,-30.2446,-70.7494,2663,V\n",
            row["norad_id"],
            row["utc"].as_str().unwrap(),
            row["magnitude"].as_f64().unwrap() + OFFSET_MAG
        );
    }
    let file = path(folder, "photometry.csv");
    fs::write(&file, text).unwrap();
    file
}

#[test]
fn verif_learned_offsets_move_predictions_of_all_verbs() {
    let folder = TempDir::new().unwrap();
    let elements = published_constellation(&folder, EPOCH);
    let (before, _) = places(&elements, &[]);
    let (photometry, learned) = (photometry(&folder, &before), path(&folder, "learned.json"));
    let flags = elements.each_ref().map(String::as_str);
    let measured = path(&folder, "measured.csv");
    // The delays of the second prediction are not used, because delays of three sigmas were not searched.
    let rows = |row: usize| format!("{FIRST_NORAD},{},0.01,1.0\n{FIRST_NORAD},0,0.01,2.0\n", ["2", "-2"][row % 2]);
    let delays: String = (0..40).map(rows).collect();
    fs::write(&measured, format!("# {{}}\nnorad_id,late_s,late_sigma_s,late_expected_sigma_s\n{delays}")).unwrap();
    let verb = ["learn", "--photometry", &photometry, "-o", &learned, "--measured", &measured, "--quiet"];
    let table = json(&[&verb, &flags]);
    let kind = &table["kinds"][0];
    let used = kind["satellites"].as_u64().unwrap();
    assert!(kind["kind"] == "starlink-v1.5" && (LEAST_USED..=MEASURED as u64).contains(&used), "{kind}");
    let number = |value: &Value, name: &str| value[name].as_f64().unwrap_or_else(|| panic!("{name} in {value}"));
    // Satellites with the same offset: the model's sigma of 0.45 mag moves it by less than 0.1 mag.
    assert!((number(kind, "offset_mag") - OFFSET_MAG).abs() < 0.1, "{kind}");
    let file: Value = serde_json::from_str(&fs::read_to_string(&learned).unwrap()).unwrap();
    assert_eq!(file["provenance"]["photometry"], photometry.as_str());
    let lateness = number(&file["kinds"][0]["lateness"], "factor");
    assert!(lateness > 1.2 && file["kinds"][0]["lateness"]["measurements"] == 40, "{file}");

    let (after, provenance) = places(&elements, &["--learned", &learned]);
    assert_eq!(provenance["learned"]["satellites"], used);
    assert_eq!(provenance["learned"]["kinds"][0]["kind"], "starlink-v1.5");
    assert_eq!(before.len(), after.len());
    let satellites = file["satellites"].as_array().unwrap();
    let of_kind = &file["kinds"][0]["magnitude"];
    let mut of_learned_sigma = 0;
    for (before, after) in before.iter().zip(&after) {
        let own = satellites.iter().find(|one| one["norad_id"] == before["norad_id"]).unwrap_or(of_kind);
        // Magnitudes are printed with three decimals.
        let moved = number(after, "magnitude") - number(before, "magnitude");
        assert!((moved - number(own, "offset_mag")).abs() < 2e-3, "{before} {after}");
        assert_eq!(after["mag_source"].as_str().map(|source| source.ends_with(" (learned)")), Some(true));
        // Errors of position add to sigma, and so does geometry that the model was not fitted to.
        let (sigma, learned_mag) = (number(after, "magnitude_sigma"), number(own, "sigma_mag"));
        assert!(sigma > learned_mag - 1e-3 && sigma < number(before, "magnitude_sigma"), "{before} {after} {own}");
        of_learned_sigma += usize::from(sigma < learned_mag + 0.02);
        // Times are printed with two decimals.
        let widened = number(after, "along_track_sigma_s") / number(before, "along_track_sigma_s");
        assert!((widened / lateness - 1.0).abs() < 0.05, "{before} {after}");
    }
    assert!(of_learned_sigma > before.len() / 4, "{of_learned_sigma} of {}", before.len());

    let night = ["forecast", "--night", "2026-08-14", "--max-mag", "9", "--learned", &learned];
    let forecast = done(&[&night, &flags, &SITE, &["--format", "csv"]]);
    assert!(forecast.contains("(learned)") && forecast.contains("learned:"), "{}", &forecast[..2000]);
    let configuration = path(&folder, "streakcast.toml");
    fs::write(&configuration, "learned = 'learned.json'\n").unwrap();
    let (by_file, _) = places(&elements, &["--config", &configuration]);
    assert_eq!(by_file, after);

    // The same satellites later, one of them 4 mag brighter.
    let (tonight, picture) = (path(&folder, "tonight.csv"), path(&folder, "alarms.svg"));
    let bright = satellites[0]["norad_id"].to_string();
    let quiet = fs::read_to_string(&photometry).unwrap();
    let changed = quiet.lines().map(|line| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if cells[0] == bright {
            cells[2] = (cells[2].parse::<f64>().unwrap() - 4.0).to_string();
        }
        cells.join(",") + "\n"
    });
    fs::write(&tonight, changed.collect::<String>()).unwrap();
    let verb = ["alarms", "--photometry", &tonight, "--learned", &learned, "--picture", &picture, "--quiet"];
    let alarms = json(&[&verb, &flags]);
    assert_eq!(alarms["provenance"]["passes_tested"], used);
    let rows = alarms["alarms"].as_array().unwrap();
    assert_eq!(rows.iter().map(|row| row["norad_id"].to_string()).collect::<Vec<_>>(), [bright.as_str()], "{rows:?}");
    assert!(rows[0]["alarm"] == "brightness" && number(&rows[0], "difference_mag") < -3.5, "{rows:?}");
    assert!(fs::read_to_string(&picture).unwrap().contains(&format!("{bright}: ")));
    for (flag, parts) in [("0", "above 0"), ("2", "at most 1")] {
        let (code, _, stderr) = run(&[&verb, &flags, &["--probability", flag]]);
        assert!(code == 2 && stderr.contains(parts) && stderr.lines().count() == 1, "{stderr}");
    }

    let other = ["--learned", &learned, "--model", "starlink-v1.5=starlink-v1.5-phase"];
    let (code, _, stderr) = run(&[&["ephemeris"], &TIMES, &["starlink-v1.5"], &flags, &SITE, &other]);
    assert_eq!((code, stderr.lines().count()), (2, 1), "{stderr}");
    for part in ["learned.json", "brdf:starlink-v1.5-facets", "phase:starlink-v1.5-phase", "allowed"] {
        assert!(stderr.contains(part), "{stderr}");
    }
}

#[test]
fn invalid_input_is_named() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str, text: &str| {
        let path = path(&folder, name);
        fs::write(&path, text).unwrap();
        path
    };
    let mmt = "Date,StdMag,Mag,Filter,Penumbra,Distance,Phase,Channel,Track\n\
               2021-01-21 17:29:31.594000,6.647,7.59759,Clear,0,1507.229,92.952,7,1\n";
    let photometry = file("mmt.csv", mmt);
    let columns = "time=Date,time_scale=utc,magnitude=Mag,distance=Distance,phase=Phase,norad=Track";
    let numbered = ["--columns", columns, "--site", "MMT-9"];
    let no_column = file("a.csv", "norad_id,late_s\n1,2\n");
    let applied = file("b.csv", "# learned: {}\nnorad_id,late_s,late_sigma_s,late_expected_sigma_s\n");
    let header = "norad_id,late_s,late_sigma_s,late_expected_sigma_s\n";
    let no_number = file("c.csv", &format!("{header}1,soon,0.1,2\n"));
    let ecsv = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: norad_id, datatype: int64}\n";
    let blanks = file("e.ecsv", &format!("{ecsv}{} \"soon\" 0.1 2\n", header.replace(',', " ") + "1"));
    let no_sigma = file("d.csv", &format!("{header}1,2,0.1,0\n"));
    let learned = path(&folder, "learned.json");
    let given = ["learn", "--photometry", &photometry, "--height-km", "1200", "-o", &learned];
    for (flags, parts) in [
        (vec![], vec!["missing kind", "--kind", "--elements"]),
        (vec!["--kind", "twoweb"], vec!["twoweb", "allowed", "oneweb"]),
        (vec!["--kind", "oneweb"], vec!["1 without a satellite number", "allowed"]),
        (vec!["--kind", "other", numbered[0], numbered[1], numbered[2], numbered[3]], vec!["without a kind or model"]),
        (vec!["--kind", "oneweb", "--model", "mine.json"], vec!["mine.json"]),
    ] {
        let (code, _, stderr) = run(&[&given, &flags, &["--quiet"]]);
        assert_eq!((code, stderr.lines().count()), (2, 1), "{flags:?}: {stderr}");
        assert!(parts.iter().all(|part| stderr.contains(part)), "{flags:?}: {stderr}");
    }
    for (measured, parts) in [
        (&no_column, vec!["a.csv", "late_sigma_s", "allowed"]),
        (&applied, vec!["b.csv", "--learned", "allowed"]),
        (&no_number, vec!["c.csv", "line 2: late_s is 'soon'", "allowed"]),
        (&blanks, vec!["e.ecsv", "line 6: late_s is 'soon'"]),
        (&no_sigma, vec!["d.csv", "line 2: late_expected_sigma_s is '0'"]),
    ] {
        let measured = ["--measured", measured, "--kind", "oneweb", "--quiet"];
        let (code, _, stderr) = run(&[&given, &measured, &numbered]);
        assert_eq!((code, stderr.lines().count()), (2, 1), "{stderr}");
        assert!(parts.iter().all(|part| stderr.contains(part)), "{stderr}");
    }
    for (name, part) in [("none.json", "none.json"), ("mmt.csv", "line 1")] {
        let sky = ["--shells", "oneweb", "--mpc", "X05", "--quiet", "--learned", &path(&folder, name)];
        let (code, _, stderr) = run(&[&["ephemeris"], &TIMES, &["oneweb"], &sky]);
        assert!(code == 2 && stderr.lines().count() == 1 && stderr.contains(part), "{stderr}");
    }
}

/// Delays are omitted if the default search of `measure` does not extend to three sigmas of the prediction.
#[test]
fn delays_are_used_up_to_the_range_of_the_search() {
    let search = PredictOptions::default();
    let delay =
        |expected_sigma_s: f64| MeasuredDelay { norad_id: NoradId(1), late_s: 0.0, sigma_s: 0.1, expected_sigma_s };
    let largest_sigma_s = search.most_late_s / search.sigmas;
    assert!(delay(largest_sigma_s).is_range_searched());
    assert!(!delay(1.001 * largest_sigma_s).is_range_searched());
}

/// The first exposure of a pass corrects the next ones; other satellites and other passes are unchanged.
#[test]
fn verif_a_measured_magnitude_corrects_its_pass() {
    let folder = TempDir::new().unwrap();
    let elements = published_constellation(&folder, EPOCH);
    let (before, _) = places(&elements, &[]);
    let mut ids: Vec<u64> = before.iter().map(|row| row["norad_id"].as_u64().unwrap()).collect();
    ids.dedup();
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    let first = |id: &u64| before.iter().find(|row| row["norad_id"] == *id).unwrap();
    let mut text = "# by hand\nnorad_id,mid_utc,magnitude,magnitude_sigma,flags\n".to_owned();
    for id in &ids[..MEASURED] {
        let row = first(id);
        let utc = row["utc"].as_str().unwrap();
        text += &format!("{id},{utc},{:.4},0,\n", number(row, "magnitude") + OFFSET_MAG);
    }
    // A limit, a satellite that is not in the sky, and a satellite that is not found do not count.
    let utc = before[0]["utc"].as_str().unwrap();
    text += &format!("{},{utc},1.0,0,saturated\n1,{utc},5.0,0.1,\n{},{utc},,,\n", ids[MEASURED], ids[MEASURED]);
    let measured = path(&folder, "measured.csv");
    fs::write(&measured, &text).unwrap();
    let (after, provenance) = places(&elements, &["--measured", &measured]);
    assert_eq!(provenance["measured"]["measurements"], MEASURED as u64 + 1);
    assert_eq!(provenance["measured"]["not_used"], 1);
    assert_eq!(before.len(), after.len());
    for (before, after) in before.iter().zip(&after) {
        let moved_mag = number(after, "magnitude") - number(before, "magnitude");
        let ratio = number(after, "magnitude_sigma") / number(before, "magnitude_sigma");
        if ids[..MEASURED].contains(&before["norad_id"].as_u64().unwrap()) {
            // Within ten seconds the correlation is 0.5 to 0.9; the error of the position remains.
            assert!((0.4..0.91).contains(&(moved_mag / OFFSET_MAG)) && ratio < 0.95, "{before} {after}");
        } else {
            assert!(moved_mag == 0.0 && ratio == 1.0, "{before} {after}");
        }
    }
    // An orbit later the measurements have no effect.
    let later = |flags: &[&str]| {
        let [first, second] = elements.each_ref().map(String::as_str);
        let id = ids[0].to_string();
        let verb = ["ephemeris", "--times", "2026-08-15T01:05:00Z", "--norad", &id];
        json(&[&verb, &[first, second], &SITE, flags])["ephemeris"].clone()
    };
    assert_eq!(later(&[]), later(&["--measured", &measured]));
    // Errors name file, row and what is allowed.
    let [one, two] = elements.each_ref().map(String::as_str);
    for (from, to, parts) in [
        ("magnitude_sigma", "error", ["missing column magnitude_sigma", "mid_utc"]),
        (",0,\n", ",-1,\n", ["line 3: magnitude_sigma is '-1'", "0 to 10"]),
        ("2026-08-14T", "yesterday ", ["line 3: mid_utc is 'yesterday", "a time in UTC"]),
    ] {
        fs::write(&measured, text.replacen(from, to, 1)).unwrap();
        let verb = ["ephemeris", "--times", "2026-08-14T23:30:00Z", "--norad", "1", "--measured", &measured];
        let (code, _, stderr) = run(&[&verb, &[one, two], &SITE]);
        assert!(code == 2 && stderr.contains("measured.csv"), "{stderr}");
        parts.iter().for_each(|part| assert!(stderr.contains(part), "{part}: {stderr}"));
    }
}
