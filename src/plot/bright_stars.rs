//! Stars visible to the naked eye.

use crate::frames::{Direction, Gcrs};

/// Table of `right ascension,declination,V,name`, degrees and magnitudes; the head of the file names its source.
const TABLE: &str = include_str!("bright_stars.csv");

/// Star visible to the naked eye.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct BrightStar {
    /// Direction from the solar system's barycentre, ICRS at epoch J2000, rounded to 0.001 degrees.
    pub direction: Direction<Gcrs>,
    /// Magnitude in Johnson's band V, from Hipparcos.
    pub v_mag: f64,
    /// Name in the catalogue of star names of the International Astronomical Union, for the 30 brightest stars and
    /// Polaris. Of α Centauri, only the brighter component has one.
    pub name: Option<&'static str>,
}

/// Returns the 5044 Hipparcos stars to V = 6.0 mag.
///
/// Proper motions are not included: the fastest, some arcseconds a year, shift a star by minutes of arc in decades.
pub(super) fn bright_stars() -> impl Iterator<Item = BrightStar> {
    TABLE.lines().filter(|line| !line.starts_with('#')).filter_map(|line| {
        let mut cells = line.split(',');
        let mut number = || cells.next()?.parse::<f64>().ok();
        let (ra_deg, dec_deg, v_mag) = (number()?, number()?, number()?);
        let name = cells.next().filter(|name| !name.is_empty());
        let direction = Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians());
        Some(BrightStar { direction, v_mag, name })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions at epoch J2000 and magnitudes V in SIMBAD.
    #[test]
    fn valid_positions_of_named_stars() {
        // Tolerance: the table is rounded to 0.001 degrees; Johnson and Hipparcos magnitudes of variable and double
        // stars differ.
        const TOLERANCE_DEG: f64 = 0.001;
        const TOLERANCE_MAG: f64 = 0.15;
        for (name, ra_deg, dec_deg, v_mag) in [
            ("Sirius", 101.287_155, -16.716_116, -1.46),
            ("Canopus", 95.987_958, -52.695_661, -0.74),
            ("Arcturus", 213.915_300, 19.182_409, -0.05),
            ("Vega", 279.234_735, 38.783_689, 0.03),
            ("Rigel", 78.634_467, -8.201_638, 0.13),
            ("Procyon", 114.825_498, 5.224_988, 0.37),
            ("Altair", 297.695_827, 8.868_321, 0.76),
            ("Aldebaran", 68.980_163, 16.509_302, 0.86),
            ("Fomalhaut", 344.412_693, -29.622_237, 1.16),
            ("Deneb", 310.357_980, 45.280_339, 1.25),
            ("Polaris", 37.954_561, 89.264_109, 2.02),
            // A motion of 5.2 arcsec a year, so that another epoch would be noticed.
            ("61 Cygni A", 316.724_748, 38.749_417, 5.21),
        ] {
            let expected = Direction::from_lon_lat_rad(f64::to_radians(ra_deg), f64::to_radians(dec_deg));
            let apart_deg = |star: &BrightStar| star.direction.separation_rad(&expected).to_degrees();
            let found = bright_stars().find(|star| apart_deg(star) < TOLERANCE_DEG);
            let found = found.unwrap_or_else(|| panic!("no star at the position of {name}"));
            assert!((found.v_mag - v_mag).abs() < TOLERANCE_MAG, "{name}: {}", found.v_mag);
            assert_eq!(found.name, (name != "61 Cygni A").then_some(name));
        }
    }

    #[test]
    fn every_line_is_a_star() {
        let magnitudes: Vec<f64> = bright_stars().map(|star| star.v_mag).collect();
        assert_eq!(magnitudes.len(), 5044);
        assert_eq!(bright_stars().filter(|star| star.name.is_some()).count(), 31);
        assert!(magnitudes.iter().all(|v_mag| (-1.5..=6.0).contains(v_mag)));
    }
}
