//! Conversion between magnitudes and counts of a frame.

use crate::error::Error;

/// Conversion between magnitudes and counts per second of a frame.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CountScale {
    zero_point_mag: f64,
    exposure_s: f64,
}

impl CountScale {
    /// Creates the scale from the zero point of a frame, which is the magnitude of a star whose pixels sum to 1 in the
    /// unit of the frame (counts of the whole exposure, or counts per second).
    ///
    /// # Errors
    /// The zero point is out of range, or the exposure time is not above 0 s.
    pub fn of_frame(zero_point_mag: f64, exposure_s: f64) -> Result<Self, Error> {
        Error::check_range("zero point (mag)", zero_point_mag, -20.0, 60.0)?;
        if !(exposure_s > 0.0 && exposure_s.is_finite()) {
            return Err(Error::invalid("exposure", format!("{exposure_s} s"), "above 0 s"));
        }
        Ok(Self { zero_point_mag, exposure_s })
    }

    /// Creates the scale of a frame in counts of the whole exposure from the magnitude of a star of 1 count per second.
    ///
    /// # Errors
    /// The errors of [`CountScale::of_frame`].
    pub fn of_counts_per_second(zero_point_mag: f64, exposure_s: f64) -> Result<Self, Error> {
        // A star is exposed during the whole exposure time t: ZP_frame = ZP_1s + 2.5 log10 t.
        Self::of_frame(zero_point_mag, exposure_s)?;
        Self::of_frame(zero_point_mag + 2.5 * exposure_s.log10(), exposure_s)
    }

    /// Returns the rate, in the frame's unit per second, of a stationary light of this magnitude; 0 for `None`.
    pub fn rate(&self, magnitude: Option<f64>) -> f64 {
        // The pixels of a star that is exposed for the whole time sum to 10^(-0.4 (m - ZP)).
        magnitude.map_or(0.0, |magnitude| 10f64.powf(-0.4 * (magnitude - self.zero_point_mag)) / self.exposure_s)
    }

    /// Returns the magnitude of a stationary light of this rate (the frame's unit per second); `None` if the rate is 0.
    pub fn magnitude(&self, rate: f64) -> Option<f64> {
        (rate > 0.0).then(|| self.zero_point_mag - 2.5 * (rate * self.exposure_s).log10())
    }

    /// Returns the magnitude of a star whose pixels sum to 1 in the frame's unit.
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
        let second = CountScale::of_counts_per_second(25.0, 30.0).unwrap();
        assert!((second.rate(Some(20.0)) - 100.0).abs() < 1e-9);
        assert_eq!(frame.rate(None), 0.0);
        assert!((frame.magnitude(frame.rate(Some(7.3))).unwrap() - 7.3).abs() < 1e-12);
        assert_eq!(frame.magnitude(0.0), None);
        assert!(CountScale::of_frame(f64::NAN, 30.0).is_err() && CountScale::of_frame(25.0, 0.0).is_err());
        assert!(CountScale::of_counts_per_second(25.0, -1.0).unwrap_err().to_string().contains("-1 s"));
    }
}
