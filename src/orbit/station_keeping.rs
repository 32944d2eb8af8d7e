//! Classes of Starlink satellites by their thrust and drag, and the elements that SGP4 propagates for each.
//!
//! SGP4 applies the drag of the element set (B*). A satellite that holds its orbit cancels that drag by thrust, so SGP4
//! lets it fall and run ahead of its true position: by 39 s in a week (68 %) for Starlink V2 Minis. Without drag the
//! mean motion of the element set must change too. It was fitted together with the drag and is valid at the epoch,
//! while the satellite keeps the mean motion that it had during the observations before the epoch.
//!
//! ```text
//! B* = 0,    n = n₀ - 2 τ (ṅ/2)                                           rev/day
//! ```
//!
//! with the published ṅ/2 and one lag τ for each class of satellite. An element set of another epoch gives a better
//! mean motion (`orbit_model.rs`). The remaining errors are in `starlink_lateness.rs`.
//!
//! `tests/reference/calibrate_station_keeping.py` calibrates the lags on the Starlink catalogue of June 2026
//! (docs/explanation/uncertainty.md).

use std::f64::consts::TAU;

use crate::constants::{DAY_S, WGS72_MU_KM3_S2};
use crate::elements::{Certainty, ElementSet, Generation, GenerationTable, Origin};

/// WGS72 equatorial radius, km.
const WGS72_RADIUS_KM: f64 = 6_378.135;
/// Largest |ṅ/2| of a V1.5 that holds its orbit, rev/day². Between 1e-4 and 3e-4 they coast down, and the drag is real.
const V15_STATION_REV_DAY2: f64 = 1e-4;
/// Largest |ṅ/2| of a VisorSat or V2 Mini in little drag, rev/day².
const STATION_REV_DAY2: f64 = 3e-4;
/// Largest ṅ/2 of a V2 Mini that cancels strong drag, rev/day².
const STRONG_DRAG_REV_DAY2: f64 = 2e-3;
/// Satellites with a smaller ṅ/2 are being raised, rev/day².
const RAISING_REV_DAY2: f64 = -1e-3;
/// V2 Minis below this height wait in a parking orbit, or are being raised or lowered, km.
const V2_MINI_STATION_KM: f64 = 450.0;
/// 2 τ of a V2 Mini with strong drag or a Direct-to-Cell that changed its orbit a short time before the epoch, days.
const TWICE_LAG_AFTER_CHANGE_DAY: f64 = -0.45;

/// Drag that SGP4 applies.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum DragModel {
    /// The published B* for every satellite.
    Published,
    /// No drag for satellites that hold their orbits; the published B* for all others.
    #[default]
    StationKeeping,
}

impl DragModel {
    /// Name in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::StationKeeping => "station-keeping",
        }
    }

    /// The model of this [`name`](Self::name).
    pub fn by_name(name: &str) -> Option<Self> {
        [Self::Published, Self::StationKeeping].into_iter().find(|model| model.name() == name)
    }

    /// The class of a Starlink satellite; `None` for all other satellites and without a name, and for all satellites
    /// with [`Self::Published`].
    pub fn class_of(self, elements: &ElementSet) -> Option<StarlinkClass> {
        match self {
            Self::Published => None,
            Self::StationKeeping => StarlinkClass::from_elements(elements),
        }
    }

    /// Returns the elements that SGP4 propagates if a satellite has one element set.
    pub fn propagated(self, elements: &ElementSet) -> ElementSet {
        let kept = self.class_of(elements).and_then(|class| class.kept_mean_motion(elements));
        kept.map_or_else(|| elements.clone(), |mean_motion_rev_day| without_drag(elements, mean_motion_rev_day))
    }
}

/// Returns the same elements without drag and with another mean motion.
pub(super) fn without_drag(elements: &ElementSet, mean_motion_rev_day: f64) -> ElementSet {
    ElementSet { mean_motion_rev_day, bstar_per_earth_radius: 0.0, ..elements.clone() }
}

/// Source of the mean motion of a Starlink satellite.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MeanMotion {
    /// One element set.
    OneSet,
    /// The epochs of two or three element sets.
    TwoSets,
    /// The epochs of four element sets, which agree.
    FourSets,
    /// The epochs of two or three of four element sets; the others do not agree.
    Disagreeing,
    /// The epochs of two element sets, one before and one after the exposures.
    Enclosed,
    /// The shell of the satellite; element sets of other epochs agree with it.
    Shell,
    /// The shell of the satellite, without another element set that agrees with it, as after its arrival there.
    Arrived,
    /// Two element sets, or one, of a satellite far from all shells of its inclination.
    OffShell,
    /// One element set: according to another one, the satellite changed its orbit between the epochs.
    Changed,
    /// One element set with its published drag: according to another one, the satellite does not cancel its drag.
    Coasting,
    /// A constant rate of change between the epochs of two element sets.
    Rate,
    /// One element set of a V1.5 that changes its orbit at no constant rate.
    NoRate,
}

impl MeanMotion {
    /// Returns true if the satellite kept its mean motion between the epochs of its element sets on one side of the
    /// exposures.
    pub(super) fn is_of_older_sets(self) -> bool {
        matches!(self, Self::TwoSets | Self::FourSets | Self::Disagreeing)
    }

    /// Returns true if the prediction differs from that of one element set.
    pub fn is_improved(self) -> bool {
        matches!(
            self,
            Self::TwoSets
                | Self::FourSets
                | Self::Disagreeing
                | Self::Enclosed
                | Self::Shell
                | Self::Arrived
                | Self::Coasting
                | Self::Rate
        )
    }
}

/// A class of Starlink satellites, for which propagation and lateness are calibrated.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StarlinkClass {
    /// V1.5 on station.
    V15,
    /// VisorSat and V2 Mini on station.
    Station,
    /// V2 Mini on station in strong drag.
    StrongDrag,
    /// Direct-to-Cell.
    DirectToCell,
    /// V2 Mini below 450 km that waits in a parking orbit and cancels its drag.
    Parked,
    /// V2 Mini and Direct-to-Cell that are being raised or lowered.
    Raising,
    /// V1.5 that coast down or thrust.
    MovingV15,
    /// V0.9, V1.0, and VisorSats that do not hold their orbits.
    Descending,
}

impl StarlinkClass {
    /// All classes.
    pub const ALL: [Self; 8] = [
        Self::V15,
        Self::Station,
        Self::StrongDrag,
        Self::DirectToCell,
        Self::Parked,
        Self::Raising,
        Self::MovingV15,
        Self::Descending,
    ];

    /// Returns the name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::V15 => "V1.5",
            Self::Station => "VisorSat, V2 Mini",
            Self::StrongDrag => "V2 Mini, strong drag",
            Self::DirectToCell => "Direct-to-Cell",
            Self::Parked => "V2 Mini, parked",
            Self::Raising => "V2 Mini, raising",
            Self::MovingV15 => "V1.5, moving",
            Self::Descending => "V1.0, descending",
        }
    }

    /// The class of an element set; `None` for other satellites, debris, rocket bodies and satellites without a name.
    pub fn from_elements(elements: &ElementSet) -> Option<Self> {
        let (generation, certainty) = GenerationTable::embedded().classify(elements);
        let is_named = certainty != Certainty::Guess || elements.name.starts_with("STARLINK");
        if !is_named || elements.origin == Origin::Synthetic {
            return None;
        }
        let change = elements.mean_motion_dot_rev_day2;
        let class = match generation {
            Generation::StarlinkV15 if change.abs() <= V15_STATION_REV_DAY2 => Self::V15,
            Generation::StarlinkV15 => Self::MovingV15,
            Generation::StarlinkVisorSat if change.abs() <= STATION_REV_DAY2 => Self::Station,
            Generation::StarlinkV09 | Generation::StarlinkV10 | Generation::StarlinkVisorSat => Self::Descending,
            Generation::StarlinkV2Mini | Generation::StarlinkDirectToCell if change <= RAISING_REV_DAY2 => {
                Self::Raising
            }
            Generation::StarlinkDirectToCell => Self::DirectToCell,
            Generation::StarlinkV2Mini if height_km(elements) < V2_MINI_STATION_KM => Self::Parked,
            Generation::StarlinkV2Mini if change.abs() <= STATION_REV_DAY2 => Self::Station,
            Generation::StarlinkV2Mini if change <= STRONG_DRAG_REV_DAY2 => Self::StrongDrag,
            Generation::StarlinkV2Mini => Self::Raising,
            _ => return None,
        };
        Some(class)
    }

    /// Returns true if the satellites of this class share the mean motions of shells.
    pub(super) const fn has_shells(self) -> bool {
        matches!(self, Self::V15 | Self::Station | Self::StrongDrag | Self::DirectToCell)
    }

    /// Returns 2 τ, days, of the classes that cancel their drag; `None` where the published drag is applied.
    const fn twice_lag_day(self) -> Option<f64> {
        match self {
            Self::V15 | Self::Station => Some(0.75),
            Self::StrongDrag => Some(0.45),
            Self::DirectToCell => Some(0.33),
            Self::Parked => Some(0.30),
            Self::Raising | Self::MovingV15 | Self::Descending => None,
        }
    }

    /// Returns the mean motion that a satellite of this class keeps according to one element set, rev/day; `None` where
    /// the published drag is applied.
    pub(super) fn kept_mean_motion(self, published: &ElementSet) -> Option<f64> {
        Some(lagged(published, self.twice_lag_day()?))
    }

    /// Returns the mean motion of a satellite of this class that changed its orbit a short time before the epoch,
    /// rev/day; `None` where the published drag is applied.
    ///
    /// The element set of a V2 Mini that has just arrived at its height was fitted to observations of which a part is
    /// from before the arrival, and its mean motion lags behind: 2 τ is negative.
    pub(super) fn mean_motion_after_change(self, published: &ElementSet) -> Option<f64> {
        match self {
            Self::StrongDrag | Self::DirectToCell => Some(lagged(published, TWICE_LAG_AFTER_CHANGE_DAY)),
            _ => self.kept_mean_motion(published),
        }
    }
}

/// Returns the published mean motion, corrected for a lag, rev/day.
fn lagged(published: &ElementSet, twice_lag_day: f64) -> f64 {
    // n = n₀ - 2 τ (ṅ/2)
    published.mean_motion_rev_day - twice_lag_day * published.mean_motion_dot_rev_day2
}

/// Returns the height of a circular orbit with the published mean motion, km.
pub(super) fn height_km(elements: &ElementSet) -> f64 {
    // a³ = μ (P / 2π)²
    let period_s = DAY_S / elements.mean_motion_rev_day;
    (WGS72_MU_KM3_S2 * (period_s / TAU).powi(2)).cbrt() - WGS72_RADIUS_KM
}

#[cfg(test)]
mod tests {
    use super::super::test_elements::starlink;
    use super::*;

    #[test]
    fn verif_classes_by_kind_derivative_and_height() {
        // 15.28 rev/day are 480 km, 15.7 rev/day 355 km.
        for (name, mean_motion, derivative, class) in [
            ("STARLINK-4000", 15.06, 2e-5, Some(StarlinkClass::V15)),
            ("STARLINK-4000", 15.06, 2e-4, Some(StarlinkClass::MovingV15)),
            ("STARLINK-4000", 15.06, -5e-4, Some(StarlinkClass::MovingV15)),
            ("STARLINK-2000", 15.06, -2e-4, Some(StarlinkClass::Station)),
            ("STARLINK-2000", 15.06, 4e-4, Some(StarlinkClass::Descending)),
            ("STARLINK-31000", 15.28, 2e-4, Some(StarlinkClass::Station)),
            ("STARLINK-31000", 15.28, 1e-3, Some(StarlinkClass::StrongDrag)),
            ("STARLINK-31000", 15.28, -9e-4, Some(StarlinkClass::StrongDrag)),
            ("STARLINK-31000", 15.28, 3e-3, Some(StarlinkClass::Raising)),
            ("STARLINK-31000", 15.28, -2e-3, Some(StarlinkClass::Raising)),
            ("STARLINK-31000", 15.7, 1e-4, Some(StarlinkClass::Parked)),
            ("STARLINK-31000", 15.7, 9e-3, Some(StarlinkClass::Parked)),
            ("STARLINK-31000", 15.7, -2e-3, Some(StarlinkClass::Raising)),
            ("STARLINK-11100 [DTC]", 15.7, 1e-2, Some(StarlinkClass::DirectToCell)),
            ("STARLINK-11100 [DTC]", 15.7, -1e-2, Some(StarlinkClass::Raising)),
            ("STARLINK-1100", 15.06, 1e-5, Some(StarlinkClass::Descending)),
            ("STARLINK-31000 DEB", 15.28, 2e-4, None),
            ("ONEWEB-0012", 13.16, 0.0, None),
            ("", 15.28, 2e-4, None),
        ] {
            let set = starlink(name, mean_motion, derivative);
            assert_eq!(DragModel::StationKeeping.class_of(&set), class, "{name} {mean_motion} {derivative}");
            assert_eq!(DragModel::Published.class_of(&set), None);
        }
    }

    #[test]
    fn verif_mean_motion_without_drag() {
        let set = starlink("STARLINK-31000", 15.28, 2e-4);
        // n₀ - 2 τ (ṅ/2) with 2 τ = 0.75 d
        let kept = StarlinkClass::Station.kept_mean_motion(&set).unwrap();
        assert!((kept - (15.28 - 1.5e-4)).abs() < 1e-12);
        assert_eq!(StarlinkClass::Raising.kept_mean_motion(&set), None);
        // After a change of the orbit, 2 τ = -0.45 d in strong drag.
        let strong = starlink("STARLINK-31000", 15.28, 6e-4);
        for class in [StarlinkClass::StrongDrag, StarlinkClass::DirectToCell] {
            let after = class.mean_motion_after_change(&strong).unwrap();
            assert!((after - (15.28 + 2.7e-4)).abs() < 1e-12);
        }
        assert_eq!(StarlinkClass::Station.mean_motion_after_change(&set), Some(kept));
    }
}
