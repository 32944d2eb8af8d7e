//! Standard magnitudes of the brightest objects: space stations, large payloads, and rocket bodies by class; and of
//! cubesats, which are much fainter than the satellites of unknown brightness.
//!
//! `bright_objects.csv` has the source of every magnitude. A row with a catalogue number is one object. A row without
//! one is a class: all rocket bodies of this name, where a stage number in parentheses is ignored, or, if it ends in
//! `*`, all satellites whose name begins with it. A row with `part_of` is a module of a station; its light is included
//! in the magnitude of that station.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::brightness::MagnitudeSource;
use super::magnitude::StandardMagnitude;
use super::model::BrightnessModel;

const TABLE: &str = include_str!("bright_objects.csv");

/// A bright object, or a class of rocket bodies or cubesats.
#[derive(Clone, Debug, PartialEq)]
pub struct BrightObject {
    /// Name of the object, or of the class as in catalogues: `SL-16 R/B`, `FLOCK*`.
    pub name: &'static str,
    /// NORAD catalogue number; `None` for a class.
    pub norad_id: Option<u32>,
    /// Magnitude at 1000 km and phase angle 90°, taken as V (Vega).
    pub half_lit: StandardMagnitude,
    /// One sigma of a single magnitude, mag.
    pub sigma_mag: f64,
    /// Typical size, m.
    pub size_m: f64,
    /// Origin of the magnitude.
    pub source: &'static str,
}

impl BrightObject {
    /// Returns the brightness model.
    pub fn model(&self) -> BrightnessModel {
        let source = match self.norad_id {
            Some(_) => MagnitudeSource::StandardMagnitude,
            None => MagnitudeSource::Mean(
                self.name.to_ascii_lowercase().replace(" r/b", "-rocket-body").replace('*', "-cubesat").into(),
            ),
        };
        BrightnessModel::of_object(self.half_lit, self.sigma_mag, source, self.size_m)
    }
}

/// The table of bright objects.
#[derive(Clone, Debug, Default)]
pub struct BrightObjects {
    objects: Vec<BrightObject>,
    /// Stations of modules, by the catalogue number of the module.
    modules: BTreeMap<u32, u32>,
}

static EMBEDDED: LazyLock<BrightObjects> = LazyLock::new(|| BrightObjects::parse(TABLE));

impl BrightObjects {
    /// Returns the table of the library.
    pub fn embedded() -> &'static Self {
        &EMBEDDED
    }

    /// Returns the objects and classes.
    pub fn iter(&self) -> impl Iterator<Item = &BrightObject> {
        self.objects.iter()
    }

    /// Returns the catalogue number of the station to which a module belongs.
    pub fn station_of(&self, norad_id: u32) -> Option<u32> {
        self.modules.get(&norad_id).copied()
    }

    /// Returns true for the main object of a space station, whose light includes its modules and docked spacecraft.
    pub fn is_station(&self, norad_id: u32) -> bool {
        self.modules.values().any(|station| *station == norad_id)
    }

    /// Returns the object with this catalogue number, or else the class of this name. A stage number in parentheses is
    /// ignored: `SL-12 R/B(2)` is of the class `SL-12 R/B`. Debris is of no class.
    pub fn get(&self, norad_id: u32, name: &str) -> Option<&BrightObject> {
        let class = name.split_once('(').map_or(name, |(class, stage)| {
            let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            if is_number(stage.trim_end().trim_end_matches(')')) { class } else { name }
        });
        let by_number = self.objects.iter().find(|object| object.norad_id == Some(norad_id));
        let is_of = |object: &&BrightObject| match object.name.strip_suffix('*') {
            Some(family) => name.starts_with(family) && !name.ends_with(" DEB"),
            None => object.norad_id.is_none() && object.name == class.trim_end(),
        };
        by_number.or_else(|| self.objects.iter().find(is_of))
    }

    /// Parses the rows; a test checks every one.
    fn parse(text: &'static str) -> Self {
        let mut table = Self::default();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let mut cells = line.splitn(7, ',');
            let mut next = || cells.next().unwrap_or_default();
            let (name, norad_id, part_of) = (next(), next().parse().ok(), next().parse().ok());
            if let (Some(module), Some(station)) = (norad_id, part_of) {
                table.modules.insert(module, station);
                continue;
            }
            if let (Ok(half_lit), Ok(sigma_mag), Ok(size_m), source) =
                (next().parse(), next().parse(), next().parse(), next())
            {
                let half_lit = StandardMagnitude(half_lit);
                table.objects.push(BrightObject { name, norad_id, half_lit, sigma_mag, size_m, source });
            }
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_every_row_is_read() {
        let rows = TABLE.lines().filter(|line| !line.starts_with('#')).count() - 1;
        let table = BrightObjects::embedded();
        assert_eq!(table.objects.len() + table.modules.len(), rows);
        for object in table.iter() {
            assert!((-3.0..10.0).contains(&object.half_lit.0) && (0.3..2.0).contains(&object.sigma_mag), "{object:?}");
            assert!(object.source.len() > 20 && !object.source.contains(','), "{object:?}");
        }
        for station in table.modules.values() {
            assert!(table.objects.iter().any(|object| object.norad_id == Some(*station)), "{station}");
        }
    }

    #[test]
    fn verif_objects_by_number_and_classes_by_name() {
        let table = BrightObjects::embedded();
        assert_eq!(table.get(25_544, "").unwrap().name, "ISS");
        assert_eq!(table.get(1, "SL-16 R/B").unwrap().name, "SL-16 R/B");
        assert_eq!(table.get(1, "SL-12 R/B(2)").unwrap().name, "SL-12 R/B");
        assert_eq!(table.get(1, "SL-12 R/B(AUX MOTOR)").unwrap().name, "SL-12 R/B(AUX MOTOR)");
        assert_eq!(table.get(1, "SL-16 DEB"), None);
        assert_eq!(table.get(1, "FLOCK 4P-12").unwrap().model().source().to_string(), "prior:flock-cubesat");
        assert_eq!(table.get(1, "FLOCK 4P-12 DEB"), None);
        assert_eq!(table.get(1, "A FLOCK"), None);
        assert_eq!(table.station_of(49_044), Some(25_544));
        assert!(table.is_station(48_274) && !table.is_station(49_044) && !table.is_station(20_580));
        assert_eq!(table.get(1, "SL-16 R/B").unwrap().model().source().to_string(), "prior:sl-16-rocket-body");
    }
}
