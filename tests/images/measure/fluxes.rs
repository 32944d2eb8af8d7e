//! Fluxes, offsets and delays of streaks of known brightness, and the share of their errors within one sigma.

use super::detection::check_false_detections;
use super::widths::check_a_fitted_width;
use super::*;

/// Number of streaks in the whole sample at a signal to noise of 10.
const ALL_AT_10: usize = 480;

/// All combinations of brightness, angle, seeing and crowding, or every n-th of them. Repeats differ in form and end.
fn grid(repeats: Range<u64>, step: usize) -> Vec<Outcome> {
    let mut cases = Vec::new();
    for signal_to_noise in BRIGHTNESS {
        for angle_deg in ANGLES_DEG {
            for (number, seeing_pix) in SEEING_PIX.into_iter().enumerate() {
                for stars_per_megapixel in STARS {
                    for repeat in repeats.clone() {
                        let form =
                            if repeat % 2 == 0 { SeeingForm::Gaussian } else { SeeingForm::Moffat { beta: 3.5 } };
                        let seed = 1000 * cases.len() as u64 + number as u64;
                        let has_end = repeat % 4 >= 2;
                        cases.push(Case {
                            signal_to_noise,
                            angle_deg,
                            seeing_pix,
                            form,
                            stars_per_megapixel,
                            has_end,
                            seed,
                        });
                    }
                }
            }
        }
    }
    cases.into_par_iter().step_by(step).map(|case| measured(case, &options(), optics(&case))).collect()
}

/// Name of a sample, and its streaks.
type Sample<'a> = (String, Vec<&'a Outcome>);

/// The whole sample and parts of it.
fn parts(outcomes: &[Outcome]) -> Vec<Sample<'_>> {
    let part = |name: &str, is_in: &dyn Fn(&Case) -> bool| {
        (name.to_owned(), outcomes.iter().filter(|one| is_in(&one.case)).collect::<Vec<_>>())
    };
    let mut parts = vec![
        part("all", &|_| true),
        part("Gaussian profile", &|case| case.form == SeeingForm::Gaussian),
        part("Moffat profile", &|case| case.form != SeeingForm::Gaussian),
        part("with an end in the frame", &|case| case.has_end),
    ];
    type Key = fn(&Case) -> f64;
    let keys: [(&str, &[f64], Key); 4] = [
        ("signal to noise", &BRIGHTNESS, |case| case.signal_to_noise),
        ("angle to the rows, deg:", &ANGLES_DEG, |case| case.angle_deg),
        ("seeing, pixels:", &SEEING_PIX, |case| case.seeing_pix),
        ("stars per megapixel:", &STARS, |case| case.stars_per_megapixel),
    ];
    for (name, values, key) in keys {
        parts.extend(values.iter().map(|value| part(&format!("{name} {value}"), &|case| key(case) == *value)));
    }
    parts
}

/// Checks the bounds of samples, and prints the lines of the table of docs/explanation/measuring.md.
fn check_fluxes(samples: &[Sample], within_one_sigma: &RangeInclusive<f64>) {
    let mut failures = Vec::new();
    for (name, outcomes) in samples {
        let (bias, error, share, found) = bias_and_share(outcomes.iter().copied());
        print_row(name, [bias, error, share], found, outcomes.len());
        if bias.abs() >= FLUX_BIAS || !within_one_sigma.contains(&share) {
            failures.push(name);
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}

/// Checks the share of streaks found, except among 1,000 stars per megapixel, where the search is not complete at these
/// ratios of signal to noise (docs/explanation/measuring.md).
fn check_completeness(outcomes: &[Outcome]) {
    for (signal_to_noise, least) in [(10.0, FOUND_AT_10), (30.0, FOUND_AT_30)] {
        let is_selected = |case: &Case| case.signal_to_noise == signal_to_noise && case.stars_per_megapixel < 1000.0;
        let of: Vec<&Outcome> = outcomes.iter().filter(|one| is_selected(&one.case)).collect();
        let found = of.iter().filter(|one| one.measured.is_detected).count() as f64 / of.len() as f64;
        assert!(found >= least, "found {found} at {signal_to_noise}");
    }
}

/// `fluxes_of_many` has more streaks.
#[test]
fn verif_flux_is_unbiased_and_errors_are_honest() {
    // Moffat profiles without an end in the frame, and Gaussian ones with an end: 288 streaks, or every third of them.
    let outcomes = grid(1..3, if is_all() { 1 } else { 3 });
    check_fluxes(&[("all".to_owned(), outcomes.iter().collect())], &within_one_sigma_of(outcomes.len()));
}

/// Prints the table of docs/explanation/measuring.md, which docs/tables.sh collects.
#[test]
#[ignore = "some 2,600 streaks"]
fn fluxes_of_many() {
    println!("| streaks | bias of the flux | within one sigma | found |\n|---|---|---|---|");
    let outcomes = grid(0..10, 1);
    check_fluxes(&parts(&outcomes), &WITHIN_ONE_SIGMA);
    check_completeness(&outcomes);
    check_a_low_signal_to_noise(ALL_AT_10);
    check_a_fitted_width();
    check_false_detections(600);
}

/// Signal to noise, seeing and density of stars of the cells in which the share within one sigma is tested.
const COVERAGE_SIGNALS: [f64; 4] = [8.0, 20.0, 60.0, 300.0];
const COVERAGE_SEEING_PIX: [f64; 5] = [0.8, 1.2, 2.0, 3.5, 6.0];
/// Number of streaks in a cell.
const COVERAGE_COUNT: u64 = 100;

/// Prints the share of fluxes within one sigma, with its binomial error, and the share with the flag `width`, by
/// density of stars, seeing and signal to noise. The share of each row must be that of one sigma.
#[test]
#[ignore = "some 6,000 streaks"]
fn coverage_of_many() {
    let names = COVERAGE_SIGNALS.map(|signal| format!("signal to noise {signal}"));
    println!("| stars per megapixel | seeing, pixels | {} | all | `width` |", names.join(" | "));
    println!("|---|---|{}---|---|", "---|".repeat(names.len()));
    let mut failures = Vec::new();
    for stars_per_megapixel in STARS.into_iter().rev() {
        for seeing_pix in COVERAGE_SEEING_PIX {
            let cells = COVERAGE_SIGNALS.map(|signal| cell(signal, seeing_pix, stars_per_megapixel, COVERAGE_COUNT));
            let text = |outcomes: &[&Outcome]| {
                let (.., share, found) = bias_and_share(outcomes.iter().copied());
                let error = (share * (1.0 - share) / found as f64).sqrt();
                (share, found, format!("{:.0} ± {:.0} % of {found}", 100.0 * share, 100.0 * error))
            };
            let shown: Vec<String> = cells.iter().map(|cell| text(&cell.iter().collect::<Vec<_>>()).2).collect();
            let all: Vec<&Outcome> = cells.iter().flatten().filter(|one| one.measured.is_detected).collect();
            let (share, found, row) = text(&all);
            let flagged = all.iter().filter(|one| one.measured.flags.contains(&Flag::Width)).count();
            let flagged = 100.0 * flagged as f64 / found as f64;
            println!("| {stars_per_megapixel} | {seeing_pix} | {} | {row} | {flagged:.1} % |", shown.join(" | "));
            if !within_one_sigma_of(found).contains(&share) || flagged > 100.0 * WRONG_WIDTHS {
                failures.push((stars_per_megapixel, seeing_pix));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}

/// At a low signal to noise the fitted position follows the noise, for which the flux is corrected. Nearly all of these
/// streaks are found, so that the selection by detection does not bias the mean.
fn check_a_low_signal_to_noise(count: usize) {
    /// Smallest difference of the uncorrected flux from the truth, in standard errors: the correction is needed.
    const UNCORRECTED_ERRORS: f64 = 2.0;
    let cases: Vec<Case> = [0.0, 100.0].into_iter().flat_map(|stars| cases_at(10.0, stars, count / 2)).collect();
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let (bias, error, share, found) = bias_and_share(outcomes.iter());
    let uncorrected = |one: &Outcome| one.measured.signal_to_noise * one.measured.rate.sigma / one.truth - 1.0;
    let detected = outcomes.iter().filter(|one| one.measured.is_detected);
    let before = detected.map(uncorrected).sum::<f64>() / found as f64;
    print_row("signal to noise 10, 0 and 100 stars", [bias, error, share], found, count);
    println!("| the same without the correction for the fitted position | {:+.1} % | | |", 100.0 * before);
    assert!(bias.abs() < FLUX_BIAS, "{bias}");
    // In a smaller sample the standard error is too large to see the correction.
    assert!(count < ALL_AT_10 || before > UNCORRECTED_ERRORS * error, "{before}, {error}");
    assert!(found as f64 >= FOUND_AT_10 * count as f64, "{found}");
}

#[test]
fn verif_flux_at_a_low_signal_to_noise_is_unbiased() {
    check_a_low_signal_to_noise(if is_all() { ALL_AT_10 } else { 192 });
}

/// Offset and delay agree with the truth within their errors.
#[test]
fn verif_offsets_and_delays_are_measured() {
    /// Smallest share within three sigmas plus a hundredth of a pixel.
    const WITHIN_THREE_SIGMAS: f64 = 0.97;
    let cases = (0..120).map(|number: usize| Case {
        signal_to_noise: 60.0,
        angle_deg: ANGLES_DEG[number % 4],
        seeing_pix: 4.0,
        form: SeeingForm::Gaussian,
        stars_per_megapixel: 0.0,
        has_end: true,
        seed: 9_000_000 + 10 * number as u64,
    });
    let cases: Vec<Case> = cases.collect();
    let outcomes: Vec<Outcome> = cases.into_par_iter().map(|case| measured(case, &options(), optics(&case))).collect();
    let of = |difference: fn(&Outcome) -> Option<(f64, f64, f64)>| {
        let all: Vec<(f64, f64, f64)> = outcomes.iter().filter_map(difference).collect();
        let within = all.iter().filter(|(error, sigma, margin)| error.abs() <= 3.0 * sigma + margin).count();
        (all.len(), within as f64 / all.len() as f64)
    };
    let (delays, delays_within) = of(|one| {
        let late = one.measured.late_s?;
        Some((late.value - one.late_s, late.sigma, 0.01 / SPEED_PIX_S))
    });
    let (offsets, offsets_within) = of(|one| {
        // Positive offsets of the library have larger y, or larger x for steep tracks.
        let sense = if one.case.angle_deg > 45.0 { -1.0 } else { 1.0 };
        let (offset, truth) = (one.measured.offset_pix, sense * one.offset_pix);
        // The offset is measured at the middle of the corridor, where a tilt does not change it.
        Some((offset.value - truth, offset.sigma, 0.01 + 20.0 * one.measured.tilt_rad.abs()))
    });
    println!("{delays} delays, {delays_within} within; {offsets} offsets, {offsets_within} within");
    assert!(delays >= 100 && offsets == 120);
    assert!(delays_within >= WITHIN_THREE_SIGMAS && offsets_within >= WITHIN_THREE_SIGMAS);
}
