//! Differences of passes from learned magnitudes against time, with alarms.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame};
use super::error;
use super::numbers::count;
use super::picture::{INK, Picture};
use super::statistics::check;
use crate::error::Error;

const WIDTH: f64 = 1120.0;
const SIDES: [f64; 4] = [92.0, 60.0, 1090.0, 540.0];
const QUIET: RGBColor = RGBColor(150, 150, 150);
const ALARM: RGBColor = RGBColor(213, 94, 0);

/// Alarm in the chart.
#[derive(Clone, Debug)]
pub struct AlarmMark {
    /// Days since the origin of the chart.
    pub day: f64,
    /// Difference of the pass, mag; 0 for an alarm of another kind.
    pub difference_mag: f64,
    /// Text beside the mark.
    pub label: String,
}

/// Differences of passes from learned magnitudes.
#[derive(Clone, Debug)]
pub struct AlarmChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Date of the origin of the days.
    pub origin: &'a str,
    /// Days of the passes since the origin; shape `(n_pass)`.
    pub days: &'a [f64],
    /// Differences, mag; positive is fainter; shape `(n_pass)`.
    pub differences_mag: &'a [f64],
    /// One sigma that is expected, mag; shape `(n_pass)`.
    pub sigmas_mag: &'a [f64],
    /// Alarms.
    pub alarms: &'a [AlarmMark],
}

/// Draws a bar of one sigma for each pass at its difference, and a labelled dot for each alarm. Brighter is higher.
///
/// # Errors
/// There is no pass, a value is not finite, or columns differ in length.
pub fn alarm_chart(input: &AlarmChart<'_>) -> Result<Picture, Error> {
    let n = input.days.len();
    for (what, column) in [("days", input.days), ("differences", input.differences_mag), ("sigmas", input.sigmas_mag)] {
        check(what, column)?;
        if column.len() != n {
            return Err(error::length(what, column.len(), n));
        }
    }
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| (least.min(x), most.max(x)))
    };
    let (first, last) = ends(&mut input.days.iter().copied());
    let sides = input.differences_mag.iter().zip(input.sigmas_mag).flat_map(|(mag, sigma)| [mag - sigma, mag + sigma]);
    let marked = input.alarms.iter().map(|mark| mark.difference_mag);
    let (bright, faint) = ends(&mut sides.chain(marked).chain([-1.0, 1.0]));
    let (wide, high) = (0.03 * (last - first).max(0.1), 0.06 * (faint - bright));
    let y = Axis { from: faint + high, to: bright - high, is_log: false };
    let frame = Frame { sides: SIDES, x: Axis::linear(first - wide, last + wide), y };
    let mut picture = Picture::new(WIDTH as usize, 640);
    picture.set_title(input.title, (WIDTH / 2.0, 28.0), 22.0, HPos::Center);
    let zero = [frame.at(frame.x.from, 0.0), frame.at(frame.x.to, 0.0)];
    picture.dashed(&zero, [6.0, 4.0], INK.mix(0.7), 1.2);
    for ((day, mag), sigma) in input.days.iter().zip(input.differences_mag).zip(input.sigmas_mag) {
        picture.line(&[frame.at(*day, mag - sigma), frame.at(*day, mag + sigma)], QUIET.mix(0.5), 1.5);
        picture.dot(frame.at(*day, *mag), QUIET);
    }
    for mark in input.alarms {
        let (x, y) = frame.at(mark.day, mark.difference_mag);
        picture.dot((x, y), ALARM);
        picture.circle((x, y), 9.0, ALARM.to_rgba(), 2.0);
        let (side, shift) = if x > 0.5 * WIDTH { (HPos::Right, -14.0) } else { (HPos::Left, 14.0) };
        picture.text(&mark.label, (x + shift, y), 15.0, side);
    }
    frame.draw(&mut picture, [true, true]);
    frame.name_x(&mut picture, &format!("days since {}", input.origin));
    frame.name_y(&mut picture, "fainter than learned, mag", 58.0);
    let caption = format!("Passes, with one expected sigma: {}. Alarms: {}.", count(n), count(input.alarms.len()));
    picture.paragraph(&caption, [SIDES[0], SIDES[2]], 612.0, 16.0);
    Ok(picture)
}
