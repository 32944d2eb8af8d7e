//! Exposure: start, length and pointing.

use hifitime::Epoch;

use super::error::{SkyError, check_epoch};
use crate::frames::{Direction, Gcrs, parse_direction, parse_instant, seconds_between};
use crate::orbit::MAX_WINDOW_S;

/// Exposure: the shutter opens at `start` and closes `duration_s` later, while the telescope tracks one direction
/// relative to the stars.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// Name in the schedule.
    pub id: String,
    /// Shutter opening.
    pub start: Epoch,
    /// Length, seconds, at least 0.
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
    /// [`SkyError`] for a text of another form or out of range. A negative length is rejected when the exposure is
    /// used.
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

    /// Rejects numbers that are not finite, negative lengths, and times outside the years of the Sun's ephemeris.
    pub(super) fn check(&self) -> Result<(), SkyError> {
        let id = &self.id;
        if !(self.duration_s >= 0.0 && self.duration_s.is_finite()) {
            let given = format!("{} s", self.duration_s);
            return Err(SkyError::invalid(format!("exposure {id}: duration"), given, "0 or more"));
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

/// Returns exposures in order of time, in groups covered by one window; an exposure longer than a window is a group
/// alone.
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
