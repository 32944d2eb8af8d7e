//! Which satellites hold their orbit, and which are on their way up or down.
//!
//! Lu (2024, section 3) keeps only photometry of satellites on station: a − R_E > 530 km and |da/dt| < 100 m/day over three
//! consecutive element sets. Orbit uncertainty asks the same, for a thrusting satellite leaves its element set within hours.
//! The threshold of height belongs to Starlink's first shells; newer ones stand lower, so both thresholds are parameters.

use hifitime::{Epoch, Unit};

use super::element_set::ElementSet;
use super::mean_motion::semi_major_axis_km;
use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;

/// What counts as on station.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StationRule {
    /// Least height of the semi-major axis above the equatorial radius, km.
    pub min_height_km: f64,
    /// Largest rate of the semi-major axis, either way, m/day.
    pub max_rate_m_day: f64,
    /// How many consecutive element sets must agree, at least 2.
    pub consecutive_sets: usize,
}

impl Default for StationRule {
    /// 530 km, 100 m/day, three element sets: Lu (2024, section 3).
    fn default() -> Self {
        Self { min_height_km: 530.0, max_rate_m_day: 100.0, consecutive_sets: 3 }
    }
}

/// What a satellite does at the time of an element set.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum OrbitPhase {
    /// High enough and steady.
    OnStation,
    /// Steady, but lower than the rule asks: parked, or a shell that stands lower.
    Parked,
    /// The semi-major axis grows faster than the rule allows.
    Raising,
    /// The semi-major axis shrinks faster than the rule allows.
    Decaying,
    /// Too few element sets around this one to say, or rates of both signs.
    Unknown,
}

impl OrbitPhase {
    /// The word for files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::OnStation => "on_station",
            Self::Parked => "parked",
            Self::Raising => "raising",
            Self::Decaying => "decaying",
            Self::Unknown => "unknown",
        }
    }
}

/// Element sets closer together than this make no rate: fits of the same tracking, rounding over hours, days.
const LEAST_INTERVAL_DAY: f64 = 0.05;

/// What the satellite does at each of its element sets, in the order given: the records of **one** object in time order,
/// as [`History::of`](super::History::of) returns them.
///
/// A set is judged by every run of `consecutive_sets` sets that holds it. If in one of them all rates are slow, it is
/// steady; else all rates of the sets around it must have the same sign. Sets less than 72 minutes apart count as one.
pub fn orbit_phases(sets: &[ElementSet], rule: &StationRule) -> Vec<OrbitPhase> {
    // 1. Instants apart from one another, with their semi-major axes.
    let mut distinct: Vec<(Epoch, f64)> = Vec::with_capacity(sets.len());
    let mut index = Vec::with_capacity(sets.len());
    for set in sets {
        let apart = distinct.last().is_none_or(|(last, _)| days_between(*last, set.epoch) >= LEAST_INTERVAL_DAY);
        if apart {
            distinct.push((set.epoch, semi_major_axis_km(set)));
        }
        index.push(distinct.len() - 1);
    }
    // 2. Rates between neighbours, m/day.
    let rates: Vec<f64> =
        distinct.windows(2).map(|pair| (pair[1].1 - pair[0].1) * 1000.0 / days_between(pair[0].0, pair[1].0)).collect();
    // 3. One verdict for each distinct set.
    let verdicts: Vec<OrbitPhase> =
        (0..distinct.len()).map(|at| verdict(at, distinct[at].1 - EARTH_EQUATORIAL_RADIUS_KM, &rates, rule)).collect();
    index.into_iter().map(|at| verdicts[at]).collect()
}

fn verdict(at: usize, height_km: f64, rates: &[f64], rule: &StationRule) -> OrbitPhase {
    let run = rule.consecutive_sets.max(2) - 1;
    let runs = (at.saturating_sub(run)..=at).filter_map(|start| rates.get(start..start + run));
    let mut any = false;
    let (mut up, mut down) = (false, false);
    for run in runs {
        any = true;
        if run.iter().all(|rate| rate.abs() < rule.max_rate_m_day) {
            return if height_km > rule.min_height_km { OrbitPhase::OnStation } else { OrbitPhase::Parked };
        }
        up |= run.iter().all(|rate| *rate > 0.0);
        down |= run.iter().all(|rate| *rate < 0.0);
    }
    match (any, up, down) {
        (true, true, false) => OrbitPhase::Raising,
        (true, false, true) => OrbitPhase::Decaying,
        _ => OrbitPhase::Unknown,
    }
}

fn days_between(from: Epoch, to: Epoch) -> f64 {
    (to - from).to_unit(Unit::Day)
}
