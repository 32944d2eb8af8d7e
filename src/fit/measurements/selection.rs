//! Which placed records are used: Lu (2024), section 3, every threshold an option.

use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::elements::{OrbitPhase, StationRule};
use crate::geometry::{KARMAN_LINE_KM, grazing_height_km};
use crate::photometry::StandardMagnitude;

use super::dropped::DropReason;
use super::error::MeasuredError;
use super::placement::Placed;
use super::record::Record;
use super::station::Stations;

/// What is asked of a record. The filter is the reader's ([`ReadOptions::filters`](super::ReadOptions::filters)).
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Drop what the survey flagged as in the penumbra.
    pub drop_penumbra_flag: bool,
    /// Drop satellites whose line to the Sun passes lower above the ground, km; `None`: no such rule.
    ///
    /// Of distance and phase alone the place is not known, and the ground is a sphere of 6378.137 km: stricter by up to 21 km at the poles.
    pub least_grazing_height_km: Option<f64>,
    /// Drop what stands lower at the site: it cannot have been seen, so it is another satellite. Radians; `None`: no such rule.
    pub least_altitude_rad: Option<f64>,
    /// Keep satellites on station only; needs a history. `None`: keep all.
    pub station: Option<StationRule>,
    /// Drop records whose range differs by more from that of the named satellite, km; `None`: no such rule.
    pub max_range_difference_km: Option<f64>,
    /// Drop records whose phase differs by more from that of the named satellite, radians; `None`: no such rule.
    pub max_phase_difference_rad: Option<f64>,
    /// Take 5 log10 of the Sun's distance in au off the magnitudes. Lu (2024) leaves it in (at most 0.04 mag).
    pub correct_sun_distance: bool,
}

impl Default for Selection {
    /// Lu (2024), section 3, as far as rows tell: no flagged ones, 100 km, above the horizon; any satellite, on station or not. Range and
    /// phase, which the paper does not check, may differ by what one would put down to old element sets.
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
    /// Every record that has a geometry.
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
    /// [`MeasuredError::Setting`] for a threshold that is not a number or negative where it must not be.
    pub(super) fn check(&self) -> Result<(), MeasuredError> {
        let not_negative = [
            ("max_range_difference_km", self.max_range_difference_km),
            ("max_phase_difference_rad", self.max_phase_difference_rad),
        ];
        for (name, value) in not_negative {
            if let Some(value) = value.filter(|value| !(0.0..).contains(value)) {
                return Err(MeasuredError::Setting { name, given: value.to_string(), allowed: "0 or more" });
            }
        }
        for (name, value) in
            [("least_grazing_height_km", self.least_grazing_height_km), ("least_altitude_rad", self.least_altitude_rad)]
        {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                return Err(MeasuredError::Setting { name, given: value.to_string(), allowed: "a finite number" });
            }
        }
        Ok(())
    }

    /// What can be said before there is a geometry.
    pub(super) fn judge_record(&self, record: &Record) -> Option<DropReason> {
        (self.drop_penumbra_flag && record.in_penumbra).then_some(DropReason::PenumbraFlag)
    }

    /// Why a placed record is not used; `None` where it is. `stations` is there where the rule is.
    pub(super) fn judge(&self, record: &Record, placed: &Placed, stations: Option<&Stations>) -> Option<DropReason> {
        let geometry = &placed.geometry;
        if let Some(least) = self.least_altitude_rad
            && placed.altitude_rad.is_some_and(|altitude| altitude < least)
        {
            return Some(DropReason::BelowHorizon);
        }
        let (range_km, phase_rad) = record.sighting.distance_and_phase();
        // Angles are asked for where there is a limit alone.
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
                // Perpendicular distance of the line to the Sun from the Earth's centre: R cos δ_sun, where the line dips.
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

    /// At 1000 km.
    pub(super) fn standard_magnitude(&self, record: &Record, placed: &Placed) -> StandardMagnitude {
        let standard = record.magnitude.to_standard(placed.geometry.range_km);
        // A prediction adds 5 log10 R, data subtract it.
        let sun_mag = if self.correct_sun_distance { 5.0 * placed.geometry.sun_distance_au.log10() } else { 0.0 };
        StandardMagnitude(standard.0 - sun_mag)
    }
}
