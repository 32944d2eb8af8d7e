//! Simulated constellations: Walker shells as element sets for any epoch, marked as synthetic.
//!
//! A shell of P planes with S satellites each (T = P·S satellites) and phasing F, in Walker's notation i: T/P/F (1984),
//! has
//!
//! ```text
//! Ω_p  = Ω₀ + p · spread / P                                  p = 0 … P−1
//! u_ps = u₀ + 360° · s / S + 360° · F · p / T                 s = 0 … S−1
//! ```
//!
//! where Ω is the right ascension of the ascending node, u the mean argument of latitude, and `spread` is 360° (Walker
//! delta) or 180° (Walker star, polar shells). The orbits are circular, without drag (B* = 0), and their mean radius in
//! SGP4 is the Earth's equatorial radius (6378.137 km) plus the altitude of the shell. Ω₀ and u₀ hold at
//! 2000-01-01T12:00:00 UTC, and both angles change with SGP4's secular rates. Element sets of one constellation for two
//! epochs therefore describe the same satellites: propagated to a common time, they agree within kilometres.
//!
//! The positions do not correspond to real satellites: counts and statistics are meaningful, single crossings are not.

use std::f64::consts::TAU;
use std::sync::Arc;

use hifitime::{Duration, Epoch, TimeScale};
use serde::Deserialize;

use super::element_set::{ElementSet, NoradId, Origin};
use super::epoch::DAY_NS;
use super::error::ElementsError;
use super::on_station::{mean_motion_for_radius, secular_rates_rad_day};
use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;

/// Bundled constellations, with their sources.
const EMBEDDED: &str = include_str!("shells.toml");

/// First catalogue number of simulated satellites. Each constellation has a block of a million numbers.
pub const FIRST_SYNTHETIC_ID: u32 = 900_000_000;
/// First catalogue number of user-defined constellations.
const FIRST_OWN_ID: u32 = 950_000_000;
/// Catalogue numbers reserved for one constellation.
const ID_BLOCK: u32 = 1_000_000;

/// Shell: circular orbits of one altitude and inclination in evenly spaced planes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shell {
    /// Mean altitude above the equatorial radius, km, 120 to 5,500 (SGP4's near-Earth theory).
    pub altitude_km: f64,
    /// Inclination, degrees, [0, 180].
    pub inclination_deg: f64,
    /// Number of planes P.
    pub planes: u32,
    /// Number of satellites in each plane, S.
    pub satellites_per_plane: u32,
    /// Walker's phasing F: adjacent planes are shifted by 360° F / T.
    #[serde(default = "one")]
    pub phasing: u32,
    /// Arc over which the ascending nodes are distributed, degrees: 360 (Walker delta) or 180 (Walker star).
    #[serde(default = "full_circle")]
    pub node_spread_deg: f64,
    /// Right ascension of the ascending node of the first plane at 2000-01-01T12:00:00 UTC, degrees.
    #[serde(default)]
    pub node_offset_deg: f64,
    /// Mean argument of latitude of the first satellite at 2000-01-01T12:00:00 UTC, degrees.
    #[serde(default)]
    pub phase_offset_deg: f64,
}

fn one() -> u32 {
    1
}

fn full_circle() -> f64 {
    360.0
}

/// Named constellation: a set of shells with the source of its numbers.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Constellation {
    /// Name, such as `starlink-gen1`.
    pub name: String,
    /// Source of the numbers.
    pub source: String,
    /// The shells.
    pub shells: Vec<Shell>,
    /// Catalogue number of the first satellite.
    pub first_id: NoradId,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    constellation: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    #[serde(default)]
    source: String,
    satellites: Option<u64>,
    shell: Vec<Shell>,
}

impl Constellation {
    /// Returns the bundled constellations.
    pub fn embedded() -> Vec<Self> {
        // Parsing cannot fail: the text is part of the library, and a test parses it.
        parse(EMBEDDED, FIRST_SYNTHETIC_ID).unwrap_or_default()
    }

    /// Returns the bundled constellation with this name; case is ignored.
    ///
    /// # Errors
    /// The name is unknown. The error lists the known names.
    pub fn by_name(name: &str) -> Result<Self, ElementsError> {
        let mut all = Self::embedded();
        match all.iter().position(|constellation| constellation.name.eq_ignore_ascii_case(name.trim())) {
            Some(at) => Ok(all.swap_remove(at)),
            None => {
                let known: Vec<_> = all.into_iter().map(|constellation| constellation.name).collect();
                Err(ElementsError::UnknownShells { name: name.into(), known: known.join(", ") })
            }
        }
    }

    /// Parses constellations from TOML.
    ///
    /// ```
    /// use streakcast::elements::Constellation;
    ///
    /// let mine = Constellation::from_toml(r#"
    ///     [[constellation]]
    ///     name = "mine"
    ///     source = "example"
    ///     [[constellation.shell]]
    ///     altitude_km = 800
    ///     inclination_deg = 86.4
    ///     planes = 6
    ///     satellites_per_plane = 11
    ///     phasing = 2
    ///     node_spread_deg = 180
    /// "#)?;
    /// assert_eq!(mine[0].satellites(), 66);
    /// # Ok::<(), streakcast::elements::ElementsError>(())
    /// ```
    ///
    /// The keys are those of [`Shell`]. `satellites` in a `[[constellation]]` states the total, which is checked.
    ///
    /// # Errors
    /// * The TOML is invalid, or a key is missing or unknown.
    /// * A number is out of range, or the stated total is not the sum of the shells.
    pub fn from_toml(text: &str) -> Result<Vec<Self>, ElementsError> {
        parse(text, FIRST_OWN_ID)
    }

    /// Returns the total number of satellites.
    pub fn satellites(&self) -> usize {
        self.shells.iter().map(|shell| shell.planes as usize * shell.satellites_per_plane as usize).sum()
    }

    /// Returns the element sets of all satellites at an epoch, in the order of shells, planes and satellites.
    ///
    /// Catalogue numbers start at [`first_id`](Self::first_id). Names have the form `STARLINK-GEN1-S1 P03-07
    /// (synthetic)`, with shell, plane and satellite counted from 1. The origin is [`Origin::Synthetic`].
    pub fn element_sets(&self, epoch: Epoch) -> Vec<ElementSet> {
        let epoch = epoch.to_time_scale(TimeScale::UTC);
        let days = days_since_reference(epoch);
        let prefix = self.name.to_ascii_uppercase();
        let mut sets = Vec::with_capacity(self.satellites());
        for (number, shell) in self.shells.iter().enumerate() {
            let inclination = shell.inclination_deg.to_radians();
            let mean_motion = mean_motion_for_radius(EARTH_EQUATORIAL_RADIUS_KM + shell.altitude_km, inclination);
            let (node_rate, latitude_rate) = secular_rates_rad_day(mean_motion, inclination);
            let node_drift = (node_rate * days).rem_euclid(TAU).to_degrees();
            let phase_drift = (latitude_rate * days).rem_euclid(TAU).to_degrees();
            let (planes, per_plane) = (f64::from(shell.planes), f64::from(shell.satellites_per_plane));
            for plane in 0..shell.planes {
                let p = f64::from(plane);
                // Ω_p = Ω₀ + p spread / P
                let node = shell.node_offset_deg + node_drift + p * shell.node_spread_deg / planes;
                for satellite in 0..shell.satellites_per_plane {
                    // u_ps = u₀ + 360° s / S + 360° F p / T
                    let phase = shell.phase_offset_deg
                        + phase_drift
                        + 360.0 * f64::from(satellite) / per_plane
                        + 360.0 * f64::from(shell.phasing) * p / (planes * per_plane);
                    let name = format!("{prefix}-S{} P{:02}-{:02} (synthetic)", number + 1, plane + 1, satellite + 1);
                    sets.push(ElementSet {
                        norad_id: NoradId(self.first_id.0 + sets.len() as u32),
                        name: Arc::from(name),
                        international_designator: Arc::default(),
                        epoch,
                        mean_motion_rev_day: mean_motion,
                        eccentricity: 0.0,
                        inclination_deg: shell.inclination_deg,
                        right_ascension_of_node_deg: node.rem_euclid(360.0),
                        argument_of_perigee_deg: 0.0,
                        mean_anomaly_deg: phase.rem_euclid(360.0),
                        bstar_per_earth_radius: 0.0,
                        mean_motion_dot_rev_day2: 0.0,
                        mean_motion_ddot_rev_day3: 0.0,
                        revolution_at_epoch: 0,
                        decayed: None,
                        origin: Origin::Synthetic,
                    });
                }
            }
        }
        sets
    }
}

/// Returns the time from 2000-01-01T12:00:00 UTC to an epoch in days of 86,400 s. Leap seconds are not counted, as in
/// SGP4.
fn days_since_reference(epoch: Epoch) -> f64 {
    // 36,524.5 days from 1900-01-01T00:00:00, the zero of hifitime's UTC, to the reference.
    let reference = i128::from(DAY_NS) * 73_049 / 2;
    Duration::from_total_nanoseconds(epoch.to_utc_duration().total_nanoseconds() - reference)
        .to_unit(hifitime::Unit::Day)
}

fn parse(text: &str, first_id: u32) -> Result<Vec<Constellation>, ElementsError> {
    let file: File =
        toml::from_str(text).map_err(|error| ElementsError::ShellSyntax(crate::input::toml_error(&error, text)))?;
    // The blocks of catalogue numbers must end below 1,000,000,000.
    if file.constellation.len() > 49 {
        return Err(ElementsError::ShellSyntax(format!(
            "{} constellations; allowed: at most 49",
            file.constellation.len()
        )));
    }
    file.constellation
        .into_iter()
        .zip((first_id..).step_by(ID_BLOCK as usize))
        .map(|(entry, first_id)| checked(entry, first_id))
        .collect()
}

fn checked(entry: Entry, first_id: u32) -> Result<Constellation, ElementsError> {
    for (at, shell) in entry.shell.iter().enumerate() {
        let ranges = [
            ("altitude_km", shell.altitude_km, 120.0..=5500.0, "120 to 5500 km"),
            ("inclination_deg", shell.inclination_deg, 0.0..=180.0, "0 to 180 deg"),
            ("planes", f64::from(shell.planes), 1.0..=1e6, "1 to 1000000"),
            ("satellites_per_plane", f64::from(shell.satellites_per_plane), 1.0..=1e6, "1 to 1000000"),
            ("node_spread_deg", shell.node_spread_deg, 0.0..=360.0, "0 to 360 deg"),
            ("node_offset_deg", shell.node_offset_deg, -360.0..=360.0, "-360 to 360 deg"),
            ("phase_offset_deg", shell.phase_offset_deg, -360.0..=360.0, "-360 to 360 deg"),
        ];
        for (field, value, range, allowed) in ranges {
            if !range.contains(&value) {
                return Err(ElementsError::ShellOutOfRange { name: entry.name, shell: at + 1, field, value, allowed });
            }
        }
    }
    let sum: u64 =
        entry.shell.iter().map(|shell| u64::from(shell.planes) * u64::from(shell.satellites_per_plane)).sum();
    let stated = entry.satellites.unwrap_or(sum);
    if stated != sum || sum == 0 || sum >= u64::from(ID_BLOCK) {
        return Err(ElementsError::ShellTotal { name: entry.name, stated, sum });
    }
    Ok(Constellation { name: entry.name, source: entry.source, shells: entry.shell, first_id: NoradId(first_id) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_the_embedded_constellations_are_as_filed() {
        let all = parse(EMBEDDED, FIRST_SYNTHETIC_ID).expect("the embedded file is good");
        let totals: Vec<_> =
            all.iter().map(|constellation| (constellation.name.as_str(), constellation.satellites())).collect();
        assert_eq!(
            totals,
            [
                ("starlink-gen1", 4408),
                ("starlink-gen2", 29_988),
                ("oneweb", 6372),
                ("kuiper", 3236),
                ("qianfan", 1296),
                ("guowang", 12_992)
            ]
        );
        assert!(all.iter().all(|constellation| !constellation.source.is_empty()));
    }

    #[test]
    fn verif_errors_contain_the_allowed_values() {
        let shell = |text: &str| {
            Constellation::from_toml(&format!("[[constellation]]\nname = \"x\"\nshell = [{{ {text} }}]"))
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            shell("altitude_km = 50, inclination_deg = 53, planes = 1, satellites_per_plane = 1"),
            "constellation \"x\", shell 1: altitude_km 50 is out of range: allowed 120 to 5500 km"
        );
        assert!(
            shell("altitude_km = 550, inclination_deg = 53, planes = 0, satellites_per_plane = 1").contains("planes")
        );
        assert!(shell("altitude = 550").contains("unknown field `altitude`"));
        assert_eq!(
            Constellation::by_name("starling").unwrap_err().to_string(),
            "unknown shells \"starling\": expected one of starlink-gen1, starlink-gen2, oneweb, kuiper, qianfan, guowang"
        );
    }
}
