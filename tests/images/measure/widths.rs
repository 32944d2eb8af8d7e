//! Widths and forms of the image of a streak, and the size of the satellite.

use super::*;

/// The width of faint and narrow streaks has a large error, so that it differs from the right one by chance.
#[test]
fn verif_streaks_with_the_given_seeing_have_no_flag_of_the_width() {
    let outcomes = cell(20.0, 0.8, 0.0, 40);
    let flagged = outcomes.iter().filter(|one| one.measured.flags.contains(&Flag::Width)).count();
    assert!(flagged as f64 <= WRONG_WIDTHS * outcomes.len() as f64, "{flagged}");
    // A wrong seeing is flagged.
    let case = Case { seed: 5, ..outcomes[0].case };
    let case = Case { signal_to_noise: 100.0, seeing_pix: 3.0, angle_deg: 20.0, has_end: false, ..case };
    let assumed = Optics { seeing_arcsec: 2.0, ..optics(&case) };
    assert!(measured(case, &options(), assumed).measured.flags.contains(&Flag::Width));
}

/// Where the profile of a streak has other wings than the assumed one, the error of the flux contains the difference.
#[test]
fn verif_a_wrong_form_of_the_profile_is_part_of_the_error() {
    let moffat = SeeingForm::Moffat { beta: 3.5 };
    for (form, assumed) in [(moffat, SeeingForm::Gaussian), (SeeingForm::Gaussian, moffat)] {
        for seeing_pix in [2.2, 4.0] {
            for seed in 0..4 {
                let case = Case {
                    signal_to_noise: 300.0,
                    angle_deg: 20.0 + 40.0 * seed as f64,
                    seeing_pix,
                    form,
                    stars_per_megapixel: 0.0,
                    has_end: false,
                    seed: 4000 + seed,
                };
                let outcome = measured(case, &options(), Optics { form: assumed, ..optics(&case) });
                let (rate, stated) = (outcome.measured.rate, outcome.measured.form_sigma);
                let error = (rate.value / outcome.truth - 1.0).abs();
                println!("{form:?} {seeing_pix}: off by {error:.3}, stated {:.3}", rate.sigma / outcome.truth);
                assert!(error > 0.02 && error * outcome.truth <= 2.0 * rate.sigma, "{error} {rate:?}");
                assert!(stated > 0.5 * error * outcome.truth, "{stated} {error}");
                // With the right form the error is that of the noise.
                let right = measured(case, &options(), optics(&case)).measured;
                assert!(right.form_sigma < 0.3 * stated, "{} {stated}", right.form_sigma);
            }
        }
    }
}

#[test]
fn verif_a_fitted_width_replaces_a_wrong_seeing() {
    check_a_fitted_width();
}

/// With a given seeing that is wrong by 20 %, the fit of the width restores the flux.
pub(super) fn check_a_fitted_width() {
    let cases: Vec<Case> = (0..60)
        .map(|number: usize| Case {
            signal_to_noise: 150.0,
            angle_deg: ANGLES_DEG[number % 4],
            seeing_pix: 4.0,
            form: SeeingForm::Gaussian,
            stars_per_megapixel: 0.0,
            has_end: false,
            seed: 8_000_000 + 10 * number as u64,
        })
        .collect();
    let fitted = MeasureOptions { fit_width: true, ..options() };
    let outcomes: Vec<Outcome> = cases
        .into_par_iter()
        .map(|case| measured(case, &fitted, Optics { seeing_arcsec: 1.2 * case.seeing_pix, ..optics(&case) }))
        .collect();
    let (bias, error, share, found) = bias_and_share(outcomes.iter());
    print_row("given seeing 20 % too large, width fitted", [bias, error, share], found, outcomes.len());
    assert!(found == 60 && bias.abs() < FLUX_BIAS, "{bias}");
    assert!(outcomes.iter().all(|one| (one.measured.seeing_arcsec.unwrap() / 4.0 - 1.0).abs() < 0.05));
}

/// Streaks that are four times wider than the assumed seeing, as those of defocused satellites, are measured whole:
/// their wings are not masked as stars.
#[test]
fn verif_streaks_much_wider_than_the_seeing_are_measured() {
    const COUNT: usize = 40;
    /// Smallest number of streaks that are found, and largest error of each width.
    const FOUND: usize = 39;
    const WIDTH: f64 = 0.1;
    let cases: Vec<Case> = (0..COUNT)
        .map(|number: usize| Case {
            signal_to_noise: 150.0,
            angle_deg: ANGLES_DEG[number % 4],
            seeing_pix: 16.0,
            form: SeeingForm::Gaussian,
            stars_per_megapixel: if number < COUNT / 2 { 0.0 } else { 100.0 },
            has_end: false,
            seed: 8_500_000 + 10 * number as u64,
        })
        .collect();
    let fitted = MeasureOptions { fit_width: true, ..options() };
    let outcomes: Vec<Outcome> = cases
        .into_par_iter()
        .map(|case| measured(case, &fitted, Optics { seeing_arcsec: 4.0, ..optics(&case) }))
        .collect();
    let (bias, _, _, found) = bias_and_share(outcomes.iter());
    println!("four times wider: bias {:.2} %, found {found} of {COUNT}", 100.0 * bias);
    assert!(found >= FOUND && bias.abs() < FLUX_BIAS, "{found}, {bias}");
    let found = outcomes.iter().filter(|one| one.measured.is_detected);
    for (case, seeing) in found.map(|one| (one.case, one.measured.seeing_arcsec)) {
        assert!((seeing.unwrap() / case.seeing_pix - 1.0).abs() < WIDTH, "{case:?}: {seeing:?}");
    }
}

/// Streaks narrower than a pixel are measured whole: the fit does not stay beside the streak.
#[test]
fn verif_streaks_narrower_than_a_pixel_are_measured_whole() {
    /// Largest mean square of the errors in sigmas, and largest error.
    const SQUARES: f64 = 1.3;
    const SIGMAS: f64 = 4.5;
    let case = |number: usize| Case {
        signal_to_noise: [12.0, 18.0][number % 2],
        angle_deg: (37 * number % 180) as f64,
        seeing_pix: 0.8,
        form: SeeingForm::Gaussian,
        stars_per_megapixel: 0.0,
        has_end: false,
        seed: 9_500_000 + 10 * number as u64,
    };
    let cases: Vec<Case> = (0..200).map(case).collect();
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let found = outcomes.iter().filter(|one| one.measured.is_detected);
    let errors: Vec<f64> = found.map(|one| (one.measured.rate.value - one.truth) / one.measured.rate.sigma).collect();
    let squares = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    let most = errors.iter().fold(0.0f64, |most, error| most.max(error.abs()));
    println!("narrow streaks: {} found, mean square {squares:.2}, largest {most:.1}", errors.len());
    assert!(errors.len() > 190 && squares < SQUARES && most < SIGMAS, "{}: {squares}, {most}", errors.len());
}

/// The profile of the pixels along a track is that of the fitted streak, for all directions of motion.
#[test]
fn verif_profiles_across_the_track_are_those_of_the_fit() {
    /// Largest difference: the sum of this number of sigmas and this share of the peak.
    const SIGMAS: f64 = 5.0;
    const OF_PEAK: f64 = 0.03;
    for angle_deg in [0.0, 3.0, 52.0, 88.0, 160.0, 250.0] {
        let case = Case {
            signal_to_noise: 400.0,
            angle_deg,
            seeing_pix: 4.0,
            form: SeeingForm::Gaussian,
            stars_per_megapixel: 0.0,
            has_end: false,
            seed: 30 + angle_deg as u64,
        };
        let (outcome, plane) = drawn(case, &options(), optics(&case));
        let light_area = LightArea::whole(ROWS, COLUMNS);
        let sky = Background::new(&plane, &light_area);
        let profile = optics(&case).profile(600.0, 0.0, 1.0, 1.0).unwrap();
        let cut = streak_cut(&image_of(&plane, &sky, &light_area), &outcome.measured, &profile);
        let rows = cut.across_pix.len();
        assert_eq!((cut.profile.len(), cut.values.len()), (rows, rows * cut.columns));
        let peak = cut.model.iter().copied().fold(0.0, f64::max);
        for row in 0..rows {
            let difference = cut.profile[row] - cut.model[row];
            let most = SIGMAS * cut.profile_sigma[row] + OF_PEAK * peak;
            assert!(difference.abs() <= most, "{angle_deg}: row {row}: {} and {}", cut.profile[row], cut.model[row]);
        }
        assert!(cut.profile[rows / 2] > 0.9 * peak);
    }
}

/// The error of an assumed size is half of the difference of the fluxes with the sizes one sigma away. If the width is
/// fitted, it depends only on the shape of the light.
#[test]
fn verif_the_error_of_an_assumed_size_is_part_of_that_of_the_flux() {
    let optics = Optics { form: SeeingForm::Gaussian, seeing_arcsec: 2.5, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    // 10 m at 600 km are 3.4 pixels.
    let profile = optics.profile(600.0, 5.0, 1.0, 1.0).unwrap();
    let at =
        |time_s: f64| PixelPosition { x: 200.0 + SPEED_PIX_S * (time_s - 15.0), y: 150.0 + 20.0 * (time_s - 15.0) };
    let path = |[from_s, to_s]: [f64; 2], rate: f64| {
        StreakPath::new([from_s, to_s].map(|time_s| PathNode::new(time_s, at(time_s), rate)).to_vec()).unwrap()
    };
    const RATE: f64 = 2e5;
    let mut plane = Plane::from_values(ROWS, COLUMNS, vec![SKY_E as f32; ROWS * COLUMNS]).unwrap();
    draw(&path([0.0, EXPOSURE_S], RATE), &profile, ROWS, COLUMNS).add_to(&mut plane);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for value in plane.values_mut() {
        *value += 20.0 * <StandardNormal as Distribution<f32>>::sample(&StandardNormal, &mut random);
    }
    let light_area = LightArea::whole(ROWS, COLUMNS);
    let found = |radius_m: f64, radius_sigma_m: f64, fit_width: bool| {
        let predicted = PredictedStreak {
            path: path([-2.0, EXPOSURE_S + 2.0], 1.0),
            drift_pix_s: [0.0; 2],
            lateness_sigma_s: 0.1,
            largest_delay_s: 5.0,
            ends_s: None,
            cross_sigma_pix: CROSS_PIX,
            range_km: 600.0,
            radius_m,
            radius_sigma_m,
        };
        measure(&plane, &light_area, &predicted, &optics, &MeasureOptions { fit_width, ..options() }).unwrap()
    };
    let (exact, small, large) = (found(5.0, 0.0, false), found(2.5, 0.0, false), found(7.5, 0.0, false));
    let assumed = found(5.0, 2.5, false);
    assert_eq!(exact.size_sigma, 0.0);
    assert_eq!(assumed.rate.value, exact.rate.value);
    let half = 0.5 * (large.rate.value - small.rate.value);
    assert!(half > 0.05 * RATE && (assumed.size_sigma / half - 1.0).abs() < 0.1, "{} {half}", assumed.size_sigma);
    assert!((assumed.rate.sigma / exact.rate.sigma.hypot(assumed.size_sigma) - 1.0).abs() < 1e-9);
    // The signal to noise, which decides about the detection, does not contain it.
    assert_eq!(assumed.signal_to_noise, exact.signal_to_noise);
    let fitted = found(5.0, 2.5, true);
    assert!(fitted.size_sigma < 0.3 * assumed.size_sigma, "{} {}", fitted.size_sigma, assumed.size_sigma);
}
