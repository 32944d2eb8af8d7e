//! The colour bar: what the colours of a picture stand for.

use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::picture::{INK, Picture, Pixels};
use super::scale::ColourScale;

/// Steps of colour a pixel.
const FINE: f64 = 2.0;
const SIZE: f64 = 19.0;

/// A bar with this left, top, right and bottom, ticks at its right, and words above.
pub(super) fn colour_bar(picture: &mut Picture, scale: &ColourScale, sides: [f64; 4], words: &str) {
    let [left, top, right, bottom] = sides;
    let steps = ((bottom - top) * FINE).max(1.0) as usize;
    let colour = |step: usize| Some(scale.colour_at(1.0 - (step as f64 + 0.5) / steps as f64));
    let each = (right - left, (bottom - top) / steps as f64);
    let colours = (0..steps).map(colour).collect();
    picture.paint(Pixels { corner: (left, top), each, columns: 1, colours, within: None });
    picture.border(sides, 1.4);
    for (value, label) in scale.ticks() {
        let y = bottom - (bottom - top) * scale.share(value);
        picture.line(&[(right, y), (right + 6.0, y)], INK.to_rgba(), 1.4);
        picture.text(&label, (right + 11.0, y), SIZE, HPos::Left);
    }
    picture.text(words, (left, top - 20.0), SIZE, HPos::Left);
}
