//! Element set: catalogue number, epoch and mean elements for SGP4, as published.

use std::fmt;
use std::sync::Arc;

use hifitime::Epoch;
use serde::{Deserialize, Serialize};

/// NORAD catalogue number of up to nine digits. It is displayed without padding.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NoradId(pub u32);

impl NoradId {
    /// Returns the name of the satellite, or this number if the name is empty.
    pub fn or_name(self, name: &str) -> String {
        if name.is_empty() { self.to_string() } else { name.to_owned() }
    }
}

impl fmt::Display for NoradId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// Mean elements for SGP4 in their published units (degrees, revolutions a day), in TEME (true equator and mean
/// equinox) of the epoch.
///
/// Numbers are stored as read, so that the same record in another format gives a bit-identical ephemeris.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementSet {
    /// Catalogue number.
    pub norad_id: NoradId,
    /// Name, without the leading "0 " of three-line files and without surrounding blanks; empty if omitted.
    pub name: Arc<str>,
    /// COSPAR designator in the form `1998-067A`; empty if omitted.
    pub international_designator: Arc<str>,
    /// Epoch of the elements (UTC in the files).
    pub epoch: Epoch,
    /// Mean motion (Kozai), revolutions a day.
    pub mean_motion_rev_day: f64,
    /// Eccentricity, [0, 1).
    pub eccentricity: f64,
    /// Inclination, degrees, [0, 180].
    pub inclination_deg: f64,
    /// Right ascension of the ascending node, degrees.
    pub right_ascension_of_node_deg: f64,
    /// Argument of perigee, degrees.
    pub argument_of_perigee_deg: f64,
    /// Mean anomaly, degrees.
    pub mean_anomaly_deg: f64,
    /// Drag term B* of SGP4, 1/earth radii.
    pub bstar_per_earth_radius: f64,
    /// Half the first derivative of the mean motion as published (SGP4 does not use it), revolutions/day².
    pub mean_motion_dot_rev_day2: f64,
    /// A sixth of the second derivative of the mean motion as published (SGP4 does not use it), revolutions/day³.
    pub mean_motion_ddot_rev_day3: f64,
    /// Revolution number at epoch; 0 if omitted.
    pub revolution_at_epoch: u32,
    /// Time from which the satellite is known to have decayed: that of DECAY_DATE, the end of its day without a time;
    /// `None` if omitted.
    pub decayed: Option<Epoch>,
    /// Origin of the element set.
    pub origin: Origin,
}

impl ElementSet {
    /// Returns true if both sets have a COSPAR designator and these differ: the sets are of different objects, also
    /// under one catalogue number.
    pub(crate) fn is_of_other_object(&self, other: &Self) -> bool {
        let [first, second] = [self, other].map(|set| &set.international_designator);
        if first == second {
            return false;
        }
        // The same designator may be written as 1998-067A or 98067A. Texts such as UNKNOWN are no designators.
        let key =
            |text: &str| text.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_uppercase();
        let keys = [first, second].map(|text| key(text));
        let [first, second] = &keys;
        keys.iter().all(|key| key.starts_with(|c: char| c.is_ascii_digit()))
            && !first.ends_with(&**second)
            && !second.ends_with(&**first)
    }

    /// Returns the first of the elements that differ by more than the rounding in a TLE, with both values and the unit.
    pub(crate) fn difference(&self, other: &Self) -> Option<(&'static str, [f64; 2], &'static str)> {
        /// Unit of the last digit in a TLE, with a margin for the rounding of its decimals.
        const ANGLE_DEG: f64 = 1.001e-4;
        const MEAN_MOTION_REV_DAY: f64 = 1.001e-8;
        const ECCENTRICITY: f64 = 1.001e-7;
        let bstar_step = |bstar: f64| 1.001e-4 * bstar.abs() + 1e-10;
        let values = |value: fn(&Self) -> f64| [value(self), value(other)];
        let angle = |[a, b]: [f64; 2]| ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs() > ANGLE_DEG;
        let by = |[a, b]: [f64; 2], step: f64| (a - b).abs() > step;
        let inclinations = values(|set| set.inclination_deg);
        let nodes = values(|set| set.right_ascension_of_node_deg);
        let motions = values(|set| set.mean_motion_rev_day);
        let eccentricities = values(|set| set.eccentricity);
        let perigees = values(|set| set.argument_of_perigee_deg);
        let anomalies = values(|set| set.mean_anomaly_deg);
        let drags = values(|set| set.bstar_per_earth_radius);
        [
            ("inclination", inclinations, " deg", angle(inclinations)),
            ("right ascension of the node", nodes, " deg", angle(nodes)),
            ("mean motion", motions, " rev/day", by(motions, MEAN_MOTION_REV_DAY)),
            ("eccentricity", eccentricities, "", by(eccentricities, ECCENTRICITY)),
            ("argument of perigee", perigees, " deg", angle(perigees)),
            ("mean anomaly", anomalies, " deg", angle(anomalies)),
            ("B*", drags, " 1/earth radii", by(drags, bstar_step(drags[0]))),
        ]
        .into_iter()
        .find_map(|(name, values, unit, differs)| differs.then_some((name, values, unit)))
    }
}

/// Origin of an element set.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Origin {
    /// Read from a file.
    Published,
    /// Generated by a [`Constellation`](super::Constellation); it does not correspond to a real satellite.
    Synthetic,
}

#[cfg(test)]
mod tests {
    use super::super::Constellation;
    use super::super::epoch::parse_iso;
    use super::*;

    fn set() -> ElementSet {
        let epoch = parse_iso("2026-06-15T03:00:00").unwrap();
        Constellation::by_name("kuiper").unwrap().element_sets(epoch).swap_remove(0)
    }

    #[test]
    fn sets_with_other_designators_are_of_other_objects() {
        let with = |text: &str| ElementSet { international_designator: text.into(), ..set() };
        for (first, second, is_other) in [
            ("2025-189B", "2025-189AD", true),
            ("1998-067A", "1998-067B", true),
            ("98067A", "1999-067A", true),
            ("1998-067A", "98067A", false),
            ("1998-067A", "1998-067a", false),
            ("", "1998-067A", false),
            ("UNKNOWN", "1998-067A", false),
        ] {
            assert_eq!(with(first).is_of_other_object(&with(second)), is_other, "{first} {second}");
            assert_eq!(with(second).is_of_other_object(&with(first)), is_other, "{second} {first}");
        }
    }

    #[test]
    fn differences_are_larger_than_the_rounding_of_other_formats() {
        let set = ElementSet { right_ascension_of_node_deg: 359.99998, ..set() };
        let rounded = ElementSet {
            right_ascension_of_node_deg: 0.0,
            mean_motion_rev_day: set.mean_motion_rev_day + 1e-8,
            ..set.clone()
        };
        assert_eq!(set.difference(&rounded), None);
        let node = ElementSet { right_ascension_of_node_deg: 4.7372, ..set.clone() };
        let expected = ("right ascension of the node", [359.99998, 4.7372], " deg");
        assert_eq!(set.difference(&node), Some(expected));
        let drag = ElementSet { bstar_per_earth_radius: 1e-3, ..set.clone() };
        assert_eq!(set.difference(&drag).map(|(name, ..)| name), Some("B*"));
    }
}
