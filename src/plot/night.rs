//! Timeline of a night: exposures with streaks, the brightest magnitude and the number of streaks in each.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame, colour_bar};
use super::error;
use super::numbers::{count, fixed, many, per_cent};
use super::picture::Picture;
use super::scale::{ColourScale, Quantity};
use super::statistics::{check, check_length};
use super::time_axis::{LocalClock, bands_in_time, draw_local, draw_utc, legend};
use crate::error::Error;

const WIDTH: f64 = 1180.0;
const LEFT: f64 = 92.0;
const RIGHT: f64 = 1040.0;
/// Top and bottom of the panel of magnitudes, of the panel of numbers, and of the strip of all exposures, pixels.
const MAGNITUDES: [f64; 2] = [112.0, 430.0];
const NUMBERS: [f64; 2] = [438.0, 528.0];
const STRIP: [f64; 2] = [536.0, 566.0];
const CLEAR: RGBColor = RGBColor(208, 208, 208);
/// Colour of exposures whose streaks have no magnitude, and of exposures that could not be evaluated.
const UNKNOWN: RGBColor = RGBColor(90, 90, 90);
const LIMIT: RGBColor = RGBColor(213, 94, 0);
const DAY_S: f64 = 86_400.0;

/// Exposures of a night.
#[derive(Clone, Debug)]
pub struct NightTimeline<'a> {
    /// Title.
    pub title: &'a str,
    /// Text that follows the number of exposures in the caption.
    pub caption: &'a str,
    /// Times of shutter opening, MJD (UTC), within two days; shape `(n_exposure)`.
    pub start_mjd: &'a [f64],
    /// Exposure times, seconds, 0 or more; shape `(n_exposure)`.
    pub duration_s: &'a [f64],
    /// Number of sunlit satellites that cross the field, 0 or more; shape `(n_exposure)`.
    pub n_streaks: &'a [f64],
    /// Magnitude of the brightest streak, mag; NaN if there is no streak or no magnitude; shape `(n_exposure)`.
    pub brightest_mag: &'a [f64],
    /// Magnitude limit, drawn as a dashed line.
    pub limit_mag: Option<f64>,
    /// Times, MJD (UTC), in order, each with the Sun's altitude, degrees, from which the bands of day and twilight are
    /// drawn. Empty without a site.
    pub sun: &'a [(f64, f64)],
    /// Clock of the upper axis; `None` for no upper axis.
    pub local: Option<LocalClock>,
}

/// Draws three panels: at the top the brightest magnitude of each exposure with streaks (brighter is higher); below it
/// the number of satellites that cross; at the bottom every exposure as a bar, grey if no satellite crosses.
///
/// A night without streaks is drawn with a note.
///
/// # Errors
/// There is no exposure; columns differ in length; a time is not finite; or exposures are more than two days apart.
pub fn night_timeline(input: &NightTimeline<'_>) -> Result<Picture, Error> {
    check("exposures", input.start_mjd)?;
    let n = input.start_mjd.len();
    check_length("lengths of exposures", input.duration_s, n)?;
    check_length("numbers of streaks", input.n_streaks, n)?;
    if input.brightest_mag.len() != n {
        return Err(error::length("brightest magnitudes", input.brightest_mag.len(), n));
    }
    let end = |k: usize| input.start_mjd[k] + input.duration_s[k] / DAY_S;
    let first = input.start_mjd.iter().copied().fold(f64::INFINITY, f64::min);
    let last = (0..n).map(end).fold(f64::NEG_INFINITY, f64::max);
    if last - first > 2.0 {
        let (what, given) = ("the time from first to last exposure".to_owned(), format!("{:.1} d", last - first));
        return Err(Error::invalid(what, given, "at most 2 d; select one night of a longer schedule"));
    }
    let margin = (0.012 * (last - first)).max(20.0 / DAY_S);
    let x = Axis::linear(first - margin, last + margin);

    let height = 696.0;
    let mut picture = Picture::new(WIDTH as usize, height as usize);
    picture.set_title(input.title, (WIDTH / 2.0, 28.0), 22.0, HPos::Center);
    let shown: Vec<f64> = input.brightest_mag.iter().copied().filter(|mag| mag.is_finite()).collect();
    let scale = ColourScale::from_values(Quantity::Magnitude, shown.iter().copied());
    let ends = shown.iter().copied().chain(input.limit_mag).chain(shown.is_empty().then_some(scale.least));
    let (bright, faint) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), mag| (l.min(mag), h.max(mag)));
    let y = Axis { from: (faint + 0.4).ceil(), to: (bright - 0.4).floor(), is_log: false };
    let most = input.n_streaks.iter().copied().fold(1.0, f64::max);
    let frame = |[top, bottom]: [f64; 2], y: Axis| Frame { sides: [LEFT, top, RIGHT, bottom], x, y };
    let magnitudes = frame(MAGNITUDES, y);
    let numbers = frame(NUMBERS, Axis::linear(0.0, (most * 1.15).max(1.15)));
    let strip = frame(STRIP, Axis::linear(0.0, 1.0));

    let mut bands = Vec::new();
    for panel in [&magnitudes, &numbers, &strip] {
        bands = bands_in_time(&mut picture, panel, input.sun);
    }
    if let Some(limit) = input.limit_mag {
        let line = [magnitudes.at(x.from, limit), magnitudes.at(x.to, limit)];
        picture.dashed(&line, [9.0, 6.0], LIMIT.to_rgba(), 2.0);
    }
    let mut order: Vec<usize> = (0..n).collect();
    // Exposures are drawn in order of brightness, so that the brightest are on top.
    let key = |k: usize| input.brightest_mag[k];
    order.sort_by(|a, b| key(*b).total_cmp(&key(*a)));
    for k in order {
        let (start, end, mag) = (input.start_mjd[k], end(k), input.brightest_mag[k]);
        let [red, green, blue] = scale.colour(if mag.is_finite() { mag } else { scale.greatest });
        let colour = match (mag.is_finite(), input.n_streaks[k] > 0.0) {
            (true, _) => RGBColor(red, green, blue),
            (false, true) => UNKNOWN,
            (false, false) => CLEAR,
        };
        let (left, right) = (strip.at(start, 0.0).0, strip.at(end, 0.0).0);
        // Exposures are at least a pixel wide, so that none disappears.
        picture.rectangle([left, STRIP[0] + 1.0, right.max(left + 1.0), STRIP[1] - 1.0], colour.to_rgba());
        if input.n_streaks[k] > 0.0 {
            let middle = (start + end) / 2.0;
            let (bar_x, bar_y) = numbers.at(middle, input.n_streaks[k]);
            let half = ((right - left) / 2.0).max(0.7);
            picture.rectangle([bar_x - half, bar_y, bar_x + half, NUMBERS[1]], UNKNOWN.to_rgba());
            if mag.is_finite() {
                let (across, up) = magnitudes.at(middle, mag);
                picture.line(&[(left, up), (right, up)], colour.to_rgba(), 3.0);
                picture.dot((across, up), colour);
            }
        }
    }
    magnitudes.draw_y(&mut picture);
    numbers.draw_y(&mut picture);
    picture.border(strip.sides, 1.4);
    magnitudes.name_y(&mut picture, "brightest streak, mag", 60.0);
    numbers.name_y(&mut picture, "streaks", 60.0);
    draw_utc(&mut picture, &strip);
    draw_local(&mut picture, &magnitudes, input.local.as_ref());
    if shown.is_empty() {
        let text = match input.n_streaks.iter().any(|number| *number > 0.0) {
            true => "no streak of this night has a magnitude",
            false => "no exposure of this night has a streak",
        };
        let middle = (MAGNITUDES[0] + MAGNITUDES[1]) / 2.0;
        picture.note(text, ((LEFT + RIGHT) / 2.0, middle));
    } else {
        let sides = [RIGHT + 26.0, MAGNITUDES[0] + 26.0, RIGHT + 50.0, NUMBERS[1] - 10.0];
        colour_bar(&mut picture, &scale, sides, &scale.label());
    }

    let mut from = LEFT;
    let baseline = 644.0;
    from = legend(&mut picture, &bands, from, baseline);
    picture.rectangle([from, baseline - 8.0, from + 24.0, baseline + 8.0], CLEAR.to_rgba());
    from = picture.legend_text("clear exposure", from + 31.0, baseline) - 8.0;
    if (0..n).any(|k| input.n_streaks[k] > 0.0 && !input.brightest_mag[k].is_finite()) {
        picture.rectangle([from, baseline - 8.0, from + 24.0, baseline + 8.0], UNKNOWN.to_rgba());
        from = picture.legend_text("streak, no magnitude", from + 31.0, baseline) - 8.0;
    }
    if let Some(limit) = input.limit_mag {
        picture.dashed(&[(from, baseline), (from + 30.0, baseline)], [9.0, 6.0], LIMIT.to_rgba(), 2.0);
        let decimals = usize::from((limit - limit.round()).abs() > 1e-9);
        picture.legend_text(&format!("limit {} mag", fixed(limit, decimals)), from + 37.0, baseline);
    }
    let struck = input.n_streaks.iter().filter(|number| **number > 0.0).count();
    let over = input.limit_mag.map(|limit| shown.iter().filter(|mag| **mag < limit).count());
    let over =
        over.map(|over| format!(", {} with a mean magnitude brighter than the limit", count(over))).unwrap_or_default();
    let caption = format!(
        "{}, {} with streaks ({}){over}. {}",
        many(n, "exposure", "exposures"),
        count(struck),
        per_cent(struck as f64 / n as f64),
        input.caption
    );
    picture.set_scales(vec![scale]);
    picture.paragraph(&caption, [LEFT, WIDTH - 24.0], 674.0, 16.0);
    Ok(picture)
}
