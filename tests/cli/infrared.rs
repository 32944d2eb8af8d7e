//! Infrared bands, response files and limits of surface brightness on the command line.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::cli::run;

/// Element set of the telescope, an invented satellite.
const OBSERVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/data/elements/sample.2le");
/// A brightness model; its size is replaced.
const MODEL: &str = include_str!("../../src/photometry/models/kuiper.json");
const SHARED: &[&str] = &["--shells", "oneweb", "--quiet", "--fov", "10deg", "--observer-elements", OBSERVER];
const START: &str = "2026-03-21T06:00:00Z";

/// Returns the passes in eight fields around the sky, without those that the Earth hides.
fn passes(more: &[&str]) -> Vec<Value> {
    let mut found = Vec::new();
    for ra in (0..360).step_by(45) {
        let exposure = ["--start", START, "--exposure", "300s", "--ra", &ra.to_string(), "--dec", "20"];
        let (code, stdout, stderr) = run(&[&["passes", "--format", "json"], SHARED, &exposure, more]);
        match code {
            0 => {
                let answer: Value = serde_json::from_str(&stdout).unwrap();
                found.extend(answer["passes"].as_array().unwrap().clone());
            }
            1 => {}
            _ => assert!(stderr.contains("below the Earth's limb of "), "{stderr}"),
        }
    }
    found
}

fn number(pass: &Value, key: &str) -> f64 {
    pass[key].as_f64().unwrap_or_else(|| panic!("{key} in {pass}"))
}

/// Returns the magnitudes at 1000 km of satellites that are in the umbra at the brightest point and in the middle.
fn in_shadow(passes: &[Value]) -> Vec<f64> {
    let dark = passes.iter().filter(|pass| pass["illumination"] == "umbra" && pass["mag_source"] == "thermal");
    dark.map(|pass| number(pass, "magnitude") - 5.0 * (number(pass, "range_km") / 1000.0).log10()).collect()
}

#[test]
fn satellites_in_shadow_shine_in_thermal_bands() {
    let of_band = |band: &str, more: &[&str]| passes(&[&["--band", band], more].concat());
    let is_dark = |pass: &Value| pass["illumination"] == "umbra";
    let (visual, thermal) = (of_band("V", &[]), of_band("W2", &["--no-earthshine"]));
    let dark = of_band("V", &["--include-dark"]);
    assert!(thermal.len() == dark.len() && dark.len() > visual.len(), "{} {}", thermal.len(), dark.len());
    assert!(thermal.iter().all(|pass| pass["magnitude_peak"].is_number()));
    assert!(dark.iter().filter(|pass| is_dark(pass)).any(|pass| pass["magnitude_peak"].is_null()));
    // In K the emission is faint: satellites in shadow are listed only with --include-dark, with a magnitude.
    assert_eq!(of_band("K", &[]).len(), visual.len());
    assert!(of_band("K", &["--include-dark"]).iter().all(|pass| pass["magnitude_peak"].is_number()));
    // OneWeb is 2 m in size: 6.869 (AB) + (-28.29 + 25.00) - 2.5 log10(0.9 π)
    let expected = 6.869 - 3.29 - 2.5 * (0.9 * std::f64::consts::PI).log10();
    let found = in_shadow(&thermal);
    assert!(!found.is_empty() && found.iter().all(|found| (found - expected).abs() < 0.01), "{found:?} {expected}");
    // The sigma contains that of the assumed size, 1.09 mag.
    assert!(thermal.iter().filter(|pass| is_dark(pass)).all(|pass| number(pass, "magnitude_peak_sigma") > 1.1));
}

/// In the middle of the night nearly all satellites are in shadow; in W2 they count in the statistics.
#[test]
fn statistics_of_a_site_count_satellites_in_shadow() {
    let trails = |band: &str| {
        let shared = ["--shells", "starlink-gen1", "--mpc", "X05", "--fov", "1deg", "--exposure", "60s", "--quiet"];
        let more = ["--night", "2026-06-21", "--format", "json", "--band", band];
        let (code, stdout, stderr) = run(&[&["statistics"], &shared, &more]);
        assert_eq!(code, 0, "{stderr}");
        let answer: Value = serde_json::from_str(&stdout).unwrap();
        let rows = answer["statistics"].as_array().unwrap_or_else(|| panic!("{answer}")).clone();
        let lowest = rows
            .iter()
            .min_by(|one, other| number(one, "sun_altitude_deg").total_cmp(&number(other, "sun_altitude_deg")));
        number(lowest.unwrap(), "trails_per_exposure")
    };
    let (visual, thermal) = (trails("V"), trails("W2"));
    assert!(thermal > 5.0 * visual.max(0.01), "{visual} {thermal}");
}

/// A satellite of 100 m² at 5 µm and 20 µm, against Planck's law by an independent computation in Python: 1.417 and
/// -2.523 mag (AB) at 1000 km. Their difference agrees with SPARKLES' figure within 0.1 mag (`photometry/response.rs`).
#[test]
fn one_hundred_square_metres_at_5_and_20_micrometres() {
    /// Tolerance, mag: bands of 0.2 % width.
    const BAND_MAG: f64 = 0.01;
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    assert!(MODEL.contains("\"size_m\": 4.0"));
    fs::write(
        path("large.json"),
        MODEL
            .replace("\"size_m\": 4.0", "\"size_m\": 11.28379167")
            .replace("\"name\": \"kuiper\"", "\"name\": \"large\""),
    )
    .unwrap();
    fs::write(path("5.csv"), "wavelength_nm,response\n4995,1\n5005,1\n").unwrap();
    let ecsv = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: wavelength, unit: micron, datatype: float64}\n\
                # - {name: response, datatype: float64}\nwavelength response\n19.98 0.5\n20.02 0.5\n";
    fs::write(path("20.ecsv"), ecsv).unwrap();
    for (file, expected) in [("5.csv", 1.417), ("20.ecsv", -2.523)] {
        let (band, model) = (path(file), path("large.json"));
        let found = in_shadow(&passes(&["--band", &band, "--model", &model, "--no-earthshine"]));
        assert!(!found.is_empty() && found.iter().all(|one| (one - expected).abs() < BAND_MAG), "{file}: {found:?}");
    }
}

#[test]
fn invalid_response_files_are_errors_with_their_line() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("band.csv").display().to_string();
    let exposure = ["--start", START, "--exposure", "30s", "--ra", "10", "--dec", "20", "--band", &path];
    for (text, words) in [
        ("wavelength_um,flux\n3,1\n", "missing column response"),
        ("wavelength_um,response\n3,1\n2,1\n", "line 3: wavelength_um is '2'; allowed: wavelengths that increase"),
        ("wavelength,response\n3000,1\n4000,1\n", "line 2: wavelength_um is '3000'; allowed: a number from 0.25 to 50"),
        ("wavelength_um,response\n3,1\n4,-1\n", "line 3: response is '-1'; allowed: a number from 0"),
        ("wavelength_um,response\n3,0\n4,0\n", "no response is positive; allowed: two rows or more"),
    ] {
        fs::write(&path, text).unwrap();
        let (code, _, stderr) = run(&[&["passes"], SHARED, &exposure]);
        assert!(code == 2 && stderr.contains(words) && stderr.contains("band.csv"), "{text}: {code} {stderr}");
    }
    fs::write(&path, "wavelength_um,response\n3,1\n4,1\n").unwrap();
    let (code, _, stderr) = run(&[&["passes"], SHARED, &exposure, &["--mag-system", "Vega"]]);
    assert!(code == 2 && stderr.contains("mag-system is Vega with a response file"), "{stderr}");
}

#[test]
fn a_limit_of_surface_brightness_gives_avoid() {
    let telescope: &[&str] = &["--telescope", "small"];
    let bright = passes(&[&["--band", "W2", "--limit-surface-brightness", "30"], telescope].concat());
    assert!(bright.iter().all(|pass| number(pass, "p_brighter") > 0.9), "{bright:?}");
    let faint = passes(&[&["--band", "W2", "--limit-surface-brightness", "5"], telescope].concat());
    assert!(faint.len() == bright.len() && faint.iter().all(|pass| number(pass, "p_brighter") < 0.1));

    let folder = TempDir::new().unwrap();
    let path = folder.path().join("s.csv").display().to_string();
    let rows: String = (0..360).step_by(45).map(|ra| format!("x{ra},{START},300,{ra},20\n")).collect();
    fs::write(&path, format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{rows}")).unwrap();
    let judged = |more: &[&str]| {
        let flags = ["flag", "--schedule", &path, "--band", "W2", "--format", "json"];
        let (code, stdout, stderr) = run(&[&flags, SHARED, more]);
        assert_eq!(code, 0, "{stderr}");
        let flags = serde_json::from_str::<Value>(&stdout).unwrap()["flags"].as_array().unwrap().clone();
        let of = |verdict: &str| flags.iter().filter(|flag| flag["verdict"] == verdict).cloned().collect::<Vec<_>>();
        (of("avoid"), of("streaked"))
    };
    let (avoided, streaked) = judged(&[telescope, &["--limit-surface-brightness", "30"]].concat());
    assert!(streaked.is_empty() && !avoided.is_empty(), "{streaked:?}");
    assert!(
        avoided.iter().all(|flag| flag["reasons"].to_string().contains("chance of being brighter than 30 mag/arcsec2"))
    );
    let (avoided_faint, streaked) = judged(&[telescope, &["--limit-surface-brightness", "5"]].concat());
    assert!(avoided_faint.is_empty() && streaked.len() == avoided.len());
    // The policy has the same key, and the limit needs a telescope.
    let policy = folder.path().join("p.toml").display().to_string();
    fs::write(&policy, "limit_surface_brightness = { W2 = 5, default = 30 }\n").unwrap();
    assert_eq!(judged(&[telescope, &["--policy", &policy]].concat()).0.len(), avoided.len());
    let (code, _, stderr) = run(&[&["flag", "--schedule", &path], SHARED, &["--policy", &policy]]);
    assert!(code == 2 && stderr.contains("missing telescope for limit-surface-brightness"), "{stderr}");
}

/// Exposures at the next starts have the verdict that the starts promise, in visual light and in thermal bands, where
/// satellites in the Earth's shadow block as well. The longest delay is searched in parts.
#[test]
fn exposures_at_the_next_starts_are_clear_or_acceptable() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("night.csv").display().to_string();
    let flags_of = |rows: &[(String, String)], more: &[&str]| -> Vec<Value> {
        let row = |(number, (start, field)): (usize, &(String, String))| format!("{number},{start},30,{field}");
        let rows: Vec<String> = rows.iter().enumerate().map(row).collect();
        fs::write(&path, format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{}\n", rows.join("\n"))).unwrap();
        let site =
            ["flag", "--schedule", &path, "--mpc", "X05", "--shells", "starlink-gen1,oneweb", "--format", "json"];
        let (code, stdout, stderr) = run(&[&site, &["--quiet", "--fov", "9deg"], more]);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).unwrap()["flags"].as_array().unwrap().clone()
    };
    let policy = folder.path().join("margin.toml").display().to_string();
    fs::write(&policy, "margin_s = 5\n").unwrap();
    for (more, start_key, verdicts) in [
        (["--band", "W2", "--policy", &policy].as_slice(), "next_clear_start_utc", ["clear"].as_slice()),
        (&["--band", "V"], "next_clear_start_utc", &["clear"]),
        (&["--limit-mag", "7.5"], "next_acceptable_start_utc", &["clear", "streaked"]),
    ] {
        // Before midnight and at dawn, from 30 to 60 deg above the horizon.
        let rows: Vec<(String, String)> = (0..24)
            .map(|number| {
                let hour = if number < 12 { 2 } else { 9 };
                let field = format!("{},{}", 15 * (hour + 13) + 5 * (number % 12) - 25, -60 + 5 * (number % 12));
                (format!("2026-06-21T{hour:02}:{:02}:00Z", 2 * number), field)
            })
            .collect();
        let flags = flags_of(&rows, more);
        let later: Vec<(String, String)> = flags
            .iter()
            .zip(&rows)
            .filter(|(flag, _)| flag["verdict"] != "clear")
            .filter_map(|(flag, (_, field))| Some((flag[start_key].as_str()?.to_owned(), field.clone())))
            .collect();
        assert!(later.len() > 4, "{more:?}: {} of {}", later.len(), flags.len());
        for (flag, row) in flags_of(&later, more).iter().zip(&later) {
            assert!(verdicts.contains(&flag["verdict"].as_str().unwrap()), "{more:?} {row:?}: {flag}");
        }
    }
}
