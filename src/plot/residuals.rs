//! Charts of a fit: histogram of residuals (figure 5 of Lu 2024), magnitudes against phase angle, and residuals against
//! each angle of the viewing geometry.

use std::f64::consts::TAU;

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame};
use super::density::dots;
use super::numbers::{count, fixed, many};
use super::picture::{INK, Picture};
use super::statistics::{BandSegment, check, check_length, histogram, mad_sigma, mean_and_sd, running_band, sorted};
use crate::error::Error;
use crate::math::quantile::quantile;

const BARS: RGBColor = RGBColor(158, 202, 225);
const CURVE: RGBColor = RGBColor(213, 94, 0);
/// Fraction of the residuals that the axis may omit at each end.
const HISTOGRAM_BEYOND: f64 = 0.003;

/// Residuals of a fit.
#[derive(Clone, Debug)]
pub struct ResidualHistogram<'a> {
    /// Title.
    pub title: &'a str,
    /// Observed minus computed magnitudes, finite, mag.
    pub residuals_mag: &'a [f64],
    /// Standard deviation of the normal curve drawn over the bars, mag, above 0: the sigma of the fit or its RMSE.
    pub sigma_mag: f64,
}

/// Draws the density of residuals as bars, over them the normal curve of the given sigma, and below them the mean, the
/// standard deviation and 1.4826 MAD.
///
/// The axis is symmetric about 0 and contains at least 99.4 % of the residuals and three sigma. The caption gives the
/// number of residuals beyond the axis.
///
/// # Errors
/// There is no residual, a residual is not finite, or sigma is not above 0.
pub fn residual_histogram(input: &ResidualHistogram<'_>) -> Result<Picture, Error> {
    let (values, sigma) = (input.residuals_mag, input.sigma_mag);
    check("residuals", values)?;
    if !(sigma.is_finite() && sigma > 0.0) {
        let what = "sigma of the normal curve".to_owned();
        return Err(Error::invalid(what, format!("{sigma} mag"), "above 0 mag"));
    }
    let sorted = sorted(values);
    let end =
        quantile(&sorted, HISTOGRAM_BEYOND).abs().max(quantile(&sorted, 1.0 - HISTOGRAM_BEYOND).abs()).max(3.0 * sigma);
    let x = Axis::linear(-1.04 * end, 1.04 * end);
    let bins = bins(&sorted, x.to - x.from);
    let counts = histogram(values, &x, bins);
    let width = (x.to - x.from) / bins as f64;
    // N(0, σ) = exp(−x² / 2σ²) / (σ √2π)
    let normal = |x: f64| (-0.5 * (x / sigma).powi(2)).exp() / (sigma * TAU.sqrt());
    let density = |count: usize| count as f64 / (values.len() as f64 * width);
    let most = counts.iter().map(|count| density(*count)).fold(normal(0.0), f64::max);
    let frame = Frame { sides: [92.0, 60.0, 772.0, 500.0], x, y: Axis::linear(0.0, 1.08 * most) };

    let mut picture = Picture::new(800, 640);
    picture.set_title(input.title, (400.0, 28.0), 22.0, HPos::Center);
    for (bin, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let side = |bin: usize| x.value(bin as f64 / bins as f64);
        let ((left, top), (right, bottom)) = (frame.at(side(bin), density(*count)), frame.at(side(bin + 1), 0.0));
        picture.rectangle([left, top, right, bottom], BARS.to_rgba());
        picture.border([left, top, right, bottom], 0.8);
    }
    let curve: Vec<_> =
        (0..=240).map(|part| x.value(f64::from(part) / 240.0)).map(|x| frame.at(x, normal(x))).collect();
    picture.line(&curve, CURVE.to_rgba(), 2.6);
    picture.dashed(&[frame.at(0.0, 0.0), frame.at(0.0, frame.y.to)], [6.0, 4.0], INK.mix(0.7), 1.2);
    frame.draw(&mut picture, [true, true]);
    frame.name_x(&mut picture, "O−C, mag");
    frame.name_y(&mut picture, "share per mag", 58.0);
    picture.line(&[(110.0, 80.0), (140.0, 80.0)], CURVE.to_rgba(), 2.6);
    picture.text(&format!("σ = {} mag", fixed(sigma, 3)), (150.0, 80.0), 17.0, HPos::Left);

    let (mean, sd) = mean_and_sd(values);
    let (mean, sd, mad) = (fixed(mean, 3), fixed(sd, 3), fixed(mad_sigma(values), 3));
    let beyond = match values.iter().filter(|value| !x.holds(**value)).count() {
        0 => String::new(),
        beyond => format!(" {} beyond the axis.", count(beyond)),
    };
    let number = count(values.len());
    let caption = format!("n = {number}: mean {mean}, standard deviation {sd}, 1.4826 MAD {mad} mag.{beyond}");
    picture.paragraph(&caption, [30.0, 780.0], 588.0, 17.0);
    Ok(picture)
}

/// Returns the number of bins by the rule of Freedman and Diaconis (1981), with bins 2 IQR n^(−1/3) wide. The number is
/// between 11 and 81 and odd, so that one bin is centred on 0.
fn bins(sorted: &[f64], range: f64) -> usize {
    let iqr = quantile(sorted, 0.75) - quantile(sorted, 0.25);
    let width = 2.0 * iqr / (sorted.len() as f64).cbrt();
    let bins = if width > 0.0 { (range / width).clamp(11.0, 80.0) } else { 41.0 };
    bins as usize | 1
}

const MEASURED: RGBColor = RGBColor(0, 114, 178);
const MODEL: RGBColor = RGBColor(213, 94, 0);
/// Number of bins of the running medians.
const PHASE_BINS: usize = 36;
/// Fraction of the magnitudes that the axis may omit at each end.
const PHASE_BEYOND: f64 = 0.002;

/// Magnitudes as a function of the phase angle.
#[derive(Clone, Debug)]
pub struct PhaseCurve<'a> {
    /// Title.
    pub title: &'a str,
    /// Name of the magnitudes, for example `magnitude V at 1000 km`.
    pub magnitude_name: &'a str,
    /// Sun-satellite-observer angle, 0 to π, radians; shape `(n_point)`.
    pub phase_angle_rad: &'a [f64],
    /// Measured magnitudes, finite; shape `(n_point)`.
    pub measured_mag: &'a [f64],
    /// Magnitudes of the model in the same geometry, finite; empty if there is no model, in which case a single panel
    /// is drawn; shape `(n_point)`.
    pub model_mag: &'a [f64],
}

/// Draws measured magnitudes against phase angle and, next to them on the same axes, the magnitudes of the model. Each
/// panel contains the running medians of the measured and of the computed magnitudes. Brighter magnitudes are higher.
///
/// The axis of magnitudes contains at least 99.6 % of the measured and of the computed ones. The caption gives the
/// number beyond the axis.
///
/// # Errors
/// There is no point; columns differ in length; a value is not finite; or a phase angle is invalid.
pub fn phase_curve(input: &PhaseCurve<'_>) -> Result<Picture, Error> {
    check("phase angles", input.phase_angle_rad)?;
    check_length("measured magnitudes", input.measured_mag, input.phase_angle_rad.len())?;
    let phase: Vec<f64> = input.phase_angle_rad.iter().map(|angle| angle.to_degrees()).collect();
    if let Some(wrong) = phase.iter().find(|angle| !(0.0..=180.0).contains(*angle)) {
        let (what, given) = ("phase angle".to_owned(), format!("{wrong}°"));
        return Err(Error::invalid(what, given, "0 to 180°"));
    }
    let mut panels = vec![("measured", MEASURED, input.measured_mag)];
    if !input.model_mag.is_empty() {
        check_length("magnitudes of the model", input.model_mag, phase.len())?;
        panels.push(("model", MODEL, input.model_mag));
    }
    let ends = panels.iter().map(|(_, _, magnitudes)| {
        let sorted = sorted(magnitudes);
        (quantile(&sorted, PHASE_BEYOND), quantile(&sorted, 1.0 - PHASE_BEYOND))
    });
    let (bright, faint) = ends
        .fold((f64::INFINITY, f64::NEG_INFINITY), |all, quantiles| (all.0.min(quantiles.0), all.1.max(quantiles.1)));
    let margin = 0.05 * (faint - bright);
    // The axis is reversed, with the faint end at the bottom. `Axis::linear` widens it if all values are equal.
    let up = Axis::linear(bright - margin, faint + margin);
    let y = Axis { from: up.to, to: up.from, is_log: false };
    let (least, greatest) = phase.iter().fold((180.0_f64, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    let margin = 0.03 * (greatest - least);
    let x = Axis::linear(least - margin, greatest + margin);

    let width = if panels.len() == 1 { 640.0 } else { 560.0 };
    let whole = 92.0 + panels.len() as f64 * (width + 20.0) + 8.0;
    let mut picture = Picture::new(whole as usize, 660);
    picture.set_title(input.title, (whole / 2.0, 28.0), 22.0, HPos::Center);
    let medians: Vec<Vec<BandSegment>> =
        panels.iter().map(|(_, _, magnitudes)| running_band(&phase, magnitudes, &x, PHASE_BINS)).collect();
    for (index, (name, colour, magnitudes)) in panels.iter().enumerate() {
        let left = 92.0 + index as f64 * (width + 20.0);
        let frame = Frame { sides: [left, 84.0, left + width, 540.0], x, y };
        picture.paint(dots(&frame, &phase, magnitudes, mixed(*colour)));
        let lines: Vec<(usize, Vec<_>)> = medians
            .iter()
            .enumerate()
            .flat_map(|(of, all)| all.iter().map(move |segment| (of, segment)))
            .map(|(of, segment)| (of, segment.iter().map(|(x, [_, median, _])| frame.at(*x, *median)).collect()))
            .collect();
        // Light lines separate the curves from the points. They are drawn before all curves, so that they do not
        // interrupt a curve.
        lines.iter().for_each(|(_, line)| picture.line(line, RGBColor(255, 255, 255).to_rgba(), 5.5));
        for (of, line) in &lines {
            match of {
                0 => picture.line(line, MEASURED.to_rgba(), 3.0),
                _ => picture.dashed(line, [10.0, 6.0], MODEL.to_rgba(), 3.0),
            }
        }
        frame.draw(&mut picture, [true, index == 0]);
        frame.name_x(&mut picture, "phase angle, °");
        if index == 0 {
            frame.name_y(&mut picture, input.magnitude_name, 60.0);
        }
        picture.text(name, (left + width / 2.0, 66.0), 19.0, HPos::Center);
    }
    let mut from = 30.0;
    for ((name, colour, _), dash) in panels.iter().zip([[30.0, 0.1], [10.0, 6.0]]) {
        picture.dashed(&[(from, 612.0), (from + 32.0, 612.0)], dash, colour.to_rgba(), 3.0);
        from = picture.legend_text(&format!("running median, {name}"), from + 42.0, 612.0);
    }
    let out = |magnitudes: &[f64]| magnitudes.iter().filter(|magnitude| !y.holds(**magnitude)).count();
    let beyond = match panels.iter().map(|(_, _, magnitudes)| out(magnitudes)).sum() {
        0 => String::new(),
        beyond => format!("; {} beyond the axis", many(beyond, "magnitude", "magnitudes")),
    };
    picture.paragraph(&format!("n = {}{beyond}.", count(phase.len())), [30.0, whole - 30.0], 640.0, 16.0);
    Ok(picture)
}

/// Returns a colour half way to white, for dots under lines.
fn mixed(colour: RGBColor) -> RGBColor {
    let half = |channel: u8| channel / 2 + 127;
    RGBColor(half(colour.0), half(colour.1), half(colour.2))
}

const DOT: RGBColor = RGBColor(120, 120, 120);
const BAND: RGBColor = RGBColor(86, 180, 233);
const MEDIAN: RGBColor = RGBColor(0, 114, 178);
/// Number of bins of the running median.
const PANEL_BINS: usize = 24;
/// Fraction of the residuals that the axis may omit at each end.
const PANEL_BEYOND: f64 = 0.01;

/// Residuals of a fit with their viewing geometry.
#[derive(Clone, Debug)]
pub struct ResidualPanels<'a> {
    /// Title.
    pub title: &'a str,
    /// Observed minus computed magnitudes, finite, mag; shape `(n_point)`.
    pub residuals_mag: &'a [f64],
    /// Latitude of the Sun above the plane of the chassis, radians; shape `(n_point)`.
    pub sun_latitude_rad: &'a [f64],
    /// Longitude of the observer from the Sun's azimuth, folded or not, radians; shape `(n_point)`.
    pub observer_longitude_rad: &'a [f64],
    /// Latitude of the observer above the plane of the chassis, radians; shape `(n_point)`.
    pub observer_latitude_rad: &'a [f64],
    /// Sun-satellite-observer angle, radians; shape `(n_point)`.
    pub phase_angle_rad: &'a [f64],
}

/// Draws residuals against each of the four angles, as points with a running median and a band from the quantile 0.16
/// to the quantile 0.84.
///
/// The axis of residuals is symmetric about 0 and contains at least 98 % of the residuals. The caption gives the number
/// beyond the axis. Bins with fewer than eight points have no median, which interrupts the line.
///
/// # Errors
/// There is no residual, columns differ in length, or a value is not finite.
pub fn residual_panels(input: &ResidualPanels<'_>) -> Result<Picture, Error> {
    let residuals = input.residuals_mag;
    check("residuals", residuals)?;
    let panels = [
        ("latitude of the Sun, °", input.sun_latitude_rad),
        ("longitude of the observer, °", input.observer_longitude_rad),
        ("latitude of the observer, °", input.observer_latitude_rad),
        ("phase angle, °", input.phase_angle_rad),
    ];
    let sorted = sorted(residuals);
    let end = quantile(&sorted, PANEL_BEYOND).abs().max(quantile(&sorted, 1.0 - PANEL_BEYOND).abs());
    let end = if end > 0.0 { 1.06 * end } else { 0.1 };
    let y = Axis::linear(-end, end);

    let mut picture = Picture::new(1180, 940);
    picture.set_title(input.title, (590.0, 28.0), 22.0, HPos::Center);
    for (index, (name, angles_rad)) in panels.into_iter().enumerate() {
        check_length(name, angles_rad, residuals.len())?;
        let angles: Vec<f64> = angles_rad.iter().map(|angle| angle.to_degrees()).collect();
        let (low, high) = angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let margin = 0.03 * (high - low);
        let (left, top) = (92.0 + 544.0 * (index % 2) as f64, 60.0 + 410.0 * (index / 2) as f64);
        let frame =
            Frame { sides: [left, top, left + 520.0, top + 320.0], x: Axis::linear(low - margin, high + margin), y };
        picture.paint(dots(&frame, &angles, residuals, DOT));
        let band = running_band(&angles, residuals, &Axis::linear(low, high), PANEL_BINS);
        let part = |segment: &BandSegment, k: usize| {
            segment.iter().map(|(x, quantiles)| frame.at(*x, quantiles[k])).collect::<Vec<_>>()
        };
        for segment in band.iter().filter(|segment| segment.len() > 1) {
            let back = part(segment, 2).into_iter().rev();
            picture.patch(part(segment, 0).into_iter().chain(back).collect(), BAND.mix(0.45));
        }
        picture.line(&[frame.at(frame.x.from, 0.0), frame.at(frame.x.to, 0.0)], INK.mix(0.7), 1.2);
        for segment in &band {
            picture.line(&part(segment, 1), MEDIAN.to_rgba(), 3.0);
        }
        frame.draw(&mut picture, [true, index % 2 == 0]);
        frame.name_x(&mut picture, name);
        if index % 2 == 0 {
            frame.name_y(&mut picture, "O−C, mag", 62.0);
        }
    }
    picture.line(&[(30.0, 880.0), (62.0, 880.0)], MEDIAN.to_rgba(), 3.0);
    let x = picture.legend_text("running median", 72.0, 880.0);
    picture.rectangle([x, 871.0, x + 32.0, 889.0], BAND.mix(0.6));
    picture.legend_text("16 to 84 %", x + 42.0, 880.0);
    let beyond = match residuals.iter().filter(|value| !y.holds(**value)).count() {
        0 => String::new(),
        beyond => format!("; {} beyond the axis", count(beyond)),
    };
    let caption = format!("n = {}{beyond}. O−C above 0: observed fainter than computed.", count(residuals.len()));
    picture.paragraph(&caption, [30.0, 1150.0], 912.0, 16.0);
    Ok(picture)
}
