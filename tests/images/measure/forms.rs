//! Point spread functions whose form is unknown.

use super::*;

const FORMS: [SeeingForm; 3] =
    [SeeingForm::Gaussian, SeeingForm::Moffat { beta: 3.5 }, SeeingForm::Moffat { beta: 2.5 }];

/// Returns streaks with this form that are measured as Moffat profiles of β = 3.5, by default only a guess.
fn measured_by_default(form: SeeingForm, signal_to_noise: f64, fit_width: bool, count: u64) -> Vec<Outcome> {
    let options = MeasureOptions { is_form_known: false, is_seeing_known: true, fit_width, ..options() };
    let case = |number: u64| Case {
        signal_to_noise,
        angle_deg: (number * 37 % 180) as f64 + 0.5,
        seeing_pix: SEEING_PIX[number as usize % 2],
        form,
        stars_per_megapixel: 0.0,
        has_end: false,
        seed: 9_000_000 + 1000 * number + signal_to_noise as u64,
    };
    let measure = |number| {
        let case = case(number);
        measured(case, &options, Optics { form: SeeingForm::Moffat { beta: 3.5 }, ..optics(&case) })
    };
    (0..count).into_par_iter().map(measure).collect()
}

/// Without a given form, the fluxes of streaks with any of the forms agree with the truth within their errors.
#[test]
fn verif_an_unknown_form_is_part_of_the_flux_and_its_error() {
    const COUNT: u64 = 24;
    /// Largest bias of the fluxes of bright streaks, whose form shows.
    const BIAS: f64 = 0.02;
    /// Smallest share within one sigma: two standard errors of 24 below 63 %. Errors of faint streaks, whose form does
    /// not show, contain the form although a part of them has the assumed one.
    const WITHIN: f64 = 0.43;
    for fit_width in [false, true] {
        for signal_to_noise in [8.0, 20.0, 100.0] {
            for form in FORMS {
                let outcomes = measured_by_default(form, signal_to_noise, fit_width, COUNT);
                let (bias, error, share, found) = bias_and_share(outcomes.iter());
                println!("{fit_width} {signal_to_noise} {form:?}: {bias:.3} +- {error:.3}, {share:.2} of {found}");
                assert!(share >= WITHIN, "{form:?} at {signal_to_noise}: {share:.2}");
                assert!(signal_to_noise < 100.0 || bias.abs() < BIAS, "{form:?} at {signal_to_noise}: {bias:.3}");
            }
        }
    }
}

/// Other streaks of a table beside a streak are no part of the noise of its background.
#[test]
fn verif_streaks_beside_a_streak_do_not_widen_its_error() {
    const COUNT: u64 = 24;
    const FWHM_PIX: f64 = 4.0;
    /// Distance between neighbouring streaks, pixels.
    const APART_PIX: f64 = 24.0 * FWHM_PIX;
    /// Largest ratio of the median errors with and without neighbours.
    const RATIO: f64 = 1.15;
    let light_area = LightArea::whole(ROWS, COLUMNS);
    let profile =
        Optics { form: SeeingForm::Gaussian, seeing_arcsec: FWHM_PIX, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let sigmas = |offsets: &[f64], neighbour_pix: Option<f64>| -> f64 {
        let of_seed = |seed: u64| {
            let path = |offset_pix: f64, rate: f64| {
                let at = |time_s: f64| PixelPosition { x: SPEED_PIX_S * time_s - 100.0, y: 160.0 + offset_pix };
                StreakPath::new([0.0, EXPOSURE_S].map(|time_s| PathNode::new(time_s, at(time_s), rate)).to_vec())
                    .unwrap()
            };
            let streaks: Vec<StreakPath> = offsets.iter().map(|offset_pix| path(*offset_pix, 3e4)).collect();
            let drawn_as = profile.profile(600.0, 0.0, 1.0, 1.0).unwrap();
            let plane = on_noisy_sky(&streaks, &drawn_as, [ROWS, COLUMNS], [100.0, 20.0], seed);
            let options = MeasureOptions { neighbour_pix, ..options() };
            let measured = measure(&plane, &light_area, &point_source(path(0.0, 1.0)), &profile, &options).unwrap();
            assert!(measured.is_detected);
            measured.rate.sigma
        };
        let mut all: Vec<f64> = (0..COUNT).into_par_iter().map(of_seed).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let alone = sigmas(&[0.0], None);
    let beside = sigmas(&[-APART_PIX, 0.0, APART_PIX], Some(APART_PIX));
    println!("error alone {alone:.0}, with neighbours {beside:.0}");
    assert!(beside < RATIO * alone, "{alone} {beside}");
}
