//! Residuals against each angle of the geometry: what a model leaves unexplained, and where.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use crate::math::quantile::quantile;

use super::axes::{Axis, Frame};
use super::dots::dots;
use super::error::PlotError;
use super::numbers::count;
use super::picture::{INK, Picture};
use super::statistics::{Stretch, check, check_length, running_band, sorted};

const DOT: RGBColor = RGBColor(120, 120, 120);
const BAND: RGBColor = RGBColor(86, 180, 233);
const MEDIAN: RGBColor = RGBColor(0, 114, 178);
/// Bins of the running median.
const BINS: usize = 24;
/// Share of the residuals that the axis may leave out at each end.
const BEYOND: f64 = 0.01;

/// Residuals and their geometry.
#[derive(Clone, Debug)]
pub struct ResidualPanels<'a> {
    /// Above.
    pub title: &'a str,
    /// `(n_point)` observed less computed magnitudes, finite, mag.
    pub residuals_mag: &'a [f64],
    /// `(n_point)` latitude of the Sun above the plane of the chassis, radians.
    pub sun_latitude_rad: &'a [f64],
    /// `(n_point)` longitude of the observer from the Sun's azimuth, folded or not, radians.
    pub observer_longitude_rad: &'a [f64],
    /// `(n_point)` latitude of the observer above the plane of the chassis, radians.
    pub observer_latitude_rad: &'a [f64],
    /// `(n_point)` Sun, satellite, observer, radians.
    pub phase_angle_rad: &'a [f64],
}

/// Draws residuals against each of the four angles: points, running median, and the band from the quantile 0.16 to 0.84.
///
/// The axis of residuals is as long on both sides of 0 and holds at least 98 % of them; how many lie beyond is said. Bins of fewer than eight
/// points have no median, and the line breaks there.
///
/// # Errors
/// No residual, columns of unequal length, a value that is not finite.
pub fn residual_panels(input: &ResidualPanels<'_>) -> Result<Picture, PlotError> {
    let residuals = input.residuals_mag;
    check("residuals", residuals)?;
    let panels = [
        ("latitude of the Sun, °", input.sun_latitude_rad),
        ("longitude of the observer, °", input.observer_longitude_rad),
        ("latitude of the observer, °", input.observer_latitude_rad),
        ("phase angle, °", input.phase_angle_rad),
    ];
    let sorted = sorted(residuals);
    let end = quantile(&sorted, BEYOND).abs().max(quantile(&sorted, 1.0 - BEYOND).abs());
    let end = if end > 0.0 { 1.06 * end } else { 0.1 };
    let y = Axis::linear(-end, end);

    let mut picture = Picture::new(1180, 940);
    picture.text(input.title, (590.0, 28.0), 22.0, HPos::Center);
    for (index, (name, angles_rad)) in panels.into_iter().enumerate() {
        check_length(name, angles_rad, residuals.len())?;
        let angles: Vec<f64> = angles_rad.iter().map(|angle| angle.to_degrees()).collect();
        let (low, high) = angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let room = 0.03 * (high - low);
        let (left, top) = (92.0 + 544.0 * (index % 2) as f64, 60.0 + 410.0 * (index / 2) as f64);
        let frame =
            Frame { sides: [left, top, left + 520.0, top + 320.0], x: Axis::linear(low - room, high + room), y };
        picture.paint(dots(&frame, &angles, residuals, DOT));
        let band = running_band(&angles, residuals, &Axis::linear(low, high), BINS);
        let part = |stretch: &Stretch, k: usize| {
            stretch.iter().map(|(x, quantiles)| frame.at(*x, quantiles[k])).collect::<Vec<_>>()
        };
        for stretch in band.iter().filter(|stretch| stretch.len() > 1) {
            let back = part(stretch, 2).into_iter().rev();
            picture.patch(part(stretch, 0).into_iter().chain(back).collect(), BAND.mix(0.45));
        }
        picture.line(&[frame.at(frame.x.from, 0.0), frame.at(frame.x.to, 0.0)], INK.mix(0.7), 1.2);
        for stretch in &band {
            picture.line(&part(stretch, 1), MEDIAN.to_rgba(), 3.0);
        }
        frame.draw(&mut picture, [true, index % 2 == 0]);
        frame.name_x(&mut picture, name);
        if index % 2 == 0 {
            frame.name_y(&mut picture, "O−C, mag", 62.0);
        }
    }
    picture.line(&[(30.0, 880.0), (62.0, 880.0)], MEDIAN.to_rgba(), 3.0);
    let x = picture.words("running median", 72.0, 880.0);
    picture.rectangle([x, 871.0, x + 32.0, 889.0], BAND.mix(0.6));
    picture.words("16 to 84 %", x + 42.0, 880.0);
    let beyond = match residuals.iter().filter(|value| !y.holds(**value)).count() {
        0 => String::new(),
        beyond => format!("; {} beyond the axis", count(beyond)),
    };
    let caption = format!("n = {}{beyond}. O−C above 0: observed fainter than computed.", count(residuals.len()));
    picture.paragraph(&caption, [30.0, 1150.0], 912.0, 16.0);
    Ok(picture)
}
