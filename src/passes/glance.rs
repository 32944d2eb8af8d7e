//! Who stands over a site at one moment: the whole catalogue at a glance, for averages over thousands of moments. Tracks over a stretch of time, with
//! all that is told of a point, are of [`Sky::overhead`].

use hifitime::Epoch;

use super::sky::{Sky, SkyError};
use crate::geometry::{Illumination, ViewingGeometry};
use crate::orbit::LeftOut;
use crate::photometry::{Brightness, PhotometryOptions};

/// One satellite above a site's horizon at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Glance {
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// Altitude without refraction, radians.
    pub altitude_rad: f64,
    /// Azimuth from north through east, [0, 2π), radians.
    pub azimuth_rad: f64,
    /// Distance, km.
    pub range_km: f64,
    /// Speed among the stars, rad/s.
    pub angular_rate_rad_s: f64,
    /// Sunlit, in penumbra or in umbra.
    pub illumination: Illumination,
    /// Its light; `None` in the umbra and where a model sees nothing. The sigma is that of the model alone, without the error of the elements.
    pub brightness: Option<Brightness>,
}

impl Glance {
    /// True where any part of the Sun reaches it.
    pub fn is_lit(&self) -> bool {
        self.illumination != Illumination::Umbra
    }
}

impl Sky {
    /// All satellites above an altitude at a moment, in the catalogue's order, and those without a position; on all threads.
    ///
    /// # Errors
    /// [`SkyError::NoEphemeris`] outside the years of the Sun's ephemeris; [`SkyError::NoHorizon`] for an observer in orbit.
    pub fn glance(
        &self,
        epoch: Epoch,
        min_altitude_rad: f64,
        photometry: &PhotometryOptions,
    ) -> Result<(Vec<Glance>, Vec<LeftOut>), SkyError> {
        super::sky::check_epoch(epoch)?;
        let observer = self.site_observer()?;
        let scene = self.scene_without_windows(epoch, 0.0);
        let (orientation, sun) = (scene.orientation.at_s(0.0), scene.sun.at_s(0.0).sun);
        let here = observer.state(&orientation);
        let limit = min_altitude_rad.sin();
        let (found, left_out) = self.survey(
            |_| true,
            |element_index, propagator, found| {
                let minutes = propagator.minutes_since_epoch(epoch);
                let state = propagator.state_at_minutes(minutes, &orientation.teme_to_gcrs)?;
                let away = state.position - here.position;
                if here.sine_of_altitude(&away) < limit {
                    return Ok(());
                }
                let geometry = ViewingGeometry::new(&state.position, &here.position, &sun);
                let place = geometry.zip(here.altitude_azimuth_rad(&away));
                found.extend(place.map(|(geometry, (altitude_rad, azimuth_rad))| {
                    let illumination = self.shadow().illumination(&state.position, &sun);
                    let (sight, moving) = (away.vector(), state.velocity.vector() - here.velocity.vector());
                    Glance {
                        element_index,
                        altitude_rad,
                        azimuth_rad,
                        range_km: geometry.range_km,
                        // ω = |r × v| / r²
                        angular_rate_rad_s: sight.cross(&moving).norm() / sight.norm_squared(),
                        illumination,
                        brightness: self.model(element_index).brightness(
                            &geometry,
                            illumination.lit_fraction(),
                            photometry,
                        ),
                    }
                }));
                Ok(())
            },
        );
        Ok((found, left_out))
    }
}
