//! Selection of records as in Lu (2024), section 3, with every threshold as an option, and intervals in which
//! satellites are on station.

use std::collections::HashMap;

use hifitime::Epoch;

use super::dropped::DropReason;
use super::placement::Placed;
use super::record::Record;
use crate::elements::{ElementSet, History, NoradId, OrbitPhase, StationRule, orbit_phases};
use crate::error::Error;
use crate::geometry::KARMAN_LINE_KM;
use crate::photometry::StandardMagnitude;

/// Thresholds for the use of records. Filters are selected when files are read
/// ([`PhotometryOptions::filters`](super::PhotometryOptions::filters)).
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// If true, records that the survey flags as being in the penumbra are dropped.
    pub drop_penumbra_flag: bool,
    /// Smallest height above the ground of the line from satellite to Sun, km; `None`: no limit.
    ///
    /// For records with only distance and phase angle, the ground is a sphere of 6378.137 km. At the poles this is
    /// stricter by up to 21 km.
    pub least_grazing_height_km: Option<f64>,
    /// Lowest altitude at the site, radians. A satellite below it cannot be the observed one. `None`: no limit.
    pub least_altitude_rad: Option<f64>,
    /// Rule by which satellites are on station; others are dropped. It requires a history. `None`: all are kept.
    pub station: Option<StationRule>,
    /// Largest difference between the recorded range and the computed range of the satellite, km; `None`: no limit.
    pub max_range_difference_km: Option<f64>,
    /// Largest difference between the recorded and the computed phase angle of the satellite, radians; `None`: no
    /// limit.
    pub max_phase_difference_rad: Option<f64>,
    /// If true, 5 log10 of the Sun's distance in au is subtracted from the magnitudes. Lu (2024) neglects this (at most
    /// 0.04 mag).
    pub correct_sun_distance: bool,
}

impl Default for Selection {
    /// Returns the selection of Lu (2024), section 3: records without penumbra flag, sunlight that passes at least 100
    /// km above the ground, satellites above the horizon, whether on station or not. In addition, the range, which the
    /// paper does not check, may differ by at most 100 km.
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
    /// Returns a selection that accepts every record with a viewing geometry.
    pub fn everything() -> Self {
        Self {
            drop_penumbra_flag: false,
            least_grazing_height_km: None,
            least_altitude_rad: None,
            max_range_difference_km: None,
            ..Self::default()
        }
    }

    /// Checks the thresholds.
    ///
    /// # Errors
    /// A threshold is not finite, or is negative where it must not be.
    pub(super) fn check(&self) -> Result<(), Error> {
        let not_negative = [
            ("max_range_difference_km", self.max_range_difference_km),
            ("max_phase_difference_rad", self.max_phase_difference_rad),
        ];
        for (name, value) in not_negative {
            if let Some(value) = value.filter(|value| !(0.0..).contains(value)) {
                return Err(Error::invalid(name, value, "0 or more"));
            }
        }
        for (name, value) in
            [("least_grazing_height_km", self.least_grazing_height_km), ("least_altitude_rad", self.least_altitude_rad)]
        {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                return Err(Error::invalid(name, value, "a finite number"));
            }
        }
        Ok(())
    }

    /// Returns the reason to drop a record before its geometry is computed; `None` if it is kept.
    pub(super) fn drop_record(&self, record: &Record) -> Option<DropReason> {
        (self.drop_penumbra_flag && record.in_penumbra).then_some(DropReason::PenumbraFlag)
    }

    /// Returns the reason to drop a record with its geometry; `None` if it is kept. `stations` has the mission phases
    /// of the satellites, from which it is known whether a satellite is on station; it is `None` if
    /// `Selection::station` is `None`.
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
        // Differences are computed only if a limit is set.
        let apart = |limit: Option<f64>, recorded: Option<f64>, placed: &dyn Fn() -> f64| {
            limit.zip(recorded).is_some_and(|(limit, recorded)| (placed() - recorded).abs() > limit)
        };
        if apart(self.max_range_difference_km, range_km, &|| geometry.range_km)
            || apart(self.max_phase_difference_rad, phase_rad, &|| geometry.phase_angle_rad())
        {
            return Some(DropReason::WrongAssociation);
        }
        if let Some(least) = self.least_grazing_height_km
            && placed.grazing_height_km().is_some_and(|height_km| height_km < least)
        {
            return Some(DropReason::Shaded);
        }
        if let Some(stations) = stations {
            let phase = placed.norad_id.zip(record.epoch).map(|(norad_id, epoch)| stations.phase_at(norad_id, epoch));
            if phase != Some(OrbitPhase::OnStation) {
                return Some(DropReason::OffStation);
            }
        }
        None
    }

    /// Returns the magnitude at a range of 1000 km.
    pub(super) fn standard_magnitude(&self, record: &Record, placed: &Placed) -> StandardMagnitude {
        let standard = record.magnitude.to_standard(placed.geometry.range_km);
        // Models add 5 log10 R to their predictions, where R is the Sun's distance in au, so it is subtracted from
        // measurements.
        let sun_mag = if self.correct_sun_distance { 5.0 * placed.geometry.sun_distance_au.log10() } else { 0.0 };
        StandardMagnitude(standard.0 - sun_mag)
    }
}

/// Interval in which a satellite was in the same phase of its mission.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StationInterval {
    /// Start: half way between the first element set of the interval and the previous one, or the first element set of
    /// all.
    pub start: Epoch,
    /// End: half way between the last element set of the interval and the next one, or the last element set of all.
    pub end: Epoch,
    /// Phase of the mission.
    pub phase: OrbitPhase,
    /// Number of element sets in the interval.
    pub element_sets: usize,
}

/// Mission phases of all satellites in a history.
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

    /// Returns the phase of a satellite at an epoch, according to the element set that is nearest in time;
    /// [`OrbitPhase::Unknown`] without element sets.
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

    /// Returns the intervals of a satellite in order of time; empty if the satellite is not in the history.
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
