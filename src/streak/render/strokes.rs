//! The loops that put light into pixels, in the widest vectors of the machine.

use std::ops::Range;

use crate::camera::{Lanes, Lattice, Patch, ProfileTables};
use crate::vectors::{NullaryFnOnce, widest};

use super::blocks::{EACH, LANES, add};
use super::chords::Chord;
use super::ends::End;
use super::panels::PanelTree;
use super::runs::{Run, Source};

/// Columns of the pixels that share a phase of a lattice.
const COLUMNS: [f32; Lattice::COLUMNS] = {
    let mut columns = [0.0; Lattice::COLUMNS];
    let mut number = 0;
    while number < Lattice::COLUMNS {
        columns[number] = number as f32;
        number += 1;
    }
    columns
};

/// The profile across a line.
pub(super) struct Across {
    /// At the direction of a chord.
    pub line: Lanes,
    /// What a radian more makes of it; none for chords so straight that it is not felt.
    pub turned: Option<Lanes>,
    /// The first one for rows of pixels; for long and straight chords.
    pub lattice: Option<Lattice>,
}

/// All that the loops need.
pub(super) struct Strokes<'a> {
    pub chords: &'a [Chord],
    /// Tables of the profile across the path, and which of them each chord uses.
    pub tables: &'a [Across],
    pub table_of: &'a [usize],
    pub trees: &'a [PanelTree],
    /// Of each chord: the trees that reach its pixels.
    pub trees_of: &'a [Range<usize>],
    /// Ends that are drawn by the profile's table of half lines, and the trees that reach each one's middle.
    pub ends: &'a [(End, Range<usize>)],
    pub profile: &'a ProfileTables,
    pub runs: &'a [Run],
    pub patch: &'a mut Patch,
}

/// Draws all runs.
pub(super) fn draw(strokes: Strokes<'_>) {
    widest(strokes);
}

impl NullaryFnOnce for Strokes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for run in self.runs {
            let first_column = run.columns.start;
            let pixels = self.patch.stretch_mut(run.row, run.columns.clone());
            match run.source {
                Source::Smooth(number) => {
                    let table = &self.tables[self.table_of[number]];
                    smooth(&self.chords[number], table, self.profile, run.row, first_column, pixels);
                }
                Source::Summed(number) => {
                    let trees = &self.trees[self.trees_of[number].clone()];
                    summed(trees, self.profile, run.row, first_column, pixels);
                }
                Source::Edge { end, is_beside } => {
                    if let Some(table) = self.profile.edge() {
                        self.ends[end].0.add_to(table, is_beside, run.row, first_column, pixels);
                    }
                }
                Source::Middle(number) => {
                    pixels.fill(0.0);
                    let trees = &self.trees[self.ends[number].1.clone()];
                    summed(trees, self.profile, run.row, first_column, pixels);
                }
            }
        }
    }
}

/// Light of panels in pixels of a row.
#[inline(always)]
fn summed(trees: &[PanelTree], profile: &ProfileTables, row: usize, first_column: usize, pixels: &mut [f32]) {
    for (block, out) in pixels.chunks_mut(LANES).enumerate() {
        let at = [(first_column + block * LANES) as f64, row as f64];
        let mut light = [0.0; LANES];
        for tree in trees {
            tree.add_to(at, out.len(), profile, &mut light);
        }
        add(&light, out);
    }
}

/// Light of a chord in pixels of a row that have their feet on it.
///
/// A pixel at (a, b) has its foot at a₀ = a + d g and lies v = d (1 - g²/2) to the left of the path, where d = b - f(a), g = f'(a). Of a path of
/// curvature κ, points at a way u from the foot are at distance r² = v² + u² (1 - κv) from the pixel, to first order in κ, so that
///
/// I = λ(a₀) (1 + κv/2) L(v) + λ''/2 M₂(v).
///
/// Pixels are squares: L depends on the path's direction at the foot too, L(v, φ + κa₀) = L(v, φ) + κa₀ dL/dφ.
#[inline(always)]
fn smooth(chord: &Chord, table: &Across, profile: &ProfileTables, row: usize, first_column: usize, pixels: &mut [f32]) {
    let stroke = Smooth::of(chord, table, profile);
    if let Some(lattice) = &table.lattice {
        return straight(chord, &stroke, lattice, row, first_column, pixels);
    }
    let [ux, uy] = chord.along;
    let dy = row as f64 - chord.middle[1];
    for (block, out) in pixels.chunks_mut(LANES).enumerate() {
        let dx = (first_column + block * LANES) as f64 - chord.middle[0];
        let first = [(dx * ux + dy * uy) as f32, (dy * ux - dx * uy) as f32];
        let light = stroke.light(&stroke.feet(first, &EACH));
        add(&light, out);
    }
}

/// The same for long and straight chords, of even light or nearly, where the second order in g is not felt: light is read from a lattice.
#[inline(always)]
fn straight(chord: &Chord, stroke: &Smooth, lattice: &Lattice, row: usize, first_column: usize, pixels: &mut [f32]) {
    let [ux, uy] = chord.along;
    let dy = row as f64 - chord.middle[1];
    // A line is the same from both sides: v is to grow with the columns.
    let sign = if stroke.step[1] < 0.0 { -1.0 } else { 1.0 };
    let ([step_a, step_b], bow, half2) = ([stroke.step[0], sign * stroke.step[1]], sign * stroke.bow, stroke.half2);
    let [l0, l1, l2, l3] = stroke.light;
    for (number, out) in pixels.chunks_mut(Lattice::COLUMNS).enumerate() {
        let dx = (first_column + number * Lattice::COLUMNS) as f64 - chord.middle[0];
        let (a, b) = ((dx * ux + dy * uy) as f32, sign * (dy * ux - dx * uy) as f32);
        let Some(near) = lattice.columns(b - bow * (a * a - half2), out.len()) else { continue };
        // Distances from those that the lattice has; and the twist from a to the foot, which needs no better ones than these.
        let (b, step_b) = (b - near.known_pix, step_b - near.step_pix);
        let (twist, twist_step) = (2.0 * bow * near.known_pix, 2.0 * bow * near.step_pix);
        for (((pixel, before), after), column) in out.iter_mut().zip(near.before).zip(near.after).zip(&COLUMNS) {
            let a = a + column * step_a;
            let part = (b + column * step_b - bow * (a * a - half2)) * near.per_phase;
            let turn = twist + column * twist_step;
            let foot = a + a * turn;
            let light = l0 + foot * (l1 + foot * (l2 + foot * l3));
            // κv is the twist.
            let brightness = light * (1.0 + 0.5 * turn);
            *pixel += brightness * (before + part * (after - before));
        }
    }
}

/// A chord as the loop needs it.
struct Smooth<'a> {
    table: &'a Across,
    second_moment: Option<&'a Lanes>,
    step: [f32; 2],
    bow: f32,
    half2: f32,
    curvature: f32,
    light: [f32; 4],
}

/// Pixels as a chord sees them: v, a₀, and λ(a₀) (1 + κv/2).
struct Feet<const N: usize> {
    across: [f32; N],
    along: [f32; N],
    brightness: [f32; N],
}

impl<'a> Smooth<'a> {
    #[inline(always)]
    fn of(chord: &Chord, table: &'a Across, profile: &'a ProfileTables) -> Self {
        Self {
            table,
            second_moment: chord.is_bent(profile).then(|| profile.line_second_moment()),
            step: [chord.along[0] as f32, -chord.along[1] as f32],
            bow: chord.bow as f32,
            half2: (chord.half_pix * chord.half_pix) as f32,
            curvature: chord.curvature() as f32,
            light: chord.light.map(|power| power as f32),
        }
    }

    /// Of pixels so many columns after the first, whose a and b are given.
    #[inline(always)]
    fn feet<const N: usize>(&self, first: [f32; 2], columns: &[f32; N]) -> Feet<N> {
        let mut feet = Feet { across: [0.0; N], along: [0.0; N], brightness: [0.0; N] };
        for (lane, column) in columns.iter().enumerate() {
            let a = first[0] + column * self.step[0];
            let b = first[1] + column * self.step[1];
            let d = b - self.bow * (a * a - self.half2);
            let g = 2.0 * self.bow * a;
            let v = d * (1.0 - 0.5 * g * g);
            let foot = a + d * g;
            feet.across[lane] = v;
            feet.along[lane] = foot;
            let bend = self.light[2] + foot * self.light[3];
            feet.brightness[lane] =
                (self.light[0] + foot * (self.light[1] + foot * bend)) * (1.0 + 0.5 * self.curvature * v);
        }
        feet
    }

    #[inline(always)]
    fn light<const N: usize>(&self, feet: &Feet<N>) -> [f32; N] {
        let distance = feet.across.map(f32::abs);
        let mut shares = self.table.line.at(&distance);
        if let Some(turned) = &self.table.turned {
            let turned = turned.at(&distance);
            for lane in 0..N {
                // The path's direction at the foot: f'(a₀)
                shares[lane] += self.curvature * feet.along[lane] * turned[lane];
            }
        }
        let mut light = [0.0; N];
        for lane in 0..N {
            light[lane] = feet.brightness[lane] * shares[lane];
        }
        if let Some(moments) = self.second_moment {
            let moments = moments.at(&distance);
            for lane in 0..N {
                light[lane] += (self.light[2] + 3.0 * self.light[3] * feet.along[lane]) * moments[lane];
            }
        }
        light
    }
}
