//! Charts of a fit and of a pass, drawn from invented data: `cargo run --example charts -- FOLDER` writes them as PNG and SVG.

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::PathBuf;

use streakcast::geometry::Site;
use streakcast::math::healpix::{cell_count, ring_centre_rad};
use streakcast::plot::{
    AlarmChart, AlarmMark, Corner, CountsAndSpread, CutPanel, FinderChart, LayerPanel, Layers, LightCurve, LocalClock,
    PhaseCurve, Quantity, ResidualHistogram, ResidualPanels, SkyChart, SkyTrack, alarm_chart, corner,
    counts_and_spread, finder_chart, layers, light_curve, phase_curve, residual_histogram, residual_panels, sky_chart,
    streak_cuts,
};

/// Generator of reproducible pseudo-random numbers: the fractional parts of large multiples of sines.
struct Spread(f64);

impl Spread {
    /// Returns a number uniform between 0 and 1.
    fn even(&mut self) -> f64 {
        self.0 += 1.0;
        ((self.0 * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0)
    }

    /// Returns a normally distributed number (Box and Muller 1958).
    fn normal(&mut self) -> f64 {
        (-2.0 * self.even().max(1e-12).ln()).sqrt() * (TAU * self.even()).cos()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".to_owned()));
    let mut spread = Spread(0.0);

    // A posterior: six parameters of a model, two of them correlated, one close to its bound.
    let names = ["c1", "n1", "c2", "n2", "f_array", "albedo_chassis"].map(str::to_owned);
    let truths = [0.0125, 31.0, 0.30, 4.2, 0.082, 0.3];
    let mut samples: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for _ in 0..30_000 {
        let common = spread.normal();
        samples[0].push(0.0123 + 0.000_35 * (0.8 * common + 0.6 * spread.normal()));
        samples[1].push(30.2 + 1.2 * (-0.9 * common + 0.44 * spread.normal()));
        samples[2].push(0.31 + 0.02 * spread.normal());
        samples[3].push(4.0 + 0.3 * spread.normal().abs());
        samples[4].push(0.0812 * (0.04 * spread.normal()).exp());
        samples[5].push(0.3 + 0.01 * (spread.normal() + 0.5 * common));
    }
    let posterior =
        corner(&Corner { title: "", names: &names, samples: &samples, truths: Some(&truths), bounds: None })?;

    // Cells of a satellite's body frame: bright towards the Sun, fewer samples near the edge.
    let nside = 32;
    let mut cells: [Vec<(u64, f64)>; 4] = Default::default();
    let (mut counts, mut iqr_mag) = (Vec::new(), Vec::new());
    for cell in 0..cell_count(nside) {
        let Some((longitude, latitude)) = ring_centre_rad(nside, cell) else { continue };
        if longitude > PI || latitude > -0.35 || (latitude > -0.6 && spread.even() < 0.3) {
            continue;
        }
        let magnitude = 6.0 - 1.4 * longitude.cos() * latitude.cos() + 0.1 * spread.normal();
        let count = (5.5 + 1.6 * (-latitude).sin() + 0.9 * spread.normal() - 0.5 * longitude).exp().ceil();
        let iqr = 0.36 * (0.35 * spread.normal()).exp() + 0.5 / count.sqrt();
        let residual = 0.25 * (2.0 * longitude).sin() * latitude.sin() + 0.12 * spread.normal();
        for (column, value) in cells.iter_mut().zip([magnitude, count, iqr, residual]) {
            column.push((cell, value));
        }
        counts.push(count);
        iqr_mag.push(iqr);
    }
    let panel = |title, quantity, column: usize| LayerPanel { title, quantity, cells: &cells[column] };
    let slice = layers(&Layers {
        title: "Sun at latitude −19° to −18°",
        caption: "Invented data.",
        nside,
        is_folded: true,
        panels: vec![
            panel("(a) median magnitude", Quantity::Magnitude, 0),
            panel("(b) samples", Quantity::Count, 1),
            panel("(c) spread", Quantity::Spread, 2),
        ],
    })?;
    let o_c = layers(&Layers {
        title: "O−C of invented data",
        caption: "",
        nside,
        is_folded: true,
        panels: ["(a) Sun at latitude −8°", "(b) −14°", "(c) −20°"]
            .map(|title| panel(title, Quantity::Residual, 3))
            .to_vec(),
    })?;
    let cells_kept = counts_and_spread(&CountsAndSpread {
        title: "Cells of invented data",
        counts: &counts,
        iqr_mag: &iqr_mag,
        least_count: 80.0,
        most_iqr_mag: 0.4,
    })?;

    // Points of a fit: a model with an error at small phase angles, and 2 % outliers.
    let mut columns: [Vec<f64>; 7] = Default::default();
    for _ in 0..20_000 {
        let (sun_latitude, longitude) = (-0.4 * spread.even() - 0.05, PI * spread.even());
        let latitude = -FRAC_PI_2 * (0.3 + 0.7 * spread.even());
        // cos φ = sin δ sin δ_sun + cos δ cos δ_sun cos λ
        let cosine = latitude.sin() * sun_latitude.sin() + latitude.cos() * sun_latitude.cos() * longitude.cos();
        let phase = cosine.acos();
        let model = 6.2 - 1.2 * phase.cos() + 0.5 * (latitude + 1.0).sin();
        let wrong = if spread.even() < 0.02 { 3.0 } else { 1.0 };
        let residual = 0.22 * wrong * spread.normal() + 0.3 * (-phase / 0.4).exp();
        let point = [sun_latitude, longitude, latitude, phase, model, model + residual, residual];
        columns.iter_mut().zip(point).for_each(|(column, value)| column.push(value));
    }
    let [sun_latitude_rad, observer_longitude_rad, observer_latitude_rad, phase_angle_rad, model, measured, residuals] =
        &columns;
    let bars = residual_histogram(&ResidualHistogram {
        title: "Residuals of invented data",
        residuals_mag: residuals,
        sigma_mag: 0.25,
    })?;
    let curve = phase_curve(&PhaseCurve {
        title: "Invented satellite",
        magnitude_name: "magnitude V (Vega) at 1000 km",
        phase_angle_rad,
        measured_mag: measured,
        model_mag: model,
    })?;
    let against_angles = residual_panels(&ResidualPanels {
        title: "Residuals of invented data against the geometry",
        residuals_mag: residuals,
        sun_latitude_rad,
        observer_longitude_rad,
        observer_latitude_rad,
        phase_angle_rad,
    })?;

    let days: Vec<f64> = (0..60).map(|day| 0.5 * f64::from(day)).collect();
    let mut differences: Vec<f64> = days.iter().map(|_| 0.35 * spread.normal()).collect();
    differences[40] = -3.5;
    let alarms = [AlarmMark { day: days[40], difference_mag: -3.5, label: "90001: -3.5 mag".to_owned() }];
    let passes = alarm_chart(&AlarmChart {
        title: "Invented passes",
        origin: "2026-01-01",
        days: &days,
        differences_mag: &differences,
        sigmas_mag: &vec![0.35; days.len()],
        alarms: &alarms,
    })?;

    // A streak of Gaussian profile in noise of one count, four pixels beside its predicted track.
    let across: Vec<f64> = (-15..=15).map(f64::from).collect();
    let fitted: Vec<f64> = across.iter().map(|v| 6.0 * (-0.5 * (v / 2.0).powi(2)).exp()).collect();
    let columns = 200;
    let values: Vec<f64> = fitted.iter().flat_map(|light| vec![*light; columns]).map(|v| v + spread.normal()).collect();
    let mean = |row: &[f64]| row.iter().sum::<f64>() / columns as f64;
    let cuts = streak_cuts(
        "Invented streak",
        &[CutPanel {
            title: "90001: 6.12 +- 0.02 mag",
            columns,
            length_pix: 1000.0,
            across_pix: &across,
            values: &values,
            profile: &values.chunks_exact(columns).map(mean).collect::<Vec<f64>>(),
            profile_sigma: &vec![1.0 / (columns as f64).sqrt(); across.len()],
            model: &fitted,
            predicted_pix: 4.0,
        }],
    )?;

    // A pass from west to east, 70 degrees high, which ends in the Earth's shadow; the models do not describe its start.
    let site = Site::new_deg("invented site", 48.0, 16.0, 200.0)?;
    let share = |k: usize| k as f64 / 60.0;
    let track = SkyTrack {
        name: "Invented satellite".to_owned(),
        time_mjd: (0..=60).map(|k| 61_000.8 + 0.004 * share(k)).collect(),
        azimuth_deg: (0..=60).map(|k| 280.0 + 200.0 * share(k)).collect(),
        altitude_deg: (0..=60).map(|k| 10.0 + 60.0 * (PI * share(k)).sin()).collect(),
        magnitude: (0..=60).map(|k| if k > 45 { f64::NAN } else { 5.0 - 3.0 * share(k) }).collect(),
        sigma_mag: (0..=60).map(|k| if k < 15 { 0.7 } else { 0.3 }).collect(),
        time_sigma_s: 2.0,
    };
    let local = Some(LocalClock { ahead_of_utc_h: 1.0, name: "local time (UTC+1)".to_owned() });
    let tracks = std::slice::from_ref(&track);
    let site = Some(&site);
    let sky =
        sky_chart(&SkyChart { title: "Invented pass", caption: "Invented data.", tracks, local: local.clone(), site })?;
    let finder = finder_chart(&FinderChart {
        title: "Pass of an invented satellite",
        caption: "Invented data.",
        track: &track,
        local: local.clone(),
        site,
    })?;
    let brightness = light_curve(&LightCurve {
        title: "Light curve of an invented satellite",
        caption: "Invented data.",
        time_mjd: &track.time_mjd,
        magnitude: &track.magnitude,
        sigma_mag: &track.sigma_mag,
        in_fitted_range: &(0..=60).map(|k| k >= 15).collect::<Vec<bool>>(),
        in_field: &[],
        shutter: None,
        limit_mag: None,
        local,
    })?;

    let pictures = [
        ("sky", sky),
        ("finder", finder),
        ("curve", brightness),
        ("alarms", passes),
        ("cuts", cuts),
        ("corner", posterior),
        ("slice", slice),
        ("o-c", o_c),
        ("cells", cells_kept),
        ("histogram", bars),
        ("phase", curve),
        ("angles", against_angles),
    ];
    for (name, picture) in pictures {
        std::fs::write(folder.join(format!("{name}.png")), picture.to_png()?)?;
        std::fs::write(folder.join(format!("{name}.svg")), picture.to_svg()?)?;
    }
    Ok(())
}
