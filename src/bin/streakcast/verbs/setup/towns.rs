//! Towns with more than 15,000 people, of GeoNames: positions and time zones by name, and the town closest to a site.

use std::io::Read;

use flate2::read::GzDecoder;
use streakcast::geometry::Site;

/// Table by `tests/reference/make_towns.py`, which describes its form.
const TABLE: &[u8] = include_bytes!("towns.txt.gz");

/// Smallest similarity of two names for a suggestion.
const SIMILAR: f64 = 0.9;

/// One town.
#[derive(Clone, Debug, PartialEq)]
pub struct Town {
    /// Its name, and other names of it.
    names: Vec<String>,
    /// Code of the country, two letters.
    country: String,
    /// Time zone of the IANA database.
    pub time_zone: String,
    /// Latitude, degrees north.
    pub latitude_deg: f64,
    /// Longitude, degrees east.
    pub longitude_deg: f64,
    /// Thousands of people.
    population: u32,
}

impl Town {
    /// Returns the name with the code of the country: `Vienna, AT`.
    pub fn name(&self) -> String {
        format!("{}, {}", self.names[0], self.country)
    }

    /// Returns the distance from a site, km.
    pub fn distance_km(&self, site: &Site) -> f64 {
        let here = Site::new_deg("", self.latitude_deg, self.longitude_deg, 0.0);
        here.map_or(f64::INFINITY, |here| (here.itrs() - site.itrs()).norm_km())
    }
}

/// All towns.
pub struct Towns {
    towns: Vec<Town>,
    /// Pairs of letters: one with a mark, and the same without.
    letters: Vec<(char, char)>,
}

impl Towns {
    /// Reads the table that is part of the program.
    pub fn embedded() -> Self {
        let mut text = String::new();
        // The table is complete, so that reading does not fail.
        let _ = GzDecoder::new(TABLE).read_to_string(&mut text);
        let mut lines = text.lines().skip(1);
        let letters: Vec<char> = lines.next().unwrap_or_default().chars().collect();
        let (mut country, mut time_zone) = ("", "");
        let mut towns = Vec::new();
        for line in lines {
            let mut cells = line.split('\t');
            let names = cells.next().unwrap_or_default();
            let numbers: Vec<f64> = cells.filter_map(|cell| cell.parse().ok()).collect();
            match numbers[..] {
                [latitude_deg, longitude_deg, population] => towns.push(Town {
                    names: names.split('|').map(str::to_owned).collect(),
                    country: country.to_owned(),
                    time_zone: time_zone.to_owned(),
                    latitude_deg,
                    longitude_deg,
                    population: population as u32,
                }),
                _ => (country, time_zone) = line.split_once(' ').unwrap_or_default(),
            }
        }
        Self { towns, letters: letters.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect() }
    }

    /// Returns the towns with a name, the largest first: `Vienna`, or with the code of its country `Vienna, US`. Case
    /// and marks of letters are ignored.
    pub fn by_name(&self, name: &str) -> Vec<&Town> {
        let (name, country) = match name.rsplit_once(',') {
            Some((name, country)) => (name, Some(country.trim())),
            None => (name, None),
        };
        let key = self.key(name);
        let is_in = |town: &&Town| country.is_none_or(|country| country.eq_ignore_ascii_case(&town.country));
        let has_name = |town: &&Town| town.names.iter().any(|name| self.key(name) == key);
        let mut found: Vec<&Town> = self.towns.iter().filter(is_in).filter(has_name).collect();
        found.sort_by_key(|town| std::cmp::Reverse(town.population));
        found
    }

    /// Returns the names of up to three towns with a similar name.
    pub fn similar(&self, name: &str) -> Vec<String> {
        let key = self.key(name.split(',').next().unwrap_or_default());
        let similarity = |town: &Town| strsim::jaro_winkler(&self.key(&town.names[0]), &key);
        let mut near: Vec<(f64, &Town)> = self.towns.iter().map(|town| (similarity(town), town)).collect();
        near.retain(|(similarity, _)| *similarity > SIMILAR);
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        near.into_iter().take(3).map(|(_, town)| town.name()).collect()
    }

    /// Returns the town closest to a site.
    pub fn closest(&self, site: &Site) -> Option<&Town> {
        self.towns.iter().min_by(|a, b| a.distance_km(site).total_cmp(&b.distance_km(site)))
    }

    fn key(&self, name: &str) -> String {
        let plain = |letter| self.letters.iter().find(|(marked, _)| *marked == letter).map_or(letter, |pair| pair.1);
        let is_kept = |letter: &char| letter.is_alphanumeric();
        name.to_lowercase()
            .chars()
            .map(|letter| if letter.is_ascii() { letter } else { plain(letter) })
            .filter(is_kept)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn towns_by_name_and_country() {
        let towns = Towns::embedded();
        assert_eq!(towns.towns.len(), 34_006);
        let found = |name: &str| towns.by_name(name).first().map(|town| town.name()).unwrap_or_default();
        for (name, expected) in [
            ("Vienna", "Vienna, AT"),
            ("wien", "Vienna, AT"),
            ("vienna,us", "Vienna, US"),
            ("zurich", "Zürich, CH"),
            ("Zürich", "Zürich, CH"),
            ("Nowhere at all", ""),
            ("Vienna, FR", ""),
        ] {
            assert_eq!(found(name), expected, "{name}");
        }
        assert!(towns.similar("Vienn").contains(&"Vienna, AT".to_owned()), "{:?}", towns.similar("Vienn"));
    }

    /// All time zones of the table are in the database of the program.
    #[test]
    fn time_zones_exist() {
        for town in &Towns::embedded().towns {
            assert!(crate::local_time::local_time(&town.time_zone).is_ok(), "{town:?}");
        }
    }

    #[test]
    fn the_closest_town_has_the_time_zone_of_a_site() {
        let towns = Towns::embedded();
        let zone = |lat, lon| {
            let site = Site::new_deg("", lat, lon, 0.0).unwrap();
            towns.closest(&site).map(|town| town.time_zone.as_str())
        };
        assert_eq!(zone(-30.24, -70.75), Some("America/Santiago"));
        assert_eq!(zone(28.76, -17.88), Some("Atlantic/Canary"));
    }
}
