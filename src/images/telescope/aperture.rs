//! What is known of a telescope and its camera, and how wide it makes a streak.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::streak::{ARCSEC_PER_RAD, expected_lost_pixel_fraction};

/// Speed on the sky of a satellite 550 km overhead, arcsec/s: √(μ / (R + h)) / h.
const RATE_AT_550_KM_ARCSEC_S: f64 = 2844.7;

/// A telescope with its camera. Made by [`Telescope::by_name`] or from a TOML file with these same keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Telescope {
    /// Lower-case letters, digits, `.` and `-`.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// Radius of the light-collecting aperture, m.
    pub outer_radius_m: f64,
    /// Radius of the central obstruction, m; 0 where there is none or none is published.
    pub inner_radius_m: f64,
    /// Typical width (FWHM) of a star's image from air and optics, arcsec.
    pub seeing_arcsec: f64,
    /// Side of a pixel on the sky, arcsec.
    pub pixel_scale_arcsec: f64,
    /// The field that is taken where none is given.
    pub field: FieldOfView,
    /// How many streak widths wide a mask must be. Two hold 98 % of the light of a Gaussian profile whose FWHM is
    /// the width.
    #[serde(default = "default_mask_widths")]
    pub mask_widths: f64,
    /// Brightest streaks that the detector bears, by band name. They make verdicts where a policy says `"telescope"`.
    #[serde(default)]
    pub limits: BTreeMap<String, BandLimits>,
    /// Where these numbers come from.
    pub source: String,
}

/// The usual masked width in streak widths.
fn default_mask_widths() -> f64 {
    2.0
}

/// Magnitudes that a satellite must be fainter than; those of a satellite standing still at 550 km overhead for
/// streaks.
#[derive(Copy, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandLimits {
    /// A moving satellite brighter than this saturates the pixels of its trail.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trail_saturation_mag: Option<f64>,
    /// A moving satellite brighter than this leaves crosstalk that cannot be corrected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crosstalk_mag: Option<f64>,
}

/// The part of the sky that an exposure sees; on the tangent plane, x to the east, y to the north, degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FieldOfView {
    /// A circle of this full diameter.
    CircleDeg(f64),
    /// A rectangle of this width and height about the centre.
    RectangleDeg([f64; 2]),
    /// An outline of three or more corners in order.
    PolygonDeg(Vec<[f64; 2]>),
}

impl FieldOfView {
    /// Area, square degrees, on the tangent plane.
    pub fn area_deg2(&self) -> f64 {
        match self {
            Self::CircleDeg(diameter) => std::f64::consts::FRAC_PI_4 * diameter * diameter,
            Self::RectangleDeg([width, height]) => width * height,
            Self::PolygonDeg(corners) => {
                let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
                0.5 * pairs.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs()
            }
        }
    }
}

impl Telescope {
    /// Diameter of the out-of-focus disk of a point at `range_km`, arcsec, from rim to rim.
    pub fn defocus_outer_arcsec(&self, range_km: f64) -> f64 {
        2.0 * self.outer_radius_m / (range_km * 1000.0) * ARCSEC_PER_RAD
    }

    /// Diameter of the hole in that disk, arcsec.
    pub fn defocus_inner_arcsec(&self, range_km: f64) -> f64 {
        2.0 * self.inner_radius_m / (range_km * 1000.0) * ARCSEC_PER_RAD
    }

    /// Width of the streak of a satellite of `satellite_size_m` at `range_km`, arcsec.
    pub fn width_arcsec(&self, range_km: f64, satellite_size_m: f64) -> f64 {
        // θ² = θ_atm² + (D_sat² + D_mirror²) / d²                        Tyson et al. (2020), eq. 1
        let satellite = satellite_size_m / (range_km * 1000.0) * ARCSEC_PER_RAD;
        self.seeing_arcsec.hypot(satellite).hypot(self.defocus_outer_arcsec(range_km))
    }

    /// Magnitude of a satellite at 550 km overhead whose streak is as bright per area as this one: what the limits of a camera are
    /// compared with.
    ///
    /// `magnitude` is the apparent one, as if the satellite stood still. A pixel gets the light of m for the time that the streak needs
    /// to pass it, spread over the streak's width: a satellite that is farther is slower and more in focus, and worse for the same
    /// magnitude. With the seeing alone this is the rule of SATCON1, 2.5 log10(h / 550 km).
    pub fn as_at_550_km_mag(
        &self,
        magnitude: f64,
        range_km: f64,
        angular_rate_arcsec_s: f64,
        satellite_size_m: f64,
    ) -> f64 {
        // m + 2.5 log10(ω θ / ω₀ θ₀)
        let width = self.width_arcsec(range_km, satellite_size_m) / self.width_arcsec(550.0, satellite_size_m);
        magnitude + 2.5 * (width * angular_rate_arcsec_s / RATE_AT_550_KM_ARCSEC_S).log10()
    }

    /// Share of a field's pixels that masking one streak costs; see [`expected_lost_pixel_fraction`].
    pub fn lost_pixel_fraction(&self, streak_length_deg: f64, width_arcsec: f64, field_area_deg2: f64) -> f64 {
        expected_lost_pixel_fraction(streak_length_deg, self.mask_widths * width_arcsec, field_area_deg2)
    }
}
