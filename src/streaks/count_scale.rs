//! From magnitudes to what a frame counts.

use thiserror::Error;

/// Why a frame's counts have no magnitudes.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CountScaleError {
    /// A zero point that is none.
    #[error("zero point {given} mag (allowed: -20 to 60)")]
    ZeroPoint {
        /// As given.
        given: f64,
    },
    /// An exposure without length.
    #[error("an exposure of {given} s (allowed: above 0)")]
    Exposure {
        /// As given, seconds.
        given: f64,
    },
}

/// How many counts a second of light makes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CountScale {
    zero_point_mag: f64,
    exposure_s: f64,
}

impl CountScale {
    /// `zero_point_mag` is the magnitude of a star whose image in the frame sums to 1, in whatever unit the frame has: counts of the whole
    /// exposure, or counts per second.
    ///
    /// # Errors
    /// A zero point out of range, an exposure that is not above 0 s.
    pub fn of_frame(zero_point_mag: f64, exposure_s: f64) -> Result<Self, CountScaleError> {
        if !(-20.0..=60.0).contains(&zero_point_mag) {
            return Err(CountScaleError::ZeroPoint { given: zero_point_mag });
        }
        if !(exposure_s > 0.0 && exposure_s.is_finite()) {
            return Err(CountScaleError::Exposure { given: exposure_s });
        }
        Ok(Self { zero_point_mag, exposure_s })
    }

    /// `zero_point_mag` is the magnitude of a star that makes 1 count per second, in a frame that holds the counts of the whole exposure.
    ///
    /// # Errors
    /// As [`CountScale::of_frame`].
    pub fn of_a_second(zero_point_mag: f64, exposure_s: f64) -> Result<Self, CountScaleError> {
        // A star is in the frame for the whole exposure: ZP_frame = ZP_1s + 2.5 log10 t.
        Self::of_frame(zero_point_mag, exposure_s)?;
        Self::of_frame(zero_point_mag + 2.5 * exposure_s.log10(), exposure_s)
    }

    /// Frame units per second of a light of this magnitude that stands still; 0 in the dark.
    pub fn rate(&self, magnitude: Option<f64>) -> f64 {
        // A star of the exposure's length sums to 10^(-0.4 (m - ZP)).
        magnitude.map_or(0.0, |magnitude| 10f64.powf(-0.4 * (magnitude - self.zero_point_mag)) / self.exposure_s)
    }

    /// Magnitude of a light that stands still and makes as much a second; `None` where it makes nothing.
    pub fn magnitude(&self, rate: f64) -> Option<f64> {
        (rate > 0.0).then(|| self.zero_point_mag - 2.5 * (rate * self.exposure_s).log10())
    }

    /// Magnitude of a star that sums to 1 in the frame.
    pub fn zero_point_mag(&self) -> f64 {
        self.zero_point_mag
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_a_star_sums_to_its_magnitude() {
        let frame = CountScale::of_frame(25.0, 30.0).unwrap();
        assert!((frame.rate(Some(20.0)) * 30.0 - 100.0).abs() < 1e-9);
        let second = CountScale::of_a_second(25.0, 30.0).unwrap();
        assert!((second.rate(Some(20.0)) - 100.0).abs() < 1e-9);
        assert_eq!(frame.rate(None), 0.0);
        assert!((frame.magnitude(frame.rate(Some(7.3))).unwrap() - 7.3).abs() < 1e-12);
        assert_eq!(frame.magnitude(0.0), None);
        assert!(CountScale::of_frame(f64::NAN, 30.0).is_err() && CountScale::of_frame(25.0, 0.0).is_err());
        assert!(CountScale::of_a_second(25.0, -1.0).unwrap_err().to_string().contains("-1 s"));
    }
}
