//! A detector: which of its stages there are.

use serde::Deserialize;

use super::conversion::Quantisation;
use super::crosstalk::Crosstalk;
use super::error::DetectorError;
use super::non_linearity::NonLinearity;
use super::saturation::Saturation;
use super::vignetting::Vignetting;

/// A detector, as a TOML table. What is left out is not there: the default turns electrons into as many counts, with photon noise and no other.
///
/// Stages follow one another as in the camera: vignetting, photon noise, full wells and bleeding, non-linearity, crosstalk, read noise, gain
/// and bias, whole counts.
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
/// # Ok::<(), streakcast::images::DetectorError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Detector {
    /// Electrons per count, \[1e-6, 1e6\].
    pub gain_e_adu: f64,
    /// Counts without light, \[-1e6, 1e6\].
    pub bias_adu: f64,
    /// Sigma of the readout, electrons, \[0, 1e5\]. Only synthetic frames get it: others have it already.
    pub read_noise_e: f64,
    /// Whether light comes in whole photons. Without it light is added without any noise.
    pub shot_noise: bool,
    /// Light lost towards the corners.
    pub vignetting: Option<Vignetting>,
    /// Full wells.
    pub saturation: Option<Saturation>,
    /// Signals against charge.
    pub non_linearity: Option<NonLinearity>,
    /// Ghosts between amplifiers.
    pub crosstalk: Option<Crosstalk>,
    /// Whole counts.
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
    /// From the text of a TOML table.
    ///
    /// # Errors
    /// [`DetectorError::Toml`] for what is not a detector, otherwise as [`Detector::validate`].
    pub fn from_toml(text: &str) -> Result<Self, DetectorError> {
        let detector: Self = toml::from_str(text)
            .map_err(|error| DetectorError::Toml { message: error.to_string().trim().to_owned() })?;
        detector.validate()?;
        Ok(detector)
    }

    /// Holds every number to its range.
    ///
    /// # Errors
    /// [`DetectorError`] with the first that is outside, not finite, or does not go with the others.
    pub fn validate(&self) -> Result<(), DetectorError> {
        DetectorError::hold("gain_e_adu", self.gain_e_adu, 1e-6, 1e6)?;
        DetectorError::hold("bias_adu", self.bias_adu, -1e6, 1e6)?;
        DetectorError::hold("read_noise_e", self.read_noise_e, 0.0, 1e5)?;
        self.vignetting.as_ref().map_or(Ok(()), Vignetting::validate)?;
        self.saturation.as_ref().map_or(Ok(()), Saturation::validate)?;
        self.non_linearity.as_ref().map_or(Ok(()), NonLinearity::validate)?;
        self.crosstalk.as_ref().map_or(Ok(()), Crosstalk::validate)?;
        self.quantisation.as_ref().map_or(Ok(()), Quantisation::validate)
    }

    /// # Errors
    /// As [`Detector::validate`], and [`DetectorError::AmplifierOutside`] for a frame smaller than what the amplifiers read.
    pub(super) fn validate_for(&self, rows: usize, columns: usize) -> Result<(), DetectorError> {
        self.validate()?;
        self.crosstalk.as_ref().map_or(Ok(()), |crosstalk| crosstalk.check_shape(rows, columns))
    }
}
