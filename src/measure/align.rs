//! First position of a bright streak: the brightest line near the position of the search.

use super::background::median_and_sigma;
use super::band::Band;
use super::search::{Extent, Found};
use super::streak::Measuring;
use crate::math::quantile::median;

/// Distance from the position of the search in which the brightest line of a streak is found, FWHM, and its smallest
/// value, pixels; number of parts of the track, smallest number of columns of a part, and smallest peak of its profile
/// relative to the noise of the profile.
const ALIGN_WIDTHS: f64 = 8.0;
const ALIGN_PIX: f64 = 12.0;
const ALIGN_PARTS: usize = 8;
const ALIGN_COLUMNS: usize = 4;
const ALIGN_SIGMAS: f64 = 20.0;

impl Measuring<'_> {
    /// Returns the position of the search with the distance and the slope of the brightest line near it.
    ///
    /// The search clips pixels at a few sigmas, which makes bright streaks seem wide, with the same light everywhere in
    /// this width. The brightest line is found in the median profile across the track of several parts of the track, by
    /// a robust line through their peaks. Without such a peak in at least three parts, and in more than half of the
    /// parts, the position stays the same. Peaks outside of the corridor are of other streaks.
    pub(super) fn aligned(&self, found: &Found, extent: &Extent) -> Found {
        let corridor = &self.corridor;
        let cos = corridor.cos();
        let fwhm = self.profile.fwhm_pix().max(1.0);
        let half = (ALIGN_WIDTHS * fwhm / cos).ceil().max(ALIGN_PIX) as usize;
        let line = [found.minor_pix, found.slope];
        let band = Band::read(self.image.plane, self.image.light_area, corridor, line, half);
        let middle = 0.5 * band.len() as f64;
        let is_exposed =
            |column: usize| (0.0..=self.image.exposure_s).contains(&(corridor.time_s[column] + found.late_s));
        let height = band.height;
        // Index of the middle of each part, and distance of its peak from the line.
        let mut peaks: Vec<(f64, f64)> = Vec::new();
        let mut parts = 0;
        for part in 0..ALIGN_PARTS {
            let columns = part * band.len() / ALIGN_PARTS..(part + 1) * band.len() / ALIGN_PARTS;
            let columns: Vec<usize> = columns
                .filter(|column| is_exposed(*column) && band.values[column * height + half].is_finite())
                .collect();
            if columns.len() < ALIGN_COLUMNS {
                continue;
            }
            parts += 1;
            let row = |offset: usize| -> Option<f64> {
                let values = columns.iter().map(|column| f64::from(band.values[column * height + offset]));
                let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
                (2 * values.len() > columns.len()).then(|| median(values))
            };
            let rows: Vec<Option<f64>> = (0..height).map(row).collect();
            let known: Vec<f64> = rows.iter().flatten().copied().collect();
            let (sky, noise) = median_and_sigma(&known);
            let noise = noise.max(self.median_noise(columns.len()));
            let value = |offset: usize| rows[offset].map_or(f64::NEG_INFINITY, |value| value - sky);
            let index = columns.iter().sum::<usize>() as f64 / columns.len() as f64 - middle;
            let track = found.minor_pix + found.slope * index - half as f64;
            let reach_pix = extent.reach_pix(index / cos);
            // The flank of a brighter streak beside the corridor is no peak.
            let is_peak = |offset: &usize| {
                ((*offset as f64 + track) * cos).abs() <= reach_pix
                    && (*offset == 0 || value(*offset) >= value(*offset - 1))
                    && (*offset + 1 == height || value(*offset) >= value(*offset + 1))
            };
            let peaks_inside = (0..height).filter(is_peak);
            let Some(peak) = peaks_inside.max_by(|a, b| value(*a).total_cmp(&value(*b))) else { continue };
            if noise.is_nan() || value(peak) <= ALIGN_SIGMAS * noise {
                continue;
            }
            // The middle of the light above half of the peak, also of a saturated one.
            let above = |offset: &usize| value(*offset) > 0.5 * value(peak);
            let light = (0..=peak).rev().take_while(above).chain((peak + 1..height).take_while(above));
            let [mut sum, mut weighted] = [0.0; 2];
            for offset in light {
                let light = value(offset) - 0.5 * value(peak);
                sum += light;
                weighted += light * (offset as f64 - half as f64);
            }
            peaks.push((index, weighted / sum));
        }
        if peaks.len() < 3 || 2 * peaks.len() <= parts {
            return *found;
        }
        let pairs = peaks
            .iter()
            .enumerate()
            .flat_map(|(number, first)| peaks[..number].iter().map(move |second| (first, second)));
        let slope = median(pairs.map(|(first, second)| (first.1 - second.1) / (first.0 - second.0)).collect());
        let shift = median(peaks.iter().map(|(index, distance)| distance - slope * index).collect());
        Found { minor_pix: found.minor_pix + shift, slope: found.slope + slope, ..*found }
    }
}
