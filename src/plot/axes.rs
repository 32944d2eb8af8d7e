//! Boxes with axes, ticks and labels, and colour bars.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::numbers::labels;
use super::picture::{INK, Picture, Pixels, lines_of, width_of};
use super::scale::ColourScale;

/// Font sizes of tick labels and of axis names, pixels.
pub(super) const TICK_SIZE: f64 = 16.0;
pub(super) const NAME_SIZE: f64 = 18.0;

/// Smallest gap between two tick labels, pixels.
const LABEL_GAP: f64 = 12.0;

/// Range of values along one side of a box.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// Value at the left or lower end.
    pub from: f64,
    /// Value at the right or upper end; less than `from` for a reversed axis.
    pub to: f64,
    /// True for a logarithmic axis; both ends are positive.
    pub is_log: bool,
}

/// Box in a picture with two axes.
#[derive(Copy, Clone, Debug)]
pub(super) struct Frame {
    /// Positions of the left, top, right and bottom sides, pixels.
    pub sides: [f64; 4],
    /// Axis along the bottom.
    pub x: Axis,
    /// Axis along the left side.
    pub y: Axis,
}

impl Axis {
    /// Creates a linear axis; it is widened if both ends are equal.
    pub fn linear(from: f64, to: f64) -> Self {
        // If the ends differ by only a few bits, all ticks would coincide.
        if (to - from).abs() > 1e-12 * from.abs().max(to.abs()) {
            return Self { from, to, is_log: false };
        }
        let margin = if from == 0.0 { 1.0 } else { 0.1 * from.abs() };
        Self { from: from - margin, to: from + margin, is_log: false }
    }

    /// Creates a logarithmic axis between two positive values.
    pub fn log(from: f64, to: f64) -> Self {
        let to = if to > from { to } else { 10.0 * from };
        Self { from, to, is_log: true }
    }

    /// Returns the position of a value on the axis: 0 at the start, 1 at the end.
    pub fn share(&self, value: f64) -> f64 {
        if self.is_log {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }

    /// Returns the value at a position on the axis.
    pub fn value(&self, share: f64) -> f64 {
        if self.is_log {
            self.from * (self.to / self.from).powf(share)
        } else {
            self.from + share * (self.to - self.from)
        }
    }

    /// Returns true for a value between the ends.
    pub fn holds(&self, value: f64) -> bool {
        (0.0..=1.0).contains(&self.share(value))
    }

    /// Returns round values with their labels, as many as fit without overlap on an axis of `length` pixels. Labels
    /// that do not fit are empty. `across` is true if labels are side by side, false if they are above one another.
    pub fn ticks(&self, length: f64, across: bool) -> Vec<(f64, String)> {
        if self.is_log {
            return self.decades();
        }
        let needed = |label: &str| if across { width_of(label, TICK_SIZE) + LABEL_GAP } else { TICK_SIZE + LABEL_GAP };
        let apart = |a: f64, b: f64| (self.share(b) - self.share(a)).abs() * length;
        let fits = |ticks: &[(f64, String)]| {
            let widest = ticks.iter().map(|(_, label)| needed(label)).fold(0.0, f64::max);
            ticks.len() > 1 && ticks.windows(2).all(|pair| apart(pair[0].0, pair[1].0) >= widest)
        };
        if let Some(ticks) = (2..=8).rev().map(|most| self.multiples(most)).find(|ticks| fits(ticks)) {
            return ticks;
        }
        // A short axis keeps some ticks, with only those labels that fit.
        let mut ticks = self.multiples(4);
        let mut last: Option<(f64, f64)> = None;
        for (value, label) in &mut ticks {
            match last {
                Some((before, taken)) if apart(before, *value) < (taken + needed(label)) / 2.0 => label.clear(),
                _ => last = Some((*value, needed(label))),
            }
        }
        ticks
    }

    /// Returns the ticks of [`Self::ticks`] without the labels that extend more than `beyond` pixels past an end of the
    /// axis. If no label would remain, all are kept.
    pub fn ticks_within(&self, length: f64, across: bool, beyond: f64) -> Vec<(f64, String)> {
        let ticks = self.ticks(length, across);
        let is_within = |(value, label): &(f64, String)| {
            let half = if across { width_of(label, TICK_SIZE) } else { TICK_SIZE } / 2.0;
            let position = self.share(*value) * length;
            position - half >= -beyond && position + half <= length + beyond
        };
        if !ticks.iter().any(|tick| !tick.1.is_empty() && is_within(tick)) {
            return ticks;
        }
        let kept = |tick: (f64, String)| if is_within(&tick) { tick } else { (tick.0, String::new()) };
        ticks.into_iter().map(kept).collect()
    }

    fn multiples(&self, most: usize) -> Vec<(f64, String)> {
        let (low, high) = (self.from.min(self.to), self.from.max(self.to));
        let rough = (high - low) / most as f64;
        let decade = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|step| step * decade).into_iter().find(|step| *step >= rough * 0.999);
        let step = step.unwrap_or(10.0 * decade);
        let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
        let values: Vec<f64> =
            (0..=(last - first).clamp(-1.0, 20.0) as i64).map(|n| (first + n as f64) * step).collect();
        let text = labels(&values, step);
        values.into_iter().zip(text).collect()
    }

    fn decades(&self) -> Vec<(f64, String)> {
        let (first, last) = (self.from.log10().floor() as i32, self.to.log10().ceil() as i32);
        let values = (first..=last).map(|power| 10_f64.powi(power)).filter(|value| self.holds(*value));
        values.map(|value| (value, value.to_string())).collect()
    }
}

impl Frame {
    /// Returns the position of a pair of values in the picture, clamped to the border of the box.
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let [left, top, right, bottom] = self.sides;
        let (across, up) = (self.x.share(x).clamp(0.0, 1.0), self.y.share(y).clamp(0.0, 1.0));
        (left + across * (right - left), bottom - up * (bottom - top))
    }

    /// Returns true for a pair of values inside the box.
    pub fn holds(&self, x: f64, y: f64) -> bool {
        self.x.holds(x) && self.y.holds(y)
    }

    pub fn width(&self) -> f64 {
        self.sides[2] - self.sides[0]
    }

    pub fn height(&self) -> f64 {
        self.sides[3] - self.sides[1]
    }

    /// Draws the border and the ticks; if requested, with labels below the box and to its left.
    pub fn draw(&self, picture: &mut Picture, labels: [bool; 2]) {
        self.draw_within(picture, labels, f64::INFINITY);
    }

    /// Draws the same as [`Self::draw`] for a box next to others: no label extends more than `beyond` pixels past the
    /// border.
    pub fn draw_within(&self, picture: &mut Picture, [has_x_labels, has_y_labels]: [bool; 2], beyond: f64) {
        let [left, top, _, bottom] = self.sides;
        for (value, label) in self.y.ticks_within(bottom - top, false, beyond) {
            let (_, y) = self.at(self.x.from, value);
            picture.line(&[(left, y), (left + 5.0, y)], INK.to_rgba(), 1.2);
            if has_y_labels && !label.is_empty() {
                picture.text(&label, (left - 8.0, y), TICK_SIZE, HPos::Right);
            }
        }
        self.draw_without_y(picture, has_x_labels, beyond);
    }

    /// Draws the border, and the ticks of the left side with labels, for a box with another x axis.
    pub fn draw_y(&self, picture: &mut Picture) {
        let [left, top, _, bottom] = self.sides;
        for (value, label) in self.y.ticks(bottom - top, false) {
            let (_, y) = self.at(self.x.from, value);
            picture.line(&[(left, y), (left + 5.0, y)], INK.to_rgba(), 1.2);
            if !label.is_empty() {
                picture.text(&label, (left - 8.0, y), TICK_SIZE, HPos::Right);
            }
        }
        picture.border(self.sides, 1.4);
    }

    /// Draws the same as [`Self::draw_within`], without ticks and labels at the left.
    pub fn draw_without_y(&self, picture: &mut Picture, has_x_labels: bool, beyond: f64) {
        let [left, _, right, bottom] = self.sides;
        for (value, label) in self.x.ticks_within(right - left, true, beyond) {
            let (x, _) = self.at(value, self.y.from);
            picture.line(&[(x, bottom), (x, bottom - 5.0)], INK.to_rgba(), 1.2);
            if has_x_labels && !label.is_empty() {
                picture.text(&label, (x, bottom + 16.0), TICK_SIZE, HPos::Center);
            }
        }
        picture.border(self.sides, 1.4);
    }

    /// Returns the width of the labels to the left of the box, pixels.
    pub fn y_label_width(&self) -> f64 {
        self.y.ticks(self.height(), false).iter().map(|(_, label)| width_of(label, TICK_SIZE)).fold(0.0, f64::max)
    }

    /// Draws the name of the x axis.
    pub fn name_x(&self, picture: &mut Picture, name: &str) {
        let [left, _, right, bottom] = self.sides;
        picture.text(name, ((left + right) / 2.0, bottom + 42.0), NAME_SIZE, HPos::Center);
    }

    /// Draws the name of the y axis, `away` pixels to the left of the axis.
    pub fn name_y(&self, picture: &mut Picture, name: &str, away: f64) {
        let [left, top, _, bottom] = self.sides;
        picture.upright(name, (left - away, (top + bottom) / 2.0), NAME_SIZE);
    }
}

/// Number of colour steps per pixel.
const STEPS_PER_PIXEL: f64 = 2.0;
const BAR_TEXT_SIZE: f64 = 19.0;
/// Height of the triangle at an end beyond which values lie, pixels.
const TIP: f64 = 15.0;

/// Draws a colour bar with the given left, top, right and bottom, with ticks at its right side and a label above. A
/// triangle marks an end beyond which values lie.
pub(super) fn colour_bar(picture: &mut Picture, scale: &ColourScale, sides: [f64; 4], text: &str) {
    let [left, top, right, bottom] = sides;
    let steps = ((bottom - top) * STEPS_PER_PIXEL).max(1.0) as usize;
    let colour = |step: usize| Some(scale.colour_at(1.0 - (step as f64 + 0.5) / steps as f64));
    let each = (right - left, (bottom - top) / steps as f64);
    let colours = (0..steps).map(colour).collect();
    picture.paint(Pixels { corner: (left, top), each, columns: 1, colours, within: None });
    picture.border(sides, 1.4);
    let is_beyond = |share: f64| match share == scale.share(scale.greatest) {
        true => scale.has_higher,
        false => scale.has_lower,
    };
    for (share, base, tip) in [(1.0, top, top - TIP), (0.0, bottom, bottom + TIP)] {
        if is_beyond(share) {
            let [red, green, blue] = scale.colour_at(share);
            let corners = vec![(left, base), ((left + right) / 2.0, tip), (right, base)];
            picture.patch(corners.clone(), RGBColor(red, green, blue).to_rgba());
            picture.line(&[corners[0], corners[1], corners[2], corners[0]], INK.to_rgba(), 1.4);
        }
    }
    for (value, label) in scale.ticks() {
        let y = bottom - (bottom - top) * scale.share(value);
        picture.line(&[(right, y), (right + 6.0, y)], INK.to_rgba(), 1.4);
        picture.text(&label, (right + 11.0, y), BAR_TEXT_SIZE, HPos::Left);
    }
    let above = if is_beyond(1.0) { top - TIP } else { top };
    // A label that is too long for the rest of the picture has several lines.
    let lines = lines_of(text, picture.size().0 as f64 - left - 4.0, BAR_TEXT_SIZE);
    for (line, text) in lines.iter().rev().enumerate() {
        picture.text(text, (left, above - 20.0 - 1.2 * BAR_TEXT_SIZE * line as f64), BAR_TEXT_SIZE, HPos::Left);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_ticks_are_round_and_do_not_overlap() {
        for (from, to) in [(0.0, 1.0), (-3.3, 12.9), (0.012_31, 0.012_39), (5e6, 5.1e6), (9.0, 4.0), (-1e-8, 3e-8)] {
            for length in [90.0, 150.0, 600.0] {
                let axis = Axis::linear(from, to);
                let ticks = axis.ticks(length, true);
                assert!(
                    !ticks.is_empty()
                        && ticks.iter().all(|(value, _)| axis.share(*value) > -1e-6 && axis.share(*value) < 1.0 + 1e-6)
                );
                let labels: Vec<_> = ticks.iter().filter(|tick| !tick.1.is_empty()).collect();
                assert!(!labels.is_empty() && ticks.len() > 1, "{ticks:?}");
                for pair in labels.windows(2) {
                    let apart = (axis.share(pair[1].0) - axis.share(pair[0].0)).abs() * length;
                    let widths = (width_of(&pair[0].1, TICK_SIZE) + width_of(&pair[1].1, TICK_SIZE)) / 2.0;
                    assert!(pair[0].1 != pair[1].1 && apart > widths, "{ticks:?} on {length}");
                }
            }
        }
        let text: Vec<String> = Axis::linear(0.0, 1.0).ticks(600.0, true).into_iter().map(|tick| tick.1).collect();
        assert_eq!(text, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        let text: Vec<String> = Axis::log(1.0, 3000.0).ticks(600.0, true).into_iter().map(|tick| tick.1).collect();
        assert_eq!(text, ["1", "10", "100", "1000"]);
    }

    #[test]
    fn verif_labels_of_neighbours_do_not_overlap() {
        for (from, to) in [(0.0, 1.0), (0.0213, 0.0287), (-1.3, 1.0), (5e-7, 9e-7), (100.0, 1000.0)] {
            for (length, beyond) in [(60.0, 4.0), (150.0, 4.0), (230.0, 4.0)] {
                let axis = Axis::linear(from, to);
                let ticks = axis.ticks_within(length, true, beyond);
                assert_eq!(ticks.len(), axis.ticks(length, true).len());
                let labels: Vec<_> = ticks.iter().filter(|tick| !tick.1.is_empty()).collect();
                assert!(!labels.is_empty(), "{ticks:?}");
                for (value, label) in labels {
                    let (position, half) = (axis.share(*value) * length, width_of(label, TICK_SIZE) / 2.0);
                    assert!(
                        length < 100.0 || (position - half >= -beyond && position + half <= length + beyond),
                        "{label} on {length}"
                    );
                }
            }
        }
        let all: Vec<String> = Axis::linear(0.0, 1.0).ticks(150.0, true).into_iter().map(|tick| tick.1).collect();
        let kept = Axis::linear(0.0, 1.0).ticks_within(150.0, true, 4.0);
        assert!(all.iter().all(|label| !label.is_empty()) && kept[0].1.is_empty() && !kept[1].1.is_empty(), "{kept:?}");
    }

    #[test]
    fn verif_values_and_shares_are_inverse() {
        let frame = Frame { sides: [100.0, 50.0, 300.0, 150.0], x: Axis::log(1.0, 100.0), y: Axis::linear(9.0, 4.0) };
        let (x, y) = frame.at(10.0, 4.0);
        assert!((x - 200.0).abs() < 1e-9 && (y - 50.0).abs() < 1e-9);
        assert!((frame.x.value(0.5) - 10.0).abs() < 1e-9 && !frame.holds(10.0, 3.0));
        assert_eq!(frame.at(1e9, 0.0), (300.0, 50.0));
        assert!(Axis::linear(3.0, 3.0).holds(3.0) && Axis::linear(0.0, 0.0).to > 0.0);
    }
}
