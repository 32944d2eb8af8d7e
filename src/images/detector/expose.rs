//! Conversion of the whole light of a synthetic frame to counts, by all stages of the detector.

use rayon::prelude::*;

use crate::error::Error;
use crate::images::Plane;

use super::conversion::{Purpose, electrons, gaussian, stream};
use super::saturation::Saturated;
use super::settings::Detector;

impl Detector {
    /// Converts light to a frame in counts. The light is given as the expected electrons of each pixel before
    /// vignetting (sky, stars and streaks together). The result depends on the seed, but not on the number of threads.
    ///
    /// # Errors
    /// The errors of [`Detector::validate`], and an amplifier that extends beyond the frame.
    pub fn expose(&self, light: &Plane, seed: u64) -> Result<(Plane, Saturated), Error> {
        let (rows, columns) = (light.rows(), light.columns());
        self.validate_for(rows, columns)?;
        let mut frame = light.clone();
        if columns == 0 {
            return Ok((frame, Saturated::default()));
        }
        frame.values_mut().par_chunks_mut(columns).enumerate().for_each(|(row, pixels)| {
            if let Some(vignetting) = &self.vignetting {
                vignetting.apply(rows, columns, row, 0, pixels);
            }
            if self.shot_noise {
                let mut random = stream(seed, Purpose::Shot, row);
                pixels.iter_mut().for_each(|pixel| *pixel = electrons(*pixel, &mut random));
            }
        });
        let saturated =
            self.saturation.map_or_else(Saturated::default, |saturation| saturation.apply(&mut frame, None));
        if let Some(non_linearity) = &self.non_linearity {
            let bend = |pixel: &mut f32| *pixel = non_linearity.measured(f64::from(*pixel)) as f32;
            frame.values_mut().par_iter_mut().for_each(bend);
        }
        if let Some(crosstalk) = &self.crosstalk {
            let signal = frame.clone();
            for row in 0..rows {
                for (column, pixel) in signal.row(row).iter().enumerate() {
                    crosstalk.spread(row, column, *pixel, |row, column, ghost| frame.row_mut(row)[column] += ghost);
                }
            }
        }
        frame.values_mut().par_chunks_mut(columns).enumerate().for_each(|(row, pixels)| {
            if self.read_noise_e > 0.0 {
                let mut random = stream(seed, Purpose::Read, row);
                pixels.iter_mut().for_each(|pixel| *pixel += gaussian(self.read_noise_e as f32, &mut random));
            }
            for pixel in pixels {
                *pixel = (f64::from(*pixel) / self.gain_e_adu + self.bias_adu) as f32;
                if let Some(quantisation) = &self.quantisation {
                    *pixel = quantisation.apply(*pixel);
                }
            }
        });
        Ok((frame, saturated))
    }
}
