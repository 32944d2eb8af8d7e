//! Distance from a streak up to which its light exceeds a level.

use super::super::psf::RadialProfile;

/// Distance of the tabulated positions across a streak, pixels.
const STEP_PIX: f64 = 0.25;

/// Profile of a line of light across its length, as the distance up to which it exceeds a level.
#[derive(Clone, Debug, PartialEq)]
pub struct LightWidth {
    /// Largest light at this distance or farther, for unit light per pixel of length; decreasing.
    table: Vec<f64>,
}

impl LightWidth {
    /// Tabulates a profile for lines at an angle from the rows.
    pub fn new(profile: &RadialProfile, angle_rad: f64) -> Self {
        let count = (profile.pixel_reach_pix() / STEP_PIX).ceil() as usize;
        let mut table: Vec<f64> = (0..=count).map(|step| profile.line(step as f64 * STEP_PIX, angle_rad)).collect();
        // Rings are brighter at their edge than in their middle.
        for step in (0..count).rev() {
            table[step] = table[step].max(table[step + 1]);
        }
        Self { table }
    }

    /// Returns the light of the brightest pixels for unit light per pixel of length.
    pub fn peak(&self) -> f64 {
        self.table[0]
    }

    /// Returns the distance, pixels, beyond which the light of a line with unit light per pixel of length is at most
    /// `level`; `None` if it is so everywhere.
    pub fn beyond_pix(&self, level: f64) -> Option<f64> {
        let above = self.table.partition_point(|light| *light > level);
        // The light crosses the level before the first step at which it is not above.
        (above > 0).then(|| (above.min(self.table.len() - 1)) as f64 * STEP_PIX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streaks::{Blur, Seeing};

    #[test]
    fn verif_width_of_a_gaussian_line() {
        let profile = RadialProfile::new(&Blur::seeing(Seeing::Gaussian { fwhm_pix: 6.0 })).unwrap();
        let width = LightWidth::new(&profile, 0.3);
        // exp(-r²/2σ²) = level / peak; pixels add 1/12 to the variance.
        let sigma = (6.0f64 / 2.3548).hypot((1.0f64 / 12.0).sqrt());
        for share in [0.5, 0.1, 0.01] {
            let expected = sigma * (-2.0 * f64::ln(share)).sqrt();
            let found = width.beyond_pix(share * width.peak()).unwrap();
            assert!(found >= expected - 0.02 && found <= expected + 0.27, "{share}: {found} {expected}");
        }
        assert_eq!(width.beyond_pix(width.peak()), None);
        assert!(width.beyond_pix(0.0).unwrap() <= profile.pixel_reach_pix() + 0.25);
    }
}
