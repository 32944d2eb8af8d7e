//! `streakcast map`: tables, FITS, pictures, and what it says to questions that are none.

use std::fs;

use assert_cmd::Command;
use tempfile::tempdir;

const STREAKCAST: &str = env!("CARGO_BIN_EXE_streakcast");
const BODY: &[&str] = &["map", "body", "--model", "starlink-v1.5", "--sun-latitude-deg", "-14"];
const SKY: &[&str] = &["map", "sky", "--model", "starlink-v1.5", "--sun-altitude-deg", "-16"];

fn run(arguments: &[&[&str]]) -> (i32, String, String) {
    let output = Command::new(STREAKCAST).args(arguments.concat()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// The rows below the provenance: the header first.
fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect()).collect()
}

#[track_caller]
fn answers(arguments: &[&[&str]]) -> String {
    let (code, stdout, stderr) = run(arguments);
    assert_eq!(code, 0, "{stderr}");
    stdout
}

#[track_caller]
fn fails(arguments: &[&[&str]], parts: &[&str]) {
    let (code, stdout, stderr) = run(arguments);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    let errors: Vec<&str> = stderr.lines().filter(|line| !line.starts_with("warning: ")).collect();
    assert_eq!(errors.len(), 1, "{stderr}");
    for part in parts {
        assert!(errors[0].contains(part), "'{part}' is not in: {}", errors[0]);
    }
}

#[test]
fn verif_body_table() {
    let text = answers(&[BODY, &["--format", "csv"]]);
    let rows = rows(&text);
    assert_eq!(rows[0], ["observer_longitude_deg", "observer_latitude_deg", "standard_magnitude"]);
    assert_eq!(rows.len(), 1 + 180 * 46);
    assert!(text.contains("# sun_latitude_deg: -14.0") && text.contains("# model: \"brdf:starlink-v1.5\""));
    for row in &rows[1..] {
        let latitude: f64 = row[1].parse().unwrap();
        assert!((-90.0..=0.0).contains(&latitude) && row[0].parse::<f64>().unwrap() < 360.0);
        assert!(row[2].is_empty() || row[2].parse::<f64>().unwrap().is_finite(), "{row:?}");
    }
    assert!(text.contains("# earthshine: \"computed\""));
    let sunlight = answers(&[BODY, &["--no-earthshine", "--format", "csv"]]);
    assert!(sunlight.contains("# earthshine: \"off\"") && rows != self::rows(&sunlight));
    assert!(rows.iter().any(|row| row[2].is_empty()) && rows.iter().filter(|row| !row[2].is_empty()).count() > 8000);
}

#[test]
fn verif_sky_table_of_a_site() {
    let text = answers(&[SKY, &["--height-km", "550", "--format", "csv", "--step-deg", "5"]]);
    let sphere = rows(&text);
    assert_eq!(sphere[0], ["azimuth_deg", "altitude_deg", "range_km", "magnitude"]);
    assert_eq!(sphere.len(), 1 + 72 * 19);
    assert_eq!(sphere[sphere.len() - 1][2], "550.000");
    assert!(text.contains("# earth: \"sphere of 6378.137 km\""));
    // Opposite to the Sun, low: in the shadow, with a range and without a magnitude.
    let low = sphere.iter().find(|row| row[0] == "180.000000" && row[1] == "10.000000").unwrap();
    assert!(low[3].is_empty() && low[2].parse::<f64>().unwrap() > 1500.0);
    let place = ["--mpc", "X05", "--sun-azimuth-deg", "250", "--extinction", "0.15", "--band", "r"];
    let text = answers(&[SKY, &place, &["--step-deg", "5", "--format", "csv"]]);
    assert!(text.contains("# earth: \"WGS84 ellipsoid\"") && text.contains("# extinction_mag_per_airmass: 0.15"));
    assert!(text.contains("# band: \"r\"") && text.contains("# mag_system: \"AB\""), "{}", &text[..600]);
    assert_ne!(rows(&text)[100], sphere[100]);
}

#[test]
fn verif_cells_come_in_every_format() {
    let text = answers(&[SKY, &["--nside", "4", "--format", "csv"]]);
    let rows = rows(&text);
    assert_eq!(rows[0][0], "healpix_cell");
    assert_eq!((rows.len(), rows[1][0], rows[104][0]), (105, "0", "103"));
    assert!(answers(&[SKY, &["--nside", "4", "--format", "ecsv"]]).contains("{name: range_km, unit: km"));
    let json: serde_json::Value =
        serde_json::from_str(&answers(&[SKY, &["--nside", "4", "--format", "json"]])).unwrap();
    assert_eq!(json["directions"].as_array().unwrap().len(), 104);
    assert_eq!(json["provenance"]["sun_altitude_deg"], -16.0);
}

#[test]
fn verif_files_are_made_beside_one_another() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (table, picture) = (path("body.csv"), path("body.svg"));
    #[cfg(feature = "plot")]
    assert_eq!(answers(&[BODY, &["-o", &table, "--picture", &picture]]), "");
    #[cfg(feature = "plot")]
    assert!(fs::read_to_string(&picture).unwrap().starts_with("<svg"));
    #[cfg(not(feature = "plot"))]
    assert_eq!((answers(&[BODY, &["-o", &table]]), picture.is_empty()), (String::new(), false));
    assert_eq!(rows(&fs::read_to_string(&table).unwrap()).len(), 8281);
}

#[cfg(feature = "plot")]
#[test]
fn verif_the_papers_twelve_maps() {
    let folder = tempdir().unwrap();
    let made = folder.path().join("figures");
    assert_eq!(answers(&[&["map", "paper", "-o", &made.display().to_string()]]), "");
    for figure in 6..=9 {
        let bytes = fs::read(made.join(format!("figure-{figure}.png"))).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 50_000, "figure {figure}: {} bytes", bytes.len());
    }
    assert_eq!(fs::read_dir(&made).unwrap().count(), 4);
}

#[cfg(feature = "fits")]
#[test]
fn verif_fits_by_format_or_by_name() {
    // A name that CFITSIO would take for an expression.
    let folder = tempdir().unwrap();
    for (name, more) in [("map[1].fits", &["--nside", "16"][..]), ("map.out", &["--format", "fits", "--nside", "16"])] {
        let path = folder.path().join(name);
        assert_eq!(answers(&[SKY, more, &["-o", &path.display().to_string()]]), "");
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"SIMPLE  =") && bytes.len() > 12 * 256 * 16, "{name}: {}", bytes.len());
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    fails(&[SKY, &["--format", "fits"]], &["needs a file; say -o"]);
    let path = folder.path().join("x.fits").display().to_string();
    fails(&[SKY, &["--step-deg", "1", "-o", &path]], &["--nside 64 instead of --step-deg"]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn verif_questions_that_are_none() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("out.csv").display().to_string();
    let out = ["-o", path.as_str()];
    let known = "bluebird, direct-to-cell";
    fails(&[&["map", "body", "--model", "nope", "--sun-latitude-deg", "-14"], &out], &["unknown model 'nope'", known]);
    fails(&[&["map", "body", "--model", "no.json", "--sun-latitude-deg", "-14"], &out], &["model no.json"]);
    fails(&[BODY, &["--height-km", "0"], &out], &["height 0 km: allowed above 0, at most 100000 km"]);
    fails(&[SKY, &["--height-km", "-550"], &out], &["height -550 km"]);
    fails(&[SKY, &["--height-km", "nan"], &out], &["height NaN km"]);
    fails(
        &[&["map", "sky", "--model", "v1.5", "--sun-altitude-deg", "-91"], &out],
        &["Sun's altitude -91", "-90 to 90"],
    );
    fails(&[&["map", "body", "--model", "v1.5", "--sun-latitude-deg", "95"], &out], &["Sun's latitude 95"]);
    fails(&[SKY, &["--sun-azimuth-deg", "1000"], &out], &["Sun's azimuth 1000"]);
    fails(&[SKY, &["--step-deg", "7"], &out], &["step 7 deg: allowed 0.1 to 5 deg"]);
    fails(&[SKY, &["--nside", "0"], &out], &["nside 0: allowed 1 to 1024"]);
    fails(&[SKY, &["--nside", "8", "--step-deg", "2"], &out], &["cannot be used with"]);
    fails(&[SKY, &["--site", "Nowhere at all"], &out], &["Nowhere at all"]);
    fails(&[SKY, &["--lat", "91", "--lon", "0"], &out], &["lat"]);
    fails(&[SKY, &["--extinction", "-1"], &out], &["extinction -1 mag: allowed 0 to 5 mag"]);
    fails(&[SKY, &["--band", "q"], &out], &["q"]);
    fails(&[&["map", "sky", "--model", "v1.5"], &out], &["--sun-altitude-deg"]);
    #[cfg(feature = "plot")]
    {
        fails(&[SKY, &["--picture", "map.gif"], &out], &["picture map.gif: its name must end in .png or .svg"]);
        fails(&[SKY, &["--picture", "no/such/folder/map.png"], &out], &["no/such/folder"]);
        let both = folder.path().join("both.png").display().to_string();
        fails(&[SKY, &["--picture", &both, "-o", &both]], &["name the same file"]);
        fails(&[&["map", "paper", "-o", "no/such/folder"]], &["cannot make the folder no/such/folder"]);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn verif_a_provisional_model_and_a_sun_behind_the_earth_are_said() {
    let (_, _, stderr) = run(&[BODY]);
    // As the model's own file says it.
    let file = answers(&[&["model", "show", "starlink-v1.5", "--format", "json"]]);
    let file: serde_json::Value = serde_json::from_str(&file).unwrap();
    assert_eq!(stderr.contains("is provisional"), file["provenance"]["provisional"] == true, "{stderr}");
    let dark = ["map", "body", "--model", "visorsat", "--sun-latitude-deg", "-30"];
    assert!(run(&[&dark]).2.contains("below the Earth's limb (-23.0 deg)"));
    assert_eq!(run(&[&dark, &["--quiet"]]).2, "");
    assert_eq!(run(&[&dark, &["--height-km", "1200"]]).2, "");
}
