//! Angles of a pointing from zenith, Sun and limb of a telescope in orbit while the shutter is open, and its limits.

use super::error;
use super::exposure::Exposure;
use super::sky::Sky;
use crate::error::Error;
use crate::frames::{seconds_after, seconds_between};
use crate::geometry::PointingAngles;

/// Sampling interval of the angles, seconds. From a low orbit the zenith moves by up to 0.7° in this time.
const INTERVAL_S: f64 = 10.0;

impl Sky {
    /// Returns the angles of the pointing of an exposure, at opening, at closing and, in between, at intervals of at
    /// most 10 s; none for a site.
    ///
    /// # Errors
    /// The position of the telescope cannot be computed.
    #[doc(hidden)]
    pub fn pointing_angles(&self, exposure: &Exposure) -> Result<Vec<PointingAngles>, Error> {
        let Some(observer) = self.viewpoint().orbit() else { return Ok(Vec::new()) };
        let end = seconds_after(exposure.start, exposure.duration_s);
        let (orientation, sun) = self.almanac_over(exposure.start, end);
        let after_s = seconds_between(orientation.reference(), exposure.start);
        let steps = (exposure.duration_s / INTERVAL_S).ceil().max(1.0);
        let at = |step: usize| {
            let time_s = after_s + exposure.duration_s * step as f64 / steps;
            let epoch = seconds_after(orientation.reference(), time_s);
            observer.pointing_angles(&exposure.pointing, epoch, &orientation.at_s(time_s), &sun.at_s(time_s).sun)
        };
        let failed = |reason| error::no_observer(&observer.name(), &reason);
        (0..=steps as usize).map(|step| at(step).map_err(failed)).collect()
    }

    /// Returns the description of the limit of a telescope in orbit that an exposure breaks by most, with the angle and
    /// the allowed ones; `None` if it breaks none.
    ///
    /// # Errors
    /// Same as [`Sky::pointing_angles`].
    #[doc(hidden)]
    pub fn broken_limit(&self, exposure: &Exposure) -> Result<Option<String>, Error> {
        let Some(observer) = self.viewpoint().orbit().filter(|observer| !observer.limits().is_empty()) else {
            return Ok(None);
        };
        let limits = observer.limits();
        let angles = self.pointing_angles(exposure)?;
        let worst = angles.iter().min_by(|first, other| limits.margin_rad(first).total_cmp(&limits.margin_rad(other)));
        Ok(worst.and_then(|angles| limits.broken(angles)))
    }
}
