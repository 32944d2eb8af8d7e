//! Points by the hundred thousand: each a small disc of thin paint, so that the dense is darker.

use plotters::prelude::RGBColor;

use super::axes::Frame;
use super::picture::{PAPER, Pixels};

/// Cells of paint a pixel, along each side.
const FINE: usize = 2;

/// Radius of a dot, pixels.
const RADIUS: f64 = 1.7;

/// Points inside a frame, painted; those outside are left out.
pub(super) fn dots(frame: &Frame, x: &[f64], y: &[f64], colour: RGBColor) -> Pixels {
    let columns = (frame.width() * FINE as f64) as usize;
    let rows = (frame.height() * FINE as f64) as usize;
    let mut layers = vec![0_u32; columns * rows];
    let reach = (RADIUS * FINE as f64).ceil() as isize;
    let is_in = |right: isize, down: isize| (right as f64).hypot(down as f64) <= RADIUS * FINE as f64;
    let [left, top, ..] = frame.sides;
    for (&x, &y) in x.iter().zip(y).filter(|(x, y)| frame.holds(**x, **y)) {
        let (across, down) = frame.at(x, y);
        let (column, row) = (((across - left) * FINE as f64) as isize, ((down - top) * FINE as f64) as isize);
        for (r, d) in
            (-reach..=reach).flat_map(|r| (-reach..=reach).map(move |d| (r, d))).filter(|(r, d)| is_in(*r, *d))
        {
            if (0..columns as isize).contains(&(column + r)) && (0..rows as isize).contains(&(row + d)) {
                layers[(row + d) as usize * columns + (column + r) as usize] += 1;
            }
        }
    }
    // Thinner paint where points are many: 60 % for a few, a tenth where a cell in the dense parts has dozens.
    let painted: Vec<u32> = layers.iter().copied().filter(|count| *count > 0).collect();
    let mean = painted.iter().sum::<u32>() as f64 / painted.len().max(1) as f64;
    let thin = 1.0 - (0.6 / mean.max(1.0).sqrt()).max(0.06);
    let mixed = |count: &u32| {
        let paper = thin.powi((*count).min(200) as i32);
        let ink = [colour.0, colour.1, colour.2];
        let channel = |k: usize| (paper * f64::from(PAPER[k]) + (1.0 - paper) * f64::from(ink[k])).round() as u8;
        (*count > 0).then(|| [channel(0), channel(1), channel(2)])
    };
    let each = (1.0 / FINE as f64, 1.0 / FINE as f64);
    Pixels {
        corner: (left, top),
        each,
        columns: columns.max(1),
        colours: layers.iter().map(mixed).collect(),
        within: None,
    }
}
