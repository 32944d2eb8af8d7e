//! Chart of the number of trails per exposure against the Sun's altitude.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame};
use super::numbers::{count, fixed, many};
use super::picture::Picture;
use super::statistics::{check, check_length, mean_and_sd};
use super::time_axis::{bands_in_altitude, legend};
use crate::error::Error;

const WIDTH: f64 = 1060.0;
const LEFT: f64 = 92.0;
const RIGHT: f64 = 1030.0;
const RATES: [f64; 2] = [62.0, 430.0];
const NUMBERS: [f64; 2] = [438.0, 520.0];
const DOT: RGBColor = RGBColor(150, 150, 150);
const ALL: RGBColor = RGBColor(0, 114, 178);
const BRIGHT: RGBColor = RGBColor(213, 94, 0);

/// Exposures, each with the altitude of the Sun.
#[derive(Clone, Debug)]
pub struct SunAltitude<'a> {
    /// Title.
    pub title: &'a str,
    /// Text that follows the number of exposures in the caption.
    pub caption: &'a str,
    /// Altitude of the Sun at the middle of the exposure, degrees; shape `(n_exposure)`.
    pub sun_altitude_deg: &'a [f64],
    /// Number of sunlit satellites that cross the field, 0 or more; shape `(n_exposure)`.
    pub n_trails: &'a [f64],
    /// Number of these satellites that are brighter than a limit, and the limit, mag; shape `(n_exposure)`.
    pub n_bright: Option<(&'a [f64], f64)>,
    /// Width of the bins, degrees, 0.1 to 30.
    pub bin_deg: f64,
}

/// Draws the mean number of trails per exposure in bins of the Sun's altitude, with the standard error of each mean,
/// over points for the single exposures. A panel below shows the number of exposures in each bin. The altitude
/// decreases from left to right.
///
/// # Errors
/// There is no exposure; columns differ in length; values are not finite; an altitude is invalid; or the bin width is
/// out of range.
pub fn sun_altitude(input: &SunAltitude<'_>) -> Result<Picture, Error> {
    let out = |what: &str, given: String, allowed| Err(Error::invalid(what, given, allowed));
    check("exposures", input.sun_altitude_deg)?;
    let n = input.sun_altitude_deg.len();
    check_length("numbers of trails", input.n_trails, n)?;
    if let Some((bright, limit)) = input.n_bright {
        check_length("numbers of bright trails", bright, n)?;
        check("the limit", &[limit])?;
    }
    if !(0.1..=30.0).contains(&input.bin_deg) {
        return out("the width of bins", format!("{}°", input.bin_deg), "0.1 to 30°");
    }
    if let Some(wrong) = input.sun_altitude_deg.iter().find(|altitude| !(-90.0..=90.0).contains(*altitude)) {
        return out("an altitude of the Sun", format!("{wrong}°"), "-90 to 90°");
    }
    let (low, high) =
        input.sun_altitude_deg.iter().fold((90.0_f64, -90.0_f64), |(low, high), a| (low.min(*a), high.max(*a)));
    let ends = [(high / input.bin_deg).ceil() * input.bin_deg, (low / input.bin_deg).floor() * input.bin_deg];
    let x = Axis::linear(ends[0], if ends[0] - ends[1] < 1e-9 { ends[0] - input.bin_deg } else { ends[1] });
    let all = means(input.sun_altitude_deg, input.n_trails, &x, input.bin_deg);
    let bright = input.n_bright.map(|(bright, _)| means(input.sun_altitude_deg, bright, &x, input.bin_deg));
    let highest = all.iter().map(|bin| bin.mean + bin.error).fold(0.0, f64::max);
    // The means determine the range of the axis. If the numbers of trails of single exposures determined it, means of a
    // hundredth of a trail would not be visible.
    let top = (1.3 * highest).max(0.02);
    let rates = Frame { sides: [LEFT, RATES[0], RIGHT, RATES[1]], x, y: Axis::linear(-0.03 * top, top) };
    let most = all.iter().map(|bin| bin.count).max().unwrap_or(1);
    let numbers = Frame { sides: [LEFT, NUMBERS[0], RIGHT, NUMBERS[1]], x, y: Axis::linear(0.0, 1.15 * most as f64) };

    let mut picture = Picture::new(WIDTH as usize, 694);
    picture.set_title(input.title, (WIDTH / 2.0, 28.0), 22.0, HPos::Center);
    bands_in_altitude(&mut picture, &numbers);
    let bands = bands_in_altitude(&mut picture, &rates);
    // Every point is drawn as a mark, because the coloured bands would hide painted pixels.
    for (&altitude, &trails) in input.sun_altitude_deg.iter().zip(input.n_trails) {
        if rates.holds(altitude, trails) {
            let (x, y) = rates.at(altitude, trails);
            picture.rectangle([x - 1.5, y - 1.5, x + 1.5, y + 1.5], DOT.mix(0.5));
        }
    }
    for bin in &all {
        let (left, top) = numbers.at(bin.from, bin.count as f64);
        let right = numbers.at(bin.to, 0.0).0;
        picture.rectangle([left + 0.5, top, right - 0.5, NUMBERS[1]], DOT.to_rgba());
    }
    series(&mut picture, &rates, &all, ALL, false);
    if let Some(bright) = &bright {
        series(&mut picture, &rates, bright, BRIGHT, true);
    }
    rates.draw(&mut picture, [false, true]);
    numbers.draw(&mut picture, [true, true]);
    numbers.name_x(&mut picture, "altitude of the Sun, °");
    rates.name_y(&mut picture, "trails per exposure", 62.0);
    numbers.name_y(&mut picture, "exposures", 62.0);

    let y = 594.0;
    picture.line(&[(LEFT, y), (LEFT + 30.0, y)], ALL.to_rgba(), 3.0);
    let mut from = picture.legend_text("mean ± its error", LEFT + 38.0, y);
    picture.rectangle([from + 6.0, y - 1.5, from + 9.0, y + 1.5], DOT.to_rgba());
    from = picture.legend_text("single exposure", from + 16.0, y);
    if let Some((_, limit)) = input.n_bright {
        picture.dashed(&[(from, y), (from + 30.0, y)], [10.0, 6.0], BRIGHT.to_rgba(), 3.0);
        let decimals = usize::from((limit - limit.round()).abs() > 1e-9);
        picture.legend_text(&format!("brighter than {} mag", fixed(limit, decimals)), from + 38.0, y);
    }
    // Curves and twilight bands together are wider than the picture.
    legend(&mut picture, &bands, LEFT, y + 26.0);
    let beyond = match input.n_trails.iter().filter(|trails| !rates.y.holds(**trails)).count() {
        0 => String::new(),
        beyond => format!("; {} with more than the axis shows", count(beyond)),
    };
    let (mean, _) = mean_and_sd(input.n_trails);
    let caption = format!(
        "{}, {} trails per exposure on average{beyond}. {}",
        many(n, "exposure", "exposures"),
        fixed(mean, 2),
        input.caption
    );
    picture.paragraph(&caption, [LEFT, WIDTH - 24.0], 652.0, 16.0);
    Ok(picture)
}

/// Exposures in one bin of the Sun's altitude.
struct Bin {
    from: f64,
    to: f64,
    count: usize,
    mean: f64,
    error: f64,
}

/// Returns the bins in order of decreasing altitude, without the empty ones.
fn means(altitudes: &[f64], trails: &[f64], x: &Axis, width: f64) -> Vec<Bin> {
    let bins = ((x.from - x.to) / width).round().max(1.0) as usize;
    let mut held = vec![Vec::new(); bins];
    for (altitude, trails) in altitudes.iter().zip(trails) {
        held[(((x.from - altitude) / width) as usize).min(bins - 1)].push(*trails);
    }
    let bin = |(index, trails): (usize, Vec<f64>)| {
        let (mean, sd) = mean_and_sd(&trails);
        let from = x.from - width * index as f64;
        // Standard error of the mean, s / √n.
        Bin { from, to: from - width, count: trails.len(), mean, error: sd / (trails.len() as f64).sqrt() }
    };
    held.into_iter().enumerate().filter(|(_, trails)| !trails.is_empty()).map(bin).collect()
}

/// Draws a line through the means of neighbouring bins, each mean with its error.
fn series(picture: &mut Picture, frame: &Frame, bins: &[Bin], colour: RGBColor, is_dashed: bool) {
    let middle = |bin: &Bin| (bin.from + bin.to) / 2.0;
    for run in bins.chunk_by(|bin, next| (bin.to - next.from).abs() < 1e-9) {
        let line: Vec<_> = run.iter().map(|bin| frame.at(middle(bin), bin.mean)).collect();
        match is_dashed {
            true => picture.dashed(&line, [10.0, 6.0], colour.to_rgba(), 3.0),
            false => picture.line(&line, colour.to_rgba(), 3.0),
        }
    }
    for bin in bins {
        let (x, y) = frame.at(middle(bin), bin.mean);
        let (low, high) =
            (frame.at(middle(bin), bin.mean - bin.error).1, frame.at(middle(bin), bin.mean + bin.error).1);
        picture.line(&[(x, low), (x, high)], colour.to_rgba(), 2.0);
        // Dots of the dashed line are open, so that both lines remain visible where they coincide.
        picture.dot((x, y), if is_dashed { RGBColor(255, 255, 255) } else { colour });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_bins_hold_what_lies_in_them() {
        let x = Axis::linear(0.0, -6.0);
        let bins = means(&[-0.5, -1.5, -1.9, -5.0, -6.0], &[2.0, 4.0, 0.0, 1.0, 3.0], &x, 2.0);
        let shown: Vec<_> = bins.iter().map(|bin| (bin.from, bin.count, bin.mean)).collect();
        assert_eq!(shown, [(0.0, 3, 2.0), (-4.0, 2, 2.0)]);
        // s = 2, n = 3
        assert!((bins[0].error - 2.0 / 3_f64.sqrt()).abs() < 1e-12);
    }
}
