//! Magnitudes against phase angle, measured and modelled side by side.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use crate::math::quantile::quantile;

use super::axes::{Axis, Frame};
use super::dots::dots;
use super::error::PlotError;
use super::numbers::{count, many};
use super::picture::Picture;
use super::statistics::{Stretch, check, check_length, running_band, sorted};

const MEASURED: RGBColor = RGBColor(0, 114, 178);
const MODEL: RGBColor = RGBColor(213, 94, 0);
/// Bins of the running medians.
const BINS: usize = 36;
/// Share of the magnitudes that the axis may leave out at each end.
const BEYOND: f64 = 0.002;

/// Magnitudes at phase angles.
#[derive(Clone, Debug)]
pub struct PhaseCurve<'a> {
    /// Above.
    pub title: &'a str,
    /// What the magnitudes are: `magnitude V at 1000 km`.
    pub magnitude_name: &'a str,
    /// `(n_point)` Sun, satellite, observer: 0 to π, radians.
    pub phase_angle_rad: &'a [f64],
    /// `(n_point)` measured, finite.
    pub measured_mag: &'a [f64],
    /// `(n_point)` of the model in the same geometry, finite; empty where there is no model, and one panel is drawn.
    pub model_mag: &'a [f64],
}

/// Draws measured magnitudes against phase angle, those of the model beside on the same axes, and the running medians of both in both; bright
/// is up.
///
/// The axis of magnitudes holds at least 99.6 % of either; how many points lie beyond is said.
///
/// # Errors
/// No point, columns of unequal length, a value that is not finite, a phase angle that is none.
pub fn phase_curve(input: &PhaseCurve<'_>) -> Result<Picture, PlotError> {
    check("phase angles", input.phase_angle_rad)?;
    check_length("measured magnitudes", input.measured_mag, input.phase_angle_rad.len())?;
    let phase: Vec<f64> = input.phase_angle_rad.iter().map(|angle| angle.to_degrees()).collect();
    if let Some(wrong) = phase.iter().find(|angle| !(0.0..=180.0).contains(*angle)) {
        let (what, given) = ("phase angle".to_owned(), format!("{wrong}°"));
        return Err(PlotError::OutOfRange { what, given, allowed: "0 to 180°" });
    }
    let mut panels = vec![("measured", MEASURED, input.measured_mag)];
    if !input.model_mag.is_empty() {
        check_length("magnitudes of the model", input.model_mag, phase.len())?;
        panels.push(("model", MODEL, input.model_mag));
    }
    let ends = panels.iter().map(|(_, _, magnitudes)| {
        let sorted = sorted(magnitudes);
        (quantile(&sorted, BEYOND), quantile(&sorted, 1.0 - BEYOND))
    });
    let (bright, faint) =
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |all, one| (all.0.min(one.0), all.1.max(one.1)));
    let room = 0.05 * (faint - bright);
    // Down to the faint: a single value has its room turned round as well.
    let up = Axis::linear(bright - room, faint + room);
    let y = Axis { from: up.to, to: up.from, is_log: false };
    let (least, greatest) = phase.iter().fold((180.0_f64, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    let room = 0.03 * (greatest - least);
    let x = Axis::linear(least - room, greatest + room);

    let width = if panels.len() == 1 { 640.0 } else { 560.0 };
    let whole = 92.0 + panels.len() as f64 * (width + 20.0) + 8.0;
    let mut picture = Picture::new(whole as usize, 660);
    picture.text(input.title, (whole / 2.0, 28.0), 22.0, HPos::Center);
    let medians: Vec<Vec<Stretch>> =
        panels.iter().map(|(_, _, magnitudes)| running_band(&phase, magnitudes, &x, BINS)).collect();
    for (index, (name, colour, magnitudes)) in panels.iter().enumerate() {
        let left = 92.0 + index as f64 * (width + 20.0);
        let frame = Frame { sides: [left, 84.0, left + width, 540.0], x, y };
        picture.paint(dots(&frame, &phase, magnitudes, mixed(*colour)));
        let lines: Vec<(usize, Vec<_>)> = medians
            .iter()
            .enumerate()
            .flat_map(|(of, all)| all.iter().map(move |stretch| (of, stretch)))
            .map(|(of, stretch)| (of, stretch.iter().map(|(x, [_, median, _])| frame.at(*x, *median)).collect()))
            .collect();
        // Light lines below keep them apart from the points; below all of them, that none breaks another.
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
        from = picture.words(&format!("running median, {name}"), from + 42.0, 612.0);
    }
    let out = |magnitudes: &[f64]| magnitudes.iter().filter(|magnitude| !y.holds(**magnitude)).count();
    let beyond = match panels.iter().map(|(_, _, magnitudes)| out(magnitudes)).sum() {
        0 => String::new(),
        beyond => format!("; {} beyond the axis", many(beyond, "magnitude", "magnitudes")),
    };
    picture.paragraph(&format!("n = {}{beyond}.", count(phase.len())), [30.0, whole - 30.0], 640.0, 16.0);
    Ok(picture)
}

/// Half way to white: dots are lighter than the lines over them.
fn mixed(colour: RGBColor) -> RGBColor {
    let half = |channel: u8| channel / 2 + 127;
    RGBColor(half(colour.0), half(colour.1), half(colour.2))
}
