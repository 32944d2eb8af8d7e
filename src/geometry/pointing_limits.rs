//! Limits on the pointing of a telescope in orbit: angles from its zenith, from the Sun and from the Earth's limb.

use super::limb::EarthLimb;
use crate::frames::{Direction, Gcrs, Position};

/// Angles of a pointing of a telescope in orbit, radians. Aberration (26" at most) is neglected.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PointingAngles {
    /// Angle from the zenith, the direction from the Earth's centre to the telescope, in [0, π]. The normal of the
    /// ellipsoid differs from it by at most 0.19°.
    pub zenith_rad: f64,
    /// Angle from the centre of the Sun, in [0, π].
    pub sun_rad: f64,
    /// Angle from the Earth's limb, of [`EarthLimb::altitude_rad`]: negative for a line of sight that meets the Earth.
    pub limb_rad: f64,
}

impl PointingAngles {
    /// Computes the angles from the geocentric positions of telescope and Sun.
    pub fn new(pointing: &Direction<Gcrs>, telescope: &Position<Gcrs>, sun: &Position<Gcrs>, limb: &EarthLimb) -> Self {
        let from = |direction: Option<Direction<Gcrs>>| {
            direction.map_or(f64::NAN, |direction| direction.separation_rad(pointing))
        };
        Self {
            zenith_rad: from(telescope.direction()),
            sun_rad: from((*sun - *telescope).direction()),
            limb_rad: limb.altitude_rad(telescope, pointing),
        }
    }
}

/// Limits on the pointing of a telescope in orbit, radians; `None` for no limit. An angle equal to its limit is
/// allowed.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct PointingLimits {
    /// Largest angle from the zenith.
    pub max_zenith_angle_rad: Option<f64>,
    /// Smallest angle from the centre of the Sun.
    pub min_sun_angle_rad: Option<f64>,
    /// Smallest angle from the Earth's limb.
    pub min_limb_angle_rad: Option<f64>,
}

impl PointingLimits {
    /// Returns true if there is no limit.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the smallest margin of the angles from a limit, radians: negative if a limit is broken, infinite without
    /// limits.
    pub fn margin_rad(&self, angles: &PointingAngles) -> f64 {
        self.margins(angles).iter().map(|(margin_rad, ..)| *margin_rad).fold(f64::INFINITY, f64::min)
    }

    /// Returns the description of the limit that is broken by the largest angle, with the angle and the allowed ones;
    /// `None` if none is broken.
    pub fn broken(&self, angles: &PointingAngles) -> Option<String> {
        let (margin_rad, angle_rad, limit_rad, [of, bound]) =
            self.margins(angles).into_iter().min_by(|first, other| first.0.total_cmp(&other.0))?;
        let [angle_deg, limit_deg] = [angle_rad, limit_rad].map(f64::to_degrees);
        // An angle that rounds to the limit is shown with the digits by which it differs.
        let decimals = (1..9).find(|&digits| format!("{angle_deg:.digits$}") != format!("{limit_deg:.digits$}"));
        let digits = decimals.unwrap_or(9);
        let limit_deg = (limit_deg * 1e9).round() / 1e9;
        (margin_rad < 0.0)
            .then(|| format!("the pointing is {angle_deg:.digits$} deg from {of}; allowed: {limit_deg} deg or {bound}"))
    }

    /// Returns for each limit the margin, the angle, the limit, and names for messages.
    fn margins(&self, angles: &PointingAngles) -> Vec<(f64, f64, f64, [&'static str; 2])> {
        let most = |limit: Option<f64>, angle: f64, of| limit.map(|limit| (limit - angle, angle, limit, [of, "less"]));
        let least = |limit: Option<f64>, angle: f64, of| limit.map(|limit| (angle - limit, angle, limit, [of, "more"]));
        [
            most(self.max_zenith_angle_rad, angles.zenith_rad, "the zenith of the telescope"),
            least(self.min_sun_angle_rad, angles.sun_rad, "the Sun"),
            least(self.min_limb_angle_rad, angles.limb_rad, "the Earth's limb"),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::AU_KM;

    /// Telescope on the equator at a height of 550 km, Sun 90° ahead.
    fn angles(from_zenith_deg: f64) -> PointingAngles {
        let telescope = Position::new(6928.137, 0.0, 0.0);
        let pointing = Direction::from_lon_lat_rad(from_zenith_deg.to_radians(), 0.0);
        PointingAngles::new(&pointing, &telescope, &Position::new(0.0, AU_KM, 0.0), &EarthLimb::default())
    }

    /// Computed by hand: the limb is asin(6378.137 / 6928.137) = 67.016° from the nadir, 112.984° from the zenith. The
    /// parallax of the Sun is 6928 km / 1 au = 0.0027°.
    #[test]
    fn angles_by_hand() {
        for (from_zenith_deg, sun_deg, limb_deg) in [(0.0, 90.0, 112.984), (80.0, 10.0, 32.984), (120.0, 30.0, -7.016)]
        {
            let found = angles(from_zenith_deg);
            assert!((found.zenith_rad.to_degrees() - from_zenith_deg).abs() < 1e-9);
            assert!((found.sun_rad.to_degrees() - sun_deg).abs() < 0.003, "{found:?}");
            assert!((found.limb_rad.to_degrees() - limb_deg).abs() < 0.001, "{found:?}");
        }
    }

    #[test]
    fn a_broken_limit_is_described() {
        let limit = |zenith: Option<f64>, sun: Option<f64>, limb: Option<f64>| PointingLimits {
            max_zenith_angle_rad: zenith.map(f64::to_radians),
            min_sun_angle_rad: sun.map(f64::to_radians),
            min_limb_angle_rad: limb.map(f64::to_radians),
        };
        let at = angles(80.0);
        assert_eq!(PointingLimits::default().margin_rad(&at), f64::INFINITY);
        assert_eq!(PointingLimits::default().broken(&at), None);
        for (limits, expected) in [
            (limit(Some(81.0), Some(9.0), Some(32.0)), None),
            (limit(Some(35.0), None, None), Some("80.0 deg from the zenith of the telescope; allowed: 35 deg or less")),
            (limit(None, Some(91.0), None), Some("10.0 deg from the Sun; allowed: 91 deg or more")),
            (limit(None, None, Some(33.0)), Some("32.98 deg from the Earth's limb; allowed: 33 deg or more")),
            // Two are broken: the one that is missed by more is stated.
            (limit(Some(79.0), Some(91.0), None), Some("10.0 deg from the Sun; allowed: 91 deg or more")),
        ] {
            assert_eq!(limits.broken(&at), expected.map(|text| format!("the pointing is {text}")));
            assert_eq!(limits.margin_rad(&at) < 0.0, expected.is_some());
        }
    }
}
