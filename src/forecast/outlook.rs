//! The answer to a question about a night.

use super::error::ForecastError;
use super::night::Night;
use super::request::{ForecastRequest, Selection};
use crate::output::counted;
use crate::passes::{Sky, VisiblePass, VisiblePasses, VisibleRequest};
use crate::photometry::MagnitudeSource;

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
    /// In words, why there is no pass over the sky's site; `None` where there is one.
    pub fn why_empty(&self, sky: &Sky, request: &ForecastRequest) -> Option<String> {
        if !self.found.passes.is_empty() {
            return None;
        }
        // Coordinates alone have no name.
        let named = sky.viewpoint().site().map(|observer| observer.site().name.as_str());
        let site = named.filter(|name| *name != "site").unwrap_or("the site");
        if let Some(why) = self.night.why_never_dark(site).filter(|_| !request.include_dark) {
            return Some(why);
        }
        let count = &self.found.not_shown;
        let satellites = self.found.satellites;
        let passes = |count: usize| counted(count, "pass", "passes");
        let verb = |count: usize, one: &'static str, many: &'static str| if count == 1 { one } else { many };
        let mut reasons = Vec::new();
        if count.in_shadow > 0 {
            let (passes, is) = (passes(count.in_shadow), verb(count.in_shadow, "is", "are"));
            reasons.push(format!("{passes} {is} in the Earth's shadow while it is dark at {site}"));
        }
        if count.too_low > 0 {
            let lowest_deg = request.min_culmination_rad.to_degrees();
            let culminates = verb(count.too_low, "culminates", "culminate");
            reasons.push(format!("{} {culminates} below {lowest_deg:.1} deg", passes(count.too_low)));
        }
        if let Some(limit) = request.max_magnitude.filter(|_| count.too_faint > 0) {
            let stays = verb(count.too_faint, "stays", "stay");
            reasons.push(format!("{} {stays} fainter than mag {limit}", passes(count.too_faint)));
        }
        if reasons.is_empty() {
            let lowest_deg = request.min_altitude_rad.to_degrees();
            let of = if satellites == 1 {
                "the one satellite does not stand".to_owned()
            } else {
                format!("none of {satellites} satellites stands")
            };
            let when = if request.include_dark { String::new() } else { format!(" while it is dark at {site}") };
            reasons.push(format!("{of} above {lowest_deg:.1} deg{when} within the time asked about"));
        }
        Some(reasons.join("; "))
    }

    /// In words, how many passes rest on a prior alone, shown or left out as too faint; `None` where none does.
    pub fn prior_warning(&self, sky: &Sky, max_magnitude: Option<f64>) -> Option<String> {
        let is_prior = |pass: &&VisiblePass| *sky.model(pass.element_index).source() == MagnitudeSource::Prior;
        let shown = self.found.passes.iter().filter(|pass| pass.visible.is_some()).filter(is_prior).count();
        let hidden = self.found.not_shown.too_faint_by_prior;
        let passes = |count: usize| counted(count, "pass", "passes");
        let mut told = Vec::new();
        if shown > 0 {
            told.push(format!("{} shown", passes(shown)));
        }
        if let Some(limit) = max_magnitude.filter(|_| hidden > 0) {
            told.push(format!("{} left out as fainter than mag {limit}", passes(hidden)));
        }
        let told = (!told.is_empty()).then(|| told.join(", "))?;
        Some(format!(
            "nothing is known of the brightness of some satellites, and their magnitudes are a wide prior alone ({told}); --qs-mag FILE takes standard magnitudes"
        ))
    }
}
