//! Selection of placed records as in Lu (2024), section 3, with every threshold as an option, and on-station intervals
//! of satellites.

use std::collections::HashMap;

use hifitime::Epoch;

use super::super::error::FitError;
use super::dropped::DropReason;
use super::placement::Placed;
use super::record::Record;
use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::elements::{ElementSet, History, NoradId, OrbitPhase, StationRule, orbit_phases};
use crate::geometry::{KARMAN_LINE_KM, grazing_height_km};
use crate::photometry::StandardMagnitude;

/// Thresholds for the use of records. Filters are selected on reading
/// ([`PhotometryOptions::filters`](super::PhotometryOptions::filters)).
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Drops records that the survey flags as in the penumbra.
    pub drop_penumbra_flag: bool,
    /// Least height of the line from satellite to Sun above the ground, km; `None`: no limit.
    ///
    /// For records with distance and phase only, the ground is a sphere of 6378.137 km, which is stricter by up to 21
    /// km at the poles.
    pub least_grazing_height_km: Option<f64>,
    /// Least altitude at the site, radians; a lower satellite cannot be the observed one. `None`: no limit.
    pub least_altitude_rad: Option<f64>,
    /// Keeps satellites on station by this rule, which needs a history. `None`: keeps all.
    pub station: Option<StationRule>,
    /// Largest difference between the recorded range and that of the satellite, km; `None`: no limit.
    pub max_range_difference_km: Option<f64>,
    /// Largest difference between the recorded phase and that of the satellite, radians; `None`: no limit.
    pub max_phase_difference_rad: Option<f64>,
    /// Subtracts 5 log10 of the Sun's distance in au from the magnitudes. Lu (2024) does not (at most 0.04 mag).
    pub correct_sun_distance: bool,
}

impl Default for Selection {
    /// Lu (2024), section 3: no penumbra flags, 100 km, above the horizon, on station or not. The range, which the
    /// paper does not check, may differ by 100 km.
    fn default() -> Self {
        Self {
            drop_penumbra_flag: true,
            least_grazing_height_km: Some(KARMAN_LINE_KM),
            least_altitude_rad: Some(0.0),
            station: None,
            max_range_difference_km: Some(100.0),
            max_phase_difference_rad: None,
            correct_sun_distance: false,
        }
    }
}

impl Selection {
    /// Every record with a geometry.
    pub fn everything() -> Self {
        Self {
            drop_penumbra_flag: false,
            least_grazing_height_km: None,
            least_altitude_rad: None,
            max_range_difference_km: None,
            ..Self::default()
        }
    }

    /// # Errors
    /// [`FitError::Setting`] for a threshold that is not finite, or negative where it must not be.
    pub(super) fn check(&self) -> Result<(), FitError> {
        let not_negative = [
            ("max_range_difference_km", self.max_range_difference_km),
            ("max_phase_difference_rad", self.max_phase_difference_rad),
        ];
        for (name, value) in not_negative {
            if let Some(value) = value.filter(|value| !(0.0..).contains(value)) {
                return Err(FitError::Setting { name, given: value.to_string(), allowed: "0 or more" });
            }
        }
        for (name, value) in
            [("least_grazing_height_km", self.least_grazing_height_km), ("least_altitude_rad", self.least_altitude_rad)]
        {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                return Err(FitError::Setting { name, given: value.to_string(), allowed: "a finite number" });
            }
        }
        Ok(())
    }

    /// Reason to drop a record before its geometry is computed.
    pub(super) fn drop_record(&self, record: &Record) -> Option<DropReason> {
        (self.drop_penumbra_flag && record.in_penumbra).then_some(DropReason::PenumbraFlag)
    }

    /// Reason to drop a placed record; `stations` is given if the rule is.
    pub(super) fn drop_placed(
        &self,
        record: &Record,
        placed: &Placed,
        stations: Option<&Stations>,
    ) -> Option<DropReason> {
        let geometry = &placed.geometry;
        if let Some(least) = self.least_altitude_rad
            && placed.altitude_rad.is_some_and(|altitude| altitude < least)
        {
            return Some(DropReason::BelowHorizon);
        }
        let (range_km, phase_rad) = record.sighting.distance_and_phase();
        // Angles are computed only if there is a limit.
        let apart = |limit: Option<f64>, recorded: Option<f64>, placed: &dyn Fn() -> f64| {
            limit.zip(recorded).is_some_and(|(limit, recorded)| (placed() - recorded).abs() > limit)
        };
        if apart(self.max_range_difference_km, range_km, &|| geometry.range_km)
            || apart(self.max_phase_difference_rad, phase_rad, &|| geometry.phase_angle_rad())
        {
            return Some(DropReason::WrongAssociation);
        }
        if let Some(least) = self.least_grazing_height_km {
            let height_km = match &placed.satellite_and_sun {
                Some((satellite, sun)) => grazing_height_km(satellite, sun),
                // Distance of the line to the Sun from the Earth's centre: R cos δ_sun for a Sun below the horizontal
                // plane.
                None => (geometry.sun_latitude_rad < 0.0).then(|| {
                    let radius_km = EARTH_EQUATORIAL_RADIUS_KM + geometry.height_km;
                    radius_km * geometry.sun_latitude_rad.cos() - EARTH_EQUATORIAL_RADIUS_KM
                }),
            };
            if height_km.is_some_and(|height_km| height_km < least) {
                return Some(DropReason::Shaded);
            }
        }
        if let Some(stations) = stations {
            let phase = placed.norad_id.zip(record.epoch).map(|(norad_id, epoch)| stations.phase_at(norad_id, epoch));
            if phase != Some(OrbitPhase::OnStation) {
                return Some(DropReason::OffStation);
            }
        }
        None
    }

    /// Magnitude at 1000 km.
    pub(super) fn standard_magnitude(&self, record: &Record, placed: &Placed) -> StandardMagnitude {
        let standard = record.magnitude.to_standard(placed.geometry.range_km);
        // Predictions add 5 log10 R, so that data subtract it.
        let sun_mag = if self.correct_sun_distance { 5.0 * placed.geometry.sun_distance_au.log10() } else { 0.0 };
        StandardMagnitude(standard.0 - sun_mag)
    }
}

/// Interval in which a satellite was in one phase of its mission.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StationInterval {
    /// Middle between this element set and the previous one, or the first element set.
    pub start: Epoch,
    /// Middle between this element set and the next one, or the last element set.
    pub end: Epoch,
    /// Phase of the mission.
    pub phase: OrbitPhase,
    /// Number of element sets in the interval.
    pub element_sets: usize,
}

/// Mission phases of all satellites of a history.
#[derive(Clone, Debug, Default)]
pub struct Stations {
    phases: HashMap<NoradId, Vec<(Epoch, OrbitPhase)>>,
}

impl Stations {
    /// Applies the rule to every element set.
    pub fn new(history: &History, rule: &StationRule) -> Self {
        let of_one = |sets: &[ElementSet]| {
            let phases = sets.iter().map(|set| set.epoch).zip(orbit_phases(sets, rule)).collect();
            (sets[0].norad_id, phases)
        };
        Self { phases: history.objects().map(of_one).collect() }
    }

    /// Phase of a satellite at an epoch, taken from its element set nearest in time; [`OrbitPhase::Unknown`] without
    /// element sets.
    pub fn phase_at(&self, norad_id: NoradId, epoch: Epoch) -> OrbitPhase {
        let Some(phases) = self.phases.get(&norad_id) else { return OrbitPhase::Unknown };
        let after = phases.partition_point(|(at, _)| *at <= epoch);
        let (before, next) = (after.checked_sub(1).map(|at| phases[at]), phases.get(after));
        match (before, next) {
            (Some((past, phase)), Some((coming, other))) => {
                if *coming - epoch <= epoch - past {
                    *other
                } else {
                    phase
                }
            }
            (Some((_, phase)), None) => phase,
            (None, Some((_, phase))) => *phase,
            (None, None) => OrbitPhase::Unknown,
        }
    }

    /// Intervals of a satellite in time order; empty for one that is not in the history.
    pub fn intervals(&self, norad_id: NoradId) -> Vec<StationInterval> {
        let phases = self.phases.get(&norad_id).map(Vec::as_slice).unwrap_or_default();
        let mut intervals: Vec<StationInterval> = Vec::new();
        let mut last: Option<Epoch> = None;
        for &(epoch, phase) in phases {
            match intervals.last_mut() {
                Some(interval) if interval.phase == phase => {
                    interval.end = epoch;
                    interval.element_sets += 1;
                }
                open => {
                    let start = last.map_or(epoch, |last| last + (epoch - last) * 0.5);
                    if let Some(interval) = open {
                        interval.end = start;
                    }
                    intervals.push(StationInterval { start, end: epoch, phase, element_sets: 1 });
                }
            }
            last = Some(epoch);
        }
        intervals
    }
}
