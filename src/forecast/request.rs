//! Request for a forecast: time range and limits.

use hifitime::Epoch;

use crate::constants::DAY_S;
use crate::error::Error;
use crate::frames::seconds_between;
use crate::photometry::PhotometryOptions;

/// Longest time of a forecast, days.
const LONGEST_DAYS: f64 = 31.0;
/// Largest number of sampled points along one pass.
const MOST_SAMPLES: usize = 10_000;

/// Order of the passes of a forecast.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum PassOrder {
    /// By the time at which they become visible.
    #[default]
    Time,
    /// By the probability of being brighter than the limit, the most probable first; then by magnitude and time.
    /// Without a limit, the brightest first.
    Brightness,
}

impl PassOrder {
    /// Names of the orders, with the orders.
    pub const NAMES: [(&str, Self); 2] = [("time", Self::Time), ("brightness", Self::Brightness)];

    /// Returns the order with this name: `time` or `brightness`.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::NAMES.into_iter().find(|(known, _)| *known == name).map(|(_, order)| order)
    }
}

/// Request for the passes of a night or another time range.
#[derive(Clone, Debug, PartialEq)]
pub struct ForecastRequest {
    /// Start.
    pub start: Epoch,
    /// End, at most 31 days later.
    pub end: Epoch,
    /// Highest altitude of the Sun at the site for a visible pass, radians; `None` for no limit.
    pub max_sun_altitude_rad: Option<f64>,
    /// Altitude at which passes rise and set, radians, [0, π/2).
    pub min_altitude_rad: f64,
    /// Smallest altitude at culmination, radians.
    pub min_culmination_rad: f64,
    /// Magnitude limit by night. If it is set, only passes that are probably brighter are listed.
    pub max_magnitude: Option<f64>,
    /// Smallest probability of being brighter than the limit, [0, 1]; with 0 all passes are listed.
    pub min_probability: f64,
    /// If true, the limit in twilight is that of the same eye or instrument in a brighter sky.
    pub twilight: bool,
    /// Order of the passes.
    pub order: PassOrder,
    /// If true, passes in the Earth's shadow and in daylight are included.
    pub include_dark: bool,
    /// Number of sampled points along each pass from rise to set; may be 0.
    pub samples: usize,
    /// Band, magnitude system and extinction of the magnitudes.
    pub photometry: PhotometryOptions,
}

impl ForecastRequest {
    /// Creates a request from `start` to `end` for passes above 10 deg with the Sun below -6 deg, of any magnitude, in
    /// the order of time. Magnitudes are those above the atmosphere, and limits are the same in twilight as by night.
    pub fn new(start: Epoch, end: Epoch) -> Self {
        Self {
            start,
            end,
            max_sun_altitude_rad: Some((-6.0_f64).to_radians()),
            min_altitude_rad: 10.0_f64.to_radians(),
            min_culmination_rad: 0.0,
            max_magnitude: None,
            min_probability: 0.5,
            twilight: false,
            order: PassOrder::Time,
            include_dark: false,
            samples: 0,
            photometry: PhotometryOptions::default(),
        }
    }

    /// Checks the ranges of all numbers.
    ///
    /// # Errors
    /// The first number that is out of range.
    pub fn check(&self) -> Result<(), Error> {
        let days = seconds_between(self.start, self.end) / DAY_S;
        // Values are rounded to 1e-9 deg, because the conversion to radians and back changes the last digits.
        let degrees = |radians: f64| (radians.to_degrees() * 1e9).round() / 1e9;
        let out_of_range = |what: &str, given: f64, unit: &str, allowed: &str| {
            Err(Error::invalid(what, format_args!("{given}{unit}"), allowed))
        };
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
        if !(0.0..=1.0).contains(&self.min_probability) {
            return out_of_range("min-p-brighter", self.min_probability, "", "0 to 1");
        }
        if self.samples > MOST_SAMPLES {
            return out_of_range("samples", self.samples as f64, "", "0 to 10000");
        }
        Ok(())
    }
}
