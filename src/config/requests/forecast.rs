//! Which passes of which night.

use hifitime::Epoch;
use serde::Deserialize;

use super::error::QuestionError;
use super::time_range::time_range;
use crate::config::Setup;
use crate::elements::Generation;
use crate::forecast::{ForecastRequest, Selection};

/// A forecast as it was said; what is left out has the values of the command line.
///
/// ```
/// let said: streakcast::config::ForecastSaid = serde_json::from_str(r#"{"night": "2024-08-14", "max_mag": 5}"#)?;
/// assert_eq!((said.min_altitude, said.sun_altitude_deg), (10.0, Some(-6.0)));
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ForecastSaid {
    /// The evening's local date at the site.
    pub night: Option<String>,
    /// First moment, instead of a night.
    pub start: Option<String>,
    /// Last moment, at most 31 days later.
    pub end: Option<String>,
    /// Passes whose peak is fainter are left out, mag.
    pub max_mag: Option<f64>,
    /// What counts as rise and set, degrees.
    pub min_altitude: f64,
    /// Passes that culminate lower are left out, degrees.
    pub min_culmination: f64,
    /// What the Sun's altitude must be below, degrees; `None` for day and night.
    pub sun_altitude_deg: Option<f64>,
    /// Kinds of satellites by name; all where none is said.
    pub generation: Vec<String>,
    /// Parts of names.
    pub name: Vec<String>,
    /// NORAD catalogue numbers.
    pub norad: Vec<u32>,
    /// Passes in the Earth's shadow and by daylight too.
    pub include_dark: bool,
    /// Points along each pass.
    pub samples: Option<usize>,
}

impl Default for ForecastSaid {
    fn default() -> Self {
        Self {
            night: None,
            start: None,
            end: None,
            max_mag: None,
            min_altitude: 10.0,
            min_culmination: 0.0,
            sun_altitude_deg: Some(-6.0),
            generation: Vec::new(),
            name: Vec::new(),
            norad: Vec::new(),
            include_dark: false,
            samples: None,
        }
    }
}

impl ForecastSaid {
    /// Who is asked about.
    ///
    /// # Errors
    /// A kind that is not known.
    pub fn selection(&self) -> Result<Selection, QuestionError> {
        let kind = |name: &String| {
            Generation::by_name(name).ok_or_else(|| {
                let known = Generation::ALL.map(Generation::name).join(", ");
                QuestionError::said(format!("generation '{name}' is not known; allowed: {known}"))
            })
        };
        Ok(Selection {
            generations: self.generation.iter().map(kind).collect::<Result<_, _>>()?,
            names: self.name.clone(),
            norad_ids: self.norad.clone(),
        })
    }

    /// From when to when.
    ///
    /// # Errors
    /// As [`time_range`].
    pub fn time_range(&self, setup: &Setup) -> Result<(Epoch, Epoch), QuestionError> {
        time_range(self.night.as_deref(), self.start.as_deref(), self.end.as_deref(), setup)
    }

    /// What is asked of that time, with `unsaid_samples` points along each pass where neither this nor the setup says how many.
    ///
    /// # Errors
    /// A number out of range.
    pub fn request(
        &self,
        (start, end): (Epoch, Epoch),
        setup: &Setup,
        unsaid_samples: usize,
    ) -> Result<ForecastRequest, QuestionError> {
        let request = ForecastRequest {
            start,
            end,
            max_sun_altitude_rad: self.sun_altitude_deg.map(f64::to_radians),
            min_altitude_rad: self.min_altitude.to_radians(),
            min_culmination_rad: self.min_culmination.to_radians(),
            max_magnitude: self.max_mag,
            include_dark: self.include_dark,
            samples: self.samples.or(setup.samples).unwrap_or(unsaid_samples),
            photometry: setup.photometry()?,
        };
        request.check()?;
        Ok(request)
    }
}
