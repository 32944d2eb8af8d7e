//! Streaks in numbers: how faint a moving satellite looks, and how many pixels it costs.

/// Arcseconds in a radian.
pub(super) const ARCSEC_PER_RAD: f64 = 180.0 * 3600.0 / std::f64::consts::PI;

/// Magnitude of the star whose image would be as bright per area as the streak, in the same exposure.
///
/// `magnitude` is that of the satellite as if it stood still, `width_arcsec` its streak's width, `angular_rate_arcsec_s` its speed,
/// `exposure_s` the time that the shutter is open. A satellite too slow to draw a streak longer than its
/// width keeps its own magnitude.
pub fn effective_magnitude(magnitude: f64, width_arcsec: f64, angular_rate_arcsec_s: f64, exposure_s: f64) -> f64 {
    // m_eff = m - 2.5 log10(θ / (ω t))
    let length_arcsec = (angular_rate_arcsec_s * exposure_s).max(width_arcsec);
    magnitude - 2.5 * (width_arcsec / length_arcsec).log10()
}

/// Surface brightness of the streak, mag per square arcsecond, averaged over the exposure: what a sky of that
/// brightness would put into the same pixels in the same time.
pub fn surface_brightness_mag_arcsec2(
    magnitude: f64,
    width_arcsec: f64,
    angular_rate_arcsec_s: f64,
    exposure_s: f64,
) -> f64 {
    // In t seconds the light of t seconds is spread over ω t long and θ wide: μ = m + 2.5 log10(ω t θ).
    let length_arcsec = (angular_rate_arcsec_s * exposure_s).max(width_arcsec);
    magnitude + 2.5 * (length_arcsec * width_arcsec).log10()
}

/// How long a point of the streak takes to cross a pixel, seconds.
pub fn time_on_pixel_s(pixel_scale_arcsec: f64, angular_rate_arcsec_s: f64) -> f64 {
    pixel_scale_arcsec / angular_rate_arcsec_s
}

/// Share of a field's area that a band along the streak covers, [0, 1].
///
/// The band is `streak_length_deg` long (all chords within the field), `masked_width_arcsec` wide. Its round
/// ends, and what lies beyond the field's edge, are left out; for several streaks add up, which
/// counts crossings twice, and cut at 1.
pub fn expected_lost_pixel_fraction(streak_length_deg: f64, masked_width_arcsec: f64, field_area_deg2: f64) -> f64 {
    (streak_length_deg * masked_width_arcsec / 3600.0 / field_area_deg2).clamp(0.0, 1.0)
}
