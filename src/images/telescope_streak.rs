//! Photometric quantities of a streak: effective magnitude, surface brightness and lost pixels.

/// Number of arcseconds in a radian.
pub const ARCSEC_PER_RAD: f64 = 180.0 * 3600.0 / std::f64::consts::PI;

/// Returns the magnitude of a star that has the surface brightness of the streak in the same exposure.
///
/// `magnitude` is the magnitude of the satellite irrespective of its motion, `width_arcsec` the width of its streak,
/// `angular_rate_arcsec_s` its angular speed and `exposure_s` the exposure time. If the satellite moves by less than
/// the width of its streak, its own magnitude is returned.
pub fn effective_magnitude(magnitude: f64, width_arcsec: f64, angular_rate_arcsec_s: f64, exposure_s: f64) -> f64 {
    // m_eff = m - 2.5 log10(θ / (ω t))
    let length_arcsec = (angular_rate_arcsec_s * exposure_s).max(width_arcsec);
    magnitude - 2.5 * (width_arcsec / length_arcsec).log10()
}

/// Returns the surface brightness of the streak, mag per square arcsecond, averaged over the exposure. A sky of this
/// surface brightness gives the same signal in the same pixels.
pub fn surface_brightness_mag_arcsec2(
    magnitude: f64,
    width_arcsec: f64,
    angular_rate_arcsec_s: f64,
    exposure_s: f64,
) -> f64 {
    // The light collected in t seconds is spread over a length ω t and a width θ: μ = m + 2.5 log10(ω t θ).
    let length_arcsec = (angular_rate_arcsec_s * exposure_s).max(width_arcsec);
    magnitude + 2.5 * (length_arcsec * width_arcsec).log10()
}

/// Returns the fraction of a field's area that a band along the streak covers, [0, 1].
///
/// The band is `masked_width_arcsec` wide and `streak_length_deg` long (the lit part within the field). Its
/// round ends and the clipping at the edge of the field are neglected. For several streaks, sum the fractions and limit
/// the sum to 1; intersections are then counted twice.
pub fn expected_lost_pixel_fraction(streak_length_deg: f64, masked_width_arcsec: f64, field_area_deg2: f64) -> f64 {
    (streak_length_deg * masked_width_arcsec / 3600.0 / field_area_deg2).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::telescope::Telescope;

    #[test]
    fn valid_effective_magnitudes_of_tyson_2020() {
        // 30 s, 0.7", 2300"/s: 12.5 mag fainter with the seeing alone; 10.8 with the defocused width at 550 km.
        assert!((effective_magnitude(0.0, 0.7, 2300.0, 30.0) - 12.5).abs() < 0.05);
        let rubin = Telescope::by_name("rubin").unwrap();
        let width = rubin.width_arcsec(550.0, 0.0);
        assert!((effective_magnitude(0.0, width, 2300.0, 30.0) - 10.8).abs() < 0.05, "{width}");
        // "The full width at half maximum of the trail is about 3 arcsec" (Tyson et al. 2020, abstract).
        assert!((width - 3.2).abs() < 0.05, "{width}");
    }

    #[test]
    fn valid_annulus_diameters() {
        let rubin = Telescope::by_name("rubin").unwrap();
        for (range_km, diameter_arcsec) in [(350.0, 4.93), (550.0, 3.135), (1200.0, 1.44)] {
            assert!((rubin.defocus_outer_arcsec(range_km) - diameter_arcsec).abs() < 0.005);
        }
    }

    #[test]
    fn verif_surface_brightness_follows_from_the_effective_magnitude() {
        // Surface brightness = magnitude of the effective star spread over θ².
        let (m, width, rate, exposure) = (6.5, 3.4, 2500.0, 30.0);
        let effective = effective_magnitude(m, width, rate, exposure);
        let surface = surface_brightness_mag_arcsec2(m, width, rate, exposure);
        assert!((surface - (effective + 2.5 * (width * width).log10())).abs() < 1e-12);
        // A satellite that hardly moves keeps its magnitude.
        assert_eq!(effective_magnitude(11.0, 2.0, 0.0, 30.0), 11.0);
        assert_eq!(effective_magnitude(11.0, 2.0, 1e-3, 30.0), 11.0);
    }

    #[test]
    fn valid_limits_at_other_heights_are_those_of_satcon1_with_seeing_alone() {
        let rubin = Telescope::by_name("rubin").unwrap();
        let seeing = Telescope { outer_radius_m: 0.001, inner_radius_m: 0.0, ..rubin.clone() };
        let rate = |height_km: f64| (398_600.4_f64 / (6378.137 + height_km)).sqrt() / height_km * ARCSEC_PER_RAD;
        assert!((rubin.equivalent_mag_at_550_km(5.0, 550.0, rate(550.0), 3.0) - 5.0).abs() < 1e-4);
        for height_km in [340.0_f64, 600.0, 1200.0] {
            let as_limit = 7.0 + (7.0 - seeing.equivalent_mag_at_550_km(7.0, height_km, rate(height_km), 0.0));
            // SATCON1 neglects that higher satellites fly more slowly: 0.05 mag at 1200 km.
            assert!((as_limit - (7.0 + 2.5 * (height_km / 550.0).log10())).abs() < 0.055, "{height_km}: {as_limit}");
        }
        // At 1200 km a satellite is more in focus and therefore brighter per pixel: 1.6 instead of 3.1 arcsec wide.
        let shift = |telescope: &Telescope| telescope.equivalent_mag_at_550_km(7.0, 1200.0, rate(1200.0), 0.0);
        assert!(shift(&rubin) < shift(&seeing) - 0.6, "{} {}", shift(&rubin), shift(&seeing));
    }

    #[test]
    fn verif_lost_pixels() {
        // 3.5 deg long, 7.2 arcsec wide in 9.62 square degrees.
        let fraction = expected_lost_pixel_fraction(3.5, 7.2, 9.621);
        assert!((fraction - 3.5 * 0.002 / 9.621).abs() < 1e-15);
        assert_eq!(expected_lost_pixel_fraction(100.0, 36_000.0, 1.0), 1.0);
        let rubin = Telescope::by_name("rubin").unwrap();
        let area = rubin.field.area_deg2();
        assert!((rubin.lost_pixel_fraction(3.5, 3.6, area) - fraction).abs() < 1e-6);
    }
}
