//! Light of a satellite in directions that its fitted panels do not describe: with the Sun or the observer above the
//! plane of its horizon. Models of panels are fitted to photometry from the ground, which sees the lower side in
//! twilight, and have few or no panels on the upper side. Such a satellite is not dark: it is taken as a diffuse body.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::phase::linear_phase_law;
use crate::frames::{Body, Direction};
use crate::geometry::ViewingGeometry;
use crate::math::quantile::median;

/// Uncertainty (one sigma) of magnitudes far outside the fitted geometry, mag: that of different payloads at one
/// standard magnitude of the list qs.mag (68 % are within 1.5 mag).
pub(super) const DIFFUSE_SIGMA_MAG: f64 = 1.5;

/// Angle above which the diffuse body counts fully, radians: that of the Sun above its largest fitted latitude, or of
/// the observer above the plane of the satellite's horizon. For smaller angles its light is proportional to them.
const FULL_RAD: f64 = 5.0 * PI / 180.0;

/// Least share of the light of the diffuse body, 5 mag fainter. Assumed: panels alone may reflect nothing, as no
/// satellite does.
const LEAST_SHARE: f64 = 0.01;

/// Numbers of latitudes of Sun and observer, and of longitudes of the observer, for the median over the fitted range.
const LATITUDES: usize = 4;
const LONGITUDES: usize = 8;

/// Ranges of the latitude of the Sun and of the observer above the plane of the satellite's horizon, and of the phase
/// angle, each as [least, greatest], radians.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Ranges {
    pub sun_latitude_rad: [f64; 2],
    pub observer_latitude_rad: [f64; 2],
    pub phase_rad: [f64; 2],
}

impl Ranges {
    /// Geometry of observers on the ground at night: Sun and observer are below the plane.
    pub const FROM_THE_GROUND: Self =
        Self { sun_latitude_rad: [-FRAC_PI_2, 0.0], observer_latitude_rad: [-FRAC_PI_2, 0.0], phase_rad: [0.0, PI] };
}

/// Diffuse body with the linear phase law, which has the median brightness of a model of panels in its fitted range.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct DiffuseBody {
    /// Reflection at a phase angle of 90°, m² sr⁻¹.
    half_lit_m2_sr: f64,
    /// Largest latitude of the Sun in the fitted range, radians.
    sun_latitude_rad: f64,
}

impl DiffuseBody {
    /// Returns the body for panels with a reflection (m² sr⁻¹) that depends on the directions to Sun and observer;
    /// `None` if they reflect nothing in these ranges.
    pub fn new(panels_m2_sr: impl Fn(&Direction<Body>, &Direction<Body>) -> f64, ranges: &Ranges) -> Option<Self> {
        let latitudes = |[from, to]: [f64; 2]| {
            (0..LATITUDES).map(move |index| from + (to - from) * (index as f64 + 0.5) / LATITUDES as f64)
        };
        let mut ratios = Vec::new();
        for sun in latitudes(ranges.sun_latitude_rad) {
            let to_sun = Direction::from_lon_lat_rad(0.0, sun);
            for observer in latitudes(ranges.observer_latitude_rad) {
                for index in 0..LONGITUDES {
                    let longitude = TAU * (index as f64 + 0.5) / LONGITUDES as f64;
                    let to_observer = Direction::from_lon_lat_rad(longitude, observer);
                    let phase_rad = to_sun.separation_rad(&to_observer);
                    let [least, greatest] = ranges.phase_rad;
                    if (least..=greatest).contains(&phase_rad) {
                        ratios.push(panels_m2_sr(&to_sun, &to_observer) / linear_phase_law(phase_rad));
                    }
                }
            }
        }
        ratios.retain(|ratio| *ratio > 0.0 && ratio.is_finite());
        (!ratios.is_empty())
            .then(|| Self { half_lit_m2_sr: median(ratios), sun_latitude_rad: ranges.sun_latitude_rad[1] })
    }

    /// Returns the reflection that is at least to be expected in a geometry, m² sr⁻¹: 1 % of that of the diffuse body
    /// with the Sun below its largest fitted latitude and the observer below the plane of the satellite's horizon.
    pub fn reflection_m2_sr(&self, geometry: &ViewingGeometry) -> f64 {
        let above_rad = (geometry.sun_latitude_rad - self.sun_latitude_rad).max(geometry.observer_latitude_rad);
        let share = (above_rad / FULL_RAD).clamp(LEAST_SHARE, 1.0);
        // B = s B(90°) 2 (1 - φ/180°)
        share * self.half_lit_m2_sr * linear_phase_law(geometry.phase_angle_rad())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn geometry(sun_deg: f64, observer_deg: f64) -> ViewingGeometry {
        let [sun_latitude_rad, observer_latitude_rad] = [sun_deg, observer_deg].map(f64::to_radians);
        ViewingGeometry {
            sun_latitude_rad,
            observer_latitude_rad,
            observer_longitude_rad: 1.0,
            range_km: 1000.0,
            height_km: 550.0,
            sun_distance_au: 1.0,
        }
    }

    #[test]
    fn the_body_has_the_median_of_the_panels_and_counts_above_the_plane() {
        let ranges = Ranges { sun_latitude_rad: [-0.4, (-5_f64).to_radians()], ..Ranges::FROM_THE_GROUND };
        // Panels that follow the linear phase law.
        let panels =
            |sun: &Direction<Body>, observer: &Direction<Body>| 0.3 * linear_phase_law(sun.separation_rad(observer));
        let body = DiffuseBody::new(panels, &ranges).unwrap();
        assert!((body.half_lit_m2_sr - 0.3).abs() < 1e-12);
        let share = |sun_deg: f64, observer_deg: f64| {
            let geometry = geometry(sun_deg, observer_deg);
            body.reflection_m2_sr(&geometry) / (0.3 * linear_phase_law(geometry.phase_angle_rad()))
        };
        for (sun_deg, observer_deg, expected) in [
            (-6.0, -40.0, 0.01),
            (-2.5, -40.0, 0.5),
            (0.0, -40.0, 1.0),
            (20.0, -40.0, 1.0),
            (-20.0, 1.0, 0.2),
            (-20.0, 30.0, 1.0),
        ] {
            let found = share(sun_deg, observer_deg);
            assert!((found - expected).abs() < 1e-12, "{sun_deg} {observer_deg}: {found}");
        }
        assert_eq!(DiffuseBody::new(|_, _| 0.0, &ranges), None);
    }
}
