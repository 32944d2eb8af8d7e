//! `inject` for raw frames: overscan regions and non-square pixels.

use std::fs;
use std::ops::Range;
use std::path::Path;

use crate::common::cli::{done, path, records, run};
use crate::common::injected::{RANDOM, SKY, numbers, unrounded, values};
use streakcast::images::{CardValue, FrameCopy, FrameFile};
use tempfile::TempDir;

const COLUMNS: usize = 400;
const LIT_COLUMNS: Range<usize> = 50..380;
const LIT_ROWS: Range<usize> = 10..290;

/// Creates a frame of stars with the given header cards.
fn frame(folder: &TempDir, name: &str, sky: &str, cards: &[(&str, CardValue)]) -> String {
    let [description, plain, output] = ["sky.toml", "plain.fits", name].map(|name| path(folder, name));
    fs::write(&description, sky).unwrap();
    let nothing = ["--random-streaks", "0", "--pixels-only", "--ra", "40", "--dec", "0"];
    done(&[&["inject", "--synthetic", &description, "-o", &plain], &RANDOM[2..], &nothing]);
    let mut copy = FrameCopy::begin(&FrameFile::open(Path::new(&plain)).unwrap(), Path::new(&output)).unwrap();
    cards.iter().for_each(|(keyword, value)| copy.set_card(0, keyword, value, "").unwrap());
    copy.finish().unwrap();
    output
}

/// Returns the numbers of changed pixels in the illuminated part of the frame and elsewhere.
fn changed(before: &str, after: &str) -> [usize; 2] {
    let mut counts = [0, 0];
    for (pixel, (old, new)) in values(before, 0).iter().zip(&values(after, 0)).enumerate() {
        let is_lit = LIT_ROWS.contains(&(pixel / COLUMNS)) && LIT_COLUMNS.contains(&(pixel % COLUMNS));
        counts[usize::from(!is_lit)] += usize::from(old != new);
    }
    counts
}

const DATA: (&str, &str) = ("DATASEC", "[51:380,11:290]");
const BIAS: (&str, &str) = ("BIASSEC", "[381:400,1:300]");

fn with(sky: &str, folder: &TempDir, name: &str, sections: &[(&str, &str)]) -> String {
    let cards: Vec<_> = sections.iter().map(|(keyword, section)| (*keyword, CardValue::from(*section))).collect();
    frame(folder, name, sky, &cards)
}

#[test]
fn verif_overscan_receives_no_light() {
    let folder = TempDir::new().unwrap();
    let raw = with(&unrounded(), &folder, "raw.fits", &[DATA, BIAS]);
    let (output, truth) = (path(&folder, "out.fits"), path(&folder, "truth.csv"));
    let options = ["--random-streaks", "4", "--magnitude", "5,6", "--seeing", "2.5arcsec", "--seed", "3"];
    let files = ["--image", &raw, "-o", &output, "--truth", &truth, "--no-noise"];
    let (code, _, stderr) = run(&[&["inject"], &files, &options]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("HDU 0: only [51:380,11:290] is illuminated"), "{stderr}");
    let [lit, dark] = changed(&raw, &output);
    assert!(lit > 1000 && dark == 0, "{lit} {dark}");
    // The truth table describes the light and the ends of the streak in the illuminated part.
    let rows = records(&fs::read_to_string(&truth).unwrap());
    let counts: f64 = numbers(&rows, "counts").iter().sum();
    let light = values(&raw, 0).iter().zip(&values(&output, 0)).map(|(old, new)| f64::from(new - old)).sum::<f64>();
    assert!((light / counts - 1.0).abs() < 1e-4, "{light} {counts}");
    let borders = |values: Vec<f64>, least: f64, greatest: f64| {
        assert!(values.iter().all(|at| (least - 0.01..=greatest + 0.01).contains(at)), "{values:?}");
        values.iter().filter(|at| (*at - least).abs() < 0.01 || (*at - greatest).abs() < 0.01).count()
    };
    let on_x = borders([numbers(&rows, "x1_pix"), numbers(&rows, "x2_pix")].concat(), 50.5, 380.5);
    let on_y = borders([numbers(&rows, "y1_pix"), numbers(&rows, "y2_pix")].concat(), 10.5, 290.5);
    assert_eq!(on_x + on_y, 2 * (rows.len() - 1), "every streak runs from border to border");

    // Section keywords that may remain after the overscan was trimmed are ignored.
    let trimmed = with(&unrounded(), &folder, "trimmed.fits", &[DATA]);
    let files = ["--image", &trimmed, "-o", &output, "--no-noise", "--quiet"];
    done(&[&["inject"], &files, &options]);
    assert!(changed(&trimmed, &output)[1] > 100);
}

#[test]
fn verif_charge_that_bleeds_stays_out_of_the_overscan() {
    let folder = TempDir::new().unwrap();
    let raw = with(SKY, &folder, "raw.fits", &[DATA, BIAS]);
    let (output, detector) = (path(&folder, "out.fits"), path(&folder, "detector.toml"));
    fs::write(&detector, "gain_e_adu = 2.0\nbias_adu = 300\nsaturation = { full_well_e = 40000 }\n").unwrap();
    let files = ["--image", &raw, "-o", &output, "--detector", &detector, "--quiet"];
    done(&[&["inject"], &files, &["--random-streaks", "3", "--magnitude", "-8", "--seeing", "2.5arcsec"]]);
    let [lit, dark] = changed(&raw, &output);
    let full = values(&output, 0).iter().filter(|value| **value >= 20_300.0).count();
    assert!(lit > 1000 && full > 1000 && dark == 0, "{lit} {full} {dark}");
}

#[test]
fn verif_non_square_pixels_give_an_elongated_image() {
    let folder = TempDir::new().unwrap();
    // Pixels are 2" by 1".
    let oblong = frame(&folder, "oblong.fits", &unrounded(), &[("CD1_1", CardValue::Real(-2.0 / 3600.0))]);
    let (output, truth) = (path(&folder, "out.fits"), path(&folder, "truth.csv"));
    // A streak of only 0.02 arcsec.
    let still = ["--random-streaks", "1", "--magnitude", "7", "--streak-rate-deg-s", "1e-4", "--exposure", "0.05s"];
    let files = ["--image", &oblong, "-o", &output, "--truth", &truth, "--no-noise", "--quiet"];
    done(&[&["inject"], &files, &still, &["--seeing", "12arcsec", "--psf", "gaussian"]]);
    let mut sums = [0.0f64; 5];
    for (pixel, (old, new)) in values(&oblong, 0).iter().zip(&values(&output, 0)).enumerate() {
        let (light, x, y) = (f64::from(new - old), (pixel % COLUMNS) as f64, (pixel / COLUMNS) as f64);
        [1.0, x, y, x * x, y * y].iter().zip(&mut sums).for_each(|(weight, sum)| *sum += light * weight);
    }
    let [light, x, y, xx, yy] = sums;
    let variance = |first: f64, second: f64| second / light - (first / light).powi(2);
    // Variance of a Gaussian plus that of a pixel, in pixels². Single precision on the sky causes an error of 1 %.
    let sigma_arcsec = 12.0 / (8.0f64 * 2f64.ln()).sqrt();
    let expected = |side_arcsec: f64| (sigma_arcsec / side_arcsec).powi(2) + 1.0 / 12.0;
    let (across, along) = (variance(x, xx) / expected(2.0), variance(y, yy) / expected(1.0));
    assert!((across - 1.0).abs() < 0.01 && (along - 1.0).abs() < 0.01, "{across} {along}");
    let counts: f64 = numbers(&records(&fs::read_to_string(&truth).unwrap()), "counts").iter().sum();
    assert!((light / counts - 1.0).abs() < 1e-4, "{light} {counts}");
}
