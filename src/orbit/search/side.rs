//! Side test: is a satellite on the same side of the Earth as the cone? Without solving Kepler's equation, it rejects
//! nine in ten of the satellites that pass the plane test.

use nalgebra::Vector3;

use super::kepler::Phase;
use super::kepler::sin_cos;

/// Largest ratio of the difference between true and mean longitude to the eccentricity, for eccentricities up to 0.9.
/// The difference is 2 e + 11/48 e³ + ... for small eccentricities.
pub(super) const SWING_PER_ECCENTRICITY: f64 = 2.5;

/// Error of the series for sine and cosine plus that of single precision, radians.
const ROUGHNESS_RAD: f64 = 3e-3;

/// Largest deficit of the length of the interpolated normal from 1.
const SHORTNESS: f64 = 1e-4;

/// Angle, radians, beyond which a cap, enlarged by the satellite's motion, counts as the whole sphere.
const EVERYWHERE_RAD: f64 = 3.0;

/// Cap, seen from the Earth's centre, that contains the part of a cone inside a shell of orbits.
#[derive(Copy, Clone)]
pub(super) struct Cap {
    centre: Vector3<f64>,
    radius_rad: f64,
    lowest_km: f64,
}

impl Cap {
    /// Returns the cap of the part of a cone between two distances from the observer, for orbits no lower than
    /// `lowest_km` from the Earth's centre. The axis of the cone is a unit vector. `None` if the cap may be the whole
    /// sphere.
    pub fn from_cone(
        observer: &Vector3<f64>,
        axis: &Vector3<f64>,
        radius_rad: f64,
        distances_km: [f64; 2],
        lowest_km: f64,
    ) -> Option<Self> {
        let along = Self::along(observer, axis, radius_rad, distances_km, lowest_km);
        along.or_else(|| Self::about(observer, distances_km[1], lowest_km))
    }

    /// Returns the cap of all positions within `far_km` of the observer, for very wide cones.
    fn about(observer: &Vector3<f64>, far_km: f64, lowest_km: f64) -> Option<Self> {
        let height_km = observer.norm();
        // cos ψ = (r² + R² - ρ²) / 2rR is smallest at the largest ρ, at r = √(R² - ρ²) or at the lowest radius if that
        // is larger.
        let radius_km = lowest_km.max((height_km * height_km - far_km * far_km).max(0.0).sqrt());
        let cosine = (radius_km * radius_km + height_km * height_km - far_km * far_km) / (2.0 * radius_km * height_km);
        // For NaN the result is `None`.
        (cosine > -1.0).then(|| Self { centre: observer / height_km, radius_rad: cosine.min(1.0).acos(), lowest_km })
    }

    /// Returns the cap of a cone whose axis is a unit vector; `None` if the cone is too wide for this bound.
    fn along(
        observer: &Vector3<f64>,
        axis: &Vector3<f64>,
        radius_rad: f64,
        [near_km, far_km]: [f64; 2],
        lowest_km: f64,
    ) -> Option<Self> {
        // Largest width of the cone across its axis.
        let width_km = 2.0 * far_km * radius_rad.tan();
        if !(radius_rad < 0.5 && width_km < 0.5 * lowest_km) {
            return None;
        }
        // Seen from the Earth's centre, the points of the axis lie in order on one great circle.
        let [first, last] = [near_km, far_km].map(|distance_km| (observer + axis * distance_km).normalize());
        let middle = first + last;
        let length = middle.norm();
        // Largest angle, seen from the Earth's centre, between a point of the cone and the axis.
        let apart_rad = (width_km / (lowest_km - width_km)).min(1.0).asin();
        (length > 1.0).then(|| Self {
            centre: middle / length,
            radius_rad: (0.5 * length).min(1.0).acos() + apart_rad,
            lowest_km,
        })
    }

    /// Returns true if a satellite may be in the direction of the cap within `half_s` of a time of the window; its
    /// position error is at most `slop_km`.
    #[inline]
    pub fn may_hold(&self, phase: &Phase, normal: &Vector3<f64>, time_s: f64, half_s: f64, slop_km: f64) -> bool {
        let within_rad = self.radius_rad
            + f64::from(phase.swing_rad)
            + phase.mean_longitude_rate_rad_s.abs() * half_s
            + 1.1 * slop_km / self.lowest_km
            + ROUGHNESS_RAD;
        // Either the cap is the whole sphere, or the position error is too large for the small-angle bound below.
        if within_rad > EVERYWHERE_RAD || slop_km > 0.3 * self.lowest_km {
            return true;
        }
        // x = r - (r·n) n and y = n × r are the axes of the orbit plane, as in `kepler`. With the mean longitude λ and
        // the centre c of the cap, cos λ x·c + sin λ y·c is the cosine of the angle between the satellite and the
        // centre.
        let [rx, ry, rz] = phase.reference;
        let reference = Vector3::new(f64::from(rx), f64::from(ry), f64::from(rz));
        let off_plane = reference.dot(normal);
        let x = reference.dot(&self.centre) - off_plane * normal.dot(&self.centre);
        let y = normal.cross(&reference).dot(&self.centre);
        let (sin, cos) = sin_cos(phase.mean_longitude_rad + phase.mean_longitude_rate_rad_s * time_s);
        // The reference vector turns out of the plane by a degree or two. Both axes, and with them the cosine, are
        // therefore too short by the factor √(1 - (r·n)²).
        let cosine = sin_cos(within_rad).1 - off_plane * off_plane - SHORTNESS;
        let along = cos * x + sin * y;
        // A NaN passes the test.
        along >= cosine || along.is_nan()
    }
}

#[cfg(test)]
mod tests {
    use super::super::kepler::plane_state;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn verif_longitudes_swing_no_farther_than_they_may() {
        for eccentricity in [1e-4, 0.01, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9] {
            let swing = (0..2000)
                .map(|step| {
                    let mean_rad = f64::from(step) * std::f64::consts::TAU / 2000.0;
                    let ([x, y], _) = plane_state(mean_rad, [eccentricity, 0.0], 7000.0);
                    let off_rad = y.atan2(x) - mean_rad;
                    off_rad.sin().atan2(off_rad.cos()).abs()
                })
                .fold(0.0, f64::max);
            assert!(swing < SWING_PER_ECCENTRICITY * eccentricity + 1e-4, "{eccentricity}: {swing}");
        }
    }

    proptest! {
        /// No position within a cone and a shell lies outside their cap.
        #[test]
        fn verif_caps_contain_their_cones(
            zenith_rad in 0.0..1.6_f64,
            radius_rad in 0.001..1.5_f64,
            (first, second) in (0.0..1.0_f64, 0.0..1.0_f64),
            (depth, off, around) in (0.0..1.0_f64, 0.0..1.0_f64, 0.0..6.3_f64),
        ) {
            let observer = Vector3::new(0.0, 0.0, 6378.0);
            let axis = Vector3::new(zenith_rad.sin(), 0.0, zenith_rad.cos());
            let (near_km, far_km) = (400.0 + 3000.0 * first.min(second), 400.0 + 3000.0 * first.max(second));
            let off_rad = off * radius_rad;
            let across = Vector3::y() * around.cos() + axis.cross(&Vector3::y()) * around.sin();
            let position = observer
                + (axis * off_rad.cos() + across * off_rad.sin()) * (near_km + depth * (far_km - near_km));
            let lowest_km = position.norm().min(6800.0);
            if let Some(cap) = Cap::from_cone(&observer, &axis, radius_rad, [near_km, far_km], lowest_km) {
                let angle_rad = cap.centre.cross(&position).norm().atan2(cap.centre.dot(&position));
                prop_assert!(angle_rad <= cap.radius_rad, "{angle_rad} {}", cap.radius_rad);
            }
        }
    }
}
