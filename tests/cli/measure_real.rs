//! `measure` on real frames: streaks of known satellites, and frames that lack what a measurement needs.
//!
//! Requires the data folder; skipped with a message without it. Bounds were set before the results were known, except
//! where a comment states otherwise.

use std::path::Path;

use serde_json::Value;

use crate::common::cli::{json, run};

/// Measurements of a frame with the element sets of a file.
fn measured(data: &Path, frame: &str, elements: &str, more: &[&str]) -> Vec<Value> {
    let path = |name: &str| data.join(name).display().to_string();
    let (frame, elements) = (path(frame), path(elements));
    let document = json(&[&["measure", &frame, "--elements", &elements, "--quiet"], more]);
    document["measurements"].as_array().unwrap().clone()
}

/// Starlink-1102 in the exposure 941420 of the Dark Energy Camera.
///
/// The zero point is that of chip S12 in the same exposure, processed by Rubin's pipeline (PhotoCalib: 2.646 nJy a
/// count); the sky of the two chips differs by less than 0.2 mag. Published: the satellites of this launch have about 5
/// mag in g (Tyson et al. 2020, section 6; Rawls 2020, zenodo 3937869).
///
/// The sum of the pixels within 20, 25 or 30 pixels of the streak, minus the median of the next 25 pixels of the same
/// column, by hand, is 7,284 to 7,359 counts for each pixel of length: with 10,060 pixels a second 5.47 to 5.48 mag. A
/// third of the track in the cutout is on the bright edge and the overscan of the chip, whose blocks have small
/// weights. The measurement has the flags `edge` and `pixel_noise`.
#[test]
fn valid_starlink_1102_is_measured_where_it_was_seen() {
    const FRAME: &str = "frames/trailblazer/cutout_c4d_200306_000415_ori.fits.fz";
    /// Distance of the streak from the track, by hand (tests/images/streak_real.rs), and its error, arcsec.
    const BESIDE_ARCSEC: f64 = 27.4;
    const BESIDE_ERROR_ARCSEC: f64 = 0.6;
    const SUM_MAG: f64 = 5.48;
    /// The bound was set before the first measurement.
    const MARGIN_MAG: f64 = 0.2;
    let Some(data) = crate::common::data_dir() else { return };
    let options = ["--zero-point", "30.343", "--gain", "4.0"];
    let rows = measured(&data, FRAME, "tle/supgp/starlink_supgp_2020-02-23.tle", &options);
    assert_eq!(rows.len(), 1, "only one of 70 cutouts has a predicted track");
    let row = &rows[0];
    let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name}: {row}"));
    println!("{row}");
    assert!(row["detected"] == true && row["norad_id"] == 44920, "{row}");
    assert!((number("offset_arcsec").abs() - BESIDE_ARCSEC).abs() <= BESIDE_ERROR_ARCSEC, "{row}");
    assert!((number("magnitude") - SUM_MAG).abs() <= MARGIN_MAG, "{row}");
    assert!(["edge", "pixel_noise"].iter().all(|flag| row["flags"].to_string().contains(flag)), "{row}");
    // The result depends on the given seeing. These checks were written after the first run (5.68 mag, and not found).
    // They are not requirements, but check the statements in docs/explanation/measuring.md.
    let with_seeing = |seeing: &str| {
        let options = [&options[..], &["--seeing", seeing]].concat();
        measured(&data, FRAME, "tle/supgp/starlink_supgp_2020-02-23.tle", &options).remove(0)
    };
    let (narrow, wide) = (with_seeing("1.1arcsec"), with_seeing("2arcsec"));
    assert!(narrow["magnitude"].as_f64().unwrap() > SUM_MAG + 0.15, "{narrow}");
    assert!(wide["detected"] == false, "{wide}");
    // Elements of a manoeuvre, 9.5 days old, are wrong by 27 arcmin: the streak is outside the corridor.
    let rows = measured(&data, FRAME, "tle/supgp/starlink_supgp_2020-02-25.tle", &options);
    assert!(rows.iter().all(|row| row["detected"] == false), "{rows:?}");
}

/// A wide streak in a frame of Hyper Suprime-Cam, which `identify` assigns to FUSE (25791) with a probability of 0.9999
/// from its ends, at a distance of 127.2 arcsec from the track of elements that are 10.9 days old. The sum of the
/// pixels within 45 pixels of the streak, by hand, is 44,700 counts for each pixel of length, and 2.5e8 counts a
/// second.
#[test]
fn valid_a_wide_streak_of_hyper_suprime_cam_is_found() {
    const BESIDE_ARCSEC: f64 = 127.2;
    /// Ends measured by eye are good to some pixels of 0.17 arcsec.
    const BESIDE_ERROR_ARCSEC: f64 = 3.0;
    const SUM_COUNTS_S: f64 = 2.47e8;
    const SUM_ERROR: f64 = 0.2;
    let Some(data) = crate::common::data_dir() else { return };
    // The streak is wider than the template, and with some predicted tracks its middle is masked as a star
    // (docs/explanation/measuring.md). This position of the observatory gives one of the others.
    let site = ["--lat", "19.8255", "--lon", "-155.4765", "--height", "4163"];
    let options = [&["--accept-bad-checksums", "--gain", "3.2"][..], &site].concat();
    let frame = "frames/trailblazer/cutout_HSCA21787010.fits";
    let rows = measured(&data, frame, "tle/fullcat/tle_2020-05-17.txt", &options);
    println!("{rows:?}");
    let row = rows.iter().find(|row| row["norad_id"] == 25791).expect("a predicted track of FUSE");
    let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name}: {row}"));
    assert!(row["detected"] == true, "{row}");
    assert!((number("offset_arcsec").abs() - BESIDE_ARCSEC).abs() <= BESIDE_ERROR_ARCSEC, "{row}");
    assert!((number("rate") / SUM_COUNTS_S - 1.0).abs() <= SUM_ERROR, "{row}");
    assert!(!row["flags"].to_string().contains("masked"), "{row}");
}

/// The other frames lack what a measurement needs, which the message names.
#[test]
fn valid_frames_without_coordinates_time_or_site_are_named() {
    let Some(data) = crate::common::data_dir() else { return };
    let elements = data.join("tle/mmt_2021/starlink_2021-01-07.txt").display().to_string();
    for (frame, part) in [
        ("trailblazer/cutout_A3671-C2018_F4-R-3.fit", "CTYPE1 is"),
        ("trailblazer/cutout_GMOSN.i.2021-01-17T14_35_11.5_2PAC.fits", "69.7 s apart"),
        ("trailblazer/cutout_LMI.VR.2021-06-01T04_06_03.67_1PA.fits", "missing site"),
        ("trailblazer/cutout_frame-i-008108-5-0025.fits", "missing site"),
        // The time scale of the header is wrong.
        ("trailblazer/cutout_calexp-0941420_23.fits", "in another time scale than TIMESYS"),
        ("astride/long.fits", "-0.4 s from DATE-OBS + TIME-OBS to JD"),
    ] {
        let path = data.join("frames").join(frame).display().to_string();
        let (code, _, stderr) = run(&[&["measure", &path, "--elements", &elements]]);
        assert!(code == 2 && stderr.contains(part) && stderr.contains(&path), "{frame}: {stderr}");
    }
}
