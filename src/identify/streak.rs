//! Measured streak: a line on the sky, and the time of the exposure.

use hifitime::Epoch;
use nalgebra::Vector3;

use super::error;
use crate::error::Error;
use crate::frames::{Direction, Gcrs};

/// Relation between the time interval and the ends of a streak.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Timing {
    /// The satellite is at the first end at the start of the interval and at the second end at its end, so the
    /// direction of motion is known.
    FirstToSecond,
    /// The ends are the positions at shutter opening and closing, in unknown order.
    Whole,
    /// The satellite passes the streak at an unknown time during the exposure. The streak may end at the edges of the
    /// frame.
    Within,
}

impl Timing {
    /// Returns the name in outputs.
    pub fn name(self) -> &'static str {
        match self {
            Timing::FirstToSecond => "first end to second",
            Timing::Whole => "whole streak",
            Timing::Within => "within the exposure",
        }
    }
}

/// Measured streak with its errors. Positions are astrometric, ICRS.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredStreak {
    middle: Direction<Gcrs>,
    position_angle_rad: f64,
    length_rad: Option<f64>,
    start: Epoch,
    duration_s: f64,
    timing: Timing,
    position_sigma_rad: f64,
    time_sigma_s: f64,
    angle_sigma_rad: f64,
    by_ends: bool,
}

/// Smallest length of a streak, radians (0.01 arcsec).
const LEAST_LENGTH_RAD: f64 = 4.8e-8;
/// Largest length of a streak, radians. Longer tracks differ too much from great circles.
const LONGEST_RAD: f64 = 2.0;
/// Smallest error of the position angle, radians. It allows for curvature of the track and distortion of the optics.
const LEAST_ANGLE_SIGMA_RAD: f64 = 1e-5;

impl MeasuredStreak {
    /// Creates a streak from two ends. `position_sigma_rad` is the error (one sigma) of each end in any direction,
    /// radians; `time_sigma_s` is that of the clock, seconds.
    ///
    /// # Errors
    /// The ends are at the same position or more than 2 rad (114.6°) apart, an error is not positive, or the duration
    /// is not valid for the timing.
    pub fn from_ends(
        ends: [Direction<Gcrs>; 2],
        (start, duration_s): (Epoch, f64),
        timing: Timing,
        position_sigma_rad: f64,
        time_sigma_s: f64,
    ) -> Result<Self, Error> {
        let length_rad = ends[0].separation_rad(&ends[1]);
        if length_rad.is_nan() || length_rad < LEAST_LENGTH_RAD {
            return Err(error::no_line(length_rad.to_degrees() * 3600.0));
        }
        if length_rad > LONGEST_RAD {
            return Err(value("length of the streak", length_rad.to_degrees(), "deg", "at most 114 deg"));
        }
        let middle = Direction::from_vector((ends[0].vector() + ends[1].vector()).normalize());
        let streak = Self {
            middle,
            position_angle_rad: middle.position_angle_rad(&ends[1]),
            length_rad: Some(length_rad),
            start,
            duration_s,
            timing,
            position_sigma_rad,
            time_sigma_s,
            // Each of the two ends has an error σ perpendicular to the line.
            angle_sigma_rad: (std::f64::consts::SQRT_2 * position_sigma_rad / length_rad).max(LEAST_ANGLE_SIGMA_RAD),
            by_ends: true,
        };
        streak.checked()
    }

    /// Creates a streak from its middle, the position angle of the line there (from north through east, in either
    /// direction) with its error (one sigma), and its length if known. All angles are in radians.
    ///
    /// # Errors
    /// Same as [`MeasuredStreak::from_ends`]; also [`Timing::Whole`] without a length, and [`Timing::FirstToSecond`],
    /// because a position angle does not define the direction of motion.
    pub fn from_middle(
        middle: Direction<Gcrs>,
        (position_angle_rad, angle_sigma_rad): (f64, f64),
        length_rad: Option<f64>,
        (start, duration_s): (Epoch, f64),
        timing: Timing,
        position_sigma_rad: f64,
        time_sigma_s: f64,
    ) -> Result<Self, Error> {
        if !(position_angle_rad.is_finite() && position_angle_rad.abs() <= std::f64::consts::TAU) {
            return Err(value("position angle", position_angle_rad.to_degrees(), "deg", "-360 to 360 deg"));
        }
        if let Some(length_rad) = length_rad
            && !(LEAST_LENGTH_RAD..=LONGEST_RAD).contains(&length_rad)
        {
            return Err(value("length of the streak", length_rad.to_degrees(), "deg", "above 0, at most 114 deg"));
        }
        if timing == Timing::FirstToSecond {
            return Err(Error::invalid(
                "timing",
                timing.name(),
                "a streak given by two ends, because a position angle does not define which end was first",
            ));
        }
        if timing == Timing::Whole && length_rad.is_none() {
            return Err(Error::invalid("timing", timing.name(), "a streak of known length"));
        }
        let angle_sigma_rad = angle_sigma_rad.max(LEAST_ANGLE_SIGMA_RAD);
        let streak = Self {
            middle,
            position_angle_rad: position_angle_rad.rem_euclid(std::f64::consts::TAU),
            length_rad,
            start,
            duration_s,
            timing,
            position_sigma_rad,
            time_sigma_s,
            angle_sigma_rad,
            by_ends: false,
        };
        streak.checked()
    }

    fn checked(self) -> Result<Self, Error> {
        let may_be_instant = self.timing == Timing::Within;
        if !self.duration_s.is_finite() || self.duration_s < 0.0 || (self.duration_s == 0.0 && !may_be_instant) {
            let allowed =
                if may_be_instant { "0 s or more" } else { "above 0 s: both ends cannot be reached at the same time" };
            return Err(value("length of the exposure", self.duration_s, "s", allowed));
        }
        for (what, sigma, unit, allowed) in [
            ("error of the position", self.position_sigma_rad.to_degrees() * 3600.0, "arcsec", "above 0 arcsec"),
            ("error of the time", self.time_sigma_s, "s", "above 0 s"),
            ("error of the angle", self.angle_sigma_rad.to_degrees(), "deg", "above 0 deg"),
        ] {
            if !(sigma > 0.0 && sigma.is_finite()) {
                return Err(value(what, sigma, unit, allowed));
            }
        }
        Ok(self)
    }

    /// Returns the middle of the streak.
    pub fn middle(&self) -> Direction<Gcrs> {
        self.middle
    }

    /// Returns the position angle at the middle, towards the second end, from north through east, [0, 2π), radians.
    pub fn position_angle_rad(&self) -> f64 {
        self.position_angle_rad
    }

    /// Returns the length, radians; `None` if it is unknown.
    pub fn length_rad(&self) -> Option<f64> {
        self.length_rad
    }

    /// Returns both ends; `None` if the length is unknown.
    pub fn ends(&self) -> Option<[Direction<Gcrs>; 2]> {
        let half_rad = 0.5 * self.length_rad?;
        let (east, north) = self.middle.east_north();
        let along: Vector3<f64> = east * self.position_angle_rad.sin() + north * self.position_angle_rad.cos();
        Some([-half_rad, half_rad].map(|offset_rad: f64| {
            Direction::from_vector((self.middle.vector() * offset_rad.cos() + along * offset_rad.sin()).normalize())
        }))
    }

    /// Returns true if both ends were measured, and false if the middle and the position angle were measured.
    pub fn is_by_ends(&self) -> bool {
        self.by_ends
    }

    /// Returns the start of the interval.
    pub fn start(&self) -> Epoch {
        self.start
    }

    /// Returns the duration, seconds.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Returns the relation between the time interval and the ends.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Returns the error (one sigma) of each end in any direction, radians.
    pub fn position_sigma_rad(&self) -> f64 {
        self.position_sigma_rad
    }

    /// Returns the error (one sigma) of the clock, seconds.
    pub fn time_sigma_s(&self) -> f64 {
        self.time_sigma_s
    }

    /// Returns the error (one sigma) of the position angle, radians.
    pub fn angle_sigma_rad(&self) -> f64 {
        self.angle_sigma_rad
    }
}

fn value(what: &'static str, given: f64, unit: &str, allowed: &'static str) -> Error {
    Error::invalid(what, format!("{given} {unit}"), allowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ra_deg: f64, dec_deg: f64) -> Direction<Gcrs> {
        Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians())
    }

    fn time() -> (Epoch, f64) {
        (Epoch::from_gregorian_utc_at_midnight(2024, 8, 14), 30.0)
    }

    #[test]
    fn verif_ends_come_back() {
        let ends = [at(188.0, -30.0), at(190.0, -29.0)];
        let streak = MeasuredStreak::from_ends(ends, time(), Timing::Within, 1e-5, 0.5).unwrap();
        let back = streak.ends().unwrap();
        assert!(back[0].separation_rad(&ends[0]) < 1e-12 && back[1].separation_rad(&ends[1]) < 1e-12);
        let same = MeasuredStreak::from_middle(
            streak.middle(),
            (streak.position_angle_rad(), 0.01),
            streak.length_rad(),
            time(),
            Timing::Whole,
            1e-5,
            0.5,
        );
        assert!(same.unwrap().ends().unwrap()[1].separation_rad(&ends[1]) < 1e-12);
    }

    #[test]
    fn invalid_streaks_are_rejected_with_a_reason() {
        let ends = |a, b, time, timing| MeasuredStreak::from_ends([a, b], time, timing, 1e-5, 0.5);
        let message = |result: Result<MeasuredStreak, Error>| result.unwrap_err().to_string();
        assert!(message(ends(at(1.0, 2.0), at(1.0, 2.0), time(), Timing::Within)).contains("same position"));
        assert!(message(ends(at(1.0, 2.0), at(150.0, 2.0), time(), Timing::Within)).contains("at most 114 deg"));
        let instant = (time().0, 0.0);
        assert!(message(ends(at(1.0, 2.0), at(2.0, 2.0), instant, Timing::FirstToSecond)).contains("above 0 s"));
        assert!(ends(at(1.0, 2.0), at(2.0, 2.0), instant, Timing::Within).is_ok());
        let middle =
            |length, timing| MeasuredStreak::from_middle(at(1.0, 2.0), (0.3, 0.01), length, time(), timing, 1e-5, 0.5);
        assert!(message(middle(None, Timing::Whole)).contains("known length"));
        assert!(message(middle(Some(0.1), Timing::FirstToSecond)).contains("two ends"));
        let sigma = MeasuredStreak::from_ends([at(1.0, 2.0), at(2.0, 2.0)], time(), Timing::Within, 1e-5, 0.0);
        assert!(message(sigma).contains("error of the time is 0 s"));
    }
}
