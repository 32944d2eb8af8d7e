//! Plots of a fit: corner plots, residuals, phase curves and histograms.

use image::RgbImage;
use streakcast::plot::{
    AlarmChart, AlarmMark, Corner, CountsAndSpread, PhaseCurve, ResidualHistogram, ResidualPanels, alarm_chart, corner,
    counts_and_spread, phase_curve, residual_histogram, residual_panels,
};

use super::{has, pixels, words};

/// Returns quantiles of the standard normal distribution, in an order that depends on `stride`.
fn normal(count: usize, stride: usize) -> Vec<f64> {
    // Winitzki's inverse of the error function, with an error of 0.002.
    let inverse = |share: f64| {
        let x = 2.0 * share - 1.0;
        let log = (1.0 - x * x).ln();
        let first = 2.0 / (std::f64::consts::PI * 0.147) + log / 2.0;
        x.signum() * ((first * first - log / 0.147).sqrt() - first).sqrt() * std::f64::consts::SQRT_2
    };
    (0..count).map(|index| inverse(((index * stride % count) as f64 + 0.5) / count as f64)).collect()
}

fn posterior(parameters: usize, samples: usize) -> (Vec<String>, Vec<Vec<f64>>) {
    let strides = [1, 617, 1223, 2801, 3407, 4409, 5503, 6607, 7703];
    let column = |k: usize| normal(samples, strides[k]).into_iter().map(|x| 0.0123 + 0.000_35 * x).collect();
    ((1..=parameters).map(|k| format!("c{k}")).collect(), (0..parameters).map(column).collect())
}

#[test]
fn verif_a_corner_plot_shows_quantiles_and_names() {
    let (names, samples) = posterior(3, 20_000);
    let picture =
        corner(&Corner { title: "A model", names: &names, samples: &samples, truths: None, bounds: None }).unwrap();
    // One sigma is 0.00035. The quantiles 0.16 and 0.84 are at 0.9945 sigma from the median.
    has(&picture, &["A model", "c1 = 0.0123 +0.0003 −0.0003", "c3 = 0.0123 +0.0003 −0.0003", "c1", "c2", "c3"]);
    let image = pixels(&picture);
    // Only true values are drawn in orange.
    let orange = |image: &RgbImage| image.pixels().filter(|pixel| pixel.0 == [213, 94, 0]).count();
    assert_eq!(orange(&image), 0);
    let truths = [0.0124, 0.0122, 0.0123];
    let with_truths =
        corner(&Corner { title: "", names: &names, samples: &samples, truths: Some(&truths), bounds: None }).unwrap();
    assert!(orange(&pixels(&with_truths)) > 1000);
}

/// If samples accumulate at a lower bound of 0, the axis has no tick below it; without the bound it has one.
#[test]
fn verif_corner_plots_end_at_bounds() {
    let (names, mut samples) = posterior(2, 4_000);
    let middle = samples[0].iter().sum::<f64>() / 4_000.0;
    samples[0].iter_mut().for_each(|sample| *sample = (*sample - middle).abs());
    let most = samples[0].iter().copied().fold(0.0, f64::max);
    let bounds = [[0.0, 10.0 * most], [f64::NEG_INFINITY, f64::INFINITY]];
    let drawn = |bounds: Option<&[[f64; 2]]>| {
        pixels(&corner(&Corner { title: "", names: &names, samples: &samples, truths: None, bounds }).unwrap())
    };
    let (free, bound) = (drawn(None), drawn(Some(&bounds)));
    // The bars of the first panel start at its left side.
    let first_bar = |picture: &RgbImage| {
        picture.enumerate_pixels().filter(|(.., colour)| colour.0 == [158, 202, 225]).map(|(x, ..)| x).min().unwrap()
    };
    assert!(first_bar(&bound) + 10 < first_bar(&free), "{} {}", first_bar(&bound), first_bar(&free));
    let wrong = Corner { title: "", names: &names, samples: &samples, truths: None, bounds: Some(&bounds[..1]) };
    assert!(corner(&wrong).map(|_| ()).unwrap_err().to_string().contains("bounds of parameters"));
}

#[test]
fn verif_corner_plots_of_two_to_nine_parameters_stay_in_their_size() {
    for parameters in 2..=9 {
        let (names, samples) = posterior(parameters, 2_000);
        let names: Vec<String> = names.iter().map(|name| format!("{name}_of_a_long_name")).collect();
        pixels(&corner(&Corner { title: "", names: &names, samples: &samples, truths: None, bounds: None }).unwrap());
    }
}

#[test]
fn verif_a_corner_plot_rejects_invalid_input() {
    let (names, mut samples) = posterior(2, 100);
    let drawn = |names: &[String], samples: &[Vec<f64>], truths: Option<&[f64]>| {
        corner(&Corner { title: "", names, samples, truths, bounds: None })
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    assert!(drawn(&names[..1], &samples[..1], None).unwrap_err().contains("is 1; allowed: 2 to 9"));
    assert!(drawn(&names[..1], &samples, None).unwrap_err().contains("names of parameters: 1 values"));
    assert!(
        drawn(&names, &samples, Some(&[f64::INFINITY, 0.0])).unwrap_err().contains("value 0 (counted from 0) is inf")
    );
    assert!(drawn(&names, &[Vec::new(), Vec::new()], None).unwrap_err().contains("nothing to draw: no samples of c1"));
    // A single value, and identical values, can be drawn.
    assert_eq!(drawn(&names, &[vec![1.0], vec![0.0]], None), Ok(()));
    assert_eq!(drawn(&names, &[vec![1e-9; 50], vec![-3e7; 50]], None), Ok(()));
    samples[1][7] = f64::NAN;
    assert!(drawn(&names, &samples, None).unwrap_err().contains("samples of c2: value 7 (counted from 0) is NaN"));
    samples[1].pop();
    assert!(drawn(&names, &samples, None).unwrap_err().contains("99 values; allowed: 100"));
}

#[test]
fn verif_the_histogram_shows_mean_deviation_and_mad() {
    let residuals: Vec<f64> = normal(10_001, 617).into_iter().map(|x| 0.05 + 0.2 * x).collect();
    let input = ResidualHistogram { title: "Layer", residuals_mag: &residuals, sigma_mag: 0.25 };
    let picture = residual_histogram(&input).unwrap();
    let expected = "n = 10,001: mean 0.050, standard deviation 0.200, 1.4826 MAD 0.200 mag. ";
    assert!(words(&picture).iter().any(|words| words.starts_with(expected.trim())), "{:?}", words(&picture));
    has(&picture, &["Layer", "O−C, mag", "σ = 0.250 mag"]);
    // The maximum of the curve, 1 / (0.25 √2π) = 1.596 per mag, is orange; above it is the background.
    let image = pixels(&picture);
    assert!((60..500).any(|y| image.get_pixel(440, y).0 == [213, 94, 0]));
    let refused = |residuals: &[f64], sigma: f64| {
        let input = ResidualHistogram { title: "", residuals_mag: residuals, sigma_mag: sigma };
        residual_histogram(&input).map(|_| ()).map_err(|error| error.to_string())
    };
    assert!(refused(&[], 0.2).unwrap_err().contains("nothing to draw: no residuals"));
    assert!(refused(&[f64::NAN], 0.2).unwrap_err().contains("NaN"));
    assert!(refused(&[0.1], 0.0).unwrap_err().contains("is 0 mag; allowed: above 0 mag"));
    assert_eq!(refused(&[0.1], 0.2), Ok(()));
    assert_eq!(refused(&[0.0; 9], 0.2), Ok(()));
}

#[test]
fn verif_cells_kept_are_counted() {
    // Values equal to the thresholds are kept: 3 of 5.
    let (counts, iqr_mag) = ([80.0, 79.0, 500.0, 500.0, 1e4], [0.4, 0.1, 0.41, 0.2, 0.0]);
    let input =
        CountsAndSpread { title: "Cells", counts: &counts, iqr_mag: &iqr_mag, least_count: 80.0, most_iqr_mag: 0.4 };
    let picture = counts_and_spread(&input).unwrap();
    pixels(&picture);
    has(&picture, &["Cells", "kept: 60.0 %", "3 of 5 cells", "80", "0.4 mag", "samples in a cell"]);
    let refused = |counts: &[f64], iqr_mag: &[f64], least_count: f64| {
        let input = CountsAndSpread { counts, iqr_mag, least_count, ..input.clone() };
        counts_and_spread(&input).map(|_| ()).map_err(|error| error.to_string())
    };
    assert!(refused(&[], &[], 80.0).unwrap_err().contains("nothing to draw: no samples of cells"));
    assert!(refused(&[3.0, 0.0], &[0.1, 0.1], 80.0).unwrap_err().contains("is 0; allowed: 1 or more"));
    assert!(refused(&[3.0], &[-0.1], 80.0).unwrap_err().contains("is -0.1"));
    assert!(refused(&[3.0], &[0.1, 0.2], 80.0).unwrap_err().contains("2 values; allowed: 1"));
    assert!(refused(&[3.0], &[0.1], f64::NAN).unwrap_err().contains("is NaN"));
    assert_eq!(refused(&[1.0], &[0.0], 1.0), Ok(()));
}

#[test]
fn verif_points_are_drawn_with_their_model_and_over_their_angles() {
    let count = 5_000;
    let angle =
        |stride: usize| (0..count).map(|n| 0.2 + 2.0 * (n * stride % count) as f64 / count as f64).collect::<Vec<_>>();
    let (phase, residuals) = (angle(617), normal(count, 1223));
    let model: Vec<f64> = phase.iter().map(|phase| 5.0 + phase).collect();
    let measured: Vec<f64> = model.iter().zip(&residuals).map(|(model, residual)| model + 0.2 * residual).collect();
    let curve = PhaseCurve {
        title: "One",
        magnitude_name: "magnitude V",
        phase_angle_rad: &phase,
        measured_mag: &measured,
        model_mag: &model,
    };
    let both = phase_curve(&curve).unwrap();
    has(&both, &["One", "magnitude V", "measured", "model", "running median, model", "phase angle, °"]);
    let alone = phase_curve(&PhaseCurve { model_mag: &[], ..curve.clone() }).unwrap();
    assert!(!words(&alone).contains(&"model".to_owned()) && alone.size().0 < both.size().0);
    pixels(&both);
    pixels(&alone);
    // If both medians coincide, one is visible in the gaps of the dashed other.
    let same = pixels(&phase_curve(&PhaseCurve { measured_mag: &model, ..curve.clone() }).unwrap());
    let blue = (672..1232)
        .flat_map(|x| (84..540).map(move |y| (x, y)))
        .filter(|&(x, y)| same.get_pixel(x, y).0 == [0, 114, 178])
        .count();
    assert!(blue > 100, "{blue} pixels of the line below the dashes");
    let one = PhaseCurve { phase_angle_rad: &[1.0], measured_mag: &[6.0], model_mag: &[6.0], ..curve.clone() };
    pixels(&phase_curve(&one).unwrap());
    // One of 300 magnitudes is an outlier, then two of them.
    for (off, expected) in [(1, "; 1 magnitude beyond the axis"), (2, "; 2 magnitudes beyond the axis")] {
        let far: Vec<f64> = (0..2_000).map(|n| if n < off { 60.0 } else { 6.0 + n as f64 * 1e-4 }).collect();
        let picture = phase_curve(&PhaseCurve {
            phase_angle_rad: &phase[..2_000],
            measured_mag: &far,
            model_mag: &[],
            ..curve.clone()
        });
        let texts = words(&picture.unwrap()).join(" ");
        assert!(texts.contains(expected), "{texts}");
    }
    let wrong = phase_curve(&PhaseCurve { phase_angle_rad: &[4.0], ..one.clone() }).map(|_| ()).unwrap_err();
    assert!(wrong.to_string().contains("allowed: 0 to 180°"), "{wrong}");

    let panels = ResidualPanels {
        title: "Four",
        residuals_mag: &residuals,
        sun_latitude_rad: &angle(1),
        observer_longitude_rad: &angle(1223),
        observer_latitude_rad: &angle(2801),
        phase_angle_rad: &phase,
    };
    let picture = residual_panels(&panels).unwrap();
    pixels(&picture);
    has(&picture, &["Four", "latitude of the Sun, °", "longitude of the observer, °", "latitude of the observer, °"]);
    has(&picture, &["O−C, mag", "running median", "16 to 84 %"]);
    let short = residual_panels(&ResidualPanels { sun_latitude_rad: &[], ..panels.clone() }).map(|_| ()).unwrap_err();
    assert!(short.to_string().contains("latitude of the Sun, °: 0 values"), "{short}");
    let (zero, nothing): (&[f64], &[f64]) = (&[0.0], &[]);
    let all = |column| ResidualPanels {
        title: "",
        residuals_mag: column,
        sun_latitude_rad: column,
        observer_longitude_rad: column,
        observer_latitude_rad: column,
        phase_angle_rad: column,
    };
    pixels(&residual_panels(&all(zero)).unwrap());
    assert!(residual_panels(&all(nothing)).is_err());
}

#[test]
fn verif_a_chart_of_alarms_shows_passes_and_labels() {
    let days: Vec<f64> = (0..40).map(f64::from).collect();
    let differences = normal(40, 7);
    let sigmas = vec![0.4; 40];
    let alarms = [AlarmMark { day: 30.0, difference_mag: -4.0, label: "90001: -4.0 mag".to_owned() }];
    let chart = AlarmChart {
        title: "Quiet sky",
        origin: "2026-01-01T00:00:00Z",
        days: &days,
        differences_mag: &differences,
        sigmas_mag: &sigmas,
        alarms: &alarms,
    };
    let picture = alarm_chart(&chart).unwrap();
    has(&picture, &["Quiet sky", "90001: -4.0 mag", "days since 2026-01-01T00:00:00Z"]);
    has(&picture, &["Passes, with one expected sigma: 40. Alarms: 1."]);
    let orange = |picture| pixels(picture).pixels().filter(|pixel| pixel.0 == [213, 94, 0]).count();
    assert!(orange(&picture) > 50);
    let quiet = alarm_chart(&AlarmChart { alarms: &[], ..chart.clone() }).unwrap();
    assert_eq!(orange(&quiet), 0);
    let short = alarm_chart(&AlarmChart { sigmas_mag: &[0.4], ..chart.clone() }).map(|_| ()).unwrap_err();
    assert!(short.to_string().contains("sigmas"), "{short}");
    assert!(alarm_chart(&AlarmChart { days: &[], differences_mag: &[], sigmas_mag: &[], ..chart }).is_err());
}
