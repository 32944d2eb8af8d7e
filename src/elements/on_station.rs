//! Phases of orbits (raising, on station, decaying) from their heights, and mean motion for an orbit of given height.
//!
//! An element set contains Kozai's mean motion n. SGP4 first converts it to Brouwer's mean motion, which determines the
//! semi-major axis (Hoots & Roehrich, Spacetrack Report 3, section 6; Vallado et al. 2006, AIAA 2006-6753, `initl`).
//! With Kepler's law and the published mean motion, heights of low orbits would be wrong by up to 5 km. Constants are
//! WGS72, as in SGP4.

use std::f64::consts::TAU;

use hifitime::{Epoch, Unit};

use super::element_set::ElementSet;
use crate::constants::{EARTH_EQUATORIAL_RADIUS_KM, WGS72_MU_KM3_S2};

/// Equatorial radius of WGS72, km: the unit of length in SGP4.
const EARTH_RADIUS_KM: f64 = 6378.135;
/// Second zonal harmonic of WGS72.
const J2: f64 = 0.001_082_616;
/// Fourth zonal harmonic of WGS72.
const J4: f64 = -0.000_001_655_97;
/// Minutes in a day.
pub(super) const DAY_MIN: f64 = 1440.0;

/// Returns √μ in (earth radii)^1.5 per minute, the mean motion at one earth radius in rad/min.
fn k_e() -> f64 {
    60.0 / (EARTH_RADIUS_KM.powi(3) / WGS72_MU_KM3_S2).sqrt()
}

/// Returns δ = 3/2 k₂ (3 cos²i − 1) / (a² (1 − e²)^1.5) with k₂ = J₂/2, a in earth radii.
fn delta(semi_major_axis: f64, eccentricity: f64, inclination_rad: f64) -> f64 {
    let cos_i = inclination_rad.cos();
    0.75 * J2 * (3.0 * cos_i * cos_i - 1.0)
        / (semi_major_axis * semi_major_axis * (1.0 - eccentricity * eccentricity).powf(1.5))
}

/// Returns the semi-major axis, earth radii, from Kozai's mean motion n, by way of Brouwer's mean motion n / (1 + δ₀).
fn recover(mean_motion_rad_min: f64, eccentricity: f64, inclination_rad: f64) -> f64 {
    // a₁ = (k_e / n)^(2/3);  a₀ = a₁ (1 − δ₁/3 − δ₁² − 134/81 δ₁³);  n″ = n / (1 + δ₀)       STR 3, section 6
    let a1 = (k_e() / mean_motion_rad_min).powf(2.0 / 3.0);
    let d1 = delta(a1, eccentricity, inclination_rad);
    let a0 = a1 * (1.0 - d1 * (1.0 / 3.0 + d1 * (1.0 + 134.0 / 81.0 * d1)));
    let brouwer = mean_motion_rad_min / (1.0 + delta(a0, eccentricity, inclination_rad));
    (k_e() / brouwer).powf(2.0 / 3.0)
}

/// Returns the semi-major axis (Brouwer's mean, as used in SGP4) of an element set, km.
pub fn semi_major_axis_km(set: &ElementSet) -> f64 {
    let mean_motion = set.mean_motion_rev_day * TAU / DAY_MIN;
    EARTH_RADIUS_KM * recover(mean_motion, set.eccentricity, set.inclination_deg.to_radians())
}

/// Returns the published (Kozai) mean motion, revolutions a day, for which SGP4 gives a circular orbit of this mean
/// radius, km.
///
/// The radius in SGP4 of a circular mean orbit is a (1 − 3/4 J₂ (R/a)² (3 cos²i − 1)) plus terms that average to zero
/// over a revolution, so that the semi-major axis a differs from the radius by up to 5 km. Accurate to one metre.
pub(super) fn mean_motion_for_radius(radius_km: f64, inclination_rad: f64) -> f64 {
    let radius = radius_km / EARTH_RADIUS_KM;
    // For a circular orbit, δ is the relative difference of semi-major axis and radius: r = a (1 − δ(a)). Each
    // iteration adds three digits.
    let mut a = radius;
    for _ in 0..6 {
        a = radius / (1.0 - delta(a, 0.0, inclination_rad));
    }
    // The inverse of `recover`, by fixed-point iteration on the published mean motion.
    let mut mean_motion = k_e() / a.powf(1.5);
    for _ in 0..6 {
        mean_motion *= (recover(mean_motion, 0.0, inclination_rad) / a).powf(1.5);
    }
    mean_motion * DAY_MIN / TAU
}

/// Returns the rates of the node and of the argument of latitude (ω + M) in SGP4, rad/day, for a circular orbit without
/// drag.
///
/// `mean_motion_rev_day` is the published (Kozai) value. Valid for near-Earth orbits (periods below 225 minutes).
pub(super) fn secular_rates_rad_day(mean_motion_rev_day: f64, inclination_rad: f64) -> (f64, f64) {
    let a = recover(mean_motion_rev_day * TAU / DAY_MIN, 0.0, inclination_rad);
    let n = k_e() / a.powf(1.5);
    let cos = inclination_rad.cos();
    let (cos2, cos4) = (cos * cos, cos.powi(4));
    // Ṁ, ω̇, Ω̇ as in `sgp4init` of Vallado et al. (2006), for e = 0.
    let t1 = 1.5 * J2 * n / (a * a);
    let t2 = 0.5 * t1 * J2 / (a * a);
    let t3 = -0.46875 * J4 * n / a.powi(4);
    let anomaly = n + 0.5 * t1 * (3.0 * cos2 - 1.0) + 0.0625 * t2 * (13.0 - 78.0 * cos2 + 137.0 * cos4);
    let perigee = -0.5 * t1 * (1.0 - 5.0 * cos2)
        + 0.0625 * t2 * (7.0 - 114.0 * cos2 + 395.0 * cos4)
        + t3 * (3.0 - 36.0 * cos2 + 49.0 * cos4);
    let node = cos * (-t1 + 0.5 * t2 * (4.0 - 19.0 * cos2) + 2.0 * t3 * (3.0 - 7.0 * cos2));
    (node * DAY_MIN, (anomaly + perigee) * DAY_MIN)
}

/// Criteria of the on-station phase.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StationRule {
    /// Smallest height of the semi-major axis above the equatorial radius, km.
    pub min_height_km: f64,
    /// Largest rate of change of the semi-major axis, in either direction, m/day.
    pub max_rate_m_day: f64,
    /// Number of consecutive element sets that must agree, at least 2.
    pub consecutive_sets: usize,
}

impl Default for StationRule {
    /// Returns 530 km, 100 m/day and three element sets, as in Lu (2024, section 3).
    fn default() -> Self {
        Self { min_height_km: 530.0, max_rate_m_day: 100.0, consecutive_sets: 3 }
    }
}

/// Phase of an orbit at the time of an element set.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum OrbitPhase {
    /// Constant height, above the minimum height.
    OnStation,
    /// Constant height, below the minimum height: in a parking orbit or a lower shell.
    Parked,
    /// The semi-major axis increases faster than the limit.
    Raising,
    /// The semi-major axis decreases faster than the limit.
    Decaying,
    /// Undetermined: too few element sets nearby, or the semi-major axis both increases and decreases.
    Unknown,
}

impl OrbitPhase {
    /// Returns the name in files and messages.
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

/// Shortest time between element sets from which a rate is computed, days. Closer sets are fits to the same
/// observations, or their difference is dominated by rounding.
const LEAST_INTERVAL_DAY: f64 = 0.05;

/// Returns the phase of **one** satellite at each of its element sets, in their order. The sets must be in time order,
/// as returned by [`History::sets_of`](super::History::sets_of).
///
/// All runs of `consecutive_sets` sets that contain a set are examined. If all rates of one run are below the limit,
/// the height is constant. Otherwise the orbit is raising if all rates of at least one run are positive and no run has
/// only negative rates, and decaying in the opposite case. Sets less than 72 minutes apart are treated as one.
pub fn orbit_phases(sets: &[ElementSet], rule: &StationRule) -> Vec<OrbitPhase> {
    // 1. Element sets at distinct times, with their semi-major axes.
    let mut distinct: Vec<(Epoch, f64)> = Vec::with_capacity(sets.len());
    let mut index = Vec::with_capacity(sets.len());
    for set in sets {
        let apart = distinct.last().is_none_or(|(last, _)| days_between(*last, set.epoch) >= LEAST_INTERVAL_DAY);
        if apart {
            distinct.push((set.epoch, semi_major_axis_km(set)));
        }
        index.push(distinct.len() - 1);
    }
    // 2. Rates between neighbouring sets, m/day.
    let rates: Vec<f64> =
        distinct.windows(2).map(|pair| (pair[1].1 - pair[0].1) * 1000.0 / days_between(pair[0].0, pair[1].0)).collect();
    // 3. Phase of each distinct set.
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
