//! Settings of a detector: the stages that are applied and their parameters.

use serde::Deserialize;

use super::conversion::Quantisation;
use super::crosstalk::Crosstalk;
use super::non_linearity::NonLinearity;
use super::saturation::Saturation;
use super::vignetting::Vignetting;
use crate::error::Error;

/// Detector, as described by a TOML table. Omitted stages are not applied. By default, electrons are converted to the
/// same number of counts, with photon noise only.
///
/// The stages are applied in the order in which they occur in a camera: vignetting, photon noise, saturation and
/// bleeding, non-linearity, crosstalk, read noise, gain and bias, quantisation.
///
/// ```
/// let detector = streakcast::images::Detector::from_toml(
///     "gain_e_adu = 1.6
///      read_noise_e = 8.5
///      bias_adu = 300
///      saturation = { full_well_e = 140000 }
///      quantisation = { greatest_adu = 65535 }",
/// )?;
/// assert_eq!(detector.saturation.map(|saturation| saturation.full_well_e), Some(140_000.0));
/// # Ok::<(), streakcast::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Detector {
    /// Gain, electrons per count, \[1e-6, 1e6\].
    pub gain_e_adu: f64,
    /// Bias, counts, \[-1e6, 1e6\].
    pub bias_adu: f64,
    /// Read noise (one sigma), electrons, \[0, 1e5\]. It is added only to synthetic frames, because existing frames
    /// contain it.
    pub read_noise_e: f64,
    /// If true, photon noise is simulated; if false, light is added without noise.
    pub shot_noise: bool,
    /// Loss of light towards the corners.
    pub vignetting: Option<Vignetting>,
    /// Full well of the pixels and bleeding.
    pub saturation: Option<Saturation>,
    /// Non-linearity of the signal.
    pub non_linearity: Option<NonLinearity>,
    /// Crosstalk between amplifiers.
    pub crosstalk: Option<Crosstalk>,
    /// Rounding of counts to integers, and their range.
    pub quantisation: Option<Quantisation>,
}

impl Default for Detector {
    fn default() -> Self {
        Self {
            gain_e_adu: 1.0,
            bias_adu: 0.0,
            read_noise_e: 0.0,
            shot_noise: true,
            vignetting: None,
            saturation: None,
            non_linearity: None,
            crosstalk: None,
            quantisation: None,
        }
    }
}

impl Detector {
    /// Reads the settings from a TOML table.
    ///
    /// # Errors
    /// The text is not a valid detector table, or a value fails [`Detector::validate`].
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        Self::parse(text).map_err(|error| error.at("detector"))
    }

    /// Reads the settings from the TOML of a file, which its errors do not name.
    pub(crate) fn parse(text: &str) -> Result<Self, Error> {
        let detector: Self = toml::from_str(text).map_err(|error| crate::input::toml_error(&error, text))?;
        detector.check()?;
        Ok(detector)
    }

    /// Checks the range of every number.
    ///
    /// # Errors
    /// The first value that is out of range, not finite, or inconsistent with the others.
    pub fn validate(&self) -> Result<(), Error> {
        self.check().map_err(|error| error.at("detector"))
    }

    /// Checks the range of every number. Its errors do not name the detector.
    pub(crate) fn check(&self) -> Result<(), Error> {
        Error::check_range("gain_e_adu", self.gain_e_adu, 1e-6, 1e6)?;
        Error::check_range("bias_adu", self.bias_adu, -1e6, 1e6)?;
        Error::check_range("read_noise_e", self.read_noise_e, 0.0, 1e5)?;
        self.vignetting.as_ref().map_or(Ok(()), Vignetting::validate)?;
        self.saturation.as_ref().map_or(Ok(()), Saturation::validate)?;
        self.non_linearity.as_ref().map_or(Ok(()), NonLinearity::validate)?;
        self.crosstalk.as_ref().map_or(Ok(()), Crosstalk::validate)?;
        self.quantisation.as_ref().map_or(Ok(()), Quantisation::validate)
    }

    /// Checks all values, and the amplifiers for a frame of this shape.
    ///
    /// # Errors
    /// The errors of [`Detector::validate`], and an amplifier that extends beyond the frame.
    pub(super) fn validate_for(&self, rows: usize, columns: usize) -> Result<(), Error> {
        self.validate()?;
        let shape = self.crosstalk.as_ref().map_or(Ok(()), |crosstalk| crosstalk.check_shape(rows, columns));
        shape.map_err(|error| error.at("detector"))
    }
}
