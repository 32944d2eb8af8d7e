//! Learned files: corrections of magnitudes and of errors along the track, from measurements of satellites.
//!
//! `streakcast learn` writes them, and `--learned FILE` applies them (docs/explanation/learning.md).

use std::path::Path;

use hifitime::Epoch;
use serde::{Deserialize, Serialize};

use crate::elements::Generation;
use crate::error::Error;
use crate::input::json_error;
use crate::photometry::{ErrorDistribution, NormalPart};

/// Version of the schema that is supported.
const SCHEMA: u32 = 1;

/// Largest accepted offset, mag.
const MOST_OFFSET_MAG: f64 = 10.0;
/// Accepted sigmas, mag.
const SIGMAS_MAG: [f64; 2] = [0.01, 5.0];
/// Accepted factors of the error along the track.
const LATENESS_FACTORS: [f64; 2] = [0.1, 10.0];

/// Content of a learned file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct LearnedFile {
    /// Version of the schema; 1.
    pub schema: u32,
    /// Name and version of the program that wrote the file.
    pub program: String,
    /// Files of the measurements, and the options of the run.
    pub provenance: serde_json::Map<String, serde_json::Value>,
    /// Time of the first measurement, UTC.
    pub first_utc: String,
    /// Time of the last measurement, UTC.
    pub last_utc: String,
    /// Kinds of satellites.
    #[doc(hidden)]
    pub kinds: Vec<LearnedKind>,
    /// Satellites with measured magnitudes.
    #[doc(hidden)]
    pub satellites: Vec<LearnedSatellite>,
}

/// Corrections of the satellites of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedKind {
    /// Kind of satellite.
    pub kind: Generation,
    /// Correction of magnitudes; null without measured magnitudes.
    pub magnitude: Option<LearnedMagnitude>,
    /// Correction of the error along the track; null without measured delays.
    pub lateness: Option<LearnedLateness>,
}

/// Correction of the magnitudes of one kind of satellite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedMagnitude {
    /// Source of the magnitudes of the model, for example `brdf:oneweb-panels`.
    pub model: String,
    /// Number of satellites.
    pub satellites: usize,
    /// Number of passes.
    pub passes: usize,
    /// Number of measurements.
    pub measurements: usize,
    /// Time of the first measurement, UTC.
    pub first_utc: String,
    /// Time of the last measurement, UTC.
    pub last_utc: String,
    /// Mean offset of the satellites, mag; positive is fainter than the model.
    pub offset_mag: f64,
    /// One sigma of the mean offset, mag.
    pub offset_sigma_mag: f64,
    /// Standard deviation of the offsets of the satellites, mag.
    pub satellite_sigma_mag: f64,
    /// Scale of the differences between passes of a satellite (Student's t with four degrees of freedom), mag.
    pub pass_scale_mag: f64,
    /// One sigma of the measurements within a pass, mag.
    pub point_sigma_mag: f64,
    /// One sigma of a single measurement about the learned magnitude, mag, for satellites of this kind that have no
    /// entry of their own in the file.
    pub sigma_mag: f64,
}

/// Correction of the error along the track of one kind of satellite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedLateness {
    /// Number of measured delays.
    pub measurements: usize,
    /// Factor of the error along the track.
    pub factor: f64,
    /// One sigma of the factor, as a fraction of it.
    pub relative_sigma: f64,
}

/// Correction of the magnitudes of one satellite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedSatellite {
    /// NORAD catalogue number.
    pub norad_id: u32,
    /// Kind of satellite.
    pub kind: Generation,
    /// Number of passes.
    pub passes: usize,
    /// Number of measurements.
    pub measurements: usize,
    /// Time of the first measurement, UTC.
    pub first_utc: String,
    /// Time of the last measurement, UTC.
    pub last_utc: String,
    /// Offset from the model, mag; positive is fainter than the model.
    pub offset_mag: f64,
    /// One sigma of the offset, mag.
    pub offset_sigma_mag: f64,
    /// One sigma of a measurement in another pass, mag.
    pub sigma_mag: f64,
}

/// Distribution of measured magnitudes about learned ones, in units of their sigma: two normal distributions that agree
/// with Student's t of four degrees of freedom, whose central 68.27 % are within one sigma.
pub(crate) const LEARNED_ERRORS: ErrorDistribution =
    ErrorDistribution { parts: [symmetric(0.69, 0.78), symmetric(0.31, 1.75), symmetric(0.0, 1.0)] };

const fn symmetric(share: f64, width: f64) -> NormalPart {
    NormalPart { share, centre: 0.0, width }
}

impl LearnedFile {
    /// Creates a file of the supported schema from its content.
    #[doc(hidden)]
    pub fn new(
        provenance: serde_json::Map<String, serde_json::Value>,
        [first_utc, last_utc]: [String; 2],
        kinds: Vec<LearnedKind>,
        satellites: Vec<LearnedSatellite>,
    ) -> Self {
        let program = concat!("streakcast ", env!("CARGO_PKG_VERSION")).to_owned();
        Self { schema: SCHEMA, program, provenance, first_utc, last_utc, kinds, satellites }
    }

    /// Reads and validates a file.
    ///
    /// # Errors
    /// The file cannot be read, or as for [`Self::from_json`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        let failed = |source| Error::system(source).in_file("learned file", path);
        Self::from_json(&crate::input::read_to_string(path).map_err(failed)?, &path.display().to_string())
    }

    /// Reads and validates the text of a file; errors contain `origin` (the name of the file).
    ///
    /// # Errors
    /// The text is not JSON, a key is unknown or missing, or a value is out of range.
    pub fn from_json(text: &str, origin: &str) -> Result<Self, Error> {
        let failed = |error| json_error(&error).in_file("learned file", origin);
        let file: Self = serde_json::from_str(text).map_err(failed)?;
        file.validate(origin)?;
        Ok(file)
    }

    /// Returns the text of the file, indented.
    pub fn to_json(&self) -> String {
        // Serialising cannot fail: all keys are strings, and all numbers of a validated file are finite.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    fn validate(&self, origin: &str) -> Result<(), Error> {
        let wrong = |key: String, given: String, allowed: String| {
            Error::invalid(key, given, allowed).in_file("learned file", origin)
        };
        if self.schema != SCHEMA {
            return Err(wrong("schema".to_owned(), self.schema.to_string(), SCHEMA.to_string()));
        }
        let range = |key: String, given: f64, [least, most]: [f64; 2]| {
            // NaN is outside every range.
            if (least..=most).contains(&given) {
                return Ok(());
            }
            Err(wrong(key, given.to_string(), format!("{least} to {most}")))
        };
        let offsets = [-MOST_OFFSET_MAG, MOST_OFFSET_MAG];
        let time = |key: String, text: &str| match text.parse::<Epoch>() {
            Ok(_) => Ok(()),
            Err(_) => Err(wrong(key, format!("{text:?}"), "a time in UTC, such as 2026-08-14T23:36:25Z".to_owned())),
        };
        time("first_utc".to_owned(), &self.first_utc)?;
        time("last_utc".to_owned(), &self.last_utc)?;
        for (at, learned) in self.kinds.iter().enumerate() {
            if self.kinds[..at].iter().any(|other| other.kind == learned.kind) {
                return Err(wrong(format!("kinds[{at}].kind"), learned.kind.to_string(), "each kind once".to_owned()));
            }
            if let Some(magnitude) = &learned.magnitude {
                let key = |name: &str| format!("kinds[{at}].magnitude.{name}");
                range(key("offset_mag"), magnitude.offset_mag, offsets)?;
                range(key("sigma_mag"), magnitude.sigma_mag, SIGMAS_MAG)?;
            }
            if let Some(lateness) = &learned.lateness {
                range(format!("kinds[{at}].lateness.factor"), lateness.factor, LATENESS_FACTORS)?;
            }
        }
        let mut seen = std::collections::BTreeSet::new();
        for (at, satellite) in self.satellites.iter().enumerate() {
            let key = |name: &str| format!("satellites[{at}].{name}");
            if !seen.insert(satellite.norad_id) {
                return Err(wrong(key("norad_id"), satellite.norad_id.to_string(), "each satellite once".to_owned()));
            }
            if self.magnitude_of(satellite.kind).is_none() {
                return Err(wrong(
                    key("kind"),
                    satellite.kind.to_string(),
                    "a kind in kinds with a magnitude".to_owned(),
                ));
            }
            range(key("offset_mag"), satellite.offset_mag, offsets)?;
            range(key("sigma_mag"), satellite.sigma_mag, SIGMAS_MAG)?;
        }
        Ok(())
    }

    /// Returns the entry of a kind; `None` if it is not in the file.
    #[doc(hidden)]
    pub fn of_kind(&self, kind: Generation) -> Option<&LearnedKind> {
        self.kinds.iter().find(|learned| learned.kind == kind)
    }

    /// Returns the correction of the magnitudes of a kind.
    pub(crate) fn magnitude_of(&self, kind: Generation) -> Option<&LearnedMagnitude> {
        self.of_kind(kind)?.magnitude.as_ref()
    }

    /// Returns the factor of the error along the track of a kind; 1 without measurements.
    pub fn lateness_factor(&self, kind: Generation) -> f64 {
        self.of_kind(kind).and_then(|learned| learned.lateness.as_ref()).map_or(1.0, |lateness| lateness.factor)
    }

    /// Returns a summary for the provenance of results.
    pub fn summary(&self, path: &str) -> serde_json::Value {
        let models = self.kinds.iter().filter_map(|learned| {
            let magnitude = learned.magnitude.as_ref()?;
            Some(serde_json::json!({
                "kind": learned.kind.name(), "model": magnitude.model, "offset_mag": magnitude.offset_mag,
                "sigma_mag": magnitude.sigma_mag, "passes": magnitude.passes,
            }))
        });
        serde_json::json!({
            "file": path,
            "first_utc": self.first_utc,
            "last_utc": self.last_utc,
            "satellites": self.satellites.len(),
            "kinds": models.collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_learned_errors_are_those_of_student() {
        // Cumulative distribution of Student's t with four degrees of freedom:
        // F(t) = 1/2 + 3/8 (t/q) (1 - t²/q² / 12), q = √(1 + t²/4)
        let student = |t: f64| {
            let q = (1.0 + t * t / 4.0).sqrt();
            0.5 + 0.375 * (t / q) * (1.0 - t * t / (12.0 * q * q))
        };
        // 68.27 % are within 1.1416 scales.
        const HALF_WIDTH: f64 = 1.1416;
        assert!((student(HALF_WIDTH) - student(-HALF_WIDTH) - 0.6827).abs() < 1e-4);
        for x in [0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0] {
            let (two_normals, t) = (LEARNED_ERRORS.cumulative(x, 0.0), student(x * HALF_WIDTH));
            assert!((two_normals - t).abs() < 0.005, "{x}: {two_normals} for {t}");
        }
    }
}
