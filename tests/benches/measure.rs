//! Time of the measurement of five streaks in a frame of 4,000 by 4,000 pixels, with the background; target: 1 s.

use divan::Bencher;
use rayon::prelude::*;
use streakcast::images::{LightArea, PixelPosition, Plane};
use streakcast::measure::{Background, MeasureOptions, PredictedStreak, StreakImage, measure_streak};
use streakcast::streaks::{Optics, PathNode, SeeingForm, StreakPath, draw};

const SIDE: usize = 4000;
const EXPOSURE_S: f64 = 30.0;

fn main() {
    divan::main();
}

/// Path across the frame between two times, `offset_pix` beside the predicted path.
fn path(number: usize, offset_pix: f64, rate: f64, times_s: [f64; 2]) -> StreakPath {
    let (sin, cos) = (0.3 + 0.5 * number as f64).sin_cos();
    let node = |time_s: f64| {
        let along = 2000.0 * (time_s - 15.0);
        let (x, y) = (2000.0 + cos * along - sin * offset_pix, 2000.0 + sin * along + cos * offset_pix);
        PathNode::new(time_s, PixelPosition { x, y }, rate)
    };
    StreakPath::new(times_s.map(node).to_vec()).unwrap()
}

#[divan::bench(sample_count = 10)]
fn five_streaks_in_a_frame(bencher: Bencher) {
    let optics =
        Optics { form: SeeingForm::Moffat { beta: 3.5 }, seeing_arcsec: 3.0, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let profile = optics.profile(600.0, 1.0, 1.0, 1.0).unwrap();
    let mut plane = Plane::zeros(SIDE, SIDE);
    // Noise of a linear congruential generator: the sum of four uniform numbers, with a sigma of 20.
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    plane
        .values_mut()
        .iter_mut()
        .for_each(|value| *value = 400.0 + 34.6 * (uniform() + uniform() + uniform() + uniform()));
    for number in 0..5 {
        draw(&path(number, 12.0, 4e5, [0.0, EXPOSURE_S]), &profile, SIDE, SIDE).add_to(&mut plane);
    }
    let light_area = LightArea::whole(SIDE, SIDE);
    bencher.bench_local(|| {
        let background = Background::new(&plane, &light_area);
        let image = StreakImage {
            plane: &plane,
            background: &background,
            light_area: &light_area,
            exposure_s: EXPOSURE_S,
            electrons_per_unit: Some(1.0),
            saturation: None,
            pixel_scale_arcsec: 1.0,
            pixel_aspect: 1.0,
        };
        let found = (0..5).into_par_iter().filter(|&number| {
            let predicted = PredictedStreak {
                path: path(number, 0.0, 1.0, [-3.0, EXPOSURE_S + 3.0]),
                drift_pix_s: [1.0, 1.0],
                lateness_sigma_s: 0.3,
                largest_delay_s: 5.0,
                ends_s: None,
                cross_sigma_pix: 100.0,
                range_km: 600.0,
                radius_m: 1.0,
                radius_sigma_m: 0.0,
            };
            let measured = measure_streak(&image, &predicted, &optics, &MeasureOptions::default()).unwrap();
            measured.is_some_and(|measured| measured.is_detected)
        });
        assert_eq!(found.count(), 5);
    });
}
