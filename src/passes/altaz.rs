//! Altitude and azimuth of the Sun and of a pointing.

use hifitime::Epoch;

use super::error;
use super::error::check_epoch;
use super::sky::Sky;
use crate::error::Error;
use crate::frames::{Direction, Gcrs, seconds_after};

/// Altitude and azimuth at a site.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AltAz {
    /// Altitude above the horizon, geometric, radians.
    pub altitude_rad: f64,
    /// Azimuth from north through east, [0, 2π), radians.
    pub azimuth_rad: f64,
}

impl Sky {
    /// Computes altitude and azimuth of the Sun's centre, without refraction and without aberration (20").
    ///
    /// # Errors
    /// The observer is in orbit, or the time is outside the years of the Sun's ephemeris.
    #[doc(hidden)]
    pub fn sun_altaz(&self, epoch: Epoch) -> Result<AltAz, Error> {
        check_epoch(epoch)?;
        let scene = self.scene_without_windows(epoch, 0.0);
        let here = self.site_observer()?.state(&scene.orientation.at_s(0.0));
        let altaz = here.altitude_azimuth_rad(&(scene.sun.at_s(0.0).sun - here.position));
        let (altitude_rad, azimuth_rad) = altaz.ok_or_else(|| error::no_ephemeris(epoch))?;
        Ok(AltAz { altitude_rad, azimuth_rad })
    }

    /// Returns the first time, within a day after `from`, at which the Sun's centre is at an altitude; `None` if it
    /// does not reach this altitude.
    ///
    /// # Errors
    /// The errors of [`Sky::sun_altaz`].
    pub fn sun_reaches(&self, altitude_rad: f64, from: Epoch) -> Result<Option<Epoch>, Error> {
        /// Search step, seconds. In one step the Sun moves by at most 2.5°. It can cross the same altitude twice in a
        /// step only near noon and midnight, where its altitude hardly changes.
        const STEP_S: f64 = 600.0;
        /// Tolerance, seconds; the Sun moves by half a thousandth of a degree in this time.
        const CLOSE_S: f64 = 0.1;
        let above = |seconds: f64| -> Result<f64, Error> {
            Ok(self.sun_altaz(seconds_after(from, seconds))?.altitude_rad - altitude_rad)
        };
        let mut low_s = 0.0;
        let mut low = above(low_s)?;
        while low_s < crate::constants::DAY_S {
            let mut high_s = low_s + STEP_S;
            let high = above(high_s)?;
            if low == 0.0 {
                return Ok(Some(seconds_after(from, low_s)));
            }
            if low * high < 0.0 {
                while high_s - low_s > CLOSE_S {
                    let middle_s = (low_s + high_s) / 2.0;
                    if above(middle_s)? * low > 0.0 { low_s = middle_s } else { high_s = middle_s }
                }
                return Ok(Some(seconds_after(from, (low_s + high_s) / 2.0)));
            }
            (low_s, low) = (high_s, high);
        }
        Ok(None)
    }

    /// Computes altitude and azimuth of a pointing, without refraction and without aberration (25" at most).
    ///
    /// # Errors
    /// The errors of [`Sky::sun_altaz`].
    #[doc(hidden)]
    pub fn pointing_altaz(&self, pointing: &Direction<Gcrs>, epoch: Epoch) -> Result<AltAz, Error> {
        check_epoch(epoch)?;
        let orientation = self.orientation_over(epoch, epoch).at_s(0.0);
        let direction = self.site_observer()?.state(&orientation).horizon * *pointing;
        Ok(AltAz { altitude_rad: direction.latitude_rad(), azimuth_rad: direction.longitude_rad() })
    }
}
