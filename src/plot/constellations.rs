//! Lines of constellations between stars.

use crate::frames::{Direction, Gcrs};

/// Table of `name,chains`; the head of the file names its source.
const TABLE: &str = include_str!("constellations.csv");

/// Constellation with its lines.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Constellation {
    /// Latin name.
    pub name: &'static str,
    /// Chains of stars joined by lines, ICRS at epoch J2000, rounded to 0.01 degrees; two stars or more each. The first
    /// chain is the main part of the figure.
    pub chains: Vec<Vec<Direction<Gcrs>>>,
}

/// Returns the 80 constellations that have lines; the others have no figure of bright stars.
pub(super) fn constellations() -> impl Iterator<Item = Constellation> {
    TABLE.lines().filter(|line| !line.starts_with('#')).filter_map(|line| {
        let (name, chains) = line.split_once(',')?;
        Some(Constellation { name, chains: chains.split(';').map(chain).collect() })
    })
}

/// Reads the positions of a chain: right ascensions and declinations in turn, degrees.
fn chain(text: &str) -> Vec<Direction<Gcrs>> {
    let degrees: Vec<f64> = text.split(' ').map_while(|number| number.parse().ok()).collect();
    let (positions, _) = degrees.as_chunks();
    positions.iter().map(|[ra, dec]| Direction::from_lon_lat_rad(ra.to_radians(), dec.to_radians())).collect()
}

#[cfg(test)]
mod tests {
    use super::super::bright_stars::bright_stars;
    use super::*;

    /// Every line joins two stars of the table of bright stars that are less than 26 degrees apart.
    #[test]
    fn verif_lines_join_stars() {
        // Tolerance: positions are rounded to 0.01 degrees.
        const TOLERANCE_RAD: f64 = 0.0002;
        const LONGEST_DEG: f64 = 26.0;
        let stars: Vec<_> = bright_stars().map(|star| star.direction).collect();
        let all: Vec<Constellation> = constellations().collect();
        assert_eq!(all.len(), 80);
        for Constellation { name, chains } in &all {
            for chain in chains {
                assert!(chain.len() > 1, "{name}");
                for position in chain {
                    assert!(stars.iter().any(|star| star.separation_rad(position) < TOLERANCE_RAD), "{name}");
                }
                for pair in chain.windows(2) {
                    let length_deg = pair[0].separation_rad(&pair[1]).to_degrees();
                    assert!((0.3..LONGEST_DEG).contains(&length_deg), "{name}: {length_deg}");
                }
            }
        }
    }

    /// The belt of Orion is in its figure, at the positions of SIMBAD.
    #[test]
    fn valid_the_belt_of_orion() {
        let orion = constellations().find(|constellation| constellation.name == "Orion").unwrap();
        for (ra_deg, dec_deg) in [(85.190, -1.943), (84.053, -1.202), (83.002, -0.299)] {
            let star = Direction::from_lon_lat_rad(f64::to_radians(ra_deg), f64::to_radians(dec_deg));
            assert!(orion.chains.iter().flatten().any(|corner| corner.separation_rad(&star).to_degrees() < 0.01));
        }
    }
}
