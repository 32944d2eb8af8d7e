//! Local time and altitude of the Sun at a site.

use hifitime::Epoch;
use streakcast::frames::{EopTable, Orientation};
use streakcast::geometry::{Observer, Site};
use streakcast::plot::LocalClock;

/// Interval between two computed positions of the Sun, days. The Sun's altitude changes by at most 1.25° in this time;
/// linear interpolation is accurate to a few hundredths of a degree.
const STEP_DAYS: f64 = 5.0 / 1440.0;

/// Local time: offset from UTC, and name on the axis.
pub struct Clock {
    ahead_of_utc_h: f64,
    name: String,
}

impl Clock {
    /// Returns the local time with a given offset, or else the mean solar time of a site; `None` if neither is given.
    pub fn new(offset_h: Option<f64>, site: Option<&Site>) -> Option<Self> {
        match (offset_h, site) {
            (Some(hours), _) => {
                let sign = if hours < 0.0 { '−' } else { '+' };
                let minutes = (hours.abs() * 60.0).round() as u32;
                let rest = if minutes.is_multiple_of(60) { String::new() } else { format!(":{:02}", minutes % 60) };
                Some(Self { ahead_of_utc_h: hours, name: format!("local time (UTC{sign}{}{rest})", minutes / 60) })
            }
            // The mean Sun moves by 15° per hour.
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

/// Returns the altitude of the Sun at a site, degrees, at a time given as MJD (UTC).
pub fn sun_altitude_deg(observer: &Observer, eop: &EopTable, mjd: f64) -> f64 {
    let moment = Epoch::from_mjd_utc(mjd);
    let state = observer.state(&Orientation::at(moment, eop));
    state.sun_altitude_azimuth_rad(moment).map_or(f64::NAN, |(altitude, _)| altitude.to_degrees())
}

/// Returns times (MJD, UTC) and altitudes of the Sun (degrees) for an interval that includes `first` and `last`.
pub fn sun_over(site: &Site, eop: &EopTable, first: f64, last: f64) -> Vec<(f64, f64)> {
    let observer = Observer::new(site.clone());
    let margin = 0.05 * (last - first) + STEP_DAYS;
    let steps = ((last - first + 2.0 * margin) / STEP_DAYS).ceil() as usize;
    let at = |step: usize| first - margin + step as f64 * STEP_DAYS;
    (0..=steps).map(|step| (at(step), sun_altitude_deg(&observer, eop, at(step)))).collect()
}
