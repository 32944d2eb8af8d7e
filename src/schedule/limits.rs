//! Limits on the brightness of satellites in one exposure: in magnitudes, and in surface brightness of the streak.

use crate::images::{ARCSEC_PER_RAD, Telescope, surface_brightness_mag_arcsec2};
use crate::passes::{Pass, Sky};

use super::policy::Policy;

/// Limits of a policy for one exposure. A satellite exceeds them if it is brighter than one of them.
#[derive(Copy, Clone, Debug, Default)]
pub(super) struct Limits<'a> {
    limit_mag: Option<f64>,
    surface: Option<SurfaceLimit<'a>>,
}

/// Limit of surface brightness, with the telescope and the exposure time that determine it.
#[derive(Copy, Clone, Debug)]
struct SurfaceLimit<'a> {
    limit_mag_arcsec2: f64,
    exposure_s: f64,
    telescope: &'a Telescope,
    sky: &'a Sky,
}

/// Limit for one satellite.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct SatelliteLimit {
    /// Apparent magnitude than which the satellite is brighter than a limit.
    pub limit_mag: f64,
    /// If the limit is a surface brightness: that of the streak less the magnitude of the satellite.
    pub surface_less_mag: Option<f64>,
}

impl<'a> Limits<'a> {
    /// Returns the limits for exposures of this length in a band. A limit of surface brightness needs a telescope.
    pub fn new(
        policy: &Policy,
        telescope: Option<&'a Telescope>,
        sky: &'a Sky,
        band: Option<&str>,
        exposure_s: f64,
    ) -> Self {
        let surface = policy.limit_surface_brightness.as_ref().and_then(|limit| limit.limit_in(band)).zip(telescope);
        Self {
            limit_mag: policy.limit_mag_in(band),
            surface: surface.map(|(limit_mag_arcsec2, telescope)| SurfaceLimit {
                limit_mag_arcsec2,
                exposure_s,
                telescope,
                sky,
            }),
        }
    }

    /// Returns a limit in magnitudes alone.
    #[cfg(test)]
    pub fn of_mag(limit_mag: Option<f64>) -> Self {
        Self { limit_mag, surface: None }
    }

    /// Returns the limits with another limit in magnitudes.
    pub fn with_limit_mag(self, limit_mag: Option<f64>) -> Self {
        Self { limit_mag, ..self }
    }

    /// Returns true if no limit applies.
    pub fn is_none(&self) -> bool {
        self.limit_mag.is_none() && self.surface.is_none()
    }

    /// Returns the limit for a satellite at a range with an angular speed; `None` if no limit applies.
    pub fn limit_of(&self, element_index: usize, range_km: f64, angular_rate_rad_s: f64) -> Option<SatelliteLimit> {
        let of_mag = self.limit_mag.map(|limit_mag| SatelliteLimit { limit_mag, surface_less_mag: None });
        let of_surface = self.surface.map(|SurfaceLimit { limit_mag_arcsec2, exposure_s, telescope, sky }| {
            let width_arcsec = telescope.width_arcsec(range_km, sky.model(element_index).size_m());
            let rate_arcsec_s = angular_rate_rad_s * ARCSEC_PER_RAD;
            let less_mag = surface_brightness_mag_arcsec2(0.0, width_arcsec, rate_arcsec_s, exposure_s);
            SatelliteLimit { limit_mag: limit_mag_arcsec2 - less_mag, surface_less_mag: Some(less_mag) }
        });
        // The fainter limit is exceeded first.
        of_mag.into_iter().chain(of_surface).max_by(|a, b| a.limit_mag.total_cmp(&b.limit_mag))
    }

    /// Returns the limit for the satellite of a pass; `None` if no limit applies.
    pub fn of_pass(&self, pass: &Pass) -> Option<SatelliteLimit> {
        self.limit_of(pass.element_index, pass.mid.range_km, pass.angular_rate_rad_s)
    }
}
