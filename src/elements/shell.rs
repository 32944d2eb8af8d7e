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
//! epochs therefore describe the same satellites: propagated to a common time, they agree within kilometres. Shells
//! above 5,800 km are propagated with SDP4; Moon and Sun turn their planes by degrees in years, which these rates omit.
//!
//! The first node of a sun-synchronous shell may be given by its local mean solar time, which then holds at any epoch.
//!
//! The positions do not correspond to real satellites: counts and statistics are meaningful, single crossings are not.

use std::f64::consts::TAU;
use std::fmt;
use std::sync::{Arc, LazyLock};

use hifitime::{Duration, Epoch, TimeScale};
use serde::Deserialize;
use serde::de::{Deserializer, SeqAccess, Visitor};
use toml::value::Datetime;

use super::element_set::{ElementSet, NoradId, Origin};
use super::epoch::DAY_NS;
use super::on_station::{mean_motion_for_radius, secular_rates_rad_day};
use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::error::Error;
use crate::message::Quoted;

/// Bundled constellations, with their sources.
const EMBEDDED: &str = include_str!("shells.toml");

/// The same, parsed once. Parsing cannot fail: the text is part of the library, and a test parses it.
static BUNDLED: LazyLock<ShellFile> =
    LazyLock::new(|| parse(EMBEDDED, FIRST_SYNTHETIC_ID, ID_BLOCK).unwrap_or_default());

/// First catalogue number of simulated satellites. Each bundled constellation begins at a multiple of a million.
pub const FIRST_SYNTHETIC_ID: u32 = 900_000_000;
/// First catalogue number of user-defined constellations, which follow one another without gaps.
const FIRST_OWN_ID: u32 = 950_000_000;
/// Multiple at which bundled constellations begin, so that a new one does not change the numbers of the others.
const ID_BLOCK: u32 = 1_000_000;
/// Right ascension of the mean Sun at 2000-01-01T12:00:00 UTC, degrees, and its rate, degrees a day (USNO, approximate
/// solar coordinates).
const MEAN_SUN_DEG: f64 = 280.460;
const MEAN_SUN_DEG_DAY: f64 = 0.985_647_4;
/// Largest number of satellites of one constellation.
const MOST_SATELLITES: u64 = 10_000_000;
/// Largest number of satellites of all user-defined constellations: their numbers end below 1,000,000,000.
const MOST_IN_ALL: u64 = 49_999_999;
/// Largest number of constellations in a file.
const MOST_CONSTELLATIONS: usize = 200;

/// Shell: circular orbits of one altitude and inclination in evenly spaced planes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Shell {
    /// Mean altitude above the equatorial radius, km, 120 to 40,000.
    pub altitude_km: f64,
    /// Inclination, degrees, [0, 180].
    pub inclination_deg: f64,
    /// Number of planes P.
    pub planes: u32,
    /// Number of satellites in each plane, S.
    pub satellites_per_plane: u32,
    /// Walker's phasing F: adjacent planes are shifted by 360° F / T.
    pub phasing: u32,
    /// Arc over which the ascending nodes are distributed, degrees: 360 (Walker delta) or 180 (Walker star).
    pub node_spread_deg: f64,
    /// Right ascension of the ascending node of the first plane at 2000-01-01T12:00:00 UTC, degrees.
    pub node_offset_deg: f64,
    /// Local mean solar time of the ascending node of the first plane at any epoch, hours, [0, 24), in place of
    /// `node_offset_deg`; for sun-synchronous shells.
    pub node_local_time_h: Option<f64>,
    /// Mean argument of latitude of the first satellite at 2000-01-01T12:00:00 UTC, degrees.
    pub phase_offset_deg: f64,
    /// True if no source has the planes of this shell, so that `planes` and `satellites_per_plane` are assumed; only
    /// their product is known.
    pub planes_assumed: bool,
}

impl Shell {
    /// Returns the number of satellites of all planes.
    fn planned(&self) -> usize {
        self.planes as usize * self.satellites_per_plane as usize
    }

    /// Returns the satellites that are in orbit if `deployed` of them are, as pairs of plane and satellite, from 0, in
    /// order: as few planes as possible, evenly distributed. The last of them may be incomplete; its satellites are
    /// evenly distributed.
    fn in_orbit(&self, deployed: usize) -> impl Iterator<Item = (u32, u32)> {
        let (planes, per_plane) = (self.planes, self.satellites_per_plane);
        let in_use = deployed.div_ceil(per_plane as usize) as u32;
        let incomplete = (deployed % per_plane as usize) as u32;
        let of_plane = move |(number, plane): (u32, u32)| {
            let count = if number + 1 == in_use && incomplete > 0 { incomplete } else { per_plane };
            spread(count, per_plane).map(move |satellite| (plane, satellite))
        };
        (0..).zip(spread(in_use, planes)).flat_map(of_plane)
    }
}

/// Returns `count` evenly distributed numbers below `of`, in order.
fn spread(count: u32, of: u32) -> impl Iterator<Item = u32> {
    // ⌊(i + 1) n / N⌋ > ⌊i n / N⌋ for n of N numbers
    let before = move |number: u32| u64::from(number) * u64::from(count) / u64::from(of);
    (0..of).filter(move |&number| before(number + 1) > before(number))
}

/// Shells of a file: one for each combination of altitude and inclination.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Shells {
    #[serde(deserialize_with = "numbers")]
    altitude_km: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    inclination_deg: Vec<f64>,
    planes: u32,
    satellites_per_plane: u32,
    #[serde(default = "one")]
    phasing: u32,
    #[serde(default = "full_circle")]
    node_spread_deg: f64,
    #[serde(default)]
    node_offset_deg: f64,
    node_local_time_h: Option<f64>,
    #[serde(default)]
    phase_offset_deg: f64,
    #[serde(default)]
    planes_assumed: bool,
}

impl Shells {
    /// Returns one shell with its nodes shifted by an angle, degrees.
    fn with_shifted_nodes(shell: &Shell, shift_deg: f64) -> Self {
        Self {
            altitude_km: vec![shell.altitude_km],
            inclination_deg: vec![shell.inclination_deg],
            planes: shell.planes,
            satellites_per_plane: shell.satellites_per_plane,
            phasing: shell.phasing,
            node_spread_deg: shell.node_spread_deg,
            node_offset_deg: match shell.node_local_time_h {
                Some(_) => 0.0,
                None => (shell.node_offset_deg + shift_deg) % 360.0,
            },
            node_local_time_h: shell.node_local_time_h.map(|hours| (hours + shift_deg / 15.0) % 24.0),
            phase_offset_deg: shell.phase_offset_deg,
            planes_assumed: shell.planes_assumed,
        }
    }

    fn each(&self) -> impl Iterator<Item = Shell> + '_ {
        let pairs = self
            .altitude_km
            .iter()
            .flat_map(|&altitude| self.inclination_deg.iter().map(move |&inclination| (altitude, inclination)));
        pairs.map(|(altitude_km, inclination_deg)| Shell {
            altitude_km,
            inclination_deg,
            planes: self.planes,
            satellites_per_plane: self.satellites_per_plane,
            phasing: self.phasing,
            node_spread_deg: self.node_spread_deg,
            node_offset_deg: self.node_offset_deg,
            node_local_time_h: self.node_local_time_h,
            phase_offset_deg: self.phase_offset_deg,
            planes_assumed: self.planes_assumed,
        })
    }
}

/// Reads a number or a list of numbers.
fn numbers<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    struct Numbers;
    impl<'de> Visitor<'de> for Numbers {
        type Value = Vec<f64>;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("a number or a list of numbers, at least one")
        }

        fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<Vec<f64>, E> {
            Ok(vec![number])
        }

        fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Vec<f64>, E> {
            Ok(vec![number as f64])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<f64>, A::Error> {
            let mut numbers = Vec::new();
            while let Some(number) = list.next_element()? {
                numbers.push(number);
            }
            if numbers.is_empty() { Err(serde::de::Error::invalid_length(0, &self)) } else { Ok(numbers) }
        }
    }
    deserializer.deserialize_any(Numbers)
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
    /// Fraction of the satellites that are in orbit, 0 to 1, in evenly distributed planes of each shell. The total is
    /// rounded to one satellite, and remainders are carried over from shell to shell.
    pub deployed_fraction: f64,
}

/// Named selection of bundled constellations, such as `planned-2026`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct ConstellationSet {
    /// Name.
    pub name: String,
    /// Description with date.
    pub source: String,
    /// Names of the constellations.
    pub constellations: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    constellation: Vec<Entry>,
    #[serde(default)]
    set: Vec<ConstellationSet>,
    #[serde(default)]
    period: Vec<PeriodEntry>,
}

/// Constellations, sets of them, and periods of a file.
#[derive(Debug, Default)]
pub(super) struct ShellFile {
    pub constellations: Vec<Constellation>,
    pub periods: Vec<PeriodEntry>,
    sets: Vec<ConstellationSet>,
}

/// `[[period]]` of a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PeriodEntry {
    pub from: Datetime,
    /// File of element sets, or list of files.
    pub elements: Option<toml::Value>,
    /// Fractions by name.
    pub shells: Option<toml::Table>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    #[serde(default)]
    source: String,
    satellites: Option<u64>,
    #[serde(default)]
    shell: Vec<Shells>,
    /// Name of a constellation before this one with the same shells, whose planes lie midway between those of this one.
    shells_of: Option<String>,
}

impl Constellation {
    /// Returns the bundled constellations.
    pub fn embedded() -> Vec<Self> {
        BUNDLED.constellations.clone()
    }

    /// Returns the bundled sets of constellations.
    #[doc(hidden)]
    pub fn embedded_sets() -> Vec<ConstellationSet> {
        BUNDLED.sets.clone()
    }

    /// Returns the bundled constellation with this name, or those of the bundled set with this name; case is ignored.
    ///
    /// # Errors
    /// The name is unknown. The error lists the known names.
    pub fn by_name_or_set(name: &str) -> Result<Vec<Self>, Error> {
        match BUNDLED.sets.iter().find(|set| set.name.eq_ignore_ascii_case(name.trim())) {
            Some(set) => set.constellations.iter().map(|name| Self::by_name(name)).collect(),
            None => Ok(vec![Self::by_name(name)?]),
        }
    }

    /// Returns the bundled constellation with this name; case is ignored.
    ///
    /// # Errors
    /// The name is unknown. The error lists the known names.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let ShellFile { constellations, sets, .. } = &*BUNDLED;
        constellations
            .iter()
            .find(|constellation| constellation.name.eq_ignore_ascii_case(name.trim()))
            .cloned()
            .ok_or_else(|| {
                let names = constellations
                    .iter()
                    .map(|constellation| constellation.name.as_str())
                    .chain(sets.iter().map(|set| set.name.as_str()));
                Error::format(format!(
                    "unknown shells {:?}: expected one of {}",
                    Quoted::new(name),
                    names.collect::<Vec<_>>().join(", ")
                ))
            })
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
    /// # Ok::<(), streakcast::Error>(())
    /// ```
    ///
    /// The keys are those of [`Shell`]. `altitude_km` and `inclination_deg` may be lists; then there is a shell for
    /// each combination. `satellites` in a `[[constellation]]` states the total, which is checked. `shells_of`, in
    /// place of shells, is the name of a constellation before it in the file: its shells are repeated, with the planes
    /// midway between. A file has at most 200 constellations, each of at most 10 million satellites. Tables
    /// `[[period]]` are not returned.
    ///
    /// # Errors
    /// * The TOML is invalid, or a key is missing or unknown.
    /// * A number is out of range, or the stated total is not the sum of the shells.
    pub fn from_toml(text: &str) -> Result<Vec<Self>, Error> {
        Ok(ShellFile::from_toml(text)?.constellations)
    }

    /// Gives the satellites of user-defined constellations of several files numbers that follow one another.
    ///
    /// # Errors
    /// There are more than 49,999,999 satellites.
    pub fn number_own<'a>(own: impl Iterator<Item = &'a mut Self>) -> Result<(), Error> {
        let mut count = 0;
        for constellation in own {
            constellation.first_id = NoradId(FIRST_OWN_ID + count as u32);
            count += constellation.planned_satellites() as u64;
            if count > MOST_IN_ALL {
                return Err(too_many_in_all());
            }
        }
        Ok(())
    }

    /// Returns the number of deployed satellites in all shells.
    pub fn satellites(&self) -> usize {
        self.deployed().sum()
    }

    /// Returns the number of deployed satellites in shells of which no source has the planes.
    #[doc(hidden)]
    pub fn satellites_with_assumed_planes(&self) -> usize {
        let assumed = self.shells.iter().zip(self.deployed()).filter(|(shell, _)| shell.planes_assumed);
        assumed.map(|(_, deployed)| deployed).sum()
    }

    /// Returns the number of deployed satellites in each shell.
    fn deployed(&self) -> impl Iterator<Item = usize> {
        let (mut planned, mut before) = (0, 0);
        self.shells.iter().map(move |shell| {
            planned += shell.planned();
            // n_i = [f (T_1 + … + T_i)] - [f (T_1 + … + T_i-1)], so that the sum is f T, rounded
            let until = (self.deployed_fraction * planned as f64).round() as usize;
            let deployed = until - before;
            before = until;
            deployed
        })
    }

    /// Returns the number of satellites of all planes.
    fn planned_satellites(&self) -> usize {
        self.shells.iter().map(Shell::planned).sum()
    }

    /// Returns the element sets of all deployed satellites at an epoch, in the order of shells, planes and satellites.
    ///
    /// Catalogue numbers start at [`first_id`](Self::first_id), and satellites that are not deployed keep theirs. Names
    /// have the form `STARLINK-GEN1-S1 P03-07 (synthetic)`, with shell, plane and satellite counted from 1. The origin
    /// is [`Origin::Synthetic`].
    pub fn element_sets(&self, epoch: Epoch) -> Vec<ElementSet> {
        let epoch = epoch.to_time_scale(TimeScale::UTC);
        let days = days_since_reference(epoch);
        let prefix = self.name.to_ascii_uppercase();
        let mut sets = Vec::with_capacity(self.satellites());
        let mut shell_id = self.first_id.0;
        for (number, (shell, deployed)) in self.shells.iter().zip(self.deployed()).enumerate() {
            let inclination = shell.inclination_deg.to_radians();
            let mean_motion = mean_motion_for_radius(EARTH_EQUATORIAL_RADIUS_KM + shell.altitude_km, inclination);
            let (node_rate, latitude_rate) = secular_rates_rad_day(mean_motion, inclination);
            let node_drift = (node_rate * days).rem_euclid(TAU).to_degrees();
            let phase_drift = (latitude_rate * days).rem_euclid(TAU).to_degrees();
            let first_node = match shell.node_local_time_h {
                // The right ascension of the mean Sun plus the local time after noon.
                Some(hours) => MEAN_SUN_DEG + MEAN_SUN_DEG_DAY * days + 15.0 * (hours - 12.0),
                None => shell.node_offset_deg + node_drift,
            };
            let (planes, per_plane) = (f64::from(shell.planes), f64::from(shell.satellites_per_plane));
            for (plane, satellite) in shell.in_orbit(deployed) {
                let p = f64::from(plane);
                // Ω_p = Ω₀ + p spread / P
                let node = first_node + p * shell.node_spread_deg / planes;
                // u_ps = u₀ + 360° s / S + 360° F p / T
                let phase = shell.phase_offset_deg
                    + phase_drift
                    + 360.0 * f64::from(satellite) / per_plane
                    + 360.0 * f64::from(shell.phasing) * p / (planes * per_plane);
                let name = format!("{prefix}-S{} P{:02}-{:02} (synthetic)", number + 1, plane + 1, satellite + 1);
                sets.push(ElementSet {
                    norad_id: NoradId(shell_id + plane * shell.satellites_per_plane + satellite),
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
            shell_id += shell.planes * shell.satellites_per_plane;
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

impl ShellFile {
    /// Parses a file of the user.
    ///
    /// # Errors
    /// Same as [`Constellation::from_toml`].
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let file = parse(text, FIRST_OWN_ID, 1)?;
        if file.constellations.is_empty() && file.periods.is_empty() {
            let message = "the file has neither [[constellation]] nor [[period]]; allowed: at least one of them";
            return Err(in_constellations(message));
        }
        Ok(file)
    }
}

/// Reads constellations, sets and periods. Catalogue numbers begin at `first_id`, those of each constellation at a
/// multiple of `block` after it.
fn parse(text: &str, first_id: u32, block: u32) -> Result<ShellFile, Error> {
    let file: File =
        toml::from_str(text).map_err(|error| crate::input::toml_error(&error, text).at("constellation file"))?;
    let count = file.constellation.len();
    if count > MOST_CONSTELLATIONS {
        let message = format!("{count} constellations; allowed: at most {MOST_CONSTELLATIONS}");
        return Err(in_constellations(message));
    }
    let (mut all, mut used) = (Vec::with_capacity(count), 0);
    for mut entry in file.constellation {
        if all.iter().any(|other: &Constellation| other.name == entry.name) {
            let message = format!("constellation {:?} is twice in the file; allowed: different names", entry.name);
            return Err(in_constellations(message));
        }
        if let Some(name) = entry.shells_of.take() {
            entry.shell = midway(&all, &name, &entry)?;
        }
        let constellation = checked(entry, first_id + used as u32)?;
        used += (constellation.planned_satellites() as u64).next_multiple_of(u64::from(block));
        if used > MOST_IN_ALL {
            return Err(too_many_in_all());
        }
        all.push(constellation);
    }
    Ok(ShellFile { constellations: all, periods: file.period, sets: file.set })
}

/// Returns the shells of the constellation `name`, with planes midway between.
fn midway(all: &[Constellation], name: &str, entry: &Entry) -> Result<Vec<Shells>, Error> {
    let wrong = |what: String| in_constellations(format!("constellation {:?}: {what}", entry.name));
    if !entry.shell.is_empty() {
        return Err(wrong("shell and shells_of exclude each other; specify one of them".to_owned()));
    }
    let found = all
        .iter()
        .find(|constellation| constellation.name == name)
        .ok_or_else(|| wrong(format!("shells_of {name:?} is not the name of a constellation before it in the file")))?;
    Ok(found
        .shells
        .iter()
        .map(|shell| Shells::with_shifted_nodes(shell, 0.5 * shell.node_spread_deg / f64::from(shell.planes)))
        .collect())
}

fn checked(entry: Entry, first_id: u32) -> Result<Constellation, Error> {
    for (at, shell) in entry.shell.iter().enumerate() {
        if shell.node_local_time_h.is_some() && shell.node_offset_deg != 0.0 {
            return Err(in_constellations(format!(
                "constellation {:?}, shell {}: node_local_time_h and node_offset_deg exclude each other; specify one of them",
                entry.name,
                at + 1
            )));
        }
        let altitudes = shell.altitude_km.iter().map(|&km| ("altitude_km", km, 120.0..=40_000.0, "120 to 40000 km"));
        let inclinations =
            shell.inclination_deg.iter().map(|&deg| ("inclination_deg", deg, 0.0..=180.0, "0 to 180 deg"));
        let local_time = shell.node_local_time_h.map(|hours| ("node_local_time_h", hours, 0.0..=24.0, "0 to 24 hours"));
        let ranges = [
            ("planes", f64::from(shell.planes), 1.0..=1e6, "1 to 1000000"),
            ("satellites_per_plane", f64::from(shell.satellites_per_plane), 1.0..=1e6, "1 to 1000000"),
            ("node_spread_deg", shell.node_spread_deg, 0.0..=360.0, "0 to 360 deg"),
            ("node_offset_deg", shell.node_offset_deg, -360.0..=360.0, "-360 to 360 deg"),
            ("phase_offset_deg", shell.phase_offset_deg, -360.0..=360.0, "-360 to 360 deg"),
        ];
        for (field, value, range, allowed) in altitudes.chain(inclinations).chain(local_time).chain(ranges) {
            if !range.contains(&value) {
                return Err(Error::format(format!(
                    "constellation {:?}, shell {}: {field} {value} is out of range: allowed {allowed}",
                    Quoted::new(&entry.name),
                    at + 1
                )));
            }
        }
    }
    let satellites_of = |shell: &Shells| {
        let shells = (shell.altitude_km.len() * shell.inclination_deg.len()) as u64;
        // At most 10¹² for each shell; the lists of a file are too short for an overflow.
        shells.saturating_mul(u64::from(shell.planes) * u64::from(shell.satellites_per_plane))
    };
    let sum = entry.shell.iter().map(satellites_of).fold(0, u64::saturating_add);
    let stated = entry.satellites.unwrap_or(sum);
    if sum == 0 || sum > MOST_SATELLITES {
        return Err(Error::format(format!("constellation {:?} has {sum} satellites", Quoted::new(&entry.name)))
            .allowing(format!("1 to {MOST_SATELLITES}")));
    }
    if stated != sum {
        return Err(Error::format(format!(
            "constellation {:?} states {stated} satellites, but its shells have {sum}",
            Quoted::new(&entry.name)
        )));
    }
    let shells = entry.shell.iter().flat_map(Shells::each).collect();
    let first_id = NoradId(first_id);
    Ok(Constellation { name: entry.name, source: entry.source, shells, first_id, deployed_fraction: 1.0 })
}

/// Returns the error of invalid text of a file of constellations.
pub(super) fn in_constellations(problem: impl Into<String>) -> Error {
    Error::format(problem).at("constellation file")
}

/// All constellations together have too many satellites.
fn too_many_in_all() -> Error {
    Error::format(format!("the constellations of the files have more than {MOST_IN_ALL} satellites in all"))
        .allowing(format!("at most {MOST_IN_ALL}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_the_embedded_constellations_are_as_filed() {
        let all = parse(EMBEDDED, FIRST_SYNTHETIC_ID, ID_BLOCK).expect("the embedded file is good").constellations;
        // `satellites` of each constellation, which the parser compares with the sum, is the number of the filing.
        assert_eq!(all.len(), 30);
        assert!(EMBEDDED.matches("\nsatellites = ").count() == all.len());
        for set in Constellation::embedded_sets() {
            assert!(
                set.constellations.iter().all(|name| all.iter().any(|constellation| constellation.name == *name)),
                "{set:?}"
            );
        }
        assert!(all.iter().all(|constellation| !constellation.source.is_empty()));
    }

    fn assert_starts(text: &str, start: &str) {
        assert!(text.starts_with(start), "{text}");
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
            "constellation \"x\", shell 1: altitude_km 50 is out of range: allowed 120 to 40000 km"
        );
        assert!(
            shell("altitude_km = 550, inclination_deg = 53, planes = 0, satellites_per_plane = 1").contains("planes")
        );
        assert!(shell("altitude = 550").contains("unknown key 'altitude'"));
        let good = "inclination_deg = 53, planes = 1, satellites_per_plane = 1";
        assert!(shell(&format!("altitude_km = [], {good}")).contains("a list of numbers, at least one"));
        let both = format!("altitude_km = 550, node_local_time_h = 18, node_offset_deg = 77, {good}");
        assert!(shell(&both).contains("node_local_time_h and node_offset_deg exclude each other"));
        let text = format!("[[constellation]]\nname = \"x\"\nshell = [{{ altitude_km = 550, {good} }}]\n");
        let twice = Constellation::from_toml(&text.repeat(2)).unwrap_err().to_string();
        assert!(twice.contains("\"x\" is twice in the file"), "{twice}");
        assert_starts(
            &Constellation::by_name("starling").unwrap_err().to_string(),
            "unknown shells \"starling\": expected one of starlink-gen1, starlink-gen2, oneweb, kuiper, qianfan, guowang, starlink-gen2-remaining",
        );
    }
}
