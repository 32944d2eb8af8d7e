//! The clock where the telescope stands, and the Sun over it.

use hifitime::Epoch;
use streakcast::frames::{EopTable, Orientation};
use streakcast::geometry::{Observer, Site};
use streakcast::plot::LocalClock;

/// Between two places of the Sun, days: 1.25° at most, on which its way is straight to a few hundredths of a degree.
const STEP_DAYS: f64 = 5.0 / 1440.0;

/// A clock and its name.
pub struct Clock {
    ahead_of_utc_h: f64,
    name: String,
}

impl Clock {
    /// The one said, else that of the site's longitude, else none.
    pub fn new(offset_h: Option<f64>, site: Option<&Site>) -> Option<Self> {
        match (offset_h, site) {
            (Some(hours), _) => {
                let sign = if hours < 0.0 { '−' } else { '+' };
                let minutes = (hours.abs() * 60.0).round() as u32;
                let rest = if minutes.is_multiple_of(60) { String::new() } else { format!(":{:02}", minutes % 60) };
                Some(Self { ahead_of_utc_h: hours, name: format!("local time (UTC{sign}{}{rest})", minutes / 60) })
            }
            // The mean Sun goes 15° an hour.
            (None, Some(site)) => Some(Self {
                ahead_of_utc_h: site.longitude_rad.to_degrees() / 15.0,
                name: "local mean solar time".to_owned(),
            }),
            (None, None) => None,
        }
    }

    pub fn local(clock: Option<&Self>) -> Option<LocalClock<'_>> {
        clock.map(|clock| LocalClock { ahead_of_utc_h: clock.ahead_of_utc_h, name: &clock.name })
    }
}

/// Altitude of the Sun over a site, degrees, at a moment, MJD (UTC).
pub fn sun_altitude_deg(observer: &Observer, eop: &EopTable, mjd: f64) -> f64 {
    let moment = Epoch::from_mjd_utc(mjd);
    let state = observer.state(&Orientation::at(moment, eop));
    state.sun_altitude_azimuth_rad(moment).map_or(f64::NAN, |(altitude, _)| altitude.to_degrees())
}

/// Moments and altitudes of the Sun from somewhat before `first` until after `last`, MJD (UTC), degrees.
pub fn sun_over(site: &Site, eop: &EopTable, first: f64, last: f64) -> Vec<(f64, f64)> {
    let observer = Observer::new(site.clone());
    let room = 0.05 * (last - first) + STEP_DAYS;
    let steps = ((last - first + 2.0 * room) / STEP_DAYS).ceil() as usize;
    let at = |step: usize| first - room + step as f64 * STEP_DAYS;
    (0..=steps).map(|step| (at(step), sun_altitude_deg(&observer, eop, at(step)))).collect()
}
