//! Positions of deep-sky objects by name: Messier, Caldwell, and their NGC and IC numbers.

use std::collections::BTreeSet;

use super::{Direction, Gcrs};
use crate::error::{Error, ErrorKind};
use crate::message::Quoted;

/// Table of `names separated by |;right ascension;declination`, degrees; the head of the file names its source.
const TABLE: &str = include_str!("deep_sky.csv");
/// Number of letters from which the beginning of a name is recognized, and largest number of names with this beginning
/// in an error.
const LEAST_LETTERS: usize = 3;
const MOST_SIMILAR: usize = 4;

/// Returns the direction of a deep-sky object by one of its names (`M31`, `Messier 31`, `C14`, `NGC 224`, `Andromeda
/// Galaxy`); case, blanks and punctuation are ignored. Centres of extended objects are good to some arcminutes.
///
/// # Errors
/// The name is not in the table; the error lists the names that begin with it.
pub fn deep_sky_object(name: &str) -> Result<Direction<Gcrs>, Error> {
    let key = key_of(name);
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let key = match (key.strip_prefix("messier"), key.strip_prefix('c').filter(|text| is_number(text))) {
        (Some(number), _) => format!("m{number}"),
        (_, Some(number)) => format!("caldwell{number}"),
        _ => key,
    };
    let found = rows().find_map(|line| {
        let mut fields = line.split(';');
        let is_named = fields.next()?.split('|').any(|known| key_of(known) == key);
        let mut radians = || Some(fields.next()?.parse::<f64>().ok()?.to_radians());
        is_named.then(|| Some(Direction::from_lon_lat_rad(radians()?, radians()?)))?
    });
    found.ok_or_else(|| {
        let error = Error::new(
            ErrorKind::Invalid,
            match &names_from(&key)[..] {
                [] => format!("unknown target '{}'", Quoted::new(name)),
                similar => format!("unknown target '{}'; similar names: {}", Quoted::new(name), similar.join(", ")),
            },
        );
        error.allowing("Messier, Caldwell, and their NGC and IC numbers and names (M31, NGC 224), or --ra and --dec")
    })
}

fn rows() -> impl Iterator<Item = &'static str> {
    TABLE.lines().filter(|line| !line.starts_with('#'))
}

/// Returns the names that begin with this key. Numbers of catalogues have no beginnings: M 1 is not similar to M 10.
fn names_from(key: &str) -> Vec<String> {
    if key.chars().count() < LEAST_LETTERS || key.ends_with(|mark: char| mark.is_ascii_digit()) {
        return Vec::new();
    }
    let names = rows().filter_map(|line| line.split(';').next()).flat_map(|names| names.split('|'));
    // Some objects share a name.
    let similar: BTreeSet<&str> = names.filter(|known| key_of(known).starts_with(key)).collect();
    similar.into_iter().take(MOST_SIMILAR).map(str::to_owned).collect()
}

fn key_of(name: &str) -> String {
    name.chars().filter(|mark| mark.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_every_spelling() {
        let andromeda = deep_sky_object("M31").unwrap();
        for name in ["m 31", "Messier 31", "NGC224", "Andromeda galaxy"] {
            assert_eq!(deep_sky_object(name).unwrap(), andromeda, "{name}");
        }
        assert_eq!(deep_sky_object("C 14").unwrap(), deep_sky_object("Caldwell 14").unwrap());
        let error = |name: &str| deep_sky_object(name).unwrap_err().to_string();
        for name in ["M111", "NGC 22", "Pegasus", "O"] {
            assert!(error(name).contains(&format!("'{name}'; allowed: ")) && error(name).contains("--ra"), "{name}");
        }
        for (name, similar) in [
            ("andromeda", "Andromeda Galaxy"),
            ("Owl", "Owl Cluster, Owl Nebula"),
            ("Veil", "Veil Nebula"),
            ("47 Tuc", "47 Tucanae"),
        ] {
            let expected = format!("unknown target '{name}'; similar names: {similar}; allowed: Messier");
            assert!(error(name).starts_with(&expected), "{}", error(name));
        }
    }

    #[test]
    fn every_messier_and_caldwell_object_has_a_position() {
        let all =
            (1..=110).map(|number| format!("M{number}")).chain((1..=109).map(|number| format!("Caldwell {number}")));
        for name in all {
            assert!(deep_sky_object(&name).is_ok(), "{name}");
        }
    }

    /// Positions in SIMBAD, degrees.
    #[test]
    fn valid_positions_of_galaxies() {
        // Tolerance: tables of galaxies' centres differ by some arcseconds.
        const TOLERANCE_DEG: f64 = 0.01;
        for (name, ra_deg, dec_deg) in
            [("M31", 10.684_708, 41.268_75), ("M87", 187.705_93, 12.391_123), ("M104", 189.997_633, -11.623_054)]
        {
            let expected = Direction::from_lon_lat_rad(f64::to_radians(ra_deg), f64::to_radians(dec_deg));
            let apart_rad = deep_sky_object(name).unwrap().separation_rad(&expected);
            assert!(apart_rad.to_degrees() < TOLERANCE_DEG, "{name}: {} deg", apart_rad.to_degrees());
        }
    }
}
