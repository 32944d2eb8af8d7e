//! Photometry options on the command line: each changes magnitudes as documented, and is stated in the provenance.

use std::fs;

use crate::common::cli::{SKY, json, path, run};
use serde_json::Value;
use streakcast::frames::Direction;
use streakcast::photometry::ModelLibrary;

/// Wide field at dusk with Starlink satellites.
const PASSES: &[&str] = &[
    "passes",
    "--start",
    "2024-08-14T23:30:00Z",
    "--exposure",
    "120s",
    "--ra",
    "217.5",
    "--dec=-30",
    "--fov",
    "80deg",
];

/// Largest difference between the sigma at the peak and that at the brightest of 401 points.
const PEAK_SIGMA_MAG: f64 = 0.05;

/// Returns satellite, magnitude and altitude (radians) of every pass with a magnitude.
fn magnitudes(answer: &Value) -> Vec<(u64, f64, f64)> {
    let of = |pass: &Value| {
        Some((pass["norad_id"].as_u64()?, pass["magnitude"].as_f64()?, pass["altitude_deg"].as_f64()?.to_radians()))
    };
    answer["passes"].as_array().unwrap().iter().filter_map(of).collect()
}

fn passes_with(flags: &[&str]) -> Value {
    json(&[PASSES, SKY, flags])
}

#[test]
fn extinction_dims_by_the_airmass() {
    let (above, below) = (passes_with(&[]), passes_with(&["--extinction", "0.2"]));
    let (above_air, below_air) = (magnitudes(&above), magnitudes(&below));
    assert!(above_air.len() > 10 && above_air.len() == below_air.len(), "{}", above_air.len());
    for ((id, above, altitude_rad), (same, below, _)) in above_air.into_iter().zip(below_air) {
        assert_eq!(id, same);
        // Above 20 degrees, the plane-parallel airmass has an error of 1 %, and the altitude an error of 0.2 degrees
        // (geodetic latitude).
        if altitude_rad > 0.35 {
            assert!((below - above - 0.2 / altitude_rad.sin()).abs() < 0.01, "{id}: {above} {below} {altitude_rad}");
        }
        assert!(below > above + 0.199);
    }
    assert_eq!(below["provenance"]["extinction_mag_per_airmass"], 0.2);
    assert!(above["provenance"]["extinction_mag_per_airmass"].is_null());
}

#[test]
fn the_distance_of_the_sun_on_the_date() {
    let (standard, of_the_day) = (magnitudes(&passes_with(&[])), magnitudes(&passes_with(&["--sun-distance"])));
    assert!(standard.len() > 10);
    for ((_, standard, _), (_, of_the_day, _)) in standard.into_iter().zip(of_the_day) {
        // 1.0126 au on 14 August 2024 (astronomical almanacs): 5 log₁₀ R = 0.0272, printed to 0.001.
        assert!((of_the_day - standard - 0.0272).abs() < 0.0016, "{standard} {of_the_day}");
    }
}

#[test]
fn earthshine_only_brightens_and_is_named() {
    let (with, without) = (passes_with(&[]), passes_with(&["--no-earthshine"]));
    assert_eq!(
        (&with["provenance"]["earthshine"], &without["provenance"]["earthshine"]),
        (&"computed".into(), &"off".into())
    );
    let pairs: Vec<_> = magnitudes(&with).into_iter().zip(magnitudes(&without)).collect();
    assert!(pairs.iter().all(|((_, with, _), (_, without, _))| with <= without));
}

/// Model of a panel on the upper side, which is not visible from the ground.
const UPPER_PANEL: &str = r#"{"schema": 1, "name": "top", "title": "Panel on the upper side", "kind": "panels", "band": "V",
"mag_system": "Vega", "size_m": 2.0, "sigma_mag": 0.5, "sigma_origin": "assumed", "panels": {"parameters": [], "panels": [
{"name": "top", "anchor_m": [0, 0, 0], "u_m": [0, 1], "v_m": [0, 1], "attitude": {"law": "nadir"}, "front": [],
"back": [{"law": "lambert", "albedo": 0.2}], "through": [], "earthshine": false}]}, "provenance": {"source": "test",
"data": "none", "n_points": 0, "date": "2026-11", "provisional": false, "notes": []}}"#;

#[test]
fn a_sunlit_satellite_without_light_of_its_model_has_that_of_the_prior() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("top.json");
    std::fs::write(&path, UPPER_PANEL).unwrap();
    let answer = passes_with(&["--model", path.to_str().unwrap(), "--no-earthshine", "--limit-mag", "7"]);
    let passes = answer["passes"].as_array().unwrap();
    assert!(passes.len() > 10, "{}", passes.len());
    for pass in passes {
        assert_eq!(pass["mag_source"], "prior", "{pass}");
        assert!(pass["magnitude"].is_number() && pass["p_brighter"].as_f64().unwrap() > 0.01, "{pass}");
    }
}

#[test]
fn passes_have_the_fitted_range_flag() {
    let answer = passes_with(&[]);
    let passes = answer["passes"].as_array().unwrap();
    let flagged = passes.iter().filter(|pass| pass["in_fitted_range"].is_boolean()).count();
    assert_eq!(flagged, magnitudes(&answer).len());
    assert!(passes.iter().any(|pass| pass["in_fitted_range"] == true));
}

/// The sigma beside the peak magnitude is that at the brightest point, also if the satellite is in shadow at mid.
#[test]
fn peak_magnitudes_have_their_own_sigma() {
    let later = ["passes", "--start", "2024-08-15T00:15:00Z", "--exposure", "120s", "--ra", "240", "--dec=-30"];
    let answer = json(&[&later, SKY, &["--fov", "80deg", "--samples", "401"]]);
    let passes = answer["passes"].as_array().unwrap();
    let number = |value: &Value| value.as_f64().unwrap_or(f64::INFINITY);
    let bright: Vec<&Value> = passes.iter().filter(|pass| pass["magnitude_peak"].is_f64()).collect();
    assert!(bright.iter().any(|pass| pass["magnitude"].is_null()), "no satellite is in shadow at mid");
    for pass in bright {
        let samples = pass["samples"].as_array().unwrap();
        let brightest =
            samples.iter().min_by(|a, b| number(&a["magnitude"]).total_cmp(&number(&b["magnitude"]))).unwrap();
        let difference = number(&pass["magnitude_peak_sigma"]) - number(&brightest["magnitude_sigma"]);
        assert!(difference.abs() < PEAK_SIGMA_MAG, "{pass}");
    }
}

#[test]
fn an_invalid_extinction_is_rejected() {
    for wrong in ["-0.1", "9"] {
        let flag = format!("--extinction={wrong}");
        let (code, stdout, stderr) = run(&[PASSES, SKY, &[&flag]]);
        assert!(code == 2 && stdout.is_empty() && stderr.contains("0 to 5 mag") && stderr.contains(wrong), "{stderr}");
    }
}

/// Models given by `--model`: one for all satellites and one for a generation, by name and as a file. The model for a
/// generation takes precedence, and all are stated in the rows and in the provenance.
#[test]
fn models_of_all_satellites_and_of_a_kind() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.json");
    let (_, text, _) = run(&[&["model", "show", "oneweb"]]);
    std::fs::write(&file, text.replace("\"oneweb\"", "\"mine\"")).unwrap();
    let sources = |answer: &Value| -> Vec<(String, String)> {
        let text = |pass: &Value, key: &str| pass[key].as_str().unwrap_or_default().to_owned();
        answer["passes"].as_array().unwrap().iter().map(|pass| (text(pass, "name"), text(pass, "mag_source"))).collect()
    };
    let own = format!("starlink-v1.5={}", file.display());
    for (flags, expected) in [
        (vec!["--model", "kuiper"], ":kuiper"),
        (vec!["--model", own.as_str(), "--model", "kuiper"], ":mine"),
        (vec!["--model", "oneweb=kuiper", "--model", "starlink-v1.5=starlink-v1.5-phase"], ":starlink-v1.5-phase"),
    ] {
        let answer = passes_with(&flags);
        let given = sources(&answer);
        assert!(given.len() > 10 && given.iter().all(|(_, source)| source.ends_with(expected)), "{given:?}");
        let stated = answer["provenance"]["models"].as_array().unwrap();
        assert!(stated.len() == 1 && stated[0].as_str().unwrap().ends_with(expected), "{stated:?}");
    }
    for (wrong, named, allowed) in [
        ("nothing", "unknown model 'nothing'", "starlink-v1.5"),
        ("nothing=oneweb", "unknown kind of satellite 'nothing'", "starlink-visorsat"),
        ("oneweb=", "empty name of a model", "KIND=MODEL"),
    ] {
        let (code, _, stderr) = run(&[PASSES, SKY, &["--model", wrong]]);
        assert!(code == 2 && stderr.contains(named) && stderr.contains(allowed), "{stderr}");
    }
}

/// `model pressure` has the force of the library, at the latitudes that are given.
#[test]
fn pressure_of_sunlight_is_that_of_the_library() {
    let latitudes_deg = ["-20", "15", "60"];
    let words = ["model", "pressure", "starlink-v1.5-facets", "--mass-kg", "250", "--quiet", "--sun-latitude-deg"];
    let answer = json(&[&words, &latitudes_deg]);
    let rows = answer["accelerations"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    let model = ModelLibrary::embedded().find("starlink-v1.5-facets").unwrap();
    for (row, latitude_deg) in rows.iter().zip(latitudes_deg) {
        let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name}: {row}"));
        let latitude_deg: f64 = latitude_deg.parse().unwrap();
        assert_eq!(number("sun_latitude_deg"), latitude_deg);
        let to_sun = Direction::from_lon_lat_rad(0.0, latitude_deg.to_radians());
        let force = model.sunlight_force(&to_sun).unwrap();
        let expected = *force.acceleration(250.0, 1.0, 1.0).unwrap().vector() * 1e9;
        // Rounded to four decimals.
        for (axis, expected) in ["x", "y", "z"].iter().zip(expected.iter()) {
            assert!((number(&format!("acceleration_{axis}_nm_s2")) - expected).abs() < 1e-4, "{row}");
        }
        let away = -expected.dot(to_sun.vector());
        assert!((number("acceleration_away_from_sun_nm_s2") - away).abs() < 1e-4, "{row}");
        assert!((number("cross_section_m2") - force.cross_section_m2).abs() < 1e-4, "{row}");
        // Panels reflect or transmit a few hundredths of the light and absorb the rest. Transmitted light reduces the
        // force.
        assert!((0.95..1.2).contains(&number("pressure_coefficient")), "{row}");
        assert_eq!(row["in_fitted_range"], latitude_deg == -20.0);
    }
    assert_eq!(answer["provenance"]["mass_kg"], 250.0);
    assert_eq!(json(&[&words[..6]])["accelerations"].as_array().unwrap().len(), 13);
}

/// The brightness of an object with 99.9 or 0.0 in a table of standard magnitudes is unknown.
#[test]
fn placeholders_of_standard_magnitudes_are_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let (elements, table) = (path(&folder, "k.tle"), path(&folder, "qs.mag"));
    let tle = "OBJECT K\n1 33333U 08042A   26233.40737406  .00000509  00000+0  28042-4 0  9999\n\
               2 33333  43.0022 234.8033 0002196 253.9405 106.1205 15.27591224176824\n";
    fs::write(&elements, tle).unwrap();
    let sources = |magnitude: &str| {
        fs::write(&table, format!("33333   08 42A    OBJ            {magnitude}\n")).unwrap();
        let time = ["--times", "2026-08-22T03:14:55Z", "--norad", "33333", "--mpc", "X05", "--format", "json"];
        let (code, stdout, stderr) = run(&[&["ephemeris", "--elements", &elements, "--qs-mag", &table], &time]);
        assert_eq!(code, 0, "{stderr}");
        let answer: Value = serde_json::from_str(&stdout).unwrap();
        let warning = "1 magnitude of 1 satellite in the table of standard magnitudes ignored";
        (answer["provenance"]["models"].to_string().contains("prior"), stderr.contains(warning))
    };
    assert_eq!([sources("99.9"), sources(" 0.0"), sources(" 6.5")], [(true, true), (true, true), (false, false)]);
}
