//! Passbands, zero points, and the Sun's magnitude in each.
//!
//! The reflectance of a satellite is usually measured in only one band. Magnitudes in other bands are computed from the
//! Sun's colour as if the satellite were grey, and are marked as such.

use std::fmt;
use std::str::FromStr;

use super::response::{DIFFUSE_LESS_SUN_MAG, ResponseBand};
use crate::error::Error;

/// A passband.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Band {
    /// Johnson B.
    B,
    /// Johnson V.
    V,
    /// Cousins R.
    R,
    /// Cousins I.
    I,
    /// LSST u.
    LsstU,
    /// LSST g.
    LsstG,
    /// LSST r.
    LsstR,
    /// LSST i.
    LsstI,
    /// LSST z.
    LsstZ,
    /// LSST y.
    LsstY,
    /// Gaia G.
    GaiaG,
    /// 2MASS J.
    J,
    /// 2MASS H.
    H,
    /// 2MASS Ks.
    K,
    /// WISE W1, 3.4 µm.
    W1,
    /// WISE W2, 4.6 µm.
    W2,
    /// A response curve.
    Response(ResponseBand),
}

/// Zero point of magnitudes.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MagSystem {
    /// Vega has a magnitude of about 0.03.
    Vega,
    /// A source of 3631 Jy at every frequency has magnitude 0.
    Ab,
}

impl Band {
    /// All bands with a name, from blue to red within each photometric system.
    pub const ALL: [Band; 16] = [
        Band::B,
        Band::V,
        Band::R,
        Band::I,
        Band::LsstU,
        Band::LsstG,
        Band::LsstR,
        Band::LsstI,
        Band::LsstZ,
        Band::LsstY,
        Band::GaiaG,
        Band::J,
        Band::H,
        Band::K,
        Band::W1,
        Band::W2,
    ];

    /// Returns the band's name in tables, for example `V`, `g` (LSST), `G` (Gaia) or `K` (2MASS Ks);
    /// `response` for a response curve.
    pub fn name(self) -> &'static str {
        match self {
            Band::B => "B",
            Band::V => "V",
            Band::R => "R",
            Band::I => "I",
            Band::LsstU => "u",
            Band::LsstG => "g",
            Band::LsstR => "r",
            Band::LsstI => "i",
            Band::LsstZ => "z",
            Band::LsstY => "y",
            Band::GaiaG => "G",
            Band::J => "J",
            Band::H => "H",
            Band::K => "K",
            Band::W1 => "W1",
            Band::W2 => "W2",
            Band::Response(_) => "response",
        }
    }

    /// Returns the magnitude system that is usual for this band.
    pub fn usual_system(self) -> MagSystem {
        match self {
            Band::B | Band::V | Band::R | Band::I | Band::GaiaG => MagSystem::Vega,
            Band::J | Band::H | Band::K | Band::W1 | Band::W2 => MagSystem::Vega,
            Band::LsstU | Band::LsstG | Band::LsstR | Band::LsstI | Band::LsstZ | Band::LsstY => MagSystem::Ab,
            Band::Response(_) => MagSystem::Ab,
        }
    }

    /// Returns the apparent magnitude of the Sun at 1 au. That of a response curve is AB in both systems.
    pub fn sun_magnitude(self, system: MagSystem) -> f64 {
        // AB magnitudes, and Vega magnitudes in B, V, R, I, J, H, K, W1 and W2: Willmer (2018, ApJS 236, 47), table 3;
        // Vega magnitudes in W1 and W2 were read from copies of the table, not compared with the paper.
        // Vega magnitudes in u to y: the AB values less those of Vega (CALSPEC spectrum in pyphot 2.1.1) in the
        // LSST 2023 passbands (speclite 1.0): 0.61, -0.10, 0.14, 0.36, 0.51, 0.55.
        // G: Casagrande and VandenBerg (2018, MNRAS 479, L102); AB - Vega 0.114 from the Gaia DR3 zero points.
        let (vega, ab) = match self {
            Band::B => (-26.13, -26.26),
            Band::V => (-26.76, -26.77),
            Band::R => (-27.15, -26.97),
            Band::I => (-27.47, -27.05),
            Band::LsstU => (-25.91, -25.30),
            Band::LsstG => (-26.42, -26.52),
            Band::LsstR => (-27.08, -26.93),
            Band::LsstI => (-27.41, -27.04),
            Band::LsstZ => (-27.57, -27.06),
            Band::LsstY => (-27.62, -27.07),
            Band::GaiaG => (-26.90, -26.79),
            Band::J => (-27.90, -27.03),
            Band::H => (-28.25, -26.91),
            Band::K => (-28.30, -26.49),
            Band::W1 => (-28.31, -25.66),
            Band::W2 => (-28.29, -25.00),
            Band::Response(band) => (band.sun_mag(), band.sun_mag()),
        };
        match system {
            MagSystem::Vega => vega,
            MagSystem::Ab => ab,
        }
    }

    /// Returns the magnitudes of 1 m² of a black body at 280 K and at 290 K, at a range of 1000 km. `None` in bands in
    /// which the full Moon's light on a satellite outshines its thermal emission: in J, H and at shorter wavelengths.
    pub(super) fn black_body_mag(self, system: MagSystem) -> Option<[f64; 2]> {
        // AB magnitudes of Planck's law in the passbands: photon-weighted means by
        // `tests/reference/make_infrared_bands.py`, with the response curves of Cohen et al. (2003, AJ 126, 1090) and
        // Wright et al. (2010, AJ 140, 1868). Their zero points agree with those of Willmer within 0.04 mag.
        let ab = match self {
            Band::K => [17.942, 17.075],
            Band::W1 => [10.105, 9.562],
            Band::W2 => [6.869, 6.465],
            Band::Response(band) => band.black_body_mag()?,
            _ => return None,
        };
        let to_system = self.sun_magnitude(system) - self.sun_magnitude(MagSystem::Ab);
        Some(ab.map(|ab| ab + to_system))
    }

    /// Returns true for J, H, K, W1 and W2.
    #[doc(hidden)]
    pub fn is_infrared(self) -> bool {
        matches!(self, Band::J | Band::H | Band::K | Band::W1 | Band::W2)
    }

    /// Returns true if thermal emission contributes to the light of satellites, so that those in the Earth's shadow
    /// have a magnitude: in K, W1, W2 and response curves beyond about 2 µm.
    #[doc(hidden)]
    pub fn has_emission(self) -> bool {
        self.black_body_mag(MagSystem::Ab).is_some()
    }

    /// Returns true if satellites in the Earth's shadow are not much fainter than others: their emission is at least 1
    /// % of the sunlight that a diffuse body of the same area reflects. This holds in W1, W2 and response curves beyond
    /// about 3 µm, not in K (10 mag).
    #[doc(hidden)]
    pub fn is_thermal(self) -> bool {
        self.black_body_mag(MagSystem::Ab)
            .is_some_and(|[emitted, _]| emitted < self.sun_magnitude(MagSystem::Ab) + DIFFUSE_LESS_SUN_MAG + 5.0)
    }
}

impl fmt::Display for Band {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl fmt::Display for MagSystem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            MagSystem::Vega => "Vega",
            MagSystem::Ab => "AB",
        })
    }
}

impl FromStr for Band {
    type Err = Error;

    /// Parses the name of a band. Case matters (`R` is Cousins, `r` is LSST; `G` is Gaia, `g` is LSST). `Ks` is `K`.
    fn from_str(text: &str) -> Result<Self, Error> {
        let name = if text.trim() == "Ks" { "K" } else { text.trim() };
        Band::ALL.into_iter().find(|band| band.name() == name).ok_or_else(|| {
            Error::unknown(
                "band",
                text,
                "B V R I (Johnson-Cousins), u g r i z y (LSST), G (Gaia), J H K (2MASS), W1 W2 (WISE)",
            )
        })
    }
}

impl FromStr for MagSystem {
    type Err = Error;

    /// Parses the name of a magnitude system; upper and lower case are equivalent.
    fn from_str(text: &str) -> Result<Self, Error> {
        match text.trim().to_ascii_lowercase().as_str() {
            "vega" => Ok(MagSystem::Vega),
            "ab" => Ok(MagSystem::Ab),
            _ => Err(Error::unknown("magnitude system", text, "Vega and AB")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_names_round_trip() {
        for band in Band::ALL {
            assert_eq!(band.to_string().parse::<Band>().unwrap(), band);
        }
        assert_eq!("ab".parse::<MagSystem>().unwrap(), MagSystem::Ab);
        assert_eq!(MagSystem::Vega.to_string().parse::<MagSystem>().unwrap(), MagSystem::Vega);
        let error = "w".parse::<Band>().unwrap_err().to_string();
        assert!(error.contains("\"w\"") && error.contains("u g r i z y") && error.contains("J H K"), "{error}");
        assert!("vaga".parse::<MagSystem>().is_err());
    }

    #[test]
    fn valid_colours_of_the_sun() {
        let sun = |band: Band| band.sun_magnitude(band.usual_system());
        assert_eq!(sun(Band::V), -26.76);
        // B - V of the Sun: 0.653 ± 0.005 (Ramirez et al. 2012, ApJ 752, 5); V - R 0.352, V - I 0.702. Willmer's
        // tables are rounded to 0.01 mag and state errors of 0.02 to 0.04 mag.
        for (blue, red, colour) in [(Band::B, Band::V, 0.653), (Band::V, Band::R, 0.352), (Band::V, Band::I, 0.702)] {
            assert!((sun(blue) - sun(red) - colour).abs() < 0.05, "{blue} - {red}");
        }
        // g - r, r - i, i - z of the Sun in SDSS: 0.44, 0.11, 0.03 (SDSS, ugriz colours of Vega and the Sun).
        for (blue, red, colour) in
            [(Band::LsstG, Band::LsstR, 0.44), (Band::LsstR, Band::LsstI, 0.11), (Band::LsstI, Band::LsstZ, 0.03)]
        {
            assert!((sun(blue) - sun(red) - colour).abs() < 0.05, "{blue} - {red}");
        }
        // Vega is bluer than a flat spectrum: the redder the band, the more AB exceeds Vega.
        for pair in [Band::LsstG, Band::LsstR, Band::LsstI, Band::LsstZ, Band::LsstY].windows(2) {
            let excess = |band: Band| band.sun_magnitude(MagSystem::Ab) - band.sun_magnitude(MagSystem::Vega);
            assert!(excess(pair[0]) < excess(pair[1]));
        }
    }
}
