//! From native coordinates of a projection to the sky: one rotation.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Matrix3;

/// A sine or cosine this small is zero: a reference point at a pole.
const TINY: f64 = 1e-10;

/// What says how the native sphere lies on the sky; degrees, as in a header.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct NativePole {
    /// CRVAL of right ascension.
    pub right_ascension_deg: f64,
    /// CRVAL of declination.
    pub declination_deg: f64,
    /// LONPOLE, if given.
    pub lonpole_deg: Option<f64>,
    /// LATPOLE, if given.
    pub latpole_deg: Option<f64>,
    /// Whether the reference point is the native pole (zenithal projections), else the native origin.
    pub is_zenithal: bool,
}

impl NativePole {
    /// The matrix that turns native directions into those of the sky; `None` where the header's numbers belong to no rotation.
    ///
    /// Paper II (Calabretta and Greisen 2002), eqs. 2 and 8 to 10.
    pub fn to_sky(self) -> Option<Matrix3<f64>> {
        let declination_0 = self.declination_deg.to_radians();
        let native_latitude_deg = if self.is_zenithal { 90.0 } else { 0.0 };
        // Where LONPOLE is not given: 0 if δ₀ ≥ θ₀, else 180°.
        let default = if self.declination_deg >= native_latitude_deg { 0.0 } else { 180.0 };
        let phi_pole = self.lonpole_deg.unwrap_or(default).to_radians();
        let right_ascension_0 = self.right_ascension_deg.to_radians();
        let (pole_longitude, pole_latitude) = if self.is_zenithal {
            (right_ascension_0, declination_0)
        } else {
            let pole_latitude = self.pole_latitude(declination_0, phi_pole)?;
            (right_ascension_0 - self.longitude_from_pole(declination_0, phi_pole, pole_latitude), pole_latitude)
        };
        let (sin_phi, cos_phi) = phi_pole.sin_cos();
        let (sin_lat, cos_lat) = pole_latitude.sin_cos();
        let (sin_lon, cos_lon) = pole_longitude.sin_cos();
        // sin δ = sin θ sin δp + cos θ cos δp cos(φ - φp), and its two companions        paper II, eq. 2
        let turned = Matrix3::new(
            -sin_lat * cos_phi,
            -sin_lat * sin_phi,
            cos_lat,
            sin_phi,
            -cos_phi,
            0.0,
            cos_lat * cos_phi,
            cos_lat * sin_phi,
            sin_lat,
        );
        let about_pole = Matrix3::new(cos_lon, -sin_lon, 0.0, sin_lon, cos_lon, 0.0, 0.0, 0.0, 1.0);
        Some(about_pole * turned)
    }

    /// Declination of the native pole where the reference point is the native origin (θ₀ = 0, φ₀ = 0).
    ///
    /// δp = atan2(0, cos φp) ± arccos(sin δ₀ / |cos φp|), the one nearer to LATPOLE        paper II, eq. 8
    fn pole_latitude(self, declination_0: f64, phi_pole: f64) -> Option<f64> {
        let (sin_phi, cos_phi) = phi_pole.sin_cos();
        let across = (1.0 - sin_phi * sin_phi).sqrt();
        let wanted = self.latpole_deg.unwrap_or(90.0).to_radians();
        if across < TINY {
            // The pole is anywhere on a circle: LATPOLE says where.
            return (declination_0.abs() < TINY).then_some(wanted);
        }
        let ratio = declination_0.sin() / across;
        if ratio.abs() > 1.0 + TINY {
            return None;
        }
        let from = 0f64.atan2(cos_phi);
        let angle = ratio.clamp(-1.0, 1.0).acos();
        let is_latitude = |latitude: &f64| latitude.abs() <= FRAC_PI_2 + TINY;
        let wrapped = |latitude: f64| {
            let turn = std::f64::consts::TAU;
            latitude - turn * (latitude / turn).round()
        };
        let candidates = [wrapped(from + angle), wrapped(from - angle)];
        candidates.into_iter().filter(is_latitude).min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs()))
    }

    /// Right ascension of the reference point minus that of the native pole (θ₀ = 0, φ₀ = 0).        paper II, eqs. 9, 10
    fn longitude_from_pole(self, declination_0: f64, phi_pole: f64, pole_latitude: f64) -> f64 {
        if (pole_latitude - FRAC_PI_2).abs() < TINY {
            return std::f64::consts::PI - phi_pole;
        }
        if (pole_latitude + FRAC_PI_2).abs() < TINY {
            return phi_pole;
        }
        if declination_0.cos().abs() < TINY {
            return 0.0;
        }
        let sine = phi_pole.sin() / declination_0.cos();
        let cosine = -pole_latitude.sin() * declination_0.sin() / (pole_latitude.cos() * declination_0.cos());
        sine.atan2(cosine)
    }
}
