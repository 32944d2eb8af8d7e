//! `streakcast map`: tables, FITS, pictures, and errors for invalid arguments.

use std::fs;

use assert_cmd::Command;
use tempfile::tempdir;

const STREAKCAST: &str = env!("CARGO_BIN_EXE_streakcast");
const BODY: &[&str] = &["map", "body", "--model", "starlink-v1.5", "--sun-latitude-deg", "-14"];
const SKY: &[&str] = &["map", "sky", "--model", "starlink-v1.5", "--sun-altitude-deg", "-16"];

fn run(arguments: &[&[&str]]) -> (i32, String, String) {
    let output = Command::new(STREAKCAST).env("STREAKCAST_NO_HOME", "1").args(arguments.concat()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Returns the rows after the provenance, including the header.
fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect()).collect()
}

#[track_caller]
fn output(arguments: &[&[&str]]) -> String {
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
    let text = output(&[BODY, &["--format", "csv"]]);
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
    // Earthshine does not apply to the mean model, and is not stated.
    let mean = output(&[&["map", "body", "--model", "oneweb", "--sun-latitude-deg", "-14", "--format", "csv"]]);
    assert!(mean.contains("# model: ") && !mean.contains("earthshine"), "{}", &mean[..400]);
    let sunlight = output(&[BODY, &["--no-earthshine", "--format", "csv"]]);
    assert!(sunlight.contains("# earthshine: \"off\"") && rows != self::rows(&sunlight));
    // Where no lit panel is visible, the satellite is a diffuse body; sunlight on the panels alone is fainter than
    // that.
    assert!(rows[1..].iter().all(|row| row[2].parse::<f64>().unwrap() < 20.0));
    assert!(self::rows(&sunlight)[1..].iter().any(|row| row[2].parse::<f64>().is_ok_and(|magnitude| magnitude > 30.0)));
}

#[test]
fn verif_sky_table_of_a_site() {
    let text = output(&[SKY, &["--height-km", "550", "--format", "csv", "--step-deg", "5"]]);
    let sphere = rows(&text);
    assert_eq!(sphere[0], ["azimuth_deg", "altitude_deg", "range_km", "magnitude"]);
    assert_eq!(sphere.len(), 1 + 72 * 19);
    assert_eq!(sphere[sphere.len() - 1][2], "550.000");
    assert!(text.contains("# earth: \"sphere of 6378.137 km\""));
    // Low and opposite to the Sun, the satellite is in the shadow: the range is given, but no magnitude.
    let low = sphere.iter().find(|row| row[0] == "180.000000" && row[1] == "10.000000").unwrap();
    assert!(low[3].is_empty() && low[2].parse::<f64>().unwrap() > 1500.0);
    let place = ["--mpc", "X05", "--sun-azimuth-deg", "250", "--extinction", "0.15", "--band", "r"];
    let text = output(&[SKY, &place, &["--step-deg", "5", "--format", "csv"]]);
    assert!(text.contains("# earth: \"WGS84 ellipsoid\"") && text.contains("# extinction_mag_per_airmass: 0.15"));
    assert!(text.contains("# band: \"r\"") && text.contains("# mag_system: \"AB\""), "{}", &text[..600]);
    assert_ne!(rows(&text)[100], sphere[100]);
}

#[test]
fn verif_cells_in_every_format() {
    let text = output(&[SKY, &["--nside", "4", "--format", "csv"]]);
    let rows = rows(&text);
    assert_eq!(rows[0][0], "healpix_cell");
    assert_eq!((rows.len(), rows[1][0], rows[104][0]), (105, "0", "103"));
    assert!(output(&[SKY, &["--nside", "4", "--format", "ecsv"]]).contains("{name: range_km, unit: km"));
    let json: serde_json::Value = serde_json::from_str(&output(&[SKY, &["--nside", "4", "--format", "json"]])).unwrap();
    assert_eq!(json["directions"].as_array().unwrap().len(), 104);
    assert_eq!(json["provenance"]["sun_altitude_deg"], -16.0);
}

#[test]
fn verif_several_output_files() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (table, picture) = (path("body.csv"), path("body.svg"));
    assert_eq!(output(&[BODY, &["-o", &table, "--picture", &picture]]), "");
    assert!(fs::read_to_string(&picture).unwrap().starts_with("<svg"));
    assert_eq!(rows(&fs::read_to_string(&table).unwrap()).len(), 8281);
}

#[test]
fn verif_the_papers_twelve_maps() {
    let folder = tempdir().unwrap();
    let made = folder.path().join("figures");
    assert_eq!(output(&[&["map", "paper", "-o", &made.display().to_string()]]), "");
    for figure in 6..=9 {
        let bytes = fs::read(made.join(format!("figure-{figure}.png"))).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 50_000, "figure {figure}: {} bytes", bytes.len());
    }
    assert_eq!(fs::read_dir(&made).unwrap().count(), 4);
}

/// Options of the photometry also apply to the figures of the paper.
#[test]
fn verif_the_papers_figures_in_another_band() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let file = output(&[&["model", "show", "oneweb"]]);
    let file = file.replace("\"oneweb\"", "\"mine\"").replace("\"provisional\": false", "\"provisional\": true");
    fs::write(path("mine.json"), file).unwrap();
    fs::write(path("mine.toml"), "extinction = 0.2\n[models]\nfiles = ['mine.json']\n").unwrap();
    let (made, config) = (path("figures"), path("mine.toml"));
    let paper = ["map", "paper", "--format", "svg", "-o", &made, "--model", "mine", "--config", &config, "--band", "r"];
    let (code, _, stderr) = run(&[&paper, &["--threads", "1"]]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("warning: model prior:mine is provisional"), "{stderr}");
    assert!(
        stderr.contains("warning: extinction of the configuration has no effect on the paper's figures"),
        "{stderr}"
    );
    let figure = fs::read_to_string(folder.path().join("figures/figure-7.svg")).unwrap();
    assert!(figure.contains("r (AB)"));
    assert!(
        figure.contains(r#""Provenance":{"band":"r""#) && figure.contains(r#""model":"prior:mine""#),
        "{}",
        &figure[..900]
    );
    fails(&[&paper, &["--threads", "0"]], &["threads is 0"]);
}

#[cfg(unix)]
#[test]
fn verif_fits_by_format_or_by_name() {
    // A name that CFITSIO would interpret as an expression.
    let folder = tempdir().unwrap();
    for (name, more) in [("map[1].fits", &["--nside", "16"][..]), ("map.out", &["--format", "fits", "--nside", "16"])] {
        let path = folder.path().join(name);
        assert_eq!(output(&[SKY, more, &["-o", &path.display().to_string()]]), "");
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"SIMPLE  =") && bytes.len() > 12 * 256 * 16, "{name}: {}", bytes.len());
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    fails(&[SKY, &["--format", "fits"]], &["missing output file for format fits; specify -o"]);
    let path = folder.path().join("x.fits").display().to_string();
    fails(&[SKY, &["--step-deg", "1", "-o", &path]], &["--step-deg is given with format fits"]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn verif_invalid_arguments() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("out.csv").display().to_string();
    let out = ["-o", path.as_str()];
    let known = "bluebird, direct-to-cell";
    fails(&[&["map", "body", "--model", "nope", "--sun-latitude-deg", "-14"], &out], &["unknown model 'nope'", known]);
    fails(&[&["map", "body", "--model", "no.json", "--sun-latitude-deg", "-14"], &out], &["model no.json"]);
    fails(&[BODY, &["--height-km", "0"], &out], &["height is 0 km; allowed: above 0, at most 100000 km"]);
    fails(&[SKY, &["--height-km", "-550"], &out], &["height is -550 km"]);
    fails(&[SKY, &["--height-km", "nan"], &out], &["height is NaN km"]);
    fails(
        &[&["map", "sky", "--model", "v1.5", "--sun-altitude-deg", "-91"], &out],
        &["Sun's altitude is -91", "-90 to 90"],
    );
    fails(&[&["map", "body", "--model", "v1.5", "--sun-latitude-deg", "95"], &out], &["Sun's latitude is 95"]);
    fails(&[SKY, &["--sun-azimuth-deg", "1000"], &out], &["Sun's azimuth is 1000"]);
    fails(&[SKY, &["--step-deg", "7"], &out], &["step is 7 deg; allowed: 0.1 to 5 deg"]);
    fails(&[SKY, &["--nside", "0"], &out], &["nside is 0; allowed: 1 to 1024"]);
    fails(&[SKY, &["--nside", "8", "--step-deg", "2"], &out], &["cannot be used with"]);
    fails(&[SKY, &["--site", "Nowhere at all"], &out], &["Nowhere at all"]);
    fails(&[SKY, &["--lat", "91", "--lon", "0"], &out], &["lat"]);
    fails(&[SKY, &["--extinction", "-1"], &out], &["extinction is -1 mag; allowed: 0 to 5 mag"]);
    fails(&[SKY, &["--band", "q"], &out], &["q"]);
    fails(&[SKY, &["--threads", "100000"], &out], &["threads is 100000; allowed: 1 to 1024"]);
    fails(&[&["map", "sky", "--model", "v1.5"], &out], &["--sun-altitude-deg"]);
    {
        fails(
            &[SKY, &["--picture", "map.gif"], &out],
            &["invalid picture name map.gif; allowed: a name that ends in .png or .svg"],
        );
        for flag in ["--picture", "-o"] {
            fails(&[SKY, &[flag, "map.PDF"]], &["invalid picture name map.PDF: PDF is not supported"]);
        }
        fails(&[SKY, &["--picture", "Cargo.toml/map.png"], &out], &["folder Cargo.toml: "]);
        fails(&[&["map", "paper", "-o", "Cargo.toml"]], &["folder Cargo.toml: "]);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn verif_a_provisional_model_and_a_hidden_sun_are_reported() {
    let (_, _, stderr) = run(&[BODY]);
    // Same as in the model file.
    let file = output(&[&["model", "show", "starlink-v1.5", "--format", "json"]]);
    let file: serde_json::Value = serde_json::from_str(&file).unwrap();
    assert_eq!(stderr.contains("is provisional"), file["provenance"]["provisional"] == true, "{stderr}");
    let dark = ["map", "body", "--model", "visorsat", "--sun-latitude-deg", "-30"];
    assert!(run(&[&dark]).2.contains("below the Earth's limb (-23.0 deg)"));
    assert_eq!(run(&[&dark, &["--quiet"]]).2, "");
    assert_eq!(run(&[&dark, &["--height-km", "1200"]]).2, "");
}

/// The extension of the file name (in any case) determines the format. Unsupported ones are rejected before the
/// computation.
#[test]
fn verif_file_name_extensions() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    #[cfg(unix)]
    for name in ["a.FITS", "a.fit", "a.Fits"] {
        assert_eq!(output(&[SKY, &["--nside", "4", "-o", &path(name)]]), "");
        assert!(fs::read(path(name)).unwrap().starts_with(b"SIMPLE  ="), "{name}");
        fs::remove_file(path(name)).unwrap();
    }
    assert_eq!(output(&[SKY, &["--nside", "4", "-o", &path("a.JSON")]]), "");
    assert!(fs::read_to_string(path("a.JSON")).unwrap().starts_with('{'));
    fs::remove_file(path("a.JSON")).unwrap();

    fails(&[SKY, &["-o", &path("a.fits.gz")]], &["which is not supported; allowed: ", "a.fits"]);
    fails(&[SKY, &["-o", &path("a.PNG")]], &["is a picture; allowed: --picture", "a.PNG"]);
    fails(&[SKY, &["-o", &path("a.svg"), "--format", "csv"]], &["is a picture; allowed: --picture"]);
    fails(
        &[SKY, &["-o", &path("a.csv"), "--format", "fits"]],
        &["does not have the format fits", "allowed: the extension .fits"],
    );
    fails(
        &[SKY, &["-o", &path("a.fits"), "--format", "ecsv"]],
        &["does not have the format ecsv", "allowed: the extension .ecsv"],
    );
    fails(
        &[SKY, &["--format", "parquet"]],
        &["unknown format 'parquet'; allowed: table, csv, ecsv, json, jsonl, votable, fits"],
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn verif_two_outputs_need_two_files() {
    let folder = tempdir().unwrap();
    fs::create_dir(folder.path().join("sub")).unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    for (output, picture) in [("a.svg", "a.svg"), ("a.svg", "./a.svg"), ("sub/../a.png", "a.png")] {
        let outputs = ["-o", &path(output), "--picture", &path(picture)];
        fails(&[SKY, &outputs], &["is also another output; allowed: another file"]);
    }
    fails(
        &[SKY, &["--nside", "8", "--picture", &path("a.png")]],
        &["--nside has no effect on a picture", "(-o or --format)"],
    );
    fails(&[BODY, &["--step-deg", "1", "--picture", &path("a.png")]], &["--step-deg has no effect on a picture"]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let both = output(&[BODY, &["--step-deg", "5", "--picture", &path("a.png"), "--format", "csv"]]);
    assert_eq!(rows(&both).len(), 1 + 72 * 19);
    assert!(fs::read(path("a.png")).unwrap().starts_with(b"\x89PNG"));
}

/// Values of the configuration are used unless flags override them. Values without effect on a map are reported.
#[test]
fn verif_a_configuration() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let config = |name: &str, text: &str| {
        fs::write(path(name), text).unwrap();
        path(name)
    };
    let night = config("night.toml", "format = 'json'\nband = 'r'\nmpc = 'X05'\nfov = '3deg'\nsun-distance = true\n");
    let with = ["--config", night.as_str(), "--nside", "4"];
    let (code, stdout, stderr) = run(&[SKY, &with]);
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((code, &json["provenance"]["band"], json["directions"][0].is_object()), (0, &"r".into(), true));
    assert!(
        stderr.contains("warning: sun_distance of the configuration has no effect on a map of the sky"),
        "{stderr}"
    );
    // Flags and file name extensions take precedence.
    assert!(output(&[SKY, &with, &["--format", "csv"]]).contains("healpix_cell,azimuth_deg"));
    let table = path("sky.csv");
    assert_eq!(output(&[SKY, &with, &["-o", &table]]), "");
    assert!(fs::read_to_string(&table).unwrap().contains("healpix_cell,azimuth_deg"));
    let other = path("sky.out");
    assert_eq!(output(&[SKY, &with, &["-o", &other]]), "");
    assert!(fs::read_to_string(&other).unwrap().starts_with('{'));

    let air = config("air.toml", "extinction = 0.2\nshadow = 'atmosphere'\n");
    let (code, _, stderr) = run(&[BODY, &["--config", &air]]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains(
        "extinction, shadow of the configuration have no effect on a map of the directions around a satellite"
    ));
    assert!(!run(&[SKY, &["--config", &air, "--step-deg", "5"]]).2.contains("no effect"));

    let space = config("space.toml", "observer_norad = 20580\nobserver_elements = 'hst.tle'\n");
    fails(&[SKY, &["--config", &space]], &["observer of the configuration is in orbit", "--site, --mpc, or --lat"]);
    output(&[SKY, &["--config", &space, "--mpc", "X05", "--step-deg", "5"]]);
    output(&[BODY, &["--config", &space, "--step-deg", "5"]]);
}

#[test]
fn verif_a_model_is_a_name_or_a_path() {
    let folder = tempdir().unwrap();
    let file = output(&[&["model", "show", "oneweb"]]).replace("\"oneweb\"", "\"mine\"");
    fs::write(folder.path().join("mine.v2"), &file).unwrap();
    fs::write(folder.path().join("oneweb"), "no model").unwrap();
    let here = |model: &str| {
        let arguments =
            ["map", "body", "--model", model, "--sun-latitude-deg", "-14", "--step-deg", "5", "--format", "csv"];
        let output = Command::new(STREAKCAST)
            .env("STREAKCAST_NO_HOME", "1")
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap())
    };
    let whole = folder.path().join("mine.v2").display().to_string();
    for path in ["mine.v2", "./mine.v2", &whole] {
        assert!(here(path)[0].contains("# model: \"prior:mine\""), "{path}: {:?}", here(path)[1]);
    }
    // A name of a bundled model is not read as a file, and a path is not read as a model name.
    assert!(here("oneweb")[0].contains("# model: \"prior:oneweb\""), "{}", here("oneweb")[1]);
    assert!(here("./oneweb")[1].contains("./oneweb"));
    assert!(
        here("no/such/model")[1].contains("error: model no/such/model: No such file"),
        "{}",
        here("no/such/model")[1]
    );
    assert!(here("nope")[1].contains("unknown model 'nope', and no file of that name; allowed:"));
}

#[cfg(unix)]
#[test]
fn verif_an_invalid_temporary_folder_is_reported_once_with_a_remedy() {
    let folder = tempdir().unwrap();
    let output = folder.path().join("a.fits");
    let map_with = |scratch: &std::path::Path| {
        Command::new(STREAKCAST)
            .env("STREAKCAST_NO_HOME", "1")
            .args([SKY, &["--nside", "4", "-o", &output.display().to_string()]].concat())
            .env("TMPDIR", scratch)
            .output()
            .unwrap()
    };
    let scratch = folder.path().join("missing");
    let stderr = String::from_utf8(map_with(&scratch).stderr).unwrap();
    let error = stderr.lines().find(|line| line.starts_with("error: ")).unwrap();
    assert!(error.contains("No such file") && error.contains("TMPDIR sets another folder"), "{error}");
    assert_eq!(error.matches(&scratch.display().to_string()).count(), 1, "{error}");
    assert!(!output.exists());
    // CFITSIO interprets brackets in a file name as a filter; the temporary folder may contain brackets.
    let bracket = folder.path().join("a[b]");
    fs::create_dir(&bracket).unwrap();
    assert!(map_with(&bracket).status.success());
    assert!(output.exists());
}
