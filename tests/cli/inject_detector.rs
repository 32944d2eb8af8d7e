//! `inject` with a detector: the light of bright streaks is conserved, and masks mark bleeding and ghosts.

use std::fs;
use std::path::Path;

use crate::common::cli::{done, path, records, run};
use crate::common::injected::{RANDOM, SKY, numbers, values};
use streakcast::images::{Card, CardValue, FrameFile, ImageValues, NewImage, Pixels, write_frame};
use tempfile::TempDir;

const SIDE: usize = 300;

/// Returns the pixels of the first HDU in double precision.
fn exact(file: &str) -> Vec<f64> {
    FrameFile::open(Path::new(file)).unwrap().read_rows(0, 0..SIDE).unwrap()
}

#[test]
fn verif_noise_beside_large_numbers_loses_no_light() {
    let folder = TempDir::new().unwrap();
    let pixels = |level: f64| {
        [Pixels::F64(vec![level; SIDE * SIDE].into()), Pixels::I32(vec![level as i32; SIDE * SIDE].into())]
    };
    let cards = Card::with_value("EXPTIME", &CardValue::Real(30.0), "");
    let frames = pixels(1e9).into_iter().chain(pixels(1e12).into_iter().take(1));
    for (number, pixels) in frames.enumerate() {
        let [input, output, truth] = ["fits", "out.fits", "csv"].map(|end| path(&folder, &format!("{number}.{end}")));
        let image = ImageValues::new(SIDE, pixels).unwrap();
        let image = NewImage { name: "", values: &image, cards: &cards, rice: None };
        write_frame(Path::new(&input), &[image]).unwrap();
        // The peak is about 30 counts, half of the resolution of single precision at 1e9 counts.
        let light = ["--random-streaks", "1", "--magnitude", "8", "--zero-point-1s", "22", "--gain", "2"];
        let sky =
            ["--pixel-scale", "1arcsec", "--seeing", "2.5arcsec", "--start", "2024-08-14T00:30:00Z", "--seed", "3"];
        done(&[&["inject", "--image", &input, "-o", &output, "--truth", &truth, "--quiet"], &light, &sky]);
        let added: Vec<f64> = exact(&input).iter().zip(exact(&output)).map(|(old, new)| new - old).collect();
        let counts: f64 = numbers(&records(&fs::read_to_string(&truth).unwrap()), "counts").iter().sum();
        let (sum, peak) = (added.iter().sum::<f64>(), added.iter().copied().fold(0.0, f64::max));
        assert!((5.0..200.0).contains(&peak), "{peak}");
        // The gain is two electrons per count; the tolerance is six sigma.
        let allowed = 6.0 * (counts / 2.0).sqrt();
        assert!((sum - counts).abs() < allowed && allowed < 0.04 * counts, "{number}: {sum} {counts}");
    }
}

#[test]
fn verif_bleeding_and_ghosts_are_masked() {
    let folder = TempDir::new().unwrap();
    let [description, plain, output, detector] =
        ["sky.toml", "plain.fits", "out.fits", "detector.toml"].map(|name| path(&folder, name));
    fs::write(&description, SKY).unwrap();
    done(&[
        &["inject", "--synthetic", &description, "-o", &plain, "--random-streaks", "0", "--pixels-only"],
        &RANDOM[2..],
    ]);
    // Full wells hold 4,000 electrons, of which the sky is 1,200. Each half of the chip has ghosts of the other half.
    let text = "bias_adu = 300\nsaturation = { full_well_e = 4000, bleeding = 'columns' }\nquantisation = {}\n\
        crosstalk = { coefficients = [[0, 0.03], [0.03, 0]], amplifiers = [\
        { first_row = 0, rows = 300, first_column = 0, columns = 200 },\
        { first_row = 0, rows = 300, first_column = 200, columns = 200, corner = 'first_row_last_column' }] }\n";
    fs::write(&detector, text).unwrap();
    let files = ["--image", &plain, "-o", &output, "--detector", &detector, "--quiet", "--seed", "5"];
    done(&[&["inject"], &files, &["--random-streaks", "1", "--magnitude", "1", "--seeing", "2.5arcsec"]]);
    let (old, new, mask) = (values(&plain, 0), values(&output, 0), values(&output, 1));
    // The sky noise is 17.5 counts, and streaks of one count are added.
    let [mut changed, mut unmasked, mut alone, mut idle] = [0; 4];
    for ((old, new), bits) in old.iter().zip(&new).zip(&mask) {
        let change = (new - old).abs();
        changed += usize::from(change > 20.0);
        unmasked += usize::from(change > 20.0 && *bits == 0.0);
        alone += usize::from(change > 20.0 && *bits == 2.0);
        idle += usize::from(change == 0.0 && *bits == 2.0);
    }
    assert!(changed > 3000 && unmasked == 0, "{unmasked} of {changed}");
    assert!(alone > 1000, "bled columns and ghosts are injected and no streak: {alone}");
    assert!(idle < changed / 50, "{idle} are masked and did not change");
}

/// A file with the keys of a detector, one with the table `[detector]`, and the description of a synthetic frame are
/// the same detector.
#[test]
fn verif_a_detector_is_read_from_each_form_of_file() {
    let folder = TempDir::new().unwrap();
    let [plain, output, detector] = ["plain.fits", "out.fits", "detector.toml"].map(|name| path(&folder, name));
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/synthetic.toml");
    done(&[&["inject", "--synthetic", example, "-o", &plain, "--random-streaks", "0", "--pixels-only"], &RANDOM[2..]]);
    let streak = ["--random-streaks", "1", "--magnitude", "1", "--seeing", "2.5arcsec", "--seed", "5", "--quiet"];
    let injected = |detector: &str| {
        done(&[&["inject", "--image", &plain, "-o", &output, "--detector", detector], &streak]);
        fs::read(&output).unwrap()
    };
    let expected = injected(example);
    let text = fs::read_to_string(example).unwrap();
    let (_, keys) = text.split_once("[detector]\n").unwrap();
    for text in [keys.to_owned(), format!("[detector]\n{keys}")] {
        fs::write(&detector, text).unwrap();
        assert!(injected(&detector) == expected);
    }
    for (text, more, message) in [
        ("[detector]\ngain = 2\n", "0", "detector.toml: line 2: unknown key 'gain'"),
        ("gain = 2\n", "0", "detector.toml: line 1: unknown key 'gain'"),
        ("gain_e_adu = \"x\"\n", "0", "detector.toml: line 1: invalid value"),
        ("[detector]\ngain_e_adu = 0\n", "0", "detector.toml: gain_e_adu is 0; allowed: 0.000001 to 1000000"),
        ("bias_adu = 3\n[detector]\n", "0", "detector.toml: line 1: unknown key 'bias_adu'"),
        ("[detector]\ngain_e_adu = 2\n", "2", "--gain and gain_e_adu in the file of --detector exclude each other"),
    ] {
        fs::write(&detector, text).unwrap();
        let gain: &[&str] = if more == "0" { &[] } else { &["--gain", more] };
        let files = ["inject", "--image", &plain, "-o", &output, "--detector", &detector];
        let (code, _, stderr) = run(&[&files, &streak, gain]);
        assert!(code == 2 && stderr.contains(message), "{text}: {stderr}");
    }
}

#[test]
fn verif_variances_of_a_masked_image_grow_with_the_light() {
    let folder = TempDir::new().unwrap();
    let [input, output] = ["in.fits", "out.fits"].map(|name| path(&folder, name));
    let plane = |value: f32| ImageValues::new(SIDE, Pixels::F32(vec![value; SIDE * SIDE].into())).unwrap();
    let (image, mask, variance) = (plane(0.0), plane(0.0), plane(629.0));
    let cards = Card::with_value("EXPTIME", &CardValue::Real(30.0), "");
    let named = [("IMAGE", &image), ("MASK", &mask), ("VARIANCE", &variance)];
    let empty = ImageValues::new(1, Pixels::U8(vec![0].into())).unwrap();
    let primary = NewImage { name: "", values: &empty, cards: &cards, rice: None };
    let planes = named.map(|(name, values)| NewImage { name, values, cards: &[], rice: None });
    write_frame(Path::new(&input), &[&[primary][..], &planes].concat()).unwrap();
    let light = ["--random-streaks", "1", "--magnitude", "6", "--zero-point-1s", "26", "--gain", "4", "--hdu", "1"];
    let sky = ["--pixel-scale", "1arcsec", "--seeing", "2.5arcsec", "--start", "2024-08-14T00:30:00Z", "--seed", "3"];
    let arguments: &[&str] = &["inject", "--image", &input, "-o", &output, "--quiet"];
    done(&[arguments, &light, &sky]);
    let (added, variances) = (values(&output, 1), values(&output, 3));
    let lit = added.iter().filter(|value| **value > 100.0).count();
    assert!(lit > 100, "{lit}");
    for (added, variance) in added.iter().zip(&variances) {
        assert!((variance - 629.0 - added / 4.0).abs() < 1e-6 * variance, "{added} {variance}");
    }
    for option in ["--pixels-only", "--no-noise"] {
        done(&[arguments, &light, &sky, &[option]]);
        assert!(values(&output, 3).iter().all(|variance| *variance == 629.0), "{option}");
    }
}
