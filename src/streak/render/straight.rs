//! The loop for long and straight chords: light is read from a lattice.

use crate::camera::Lattice;

use super::chords::Chord;

/// Stretches of [`Lattice::COLUMNS`] that are made ready at a time where rows are long enough.
const STRETCHES: usize = 4;

/// Columns of a stretch.
const COLUMNS: [f32; Lattice::COLUMNS] = {
    let mut columns = [0.0; Lattice::COLUMNS];
    let mut number = 0;
    while number < Lattice::COLUMNS {
        columns[number] = number as f32;
        number += 1;
    }
    columns
};

/// Columns through which brightness is a cubic.
const NODES: [f32; 4] = [0.0, THIRD, 2.0 * THIRD, 3.0 * THIRD];
const THIRD: f32 = (Lattice::COLUMNS - 1) as f32 / 3.0;

/// Light of a chord in pixels of a row that have their feet on it, where it is so straight that the second order in g (see the loop for all others) is not felt.
///
/// Over a stretch of columns the distance from the path is a square, and brightness as good as a cubic.
#[inline(always)]
pub(super) fn straight(chord: &Chord, lattice: &Lattice, row: usize, first_column: usize, pixels: &mut [f32]) {
    let dy = row as f64 - chord.middle[1];
    let all = STRETCHES * Lattice::COLUMNS;
    for (number, out) in pixels.chunks_mut(all).enumerate() {
        let from = [(first_column + number * all) as f64 - chord.middle[0], dy];
        if out.len() > Lattice::COLUMNS {
            Ready::<STRETCHES>::of(chord, lattice, from).add_to(lattice, out);
        } else {
            Ready::<1>::of(chord, lattice, from).add_to(lattice, out);
        }
    }
}

/// What neighbouring stretches of a row need.
struct Ready<const N: usize> {
    /// Where the lattice has the light of the first column.
    place: [[i32; 2]; N],
    /// By the column: how far each pixel is from one phase towards the next; a square.
    part: [[f32; 3]; N],
    /// And λ(a₀) (1 + κv/2); a cubic.
    brightness: [[f32; 4]; N],
}

impl<const N: usize> Ready<N> {
    /// Of stretches of which the first begins at a place from the chord's middle.
    #[inline(always)]
    fn of(chord: &Chord, lattice: &Lattice, [dx, dy]: [f64; 2]) -> Self {
        let [ux, uy] = chord.along;
        // A line is the same from both sides: v is to grow with the columns.
        let sign = if uy > 0.0 { -1.0 } else { 1.0 };
        let (step_a, step_b) = (ux as f32, (-sign * uy) as f32);
        let (bow, half2) = ((sign * chord.bow) as f32, (chord.half_pix * chord.half_pix) as f32);
        let [l0, l1, l2, l3] = chord.light.map(|power| power as f32);
        let (step_pix, per_phase) = (lattice.step_pix(), lattice.phases_per_pix());
        let mut ready = Self { place: [[0; 2]; N], part: [[0.0; 3]; N], brightness: [[0.0; 4]; N] };
        for stretch in 0..N {
            let dx = dx + (stretch * Lattice::COLUMNS) as f64;
            let (a, b) = ((dx * ux + dy * uy) as f32, (sign * (dy * ux - dx * uy)) as f32);
            let across = b - bow * (a * a - half2);
            let (place, known_pix) = lattice.place(across);
            ready.place[stretch] = place;
            ready.part[stretch] = [
                (across - known_pix) * per_phase,
                (step_b - step_pix - 2.0 * bow * a * step_a) * per_phase,
                -bow * step_a * step_a * per_phase,
            ];
            ready.brightness[stretch] = cubic(NODES.map(|column| {
                let a = a + column * step_a;
                // κv, and the twist from a to the foot.
                let turn = 2.0 * bow * (known_pix + column * step_pix);
                let foot = a + a * turn;
                (l0 + foot * (l1 + foot * (l2 + foot * l3))) * (1.0 + 0.5 * turn)
            }));
        }
        ready
    }

    /// Adds the light to pixels, of which the first is the first column.
    #[inline(always)]
    fn add_to(&self, lattice: &Lattice, pixels: &mut [f32]) {
        for (stretch, out) in pixels.chunks_mut(Lattice::COLUMNS).enumerate() {
            let Some([before, after]) = lattice.light(self.place[stretch], out.len()) else { continue };
            let ([p0, p1, p2], [b0, b1, b2, b3]) = (self.part[stretch], self.brightness[stretch]);
            for (((pixel, before), after), column) in out.iter_mut().zip(before).zip(after).zip(&COLUMNS) {
                let part = p0 + column * (p1 + column * p2);
                let brightness = b0 + column * (b1 + column * (b2 + column * b3));
                *pixel += brightness * (before + part * (after - before));
            }
        }
    }
}

/// Powers of the cubic through values at [`NODES`].
#[inline(always)]
fn cubic([f0, f1, f2, f3]: [f32; 4]) -> [f32; 4] {
    const PER: f32 = 1.0 / THIRD;
    // f₀ + t Δ + t (t - 1)/2 Δ² + t (t - 1) (t - 2)/6 Δ³
    let (d1, d2, d3) = (f1 - f0, f2 - 2.0 * f1 + f0, f3 - 3.0 * (f2 - f1) - f0);
    let [first, second, third] = [d1 - 0.5 * d2 + d3 * (1.0 / 3.0), 0.5 * (d2 - d3), d3 * (1.0 / 6.0)];
    [f0, first * PER, second * (PER * PER), third * (PER * PER * PER)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_goes_through_its_four_columns() {
        let value = |x: f32| 1.0 + x * (0.05 + x * (-0.002 + x * 2e-5));
        let powers = cubic(NODES.map(value));
        for x in COLUMNS {
            let found = powers.iter().rev().fold(0.0, |sum, power| sum * x + power);
            assert!((found - value(x)).abs() < 1e-5, "{x}: {found} {}", value(x));
        }
    }
}
