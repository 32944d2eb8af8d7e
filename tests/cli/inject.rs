//! `inject` on the command line: frames, masks, truth tables, errors for invalid input.

use std::fs;
use std::path::Path;

use crate::common::cli::{done, path, records, run};
use crate::common::injected::{RANDOM, SKY, column, numbers, unrounded, values, with_card};
use hifitime::Epoch;
use streakcast::frames::{Direction, Gcrs};
use streakcast::images::FrameFile;
use tempfile::TempDir;

fn synthetic(folder: &TempDir, name: &str, more: &[&str]) -> String {
    let description = path(folder, "sky.toml");
    fs::write(&description, SKY).unwrap();
    let output = path(folder, name);
    done(&[&["inject", "--synthetic", &description, "-o", &output], RANDOM, more]);
    output
}

fn names(file: &str) -> Vec<String> {
    FrameFile::open(Path::new(file)).unwrap().hdus().iter().map(|hdu| hdu.name.clone()).collect()
}

#[test]
fn verif_added_light_equals_the_truth_and_other_data_are_kept() {
    let folder = TempDir::new().unwrap();
    let plain = path(&folder, "plain.fits");
    let description = path(&folder, "sky.toml");
    // Pixels are floating-point numbers, so that nothing is rounded.
    fs::write(&description, SKY.replace(", quantisation = { greatest_adu = 65535 }", "")).unwrap();
    done(&[&["inject", "--synthetic", &description, "-o", &plain, "--pixels-only", "--seed", "1"], RANDOM]);
    let before = fs::read(&plain).unwrap();
    let (output, truth) = (path(&folder, "out.fits"), path(&folder, "truth.csv"));
    done(&[
        &["inject", "--image", &plain, "-o", &output, "--truth", &truth, "--no-noise", "--seed", "5"],
        &RANDOM[..4],
        &["--seeing", "2.5arcsec"],
    ]);
    assert_eq!(fs::read(&plain).unwrap(), before, "the input is not touched");
    assert_eq!(names(&output), ["", "STREAKMASK", "STREAKS", "STREAK_POINTS"]);

    let rows = records(&fs::read_to_string(&truth).unwrap());
    let counts: f64 = numbers(&rows, "counts").iter().sum();
    let (old, new, mask) = (values(&plain, 0), values(&output, 0), values(&output, 1));
    let added: f64 = old.iter().zip(&new).map(|(old, new)| f64::from(new - old)).sum();
    // Rounding to single precision, on a sky of a thousand counts, causes errors of 1e-4 counts per pixel.
    assert!((added - counts).abs() < 1e-4 * counts, "{added} {counts}");
    // In LSST masks, bit 0 is STREAK and bit 1 is INJECTED. Changed pixels are marked, except in the faintest wings.
    // Pixels with STREAK also have INJECTED.
    assert!(mask.iter().all(|&bits| [0.0, 2.0, 3.0].contains(&bits)));
    let unmarked: f64 = old
        .iter()
        .zip(&new)
        .zip(&mask)
        .filter(|(_, mask)| **mask == 0.0)
        .map(|((old, new), _)| f64::from(new - old))
        .sum();
    assert!(unmarked.abs() < 1e-2 * counts, "{unmarked}");
    let stands_out = mask.iter().filter(|&&bits| bits == 3.0).count();
    assert!(stands_out > 300, "{stands_out}");
    // Both streaks end at the edge of the frame, or at the position at which the shutter closed.
    for (x, y) in numbers(&rows, "x1_pix").into_iter().zip(numbers(&rows, "y1_pix")) {
        assert!((0.5..=400.5).contains(&x) && (0.5..=300.5).contains(&y));
    }
}

#[test]
fn verif_the_seed_determines_the_frame() {
    let folder = TempDir::new().unwrap();
    let [a, b, c] = [("a.fits", "7", "1"), ("b.fits", "7", "2"), ("c.fits", "8", "2")].map(|(name, seed, threads)| {
        fs::read(synthetic(&folder, name, &["--seed", seed, "--threads", threads])).unwrap()
    });
    assert!(a == b, "the same at any number of threads");
    assert!(a != c);
}

#[test]
fn verif_many_frames_are_written_to_a_folder_with_individual_streaks() {
    let folder = TempDir::new().unwrap();
    let (description, truth) = (path(&folder, "sky.toml"), path(&folder, "all.csv"));
    fs::write(&description, SKY).unwrap();
    let out = path(&folder, "set");
    fs::create_dir(&out).unwrap();
    done(&[
        &["inject", "--synthetic", &description, "--frames", "3", "-o", &out, "--truth", &truth, "--seed", "3"],
        RANDOM,
    ]);
    let mut found: Vec<String> =
        fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    found.sort();
    assert_eq!(found, ["frame-0001.fits", "frame-0002.fits", "frame-0003.fits"]);
    let rows = records(&fs::read_to_string(&truth).unwrap());
    assert_eq!(column(&rows, "image").iter().filter(|image| *image == "frame-0002.fits").count(), 2);
    let mut lengths = column(&rows, "x1_pix");
    lengths.dedup();
    assert_eq!(lengths.len(), 6, "no two streaks are the same");
    // Each frame of a set is reproduced from the seed in its truth table.
    let alone = path(&folder, "alone.fits");
    let seed = column(&rows, "seed")[2].clone();
    done(&[&["inject", "--synthetic", &description, "-o", &alone, "--seed", &seed], RANDOM]);
    assert_eq!(values(&alone, 0), values(&format!("{out}/frame-0002.fits"), 0));
}

#[test]
fn verif_satellites_of_a_shell_cross_a_wide_frame() {
    let folder = TempDir::new().unwrap();
    let description = path(&folder, "wide.toml");
    fs::write(
        &description,
        SKY.replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
            .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0"),
    )
    .unwrap();
    let (output, truth, trails) = (path(&folder, "wide.fits"), path(&folder, "wide.json"), path(&folder, "trails.csv"));
    let shot = [
        "--start",
        "2026-08-14T23:29:05Z",
        "--exposure",
        "30s",
        "--ra",
        "198.9",
        "--dec",
        "7.7",
        "--seeing",
        "60arcsec",
    ];
    let question = ["--shells", "starlink-gen1", "--mpc", "X05"];
    done(&[
        &["inject", "--synthetic", &description, "-o", &output, "--truth", &truth, "--trails", &trails, "--quiet"],
        &shot,
        &question,
    ]);
    let document: serde_json::Value = serde_json::from_str(&fs::read_to_string(&truth).unwrap()).unwrap();
    let streaks = document["streaks"].as_array().unwrap();
    assert!(!streaks.is_empty());
    assert!(document["provenance"]["models"].to_string().contains("starlink"));
    // Satellites found by `passes` in the circle around the frame, without those that do not touch the frame.
    let passes: serde_json::Value =
        crate::common::cli::json(&[&["passes"], &shot[..8], &["--fov", "4.6deg", "--quiet"], &question]);
    let known: Vec<i64> =
        passes["passes"].as_array().unwrap().iter().map(|pass| pass["norad_id"].as_i64().unwrap()).collect();
    for streak in streaks {
        assert!(known.contains(&streak["norad_id"].as_i64().unwrap()), "{streak}");
        assert!(streak["magnitude"].as_f64().unwrap() < 9.0 && streak["length_pix"].as_f64().unwrap() > 0.0);
    }
    // In the table of trails, mag is per pixel of length; with the length, it gives the total flux of the streak.
    let rows = records(&fs::read_to_string(&trails).unwrap());
    assert_eq!(column(&rows, "source_type")[0], "Trail");
    let (mag, length) = (numbers(&rows, "mag")[0], numbers(&rows, "trail_length")[0]);
    let first = &streaks[0];
    let total = mag - 2.5 * length.log10();
    assert!((total - first["total_magnitude"].as_f64().unwrap()).abs() < 2e-3);
}

/// A satellite enters the umbra inside the frame: its streak in the truth ends there, as its lit part in `passes`. In
/// the geometric shadow the same satellite is lit up to the edge of the frame.
#[test]
fn verif_a_partly_lit_streak_counts_only_its_lit_part() {
    // Tolerance of the end, seconds: the track has a point every tenth of a degree.
    const END_S: f64 = 0.1;
    // Tolerance of the length relative to the arc between both ends: the projection of a frame of 3 deg.
    const LENGTH: f64 = 5e-3;
    let folder = TempDir::new().unwrap();
    let [description, output, truth] = ["wide.toml", "wide.fits", "wide.csv"].map(|name| path(&folder, name));
    let wide = SKY.replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0");
    fs::write(&description, wide.replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0")).unwrap();
    let shot = ["--start", "2024-08-13T23:46:04Z", "--exposure", "14s", "--ra", "287.3", "--dec", "-7.3"];
    let satellites = ["--shells", "starlink-gen1", "--mpc", "X05", "--quiet"];
    const NORAD_ID: i64 = 900_003_099;
    let streak = |shadow: &str| {
        let out = ["inject", "--synthetic", &description, "-o", &output, "--truth", &truth, "--seeing", "60arcsec"];
        done(&[&out, &shot, &satellites, &["--shadow", shadow]]);
        let rows = records(&fs::read_to_string(&truth).unwrap());
        let row = column(&rows, "norad_id").iter().position(|id| *id == NORAD_ID.to_string()).expect("the satellite");
        let number = |name: &str| numbers(&rows, name)[row];
        let end = |ra: &str, dec: &str| {
            Direction::<Gcrs>::from_lon_lat_rad(number(ra).to_radians(), number(dec).to_radians())
        };
        let arc_deg = end("ra1_deg", "dec1_deg").separation_rad(&end("ra2_deg", "dec2_deg")).to_degrees();
        let length_deg = number("length_pix") * 30.0 / 3600.0;
        assert!((length_deg / arc_deg - 1.0).abs() < LENGTH, "{length_deg} {arc_deg}");
        (length_deg, column(&rows, "exit_utc")[row].parse::<Epoch>().unwrap(), number("y2_pix"))
    };
    let (lit_deg, exit, y_end) = streak("atmosphere");
    let (whole_deg, ..) = streak("geometric");
    assert!((0.3..0.7).contains(&(lit_deg / whole_deg)), "{lit_deg} of {whole_deg}");
    assert!((50.0..250.0).contains(&y_end), "{y_end}: the light ends inside the frame");
    let passes = crate::common::cli::json(&[&["passes", "--fov", "5deg"], &shot, &satellites]);
    let passes = passes["passes"].as_array().unwrap();
    let pass = passes.iter().find(|pass| pass["norad_id"] == NORAD_ID).expect("the pass");
    let umbra: Epoch = pass["lit_chords"][0]["exit_utc"].as_str().unwrap().parse().unwrap();
    assert!(umbra < pass["exit_utc"].as_str().unwrap().parse::<Epoch>().unwrap());
    assert!((exit - umbra).to_seconds().abs() < END_S, "{exit} {umbra}");
}

/// Creates a wide synthetic frame, exposed for 4 s while the first satellite of the evening crosses it.
fn wide(folder: &TempDir, more: &[&str]) -> Vec<csv::StringRecord> {
    let pointing = ["--shells", "starlink-gen1", "--mpc", "X05", "--ra", "198.9", "--dec", "7.7"];
    let evening = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--fov", "2deg", "--quiet"];
    let passes = crate::common::cli::json(&[&["passes"], &pointing, &evening]);
    let middle: hifitime::Epoch = passes["passes"][0]["mid_utc"].as_str().unwrap().parse().unwrap();
    let start = streakcast::output::format_utc(middle - hifitime::Unit::Second * 2.0, 3);
    let (description, output, truth) = (path(folder, "wide.toml"), path(folder, "wide.fits"), path(folder, "wide.csv"));
    let text = SKY
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 20.0");
    fs::write(&description, text).unwrap();
    let question = [&pointing[..], &["--start", &start, "--exposure", "4s"]].concat();
    done(&[
        &["inject", "--synthetic", &description, "-o", &output, "--truth", &truth, "--seeing", "60arcsec", "--quiet"],
        &question,
        more,
    ]);
    records(&fs::read_to_string(&truth).unwrap())
}

#[test]
fn verif_a_tracked_satellite_is_a_point_with_its_total_light() {
    let folder = TempDir::new().unwrap();
    let rows = wide(&folder, &[]);
    let brightest = numbers(&rows, "magnitude")
        .iter()
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(b.1))
        .map(|(index, _)| index)
        .unwrap();
    let [norad, length] = ["norad_id", "length_pix"].map(|name| column(&rows, name)[brightest].clone());
    let [rate, angle, magnitude, zero_point] =
        ["angular_rate_deg_s", "position_angle_deg", "magnitude", "zero_point_mag"]
            .map(|name| numbers(&rows, name)[brightest]);
    assert!(length.parse::<f64>().unwrap() > 20.0, "{length}");
    let (sin, cos) = angle.to_radians().sin_cos();
    let follow = format!("--track-rate={},{}", 3600.0 * rate * sin, 3600.0 * rate * cos);
    let followed = wide(&folder, &[&follow]);
    let index =
        column(&followed, "norad_id").iter().position(|id| *id == norad).expect("the satellite is in the frame");
    // The satellite follows its orbit, and the telescope a great circle at the mean rate. In 4 s the difference is a
    // few pixels of 30".
    assert!(numbers(&followed, "length_pix")[index] < 6.0);
    // All light of the 4 s is in one point: 10^(-0.4 (m - ZP)) with m at mid-exposure, which changes by a few
    // hundredths in 4 s.
    let expected = 10f64.powf(-0.4 * (magnitude - zero_point));
    let counts = numbers(&followed, "counts")[index];
    assert!((counts / expected - 1.0).abs() < 0.05, "{counts} {expected}");
    // For a point the effective magnitude is the magnitude; a streak has a lower surface brightness.
    let effective = |rows: &[csv::StringRecord], index: usize| numbers(rows, "effective_magnitude")[index];
    assert!(
        (effective(&followed, index) - magnitude).abs() < 1.5
            && effective(&rows, brightest) > effective(&followed, index) + 1.0
    );
}

#[test]
fn verif_stars_trail_with_non_sidereal_tracking() {
    let folder = TempDir::new().unwrap();
    let [description, list] = ["sky.toml", "stars.csv"].map(|name| path(&folder, name));
    // The frame has one star in its centre and no noise.
    let sky = "columns = 400\nrows = 300\npixel_scale_arcsec = 0.5\nzero_point_1s_mag = 25.0\nsky_mag_arcsec2 = 40\n\
        star_list = 'stars.csv'\ndetector = { shot_noise = false }\n";
    fs::write(&description, sky).unwrap();
    fs::write(&list, "ra_deg,dec_deg,magnitude\n40,10,12\n").unwrap();
    let take = |name: &str, more: &[&str]| {
        let output = path(&folder, name);
        let centre = ["--ra", "40", "--dec", "10", "--random-streaks", "0", "--magnitude", "5", "--pixels-only"];
        let shot = ["--exposure", "30s", "--seeing", "2arcsec", "--psf", "gaussian", "--quiet", "--seed", "2"];
        done(&[&["inject", "--synthetic", &description, "-o", &output], &centre, &shot, more]);
        values(&output, 0)
    };
    let moments = |pixels: &[f32]| {
        let mut sums = [0.0f64; 6];
        for (pixel, light) in pixels.iter().enumerate() {
            let (x, y) = ((pixel % 400) as f64 - 199.5, (pixel / 400) as f64 - 149.5);
            let terms = [1.0, x, y, x * x, y * y, x * y];
            terms.iter().zip(&mut sums).for_each(|(term, sum)| *sum += f64::from(*light) * term);
        }
        sums
    };
    let (still, trailed) =
        (moments(&take("still.fits", &[])), moments(&take("trailed.fits", &["--track-rate", "2,1"])));
    // The rates are 2"/s east and 1"/s north for 30 s: 120 and 60 pixels. A uniform line of length L has the variance
    // L²/12.
    assert!((trailed[0] / still[0] - 1.0).abs() < 1e-3, "{} {}", trailed[0], still[0]);
    let mean = |sums: &[f64; 6], index: usize| sums[index] / sums[0];
    assert!((mean(&trailed, 1) - mean(&still, 1)).abs() < 0.05 && (mean(&trailed, 2) - mean(&still, 2)).abs() < 0.05);
    for (index, expected) in [(3, 120.0f64 * 120.0 / 12.0), (4, 60.0 * 60.0 / 12.0)] {
        let wider = mean(&trailed, index) - mean(&still, index);
        assert!((wider / expected - 1.0).abs() < 0.01, "{index}: {wider} {expected}");
    }
    assert!((mean(&trailed, 5).abs() / 600.0 - 1.0).abs() < 0.01, "{}", mean(&trailed, 5));

    // With tracking of a satellite, the number of random stars is the same.
    let field = "stars = { per_megapixel = 1000, slope = 0.6, brightest_mag = 14, faintest_mag = 16 }";
    fs::write(&description, sky.replace("star_list = 'stars.csv'", field)).unwrap();
    let total = |pixels: Vec<f32>| pixels.iter().map(|pixel| f64::from(*pixel)).sum::<f64>();
    let still = total(take("field.fits", &[]));
    for rate in ["--track-rate=0,0", "--track-rate=2,1", "--track-rate=-300,180"] {
        let trailed = total(take("trails.fits", &[rate]));
        assert!((trailed / still - 1.0).abs() < 0.4, "{rate}: {trailed} {still}");
    }

    // Too many trails are rejected, and so is a star on the frame that is too bright.
    let refused = |more: &[&str]| {
        let output = path(&folder, "none.fits");
        let centre = ["--ra", "40", "--dec", "10", "--random-streaks", "0", "--magnitude", "5", "--exposure", "30s"];
        let (code, _, stderr) =
            run(&[&["inject", "--synthetic", &description, "-o", &output, "--seeing", "2arcsec"], &centre, more]);
        assert!(code == 2 && !Path::new(&output).exists(), "{stderr}");
        stderr
    };
    assert!(refused(&["--track-rate=1e7,0"]).contains("stars that trail over the frame is"));
    fs::write(&description, sky).unwrap();
    fs::write(&list, "ra_deg,dec_deg,magnitude\n40,10,12\n220,-10,-26\n").unwrap();
    for more in [&[][..], &["--track-rate=2,1"]] {
        assert!((total(take("two.fits", more)) / moments(&take("still.fits", &[]))[0] - 1.0).abs() < 1e-3);
    }
    fs::write(&list, "ra_deg,dec_deg,magnitude\n40,10,-10\n").unwrap();
    for more in [&[][..], &["--track-rate=2,1"]] {
        assert!(refused(more).contains("flux_e is"), "{more:?}");
    }
}

#[test]
fn verif_the_middle_point_and_a_flash_in_the_light_curve() {
    let folder = TempDir::new().unwrap();
    let plain = synthetic(&folder, "plain.fits", &["--pixels-only"]);
    let (output, truth) = (path(&folder, "out.fits"), path(&folder, "truth.csv"));
    let one = [
        "--random-streaks",
        "1",
        "--magnitude",
        "9",
        "--streak-rate-deg-s",
        "0.01",
        "--seeing",
        "2.5arcsec",
        "--quiet",
        "--seed",
        "2",
    ];
    let inject_with = |more: &[&str]| {
        done(&[&["inject", "--image", &plain, "-o", &output, "--truth", &truth], &one, more]);
        records(&fs::read_to_string(&truth).unwrap())
    };
    let [two, eleven] = ["2", "11"].map(|points| inject_with(&["--truth-points", points]));
    assert_eq!(column(&two, "magnitude"), column(&eleven, "magnitude"));
    assert!(
        (numbers(&two, "surface_brightness_mag_arcsec2")[0] - numbers(&eleven, "surface_brightness_mag_arcsec2")[0])
            .abs()
            < 2e-3
    );
    let flash = inject_with(&["--glint", "5,0,0.1"]);
    // A flash of magnitude 5 is added to light of magnitude 9: the peak is 4.97. Its fluence in 30 s is 0.1 s × 1.064.
    assert!((numbers(&flash, "magnitude_peak")[0] - 4.97).abs() < 0.03, "{:?}", column(&flash, "magnitude_peak"));
    let gained = numbers(&flash, "counts")[0] - numbers(&eleven, "counts")[0];
    let expected = 10f64.powf(-0.4 * (5.0 - numbers(&flash, "zero_point_mag")[0])) * 0.106_447 / 30.0;
    assert!((gained / expected - 1.0).abs() < 0.01, "{gained} {expected}");
}

#[test]
fn verif_faint_light_is_not_rounded_away() {
    let folder = TempDir::new().unwrap();
    // Pixels are 16-bit integers; the peak of the streak is below one count.
    let plain = synthetic(&folder, "plain.fits", &["--pixels-only", "--seed", "1"]);
    let (output, truth) = (path(&folder, "out.fits"), path(&folder, "truth.csv"));
    for (more, noise) in [(&["--no-noise"][..], 0.0), (&["--gain", "8"], 1.0 / 8.0)] {
        let (mut added, mut expected_counts, mut pixels) = (0.0, 0.0, 0.0);
        for seed in ["3", "4", "5", "6"] {
            let streak = [
                "--random-streaks",
                "1",
                "--magnitude",
                "12.5",
                "--streak-rate-deg-s",
                "0.5",
                "--seeing",
                "4arcsec",
                "--quiet",
                "--seed",
                seed,
            ];
            done(&[&["inject", "--image", &plain, "-o", &output, "--truth", &truth], &streak, more]);
            let (old, new) = (values(&plain, 0), values(&output, 0));
            added += old.iter().zip(&new).map(|(old, new)| f64::from(new - old)).sum::<f64>();
            pixels += old.iter().zip(&new).filter(|(old, new)| old != new).count() as f64;
            expected_counts += numbers(&records(&fs::read_to_string(&truth).unwrap()), "counts").iter().sum::<f64>();
        }
        // A pixel with x counts is rounded to 1 with probability x. The variance is below 1/4 count², plus photon
        // noise. The tolerance is five sigma.
        let sigma = (4.0 * 0.25 * 400.0 * 40.0 + noise * expected_counts).sqrt();
        assert!(
            (added - expected_counts).abs() < 5.0 * sigma && pixels > 500.0,
            "{added} {expected_counts} ± {sigma}, {pixels} pixels"
        );
        assert!(expected_counts > 10.0 * sigma, "the test can fail: {expected_counts} {sigma}");
    }
}

#[test]
fn verif_light_is_rounded_by_another_pattern_in_each_frame() {
    let folder = TempDir::new().unwrap();
    // Pixels are 16-bit integers; the peak of the streak is below one count.
    let plain = synthetic(&folder, "plain.fits", &["--pixels-only", "--seed", "1"]);
    let output = path(&folder, "out.fits");
    let rounded = |start: &str| {
        let streak = ["--random-streaks", "1", "--magnitude", "12.5", "--streak-rate-deg-s", "0.5"];
        let more = ["--seeing", "4arcsec", "--no-noise", "--seed", "3", "--start", start, "--quiet"];
        done(&[&["inject", "--image", &plain, "-o", &output], &streak, &more]);
        values(&output, 0)
    };
    let [first, same, later] = ["2026-08-14T23:29:05Z", "2026-08-14T23:29:05Z", "2026-08-14T23:30:05Z"].map(rounded);
    assert_eq!(first, same);
    assert_ne!(first, later);
}

#[test]
fn verif_resolved_panels_are_two_light_sources() {
    let folder = TempDir::new().unwrap();
    let rows = wide(&folder, &[]);
    // Small frame with small pixels at the position of a satellite, exposed for 4 s.
    let entered: hifitime::Epoch = column(&rows, "enter_utc")[0].parse().unwrap();
    let start = streakcast::output::format_utc(entered - hifitime::Unit::Second * 2.0, 3);
    let [ra, dec, norad] = ["ra1_deg", "dec1_deg", "norad_id"].map(|name| column(&rows, name)[0].clone());
    let description = path(&folder, "small.toml");
    fs::write(&description, unrounded().replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 0.4")).unwrap();
    let inject_with = |name: &str, more: &[&str]| {
        let (output, truth) = (path(&folder, name), path(&folder, "small.csv"));
        let frame = ["--synthetic", &description, "-o", &output, "--truth", &truth, "--quiet", "--no-noise"];
        // The default model of these satellites does not separate chassis and solar array.
        let panels = ["--model", "starlink-v1.5=starlink-v1.5"];
        let shot = ["--shells", "starlink-gen1", "--mpc", "X05", "--start", &start, "--exposure", "4s", "--ra", &ra];
        done(&[
            &["inject"],
            &frame,
            &shot,
            &panels,
            &[&format!("--dec={dec}"), "--seeing", "0.8arcsec"],
            more,
            &["--labels", "coco"],
        ]);
        (records(&fs::read_to_string(&truth).unwrap()), values(&output, 0))
    };
    let (whole, whole_values) = inject_with("whole.fits", &[]);
    let (apart, apart_values) = inject_with("apart.fits", &["--resolve-panels"]);
    let of_satellite = |rows: &[csv::StringRecord]| -> Vec<(String, f64)> {
        let ids = column(rows, "norad_id");
        let parts = column(rows, "part").into_iter().zip(numbers(rows, "counts"));
        parts.zip(ids).filter(|(_, id)| *id == norad).map(|(part, _)| part).collect()
    };
    let (whole, apart) = (of_satellite(&whole), of_satellite(&apart));
    let labels = |parts: &[(String, f64)]| parts.iter().map(|(label, _)| label.clone()).collect::<Vec<_>>();
    assert_eq!(labels(&whole), ["whole"]);
    assert_eq!(labels(&apart), ["chassis", "array"]);
    // They are one label.
    let annotations = |name: &str| -> Vec<String> {
        let text = fs::read_to_string(path(&folder, name)).unwrap();
        let coco: serde_json::Value = serde_json::from_str(&text).unwrap();
        coco["annotations"].as_array().unwrap().iter().map(|one| one["streak"].to_string()).collect()
    };
    let names = annotations("whole.coco.json");
    assert!(!names.is_empty() && annotations("apart.coco.json") == names, "{names:?}");
    // The total is the same, except that at a corner of the frame one path is a few pixels longer.
    let together: f64 = apart.iter().map(|(_, counts)| counts).sum();
    assert!((together / whole[0].1 - 1.0).abs() < 0.05, "{together} {}", whole[0].1);
    // The distribution of the light differs.
    let moved: f64 = whole_values.iter().zip(&apart_values).map(|(a, b)| f64::from((a - b).abs())).sum();
    assert!(moved > 0.05 * together, "{moved} {together}");
}

#[test]
fn verif_a_satellite_at_the_edge_of_a_chip_adds_only_the_light_inside() {
    let folder = TempDir::new().unwrap();
    let truth_of_wide = wide(&folder, &["--no-noise"]);
    let (x1, x2) = (numbers(&truth_of_wide, "x1_pix")[0], numbers(&truth_of_wide, "x2_pix")[0]);
    let (y1, y2) = (numbers(&truth_of_wide, "y1_pix")[0], numbers(&truth_of_wide, "y2_pix")[0]);
    assert!((y2 - y1).abs() > 4.0 && (x2 - x1).abs() >= 0.0, "{y1} {y2}");
    // The frame without the rows above the middle of the streak, so that the track leaves it there.
    let whole = path(&folder, "plain.fits");
    let description = path(&folder, "plain.toml");
    let text = unrounded()
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 20.0");
    fs::write(&description, text).unwrap();
    let pointing = ["--ra", "198.9", "--dec", "7.7"];
    let begun = fs::read(path(&folder, "wide.fits")).unwrap();
    let date = begun.chunks_exact(80).find(|card| card.starts_with(b"DATE-OBS")).expect("DATE-OBS");
    let date = String::from_utf8_lossy(date).split('\'').nth(1).unwrap().trim().to_owned() + "Z";
    let shot = ["--start", &date, "--exposure", "4s", "--seeing", "60arcsec", "--quiet"];
    let random = ["--random-streaks", "0", "--magnitude", "5", "--pixels-only"];
    done(&[&["inject", "--synthetic", &description, "-o", &whole], &pointing, &shot, &random]);
    let bytes = fs::read(&whole).unwrap();
    let rows_kept = (0.5 * (y1 + y2)).floor() as usize;
    let header = 2880 * (bytes.chunks_exact(80).position(|card| card.starts_with(b"END ")).unwrap() / 36 + 1);
    let size = (bytes.len() - header) / (400 * 300);
    let mut cut = with_card(&bytes, "NAXIS2", &rows_kept.to_string());
    cut.truncate(header + rows_kept * 400 * size);
    cut.resize(cut.len().div_ceil(2880) * 2880, 0);
    let part = path(&folder, "part.fits");
    fs::write(&part, &cut).unwrap();
    let added = |input: &str| {
        let (output, truth) = (path(&folder, "edge.fits"), path(&folder, "edge.csv"));
        let from =
            ["--image", input, "-o", &output, "--truth", &truth, "--no-noise", "--seeing", "60arcsec", "--quiet"];
        done(&[&["inject"], &from, &["--shells", "starlink-gen1", "--mpc", "X05"]]);
        let (old, new) = (values(input, 0), values(&output, 0));
        let light: Vec<f32> = old.iter().zip(&new).map(|(old, new)| new - old).collect();
        (light, records(&fs::read_to_string(&truth).unwrap()))
    };
    let ((all, _), (kept, truth)) = (added(&whole), added(&part));
    // The light in all remaining pixels is identical, up to the last row, and the track ends at the edge.
    let peak = all.iter().copied().fold(0.0_f32, f32::max);
    let worst = all.iter().zip(&kept).map(|(a, b)| (a - b).abs()).fold(0.0_f32, f32::max);
    assert_eq!(kept.len(), 400 * rows_kept);
    assert!(peak > 10.0 && worst < 2e-3 * peak, "{worst} {peak}");
    assert!(kept[400 * (rows_kept - 1)..].iter().any(|light| *light > 0.1 * peak));
    let edge = rows_kept as f64 + 0.5;
    let ends = [numbers(&truth, "y1_pix"), numbers(&truth, "y2_pix")].concat();
    assert!(ends.iter().any(|y| (y - edge).abs() < 0.01), "{ends:?} {edge}");
}

#[test]
fn verif_names_with_brackets_and_undefined_pixels() {
    let folder = TempDir::new().unwrap();
    let (description, plain) = (path(&folder, "sky.toml"), path(&folder, "plain.fits"));
    fs::write(&description, unrounded()).unwrap();
    done(&[&["inject", "--synthetic", &description, "-o", &plain, "--pixels-only"], RANDOM]);
    // Every seventh pixel has no value.
    let mut bytes = fs::read(&plain).unwrap();
    let header = 2880 * (bytes.chunks_exact(80).position(|card| card.starts_with(b"END ")).unwrap() / 36 + 1);
    for pixel in (0..400 * 300).step_by(7) {
        let at = header + 4 * pixel;
        bytes[at..at + 4].copy_from_slice(&f32::NAN.to_be_bytes());
    }
    // CFITSIO would interpret such names as sections, filters and compression.
    let input = path(&folder, "night[1:100,*](2)+1.fits");
    let output = path(&folder, "out[compress R][0].fits");
    fs::write(&input, &bytes).unwrap();
    let options = ["--random-streaks", "2", "--magnitude", "5", "--seeing", "2.5arcsec", "--gain", "2", "--quiet"];
    done(&[&["inject", "--image", &input, "-o", &output], &options]);
    assert_eq!(fs::read(&input).unwrap(), bytes);
    let (old, new) = (values(&input, 0), values(&output, 0));
    assert!(old.iter().zip(&new).all(|(old, new)| old.is_nan() == new.is_nan()));
    let changed = old.iter().zip(&new).filter(|(old, new)| !old.is_nan() && old != new).count();
    assert!(changed > 1000, "{changed}");
}

/// Full disk, simulated by a limit on file sizes whose signal is ignored; and folders in which files cannot be created.
#[cfg(target_os = "linux")]
#[test]
fn verif_a_full_disk_and_missing_permissions_leave_no_output() {
    let folder = TempDir::new().unwrap();
    let plain = synthetic(&folder, "plain.fits", &["--pixels-only"]);
    let (before, output) = (fs::read(&plain).unwrap(), path(&folder, "out.fits"));
    fs::write(&output, "an older file").unwrap();
    let options = ["--random-streaks", "1", "--magnitude", "5", "--seeing", "2arcsec", "--quiet"];
    // The limit is 100 blocks of 512 (or 1024) bytes; the frame has 240,000 bytes.
    let script = "trap '' XFSZ; ulimit -f 100; exec \"$0\" \"$@\"";
    let full = std::process::Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_streakcast"), "inject", "--image", &plain, "-o", &output])
        .args(options)
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&full.stderr).into_owned();
    assert!(!full.status.success() && full.status.code() == Some(2), "{:?} {stderr}", full.status);
    assert!(
        stderr.lines().count() == 1 && stderr.contains("out.fits") && stderr.contains("the disk may be full"),
        "{stderr}"
    );
    assert_eq!(fs::read_to_string(&output).unwrap(), "an older file", "the old file is kept");
    // Permissions have no effect for root, but files cannot be created in /proc.
    let (code, stdout, stderr) = run(&[&["inject", "--image", &plain, "-o", "/proc/out.fits"], &options]);
    assert_eq!((code, stdout.as_str(), stderr.lines().count()), (2, "", 1), "{stderr}");
    assert!(stderr.contains("/proc"), "{stderr}");
    assert_eq!(fs::read(&plain).unwrap(), before);
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().ends_with(".part")), "{left:?}");
}

#[test]
fn verif_invalid_input_gives_one_line_and_no_output() {
    let folder = TempDir::new().unwrap();
    let plain = synthetic(&folder, "plain.fits", &["--pixels-only"]);
    let output = path(&folder, "out.fits");
    let cut = path(&folder, "cut.fits");
    let bytes = fs::read(&plain).unwrap();
    fs::write(&cut, &bytes[..bytes.len() - 5000]).unwrap();
    let [cube, broad, negative, dark] = [("NAXIS", "3"), ("NAXIS1", "4000"), ("NAXIS2", "-300"), ("EXPTIME", "0.0")]
        .map(|(keyword, value)| {
            let file = path(&folder, &format!("{keyword}{value}.fits"));
            fs::write(&file, with_card(&bytes, keyword, value)).unwrap();
            file
        });
    let unsolved = path(&folder, "unsolved.fits");
    let mut cards = bytes.clone();
    let ctypes = cards.chunks_exact_mut(80).filter(|card| card.starts_with(b"CTYPE"));
    ctypes.for_each(|card| card[0] = b'X');
    fs::write(&unsolved, cards).unwrap();
    let text = path(&folder, "text.fits");
    fs::write(&text, "no FITS at all").unwrap();
    let plain_csv = path(&folder, "curve.csv");
    fs::write(&plain_csv, "time_s,delta_mag\n0,0\n1,1\n").unwrap();
    let image = |file: &str| vec!["inject".to_owned(), "--image".to_owned(), file.to_owned()];
    let random = &RANDOM[..4];
    let seeing = &["--seeing", "2arcsec"][..];
    for (file, output, more, words) in [
        (&cut, &output, [random, seeing].concat(), &["cut.fits", "HDU 0", "truncated"][..]),
        (&cube, &output, [random, seeing].concat(), &["NAXIS3.fits", "HDU 0", "NAXIS3"]),
        (&broad, &output, [random, seeing].concat(), &["NAXIS14000.fits", "HDU 0", "truncated"]),
        (&negative, &output, [random, seeing].concat(), &["NAXIS2-300.fits", "NAXIS2 is -300"]),
        (&dark, &output, [random, seeing].concat(), &["EXPTIME0.0.fits", "EXPTIME"]),
        (
            &unsolved,
            &output,
            [random, seeing].concat(),
            &[
                "unsolved.fits: HDU 0: no celestial coordinates: CTYPE1 is \"\"",
                "or --pixel-scale ANGLE with random streaks",
            ],
        ),
        (&text, &output, [random, seeing].concat(), &["text.fits", "not a FITS file"]),
        (&path(&folder, "none.fits"), &output, [random, seeing].concat(), &["none.fits"]),
        (&plain, &plain, [random, seeing].concat(), &["plain.fits", "input"]),
        (&plain, &output, random.to_vec(), &["--seeing", "--telescope"]),
        (&plain, &output, [random, seeing, &["--psf", "moffat:1"]].concat(), &["moffat:1", "2 to 100"]),
        (&plain, &output, [random, seeing, &["--hdu", "4"]].concat(), &["HDU 4 is missing", "0 to 0"]),
        (&plain, &output, [random, seeing, &["--glint", "3,0"]].concat(), &["--glint", "3 numbers"]),
        (&plain, &output, [random, seeing, &["--tumbling", "0,1"]].concat(), &["period", "0.02 to 1e5"]),
        (&plain, &output, [random, seeing, &["--exposure", "0s"]].concat(), &["exposure", "above 0"]),
        (&plain, &output, [random, seeing, &["--mask-bits", "sdss"]].concat(), &["sdss", "lsst, desdm"]),
        (&plain, &output, [random, seeing, &["--truth", "t.parquet"]].concat(), &["t.parquet", ".csv"]),
        (&plain, &output, [random, seeing, &["--gain=-1"]].concat(), &["gain is -1", "above 0"]),
        (&plain, &output, [&["--random-streaks", "1", "--magnitude", "9,3"], seeing].concat(), &["brighter first"]),
        (&plain, &output, seeing.to_vec(), &["--elements", "--shells", "--random-streaks"]),
        (&plain, &output, [&["--shells", "oneweb"], seeing].concat(), &["site", "--mpc"]),
        (&plain, &output, [&["--magnitude", "5"], seeing].concat(), &["--random-streaks"]),
        (&plain, &output, [random, seeing, &["--fov", "1deg"]].concat(), &["--fov", "the frame is the field"]),
        (&plain, &output, [random, seeing, &["--frames", "2"]].concat(), &["--frames", "--synthetic"]),
        (&plain, &output, [random, seeing, &["--truth-points", "100000000"]].concat(), &["truth-points", "2 to 10000"]),
        (
            &plain,
            &output,
            [random, seeing, &["--truth", &plain_csv, "--light-curve", &plain_csv]].concat(),
            &["also an input", "allowed: another file"],
        ),
    ] {
        let command: Vec<String> = image(file);
        let command: Vec<&str> = command.iter().map(String::as_str).collect();
        let (code, stdout, stderr) = run(&[&command, &["-o", output], &more]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
        assert!(words.iter().all(|word| stderr.contains(word)), "{stderr} lacks one of {words:?}");
    }
    assert!(!Path::new(&output).exists());
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().ends_with(".part")), "{left:?}");
    assert_eq!(fs::read(&plain).unwrap(), bytes);
}

/// The folder of the output is created. `identify` does not take the mask of the written frame as an image.
#[test]
fn verif_an_injected_frame_in_a_new_folder_is_one_image() {
    let folder = TempDir::new().unwrap();
    let plain = synthetic(&folder, "plain.fits", &["--pixels-only"]);
    let output = path(&folder, "new/deep/out.fits");
    let (code, _, stderr) = run(&[&["inject", "--image", &plain, "-o", &output, "--seeing", "2arcsec"], &RANDOM[..4]]);
    assert_eq!(code, 0, "{stderr}");
    let streak = ["--image", &output, "--from-pix", "10,10", "--to-pix", "90,90"];
    let (code, _, stderr) = run(&[&["identify", "--shells", "oneweb", "--mpc", "327", "-q"], &streak]);
    assert!(code < 2, "{stderr}");
}
