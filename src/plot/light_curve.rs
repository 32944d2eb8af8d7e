//! Light curve: magnitude along a track with its uncertainty, and the intervals in which the satellite is in the field.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame};
use super::error;
use super::numbers::fixed;
use super::picture::Picture;
use super::statistics::{check, check_length};
use super::time_axis::{LocalClock, draw_local, draw_utc};
use crate::error::Error;

const WIDTH: f64 = 1120.0;
const SIDES: [f64; 4] = [92.0, 118.0, 1090.0, 540.0];
const LINE: RGBColor = RGBColor(0, 114, 178);
const BAND: RGBColor = RGBColor(86, 180, 233);
const FIELD: RGBColor = RGBColor(213, 94, 0);
const SHUTTER: RGBColor = RGBColor(240, 228, 66);
const DARK: RGBColor = RGBColor(150, 150, 150);
const LIMIT: RGBColor = RGBColor(90, 90, 90);

/// Magnitudes of one satellite along its track.
#[derive(Clone, Debug)]
pub struct LightCurve<'a> {
    /// Title.
    pub title: &'a str,
    /// Caption below the chart.
    pub caption: &'a str,
    /// Times, MJD (UTC), increasing; shape `(n_point)`.
    pub time_mjd: &'a [f64],
    /// Magnitudes; NaN in the Earth's shadow; shape `(n_point)`.
    pub magnitude: &'a [f64],
    /// Uncertainties (one sigma) of the magnitudes, mag; NaN if unknown; shape `(n_point)`.
    pub sigma_mag: &'a [f64],
    /// False where the geometry is more than 10 degrees from that of the fitted measurements; shape `(n_point)`, or
    /// empty if unknown.
    pub in_fitted_range: &'a [bool],
    /// Intervals in which the satellite is in the field: entry and exit, MJD (UTC).
    pub in_field: &'a [[f64; 2]],
    /// Opening and closing of the shutter, MJD (UTC).
    pub shutter: Option<[f64; 2]>,
    /// Magnitude limit, drawn as a dashed line.
    pub limit_mag: Option<f64>,
    /// Clock of the upper axis; `None` for no upper axis.
    pub local: Option<LocalClock>,
}

/// Draws magnitudes against time, with brighter magnitudes higher, and a band of one sigma, which the caption explains.
/// The line is dashed outside the fitted geometry. Vertical lines with times mark entry into and exit from the field;
/// grey marks intervals in which the satellite is dark.
///
/// # Errors
/// There are fewer than two points, or none of them has a magnitude; columns differ in length; or times are not finite
/// or do not increase.
pub fn light_curve(input: &LightCurve<'_>) -> Result<Picture, Error> {
    check("points along the track", input.time_mjd)?;
    let n = input.time_mjd.len();
    for (what, column) in [("magnitudes", input.magnitude), ("sigmas", input.sigma_mag)] {
        if column.len() != n {
            return Err(error::length(what, column.len(), n));
        }
    }
    if !input.in_fitted_range.is_empty() && input.in_fitted_range.len() != n {
        return Err(error::length("marks of the fitted range", input.in_fitted_range.len(), n));
    }
    if n < 2 || input.time_mjd.windows(2).any(|pair| pair[0] >= pair[1]) {
        let (what, given) = ("the list of times of a track".to_owned(), format!("not increasing ({n} values)"));
        return Err(Error::invalid(what, given, "two or more, each later than the one before"));
    }
    let lit: Vec<f64> = input.magnitude.iter().copied().filter(|magnitude| magnitude.is_finite()).collect();
    check_length("magnitudes along the track", &lit, lit.len())?;
    let sigma = |k: usize| if input.sigma_mag[k].is_finite() { input.sigma_mag[k] } else { 0.0 };
    let edges = (0..n).filter(|k| input.magnitude[*k].is_finite());
    let (bright, faint) = edges.fold((f64::INFINITY, f64::NEG_INFINITY), |(bright, faint), k| {
        (bright.min(input.magnitude[k] - sigma(k)), faint.max(input.magnitude[k] + sigma(k)))
    });
    let (bright, faint) = match input.limit_mag {
        Some(limit) => (bright.min(limit), faint.max(limit)),
        None => (bright, faint),
    };
    let margin = (0.07 * (faint - bright)).max(0.1);
    let span = input.time_mjd[n - 1] - input.time_mjd[0];
    let frame = Frame {
        sides: SIDES,
        x: Axis::linear(input.time_mjd[0] - 0.015 * span, input.time_mjd[n - 1] + 0.015 * span),
        y: Axis { from: faint + margin, to: bright - margin, is_log: false },
    };
    let [left, top, right, bottom] = SIDES;
    let mut picture = Picture::new(WIDTH as usize, 716);
    picture.set_title(input.title, (WIDTH / 2.0, 28.0), 22.0, HPos::Center);
    let across = |mjd: f64| frame.at(mjd, frame.y.from).0;
    if let Some([open, close]) = input.shutter {
        picture.rectangle([across(open), top, across(close), bottom], SHUTTER.mix(0.22));
    }
    for interval in dark_intervals(input) {
        picture.rectangle([across(interval[0]), top, across(interval[1]), bottom], DARK.mix(0.45));
    }
    if let Some(limit) = input.limit_mag {
        let line = [frame.at(frame.x.from, limit), frame.at(frame.x.to, limit)];
        picture.dashed(&line, [9.0, 6.0], LIMIT.to_rgba(), 1.8);
    }
    let points: Vec<usize> = (0..n).collect();
    let is_lit = |k: &usize| input.magnitude[*k].is_finite();
    let runs: Vec<&[usize]> = points.chunk_by(|a, b| is_lit(a) == is_lit(b)).filter(|run| is_lit(&run[0])).collect();
    let is_fitted = |k: usize| input.in_fitted_range.get(k).copied().unwrap_or(true);
    for run in &runs {
        let at = |k: usize, sigmas: f64| frame.at(input.time_mjd[k], input.magnitude[k] + sigmas * sigma(k));
        let upper = run.iter().map(|&k| at(k, -1.0));
        let lower = run.iter().rev().map(|&k| at(k, 1.0));
        if run.len() > 1 {
            picture.patch(upper.chain(lower).collect(), BAND.mix(0.4));
        }
        if let [alone] = run {
            picture.dot(at(*alone, 0.0), LINE);
        }
        for part in run.chunk_by(|a, b| is_fitted(*a) == is_fitted(*b)) {
            // A part ends at the first point of the next, so that the line has no gap.
            let next = (part[part.len() - 1] + 1).min(run[run.len() - 1]);
            let line: Vec<_> = (part[0]..=next).map(|k| at(k, 0.0)).collect();
            draw_part(&mut picture, &line, is_fitted(part[0]));
        }
    }
    for (number, [enter, exit]) in input.in_field.iter().enumerate() {
        let (x0, x1) = (across(*enter), across(*exit));
        picture.rectangle([x0, top, x1, bottom], FIELD.mix(0.14));
        for x in [x0, x1] {
            picture.line(&[(x, top), (x, bottom)], FIELD.to_rgba(), 2.0);
        }
        // Only the first interval is labelled; its labels always fit.
        if number == 0 {
            let fits = x0 - left > 60.0 && right - x1 > 60.0;
            let (enter_side, exit_side) = if fits { (HPos::Right, HPos::Left) } else { (HPos::Left, HPos::Right) };
            let y = if fits { [bottom - 16.0; 2] } else { [bottom - 36.0, bottom - 14.0] };
            let shift = if fits { 6.0 } else { -6.0 };
            picture.text("enter", (x0 - shift, y[0]), 16.0, enter_side);
            picture.text("exit", (x1 + shift, y[1]), 16.0, exit_side);
        }
    }
    frame.draw_y(&mut picture);
    frame.name_y(&mut picture, "magnitude", 60.0);
    draw_utc(&mut picture, &frame);
    draw_local(&mut picture, &frame, input.local.as_ref());

    let y = 614.0;
    let mut x = left;
    picture.rectangle([x, y - 8.0, x + 30.0, y + 8.0], BAND.mix(0.4));
    picture.line(&[(x, y), (x + 30.0, y)], LINE.to_rgba(), 3.0);
    x = picture.legend_text("magnitude, ±1σ", x + 38.0, y);
    let has_unfitted = runs.iter().any(|run| run.iter().any(|k| !is_fitted(*k)));
    if has_unfitted {
        draw_part(&mut picture, &[(x, y), (x + 38.0, y)], false);
        x = picture.legend_text("outside the fitted geometry", x + 46.0, y);
    }
    if !input.in_field.is_empty() {
        picture.rectangle([x, y - 8.0, x + 24.0, y + 8.0], FIELD.mix(0.14));
        picture.line(&[(x, y - 8.0), (x, y + 8.0)], FIELD.to_rgba(), 2.0);
        picture.line(&[(x + 24.0, y - 8.0), (x + 24.0, y + 8.0)], FIELD.to_rgba(), 2.0);
        x = picture.legend_text("in the field", x + 32.0, y);
    }
    if input.shutter.is_some() {
        picture.rectangle([x, y - 8.0, x + 24.0, y + 8.0], SHUTTER.mix(0.3));
        picture.border([x, y - 8.0, x + 24.0, y + 8.0], 1.0);
        x = picture.legend_text("shutter open", x + 32.0, y);
    }
    if lit.len() < n {
        picture.rectangle([x, y - 8.0, x + 24.0, y + 8.0], DARK.mix(0.45));
        x = picture.legend_text("not visible", x + 32.0, y);
    }
    if let Some(limit) = input.limit_mag {
        picture.dashed(&[(x, y), (x + 30.0, y)], [9.0, 6.0], LIMIT.to_rgba(), 1.8);
        picture.legend_text(&format!("limit {} mag", fixed(limit, 1)), x + 38.0, y);
    }
    let mut caption = String::new();
    let sigmas = || runs.iter().flat_map(|run| run.iter()).map(|k| input.sigma_mag[*k]).filter(|s| s.is_finite());
    if let Some((least, greatest)) = sigmas().reduce(f64::min).zip(sigmas().reduce(f64::max)) {
        let [least, greatest] = [least, greatest].map(|sigma| fixed(sigma, 1));
        let range = if least == greatest { format!("±{least}") } else { format!("±{least} to ±{greatest}") };
        caption = format!(
            "Band: one sigma of a single measurement, {range} mag: scatter about the brightness model, and errors of \
             colour and position. It is wider outside the geometry of the fitted measurements and near the Earth's \
             shadow. "
        );
    }
    caption += input.caption;
    picture.paragraph(caption.trim_end(), [left, WIDTH - 24.0], 644.0, 16.0);
    Ok(picture)
}

/// Draws a part of the curve, dashed outside the fitted geometry.
fn draw_part(picture: &mut Picture, line: &[(f64, f64)], is_fitted: bool) {
    match is_fitted {
        true => picture.line(line, LINE.to_rgba(), 3.0),
        false => picture.dashed(line, [9.0, 5.0], LINE.to_rgba(), 3.0),
    }
}

/// Returns the intervals in which the satellite is dark: from half way after the last lit point to half way before the
/// next.
fn dark_intervals(input: &LightCurve<'_>) -> Vec<[f64; 2]> {
    let n = input.time_mjd.len();
    let points: Vec<usize> = (0..n).collect();
    let is_lit = |k: usize| input.magnitude[k].is_finite();
    let half = |a: usize, b: usize| (input.time_mjd[a] + input.time_mjd[b]) / 2.0;
    let runs = points.chunk_by(|a, b| is_lit(*a) == is_lit(*b)).filter(|run| !is_lit(run[0]));
    let ends = |run: &[usize]| {
        let (first, last) = (run[0], run[run.len() - 1]);
        let from = if first == 0 { input.time_mjd[0] } else { half(first - 1, first) };
        let to = if last == n - 1 { input.time_mjd[last] } else { half(last, last + 1) };
        [from, to]
    };
    runs.map(ends).collect()
}
