//! Telescopes by name and from TOML files: aperture, seeing, pixels, field of view, and losses to bright
//! streaks.
//!
//! A satellite is so near that it is out of focus: the image of a point is a ring with the shape of the mirror. Widths
//! of streaks follow Tyson et al. (2020, AJ 160, 226) and Ragazzoni (2020, PASP 132, 114502). Angles are in arcseconds
//! and degrees, as in the TOML files.

use serde::{Deserialize, Serialize};

use super::magnitude_limit::MagnitudeLimit;
pub use super::telescope_streak::{
    ARCSEC_PER_RAD, effective_magnitude, expected_lost_pixel_fraction, surface_brightness_mag_arcsec2,
};
use crate::error::Error;

/// Speed on the sky of a satellite 550 km overhead, arcsec/s: √(μ / (R + h)) / h.
const RATE_AT_550_KM_ARCSEC_S: f64 = 2844.7;

/// Telescope with its camera, created by [`Telescope::by_name`] or read from a TOML file with the same keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Telescope {
    /// Name, of lower-case letters, digits, `.` and `-`.
    pub name: String,
    /// Title in one line.
    pub title: String,
    /// Radius of the light-collecting aperture, m.
    pub outer_radius_m: f64,
    /// Radius of the central obstruction, m; 0 if there is none or its size is not published.
    pub inner_radius_m: f64,
    /// Typical width (FWHM) of a star's image from atmosphere and optics, arcsec.
    pub seeing_arcsec: f64,
    /// Side of a pixel on the sky, arcsec.
    pub pixel_scale_arcsec: f64,
    /// Default field of view.
    pub field: FieldOfView,
    /// Width of a mask as a multiple of the width of the streak; not used if `mask_arcsec` is given. A factor of two
    /// contains 98 % of the light of a streak with a Gaussian profile.
    #[serde(default = "default_mask_widths")]
    pub mask_widths: f64,
    /// Width of a mask that is the same for all streaks, arcsec.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mask_arcsec: Option<f64>,
    /// Share of an exposure that is lost to a bright streak across the whole field; 0 to 100; 0.08 if omitted. With a
    /// value above 1 a bright streak costs more than the exposure.
    ///
    /// The default is that of 15 lost CCDs of 189 (Hu et al. 2022, ApJL 941, L15, section 2).
    #[serde(default = "default_bright_share")]
    pub bright_share: f64,
    /// Magnitude of a satellite 550 km overhead, without motion, above which its streak is bright: signals on the rest
    /// of the detector cannot be corrected. The default, also for bands that are not in a table, is 7 (Tyson et al.
    /// 2020).
    #[serde(default = "default_bright_mag")]
    pub bright_mag: MagnitudeLimit,
    /// Source of these numbers.
    pub source: String,
}

/// Returns the default width of a mask as a multiple of the width of the streak.
fn default_mask_widths() -> f64 {
    2.0
}

/// Returns the default share of an exposure that is lost to a bright streak.
fn default_bright_share() -> f64 {
    0.08
}

/// Magnitude of bright streaks in bands without a value.
const DEFAULT_BRIGHT_MAG: f64 = 7.0;

fn default_bright_mag() -> MagnitudeLimit {
    MagnitudeLimit::All(DEFAULT_BRIGHT_MAG)
}

/// Part of the sky covered by an exposure, on the tangent plane. The x axis points east, the y axis north; degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FieldOfView {
    /// A circle of this diameter.
    CircleDeg(f64),
    /// A rectangle of this width and height, centred on the pointing.
    RectangleDeg([f64; 2]),
    /// A polygon of three or more corners in order.
    PolygonDeg(Vec<[f64; 2]>),
}

impl FieldOfView {
    /// Returns the area on the tangent plane, square degrees.
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
    /// Returns the diameter of the defocused image of a point at `range_km`, arcsec, measured at its outer edge.
    pub fn defocus_outer_arcsec(&self, range_km: f64) -> f64 {
        2.0 * self.outer_radius_m / (range_km * 1000.0) * ARCSEC_PER_RAD
    }

    /// Returns the width of the streak of a satellite of the size `satellite_size_m` (m) at `range_km`, arcsec.
    pub fn width_arcsec(&self, range_km: f64, satellite_size_m: f64) -> f64 {
        // θ² = θ_atm² + (D_sat² + D_mirror²) / d²                        Tyson et al. (2020), eq. 1
        let satellite = satellite_size_m / (range_km * 1000.0) * ARCSEC_PER_RAD;
        self.seeing_arcsec.hypot(satellite).hypot(self.defocus_outer_arcsec(range_km))
    }

    /// Returns the magnitude at which a satellite 550 km overhead would have a streak of the same surface brightness.
    /// This can be compared with the limits of a camera.
    ///
    /// `magnitude` is the apparent magnitude of the satellite, irrespective of its motion. A pixel receives the light
    /// of the satellite, spread over the width of the streak, while the satellite crosses the pixel. A more distant
    /// satellite moves more slowly and is more in focus, so that at the same magnitude its streak is brighter. Without
    /// defocus, the difference is that of the rule of SATCON1, 2.5 log10(h / 550 km).
    pub fn equivalent_mag_at_550_km(
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

    /// Returns the fraction of a field's pixels that are lost by masking one streak, [0, 1]. Round ends
    /// and the clipping at the edge of the field are neglected.
    pub fn lost_pixel_fraction(&self, streak_length_deg: f64, width_arcsec: f64, field_area_deg2: f64) -> f64 {
        expected_lost_pixel_fraction(streak_length_deg, self.mask_width_arcsec(width_arcsec), field_area_deg2)
    }

    /// Returns the width of the mask of a streak of the width `width_arcsec`, arcsec.
    pub fn mask_width_arcsec(&self, width_arcsec: f64) -> f64 {
        self.mask_arcsec.unwrap_or(self.mask_widths * width_arcsec)
    }

    /// Returns the magnitude of bright streaks in a band, for a satellite 550 km overhead without motion.
    pub fn bright_mag_in(&self, band: Option<&str>) -> f64 {
        self.bright_mag.limit_in(band).unwrap_or(DEFAULT_BRIGHT_MAG)
    }
}

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// Name and TOML text of every preset.
        const PRESETS: &[(&str, &str)] = &[$(($name, include_str!(concat!("telescope/presets/", $name, ".toml")))),*];
    };
}
presets!("atlas", "decam", "pan-starrs", "rubin", "small", "vst", "ztf");

/// Names of the bands for which magnitudes of bright streaks can be given. They are listed here so that this module
/// does not depend on photometry.
const BANDS: [&str; 16] = ["B", "V", "R", "I", "u", "g", "r", "i", "z", "y", "G", "J", "H", "K", "W1", "W2"];

impl Telescope {
    /// Returns a preset by its name; upper and lower case are equivalent. `lsst` is Rubin, `panstarrs` and `ps1` are
    /// Pan-STARRS.
    ///
    /// # Errors
    /// An unknown name.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let preset_name = match name.trim().to_ascii_lowercase().as_str() {
            "lsst" | "simonyi" => "rubin".to_owned(),
            "panstarrs" | "ps1" => "pan-starrs".to_owned(),
            "blanco" => "decam".to_owned(),
            other => other.to_owned(),
        };
        let (preset, text) = PRESETS.iter().find(|(preset, _)| *preset == preset_name).ok_or_else(|| {
            let known: Vec<&str> = Self::names().collect();
            Error::invalid("telescope", format!("{name:?}"), known.join(", "))
        })?;
        Self::from_toml(text, preset)
    }

    /// Returns the names of the presets in alphabetical order.
    pub fn names() -> impl Iterator<Item = &'static str> {
        PRESETS.iter().map(|(name, _)| *name)
    }

    /// Reads a TOML file with the keys of [`Telescope`]; `origin` is the name of the file in errors.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown or missing, a value is out of range, or a limit is for an unknown band.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, Error> {
        let telescope: Self = toml::from_str(text)
            .map_err(|error| crate::input::toml_error(&error, text).in_file("telescope file", origin))?;
        telescope.validate(origin)?;
        Ok(telescope)
    }

    fn validate(&self, origin: &str) -> Result<(), Error> {
        let range = |key: &str, given: f64, least: f64, greatest: f64| {
            Error::check_range(key, given, least, greatest).map_err(|error| error.in_file("telescope file", origin))
        };
        range("outer_radius_m", self.outer_radius_m, 0.001, 100.0)?;
        range("inner_radius_m", self.inner_radius_m, 0.0, self.outer_radius_m)?;
        range("seeing_arcsec", self.seeing_arcsec, 0.001, 600.0)?;
        range("pixel_scale_arcsec", self.pixel_scale_arcsec, 0.001, 600.0)?;
        range("mask_widths", self.mask_widths, 0.1, 100.0)?;
        match &self.field {
            FieldOfView::CircleDeg(diameter) => range("field.circle_deg", *diameter, 1e-4, 170.0)?,
            FieldOfView::RectangleDeg(sides) => {
                sides.iter().try_for_each(|&side| range("field.rectangle_deg", side, 1e-4, 170.0))?
            }
            FieldOfView::PolygonDeg(corners) => {
                range("field.polygon_deg (corners)", corners.len() as f64, 3.0, 10_000.0)?;
                corners.iter().flatten().try_for_each(|&value| range("field.polygon_deg", value, -85.0, 85.0))?
            }
        }
        self.mask_arcsec.map_or(Ok(()), |width| range("mask_arcsec", width, 0.001, 3600.0))?;
        range("bright_share", self.bright_share, 0.0, 100.0)?;
        self.bright_mag.numbers().into_iter().try_for_each(|mag| range("bright_mag", mag, -10.0, 30.0))?;
        if let MagnitudeLimit::PerBand(magnitudes) = &self.bright_mag
            && let Some(band) = magnitudes.keys().find(|band| *band != "default" && !BANDS.contains(&band.as_str()))
        {
            let what = format!("telescope file {origin}: band of bright_mag");
            return Err(Error::invalid(what, format!("{band:?}"), format!("{}, default", BANDS.join(", "))));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: &str = r#"
name = "mine"
title = "My telescope"
outer_radius_m = 0.5
inner_radius_m = 0.2
seeing_arcsec = 1.5
pixel_scale_arcsec = 0.5
field = { polygon_deg = [[-1, -1], [1, -1], [1, 1], [-1, 1]] }
source = "measured"

[bright_mag]
V = 6.0
"#;

    #[test]
    fn verif_presets_are_sound_and_named_after_their_files() {
        let names: Vec<_> = Telescope::names().collect();
        assert_eq!(names, ["atlas", "decam", "pan-starrs", "rubin", "small", "vst", "ztf"]);
        for name in names {
            let telescope = Telescope::by_name(name).unwrap();
            assert_eq!(telescope.name, name);
            assert!(telescope.field.area_deg2() > 0.5 && telescope.mask_widths == 2.0);
            // The written text reads back as the same telescope.
            let text = toml::to_string(&telescope).unwrap();
            assert_eq!(Telescope::from_toml(&text, name).unwrap(), telescope);
        }
        assert_eq!(Telescope::by_name(" LSST ").unwrap().name, "rubin");
        // ZTF: 55 square degrees with gaps (Dekany et al. 2020).
        assert!((Telescope::by_name("ztf").unwrap().field.area_deg2() - 55.0).abs() < 0.2);
        let error = Telescope::by_name("hubble").unwrap_err().to_string();
        assert!(error.contains("\"hubble\"") && error.contains("atlas, decam"), "{error}");
    }

    #[test]
    fn verif_a_telescope_file_is_read_and_its_ranges_are_checked() {
        let own = Telescope::from_toml(OWN, "mine.toml").unwrap();
        assert!((own.field.area_deg2() - 4.0).abs() < 1e-12);
        assert_eq!([Some("V"), Some("g"), None].map(|band| own.bright_mag_in(band)), [6.0, 7.0, 7.0]);
        assert_eq!((own.bright_share, own.mask_width_arcsec(3.0)), (0.08, 6.0));
        let with = |key: &str| Telescope::from_toml(&format!("{key}\n{OWN}"), "mine.toml");
        assert_eq!(with("mask_arcsec = 60").unwrap().mask_width_arcsec(3.0), 60.0);
        let as_text = OWN.replace("[bright_mag]\nV = 6.0", "bright_mag = 'V=6,default=7.5'");
        let as_text = Telescope::from_toml(&as_text, "mine.toml").unwrap();
        assert_eq!([Some("V"), Some("g"), None].map(|band| as_text.bright_mag_in(band)), [6.0, 7.5, 7.5]);
        for (key, words) in [
            ("mask_arcsec = 0", "mask_arcsec is 0"),
            ("bright_share = -0.1", "bright_share is -0.1; allowed: 0 to 100"),
            ("bright_share = nan", "bright_share is NaN"),
        ] {
            let error = with(key).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        for (from, to, words) in [
            ("outer_radius_m = 0.5", "outer_radius_m = -0.5", &["outer_radius_m is -0.5", "0.001 to 100"][..]),
            ("inner_radius_m = 0.2", "inner_radius_m = 0.6", &["inner_radius_m is 0.6", "0 to 0.5"]),
            ("seeing_arcsec = 1.5", "seeing_arcsec = nan", &["seeing_arcsec is NaN"]),
            ("seeing_arcsec = 1.5", "seing_arcsec = 1.5", &["unknown key 'seing_arcsec'"]),
            ("seeing_arcsec = 1.5", "", &["missing key 'seeing_arcsec'"]),
            ("polygon_deg = [[-1, -1], [1, -1], [1, 1], [-1, 1]]", "circle_deg = 0", &["field.circle_deg is 0"]),
            ("polygon_deg = [[-1, -1], [1, -1], [1, 1], [-1, 1]]", "polygon_deg = [[0, 0]]", &["corners", "3 to"]),
            (
                "V = 6.0",
                "W = 6.0",
                &["band of bright_mag is \"W\"", "B, V, R, I, u, g, r, i, z, y, G, J, H, K, W1, W2, default"],
            ),
            ("V = 6.0", "V = 99.0", &["bright_mag is 99"]),
            ("[bright_mag]\nV = 6.0", "bright_mag = 'bright'", &["invalid magnitude limit"]),
            ("[bright_mag]", "[limits.V]", &["unknown key 'limits'"]),
        ] {
            let text = OWN.replace(from, to);
            assert_ne!(text, OWN);
            let error = Telescope::from_toml(&text, "mine.toml").unwrap_err().to_string();
            assert!(error.starts_with("telescope file mine.toml: "), "{error}");
            for word in words {
                assert!(error.contains(word), "{error:?} should contain {word:?}");
            }
        }
    }
}
