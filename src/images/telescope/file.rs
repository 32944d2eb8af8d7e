//! Telescopes by name and from TOML files, each held to what is allowed.

use super::super::error::ImagesError;

use super::aperture::{FieldOfView, Telescope};

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// Name and text of every preset, in the form that users write.
        const PRESETS: &[(&str, &str)] = &[$(($name, include_str!(concat!("presets/", $name, ".toml")))),*];
    };
}
presets!("atlas", "decam", "pan-starrs", "rubin", "small", "vst", "ztf");

/// Names of the bands that limits may be given for. Kept here so that telescopes import nothing.
const BANDS: [&str; 11] = ["B", "V", "R", "I", "u", "g", "r", "i", "z", "y", "G"];

impl Telescope {
    /// A preset by name, in any case; `lsst` is Rubin, `panstarrs` and `ps1` Pan-STARRS.
    ///
    /// # Errors
    /// [`ImagesError::UnknownTelescope`] with all known names.
    pub fn by_name(name: &str) -> Result<Self, ImagesError> {
        let wanted = match name.trim().to_ascii_lowercase().as_str() {
            "lsst" | "simonyi" => "rubin".to_owned(),
            "panstarrs" | "ps1" => "pan-starrs".to_owned(),
            "blanco" => "decam".to_owned(),
            other => other.to_owned(),
        };
        let (preset, text) =
            PRESETS.iter().find(|(preset, _)| *preset == wanted).ok_or_else(|| ImagesError::UnknownTelescope {
                given: name.to_owned(),
                known: Self::names().collect::<Vec<_>>().join(", "),
            })?;
        Self::from_toml(text, preset)
    }

    /// Names of the presets in alphabetical order.
    pub fn names() -> impl Iterator<Item = &'static str> {
        PRESETS.iter().map(|(name, _)| *name)
    }

    /// From the text of a TOML file with the keys of [`Telescope`]; `origin` (its name) is what errors call it.
    ///
    /// # Errors
    /// [`ImagesError`]: text that is not TOML, unknown or missing keys, values out of range, limits for unknown
    /// bands.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, ImagesError> {
        let telescope: Self = toml::from_str(text).map_err(|error| ImagesError::TelescopeToml {
            origin: origin.to_owned(),
            message: error.to_string().trim_end().to_owned(),
        })?;
        telescope.validate(origin)?;
        Ok(telescope)
    }

    fn validate(&self, origin: &str) -> Result<(), ImagesError> {
        let range = |key: &str, given: f64, least: f64, greatest: f64| {
            // Not a number is in no range.
            if (least..=greatest).contains(&given) {
                return Ok(());
            }
            Err(ImagesError::TelescopeOutOfRange {
                origin: origin.to_owned(),
                key: key.to_owned(),
                given,
                least,
                greatest,
            })
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
        for (band, limits) in &self.limits {
            if !BANDS.contains(&band.as_str()) {
                return Err(ImagesError::TelescopeBand { origin: origin.to_owned(), given: band.clone() });
            }
            for (key, limit) in
                [("trail_saturation_mag", limits.trail_saturation_mag), ("crosstalk_mag", limits.crosstalk_mag)]
            {
                limit.map_or(Ok(()), |mag| range(&format!("limits.{band}.{key}"), mag, -10.0, 30.0))?;
            }
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

[limits.V]
trail_saturation_mag = 4.0
"#;

    #[test]
    fn verif_presets_are_sound_and_named_after_their_files() {
        let names: Vec<_> = Telescope::names().collect();
        assert_eq!(names, ["atlas", "decam", "pan-starrs", "rubin", "small", "vst", "ztf"]);
        for name in names {
            let telescope = Telescope::by_name(name).unwrap();
            assert_eq!(telescope.name, name);
            assert!(telescope.field.area_deg2() > 0.5 && telescope.mask_widths == 2.0);
            // What is written reads back as the same telescope.
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
    fn verif_a_file_of_ones_own_is_read_and_held_to_its_ranges() {
        let own = Telescope::from_toml(OWN, "mine.toml").unwrap();
        assert!((own.field.area_deg2() - 4.0).abs() < 1e-12);
        assert_eq!(own.limits["V"].trail_saturation_mag, Some(4.0));
        for (from, to, words) in [
            ("outer_radius_m = 0.5", "outer_radius_m = -0.5", &["outer_radius_m is -0.5", "0.001 to 100"][..]),
            ("inner_radius_m = 0.2", "inner_radius_m = 0.6", &["inner_radius_m is 0.6", "0 to 0.5"]),
            ("seeing_arcsec = 1.5", "seeing_arcsec = nan", &["seeing_arcsec is NaN"]),
            ("seeing_arcsec = 1.5", "seing_arcsec = 1.5", &["unknown field `seing_arcsec`"]),
            ("seeing_arcsec = 1.5", "", &["missing field `seeing_arcsec`"]),
            ("polygon_deg = [[-1, -1], [1, -1], [1, 1], [-1, 1]]", "circle_deg = 0", &["field.circle_deg is 0"]),
            ("polygon_deg = [[-1, -1], [1, -1], [1, 1], [-1, 1]]", "polygon_deg = [[0, 0]]", &["corners", "3 to"]),
            ("[limits.V]", "[limits.W]", &["band \"W\"", "B V R I u g r i z y G"]),
            ("trail_saturation_mag = 4.0", "trail_saturation_mag = 99.0", &["limits.V.trail_saturation_mag is 99"]),
        ] {
            let text = OWN.replace(from, to);
            assert_ne!(text, OWN);
            let error = Telescope::from_toml(&text, "mine.toml").unwrap_err().to_string();
            assert!(error.starts_with("telescope file mine.toml: "), "{error}");
            for word in words {
                assert!(error.contains(word), "{error:?} should speak of {word:?}");
            }
        }
    }
}
