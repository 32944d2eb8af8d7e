//! Request of a forecast: time, limits, and selection of satellites.

use hifitime::Epoch;

use super::error::ForecastError;
use crate::constants::DAY_S;
use crate::elements::{ElementSet, Generation, GenerationTable};
use crate::frames::seconds_between;
use crate::photometry::PhotometryOptions;

/// Longest time of a forecast, days.
const LONGEST_DAYS: f64 = 31.0;
/// Largest number of points along one pass.
const MOST_SAMPLES: usize = 10_000;

/// Request for the passes of a night or of another interval.
#[derive(Clone, Debug, PartialEq)]
pub struct ForecastRequest {
    /// Start.
    pub start: Epoch,
    /// End, at most 31 days later.
    pub end: Epoch,
    /// Upper limit of the Sun's altitude at the site, radians; `None` includes day and night.
    pub max_sun_altitude_rad: Option<f64>,
    /// Altitude of rise and set, radians, [0, π/2).
    pub min_altitude_rad: f64,
    /// Minimum altitude at culmination, radians.
    pub min_culmination_rad: f64,
    /// Faintest peak magnitude; passes without a magnitude are omitted too.
    pub max_magnitude: Option<f64>,
    /// Includes passes in the Earth's shadow and in daylight.
    pub include_dark: bool,
    /// Number of points along each pass from rise to set; may be 0.
    pub samples: usize,
    /// Band, zero point and extinction of the magnitudes.
    pub photometry: PhotometryOptions,
}

impl ForecastRequest {
    /// Creates a request from `start` to `end` with the Sun 6 deg below the horizon, altitudes above 10 deg, and any
    /// magnitude.
    pub fn new(start: Epoch, end: Epoch) -> Self {
        Self {
            start,
            end,
            max_sun_altitude_rad: Some((-6.0_f64).to_radians()),
            min_altitude_rad: 10.0_f64.to_radians(),
            min_culmination_rad: 0.0,
            max_magnitude: None,
            include_dark: false,
            samples: 0,
            photometry: PhotometryOptions::default(),
        }
    }

    /// Checks the ranges of all numbers.
    ///
    /// # Errors
    /// [`ForecastError::OutOfRange`] for the first number that is out of range.
    pub fn check(&self) -> Result<(), ForecastError> {
        let days = seconds_between(self.start, self.end) / DAY_S;
        // Rounded to the degrees as entered: the conversion to radians and back changes the last digits.
        let degrees = |radians: f64| (radians.to_degrees() * 1e9).round() / 1e9;
        let out_of_range = |what, given, unit, allowed| Err(ForecastError::OutOfRange { what, given, unit, allowed });
        if !(0.0..=LONGEST_DAYS).contains(&days) {
            return out_of_range(
                "length of the requested interval",
                days,
                " days",
                "0 to 31 days, the end not before the start",
            );
        }
        if let Some(sun_rad) = self.max_sun_altitude_rad.filter(|sun_rad| !(-90.0..=90.0).contains(&degrees(*sun_rad)))
        {
            return out_of_range("sun-altitude-deg", degrees(sun_rad), " deg", "-90 to 90 deg");
        }
        for (what, given_rad) in
            [("min-altitude", self.min_altitude_rad), ("min-culmination", self.min_culmination_rad)]
        {
            if !(0.0..90.0).contains(&degrees(given_rad)) {
                return out_of_range(what, degrees(given_rad), " deg", "0 deg to below 90 deg");
            }
        }
        if let Some(magnitude) = self.max_magnitude.filter(|magnitude| !(-30.0..=40.0).contains(magnitude)) {
            return out_of_range("max-mag", magnitude, " mag", "-30 to 40 mag");
        }
        if self.samples > MOST_SAMPLES {
            return out_of_range("samples", self.samples as f64, "", "0 to 10000");
        }
        Ok(())
    }
}

/// Selection of satellites that match all three lists. A satellite matches a list if it matches one of the items, or if
/// the list is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Generations of satellites.
    pub generations: Vec<Generation>,
    /// Parts of names, in any case.
    pub names: Vec<String>,
    /// NORAD catalogue numbers.
    pub norad_ids: Vec<u32>,
}

impl Selection {
    /// Returns true for a selected satellite.
    pub fn contains(&self, elements: &ElementSet) -> bool {
        let is_named = || {
            let name = elements.name.to_lowercase();
            self.names.iter().any(|part| name.contains(&part.to_lowercase()))
        };
        (self.norad_ids.is_empty() || self.norad_ids.contains(&elements.norad_id.0))
            && (self.names.is_empty() || is_named())
            && (self.generations.is_empty() || self.generations.contains(&GenerationTable::embedded().of(elements)))
    }

    /// Returns a warning with the selected catalogue numbers that the element sets lack; `None` if all are present.
    pub fn unknown_warning(&self, elements: &[ElementSet]) -> Option<String> {
        let is_unknown = |id: &&u32| !elements.iter().any(|set| set.norad_id.0 == **id);
        let unknown: Vec<String> = self.norad_ids.iter().filter(is_unknown).map(ToString::to_string).collect();
        let numbers = if unknown.len() == 1 { "number" } else { "numbers" };
        (!unknown.is_empty())
            .then(|| format!("none of the {} satellites has NORAD {numbers} {}", elements.len(), unknown.join(" or ")))
    }

    /// Returns a description of the selection.
    pub fn description(&self) -> String {
        let list =
            |what: &str, items: Vec<String>| (!items.is_empty()).then(|| format!("{what} {}", items.join(" or ")));
        let parts = [
            list("generation", self.generations.iter().map(ToString::to_string).collect()),
            list("a name with", self.names.clone()),
            list("NORAD number", self.norad_ids.iter().map(ToString::to_string).collect()),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" and ")
    }
}
