//! When a site is dark.

use hifitime::{Epoch, TimeScale};

use crate::frames::{seconds_after, seconds_between};
use crate::geometry::SunTable;
use crate::output::format_utc;
use crate::passes::{Sky, SkyError, intervals_where};

/// The Sun is looked at in steps of this, seconds: a quarter of a degree.
const STEP_S: f64 = 60.0;

/// A stretch of time at a site, and when the Sun is low enough in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Night {
    /// First moment.
    pub start: Epoch,
    /// Last moment.
    pub end: Epoch,
    /// What the Sun's altitude must be below, radians; `None` where it does not matter.
    pub max_sun_altitude_rad: Option<f64>,
    /// When it is, in order of time.
    pub dark: Vec<(Epoch, Epoch)>,
    /// The lowest altitude of the Sun's centre, radians, without refraction.
    pub lowest_sun_rad: f64,
    /// When that is.
    pub lowest_sun_at: Epoch,
}

impl Night {
    /// The Sun from `start` to `end` (not before it) as seen from the sky's site.
    ///
    /// # Errors
    /// [`SkyError::NoHorizon`] for an observer in orbit.
    pub fn over(sky: &Sky, start: Epoch, end: Epoch, max_sun_altitude_rad: Option<f64>) -> Result<Self, SkyError> {
        let observer =
            sky.viewpoint().site().ok_or_else(|| SkyError::NoHorizon { observer: sky.viewpoint().name() })?;
        let (orientation, sun) = (sky.orientation_over(start, end), SunTable::new(start, end));
        let span_s = seconds_between(start, end).max(0.0);
        let altitude_rad = |time_s: f64| {
            let here = observer.state(&orientation.at_s(time_s));
            here.sine_of_altitude(&(sun.at_s(time_s).sun - here.position)).asin()
        };
        let steps = (span_s / STEP_S).ceil().max(1.0) as usize;
        let (lowest_s, lowest_sun_rad) = (0..=steps)
            .map(|step| span_s * step as f64 / steps as f64)
            .map(|time_s| (time_s, altitude_rad(time_s)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0.0, f64::NAN));
        let moment = |time_s: f64| seconds_after(start, time_s).to_time_scale(TimeScale::UTC);
        let dark = match max_sun_altitude_rad {
            Some(limit_rad) => intervals_where(0.0, span_s, steps, |time_s| altitude_rad(time_s) < limit_rad)
                .into_iter()
                .map(|(from_s, until_s)| (moment(from_s), moment(until_s)))
                .collect(),
            None => vec![(start, end)],
        };
        Ok(Self { start, end, max_sun_altitude_rad, dark, lowest_sun_rad, lowest_sun_at: moment(lowest_s) })
    }

    /// How long it is dark, seconds.
    pub fn dark_s(&self) -> f64 {
        self.dark.iter().map(|(from, until)| seconds_between(*from, *until)).sum()
    }

    /// In words, why it is never dark; `None` where it is.
    pub fn why_never_dark(&self, site: &str) -> Option<String> {
        let limit_rad = self.max_sun_altitude_rad.filter(|_| self.dark.is_empty())?;
        Some(format!(
            "it does not get dark at {site} between {} and {}: the Sun sinks to {:.1} deg at the lowest ({}), and {:.1} deg was asked for",
            format_utc(self.start, 0),
            format_utc(self.end, 0),
            self.lowest_sun_rad.to_degrees(),
            format_utc(self.lowest_sun_at, 0),
            limit_rad.to_degrees(),
        ))
    }
}
