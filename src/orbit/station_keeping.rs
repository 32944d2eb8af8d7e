//! Propagation of satellites that hold their orbits by thrust.
//!
//! SGP4 applies the drag of the element set (B*). A satellite that holds its orbit cancels that drag by thrust, so SGP4
//! lets it fall and run ahead of its true position: by 55 s in a week for a Starlink V2 Mini. Without drag the mean
//! motion of the element set must change too. It was fitted together with the drag and is valid at the epoch, while the
//! satellite keeps the mean motion that it had during the observations before the epoch.
//!
//! ```text
//! B* = 0,    n = n₀ - 2 τ (ṅ/2)                                           rev/day
//! ```
//!
//! with the published ṅ/2 and one lag τ for each class of satellite. Along the track, in seconds, with the age t in
//! days and the period P: the published drag D = P ṅ/2 gives D t², of which the lag removes 2 τ D t. The remaining
//! error is distributed as a core of two Gaussians and a wide Gaussian for the share m of satellites that manoeuvred
//! since the epoch:
//!
//! ```text
//! (1 - m) [0.7 N(s) + 0.3 N(r s)] + m N(90 t)        s = √(s₀² + (k t)² + (c D t)²),    m = m₀ + m₁ t ≤ 0.5
//! ```
//!
//! The last Gaussian is at least as wide as the second; no sigma exceeds 0.3413 P.
//!
//! `tests/reference/calibrate_station_keeping.py` calibrates the lags on the Starlink catalogue of June 2026 and
//! reports the remaining errors of other objects and dates (docs/explanation/uncertainty.md).

use super::lateness::Lateness;
use crate::elements::{Certainty, ElementSet, Generation, GenerationTable, semi_major_axis_km};

/// WGS72 equatorial radius, km.
const WGS72_RADIUS_KM: f64 = 6_378.135;
/// Largest |ṅ/2| of a satellite that holds its orbit, rev/day².
const ON_STATION_REV_DAY2: f64 = 3e-4;
/// Largest |ṅ/2| of a V2 Mini that cancels strong drag, rev/day².
const STRONG_DRAG_REV_DAY2: f64 = 2e-3;
/// Largest |ṅ/2| of a Direct-to-Cell satellite on station at 360 km, rev/day².
const DIRECT_TO_CELL_REV_DAY2: f64 = 6e-3;
/// A V2 Mini below this height with |ṅ/2| above [`ON_STATION_REV_DAY2`] is being raised or lowered, km.
const V2_MINI_STATION_KM: f64 = 450.0;
/// Weight of the inner Gaussian of the core.
const CORE_WEIGHT: f64 = 0.7;
/// Sigma of the lateness of satellites that manoeuvred, s per day of age.
const MANOEUVRE_S_DAY: f64 = 90.0;
/// Largest share of satellites that manoeuvred; the ages in the calibration end at 21 days.
const LARGEST_MANOEUVRING: f64 = 0.5;

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

    /// The class of a satellite whose published drag is not applied; `None` where the drag is applied.
    pub fn class_of(self, elements: &ElementSet) -> Option<StationKeeping> {
        match self {
            Self::Published => None,
            Self::StationKeeping => StationKeeping::of(elements),
        }
    }
}

/// A class of satellites that hold their orbits, for which lag and lateness are calibrated.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum StationKeeping {
    /// V1.5 on station.
    StarlinkV15,
    /// VisorSat and V2 Mini on station.
    Starlink,
    /// V2 Mini in strong drag.
    StarlinkStrongDrag,
    /// Direct-to-Cell.
    DirectToCell,
}

impl StationKeeping {
    /// The class of an element set; `None` where the drag is real, or the class uncertain.
    ///
    /// Descending and raising satellites, V0.9 and V1.0 (many of which descend), debris, rocket bodies and other
    /// constellations keep the published drag: a wrong class costs more than a right one gains.
    pub fn of(elements: &ElementSet) -> Option<Self> {
        let (generation, certainty) = GenerationTable::embedded().classify(elements);
        if certainty == Certainty::Guess && !elements.name.starts_with("STARLINK") {
            return None;
        }
        let change = elements.mean_motion_dot_rev_day2.abs();
        match generation {
            Generation::StarlinkV15 if change <= ON_STATION_REV_DAY2 => Some(Self::StarlinkV15),
            Generation::StarlinkVisorSat | Generation::StarlinkV2Mini if change <= ON_STATION_REV_DAY2 => {
                Some(Self::Starlink)
            }
            Generation::StarlinkV2Mini
                if change <= STRONG_DRAG_REV_DAY2
                    && semi_major_axis_km(elements) - WGS72_RADIUS_KM >= V2_MINI_STATION_KM =>
            {
                Some(Self::StarlinkStrongDrag)
            }
            Generation::StarlinkDirectToCell if change <= DIRECT_TO_CELL_REV_DAY2 => Some(Self::DirectToCell),
            _ => None,
        }
    }

    /// The element set that SGP4 propagates.
    pub(super) fn elements(self, published: &ElementSet) -> ElementSet {
        // n = n₀ - 2 τ (ṅ/2)
        let change = published.mean_motion_dot_rev_day2 * self.calibration().twice_lag_day;
        ElementSet {
            mean_motion_rev_day: published.mean_motion_rev_day - change,
            bstar_per_earth_radius: 0.0,
            ..published.clone()
        }
    }

    /// Distribution of the delay at an age in days; `drag_s_day2` is D, `cap_s` the sigma at which every position along
    /// the orbit is equally likely.
    pub(super) fn lateness(self, age: f64, drag_s_day2: f64, cap_s: f64) -> Lateness {
        let c = self.calibration();
        // s = √(s₀² + (k t)² + (c D t)²)
        let core_s = (c.floor_s.powi(2) + (c.growth_s_day * age).powi(2) + (c.drag_day * drag_s_day2 * age).powi(2))
            .sqrt()
            .min(cap_s / c.ratio);
        let outer_s = c.ratio * core_s;
        // m = m₀ + m₁ t
        let manoeuvred = (c.manoeuvring + c.manoeuvring_a_day * age).min(LARGEST_MANOEUVRING);
        Lateness::core_and_manoeuvres(
            [(CORE_WEIGHT, core_s), (1.0 - CORE_WEIGHT, outer_s)],
            (manoeuvred, (MANOEUVRE_S_DAY * age).max(outer_s).min(cap_s)),
        )
    }

    /// Growth of the error across the track at an age in days, km.
    pub(super) fn cross_track_km(self, age: f64) -> f64 {
        let c = self.calibration();
        c.cross_km * age.powf(c.cross_power)
    }

    /// The fits of `tests/reference/calibrate_station_keeping.py`, rounded.
    #[rustfmt::skip]
    const fn calibration(self) -> Calibration {
        match self {
            Self::StarlinkV15        => Calibration { twice_lag_day: 0.75, floor_s: 0.33, growth_s_day: 0.113, drag_day: 4.42, ratio: 3.6, manoeuvring: 0.021,  manoeuvring_a_day: 0.0079, cross_km: 0.057, cross_power: 1.33 },
            Self::Starlink           => Calibration { twice_lag_day: 0.75, floor_s: 0.52, growth_s_day: 0.348, drag_day: 0.345, ratio: 3.3, manoeuvring: 0.0076, manoeuvring_a_day: 0.0032, cross_km: 0.111, cross_power: 1.12 },
            Self::StarlinkStrongDrag => Calibration { twice_lag_day: 0.45, floor_s: 0.23, growth_s_day: 0.0,   drag_day: 0.63,  ratio: 2.7, manoeuvring: 0.059,  manoeuvring_a_day: 0.0058, cross_km: 0.142, cross_power: 0.99 },
            Self::DirectToCell       => Calibration { twice_lag_day: 0.33, floor_s: 0.57, growth_s_day: 0.42,  drag_day: 0.262, ratio: 2.4, manoeuvring: 0.010,  manoeuvring_a_day: 0.0,    cross_km: 0.252, cross_power: 0.87 },
        }
    }
}

/// Lag and lateness of a class: the coefficients of the formulas at the head of this file.
struct Calibration {
    /// 2 τ, days.
    twice_lag_day: f64,
    /// s₀, seconds.
    floor_s: f64,
    /// k, s/day.
    growth_s_day: f64,
    /// c, days.
    drag_day: f64,
    /// r, the outer over the inner sigma of the core.
    ratio: f64,
    /// m₀.
    manoeuvring: f64,
    /// m₁, 1/day.
    manoeuvring_a_day: f64,
    /// Growth of the error across the track, km/day^power, and its power.
    cross_km: f64,
    cross_power: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::{NoradId, Origin};
    use hifitime::Epoch;

    fn elements(name: &str, mean_motion_rev_day: f64, half_derivative_rev_day2: f64) -> ElementSet {
        ElementSet {
            norad_id: NoradId(60_000),
            name: name.into(),
            international_designator: "".into(),
            epoch: Epoch::from_gregorian_utc_at_midnight(2026, 6, 5),
            mean_motion_rev_day,
            eccentricity: 1e-4,
            inclination_deg: 53.16,
            right_ascension_of_node_deg: 0.0,
            argument_of_perigee_deg: 0.0,
            mean_anomaly_deg: 0.0,
            bstar_per_earth_radius: 1e-3,
            mean_motion_dot_rev_day2: half_derivative_rev_day2,
            mean_motion_ddot_rev_day3: 0.0,
            revolution_at_epoch: 0,
            decayed: None,
            origin: Origin::Published,
        }
    }

    #[test]
    fn verif_classes_by_kind_derivative_and_height() {
        // 15.28 rev/day are 480 km, 15.7 rev/day 355 km.
        for (name, mean_motion, derivative, class) in [
            ("STARLINK-4000", 15.06, 2e-5, Some(StationKeeping::StarlinkV15)),
            ("STARLINK-4000", 15.06, -5e-4, None),
            ("STARLINK-2000", 15.06, -2e-4, Some(StationKeeping::Starlink)),
            ("STARLINK-31000", 15.28, 2e-4, Some(StationKeeping::Starlink)),
            ("STARLINK-31000", 15.28, 1e-3, Some(StationKeeping::StarlinkStrongDrag)),
            ("STARLINK-31000", 15.28, 3e-3, None),
            ("STARLINK-31000", 15.7, 1e-3, None),
            ("STARLINK-11100 [DTC]", 15.7, 4e-3, Some(StationKeeping::DirectToCell)),
            ("STARLINK-11100 [DTC]", 15.7, 1e-2, None),
            ("STARLINK-1100", 15.06, 1e-5, None),
            ("STARLINK-31000 DEB", 15.28, 2e-4, None),
            ("ONEWEB-0012", 13.16, 0.0, None),
            ("", 15.28, 2e-4, None),
        ] {
            let set = elements(name, mean_motion, derivative);
            assert_eq!(DragModel::StationKeeping.class_of(&set), class, "{name} {mean_motion} {derivative}");
            assert_eq!(DragModel::Published.class_of(&set), None);
        }
    }

    #[test]
    fn verif_elements_without_drag() {
        let set = elements("STARLINK-31000", 15.28, 2e-4);
        let kept = StationKeeping::Starlink.elements(&set);
        // n₀ - 2 τ (ṅ/2) with 2 τ = 0.75 d
        assert!((kept.mean_motion_rev_day - (15.28 - 1.5e-4)).abs() < 1e-12);
        assert_eq!(kept.bstar_per_earth_radius, 0.0);
        assert_eq!(ElementSet { mean_motion_rev_day: 15.28, bstar_per_earth_radius: 1e-3, ..kept }, set);
    }
}
