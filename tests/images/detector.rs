//! Detector effects: statistics of noise, conservation of charge, optional stages.

use proptest::prelude::*;
use streakcast::images::{Detector, Patch, PixelPosition, Plane, Saturated};
use streakcast::streaks::{Blur, RadialProfile, RandomStars, Seeing, Star, background, draw_point};

fn profile() -> RadialProfile {
    RadialProfile::new(&Blur::seeing(Seeing::Gaussian { fwhm_pix: 3.0 })).expect("a profile")
}

fn point(x: f64, y: f64, flux: f64, rows: usize, columns: usize) -> Patch {
    draw_point(&profile(), PixelPosition { x, y }, flux, rows, columns)
}

fn detector(text: &str) -> Detector {
    Detector::from_toml(text).expect("a detector")
}

fn flat(rows: usize, columns: usize, value: f32) -> Plane {
    let mut plane = Plane::zeros(rows, columns);
    plane.values_mut().fill(value);
    plane
}

fn sum(plane: &Plane) -> f64 {
    plane.values().iter().map(|value| f64::from(*value)).sum()
}

fn mean_and_variance(values: &[f32]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / count;
    let variance = values.iter().map(|value| (f64::from(*value) - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, variance)
}

#[test]
fn verif_a_detector_without_effects_is_the_identity() {
    let off = detector("shot_noise = false");
    let mut light = flat(20, 30, 7.25);
    point(12.3, 9.8, 500.0, 20, 30).add_to(&mut light);
    assert_eq!(off.expose(&light, 1).expect("a frame"), (light.clone(), Saturated::default()));
    // Added light is summed with the frame. Adding nothing leaves the frame unchanged.
    let patch = point(3.3, 4.4, 250.0, 20, 30);
    let mut frame = light.clone();
    off.add_light(&mut frame, std::slice::from_ref(&patch), 1).expect("added");
    let mut sum = light.clone();
    patch.add_to(&mut sum);
    assert_eq!(frame, sum);
    let mut frame = light.clone();
    detector("read_noise_e = 5\ngain_e_adu = 2\nquantisation = {}").add_light(&mut frame, &[], 1).expect("added");
    assert_eq!(frame, light);
    // Bias and gain.
    let (frame, _) =
        detector("shot_noise = false\ngain_e_adu = 2.5\nbias_adu = 100").expose(&light, 1).expect("a frame");
    let pairs = frame.values().iter().zip(light.values());
    assert!(pairs.into_iter().all(|(count, e)| (count - (e / 2.5 + 100.0)).abs() < 1e-4));
}

#[test]
fn verif_noise_has_the_mean_and_the_variance_of_photons_and_readout() {
    let count = 400.0 * 400.0_f64;
    for sky in [0.3_f32, 4.0, 60.0, 3000.0] {
        let (frame, _) = Detector::default().expose(&flat(400, 400, sky), 7).expect("a frame");
        let (mean, variance) = mean_and_variance(frame.values());
        let sky = f64::from(sky);
        // Six sigma of the mean, and of the variance, whose variance is (2 λ² + λ) / n.
        assert!((mean - sky).abs() < 6.0 * (sky / count).sqrt(), "{sky}: {mean}");
        assert!((variance - sky).abs() < 6.0 * ((2.0 * sky * sky + sky) / count).sqrt(), "{sky}: {variance}");
    }
    let noisy = detector("gain_e_adu = 1.5\nread_noise_e = 6\nbias_adu = 200");
    let (mean, variance) = mean_and_variance(noisy.expose(&flat(400, 400, 90.0), 3).expect("a frame").0.values());
    assert!((mean - 260.0).abs() < 0.12, "{mean}");
    let expected = (90.0 + 36.0) / 2.25;
    assert!((variance / expected - 1.0).abs() < 0.025, "{variance} {expected}");
    // Light added to a frame has only its own photon noise; the noise of the frame is not generated again.
    let base = noisy.expose(&flat(100, 100, 400.0), 3).expect("a frame").0;
    let patch = point(50.0, 50.0, 5e4, 100, 100);
    let mut chi2 = 0.0;
    let mut pixels = 0.0;
    for seed in 0..20 {
        let mut frame = base.clone();
        noisy.add_light(&mut frame, std::slice::from_ref(&patch), seed).expect("added");
        for span in patch.iter() {
            for (column, light) in (span.first_column..).zip(span.values).filter(|(_, light)| **light > 20.0) {
                let added = 1.5 * f64::from(frame.row(span.row)[column] - base.row(span.row)[column]);
                chi2 += (added - f64::from(*light)).powi(2) / f64::from(*light);
                pixels += 1.0;
            }
        }
    }
    assert!((chi2 / pixels - 1.0).abs() < 6.0 * (2.0_f64 / pixels).sqrt(), "{} of {pixels}", chi2 / pixels);
}

#[test]
fn verif_the_same_seed_gives_the_same_frame_on_any_number_of_threads() {
    let noisy = detector(
        "gain_e_adu = 1.5\nread_noise_e = 6\nsaturation = { full_well_e = 900 }\nquantisation = {}\n\
         crosstalk = { amplifiers = [{ first_row = 0, rows = 60, first_column = 0, columns = 40 },\
         { first_row = 0, rows = 60, first_column = 40, columns = 40, corner = \"first_row_last_column\" }],\
         coefficients = [[0, 1e-3], [2e-3, 0]] }",
    );
    let mut light = flat(60, 80, 100.0);
    let patches = [point(20.0, 30.0, 3e4, 60, 80), point(24.0, 31.0, 1e4, 60, 80)];
    patches.iter().for_each(|patch| patch.add_to(&mut light));
    let frames = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (exposed, _) = noisy.expose(&light, seed).expect("a frame");
            let mut added = flat(60, 80, 150.0);
            noisy.add_light(&mut added, &patches, seed).expect("added");
            (exposed, added)
        })
    };
    assert_eq!(frames(1, 5), frames(3, 5));
    let (one, other) = (frames(1, 5), frames(1, 6));
    assert!(one.0 != other.0 && one.1 != other.1);
}

#[test]
fn verif_bleeding_conserves_charge() {
    let cut = |direction: &str| {
        detector(&format!("shot_noise = false\nsaturation = {{ full_well_e = 100, bleeding = \"{direction}\" }}"))
    };
    let mut light = flat(101, 31, 10.0);
    light.row_mut(50)[15] = 1000.0;
    let (frame, saturated) = cut("columns").expose(&light, 0).expect("a frame");
    assert_eq!(saturated, Saturated { pixels: 1, lost_e: 0.0 });
    assert!((sum(&frame) - sum(&light)).abs() < 1e-6 * sum(&light));
    // 450 electrons flow in each direction, into five pixels with a capacity of 90 each.
    let column: Vec<f32> = (43..58).map(|row| frame.row(row)[15]).collect();
    assert_eq!(
        column,
        [10.0, 10.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 100.0, 10.0, 10.0]
    );
    assert!(frame.row(50)[14] == 10.0 && frame.row(50)[16] == 10.0);
    let (frame, _) = cut("rows").expose(&light, 0).expect("a frame");
    assert_eq!((frame.row(50)[10], frame.row(50)[9], frame.row(49)[15]), (100.0, 10.0, 10.0));
    let (frame, saturated) = cut("off").expose(&light, 0).expect("a frame");
    assert_eq!((frame.row(50)[15], frame.row(49)[15], saturated.lost_e), (100.0, 10.0, 900.0));
    // Near the edge, half of the charge leaves the frame, which is reported.
    let mut light = flat(101, 31, 10.0);
    light.row_mut(2)[15] = 5000.0;
    let (frame, saturated) = cut("columns").expose(&light, 0).expect("a frame");
    assert!((saturated.lost_e - (2450.0 - 180.0)).abs() < 0.01, "{saturated:?}");
    assert!((sum(&frame) + saturated.lost_e - sum(&light)).abs() < 1e-6 * sum(&light));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn verif_wells_do_not_exceed_their_capacity_and_nothing_is_lost(
        values in prop::collection::vec(0.0..300.0_f32, 12 * 7), direction in 0..3_usize, full_well_e in 50.0..250.0_f64,
    ) {
        let direction = ["columns", "rows", "off"][direction];
        let cut = detector(&format!("shot_noise = false\nsaturation = {{ full_well_e = {full_well_e:?}, bleeding = \"{direction}\" }}"));
        let light = Plane::from_values(12, 7, values).expect("a plane");
        let (frame, saturated) = cut.expose(&light, 0).expect("a frame");
        prop_assert!(frame.values().iter().all(|value| f64::from(*value) <= full_well_e * 1.000001));
        prop_assert!((sum(&frame) + saturated.lost_e - sum(&light)).abs() < 1e-5 * sum(&light));
        prop_assert_eq!(saturated.pixels, light.values().iter().filter(|value| f64::from(**value) > full_well_e).count());
    }
}

#[test]
fn verif_light_added_to_a_frame_fills_the_remaining_capacity() {
    let cut = detector("shot_noise = false\ngain_e_adu = 2\nbias_adu = 50\nsaturation = { full_well_e = 1000 }");
    let counts = |e: f32| e / 2.0 + 50.0;
    let mut frame = flat(81, 20, counts(400.0));
    // One pixel is above its full well, and another one has no value.
    frame.row_mut(30)[10] = counts(1500.0);
    frame.row_mut(5)[3] = f32::NAN;
    let before = frame.clone();
    let patch = point(10.0, 40.0, 20_000.0, 81, 20);
    let saturated = cut.add_light(&mut frame, std::slice::from_ref(&patch), 0).expect("added");
    assert!(saturated.pixels > 4 && saturated.lost_e == 0.0, "{saturated:?}");
    assert_eq!(frame.row(30)[10], counts(1500.0));
    assert!(frame.row(5)[3].is_nan());
    let valid = |plane: &Plane| {
        plane.values().iter().filter(|value| !value.is_nan()).map(|value| f64::from(*value)).sum::<f64>()
    };
    assert!((2.0 * (valid(&frame) - valid(&before)) / 20_000.0 - 1.0).abs() < 1e-4);
    assert!(frame.values().iter().all(|value| value.is_nan() || *value <= counts(1500.0)));
    assert!((frame.row(43)[10] - counts(1000.0)).abs() < 0.01);
    // Distant pixels are unchanged.
    for row in (0..10).filter(|row| *row != 5) {
        assert_eq!(frame.row(row), before.row(row));
    }
}

#[test]
fn verif_crosstalk_appears_in_the_mirrored_pixel() {
    let text = |corner: &str| {
        format!(
            "shot_noise = false\ncrosstalk = {{ amplifiers = [{{ first_row = 0, rows = 30, first_column = 0, columns = 40 }},\
             {{ first_row = 0, rows = 30, first_column = 40, columns = 40, corner = \"{corner}\" }}],\
             coefficients = [[0, 2e-3], [1e-3, 0]] }}"
        )
    };
    for (corner, row, column) in [
        ("first_row_first_column", 4, 47),
        ("first_row_last_column", 4, 72),
        ("last_row_first_column", 25, 47),
        ("last_row_last_column", 25, 72),
    ] {
        let mut light = Plane::zeros(30, 80);
        light.row_mut(4)[7] = 10_000.0;
        let (frame, _) = detector(&text(corner)).expose(&light, 0).expect("a frame");
        assert_eq!((frame.row(4)[7], frame.row(row)[column]), (10_000.0, 10.0), "{corner}");
        assert!((sum(&frame) - 10_010.0).abs() < 1e-2, "{corner}");
        // In the opposite direction with the other coefficient, and added to a frame.
        let mut frame = flat(30, 80, 100.0);
        let patch = point(column as f64, row as f64, 1e5, 30, 80);
        detector(&text(corner)).add_light(&mut frame, std::slice::from_ref(&patch), 0).expect("added");
        let ghost = f64::from(frame.row(4)[7]) - 100.0;
        assert!((ghost / (2e-3 * f64::from(patch.at(row, column))) - 1.0).abs() < 1e-3, "{corner}: {ghost}");
    }
    let small = detector(&text("first_row_first_column")).expose(&Plane::zeros(20, 80), 0).expect_err("too small");
    let message = "detector: amplifier 0 is rows 0 to 29 and columns 0 to 39; \
                   allowed: rows and columns of the frame of 20 rows by 80 columns";
    assert_eq!(small.to_string(), message);
}

#[test]
fn verif_non_linearity_and_its_inverse() {
    let bent = detector("shot_noise = false\nnon_linearity = { scale_e = 1e5, coefficients = [-0.04, 0.01] }");
    let (frame, _) =
        bent.expose(&Plane::from_values(1, 4, vec![0.0, 1e4, 1e5, 2e5]).expect("a plane"), 0).expect("a frame");
    // The response is e (1 - 0.04 s + 0.01 s²) with s = e / scale, continued by its tangent above the scale, with slope
    // 1 - 0.08 + 0.03.
    for (value, expected) in frame.values().iter().zip([0.0, 1e4 * (1.0 - 0.004 + 0.0001), 0.97e5, 0.97e5 + 0.95e5]) {
        assert!((f64::from(*value) - expected).abs() < 0.02, "{value} {expected}");
    }
    // Light added in two steps gives the same result as in one step.
    let patch = point(10.0, 10.0, 3e5, 21, 21);
    let mut at_once = Plane::zeros(21, 21);
    patch.add_to(&mut at_once);
    patch.add_to(&mut at_once);
    let (at_once, _) = bent.expose(&at_once, 0).expect("a frame");
    let mut in_steps = Plane::zeros(21, 21);
    for _ in 0..2 {
        bent.add_light(&mut in_steps, std::slice::from_ref(&patch), 0).expect("added");
    }
    for (a, b) in at_once.values().iter().zip(in_steps.values()) {
        assert!((a - b).abs() < 0.02 + 1e-6 * a.abs(), "{a} {b}");
    }
}

#[test]
fn verif_vignetting() {
    let polynomial =
        detector("shot_noise = false\nvignetting.polynomial = { radius_pix = 50, coefficients = [-0.2, -0.1] }");
    let table = detector(
        "shot_noise = false\nvignetting.table = { centre_pix = [50, 50], radii_pix = [0, 25, 50], transmission = [1, 0.9, 0.5] }",
    );
    let light = flat(101, 101, 100.0);
    let of = |detector: &Detector| detector.expose(&light, 0).expect("a frame").0;
    let (a, b) = (of(&polynomial), of(&table));
    for (column, polynomial, table) in
        [(50, 100.0, 100.0), (75, 100.0 * (1.0 - 0.05 - 0.00625), 90.0), (100, 70.0, 50.0)]
    {
        assert!((a.row(50)[column] - polynomial).abs() < 1e-3 && (b.row(50)[column] - table).abs() < 1e-3, "{column}");
    }
    // Beyond the table the factor is constant. Added light is reduced by the same factor.
    assert!((b.row(0)[0] - 50.0).abs() < 1e-3);
    let patch = point(75.0, 50.0, 1000.0, 101, 101);
    let mut frame = Plane::zeros(101, 101);
    polynomial.add_light(&mut frame, std::slice::from_ref(&patch), 0).expect("added");
    assert!((frame.row(50)[75] / patch.at(50, 75) - 0.943_75).abs() < 1e-5);
}

#[test]
fn verif_integer_counts() {
    let whole = detector("shot_noise = false\ngain_e_adu = 2\nbias_adu = 100\nquantisation = { greatest_adu = 4095 }");
    let light = Plane::from_values(1, 4, vec![0.0, 2.9, 3.1, 1e5]).expect("a plane");
    assert_eq!(whole.expose(&light, 0).expect("a frame").0.values(), [100.0, 101.0, 102.0, 4095.0]);
    // A tenth of a count in every pixel is not lost by rounding: a tenth of the pixels increase by one.
    let mut wide = flat(300, 300, 0.2);
    wide.values_mut()[0] = 0.2;
    let profile = RadialProfile::new(&Blur::seeing(Seeing::Gaussian { fwhm_pix: 90.0 })).expect("a profile");
    let patch = draw_point(&profile, PixelPosition { x: 150.0, y: 150.0 }, 4000.0, 300, 300);
    let mut frame = flat(300, 300, 1000.0);
    whole.add_light(&mut frame, std::slice::from_ref(&patch), 4).expect("added");
    assert!(frame.values().iter().all(|value| value.fract() == 0.0));
    let gained = sum(&frame) - 1000.0 * 9e4;
    // 2000 counts in 9e4 pixels. The variance of a pixel is at most a quarter.
    assert!((gained - 0.5 * patch.sum()).abs() < 6.0 * (0.1 * 9e4_f64).sqrt(), "{gained}");
}

#[test]
fn verif_invalid_detectors_are_rejected() {
    for text in [
        "gain_e_adu = 0",
        "gain_e_adu = nan",
        "read_noise_e = -1",
        "bias = 3",
        "saturation = { full_well_e = 0 }",
        "saturation = { full_well_e = 10, bleeding = \"sideways\" }",
        "quantisation = { greatest_adu = 0 }",
        "non_linearity = { scale_e = 1e5, coefficients = [] }",
        "non_linearity = { scale_e = 1e5, coefficients = [-0.9] }",
        "vignetting.polynomial = { radius_pix = 0, coefficients = [0.1] }",
        "vignetting.table = { radii_pix = [0, 5, 5], transmission = [1, 1, 1] }",
        "vignetting.table = { radii_pix = [0, 5], transmission = [1] }",
        "crosstalk = { amplifiers = [], coefficients = [] }",
        "crosstalk = { amplifiers = [{ first_row = 0, rows = 9, first_column = 0, columns = 4 }, { first_row = 0, rows = 9, first_column = 3, columns = 4 }], coefficients = [[0, 0], [0, 0]] }",
        "crosstalk = { amplifiers = [{ first_row = 0, rows = 9, first_column = 0, columns = 4 }, { first_row = 0, rows = 9, first_column = 4, columns = 4 }], coefficients = [[0.01, 0], [0, 0]] }",
    ] {
        assert!(Detector::from_toml(text).is_err(), "{text}");
    }
    let patch = point(3.0, 3.0, 1.0, 10, 10);
    let error = Detector::default().add_light(&mut Plane::zeros(10, 11), &[patch], 0).expect_err("another shape");
    let message = "size of the light is 10 rows by 10 columns; allowed: 10 rows by 11 columns, the size of the frame";
    assert_eq!(error.to_string(), message);
}

#[test]
fn verif_backgrounds() {
    let stars = RandomStars {
        per_megapixel: 3000.0,
        slope: 0.4,
        brightest_mag: 14.0,
        faintest_mag: 20.0,
        zero_point_mag: 25.0,
    };
    let drawn = stars.draw(1000, 1000, 10.0, 9).expect("stars");
    let expected = 3000.0 * 1.02 * 1.02;
    assert!((drawn.len() as f64 - expected).abs() < 6.0 * f64::sqrt(expected), "{}", drawn.len());
    assert_eq!(drawn, stars.draw(1000, 1000, 10.0, 9).expect("stars"));
    // Star numbers increase by 10^0.4 per magnitude: the fraction 10^-0.8 is two magnitudes brighter than the limit.
    let bright = drawn.iter().filter(|star| star.flux_e > 10_f64.powf(0.4 * 7.0)).count() as f64;
    let share = 10_f64.powf(-0.8);
    assert!((bright / drawn.len() as f64 - share).abs() < 0.03, "{bright}");
    assert!(drawn.iter().all(|star| (99.9..=25_119.0).contains(&star.flux_e)));

    let profile = profile();
    let lone = [Star::of_magnitude(PixelPosition { x: 30.0, y: 20.0 }, 15.0, 25.0)];
    let plane = background(50, 60, 12.0, &lone, &profile).expect("a background");
    assert!((sum(&plane) - 12.0 * 3000.0 - 1e4).abs() < 1.0, "{}", sum(&plane));
    let error = background(5, 5, -1.0, &[], &profile).expect_err("a negative sky");
    assert_eq!(error.to_string(), "background: sky_e is -1; allowed: 0 to 1000000000");
    assert!(RandomStars { slope: f64::NAN, ..stars }.draw(10, 10, 0.0, 0).is_err());
}
