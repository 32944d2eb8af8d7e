//! Width of a streak: a first estimate from the profile across the track, its fit, and its effect on the error of the
//! flux.

use super::background::median_and_sigma;
use super::band::Band;
use super::fit::{BlockFit, Blocks, fit_blocks, squares_by_block};
use super::search::Found;
use super::streak::{Measuring, Shift, profile_of};
use crate::error::Error;
use crate::math::minimum::minimum;
use crate::math::quantile::median;
use crate::streaks::Optics;

/// Range of fitted widths relative to the given one.
const WIDTH_RANGE: [f64; 2] = [0.4, 2.5];
/// The first estimate of the width uses the median profile across the track up to this distance, in FWHM of the given
/// width. It is not used if the peak of the profile is less than `PROFILE_SIGNAL` times its noise, or if the estimate
/// differs from the given width by more than the factor `MOST_WIDENING`.
const PROFILE_WIDTHS: f64 = 16.0;
const PROFILE_SIGNAL: f64 = 10.0;
const MOST_WIDENING: f64 = 8.0;
/// Smallest number of rows beside the streak whose scatter is a measure of the noise.
const LEAST_SKY_ROWS: usize = 10;

impl Measuring<'_> {
    /// Sets the seeing to the width of the median profile across the track, from which the fit of the width starts.
    ///
    /// This matters for streaks that are much wider than the given seeing, because their wings would otherwise be
    /// masked as stars.
    pub fn start_width(&mut self, found: &Found, late_s: f64) {
        let corridor = &self.corridor;
        let half = (PROFILE_WIDTHS * self.profile.fwhm_pix().max(1.0) / corridor.cos()).ceil() as usize;
        let line = [found.minor_pix, found.slope];
        let band = Band::read(self.image.plane, self.image.light_area, corridor, line, half);
        let is_exposed = |column: &usize| (0.0..=self.image.exposure_s).contains(&(corridor.time_s[*column] + late_s));
        let exposed: Vec<usize> = (0..band.len()).filter(is_exposed).collect();
        // Rows with fewer than half of the columns are at the edge of the frame.
        let row = |offset: usize| -> Option<f64> {
            let values = exposed.iter().map(|column| f64::from(band.values[column * band.height + offset]));
            let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
            (2 * values.len() > exposed.len()).then(|| median(values))
        };
        let rows: Vec<Option<f64>> = (0..band.height).map(row).collect();
        let near = half - half / 8..=half + half / 8;
        let peak = near.filter_map(|offset| Some((offset, rows[offset]?))).max_by(|a, b| a.1.total_cmp(&b.1));
        // One side may extend beyond the illuminated pixels, so the sky is measured at the brighter side.
        let sides = [0..half - 2 * half / 3, half + 2 * half / 3 + 1..band.height];
        let side = |offsets: std::ops::Range<usize>| {
            let values: Vec<f64> = rows[offsets].iter().flatten().copied().collect();
            (values.len() >= LEAST_SKY_ROWS).then(|| median_and_sigma(&values))
        };
        let beside = sides.into_iter().filter_map(side).max_by(|a, b| a.0.total_cmp(&b.0));
        let (Some((peak, light)), Some((sky, noise))) = (peak, beside) else { return };
        if light - sky < PROFILE_SIGNAL * noise.max(self.median_noise(exposed.len())) {
            return;
        }
        // Distance from the peak to the half of its light, interpolated between two pixels.
        let level = sky + 0.5 * (light - sky);
        let crossing = |step: isize| -> Option<f64> {
            let mut before = light;
            for distance in 1..half {
                let value = (*rows.get(peak.checked_add_signed(step * distance as isize)?)?)?;
                if value < level {
                    return Some(distance as f64 - (level - value) / (before - value));
                }
                before = value;
            }
            None
        };
        let (Some(left), Some(right)) = (crossing(-1), crossing(1)) else { return };
        let ratio = (left + right) * corridor.cos() / self.profile.fwhm_pix();
        if (1.0 / MOST_WIDENING..=MOST_WIDENING).contains(&ratio) {
            let given = self.optics;
            self.optics = Optics { seeing_arcsec: given.seeing_arcsec * ratio, ..given };
            // A width that cannot be drawn is not used.
            match profile_of(self.image, self.predicted, &self.optics) {
                Ok(profile) => self.profile = profile,
                Err(_) => self.optics = given,
            }
        }
    }

    /// Fits the seeing to the width of the streak, sets it, and returns it in arcsec, with the decrease of the sum of
    /// the squared residuals.
    pub fn fit_width(
        &mut self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
    ) -> Result<(f64, f64), Error> {
        let given = self.optics;
        let mut best = (0.0, f64::INFINITY);
        let mut of = |this: &mut Self, ln_ratio: f64| -> f64 {
            this.optics = Optics { seeing_arcsec: given.seeing_arcsec * ln_ratio.exp(), ..given };
            // Widths that cannot be drawn are excluded.
            let Ok(profile) = profile_of(this.image, this.predicted, &this.optics) else { return f64::NAN };
            this.profile = profile;
            let Ok(Some(drawn)) = this.drawn(band, shift) else { return f64::NAN };
            let squares = squares_by_block(&fit_blocks(band, &band.values, mask, &drawn.template, 0, blocks));
            if squares < best.1 {
                best = (ln_ratio, squares);
            }
            squares
        };
        let [low, high] = WIDTH_RANGE.map(f64::ln);
        /// Accuracy of the logarithm of the width.
        const TOLERANCE: f64 = 0.005;
        let start = (0.0, of(self, 0.0));
        minimum(|ln_ratio| of(self, ln_ratio), [low, high], start, TOLERANCE);
        self.optics = Optics { seeing_arcsec: given.seeing_arcsec * best.0.exp(), ..given };
        self.profile = profile_of(self.image, self.predicted, &self.optics)?;
        Ok((self.optics.seeing_arcsec, start.1 - best.1))
    }

    /// Returns the factor by which the variance of the flux is larger because the width is fitted, too:
    /// 1 / (1 - ρ²) with the correlation ρ of the template and its derivative by the width.
    pub fn width_inflation(&self, band: &Band, mask: &[bool], blocks: &Blocks, shift: &Shift) -> Result<f64, Error> {
        const STEP: f64 = 0.02;
        let given = self.optics;
        let template = |ratio: f64| -> Result<Option<Vec<f32>>, Error> {
            let optics = Optics { seeing_arcsec: given.seeing_arcsec * ratio, ..given };
            let profile = profile_of(self.image, self.predicted, &optics)?;
            Ok(self.drawn_with(&profile, band, shift)?.map(|drawn| drawn.template))
        };
        let (wider, same) = (template(1.0 + STEP)?, template(1.0)?);
        let (Some(wider), Some(same)) = (wider, same) else { return Ok(1.0) };
        let change: Vec<f32> = wider.iter().zip(&same).map(|(wider, same)| (wider - same) / STEP as f32).collect();
        // Pixels without a value in the frame have no value in the derivative.
        let change: Vec<f32> = change
            .iter()
            .zip(&band.values)
            .map(|(change, value)| if value.is_nan() { f32::NAN } else { *change })
            .collect();
        let fits = fit_blocks(band, &change, mask, &same, 0, blocks);
        let sum = |of: fn(&BlockFit) -> f64| fits.iter().map(of).sum::<f64>();
        let correlation = sum(|fit| fit.signal).powi(2) / (sum(|fit| fit.weight) * sum(|fit| fit.squares));
        Ok(1.0 / (1.0 - correlation.clamp(0.0, 0.9)))
    }
}
