//! Drawing of a path with a point spread function from a file.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::Range;

use super::path::StreakPath;
use crate::error::Error;
use crate::images::{Patch, PatchRows, PixelPosition, PsfGrid};
use crate::watch::Watch;

/// Number of positions of a star within a pixel, along each axis, for which its light in pixels is computed. Points of
/// the path are divided among the nearest four of them, which adds 0.03 pixels in quadrature to the width.
const PHASES: i64 = 16;
/// Largest distance of the points that form the path, pixels.
const STEP_PIX: f64 = 0.05;
/// Side of the squares in which a variable point spread function is that of their middle, pixels.
const BLOCK_PIX: f64 = 64.0;

/// Square of the frame, position within a pixel in units of 1/16, and pixel. In this order, the light of a star is
/// computed once for each square and position within a pixel, and is not kept.
type Place = ([i64; 2], [i64; 2], [i64; 2]);

/// Draws a path in a frame of `rows` by `columns` pixels. The light of each point is conserved: the pixels of a star
/// have the sum of its light at each position within a pixel.
///
/// # Errors
/// The sum of a variable point spread function is not positive somewhere on the path, or the computation is stopped.
pub fn draw_image(
    path: &StreakPath,
    psf: &PsfGrid,
    rows: usize,
    columns: usize,
    watch: &Watch,
) -> Result<Patch, Error> {
    let mut lights: BTreeMap<Place, f64> = BTreeMap::new();
    let reach = psf.reach_pix() + 1.0;
    let is_near = |at: PixelPosition| {
        let within = |at: f64, count: usize| at > -reach && at < count as f64 - 1.0 + reach;
        within(at.x, columns) && within(at.y, rows)
    };
    for piece in path.pieces() {
        let [x, y] = [&piece.x, &piece.y].map(|cubic| cubic.control_points(0.0, piece.duration_s));
        // The speed along a cubic is at most three times the longest side of its Bézier control polygon.
        let longest = (1..4).map(|i| (x[i] - x[i - 1]).hypot(y[i] - y[i - 1])).fold(0.0, f64::max);
        let count = (3.0 * longest / STEP_PIX).ceil().clamp(1.0, 1e8);
        let step_s = piece.duration_s / count;
        for number in 0..count as usize {
            let since_s = number as f64 * step_s;
            let middle_s = since_s + 0.5 * step_s;
            let at = PixelPosition { x: piece.x.at(middle_s), y: piece.y.at(middle_s) };
            if !is_near(at) {
                continue;
            }
            let light = piece.rate.integral(since_s + step_s) - piece.rate.integral(since_s);
            let block = if psf.is_variable() { [at.x, at.y].map(|at| (at / BLOCK_PIX).floor() as i64) } else { [0, 0] };
            add(&mut lights, block, at, light);
        }
    }
    let frame = StampFrame::new(psf);
    let mut extents = PatchRows::new(rows, columns);
    for (_, _, pixel) in lights.keys() {
        for (row, range, _) in frame.rows(*pixel, rows, columns) {
            extents.add(row, range);
        }
    }
    let mut patch = extents.into_patch();
    let mut samples: Option<([i64; 2], Vec<f64>)> = None;
    let mut stamp: Option<([[i64; 2]; 2], Vec<f64>)> = None;
    for ((block, phase, pixel), light) in &lights {
        if stamp.as_ref().is_none_or(|(of, _)| *of != [*block, *phase]) {
            watch.check()?;
            if samples.as_ref().is_none_or(|(of, _)| of != block) {
                samples = Some((*block, samples_at(psf, *block, rows, columns)?));
            }
            stamp = samples.as_ref().map(|(_, samples)| ([*block, *phase], frame.values(psf, samples, *phase)));
        }
        let Some((_, values)) = &stamp else { continue };
        for (row, range, from) in frame.rows(*pixel, rows, columns) {
            let values = &values[from..from + range.len()];
            let pixels = patch.span_mut(row, range);
            pixels.iter_mut().zip(values).for_each(|(pixel, value)| *pixel += (light * value) as f32);
        }
    }
    Ok(patch)
}

/// Returns the samples of the point spread function in the middle of a square. A square outside of the frame has those
/// of the nearest place in the frame, because a polynomial has no meaning elsewhere.
fn samples_at(psf: &PsfGrid, block: [i64; 2], rows: usize, columns: usize) -> Result<Vec<f64>, Error> {
    let middle = |axis: usize, count: usize| ((block[axis] as f64 + 0.5) * BLOCK_PIX).clamp(0.0, count as f64);
    let middle = PixelPosition { x: middle(0, columns), y: middle(1, rows) };
    psf.at(middle).ok_or_else(|| {
        let [x, y] = middle.fits();
        Error::invalid(format!("sum of the point spread function at ({x:.0}, {y:.0})"), "0 or less", "above 0")
    })
}

/// Divides the light of a point among the nearest four positions.
fn add(lights: &mut BTreeMap<Place, f64>, block: [i64; 2], at: PixelPosition, light: f64) {
    let fine = [at.x, at.y].map(|at| at * PHASES as f64);
    let first = fine.map(|at| at.floor() as i64);
    let share = [0, 1].map(|axis| fine[axis] - first[axis] as f64);
    for (dx, wx) in [(0, 1.0 - share[0]), (1, share[0])] {
        for (dy, wy) in [(0, 1.0 - share[1]), (1, share[1])] {
            if wx * wy > 0.0 {
                let cell = [first[0] + dx, first[1] + dy];
                let place = (block, cell.map(|at| at.rem_euclid(PHASES)), cell.map(|at| at.div_euclid(PHASES)));
                *lights.entry(place).or_default() += light * wx * wy;
            }
        }
    }
}

/// The pixels around a star that have its light.
struct StampFrame {
    /// Number of pixels to the left of and below the pixel of the star.
    before: [i64; 2],
    /// Columns and rows.
    size: [usize; 2],
}

impl StampFrame {
    fn new(psf: &PsfGrid) -> Self {
        let [rows, columns] = psf.reach();
        let before = [columns, rows].map(|reach| ((reach + 1.0) * psf.step_pix).ceil() as i64);
        Self { before, size: before.map(|half| 2 * half as usize + 2) }
    }

    /// Returns the light of a star of unit light in these pixels, for a position within its pixel.
    fn values(&self, psf: &PsfGrid, samples: &[f64], phase: [i64; 2]) -> Vec<f64> {
        let [rows, columns] = psf.size;
        let axis = |axis: usize, count: usize| -> Vec<Vec<(usize, f64)>> {
            let (middle, half) = (psf.star[1 - axis], self.before[axis]);
            let star = phase[axis] as f64 / PHASES as f64;
            (-half..=half + 1).map(|pixel| weights(count, (pixel as f64 - star) / psf.step_pix + middle)).collect()
        };
        let (across, up) = (axis(0, columns), axis(1, rows));
        let mut values = Vec::with_capacity(across.len() * up.len());
        let mut line = vec![0.0; columns];
        for of_row in &up {
            line.fill(0.0);
            for (row, weight) in of_row {
                let samples = &samples[row * columns..(row + 1) * columns];
                line.iter_mut().zip(samples).for_each(|(sum, sample)| *sum += weight * sample);
            }
            values.extend(
                across.iter().map(|of_pixel| of_pixel.iter().map(|(at, weight)| weight * line[*at]).sum::<f64>()),
            );
        }
        let sum: f64 = values.iter().sum();
        if sum > 0.0 {
            values.iter_mut().for_each(|value| *value /= sum);
        }
        values
    }

    /// Returns the rows of the frame that the light of a star in a pixel reaches: columns, and the index of their first
    /// value.
    fn rows(
        &self,
        pixel: [i64; 2],
        rows: usize,
        columns: usize,
    ) -> impl Iterator<Item = (usize, Range<usize>, usize)> + use<> {
        let [left, bottom] = [0, 1].map(|axis| pixel[axis] - self.before[axis]);
        let [width, height] = self.size;
        let first = left.clamp(0, columns as i64);
        let end = (left + width as i64).clamp(first, columns as i64);
        let range = first as usize..end as usize;
        (0..height as i64).filter_map(move |row| {
            let in_frame = usize::try_from(bottom + row).ok().filter(|row| *row < rows && !range.is_empty())?;
            let from = row as usize * width + (first - left) as usize;
            Some((in_frame, range.clone(), from))
        })
    }
}

/// Half of the number of samples that determine a value between samples.
const TAPS: i64 = 6;
/// Shape of the window: a larger number is more accurate for well sampled images, and less for coarse ones. With 8, the
/// largest error in units of the peak is 0.9, 0.4, 0.2, 0.05 and 0.007 % for a Gaussian in pixels with a FWHM of 1.5,
/// 2, 2.5, 3 and 4 samples (5.2, 3.9, 2.1, 1.3 and 0.6 % for a cubic through four samples).
const WINDOW: f64 = 8.0;

/// Returns the weights of the samples nearest to a position, by the sine cardinal in a Kaiser window over twelve of
/// them (Harris 1978, Proc. IEEE 66, 51); they add up to 1. Samples beyond the ends are 0.
fn weights(count: usize, at: f64) -> Vec<(usize, f64)> {
    let first = at.floor();
    // sinc x · I₀(β √(1 - x²/a²)) / I₀(β); the constant factor cancels.
    let weight = |x: f64| {
        let sinc = if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
        sinc * bessel_i0(WINDOW * (1.0 - (x / TAPS as f64).powi(2)).max(0.0).sqrt())
    };
    let taps: Vec<(i64, f64)> =
        (1 - TAPS..=TAPS).map(|step| (first as i64 + step, weight(at - first - step as f64))).collect();
    let sum: f64 = taps.iter().map(|(_, weight)| weight).sum();
    let inside = |(sample, weight): (i64, f64)| {
        let sample = usize::try_from(sample).ok().filter(|sample| *sample < count && weight != 0.0)?;
        Some((sample, weight / sum))
    };
    taps.into_iter().filter_map(inside).collect()
}

/// Modified Bessel function of the first kind and order 0, by its power series.
fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    // (x/2)^2k / k!²; the terms fall below the rounding of the sum before k = 3 x + 10.
    for k in 1..(3.0 * x) as u32 + 10 {
        term *= (0.5 * x / f64::from(k)).powi(2);
        sum += term;
    }
    sum
}

/// Returns the full width at half maximum of a line of light at an angle from the rows, measured across the line,
/// pixels.
pub fn image_width_pix(psf: &PsfGrid, at: PixelPosition, angle_rad: f64) -> Option<f64> {
    let samples = psf.at(at)?;
    let [rows, columns] = psf.size;
    let (sin, cos) = angle_rad.sin_cos();
    let [up, right] = psf.reach();
    let half = up.hypot(right).ceil();
    // Light in strips along the line that are as wide as the distance of the samples.
    let mut strips = vec![0.0; 2 * half as usize + 2];
    for row in 0..rows {
        for column in 0..columns {
            let (dx, dy) = (column as f64 - psf.star[1], row as f64 - psf.star[0]);
            let across = dy * cos - dx * sin + half;
            let (first, share) = (across.floor(), across.fract());
            let value = samples[row * columns + column];
            strips[first as usize] += (1.0 - share) * value;
            strips[first as usize + 1] += share * value;
        }
    }
    let peak = (0..strips.len()).max_by(|a, b| strips[*a].total_cmp(&strips[*b]))?;
    let level = 0.5 * strips[peak];
    // Distance from the peak at which the light falls to half, towards either side.
    let falls = |side: isize| {
        let mut last = peak as isize;
        while let Some(value) = usize::try_from(last + side).ok().and_then(|next| strips.get(next)) {
            if *value < level {
                let before = strips[last as usize];
                return (last - peak as isize).unsigned_abs() as f64 + (before - level) / (before - value);
            }
            last += side;
        }
        (last - peak as isize).unsigned_abs() as f64
    };
    Some((falls(-1) + falls(1)) * psf.step_pix)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light of a Gaussian with a FWHM in a pixel at a distance, in pixels.
    fn in_pixel(distance: f64, fwhm: f64) -> f64 {
        let sigma = fwhm / (8.0 * 2.0_f64.ln()).sqrt();
        let edge = |at: f64| libm::erf(at / (sigma * std::f64::consts::SQRT_2));
        0.5 * (edge(distance + 0.5) - edge(distance - 0.5))
    }

    /// The errors that the comment of `WINDOW` states, with all positions of a star within a pixel.
    #[test]
    fn verif_samples_are_interpolated_to_the_stated_errors() {
        for (fwhm, most) in [(1.5, 0.0093), (2.0, 0.004), (2.5, 0.002), (3.0, 0.0006), (4.0, 1e-4), (8.0, 1e-4)] {
            let samples: Vec<f64> = (0..61).map(|sample| in_pixel(f64::from(sample) - 30.0, fwhm)).collect();
            let mut largest = 0.0_f64;
            for step in 0..40 * 16 {
                let at = 10.0 + f64::from(step) / 16.0;
                let weights = weights(samples.len(), at);
                assert!((weights.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
                let found: f64 = weights.iter().map(|(sample, weight)| weight * samples[*sample]).sum();
                largest = largest.max((found - in_pixel(at - 30.0, fwhm)).abs() / in_pixel(0.0, fwhm));
            }
            assert!(largest < most && largest > 0.3 * most, "FWHM {fwhm}: {largest}");
        }
    }
}
