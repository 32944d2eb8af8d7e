//! Exposure: start, length and pointing.

use hifitime::Epoch;

use super::error::check_epoch;
use crate::constants::DAY_S;
use crate::error::{Error, ErrorKind};
use crate::frames::{Direction, Gcrs, parse_direction, parse_instant, seconds_between};
use crate::orbit::MAX_WINDOW_S;

/// Longest exposure of a query, seconds. It exceeds 31 days because the search for clear start times treats the whole
/// time of a request, which may last 31 days, as one exposure.
const LONGEST_S: f64 = 32.0 * DAY_S;

/// Exposure: the shutter opens at `start` and closes `duration_s` later, while the telescope tracks one direction
/// relative to the stars.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// Identifier of the exposure in the schedule.
    pub id: String,
    /// Time at which the shutter opens.
    pub start: Epoch,
    /// Exposure time, seconds, from 0 to 32 days.
    pub duration_s: f64,
    /// Centre of the field, ICRS astrometric direction.
    pub pointing: Direction<Gcrs>,
    /// Position angle of the field's y axis, from north through east, radians.
    pub rotation_rad: f64,
}

impl Exposure {
    /// Creates an exposure from texts. The start is ISO 8601 with `Z` or an offset. Right ascension (`14h53m36s`,
    /// `14:53:36` or degrees) and declination (`-08d54m`, `-08:54:00` or degrees) are ICRS astrometric. The rotation is
    /// 0 and the identifier is empty.
    ///
    /// # Errors
    /// A text has another form or a value is out of range. An exposure time out of range is rejected
    /// only when the exposure is used.
    pub fn new(start: &str, duration_s: f64, ra: &str, dec: &str) -> Result<Self, Error> {
        let pointing = parse_direction(ra, dec)?;
        Ok(Self {
            id: String::new(),
            start: parse_instant(start, None)
                .map_err(|problem| Error::new(ErrorKind::Invalid, format!("start: {problem}")))?,
            duration_s,
            pointing,
            rotation_rad: 0.0,
        })
    }

    /// Rejects numbers that are not finite, exposure times below 0 or above 32 days, and times outside the years of the
    /// ephemeris of Sun and Earth.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let id = &self.id;
        if !(0.0..=LONGEST_S).contains(&self.duration_s) {
            let given = format!("{} s", self.duration_s);
            return Err(
                Error::invalid("duration", given, format!("0 to {LONGEST_S} s")).at(format_args!("exposure {id}"))
            );
        }
        if !(self.pointing.vector().norm() - 1.0).abs().lt(&1e-6) {
            return Err(
                Error::invalid("pointing", "not a direction", "finite numbers").at(format_args!("exposure {id}"))
            );
        }
        if !self.rotation_rad.is_finite() {
            return Err(
                Error::invalid("rotation", self.rotation_rad, "finite numbers").at(format_args!("exposure {id}"))
            );
        }
        check_epoch(self.start)
    }

    /// Returns the time at which the shutter closes, seconds after `start`.
    pub(super) fn end_s(&self, start: Epoch) -> f64 {
        seconds_between(start, self.start) + self.duration_s
    }
}

/// Returns the indices of the exposures in order of time, in groups that fit into one search window. An exposure that
/// is longer than a window forms a group of its own.
pub(super) fn groups(exposures: &[Exposure]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..exposures.len()).collect();
    order.sort_by_key(|&index| exposures[index].start);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for index in order {
        match groups.last_mut() {
            Some(group) if exposures[index].end_s(exposures[group[0]].start) <= MAX_WINDOW_S => group.push(index),
            _ => groups.push(vec![index]),
        }
    }
    groups
}
