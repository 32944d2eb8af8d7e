//! Hidden light: the share of a streak's light on masked pixels, on pixels without a value, or outside of the
//! illuminated area.

use super::band::Band;
use crate::images::LightArea;

/// Share of the light of a column of which less counts as none.
const NOTHING: f64 = 0.02;

/// Returns the smallest share of a streak's light on pixels with a value, for streaks up to `reach` pixels beside the
/// drawn one; pixels outside the illuminated area do not count. With `in_lit_columns`, nor do columns of the streak
/// without any light on such pixels: a part of its length may be hidden.
pub(super) fn least_usable_beside(
    band: &Band,
    template: &[f32],
    light_area: &LightArea,
    reach: isize,
    in_lit_columns: bool,
) -> f64 {
    let share = |shift: isize| {
        let (mut all, mut light, mut usable) = (0.0, 0.0, 0.0);
        for (column, weights) in template.chunks_exact(band.height).enumerate() {
            let (mut inside, mut seen) = (0.0, 0.0);
            for (offset, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
                all += f64::from(*weight);
                let Ok(offset) = usize::try_from(offset as isize + shift) else { continue };
                if offset >= band.height || !light_area.contains(band.pixel(column, offset)) {
                    continue;
                }
                inside += f64::from(*weight);
                if band.values[column * band.height + offset].is_finite() {
                    seen += f64::from(*weight);
                }
            }
            if in_lit_columns && seen < NOTHING * inside {
                all -= inside;
                continue;
            }
            light += inside;
            usable += seen;
        }
        // A streak whose middle is outside of the image cannot be seen, whether or not its wings are masked.
        if 2.0 * light > all && light > 0.0 { usable / light } else { 1.0 }
    };
    (-reach..=reach).map(share).fold(1.0, f64::min)
}

/// Returns the fraction of the streak's length at which a pixel `margin` pixels from its middle, on either side, is
/// outside the illuminated area, and the fraction of its light that is masked or without a value.
pub(super) fn edge_and_hidden_shares(
    band: &Band,
    mask: &[bool],
    template: &[f32],
    light_area: &LightArea,
    margin: usize,
) -> (f64, f64) {
    let (mut lit, mut edge, mut light, mut hidden) = (0.0, 0.0, 0.0, 0.0);
    for (column, weights) in template.chunks_exact(band.height).enumerate() {
        if weights.iter().all(|weight| *weight <= 0.0) {
            continue;
        }
        lit += 1.0;
        let is_outside = |offset: usize| {
            let at = band.pixel(column, offset);
            !light_area.contains(at)
        };
        edge += f64::from(u8::from(is_outside(band.half() - margin) || is_outside(band.half() + margin)));
        let start = column * band.height;
        for (offset, weight) in weights.iter().enumerate() {
            light += f64::from(*weight);
            if mask[start + offset] || band.values[start + offset].is_nan() {
                hidden += f64::from(*weight);
            }
        }
    }
    (if lit > 0.0 { edge / lit } else { 1.0 }, if light > 0.0 { hidden / light } else { 1.0 })
}
