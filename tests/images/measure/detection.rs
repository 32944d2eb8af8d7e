//! Streaks that are found, hidden or missing: completeness, false detections and limits.

use super::*;

/// Largest accepted share of false detections: 2.4 sigmas above the probability of one in 600 corridors, 1.4 sigmas in
/// 200.
const FALSE_ALARMS: f64 = 0.02;

/// Corridors without a streak, a third of them among 1,000 stars per megapixel.
pub(super) fn check_false_detections(count: usize) {
    let cases: Vec<Case> = (0..count)
        .map(|number: usize| Case {
            signal_to_noise: 0.0,
            angle_deg: ANGLES_DEG[number % 4],
            seeing_pix: SEEING_PIX[(number / 4) % 3],
            form: SeeingForm::Gaussian,
            stars_per_megapixel: STARS[(number / 12) % 3],
            has_end: false,
            seed: 7_000_000 + 10 * number as u64,
        })
        .collect();
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let found = outcomes.iter().filter(|one| one.measured.is_detected).count();
    println!("| no streak | | | {found} of {count} |");
    assert!(found as f64 <= FALSE_ALARMS * count as f64, "{found}");
    // Upper limits are above the rate, which is 0.
    assert!(outcomes.iter().all(|one| one.measured.rate_limit > 0.0));
}

#[test]
fn verif_false_detections_are_rare() {
    check_false_detections(if is_all() { 200 } else { 100 });
}

/// Bright streaks that the mask of the frame covers are neither found nor excluded, and dark streaks are not found in
/// the contrast beside them.
#[test]
fn verif_hidden_and_dark_streaks_have_no_limit() {
    let light_area = LightArea::whole(ROWS, COLUMNS);
    for (number, angle_deg) in ANGLES_DEG.into_iter().enumerate() {
        for signal_to_noise in [30.0, 400.0, 4000.0] {
            let case = Case {
                signal_to_noise,
                angle_deg,
                seeing_pix: 3.0,
                form: SeeingForm::Gaussian,
                stars_per_megapixel: 100.0,
                has_end: number % 2 == 1,
                seed: 9_000_000 + 10 * number as u64,
            };
            let Scene { plane, predicted, .. } = scene(case);
            let (found, _) = drawn(case, &options(), optics(&case));
            let clear = found.measured;
            assert!(clear.is_detected && !clear.flags.contains(&Flag::Masked) && !clear.flags.contains(&Flag::Dark));
            // The mask reaches to the given distance from the track.
            for half_width_pix in [1.5, 3.0, 4.0, 8.0] {
                let mut masked = plane.clone();
                let [from, to] = clear.ends_in_frame();
                let length_pix = from.distance(to);
                for (index, value) in masked.values_mut().iter_mut().enumerate() {
                    let (x, y) = ((index % COLUMNS) as f64, (index / COLUMNS) as f64);
                    let across = ((x - from.x) * (to.y - from.y) - (y - from.y) * (to.x - from.x)) / length_pix;
                    if across.abs() < half_width_pix {
                        *value = f32::NAN;
                    }
                }
                let one = measure(&masked, &light_area, &predicted, &optics(&case), &options()).unwrap();
                let message = format!("{case:?}, {half_width_pix}: {:?}", one.flags);
                assert!(one.flags.contains(&Flag::Masked) && !one.flags.contains(&Flag::Dark), "{message}");
                assert!(!one.is_detected, "{message}");
            }
            // The frame with negative light.
            let mut dark = plane.clone();
            dark.values_mut().iter_mut().for_each(|value| *value = 2.0 * SKY_E as f32 - *value);
            let one = measure(&dark, &light_area, &predicted, &optics(&case), &options()).unwrap();
            assert!(!one.is_detected && one.flags.contains(&Flag::Dark), "{case:?}: {:?}", one.flags);
        }
    }
}

/// A bright streak a few pixels from the edge of the frame is found with its flux.
#[test]
fn verif_streaks_beside_the_edge_are_found() {
    /// Largest relative error of the flux.
    const ERROR: f64 = 0.05;
    let profile = Optics { form: SeeingForm::Gaussian, seeing_arcsec: 3.0, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let drawn_with = profile.profile(600.0, 0.0, 1.0, 1.0).unwrap();
    for (number, edge_pix) in [2.0, 4.0, 7.0, COLUMNS as f64 - 4.0].into_iter().enumerate() {
        let light_area = LightArea::whole(ROWS, COLUMNS);
        let path = |rate: f64| {
            let ends = [(0.0, 60.0), (EXPOSURE_S, 260.0)];
            let nodes = ends.map(|(time_s, y)| PathNode::new(time_s, PixelPosition { x: edge_pix, y }, rate));
            StreakPath::new(nodes.to_vec()).unwrap()
        };
        let plane = on_noisy_sky(&[path(6000.0)], &drawn_with, [ROWS, COLUMNS], [1000.0, 10.0], number as u64);
        let predicted = PredictedStreak {
            largest_delay_s: 5.0,
            ends_s: Some([0.0, EXPOSURE_S]),
            cross_sigma_pix: 2.0,
            ..point_source(path(1.0))
        };
        // Also with a border of two masked columns, as of an amplifier, outside of the light of the streak.
        let mut with_border = plane.clone();
        with_border.values_mut().chunks_exact_mut(COLUMNS).for_each(|row| row[..2].fill(f32::NAN));
        for plane in [Some(plane), (number == 2).then_some(with_border)].into_iter().flatten() {
            let one = measure(&plane, &light_area, &predicted, &profile, &options()).unwrap();
            assert!(one.is_detected, "{edge_pix}: {} of {}", one.significance, one.threshold);
            assert!((one.rate.value / 6000.0 - 1.0).abs() < ERROR, "{edge_pix}: {:?}", one.rate);
        }
    }
}

/// Completeness rises from a few to all streaks with the signal to noise, and detections elsewhere are rare.
///
/// Bounds were set before the first run. `completeness_of_many` has more streaks.
#[test]
fn verif_completeness_rises_with_the_signal_to_noise() {
    const COUNT: usize = 48;
    /// Signal to noise, and smallest and largest share that is found.
    const FOUND: [(f64, [f64; 2]); 4] =
        [(3.0, [0.0, 0.2]), (6.0, [0.3, 1.0]), (12.0, [0.95, 1.0]), (25.0, [0.98, 1.0])];
    const ELSEWHERE: f64 = 0.03;
    for stars_per_megapixel in if is_all() { &[100.0, 0.0][..] } else { &[100.0] } {
        let stars_per_megapixel = *stars_per_megapixel;
        let mut wrong = 0.0;
        for (signal_to_noise, [least, most]) in FOUND {
            let (found, elsewhere) = completeness(cases_at(signal_to_noise, stars_per_megapixel, COUNT));
            println!(
                "{stars_per_megapixel} stars, signal to noise {signal_to_noise}: {found:.3}, elsewhere {elsewhere:.3}"
            );
            assert!((least..=most).contains(&found), "{stars_per_megapixel}, {signal_to_noise}: {found}");
            wrong += elsewhere / FOUND.len() as f64;
        }
        assert!(wrong <= ELSEWHERE, "{stars_per_megapixel}: {wrong}");
    }
}

/// Prints the table from which docs/completeness.py draws curves: the lines that begin with `|`.
///
/// `cargo test --release --test images completeness_of_many -- --ignored --nocapture | grep '^|'
/// > docs/tables/completeness.md`
#[test]
#[ignore = "some 10,000 streaks"]
fn completeness_of_many() {
    const COUNT: usize = 288;
    let numbers = |of: &dyn Fn(f64) -> String| STARS.map(of).join(" | ");
    println!("| signal to noise | {} |", numbers(&|stars| format!("found, elsewhere: {stars} stars")));
    println!("|---|{}", "---|".repeat(STARS.len()));
    for signal_to_noise in [0.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 50.0] {
        let cell = |stars: f64| {
            let (found, elsewhere) = completeness(cases_at(signal_to_noise, stars, COUNT));
            format!("{:.1} %, {:.1} %", 100.0 * found, 100.0 * elsewhere)
        };
        println!("| {signal_to_noise} | {} |", numbers(&cell));
    }
}

#[test]
fn a_constant_frame_has_no_limit() {
    for level in [0.0, 1.0, 1000.7] {
        let mut plane = Plane::zeros(200, 300);
        plane.values_mut().fill(level);
        let node = |time_s: f64| PathNode::new(time_s, PixelPosition { x: 30.0 * time_s, y: 100.0 + time_s }, 1.0);
        let predicted = PredictedStreak {
            path: StreakPath::new([-2.0, 12.0].map(node).to_vec()).unwrap(),
            drift_pix_s: [0.0; 2],
            lateness_sigma_s: 0.1,
            largest_delay_s: 1.0,
            ends_s: None,
            cross_sigma_pix: 1.0,
            range_km: 600.0,
            radius_m: 0.0,
            radius_sigma_m: 0.0,
        };
        let optics =
            Optics { form: SeeingForm::Gaussian, seeing_arcsec: 2.0, outer_radius_m: 0.0, inner_radius_m: 0.0 };
        let measured = measure(&plane, &LightArea::whole(200, 300), &predicted, &optics, &options()).unwrap();
        assert!(!measured.is_detected && measured.rate_limit.is_nan() && measured.rate.sigma.is_nan(), "{measured:?}");
    }
}
