//! Corner plots: posterior distributions of each parameter and of each pair of parameters.

use colorous::BLUES;
use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame, NAME_SIZE};
use super::density::Density;
use super::error;
use super::numbers::with_errors;
use super::picture::{INK, Picture, width_of};
use super::statistics::{ONE_SIGMA, check, check_length, histogram, sorted};
use crate::error::Error;
use crate::math::quantile::quantile;

/// Fractions of a two-dimensional normal distribution within one sigma and within two sigma, 1 − exp(−1/2) and 1 −
/// exp(−2).
const CONTAINED: [f64; 2] = [0.393, 0.865];
/// Fraction of the samples that an axis may omit at each end.
const OMITTED: f64 = 0.001;
/// Margin of an axis beyond its samples at each end, as a fraction of their range.
const MARGIN: f64 = 0.08;
const HISTOGRAM: RGBColor = RGBColor(158, 202, 225);
const TRUTH: RGBColor = RGBColor(213, 94, 0);
const LEGEND: &str = "Dashed: quantiles 0.16, 0.5 and 0.84. Lines: the densest 39.3 and 86.5 % of the samples.";
const LEGEND_WITH_TRUTHS: &str =
    "Dashed: quantiles 0.16, 0.5 and 0.84. Lines: the densest 39.3 and 86.5 % of the samples. Orange: true values.";
const GAP: f64 = 12.0;
/// Largest distance, pixels, by which labels may extend past the border of their panel, so that labels of neighbouring
/// panels do not overlap.
const BEYOND_PANEL: f64 = 0.5 * GAP - 2.0;
const BELOW: f64 = 66.0;
const RIGHT: f64 = 22.0;
/// Largest width of the picture and largest width of a panel, pixels.
const WIDEST: f64 = 1560.0;
const WIDEST_PANEL: f64 = 230.0;

/// Samples of a posterior.
#[derive(Clone, Debug)]
pub struct Corner<'a> {
    /// Title; may be empty.
    pub title: &'a str,
    /// Name of each of the 2 to 9 parameters, including the unit if there is one; shape `(n_param)`.
    pub names: &'a [String],
    /// Samples of each parameter in its unit, finite; columns of equal length; shape `(n_param)`.
    pub samples: &'a [Vec<f64>],
    /// True values, if known; drawn as orange lines; shape `(n_param)`.
    pub truths: Option<&'a [f64]>,
    /// Lower and upper bounds of each parameter, past which its axis does not extend; shape `(n_param)`.
    pub bounds: Option<&'a [[f64; 2]]>,
}

/// Draws histograms on the diagonal, with dashed lines at the quantiles 0.16, 0.5 and 0.84 and their values above.
/// Below the diagonal, each pair of parameters is drawn with darker colours for more samples and with lines around the
/// densest 39.3 and 86.5 % of the samples.
///
/// Axes contain at least 99.8 % of the samples and the true values. Axes and lines end at the bounds.
///
/// # Errors
/// There are fewer than 2 or more than 9 parameters; columns, names, true values or bounds differ in length; or samples
/// are missing or not finite.
pub fn corner(input: &Corner<'_>) -> Result<Picture, Error> {
    let axes = axes(input)?;
    let count = axes.len();
    let titles: Vec<Vec<String>> = (0..count).map(|i| title(&input.names[i], &input.samples[i])).collect();
    // A first estimate of the panel size determines the width of the labels at the left of the picture.
    let guess = (WIDEST / (count as f64 + 1.0)).min(WIDEST_PANEL);
    let frame_of = |sides, x: usize, y: usize| Frame { sides, x: axes[x], y: axes[y] };
    let widest_label = (1..count).map(|i| frame_of([0.0, 0.0, guess, guess], 0, i).y_label_width()).fold(0.0, f64::max);
    let left = widest_label + 52.0;
    let beyond = |panel: f64| {
        let widths = titles[count - 1].iter().map(|line| width_of(line, NAME_SIZE));
        (widths.fold(0.0, f64::max) - panel).max(0.0) + RIGHT
    };
    let gaps = GAP * (count as f64 - 1.0);
    let panel = ((WIDEST - left - gaps - beyond(guess)) / count as f64).clamp(60.0, WIDEST_PANEL).floor();
    let is_titled = !input.title.is_empty();
    let lines = titles.iter().map(Vec::len).max().unwrap_or(1) as f64;
    let top = 14.0 + 24.0 * lines + if is_titled { 36.0 } else { 0.0 };
    let side = count as f64 * panel + gaps;
    let mut picture = Picture::new((left + side + beyond(panel)) as usize, (top + side + BELOW) as usize);
    if is_titled {
        picture.set_title(input.title, (left, 26.0), 23.0, HPos::Left);
    }
    // The legend is placed in the free area above the diagonal.
    let first = left + count.div_ceil(2) as f64 * (panel + GAP);
    let legend = if input.truths.is_some() { LEGEND_WITH_TRUTHS } else { LEGEND };
    picture.paragraph(legend, [first, left + side + beyond(panel) - 8.0], top + 12.0, 16.0);
    for (row, title) in titles.iter().enumerate() {
        for column in 0..=row {
            let (x, y) = (left + column as f64 * (panel + GAP), top + row as f64 * (panel + GAP));
            let frame = frame_of([x, y, x + panel, y + panel], column, row);
            let is_below = row + 1 == count;
            if row == column {
                histogram_panel(&mut picture, input, &frame, row, is_below);
                for (line, text) in title.iter().rev().enumerate() {
                    picture.text(text, (x, y - 16.0 - 24.0 * line as f64), NAME_SIZE, HPos::Left);
                }
            } else {
                pair(&mut picture, input, &frame, [column, row], [is_below, column == 0]);
            }
            if is_below {
                frame.name_x(&mut picture, &truncated(&input.names[column], panel + GAP - 4.0));
            }
            if column == 0 && row > 0 {
                frame.name_y(&mut picture, &truncated(&input.names[row], panel + GAP - 4.0), widest_label + 30.0);
            }
        }
    }
    Ok(picture)
}

/// Checks the input and returns an axis for each parameter.
fn axes(input: &Corner<'_>) -> Result<Vec<Axis>, Error> {
    let count = input.samples.len();
    if !(2..=9).contains(&count) {
        let what = "the number of parameters of a corner plot".to_owned();
        return Err(Error::invalid(what, count, "2 to 9"));
    }
    let unequal = |what: &str, given: usize| error::length(what, given, count);
    if input.names.len() != count {
        return Err(unequal("names of parameters", input.names.len()));
    }
    if let Some(truths) = input.truths {
        if truths.len() != count {
            return Err(unequal("true values of parameters", truths.len()));
        }
        check("true values of parameters", truths)?;
    }
    if let Some(bounds) = input.bounds.filter(|bounds| bounds.len() != count) {
        return Err(unequal("bounds of parameters", bounds.len()));
    }
    let expected = input.samples[0].len();
    let axis = |(index, (name, samples)): (usize, (&String, &Vec<f64>))| {
        check_length(&format!("samples of {name}"), samples, expected)?;
        let sorted = sorted(samples);
        let (low, high) = (quantile(&sorted, OMITTED), quantile(&sorted, 1.0 - OMITTED));
        let truth = input.truths.map(|truths| truths[index]);
        let (low, high) = (truth.map_or(low, |truth| low.min(truth)), truth.map_or(high, |truth| high.max(truth)));
        let margin = MARGIN * (high - low);
        let [least, greatest] = input.bounds.map_or([f64::NEG_INFINITY, f64::INFINITY], |bounds| bounds[index]);
        // The axis always contains the samples and the true values, even those outside the bounds.
        Ok(Axis::linear((low - margin).max(least.min(low)), (high + margin).min(greatest.max(high))))
    };
    input.names.iter().zip(input.samples).enumerate().map(axis).collect()
}

/// Returns a title such as `c1 = 0.0123 +0.0004 −0.0003`; a long name is on its own line.
fn title(name: &str, samples: &[f64]) -> Vec<String> {
    let sorted = sorted(samples);
    let [low, middle, high] = ONE_SIGMA.map(|share| quantile(&sorted, share));
    let value = with_errors(middle, high - middle, middle - low);
    if name.chars().count() <= 8 { vec![format!("{name} = {value}")] } else { vec![format!("{name} ="), value] }
}

/// Returns a name, truncated to a width in pixels.
fn truncated(name: &str, width: f64) -> String {
    let mut cut = name.to_owned();
    let mut shown = cut.clone();
    while width_of(&shown, NAME_SIZE) > width && cut.pop().is_some() {
        shown = format!("{cut}…");
    }
    shown
}

/// Returns the number of bins for a number of samples, from 16 to 44.
fn bins(samples: usize) -> usize {
    (2.5 * (samples as f64).powf(0.25)).clamp(16.0, 44.0) as usize
}

fn histogram_panel(picture: &mut Picture, input: &Corner<'_>, frame: &Frame, index: usize, is_below: bool) {
    let samples = &input.samples[index];
    let bins = bins(samples.len());
    let counts = histogram(samples, &frame.x, bins);
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let frame = Frame { y: Axis::linear(0.0, 1.08 * most), ..*frame };
    let mut outline = vec![frame.at(frame.x.from, 0.0)];
    for (bin, count) in counts.iter().enumerate() {
        let side = |bin: usize| frame.x.value(bin as f64 / bins as f64);
        outline.push(frame.at(side(bin), *count as f64));
        outline.push(frame.at(side(bin + 1), *count as f64));
    }
    outline.push(frame.at(frame.x.to, 0.0));
    picture.patch(outline.clone(), HISTOGRAM.to_rgba());
    picture.line(&outline, INK.to_rgba(), 1.2);
    let sorted = sorted(samples);
    for share in ONE_SIGMA {
        let value = quantile(&sorted, share);
        let line = [frame.at(value, 0.0), frame.at(value, frame.y.to)];
        picture.dashed(&line, [6.0, 4.0], INK.to_rgba(), 1.4);
    }
    if let Some(truths) = input.truths {
        picture.line(&[frame.at(truths[index], 0.0), frame.at(truths[index], frame.y.to)], TRUTH.to_rgba(), 2.0);
    }
    // The counts have no labels, because only the shape of the histogram matters.
    frame.draw_without_y(picture, is_below, BEYOND_PANEL);
}

fn pair(picture: &mut Picture, input: &Corner<'_>, frame: &Frame, [column, row]: [usize; 2], labels: [bool; 2]) {
    let (x, y) = (&input.samples[column], &input.samples[row]);
    let is_end = |parameter: usize, end: f64| input.bounds.is_some_and(|bounds| bounds[parameter].contains(&end));
    let walls = [frame.x.from, frame.x.to].map(|end| is_end(column, end));
    let walls = [walls, [frame.y.from, frame.y.to].map(|end| is_end(row, end))];
    let density = Density::new(x, y, frame, bins(x.len()));
    let most = density.most();
    let colour = |count: f64| {
        let colour = BLUES.eval_continuous(0.12 + 0.78 * count / most);
        [colour.r, colour.g, colour.b]
    };
    picture.paint(density.pixels(frame, colour));
    for line in density.lines_around(frame, &CONTAINED, walls) {
        picture.line(&line, INK.to_rgba(), 1.4);
    }
    if let Some(truths) = input.truths {
        let (x, y) = (truths[column], truths[row]);
        picture.line(&[frame.at(x, frame.y.from), frame.at(x, frame.y.to)], TRUTH.to_rgba(), 1.6);
        picture.line(&[frame.at(frame.x.from, y), frame.at(frame.x.to, y)], TRUTH.to_rgba(), 1.6);
    }
    frame.draw_within(picture, labels, BEYOND_PANEL);
}
