//! Delays of streaks with an end in the image.

use super::*;

/// The errors of delays are honest for faint streaks, too, whose end is a step in the noise, not a smooth edge.
#[test]
fn verif_errors_of_delays_are_honest() {
    const COUNT: usize = 96;
    /// Share within one sigma. The distribution of the position of a step has wider wings than a normal one, and more
    /// values near the middle.
    const WITHIN: RangeInclusive<f64> = 0.6..=0.95;
    const WITHIN_THREE_SIGMAS: f64 = 0.96;
    for signal_to_noise in [10.0, 15.0, 30.0, 60.0, 300.0] {
        let cases = (0..COUNT).map(|number| Case {
            signal_to_noise,
            angle_deg: ANGLES_DEG[number % 4],
            seeing_pix: SEEING_PIX[number % 2],
            form: SeeingForm::Gaussian,
            stars_per_megapixel: 0.0,
            has_end: true,
            seed: 9_500_000 + 10 * number as u64,
        });
        let cases: Vec<Case> = cases.collect();
        let pulls: Vec<f64> = cases
            .into_par_iter()
            .map(|case| measured(case, &options(), optics(&case)))
            .filter_map(|one| one.measured.late_s.map(|late| (late.value - one.late_s) / late.sigma))
            .collect();
        let share = |sigmas: f64| pulls.iter().filter(|pull| pull.abs() <= sigmas).count() as f64 / pulls.len() as f64;
        println!("signal to noise {signal_to_noise}: {:.2}, {:.2} of {}", share(1.0), share(3.0), pulls.len());
        assert!(pulls.len() as f64 > 0.8 * COUNT as f64, "{signal_to_noise}: {}", pulls.len());
        assert!(WITHIN.contains(&share(1.0)), "{signal_to_noise}: {}", share(1.0));
        assert!(share(3.0) >= WITHIN_THREE_SIGMAS, "{signal_to_noise}: {}", share(3.0));
    }
}
