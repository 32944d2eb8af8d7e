//! Edge of the Earth's shadow on the sky of a site, for satellites at one height.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector3;

use super::sky::SkyView;

/// Precision of the edge as an angle at the Earth's centre, radians; a metre for satellites 1000 km high.
const CLOSE_RAD: f64 = 1e-7;

/// A direction in which a satellite at the edge of the shadow receives half of the Sun's light.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ShadowEdgePoint {
    /// Azimuth from north through east, [0, 2π), radians.
    pub azimuth_rad: f64,
    /// Altitude above the horizon, radians; negative where the edge is below the horizon.
    pub altitude_rad: f64,
}

impl SkyView<'_> {
    /// Returns the edge of the Earth's shadow on the sphere of the satellites, where half of the Sun's light remains.
    /// The result is a closed line of `count` points around the axis of the shadow, points below the horizon included.
    ///
    /// The edge is nearly a circle around the axis. On each of `count` great circles through the axis it is found by
    /// bisection. The result is empty if the shadow does not reach the height of the satellites.
    #[doc(hidden)]
    pub fn shadow_edge(&self, count: usize) -> Vec<ShadowEdgePoint> {
        let to_sun = self.sun.vector().normalize();
        let aside = if to_sun.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
        let across = to_sun.cross(&aside).normalize();
        let (a, b) = (across, to_sun.cross(&across));
        let position = |around_rad: f64, from_sun_rad: f64| {
            let outwards = a * around_rad.cos() + b * around_rad.sin();
            (to_sun * from_sun_rad.cos() + outwards * from_sun_rad.sin()) * self.radius_km
        };
        let is_dark = |satellite: &Vector3<f64>| self.lit_fraction(satellite) < 0.5;
        (0..count)
            .filter_map(|step| {
                let around_rad = TAU * step as f64 / count as f64;
                if !is_dark(&position(around_rad, PI)) {
                    return None;
                }
                let (mut lit_rad, mut dark_rad) = (FRAC_PI_2, PI);
                while dark_rad - lit_rad > CLOSE_RAD {
                    let middle_rad = 0.5 * (lit_rad + dark_rad);
                    if is_dark(&position(around_rad, middle_rad)) {
                        dark_rad = middle_rad
                    } else {
                        lit_rad = middle_rad
                    }
                }
                let sight = position(around_rad, lit_rad) - self.observer.vector();
                // The axes are north, east and zenith, as in `SkyView::row`.
                let local = self.axes.transpose() * sight / sight.norm();
                Some(ShadowEdgePoint {
                    azimuth_rad: local.y.atan2(local.x).rem_euclid(TAU),
                    altitude_rad: local.z.clamp(-1.0, 1.0).asin(),
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Site;
    use crate::maps::Earth;
    use crate::photometry::{ModelLibrary, PhotometryOptions};

    /// Distance from the edge at which the light is compared, about one degree. The penumbra is some 50 km wide at the
    /// satellites, because the Sun has a diameter of 0.5 degrees.
    const ASIDE_RAD: f64 = 0.02;

    #[test]
    fn verif_light_changes_across_the_edge() {
        let library = ModelLibrary::embedded();
        let model = library.get("starlink-v1.5").unwrap();
        for earth in [Earth::Sphere, Earth::Ellipsoid(Site::by_name("rubin").unwrap())] {
            for (sun_altitude_deg, height_km) in [(-18.0, 550.0), (-25.0, 550.0), (-30.0, 1200.0), (-12.0, 340.0)] {
                let sun = (250_f64.to_radians(), f64::to_radians(sun_altitude_deg));
                let options = PhotometryOptions::default();
                let view = SkyView::new(&model, earth.clone(), height_km, sun.0, sun.1, options).unwrap();
                let edge = view.shadow_edge(72);
                assert_eq!(edge.len(), 72);
                let mut seen = 0;
                for point in edge.iter().filter(|point| point.altitude_rad > 0.05) {
                    let lit = view.at(point.azimuth_rad, point.altitude_rad).lit_fraction;
                    assert!((0.3..0.7).contains(&lit), "{sun_altitude_deg} {height_km}: {lit}");
                    // On the two sides of the edge the light is more and less than half.
                    let around: Vec<f64> = (0..12)
                        .map(|step| {
                            let (sin, cos) = (TAU * f64::from(step) / 12.0).sin_cos();
                            let altitude_rad = point.altitude_rad + ASIDE_RAD * sin;
                            view.at(point.azimuth_rad + ASIDE_RAD * cos / altitude_rad.cos(), altitude_rad).lit_fraction
                        })
                        .collect();
                    let most = around.iter().copied().fold(0.0, f64::max);
                    let least = around.iter().copied().fold(1.0, f64::min);
                    assert!(most > lit + 0.05 && least < lit - 0.05, "{sun_altitude_deg} {height_km}: {around:?}");
                    seen += 1;
                }
                assert!(seen > 5, "{sun_altitude_deg} {height_km}: {seen} points above the horizon");
            }
        }
    }

    #[test]
    fn out_of_the_shadow_there_is_no_edge() {
        let library = ModelLibrary::embedded();
        let model = library.get("starlink-v1.5").unwrap();
        let view = SkyView::new(&model, Earth::Sphere, 550.0, 0.0, 0.5, PhotometryOptions::default()).unwrap();
        // By day the edge is below the horizon only.
        assert!(view.shadow_edge(36).iter().all(|point| point.altitude_rad < 0.0));
    }
}
