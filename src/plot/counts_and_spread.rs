//! Number of samples in cells of viewing geometry against the spread of their magnitudes, with the thresholds of the
//! fit: figure 3 of Lu (2024).

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame, colour_bar};
use super::density::Density;
use super::numbers::{count, fixed, per_cent};
use super::picture::{Picture, width_of};
use super::scale::{ColourScale, Quantity};
use super::statistics::{check, check_length, sorted};
use crate::error::Error;
use crate::math::quantile::quantile;

const LINE: RGBColor = RGBColor(0, 114, 178);
const THRESHOLD: RGBColor = RGBColor(213, 94, 0);
/// Number of density bins along each side.
const BINS: usize = 48;
/// Fraction of the cells whose spread may be beyond the end of the axis.
const BEYOND: f64 = 0.005;

/// Numbers of samples and spreads of cells, and the thresholds for both.
#[derive(Clone, Debug)]
pub struct CountsAndSpread<'a> {
    /// Title.
    pub title: &'a str,
    /// Number of samples in each cell, 1 or more; shape `(n_cell)`.
    pub counts: &'a [f64],
    /// Interquartile range of each cell's magnitudes, 0 or more, mag; shape `(n_cell)`.
    pub iqr_mag: &'a [f64],
    /// Smallest number of samples with which a cell is kept, 1 or more; 80 in the paper.
    pub least_count: f64,
    /// Largest spread with which a cell is kept, mag, above 0; 0.4 mag in the paper.
    pub most_iqr_mag: f64,
}

/// Draws the density of cells by number of samples and spread, the cumulative fractions of cells in panels above and to
/// the right, and both thresholds with the fraction of cells that are kept.
///
/// # Errors
/// There is no cell; columns differ in length; a value is not finite; a count is below 1 or a spread below 0; or a
/// threshold is invalid (fewer than 1 sample, 0 mag).
pub fn counts_and_spread(input: &CountsAndSpread<'_>) -> Result<Picture, Error> {
    check("samples of cells", input.counts)?;
    check_length("spreads of cells", input.iqr_mag, input.counts.len())?;
    let out = |what: &str, given: f64, allowed| Error::invalid(what, given, allowed);
    if let Some(few) = input.counts.iter().find(|count| **count < 1.0) {
        return Err(out("number of samples of a cell", *few, "1 or more"));
    }
    if let Some(negative) = input.iqr_mag.iter().find(|iqr| **iqr < 0.0) {
        return Err(out("interquartile range of a cell", *negative, "0 mag or more"));
    }
    if !(input.least_count.is_finite() && input.least_count >= 1.0) {
        return Err(out("least number of samples", input.least_count, "1 or more"));
    }
    if !(input.most_iqr_mag.is_finite() && input.most_iqr_mag > 0.0) {
        return Err(out("greatest spread", input.most_iqr_mag, "above 0 mag"));
    }
    let (counts, spreads) = (sorted(input.counts), sorted(input.iqr_mag));
    let most = counts[counts.len() - 1].max(1.5 * input.least_count);
    let widest = quantile(&spreads, 1.0 - BEYOND).max(1.25 * input.most_iqr_mag);
    let x = Axis::log(0.9, 1.2 * most);
    let y = Axis::linear(0.0, 1.04 * widest);
    let main = Frame { sides: [88.0, 240.0, 628.0, 760.0], x, y };
    let shares = Axis::linear(0.0, 1.0);
    let upper_frame = Frame { sides: [88.0, 64.0, 628.0, 224.0], x, y: shares };
    let right_frame = Frame { sides: [672.0, 240.0, 816.0, 760.0], x: shares, y };

    let mut picture = Picture::new(930, 900);
    picture.set_title(input.title, (465.0, 28.0), 22.0, HPos::Center);
    let density = Density::new(input.counts, input.iqr_mag, &main, BINS);
    let scale = ColourScale::from_values(Quantity::Count, density.counts.iter().copied().filter(|count| *count > 0.0));
    picture.paint(density.pixels(&main, |count| scale.colour(count)));
    thresholds(&mut picture, input, &main, [true, true]);
    thresholds(&mut picture, input, &upper_frame, [true, false]);
    thresholds(&mut picture, input, &right_frame, [false, true]);
    let up_to =
        |sorted: &[f64], value: f64| sorted.partition_point(|other| *other <= value) as f64 / sorted.len() as f64;
    let steps = |axis: Axis| (0..=400).map(move |part| axis.value(f64::from(part) / 400.0));
    let curve: Vec<_> = steps(x).map(|value| upper_frame.at(value, up_to(&counts, value))).collect();
    picture.line(&curve, LINE.to_rgba(), 2.2);
    let curve: Vec<_> = steps(y).map(|value| right_frame.at(up_to(&spreads, value), value)).collect();
    picture.line(&curve, LINE.to_rgba(), 2.2);
    main.draw(&mut picture, [true, true]);
    upper_frame.draw(&mut picture, [false, true]);
    right_frame.draw(&mut picture, [true, false]);
    main.name_x(&mut picture, "samples in a cell");
    main.name_y(&mut picture, "interquartile range, mag", 56.0);
    upper_frame.name_y(&mut picture, "share of cells", 56.0);
    right_frame.name_x(&mut picture, "share of cells");
    colour_bar(&mut picture, &scale, [844.0, 300.0, 866.0, 760.0], "cells");

    let kept = |(samples, iqr): &(&f64, &f64)| **samples >= input.least_count && **iqr <= input.most_iqr_mag;
    let kept = input.counts.iter().zip(input.iqr_mag).filter(kept).count();
    let share = per_cent(kept as f64 / counts.len() as f64);
    let enough =
        per_cent(counts.iter().filter(|samples| **samples >= input.least_count).count() as f64 / counts.len() as f64);
    let narrow = per_cent(up_to(&spreads, input.most_iqr_mag));
    let text = [format!("kept: {share}"), format!("{} of {} cells", count(kept), count(counts.len()))];
    for (line, text) in text.iter().enumerate() {
        picture.text(text, (672.0, 92.0 + 26.0 * line as f64), 18.0, HPos::Left);
    }
    let beyond = match spreads.iter().filter(|iqr| !y.holds(**iqr)).count() {
        0 => String::new(),
        beyond => format!(" {} cells have a wider spread than the axis shows.", count(beyond)),
    };
    let (least, widest) = (input.least_count, input.most_iqr_mag);
    let caption = format!(
        "{enough} of the cells have {least} samples or more, {narrow} a spread of {widest} mag or less. Curves: cumulative share of cells.{beyond}"
    );
    picture.paragraph(&caption, [30.0, 900.0], 842.0, 17.0);
    Ok(picture)
}

/// Draws the thresholds as dashed lines, with their values where they meet the outer boxes.
fn thresholds(picture: &mut Picture, input: &CountsAndSpread<'_>, frame: &Frame, [has_count, has_spread]: [bool; 2]) {
    let is_main = has_count && has_spread;
    if has_count {
        let line = [(input.least_count, frame.y.from), (input.least_count, frame.y.to)].map(|(x, y)| frame.at(x, y));
        picture.dashed(&line, [7.0, 4.0], THRESHOLD.to_rgba(), 2.0);
        if !is_main {
            let text = fixed(input.least_count, 0);
            let (x, y) = (line[0].0, frame.sides[1] + 16.0);
            let is_right = x + 10.0 + width_of(&text, 16.0) < frame.sides[2];
            let (x, side) = if is_right { (x + 7.0, HPos::Left) } else { (x - 7.0, HPos::Right) };
            picture.text(&text, (x, y), 16.0, side);
        }
    }
    if has_spread {
        let line = [(frame.x.from, input.most_iqr_mag), (frame.x.to, input.most_iqr_mag)].map(|(x, y)| frame.at(x, y));
        picture.dashed(&line, [7.0, 4.0], THRESHOLD.to_rgba(), 2.0);
        if !is_main {
            picture.text(
                &format!("{} mag", input.most_iqr_mag),
                (frame.sides[0] + 8.0, line[0].1 - 13.0),
                16.0,
                HPos::Left,
            );
        }
    }
}
