//! The loop for long and straight chords: light is read from a lattice.

use std::ops::Range;

use crate::images::Patch;
use crate::streaks::Lattice;

use super::chords::Chord;
use super::runs::Run;

/// Stretches of rows that are made ready at a time.
const BATCH: usize = 8;

/// Greatest number of columns in a stretch.
const LONGEST: usize = 256;

/// Numbers of its columns.
const COLUMNS: [f32; LONGEST] = {
    let mut columns = [0.0; LONGEST];
    let mut number = 0;
    while number < LONGEST {
        columns[number] = number as f32;
        number += 1;
    }
    columns
};

/// Light of a chord in pixels that have their feet on it, where it is so straight that the second order in g (see the loop for all others) is not felt.
///
/// Over a stretch of columns the distance from the path is a square, and brightness as good as a cubic.
#[inline(always)]
pub(super) fn straight(chord: &Chord, lattice: &Lattice, runs: &[Run], patch: &mut Patch) {
    let longest = longest(chord, lattice);
    let mut stretches = Vec::with_capacity(2 * runs.len());
    for run in runs {
        let dy = run.row as f64 - chord.middle[1];
        let mut dx = run.columns.start as f64 - chord.middle[0];
        let mut from = run.columns.start;
        while from < run.columns.end {
            let to = run.columns.end.min(from + longest);
            stretches.push(Stretch { row: run.row, columns: from..to, from: [dx, dy] });
            from = to;
            dx += longest as f64;
        }
    }
    for some in stretches.chunks(BATCH) {
        let mut from = [[0.0; BATCH]; 2];
        for (number, stretch) in some.iter().enumerate() {
            [from[0][number], from[1][number]] = stretch.from;
        }
        let ready = Ready::of(chord, lattice, longest, &from);
        for (number, stretch) in some.iter().enumerate() {
            ready.add_to(number, lattice, patch.stretch_mut(stretch.row, stretch.columns.clone()));
        }
    }
}

/// How many columns may be read at a time: over them distances from the chord may grow by about half a phase more or less than the lattice's.
fn longest(chord: &Chord, lattice: &Lattice) -> usize {
    let [ux, uy] = chord.along;
    let a_column = (uy.abs() - f64::from(lattice.step_pix())).abs() + chord.half_turn_rad() * ux.abs();
    let phase_pix = 1.0 / f64::from(lattice.phases_per_pix());
    ((0.5 * phase_pix / a_column) as usize).clamp(Lattice::COLUMNS, LONGEST)
}

/// Neighbouring pixels of a row, at most as many as are drawn from one place of a lattice.
struct Stretch {
    row: usize,
    columns: Range<usize>,
    /// Columns and rows of the first from the chord's middle.
    from: [f64; 2],
}

/// What stretches need, number by number of all of them.
struct Ready {
    /// Where the lattice has the light of the first column.
    places: [[i32; 2]; BATCH],
    /// By the column: how far each pixel is from the phase, in phases; a square.
    way: [[f32; BATCH]; 3],
    /// And λ(a₀) (1 + κv/2); a cubic.
    brightness: [[f32; BATCH]; 4],
}

impl Ready {
    #[inline(always)]
    fn of(chord: &Chord, lattice: &Lattice, longest: usize, [dx, dy]: &[[f64; BATCH]; 2]) -> Self {
        let [ux, uy] = chord.along;
        // A line is the same from both sides: v is to grow with the columns.
        let sign = if uy > 0.0 { -1.0 } else { 1.0 };
        let (step_a, step_b) = (ux as f32, (-sign * uy) as f32);
        let (bow, half2) = ((sign * chord.bow) as f32, (chord.half_pix * chord.half_pix) as f32);
        let [l0, l1, l2, l3] = chord.light.map(|power| power as f32);
        let (step_pix, per_phase) = (lattice.step_pix(), lattice.phases_per_pix());
        let (mut a, mut across) = ([0.0_f32; BATCH], [0.0_f32; BATCH]);
        for number in 0..BATCH {
            a[number] = (dx[number] * ux + dy[number] * uy) as f32;
            across[number] = (sign * (dy[number] * ux - dx[number] * uy)) as f32;
        }
        for number in 0..BATCH {
            across[number] -= bow * (a[number] * a[number] - half2);
        }
        let (places, known_pix) = lattice.places(&across);
        let mut way = [[0.0; BATCH]; 3];
        for number in 0..BATCH {
            way[0][number] = (across[number] - known_pix[number]) * per_phase;
            way[1][number] = (step_b - step_pix - 2.0 * bow * a[number] * step_a) * per_phase;
            way[2][number] = -bow * step_a * step_a * per_phase;
        }
        // From one to the next of four evenly spaced columns, the first and the last among them.
        let third = (longest - 1) as f32 / 3.0;
        let mut values = [[0.0; BATCH]; 4];
        for (node, values) in values.iter_mut().enumerate() {
            let column = node as f32 * third;
            for number in 0..BATCH {
                let a = a[number] + column * step_a;
                // κv, and the twist from a to the foot.
                let turn = 2.0 * bow * (known_pix[number] + column * step_pix);
                let foot = a + a * turn;
                values[number] = (l0 + foot * (l1 + foot * (l2 + foot * l3))) * (1.0 + 0.5 * turn);
            }
        }
        let mut brightness = [[0.0; BATCH]; 4];
        for number in 0..BATCH {
            let [f0, f1, f2, f3] = &values;
            let powers = cubic([f0[number], f1[number], f2[number], f3[number]], 1.0 / third);
            for (brightness, power) in brightness.iter_mut().zip(powers) {
                brightness[number] = power;
            }
        }
        Self { places, way, brightness }
    }

    /// Adds the light to the pixels of a stretch.
    #[inline(always)]
    fn add_to(&self, number: usize, lattice: &Lattice, pixels: &mut [f32]) {
        let Some([light, slope, bend]) = lattice.light(self.places[number], pixels.len()) else { return };
        let ([p0, p1, p2], [b0, b1, b2, b3]) = (&self.way, &self.brightness);
        let (p0, p1, p2) = (p0[number], p1[number], p2[number]);
        let (b0, b1, b2, b3) = (b0[number], b1[number], b2[number], b3[number]);
        let powers = light.iter().zip(slope).zip(bend);
        for ((pixel, ((light, slope), bend)), column) in pixels.iter_mut().zip(powers).zip(&COLUMNS) {
            let way = p0 + column * (p1 + column * p2);
            let brightness = b0 + column * (b1 + column * (b2 + column * b3));
            *pixel += brightness * (light + way * (slope + way * bend));
        }
    }
}

/// Powers of the cubic through values at four columns, `per_column` steps between these in a column.
#[inline(always)]
fn cubic([f0, f1, f2, f3]: [f32; 4], per_column: f32) -> [f32; 4] {
    // f₀ + t Δ + t (t - 1)/2 Δ² + t (t - 1) (t - 2)/6 Δ³
    let (d1, d2, d3) = (f1 - f0, f2 - 2.0 * f1 + f0, f3 - 3.0 * (f2 - f1) - f0);
    let [first, second, third] = [d1 - 0.5 * d2 + d3 * (1.0 / 3.0), 0.5 * (d2 - d3), d3 * (1.0 / 6.0)];
    let per2 = per_column * per_column;
    [f0, first * per_column, second * per2, third * (per2 * per_column)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_goes_through_its_four_columns() {
        let value = |x: f32| 1.0 + x * (0.0125 + x * (-1.25e-4 + x * 3e-7));
        let powers = cubic([0.0, 85.0, 170.0, 255.0].map(value), 1.0 / 85.0);
        for x in &COLUMNS {
            let found = powers.iter().rev().fold(0.0, |sum, power| sum * x + power);
            assert!((found - value(*x)).abs() < 1e-5, "{x}: {found} {}", value(*x));
        }
    }
}
