//! The limits of a telescope's file, made comparable with the passes of a sky.

use crate::images::{ARCSEC_PER_RAD, Telescope};
use crate::passes::{FieldPass, Sky};
use crate::photometry::{Band, PhotometryOptions};

use super::judge::{CameraLimits, LimitKind};

/// A telescope and what its passes were predicted with.
pub(super) struct Camera<'a> {
    pub telescope: &'a Telescope,
    pub sky: &'a Sky,
    pub photometry: &'a PhotometryOptions,
}

impl CameraLimits for Camera<'_> {
    fn limit_mag(&self, kind: LimitKind, band: Option<&str>) -> Option<f64> {
        kind.limit_mag(self.telescope, band?)
    }

    fn as_at_550_km_mag(&self, pass: &FieldPass, magnitude: f64, band: Option<&str>) -> f64 {
        // Through the Sun's colour, as every other band: satellites are taken as grey.
        let colour = band.and_then(|band| band.parse::<Band>().ok()).map_or(0.0, |band| {
            band.sun_magnitude(band.usual_system()) - self.photometry.band.sun_magnitude(self.photometry.system)
        });
        self.telescope.as_at_550_km_mag(
            magnitude + colour,
            pass.mid.range_km,
            pass.angular_rate_rad_s * ARCSEC_PER_RAD,
            self.sky.model(pass.element_index).size_m(),
        )
    }
}
