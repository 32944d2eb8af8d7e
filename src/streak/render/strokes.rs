//! The loops that put light into pixels, in the widest vectors of the machine.

use std::ops::Range;

use pulp::{Arch, NullaryFnOnce};

use crate::camera::{Lanes, Patch, ProfileTables};

use super::chords::Chord;
use super::ends::End;
use super::panels::{LANES, PanelTree};
use super::runs::{Run, Source};

/// λ''/2λ times the variance from which on it is felt.
const LEAST_BEND: f64 = 2e-6;

/// All that the loops need.
pub(super) struct Strokes<'a> {
    pub chords: &'a [Chord],
    /// Tables of the profile across the path, and which of them each chord uses.
    pub tables: &'a [Lanes],
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
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => simd.vectorize(strokes),
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => simd.vectorize(strokes),
        _ => strokes.call(),
    }
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
                Source::Edge(number) => {
                    if let Some(table) = self.profile.edge() {
                        self.ends[number].0.add_to(table, run.row, first_column, pixels);
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
        for (pixel, light) in out.iter_mut().zip(light) {
            *pixel += light;
        }
    }
}

/// Light of a chord in pixels of a row that have their feet on it.
///
/// A pixel at (a, b) has its foot at a₀ = a + d g and lies v = d (1 - g²/2) to the left of the path, where d = b - f(a), g = f'(a). Of a path of
/// curvature κ, points at a way u from the foot are at distance r² = v² + u² (1 - κv) from the pixel, to first order in κ, so that
///
/// I = λ(a₀) (1 + κv/2) L(v) + λ''/2 M₂(v).
#[inline(always)]
fn smooth(chord: &Chord, table: &Lanes, profile: &ProfileTables, row: usize, first_column: usize, pixels: &mut [f32]) {
    let [ux, uy] = chord.along;
    let (bow, half2) = (chord.bow as f32, (chord.half_pix * chord.half_pix) as f32);
    let curvature = chord.curvature() as f32;
    let light = chord.light.map(|power| power as f32);
    let is_bent = chord.bend().abs() * profile.variance_pix2() > LEAST_BEND;
    let dy = row as f64 - chord.middle[1];
    for (block, out) in pixels.chunks_mut(LANES).enumerate() {
        let dx = (first_column + block * LANES) as f64 - chord.middle[0];
        let (a0, b0) = ((dx * ux + dy * uy) as f32, (dy * ux - dx * uy) as f32);
        let (step_a, step_b) = (ux as f32, -uy as f32);
        let (mut across, mut brightness) = ([0.0_f32; LANES], [0.0_f32; LANES]);
        for lane in 0..LANES {
            let a = a0 + lane as f32 * step_a;
            let b = b0 + lane as f32 * step_b;
            let d = b - bow * (a * a - half2);
            let g = 2.0 * bow * a;
            let v = d * (1.0 - 0.5 * g * g);
            let foot = a + d * g;
            across[lane] = v.abs();
            brightness[lane] = (light[0] + foot * (light[1] + foot * light[2])) * (1.0 + 0.5 * curvature * v);
        }
        let shares = table.at(&across);
        for lane in 0..LANES {
            brightness[lane] *= shares[lane];
        }
        if is_bent {
            let moments = profile.line_second_moment().at(&across);
            for lane in 0..LANES {
                brightness[lane] += light[2] * moments[lane];
            }
        }
        if let Ok(whole) = <&mut [f32; LANES]>::try_from(&mut *out) {
            for lane in 0..LANES {
                whole[lane] += brightness[lane];
            }
        } else {
            for (pixel, value) in out.iter_mut().zip(brightness) {
                *pixel += value;
            }
        }
    }
}
