//! Charts of fits: the words and numbers they hold, their size, their colours, and input that cannot be drawn.

#![cfg(feature = "plot")]

use image::RgbImage;
use streakcast::healpix::{cell_count, ring_centre_rad};
use streakcast::plot::{
    ColourScale, Corner, CountsAndSpread, FieldChart, FieldStreak, LayerPanel, Layers, LightCurve, LocalClock,
    NightTimeline, PhaseCurve, Picture, PlotError, Quantity, ResidualHistogram, ResidualPanels, SkyChart, SkyRate,
    SkyTrack, SunAltitude, corner, counts_and_spread, field_chart, layers, light_curve, night_timeline, phase_curve,
    residual_histogram, residual_panels, sky_chart, sky_rate, sun_altitude,
};

/// Averaging of four pixels and rounding, in steps of 255.
const COLOUR_STEPS: u8 = 2;

fn pixels(picture: &Picture) -> RgbImage {
    let image = image::load_from_memory(&picture.to_png().unwrap()).unwrap().to_rgb8();
    let (width, height) = picture.size();
    assert_eq!((image.width() as usize, image.height() as usize), (width, height));
    assert!(width <= 1600 && height <= 1600, "{width} {height}");
    image
}

/// The words of an SVG that is well-formed, one a line.
fn words(picture: &Picture) -> Vec<String> {
    let text = picture.to_svg().unwrap();
    let mut reader = quick_xml::Reader::from_str(&text);
    let mut words = Vec::new();
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Eof => return words,
            quick_xml::events::Event::Text(text) if !text.contains("@font-face") => words.push(text.trim().to_owned()),
            _ => {}
        }
    }
}

fn has(picture: &Picture, expected: &[&str]) {
    let words = words(picture);
    for one in expected {
        assert!(words.iter().any(|words| words == one), "{one} is not in {words:?}");
    }
}

/// Evenly spread values of a normal distribution about 0, sigma 1, in an order that has nothing to do with that of another `stride`.
fn normal(count: usize, stride: usize) -> Vec<f64> {
    // Winitzki's inverse of the error function, good to 0.002.
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
fn verif_a_corner_plot_says_quantiles_and_names() {
    let (names, samples) = posterior(3, 20_000);
    let picture =
        corner(&Corner { title: "A model", names: &names, samples: &samples, truths: None, bounds: None }).unwrap();
    // One sigma is 0.00035, and quantiles 0.16 and 0.84 lie 0.9945 of it away.
    has(&picture, &["A model", "c1 = 0.0123 +0.0003 −0.0003", "c3 = 0.0123 +0.0003 −0.0003", "c1", "c2", "c3"]);
    let image = pixels(&picture);
    // Orange is there only with truths.
    let orange = |image: &RgbImage| image.pixels().filter(|pixel| pixel.0 == [213, 94, 0]).count();
    assert_eq!(orange(&image), 0);
    let truths = [0.0124, 0.0122, 0.0123];
    let with_truths =
        corner(&Corner { title: "", names: &names, samples: &samples, truths: Some(&truths), bounds: None }).unwrap();
    assert!(orange(&pixels(&with_truths)) > 1000);
}

/// Samples that pile up at a bound of 0: no tick of their axis stands below it, as one does without the bound.
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
    // The bars of the first panel begin at its left side.
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
fn verif_a_corner_plot_refuses_what_it_cannot_draw() {
    let (names, mut samples) = posterior(2, 100);
    let drawn = |names: &[String], samples: &[Vec<f64>], truths: Option<&[f64]>| {
        corner(&Corner { title: "", names, samples, truths, bounds: None })
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    assert!(drawn(&names[..1], &samples[..1], None).unwrap_err().contains("is 1, allowed: 2 to 9"));
    assert!(drawn(&names[..1], &samples, None).unwrap_err().contains("names of parameters: 1 values"));
    assert!(
        drawn(&names, &samples, Some(&[f64::INFINITY, 0.0])).unwrap_err().contains("value 0, counted from 0, is inf")
    );
    assert!(drawn(&names, &[Vec::new(), Vec::new()], None).unwrap_err().contains("there are no samples of c1"));
    // One value, and one value many times, are drawn.
    assert_eq!(drawn(&names, &[vec![1.0], vec![0.0]], None), Ok(()));
    assert_eq!(drawn(&names, &[vec![1e-9; 50], vec![-3e7; 50]], None), Ok(()));
    samples[1][7] = f64::NAN;
    assert!(drawn(&names, &samples, None).unwrap_err().contains("samples of c2: value 7, counted from 0, is NaN"));
    samples[1].pop();
    assert!(drawn(&names, &samples, None).unwrap_err().contains("99 values, but there must be 100"));
}

fn southern_cells(nside: u32, value: impl Fn(f64, f64) -> f64) -> Vec<(u64, f64)> {
    let cells = (0..cell_count(nside)).map(|cell| (cell, ring_centre_rad(nside, cell).unwrap()));
    cells.filter(|(_, (_, latitude))| *latitude < 0.0).map(|(cell, (x, y))| (cell, value(x, y))).collect()
}

#[test]
fn verif_cells_have_their_colours_where_they_stand() {
    let residuals = southern_cells(8, |longitude, latitude| 0.5 * longitude.cos() * latitude.cos());
    let missing = residuals[40].0;
    let shown: Vec<_> = residuals.iter().copied().filter(|(cell, _)| *cell != missing).collect();
    for is_folded in [true, false] {
        let panel = LayerPanel { title: "(a) Sun at latitude −8°", quantity: Quantity::Residual, cells: &shown };
        let picture =
            layers(&Layers { title: "O−C", caption: "Test.", nside: 8, is_folded, panels: vec![panel] }).unwrap();
        let image = pixels(&picture);
        let scale = picture.scales()[0];
        assert!((scale.least + scale.greatest).abs() < 1e-12);
        // The layout: a margin of 66 and a radius of 270 at the left, 46 + 32 + 66 + 270 above.
        let mut looked_at = 0;
        for (cell, value) in &residuals {
            let (longitude, latitude) = ring_centre_rad(8, *cell).unwrap();
            let distance = 270.0 * (latitude + std::f64::consts::FRAC_PI_2) / std::f64::consts::FRAC_PI_2;
            // Away from the borders of the half, from lines and from words.
            let degrees = longitude.to_degrees();
            let is_clear = [90.0, 180.0, 270.0].iter().all(|circle| (distance - circle).abs() > 6.0);
            if !is_clear || (100.0..130.0).contains(&degrees) || (is_folded && !(8.0..172.0).contains(&degrees)) {
                continue;
            }
            let (x, y) = (336.0 - distance * longitude.sin(), 414.0 - distance * longitude.cos());
            let found = image.get_pixel(x as u32, y as u32).0;
            let expected = if *cell == missing { [205; 3] } else { scale.colour(*value) };
            let apart = found.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            assert!(apart <= COLOUR_STEPS, "cell {cell} at {x} {y}: {found:?} for {expected:?}");
            looked_at += 1;
        }
        assert!(looked_at > if is_folded { 100 } else { 200 }, "{looked_at}");
        has(&picture, &["O−C", "(a) Sun at latitude −8°", "O−C, mag", "0°", "90°", "180°", "−60°", "Sun", "no cell"]);
        assert_eq!(words(&picture).contains(&"270°".to_owned()), !is_folded);
    }
}

#[test]
fn verif_panels_of_several_quantities_have_a_bar_each() {
    let magnitudes = southern_cells(4, |longitude, _| 6.0 + longitude.cos());
    let counts = southern_cells(4, |longitude, _| (1.0 + 100.0 * longitude).floor());
    let spreads = southern_cells(4, |_, latitude| 0.3 - 0.2 * latitude);
    let panel = |title, quantity, cells| LayerPanel { title, quantity, cells };
    let panels = vec![
        panel("(a)", Quantity::Magnitude, &magnitudes[..]),
        panel("(b)", Quantity::Count, &counts),
        panel("(c)", Quantity::Spread, &spreads),
    ];
    for is_folded in [true, false] {
        let input = Layers { title: "", caption: "", nside: 4, is_folded, panels: panels.clone() };
        let picture = layers(&input).unwrap();
        pixels(&picture);
        has(&picture, &["(a)", "(b)", "(c)", "mag", "samples", "IQR, mag", "100"]);
        let quantities: Vec<Quantity> = picture.scales().iter().map(|scale: &ColourScale| scale.quantity).collect();
        assert_eq!(quantities, [Quantity::Magnitude, Quantity::Count, Quantity::Spread]);
        // Twelve layers fit as well.
        let twelve = vec![panels[0].clone(); 12];
        pixels(&layers(&Layers { panels: twelve, ..input }).unwrap());
    }
}

#[test]
fn verif_layers_refuse_what_they_cannot_draw() {
    let refused = |nside: u32, quantity: Quantity, cells: &[(u64, f64)]| {
        let panels = vec![LayerPanel { title: "p", quantity, cells }];
        layers(&Layers { title: "", caption: "", nside, is_folded: true, panels }).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(0, Quantity::Magnitude, &[(1, 1.0)]).contains("nside is 0, allowed: 1 to 1024"));
    assert!(refused(4, Quantity::Magnitude, &[(192, 1.0)]).contains("is 192, allowed: below 12 nside²"));
    assert!(refused(4, Quantity::Magnitude, &[(191, f64::NAN)]).contains("value 0, counted from 0, is NaN"));
    assert!(refused(4, Quantity::Count, &[(191, 0.0)]).contains("1 sample or more"));
    assert!(refused(4, Quantity::Spread, &[(191, 0.1), (191, 0.2)]).contains("is twice, allowed: once"));
    assert!(refused(4, Quantity::Spread, &[]).contains("there are no cells"));
    let none = layers(&Layers { title: "", caption: "", nside: 4, is_folded: true, panels: Vec::new() });
    assert!(matches!(none, Err(PlotError::OutOfRange { .. })));
}

#[test]
fn verif_the_histogram_says_mean_deviation_and_mad() {
    let residuals: Vec<f64> = normal(10_001, 617).into_iter().map(|x| 0.05 + 0.2 * x).collect();
    let input = ResidualHistogram { title: "Layer", residuals_mag: &residuals, sigma_mag: 0.25 };
    let picture = residual_histogram(&input).unwrap();
    let expected = "n = 10,001: mean 0.050, standard deviation 0.200, 1.4826 MAD 0.200 mag. ";
    assert!(words(&picture).iter().any(|words| words.starts_with(expected.trim())), "{:?}", words(&picture));
    has(&picture, &["Layer", "O−C, mag", "σ = 0.250 mag"]);
    // The curve's top, 1 / (0.25 √2π) = 1.596 per mag, is orange; above the middle is paper.
    let image = pixels(&picture);
    assert!((60..500).any(|y| image.get_pixel(440, y).0 == [213, 94, 0]));
    let refused = |residuals: &[f64], sigma: f64| {
        let input = ResidualHistogram { title: "", residuals_mag: residuals, sigma_mag: sigma };
        residual_histogram(&input).map(|_| ()).map_err(|error| error.to_string())
    };
    assert!(refused(&[], 0.2).unwrap_err().contains("there are no residuals"));
    assert!(refused(&[f64::NAN], 0.2).unwrap_err().contains("NaN"));
    assert!(refused(&[0.1], 0.0).unwrap_err().contains("is 0 mag, allowed: above 0 mag"));
    assert_eq!(refused(&[0.1], 0.2), Ok(()));
    assert_eq!(refused(&[0.0; 9], 0.2), Ok(()));
}

#[test]
fn verif_cells_kept_are_counted() {
    // Thresholds themselves are kept: 3 of 5.
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
    assert!(refused(&[], &[], 80.0).unwrap_err().contains("there are no samples of cells"));
    assert!(refused(&[3.0, 0.0], &[0.1, 0.1], 80.0).unwrap_err().contains("is 0, allowed: 1 or more"));
    assert!(refused(&[3.0], &[-0.1], 80.0).unwrap_err().contains("is -0.1"));
    assert!(refused(&[3.0], &[0.1, 0.2], 80.0).unwrap_err().contains("2 values, but there must be 1"));
    assert!(refused(&[3.0], &[0.1], f64::NAN).unwrap_err().contains("is NaN"));
    assert_eq!(refused(&[1.0], &[0.0], 1.0), Ok(()));
}

#[test]
fn verif_points_stand_beside_their_model_and_over_their_angles() {
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
    let one = PhaseCurve { phase_angle_rad: &[1.0], measured_mag: &[6.0], model_mag: &[6.0], ..curve.clone() };
    pixels(&phase_curve(&one).unwrap());
    // One of 300 magnitudes lies far off, and then two of them.
    for (off, expected) in [(1, "; 1 magnitude beyond the axis"), (2, "; 2 magnitudes beyond the axis")] {
        let far: Vec<f64> = (0..2_000).map(|n| if n < off { 60.0 } else { 6.0 + n as f64 * 1e-4 }).collect();
        let picture = phase_curve(&PhaseCurve {
            phase_angle_rad: &phase[..2_000],
            measured_mag: &far,
            model_mag: &[],
            ..curve.clone()
        });
        let said = words(&picture.unwrap()).join(" ");
        assert!(said.contains(expected), "{said}");
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

/// Two hours of exposures a minute apart, every fifth struck.
fn night(magnitude: impl Fn(usize) -> f64) -> [Vec<f64>; 4] {
    let n = 120;
    let start = (0..n).map(|k| 60_536.0 + k as f64 / 1440.0).collect();
    let magnitude: Vec<f64> = (0..n).map(|k| if k % 5 == 0 { magnitude(k) } else { f64::NAN }).collect();
    let streaks = (0..n).map(|k| if k % 5 == 0 { 1.0 + (k % 3) as f64 } else { 0.0 }).collect();
    [start, vec![30.0; n], streaks, magnitude]
}

fn timeline<'a>([start, duration, streaks, magnitude]: &'a [Vec<f64>; 4], sun: &'a [(f64, f64)]) -> NightTimeline<'a> {
    NightTimeline {
        title: "Night",
        caption: "Test.",
        start_mjd: start,
        duration_s: duration,
        n_streaks: streaks,
        brightest_mag: magnitude,
        limit_mag: Some(6.5),
        sun,
        local: Some(LocalClock { ahead_of_utc_h: -4.0, name: "UTC−4" }),
    }
}

#[test]
fn verif_a_night_shows_its_exposures_in_their_colours() {
    let columns = night(|k| 5.0 + k as f64 / 40.0);
    let sun = [(60_535.9, 5.0), (60_536.2, -25.0)];
    let picture = night_timeline(&timeline(&columns, &sun)).unwrap();
    let counts = "120 exposures, 24 struck (20.0 %), 12 by one brighter than the limit. Test.";
    has(&picture, &[counts, "UTC, 2024-08-13/14", "UTC−4, 2024-08-13", "01:00", "21:00", "limit 6.5 mag", "nautical"]);
    let image = pixels(&picture);
    let scale = picture.scales()[0];
    // The strip: exposure 60, struck at 6.5 mag, and the clear one after it; the axis from 1.2 % before to 1.2 % after.
    let span = (119.0 * 60.0 + 30.0) / 86_400.0;
    let across = |k: f64| 92.0 + (0.012 * span + (k + 0.25) / 1440.0) / (1.024 * span) * (1040.0 - 92.0);
    let at = |k: f64| image.get_pixel(across(k) as u32, 551).0;
    near(at(60.0), scale.colour(6.5));
    assert_eq!(at(61.0), [208, 208, 208]);
    // Above, bright is up: the first dot lies higher than the last.
    let dot = |k: f64, colour: [u8; 3]| {
        let column: Vec<u32> = (112..430).filter(|y| close(image.get_pixel(across(k) as u32, *y).0, colour)).collect();
        column.iter().sum::<u32>() as f64 / column.len() as f64
    };
    let (first, last) = (dot(0.0, scale.colour(5.0)), dot(115.0, scale.colour(7.875)));
    assert!(first + 100.0 < last, "{first} {last}");
    // Nothing known of the Sun: no bands, and no words of them.
    let without = night_timeline(&NightTimeline { sun: &[], local: None, ..timeline(&columns, &[]) }).unwrap();
    assert!(!words(&without).iter().any(|words| words.contains("twilight") || words.contains("UTC−4")));
}

fn close(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= COLOUR_STEPS)
}

#[track_caller]
fn near(a: [u8; 3], b: [u8; 3]) {
    assert!(close(a, b), "{a:?} {b:?}");
}

#[test]
fn verif_nights_that_are_empty_say_so_and_others_are_refused() {
    let [start, duration, _, magnitude] = night(|_| f64::NAN);
    let clear = [start.clone(), duration.clone(), vec![0.0; 120], magnitude.clone()];
    has(&night_timeline(&timeline(&clear, &[])).unwrap(), &["no exposure of this night is struck"]);
    let unknown = night(|_| f64::NAN);
    let picture = night_timeline(&timeline(&unknown, &[])).unwrap();
    has(&picture, &["no magnitude is known of any streak of this night", "struck, no magnitude"]);
    let refused =
        |columns: &[Vec<f64>; 4]| night_timeline(&timeline(columns, &[])).map(|_| ()).unwrap_err().to_string();
    assert!(refused(&Default::default()).contains("there are no exposures"));
    let mut long = clear.clone();
    long[0][119] += 3.0;
    assert!(refused(&long).contains("allowed: 2 d"));
    let mut uneven = clear.clone();
    uneven[3].pop();
    assert!(refused(&uneven).contains("brightest magnitudes: 119 values, but there must be 120"));
    let mut wrong = clear;
    wrong[0][3] = f64::NAN;
    assert!(refused(&wrong).contains("value 3, counted from 0, is NaN"));
    // One exposure alone is drawn.
    let one = [vec![60_536.0], vec![15.0], vec![1.0], vec![4.2]];
    pixels(&night_timeline(&timeline(&one, &[])).unwrap());
}

fn streak(name: &str, from: [f64; 2], to: [f64; 2], magnitude: f64) -> FieldStreak {
    let name = name.to_owned();
    let [enter_mjd, exit_mjd] = [1801.0, 1804.5].map(|seconds| 60_536.0 + seconds / 86_400.0);
    FieldStreak { name, track_deg: vec![from, to], enter_mjd, exit_mjd, magnitude, sigma_mag: 0.4 }
}

#[test]
fn verif_east_is_left_and_north_is_up_in_a_field() {
    let outlines = [vec![[11.0, -1.0], [11.0, 1.0], [9.0, 1.0], [9.0, -1.0]]];
    // From the middle to the east, and from the middle to the north.
    let streaks = [streak("EAST", [10.0, 0.0], [10.8, 0.0], 4.0), streak("NORTH", [10.0, 0.0], [10.0, 0.8], 7.0)];
    let chart = |outlines: &[Vec<[f64; 2]>], streaks: &[FieldStreak]| {
        field_chart(&FieldChart { title: "Field", caption: "Test.", ra_deg: 10.0, dec_deg: 0.0, outlines, streaks })
    };
    let picture = chart(&outlines, &streaks).unwrap();
    // The brightest first, in whatever order they come.
    let turned = [streaks[1].clone(), streaks[0].clone()];
    assert_eq!(chart(&outlines, &turned).unwrap().to_svg().unwrap(), picture.to_svg().unwrap());
    has(
        &picture,
        &["EAST", "NORTH", "4.0 ±0.4", "00:30:01.0", "00:30:04.5", "N", "E", "0.5°", "offset to the east, °"],
    );
    let (image, scale) = (pixels(&picture), picture.scales()[0]);
    let (bright, faint) = (scale.colour(4.0), scale.colour(7.0));
    // The chart's box; its middle is at (432, 412).
    let of = |colour: [u8; 3]| -> Vec<(f64, f64)> {
        let all = image.enumerate_pixels().filter(|(x, y, _)| (92..772).contains(x) && (72..752).contains(y));
        all.filter(|(.., pixel)| close(pixel.0, colour)).map(|(x, y, _)| (f64::from(x), f64::from(y))).collect()
    };
    let mean = |all: &[(f64, f64)]| {
        let n = all.len() as f64;
        (all.iter().map(|place| place.0).sum::<f64>() / n, all.iter().map(|place| place.1).sum::<f64>() / n)
    };
    let ((east_x, east_y), (north_x, north_y)) = (mean(&of(bright)), mean(&of(faint)));
    assert!(east_x < 370.0 && (east_y - 412.0).abs() < 6.0, "{east_x} {east_y}");
    assert!(north_y < 350.0 && (north_x - 432.0).abs() < 6.0, "{north_x} {north_y}");

    let empty = chart(&outlines, &[]).unwrap();
    has(&empty, &["no streak crosses this field"]);
    let refused = |outlines: &[Vec<[f64; 2]>], streaks: &[FieldStreak]| {
        chart(outlines, streaks).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(&[], &[]).contains("no border of the field is known"));
    assert!(refused(&[], &[streak("FAR", [10.0, 0.0], [100.0, 0.0], 4.0)]).contains("at most 75°"));
    assert!(refused(&[], &[streak("NOWHERE", [10.0, 0.0], [10.0, 91.0], 4.0)]).contains("a place of the chart"));
    // Thirty are drawn, and the list says how many are left.
    let many: Vec<FieldStreak> =
        (0..30).map(|k| streak("MANY", [9.5, -0.9], [10.5, -0.9 + 0.06 * f64::from(k)], 5.0)).collect();
    has(&chart(&outlines, &many).unwrap(), &["and 8 more, in the data"]);
    // Small fields are in arcminutes, and a dark streak has no magnitude.
    let small = [vec![[10.01, 0.0], [10.0, 0.06], [9.99, 0.0]]];
    has(
        &chart(&small, &[streak("DARK", [10.0, 0.0], [10.0, 0.02], f64::NAN)]).unwrap(),
        &["offset to the east, ′", "dark"],
    );
}

#[test]
fn verif_a_light_curve_has_its_band_and_its_marks() {
    let n = 101;
    let time: Vec<f64> = (0..n).map(|k| 60_536.0 + k as f64 / 86_400.0).collect();
    let magnitude: Vec<f64> = (0..n).map(|k| if k > 80 { f64::NAN } else { 6.0 + 0.01 * k as f64 }).collect();
    let sigma = vec![0.4; n];
    let second = 1.0 / 86_400.0;
    let curve = |time: &[f64], magnitude: &[f64], sigma: &[f64]| {
        light_curve(&LightCurve {
            title: "Curve",
            caption: "Test.",
            time_mjd: time,
            magnitude,
            sigma_mag: sigma,
            in_field: &[[60_536.0 + 40.0 * second, 60_536.0 + 50.0 * second]],
            shutter: Some([60_536.0 + 30.0 * second, 60_536.0 + 60.0 * second]),
            limit_mag: Some(7.0),
            local: None,
        })
    };
    let picture = curve(&time, &magnitude, &sigma).unwrap();
    has(
        &picture,
        &[
            "enter",
            "exit",
            "magnitude, ±1σ",
            "in the field",
            "shutter open",
            "nothing seen",
            "limit 7.0 mag",
            "UTC, 2024-08-13/14",
        ],
    );
    let image = pixels(&picture);
    // Columns of the track at 20 s: the line, and the band as wide as two sigmas.
    let x = (92.0 + 998.0 * (0.015 + 0.2) / 1.03) as u32;
    let shade: Vec<u32> =
        (118..540).filter(|y| image.get_pixel(x, *y).0[2] > image.get_pixel(x, *y).0[0].saturating_add(20)).collect();
    let (least, most) = (5.6 - 0.112, 7.2 + 0.112);
    let expected = 0.8 / (most - least) * 422.0;
    assert!((shade.len() as f64 - expected).abs() < 6.0, "{} {expected}", shade.len());
    let refused = |time: &[f64], magnitude: &[f64], sigma: &[f64]| {
        curve(time, magnitude, sigma).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused(&time, &vec![f64::NAN; n], &sigma).contains("there are no magnitudes along the track"));
    assert!(refused(&time, &magnitude[..50], &sigma).contains("magnitudes: 50 values, but there must be 101"));
    assert!(refused(&[], &[], &[]).contains("there are no points along the track"));
    assert!(refused(&[1.0, 1.0], &[5.0; 2], &[0.1; 2]).contains("each later than the one before"));
}

#[test]
fn verif_a_rate_has_its_colour_where_it_is() {
    let cells: Vec<(u64, f64)> = (0..cell_count(8))
        .filter_map(|cell| Some((cell, ring_centre_rad(8, cell)?)))
        .filter(|(_, (_, altitude))| *altitude > 0.4)
        .map(|(cell, (azimuth, _))| (cell, 1.0 + azimuth.sin()))
        .collect();
    let (cells, rate): (Vec<u64>, Vec<f64>) = cells.into_iter().unzip();
    let drawn = |nside: u32, cells: &[u64], rate: &[f64]| {
        sky_rate(&SkyRate {
            title: "Rate",
            subtitle: "Sun",
            caption: "Test.",
            nside,
            cells,
            rate,
            sun_azimuth_deg: 250.0,
        })
    };
    let picture = drawn(8, &cells, &rate).unwrap();
    has(&picture, &["Rate", "N", "E", "S", "W", "streaks", "not asked", "0.0", "2.0"]);
    let (image, scale) = (pixels(&picture), picture.scales()[0]);
    // Most in the east, which is left of the middle (336, 414).
    near(image.get_pixel(336 - 130, 410).0, scale.colour(2.0));
    near(image.get_pixel(336 + 130, 410).0, scale.colour(0.0));
    near(image.get_pixel(336 + 250, 410).0, [205, 205, 205]);
    let refused = |nside, cells: &[u64], rate: &[f64]| drawn(nside, cells, rate).map(|_| ()).unwrap_err().to_string();
    assert!(refused(8, &[], &[]).contains("there are no rates"));
    assert!(refused(8, &[1], &[-1.0]).contains("0 streaks or more"));
    assert!(refused(8, &[1, 1], &[1.0; 2]).contains("each once"));
    assert!(refused(1, &[12], &[1.0]).contains("a cell is 12"));
    assert!(refused(0, &[1], &[1.0]).contains("nside is 0"));
    assert!(refused(8, &[1, 2], &[1.0]).contains("cells: 2 values"));
}

#[test]
fn verif_trails_against_the_sun_go_from_day_to_night() {
    let sun: Vec<f64> = (0..600).map(|k| -0.1 * f64::from(k)).collect();
    let trails: Vec<f64> = sun.iter().map(|altitude| if *altitude > -30.0 { 3.0 } else { 1.0 }).collect();
    let bright = vec![0.5; 600];
    let drawn = |sun: &[f64], trails: &[f64], bin_deg: f64| {
        let n_bright = Some((&bright[..trails.len().min(600)], 7.0));
        sun_altitude(&SunAltitude {
            title: "Trails",
            caption: "Test.",
            sun_altitude_deg: sun,
            n_trails: trails,
            n_bright,
            bin_deg,
        })
    };
    let picture = drawn(&sun, &trails, 2.0).unwrap();
    has(
        &picture,
        &[
            "600 exposures, 2.00 trails each on average. Test.",
            "altitude of the Sun, °",
            "civil",
            "brighter than 7 mag",
        ],
    );
    let image = pixels(&picture);
    // The line of means: above while the Sun is high (left), below when it is low.
    let blue = |x: u32| (62..430).filter(|y| close(image.get_pixel(x, *y).0, [0, 114, 178])).min().unwrap();
    assert!(blue(250) + 100 < blue(850), "{} {}", blue(250), blue(850));
    let refused = |sun: &[f64], trails: &[f64], bin| drawn(sun, trails, bin).map(|_| ()).unwrap_err().to_string();
    assert!(refused(&[], &[], 2.0).contains("there are no exposures"));
    assert!(refused(&sun, &trails[..3], 2.0).contains("numbers of trails: 3 values"));
    assert!(refused(&sun, &trails, 0.0).contains("allowed: 0.1 to 30°"));
    assert!(refused(&[-100.0], &[1.0], 2.0).contains("allowed: -90 to 90°"));
    pixels(&drawn(&[-5.0], &[0.0], 2.0).unwrap());
}

#[test]
fn verif_an_svg_carries_its_font() {
    let one = [vec![60_536.0], vec![15.0], vec![1.0], vec![4.2]];
    let text = night_timeline(&timeline(&one, &[])).unwrap().to_svg().unwrap();
    assert!(text.contains("@font-face{font-family:\"DejaVu Sans\";src:url(data:font/ttf;base64,AAEAAAA"));
    assert!(!text.contains("http://") || text.matches("http").count() == 2, "only the two names of SVG itself");
}

/// A pass from west over the zenith to east in ten minutes, fading into the shadow.
fn pass(name: &str) -> SkyTrack {
    let points = 41;
    let share = |k: usize| k as f64 / (points - 1) as f64;
    SkyTrack {
        name: name.to_owned(),
        time_mjd: (0..points).map(|k| 60_536.0 + (5.0 + 600.0 * share(k)) / 86_400.0).collect(),
        azimuth_deg: (0..points).map(|k| if share(k) < 0.5 { 270.0 } else { 90.0 }).collect(),
        altitude_deg: (0..points).map(|k| 10.0 + 80.0 * (1.0 - (2.0 * share(k) - 1.0).abs())).collect(),
        magnitude: (0..points).map(|k| if share(k) > 0.7 { f64::NAN } else { 5.0 - 2.0 * share(k) }).collect(),
        sigma_mag: vec![0.4; points],
    }
}

#[test]
fn verif_a_sky_chart_says_who_when_and_how_bright() {
    let one = [pass("SAMPLE 1")];
    let drawn = |tracks: &[SkyTrack]| sky_chart(&SkyChart { title: "A night", caption: "Invented.", tracks });
    let picture = drawn(&one).unwrap();
    // Minutes along a pass that is alone; the ends to a second; the brightest magnitude.
    has(&picture, &["A night", "N", "E", "S", "W", "30°", "60°", "00:01", "SAMPLE 1", "00:00:05", "00:10:05"]);
    has(&picture, &["3.6 ±0.4"]);
    assert!(words(&picture).join(" ").contains("the brightest of each pass. Invented."));
    pixels(&picture);
    let many: Vec<SkyTrack> = (1..=30).map(|k| pass(&format!("SAMPLE {k}"))).collect();
    let picture = drawn(&many).unwrap();
    has(&picture, &["SAMPLE 22", "22"]);
    assert!(words(&picture).join(" ").contains("The 22 brightest of 30 passes."));
    // The brightest stay, in the order of the list.
    let mut one_bright = many.clone();
    one_bright[29].magnitude[0] = -3.0;
    let picture_of_it = drawn(&one_bright).unwrap();
    has(&picture_of_it, &["SAMPLE 21", "SAMPLE 30", "−3.0 ±0.4"]);
    assert!(!words(&picture_of_it).iter().any(|words| words == "SAMPLE 22"));
    assert!(!words(&picture).iter().any(|words| words == "00:01"));
    pixels(&picture);
    // Dark all along is drawn too, and a night without a pass.
    let dark = SkyTrack { magnitude: vec![f64::NAN; 41], ..pass("DARK") };
    has(&drawn(&[dark]).unwrap(), &["dark"]);
    has(&drawn(&[]).unwrap(), &["no pass", "30°"]);
}

#[test]
fn verif_a_sky_chart_refuses_what_it_cannot_draw() {
    let said = |track: SkyTrack| {
        let tracks = [track];
        sky_chart(&SkyChart { title: "", caption: "", tracks: &tracks }).map(|_| ()).unwrap_err().to_string()
    };
    assert!(said(SkyTrack { sigma_mag: vec![0.4], ..pass("A") }).contains("sigmas of A: 1 values"));
    assert!(said(SkyTrack { altitude_deg: vec![-5.0; 41], ..pass("A") }).contains("allowed: 0 to 90 deg"));
    assert!(said(SkyTrack { time_mjd: vec![60_536.0; 41], ..pass("A") }).contains("each later than the one before"));
    assert!(said(SkyTrack { azimuth_deg: vec![f64::NAN; 41], ..pass("A") }).contains("only finite numbers"));
}
