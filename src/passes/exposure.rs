//! Exposure: start, length and pointing.

use hifitime::Epoch;

use super::error::{SkyError, check_epoch};
use crate::constants::DAY_S;
use crate::frames::{Direction, Gcrs, parse_direction, parse_instant, seconds_between};
use crate::orbit::MAX_WINDOW_S;

/// Longest exposure of a query, seconds. Clear start times are searched in one exposure over the whole time of a request,
/// which may have 31 days.
const LONGEST_S: f64 = 32.0 * DAY_S;

/// Exposure: the shutter opens at `start` and closes `duration_s` later, while the telescope tracks one direction
/// relative to the stars.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// Name in the schedule.
    pub id: String,
    /// Shutter opening.
    pub start: Epoch,
    /// Length, seconds, from 0 to 32 days.
    pub duration_s: f64,
    /// Centre of the field, ICRS astrometric.
    pub pointing: Direction<Gcrs>,
    /// Position angle of the field's y axis, from north through east, radians.
    pub rotation_rad: f64,
}

impl Exposure {
    /// Parses an exposure: the start as ISO 8601 with `Z` or an offset, right ascension (`14h53m36s`, `14:53:36` or
    /// degrees) and declination (`-08d54m`, `-08:54:00` or degrees) as ICRS astrometric. The rotation is 0, the
    /// identifier empty.
    ///
    /// # Errors
    /// [`SkyError`] for a text of another form or out of range. A length out of range is rejected when the exposure
    /// is used.
    pub fn new(start: &str, duration_s: f64, ra: &str, dec: &str) -> Result<Self, SkyError> {
        let pointing = parse_direction(ra, dec).map_err(SkyError::Direction)?;
        Ok(Self {
            id: String::new(),
            start: parse_instant(start, None).map_err(SkyError::Start)?,
            duration_s,
            pointing,
            rotation_rad: 0.0,
        })
    }

    /// Rejects numbers that are not finite, lengths below 0 or above 32 days, and times outside the years of the Sun's ephemeris.
    pub(super) fn check(&self) -> Result<(), SkyError> {
        let id = &self.id;
        if !(0.0..=LONGEST_S).contains(&self.duration_s) {
            let given = format!("{} s", self.duration_s);
            return Err(SkyError::invalid(format!("exposure {id}: duration"), given, format!("0 to {LONGEST_S} s")));
        }
        if !(self.pointing.vector().norm() - 1.0).abs().lt(&1e-6) {
            return Err(SkyError::invalid(format!("exposure {id}: pointing"), "not a direction", "finite numbers"));
        }
        if !self.rotation_rad.is_finite() {
            return Err(SkyError::invalid(format!("exposure {id}: rotation"), self.rotation_rad, "finite numbers"));
        }
        check_epoch(self.start)
    }

    /// Shutter closing, seconds after `start`.
    pub(super) fn end_s(&self, start: Epoch) -> f64 {
        seconds_between(start, self.start) + self.duration_s
    }
}

/// Returns the indices of the exposures in order of time, in groups that fit into one search window. An exposure longer
/// than a window is a group of its own.
pub(super) fn groups(exposures: &[Exposure]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..exposures.len()).collect();
    order.sort_by_key(|&one| exposures[one].start);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for one in order {
        match groups.last_mut() {
            Some(group) if exposures[one].end_s(exposures[group[0]].start) <= MAX_WINDOW_S => group.push(one),
            _ => groups.push(vec![one]),
        }
    }
    groups
}
