//! Local time and altitude of the Sun at a site.

use hifitime::Epoch;
use streakcast::frames::{EopTable, Orientation};
use streakcast::geometry::{Observer, Site};
use streakcast::plot::LocalClock;

use crate::local_time::LocalTime;

/// Interval between two computed positions of the Sun, days. The Sun's altitude changes by at most 1.25° in this time;
/// linear interpolation is accurate to a few hundredths of a degree.
const STEP_DAYS: f64 = 5.0 / 1440.0;

/// Local time of the upper axis.
pub enum Clock {
    /// Local time of a time zone.
    Zone(LocalTime),
    /// Mean solar time, hours ahead of UTC.
    MeanSolar(f64),
}

impl Clock {
    /// Returns the local time of the given zone, or else the mean solar time of a site; `None` if neither is given.
    pub fn new(zone: Option<LocalTime>, site: Option<&Site>) -> Option<Self> {
        // The mean Sun moves by 15° per hour.
        let mean_solar = |site: &Site| Self::MeanSolar(site.longitude_rad.to_degrees() / 15.0);
        zone.map(Self::Zone).or_else(|| site.map(mean_solar))
    }

    /// Returns the clock for a plot that begins at a time (MJD, UTC).
    pub fn at(&self, mjd: f64) -> LocalClock {
        match self {
            Self::Zone(zone) => {
                let hours = zone.ahead_of_utc_h(Epoch::from_mjd_utc(mjd));
                let sign = if hours < 0.0 { '−' } else { '+' };
                let minutes = (hours.abs() * 60.0).round() as u32;
                let rest = if minutes.is_multiple_of(60) { String::new() } else { format!(":{:02}", minutes % 60) };
                LocalClock { ahead_of_utc_h: hours, name: format!("local time (UTC{sign}{}{rest})", minutes / 60) }
            }
            Self::MeanSolar(hours) => LocalClock { ahead_of_utc_h: *hours, name: "local mean solar time".to_owned() },
        }
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
