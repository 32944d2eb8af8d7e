//! Histogram of residuals beside a normal curve: figure 5 of Lu (2024).

use std::f64::consts::TAU;

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use crate::math::quantile::quantile;

use super::axes::{Axis, Frame};
use super::error::PlotError;
use super::numbers::{count, fixed};
use super::picture::{INK, Picture};
use super::statistics::{check, histogram, mad_sigma, mean_and_sd, sorted};

const BARS: RGBColor = RGBColor(158, 202, 225);
const CURVE: RGBColor = RGBColor(213, 94, 0);
/// Share of the residuals that the axis may leave out at each end.
const BEYOND: f64 = 0.003;

/// Residuals of a fit.
#[derive(Clone, Debug)]
pub struct ResidualHistogram<'a> {
    /// Above.
    pub title: &'a str,
    /// Observed less computed magnitudes, finite, mag.
    pub residuals_mag: &'a [f64],
    /// Standard deviation of the normal curve about 0 that the bars are held against, above 0: what the fit foretells, or its RMSE, mag.
    pub sigma_mag: f64,
}

/// Draws the density of residuals as bars, the normal curve of the sigma given over them, and mean, standard deviation and 1.4826 MAD below.
///
/// The axis is as long on both sides of 0 and holds at least 99.4 % of the residuals and three sigma; how many lie beyond is said.
///
/// # Errors
/// No residual, one that is not finite, a sigma that is not above 0.
pub fn residual_histogram(input: &ResidualHistogram<'_>) -> Result<Picture, PlotError> {
    let (values, sigma) = (input.residuals_mag, input.sigma_mag);
    check("residuals", values)?;
    if !(sigma.is_finite() && sigma > 0.0) {
        let what = "sigma of the normal curve".to_owned();
        return Err(PlotError::OutOfRange { what, given: format!("{sigma} mag"), allowed: "above 0 mag" });
    }
    let sorted = sorted(values);
    let end = quantile(&sorted, BEYOND).abs().max(quantile(&sorted, 1.0 - BEYOND).abs()).max(3.0 * sigma);
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
    picture.text(input.title, (400.0, 28.0), 22.0, HPos::Center);
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

/// As many bins as Freedman and Diaconis (1981) advise, 2 IQR n^(−1/3) wide, between 11 and 81 and odd, so that one has 0 in its middle.
fn bins(sorted: &[f64], range: f64) -> usize {
    let iqr = quantile(sorted, 0.75) - quantile(sorted, 0.25);
    let width = 2.0 * iqr / (sorted.len() as f64).cbrt();
    let bins = if width > 0.0 { (range / width).clamp(11.0, 80.0) } else { 41.0 };
    bins as usize | 1
}
