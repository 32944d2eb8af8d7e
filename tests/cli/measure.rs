//! `measure` on the command line: injected streaks of satellites, outputs, invalid input.

use std::fs;

use crate::common::cli::{done, json, path, published_constellation, records, run};
use crate::common::injected::{SKY, column, numbers, unrounded, with_card, with_new_cards};
use tempfile::TempDir;

/// Largest difference of measured and true flux in sigmas, and the largest bias.
const SIGMAS: f64 = 4.0;
const FLUX_BIAS: f64 = 0.02;

const SATELLITES: &[&str] = &["--shells", "starlink-gen1", "--mpc", "X05", "--quiet"];

/// Format of uploads to SCORE, with the flags that it requires.
const SCORE: &[&str] = &[
    "--format",
    "score",
    "--observer-email",
    "a@example.org",
    "--observer-orcid",
    "0000-0000-0000-0000",
    "--instrument",
    "test",
];

/// A wide frame with the streaks of a synthetic constellation; returns its path and that of its truth table.
fn wide(folder: &TempDir) -> (String, String) {
    wide_with(folder, "")
}

/// Same as `wide`, with more keys in the description of the frame.
fn wide_with(folder: &TempDir, keys: &str) -> (String, String) {
    let description = path(folder, "wide.toml");
    let text = format!("{keys}{}", unrounded())
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0");
    fs::write(&description, text).unwrap();
    let (output, truth) = (path(folder, "wide.fits"), path(folder, "truth.csv"));
    let shot = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"];
    let seeing = ["--seeing", "90arcsec", "--truth", &truth];
    done(&[&["inject", "--synthetic", &description, "-o", &output], &shot, &seeing, SATELLITES]);
    (output, truth)
}

#[test]
fn verif_injected_streaks_of_satellites_have_their_magnitudes() {
    let folder = TempDir::new().unwrap();
    let (frame, truth) = wide(&folder);
    let document = json(&[&["measure", &frame, "--seeing", "90arcsec"], SATELLITES]);
    let rows = document["measurements"].as_array().unwrap();
    let truth = records(&fs::read_to_string(&truth).unwrap());
    let (ids, counts) = (column(&truth, "norad_id"), numbers(&truth, "counts"));
    let mut compared = 0;
    for (id, counts) in ids.iter().zip(&counts) {
        let row = rows.iter().find(|row| row["norad_id"].as_u64() == id.parse().ok()).expect("a predicted track");
        if row["detected"] != true {
            continue;
        }
        let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name}: {row}"));
        // The Sun is so far away that its directions from satellite and observer are the same within 0.001 deg.
        let sum_deg = number("phase_angle_deg") + number("sun_angle_deg");
        assert!((sum_deg - 180.0).abs() < 0.003, "{row}");
        // The triangle of Earth's centre, satellite and observer gives the radius of the orbit, 540 to 570 km high.
        let (range_km, radius_km) = (number("range_km"), 6378.0_f64);
        let along_km = range_km * number("observer_angle_deg").to_radians().cos();
        let orbit_km = along_km + (along_km.powi(2) - range_km.powi(2) + radius_km.powi(2)).sqrt();
        assert!((530.0..590.0).contains(&(orbit_km - radius_km)), "{orbit_km}: {row}");
        // At night the Sun is below the horizon of a low satellite by at most the dip of its horizon, 23 deg.
        assert!((67.0..90.0).contains(&number("sun_incidence_angle_deg")), "{row}");
        for (column, distance_km) in [("magnitude_550_km", 550.0), ("magnitude_1000_km", 1000.0)] {
            let scaled = number("magnitude") - 5.0 * (range_km / distance_km).log10();
            assert!((number(column) - scaled).abs() < 1e-3, "{row}");
        }
        let (rate, sigma, truth) = (number("rate"), number("rate_sigma"), counts / number("duration_s"));
        assert!((rate - truth).abs() < SIGMAS * sigma + FLUX_BIAS * truth, "{id}: {rate} +- {sigma}, true {truth}");
        compared += 1;
    }
    assert!(compared >= 1, "{rows:?}");
    assert!(document["provenance"]["models"].to_string().contains("starlink"));
}

/// A streak corrects the predicted magnitude of the next streaks of its pass, in frames in any order.
#[test]
fn verif_a_streak_corrects_the_prediction_of_the_next_of_its_pass() {
    let folder = TempDir::new().unwrap();
    let elements = published_constellation(&folder, "2026-08-14T00:00:00 UTC");
    let satellites = [elements[0].as_str(), &elements[1], "--mpc", "X05", "--quiet"];
    let description = path(&folder, "wide.toml");
    let text = unrounded()
        .replace("columns = 400", "columns = 1024")
        .replace("rows = 300", "rows = 1024")
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0");
    fs::write(&description, text).unwrap();
    let frames: Vec<String> = ["05", "09"]
        .iter()
        .map(|second| {
            let output = path(&folder, &format!("{second}.fits"));
            let start = format!("2026-08-14T23:29:{second}Z");
            let shot = ["--start", &start, "--exposure", "3s", "--ra", "198.9", "--dec", "7.7"];
            // The satellites are drawn with another model than the one that predicts them.
            let light = ["--seeing", "90arcsec", "--model", "oneweb"];
            done(&[&["inject", "--synthetic", &description, "-o", &output], &shot, &light, &satellites]);
            output
        })
        .collect();
    let rows = |flags: &[&str]| {
        let document = json(&[&["measure", &frames[1], &frames[0], "--seeing", "90arcsec"], flags, &satellites]);
        document["measurements"].as_array().unwrap().clone()
    };
    let found = rows(&[]);
    let mut compared = 0;
    for later in found.iter().filter(|row| row["image"].as_str().unwrap().contains("09.fits")) {
        let is_earlier = |row: &&serde_json::Value| {
            row["image"].as_str().unwrap().contains("05.fits") && row["norad_id"] == later["norad_id"]
        };
        let earlier = found.iter().find(is_earlier).filter(|row| row["detected"] == true);
        let Some(earlier) = earlier else {
            assert!(later["pass_magnitude"].is_null(), "{later}");
            continue;
        };
        assert!(earlier["pass_magnitude"].is_null(), "{earlier}");
        if later["detected"] != true {
            continue;
        }
        let number = |name: &str| later[name].as_f64().unwrap_or_else(|| panic!("{name}: {later}"));
        let off = |name: &str| (number("magnitude") - number(name)).abs();
        // The correlation is 0.7 to 0.9 after 4 s.
        assert!(
            off("predicted_magnitude") > 0.2 && off("pass_magnitude") < 0.4 * off("predicted_magnitude"),
            "{later}"
        );
        assert!((0.01..0.3).contains(&number("pass_magnitude_sigma")), "{later}");
        compared += 1;
    }
    assert!(compared >= 1, "{found:?}");
    // Tables of measured magnitudes correct the prediction of the model itself.
    let table = path(&folder, "first.csv");
    done(&[&["measure", &frames[0], "--seeing", "90arcsec", "--format", "csv", "-o", &table], &satellites]);
    let given = rows(&["--measured", &table]);
    for (given, own) in given.iter().zip(&found) {
        assert!(given["pass_magnitude"].is_null(), "{given}");
        if let Some(magnitude) = own["pass_magnitude"].as_f64() {
            assert!((given["predicted_magnitude"].as_f64().unwrap() - magnitude).abs() < 0.01, "{given} {own}");
        }
    }
}

#[test]
fn verif_uploads_have_the_columns_of_score_and_are_read_by_fit() {
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder);
    let text = done(&[&["measure", &frame, "--seeing", "90arcsec"], SCORE, SATELLITES]);
    let header = "satellite_name,norad_cat_id,observation_time_utc,observation_time_uncertainty_sec,\
                  apparent_magnitude,apparent_magnitude_uncertainty,observer_latitude_deg,observer_longitude_deg,\
                  observer_altitude_m,limiting_magnitude,instrument,observing_mode,observing_filter,observer_email,\
                  observer_orcid,satellite_right_ascension_deg,satellite_declination_deg,sigma_2_ra,\
                  sigma_ra_sigma_dec,sigma_2_dec,range_to_satellite_km,range_to_satellite_uncertainty_km,\
                  range_rate_of_satellite_km_per_sec,range_rate_of_satellite_uncertainty_km_per_sec,comments,\
                  data_archive_link,mpc_code";
    assert_eq!(text.lines().next(), Some(header));
    let rows = records(&text);
    assert!(numbers(&rows, "limiting_magnitude").iter().all(|limit| (0.0..20.0).contains(limit)));
    for (magnitude, comment) in column(&rows, "apparent_magnitude").iter().zip(column(&rows, "comments")) {
        assert_eq!(magnitude.is_empty(), comment == "non-detection");
    }
    if let Some(folder) = crate::common::data_dir() {
        let example =
            fs::read_to_string(folder.join("photometry/score_format/observation_format_example.csv")).unwrap();
        assert_eq!(example.lines().next(), Some(header));
    }
    let photometry = path(&folder, "photometry.csv");
    done(&[&["measure", &frame, "--seeing", "90arcsec", "--format", "fit", "-o", &photometry], SATELLITES]);
    let found = records(&fs::read_to_string(&photometry).unwrap());
    assert!(found.len() > 1);
}

/// Stars of known magnitude replace the zero point and the seeing of the header.
#[test]
fn verif_the_zero_point_is_that_of_stars_in_a_table() {
    /// Largest error of the zero point, mag, in addition to `SIGMAS`, and of the seeing.
    const ZERO_POINT_MAG: f64 = 0.01;
    const SEEING: f64 = 0.05;
    let folder = TempDir::new().unwrap();
    let list = path(&folder, "stars.csv");
    // A grid of stars of 6 to 10 mag; its last star is faint.
    let star = |index: usize| {
        let (ra, dec) = (197.9 + 0.31 * (index % 7) as f64, 6.8 + 0.29 * (index / 7) as f64);
        let mag = if index == 48 { 14.0 } else { 6.0 + 4.0 * (index % 11) as f64 / 10.0 };
        format!("{ra},{dec},{mag},V\n")
    };
    fs::write(&list, format!("ra_deg,dec_deg,magnitude,band\n{}", (0..49).map(star).collect::<String>())).unwrap();
    let (frame, _) = wide_with(&folder, &format!("star_list = {list:?}\n"));
    let document = json(&[&["measure", &frame, "--stars", &list, "--band", "V"], SATELLITES]);
    let rows = document["measurements"].as_array().unwrap();
    // A star of 18 mag gives one electron per second. The zero point is for one count (2 electrons) in the 30 s of the
    // exposure.
    let truth = 18.0 + 2.5 * (30.0f64 / 2.0).log10();
    let mut found = 0;
    for row in rows {
        let number = |name: &str| row[name].as_f64().unwrap();
        let (value, sigma) = (number("zero_point_mag"), number("zero_point_sigma_mag"));
        assert!((value - truth).abs() <= SIGMAS * sigma + ZERO_POINT_MAG, "{value} +- {sigma}, true {truth}");
        assert_eq!(row["calibrated"], true);
        if row["detected"] != true {
            continue;
        }
        let magnitude = value - 2.5 * (number("rate") * 30.0).log10();
        assert!((number("magnitude") - magnitude).abs() < 1e-3, "{row}");
        let relative = 2.5 / std::f64::consts::LN_10 * number("rate_sigma") / number("rate");
        assert!((number("magnitude_sigma") - relative.hypot(sigma)).abs() < 1e-3, "{row}");
        found += 1;
    }
    assert!(found >= 1, "{rows:?}");
    let verbose: Vec<&str> = SATELLITES.iter().copied().filter(|flag| *flag != "--quiet").collect();
    let (_, _, stderr) = run(&[&["measure", &frame, "--stars", &list, "--band", "V"], &verbose]);
    let seeing = stderr.split("FWHM ").nth(1).and_then(|text| text.split(' ').next()).unwrap().parse::<f64>().unwrap();
    assert!(stderr.contains("1 faint") && (seeing / 90.0 - 1.0).abs() < SEEING, "{stderr}");
    let (_, _, stderr) =
        run(&[&["measure", &frame, "--stars", &list, "--band", "V", "--seeing", "140arcsec"], &verbose]);
    assert!(stderr.contains("given seeing 140.00 arcsec"), "{stderr}");

    let few = path(&folder, "few.csv");
    fs::write(&few, format!("ra_deg,dec_deg,magnitude,band\n{}{}", star(0), star(1))).unwrap();
    let (code, stdout, stderr) = run(&[&["measure", &frame, "--stars", &few, "--format", "csv"], &verbose]);
    assert!(code == 0 && stderr.contains("no zero point") && stderr.contains("stars used: 2"), "{stderr}");
    assert!(column(&records(&stdout), "calibrated").iter().all(|cell| cell == "false"));
    for (arguments, part) in [
        (vec!["--stars", "missing.csv"], "missing.csv"),
        (vec!["--stars", &list, "--zero-point", "25"], "cannot be used with"),
        (vec!["--stars", &list, "--band", "R"], "'R'; allowed: V"),
        (vec!["--stars", &list, "--star-colours", "0.7,0.95"], "of which 0 have a colour; allowed: 1 or more"),
        (vec!["--stars", &list, "--star-colours", "1"], "star-colours is '1'; allowed: the bluest and the reddest"),
        (vec!["--star-colours", "0.7,0.95"], "missing table of stars for --star-colours; specify --stars TABLE"),
    ] {
        let (code, _, stderr) = run(&[&["measure", &frame], &arguments, SATELLITES]);
        assert!(code == 2 && stderr.contains(part), "{stderr}");
    }
}

#[test]
fn verif_pictures_show_each_track() {
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder);
    let (png, svg) = (path(&folder, "tracks.png"), path(&folder, "tracks.svg"));
    for picture in [&png, &svg] {
        done(&[&["measure", &frame, "--seeing", "90arcsec", "--picture", picture], SATELLITES]);
    }
    assert!(fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    let drawn = fs::read_to_string(&svg).unwrap();
    let rows = json(&[&["measure", &frame, "--seeing", "90arcsec"], SATELLITES]);
    let rows = rows["measurements"].as_array().unwrap().clone();
    for row in rows.iter().take(12) {
        assert!(drawn.contains(row["name"].as_str().unwrap()), "{row}");
    }
    assert!(drawn.contains("across, pix") && drawn.contains("along the track, pix"));
    // The streaks are at their predicted tracks.
    assert!(drawn.contains("Blue, dashed: predicted track."));
    let (code, _, stderr) = run(&[&["measure", &frame, "--picture", "tracks.txt"], SATELLITES]);
    assert!(code == 2 && stderr.contains(".png or .svg"), "{stderr}");
}

#[test]
fn invalid_input_is_named() {
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder);
    let missing = path(&folder, "missing.fits");
    let text = path(&folder, "text.fits");
    fs::write(&text, "no frame").unwrap();
    let no_wcs = path(&folder, "no_wcs.fits");
    let bytes = fs::read(&frame).unwrap();
    let renamed = |from: &str, to: &str| -> Vec<u8> {
        let mut bytes = bytes.clone();
        for card in bytes.chunks_exact_mut(80) {
            if card.starts_with(from.as_bytes()) {
                card[..to.len()].copy_from_slice(to.as_bytes());
            }
        }
        bytes
    };
    fs::write(&no_wcs, renamed("CTYPE1  ", "XTYPE1  ")).unwrap();
    let no_time = path(&folder, "no_time.fits");
    let mut timeless = bytes.clone();
    for card in timeless.chunks_exact_mut(80) {
        if card.starts_with(b"DATE-OBS") || card.starts_with(b"MJD-OBS ") {
            card.fill(b' ');
        }
    }
    fs::write(&no_time, timeless).unwrap();
    for (arguments, parts) in [
        (vec![missing.as_str()], vec!["missing.fits"]),
        (vec![text.as_str()], vec!["text.fits"]),
        (vec![no_wcs.as_str()], vec!["no_wcs.fits", "CTYPE1"]),
        (vec![no_time.as_str()], vec!["no_time.fits", "allowed"]),
        (vec![frame.as_str(), "--seeing", "0arcsec"], vec!["seeing"]),
        (vec![frame.as_str(), "--seeing", "1e9arcsec"], vec!["allowed"]),
        (vec![frame.as_str(), "--psf", "square"], vec!["square", "allowed"]),
        (vec![frame.as_str(), "--gain", "0"], vec!["gain is 0", "allowed"]),
        (vec![frame.as_str(), "--hdu", "77"], vec!["77"]),
        (vec![frame.as_str(), "--fov", "1deg"], vec!["--fov", "no effect"]),
        (vec![frame.as_str(), "--format", "score"], vec!["--observer-email"]),
        (vec![frame.as_str(), "--format", "sc0re"], vec!["sc0re", "score, fit"]),
    ] {
        let (code, _, stderr) = run(&[&["measure"], &arguments, SATELLITES]);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(stderr.starts_with("error: ") && stderr.lines().count() == 1, "{stderr}");
        assert!(parts.iter().all(|part| stderr.contains(part)), "{arguments:?}: {stderr}");
    }
    // Among others, a frame that cannot be used is left out.
    let document = |frames: &[&str]| -> serde_json::Value {
        let (code, stdout, stderr) = run(&[&["measure"], frames, SATELLITES, &["--format", "json"]]);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str(&stdout).unwrap()
    };
    let (both, alone) = (document(&[&no_wcs, &frame, &missing]), document(&[&frame]));
    assert_eq!(both["measurements"], alone["measurements"]);
    assert!(!both["measurements"].as_array().unwrap().is_empty());
    let loud = [&["measure", &no_wcs, &frame, &missing], &SATELLITES[..SATELLITES.len() - 1]].concat();
    let (_, _, stderr) = run(&[&loud]);
    for name in ["no_wcs.fits", "missing.fits"] {
        let line = stderr.lines().find(|line| line.contains(name) && line.ends_with("; the frame is left out"));
        assert!(line.is_some_and(|line| line.starts_with("warning: ")), "{stderr}");
    }
    let (code, _, stderr) = run(&[&["measure"], SATELLITES]);
    assert!(code == 2 && stderr.contains("missing frames"), "{stderr}");
}

/// One of several frames whose pixels, mask or band cannot be used is left out like one that cannot be opened. Alone it
/// is an error.
#[test]
fn frames_that_fail_while_they_are_measured_are_left_out() {
    use std::path::Path;
    use streakcast::images::{Card, CardValue, FrameFile, ImageValues, NewImage, Pixels, Rice, write_frame};
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder);
    let file = FrameFile::open(Path::new(&frame)).unwrap();
    let values: Vec<f32> = file.read_plane(0).unwrap().values().to_vec();
    let values = ImageValues::new(400, Pixels::F32(values.into())).unwrap();
    let bits: Vec<u8> = (0u32..400 * 300).map(|at| u8::from(at.wrapping_mul(2_654_435_761) < 1 << 28)).collect();
    let mask = ImageValues::new(400, Pixels::U8(bits.into())).unwrap();
    // Damages the compressed data of the last image.
    let damaged = |name: &str, mask: Option<&ImageValues<'_>>, filter: &str| {
        let mut cards = file.header(0).unwrap().cards().to_vec();
        cards.retain(|card| card.keyword() != "FILTER");
        cards.extend(Card::with_value("FILTER", &CardValue::Text(filter.into()), ""));
        let rice = Some(Rice::default());
        let mut images = vec![NewImage { name: "SCI", values: &values, cards: &cards, rice }];
        images.extend(mask.map(|values| NewImage { name: "MASK", values, cards: &[], rice }));
        let path = path(&folder, name);
        write_frame(Path::new(&path), &images).unwrap();
        path
    };
    let spoil = |path: &str| {
        let mut bytes = fs::read(path).unwrap();
        let end = bytes.len() - 4000;
        bytes[end - 6000..end].fill(0xff);
        fs::write(path, bytes).unwrap();
    };
    let (pixels, plane) = (damaged("pixels.fits.fz", None, "V"), damaged("plane.fits.fz", Some(&mask), "V"));
    spoil(&pixels);
    spoil(&plane);
    let other_band = damaged("other.fits.fz", None, "Ks");
    let stars = path(&folder, "stars.csv");
    fs::write(&stars, "ra_deg,dec_deg,mag,band\n198.9,7.7,12,V\n").unwrap();
    let missing = path(&folder, "missing.fits");
    let flags = ["--seeing", "90arcsec", "--format", "json"];
    let by_stars = ["--stars", &stars];
    for (bad, words, more) in [
        (&pixels, "CFITSIO: damaged compressed data", &[][..]),
        (&plane, "CFITSIO: damaged compressed data", &[]),
        (&other_band, "is 'Ks'; allowed: V", &by_stars),
    ] {
        let satellites = &SATELLITES[..SATELLITES.len() - 1];
        let measured = |frames: &[&str]| run(&[&["measure"], frames, satellites, &flags, more]);
        let (code, _, stderr) = measured(&[bad]);
        assert!(code == 2 && stderr.contains(words) && !stderr.contains("left out"), "{stderr}");
        let good = damaged("good.fits.fz", None, "V");
        let (code, stdout, stderr) = measured(&[bad, &good, &missing, bad]);
        let document: serde_json::Value = serde_json::from_str(&stdout).unwrap();
        let rows = document["measurements"].as_array().unwrap();
        assert!(code == 0 && !rows.is_empty() && rows.iter().all(|row| row["image"] == good.as_str()), "{stderr}");
        assert_eq!(document["provenance"]["options"]["frames"], serde_json::json!([good]));
        let named = |file: &str| {
            let begin = format!("warning: {file}: ");
            stderr.lines().filter(|line| line.starts_with(&begin) && line.ends_with("; the frame is left out")).count()
        };
        assert_eq!((named(bad), named(&missing), named(&good)), (2, 1, 0), "{stderr}");
        let (code, _, stderr) = measured(&[bad, bad]);
        assert!(code == 2 && stderr.lines().last().unwrap().contains(words), "{stderr}");
    }
    // `mask` writes nothing.
    let polygons = path(&folder, "polygons.json");
    let words = ["mask", &frame, &pixels, "--seeing", "90arcsec", "--polygons", &polygons];
    let (code, _, _) = run(&[&words, SATELLITES]);
    assert!(code == 2 && !Path::new(&polygons).exists());
}

/// A frame below the horizon of the site, or by day, has a wrong start or a wrong site.
#[test]
fn frames_below_the_horizon_and_by_day_have_a_warning() {
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder);
    let polygons = path(&folder, "polygons.json");
    for (start, words) in [
        ("2026-08-14T23:29:05Z", ""),
        ("2026-08-14T10:00:00Z", "the middle of the frame is at an altitude of -"),
        ("2026-08-14T15:00:00Z", "the Sun is at an altitude of "),
    ] {
        for verb in [&["measure"][..], &["mask", "--zero-point", "20", "--polygons", &polygons]] {
            let flags = ["--shells", "starlink-gen1", "--mpc", "X05", "--seeing", "90arcsec", "--start", start];
            let (code, _, stderr) = run(&[verb, &[&frame], &flags]);
            let begin = format!("warning: {frame}: ");
            let line = stderr.lines().find(|line| line.starts_with(&begin) && line.contains("at an altitude of"));
            assert_eq!(line.is_some(), !words.is_empty(), "{verb:?} {start}: {stderr}");
            assert!(code < 2 && line.unwrap_or_default().contains(words), "{verb:?} {start}: {stderr}");
        }
    }
}

/// Without a given site, all frames of a run are at one site. Frames of another one, of no site, and of years without
/// an ephemeris are left out by `measure`, and an error of `mask`.
#[test]
fn frames_of_another_site_or_century_are_named() {
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder);
    let bytes = fs::read(&frame).unwrap();
    let at = |name: &str, latitude_deg: &str, longitude_deg: &str| {
        let file = path(&folder, name);
        let cards = [("OBSGEO-B", latitude_deg), ("OBSGEO-L", longitude_deg), ("OBSGEO-H", "2600.0")];
        fs::write(&file, with_new_cards(&bytes, &cards)).unwrap();
        file
    };
    let chile = at("chile.fits", "-30.2446", "-70.7494");
    let neighbour = at("neighbour.fits", "-30.2500", "-70.7494");
    let hawaii = at("hawaii.fits", "19.8", "-155.5");
    let old = path(&folder, "old.fits");
    let early = with_card(&fs::read(&chile).unwrap(), "DATE-OBS", "'1930-08-14T23:29'");
    fs::write(&old, with_card(&early, "MJD-OBS", "26202.9784722222")).unwrap();
    let satellites = &["--shells", "starlink-gen1"][..];
    let apart = |km: &str| format!(": the site in the header is {km} km from that of ");
    let none = ": the site in the header is missing; allowed: one run for each site, or --site or".to_owned();
    // The start is that of MJD-OBS.
    let years = ": 1930-08-14T23:28:59.999998023 UTC is outside the years of the ephemeris".to_owned();
    for (frames, failed, words) in [
        ([&chile, &hawaii], &hawaii, apart("9433")),
        ([&hawaii, &chile], &chile, apart("9433")),
        ([&chile, &frame], &frame, none.clone()),
        ([&frame, &chile], &frame, none),
        ([&chile, &old], &old, years),
    ] {
        let (output, polygons) = (path(&folder, "out.json"), path(&folder, "polygons.json"));
        let flags = ["--seeing", "90arcsec", "--format", "json", "-o", &output];
        let (code, _, stderr) = run(&[&["measure", frames[0], frames[1]], &flags, satellites]);
        let begin = format!("warning: {failed}{words}");
        let line = stderr.lines().find(|line| line.starts_with(&begin) && line.ends_with("; the frame is left out"));
        // 1: no track is in a frame of the same field from the other site.
        assert!(code < 2 && line.is_some(), "{begin}: {stderr}");
        assert!(!fs::read_to_string(&output).unwrap().contains(&format!("\"image\":\"{failed}")), "{frames:?}");
        let flags = ["--seeing", "90arcsec", "--polygons", &polygons];
        let (code, _, stderr) = run(&[&["mask", frames[0], frames[1]], &flags, satellites]);
        assert!(code == 2 && stderr.starts_with(&format!("error: {failed}{words}")), "{stderr}");
    }
    // 600 m are one site, and a given site is that of all frames.
    for (frames, more) in [([&chile, &neighbour], &[][..]), ([&chile, &hawaii], &["--mpc", "X05"])] {
        let arguments = ["measure", frames[0], frames[1], "--seeing", "90arcsec", "--quiet"];
        let document = json(&[&arguments, satellites, more]);
        let rows = document["measurements"].as_array().unwrap();
        assert!(frames.iter().all(|frame| rows.iter().any(|row| row["image"] == frame.as_str())), "{rows:?}");
    }
}

/// The stated error of a prediction is not limited by the range of delays that is searched. A time in an upload is
/// within the exposure.
#[test]
fn verif_errors_of_old_elements_are_stated() {
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder);
    let elements = published_constellation(&folder, "2026-07-14T00:00:00 UTC");
    let sky = [elements[0].as_str(), &elements[1], "--mpc", "X05", "--quiet"];
    let document = json(&[&["measure", &frame, "--seeing", "90arcsec"], &sky]);
    let rows = document["measurements"].as_array().unwrap();
    let sigmas_s = rows.iter().map(|row| row["late_expected_sigma_s"].as_f64().unwrap());
    let least_s = sigmas_s.fold(f64::INFINITY, f64::min);
    // A search of three sigmas up to 5 s contains errors of 5/3 s.
    assert!(least_s.is_finite() && least_s > 5.0, "{rows:?}");
    // Streaks near unknown positions are not uploaded.
    let upload = done(&[&["measure", &frame, "--seeing", "90arcsec"], SCORE, &sky]);
    assert!(numbers(&records(&upload), "observation_time_uncertainty_sec").is_empty(), "{upload}");
    let elements = published_constellation(&folder, "2026-07-26T00:00:00 UTC");
    let sky = [elements[0].as_str(), &elements[1], "--mpc", "X05", "--quiet"];
    let upload = done(&[&["measure", &frame, "--seeing", "90arcsec"], SCORE, &sky]);
    let uploaded = numbers(&records(&upload), "observation_time_uncertainty_sec");
    assert!(
        !uploaded.is_empty() && uploaded.iter().all(|sigma_s| *sigma_s < 30.0 / 12f64.sqrt() + 1e-4),
        "{uploaded:?}"
    );
}

/// The error of the prediction along the track contains that of the start in the header: 0.29 s for whole seconds.
#[test]
fn verif_the_error_of_the_start_is_that_of_the_prediction() {
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder);
    let bytes = fs::read(&frame).unwrap();
    let expected_s = |name: &str, date: &str| {
        let file = path(&folder, name);
        fs::write(&file, with_new_cards(&bytes, &[("DATE-BEG", date)])).unwrap();
        let document = json(&[&["measure", &file, "--seeing", "90arcsec"], SATELLITES]);
        document["measurements"].as_array().unwrap()[0]["late_expected_sigma_s"].as_f64().unwrap()
    };
    let own_s = expected_s("exact.fits", "'2026-08-14T23:29:05.000'");
    for (name, date, sigma_s) in [
        ("whole.fits", "'2026-08-14T23:29:05'", 12f64.sqrt().recip()),
        ("stated.fits", "'2026-08-14T23:29:05.000' / +/- 2 s", 2.0),
    ] {
        let sigma = expected_s(name, date);
        assert!((sigma - own_s.hypot(sigma_s)).abs() < 1e-3 * sigma, "{date}: {sigma}, without it {own_s}");
    }
}

#[test]
fn verif_saturated_streaks_are_lower_limits_and_magnitudes_without_zero_point_are_instrumental() {
    let folder = TempDir::new().unwrap();
    let description = path(&folder, "sky.toml");
    // The streaks exceed the full well of the pixels, the sky does not.
    let text = SKY
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 24.5")
        .replace("sky_mag_arcsec2 = 21.0", "sky_mag_arcsec2 = 28.0")
        .replace("bias_adu = 300,", "bias_adu = 300, saturation = { full_well_e = 20000 },");
    fs::write(&description, text).unwrap();
    let (frame, truth) = (path(&folder, "bright.fits"), path(&folder, "truth.csv"));
    let shot = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"];
    let seeing = ["--seeing", "90arcsec", "--truth", &truth];
    done(&[&["inject", "--synthetic", &description, "-o", &frame], &shot, &seeing, SATELLITES]);
    let rows_of = |frame: &str| -> Vec<serde_json::Value> {
        let document = json(&[&["measure", frame, "--seeing", "90arcsec"], SATELLITES]);
        document["measurements"].as_array().unwrap().clone()
    };
    let truth = records(&fs::read_to_string(&truth).unwrap());
    let (ids, counts) = (column(&truth, "norad_id"), numbers(&truth, "counts"));
    let mut saturated = 0;
    for row in rows_of(&frame) {
        if !row["flags"].to_string().contains("saturated") {
            continue;
        }
        let truth = ids.iter().position(|id| row["norad_id"].as_u64() == id.parse().ok()).map(|at| counts[at]).unwrap();
        assert!(row["rate"].as_f64().unwrap() * row["duration_s"].as_f64().unwrap() < truth, "{row}");
        saturated += 1;
    }
    assert!(saturated > 0);
    let bare = path(&folder, "bare.fits");
    let mut bytes = fs::read(&frame).unwrap();
    let card = bytes.chunks_exact_mut(80).find(|card| card.starts_with(b"MAGZP   =")).unwrap();
    card[0] = b'X';
    fs::write(&bare, bytes).unwrap();
    let rows = rows_of(&bare);
    assert!(!rows.is_empty() && rows.iter().all(|row| row["calibrated"] == false));
    let (code, _, stderr) = run(&[&["measure", &bare, "--format", "fit"], SATELLITES]);
    assert!(code == 2 && stderr.contains("no zero point"), "{stderr}");
}
