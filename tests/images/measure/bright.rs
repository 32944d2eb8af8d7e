//! Bright streaks, streaks beside each other, and given ends.

use super::*;

/// The star mask has no pixels of a streak: bright streaks, whose errors of position and profile are many times the
/// noise, have their flux, also beside another bright streak.
#[test]
fn verif_bright_streaks_are_measured_whole() {
    /// Largest relative error of a flux.
    const FLUX: f64 = 0.03;
    let mut cases = Vec::new();
    for signal_to_noise in [1e3, 1e4, 1e5, 1e6] {
        for (number, seeing_pix) in [1.05, 2.2, 4.0, 7.0].into_iter().enumerate() {
            for (angle, angle_deg) in ANGLES_DEG.into_iter().enumerate() {
                let form =
                    if (number + angle) % 2 == 0 { SeeingForm::Gaussian } else { SeeingForm::Moffat { beta: 3.5 } };
                let seed = 8_700_000 + 10 * cases.len() as u64;
                cases.push(Case {
                    signal_to_noise,
                    angle_deg,
                    seeing_pix,
                    form,
                    stars_per_megapixel: 0.0,
                    has_end: angle == 1,
                    seed,
                });
            }
        }
    }
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let failed = |one: &&Outcome| {
        let measured = &one.measured;
        !measured.is_detected
            || (measured.rate.value / one.truth - 1.0).abs() > FLUX
            || measured.flags.contains(&Flag::Masked)
    };
    for one in outcomes.iter().filter(failed) {
        println!("{:?}: {} {:?}", one.case, one.measured.rate.value / one.truth, one.measured.flags);
    }
    assert_eq!(outcomes.iter().filter(failed).count(), 0, "of {}", outcomes.len());
}

/// A bright streak in a corner of the frame has its flux also if another one of the same brightness ends 77 pixels from
/// it at the edge of the frame.
#[test]
fn verif_a_bright_streak_beside_another_has_its_flux() {
    /// Largest relative error of a flux, and light per second of each streak.
    const FLUX: f64 = 0.03;
    const RATE: f64 = 800_000.0;
    const SIDE: usize = 400;
    let optics = Optics {
        form: SeeingForm::Moffat { beta: 3.5 },
        seeing_arcsec: 1.05,
        outer_radius_m: 0.0,
        inner_radius_m: 0.0,
    };
    let profile = optics.profile(600.0, 0.0, 1.0, 1.0).unwrap();
    let line = |from: [f64; 3], to: [f64; 3], rate: f64| {
        let nodes = [from, to].map(|[time_s, x, y]| PathNode::new(time_s, PixelPosition { x, y }, rate));
        StreakPath::new(nodes.to_vec()).unwrap()
    };
    let other = line([13.0, 229.0, -8.0], [22.2, 164.0, 408.0], RATE);
    let extended = |rate: f64| line([13.0, 226.7, -73.4], [20.0, -57.2, 203.2], rate);
    for seed in 0..4 {
        for has_other in [false, true] {
            let drawn: Vec<StreakPath> =
                [Some(extended(RATE)), has_other.then(|| other.clone())].into_iter().flatten().collect();
            let plane = on_noisy_sky(&drawn, &profile, [SIDE; 2], [100.0, 10.0], seed);
            let predicted = PredictedStreak {
                lateness_sigma_s: 0.6,
                largest_delay_s: 5.0,
                cross_sigma_pix: 0.5,
                ..point_source(extended(1.0))
            };
            let light_area = LightArea::whole(SIDE, SIDE);
            let measured = measure(&plane, &light_area, &predicted, &optics, &options()).unwrap();
            let ratio = measured.rate.value / RATE;
            println!("seed {seed}, other {has_other}: {ratio} {:?} {:?}", measured.flags, measured.offset_pix);
            assert!((ratio - 1.0).abs() <= FLUX, "seed {seed}, other {has_other}: {ratio}");
        }
    }
}

/// Two given streaks beside each other, of which one is five times brighter, have their own fluxes and a flag.
#[test]
fn given_streaks_beside_each_other_do_not_take_the_same_light() {
    /// Largest relative error of the flux, and light of the streaks per second.
    const FLUX: f64 = 0.1;
    const RATES: [f64; 2] = [10_000.0, 50_000.0];
    const SIDE: usize = 400;
    const LENGTH: f64 = 300.0;
    let optics = Optics { form: SeeingForm::Gaussian, seeing_arcsec: 4.0, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let profile = optics.profile(600.0, 0.0, 1.0, 1.0).unwrap();
    let line = |y: f64, beyond: f64, rate: f64| {
        let node = |time_s: f64| {
            PathNode::new(time_s, PixelPosition { x: 50.0 + LENGTH * time_s / 10.0, y: y + 2.0 * time_s }, rate)
        };
        StreakPath::new([-beyond, 10.0 + beyond].map(node).to_vec()).unwrap()
    };
    for (apart, cross_sigma_pix) in [(16.0, 0.5), (16.0, 3.0), (24.0, 3.0), (60.0, 3.0)] {
        let places = [150.0, 150.0 + apart];
        let drawn: Vec<StreakPath> = places.iter().zip(RATES).map(|(y, rate)| line(*y, 0.0, rate)).collect();
        let plane = on_noisy_sky(&drawn, &profile, [SIDE; 2], [800.0, 20.0], 3);
        for (y, rate) in places.iter().zip(RATES) {
            let predicted =
                PredictedStreak { ends_s: Some([0.0, 10.0]), cross_sigma_pix, ..point_source(line(*y, 0.5, 1.0)) };
            let options = MeasureOptions { neighbour_pix: Some(apart), ..options() };
            let light_area = LightArea::whole(SIDE, SIDE);
            let measured = measure(&plane, &light_area, &predicted, &optics, &options).unwrap();
            let ratio = measured.rate.value / rate;
            println!("{apart} {cross_sigma_pix}: {ratio} {:?} {:?}", measured.flags, measured.offset_pix);
            assert!(measured.offset_pix.value.abs() < 1.0, "{apart}: {:?}", measured.offset_pix);
            assert!((ratio - 1.0).abs() <= FLUX, "{apart}: {ratio}");
            assert_eq!(measured.flags.contains(&Flag::Blended), apart <= 24.0, "{apart}");
        }
    }
}

/// Given ends are fitted where the light of a bright streak ends, and stay near the given position if bad pixels hide
/// it.
#[test]
fn verif_given_ends_of_bright_streaks_are_where_their_light_ends() {
    /// Largest error of an end, and of one that bad pixels hide, pixels. The error of the given ends is 3 pixels.
    const END_PIX: f64 = 0.3;
    const HIDDEN_PIX: f64 = 2.0;
    const RATE: f64 = 84_000.0;
    let (rows, columns) = (160, 600);
    let optics = Optics { form: SeeingForm::Gaussian, seeing_arcsec: 2.4, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let profile = optics.profile(600.0, 0.0, 1.0, 1.0).unwrap();
    for seed in 0..40 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let (y, rise) = (60.0 + 3.0 * normal(), 40.0 + 10.0 * normal());
        let at = |time_s: f64| PixelPosition { x: 59.0 + 16.0 * time_s, y: y + rise * time_s / EXPOSURE_S };
        let line = |[from_s, to_s]: [f64; 2], rate: f64| {
            StreakPath::new([from_s, to_s].map(|time_s| PathNode::new(time_s, at(time_s), rate)).to_vec()).unwrap()
        };
        let mut plane = Plane::zeros(rows, columns);
        draw(&line([0.0, EXPOSURE_S], RATE), &profile, rows, columns).add_to(&mut plane);
        let is_hidden = seed % 4 == 0;
        if is_hidden {
            // Bad pixels around the end.
            let end = at(EXPOSURE_S);
            for row in 0..rows {
                for column in 0..columns {
                    if end.distance(PixelPosition { x: column as f64, y: row as f64 }) < 8.0 {
                        plane.row_mut(row)[column] = f32::NAN;
                    }
                }
            }
        }
        for value in plane.values_mut() {
            let mean = f64::from(*value) + 150.0;
            *value = (mean + normal() * mean.sqrt()) as f32;
        }
        let predicted = PredictedStreak {
            ends_s: Some([0.0, EXPOSURE_S]),
            cross_sigma_pix: 3.0,
            ..point_source(line([-0.8, EXPOSURE_S + 0.8], 1.0))
        };
        let measured = measure(&plane, &LightArea::whole(rows, columns), &predicted, &optics, &options()).unwrap();
        let [first, last] = measured.ends_in_frame();
        let errors_pix = [first.distance(at(0.0)), last.distance(at(EXPOSURE_S))];
        let ratio = measured.rate.value / RATE - 1.0;
        println!("seed {seed}: ends {errors_pix:.2?}, flux {ratio:.5} +- {:.5}", measured.rate.sigma / RATE);
        assert!(errors_pix[0] < END_PIX && errors_pix[1] < if is_hidden { HIDDEN_PIX } else { END_PIX }, "seed {seed}");
        assert!(is_hidden || ratio.abs() < 5.0 * measured.rate.sigma / RATE, "seed {seed}: {ratio}");
    }
}
