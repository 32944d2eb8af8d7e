//! The answer to a question about a night.

use super::error::ForecastError;
use super::night::Night;
use super::request::{ForecastRequest, Selection};
use crate::passes::{Sky, VisiblePasses, VisibleRequest};

/// A night and what passes in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// When it is dark.
    pub night: Night,
    /// What passes.
    pub found: VisiblePasses,
}

/// Every visible pass of the satellites selected, on all threads of the current pool.
///
/// # Errors
/// A number out of range, nobody selected, an observer in orbit, or a time for which Sun and Earth are not known.
pub fn forecast(sky: &Sky, request: &ForecastRequest, selection: &Selection) -> Result<Forecast, ForecastError> {
    request.check()?;
    let satellites = sky.elements().len();
    if !sky.elements().iter().any(|elements| selection.holds(elements)) {
        return Err(ForecastError::NobodyWanted { satellites, wanted: selection.words() });
    }
    let night = Night::over(sky, request.start, request.end, request.max_sun_altitude_rad)?;
    let found = sky.visible_passes(
        &VisibleRequest {
            start: request.start,
            end: request.end,
            dark: night.dark.clone(),
            min_altitude_rad: request.min_altitude_rad,
            min_culmination_rad: request.min_culmination_rad,
            max_magnitude: request.max_magnitude,
            include_dark: request.include_dark,
            samples: request.samples,
            photometry: request.photometry,
        },
        &|element_index| selection.holds(&sky.elements()[element_index]),
    )?;
    Ok(Forecast { night, found })
}

impl Forecast {
    /// In words, why there is no pass; `None` where there is one.
    pub fn why_empty(&self, site: &str, request: &ForecastRequest) -> Option<String> {
        if !self.found.passes.is_empty() {
            return None;
        }
        if let Some(why) = self.night.why_never_dark(site).filter(|_| !request.include_dark) {
            return Some(why);
        }
        let count = &self.found.not_shown;
        let satellites = self.found.satellites;
        let mut reasons = Vec::new();
        if count.in_shadow > 0 {
            reasons.push(format!("{} passes are in the Earth's shadow while it is dark at {site}", count.in_shadow));
        }
        if count.too_low > 0 {
            let lowest_deg = request.min_culmination_rad.to_degrees();
            reasons.push(format!("{} culminate below {lowest_deg:.1} deg", count.too_low));
        }
        if let Some(limit) = request.max_magnitude.filter(|_| count.too_faint > 0) {
            reasons.push(format!("{} stay fainter than mag {limit}", count.too_faint));
        }
        if reasons.is_empty() {
            let lowest_deg = request.min_altitude_rad.to_degrees();
            reasons.push(format!(
                "none of {satellites} satellites rises above {lowest_deg:.1} deg while it is dark at {site}"
            ));
        }
        Some(reasons.join("; "))
    }
}
